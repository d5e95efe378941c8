"""Names where geometry tells: floor, ceiling, walls, tables, hanging lamps; what could be anything gets none.

Goes in: pieces of segments. Comes out: for some segments a name and the probability that it is right. The
rules speak of size, direction, height and of what lies behind; probabilities are the shares of segments that
were named rightly on simulated rooms, a little lowered: `tests/benchmarks/doubt.py` counts them anew.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import BoolArray, FloatArray
from scenewidget.engine.pieces import Pieces

__all__ = ["name_segments"]

ROOM = 7.0  # m² of surface below which a scan shows no room, and its lowest plane may be a table
FLAT = 0.42  # least length of the mean normal of what faces one way
EVEN = 0.55  # the same of what is to be floor without being the largest part of it
LEVEL = 0.95  # least cosine between the normal of floor or ceiling and the vertical
ABOUT_LEVEL = 0.9  # the same of a small part of a floor, which noise tilts
UPRIGHT = 0.2  # most cosine between the normal of a wall and the vertical
SPECK = 2e-4  # of the scene's area: what is smaller may be anything
BEYOND = 0.02  # most of the scene's area that may lie behind what bounds the room
SAME_LEVEL = 0.08  # metres by which parts of one floor differ in height
TABLE = (0.62, 0.82)  # height of a table's top above the floor, metres
THIN = 0.08  # standard deviation of a table across its top, metres: what is thicker has drawers or cushions


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
        "floor", "ceiling", "wall", "table", "lamp" of `editing.vocabulary.NYU40`.

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
    length = np.linalg.norm(vectors, axis=1)
    normal = vectors / np.maximum(length, 1e-300)[:, None]
    is_flat = length > FLAT * area
    height = pieces.moments.centroid @ up
    low, high = _extent(pieces, n, height, up)
    behind = np.array([_behind(pieces, s, center[s], normal[s]) for s in range(n)]) / max(total, 1e-300)
    rising = normal @ up
    out: dict[int, tuple[str, float]] = {}
    flat_up = np.flatnonzero(is_flat & (rising > LEVEL) & (behind < BEYOND) & (area > 0.03 * total))
    if len(flat_up):
        floor = int(flat_up[np.argmax(area[flat_up])])
        out[floor] = ("floor", 0.95)
        ground = float(center[floor] @ up)
        # things on the floor touch it; what lies as low without doing so is floor that is seen elsewhere
        is_level = (length > EVEN * area) & (rising > ABOUT_LEVEL)
        is_level &= np.abs(center @ up - ground) < SAME_LEVEL
        is_level &= ~_touching(pieces, n, out, "floor") & (area > SPECK * total)
        for s in np.flatnonzero(is_level):
            out.setdefault(int(s), ("floor", 0.9))
    flat_down = is_flat & (rising < -LEVEL) & (behind < BEYOND) & (area > 0.03 * total)
    for s in np.flatnonzero(flat_down):
        out[int(s)] = ("ceiling", 0.95)
    bounds = is_flat & (np.abs(rising) < UPRIGHT) & (behind < BEYOND)
    tall = high - low
    width = area / np.maximum(tall, 0.1)
    is_wall = bounds & (area > 2.5) & (tall > 1.5) & (width > 0.5)
    for s in np.flatnonzero(is_wall):
        out[int(s)] = ("wall", 0.92)
    tops = [float(center[s] @ up) for s in np.flatnonzero(flat_down)]
    if tops:  # what stands even and upright up to the ceiling is a wall, or a part of one
        is_even = length > 0.48 * area
        reaches = high > max(tops) - 0.15
        for s in np.flatnonzero(is_even & reaches & (np.abs(rising) < 0.1) & (area > 0.8)):
            out.setdefault(int(s), ("wall", 0.92))
    if len(flat_up):
        above = center @ up - ground
        spread = np.sqrt(np.maximum(moments.principal()[0], 0.0) / np.maximum(area, 1e-300)[:, None])
        is_top = (vectors @ up > FLAT * area) & (above > TABLE[0]) & (above < TABLE[1])
        is_broad = (spread[:, 1] > 0.18) & (spread[:, 2] < 0.7) & (area > 0.5)
        for s in np.flatnonzero(is_top & is_broad & (spread[:, 0] < THIN)):
            out.setdefault(int(s), ("table", 0.9))
        if tops:
            hangs = (low - ground > 1.5) & (high > max(tops) - 1.1) & (area > 0.15) & (area < 1.5)
            is_round = (length < 0.21 * area) & (spread[:, 2] < 0.25)
            for s in np.flatnonzero(hangs & is_round & ~_touching(pieces, n, out, "wall")):
                out.setdefault(int(s), ("lamp", 0.9))
    return out


def _touching(pieces: Pieces, n: int, names: dict[int, tuple[str, float]], name: str) -> BoolArray:
    """(n,) which segments touch one of that name."""
    is_named = np.array([names.get(s, ("", 0.0))[0] == name for s in range(n)])
    ends = pieces.segment[pieces.pairs]
    out = np.zeros(n, dtype=bool)
    out[ends[is_named[ends[:, ::-1]]]] = True
    return out


def _extent(pieces: Pieces, n: int, height: FloatArray, up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n,) lowest and highest place of each segment, its pieces taken as upright rectangles."""
    spread = np.einsum("i,nij,j->n", up, pieces.moments.scatter, up)
    reach = np.sqrt(3.0 * np.maximum(spread, 0.0) / np.maximum(pieces.moments.area, 1e-300))
    low, high = np.full(n, np.inf), np.full(n, -np.inf)
    np.minimum.at(low, pieces.segment, height - reach)
    np.maximum.at(high, pieces.segment, height + reach)
    return low, high


def _behind(pieces: Pieces, segment: int, center: FloatArray, normal: FloatArray) -> float:
    """Area of other segments more than 20 cm behind the plane of one, m²."""
    depth = (pieces.moments.centroid - center) @ normal
    return float(pieces.moments.area[(depth < -0.2) & (pieces.segment != segment)].sum())
