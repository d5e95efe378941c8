"""Meshes: what is refused, plain geometry in closed form, adjacency by definition, and files."""

import itertools
import random
import re
import struct

import numpy as np
import pytest
import shapes
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from strategies import messy_meshes

from scenewidget.engine.mesh import (
    MAX_FAN,
    Mesh,
    MeshError,
    connected_components,
    face_adjacency,
    load_mesh,
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


# --- files ----------------------------------------------------------------------------------------


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def exported(mesh, suffix, **options):
    data = as_trimesh(mesh).export(file_type=suffix, **options)
    return data.encode() if isinstance(data, str) else data


def written(folder, name, data):
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


FORMATS = [("ply", {}), ("ply", {"encoding": "ascii"}), ("obj", {}), ("off", {}), ("stl", {}), ("glb", {})]


@pytest.mark.parametrize(("suffix", "options"), FORMATS)
def test_every_format_gives_the_faces_back_in_order(tmp_path, suffix, options):
    mesh = shapes.blob(2)
    read = load_mesh(written(tmp_path, f"mesh.{suffix}", exported(mesh, suffix, **options)))
    np.testing.assert_allclose(read.vertices[read.faces], mesh.vertices[mesh.faces], atol=1e-5)
    np.testing.assert_array_equal(face_adjacency(read), face_adjacency(mesh))


def test_vertex_colors_come_along(tmp_path):
    mesh, colors = shapes.box(1), np.arange(24, dtype=np.uint8).reshape(8, 3)
    coloured = as_trimesh(mesh)
    coloured.visual.vertex_colors = colors
    for suffix in ("ply", "glb"):
        read = load_mesh(written(tmp_path, f"a.{suffix}", coloured.export(file_type=suffix)))
        np.testing.assert_array_equal(read.vertex_colors[read.faces], colors[mesh.faces])
    np.testing.assert_array_equal(load_mesh(coloured).vertex_colors, colors)
    assert load_mesh(as_trimesh(mesh)).vertex_colors is None


def test_arrays_trimeshes_and_meshes_are_taken_as_they_are():
    mesh = shapes.box(1)
    assert load_mesh(mesh) is mesh
    for source in ((mesh.vertices, mesh.faces), as_trimesh(mesh)):
        np.testing.assert_array_equal(load_mesh(source).faces, mesh.faces)


def ply(n_vertices, n_faces, body, *, binary=False):
    kind = "binary_little_endian" if binary else "ascii"
    head = (
        f"ply\nformat {kind} 1.0\nelement vertex {n_vertices}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {n_faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return head.encode() + (body if binary else body.encode())


CORNERS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
BYTES = b"".join(struct.pack("<3f", *map(float, line.split())) for line in CORNERS.splitlines())


def test_polygons_are_cut_into_triangles(tmp_path):
    obj = "".join(f"v {line}\n" for line in CORNERS.splitlines())
    for name, data in (
        ("a.ply", ply(4, 1, CORNERS + "4 0 1 2 3\n")),
        ("b.ply", ply(4, 1, BYTES + struct.pack("<B4i", 4, 0, 1, 2, 3), binary=True)),
        ("a.obj", obj + "f 1 2 3 4\n"),
        ("b.obj", obj + "vt 0 0\nf -4/-1 -3/-1 -2/-1 -1/-1\n"),
        ("a.off", f"OFF\n4 1 0\n{CORNERS}4 0 1 2 3\n"),
    ):
        mesh = load_mesh(written(tmp_path, name, data))
        assert mesh.n_faces == 2
        assert mesh.face_areas.sum() == pytest.approx(1)
        np.testing.assert_allclose(mesh.face_normals, [[0, 0, 1]] * 2)


def test_materials_do_not_reorder_the_faces_of_an_obj(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 1 2 4\n"
    mesh = load_mesh(written(tmp_path, "a.obj", text))
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    expected = corners[[[0, 1, 2], [0, 2, 3], [0, 1, 3]]]
    np.testing.assert_allclose(mesh.vertices[mesh.faces], expected)


def test_negative_indices_of_an_obj_count_back_from_their_line(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 6 1 0\nf -3 -2 -1\nf 1 2 -1\n"
    mesh = load_mesh(written(tmp_path, "a.obj", text))
    np.testing.assert_allclose(mesh.vertices[mesh.faces][:, :, 0], [[0, 1, 1], [5, 6, 6], [0, 1, 6]])


def test_parts_of_a_scene_are_put_together_with_their_transforms(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box())
    scene.add_geometry(
        trimesh.creation.box(), transform=trimesh.transformations.translation_matrix([5, 0, 0])
    )
    mesh = load_mesh(written(tmp_path, "a.glb", scene.export(file_type="glb")))
    assert mesh.n_faces == 24
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(6)


GOOD = ply(4, 2, CORNERS + "3 0 1 2\n3 0 2 3\n")
GOOD_BINARY = ply(4, 2, BYTES + struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 0, 2, 3), binary=True)
GOOD_STL = exported(shapes.box(1), "stl")
GOOD_GLB = exported(shapes.box(1), "glb")
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.ply", b"", "is empty"),
        ("a.ply", "hello", "does not start with 'ply'"),
        ("a.ply", GOOD[:40], "truncated: its PLY header has no end"),
        ("a.ply", GOOD[:-5], "truncated: its header promises 2 faces, 1 could be read"),
        ("a.ply", GOOD[:-8], "truncated: its header promises at least"),
        ("a.ply", GOOD[: GOOD.index(b"1 1 0")], "truncated"),
        ("a.ply", GOOD_BINARY[:-1], "truncated"),
        ("a.ply", GOOD_BINARY[:-20], "truncated"),
        ("a.ply", ply(4, 5, CORNERS + "4 0 1 2 3\n" * 3), "truncated: its header promises at least"),
        ("a.ply", ply(4, 10**12, BYTES, binary=True), "promises 1000000000000 of element 'face', but only"),
        ("a.ply", ply(10**9, 1, BYTES, binary=True), "promises 1000000000 of element 'vertex'"),
        ("a.ply", ply("-4", 1, CORNERS), "promises -4 of element 'vertex'"),
        ("a.ply", ply(4, 0, CORNERS), "holds no triangles, only points"),
        ("a.ply", ply(4, 1, CORNERS + "3 0 1 7\n"), "refers to a vertex that does not exist"),
        ("a.ply", ply(4, 1, CORNERS.replace("1 1 0", "1 nan 0") + "3 0 1 2\n"), "NaN or infinite"),
        (
            "a.ply",
            ply(4, 2, BYTES + struct.pack("<B4iB3i", 4, 0, 1, 2, 3, 3, 0, 1, 2), binary=True),
            "differ in their number of corners, split them",
        ),
        ("a.obj", OBJ, "holds no triangles"),
        ("a.obj", OBJ + "f 1 2 9\n", "damaged"),
        ("a.obj", OBJ + "f 1 2 3\nf 1 2", "a face with fewer than three corners"),
        ("a.obj", OBJ + "f 0 1 2\n", "a face with vertex 0"),
        ("a.obj", OBJ + "f 1/1 0/1 2/1\n", "a face with vertex 0"),
        ("a.obj", "v 0 zero 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "damaged"),
        ("a.off", "OFF\n4 2 0\n" + CORNERS + "4 0 1 2 3\n", "promises at least 8 lines"),
        ("a.off", "OFF\n4 99999999999 0\n" + CORNERS + "4 0 1 2 3\n", "damaged or truncated"),
        ("a.stl", GOOD_STL[:-10], "promises 12 faces in 684 bytes, and it has 674"),
        ("a.stl", GOOD_STL[:80] + b"\xff\xff\xff\xff" + GOOD_STL[84:], "promises 4294967295 faces"),
        ("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "does not end with 'endsolid'"),
        ("a.glb", GOOD_GLB[:-30], "damaged"),
        ("a.glb", b"glTF", "damaged"),
        ("a.txt", "hello", "suffix must be one of .ply, .obj"),
        ("noending", "hello", "suffix must be one of"),
    ],
)  # fmt: skip
def test_a_damaged_file_is_refused_with_its_name(tmp_path, name, data, message):
    with pytest.raises(MeshError, match=message) as caught:
        load_mesh(written(tmp_path, name, data))
    assert name in str(caught.value) or "faces" in str(caught.value)


def test_a_missing_file_and_a_folder_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"mesh file .*nothing\.ply.* does not exist"):
        load_mesh(tmp_path / "nothing.ply")
    with pytest.raises(MeshError, match="is a folder"):
        load_mesh(tmp_path)


@pytest.mark.parametrize("source", [None, 3, [1], {"a": 1}, np.zeros((3, 3))])
def test_what_is_no_mesh_is_refused(source):
    with pytest.raises(TypeError, match=f"mesh must be a path.*got {type(source).__name__}"):
        load_mesh(source)


def test_a_tuple_of_three_is_refused():
    with pytest.raises(TypeError, match=re.escape("must be (vertices, faces), got 3 entries")):
        load_mesh((V, F, F))


def damaged(data, rng):
    """Cut short, bytes changed, numbers changed, bytes put in or taken out."""
    data = bytearray(data)
    way = rng.randrange(5)
    if way == 0:
        return bytes(data[: rng.randrange(len(data))])
    at = rng.randrange(len(data))
    if way == 1:
        for _ in range(rng.randrange(1, 20)):
            data[rng.randrange(len(data))] = rng.randrange(256)
    elif way == 2:
        for _ in range(rng.randrange(1, 6)):
            data[rng.randrange(min(600, len(data)))] = rng.choice(b"0123456789-. \n\x00\xff")
    elif way == 3:
        data[at:at] = rng.randbytes(rng.randrange(1, 50))
    else:
        del data[at : at + rng.randrange(1, 200)]
    return bytes(data)


@pytest.mark.parametrize(("suffix", "options"), FORMATS)
def test_damaged_bytes_give_a_mesh_or_a_mesh_error(tmp_path, suffix, options):
    good = exported(shapes.box(2), suffix, **options)
    rng = random.Random(0)
    for _ in range(150):
        path = written(tmp_path, f"a.{suffix}", damaged(good, rng))
        try:
            mesh = load_mesh(path)
        except MeshError:
            continue
        assert mesh.faces.max() < mesh.n_vertices


def test_bounds_leave_out_vertices_in_no_face():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 2, 0], [9e9, -9e9, 9e9]], [[0, 1, 2]])
    assert mesh.is_used.tolist() == [True, True, True, False]
    assert mesh.bounds.tolist() == [[0, 0, 0], [1, 2, 0]]
    with pytest.raises(ValueError, match="read-only"):
        mesh.is_used[3] = True
