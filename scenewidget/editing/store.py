"""The project file, ``.swproj``: a segmentation, the log of all operations on it, and which mesh it is of.

An SQLite database in WAL mode. Each operation is a transaction that is on the disk before `append` returns;
nothing is ever deleted from the log, undo and redo are entries of it. Every row carries a checksum, those of
the log are chained, so that damage is noticed wherever it is. What is read is data only: numbers with their
declared sizes checked against the bytes that are there, and JSON.
"""

from __future__ import annotations

import contextlib
import dataclasses
import errno
import hashlib
import json
import math
import os
import sqlite3
import threading
import warnings
import weakref
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from scenewidget.editing.edits import Cut, Edit, edit_from_dict, edit_to_dict
from scenewidget.editing.files import FileLock, explain, replacing
from scenewidget.editing.fingerprint import Fingerprint, fingerprint
from scenewidget.editing.partition import KnownCut
from scenewidget.editing.vocabulary import checked_vocabulary
from scenewidget.engine.mesh import BoolArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import LEVELS, Segmentation

__all__ = ["Log", "Operation", "Project", "ProjectError", "ProjectFile", "read_log"]

Action = Literal["open", "edit", "undo", "redo", "segmentation", "vocabulary"]
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


class ProjectError(ValueError):
    """A project file that is damaged, foreign, too new, or of another mesh."""


@dataclass(frozen=True, eq=False)
class Operation:
    """An entry of the log."""

    time: float  # seconds since 1970, UTC
    action: Action
    edit: Edit | None = None  # of "edit"
    cut: KnownCut | None = None  # of a `Cut`: its outcome
    names: tuple[str, ...] = ()  # of "vocabulary"


@dataclass(frozen=True, eq=False)
class Log:
    """What a list of operations comes down to."""

    done: list[tuple[Edit, float]] = field(default_factory=list)
    undone: list[Edit] = field(default_factory=list)
    cuts: dict[tuple[Cut, bytes], BoolArray] = field(default_factory=dict)
    vocabulary: tuple[str, ...] = ()


def read_log(operations: Iterable[Operation]) -> Log:
    """The edits that are done and undone after some operations.

    Raises
    ------
    ProjectError
        An undo or redo with nothing to undo or redo.
    """
    done: list[tuple[Edit, float]] = []
    undone: list[Edit] = []
    cuts: dict[tuple[Cut, bytes], BoolArray] = {}
    vocabulary: tuple[str, ...] = ()
    for operation in operations:
        if operation.action == "edit" and operation.edit is not None:
            done.append((operation.edit, operation.time))
            undone.clear()
            if operation.cut is not None and isinstance(operation.edit, Cut):
                cuts[operation.edit, operation.cut.segment_digest] = operation.cut.is_b
        elif operation.action == "vocabulary":
            vocabulary = operation.names
        elif operation.action == "undo":
            if not done:
                raise ProjectError("the log undoes an edit that was never done")
            undone.append(done.pop()[0])
        elif operation.action == "redo":
            if not undone:
                raise ProjectError("the log redoes an edit that was never undone")
            done.append((undone.pop(), operation.time))
    return Log(done, undone, cuts, vocabulary)


@dataclass(frozen=True, eq=False)
class Project:
    """All that a project file holds."""

    fingerprint: Fingerprint
    labels: npt.NDArray[Any]
    confidence: npt.NDArray[Any]
    levels: Mapping[str, npt.NDArray[Any]]
    names: tuple[str, ...]
    timings: Mapping[str, float]
    report: Mapping[str, Any]
    params: Params | None
    mesh: Mesh | None
    source: str  # where the mesh was loaded from, "" if from no file
    operations: tuple[Operation, ...]
    n_lost: int = 0  # operations that a recovery left behind

    @classmethod
    def of(
        cls,
        automatic: Segmentation,
        *,
        fingerprint: Fingerprint,
        mesh: Mesh | None,
        source: str,
        params: Params | None,
        operations: tuple[Operation, ...],
    ) -> Project:
        """The project of a segmentation. Items and the simplified mesh are left out: `segment` makes them."""
        return cls(
            fingerprint=fingerprint,
            labels=automatic.labels,
            confidence=np.asarray(automatic.confidence),
            levels=automatic.levels,
            names=tuple(automatic.names),
            timings=automatic.timings,
            report=automatic.report,
            params=params,
            mesh=mesh,
            source=source,
            operations=operations,
        )

    def segmentation(self, mesh: Mesh) -> Segmentation:
        """The automatic segmentation, on its mesh."""
        return Segmentation(
            mesh,
            self.labels,
            self.confidence,
            levels=dict(self.levels),
            names=self.names,
            timings=self.timings,
            report=self.report,
        )


_open_files: weakref.WeakValueDictionary[str, ProjectFile] = weakref.WeakValueDictionary()
_registry_lock = threading.Lock()


class ProjectFile:
    """An open project file.

    While it is open for writing, a lock beside it keeps other processes from writing. Within one process
    the newest one has the file, and the one before is closed (a notebook cell that is run again).

    Attributes
    ----------
    path : Path
    read_only : bool
    read_only_reason : str
        "" if it can be written.
    on_takeover : callable
        Called when another one of this process takes the file over.
    """

    def __init__(
        self, path: Path, connection: sqlite3.Connection, lock: FileLock | None, read_only_reason: str
    ) -> None:
        self.path = path
        self.read_only_reason = read_only_reason
        self.on_takeover: Callable[[], None] | None = None
        self._connection: sqlite3.Connection | None = connection
        self._lock = lock
        self._last_digest = b""
        self._next_seq = 0
        self._guard = threading.RLock()

    @property
    def read_only(self) -> bool:
        """Whether operations can't be written."""
        return self.read_only_reason != ""

    def is_at(self, path: Path) -> bool:
        """Whether this is the file of that path."""
        return _key(self.path) == _key(path)

    # --- opening and closing ----------------------------------------------------------------------

    @classmethod
    def write(cls, path: Path, project: Project, *, replaces: ProjectFile | None = None) -> ProjectFile:
        """Write a new file, put it in the place of the old one, and open it.

        Raises
        ------
        OSError
            It can't be written, or another process works on the old one, which is untouched then.
        """
        path = path.absolute()
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, f"can't write {str(path)!r}: it is a folder")
        lock = replaces._lock if replaces is not None and replaces.is_at(path) else None
        if lock is None:
            other = _open_files.get(_key(path))
            lock = FileLock(path)
            if other is not None:
                other._surrender()
            try:
                holder = lock.acquire()
            except OSError as error:
                raise explain(error, path) from error
            if holder:
                raise PermissionError(
                    errno.EACCES, f"can't write {str(path)!r}: {holder} works on it; choose another name"
                )
        try:
            with replacing(path) as temporary:
                _create(temporary, project)
                if replaces is not None and replaces._lock is lock:
                    replaces._disconnect()
                _settle(path)
            if replaces is not None and replaces._lock is lock:
                replaces._lock = None
            return cls._connect(path, lock, "", checked=True)
        except BaseException:
            if replaces is None or replaces._lock is not lock:
                lock.release()
            elif replaces._connection is None:  # renaming failed: go on with the old file
                replaces._connection = _connect(path, "rw")
            raise

    @classmethod
    def open(cls, path: Path) -> ProjectFile:
        """Open a file, for writing if nobody else does.

        Raises
        ------
        FileNotFoundError
        ProjectError
            Not a project, damaged, or of a newer version.
        """
        path = path.absolute()
        if not path.exists():
            raise FileNotFoundError(errno.ENOENT, f"project file {str(path)!r} does not exist")
        if not path.is_file():
            raise ProjectError(f"{path.name!r} is no file")
        other = _open_files.get(_key(path))
        if other is not None:
            other._surrender()
        lock, reason = FileLock(path), ""
        try:
            if not os.access(path, os.W_OK):
                reason = "you have no permission to write it"
            elif holder := lock.acquire():
                reason = f"{holder} works on it"
        except OSError:
            reason = "its folder can't be written"
        try:
            return cls._connect(path, None if reason else lock, reason)
        except BaseException:
            lock.release()
            raise

    @classmethod
    def _connect(
        cls, path: Path, lock: FileLock | None, reason: str, *, checked: bool = False
    ) -> ProjectFile:
        connection = _connect(path, "ro" if reason else "rw")
        try:
            with _reading(path):
                if not checked:
                    connection = _check(connection, path, read_only=bool(reason))
                if not reason:
                    connection.execute("PRAGMA journal_mode=WAL")
                    connection.execute("PRAGMA synchronous=FULL")  # a commit is on the disk
                    connection.execute("PRAGMA wal_autocheckpoint=500")
                file = cls(path, connection, lock, reason)
                row = connection.execute(
                    "SELECT seq, digest FROM operation ORDER BY seq DESC LIMIT 1"
                ).fetchone()
                if row is not None:
                    file._next_seq, file._last_digest = int(row[0]) + 1, bytes(row[1])
        except BaseException:
            connection.close()
            raise
        if lock is not None:
            with _registry_lock:
                _open_files[_key(path)] = file
        return file

    def checkpoint(self) -> None:
        """Bring everything into the one file, so that it can be copied."""
        with self._guard, self._writing() as connection:
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def close(self) -> None:
        """Close the file and give the lock back."""
        with self._guard:
            self._disconnect()
            if self._lock is not None:
                self._lock.release()
                self._lock = None
        with _registry_lock:
            if _open_files.get(_key(self.path)) is self:
                del _open_files[_key(self.path)]

    def __del__(self) -> None:
        with contextlib.suppress(Exception):
            self.close()

    def _surrender(self) -> None:
        self.close()
        self.read_only_reason = "another session of this process has taken it over"
        if self.on_takeover is not None:
            self.on_takeover()

    def _disconnect(self) -> None:
        if self._connection is not None:
            with contextlib.suppress(sqlite3.Error):
                self._connection.close()
            self._connection = None

    # --- reading and writing ----------------------------------------------------------------------

    def append(self, operations: Sequence[Operation], renewed: Project | None = None) -> None:
        """Add operations to the log, all or none; they are on the disk when this returns.

        Parameters
        ----------
        operations : sequence of Operation
        renewed : Project, optional
            Another automatic segmentation, which replaces the one in the file.

        Raises
        ------
        OSError
            The disk is full, …; the file is as it was.
        """
        rows, digest = [], self._last_digest
        for seq, operation in enumerate(operations, self._next_seq):
            body, extra = _encode(operation)
            digest = _digest(digest, seq, repr(operation.time), operation.action, body, extra or b"")
            rows.append((seq, operation.time, operation.action, body, extra, digest))
        with self._guard, self._writing() as connection:
            connection.execute("BEGIN IMMEDIATE")
            try:
                if renewed is not None:
                    _write_segmentation(connection, renewed)
                connection.executemany("INSERT INTO operation VALUES (?, ?, ?, ?, ?, ?)", rows)
                connection.execute("COMMIT")
            except BaseException:
                with contextlib.suppress(sqlite3.Error):
                    connection.execute("ROLLBACK")
                raise
            self._last_digest, self._next_seq = digest, self._next_seq + len(rows)

    @contextlib.contextmanager
    def _writing(self) -> Any:
        if self._connection is None:
            raise OSError(
                errno.EBADF, f"{self.path.name!r} is closed: {self.read_only_reason or 'save again'}"
            )
        try:
            yield self._connection
        except sqlite3.Error as error:
            raise _as_os_error(error, self.path) from error

    def load(self, *, recover: bool = False) -> Project:
        """Everything in the file.

        Raises
        ------
        ProjectError
            Something is damaged. With ``recover`` the log may be: what comes before the damage counts.
        """
        with self._guard, _reading(self.path):
            if self._connection is None:
                raise ProjectError(f"{self.path.name!r} is closed")
            return _load(self._connection, self.path.name, recover=recover)


# --- the database ---------------------------------------------------------------------------------


def _key(path: Path) -> str:
    return os.path.realpath(path)


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    uri = f"{path.as_uri()}?mode={mode}"
    try:
        connection = sqlite3.connect(uri, uri=True, isolation_level=None, check_same_thread=False, timeout=5)
        connection.execute("PRAGMA trusted_schema=OFF")
        connection.execute("PRAGMA cell_size_check=ON")
        connection.execute("PRAGMA mmap_size=0")
        if mode == "ro":
            try:
                connection.execute("SELECT COUNT(*) FROM sqlite_master").fetchone()
            except sqlite3.OperationalError:  # WAL needs to write beside the file, which nobody may here
                connection.close()
                connection = sqlite3.connect(
                    f"{uri}&immutable=1", uri=True, isolation_level=None, check_same_thread=False
                )
                connection.execute("PRAGMA trusted_schema=OFF")
    except sqlite3.Error as error:
        raise ProjectError(f"{path.name!r} can't be opened ({error})") from error
    connection.set_authorizer(_allow)
    return connection


def _allow(action: int, *_: Any) -> int:
    """A file may not make the database open other files."""
    return (
        sqlite3.SQLITE_DENY if action in (sqlite3.SQLITE_ATTACH, sqlite3.SQLITE_DETACH) else sqlite3.SQLITE_OK
    )


@contextlib.contextmanager
def _reading(path: Path) -> Any:
    """Whatever goes wrong in reading a file is the file's fault, and its name belongs in the message."""
    try:
        yield
    except ProjectError as error:
        raise (
            error if path.name in str(error) else ProjectError(f"{path.name!r} is damaged: {error}")
        ) from error
    except (
        sqlite3.Error,
        ValueError,
        TypeError,
        KeyError,
        OverflowError,
        RecursionError,
        MemoryError,
        zlib.error,
    ) as error:
        raise ProjectError(f"{path.name!r} is damaged or no project file ({error!s:.200})") from error


def _check(connection: sqlite3.Connection, path: Path, *, read_only: bool) -> sqlite3.Connection:
    """The connection to a sound project file of the present version; migrates an older one."""
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise ProjectError(f"{path.name!r} is no project file of scenewidget")
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    if version > VERSION:
        raise ProjectError(
            f"{path.name!r} was written by a newer scenewidget (format {version}, this one reads up to "
            f"{VERSION}); update scenewidget"
        )
    if version < 1:
        raise ProjectError(f"{path.name!r} is damaged: it has the format {version}")
    found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if found != "ok":
        raise ProjectError(f"{path.name!r} is damaged: {found!s:.200}")
    if version < VERSION:
        if read_only:  # upgrade a copy
            copy = sqlite3.connect(":memory:", isolation_level=None, check_same_thread=False)
            connection.backup(copy)
            connection.close()
            connection = copy
        connection.execute("BEGIN IMMEDIATE")
        for statement in (s for step in MIGRATIONS[version - 1 : VERSION - 1] for s in step):
            connection.execute(statement)
        connection.execute(f"PRAGMA user_version={VERSION}")
        connection.execute("COMMIT")
    tables = {row[0] for row in connection.execute("SELECT type || ' ' || name FROM sqlite_master")}
    allowed = {"table fact", "table array", "table operation", "index sqlite_autoindex_array_1"}
    if tables != allowed:
        raise ProjectError(
            f"{path.name!r} is damaged or forged: it holds {sorted(tables ^ allowed)[0]!r:.80}"
        )
    return connection


def _create(path: Path, project: Project) -> None:
    try:
        connection = sqlite3.connect(path, isolation_level=None)
        try:
            connection.execute("PRAGMA journal_mode=OFF")  # `replacing` flushes the file as a whole
            connection.execute("PRAGMA synchronous=OFF")
            connection.execute("PRAGMA page_size=4096")
            connection.execute(f"PRAGMA application_id={APPLICATION_ID}")
            connection.execute(f"PRAGMA user_version={VERSION}")
            connection.execute("BEGIN")
            for statement in SCHEMA:
                connection.execute(statement)
            _write_segmentation(connection, project)
            _put_fact(connection, "fingerprint", project.fingerprint.to_dict())
            _put_fact(connection, "source", project.source)
            if project.mesh is not None:
                _put_array(connection, "mesh/vertices", project.mesh.vertices)
                _put_array(connection, "mesh/faces", project.mesh.faces)
                if project.mesh.vertex_colors is not None:
                    _put_array(connection, "mesh/vertex_colors", project.mesh.vertex_colors)
            digest = b""
            for seq, operation in enumerate(project.operations):
                body, extra = _encode(operation)
                digest = _digest(digest, seq, repr(operation.time), operation.action, body, extra or b"")
                connection.execute(
                    "INSERT INTO operation VALUES (?, ?, ?, ?, ?, ?)",
                    (seq, operation.time, operation.action, body, extra, digest),
                )
            connection.execute("COMMIT")
        finally:
            connection.close()
    except sqlite3.Error as error:
        raise _as_os_error(error, path) from error


def _settle(path: Path) -> None:
    """Make the file that is to be replaced whole in itself, so that no log of it meets the new file."""
    if path.exists():
        with contextlib.suppress(sqlite3.Error):
            old = sqlite3.connect(path, timeout=5)
            try:
                old.execute("PRAGMA journal_mode=DELETE")
            finally:
                old.close()
    for suffix in ("-wal", "-shm", "-journal"):
        path.with_name(path.name + suffix).unlink(missing_ok=True)


def _as_os_error(error: sqlite3.Error, path: Path) -> OSError:
    codes = {
        sqlite3.SQLITE_FULL: errno.ENOSPC,
        sqlite3.SQLITE_READONLY: errno.EROFS,
        sqlite3.SQLITE_CANTOPEN: errno.EACCES,
    }
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    return explain(OSError(codes.get(code, errno.EIO), str(error)), path)


def _write_segmentation(connection: sqlite3.Connection, project: Project) -> None:
    connection.execute(
        "DELETE FROM array WHERE name = 'labels' OR name = 'confidence' OR name LIKE 'level/%'"
    )
    _put_array(connection, "labels", project.labels)
    _put_array(connection, "confidence", project.confidence)
    for level, parts in project.levels.items():
        _put_array(connection, f"level/{level}", parts)
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


def _load(connection: sqlite3.Connection, name: str, *, recover: bool) -> Project:
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
        expected = [found.n_faces] if array_name in columns else [None, 3]
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
        timings=dict(facts["timings"]),
        report=dict(facts["report"]),
        params=_load_params(facts["params"], name),
        mesh=mesh,
        source=str(facts["source"]),
        operations=tuple(operations),
        n_lost=n_lost,
    )


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
