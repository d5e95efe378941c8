"""E57, by the library of that name (extra ``e57``), the poses of its scans applied."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from scenewidget.engine.mesh import FloatArray, MeshError
from scenewidget.engine.readers.colors import as_bytes
from scenewidget.engine.readers.scan import Notes, Scan

__all__ = ["read"]

SPACE = "{http://www.astm.org/COMMIT/E57/2010-e57-v1.0}"


def read(path: Path, notes: Notes) -> Scan:
    """Points of the E57 at ``path``; ``notes`` hear what was guessed or lost."""
    with path.open("rb") as file:
        head = file.read(48)
    promised = struct.unpack_from("<Q", head, 16)[0] if len(head) == 48 else 0
    if promised != path.stat().st_size:
        raise MeshError(
            f"{path.name!r} is damaged or truncated: its header promises {promised} bytes, it has "
            f"{path.stat().st_size}"
        )
    try:
        import e57
    except ImportError:
        raise MeshError(f'{path.name!r} is E57: `pip install "scenewidget[e57]"` lets it be read') from None
    try:
        found = e57.read_points(str(path))
    except BaseException as error:  # a panic of its Rust is no Exception
        if isinstance(error, (KeyboardInterrupt, SystemExit)):
            raise
        raise MeshError(f"{path.name!r} is damaged: {error!s:.200}") from None
    scan = Scan(np.asarray(found.points, dtype=np.float64).reshape(-1, 3))
    colors = np.asarray(getattr(found, "color", None) if getattr(found, "color", None) is not None else [])
    if colors.size and colors.reshape(-1, 3).shape[0] == len(scan.vertices):
        scan.colors = as_bytes(colors.reshape(-1, 3), notes)
    scan.viewpoint = _stations(e57.raw_xml(str(path)), len(scan.vertices))
    return scan


def _stations(xml: Any, n: int) -> FloatArray | None:
    """(n, 3) where the scanner stood for each point, where the file gives the pose of all its scans."""
    try:
        root: Any = ElementTree.fromstring(xml)
        scans = root.findall(f"{SPACE}data3D/{SPACE}vectorChild")
        counts = [int(scan.find(f"{SPACE}points").get("recordCount")) for scan in scans]
        places = [
            [float(scan.find(f"{SPACE}pose/{SPACE}translation/{SPACE}{axis}").text or 0) for axis in "xyz"]
            for scan in scans
        ]
    except (ElementTree.ParseError, AttributeError, TypeError, ValueError):
        return None
    if sum(counts) != n or not np.isfinite(places).all():  # some points were said to be invalid
        return None
    return np.repeat(np.array(places, dtype=np.float64).reshape(-1, 3), counts, axis=0)
