"""Which way is up in a scan.

Goes in: what a person said, or "auto", and the mesh. Comes out: a unit vector. Scanners write z up, y up, or
whatever their first camera saw; nothing in a file tells.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scenewidget.engine.mesh import Mesh

__all__ = ["AXES", "checked_up", "detect_up"]

AXES: dict[str, tuple[float, float, float]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}
ALIGNED = 0.94  # a face faces an axis if the cosine between them is at least this, that is within 20 degrees
N_SAMPLED = 100_000  # of a larger mesh, about so many faces are looked at
LEAST_SHARE = 0.1  # nothing is concluded if less of the area than this faces along the axis
CLEARLY = 1.25  # another axis must be so much better than z, and so much more must face down than up


def checked_up(up: Any) -> str | tuple[float, float, float]:
    """A name as it is, a vector as a tuple; ValueError if it is neither.

    Examples
    --------
    >>> checked_up("-y"), checked_up([0, 0, 2])
    ('-y', (0.0, 0.0, 2.0))
    """
    if isinstance(up, str) and (up == "auto" or up in AXES):
        return up
    try:
        x, y, z = (float(value) for value in up)
    except (TypeError, ValueError):
        x = y = z = math.nan
    if isinstance(up, str) or not 0.0 < math.hypot(x, y, z) < math.inf:
        names = ", ".join(repr(name) for name in ("auto", *AXES))
        raise ValueError(f"up must be one of {names} or a vector (x, y, z) other than 0, got {up!r}")
    return x, y, z


def detect_up(mesh: Mesh) -> str:
    """Name of the axis that is up, by where the surface faces; "z" where that doesn't tell.

    Floor and ceiling together are larger than a pair of opposite walls, and a room is wider than high: so
    the axis is the one with most area facing along it (within 20 degrees) per metre of extent. Of its two
    ends, up is where more area faces: table tops are scanned, their undersides aren't. Whatever isn't +z must
    win clearly. A tilted scan, an object or a detail of a wall doesn't tell; then say it.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> detect_up(mesh)
    'z'
    """
    some = slice(None, None, max(1, mesh.n_faces // N_SAMPLED))
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[some]], 1, 0)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    normals = np.divide(normals, areas[:, None], out=np.zeros_like(normals), where=areas[:, None] > 0)
    faces_up = np.array([areas[normals[:, k] > ALIGNED].sum() for k in range(3)])
    faces_down = np.array([areas[normals[:, k] < -ALIGNED].sum() for k in range(3)])
    facing = faces_up + faces_down
    low, high = np.percentile(a, [1, 99], axis=0)
    score = facing / np.maximum(high - low, 1e-3 * max(float((high - low).max()), 1e-12))
    axis = int(np.argmax(score))
    if score[axis] <= CLEARLY * score[2] or facing[axis] < LEAST_SHARE * areas.sum():
        axis = 2
    slack = CLEARLY if axis == 2 else 1.0
    is_down = facing[axis] >= LEAST_SHARE * areas.sum() and faces_down[axis] > slack * faces_up[axis]
    return ("-" if is_down else "") + "xyz"[axis]
