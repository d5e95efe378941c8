"""What things are made of, as far as a scanner notices: their colours and how much of their depth gets
lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

__all__ = ["Material", "fabric", "glass", "leaf", "metal", "paint", "paper", "plastic", "wood"]

Pattern = Literal["plain", "grain", "weave", "stripes", "checks", "spots", "print", "books", "planks"]
Color = tuple[int, int, int]
T = TypeVar("T")


@dataclass(frozen=True)
class Material:
    """Surface of a part.

    Parameters
    ----------
    color, accent : (red, green, blue) in 0..255
        Main colour and the second colour of the pattern.
    pattern : str
        How the two alternate over the surface.
    scale : float
        Size of the pattern in metres.
    dropout : float
        Share of depth readings that come back empty: glass lets light through, black absorbs it, metal
        mirrors it.
    """

    color: Color
    accent: Color = (128, 128, 128)
    pattern: Pattern = "plain"
    scale: float = 0.1
    dropout: float = 0.0


def paint(rng: np.random.Generator) -> Material:
    """Wall paint: white, cream, or a muted colour."""
    base = _pick(rng, [(236, 233, 226), (228, 219, 200), (214, 222, 224), (221, 208, 196), (201, 212, 198)])
    return Material(_vary(rng, base, 6), _vary(rng, base, 14), "spots", 1.2)


def wood(rng: np.random.Generator) -> Material:
    """Oak, pine, walnut or white lacquer."""
    base, vein = _pick(
        rng,
        [
            ((190, 148, 98), (160, 118, 72)),
            ((214, 180, 130), (190, 150, 100)),
            ((112, 76, 50), (84, 54, 34)),
            ((226, 224, 218), (214, 210, 202)),
            ((150, 104, 66), (122, 82, 48)),
        ],
    )
    return Material(_vary(rng, base, 8), _vary(rng, vein, 8), "grain", float(rng.uniform(0.03, 0.07)))


def fabric(rng: np.random.Generator) -> Material:
    """Upholstery and cloth: muted or strong, woven, striped, chequered or spotted."""
    base = _pick(
        rng,
        [
            (92, 108, 124),
            (150, 88, 72),
            (86, 112, 92),
            (178, 160, 134),
            (122, 116, 112),
            (52, 72, 104),
            (196, 150, 72),
            (136, 86, 108),
        ],
    )
    pattern: Pattern = _pick(rng, ["weave", "weave", "weave", "stripes", "checks", "spots"])
    accent = _vary(rng, base, 40)
    return Material(_vary(rng, base, 10), accent, pattern, float(rng.uniform(0.05, 0.16)))


def paper(rng: np.random.Generator) -> Material:
    """A print or painting: areas of saturated colours."""
    return Material(_vivid(rng), _vivid(rng), "print", float(rng.uniform(0.12, 0.3)))


def plastic(rng: np.random.Generator) -> Material:
    """A plain vivid, grey or white thing."""
    grey = int(rng.integers(60, 235))
    return Material(_vivid(rng) if rng.random() < 0.6 else (grey, grey, grey))


def metal(rng: np.random.Generator) -> Material:
    """Brushed steel, brass or black iron, which scanners read badly."""
    base = _pick(rng, [(150, 152, 156), (176, 146, 84), (44, 44, 48)])
    return Material(_vary(rng, base, 6), _vary(rng, base, 16), "weave", 0.03, dropout=0.08)


def leaf(rng: np.random.Generator) -> Material:
    """Green of a pot plant."""
    return Material(_vary(rng, (74, 118, 58), 16), _vary(rng, (104, 150, 76), 16), "spots", 0.05)


def glass(dropout: float) -> Material:
    """A window pane or dark screen."""
    return Material((58, 66, 78), (92, 108, 124), "spots", 0.5, dropout=dropout)


def _pick(rng: np.random.Generator, options: Sequence[T]) -> T:
    return options[int(rng.integers(len(options)))]


def _vary(rng: np.random.Generator, color: Color, amount: float) -> Color:
    r, g, b = np.clip(np.array(color) + rng.normal(0, amount, 3), 0, 255).astype(int).tolist()
    return r, g, b


def _vivid(rng: np.random.Generator) -> Color:
    hue, value = rng.uniform(0, 6), rng.uniform(120, 230)
    ramp = np.clip(np.abs((hue + np.array([0, 4, 2])) % 6 - 3) - 1, 0, 1)
    r, g, b = (value * (1 - rng.uniform(0.4, 0.8) * (1 - ramp))).astype(int).tolist()
    return r, g, b
