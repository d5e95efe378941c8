"""What a session says of its project file is true of what lies at the path now."""

import errno
import os
import shutil
import sqlite3
import tempfile
import time
from pathlib import Path

import pytest
import shapes
from test_session import box_session
from test_store import OLD_EDITS, change, old_project, run, saved

import scenewidget as sw
from scenewidget.editing import files, project_reader, schema
from scenewidget.editing.edits import Merge
from scenewidget.editing.project import ProjectError
from scenewidget.editing.project_reader import summary_of
from scenewidget.editing.session import Session

NAME = "room.swproj"


def working(folder, **options):
    """A session with one edit in its file."""
    session = box_session()
    session.save(folder / NAME, **options)
    session.merge(0, 40)
    return session


def other_file(folder):
    session = box_session()
    session.save(folder / "other.swproj")
    session.relabel(0, "other")
    session.close()
    return folder / "other.swproj"


# --- saved means saved at that path, now ----------------------------------------------------------

HAPPENINGS = {
    "deleted": (lambda f: (f / NAME).unlink(), "'room.swproj' was deleted; save.. writes it anew"),
    "renamed": (
        lambda f: (f / NAME).rename(f / "b.swproj"),
        "renamed or moved away; save.. writes a new one",
    ),
    "folder removed": (shutil.rmtree, "the folder of 'room.swproj' is gone; save your work elsewhere"),
    "folder renamed": (lambda f: f.rename(f.with_name("b")), "the folder of 'room.swproj' is gone"),
    "replaced": (
        lambda f: other_file(f).replace(f / NAME),
        "another file has taken the place of 'room.swproj'",
    ),
    "written over": (
        lambda f: shutil.copyfile(other_file(f), f / NAME),
        "somebody else has written into 'room.swproj'",
    ),
    "truncated": (lambda f: (f / NAME).write_bytes(b""), "somebody else has written into 'room.swproj'"),
}


@pytest.mark.parametrize("happening", HAPPENINGS)
def test_a_file_that_is_no_longer_ours_is_noticed_at_once(tmp_path, happening):
    folder = tmp_path / "a"
    folder.mkdir()
    happens, message = HAPPENINGS[happening]
    session = working(folder)
    assert session.is_saved
    happens(folder)
    assert not session.is_saved  # at a look
    with pytest.warns(UserWarning, match=message + ".*The edit is done, but only in memory"):
        session.merge(70, 40)
    assert not session.is_saved  # at an edit
    assert len(session.edits) == 2
    if "folder" in happening:
        with pytest.raises(FileNotFoundError, match="its folder does not exist; make it first"):
            session.save()
        folder.mkdir(exist_ok=True)
    elif happening in ("replaced", "written over"):
        content = (folder / NAME).read_bytes()
        with pytest.raises(FileExistsError, match=message):
            session.save()
        assert (folder / NAME).read_bytes() == content
        session.save(folder / "mine.swproj")
        assert session.is_saved
    elif happening == "truncated":
        with pytest.raises(FileExistsError, match=message):
            session.save()
    session.save(folder / NAME)
    session.relabel(0, "chair")
    assert session.is_saved
    mesh = session.mesh
    session.close()
    assert {path.name for path in folder.iterdir()} <= {NAME, "b.swproj", "mine.swproj", "other.swproj"}
    assert len(Session.open(folder / NAME, mesh).edits) == 3


def test_a_file_that_comes_back_is_gone_on_with(tmp_path):
    session = working(tmp_path)
    (tmp_path / NAME).rename(tmp_path / "b")
    with pytest.warns(UserWarning, match="moved away"):
        session.merge(70, 40)
    (tmp_path / "b").rename(tmp_path / NAME)
    session.merge(100, 40)
    assert session.is_saved
    session.close()
    assert len(Session.open(tmp_path / NAME, session.mesh).edits) == 3


def test_a_file_that_was_only_touched_is_still_ours(tmp_path):
    session = working(tmp_path)
    os.utime(tmp_path / NAME, ns=(1, 1))
    assert session.is_saved
    session.merge(70, 40)
    assert session.is_saved


def test_a_file_with_its_mesh_is_written_anew_with_it(tmp_path):
    session = working(tmp_path, include_mesh=True)
    (tmp_path / NAME).unlink()
    session.save()
    session.close()
    del session
    assert run("import sys, scenewidget as sw; print(sw.Session.open(sys.argv[1]).mesh)", tmp_path / NAME)


RENAMED_AND_KILLED = """
    import os, signal, sys
    from pathlib import Path
    from test_session import box_session
    path = Path(sys.argv[1])
    session = box_session()
    session.save(path)
    for n in range(int(sys.argv[2])):
        session.relabel(0, str(n))
    assert session.is_saved
    path.rename(path.with_name("b.swproj"))
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
@pytest.mark.parametrize("n", [1, 15])
def test_a_renamed_file_of_a_killed_process_holds_all_that_was_acknowledged(tmp_path, n):
    with pytest.raises(AssertionError):
        run(RENAMED_AND_KILLED, tmp_path / NAME, n)
    with Session.open(tmp_path / "b.swproj", shapes.box(4)) as session:
        assert len(session.edits) == n


def test_the_log_begins_anew_now_and_then_and_nothing_is_lost(tmp_path):
    session = working(tmp_path)
    sizes = set()
    for n in range(300):
        session.relabel(0, f"name {n}")
        sizes.add((tmp_path / f"{NAME}-wal").stat().st_size)
    assert max(sizes) < 3e6
    assert min(sizes) < max(sizes) / 10
    session.close()
    assert len(Session.open(tmp_path / NAME, session.mesh).edits) == 301


@pytest.mark.filterwarnings("ignore:.*only in memory")
@pytest.mark.parametrize("way_out", ["save", "copy"])
def test_the_picture_says_so_and_offers_ways_out(tmp_path, monkeypatch, way_out):
    monkeypatch.chdir(tmp_path)
    mesh = shapes.box(4)
    widget = sw.SceneWidget(mesh, sw.Params(n_segments=6, n_runs=2, n_graph_runs=2), autosave=tmp_path / NAME)
    widget.wait()
    widget.session.relabel(0, "one")
    widget.save()
    assert widget.view.save_state == "saved"
    (tmp_path / NAME).unlink()
    widget.session.relabel(0, "two")
    assert widget.view.save_state == "failed"
    assert "'room.swproj' was deleted" in widget.view.save_note
    widget.view._handle_custom_msg({"kind": "choose", "notice": "file", "action": way_out}, [])
    assert widget.view.save_state == "saved"
    assert widget.view.notices == []
    assert summary_of(widget.session.path).n_steps == 2
    widget.close()


# --- check before you take ------------------------------------------------------------------------


def test_a_refused_opening_leaves_the_file_with_whoever_has_it(tmp_path):
    session = working(tmp_path)
    heard = []
    session.observe(heard.append)
    with pytest.raises(ProjectError, match="belongs to another mesh"):
        Session.open(tmp_path / NAME, shapes.box(2))
    session.merge(70, 40)
    assert session.is_saved
    assert [event.kind for event in heard] == ["edit"]
    assert (tmp_path / f"{NAME}.lock").exists()


def test_a_save_that_fails_leaves_the_file_with_whoever_has_it(tmp_path, monkeypatch):
    session, other = working(tmp_path), box_session()

    def full(*_):
        raise OSError(errno.ENOSPC, "no space left on device")

    for place in ("fsync", "replace"):
        with monkeypatch.context() as patch:
            patch.setattr(*((files.os, "fsync", full) if place == "fsync" else (files.Path, "replace", full)))
            with pytest.raises(OSError, match="the disk is full"):
                other.save(tmp_path / NAME)
        session.relabel(0, place)
        assert session.is_saved
    assert {p.name for p in tmp_path.iterdir()} == {NAME, f"{NAME}-wal", f"{NAME}-shm", f"{NAME}.lock"}
    session.close()
    assert [edit.name for edit in Session.open(tmp_path / NAME, session.mesh).edits[1:]] == [
        "fsync",
        "replace",
    ]


def test_who_was_taken_over_does_not_write_over_the_newer_session(tmp_path):
    first = working(tmp_path)
    second = Session.open(tmp_path / NAME, first.mesh)
    second.merge(70, 40)
    with pytest.raises(PermissionError, match="a newer session has taken it over; save under another name"):
        first.save()
    second.merge(100, 40)
    assert second.is_saved


def test_what_is_no_project_is_never_replaced_by_one(tmp_path):
    (tmp_path / "scan.ply").write_bytes(b"ply\nformat ascii 1.0\n" + b"x" * 100)
    with pytest.raises(
        FileExistsError, match="is no project file, so it is not replaced; choose another name"
    ):
        box_session().save(tmp_path / "scan.ply")
    assert [p.name for p in tmp_path.iterdir()] == ["scan.ply"]


WRITER = """
    import sys, warnings, shapes, scenewidget as sw
    warnings.simplefilter("ignore")
    session = sw.Session.open(sys.argv[1], shapes.box(4))
    print(session.read_only, session.file_reason)
"""


@pytest.mark.skipif(os.name != "posix", reason="links of another kind")
def test_all_names_of_a_file_are_one(tmp_path, monkeypatch):
    inside = tmp_path / "inside"
    inside.mkdir()
    session = working(inside)
    (tmp_path / "soft.swproj").symlink_to(inside / NAME)
    (tmp_path / "hard.swproj").hardlink_to(inside / NAME)
    (tmp_path / "way").symlink_to(inside)
    monkeypatch.chdir(inside)
    for path in (
        tmp_path / "soft.swproj",
        tmp_path / "way" / NAME,
        f"../inside/{NAME}",
        tmp_path / "hard.swproj",
    ):
        assert run(WRITER, path).startswith("True another kernel or script"), path
        session.relabel(0, str(path)[-60:])
        assert session.is_saved
    for path in (
        tmp_path / "soft.swproj",
        Path(NAME),
        tmp_path / "hard.swproj",
    ):  # in this process the newer has it
        newer = Session.open(path, session.mesh)
        assert not newer.read_only
        assert "taken the file over" in session.file_problem
        assert len(newer.edits) == len(session.edits)
        session = newer
        session.relabel(40, str(path)[-60:])
        assert session.is_saved
    session.close()
    assert (tmp_path / "soft.swproj").is_symlink()
    assert not [p for p in (*tmp_path.iterdir(), *inside.iterdir()) if ".lock" in p.name or "-wal" in p.name]


def test_saving_through_a_link_writes_where_it_leads(tmp_path):
    session = working(tmp_path)
    (tmp_path / "soft.swproj").symlink_to(tmp_path / NAME)
    session.save(tmp_path / "soft.swproj", include_mesh=True)
    assert (tmp_path / "soft.swproj").is_symlink()
    session.merge(70, 40)
    session.close()
    assert len(Session.open(tmp_path / NAME).edits) == 2


# --- media ----------------------------------------------------------------------------------------


def killed(folder, n=3, version=schema.VERSION):
    """File and log as a killed process leaves them, the last steps in the log alone; the mesh."""
    if version == 1:
        old_project(folder, "format_1_killed")
        return shapes.box(4), len(OLD_EDITS)
    session = working(folder)
    shutil.copy(folder / NAME, folder / "before")
    for k in range(n):
        session.relabel(0, f"step {k}")
    shutil.copy(folder / f"{NAME}-wal", folder / "log")
    session.close()
    (folder / "before").replace(folder / NAME)
    (folder / "log").replace(folder / f"{NAME}-wal")
    return session.mesh, 1 + n


READ_AS_NOBODY = """
    import os, sys, warnings, shapes, scenewidget as sw
    from scenewidget.editing.project_reader import summary_of
    from pathlib import Path
    warnings.simplefilter("ignore")
    summary_of, sw.Session
    if os.geteuid() == 0:
        os.setuid(65534)
    try:
        session = sw.Session.open(sys.argv[1], shapes.box(4))
        print(session.read_only, len(session.edits), summary_of(Path(sys.argv[1])).n_steps)
    except ValueError as error:
        print(error)
"""


@pytest.mark.skipif(os.name != "posix", reason="permissions of another kind")
@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("index", [False, True])
def test_a_log_on_a_read_only_medium_counts(version, index):
    with tempfile.TemporaryDirectory() as name:  # pytest's own folders are for their owner only
        check_read_only(Path(name), version, index)


def check_read_only(folder, version, index):
    _, n = killed(folder, version=version)
    if index:
        (folder / f"{NAME}-shm").write_bytes(b"\0" * 32768)  # of another mount, say
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    folder.chmod(0o555)
    try:
        assert run(READ_AS_NOBODY, folder / NAME) == f"True {n} {n}"
        (folder / f"{NAME}-wal").chmod(0)
        assert "can't be read" in run(READ_AS_NOBODY, folder / NAME)
    finally:
        folder.chmod(0o755)
        (folder / f"{NAME}-wal").chmod(0o644)
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before


def test_an_index_that_tells_of_a_lost_log_is_believed(tmp_path):
    session = working(tmp_path)
    session.merge(70, 40)
    shutil.copy(tmp_path / f"{NAME}-shm", tmp_path / "index")
    session.close()
    index = bytearray((tmp_path / "index").read_bytes())
    (tmp_path / f"{NAME}-shm").write_bytes(index)
    assert (
        len(Session.open(tmp_path / NAME, session.mesh).edits) == 2
    )  # nothing in the log that the file lacks
    index[96:100] = b"\0\0\0\0"
    gc_free_copy = tmp_path / "b.swproj"
    shutil.copy(tmp_path / NAME, gc_free_copy)
    gc_free_copy.with_name("b.swproj-shm").write_bytes(index)
    with pytest.raises(ProjectError, match=r"lacks its log 'b.swproj-wal', which held the last steps"):
        Session.open(gc_free_copy, session.mesh)


@pytest.mark.filterwarnings("ignore:.*read-only")
def test_where_there_are_no_locks_nothing_is_written(tmp_path, monkeypatch):
    mesh, n = killed(tmp_path)

    def refuse(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", refuse)
    before = (tmp_path / NAME).read_bytes()
    session = Session.open(tmp_path / NAME, mesh)
    assert session.read_only
    assert "can't keep others from writing at the same time (No locks available)" in session.file_reason
    assert len(session.edits) == n
    assert (tmp_path / NAME).read_bytes() == before
    assert not (tmp_path / f"{NAME}.lock").exists()


def test_a_log_of_earlier_does_not_undo_what_was_done_since(tmp_path):
    session = working(tmp_path)
    shutil.copy(tmp_path / f"{NAME}-wal", tmp_path / "log")
    session.merge(70, 40)
    session.merge(100, 40)
    session.close()
    (tmp_path / "log").replace(tmp_path / f"{NAME}-wal")
    with Session.open(tmp_path / NAME, session.mesh) as again:
        assert len(again.edits) == 3
        again.merge(130, 40)
        assert again.is_saved
    assert len(Session.open(tmp_path / NAME, session.mesh).edits) == 4


def test_a_log_of_other_work_is_refused(tmp_path):
    session = working(tmp_path)
    shutil.copy(tmp_path / NAME, tmp_path / "a.swproj")
    session.undo()
    session.relabel(0, "other")
    shutil.copy(tmp_path / f"{NAME}-wal", tmp_path / "a.swproj-wal")
    session.close()
    with Session.open(tmp_path / "a.swproj", session.mesh) as again:  # it goes on from the file
        assert [edit.name for edit in again.edits] == ["other"]
    with Session.open(tmp_path / "a.swproj", session.mesh) as again:
        again.relabel(0, "mine")
        shutil.copy(tmp_path / "a.swproj", tmp_path / "b.swproj")
    session = working(tmp_path)
    session.merge(70, 40)
    shutil.copy(tmp_path / f"{NAME}-wal", tmp_path / "b.swproj-wal")
    session.close()
    before = (tmp_path / "b.swproj").read_bytes()
    with pytest.raises(ProjectError, match=r"recover=True. takes the file without"):
        Session.open(tmp_path / "b.swproj", session.mesh)
    assert (tmp_path / "b.swproj").read_bytes() == before
    with Session.open(tmp_path / "b.swproj", session.mesh, recover=True) as again:
        assert [edit.name for edit in again.edits] == ["other", "mine"]
        again.relabel(0, "more")
        assert again.is_saved
    assert len(Session.open(tmp_path / "b.swproj", session.mesh).edits) == 3


# --- forged files ---------------------------------------------------------------------------------

ENDLESS = "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n) SELECT"
FORGERIES = {
    "a view for the log": (
        "DROP TABLE operation",
        f"CREATE VIEW operation AS {ENDLESS} k AS seq, 1.0 AS time, 'edit' AS action, '' AS body, "
        "NULL AS extra, x'' AS digest FROM n",
    ),
    "a view for the facts": (
        "DROP TABLE fact",
        f"CREATE VIEW fact AS {ENDLESS} 'fingerprint' AS key, '' AS value, x'' AS digest FROM n",
    ),
    "a view for the root": (
        "DROP TABLE root",
        f"CREATE VIEW root AS {ENDLESS} k AS id, 0 AS n_operations, x'' AS log, x'' AS content FROM n",
    ),
    "a check that takes long": (
        "DROP TABLE operation",
        "CREATE TABLE operation (seq INTEGER PRIMARY KEY CHECK (length(randomblob(500000000)) > 0), "
        "time REAL NOT NULL, action TEXT NOT NULL, body TEXT NOT NULL, extra BLOB, digest BLOB NOT NULL)",
    ),
    "a computed column": (
        "DROP TABLE fact",
        "CREATE TABLE fact (key TEXT PRIMARY KEY, value TEXT AS (hex(zeroblob(400000000))), digest BLOB)",
    ),
    "an index on an expression": ("CREATE INDEX i ON operation (length(randomblob(100000000)))",),
    "a million tables": tuple(f"CREATE TABLE t{k} (x)" for k in range(3000)),
    "a virtual table": ("CREATE VIRTUAL TABLE v USING fts5(x)",),
    "a trigger": ("CREATE TRIGGER t AFTER INSERT ON operation BEGIN DELETE FROM array; END",),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_forged_files_are_refused_at_once_by_every_reader(tmp_path, monkeypatch, forgery):
    from scenewidget.widget.autosave import default_name

    monkeypatch.chdir(tmp_path)
    _, _, mesh = saved(tmp_path / NAME)
    path = tmp_path / default_name(mesh)
    (tmp_path / NAME).rename(path)
    try:
        change(path, "PRAGMA journal_mode=DELETE", "BEGIN", *FORGERIES[forgery], "COMMIT")
    except sqlite3.OperationalError as error:
        pytest.skip(str(error))
    begin = time.thread_time()
    with pytest.raises(ProjectError, match=path.name):
        Session.open(path, mesh)
    with pytest.raises(ProjectError, match=path.name):
        summary_of(path)
    widget = sw.SceneWidget(mesh, sw.Params(n_runs=2, n_graph_runs=2), autosave=True)
    assert widget.view.notices == []
    assert time.thread_time() - begin < 1  # of this thread: the machine may be busy
    widget.close()
    with pytest.raises(ProjectError, match=path.name):
        sw.SceneWidget(mesh, autosave=path)


def test_a_pipe_is_no_project(tmp_path):
    if os.name == "posix":
        os.mkfifo(tmp_path / "p.swproj")
        with pytest.raises(ProjectError, match="is no file"):
            summary_of(tmp_path / "p.swproj")


def test_a_journal_may_not_name_another_file(tmp_path):
    _, _, mesh = saved(tmp_path / NAME)
    (tmp_path / "precious").write_text("x")
    name = bytes(str(tmp_path / "precious"), "ascii")
    end = len(name).to_bytes(4, "big") + sum(name).to_bytes(4, "big") + project_reader.SUPER_JOURNAL
    (tmp_path / f"{NAME}-journal").write_bytes(project_reader.SUPER_JOURNAL + b"\0" * 504 + name + end)
    with pytest.raises(ProjectError, match="names another file"):
        Session.open(tmp_path / NAME, mesh)
    assert (tmp_path / "precious").exists()


def test_a_long_stroke_is_kept_small(tmp_path):
    session = box_session()
    session.save(tmp_path / NAME)
    session.do(Merge(tuple(range(0, 190)), 191))
    session.close()
    with sqlite3.connect(tmp_path / NAME) as connection:
        (body,) = connection.execute("SELECT body FROM operation WHERE action = 'edit'").fetchone()
    connection.close()
    assert len(body) < 250
    with Session.open(tmp_path / NAME, session.mesh) as again:
        assert again.edits == session.edits
