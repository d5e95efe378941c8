"""Moments in closed form and as sums."""

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st
from strategies import messy_meshes

from scenewidget.engine.mesh import Mesh
from scenewidget.engine.moments import face_moments, group_moments, mean_normals, moment_origin


def whole(mesh):
    return face_moments(mesh).gather(np.zeros(mesh.n_faces, int), 1)


def test_a_rectangle_has_the_moments_of_the_textbook():
    mesh = shapes.grid_square(7)
    a, b = 3.0, 0.5
    moments = whole(Mesh(mesh.vertices * [a, b, 1] + [10, 20, 30], mesh.faces))
    np.testing.assert_allclose(moments.area, a * b)
    np.testing.assert_allclose(moments.centroid, 0, atol=1e-12)  # about the centre of the bounding box
    np.testing.assert_allclose(moments.scatter[0], np.diag([b * a**3, a * b**3, 0]) / 12, atol=1e-12)
    values, vectors = moments.principal()
    np.testing.assert_allclose(values[0], [0, a * b**3 / 12, b * a**3 / 12], atol=1e-12)
    np.testing.assert_allclose(np.abs(vectors[0]), [[0, 0, 1], [0, 1, 0], [1, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(moments.flatness(), 0, atol=1e-12)


def test_a_vertex_in_no_face_costs_no_digits():
    mesh = shapes.grid_square(7)
    stray = Mesh(np.concatenate([mesh.vertices, [[1e9, 1e9, 1e9]]]), mesh.faces)
    np.testing.assert_array_equal(moment_origin(stray), moment_origin(mesh))
    np.testing.assert_allclose(whole(stray).principal()[0], [[0, 1 / 12, 1 / 12]], atol=1e-12)


def test_the_surface_of_a_cube_is_as_wide_in_every_direction():
    moments = whole(shapes.box(3))
    np.testing.assert_allclose(
        moments.scatter[0], 5 / 6 * np.eye(3), atol=1e-12
    )  # 2/4 + 4/12 of six unit squares
    assert moments.flatness() == pytest.approx(1)


@given(messy_meshes(), st.integers(0, 99))
def test_moments_are_those_of_sampled_points(mesh, seed):
    """Midpoints of the edges integrate quadratics over a triangle exactly."""
    corners = mesh.vertices[mesh.faces] - moment_origin(mesh)
    middle = (corners + np.roll(corners, 1, axis=1)) / 2
    moments = face_moments(mesh)
    np.testing.assert_allclose(moments.first, mesh.face_areas[:, None] * middle.mean(axis=1), atol=1e-12)
    second = np.einsum("fki,fkj->fij", middle, middle) / 3
    np.testing.assert_allclose(moments.second, mesh.face_areas[:, None, None] * second, atol=1e-12)


@given(messy_meshes(), st.data())
def test_gathering_in_two_steps_is_gathering_at_once(mesh, data):
    n = mesh.n_faces
    fine = np.array(data.draw(st.lists(st.integers(-1, 4), min_size=n, max_size=n)))
    coarse = np.array([0, 1, 0, -1, 1])
    direct = face_moments(mesh).gather(np.where(fine >= 0, coarse[fine], -1), 2)
    steps = face_moments(mesh).gather(fine, 5).gather(coarse, 2)
    for a, b in zip((direct.area, direct.first, direct.second), (steps.area, steps.first, steps.second)):
        np.testing.assert_allclose(a, b, atol=1e-12)


@given(messy_meshes(), st.data())
def test_moments_of_groups_are_gathered_moments_of_faces(mesh, data):
    group = np.array(data.draw(st.lists(st.integers(-1, 3), min_size=mesh.n_faces, max_size=mesh.n_faces)))
    expected, found = face_moments(mesh).gather(group, 4), group_moments(mesh, group, 4)
    for name in ("area", "first", "second"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=1e-9, atol=1e-12)


@given(st.integers(0, 99))
def test_flatness_does_not_depend_on_place_and_size(seed):
    mesh = shapes.blob(2)
    assert whole(shapes.moved(mesh, seed=seed, scale=0.01)).flatness() == pytest.approx(
        whole(mesh).flatness()
    )


def test_pieces_without_area_are_flat_points_at_the_origin():
    moments = face_moments(shapes.triangle()).gather(np.array([-1]), 2)
    assert moments.area.dtype == np.float64
    assert moments.area.tolist() == [0, 0]
    assert moments.centroid.tolist() == [[0, 0, 0]] * 2
    assert moments.flatness().tolist() == [0, 0]


def test_the_mean_normal_is_by_area_and_zero_where_normals_cancel():
    box = shapes.box(2, size=(1.0, 2.0, 3.0))
    side = shapes._side(box)
    unit = mean_normals(box.face_vectors, side, 7)
    np.testing.assert_allclose(np.abs(unit[:6]).max(axis=1), 1)
    np.testing.assert_allclose(unit[side], box.face_normals, atol=1e-12)
    assert unit[6].tolist() == [0, 0, 0]
    np.testing.assert_allclose(
        mean_normals(np.array([[0, 0, 3.0], [4.0, 0, 0]]), np.zeros(2, int), 1), [[0.8, 0, 0.6]]
    )
    assert mean_normals(box.face_vectors, np.where(side < 6, -1, 0), 1).tolist() == [[0, 0, 0]]
