"""A scan itself as a file: its vertices, triangles and colours, without labels."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.editing.files import checked_path
from scenewidget.editing.formats.seal import write_files
from scenewidget.engine.mesh import Mesh

__all__ = ["save_mesh", "scan_bytes"]

KINDS = ("ply", "obj", "glb", "stl", "off")


def save_mesh(mesh: Mesh, path: str | os.PathLike[str], *, overwrite: bool = False) -> list[Path]:
    """Write a scan: a mesh as PLY, OBJ, GLB, STL or OFF, a cloud as PLY.

    Labels go with `export`; those that were made on ``mesh`` fit what `load_mesh` reads from the file, since
    its triangles keep their order.

    Parameters
    ----------
    mesh : Mesh or PointCloud
    path : path
        Its suffix says the format. STL and OFF lose the colours.
    overwrite : bool
        As of `export`: whether a file may be replaced that no export wrote.

    Returns
    -------
    paths : list of Path

    Raises
    ------
    ValueError
        Another suffix.
    FileExistsError
        A file is there that no export wrote.

    Examples
    --------
    >>> import tempfile
    >>> import scenewidget as sw
    >>> mesh, _ = sw.datasets.load_room()
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = sw.save_mesh(mesh, f"{folder}/room.ply")
    ...     sw.load_mesh(f"{folder}/room.ply").n_faces == mesh.n_faces
    True
    """
    target = checked_path(path)
    kind = target.suffix.lower()[1:]
    if kind not in KINDS:
        listed = ", ".join(f".{name}" for name in KINDS)
        raise ValueError(f"a scan can be written as {listed}, not as {target.name!r}")
    if mesh.is_cloud and kind != "ply":
        raise ValueError(f"mesh is a point cloud, which is written as .ply only, not as {target.name!r}")
    contents = {target: [scan_bytes(mesh, kind)]}
    return write_files(contents, asked=target, overwrite=overwrite, inputs=[mesh.source])


def scan_bytes(mesh: Mesh, kind: str) -> bytes:
    """A scan as the content of a file, its faces in the same order; a cloud as PLY only.

    Parameters
    ----------
    mesh : Mesh or PointCloud
    kind : "ply" | "obj" | "glb" | "stl" | "off"

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> scan_bytes(analytic.square(2), "ply")[:3]
    b'ply'
    """
    import trimesh

    if mesh.is_cloud:
        return _cloud_bytes(mesh)
    makers: Any = trimesh
    colors: Any = None if mesh.vertex_colors is None else np.asarray(mesh.vertex_colors)
    shape = makers.Trimesh(mesh.vertices, mesh.faces, vertex_colors=colors, process=False, validate=False)
    content = shape.export(file_type=kind)
    return content.encode() if isinstance(content, str) else bytes(content)


def _cloud_bytes(cloud: Any) -> bytes:
    """A binary PLY of points, with the normals that were given and the colours."""
    columns = [("double", "<f8", ("x", "y", "z"), cloud.points)]
    if cloud.given_normals is not None:
        columns.append(("float", "<f4", ("nx", "ny", "nz"), cloud.given_normals))
    if cloud.vertex_colors is not None:
        columns.append(("uchar", "u1", ("red", "green", "blue"), cloud.vertex_colors))
    rows = np.empty(cloud.n_faces, dtype=[(names[0], dtype, 3) for _, dtype, names, _ in columns])
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {cloud.n_faces}\n"
    for kind, _, names, values in columns:
        rows[names[0]] = values
        head += "".join(f"property {kind} {name}\n" for name in names)
    return (head + "end_header\n").encode() + rows.tobytes()
