"""The tables of a project file: how a project becomes rows, and how rows are trusted again.

Every row carries a checksum, those of the log are chained, and one row, the root, binds it all: it says how
long the log is, how its chain ends, and which facts and arrays lie beside it. Each transaction writes it
anew, so pages of two states never pass for a third. Arrays are compressed; their declared sizes are checked
against the bytes that are there before memory is taken. Everything else is JSON.
"""

from __future__ import annotations

import base64
import contextlib
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

from scenewidget.editing.edits import Merge, Split, edit_from_dict, edit_values
from scenewidget.editing.fingerprint import Fingerprint, fingerprint
from scenewidget.editing.partition import KnownCut
from scenewidget.editing.project import Action, Operation, Project, ProjectError, Root, read_log
from scenewidget.editing.vocabulary import checked_vocabulary
from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import LEVELS

__all__ = [
    "APPLICATION_ID",
    "DAMAGE",
    "VERSION",
    "check_tables",
    "insert_operations",
    "load_project",
    "migrate",
    "read_root",
    "read_summary",
    "replace_segmentation",
    "write_project",
]

APPLICATION_ID = 0x5357504A  # "SWPJ"
SCHEMA = (
    "CREATE TABLE fact (key TEXT PRIMARY KEY, value TEXT NOT NULL, digest BLOB NOT NULL) WITHOUT ROWID",
    "CREATE TABLE array (name TEXT PRIMARY KEY, dtype TEXT NOT NULL, shape TEXT NOT NULL,"
    " data BLOB NOT NULL, digest BLOB NOT NULL)",
    "CREATE TABLE operation (seq INTEGER PRIMARY KEY, time REAL NOT NULL, action TEXT NOT NULL,"
    " body TEXT NOT NULL, extra BLOB, digest BLOB NOT NULL)",
    "CREATE TABLE root (id INTEGER PRIMARY KEY, n_operations INTEGER NOT NULL, log BLOB NOT NULL,"
    " content BLOB NOT NULL)",
)
VERSION = 2
ROOT_SINCE = 2  # the version that brought the root
LARGEST_RATIO = 1_100  # of zlib is 1032
MOST_OPERATIONS = 2_000_000  # of a log; a person makes some thousands in a day
LONG_LIST = 100  # whole numbers that are packed in JSON
DAMAGE = (  # what reading damaged rows can raise
    ProjectError,
    sqlite3.Error,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    RecursionError,
    MemoryError,
    zlib.error,
)
DTYPES = {"<i4": np.int32, "<f4": np.float32, "<f8": np.float64, "|u1": np.uint8}


def write_project(connection: sqlite3.Connection, project: Project) -> None:
    """Fill an empty database."""
    connection.execute(f"PRAGMA application_id={APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version={VERSION}")
    connection.execute("BEGIN")
    for statement in SCHEMA:
        connection.execute(statement)
    _put_segmentation(connection, project)
    _put_fact(connection, "fingerprint", project.fingerprint.to_dict())
    _put_fact(connection, "source", project.source)
    if project.mesh is not None:
        _put_array(connection, "mesh/vertices", project.mesh.vertices)
        _put_array(connection, "mesh/faces", project.mesh.faces)
        if project.mesh.vertex_colors is not None:
            _put_array(connection, "mesh/vertex_colors", project.mesh.vertex_colors)
        if isinstance(project.mesh, PointCloud) and project.mesh.has_sides:  # others are found again
            _put_array(connection, "mesh/normals", project.mesh.face_normals.astype(np.float32))
    _put_root(connection, Root(0, b"", _content_of(connection)))
    insert_operations(connection, project.operations)
    connection.execute("COMMIT")


def insert_operations(connection: sqlite3.Connection, operations: Iterable[Operation]) -> Root:
    """Add operations at the end of the log, within the caller's transaction; the root after that."""
    root = read_root(connection)
    first, digest = root.n_operations, root.log
    rows = []
    for seq, operation in enumerate(operations, first):
        body, extra = _encode(operation)
        digest = _digest(digest, seq, repr(operation.time), operation.action, body, extra or b"")
        rows.append((seq, operation.time, operation.action, body, extra, digest))
    connection.executemany("INSERT INTO operation VALUES (?, ?, ?, ?, ?, ?)", rows)
    root = Root(first + len(rows), digest, root.content)
    _put_root(connection, root)
    return root


def read_root(connection: sqlite3.Connection) -> Root:
    """The root of a database of the present version."""
    rows = connection.execute("SELECT id, n_operations, log, content FROM root LIMIT 2").fetchall()
    if len(rows) != 1 or [type(value) for value in rows[0]] != [int, int, bytes, bytes]:
        raise ProjectError("it has no root")
    return Root(*rows[0][1:])


def _put_root(connection: sqlite3.Connection, root: Root) -> None:
    row = (1, root.n_operations, root.log, root.content)
    connection.execute("INSERT OR REPLACE INTO root VALUES (?, ?, ?, ?)", row)


def _content_of(connection: sqlite3.Connection) -> bytes:
    """What binds facts and arrays together: a digest of their digests."""
    facts = connection.execute("SELECT key, digest FROM fact").fetchall()
    arrays = connection.execute("SELECT name, digest FROM array").fetchall()
    return _content(dict(facts), dict(arrays))


def _content(facts: Mapping[str, bytes], arrays: Mapping[str, bytes]) -> bytes:
    return _digest(
        b"", *(x for rows in (facts, arrays) for row in (*sorted(rows.items()), ("", b"")) for x in row)
    )


def migrate(connection: sqlite3.Connection, root: Root) -> None:
    """Bring a database of an older version to the present one, all or nothing.

    Parameters
    ----------
    connection : Connection
        Outside of any transaction.
    root : Root
        Of what was read and checked there; if it is no longer so, nothing changes.

    Raises
    ------
    ProjectError
        Somebody has changed the database since.
    """
    connection.execute("BEGIN IMMEDIATE")
    try:
        version = connection.execute("PRAGMA user_version").fetchone()[0]
        if version < ROOT_SINCE:
            last = connection.execute(
                "SELECT seq, digest FROM operation ORDER BY seq DESC LIMIT 1"
            ).fetchone()
            n, log = (0, b"") if last is None else (int(last[0]) + 1, bytes(last[1]))
            if Root(n, log, _content_of(connection)) != root:
                raise ProjectError("it has changed since it was read")
            connection.execute(SCHEMA[3])
            _put_root(connection, root)
            connection.execute(f"PRAGMA user_version={VERSION}")
        connection.execute("COMMIT")
    except BaseException:
        with contextlib.suppress(sqlite3.Error):
            connection.execute("ROLLBACK")
        raise


def check_tables(connection: sqlite3.Connection) -> int:
    """The version of a database that has exactly our tables, word by word: nothing in it is ours to run.

    Raises
    ------
    ProjectError
        No project, of a newer version, or with other tables, views, triggers, …
    """
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise ProjectError("it is no project file of scenewidget")
    version = int(connection.execute("PRAGMA user_version").fetchone()[0])
    if version > VERSION:
        raise ProjectError(
            f"it was written by a newer scenewidget (format {version}, this one reads up to {VERSION}); "
            "update scenewidget"
        )
    if version < 1:
        raise ProjectError(f"it is damaged: it has the format {version}")
    wanted: set[tuple[str, str, str | None]]
    wanted = {("table", sql.split(maxsplit=3)[2], sql) for sql in SCHEMA[: 3 if version < ROOT_SINCE else 4]}
    wanted.add(("index", "sqlite_autoindex_array_1", None))
    query = "SELECT type, name, sql FROM sqlite_master LIMIT 20"
    found = set(connection.execute(query).fetchall())
    if found != wanted:
        kind, name, _ = min(found ^ wanted, key=str)
        raise ProjectError(f"it is damaged or forged: it holds {f'{kind} {name}'!r:.80}")
    return version


def _put_segmentation(connection: sqlite3.Connection, project: Project) -> None:
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
    _put_fact(connection, "groups", list(project.groups))
    _put_fact(connection, "timings", _plain(project.timings))
    _put_fact(connection, "report", _plain(project.report))
    _put_fact(connection, "params", None if project.params is None else dataclasses.asdict(project.params))


def replace_segmentation(connection: sqlite3.Connection, project: Project) -> None:
    """Put another automatic segmentation into a project, within the caller's transaction."""
    _put_segmentation(connection, project)
    root = read_root(connection)
    _put_root(connection, Root(root.n_operations, root.log, _content_of(connection)))


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """The entries that JSON can hold: words, numbers, and lists and tables of these."""
    return {str(key): plain for key, value in values.items() if (plain := _plain_value(value)) is not None}


def _plain_value(value: Any) -> Any:
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, Mapping):
        return _plain(plain)
    if isinstance(plain, (list, tuple)):
        return [_plain_value(one) for one in plain]
    is_number = isinstance(plain, (bool, int)) or (isinstance(plain, float) and math.isfinite(plain))
    return plain if is_number or isinstance(plain, str) else None


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
        body = {key: _packed(value) for key, value in edit_values(operation.edit).items()}
        if operation.action != "edit":
            body = {"edit": body, "p": operation.p, "gain": operation.gain}
    elif operation.action == "vocabulary":
        body = list(operation.names)
    extra = None
    if operation.cut is not None:
        is_b = operation.cut.is_b
        header = len(is_b).to_bytes(4, "little") + operation.cut.segment_digest
        extra = header + zlib.compress(np.packbits(is_b).tobytes(), 6)
    return json.dumps(body, separators=(",", ":")), extra


def _packed(value: Any) -> Any:
    """A long list of faces as compressed differences: a brush stroke has a hundred thousand of them."""
    if isinstance(value, np.ndarray) and len(value) < LONG_LIST:
        return value.tolist()
    if not isinstance(value, (list, np.ndarray)) or len(value) < LONG_LIST:
        return value
    steps = np.diff(np.array(value, np.int64), prepend=0).astype("<i4")
    return {"n": len(value), "packed": base64.b64encode(zlib.compress(steps.tobytes(), 1)).decode("ascii")}


def _unpacked(data: dict[str, Any]) -> Any:
    """What `_packed` has packed; every other object of JSON as it is."""
    if data.keys() != {"n", "packed"}:
        return data
    if type(data["n"]) is not int or not 0 <= data["n"] < 2**31:
        raise ProjectError("a list of faces has no length")
    steps = np.frombuffer(_inflate(base64.b64decode(data["packed"]), 4 * data["n"]), "<i4")
    return np.cumsum(steps, dtype=np.int64).tolist()


def _decode(row: tuple[Any, ...]) -> Operation:
    _, when, action, body, extra, _ = row
    if action not in get_args(Action) or not isinstance(when, float) or not math.isfinite(when):
        raise ProjectError(f"the log holds an unknown operation {action!r:.60}")
    data = json.loads(body, object_hook=_unpacked)
    if action == "vocabulary":
        return Operation(when, action, names=checked_vocabulary(data))
    if action in ("propose", "dismiss"):
        p, gain = (float(data[key]) for key in ("p", "gain"))
        if not (math.isfinite(p) and math.isfinite(gain)):
            raise ProjectError("the log holds a proposal without a probability")
        edit = edit_from_dict(data["edit"])
        if not isinstance(edit, (Merge, Split)):
            raise ProjectError("the log holds a proposal that is none")
        return Operation(when, action, edit, p=p, gain=gain)
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


def load_project(connection: sqlite3.Connection, version: int, *, recover: bool) -> Project:
    """Everything in a database whose tables are as they should be.

    Raises
    ------
    ProjectError, sqlite3.Error, ValueError, TypeError, KeyError, …
        Something is damaged. With ``recover`` the log may be: what comes before the damage counts.
    """
    facts, fact_digests = _load_facts(connection)
    found = Fingerprint.from_dict(facts["fingerprint"])
    rows, array_digests = {}, {}
    for row in connection.execute("SELECT name, dtype, shape, data, digest FROM array"):
        if row[4] != _digest(b"", *row[:4]):
            raise ProjectError(f"its array {row[0]!r:.60} was changed")
        rows[row[0]], array_digests[row[0]] = row[1:4], row[4]
    operations, chain, total = _load_operations(connection, recover=recover)
    root = Root(len(operations), chain[-1], _content(fact_digests, array_digests))
    n_lost = total - len(operations)
    if version >= ROOT_SINCE:
        n_lost += _missing(read_root(connection), root, recover=recover)
    arrays = {name: _array(name, row, found) for name, row in rows.items()}
    mesh: Mesh | None = None
    if "mesh/faces" in arrays:
        places, faces = arrays["mesh/vertices"], arrays["mesh/faces"]
        if len(places) == len(faces) and (faces == np.arange(len(faces))[:, None]).all():  # of a cloud
            mesh = PointCloud(places, arrays.get("mesh/normals"), arrays.get("mesh/vertex_colors"))
        else:
            mesh = Mesh(places, faces, arrays.get("mesh/vertex_colors"))
        if fingerprint(mesh) != found:
            raise ProjectError("its mesh is not the one of its fingerprint")
    return Project(
        fingerprint=found,
        labels=arrays["labels"],
        confidence=arrays["confidence"],
        levels={level: arrays[f"level/{level}"] for level in LEVELS if f"level/{level}" in arrays},
        names=tuple(str(text) for text in facts["names"]),
        groups=tuple(facts.get("groups", ())),  # files from before there were any have none
        keys=arrays.get("keys"),
        timings=dict(facts["timings"]),
        report=dict(facts["report"]),
        params=_load_params(facts["params"]),
        mesh=mesh,
        source=str(facts["source"]),
        operations=tuple(operations),
        n_lost=n_lost,
        root=root,
        chain=tuple(chain),
    )


def _load_facts(connection: sqlite3.Connection) -> tuple[dict[str, Any], dict[str, bytes]]:
    facts, digests = {}, {}
    for key, value, digest in connection.execute("SELECT key, value, digest FROM fact"):
        if digest != _digest(b"", key, value):
            raise ProjectError(f"its entry {key!r:.60} was changed")
        facts[key], digests[key] = json.loads(value), digest
    return facts, digests


def _array(name: str, row: tuple[Any, ...], mesh: Fingerprint) -> npt.NDArray[Any]:
    """An array of a row; what is declared is checked before memory is taken."""
    dtype, shape_text, data = row
    expected: list[int | None] = [mesh.n_faces]
    if name == "keys":
        expected = [None, None]
    elif name.startswith("mesh/"):
        expected = [mesh.n_faces if name == "mesh/faces" else mesh.n_vertices, 3]
    shape = json.loads(shape_text)
    if dtype not in DTYPES or not isinstance(shape, list) or len(shape) != len(expected):
        raise ProjectError(f"its array {name!r:.60} has an unknown form")
    for size, wanted in zip(shape, expected, strict=True):
        if type(size) is not int or not 0 <= size < 2**31 or (wanted is not None and size != wanted):
            raise ProjectError(f"its array {name!r:.60} has the shape {shape!r:.60}")
    n_bytes = math.prod(shape) * np.dtype(dtype).itemsize
    return np.frombuffer(_inflate(data, n_bytes), dtype).reshape(shape).astype(DTYPES[dtype])


def _missing(said: Root, found: Root, *, recover: bool) -> int:
    """Operations that the root knows of and the log doesn't; 0 if both agree."""
    if said.content != found.content:
        raise ProjectError("it is damaged: its segmentation and its facts are of different states")
    if said == found:
        return 0
    if not recover:
        raise ProjectError(
            f"it is damaged: its log has {found.n_operations} operations where {said.n_operations} others "
            "belong. Session.open(…, recover=True) keeps those that are there"
        )
    return max(1, said.n_operations - found.n_operations)


def read_summary(connection: sqlite3.Connection, version: int) -> tuple[Fingerprint, int, float]:
    """The mesh's fingerprint, how many edits are done, and when the last one was made, undone or redone."""
    facts, _ = _load_facts(connection)
    operations, chain, _ = _load_operations(connection, recover=False)
    if version >= ROOT_SINCE:
        root = read_root(connection)
        if (root.n_operations, root.log) != (len(operations), chain[-1]):
            raise ProjectError("it is damaged: its log is not whole")
    steps = [operation for operation in operations if operation.action in ("edit", "undo", "redo")]
    n_done = sum(-1 if operation.action == "undo" else 1 for operation in steps)
    last_time = max((operation.time for operation in steps), default=0.0)
    return Fingerprint.from_dict(facts["fingerprint"]), n_done, last_time


def _load_operations(
    connection: sqlite3.Connection, *, recover: bool
) -> tuple[list[Operation], list[bytes], int]:
    """The operations, the chain of digests (before the first and after each), and how many rows there are."""
    operations: list[Operation] = []
    chain = [b""]
    total = int(connection.execute("SELECT COUNT(*) FROM operation").fetchone()[0])
    if total > MOST_OPERATIONS:
        raise ProjectError(f"its log has {total} operations; {MOST_OPERATIONS} are the most")
    try:
        for seq, row in enumerate(connection.execute("SELECT * FROM operation ORDER BY seq")):
            digest = _digest(chain[-1], row[0], repr(row[1]), row[2], row[3], row[4] or b"")
            if row[0] != seq or row[5] != digest:
                raise ProjectError(f"entry {seq} of its log was changed")
            operations.append(_decode(row))
            chain.append(digest)
        read_log(operations)
    except DAMAGE as error:
        if not recover:
            raise ProjectError(
                f"it is damaged: {error}. Session.open(…, recover=True) keeps the "
                f"{len(operations)} of {total} operations before it"
            ) from error
        while True:  # an undo too many ends the log as well
            try:
                read_log(operations)
                break
            except ProjectError:
                operations.pop()
    return operations, chain[: len(operations) + 1], total


def _load_params(data: Any) -> Params | None:
    if data is None:
        return None
    try:
        return Params(**data)
    except (TypeError, ValueError) as error:
        warnings.warn(
            f"the parameters in the project are of another version and left out ({error})", stacklevel=6
        )
        return None
