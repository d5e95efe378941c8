"""Objects that stand on the floor, such as sofas and tables, each piece different by its random generator.

A piece is built in a frame of its own: origin on the floor in the middle of its back, x to the right, y
forward, z up, metres. It reaches a little under the floor (`SINK`), so that noise never opens a gap between
the two.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from scenewidget.datasets import materials
from scenewidget.datasets.materials import Material
from scenewidget.datasets.shapes import (
    Shape,
    ball,
    box,
    box_row,
    cone,
    cup,
    cushion,
    cut,
    cylinder,
    displaced,
    ellipsoid,
    overlap,
    ripples,
    rod,
    smooth_union,
    torus,
    union,
)
from scenewidget.engine.mesh import FloatArray

__all__ = [
    "SINK",
    "Part",
    "Piece",
    "Top",
    "armchair",
    "bed",
    "bin_",
    "chair",
    "coffee_table",
    "desk",
    "floor_lamp",
    "nightstand",
    "plant",
    "pouf",
    "round_table",
    "shelf",
    "sideboard",
    "sofa",
    "table",
    "wardrobe",
]

SINK = 0.015  # metres that things reach into what carries them


@dataclass(frozen=True, eq=False)
class Part:
    """A shape of one material."""

    shape: Shape
    material: Material


@dataclass(frozen=True)
class Top:
    """A level rectangle on which small things can stand."""

    low: tuple[float, float]
    high: tuple[float, float]
    height: float


@dataclass(frozen=True, eq=False)
class Piece:
    """One thing, one instance of the truth: its kind, its parts and the tops it offers."""

    kind: str
    parts: tuple[Part, ...]
    tops: tuple[Top, ...] = ()

    @property
    def low(self) -> FloatArray:
        """(3,) lowest corner of the box around all parts."""
        corner: FloatArray = np.min([part.shape.low for part in self.parts], axis=0)
        return corner

    @property
    def high(self) -> FloatArray:
        """(3,) highest corner of the box around all parts."""
        corner: FloatArray = np.max([part.shape.high for part in self.parts], axis=0)
        return corner


Maker = Callable[[np.random.Generator], Piece]


def table(rng: np.random.Generator) -> Piece:
    """A dining table: top, apron, four tapered legs."""
    width, depth, height = rng.uniform(1.2, 1.8), rng.uniform(0.75, 0.95), rng.uniform(0.72, 0.77)
    oak = materials.wood(rng)
    board = box([-width / 2, 0, height - 0.04], [width / 2, depth, height], 0.012)
    apron = cut(
        box([-width / 2 + 0.08, 0.08, height - 0.13], [width / 2 - 0.08, depth - 0.08, height - 0.03]),
        box([-width / 2 + 0.11, 0.11, height - 0.3], [width / 2 - 0.11, depth - 0.11, height - 0.05]),
    )
    legs = _legs(width - 0.18, 0.09, depth - 0.09, height - 0.05, 0.022, 0.034, splay=rng.uniform(0, 0.04))
    top = Top((-width / 2 + 0.05, 0.05), (width / 2 - 0.05, depth - 0.05), height)
    return Piece("table", (Part(union(board, apron, legs), oak),), (top,))


def round_table(rng: np.random.Generator) -> Piece:
    """A round table on one turned column with a spreading foot."""
    radius, height = rng.uniform(0.45, 0.62), rng.uniform(0.71, 0.76)
    center = (0.0, radius)
    board = cylinder([*center, height - 0.035], 0.035, radius, 0.012)
    column = smooth_union(
        0.12,
        rod([*center, 0.05], [*center, height - 0.03], 0.05, 0.035),
        cone([*center, -SINK], 0.06 + SINK, 0.27, 0.2),
        ball([*center, 0.35 * height], 0.075),
    )
    reach = 0.6 * radius
    top = Top((-reach, radius - reach), (reach, radius + reach), height)
    return Piece("table", (Part(union(board, column), materials.wood(rng)),), (top,))


def coffee_table(rng: np.random.Generator) -> Piece:
    """A low table: oval or rectangular board, splayed legs, perhaps a lower tray."""
    width, depth, height = rng.uniform(0.8, 1.15), rng.uniform(0.5, 0.65), rng.uniform(0.38, 0.46)
    rounding = 0.02 if rng.random() < 0.5 else 0.24
    plank = box([-width / 2, 0, height - 0.5], [width / 2, depth, height + 0.5], rounding)
    board = overlap(plank, box([-width / 2, 0, height - 0.035], [width / 2, depth, height]))
    legs = _legs(width * 0.62, depth * 0.2, depth * 0.8, height - 0.02, 0.016, 0.026, splay=0.06)
    shapes = [board, legs]
    if rng.random() < 0.5:
        shapes.append(box([-width * 0.33, depth * 0.18, 0.15], [width * 0.33, depth * 0.82, 0.175]))
    top = Top((-width / 2 + 0.12, 0.12), (width / 2 - 0.12, depth - 0.12), height)
    return Piece("coffee table", (Part(union(*shapes), materials.wood(rng)),), (top,))


def desk(rng: np.random.Generator) -> Piece:
    """A desk: board, a drawer unit on one side, legs on the other."""
    width, depth, height = rng.uniform(1.2, 1.6), rng.uniform(0.62, 0.75), rng.uniform(0.72, 0.76)
    side = 1 if rng.random() < 0.5 else -1
    oak = materials.wood(rng)
    board = box([-width / 2, 0, height - 0.035], [width / 2, depth, height], 0.008)
    inner, outer = sorted((side * (width / 2 - 0.42), side * (width / 2 - 0.03)))
    drawers = _fronts(
        box([inner, 0.04, 0.06], [outer, depth - 0.05, height - 0.03], 0.006), "z", 3, depth - 0.05
    )
    legs = union(
        *(
            rod([-side * (width / 2 - 0.06), y, -SINK], [-side * (width / 2 - 0.06), y, height - 0.03], 0.024)
            for y in (0.07, depth - 0.07)
        ),
        box([inner + 0.02, 0.06, -SINK], [outer - 0.02, depth - 0.1, 0.07]),
    )
    top = Top((-width / 2 + 0.05, 0.08), (width / 2 - 0.05, depth - 0.06), height)
    return Piece("desk", (Part(union(board, drawers), oak), Part(legs, materials.metal(rng))), (top,))


def chair(rng: np.random.Generator) -> Piece:
    """A chair: four legs, a seat (perhaps padded), a leaning back of slats, of a shell or of a board."""
    width, depth, height = rng.uniform(0.42, 0.47), rng.uniform(0.42, 0.48), rng.uniform(0.44, 0.47)
    back = rng.uniform(0.82, 0.95)
    oak = materials.wood(rng)
    lean = rng.uniform(0.04, 0.09)
    y0 = lean + 0.03
    seat = box([-width / 2, y0 - 0.02, height - 0.035], [width / 2, y0 + depth, height], 0.017)
    legs = union(
        *(
            rod(
                [s * (width / 2 - 0.02), y0 + depth - 0.035, -SINK],
                [s * (width / 2 - 0.035), y0 + depth - 0.05, height - 0.02],
                0.017,
                0.024,
            )
            for s in (-1, 1)
        ),
        *(
            rod(
                [s * (width / 2 - 0.025), y0 - 0.02, -SINK],
                [s * (width / 2 - 0.03), y0 + 0.01, height],
                0.017,
                0.023,
            )
            for s in (-1, 1)
        ),
    )
    posts = union(
        *(
            rod(
                [s * (width / 2 - 0.03), y0 + 0.01, height - 0.02],
                [s * (width / 2 - 0.03), y0 - lean, back],
                0.022,
                0.016,
            )
            for s in (-1, 1)
        )
    )
    style = rng.integers(3)
    if style == 0:  # ladder back
        levels = np.linspace(0.35, 0.93, 3)
        slats = [
            _bent_slat(width - 0.04, y0 + 0.01 - lean * t, height + t * (back - height), 0.03) for t in levels
        ]
        rest = union(posts, *slats)
    elif style == 1:  # shell
        bow = cylinder([0, y0 + 0.42, height + 0.1], back - height - 0.1, 0.45)
        shell = cut(bow, cylinder([0, y0 + 0.42, 0], 2.0, 0.42))
        window = box([-width / 2, -1, height + 0.1], [width / 2, y0 + 0.2, back], 0.06)
        rest = union(posts, overlap(shell.moved([0, -0.01, 0]), window))
    else:  # board
        board = box([-width / 2 + 0.01, -0.014, 0.1], [width / 2 - 0.01, 0.014, back - height], 0.012)
        rest = board.tilted(float(np.arctan2(lean, back - height))).moved([0, y0 + 0.01, height])
        rest = union(posts, rest)
    parts = [Part(union(seat, legs, rest), oak)]
    if rng.random() < 0.4:
        pad = cushion(
            [-width / 2 + 0.02, y0 + 0.03, height - 0.01],
            [width / 2 - 0.02, y0 + depth - 0.02, height + 0.04],
        )
        parts.append(Part(pad, materials.fabric(rng)))
    return Piece("chair", tuple(parts))


def armchair(rng: np.random.Generator) -> Piece:
    """An upholstered chair with round arms and a seat cushion."""
    width, depth, back = rng.uniform(0.75, 0.88), rng.uniform(0.76, 0.86), rng.uniform(0.78, 0.95)
    return _upholstered("armchair", rng, width, depth, back, n_seats=1, n_loose=int(rng.integers(0, 2)))


def sofa(rng: np.random.Generator) -> Piece:
    """A sofa of two or three seats; its seat, back and loose cushions belong to it."""
    n_seats = int(rng.integers(2, 4))
    width = 0.45 + n_seats * rng.uniform(0.6, 0.72)
    return _upholstered(
        "sofa", rng, width, rng.uniform(0.85, 0.98), rng.uniform(0.74, 0.86), n_seats, int(rng.integers(1, 4))
    )


def bed(rng: np.random.Generator) -> Piece:
    """A bed: frame, headboard, mattress, wrinkled duvet and pillows, all one instance."""
    width, length, height = rng.choice([0.9, 1.4, 1.6]), rng.uniform(2.0, 2.1), rng.uniform(0.42, 0.52)
    half = width / 2
    oak, linen, cover = (
        materials.wood(rng),
        Material((232, 230, 224), (214, 212, 208), "spots", 0.3),
        materials.fabric(rng),
    )
    frame = union(
        box([-half - 0.04, 0, 0.12], [half + 0.04, length + 0.04, 0.3], 0.015),
        box([-half - 0.05, 0, 0.1], [half + 0.05, 0.05, rng.uniform(0.8, 1.15)], 0.02),
        *(
            box([s * half - 0.05, y, -SINK], [s * half + 0.05, y + 0.08, 0.14])
            for s in (-1, 1)
            for y in (0.02, length - 0.06)
        ),
    )
    mattress = box([-half, 0.05, 0.25], [half, length, height - 0.04], 0.06)
    start = rng.uniform(0.5, 0.75)
    hang = rng.uniform(0.1, 0.2)
    duvet = box(
        [-half - 0.05, start, height - 0.06 - hang], [half + 0.05, length + 0.02, height + 0.05], 0.07
    )
    fold = rod(
        [-half - 0.02, start + 0.05, height + 0.03],
        [half + 0.02, start + rng.uniform(0, 0.12), height + 0.03],
        0.055,
    )
    heap = ellipsoid(
        [rng.uniform(-0.4, 0.4) * half, rng.uniform(1.0, 1.7), height],
        [0.35 * width, 0.4, rng.uniform(0.06, 0.16)],
    )
    duvet = displaced(smooth_union(0.12, duvet, fold, heap), 0.011, ripples(rng, 0.3))
    n_pillows = 1 if width < 1.2 else 2
    pillows = []
    for i in range(n_pillows):
        x = (i - (n_pillows - 1) / 2) * width / 2
        pillow = cushion([-0.36 if n_pillows > 1 else -0.38, -0.22, -0.07], [0.36, 0.22, 0.07], 0.7)
        pillows.append(
            pillow.tilted(rng.uniform(-0.35, 0)).moved([x, 0.31, height + 0.06], rng.normal(0, 0.08))
        )
    soft = displaced(union(*pillows), 0.005, ripples(rng, 0.18))
    return Piece("bed", (Part(frame, oak), Part(union(mattress, soft), linen), Part(duvet, cover)))


def shelf(rng: np.random.Generator) -> Piece:
    """An open shelf with rows of books; the books belong to it."""
    width, depth, height = rng.uniform(0.8, 1.2), rng.uniform(0.28, 0.34), rng.uniform(1.5, 2.05)
    n_rows = int(rng.integers(4, 6))
    pitch = (height - 0.08) / n_rows
    boards = [
        box([-width / 2, 0, -SINK], [-width / 2 + 0.025, depth, height]),
        box([width / 2 - 0.025, 0, -SINK], [width / 2, depth, height]),
        box([-width / 2, -SINK, 0], [width / 2, 0.012, height]),
        *(
            box([-width / 2, 0, 0.05 + i * pitch], [width / 2, depth, 0.075 + i * pitch])
            for i in range(n_rows)
        ),
        box([-width / 2, 0, height - 0.028], [width / 2, depth, height]),
    ]
    rows = []
    for i in range(n_rows):
        base = [-width / 2 + 0.03, 0.01, 0.07 + i * pitch]
        filled = rng.uniform(0.45, 1.0) * (width - 0.06)
        if rng.random() < 0.85:
            rows.append(_books(rng, filled, pitch - 0.05, depth - 0.04).moved(base))
        if filled < 0.7 * width and rng.random() < 0.7:  # a bowl, ball or box in the empty place
            x, room = -width / 2 + filled + 0.14, pitch - 0.06
            item = (
                ball([x, 0.15, base[2] + 0.085], 0.08)
                if rng.random() < 0.5
                else box(
                    [x - 0.09, 0.05, base[2]],
                    [x + 0.1, depth - 0.03, base[2] + rng.uniform(0.4, 0.8) * room],
                    0.01,
                )
            )
            rows.append(item)
    colors = Material((150, 70, 60), (60, 90, 130), "books", 0.035)
    parts = [Part(union(*boards), materials.wood(rng))]
    if rows:
        parts.append(Part(union(*rows), colors))
    top = Top((-width / 2 + 0.05, 0.03), (width / 2 - 0.05, depth - 0.03), height)
    return Piece("shelf", tuple(parts), (top,))


def wardrobe(rng: np.random.Generator) -> Piece:
    """A wardrobe: doors with gaps between them, handles, a plinth and a cornice."""
    n_doors = int(rng.integers(2, 4))
    width, depth, height = n_doors * rng.uniform(0.45, 0.55), rng.uniform(0.55, 0.62), rng.uniform(1.9, 2.2)
    body = box([-width / 2, 0, 0.07], [width / 2, depth, height - 0.03], 0.006)
    body = _fronts(body, "x", n_doors, depth)
    frame = union(
        box([-width / 2 + 0.02, 0.01, -SINK], [width / 2 - 0.02, depth - 0.04, 0.09]),
        box([-width / 2 - 0.025, 0, height - 0.05], [width / 2 + 0.025, depth + 0.025, height], 0.01),
    )
    handles = union(
        *(
            rod([x, depth + 0.03, 0.9], [x, depth + 0.03, 1.15], 0.012)
            for x in (np.arange(1, n_doors) / n_doors - 0.5) * width + 0.06
        ),
        *(ball([(i + 0.5) / n_doors * width - width / 2, depth, 1.02], 0.018) for i in range(n_doors)),
    )
    oak = materials.wood(rng)
    return Piece("wardrobe", (Part(union(body, frame), oak), Part(handles, materials.metal(rng))))


def sideboard(rng: np.random.Generator) -> Piece:
    """A low cupboard on legs, with door fronts and knobs."""
    width, depth, height = rng.uniform(1.1, 1.7), rng.uniform(0.38, 0.46), rng.uniform(0.55, 0.85)
    n_doors = int(rng.integers(2, 5))
    body = _fronts(box([-width / 2, 0, 0.14], [width / 2, depth, height], 0.008), "x", n_doors, depth)
    legs = _legs(width - 0.16, 0.06, depth - 0.06, 0.16, 0.018, 0.028, splay=0.02)
    knobs = union(
        *(
            ball([(i + 0.82) / n_doors * width - width / 2, depth + 0.012, 0.62 * height + 0.05], 0.02)
            for i in range(n_doors)
        )
    )
    top = Top((-width / 2 + 0.04, 0.04), (width / 2 - 0.04, depth - 0.04), height)
    oak = materials.wood(rng)
    return Piece("sideboard", (Part(union(body, legs), oak), Part(knobs, materials.metal(rng))), (top,))


def nightstand(rng: np.random.Generator) -> Piece:
    """A small chest with two drawers."""
    width, depth, height = rng.uniform(0.4, 0.5), rng.uniform(0.36, 0.42), rng.uniform(0.45, 0.58)
    body = _fronts(box([-width / 2, 0, 0.08], [width / 2, depth, height], 0.01), "z", 2, depth)
    legs = _legs(width - 0.08, 0.05, depth - 0.05, 0.1, 0.016, 0.022)
    knobs = union(*(ball([0, depth + 0.012, 0.08 + t * (height - 0.08)], 0.018) for t in (0.27, 0.75)))
    top = Top((-width / 2 + 0.03, 0.03), (width / 2 - 0.03, depth - 0.03), height)
    oak = materials.wood(rng)
    return Piece("nightstand", (Part(union(body, legs), oak), Part(knobs, materials.metal(rng))), (top,))


def pouf(rng: np.random.Generator) -> Piece:
    """A round stuffed stool."""
    radius, height = rng.uniform(0.22, 0.3), rng.uniform(0.36, 0.44)
    body = cylinder([0, radius, -SINK], height + SINK, radius, 0.09)
    bulge = smooth_union(0.1, body, torus([0, radius, 0.5 * height], radius - 0.06, 0.09))
    return Piece("pouf", (Part(displaced(bulge, 0.004, ripples(rng, 0.25)), materials.fabric(rng)),))


def floor_lamp(rng: np.random.Generator) -> Piece:
    """A lamp on a thin pole with a conical shade, or bent over as an arc."""
    height = rng.uniform(1.45, 1.7)
    center = (0.0, 0.2)
    foot = smooth_union(
        0.05,
        cylinder([*center, -SINK], 0.03 + SINK, rng.uniform(0.14, 0.17), 0.01),
        rod([*center, 0.0], [*center, 0.15], 0.02),
    )
    wide, narrow, tall = rng.uniform(0.17, 0.22), rng.uniform(0.09, 0.15), rng.uniform(0.24, 0.32)
    bulb = ball([*center, height - 0.12], 0.045)
    if rng.random() < 0.3:  # arc
        reach = [center[0], center[1] + 0.35, height - 0.05]
        pole = union(
            rod([*center, 0.02], [*center, height - 0.35], 0.019), rod([*center, height - 0.35], reach, 0.019)
        )
        shade = cup([reach[0], reach[1], height - 0.25], 0.22, 0.2, 0.1, 0.026)
        bulb = rod([*reach], [reach[0], reach[1], height - 0.16], 0.03)
    else:
        pole = rod([*center, 0.02], [*center, height - 0.05], 0.019)
        shade = cup([*center, height - tall], tall, wide, narrow, 0.026)
    ring = union(pole, foot, bulb)
    return Piece(
        "floor lamp",
        (Part(ring, materials.metal(rng)), Part(shade, Material((238, 226, 196), (226, 208, 168), "weave"))),
    )


def plant(rng: np.random.Generator) -> Piece:
    """A pot plant: tapered pot with earth, bent stems, flat leaves."""
    radius, pot_height = rng.uniform(0.13, 0.19), rng.uniform(0.24, 0.36)
    center = np.array([0, 0.3, 0])
    pot = cup([0, 0.3, -SINK], pot_height + SINK, 0.72 * radius, radius, 0.02, pot_height - 0.04)
    stems, leaves = [], []
    for i in range(int(rng.integers(7, 12))):
        angle = 2.4 * i + rng.normal(0, 0.2)
        lean, tall = rng.uniform(0.08, 0.26), rng.uniform(0.35, 1.0)
        way = np.array([np.cos(angle), np.sin(angle), 0])
        foot = center + 0.3 * radius * way + [0, 0, pot_height - 0.05]
        tip = center + lean * way + [0, 0, pot_height + 0.75 * tall]
        stems.append(rod(foot.tolist(), tip.tolist(), 0.016, 0.013))
        long = rng.uniform(0.14, 0.24)
        blade = ellipsoid([0, long, 0], [0.4 * long, long, 0.018]).tilted(-rng.uniform(-0.3, 0.9))
        leaves.append(blade.moved(tip.tolist(), angle - np.pi / 2))
    pot_color = (
        Material((176, 106, 78), (160, 92, 66), "spots") if rng.random() < 0.5 else materials.plastic(rng)
    )
    return Piece("plant", (Part(pot, pot_color), Part(union(*stems, *leaves), materials.leaf(rng))))


def bin_(rng: np.random.Generator) -> Piece:
    """A waste-paper basket."""
    radius, height = rng.uniform(0.12, 0.16), rng.uniform(0.28, 0.4)
    return Piece(
        "bin",
        (Part(cup([0, radius, -SINK], height, 0.8 * radius, radius, 0.015, 0.03), materials.plastic(rng)),),
    )


# --- parts that several pieces share --------------------------------------------------------------


def _legs(
    span: float, back: float, front: float, height: float, foot: float, hip: float, splay: float = 0.0
) -> Shape:
    """Four tapered legs, `span` apart in x, at y = `back` and `front`, feet set out by `splay`."""
    return union(
        *(
            rod([sx * (span / 2 + splay), y + sy * splay, -SINK], [sx * span / 2, y, height], foot, hip)
            for sx in (-1, 1)
            for y, sy in ((back, -1), (front, 1))
        )
    )


def _fronts(body: Shape, axis: str, n_fronts: int, front: float) -> Shape:
    """`body` with grooves that part its front (at y = `front`) into doors (along x) or drawers (along z)."""
    low, high = body.low, body.high
    i = "xyz".index(axis)
    grooves = []
    for at in np.linspace(low[i], high[i], n_fronts + 1)[1:-1]:
        start, end = low - 0.01, high + 0.01
        start[i], end[i] = at - 0.006, at + 0.006
        start[1], end[1] = front - 0.018, front + 0.02
        grooves.append(box(start.tolist(), end.tolist()))
    return cut(body, *grooves) if grooves else body


def _bent_slat(width: float, y: float, z: float, height: float) -> Shape:
    """A slat of a chair back, bowed backwards."""
    return union(
        *(rod([s * width / 2, y, z], [0, y - 0.025, z], 0.012) for s in (-1, 1)),
        *(rod([s * width / 2, y, z + height], [0, y - 0.025, z + height], 0.012) for s in (-1, 1)),
        box([-width / 2, y - 0.018, z], [width / 2, y - 0.002, z + height]),
    )


def _books(rng: np.random.Generator, width: float, tallest: float, deepest: float) -> Shape:
    """A row of upright books, 2 to 6 cm thick, of many heights."""
    thickness = rng.uniform(0.02, 0.06, int(width / 0.02) + 1)
    edges = np.concatenate([[0.0], np.cumsum(thickness)])
    edges = edges[edges < max(width, 0.07)]
    heights = rng.uniform(0.55, 1.0, len(edges) - 1) * min(tallest, 0.31)
    return box_row(edges, heights, rng.uniform(0.6, 1.0, len(edges) - 1) * min(deepest, 0.24), [0, 0, 0])


def _upholstered(
    kind: str, rng: np.random.Generator, width: float, depth: float, back: float, n_seats: int, n_loose: int
) -> Piece:
    """Base, back, arms, seat and back cushions that bulge, loose cushions, feet."""
    cloth = materials.fabric(rng)
    arm, seat, base = rng.uniform(0.12, 0.2), rng.uniform(0.4, 0.46), rng.uniform(0.24, 0.3)
    arm_height = rng.uniform(0.55, 0.65)
    half = width / 2
    body = smooth_union(
        0.05,
        box([-half, 0.02, 0.07], [half, depth, base], 0.03),
        box([-half, 0, 0.07], [half, 0.2, back], 0.08),
        *(
            box(
                [min(s * half, s * (half - arm)), 0.04, 0.07],
                [max(s * half, s * (half - arm)), depth, arm_height],
                0.07,
            )
            for s in (-1, 1)
        ),
    )
    inner = width - 2 * arm
    pitch = inner / n_seats
    soft = []
    for i in range(n_seats):
        x = -inner / 2 + i * pitch
        soft.append(
            cushion([x + 0.006, 0.22, base - 0.03], [x + pitch - 0.006, depth + 0.02, seat + 0.02], 0.35)
        )
        rest = cushion([-pitch / 2 + 0.01, -0.1, 0], [pitch / 2 - 0.01, 0.1, back - seat + 0.08], 0.5)
        soft.append(rest.tilted(0.2).moved([x + pitch / 2, 0.32, seat - 0.02]))
    padding = displaced(union(*soft), 0.005, ripples(rng, 0.3))
    feet = _legs(width - 0.16, 0.08, depth - 0.08, 0.09, 0.02, 0.028)
    parts = [
        Part(displaced(body, 0.003, ripples(rng, 0.4)), cloth),
        Part(padding, cloth),
        Part(feet, materials.wood(rng)),
    ]
    for _ in range(n_loose):
        size = rng.uniform(0.19, 0.24)
        loose = cushion([-size, -0.07, -size], [size, 0.07, size], 0.75).tilted(rng.uniform(0.25, 0.5))
        x = rng.uniform(-1, 1) * max(inner / 2 - size, 0)
        parts.append(
            Part(loose.moved([x, 0.5, seat + size - 0.01], rng.normal(0, 0.25)), materials.fabric(rng))
        )
    return Piece(kind, tuple(parts))
