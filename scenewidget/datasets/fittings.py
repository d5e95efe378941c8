"""What belongs to walls, ceiling and floor, and the small things that lie about.

Wall things are built with the wall's surface at y = 0 and the free space at y > 0, ceiling things hang down
from z = 0, the others stand on z = 0. All reach a little into what carries them (`SINK`).
"""

from __future__ import annotations

import numpy as np

from scenewidget.datasets import materials
from scenewidget.datasets.materials import Material
from scenewidget.datasets.objects import SINK, Maker, Part, Piece
from scenewidget.datasets.shapes import (
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
    repeated,
    ripples,
    rod,
    smooth_union,
    torus,
    union,
    wavy_sheet,
)

__all__ = [
    "CLUTTER",
    "carpet",
    "curtain",
    "door",
    "hanging_lamp",
    "monitor",
    "picture",
    "radiator",
    "table_lamp",
    "television",
    "wall_shelf",
    "window",
]

LACQUER = Material((240, 239, 234), (228, 226, 220), "spots", 0.6)


def picture(rng: np.random.Generator) -> Piece:
    """A framed print, 3 cm proud of the wall; its middle is at z = 0."""
    w, h = rng.uniform(0.15, 0.42), rng.uniform(0.18, 0.38)
    rim = cut(
        box([-w, -SINK, -h], [w, 0.035, h], 0.004), box([-w + 0.03, 0, -h + 0.03], [w - 0.03, 0.1, h - 0.03])
    )
    canvas = box([-w + 0.01, -SINK, -h + 0.01], [w - 0.01, 0.02, h - 0.01])
    return Piece("picture", (Part(rim, materials.wood(rng)), Part(canvas, materials.paper(rng))))


def television(rng: np.random.Generator) -> Piece:
    """A flat screen on the wall, black: much of its depth is lost; its middle is at z = 0."""
    w = rng.uniform(0.45, 0.65)
    h = 0.58 * w
    body = union(box([-w, 0.03, -h], [w, 0.075, h], 0.01), box([-0.15, -SINK, -0.12], [0.15, 0.04, 0.12]))
    screen = box([-w + 0.015, 0.05, -h + 0.02], [w - 0.015, 0.078, h - 0.015])
    return Piece("television", (Part(body, Material((30, 30, 32))), Part(screen, materials.glass(0.3))))


def wall_shelf(rng: np.random.Generator) -> Piece:
    """A board on brackets with a few books, which belong to it; the board is at z = 0."""
    w, depth = rng.uniform(0.35, 0.6), rng.uniform(0.2, 0.26)
    board = union(
        box([-w, -SINK, -0.028], [w, depth, 0], 0.004),
        *(rod([s * 0.7 * w, 0.0, -0.15], [s * 0.7 * w, 0.8 * depth, -0.02], 0.012) for s in (-1, 1)),
        *(rod([s * 0.7 * w, 0.005, -0.16], [s * 0.7 * w, 0.005, -0.01], 0.013) for s in (-1, 1)),
    )
    n_books = int(rng.integers(4, 9))
    edges = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.05, n_books))])
    row = box_row(
        edges, rng.uniform(0.16, 0.27, n_books), rng.uniform(0.12, 0.19, n_books), [-0.9 * w, 0.01, -0.004]
    )
    books = Part(row, Material((160, 80, 60), (70, 100, 120), "books", 0.03))
    return Piece("wall shelf", (Part(board, materials.wood(rng)), books))


def radiator(rng: np.random.Generator, width: float) -> Piece:
    """A ribbed radiator on the wall, 12 cm above the floor, with its pipe."""
    n_ribs = max(int(width / 0.062), 3)
    tall = rng.uniform(0.5, 0.62)
    rib = box([-0.02, 0.045, 0.12], [0.02, 0.145, 0.12 + tall], 0.019)
    body = union(
        repeated(rib, 0, n_ribs, 0.062),
        *(rod([-0.031 * n_ribs, 0.095, z], [0.031 * n_ribs, 0.095, z], 0.026) for z in (0.17, 0.07 + tall)),
        *(rod([s * 0.025 * n_ribs, -SINK, 0.45], [s * 0.025 * n_ribs, 0.08, 0.45], 0.02) for s in (-1, 1)),
        rod([0.033 * n_ribs, 0.095, -SINK], [0.033 * n_ribs, 0.095, 0.18], 0.014),
        cylinder([0.036 * n_ribs, 0.095, 0.14], 0.08, 0.026, 0.01),
    )
    return Piece("radiator", (Part(body, LACQUER),))


def curtain(rng: np.random.Generator, width: float, height: float) -> Piece:
    """A folded cloth on a rod, from `height` down nearly to the floor."""
    cloth = wavy_sheet(
        [-width / 2, 0.03, 0.03],
        [width / 2, 0.2, height],
        width / rng.uniform(0.13, 0.18),
        0.04,
        rng.uniform(0, 6),
    )
    pole = union(
        rod([-width / 2 - 0.06, 0.11, height + 0.01], [width / 2 + 0.06, 0.11, height + 0.01], 0.016),
        rod([0, -SINK, height + 0.01], [0, 0.11, height + 0.01], 0.014),
        *(ball([s * (width / 2 + 0.06), 0.11, height + 0.01], 0.026) for s in (-1, 1)),
    )
    cloth = displaced(cloth, 0.006, ripples(rng, 0.5))
    return Piece("curtain", (Part(cloth, materials.fabric(rng)), Part(pole, materials.metal(rng))))


def window(rng: np.random.Generator, width: float, height: float, depth: float) -> Piece:
    """Frame, glazing bars, panes and sill in a recess of `depth`; the lower edge of the recess is at z =
    0.
    """
    w = width / 2
    rim, back = 0.06, -depth
    bars = [box([-0.03, back, 0], [0.03, back + 0.06, height])] if width > 0.8 else []
    if rng.random() < 0.5:
        bars.append(box([-w, back, 0.68 * height - 0.02], [w, back + 0.055, 0.68 * height + 0.02]))
    frame = union(
        box([-w - SINK, back - SINK, -SINK], [-w + rim, back + 0.07, height + SINK]),
        box([w - rim, back - SINK, -SINK], [w + SINK, back + 0.07, height + SINK]),
        box([-w, back - SINK, -SINK], [w, back + 0.07, rim]),
        box([-w, back - SINK, height - rim], [w, back + 0.07, height + SINK]),
        box([-w - 0.04, -depth, -0.035], [w + 0.04, rng.uniform(0.03, 0.12), 0.008], 0.008),
        rod([0.02, back + 0.09, 0.42 * height], [0.02, back + 0.09, 0.42 * height + 0.12], 0.012),
        rod([0.02, back + 0.05, 0.42 * height], [0.02, back + 0.09, 0.42 * height], 0.012),
        *bars,
    )
    pane = box([-w, back - SINK, 0], [w, back + 0.02, height])
    return Piece(
        "window", (Part(frame, LACQUER), Part(pane, materials.glass(float(rng.choice([0.25, 0.6, 0.9])))))
    )


def door(rng: np.random.Generator, width: float, height: float, angle: float) -> Piece:
    """Frame, leaf with two panels, handles: one instance. `angle` radians open into the room, hinges at
    +x.
    """
    w = width / 2
    casing = cut(
        union(
            box([-w - 0.07, -SINK, -SINK], [w + 0.07, 0.02, height + 0.07], 0.004),
            box([-w - SINK, -0.1, -SINK], [w + SINK, 0.01, height + SINK]),
        ),
        box([-w + 0.015, -1, -0.1], [w - 0.015, 1, height - 0.015]),
    )
    leaf = cut(
        box([-width + 0.03, -0.045, 0.005], [0, 0.0, height - 0.02], 0.003),
        *(
            box([-width + 0.15, -0.012, low], [-0.13, 0.1, high])
            for low, high in ((0.2, 0.85), (1.05, height - 0.18))
        ),
    )
    handle = union(
        *(
            union(
                rod([-width + 0.1, y, 1.03], [-width + 0.1, 2.2 * y, 1.03], 0.014),
                rod([-width + 0.1, 2.2 * y, 1.03], [-width + 0.22, 2.2 * y, 1.03], 0.013),
            )
            for y in (-0.06, 0.035)
        )
    )
    hinge = [w - 0.016, 0.0, 0.0]
    return Piece(
        "door",
        (
            Part(casing, LACQUER),
            Part(leaf.moved(hinge, -angle), materials.wood(rng) if rng.random() < 0.4 else LACQUER),
            Part(handle.moved(hinge, -angle), materials.metal(rng)),
        ),
    )


def hanging_lamp(rng: np.random.Generator) -> Piece:
    """A lamp that hangs from the ceiling at z = 0: a bell, a globe or a ring of globes."""
    drop = rng.uniform(0.45, 0.8)
    metal = materials.metal(rng)
    cord = union(rod([0, 0, SINK], [0, 0, -drop], 0.017), cone([0, 0, -0.035], 0.035 + SINK, 0.025, 0.055))
    style = rng.integers(3)
    if style == 0:
        wide = rng.uniform(0.18, 0.26)
        head = union(cup([0, 0, -drop - 0.2], 0.22, wide, 0.06, 0.026), ball([0, 0, -drop - 0.1], 0.05))
    elif style == 1:
        head = ball([0, 0, -drop - 0.1], rng.uniform(0.13, 0.18))
    else:
        angles = np.arange(5) * 2 * np.pi / 5 + rng.uniform(0, 1)
        tips = [[0.28 * np.cos(a), 0.28 * np.sin(a), -drop + 0.02] for a in angles]
        head = union(
            ball([0, 0, -drop], 0.04),
            *(rod([0, 0, -drop], tip, 0.018) for tip in tips),
            *(ball([tip[0], tip[1], tip[2] - 0.05], 0.06) for tip in tips),
        )
    return Piece(
        "hanging lamp", (Part(cord, metal), Part(head, Material((240, 230, 204), (228, 214, 178), "spots")))
    )


def carpet(rng: np.random.Generator) -> Piece:
    """A carpet, 1.5 cm thick, rectangular or round, a little wavy; its middle is at the origin."""
    w, h = rng.uniform(0.8, 1.3), rng.uniform(0.6, 0.95)
    body = (
        box([-w, -h, -SINK], [w, h, 0.014], 0.006)
        if rng.random() < 0.65
        else cylinder([0, 0, -SINK], 0.029, h, 0.006)
    )
    return Piece("carpet", (Part(displaced(body, 0.003, ripples(rng, 0.7)), materials.fabric(rng)),))


def monitor(rng: np.random.Generator) -> Piece:
    """A computer screen on its foot."""
    w = rng.uniform(0.25, 0.32)
    screen = box([-w, -0.018, 0.1], [w, 0.018, 0.1 + 1.15 * w], 0.008).tilted(0.06)
    foot = union(
        cylinder([0, -0.03, -SINK], 0.012 + SINK, 0.11, 0.006), rod([0, -0.05, 0], [0, -0.035, 0.25], 0.018)
    )
    panel = box([-w + 0.015, 0.0, 0.115], [w - 0.015, 0.021, 0.09 + 1.15 * w]).tilted(0.06)
    return Piece(
        "monitor", (Part(union(screen, foot), Material((40, 40, 44))), Part(panel, materials.glass(0.25)))
    )


def table_lamp(rng: np.random.Generator) -> Piece:
    """A small lamp: a turned or round foot and a conical shade."""
    tall = rng.uniform(0.22, 0.3)
    foot = smooth_union(
        0.04,
        cone([0, 0, -SINK], 0.03 + SINK, 0.075, 0.05),
        ellipsoid([0, 0, 0.45 * tall], [0.06, 0.06, 0.4 * tall]),
        rod([0, 0, 0], [0, 0, tall + 0.05], 0.014),
    )
    shade = cup([0, 0, tall], 0.17, rng.uniform(0.12, 0.15), 0.08, 0.024)
    return Piece(
        "table lamp",
        (Part(foot, materials.plastic(rng)), Part(shade, Material((236, 222, 190), (222, 204, 164)))),
    )


# --- small things ---------------------------------------------------------------------------------


def _vase(rng: np.random.Generator) -> Piece:
    tall, wide = rng.uniform(0.16, 0.3), rng.uniform(0.05, 0.085)
    belly = smooth_union(
        0.06,
        ellipsoid([0, 0, 0.4 * tall], [wide, wide, 0.42 * tall]),
        cone([0, 0, -SINK], 0.04 + SINK, 0.8 * wide, 0.6 * wide),
        cone([0, 0, 0.7 * tall], 0.3 * tall, 0.4 * wide, 0.6 * wide),
    )
    return Piece("vase", (Part(belly, materials.plastic(rng)),))


def _bowl(rng: np.random.Generator) -> Piece:
    radius = rng.uniform(0.1, 0.16)
    shell = union(
        cup([0, 0, -SINK], 0.09, 0.5 * radius, radius, 0.014, 0.03),
        torus([0, 0, 0.075], radius - 0.006, 0.009),
    )
    fruit = union(
        *(ball([0.45 * radius * np.cos(a), 0.45 * radius * np.sin(a), 0.065], 0.038) for a in (0.3, 2.4, 4.5))
    )
    return Piece(
        "bowl",
        (Part(shell, materials.plastic(rng)), Part(fruit, Material((206, 120, 50), (190, 60, 40), "spots"))),
    )


def _book_stack(rng: np.random.Generator) -> Piece:
    z, books = -SINK, []
    for _ in range(int(rng.integers(2, 6))):
        thick = rng.uniform(0.018, 0.045)
        w, h = rng.uniform(0.07, 0.1), rng.uniform(0.1, 0.14)
        books.append(box([-w, -h, z], [w, h, z + thick + 0.001]).moved([0, 0, 0], rng.normal(0, 0.2)))
        z += thick
    return Piece("books", (Part(union(*books), Material((150, 70, 60), (60, 90, 130), "books", 0.03)),))


def _carton(rng: np.random.Generator) -> Piece:
    w, h, tall = rng.uniform(0.09, 0.2), rng.uniform(0.09, 0.16), rng.uniform(0.1, 0.28)
    body = box([-w, -h, -SINK], [w, h, tall], 0.004)
    flap = (
        cut(body, box([-w + 0.015, -h + 0.015, 0.4 * tall], [w - 0.015, h - 0.015, 1]))
        if rng.random() < 0.5
        else body
    )
    return Piece("box", (Part(flap, Material((186, 150, 108), (170, 134, 94), "spots", 0.2)),))


def _toy_ball(rng: np.random.Generator) -> Piece:
    radius = rng.uniform(0.07, 0.13)
    return Piece("ball", (Part(ball([0, 0, radius - 0.006], radius), materials.plastic(rng)),))


def _bag(rng: np.random.Generator) -> Piece:
    w, tall = rng.uniform(0.16, 0.22), rng.uniform(0.24, 0.34)
    body = smooth_union(
        0.1,
        ellipsoid([0, 0, 0.38 * tall], [w, 0.12, 0.44 * tall]),
        box([-0.9 * w, -0.1, -SINK], [0.9 * w, 0.1, 0.5 * tall], 0.05),
    )
    strap = union(
        rod([-0.6 * w, 0, 0.6 * tall], [0, 0.02, tall + 0.1], 0.014),
        rod([0, 0.02, tall + 0.1], [0.6 * w, 0, 0.6 * tall], 0.014),
    )
    return Piece(
        "bag", (Part(displaced(union(body, strap), 0.008, ripples(rng, 0.16)), materials.fabric(rng)),)
    )


def _clothes(rng: np.random.Generator) -> Piece:
    lumps = [
        ellipsoid(
            [*rng.normal(0, 0.1, 2), 0.03],
            [rng.uniform(0.14, 0.26), rng.uniform(0.1, 0.2), rng.uniform(0.05, 0.1)],
        )
        for _ in range(3)
    ]
    heap = displaced(smooth_union(0.1, *lumps), 0.011, ripples(rng, 0.15))
    return Piece("clothes", (Part(heap, materials.fabric(rng)),))


def _floor_cushion(rng: np.random.Generator) -> Piece:
    size = rng.uniform(0.22, 0.3)
    soft = displaced(cushion([-size, -size, -0.02], [size, size, 0.15], 0.7), 0.004, ripples(rng, 0.25))
    return Piece("cushion", (Part(soft, materials.fabric(rng)),))


def _laptop(rng: np.random.Generator) -> Piece:
    base = box([-0.16, -0.11, -SINK], [0.16, 0.11, 0.02], 0.004)
    lid = box([-0.16, -0.008, 0], [0.16, 0.008, 0.22], 0.004).tilted(0.25).moved([0, -0.11, 0.015])
    return Piece("laptop", (Part(union(base, lid), Material((150, 152, 156))),))


def _mug(rng: np.random.Generator) -> Piece:
    body = cup([0, 0, -SINK], 0.1 + SINK, 0.042, 0.046, 0.01, 0.03)
    ear = rod([0.05, 0, 0.03], [0.075, 0, 0.05], 0.009)
    return Piece(
        "mug",
        (Part(union(body, ear, rod([0.075, 0, 0.05], [0.05, 0, 0.08], 0.009)), materials.plastic(rng)),),
    )


def _pot_plant(rng: np.random.Generator) -> Piece:
    pot = cup([0, 0, -SINK], 0.12, 0.05, 0.07, 0.012, 0.08)
    blobs = [
        ellipsoid([*rng.normal(0, 0.045, 2), rng.uniform(0.13, 0.26)], rng.uniform(0.04, 0.07, 3).tolist())
        for _ in range(5)
    ]
    crown = displaced(
        smooth_union(0.03, *blobs, rod([0, 0, 0.06], [0, 0, 0.2], 0.02)), 0.006, ripples(rng, 0.07)
    )
    return Piece("pot plant", (Part(pot, materials.plastic(rng)), Part(crown, materials.leaf(rng))))


# small things by where they may be: on tops of furniture, or on the floor
CLUTTER: dict[str, tuple[Maker, ...]] = {
    "top": (_vase, _bowl, _book_stack, _carton, _laptop, _mug, _pot_plant, table_lamp, _book_stack),
    "floor": (_carton, _toy_ball, _bag, _clothes, _floor_cushion, _book_stack),
}
