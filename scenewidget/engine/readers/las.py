"""LAS and LAZ, by laspy and lazrs (extra ``las``)."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.engine.mesh import MeshError
from scenewidget.engine.readers.colors import as_bytes
from scenewidget.engine.readers.scan import Notes, Scan, check_promise, check_size

__all__ = ["columns_of", "read"]

VLR, EVLR = 54, 60  # bytes that a record takes at least
LEAST_POINT = 20  # bytes of the smallest point, with which each chunk of a LAZ begins


def read(path: Path, notes: Notes) -> Scan:
    """Points of the LAS or LAZ at ``path``; ``notes`` hear what was guessed or lost."""
    las = _open(path)
    scan = Scan(np.stack([np.asarray(las[axis], dtype=np.float64) for axis in "xyz"], axis=1))
    if {"red", "green", "blue"} <= set(las.point_format.dimension_names):
        colors = np.stack([np.asarray(las[name]) for name in ("red", "green", "blue")], axis=1)
        scan.colors = as_bytes(colors, notes) if colors.any() else None
    return scan


def columns_of(path: Path) -> dict[str, Any]:
    """All numbers a point of the LAS or LAZ at ``path`` by their names, extra ones too."""
    las = _open(path)
    names = [name for name in las.point_format.dimension_names if name.lower() not in "xyz"]
    return {name: np.asarray(las[name]) for name in ("x", "y", "z", *names)}


def _open(path: Path) -> Any:
    _check(path)
    try:
        import laspy
    except ImportError:
        raise MeshError(
            f'{path.name!r} is LAS or LAZ: `pip install "scenewidget[las]"` lets it be read'
        ) from None
    # not by threads: they believe the sizes in the table of chunks, and a forged one ends the process
    try:
        las = laspy.read(path, laz_backend=laspy.LazBackend.Lazrs)
    except BaseException as error:  # a panic of its Rust is no Exception
        if isinstance(error, (KeyboardInterrupt, SystemExit)):
            raise
        raise MeshError(f"{path.name!r} is damaged: {error!s:.200}") from None
    if len(las.points) == 0:
        raise MeshError(f"{path.name!r} holds no points")
    return las


def _check(path: Path) -> None:
    """Hold what the header promises against the file: libraries read half of a cut one without a word."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(375)
    if len(head) < 227:
        raise MeshError(f"{path.name!r} is truncated inside its header")
    start, kind, length, count = struct.unpack_from("<I4xBHI", head, 96)
    if head[25] >= 4 and len(head) >= 255:
        count = max(count, struct.unpack_from("<Q", head, 247)[0])
    check_promise(
        path, "records of its header", struct.unpack_from("<I", head, 100)[0], VLR, min(start, size)
    )
    if head[25] >= 4 and len(head) >= 247:
        check_promise(path, "records at its end", struct.unpack_from("<I", head, 243)[0], EVLR, size)
    check_size(path, "points", count * 32)
    if kind & 0x80:  # compressed: a point takes at least a fraction of a byte
        check_promise(path, "points", count, 1, 64 * max(size - start, 0))
        _check_chunks(path, start, size)
    else:
        check_promise(path, "points", count, max(length, LEAST_POINT), max(size - start, 0))


def _check_chunks(path: Path, start: int, size: int) -> None:
    """Hold the number of chunks against the file: a library that believes it asks for all their memory."""
    with path.open("rb") as file:
        file.seek(start)
        at = int.from_bytes(file.read(8), "little", signed=True)
        if at == -1:  # written by a program that couldn't go back: it stands at the end
            file.seek(max(size - 8, 0))
            at = int.from_bytes(file.read(8), "little", signed=True)
        if not start <= at <= size - 8:
            raise MeshError(
                f"{path.name!r} is damaged or truncated: its table of chunks is not where it says"
            )
        file.seek(at + 4)
        n_chunks = int.from_bytes(file.read(4), "little")
    check_promise(path, "chunks", n_chunks, LEAST_POINT, size - start)
