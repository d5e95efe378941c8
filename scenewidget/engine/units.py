"""In which unit a scan is: from its size, how dense its surface is, and how high its rooms are.

Goes in: a mesh. Comes out: the unit that fits best, with the factor to metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from scenewidget.engine.gravity import large_axes
from scenewidget.engine.mesh import FloatArray, Mesh

__all__ = ["FACTORS", "METRE", "Unit", "UnitName", "likely_unit"]

UnitName = Literal["auto", "m", "cm", "mm", "in", "ft"]
FACTORS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}  # to metres


@dataclass(frozen=True)
class Unit:
    """A unit of length.

    Attributes
    ----------
    name : str
    factor : float
        Metres of one.

    Examples
    --------
    >>> Unit("inches", 0.0254).factor
    0.0254
    """

    name: str
    factor: float


METRE = Unit("metres", 1.0)
UNITS = (  # and how unlikely each is before anything is seen, in nats
    (METRE, 0.0),
    (Unit("millimetres", 0.001), 0.7),
    (Unit("centimetres", 0.01), 1.5),
    (Unit("inches", 0.0254), 2.0),
    (Unit("feet", 0.3048), 2.0),
    (Unit("hundreds of metres", 100.0), 3.0),  # scaled down once too often
    (Unit("thousands of metres", 1000.0), 3.0),
)
ROOM = ((4.5, 0.8), (0.015, 1.2))  # metres across and of an edge: medians, and widths of their logarithms
THINGS = ((1.2, 0.8), (0.003, 1.2))  # the same of scans of a table
HEIGHT, SPREAD = 2.6, 0.13  # metres from floor to ceiling
FLAT = 0.4  # height over width up to which a scan may be of a table
SURE = 3.0  # nats by which another unit must be more likely than the metre


def likely_unit(mesh: Mesh) -> Unit:
    """The unit that fits the mesh best; the metre unless another one fits much better.

    Parameters
    ----------
    mesh : Mesh

    Examples
    --------
    >>> from scenewidget.datasets import load_room
    >>> room = load_room()[0]
    >>> likely_unit(room).name, likely_unit(Mesh(room.vertices * 1000, room.faces)).name
    ('metres', 'millimetres')
    """
    if mesh.is_cloud:  # has no edges; its reader judges the size alone
        return METRE
    extent = np.sort(np.ptp(mesh.bounds, axis=0))[::-1]
    edge = _median_edge(mesh)
    if not (extent[0] > 0 and edge > 0):
        return METRE
    axes = large_axes(mesh)[:3]
    opposed = [axis for axis in axes if axis.is_opposed and axis.share > 0.1]
    is_flat = len(axes) > 0 and not opposed and min(axis.extent for axis in axes) < FLAT * extent[0]
    kinds = (ROOM, THINGS) if is_flat else (ROOM,)
    heights = []
    if opposed:  # the widest pair of surfaces, for their distance, is floor and ceiling
        heights.append(max(opposed, key=lambda axis: axis.share / axis.extent).extent)
    scores = []
    for unit, unlikely in UNITS:
        size = max(
            _fit(extent[0] * unit.factor, kind[0]) + _fit(edge * unit.factor, kind[1]) for kind in kinds
        )
        size += sum(max(_fit(height * unit.factor, (HEIGHT, SPREAD)), -6.0) for height in heights)
        scores.append(size - unlikely)
    best = int(np.argmax(scores))
    return UNITS[best][0] if scores[best] > scores[0] + SURE else METRE


def _fit(value: float, expected: tuple[float, float]) -> float:
    """Logarithm of a normal density of the logarithm, up to a constant."""
    median, width = expected
    return -0.5 * float(np.log(value / median) / width) ** 2


def _median_edge(mesh: Mesh) -> float:
    some = mesh.faces[:: max(1, mesh.n_faces // 20_000)]
    edges: FloatArray = mesh.vertices[some[:, 0]] - mesh.vertices[some[:, 1]]
    return float(np.median(np.linalg.norm(edges, axis=1)))
