"""Furniture in plausible places: tables with chairs, beds with nightstands, radiators below windows.

A greedy layout: each furnishing proposes places that suit its kind until one is free.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from scenewidget.datasets import fittings, objects
from scenewidget.datasets.objects import Maker, Piece
from scenewidget.datasets.plan import Plan, numbered, shell
from scenewidget.datasets.scene import Scene, place
from scenewidget.datasets.shapes import union
from scenewidget.engine.mesh import FloatArray

__all__ = ["STYLES", "furnish"]

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
    "armchair": objects.armchair,
    "bed": objects.bed,
    "bin": objects.bin_,
    "chair": objects.chair,
    "coffee table": objects.coffee_table,
    "desk": objects.desk,
    "floor lamp": objects.floor_lamp,
    "nightstand": objects.nightstand,
    "plant": objects.plant,
    "pouf": objects.pouf,
    "round table": objects.round_table,
    "shelf": objects.shelf,
    "sideboard": objects.sideboard,
    "sofa": objects.sofa,
    "table": objects.table,
    "wardrobe": objects.wardrobe,
}
_HANGING: dict[str, tuple[Maker, float, float]] = {  # maker, range of heights
    "picture": (fittings.picture, 1.35, 1.7),
    "television": (fittings.television, 1.15, 1.35),
    "wall shelf": (fittings.wall_shelf, 1.3, 1.75),
}
_FITTED = {"radiator", "curtain", "hanging lamp", *_HANGING}  # fixed to a wall or the ceiling
_MARGIN = 0.01  # metres between the boxes of things that must not touch


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
    hull = shell(plan, rng.spawn(1)[0], relief)
    room = _Furnishing(plan, rng.spawn(1)[0])
    n_placed = 0
    for kind in _wishes(style, n_objects):
        if n_placed == n_objects:
            break
        n_placed += room.add(kind)
    for _ in range(clutter):
        room.add_clutter()
    names = numbered([piece.kind for piece, _, _ in room.placed], always=True)
    things = [
        place(name, piece, offset, turn)
        for name, (piece, offset, turn) in zip(names, room.placed, strict=True)
    ]
    return Scene([*hull, *things]), n_placed


def _wishes(style: str, n_objects: int) -> Iterator[str]:
    for _ in range(3 + n_objects // 8):
        yield from STYLES[style]


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


def _to_room(pose: Pose, local: FloatArray) -> tuple[float, float]:
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    x, y = pose[1][0] + cos * local[0] - sin * local[1], pose[1][1] + sin * local[0] + cos * local[1]
    return float(x), float(y)
