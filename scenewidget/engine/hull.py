"""The hull of a room: its walls, floor and ceiling, each one segment although furniture cuts it in pieces.

Goes in: labels of the items. Comes out: labels in which pieces of one wall are one segment, whether they
touch or not, and however the scan has bent the wall. Not in the thesis, which leaves such pieces apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from scenewidget.engine.atoms import renumbered
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray
from scenewidget.engine.moments import mean_normals

__all__ = ["Planes", "join_planes", "segment_planes"]

PARALLEL = 0.9  # Two normals agree whose dot product is at least this.
UPRIGHT = 0.2  # The dot product of the normals of a wall and of the floor is at most this.
ROUGHNESS = 0.08  # A piece of a wall lies within so many metres (root mean square) of its plane.


@dataclass(frozen=True, eq=False)
class Planes:
    """Best plane of each segment, and whether the segment is a piece of the room's hull.

    Attributes
    ----------
    areas : (n,) float64
        Square metres.
    centroids : (n, 3) float64
        Metres from the centre of the mesh's bounding box.
    normals : (n, 3) float64
        Unit, of the plane; towards the side that the faces look to.
    mean_normals : (n, 3) float64
        Unit, of the faces; zero where they cancel.
    roughness : (n,) float64
        Root mean square distance from the plane, metres.
    is_hull : (n,) bool
        Large, flat, and next to nothing of the scene behind it, or from the floor to the ceiling: behind the
        walls at the inner corner of an L is the other leg of the room.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.hull import segment_planes
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(4, size=2.0), np.zeros(32, int))
    >>> planes = segment_planes(items, np.zeros(1, int))
    >>> planes.areas.round(3).tolist(), planes.normals.round(3).tolist(), planes.is_hull.tolist()
    ([4.0], [[0.0, 0.0, 1.0]], [True])
    """

    areas: FloatArray
    centroids: FloatArray
    normals: FloatArray
    mean_normals: FloatArray
    roughness: FloatArray
    is_hull: BoolArray


def segment_planes(
    items: Items,
    labels: IntArray,
    *,
    min_area: float = 1.0,
    behind: float = 0.12,
    share_behind: float = 0.03,
    lean: float = 0.05,
    gap: float = 0.15,
) -> Planes:
    """Planes of the segments.

    Parameters
    ----------
    items : Items
    labels : (n_items,) int32
        Dense.
    min_area : float
        Least area of a piece of the hull, m².
    behind, share_behind : float
        Of the scene's area, other segments have at most this share more than ``behind`` metres behind the
        plane of a piece of the hull.
    lean : float
        A metre to the side, behind begins so many metres further back: the plane of a piece of a bent
        ceiling leans.
    gap : float
        How near to both floor and ceiling, the largest two pieces of the hull that face each other, a wall
        comes that has more behind it, metres.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import folded, square
    >>> from scenewidget.engine.hull import segment_planes
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(folded(square(4, size=2.0), "x", 1.0, np.pi / 2), np.arange(32) // 16)
    >>> segment_planes(items, np.arange(2)).is_hull.tolist()
    [True, True]
    """
    n = int(labels.max(initial=-1)) + 1
    keep = labels >= 0
    moments = items.moments.gather(labels, n)
    values, vectors = moments.principal()
    roughness = np.sqrt(values[:, 0] / np.where(moments.area > 0, moments.area, 1.0))
    mean = mean_normals(items.areas[:, None] * items.normals, labels, n)
    normals = vectors[:, :, 0]
    normals = normals * np.where(np.einsum("ij,ij->i", normals, mean) < 0, -1.0, 1.0)[:, None]
    centroids, positions = moments.centroid, items.moments.centroid
    is_hull = (moments.area >= min_area) & (roughness <= ROUGHNESS)
    is_hull &= np.einsum("ij,ij->i", normals, mean) >= PARALLEL
    is_upright = is_hull.copy()
    for s in np.flatnonzero(is_hull):
        apart = positions - centroids[s]
        depth = apart @ normals[s]
        aside = np.sqrt(np.maximum(np.einsum("ij,ij->i", apart, apart) - depth**2, 0.0))
        is_behind = (depth < -behind - lean * aside) & (labels != s)
        is_hull[s] = items.areas[is_behind].sum() <= share_behind * items.areas.sum()
    ends = _floor_and_ceiling(moments.area, normals, is_hull)
    is_upright &= len(ends) > 0
    for end in ends:
        height = (positions - centroids[end]) @ normals[end] - np.sqrt(items.areas / np.pi)
        least = np.full(n, np.inf)
        np.minimum.at(least, labels[keep], height[keep])
        is_upright &= (np.abs(normals @ normals[end]) < UPRIGHT) & (least < gap)
    return Planes(moments.area, centroids, normals, mean, roughness, is_hull | is_upright)


def _floor_and_ceiling(areas: FloatArray, normals: FloatArray, is_hull: BoolArray) -> tuple[int, ...]:
    """The two pieces of the hull with the largest area that face each other; none where no two do."""
    hull = np.flatnonzero(is_hull)
    faces = normals[hull] @ normals[hull].T < -PARALLEL
    if not faces.any():
        return ()
    both = np.where(faces, areas[hull][:, None] + areas[hull], 0.0)
    first, second = np.unravel_index(both.argmax(), both.shape)
    return int(hull[first]), int(hull[second])


def join_planes(
    items: Items,
    labels: IntArray,
    *,
    min_seed_area: float = 1.0,
    reach: tuple[float, float] = (0.03, 0.06),
    shell: float = 0.3,
    near: float = 0.3,
    bend: float = 0.25,
) -> IntArray:
    """Join segments that lie in the plane of a wall, floor or ceiling, whether they touch it or not.

    A seed is a piece of the room's hull. In order of area each seed takes the segments, other seeds
    included, whose mean normal agrees with its own and whose root mean square distance from its plane is
    small; then those beside what it has so far that go on at the same height, for scans bend walls. What has
    grown has another plane and another roughness: so pieces of the hull are compared again, until none joins.

    Parameters
    ----------
    items : Items
    labels : (n_items,) int32
        Dense.
    min_seed_area : float
        Square metres.
    reach : (least, most)
        How far a segment may lie from the plane, and how high the step between it and what it goes on from
        may be, metres: 1.5 times the seed's roughness between these.
    shell : float
        Fusion leaves shells behind walls that face the other way; those up to this far behind (metres)
        belong to the wall.
    near : float
        Widest gap over which a bent wall is followed, metres.
    bend : float
        Farthest that it is followed from the seed's plane, metres.

    Returns
    -------
    labels : (n_items,) int32
        Dense.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import part_of, square
    >>> from scenewidget.engine.hull import join_planes
    >>> from scenewidget.engine.items import patch_items
    >>> floor = square(6, size=3.0)
    >>> mesh = part_of(floor, np.abs(floor.face_centroids[:, 0] - 1.5) > 0.5)  # a gap of 1 m
    >>> items = patch_items(mesh, mesh.face_centroids[:, 0] > 1.5)
    >>> join_planes(items, np.arange(2)).tolist()
    [0, 0]
    """
    join = partial(
        _joined, items, min_seed_area=min_seed_area, reach=reach, shell=shell, near=near, bend=bend
    )
    joined = join(labels, is_hull_only=False)
    while joined.max(initial=-1) < labels.max(initial=-1):
        labels, joined = joined, join(joined, is_hull_only=True)
    return joined


def _joined(
    items: Items,
    labels: IntArray,
    *,
    min_seed_area: float,
    reach: tuple[float, float],
    shell: float,
    near: float,
    bend: float,
    is_hull_only: bool,
) -> IntArray:
    """One round of `join_planes`; dense labels, fewer where segments were joined."""
    planes = segment_planes(items, labels, min_area=min_seed_area)
    scatter = items.moments.gather(labels, len(planes.areas)).scatter
    area = np.where(planes.areas > 0, planes.areas, 1.0)
    group = np.arange(len(area))
    is_free = np.ones(len(area), dtype=np.bool_)
    may_join = planes.is_hull if is_hull_only else is_free.copy()
    for s in np.argsort(-planes.areas, kind="stable"):
        if not (is_free[s] and planes.is_hull[s]):
            continue
        normal = planes.normals[s]
        offset = (planes.centroids - planes.centroids[s]) @ normal
        spread = np.maximum(np.einsum("i,nij,j->n", normal, scatter, normal) / area, 0.0)
        distance = np.sqrt(offset**2 + spread)
        facing = planes.mean_normals @ normal
        step = float(np.clip(1.5 * planes.roughness[s], *reach))
        fits = is_free & may_join & (facing > PARALLEL)
        joins = fits & (distance < step)
        joins[s] = True
        beside = fits & (distance < bend) & (planes.roughness < ROUGHNESS)
        _follow(items, labels, joins, beside & ~joins, normal, step=step, near=near)
        joins |= is_free & (facing < -PARALLEL) & (offset < 0) & (offset > -shell)
        group[joins] = s
        is_free &= ~joins
    return renumbered(group, labels)


def _follow(
    items: Items,
    labels: IntArray,
    joins: BoolArray,
    candidates: BoolArray,
    normal: FloatArray,
    *,
    step: float,
    near: float,
) -> None:
    """Mark in ``joins`` the candidates that go on at the same height beside what has joined already.

    Heights are compared along the rim: those items of a candidate that are nearest to a joined one, each
    with that one.
    """
    position = items.moments.centroid
    height = position @ normal
    foot = position - height[:, None] * normal
    radius = np.sqrt(items.areas / np.pi)
    while candidates.any():
        joined = np.flatnonzero((labels >= 0) & joins[labels])
        waiting = np.flatnonzero((labels >= 0) & candidates[labels])
        gap, nearest = cKDTree(foot[joined]).query(foot[waiting])
        gap = np.maximum(gap - radius[waiting] - radius[joined[nearest]], 0.0)
        owner = labels[waiting]
        least = np.full(len(joins), np.inf)
        np.minimum.at(least, owner, gap)
        is_rim = gap <= least[owner] + near
        weight = items.areas[waiting] * is_rim
        rise = (height[waiting] - height[joined[nearest]]) * weight
        total = np.bincount(owner, weight, len(joins))
        mean = np.bincount(owner, rise, len(joins)) / np.where(total > 0, total, 1.0)
        goes_on = candidates & (least <= near) & (np.abs(mean) < step)
        if not goes_on.any():
            break
        joins |= goes_on
        candidates &= ~goes_on
