"""A labeled mesh in few bytes: the format of the shipped room.

Marching cubes numbers vertices as it goes, so that neighbours in space are neighbours in the file. Vertices
are renumbered by first use, faces count backwards from the highest vertex so far (a new vertex is a 0),
positions (in steps of half a millimetre), colours and labels are differences to their predecessor; LZMA does
the rest.
"""

from __future__ import annotations

import io
import lzma
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import IntArray, Mesh

__all__ = ["STEP", "pack", "unpack"]

STEP = 0.0005  # metres


def pack(mesh: Mesh, labels: IntArray, names: Sequence[str]) -> bytes:
    """Bytes from which `unpack` restores the mesh, positions rounded to `STEP`, vertices in order of first
    use.

    Parameters
    ----------
    mesh : Mesh
        With colours. Vertices that no face uses are dropped.
    labels : (n_faces,) int
    names : sequence of str
    """
    if mesh.vertex_colors is None:
        raise ValueError("mesh has no vertex_colors; packing wants them")
    used, first_use = np.unique(mesh.faces, return_index=True)
    order = used[np.argsort(first_use)]
    new_index = np.empty(mesh.n_vertices, dtype=np.int64)
    new_index[order] = np.arange(len(order))
    corners = new_index[mesh.faces.ravel()]
    newest = np.maximum.accumulate(np.concatenate([[-1], corners[:-1]]))
    positions = np.round(mesh.vertices[order] / STEP).astype(np.int64)
    arrays = {
        "names": np.array(list(names)),
        "faces": _planes(newest + 1 - corners),
        "vertices": _planes(_differences(positions).T),
        "colors": _planes(_differences(mesh.vertex_colors[order].astype(np.int64)).T),
        "labels": _planes(_differences(labels.astype(np.int64))),
    }
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **arrays)
    return lzma.compress(stream.getvalue(), preset=9 | lzma.PRESET_EXTREME)


def unpack(data: bytes) -> tuple[Mesh, IntArray, tuple[str, ...]]:
    """Mesh, label of each face and names that `pack` was given."""
    with np.load(io.BytesIO(lzma.decompress(data)), allow_pickle=False) as arrays:
        names = tuple(str(name) for name in arrays["names"])
        codes = _from_planes(arrays["faces"])
        vertices = _from_planes(arrays["vertices"]).reshape(3, -1).cumsum(axis=1).T * STEP
        colors = _from_planes(arrays["colors"]).reshape(3, -1).cumsum(axis=1).T
        labels = _from_planes(arrays["labels"]).cumsum()
    # a 0 opens a vertex, so the highest vertex before each corner is the number of zeros before it, less one
    n_open = np.concatenate([[0], np.cumsum(codes == 0)[:-1]])
    faces = (n_open - codes).reshape(-1, 3)
    return Mesh(vertices, faces, colors.astype(np.uint8)), labels.astype(np.int32), names


def _differences(values: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    return np.diff(values, axis=0, prepend=np.zeros_like(values[:1]))


def _planes(values: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
    """(3, n) uint8: low, middle and high bytes of whole numbers, signs folded in: 0, -1, 1, -2, …"""
    folded = np.where(values < 0, -2 * values - 1, 2 * values).ravel()
    if folded.max(initial=0) >= 1 << 24:
        raise ValueError(f"a difference of {int(folded.max()) // 2} is too large for three bytes")
    return np.stack([(folded >> shift & 255).astype(np.uint8) for shift in (0, 8, 16)])


def _from_planes(planes: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    folded = sum(planes[i].astype(np.int64) << (8 * i) for i in range(3))
    values: npt.NDArray[np.int64] = np.where(folded & 1, -(folded + 1) // 2, folded // 2)
    return values
