"""Project files: what goes in comes out, nobody's work is overwritten, and damage is noticed."""

import gc
import os
import resource
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import numpy as np
import pytest
import shapes
import trimesh
from attacks import GOLDEN, old_project
from editing_strategies import assert_same, edited
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_session import box_session, do_all

import scenewidget as sw
from scenewidget.editing import schema, store
from scenewidget.editing.edits import Cut, Merge, Relabel, Split
from scenewidget.editing.fingerprint import fingerprint
from scenewidget.editing.project import ProjectError
from scenewidget.editing.session import Session
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.segmentation import Segmentation

HERE = Path(__file__).parent


def run(code, *arguments):
    """Output of a Python program of its own."""
    paths = os.pathsep.join([str(HERE), str(HERE.parent), *sys.path])
    command = [sys.executable, "-c", textwrap.dedent(code), *map(str, arguments)]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, env={**os.environ, "PYTHONPATH": paths}
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def saved(path, **options):
    """A saved and closed session with a few edits; its last segmentation and edits."""
    session = box_session()
    session.relabel(0, "chair")
    session.save(path, **options)
    session.merge([0, 40], 70)
    session.cut(0, 70)
    session.split(100, "base")
    session.undo()
    result = session.segmentation, session.edits, session.mesh
    session.close()
    return result


# --- round trip -----------------------------------------------------------------------------------


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(edited(max_size=6), st.integers(0, 6), st.booleans())
def test_a_reopened_session_is_the_same_and_can_undo_and_redo(tmp_path, case, n_before, include_mesh):
    segmentation, edits = case
    path = tmp_path / "room.swproj"
    session = Session(segmentation.mesh, segmentation, vocabulary=["one", "two"])
    do_all(session, edits[:n_before])
    session.save(path, include_mesh=include_mesh)
    do_all(session, edits[n_before:])
    if session.can_undo:
        session.undo()
    assert session.is_saved
    with Session.open(path, None if include_mesh else segmentation.mesh) as again:
        assert again.edits == session.edits
        assert again.undone == session.undone
        assert again.vocabulary == ("one", "two")
        assert_same(again.segmentation, session.segmentation)
        if again.can_redo:
            again.redo()
            session.redo()
            assert_same(again.segmentation, session.segmentation)
        while again.can_undo:
            again.undo()
        assert_same(again.segmentation, segmentation)


def test_every_edit_is_on_disk_before_the_call_returns(tmp_path):
    path = tmp_path / "room.swproj"
    session = box_session()
    session.save(path)
    for n, edit in enumerate([(0, 40), (70, 40), (100, 40)], start=1):
        session.merge(*edit)
        with sqlite3.connect(path) as other:  # another reader sees what is committed
            count = other.execute("SELECT COUNT(*) FROM operation WHERE action = 'edit'").fetchone()[0]
        assert count == n
        assert session.is_saved


def test_everything_about_the_segmentation_is_kept(tmp_path):
    mesh = shapes.box(12)
    params = sw.Params(n_segments=8, n_runs=2, n_graph_runs=2, k_range=(9, 12))
    seg = sw.segment(mesh, params)
    session = Session(mesh, seg, params=params)
    session.save(tmp_path / "room.swproj")
    session.close()
    with Session.open(tmp_path / "room.swproj", mesh) as again:
        assert again.params == params
        assert_same(again.automatic, seg)
        assert again.automatic.timings.keys() == seg.timings.keys()
        assert set(again.automatic.report) == set(seg.report)


def test_the_mesh_is_found_again(tmp_path, monkeypatch):
    mesh = shapes.box(4, size=(1.0, 1.37, 2.11))  # of no other test
    scan = tmp_path / "scan.ply"
    scan.write_bytes(
        trimesh.exchange.ply.export_ply(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False))
    )
    loaded = sw.load_mesh(scan)
    seg = Segmentation.from_labels(loaded, np.arange(192) // 32)
    path = tmp_path / "room.swproj"
    session = Session(scan, seg)
    session.save(path)
    session.close()
    again = Session.open(path)
    assert again.mesh is session.mesh or again.mesh is loaded  # this process has it still
    again.close()
    digest = fingerprint(loaded).digest
    code = "import sys, scenewidget as sw; print(sw.Session.open(sys.argv[1]).mesh)"
    assert run(code, path) == repr(loaded)  # from where it was loaded
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    for file in (scan, path):
        shutil.move(file, moved / file.name)
    assert run(code, moved / "room.swproj") == repr(loaded)  # beside the project
    (moved / "scan.ply").unlink()
    code = """
        import sys, scenewidget as sw
        try:
            sw.Session.open(sys.argv[1])
        except ValueError as error:
            print(error)
    """
    message = run(code, moved / "room.swproj")
    assert "does not hold the mesh (192 faces" in message
    assert digest[:8] in message
    assert "give it: Session.open('room.swproj', mesh='scan.ply')" in message


def test_another_mesh_is_refused_with_both_named(tmp_path):
    saved(tmp_path / "room.swproj")
    with pytest.raises(
        ProjectError, match=r"'room.swproj' belongs to another mesh: .*192 faces.* has 48 faces"
    ):
        Session.open(tmp_path / "room.swproj", shapes.box(2))
    mesh = shapes.box(4)
    shifted = Mesh(mesh.vertices + np.array([0, 0, 1e-9]), mesh.faces)
    with pytest.raises(ProjectError, match=r"fingerprint .* fingerprint"):
        Session.open(tmp_path / "room.swproj", shifted)


def test_saving_again_elsewhere_leaves_the_first_file(tmp_path):
    session = box_session()
    session.save(tmp_path / "a.swproj")
    session.merge(0, 40)
    session.save(tmp_path / "b.swproj")
    session.merge(70, 40)
    session.save()
    mesh = session.mesh
    session.close()
    assert [len(Session.open(tmp_path / f"{name}.swproj", mesh).edits) for name in "ab"] == [1, 2]


def test_a_closed_project_is_one_file_that_can_be_copied(tmp_path):
    _, _, mesh = saved(tmp_path / "room.swproj")
    assert [p.name for p in tmp_path.iterdir()] == ["room.swproj"]
    session = Session.open(tmp_path / "room.swproj", mesh)
    session.merge(0, 190)
    session.save()  # brings everything into the one file
    shutil.copy(tmp_path / "room.swproj", tmp_path / "copy.swproj")
    assert Session.open(tmp_path / "copy.swproj", mesh).edits == session.edits


def test_another_segmentation_goes_into_the_file(tmp_path):
    session = box_session()
    session.save(tmp_path / "room.swproj")
    session.merge(0, 40)
    other = Segmentation.from_labels(session.mesh, np.arange(192) // 48)
    params = sw.Params(n_segments=4)
    session.resegment(other, params)
    expected, mesh = session.segmentation, session.mesh
    session.close()
    with Session.open(tmp_path / "room.swproj", mesh) as again:
        assert_same(again.segmentation, expected)
        assert again.params == params


# --- several at work ------------------------------------------------------------------------------


def test_a_second_process_opens_read_only_and_says_who_has_it(tmp_path):
    path = tmp_path / "room.swproj"
    session = box_session()
    session.save(path)
    session.merge(0, 40)
    code = """
        import sys, warnings, shapes, scenewidget as sw
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            session = sw.Session.open(sys.argv[1], shapes.box(4))
        print(caught[0].message)
        session.merge(70, 40)
        print(session.read_only, session.is_saved, len(session.edits))
        try:
            session.save(sys.argv[1])
        except OSError as error:
            print(error)
        session.save(sys.argv[2])
        print(session.read_only, session.is_saved)
    """
    lines = run(code, path, tmp_path / "mine.swproj").splitlines()
    assert f"'room.swproj' is open read-only: another kernel or script (process {os.getpid()} on" in lines[0]
    assert lines[1] == "True False 2"
    assert "works on it; choose another name" in lines[2]
    assert lines[3] == "False True"
    session.merge(70, 40)
    assert session.is_saved


def test_a_later_session_of_the_same_process_takes_the_file_over(tmp_path):
    path = tmp_path / "room.swproj"
    first, heard = box_session(), []
    first.save(path)
    first.merge(0, 40)
    first.observe(heard.append)
    second = Session.open(path, first.mesh)
    assert not second.read_only
    assert [event.kind for event in heard] == ["file"]
    assert "taken the file over" in first.file_problem
    assert not first.is_saved
    first.merge(70, 40)
    assert len(first.edits) == 2
    second.merge(100, 40)
    second.close()
    assert len(Session.open(path, first.mesh).edits) == 2


def test_a_forgotten_session_gives_its_file_back(tmp_path):
    path = tmp_path / "room.swproj"
    box_session().save(path)
    gc.collect()
    assert [p.name for p in tmp_path.iterdir()] == ["room.swproj"]


AS_NOBODY = """
    import os, sys, warnings, shapes, scenewidget as sw
    import scenewidget.editing.formats  # Python itself may lie where nobody can read
    from test_session import box_session
    warnings.simplefilter("ignore")
    if os.geteuid() == 0:
        os.setuid(65534)
    session = sw.Session.open(sys.argv[1], shapes.box(4))
    print(session.read_only, len(session.edits))
    for write in (
        lambda: session.save(sys.argv[1]),
        lambda: box_session().save(sys.argv[2]),
        lambda: sw.export(session.segmentation, session.mesh, sys.argv[3]),
    ):
        try:
            write()
        except OSError as error:
            print(type(error).__name__, error)
"""


@pytest.mark.skipif(os.name != "posix", reason="permissions of another kind")
def test_read_only_folders_are_read_and_not_written():
    with tempfile.TemporaryDirectory() as name:  # pytest's own folders are for their owner only
        check_read_only_folder(Path(name))


def check_read_only_folder(folder):
    _, edits, _ = saved(folder / "room.swproj")
    folder.chmod(0o555)
    try:
        lines = run(AS_NOBODY, folder / "room.swproj", folder / "b.swproj", folder / "a.ply").splitlines()
    finally:
        folder.chmod(0o755)
    assert lines[0] == f"True {len(edits)}"
    assert len(lines) == 4
    assert all("PermissionError" in line and "no permission" in line for line in lines[1:])
    assert [p.name for p in folder.iterdir()] == ["room.swproj"]


FULL_DISK = """
    import resource, sys, warnings, numpy as np, shapes, scenewidget as sw
    from pathlib import Path
    folder = Path(sys.argv[1])
    session = sw.Session.open(folder / "room.swproj", shapes.box(4))
    mesh = shapes.box(24)
    large = sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces))
    n, before = len(session.edits), (folder / "old.npz").read_bytes()
    size = (folder / "room.swproj").stat().st_size
    resource.setrlimit(resource.RLIMIT_FSIZE, (8192, resource.RLIM_INFINITY))  # no file may grow beyond
    caught = []
    warnings.showwarning = lambda message, *_: caught.append(str(message))
    warnings.simplefilter("always")
    while not caught:
        session.split(0, "dihedral")
        session.undo()
    print(caught[0])
    print(session.is_saved, session.file_problem != "")
    for write in (
        lambda: session.save(),
        lambda: session.save(folder / "new.swproj"),
        lambda: sw.export(large, mesh, folder / "old.npz"),
        lambda: sw.export(large, mesh, folder / "new.ply"),
    ):
        try:
            write()
            print("written")
        except OSError as error:
            print(type(error).__name__, error)
    assert (folder / "old.npz").read_bytes() == before
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    session.relabel(0, "there is room again")
    print(session.is_saved, session.file_problem == "", len(session.edits) == n + 1)
    session.close()
    print(sw.Session.open(folder / "room.swproj", shapes.box(4)).edits[-1].name)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs limits of resources")
def test_a_full_disk_is_told_and_nothing_is_lost(tmp_path):
    saved(tmp_path / "room.swproj")
    mesh = shapes.box(24)
    sw.export(Segmentation.from_labels(mesh, np.arange(mesh.n_faces)), mesh, tmp_path / "old.npz")
    lines = run(FULL_DISK, tmp_path).splitlines()
    assert "can't write" in lines[0]
    assert "The edit is done, but only in memory" in lines[0]
    assert lines[1] == "False True"
    assert "OSError" in lines[2]
    assert "new.swproj" in lines[3]
    assert lines[-2:] == ["True True True", "there is room again"]
    names = {p.name for p in tmp_path.iterdir()}
    assert "new.swproj" not in names
    assert not any(name.endswith(".tmp") for name in names)


@pytest.mark.skipif(os.name != "posix", reason="needs limits of resources")
def test_a_new_file_for_whose_log_there_is_no_room_does_not_stay(tmp_path):
    import resource

    mesh = shapes.box(4)
    session, limits = (
        Session(mesh, Segmentation.from_labels(mesh, np.arange(192))),
        resource.getrlimit(resource.RLIMIT_FSIZE),
    )
    resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, limits[1]))  # the index of the log takes 32 kB
    try:
        with pytest.raises(OSError, match=r"can't write '.*a\.swproj': the disk is full"):
            session.save(tmp_path / "a.swproj")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert list(tmp_path.iterdir()) == []
    session.save(tmp_path / "a.swproj", overwrite=False)
    session.close()


# --- damage ---------------------------------------------------------------------------------------


def test_what_is_no_project_is_refused(tmp_path):
    mesh = shapes.box(4)
    with pytest.raises(FileNotFoundError, match=r"project file .*gone\.swproj' does not exist"):
        Session.open(tmp_path / "gone.swproj", mesh)
    with pytest.raises(ProjectError, match="is no file"):
        Session.open(tmp_path, mesh)
    for content in (b"", b"hello", b"SQLite format 3\0" + b"\0" * 100, b"x" * 5000):
        (tmp_path / "a.swproj").write_bytes(content)
        with pytest.raises(ProjectError, match=r"a\.swproj"):
            Session.open(tmp_path / "a.swproj", mesh)
    sqlite3.connect(tmp_path / "b.swproj").execute("CREATE TABLE fact (x)").connection.close()
    with pytest.raises(ProjectError, match="is no project file of scenewidget"):
        Session.open(tmp_path / "b.swproj", mesh)
    assert not list(tmp_path.glob("*.lock"))


def change(path, *statements):
    with sqlite3.connect(path, isolation_level=None) as connection:
        for statement in statements:
            connection.execute(*statement) if isinstance(statement, tuple) else connection.execute(statement)
    connection.close()


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("PRAGMA user_version=99", "written by a newer scenewidget .format 99"),
        ("PRAGMA user_version=0", "damaged"),
        (
            "UPDATE operation SET time = time + 1 WHERE seq = 2",
            "entry 2 of its log was changed.*keeps the 2 of",
        ),
        ("DELETE FROM operation WHERE seq = 1", "entry 1 of its log was changed"),
        ("UPDATE operation SET body = '[' WHERE seq = 3", "entry 3 of its log was changed"),
        ("UPDATE array SET data = zeroblob(10) WHERE name = 'labels'", "its array 'labels' was changed"),
        ("UPDATE fact SET value = '[]' WHERE key = 'names'", "its entry 'names' was changed"),
        ("DELETE FROM fact WHERE key = 'names'", "damaged"),
        ("DELETE FROM array WHERE name = 'labels'", "damaged"),
        ("CREATE TABLE more (x)", "forged: it holds 'table more'"),
        ("CREATE TRIGGER t AFTER INSERT ON operation BEGIN DELETE FROM array; END", "forged"),
        ("CREATE VIEW v AS SELECT 1", "forged"),
    ],
)
def test_changed_files_are_refused(tmp_path, statement, message):
    _, _, mesh = saved(tmp_path / "room.swproj")
    change(tmp_path / "room.swproj", statement)
    with pytest.raises(ProjectError, match=message):
        Session.open(tmp_path / "room.swproj", mesh)


def test_a_damaged_log_can_be_recovered_up_to_the_damage(tmp_path):
    _, edits, mesh = saved(tmp_path / "room.swproj")
    change(tmp_path / "room.swproj", "UPDATE operation SET body = '3' WHERE seq = 3")
    with Session.open(tmp_path / "room.swproj", mesh, recover=True) as session:
        assert session.edits == edits[:2]
        session.merge(100, 0)
    with Session.open(tmp_path / "room.swproj", mesh) as again:
        assert len(again.edits) == 3


def forge(path, *statements):
    """Change a file as somebody does who knows how its digests are made."""
    with sqlite3.connect(path, isolation_level=None) as connection:
        for statement in statements:
            connection.execute(*statement)
        root = schema.read_root(connection)
        content = schema._content_of(connection)
        connection.execute("UPDATE root SET content = ? WHERE n_operations = ?", (content, root.n_operations))
    connection.close()


def forge_array(path, name, dtype, shape, data):
    row = (name, dtype, shape, data)
    digest = schema._digest(b"", *row)
    forge(path, ("INSERT OR REPLACE INTO array VALUES (?, ?, ?, ?, ?)", (*row, digest)))


@pytest.mark.parametrize(
    ("dtype", "shape"),
    [("<i4", "[2000000000]"), ("<i4", "[192, 1]"), ("|O", "[192]"), ("<i4", "[-192]"), ("<i4", "[true]"),
     ("<i4", "192"), ("<i4", "[192.0]")],
)  # fmt: skip
def test_forged_arrays_are_refused_before_they_take_memory(tmp_path, dtype, shape):
    import zlib

    _, _, mesh = saved(tmp_path / "room.swproj")
    forge_array(tmp_path / "room.swproj", "labels", dtype, shape, zlib.compress(b"\0" * 768))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ProjectError, match=r"room\.swproj"):
        Session.open(tmp_path / "room.swproj", mesh)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000


def test_a_bomb_of_zeros_is_refused(tmp_path):
    import zlib

    _, _, mesh = saved(tmp_path / "room.swproj")
    forge_array(tmp_path / "room.swproj", "labels", "<i4", "[192]", zlib.compress(b"\0" * 100_000_000))
    with pytest.raises(ProjectError, match="has not the 768 bytes"):
        Session.open(tmp_path / "room.swproj", mesh)


OLD_EDITS = [Relabel(0, "chair"), Merge((0, 40), 70), Cut(0, 70)]


def version_of(path):
    with sqlite3.connect(path) as connection:
        version = connection.execute("PRAGMA user_version").fetchone()[0]
    connection.close()
    return version


@pytest.mark.filterwarnings("ignore:.*read-only")
@pytest.mark.parametrize("read_only", [False, True])
@pytest.mark.parametrize("name", ["format_1", "format_1_killed", "format_2", "format_2_killed"])
def test_projects_of_every_format_open_and_are_brought_up_to_date(tmp_path, monkeypatch, name, read_only):
    path = old_project(tmp_path, name)
    if read_only:
        monkeypatch.setattr(store.os, "access", lambda *_: False)
    with Session.open(path) as session:  # the mesh is in the file
        assert session.read_only == read_only
        assert session.edits == OLD_EDITS
        assert list(session.undone) == [Split(100, "base")]
        assert session.vocabulary == ("chair", "Tür")
        expected = session.segmentation
    monkeypatch.undo()
    if read_only:
        assert path.read_bytes() == (GOLDEN / f"{name}.swproj").read_bytes()
        return
    assert version_of(path) == schema.VERSION
    with Session.open(path) as again:
        assert_same(again.segmentation, expected)
        again.redo()


def test_parameters_of_another_version_are_left_out(tmp_path):
    _, _, mesh = saved(tmp_path / "room.swproj")
    text = '{"n_segments":5,"not_yet_invented":1}'
    row = ("params", text, schema._digest(b"", "params", text))
    forge(tmp_path / "room.swproj", ("INSERT OR REPLACE INTO fact VALUES (?, ?, ?)", row))
    with pytest.warns(UserWarning, match="of another version and left out"):
        assert Session.open(tmp_path / "room.swproj", mesh).params is None


def test_strokes_and_slices_survive_in_the_file_and_are_small_there(tmp_path):
    session = box_session()
    session.save(tmp_path / "room.swproj")
    rng = np.random.default_rng(0)
    session.paint(np.flatnonzero(rng.random(192) < 0.5), onto_face=190)
    session.paint(range(20, 90))
    session.slice(100, (0.1, 0.2, 0.3), (1.0, 1.0, 0.3))
    session.grow(100)
    session.smooth_border(30, rounds=5)
    session.slice(190, session.mesh.vertices.mean(axis=0), (0.3, 1.0, 0.2))
    session.shrink(30)
    session.undo()
    expected, edits = session.segmentation, session.edits
    del session  # as if the process had been killed: nothing is closed
    with Session.open(tmp_path / "room.swproj", shapes.box(4)) as again:
        assert again.edits == edits
        assert_same(again.segmentation, expected)
        again.redo()
        again.go_to(0)
        assert again.segmentation is again.automatic
        assert list(again.to_frame()["edit"][1:4]) == ["paint", "paint", "slice"]
    with sqlite3.connect(tmp_path / "room.swproj") as connection:
        bodies = [row[0] for row in connection.execute("SELECT body FROM operation ORDER BY seq")]
    assert max(map(len, bodies)) < 500
    assert '"ranges":[20,90]' in bodies[2]


@pytest.mark.parametrize("ranges", [[0, 2**40], [-1, 2], [5, 2], [0.5, 3], []])
def test_forged_strokes_are_refused_at_the_door(tmp_path, monkeypatch, ranges):
    session = box_session()
    session.save(tmp_path / "room.swproj")
    monkeypatch.setattr(schema, "edit_values", lambda _: {"kind": "paint", "ranges": ranges, "onto_face": 70})
    session.paint([0, 40], 70)
    session.close()
    with pytest.raises(ProjectError):
        Session.open(tmp_path / "room.swproj", shapes.box(4))


def test_a_forged_stroke_of_all_numbers_takes_no_memory_and_says_why_it_does_not_apply(tmp_path, monkeypatch):
    session = box_session()
    session.save(tmp_path / "room.swproj")
    monkeypatch.setattr(schema, "edit_values", lambda _: {"kind": "paint", "ranges": [0, 2**31]})
    session.paint([0, 40], 70)
    session.close()
    with Session.open(tmp_path / "room.swproj", shapes.box(4)) as again:
        assert "there is no face 2147483647" in again.history[0].problem
        assert len(again.to_frame()["faces"].iloc[1]) == 1000
