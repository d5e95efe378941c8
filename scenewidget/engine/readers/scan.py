"""What a file of a scanner says, before anything about it is judged, and the limits of what is read.

Every reader makes a `Scan`; `scenewidget.engine.readers` checks, repairs and turns it into a `Mesh` or a
`PointCloud`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import LARGEST, BoolArray, FloatArray, IntArray, MeshError

__all__ = [
    "MAX_BYTES",
    "MAX_PIXELS",
    "ByteArray",
    "Notes",
    "Scan",
    "beside",
    "check_promise",
    "check_size",
    "decoded_text",
]

STRAY = 100.0  # times as far off as nearly all others

ByteArray = npt.NDArray[np.uint8]

MAX_BYTES = 2**32  # that a scan may take once it is decoded; more is refused before memory is asked for
MAX_PIXELS = 2**26  # of one texture, 8192 × 8192; of larger JPEGs a half or a quarter is read
VERTEX_BYTES, FACE_BYTES = 24, 12  # what `Mesh` needs for one


@dataclass
class Notes:
    """Remarks on a scan, one line each: what was repaired, dropped or guessed.

    Attributes
    ----------
    lines : list of str
        For ``Mesh.report``.
    warned : list of str
        Those of the lines that a user should hear of without asking.
    """

    lines: list[str] = field(default_factory=list)
    warned: list[str] = field(default_factory=list)

    def say(self, line: str, *, warn: bool = False) -> None:
        """Add a line once; ``warn`` says it aloud as well."""
        if line not in self.lines:
            self.lines.append(line)
            if warn:
                self.warned.append(line)


@dataclass(eq=False)
class Scan:
    """Vertices and polygons in the numbering of the file.

    Attributes
    ----------
    vertices : (n_vertices, 3) float64
        As written, in the unit of the file; may hold NaN.
    corners : (n_corners,) int
        Vertices of all polygons, one polygon after the other; may point anywhere.
    counts : (n_polygons,) int, optional
        Corners of each polygon; None where all have three.
    colors : (n_vertices, 3) uint8, optional
    normals : (n_vertices, 3) float, optional
        For point clouds.
    viewpoint : (3,) or (n_vertices, 3) float, optional
        Where the scanner stood.
    is_single : bool
        Positions were stored as 32-bit floats, so digits may be lost.
    """

    vertices: FloatArray
    corners: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int32))
    counts: IntArray | None = None
    colors: ByteArray | None = None
    normals: FloatArray | None = None
    viewpoint: FloatArray | None = None
    is_single: bool = False

    @cached_property
    def is_usable(self) -> BoolArray:
        """(n_vertices,) whether a place is one that can be worked with.

        It is finite, not beyond all bounds, and no stray: at most one place of a thousand, `STRAY` times as
        far from the middle as all but half a per cent. Scanners write such (1e6) for "nothing measured".
        """
        vertices, step = self.vertices, max(1, len(self.vertices) // 100_000)
        with np.errstate(invalid="ignore"):
            usable = np.asarray((np.abs(vertices) <= LARGEST).all(axis=1))
        some = vertices[::step][usable[::step]]
        if len(vertices) < 1000 or not len(some):
            return usable
        middle = np.median(some, axis=0)
        reach = float(np.quantile(np.abs(some - middle).max(axis=1), 0.995))
        with np.errstate(invalid="ignore"):
            is_stray = usable & (np.abs(vertices - middle) > STRAY * reach).any(axis=1)
        return usable & ~is_stray if 1000 * is_stray.sum() <= len(vertices) else usable

    @property
    def n_polygons(self) -> int:
        """Number of polygons."""
        return len(self.corners) // 3 if self.counts is None else len(self.counts)


def check_size(path: Path, what: str, n_bytes: Any) -> None:
    """Refuse ``what`` of the file at ``path`` would take more than `MAX_BYTES`: ``n_bytes`` once decoded."""
    if n_bytes > MAX_BYTES:
        raise MeshError(
            f"{path.name!r} asks for {n_bytes / 1e9:.3g} GB of {what}, and at most {MAX_BYTES / 1e9:.1f} GB "
            "are read; if that is right, cut the scan in parts or thin it out first"
        )


def check_promise(path: Path, what: str, count: Any, least: int, room: int) -> None:
    """Refuse a ``count`` of ``what``, at least ``least`` bytes each, for which ``path`` has no ``room``."""
    if not 0 <= count <= room // max(least, 1):
        raise MeshError(
            f"{path.name!r} is damaged or truncated: its header promises {count} {what}, but only {room} "
            "bytes follow"
        )


def beside(folder: Path, name: str) -> Path | None:
    """A file that another one in ``folder`` names, or None.

    Folders within ``name`` are followed, in any case if there is none in that one; else only its last part
    counts: scans move from one computer to another, and their textures come along.
    """
    parts = [part for part in re.split(r"[\\/]", name.strip().strip('"')) if part not in ("", ".")]
    if not parts or "\0" in name:
        return None
    for chain in (parts, parts[-1:]):
        place: Path | None = folder
        for part in chain:
            place = None if place is None else _entry(place, part)
        if place is not None and place.is_file():
            return place
    return None


def _entry(folder: Path, name: str) -> Path | None:
    """An entry of a folder by its name, in another case if need be."""
    place = folder / name
    if place.exists():
        return place
    if not folder.is_dir():
        return None
    return next((entry for entry in folder.iterdir() if entry.name.lower() == name.lower()), None)


def decoded_text(data: bytes) -> str:
    """Text of a small file, ``data``: UTF-8 where its bytes are that, with a mark or not, else Latin-1."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")
