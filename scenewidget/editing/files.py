"""Files that are there whole or not at all, and locks that tell who is at work.

A file is written beside its destination, flushed to the disk, and renamed over it: whatever happens, the
destination holds the old file or the new one.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import secrets
import socket
import time
from collections.abc import Iterator
from pathlib import Path

__all__ = ["FileLock", "checked_path", "explain", "replacing", "sync_folder"]


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


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path beside ``path`` to write to; becomes ``path`` when the block ends well.

    Raises
    ------
    OSError
        The folder can't be written, the disk is full, …; the message says what stays.
    """
    leftovers = path.parent.glob(f".{path.name}.*.tmp") if path.parent.is_dir() else ()
    for old in leftovers:  # of a process that was killed
        with contextlib.suppress(OSError):
            if old.stat().st_mtime < time.time() - 3600:
                old.unlink()
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        yield temporary
        descriptor = os.open(temporary, os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        temporary.replace(path)
        sync_folder(path.parent)
    except OSError as error:
        raise explain(error, path) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


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
    }
    reason = reasons.get(error.errno or 0, error.strerror or str(error))
    stays = "; the file that was there is untouched" if path.is_file() else ""
    message = f"can't write {str(path)!r}: {reason}{stays}"
    return type(error)(error.errno, message) if error.errno else OSError(message)


def sync_folder(folder: Path) -> None:
    """Make a rename in a folder durable; nothing where the system has no such call."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError:  # some network file systems can't
        pass
    finally:
        os.close(descriptor)


class FileLock:
    """An advisory lock on a file, held until `release` or the end of the process, however that ends.

    It lies in a file of its own, ``<name>.lock``, because closing any descriptor of a database would
    drop the locks that SQLite holds on it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path.with_name(path.name + ".lock")
        self._descriptor: int | None = None

    def acquire(self) -> str:
        """Take the lock; "" if that worked, else who has it.

        Raises
        ------
        OSError
            The folder can't be written.
        """
        for _ in range(100):
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
            if not _try_lock(descriptor):
                holder = _describe(descriptor)
                os.close(descriptor)
                return holder
            try:
                is_current = os.fstat(descriptor).st_ino == self.path.stat().st_ino
            except FileNotFoundError:
                is_current = False
            if is_current or os.name != "posix":
                os.ftruncate(descriptor, 0)
                os.lseek(descriptor, 0, os.SEEK_SET)
                os.write(descriptor, json.dumps(_self_description()).encode())
                self._descriptor = descriptor
                return ""
            os.close(descriptor)  # its owner has just removed it: take the next one
        return "a process that comes and goes"

    def release(self) -> None:
        """Give the lock back."""
        if self._descriptor is None:
            return
        with contextlib.suppress(OSError):
            if os.name == "posix":
                self.path.unlink(missing_ok=True)
        os.close(self._descriptor)
        self._descriptor = None


def _self_description() -> dict[str, object]:
    return {"process": os.getpid(), "computer": socket.gethostname()}


def _describe(descriptor: int) -> str:
    try:
        os.lseek(descriptor, 0, os.SEEK_SET)
        data = json.loads(os.read(descriptor, 500))
        process, computer = int(data["process"]), str(data["computer"])[:60]
    except (OSError, ValueError, TypeError, KeyError):
        return "another kernel or script"
    return f"another kernel or script (process {process} on {computer!r})"


if os.name == "posix":
    import fcntl

    def _try_lock(descriptor: int) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in (errno.EWOULDBLOCK, errno.EACCES, errno.EAGAIN):
                return False
            raise
        return True

else:

    def _try_lock(descriptor: int) -> bool:
        import importlib

        windows = importlib.import_module("msvcrt")
        try:
            os.lseek(descriptor, 1 << 20, os.SEEK_SET)  # beyond the description, which others may read
            windows.locking(descriptor, windows.LK_NBLCK, 1)
        except OSError:
            return False
        os.lseek(descriptor, 0, os.SEEK_SET)
        return True
