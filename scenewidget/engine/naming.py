"""Names where geometry tells: floor, ceiling and walls; what could be anything gets none.

Goes in: pieces of segments. Comes out: for some segments a name and the probability that it is right. The
rules speak of size, direction, height and of what lies behind; probabilities are the shares of segments that
were named rightly on simulated rooms, a little lowered: `tests/benchmarks/doubt.py` counts them anew.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import FloatArray
from scenewidget.engine.pieces import Pieces

__all__ = ["name_segments"]

ROOM = 7.0  # m² of surface below which a scan shows no room, and its lowest plane may be a table
FLAT = 0.85  # least length of the mean normal of what faces one way
LEVEL = 0.95  # least cosine between the normal of floor or ceiling and the vertical
UPRIGHT = 0.2  # most cosine between the normal of a wall and the vertical
BEYOND = 0.02  # most of the scene's area that may lie behind what bounds the room


def name_segments(pieces: Pieces, up: FloatArray) -> dict[int, tuple[str, float]]:
    """Name and probability of each segment whose geometry tells.

    Parameters
    ----------
    pieces : Pieces
        With lengths in metres.
    up : (3,) float64
        Unit vector against gravity.

    Returns
    -------
    names : dict of int to (str, float)
        "floor", "ceiling", "wall" of `editing.vocabulary.NYU40`.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh, truth = sw.datasets.load_room()
    >>> name_segments(truth.find_doubt().pieces, [0, 0, 1])[0][0] in ("floor", "ceiling", "wall")
    True
    """
    n = int(pieces.segment.max(initial=-1)) + 1
    total = float(pieces.moments.area.sum())
    if n == 0 or total < ROOM:
        return {}
    up = np.asarray(up, dtype=np.float64)
    moments = pieces.moments.gather(pieces.segment, n)
    area, center = moments.area, moments.centroid
    vectors = np.stack([np.bincount(pieces.segment, v, n) for v in pieces.vectors.T], axis=1)
    normal = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
    is_flat = np.linalg.norm(vectors, axis=1) > FLAT * area
    height = pieces.moments.centroid @ up
    low, high = _extent(pieces, n, height)
    behind = np.array([_behind(pieces, s, center[s], normal[s]) for s in range(n)]) / max(total, 1e-300)
    rising = normal @ up
    out: dict[int, tuple[str, float]] = {}
    flat_up = np.flatnonzero(is_flat & (rising > LEVEL) & (behind < BEYOND) & (area > 0.03 * total))
    if len(flat_up):
        floor = int(flat_up[np.argmax(area[flat_up])])
        out[floor] = ("floor", 0.95)
    flat_down = is_flat & (rising < -LEVEL) & (behind < BEYOND) & (area > 0.03 * total)
    for s in np.flatnonzero(flat_down):
        out[int(s)] = ("ceiling", 0.95)
    bounds = is_flat & (np.abs(rising) < UPRIGHT) & (behind < BEYOND)
    tall = high - low
    width = area / np.maximum(tall, 0.1)
    is_wall = bounds & (area > 2.5) & (tall > 1.5) & (width > 0.5)
    for s in np.flatnonzero(is_wall):
        out[int(s)] = ("wall", 0.92)
    return out


def _extent(pieces: Pieces, n: int, height: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n,) lowest and highest place of each segment, by the centers of its pieces and their size."""
    reach = np.sqrt(pieces.moments.area / np.pi)
    low, high = np.full(n, np.inf), np.full(n, -np.inf)
    np.minimum.at(low, pieces.segment, height - reach)
    np.maximum.at(high, pieces.segment, height + reach)
    return low, high


def _behind(pieces: Pieces, segment: int, center: FloatArray, normal: FloatArray) -> float:
    """Area of other segments more than 20 cm behind the plane of one, m²."""
    depth = (pieces.moments.centroid - center) @ normal
    return float(pieces.moments.area[(depth < -0.2) & (pieces.segment != segment)].sum())
