"""STL, text and binary: triangles with corners of their own, and the colours that VisCAM and Magics put in.

3D Systems (1988). Vertex 3f + k is corner k of face f.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from scenewidget.engine.mesh import IntArray, MeshError
from scenewidget.engine.readers.colors import at_vertices
from scenewidget.engine.readers.scan import ByteArray, Notes, Scan
from scenewidget.engine.readers.text import numbers

__all__ = ["read"]

LAYOUT = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("color", "<u2")])


def read(path: Path, notes: Notes) -> Scan:
    """Triangles of an STL at ``path``; ``notes`` hear what was guessed or lost."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if 84 + 50 * count <= len(data) and (count or len(data) == 84):
        table = np.frombuffer(data, LAYOUT, count=count, offset=84)
        if len(data) > 84 + 50 * count:
            notes.say(f"{len(data) - 84 - 50 * count} bytes behind the last face were left out")
        scan = Scan(table["corners"].reshape(-1, 3).astype(np.float64), is_single=True)
        scan.corners = np.arange(3 * count)
        scan.colors = _colors(data[:80], table["color"], scan.corners, notes)
        return scan
    if data.lstrip()[:5].lower() != b"solid":
        raise MeshError(
            f"{path.name!r} is damaged or truncated: its header promises {count} faces "
            f"in {84 + 50 * count} bytes, and it has {len(data)}"
        )
    if b"endsolid" not in data[-1024:].lower():
        raise MeshError(f"{path.name!r} is truncated: it does not end with 'endsolid'")
    words = re.findall(rb"^\s*vertex\s([^\n\r]*)", data, re.MULTILINE | re.IGNORECASE)
    n_facets = len(re.findall(rb"^\s*endfacet", data, re.MULTILINE | re.IGNORECASE))
    if len(words) != 3 * n_facets or not words:  # several on a line
        words = re.findall(rb"\bvertex((?:\s+[^\s]+){3})", data, re.IGNORECASE)
        n_facets = len(re.findall(rb"\bendfacet\b", data, re.IGNORECASE))
    values = numbers(b"\n".join(words))
    if len(values) != 9 * n_facets:
        raise MeshError(
            f"{path.name!r} is damaged: it has {len(words)} corners with {len(values)} coordinates for "
            f"{n_facets} faces"
        )
    scan = Scan(values.reshape(-1, 3))
    scan.corners = np.arange(len(scan.vertices))
    return scan


def _colors(head: bytes, words: IntArray, corners: IntArray, notes: Notes) -> ByteArray | None:
    """(n_corners, 3) of the five bits a channel in the last word of each face; None where nobody set them."""
    is_magics = b"COLOR=" in head
    is_own = (words & 0x8000 == 0) if is_magics else (words & 0x8000 != 0)
    if not is_own.any() or (not is_magics and not is_own.all()):
        return None
    levels = np.stack([words & 31, words >> 5 & 31, words >> 10 & 31], axis=1)
    faces = np.round(levels[:, :: 1 if is_magics else -1] * (255 / 31)).astype(np.uint8)
    if is_magics:
        at = head.index(b"COLOR=") + 6
        faces[~is_own] = np.frombuffer(head[at : at + 3].ljust(3, b"\xff"), np.uint8)
    notes.say(f"colours of the faces were read as {'Magics' if is_magics else 'VisCAM'} writes them")
    return at_vertices(corners, np.repeat(faces, 3, axis=0), len(corners))
