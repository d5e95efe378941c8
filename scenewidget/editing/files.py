"""Files that are there whole or not at all, and locks that tell who is at work.

A file is written beside its destination, flushed to the disk, and renamed over it: whatever happens, the
destination holds the old file or the new one. Symbolic links are followed, so a link stays a link.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import importlib
import json
import os
import re
import secrets
import shutil
import socket
import struct
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

__all__ = [
    "FileLock",
    "Handle",
    "checked_path",
    "explain",
    "is_blind_to_case",
    "is_one_name",
    "left_behind",
    "real",
    "replacing",
    "replacing_all",
    "spoken_process",
    "sync_folder",
    "this_process",
]


def checked_path(path: object) -> Path:
    """A path out of a str or a path-like object.

    Raises
    ------
    TypeError
        Something else; the message says ``path``.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"path must be a str or a Path, got {type(path).__name__}")
    return Path(path)


def real(path: Path) -> Path:
    """Where a path leads: absolute, links followed."""
    return Path(os.path.realpath(path))


def is_one_name(one: Path, other: Path) -> bool:
    """Whether two real paths are one, as where case makes no difference; two links to one file are not."""
    if one == other:
        return True
    if str(one).casefold() != str(other).casefold():
        return False
    try:
        return one.samefile(other) and one.samefile(one.with_name(one.name.swapcase()))
    except OSError:
        return False


def is_blind_to_case(folder: Path) -> bool:
    """Whether capital and small letters make no difference in names there; False if nothing tells."""
    names = {path.name for path in folder.iterdir()}
    others = (name.swapcase() for name in names)
    return any((folder / name).exists() for name in others if name not in names)


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path beside ``path`` to write to; becomes ``path`` when the block ends well.

    Raises
    ------
    OSError
        The folder can't be written, the disk is full, …; the message says what stays.
    """
    with replacing_all([path]) as (temporary,):
        yield temporary


@contextlib.contextmanager
def replacing_all(paths: Sequence[Path]) -> Iterator[list[Path]]:
    """Paths to write to, one beside each of ``paths``; they take their places when the block ends well.

    If one can't take its place, those that have taken theirs give it back: all or none.

    Raises
    ------
    OSError
        A folder can't be written, the disk is full, …; the message says what stays.
    """
    for path in paths:
        _refuse_device(path)
    places = [real(path) for path in paths]
    for place in places:
        _sweep(place)
    temporaries = [_beside(place) for place in places]
    current = places[0]
    try:
        yield temporaries
        for temporary in temporaries:
            _sync(temporary)
        replaced: list[tuple[Path, Path | None]] = []
        try:
            for current, temporary in zip(places, temporaries, strict=True):
                old = _second_name(current) if len(places) > 1 else None
                replaced.append((current, old))
                _take_place(temporary, current)
        except OSError:
            for place, old in replaced[:-1]:
                place.unlink() if old is None else _take_place(old, place)
            raise
        finally:
            for _, old in replaced:
                if old is not None:
                    old.unlink(missing_ok=True)
        for folder in {place.parent for place in places}:
            sync_folder(folder)
    except OSError as error:
        raise explain(error, current) from error
    finally:
        for temporary in temporaries:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)


def _beside(path: Path) -> Path:
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")


def _sweep(path: Path) -> None:
    """Remove what killed processes have left beside a file, some time ago: others may be writing it now."""
    for old in left_behind(path):
        with contextlib.suppress(OSError):
            if old.stat().st_mtime < time.time() - 3600:
                old.unlink()


def left_behind(path: Path) -> list[Path]:
    """What is half written of a file: by a process at work, or by one that was killed."""
    return list(path.parent.glob(f".{glob.escape(path.name)}.*.tmp")) if path.parent.is_dir() else []


def _second_name(path: Path) -> Path | None:
    """Another name for what is at a path, so that it can come back; None if nothing is there."""
    if not path.exists():
        return None
    other = _beside(path)
    try:
        other.hardlink_to(path)
    except OSError:  # a file system without hard links
        shutil.copy2(path, other)
    return other


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


ON_WINDOWS = os.name == "nt"
HELD_ON_WINDOWS = (5, 32, 33)  # what replacing a file says there while somebody has it open
PATIENCE = 2.0  # seconds for which a scanner of viruses or an index may have a new file open
DEVICES = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9\u00b9\u00b2\u00b3])\s*(\..*)?", re.IGNORECASE)


def _take_place(temporary: Path, place: Path) -> None:
    """Rename a file; on Windows, wait a little for whoever has one of the two open just now."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            temporary.replace(place)
            return
        except PermissionError as error:
            is_held = getattr(error, "winerror", None) in HELD_ON_WINDOWS
            if not is_held or time.monotonic() > end:
                raise
        time.sleep(0.05)


def _refuse_device(path: Path) -> None:
    """Raise for names that Windows gives to devices or shortens: what is written there would be lost."""
    name = path.name
    if ON_WINDOWS and (DEVICES.fullmatch(name) or name != name.rstrip(". ") or set(name) & set('<>:"|?*')):
        raise OSError(
            errno.EINVAL, f"can't write {str(path)!r}: Windows has no files of that name; choose another"
        )


def explain(error: OSError, path: Path) -> OSError:
    """The same kind of error with a message that says what could not be written and the way out."""
    reasons = {
        errno.ENOSPC: "the disk is full; free some space or choose another place",
        errno.EDQUOT: "your quota is used up; free some space or choose another place",
        errno.EFBIG: "the file would be larger than allowed here; choose another place",
        errno.EROFS: "the disk can't be written; choose another place",
        errno.EACCES: "you have no permission; choose another place",
        errno.EPERM: "you have no permission; choose another place",
        errno.ENOENT: "its folder does not exist; make it first",
        errno.ENOTDIR: "its folder is no folder; choose another place",
        errno.EISDIR: "it is a folder; name a file in it",
        errno.EINVAL: "its name isn't allowed there; choose another one",
        errno.ENAMETOOLONG: "its name is too long; choose a shorter one",
    }
    reason = reasons.get(error.errno or 0, error.strerror or str(error))
    if getattr(error, "winerror", None) in HELD_ON_WINDOWS:
        reason = "another program has it open; close it there or choose another place"
    stays = "; the file that was there is untouched" if path.is_file() else ""
    message = f"can't write {str(path)!r}: {reason}{stays}"
    return type(error)(error.errno, message) if error.errno else OSError(message)


def sync_folder(folder: Path) -> None:
    """Make a rename in a folder durable; nothing where the system has no such call."""
    if ON_WINDOWS:
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError:  # some network file systems can't
        pass
    finally:
        os.close(descriptor)


class FileLock:
    """An advisory lock on a name, held until `release` or the end of the process, however that ends.

    It lies in a file of its own, ``<name>.lock``, because closing any descriptor of a database would
    drop the locks that SQLite holds on it. Links are followed first: all ways to a name are one.
    """

    def __init__(self, path: Path) -> None:
        path = real(path)
        self.path = path.with_name(path.name + ".lock")
        self._descriptor: int | None = None

    def acquire(self) -> str:
        """Take the lock; "" if that worked, else who has it.

        Raises
        ------
        OSError
            The folder can't be written, or its file system has no locks.
        """
        for _ in range(100):
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                is_free = _try_lock(descriptor)
            except OSError:
                os.close(descriptor)
                with contextlib.suppress(OSError):
                    self.path.unlink()
                raise
            if not is_free:
                holder = _describe(descriptor)
                os.close(descriptor)
                return holder
            try:
                is_current = os.fstat(descriptor).st_ino == self.path.stat().st_ino
            except FileNotFoundError:
                is_current = False
            if is_current or ON_WINDOWS:
                with contextlib.suppress(OSError):  # who has it is only told; the disk may be full
                    os.ftruncate(descriptor, 0)
                    os.lseek(descriptor, 0, os.SEEK_SET)
                    os.write(descriptor, json.dumps(this_process()).encode())
                self._descriptor = descriptor
                return ""
            os.close(descriptor)  # its owner has just removed it: take the next one
        return "a process that comes and goes"

    def release(self) -> None:
        """Give the lock back."""
        if self._descriptor is None:
            return
        with contextlib.suppress(OSError):
            if not ON_WINDOWS and os.path.samestat(os.fstat(self._descriptor), self.path.stat()):
                self.path.unlink()
        os.close(self._descriptor)
        self._descriptor = None
        if ON_WINDOWS:  # which removes no file that anybody has open
            with contextlib.suppress(OSError):
                self.path.unlink()


class Handle:
    """A file that is kept in hand: it stays the same file, whatever happens to its names.

    Parameters
    ----------
    path : Path
        To be closed last of all that this process has open of it: closing any descriptor of a file drops
        the locks that SQLite holds on it.
    """

    def __init__(self, path: Path) -> None:
        # on Windows an open file could not be replaced
        self._descriptor: int | None = None if ON_WINDOWS else os.open(path, os.O_RDWR)

    def lock(self) -> bool:
        """Take the lock that all names of the file share; False if somebody has it.

        True where the system has no such lock: names are locked anyway, see `FileLock`.
        """
        return self._descriptor is None or _try_lock_all_names(self._descriptor)

    def is_same(self, found: os.stat_result) -> bool:
        """Whether what was found at some path is this file."""
        return self._descriptor is None or os.path.samestat(os.fstat(self._descriptor), found)

    @property
    def has_a_name(self) -> bool:
        """Whether it still lies in some folder."""
        return self._descriptor is None or os.fstat(self._descriptor).st_nlink > 0

    def sync(self) -> None:
        """Bring what was written to the disk."""
        if self._descriptor is not None:
            os.fsync(self._descriptor)

    def close(self) -> None:
        """Let go of it and of its lock."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None


def this_process() -> dict[str, object]:
    """By which others may know who has a lock."""
    return {"process": os.getpid(), "computer": socket.gethostname()}


def spoken_process(who: str, text: str | bytes) -> str:
    """Who wrote what `this_process` says, as JSON; ``who`` alone where it can't be read."""
    try:
        data = json.loads(text)
        return f"{who} (process {int(data['process'])} on {str(data['computer'])[:60]!r})"
    except (ValueError, TypeError, KeyError):
        return who


def _describe(descriptor: int) -> str:
    who = "another kernel or script"
    try:
        os.lseek(descriptor, 0, os.SEEK_SET)
        return spoken_process(who, os.read(descriptor, 500))
    except OSError:
        return who


def _try_lock_all_names(descriptor: int) -> bool:
    """Lock one byte far behind the end, which no reader or database ever touches."""
    if sys.platform != "linux":
        return True
    import fcntl

    wanted = struct.pack("hhqqi4x", fcntl.F_WRLCK, os.SEEK_SET, 1 << 60, 1, 0)
    try:
        fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, wanted)
    except OSError as error:
        return error.errno not in (errno.EAGAIN, errno.EACCES)
    return True


def _try_lock(descriptor: int) -> bool:
    if ON_WINDOWS:
        windows = importlib.import_module("msvcrt")
        try:
            os.lseek(descriptor, 1 << 20, os.SEEK_SET)  # beyond the description, which others may read
            windows.locking(descriptor, windows.LK_NBLCK, 1)
        except OSError:
            return False
        os.lseek(descriptor, 0, os.SEEK_SET)
        return True
    posix = importlib.import_module("fcntl")
    try:
        posix.flock(descriptor, posix.LOCK_EX | posix.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES, errno.EAGAIN):
            return False
        raise
    return True
