"""Descriptors of vertices against closed forms and identities."""

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st
from strategies import clean_meshes, messy_meshes

from scenewidget.engine.features import (
    delta_coordinates,
    global_point_signature,
    heat_kernel_signature,
    heat_kernel_times,
    mean_curvature,
    vertex_to_face,
    wave_kernel_energies,
    wave_kernel_signature,
)
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.operators import eigenbasis
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import segment

# --- delta coordinates ----------------------------------------------------------------------------


def test_delta_coordinates_of_a_sphere_are_twice_the_mean_curvature_normal():
    sphere = shapes.icosphere(4, radius=2.0)
    expected = 2 * 0.5 * sphere.vertices / 2.0  # 2 H n with H = 1/r
    np.testing.assert_allclose(delta_coordinates(sphere), expected, atol=0.005)
    np.testing.assert_allclose(mean_curvature(sphere), 0.5, rtol=0.005)


def test_mean_curvature_of_a_cylinder_is_half_its_inverse_radius():
    sheet = shapes.grid_square(60)
    angle = np.pi * sheet.vertices[:, 0]
    half_cylinder = np.column_stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), sheet.vertices[:, 1]])
    inner = ((sheet.vertices[:, :2] > 0) & (sheet.vertices[:, :2] < 1)).all(axis=1)
    curvature = mean_curvature(Mesh(half_cylinder, sheet.faces))
    np.testing.assert_allclose(curvature[inner], 1.0, rtol=1e-3)


def test_inner_vertices_of_a_plane_have_no_delta_and_no_curvature():
    square = shapes.grid_square(6)
    inner = ((square.vertices[:, :2] > 0) & (square.vertices[:, :2] < 1)).all(axis=1)
    np.testing.assert_allclose(delta_coordinates(square)[inner], 0.0, atol=1e-11)
    np.testing.assert_allclose(delta_coordinates(square, "uniform")[inner], 0.0, atol=1e-12)


def test_uniform_delta_is_valence_times_the_step_from_the_mean_of_the_neighbours():
    mesh = shapes.tetrahedron()
    means = np.stack([np.delete(mesh.vertices, i, axis=0).mean(axis=0) for i in range(4)])
    np.testing.assert_allclose(delta_coordinates(mesh, "uniform"), 3 * (mesh.vertices - means))


@given(clean_meshes(), st.integers(0, 99), st.floats(0.1, 10))
def test_delta_coordinates_turn_and_scale_with_the_mesh(mesh, seed, scale):
    moved = shapes.moved(mesh, seed=seed, scale=scale)
    turn = shapes.rotation(seed)
    cotangent, uniform = delta_coordinates(mesh) @ turn.T, delta_coordinates(mesh, "uniform") @ turn.T
    np.testing.assert_allclose(
        delta_coordinates(moved) * scale, cotangent, atol=1e-8 * np.abs(cotangent).max()
    )
    np.testing.assert_allclose(delta_coordinates(moved, "uniform") / scale, uniform, atol=1e-10)


@given(messy_meshes())
def test_delta_coordinates_of_any_triangles_are_finite_and_zero_where_no_face_is(mesh):
    is_unused = ~np.isin(np.arange(mesh.n_vertices), mesh.faces)
    for kind in ("cotangent", "uniform"):
        delta = delta_coordinates(mesh, kind)
        assert np.isfinite(delta).all()
        np.testing.assert_array_equal(delta[is_unused], 0.0)


def test_delta_coordinates_keep_their_digits_far_from_the_origin():
    sphere = shapes.icosphere(2)
    far = Mesh(sphere.vertices + 4096.0, sphere.faces)
    np.testing.assert_allclose(delta_coordinates(far), delta_coordinates(sphere), atol=1e-8)


def test_an_unknown_kind_is_refused():
    with pytest.raises(ValueError, match='kind must be "cotangent" or "uniform", got \'robust\''):
        delta_coordinates(shapes.triangle(), "robust")


# --- global point signature -----------------------------------------------------------------------


def test_signature_is_eigenfunctions_over_roots_of_eigenvalues_without_the_zero_mode():
    basis = eigenbasis(shapes.blob(2), 12)
    expected = basis.vectors[:, 1:] / np.sqrt(basis.values[1:])
    np.testing.assert_allclose(global_point_signature(basis), expected)


@given(st.integers(0, 20), st.floats(0.1, 10))
def test_signature_does_not_depend_on_position_orientation_and_scale(seed, scale):
    mesh = shapes.blob(1, seed=seed)
    expected = global_point_signature(eigenbasis(mesh, 6))
    moved = shapes.moved(mesh, seed=seed, scale=scale)
    np.testing.assert_allclose(global_point_signature(eigenbasis(moved, 6)), expected, atol=1e-6)


def test_each_component_is_described_as_if_alone():
    pieces = shapes.blob(2), shapes.blob(1, seed=1), shapes.triangle()
    scene = shapes.joined(*pieces, gap=9.0)
    mesh = Mesh([*scene.vertices, [0, 0, 0]], scene.faces)  # the last vertex is in no face
    basis = eigenbasis(mesh, 8, per_component=True)
    signature = global_point_signature(basis)
    assert signature.shape == (mesh.n_vertices, 7)
    for i, piece in enumerate(pieces):
        alone = eigenbasis(piece, 8)
        own = signature[basis.component == i]
        np.testing.assert_allclose(own[:, : alone.k - 1], global_point_signature(alone), atol=1e-6)
        np.testing.assert_array_equal(own[:, alone.k - 1 :], 0.0)
        times = [0.0, 0.1, 1.0]
        heat = heat_kernel_signature(basis, times)[basis.component == i]
        np.testing.assert_allclose(heat, heat_kernel_signature(alone, times), rtol=1e-6)
        energies, sigma = [0.5, 1.5], 1.0
        wave = wave_kernel_signature(basis, energies, sigma)[basis.component == i]
        np.testing.assert_allclose(wave, wave_kernel_signature(alone, energies, sigma), rtol=1e-5)
    for described in (signature, heat_kernel_signature(basis), wave_kernel_signature(basis)):
        np.testing.assert_array_equal(described[-1], 0.0)


def test_all_zero_modes_of_a_scene_are_dropped():
    mesh = shapes.joined(shapes.blob(1), shapes.box(2), gap=9.0)
    assert global_point_signature(eigenbasis(mesh, 10)).shape == (mesh.n_vertices, 8)


# --- heat kernel signature ------------------------------------------------------------------------


def test_heat_on_a_mesh_is_the_sum_of_its_decays():
    basis = eigenbasis(shapes.torus(), 30)
    times = heat_kernel_times(basis)
    signature = heat_kernel_signature(basis)
    assert signature.shape == (512, 100)
    np.testing.assert_allclose(basis.mass @ signature, np.exp(-np.outer(times, basis.values)).sum(axis=1))
    scaled = heat_kernel_signature(basis, scaled=True)
    np.testing.assert_allclose(basis.mass @ scaled, 1.0)


def test_heat_spreads_evenly_in_the_end_and_ever_less_is_left():
    sphere = shapes.icosphere(3)
    basis = eigenbasis(sphere, 16)
    signature = heat_kernel_signature(basis, [0.0, 0.1, 1.0, 100.0])
    np.testing.assert_allclose(signature[:, -1], 1 / basis.mass.sum())
    assert (np.diff(signature, axis=1) <= 0).all()


def test_heat_on_the_sphere_is_the_same_everywhere_and_known():
    basis = eigenbasis(shapes.icosphere(4), 16)
    degree = np.arange(4)
    t = 0.5
    expected = ((2 * degree + 1) * np.exp(-degree * (degree + 1) * t)).sum() / (4 * np.pi)
    np.testing.assert_allclose(heat_kernel_signature(basis, [t])[:, 0], expected, rtol=0.01)


def test_times_span_the_spectrum():
    basis = eigenbasis(shapes.icosphere(3), 16)
    times = heat_kernel_times(basis, 5)
    np.testing.assert_allclose(times[[0, -1]] * basis.values[[-1, 1]], 4 * np.log(10))
    np.testing.assert_allclose(times[1:] / times[:-1], times[1] / times[0])


# --- wave kernel signature ------------------------------------------------------------------------


def test_wave_kernel_signature_matches_its_definition():
    basis = eigenbasis(shapes.blob(2), 10)
    energies, sigma = wave_kernel_energies(basis, 6)
    log_values = np.log(basis.values[1:])
    expected = np.empty((len(basis.vectors), 6))
    for j, e in enumerate(energies):
        g = np.exp(-((e - log_values) ** 2) / (2 * sigma**2))
        expected[:, j] = (basis.vectors[:, 1:] ** 2 @ g) / g.sum()
    np.testing.assert_allclose(wave_kernel_signature(basis, energies), expected)
    np.testing.assert_allclose(basis.mass @ expected, 1.0)


def test_energies_leave_two_sigma_at_both_ends():
    basis = eigenbasis(shapes.blob(2), 40)
    energies, sigma = wave_kernel_energies(basis)
    assert len(energies) == 100
    assert sigma == pytest.approx(7 * (energies[-1] - energies[0]) / 100)
    low, high = np.log(basis.values[[1, -1]])
    np.testing.assert_allclose([energies[0] - 2 * sigma, energies[-1] + 2 * sigma], [low, high])


def test_energies_far_from_the_spectrum_still_have_a_signature():
    basis = eigenbasis(shapes.blob(1), 10)
    signature = wave_kernel_signature(basis, [-1000.0, 1000.0], sigma=0.1)
    np.testing.assert_allclose(signature, basis.vectors[:, [1, -1]] ** 2, atol=1e-9)


def test_a_basis_with_one_nonzero_eigenvalue_has_a_wave_kernel_signature():
    signature = wave_kernel_signature(eigenbasis(shapes.blob(1), 2))
    assert np.isfinite(signature).all()


@given(st.integers(0, 20), st.floats(0.1, 10))
def test_signatures_scale_as_one_over_an_area(seed, scale):
    mesh = shapes.blob(1, seed=seed)
    basis, scaled = eigenbasis(mesh, 6), eigenbasis(shapes.moved(mesh, seed=seed, scale=scale), 6)
    for signature in (heat_kernel_signature, wave_kernel_signature):
        np.testing.assert_allclose(signature(scaled) * scale**2, signature(basis), rtol=1e-4, atol=1e-6)


# --- any triangles --------------------------------------------------------------------------------


@given(messy_meshes(), st.booleans())
def test_signatures_of_any_triangles_are_finite(mesh, per_component):
    basis = eigenbasis(mesh, 12, per_component=per_component)
    times = [0.0, 0.1, 10.0]
    for signature in (
        global_point_signature(basis),
        heat_kernel_signature(basis),
        heat_kernel_signature(basis, times, scaled=True),
        wave_kernel_signature(basis),
    ):
        assert np.isfinite(signature).all()
        assert np.isfinite(vertex_to_face(mesh, signature)).all()
        np.testing.assert_array_equal(signature[basis.component < 0], 0.0)


# --- bad arguments --------------------------------------------------------------------------------


def test_bad_samples_are_refused():
    basis = eigenbasis(shapes.blob(1), 5)
    with pytest.raises(
        ValueError, match=r"times must be finite numbers, shape \(n_times,\), got shape \(0,\)"
    ):
        heat_kernel_signature(basis, [])
    with pytest.raises(ValueError, match=r"times must not be negative, got -1\.0"):
        heat_kernel_signature(basis, [-1.0])
    with pytest.raises(ValueError, match="energies must be finite"):
        wave_kernel_signature(basis, [np.nan])
    with pytest.raises(ValueError, match="sigma must be a positive number, got 0"):
        wave_kernel_signature(basis, [1.0], sigma=0)
    with pytest.raises(ValueError, match="n_times must be at least 1, got 0"):
        heat_kernel_times(basis, 0)
    with pytest.raises(TypeError, match="n_energies must be a whole number"):
        wave_kernel_energies(basis, 1.5)


def test_a_basis_of_zero_modes_only_says_how_to_get_more():
    mesh = shapes.joined(shapes.blob(1), shapes.box(2), gap=9.0)
    with pytest.raises(ValueError, match=r"only zero modes.*2 components.*k > 2, or for per_component=True"):
        heat_kernel_signature(eigenbasis(mesh, 2))
    sliver = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]])  # a zero mode more
    params = Params(feature="wks", n_eigenpairs=2)
    with pytest.raises(ValueError, match=r"only zero modes.*with segment, set n_eigenpairs to 3 or more"):
        segment(sliver, params)
    assert segment(sliver, params.replace(n_eigenpairs=3)).n_segments == 1


# --- lift to faces --------------------------------------------------------------------------------


def test_a_face_has_the_mean_of_its_corners():
    mesh = Mesh(np.eye(4, 3), [[0, 1, 2], [3, 2, 1]])
    np.testing.assert_allclose(vertex_to_face(mesh, [0.0, 3.0, 6.0, 9.0]), [3.0, 6.0])
    np.testing.assert_allclose(vertex_to_face(mesh, mesh.vertices), mesh.face_centroids)


def test_values_of_the_wrong_length_are_refused():
    with pytest.raises(ValueError, match=r"a row for each of the 3 vertices, got shape \(1, 3\)"):
        vertex_to_face(shapes.triangle(), np.zeros((1, 3)))
