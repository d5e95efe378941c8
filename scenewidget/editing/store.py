"""The project file, ``.swproj``: an SQLite database that is right after whatever happens.

It is in WAL mode: each operation is a transaction that is on the disk before `ProjectFile.append` returns.
Nothing is ever deleted from the log; undo and redo are entries of it. One process writes at a time.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import os
import sqlite3
import threading
import weakref
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from scenewidget.editing.files import FileLock, explain, replacing
from scenewidget.editing.fingerprint import Fingerprint
from scenewidget.editing.project import Operation, Project, ProjectError
from scenewidget.editing.schema import (
    APPLICATION_ID,
    MIGRATIONS,
    VERSION,
    insert_operations,
    load_project,
    read_summary,
    write_project,
    write_segmentation,
)

__all__ = ["ProjectFile", "Summary", "summary_of"]

TABLES = {"table fact", "table array", "table operation", "index sqlite_autoindex_array_1"}
_open_files: weakref.WeakValueDictionary[str, ProjectFile] = weakref.WeakValueDictionary()
_registry_lock = threading.Lock()
_of_parents: list[sqlite3.Connection] = []  # connections that a fork carried over, never to be touched


@dataclass(frozen=True)
class Summary:
    """What a project file is about, without opening it."""

    path: Path
    fingerprint: Fingerprint
    n_steps: int  # edits that are done
    last_time: float  # of the last edit, undo or redo, seconds since 1970 (UTC)


def summary_of(path: Path) -> Summary:
    """What is in a project file; takes no lock, writes nothing, reads a few rows.

    Raises
    ------
    OSError, ProjectError
        Not there, no project, damaged, or of a newer version.
    """
    path = path.absolute()
    has_log = path.with_name(path.name + "-wal").exists()
    with _reading(path):
        uri = f"{path.as_uri()}?mode=ro" + ("" if has_log else "&immutable=1")
        connection = sqlite3.connect(uri, uri=True, isolation_level=None, timeout=1)
        try:
            connection.execute("PRAGMA trusted_schema=OFF")
            connection.set_authorizer(_allow)
            if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
                raise ProjectError(f"{path.name!r} is no project file of scenewidget")
            if not 1 <= connection.execute("PRAGMA user_version").fetchone()[0] <= VERSION:
                raise ProjectError(f"{path.name!r} was written by a newer scenewidget, or is damaged")
            found, n_steps, last_time = read_summary(connection)
        finally:
            connection.close()
    return Summary(path, found, n_steps, last_time)


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
    on_takeover : weak reference to a method
        Called when another one of this process takes the file over.
    """

    def __init__(
        self, path: Path, connection: sqlite3.Connection, lock: FileLock | None, read_only_reason: str
    ) -> None:
        self.path = path
        self.read_only_reason = read_only_reason
        self.on_takeover: weakref.WeakMethod[Callable[[], None]] | None = None
        self._process = os.getpid()
        self._connection: sqlite3.Connection | None = connection
        self._lock = lock
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
    def write(
        cls, path: Path, project: Project, *, replaces: ProjectFile | None = None, overwrite: bool = True
    ) -> ProjectFile:
        """Write a new file, put it in the place of the old one, and open it.

        Raises
        ------
        FileExistsError
            Not to ``overwrite`` it, and there is one, or somebody is just making it.
        OSError
            It can't be written, or another process works on the old one, which is untouched then.
        """
        path = path.absolute()
        if path.is_dir():
            raise explain(IsADirectoryError(errno.EISDIR, ""), path)
        lock = replaces._lock if replaces is not None and replaces.is_at(path) else None
        if lock is None:
            other = _open_files.get(_key(path))
            lock = FileLock(path)
            if other is not None and overwrite:
                other._surrender()
            try:
                holder = lock.acquire()
            except OSError as error:
                raise explain(error, path) from error
            if not overwrite and (holder or path.exists()):  # whoever has the lock alone may make the file
                lock.release()
                raise FileExistsError(errno.EEXIST, f"{str(path)!r} is there already")
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
                _make_durable(replaces._connection)
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
                    _make_durable(connection)
                file = cls(path, connection, lock, reason)
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
        self.read_only_reason = "a newer session has taken it over"
        callback = None if self.on_takeover is None else self.on_takeover()
        if callback is not None:
            callback()

    def _disconnect(self) -> None:
        if self._connection is None:
            return
        if os.getpid() != self._process:  # closing it here would pull the file from under the parent
            _of_parents.append(self._connection)
            self._lock = None
        else:
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
        with self._guard, self._writing() as connection:
            connection.execute("BEGIN IMMEDIATE")
            try:
                if renewed is not None:
                    write_segmentation(connection, renewed)
                insert_operations(connection, operations)
                connection.execute("COMMIT")
            except BaseException:
                with contextlib.suppress(sqlite3.Error):
                    connection.execute("ROLLBACK")
                raise

    @contextlib.contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        if os.getpid() != self._process:
            raise OSError(
                errno.EBADF, f"{self.path.name!r} belongs to the process that this one was forked from"
            )
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
            return load_project(self._connection, self.path.name, recover=recover)


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


def _allow(action: int, *_: object) -> int:
    """A file may not make the database open other files."""
    return (
        sqlite3.SQLITE_DENY if action in (sqlite3.SQLITE_ATTACH, sqlite3.SQLITE_DETACH) else sqlite3.SQLITE_OK
    )


def _make_durable(connection: sqlite3.Connection) -> None:
    connection.execute("PRAGMA journal_mode=WAL")
    connection.execute("PRAGMA synchronous=FULL")  # a commit is on the disk
    connection.execute("PRAGMA wal_autocheckpoint=500")


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[None]:
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
    if tables != TABLES:
        raise ProjectError(f"{path.name!r} is damaged or forged: it holds {sorted(tables ^ TABLES)[0]!r:.80}")
    return connection


def _create(path: Path, project: Project) -> None:
    try:
        connection = sqlite3.connect(path, isolation_level=None)
        try:
            connection.execute("PRAGMA journal_mode=OFF")  # `replacing` flushes the file as a whole
            connection.execute("PRAGMA synchronous=OFF")
            write_project(connection, project)
        finally:
            connection.close()
    except sqlite3.Error as error:
        raise _as_os_error(error, path) from error


def _settle(path: Path) -> None:
    """Make the file that is to be replaced whole in itself, so that no log of it meets the new file."""
    if path.exists():
        with contextlib.suppress(sqlite3.Error):
            old = sqlite3.connect(path, timeout=1)
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


@atexit.register
def _close_all() -> None:
    """Leave whole files behind, without logs beside them."""
    for file in list(_open_files.values()):
        file.close()
