"""The answer: a label, a confidence and three levels of parts for every face of the mesh as loaded.

Goes in: labels per item and the map from raw faces to items. Comes out: a read-only `Segmentation`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenewidget.engine.boxes import oriented_boxes
from scenewidget.engine.checks import warn_caller
from scenewidget.engine.doubt import Doubt, doubts
from scenewidget.engine.gravity import up_direction
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.moments import group_moments, mean_normals, moment_origin
from scenewidget.engine.naming import name_segments
from scenewidget.engine.pieces import make_pieces

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "Level",
    "Segmentation",
    "confidence_of",
    "dense_groups",
    "order_by_area",
    "segmentation_of_items",
]

Level = Literal["dihedral", "base", "final"]
LEVELS: tuple[Level, ...] = ("dihedral", "base", "final")
SCALES = "metres in a unit of the scene"  # entry of the report: of each island, the largest first


@dataclass(frozen=True, eq=False)
class Segmentation:
    """A partition of a mesh into segments, with what is known about how it came about.

    Parameters
    ----------
    mesh : Mesh
        The mesh as loaded; every array per face is about its faces.
    labels : (n_faces,) int32
        Segment of each face, 0 the largest by area, -1 unlabeled. Any integers are accepted and
        renumbered by `from_labels`; the constructor wants them dense already.
    confidence : (n_faces,) float32, optional
        Probability that the face is right: that its segment is mostly of its thing, and its thing mostly in
        its segment (`engine.doubt`). By default it is found on first use (half a second at a million faces)
        where ``keys`` are known; otherwise it is 1, and 0 where unlabeled.
    levels : mapping of level to (n_faces,) int32
        Part ids of the recommendation levels "dihedral" and "base" (thesis 3.6); -1 unlabeled.
    names : sequence of str
        Name of each segment; "" where it has none.
    keys : (n_base, n_runs) int32, optional
        Cluster of each part of the level "base" in each run of the ensemble, -1 where the run did not see it.
    items : Items, optional
        What was clustered.
    item_labels : (n_items,) int32, optional
        Segment of each item.
    face_map : (n_faces,) int32, optional
        Item of each face, -1 where the face was dropped.
    simplified : Mesh, optional
        The simplified mesh, if its faces were the items.
    timings : mapping of stage to seconds
    report : mapping of str to anything
        What the user should know: faces dropped and why, items reached, orientation, warnings. "runs" says
        how many columns of the keys are of which kind.
    doubt : Doubt or callable () → Doubt, optional
        What may be wrong, if it has been found already, or what finds it on first use; kept only as long as
        it is of these ``labels``.
    groups : sequence of int, optional
        For each segment the one that it is a part of, itself where of none: a cushion says its sofa. The
        whole is a segment too, and gives the group its name; a part has no parts of its own.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> segmentation = sw.Segmentation.from_labels(square(1), [7, -1], names=[""] * 7 + ["floor"])
    >>> segmentation
    Segmentation(2 faces, 1 segments, 50.0% labeled)
    >>> segmentation.to_frame()[["name", "faces", "area"]].to_dict("records")
    [{'name': 'floor', 'faces': 1, 'area': 0.5}]
    """

    mesh: Mesh
    labels: IntArray
    confidence: FloatArray = field(default_factory=lambda: None)  # type: ignore[arg-type,return-value]  # see below
    levels: Mapping[str, IntArray] = field(default_factory=dict)
    names: Sequence[str] = ()
    keys: IntArray | None = None
    items: Items | None = None
    item_labels: IntArray | None = None
    face_map: IntArray | None = None
    simplified: Mesh | None = None
    timings: Mapping[str, float] = field(default_factory=dict)
    report: Mapping[str, Any] = field(default_factory=dict)
    doubt: Doubt | Callable[[], Doubt] | None = field(default=None, repr=False)
    groups: Sequence[int] = ()

    def __post_init__(self) -> None:
        n = self.mesh.n_faces
        labels = _face_array("labels", self.labels, n, np.int32)
        lowest, highest = int(labels.min()), int(labels.max())
        present = np.zeros(max(highest, -1) + 1, dtype=bool)
        present[labels[labels >= 0]] = True
        if lowest < -1 or not present.all():
            raise ValueError(
                "labels must be -1 or 0, 1, 2, … without gaps; "
                "Segmentation.from_labels(mesh, labels) renumbers"
            )
        levels = {}
        for name, parts in self.levels.items():
            if name not in LEVELS:
                options = ", ".join(map(repr, LEVELS))
                raise ValueError(f"levels has a key {name!r}; it must be one of {options}")
            levels[name] = _face_array(f"levels[{name!r}]", parts, n, np.int32)
        names = tuple(self.names) or ("",) * (highest + 1)
        if len(names) != highest + 1:
            raise ValueError(f"names must have one entry a segment: {highest + 1}, got {len(names)}")
        keys = None if self.keys is None else _checked_keys(self.keys, levels.get("base"))
        confidence = vars(self).pop("confidence", None)
        if confidence is None and keys is None:
            confidence = np.where(labels >= 0, 1.0, 0.0)
        if confidence is not None:  # otherwise `__getattr__` finds it when it is asked for
            vars(self)["confidence"] = _face_array("confidence", confidence, n, np.float32)
        for key, value in (
            ("labels", labels),
            ("levels", MappingProxyType(levels)),
            ("names", names),
            ("groups", _checked_groups(self.groups, highest + 1)),
            ("keys", keys),
            ("timings", MappingProxyType(dict(self.timings))),
            ("report", MappingProxyType(dict(self.report))),
        ):
            object.__setattr__(self, key, value)
        if isinstance(self.doubt, Doubt) and self.doubt.pieces.labels is not labels:  # replaced since
            object.__setattr__(self, "doubt", None)

    def __getattr__(self, name: str) -> Any:
        if name != "confidence" or "keys" not in vars(self):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        confidence = confidence_of(self.find_doubt())
        confidence.flags.writeable = False
        object.__setattr__(self, "confidence", confidence)
        return confidence

    def __getstate__(self) -> dict[str, Any]:
        """For `pickle` and `copy.deepcopy`; what may be wrong is found again when it is asked for."""
        plain = {"levels": dict(self.levels), "timings": dict(self.timings), "report": dict(self.report)}
        if callable(self.doubt):
            plain["confidence"] = self.confidence  # which is not found again in the same way
        return {**vars(self), **plain, "doubt": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)
        self.__post_init__()

    def with_timings(self, timings: Mapping[str, float]) -> Segmentation:
        """The same with other ``timings``; what was found on first use stays found.

        Parameters
        ----------
        timings : mapping of stage to seconds
        """
        out = object.__new__(type(self))
        vars(out).update(vars(self), timings=MappingProxyType(dict(timings)))
        return out

    @classmethod
    def from_labels(
        cls,
        mesh: Mesh,
        labels: IntArray | Sequence[int],
        *,
        names: Sequence[str] = (),
        confidence: FloatArray | None = None,
        groups: Sequence[int] = (),
    ) -> Segmentation:
        """A segmentation from any integer labels, renumbered so that 0 is the largest by area.

        Parameters
        ----------
        mesh : Mesh
        labels : (n_faces,) int
            Any numbering; negative means unlabeled.
        names : sequence of str, optional
            Name of each label as passed in: ``names[labels[f]]`` is the name of face f's segment.
        confidence : (n_faces,) float, optional
        groups : sequence of int, optional
            Label that each label as passed in is a part of, itself where of none. Where that one has no
            faces, the largest of its parts stands for the whole.

        Raises
        ------
        ValueError
            A wrong length, or a label that ``names`` or ``groups`` does not reach.

        Examples
        --------
        >>> import scenewidget as sw
        >>> from scenewidget.datasets.analytic import square
        >>> sw.Segmentation.from_labels(square(1), [5, 3], groups=[0, 1, 2, 5, 4, 5]).groups
        (0, 0)
        """
        given = _face_array("labels", np.asarray(labels), mesh.n_faces, np.int64)
        highest = int(given.max(initial=-1))
        if names and highest >= len(names):
            raise ValueError(f"labels go up to {highest}, but names has only {len(names)} entries")
        dense, kept = order_by_area(given, mesh.face_areas)
        kept_names = tuple(str(names[label]) for label in kept) if names else ()
        optional: Any = {} if confidence is None else {"confidence": confidence}
        if len(groups):
            if highest >= len(groups):
                raise ValueError(f"labels go up to {highest}, but groups has only {len(groups)} entries")
            optional["groups"] = dense_groups(kept, np.asarray(groups)[kept])
        return cls(mesh, dense, names=kept_names, **optional)

    def __repr__(self) -> str:
        shape = f"{self.mesh.n_faces} {self.mesh.noun}s, {self.n_segments} segments"
        return f"Segmentation({shape}, {self.coverage:.1%} labeled)"

    @property
    def n_segments(self) -> int:
        """Number of segments, unlabeled faces not counted."""
        return len(self.names)

    @property
    def coverage(self) -> float:
        """Share of the faces that carry a label."""
        return float(np.mean(self.labels >= 0))

    def things(self) -> Segmentation:
        """The same with every group one segment, called like its whole: what to judge against whole things.

        Returns
        -------
        Segmentation
            Without levels and keys; the segmentation itself where nothing is grouped.

        Examples
        --------
        >>> import scenewidget as sw
        >>> from scenewidget.datasets.analytic import square
        >>> names = ["sofa", "cushion"]
        >>> found = sw.Segmentation.from_labels(square(1), [0, 1], names=names, groups=[0, 0])
        >>> found.things().names
        ('sofa',)
        """
        if all(whole == segment for segment, whole in enumerate(self.groups)):
            return self
        labels = np.append(np.array(self.groups, np.int64), -1)[self.labels]
        return self.from_labels(self.mesh, labels, names=self.names, confidence=self.confidence)

    def level(self, level: Level) -> IntArray:
        """(n_faces,) int32 part ids of a recommendation level, -1 unlabeled (thesis 3.6).

        Raises
        ------
        ValueError
            A level that does not exist, or that this segmentation was made without.
        """
        if level == "final":
            return self.labels
        if level not in LEVELS:
            raise ValueError(f"level must be one of {', '.join(map(repr, LEVELS))}, got {level!r}")
        if level not in self.levels:
            raise ValueError(
                f"this segmentation has no level {level!r}: it was not made by segment(); use level='final'"
            )
        return self.levels[level]

    def borders(self) -> pd.DataFrame:
        """A row a pair of segments that touch: how likely they are one thing, the likeliest first.

        Returns
        -------
        borders : pandas.DataFrame
            ``first``, ``second``: the segments, the larger one first; ``length`` of their border in metres;
            ``p_same``, the probability that they are one thing; ``agreement``, the share of the runs that put
            the two together, NaN where no ensemble is known; ``offset``, how far the smaller lies from the
            plane of the larger (root mean square, metres); ``convex``, the share of the border where the
            surface bulges.

        Notes
        -----
        Fragments of a scan that come as near to each other as a few centimetres touch. Where no ensemble is
        known, as for imported labels, only the shape speaks.

        Examples
        --------
        >>> import scenewidget as sw
        >>> mesh, truth = sw.datasets.load_room()
        >>> truth.borders().columns.tolist()[:4]
        ['first', 'second', 'length', 'p_same']
        """
        import pandas as pd

        doubt = self.find_doubt()
        b = doubt.borders
        known = 1.0 if self.keys is not None else np.nan
        table = {
            "first": b.first,
            "second": b.second,
            "length": b.length,
            "p_same": doubt.same,
            "agreement": known * 0.5 * (b.by_graph + b.by_medoids),
            "offset": b.offset,
            "convex": b.convex,
        }
        return pd.DataFrame(table).sort_values("p_same", ascending=False, kind="stable", ignore_index=True)

    def cuts(self) -> pd.DataFrame:
        """A row a segment: its likeliest cut in two, and how likely it is two things.

        Returns
        -------
        cuts : pandas.DataFrame
            ``segment``; ``p_two``, the probability that the two sides are two things; ``faces``, an array of
            those of the smaller side. 0 and no faces where the runs offer no cut, or no ensemble is known.

        Examples
        --------
        >>> import scenewidget as sw
        >>> mesh, truth = sw.datasets.load_room()
        >>> truth.cuts().columns.tolist()
        ['segment', 'p_two', 'faces']
        """
        import pandas as pd

        doubt = self.find_doubt()
        order = np.argsort(doubt.pieces.face_piece, kind="stable")
        ends = np.searchsorted(doubt.pieces.face_piece[order], np.arange(doubt.pieces.n + 1))
        faces = [
            np.sort(np.concatenate([order[:0], *(order[ends[p] : ends[p + 1]] for p in doubt.side(s))]))
            for s in range(self.n_segments)
        ]
        return pd.DataFrame({"segment": np.arange(self.n_segments), "p_two": doubt.two, "faces": faces})

    def suggest_names(
        self, *, up: tuple[float, float, float] | FloatArray | None = None
    ) -> dict[int, tuple[str, float]]:
        """Names where geometry tells: floor, ceiling, wall, table, hanging lamp; others are left out.

        They are offers, nothing is named by them: ``session.relabel(face, name)`` does that, or
        ``session.accept_names()``. The words are those of NYU40; `Session` has them in other ones.

        Parameters
        ----------
        up : (3,) float, optional
            Against gravity. By default what the surface tells, see `engine.gravity.up_direction`; z where it
            doesn't.

        Returns
        -------
        names : dict of int to (str, float)
            Segment to name and the probability that it is right. None for scans that show no room.

        Raises
        ------
        ValueError
            A direction that is none.

        Examples
        --------
        >>> import scenewidget as sw
        >>> mesh, truth = sw.datasets.load_room()
        >>> sorted({name for name, _ in truth.suggest_names().values()})
        ['ceiling', 'floor', 'wall']
        """
        if up is None:
            found = up_direction(self.mesh)
            up = (0.0, 0.0, 1.0) if found is None else found
        direction = np.asarray(up, dtype=np.float64)
        length = float(np.linalg.norm(direction)) if direction.shape == (3,) else 0.0
        if not (np.isfinite(length) and length > 0):
            raise ValueError(f"up must be three numbers, not all zero, got {up!r:.200}; write up=(0, 0, 1)")
        return name_segments(self.find_doubt().pieces, direction / length)

    def find_doubt(self) -> Doubt:
        """What may be wrong; found on first use where it wasn't given (half a second at a million faces)."""
        found = self.doubt() if callable(self.doubt) else self.doubt
        if found is None or found.pieces.labels is not self.labels:
            base = np.minimum(self.labels, 0) if self.keys is None else self.levels["base"]
            scale = self.report.get(SCALES, [None])[0] if self.items is None else self.items.scale
            pieces = make_pieces(self.mesh, self.labels, base, scale=scale)
            found = doubts(pieces, self.keys, self.report.get("runs"), n_segments=self.n_segments)
        object.__setattr__(self, "doubt", found)
        return found

    def boxes(self, up: FloatArray | None = None) -> pd.DataFrame:
        """The smallest upright box around each segment: center (m), size (m), axes.

        Parameters
        ----------
        up : (3,) float, optional
            Against gravity; z by default.

        Returns
        -------
        boxes : DataFrame
            A row a segment, of tuples: ``size`` is the longer and the shorter side of the plan and the
            height, the three ``axes`` are unit vectors along them; see `boxes.oriented_boxes`.
        """
        import pandas as pd

        found = oriented_boxes(self.mesh, self.labels, self.n_segments, up)
        return pd.DataFrame(
            {
                "name": list(self.names),
                "center": [tuple(row) for row in found.center.tolist()],
                "size": [tuple(row) for row in found.size.tolist()],
                "axes": [tuple(map(tuple, rows)) for rows in found.axes.tolist()],
            },
            index=pd.RangeIndex(self.n_segments, name="segment"),
        )

    def to_frame(self) -> pd.DataFrame:
        """A row a segment: name, group, faces, area (m²), centroid (m), normal, flatness, size, confidence.

        The group is the segment that it is a part of, itself where of none: ``groupby("group")`` has a row a
        thing.
        The centroid and the area-weighted mean normal are tuples of three; flatness is λ2/λ0 of the
        scatter matrix, 0 for a plane; size is that of the smallest upright box, z up: the longer and the
        shorter side of its plan and its height, see `boxes`; confidence is the mean over the area.
        """
        import pandas as pd

        n, labels, mesh = self.n_segments, self.labels, self.mesh
        moments = group_moments(mesh, labels, n)
        keep = labels >= 0
        inside = labels[keep]
        normal = mean_normals(mesh.face_vectors, labels, n)
        centroid = moments.centroid + moment_origin(mesh)
        weighted = np.bincount(inside, (mesh.face_areas * self.confidence)[keep], n)
        confidence = np.divide(weighted, moments.area, out=np.zeros(n), where=moments.area > 0)
        return pd.DataFrame(
            {
                "name": list(self.names),
                "group": list(self.groups),
                "faces": np.bincount(inside, minlength=n),
                "area": moments.area,
                "centroid": [tuple(row) for row in centroid.tolist()],
                "normal": [tuple(row) for row in normal.tolist()],
                "flatness": moments.flatness(),
                "size": [tuple(row) for row in oriented_boxes(mesh, labels, n).size.tolist()],
                "confidence": confidence,
            },
            index=pd.RangeIndex(n, name="segment"),
        )


def segmentation_of_items(
    mesh: Mesh,
    items: Items,
    labels: IntArray,
    *,
    dihedral: IntArray,
    base: IntArray,
    keys: IntArray,
    runs: Mapping[str, int],
) -> Segmentation:
    """What was found of the items, on the faces of the mesh as loaded.

    Parameters
    ----------
    mesh : Mesh
        As loaded.
    items : Items
        Of this mesh.
    labels : (n_items,) int
        Finished segments.
    dihedral : (items.mesh.n_faces,) int32
        The level "dihedral", on the mesh that the items are made of.
    base : (n_items,) int32
        The level "base".
    keys : (n_items, n_runs) int32
        Cluster of each item in each run.
    runs : mapping of str to int
        How many of these are of which kind, in their order: "k-medoids", "graph".

    Warns
    -----
    UserWarning
        Less than half of the faces have a label.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.segmentation import segmentation_of_items
    >>> mesh = square(2)
    >>> items = patch_items(mesh, np.arange(8) // 4)
    >>> found = {"dihedral": np.zeros(8, np.int32), "base": np.arange(2), "keys": np.array([[0], [1]])}
    >>> segmentation_of_items(mesh, items, np.arange(2), **found, runs={"graph": 1})
    Segmentation(8 faces, 2 segments, 100.0% labeled)
    """
    dense, kept = order_by_area(items.to_faces(labels, -1), mesh.face_areas)
    if (dense >= 0).mean() < 0.5:
        warn_caller(
            f"only {(dense >= 0).mean():.1%} of the faces are labeled: the mesh is in many pieces, and most "
            "were too small to keep (see report); weld it first, or use items='superfacets' with more "
            "n_items"
        )
    rank = np.full(int(labels.max()) + 1, -1, dtype=np.int32)
    rank[kept] = np.arange(len(kept), dtype=np.int32)
    is_raw = items.mesh is mesh
    face_base = items.to_faces(base, -1)
    keys = keys[np.unique(base, return_index=True)[1]]
    dense.flags.writeable = False
    return Segmentation(
        mesh,
        dense,
        levels={
            # a face of the simplified mesh is an item, but one of the raw mesh is only a part of one
            "dihedral": dihedral if is_raw else items.to_faces(dihedral, -1),
            "base": face_base,
        },
        keys=keys,
        items=items,
        item_labels=rank[labels],
        face_map=items.face_map,
        simplified=None if is_raw else items.mesh,
        report={**items.report, SCALES: [round(float(s), 4) for s in items.scales], "runs": dict(runs)},
    )


def confidence_of(doubt: Doubt) -> FloatArray:
    """(n_faces,) float32 probability that each face is right, 0 where unlabeled.

    Labeled faces of no base segment, of which the runs say nothing, get one half.

    Parameters
    ----------
    doubt : Doubt

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.segmentation import confidence_of
    >>> confidence_of(sw.segment(square(6, size=2.0)).find_doubt()).dtype
    dtype('float32')
    """
    right = np.append(1.0 - doubt.wrong, 0.5)[doubt.pieces.face_piece]
    return np.where(doubt.pieces.labels >= 0, right, 0.0).astype(np.float32)


def order_by_area(labels: IntArray, areas: FloatArray) -> tuple[IntArray, IntArray]:
    """Renumber labels densely, the largest area first; ties keep the order of first appearance.

    Parameters
    ----------
    labels : (n,) int
        Any numbering, negative for unlabeled.
    areas : (n,) float64

    Returns
    -------
    dense : (n,) int32
        -1, 0, 1, 2, …
    kept : (n_segments,) int64
        The old label behind each new one.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.segmentation import order_by_area
    >>> order_by_area(np.array([7, 7, 3, -1]), np.array([1.0, 1.0, 5.0, 1.0]))
    (array([ 1,  1,  0, -1], dtype=int32), array([3, 7]))
    """
    out = np.full(len(labels), -1, dtype=np.int32)
    keep = labels >= 0
    if not keep.any():
        return out, np.empty(0, dtype=np.int64)
    inside = labels[keep].astype(np.int64)
    if int(inside.max()) > 2 * len(inside):  # sparse numbers: make them dense before counting
        old, inverse = np.unique(inside, return_inverse=True)
    else:
        old, inverse = np.arange(int(inside.max()) + 1), inside
    first = np.full(len(old), len(inside))
    first[inverse[::-1]] = np.arange(len(inside))[::-1]  # the last written is the first in the array
    order = np.lexsort((first, -np.bincount(inverse, areas[keep])))
    order = order[first[order] < len(inside)]
    rank = np.full(len(old), -1, dtype=np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    out[keep] = rank[inverse]
    return out, old[order]


def dense_groups(kept: IntArray, wholes: IntArray) -> tuple[int, ...]:
    """Groups by the numbers of segments, from groups by other ids.

    Parameters
    ----------
    kept : (n_segments,) int
        Id of each segment, the largest first.
    wholes : (n_segments,) int
        Id that all parts of a thing share, of the segment that is the whole if there is one.

    Returns
    -------
    groups : tuple of int
        As `Segmentation.groups`. Where no segment has the shared id, the first of the parts is the whole.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.segmentation import dense_groups
    >>> dense_groups(np.array([7, 3, 4]), np.array([4, 3, 4]))
    (2, 1, 2)
    """
    place = {whole: k for k, whole in reversed(list(enumerate(wholes.tolist())))}
    place |= {i: k for k, (i, whole) in enumerate(zip(kept.tolist(), wholes.tolist())) if i == whole}
    return tuple(place[whole] for whole in wholes.tolist())


def _checked_groups(groups: Sequence[int], n: int) -> tuple[int, ...]:
    found = [int(whole) if hasattr(whole, "__index__") else -1 for whole in groups]
    if found == list(range(len(found))):  # which says nothing, of however many segments
        return tuple(range(n))
    if len(found) != n:
        raise ValueError(f"groups must have one entry a segment: {n}, got {len(found)}")
    for segment, whole in enumerate(found):
        if not 0 <= whole < n or found[whole] != whole:
            raise ValueError(
                f"groups says that segment {segment} is a part of {groups[segment]!r:.60}, which must be a "
                "segment, and no part itself"
            )
    return tuple(found)


def _checked_keys(keys: Any, base: IntArray | None) -> IntArray:
    array = np.asarray(keys)
    n_base = 0 if base is None else int(base.max()) + 1
    if base is None or array.ndim != 2 or len(array) < n_base:
        raise ValueError(
            f"keys must have a row for each of the {n_base} parts of levels['base'], got {array.shape}"
        )
    if array.dtype.kind not in "iu":
        raise TypeError(f"keys must be whole numbers, got dtype {array.dtype}")
    if array.dtype != np.int32 or array.flags.writeable:
        array = np.array(array, dtype=np.int32)
        array.flags.writeable = False
    return array


def _face_array(name: str, value: Any, n_faces: int, dtype: Any) -> Any:
    array = np.asarray(value)
    if array.dtype.kind not in "iufb":
        raise TypeError(f"{name} must be an array of numbers, got dtype {array.dtype}")
    if array.shape != (n_faces,):
        raise ValueError(f"{name} must have one entry a face of the mesh: ({n_faces},), got {array.shape}")
    if np.dtype(dtype).kind == "i" and array.dtype.kind == "f":
        raise TypeError(f"{name} must be whole numbers, got dtype {array.dtype}")
    if array.dtype != dtype or array.flags.writeable:
        array = np.array(array, dtype=dtype)
        array.flags.writeable = False
    return array
