"""Meshes: what is refused, plain geometry in closed form, adjacency by definition, and files."""

import itertools

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st
from strategies import messy_meshes

from scenewidget.engine.mesh import (
    MAX_FAN,
    Mesh,
    MeshError,
    ascending,
    connected_components,
    face_adjacency,
    neighbor_table,
    shared_edge_lengths,
    unique_codes,
    weld,
)

V = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
F = [[0, 1, 2]]


def test_arrays_are_copied_and_read_only():
    vertices, faces = np.array(V), np.array(F)
    mesh = Mesh(vertices, faces, np.zeros((3, 3), np.uint8))
    vertices[0] = 7
    assert mesh.vertices[0].tolist() == [0, 0, 0]
    for array in (mesh.vertices, mesh.faces, mesh.vertex_colors, mesh.face_areas, mesh.face_normals):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert (mesh.vertices.dtype, mesh.faces.dtype) == (np.float64, np.int32)


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "message"),
    [
        (V, [[0, 1, 3]], MeshError, r"faces\[0\] = \[0, 1, 3\] refers to a vertex that does not exist"),
        (V, [[0, 1, 2], [0, 1, -1]], MeshError, r"faces\[1\] = \[0, 1, -1\]"),
        (V, [[0, 1, 2**40]], MeshError, "does not exist"),
        (V, [[0, 1, np.inf]], MeshError, "does not exist"),
        (V, [[0, 1, np.nan]], TypeError, "faces must hold whole numbers"),
        (V, [[0, 1, 1.5]], TypeError, "faces must hold whole numbers"),
        (V, [[True, False, True]], TypeError, "faces must be an array of numbers"),
        (V, [["a", "b", "c"]], TypeError, "faces must be an array of numbers"),
        (V, None, TypeError, "faces must be an array of numbers"),
        (V, [], MeshError, "faces is empty"),
        (V, np.empty((0, 3), int), MeshError, "faces is empty"),
        (V, [0, 1, 2], MeshError, r"faces must have shape \(n_faces, 3\), got \(3,\)"),
        (V, [[0, 1, 2, 0]], MeshError, "split polygons into triangles"),
        (V, [[0, 1, 2], [0, 1]], MeshError, "faces must have as many entries in every row"),
        ([[0, 0], [1, 0], [0, 1]], F, MeshError, r"vertices must have shape \(n_vertices, 3\), got \(3, 2\)"),
        ([], F, MeshError, "vertices must have shape"),
        ([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], F, MeshError, r"NaN or infinite positions in 1 rows"),
        ([[0, 0, np.inf], [1, 0, 0], [0, 1, 0]], F, MeshError, "NaN or infinite"),
        (np.array(V) * 1e150, F, MeshError, r"vertices reach 1e\+150 metres .* scale the mesh to metres"),
        (np.zeros((3, 3), complex), F, TypeError, "vertices must be an array of numbers"),
    ],
)  # fmt: skip
def test_bad_arrays_are_refused(vertices, faces, error, message):
    with pytest.raises(error, match=message):
        Mesh(vertices, faces)


@pytest.mark.parametrize(
    ("colors", "message"),
    [
        (np.zeros((2, 3), np.uint8), r"vertex_colors must have shape \(3, 3\)"),
        (np.zeros((3, 2), np.uint8), "vertex_colors must have shape"),
        (np.full((3, 3), 2.0), r"vertex_colors as floats must lie in \[0, 1\]"),
        (np.full((3, 3), np.nan), "vertex_colors as floats"),
        (np.full((3, 3), 300), r"vertex_colors must lie in 0\.\.255"),
        (np.full((3, 3), -1), r"vertex_colors must lie in 0\.\.255"),
    ],
)
def test_bad_colors_are_refused(colors, message):
    with pytest.raises(MeshError, match=message):
        Mesh(V, F, colors)


def test_colors_are_bytes_whatever_they_came_as():
    floats = Mesh(V, F, [[0, 0.5, 1.0]] * 3)
    assert floats.vertex_colors.tolist() == [[0, 128, 255]] * 3
    assert Mesh(V, F, np.full((3, 4), 7)).vertex_colors.tolist() == [[7, 7, 7]] * 3


def test_unused_vertices_may_be_nan_and_faces_keep_their_order():
    mesh = Mesh([*V, [np.nan] * 3], [[2, 0, 1], [0, 0, 1], [2, 0, 1]])
    assert np.isfinite(mesh.vertices).all()
    assert mesh.faces.tolist() == [[2, 0, 1], [0, 0, 1], [2, 0, 1]]


def test_whole_floats_and_unsigned_indices_are_indices():
    assert Mesh(V, [[0.0, 1.0, 2.0]]).faces.tolist() == F
    assert Mesh(V, np.array(F, np.uint64)).faces.tolist() == F


def test_area_normal_and_centroid_of_a_right_triangle():
    mesh = shapes.triangle()
    np.testing.assert_allclose(mesh.face_areas, [6])
    np.testing.assert_allclose(mesh.face_normals, [[0, 0, 1]])
    np.testing.assert_allclose(mesh.face_centroids, [[1, 4 / 3, 0]])
    assert repr(mesh) == "Mesh(3 vertices, 1 faces)"


def test_degenerate_faces_have_no_area_and_no_normal():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [0, 1, 1]])
    assert mesh.face_areas.tolist() == [0, 0]
    assert mesh.face_normals.tolist() == [[0, 0, 0]] * 2


@given(st.integers(0, 99))
def test_areas_of_a_closed_surface_point_nowhere_in_sum(seed):
    np.testing.assert_allclose(
        shapes.moved(shapes.blob(2), seed=seed).face_vectors.sum(axis=0), 0, atol=1e-12
    )


# --- adjacency ------------------------------------------------------------------------------------


def adjacency_by_definition(mesh):
    """Pairs of faces with a common edge of two places, up to MAX_FAN of them at an edge; else a chain."""
    place = [tuple(row + 0.0) for row in mesh.vertices]
    at_edge = {}
    for f, corners in enumerate(mesh.faces.tolist()):
        for i in range(3):
            a, b = place[corners[i]], place[corners[(i + 1) % 3]]
            if a != b:
                at_edge.setdefault(frozenset((a, b)), []).append(f)
    pairs = set()
    for faces in at_edge.values():
        if len(faces) <= MAX_FAN:
            pairs |= {(min(a, b), max(a, b)) for a in faces for b in faces if a != b}
        else:
            pairs |= {(a, b) for a, b in itertools.pairwise(faces) if a != b}
    return sorted(pairs)


@given(messy_meshes(max_vertices=8, max_faces=40))
def test_adjacency_is_that_of_the_definition(mesh):
    assert [tuple(p) for p in face_adjacency(mesh).tolist()] == adjacency_by_definition(mesh)


@given(messy_meshes())
def test_a_soup_is_as_connected_as_the_mesh_it_came_from(mesh):
    np.testing.assert_array_equal(face_adjacency(shapes.soup(mesh)), face_adjacency(mesh))


@pytest.mark.parametrize("n", [2, 3, 8, 9, 30])
def test_pages_of_a_book_are_neighbours(n):
    pairs = face_adjacency(shapes.fan(n))
    assert len(pairs) == (n * (n - 1) // 2 if n <= MAX_FAN else n - 1)
    assert connected_components(n, pairs)[0] == 1


def test_adjacency_of_a_closed_manifold_is_three_a_face():
    mesh = shapes.icosphere(3)
    assert len(face_adjacency(mesh)) == mesh.n_faces * 3 // 2
    np.testing.assert_array_equal(np.bincount(face_adjacency(mesh).ravel()), 3)


@given(messy_meshes())
def test_welding_gives_the_first_vertex_at_the_same_place(mesh):
    places = {}
    expected = [places.setdefault(tuple(row + 0.0), i) for i, row in enumerate(mesh.vertices)]
    assert weld(mesh).tolist() == expected


def test_minus_zero_and_zero_are_one_place():
    mesh = Mesh([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, -0.0, 0]], [[0, 1, 2]])
    assert weld(mesh).tolist() == [0, 1, 2, 0]


@given(st.integers(1, 12), st.lists(st.tuples(st.integers(0, 11), st.integers(0, 11))))
def test_components_are_numbered_by_their_smallest_node(n, pairs):
    pairs = np.array([p for p in pairs if max(p) < n], dtype=int).reshape(-1, 2)
    count, component = connected_components(n, pairs)
    reach = np.eye(n, dtype=bool)
    reach[pairs[:, 0], pairs[:, 1]] = reach[pairs[:, 1], pairs[:, 0]] = True
    for _ in range(n):
        reach = reach @ reach
    np.testing.assert_array_equal(component[:, None] == component, reach)
    _, first = np.unique(component, return_index=True)
    assert len(first) == count
    assert (np.diff(first) > 0).all()


def test_bounds_leave_out_vertices_in_no_face():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 2, 0], [9e9, -9e9, 9e9]], [[0, 1, 2]])
    assert mesh.is_used.tolist() == [True, True, True, False]
    assert mesh.bounds.tolist() == [[0, 0, 0], [1, 2, 0]]
    with pytest.raises(ValueError, match="read-only"):
        mesh.is_used[3] = True


@given(st.lists(st.integers(0, 30), min_size=1), st.integers(31, 500))
def test_codes_are_counted_as_they_are_sorted(codes, end):
    for found, expected in zip(
        unique_codes(np.array(codes), end), np.unique(codes, return_inverse=True), strict=True
    ):
        np.testing.assert_array_equal(found, expected)


def test_shared_edges_are_measured_in_a_mesh_that_is_not_welded():
    corners = np.array([[0, 0, 0], [3, 0, 0], [3, 4, 0], [3, 4, 0], [0, 0, 0], [0, 4, 0], [9, 9, 9]], float)
    mesh = Mesh(corners, [[0, 1, 2], [3, 5, 4], [5, 4, 6]])
    assert shared_edge_lengths(mesh, np.array([[0, 1], [1, 2], [0, 2]])).tolist() == [5.0, 4.0, 0.0]


def test_what_is_known_of_faces_goes_with_those_chosen():
    mesh = shapes.room(3)[0]
    known = [mesh.face_areas, mesh.face_normals, mesh.face_centroids]
    order = np.random.default_rng(0).permutation(mesh.n_faces)[: mesh.n_faces // 2]
    chosen, anew = mesh.chosen(order), Mesh(mesh.vertices, mesh.faces[order])
    for values, expected in zip(known, (anew.face_areas, anew.face_normals, anew.face_centroids)):
        np.testing.assert_array_equal(values[order], expected)
    np.testing.assert_array_equal(chosen.face_vectors, anew.face_vectors)
    np.testing.assert_array_equal(chosen.face_normals, anew.face_normals)
    assert not chosen.face_areas.flags.writeable


@given(
    st.lists(st.sampled_from([0.0, -0.0, 0.5, 1e-30, 3.0, -2.0, np.inf, np.nan]), max_size=12),
    st.sampled_from([np.float32, np.float64]),
)
def test_ascending_is_a_stable_order_of_any_numbers(values, dtype):
    values = np.array(values, dtype)
    assert ascending(values).tolist() == np.argsort(values, kind="stable").tolist()


@given(messy_meshes())
def test_neighbors_are_listed_in_order(mesh):
    pairs = face_adjacency(mesh)
    indptr, indices = neighbor_table(mesh.n_faces, pairs)
    for f in range(mesh.n_faces):
        expected = sorted([b for a, b in pairs.tolist() if a == f] + [a for a, b in pairs.tolist() if b == f])
        assert indices[indptr[f] : indptr[f + 1]].tolist() == expected
