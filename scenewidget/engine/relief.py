"""What lies on a floor or hangs on a wall, nearly in its plane: carpets, doors, pictures.

Goes in: labels in which the hull of the room is whole. Comes out: labels in which regions that stand out
from their wall or floor by a small step, or behind a ridge as a door behind its frame, or by their tint, are
segments of their own. Normals can't see a step of a centimetre; a map of heights over the plane can, and
where the walls are less even than that, a map of tints. Not in the thesis.
"""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from scenewidget.engine.consensus import co_association
from scenewidget.engine.hull import segment_planes
from scenewidget.engine.items import Items
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.memo import Recall, compute
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray
from scenewidget.engine.region_merging import merged_regions
from scenewidget.engine.wall_map import Seams, WallMap, nearest, wall_maps

__all__ = ["separate_reliefs", "separate_tints"]

HEIGHTS, TINTS = slice(0, 1), slice(1, None)  # which values of the maps
FACING = 0.7  # Items are in the map whose normal has this dot product with the wall's: no flanks, no shells.
# A region above this share of the wall's main one must stand out more: scans bend walls and shift halves.
LARGE = 0.3
UNEVEN = 5.0  # A step is at least this many times as high as the walls are uneven.
HOLE = 2  # Holes in a map up to twice so many cells wide don't count.
# A thing borders on its wall along this share of its outline; a part that has been shifted lies at the edge.
SURROUNDED = 0.5


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
        Least mean height of the step, or of the ridge, along a region's seam, units of the scene.
    min_area : float
        Least area of such a region, square units of the scene.
    cell : float
        Side of the map's cells, units of the scene; more where faces are larger.
    n_threads : int
        Doesn't change the result.
    recall : Recall
        Where to remember the maps of walls: other labels of the same items leave most walls as they are.

    Returns
    -------
    labels : (n_items,) int32
        Dense.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.relief import separate_reliefs
    >>> floor = square(60, size=3.0)
    >>> is_carpet = (np.abs(floor.vertices[:, :2] - 1.5) < 0.6).all(axis=1)
    >>> scan = sw.Mesh(floor.vertices + np.outer(is_carpet, [0, 0, 0.02]), floor.faces)  # 2 cm thick
    >>> tile = np.floor(floor.face_centroids[:, :2] / 0.15).astype(int)
    >>> items = patch_items(scan, tile[:, 0] * 20 + tile[:, 1])
    >>> labels = separate_reliefs(items, np.zeros(items.n, np.int32))
    >>> round(float(items.areas[labels == 1].sum()), 1)
    0.8
    """
    s = items.scale
    return _separated(items, labels, HEIGHTS, step * s, min_area * s**2, cell * s, n_threads, recall)


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

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.relief import separate_tints
    >>> items = patch_items(square(4, size=2.0), np.zeros(32, int))  # without colours nothing is parted
    >>> separate_tints(items, np.zeros(1, np.int32)).tolist()
    [0]
    """
    if items.face_tints is None:
        return labels
    s = items.scale
    return _separated(items, labels, TINTS, contrast, min_area * s**2, cell * s, n_threads, recall)


def _separated(
    items: Items,
    labels: IntArray,
    which: slice,
    step: float,
    min_area: float,
    cell: float,
    n_threads: int,
    recall: Recall,
) -> IntArray:
    """Regions parted by some of the values in the maps, lengths in metres.

    A wall is mapped once for all its values: most walls stay whole when their reliefs are parted.
    """
    planes = segment_planes(items, labels)
    inside = items.normals @ planes.normals[planes.is_hull].T > FACING
    walls = [
        np.flatnonzero(inside[:, i] & (labels == s)) for i, s in enumerate(np.flatnonzero(planes.is_hull))
    ]
    walls = [members for members in walls if len(members)]
    if not walls:
        return labels
    tints = items.face_tints  # not found by two threads at once

    def maps_of(members: IntArray) -> list[WallMap]:
        key = ("wall map", cell, members.tobytes())
        return recall(key, lambda: wall_maps(items, members, tints, cell))

    with ThreadPoolExecutor(n_threads) as pool:
        maps = list(pool.map(maps_of, walls))
        uneven = _unevenness([grid.seams.of(which) for wall in maps for grid in wall])
        steps = np.maximum(step, UNEVEN * uneven)

        def reliefs_of(members: IntArray, wall: list[WallMap]) -> list[IntArray]:
            key = ("reliefs", which.start, cell, min_area, steps.tobytes(), members.tobytes())
            return recall(key, lambda: _reliefs(items.areas, members, wall, which, steps, min_area))

        reliefs = pool.map(reliefs_of, walls, maps)
        labels = labels.copy()
        for label, relief in enumerate(itertools.chain.from_iterable(reliefs), len(planes.areas)):
            labels[relief] = label
    return labels


def _unevenness(seams: list[Seams]) -> FloatArray:
    """(n_values,) median of the mean step along a seam, by length: most seams lie within one surface."""
    length = np.concatenate([s.length for s in seams])
    means = np.abs(np.concatenate([s.step for s in seams], axis=1)) / length
    if len(length) == 0:
        return np.zeros(len(means))
    order = np.argsort(means, axis=1)
    half = (np.cumsum(length[order], axis=1) < 0.5 * length.sum()).sum(axis=1)
    return np.asarray(means[np.arange(len(means)), order[np.arange(len(means)), half]])


def _reliefs(
    areas: FloatArray,
    members: IntArray,
    maps: list[WallMap],
    which: slice,
    steps: FloatArray,
    min_area: float,
) -> list[IntArray]:
    """Items of each region that stands out of the wall.

    Where the cells happen to lie matters near the threshold: so several grids vote, by evidence
    accumulation as in `consensus`.
    """
    seams = [grid.seams.of(which).in_units_of(steps) for grid in maps]
    keys = [_regions(areas, grid, seam, min_area)[members] for grid, seam in zip(maps, seams)]
    co = co_association(np.stack(keys, axis=1), areas[members], n_threads=1)
    region = cut_tree(average_linkage(co.C, co.weights), similarity=0.5)[co.base]
    area = np.bincount(region, areas[members])
    is_relief = area >= min_area
    is_relief[area.argmax()] = False
    return [members[region == r] for r in np.flatnonzero(is_relief)]


def _regions(areas: FloatArray, grid: WallMap, seams: Seams, min_area: float) -> IntArray:
    """(n_items,) 1 and up for regions that stand out of the wall on one grid, 0 for all else."""
    roots = merged_regions(int(grid.without_rims.max()) + 1, seams)
    cells = np.where(grid.without_rims >= 0, roots[grid.without_rims], -1)
    region = _most_frequent(grid.item, cells, len(areas))
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


def _surrounded(region: IntArray, n_regions: int) -> FloatArray:
    """(n_regions,) share of each region's outline beyond which the map goes on; small holes don't count."""
    region = nearest(region, HOLE, np.full(region.shape, -1))
    outline, inner = np.zeros(n_regions + 1), np.zeros(n_regions + 1)  # the last is that of empty cells
    for axis in (0, 1):
        beside = np.roll(region, -1, axis)
        at = region != beside
        for one, other in ((region[at], beside[at]), (beside[at], region[at])):
            outline += np.bincount(one % (n_regions + 1), minlength=n_regions + 1)
            inner += np.bincount(one % (n_regions + 1), other >= 0, n_regions + 1)
    return np.asarray(inner[:-1] / np.maximum(outline[:-1], 1.0))


def _mean_step(seams: Seams, ends: IntArray, around: BoolArray, region: int) -> float:
    """Mean over the cells round a region of the steps and ridges, whichever is largest on each side."""
    other = np.where(ends[around, 0] == region, ends[around, 1], ends[around, 0])
    sign = np.where(ends[around, 0] == region, 1.0, -1.0)
    sums = [np.bincount(other, sign * step) for step in seams.step[:, around]]
    sums += [np.bincount(other, ridge) for ridge in seams.ridge[:, around]]
    return float(np.abs(sums).max(axis=0).sum() / seams.length[around].sum())
