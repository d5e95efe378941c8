"""What lies on a floor or hangs on a wall, nearly in its plane: carpets, doors, pictures.

Goes in: labels in which the hull of the room is whole. Comes out: labels in which regions that stand out
from their wall or floor by a small step, or behind a ridge as a door behind its frame, or by their tint, are
segments of their own. Normals can't see a step of a centimetre; a map of heights over the plane can, and
where the walls are less even than that, a map of tints. Not in the thesis.
"""

from __future__ import annotations

import heapq
import itertools
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numba
import numpy as np
from scipy import ndimage

from scenewidget.engine.consensus import co_association
from scenewidget.engine.hull import segment_planes
from scenewidget.engine.items import Items
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.memo import Recall, compute
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray

__all__ = ["separate_reliefs", "separate_tints"]

FACING = 0.7  # least dot product with the plane's normal of what is in the map: no flanks, no shells
LARGE = 0.3  # of the wall's main region; larger ones must stand out more: scans bend walls and shift halves
MARGIN = 5  # empty cells round the map, as far as heights are compared
MOST_CELLS = 2_000  # along a side of the map
SHIFTS = ((0.0, 0.0), (0.5, 0.5), (0.0, 0.5), (0.5, 0.0))  # of the grids that vote, in cells
UNEVEN = 5.0  # a step is this many times the unevenness of the walls
REACH = 2  # cells; narrow items this near to a broad one are the rim of a step
RIM = 1  # cells; an item that nowhere holds a square of 2 RIM + 1 cells is narrow
SURROUNDED = 0.5  # of its outline, along which a region borders on its wall: a shifted part lies at the edge
DOUBT = 2.5  # steps over the root of a seam's cells: long seams are decided first


def separate_reliefs(
    items: Items,
    labels: IntArray,
    *,
    step: float = 0.008,
    min_area: float = 0.1,
    cell: float = 0.03,
    n_threads: int = 2,
    recall: Recall = compute,
) -> IntArray:
    """Part what stands out of walls, floor and ceiling by a step.

    In the map of a wall's heights, items are joined to regions while the mean step along their common seam
    is small, the surest first.

    Parameters
    ----------
    items : Items
    labels : (n_items,) int32
        Dense.
    step : float
        Least mean height of the step, or of the ridge, along a region's seam, metres.
    min_area : float
        Least area of such a region, m².
    cell : float
        Side of the map's cells, metres; more where faces are larger.
    n_threads : int
        Doesn't change the result.
    recall : Recall
        Where to remember the maps of walls: other labels of the same items leave most walls as they are.

    Returns
    -------
    labels : (n_items,) int32
        Dense.
    """
    return _separated(items, labels, None, step, min_area, cell, n_threads, recall)


def separate_tints(
    items: Items,
    labels: IntArray,
    *,
    contrast: float = 0.15,
    min_area: float = 0.1,
    cell: float = 0.03,
    n_threads: int = 2,
    recall: Recall = compute,
) -> IntArray:
    """Part what differs in tint from the wall, floor or ceiling round it; nothing where there are no colours.

    As `separate_reliefs`, with maps of tints (see `Items.face_tints`) in place of heights.

    Parameters
    ----------
    items : Items
    labels : (n_items,) int32
        Dense.
    contrast : float
        Least mean step of a tint, or of a stripe, along a region's seam.
    min_area, cell, n_threads, recall
        As there.

    Returns
    -------
    labels : (n_items,) int32
        Dense.
    """
    tints = items.face_tints
    if tints is None:
        return labels
    return _separated(items, labels, tints, contrast, min_area, cell, n_threads, recall)


def _separated(
    items: Items,
    labels: IntArray,
    values: FloatArray | None,
    step: float,
    min_area: float,
    cell: float,
    n_threads: int,
    recall: Recall,
) -> IntArray:
    """Regions parted by (n_values, n_faces) values of the faces; by their heights over the wall for None."""
    planes = segment_planes(items, labels)
    inside = items.normals @ planes.normals[planes.is_hull].T > FACING
    walls = [
        np.flatnonzero(inside[:, i] & (labels == s)) for i, s in enumerate(np.flatnonzero(planes.is_hull))
    ]
    walls = [members for members in walls if len(members)]
    if not walls:
        return labels
    kind = "heights" if values is None else "tints"

    def maps_of(members: IntArray) -> list[_Map]:
        key = ("wall map", kind, cell, members.tobytes())
        return recall(key, lambda: _maps(_points(items, members, values), cell))

    with ThreadPoolExecutor(n_threads) as pool:
        maps = list(pool.map(maps_of, walls))
        uneven = _unevenness([seams for wall in maps for _, _, seams in wall])
        steps = np.maximum(step, UNEVEN * uneven)
        reliefs = pool.map(
            lambda members, wall: _reliefs(items.areas, members, wall, steps, min_area), walls, maps
        )
        labels = labels.copy()
        for label, relief in enumerate(itertools.chain.from_iterable(reliefs), len(planes.areas)):
            labels[relief] = label
    return labels


def _unevenness(seams: list[_Seams]) -> FloatArray:
    """(n_values,) median of the mean step along a seam, by length: most seams lie within one surface."""
    length = np.concatenate([s.length for s in seams])
    means = np.abs(np.concatenate([s.step for s in seams], axis=1)) / length
    if len(length) == 0:
        return np.zeros(len(means))
    order = np.argsort(means, axis=1)
    half = (np.cumsum(length[order], axis=1) < 0.5 * length.sum()).sum(axis=1)
    return np.asarray(means[np.arange(len(means)), order[np.arange(len(means)), half]])


def _reliefs(
    areas: FloatArray, members: IntArray, maps: list[_Map], steps: FloatArray, min_area: float
) -> list[IntArray]:
    """Items of each region that stands out of the wall.

    Where the cells happen to lie matters near the threshold: so several grids vote, by evidence
    accumulation as in `consensus`.
    """
    keys = [
        _regions(areas, item, whole, seams.in_units_of(steps), min_area)[members]
        for item, whole, seams in maps
    ]
    co = co_association(np.stack(keys, axis=1), areas[members], n_threads=1)
    region = cut_tree(average_linkage(co.C, co.weights), similarity=0.5)[co.base]
    area = np.bincount(region, areas[members])
    is_relief = area >= min_area
    is_relief[area.argmax()] = False
    return [members[region == r] for r in np.flatnonzero(is_relief)]


def _regions(areas: FloatArray, item: IntArray, whole: IntArray, seams: _Seams, min_area: float) -> IntArray:
    """(n_items,) 1 and up for regions that stand out of the wall on one grid, 0 for all else."""
    roots = _merged(int(whole.max()) + 1, seams)
    cells = np.where(whole >= 0, roots[whole], -1)
    region = _most_frequent(item, cells, len(areas))
    area = np.bincount(region[region >= 0], areas[region >= 0], len(areas))
    main = int(area.argmax())
    surrounded = _surrounded(cells, len(areas))
    ends = roots[seams.pairs]
    is_between = ends[:, 0] != ends[:, 1]
    out = np.zeros(len(areas), dtype=np.int32)
    for r in np.flatnonzero(area >= min_area).tolist():
        around = is_between & (ends == r).any(axis=1)
        if r == main or surrounded[r] < SURROUNDED or not around.any():
            continue
        if _mean_step(seams, ends, around, r) >= max(1.0, area[r] / (LARGE * area[main])):
            out[region == r] = r + 1
    return out


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


@dataclass(frozen=True, eq=False)
class _Seams:
    """Pairs of items, and sums over the cells along their seam: step (second less first), ridge, number."""

    pairs: IntArray
    step: FloatArray  # (n_values, n_pairs)
    ridge: FloatArray  # (n_values, n_pairs)
    length: FloatArray

    def in_units_of(self, steps: FloatArray) -> _Seams:
        """Steps and ridges as multiples of what counts as a step, (n_values,)."""
        return _Seams(self.pairs, self.step / steps[:, None], self.ridge / steps[:, None], self.length)


_Map = tuple[IntArray, IntArray, _Seams]  # items of the cells, also without rims, and seams of the latter


def _points(items: Items, members: IntArray, values: FloatArray | None) -> _Points:
    order, start = items.faces_by_item
    faces = np.concatenate([order[start[i] : start[i + 1]] for i in members])
    area = items.mesh.face_areas[faces]
    position = items.mesh.face_centroids[faces]
    position -= np.average(position, axis=0, weights=area)  # a product's last bits depend on BLAS' threads
    _, axes = np.linalg.eigh((area[:, None] * position).T @ position)
    foot = np.ascontiguousarray(axes[:, 1:].T @ position.T)
    heights = (position @ axes[:, 0])[None]  # either side may be up
    return _Points(foot, heights if values is None else values[:, faces], area, items.item_of_face[faces])


def _maps(points: _Points, cell: float) -> list[_Map]:
    """A map on each of the grids."""
    cell = max(
        cell, 1.2 * float(np.sqrt(2 * np.median(points.area))), float(np.ptp(points.foot)) / MOST_CELLS
    )
    maps = []
    for shift in SHIFTS:
        grid = _value_map(points, cell, shift)
        whole = _without_rims(grid.item)
        maps.append((grid.item, whole, _seams(grid, whole)))
    return maps


def _value_map(points: _Points, cell: float, shift: tuple[float, float]) -> _ValueMap:
    """Mean values of the faces in each cell, by area."""
    offset = MARGIN - np.floor(points.foot.min(axis=1) / cell + shift)
    most = np.floor(points.foot.max(axis=1) / cell + shift) + offset
    shape = (int(most[1]) + MARGIN + 1, int(most[0]) + MARGIN + 1)
    across, along = np.asarray(shift) + offset
    return _ValueMap(
        *_rasterised(points.foot, points.values, points.area, points.item, cell, across, along, shape)
    )


@numba.njit(cache=True, nogil=True)
def _rasterised(foot, values, area, item, cell, across, along, shape):  # type: ignore[no-untyped-def]
    """Weight, weight times values, and the item with most of each cell, the lowest of equals."""
    weight, sums = np.zeros(shape), np.zeros((len(values), *shape))
    winner, most = np.full(shape, -1, np.int32), np.zeros(shape)
    part = np.zeros(shape)  # of the item at hand
    rows, columns = np.empty(len(item), np.int32), np.empty(len(item), np.int32)
    for f in range(len(item)):
        columns[f] = int(np.floor(foot[0, f] / cell + across))
        rows[f] = int(np.floor(foot[1, f] / cell + along))
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
    return weight, sums, winner


def _sums(place: IntArray, values: FloatArray, n_places: int) -> FloatArray:
    return np.asarray(np.bincount(place, values, n_places), dtype=np.float64)


def _most_frequent(item: IntArray, region: IntArray, n_items: int) -> IntArray:
    """(n_items,) the region that most of an item's cells are in, the lowest of equals; −1 outside the map."""
    is_known = (item >= 0) & (region >= 0)
    item, region = item[is_known].astype(np.int64), region[is_known]
    n = int(region.max(initial=0)) + 1
    code, count = np.unique(item * n + region, return_counts=True)
    order = np.lexsort((-code, count, code // n))
    out = np.full(n_items, -1)
    out[code[order] // n] = code[order] % n  # the last of an item wins
    return out


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


def _seams(grid: _ValueMap, item: IntArray) -> _Seams:
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
    return _Seams(np.stack([code // n, code % n], axis=1), step, ridge, length)


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


def _surrounded(region: IntArray, n_regions: int) -> FloatArray:
    """(n_regions,) share of each region's outline beyond which the map goes on; small holes don't count."""
    distance, (rows, columns) = ndimage.distance_transform_edt(region < 0, return_indices=True)
    region = np.where(distance <= REACH, region[rows, columns], -1)
    outline, inner = np.zeros(n_regions + 1), np.zeros(n_regions + 1)  # the last is that of empty cells
    for axis in (0, 1):
        beside = np.roll(region, -1, axis)
        at = region != beside
        for one, other in ((region[at], beside[at]), (beside[at], region[at])):
            outline += np.bincount(one % (n_regions + 1), minlength=n_regions + 1)
            inner += np.bincount(one % (n_regions + 1), other >= 0, n_regions + 1)
    return np.asarray(inner[:-1] / np.maximum(outline[:-1], 1.0))


def _merged(n_nodes: int, seams: _Seams) -> IntArray:
    """(n_nodes,) root of each node after joining regions whose seam has no step, the surest first.

    Sure is a small mean along a long seam. Sums over seams add up when regions are joined, so the mean is
    always that of all cells between two regions.
    """
    parent = np.arange(n_nodes)
    if len(seams.pairs):
        sums = np.concatenate([seams.step, seams.ridge])
        _merge(parent, seams.pairs, np.ascontiguousarray(sums.T), seams.length.copy())
    while not np.array_equal(parent, parent[parent]):
        parent = parent[parent]
    return parent


@numba.njit(cache=True, nogil=True)
def _merge(parent, pairs, sums, length):  # type: ignore[no-untyped-def]
    """Sets the parent of each node that is joined to another; the sums are overwritten.

    Each seam is in the lists of both its ends, as entry 2 s in that of its first and 2 s + 1 in that of its
    second end; the sums are first those of the steps, from the first to the second, then those of the ridges.
    """
    n, m, n_values = len(parent), len(pairs), sums.shape[1] // 2
    ends = pairs.copy()
    head = np.full(n, -1)  # first entry in the list of a node
    after, before = np.full(2 * m, -1), np.full(2 * m, -1)
    degree = np.zeros(n, np.int64)
    turn = np.zeros(m, np.int64)  # how often a seam has changed: what the heap has of it may be stale
    seam_to = np.full(n, -1)  # from the node at hand
    for s in range(m):
        for side in range(2):
            _insert(head, after, before, ends[s, side], 2 * s + side)
            degree[ends[s, side]] += 1
    heap = [(_doubt(sums, length, s), ends[s, 0], ends[s, 1], s, 0) for s in range(m)]
    heapq.heapify(heap)
    while len(heap) > 0:
        _, i, j, s, version = heapq.heappop(heap)
        if version != turn[s] or np.abs(sums[s]).max() > length[s]:
            continue
        if degree[i] < degree[j]:
            i, j = j, i
        parent[j] = i
        turn[s] = -1
        for side in range(2):
            _remove(head, after, before, ends[s, side], 2 * s + side)
            degree[ends[s, side]] -= 1
        entry = head[i]
        while entry >= 0:
            seam_to[ends[entry // 2, 1 - entry % 2]] = entry // 2
            entry = after[entry]
        entry = head[j]
        while entry >= 0:
            s, side, following = entry // 2, entry % 2, after[entry]
            k = ends[s, 1 - side]
            old = seam_to[k]
            if old >= 0:
                # both from i to k
                sign = 1.0 if (ends[old, 0] == i) == (side == 0) else -1.0
                sums[old, :n_values] += sign * sums[s, :n_values]
                sums[old, n_values:] += sums[s, n_values:]
                length[old] += length[s]
                turn[s] = -1
                _remove(head, after, before, k, 2 * s + 1 - side)
                degree[k] -= 1
                s = old
            else:
                ends[s, side] = i
                _insert(head, after, before, i, entry)
                degree[i] += 1
            turn[s] += 1
            heapq.heappush(heap, (_doubt(sums, length, s), i, k, s, turn[s]))
            entry = following
        entry = head[i]
        while entry >= 0:
            seam_to[ends[entry // 2, 1 - entry % 2]] = -1
            entry = after[entry]


@numba.njit(cache=True, nogil=True)
def _doubt(sums, length, s):  # type: ignore[no-untyped-def]
    return np.abs(sums[s]).max() / length[s] + DOUBT / length[s] ** 0.5


@numba.njit(cache=True, nogil=True)
def _insert(head, after, before, node, entry):  # type: ignore[no-untyped-def]
    """Put an entry at the head of a node's list."""
    after[entry], before[entry] = head[node], -1
    if head[node] >= 0:
        before[head[node]] = entry
    head[node] = entry


@numba.njit(cache=True, nogil=True)
def _remove(head, after, before, node, entry):  # type: ignore[no-untyped-def]
    if before[entry] >= 0:
        after[before[entry]] = after[entry]
    else:
        head[node] = after[entry]
    if after[entry] >= 0:
        before[after[entry]] = before[entry]


def _mean_step(seams: _Seams, ends: IntArray, around: BoolArray, region: int) -> float:
    """Mean over the cells round a region of the steps and ridges, whichever is largest on each side."""
    other = np.where(ends[around, 0] == region, ends[around, 1], ends[around, 0])
    sign = np.where(ends[around, 0] == region, 1.0, -1.0)
    sums = [np.bincount(other, sign * step) for step in seams.step[:, around]]
    sums += [np.bincount(other, ridge) for ridge in seams.ridge[:, around]]
    return float(np.abs(sums).max(axis=0).sum() / seams.length[around].sum())
