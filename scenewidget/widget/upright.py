"""Which way is up in a scan.

Goes in: what a person said, or "auto", and the mesh. Comes out: a unit vector. Scanners write z up, y up, or
whatever their first camera saw; nothing in a file tells.
"""

from __future__ import annotations

import math
from typing import Any

from scenewidget.engine.mesh import Mesh
from scenewidget.engine.orientation import up_direction

__all__ = ["AXES", "checked_up", "told_up", "up_vector"]

AXES: dict[str, tuple[float, float, float]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}


ALIGNED = math.cos(math.radians(3.0))  # with an axis of the file: then that axis is meant


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


def up_vector(up: Any, mesh: Mesh) -> tuple[float, float, float]:
    """Unit vector of what `checked_up` gives; of "auto" what the surface tells, z where it doesn't.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> up_vector("-y", analytic.square(2))
    (0.0, -1.0, 0.0)
    """
    return told_up(up, mesh) or AXES["z"]


def told_up(up: Any, mesh: Mesh) -> tuple[float, float, float] | None:
    """As `up_vector`, None where a person has to be asked.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> told_up("auto", analytic.square(2)) is None
    True
    """
    if up == "auto":
        found = up_direction(mesh)
        if found is None:
            return None
        up = next((axis for axis in AXES.values() if found @ axis > ALIGNED), tuple(found.tolist()))
    x, y, z = AXES[up] if isinstance(up, str) else up
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length
