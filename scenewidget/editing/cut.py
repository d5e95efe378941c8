"""Divide one segment along the cheapest boundary between two faces.

Goes in: the faces of a segment and two of them. Comes out: which faces are on the side of the second.
Fuzzy clustering and cuts: Katz and Tal (2003), Hierarchical mesh decomposition, ACM TOG 22(3). Faces that
are clearly nearer to one of the two belong to it; over the zone between them a minimum cut finds the
boundary, for which creases are cheap, above all concave ones.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from scenewidget.engine.mesh import (
    BoolArray,
    FloatArray,
    IntArray,
    Mesh,
    connected_components,
    face_adjacency,
)
from scenewidget.engine.preprocess import filter_normals
from scenewidget.engine.threads import n_threads

__all__ = ["cut_segment"]

FUZZY = 0.8  # |d_a − d_b| / d(a, b) below which the minimum cut decides
CONVEX = 0.5  # a convex crease counts so much of a concave one
TURN = 3.0  # a mean turn of the normal adds as much distance as so many edges
STEEP = 3.0  # how fast the cost of a boundary falls with the sharpness of its crease
MIDDLE = 5.0  # how much dearer a boundary gets towards a seed: on a plane the shortest would hug it
SCALE = 10_000  # capacity of the dearest edge; capacities are whole numbers
DIRECT = 15_000  # up to so many faces one minimum cut decides; above, one between patches, then one in a band
N_CELLS = 10_000  # cells of the grid that patches are made of; there are about twice as many patches


def cut_segment(mesh: Mesh, faces: IntArray, face_a: int, face_b: int) -> BoolArray:
    """Which faces of a segment are on the side of ``face_b``.

    Parameters
    ----------
    mesh : Mesh
    faces : (n,) int
        Faces of the segment, ascending, ``face_a`` and ``face_b`` among them.
    face_a, face_b : int
        Two different faces.

    Returns
    -------
    is_b : (n,) bool
        False at ``face_a``, True at ``face_b``. Pieces that are connected with neither go to the nearer
        of the two. Ties go to ``face_a``.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> cut_segment(mesh, np.arange(8), 0, 7)
    array([False, False,  True,  True, False, False,  True,  True])
    """
    sub = mesh.part(faces)
    a, b = (int(np.searchsorted(faces, face)) for face in (face_a, face_b))
    pairs = face_adjacency(sub)
    _, piece = connected_components(sub.n_faces, pairs)
    away = sub.face_centroids - sub.face_centroids[[a]]
    home = sub.face_centroids - sub.face_centroids[[b]]
    is_nearer = np.einsum("ij,ij->i", home, home) < np.einsum("ij,ij->i", away, away)
    is_b = _by_vote(piece, is_nearer, sub.face_areas)
    is_b[piece == piece[a]] = False
    is_b[piece == piece[b]] = True
    if piece[a] == piece[b]:
        inside = piece == piece[a]
        is_b[inside] = _divide(sub, pairs, inside, a, b)[inside]
    is_b[a], is_b[b] = False, True
    return is_b


def _by_vote(group: IntArray, votes: BoolArray, weights: FloatArray) -> BoolArray:
    """Whether more than half of the weight of an item's group votes yes, for each item."""
    yes = np.bincount(group, weights * votes)
    return np.asarray((yes > 0.5 * np.bincount(group, weights))[group])


def _divide(sub: Mesh, pairs: IntArray, inside: BoolArray, a: int, b: int) -> BoolArray:
    """(n_faces,) the side of b; meaningful in the piece that both are in."""
    pairs = pairs[inside[pairs[:, 0]]]
    normals = filter_normals(sub, pairs, sweeps=10, n_threads=n_threads())
    lengths, turn = _edges(sub, pairs, normals)
    # distance along the surface, a turn of the normal being as far as some edges
    step = np.linalg.norm(sub.face_centroids[pairs[:, 0]] - sub.face_centroids[pairs[:, 1]], axis=1)
    mean_turn = max(float(turn.mean()), 1e-6)
    weight = step + TURN * float(step.mean()) * turn / mean_turn + 1e-12
    n = sub.n_faces
    graph = sparse.csr_array((weight, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    d_a, d_b = csgraph.dijkstra(graph, directed=False, indices=[a, b])
    reached = inside & np.isfinite(d_a)
    lean = np.where(reached, np.subtract(d_a, d_b, where=reached, out=np.zeros(n)) / d_a[b], 0.0)
    fuzzy = reached & (np.abs(lean) < FUZZY)
    fuzzy[[a, b]] = False
    is_b = lean > 0
    is_b[a], is_b[b] = False, True
    dearness = lengths / (1.0 + STEEP * turn / mean_turn) * (1.0 + MIDDLE * lean[pairs].mean(axis=1) ** 2)
    longest = float(dearness.max())
    capacity = np.maximum(1, np.round(SCALE / (longest or 1.0) * dearness)).astype(np.int64)
    if int(fuzzy.sum()) > DIRECT:
        cell = _cells(sub, normals, fuzzy)
        is_b = _settle(cell, is_b, pairs, capacity)
        fuzzy &= _near_boundary(cell, is_b, pairs)
    node = np.where(fuzzy, np.cumsum(fuzzy) - 1, -1)
    return _settle(node, is_b, pairs, capacity)


def _settle(group: IntArray, is_b: BoolArray, pairs: IntArray, capacity: IntArray) -> BoolArray:
    """Sides after a minimum cut between groups of faces; those in group -1 keep theirs."""
    node = np.where(group >= 0, group + 2, is_b.astype(np.int64))
    ends = np.sort(node[pairs], axis=1)
    crosses = ends[:, 0] != ends[:, 1]
    return np.asarray(~_min_cut(int(node.max()) + 1, ends[crosses], capacity[crosses])[node])


def _cells(sub: Mesh, normals: FloatArray, fuzzy: BoolArray) -> IntArray:
    """(n_faces,) patches of the fuzzy zone, -1 elsewhere: a cell of a grid and about one normal.

    Creases run between patches then, so a cut between patches can follow them.
    """
    size = max(float(np.sqrt(sub.face_areas[fuzzy].sum() / N_CELLS)), 1e-12)
    grid = np.floor((sub.face_centroids[fuzzy] - sub.vertices.min(axis=0)) / size).astype(np.int64)
    facing = np.round(1.5 * normals[fuzzy]).astype(np.int64)
    _, cell = np.unique(np.column_stack([grid, facing]), axis=0, return_inverse=True)
    out = np.full(sub.n_faces, -1)
    out[fuzzy] = cell.ravel()
    return out


def _near_boundary(cell: IntArray, is_b: BoolArray, pairs: IntArray) -> BoolArray:
    """(n_faces,) whether a face is in a cell at most two cells away from where the sides meet."""
    is_near = np.zeros(int(cell.max()) + 2, dtype=bool)  # the last one is that of no cell
    meets = is_b[pairs[:, 0]] != is_b[pairs[:, 1]]
    is_near[cell[pairs[meets]]] = True
    for _ in range(2):
        touches = is_near[cell[pairs]].any(axis=1)
        is_near[cell[pairs[touches]]] = True
        is_near[-1] = False
    return np.asarray(is_near[cell])


def _edges(sub: Mesh, pairs: IntArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Length of the edge that two faces share, and how much of a crease it is: 1 − cos, convex ones less."""
    i, j = pairs.T
    turn = np.maximum(1.0 - np.einsum("ij,ij->i", normals[i], normals[j]), 0.0).astype(np.float64)
    apart = sub.face_centroids[j] - sub.face_centroids[i]
    is_convex = np.einsum("ij,ij->i", apart, normals[j] - normals[i]) > 0
    return sub.seam_lengths(pairs), np.where(is_convex, CONVEX, 1.0) * turn


def _min_cut(n: int, pairs: IntArray, capacity: IntArray) -> BoolArray:
    """(n,) which nodes are on the side of node 0 of a minimum cut between 0 and 1."""
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    graph = sparse.coo_array((np.tile(capacity, 2), (rows, columns)), shape=(n, n)).tocsr()
    graph.data = np.minimum(graph.data, 2**30 - 1)  # source and sink have many edges; residuals double
    graph = sparse.csr_matrix(
        (graph.data.astype(np.int32), graph.indices.astype(np.int32), graph.indptr.astype(np.int32)),
        shape=(n, n),
    )
    flow = csgraph.maximum_flow(graph, 0, 1).flow
    residual = graph - flow
    residual.eliminate_zeros()
    reached = csgraph.breadth_first_order(residual, 0, return_predecessors=False)
    out = np.zeros(n, dtype=bool)
    out[reached] = True
    return out
