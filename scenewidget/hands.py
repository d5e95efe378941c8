"""Several hands on one scan: how far people agree, and what they agree on.

Go in: the segmentations that people made, by name. Come out: a table with a row a pair of them, or one
segmentation by area-weighted evidence accumulation (Fred and Jain 2005, IEEE TPAMI 27(6)) over those pairs of
faces that somebody labels both. A face without a label says nothing for or against anything.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenewidget.engine.atoms import common_refinement
from scenewidget.engine.consensus import co_association
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation, order_by_area
from scenewidget.evaluation import By, checked_labels, checked_metrics, evaluate, face_weights
from scenewidget.metrics import Unlabeled

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["agreement", "consensus"]

LARGEST = 10_000  # parts held apart by somebody; their matrices then take 3 GB
ONE_SIDED = ("mean_iou",)  # metrics that change when the two sides change places

Annotations = Mapping[str, Segmentation | IntArray]


def agreement(
    annotations: Annotations,
    mesh: Mesh | None = None,
    *,
    by: By = "faces",
    unlabeled: Unlabeled = "drop",
    metrics: Collection[str] | None = None,
    per: Literal["pair", "segment", "name"] = "pair",
) -> pd.DataFrame:
    """How far each two of several annotations of a scan agree.

    `Compare` shows where two of them differ: ``sw.Compare(mesh, seg1, seg2)``, in the colours "errors".

    Parameters
    ----------
    annotations : mapping of name to Segmentation or (n_faces,) int
        Two or more.
    mesh : Mesh, optional
        The mesh that all of them label; may be left out when one of them is a `Segmentation`.
    by : "faces" | "area"
        As of `evaluate`.
    unlabeled : "drop" | "one" | "singletons"
        As of `evaluate`: by default what either of the two leaves unlabeled doesn't count for them.
    metrics : collection of str, optional
        Columns to compute; all of them by default.
    per : "pair" | "segment" | "name"
        What has a row: each pair of annotations; each segment of either of a pair; each name of a pair.

    Returns
    -------
    table : pandas.DataFrame
        Index ("first", "second"), a row a pair, in the order of the mapping. The metrics of `evaluate`; where
        one of them takes a side for the truth (``mean_iou``), the mean of both ways. Then ``coverage``, the
        share of what either labels that both do; ``same_name``, the share of what both have named that they
        call the same; ``n_first`` and ``n_second``, their segments. nan where there is nothing to compare.

        With ``per="segment"`` the index is ("first", "second", "segment"), the segment one of the first's,
        and every pair stands in both orders, the least agreed on come first: ``name``; ``size``, in faces
        or m²; ``match``, the segment of the second that overlaps most by intersection over union, the lower
        one at a tie, -1 for none; ``match_name``; ``iou``; ``outside``, the share of it that the second has
        not in ``match``. With ``per="name"`` it is ("first", "second", "name"), of all that either has
        named: ``size_first``, ``size_second`` and ``iou``. What either leaves unlabeled doesn't count.

    Raises
    ------
    TypeError
        Something that is no segmentation, or not a mapping.
    ValueError
        Labels of another mesh, an unknown metric or ``per``, fewer than two annotations.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> first, second = np.array([0, 0, 0, 0, 1, 1, 1, 1]), np.array([0, 0, 0, 0, 0, 0, 1, -1])
    >>> table = sw.agreement({"first": first, "second": second}, square(2))
    >>> table.loc[("first", "second"), ["rand_index_error", "coverage"]].round(2).tolist()
    [0.48, 0.88]
    """
    import pandas as pd

    mesh, labels = _checked(annotations, mesh)
    columns = checked_metrics(metrics)
    weights = face_weights(mesh, by)
    if len(labels) < 2:
        raise ValueError(
            f"annotations holds only {next(iter(labels))!r}; agreement takes two or more, "
            "such as {'first': seg1, 'second': seg2}"
        )
    if per == "segment":
        return _by_segment(annotations, labels, weights)
    if per == "name":
        return _by_name(annotations, labels, weights)
    if per != "pair":
        raise ValueError(f"per must be 'pair', 'segment' or 'name', got {per!r}")
    rows = {}
    for first, second in itertools.combinations(labels, 2):
        a, b = labels[first], labels[second]
        row = dict.fromkeys(columns, np.nan)
        if _area((a >= 0) & (b >= 0), weights) > 0:
            options: dict[str, Any] = {"by": by, "unlabeled": unlabeled}
            row |= evaluate({"": a}, b, mesh, metrics=columns, **options).loc["", columns].to_dict()
            if one_sided := [name for name in columns if name in ONE_SIDED]:
                back = evaluate({"": b}, a, mesh, metrics=one_sided, **options).loc[""]
                row |= {name: (row[name] + back[name]) / 2 for name in one_sided}
        either = _area((a >= 0) | (b >= 0), weights)
        row["coverage"] = _area((a >= 0) & (b >= 0), weights) / either if either > 0 else np.nan
        row["same_name"] = _same_name(_named(annotations[first]), _named(annotations[second]), a, b, weights)
        row["n_first"], row["n_second"] = (len(np.unique(x[x >= 0])) for x in (a, b))
        rows[first, second] = row
    index = pd.MultiIndex.from_tuples(rows, names=["first", "second"])
    return pd.DataFrame(list(rows.values()), index=index)


def _by_segment(
    annotations: Annotations, labels: Mapping[str, IntArray], weights: FloatArray | None
) -> pd.DataFrame:
    import pandas as pd

    rows, index = [], []
    for first, second in itertools.permutations(labels, 2):
        (a_ids, a), (b_ids, b) = (_dense(labels[person]) for person in (first, second))
        keep = (a >= 0) & (b >= 0)
        of_first, of_second = (_named(annotations[person]) for person in (first, second))
        sizes = np.zeros((len(a_ids), len(b_ids)))
        np.add.at(sizes, (a[keep], b[keep]), 1.0 if weights is None else weights[keep])
        own, other = sizes.sum(axis=1), sizes.sum(axis=0)
        union = own[:, None] + other - sizes
        iou = np.divide(sizes, union, out=np.zeros_like(sizes), where=union > 0)
        is_labeled = a >= 0
        size = np.bincount(a[is_labeled], None if weights is None else weights[is_labeled]).astype(float)
        for k, segment in enumerate(a_ids.tolist()):
            best = int(iou[k].argmax()) if own[k] > 0 else -1
            match = int(b_ids[best]) if best >= 0 else -1
            index.append((first, second, segment))
            rows.append(
                {
                    "name": _name_of(of_first, segment),
                    "size": float(size[k]),
                    "match": match,
                    "match_name": _name_of(of_second, match),
                    "iou": iou[k, best] if best >= 0 else np.nan,
                    "outside": 1 - sizes[k, best] / own[k] if best >= 0 else np.nan,
                }
            )
    columns = ["name", "size", "match", "match_name", "iou", "outside"]
    keys = pd.MultiIndex.from_tuples(index or [("", "", 0)], names=["first", "second", "segment"])
    table = pd.DataFrame(rows, index=keys[: len(index)], columns=columns)
    return table.sort_values(["iou", "size"], ascending=[True, False], kind="stable")


def _by_name(
    annotations: Annotations, labels: Mapping[str, IntArray], weights: FloatArray | None
) -> pd.DataFrame:
    import pandas as pd

    rows, index = [], []
    for first, second in itertools.combinations(labels, 2):
        keep = (labels[first] >= 0) & (labels[second] >= 0)
        named = [_named(annotations[person]) for person in (first, second)]
        for name in sorted({name for names in named for name in names if name}):
            masks = [
                keep & np.isin(labels[person], [k for k, own in enumerate(names) if own == name])
                for person, names in zip((first, second), named, strict=True)
            ]
            either = _area(masks[0] | masks[1], weights)
            index.append((first, second, name))
            rows.append(
                {
                    "size_first": _area(masks[0], weights),
                    "size_second": _area(masks[1], weights),
                    "iou": _area(masks[0] & masks[1], weights) / either if either > 0 else np.nan,
                }
            )
    columns = ["size_first", "size_second", "iou"]
    keys = pd.MultiIndex.from_tuples(index, names=["first", "second", "name"]) if index else None
    return pd.DataFrame(rows, index=keys, columns=columns).sort_values("iou", kind="stable")


def _dense(labels: IntArray) -> tuple[IntArray, IntArray]:
    """Segments in ascending order, and which of them each face is in; -1 for none."""
    ids, dense = np.unique(labels, return_inverse=True)
    n_none = int((ids < 0).sum())
    return ids[n_none:], np.maximum(dense.astype(np.int64) - n_none, -1)


def _name_of(names: list[str], segment: int) -> str:
    return names[segment] if 0 <= segment < len(names) else ""


def consensus(annotations: Annotations, mesh: Mesh | None = None) -> Segmentation:
    """What several people agree on: one segmentation out of their annotations of a scan.

    Parts that nobody cuts are joined while, over their area, at least half of those who labeled both held
    them together. Who leaves a face unlabeled says nothing about it; what nobody labels stays unlabeled.

    Parameters
    ----------
    annotations : mapping of name to Segmentation or (n_faces,) int
        One or more; their order doesn't matter.
    mesh : Mesh, optional
        The mesh that all of them label; may be left out when one of them is a `Segmentation`.

    Returns
    -------
    Segmentation
        ``confidence`` of a face is the agreement there: the mean, over all who label it, of the overlap of
        their segment with this one (intersection over union by area, where they label anything); 1 where
        all drew this very segment. ``names`` are voted: who names the segment that covers most of it has a
        vote; at a tie the name over more area wins, then the first by alphabet. ``levels["base"]`` are the
        parts that somebody holds apart, so that a split in the editor offers what was in dispute.
        ``report["annotators"]`` are the people. `Compare` shows where they disagree:
        ``sw.Compare(mesh, agreed, seg1)``, in the colours "confidence".

    Raises
    ------
    TypeError
        Something that is no segmentation, or not a mapping.
    ValueError
        Labels of another mesh, no annotation, or ones that cut the scan into more than 10 000 parts.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> ann, bob = np.array([0, 0, 0, 0, 1, 1, 1, 1]), np.array([0, 0, 0, 1, 1, 1, 1, 1])
    >>> cyd = np.array([5, 5, 5, 5, -1, -1, -1, -1])  # has seen one half
    >>> agreed = sw.consensus({"ann": ann, "bob": bob, "cyd": cyd}, square(2))
    >>> agreed.labels.tolist(), [f"{share:.2f}" for share in agreed.confidence[2:5]]
    ([0, 0, 0, 0, 1, 1, 1, 1], ['0.92', '0.71', '0.90'])
    """
    mesh, labels = _checked(annotations, mesh)
    dense = [order_by_area(column, mesh.face_areas)[0].astype(np.int64) for column in labels.values()]
    atoms = common_refinement(dense, mesh.n_faces)
    face_part = np.empty(atoms.n, dtype=np.int64)
    order = np.argsort(atoms.first_face)  # a numbering that does not tell who came first
    face_part[order] = np.arange(atoms.n)
    face_part = face_part[atoms.face_atom]
    keys = np.stack([column[atoms.first_face[order]] for column in dense], axis=1)
    areas = np.bincount(face_part, mesh.face_areas, atoms.n).astype(np.float64)
    known = np.flatnonzero((keys >= 0).any(axis=1))
    part_label: IntArray = np.full(atoms.n, -1, dtype=np.int64)
    if len(known) > LARGEST:
        raise ValueError(
            f"annotations cut the scan into {len(known)} parts, more than {LARGEST}: "
            "are these labels that people drew?"
        )
    if len(known):
        part_label[known] = _joined(keys[known], areas[known])
    part_label, _ = order_by_area(part_label, areas)
    share = _overlaps(keys, part_label, areas)
    is_seen = keys >= 0
    overlap = np.where(is_seen, share, 0.0)
    agreed = np.sort(overlap, axis=1).sum(axis=1) / np.maximum(is_seen.sum(axis=1), 1)
    base = np.full(atoms.n, -1, dtype=np.int64)
    base[known] = np.arange(len(known))
    found = Segmentation.from_labels(
        mesh,
        part_label[face_part],
        names=_voted(annotations, labels, part_label[face_part], mesh.face_areas),
        confidence=np.minimum(agreed, 1.0)[face_part],
    )
    report = {"annotators": sorted(map(str, labels))}
    return dataclasses.replace(found, levels={"base": base[face_part].astype(np.int32)}, report=report)


def _joined(keys: IntArray, areas: FloatArray) -> IntArray:
    """(n_parts,) int32 label of each part; ``keys`` is what each person calls it."""
    co = co_association(keys, areas)
    is_seen = (keys >= 0).astype(np.float64)
    weights = areas if areas.max() > 0 else np.ones(len(areas))
    return cut_tree(average_linkage(co.C, weights, is_seen @ is_seen.T), similarity=0.5)


def _overlaps(keys: IntArray, label: IntArray, areas: FloatArray) -> FloatArray:
    """(n_parts, n_people): overlap of each one's segment with the label's, over what that one has labeled."""
    out = np.zeros(keys.shape)
    for k, key in enumerate(keys.T):
        keep = (key >= 0) & (label >= 0)
        if not keep.any():
            continue
        n = int(label.max()) + 1
        pair, inverse = np.unique(key[keep] * n + label[keep], return_inverse=True)
        common = np.bincount(inverse, areas[keep])
        own, ours = np.bincount(key[keep], areas[keep]), np.bincount(label[keep], areas[keep], n)
        union = own[pair // n] + ours[pair % n] - common
        alone = (np.bincount(pair // n)[pair // n] == 1) & (np.bincount(pair % n)[pair % n] == 1)
        iou = np.divide(common, union, out=alone.astype(np.float64), where=union > 0)
        out[keep, k] = np.where(alone, 1.0, iou)[inverse]
    return out


def _voted(
    annotations: Annotations, labels: Mapping[str, IntArray], agreed: IntArray, areas: FloatArray
) -> list[str]:
    """Name of each agreed segment."""
    n = int(agreed.max()) + 1
    votes: list[dict[str, list[float]]] = [{} for _ in range(n)]  # of a segment: name -> areas behind it
    for person, theirs in labels.items():
        names = getattr(annotations[person], "names", ())
        if not any(names):
            continue
        keep = (theirs >= 0) & (agreed >= 0)
        pair, inverse = np.unique(agreed[keep] * len(names) + theirs[keep], return_inverse=True)
        common = np.bincount(inverse, areas[keep])
        best = pair[np.lexsort((-common, pair // len(names)))]
        area = dict(zip(pair.tolist(), common.tolist()))
        for code in best[np.unique(best // len(names), return_index=True)[1]].tolist():
            segment, own = divmod(code, len(names))
            if names[own]:
                votes[segment].setdefault(names[own], []).append(area[code])
    return [min(box, key=lambda name: (-len(box[name]), -_sum(box[name]), name), default="") for box in votes]


def _sum(values: list[float]) -> float:
    """In an order that is the same whoever came first."""
    return sum(sorted(values))


def _named(annotation: Any) -> list[str]:
    return list(getattr(annotation, "names", ()))


def _same_name(
    first: list[str], second: list[str], a: IntArray, b: IntArray, weights: FloatArray | None
) -> float:
    """Share of what both have named that they call the same; nan if that is nothing."""
    if not any(first) or not any(second):
        return np.nan
    known = sorted({*first, *second, ""})
    code = {name: k for k, name in enumerate(known)}  # "" is the first
    one = np.array([*(code[name] for name in first), 0])[a]  # label −1 is the last entry
    two = np.array([*(code[name] for name in second), 0])[b]
    both = (one > 0) & (two > 0)
    named = _area(both, weights)
    return _area(both & (one == two), weights) / named if named > 0 else np.nan


def _area(mask: Any, weights: FloatArray | None) -> float:
    return float(mask.sum() if weights is None else weights[mask].sum())


def _checked(annotations: Any, mesh: Any) -> tuple[Mesh, dict[str, IntArray]]:
    """The mesh and everybody's labels on it; TypeError or ValueError if they can't be."""
    if mesh is None:
        values = list(annotations.values()) if isinstance(annotations, Mapping) else []
        mesh = next((value.mesh for value in values if isinstance(value, Segmentation)), None)
        if mesh is None and values:
            raise TypeError("mesh is needed when all annotations are arrays: give it after them")
    elif not isinstance(mesh, Mesh):
        raise TypeError(f"mesh must be a scenewidget.Mesh, got {type(mesh).__name__}")
    return mesh, checked_labels("annotations", annotations, mesh)
