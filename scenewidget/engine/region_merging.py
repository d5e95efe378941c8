"""Region merging: regions of a map are joined as long as there is no step between them, the surest first.

Goes in: regions, and the sums along their seams. Comes out: which regions are one. Not in the thesis.
"""

from __future__ import annotations

import heapq

import numba
import numpy as np

from scenewidget.engine.mesh import IntArray
from scenewidget.engine.seam_lists import insert, remove
from scenewidget.engine.wall_map import Seams

__all__ = ["merged_regions"]

DOUBT = 2.5  # A seam of n cells counts as DOUBT / √n steps higher, so that long seams are decided first.


def merged_regions(n_regions: int, seams: Seams) -> IntArray:
    """(n_regions,) the root of each region after joining those whose seam has no step, the surest first.

    Sure is a small mean along a long seam. Sums over seams add up when regions are joined, so the mean is
    always that of all cells between two regions.

    Parameters
    ----------
    n_regions : int
    seams : Seams
        In units of what counts as a step: a mean of at most 1 is none.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.region_merging import merged_regions
    >>> from scenewidget.engine.wall_map import Seams
    >>> steps, ridges = np.array([[0.5, 9.0]]), np.zeros((1, 2))
    >>> seams = Seams(np.array([[0, 1], [1, 2]]), steps, ridges, np.array([3.0, 3.0]))
    >>> merged_regions(3, seams).tolist()  # mean steps of 1/6 and 3
    [1, 1, 2]
    """
    parent = np.arange(n_regions)
    if len(seams.pairs):
        sums = np.concatenate([seams.step, seams.ridge])
        _merge(parent, seams.pairs, np.ascontiguousarray(sums.T), seams.length.copy())
    while not np.array_equal(parent, parent[parent]):
        parent = parent[parent]
    return parent


@numba.njit(cache=True, nogil=True)
def _merge(parent, pairs, sums, length):  # type: ignore[no-untyped-def]
    """Sets the parent of each node that is joined to another; the sums are overwritten.

    The sums are first those of the steps, from the first to the second end, then those of the ridges.
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
            insert(head, after, before, ends[s, side], 2 * s + side)
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
            remove(head, after, before, ends[s, side], 2 * s + side)
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
                remove(head, after, before, k, 2 * s + 1 - side)
                degree[k] -= 1
                s = old
            else:
                ends[s, side] = i
                insert(head, after, before, i, entry)
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
