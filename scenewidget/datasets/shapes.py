"""Solids as signed distances: what furniture is made of.

A shape answers, for many points at once, how far away its surface is: positive outside, negative inside,
metres. The primitives are exact or never overestimate, so that a block of space can be skipped safely.
Points come as ``(3, n)``, one row an axis, which lets formulas read ``x, y, z = points``. Closed forms after
Quilez, "Distance functions" (iquilezles.org), and Hart (1996), The Visual Computer 12.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from scenewidget.engine.mesh import FloatArray

__all__ = [
    "Field",
    "Shape",
    "ball",
    "box",
    "box_row",
    "cone",
    "cup",
    "cushion",
    "cut",
    "cylinder",
    "displaced",
    "ellipsoid",
    "half_space",
    "overlap",
    "repeated",
    "ripples",
    "rod",
    "smooth_union",
    "torus",
    "union",
    "wavy_sheet",
]

Field = Callable[[FloatArray], FloatArray]
Point = Sequence[float]


@dataclass(frozen=True, eq=False)
class Shape:
    """A solid.

    Parameters
    ----------
    distance : callable
        ``(3, n)`` points in metres to ``(n,)`` signed distances, negative inside.
    low, high : (3,) float
        Corners of an axis-aligned box that holds the solid.
    """

    distance: Field
    low: FloatArray
    high: FloatArray

    def moved(self, offset: Point, turn: float = 0.0) -> Shape:
        """Turned about the z axis by `turn` radians, then shifted by `offset` metres."""
        shift = np.array(offset, dtype=np.float32)[:, None]
        cos, sin = float(np.cos(turn)), float(np.sin(turn))

        def distance(points: FloatArray) -> FloatArray:
            x, y, z = points - shift
            return self.distance(np.stack([cos * x + sin * y, cos * y - sin * x, z]))

        corners = np.array([(x, y) for x in (self.low[0], self.high[0]) for y in (self.low[1], self.high[1])])
        turned = corners @ np.array([[cos, sin], [-sin, cos]])
        low = np.array([*turned.min(axis=0), self.low[2]]) + shift[:, 0]
        high = np.array([*turned.max(axis=0), self.high[2]]) + shift[:, 0]
        return Shape(distance, low, high)

    def tilted(self, angle: float) -> Shape:
        """Turned about the x axis by `angle` radians: the top of a positive angle leans towards -y."""
        cos, sin = float(np.cos(angle)), float(np.sin(angle))

        def distance(points: FloatArray) -> FloatArray:
            x, y, z = points
            return self.distance(np.stack([x, cos * y + sin * z, cos * z - sin * y]))

        corners = np.array([(y, z) for y in (self.low[1], self.high[1]) for z in (self.low[2], self.high[2])])
        turned = corners @ np.array([[cos, sin], [-sin, cos]])
        low, high = turned.min(axis=0), turned.max(axis=0)
        return Shape(distance, np.array([self.low[0], *low]), np.array([self.high[0], *high]))


# --- primitives -----------------------------------------------------------------------------------


def ball(center: Point, radius: float) -> Shape:
    """A sphere; exact."""
    middle = _column(center)
    return Shape(lambda points: _length(*(points - middle)) - radius, *_around(center, [radius] * 3))


def ellipsoid(center: Point, radii: Point) -> Shape:
    """An axis-aligned ellipsoid; first-order distance, good near the surface, at most the smallest radius
    off inside.
    """
    middle, r = _column(center), _column(radii)

    def distance(points: FloatArray) -> FloatArray:
        scaled = (points - middle) / r
        norm = _length(*scaled)
        slope = _length(*(scaled / r))
        inside = -float(r.min()) * np.ones_like(norm)
        gap: FloatArray = np.divide(norm * (norm - 1), slope, out=inside, where=slope > 1e-6)
        return gap

    return Shape(distance, *_around(center, radii))


def box(low: Point, high: Point, rounding: float = 0.0) -> Shape:
    """An axis-aligned box whose edges are rounded with radius `rounding`; exact."""
    middle = (_column(low) + _column(high)) / 2
    half = (_column(high) - _column(low)) / 2
    rounding = min(rounding, float(half.min()))

    def distance(points: FloatArray) -> FloatArray:
        x, y, z = np.abs(points - middle) - (half - rounding)
        outside = _length(np.maximum(x, 0), np.maximum(y, 0), np.maximum(z, 0))
        result: FloatArray = outside + np.minimum(np.maximum(np.maximum(x, y), z), 0) - rounding
        return result

    return Shape(distance, np.array(low, float), np.array(high, float))


def half_space(point: Point, normal: Point) -> Shape:
    """All that lies behind a plane through `point`; `normal` points out of it."""
    middle = _column(point)
    unit = _column(normal) / np.float32(np.linalg.norm(normal))
    return Shape(
        lambda points: (unit * (points - middle)).sum(axis=0), np.full(3, -np.inf), np.full(3, np.inf)
    )


def cylinder(bottom: Point, height: float, radius: float, rounding: float = 0.0) -> Shape:
    """An upright cylinder that stands on `bottom`; exact."""
    middle = _column(bottom)
    half = height / 2
    rounding = min(rounding, half, radius)

    def distance(points: FloatArray) -> FloatArray:
        x, y, z = points - middle
        return _rectangle(_length(x, y) - radius + rounding, np.abs(z - half) - half + rounding) - rounding

    return Shape(distance, *_standing(bottom, height, radius))


def cone(bottom: Point, height: float, low_radius: float, high_radius: float) -> Shape:
    """An upright cone cut at both ends; exact."""
    middle = _column(bottom)
    slant = high_radius - low_radius
    square = slant**2 + height**2

    def distance(points: FloatArray) -> FloatArray:
        x, y, z = points - middle
        radius = _length(x, y)
        cap_r = radius - np.minimum(
            radius, np.where(z < height / 2, np.float32(low_radius), np.float32(high_radius))
        )
        cap_z = np.abs(z - height / 2) - height / 2
        along = np.clip(((radius - low_radius) * slant + z * height) / square, 0, 1)
        side_r = radius - low_radius - along * slant
        side_z = z - along * height
        is_inside = (side_r < 0) & (cap_z < 0)
        gap = np.sqrt(np.minimum(cap_r**2 + cap_z**2, side_r**2 + side_z**2))
        result: FloatArray = np.where(is_inside, -gap, gap)
        return result

    return Shape(distance, *_standing(bottom, height, max(low_radius, high_radius)))


def cup(
    bottom: Point, height: float, low_radius: float, high_radius: float, wall: float, floor: float = 0.0
) -> Shape:
    """An upright cone, hollow and open at the top; with `floor` = 0 also open below, as a lamp shade is."""
    slope = (high_radius - low_radius) / height
    start = floor if floor > 0 else -0.1
    inner = cone(
        [bottom[0], bottom[1], bottom[2] + start],
        height + 0.1 - start,
        low_radius + slope * start - wall,
        high_radius + 0.1 * slope - wall,
    )
    return cut(cone(bottom, height, low_radius, high_radius), inner)


def rod(start: Point, end: Point, radius: float, end_radius: float | None = None) -> Shape:
    """A round bar with round ends, tapered if `end_radius` differs; exact for equal radii, else to first
    order.
    """
    a, b = _column(start), _column(end)
    axis = b - a
    square = float((axis**2).sum())
    last = radius if end_radius is None else end_radius

    def distance(points: FloatArray) -> FloatArray:
        rest = points - a
        along = np.clip((rest * axis).sum(axis=0) / square, 0, 1)
        result: FloatArray = _length(*(rest - along * axis)) - (radius + along * (last - radius))
        return result

    reach = max(radius, last)
    low = np.minimum(a, b)[:, 0] - reach
    high = np.maximum(a, b)[:, 0] + reach
    return Shape(distance, low.astype(float), high.astype(float))


def torus(center: Point, ring: float, tube: float) -> Shape:
    """A lying ring; exact."""
    middle = _column(center)

    def distance(points: FloatArray) -> FloatArray:
        x, y, z = points - middle
        result: FloatArray = np.hypot(_length(x, y) - ring, z) - tube
        return result

    return Shape(distance, *_around(center, [ring + tube, ring + tube, tube]))


def cushion(low: Point, high: Point, softness: float = 0.6) -> Shape:
    """A stuffed box: thickest in the middle (along its shortest axis), thinner by `softness` at the seams."""
    middle = (_column(low) + _column(high)) / 2
    half = ((_column(high) - _column(low)) / 2)[:, 0]
    thin = int(np.argmin(half))
    u, v = (i for i in range(3) if i != thin)
    rounding = 0.35 * float(min(half[u], half[v]))

    def distance(points: FloatArray) -> FloatArray:
        rest = np.abs(points - middle)
        a, b = np.minimum(rest[u] / half[u], 1.2), np.minimum(rest[v] / half[v], 1.2)
        thickness = half[thin] * (
            1 - softness * np.maximum(a, b) ** 4 - 0.25 * softness * np.minimum(a, b) ** 2
        )
        top = 0.75 * (rest[thin] - np.maximum(thickness, 0.1 * half[thin]))
        side = _rectangle(rest[u] - half[u] + rounding, rest[v] - half[v] + rounding) - rounding
        return _smooth_maximum(top, side, 0.5 * float(half[thin]))

    return Shape(distance, np.array(low, float), np.array(high, float))


def wavy_sheet(low: Point, high: Point, n_folds: float, thickness: float, phase: float = 0.0) -> Shape:
    """A hanging cloth: a sheet along x that swings in y between `low` and `high`, folds fuller towards the
    floor.
    """
    middle = (_column(low) + _column(high)) / 2
    half = ((_column(high) - _column(low)) / 2)[:, 0]
    wave = float(2 * np.pi * n_folds / (2 * half[0]))
    swing = float(half[1]) - thickness / 2
    lipschitz = 1 / np.hypot(1, swing * wave)

    def distance(points: FloatArray) -> FloatArray:
        x, y, z = points - middle
        fold = np.sin(wave * x + phase) + 0.25 * np.sin(2.3 * wave * x + 2 * phase)
        center = swing * 0.8 * fold * (0.75 - 0.25 * np.clip(z / half[2], -1, 1))
        sheet = (np.abs(y - center) - thickness / 2) * lipschitz
        result: FloatArray = np.maximum(sheet, np.maximum(np.abs(x) - half[0], np.abs(z) - half[2]))
        return result

    return Shape(distance, np.array(low, float), np.array(high, float))


def box_row(edges: FloatArray, heights: FloatArray, depths: FloatArray, base: Point) -> Shape:
    """Boxes side by side along x, as books in a shelf: box i spans ``edges[i]`` to ``edges[i + 1]``.

    Each reaches from the back plane y = ``base[1]`` forward by ``depths[i]`` and up from ``base[2]`` by
    ``heights[i]``. Exact up to the second neighbour of the box at a point's x.
    """
    starts, ends = edges[:-1] + base[0] + 0.001, edges[1:] + base[0] - 0.001

    def distance(points: FloatArray) -> FloatArray:
        x, y, z = points
        here = np.clip(np.searchsorted(edges + base[0], x) - 1, 0, len(starts) - 1)
        result = np.full(x.shape, np.inf, dtype=points.dtype)
        for step in (-1, 0, 1):
            i = np.clip(here + step, 0, len(starts) - 1)
            dx = np.maximum(starts[i] - x, x - ends[i])
            dy = np.maximum(base[1] - y, y - base[1] - depths[i])
            dz = np.maximum(base[2] - z, z - base[2] - heights[i])
            outside = _length(np.maximum(dx, 0), np.maximum(dy, 0), np.maximum(dz, 0))
            result = np.minimum(result, outside + np.minimum(np.maximum(np.maximum(dx, dy), dz), 0))
        return result

    low = np.array([edges[0] + base[0], base[1], base[2]], float)
    high = np.array([edges[-1] + base[0], base[1] + depths.max(), base[2] + heights.max()], float)
    return Shape(distance, low, high)


# --- combinations ---------------------------------------------------------------------------------


def union(*shapes: Shape) -> Shape:
    """All shapes together."""

    def distance(points: FloatArray) -> FloatArray:
        result = shapes[0].distance(points)
        for shape in shapes[1:]:
            result = np.minimum(result, shape.distance(points))
        return result

    return Shape(distance, *_hull(shapes))


def smooth_union(radius: float, *shapes: Shape) -> Shape:
    """All shapes together, their seams filled up to about `radius` metres."""

    def distance(points: FloatArray) -> FloatArray:
        result = shapes[0].distance(points)
        for shape in shapes[1:]:
            result = -_smooth_maximum(-result, -shape.distance(points), radius)
        return result

    low, high = _hull(shapes)
    return Shape(distance, low - radius / 4, high + radius / 4)


def cut(shape: Shape, *holes: Shape) -> Shape:
    """`shape` without the holes."""

    def distance(points: FloatArray) -> FloatArray:
        result = shape.distance(points)
        for hole in holes:
            result = np.maximum(result, -hole.distance(points))
        return result

    return Shape(distance, shape.low, shape.high)


def overlap(a: Shape, b: Shape) -> Shape:
    """What lies in both shapes."""
    return Shape(
        lambda points: np.maximum(a.distance(points), b.distance(points)),
        np.maximum(a.low, b.low),
        np.minimum(a.high, b.high),
    )


def repeated(shape: Shape, axis: int, n_copies: int, pitch: float) -> Shape:
    """Copies of `shape` along an axis, centred about it, `pitch` metres apart; `shape` must fit within one
    pitch.
    """
    last = (n_copies - 1) / 2

    def distance(points: FloatArray) -> FloatArray:
        nearest = np.clip(np.round(points[axis] / pitch + last), 0, n_copies - 1) - last
        folded = points.copy()
        folded[axis] -= nearest * pitch
        return shape.distance(folded)

    low, high = shape.low.copy(), shape.high.copy()
    low[axis] -= last * pitch
    high[axis] += last * pitch
    return Shape(distance, low, high)


def displaced(shape: Shape, amount: float, field: Field) -> Shape:
    """`shape` with its surface pushed out by ``amount * field(points)`` metres; keep the slope of that below
    1/2.
    """
    if amount == 0:
        return shape
    return Shape(
        lambda points: shape.distance(points) - amount * field(points),
        shape.low - 2 * abs(amount),
        shape.high + 2 * abs(amount),
    )


def ripples(rng: np.random.Generator, wavelength: float, n_waves: int = 10) -> Field:
    """A smooth random field of rms 1: plane waves in random directions, wavelengths within a factor 1.6 of
    the given.
    """
    direction = rng.normal(size=(n_waves, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    length = wavelength * rng.uniform(0.7, 1.6, n_waves)
    wave = (2 * np.pi * direction / length[:, None]).astype(np.float32)
    phase = rng.uniform(0, 2 * np.pi, n_waves).astype(np.float32)

    def field(points: FloatArray) -> FloatArray:
        total = np.zeros(points.shape[1], dtype=np.float32)
        for (a, b, c), start in zip(wave, phase, strict=True):
            total += np.sin(a * points[0] + b * points[1] + c * points[2] + start)
        return total * np.float32(np.sqrt(2 / n_waves))

    return field


# --- helpers --------------------------------------------------------------------------------------


def _column(point: Point) -> FloatArray:
    return np.array(point, dtype=np.float32)[:, None]


def _length(*components: FloatArray) -> FloatArray:
    total = components[0] ** 2
    for component in components[1:]:
        total = total + component**2
    return np.sqrt(total)


def _rectangle(x: FloatArray, y: FloatArray) -> FloatArray:
    """Distance to a rectangle from the signed distances to its two pairs of sides."""
    return _length(np.maximum(x, 0), np.maximum(y, 0)) + np.minimum(np.maximum(x, y), 0)


def _smooth_maximum(a: FloatArray, b: FloatArray, radius: float) -> FloatArray:
    """Polynomial smooth maximum: differs from the maximum only where a and b are within `radius` of each
    other.
    """
    blend = np.maximum(radius - np.abs(a - b), 0) / radius
    return np.maximum(a, b) + blend**2 * (radius / 4)


def _around(center: Point, half: Point) -> tuple[FloatArray, FloatArray]:
    middle = np.array(center, float)
    return middle - np.array(half, float), middle + np.array(half, float)


def _standing(bottom: Point, height: float, radius: float) -> tuple[FloatArray, FloatArray]:
    x, y, z = bottom
    return np.array([x - radius, y - radius, z]), np.array([x + radius, y + radius, z + height])


def _hull(shapes: Sequence[Shape]) -> tuple[FloatArray, FloatArray]:
    return np.min([s.low for s in shapes], axis=0), np.max([s.high for s in shapes], axis=0)
