"""LAS and LAZ, by laspy and lazrs (extra ``las``)."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from scenewidget.engine.mesh import MeshError
from scenewidget.engine.readers.colors import as_bytes
from scenewidget.engine.readers.scan import Notes, Scan, check_promise, check_size

__all__ = ["read"]

VLR, EVLR = 54, 60  # bytes that a record takes at least


def read(path: Path, notes: Notes) -> Scan:
    """Points of the LAS or LAZ at ``path``; ``notes`` hear what was guessed or lost."""
    _check(path)
    try:
        import laspy
    except ImportError:
        raise MeshError(
            f'{path.name!r} is LAS or LAZ: `pip install "scenewidget[las]"` lets it be read'
        ) from None
    las = laspy.read(path)
    if len(las.points) == 0:
        raise MeshError(f"{path.name!r} holds no points")
    scan = Scan(np.stack([np.asarray(las[axis], dtype=np.float64) for axis in "xyz"], axis=1))
    if {"red", "green", "blue"} <= set(las.point_format.dimension_names):
        colors = np.stack([np.asarray(las[name]) for name in ("red", "green", "blue")], axis=1)
        scan.colors = as_bytes(colors, notes) if colors.any() else None
    return scan


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
    else:
        check_promise(path, "points", count, max(length, 20), max(size - start, 0))
