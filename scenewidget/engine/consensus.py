"""Consensus of an ensemble: from the keys of its runs to one partition.

Goes in: a label per item and run. Come out: base segments (items with equal keys), how often they fall
together, a partition of them by probabilistic evidence accumulation in each component, or as the median
partition (thesis 3.5). Partitions by a cut of a merge tree are in `linkage`; how far to trust segments, in
`doubt`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy import sparse

from scenewidget.engine.allocation import allocate
from scenewidget.engine.atoms import by_first_appearance
from scenewidget.engine.checks import warn_caller
from scenewidget.engine.evidence import counted_together
from scenewidget.engine.kernels import kernel
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.peac import PeacResult, peac

__all__ = [
    "CoAssociation",
    "Leftover",
    "base_segments",
    "co_association",
    "component_trees",
    "median_partition",
    "peac",
    "peac_by_component",
    "settle_leftovers",
]

Leftover = Literal["alone", "argmax", "linkage"]


class CoAssociation(NamedTuple):
    """How often base segments fall together.

    Attributes
    ----------
    C : (n_base, n_base) float64
        Share of the runs that saw both in which they share a cluster; 0 where none saw both.
    weights : (n_base,) float64
        Sum of the items' weights in each base segment.
    base : (n_items,) int32
        Base segment of each item, numbered by first appearance.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.consensus import co_association
    >>> co = co_association(np.array([[0, 0], [0, 1], [1, 1], [1, 1]]))
    >>> co.base.tolist(), co.C.tolist()
    ([0, 1, 2, 2], [[1.0, 0.5, 0.0], [0.5, 1.0, 0.5], [0.0, 0.5, 1.0]])
    >>> co.between(np.array([0, 0, 1, 1]), np.ones(4), 2).tolist()
    [[3.0, 1.0], [1.0, 4.0]]
    """

    C: FloatArray
    weights: FloatArray
    base: IntArray

    def between(self, groups: IntArray, areas: FloatArray, n_groups: int) -> FloatArray:
        """(n_groups, n_groups) sums over pairs of items, one of each group: both areas times co-association.

        Over the areas of both groups these are means: the share of the runs that put them together.

        Parameters
        ----------
        groups : (n_items,) int
            −1 for items in none.
        areas : (n_items,) float64
        n_groups : int
        """
        member = self._member(groups, areas, n_groups)
        return np.asarray(member.T @ np.asarray((member.T @ self.C).T))

    def _member(self, groups: IntArray, areas: FloatArray, n_groups: int) -> sparse.csr_array:
        """(n_base, n_groups) area of each base segment in each group."""
        keep = groups >= 0
        entries = (areas[keep], (self.base[keep], groups[keep]))
        return sparse.csr_array(entries, shape=(len(self.weights), n_groups))

    def within(self, component: IntArray) -> tuple[IntArray, ...]:
        """Base segments of each component; none lies in two.

        Parameters
        ----------
        component : (n_items,) int
        """
        of_base = np.zeros(len(self.weights), dtype=np.int64)
        of_base[self.base] = component
        return tuple(np.flatnonzero(of_base == c) for c in range(int(component.max()) + 1))

    def among(self, inside: IntArray) -> FloatArray:
        """(n_inside, n_inside) C of some base segments.

        Parameters
        ----------
        inside : (n_inside,) int
            Ascending.
        """
        is_all = len(inside) == len(self.weights)
        return self.C if is_all else np.ascontiguousarray(self.C[np.ix_(inside, inside)])


def base_segments(keys: IntArray) -> IntArray:
    """(n_items,) int32: items with equal keys get equal numbers, by first appearance (Eq. 3.10).

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.consensus import base_segments
    >>> base_segments(np.array([[0, 0], [0, 1], [0, 0]])).tolist()
    [0, 1, 0]
    """
    keys = np.ascontiguousarray(keys, dtype=np.int32)
    if keys.ndim != 2:
        raise ValueError(f"keys must have shape (n_items, n_runs), got {keys.shape}")
    if keys.shape[1] == 0:
        return np.zeros(len(keys), dtype=np.int32)
    rows = keys.view(np.dtype((np.void, keys.itemsize * keys.shape[1]))).ravel()
    return by_first_appearance(rows)


def co_association(keys: IntArray, weights: FloatArray | None = None, *, n_threads: int = 2) -> CoAssociation:
    """Co-association matrix of the base segments of an ensemble.

    Parameters
    ----------
    keys : (n_items, n_runs) int
        Cluster of each item in each run; −1 where the run did not see the item (partial evidence).
    weights : (n_items,) float, optional
        Areas; 1 each by default.
    n_threads : int
        Doesn't change the result.

    Returns
    -------
    CoAssociation
        A named tuple (C, weights, base).

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.consensus import co_association
    >>> keys = np.array([[0, 0, 0], [0, 0, 1], [1, 1, 1]])  # three items in three runs
    >>> co_association(keys).C.round(2).tolist()
    [[1.0, 0.67, 0.0], [0.67, 1.0, 0.33], [0.0, 0.33, 1.0]]
    """
    keys = np.asarray(keys)
    if keys.ndim != 2 or keys.dtype.kind not in "iu":
        raise ValueError(
            f"keys must be whole numbers of shape (n_items, n_runs), got {keys.shape} {keys.dtype}"
        )
    if keys.shape[1] == 0:
        raise ValueError("keys has no runs: an ensemble needs at least one")
    if len(keys) == 0:
        raise ValueError("keys has no items")
    weights = np.ones(len(keys)) if weights is None else np.asarray(weights, dtype=np.float64)
    if weights.shape != (len(keys),):
        raise ValueError(f"weights must have one entry an item: ({len(keys)},), got {weights.shape}")
    if not (weights.min() >= 0 and np.isfinite(weights).all()):
        raise ValueError("weights must be finite and not negative")
    base = base_segments(keys)
    n_base = int(base.max()) + 1
    first = np.full(n_base, len(base), dtype=np.int64)
    np.minimum.at(first, base, np.arange(len(base)))
    table = np.ascontiguousarray(keys[first], dtype=np.int32)
    C = counted_together(table, n_threads)  # dense (n_base, n_base) float64: 800 MB at 10 000
    if table.min() >= 0:
        C /= keys.shape[1]
    else:
        seen = counted_together(table, n_threads, seen=True)
        np.divide(C, seen, out=C, where=seen > 0)
    return CoAssociation(C, np.bincount(base, weights, n_base).astype(np.float64), base)


def component_trees(
    co: CoAssociation, component: IntArray, *, monitor: Monitor | None = None
) -> tuple[FloatArray, ...]:
    """Merge tree of the base segments of each component, from which `peac` starts whatever S is.

    Parameters
    ----------
    co : CoAssociation
    component : (n_items,) int
        From 0.
    monitor : Monitor, optional

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.consensus import co_association, component_trees
    >>> co = co_association(np.array([[0, 0], [0, 1], [1, 2]]))
    >>> [len(tree) for tree in component_trees(co, np.array([0, 0, 1]))]
    [1, 0]
    """
    monitor = monitor or SILENT
    trees = []
    for inside in co.within(component):
        monitor.tick()
        weights = co.weights[inside]
        trees.append(average_linkage(co.among(inside), weights / (weights.sum() or 1.0)))
    return tuple(trees)


def peac_by_component(
    co: CoAssociation,
    component: IntArray,
    share: FloatArray,
    n_segments: int | Literal["auto"],
    *,
    trees: Sequence[FloatArray],
    leftover: Leftover = "alone",
    seed: int = 0,
    monitor: Monitor | None = None,
) -> IntArray:
    """Partition by `peac` in each component with its share of S (thesis 3.1, 3.5).

    Parameters
    ----------
    co : CoAssociation
    component : (n_items,) int
        From 0.
    share : (n_components,) float64
        Of `allocation.component_shares`.
    n_segments : int or "auto"
        S, shared out as ``share`` says; "auto" takes in each component the number of clusters of its
        `median_partition`. That minimises the same distance to the runs (Eq. 3.11) over partitions into any
        number of clusters, and so needs none: Gionis, Mannila and Tsaparas (2007), ACM TKDD 1(1); Goder and
        Filkov (2008), ALENEX.
    trees : sequence of (n_base − 1, 4) float64
        Of `component_trees`.
    leftover : str
        See `settle_leftovers`.
    seed : int
        Each component draws from a generator of its own.
    monitor : Monitor, optional

    Returns
    -------
    labels : (n_base,) int32
        Dense.

    Warns
    -----
    UserWarning
        Much of the area is left over, or a component did not converge.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.consensus import co_association, component_trees, peac_by_component
    >>> co = co_association(np.array([[0, 0], [0, 0], [1, 1], [2, 2]]))
    >>> component = np.array([0, 0, 0, 1])
    >>> trees = component_trees(co, component)
    >>> peac_by_component(co, component, np.array([0.7, 0.3]), 3, trees=trees).tolist()
    [0, 1, 2]
    """
    out = np.empty(len(co.weights), dtype=np.int32)
    labels: IntArray
    offset, left, unsolved = 0, 0.0, 0
    members = co.within(component)
    if n_segments == "auto":
        counts = np.array([_natural_number(co, inside, seed) for inside in members])
    else:
        counts = allocate(n_segments, share, np.array([len(inside) for inside in members]))
    for c, (inside, count) in enumerate(zip(members, counts, strict=True)):
        weights = co.weights[inside]
        if count <= 1 or len(inside) == 1 or not weights.sum() > 0:
            labels = np.zeros(len(inside), dtype=np.int32)
        else:
            C, child = co.among(inside), np.random.SeedSequence(seed, spawn_key=(c,))
            result = peac(C, weights, int(count), tree=trees[c], seed=child, monitor=monitor)
            labels, part = settle_leftovers(result, C, weights, leftover)
            left += part * float(weights.sum())
            unsolved += not result.converged
        out[inside] = labels + offset
        offset += int(labels.max()) + 1
    total = float(co.weights.sum())
    if total > 0 and left > 0.05 * total:
        warn_caller(
            f"{left / total:.0%} of the area has no cluster with a probability of at least ½; "
            "raise n_segments, or join what is left over: leftover='argmax' gives it to the likeliest "
            "cluster, leftover='linkage' groups it"
        )
    if unsolved:
        warn_caller(
            f"the consensus did not converge in {unsolved} of {len(counts)} components, so its segments hang "
            "on the seed more than they should; try another seed, or consensus='linkage'"
        )
    return out


def _natural_number(co: CoAssociation, inside: IntArray, seed: int) -> int:
    """Clusters of the median partition of some base segments."""
    weights = co.weights[inside]
    if not weights.sum() > 0:
        return 1
    return int(median_partition(co.among(inside), weights / weights.sum(), seed=seed).max()) + 1


def settle_leftovers(
    result: PeacResult, C: FloatArray, weights: FloatArray, rule: Leftover = "alone"
) -> tuple[IntArray, float]:
    """Labels from soft assignments; ``rule`` says what becomes of columns whose largest entry is below ½.

    Parameters
    ----------
    result : PeacResult
    C : (n_base, n_base) float
        What it was solved for.
    weights : (n_base,) float
    rule : str
        "alone": a segment of its own (thesis 3.5); "argmax": the largest entry all the same; "linkage":
        they are grouped among themselves and with the settled clusters by average linkage at ½.

    Returns
    -------
    labels : (n_base,) int32
        Dense.
    share : float
        Share of the weight in such columns.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.consensus import settle_leftovers
    >>> from scenewidget.engine.peac import PeacResult
    >>> C = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.5, 0.5, 1.0]])
    >>> Y = np.array([[1.0, 0.0, 0.4], [0.0, 1.0, 0.3], [0.0, 0.0, 0.3]])  # the third belongs nowhere
    >>> result = PeacResult(Y, np.array([0, 1, 0]), 0.0, 0.0, True, 1)
    >>> [settle_leftovers(result, C, np.ones(3), rule)[0].tolist() for rule in ("alone", "argmax")]
    [[0, 1, 2], [0, 1, 0]]
    """
    is_left = result.Y.max(axis=0) < 0.5
    labels = result.labels.astype(np.int64)
    n_left = int(is_left.sum())
    m = len(result.Y)
    if rule in ("alone", "linkage"):
        labels[is_left] = m + np.arange(n_left)
    elif rule != "argmax":
        raise ValueError(f"leftover must be 'alone', 'argmax' or 'linkage', got {rule!r}")
    if rule == "linkage" and n_left:
        groups, inverse = np.unique(labels, return_inverse=True)
        member = np.zeros((len(groups), len(labels)))
        member[inverse, np.arange(len(labels))] = weights
        mass = member.sum(axis=1)
        safe = np.where(mass > 0, mass, 1.0)
        mean = member @ C @ member.T / (safe[:, None] * safe[None, :])
        settled = groups < m
        mean[np.ix_(settled, settled)] = -1e15  # settled clusters stay apart, whatever stands between them
        np.fill_diagonal(mean, 1.0)
        labels = cut_tree(average_linkage(mean, mass), similarity=0.5)[inverse].astype(np.int64)
    _, dense = np.unique(labels, return_inverse=True)
    total = float(np.sum(weights))
    return dense.astype(np.int32), float(weights[is_left].sum()) / total if total > 0 else 0.0


def median_partition(C: FloatArray, weights: FloatArray, *, seed: int = 0, max_sweeps: int = 100) -> IntArray:
    """Partition that agrees most with the ensemble: correlation clustering of C at ½, no number needed.

    Minimises Σ w_ij (c_ij − [same label])², which is the sum of the (weighted Mirkin) distances to all
    runs, by moving single base segments to where they gain most, from the average-linkage cut at ½.

    Parameters
    ----------
    C : (n_base, n_base) float
    weights : (n_base,) float
    seed : int
        Decides the order in which base segments are tried.
    max_sweeps : int
        Most passes over all base segments.

    Returns
    -------
    labels : (n_base,) int32
        Dense, numbered by first appearance. No single move improves it further.

    References
    ----------
    Goder and Filkov (2008), ALENEX: "best one element moves".

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.consensus import median_partition
    >>> C = np.array([[1.0, 0.8, 0.2], [0.8, 1.0, 0.4], [0.2, 0.4, 1.0]])
    >>> median_partition(C, np.ones(3)).tolist()
    [0, 0, 1]
    """
    C = np.ascontiguousarray(C, dtype=np.float64)
    a = np.ascontiguousarray(weights, dtype=np.float64)
    labels = cut_tree(average_linkage(C, a), similarity=0.5)
    labels = _best_moves(
        C, a, labels.astype(np.int64), np.random.default_rng(seed).permutation(len(C)), max_sweeps
    )
    return by_first_appearance(labels)


@kernel(allocates=True)
def _best_moves(C, a, labels, order, max_sweeps):  # type: ignore[no-untyped-def]
    n = len(a)
    gain = np.zeros((n, n))  # gain[i, l] = Σ_j a_j (C_ij − ½) over the members of cluster l
    for i in range(n):
        for j in range(n):
            if i != j:
                gain[i, labels[j]] += a[j] * (C[i, j] - 0.5)
    count = np.zeros(n, dtype=np.int64)
    for i in range(n):
        count[labels[i]] += 1
    for _ in range(max_sweeps):
        moved = False
        for i in order:
            old = labels[i]
            best, new = gain[i, old] + 1e-12, old
            for c in range(n):
                value = gain[i, c] if count[c] > 0 else 0.0
                if value > best:
                    best, new = value, c
            if new != old:
                moved = True
                labels[i] = new
                count[old] -= 1
                count[new] += 1
                for j in range(n):
                    if j != i:
                        change = a[i] * (C[j, i] - 0.5)
                        gain[j, old] -= change
                        gain[j, new] += change
        if not moved:
            break
    return labels
