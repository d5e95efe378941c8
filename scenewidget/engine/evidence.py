"""What an ensemble knows about groups of pieces: how often its runs put them together.

Goes in: keys of the pieces, and the group of each. Comes out: mean co-association between groups. Evidence
accumulation: Fred and Jain (2005), IEEE TPAMI 27(6).
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.threads import one_blas_thread

__all__ = ["agreement_of_groups", "counted_together"]

BLOCK = 128  # A thread counts so many rows at a time, and compares them with as many.


def agreement_of_groups(
    keys: IntArray, weights: FloatArray, part: IntArray, group: IntArray, n_groups: int, asked: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Mean co-association between groups of parts, and between parts and groups.

    Parameters
    ----------
    keys : (n_parts, n_runs) int
        Cluster of each part in each run; −1 where the run did not see it.
    weights, part, group : (n_entries,)
        So much of a part lies in a group.
    n_groups : int
    asked : (n_asked,) int
        Parts whose agreement with every group is wanted.

    Returns
    -------
    between : (n_groups, n_groups) float64
        Share of the runs in which two random places, one of each group, share a cluster; 0 for a group
        without weight. The diagonal is that of a group with itself.
    with_groups : (n_asked, n_groups) float64

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.evidence import agreement_of_groups
    >>> keys = np.array([[0, 0], [0, 1], [1, 1]])  # three parts in two runs
    >>> group = np.array([0, 1, 1])  # the last two are one group
    >>> between, with_groups = agreement_of_groups(keys, np.ones(3), np.arange(3), group, 2, np.array([0]))
    >>> between.round(3).tolist(), with_groups.tolist()
    ([[1.0, 0.25], [0.25, 0.75]], [[1.0, 0.25]])
    """
    keys = np.asarray(keys, np.int64)
    n_runs = keys.shape[1]
    width = keys.max(axis=0, initial=-1) + 1
    start = np.concatenate([[0], np.cumsum(width)])
    table, total = np.zeros((n_groups, int(start[-1])), np.float32), np.zeros(n_groups)
    _fill(keys, np.asarray(weights, np.float64), part, group, start, table, total)
    mass = np.where(total > 0, total, np.inf)
    table /= mass[:, None].astype(np.float32)
    with one_blas_thread():  # a product of milliseconds: threads that wait for each other cost more
        between = (table @ table.T).astype(np.float64) / n_runs
    with_groups = np.zeros((len(asked), n_groups))
    _gather(keys, asked, start, np.ascontiguousarray(table.T), with_groups)
    return between, with_groups / n_runs


def counted_together(table: IntArray, n_threads: int = 1, *, seen: bool = False) -> FloatArray:
    """(n, n) float64: in how many runs two rows fall in one cluster.

    Parameters
    ----------
    table : (n, n_runs) int
        Cluster of each row in each run; −1 falls in none.
    n_threads : int
        Doesn't change the result.
    seen : bool
        Count the runs that saw both rows instead.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.evidence import counted_together
    >>> table = np.array([[0, 0, 0], [0, 1, -1]])
    >>> counted_together(table).tolist(), counted_together(table, seen=True).tolist()
    ([[3.0, 1.0], [1.0, 2.0]], [[3.0, 2.0], [2.0, 2.0]])
    """
    n = len(table)
    keys = np.ascontiguousarray(table, dtype=np.int32)
    if seen:
        keys = np.minimum(keys, 0)  # so that all that were seen fall in one cluster
    out = np.empty((n, n))
    if n_threads == 1 or n <= BLOCK:
        _count(keys, out, 0, n)
        return out
    with ThreadPoolExecutor(n_threads) as pool:
        for _ in pool.map(lambda first: _count(keys, out, first, min(first + BLOCK, n)), range(0, n, BLOCK)):
            pass
    return out


@kernel
def _count(table, out, first, last):  # type: ignore[no-untyped-def]
    """Runs in which two rows fall in one cluster, of rows from ``first`` to all before."""
    n_runs = table.shape[1]
    for left in range(0, last, BLOCK):  # squares, whose both sides of the diagonal stay in the cache
        right = left + BLOCK
        for i in range(first if first > left else left, last):
            for j in range(left, i + 1 if i < right else right):
                equal = np.int32(0)
                for r in range(n_runs):
                    equal = np.int32(equal + np.int32(table[i, r] == table[j, r] and table[i, r] >= 0))
                out[i, j] = equal
        for j in range(left, right if right < last else last):
            for i in range(first if first > j else j, last):
                out[j, i] = out[i, j]


@kernel
def _fill(keys, weights, part, group, start, table, total):  # type: ignore[no-untyped-def]
    """Weight of each group in each cluster of each run, and altogether."""
    for e in range(len(part)):
        p, g = part[e], group[e]
        total[g] += weights[e]
        for r in range(keys.shape[1]):
            if keys[p, r] >= 0:
                table[g, start[r] + keys[p, r]] += weights[e]


@kernel
def _gather(keys, asked, start, by_cluster, out):  # type: ignore[no-untyped-def]
    """Sum over the runs of what the part's cluster holds of each group."""
    for i in range(len(asked)):
        for r in range(keys.shape[1]):
            k = keys[asked[i], r]
            if k >= 0:
                held = by_cluster[start[r] + k]
                for g in range(len(held)):
                    out[i, g] += held[g]
