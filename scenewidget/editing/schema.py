"""The tables of a project file: how a project becomes rows, and how rows are trusted again.

Every row carries a checksum, those of the log are chained. Arrays are compressed; their declared sizes are
checked against the bytes that are there before memory is taken. Everything else is JSON.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import sqlite3
import warnings
import zlib
from collections.abc import Iterable, Mapping
from typing import Any, get_args

import numpy as np
import numpy.typing as npt

from scenewidget.editing.edits import edit_from_dict, edit_to_dict
from scenewidget.editing.fingerprint import Fingerprint, fingerprint
from scenewidget.editing.partition import KnownCut
from scenewidget.editing.project import Action, Operation, Project, ProjectError, read_log
from scenewidget.editing.vocabulary import checked_vocabulary
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import LEVELS

__all__ = [
    "APPLICATION_ID",
    "MIGRATIONS",
    "VERSION",
    "insert_operations",
    "load_project",
    "read_summary",
    "write_project",
    "write_segmentation",
]

APPLICATION_ID = 0x5357504A  # "SWPJ"
SCHEMA = (
    "CREATE TABLE fact (key TEXT PRIMARY KEY, value TEXT NOT NULL, digest BLOB NOT NULL) WITHOUT ROWID",
    "CREATE TABLE array (name TEXT PRIMARY KEY, dtype TEXT NOT NULL, shape TEXT NOT NULL,"
    " data BLOB NOT NULL, digest BLOB NOT NULL)",
    "CREATE TABLE operation (seq INTEGER PRIMARY KEY, time REAL NOT NULL, action TEXT NOT NULL,"
    " body TEXT NOT NULL, extra BLOB, digest BLOB NOT NULL)",
)
MIGRATIONS: tuple[tuple[str, ...], ...] = ()  # statements that lead from schema version k + 1 to k + 2
VERSION = 1 + len(MIGRATIONS)
LARGEST_RATIO = 1_100  # of zlib is 1032
DTYPES = {"<i4": np.int32, "<f4": np.float32, "<f8": np.float64, "|u1": np.uint8}


def write_project(connection: sqlite3.Connection, project: Project) -> None:
    """Fill an empty database."""
    connection.execute(f"PRAGMA application_id={APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version={VERSION}")
    connection.execute("BEGIN")
    for statement in SCHEMA:
        connection.execute(statement)
    write_segmentation(connection, project)
    _put_fact(connection, "fingerprint", project.fingerprint.to_dict())
    _put_fact(connection, "source", project.source)
    if project.mesh is not None:
        _put_array(connection, "mesh/vertices", project.mesh.vertices)
        _put_array(connection, "mesh/faces", project.mesh.faces)
        if project.mesh.vertex_colors is not None:
            _put_array(connection, "mesh/vertex_colors", project.mesh.vertex_colors)
    insert_operations(connection, project.operations)
    connection.execute("COMMIT")


def insert_operations(connection: sqlite3.Connection, operations: Iterable[Operation]) -> None:
    """Add operations at the end of the log, within the caller's transaction."""
    last = connection.execute("SELECT seq, digest FROM operation ORDER BY seq DESC LIMIT 1").fetchone()
    first, digest = (0, b"") if last is None else (int(last[0]) + 1, bytes(last[1]))
    rows = []
    for seq, operation in enumerate(operations, first):
        body, extra = _encode(operation)
        digest = _digest(digest, seq, repr(operation.time), operation.action, body, extra or b"")
        rows.append((seq, operation.time, operation.action, body, extra, digest))
    connection.executemany("INSERT INTO operation VALUES (?, ?, ?, ?, ?, ?)", rows)


def write_segmentation(connection: sqlite3.Connection, project: Project) -> None:
    """Write the automatic segmentation over the one that is there, within the caller's transaction."""
    connection.execute(
        "DELETE FROM array WHERE name IN ('labels', 'confidence', 'keys') OR name LIKE 'level/%'"
    )
    _put_array(connection, "labels", project.labels)
    _put_array(connection, "confidence", project.confidence)
    for level, parts in project.levels.items():
        _put_array(connection, f"level/{level}", parts)
    if project.keys is not None:
        _put_array(connection, "keys", project.keys)
    _put_fact(connection, "names", list(project.names))
    _put_fact(connection, "timings", _plain(project.timings))
    _put_fact(connection, "report", _plain(project.report))
    _put_fact(connection, "params", None if project.params is None else dataclasses.asdict(project.params))


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """The entries that JSON can hold."""
    out = {}
    for key, value in values.items():
        plain = value.item() if isinstance(value, np.generic) else value
        if isinstance(plain, (str, bool, int)) or (isinstance(plain, float) and math.isfinite(plain)):
            out[str(key)] = plain
    return out


def _put_fact(connection: sqlite3.Connection, key: str, value: Any) -> None:
    text = json.dumps(value, separators=(",", ":"))
    connection.execute("INSERT OR REPLACE INTO fact VALUES (?, ?, ?)", (key, text, _digest(b"", key, text)))


def _put_array(connection: sqlite3.Connection, name: str, array: npt.NDArray[Any]) -> None:
    array = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    data = zlib.compress(array.tobytes(), 6)
    row = (name, array.dtype.str, json.dumps(array.shape), data)
    connection.execute("INSERT OR REPLACE INTO array VALUES (?, ?, ?, ?, ?)", (*row, _digest(b"", *row)))


def _digest(before: bytes, *values: Any) -> bytes:
    digest = hashlib.blake2b(before, digest_size=8)
    for value in values:
        data = value if isinstance(value, bytes) else str(value).encode("utf-8", "surrogatepass")
        digest.update(len(data).to_bytes(8, "little"))
        digest.update(data)
    return digest.digest()


def _encode(operation: Operation) -> tuple[str, bytes | None]:
    body: Any = None
    if operation.edit is not None:
        body = edit_to_dict(operation.edit)
    elif operation.action == "vocabulary":
        body = list(operation.names)
    extra = None
    if operation.cut is not None:
        is_b = operation.cut.is_b
        header = len(is_b).to_bytes(4, "little") + operation.cut.segment_digest
        extra = header + zlib.compress(np.packbits(is_b).tobytes(), 6)
    return json.dumps(body, separators=(",", ":")), extra


def _decode(row: tuple[Any, ...]) -> Operation:
    _, when, action, body, extra, _ = row
    if action not in get_args(Action) or not isinstance(when, float) or not math.isfinite(when):
        raise ProjectError(f"the log holds an unknown operation {action!r:.60}")
    data = json.loads(body)
    if action == "vocabulary":
        return Operation(when, action, names=checked_vocabulary(data))
    if action != "edit":
        return Operation(when, action)
    edit = edit_from_dict(data)
    if extra is None:
        return Operation(when, action, edit)
    n = int.from_bytes(extra[:4], "little")
    bits = np.frombuffer(_inflate(extra[20:], (n + 7) // 8), np.uint8)
    return Operation(when, action, edit, KnownCut(extra[4:20], np.unpackbits(bits, count=n).astype(bool)))


def _inflate(data: bytes, n_bytes: int) -> bytes:
    """Exactly so many bytes out of zlib's; never more memory than the data can fill."""
    if n_bytes > LARGEST_RATIO * len(data) + 64:
        raise ProjectError(f"{len(data)} bytes can't hold the {n_bytes} that are declared")
    inflater = zlib.decompressobj()
    out = inflater.decompress(data, n_bytes + 1)
    if len(out) != n_bytes or not inflater.eof:
        raise ProjectError(f"an array has not the {n_bytes} bytes that are declared")
    return out


def load_project(connection: sqlite3.Connection, name: str, *, recover: bool) -> Project:
    """Everything in a database; ``name`` is that of its file, for messages.

    Raises
    ------
    ProjectError, sqlite3.Error, ValueError, TypeError, KeyError, …
        Something is damaged. With ``recover`` the log may be: what comes before the damage counts.
    """
    facts = {}
    for key, value, digest in connection.execute("SELECT key, value, digest FROM fact"):
        if digest != _digest(b"", key, value):
            raise ProjectError(f"its entry {key!r:.60} was changed")
        facts[key] = json.loads(value)
    found = Fingerprint.from_dict(facts["fingerprint"])
    arrays = {}
    columns = ("labels", "confidence", *(f"level/{level}" for level in LEVELS))
    for row in connection.execute("SELECT name, dtype, shape, data, digest FROM array"):
        array_name, dtype, shape_text, data, digest = row
        if digest != _digest(b"", *row[:4]):
            raise ProjectError(f"its array {array_name!r:.60} was changed")
        shape = json.loads(shape_text)
        expected = [found.n_faces] if array_name in columns else [None, None if array_name == "keys" else 3]
        if dtype not in DTYPES or len(shape) != len(expected):
            raise ProjectError(f"its array {array_name!r:.60} has an unknown form")
        for size, wanted in zip(shape, expected, strict=True):
            if type(size) is not int or not 0 <= size < 2**31 or (wanted is not None and size != wanted):
                raise ProjectError(f"its array {array_name!r:.60} has the shape {shape!r:.60}")
        n_bytes = math.prod(shape) * np.dtype(dtype).itemsize
        arrays[array_name] = (
            np.frombuffer(_inflate(data, n_bytes), dtype).reshape(shape).astype(DTYPES[dtype])
        )
    mesh = None
    if "mesh/faces" in arrays:
        mesh = Mesh(arrays["mesh/vertices"], arrays["mesh/faces"], arrays.get("mesh/vertex_colors"))
        if fingerprint(mesh) != found:
            raise ProjectError("its mesh is not the one of its fingerprint")
    operations, n_lost = _load_operations(connection, name, recover=recover)
    return Project(
        fingerprint=found,
        labels=arrays["labels"],
        confidence=arrays["confidence"],
        levels={level: arrays[f"level/{level}"] for level in LEVELS if f"level/{level}" in arrays},
        names=tuple(str(text) for text in facts["names"]),
        keys=arrays.get("keys"),
        timings=dict(facts["timings"]),
        report=dict(facts["report"]),
        params=_load_params(facts["params"], name),
        mesh=mesh,
        source=str(facts["source"]),
        operations=tuple(operations),
        n_lost=n_lost,
    )


def read_summary(connection: sqlite3.Connection) -> tuple[Fingerprint, int, float]:
    """The mesh's fingerprint, how many edits are done, and when the last one was made, undone or redone."""
    row = connection.execute("SELECT value, digest FROM fact WHERE key = 'fingerprint'").fetchone()
    if row is None or row[1] != _digest(b"", "fingerprint", row[0]):
        raise ProjectError("its entry 'fingerprint' was changed")
    n_steps, last_time = connection.execute(
        "SELECT SUM(CASE action WHEN 'undo' THEN -1 ELSE 1 END), MAX(time) FROM operation"
        " WHERE action IN ('edit', 'undo', 'redo')"
    ).fetchone()
    return Fingerprint.from_dict(json.loads(row[0])), int(n_steps or 0), float(last_time or 0.0)


def _load_operations(
    connection: sqlite3.Connection, name: str, *, recover: bool
) -> tuple[list[Operation], int]:
    operations: list[Operation] = []
    total = connection.execute("SELECT COUNT(*) FROM operation").fetchone()[0]
    before = b""
    try:
        for seq, row in enumerate(connection.execute("SELECT * FROM operation ORDER BY seq")):
            digest = _digest(before, row[0], repr(row[1]), row[2], row[3], row[4] or b"")
            if row[0] != seq or row[5] != digest:
                raise ProjectError(f"entry {seq} of its log was changed")
            operations.append(_decode(row))
            read_log(operations[-1:]) if operations[-1].action == "edit" else None
            before = digest
        read_log(operations)
    except (
        ProjectError,
        sqlite3.Error,
        ValueError,
        TypeError,
        OverflowError,
        RecursionError,
        zlib.error,
    ) as error:
        if not recover:
            raise ProjectError(
                f"{name!r} is damaged: {error}. Session.open(…, recover=True) keeps the "
                f"{len(operations)} of {total} operations before it"
            ) from error
        while True:  # an undo too many ends the log as well
            try:
                read_log(operations)
                break
            except ProjectError:
                operations.pop()
    return operations, total - len(operations)


def _load_params(data: Any, name: str) -> Params | None:
    if data is None:
        return None
    try:
        return Params(**data)
    except (TypeError, ValueError) as error:
        warnings.warn(
            f"the parameters in {name!r} are of another version and left out ({error})", stacklevel=6
        )
        return None
