"""Autosave: what is written when, what is offered again, and what is never lost. Without a browser."""

import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.editing import store
from scenewidget.editing.project_reader import summary_of
from scenewidget.widget.autosave import default_name, newest_project

OTHER_KERNEL = """
import sys
from pathlib import Path
from scenewidget.editing.project_reader import read_project
from scenewidget.editing.store import ProjectFile

path = Path(sys.argv[1])
file = ProjectFile.take(path, read_project(path))
print(file.read_only, flush=True)
sys.stdin.read()
"""
SMALL = sw.Params(n_segments=6, n_runs=4, n_graph_runs=4)

NAME = {"kind": "relabel", "face": 0, "name": "wall"}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The kernel's folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def mesh():
    """A box of 4 × 3 × 2.4 m seen from inside."""
    box = shapes.box(12, size=(4.0, 3.0, 2.4))
    return sw.Mesh(box.vertices, box.faces[:, ::-1])


@pytest.fixture
def show(mesh):
    """Makes widgets as a cell does, segmented; closes them."""
    shown = []

    def make(scan=None, params=SMALL, **options):
        shown.append(sw.SceneWidget(mesh if scan is None else scan, params, **options))
        shown[-1].wait(60)
        return shown[-1]

    yield make
    for widget in shown:
        widget.session.close()
        widget.close()


def tell(widget, **message):
    """What the browser sends."""
    widget.view._handle_custom_msg({"revision": widget.view.revision, **message}, [])
    widget._autosave.wait()


def merge(widget, source=1, onto=0):
    labels = widget.segmentation.labels
    face, target = (int(np.argmax(labels == segment)) for segment in (source, onto))
    tell(widget, kind="merge", face=face, onto_face=target, level="final")


def files():
    return sorted(path.name for path in Path.cwd().iterdir())


def notices(widget):
    return {notice["key"]: notice["text"] for notice in widget.view.notices}


def test_showing_and_scripting_write_nothing_the_first_gesture_does(show, mesh):
    widget = show()
    assert (widget.view.save_state, files()) == ("", [])
    first, second = (int(np.argmax(widget.segmentation.labels == segment)) for segment in (0, 1))
    widget.session.merge(second, first)
    assert (widget.view.save_state, files()) == ("unsaved", [])
    merge(widget)
    assert widget.view.save_state == "saved"
    assert widget.session.path == Path.cwd() / default_name(mesh)
    assert summary_of(widget.session.path).n_steps == 2
    widget.session.relabel(first, "wall")  # from now on a script's edits are kept too
    assert summary_of(widget.session.path).n_steps == 3


def test_the_last_state_is_offered_and_restored(show, mesh):
    before = show()
    merge(before)
    merge(before)
    tell(before, kind="undo")
    wanted = before.segmentation
    before.session.close()
    again = show(sw.Mesh(mesh.vertices, mesh.faces), autosave=True)
    assert "1 step in scan-" in notices(again)["offer"]
    assert again.segmentation.n_segments == wanted.n_segments + 1
    computed = again.params.replace(seed=9)
    again.params = computed
    tell(again, kind="choose", notice="offer", action="restore")
    np.testing.assert_array_equal(again.segmentation.labels, wanted.labels)
    assert again.view.n_segments == wanted.n_segments
    assert again.params == SMALL
    assert (again.view.redo_title, again.view.save_state, notices(again)) == ("Merge", "saved", {})
    assert "Restored 1 step" in again.view.status
    assert not again.busy
    merge(again)
    assert summary_of(again.session.path).n_steps == 2
    assert files() == [default_name(mesh), f"{default_name(mesh)}-shm", f"{default_name(mesh)}-wal",
                       f"{default_name(mesh)}.lock"]  # fmt: skip


def test_starting_afresh_leaves_the_old_file_alone(show, mesh):
    first = show()
    merge(first)
    first.session.close()
    old = Path(default_name(mesh)).read_bytes()
    second = show()
    tell(second, kind="choose", notice="offer", action="drop")
    assert notices(second) == {}
    merge(second)
    assert second.session.path.name == default_name(mesh).replace(".swproj", "-2.swproj")
    second.session.close()
    assert Path(default_name(mesh)).read_bytes() == old
    third = show()
    assert "-2.swproj" in notices(third)["offer"]  # the one worked on last


def test_edits_made_before_restoring_stay_in_a_file_of_their_own(show, mesh):
    first = show()
    merge(first)
    first.session.close()
    second = show()
    merge(second, 2, 0)
    merge(second)
    own = second.session.path
    tell(second, kind="choose", notice="offer", action="restore")
    assert second.session.path.name == default_name(mesh)
    assert len(second.session.edits) == 1
    assert summary_of(own).n_steps == 2


def test_two_widgets_that_begin_their_files_at_once_have_one_each(show, mesh, monkeypatch):
    widgets = show(), show()
    both_write, create = threading.Barrier(2), store._create
    monkeypatch.setattr(store, "_create", lambda *args: (both_write.wait(30), create(*args)))
    edits = [threading.Thread(target=tell, args=(widget,), kwargs=NAME) for widget in widgets]
    for edit in edits:
        edit.start()
    for edit in edits:
        edit.join(60)
    name = default_name(mesh)
    assert {widget.session.path.name for widget in widgets} == {name, name.replace(".swproj", "-2.swproj")}
    assert [widget.view.save_state for widget in widgets] == ["saved", "saved"]
    assert [summary_of(widget.session.path).n_steps for widget in widgets] == [1, 1]


def test_running_the_cell_again_takes_the_file_over_and_says_so(show):
    first = show()
    merge(first)
    second = show()
    tell(second, kind="choose", notice="offer", action="restore")
    assert second.view.save_state == "saved"
    merge(first)  # in the output that is still on the page
    assert first.view.save_state == "read-only"
    assert "taken it over" in notices(first)["file"]
    tell(first, kind="choose", notice="file", action="copy")
    assert (first.view.save_state, notices(first)) == ("saved", {})
    assert first.session.path != second.session.path
    assert len(second.session.edits) == 1


def test_a_second_kernel_opens_read_only_and_says_so(show, mesh, folder):
    first = show()
    merge(first)
    path = first.session.path
    first.session.close()
    other = subprocess.Popen(
        [sys.executable, "-c", OTHER_KERNEL, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert other.stdout.readline() == "False\n"
        second = show()
        tell(second, kind="choose", notice="offer", action="restore")
        assert second.view.save_state == "read-only"
        assert f"process {other.pid}" in notices(second)["file"]
        merge(second)
        assert len(second.session.edits) == 2
        assert second.view.save_state == "read-only"
        assert summary_of(path).n_steps == 1
        tell(second, kind="choose", notice="file", action="copy")
        assert second.view.save_state == "saved"
        assert summary_of(second.session.path).n_steps == 2
    finally:
        other.communicate()


def test_a_place_that_cannot_be_written_is_told_and_tried_again(show, folder):
    widget = show(autosave=folder / "nowhere" / "room.swproj")
    merge(widget)
    assert widget.view.save_state == "failed"
    assert notices(widget)["file"].startswith("Can't write")
    assert "its folder does not exist" in notices(widget)["file"]
    assert "in memory only" in notices(widget)["file"]
    merge(widget)
    assert widget.view.save_state == "failed"
    with pytest.raises(OSError, match="does not exist"):
        widget.save()
    (folder / "nowhere").mkdir()
    tell(widget, kind="choose", notice="file", action="save")
    assert (widget.view.save_state, notices(widget)) == ("saved", {})
    assert summary_of(folder / "nowhere" / "room.swproj").n_steps == 2


def test_without_autosave_save_decides(show, folder):
    widget = show(autosave=False)
    merge(widget)
    assert (widget.view.save_state, files()) == ("unsaved", [])
    tell(widget, kind="save")
    assert widget.view.save_state == "saved"
    assert "Saved in scan-" in widget.view.status
    merge(widget)
    assert summary_of(widget.session.path).n_steps == 2
    assert widget.save("mine.swproj") == folder / "mine.swproj"
    merge(widget)
    assert summary_of(folder / "mine.swproj").n_steps == 3


def test_a_path_is_begun_by_scripts_too_and_not_with_another_mesh(show, mesh, folder):
    widget = show(autosave="room.swproj")
    widget.session.relabel(0, "wall")
    widget._autosave.wait()
    assert summary_of(folder / "room.swproj").n_steps == 1
    widget.session.close()
    other = sw.Mesh(mesh.vertices + 1.0, mesh.faces)
    with pytest.raises(ValueError, match="belongs to another mesh"):
        sw.SceneWidget(other, SMALL, autosave="room.swproj")
    with pytest.raises(TypeError, match="autosave must be True, False or a path, got int"):
        sw.SceneWidget(mesh, SMALL, autosave=3)
    with pytest.raises(
        ValueError, match=r"autosave must name a file, but .* is a folder; try .*scan-\w+.swp"
    ):
        sw.SceneWidget(mesh, SMALL, autosave=folder)
    again = show(autosave="room.swproj")
    assert "in room.swproj" in notices(again)["offer"]
    merge(again)
    assert again.session.path == folder / "room-2.swproj"
    assert "in room-2.swproj" in notices(show(autosave="room.swproj"))["offer"]  # what was done last


def test_the_name_of_the_file_is_that_of_the_scan(mesh, folder):
    sw.export(sw.Segmentation.from_labels(mesh, np.zeros(mesh.n_faces, int)), mesh, "my café, 1.ply")
    scan = sw.load_mesh("my café, 1.ply")
    assert default_name(scan).startswith("my_café_1-")
    assert default_name(mesh).startswith("scan-")


def test_damaged_and_foreign_files_are_passed_over(show, mesh, folder):
    widget = show()
    merge(widget)
    path = widget.session.path
    widget.session.close()
    whole = path.read_bytes()
    name = path.name
    for content in (b"", b"no project", whole[:3000], b"x" * 200 + whole[200:]):
        Path(name.replace("scan", "other")).write_bytes(content)
        found = newest_project(mesh, folder)
        assert found is not None
        assert found.path == path
    assert newest_project(sw.Mesh(mesh.vertices + 1, mesh.faces), folder) is None
    assert {file for file in files() if "-wal" in file or "-shm" in file} == set()  # looking leaves no traces


def test_the_first_edit_is_answered_before_the_file_is_written(show, monkeypatch):
    widget = show()
    answered = []
    begin = widget._autosave._begin_file
    monkeypatch.setattr(
        widget._autosave,
        "_begin_file",
        lambda session: (answered.append(widget.view._answers), begin(session)),
    )
    labels = widget.segmentation.labels
    tell(widget, kind="merge", face=int(np.argmax(labels == 1)), onto_face=int(np.argmax(labels == 0)),
         level="final", client="a", number=1)  # fmt: skip
    assert answered == [{"a": 1}]
    deadline = time.monotonic() + 10
    while widget.view.save_state != "saved" and time.monotonic() < deadline:
        time.sleep(0.01)
    assert widget.view.save_state == "saved"


def test_a_file_that_cannot_be_restored_is_told_and_nothing_is_lost(show, mesh):
    first = show()
    merge(first)
    path = first.session.path
    first.session.close()
    second = show()
    before = second.segmentation
    content = bytearray(path.read_bytes())
    at = content.find(b"labels")
    content[at + 60] ^= 255
    path.write_bytes(content)
    tell(second, kind="choose", notice="offer", action="restore")
    assert path.name in second.view.error
    assert second.segmentation is before
    assert "offer" in notices(second)


def test_restoring_does_not_wait_for_the_computation(show, mesh, monkeypatch):
    first = show()
    merge(first)
    first.session.close()

    def endless(self, params, *, progress, cancel):
        cancel.wait(60)
        raise sw.Cancelled("as asked")

    monkeypatch.setattr(sw.Pipeline, "run", endless)
    second = sw.SceneWidget(mesh, SMALL)
    assert second.busy
    tell(second, kind="choose", notice="offer", action="restore")
    assert not second.busy
    assert (second.view.n_segments, second.view.undo_title) == (first.view.n_segments, "Merge")
    assert second.controls.can_suggest
    assert second.wait(10) is second.segmentation
    second.session.close()
    second.close()


def test_the_granularity_of_a_restored_result_can_be_chosen_again(show):
    mesh, _ = shapes.room(8, noise=0.003)
    fine = SMALL.replace(min_area=0.0)
    first = show(mesh, fine)
    merge(first)
    bounds, path = first.controls.family, first.session.path
    first.session.close()
    second = show(mesh, SMALL.replace(n_segments=4))
    second.restore(path)
    second.wait(60)
    assert second.controls.family == bounds
    assert "granularity" not in second.controls.idle
    assert (len(second.session.edits), second.busy, second.params) == (1, False, fine)
    second.controls.set("granularity", bounds[1])
    second.wait(60)
    assert second.session.automatic.n_segments == bounds[1]
    assert len(second.session.edits) == 1


def test_a_result_that_comes_while_somebody_restores_goes_to_the_session_before(show, mesh, monkeypatch):
    first = show()
    merge(first)
    path = first.session.path
    first.session.close()
    second, order = show(), []
    take, open_project = second._commands.take, sw.Session.open

    def late(*result):
        arrived.set()
        second._worker._cancel.wait(30)  # somebody restores
        order.append("result")
        return take(*result)

    arrived = threading.Event()
    monkeypatch.setattr(second._commands, "take", late)
    monkeypatch.setattr(sw.Session, "open", lambda *args: order.append("file") or open_project(*args))
    second.params = SMALL.replace(n_segments=3)
    assert arrived.wait(30)
    second.restore(path)
    assert order == ["result", "file"]
    np.testing.assert_array_equal(second.wait(60).labels, first.segmentation.labels)


def test_a_folder_that_was_removed_is_no_obstacle_to_looking(mesh, folder, monkeypatch):
    monkeypatch.setattr(Path, "cwd", lambda: (_ for _ in ()).throw(FileNotFoundError("gone")))
    widget = sw.SceneWidget(mesh, SMALL)
    assert widget.wait(60).n_segments > 1
    widget.close()


def test_the_state_told_is_the_last_one_whoever_is_slow(show, monkeypatch):
    widget = show(autosave=False)
    merge(widget)
    autosave, session = widget._autosave, widget.session
    history = type(session).history

    def slow(self):  # meanwhile another thread saves, and tells
        monkeypatch.undo()
        autosave.save(session, "quick.swproj")
        return history.fget(self)

    with monkeypatch.context() as patch:
        patch.setattr(type(session), "history", property(slow))
        patch.setattr(monkeypatch, "undo", lambda: setattr(type(session), "history", history))
        autosave.tell(session)
    assert widget.view.save_state == "saved"
