"""Where the two-seed cut puts its boundary."""

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st
from strategies import messy_meshes

from scenewidget.editing.cut import cut_segment
from scenewidget.engine.mesh import Mesh


def step(n=20):
    """A floor, a riser and a tread, n × n cells each: two creases, at x = 1, one concave, one convex."""
    square = shapes.grid_square(n).vertices
    floor, riser, tread = square, square[:, [2, 1, 0]] + np.array([1, 0, 0]), square + np.array([1, 0, 1])
    vertices, place = np.unique(
        np.round(np.concatenate([floor, riser, tread]), 9), axis=0, return_inverse=True
    )
    faces = np.concatenate([shapes.grid_square(n).faces + k * len(square) for k in range(3)])
    faces[2 * n * n : 4 * n * n] = faces[2 * n * n : 4 * n * n, ::-1]
    return Mesh(vertices, place.ravel()[faces])


def test_the_boundary_follows_the_crease_between_the_seeds():
    mesh = step()
    part = np.arange(mesh.n_faces) // 800
    faces = np.flatnonzero(part < 2)
    for face_a, face_b in ((0, 1599), (430, 1200), (790, 810), (1599, 3)):
        is_b = cut_segment(mesh, faces, face_a, face_b)
        expected = part[faces] == part[face_b]
        np.testing.assert_array_equal(is_b, expected)


def test_noise_does_not_move_the_boundary_far():
    mesh = step(40)
    noise = np.random.default_rng(0).normal(scale=0.004, size=mesh.vertices.shape)
    mesh = Mesh(mesh.vertices + noise, mesh.faces)
    part = np.arange(mesh.n_faces) // 3200
    faces = np.flatnonzero(part < 2)
    is_b = cut_segment(mesh, faces, 100, 6000)
    assert np.mean(is_b == (part[faces] == 1)) > 0.99


def test_a_plane_is_cut_in_two_near_the_middle():
    mesh = shapes.grid_square(20)
    is_b = cut_segment(mesh, np.arange(800), 0, 799)
    assert 0.3 < is_b.mean() < 0.7


def test_a_bottleneck_is_the_cheapest_boundary():
    wide = shapes.grid_square(10)
    keep = (np.abs(wide.face_centroids[:, 0] - 0.55) > 0.05) | (
        np.abs(wide.face_centroids[:, 1] - 0.55) < 0.05
    )
    mesh = Mesh(wide.vertices, wide.faces[keep])
    x = mesh.face_centroids[:, 0]
    is_b = cut_segment(mesh, np.arange(mesh.n_faces), int(x.argmin()), int(x.argmax()))
    assert not is_b[x < 0.5].any()
    assert is_b[x > 0.6].all()


def test_pieces_apart_go_to_the_nearer_seed():
    mesh = shapes.joined(*[shapes.grid_square(3)] * 4, gap=2.0)
    piece = np.arange(mesh.n_faces) // 18
    is_b = cut_segment(mesh, np.arange(mesh.n_faces), 0, 71)
    np.testing.assert_array_equal(is_b, piece >= 2)
    is_b = cut_segment(mesh, np.arange(mesh.n_faces), 0, 17)  # both in the first piece
    assert len({bool(x) for x in is_b[18:]}) == 1


@given(messy_meshes(), st.data())
def test_seeds_end_on_their_own_sides_of_any_mesh(mesh, data):
    faces = np.unique(data.draw(st.lists(st.integers(0, mesh.n_faces - 1), min_size=2, max_size=20)))
    if len(faces) < 2:
        return
    face_a, face_b = data.draw(st.permutations(faces.tolist()))[:2]
    is_b = cut_segment(mesh, faces, face_a, face_b)
    assert not is_b[np.searchsorted(faces, face_a)]
    assert is_b[np.searchsorted(faces, face_b)]
    np.testing.assert_array_equal(is_b, cut_segment(mesh, faces, face_a, face_b))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_units_do_not_matter(scale):
    mesh = step(10)
    scaled = Mesh(mesh.vertices * scale, mesh.faces)
    faces = np.arange(400)
    np.testing.assert_array_equal(cut_segment(scaled, faces, 3, 390), cut_segment(mesh, faces, 3, 390))
