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

__all__ = ["cut_segment"]

FUZZY = 0.8  # |d_a − d_b| / d(a, b) below which the minimum cut decides
CONVEX = 0.5  # what a convex crease counts beside a concave one
TURN = 3.0  # edges that a mean turn of the normal is worth in the distance
STEEP = 3.0  # how fast creases get cheap
MIDDLE = 5.0  # boundaries near a seed are dearer, or the shortest one on a plane would hug it
SCALE = 1_000_000  # capacities are whole numbers; the dearest edge has this


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
    """
    used, corners = np.unique(mesh.faces[faces], return_inverse=True)
    sub = Mesh(mesh.vertices[used], corners.reshape(-1, 3))
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
    pairs = pairs[inside[pairs[:, 0]]]
    lengths, turn = _edges(sub, pairs)
    # distance along the surface, a turn of the normal being as far as some edges
    step = np.linalg.norm(sub.face_centroids[pairs[:, 0]] - sub.face_centroids[pairs[:, 1]], axis=1)
    mean_turn = max(float(turn.mean()), 1e-6)
    weight = step + TURN * float(step.mean()) * turn / mean_turn + 1e-12
    n = sub.n_faces
    graph = sparse.csr_array((weight, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    d_a, d_b = csgraph.dijkstra(graph, directed=False, indices=[a, b])
    reached = inside & np.isfinite(d_a)
    lean = np.where(reached, np.subtract(d_a, d_b, where=reached, out=np.zeros(n)) / d_a[b], 0.0)
    node = np.full(n, 0)
    fuzzy = reached & (np.abs(lean) < FUZZY)
    fuzzy[[a, b]] = False
    node[lean > 0] = 1
    node[a], node[b] = 0, 1
    node[fuzzy] = 2 + np.arange(int(fuzzy.sum()))
    dearness = lengths / (1.0 + STEEP * turn / mean_turn) * (1.0 + MIDDLE * lean[pairs].mean(axis=1) ** 2)
    longest = float(dearness.max())
    capacity = np.maximum(1, np.round(SCALE / (longest or 1.0) * dearness)).astype(np.int64)
    ends = np.sort(node[pairs], axis=1)
    crosses = ends[:, 0] != ends[:, 1]
    is_source_side = _min_cut(2 + int(fuzzy.sum()), ends[crosses], capacity[crosses])
    return np.asarray(~is_source_side[node])


def _edges(sub: Mesh, pairs: IntArray) -> tuple[FloatArray, FloatArray]:
    """Length of the edge that two faces share, and how much of a crease it is: 1 − cos, convex ones less."""
    normals = filter_normals(sub, pairs, sweeps=10)
    i, j = pairs.T
    turn = np.maximum(1.0 - np.einsum("ij,ij->i", normals[i], normals[j]), 0.0).astype(np.float64)
    apart = sub.face_centroids[j] - sub.face_centroids[i]
    is_convex = np.einsum("ij,ij->i", apart, normals[j] - normals[i]) > 0
    corner = sub.vertices[sub.faces]
    shared = (corner[i][:, :, None, :] == corner[j][:, None, :, :]).all(axis=3).any(axis=2)
    lengths = np.zeros(len(pairs))
    for k in range(3):
        side = shared[:, k] & shared[:, (k + 1) % 3]
        edge = corner[i[side], k] - corner[i[side], (k + 1) % 3]
        lengths[side] = np.linalg.norm(edge, axis=1)
    return lengths, np.where(is_convex, CONVEX, 1.0) * turn


def _min_cut(n: int, pairs: IntArray, capacity: IntArray) -> BoolArray:
    """(n,) which nodes are on the side of node 0 of a minimum cut between 0 and 1."""
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    graph = sparse.coo_array((np.tile(capacity, 2), (rows, columns)), shape=(n, n)).tocsr()
    graph.data = np.minimum(graph.data, 2**31 - 1)  # of source and sink, whose many edges add up
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
