"""glTF 2.0, as one file (GLB) or as JSON with files beside it: nodes, primitives, materials, textures.

Khronos (2021), *glTF 2.0 specification*. Vertices come in the order of the scene's nodes and primitives;
primitives of one node that share their positions share their vertices. Coordinates stay as they are
written: y is up there, `orientation.up_direction` finds it.
"""

from __future__ import annotations

import base64
import json
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import FloatArray, IntArray, MeshError
from scenewidget.engine.readers.colors import Texture, at_vertices, open_image, to_linear, to_srgb
from scenewidget.engine.readers.scan import (
    FACE_BYTES,
    VERTEX_BYTES,
    ByteArray,
    Notes,
    Scan,
    beside,
    check_size,
)

__all__ = ["read"]

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
MAX_DEPTH = 100
MAX_INSTANCES = 100_000  # of one node
WRAPS = {33071: "clamp", 33648: "mirror"}
DRACO = "KHR_draco_mesh_compression"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
GLOSSY = "KHR_materials_pbrSpecularGlossiness"
INSTANCES = "EXT_mesh_gpu_instancing"
UNDERSTOOD = re.compile(  # extensions that we read, or that don't touch geometry and colour
    r"KHR_mesh_quantization|KHR_texture_transform|KHR_texture_basisu|EXT_texture_webp|KHR_materials_\w+"
    r"|KHR_lights_\w+|KHR_xmp\w*|KHR_animation_\w+|KHR_node_visibility|KHR_audio\w*|EXT_lights_\w+"
    rf"|EXT_mesh_features|EXT_structural_metadata|CESIUM_primitive_outline|{DRACO}|{INSTANCES}"
)
ADVICE = "save it without, for example by `npx @gltf-transform/cli copy in.glb out.glb`"


def read(path: Path, notes: Notes) -> Scan:
    """Vertices and triangles of the default scene at ``path``; ``notes`` hear what was guessed or lost."""
    try:
        return _read(_File.open(path, notes))
    except MeshError as error:
        raise error if path.name in str(error) else MeshError(f"{path.name!r} {error}") from None


@dataclass(eq=False)
class _File:
    """The JSON of a file, and what it refers to."""

    path: Path
    content: dict[str, Any]
    chunk: bytes  # the binary part of a GLB
    notes: Notes
    pictures: dict[int, ByteArray | None] = field(default_factory=dict)
    loaded: dict[int, bytes] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path, notes: Notes) -> _File:
        """Take the file apart and refuse what it requires and we don't know."""
        data = path.read_bytes()
        text, chunk = _chunks(data) if data[:4] == b"glTF" else (data, b"")
        content = json.loads(text)
        if not isinstance(content, dict) or not isinstance(content.get("asset"), dict):
            raise MeshError("is damaged: it holds no glTF scene")
        version = str(content["asset"].get("version", ""))
        if not version.startswith("2"):
            raise MeshError(f"is glTF of version {version[:20]!r}; 2.0 is read: convert it first")
        for name in content.get("extensionsRequired", []):
            if name in MESHOPT or not UNDERSTOOD.fullmatch(str(name)):
                raise MeshError(f"requires the extension {str(name)[:60]!r}, which isn't read; {ADVICE}")
        _say_what_is_not_read(content, notes)
        return cls(path, content, chunk, notes)

    def entry(self, kind: str, index: Any) -> dict[str, Any]:
        """Entry of a list of the JSON by its number."""
        values = self.content.get(kind, [])
        if type(index) is not int or not isinstance(values, list) or not 0 <= index < len(values):
            raise MeshError(f"is damaged: it refers to {index!r:.40} of its {kind}")
        found = values[index]
        if not isinstance(found, dict):
            raise MeshError(f"is damaged: entry {index} of its {kind} is no object")
        return found

    def buffer(self, index: int) -> bytes:
        """Bytes of a buffer: the binary part, a data URI, or a file beside this one."""
        if index in self.loaded:
            return self.loaded[index]
        entry = self.entry("buffers", index)
        if "uri" in entry:
            self.loaded[index] = self.resource(entry["uri"])
        elif self._is_chunk(index):
            self.loaded[index] = self.chunk
        else:
            raise MeshError(f"is damaged: its buffer {index} is nowhere")
        return self.loaded[index]

    def _is_chunk(self, index: int) -> bool:
        return index == 0 and bool(self.chunk)

    def resource(self, uri: Any) -> bytes:
        """Bytes behind a URI: data, or a file in the same folder or below."""
        if not isinstance(uri, str):
            raise MeshError("is damaged: a URI is no text")
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[-1], validate=False)
        parts = [part for part in re.split(r"[\\/]", unquote(uri)) if part not in ("", ".")]
        if not parts or ".." in parts or ":" in parts[0] or "\0" in uri:
            raise MeshError(f"refers to {uri[:80]!r}; only files beside it are read")
        place = beside(self.path.parent, "/".join(parts))
        if place is None:
            raise FileNotFoundError(f"{self.path.name!r} needs {uri[:200]!r} beside it, which does not exist")
        return place.read_bytes()

    def view(self, index: Any) -> memoryview:
        """Bytes of a buffer view."""
        entry = self.entry("bufferViews", index)
        packed = next((name for name in MESHOPT if name in entry.get("extensions", {})), None)
        if (
            packed
            and "uri" not in self.entry("buffers", entry["buffer"])
            and not self._is_chunk(entry["buffer"])
        ):
            raise MeshError(f"is compressed by {packed!r}, which isn't read; {ADVICE}")
        start, length = _whole(entry.get("byteOffset", 0)), _whole(entry["byteLength"])
        data = self.buffer(_whole(entry["buffer"]))
        if start + length > len(data):
            raise MeshError(
                f"is damaged or truncated: a part of {length} bytes at {start} lies beyond its {len(data)}"
            )
        return memoryview(data)[start : start + length]

    def accessor(self, index: Any, what: str) -> npt.NDArray[Any]:
        """(count, n) numbers; normalised integers as floats in 0–1 or -1–1."""
        entry = self.entry("accessors", index)
        kind, n = COMPONENTS.get(entry.get("componentType", 0)), WIDTHS.get(entry.get("type", ""))
        count = _whole(entry.get("count"))
        if kind is None or n is None:
            raise MeshError(f"is damaged: the type of its {what} is unknown")
        dtype = np.dtype(kind)
        check_size(self.path, what, count * n * dtype.itemsize)
        if "bufferView" in entry:
            values = self._strided(entry, dtype, count, n, what)
        elif "sparse" in entry and count <= 1_000_000 + 16 * len(self.chunk):
            values = np.zeros((count, n), dtype=dtype)
        else:
            raise MeshError(f"is damaged: its {what}, {count} of them, have no data")
        if "sparse" in entry:
            values = self._with_sparse(values, entry["sparse"], dtype, n, what)
        if entry.get("normalized") and dtype.kind in "iu":
            return np.maximum(values / np.float32(np.iinfo(dtype).max), np.float32(-1.0))
        return values

    def _strided(
        self, entry: dict[str, Any], dtype: np.dtype[Any], count: int, n: int, what: str
    ) -> npt.NDArray[Any]:
        view = self.view(entry["bufferView"])
        start, size = _whole(entry.get("byteOffset", 0)), n * dtype.itemsize
        stride = _whole(self.entry("bufferViews", entry["bufferView"]).get("byteStride", size)) or size
        if stride < size:
            raise MeshError(f"is damaged: the entries of its {what} overlap")
        if count == 0 or start + (count - 1) * stride + size > len(view):
            raise MeshError(
                f"is damaged or truncated: {count} of its {what} are promised in {len(view)} bytes"
            )
        shape, strides = (count, n), (stride, dtype.itemsize)
        return np.ndarray(shape, dtype, view, offset=start, strides=strides)

    def _with_sparse(
        self, values: npt.NDArray[Any], sparse: dict[str, Any], dtype: np.dtype[Any], n: int, what: str
    ) -> npt.NDArray[Any]:
        count = _whole(sparse["count"])
        at = {"componentType": sparse["indices"]["componentType"], **sparse["indices"]}
        index = self._strided(at, np.dtype(COMPONENTS[at["componentType"]]), count, 1, what)[:, 0]
        if index.max() >= len(values):
            raise MeshError(f"is damaged: an exception among its {what} lies beyond their end")
        values = np.array(values)
        values[index] = self._strided(sparse["values"], dtype, count, n, what)
        return values


def _say_what_is_not_read(content: dict[str, Any], notes: Notes) -> None:
    """Remark on extensions that may be ignored: aloud where a node, a mesh or a primitive has them."""
    shapes = [*content.get("nodes", []), *content.get("meshes", [])]
    shapes += [primitive for mesh in content.get("meshes", []) for primitive in mesh.get("primitives", [])]
    of_shapes = {name for shape in shapes for name in shape.get("extensions", {})}
    for name in content.get("extensionsUsed", []):
        if name not in MESHOPT and not UNDERSTOOD.fullmatch(str(name)):
            what = (
                "shapes are as the file has them" if name in of_shapes else "the scan is as the file has it"
            )
            notes.say(f"the extension {str(name)[:60]!r} isn't read: {what} without", warn=name in of_shapes)


def _chunks(data: bytes) -> tuple[bytes, bytes]:
    if len(data) < 20:
        raise MeshError("is damaged or truncated")
    version, total = struct.unpack_from("<II", data, 4)
    size, kind = struct.unpack_from("<I4s", data, 12)
    if version != 2:
        raise MeshError(f"is a GLB of version {version}; version 2 is read: convert it first")
    if total > len(data) or kind != b"JSON" or 20 + size > len(data):
        raise MeshError(f"is damaged or truncated: its header promises {total} bytes, and it has {len(data)}")
    text, rest = data[20 : 20 + size], 20 + size
    if len(data) >= rest + 8:
        length, kind = struct.unpack_from("<I4s", data, rest)
        if kind == b"BIN\0":
            if rest + 8 + length > len(data):
                raise MeshError("is damaged or truncated inside its data")
            return text, data[rest + 8 : rest + 8 + length]
    return text, b""


def _whole(value: Any) -> int:
    if type(value) is not int or not 0 <= value < 2**53:
        raise MeshError(f"is damaged: {value!r:.40} stands where a count is expected")
    return value


# --- nodes and primitives -------------------------------------------------------------------------


@dataclass(eq=False)
class _Part:
    """What one node draws with one set of positions."""

    vertices: FloatArray
    triangles: list[IntArray] = field(default_factory=list)
    colors: ByteArray | None = None
    is_single: bool = True


def _read(file: _File) -> Scan:
    parts = list(_parts(file))
    surfaces = [part for part in parts if part.triangles]
    if not surfaces:
        return _points(file, parts)
    if len(surfaces) < len(parts):
        file.notes.say("the file also holds points or lines, which are left out")
    parts = surfaces
    vertices = np.concatenate([part.vertices for part in parts])
    shift = np.cumsum([0, *(len(part.vertices) for part in parts)])
    corners = [t + s for part, s in zip(parts, shift.tolist()) for t in part.triangles]
    scan = Scan(vertices, np.concatenate(corners).reshape(-1), is_single=True)
    if any(part.colors is not None for part in parts):
        bare = sum(part.colors is None for part in parts)
        if bare:
            file.notes.say(f"{bare} of {len(parts)} parts have no colours and are white")
        white = [np.full((len(part.vertices), 3), 255, np.uint8) for part in parts]
        scan.colors = np.concatenate([w if p.colors is None else p.colors for p, w in zip(parts, white)])
    return scan


def _points(file: _File, parts: list[_Part]) -> Scan:
    """Vertices of parts without triangles, as a cloud."""
    scan = Scan(np.concatenate([np.empty((0, 3)), *(part.vertices for part in parts)]), is_single=True)
    if parts and all(part.colors is not None for part in parts):
        scan.colors = np.concatenate([part.colors for part in parts if part.colors is not None])
    return scan


def _parts(file: _File) -> Iterator[_Part]:
    nodes = file.content.get("nodes", [])
    scenes = file.content.get("scenes", [])
    roots = list(range(len(nodes)))
    if len(scenes) > 1:
        file.notes.say(f"the file holds {len(scenes)} scenes: that which it shows first was read")
    if scenes:
        roots = file.entry("scenes", file.content.get("scene", 0)).get("nodes", [])
    else:
        below = {child for node in nodes if isinstance(node, dict) for child in node.get("children", [])}
        roots = [k for k in roots if k not in below]
    seen: set[int] = set()
    stack = [(root, np.eye(4), 0) for root in reversed(roots)]
    decoded = 0
    while stack:
        number, above, depth = stack.pop()
        node = file.entry("nodes", number)
        if number in seen or depth > MAX_DEPTH:
            raise MeshError("is damaged: its nodes don't form a tree")
        seen.add(number)
        if node.get("extensions", {}).get("KHR_node_visibility", {}).get("visible") is False:
            file.notes.say("the file hides some of its nodes: they are left out")
            continue
        matrix = above @ _matrix(node)
        children = node.get("children", [])
        stack += [(child, matrix, depth + 1) for child in reversed(children)]
        if "mesh" not in node:
            continue
        if "skin" in node:
            file.notes.say("the file has skins: meshes are read as they are before any is applied")
        for place in _instances(file, node):
            for part in _mesh(file, node["mesh"], matrix @ place):
                size = VERTEX_BYTES * len(part.vertices) + sum(FACE_BYTES * len(t) for t in part.triangles)
                decoded += size
                check_size(file.path, "geometry", decoded)  # nodes may share a mesh as often as they like
                yield part


def _instances(file: _File, node: dict[str, Any]) -> Iterator[FloatArray]:
    """Where a node draws its mesh, seen from the node: once, or as often as EXT_mesh_gpu_instancing says."""
    extension = node.get("extensions", {}).get(INSTANCES)
    if extension is None:
        yield np.eye(4)
        return
    widths = {"TRANSLATION": 3, "ROTATION": 4, "SCALE": 3}
    given = extension.get("attributes", {})
    found = {name.lower(): _floats(file, given[name], "instances") for name in widths if name in given}
    counts = {len(values) for values in found.values()}
    if len(counts) != 1 or any(
        found[name.lower()].shape[1] != widths[name] for name in widths if name in given
    ):
        raise MeshError(f"is damaged: {INSTANCES!r} needs as many translations as rotations and scales")
    n = counts.pop()
    if n > MAX_INSTANCES:
        raise MeshError(f"draws a mesh {n} times, and at most {MAX_INSTANCES} are read; {ADVICE}")
    file.notes.say(f"a mesh is drawn {n} times, as {INSTANCES} says: each is a part of the scan")
    for row in range(n):
        yield _matrix({name: values[row].tolist() for name, values in found.items()})


def _mesh(file: _File, index: Any, matrix: FloatArray) -> Iterator[_Part]:
    """Parts of a mesh under a node, one for each set of positions."""
    by_positions: dict[Any, _Part] = {}
    hues: dict[Any, list[tuple[IntArray, Any]]] = {}
    is_mirrored = np.linalg.det(matrix[:3, :3]) < 0
    for number, primitive in enumerate(file.entry("meshes", index).get("primitives", [])):
        mode = primitive.get("mode", 4)
        if "targets" in primitive:
            file.notes.say("the file has morph targets: meshes are read as they are before any is applied")
        if mode not in (0, 4, 5, 6):
            file.notes.say("the file also holds points or lines, which are left out")
            continue
        attributes, triangles = _geometry(file, primitive, mode)
        places = attributes["POSITION"]
        key = ("draco", number) if isinstance(places, np.ndarray) else places
        if key not in by_positions:
            local = places if isinstance(places, np.ndarray) else file.accessor(places, "positions")
            if local.shape[1] != 3:
                raise MeshError("is damaged: its positions have no three coordinates")
            with np.errstate(over="ignore", invalid="ignore"):  # the door looks for what isn't finite
                moved = local.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
            by_positions[key] = _Part(moved)
        part = by_positions[key]
        n = len(part.vertices)
        if mode == 0:
            nothing = np.empty((0, 3), dtype=np.int64)
            hues.setdefault(key, []).append((nothing, _colors(file, primitive, attributes, nothing, n)))
            continue
        if triangles is None:
            triangles = _assembled(np.arange(n), mode)
        if is_mirrored:
            triangles = triangles[:, ::-1]
        part.triangles.append(triangles)
        hues.setdefault(key, []).append((triangles, _colors(file, primitive, attributes, triangles, n)))
    for key, part in by_positions.items():
        part.colors = _joined(hues[key], len(part.vertices))
        yield part


def _joined(hues: list[tuple[IntArray, Any]], n: int) -> ByteArray | None:
    """Colours of the vertices that several primitives may share."""
    found = [(triangles, colors) for triangles, colors in hues if colors is not None]
    if not found:
        return None
    if len(hues) == 1:
        return np.asarray(found[0][1])
    corners = np.concatenate([triangles.reshape(-1) for triangles, _ in found])
    valid = [np.clip(triangles.reshape(-1), 0, n - 1) for triangles, _ in found]
    return at_vertices(corners, np.concatenate([c[v] for v, (_, c) in zip(valid, found)]), n)


def _geometry(file: _File, primitive: dict[str, Any], mode: int) -> tuple[dict[str, Any], IntArray | None]:
    """Attributes of a primitive, by accessor or decoded, and its triangles."""
    attributes = dict(primitive.get("attributes", {}))
    if "POSITION" not in attributes:
        raise MeshError("is damaged: a primitive has no positions")
    draco = primitive.get("extensions", {}).get(DRACO)
    if draco is not None and "bufferView" not in file.entry("accessors", attributes["POSITION"]):
        return _undraco(file, draco, attributes)
    if "indices" not in primitive or mode == 0:
        return attributes, None
    index = file.accessor(primitive["indices"], "indices")
    if index.dtype.kind != "u" or index.shape[1] != 1:
        raise MeshError("is damaged: its indices are no whole numbers")
    return attributes, _assembled(index[:, 0].astype(np.int64), mode)


def _assembled(index: IntArray, mode: int) -> IntArray:
    """(n, 3) triangles out of a list, a strip or a fan of vertices."""
    if mode == 4:
        if len(index) % 3:
            raise MeshError(f"is damaged or truncated: {len(index)} corners don't make triangles")
        return index.reshape(-1, 3)
    if mode == 6:
        return np.stack([index[1:-1], index[2:], np.repeat(index[:1], max(len(index) - 2, 0))], axis=1)
    strip = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    strip[1::2] = strip[1::2][:, [1, 0, 2]]
    return strip


def _undraco(
    file: _File, extension: dict[str, Any], attributes: dict[str, Any]
) -> tuple[dict[str, Any], IntArray]:
    try:
        import DracoPy
    except ImportError:
        raise MeshError(
            f"is compressed by {DRACO!r}: `pip install DracoPy` lets it be read, or {ADVICE}"
        ) from None
    promised = _whole(file.entry("accessors", attributes["POSITION"]).get("count"))
    data = bytes(file.view(extension["bufferView"]))
    if promised > 100 * len(data):
        raise MeshError(f"is damaged: {promised} vertices are promised in {len(data)} compressed bytes")
    mesh = DracoPy.decode(data)
    if len(mesh.points) != promised:
        raise MeshError(f"is damaged: {promised} vertices are promised, {len(mesh.points)} decoded")
    found: dict[str, Any] = {"POSITION": np.asarray(mesh.points)}
    by_id = {entry["unique_id"]: np.asarray(entry["data"]) for entry in mesh.attributes}
    for name, number in extension.get("attributes", {}).items():
        if name != "POSITION" and name in attributes and number in by_id:
            values = by_id[number]
            entry = file.entry("accessors", attributes[name])
            if entry.get("normalized") and values.dtype.kind in "iu":
                values = values / np.float32(np.iinfo(values.dtype).max)
            found[name] = values
    return found, np.asarray(mesh.faces, dtype=np.int64)


def _matrix(node: dict[str, Any]) -> FloatArray:
    if "matrix" in node:
        return _numbers(node["matrix"], 16).reshape(4, 4).T
    out = np.eye(4)
    if "rotation" in node:
        x, y, z, w = _numbers(node["rotation"], 4)
        length = float(np.sqrt(x * x + y * y + z * z + w * w)) or 1.0
        x, y, z, w = x / length, y / length, z / length, w / length
        out[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    if "scale" in node:
        out[:3, :3] *= _numbers(node["scale"], 3)
    if "translation" in node:
        out[:3, 3] = _numbers(node["translation"], 3)
    return out


def _numbers(values: Any, n: int) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    if array.shape != (n,) or not np.isfinite(array).all():
        raise MeshError(f"is damaged: {n} numbers are expected, not {values!r:.60}")
    return array


# --- colours --------------------------------------------------------------------------------------


def _colors(
    file: _File, primitive: dict[str, Any], attributes: dict[str, Any], triangles: IntArray, n: int
) -> ByteArray | None:
    """(n, 3) base colour of the material times the vertex colours; None where neither says anything."""
    own = _vertex_colors(file, attributes, n)
    factor: FloatArray = np.ones(3)
    texture: Texture | None = None
    coordinates, transform = 0, dict[str, Any]()
    if "material" in primitive:
        factor, texture, coordinates, transform = _material(file, primitive["material"])
    if own is not None and own.dtype == np.uint8:  # written as screens show them: nothing may change them
        return own
    light: Any = factor.astype(np.float32)
    is_known = own is not None or bool((factor != 1).any())
    name = f"TEXCOORD_{coordinates}"
    if texture is not None and name in attributes:
        uv = _floats(file, attributes[name], "texture coordinates")
        if len(uv) < n:
            raise MeshError(f"is damaged: {len(uv)} texture coordinates for {n} vertices")
        uv = _transformed(uv[:n], transform)
        valid = triangles[((triangles >= 0) & (triangles < n)).all(axis=1)]
        texels = at_vertices(valid.reshape(-1), texture.at(uv[valid]).reshape(-1, 3), n)
        if own is None and (factor == 1).all():
            return texels
        light, is_known = light * to_linear(texels), True
    elif texture is not None:
        file.notes.say("a textured part has no texture coordinates: its texture is lost", warn=True)
    if not is_known:
        return None
    light = light * own if own is not None else light
    return to_srgb(np.broadcast_to(light, (n, 3)))


def _floats(file: _File, values: Any, what: str) -> FloatArray:
    found = values if isinstance(values, np.ndarray) else file.accessor(values, what)
    return np.asarray(found, dtype=np.float64)


def _vertex_colors(file: _File, attributes: dict[str, Any], n: int) -> npt.NDArray[Any] | None:
    """(n, 3) linear light, or bytes for screens where the program that wrote them means those."""
    if "COLOR_0" not in attributes:
        return None
    values = attributes["COLOR_0"]
    values = values if isinstance(values, np.ndarray) else file.accessor(values, "colours")
    if len(values) < n or values.shape[1] < 3:
        raise MeshError(f"is damaged: {len(values)} colours for {n} vertices")
    values = values[:n, :3]
    if values.dtype.kind in "iu":  # not marked as normalised, as some programs forget
        values = values / np.float32(np.iinfo(values.dtype).max)
    light: FloatArray = np.nan_to_num(values.astype(np.float32))
    written = _bytes_as_floats(light)
    if written is not None:
        file.notes.say(f"vertex colours up to {light.max():g} were taken as 0–255")
        return written
    light = np.clip(light, 0, 1)
    generator = str(file.content["asset"].get("generator", ""))
    extras = file.content["asset"].get("extras")
    if generator == "scenewidget" and isinstance(extras, dict) and extras.get("colors") == "linear":
        return to_srgb(light)  # the scan's; the factor of the material is the colour of the segment
    if "trimesh" in generator or generator == "scenewidget":
        file.notes.say(f"vertex colours were taken as bytes for screens, as {generator[:60]!r} writes them")
        return np.asarray(np.round(255 * light), dtype=np.uint8)
    file.notes.say("vertex colours were taken as linear light, as glTF means them")
    return light


def _bytes_as_floats(values: FloatArray) -> npt.NDArray[np.uint8] | None:
    """The bytes that some programs write where light, from 0 to 1, is meant; None where it is light."""
    if not 1.5 < float(values.max(initial=0.0)) <= 255.5:
        return None
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


def _material(file: _File, index: Any) -> tuple[FloatArray, Texture | None, int, dict[str, Any]]:
    """Base colour factor, texture, number of its coordinates, and how they are transformed."""
    material = file.entry("materials", index)
    glossy = material.get("extensions", {}).get(GLOSSY)
    if glossy is not None and "pbrMetallicRoughness" not in material:
        base, factor_key, texture_key = glossy, "diffuseFactor", "diffuseTexture"
    else:
        base, factor_key = material.get("pbrMetallicRoughness", {}), "baseColorFactor"
        texture_key = "baseColorTexture"
    factor = _numbers(base.get(factor_key, [1, 1, 1, 1]), 4)[:3]
    info = base.get(texture_key)
    if "trimesh" in str(file.content["asset"].get("generator", "")):
        factor = _factor_of_trimesh(factor, has_texture=info is not None)
    written = _bytes_as_floats(factor)
    if written is not None:
        file.notes.say(f"a base colour up to {factor.max():g} was taken as 0–255")
        factor = to_linear(written)
    factor = np.clip(factor, 0, 1)
    if info is None and "emissiveTexture" in material and (factor_key not in base or not factor.any()):
        factor, info = np.ones(3), material["emissiveTexture"]  # scans whose light is in the picture
    if info is None:
        return factor, None, 0, {}
    transform = info.get("extensions", {}).get("KHR_texture_transform", {})
    coordinates = _whole(transform.get("texCoord", info.get("texCoord", 0)))
    entry = file.entry("textures", info.get("index"))
    texture = None
    pixels = _picture(file, entry)
    if pixels is not None:
        sampler = file.entry("samplers", entry["sampler"]) if "sampler" in entry else {}
        wrap = tuple(WRAPS.get(sampler.get(key, 0), "repeat") for key in ("wrapS", "wrapT"))
        texture = Texture(pixels, is_bottom_up=False, wrap=(wrap[0], wrap[1]))
    return factor, texture, coordinates, transform


def _factor_of_trimesh(factor: FloatArray, *, has_texture: bool) -> FloatArray:
    """Linear light of a base colour that trimesh wrote: it writes bytes for screens, as at vertices.

    Its textured materials have a grey of 102 that nobody chose, which would darken the picture.
    """
    if has_texture and np.allclose(factor, 102 / 255, atol=1e-6):
        return np.ones(3)
    return np.asarray(to_linear(np.round(255 * np.clip(factor, 0, 1)).astype(np.uint8)), dtype=np.float64)


def _picture(file: _File, entry: dict[str, Any]) -> ByteArray | None:
    extensions = entry.get("extensions", {})
    source = extensions.get("EXT_texture_webp", {}).get("source", entry.get("source"))
    if source is None:
        name = next(iter(extensions), "no picture")
        file.notes.say(
            f"a texture is stored by {name!r:.60}, which isn't read: its colours are lost", warn=True
        )
        return None
    if source not in file.pictures:
        image = file.entry("images", source)
        title = str(image.get("name") or image.get("uri", f"image {source}"))[:80]
        title = f"image {source}" if title.startswith("data:") else title
        try:
            data = (
                bytes(file.view(image["bufferView"]))
                if "bufferView" in image
                else file.resource(image["uri"])
            )
        except FileNotFoundError:
            file.notes.say(f"texture {title!r} is missing: what it colours has no colours", warn=True)
            file.pictures[source] = None
        else:
            file.pictures[source] = open_image(data, title, file.notes)
    return file.pictures[source]


def _transformed(uv: FloatArray, transform: dict[str, Any]) -> FloatArray:
    """Coordinates under KHR_texture_transform: scaled, turned, moved."""
    if not transform:
        return uv
    scale = _numbers(transform.get("scale", [1, 1]), 2)
    angle = float(transform.get("rotation", 0.0))
    turn: FloatArray = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray((uv * scale) @ turn.T + _numbers(transform.get("offset", [0, 0]), 2))
