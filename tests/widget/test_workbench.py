"""The queue of scans, driven as the page drives it."""

import json

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.widget import workbench


@pytest.fixture
def out(tmp_path):
    """Two segmented scans, the second more doubtful, and true labels of it."""
    mesh = shapes.sheet(4, 4, width=2.0, depth=2.0)
    halves = sw.Segmentation.from_labels(mesh, np.arange(32) // 16)
    for k, name in enumerate("ab"):
        folder = tmp_path / "out" / f"{name}.ply"
        folder.mkdir(parents=True)
        source = tmp_path / f"{name}.ply"
        sw.export(halves, mesh, source)
        sw.export(halves, sw.load(source), folder / f"{name}.npz")
        row = {"scan": f"{name}.ply", "key": "f", "files": {f"{name}.npz": [1, 1]}, "source": str(source)}
        (folder / "row.json").write_text(json.dumps(row | {"doubt": k / 10, "faces": 32, "segments": 2}))
    (tmp_path / "truth").mkdir()
    sw.export(sw.Segmentation.from_labels(mesh, np.zeros(32, int)), mesh, tmp_path / "truth" / "b.npz")
    return tmp_path / "out"


def press(bench, kind, *scans):
    bench.queue._handle_custom_msg({"kind": kind, "scans": list(scans)}, [])


def test_from_the_queue_through_the_editor_to_done(out, tmp_path):
    bench = sw.Workbench(out, "ann", truth=tmp_path / "truth")
    assert bench.next() == "b.ply"
    assert bench.queue.current == "b.ply"
    bench.editor.wait()
    assert bench.editor.scores  # it has a truth
    bench.editor.session.merge(0, 31)
    row = next(row for row in bench.queue.rows if row["scan"] == "b.ply")
    assert (row["state"], row["edits"]) == ("begun", 1)
    press(bench, "done", "a.ply")
    assert bench.current == "a.ply"
    table = bench.to_frame().set_index("scan")
    assert table.state.to_dict() == {"a.ply": "new", "b.ply": "done"}
    assert table.error_now["b.ply"] == 0
    assert table.people["b.ply"] == "ann"
    press(bench, "next", "b.ply")
    assert "Nothing else is left" in bench.queue.note
    press(bench, "previous", "b.ply")
    assert bench.current == "b.ply"
    assert len(bench.editor.session.edits) == 1  # kept in its project
    bench.close()


def test_what_somebody_has_open_is_passed_over_and_given_free_at_the_end(out):
    ann, bob = sw.Workbench(out, "ann"), sw.Workbench(out, "bob")
    ann.edit("b.ply")
    press(bob, "open", "b.ply")
    assert "'b.ply' is open elsewhere: another kernel or script" in bob.queue.note
    assert bob.next() == "a.ply"
    ann.close()
    bob.edit("b.ply")
    again = sw.Workbench(out, "bob")  # the cell is run again: the newest has it
    again.edit("b.ply")
    again.close()


def test_at_the_end_of_a_program_everything_is_left_though_one_fails(out, monkeypatch):
    ann, bob = sw.Workbench(out, "ann"), sw.Workbench(out, "bob", own=True)
    for bench in (ann, bob):
        bench.edit("a.ply")

    def fail():
        raise RuntimeError("no disk")

    for failing in (ann, bob):
        for bench in (ann, bob):
            monkeypatch.undo()
            bench.edit("a.ply")
        monkeypatch.setattr(failing.editor, "close", fail)
        with pytest.raises(RuntimeError, match="no disk"):
            workbench._leave_all()
        assert (bob if failing is ann else ann).editor is None
    monkeypatch.undo()
    workbench._leave_all()


def test_a_large_scan_is_corrected_room_by_room(out, tmp_path):
    bench = sw.Workbench(out, "ann", truth=tmp_path / "truth", room_faces=31)
    bench.edit("b.ply")
    assert isinstance(bench.editor, sw.Rooms)
    bench.editor.edit(0)
    bench.editor.editor.session.paint([0])
    row = next(row for row in bench.queue.rows if row["scan"] == "b.ply")
    assert (row["state"], row["edits"]) == ("begun", 1)
    bench.edit("a.ply")  # which puts the whole of the other together
    assert sw.Session.open(out / "b.ply" / "b.swproj").segmentation.n_segments == 3
    bench.edit("b.ply")
    bench.editor.edit(0)
    assert len(bench.editor.editor.session.edits) == 1  # in the room's own project
    bench.editor.editor.session.merge(0, 31)
    bench.done()
    table = bench.to_frame().set_index("scan")
    assert table.loc["b.ply", ["state", "edits"]].tolist() == ["done", 2]
    assert table.error_now["b.ply"] > 0
    assert bench.export(tmp_path / "set", validation=0).segments.tolist() == [2]
    bench.close()


def test_pictures_come_when_they_are_asked_for(out, monkeypatch):
    (out / "a.ply" / "picture.jpg").write_bytes(b"jpeg")
    bench, sent = sw.Workbench(out, "ann"), []
    monkeypatch.setattr(bench.queue, "send", lambda content, buffers=None: sent.append((content, buffers)))
    press(bench, "pictures", "a.ply", "b.ply", "../a.ply")
    assert sent == [({"kind": "pictures", "asked": ["a.ply", "b.ply"], "scans": ["a.ply"]}, [b"jpeg"])]
    bench.close()


def test_two_people_on_copies_of_their_own_can_be_compared_and_measured(out, tmp_path):
    with pytest.raises(ValueError, match="no scan has been corrected by two people who called it done"):
        sw.Workbench(out, "ann", own=True).agreement()
    for person in ("ann", "bob"):
        bench = sw.Workbench(out, person, own=True, gold=tmp_path / "truth")
        bench.edit("b.ply")
        if person == "bob":
            bench.editor.session.merge(0, 31)
        bench.done()
        bench.close()
    table = bench.agreement()
    assert table.index.tolist() == [("b.ply", "ann", "bob")]
    assert table[["n_first", "n_second"]].values.tolist() == [[2, 1]]
    errors = bench.measure().rand_index_error  # against one segment, which nobody was shown
    assert errors["b.ply", "bob"] == 0 < errors["b.ply", "ann"]
    assert not any("now" in row and row["now"] for row in bench.queue.rows)
    theirs = bench.annotations("b.ply")
    assert {person: found.n_segments for person, found in theirs.items()} == {"ann": 2, "bob": 1}
    assert bench.annotations("a.ply") == {}
    agreed = sw.consensus(theirs)
    dataset = bench.export(tmp_path / "set", agreed=True, validation=0)
    assert dataset[["scan", "segments", "people"]].values.tolist() == [["b.ply", agreed.n_segments, 2]]
    assert bench.export(tmp_path / "own", validation=0).segments.tolist() == [1]  # Bob's
    cyd = sw.Workbench(out, "cyd", own=True)
    assert cyd.export(tmp_path / "cyd", agreed=True, validation=0).people.tolist() == [2]
    with pytest.raises(ValueError, match=r"no scan of 'cyd' is done yet; ann, bob have .*agreed=True takes"):
        cyd.export(tmp_path / "none")
    bench.edit("b.ply")
    bench.review()
    assert bench.export(tmp_path / "ann", agreed=True, validation=0).people.tolist() == [1]
    with pytest.raises(ValueError, match="by two people who called it done"):
        bench.agreement()


def test_what_is_damaged_holds_nobody_up(out):
    (out / "b.ply" / "b.swproj").write_text("junk")
    (out / "b.ply" / "work.json").write_text('{"seconds": [1], "edits": "x", "errors": {"a": "b"}}')
    bench = sw.Workbench(out, "ann")
    assert bench.next() == "a.ply"
    assert "'b.ply' was passed over: 'b.swproj' is damaged or no project" in bench.queue.note
    with pytest.raises(ValueError, match="was passed over"):
        bench.next()
    with pytest.raises(TypeError, match="states must be a collection"):
        bench.export(out / "set", states="new")
    with pytest.raises(ValueError, match="target must be a folder of this machine"):
        bench.export("s3://bucket/set", states=["new"])
    bench.close()


def test_bad_input_is_explained(out, tmp_path):
    with pytest.raises(ValueError, match="no results in"):
        sw.Workbench(tmp_path / "truth")
    with pytest.raises(ValueError, match="is a URL: fetch it first"):
        sw.Workbench("s3://bucket/out")
    with pytest.raises(TypeError, match="out must be a folder"):
        sw.Workbench(3)
    for options, error, message in (
        ({"person": ""}, ValueError, "person must be a name of at most 80 letters"),
        ({"own": "yes"}, TypeError, "own must be True or False"),
        ({"height": 20}, ValueError, "height must be at least"),
        ({"scans": "gone"}, ValueError, "scans must be the folder of the scans"),
        ({"truth": 3}, TypeError, "truth must be a folder or a file, got int"),
        ({"gold": "gone"}, ValueError, "gold: 'gone' does not exist"),
    ):
        with pytest.raises(error, match=message):
            sw.Workbench(out, **options)
    bench = sw.Workbench(out)
    with pytest.raises(ValueError, match="there is no scan"):
        bench.edit("c.ply")
    with pytest.raises(ValueError, match="no scan is open"):
        bench.done()
    bench.close()
