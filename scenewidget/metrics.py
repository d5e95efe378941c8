"""How well two segmentations of the same items agree.

Go in: two label vectors, and if wanted the areas of the items. Comes out: one number. All regional
measures are sums over the contingency table n (items, or area, that carry label i in `a` and j in `b`)
with its margins r and s; cut discrepancy alone looks at the mesh. Equations 4.3 to 4.7 are those of
Küçükdemir (2020), after Chen, Golovinskiy and Funkhouser (2009), *A benchmark for 3D mesh
segmentation*, ACM Transactions on Graphics 28(3).

Conventions that every function here shares:

- `a` and `b` are (n,) whole numbers or a `Segmentation`; names of labels mean nothing, negative is
  unlabeled. The second is the truth where a measure is not symmetric.
- `weights` (n,) are counts of 1 by default; face areas make a measure independent of the triangulation.
- `unlabeled="drop"` leaves out what either side did not label, ``"one"`` makes all unlabeled items of a
  side one segment, ``"singletons"`` a segment each.
- No items, or none left, is a `ValueError`: there is nothing that could agree.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy import sparse
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh, face_adjacency, weld
from scenewidget.engine.segmentation import Segmentation

__all__ = [
    "Unlabeled",
    "adjusted_rand_index",
    "cut_discrepancy",
    "global_consistency_error",
    "hamming_distance",
    "local_consistency_error",
    "match_segments",
    "mean_iou",
    "quick_scores",
    "rand_index_error",
    "variation_of_information",
]

Unlabeled = Literal["drop", "one", "singletons"]
UNLABELED: tuple[Unlabeled, ...] = ("drop", "one", "singletons")
Labels = IntArray | Segmentation
DENSE_CELLS = 20_000_000  # 160 MB: up to here a matching is solved on a dense matrix


# --- regions --------------------------------------------------------------------------------------


def rand_index_error(
    a: Labels, b: Labels, weights: FloatArray | None = None, unlabeled: Unlabeled = "drop"
) -> float:
    """1 − RI: share of the pairs of items that one side joins and the other parts (Eq. 4.7).

    With weights a pair counts w_i·w_j: (Σr² + Σs² − 2Σn²) / (W² − Σw²), summed as Σn(r − n) + Σn(s − n),
    which loses no digits.

    Parameters
    ----------
    a, b : (n,) int or Segmentation
        Labels of the same items; see the module's docstring.
    weights : (n,) float, optional
        How much each item counts, areas for example; all alike by default.
    unlabeled : "drop" | "one" | "singletons"
        What becomes of items with a negative label: left out, one segment, or a segment each.

    Returns
    -------
    error : float
        In [0, 1]; 0 when there are no pairs. Symmetric.

    References
    ----------
    Rand (1971), Journal of the American Statistical Association 66(336). The thesis' factor in front of
    the sum is the reciprocal of the number of pairs.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> ours, truth = np.array([0, 0, 0, 1]), np.array([0, 0, 1, 1])
    >>> sw.metrics.rand_index_error(ours, truth)  # of 6 pairs 3
    0.5
    """
    return _rand_error(_contingency(a, b, weights, unlabeled))


def _rand_error(table: _Contingency) -> float:
    n = table.n
    apart = (n * (table.r[table.i] - n)).sum() + (n * (table.s[table.j] - n)).sum()
    pairs = table.total**2 - table.squares.sum()
    return min(max(float(apart) / float(pairs), 0.0), 1.0) if pairs > 0 else 0.0


def global_consistency_error(
    a: Labels, b: Labels, weights: FloatArray | None = None, unlabeled: Unlabeled = "drop"
) -> float:
    """GCE: the local refinement error (Eq. 4.4), taken in one direction for all items (Eq. 4.5).

    min(Σ n(1 − n/r), Σ n(1 − n/s)) / W. It is 0 when one side refines the other, so all-singletons and
    one-segment-for-everything score 0: never report it alone.

    Parameters
    ----------
    a, b, weights, unlabeled
        As of `rand_index_error`.

    Returns
    -------
    error : float
        In [0, 1). Symmetric.

    References
    ----------
    Martin, Fowlkes, Tal and Malik (2001), ICCV.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> fine, coarse = np.array([0, 1, 2, 2]), np.array([0, 0, 1, 1])
    >>> sw.metrics.global_consistency_error(fine, coarse)  # a refinement
    0.0
    """
    return _global_error(_contingency(a, b, weights, unlabeled))


def _global_error(table: _Contingency) -> float:
    of_a, of_b = _refinement_errors(table)
    return float(min((table.n * of_a).sum(), (table.n * of_b).sum()) / table.total)


def local_consistency_error(
    a: Labels, b: Labels, weights: FloatArray | None = None, unlabeled: Unlabeled = "drop"
) -> float:
    """LCE: as GCE, with the kinder direction chosen for each item by itself (Eq. 4.6); never above GCE.

    Parameters
    ----------
    a, b, weights, unlabeled
        As of `rand_index_error`.

    Returns
    -------
    error : float
        In [0, 1). Symmetric.

    References
    ----------
    Martin, Fowlkes, Tal and Malik (2001), ICCV.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> ours, truth = np.array([0, 0, 0, 1]), np.array([0, 0, 1, 1])
    >>> round(sw.metrics.local_consistency_error(ours, truth), 3)
    0.125
    """
    return _local_error(_contingency(a, b, weights, unlabeled))


def _local_error(table: _Contingency) -> float:
    of_a, of_b = _refinement_errors(table)
    return float((table.n * np.minimum(of_a, of_b)).sum() / table.total)


def hamming_distance(
    a: Labels,
    b: Labels,
    weights: FloatArray | None = None,
    unlabeled: Unlabeled = "drop",
    *,
    directional: bool = False,
) -> float:
    """Share of the items outside the best partner of their segment (Eq. 4.3).

    Directional: DH(a, b) / W = Σ_i (r_i − max_j n_ij) / W, what of each segment of `a` lies outside the
    segment of `b` that it overlaps most; 0 when `a` refines `b`. Otherwise the mean of both directions.
    The thesis weights by area: pass ``weights=mesh.face_areas``.

    Parameters
    ----------
    a, b, weights, unlabeled
        As of `rand_index_error`.
    directional : bool
        Whether only what of `a` lies outside of `b` counts.

    Returns
    -------
    distance : float
        In [0, 1). Symmetric unless `directional`.

    References
    ----------
    Huang and Dom (1995), ICIP; Chen et al. (2009).

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> ours, truth = np.array([0, 0, 0, 1]), np.array([0, 0, 1, 1])
    >>> sw.metrics.hamming_distance(ours, truth)
    0.25
    """
    table = _contingency(a, b, weights, unlabeled)
    best_in_b, best_in_a = np.zeros(len(table.r)), np.zeros(len(table.s))
    np.maximum.at(best_in_b, table.i, table.n)
    np.maximum.at(best_in_a, table.j, table.n)
    forth = 1.0 - best_in_b.sum() / table.total
    back = 1.0 - best_in_a.sum() / table.total
    return max(float(forth if directional else 0.5 * (forth + back)), 0.0)


def adjusted_rand_index(
    a: Labels, b: Labels, weights: FloatArray | None = None, unlabeled: Unlabeled = "drop"
) -> float:
    """ARI: the Rand index, corrected so that random labels with the same margins expect 0.

    Parameters
    ----------
    a, b, weights, unlabeled
        As of `rand_index_error`.

    Returns
    -------
    score : float
        At most 1, which means equal up to names; **higher is better**. 1 when there are no pairs.
        Symmetric.

    References
    ----------
    Hubert and Arabie (1985), Journal of Classification 2; pairs weigh w_i·w_j here.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> sw.metrics.adjusted_rand_index(np.array([0, 0, 1, 1]), np.array([5, 5, 2, 2]))
    1.0
    """
    table = _contingency(a, b, weights, unlabeled)
    pairs = float(table.total**2 - table.squares.sum())
    squares_a, squares_b = np.zeros_like(table.r), np.zeros_like(table.s)
    np.add.at(squares_a, table.i, table.squares)
    np.add.at(squares_b, table.j, table.squares)
    together = float((table.n**2 - table.squares).sum())  # cell by cell: a lone item leaves exactly 0
    in_a, in_b = float((table.r**2 - squares_a).sum()), float((table.s**2 - squares_b).sum())
    if pairs <= 0 or in_a == in_b == 0 or len(table.r) == len(table.s) == 1:
        return 1.0  # nothing to tell apart: both all singletons, or both one segment
    expected = in_a / pairs * in_b
    most = 0.5 * (in_a + in_b)
    return (together - expected) / (most - expected)


def variation_of_information(
    a: Labels, b: Labels, weights: FloatArray | None = None, unlabeled: Unlabeled = "drop"
) -> float:
    """H(a | b) + H(b | a) in nats: what each side leaves unsaid about the other. A metric.

    Parameters
    ----------
    a, b, weights, unlabeled
        As of `rand_index_error`.

    Returns
    -------
    distance : float
        0 for equal partitions, at most log n. Symmetric.

    References
    ----------
    Meilă (2007), Journal of Multivariate Analysis 98(5).

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> halves, whole = np.array([0, 0, 1, 1]), np.zeros(4, int)
    >>> round(sw.metrics.variation_of_information(halves, whole), 3)  # ln 2
    0.693
    """
    table = _contingency(a, b, weights, unlabeled)
    share_a, share_b = table.n / table.r[table.i], table.n / table.s[table.j]
    return max(float(-(table.n * (np.log(share_a) + np.log(share_b))).sum() / table.total), 0.0)


def mean_iou(a: Labels, b: Labels, weights: FloatArray | None = None, unlabeled: Unlabeled = "drop") -> float:
    """Mean over the segments of `b` of the IoU with their partner in `a`, one partner each.

    The matching maximises the sum of intersection over union (Kuhn's assignment problem, solved by
    scipy). Segments of `b` without a partner count 0; those of `a` left over count nothing, so give the
    truth as `b`.

    Parameters
    ----------
    a, b, weights, unlabeled
        As of `rand_index_error`; `b` is the truth.

    Returns
    -------
    score : float
        In (0, 1], **higher is better**.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> ours, truth = np.array([0, 0, 0, 1]), np.array([0, 0, 1, 1])
    >>> round(sw.metrics.mean_iou(ours, truth), 3)
    0.583
    """
    return _mean_iou(_contingency(a, b, weights, unlabeled))


def _mean_iou(table: _Contingency) -> float:
    iou = table.n / (table.r[table.i] + table.s[table.j] - table.n)
    return _matching_sum(table.i, table.j, iou, len(table.r), len(table.s)) / len(table.s)


def match_segments(a: Labels, b: Labels, counts: IntArray | None = None) -> IntArray:
    """Partner in `b` of each segment of `a`, so that the sum of intersection over union is largest.

    Parameters
    ----------
    a, b : (n,) int or Segmentation
    counts : (n,) int, optional
        How many equal items each entry stands for; 1 by default.

    Returns
    -------
    partner : (n_a,) int
        Label in `b` for each label of `a`, one partner each; −1 where there is none.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> sw.metrics.match_segments(np.array([0, 0, 1, 2]), np.array([1, 1, 0, 0])).tolist()
    [1, 0, -1]
    """
    left, right = _label_pair(a, b)
    weight = None if counts is None else _check_weights(counts, len(left))
    n_left, n_right = int(left.max(initial=-1)) + 1, int(right.max(initial=-1)) + 1
    partner = np.full(n_left, -1)
    keep = (left >= 0) & (right >= 0)
    if not keep.any():
        return partner
    value = np.ones(int(keep.sum())) if weight is None else weight[keep]
    shape = (n_left, n_right)
    cells = sparse.coo_array((value, (left[keep], right[keep])), shape=shape).tocsr().tocoo()
    i, j, n = cells.row, cells.col, cells.data
    r, s = np.bincount(i, n, n_left), np.bincount(j, n, n_right)
    rows, columns = _matching(i, j, n / (r[i] + s[j] - n), n_left, n_right)
    partner[rows] = columns
    return partner


def quick_scores(a: Labels, b: Labels, counts: IntArray | None = None) -> dict[str, float]:
    """The measures that one contingency table gives: fast enough to follow a person's edits.

    Parameters
    ----------
    a, b : (n,) int or Segmentation
        `b` is the truth.
    counts : (n,) int, optional
        How many equal items each entry stands for; 1 by default. So a million faces can be given as the few
        thousand different combinations of labels that they have.

    Returns
    -------
    scores : dict
        ``rand_index_error``, ``global_consistency_error``, ``local_consistency_error``, ``mean_iou`` over
        the items that both label, nan if there are none; and ``coverage``, the share of what `b` labels
        that `a` labels too.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> scores = sw.metrics.quick_scores(np.array([0, 0, 0, -1]), np.array([0, 0, 1, 1]))
    >>> round(scores["rand_index_error"], 3), scores["coverage"]
    (0.667, 0.75)
    """
    left, right = _label_pair(a, b)
    weight = np.ones(len(left)) if counts is None else _check_weights(counts, len(left))
    known, both = right >= 0, (left >= 0) & (right >= 0)
    total = float(weight[known].sum())
    coverage = float(weight[both].sum()) / total if total > 0 else float("nan")
    names = ("rand_index_error", "global_consistency_error", "local_consistency_error", "mean_iou")
    if not weight[both].sum() > 0:
        return dict.fromkeys(names, float("nan")) | {"coverage": coverage}
    table = _contingency(left, right, weight, "drop")
    table = dataclasses.replace(table, squares=table.n)  # each item is one of many, with a weight of 1
    values = (_rand_error(table), _global_error(table), _local_error(table), _mean_iou(table))
    return dict(zip(names, values)) | {"coverage": coverage}


# --- cuts -----------------------------------------------------------------------------------------


def cut_discrepancy(a: Labels, b: Labels, mesh: Mesh, unlabeled: Unlabeled = "drop") -> float:
    """Mean distance along the surface between the cuts of `a` and those of `b`, over the mesh's radius.

    The cuts of a segmentation are the edges between faces of different segments. Each point of a cut is
    as far as the nearest cut of the other side; the two directional means are added and divided by the
    mean distance of the surface from its centroid (Chen et al. 2009, after Huang and Dom 1995).

    Distances follow the edges of the mesh and the straight lines that cross one edge between the two
    vertices opposite to it, a graph that overestimates the geodesic distance by a few per cent; they
    are linear between the ends of a cut edge. Where no path leads to a cut of the other side (another
    component), the straight line in space stands in.

    Parameters
    ----------
    a, b : (n_faces,) int or Segmentation
    mesh : Mesh
    unlabeled : "drop" | "one" | "singletons"
        "drop": an edge beside a face that either side left unlabeled is no cut.

    Returns
    -------
    distance : float
        0 when the cuts are the same, or neither side has any; nan when only one side has cuts. No unit.
        Symmetric.

    Notes
    -----
    Time is that of two Dijkstra searches over the vertices.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> mesh = square(4)
    >>> left, lower = (mesh.face_centroids[:, :2] < 0.5).astype(int).T
    >>> sw.metrics.cut_discrepancy(left, left, mesh), sw.metrics.cut_discrepancy(left, lower, mesh) > 0.5
    (0.0, True)
    """
    if not isinstance(mesh, Mesh):
        raise TypeError(f"mesh must be a scenewidget.Mesh, got {type(mesh).__name__}")
    left, right = _label_pair(a, b)
    if len(left) != mesh.n_faces:
        raise ValueError(
            f"a and b must have one label a face: the mesh has {mesh.n_faces} faces, got {len(left)}"
        )
    _check_unlabeled(unlabeled)
    faces = weld(mesh)[mesh.faces]
    if mesh.is_cloud:  # neighbours are what is cut, and the way from point to point
        edge = beside = face_adjacency(mesh)
    else:
        edge, opposite, beside = _inner_edges(faces, mesh.n_vertices)
    left, right, keep = _resolve(left, right, unlabeled)
    usable = np.ones(len(beside), dtype=bool) if keep is None else keep[beside].all(axis=1)
    is_cut = [usable & (labels[beside[:, 0]] != labels[beside[:, 1]]) for labels in (left, right)]
    if not is_cut[0].any() and not is_cut[1].any():
        return 0.0
    if not is_cut[0].any() or not is_cut[1].any():
        return float("nan")
    graph = _point_graph(mesh, edge) if mesh.is_cloud else _surface_graph(mesh, faces, edge, opposite)
    forth = _mean_distance_to(graph, mesh, edge[is_cut[0]], edge[is_cut[1]])
    back = _mean_distance_to(graph, mesh, edge[is_cut[1]], edge[is_cut[0]])
    return (forth + back) / _mean_radius(mesh)


def _inner_edges(faces: IntArray, n_vertices: int) -> tuple[IntArray, IntArray, IntArray]:
    """Edges with two faces or more: their ends, the vertices opposite, the faces beside; a row a pair."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    apex = np.roll(faces, -2, axis=1).ravel()
    key = np.minimum(start, end).astype(np.int64) * n_vertices + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    order = order[(start != end)[order]]
    same = key[order][1:] == key[order][:-1]
    first, second = order[:-1][same], order[1:][same]
    edge = np.stack([start[first], end[first]], axis=1)
    opposite = np.stack([apex[first], apex[second]], axis=1)
    beside = np.stack([first // 3, second // 3], axis=1)
    return edge, opposite, beside


def _point_graph(cloud: Mesh, pairs: IntArray) -> sparse.csr_array:
    """Points joined to their neighbours."""
    length = np.linalg.norm(cloud.vertices[pairs[:, 0]] - cloud.vertices[pairs[:, 1]], axis=1)
    n = cloud.n_vertices
    return sparse.csr_array((np.maximum(length, 1e-12), (pairs[:, 0], pairs[:, 1])), shape=(n, n))


def _surface_graph(mesh: Mesh, faces: IntArray, edge: IntArray, opposite: IntArray) -> sparse.csr_array:
    """Vertices joined along edges, and across each inner edge where the unfolded line crosses it."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    p, q, u, v = (mesh.vertices[x] for x in (edge[:, 0], edge[:, 1], opposite[:, 0], opposite[:, 1]))
    axis = q - p
    length = np.linalg.norm(axis, axis=1)
    along_u, along_v = (np.einsum("ij,ij->i", x - p, axis) / length for x in (u, v))
    off_u = np.sqrt(np.maximum(np.einsum("ij,ij->i", u - p, u - p) - along_u**2, 0.0))
    off_v = np.sqrt(np.maximum(np.einsum("ij,ij->i", v - p, v - p) - along_v**2, 0.0))
    both = off_u + off_v
    crossing = np.divide(
        along_u * off_v + along_v * off_u, both, out=np.full(len(both), -1.0), where=both > 0
    )
    is_direct = (crossing > 0) & (crossing < length) & (opposite[:, 0] != opposite[:, 1])
    unfolded = np.hypot(along_u - along_v, both)
    ends = np.concatenate([sides, opposite[is_direct]])
    weight = np.concatenate(
        [np.linalg.norm(mesh.vertices[sides[:, 0]] - mesh.vertices[sides[:, 1]], axis=1), unfolded[is_direct]]
    )
    low, high = ends.min(axis=1).astype(np.int64), ends.max(axis=1)
    code = low * mesh.n_vertices + high
    order = np.lexsort((weight, code))  # an edge of two faces comes twice: the shortest stands
    order = order[np.concatenate([[True], np.diff(code[order]) > 0]) & (low != high)[order]]
    n = mesh.n_vertices
    return sparse.csr_array((weight[order], (low[order], high[order])), shape=(n, n))


def _mean_distance_to(graph: sparse.csr_array, mesh: Mesh, from_edge: IntArray, to_edge: IntArray) -> float:
    targets = np.unique(to_edge)
    distance = csgraph.dijkstra(graph, directed=False, indices=targets, min_only=True)
    origins = np.unique(from_edge)
    lost = origins[~np.isfinite(distance[origins])]
    if len(lost):
        distance[lost] = cKDTree(mesh.vertices[targets]).query(mesh.vertices[lost])[0]
    length = np.linalg.norm(mesh.vertices[from_edge[:, 0]] - mesh.vertices[from_edge[:, 1]], axis=1)
    return float(np.average(distance[from_edge].mean(axis=1), weights=length))


def _mean_radius(mesh: Mesh) -> float:
    """Metres; the surface's mean distance from its centroid, sampled at the centroids of the faces."""
    centroid = np.average(mesh.face_centroids, axis=0, weights=mesh.face_areas)
    distance = np.linalg.norm(mesh.face_centroids - centroid, axis=1)
    return float(np.average(distance, weights=mesh.face_areas))


# --- the contingency table ------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Contingency:
    """Non-empty cells (i, j) of weight n with margins r (rows) and s (columns).

    squares is Σw² in each cell, the pairs of an item with itself; total is W.

    Counts stay int64, exact to 3·10⁹ items; areas are float64.
    """

    i: IntArray
    j: IntArray
    n: Any
    r: Any
    s: Any
    squares: Any
    total: Any


def _contingency(a: Labels, b: Labels, weights: FloatArray | None, unlabeled: Unlabeled) -> _Contingency:
    _check_unlabeled(unlabeled)
    left, right = _label_pair(a, b)
    weight = None if weights is None else _check_weights(weights, len(left))
    left, right, keep = _resolve(left, right, unlabeled)
    if keep is not None:
        left, right = left[keep], right[keep]
        weight = None if weight is None else weight[keep]
    if len(left) == 0:
        raise ValueError(
            "no item is labeled in both a and b, so there is nothing to compare; "
            "unlabeled='one' or 'singletons' counts the others too"
        )
    left, n_left = _renumber(left)
    right, n_right = _renumber(right)
    value = np.ones(len(left), dtype=np.int64) if weight is None else weight
    shape = (n_left, n_right)
    cells = sparse.coo_array((value, (left, right)), shape=shape).tocsr().tocoo()
    squares = cells.data  # of counts of 1
    if weight is not None:
        squares = sparse.coo_array((weight**2, (left, right)), shape=shape).tocsr().data  # in the same order
    is_filled = cells.data > 0
    i, j, n, squares = cells.row[is_filled], cells.col[is_filled], cells.data[is_filled], squares[is_filled]
    if len(n) == 0:
        raise ValueError("weights sum to 0 over the labeled items, so there is nothing to compare")
    if not is_filled.all():  # segments without weight don't exist
        (i, n_left), (j, n_right) = _renumber(i), _renumber(j)
    r, s = np.zeros(n_left, dtype=n.dtype), np.zeros(n_right, dtype=n.dtype)
    np.add.at(r, i, n)
    np.add.at(s, j, n)
    return _Contingency(i, j, n, r, s, squares, n.sum())


def _refinement_errors(table: _Contingency) -> tuple[FloatArray, FloatArray]:
    """Per cell: share of the item's segment in one side that lies outside its segment in the other."""
    return 1.0 - table.n / table.r[table.i], 1.0 - table.n / table.s[table.j]


def _matching_sum(i: IntArray, j: IntArray, value: FloatArray, n_rows: int, n_columns: int) -> float:
    """Largest sum of values over cells with no two in a row or column."""
    rows, columns = _matching(i, j, value, n_rows, n_columns)
    return float(sparse.csr_array((value, (i, j)), shape=(n_rows, n_columns))[rows, columns].sum())


def _matching(
    i: IntArray, j: IntArray, value: FloatArray, n_rows: int, n_columns: int
) -> tuple[IntArray, IntArray]:
    """Cells of the largest sum of values with no two in a row or column: their rows and columns."""
    keep = _undominated(i, j, value, n_rows)
    i, j, value = i[keep], j[keep], value[keep]
    keep = _undominated(j, i, value, n_columns)
    i, j, value = i[keep], j[keep], value[keep]
    is_alone = (np.bincount(i, minlength=n_rows)[i] == 1) & (np.bincount(j, minlength=n_columns)[j] == 1)
    alone = (i[is_alone], j[is_alone])
    i, j, value = i[~is_alone], j[~is_alone], value[~is_alone]
    if len(value) == 0:
        return alone
    row_names, column_names = np.unique(i), np.unique(j)
    (i, n_rows), (j, n_columns) = _renumber(i), _renumber(j)
    if n_rows * n_columns <= DENSE_CELLS:
        dense = np.zeros((n_rows, n_columns))
        dense[i, j] = value
        rows, columns = linear_sum_assignment(dense, maximize=True)
        keep = dense[rows, columns] > 0
        rows, columns = rows[keep], columns[keep]
    else:
        rows, columns = _sparse_matching(i, j, value, n_rows, n_columns)
    return (
        np.concatenate([alone[0], row_names[rows]]),
        np.concatenate([alone[1], column_names[columns]]),
    )


def _sparse_matching(
    i: IntArray, j: IntArray, value: FloatArray, n_rows: int, n_columns: int
) -> tuple[IntArray, IntArray]:
    # Each row may also take a column of its own that is worth 0; costs are shifted by 2 because an
    # explicit 0 is no edge to scipy.
    rows = np.concatenate([i, np.arange(n_rows)])
    columns = np.concatenate([j, n_columns + np.arange(n_rows)])
    cost = np.concatenate([2.0 - value, np.full(n_rows, 2.0)])
    graph = sparse.csr_array((cost, (rows, columns)), shape=(n_rows, n_columns + n_rows))
    matched_rows, matched = csgraph.min_weight_full_bipartite_matching(graph)
    keep = matched < n_columns
    return matched_rows[keep], matched[keep]


def _undominated(i: IntArray, j: IntArray, value: FloatArray, n_rows: int) -> BoolArray:
    """False for rows with a single cell where another such row offers the same column more.

    Over-segmentations consist of little else; without this a matching of 10⁶ singletons never ends.
    """
    keep = np.bincount(i, minlength=n_rows)[i] > 1
    single = np.flatnonzero(~keep)
    single = single[np.lexsort((-value[single], j[single]))]
    keep[single[np.concatenate([[True], np.diff(j[single]) > 0])[: len(single)]]] = True
    return keep


# --- checks ---------------------------------------------------------------------------------------


def _label_pair(a: Labels, b: Labels) -> tuple[IntArray, IntArray]:
    left, right = _labels("a", a), _labels("b", b)
    if len(left) != len(right):
        raise ValueError(f"a and b must label the same items, got {len(left)} and {len(right)} labels")
    if len(left) == 0:
        raise ValueError("a and b are empty, so there is nothing to compare")
    return left, right


def _labels(name: str, value: Any) -> IntArray:
    if isinstance(value, Segmentation):
        return value.labels
    array = np.asarray(value)
    if array.dtype.kind not in "iu" and array.size:
        raise TypeError(
            f"{name} must be whole-number labels or a Segmentation, got {type(value).__name__} "
            f"of dtype {array.dtype}"
        )
    if array.ndim != 1:
        raise ValueError(f"{name} must have one label an item: shape (n,), got {array.shape}")
    return array.astype(np.int64) if array.dtype.kind == "u" else array


def _check_weights(weights: Any, n: int) -> FloatArray:
    array = np.asarray(weights)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"weights must be numbers, got dtype {array.dtype}")
    if array.shape != (n,):
        raise ValueError(f"weights must have one entry an item: ({n},), got {array.shape}")
    array = array.astype(np.float64)
    if not np.isfinite(array).all() or (array < 0).any():
        raise ValueError("weights must be finite and at least 0, such as mesh.face_areas")
    return array


def _check_unlabeled(unlabeled: str) -> None:
    if unlabeled not in UNLABELED:
        raise ValueError(f"unlabeled must be one of {', '.join(map(repr, UNLABELED))}, got {unlabeled!r}")


def _resolve(
    left: IntArray, right: IntArray, unlabeled: Unlabeled
) -> tuple[IntArray, IntArray, BoolArray | None]:
    """Labels with the unlabeled turned into segments, or the mask of the items to keep (None: all)."""
    if unlabeled == "drop":
        keep = (left >= 0) & (right >= 0)
        return left, right, None if keep.all() else keep
    return _fill(left, unlabeled), _fill(right, unlabeled), None


def _fill(labels: IntArray, unlabeled: Unlabeled) -> IntArray:
    is_open = labels < 0
    count = int(is_open.sum())
    if count == 0:
        return labels
    dense, n_labels = _renumber(np.where(is_open, labels.max(initial=0), labels))
    dense[is_open] = n_labels if unlabeled == "one" else n_labels + np.arange(count)
    return dense


def _renumber(labels: IntArray) -> tuple[IntArray, int]:
    """Labels 0, 1, 2, … in the order of the old ones, and their number."""
    lowest, highest = int(labels.min()), int(labels.max())
    if lowest < 0 or highest > 4 * len(labels) + 1000:
        values, inverse = np.unique(labels, return_inverse=True)
        return inverse, len(values)
    present = np.zeros(highest + 1, dtype=bool)
    present[labels] = True
    rank = np.cumsum(present) - 1
    return rank[labels], int(present.sum())
