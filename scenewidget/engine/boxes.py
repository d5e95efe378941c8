"""Oriented boxes of segments: how large things are, and which way they stand.

Goes in: a mesh, labels, and which way is up. Comes out: for each segment the smallest box around it that
stands upright, as a piece of furniture does. Its sides in the plan are those of the smallest rectangle around
the plan, one side of which lies on a side of the convex hull (Freeman and Shapira 1975, Communications of the
ACM 18).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from scenewidget.engine.mesh import FloatArray, IntArray, Mesh

__all__ = ["Boxes", "oriented_boxes"]


@dataclass(frozen=True, eq=False)
class Boxes:
    """A box a segment.

    Attributes
    ----------
    center : (n, 3) float64
        Metres; NaN for a segment without faces.
    axes : (n, 3, 3) float64
        Rows are unit vectors, right-handed: along the longer side of the plan, along the shorter, upwards.
    size : (n, 3) float64
        Metres along each.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> import numpy as np
    >>> mesh = analytic.square(4, size=2.0)
    >>> boxes = oriented_boxes(mesh, np.zeros(mesh.n_faces, int), 1)
    >>> boxes.center.round(6).tolist(), boxes.size.round(6).tolist()
    ([[1.0, 1.0, 0.0]], [[2.0, 2.0, 0.0]])
    """

    center: FloatArray
    axes: FloatArray
    size: FloatArray


def oriented_boxes(mesh: Mesh, labels: IntArray, n: int, up: FloatArray | None = None) -> Boxes:
    """The smallest upright box around each segment.

    Parameters
    ----------
    mesh : Mesh
    labels : (n_faces,) int
        -1 belongs to none.
    n : int
        Segments.
    up : (3,) float, optional
        Against gravity, of any length but 0; along z by default.

    Returns
    -------
    boxes : Boxes
        Of several smallest rectangles, the one that is turned least from the first horizontal axis.

    Raises
    ------
    ValueError
        ``up`` has no direction.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> import numpy as np
    >>> mesh = analytic.square(2)
    >>> oriented_boxes(mesh, np.zeros(mesh.n_faces, int), 1, up=[0, 1, 0]).size.round(6).tolist()
    [[1.0, 0.0, 1.0]]
    """
    frame = _upright(np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up, np.float64))
    center, size = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
    axes = np.full((n, 3, 3), np.nan)
    order = np.argsort(labels, kind="stable")
    bounds = np.searchsorted(labels[order], np.arange(n + 1))
    turned = mesh.vertices @ frame.T
    for k in range(n):
        corners = np.unique(mesh.faces[order[bounds[k] : bounds[k + 1]]])
        if len(corners) == 0:
            continue
        points = turned[corners]
        plan = _smallest_rectangle(points[:, :2])
        own = np.vstack([np.column_stack([plan, np.zeros(2)]), [0.0, 0.0, 1.0]])
        along = points @ own.T
        low, high = along.min(axis=0), along.max(axis=0)
        axes[k] = own @ frame
        center[k] = (low + high) / 2 @ axes[k]
        size[k] = high - low
    return Boxes(center, axes, size)


def _upright(up: FloatArray) -> FloatArray:
    """(3, 3) right-handed axes whose last one is ``up``; those of the mesh where up is z."""
    length = float(np.linalg.norm(up))
    if up.shape != (3,) or not (length > 0 and np.isfinite(length)):
        raise ValueError(f"up must be a direction, (3,) numbers that aren't all 0, got {up!r:.100}")
    up = up / length
    least = int(np.argmin(np.abs(up) + np.array([0, 1e-9, 2e-9])))
    first = np.eye(3)[least] - up[least] * up
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(up, first), up])


def _smallest_rectangle(points: FloatArray) -> FloatArray:
    """(2, 2) unit vectors along the longer and the shorter side, right-handed."""
    try:
        hull = points[ConvexHull(points).vertices]
    except QhullError:  # on a line, or at one place
        along = (points - points.mean(axis=0)) @ _main_direction(points)
        hull = points[[int(np.argmin(along)), int(np.argmax(along))]]
    sides = np.roll(hull, -1, axis=0) - hull
    angle = np.unique(np.arctan2(sides[:, 1], sides[:, 0]) % (np.pi / 2))
    c, s = np.cos(angle), np.sin(angle)
    along = np.outer(c, hull[:, 0]) + np.outer(s, hull[:, 1])
    across = np.outer(c, hull[:, 1]) - np.outer(s, hull[:, 0])
    length, width = np.ptp(along, axis=1), np.ptp(across, axis=1)
    area = length * width + 1e-9 * (length + width) ** 2  # of boxes without a width, the shortest
    best = int(np.argmax(area <= area.min() * (1 + 1e-9)))
    first = np.array([c[best], s[best]])
    if width[best] > length[best] * (1 + 1e-9):
        first = np.array([-s[best], c[best]])
    return np.array([first, [-first[1], first[0]]])


def _main_direction(points: FloatArray) -> FloatArray:
    """(2,) unit vector along which points in the plane are spread most."""
    away = points - points.mean(axis=0)
    direction: FloatArray = np.linalg.eigh(away.T @ away)[1][:, -1]
    return direction
