"""A furnished room as one signed distance field that knows what each point is nearest to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scenewidget.datasets.materials import Material
from scenewidget.datasets.objects import Part, Piece
from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["Scene", "Thing", "place"]


@dataclass(frozen=True, eq=False)
class Thing:
    """A piece in its place: one instance of the truth, parts in room coordinates (metres, z up)."""

    name: str
    parts: tuple[Part, ...]


def place(name: str, piece: Piece, offset: Sequence[float], turn: float = 0.0) -> Thing:
    """`piece` turned by `turn` radians about z and shifted by `offset` metres."""
    return Thing(name, tuple(Part(part.shape.moved(offset, turn), part.material) for part in piece.parts))


class Scene:
    """All things of a room.

    Parameters
    ----------
    things : sequence of Thing
        Order matters only for exact ties: the first wins.
    """

    def __init__(self, things: Sequence[Thing]) -> None:
        self.things = tuple(things)
        self.parts = tuple(part for thing in things for part in thing.parts)
        self.part_thing: IntArray = np.repeat(np.arange(len(things)), [len(thing.parts) for thing in things])
        self.low = np.array([part.shape.low for part in self.parts])
        self.high = np.array([part.shape.high for part in self.parts])

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each thing."""
        return tuple(thing.name for thing in self.things)

    @property
    def materials(self) -> tuple[Material, ...]:
        """Material of each part."""
        return tuple(part.material for part in self.parts)

    def nearest(self, points: FloatArray, *, reach: float = 0.08) -> tuple[FloatArray, IntArray]:
        """Signed distance to the nearest surface, and the part that it belongs to.

        Parameters
        ----------
        points : (3, n) float
            Room coordinates, metres.
        reach : float
            Parts further away than this (metres) are left out at first; points that find none are asked
            again.

        Returns
        -------
        distance : (n,) float32
            Smallest signed distance over all parts: inside several parts, that to the one we are deepest in.
        part : (n,) int32
        """
        points = np.ascontiguousarray(points, dtype=np.float32)
        n = points.shape[1]
        distance = np.full(n, np.inf, dtype=np.float32)
        nearest = np.zeros(n, dtype=np.int32)
        order = np.argsort(points[0], kind="stable")  # a slab in x is then one slice
        x = points[0][order]
        for i, part in enumerate(self.parts):
            first, last = np.searchsorted(x, [self.low[i, 0] - reach, self.high[i, 0] + reach])
            here = order[first:last]
            is_near = np.ones(len(here), dtype=bool)
            for axis in (1, 2):
                along = points[axis][here]
                is_near &= (along >= self.low[i, axis] - reach) & (along <= self.high[i, axis] + reach)
            here = here[is_near]
            if len(here):
                found = part.shape.distance(points[:, here]).astype(np.float32)
                closer = found < distance[here]
                distance[here[closer]] = found[closer]
                nearest[here[closer]] = i
        lost = np.flatnonzero(distance > reach)
        if len(lost) and reach < 100:
            distance[lost], nearest[lost] = self.nearest(points[:, lost], reach=max(20 * reach, 1))
        return distance, nearest
