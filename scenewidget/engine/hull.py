"""The hull of a room: its walls, floor and ceiling, each one segment although furniture cuts it in pieces.

Goes in: labels of the items. Comes out: labels in which pieces of one wall are one segment, whether they
touch or not, and however the scan has bent the wall. Not in the thesis, which leaves such pieces apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from scenewidget.engine.atoms import renumbered
from scenewidget.engine.items import SCENE, Items
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, connected_components
from scenewidget.engine.moments import Moments, mean_normals

__all__ = ["Planes", "join_planes", "segment_planes"]

PARALLEL = 0.9  # Two normals agree whose dot product is at least this.
UPRIGHT = 0.2  # The dot product of the normals of a wall and of the floor is at most this.
ACROSS = 0.5  # The dot product of the normals of pieces of the hull that stand on each other is below this.
LEAN = 0.02  # The plane of a piece of a floor leans by so much, 2 cm a metre, without the floor doing so.
THICK = (0.04, 0.45)  # Least and most thickness of a wall between two rooms, units of the scene.
MOST_WALLS = 256  # The largest are looked at: a storey of offices has as many, a heap of triangles thousands.
BEYOND = 0.9  # Share of a segment that lies beyond a wall if the segment does.
ROUGHNESS = 0.08  # A piece of a wall lies within so many units of the scene (root mean square) of its plane.


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
    is_room : bool
        Whether two pieces of the hull stand on each other or face each other. One alone may be a table.

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
    is_room: bool


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
        Least area of a piece of the hull, square units of the scene.
    behind, share_behind : float
        Of the scene's area, other segments have at most this share more than ``behind`` units of the scene
        behind the plane of a piece of the hull.
    lean : float
        One unit to the side, behind begins so many units further back: the plane of a piece of a bent
        ceiling leans.
    gap : float
        How near to both floor and ceiling, the largest two pieces of the hull that face each other, a wall
        comes that has more behind it, units of the scene.

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
    s = items.scale
    min_area, behind, gap = min_area * s**2, behind * s, gap * s
    n = int(labels.max(initial=-1)) + 1
    keep = labels >= 0
    moments = items.moments.gather(labels, n)
    values, vectors = moments.principal()
    roughness = np.sqrt(values[:, 0] / np.where(moments.area > 0, moments.area, 1.0))
    mean = mean_normals(items.areas[:, None] * items.normals, labels, n)
    normals = vectors[:, :, 0]
    normals = normals * np.where(np.einsum("ij,ij->i", normals, mean) < 0, -1.0, 1.0)[:, None]
    centroids, positions = moments.centroid, items.moments.centroid
    is_hull = (moments.area >= min_area) & (roughness <= ROUGHNESS * s)
    is_hull &= np.einsum("ij,ij->i", normals, mean) >= PARALLEL
    is_upright = is_hull.copy()
    for h in np.flatnonzero(is_hull):
        apart = positions - centroids[h]
        depth = apart @ normals[h]
        aside = np.sqrt(np.maximum(np.einsum("ij,ij->i", apart, apart) - depth**2, 0.0))
        is_behind = (depth < -behind - lean * aside) & (labels != h)
        is_hull[h] = items.areas[is_behind].sum() <= share_behind * items.areas.sum()
    ends = _floor_and_ceiling(moments.area, normals, is_hull)
    is_upright &= len(ends) > 0
    for end in ends:
        height = (positions - centroids[end]) @ normals[end] - np.sqrt(items.areas / np.pi)
        least = np.full(n, np.inf)
        np.minimum.at(least, labels[keep], height[keep])
        is_upright &= (np.abs(normals @ normals[end]) < UPRIGHT) & (least < gap)
    is_hull |= is_upright
    dots = normals[is_hull] @ normals[is_hull].T
    is_room = bool((np.abs(dots) < ACROSS).any() or (dots < -PARALLEL).any())
    return Planes(moments.area, centroids, normals, mean, roughness, is_hull, is_room)


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
    small; then those beside what it has so far that go on at the same height, for scans bend walls; of what
    is farther off also those near the plane of both together, for the plane of a small seed leans. What has
    grown has another plane and another roughness: so pieces of the hull are compared again, until none joins.
    Nothing is joined through a wall that shows on both sides, unless it touches: a floor that runs through a
    door is one. Where the hull is no room (see `Planes.is_room`) only what touches is joined: of a table seen
    from one side, nothing tells that what lies at its height beyond a gap is the same table.

    Parameters
    ----------
    items : Items
    labels : (n_items,) int32
        Dense.
    min_seed_area : float
        Square units of the scene, as all lengths here are in units of the scene.
    reach : (least, most)
        How far a segment may lie from the plane, and how high the step between it and what it goes on from
        may be: 1.5 times the seed's roughness between these.
    shell : float
        Fusion leaves shells behind walls that face the other way; those up to this far behind belong to the
        wall.
    near : float
        Widest gap over which a bent wall is followed.
    bend : float
        Farthest that it is followed from the seed's plane.

    Returns
    -------
    labels : (n_items,) int32
        Dense.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import folded, part_of, square
    >>> from scenewidget.engine.hull import join_planes
    >>> from scenewidget.engine.items import patch_items
    >>> floor = folded(square(8, size=4.0), "x", 3.0, np.pi / 2)  # and from x = 3 on a wall
    >>> mesh = part_of(floor, np.abs(floor.face_centroids[:, 0] - 1.5) > 0.5)  # a gap of 1 m
    >>> items = patch_items(mesh, np.digitize(mesh.face_centroids[:, 0], [1.5, 2.9]))
    >>> join_planes(items, np.arange(3)).tolist()
    [0, 0, 1]
    """
    s = items.scale
    planes_of = partial(segment_planes, items, min_area=min_seed_area)
    planes = planes_of(labels)
    join = partial(
        _joined,
        items,
        walls=_walls(items, labels, planes, min_seed_area * s**2),
        reach=(reach[0] * s, reach[1] * s),
        shell=shell * s,
        near=near * s,
        bend=bend * s,
    )
    joined = join(labels, planes, is_hull_only=False)
    while joined.max(initial=-1) < labels.max(initial=-1):
        labels, joined = joined, join(joined, planes_of(joined), is_hull_only=True)
    return joined


def _joined(
    items: Items,
    labels: IntArray,
    planes: Planes,
    *,
    walls: list[_Wall],
    reach: tuple[float, float],
    shell: float,
    near: float,
    bend: float,
    is_hull_only: bool,
) -> IntArray:
    """One round of `join_planes`, lengths in metres; dense labels, fewer where segments were joined."""
    moments = items.moments.gather(labels, len(planes.areas))
    group = np.arange(len(planes.areas))
    is_free = np.ones(len(group), dtype=np.bool_)
    fronts = np.array([_front(items, labels, wall) for wall in walls]).reshape(len(walls), len(group))
    ends = items.touching(labels).labels if walls else np.empty((0, 2), dtype=np.int32)
    may_join = planes.is_hull if is_hull_only else is_free.copy()
    for s in np.argsort(-planes.areas, kind="stable"):
        if not (is_free[s] and planes.is_hull[s]):
            continue
        normal = planes.normals[s]
        offset = (planes.centroids - planes.centroids[s]) @ normal
        distance = moments.distance(planes.centroids[s], normal)
        facing = planes.mean_normals @ normal
        step = float(np.clip(1.5 * planes.roughness[s], *reach))
        fits = is_free & may_join & (facing > PARALLEL)
        beyond = _beyond(fronts, int(s))
        fits &= ~_through_walls(items, labels, walls, beyond, ends, int(s), fits, near)
        joins = fits & (distance < step)
        joins[s] = True
        beside = fits & (distance < bend) & (planes.roughness < ROUGHNESS * items.scale)
        _follow(items, labels, joins, beside & ~joins, normal, step=step, near=near)
        leaning = fits & ~joins & (_off_common_plane(moments, int(s), normal) < step)
        joins |= leaning & (_gaps(items, labels, joins, leaning) > near)
        is_shell = is_free & (facing < -PARALLEL) & (offset < 0) & (offset > -shell)
        joins |= is_shell & ~beyond.any(axis=0)
        if not planes.is_room:
            joins = _touching(items, labels, joins, int(s))
        group[joins] = s
        is_free &= ~joins
    return renumbered(group, labels)


class _Wall(NamedTuple):
    """A wall that shows on both sides: two large planes back to back."""

    middle: FloatArray  # (3,) amid the two
    normal: FloatArray  # (3,) towards one of the sides, in front
    body: IntArray  # the items of both
    tree: cKDTree  # of their centroids


def _walls(items: Items, labels: IntArray, planes: Planes, min_area: float) -> list[_Wall]:
    """Walls between rooms, `MOST_WALLS` at most: on either side is a part of the scene that may be one; else
    it is a shell.
    """
    s = items.scale
    is_flat = (planes.areas >= min_area) & (planes.roughness <= ROUGHNESS * s)
    is_flat &= np.einsum("ij,ij->i", planes.normals, planes.mean_normals) >= PARALLEL
    flat = np.flatnonzero(is_flat)
    normals, centroids = planes.normals[flat], planes.centroids[flat]
    depth = (
        np.einsum("ik,ik->i", normals, centroids)[:, None] - normals @ centroids.T
    )  # of one behind another
    thickness = 0.5 * (depth + depth.T)
    is_wall = (normals @ normals.T < -PARALLEL) & (np.minimum(depth, depth.T) > 0)
    is_wall &= (thickness > THICK[0] * s) & (thickness < THICK[1] * s)
    pairs = np.argwhere(np.triu(is_wall, 1))
    smaller = planes.areas[flat[pairs]].min(axis=1)
    out: list[_Wall] = []
    for i, j in pairs[np.argsort(-smaller, kind="stable")]:
        if len(out) == MOST_WALLS:
            break
        normal = normals[i] - normals[j]
        normal = normal / np.linalg.norm(normal)
        body = np.flatnonzero((labels == flat[i]) | (labels == flat[j]))
        tree = cKDTree(items.moments.centroid[body])
        wall = _Wall(0.5 * (centroids[i] + centroids[j]), normal, body, tree)
        share = float(items.areas[_is_front(items, wall)].sum() / items.areas.sum())
        if min(share, 1.0 - share) >= SCENE:
            out.append(wall)
    return out


def _is_front(items: Items, wall: _Wall) -> BoolArray:
    """(n_items,) which lie in front of a wall."""
    return np.asarray((items.moments.centroid - wall.middle) @ wall.normal > 0)


def _front(items: Items, labels: IntArray, wall: _Wall) -> FloatArray:
    """(n_segments,) share of the area of each segment that lies in front of a wall."""
    keep = labels >= 0
    is_front = _is_front(items, wall)
    area, of_front = (np.bincount(labels[keep], (items.areas * w)[keep]) for w in (1.0, is_front))
    return np.asarray(of_front / np.maximum(area, 1e-300))


def _beyond(fronts: FloatArray, seed: int) -> BoolArray:
    """(n_walls, n_segments) which lie beyond a wall, seen from the seed; none if it lies on both sides."""
    front = fronts[:, seed, None]
    is_beyond = np.where(front >= BEYOND, fronts <= 1 - BEYOND, fronts >= BEYOND)
    return is_beyond & ((front >= BEYOND) | (front <= 1 - BEYOND))


def _through_walls(
    items: Items,
    labels: IntArray,
    walls: list[_Wall],
    beyond: BoolArray,
    ends: IntArray,
    seed: int,
    segments: BoolArray,
    near: float,
) -> BoolArray:
    """(n_segments,) of some segments those to which the shortest way from the seed leads through a wall;
    none that touches it, as ``ends`` of the seams tell.
    """
    out = np.zeros(len(segments), dtype=np.bool_)
    segments = segments & beyond.any(axis=0)
    if segments.any():
        segments[ends[(ends == seed).any(axis=1)]] = False
    if not segments.any():
        return out
    position, radius = items.moments.centroid, np.sqrt(items.areas / np.pi)
    own = np.flatnonzero(labels == seed)
    other = np.flatnonzero((labels >= 0) & segments[labels])
    apart, nearest = cKDTree(position[own]).query(position[other])
    least = np.full(len(segments), np.inf)
    np.minimum.at(least, labels[other], apart)
    is_way = apart <= least[labels[other]]
    start, end, owner = position[own[nearest[is_way]]], position[other[is_way]], labels[other[is_way]]
    for wall, is_beyond in zip(walls, beyond):
        ways = np.flatnonzero(is_beyond[owner])
        if len(ways) == 0:
            continue
        before, behind = ((place[ways] - wall.middle) @ wall.normal for place in (start, end))
        share = np.divide(before, before - behind, out=np.zeros(len(ways)), where=before != behind)
        crossing = start[ways] + share.clip(0, 1)[:, None] * (end[ways] - start[ways])
        distance, at = wall.tree.query(crossing)
        out[owner[ways[distance - radius[wall.body[at]] <= near]]] = True
    return out


def _off_common_plane(moments: Moments, seed: int, normal: FloatArray) -> FloatArray:
    """(n,) distance from the best plane of each segment and the seed, root mean square, of the farther;
    infinite where it leans more than the seed's, whose ``normal`` is given, ever does by mistake.
    """
    both = Moments(
        moments.area + moments.area[seed],
        moments.first + moments.first[seed],
        moments.second + moments.second[seed],
    )
    normals = both.principal()[1][:, :, 0]
    seeds = Moments(*(np.broadcast_to(x[seed], x.shape) for x in vars(moments).values()))
    farther = np.maximum(moments.distance(both.centroid, normals), seeds.distance(both.centroid, normals))
    lean = np.sqrt(np.maximum(1.0 - (normals @ normal) ** 2, 0.0))
    return np.where(lean <= LEAN, farther, np.inf)


def _gaps(items: Items, labels: IntArray, joined: BoolArray, segments: BoolArray) -> FloatArray:
    """(n,) metres from some segments to the nearest joined one, items taken for discs; 0 for the others."""
    gap = np.where(segments, np.inf, 0.0)
    if segments.any():
        position, radius = items.moments.centroid, np.sqrt(items.areas / np.pi)
        own = np.flatnonzero((labels >= 0) & joined[labels])
        other = np.flatnonzero((labels >= 0) & segments[labels])
        apart, nearest = cKDTree(position[own]).query(position[other])
        np.minimum.at(gap, labels[other], apart - radius[other] - radius[own[nearest]])
    return gap


def _touching(items: Items, labels: IntArray, joins: BoolArray, seed: int) -> BoolArray:
    """Of segments that would join, those that a chain of touching ones leads to from the seed."""
    ends = items.touching(np.where(joins[labels], labels, -1)).labels
    _, component = connected_components(len(joins), ends)
    return np.asarray(joins & (component == component[seed]))


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
