"""One nested family of segmentations: granularity as a number that is answered at once.

Goes in: a finished segmentation, a finer one, and how often the ensemble put base segments together. Comes
out: a `Family`, a sequence of merges of fine pieces, so that a coarser segment is always a union of finer
ones. It runs through the given segmentation: pieces are joined within its segments first, then its segments.
Within them by average linkage: Fred and Jain (2005), IEEE TPAMI 27(6), here among neighbours. Among them by
what is missed least, so that a lamp goes to the ceiling before two walls become one.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from scenewidget.engine.checks import checked_whole
from scenewidget.engine.consensus import CoAssociation
from scenewidget.engine.doubt import Doubt, doubts
from scenewidget.engine.finish import connected_pieces
from scenewidget.engine.items import Items
from scenewidget.engine.linkage import cut_tree
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, connected_components
from scenewidget.engine.pieces import Pieces, make_pieces
from scenewidget.engine.segmentation import Segmentation, order_by_area

__all__ = ["Family", "fine_pieces", "make_family"]

FINE_SIMILARITY = 0.9  # What this share of the runs puts together is one piece of the finest cut.


@dataclass(frozen=True, eq=False)
class Family:
    """Nested segmentations of one mesh, from fine to coarse.

    Attributes
    ----------
    segmentation : Segmentation
        The one that the family was made for; ``cut(segmentation.n_segments)`` is this object.
    piece : (n_items,) int32
        Finest segment of each item, dense; −1 for items that no face of the mesh belongs to.
    merges : (most − least, 2) int32
        Pieces that stand for the two segments joined at each step, from fine to coarse. The first, of the
        larger area, stands for both from then on.
    similarity : (most − least,) float64
        Mean co-association of the two: the share of the runs that put them together.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import folded, square
    >>> family = sw.Pipeline(folded(square(6, size=2.0), "x", 1.0, 1.5)).family()
    >>> family.cut(2).n_segments
    2
    """

    segmentation: Segmentation
    piece: IntArray
    merges: IntArray
    similarity: FloatArray
    _base: IntArray  # (n_items,) base segment of each
    _face_areas: FloatArray  # (most,) of the faces of each piece
    _items: Items

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @cached_property
    def _pieces(self) -> Pieces:
        """Of the finest cut."""
        run, to_faces = self.segmentation, self._items.to_faces
        base = to_faces(self._base, -1)
        return make_pieces(run.mesh, to_faces(self.piece, -1), base, scale=self._items.scale)

    def __repr__(self) -> str:
        return f"Family({self.least} to {self.most} segments)"

    @property
    def most(self) -> int:
        """Segments of the finest cut."""
        return len(self._face_areas)

    @property
    def least(self) -> int:
        """Segments of the coarsest cut: one a scene, where a scan shows several that are far apart."""
        return self.most - len(self.merges)

    def groups(self, n_segments: int) -> IntArray:
        """(most,) int32 which piece stands for the segment of each piece, at so many segments.

        Raises
        ------
        TypeError
            Not a whole number.
        ValueError
            The family has no such cut.
        """
        n_segments = checked_whole("n_segments", n_segments)
        if not self.least <= n_segments <= self.most:
            raise ValueError(
                f"n_segments must lie in {self.least}..{self.most}, the range of this family, "
                f"got {n_segments}"
            )
        group = np.arange(self.most, dtype=np.int32)
        for kept, gone in self.merges[: self.most - n_segments][::-1]:  # the last first: one pass is enough
            group[gone] = group[kept]
        return group

    def item_labels(self, n_segments: int) -> IntArray:
        """(n_items,) int32 segment of each item in the nearest cut that there is, −1 for none: a preview.

        Parameters
        ----------
        n_segments : int
            Beyond the ends of the family it is taken for its end.
        """
        group = self.groups(min(max(n_segments, self.least), self.most))
        return np.append(order_by_area(group, self._face_areas)[0], np.int32(-1))[self.piece]

    def cut(self, n_segments: int) -> Segmentation:
        """The segmentation with exactly ``n_segments`` segments.

        Raises
        ------
        TypeError
            Not a whole number.
        ValueError
            Fewer than ``least`` or more than ``most``.
        """
        run, group = self.segmentation, self.groups(n_segments)
        if n_segments == run.n_segments:
            return run
        dense, _ = order_by_area(group, self._face_areas)
        item_labels = np.append(dense, np.int32(-1))[self.piece]
        labels = self._items.to_faces(item_labels, -1)
        labels.flags.writeable = False

        def find_doubt() -> Doubt:
            # pieces of the finest cut, each in its segment of this one
            pieces = dataclasses.replace(self._pieces, labels=labels, segment=dense[self._pieces.segment])
            return doubts(pieces, run.keys, run.report.get("runs"), n_segments=n_segments)

        return dataclasses.replace(
            run,
            labels=labels,
            confidence=None,  # type: ignore[arg-type]  # follows from the doubt
            doubt=find_doubt,
            names=(),
            groups=(),
            item_labels=item_labels,
            timings={},
        )


def fine_pieces(items: Items, co: CoAssociation, tree: FloatArray) -> IntArray:
    """(n_items,) int32 connected pieces that nine tenths of the runs put together.

    Parameters
    ----------
    items : Items
    co : CoAssociation
        Of the items.
    tree : (n_base − 1, 4) float64
        `average_linkage` of its base segments.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.consensus import co_association
    >>> from scenewidget.engine.family import fine_pieces
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.linkage import average_linkage
    >>> items = patch_items(square(2), np.array([0, 0, 1, 1, 2, 2, 2, 2]))
    >>> co = co_association(np.array([[0, 0], [0, 0], [1, 1]]), items.areas)
    >>> fine_pieces(items, co, average_linkage(co.C, co.weights)).tolist()
    [0, 0, 1]
    """
    return connected_pieces(cut_tree(tree, similarity=FINE_SIMILARITY)[co.base], items.pairs)


def make_family(
    segmentation: Segmentation,
    fine: IntArray,
    co: CoAssociation,
    *,
    min_area: float = 0.0,
) -> Family:
    """The nested family that runs through a segmentation.

    Parameters
    ----------
    segmentation : Segmentation
        Of items, as `segment` makes it.
    fine : (n_items,) int
        Finished labels of a finer cut. Pieces are what is one segment in it and in ``segmentation``.
    co : CoAssociation
        Of the items.
    min_area : float
        Smaller pieces (m² in a room, square units of a smaller scene) go to the piece of their segment that
        they agree with most, neighbours first.

    Returns
    -------
    Family
        Within the segments of ``segmentation`` the two pieces are joined at each step that touch and have the
        largest mean co-association c, and in the end those that don't touch. Then of the segments that touch
        the two for which A₁ A₂ (1 − c) is least, the pairs of places that are expected to be wrongly
        together, by which 1 − RI grows. Fragments touch what lies nearest.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import folded, square
    >>> from scenewidget.engine.family import make_family
    >>> pipe = sw.Pipeline(folded(square(6, size=2.0), "x", 1.0, 1.5))
    >>> items, co = pipe.get("items"), pipe.get("coassociation")
    >>> family = make_family(pipe.run(), np.arange(items.n), co)
    >>> family.most == items.n, family.cut(family.least).n_segments == family.least
    (True, True)
    """
    items, run, face_map = segmentation.items, segmentation.item_labels, segmentation.face_map
    if items is None or run is None or face_map is None:
        raise ValueError("segmentation has no items: it must come from segment() or Pipeline.run()")
    keep, mapped = run >= 0, face_map >= 0
    code = run.astype(np.int64) * (int(fine.max()) + 1) + fine
    piece = np.full(items.n, -1, dtype=np.int32)
    piece[keep] = np.unique(code[keep], return_inverse=True)[1]
    seen = np.bincount(face_map[mapped], segmentation.mesh.face_areas[mapped], items.n)
    n_faces = np.bincount(face_map[mapped], minlength=items.n)

    bonds = _bonds(items, co, piece)
    home = np.zeros(len(bonds.area), dtype=np.int64)
    home[piece[keep]] = run[keep]
    least = np.zeros(len(bonds.area))  # m²; a piece lies in one scene
    least[piece[keep]] = min_area * items.scales[items.island[keep]] ** 2
    is_crumb = bonds.area < least
    is_crumb |= np.bincount(piece[keep], n_faces[keep], len(home)) == 0
    for crumb in np.flatnonzero(is_crumb)[np.argsort(bonds.area[is_crumb], kind="stable")]:
        kin = (home == home[crumb]) & bonds.is_there
        kin[crumb] = False
        if (bonds.area[crumb] < least[crumb] or n_faces[piece == crumb].sum() == 0) and kin.any():
            into = int(np.argmax(np.where(kin, bonds.closeness(crumb), -np.inf)))
            bonds.merge(into, int(crumb))
            piece[piece == crumb] = into

    kept, dense = np.unique(piece[keep], return_inverse=True)
    piece[keep] = dense
    bonds, home = bonds.take(kept), home[kept]
    within = _agglomerate(bonds, lambda i, others: home[others] == home[i], bonds.closeness)
    standing = np.full(int(run.max(initial=-1)) + 1, -1)
    standing[home[bonds.is_there]] = np.flatnonzero(bonds.is_there)
    _bridge(items, np.append(standing, -1)[run], bonds)
    among = _agglomerate(bonds, lambda i, others: bonds.touches[i, others], bonds.worth)
    steps = [*within, *among]
    return Family(
        segmentation,
        piece,
        np.array([step[:2] for step in steps], dtype=np.int32).reshape(-1, 2),
        np.array([step[2] for step in steps], dtype=np.float64),
        co.base,
        np.bincount(piece[keep], seen[keep], len(kept)).astype(np.float64),
        items,
    )


@dataclass(frozen=True, eq=False)
class _Bonds:
    """What holds pieces together, while they are merged."""

    total: FloatArray  # (n, n) sum of co-association times both areas
    touches: BoolArray  # (n, n)
    area: FloatArray  # (n,)
    is_there: BoolArray  # (n,)

    def mean(self, i: int) -> FloatArray:
        """(n,) mean co-association of a piece with each."""
        return np.asarray(self.total[i] / np.maximum(self.area[i] * self.area, 1e-300))

    def closeness(self, i: int) -> FloatArray:
        """(n,) the same, neighbours before all others."""
        return np.asarray(self.mean(i) + 2.0 * self.touches[i])

    def worth(self, i: int) -> FloatArray:
        """(n,) less the pairs of places that are expected to be wrongly together if joined with each, m⁴."""
        return np.asarray(-self.area[i] * self.area * (1.0 - self.mean(i)))

    def merge(self, kept: int, gone: int) -> None:
        self.total[kept] += self.total[gone]
        self.total[:, kept] = self.total[kept]
        self.touches[kept] |= self.touches[gone]
        self.touches[:, kept] = self.touches[kept]
        self.area[kept] += self.area[gone]
        self.is_there[gone] = False

    def take(self, kept: IntArray) -> _Bonds:
        square = np.ix_(kept, kept)
        return _Bonds(self.total[square], self.touches[square], self.area[kept], self.is_there[kept])


def _bonds(items: Items, co: CoAssociation, piece: IntArray) -> _Bonds:
    n, keep = int(piece.max(initial=-1)) + 1, piece >= 0
    total = co.between(piece, items.areas, n)  # dense (n_pieces, n_pieces)
    one, other = items.touching(piece).labels.T
    touches = np.zeros((n, n), dtype=bool)
    touches[one, other] = touches[other, one] = True
    area = np.bincount(piece[keep], items.areas[keep], n).astype(np.float64)
    return _Bonds(total, touches, area, np.ones(n, dtype=bool))


def _bridge(items: Items, standing: IntArray, bonds: _Bonds) -> None:
    """Let fragments of a scene touch what lies nearest, until chains of touching pieces lead everywhere.

    ``standing`` is the piece that stands for each item, −1 for none.
    """
    position, radius = items.moments.centroid, np.sqrt(items.areas / np.pi)
    for island in range(len(items.scales)):
        inside = np.flatnonzero((items.island == island) & (standing >= 0))
        while True:
            _, component = connected_components(len(bonds.area), np.argwhere(bonds.touches))
            part = component[standing[inside]]
            parts = np.unique(part)
            if len(parts) < 2:
                break
            largest = parts[np.argmax([items.areas[inside[part == c]].sum() for c in parts])]
            for c in parts[parts != largest]:
                own, others = inside[part == c], inside[part != c]
                apart, nearest = cKDTree(position[others]).query(position[own])
                k = int(np.argmin(apart - radius[own] - radius[others[nearest]]))
                one, other = standing[own[k]], standing[others[nearest[k]]]
                bonds.touches[one, other] = bonds.touches[other, one] = True


def _agglomerate(
    bonds: _Bonds, may_join: Callable[[int, IntArray], BoolArray], value: Callable[[int], FloatArray]
) -> list[tuple[int, int, float]]:
    """Merge the pair of the highest value that may be joined until there is none; (kept, gone, similarity).

    Each row remembers its best partner, so a step costs a few rows, not the whole matrix.
    """
    n = len(bonds.area)
    everything = np.arange(n)
    partner, best = np.zeros(n, dtype=np.int64), np.full(n, -np.inf)

    def look(i: int) -> None:
        others = everything[bonds.is_there & (everything != i)]
        others = others[may_join(i, others)]
        values = value(i)[others]
        best[i] = values.max(initial=-np.inf)
        partner[i] = others[np.argmax(values)] if len(others) else -1

    for k in np.flatnonzero(bonds.is_there):
        look(int(k))
    steps = []
    while np.isfinite(best.max(initial=-np.inf)):
        i = int(np.argmax(best))
        j = int(partner[i])
        is_first = (bonds.area[i], j) > (bonds.area[j], i)
        kept, gone = (i, j) if is_first else (j, i)
        steps.append((kept, gone, float(bonds.mean(i)[j])))
        bonds.merge(kept, gone)
        best[gone] = -np.inf
        concerned = np.isin(partner, (kept, gone)) | bonds.touches[kept]
        concerned[kept] = True
        for k in np.flatnonzero(concerned & bonds.is_there):
            look(int(k))
    return steps
