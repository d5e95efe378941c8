import numpy as np
import pytest
from shapes import grid_square

from scenewidget.datasets import analytic
from scenewidget.engine.mesh import face_adjacency


def edge_lengths(mesh):
    corners = mesh.vertices[mesh.faces]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)


def test_sphere_and_torus_lie_on_their_surfaces_and_face_outwards():
    ball = analytic.sphere(3, radius=2.0)
    np.testing.assert_allclose(np.linalg.norm(ball.vertices, axis=1), 2.0)
    assert (np.einsum("ij,ij->i", ball.face_normals, ball.face_centroids) > 0).all()
    ring = analytic.torus(1.5, 0.3)
    x, y, z = ring.vertices.T
    np.testing.assert_allclose(np.hypot(np.hypot(x, y) - 1.5, z), 0.3)
    assert ring.face_areas.sum() == pytest.approx(4 * np.pi**2 * 1.5 * 0.3, rel=0.01)
    assert len(face_adjacency(ring)) == 3 * ring.n_faces // 2  # closed
    tube = np.stack([x, y, 0 * z], axis=1) * (1.5 / np.hypot(x, y))[:, None]
    out = ring.face_centroids - tube[ring.faces].mean(axis=1)
    assert (np.einsum("ij,ij->i", ring.face_normals, out) > 0).all()


@pytest.mark.parametrize("triangulation", ["regular", "irregular"])
def test_squares_are_flat_whole_and_face_up(triangulation):
    mesh = analytic.square(12, size=2.0, triangulation=triangulation, seed=3)
    assert mesh.face_areas.sum() == pytest.approx(4.0)
    np.testing.assert_allclose(mesh.face_normals, np.tile([0, 0, 1.0], (mesh.n_faces, 1)), atol=1e-12)
    assert len(face_adjacency(mesh)) == (3 * mesh.n_faces - 4 * 12) // 2


def test_folding_keeps_every_edge():
    flat = analytic.paper_figure(20)
    folded = analytic.folded(flat, "x", 0.6, 1.1)
    folded = analytic.folded(folded, "y", 0.7, -0.8)
    folded = analytic.folded(folded, "y", 0.4, 2.0)
    np.testing.assert_allclose(edge_lengths(folded), edge_lengths(flat), atol=1e-12)
    assert np.ptp(folded.vertices[:, 2]) > 0.3


def test_the_paper_figure_is_a_cross():
    mesh = analytic.paper_figure(20)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [[0, 0, 0], [1, 1.3, 0]], atol=1e-12)
    assert mesh.face_areas.sum() == pytest.approx(1.0 * 0.2 + 0.2 * 0.4 + 0.2 * 0.7)


def test_part_of_keeps_the_faces_and_drops_the_rest():
    mesh = grid_square(4)
    part = analytic.part_of(mesh, mesh.face_centroids[:, 0] < 0.5)
    assert part.face_areas.sum() == pytest.approx(0.5)
    assert part.n_vertices == 15
