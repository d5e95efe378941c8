"""What writes files does so on Windows, too: no file is replaced while it is open, none is left over."""

import ast
import sys
from pathlib import Path

import numpy as np
import pytest
import shapes
import windows

import scenewidget as sw
from scenewidget.batch.dataset import export_dataset
from scenewidget.batch.worklist import Worklist
from scenewidget.editing import files
from scenewidget.editing.edits import Merge, Relabel

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="asks Linux which files are open")
MESH = shapes.box(4)
TEXTS = (".json", ".csv", ".txt", ".xml")
EXPORTS = ("csv", "glb", "npy", "npz", "parquet", "ply", "scannet", "scenenn", "txt")
LABELS = np.arange(MESH.n_faces) // 16


@pytest.fixture
def refused(monkeypatch):
    return windows.pretend(monkeypatch)


def session():
    return sw.Session(MESH, sw.Segmentation.from_labels(MESH, LABELS))


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_pretence_refuses_what_windows_does(refused, tmp_path):
    path = tmp_path / "room.ply"
    path.write_text("old")
    with (
        path.open(),
        pytest.raises(PermissionError, match=r"another program has it open; .* untouched"),
        files.replacing(path) as temporary,
    ):
        temporary.write_text("new")
    assert (path.read_text(), refused, names(tmp_path)) == ("old", ["room.ply"], ["room.ply"])


def test_a_project_lives_through_saving_taking_over_and_closing(refused, tmp_path):
    one = session()
    room = one.save(tmp_path / "room.swproj")
    one.merge(0, 20)
    one.save()
    one.save(include_mesh=True)  # another file in its own place
    one.save(tmp_path / "other.swproj")
    one.save(room)  # and back, over a project
    assert "room.swproj.lock" in names(tmp_path)
    two = sw.Session.open(room, MESH)
    assert one.read_only
    assert not two.read_only
    two.relabel(0, "floor")
    two.save(tmp_path / "copy.swproj", anonymous=True)
    two.close()
    with sw.Session.open(room, MESH) as three:
        assert three.edits == [Merge((0,), 20), Relabel(0, "floor")]
    assert refused == []
    assert names(tmp_path) == ["copy.swproj", "other.swproj", "room.swproj"]


def test_a_lock_keeps_others_out_and_leaves_nothing(refused, tmp_path):
    one, two = (files.FileLock(tmp_path / "room.swproj") for _ in range(2))
    assert one.acquire() == ""
    assert "another kernel or script" in two.acquire()
    one.release()
    assert two.acquire() == ""
    two.release()
    assert (names(tmp_path), refused) == ([], [])


@pytest.mark.parametrize("kind", EXPORTS)
def test_every_export_can_be_written_again_and_its_lines_end_as_elsewhere(refused, tmp_path, kind):
    one = session()
    path, *_ = sw.export(one.segmentation, MESH, tmp_path / "room.out", kind)
    first = {name: (tmp_path / name).read_bytes() for name in names(tmp_path)}
    if kind not in ("csv", "parquet"):
        sw.import_labels(MESH, path, kind)
    one.merge(0, 20)
    sw.export(one.segmentation, MESH, tmp_path / "room.out", kind)
    assert refused == []
    assert set(names(tmp_path)) == set(first)
    if kind in ("csv", "scannet", "scenenn", "txt"):
        assert not any(b"\r\n" in content for name, content in first.items() if not name.endswith(".ply"))


def test_a_run_its_queue_and_the_dataset_are_written(refused, tmp_path):
    source, out, target = tmp_path / "scans" / "a.ply", tmp_path / "out", tmp_path / "dataset"
    source.parent.mkdir()
    sw.export(session().segmentation, MESH, source)
    kinds = ["npz", "scannet", "csv", "swproj"]
    for _ in range(2):  # the second time it goes over what is there
        run = sw.segment_all(source.parent, out, formats=kinds, n_workers=0, resume=False, progress=False)
        assert run.to_frame()["status"].tolist() == ["done"]
    work = Worklist(out, "ann", own=True)
    held, _ = work.lock("a.ply")
    with work.open("a.ply", sw.load(source)) as editor:
        editor.relabel(0, "floor")
    for state in ("begun", "done"):
        work.note("a.ply", state=state, seconds=1.0)
    held.release()
    for _ in range(2):
        export_dataset(work, target)
    assert refused == []
    assert [path for path in tmp_path.rglob("*") if path.suffix in (".lock", ".tmp")] == []
    assert not any(b"\r" in path.read_bytes() for path in tmp_path.rglob("*") if path.suffix in TEXTS)


def test_text_is_written_with_lines_that_end_alike_everywhere():
    """Python's own default would be that of the system, which no pretence reaches."""
    calls = 0
    for path in Path(sw.__file__).parent.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if "write_text(" not in text or "_build" in path.parts:  # which writes nothing that anybody keeps
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "write_text":
                if ast.unparse(node.func.value) == "Path('/proc/self/clear_refs')":
                    continue
                said = {keyword.arg for keyword in node.keywords}
                assert said >= {"encoding", "newline"}, f"{path.name}:{node.lineno}"
                calls += 1
    assert calls >= 3
