"""What tells a file of ours from another one: a seal in it, a digest of all that it holds.

An export replaces what an export wrote, and nothing else: not the scan, not labels that somebody made or
corrected by hand. Formats with room for a remark carry the seal; for the others the file system keeps it
where it can, and this process remembers what it wrote. Files of one export carry the same set number, so that
two halves of different exports aren't taken for one.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from scenewidget.editing.files import real, replacing_all
from scenewidget.editing.formats.common import FormatError
from scenewidget.engine.checks import checked_flag

__all__ = ["SEAL", "Contents", "check_one_set", "write_files"]

Contents = Mapping[Path, Sequence[bytes | memoryview]]  # of files: what they hold, in pieces

DIGITS = 32
SEAL = f"scenewidget-seal:{'0' * DIGITS}:{'0' * DIGITS}"  # to be put into a file; its set, and its own digest
_SEAL = re.compile(rb"scenewidget-seal:([0-9a-f]{32}):([0-9a-f]{32})")
ROOM = 100_000  # bytes at both ends of a file where a seal is looked for
ATTRIBUTE = "user.scenewidget.seal"
_written: dict[tuple[int, int], tuple[int, int]] = {}  # by this process: device and number -> size and time


def write_files(contents: Contents, *, asked: Path, overwrite: bool, inputs: Sequence[str]) -> list[Path]:
    """Write the files of one export, all or none.

    Parameters
    ----------
    contents : mapping of Path to sequence of bytes
    asked : Path
        What was asked for; the others are named after it.
    overwrite : bool
        Whether files may be replaced that no export wrote.
    inputs : sequence of str
        Where the scan was loaded from; "" counts for nothing.

    Returns
    -------
    paths : list of Path

    Raises
    ------
    FileExistsError
        One is there that no export wrote, or that is the scan; nothing was written.
    OSError
        Disk full, no permission, …; nothing was written.
    """
    paths = list(contents)
    if not checked_flag("overwrite", overwrite):
        for path in paths:
            _check_free(path, asked, inputs)
    whole = hashlib.blake2b(digest_size=DIGITS // 2)
    for pieces in contents.values():
        for piece in pieces:
            whole.update(piece)
    with replacing_all(paths) as temporaries:
        for pieces, temporary in zip(contents.values(), temporaries, strict=True):
            sealed, digest = _sealed(pieces, whole.hexdigest())
            with temporary.open("wb") as file:
                for piece in sealed:
                    file.write(piece)
            with contextlib.suppress(OSError, AttributeError):  # not every system has them
                os.setxattr(temporary, ATTRIBUTE, digest.encode())
    for path in paths:
        found = path.stat()
        _written[found.st_dev, found.st_ino] = (found.st_size, found.st_mtime_ns)
    return paths


def check_one_set(*paths: Path) -> None:
    """Whether files belong to one export, as far as they say.

    Raises
    ------
    FormatError
        They are of different ones.
    """
    found = {seal[1] for seal in map(_seal_in, paths) if seal is not None}
    if len(found) > 1:
        names = " and ".join(repr(path.name) for path in paths)
        raise FormatError(f"{names} are of different exports, one of which was interrupted; export again")


def _check_free(path: Path, asked: Path, inputs: Sequence[str]) -> None:
    if not os.path.lexists(path):
        return
    beside = "" if path == asked else f" (written along with {asked.name!r})"
    way_out = "choose another name, or replace it with overwrite=True"
    if any(_is_same(path, source) for source in inputs):
        raise FileExistsError(errno.EEXIST, f"{str(path)!r}{beside} is the scan itself; {way_out}")
    if real(path).is_dir():
        raise IsADirectoryError(errno.EISDIR, f"{str(path)!r} is a folder; name a file in it")
    if path.exists() and not _is_ours(path):
        raise FileExistsError(
            errno.EEXIST, f"{str(path)!r}{beside} is there, and no export wrote it; {way_out}"
        )


def _is_same(path: Path, source: str) -> bool:
    try:
        return source != "" and path.samefile(source)
    except OSError:
        return False


def _is_ours(path: Path) -> bool:
    """Whether an export wrote this file and nobody has changed it since."""
    found = path.stat()
    if _written.get((found.st_dev, found.st_ino)) == (found.st_size, found.st_mtime_ns):
        return True
    seal = _seal_in(path)
    if seal is not None:
        said = seal[2].decode()
    else:
        try:
            said = os.getxattr(path, ATTRIBUTE).decode(errors="replace")
        except (OSError, AttributeError):
            return False
    data = path.read_bytes()
    return said == _digest([data if seal is None else data.replace(seal[2], b"0" * DIGITS, 1)])


def _sealed(pieces: Sequence[bytes | memoryview], set_: str) -> tuple[list[bytes | memoryview], str]:
    """The pieces with set and digest where they have room for a seal, and the digest."""
    empty = SEAL.encode()
    opened = empty.replace(b"0" * DIGITS, set_.encode(), 1)
    out = [piece.replace(empty, opened, 1) if isinstance(piece, bytes) else piece for piece in pieces]
    digest = _digest(out)
    closed = opened[:-DIGITS] + digest.encode()
    return [piece.replace(opened, closed, 1) if isinstance(piece, bytes) else piece for piece in out], digest


def _digest(pieces: Sequence[bytes | memoryview]) -> str:
    digest = hashlib.blake2b(digest_size=DIGITS // 2)
    for piece in pieces:
        digest.update(piece)
    return digest.hexdigest()


def _seal_in(path: Path) -> re.Match[bytes] | None:
    """The first seal near the beginning or the end of a file."""
    try:
        with path.open("rb") as file:
            found = _SEAL.search(file.read(ROOM))
            if found is None:
                file.seek(max(0, path.stat().st_size - ROOM))
                found = _SEAL.search(file.read(ROOM))
    except FileNotFoundError:
        return None
    return found
