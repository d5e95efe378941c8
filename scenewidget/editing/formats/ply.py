"""PLY: colours and a property ``instance``, on the faces or on the vertices.

Turk (1994), *The PLY polygon file format*. Names of segments go into comments,
``comment segment 3 "chair"``, as JSON.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from scenewidget.editing.formats.common import (
    FormatError,
    Labels,
    clean_name,
    same_place,
    vertices_from_faces,
)
from scenewidget.editing.formats.seal import SEAL, Contents
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation
from scenewidget.palette import segment_colors

__all__ = ["LABEL_NAMES", "read", "read_columns", "write"]

LABEL_NAMES = (
    "instance",
    "label",
    "segment",
    "object",
    "objectid",
    "segment_id",
    "instance_id",
    "category_id",
)
HEADER_ROOM = 60_000  # bytes of header that readers accept
TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}


def write(segmentation: Segmentation, mesh: Mesh, path: Path, *, per: str = "face") -> Contents:
    """The mesh with colours and instances; see `export`."""
    if per not in ("face", "vertex"):
        raise ValueError(f"per must be 'face' or 'vertex', got {per!r}")
    colors = segment_colors(segmentation)
    as_float = mesh.vertices.astype(np.float32)
    is_exact = np.array_equal(as_float, mesh.vertices)
    position = "float" if is_exact else "double"
    columns: list[tuple[str, Any, str, str]] = [
        (axis, (as_float if is_exact else mesh.vertices)[:, k], "<f4" if is_exact else "<f8", position)
        for k, axis in enumerate("xyz")
    ]
    face_columns: list[tuple[str, Any, str, str]] = []
    if per == "vertex":
        labels = vertices_from_faces(segmentation.labels, mesh)
        columns += _color_columns(colors[labels])
        columns.append(("instance", labels, "<i4", "int"))
    else:
        if mesh.vertex_colors is not None:
            columns += _color_columns(mesh.vertex_colors)
        face_columns = [*_color_columns(colors[segmentation.labels])]
        face_columns.append(("instance", segmentation.labels, "<i4", "int"))
    vertices = _table(mesh.n_vertices, columns)
    corners = [("n", np.uint8(3), "u1", ""), ("corners", mesh.faces, "(3,)<i4", "")]
    faces = _table(mesh.n_faces, [*corners, *face_columns])
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment {SEAL}",
        f"comment instances per {per}, -1 unlabeled",
    ]
    header += [f"comment segment {i} {json.dumps(name)}" for i, name in enumerate(segmentation.names) if name]
    header += [f"element vertex {mesh.n_vertices}", *(f"property {t} {name}" for name, _, _, t in columns)]
    header += [f"element face {mesh.n_faces}", "property list uchar int vertex_indices"]
    header += [*(f"property {t} {name}" for name, _, _, t in face_columns), "end_header\n"]
    head = "\n".join(header).encode("ascii")
    if len(head) > HEADER_ROOM:
        raise ValueError(
            f"the names of {segmentation.n_segments} segments don't fit into the header of a PLY; "
            "choose NPZ or GLB"
        )
    return {path: [head, vertices.data, faces.data]}


def _color_columns(colors: npt.NDArray[np.uint8]) -> list[tuple[str, Any, str, str]]:
    return [(name, colors[:, k], "u1", "uchar") for k, name in enumerate(("red", "green", "blue"))]


def _table(n: int, columns: list[tuple[str, Any, str, str]]) -> npt.NDArray[Any]:
    out = np.zeros(n, dtype=[(name, layout) for name, _, layout, _ in columns])
    for name, values, _, _ in columns:
        out[name] = values
    return out.view(np.uint8)


def read(path: Path, mesh: Mesh) -> Labels:
    """Labels of a PLY: those of its faces if it has any, else those of its vertices."""
    with path.open("rb") as file:
        elements, comments = read_columns(file, path.stat().st_size)
    names = {}
    for comment in comments:
        match = re.fullmatch(r'segment (\d{1,9}) (".*")', comment)
        if match:
            names[int(match[1])] = clean_name(json.loads(match[2]))
    vertices = elements.get("vertex", {})
    if all(axis in vertices for axis in "xyz"):
        place = np.stack([vertices[axis].astype(np.float64) for axis in "xyz"], axis=1)
        if not same_place(place, mesh):
            raise FormatError(
                f"{path.name!r} has {len(place)} vertices that are not those of the mesh "
                f"({mesh.n_vertices}): "
                "labels are of another mesh, or the vertices were moved or sorted"
            )
    for element, per, size in (("face", "face", mesh.n_faces), ("vertex", "vertex", mesh.n_vertices)):
        columns = elements.get(element, {})
        label = next((name for name in LABEL_NAMES if name in columns), None)
        if label is None:
            continue
        values = whole_numbers(columns[label], label)
        if len(values) != size:
            raise FormatError(
                f"{path.name!r} has {len(values)} labels on its {element} element, but the mesh has {size}"
            )
        corners = columns.get("vertex_indices", columns.get("vertex_index"))
        if per == "face" and corners is not None and not np.array_equal(corners, mesh.faces):
            raise FormatError(f"{path.name!r} has other faces than the mesh, or in another order")
        return Labels(values, "face" if per == "face" else "vertex", names)
    found = sorted({name for columns in elements.values() for name in columns})
    raise FormatError(
        f"{path.name!r} has no labels: none of its properties ({', '.join(found)[:300]}) is called "
        f"{', '.join(LABEL_NAMES)}"
    )


def whole_numbers(values: npt.NDArray[Any], name: str) -> IntArray:
    """Labels as int64; FormatError if they are no whole numbers."""
    if (
        values.dtype.kind == "f"
        and not (np.isfinite(values) & (values == np.floor(values)) & (np.abs(values) < 2**53)).all()
    ):
        raise FormatError(f"holds values of {name!r} that are not whole numbers")
    return values.astype(np.int64)


# --- a reader of columns --------------------------------------------------------------------------

Columns = dict[str, npt.NDArray[Any]]
_Property = tuple[str, str, str]  # name, type, type of the count if it is a list, else ""


def read_columns(file: BinaryIO, size: int) -> tuple[dict[str, Columns], list[str]]:
    """All scalar columns of a PLY by element, and lists where each row has three entries; its comments.

    Whatever the header promises is checked against the size of the file before memory is taken.
    """
    order, elements, comments = _read_header(file)
    out: dict[str, Columns] = {}
    if order == "":
        lines = file.read().split(b"\n")
        start = 0
        for name, count, properties in elements:
            if count > len(lines) - start:
                raise FormatError(
                    f"is truncated: {count} of {name!r} are promised, {len(lines) - start} lines follow"
                )
            out[name] = _text_columns(lines[start : start + count], properties)
            start += count
        return out, comments
    for name, count, properties in elements:
        fields = []
        for k, (_, type_, count_type) in enumerate(properties):
            if count_type:  # triangles only: what our meshes have
                fields += [(f"n{k}", f"{order}{count_type}"), (f"c{k}", f"(3,){order}{type_}")]
            else:
                fields.append((f"c{k}", f"{order}{type_}"))
        layout = np.dtype(fields)
        if count * layout.itemsize > size - file.tell():
            raise FormatError(
                f"is damaged, truncated or not of triangles: {count} of {name!r} take "
                f"{count * layout.itemsize} bytes, but {size - file.tell()} follow"
            )
        block = np.frombuffer(file.read(count * layout.itemsize), layout)
        columns = {}
        for k, (column, _, count_type) in enumerate(properties):
            if count_type and not (block[f"n{k}"] == 3).all():
                raise FormatError(f"has lists {column!r} with other than three entries")
            columns[column] = block[f"c{k}"]
        out[name] = columns
    return out, comments


def _text_columns(lines: list[bytes], properties: list[_Property]) -> Columns:
    width = sum(4 if count_type else 1 for _, _, count_type in properties)
    rows = [line.split() for line in lines]
    if any(len(row) != width for row in rows):
        raise FormatError(f"is damaged: a row has not the {width} numbers that the header promises")
    values = np.array(rows, dtype=object).reshape(len(rows), width)
    columns, at = {}, 0
    for name, type_, count_type in properties:
        if count_type:
            if any(int(x) != 3 for x in values[:, at]):
                raise FormatError(f"has lists {name!r} with other than three entries")
            columns[name] = values[:, at + 1 : at + 4].astype(np.float64).astype(type_)
            at += 4
        else:
            columns[name] = values[:, at].astype(np.float64)
            at += 1
    return columns


def _read_header(file: BinaryIO) -> tuple[str, list[tuple[str, int, list[_Property]]], list[str]]:
    if file.readline(100).strip() != b"ply":
        raise FormatError("does not start with 'ply': it is not a PLY file, or damaged")
    order: str | None = None
    elements: list[tuple[str, int, list[_Property]]] = []
    comments: list[str] = []
    for _ in range(20_000):
        line = file.readline(10_000)
        if not line:
            raise FormatError("is truncated: its PLY header has no end")
        text = line.decode("utf-8", "replace").strip()
        words = text.split()
        if words == ["end_header"]:
            break
        if words[:1] == ["comment"]:
            comments.append(text[len("comment ") :])
        elif words[:1] == ["format"] and len(words) == 3:
            order = ORDERS.get(words[1])
        elif words[:1] == ["element"]:
            if len(words) != 3 or not re.fullmatch(r"\d{1,12}", words[2]):
                raise FormatError(f"is damaged: its header says {text!r:.100}")
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements_types = words[1:-1] if words[1:2] != ["list"] else words[2:-1]
            if not elements or not elements_types or any(t not in TYPES for t in elements_types):
                raise FormatError(f"is damaged: its header says {text!r:.100}")
            is_list = words[1] == "list"
            if len(elements_types) != 1 + is_list or (is_list and TYPES[elements_types[0]][0] == "f"):
                raise FormatError(f"is damaged: its header says {text!r:.100}")
            count_type = TYPES[elements_types[0]] if is_list else ""
            elements[-1][2].append((words[-1], TYPES[elements_types[-1]], count_type))
    else:
        raise FormatError("has a PLY header without end")
    if order is None:
        raise FormatError("has no format that PLY knows")
    if any(not properties for _, _, properties in elements):
        raise FormatError("has an element without properties")
    return order, elements, comments
