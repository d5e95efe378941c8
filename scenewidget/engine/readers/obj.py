"""OBJ with its materials: positions, colours behind them, polygons, textures.

Wavefront's *Object Files* and *Material Library Files*. Seams of texture coordinates don't multiply the
vertices: each keeps its number, and has the mean of the colours at its corners.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, MeshError
from scenewidget.engine.readers.colors import Texture, as_bytes, at_vertices, open_image
from scenewidget.engine.readers.scan import ByteArray, Notes, Scan, beside, decoded_text
from scenewidget.engine.readers.text import CHUNK, rows, whole_numbers, without_remarks, words_per_line

__all__ = ["read"]

AT_ONCE = 1 << 16  # polygons whose texture is looked up together
MAX_LIBRARY = 1 << 24  # bytes of a material library
OPTIONS = {  # of map_Kd, and how many words follow each
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-clamp": 1,
    "-bm": 1, "-imfchan": 1, "-type": 1, "-cc": 1, "-colorspace": 1,
}  # fmt: skip


@dataclass
class _Faces:
    """Corners as written, counting from 1 or back from the line; 0 where there is none."""

    vertex: IntArray
    texture: IntArray
    counts: IntArray


def read(path: Path, notes: Notes) -> Scan:
    """Vertices and polygons of an OBJ at ``path``; ``notes`` hear what was guessed or lost."""
    data = np.fromfile(path, dtype=np.uint8)
    if data[:2].tobytes() in (b"\xff\xfe", b"\xfe\xff"):
        text = data.tobytes().decode("utf-16", "replace").encode()
        data = np.frombuffer(bytearray(text), dtype=np.uint8)
    if data[:3].tobytes() == b"\xef\xbb\xbf":  # a byte order mark
        data = data[3:]
    if (data == ord("\\")).any():  # lines that go on
        data = np.frombuffer(bytearray(re.sub(rb"\\\r?\n", b" ", data.tobytes())), dtype=np.uint8)
    if not (data == 10).any():
        data[data == 13] = 10
    if re.search(rb"^[ \t]+\S", data.data, re.MULTILINE):
        text = re.sub(rb"^[ \t]+", b"", data.tobytes(), flags=re.MULTILINE)
        data = np.frombuffer(bytearray(text), dtype=np.uint8)
    lines = _Lines(data)
    del data  # which lines may let go
    try:
        return _read(path, lines, notes)
    except MeshError as error:
        raise error if path.name in str(error) else MeshError(f"{path.name!r} {error}") from None


class _Lines:
    """Lines of a text by the word that they begin with; taking them out blanks that word."""

    def __init__(self, data: ByteArray) -> None:
        self.data = data
        ends = np.flatnonzero(data == 10).astype(np.min_scalar_type(len(data) + 3))
        self.ends = np.append(ends, ends.dtype.type(len(data)))
        self.starts = np.concatenate([np.zeros(1, ends.dtype), ends + ends.dtype.type(1)])
        first, second, third = (
            np.where(self.starts + k < self.ends, data[np.minimum(self.starts + k, len(data) - 1)], 10)
            for k in range(3)
        )
        is_blank = (second == 32) | (second == 9)
        is_long = (third == 32) | (third == 9)
        self.is_paint = (first == ord("#")) & (second == ord("M")) & (third == ord("R"))  # ZBrush's #MRGB
        first, second = first | 32, second | 32  # some write V and F
        self.is_vertex = (first == ord("v")) & is_blank
        self.is_texture = (first == ord("v")) & (second == ord("t")) & is_long
        self.is_color = (first == ord("v")) & (second == ord("c")) & is_long
        self.is_face = (first == ord("f")) & is_blank
        self.is_material = (first == ord("u")) & (second == ord("s"))
        self.is_library = (first == ord("m")) & (second == ord("t"))

    def pieces(self, which: BoolArray, width: int) -> Iterator[bytes]:
        """Text of these lines, their first word, of ``width`` letters, left out; some megabytes at once."""
        chosen = np.flatnonzero(which).astype(np.int32)
        if len(chosen) == 0:
            return
        for k in range(width):
            self.data[self.starts[chosen] + self.starts.dtype.type(k)] = 32
        written = np.cumsum(self.ends[chosen] - self.starts[chosen], dtype=np.int64) // CHUNK
        for some in np.split(chosen, np.flatnonzero(np.diff(written)) + 1):
            runs = np.flatnonzero(np.concatenate([[True], np.diff(some) > 1]))
            last = np.append(runs[1:], len(some)) - 1
            spans = zip(self.starts[some[runs]].tolist(), self.ends[some[last]].tolist())
            yield b"\n".join([self.data.data[a:b] for a, b in spans])

    def let_go(self) -> None:
        """Free the text, which isn't needed any more, and what is known of its lines."""
        vars(self).clear()

    def words(self, which: BoolArray) -> list[str]:
        """What stands behind the first word of these lines."""
        spans = zip(self.starts[which].tolist(), self.ends[which].tolist())
        texts = (decoded_text(bytes(self.data[a:b])).split(None, 1) for a, b in spans)
        return [text[1].strip() if len(text) > 1 else "" for text in texts]


def _read(path: Path, lines: _Lines, notes: Notes) -> Scan:
    materials = lines.words(lines.is_material)
    libraries = lines.words(lines.is_library)
    if materials and not libraries and beside(path.parent, path.stem + ".mtl"):
        libraries = [path.stem + ".mtl"]  # which some programs forget to say
    vertices, colors = _vertices(lines, notes)
    scan = Scan(vertices)
    scan.colors = _listed_colors(lines, len(vertices), notes) if colors is None else colors
    has_materials = bool(libraries and (materials or lines.is_texture.any()))
    faces = _faces(path, lines, has_materials)
    if faces is None:
        return scan
    scan.corners = _from_zero(faces.vertex, faces.counts, lines.is_face, lines.is_vertex)
    if (faces.vertex == 0).any() and faces.vertex.max() < len(vertices):
        raise MeshError(
            f"{path.name!r} has a face with vertex 0, but OBJ files number vertices from 1: add 1 to each"
        )
    scan.counts = None if (faces.counts == 3).all() else faces.counts
    if has_materials:
        number = {name: k for k, name in enumerate(dict.fromkeys(materials))}
        line_of_material = np.flatnonzero(lines.is_material)
        used = np.searchsorted(line_of_material, np.flatnonzero(lines.is_face)) - 1
        code = np.array([*(number[name] for name in materials), -1], dtype=np.int32)[used]
        uv = _from_zero(faces.texture, faces.counts, lines.is_face, lines.is_texture)
        coordinates = _coordinates(lines)
        lines.let_go()
        known = _library(path, libraries, notes)
        if not materials:
            if len(known) > 1:
                notes.say(f"faces name none of the library's {len(known)} materials: colours are lost")
            if len(known) != 1:
                return scan
            number, code = dict.fromkeys(known, 0), np.zeros_like(code)  # there is no other
        scan.colors = _material_colors(
            path, scan, faces.counts, uv, coordinates, list(number), code, known, notes
        )
    return scan


def _vertices(lines: _Lines, notes: Notes) -> tuple[FloatArray, ByteArray | None]:
    values, width = rows(lines.pieces(lines.is_vertex, 1))
    if len(width) == 0:
        raise MeshError("holds no vertices: it is no OBJ file, or damaged")
    if width.min() < 3:
        raise MeshError("is damaged or truncated: it has a vertex with fewer than three coordinates")
    start = np.cumsum(width) - width
    vertices = values[start[:, None] + np.arange(3)]
    has_color = width >= 6  # x y z r g b, with w before them or alpha behind
    if not has_color.any():
        return vertices, None
    behind = 3 + _has_weight(values, start, width)[has_color]
    found = as_bytes(values[(start[has_color] + behind)[:, None] + np.arange(3)], notes)
    if found is None:
        return vertices, None
    colors = np.full((len(vertices), 3), 255, dtype=np.uint8)
    colors[has_color] = found
    if not has_color.all():
        notes.say(f"{int((~has_color).sum())} of {len(vertices)} vertices have no colour and are white")
    return vertices, colors


def _has_weight(values: FloatArray, start: IntArray, width: IntArray) -> BoolArray:
    """(n_vertices,) whether a weight stands before the colour: all of the fourth numbers are 1 then.

    Of seven numbers, the last is the alpha of the colour otherwise.
    """
    is_wide = width >= 7
    return is_wide & bool((values[start[is_wide] + 3] == 1.0).all())


def _listed_colors(lines: _Lines, n: int, notes: Notes) -> ByteArray | None:
    """Colours of all ``n`` vertices in lines of their own: `vc r g b`, or `#MRGB`, 8 hex digits a vertex."""
    if lines.is_color.any():
        values, width = rows(lines.pieces(lines.is_color, 2))
        if len(width) == n and width.min() >= 3:
            return as_bytes(values[(np.cumsum(width) - width)[:, None] + np.arange(3)], notes)
        notes.say(f"{len(width)} lines of colours (vc) for {n} vertices: they are left out", warn=True)
    if lines.is_paint.any():
        digits = re.sub(r"\s", "", "".join(lines.words(lines.is_paint)))
        if len(digits) == 8 * n and re.fullmatch("[0-9A-Fa-f]+", digits):
            packed = np.frombuffer(bytes.fromhex(digits), dtype=np.uint8).reshape(n, 4)
            return np.array(packed[:, 1:])  # the first is a mask
        notes.say(f"#MRGB has {len(digits)} digits for {n} vertices: its colours are left out", warn=True)
    return None


# --- faces ----------------------------------------------------------------------------------------


def _faces(path: Path, lines: _Lines, has_textures: bool) -> _Faces | None:
    found = []
    for piece in map(without_remarks, lines.pieces(lines.is_face, 1)):
        vertex, texture, counts = _corners(piece)
        found.append((vertex, texture if has_textures else texture[:0], counts.astype(np.int32)))
    if not found:
        return None
    faces = _Faces(*(np.concatenate(parts) for parts in zip(*found)))
    if faces.counts[-1] < 3 and lines.data[-1] not in (10, 13):
        raise MeshError(
            f"{path.name!r} is damaged or truncated: it ends in a face with fewer than three corners"
        )
    return faces


def _corners(piece: bytes) -> tuple[IntArray, IntArray, IntArray]:
    """Vertices and texture coordinates of the corners of some lines, and the corners of each line."""
    counts = words_per_line(piece)
    if b"/" not in piece:
        vertex = whole_numbers(piece).astype(np.int32)
        return vertex, np.zeros(len(vertex), dtype=np.int32), counts
    raw = np.frombuffer(piece, dtype=np.uint8)
    line = np.concatenate([[0], np.flatnonzero(raw == 10) + 1])[: len(counts)]
    is_slash = raw == ord("/")
    slashes = np.add.reduceat(is_slash, line, dtype=np.int64)
    is_slash[1:] &= is_slash[:-1]
    is_slash[:1] = False
    doubles = np.add.reduceat(is_slash, line, dtype=np.int64)
    spread = piece.replace(b"/", b" ")
    per_line = words_per_line(spread)
    shapes = (  # of every corner of a line: 1, 1/2, 1//3, 1/2/3
        (slashes == 0),
        (slashes == counts) & (doubles == 0) & (per_line == 2 * counts),
        (slashes == 2 * counts) & (doubles == counts) & (per_line == 2 * counts),
        (slashes == 2 * counts) & (doubles == 0) & (per_line == 3 * counts),
    )
    values = whole_numbers(spread)
    for shape, stride in zip(shapes, (1, 2, 2, 3)):
        if shape.all():
            vertex = values[::stride].astype(np.int32)
            has_texture = shape is shapes[1] or shape is shapes[3]
            return vertex, (values[1::stride] * has_texture).astype(np.int32), counts
    words = [word.split(b"/") for word in piece.split()]
    vertex = whole_numbers(b" ".join(word[0] or b"?" for word in words)).astype(np.int32)
    texture = whole_numbers(b" ".join(word[1] if len(word) > 1 and word[1] else b"0" for word in words))
    return vertex, texture.astype(np.int32), counts


def _from_zero(index: IntArray, counts: IntArray, is_face: BoolArray, is_entry: BoolArray) -> IntArray:
    """Indices from 0; negative ones count back from the line that they stand in. -1 where there is none."""
    out = index - 1
    is_back = index < 0
    if is_back.any():
        line = np.repeat(np.flatnonzero(is_face), counts)
        found = np.cumsum(is_entry)[line[is_back]] + index[is_back]
        out[is_back] = np.where(found < 0, -1, found)
    return out


# --- materials ------------------------------------------------------------------------------------


@dataclass
class _Material:
    color: tuple[float, float, float] | None = None  # Kd, or Ke where that is black
    picture: str = ""  # map_Kd, or map_Ke or map_Ka where there is none
    home: Path = Path()  # of its library
    is_clamped: bool = False
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)


def _library(path: Path, names: list[str], notes: Notes) -> dict[str, _Material]:
    """Materials of the libraries beside the file."""
    out: dict[str, _Material] = {}
    for name in _single_names(path.parent, names):
        found = beside(path.parent, name)
        if found is None:
            notes.say(f"material library {name!r} is missing: colours of materials are lost", warn=True)
            continue
        if found.stat().st_size > MAX_LIBRARY:
            notes.say(f"material library {name!r} is too large to be one: left out", warn=True)
            continue
        material = _Material()
        for line in decoded_text(found.read_bytes()).splitlines():
            words = line.split(None, 1)
            key = words[0].lower() if len(words) > 1 else ""
            if key == "newmtl":
                material = out.setdefault(words[1].strip(), _Material(home=found.parent))
            elif key == "kd" or (key == "ke" and not any(material.color or ())):
                color = _color(words[1])
                material.color = color if key == "kd" or any(color or ()) else material.color
            elif key == "map_kd" or (key in ("map_ke", "map_ka") and not material.picture):
                _take_map(material, words[1])
    return out


def _single_names(folder: Path, names: list[str]) -> list[str]:
    """Names of libraries: a line may hold several, or one with blanks in it."""
    single = []
    for name in names:
        words = name.split()
        is_several = beside(folder, name) is None and any(beside(folder, word) for word in words)
        single += words if is_several else [name]
    return list(dict.fromkeys(single))


def _color(text: str) -> tuple[float, float, float] | None:
    try:
        values = [float(word) for word in text.split()[:3]]
    except ValueError:  # a spectrum, or damage
        return None
    r, g, b = (values * 3)[:3] if len(values) == 1 else (*values, 0.0, 0.0)[:3]
    scale = 1 / 255 if 1.0 < max(r, g, b) <= 255.0 and min(r, g, b) >= 0.0 else 1.0  # some write bytes
    return (r * scale, g * scale, b * scale)


def _take_map(material: _Material, text: str) -> None:
    words = text.split()
    while words and words[0].lower() in OPTIONS:
        option, width = words[0].lower(), OPTIONS[words[0].lower()]
        given = words[1 : 1 + width]
        if width == 3:  # one to three numbers
            given = [w for k, w in enumerate(given) if re.fullmatch(r"[-+.\deE]+", w) and k < len(words) - 2]
        if option == "-clamp":
            material.is_clamped = given == ["on"]
        elif option in ("-s", "-o") and given:
            values = (
                [float(w) for w in given] + [float(given[-1])]
                if option == "-s"
                else [float(w) for w in given] + [0.0]
            )
            pair = (values[0], values[1])
            material.scale, material.offset = (
                (pair, material.offset) if option == "-s" else (material.scale, pair)
            )
        text = text.split(None, 1 + len(given))[-1]
        words = words[1 + len(given) :]
    material.picture = text.strip().strip('"')


def _coordinates(lines: _Lines) -> FloatArray:
    """(n, 2) coordinates in textures."""
    values, width = rows(lines.pieces(lines.is_texture, 2))
    if len(width) == 0 or width.min() < 2:
        return np.zeros((0, 2))
    return np.asarray(values[(np.cumsum(width) - width)[:, None] + np.arange(2)])


def _material_colors(
    path: Path,
    scan: Scan,
    counts: IntArray,
    uv_index: IntArray,
    coordinates: FloatArray,
    names: list[str],
    material: IntArray,
    known: dict[str, _Material],
    notes: Notes,
) -> ByteArray | None:
    """Vertex colours out of materials; those of the vertices where a material says nothing."""
    code, sides = np.repeat(material, counts), np.repeat(counts, counts)
    colors = np.zeros((len(scan.corners), 3), dtype=np.uint8)
    is_known = np.zeros(len(scan.corners), dtype=bool)
    pictures: dict[tuple[Path, str], Any] = {}
    for k, name in enumerate(names):
        made_of = known.get(name)
        if made_of is None:
            notes.say(f"material {name[:60]!r} is in no library: what it colours has no colours", warn=True)
            continue
        mine = code == k
        picture = made_of.picture
        if picture and len(coordinates):
            key = (made_of.home, picture)
            if key not in pictures:
                found = beside(made_of.home, picture) or beside(path.parent, picture)
                pictures[key] = open_image(found or path.with_name("?"), picture, notes)
            if pictures[key] is None:
                continue
            wrap = "clamp" if made_of.is_clamped else "repeat"
            texture = Texture(pictures[key], wrap=(wrap, wrap))
            usable = mine & (uv_index >= 0) & (uv_index < len(coordinates))
            for n in np.unique(sides[usable]).tolist():
                whole = _whole_polygons(usable & (sides == n), n)
                for start in range(0, len(whole), AT_ONCE * n):
                    polygon = whole[start : start + AT_ONCE * n]
                    places = coordinates[uv_index[polygon]] * made_of.scale + made_of.offset
                    colors[polygon] = texture.at(places.reshape(-1, n, 2)).reshape(-1, 3)
                    is_known[polygon] = True
        elif made_of.color is not None and not picture:
            colors[mine] = np.clip(np.round(255 * np.nan_to_num(np.array(made_of.color))), 0, 255)
            is_known |= mine
    if scan.colors is not None and not pictures:  # colours of its own tell more than one for all
        return scan.colors
    if not is_known.any():
        return scan.colors
    missing = len(is_known) - int(is_known.sum())
    if missing and scan.colors is None:
        notes.say(f"{missing} of {len(is_known)} corners of faces have no colour; they count as white")
    return at_vertices(scan.corners, colors, len(scan.vertices), is_known=is_known, fallback=scan.colors)


def _whole_polygons(which: BoolArray, n: int) -> IntArray:
    """Corners, of polygons with n of them, of those that are chosen as a whole."""
    index: IntArray = np.arange(len(which), dtype=np.int32)
    if not which.all():
        index = index[which]
    if len(index) % n == 0 and (np.diff(index.reshape(-1, n), axis=1) == 1).all():
        return index
    keep = []
    at = 0
    while at + n <= len(index):  # a corner without coordinates spoils its polygon
        if index[at + n - 1] - index[at] == n - 1:
            keep.append(index[at : at + n])
            at += n
        else:
            at += 1
    return np.concatenate(keep) if keep else np.empty(0, dtype=np.int64)
