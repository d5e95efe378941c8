"""What people have done with the results of a run, on disk; and the dataset that comes of it."""

import json

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.batch.dataset import _scene_names, export_dataset, split
from scenewidget.batch.worklist import Stopwatch, Worklist


@pytest.fixture
def out(tmp_path):
    """Three scans as a run leaves them: two segmented, one failed."""
    mesh = shapes.sheet(4, 4, width=2.0, depth=2.0)
    for k, name in enumerate(("bath/a.ply", "kitchen/a.ply", "broken.ply")):
        folder = tmp_path / "out" / name
        folder.mkdir(parents=True)
        row = {"scan": name, "key": "", "files": {}, "status": "failed", "error": "damaged"}
        if k < 2:
            seg = sw.Segmentation.from_labels(mesh, np.arange(32) // 16, names=["floor", "=1+1"])
            source = tmp_path / "scans" / name
            source.parent.mkdir(parents=True)
            sw.export(seg, mesh, source)
            sw.export(seg, sw.load(source), folder / "a.npz")
            row |= {"key": "f", "files": {"a.npz": [1, 1]}, "error": "", "faces": 32, "segments": 2}
            row |= {"doubt": 0.1 + k / 10, "source": str(source), "params": {"n_segments": 2}}
        (folder / ("row.json" if k < 2 else "failed.json")).write_text(json.dumps(row))
    return tmp_path / "out"


def test_the_most_doubtful_come_first_and_what_failed_is_shown_apart(out):
    work = Worklist(out, "ann")
    assert work.order() == ["kitchen/a.ply", "bath/a.ply"]
    table = work.to_frame().set_index("scan")
    assert table.state.to_dict() == {"bath/a.ply": "new", "kitchen/a.ply": "new", "broken.ply": "failed"}
    assert table.error["broken.ply"] == "damaged"


def test_time_is_added_a_person_and_others_see_the_state(out):
    work, other = Worklist(out, "ann"), Worklist(out, "bob")
    work.note("bath/a.ply", state="begun", seconds=30, edits=2)
    other.note("bath/a.ply", seconds=12.5)
    entry = work.reread("bath/a.ply")
    assert (entry.state, entry.seconds, entry.edits) == ("begun", {"ann": 30, "bob": 12.5}, 2)


def test_a_scan_is_locked_by_one_at_a_time(out):
    work = Worklist(out, "ann")
    lock, _ = work.lock("bath/a.ply")
    held, holder = work.lock("bath/a.ply")
    assert held is None
    assert "another kernel or script (process" in holder
    lock.release()
    again, _ = work.lock("bath/a.ply")
    again.release()


def test_a_project_is_made_of_the_labels_and_goes_on_where_it_was(out):
    work = Worklist(out, "ann", own=True)
    entry = work.entries["bath/a.ply"]
    mesh = work.mesh(entry)
    with work.open("bath/a.ply", mesh) as session:
        assert session.params == sw.Params(n_segments=2)
        session.merge(0, 31)
    with work.open("bath/a.ply", mesh) as session:
        assert len(session.edits) == 1
    assert work.hands(entry) == {"ann": entry.folder / "a.ann.swproj"}
    assert work.labels(entry, mesh).n_segments == 1
    assert Worklist(out, "bob", own=True).labels(entry, mesh).n_segments == 2


def test_a_scan_that_was_moved_is_asked_for(out, tmp_path):
    work = Worklist(out, "ann")
    (tmp_path / "scans").rename(tmp_path / "moved")
    with pytest.raises(FileNotFoundError, match=r"not at .* any more; give the folder"):
        work.mesh(work.entries["bath/a.ply"])
    assert work.mesh(work.entries["bath/a.ply"], tmp_path / "moved").n_faces == 32


def test_the_dataset_is_whole_and_can_be_read_again(out, tmp_path):
    work = Worklist(out, "ann")
    with pytest.raises(ValueError, match="no scan is done yet"):
        export_dataset(work, tmp_path / "set")
    with pytest.raises(ValueError, match="validation must lie in"):
        export_dataset(work, tmp_path / "set", validation=20)
    for scan in work.order():
        work.note(scan, state="done")
    table = export_dataset(work, tmp_path / "set", validation=0.5)
    assert sorted(table.split) == ["train", "validation"]
    assert table.area.tolist() == pytest.approx([4, 4])
    scene = tmp_path / "set" / "scans" / "bath_a"
    mesh = sw.load(scene / "bath_a_vh_clean_2.ply")
    found = sw.import_labels(mesh, scene / "bath_a.aggregation.json")
    assert found.names == ("floor", "=1+1")
    lists = [(tmp_path / "set" / name).read_text().split() for name in ("train.txt", "validation.txt")]
    assert sorted(lists[0] + lists[1]) == ["bath_a", "kitchen_a"]
    lines = (tmp_path / "set" / "names.csv").read_text().splitlines()
    assert lines == ["name,segments,area", "'=1+1,2,4.0", "floor,2,4.0"]  # no spreadsheet computes it


def test_a_scene_that_comes_along_moves_few_others():
    names = [f"scene{i}" for i in range(200)]
    before, after = set(split(names, 0.2, 0)[1]), set(split([*names, "new"], 0.2, 0)[1])
    assert len(before) == 40
    assert len(before ^ after) <= 2
    assert [len(part) for part in split(["a", "b"], 0.2, 0)] == [1, 1]  # neither is empty
    assert [len(part) for part in split(["a", "b"], 0.0, 0)] == [2, 0]


def test_a_folder_that_cannot_be_read_is_named(out, monkeypatch):
    def walk(folder, onerror, followlinks):
        onerror(FileNotFoundError(2, "gone meanwhile", f"{folder}/a.ply"))
        onerror(PermissionError(13, "Permission denied", f"{folder}/b.ply"))

    monkeypatch.setattr("os.walk", walk)
    with pytest.raises(PermissionError, match=r"b.ply' can't be read: Permission denied"):
        Worklist(out, "ann")


def test_a_scan_can_be_locked_on_a_full_disk(out, monkeypatch):
    def write(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.write", write)
    work = Worklist(out, "ann")
    lock, _ = work.lock(work.order()[0])
    lock.release()
    assert not list(out.rglob("*.lock"))


def test_a_long_break_is_no_work(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("time.monotonic", lambda: clock[0])
    watch = Stopwatch()
    spent = []
    for now in (50, 4000):
        clock[0] = now
        spent.append(watch.tick())
    assert spent == [50, 120]


def test_two_people_whose_files_would_be_the_same_are_told(out):
    work = Worklist(out, "Ann B", own=True)
    work.note("bath/a.ply", state="begun")
    with pytest.raises(ValueError, match="'Ann_B' would write into the copies of 'Ann B'"):
        Worklist(out, "Ann_B", own=True)
    assert Worklist(out, "Ann B", own=True).entries["bath/a.ply"].state == "begun"
    Worklist(out, "Ann_B")  # a common copy is everybody's


def test_scenes_have_names_that_differ_on_every_disk():
    scans = ["a/Room.ply", "a/room.ply", "a/room.PLY", "b.ply", "b.obj", "c/d.ply", "c_d.ply"]
    scenes = _scene_names(scans)
    assert list(scenes) == sorted(scans)
    assert len({name.casefold() for name in scenes.values()}) == len(scans)
    assert (scenes["b.ply"], scenes["b.obj"]) == ("b_ply", "b_obj")
    assert _scene_names(["a/room.ply", "b.ply"]) == {"a/room.ply": "a_room", "b.ply": "b"}
    assert _scene_names(reversed(scans)) == scenes
