"""PCD of the Point Cloud Library: text, binary and compressed.

https://pointclouds.org/documentation/tutorials/pcd_file_format.html; the compression is LibLZF's.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import MeshError
from scenewidget.engine.readers.colors import as_bytes, unpacked
from scenewidget.engine.readers.scan import Notes, Scan, check_promise, check_size
from scenewidget.engine.readers.text import numbers

__all__ = ["columns_of", "read"]

HEADER = 1 << 16  # bytes
MOST_SQUEEZED = 300  # bytes that a byte of LZF can stand for, generously
NAMES = (
    "VERSION",
    "COLUMNS",
    "FIELDS",
    "SIZE",
    "TYPE",
    "COUNT",
    "WIDTH",
    "HEIGHT",
    "VIEWPOINT",
    "POINTS",
    "DATA",
)


def read(path: Path, notes: Notes) -> Scan:
    """Points of the PCD at ``path``; ``notes`` hear what was guessed or lost."""
    columns, head, form = _columns(path)
    if any(axis not in columns for axis in "xyz"):
        raise MeshError(f"{path.name!r} has no fields x, y and z, only {', '.join(columns)[:200]}")
    scan = Scan(np.stack([columns[axis] for axis in "xyz"], axis=1, dtype=np.float64), is_single=True)
    if all(f"normal_{axis}" in columns for axis in "xyz"):
        scan.normals = np.stack([columns[f"normal_{axis}"] for axis in "xyz"], axis=1)
    scan.colors = _colors(columns, form, notes)
    view = numbers(" ".join(head.get("VIEWPOINT", [])).encode())
    is_organized = int(head["HEIGHT"][0]) > 1
    if len(view) >= 3 and np.isfinite(view[:3]).all() and (is_organized or view[:3].any()):
        scan.viewpoint = view[:3]  # of a frame of a depth camera its own origin
    return scan


def columns_of(path: Path) -> dict[str, Any]:
    """All fields of the PCD at ``path`` by their names; of those that hold several numbers the first."""
    return _columns(path)[0]


def _columns(path: Path) -> tuple[dict[str, Any], dict[str, list[str]], str]:
    """Fields by name, the header, and the form of the data."""
    data = path.read_bytes()
    head, start = _header(path, data)
    fields, n = [name.lower() for name in head["FIELDS"]], int(head["POINTS"][0])
    counts = [int(c) for c in head.get("COUNT", ["1"] * len(fields))]
    kinds = [t.lower() + s for t, s in zip(head["TYPE"], head["SIZE"])]
    if not len(fields) == len(kinds) == len(counts) or not set(kinds) <= {
        "f4", "f8", "u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8"
    } or not all(0 < c <= 4096 for c in counts):  # fmt: skip
        raise MeshError(f"{path.name!r} is damaged: its FIELDS, SIZE, TYPE and COUNT don't fit each other")
    sizes = [np.dtype(kind).itemsize * count for kind, count in zip(kinds, counts)]
    form = head["DATA"][0].lower()
    check_size(path, "points", n * sum(sizes))
    if form == "ascii":
        columns = _text(path, data[start:], fields, counts, n)
    elif form == "binary":
        check_promise(path, "points", n, sum(sizes), len(data) - start)
        layout = np.dtype([(f"{k}", f"<{kind}", (c,)) for k, (kind, c) in enumerate(zip(kinds, counts))])
        block = np.frombuffer(data, layout, count=n, offset=start)
        columns = {name: block[f"{k}"][:, 0] for k, name in reversed(list(enumerate(fields)))}
    elif form == "binary_compressed":
        columns = _squeezed(path, data[start:], fields, kinds, sizes, counts, n)
    else:
        raise MeshError(f"{path.name!r} has data of the form {form[:40]!r}, which PCD doesn't know")
    return columns, head, form


def _header(path: Path, data: bytes) -> tuple[dict[str, list[str]], int]:
    found = re.search(rb"^[ \t]*DATA[ \t]+\w+[ \t]*\r?\n", data[:HEADER], re.MULTILINE)
    if found is None:
        raise MeshError(f"{path.name!r} is damaged or truncated: its PCD header has no line DATA")
    head: dict[str, list[str]] = {}
    for line in data[: found.end()].decode("ascii", "replace").splitlines():
        words = line.split()
        if words and words[0].upper() in NAMES:
            head["FIELDS" if words[0].upper() == "COLUMNS" else words[0].upper()] = words[1:]
    head.setdefault("HEIGHT", ["1"])
    head.setdefault("POINTS", head.get("WIDTH", ["?"]))
    for name in ("FIELDS", "SIZE", "TYPE", "POINTS", "HEIGHT"):
        if not head.get(name):
            raise MeshError(f"{path.name!r} is damaged: its PCD header has no {name}")
    for name in ("POINTS", "HEIGHT", "COUNT"):
        if not all(re.fullmatch(r"\d{1,15}", word) for word in head.get(name, [])):
            raise MeshError(f"{path.name!r} is damaged: {name} is {' '.join(head[name])[:60]!r}")
    return head, found.end()


def _text(path: Path, block: bytes, fields: list[str], counts: list[int], n: int) -> dict[str, Any]:
    width = sum(counts)
    check_promise(path, "points", n, width, len(block))
    values = numbers(block)
    if len(values) < n * width:
        raise MeshError(
            f"{path.name!r} is truncated: its header promises {n} points, {len(values) // width} are there"
        )
    rows = values[: n * width].reshape(n, width)
    starts = np.cumsum([0, *counts])[:-1]
    return {name: rows[:, at] for name, at in reversed(list(zip(fields, starts.tolist())))}


def _squeezed(
    path: Path, block: bytes, fields: list[str], kinds: list[str], sizes: list[int], counts: list[int], n: int
) -> dict[str, Any]:
    """Columns one after the other, compressed as a whole."""
    packed, whole = int.from_bytes(block[:4], "little"), int.from_bytes(block[4:8], "little")
    if len(block) < 8 + packed or whole != n * sum(sizes) or whole > MOST_SQUEEZED * packed + 64:
        raise MeshError(
            f"{path.name!r} is damaged or truncated: {n} points don't fit its {len(block)} compressed bytes"
        )
    out = np.zeros(whole, dtype=np.uint8)
    if _decompress(np.frombuffer(block, np.uint8, count=packed, offset=8), out) != whole:
        raise MeshError(f"{path.name!r} is damaged: its compressed data can't be unpacked")
    columns: dict[str, Any] = {}
    at = 0
    for name, kind, size, count in zip(fields, kinds, sizes, counts):
        found = out[at : at + n * size].view(f"<{kind}").reshape(n, count)[:, 0]
        columns.setdefault(name, found)
        at += n * size
    return columns


@kernel
def _decompress(data, out):  # type: ignore[no-untyped-def]
    """LZF (Lehmann): literal runs and references back; number of bytes written, -1 on damage."""
    i, o = 0, 0
    while i < len(data):
        control = int(data[i])
        i += 1
        if control < 32:
            length = control + 1
            if i + length > len(data) or o + length > len(out):
                return -1
            for k in range(length):
                out[o + k] = data[i + k]
            i += length
            o += length
            continue
        length = control >> 5
        if length == 7:
            if i >= len(data):
                return -1
            length += int(data[i])
            i += 1
        if i >= len(data):
            return -1
        back = o - ((control & 31) << 8) - int(data[i]) - 1
        i += 1
        length += 2
        if back < 0 or o + length > len(out):
            return -1
        for k in range(length):
            out[o + k] = out[back + k]
        o += length
    return o


def _colors(columns: dict[str, Any], form: str, notes: Notes) -> Any:
    """(n, 3) of fields r, g, b, or of one that packs them into the bits of a float or an integer."""
    for names in (("r", "g", "b"), ("red", "green", "blue")):
        if all(name in columns for name in names):
            return as_bytes(np.stack([columns[name] for name in names], axis=1), notes)
    packed = columns.get("rgb", columns.get("rgba"))
    if packed is None:
        return None
    values = np.array(packed)
    if form != "ascii":
        return unpacked(values)
    is_lost = np.isnan(values)  # what a float of 0xffRRGGBB looks like in text
    if is_lost.all():
        notes.say("colours were written as NaN and are lost: save the cloud as binary", warn=True)
        return None
    if is_lost.any():
        notes.say(f"{int(is_lost.sum())} of {len(values)} colours were written as NaN and are black")
        values[is_lost] = 0
    return unpacked(values.astype(np.int64) if np.abs(values).max() > 1 else values)
