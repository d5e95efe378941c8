"""In which unit a scan is: from its size, how dense its surface is, and how high its rooms are.

Goes in: a mesh. Comes out: the unit that fits best, with the factor to metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from scenewidget.engine.gravity import large_axes, up_direction
from scenewidget.engine.mesh import FloatArray, Mesh

__all__ = ["FACTORS", "METRE", "Unit", "UnitName", "likely_unit", "likely_units"]

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
SHELF = (0.7, 0.4)  # metres from the floor to what people put things on: median, and width of the logarithm
WALL = (2.4, 0.5)  # the same of how high a scan reaches above its floor, where it has no ceiling
LEAST_SHELF = 0.03  # of the area that faces up must lie above the floor, or it says nothing
LARGE = 6.0  # extent from which a scan without a ceiling may be in feet or inches
USUAL = (1.5, 12.0)  # extents of a cloud that is taken in metres, though another unit may be named
N_POINTS = 30_000  # of a cloud that are enough to tell
SPREAD_OUT = 1.3  # edges of a mesh for the distance to the sixth neighbour in a cloud as dense
FLAT = 0.4  # height over width up to which a scan may be of a table
ONE_PLANE = 0.36  # of the area, that the top of a table has at least
SURE = 3.0  # nats by which another unit must be more likely than the metre
NEARLY = float(np.log(10.0))  # nats by which a unit may be less likely than the best and still be named


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
    return likely_units(mesh)[0]


def likely_units(mesh: Mesh) -> tuple[Unit, ...]:
    """The unit of `likely_unit`, and behind it those that are at least a tenth as likely as the best.

    A table of four feet looks much like one of four metres, a table in inches like a larger one in
    centimetres: size and density can't tell these apart.

    Parameters
    ----------
    mesh : Mesh

    Examples
    --------
    >>> from scenewidget.datasets import load_room
    >>> [unit.name for unit in likely_units(load_room()[0])]
    ['metres']
    """
    is_usual = mesh.is_cloud and USUAL[0] <= float(np.ptp(mesh.bounds, axis=0).max()) <= USUAL[1]
    scores = _scores(mesh)
    if not scores:
        return (METRE,)
    best = int(np.argmax(scores))
    taken = best if scores[best] > scores[0] + SURE and not is_usual else 0
    near = [k for k in np.argsort(scores)[::-1].tolist() if scores[k] > scores[best] - NEARLY and k != taken]
    return tuple(UNITS[k][0] for k in (taken, *near))


def _scores(mesh: Mesh) -> list[float]:
    """How well each of the units fits, in nats; none for what has no size."""
    low, high = mesh.bounds
    if mesh.is_cloud:
        cloud: Any = mesh
        mesh = some = cloud.thinned(N_POINTS)
        edge = some.spacing / SPREAD_OUT * float(some.n_faces / cloud.n_faces) ** 0.5
        low, high = np.percentile(some.points, [1, 99], axis=0)  # a beam may end in the street
    else:
        edge = _median_edge(mesh)
    extent = np.sort(high - low)[::-1]
    if not (extent[0] > 0 and edge > 0):
        return []
    found = large_axes(mesh)
    axes = found[:3]
    opposed = [axis for axis in axes if axis.is_opposed and axis.share > 0.1]
    is_flat = bool(axes) and axes[0].share > ONE_PLANE and axes[0].extent < FLAT * extent[0]
    is_flat = is_flat and not opposed
    heights = []
    shelf, top = 0.0, 0.0
    up = up_direction(mesh, found) if extent[0] > LARGE else None
    if up is not None:  # walls may be opposed where there is no ceiling
        opposed = [axis for axis in opposed if abs(axis.direction @ up) > 0.95]
        if not opposed:
            shelf, top = _above_floor(mesh, up)
    if opposed:  # the widest pair of surfaces, for their distance, is floor and ceiling
        heights.append(max(opposed, key=lambda axis: axis.share / axis.extent).extent)
    scores = []
    for unit, unlikely in UNITS:
        room, things = (
            _fit(extent[0] * unit.factor, size) + _fit(edge * unit.factor, fine)
            for size, fine in (ROOM, THINGS)
        )
        room += sum(max(_fit(height * unit.factor, (HEIGHT, SPREAD)), -6.0) for height in heights)
        room += max(_fit(shelf * unit.factor, SHELF), -6.0) if shelf > 0 else 0.0
        room += max(_fit(top * unit.factor, WALL), -3.0) if top > 0 else 0.0
        scores.append((max(room, things) if is_flat else room) - unlikely)
    return scores


def _above_floor(mesh: Mesh, up: FloatArray) -> tuple[float, float]:
    """How high above the floor half of what faces up beyond it lies, and the whole scan; 0 where unknown."""
    height = mesh.face_centroids @ up
    faces_up = mesh.face_vectors @ up
    if not mesh.has_sides:  # of a cloud: part of the floor may look down
        faces_up = np.abs(faces_up)
    is_level = faces_up > 1.9 * mesh.face_areas
    if not is_level.any():
        return 0.0, 0.0
    levels, areas = height[is_level], mesh.face_areas[is_level]
    low, high = np.percentile(height, [0.5, 99.5])
    bins = np.clip(((levels - low) / max(high - low, 1e-300) * 50).astype(int), 0, 49)
    floor = low + (np.bincount(bins, areas, 50).argmax() + 0.5) / 50 * (high - low)
    is_above = levels > floor + 0.06 * (high - low)
    if areas[is_above].sum() < LEAST_SHELF * areas.sum():
        return 0.0, float(high - floor)
    order = np.argsort(levels[is_above])
    share = np.cumsum(areas[is_above][order])
    middle = levels[is_above][order][np.searchsorted(share, 0.5 * share[-1])]
    return float(middle - floor), float(high - floor)


def _fit(value: float, expected: tuple[float, float]) -> float:
    """Logarithm of a normal density of the logarithm, up to a constant."""
    median, width = expected
    return -0.5 * float(np.log(value / median) / width) ** 2


def _median_edge(mesh: Mesh) -> float:
    some = mesh.faces[:: max(1, mesh.n_faces // 20_000)]
    edges: FloatArray = mesh.vertices[some[:, 0]] - mesh.vertices[some[:, 1]]
    return float(np.median(np.linalg.norm(edges, axis=1)))
