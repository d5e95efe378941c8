"""What a file is, by its first bytes before its suffix, and what to do with what isn't read."""

from __future__ import annotations

import re
from pathlib import Path

from scenewidget.engine.mesh import MeshError

__all__ = ["CLOUDS", "MESHES", "kind_of"]

MESHES = ("ply", "obj", "glb", "gltf", "stl", "off")
CLOUDS = ("pcd", "las", "laz", "e57", "xyz", "pts", "csv", "txt", "asc")
HEAD = 4096

_MAGIC = (  # what a file begins with, and what it is then
    (rb"(?i:ply)[ \t]*[\r\n]", "ply"),
    (rb"glTF", "glb"),
    (rb"LASF", "las"),
    (rb"ASTM-E57", "e57"),
    (rb"(#[^\n]*\n\s*)*(# \.PCD|VERSION [.\d]+\s+FIELDS |FIELDS [a-z])", "pcd"),
    (rb"\s*((ST)?C?N?4?n?OFF|(st)?c?n?off)\b", "off"),
    (rb"\s*\{", "gltf"),
)
_FOREIGN = (  # what a file begins with, what it is, and the way out
    (
        rb"version https://git-lfs",
        "a pointer of Git LFS, not the file itself",
        "run `git lfs pull` in its repository",
    ),
    (rb"\s*<(!DOCTYPE html|html)", "a web page", "the download went wrong: fetch the file itself"),
    (rb"PXR-USDC|#usda", "a USD scene", "save it as GLB, with textures"),
    (rb"\x1f\x8b|7z\xbc\xaf|Rar!|BZh|\xfd7zXZ", "a compressed archive", "unpack it first"),
    (rb"Kaydara FBX|; FBX", "an FBX scene", "save it as GLB, for example with Blender"),
    (rb"BLENDER", "a Blender project", "export it as GLB"),
    (rb"ISO-10303-21", "a STEP model", "tessellate it and save it as STL or PLY"),
    (rb"\x89PNG|\xff\xd8\xff|GIF8|RIFF....WEBP", "a picture", "a mesh or a point cloud is needed"),
    (rb"%PDF", "a PDF", "a mesh or a point cloud is needed"),
    (rb"SQLite format 3", "a database or a project file", "sw.Session.open opens .swproj files"),
    (rb"\x89HDF", "an HDF5 file", "save its mesh as PLY"),
    (rb"\s*<\?xml[^>]*>\s*(<!--.*?-->\s*)*<COLLADA", "a COLLADA scene", "save it as GLB"),
    (rb"DRACO", "a bare Draco stream", "save it as GLB or PLY"),
    (rb"\x93NUMPY", "a NumPy array", "load it, and give (vertices, faces) or PointCloud(points)"),
)
_SUFFIXES = {
    ".usdz": ("a USDZ scene", "export the scan as GLB, with textures"),
    ".zip": ("an archive", "unpack it and give the mesh inside"),
    ".3mf": ("a 3MF model", "save it as PLY or GLB"),
    ".npz": ("an archive of NumPy arrays", "load it, and give (vertices, faces) or PointCloud(points)"),
    ".ptx": ("a PTX scan", "save it as E57, LAS or PLY, for example with CloudCompare"),
    ".fls": ("a raw scan of FARO", "export it as E57"),
    ".rcp": ("a ReCap project", "export it as E57 or LAS"),
    ".3ds": ("a 3DS model", "save it as GLB or OBJ"),
    ".dae": ("a COLLADA scene", "save it as GLB"),
    ".x3d": ("an X3D scene", "save it as GLB or PLY"),
    ".wrl": ("a VRML scene", "save it as GLB or PLY"),
    ".vtk": ("a VTK file", "save it as PLY or STL"),
    ".splat": ("Gaussian splats", "save them as PLY"),
    ".spz": ("Gaussian splats", "save them as PLY"),
    ".ksplat": ("Gaussian splats", "save them as PLY"),
}


def kind_of(path: Path, suffixes: tuple[str, ...]) -> str:
    """Name of the format of the file at ``path``, "ply" for example; ``suffixes`` are those looked for.

    Raises
    ------
    FileNotFoundError
        No such file.
    MeshError
        A folder, an empty file, or a format that isn't read; the message says what it is and what to do.
    """
    if re.match(r"[a-z][a-z0-9+.-]+:/+[^/]", str(path), re.IGNORECASE) and not path.exists():
        raise FileNotFoundError(f"{str(path)!r} is a URL, and no file of this machine: fetch it first")
    if not path.exists():
        raise FileNotFoundError(f"mesh file {str(path)!r} does not exist (looked in {str(Path.cwd())!r})")
    if path.is_dir():
        raise MeshError(f"{str(path)!r} is a folder, not a mesh file; give one of the files in it")
    if not path.is_file():
        raise MeshError(f"{str(path)!r} is no regular file")
    if path.stat().st_size == 0:
        raise MeshError(f"{path.name!r} is empty")
    with path.open("rb") as file:
        head = file.read(HEAD)
    suffix = path.suffix.lower()
    for pattern, kind in _MAGIC:
        if re.match(pattern, head) and (kind != "gltf" or suffix in (".gltf", ".glb")):
            return kind
    for pattern, what, advice in _FOREIGN:
        if re.match(pattern, head, re.DOTALL):
            raise MeshError(f"{path.name!r} is {what}; {advice}")
    if suffix in _SUFFIXES:
        what, advice = _SUFFIXES[suffix]
        raise MeshError(f"{path.name!r} is {what}, which isn't read; {advice}")
    if head.startswith(b"PK\x03\x04"):
        raise MeshError(f"{path.name!r} is an archive; unpack it and give the mesh inside")
    if suffix[1:] in (*MESHES, *CLOUDS):
        return suffix[1:]
    listed = ", ".join(f".{name}" for name in suffixes)
    raise MeshError(
        f"can't read {path.name!r}: its content is of no known kind, and its suffix must be one of {listed}"
    )
