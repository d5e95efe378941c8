"""Meshes whose geometry is known in closed form, and changes that must not matter."""

from __future__ import annotations

import numpy as np
import trimesh

from scenewidget.engine.mesh import Mesh


def triangle() -> Mesh:
    """A right triangle with legs 3 and 4."""
    return Mesh([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]])


def tetrahedron() -> Mesh:
    """Regular, edge 2√2, around the origin, normals outward."""
    corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    return Mesh(corners, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])


def grid_square(n: int, *, size: float = 1.0) -> Mesh:
    """[0, size]² at z = 0 in n × n cells of two triangles, normals up."""
    return sheet(n, n, width=size, depth=size)


def sheet(n: int, m: int, *, width: float = 1.0, depth: float = 1.0) -> Mesh:
    """[0, width] × [0, depth] at z = 0 in n × m cells of two triangles, normals up; rows of cells in x."""
    x, y = np.meshgrid(np.linspace(0, width, n + 1), np.linspace(0, depth, m + 1), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    faces = np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1)
    return Mesh(vertices, faces.reshape(-1, 3))


def box(n: int = 1, *, size: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    """Closed box around the origin with n × n cells on each side, normals outward, vertices shared."""
    top = grid_square(n).vertices + np.array([-0.5, -0.5, 0.5])
    half_turn = [1.0, -1.0, -1.0]  # about x: the top becomes the bottom, its normals still outward
    sides = np.concatenate([np.roll(side, k, axis=1) for k in range(3) for side in (top, top * half_turn)])
    faces = np.concatenate([grid_square(n).faces + k * len(top) for k in range(6)])
    vertices, place = np.unique(np.round(sides, 12), axis=0, return_inverse=True)
    return Mesh(vertices * size, place.ravel()[faces])


def icosphere(subdivisions: int = 3, *, radius: float = 1.0) -> Mesh:
    """Sphere around the origin, 20·4^subdivisions faces, normals outward."""
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Mesh(sphere.vertices, sphere.faces)


def torus(major: float = 1.0, minor: float = 0.4, *, n_major: int = 32, n_minor: int = 16) -> Mesh:
    """Torus around the z axis, normals outward."""
    shape = trimesh.creation.torus(major, minor, major_sections=n_major, minor_sections=n_minor)
    return Mesh(shape.vertices, shape.faces)


def blob(subdivisions: int = 3, *, seed: int = 0) -> Mesh:
    """A closed surface without any symmetry, so that its eigenvalues are distinct."""
    sphere = icosphere(subdivisions)
    directions = np.random.default_rng(seed).standard_normal((4, 3))
    bumps = np.sin(2.0 * sphere.vertices @ directions.T).sum(axis=1)
    return Mesh(sphere.vertices * (1.0 + 0.15 * bumps[:, None]) * [1.0, 1.3, 1.7], sphere.faces)


def accordion(n_panels: int, *, angle: float = 1.0) -> Mesh:
    """A folding screen: panels of two triangles, each two panels at the same angle (radians), open."""
    steps = np.stack(
        [np.cos(angle / 2) * np.ones(n_panels), np.sin(angle / 2) * (-1.0) ** np.arange(n_panels)]
    )
    path = np.concatenate([np.zeros((1, 2)), np.cumsum(steps.T, axis=0)])
    low = np.column_stack([path, np.zeros(len(path))])
    i = np.arange(n_panels)
    j = i + n_panels + 1
    faces = np.stack([np.stack([i, i + 1, j + 1], axis=1), np.stack([i, j + 1, j], axis=1)], axis=1)
    return Mesh(np.concatenate([low, low + np.array([0.0, 0.0, 1.0])]), faces.reshape(-1, 3))


def joined(*meshes: Mesh, gap: float = 0.0) -> Mesh:
    """Meshes in one, not welded; each moved by ``gap`` in x from the one before."""
    starts = np.cumsum([0] + [mesh.n_vertices for mesh in meshes])
    vertices = [mesh.vertices + np.array([i * gap, 0.0, 0.0]) for i, mesh in enumerate(meshes)]
    return Mesh(np.concatenate(vertices), np.concatenate([m.faces + s for m, s in zip(meshes, starts)]))


def moved(mesh: Mesh, *, seed: int = 0, scale: float = 1.0) -> Mesh:
    """Scaled, then turned and shifted at random (a proper rotation)."""
    rng = np.random.default_rng(seed)
    return Mesh(scale * mesh.vertices @ rotation(seed).T + rng.uniform(-3, 3, 3), mesh.faces)


def rotation(seed: int = 0) -> np.ndarray:
    """(3, 3) random proper rotation."""
    Q, R = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    Q *= np.sign(np.diag(R))
    return Q * np.sign(np.linalg.det(Q))


def with_faces_in_order(mesh: Mesh, order: np.ndarray) -> Mesh:
    """The same mesh; new face i is old face order[i]."""
    return Mesh(mesh.vertices, mesh.faces[order])


def with_vertices_in_order(mesh: Mesh, order: np.ndarray) -> Mesh:
    """The same mesh; new vertex i is old vertex order[i]."""
    new_number = np.empty(mesh.n_vertices, dtype=np.int64)
    new_number[order] = np.arange(mesh.n_vertices)
    return Mesh(mesh.vertices[order], new_number[mesh.faces])


def fan(n: int) -> Mesh:
    """n right triangles at one common edge, like the pages of a book: not manifold from 3 on."""
    angle = 2.0 * np.pi * np.arange(n) / n
    tips = np.column_stack([np.cos(angle), np.sin(angle), np.full(n, 0.5)])
    return Mesh(np.concatenate([[[0, 0, 0], [0, 0, 1]], tips]), [[0, 1, 2 + i] for i in range(n)])


def fragments(n: int, *, seed: int = 0, size: float = 0.05) -> Mesh:
    """n flat squares of 8 faces each, scattered in a cube of 5 m."""
    piece = grid_square(2, size=size)
    corners = np.random.default_rng(seed).uniform(0, 5, (n, 1, 3))
    faces = piece.faces + piece.n_vertices * np.arange(n)[:, None, None]
    return Mesh((piece.vertices + corners).reshape(-1, 3), faces.reshape(-1, 3))


def soup(mesh: Mesh) -> Mesh:
    """The same triangles, each with corners of its own, as STL files have them."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * mesh.n_faces).reshape(-1, 3))


def room(n: int = 24, *, noise: float = 0.0, seed: int = 0) -> tuple[Mesh, np.ndarray]:
    """A room of 4 × 3 × 2.4 m seen from inside with a closed block of a table in it, and its parts.

    Parts: six walls by the direction of their normals, the table's five visible sides (its underside does
    not touch the floor).
    """
    walls, table = box(n, size=(4.0, 3.0, 2.4)), box(n // 2, size=(1.2, 0.8, 0.5))
    table = Mesh(table.vertices + np.array([0.3, 0.2, -0.4]), table.faces)
    part = [_side(walls), 6 + _side(table)]
    mesh = joined(Mesh(walls.vertices, walls.faces[:, ::-1]), table)
    jitter = np.random.default_rng(seed).normal(scale=noise, size=mesh.vertices.shape) if noise else 0.0
    return Mesh(mesh.vertices + jitter, mesh.faces), np.concatenate(part)


def _side(mesh: Mesh) -> np.ndarray:
    """Which of the six directions of the axes each face looks to."""
    axis = np.abs(mesh.face_normals).argmax(axis=1)
    return 2 * axis + (mesh.face_normals[np.arange(mesh.n_faces), axis] > 0)
