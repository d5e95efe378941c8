"""Maps of a wall: what stands how far out of its plane, or has which tint, on a grid of cells.

Goes in: the items of one wall, floor or ceiling. Come out: maps of the items on its plane, and for each pair
of items that meet there, by how much the heights or tints step across their seam. Not in the thesis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from scenewidget.engine.items import Items
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["Seams", "WallMap", "wall_maps"]

MARGIN = 5  # The map has so many empty cells round it, as heights are compared over five cells.
MOST_CELLS = 2_000  # A side of the map has at most this many cells.
REACH = 2  # A narrow item within so many cells of a broad one is the rim of a step.
RIM = 1  # An item is narrow that nowhere holds a square of 2 RIM + 1 cells.
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

    Parameters
    ----------
    items : Items
    members : (n_members,) int
        Items of the wall.
    values : (n_values, items.mesh.n_faces) float64, optional
        What to map; the heights of the faces over the wall's best plane where it is None.
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
    >>> height = 0.02 * items.item_of_face[None]  # the second half lies 2 cm higher
    >>> grid = wall_maps(items, np.arange(2), height, 0.1)[0]
    >>> (np.abs(grid.seams.step[0]) / grid.seams.length).round(2).tolist()
    [0.02]
    """
    points = _points(items, members, values)
    cell = max(
        cell, 1.2 * float(np.sqrt(2 * np.median(points.area))), float(np.ptp(points.foot)) / MOST_CELLS
    )
    maps = []
    for shift in SHIFTS:
        grid = _value_map(points, cell, shift)
        whole = _without_rims(grid.item)
        maps.append(WallMap(grid.item, whole, _seams(grid, whole)))
    return maps


@dataclass(frozen=True, eq=False)
class _Points:
    """Faces of a wall, item by item: where on its best plane, and their values or height over it."""

    foot: FloatArray  # (2, n)
    values: FloatArray  # (n_values, n)
    area: FloatArray
    item: IntArray


@dataclass(frozen=True, eq=False)
class _ValueMap:
    """Weights and values times weights of the cells, and the item that has most of a cell, −1 for none."""

    weight: FloatArray
    values: FloatArray  # (n_values, rows, columns)
    item: IntArray


def _points(items: Items, members: IntArray, values: FloatArray | None) -> _Points:
    order, start = items.faces_by_item
    faces = np.concatenate([order[start[i] : start[i + 1]] for i in members])
    area = items.mesh.face_areas[faces]
    position = items.mesh.face_centroids[faces]
    position -= np.average(position, axis=0, weights=area)  # a product's last bits depend on BLAS' threads
    _, axes = np.linalg.eigh((area[:, None] * position).T @ position)
    foot = np.ascontiguousarray(axes[:, 1:].T @ position.T)
    heights = (position @ axes[:, 0])[None]  # either side may be up
    values = np.ascontiguousarray(heights if values is None else values[:, faces])
    return _Points(foot, values, area, items.item_of_face[faces])


def _value_map(points: _Points, cell: float, shift: tuple[float, float]) -> _ValueMap:
    """Mean values of the faces in each cell, by area."""
    offset = MARGIN - np.floor(points.foot.min(axis=1) / cell + shift)
    most = np.floor(points.foot.max(axis=1) / cell + shift) + offset
    shape = (int(most[1]) + MARGIN + 1, int(most[0]) + MARGIN + 1)
    across, along = np.asarray(shift) + offset
    weight, most, part = np.zeros((3, *shape))
    sums, winner = np.zeros((len(points.values), *shape)), np.full(shape, -1, np.int32)
    columns, rows = (np.floor(points.foot / cell + [[across], [along]])).astype(np.int32)
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
    size = 2 * RIM + 1
    low, high = ndimage.minimum_filter(item, size), ndimage.maximum_filter(item, size)
    is_broad = np.zeros(int(item.max()) + 2, dtype=np.bool_)
    is_broad[item[(low == high) & (item >= 0)]] = True
    if not is_broad.any():
        return item
    distance, (rows, columns) = ndimage.distance_transform_edt(~is_broad[item], return_indices=True)
    return np.where((item >= 0) & (distance <= REACH), item[rows, columns], item)


def _seams(grid: _ValueMap, item: IntArray) -> Seams:
    """Steps and ridges between neighbouring cells of different items, summed over each pair of items.

    The step is that between the mean values of the third to fifth cells on both sides; what is nearer is
    rounded by the scan. The ridge is how much the two cells at the seam stand out of that mean.
    """
    first, second, steps, ridges = [], [], [], []
    for axis in (0, 1):
        beside = np.roll(item, -1, axis)
        at = np.nonzero((item >= 0) & (beside >= 0) & (item != beside))
        nothing = np.zeros((len(grid.values), len(at[0])))
        here, there = (_mean(grid, at, axis, (k,), nothing) for k in (0, 1))
        before = _mean(grid, at, axis, (-2, -3, -4), here)
        after = _mean(grid, at, axis, (3, 4, 5), there)
        i, j = item[at], beside[at]
        first.append(np.minimum(i, j))
        second.append(np.maximum(i, j))
        steps.append(np.where(i < j, after - before, before - after))
        ridges.append(_mean(grid, at, axis, (0, 1), nothing) - (before + after) / 2)
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


def _mean(
    grid: _ValueMap, at: tuple[IntArray, ...], axis: int, shifts: tuple[int, ...], otherwise: FloatArray
) -> FloatArray:
    """Mean values of the cells so far along an axis from places; something else where all are empty."""
    weight, values = np.zeros(otherwise.shape[1]), np.zeros(otherwise.shape)
    for shift in shifts:
        rows, columns = (places + shift if a == axis else places for a, places in enumerate(at))
        weight += grid.weight[rows, columns]
        values += grid.values[:, rows, columns]
    return np.where(weight > 0, values / np.where(weight > 0, weight, 1.0), otherwise)
