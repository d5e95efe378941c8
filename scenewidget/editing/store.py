"""The project file, ``.swproj``: an SQLite database that is right after whatever happens.

Each operation is a transaction that is on the disk before `ProjectFile.append` returns. Nothing is ever
deleted from the log; undo and redo are entries of it. One process writes at a time.

A commit goes to the log beside the file, ``-wal``, and is flushed there; then its pages are copied into the
file itself, without waiting for the disk. So the file alone has every edit as soon as it is acknowledged,
under whatever name somebody gives it and even if we are killed; and after a power loss, the log has it.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import os
import sqlite3
import threading
import weakref
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from scenewidget.editing.files import FileLock, Handle, explain, is_one_name, real, replacing
from scenewidget.editing.project import Operation, Project, ProjectError, Root
from scenewidget.editing.project_reader import blame, guard, is_project, live_files, read_alone
from scenewidget.editing.schema import (
    insert_operations,
    migrate,
    read_root,
    replace_segmentation,
    write_project,
)

__all__ = ["FileChangedError", "ProjectFile"]

TAKEN_OVER = "a newer session has taken it over"
MOST_IN_LOG = 400  # pages, before the log begins anew
_of_parents: list[sqlite3.Connection] = []  # connections that a fork carried over, never to be touched


class FileChangedError(OSError):
    """What lies at the path is no longer the file that we wrote there."""


class ProjectFile:
    """A project file that a session has taken, for writing if nobody else does.

    While it is taken for writing, a lock beside it and one on the file itself keep other processes from
    writing, whatever name they use. Within one process the newest one has the file, and the one before is
    closed (a notebook cell that is run again).

    Attributes
    ----------
    path : Path
    read_only : bool
    read_only_reason : str
        "" if it can be written.
    root : Root
        Which state is in the file.
    on_takeover : weak reference to a method
        Called when another one of this process takes the file over.
    """

    def __init__(self, path: Path, root: Root, read_only_reason: str = "") -> None:
        self.path = path
        self.root = root
        self.read_only_reason = read_only_reason
        self.on_takeover: weakref.WeakMethod[Callable[[], None]] | None = None
        self._place = real(path)
        self._process = os.getpid()
        self._lock: FileLock | None = None
        self._handle: Handle | None = None
        self._connection: sqlite3.Connection | None = None
        self._copier: sqlite3.Connection | None = None
        self._marks: tuple[int, ...] = ()  # of the file as we left it
        self._guard = threading.RLock()

    @property
    def read_only(self) -> bool:
        """Whether operations can't be written."""
        return self.read_only_reason != ""

    @property
    def is_taken_over(self) -> bool:
        """Whether a newer session of this process has it."""
        return self.read_only_reason == TAKEN_OVER

    def is_at(self, path: Path) -> bool:
        """Whether this is the file of that path."""
        return is_one_name(self._place, real(path))

    # --- taking and letting go --------------------------------------------------------------------

    @classmethod
    def take(cls, path: Path, project: Project) -> ProjectFile:
        """Take the file that a project was read from; read-only if somebody else has it.

        Everything about the project has been checked before: nothing is taken from anybody for a file that
        is then refused.

        Raises
        ------
        FileChangedError
            It isn't in that state any more; read it again.
        OSError
            Something else is wrong with the disk; whoever had the file has it still.
        """
        path = path.absolute()
        assert project.root is not None  # of a project that was read
        file = cls(path, project.root)
        other = _owner(live_files.at(file._place))
        try:
            if other is None:
                file._take_free()
                return file
            with other._guard:
                file._take_from(other)
        except ProjectError as error:  # it was read, so it is sound
            file.read_only_reason = f"it can't be opened for writing ({error})"
            return file
        if not file.read_only:
            other._tell()
        return file

    def _take_free(self) -> None:
        self.read_only_reason = self._take_locks()
        if self.read_only:
            return
        try:
            self._drop_stale_log()
            self._connect(check=True)
        except BaseException:
            self.close()
            raise

    def _take_from(self, other: ProjectFile) -> None:
        if not is_one_name(
            other._place, self._place
        ):  # another name of it: a database must be open under one only
            lock = FileLock(self.path)
            self.read_only_reason = _try_to_lock(lock)
            if self.read_only:
                return
            self._lock = lock
            other._disconnect()
        try:
            self._connect(check=True)
        except BaseException:
            self.close()
            if other._connection is None:
                other._connect(check=True)
            raise
        other._surrender(self)

    @classmethod
    def write(
        cls, path: Path, project: Project, *, replaces: ProjectFile | None = None, overwrite: bool = True
    ) -> ProjectFile:
        """Write a new file, put it in the place of the old one, and take it.

        Nothing happens to the old file, nor to the session that has it, before the new one is complete.

        Raises
        ------
        FileExistsError
            Not to ``overwrite`` it, and there is one, or somebody is just making it; or it is no project.
        OSError
            It can't be written, or another process works on the old one, which is untouched then.
        """
        path = path.absolute()
        place = real(path)
        if place.is_dir():
            raise explain(IsADirectoryError(errno.EISDIR, ""), path)
        if not place.parent.is_dir():
            raise explain(FileNotFoundError(errno.ENOENT, ""), path)
        if not overwrite and place.exists():
            raise FileExistsError(errno.EEXIST, f"{str(path)!r} is there already")
        owner = replaces if replaces is not None and replaces._lock and replaces.is_at(path) else None
        owner = owner or next(
            (f for f in map(_owner, live_files) if f is not None and is_one_name(f._place, place)), None
        )
        file, is_new = cls(path, Root(0, b"", b"")), not place.exists()
        if owner is None:
            file._lock = _locked(path, overwrite=overwrite)
        with owner._guard if owner is not None else contextlib.nullcontext():
            try:
                if place.exists() and not is_project(place):
                    raise FileExistsError(
                        errno.EEXIST,
                        f"{str(path)!r} is there already and is no project file, so it is not replaced; "
                        "choose another name, or remove it first",
                    )
                with replacing(path) as temporary:
                    _create(temporary, project)
                    file._handle = Handle(temporary)
                    file._handle.lock()
                    if owner is not None:
                        owner._disconnect()
                    _settle(place)
                try:
                    file._connect(check=False)
                except ProjectError as error:
                    if not isinstance(error.__cause__, sqlite3.Error):
                        raise
                    _remove_log(place)  # what we have just written is sound: it is the disk
                    if is_new:
                        place.unlink(missing_ok=True)
                    raise _as_os_error(error.__cause__, path) from error
            except BaseException:
                file.close()
                if owner is not None and owner._connection is None:
                    with contextlib.suppress(OSError, ProjectError):  # go on with the old file
                        owner._connect(check=True)
                raise
            if owner is not None:
                owner._surrender(file)
        if owner is not None and owner is not replaces:
            owner._tell()
        return file

    def _take_locks(self) -> str:
        """Take both locks; who has them, or why they can't be taken, "" if that worked."""
        if not os.access(self._place, os.W_OK):
            return "you have no permission to write it"
        lock = FileLock(self.path)
        if reason := _try_to_lock(lock):
            return reason
        self._lock, self._handle = lock, Handle(self._place)
        if self._handle.lock():
            return ""
        self.close()
        return "another kernel or script works on it under another name"

    def _drop_stale_log(self) -> None:
        """Remove a log from beside the file if the file has all that is wanted of both."""
        if not _beside(self._place, "-wal").exists():
            return
        with contextlib.suppress(ProjectError):  # not whole without its log
            if read_alone(self.path) == self.root:
                if self._handle is not None:
                    self._handle.sync()
                _remove_log(self._place)

    def _connect(self, *, check: bool) -> None:
        """Open the database; with ``check`` it may have been changed, or be of an older version."""
        connection = copier = None
        try:
            with blame(self.path):
                connection = _open(self._place)
                if check:
                    guard(connection, self._place.stat().st_size)
                    connection.set_progress_handler(None, 0)
                    connection.execute("PRAGMA journal_mode=WAL")
                    migrate(connection, self.root)
                found = read_root(connection)
                if check and found != self.root:
                    raise FileChangedError(errno.ESTALE, f"{self.path.name!r} has changed since it was read")
                connection.execute("PRAGMA synchronous=FULL")  # a commit is on the disk
                copier = _open(self._place)
                copier.execute("PRAGMA synchronous=OFF")  # a copy may still be on its way there
                self._connection, self._copier, self.root = connection, copier, found
                self._copy()
        except BaseException:
            self._connection = self._copier = None
            for opened in (copier, connection):
                if opened is not None:
                    opened.close()
            raise
        live_files.add(self._place, self)

    def checkpoint(self) -> None:
        """Bring everything into the one file and onto the disk, so that nothing is beside it."""
        with self._guard, self._writing() as connection:
            self._begin_log_anew(connection)

    def close(self) -> None:
        """Close the file and give the locks back."""
        with self._guard:
            self._disconnect()
            live_files.remove(self)
            if self._handle is not None:
                self._handle.close()
                self._handle = None
            if self._lock is not None:
                self._lock.release()
                self._lock = None

    def __del__(self) -> None:
        with contextlib.suppress(Exception):
            self.close()

    def _surrender(self, to: ProjectFile) -> None:
        """Let another one have the file, with the locks that it lacks; called with both guards held."""
        self._disconnect()
        if to._lock is None:
            to._lock, self._lock = self._lock, None
        if to._handle is None:
            to._handle, self._handle = self._handle, None
        self.close()
        self.read_only_reason = TAKEN_OVER
        live_files.add(to._place, to)

    def _tell(self) -> None:
        """Let the session know that its file is gone to another; called without any guard held."""
        callback = None if self.on_takeover is None else self.on_takeover()
        if callback is not None:
            callback()

    def _disconnect(self) -> None:
        """Close the database and leave a whole file without a log."""
        connection, copier, self._connection, self._copier = self._connection, self._copier, None, None
        if connection is None or copier is None:
            return
        if os.getpid() != self._process:  # closing it here would pull the file from under the parent
            _of_parents.extend([connection, copier])
            self._lock = self._handle = None
            return
        if self._handle is not None:
            with contextlib.suppress(OSError):
                self._handle.sync()
        for opened in (copier, connection):
            with contextlib.suppress(sqlite3.Error):
                opened.close()
        if (
            self._lock is not None and not self._is_there()
        ):  # SQLite leaves the log beside whatever is there now
            _remove_log(self._place)

    # --- what lies at the path --------------------------------------------------------------------

    def trouble(self) -> str:
        """Why the path doesn't hold the file that we wrote there, and the way out; "" if it does.

        Costs some microseconds, unless somebody has touched the file: then it is read.
        """
        if self.read_only or os.getpid() != self._process:
            return ""
        with self._guard:
            name = repr(self.path.name)
            try:
                found = self.path.stat()
                is_ours = self._handle is None or self._handle.is_same(found)
            except OSError:
                if not self._place.parent.is_dir():
                    return f"the folder of {name} is gone; save your work elsewhere: save('other.swproj')"
                if self._handle is None or self._handle.has_a_name:
                    return f"{name} was renamed or moved away; save() writes a new one in its place"
                return f"{name} was deleted; save() writes it anew"
            if not is_ours:
                reason = f"another file has taken the place of {name}"
            elif self._is_as_left(found):
                return ""
            else:
                reason = f"somebody else has written into {name}"
            return f"{reason}; save your work under another name, or save({name}) to replace what is there"

    def _is_as_left(self, found: os.stat_result) -> bool:
        marks = (found.st_size, found.st_mtime_ns)
        if self._marks in ((), marks):
            return True
        try:
            is_same = read_alone(self.path) == self.root
        except (OSError, ProjectError):
            is_same = False
        if is_same:
            self._marks = marks
        return is_same

    def _is_there(self) -> bool:
        try:
            return self._handle is None or self._handle.is_same(self._place.stat())
        except OSError:
            return False

    # --- reading and writing ----------------------------------------------------------------------

    @contextlib.contextmanager
    def reading(self) -> Iterator[sqlite3.Connection | None]:
        """A connection to read with, None if the file isn't what we wrote."""
        with self._guard:
            is_ours = os.getpid() == self._process and self._connection is not None and not self.trouble()
            yield self._connection if is_ours else None

    def append(self, operations: Sequence[Operation], renewed: Project | None = None) -> None:
        """Add operations to the log, all or none; they are on the disk when this returns.

        Parameters
        ----------
        operations : sequence of Operation
        renewed : Project, optional
            Another automatic segmentation, which replaces the one in the file.

        Raises
        ------
        FileChangedError
            The path no longer holds the file. `root` says which operations are in it all the same.
        OSError
            The disk is full, …; the file is as it was.
        """
        with self._guard, self._writing() as connection:
            if operations or renewed is not None:
                try:
                    if read_root(connection) != self.root:
                        raise FileChangedError(
                            errno.ESTALE, f"somebody else has written into {self.path.name!r}"
                        )
                    if renewed is not None:
                        replace_segmentation(connection, renewed)
                    root = insert_operations(connection, operations)
                    connection.execute("COMMIT")
                except BaseException:
                    self._begin(connection)
                    raise
                self.root = root
            self._copy()
            self._check()

    @contextlib.contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        if os.getpid() != self._process:
            raise OSError(
                errno.EBADF, f"{self.path.name!r} belongs to the process that this one was forked from"
            )
        if self.read_only or self._lock is None:
            raise OSError(
                errno.EBADF, f"{self.path.name!r} is closed: {self.read_only_reason or 'save again'}"
            )
        self._check()
        if self._connection is None:  # it is back where it was
            try:
                self._connect(check=True)
            except ProjectError as error:
                raise FileChangedError(errno.ESTALE, str(error)) from error
        assert self._connection is not None
        try:
            yield self._connection
        except sqlite3.Error as error:
            raise _as_os_error(error, self.path) from error

    def _check(self) -> None:
        trouble = self.trouble()
        if trouble:
            self._disconnect()  # our log must not be taken for that of another file
            raise FileChangedError(errno.ESTALE, trouble)

    def _copy(self) -> None:
        """Copy what is committed into the file itself.

        A reader is begun before: as long as one uses the log, SQLite never begins it anew, which would throw
        away what the disk has not yet of the file. That is for `_begin_log_anew`, which waits for the disk.
        """
        connection, copier = self._connection, self._copier
        assert connection is not None
        assert copier is not None
        self._begin(connection)
        self._marks = ()
        _, n_pages, _ = copier.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
        if n_pages > MOST_IN_LOG:
            self._begin_log_anew(connection)
        found = self._place.stat()
        self._marks = (found.st_size, found.st_mtime_ns)

    def _begin_log_anew(self, connection: sqlite3.Connection) -> None:
        if self._handle is not None:
            self._handle.sync()
        connection.execute("ROLLBACK")
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        self._begin(connection)

    @staticmethod
    def _begin(connection: sqlite3.Connection) -> None:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        connection.execute("BEGIN")
        read_root(connection)


# --- the database ---------------------------------------------------------------------------------


def _owner(file: object) -> ProjectFile | None:
    """A live file of this process, not one that a fork carried over."""
    is_ours = isinstance(file, ProjectFile) and file._process == os.getpid() and file._lock is not None
    return file if is_ours else None  # type: ignore[return-value]  # it is a ProjectFile


def _try_to_lock(lock: FileLock) -> str:
    """Take a lock; why that did not work, "" if it did."""
    try:
        holder = lock.acquire()
    except OSError as error:
        if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
            return "its folder can't be written"
        return f"its folder can't keep others from writing at the same time ({error.strerror})"
    return f"{holder} works on it" if holder else ""


def _locked(path: Path, *, overwrite: bool) -> FileLock:
    lock = FileLock(path)
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
    return lock


def _open(place: Path) -> sqlite3.Connection:
    uri = f"{place.as_uri()}?mode=rw"
    connection = sqlite3.connect(uri, uri=True, isolation_level=None, check_same_thread=False, timeout=5)
    for pragma in ("trusted_schema=OFF", "cell_size_check=ON", "mmap_size=0", "wal_autocheckpoint=0"):
        connection.execute(f"PRAGMA {pragma}")
    return connection


def _create(path: Path, project: Project) -> None:
    try:
        connection = sqlite3.connect(path, isolation_level=None)
        try:
            connection.execute("PRAGMA journal_mode=OFF")  # `replacing` flushes the file as a whole
            connection.execute("PRAGMA synchronous=OFF")
            write_project(connection, project)
            connection.execute("PRAGMA journal_mode=WAL")
        finally:
            connection.close()
    except sqlite3.Error as error:
        raise _as_os_error(error, path) from error


def _settle(place: Path) -> None:
    """Make the file that is to be replaced whole in itself, so that no log of it meets the new file."""
    if place.exists() and _beside(place, "-wal").exists():
        with contextlib.suppress(sqlite3.Error):
            old = sqlite3.connect(place, timeout=1)
            try:
                old.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            finally:
                old.close()
    _remove_log(place)


def _remove_log(place: Path) -> None:
    for suffix in ("-wal", "-shm", "-journal"):
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            _beside(place, suffix).unlink()


def _beside(place: Path, suffix: str) -> Path:
    return place.with_name(place.name + suffix)


def _as_os_error(error: sqlite3.Error, path: Path) -> OSError:
    codes = {
        sqlite3.SQLITE_FULL: errno.ENOSPC,
        sqlite3.SQLITE_READONLY: errno.EROFS,
        sqlite3.SQLITE_CANTOPEN: errno.EACCES,
    }
    code = getattr(error, "sqlite_errorcode", 0)
    if code == sqlite3.SQLITE_IOERR_SHMSIZE:  # no room for the index of the log
        code = sqlite3.SQLITE_FULL
    return explain(OSError(codes.get(code & 0xFF, errno.EIO), str(error)), path)


@atexit.register
def _close_all() -> None:
    """Leave whole files behind, without logs beside them."""
    for file in list(live_files):
        if isinstance(file, ProjectFile):
            file.close()
