"""Attacks on project files: splices of true states, copies of a file that is being written, kills."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import signal
import sqlite3
import time
import warnings
from pathlib import Path

import numpy as np
import shapes
from mortal import Mortal
from saver import start

from scenewidget.editing import store
from scenewidget.editing.edits import Cut, EditError, Merge, Relabel, Split
from scenewidget.editing.project import ProjectError
from scenewidget.editing.project_reader import read_project, summary_of
from scenewidget.editing.schema import VERSION
from scenewidget.editing.session import Session
from scenewidget.engine.segmentation import Segmentation

HERE = Path(__file__).parent
MESH = shapes.box(6)
SUFFIXES = ("", "-wal", "-shm")
DEADLY = getattr(signal, "SIGKILL", signal.SIGTERM)  # on Windows, os.kill ends a process at once by any


def another(k):
    """Other segmentations of the mesh."""
    n = MESH.n_faces
    levels = {name: np.arange(n, dtype=np.int32) // size for name, size in (("dihedral", 2), ("base", 4))}
    return Segmentation(MESH, (np.arange(n, dtype=np.int32) // (16 + 8 * (k % 5))), levels=levels)


def some_work(session, rng, n):
    """Edits, undos, names, cuts and now and then another segmentation."""
    for _ in range(n):
        a, b = (int(x) for x in rng.integers(0, MESH.n_faces, 2))
        action = rng.integers(0, 9)
        try:
            if action < 2:
                session.merge(a, b, ("dihedral", "base", "final")[a % 3] if action else "final")
            elif action == 2:
                session.split(a, "base")
            elif action < 5:
                session.relabel(a, f"name {b} " + "x" * (b % 150))
            elif action == 5:
                session.undo()
            elif action == 6:
                session.redo()
            elif action == 7:
                session.cut(a, b)
            elif b % 3 == 0:
                session.resegment(another(b))
        except EditError:
            continue


def state_of(session, n_opened=0):
    """A digest of everything that a person would miss; without the last ``n_opened`` operations."""
    seg, frame = session.segmentation, session.to_frame()
    said = (
        seg.names,
        session.edits,
        session.undone,
        session.vocabulary,
        frame["time"].tolist()[: len(frame) - n_opened],
    )
    digest = hashlib.blake2b(repr(said).encode(), digest_size=16)
    digest.update(seg.labels.tobytes())
    digest.update(session.automatic.labels.tobytes())
    return len(frame) - n_opened, digest.hexdigest()


def opened(path):
    """The state that a file opens in, None if it is refused; anything else is an error."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with contextlib.suppress(ProjectError):
                summary_of(path)
            with Session.open(path, MESH) as session:
                return state_of(session, n_opened=1)
    except ProjectError:
        return None


# --- splices --------------------------------------------------------------------------------------


def true_states(folder, rng, n=24):
    """Files with their logs as they lay there at some moments, and all states that there have been."""
    moments, known = [], set()
    for project in range(2):  # of one mesh
        path = folder / f"p{project}.swproj"
        session = start(MESH)
        session.save(path, include_mesh=bool(project))
        known.add(state_of(session))
        session.observe(lambda _, session=session: known.add(state_of(session)))
        for moment in range(n // 2):
            some_work(session, rng, int(rng.integers(1, 8)))
            if moment % 4 == 3:
                session.save()
            moments.append(
                {s: Path(f"{path}{s}").read_bytes() for s in SUFFIXES if Path(f"{path}{s}").exists()}
            )
        session.close()
    return moments, known


def spliced(moments, rng):
    """Parts of two true states put together."""
    a, b = (moments[int(k)] for k in rng.integers(0, len(moments), 2))
    kind = rng.integers(5)
    if kind == 0:  # each file from somewhere
        parts = {"": a[""]}
        for suffix in ("-wal", "-shm"):
            source = (a, b, {})[int(rng.integers(3))]
            if suffix in source:
                parts[suffix] = source[suffix]
        return parts
    one, other = np.frombuffer(a[""], np.uint8), np.frombuffer(b[""], np.uint8)
    size = 4096
    n = max(len(one), len(other)) // size
    padded = [np.zeros(n * size, np.uint8), np.zeros(n * size, np.uint8)]
    for out, data in zip(padded, (one, other)):
        out[: len(data)] = data
    mask = np.zeros(n, bool)
    if kind == 1:
        mask[int(rng.integers(n + 1)) :] = True
    elif kind == 2:
        mask[int(rng.integers(n))] = True
    else:
        mask = rng.random(n) < rng.random()
    pages = np.where(mask[:, None], padded[1].reshape(n, size), padded[0].reshape(n, size))
    length = len(one) if rng.random() < 0.5 else len(other)
    parts = {"": pages.tobytes()[:length]}
    if kind == 4 and "-wal" in a:
        parts["-wal"] = a["-wal"]
    return parts


def spliced_tables(folder, moments, rng):
    """Rows of one true state in the place of those of another."""
    a, b = (moments[int(k)] for k in rng.integers(0, len(moments), 2))
    for name, parts in (("a", a), ("b", b)):
        for suffix in SUFFIXES:
            Path(f"{folder}/{name}{suffix}").unlink(missing_ok=True)
        Path(f"{folder}/{name}").write_bytes(parts[""])
    connection = sqlite3.connect(folder / "a", isolation_level=None)
    connection.execute("ATTACH ? AS other", (str(folder / "b"),))
    table = ("fact", "array", "operation", "root")[int(rng.integers(4))]
    key = {"fact": "key", "array": "name", "operation": "seq", "root": "id"}[table]
    if rng.random() < 0.4:
        connection.execute(f"DELETE FROM {table}")
        connection.execute(f"INSERT INTO {table} SELECT * FROM other.{table}")
    else:
        rows = connection.execute(f"SELECT * FROM other.{table}").fetchall()
        row = rows[int(rng.integers(len(rows)))]
        connection.execute(f"INSERT OR REPLACE INTO {table} VALUES ({', '.join('?' * len(row))})", row)
        if rng.random() < 0.3:
            connection.execute(f"DELETE FROM {table} WHERE {key} > ?", (row[0],))
    connection.execute("PRAGMA journal_mode=DELETE")
    connection.close()
    return {"": (folder / "a").read_bytes()}


def try_splices(folder, n, *, seed=0):
    """How many splices opened in a true state, were refused, and which opened in a state that never was."""
    rng = np.random.default_rng(seed)
    folder = Path(folder)
    moments, known = true_states(folder, rng)
    read = opened_parts(folder)
    assert all(read(parts) in known for parts in moments)
    n_true, n_refused, wrong = 0, 0, []
    for k in range(n):
        parts = spliced_tables(folder, moments, rng) if k % 4 == 3 else spliced(moments, rng)
        found = read(parts)
        n_refused += found is None
        n_true += found in known
        if found is not None and found not in known:
            wrong.append(k)
    return n_true, n_refused, wrong


def opened_parts(folder):
    """A function that opens a file and what lies beside it, given as bytes."""
    path = folder / "spliced.swproj"

    def read(parts):
        for suffix in (*SUFFIXES, "-journal", ".lock"):
            Path(f"{path}{suffix}").unlink(missing_ok=True)
        for suffix, data in parts.items():
            Path(f"{path}{suffix}").write_bytes(data)
        return opened(path)

    return read


# --- copies of a file that is being written -------------------------------------------------------


def edit_for_ever(path, seed, tell):
    """Edit until somebody kills us; ``tell`` hears of each state as soon as it is on the disk."""
    rng = np.random.default_rng(seed)
    session = start(MESH)
    session.save(path)
    tell.send(state_of(session))
    while True:
        some_work(session, rng, 1)
        assert session.is_saved
        tell.send(state_of(session))


def try_live_copies(folder, n, *, seed=0):
    """Copies, files in any order, some left out, while another process edits.

    Returns
    -------
    n_true, n_refused : int
    wrong : list of str
        What was wrong with the others: a state that never was, or one without what was acknowledged before.
    """
    rng = np.random.default_rng(seed)
    folder = Path(folder)
    path = folder / "live.swproj"
    editor = Mortal(edit_for_ever, path, seed)
    told, copies = [editor.hear()], []
    for k in range(n):
        told += editor.heard()
        acknowledged, _ = told[-1]
        suffixes = [s for s in rng.permutation(SUFFIXES).tolist() if s == "" or rng.random() < 0.6]
        copy = folder / f"copy{k}.swproj"
        for suffix in suffixes:
            with contextlib.suppress(FileNotFoundError, PermissionError):  # or locked, on Windows
                shutil.copyfile(f"{path}{suffix}", f"{copy}{suffix}")
        copies.append((copy, suffixes, acknowledged))
    known = {*told, *editor.kill()}
    last = opened(path)  # may have one more step, which we weren't told of
    n_true, n_refused, wrong = 0, 0, []
    for copy, suffixes, acknowledged in copies:
        found = opened(copy)
        n_refused += found is None
        if found is not None and found not in known and found != last:
            wrong.append(f"{copy.name} {suffixes}: a state that never was")
        elif found is not None and found[0] < acknowledged:
            wrong.append(f"{copy.name} {suffixes}: {found[0]} of {acknowledged} operations")
        n_true += found is not None
        for suffix in (*SUFFIXES, ".lock"):
            Path(f"{copy}{suffix}").unlink(missing_ok=True)
    return n_true - len(wrong), n_refused, wrong


# --- migration ------------------------------------------------------------------------------------

GOLDEN = HERE.parent / "golden"


def old_project(folder, name="format_1"):
    """A copy of a project that the first format of files holds; tests/golden tells how it was made."""
    for suffix in ("", "-wal"):
        if (GOLDEN / f"{name}.swproj{suffix}").exists():
            shutil.copy(GOLDEN / f"{name}.swproj{suffix}", folder / f"room.swproj{suffix}")
    return folder / "room.swproj"


def bring_up_to_date(path, n, tell):
    """Migrate and tell the steps of SQLite's machine; die at the n-th."""
    steps = [0]

    def count():
        steps[0] += 1
        if steps[0] == n:
            os.kill(os.getpid(), DEADLY)
        return 0

    class Counting(sqlite3.Connection):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            super().set_progress_handler(count, 1)

        def set_progress_handler(self, handler, n):
            pass

    project = read_project(path)
    store._open.__globals__["sqlite3"] = SqliteWith(Counting)
    store.ProjectFile.take(path, project).close()
    tell.send(steps[0])


def migrate(path, n=0, after=None):
    """Bring a project up to date in another process, which dies at its n-th step or after some seconds.

    Returns
    -------
    steps : int
        Of SQLite's machine, if it came to its end; else 0.
    """
    process = Mortal(bring_up_to_date, path, n)
    if after is not None:
        time.sleep(after)
        process.stop()
    told, _ = process.end()
    return told[0] if told else 0


class SqliteWith:
    """The module sqlite3 with another class of connections."""

    def __init__(self, factory):
        self._factory = factory

    def __getattr__(self, name):
        return getattr(sqlite3, name)

    def connect(self, *arguments, **options):
        return sqlite3.connect(*arguments, factory=self._factory, **options)


def try_migration_kills(folder, n, *, seed=0):
    """Kill a migration at n points, all over its steps and at random instants.

    Returns
    -------
    not_yet, done : int
        How often the file was as before and how often it was brought up to date; each time it held all.
    """
    rng = np.random.default_rng(seed)
    folder = Path(folder)
    names = ("format_1", "format_1_killed")
    steps = {name: migrate(old_project(folder, name)) for name in names}
    begin = time.perf_counter()
    migrate(old_project(folder))
    seconds = time.perf_counter() - begin
    n_done = 0
    for k in range(n):
        path = folder / "room.swproj"
        for suffix in (*SUFFIXES, ".lock"):
            Path(f"{path}{suffix}").unlink(missing_ok=True)
        path = old_project(folder, names[k % 2])
        if k % 4 < 2:
            migrate(path, 1 + (k // 4) * 4 * steps[names[k % 2]] // n)
        else:
            migrate(path, after=float(rng.uniform(0, seconds)))
        with contextlib.closing(sqlite3.connect(path)) as connection:
            n_done += connection.execute("PRAGMA user_version").fetchone()[0] == VERSION
        with Session.open(path) as session:
            edits, undone = session.edits, session.undone
        assert edits == [Relabel(0, "chair"), Merge((0, 40), 70), Cut(0, 70)]
        assert list(undone) == [Split(100, "base")]
    return n - n_done, n_done
