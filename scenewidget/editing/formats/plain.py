"""Just the labels: an NPY array or a text file with a whole number a line, a face (or vertex) each."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from scenewidget.editing.formats.common import FormatError, Labels
from scenewidget.editing.formats.npz import read_array
from scenewidget.editing.formats.seal import Contents
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation

__all__ = ["read_npy", "read_text", "write_npy", "write_text"]


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
    return _labels(path, read_array(path.read_bytes(), "iu").astype(np.int64), mesh)


def read_text(path: Path, mesh: Mesh) -> Labels:
    """Labels of a text file, one a line."""
    if path.stat().st_size > 22 * max(mesh.n_faces, mesh.n_vertices) + 1_000:
        raise FormatError(f"{path.name!r} is larger than labels of this mesh can be")
    return _labels(path, np.array([int(line) for line in path.read_bytes().split()], dtype=np.int64), mesh)


def _labels(path: Path, values: IntArray, mesh: Mesh) -> Labels:
    if values.shape == (mesh.n_faces,):
        return Labels(values, "face")
    if values.shape == (mesh.n_vertices,):
        return Labels(values, "vertex")
    raise FormatError(
        f"{path.name!r} has labels of shape {values.shape}, but the mesh has {mesh.n_faces} faces and "
        f"{mesh.n_vertices} vertices"
    )
