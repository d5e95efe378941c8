"""A scan of many rooms, driven as the page drives it."""

import numpy as np
import pytest
import shapes

import scenewidget as sw


@pytest.fixture
def mesh():
    return shapes.sheet(4, 4, width=2.0, depth=2.0)


@pytest.fixture
def halves(mesh):
    return sw.Segmentation.from_labels(mesh, np.arange(32) // 16)


def click(rooms, face):
    rooms.view._handle_custom_msg({"kind": "click", "face": face}, [])


def test_a_click_opens_a_room_and_its_edits_are_in_the_whole(tmp_path, mesh, halves):
    rooms = sw.Rooms(mesh, tmp_path / "flat", segmentation=halves, max_faces=16)
    assert rooms.current == -1
    face = int(np.argmax(rooms.division.coarse_room == 1))
    click(rooms, face)
    assert rooms.current == rooms._list.value == 1
    assert rooms.editor.mesh.n_faces == 16
    before = rooms.segmentation().n_segments
    rooms.editor.session.paint([0])
    assert rooms.segmentation().n_segments == before + 1
    rooms._list.value = 0
    assert rooms.current == 0
    assert rooms.editor.session.edits == []
    rooms._leave_button.click()
    assert (rooms.current, rooms.editor) == (-1, None)
    assert rooms.to_frame().opened.all()
    rooms.close()

    again = sw.Rooms(mesh, tmp_path / "flat")  # another day
    again.edit(1)
    assert len(again.editor.session.edits) == 1
    newest = sw.Rooms(mesh, tmp_path / "flat")  # the cell is run again
    newest.edit(1)
    assert again.editor is None
    newest.close()


def test_a_room_is_segmented_alone_when_it_is_opened(tmp_path, mesh, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sw.save_mesh(mesh, "a flat.ply")
    rooms = sw.Rooms("a flat.ply", params=sw.Params(n_runs=2, n_graph_runs=2), max_faces=16)
    assert (tmp_path / "a flat.rooms").is_dir()
    rooms.edit(0)
    rooms.editor.wait()
    rooms.leave()
    assert rooms.to_frame().opened.tolist() == [True, False]
    assert rooms.segmentation().coverage == 1
    rooms.close()


def test_what_can_not_be_opened_is_said(tmp_path, mesh, halves):
    rooms = sw.Rooms(mesh, tmp_path / "flat", segmentation=halves)
    held, _ = rooms.division.lock(0)  # as another kernel would
    click(rooms, 0)
    assert "room 1 of the list is open elsewhere: another kernel or script" in rooms._note.value
    held.release()
    with pytest.raises(ValueError, match="room must be a whole number from 0 to 0, got -1"):
        rooms.edit(-1)
    with pytest.raises(ValueError, match="holds the rooms of another scan"):
        sw.Rooms(shapes.sheet(2, 2, width=1.0, depth=1.0), tmp_path / "flat")
    with pytest.raises(TypeError, match="params must be a Params, got str"):
        sw.Rooms(mesh, tmp_path / "other", "thesis")
    (tmp_path / "flat" / "room_001.npz").write_bytes(b"")
    click(rooms, 0)
    assert "be read (No data left in file): divide the scan again" in rooms._note.value
    click(rooms, 10_000)
    assert rooms.current == -1
    rooms.close()
