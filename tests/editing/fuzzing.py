"""Damage to files, and what a reader may do about it: read them or refuse them, nothing else."""

from __future__ import annotations

import contextlib
import shutil
import sqlite3
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import shapes

import scenewidget as sw
from scenewidget.editing.formats import FormatError
from scenewidget.editing.project import ProjectError
from scenewidget.editing.project_reader import summary_of
from scenewidget.editing.session import Session
from scenewidget.engine.segmentation import Segmentation

MESH = shapes.box(3)
FILES = {  # reader -> (file that is damaged, file that is opened)
    "ply": ("a.ply", "a.ply"),
    "vertex.ply": ("v.ply", "v.ply"),
    "ascii.ply": ("t.ply", "t.ply"),
    "npz": ("a.npz", "a.npz"),
    "glb": ("a.glb", "a.glb"),
    "npy": ("a.npy", "a.npy"),
    "txt": ("a.txt", "a.txt"),
    "aggregation.json": ("s.aggregation.json", "s.aggregation.json"),
    "segs.json": ("s.segs.json", "s.aggregation.json"),
    "xml": ("n.xml", "n.xml"),
    "scene.ply": ("n.ply", "n.xml"),
    "swproj": ("p.swproj", "p.swproj"),
    "wal": ("k.swproj-wal", "k.swproj"),
    "pages": ("p.swproj", "p.swproj"),
    "schema": ("p.swproj", "p.swproj"),
}
PROJECTS = ("swproj", "wal", "pages", "schema")
READERS = tuple(FILES)
NUMBERS = [
    b"0",
    b"-1",
    b"1e999",
    b"99999999999999999999",
    b"null",
    b"[]",
    b"{}",
    b'""',
    b"true",
    b"NaN",
    b"-0.0",
]


def segmentation():
    """Six sides of a box, named, a few faces unlabeled."""
    labels = np.arange(MESH.n_faces) // 18
    labels[:3] = -1
    seg = Segmentation.from_labels(MESH, labels, names=["floor", "wall", "", "chair 1", "Tür", "<b>"])
    levels = {"base": np.arange(MESH.n_faces, dtype=np.int32) // 6}
    return Segmentation(MESH, seg.labels, levels=levels, names=seg.names)


def write_all(folder):
    """A sound file for each reader."""
    folder, seg = Path(folder), segmentation()
    for name in ("a.ply", "a.npz", "a.glb", "a.npy", "a.txt", "s.aggregation.json", "n.xml"):
        sw.export(seg, MESH, folder / name)
    sw.export(seg, MESH, folder / "v.ply", per="vertex")
    rows = [f"{x} {y} {z} {k % 5}" for k, (x, y, z) in enumerate(MESH.vertices.tolist())]
    rows += [f"3 {a} {b} {c}" for a, b, c in MESH.faces.tolist()]
    header = f"ply\nformat ascii 1.0\nelement vertex {MESH.n_vertices}\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz") + "property int label\n"
    header += f"element face {MESH.n_faces}\nproperty list uchar int vertex_indices\nend_header\n"
    (folder / "t.ply").write_text(header + "\n".join(rows) + "\n")
    session = Session(MESH, seg, params=sw.Params())
    session.save(folder / "p.swproj")
    edit(session)
    session.close()
    session = Session(MESH, seg)
    session.save(folder / "w.swproj")
    edit(session)
    for suffix in ("", "-wal"):  # as a killed process leaves them
        shutil.copy(folder / f"w.swproj{suffix}", folder / f"k.swproj{suffix}")
    session.close()


def edit(session):
    session.merge(40, 60)
    session.relabel(60, "sofa")
    session.cut(40, 60)
    session.split(20, "base")
    session.undo()
    session.vocabulary = ["one", "two"]


def damaged(data, rng):
    """The bytes with a few bits, numbers or pieces wrong."""
    out = bytearray(data)
    for _ in range(int(rng.choice([1, 1, 1, 2, 5, 40]))):
        if not out:
            break
        at = int(rng.integers(len(out) if rng.random() < 0.6 else min(len(out), 600)))
        kind = rng.integers(8)
        if kind <= 2:
            out[at] ^= 1 << int(rng.integers(8))
        elif kind == 3:
            out[at : at + 4] = int(rng.choice([0, 1, 2**31 - 1, 2**31, 2**32 - 1, 255])).to_bytes(4, "little")
        elif kind == 4:
            stop = len(out) if rng.random() < 0.3 else at + int(rng.integers(1, 60))
            del out[at:stop]
        elif kind == 5:
            out[at:at] = rng.integers(0, 256, int(rng.integers(1, 20)), dtype=np.uint8).tobytes()
        elif kind == 6:  # another number, or another value of JSON
            end = at
            while end < len(out) and chr(out[end]) in "0123456789.-e":
                end += 1
            out[at:end] = NUMBERS[int(rng.integers(len(NUMBERS)))]
        else:
            other = int(rng.integers(len(out)))
            piece = out[other : other + int(rng.integers(1, 60))]
            out[at : at + len(piece)] = piece
    return bytes(out)


def with_other_pages(data, rng):
    """A database with pages exchanged, repeated, emptied, or with other pointers in them."""
    size = 4096
    pages = np.frombuffer(data, np.uint8).reshape(-1, size).copy()
    for _ in range(int(rng.choice([1, 1, 2, 5]))):
        a, b = (int(x) for x in rng.integers(0, len(pages), 2))
        kind = rng.integers(5)
        if kind == 0:
            pages[[a, b]] = pages[[b, a]]
        elif kind == 1:
            pages[a] = pages[b]
        elif kind == 2:
            pages[a] = rng.integers(0, 256, size) if rng.random() < 0.5 else 0
        elif kind == 3:  # a page that it leads to, or the number of its cells
            at = int(rng.choice([1, 3, 5, 8, 12, *range(size - 12, size)])) + 100 * (a == 0)
            pages[a, min(at, size - 4) : at + 4] = list(
                int(rng.integers(0, len(pages) + 2)).to_bytes(4, "big")
            )
        else:
            pages = np.concatenate([pages[:b], pages[a:]]) if a != b else pages[: a + 1]
    return pages.tobytes()


SQL = (
    "CREATE VIEW {t} AS {endless}",
    "CREATE TABLE {t} (a, b AS (hex(zeroblob(100000000))))",
    "CREATE TABLE {t} (a CHECK (length(randomblob(100000000)) > 0), b)",
    "CREATE TRIGGER g AFTER INSERT ON {t} BEGIN DELETE FROM {t}; END",
    "CREATE INDEX g ON {t} (length(zeroblob(100000000)))",
    "CREATE VIRTUAL TABLE {t} USING fts5(x)",
    "CREATE VIRTUAL TABLE {t} USING rtree(a, b, c)",
    "CREATE TABLE {t} (" + ", ".join(f"c{k}" for k in range(1500)) + ")",
    "CREATE VIEW {t} AS SELECT " + "(" * 300 + "1" + ")" * 300,
    "CREATE TABLE {t} (key TEXT PRIMARY KEY, value, digest)",
    "",
    "SELECT 1",
    "CREATE TABLE",
    "x" * 100_000,
)
ENDLESS = "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n) SELECT k AS key, k AS value FROM n"


def with_other_schema(data, rng):
    """A database whose tables are something else by name."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "f.db"
        path.write_bytes(data)
        with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.execute("PRAGMA journal_mode=DELETE")
            connection.execute("PRAGMA writable_schema=ON")
            table = str(rng.choice(["fact", "array", "operation", "root", "other"]))
            sql = SQL[int(rng.integers(len(SQL)))].format(t=table, endless=ENDLESS)
            kind = rng.integers(5)
            if kind == 0:
                change = ("UPDATE sqlite_master SET sql = ? WHERE name = ?", (sql, table))
            elif kind == 1:
                change = ("INSERT INTO sqlite_master VALUES (?, ?, ?, ?, ?)",
                          (str(rng.choice(["table", "view", "index", "trigger", "x"])), table, table,
                           int(rng.integers(0, 20)), sql))  # fmt: skip
            elif kind == 2:
                change = (
                    "UPDATE sqlite_master SET rootpage = ? WHERE name = ?",
                    (int(rng.integers(0, 9)), table),
                )
            elif kind == 3:
                change = (
                    "UPDATE sqlite_master SET type = 'view', rootpage = 0, sql = ? WHERE name = ?",
                    (sql, table),
                )
            else:
                change = (
                    f"UPDATE sqlite_master SET name = ?, tbl_name = 'fact' WHERE name = '{table}'",
                    (sql[:50],),
                )
            connection.execute(*change)
            for pragma in ("user_version", "application_id", "schema_version"):
                if rng.random() < 0.05:
                    connection.execute(f"PRAGMA {pragma}={int(rng.integers(-3, 9))}")
        return path.read_bytes()


DAMAGES = {"pages": with_other_pages, "schema": with_other_schema}


class Fuzzer:
    """Sound files, and a way to open each with damage."""

    def __init__(self, folder):
        write_all(folder)
        self.files = {reader: tuple(Path(folder) / name for name in names) for reader, names in FILES.items()}
        self.sound = {reader: path.read_bytes() for reader, (path, _) in self.files.items()}
        with Session.open(self.files["swproj"][1], MESH) as session:
            self.project = session.segmentation
        self.states = self._states()

    def _states(self):
        """Label bytes of all states that the log of the project has seen: a torn log ends in one of them."""
        session = Session(MESH, segmentation())
        seen = {session.segmentation.labels.tobytes()}
        session.observe(lambda _: seen.add(session.segmentation.labels.tobytes()))
        edit(session)
        return seen

    def attack(self, reader, seed):
        """Open a damaged file; whether it was refused. Anything but reading and refusing is an error."""
        path, opened = self.files[reader]
        path.write_bytes(DAMAGES.get(reader, damaged)(self.sound[reader], np.random.default_rng(seed)))
        begin = time.thread_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                if reader in PROJECTS:
                    return self._open(opened)
                found = sw.import_labels(MESH, opened)
                assert found.labels.shape == (MESH.n_faces,)
                return False
        except (FormatError, ProjectError) as error:
            message = str(error)
        finally:
            assert time.thread_time() - begin < 1, f"{reader} with seed {seed} takes long"
            path.write_bytes(self.sound[reader])
        assert len(message) < 1_000, "a message that nobody reads"
        return True

    def _open(self, opened):
        keep = opened.read_bytes()
        try:
            with contextlib.suppress(ProjectError):  # what a widget reads before it offers a file
                summary_of(opened)
            with Session.open(opened, MESH) as session:
                labels = session.segmentation.labels.tobytes()
            assert labels in self.states, "damage went unnoticed"
            return False
        finally:
            for suffix in ("-wal", "-shm", ".lock"):
                opened.with_name(opened.name + suffix).unlink(missing_ok=True)
            opened.write_bytes(keep)
