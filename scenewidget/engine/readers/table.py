"""Points in text: XYZ, PTS, ASC, CSV, a point a line, with colours or normals behind the coordinates."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.engine.mesh import FloatArray, MeshError
from scenewidget.engine.readers.colors import as_bytes
from scenewidget.engine.readers.scan import Notes, Scan
from scenewidget.engine.readers.text import as_utf8, numbers, row_lengths

__all__ = ["columns_of", "read"]

HEAD = 1 << 12  # bytes that tell how columns and decimals are written
N_LOOKED_AT = 10_000  # rows that tell what a column without a name holds

_PLACE = r"(?:(?:pos|position|coord|coordinate|points?|p|world|global|local)[ _.:]?)?"
_NAMES = (  # that the columns of x, y, z, red, green, blue and the normal go by, in lower case
    *(
        (f"{_PLACE}{axis}(?:[ _]?(?:coord|coordinate|pos|position))?(?:_(?:mm|cm|m|ft|in))?", axis)
        for axis in "xyz"
    ),
    *((f"points?:{k}", axis) for k, axis in enumerate("xyz")),
    *((name, axis) for name, axis in zip(("easting", "northing", "elevation|height|altitude"), "xyz")),
    *((f"(?:colou?r[ _.:]?)?(?:{c}|{name})f?", c) for c, name in zip("rgb", ("red", "green", "blue"))),
    *((f"(?:rgb|colou?rs?):{k}", c) for k, c in enumerate("rgb")),
    *((f"n(?:ormals?)?[ _.:]?(?:{axis}|{k})", f"n{axis}") for k, axis in enumerate("xyz")),
)


@dataclass
class _Table:
    """Numbers in columns, and what the columns are called; nothing where no line of names tells."""

    values: FloatArray
    names: list[str] = field(default_factory=list)
    is_counted: bool = False
    unit: str = ""  # that stands behind the names


def read(path: Path, notes: Notes) -> Scan:
    """Points of the text at ``path``; ``notes`` hear what was guessed or lost."""
    table = _table(path)
    column = _roles(path, table, notes)
    if table.unit not in ("", "m"):
        notes.say(f'its columns are in {table.unit}, as their names say: units="{table.unit}"', warn=True)
    scan = Scan(np.stack([column[axis] for axis in "xyz"], axis=1))
    if all(name in column for name in ("nx", "ny", "nz")):
        scan.normals = np.stack([column[name] for name in ("nx", "ny", "nz")], axis=1)
    if all(name in column for name in "rgb"):
        scan.colors = as_bytes(np.stack([column[name] for name in "rgb"], axis=1), notes)
    return scan


def columns_of(path: Path) -> tuple[FloatArray, dict[str, Any]]:
    """(n_rows, n_columns) numbers of the text at ``path``, and its columns by name, where it names them."""
    table = _table(path)
    return table.values, {name: table.values[:, k] for k, name in reversed(list(enumerate(table.names)))}


def _table(path: Path) -> _Table:
    data = as_utf8(path.read_bytes())
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    unit = re.search(rb"^[^\n]*?[xX][^\n,;|\t]*?(?:[\[(] ?|_)(mm|cm|m|ft|in)\b", data[:HEAD])
    names, data = _names(data)
    mark = _mark(data)
    if mark in (b" ", b"\t") and re.search(rb"(?:^|\s)-?\d{1,3}(?:,\d{3})+\.\d", data[:HEAD]):
        raise MeshError(f"{path.name!r} writes thousands with commas: save it without them")
    if b"," in data[:HEAD] and mark != b"," and re.search(rb"\d,\d", data[:HEAD]):
        data = data.replace(b",", b".")  # decimals as half of Europe writes them
    promised, data = (None, data) if len(names) == 1 else _promised(data)  # a lone column counts nothing
    try:
        values, width = _rows(data, mark, names if mark != b" " else [])
    except MeshError as error:
        raise MeshError(f"{path.name!r} {error}") from None
    if len(width) == 0:
        raise MeshError(f"{path.name!r} holds no points")
    if promised is not None:
        values, width = _blocks(path, values, width, promised)
    if (width != width[0]).any():
        row = int(np.flatnonzero(width != width[0])[0])
        raise MeshError(
            f"{path.name!r} is damaged or truncated: line {row + 1} of its points has {width[row]} numbers, "
            f"the first has {width[0]}"
        )
    said = unit[1].decode() if unit is not None and names else ""
    return _Table(values.reshape(-1, width[0]), names[: width[0]], promised is not None, said)


def _rows(data: bytes, mark: bytes, names: list[str]) -> tuple[FloatArray, Any]:
    """Numbers of all rows, and how many each has; with ``names``, NaN for words and empty places."""
    gap = re.escape(mark) + rb"[ \t]*" + re.escape(mark)
    if names and re.search(gap, data[:HEAD]):
        return _with_gaps(data, mark, names)
    plain = data if mark.isspace() else data.replace(mark, b" ")
    try:
        values, width = numbers(plain), row_lengths(plain)
    except MeshError:
        if names:
            return _with_gaps(data, mark, names)
        raise
    return _with_gaps(data, mark, names) if names and (width != width[:1]).any() else (values, width)


def _names(data: bytes) -> tuple[list[str], bytes]:
    """What the columns are called, and the text without what stands before its numbers."""
    names: list[str] = []
    while True:
        end = data.find(b"\n")
        line = data[: end if end >= 0 else len(data)].strip()
        is_remark = line[:1] in (b"#", b"%", b"!") or line[:2] == b"//"
        is_words = re.search(rb"[A-Za-z]", re.sub(rb"[eE][-+]?\d|nan|inf", b"", line, flags=re.I)) is not None
        if end < 0 or not (is_remark or is_words or not line):
            break
        found = _split(line.decode("utf-8", "replace").lstrip("#/%! "))
        if not names and "x" in found and "y" in found:
            names = found
        elif is_words and not is_remark:
            if names:  # a word among the numbers
                break
            names = found
        data = data[end + 1 :]
    if re.search(rb"^[ \t]*(?:#|%|!|//)", data, re.MULTILINE):
        data = re.sub(rb"^[ \t]*(?:#|%|!|//)[^\n]*\n?", b"", data, flags=re.MULTILINE)
    return names, data


def _split(line: str) -> list[str]:
    """Names of a line, those that we know by the letter that stands for them."""
    mark = next((mark for mark in ",;|\t" if mark in line), None)
    line = re.sub(r"[\[(][^\[\]()]*[\])]", "", line)  # units
    words = line.split(mark) if mark else line.split()
    return [_known(word.strip().strip("\"'").strip().lower()) for word in words]


def _known(name: str) -> str:
    return next((short for pattern, short in _NAMES if re.fullmatch(pattern, name)), name)


def _mark(data: bytes) -> bytes:
    """What stands between two columns."""
    line = re.search(rb"[^\n]*\d[^\n]*", data[:HEAD])
    text = b"" if line is None else line[0].strip()
    for mark in (b";", b"|", b"\t"):
        if mark in text:
            return mark
    return b"," if b"," in text and not re.search(rb"\d\s+-?\d", text) else b" "


def _promised(data: bytes) -> tuple[int | None, bytes]:
    """The number of points, which PTS, and CloudCompare behind its names, begin with."""
    count = re.match(rb"\s*(\d{1,15})[ \t\r]*\n", data)
    return (None, data) if count is None else (int(count[1]), data[count.end() :])


def _blocks(path: Path, values: FloatArray, width: Any, promised: int) -> tuple[FloatArray, Any]:
    """Rows of all blocks, each of which begins with the number of its points."""
    start = np.cumsum(width) - width
    is_count = np.zeros(len(width), dtype=bool)
    at = promised
    while at < len(width) and width[at] == 1 and width[0] > 1 and 0 < values[start[at]] < len(width):
        is_count[at] = True
        promised += int(values[start[at]])
        at += 1 + int(values[start[at]])
    n = len(width) - int(is_count.sum())
    if promised != n:
        what = "its blocks promise" if is_count.any() else "its first line promises"
        raise MeshError(f"{path.name!r} is damaged or truncated: {what} {promised} points, {n} follow")
    return (np.delete(values, start[is_count]), width[~is_count]) if is_count.any() else (values, width)


def _with_gaps(data: bytes, mark: bytes, names: list[str]) -> tuple[FloatArray, Any]:
    """A table with words or empty places among its numbers: those count as NaN."""
    import pandas as pd

    raw = np.frombuffer(data, dtype=np.uint8)
    line = np.concatenate([[0], np.flatnonzero(raw == 10) + 1])
    line = line[line < len(raw)]
    marks = np.add.reduceat(raw == mark[0], line, dtype=np.int64)
    is_short = (marks < len(names) - 1) & (np.add.reduceat(raw > 32, line, dtype=np.int64) > 0)
    if b'"' not in data and is_short.any():
        row = int(np.flatnonzero(is_short)[0])
        raise MeshError(
            f"is damaged or truncated: line {row + 1} of its points has {marks[row] + 1} columns, and "
            f"{len(names)} have names"
        )
    options: Any = {"sep": mark.decode(), "header": None, "index_col": False, "skipinitialspace": True}
    frame = pd.read_csv(io.BytesIO(data), names=range(len(names)), low_memory=False, **options)
    try:
        columns = [
            pd.to_numeric(frame[k], errors="raise" if name in "xyz" else "coerce").astype(float)
            for k, name in enumerate(names)
        ]
    except (ValueError, TypeError) as error:
        raise MeshError(f"is damaged: {error!s:.100}") from None
    return np.stack(columns, axis=1).ravel(), np.full(len(frame), len(names))


# --- what the columns are ---------------------------------------------------------------------------


def _roles(path: Path, table: _Table, notes: Notes) -> dict[str, Any]:
    """Columns by what they hold: x, y, z, r, g, b, nx, ny, nz."""
    if table.names:
        column = {name: table.values[:, k] for k, name in reversed(list(enumerate(table.names)))}
        if any(axis not in column for axis in "xyz"):
            raise MeshError(f"{path.name!r} has no columns x, y and z, but {', '.join(table.names)[:200]}")
        return column
    width = table.values.shape[1]
    if width < 3:
        raise MeshError(f"{path.name!r} has {width} columns, and points need x, y and z")
    roles = {axis: k for k, axis in enumerate("xyz")}
    some = table.values[:: max(1, len(table.values) // N_LOOKED_AT), 3:]
    normal = next((k for k in range(width - 5) if _are_normals(some[:, k : k + 3])), None)
    free = [k for k in range(width - 5) if normal is None or abs(k - normal) >= 3]
    colored = [k for k in free if _are_colors(some[:, k : k + 3])]
    if colored:
        is_behind = (table.is_counted or path.suffix.lower() == ".pts") and width == 7  # intensity first
        first = colored[-1] if is_behind else colored[0]
        roles |= {c: 3 + first + k for k, c in enumerate("rgb")}
        if width > 6:
            notes.say(f"columns {first + 4} to {first + 6} were taken as colours")
    elif width >= 6 and normal is None:
        notes.say("columns 4 and up are neither colours nor normals: left out")
    if normal is not None:
        roles |= {f"n{axis}": 3 + normal + k for k, axis in enumerate("xyz")}
        notes.say(f"columns {normal + 4} to {normal + 6} were taken as normals: they have the length 1")
    return {name: table.values[:, k] for name, k in roles.items()}


def _are_normals(values: FloatArray) -> bool:
    """Whether rows have the length 1, as no colours have."""
    length = np.linalg.norm(values, axis=1)
    is_unit = float(np.mean(np.abs(length - 1) < 0.02))
    return is_unit > (0.9 if values.min(initial=0) < 0 else 0.99)


def _are_colors(values: FloatArray) -> bool:
    """Whether three columns fit one range of colours, whole numbers all of them or none."""
    is_whole = (values == np.floor(values)).all(axis=0)
    highest = values.max(initial=0)
    if not np.isfinite(values).all() or values.min(initial=0) < 0:
        return False
    return bool(
        highest <= 1 or (is_whole.all() and highest <= 65535) or (not is_whole.any() and highest <= 255)
    )
