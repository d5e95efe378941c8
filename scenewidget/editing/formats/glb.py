"""GLB: binary glTF 2.0 with a node a segment, named like it; parts lie in the node of their whole.

Khronos (2021), *glTF 2.0 specification*. The scene stands upright there: glTF has y up, scans have z up, so
a root node turns them. Which face of the mesh each triangle is stands in ``extras``; where another program
has dropped that, triangles are found again by their places.
"""

from __future__ import annotations

import itertools
import json
import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.editing.formats.common import FormatError, Labels, clean_name
from scenewidget.editing.formats.seal import SEAL, Contents
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.readers.colors import to_linear
from scenewidget.engine.segmentation import Segmentation
from scenewidget.palette import segment_colors

__all__ = ["read", "write"]

UPRIGHT = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # quaternion: a quarter turn about x, z becomes −y's
POINTS = 0  # mode of a primitive
SHORT, FLOAT, UINT = 5123, 5126, 5125
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
MAX_DEPTH = 50


def write(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """A node a segment, unlabeled faces in one of their own; see `export`."""
    builder = _Builder()
    colors = segment_colors(segmentation)
    order = np.argsort(segmentation.labels, kind="stable")
    starts = np.searchsorted(segmentation.labels[order], np.arange(-1, segmentation.n_segments + 1))
    for label, (start, stop) in enumerate(itertools.pairwise(starts.tolist()), start=-1):
        if start < stop:
            name = segmentation.names[label] if label >= 0 else "unlabeled"
            builder.add_segment(mesh, order[start:stop], name, colors[label], label)
    builder.group(segmentation.groups)
    return {path: list(builder.chunks())}


class _Builder:
    """Collects buffers and the JSON that describes them."""

    def __init__(self) -> None:
        self.data: list[bytes] = []
        self.size = 0
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.materials: list[dict[str, Any]] = []
        self.titles: set[str] = set()
        self.nodes: list[dict[str, Any]] = [{"name": "scan", "rotation": UPRIGHT, "children": []}]

    def add_segment(
        self, mesh: Mesh, faces: IntArray, name: str, color: npt.NDArray[np.uint8], label: int
    ) -> None:
        used, corners = np.unique(mesh.faces[faces], return_inverse=True)
        places = mesh.vertices[used].astype("<f4")
        attributes = {"POSITION": self._accessor(places, FLOAT, "VEC3", 34962)}
        if mesh.vertex_colors is not None:
            light = np.ones((len(used), 4), dtype=np.float32)  # in bytes, dark shades would become alike
            light[:, :3] = to_linear(mesh.vertex_colors[used])
            attributes["COLOR_0"] = self._accessor(
                np.round(65535 * light).astype("<u2"), SHORT, "VEC4", 34962
            )
        primitive = {"attributes": attributes, "material": len(self.materials), "mode": 4}
        if mesh.is_cloud:  # of which `used` are the faces themselves
            primitive["mode"] = POINTS
        else:
            primitive["indices"] = self._accessor(corners.astype("<u4").ravel(), UINT, "SCALAR", 34963)
        linear = to_linear(color).round(4).tolist()
        pbr = {"baseColorFactor": [*linear, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9}
        self.materials.append({"name": name, "doubleSided": True, "pbrMetallicRoughness": pbr})
        extras = {"segment": label, "faces": self._accessor(faces.astype("<u4"), UINT, "SCALAR", None)}
        self.nodes[0]["children"].append(len(self.nodes))
        # names repeat, and readers want different ones: the number comes along for those
        title = name if name and name not in self.titles else f"{name} #{label}".strip()
        self.titles.add(title)
        self.nodes.append({"name": title, "mesh": len(self.meshes), "extras": {**extras, "name": name}})
        self.meshes.append({"name": title, "primitives": [primitive]})

    def group(self, groups: Sequence[int]) -> None:
        """Put the nodes of parts into those of their wholes."""
        node = {self.nodes[k]["extras"]["segment"]: k for k in self.nodes[0]["children"]}
        for part, whole in enumerate(groups):
            if part != whole:
                self.nodes[0]["children"].remove(node[part])
                self.nodes[node[whole]].setdefault("children", []).append(node[part])

    def _accessor(self, array: npt.NDArray[Any], kind: int, type_: str, target: int | None) -> int:
        data = array.tobytes()
        view = {"buffer": 0, "byteOffset": self.size, "byteLength": len(data)}
        self.views.append(view if target is None else {**view, "target": target})
        accessor = {
            "bufferView": len(self.views) - 1,
            "componentType": kind,
            "count": len(array),
            "type": type_,
        }
        if type_ == "VEC3":
            accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        if kind == SHORT:
            accessor["normalized"] = True
        self.accessors.append(accessor)
        self.data.append(data + b"\0" * (-len(data) % 4))
        self.size += len(self.data[-1])
        return len(self.accessors) - 1

    def chunks(self) -> Iterator[bytes]:
        content = {
            "asset": {
                "version": "2.0",
                "generator": "scenewidget",
                "extras": {"seal": SEAL, "colors": "linear"},
            },
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.size}],
        }
        text = json.dumps(content, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        yield struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + self.size)
        yield struct.pack("<I4s", len(text), b"JSON") + text
        yield struct.pack("<I4s", self.size, b"BIN\0")
        yield from self.data


# --- reading --------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Piece:
    """A node that draws something."""

    name: str
    faces: IntArray | None  # of the mesh, if the file says so
    centers: FloatArray  # (n, 3) of its triangles, in the scene
    is_unlabeled: bool
    number: int  # of the node
    whole: int  # the uppermost node above that draws something, its own where there is none


def read(path: Path, mesh: Mesh) -> Labels:
    """Segments of a GLB, one a node with triangles. Faces of the mesh that no node has are unlabeled."""
    content, data = _read_chunks(path)
    pieces = list(_pieces(content, data, 200 * mesh.n_faces + 1_000_000))
    if not pieces:
        raise FormatError(f"{path.name!r} has no node with triangles")
    labels = np.full(mesh.n_faces, -1, dtype=np.int64)
    says_faces = _says_faces(pieces, mesh)
    found = [p.faces for p in pieces if p.faces is not None] if says_faces else _by_place(pieces, mesh)
    every = np.concatenate(found)
    every = every[every >= 0]
    if not len(every):
        raise FormatError(f"{path.name!r} has no triangle where the mesh has one: it belongs to another mesh")
    for k, (piece, faces) in enumerate(zip(pieces, found, strict=True)):
        if not piece.is_unlabeled:
            labels[faces[faces >= 0]] = k
    lost = sum(int((faces < 0).sum()) for faces in found)
    names = {k: piece.name for k, piece in enumerate(pieces)}
    place = {piece.number: k for k, piece in enumerate(pieces)}
    groups = {k: place[piece.whole] for k, piece in enumerate(pieces)}
    return Labels(labels, "face", names, groups, report={"triangles that the mesh does not have": lost})


def _says_faces(pieces: list[_Piece], mesh: Mesh) -> bool:
    """Whether what the file says of its faces holds: programs that saved it again keep that and renumber."""
    if any(piece.faces is None or len(piece.faces) != len(piece.centers) for piece in pieces):
        return False
    every = np.concatenate([piece.faces for piece in pieces if piece.faces is not None])
    if (
        len(every) == 0
        or every.min() < 0
        or every.max() >= mesh.n_faces
        or len(np.unique(every)) < len(every)
    ):
        return False
    reach = 1e-3 * float(np.ptp(mesh.vertices, axis=0).max() or 1.0)
    centers = np.concatenate([piece.centers for piece in pieces])
    return bool((np.abs(_z_up(centers) - mesh.face_centroids[every]) <= reach).all())


def _said_faces(content: dict[str, Any], data: bytes, number: Any) -> IntArray | None:
    try:
        return _array(content, data, number, 1).astype(np.int64).ravel()
    except (FormatError, LookupError, TypeError, ValueError):
        return None  # another program took the numbers of faces for something of its own


def _by_place(pieces: list[_Piece], mesh: Mesh) -> list[IntArray]:
    """Faces of the mesh at the places of each piece's triangles, -1 where there is none."""
    from scipy.spatial import cKDTree

    tree = cKDTree(mesh.face_centroids)
    reach = 1e-4 * float(np.ptp(mesh.vertices, axis=0).max() or 1.0)
    best: list[IntArray] = []
    for turn in (_z_up, np.asarray):  # exported with y up, as glTF wants, or as it was
        out = []
        for piece in pieces:
            distance, face = tree.query(turn(piece.centers), distance_upper_bound=reach)
            out.append(np.where(np.isfinite(distance), face, -1))
        if not best or sum((f >= 0).sum() for f in out) > sum((f >= 0).sum() for f in best):
            best = out
    return best


def _z_up(places: FloatArray) -> FloatArray:
    return np.stack([places[:, 0], -places[:, 2], places[:, 1]], axis=1)


def _read_chunks(path: Path) -> tuple[dict[str, Any], bytes]:
    raw = path.read_bytes()
    if len(raw) < 20 or raw[:4] != b"glTF":
        raise FormatError(f"{path.name!r} does not start with 'glTF': it is not a GLB file")
    _, version, total = struct.unpack_from("<4sII", raw)
    size, kind = struct.unpack_from("<I4s", raw, 12)
    if version != 2 or total != len(raw) or kind != b"JSON" or 20 + size > len(raw):
        raise FormatError(f"{path.name!r} is damaged or truncated: its parts don't fit its {len(raw)} bytes")
    content = json.loads(raw[20 : 20 + size])
    if not isinstance(content, dict):
        raise FormatError(f"{path.name!r} is damaged: it holds no scene")
    rest = raw[20 + size :]
    if not rest:
        return content, b""
    if len(rest) < 8 or struct.unpack_from("<I", rest)[0] > len(rest) - 8 or rest[4:8] != b"BIN\0":
        raise FormatError(f"{path.name!r} is damaged or truncated")
    return content, rest[8:]


def _pieces(content: dict[str, Any], data: bytes, budget: int) -> Iterator[_Piece]:
    nodes = _list(content, "nodes")
    scenes = _list(content, "scenes")
    roots = _list(scenes[_index(content.get("scene", 0), scenes)], "nodes") if scenes else range(len(nodes))
    seen: set[int] = set()
    stack = [(_index(root, nodes), np.eye(4), 0, -1) for root in roots]
    while stack:
        number, above, depth, whole = stack.pop()
        if number in seen or depth > MAX_DEPTH:
            raise FormatError("is damaged: its nodes don't form a tree")
        seen.add(number)
        node = nodes[number]
        matrix = above @ _matrix(node)
        whole = number if whole < 0 and "mesh" in node else whole
        stack += [(_index(child, nodes), matrix, depth + 1, whole) for child in _list(node, "children")]
        if "mesh" not in node:
            continue
        meshes = _list(content, "meshes")
        corners = [
            _triangles(content, data, primitive)
            for primitive in _list(meshes[_index(node["mesh"], meshes)], "primitives")
        ]
        places = np.concatenate([np.empty((0, 3)), *(c.mean(axis=1) for c in corners if len(c))])
        budget -= 36 * len(places)
        if budget < 0:  # nodes may share a mesh: a small file can ask for any number of triangles
            raise FormatError("has far more triangles than the mesh")
        extras = node.get("extras")
        faces, is_ours = None, isinstance(extras, dict) and "segment" in extras and "faces" in extras
        if is_ours:
            faces = _said_faces(content, data, extras["faces"])
        name = extras.get("name", "") if is_ours else node.get("name", "")
        yield _Piece(
            clean_name(name),
            faces,
            places @ matrix[:3, :3].T + matrix[:3, 3],
            (is_ours and extras["segment"] == -1) or node.get("name") == "unlabeled",
            number,
            whole,
        )


def _triangles(content: dict[str, Any], data: bytes, primitive: Any) -> FloatArray:
    """(n, 3, 3) corners, or (n, 1, 3) points."""
    if not isinstance(primitive, dict) or primitive.get("mode", 4) not in (4, POINTS):
        return np.empty((0, 3, 3))
    if "KHR_draco_mesh_compression" in (primitive.get("extensions") or {}):
        raise FormatError("is compressed with Draco; export it without compression")
    places = _array(content, data, primitive["attributes"]["POSITION"], 3).astype(np.float64)
    if not np.isfinite(places).all():
        raise FormatError("has places that are not numbers")
    if primitive.get("mode", 4) == POINTS:
        return places[:, None]
    if "indices" not in primitive:
        return places[: len(places) // 3 * 3].reshape(-1, 3, 3)
    indices = _array(content, data, primitive["indices"], 1).astype(np.int64).ravel()
    if len(indices) % 3 or (len(indices) and (indices.min() < 0 or indices.max() >= len(places))):
        raise FormatError("is damaged: a triangle has a corner that does not exist")
    return np.asarray(places[indices].reshape(-1, 3, 3))


def _array(content: dict[str, Any], data: bytes, number: Any, width: int) -> npt.NDArray[Any]:
    """(count, width) entries of an accessor; every size is checked against the data that is there."""
    accessors, views = _list(content, "accessors"), _list(content, "bufferViews")
    accessor = accessors[_index(number, accessors)]
    if "sparse" in accessor or "bufferView" not in accessor:
        raise FormatError("holds sparse data, which is not read")
    view = views[_index(accessor["bufferView"], views)]
    buffers = _list(content, "buffers")
    if _index(view.get("buffer", 0), buffers) != 0 or "uri" in buffers[0]:
        raise FormatError("refers to another file, which is not followed; export it as one GLB")
    kind = accessor.get("componentType")
    if kind not in COMPONENTS or accessor.get("type") != {1: "SCALAR", 3: "VEC3"}[width]:
        raise FormatError("has data of an unexpected type")
    dtype = np.dtype(COMPONENTS[kind])
    row = dtype.itemsize * width
    stride = view.get("byteStride", row) or row
    count, inner = accessor.get("count"), accessor.get("byteOffset", 0)
    start, length = view.get("byteOffset", 0), view.get("byteLength")
    if any(type(x) is not int or x < 0 for x in (count, start, inner, length, stride)) or stride < row:
        raise FormatError("is damaged: sizes are no whole numbers")
    if count and (inner + stride * (count - 1) + row > length or start + length > len(data)):
        raise FormatError(f"is damaged: {count} entries are promised where {len(data)} bytes are")
    if not count:
        return np.empty((0, width), dtype)
    block = np.frombuffer(data, np.uint8, count=stride * (count - 1) + row, offset=start + inner)
    rows = np.lib.stride_tricks.as_strided(block, (count, row), (stride, 1), writeable=False)
    return np.ascontiguousarray(rows).view(dtype).reshape(count, width)


def _matrix(node: dict[str, Any]) -> FloatArray:
    """(4, 4) transform of a node."""
    out = np.eye(4)
    if "matrix" in node:
        return _numbers(node["matrix"], 16).reshape(4, 4).T
    if "rotation" in node:
        x, y, z, w = _numbers(node["rotation"], 4)
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
    if (
        not isinstance(values, list)
        or len(values) != n
        or not all(isinstance(x, (int, float)) for x in values)
    ):
        raise FormatError(f"is damaged: {n} numbers are expected")
    array = np.array(values, dtype=np.float64)
    if not (np.abs(array) < 1e9).all():
        raise FormatError("is damaged: a transform is out of all bounds")
    return array


def _list(content: dict[str, Any], key: str) -> list[Any]:
    values = content.get(key, [])
    if not isinstance(values, list) or (
        key not in ("nodes", "children") and not all(isinstance(v, dict) for v in values)
    ):
        raise FormatError(f"is damaged: {key!r} is no list of entries")
    return values


def _index(number: Any, values: list[Any]) -> int:
    if type(number) is not int or not 0 <= number < len(values) or not isinstance(values[number], dict):
        raise FormatError(f"is damaged: it refers to entry {number!r:.40} of {len(values)}")
    return number
