"""Segmentations in the files of other tools, out and in again.

`export` writes PLY, NPZ, GLB, ScanNet's and SceneNN's pairs of files, and tables of the segments;
`import_labels` reads labels back onto a mesh. One module a format; each has ``write``, which gives what the
files hold, and ``read``.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.editing.files import checked_path
from scenewidget.editing.fingerprint import fingerprint
from scenewidget.editing.formats import glb, npz, plain, ply, scannet, scenenn, table
from scenewidget.editing.formats.common import FormatError, Labels, faces_from_vertices
from scenewidget.editing.formats.seal import Contents, write_files
from scenewidget.engine.mesh import Mesh, MeshError
from scenewidget.engine.readers import load
from scenewidget.engine.segmentation import Segmentation

__all__ = ["FormatError", "export", "import_labels"]


@dataclass(frozen=True)
class _Format:
    write: Callable[..., Contents] | None
    read: Callable[..., Labels] | None
    options: tuple[str, ...] = ()


_FORMATS = {
    "ply": _Format(ply.write, ply.read, ("per",)),
    "npz": _Format(npz.write, npz.read),
    "glb": _Format(glb.write, glb.read),
    "scannet": _Format(scannet.write, scannet.read),
    "scenenn": _Format(scenenn.write, scenenn.read),
    "csv": _Format(table.write_csv, plain.read_text),
    "parquet": _Format(table.write_parquet, None),
    "npy": _Format(plain.write_npy, plain.read_npy),
    "txt": _Format(plain.write_text, plain.read_text),
    "label": _Format(None, plain.read_label),
    "pcd": _Format(None, plain.read_pcd),
    "las": _Format(None, plain.read_las),
}
_SUFFIXES = {
    ".aggregation.json": "scannet",
    ".segs.json": "scannet",
    ".segs.v2.json": "scannet",
    ".json": "scannet",
    ".label": "label",
    ".ply": "ply",
    ".npz": "npz",
    ".glb": "glb",
    ".xml": "scenenn",
    ".csv": "csv",
    ".parquet": "parquet",
    ".npy": "npy",
    ".txt": "txt",
    **dict.fromkeys((".xyz", ".asc", ".pts", ".seg", ".labels"), "txt"),
    ".pcd": "pcd",
    ".las": "las",
    ".laz": "las",
}
_WITH_COLUMNS = ("ply", "npz", "csv", "txt", "pcd", "las")


def export(
    segmentation: Segmentation,
    mesh: Mesh | Any,
    path: str | os.PathLike[str],
    format: str | None = None,  # noqa: A002  # the contract's name for it
    *,
    overwrite: bool = False,
    **options: Any,
) -> list[Path]:
    """Write a segmentation in a format of other tools.

    Parameters
    ----------
    segmentation : Segmentation
    mesh : Mesh, path, …
        The mesh that it is of.
    path : path
    format : str, optional
        By default what the suffix says: "ply" (colours and a property ``instance``), "npz", "glb" (a node
        a segment), "scannet" (.aggregation.json and .segs.json), "scenenn" (.ply and .xml, choose by
        .xml), "csv" and "parquet" (the table of segments), "npy" and "txt" (a label a face).
    overwrite : bool
        What an export wrote is replaced; any other file, and the scan itself, only with True. That holds for
        all files that are written, the PLY beside an XML too. A file counts as written by an export as long
        as nobody has changed it; NPY, TXT, CSV and Parquet can't say so themselves, and outside of Linux only
        the process that wrote them knows.
    **options
        ``per="face"`` or ``"vertex"`` of "ply": what carries instance and colour.

    Returns
    -------
    paths : list of Path
        The files written, all of them or, on any trouble, none. In formats with labels per vertex a vertex
        gets the label of most of the area around it; a face on a boundary can come back as its neighbour.

    Raises
    ------
    ValueError
        An unknown format, or a segmentation of another mesh.
    FileExistsError
        A file is there that no export wrote, or that is the scan itself.
    OSError
        A file can't be written; the old ones are untouched.

    Examples
    --------
    >>> import tempfile
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> folder = tempfile.TemporaryDirectory()
    >>> [path.name for path in sw.export(seg, mesh, f"{folder.name}/square.ply")]
    ['square.ply']
    >>> folder.cleanup()
    """
    if not isinstance(segmentation, Segmentation):
        raise TypeError(f"segmentation must be a Segmentation, got {type(segmentation).__name__}")
    mesh = load(mesh)
    if segmentation.mesh is not mesh and fingerprint(segmentation.mesh) != fingerprint(mesh):
        raise ValueError(
            f"segmentation is of another mesh: of one with {fingerprint(segmentation.mesh)}, "
            f"but mesh has {fingerprint(mesh)}"
        )
    target = checked_path(path)
    name = _format_of(target, format)
    writer = _FORMATS[name].write
    if writer is None:
        raise ValueError(f"format {name!r} can only be read")
    for option in options:
        if option not in _FORMATS[name].options:
            raise TypeError(f"format {name!r} has no option {option!r}")
    return write_files(
        writer(segmentation, mesh, target, **options),
        asked=target,
        overwrite=overwrite,
        inputs=[mesh.source, segmentation.mesh.source],
    )


def import_labels(
    mesh: Mesh | Any,
    path: str | os.PathLike[str],
    format: str | None = None,  # noqa: A002  # as in export
    *,
    property: str | None = None,  # noqa: A002  # what PLY calls it
) -> Segmentation:
    """Labels from a file, on a mesh.

    Parameters
    ----------
    mesh : Mesh, path, …
        The mesh that the labels are of, in the order of its file.
    path : path
        What `export` wrote, or the like from other tools: PLY with labels per face or vertex, ScanNet's
        ``.aggregation.json``, SceneNN's ``.xml`` with its ``.ply``, NPY, NPZ, JSON or text with a number a
        face or vertex; a column of CSV or of CloudCompare's text, of PCD or LAS; ScanNet++'s and 3RScan's
        pairs of JSON; ``.label`` as of Semantic-KITTI. A negative label or NaN means unlabeled, in
        ``.label`` also 0.
    format : str, optional
        By default what the suffix says.
    property : str, optional
        Which property of a PLY, field of a PCD or LAS, array of an NPZ, or column of a table holds the
        labels, where its name is unusual. Case doesn't matter. Of a table without names its number, from 1.

    Returns
    -------
    Segmentation
        Labels per vertex become labels per face by majority of the three corners; where all three
        differ, the middle one counts. ``report["ambiguous faces"]`` is the number of those.

    Raises
    ------
    FileNotFoundError
    FormatError
        Damaged, not of this mesh, or without labels. A ValueError.

    Examples
    --------
    >>> import tempfile
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> folder = tempfile.TemporaryDirectory()
    >>> written = sw.export(seg, mesh, f"{folder.name}/square.glb")
    >>> sw.import_labels(mesh, written[0]).labels
    array([0, 0, 0, 0, 1, 1, 1, 1], dtype=int32)
    >>> folder.cleanup()
    """
    mesh = load(mesh)
    source = checked_path(path)
    name = _format_of(source, format)
    reader = _FORMATS[name].read
    if reader is None:
        raise FormatError(f"{source.name!r} is a table of segments; it does not say which face is in which")
    if property is not None and name not in _WITH_COLUMNS:
        raise ValueError(
            f"property names a column of {', '.join(_WITH_COLUMNS)}, and {source.name!r} is read as {name!r}"
        )
    if not source.exists():
        raise FileNotFoundError(f"label file {str(source)!r} does not exist")
    if not source.is_file():
        raise FormatError(f"{source.name!r} is no file")
    try:
        found = reader(source, mesh) if property is None else reader(source, mesh, property=property)
    except MeshError as error:  # of the readers of scans
        raise FormatError(str(error)) from error
    except FormatError as error:
        raise error if source.name in str(error) else FormatError(f"{source.name!r} {error}") from error
    except (
        ValueError,
        TypeError,
        LookupError,
        ArithmeticError,
        RecursionError,
        MemoryError,
        EOFError,
    ) as error:
        raise FormatError(f"{source.name!r} is damaged ({type(error).__name__}: {error!s:.200})") from error
    return _segmentation(mesh, found, source.name)


def _format_of(path: Path, name: str | None) -> str:
    if name is not None:
        if name not in _FORMATS:
            raise ValueError(f"format must be one of {', '.join(map(repr, _FORMATS))}, got {name!r:.60}")
        return name
    for suffix, found in _SUFFIXES.items():
        if path.name.lower().endswith(suffix):
            return found
    raise ValueError(
        f"can't tell the format of {path.name!r}; suffixes are {', '.join(_SUFFIXES)}, or give format="
    )


def _segmentation(mesh: Mesh, found: Labels, source: str) -> Segmentation:
    ambiguous = 0
    labels = found.values
    if found.per == "vertex":
        labels, ambiguous = faces_from_vertices(labels, mesh)
    ids, index = np.unique(labels, return_inverse=True)
    is_segment = ids >= 0
    dense = np.where(is_segment, np.cumsum(is_segment) - 1, -1)[index]
    kept = ids[is_segment].tolist()
    place = {i: k for k, i in enumerate(kept)}
    result = Segmentation.from_labels(
        mesh,
        dense,
        names=[found.names.get(i, "") for i in kept],
        confidence=found.confidence,
        groups=[place.get(found.groups.get(i, i), place[i]) for i in kept],
    )
    report = {
        "labels read from": source,
        "labels given per": found.per,
        "ambiguous faces": ambiguous,
        **found.report,
    }
    return dataclasses.replace(result, levels=found.levels, report=report)
