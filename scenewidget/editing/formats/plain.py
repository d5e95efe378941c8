"""Just the labels: an NPY array or a text file with a whole number a line, a face (or vertex) each."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from scenewidget.editing.formats.common import FormatError, Labels
from scenewidget.editing.formats.npz import read_array
from scenewidget.editing.formats.ply import whole_numbers
from scenewidget.editing.formats.seal import Contents
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation

__all__ = ["read_label", "read_npy", "read_text", "write_npy", "write_text"]


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
    return _labels(path, whole_numbers(read_array(path.read_bytes(), "iuf"), "labels"), mesh)


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


def read_text(path: Path, mesh: Mesh) -> Labels:
    """Labels of a text file, one a line, also such as ``np.savetxt`` writes."""
    if path.stat().st_size > 40 * max(mesh.n_faces, mesh.n_vertices) + 1_000:
        raise FormatError(f"{path.name!r} is larger than labels of this mesh can be")
    data = re.sub(rb"#[^\n]*", b"", path.read_bytes().removeprefix(b"\xef\xbb\xbf"))
    return _labels(path, whole_numbers(np.array([float(word) for word in data.split()]), "labels"), mesh)


def _labels(path: Path, values: IntArray, mesh: Mesh) -> Labels:
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
