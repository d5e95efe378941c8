"""NPZ: labels, names, confidence and levels as NumPy arrays, and what tells the mesh from others."""

from __future__ import annotations

import io
import math
import re
import sys
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.editing.edits import MAX_NAME
from scenewidget.editing.fingerprint import fingerprint, is_sketch_of, sketch
from scenewidget.editing.formats.common import FormatError, Labels, clean_name, label_column
from scenewidget.editing.formats.seal import SEAL, Contents
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.segmentation import LEVELS, Segmentation

__all__ = ["read", "read_array", "write"]

_HEADER = re.compile(  # what NumPy writes; its own reader would evaluate it
    rb"\{'descr': '([<>|][biufU]\d{1,6})', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,18}, ?)*(?:\d{1,18})?)\), \}\s*"
)


def write(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """Arrays ``labels``, ``names``, ``groups``, ``confidence``, ``level_…`` and ``mesh``; see `export`."""
    arrays: dict[str, Any] = {
        "labels": segmentation.labels,
        "names": np.array(segmentation.names, dtype=np.str_) if segmentation.names else np.empty(0, "<U1"),
        "groups": np.array(segmentation.groups, dtype=np.int32),
        "confidence": segmentation.confidence,
        "mesh": np.array(fingerprint(mesh).digest),
        "sketch": sketch(mesh),
    }
    arrays |= {f"level_{name}": parts for name, parts in segmentation.levels.items()}
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    with zipfile.ZipFile(file, "a") as archive:
        archive.comment = SEAL.encode()
    return {path: [file.getvalue()]}


def read(path: Path, mesh: Mesh, *, property: str | None = None) -> Labels:  # noqa: A002  # as in import_labels
    """Labels of an NPZ: its array ``labels``, or of a usual name, or its only one; the rest is optional."""
    most = max(mesh.n_faces, mesh.n_vertices)
    if path.stat().st_size > 1_000 * most + 1_000_000:
        raise FormatError(f"{path.name!r} is larger than labels of this mesh can be")
    try:
        with zipfile.ZipFile(io.BytesIO(path.read_bytes())) as archive:
            members = {name.removesuffix(".npy"): name for name in archive.namelist()}
            name = _name_of_labels(members, property)
            if name is None:
                raise FormatError(
                    f"{path.name!r} has no array {property or 'labels'!r}, only {', '.join(members)[:200]}; "
                    "property= names another"
                )
            labels = _member(archive, members[name], "iu", most)
            if labels.shape not in ((mesh.n_faces,), (mesh.n_vertices,)):
                raise FormatError(
                    f"{path.name!r} has labels of shape {labels.shape}, but the mesh has {mesh.n_faces} "
                    f"faces and {mesh.n_vertices} vertices"
                )
            per_face = labels.shape == (mesh.n_faces,)
            if not _is_of(archive, members, mesh, per_face=per_face):
                raise FormatError(
                    f"{path.name!r} belongs to another mesh than this one of {fingerprint(mesh)}: its "
                    "triangles lie elsewhere or in another order; give the scan that the labels were made on"
                )
            names = _member(archive, members["names"], "U", most).tolist() if "names" in members else []
            groups = _member(archive, members["groups"], "iu", most).tolist() if "groups" in members else []
            confidence = None
            if per_face and "confidence" in members:
                confidence = _per_face(archive, members["confidence"], "f", mesh)
                if not ((confidence >= 0) & (confidence <= 1)).all():
                    raise FormatError(f"{path.name!r} has a confidence outside 0..1")
            levels: dict[str, IntArray] = {
                str(level): _per_face(archive, members[f"level_{level}"], "iu", mesh).astype(np.int32)
                for level in LEVELS
                if per_face and f"level_{level}" in members
            }
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise FormatError(f"{path.name!r} is damaged or no NPZ ({error!s:.200})") from error
    return Labels(
        labels.astype(np.int64),
        "face" if per_face else "vertex",
        {i: clean_name(name) for i, name in enumerate(names)},
        dict(enumerate(groups)),
        confidence,
        levels,
    )


def _name_of_labels(members: dict[str, str], wanted: str | None) -> str | None:
    if wanted is None and "labels" in members:
        return "labels"
    only = next(iter(members)) if wanted is None and len(members) == 1 else None
    return label_column(members, wanted) or only


def _is_of(archive: zipfile.ZipFile, members: dict[str, str], mesh: Mesh, *, per_face: bool) -> bool:
    """Whether labels are of a mesh, as far as they say: of the same numbers, or of the same faces rounded."""
    if "mesh" not in members or str(_member(archive, members["mesh"], "U", 1)) == fingerprint(mesh).digest:
        return True
    return (
        per_face
        and "sketch" in members
        and is_sketch_of(_member(archive, members["sketch"], "f", mesh.n_faces), mesh)
    )


def _per_face(archive: zipfile.ZipFile, name: str, kinds: str, mesh: Mesh) -> npt.NDArray[Any]:
    array = _member(archive, name, kinds, mesh.n_faces)
    if array.shape != (mesh.n_faces,):
        raise FormatError(f"has an array {name!r:.60} of shape {array.shape} for {mesh.n_faces} faces")
    return array


def _member(archive: zipfile.ZipFile, name: str, kinds: str, most: int) -> npt.NDArray[Any]:
    limit = most * (4 * MAX_NAME if kinds == "U" else 8) + 10_000
    info = archive.getinfo(name)
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise FormatError(f"has an array {name!r:.60} that is compressed in a way that NumPy doesn't know")
    if info.file_size > limit:
        raise FormatError(f"has an array {name!r:.60} larger than any of this mesh can be")
    with archive.open(name) as file:
        return read_array(file.read(limit), kinds)


def read_array(data: bytes, kinds: str) -> npt.NDArray[Any]:
    """An array in NumPy's format out of bytes, of a kind of dtype (as in ``dtype.kind``); never objects."""
    first = 10 if data[6:7] == b"\x01" else 12  # of the header: its length takes two or four bytes
    start = first + int.from_bytes(data[8:first], "little")
    found = _HEADER.fullmatch(data[first:start])
    if (
        data[:6] != b"\x93NUMPY"
        or data[6:8] not in (b"\x01\0", b"\x02\0", b"\x03\0")
        or found is None
        or start > len(data)
    ):
        raise FormatError("has an array that is damaged or not of plain numbers")
    dtype, is_fortran = np.dtype(found[1].decode()), found[2] == b"True"
    shape = tuple(int(size) for size in found[3].replace(b" ", b"").split(b",") if size)
    if dtype.kind not in kinds:
        raise FormatError(f"has an array of dtype {dtype!s:.60}, where one of kind {kinds!r} is expected")
    if math.prod(shape) * dtype.itemsize != len(data) - start:
        raise FormatError(f"has an array whose shape {shape!r:.60} does not fit its {len(data)} bytes")
    if (
        dtype.kind == "U"
        and (np.frombuffer(data, dtype.byteorder + "u4", offset=start) > sys.maxunicode).any()
    ):
        raise FormatError("has an array of text that holds no letters")
    return np.frombuffer(data, dtype, offset=start).reshape(shape, order="F" if is_fortran else "C")
