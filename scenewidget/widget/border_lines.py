"""Borders of segments as lines in the picture, coloured by how likely each runs through one thing."""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import FloatArray, face_adjacency
from scenewidget.engine.segmentation import Segmentation

__all__ = ["border_lines"]

WIDTH = 0.015  # of a line, times the scale of the scene, metres
MOST_RINGS = 6  # of faces on either side of a border


def border_lines(segmentation: Segmentation) -> FloatArray:
    """(n_faces,) probability that the border a face lies at runs through one thing; NaN away from borders.

    Lines are about 3 cm wide in a room, narrower in a small scene, at least a face on either side. Where
    several borders meet, the most doubtful shows.

    Parameters
    ----------
    segmentation : Segmentation

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> mesh, truth = sw.datasets.load_room()
    >>> lines = border_lines(truth)
    >>> bool(0.01 < np.isfinite(lines).mean() < 0.5)
    True
    """
    mesh, labels = segmentation.mesh, segmentation.labels
    doubt = segmentation.find_doubt()
    out = np.full(mesh.n_faces, -1.0)
    pairs = face_adjacency(mesh)
    ends = np.sort(labels[pairs], axis=1).astype(np.int64)
    crosses = (ends[:, 0] != ends[:, 1]) & (ends[:, 0] >= 0)
    n = segmentation.n_segments
    known = doubt.borders.first * n + doubt.borders.second  # ascending
    wanted = ends[crosses, 0] * n + ends[crosses, 1]
    place = np.minimum(np.searchsorted(known, wanted), max(len(known) - 1, 0))
    p = np.where(known[place] == wanted, doubt.same[place], 0.0) if len(known) else np.zeros(len(wanted))
    for side in pairs[crosses].T:
        np.maximum.at(out, side, p)
    edge = 1.52 * float(np.sqrt(np.median(mesh.face_areas))) or 1.0
    for _ in range(int(np.clip(round(2 * WIDTH * doubt.pieces.scale / edge), 1, MOST_RINGS)) - 1):
        before = out.copy()
        for one, other in (pairs.T, pairs.T[::-1]):
            reached = before[other] > out[one]
            reached &= labels[one] == labels[other]
            np.maximum.at(out, one[reached], before[other[reached]])
    return np.where(out >= 0, out, np.nan)
