"""Just the labels, one a face or vertex: an array, numbers in a text, a column of a table or of a cloud."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.editing.formats.common import (
    FormatError,
    Labels,
    label_column,
    no_labels,
    same_place,
    whole_numbers,
)
from scenewidget.editing.formats.npz import read_array
from scenewidget.editing.formats.seal import Contents
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.readers import las, pcd, table
from scenewidget.engine.readers.text import as_utf8, numbers, row_lengths
from scenewidget.engine.segmentation import Segmentation

__all__ = ["read_label", "read_las", "read_npy", "read_pcd", "read_text", "write_npy", "write_text"]

BYTES_A_ROW = 400  # of a table that a label stands in, at most


def write_npy(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """Labels as an int32 array."""
    file = io.BytesIO()
    np.save(file, segmentation.labels, allow_pickle=False)
    return {path: [file.getvalue()]}


def write_text(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """A label a line."""
    return {path: [("\n".join(map(str, segmentation.labels.tolist())) + "\n").encode()]}


def read_npy(path: Path, mesh: Mesh) -> Labels:
    """Labels of an NPY file."""
    if path.stat().st_size > 8 * max(mesh.n_faces, mesh.n_vertices) + 10_000:
        raise FormatError(f"{path.name!r} is larger than labels of this mesh can be")
    return _labels(path, whole_numbers(read_array(path.read_bytes(), "iufb"), "labels"), mesh)


def read_label(path: Path, mesh: Mesh) -> Labels:
    """Labels of a file like those of Semantic-KITTI: 16 bits of class, 16 of instance, 0 unlabeled."""
    data = path.read_bytes()
    if len(data) not in (4 * mesh.n_faces, 4 * mesh.n_vertices, 4 * mesh.n_file_faces):
        raise FormatError(
            f"{path.name!r} has {len(data)} bytes, but labels of this mesh take {4 * mesh.n_faces} (a face) "
            f"or {4 * mesh.n_vertices} (a vertex)"
        )
    values = np.frombuffer(data, "<u4").astype(np.int64)
    return _labels(path, np.where(values == 0, -1, values), mesh)


def read_text(path: Path, mesh: Mesh, *, property: str | None = None) -> Labels:  # noqa: A002  # as in import_labels
    """Labels of a text: one a line, as ``np.savetxt`` writes them, or a column of a table.

    Columns go by the names in the first line; without any, ``property`` is a number that counts from 1.
    """
    most = max(mesh.n_faces, mesh.n_vertices, mesh.n_file_faces)
    if path.stat().st_size > BYTES_A_ROW * most + 10_000:
        raise FormatError(f"{path.name!r} is larger than labels of this mesh can be")
    data = as_utf8(path.read_bytes())
    start = re.sub(rb"^[ \t]*#[^\n]*", b"", data[:4096].rpartition(b"\n")[0], flags=re.MULTILINE)
    if re.search(rb"[A-Za-z]", re.sub(rb"[eE][-+]?\d|nan|inf", b"", start, flags=re.IGNORECASE)):
        return _of_columns(path, table.columns_of(path)[1], mesh, property)
    if property is not None and property.isdecimal():
        columns = {str(k + 1): column for k, column in enumerate(table.columns_of(path)[0].T)}
        return _of_columns(path, columns, mesh, property)
    if property is not None:
        raise FormatError(
            f"{path.name!r} has no line with the names of its columns; property may be the number of one, "
            "counting from 1"
        )
    data = re.sub(rb"[,;]", b" ", re.sub(rb"#[^\n]*", b"", data))
    values, width = numbers(data), row_lengths(data)
    if len(values) == 2 * len(width) > 0 and (width == 2).all():  # behind the number of each
        pairs = values.reshape(-1, 2)
        if (np.diff(pairs[:, 0]) == 1).all() and pairs[0, 0] in (0, 1):
            values = pairs[:, 1]
    return _labels(path, whole_numbers(_without_count(values, mesh), "labels"), mesh)


def read_pcd(path: Path, mesh: Mesh, *, property: str | None = None) -> Labels:  # noqa: A002  # as in import_labels
    """Labels of a field of a PCD."""
    return _of_columns(path, pcd.columns_of(path), mesh, property)


def read_las(path: Path, mesh: Mesh, *, property: str | None = None) -> Labels:  # noqa: A002  # as in import_labels
    """Labels of a LAS or LAZ: its classes, or another number a point."""
    return _of_columns(path, las.columns_of(path), mesh, property)


def _of_columns(path: Path, columns: dict[str, Any], mesh: Mesh, wanted: str | None) -> Labels:
    if {"segment", "faces", "area"} <= set(columns):
        raise FormatError(f"{path.name!r} is a table of segments; it does not say which face is in which")
    name = label_column(columns, wanted)
    if name is None:
        raise no_labels(path, columns, wanted)
    if all(axis in columns for axis in "xyz"):
        place = np.stack([columns[axis] for axis in "xyz"], axis=1).astype(np.float64)
        if mesh.is_cloud and mesh.faces_of_file is not None and len(place) == mesh.n_file_faces:
            place = place[mesh.faces_of_file]
        if not same_place(place, mesh):
            raise FormatError(
                f"{path.name!r} has {len(place)} points that are not those of the scan ({mesh.n_vertices}): "
                "labels are of another one, or the points were moved or sorted"
            )
    return _labels(path, whole_numbers(np.asarray(columns[name]), name), mesh)


def _without_count(values: FloatArray, mesh: Mesh) -> FloatArray:
    """Labels without their number, which some programs write before them."""
    n = len(values) - 1
    is_counted = n in (mesh.n_faces, mesh.n_vertices, mesh.n_file_faces) and values[0] == n
    return values[1:] if is_counted and len(values) not in (mesh.n_faces, mesh.n_vertices) else values


def _labels(path: Path, values: IntArray, mesh: Mesh) -> Labels:
    if values.ndim == 2 and 1 in values.shape:  # a column or a row
        values = values.ravel()
    if values.shape == (mesh.n_faces,):
        return Labels(values, "face")
    if values.shape == (mesh.n_vertices,):
        return Labels(values, "vertex")
    if values.shape == (mesh.n_file_faces,) and mesh.faces_of_file is not None:
        return Labels(values[mesh.faces_of_file], "face")
    raise FormatError(
        f"{path.name!r} has labels of shape {values.shape}, but the mesh has {mesh.n_faces} faces and "
        f"{mesh.n_vertices} vertices"
    )
