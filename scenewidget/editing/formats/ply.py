"""PLY: colours and a property ``instance``, on the faces or on the vertices.

Turk (1994), *The PLY polygon file format*. Names of segments go into comments,
``comment segment 3 "chair"``, as JSON, and groups as well, ``comment part 7 of 3``.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.editing.formats.common import (
    FormatError,
    Labels,
    clean_name,
    label_column,
    no_labels,
    same_place,
    vertices_from_faces,
    whole_numbers,
)
from scenewidget.editing.formats.seal import SEAL, Contents
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.readers.ply import columns_of
from scenewidget.engine.segmentation import Segmentation
from scenewidget.palette import segment_colors

__all__ = ["read", "write"]

HEADER_ROOM = 60_000  # bytes of header that readers accept


def write(segmentation: Segmentation, mesh: Mesh, path: Path, *, per: str = "face") -> Contents:
    """The mesh with colours and instances; see `export`."""
    if per not in ("face", "vertex"):
        raise ValueError(f"per must be 'face' or 'vertex', got {per!r}")
    per = "vertex" if mesh.is_cloud else per
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
    header += [f"comment part {i} of {whole}" for i, whole in enumerate(segmentation.groups) if whole != i]
    header += [f"element vertex {mesh.n_vertices}", *(f"property {t} {name}" for name, _, _, t in columns)]
    if not mesh.is_cloud:
        header += [f"element face {mesh.n_faces}", "property list uchar int vertex_indices"]
        header += [f"property {t} {name}" for name, _, _, t in face_columns]
    header.append("end_header\n")
    head = "\n".join(header).encode("ascii")
    if len(head) > HEADER_ROOM:
        raise ValueError(
            f"the names of {segmentation.n_segments} segments don't fit into the header of a PLY; "
            "choose NPZ or GLB"
        )
    return {path: [head, vertices.data] if mesh.is_cloud else [head, vertices.data, faces.data]}


def _color_columns(colors: npt.NDArray[np.uint8]) -> list[tuple[str, Any, str, str]]:
    return [(name, colors[:, k], "u1", "uchar") for k, name in enumerate(("red", "green", "blue"))]


def _table(n: int, columns: list[tuple[str, Any, str, str]]) -> npt.NDArray[Any]:
    out = np.zeros(n, dtype=[(name, layout) for name, _, layout, _ in columns])
    for name, values, _, _ in columns:
        out[name] = values
    return out.view(np.uint8)


def read(path: Path, mesh: Mesh, *, property: str | None = None) -> Labels:  # noqa: A002  # as in import_labels
    """Labels of a PLY: those of its faces if it has any, else those of its vertices.

    They are in the property of that name, or else in the first that has a usual one; case doesn't matter,
    nor what CloudCompare puts before it ("scalar_").
    """
    elements, comments = columns_of(path)
    names, groups = {}, {}
    for comment in comments:
        if match := re.fullmatch(r'segment (\d{1,9}) (".*")', comment):
            names[int(match[1])] = clean_name(json.loads(match[2]))
        elif match := re.fullmatch(r"part (\d{1,9}) of (\d{1,9})", comment):
            groups[int(match[1])] = int(match[2])
    vertices = elements.get("vertex", {})
    if all(axis in vertices for axis in "xyz"):
        place = np.stack([vertices[axis].astype(np.float64) for axis in "xyz"], axis=1)
        if mesh.is_cloud and mesh.faces_of_file is not None and len(place) == mesh.n_file_faces:
            place = place[mesh.faces_of_file]
        if not same_place(place, mesh):
            raise FormatError(
                f"{path.name!r} has {len(place)} vertices that are not those of the mesh "
                f"({mesh.n_vertices}): "
                "labels are of another mesh, or the vertices were moved or sorted"
            )
    sizes = {"face": mesh.n_file_faces, "vertex": mesh.n_file_faces if mesh.is_cloud else mesh.n_vertices}
    for element in ("face", "vertex"):
        columns = elements.get(element, {})
        label = label_column(columns, property)
        if label is None:
            continue
        if not isinstance(columns[label], np.ndarray):
            raise FormatError(f"{path.name!r} has lists of {label!r:.60} where a number each is expected")
        values = whole_numbers(columns[label], label)
        if len(values) != sizes[element]:
            raise FormatError(
                f"{path.name!r} has {len(values)} labels on its {element} element, but the mesh has "
                f"{sizes[element]}"
            )
        corners = columns.get("vertex_indices", columns.get("vertex_index"))
        if element == "face" and not _are_faces(corners, mesh):
            raise FormatError(f"{path.name!r} has other faces than the mesh, or in another order")
        if mesh.faces_of_file is not None and (element == "face" or mesh.is_cloud):
            values = values[mesh.faces_of_file]
        return Labels(values, "face" if element == "face" else "vertex", names, groups)
    found = sorted({name for columns in elements.values() for name in columns})
    raise no_labels(path, found, property)


def _are_faces(corners: Any, mesh: Mesh) -> bool:
    """Whether lists of corners are those of the mesh, whichever way they run; polygons aren't compared."""
    counts = getattr(corners, "counts", None)  # of a list; a damaged file may have a single number
    if counts is None or mesh.faces_of_file is not None or not (counts == 3).all():
        return True
    rows = np.sort(corners.values.reshape(-1, 3), axis=1)
    return np.array_equal(rows, np.sort(mesh.faces, axis=1))
