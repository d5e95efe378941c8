"""How large a scene is, in what order geometry puts its faces, and what is a scene of its own.

Goes in: a mesh. Come out: metres in a unit of the scene, faces in an order that doesn't hang on the file, and
which faces are so far from each other that they are different scenes. A table top is to its cups what a room
is to its furniture: the method looks at it through the same thresholds, only smaller.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from scenewidget.engine.mesh import FloatArray, IntArray, Mesh, connected_components, unique_codes

__all__ = ["far_apart", "geometric_order", "scene_scale"]

ROOM = 20.0  # m² of surface of the scene whose unit is a metre: the least of a room


def scene_scale(area: float) -> float:
    """Metres in a unit of a scene with so much surface: 1 for rooms, less for what is smaller.

    s = min(1, √(area / 20 m²)). Lengths in `Params` count in units of s, areas in units of s²; those of a
    room are metres. Several rooms have the unit of one.

    Parameters
    ----------
    area : float
        Square metres of surface; without any the unit is a metre.

    Examples
    --------
    >>> from scenewidget.engine.scale import scene_scale
    >>> scene_scale(50.0), scene_scale(0.8)  # a room, a table top
    (1.0, 0.2)
    """
    return min(1.0, float(np.sqrt(area / ROOM))) if area > 0 else 1.0


def geometric_order(mesh: Mesh) -> IntArray:
    """(n_faces,) faces by the places of their corners, whatever their order in the file.

    Two files of one mesh whose faces or vertices are numbered differently give the same sequence of
    triangles, so that what is computed along it is the same to the last bit.

    Parameters
    ----------
    mesh : Mesh

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.engine.scale import geometric_order
    >>> vertices = [[5, 0, 0], [6, 0, 0], [5, 1, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]]
    >>> mesh = sw.Mesh(vertices, [[0, 1, 2], [3, 4, 5]])
    >>> geometric_order(mesh).tolist()  # the face farther left comes first
    [1, 0]
    """
    (x, _), (y, n_y), (z, n_z) = (_ranks(along) for along in mesh.vertices.T)
    place, n = _ranks(_ranks(x * n_y + y)[0] * n_z + z)
    if mesh.is_cloud:
        return np.argsort(place, kind="stable").astype(np.int32)
    a, b, c = place[mesh.faces].T  # whichever corner a face begins with
    low, high = np.minimum(a, b), np.maximum(a, b)
    first, second, third = np.minimum(low, c), np.maximum(low, np.minimum(high, c)), np.maximum(high, c)
    pair = first * n + second
    code = (pair if n < 2_000_000 else _ranks(pair)[0]) * n + third  # fits in 64 bits
    order = np.argsort(code)
    if (code[order][1:] == code[order][:-1]).any():  # faces at one place stay in their order
        order = np.argsort(code, kind="stable")
    return order.astype(np.int32)


def _ranks(values: npt.NDArray[Any]) -> tuple[IntArray, int]:
    """(n,) int64 how many distinct values are smaller, and how many there are."""
    order = np.argsort(values)
    ordered = values[order]
    ranks = np.zeros(len(values), dtype=np.int64)
    ranks[order[1:]] = np.cumsum(ordered[1:] != ordered[:-1])
    return ranks, int(ranks[order[-1]]) + 1


def far_apart(mesh: Mesh, pairs: IntArray, gap: float) -> IntArray:
    """(n_faces,) int32 scene of each face: faces are in one where a chain of steps up to ``gap`` joins them.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int
        Adjacent faces.
    gap : float
        Metres between centroids of faces.

    Returns
    -------
    scene : (n_faces,) int32
        Numbered by area, the largest first.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> from scenewidget.engine.scale import far_apart
    >>> near, far = square(2).vertices, square(2).vertices + 5.0
    >>> mesh = sw.Mesh([*near, *far], [*square(2).faces, *(square(2).faces + 9)])
    >>> far_apart(mesh, face_adjacency(mesh), gap=1.0).tolist()
    [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1]
    """
    n, component = connected_components(mesh.n_faces, pairs)
    if n > 1:
        cell = np.floor((mesh.face_centroids - mesh.bounds[0]) / (gap / 4)).astype(np.int64)
        deep, wide, high = (cell.max(axis=0) + 1).tolist()
        codes, where = unique_codes((cell[:, 0] * wide + cell[:, 1]) * high + cell[:, 2], deep * wide * high)
        near = cKDTree(_centers(mesh, where, len(codes))).query_pairs(gap, output_type="ndarray")
        # components, then cells, which hold what is nearer than the gap: one graph of both
        links = np.stack([component, n + where], axis=1)
        is_new = (links[1:] != links[:-1]).any(axis=1)  # most faces follow one of the same cell
        links = np.concatenate([links[:1], links[1:][is_new], n + near])
        component = connected_components(n + len(codes), links)[1][component]
        n = int(component.max()) + 1
    area = np.bincount(component, mesh.face_areas, n)
    rank = np.empty(n, dtype=np.int32)
    rank[np.argsort(-area, kind="stable")] = np.arange(n, dtype=np.int32)
    return rank[component]


def _centers(mesh: Mesh, where: IntArray, n: int) -> FloatArray:
    """(n, 3) mean of the centroids of the faces in each cell."""
    count = np.bincount(where, minlength=n)
    return np.stack([np.bincount(where, x, n) / count for x in mesh.face_centroids.T], axis=1)
