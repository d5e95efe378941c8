"""What stands where: a room with walls, door and windows, and furniture in plausible places, all from one
seed.

Room coordinates: metres, the south-west corner of the floor at the origin, x to the east, y to the north, z
up.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from scenewidget.datasets import fittings, furniture, materials
from scenewidget.datasets.fittings import LACQUER
from scenewidget.datasets.furniture import SINK, Maker, Part, Piece
from scenewidget.datasets.scene import Scene, Thing, place
from scenewidget.datasets.shapes import Shape, box, cut, displaced, half_space, overlap, ripples, union
from scenewidget.engine.mesh import FloatArray

__all__ = ["STYLES", "Plan", "furnish", "room_plan"]

# what a room of each style gets, in this order; more objects go round the list again
STYLES: dict[str, tuple[str, ...]] = {
    "living": (
        "sofa", "coffee table", "carpet", "television", "sideboard", "armchair", "picture",
        "floor lamp", "curtain", "shelf", "plant", "hanging lamp", "radiator", "picture", "table",
        "chair", "chair", "pouf", "curtain", "wall shelf",
    ),
    "bedroom": (
        "bed", "nightstand", "wardrobe", "curtain", "picture", "carpet", "hanging lamp", "chair",
        "radiator", "plant", "nightstand", "sideboard", "curtain", "wall shelf", "armchair",
        "picture", "floor lamp", "bin", "desk", "chair",
    ),
    "dining": (
        "table", "chair", "chair", "chair", "hanging lamp", "sideboard", "picture", "chair",
        "curtain", "radiator", "plant", "shelf", "carpet", "round table", "chair", "chair",
        "picture", "floor lamp", "armchair", "curtain",
    ),
    "study": (
        "desk", "chair", "monitor", "shelf", "bin", "radiator", "shelf", "armchair", "picture",
        "floor lamp", "plant", "curtain", "round table", "chair", "hanging lamp", "carpet",
        "wall shelf", "sideboard", "pouf", "chair",
    ),
}  # fmt: skip

_STANDING: dict[str, Maker] = {
    "armchair": furniture.armchair,
    "bed": furniture.bed,
    "bin": furniture.bin_,
    "chair": furniture.chair,
    "coffee table": furniture.coffee_table,
    "desk": furniture.desk,
    "floor lamp": furniture.floor_lamp,
    "nightstand": furniture.nightstand,
    "plant": furniture.plant,
    "pouf": furniture.pouf,
    "round table": furniture.round_table,
    "shelf": furniture.shelf,
    "sideboard": furniture.sideboard,
    "sofa": furniture.sofa,
    "table": furniture.table,
    "wardrobe": furniture.wardrobe,
}
_HANGING: dict[str, tuple[Maker, float, float]] = {  # maker, range of heights
    "picture": (fittings.picture, 1.35, 1.7),
    "television": (fittings.television, 1.15, 1.35),
    "wall shelf": (fittings.wall_shelf, 1.3, 1.75),
}
_FITTED = {"radiator", "curtain", "hanging lamp", *_HANGING}  # fixed to a wall or the ceiling
_MARGIN = 0.01  # metres between the boxes of things that must not touch
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
        replace(wall, name=name) for wall, name in zip(walls, _numbered([w.name for w in walls]), strict=True)
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


def furnish(
    plan: Plan, rng: np.random.Generator, *, style: str, n_objects: int, clutter: int, relief: float
) -> tuple[Scene, int]:
    """The room with everything in it.

    Returns
    -------
    scene : Scene
    n_placed : int
        Furnishings that found a place, at most `n_objects`.
    """
    shell = _shell(plan, rng.spawn(1)[0], relief)
    room = _Furnishing(plan, rng.spawn(1)[0])
    n_placed = 0
    for kind in _wishes(style, n_objects):
        if n_placed == n_objects:
            break
        n_placed += room.add(kind)
    for _ in range(clutter):
        room.add_clutter()
    names = _numbered([piece.kind for piece, _, _ in room.placed], always=True)
    things = [
        place(name, piece, offset, turn)
        for name, (piece, offset, turn) in zip(names, room.placed, strict=True)
    ]
    return Scene([*shell, *things]), n_placed


def _wishes(style: str, n_objects: int) -> Iterator[str]:
    for _ in range(3 + n_objects // 8):
        yield from STYLES[style]


def _numbered(kinds: Sequence[str], *, always: bool = False) -> list[str]:
    """Names with a running number a kind, left out for kinds that occur once unless `always`."""
    seen: dict[str, int] = {}
    names = []
    for kind in kinds:
        seen[kind] = seen.get(kind, 0) + 1
        names.append(f"{kind} {seen[kind]}" if always or kinds.count(kind) > 1 else kind)
    return names


# --- the shell ------------------------------------------------------------------------------------


def _shell(plan: Plan, rng: np.random.Generator, relief: float) -> list[Thing]:
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


# --- the furniture --------------------------------------------------------------------------------

Box = tuple[FloatArray, FloatArray]
Pose = tuple[Piece, tuple[float, float, float], float]
Proposal = tuple[Pose, int | None]  # with what it may touch: the table that a chair is drawn up to


@dataclass
class _Furnishing:
    """A room that fills up: what has been placed and the boxes that are taken."""

    plan: Plan
    rng: np.random.Generator
    placed: list[Pose] = field(default_factory=list)
    taken: list[Box] = field(default_factory=list)  # of `placed`, same order
    blocked: list[Box] = field(default_factory=list)  # must stay free: doors and their swing, windows

    def __post_init__(self) -> None:
        width, depth, height = self.plan.size
        if self.plan.notch is not None:
            x, y = width - self.plan.notch[0], depth - self.plan.notch[1]
            self.blocked.append((np.array([x, y, -1.0]), np.array([width, depth, height])))
        for o in (*self.plan.doors, *self.plan.windows):
            wall = self.plan.walls[o.wall]
            before = o.width + 0.05 if o.bottom == 0 else 0.3
            corners = [
                wall.point(o.middle + s * (o.width / 2 + 0.08), y) for s in (-1, 1) for y in (-0.2, before)
            ]
            low, high = np.min(corners, axis=0), np.max(corners, axis=0)
            self.blocked.append((np.array([*low, o.bottom]), np.array([*high, o.bottom + o.height])))

    def add(self, kind: str) -> bool:
        """Try to place one furnishing; False if there is no room for it."""
        for _ in range(40):
            proposal = self._propose(kind)
            if proposal is None:
                return False
            pose, host = proposal
            if self._fits(pose, host):
                self._put(pose)
                return True
        return False

    def add_clutter(self) -> bool:
        """Put a small thing on a piece of furniture or on the floor."""
        tops = [(i, top) for i, (piece, _, _) in enumerate(self.placed) for top in piece.tops]
        for _ in range(30):
            where = "top" if tops and self.rng.random() < 0.7 else "floor"
            makers = fittings.CLUTTER[where]
            piece = makers[int(self.rng.integers(len(makers)))](self.rng.spawn(1)[0])
            host, z = None, 0.0
            if where == "top":
                host, top = tops[int(self.rng.integers(len(tops)))]
                local = self.rng.uniform(top.low, top.high)
                x, y = _to_room(self.placed[host], local)
                z = top.height
                if np.any(np.array(top.high) - top.low < 0.4 * (piece.high - piece.low)[:2]):
                    continue
            else:
                x, y = self.rng.uniform(0.2, np.array(self.plan.size[:2]) - 0.2)
            pose = (piece, (float(x), float(y), z), float(self.rng.uniform(0, 2 * np.pi)))
            if self._fits(pose, host):
                self._put(pose)
                return True
        return False

    def _put(self, pose: Pose) -> None:
        self.placed.append(pose)
        self.taken.append(_box(pose))

    def _fits(self, pose: Pose, host: int | None) -> bool:
        """Inside the room, clear of everything but its host (what it stands on or under)."""
        low, high = _box(pose)
        width, depth, height = self.plan.size
        slack = 0.06 if pose[0].kind in _FITTED else 0.03  # how far it may reach into walls or ceiling
        if (low[:2] < -slack).any() or (high > np.array([width, depth, height]) + slack).any():
            return False
        is_flat = pose[0].kind == "carpet"
        for i, other in enumerate(self.taken):
            if (
                i != host
                and not (is_flat ^ (self.placed[i][0].kind == "carpet"))
                and _meet(low, high, *other)
            ):
                return False
        # curtains and radiators belong at windows, a door swings over a carpet
        first = {"carpet": -1.0, "curtain": 0.0, "radiator": 0.0}.get(pose[0].kind, np.inf)
        return not any(_meet(low, high, *box) for box in self.blocked if box[0][2] <= first)

    def _of(self, *kinds: str) -> list[int]:
        return [i for i, (piece, _, _) in enumerate(self.placed) if piece.kind in kinds]

    def _propose(self, kind: str) -> Proposal | None:
        rng = self.rng.spawn(1)[0]
        if kind in _HANGING:
            make, low, high = _HANGING[kind]
            if kind == "television" and self._of("television"):
                return None
            return self._on_wall(make(rng), z=rng.uniform(low, high), gap=0.0), None
        if kind in ("radiator", "curtain"):
            return self._at_window(kind, rng)
        if kind == "monitor":
            return self._on_desk(fittings.monitor(rng))
        if kind == "hanging lamp":
            return self._under_ceiling(fittings.hanging_lamp(rng)), None
        if kind == "carpet":
            if len(self._of("carpet")) >= 2:
                return None
            x, y = rng.uniform(0.3, 0.7, 2) * self.plan.size[:2]
            return (fittings.carpet(rng), (float(x), float(y), 0.0), float(rng.normal(0, 0.1))), None
        piece = _STANDING[kind](rng)
        if kind == "chair":
            return self._at_table(piece)
        if kind in ("nightstand", "coffee table"):
            return self._beside(piece, "bed" if kind == "nightstand" else "sofa")
        if kind in ("table", "round table"):
            x, y = rng.uniform(0.25, 0.75, 2) * self.plan.size[:2]
            turn = float(rng.choice([0, np.pi / 2]) + rng.normal(0, 0.04))
            return (piece, (float(x), float(y - 0.4), 0.0), turn), None
        return self._on_wall(piece, gap=rng.uniform(0.0, 0.04)), None

    def _on_wall(self, piece: Piece, *, z: float = 0.0, gap: float) -> Pose:
        """Back to a wall, often in a corner, a little askew if it stands."""
        lengths = np.array([wall.length for wall in self.plan.walls])
        wall = self.plan.walls[int(self.rng.choice(len(lengths), p=lengths / lengths.sum()))]
        half = float(max(piece.high[0], -piece.low[0]))
        low, high = half + 0.04, wall.length - half - 0.04
        along = (
            float(self.rng.choice([low, high]))
            if self.rng.random() < 0.35
            else float(self.rng.uniform(low, max(low, high)))
        )
        x, y = wall.point(along, gap - min(float(piece.low[1]) + 0.02, 0.0))  # leaves stay out of the wall
        return piece, (x, y, float(z)), wall.turn

    def _at_window(self, kind: str, rng: np.random.Generator) -> Proposal | None:
        windows = self.plan.windows
        if not windows:
            return None
        o = windows[int(rng.integers(len(windows)))]
        wall = self.plan.walls[o.wall]
        if kind == "radiator":
            along = o.middle
            piece = fittings.radiator(rng, min(o.width, 1.3) * rng.uniform(0.55, 0.85))
        else:
            wide = rng.uniform(0.45, 0.7)
            along = o.middle + rng.choice([-1, 1]) * (o.width / 2 + rng.uniform(0.3, 0.55) * wide)
            piece = fittings.curtain(rng, wide, min(o.bottom + o.height + 0.12, self.plan.size[2] - 0.08))
        return (piece, (*wall.point(float(along)), 0.0), wall.turn), None

    def _on_desk(self, piece: Piece) -> Proposal | None:
        desks = self._of("desk", "table")
        if not desks:
            return None
        chosen = desks[int(self.rng.integers(len(desks)))]
        host = self.placed[chosen]
        top = host[0].tops[0]
        x, y = _to_room(host, np.array([self.rng.uniform(-0.2, 0.2), top.low[1] + 0.15]))
        return (piece, (x, y, top.height), host[2] + float(self.rng.normal(0, 0.1))), chosen

    def _under_ceiling(self, piece: Piece) -> Pose:
        tables = self._of("table")
        x, y = self.rng.uniform(0.3, 0.7, 2) * self.plan.size[:2]
        if tables and self.rng.random() < 0.7:
            low, high = self.taken[tables[int(self.rng.integers(len(tables)))]]
            x, y = ((low + high) / 2)[:2]
        return piece, (float(x), float(y), self.plan.size[2]), float(self.rng.uniform(0, 6))

    def _at_table(self, piece: Piece) -> Proposal:
        """Drawn up to a table or desk, facing it; without one, back to a wall."""
        hosts = self._of("table", "desk")
        if not hosts or self.rng.random() < 0.12:
            return self._on_wall(piece, gap=self.rng.uniform(0.02, 0.15)), None
        chosen = hosts[int(self.rng.integers(len(hosts)))]
        host = self.placed[chosen]
        low, high = host[0].low, host[0].high
        tuck = self.rng.uniform(0.0, 0.22)
        reach = piece.high[1] - tuck
        offset = min(0.24 * (high[0] - low[0]), (high[0] - low[0]) / 2 - 0.37)
        if host[0].kind == "desk":
            local, turn = np.array([self.rng.uniform(-0.1, 0.1), high[1] + piece.high[1] - 0.5 * tuck]), np.pi
        elif high[1] - low[1] > 0.97 or high[0] - low[0] < 1.1:  # round
            radius, turn = (
                (high[0] - low[0]) / 2,
                float(self.rng.choice(np.arange(4) * np.pi / 2) + self.rng.normal(0, 0.15)),
            )
            way = np.array([np.sin(turn), -np.cos(turn)])
            local = np.array([0, (low[1] + high[1]) / 2]) + way * (radius + piece.high[1] - 0.6 * tuck)
        else:
            seat = self.rng.integers(6)
            local, turn = [
                (np.array([-offset, low[1] - reach]), 0.0),
                (np.array([offset, low[1] - reach]), 0.0),
                (np.array([-offset, high[1] + reach]), np.pi),
                (np.array([offset, high[1] + reach]), np.pi),
                (np.array([low[0] - reach, (low[1] + high[1]) / 2]), -np.pi / 2),
                (np.array([high[0] + reach, (low[1] + high[1]) / 2]), np.pi / 2),
            ][int(seat)]
        x, y = _to_room(host, local)
        return (piece, (x, y, 0.0), host[2] + turn + float(self.rng.normal(0, 0.12))), chosen

    def _beside(self, piece: Piece, kind: str) -> Proposal | None:
        """A nightstand at the head of a bed, a low table in front of a sofa."""
        hosts = self._of(kind)
        if not hosts:
            return (self._on_wall(piece, gap=0.02), None) if piece.kind == "nightstand" else None
        host = self.placed[hosts[int(self.rng.integers(len(hosts)))]]
        if kind == "bed":
            side = self.rng.choice([-1, 1])
            local = np.array([side * (host[0].high[0] + piece.high[0] + self.rng.uniform(0.04, 0.12)), 0.0])
        else:
            local = np.array([self.rng.uniform(-0.3, 0.3), host[0].high[1] + self.rng.uniform(0.3, 0.5)])
        x, y = _to_room(host, local)
        return (piece, (x, y, 0.0), host[2] + float(self.rng.normal(0, 0.03))), None


def _box(pose: Pose) -> Box:
    moved = union(*(part.shape for part in pose[0].parts)).moved(pose[1], pose[2])
    return moved.low, moved.high


def _meet(low: FloatArray, high: FloatArray, other_low: FloatArray, other_high: FloatArray) -> bool:
    return bool((low < other_high + _MARGIN).all() and (other_low < high + _MARGIN).all())


def _gap(point: tuple[float, float], room: Box) -> float:
    """Distance in plan from a point to a box."""
    outside = np.maximum(np.maximum(room[0][:2] - point, np.array(point) - room[1][:2]), 0)
    return float(np.hypot(*outside))


def _to_room(pose: Pose, local: FloatArray) -> tuple[float, float]:
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    x, y = pose[1][0] + cos * local[0] - sin * local[1], pose[1][1] + sin * local[0] + cos * local[1]
    return float(x), float(y)
