"""The one door through which project files are read: it trusts nothing and takes nothing.

A file may come from anywhere: torn by a copy, spliced, forged. It is opened without a lock, without a trace
beside it, and read only where it has exactly our tables; whatever is wrong with it, is a `ProjectError`.

A database has a log beside it, ``-wal``, as long as somebody works on it or after he was killed. Then there
are two states: that of the file alone and that with the log. The one that goes on from the other is meant;
where neither does, the file is refused rather than answered with an older state.
"""

from __future__ import annotations

import contextlib
import errno
import shutil
import sqlite3
import stat
import struct
import tempfile
import threading
import weakref
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar

from scenewidget.editing.files import real
from scenewidget.editing.fingerprint import Fingerprint
from scenewidget.editing.project import Project, ProjectError, Root
from scenewidget.editing.schema import APPLICATION_ID, DAMAGE, check_tables, load_project, read_summary

__all__ = [
    "LiveFiles",
    "Summary",
    "blame",
    "guard",
    "is_project",
    "live_files",
    "read_alone",
    "read_project",
    "summary_of",
]

MOST_BYTES = 16 << 30  # of a project file
STEPS_A_BYTE = 4  # of SQLite's machine: more than any of our queries takes for a byte that is there
ATTEMPTS = 5  # while somebody else writes
SUPER_JOURNAL = bytes.fromhex("d9d505f920a163d7")  # ends a journal that names another file

T = TypeVar("T")


@dataclass(frozen=True)
class Summary:
    """What a project file is about, without opening it."""

    path: Path
    fingerprint: Fingerprint
    n_steps: int  # edits that are done
    last_time: float  # of the last edit, undo or redo, seconds since 1970 (UTC)


class _Live(Protocol):
    def reading(self) -> contextlib.AbstractContextManager[sqlite3.Connection | None]: ...


class LiveFiles:
    """The project files that this process writes, by what they are and not by what they are called."""

    def __init__(self) -> None:
        self._files: weakref.WeakValueDictionary[tuple[int, int], _Live] = weakref.WeakValueDictionary()
        self._lock = threading.Lock()

    def add(self, path: Path, file: _Live) -> None:
        """From now on this one writes the file at a path."""
        found = path.stat()
        with self._lock:
            self._files[found.st_dev, found.st_ino] = file

    def remove(self, file: _Live) -> None:
        """It doesn't any more."""
        with self._lock:
            for key in [key for key, other in self._files.items() if other is file]:
                del self._files[key]

    def at(self, path: Path) -> _Live | None:
        """Who writes the file at a path, by whatever name; None if nobody does."""
        try:
            found = path.stat()
        except OSError:
            return None
        with self._lock:
            return self._files.get((found.st_dev, found.st_ino))

    def __iter__(self) -> Iterator[_Live]:
        with self._lock:
            return iter(list(self._files.values()))


live_files = LiveFiles()


def read_project(path: Path, *, recover: bool = False) -> Project:
    """Everything in a project file; takes no lock, writes nothing.

    Parameters
    ----------
    path : Path
    recover : bool
        Of a damaged log, keep the operations before the damage; of a file and a log that don't belong
        together, keep the file.

    Raises
    ------
    FileNotFoundError
    ProjectError
        No project, damaged, forged, of a newer version, or without the log that it had.
    """

    def load(connection: sqlite3.Connection) -> Project:
        return load_project(connection, check_tables(connection), recover=recover)

    return _newest(path, load, _goes_on, recover=recover)


def summary_of(path: Path) -> Summary:
    """What is in a project file: its facts and its log are checked, its arrays aren't read.

    Raises
    ------
    FileNotFoundError
    ProjectError
        No project, damaged, forged, of a newer version, or without the log that it had.
    """

    def load(connection: sqlite3.Connection) -> Summary:
        return Summary(path.absolute(), *read_summary(connection, check_tables(connection)))

    return _newest(path, load, lambda one, other: one.last_time >= other.last_time)


def read_alone(path: Path) -> Root:
    """Which state a file is in by itself, whatever lies beside it.

    Raises
    ------
    FileNotFoundError, ProjectError
    """
    place = real(path)
    _check_file(path, place)
    with blame(path), _alone(place) as connection:
        root = load_project(connection, check_tables(connection), recover=False).root
    assert root is not None  # of a project that was read
    return root


def is_project(path: Path) -> bool:
    """Whether a file says that it is a project file, or is empty."""
    if live_files.at(path) is not None:  # which must not be opened a second time
        return True
    with path.open("rb") as file:
        head = file.read(72)
    return not head or (head[:15] == b"SQLite format 3" and head[68:72] == APPLICATION_ID.to_bytes(4, "big"))


def _goes_on(one: Project, other: Project) -> bool:
    """Whether a state comes after another one, or is the same."""
    n = len(other.operations)
    return (
        len(one.chain) > n
        and one.chain[n] == other.chain[n]
        and (len(one.chain) > n + 1 or one.root == other.root)
    )


def _newest(
    path: Path,
    load: Callable[[sqlite3.Connection], T],
    goes_on: Callable[[T, T], bool],
    *,
    recover: bool = False,
) -> T:
    """The state of a file, with its log or without, whichever goes on from the other."""
    place = real(path)
    _check_file(path, place)
    live = live_files.at(place)
    if live is not None:
        with blame(path), live.reading() as connection:
            if connection is not None:
                return load(connection)
    for attempt in range(ATTEMPTS):
        before = _marks(place)
        try:
            with blame(path):
                return _newest_once(place, load, goes_on, recover=recover)
        except (ProjectError, FileNotFoundError):
            if attempt == ATTEMPTS - 1 or _marks(place) == before:
                raise
    raise AssertionError  # the last attempt has returned or raised


def _newest_once(
    place: Path, load: Callable[[sqlite3.Connection], T], goes_on: Callable[[T, T], bool], *, recover: bool
) -> T:
    log, journal = _beside(place, "-wal"), _beside(place, "-journal")
    if not _size(log) and not _size(journal):
        _check_index(place)
        with _alone(place) as connection:
            return load(connection)
    if _size(journal):
        _check_journal(journal)
    with _whole(place) as connection:
        try:
            whole: T | Exception = load(connection)
        except DAMAGE as error:
            whole = error
    try:
        with _alone(place) as connection:
            alone = load(connection)
    except DAMAGE as error:
        if isinstance(whole, Exception):
            raise whole from error
        return whole
    if isinstance(whole, Exception):
        if recover:
            return alone
        raise ProjectError(
            f"its log {log.name!r} does not belong to it, or is damaged ({whole!s:.200}). "
            "Session.open(…, recover=True) takes the file without it"
        ) from whole
    if goes_on(whole, alone):
        return whole
    if goes_on(alone, whole) or recover:
        return alone
    raise ProjectError(
        f"it and its log {log.name!r} hold different work. Session.open(…, recover=True) takes the file "
        "without the log"
    )


# --- connections ----------------------------------------------------------------------------------


@contextlib.contextmanager
def _alone(place: Path) -> Iterator[sqlite3.Connection]:
    """A connection that sees the file and nothing beside it."""
    with _connected(place, f"{place.as_uri()}?mode=ro&immutable=1") as connection:
        yield connection


@contextlib.contextmanager
def _whole(place: Path) -> Iterator[sqlite3.Connection]:
    """A connection to a copy of the file and its log; the medium may be read-only, the log another's."""
    with tempfile.TemporaryDirectory(prefix="scenewidget-") as folder:
        copy = Path(folder) / "copy.swproj"
        for suffix in ("", "-journal", "-wal"):  # a log that has grown meanwhile still fits the file
            try:
                shutil.copyfile(_beside(place, suffix), _beside(copy, suffix))
            except FileNotFoundError:
                continue
            except PermissionError as error:
                raise ProjectError(
                    f"its log {place.name + suffix!r} can't be read: you have no permission"
                ) from error
        with _connected(copy, copy.as_uri()) as connection:
            yield connection


@contextlib.contextmanager
def _connected(place: Path, uri: str) -> Iterator[sqlite3.Connection]:
    connection = sqlite3.connect(uri, uri=True, isolation_level=None, timeout=1)
    try:
        guard(connection, place.stat().st_size)
        yield connection
    finally:
        connection.close()


def guard(connection: sqlite3.Connection, n_bytes: int) -> None:
    """Let a connection do nothing that a sound project of so many bytes has no need of.

    Raises
    ------
    ProjectError, sqlite3.Error
        Its tables aren't ours, or its pages don't fit together.
    """
    for pragma in ("trusted_schema=OFF", "cell_size_check=ON", "mmap_size=0", "temp_store=MEMORY"):
        connection.execute(f"PRAGMA {pragma}")
    connection.setlimit(sqlite3.SQLITE_LIMIT_SQL_LENGTH, 10_000)
    connection.setlimit(sqlite3.SQLITE_LIMIT_COLUMN, 20)
    connection.setlimit(sqlite3.SQLITE_LIMIT_EXPR_DEPTH, 20)
    connection.setlimit(sqlite3.SQLITE_LIMIT_ATTACHED, 0)
    connection.setlimit(sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH, 1)
    budget = 100 + STEPS_A_BYTE * n_bytes // 1000
    spent = 0

    def count() -> bool:
        nonlocal spent
        spent += 1
        return spent > budget

    connection.set_progress_handler(count, 1000)
    check_tables(connection)
    found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if found != "ok":
        raise ProjectError(f"it is damaged: {found!s:.200}")


@contextlib.contextmanager
def blame(path: Path) -> Iterator[None]:
    """Whatever goes wrong in reading a file is the file's fault, and its name belongs in the message."""
    try:
        yield
    except ProjectError as error:
        if path.name in str(error):
            raise
        text = str(error)
        text = text.removeprefix("it ") if text.startswith("it ") else f"is damaged: {text}"
        raise ProjectError(f"{path.name!r} {text}") from error
    except DAMAGE as error:
        raise ProjectError(f"{path.name!r} is damaged or no project file ({error!s:.200})") from error


# --- what lies there ------------------------------------------------------------------------------


def _check_file(path: Path, place: Path) -> None:
    try:
        found = place.stat()
    except (FileNotFoundError, NotADirectoryError):
        raise FileNotFoundError(errno.ENOENT, f"project file {str(path)!r} does not exist") from None
    if not stat.S_ISREG(found.st_mode):
        raise ProjectError(f"{path.name!r} is no file")
    if found.st_size + _size(_beside(place, "-wal")) > MOST_BYTES:
        raise ProjectError(f"{path.name!r} is larger than any project file ({MOST_BYTES >> 30} GB)")


def _beside(place: Path, suffix: str) -> Path:
    return place.with_name(place.name + suffix)


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except FileNotFoundError:
        return 0


def _marks(place: Path) -> list[tuple[int, ...]]:
    """What changes when somebody writes."""
    out: list[tuple[int, ...]] = []
    for suffix in ("", "-wal", "-journal"):
        try:
            found = _beside(place, suffix).stat()
        except FileNotFoundError:
            out.append(())
        else:
            out.append((found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns))
    return out


def _check_index(place: Path) -> None:
    """An index of a log, ``-shm``, that tells of steps which aren't in the file: the log was lost.

    SQLite documentation, *WAL-mode file format*: mxFrame at 16, nBackfill at 96, in the machine's order.
    """
    try:
        head = _beside(place, "-shm").read_bytes()[:100]
    except FileNotFoundError:
        return
    if len(head) == 100 and head[:48] == head[48:96] and head[12]:
        (in_log,), (in_file,) = struct.unpack_from("=I", head, 16), struct.unpack_from("=I", head, 96)
        if in_log > in_file:
            raise ProjectError(
                f"it lacks its log {place.name + '-wal'!r}, which held the last steps; bring it back beside "
                "it, or remove the file that ends in -shm to go on without them"
            )


def _check_journal(journal: Path) -> None:
    """Refuse a journal that would let SQLite look for, and remove, another file."""
    with journal.open("rb") as file:
        file.seek(max(0, _size(journal) - 8))
        if file.read() == SUPER_JOURNAL:
            raise ProjectError(f"its journal {journal.name!r} names another file")
