"""Regions joined along their seams, one pair after the other, the surest first.

Goes in: a graph of regions and the sums along its seams. Comes out: which regions are one. What counts as
sure is up to those who call it: `felzenszwalb` and `region_merging`.

Each seam is in the lists of both its ends, as entry 2 s in that of its first and 2 s + 1 in that of its
second end. ``head`` has the first entry of each region, −1 for none; ``after`` and ``before`` link entries.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray, ascending

__all__ = ["insert", "joined_along_seams", "remove"]

WAITING = -1  # place in the heap of a seam that comes again when it or a limit changes
UNCHANGED = -2  # of one that comes in the order of the start


def joined_along_seams(
    pairs: IntArray,
    sums: FloatArray,
    n_signed: int,
    lengths: FloatArray,
    limits: FloatArray,
    *,
    doubt: float = 0.0,
    sizes: FloatArray | None = None,
    threshold: float = 0.0,
) -> IntArray:
    """(n_regions,) the root of each region after joining two by two, the seam of least mean first.

    The mean along a seam is the largest of its sums, without its sign, over its length. Sums and lengths add
    up as seams become one. Two regions are joined while the mean is at most the limit of both.

    Parameters
    ----------
    pairs : (n_pairs, 2) int
        Neighbouring regions, each pair once.
    sums : (n_pairs, n_values) float
    n_signed : int
        The first so many values go from the first to the second end: seen from there they have another sign.
    lengths : (n_pairs,) float
    limits : (n_regions,) float
    doubt : float
        A seam of length n comes as if its mean were so much / √n higher.
    sizes : (n_regions,) float, optional
        With it, the limit of what was joined at a mean w is ``w + threshold / size``.
    threshold : float

    Notes
    -----
    Equal means are taken in the order of the pairs; with a ``doubt`` by the numbers of the two regions, that
    with more seams first, and in the order of the pairs at first.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.seam_lists import joined_along_seams
    >>> pairs = np.array([[0, 1], [1, 2]])
    >>> joined_along_seams(pairs, np.array([[0.2], [3.0]]), 1, np.ones(2), np.ones(3)).tolist()
    [1, 1, 2]
    """
    n, m = len(limits), len(pairs)
    roots = np.arange(n)
    ends = np.array(pairs, dtype=np.int64, order="C")
    sums, lengths = np.array(sums, np.float64, order="C"), np.array(lengths, np.float64)
    size, limits = np.array([] if sizes is None else sizes, np.float64), np.array(limits, np.float64)
    mean = np.abs(sums).max(axis=1, initial=0.0) / lengths
    rank = mean + (doubt / np.sqrt(lengths) if doubt > 0 else 0.0)
    key = ends.copy() if doubt > 0 else np.zeros((m, 2), np.int64)
    order = np.lexsort((key[:, 1], key[:, 0], rank)) if doubt > 0 else ascending(rank)
    state = np.full((3, n), -1)
    state[1] = 0
    _join(
        roots, ends, sums, n_signed, lengths, limits, float(doubt), size, float(threshold), order,
        state, np.empty((2, 2 * m), np.int64), np.empty((2, m), np.int64), mean, rank, key,
    )  # fmt: skip
    while not np.array_equal(roots, roots[roots]):
        roots = roots[roots]
    return roots


@kernel
def _join(  # type: ignore[no-untyped-def]
    parent, ends, sums, n_signed, length, limit, doubt, size, threshold, order,
    state, links, heaps, mean, rank, key,
):  # fmt: skip
    """Sets the parent of each region that is joined to another; all that it gets is overwritten.

    Seams come by ``rank``, then by ``key``. Those that are as they were come in ``order``. ``heaps`` has a
    heap of the others, which are few, and the place of each there, `UNCHANGED` or `WAITING`. ``state`` has
    the head of each region's list, the length of the list, and a seam to the region from the one that is
    looked at, if any: what stands there from before has other ends.
    """
    m, n_values = sums.shape
    after, before, heap, place = links[0], links[1], heaps[0], heaps[1]
    head, degree, seam_to = state[0], state[1], state[2]
    for s in range(m):
        for side in range(2):
            insert(head, after, before, ends[s, side], 2 * s + side)
            degree[ends[s, side]] += 1
        place[s] = UNCHANGED
    n_heap, next_one = np.int64(0), np.int64(0)
    while True:
        while next_one < m and place[order[next_one]] != UNCHANGED:
            next_one += 1
        if next_one < m and (n_heap == 0 or _is_before(order[next_one], heap[0], rank, key)):
            s = order[next_one]
            place[s] = WAITING
        elif n_heap > 0:
            s = heap[0]
            n_heap = _drop(s, heap, place, n_heap, rank, key)
        else:
            break
        w, i, j = mean[s], ends[s, 0], ends[s, 1]
        if w > limit[i] or w > limit[j]:
            continue
        if degree[i] < degree[j]:
            i, j = j, i
        parent[j] = i
        limit_before = limit[i]
        if len(size) > 0:
            size[i] += size[j]
            limit[i] = w + (threshold / size[i] if size[i] > 0 else np.inf)
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
            if old >= 0 and (ends[old, 0] == i or ends[old, 1] == i):
                sign = 1.0 if (ends[old, 0] == i) == (side == 0) else -1.0  # both from i to k
                for v in range(n_values):
                    sums[old, v] += sign * sums[s, v] if v < n_signed else sums[s, v]
                length[old] += length[s]
                if place[s] >= 0:
                    n_heap = _drop(s, heap, place, n_heap, rank, key)
                place[s] = WAITING
                remove(head, after, before, k, 2 * s + 1 - side)
                degree[k] -= 1
                s = old
            else:
                ends[s, side] = i
                insert(head, after, before, i, entry)
                degree[i] += 1
            most = 0.0
            for v in range(n_values):
                if abs(sums[s, v]) > most:
                    most = abs(sums[s, v])
            mean[s] = most / length[s]
            rank[s] = mean[s]
            if doubt > 0.0:
                rank[s] += doubt / length[s] ** 0.5
                key[s, 0], key[s, 1] = i, k
            n_heap = _settle(s, heap, place, n_heap, rank, key)
            entry = following
        if limit[i] > limit_before:  # else what it stopped has to wait on
            entry = head[i]
            while entry >= 0:
                s = entry // 2
                if place[s] == WAITING and mean[s] <= limit[i]:
                    n_heap = _settle(s, heap, place, n_heap, rank, key)
                entry = after[entry]


@kernel
def _drop(s, heap, place, n_heap, rank, key):  # type: ignore[no-untyped-def]
    """Take a seam out of the heap; how many are in it then."""
    n_heap -= 1
    last = heap[n_heap]
    if last != s:
        place[last] = place[s]
        _settle(last, heap, place, n_heap, rank, key)
    place[s] = WAITING
    return n_heap


@kernel
def _settle(s, heap, place, n_heap, rank, key):  # type: ignore[no-untyped-def]
    """Put a seam, new or moved, where it belongs in the heap; how many are in it then."""
    if place[s] < 0:
        place[s] = n_heap
        n_heap += 1
    at = place[s]
    while at > 0 and _is_before(s, heap[(at - 1) // 2], rank, key):
        heap[at] = heap[(at - 1) // 2]
        place[heap[at]] = at
        at = (at - 1) // 2
    below = 2 * at + 1
    while below < n_heap:
        if below + 1 < n_heap and _is_before(heap[below + 1], heap[below], rank, key):
            below += 1
        if not _is_before(heap[below], s, rank, key):
            break
        heap[at] = heap[below]
        place[heap[at]] = at
        at = below
        below = 2 * at + 1
    heap[at], place[s] = s, at
    return n_heap


@kernel
def _is_before(s, t, rank, key):  # type: ignore[no-untyped-def]
    if rank[s] != rank[t]:
        return rank[s] < rank[t]
    if key[s, 0] != key[t, 0]:
        return key[s, 0] < key[t, 0]
    if key[s, 1] != key[t, 1]:
        return key[s, 1] < key[t, 1]
    return s < t


@kernel
def insert(head, after, before, region, entry):  # type: ignore[no-untyped-def]
    """Put an entry at the head of a region's list."""
    after[entry], before[entry] = head[region], -1
    if head[region] >= 0:
        before[head[region]] = entry
    head[region] = entry


@kernel
def remove(head, after, before, region, entry):  # type: ignore[no-untyped-def]
    """Take an entry from a region's list."""
    if before[entry] >= 0:
        after[before[entry]] = after[entry]
    else:
        head[region] = after[entry]
    if after[entry] >= 0:
        before[after[entry]] = before[entry]
