"""Surfaces that are known in closed form, to check a method against and to learn it on.

A sphere, a torus, a square in several triangulations, a paper figure and ways to fold and to stretch it.
Metres; normals point outwards or up.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh

__all__ = ["folded", "paper_figure", "part_of", "sphere", "square", "torus"]

ARMS = ((0.0, 0.4, 1.0, 0.6), (0.4, 0.0, 0.6, 0.7), (0.4, 0.5, 0.6, 1.3))  # x, y from; x, y to


def sphere(subdivisions: int = 4, *, radius: float = 1.0) -> Mesh:
    """Around the origin, 20·4^subdivisions faces of nearly equal size.

    Parameters
    ----------
    subdivisions : int
        Of an icosahedron: each divides every face into four.
    radius : float

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import sphere
    >>> round(float(sphere(4).face_areas.sum()) / np.pi, 1)  # 4
    4.0
    """
    import trimesh  # 0.3 s to import

    shape = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Mesh(shape.vertices, shape.faces)


def torus(ring: float = 1.0, tube: float = 0.4, *, n_ring: int = 64, n_tube: int = 32) -> Mesh:
    """Around the z axis; ``ring`` is the radius of the circle in the middle of the tube.

    Parameters
    ----------
    ring : float
        Radius of the circle in the middle of the tube.
    tube : float
        Radius of the tube.
    n_ring, n_tube : int
        Cells around the axis and around the tube, two triangles each.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import torus
    >>> round(float(torus().face_areas.sum()) / (4 * np.pi**2 * 0.4), 2)
    1.0
    """
    u, v = np.meshgrid(
        2 * np.pi * np.arange(n_ring) / n_ring, 2 * np.pi * np.arange(n_tube) / n_tube, indexing="ij"
    )
    radius = ring + tube * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), tube * np.sin(v)], axis=2).reshape(-1, 3)
    a = np.arange(n_ring * n_tube).reshape(n_ring, n_tube)
    b, d = np.roll(a, -1, axis=0), np.roll(a, -1, axis=1)
    return Mesh(vertices, _cells(a, b, np.roll(b, -1, axis=1), d))


def square(
    n: int = 30,
    *,
    size: float = 1.0,
    triangulation: Literal["regular", "irregular"] = "regular",
    seed: int = 0,
) -> Mesh:
    """[0, size]² at z = 0.

    Parameters
    ----------
    n : int
        Cells along a side, two triangles each.
    size : float
        Length of a side.
    triangulation : "regular" or "irregular"
        "irregular": the inner vertices are moved at random by up to a third of a cell, and every second
        diagonal on average is flipped.
    seed : int
        Of what is irregular.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> square(2, size=3.0).face_areas.sum().item()
    9.0
    """
    if triangulation not in ("regular", "irregular"):
        raise ValueError(f'triangulation must be "regular" or "irregular", got {triangulation!r}')
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    faces = _cells(a, b, c, d)
    if triangulation == "irregular":
        rng = np.random.default_rng(seed)
        x[1:-1, 1:-1] += rng.uniform(-1 / 3, 1 / 3, (n - 1, n - 1))
        y[1:-1, 1:-1] += rng.uniform(-1 / 3, 1 / 3, (n - 1, n - 1))
        is_flipped = np.repeat(rng.random(n * n) < 0.5, 2)
        faces = np.where(is_flipped[:, None], _cells(b, c, d, a), faces)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return Mesh(vertices * (size / n), faces)


def paper_figure(n: int = 40) -> Mesh:
    """A flat cross, 1 wide and 1.3 high: left and right arm alike, the upper one longer than the lower.

    Cells have sides of 1/n, and n is a multiple of 10, so that vertices lie along the feet of the arms:
    x = 0.4, x = 0.6, y = 0.4, y = 0.6.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import paper_figure
    >>> paper_figure(10)
    Mesh(66 vertices, 84 faces)
    """
    if n <= 0 or n % 10:
        raise ValueError(f"n must be a positive multiple of 10, got {n}")
    sheet = square(2 * n, size=2.0)
    x, y, _ = sheet.face_centroids.T
    is_paper = np.zeros(sheet.n_faces, np.bool_)
    for x_low, y_low, x_high, y_high in ARMS:
        is_paper |= (x > x_low) & (x < x_high) & (y > y_low) & (y < y_high)
    return part_of(sheet, is_paper)


def folded(mesh: Mesh, axis: Literal["x", "y"], at: float, angle: float) -> Mesh:
    """Turn what lies beyond a line upwards about it, as paper is folded.

    No edge changes its length if vertices lie along the line, and the mesh is flat there: an isometry.

    Parameters
    ----------
    mesh : Mesh
    axis : "x" or "y"
        The coordinate that grows across the line.
    at : float
        Where the line is.
    angle : float
        Radians.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import folded, square
    >>> folded(square(2), "x", 0.5, np.pi / 2).vertices.max(axis=0).round(6).tolist()
    [0.5, 1.0, 0.5]
    """
    if axis not in ("x", "y"):
        raise ValueError(f'axis must be "x" or "y", got {axis!r}')
    across = "xy".index(axis)
    vertices = mesh.vertices.copy()
    is_beyond = vertices[:, across] > at - 1e-9  # on the line only what was folded before moves
    out, up = vertices[is_beyond, across] - at, vertices[is_beyond, 2]
    vertices[is_beyond, across] = at + np.cos(angle) * out - np.sin(angle) * up
    vertices[is_beyond, 2] = np.sin(angle) * out + np.cos(angle) * up
    return Mesh(vertices, mesh.faces)


def part_of(mesh: Mesh, is_kept: BoolArray) -> Mesh:
    """The mesh of the faces in ``is_kept``, (n_faces,) bool, without the vertices that only others used.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import part_of, square
    >>> part_of(square(2), np.arange(8) < 2).n_vertices
    4
    """
    used, faces = np.unique(mesh.faces[is_kept], return_inverse=True)
    colors = None if mesh.vertex_colors is None else mesh.vertex_colors[used]
    vertices: FloatArray = mesh.vertices[used]
    return Mesh(vertices, faces.reshape(-1, 3), colors)


def _cells(a: IntArray, b: IntArray, c: IntArray, d: IntArray) -> IntArray:
    """Two triangles for each four corners, cut from a to c."""
    halves = [np.stack([corner.ravel() for corner in half], axis=1) for half in ((a, b, c), (a, c, d))]
    return np.stack(halves, axis=1).reshape(-1, 3)
