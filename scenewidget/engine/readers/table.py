"""Points in text: XYZ, PTS, ASC, CSV, a point a line, with colours or normals behind the coordinates."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from scenewidget.engine.mesh import FloatArray, MeshError
from scenewidget.engine.readers.colors import as_bytes
from scenewidget.engine.readers.scan import Notes, Scan
from scenewidget.engine.readers.text import numbers, row_lengths

__all__ = ["read"]

HEAD = 1 << 12  # bytes that tell how columns and decimals are written

NAMES = {  # that the columns of x, y, z, red, green, blue and the normal go by, in lower case
    **{name: name for name in ("x", "y", "z", "r", "g", "b", "nx", "ny", "nz")},
    **{f"{name}_coordinate": name for name in "xyz"},
    **{"red": "r", "green": "g", "blue": "b", "rf": "r", "gf": "g", "bf": "b"},
    **{f"normal{mark}{axis}": f"n{axis}" for axis in "xyz" for mark in ("", "_")},
}
PLACES = {  # of the columns where no line of names tells
    3: "x y z", 4: "x y z i", 6: "x y z r g b", 7: "x y z i r g b", 9: "x y z r g b nx ny nz",
    10: "x y z r g b i nx ny nz",
}  # fmt: skip


def read(path: Path, notes: Notes) -> Scan:
    """Points of the text at ``path``; ``notes`` hear what was guessed or lost."""
    data = path.read_bytes().removeprefix(b"\xef\xbb\xbf")
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    data = re.sub(rb"\A(?:[ \t]*(?:#(?![^\n]*[xX]\b)|//(?!\s*[xX]))[^\n]*\n|\s*\n)+", b"", data)
    first = data[: data.find(b"\n") if b"\n" in data else len(data)]
    names: list[str] = []
    if re.search(rb"[A-Za-z]", re.sub(rb"[eE][-+]?\d|nan|inf", b"", first)):
        words = re.split(r"[\s,;]+", first.decode("utf-8", "replace").strip().lstrip("#/ "))
        names = [NAMES.get(word.strip('"').lower(), "?") for word in words]
        data = data[len(first) :]
    sample = data[:HEAD]
    if b"," in sample and (b";" in sample or b"\t" in sample) and re.search(rb"\d,\d", sample):
        data = data.replace(b",", b".")  # decimals as half of Europe writes them
    for mark in (b";", b","):
        if mark in first:
            data = data.replace(mark, b" ")
    promised = None
    count = re.match(rb"\s*(\d{1,15})[ \t\r]*\n", data)
    if count is not None:  # PTS, and CloudCompare behind its names: the number of points
        promised, data = int(count[1]), data[count.end() :]
    try:
        values, width = numbers(data), row_lengths(data)
    except MeshError as error:
        raise MeshError(f"{path.name!r} {error}") from None
    if len(width) == 0:
        raise MeshError(f"{path.name!r} holds no points")
    if promised is not None and promised != len(width):
        raise MeshError(
            f"{path.name!r} is damaged or truncated: its first line promises {promised} points, "
            f"{len(width)} follow"
        )
    if (width != width[0]).any():
        row = int(np.flatnonzero(width != width[0])[0])
        raise MeshError(
            f"{path.name!r} is damaged or truncated: line {row + 1} of its points has {width[row]} numbers, "
            f"the first has {width[0]}"
        )
    table = values.reshape(-1, width[0])
    names = names or PLACES.get(int(width[0]), "x y z").split()
    column = {name: table[:, k] for k, name in reversed(list(enumerate(names[: width[0]])))}
    if any(axis not in column for axis in "xyz"):
        raise MeshError(f"{path.name!r} has no columns x, y and z, but {', '.join(names)[:200]}")
    if width[0] == 6 and names == PLACES[6].split() and _are_normals(table[:, 3:6]):
        notes.say("columns 4 to 6 were taken as normals: they have the length 1")
        column = {**column, "nx": table[:, 3], "ny": table[:, 4], "nz": table[:, 5]}
        del column["r"]
    scan = Scan(np.stack([column[axis] for axis in "xyz"], axis=1))
    if all(name in column for name in ("nx", "ny", "nz")):
        scan.normals = np.stack([column[name] for name in ("nx", "ny", "nz")], axis=1)
    if all(name in column for name in "rgb"):
        scan.colors = as_bytes(np.stack([column[name] for name in "rgb"], axis=1), notes)
    return scan


def _are_normals(values: FloatArray) -> bool:
    some = values[:: max(1, len(values) // 10_000)]
    length = np.linalg.norm(some, axis=1)
    return bool(some.min(initial=0) < 0 and np.mean(np.abs(length - 1) < 0.02) > 0.9)
