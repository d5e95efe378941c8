"""What an ensemble knows about groups of pieces: how often its runs put them together.

Goes in: keys of the pieces, and the group of each. Comes out: mean co-association between groups. Evidence
accumulation: Fred and Jain (2005), IEEE TPAMI 27(6).
"""

from __future__ import annotations

import numba
import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.threads import one_blas_thread

__all__ = ["agreement_of_groups"]


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
    return between, _gather(keys, asked, start, np.ascontiguousarray(table.T), n_groups) / n_runs


@numba.njit(cache=True)
def _fill(keys, weights, part, group, start, table, total):  # type: ignore[no-untyped-def]
    """Weight of each group in each cluster of each run, and altogether."""
    for e in range(len(part)):
        p, g = part[e], group[e]
        total[g] += weights[e]
        for r in range(keys.shape[1]):
            if keys[p, r] >= 0:
                table[g, start[r] + keys[p, r]] += weights[e]


@numba.njit(cache=True)
def _gather(keys, asked, start, by_cluster, n_groups):  # type: ignore[no-untyped-def]
    """Sum over the runs of what the part's cluster holds of each group."""
    out = np.zeros((len(asked), n_groups))
    for i in range(len(asked)):
        for r in range(keys.shape[1]):
            k = keys[asked[i], r]
            if k >= 0:
                out[i] += by_cluster[start[r] + k]
    return out
