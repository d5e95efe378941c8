"""Every format out and in again, and each file read by a program that isn't ours."""

import dataclasses
import json
import struct
import zipfile
from xml.dom import minidom

import numpy as np
import ply_files
import pygltflib
import pytest
import shapes
import trimesh
from editing_strategies import segmentations
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.datasets.scenenn import load_scenenn
from scenewidget.editing.formats import FormatError
from scenewidget.editing.formats.common import faces_from_vertices, vertices_from_faces
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.readers import load_mesh
from scenewidget.engine.segmentation import Segmentation

NAMES = ("floor", "Tür <a&b>", "chair 1", "", "=1+1", 'q"uote\\')


def room(*, colored=True, unlabeled=True):
    """A box whose sides are named segments, a few faces of the last one unlabeled."""
    box = shapes.box(6, size=(3.0, 4.0, 2.5))
    colors = np.random.default_rng(0).integers(0, 256, box.vertices.shape) if colored else None
    mesh = Mesh(box.vertices.astype(np.float32), box.faces, colors)
    labels = np.arange(mesh.n_faces) // 72
    if unlabeled:
        labels[-10:] = -1
    levels = {"base": (np.arange(mesh.n_faces) // 24).astype(np.int32), "dihedral": np.arange(mesh.n_faces)}
    seg = Segmentation.from_labels(mesh, labels, names=NAMES, confidence=np.full(mesh.n_faces, 0.25))
    return mesh, Segmentation(mesh, seg.labels, seg.confidence, levels=levels, names=seg.names)


def by_name(segmentation, mesh):
    """Faces of each segment, by name."""
    return {name: np.flatnonzero(segmentation.labels == k) for k, name in enumerate(segmentation.names)}


FACE_FORMATS = ["a.ply", "a.npz", "a.glb", "a.npy", "a.txt"]
VERTEX_FORMATS = [("v.ply", {"per": "vertex"}), ("s.aggregation.json", {}), ("n.xml", {})]


@pytest.mark.parametrize("name", FACE_FORMATS)
def test_labels_per_face_come_back_exactly(tmp_path, name):
    mesh, seg = room()
    assert sw.export(seg, mesh, tmp_path / name) == [tmp_path / name]
    back = sw.import_labels(mesh, tmp_path / name)
    np.testing.assert_array_equal(back.labels, seg.labels)
    assert back.report["labels given per"] == "face"
    assert back.report["ambiguous faces"] == 0
    if name.endswith(("ply", "npz", "glb")):
        assert back.names == seg.names
    if name.endswith("npz"):
        np.testing.assert_array_equal(back.confidence, seg.confidence)
        np.testing.assert_array_equal(back.level("base"), seg.level("base"))


@pytest.mark.parametrize(("name", "options"), VERTEX_FORMATS)
def test_labels_per_vertex_come_back_by_majority(tmp_path, name, options):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / name, **options)
    back = sw.import_labels(mesh, tmp_path / name)
    values, ambiguous = faces_from_vertices(vertices_from_faces(seg.labels, mesh), mesh)
    np.testing.assert_array_equal(
        Segmentation.from_labels(mesh, back.labels).labels, Segmentation.from_labels(mesh, values).labels
    )
    assert back.report["ambiguous faces"] == ambiguous
    assert np.mean(back.labels == seg.labels) > 0.8
    assert set(back.names) == set(seg.names)
    for segment, faces in by_name(back, mesh).items():
        common = np.intersect1d(faces, by_name(seg, mesh)[segment])
        assert len(common) > 0.5 * len(faces)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(segmentations(), st.sampled_from(["a.ply", "a.npz", "a.glb", "a.npy"]))
def test_any_segmentation_comes_back_exactly(tmp_path, segmentation, name):
    mesh = segmentation.mesh
    sw.export(segmentation, mesh, tmp_path / name)
    back = sw.import_labels(mesh, tmp_path / name)
    np.testing.assert_array_equal(back.labels, Segmentation.from_labels(mesh, segmentation.labels).labels)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(segmentations(), st.sampled_from(["v.ply", "s.aggregation.json", "n.xml"]))
def test_any_segmentation_comes_back_by_majority(tmp_path, segmentation, name):
    mesh = segmentation.mesh
    if name == "n.xml":  # 32-bit places, as SceneNN has them
        mesh = Mesh(mesh.vertices.astype(np.float32), mesh.faces)
        segmentation = Segmentation.from_labels(mesh, segmentation.labels, names=segmentation.names)
    values, _ = faces_from_vertices(vertices_from_faces(segmentation.labels, mesh), mesh)
    if (values < 0).all():
        return
    sw.export(segmentation, mesh, tmp_path / name, **({"per": "vertex"} if name == "v.ply" else {}))
    back = sw.import_labels(mesh, tmp_path / name)
    np.testing.assert_array_equal(back.labels, Segmentation.from_labels(mesh, values).labels)


@pytest.mark.parametrize("name", ["a.ply", "a.npz", "a.glb", "s.aggregation.json", "n.xml"])
def test_groups_come_back(tmp_path, name):
    mesh, seg = room(unlabeled=False)
    names = ["wall", "cushion", "sofa", "", "cushion", ""]
    seg = dataclasses.replace(seg, names=names, groups=(0, 2, 2, 3, 2, 0))
    sw.export(seg, mesh, tmp_path / name)
    back = sw.import_labels(mesh, tmp_path / name)
    words = [(back.names[k], back.names[whole]) for k, whole in enumerate(back.groups)]
    assert sorted(words) == sorted((names[k], names[whole]) for k, whole in enumerate(seg.groups))


def test_a_group_is_one_object_to_others(tmp_path):
    mesh, seg = room(unlabeled=False)
    seg = dataclasses.replace(seg, names=["sofa", "cushion", "wall", "", "", ""], groups=(0, 0, 2, 3, 4, 5))
    sw.export(seg, mesh, tmp_path / "s.aggregation.json")
    content = json.loads((tmp_path / "s.aggregation.json").read_text())
    sofa, *others = content["segGroups"]
    assert [group["label"] for group in content["segGroups"]] == ["sofa", "wall", *["unannotated"] * 3]
    assert [part["label"] for part in sofa["parts"]] == ["sofa", "cushion"]
    assert sorted(sofa["segments"]) == sorted(number for part in sofa["parts"] for number in part["segments"])
    assert not any("parts" in group for group in others)
    sw.export(seg, mesh, tmp_path / "a.glb")
    content = pygltflib.GLTF2().load(tmp_path / "a.glb")
    node = {node.name: node for node in content.nodes}
    assert [content.nodes[k].name for k in node["sofa"].children] == ["cushion"]
    assert seg.to_frame().groupby("group")["faces"].sum().tolist() == [144, 72, 72, 72, 72]
    assert seg.things().n_segments == 5


# --- read by others -------------------------------------------------------------------------------


@pytest.mark.parametrize("per", ["face", "vertex"])
def test_trimesh_and_our_loader_read_the_ply(tmp_path, per):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / "a.ply", per=per)
    data = ply_files.read(tmp_path / "a.ply")
    instance = data[per]["instance"]
    if per == "face":
        np.testing.assert_array_equal(instance, seg.labels)
    else:
        np.testing.assert_array_equal(instance, vertices_from_faces(seg.labels, mesh))
    assert len({tuple(row) for row in zip(*(data[per][c] for c in ("red", "green", "blue")))}) == 7
    np.testing.assert_array_equal(data["face"]["vertex_indices"], mesh.faces)
    loaded = trimesh.load(tmp_path / "a.ply", process=False)
    np.testing.assert_array_equal(loaded.faces, mesh.faces)
    again = load_mesh(tmp_path / "a.ply")
    np.testing.assert_array_equal(again.vertices, mesh.vertices)
    np.testing.assert_array_equal(again.faces, mesh.faces)
    if per == "face":
        np.testing.assert_array_equal(again.vertex_colors, mesh.vertex_colors)
    np.testing.assert_array_equal(
        sw.import_labels(again, tmp_path / "a.ply").labels, sw.import_labels(mesh, tmp_path / "a.ply").labels
    )


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize("order", ["<", ">"])
def test_labels_that_other_programs_write_are_read(tmp_path, text, order):
    mesh, seg = room()
    vertex = np.zeros(mesh.n_vertices, dtype=[("x", "f8"), ("y", "f8"), ("z", "f8"), ("label", "i4")])
    for k, axis in enumerate("xyz"):
        vertex[axis] = mesh.vertices[:, k]
    vertex["label"] = vertices_from_faces(seg.labels, mesh)
    face = np.zeros(mesh.n_faces, dtype=[("vertex_indices", "i4", (3,)), ("category_id", "u2")])
    face["vertex_indices"], face["category_id"] = mesh.faces, seg.labels + 1
    ply_files.write(tmp_path / "f.ply", {"vertex": vertex, "face": face}, text=text, order=order)
    expected = Segmentation.from_labels(mesh, seg.labels + 1).labels
    np.testing.assert_array_equal(sw.import_labels(mesh, tmp_path / "f.ply").labels, expected)
    ply_files.write(tmp_path / "v.ply", {"vertex": vertex}, text=text, order=order)
    assert sw.import_labels(mesh, tmp_path / "v.ply").report["labels given per"] == "vertex"


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_trimesh_and_pygltflib_read_the_glb(tmp_path):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / "a.glb")
    scene = trimesh.load(tmp_path / "a.glb", process=False)
    assert {"floor", "Tür <a&b>", "chair 1", "unlabeled"} < set(scene.geometry)
    assert len(scene.geometry) == 7
    assert len(scene.geometry["floor"].faces) == 72
    np.testing.assert_allclose(scene.extents, [3.0, 2.5, 4.0], atol=1e-6)  # y is up
    gltf = pygltflib.GLTF2().load(str(tmp_path / "a.glb"))
    assert len(gltf.nodes[0].children) == 7
    assert gltf.accessors[gltf.meshes[0].primitives[0].indices].count == 3 * 10
    whole = load_mesh(tmp_path / "a.glb")
    assert whole.n_faces == mesh.n_faces


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("upright", [True, False])
def test_a_glb_of_another_program_is_matched_by_place(tmp_path, upright):
    mesh, seg = room(unlabeled=False)
    scene = trimesh.Scene()
    for k, name in enumerate(seg.names):
        part = trimesh.Trimesh(mesh.vertices, mesh.faces[seg.labels == k], process=False)
        scene.add_geometry(part, node_name=name or "nameless", geom_name=f"g{k}")
    if upright:
        scene.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    scene.export(str(tmp_path / "t.glb"))
    back = sw.import_labels(mesh, tmp_path / "t.glb")
    np.testing.assert_array_equal(back.labels, seg.labels)
    assert back.report["triangles that the mesh does not have"] == 0


@pytest.mark.parametrize("kind", ["ply", "obj", "glb", "stl", "off"])
def test_an_npz_fits_its_scan_in_a_file_of_fewer_digits(tmp_path, kind):
    mesh = shapes.joined(shapes.sheet(9, 7, width=1 / 3), shapes.sheet(5, 5, depth=0.7))
    labels = np.arange(mesh.n_faces) % 3 // 2  # twice as many of one kind
    sw.export(sw.Segmentation.from_labels(mesh, labels), mesh, tmp_path / "a.npz")
    sw.save_mesh(mesh, tmp_path / f"a.{kind}")
    again = sw.load_mesh(tmp_path / f"a.{kind}")
    assert (sw.import_labels(again, tmp_path / "a.npz").labels == labels).all()
    for other in (np.roll(mesh.faces, 1, axis=0), mesh.faces[::-1]):
        with pytest.raises(FormatError, match=r"belongs to another mesh than this one .* in another order"):
            sw.import_labels(sw.Mesh(mesh.vertices, other), tmp_path / "a.npz")


def test_a_scan_is_saved_by_its_suffix(tmp_path):
    mesh = shapes.sheet(2, 2)
    with pytest.raises(ValueError, match=r"a scan can be written as .ply, .obj, .* not as 'a.fbx'"):
        sw.save_mesh(mesh, tmp_path / "a.fbx")
    with pytest.raises(
        ValueError, match=r"mesh is a point cloud, which is written as .ply only, not as 'a.obj'"
    ):
        sw.save_mesh(sw.PointCloud(mesh.vertices), tmp_path / "a.obj")


def test_numpy_reads_the_npz(tmp_path):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as data:
        np.testing.assert_array_equal(data["labels"], seg.labels)
        assert data["names"].tolist() == list(seg.names)


def read_scannet(aggregation, segs):
    """Instances of vertices by the algorithm of ScanNet's export_train_mesh_for_evaluation.py."""
    groups = json.loads(aggregation.read_text())["segGroups"]
    vertices = {}
    for vertex, segment in enumerate(json.loads(segs.read_text())["segIndices"]):
        vertices.setdefault(segment, []).append(vertex)
    ids = np.zeros(sum(map(len, vertices.values())), int)
    labels = {}
    for group in groups:
        labels[group["objectId"] + 1] = group["label"]
        for segment in group["segments"]:
            ids[vertices[segment]] = group["objectId"] + 1
    return ids, labels


def test_scannets_own_algorithm_reads_its_files(tmp_path):
    mesh, seg = room()
    aggregation, segs = sw.export(seg, mesh, tmp_path / "scene0000_00.aggregation.json")
    ids, labels = read_scannet(aggregation, segs)
    expected = vertices_from_faces(seg.labels, mesh)
    for id_ in range(1, ids.max() + 1):
        (label,) = set(expected[ids == id_].tolist())
        assert labels[id_] == (seg.names[label] or "unannotated")
    assert set(expected[ids == 0].tolist()) <= {-1}
    data = json.loads(aggregation.read_text())
    assert data.keys() == {"sceneId", "appId", "seal", "segGroups", "segmentsFile"}
    assert data["segGroups"][0].keys() == {"id", "objectId", "segments", "label", "obb"}
    assert data["segmentsFile"] == "scene0000_00.segs.json"
    assert json.loads(segs.read_text()).keys() == {"params", "seal", "sceneId", "segIndices"}
    assert len(set(json.loads(segs.read_text())["segIndices"])) > len(data["segGroups"])  # base segments


def test_released_scannet_scenes_name_their_segments_in_other_ways(tmp_path):
    mesh, seg = room()
    aggregation, segs = sw.export(seg, mesh, tmp_path / "s.aggregation.json")
    expected = sw.import_labels(mesh, aggregation).labels
    segs.rename(tmp_path / "s_vh_clean_2.0.010000.segs.json")
    data = json.loads(aggregation.read_text())
    for named in ("scannet.s_vh_clean_2.0.010000.segs.json", "/etc/s_vh_clean_2.0.010000.segs.json", None, 3):
        aggregation.write_text(json.dumps(data | {"segmentsFile": named}))
        np.testing.assert_array_equal(sw.import_labels(mesh, aggregation).labels, expected)
    finer = sw.import_labels(mesh, tmp_path / "s_vh_clean_2.0.010000.segs.json")
    assert finer.n_segments > seg.n_segments


def test_scenenns_loader_reads_its_files(tmp_path):
    mesh, seg = room()
    scene, annotation = sw.export(seg, mesh, tmp_path / "016.xml")
    loaded, truth = load_scenenn(scene)
    np.testing.assert_array_equal(loaded.faces, mesh.faces)
    back = sw.import_labels(mesh, annotation)
    np.testing.assert_array_equal(truth.labels, back.labels)
    assert set(truth.names) == (set(seg.names) - {""}) | {"segment 4"}
    assert len(minidom.parse(str(annotation)).getElementsByTagName("label")) == 6
    text = annotation.read_text(encoding="utf-8")
    assert "Tür &lt;a&amp;b&gt;" in text
    assert 'nyu_class="chair"' in text
    assert len(ply_files.read(scene)["face"]["vertex_indices"]) == mesh.n_faces


def test_the_table_of_segments_opens_elsewhere(tmp_path):
    import csv

    pyarrow = pytest.importorskip("pyarrow.parquet")
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == seg.n_segments
    assert "'=1+1" in [row["name"] for row in rows]  # no formula
    assert float(rows[0]["centroid_z"]) == pytest.approx(seg.to_frame()["centroid"][0][2])
    sw.export(seg, mesh, tmp_path / "a.parquet")
    assert pyarrow.read_table(tmp_path / "a.parquet")["name"].to_pylist() == list(seg.names)
    with pytest.raises(FormatError, match="is a table of segments"):
        sw.import_labels(mesh, tmp_path / "a.csv")


# --- majority -------------------------------------------------------------------------------------


def test_majority_rules_by_hand(tmp_path):
    mesh = Mesh(np.eye(4, 3), [[0, 1, 2], [0, 1, 3], [1, 2, 3]])
    (tmp_path / "v.txt").write_text("7\n7\n2\n5\n")
    seg = sw.import_labels(mesh, tmp_path / "v.txt")
    assert seg.report["ambiguous faces"] == 1
    assert seg.labels[0] == seg.labels[1] != seg.labels[2]
    assert vertices_from_faces(np.array([0, 0, 1]), mesh).tolist() == [0, 0, 0, 0]
    assert vertices_from_faces(np.array([2, 0, 1]), mesh).tolist() == [2, 2, 2, 0]


def test_vertices_take_the_label_of_most_of_the_area_around_them():
    square = shapes.grid_square(1)
    assert vertices_from_faces(np.array([0, 1]), square).tolist() == [0, 1, 0, 0]
    lonely = Mesh([*square.vertices, [9, 9, 9]], square.faces)
    assert vertices_from_faces(np.array([0, 0]), lonely).tolist() == [0, 0, 0, 0, -1]


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*FACE_FORMATS, "s.aggregation.json", "n.xml"])
def test_labels_of_another_mesh_are_refused(tmp_path, name):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / name)
    with pytest.raises(ValueError, match=rf"{name[0]}\."):
        sw.import_labels(shapes.box(5), tmp_path / name)
    if name.endswith(("ply", "npz", "glb", "xml")):
        moved = Mesh(mesh.vertices + 0.5, mesh.faces)
        with pytest.raises(ValueError, match=r"other|not those of|elsewhere"):
            sw.import_labels(moved, tmp_path / name)


def test_what_cannot_be_exported_says_why(tmp_path):
    mesh, seg = room()
    with pytest.raises(ValueError, match=r"can't tell the format of 'a\.dat'"):
        sw.export(seg, mesh, tmp_path / "a.dat")
    with pytest.raises(ValueError, match="format must be one of 'ply'"):
        sw.export(seg, mesh, tmp_path / "a.dat", format="dat")
    with pytest.raises(TypeError, match="format 'npz' has no option 'per'"):
        sw.export(seg, mesh, tmp_path / "a.npz", per="face")
    with pytest.raises(ValueError, match="per must be 'face' or 'vertex'"):
        sw.export(seg, mesh, tmp_path / "a.ply", per="edge")
    with pytest.raises(ValueError, match="segmentation is of another mesh"):
        sw.export(seg, shapes.box(2), tmp_path / "a.ply")
    with pytest.raises(TypeError, match="segmentation must be a Segmentation"):
        sw.export(seg.labels, mesh, tmp_path / "a.ply")
    with pytest.raises(FileNotFoundError, match="its folder does not exist"):
        sw.export(seg, mesh, tmp_path / "no" / "a.ply")
    with pytest.raises(FileNotFoundError, match="does not exist"):
        sw.import_labels(mesh, tmp_path / "a.ply")
    assert list(tmp_path.iterdir()) == []


def test_a_format_by_name_writes_any_suffix(tmp_path):
    mesh, seg = room()
    assert [p.name for p in sw.export(seg, mesh, tmp_path / "room", format="scannet")] == [
        "room.aggregation.json",
        "room.segs.json",
    ]
    assert [p.name for p in sw.export(seg, mesh, tmp_path / "room.ply", format="scenenn")] == [
        "room.ply",
        "room.xml",
    ]


def test_an_npz_compressed_otherwise_than_numpy_does_is_refused(tmp_path):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / "a.npz")
    with zipfile.ZipFile(tmp_path / "a.npz") as plain:
        members = {name: plain.read(name) for name in plain.namelist()}
    with zipfile.ZipFile(tmp_path / "b.npz", "w", zipfile.ZIP_BZIP2) as other:
        for name, data in members.items():
            other.writestr(name, data)
    with pytest.raises(FormatError, match="compressed in a way that NumPy doesn't know"):
        sw.import_labels(mesh, tmp_path / "b.npz")


def test_forged_sizes_take_no_memory(tmp_path):
    mesh, _ = room()
    header = "ply\nformat {}\nelement vertex {}\nproperty float x\n"
    header += "element face 1\nproperty int label\nend_header\n"
    for layout in ("ascii 1.0", "binary_little_endian 1.0"):
        (tmp_path / "a.ply").write_text(header.format(layout, 10**11))
        with pytest.raises(FormatError, match=r"promise|take"):
            sw.import_labels(mesh, tmp_path / "a.ply")
    big = b"\x93NUMPY\x01\x00" + struct.pack("<H", 118)
    big += b"{'descr': '<i8', 'fortran_order': False, 'shape': (1000000000000,), }".ljust(117) + b"\n"
    (tmp_path / "a.npy").write_bytes(big)
    with pytest.raises(FormatError, match="does not fit"):
        sw.import_labels(mesh, tmp_path / "a.npy")
    np.save(tmp_path / "b.npy", np.array([{"a": 1}] * mesh.n_faces, dtype=object), allow_pickle=True)
    with pytest.raises(FormatError, match=r"b\.npy"):
        sw.import_labels(mesh, tmp_path / "b.npy")
    np.savez_compressed(tmp_path / "a.npz", labels=np.zeros(10**7, np.int64))
    with pytest.raises(FormatError, match="larger than any"):
        sw.import_labels(mesh, tmp_path / "a.npz")


def test_a_glb_that_refers_to_other_files_is_not_followed(tmp_path):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / "a.glb")
    raw = (tmp_path / "a.glb").read_bytes()
    size = struct.unpack_from("<I", raw, 12)[0]
    content = json.loads(raw[20 : 20 + size])
    content["buffers"][0]["uri"] = "/etc/passwd"
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    raw = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON") + text
    (tmp_path / "a.glb").write_bytes(raw)
    with pytest.raises(FormatError, match="refers to another file, which is not followed"):
        sw.import_labels(mesh, tmp_path / "a.glb")


@pytest.mark.parametrize(
    "text",
    [
        '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;&x;">]><a><label id="1" text="&y;"/></a>',
        '<!DOCTYPE a SYSTEM "file:///etc/passwd"><a><label id="1" text="x"/></a>',
        '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a><label id="1">&x;</label></a>',
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_are_refused(tmp_path, text, encoding):
    mesh, seg = room()
    sw.export(seg, mesh, tmp_path / "n.xml")
    (tmp_path / "n.xml").write_bytes(f'<?xml version="1.0" encoding="{encoding}"?>{text}'.encode(encoding))
    with pytest.raises(FormatError, match="declares a DOCTYPE"):
        sw.import_labels(mesh, tmp_path / "n.xml")


def test_a_segments_file_elsewhere_is_not_read(tmp_path):
    mesh, seg = room()
    inner, outer = tmp_path / "in", tmp_path / "out"
    inner.mkdir()
    outer.mkdir()
    aggregation, segs = sw.export(seg, mesh, inner / "s.aggregation.json")
    segs.rename(outer / "t.segs.json")
    data = json.loads(aggregation.read_text())
    for named in ("../out/t.segs.json", str(outer / "t.segs.json"), "..\\out\\t.segs.json", "\0", "a" * 5000):
        aggregation.write_text(json.dumps(data | {"segmentsFile": named}))
        with pytest.raises((FormatError, OSError), match=r"needs its file of segments beside it|too long"):
            sw.import_labels(mesh, aggregation)


def test_a_cloud_that_is_written_keeps_its_digits_normals_and_colours(tmp_path):
    points = np.add(np.random.default_rng(0).random((40, 3)), (4e5, 5e6, 100))
    cloud = sw.PointCloud(points, np.tile([0.0, 0, 1], (40, 1)), np.full((40, 3), 7, np.uint8))
    read = sw.load(sw.save_mesh(cloud, tmp_path / "a.ply")[0])
    np.testing.assert_array_equal(read.points, points)
    np.testing.assert_array_equal(read.given_normals, cloud.given_normals)
    np.testing.assert_array_equal(read.vertex_colors, cloud.vertex_colors)
