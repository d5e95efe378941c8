"""PLY, text and binary: polygons of any number of corners, triangle strips, and points without faces.

Turk (1994), *The PLY polygon file format*. Colours at vertices, at faces, or from a texture whose
coordinates stand at vertices or at the corners of each face, as MeshLab and Metashape write them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray, MeshError
from scenewidget.engine.readers.colors import Texture, as_bytes, at_vertices, open_image, unpacked
from scenewidget.engine.readers.scan import Notes, Scan, beside, check_promise
from scenewidget.engine.readers.text import numbers

__all__ = ["columns_of", "has_faces", "read"]

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
COLORS = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
NORMALS = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))
COORDINATES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
CORNERS = ("vertex_indices", "vertex_index", "vertex_ids", "vertexindices", "vertexindex", "indices")
PACKED = ("rgba", "rgb")  # 8 bits a channel in one number, as the Point Cloud Library has them
HEADER = 1 << 20  # bytes; longer ones are no header


@dataclass
class _Property:
    name: str
    dtype: str
    count_dtype: str = ""  # of a list


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


@dataclass
class _List:
    """Values of a list property, one row after the other, and how many each row has."""

    values: npt.NDArray[Any]
    counts: IntArray


def read(path: Path, notes: Notes) -> Scan:
    """Vertices and polygons of a PLY at ``path``; ``notes`` hear what was guessed or lost."""
    data = path.read_bytes()
    order, elements, textures, start = _read_header(path, data)
    columns = _read_text(path, data, start, elements) if order == "" else {}
    if order:
        columns = _read_binary(path, data, start, elements, order)
    columns = {name: _lower(found) for name, found in columns.items()}
    vertex = columns.get("vertex", {})
    if any(axis not in vertex for axis in "xyz"):
        raise MeshError(f"{path.name!r} has no vertices with x, y and z: it holds no geometry")
    vertices = np.stack([vertex[axis] for axis in "xyz"], axis=1, dtype=np.float64)
    is_single = order != "" and all(vertex[axis].dtype.itemsize < 8 for axis in "xyz")
    scan = Scan(vertices, is_single=is_single)
    scan.normals = _group(vertex, NORMALS)
    colors = _group(vertex, COLORS)
    scan.colors = None if colors is None else as_bytes(colors, notes)
    packed = next((vertex[name] for name in PACKED if name in vertex), None)
    if scan.colors is None and packed is not None and packed.dtype.itemsize == 4:
        scan.colors = unpacked(packed)
    if scan.colors is None and "f_dc_0" in vertex:  # Gaussian splats: the constant term of their harmonics
        light = 0.5 + 0.28209479177387814 * _group(vertex, (("f_dc_0", "f_dc_1", "f_dc_2"),))
        scan.colors = np.round(255 * np.clip(light, 0, 1)).astype(np.uint8)
        notes.say("the file holds Gaussian splats: their centres were taken as points")
    face = columns.get("face", {})
    lists = [found for found in face.values() if isinstance(found, _List) and found.values.dtype.kind in "iu"]
    only = lists[0] if len(lists) == 1 else None  # whatever it is called
    corners = next((face[name] for name in CORNERS if name in face), only)
    if corners is not None and len(corners.counts):
        scan.corners = corners.values
        scan.counts = None if (corners.counts == 3).all() else corners.counts
        found = _texture_colors(path, textures, vertex, face, scan, corners.counts, notes)
        found = _face_colors(face, scan, corners.counts, notes) if found is None else found
        scan.colors = found if found is not None else scan.colors
    elif "tristrips" in columns:
        strips = columns["tristrips"].get(CORNERS[0], columns["tristrips"].get(CORNERS[1]))
        if strips is not None:
            scan.corners = _strip_triangles(strips.values)
    elif corners is None and any(len(found) for found in face.values() if not isinstance(found, _List)):
        notes.say("its faces have no list of corners and were left out", warn=True)
    return scan


def _lower(columns: dict[str, Any]) -> dict[str, Any]:
    """The same columns by names in lower case; of two that differ in case alone the first counts."""
    return {name.lower(): found for name, found in reversed(list(columns.items()))}


def columns_of(path: Path) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """All properties of the PLY at ``path`` by element and name, and its comments.

    A property is an array, or, of lists, an object with their ``values`` one after the other and ``counts``.
    """
    data = path.read_bytes()
    order, elements, _, start = _read_header(path, data)
    columns = (
        _read_binary(path, data, start, elements, order) if order else _read_text(path, data, start, elements)
    )
    lines = data[:start].decode("utf-8", "replace").splitlines()
    return columns, [line.split("comment ", 1)[1].strip() for line in lines if line.startswith("comment ")]


def has_faces(path: Path) -> bool:
    """Whether the PLY at ``path`` promises any face or strip."""
    with path.open("rb") as file:
        _, elements, _, _ = _read_header(path, file.read(HEADER), path.stat().st_size)
    return any(element.count and element.name in ("face", "tristrips") for element in elements)


def _group(columns: dict[str, Any], names: tuple[tuple[str, ...], ...]) -> Any:
    """(n, k) of the first group of properties that is there as a whole."""
    for group in names:
        if all(name in columns for name in group):
            return np.stack([columns[name] for name in group], axis=1)
    return None


def _face_colors(face: dict[str, Any], scan: Scan, counts: IntArray, notes: Notes) -> Any:
    colors = _group(face, COLORS)
    if colors is None or scan.colors is not None:
        return None
    found = as_bytes(colors, notes)
    if found is None:
        return None
    notes.say("colours stand at the faces: a vertex has the mean of those around it")
    return at_vertices(scan.corners, np.repeat(found, counts, axis=0), len(scan.vertices))


def _texture_colors(
    path: Path,
    names: list[str],
    vertex: dict[str, Any],
    face: dict[str, Any],
    scan: Scan,
    counts: IntArray,
    notes: Notes,
) -> Any:
    """Colours from textures, coordinates per corner or per vertex; None without."""
    per_corner = face.get("texcoord")
    per_vertex = _group(vertex, COORDINATES)
    if per_corner is None and per_vertex is None:
        return None
    if not names:
        notes.say("the file has texture coordinates, but names no texture")
        return None
    if per_corner is not None and not np.array_equal(per_corner.counts, 2 * counts):
        notes.say("texture coordinates don't fit the corners of the faces: colours are lost", warn=True)
        return None
    if per_corner is None:
        valid = np.clip(scan.corners, 0, len(scan.vertices) - 1)
        uv = per_vertex[valid]
    else:
        uv = per_corner.values.reshape(-1, 2)
    number = np.clip(face.get("texnumber", np.zeros(len(counts))), -1, len(names)).astype(np.int64)
    which = np.repeat(number, counts)
    colors = np.zeros((len(uv), 3), dtype=np.uint8)
    is_known = np.zeros(len(uv), dtype=bool)
    polygon = np.repeat(np.arange(len(counts)), counts)
    for k, name in enumerate(names):
        pixels = open_image(beside(path.parent, name) or path.with_name("?"), name, notes)
        if pixels is not None:
            for n in np.unique(counts[number == k]).tolist():
                mine = (which == k) & (counts[polygon] == n)
                colors[mine] = Texture(pixels).at(uv[mine].reshape(-1, n, 2)).reshape(-1, 3)
                is_known |= mine
    if not is_known.any():
        return None
    return at_vertices(scan.corners, colors, len(scan.vertices), is_known=is_known, fallback=scan.colors)


def _strip_triangles(strip: IntArray) -> IntArray:
    """Corners of the triangles of strips that -1 parts; every other one runs the other way round."""
    a, b, c = strip[:-2], strip[1:-1], strip[2:]
    index = np.arange(len(strip))
    start = np.maximum.accumulate(np.where(strip < 0, index + 1, 0))[:-2]
    is_odd = (index[:-2] - start) % 2 == 1
    triangles = np.stack([np.where(is_odd, b, a), np.where(is_odd, a, b), c], axis=1)
    return triangles[(triangles >= 0).all(axis=1)].ravel()


# --- the header -----------------------------------------------------------------------------------


def _read_header(path: Path, data: bytes, size: int = 0) -> tuple[str, list[_Element], list[str], int]:
    """Byte order, elements, names of textures, and where the data begin."""
    end = re.compile(rb"^[ \t]*end_header[ \t]*(\r\n|\n|\r)", re.MULTILINE).search(data[:HEADER])
    if end is None and re.search(rb"\rend_header\r", data[:HEADER]):
        end = re.compile(rb"end_header\r").search(data[:HEADER])
    if data[:3].lower() != b"ply":
        raise MeshError(f"{path.name!r} does not start with 'ply': it is not a PLY file, or damaged")
    if end is None:
        raise MeshError(f"{path.name!r} is truncated: its PLY header has no end")
    order: str | None = None
    elements: list[_Element] = []
    textures: list[str] = []
    room = max(len(data), size) - end.end()
    for line in re.split(r"\r\n|\n|\r", data[: end.start()].decode("utf-8", "replace")):
        words = line.split()
        if words[:1] == ["format"] and len(words) > 1:
            order = ORDERS.get(words[1])
        elif words[:1] == ["element"]:
            if len(words) != 3 or not words[2].isascii() or not words[2].isdigit() or len(words[2]) > 18:
                raise MeshError(
                    f"{path.name!r} is damaged or truncated: its header promises "
                    f"{' '.join(words[2:])[:40] or 'nothing'} of element {' '.join(words[1:2])[:40]!r}"
                )
            check_promise(path, f"of element {words[1]!r}", int(words[2]), 1, room)
            elements.append(_Element(words[1], int(words[2])))
        elif words[:1] == ["property"]:
            if not elements:
                raise _refused(path, line)
            elements[-1].properties.append(_property(path, words, line))
        elif words[:2] == ["comment", "TextureFile"] or words[:2] == ["comment", "texturefile"]:
            textures.append(line.split(None, 2)[2].strip() if len(words) > 2 else "?")
    if order is None:
        raise MeshError(f"{path.name!r} has no format that PLY knows: ascii or binary, little or big endian")
    return order, elements, textures, end.end()


def _property(path: Path, words: list[str], line: str) -> _Property:
    types = [word.lower() for word in (words[2:-1] if words[1:2] == ["list"] else words[1:-1])]
    if len(types) != (2 if words[1:2] == ["list"] else 1) or any(t not in TYPES for t in types):
        raise _refused(path, line)
    if len(types) == 2 and TYPES[types[0]][0] == "f":
        raise _refused(path, line)
    return _Property(words[-1], TYPES[types[-1]], TYPES[types[0]] if len(types) == 2 else "")


def _refused(path: Path, line: str) -> MeshError:
    return MeshError(f"{path.name!r} is damaged: its header says {line.strip()[:100]!r}")


# --- the data -------------------------------------------------------------------------------------


def _read_binary(
    path: Path, data: bytes, start: int, elements: list[_Element], order: str
) -> dict[str, dict[str, Any]]:
    out: dict[str, dict[str, Any]] = {}
    for element in elements:
        least = sum(np.dtype(p.count_dtype or p.dtype).itemsize for p in element.properties)
        check_promise(path, f"of element {element.name!r}", element.count, least, len(data) - start)
        lists = [p for p in element.properties if p.count_dtype]
        columns: dict[str, Any] = {}
        widths = _first_widths(data, start, element, order) if element.count else [0] * len(lists)
        layout = _layout(element, widths, order)
        block = None
        if element.count * layout.itemsize <= len(data) - start:
            block = np.frombuffer(data, layout, count=element.count, offset=start)
            is_even = all((block[f"n{k}"] == n).all() for k, n in enumerate(widths))
            block = block if is_even else None
        if block is not None:
            start += element.count * layout.itemsize
            for k, p in enumerate(lists):
                counts = np.full(element.count, widths[k], dtype=np.int64)
                columns[p.name] = _List(_native(block[f"l{k}"]).reshape(-1), counts)
            for p in element.properties:
                if not p.count_dtype:
                    columns[p.name] = _native(block[p.name])
        else:
            start = _read_uneven(path, data, start, element, order, columns)
        out[element.name] = columns
    return out


def _native(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.array(values, dtype=values.dtype.base.newbyteorder("="))


def _layout(element: _Element, widths: list[int], order: str) -> np.dtype[Any]:
    fields: list[Any] = []
    k = 0
    for p in element.properties:
        if p.count_dtype:
            fields += [(f"n{k}", order + p.count_dtype), (f"l{k}", order + p.dtype, (widths[k],))]
            k += 1
        elif p.name not in [name for name, *_ in fields]:
            fields.append((p.name, order + p.dtype))
        else:  # named twice: the first counts
            fields.append((f"again {len(fields)}", order + p.dtype))
    return np.dtype(fields)


def _first_widths(data: bytes, start: int, element: _Element, order: str) -> list[int]:
    """Length of each list in the first row."""
    widths, at = [], start
    for p in element.properties:
        size = np.dtype(p.dtype).itemsize
        if p.count_dtype:
            head = data[at : at + np.dtype(p.count_dtype).itemsize]
            width = int.from_bytes(head, "little" if order == "<" else "big", signed=p.count_dtype[0] == "i")
            widths.append(width if 0 <= width * size <= len(data) else 0)
            at += len(head) + widths[-1] * size
        else:
            at += size
    return widths


def _read_uneven(
    path: Path, data: bytes, start: int, element: _Element, order: str, columns: dict[str, Any]
) -> int:
    """Rows whose lists differ in length; returns where they end."""
    raw = np.frombuffer(data, dtype=np.uint8)
    count_sizes = [np.dtype(p.count_dtype).itemsize if p.count_dtype else 0 for p in element.properties]
    sizes = [np.dtype(p.dtype).itemsize for p in element.properties]
    signed = [p.count_dtype[:1] == "i" for p in element.properties]
    places, counts, end = _walk(
        raw, start, element.count, np.array(count_sizes), np.array(sizes), np.array(signed), order == ">"
    )
    if end < 0:
        raise MeshError(
            f"{path.name!r} is damaged or truncated: its header promises {element.count} of element "
            f"{element.name!r}, {-end - 1} could be read"
        )
    for k, p in enumerate(element.properties):
        dtype = np.dtype(order + p.dtype)
        # where each value begins: rows differ in length, so they are gathered byte by byte
        first = np.repeat(places[:, k], counts[:, k])
        inside = np.arange(len(first)) - np.repeat(np.cumsum(counts[:, k]) - counts[:, k], counts[:, k])
        begin = first + inside * dtype.itemsize
        values = np.empty((len(begin), dtype.itemsize), dtype=np.uint8)
        for byte in range(dtype.itemsize):
            values[:, byte] = raw[begin + byte]
        found = _native(values.view(dtype).reshape(-1))
        columns.setdefault(p.name, _List(found, counts[:, k]) if p.count_dtype else found)
    return int(end)


@kernel(allocates=True)
def _walk(raw, start, n_rows, count_sizes, sizes, signed, is_big):  # type: ignore[no-untyped-def]
    """Place and length of each property of each row, and the end; −1 − rows where the bytes run out."""
    n = len(sizes)
    places = np.zeros((n_rows, n), dtype=np.int64)
    counts = np.ones((n_rows, n), dtype=np.int64)
    at = start
    for row in range(n_rows):
        for k in range(n):
            width = count_sizes[k]
            if at + width > len(raw):
                return places, counts, -1 - row
            if width:
                count = np.int64(0)
                for byte in range(width):
                    place = at + byte if is_big else at + width - 1 - byte
                    count = count * 256 + np.int64(raw[place])
                if signed[k] and width < 8 and count >= np.int64(1) << (8 * width - 1):
                    count -= np.int64(1) << (8 * width)
                counts[row, k] = count
                at += width
            places[row, k] = at
            if counts[row, k] < 0 or counts[row, k] > (len(raw) - at) // sizes[k]:
                return places, counts, -1 - row
            at += counts[row, k] * sizes[k]
    return places, counts, at


def _read_text(path: Path, data: bytes, start: int, elements: list[_Element]) -> dict[str, dict[str, Any]]:
    try:
        values = numbers(data[start:])
    except MeshError as error:
        raise MeshError(f"{path.name!r} {error}") from None
    out: dict[str, dict[str, Any]] = {}
    at = 0
    for element in elements:
        check_promise(
            path, f"of element {element.name!r}", element.count, len(element.properties), len(values) - at
        )
        columns: dict[str, Any] = {}
        at = _text_rows(path, values, at, element, columns)
        out[element.name] = columns
    return out


def _text_rows(path: Path, values: FloatArray, at: int, element: _Element, columns: dict[str, Any]) -> int:
    n, properties = element.count, element.properties
    widths: list[int] = []
    end = at
    for p in properties:  # as the first row has it
        first = values[end] if p.count_dtype and n and end < len(values) else 0
        widths.append(1 + int(first) if p.count_dtype and 0 <= first < len(values) else 1)
        end += widths[-1]
    width = sum(widths)
    starts = np.cumsum([0, *widths])[:-1]
    is_list = [bool(p.count_dtype) for p in properties]
    block = values[at : at + n * width].reshape(n, width) if n * width <= len(values) - at else None
    if block is not None and all(
        (block[:, s] == w - 1).all() for s, w, is_ in zip(starts, widths, is_list) if is_
    ):
        for p, s, w in zip(properties, starts.tolist(), widths):
            if p.count_dtype:
                flat = block[:, s + 1 : s + w].reshape(-1)
                columns.setdefault(p.name, _List(_typed(path, flat, p), np.full(n, w - 1)))
            else:
                columns.setdefault(p.name, _typed(path, block[:, s], p))
        return at + n * width
    places, counts, end = _walk_numbers(values, at, n, np.array(is_list))
    if end < 0:
        raise MeshError(
            f"{path.name!r} is damaged or truncated: its header promises {n} of element {element.name!r}, "
            f"{-end - 1} could be read"
        )
    for k, p in enumerate(properties):
        first = np.repeat(places[:, k], counts[:, k])
        inside = np.arange(len(first)) - np.repeat(np.cumsum(counts[:, k]) - counts[:, k], counts[:, k])
        found = _typed(path, values[first + inside], p)
        columns.setdefault(p.name, _List(found, counts[:, k]) if p.count_dtype else found)
    return int(end)


@kernel(allocates=True)
def _walk_numbers(values, start, n_rows, is_list):  # type: ignore[no-untyped-def]
    """As `_walk`, in numbers instead of bytes."""
    n = len(is_list)
    places = np.zeros((n_rows, n), dtype=np.int64)
    counts = np.ones((n_rows, n), dtype=np.int64)
    at = start
    for row in range(n_rows):
        for k in range(n):
            if is_list[k]:
                if (
                    at >= len(values)
                    or not 0 <= values[at] <= len(values)
                    or values[at] != np.floor(values[at])
                ):
                    return places, counts, -1 - row
                counts[row, k] = np.int64(values[at])
                at += 1
            places[row, k] = at
            if counts[row, k] > len(values) - at:
                return places, counts, -1 - row
            at += counts[row, k]
    return places, counts, at


def _typed(path: Path, values: FloatArray, p: _Property) -> npt.NDArray[Any]:
    """Numbers as the header declares them; positions keep all digits that stand in the text."""
    if p.dtype[0] == "f":
        return values
    if not np.isfinite(values).all() or (np.floor(values) != values).any():
        if p.name.lower() in CORNERS:
            raise MeshError(f"{path.name!r} is damaged: a corner of a face is no whole number")
        return values  # other columns: some programs declare bytes and write fractions
    limits = np.iinfo(p.dtype)
    fits = limits.min <= values.min(initial=0) and values.max(initial=0) <= limits.max
    return values.astype(p.dtype if fits else np.float64)
