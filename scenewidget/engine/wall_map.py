"""Maps of a wall: what stands how far out of its plane, or has which tint, on a grid of cells.

Goes in: the items of one wall, floor or ceiling. Come out: maps of the items on its plane, and for each pair
of items that meet there, by how much the heights or tints step across their seam. Not in the thesis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenewidget.engine.items import Items
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray
from scenewidget.engine.scale import principal_axes

__all__ = ["Seams", "WallMap", "nearest", "wall_maps"]

MARGIN = 5  # The map has so many empty cells round it, as heights are compared over five cells.
MOST_CELLS = 2_000  # A side of the map has at most this many cells.
REACH = 2  # A narrow item within so many cells of a broad one is the rim of a step.
RIM = 1  # An item is narrow that nowhere holds a square of 2 RIM + 1 cells.
# From a cell at a seam across it: it, the one beyond, both; the third to fifth on its side, and beyond.
PARTS = ((0, 1, 1), (1, 2, 1), (0, 2, 1), (-2, -5, -1), (3, 6, 1))
SHIFTS = ((0.0, 0.0), (0.5, 0.5), (0.0, 0.5), (0.5, 0.0))  # By so many cells the grids are shifted.


@dataclass(frozen=True, eq=False)
class Seams:
    """Pairs of regions that meet, and sums over the cells along their seam.

    Attributes
    ----------
    pairs : (n_pairs, 2) int64
        Each pair once, smaller first.
    step : (n_values, n_pairs) float64
        Sum of the second's value less the first's.
    ridge : (n_values, n_pairs) float64
        Sum of how much the seam itself stands out of the mean of both.
    length : (n_pairs,) float64
        Number of cells.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.wall_map import Seams
    >>> seams = Seams(np.array([[0, 1]]), np.array([[4.0]]), np.array([[2.0]]), np.array([5.0]))
    >>> seams.in_units_of(np.array([2.0])).step.tolist()
    [[2.0]]
    """

    pairs: IntArray
    step: FloatArray
    ridge: FloatArray
    length: FloatArray

    def of(self, which: slice) -> Seams:
        """The same of some of the values.

        Parameters
        ----------
        which : slice
        """
        return Seams(self.pairs, self.step[which], self.ridge[which], self.length)

    def in_units_of(self, steps: FloatArray) -> Seams:
        """The same with steps and ridges as multiples of what counts as a step.

        Parameters
        ----------
        steps : (n_values,) float64
        """
        return Seams(self.pairs, self.step / steps[:, None], self.ridge / steps[:, None], self.length)


@dataclass(frozen=True, eq=False)
class WallMap:
    """A wall on one grid.

    Attributes
    ----------
    item : (rows, columns) int32
        The item that has most of a cell, −1 for none.
    without_rims : (rows, columns) int32
        The same, with the narrow items at the rim of a step given to the broad one beside them.
    seams : Seams
        Between the items of ``without_rims``.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.wall_map import wall_maps
    >>> floor = square(20)
    >>> items = patch_items(floor, floor.face_centroids[:, 0] > 0.5)
    >>> grid = wall_maps(items, np.arange(2), None, 0.1)[0]
    >>> grid.seams.pairs.tolist(), grid.item.shape == grid.without_rims.shape
    ([[0, 1]], True)
    """

    item: IntArray
    without_rims: IntArray
    seams: Seams


def wall_maps(items: Items, members: IntArray, values: FloatArray | None, cell: float) -> list[WallMap]:
    """Maps of a wall on four grids that are shifted against each other.

    The first value is the height of the faces over the wall's best plane, either side up.

    Parameters
    ----------
    items : Items
    members : (n_members,) int
        Items of the wall.
    values : (n_values, items.mesh.n_faces) float64, optional
        What to map besides.
    cell : float
        Side of the cells, metres; more where faces are larger.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.wall_map import wall_maps
    >>> floor = square(20)
    >>> items = patch_items(floor, floor.face_centroids[:, 0] > 0.5)
    >>> tint = 0.3 * items.item_of_face[None]  # the second half is redder
    >>> grid = wall_maps(items, np.arange(2), tint, 0.1)[0]
    >>> (np.abs(grid.seams.step) / grid.seams.length).round(2).tolist()
    [[0.0], [0.28]]
    """
    points = _points(items, members, values)
    cell = max(
        cell, 1.2 * float(np.sqrt(2 * np.median(points.area))), float(np.ptp(points.foot)) / MOST_CELLS
    )
    foot = points.foot / cell
    ends = np.stack([foot.min(axis=1), foot.max(axis=1)])
    maps = []
    for shift in SHIFTS:
        grid = _value_map(points, foot, ends, shift)
        whole = _without_rims(grid.item)
        maps.append(WallMap(grid.item, whole, _seams(grid, whole)))
    return maps


@dataclass(frozen=True, eq=False)
class _Points:
    """Faces of a wall, item by item: where on its best plane, their height over it, and other values."""

    foot: FloatArray  # (2, n)
    values: FloatArray  # (1 + n_values, n)
    area: FloatArray
    item: IntArray


@dataclass(frozen=True, eq=False)
class _ValueMap:
    """Weights and values times weights of the cells, and the item that has most of a cell, −1 for none."""

    weight: FloatArray
    values: FloatArray  # (1 + n_values, rows, columns)
    item: IntArray


def _points(items: Items, members: IntArray, values: FloatArray | None) -> _Points:
    order, start = items.faces_by_item
    faces = np.concatenate([order[start[i] : start[i + 1]] for i in members])
    area = items.mesh.face_areas[faces]
    position = np.take(items.mesh.face_centroids, faces, axis=0)
    position -= np.average(position, axis=0, weights=area)  # a product's last bits depend on BLAS' threads
    axes, _ = principal_axes(position, area)
    foot = np.ascontiguousarray(axes[:, :2].T @ position.T)
    mapped = np.empty((1 if values is None else 1 + len(values), len(faces)))
    mapped[0] = position @ axes[:, 2]  # either side may be up
    if values is not None:
        np.take(values, faces, axis=1, out=mapped[1:])
    return _Points(foot, mapped, area, items.item_of_face[faces])


def _value_map(points: _Points, foot: FloatArray, ends: FloatArray, shift: tuple[float, float]) -> _ValueMap:
    """Mean values of the faces in each cell, by area; ``foot`` in cells, and its least and most."""
    offset = MARGIN - np.floor(ends[0] + shift)
    most = np.floor(ends[1] + shift) + offset
    shape = (int(most[1]) + MARGIN + 1, int(most[0]) + MARGIN + 1)
    weight, most, part = np.zeros((3, *shape))
    sums, winner = np.zeros((len(points.values), *shape)), np.full(shape, -1, np.int32)
    columns, rows = (foot + (np.asarray(shift) + offset)[:, None]).astype(np.int32)  # from MARGIN on
    _rasterise(rows, columns, points.values, points.area, points.item, weight, sums, winner, most, part)
    return _ValueMap(weight, sums, winner)


@kernel
def _rasterise(  # type: ignore[no-untyped-def]
    rows, columns, values, area, item, weight, sums, winner, most, part
):
    """Weight, weight times values, and the item with most of each cell, the lowest of equals.

    ``most`` is how much that is, ``part`` how much the item at hand has, both zero to begin with.
    """
    begin = 0
    while begin < len(item):
        end = begin
        while end < len(item) and item[end] == item[begin]:
            r, c = rows[end], columns[end]
            weight[r, c] += area[end]
            for v in range(len(values)):
                sums[v, r, c] += area[end] * values[v, end]
            part[r, c] += area[end]
            end += 1
        for f in range(begin, end):
            r, c = rows[f], columns[f]
            if part[r, c] > most[r, c]:
                most[r, c] = part[r, c]
                winner[r, c] = item[begin]
        for f in range(begin, end):
            part[rows[f], columns[f]] = 0.0
        begin = end


def _without_rims(item: IntArray) -> IntArray:
    """The map's items with the cells of narrow ones given to the broad one beside them.

    Superfacets split a step into narrow strips of middling height, over which both sides would be joined.
    """
    is_broad = np.zeros(int(item.max()) + 2, dtype=np.bool_)
    is_broad[item[_inner(item)]] = True
    is_broad[-1] = False
    if not is_broad.any():
        return item
    return np.where(item >= 0, nearest(np.where(is_broad[item], item, -1), REACH, item), item)


def _inner(item: IntArray) -> BoolArray:
    """(rows, columns) whether all cells within RIM of a cell are of its item."""
    out = np.ones(item.shape, dtype=np.bool_)
    for cells, inner in ((item, out), (item.T, out.T)):
        before = inner.copy()
        for step in range(1, RIM + 1):
            same = cells[step:] == cells[:-step]
            inner[step:] &= same & before[:-step]
            inner[:-step] &= same & before[step:]
    return out


def _seams(grid: _ValueMap, item: IntArray) -> Seams:
    """Steps and ridges between neighbouring cells of different items, summed over each pair of items.

    The step is that between the mean values of the third to fifth cells on both sides; what is nearer is
    rounded by the scan. The ridge is how much the two cells at the seam stand out of that mean.
    """
    first, second, steps, ridges = [], [], [], []
    for axis in (0, 1):
        beside = np.roll(item, -1, axis)
        rows, columns = np.nonzero((item >= 0) & (beside >= 0) & (item != beside))
        i, j = item[rows, columns], beside[rows, columns]
        across, above = np.empty((2, len(grid.values), len(i)))
        _measure(
            rows,
            columns,
            1 - axis,
            axis,
            grid.weight,
            grid.values,
            np.array(PARTS),
            np.empty(5),
            across,
            above,
        )
        first.append(np.minimum(i, j))
        second.append(np.maximum(i, j))
        steps.append(np.where(i < j, across, -across))
        ridges.append(above)
    low, high = np.concatenate(first), np.concatenate(second)
    n = int(item.max()) + 1
    code, inverse = np.unique(low * n + high, return_inverse=True)
    step, ridge = (
        np.stack([_sums(inverse, row, len(code)) for row in np.concatenate(values, axis=1)])
        for values in (steps, ridges)
    )
    length = _sums(inverse, np.ones(len(inverse)), len(code))
    return Seams(np.stack([code // n, code % n], axis=1), step, ridge, length)


def _sums(place: IntArray, values: FloatArray, n_places: int) -> FloatArray:
    return np.asarray(np.bincount(place, values, n_places), dtype=np.float64)


@kernel
def _measure(rows, columns, down, right, weight, values, parts, means, step, ridge):  # type: ignore[no-untyped-def]
    """Step and ridge of the values where a cell meets the next one down or to the right.

    From the means over `PARTS`; where all cells of a side are empty, its cell at the seam stands for it.
    """
    for e in range(len(rows)):
        for v in range(len(values)):
            for p in range(len(parts)):
                total, w = 0.0, 0.0
                for k in range(parts[p, 0], parts[p, 1], parts[p, 2]):
                    r, c = rows[e] + k * down, columns[e] + k * right
                    w += weight[r, c]
                    total += values[v, r, c]
                means[p] = total / w if w > 0 else means[p - 3] if p > 2 else 0.0
            step[v, e] = means[4] - means[3]
            ridge[v, e] = means[2] - (means[3] + means[4]) / 2


def nearest(cells: IntArray, reach: int, otherwise: IntArray) -> IntArray:
    """(rows, columns) the value of the nearest cell that has one, within ``reach`` cells.

    Of several as near that in the first column, there in the first row, as `scipy.ndimage` has it.

    Parameters
    ----------
    cells : (rows, columns) int
        −1 where there is no value.
    reach : int
        In cells.
    otherwise : (rows, columns) int
        What stands where none is within reach, and within ``reach`` of the map's edges.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.wall_map import nearest
    >>> cells = np.full((5, 7), -1)
    >>> cells[2, 2] = 5
    >>> nearest(cells, 2, np.zeros((5, 7), int))[2].tolist()
    [0, 0, 5, 5, 5, 0, 0]
    """
    steps = range(-reach, reach + 1)
    offsets = sorted((x * x + y * y, x, y) for x in steps for y in steps if x * x + y * y <= reach * reach)
    out = np.array(otherwise, dtype=np.int32)
    _fill(np.asarray(cells, dtype=np.int32), np.array(offsets), reach, out)
    return out


@kernel
def _fill(cells, offsets, reach, out):  # type: ignore[no-untyped-def]
    """The first value at one of the offsets, the third and second number of each, from each cell."""
    for r in range(reach, cells.shape[0] - reach):
        for c in range(reach, cells.shape[1] - reach):
            for k in range(len(offsets)):
                value = cells[r + offsets[k, 2], c + offsets[k, 1]]
                if value >= 0:
                    out[r, c] = value
                    break
