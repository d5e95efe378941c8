"""Which way is up in a scan, and what its large planes say about its size.

Goes in: a mesh. Come out: the directions that much of its surface faces, with the distance across, and
the one against gravity where floors, ceilings and walls tell. Nothing depends on the axes of the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.sides import right_side_out
from scenewidget.engine.threads import by_parts

__all__ = ["Axis", "large_axes", "up_direction"]

N_SAMPLED = 30_000  # faces that are enough to tell
N_VOTING = 10_000  # of them, for where to look closer
N_DIRECTIONS = 1_000  # of the half sphere, some 5 degrees apart
CONE = float(np.cos(np.radians(15.0)))  # what faces within this cone faces the axis
APART = float(np.cos(np.radians(30.0)))  # two axes are at least so far apart
ROUNDS = 3  # of smoothing: normals of raw scans are mostly noise
FEW = 5_000  # faces of what is too coarse to be one
ROOM_HEIGHT = (2.2, 3.6)  # metres from floor to ceiling
FACING = 0.5  # of the extent, that two sides lie apart which face each other
OPPOSED = 0.25  # least share that the smaller of two opposite sides has of the larger
LEAST = 0.05  # of the area, that faces along an axis
ALONE = 0.55  # of the area, from which on a plane is what everything stands on
ON_IT = 0.01  # of the area, that things on a plane have at least
CLEARLY = 1.2  # how much better than any other the axis must be
INSIDE_OUT = 0.1  # evidence from which on normals point away from free space
ASYMMETRY = 0.08  # from which on the two ends of an axis differ
ASKEW = 0.9  # cosine up to which a face looks along no axis
MORE = 1.5  # times as much that stands around another axis makes one doubtful
AT_ENDS = 0.06  # of the extent, within which floor and ceiling themselves lie
THINGS = 0.005  # of the area, that furniture between them has at least
TWICE = 1.5  # times as much that faces one way as the other
NEAR_PLANE = 0.05  # of the width of a floor or ceiling, up to which what faces along it belongs to it
ENCLOSED = 0.1  # of its area, that upright surface around it has at least where there are walls
FURNISHED = 0.04  # of its area, that tops of furniture on a floor with walls have at least; lamps have 0.03
CLUTTERED = 0.25  # of its area, from which on what faces neither along it nor along walls tells furniture
MANY_TOPS = 0.2  # of its area, that tops have at least where it isn't known which way they face
FROM_BELOW = 0.02  # of its area, that tops of furniture have below a ceiling, where nothing says more
CLEAR_RISE = 0.2  # from which on floor and ceiling are told from two walls


@dataclass(frozen=True)
class Axis:
    """A direction that much of the surface faces, either way.

    Attributes
    ----------
    direction : (3,) float64
        Unit vector; of its two signs the one that looks more like up.
    along, against : float
        Share of the area that faces this way and the other.
    extent : float
        Distance from one end of the scan to the other along it, in the unit of the mesh, the last
        hundredths left out.
    rise : float
        How much more there is of the surface that faces this way, and at how many more heights it lies, as
        seats, tables and floors do, than of what faces the other way, as ceilings do; at most about 1.
    apart : float
        Distance of the mean places along it of what faces one way and the other: of the two faces of a wall,
        or of one plane whose normals are in disorder, next to nothing.

    Examples
    --------
    >>> import numpy as np
    >>> Axis(np.array([0.0, 0.0, 1.0]), along=0.3, against=0.2, extent=2.5, rise=0.4, apart=2.0).is_opposed
    True
    """

    direction: FloatArray
    along: float
    against: float
    extent: float
    rise: float
    apart: float

    @property
    def is_opposed(self) -> bool:
        """Whether two sides face each other, as floor and ceiling or two walls do."""
        return (
            self.apart >= FACING * self.extent
            and self.against >= OPPOSED * self.along
            and self.along >= OPPOSED * self.against
        )

    @property
    def share(self) -> float:
        """Share of the area that faces either way."""
        return self.along + self.against


def up_direction(mesh: Mesh, axes: Sequence[Axis] | None = None) -> FloatArray | None:
    """(3,) unit vector against gravity, or None where the surface doesn't tell.

    Floor and ceiling together are larger than a pair of walls, and rooms are wider than high: the axis is the
    one with most area facing along it per metre of its extent; where opposite sides are as far apart as floor
    and ceiling, 2.2 to 3.6 m, only such axes are asked, and those without an opposite side if they may be
    walls. What is mostly one plane with things on it is a table or a floor. Of the two ends, up is where more
    area faces, at more heights; of a cloud whose normals may point either way, where things stand on the
    floor. None where another axis is nearly as likely, or the two ends are alike; and of a level plane with
    walls around it but without much on it: lamps hang from ceilings as things stand on floors.

    Parameters
    ----------
    mesh : Mesh
        In metres, normals pointing into free space.
    axes : sequence of Axis, optional
        `large_axes` of the mesh, where they are known.

    Examples
    --------
    >>> from scenewidget.datasets import load_room
    >>> up_direction(load_room()[0]).round(1) + 0.0
    array([0., 0., 1.])
    """
    axes = [axis for axis in axes or large_axes(mesh) if axis.share >= LEAST]
    up, side = _likely_up(mesh, axes) if axes else (None, 1.0)
    return None if up is None else _as_things_stand(mesh, up, side)


def _likely_up(mesh: Mesh, axes: Sequence[Axis]) -> tuple[FloatArray | None, float]:
    """Up by the large planes, and the factor that makes normals point into free space."""
    has_sides = mesh.has_sides  # those of a cloud without normals are guesses
    if (axes[0].along if has_sides else axes[0].share) >= ALONE:
        return _off_the_plane(mesh, axes[0], has_sides=has_sides), 1.0
    evidence = right_side_out(mesh.face_centroids, mesh.face_normals, mesh.face_areas)
    side = 1.0
    if evidence < -INSIDE_OUT:
        side = -1.0
        centers, normals, areas = _sample(mesh)
        axes = [axis for axis in _axes(centers, -normals, areas) if axis.share >= LEAST]
    low, high = ROOM_HEIGHT
    of_rooms = [axis for axis in axes if axis.is_opposed and low <= axis.extent <= high]
    if of_rooms and max(axis.rise for axis in of_rooms) < CLEAR_RISE:  # perhaps walls, and no ceiling
        of_rooms += [axis for axis in axes if not axis.is_opposed]
    axes = of_rooms or axes
    scores = [axis.share / axis.extent for axis in axes]
    best = axes[int(np.argmax(scores))]
    others = [(axis, score) for axis, score in zip(axes, scores) if axis is not best]
    if any(score * CLEARLY > max(scores) for _, score in others):
        return None, side
    if not best.is_opposed and _turns_more(
        mesh, [best, *(a for a, score in others if score > max(scores) / 4)]
    ):
        return None, side
    if not has_sides and (best.is_opposed or low <= best.extent <= high):
        return _below_the_middle(mesh, best), side
    if not has_sides:
        return _off_the_plane(mesh, best, has_sides=evidence > INSIDE_OUT), side
    rivals = [axis for axis, score in others if score > 0.5 * max(scores) and axis.is_opposed]
    if best.rise < ASYMMETRY or any(axis.rise > best.rise + 0.2 for axis in rivals):
        return None, side
    return _by_things(mesh, best, side), side


def _as_things_stand(mesh: Mesh, up: FloatArray, side: float) -> FloatArray | None:
    """``up`` where furniture bears it out, the other way where it speaks against it, else None.

    Asked of a plane that walls stand around, without one opposite: a floor, or a ceiling upside down. Of
    things on a plane without walls, and of rooms with floor and ceiling, ``up`` stays. Normals count as
    multiplied by ``side``, or as that of the plane if they may point either way.
    """
    centers, normals, areas = _sample(mesh)
    height, facing = centers @ up, side * (normals @ up)
    low, high = np.percentile(height, [1, 99])
    reach = NEAR_PLANE * float(
        np.sqrt(mesh.face_areas.sum() * areas[np.abs(facing) > CONE].sum() / areas.sum())
    )
    is_low = (height < low + reach) & (np.abs(facing) > CONE)
    if not mesh.has_sides:
        facing = facing * (1.0 if areas[is_low] @ facing[is_low] >= 0 else -1.0)
    floor = float(areas[is_low & (facing > 0)].sum())
    opposite = float(areas[(height > high - reach) & (facing < -CONE)].sum())
    if floor < LEAST * areas.sum() or opposite > OPPOSED * floor:
        return up
    above = np.where(height > low + reach, areas, 0.0) / floor
    walls = float(above[np.abs(facing) < np.sqrt(1 - CONE**2)].sum())
    alike, other = (float(above[sign * facing > CONE].sum()) for sign in (1, -1))
    askew = float(above.sum()) - walls - alike - other
    if walls < max(ENCLOSED, 4 * alike):
        least = THINGS if mesh.has_sides else max(ON_IT, walls / 2)  # a rim leans where normals are guesses
        return up if alike + askew > least else None
    is_furnished = alike > FURNISHED or (alike > FURNISHED / 2 and askew > CLUTTERED)
    if (is_furnished and alike > 2 * other) or (not mesh.has_sides and alike + other > MANY_TOPS):
        return up
    return -up if mesh.has_sides and other > max(FROM_BELOW, TWICE * alike) else None


def _turns_more(mesh: Mesh, axes: Sequence[Axis]) -> bool:
    """Whether the first of the axes is less likely upright than another: what stands looks all ways round it.

    Of the surface that faces along none of them, half as much again is parallel to that other axis.
    """
    _, normals, areas = _sample(mesh)
    along = np.abs(np.stack([normals @ axis.direction for axis in axes]))
    areas = np.where((along < ASKEW).all(axis=0), areas, 0.0)
    around = [float(areas[row < np.sqrt(1 - CONE**2)].sum()) for row in along]
    return areas.sum() > 0 and max(around) > MORE * around[0]


def _off_the_plane(mesh: Mesh, axis: Axis, *, has_sides: bool) -> FloatArray | None:
    """Up of what is mostly one plane, with things on it: away from it, on their side.

    None of a bare wall, and where the things lie on the side that normals point away from: the scan is inside
    out, or they hang below.
    """
    size = float(np.ptp(mesh.bounds, axis=0).max())
    if (has_sides and axis.along >= 0.95) or axis.extent <= 0.02 * size:
        return None
    centers, normals, areas = _sample(mesh)
    height, is_plane = centers @ axis.direction, np.abs(normals @ axis.direction) > CONE
    if not is_plane.any():
        return None
    height = height - height[is_plane].min()  # far from the origin no numbers are left between two of them
    share, edges = np.histogram(height[is_plane], 60, weights=areas[is_plane])
    level, apart = float(edges[share.argmax() : share.argmax() + 2].mean()), 0.03 * size
    above, below = (
        float(areas[side].sum() / areas.sum()) for side in (height > level + apart, height < level - apart)
    )
    if max(above, below) < ON_IT or max(above, below) < 4 * min(above, below):
        return axis.direction if has_sides else None
    if above > below:
        return axis.direction
    return None if has_sides else -axis.direction


def _by_things(mesh: Mesh, axis: Axis, side: float) -> FloatArray | None:
    """Up of a room whose upright axis is known: seats, tables and shelves between floor and ceiling face up.

    How much there is of the floor and of the ceiling themselves tells nothing where the scan was cut. None
    where as much between them faces down. Normals count as multiplied by ``side``.
    """
    centers, normals, areas = _sample(mesh)
    height, facing = centers @ axis.direction, side * (normals @ axis.direction)
    low, high = np.percentile(height, [1, 99])
    place = (height - low) / max(float(high - low), 1e-12)
    areas = np.where((place > AT_ENDS) & (place < 1 - AT_ENDS), areas, 0.0) / areas.sum()
    alike, other = (float(areas[sign * facing > CONE].sum()) for sign in (1, -1))
    if max(alike, other) < THINGS or max(alike, other) < TWICE * min(alike, other):
        return None
    return axis.direction if alike > other else -axis.direction


def _below_the_middle(mesh: Mesh, axis: Axis) -> FloatArray | None:
    """Up of a room whose normals may point either way: seats and tables lie in its lower half."""
    centers, normals, areas = _sample(mesh)
    height = centers @ axis.direction
    low, high = np.percentile(height, [1, 99])
    place = (height - low) / max(float(high - low), 1e-12)
    is_between = (np.abs(normals @ axis.direction) > CONE) & (place > 0.08) & (place < 0.92)
    if areas[is_between].sum() < 0.005 * areas.sum():
        return None
    mean = float(np.average(place[is_between], weights=areas[is_between]))
    return axis.direction if mean < 0.42 else -axis.direction if mean > 0.58 else None


def large_axes(mesh: Mesh) -> list[Axis]:
    """The directions, up to six, that most of the surface faces, most first.

    Parameters
    ----------
    mesh : Mesh

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> [axis.direction.round(1).tolist() for axis in large_axes(square(20))]
    [[0.0, 0.0, 1.0]]
    """
    if not mesh._large_axes:  # several ask for them
        mesh._large_axes.append(_axes(*_sample(mesh)))
    return list(mesh._large_axes[0])


def _axes(centers: FloatArray, normals: FloatArray, areas: FloatArray) -> list[Axis]:
    if not areas.sum() > 0:
        return []
    areas = areas / areas.sum()
    directions = _half_sphere(N_DIRECTIONS)
    some = slice(None, None, 1 + len(areas) // N_VOTING)  # where to start; what is found is refined on all
    lines, weights = normals[some].astype(np.float32), areas[some].astype(np.float32)
    is_along = lines @ directions.T.astype(np.float32)
    np.greater(
        np.abs(is_along, out=is_along), CONE, out=is_along
    )  # in place: a number for each of 10 million
    share = weights @ is_along
    found: list[FloatArray] = []
    for start in np.argsort(-share, kind="stable"):
        if len(found) == 6 or share[start] == 0.0:
            break  # there is nothing left to refine from
        if all(abs(directions[start] @ axis) < APART for axis in found):
            axis = _refined(directions[start], normals, areas)
            if all(abs(axis @ other) < APART for other in found):
                found.append(axis)
    axes = [_measured(axis, centers, normals, areas) for axis in found]
    return sorted(axes, key=lambda axis: -axis.share)


def _sample(mesh: Mesh) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centroids, smoothed unit normals and areas of some of the faces."""
    if not mesh._smoothed_faces:  # smoothing looks at all faces
        mesh._smoothed_faces.append(_smoothed_sample(mesh))
    centers, normals, areas = mesh._smoothed_faces[0]
    return centers, normals, areas


def _smoothed_sample(mesh: Mesh) -> tuple[FloatArray, FloatArray, FloatArray]:
    vectors = mesh.face_vectors
    areas = mesh.face_areas
    rounds = ROUNDS if mesh.n_faces > FEW and not mesh.is_cloud else 0
    if rounds:
        ends = np.arange(0, mesh.faces.size + 1, 3)
        shape = (mesh.n_vertices, mesh.n_faces)
        corners = sparse.csc_array((np.ones(mesh.faces.size), mesh.faces.ravel(), ends), shape=shape)
    for _ in range(rounds):
        vectors = _of_faces(mesh, corners @ vectors)
    solid = np.flatnonzero((areas > 0) & (np.abs(vectors).sum(axis=1) > 0))
    if len(solid) > N_SAMPLED:
        solid = np.random.default_rng(0).choice(solid, N_SAMPLED, replace=False)
    normals = vectors[solid]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return mesh.face_centroids[solid], normals, areas[solid]


def _of_faces(mesh: Mesh, vectors: FloatArray) -> FloatArray:
    """(n_faces, 3) sums of the vectors of a face's vertices, made as long as its area."""
    out = np.empty((mesh.n_faces, 3))

    def sums_of(rows: slice) -> None:
        a, b, c = mesh.faces[rows].T
        sums = np.take(vectors, a, axis=0)
        sums += np.take(vectors, b, axis=0)
        sums += np.take(vectors, c, axis=0)
        length = np.linalg.norm(sums, axis=1)
        share = np.divide(mesh.face_areas[rows], length, out=np.zeros_like(length), where=length > 0)
        np.multiply(sums, share[:, None], out=out[rows])

    by_parts(sums_of, mesh.n_faces)
    return out


def _half_sphere(n: int) -> FloatArray:
    """(n, 3) unit vectors with z ≥ 0, evenly spread along a spiral."""
    step = np.arange(n) + 0.5
    z = 1.0 - step / n
    angle = np.pi * (1.0 + np.sqrt(5.0)) * step
    radius = np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)


def _refined(axis: FloatArray, normals: FloatArray, areas: FloatArray) -> FloatArray:
    """The axis of what faces along it, found by turns."""
    for _ in range(5):
        weights = areas * (np.abs(normals @ axis) > CONE)
        axis = np.linalg.eigh((normals * weights[:, None]).T @ normals)[1][:, -1]
    return axis


def _measured(direction: FloatArray, centers: FloatArray, normals: FloatArray, areas: FloatArray) -> Axis:
    height = centers @ direction
    low, high = np.percentile(height, [1, 99])
    extent = max(float(high - low), 1e-12)
    facing = normals @ direction
    is_along, is_against = facing > CONE, facing < -CONE
    along, against = float(areas[is_along].sum()), float(areas[is_against].sum())
    level: IntArray = np.clip(np.round(20 * (height - low) / extent), 0, 20).astype(np.int64)
    levels = [_n_levels(level[side], areas[side]) for side in (is_along, is_against)]
    rise = (along - against) / max(along + against, 1e-12)
    alike = min(along, against) / max(along, against, 1e-12)  # of the heights of little area nothing follows
    rise += alike * (levels[0] - levels[1]) / max(sum(levels), 1e-12)
    apart = 0.0
    if min(along, against) > 0:
        ends = [float(np.average(height[side], weights=areas[side])) for side in (is_along, is_against)]
        apart = abs(ends[0] - ends[1])
    if rise < 0:
        return Axis(-direction, against, along, extent, -rise, apart)
    return Axis(direction, along, against, extent, rise, apart)


def _n_levels(level: IntArray, areas: FloatArray) -> float:
    """Number of heights over which the area is spread: the exponential of its entropy."""
    share: FloatArray = np.asarray(np.bincount(level, areas), dtype=np.float64)
    share = share[share > 0]
    share = share / max(float(areas.sum()), 1e-300)
    return float(np.exp(-(share * np.log(share)).sum())) if len(share) else 0.0
