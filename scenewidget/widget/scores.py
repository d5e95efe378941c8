"""Segments beside a truth, while they are edited: a few measures and the faces that are wrong.

Goes in: a truth per face, and segments as tables over atoms. Faces of one atom and one true segment are
counted once a mesh, so that an edit costs a look at a few thousand numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.atoms import Atoms
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation
from scenewidget.evaluation import checked_truth
from scenewidget.metrics import match_segments, quick_scores

__all__ = ["RIGHT", "UNKNOWN", "WRONG", "Scorer", "disagreement", "score_rows"]

UNKNOWN, RIGHT, WRONG = 0, 1, 2
WORDS = {
    "rand_index_error": (
        "1 − RI",
        "Share of the pairs of faces that one side joins and the other parts.",
        ".4f",
    ),
    "global_consistency_error": (
        "GCE",
        "Global consistency error: 0 where one side refines the other.",
        ".4f",
    ),
    "local_consistency_error": ("LCE", "Local consistency error: the kinder direction for each face.", ".4f"),
    "mean_iou": (
        "Mean IoU",
        "Mean overlap of the true segments with their partners: higher is better.",
        ".4f",
    ),
    "coverage": ("Coverage", "Share of the truly labeled faces that have a label.", ".1%"),
}
HIGHER_IS_BETTER = ("mean_iou", "coverage")


@dataclass(frozen=True, eq=False)
class _Cells:
    """Faces counted by atom and true label."""

    atom: IntArray
    truth: IntArray
    count: IntArray
    of_face: IntArray  # (n_faces,) index of the cell


class Scorer:
    """Compares with one truth.

    Parameters
    ----------
    mesh : Mesh
    truth : Segmentation or (n_faces,) int
        Negative where it isn't known.

    Raises
    ------
    TypeError, ValueError
        It is no truth for this mesh; the message says why.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from scenewidget.engine.atoms import common_refinement
    >>> scorer, atoms = Scorer(mesh, seg), common_refinement([seg.labels], mesh.n_faces)
    >>> scorer.scores(atoms, seg.labels[atoms.first_face])["rand_index_error"]
    0.0
    """

    def __init__(self, mesh: Mesh, truth: Segmentation | IntArray) -> None:
        _, labels = checked_truth(truth, mesh)
        self.truth: IntArray = np.where(labels >= 0, labels, -1).astype(np.int64)
        self._atoms: Atoms | None = None
        self._cells: _Cells | None = None

    def scores(self, atoms: Atoms, segments: IntArray) -> dict[str, float]:
        """`quick_scores` of segments given per atom."""
        cells = self._counted(atoms)
        return quick_scores(segments[cells.atom], cells.truth, cells.count)

    def errors(self, atoms: Atoms, segments: IntArray) -> npt.NDArray[np.uint8]:
        """(n_faces,) RIGHT, WRONG, or UNKNOWN where the truth is; unlabeled is wrong.

        A face is right if its true segment is the partner of its segment in the matching with the largest
        sum of intersection over union.
        """
        cells = self._counted(atoms)
        label = segments[cells.atom]
        partner = match_segments(label, cells.truth, cells.count)
        is_right = (label >= 0) & (np.append(partner, -2)[label] == cells.truth)
        verdict = np.where(cells.truth < 0, UNKNOWN, np.where(is_right, RIGHT, WRONG)).astype(np.uint8)
        return verdict[cells.of_face]

    def _counted(self, atoms: Atoms) -> _Cells:
        if atoms is not self._atoms or self._cells is None:
            n = int(self.truth.max(initial=-1)) + 2
            code = atoms.face_atom.astype(np.int64) * n + (self.truth + 1)
            values, of_face, count = np.unique(code, return_inverse=True, return_counts=True)
            self._atoms = atoms
            self._cells = _Cells(values // n, values % n - 1, count, of_face.astype(np.int32))
        return self._cells


def disagreement(a: IntArray, b: IntArray) -> npt.NDArray[np.uint8]:
    """(n_faces,) RIGHT where the segments of both sides are partners, WRONG elsewhere.

    UNKNOWN where neither side has a label; where one has, it is WRONG.

    Examples
    --------
    >>> import numpy as np
    >>> disagreement(np.array([0, 0, 1, -1]), np.array([3, 3, 3, -1]))
    array([1, 1, 2, 0], dtype=uint8)
    """
    n = int(b.max(initial=-1)) + 2
    values, of_face, count = np.unique(
        (a.astype(np.int64) + 1) * n + b + 1, return_inverse=True, return_counts=True
    )
    left, right = values // n - 1, values % n - 1
    partner = match_segments(left, right, count)
    is_same = (left >= 0) & (np.append(partner, -2)[left] == right)
    is_open = (left < 0) & (right < 0)
    verdict = np.where(is_open, UNKNOWN, np.where(is_same, RIGHT, WRONG)).astype(np.uint8)
    return verdict[of_face]


def score_rows(scores: Mapping[str, float], before: Mapping[str, float]) -> Sequence[dict[str, Any]]:
    """What a person reads: name, number, a sentence, and whether it became better or worse.

    Examples
    --------
    >>> now = dict.fromkeys(WORDS, 0.8)
    >>> rows = score_rows(now, {"mean_iou": 0.7})
    >>> rows[3]["text"], rows[3]["trend"]
    ('0.8000', 'better')
    """
    rows = []
    for key, (name, tip, form) in WORDS.items():
        text, old = f"{scores[key]:{form}}", before.get(key)
        trend = ""
        if old is not None and f"{old:{form}}" != text:
            trend = "better" if (scores[key] > old) == (key in HIGHER_IS_BETTER) else "worse"
        rows.append({"name": name, "text": text, "tip": tip, "trend": trend})
    return rows
