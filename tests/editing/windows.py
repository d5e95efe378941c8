"""Windows as far as files are concerned, on Linux: what Microsoft and Python document, for this process.

A file that is open can be neither replaced nor removed, there is no ``fcntl``, locks are those of ``msvcrt``,
lines would end in two characters, and names of devices are no names. SQLite's own calls are those of Linux.
"""

import errno
import os
import sys
from pathlib import Path
from types import SimpleNamespace

from scenewidget.editing import files


class SharingError(PermissionError):
    """What Windows says to whoever replaces or removes a file that is open."""

    winerror = 32


def is_open(path):
    """Whether this process has a file open, SQLite's descriptors included."""
    try:
        wanted = Path(path).stat()
    except OSError:
        return False
    for descriptor in Path("/proc/self/fd").iterdir():
        try:
            found = os.fstat(int(descriptor.name))
        except OSError:
            continue
        if os.path.samestat(found, wanted):
            return True
    return False


def pretend(monkeypatch):
    """Make this process believe it, until the test ends; returns what was refused."""
    refused = []

    def guarded(real):
        def call(*paths, **options):
            for path in paths:
                if is_open(path):
                    refused.append(Path(path).name)
                    raise SharingError(errno.EACCES, "the process cannot access the file", str(path))
            return real(*paths, **options)

        return call

    for name in ("replace", "rename", "unlink", "remove"):
        monkeypatch.setattr(os, name, guarded(getattr(os, name)))
    held = {}

    def locking(descriptor, _, n_bytes):
        found, at = os.fstat(descriptor), os.lseek(descriptor, 0, os.SEEK_CUR)
        assert (at, n_bytes) == (1 << 20, 1), "others read what stands before"
        holder = Path(f"/proc/self/fd/{held.get((found.st_dev, found.st_ino), descriptor)}")
        if holder.name != str(descriptor) and holder.exists() and os.path.samestat(holder.stat(), found):
            raise OSError(errno.EDEADLOCK, "locked")
        held[found.st_dev, found.st_ino] = descriptor

    monkeypatch.setitem(sys.modules, "msvcrt", SimpleNamespace(locking=locking, LK_NBLCK=2))
    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setattr(os, "linesep", "\r\n")
    monkeypatch.setattr(files, "ON_WINDOWS", True)
    monkeypatch.setattr(files, "PATIENCE", 0.0)
    return refused
