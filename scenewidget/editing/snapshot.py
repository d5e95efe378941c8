"""A session at one moment, as a view wants it: tables over atoms, no label per face."""

from __future__ import annotations

from dataclasses import dataclass

from scenewidget.editing.partition import Partition
from scenewidget.engine.atoms import Atoms
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.segmentation import Segmentation

__all__ = ["Snapshot"]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A session at one moment, as tables over atoms: all that a view needs, small at any number of faces.

    Attributes
    ----------
    revision : int
    automatic : Segmentation
        What the edits start from; its levels are the parts to point at.
    atoms : Atoms
    parts : dict of level to (n_atoms,) int
    labels : (n_atoms,) int32
        As in `Session.segmentation`, -1 unlabeled.
    ids : (n_segments,) int
        What stays of each segment over edits, while labels are numbered by area after each.
    names : tuple of str
        By label, "" where a segment has none.
    groups : tuple of int
        As `Segmentation.groups`.
    confidence : (n_segments,) float64
        Mean over the area; 1 where a person decided.
    atom_confidence : (n_atoms,) float64

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> state = sw.Session(mesh, seg).snapshot()
    >>> state.labels[state.atoms.face_atom]
    array([0, 0, 0, 0, 1, 1, 1, 1], dtype=int32)
    """

    revision: int
    automatic: Segmentation
    atoms: Atoms
    parts: dict[str, IntArray]
    labels: IntArray
    ids: IntArray
    names: tuple[str, ...]
    groups: tuple[int, ...]
    confidence: FloatArray
    atom_confidence: FloatArray

    @classmethod
    def of(cls, partition: Partition, revision: int) -> Snapshot:
        """What a partition holds now, under the number of the session's last change."""
        numbering = partition.numbering()
        return cls(
            revision,
            partition.automatic,
            partition.atoms,
            partition.parts,
            numbering.labels,
            numbering.ids,
            numbering.names,
            numbering.groups,
            numbering.confidence,
            numbering.atom_confidence,
        )
