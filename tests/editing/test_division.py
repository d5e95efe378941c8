"""Rooms in a folder: what is edited in one lands in the whole, and nothing else changes."""

import json

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.editing.division import Division


@pytest.fixture
def mesh():
    return shapes.sheet(4, 4, width=2.0, depth=2.0)


@pytest.fixture
def whole(mesh):
    """Two segments that reach through both halves of the scan, and a face of nobody."""
    labels = (mesh.face_centroids[:, 1] > 1.0).astype(int)
    labels[-1] = -1
    return sw.Segmentation.from_labels(mesh, labels, names=["floor", ""], groups=[1, 1])


def test_untouched_rooms_give_the_whole_back(tmp_path, mesh, whole):
    rooms = Division.make(tmp_path / "flat", mesh, segmentation=whole, max_faces=16)
    assert rooms.n_faces == (16, 16)
    found = Division.open(tmp_path / "flat").segmentation(mesh)
    assert (found.labels == whole.labels).all()
    assert (found.names, found.groups) == (whole.names, (1, 1))
    assert (found.confidence == whole.confidence).all()


def test_what_is_split_in_one_room_stays_one_in_the_other(tmp_path, mesh, whole):
    rooms = Division.make(tmp_path / "flat", mesh, segmentation=whole, max_faces=16)
    part = rooms.part(0)
    with rooms.session(0) as session:
        labels = session.segmentation.labels
        of_zero = np.flatnonzero(labels == 0)
        session.paint(of_zero[:3])
        session.relabel(int(of_zero[0]), "carpet")
    found = rooms.segmentation(mesh)
    assert found.n_segments == whole.n_segments + 1
    inside = {tuple(place) for place in part.face_centroids[of_zero[:3]].round(6)}
    is_carpet = np.array([tuple(place) in inside for place in mesh.face_centroids.round(6)])
    assert (np.array(found.names)[found.labels[is_carpet]] == "carpet").all()
    assert found.groups == (0, 0, 2)
    before, after = whole.labels[~is_carpet], found.labels[~is_carpet]
    assert sw.metrics.rand_index_error(before, after) == 0
    assert ((before < 0) == (after < 0)).all()
    with rooms.session(0) as session:
        session.undo()
        session.undo()
    assert (rooms.segmentation(mesh).labels == whole.labels).all()


def test_without_a_segmentation_rooms_are_segmented_alone(tmp_path, mesh):
    rooms = Division.make(tmp_path / "flat", mesh, max_faces=16)
    params = sw.Params(n_runs=2, n_graph_runs=2)
    found = rooms.segmentation(mesh, params)
    assert found.n_segments == 2  # a plane, but two parts
    assert found.coverage == 1.0
    assert rooms.project(1).exists()  # so that it need not be computed again


def test_what_would_be_ignored_is_refused(tmp_path, mesh, whole):
    sw.save_mesh(mesh, tmp_path / "flat.ply")
    scan = sw.load_mesh(tmp_path / "flat.ply")
    rooms = Division.make(tmp_path / "flat", scan, segmentation=whole, max_faces=16)
    rooms.refuse_other(scan=scan, segmentation=whole, max_faces=16)
    rooms.refuse_other(scan=tmp_path / "flat.ply")
    with pytest.raises(ValueError, match="divided with max_faces=16, not 8; leave it out"):
        rooms.refuse_other(max_faces=8)
    for labels in (np.zeros(32, int), np.zeros(8, int)):
        other = sw.Segmentation.from_labels(shapes.sheet(4, len(labels) // 8, width=2.0, depth=2.0), labels)
        with pytest.raises(ValueError, match=r"segmentation: .* was divided with another one; leave it out"):
            rooms.refuse_other(segmentation=other)
    sw.save_mesh(shapes.sheet(4, 5, width=2.0, depth=2.0), tmp_path / "other.ply")
    with pytest.raises(ValueError, match="holds the rooms of another scan"):
        rooms.refuse_other(scan=tmp_path / "other.ply")
    held, _ = rooms.lock(0)
    assert rooms.lock(0) == (None, rooms.lock(0)[1])
    held.release()
    rooms.lock(0)[0].release()


def test_nothing_foreign_goes_and_what_is_wrong_is_said(tmp_path, mesh, whole):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").touch()
    with pytest.raises(FileExistsError, match="holds something else: give another folder"):
        Division.make(tmp_path / "mine", mesh)
    with pytest.raises(FileNotFoundError, match="holds no rooms"):
        Division.open(tmp_path / "mine")
    rooms = Division.make(tmp_path / "flat", mesh, segmentation=whole)
    with pytest.raises(ValueError, match="room must be a whole number from 0 to 0, got 1"):
        rooms.part(1)
    other = shapes.sheet(4, 4, width=2.5, depth=2.0)
    with pytest.raises(ValueError, match="mesh is not the one that was divided"):
        rooms.segmentation(other)
    with pytest.raises(ValueError, match="segmentation is of another mesh"):
        Division.make(tmp_path / "x", shapes.sheet(2, 2, width=2.0, depth=2.0), segmentation=whole)
    with pytest.raises(TypeError, match="a cloud is not divided into rooms"):
        Division.make(tmp_path / "x", sw.PointCloud(np.eye(3)))
    with pytest.raises(TypeError, match="segmentation must be a Segmentation, got ndarray"):
        Division.make(tmp_path / "x", mesh, segmentation=whole.labels)
    with pytest.raises(NotADirectoryError, match="its folder is no folder"):
        Division.make(tmp_path / "mine" / "thesis.txt" / "x", mesh)
    with pytest.raises(ValueError, match="folder must have a name"):
        Division.open("")
    (tmp_path / "flat" / "room_001.npz").write_bytes(b"")
    with pytest.raises(ValueError, match=r"room_001.npz' can't be read"):
        rooms.part(0)
    mark = tmp_path / "flat" / "rooms.json"
    mark.write_text(json.dumps({**json.loads(mark.read_text()), "mesh": 3}))
    with pytest.raises(ValueError, match="is damaged"):
        Division.open(tmp_path / "flat")
    assert not list(tmp_path.glob(".*tmp"))
