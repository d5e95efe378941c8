"""Distances between items: edge costs, and shortest paths over the graph of neighbours.

Goes in: neighbouring pairs with features, normals and centroids. Come out: edge weights (thesis 3.4, Eqs.
3.8 and 3.9) and all-pairs shortest path lengths.

The graph of a surface is nearly planar, so eliminating its nodes in a fill-reducing order leaves a
sparse factor, and shortest paths follow from it as a linear system's solution follows from a Cholesky
factor, with (min, +) in the place of (+, ×): Planken, de Weerdt and van der Krogt (2012), JAIR 43.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from scenewidget.engine.checks import warn_caller
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.threads import n_threads as all_threads

__all__ = [
    "MAX_DENSE_ITEMS",
    "DistancesOnDemand",
    "MinPlusFactor",
    "all_pairs",
    "edge_costs",
    "edge_weights",
    "warn_of_vanishing_features",
    "weight_graph",
]

MAX_DENSE_ITEMS = 40_000  # (n, n) float32 takes 6.4 GB there
STRIP = 64  # sources that are solved together: one strip of (n_items, 64) float32 stays in the cache
LINE = 16  # of them that are written at a time: a line of the cache


def edge_costs(
    normals: FloatArray, pairs: IntArray, *, a: float = 1.0, b: float = -1.0, exponent: float = 1.5
) -> FloatArray:
    """Cost of crossing from one item to its neighbour: max(A + B⟨N_x, N_y⟩, 0)^C.

    Parameters
    ----------
    normals : (n_items, 3) float
        Unit normals; a zero normal (degenerate item) has dot product 0 with all.
    pairs : (n_pairs, 2) int
    a, b, exponent : float
        A, B, C of Eq. 3.9. The thesis' f1 is (1, 0, 1), its f2 is (1, −1, 1.5).

    Returns
    -------
    costs : (n_pairs,) float64

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.distances import edge_costs
    >>> normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    >>> edge_costs(normals, np.array([[0, 1], [1, 2]])).tolist()
    [0.0, 1.0]
    """
    dots = np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]])
    return np.asarray(np.maximum(a + b * np.clip(dots, -1.0, 1.0), 0.0) ** exponent)


def edge_weights(
    feature_steps: FloatArray | None,
    costs: FloatArray,
    lengths: FloatArray,
    *,
    feature_floor: float = 0.0,
    is_convex: BoolArray | None = None,
    convex_weight: float = 1.0,
    hop: float = 0.0,
) -> FloatArray:
    """Weight of each edge of the item graph: w = (d + d0) · cost · (α if convex) + hop.

    With the defaults this is Eq. 3.8 of the thesis, and ``length`` times 1e-12 of the median breaks ties
    between the zero-cost paths that coplanar faces give, in favour of the shorter one.

    Parameters
    ----------
    feature_steps : (n_pairs,) float, optional
        d = ‖f_x − f_y‖; None counts as 1 everywhere, so that the normals alone decide.
    costs : (n_pairs,) float
        Eq. 3.9.
    lengths : (n_pairs,) float
        Distance of the centroids, metres.
    feature_floor : float
        d0 as a share of the 95 % quantile of d, of its largest where that is 0. On clean meshes the
        mean-of-three lift makes d vanish at creases; the floor keeps their normals' cost.
    is_convex : (n_pairs,) bool, optional
    convex_weight : float
        α: what an edge costs when it is convex; below 1 keeps convex things together.
    hop : float
        Added per edge.

    Returns
    -------
    weights : (n_pairs,) float64

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.distances import edge_weights
    >>> options = {"is_convex": np.array([False, True]), "convex_weight": 0.2, "hop": 0.02}
    >>> edge_weights(None, np.array([0.0, 1.0]), np.ones(2), **options).round(3).tolist()
    [0.02, 0.22]
    """
    steps: Any = 1.0 if feature_steps is None else feature_steps
    if feature_steps is not None and feature_floor > 0 and len(feature_steps):
        steps = feature_steps + feature_floor * (np.quantile(feature_steps, 0.95) or feature_steps.max())
    weights = steps * costs
    if is_convex is not None and convex_weight != 1.0:
        weights = np.where(is_convex, convex_weight * weights, weights)
    weights = weights + hop
    median = np.median(lengths[lengths > 0]) if np.any(lengths > 0) else 1.0
    scale = np.median(weights[weights > 0]) if np.any(weights > 0) else 1.0
    return weights + 1e-12 * scale * (lengths / median)  # type: ignore[no-any-return]


def warn_of_vanishing_features(feature_steps: FloatArray, costs: FloatArray) -> None:
    """Say so where features don't see the creases, as δ of a clean mesh: all distances would vanish silently.

    Parameters
    ----------
    feature_steps : (n_pairs,) float
        As of `edge_weights`, with a ``feature_floor`` of 0.
    costs : (n_pairs,) float

    Warns
    -----
    UserWarning
        A fifth of the pairs that cost more than 0.1 have next to no feature step.

    Examples
    --------
    >>> import warnings
    >>> import numpy as np
    >>> from scenewidget.engine.distances import warn_of_vanishing_features
    >>> with warnings.catch_warnings(record=True) as heard:
    ...     warnings.simplefilter("always")
    ...     warn_of_vanishing_features(np.array([0.0, 0.0, 1.0]), np.array([1.0, 1.0, 0.0]))
    >>> str(heard[0].message)[:61]
    '100% of the creases have the same feature on both sides, so d'
    """
    is_crease = costs > 0.1
    if not is_crease.any() or len(feature_steps) == 0:
        return
    flat = float(np.mean(feature_steps[is_crease] <= 1e-6 * np.quantile(feature_steps, 0.95)))
    if flat > 0.2:
        warn_caller(
            f"{flat:.0%} of the creases have the same feature on both sides, so distances ignore them "
            "(clean, noise-free mesh?); feature_floor=0.05 lets the normals count there"
        )


def weight_graph(n_items: int, pairs: IntArray, weights: FloatArray) -> sparse.csr_array:
    """Symmetric (n_items, n_items) csr of edge weights; of duplicate pairs the lightest counts.

    An explicit zero stays an edge of length zero.

    Parameters
    ----------
    n_items : int
    pairs : (n_pairs, 2) int
        Neighbours.
    weights : (n_pairs,) float
        Not negative.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.distances import weight_graph
    >>> weight_graph(3, np.array([[0, 1], [1, 2], [0, 1]]), np.array([2.0, 3.0, 1.0])).toarray().tolist()
    [[0.0, 1.0, 0.0], [1.0, 0.0, 3.0], [0.0, 3.0, 0.0]]
    """
    low, high = pairs.min(axis=1, initial=n_items), pairs.max(axis=1, initial=-1)
    order = np.lexsort((weights, high, low))
    low, high, weights = low[order], high[order], np.asarray(weights, dtype=np.float64)[order]
    keep = np.ones(len(low), dtype=bool)
    keep[1:] = (low[1:] != low[:-1]) | (high[1:] != high[:-1])
    keep &= low != high
    low, high, weights = low[keep], high[keep], weights[keep]
    rows, columns = np.concatenate([low, high]), np.concatenate([high, low])
    data = np.concatenate([weights, weights])
    order = np.lexsort((columns, rows))
    indptr = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=n_items))])
    return sparse.csr_array((data[order], columns[order], indptr), shape=(n_items, n_items))


def all_pairs(
    graph: sparse.csr_array | sparse.csr_matrix,
    *,
    n_threads: int | None = None,
    monitor: Monitor | None = None,
) -> npt_float32:
    """Lengths of the shortest paths between all pairs of nodes.

    Parameters
    ----------
    graph : (n, n) csr
        Non-negative weights of undirected edges; where the two directions differ, the lighter counts.
        Explicit zeros are edges of length zero; of duplicate entries the lightest counts.
    n_threads : int, optional
        Threads; all cores by default. The result does not depend on it.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    Returns
    -------
    distances : (n, n) float32
        Symmetric to the bit, zero diagonal, ``inf`` where unconnected. 400 MB at n = 10 000. Sums along a
        path round differently from its two ends, by up to 5e-7 of the length: the smaller counts.

    Raises
    ------
    ValueError
        Negative or NaN weights, a matrix that isn't square, or more than 40 000 nodes.

    Examples
    --------
    >>> from scipy import sparse
    >>> from scenewidget.engine.distances import all_pairs
    >>> all_pairs(sparse.csr_array([[0.0, 2.0, 0.0], [2.0, 0.0, 3.0], [0.0, 3.0, 0.0]]))
    array([[0., 2., 5.],
           [2., 0., 3.],
           [5., 3., 0.]], dtype=float32)
    """
    n = graph.shape[0]
    if n > MAX_DENSE_ITEMS:
        raise ValueError(
            f"graph has {n} nodes; all pairs would take {4e-9 * n * n:.1f} GB. Lower n_items to at most "
            f"{MAX_DENSE_ITEMS}, or use MinPlusFactor(graph).rows(sources)"
        )
    distances = MinPlusFactor(graph).rows(np.arange(n), n_threads=n_threads, monitor=monitor)
    with ThreadPoolExecutor(n_threads) as pool:
        for _ in pool.map(lambda first: _mirror(distances, first), range(0, n, STRIP)):
            pass
    return distances


npt_float32 = np.ndarray[Any, np.dtype[np.float32]]


@dataclass(frozen=True, eq=False, init=False)
class MinPlusFactor:
    """Sparse (min, +) Cholesky factor of a graph, from which rows of shortest path lengths follow.

    Eliminating a node keeps the shortest paths between the others by joining its neighbours; the factor
    holds each node's edges to the nodes that are eliminated later. A minimum-degree order keeps it sparse
    (7 entries a node on surface meshes).

    Attributes
    ----------
    order : (n,) int32
        The node that is eliminated at each step.
    indptr, indices, values
        Column j: the later steps that step j has edges to, ascending, and their weights (float32).

    Examples
    --------
    >>> import numpy as np
    >>> from scipy import sparse
    >>> from scenewidget.engine.distances import MinPlusFactor
    >>> graph = sparse.csr_array([[0, 2.0, 0], [2.0, 0, 3.0], [0, 3.0, 0]])
    >>> MinPlusFactor(graph).rows(np.array([2])).tolist()
    [[5.0, 3.0, 0.0]]
    """

    order: IntArray
    indptr: IntArray
    indices: IntArray
    values: npt_float32

    def __init__(self, graph: sparse.csr_array | sparse.csr_matrix) -> None:
        coo = _checked(graph)
        n = coo.shape[0]
        position = _elimination_position(coo)
        order = np.argsort(position).astype(np.int32)
        low = np.minimum(position[coo.row], position[coo.col])
        high = np.maximum(position[coo.row], position[coo.col])
        keep = low != high
        low, high, data = low[keep], high[keep], coo.data[keep]
        by = np.lexsort((data, high, low))
        low, high, data = low[by], high[by], data[by].astype(np.float32)
        first = np.ones(len(low), dtype=bool)
        first[1:] = (low[1:] != low[:-1]) | (high[1:] != high[:-1])
        low, high, data = low[first], high[first], data[first]
        indptr = np.concatenate([[0], np.cumsum(np.bincount(low, minlength=n))]).astype(np.int64)
        fill_ptr, fill = _pattern(indptr, high.astype(np.int32))
        values, columns = np.full(len(fill), np.inf, np.float32), np.full((2, n), -1, np.int32)
        where, cursor = np.empty(n, np.int64), fill_ptr[:-1].copy()
        _numeric(indptr, high.astype(np.int32), data, fill_ptr, fill, values, where, columns, cursor)
        for name, array in (("order", order), ("indptr", fill_ptr), ("indices", fill), ("values", values)):
            object.__setattr__(self, name, array)

    def rows(
        self, sources: IntArray, *, n_threads: int | None = None, monitor: Monitor | None = None
    ) -> npt_float32:
        """Shortest path lengths from some nodes to all.

        Parameters
        ----------
        sources : (n_sources,) int
        n_threads : int, optional
            Threads; all cores by default. The result does not depend on it.
        monitor : Monitor, optional
            Told how far it is; stops it on cancel.

        Returns
        -------
        distances : (n_sources, n) float32
        """
        monitor = monitor or SILENT
        n = len(self.order)
        sources = np.asarray(sources)
        if len(sources) and not (sources.min() >= 0 and sources.max() < n):
            raise ValueError(f"sources must lie in 0..{n - 1}, got {sources.min()}..{sources.max()}")
        position = np.empty(n, dtype=np.int32)
        position[self.order] = np.arange(n, dtype=np.int32)
        out = np.empty((len(sources), n), dtype=np.float32)
        by = np.argsort(position[sources], kind="stable")  # neighbours in the order share their upward paths
        strips = [by[i : i + STRIP] for i in range(0, len(by), STRIP)]

        n_workers = min(n_threads or all_threads(), max(1, len(strips)))

        def solve(first: int) -> None:
            paths, is_reached = np.empty((n, STRIP), np.float32), np.empty(n, np.bool_)
            for done in range(first, len(strips), n_workers):
                monitor.tick(done / len(strips))
                steps = position[sources[strips[done]]]
                paths.fill(np.inf)
                paths[steps, np.arange(len(steps))] = 0.0
                is_reached.fill(False)
                is_reached[steps] = True
                _solve_strip(
                    int(steps.min()),
                    strips[done],
                    position,
                    self.indptr,
                    self.indices,
                    self.values,
                    paths,
                    is_reached,
                    out,
                )

        with ThreadPoolExecutor(n_workers) as pool:
            for _ in pool.map(solve, range(n_workers)):
                pass
        monitor.tick(1.0)
        return out


@dataclass(frozen=True, eq=False)
class DistancesOnDemand(Sequence[npt_float32]):
    """Distances between all nodes of several graphs, each (n, n) matrix made when it is asked for.

    At 34 000 nodes it takes 4.6 GB, more than what it is made of takes to make it again is worth.

    Parameters
    ----------
    factors : tuple of MinPlusFactor

    Examples
    --------
    >>> from scipy import sparse
    >>> from scenewidget.engine.distances import DistancesOnDemand, MinPlusFactor
    >>> factor = MinPlusFactor(sparse.csr_array([[0, 2.0], [2.0, 0]]))
    >>> [D.tolist() for D in DistancesOnDemand((factor,))]
    [[[0.0, 2.0], [2.0, 0.0]]]
    """

    factors: tuple[MinPlusFactor, ...]

    def __len__(self) -> int:
        return len(self.factors)

    def __getitem__(self, which: Any) -> Any:
        """(n, n) float32, or of a slice the same of some of the graphs."""
        if isinstance(which, slice):
            return DistancesOnDemand(self.factors[which])
        factor = self.factors[which]
        return factor.rows(np.arange(len(factor.order)), n_threads=all_threads())


def _checked(graph: Any) -> sparse.coo_array:
    if not sparse.issparse(graph):
        raise TypeError(f"graph must be a scipy sparse matrix, got {type(graph).__name__}")
    graph = sparse.coo_array(graph)  # not csr, which would add duplicate entries up
    if graph.ndim != 2 or graph.shape[0] != graph.shape[1]:
        raise ValueError(f"graph must be square, got shape {graph.shape}")
    if graph.nnz and not (graph.data >= 0).all():
        raise ValueError("graph must have non-negative weights, none of them NaN")
    return graph


def _elimination_position(coo: sparse.coo_array) -> IntArray:
    """Step at which each node is eliminated: minimum degree on the pattern, by SuperLU."""
    n = coo.shape[0]
    keep = coo.row != coo.col
    rows = np.concatenate([coo.row[keep], coo.col[keep], np.arange(n)])
    columns = np.concatenate([coo.col[keep], coo.row[keep], np.arange(n)])
    data = np.concatenate([np.full(2 * int(keep.sum()), -1.0), np.full(n, 4.0 * n)])
    pattern = sparse.csc_array((data, (rows, columns)), shape=(n, n))
    lu = splu(pattern, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.asarray(lu.perm_c, dtype=np.int32)


def _pattern(indptr: IntArray, indices: IntArray) -> tuple[IntArray, IntArray]:
    """Pattern of the factor: each column is its own later neighbours and those of its children, ascending."""
    n = len(indptr) - 1
    fill_ptr, state = np.zeros(n + 1, np.int64), np.full((3, n), -1, np.int32)
    fill: IntArray = np.empty(max(16, n, 4 * len(indices)), np.int32)
    done = 0
    while done < n:
        done = _symbolic(done, indptr, indices, fill_ptr, fill, *state)
        if done < n:
            fill = np.concatenate([fill, np.empty(len(fill) + n, np.int32)])
    fill = fill[: fill_ptr[-1]]
    column = np.repeat(np.arange(n) * n, np.diff(fill_ptr))
    return fill_ptr, (np.sort(column + fill) - column).astype(np.int32)


@kernel
def _symbolic(begin, indptr, indices, fill_ptr, fill, mark, first_child, next_child):  # type: ignore[no-untyped-def]
    """Columns from ``begin`` to the one, returned, that might find no room; of a column any order."""
    n = len(mark)
    size = fill_ptr[begin]
    for j in range(begin, n):
        if len(fill) - size < n - j:
            return j
        parent = n
        mark[j] = j
        for e in range(indptr[j], indptr[j + 1]):
            v = indices[e]
            if mark[v] != j:
                mark[v] = j
                fill[size] = v
                size += 1
                if v < parent:
                    parent = v
        child = first_child[j]
        while child >= 0:
            for e in range(fill_ptr[child], fill_ptr[child + 1]):
                v = fill[e]
                if mark[v] != j:
                    mark[v] = j
                    fill[size] = v
                    size += 1
                    if v < parent:
                        parent = v
            child = next_child[child]
        fill_ptr[j + 1] = size
        if parent < n:
            next_child[j] = first_child[parent]
            first_child[parent] = j
    return n


@kernel
def _numeric(  # type: ignore[no-untyped-def]
    indptr, indices, data, fill_ptr, fill, values, where, columns, cursor
):
    """Weights of the factor, column by column: shortest paths through eliminated nodes."""
    first_column, next_column = columns[0], columns[1]  # whose next entry is row a, as linked lists
    for a in range(len(where)):
        for e in range(fill_ptr[a], fill_ptr[a + 1]):
            where[fill[e]] = e
        for e in range(indptr[a], indptr[a + 1]):
            values[where[indices[e]]] = data[e]
        j = first_column[a]
        while j >= 0:
            following = next_column[j]
            c = cursor[j]
            to_a = values[c]
            for e in range(c + 1, fill_ptr[j + 1]):
                through = to_a + values[e]
                slot = where[fill[e]]
                if through < values[slot]:
                    values[slot] = through
            cursor[j] = c + 1
            if c + 1 < fill_ptr[j + 1]:
                row = fill[c + 1]
                next_column[j] = first_column[row]
                first_column[row] = j
            j = following
        if fill_ptr[a] < fill_ptr[a + 1]:
            row = fill[fill_ptr[a]]
            next_column[a] = first_column[row]
            first_column[row] = a


@kernel(fastmath={"nnan", "nsz"})
def _solve_strip(  # type: ignore[no-untyped-def]
    begin, places, position, indptr, indices, values, paths, is_reached, out
):
    """One sweep up the elimination order from the sources, one sweep down to all nodes."""
    n = len(position)
    for j in range(begin, n):
        if is_reached[j]:
            here = paths[j]
            for e in range(indptr[j], indptr[j + 1]):
                is_reached[indices[e]] = True
                there, w = paths[indices[e]], values[e]
                for i in range(STRIP):
                    there[i] = min(there[i], here[i] + w)
    for j in range(n - 1, -1, -1):
        here = paths[j]
        e, end = indptr[j], indptr[j + 1]
        while e + 3 < end:  # by fours, which reads and writes less
            a, b, c, d = (
                paths[indices[e]],
                paths[indices[e + 1]],
                paths[indices[e + 2]],
                paths[indices[e + 3]],
            )
            u, v, w, x = values[e], values[e + 1], values[e + 2], values[e + 3]
            for i in range(STRIP):
                here[i] = min(here[i], min(min(a[i] + u, b[i] + v), min(c[i] + w, d[i] + x)))
            e += 4
        while e < end:
            there, w = paths[indices[e]], values[e]
            for i in range(STRIP):
                here[i] = min(here[i], there[i] + w)
            e += 1
    for first in range(0, n, LINE):  # blocks whose paths stay in the cache
        last = min(first + LINE, n)
        for i in range(len(places)):
            row = out[places[i]]
            for v in range(first, last):
                row[v] = paths[position[v], i]


@kernel
def _mirror(D, first):  # type: ignore[no-untyped-def]
    """The smaller of D_ij and D_ji in both, for the rows of one strip and the columns from there on."""
    n = len(D)
    last = min(first + STRIP, n)
    for left in range(first, n, STRIP):  # square blocks: both sides of the diagonal stay in the cache
        for i in range(first, last):
            for j in range(max(left, i + 1), min(left + STRIP, n)):
                if D[j, i] < D[i, j]:
                    D[i, j] = D[j, i]
                else:
                    D[j, i] = D[i, j]
