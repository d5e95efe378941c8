"""k-medoids on a matrix of distances.

Goes in: distances between items and k. Come out: labels and medoids. Park and Jun (2009), Expert Systems
with Applications 36(2); thesis 3.4, Algorithm 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from scenewidget.engine.checks import checked_whole
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import IntArray

__all__ = ["BACKENDS", "INITS", "TIES", "KMedoidsResult", "alternate", "initial_medoids", "k_medoids"]

Init = Literal["random", "systematic", "sample", "outmost", "k-medoids++"]
INITS: tuple[Init, ...] = ("random", "systematic", "sample", "outmost", "k-medoids++")
Ties = Literal["stay", "first"]
TIES: tuple[Ties, ...] = ("stay", "first")
BACKENDS = ("numpy", "sklearn-extra")
MAX_ITER = 100


@dataclass(frozen=True, eq=False)
class KMedoidsResult:
    """One clustering.

    Attributes
    ----------
    labels : (n,) int32
        Position in ``medoids`` of each item's nearest medoid; of equally near ones the first. A medoid
        always carries its own label. -1 where no medoid can be reached.
    medoids : (k,) int32
        Items that stand for the clusters.
    cost : float
        Sum of the distances to the medoids, over the items that reach one.
    n_iter : int
        Updates of the medoids, the last of which did not lower the cost.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.kmedoids import k_medoids
    >>> place = np.array([0.0, 1.0, 2.0, 10.0, 11.0, 12.0])
    >>> result = k_medoids(np.abs(place[:, None] - place), 2)
    >>> result.cost, sorted(result.medoids.tolist())
    (4.0, [1, 4])
    """

    labels: IntArray
    medoids: IntArray
    cost: float
    n_iter: int


def k_medoids(
    D: np.ndarray[Any, np.dtype[np.floating[Any]]],
    k: int,
    *,
    init: Init = "random",
    ties: Ties = "stay",
    backend: Literal["numpy", "sklearn-extra"] = "numpy",
    seed: int | np.random.SeedSequence = 0,
) -> KMedoidsResult:
    """Cluster items around k of them: assign to the nearest medoid, move each medoid to the most central
    member, until the cost no longer falls.

    Parameters
    ----------
    D : (n, n) float
        Distances; ``inf`` where unconnected. Sums are taken in float64 whatever its dtype.
    k : int
        Clusters, 1 to n.
    init : str
        The four ways of Park and Jun, section 3.4: "random" (Method 1, the thesis' choice), "systematic"
        (every n/k-th item by ascending total distance), "sample" (the medoids of a random 10 %), "outmost"
        (the k items farthest from the most central one; of unconnected parts each has a centre of its own,
        and the farthest item of each comes first, the largest parts before the smaller); and
        "k-medoids++" (each next one drawn with probability proportional to its squared distance to the
        chosen ones; Arthur and Vassilvitskii 2007).
    ties : str
        Where a medoid goes when several members share the least sum of distances. "first", as Algorithm 2
        of the thesis is printed: the medoid is the first member with the minimum, and what the last update
        gives is the result, though it costs as much as the one before. "stay": a medoid that has the
        minimum stays, and an update that does not lower the cost is undone, as in scikit-learn-extra.
        Coplanar items are at nearly no distance under the thesis' f2, so ties are common there. Under both
        rules an item at one distance from several medoids goes to the first of them, a medoid to itself,
        and no more than 100 updates are made.
    backend : str
        "numpy" is ours; "sklearn-extra" runs ``sklearn_extra.cluster.KMedoids(method="alternate")`` from
        the same initial medoids; it knows ``ties="stay"`` only.
    seed : int or SeedSequence

    Returns
    -------
    KMedoidsResult

    Raises
    ------
    ValueError
        D isn't square or holds NaN or negative values, k is out of range, or no such rule or backend.
    ImportError
        The backend isn't installed.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.kmedoids import k_medoids
    >>> place = np.array([0.0, 1.0, 2.0, 10.0, 11.0, 12.0])
    >>> result = k_medoids(np.abs(place[:, None] - place), 2)
    >>> sorted(result.medoids.tolist()), result.cost
    ([1, 4], 4.0)
    """
    D = _checked_distances(D)
    n = len(D)
    k = checked_whole("k", k)
    if not 1 <= k <= n:
        raise ValueError(f"k must lie in 1..{n} (the number of items), got {k}")
    if backend not in BACKENDS:
        raise ValueError(f"backend must be one of {', '.join(map(repr, BACKENDS))}, got {backend!r}")
    if ties not in TIES:
        raise ValueError(f"ties must be one of {', '.join(map(repr, TIES))}, got {ties!r}")
    if backend == "sklearn-extra" and ties != "stay":
        raise ValueError(f"backend='sklearn-extra' knows ties='stay' only, got {ties!r}; use backend='numpy'")
    medoids = initial_medoids(D, k, init=init, seed=seed)
    if backend == "sklearn-extra":
        return _sklearn_extra(D, medoids)
    return alternate(D, medoids, ties)


def alternate(
    D: np.ndarray[Any, np.dtype[np.floating[Any]]], medoids: IntArray, ties: Ties = "stay"
) -> KMedoidsResult:
    """Algorithm 2 from given medoids, without checks: the inner loop of an ensemble, which holds no lock.

    Parameters
    ----------
    D : (n, n) float
        Distances, symmetric.
    medoids : (k,) int32
        Different items.
    ties : str
        See `k_medoids`.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.kmedoids import alternate
    >>> place = np.array([0.0, 1.0, 2.0, 10.0, 11.0, 12.0])
    >>> alternate(np.abs(place[:, None] - place), np.array([0, 1])).labels.tolist()
    [0, 0, 0, 1, 1, 1]
    """
    return KMedoidsResult(*_run(D, medoids, ties == "first"))


def initial_medoids(
    D: np.ndarray[Any, np.dtype[np.floating[Any]]],
    k: int,
    *,
    init: Init = "random",
    seed: int | np.random.SeedSequence = 0,
) -> IntArray:
    """(k,) int32 distinct items to start from; see `k_medoids` for the ways.

    Parameters
    ----------
    D : (n, n) float
        Distances, symmetric.
    k : int
    init : str
    seed : int or SeedSequence

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.kmedoids import initial_medoids
    >>> place = np.array([0.0, 1.0, 2.0, 10.0, 11.0, 12.0])
    >>> len(set(initial_medoids(np.abs(place[:, None] - place), 3, init="outmost").tolist()))
    3
    """
    rng = np.random.default_rng(seed)
    n = len(D)
    if init == "random":
        return rng.choice(n, size=k, replace=False).astype(np.int32)
    if init == "systematic":
        by_total = np.argsort(_finite_totals(D), kind="stable")
        return np.asarray(by_total[(np.arange(k) * n) // k], dtype=np.int32)
    if init == "sample":
        sample = np.sort(rng.choice(n, size=min(n, max(k, -(-n // 10))), replace=False))
        start = rng.choice(len(sample), size=k, replace=False).astype(np.int32)
        inner = np.ascontiguousarray(D[np.ix_(sample, sample)])
        return np.asarray(sample[_run(inner, start, False)[1]], dtype=np.int32)
    if init == "outmost":
        return _outmost(D, k)
    if init == "k-medoids++":
        chosen = [int(rng.integers(n))]
        nearest = D[chosen[0]].astype(np.float64)
        for _ in range(k - 1):
            unreached = np.isinf(nearest)
            weight = unreached.astype(np.float64) if unreached.any() else nearest**2
            weight[chosen] = 0.0
            if not weight.sum() > 0:
                weight = np.ones(n)
                weight[chosen] = 0.0
            chosen.append(int(rng.choice(n, p=weight / weight.sum())))
            nearest = np.minimum(nearest, D[chosen[-1]])
        return np.array(chosen, dtype=np.int32)
    raise ValueError(f"init must be one of {', '.join(map(repr, INITS))}, got {init!r}")


def _outmost(D: Any, k: int) -> IntArray:
    """The k items farthest from the centre of their part, one of each part first."""
    reach = np.isfinite(D)
    totals = np.where(reach, D, 0.0).sum(axis=1, dtype=np.float64)
    part = reach.argmax(axis=1)  # the first item that is within reach
    is_first = np.zeros(len(D), dtype=bool)
    away = np.empty(len(D))
    for first in np.unique(part):
        inside = np.flatnonzero(part == first)
        center = inside[np.argmin(totals[inside])]
        away[inside] = D[center, inside]
        is_first[inside[np.argmax(away[inside])]] = True
    size = np.bincount(part, minlength=len(D))[part]
    order = np.lexsort((-away, np.where(is_first, -size, 0), ~is_first))
    return np.asarray(order[:k], dtype=np.int32)


def _finite_totals(D: Any) -> Any:
    """Sum of the distances to all, unreachable ones counted as twice the longest."""
    finite = np.isfinite(D)
    if finite.all():
        return D.sum(axis=1, dtype=np.float64)
    return np.where(finite, D, 2.0 * D[finite].max(initial=1.0)).sum(axis=1, dtype=np.float64)


def _checked_distances(D: Any) -> Any:
    D = np.asarray(D)
    if D.dtype not in (np.float32, np.float64):
        D = D.astype(np.float64)
    if D.ndim != 2 or D.shape[0] != D.shape[1] or D.shape[0] == 0:
        raise ValueError(f"D must be a square matrix of distances, got shape {D.shape}")
    if not D.min() >= 0:  # NaN fails too
        raise ValueError("D must hold distances: no negative values and no NaN (inf means unconnected)")
    return np.ascontiguousarray(D)


def _sklearn_extra(D: Any, medoids: IntArray) -> KMedoidsResult:
    try:
        from sklearn_extra.cluster import KMedoids  # type: ignore[import-not-found,unused-ignore]
    except (ImportError, ValueError) as error:  # ValueError: its 0.3.0 wheel was built for numpy 1
        raise ImportError(
            'backend="sklearn-extra" needs scikit-learn-extra, whose wheels want Python 3.11 and numpy < 2: '
            'pip install "scikit-learn-extra==0.3.0" "numpy<2", or use backend="numpy", the same algorithm'
        ) from error

    class FromMedoids(KMedoids):  # type: ignore[misc]
        def _initialize_medoids(self, *_: Any, **__: Any) -> IntArray:
            return medoids.astype(np.int64)

    model = FromMedoids(n_clusters=len(medoids), metric="precomputed", method="alternate", max_iter=MAX_ITER)
    model.fit(D)
    found = np.asarray(model.medoid_indices_, dtype=np.int32)
    labels = np.asarray(model.labels_, dtype=np.int32)
    cost = float(D[np.arange(len(D)), found[labels]].sum(dtype=np.float64))
    return KMedoidsResult(labels, found, cost, int(model.n_iter_))


def _run(D: Any, medoids: IntArray, to_first: bool) -> tuple[IntArray, IntArray, float, int]:
    """Labels, medoids, cost and number of updates: assignments and updates in turn.

    Each looks only where something has changed since the one before.
    """
    n, k = len(D), len(medoids)
    medoids = np.array(medoids, dtype=np.int32)
    first, nearest, bound = np.zeros(n, np.int32), np.empty(n, D.dtype), np.zeros(n)
    labels, trial_labels = np.empty((2, n), np.int32)
    before = np.full(n, -1, np.int32)
    scratch, starts = np.empty((4, n), np.int32), np.empty((2, k + 2), np.int64)
    has_moved = np.ones(k + 1, np.bool_)
    cost = _assign(D, medoids, has_moved, first, nearest, labels, scratch[0])
    n_iter = 0
    while n_iter < MAX_ITER:
        trial = medoids.copy()
        _update(D, trial, labels, before, bound, to_first, scratch, starts)
        has_moved[:k], has_moved[k] = trial != medoids, False
        trial_cost = _assign(D, trial, has_moved, first, nearest, trial_labels, scratch[0])
        n_iter += 1
        is_lower = trial_cost < cost
        if is_lower or (to_first and trial_cost == cost):
            cost, medoids = trial_cost, trial
            before, labels, trial_labels = labels, trial_labels, before
        if not is_lower:
            break
    return labels, medoids, float(cost), n_iter


@kernel
def _assign(D, medoids, has_moved, first, nearest, labels, lost):  # type: ignore[no-untyped-def]
    """Label of the nearest medoid and the cost; ties go to the first medoid, medoids to themselves.

    ``first`` and ``nearest`` hold the first of the nearest medoids and its distance: those of the medoids
    before, on return those of these. Only items whose medoid has moved are compared with all of them.
    """
    n, k = len(D), len(medoids)
    n_lost = 0
    for i in range(n):
        if has_moved[first[i]]:
            first[i], nearest[i] = k, np.inf
            lost[n_lost] = i
            n_lost += 1
    for c in range(k):
        row = D[medoids[c]]
        if has_moved[c]:
            for i in range(n):
                if row[i] < nearest[i] or (row[i] == nearest[i] and c < first[i]):
                    nearest[i] = row[i]
                    first[i] = c
        else:
            for e in range(n_lost):
                i = lost[e]
                if row[i] < nearest[i] or (row[i] == nearest[i] and c < first[i]):
                    nearest[i] = row[i]
                    first[i] = c
    for i in range(n):
        labels[i] = first[i]
    for c in range(k):
        labels[medoids[c]] = c
    cost = 0.0
    for i in range(n):
        if nearest[i] == np.inf:
            labels[i] = -1
        else:
            cost += np.float64(D[medoids[labels[i]], i])
    return cost


@kernel
def _update(D, medoids, labels, before, bound, to_first, scratch, starts):  # type: ignore[no-untyped-def]
    """Move each medoid to the member with the least sum of distances; of equal ones see `k_medoids`.

    ``before`` holds the labels of the update before, after which clusters with the same members need none;
    ``bound`` what each item's sum was then found to be at least, on return what it is now.
    """
    n, k = len(D), len(medoids)
    members, leavers, farthest_first, place = scratch[0], scratch[1], scratch[2], scratch[3]
    start, left_at = starts[0], starts[1]  # of the members of each cluster, and of those who left it
    for c in range(k + 2):
        start[c], left_at[c] = 0, 0
    for i in range(n):
        if labels[i] >= 0:
            start[labels[i] + 2] += 1
        if before[i] >= 0 and before[i] != labels[i]:
            left_at[before[i] + 2] += 1
    for c in range(2, k + 2):
        start[c] += start[c - 1]
        left_at[c] += left_at[c - 1]
    for i in range(n):
        if labels[i] >= 0:
            members[start[labels[i] + 1]] = i
            start[labels[i] + 1] += 1
        if before[i] >= 0 and before[i] != labels[i]:
            leavers[left_at[before[i] + 1]] = i
            left_at[before[i] + 1] += 1
    for c in range(k):
        begin, end = start[c], start[c + 1]
        n_came = np.int64(0)
        for e in range(begin, end):
            n_came += before[members[e]] != c
        left_from, left_to = left_at[c], left_at[c + 1]
        if n_came + left_to - left_from == 0:
            continue
        _carry_over(
            D,
            members,
            begin,
            end,
            before,
            c,
            leavers,
            left_at[c],
            left_at[c + 1],
            n_came,
            farthest_first,
            bound,
        )
        own = D[medoids[c]]
        best, farthest = 0.0, 0.0
        for e in range(begin, end):
            distance = np.float64(own[members[e]])
            best += distance
            if distance > farthest:
                farthest = distance
        _farthest_first(own, members, begin, end, farthest, farthest_first, place)
        for e in range(begin, end):
            i = members[e]
            wins_ties = to_first and i < medoids[c]
            if bound[i] > best or (bound[i] == best and not wins_ties):
                continue
            row = D[i]
            total, at = 0.0, begin
            while at < end:  # sums only grow: stop once the best is passed
                stop = at + 32 if at + 32 < end else end
                while at < stop:
                    total += np.float64(row[farthest_first[at]])
                    at += 1
                if total * (1.0 - 1e-10) > best:
                    break
            bound[i] = total * (1.0 - 1e-10)
            if bound[i] <= best:
                total = 0.0
                for at in range(begin, end):  # in one order for all, so that equal ones come out equal
                    total += np.float64(row[members[at]])
                if total < best or (wins_ties and total == best):
                    best = total
                    medoids[c] = i


@kernel
def _carry_over(  # type: ignore[no-untyped-def]
    D, members, begin, end, before, cluster, leavers, left_from, left_to, n_came, came, bound
):
    """Bounds of the members' sums after some have come and some have left, with room for rounding."""
    if 4 * (n_came + left_to - left_from) > end - begin:
        for e in range(begin, end):
            bound[members[e]] = 0.0  # as much work as new sums
        return
    n_came = 0
    for e in range(begin, end):
        if before[members[e]] != cluster:
            came[n_came] = members[e]
            bound[members[e]] = 0.0
            n_came += 1
    for e in range(begin, end):
        i = members[e]
        if before[i] == cluster:
            row = D[i]
            more, less = 0.0, 0.0
            for a in range(n_came):
                more += np.float64(row[came[a]])
            for a in range(left_from, left_to):
                less += np.float64(row[leavers[a]])
            bound[i] = (bound[i] + more) * (1.0 - 1e-10) - less * (1.0 + 1e-10)


@kernel
def _farthest_first(own, members, begin, end, farthest, out, count):  # type: ignore[no-untyped-def]
    """Members roughly by falling distance, which brings hopeless sums past the best soonest."""
    n_bins = end - begin if end - begin < 64 else 64
    scale = (n_bins - 0.5) / farthest if 0.0 < farthest < np.inf else 0.0
    for b in range(n_bins):
        count[b] = 0
    for way in range(2):
        for e in range(end - 1, begin - 1, -1):
            place = np.float64(own[members[e]]) * scale
            b = n_bins - 1 - int(place) if place < n_bins else 0
            if way == 0:
                count[b] += 1
            else:
                count[b] -= 1
                out[begin + count[b]] = members[e]
        if way == 0:
            for b in range(1, n_bins):
                count[b] += count[b - 1]
