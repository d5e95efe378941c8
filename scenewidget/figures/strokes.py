"""Arrows and lines as triangles: needles for vectors, ribbons for isolines and edges.

Ribbons lie on the surface, a little in front of it, and face where it faces, so they vanish with it when
it is seen from behind.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["edge_segments", "isoline_segments", "markers", "needles", "ribbons"]

Segments = tuple[FloatArray, IntArray]
"""(n, 2, 3) ends, and the (n,) triangle that each lies in."""


def needles(starts: FloatArray, vectors: FloatArray, width: float) -> FloatArray:
    """Slim three-sided pyramids from each start along its vector, (3 n, 3, 3); none for vectors of length 0.

    Parameters
    ----------
    starts, vectors : (n, 3) float
    width : float
        Radius of the foot, metres; at most an eighth of the length.

    Examples
    --------
    >>> import numpy as np
    >>> needles(np.zeros((1, 3)), np.array([[0.0, 0.0, 2.0]]), width=0.1).shape
    (3, 3, 3)
    """
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    keep = length[:, 0] > 0
    starts, vectors, length = starts[keep], vectors[keep], length[keep]
    along = vectors / length
    across = np.cross(along, np.eye(3)[np.abs(along).argmin(axis=1)])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(along, across)
    radius = np.minimum(width, length / 8)
    turns = 2 * np.pi * np.arange(3) / 3
    foot = [starts + radius * (np.cos(turn) * across + np.sin(turn) * other) for turn in turns]
    tip = starts + vectors
    sides = [np.stack([foot[i], foot[(i + 1) % 3], tip], axis=1) for i in range(3)]
    return np.stack(sides, axis=1).reshape(-1, 3, 3)


def markers(places: FloatArray, radius: float) -> FloatArray:
    """Octahedra around the places, (8 n, 3, 3).

    Examples
    --------
    >>> import numpy as np
    >>> markers(np.zeros((2, 3)), radius=0.1).shape
    (16, 3, 3)
    """
    axes = radius * np.concatenate([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    corners: FloatArray = places[:, None, None] + axes[faces]
    return corners.reshape(-1, 3, 3)


def ribbons(segments: Segments, normals: FloatArray, width: float, *, both_sides: bool) -> FloatArray:
    """Flat strips along segments, (2 n, 3, 3) or (4 n, 3, 3), half a width in front of the surface.

    Parameters
    ----------
    normals : (n_triangles, 3) float
        Of the triangles that the segments lie in.
    width : float
        Metres.
    both_sides : bool
        A second strip behind the surface, for those that are seen from both sides.

    Examples
    --------
    >>> import numpy as np
    >>> segments = np.array([[[0.0, 0, 0], [1, 0, 0]]]), np.array([0])
    >>> ribbons(segments, np.array([[0.0, 0.0, 1.0]]), 0.1, both_sides=False).shape
    (2, 3, 3)
    """
    ends, triangle = segments
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    keep = length > 0
    ends, along, normal = ends[keep], along[keep] / length[keep, None], normals[triangle[keep]]
    side = 0.5 * width * np.cross(normal, along)
    strips = []
    for sign in (1.0, -1.0) if both_sides else (1.0,):
        start, end = (ends[:, i] + sign * 0.5 * width * normal for i in range(2))
        left, right = sign * side, -sign * side
        strips += [
            np.stack([start + left, start + right, end + right], axis=1),
            np.stack([start + left, end + right, end + left], axis=1),
        ]
    return np.concatenate(strips)


def isoline_segments(corners: FloatArray, values: FloatArray, levels: FloatArray) -> Segments:
    """Where a function that is linear in each triangle takes these values.

    Parameters
    ----------
    corners : (n_triangles, 3, 3) float
    values : (n_triangles, 3) float
        At the corners. Triangles with a NaN are left out.
    levels : (n_levels,) float
        A corner exactly at a level counts as above it.

    Examples
    --------
    >>> import numpy as np
    >>> corners = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    >>> ends, triangle = isoline_segments(corners, np.array([[0.0, 1.0, 1.0]]), np.array([0.5]))
    >>> ends.tolist(), triangle.tolist()
    ([[[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]]], [0])
    """
    found_ends, found_triangles = [], []
    for level in levels:
        above = values >= level
        n_above = above.sum(axis=1)
        triangle = np.flatnonzero(((n_above == 1) | (n_above == 2)) & np.isfinite(values).all(axis=1))
        is_alone = above[triangle] == (n_above[triangle] == 1)[:, None]
        lone = is_alone.argmax(axis=1)  # the corner on its own side of the level
        ends = []
        for step in (1, 2):
            other = (lone + step) % 3
            a, b = values[triangle, lone], values[triangle, other]
            share = ((level - a) / (b - a))[:, None]
            ends.append((1 - share) * corners[triangle, lone] + share * corners[triangle, other])
        found_ends.append(np.stack(ends, axis=1))
        found_triangles.append(triangle)
    return np.concatenate(found_ends), np.concatenate(found_triangles)


def edge_segments(faces: IntArray, corners: FloatArray) -> Segments:
    """Every edge once, in one of its triangles.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> ends, triangle = edge_segments(mesh.faces, mesh.vertices[mesh.faces])
    >>> len(ends)  # each of the edges once
    16
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    key = np.minimum(start, end).astype(np.int64) * (int(faces.max()) + 1) + np.maximum(start, end)
    _, first = np.unique(key, return_index=True)
    triangle, corner = np.divmod(first, 3)
    ends = np.stack([corners[triangle, corner], corners[triangle, (corner + 1) % 3]], axis=1)
    return ends, triangle
