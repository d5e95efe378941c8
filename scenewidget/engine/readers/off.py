"""OFF and its relatives with colours or normals at the vertices (COFF, NOFF, CNOFF) and colours at the faces.

Geomview's object file format.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from scenewidget.engine.mesh import MeshError
from scenewidget.engine.readers.colors import as_bytes, at_vertices
from scenewidget.engine.readers.scan import Notes, Scan, check_promise
from scenewidget.engine.readers.text import chunks, rows

__all__ = ["read"]


def read(path: Path, notes: Notes) -> Scan:
    """Vertices and polygons of an OFF at ``path``; ``notes`` hear what was guessed or lost."""
    data = path.read_bytes()
    if b"#" in data:
        data = re.sub(rb"#[^\n]*", b"", data)
    head = re.match(rb"\s*((ST)?(C)?(N)?(4)?(n)?OFF\b([ \t]+BINARY)?)?", _upper(data))
    if head is None or not (head[1] or re.match(rb"\s*\d", data)):
        raise MeshError(f"{path.name!r} does not start with 'OFF': it is not an OFF file, or damaged")
    if head[5] or head[6] or head[7]:
        raise MeshError(
            f"{path.name!r} is an OFF of a rare kind ({head[0].decode().strip()}): save it as PLY"
        )
    counts = re.compile(rb"\s*(\d{1,18})\s+(\d{1,18})(?:[ \t]+\d+)?[ \t\r]*(?:\n|$)").match(data, head.end())
    if counts is None:
        raise MeshError(
            f"{path.name!r} is damaged or truncated: the numbers of its vertices and faces are missing"
        )
    n_vertices, n_faces, room = int(counts[1]), int(counts[2]), len(data) - counts.end()
    check_promise(path, "vertices", n_vertices, 6, room + 1)
    check_promise(path, "faces", n_faces, 2, room + 1)
    values, width = rows(chunks(memoryview(data)[counts.end() :]))
    del data
    if len(width) < n_vertices + n_faces:
        raise MeshError(
            f"{path.name!r} is damaged or truncated: its header promises at least {n_vertices + n_faces} "
            f"lines, and it has {len(width)}"
        )
    start = np.cumsum(width) - width
    at, wide = start[:n_vertices], width[:n_vertices]
    least = 3 + 3 * (head[4] is not None)
    if wide.min(initial=least) < least:
        raise MeshError(f"{path.name!r} is damaged or truncated: a vertex has fewer than {least} numbers")
    scan = Scan(values[at[:, None] + np.arange(3)])
    if n_vertices and wide.min() >= least + 3:  # also where the head forgets the C
        scan.colors = as_bytes(values[at[:, None] + least + np.arange(3)], notes)
    at, wide = start[n_vertices : n_vertices + n_faces], width[n_vertices : n_vertices + n_faces]
    count = values[at]
    if not ((count >= 0) & (count == np.floor(count)) & (count < wide)).all():
        row = int(np.flatnonzero(~((count >= 0) & (count == np.floor(count)) & (count < wide)))[0])
        raise MeshError(
            f"{path.name!r} is damaged or truncated: face {row} has fewer corners than it promises"
        )
    count = count.astype(np.int32)
    if (count == 3).all():
        scan.corners = values[at[:, None] + np.arange(1, 4)].reshape(-1)
    else:
        scan.counts = count
        inside = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
        scan.corners = values[np.repeat(at, count) + 1 + inside]
    behind = wide - 1 - count
    has_color = behind >= 3
    if scan.colors is None and has_color.any():
        found = as_bytes(values[(at + 1 + count)[has_color, None] + np.arange(3)], notes)
        if found is not None:
            notes.say("colours stand at the faces: a vertex has the mean of those around it")
            if not has_color.all():
                notes.say(f"{int((~has_color).sum())} of {n_faces} faces have no colour and count as white")
            colors = np.full((n_faces, 3), 255, dtype=np.uint8)
            colors[has_color] = found
            corners = np.where(np.isfinite(scan.corners), scan.corners, -1).astype(np.int64)
            known = np.repeat(has_color, count)
            scan.colors = at_vertices(corners, np.repeat(colors, count, axis=0), n_vertices, is_known=known)
    return scan


def _upper(data: bytes) -> bytes:
    """The beginning, its keyword in capitals where a program wrote small letters."""
    return re.sub(rb"\A\s*(st)?c?n?off\b", lambda found: found[0].upper(), data[:64])
