"""Laplacians and eigenbasis against closed forms, identities, libigl and dense solvers."""

import importlib.util
import threading

import igl
import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st
from scipy import linalg
from scipy.sparse.linalg import splu
from strategies import clean_meshes, messy_meshes

from scenewidget.datasets import analytic
from scenewidget.engine import operators
from scenewidget.engine.mesh import Mesh, MeshError
from scenewidget.engine.monitor import Cancelled, Monitor
from scenewidget.engine.operators import (
    Eigenbasis,
    cotangent_laplacian,
    eigenbasis,
    mixed_areas,
    uniform_laplacian,
    vertex_components,
)

needs_robust = pytest.mark.skipif(
    importlib.util.find_spec("robust_laplacian") is None, reason="extra `robust` not installed"
)
NO_AREA = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [0, 0, 1]])


def dense(matrix):
    return matrix.toarray()


# --- uniform Laplacian ----------------------------------------------------------------------------


def test_uniform_laplacian_of_two_triangles_is_valence_minus_adjacency():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    expected = [[3, -1, -1, -1], [-1, 2, -1, 0], [-1, -1, 3, -1], [-1, 0, -1, 2]]
    np.testing.assert_array_equal(dense(uniform_laplacian(mesh)), expected)


@given(messy_meshes())
def test_uniform_laplacian_matches_its_definition(mesh):
    expected = np.zeros((mesh.n_vertices, mesh.n_vertices))
    for face in mesh.faces:
        for i in face:
            for j in face:
                if i != j:
                    expected[i, j] = -1
    expected -= np.diag(expected.sum(axis=1))
    np.testing.assert_array_equal(dense(uniform_laplacian(mesh)), expected)


# --- cotangent Laplacian and areas ----------------------------------------------------------------


def test_right_triangle_has_its_cotangents_and_areas():
    W, A = cotangent_laplacian(shapes.triangle())
    # right angle at vertex 0; cot at vertex 1 is 3/4, at vertex 2 it is 4/3
    expected = [[25 / 24, -2 / 3, -3 / 8], [-2 / 3, 2 / 3, 0], [-3 / 8, 0, 3 / 8]]
    np.testing.assert_allclose(dense(W), expected, atol=1e-15)
    np.testing.assert_allclose(A.diagonal(), [3.0, 1.5, 1.5])


def test_obtuse_corner_owns_half_of_its_face():
    mesh = Mesh([[0, 0, 0], [4, 0, 0], [2, 0.5, 0]], [[0, 1, 2]])
    np.testing.assert_allclose(mixed_areas(mesh), [0.25, 0.25, 0.5])


def test_an_edge_of_three_faces_adds_up_three_cotangents():
    angles = np.array([0.0, 2.0, 4.0])
    tips = np.column_stack([np.zeros(3), np.cos(angles), np.sin(angles)])
    mesh = Mesh([[-1, 0, 0], [1, 0, 0], *tips], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    W, _ = cotangent_laplacian(mesh)
    assert W[[0], [1]] == pytest.approx(0.0, abs=1e-15)  # right angles at the tips
    assert W[[0], [2]] == pytest.approx(-0.5)  # one face, 45° opposite: cot/2
    taller = Mesh(mesh.vertices * [1, 2, 2], mesh.faces)
    cot = 3 / 4  # of 2·atan(1/2)
    assert cotangent_laplacian(taller)[0][[0], [1]] == pytest.approx(-3 * cot / 2)


@given(clean_meshes())
def test_cotangent_laplacian_and_areas_agree_with_libigl(mesh):
    V, F = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    W, A = cotangent_laplacian(mesh)
    W_igl = -igl.cotmatrix(V, F).toarray()
    np.testing.assert_allclose(dense(W), W_igl, rtol=1e-10, atol=1e-12 * np.abs(W_igl).max())
    areas = igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    np.testing.assert_allclose(A.diagonal(), areas, rtol=1e-10)


@given(messy_meshes())
def test_laplacians_are_symmetric_semidefinite_with_zero_row_sums_on_any_triangles(mesh):
    for L in (uniform_laplacian(mesh), cotangent_laplacian(mesh)[0]):
        L = dense(L)
        assert np.isfinite(L).all()
        np.testing.assert_array_equal(L, L.T)
        # a sliver's cotangents reach 1e12; whatever the size, rounding stays relative to it
        size = np.abs(L).max()
        np.testing.assert_allclose(L.sum(axis=1), 0.0, atol=1e-14 * size)
        assert linalg.eigvalsh(L)[0] > -1e-13 * size


@given(messy_meshes())
def test_mixed_areas_sum_to_the_area_of_any_mesh(mesh):
    areas = mixed_areas(mesh)
    assert (areas >= 0).all()
    assert areas.sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-13)
    assert (cotangent_laplacian(mesh)[1].diagonal() > 0).all()


def test_needles_keep_their_area():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1e-15, 5], [0, 0, 5]], [[0, 1, 2], [0, 3, 4]])
    np.testing.assert_allclose(
        mixed_areas(mesh)[3:] / mesh.face_areas[1], [0.25, 0.5]
    )  # nearly a right angle
    assert mixed_areas(mesh).sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-15)


@given(clean_meshes(), st.integers(0, 99), st.floats(0.01, 100))
def test_moving_changes_nothing_and_scaling_only_the_areas(mesh, seed, scale):
    W, A = cotangent_laplacian(mesh)
    W_moved, A_moved = cotangent_laplacian(shapes.moved(mesh, seed=seed, scale=scale))
    np.testing.assert_allclose(dense(W_moved), dense(W), atol=1e-9 * np.abs(dense(W)).max())
    np.testing.assert_allclose(A_moved.diagonal(), scale**2 * A.diagonal(), rtol=1e-9)


@given(messy_meshes(), st.randoms(use_true_random=False))
def test_laplacians_follow_a_renumbering_of_vertices_and_ignore_the_order_of_faces(mesh, random):
    order = np.array(random.sample(range(mesh.n_vertices), mesh.n_vertices))
    shuffled = shapes.with_vertices_in_order(mesh, order)
    shuffled = shapes.with_faces_in_order(
        shuffled, np.array(random.sample(range(mesh.n_faces), mesh.n_faces))
    )
    W, A = cotangent_laplacian(mesh)
    W_shuffled, A_shuffled = cotangent_laplacian(shuffled)
    size = np.abs(dense(W)).max()
    np.testing.assert_allclose(dense(W_shuffled), dense(W)[order][:, order], atol=1e-13 * size)
    np.testing.assert_allclose(A_shuffled.diagonal(), A.diagonal()[order], rtol=1e-12)
    np.testing.assert_array_equal(
        dense(uniform_laplacian(shuffled)), dense(uniform_laplacian(mesh))[order][:, order]
    )


def test_a_mesh_without_area_is_refused():
    with pytest.raises(MeshError, match=r"all 2 faces are degenerate.*no area"):
        cotangent_laplacian(NO_AREA)
    with pytest.raises(MeshError, match="no area"):
        eigenbasis(NO_AREA, 2)
    np.testing.assert_array_equal(mixed_areas(NO_AREA), 0.0)


# --- components -----------------------------------------------------------------------------------


def test_components_are_numbered_by_their_first_vertex_and_unused_vertices_have_none():
    mesh = Mesh(np.eye(8, 3), [[7, 5, 6], [0, 2, 4]])
    np.testing.assert_array_equal(vertex_components(mesh), [0, -1, 0, -1, 0, 1, 1, 1])


# --- eigenbasis -----------------------------------------------------------------------------------


def assert_is_eigenbasis(mesh, basis, *, laplacian="cotangent", tolerance=1e-8):
    """W φ = λ A φ and Φᵀ A Φ = 1, relative to the largest eigenvalue."""
    W = uniform_laplacian(mesh) if laplacian == "uniform" else cotangent_laplacian(mesh)[0]
    A = basis.mass[:, None]
    residual = W @ basis.vectors / A - basis.vectors * basis.values
    size = np.sqrt((A * basis.vectors**2).sum(axis=0))
    np.testing.assert_allclose(size, 1.0, atol=1e-10)
    gram = basis.vectors.T @ (A * basis.vectors)
    np.testing.assert_allclose(gram, np.eye(basis.k), atol=1e-9)
    assert np.sqrt((A * residual**2).sum(axis=0)).max() <= tolerance * basis.values[-1]


def test_spectrum_of_the_unit_sphere_is_l_times_l_plus_1():
    mesh = shapes.icosphere(4)  # 2 562 vertices: iterative
    basis = eigenbasis(mesh, 16)
    degree = np.repeat(np.arange(4), 2 * np.arange(4) + 1)
    np.testing.assert_allclose(basis.values, degree * (degree + 1), rtol=0.005)
    assert basis.values[0] == 0.0
    assert_is_eigenbasis(mesh, basis)


def test_spectrum_of_a_square_with_free_boundary_is_pi_squared_m2_plus_n2():
    mesh = shapes.grid_square(50)
    m, n = np.meshgrid(np.arange(12), np.arange(12))
    expected = np.sort(np.pi**2 * (m**2 + n**2).ravel())[:30]
    basis = eigenbasis(mesh, 30)
    np.testing.assert_allclose(basis.values, expected, rtol=0.02)
    np.testing.assert_allclose(basis.values[:6], expected[:6], rtol=0.0025)
    assert_is_eigenbasis(mesh, basis)


def test_uniform_spectrum_of_a_tetrahedron_is_that_of_the_complete_graph():
    basis = eigenbasis(shapes.tetrahedron(), 4, laplacian="uniform")
    np.testing.assert_allclose(basis.values, [0, 4, 4, 4], atol=1e-9)
    np.testing.assert_array_equal(basis.mass, 1.0)


@pytest.mark.parametrize("laplacian", ["cotangent", "uniform"])
@pytest.mark.parametrize(
    "mesh", [shapes.grid_square(4), shapes.torus(n_major=24, n_minor=12)], ids=["square", "torus"]
)
def test_eigenvalues_agree_with_a_dense_solver(mesh, laplacian):
    W = uniform_laplacian(mesh) if laplacian == "uniform" else cotangent_laplacian(mesh)[0]
    mass = np.eye(mesh.n_vertices) if laplacian == "uniform" else dense(cotangent_laplacian(mesh)[1])
    expected = linalg.eigh(dense(W), mass, eigvals_only=True)[:20]
    basis = eigenbasis(mesh, 20, laplacian=laplacian)
    np.testing.assert_allclose(basis.values[1:], expected[1:], rtol=1e-9)
    assert_is_eigenbasis(mesh, basis, laplacian=laplacian)


def test_iteration_and_dense_solver_give_the_same_pairs(monkeypatch):
    mesh = shapes.blob(3)
    iterative = eigenbasis(mesh, 20)
    monkeypatch.setattr("scenewidget.engine.operators.DENSE_LIMIT", 10_000)
    direct = eigenbasis(mesh, 20)
    np.testing.assert_allclose(iterative.values, direct.values, rtol=1e-10)
    np.testing.assert_allclose(iterative.vectors, direct.vectors, atol=1e-7)


def test_a_full_spectrum_sums_to_the_trace():
    mesh = shapes.blob(1)
    W, A = cotangent_laplacian(mesh)
    basis = eigenbasis(mesh, mesh.n_vertices)
    assert basis.values.sum() == pytest.approx((W.diagonal() / A.diagonal()).sum(), rel=1e-9)


def test_the_zeros_count_the_components_and_each_pair_lives_on_one():
    mesh = shapes.joined(shapes.blob(3), shapes.grid_square(5), shapes.box(2), gap=5.0)
    basis = eigenbasis(mesh, 20)
    assert np.count_nonzero(basis.values == 0) == basis.n_components == 3
    assert_is_eigenbasis(mesh, basis)
    for phi in basis.vectors.T:
        assert len(set(basis.component[phi != 0])) == 1


@given(clean_meshes())
def test_the_spectrum_of_a_mesh_is_the_union_of_those_of_its_components(mesh):
    whole = eigenbasis(mesh, 10)
    parts = eigenbasis(mesh, 10, per_component=True)
    np.testing.assert_array_equal(whole.values, np.sort(parts.values.ravel())[: whole.k])


def test_each_component_of_a_scene_has_the_pairs_that_it_has_alone():
    pieces = shapes.blob(2), shapes.blob(1, seed=1), shapes.triangle()
    basis = eigenbasis(shapes.joined(*pieces, gap=6.0), 7, per_component=True)
    assert basis.values.shape == (3, 7)
    for i, piece in enumerate(pieces):
        alone = eigenbasis(piece, 7)
        np.testing.assert_allclose(basis.values[i, : alone.k], alone.values, rtol=1e-9)
        np.testing.assert_allclose(
            basis.vectors[basis.component == i, : alone.k] ** 2, alone.vectors**2, atol=1e-6
        )
    np.testing.assert_array_equal(basis.values[2, 3:], np.inf)
    np.testing.assert_array_equal(basis.vectors[basis.component == 2, 3:], 0.0)


def test_a_small_mesh_gives_as_many_pairs_as_it_has_vertices():
    basis = eigenbasis(shapes.triangle(), 50)
    assert basis.values.shape == (3,)
    assert basis.vectors.shape == (3, 3)


@given(messy_meshes(), st.integers(1, 15), st.booleans())
def test_any_triangles_have_a_finite_eigenbasis(mesh, k, per_component):
    basis = eigenbasis(mesh, k, per_component=per_component)
    assert np.isfinite(basis.vectors).all()
    assert not np.isnan(basis.values).any()
    assert (basis.values >= 0).all()
    assert (basis.values[..., 1:] >= basis.values[..., :-1]).all()
    np.testing.assert_array_equal(basis.vectors[basis.component < 0], 0.0)
    if per_component:
        np.testing.assert_array_equal(basis.values[:, 0], 0.0)
    else:
        assert np.count_nonzero(basis.values == 0) >= min(basis.n_components, k)
        assert np.isfinite(basis.values).all()
        gram = basis.vectors.T @ (basis.mass[:, None] * basis.vectors)
        np.testing.assert_allclose(gram, np.eye(basis.k), atol=1e-8)


def test_a_sliver_in_a_good_mesh_moves_the_eigenvalues_little():
    square = shapes.grid_square(30)
    middle = 0.5 * (square.vertices[0] + square.vertices[1])
    faces = [*square.faces, [0, square.n_vertices, 1]]  # no area: vertex on an edge
    mesh = Mesh([*square.vertices, middle], faces)
    expected = eigenbasis(square, 10).values[1:]
    np.testing.assert_allclose(eigenbasis(mesh, 10).values[1:], expected, rtol=1e-3)


@given(st.integers(0, 9), st.floats(0.1, 10))
def test_scaling_divides_eigenvalues_by_its_square(seed, scale):
    mesh = shapes.blob(1, seed=seed)
    basis = eigenbasis(mesh, 8)
    scaled = eigenbasis(shapes.moved(mesh, seed=seed, scale=scale), 8)
    np.testing.assert_allclose(scaled.values * scale**2, basis.values, rtol=1e-8)
    np.testing.assert_allclose(scaled.vectors * scale, basis.vectors, atol=1e-6)


def test_pairs_are_the_same_each_time_and_largest_entries_positive():
    mesh = shapes.torus()
    first, second = eigenbasis(mesh, 12), eigenbasis(mesh, 12)
    np.testing.assert_array_equal(first.vectors, second.vectors)
    assert (first.vectors.max(axis=0) >= (1 - 1e-5) * -first.vectors.min(axis=0)).all()


def test_threads_at_once_get_the_same_pairs_and_leave_blas_as_it_was():
    from threadpoolctl import threadpool_info

    def blas_threads():
        return sorted(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")

    before = blas_threads()
    mesh = shapes.torus()
    expected = eigenbasis(mesh, 12)
    results = [None] * 4

    def work(i):
        results[i] = eigenbasis(mesh, 12)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for basis in results:
        np.testing.assert_allclose(basis.values, expected.values, rtol=1e-12)
    assert blas_threads() == before


def test_cancel_stops_the_iteration():
    cancel = threading.Event()
    seen = []

    def progress(stage, fraction):
        seen.append(fraction)
        cancel.set()

    with pytest.raises(Cancelled):
        eigenbasis(shapes.torus(), 30, monitor=Monitor(progress, cancel))
    assert len(seen) == 1


def test_progress_never_runs_backward():
    seen = []
    mesh = shapes.joined(shapes.torus(), shapes.box(2), gap=5.0)
    eigenbasis(mesh, 10, monitor=Monitor(lambda stage, fraction: seen.append(fraction)))
    assert seen == sorted(seen)
    assert max(seen) <= 1.0


@pytest.mark.parametrize(
    ("k", "error", "message"),
    [(0, ValueError, "k must be at least 1, got 0"), (2.5, TypeError, "k must be a whole number, got 2.5")],
)
def test_a_bad_number_of_pairs_is_refused(k, error, message):
    with pytest.raises(error, match=message):
        eigenbasis(shapes.triangle(), k)


def test_an_unknown_laplacian_is_refused():
    with pytest.raises(
        ValueError, match=r'laplacian must be "cotangent", "uniform" or "robust", got \'graph\''
    ):
        eigenbasis(shapes.triangle(), 2, laplacian="graph")


def test_an_eigenbasis_checks_its_shapes_and_is_read_only():
    basis = eigenbasis(shapes.tetrahedron(), 3)
    assert repr(basis) == "Eigenbasis(3 pairs, 4 vertices, 1 components)"
    with pytest.raises(ValueError, match="read-only"):
        basis.vectors[0, 0] = 1.0
    with pytest.raises(ValueError, match=r"values must have shape \(k,\) or \(n_components, k\)"):
        Eigenbasis(np.zeros(2), basis.vectors, basis.mass, basis.component)
    with pytest.raises(ValueError, match=r"mass must have shape \(4,\)"):
        Eigenbasis(basis.values, basis.vectors, basis.mass[:2], basis.component)


# --- robust Laplacian -----------------------------------------------------------------------------


def test_a_pivot_that_rounding_makes_zero_is_survived(monkeypatch):
    """As on a fragment of a simulated room; SuperLU calls it "exactly singular"."""
    sphere, tried = analytic.sphere(3), []

    def once_singular(matrix, **options):
        tried.append(matrix)
        if len(tried) == 1:
            raise RuntimeError("Factor is exactly singular")
        return splu(matrix, **options)

    expected = eigenbasis(sphere, 10).values
    monkeypatch.setattr(operators, "splu", once_singular)
    assert np.allclose(eigenbasis(sphere, 10).values, expected, atol=1e-6)
    assert len(tried) == 2


@needs_robust
def test_robust_laplacian_finds_the_spectrum_of_the_sphere_too():
    basis = eigenbasis(shapes.icosphere(3), 9, laplacian="robust")
    np.testing.assert_allclose(basis.values, [0, 2, 2, 2, 6, 6, 6, 6, 6], rtol=0.02)


@needs_robust
@given(messy_meshes())
def test_robust_laplacian_takes_any_triangles(mesh):
    from scenewidget.engine.operators import robust_laplacian

    W, A = robust_laplacian(mesh)
    W = dense(W)
    np.testing.assert_allclose(W, W.T)
    np.testing.assert_allclose(W.sum(axis=1), 0.0, atol=1e-12 * np.abs(W).max())
    assert (A.diagonal() > 0).all()
    basis = eigenbasis(mesh, 5, laplacian="robust")
    assert np.isfinite(basis.vectors).all()


def test_a_missing_robust_laplacian_names_the_extra(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "robust_laplacian", None)
    with pytest.raises(ImportError, match=r'pip install "scenewidget\[robust\]"'):
        eigenbasis(shapes.triangle(), 2, laplacian="robust")
