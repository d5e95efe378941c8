"""What an ensemble knows about two pieces of surface: the probability that they belong to one thing.

Goes in: how often the runs put two pieces together. Comes out: a probability, calibrated on scans with a
truth. Evidence accumulation: Fred and Jain (2005), IEEE TPAMI 27(6); calibration by a sigmoid: Platt (1999).
"""

from __future__ import annotations

import numba
import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.threads import one_blas_thread

__all__ = ["agreement_behind", "agreement_of_groups", "calibrated", "foreign", "same_thing"]

# The first two are fitted to the default preset on the tuning half of the quality benchmark by
# `python tests/benchmarks/calibration.py`, which also says how they do on the other half: the mean agreement
# is off by 0.13 there on average, the confidence by 0.01. Other presets have not been calibrated.
# CONFIDENCE: for a mean agreement of a face with its segment, the share of the segment's other faces that
# belong with it.
CONFIDENCE = (
    (0.0, 0.2, 0.35, 0.45, 0.55, 0.65, 0.8, 1.0),
    (0.0, 0.332, 0.616, 0.851, 0.854, 0.862, 0.885, 0.891),
)
# SAME_THING: slope and middle of a sigmoid of the mean agreement of two segments, before walls and furniture
# are joined; each pair of faces weighs alike.
SAME_THING = (10.2, 0.451)
# FOREIGN: the share of base segments that are foreign to their segment, divided by (1 − confidence)²; by eye,
# from all scans of the benchmark.
FOREIGN = 1.3


def same_thing(agreement: FloatArray) -> FloatArray:
    """Probability that two segments which the consensus left apart are one thing.

    Parameters
    ----------
    agreement : (…) float
        Mean co-association between the two, 0 to 1.

    Returns
    -------
    probability : (…) float64
        Of a pair of faces, one of each, rising with the agreement.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.evidence import same_thing
    >>> same_thing(np.array([0.1, 0.45, 0.9])).round(2).tolist()
    [0.03, 0.5, 0.99]
    """
    slope, middle = SAME_THING
    return np.asarray(1.0 / (1.0 + np.exp(-slope * (np.asarray(agreement, np.float64) - middle))))


def calibrated(agreement: FloatArray) -> FloatArray:
    """Confidence: the probability that a face and another one of its segment belong to one thing.

    Parameters
    ----------
    agreement : (…) float
        Mean co-association of a face's item with its segment, 0 to 1.

    Returns
    -------
    confidence : (…) float64
        Rising with the agreement; straight lines between the knots.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.evidence import calibrated
    >>> calibrated(np.array([0.0, 0.35, 1.0])).round(3).tolist()
    [0.0, 0.616, 0.891]
    """
    return np.asarray(np.interp(agreement, *CONFIDENCE))


def agreement_behind(confidence: FloatArray) -> FloatArray:
    """The agreement of which `calibrated` makes this confidence.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.evidence import agreement_behind, calibrated
    >>> agreement_behind(calibrated(np.array([0.1, 0.4]))).round(6).tolist()
    [0.1, 0.4]
    """
    return np.asarray(np.interp(confidence, *CONFIDENCE[::-1]))


def foreign(confidence: FloatArray) -> FloatArray:
    """Probability that a part as a whole is foreign to its segment, so that it is right to take it off.

    Less than the probability that a pair of faces is wrongly joined: most wrong pairs are between things
    that meet in one segment, few between a part and all the rest.

    Parameters
    ----------
    confidence : (…) float
        Mean over the part.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.evidence import foreign
    >>> foreign(np.array([0.3, 0.9])).round(3).tolist()
    [0.637, 0.013]
    """
    return np.asarray(np.minimum(FOREIGN * (1.0 - np.asarray(confidence, np.float64)) ** 2, 1.0))


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
