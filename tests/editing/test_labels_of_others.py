"""Label files as other tools write them, read onto the mesh that they are of; clouds through all files."""

import io
import json

import numpy as np
import pytest
import shapes
import trimesh

import scenewidget as sw
from scenewidget.editing.formats import FormatError


@pytest.fixture(scope="module")
def mesh():
    return shapes.grid_square(4)


@pytest.fixture(scope="module")
def segments(mesh):
    return sw.Segmentation.from_labels(mesh, (mesh.face_centroids[:, 0] > 0.5).astype(int))


def cut(mesh):
    """A label a vertex: 7 to the left, 9 to the right."""
    return np.where(mesh.vertices[:, 0] > 0.5, 9, 7)


def ply_with(mesh, name, labels, kind="int"):
    head = f"ply\nformat ascii 1.0\nelement vertex {mesh.n_vertices}\nproperty float x\nproperty float y\n"
    head += f"property float z\nproperty {kind} {name}\nelement face {mesh.n_faces}\n"
    head += "property list uchar int vertex_indices\nend_header\n"
    rows = [f"{x} {y} {z} {label}" for (x, y, z), label in zip(mesh.vertices.tolist(), labels.tolist())]
    return head + "\n".join(rows + [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]) + "\n"


@pytest.mark.parametrize(
    "name", ["objectId", "OBJECTID", "scalar_Label", "scalar_Classification", "segment_id"]
)
def test_properties_are_known_whatever_their_case(tmp_path, mesh, name):
    path = tmp_path / "a.ply"
    path.write_text(ply_with(mesh, name, cut(mesh), "float" if "scalar" in name else "int"))
    assert sw.import_labels(mesh, path).n_segments == 2


def test_corners_that_are_no_list_are_not_compared(tmp_path, mesh):
    path, faces = tmp_path / "a.ply", mesh.n_faces
    head = f"ply\nformat ascii 1.0\nelement face {faces}\nproperty int vertex_indices\nproperty int label\n"
    path.write_text(head + "end_header\n" + "5 7\n" * faces)
    assert sw.import_labels(mesh, path).n_segments == 1


def test_any_property_can_be_named(tmp_path, mesh):
    path = tmp_path / "a.ply"
    path.write_text(ply_with(mesh, "My_Ids", cut(mesh)))
    with pytest.raises(FormatError, match="property= names another"):
        sw.import_labels(mesh, path)
    assert sw.import_labels(mesh, path, property="my_ids").n_segments == 2
    with pytest.raises(ValueError, match=r"property names a column of ply, .* is read as 'glb'"):
        sw.import_labels(mesh, tmp_path / "a.glb", property="x")


@pytest.mark.parametrize("names", [("segments.json", "segments_anno.json"),
                                   ("mesh.refined.0.010000.segs.v2.json", "semseg.v2.json")])  # fmt: skip
def test_pairs_of_json_of_scannetpp_and_3rscan(tmp_path, mesh, names):
    labels = cut(mesh)
    groups = [{"id": 0, "objectId": 4, "segments": [7], "label": "sofa"},
              {"id": 1, "objectId": 5, "segments": [9], "label": "wall"}]  # fmt: skip
    bom = b"\xef\xbb\xbf"
    (tmp_path / names[0]).write_bytes(bom + json.dumps({"segIndices": labels.tolist()}).encode())
    (tmp_path / names[1]).write_text(json.dumps({"segGroups": groups}))
    assert set(sw.import_labels(mesh, tmp_path / names[1]).names) == {"sofa", "wall"}
    assert sw.import_labels(mesh, tmp_path / names[0]).n_segments == 2


def test_text_of_savetxt_and_bytes_of_semantic_kitti(tmp_path, mesh, segments):
    np.savetxt(tmp_path / "a.txt", segments.labels, header="labels")
    assert sw.import_labels(mesh, tmp_path / "a.txt").labels.tolist() == segments.labels.tolist()
    (tmp_path / "b.txt").write_bytes(b"\xef\xbb\xbf" + "\r\n".join(map(str, segments.labels)).encode())
    assert sw.import_labels(mesh, tmp_path / "b.txt").labels.tolist() == segments.labels.tolist()
    values = np.where(segments.labels == 1, 0, (3 << 16) + 40).astype("<u4")
    (tmp_path / "a.label").write_bytes(values.tobytes())
    read = sw.import_labels(mesh, tmp_path / "a.label")
    assert (read.n_segments, (read.labels < 0).sum()) == (1, (segments.labels == 1).sum())
    (tmp_path / "b.label").write_bytes(b"1234")
    with pytest.raises(FormatError, match="has 4 bytes, but labels of this mesh take"):
        sw.import_labels(mesh, tmp_path / "b.label")


def as_array(labels, **options):
    file = io.BytesIO()
    np.save(file, labels) if not options else np.lib.format.write_array(file, labels, **options)
    return file.getvalue()


def as_archive(**arrays):
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


LABELS_AS = {
    "utf16.txt": lambda k: "\n".join(map(str, k)).encode("utf-16"),
    "commas.txt": lambda k: ",".join(map(str, k.tolist())).encode(),
    "named.csv": lambda k: ("label\n" + "\n".join(map(str, k))).encode(),
    "counted.txt": lambda k: f"{len(k)}\n{chr(10).join(map(str, k))}".encode(),
    "numbered.seg": lambda k: "".join(f"{n} {label}\n" for n, label in enumerate(k)).encode(),
    "column.npy": lambda k: as_array(k[:, None]),
    "version2.npy": lambda k: as_array(k.astype(bool), version=(2, 0)),
    "only.npz": lambda k: as_archive(arr_0=k),
    "others.npz": lambda k: as_archive(vertices=np.zeros(3), instances=k),
    "list.json": lambda k: json.dumps(k.tolist()).encode(),
    "named.json": lambda k: json.dumps({"scene": "a", "labels": [str(label) for label in k]}).encode(),
}


@pytest.mark.parametrize("name", LABELS_AS)
def test_labels_alone_in_whatever_form_programs_save_them(tmp_path, mesh, segments, name):
    (tmp_path / name).write_bytes(LABELS_AS[name](segments.labels))
    read = sw.import_labels(mesh, tmp_path / name)
    assert sw.metrics.rand_index_error(read.labels, segments.labels) == 0


def test_labels_in_columns_of_clouds(tmp_path):
    points = np.random.default_rng(0).random((60, 3)).round(3)
    labels = np.arange(60) % 3
    cloud, rows = sw.PointCloud(points), np.column_stack([points, labels + 2])
    text = "".join(" ".join(map(str, row)) + "\n" for row in rows.tolist())
    head = "VERSION .7\nFIELDS x y z label\nSIZE 8 8 8 4\nTYPE F F F U\nWIDTH 60\nHEIGHT 1\nDATA ascii\n"
    for name, data, wanted in (
        ("a.asc", "//X Y Z Original_cloud\n60\n" + text, "original_cloud"),
        ("b.txt", text, "4"),
        ("c.pcd", head + text.replace(".0\n", "\n"), None),
    ):
        (tmp_path / name).write_text(data)
        read = sw.import_labels(cloud, tmp_path / name, property=wanted)
        assert sw.metrics.rand_index_error(read.labels, labels) == 0
    with pytest.raises(FormatError, match="no line with the names of its columns"):
        sw.import_labels(cloud, tmp_path / "b.txt", property="class")
    with pytest.raises(FormatError, match="points that are not those of the scan"):
        sw.import_labels(sw.PointCloud(points[::-1]), tmp_path / "c.pcd")


def test_a_class_of_las_and_values_that_are_missing(tmp_path, mesh):
    laspy = pytest.importorskip("laspy")
    las = laspy.create(point_format=0, file_version="1.2")
    las.header.scales = [1e-3] * 3
    points = np.arange(12.0).reshape(4, 3)
    las.x, las.y, las.z = points.T
    las.classification = [2, 2, 6, 6]
    las.write(tmp_path / "a.las")
    assert sw.import_labels(sw.PointCloud(points), tmp_path / "a.las").labels.tolist() == [0, 0, 1, 1]
    values = cut(mesh).astype(float)
    values[mesh.faces[0]] = np.nan
    (tmp_path / "a.ply").write_text(ply_with(mesh, "scalar_Label", values, "float"))
    assert sw.import_labels(mesh, tmp_path / "a.ply").labels[0] == -1


def test_our_glb_saved_again_by_trimesh(tmp_path, mesh, segments):
    written = sw.export(segments, mesh, tmp_path / "a.glb")[0]
    trimesh.load(written, process=False).export(tmp_path / "b.glb")
    read = sw.import_labels(mesh, tmp_path / "b.glb")
    assert sw.metrics.rand_index_error(read.labels, segments.labels) == 0


def test_labels_of_polygons_reach_their_triangles(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 5 6\nf 2 6 3\n"
    (tmp_path / "a.obj").write_text(text)
    mesh = sw.load_mesh(tmp_path / "a.obj")
    (tmp_path / "a.txt").write_text("5\n6\n6\n")
    assert sw.import_labels(mesh, tmp_path / "a.txt").labels.tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize("suffix", ["ply", "npz", "txt", "npy", "glb", "xml", "aggregation.json"])
def test_clouds_go_through_files_and_projects(tmp_path, suffix):
    points = np.random.default_rng(0).random((300, 3)) * (1, 1, 0)
    cloud = sw.PointCloud(points, normals=[[0, 0, 1]] * 300)
    seg = sw.Segmentation.from_labels(cloud, (points[:, 0] > 0.5).astype(int))
    sw.export(seg, cloud, tmp_path / f"out.{suffix}")
    assert sw.import_labels(cloud, tmp_path / f"out.{suffix}").labels.tolist() == seg.labels.tolist()
    session = sw.Session(cloud, seg)
    session.merge(0, int(np.flatnonzero(seg.labels != seg.labels[0])[0]))
    session.save(tmp_path / "room.swproj")
    session.close()
    with sw.Session.open(tmp_path / "room.swproj") as again:
        assert type(again.mesh) is sw.PointCloud
        assert again.segmentation.n_segments == 1
        np.testing.assert_array_equal(again.mesh.face_normals, cloud.face_normals)
    if suffix == "glb":
        assert repr(sw.load(tmp_path / "out.glb")) == repr(sw.load_cloud(tmp_path / "out.glb"))
        assert sw.load(tmp_path / "out.glb").n_faces == 300


def test_names_of_an_npz_that_are_no_text_are_refused(tmp_path, mesh):
    names = np.full(3, 0x110000, dtype=np.uint32).view("<U1")  # beyond the last letter there is
    np.savez(tmp_path / "a.npz", labels=np.arange(mesh.n_faces) % 3, names=names)
    with pytest.raises(FormatError, match="an array of text that holds no letters"):
        sw.import_labels(mesh, tmp_path / "a.npz")


def test_labels_of_a_ply_that_are_lists_are_refused(tmp_path, mesh):
    text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
    text += "property list uchar int label\nend_header\n3 0 1 2 1 7\n"
    (tmp_path / "a.ply").write_text(text)
    with pytest.raises(FormatError, match="lists of 'label' where a number each"):
        sw.import_labels(mesh, tmp_path / "a.ply")
