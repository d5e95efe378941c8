"""Segmentations beside a truth, in one table.

Go in: segmentations by name, the truth, the mesh. Comes out: a pandas table with a row each and a column
for every metric, after section 4.3 of Küçükdemir (2020).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenewidget.engine.checks import checked_count
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation
from scenewidget.metrics import (
    Unlabeled,
    adjusted_rand_index,
    cut_discrepancy,
    global_consistency_error,
    hamming_distance,
    local_consistency_error,
    mean_iou,
    rand_index_error,
    variation_of_information,
)

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "METRICS",
    "By",
    "checked_labels",
    "checked_metrics",
    "checked_truth",
    "evaluate",
    "face_weights",
    "reliability",
]

By = Literal["faces", "area"]

METRICS: Mapping[str, Callable[..., float]] = {
    "rand_index_error": rand_index_error,
    "global_consistency_error": global_consistency_error,
    "local_consistency_error": local_consistency_error,
    "hamming_distance": hamming_distance,
    "cut_discrepancy": cut_discrepancy,
    "variation_of_information": variation_of_information,
    "adjusted_rand_index": adjusted_rand_index,
    "mean_iou": mean_iou,
}


def evaluate(
    segmentations: Mapping[str, Segmentation | IntArray],
    truth: Segmentation | IntArray,
    mesh: Mesh | None = None,
    *,
    by: By = "faces",
    unlabeled: Unlabeled = "drop",
    metrics: Collection[str] | None = None,
) -> pd.DataFrame:
    """Errors and scores of segmentations against a truth.

    Parameters
    ----------
    segmentations : mapping of name to Segmentation or (n_faces,) int
        One row each, in this order.
    truth : Segmentation or (n_faces,) int
    mesh : Mesh, optional
        The mesh that all of them label; may be left out when `truth` is a `Segmentation`.
    by : "faces" | "area"
        What the regional metrics and the coverage count: faces as the thesis does, which lets densely
        scanned regions weigh more, or square metres. Cut discrepancy always goes by length.
    unlabeled : "drop" | "one" | "singletons"
        See `scenewidget.metrics`. Whatever is chosen, the coverage says how much was left unlabeled.
    metrics : collection of str, optional
        Columns to compute; all of them by default. `cut_discrepancy` is the one that takes seconds on a
        million faces.

    Returns
    -------
    table : pandas.DataFrame
        Index "segmentation". First the errors, lower is better: ``rand_index_error``,
        ``global_consistency_error``, ``local_consistency_error``, ``hamming_distance``,
        ``cut_discrepancy``, ``variation_of_information`` (nats). Then the scores, higher is better:
        ``adjusted_rand_index``, ``mean_iou``. Then ``coverage``, the share of what the truth labels that
        the segmentation labels too; ``n_segments``, and ``n_truth``, the segments of the truth.
        A segmentation that labels nothing the truth labels has nan for every metric and coverage 0.

    Raises
    ------
    TypeError
        Something that is no segmentation, or not a mapping.
    ValueError
        Labels of another mesh, an unknown metric, an empty mapping.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> ours, truth = np.array([0, 0, 0, 0, 1, 1, 1, 1]), np.array([0, 0, 0, 0, 0, 0, 1, 1])
    >>> scores = sw.evaluate({"ours": ours}, truth, square(2), metrics=["rand_index_error"])
    >>> round(scores.loc["ours", "rand_index_error"].item(), 2)
    0.43
    """
    import pandas as pd

    mesh, actual = checked_truth(truth, mesh)
    columns = checked_metrics(metrics)
    weights = face_weights(mesh, by)
    rows = {
        name: _row(labels, actual, mesh, weights, unlabeled, columns)
        for name, labels in checked_labels("segmentations", segmentations, mesh).items()
    }
    table = pd.DataFrame.from_dict(rows, orient="index", columns=[*columns, "coverage", "n_segments"])
    table["n_truth"] = _count(actual)
    return table.rename_axis("segmentation")


def reliability(
    segmentation: Segmentation, truth: Segmentation | IntArray, *, n_bins: int = 10
) -> pd.DataFrame:
    """How far the confidence can be trusted, in bins.

    Parameters
    ----------
    segmentation : Segmentation
    truth : Segmentation or (n_faces,) int
    n_bins : int
        Of equal width, 0 to 1.

    Returns
    -------
    table : pandas.DataFrame
        A row a bin that holds faces, index "bin". ``confidence``, the mean; ``right``, the share of faces
        whose segment is mostly of their thing, and whose thing is mostly in their segment; ``share`` of the
        faces. Faces that either leaves unlabeled don't count.
        The expected calibration error is ``(t.share * (t.confidence - t.right).abs()).sum()``.

    References
    ----------
    Naeini, Cooper and Hauskrecht (2015), AAAI.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.evaluation import reliability
    >>> mesh, truth = square(2), np.arange(8) // 4
    >>> ours = sw.Segmentation.from_labels(mesh, truth, confidence=np.linspace(0.1, 0.9, 8))
    >>> len(reliability(ours, truth, n_bins=4))
    4
    """
    import pandas as pd

    if not isinstance(segmentation, Segmentation):
        raise TypeError(f"segmentation must be a Segmentation, got {type(segmentation).__name__}")
    n_bins = checked_count("n_bins", n_bins)
    _, actual = checked_truth(truth, segmentation.mesh)
    keep = (segmentation.labels >= 0) & (actual >= 0)
    label = segmentation.labels[keep]
    thing = actual[keep]
    table = np.zeros((segmentation.n_segments, int(thing.max()) + 1))
    np.add.at(table, (label, thing), 1)
    right = (table.argmax(axis=1)[label] == thing) & (table.argmax(axis=0)[thing] == label)
    confidence = segmentation.confidence[keep].astype(np.float64)
    place = np.clip((confidence * n_bins).astype(int), 0, n_bins - 1)
    faces = np.bincount(place, minlength=n_bins)
    rows = np.flatnonzero(faces)
    sums = [np.bincount(place, values, n_bins)[rows] for values in (confidence, right)]
    return pd.DataFrame(
        {
            "confidence": sums[0] / faces[rows],
            "right": sums[1] / faces[rows],
            "share": faces[rows] / max(1, len(confidence)),
        },
        index=pd.Index(rows, name="bin"),
    )


def _row(
    labels: IntArray,
    truth: IntArray,
    mesh: Mesh,
    weights: FloatArray | None,
    unlabeled: Unlabeled,
    columns: Collection[str],
) -> list[float]:
    coverage = _share((labels >= 0) & (truth >= 0), weights) / _share(truth >= 0, weights)
    values = []
    for name in columns:
        if coverage == 0 and unlabeled == "drop":
            values.append(np.nan)
        elif name == "cut_discrepancy":
            values.append(cut_discrepancy(labels, truth, mesh, unlabeled))
        else:
            values.append(METRICS[name](labels, truth, weights, unlabeled))
    return [*values, coverage, _count(labels)]


def _share(mask: BoolArray, weights: FloatArray | None) -> float:
    return float(np.average(mask, weights=weights))


def _count(labels: IntArray) -> int:
    return len(np.unique(labels[labels >= 0]))


# --- checks ---------------------------------------------------------------------------------------


def checked_truth(truth: Any, mesh: Mesh | None) -> tuple[Mesh, IntArray]:
    """The mesh and its true labels per face; TypeError or ValueError if they can't be.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.evaluation import checked_truth
    >>> mesh, labels = checked_truth(np.array([0, 1]), square(1))
    >>> labels.tolist()
    [0, 1]
    """
    if mesh is None:
        if not isinstance(truth, Segmentation):
            raise TypeError("mesh is needed when truth is an array: evaluate(segmentations, truth, mesh)")
        mesh = truth.mesh
    if not isinstance(mesh, Mesh):
        raise TypeError(f"mesh must be a scenewidget.Mesh, got {type(mesh).__name__}")
    labels = _face_labels("truth", truth, mesh)
    if not (labels >= 0).any():
        raise ValueError("truth labels no face at all, so there is nothing to compare with")
    if mesh.face_areas[labels >= 0].sum() == 0:
        raise ValueError("truth labels only faces without area, so there is nothing to compare with")
    return mesh, labels


def checked_labels(name: str, segmentations: Any, mesh: Mesh) -> dict[str, IntArray]:
    """Labels per face by name; TypeError or ValueError, which say ``name``, if they can't be.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.evaluation import checked_labels
    >>> checked_labels("annotations", {}, square(1))
    Traceback (most recent call last):
        ...
    ValueError: annotations is empty: give at least one, such as {'ours': seg}
    """
    if not isinstance(segmentations, Mapping):
        raise TypeError(
            f"{name} must map names to segmentations, such as {{'ours': seg}}, "
            f"got {type(segmentations).__name__}"
        )
    if not segmentations:
        raise ValueError(f"{name} is empty: give at least one, such as {{'ours': seg}}")
    return {key: _face_labels(f"{name}[{key!r}]", s, mesh) for key, s in segmentations.items()}


def _face_labels(name: str, value: Any, mesh: Mesh) -> IntArray:
    if isinstance(value, Segmentation):
        is_same = value.mesh is mesh or np.array_equal(value.mesh.faces, mesh.faces)
        if not is_same:
            raise ValueError(
                f"{name} belongs to another mesh, of {value.mesh.n_faces} faces where this one has "
                f"{mesh.n_faces}, or in another order; all must label the same mesh"
            )
        return value.labels
    labels = np.asarray(value)
    if labels.dtype.kind not in "iu":
        raise TypeError(
            f"{name} must be a Segmentation or whole-number labels, got {type(value).__name__} "
            f"of dtype {labels.dtype}"
        )
    if labels.shape != (mesh.n_faces,):
        raise ValueError(
            f"{name} must have one label a face of the mesh: ({mesh.n_faces},), got {labels.shape}"
        )
    return labels.astype(np.int64)


def checked_metrics(names: Collection[str] | None) -> list[str]:
    """Names of metrics, all by default; TypeError or ValueError for what is none.

    Examples
    --------
    >>> from scenewidget.evaluation import checked_metrics
    >>> checked_metrics(["mean_iou"])
    ['mean_iou']
    """
    if names is None:
        return list(METRICS)
    if isinstance(names, str):
        raise TypeError(f"metrics must be a collection of names, such as [{names!r}], got a single str")
    unknown = [name for name in names if name not in METRICS]
    if unknown:
        raise ValueError(f"metrics has {unknown[0]!r}; it may hold {', '.join(METRICS)}")
    return list(names)


def face_weights(mesh: Mesh, by: By) -> FloatArray | None:
    """What a face counts: its area, or None where all count alike; ValueError for another ``by``.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.evaluation import face_weights
    >>> face_weights(square(1), "area").tolist()
    [0.5, 0.5]
    """
    if by not in ("faces", "area"):
        raise ValueError(f"by must be 'faces' or 'area', got {by!r}")
    return mesh.face_areas if by == "area" else None
