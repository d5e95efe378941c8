"""The empty room: its outline, walls, floor and ceiling, doors and windows.

Room coordinates: metres, the south-west corner of the floor at the origin, x to the east, y to the north, z
up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from scenewidget.datasets import fittings, materials
from scenewidget.datasets.fittings import LACQUER
from scenewidget.datasets.objects import SINK, Part, Piece
from scenewidget.datasets.scene import Thing, place
from scenewidget.datasets.shapes import Shape, box, cut, displaced, half_space, overlap, ripples

__all__ = ["Opening", "Plan", "Wall", "numbered", "room_plan", "shell"]

_OUTSIDE = 12.0  # metres that walls, floor and ceiling reach outwards, beyond any grid


@dataclass(frozen=True)
class Wall:
    """A straight wall from `start` to `end` with the room on its left."""

    name: str
    start: tuple[float, float]
    end: tuple[float, float]

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))

    @property
    def turn(self) -> float:
        """Radians from the x axis to the direction of the wall."""
        return float(np.arctan2(self.end[1] - self.start[1], self.end[0] - self.start[0]))

    def point(self, along: float, away: float = 0.0) -> tuple[float, float]:
        """Room coordinates, `along` metres from the start and `away` metres into the room."""
        cos, sin = np.cos(self.turn), np.sin(self.turn)
        return float(self.start[0] + along * cos - away * sin), float(
            self.start[1] + along * sin + away * cos
        )


@dataclass(frozen=True)
class Opening:
    """A door or window in a wall, `middle` metres from its start."""

    wall: int
    middle: float
    width: float
    bottom: float
    height: float
    depth: float
    angle: float = 0.0  # radians that a door stands open


@dataclass(frozen=True)
class Plan:
    """The empty room.

    Parameters
    ----------
    size : (width, depth, height)
        Metres, of the box around the room.
    notch : (width, depth) or None
        What is missing in the north-east corner of an L-shaped room.
    """

    size: tuple[float, float, float]
    notch: tuple[float, float] | None
    walls: tuple[Wall, ...]
    doors: tuple[Opening, ...]
    windows: tuple[Opening, ...]

    def contains(self, x: float, y: float, margin: float = 0.0) -> bool:
        """Whether a point of the floor lies in the room, at least `margin` metres from the walls."""
        width, depth, _ = self.size
        is_inside = margin <= x <= width - margin and margin <= y <= depth - margin
        if self.notch is None:
            return is_inside
        return is_inside and not (x > width - self.notch[0] - margin and y > depth - self.notch[1] - margin)


def room_plan(
    rng: np.random.Generator, *, shape: str, size: tuple[float, float, float] | None, n_objects: int
) -> Plan:
    """Walls, doors and windows; without `size` the room grows with the number of objects."""
    if size is None:
        area = 11.0 + 0.9 * n_objects * rng.uniform(0.85, 1.15)
        aspect = rng.uniform(1.1, 1.5)
        if shape == "L":
            area *= 1.25
        size = (float(np.sqrt(area * aspect)), float(np.sqrt(area / aspect)), float(rng.uniform(2.4, 2.8)))
    width, depth, height = size
    notch = None
    corners = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]
    if shape == "L":
        notch = (float(width * rng.uniform(0.35, 0.5)), float(depth * rng.uniform(0.3, 0.45)))
        x, y = width - notch[0], depth - notch[1]
        corners = [(0.0, 0.0), (width, 0.0), (width, y), (x, y), (x, depth), (0.0, depth)]
    walls = []
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        dx, dy = end[0] - start[0], end[1] - start[1]
        side = ("south" if dx > 0 else "north") if abs(dx) > abs(dy) else ("east" if dy > 0 else "west")
        walls.append(Wall(f"wall {side}", start, end))
    walls = [
        replace(wall, name=name) for wall, name in zip(walls, numbered([w.name for w in walls]), strict=True)
    ]
    order = rng.permutation(len(walls))
    doors: list[Opening] = []
    windows: list[Opening] = []
    for i in order.tolist():
        free = walls[i].length - 0.3
        if not doors and free > 1.2:
            wide = rng.uniform(0.8, 0.92)
            at = wide / 2 + 0.15 + rng.choice([0.05, 0.95]) * (free - wide)
            angle = rng.uniform(0.3, 1.7) if rng.random() < 0.5 else 0.0
            if notch is not None and i in (2, 3):  # behind these walls is the missing corner: nowhere to go
                angle = 0.0
            doors.append(
                Opening(
                    i, float(at), float(wide), 0.0, min(2.05, height - 0.15), 5.0 if angle else 0.03, angle
                )
            )
        elif len(windows) < (1 if width * depth < 16 else 2) and free > 1.5 and height > 1.7:
            wide = min(rng.uniform(1.0, 1.7), free - 0.3)
            at = wide / 2 + 0.3 + rng.uniform(0.2, 0.8) * (free - wide - 0.3)
            low = rng.uniform(0.8, 0.95)
            tall = min(rng.uniform(1.1, 1.35), height - low - 0.2)
            windows.append(
                Opening(i, float(at), float(wide), float(low), float(tall), float(rng.uniform(0.12, 0.24)))
            )
    return Plan(size, notch, tuple(walls), tuple(doors), tuple(windows))


def shell(plan: Plan, rng: np.random.Generator, relief: float) -> list[Thing]:
    """Floor, ceiling, walls, doors, windows."""
    width, depth, height = plan.size
    reach = _OUTSIDE
    parquet = replace(materials.wood(rng), pattern="planks") if rng.random() < 0.75 else materials.fabric(rng)
    coat = materials.paint(rng)
    floor = box([-reach, -reach, -reach], [width + reach, depth + reach, 0])
    ceiling = box([-reach, -reach, height], [width + reach, depth + reach, height + reach])
    things = [
        Thing("floor", (Part(_uneven(floor, 0.6 * relief, rng), replace(parquet, scale=0.14)),)),
        Thing("ceiling", (Part(_uneven(ceiling, 0.8 * relief, rng), LACQUER),)),
    ]
    for i, wall in enumerate(plan.walls):
        openings = [o for o in (*plan.doors, *plan.windows) if o.wall == i]
        holes = [
            box([o.middle - o.width / 2, -o.depth, o.bottom - (0.1 if o.bottom == 0 else 0)],
                [o.middle + o.width / 2, 1, o.bottom + o.height])
            for o in openings
        ]  # fmt: skip
        slab = _slab(wall, height, _reentrant(plan))
        board = box([0, -SINK, -SINK], [wall.length, 0.016, 0.075], 0.004)
        gaps = [box([o.middle - o.width / 2 - 0.07, -1, -1], [o.middle + o.width / 2 + 0.07, 1, 1])
                for o in openings if o.bottom == 0]  # fmt: skip
        parts = (Part(cut(_uneven(slab, relief, rng), *holes), coat), Part(cut(board, *gaps), LACQUER))
        things.append(place(wall.name, Piece(wall.name, parts), [*wall.start, 0], wall.turn))
    for n, o in enumerate(plan.doors, 1):
        leaf = fittings.door(rng, o.width, o.height, o.angle)
        things.append(
            place(f"door {n}", leaf, [*plan.walls[o.wall].point(o.middle), 0], plan.walls[o.wall].turn)
        )
    for n, o in enumerate(plan.windows, 1):
        panes = fittings.window(rng, o.width, o.height, o.depth)
        things.append(
            place(
                f"window {n}", panes, [*plan.walls[o.wall].point(o.middle), o.bottom], plan.walls[o.wall].turn
            )
        )
    return things


def numbered(kinds: Sequence[str], *, always: bool = False) -> list[str]:
    """Names with a running number a kind, left out for kinds that occur once unless `always`."""
    seen: dict[str, int] = {}
    names = []
    for kind in kinds:
        seen[kind] = seen.get(kind, 0) + 1
        names.append(f"{kind} {seen[kind]}" if always or kinds.count(kind) > 1 else kind)
    return names


def _slab(wall: Wall, height: float, reentrant: tuple[float, float] | None) -> Shape:
    """All that is behind a wall, in the wall's frame.

    At a corner that points into the room, two walls share what is behind them along its diagonal (with some
    overlap), or else the one would fill the openings of the other.
    """
    before, after = (0 if corner == reentrant else _OUTSIDE for corner in (wall.start, wall.end))
    slab = box([-before, -_OUTSIDE, -_OUTSIDE], [wall.length + after, 0, height + _OUTSIDE])
    if before == 0:
        slab = overlap(slab, half_space([0, 0, 0], [-1.3, -1, 0]))
    if after == 0:
        slab = overlap(slab, half_space([wall.length, 0, 0], [1.3, -1, 0]))
    return slab


def _reentrant(plan: Plan) -> tuple[float, float] | None:
    """The corner of an L-shaped room that points into it: walls end there instead of running on."""
    return None if plan.notch is None else (plan.size[0] - plan.notch[0], plan.size[1] - plan.notch[1])


def _uneven(shape: Shape, amount: float, rng: np.random.Generator) -> Shape:
    """Bulges a metre wide and plaster waves a hand wide, rms `amount` metres in all."""
    broad, fine = ripples(rng, 1.3, 6), ripples(rng, 0.3, 8)
    return displaced(shape, amount, lambda points: 0.9 * broad(points) + 0.43 * fine(points))
