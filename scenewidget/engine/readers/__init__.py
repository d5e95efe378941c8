"""Reading scans: one door for every format, behind it one module each.

Goes in: a file, a trimesh or arrays. Comes out: a checked `Mesh`, whose ``report`` says what was repaired
or guessed. Nothing but `MeshError`, `TypeError` and `OSError` leaves this package, and what a file
declares is held against its size, and against `scan.MAX_BYTES`, before memory is asked for.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np

from scenewidget.engine.checks import warn_caller
from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import Mesh, MeshError
from scenewidget.engine.readers import e57, gltf, las, obj, off, pcd, ply, stl, table
from scenewidget.engine.readers.colors import as_bytes, at_vertices
from scenewidget.engine.readers.repair import checked_triangles, lost_precision, wound_alike
from scenewidget.engine.readers.scale import in_metres, scale_of
from scenewidget.engine.readers.scan import Notes, Scan
from scenewidget.engine.readers.sniff import CLOUDS, MESHES, kind_of
from scenewidget.engine.units import UnitName

__all__ = ["load", "load_cloud", "load_mesh"]

_READERS: dict[str, Callable[[Path, Notes], Scan]] = {
    "ply": ply.read,
    "obj": obj.read,
    "glb": gltf.read,
    "gltf": gltf.read,
    "stl": stl.read,
    "off": off.read,
}
_CLOUD_READERS: dict[str, Callable[[Path, Notes], Scan]] = {
    "ply": ply.read,
    "pcd": pcd.read,
    "las": las.read,
    "laz": las.read,
    "e57": e57.read,
    "glb": gltf.read,
    "gltf": gltf.read,
    "obj": obj.read,
    "off": off.read,
    **dict.fromkeys(("xyz", "pts", "asc", "txt", "csv"), table.read),
}


class _NoFacesError(MeshError):
    """There are vertices at most."""


def load_mesh(
    source: str | os.PathLike[str] | tuple[Any, Any] | Any,
    *,
    strict: bool = False,
    units: UnitName | None = None,
) -> Mesh:
    """Read a mesh from a file, a trimesh or arrays.

    Parameters
    ----------
    source : path, trimesh.Trimesh, Mesh, or (vertices, faces)
        Files: PLY, OBJ with its materials, GLB, glTF, STL, OFF, known by their content before their suffix;
        ``~`` is the home folder. Vertices and faces keep the numbers that they have in the file; the parts
        of a scene are put together with their transforms. Polygons are cut into triangles in their place,
        and ``faces_of_file`` says from which face each came. Colours of vertices, faces, materials and
        textures all become colours of vertices.
    strict : bool
        Refuse what would be repaired: faces with corners that don't exist or aren't finite, which are
        dropped otherwise, and faces that look to the other side than their neighbours, which are turned.
    units : str, optional
        "m", "cm", "mm", "in", "ft": what the numbers are; they are scaled to metres. "auto" takes the unit
        that size, density and room heights fit best. By default they are left as they are, with a warning
        where another unit fits much better than the metre. ``mesh.report`` names units that fit nearly as
        well as the one taken: a table of four feet looks much like one of four metres.

    Returns
    -------
    Mesh
        ``mesh.report`` has a line for everything that was repaired, dropped or guessed.

    Raises
    ------
    FileNotFoundError
        No such file.
    MeshError
        A format that we don't read, a damaged or truncated file, one that asks for more than 4 GB once
        decoded, or geometry that `Mesh` refuses.
    TypeError
        Something that is not one of the above.

    Warns
    -----
    UserWarning
        Something was lost: dropped faces, missing textures, digits. Or the unit is hardly the metre.

    Examples
    --------
    >>> mesh = load_mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    >>> mesh.n_faces, mesh.report
    (1, ())
    """
    if units is not None and units not in get_args(UnitName):
        names = ", ".join(map(repr, get_args(UnitName)))
        raise ValueError(f"units must be one of {names} or None, got {units!r:.60}")
    if isinstance(source, Mesh):
        return source if units is None else in_metres(source, units, Notes())
    notes = Notes()
    if isinstance(source, (str, os.PathLike)):
        mesh = _load_file(Path(source).expanduser(), notes, strict)
    elif isinstance(source, tuple):
        if len(source) != 2:
            raise TypeError(f"mesh as a tuple must be (vertices, faces), got {len(source)} entries")
        mesh = _from_arrays(*source, None, notes, strict)
    elif hasattr(source, "vertices") and hasattr(source, "faces"):
        mesh = _from_arrays(source.vertices, source.faces, _colors_of(source, notes), notes, strict)
    else:
        way = "; `scene.to_mesh()` puts its parts together" if hasattr(source, "to_mesh") else ""
        raise TypeError(
            "mesh must be a path, a trimesh.Trimesh, a scenewidget.Mesh or (vertices, faces), "
            f"got {type(source).__name__}{way}"
        )
    if units is not None or isinstance(source, (str, os.PathLike)):
        mesh = in_metres(mesh, units, notes)
    for line in notes.warned:
        warn_caller(f"{Path(mesh.source).name or 'mesh'}: {line}")
    return mesh


def load_cloud(
    source: str | os.PathLike[str] | Any, *, strict: bool = False, units: UnitName | None = None
) -> PointCloud:
    """Read a point cloud from a file or an array.

    Parameters
    ----------
    source : path, PointCloud, trimesh.PointCloud, or (n_points, 3) array
        Files: PCD (text, binary, compressed), PLY (of a mesh its vertices), XYZ, PTS, ASC, CSV; LAS and LAZ
        by the extra ``las``, E57 by the extra ``e57``. They are known by their content before their suffix.
    strict : bool
        Refuse points that aren't finite; they are dropped otherwise, and ``faces_of_file`` says which point
        of the file each one is.
    units : str, optional
        As of `load_mesh`.

    Returns
    -------
    PointCloud

    Raises
    ------
    FileNotFoundError, MeshError, TypeError
        As `load_mesh`.

    Examples
    --------
    >>> load_cloud([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    PointCloud(3 points)
    """
    if isinstance(source, PointCloud) and units is None:
        return source
    notes = Notes()
    if isinstance(source, (str, os.PathLike)):
        path = Path(source).expanduser()
        kind = kind_of(path, CLOUDS)
        if kind not in _CLOUD_READERS:
            raise MeshError(f"{path.name!r} is a mesh ({kind.upper()}): sw.load_mesh reads it")
        scan = _guarded(path, kind, _CLOUD_READERS[kind], notes)
        name, place = path.name, str(path.absolute())
    elif isinstance(source, PointCloud):
        scan, name, place = Scan(source.points, colors=source.vertex_colors), "cloud", source.source
        scan.normals, scan.viewpoint = source.given_normals, source.viewpoint  # type: ignore[attr-defined]
    elif hasattr(source, "vertices") and not hasattr(source, "faces"):
        scan, name, place = Scan(np.asarray(source.vertices, dtype=np.float64)), "cloud", ""
        colors = np.asarray(getattr(source, "colors", ()))
        if colors.ndim == 2 and len(colors) == len(scan.vertices):
            scan.colors = as_bytes(colors, notes)
    elif isinstance(source, (str, bytes, dict)) or source is None or not hasattr(source, "__len__"):
        raise TypeError(f"cloud must be a path or an (n_points, 3) array, got {type(source).__name__}")
    else:
        points = np.asarray(source)
        if points.dtype.kind not in "iuf" or points.ndim != 2 or points.shape[1] != 3:
            return PointCloud(points)
        scan, name, place = Scan(points.astype(np.float64)), "cloud", ""
    cloud = _cloud_of(scan, notes, strict, name, place, units)
    for line in notes.warned:
        warn_caller(f"{name}: {line}")
    return cloud


def load(
    source: str | os.PathLike[str] | Any, *, strict: bool = False, units: UnitName | None = None
) -> Mesh:
    """Read a scan: a `Mesh` or, of a file without faces, a `PointCloud`.

    Parameters
    ----------
    source : path, or what `load_mesh` takes
    strict, units
        As of `load_mesh`.

    Examples
    --------
    >>> load(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    Mesh(3 vertices, 1 faces)
    """
    if isinstance(source, (str, os.PathLike)):
        path = Path(source).expanduser()
        kind = kind_of(path, (*MESHES, *CLOUDS))
        if kind not in _READERS or (kind == "ply" and not ply.has_faces(path)):
            return load_cloud(path, strict=strict, units=units)
        if kind in _CLOUD_READERS:
            try:
                return load_mesh(path, strict=strict, units=units)
            except _NoFacesError:
                return load_cloud(path, strict=strict, units=units)
    if hasattr(source, "vertices") and not hasattr(source, "faces"):
        return load_cloud(source, strict=strict, units=units)
    return load_mesh(source, strict=strict, units=units)


def _cloud_of(
    scan: Scan, notes: Notes, strict: bool, name: str, source: str, units: UnitName | None
) -> PointCloud:
    n = len(scan.vertices)
    if n == 0:
        raise MeshError(f"{name!r} holds no points")
    is_good = scan.is_usable
    kept = None
    if not is_good.all():
        lost = n - int(is_good.sum())
        if strict or lost == n:
            raise MeshError(f"{name!r}: {lost} of {n} points are NaN, infinite or far from all others")
        notes.say(f"{lost} of {n} points were NaN, infinite or far from all others, and were left out")
        kept = np.flatnonzero(is_good)
    lost_precision(scan, notes)
    chosen = slice(None) if kept is None else kept
    viewpoint = scan.viewpoint
    if viewpoint is not None and viewpoint.ndim == 2 and kept is not None:
        viewpoint = viewpoint[kept]

    def built(factor: float) -> PointCloud:
        return PointCloud(
            scan.vertices[chosen] * factor,
            None if scan.normals is None else scan.normals[chosen],
            None if scan.colors is None else scan.colors[chosen],
            None if viewpoint is None else np.asarray(viewpoint) * factor,
            source=source,
            report=tuple(notes.lines),
            faces_of_file=kept,
            n_file_faces=n,
        )

    cloud = built(1.0)
    factor, line, is_doubtful = scale_of(cloud, units)
    if not line:
        return cloud
    notes.say(line, warn=is_doubtful)
    return built(factor)


def _load_file(path: Path, notes: Notes, strict: bool) -> Mesh:
    kind = kind_of(path, MESHES)
    if kind not in _READERS:
        raise MeshError(f"{path.name!r} is a point cloud ({kind.upper()}): sw.load_cloud reads it")
    scan = _guarded(path, kind, _READERS[kind], notes)
    if scan.n_polygons == 0:
        what = "points" if len(scan.vertices) else "nothing, or only curves"
        hint = "sw.load_cloud reads it as a point cloud" if len(scan.vertices) else "a surface mesh is needed"
        raise _NoFacesError(f"{path.name!r} holds no triangles, only {what}; {hint}")
    lost_precision(scan, notes)
    return _mesh_of(scan, notes, strict, repr(path.name), str(path.absolute()))


def _guarded(path: Path, kind: str, read: Callable[[Path, Notes], Scan], notes: Notes) -> Scan:
    """What the reader of a format makes of a file; all that it stumbles over is a `MeshError`."""
    try:
        with np.errstate(all="ignore"):
            return read(path, notes)
    except (MeshError, OSError):
        raise
    except MemoryError as error:
        raise MeshError(f"{path.name!r} needs more memory than there is; cut the scan in parts") from error
    except Exception as error:  # a damaged file breaks a reader in any way that there is
        raise MeshError(
            f"{path.name!r} is damaged, truncated or not of the format {kind.upper()} "
            f"({type(error).__name__}: {error!s:.200})"
        ) from error


def _mesh_of(scan: Scan, notes: Notes, strict: bool, name: str, source: str = "") -> Mesh:
    n_polygons = scan.n_polygons
    triangles, polygon = checked_triangles(scan, notes, strict=strict, name=name)
    if len(triangles) == 0:
        raise MeshError(f"{name} holds no triangle that could be used: all have fewer than three corners")
    vertices = scan.vertices
    is_far = ~scan.is_usable
    if is_far.any():
        is_used = np.zeros(len(vertices), dtype=bool)
        is_used[triangles] = True
        vertices = np.where((is_far & ~is_used)[:, None], 0.0, vertices)
    mesh = Mesh(vertices, triangles, scan.colors, source, polygon, n_polygons)
    turned = wound_alike(mesh, notes, strict=strict, name=name)
    if turned is mesh.faces:
        return dataclasses.replace(mesh, report=tuple(notes.lines)) if notes.lines else mesh
    return dataclasses.replace(mesh, faces=turned, report=tuple(notes.lines))


def _from_arrays(vertices: Any, faces: Any, colors: Any, notes: Notes, strict: bool) -> Mesh:
    """As from a file, where the arrays are such as a file could hold; else `Mesh` says what is wrong."""
    try:
        places, corners = np.asarray(vertices), np.asarray(faces)
    except ValueError:
        return Mesh(vertices, faces, colors)
    is_plain = places.dtype.kind in "iuf" and corners.dtype.kind in "iu"
    if not is_plain or places.shape[1:] != (3,) or corners.shape[1:] != (3,) or not len(corners):
        return Mesh(vertices, faces, colors)
    scan = Scan(np.asarray(places, dtype=np.float64), corners.reshape(-1))
    scan.colors = colors
    return _mesh_of(scan, notes, strict, "mesh")


def _colors_of(source: Any, notes: Notes) -> Any:
    """(n_vertices, 3) uint8 of a trimesh, or None."""
    visual = getattr(source, "visual", None)
    if visual is None or not getattr(visual, "defined", False):
        return None
    if visual.kind == "texture":
        n, material = len(source.vertices), visual.material
        uv = getattr(visual, "uv", None)
        picture = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
        if uv is None or len(uv) != n or picture is None:
            plain = getattr(material, "main_color", None)
            return None if plain is None else np.tile(np.asarray(plain, np.uint8)[:3], (n, 1))
        visual = visual.to_color()
    if visual.kind == "vertex":
        return np.asarray(visual.vertex_colors)[:, :3]
    if visual.kind == "face":
        notes.say("colours stand at the faces: a vertex has the mean of those around it")
        faces = np.repeat(np.asarray(visual.face_colors)[:, :3], 3, axis=0)
        return at_vertices(np.asarray(source.faces).reshape(-1), faces, len(source.vertices))
    return None
