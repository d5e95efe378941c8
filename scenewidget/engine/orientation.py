"""Which side of the surface is free space, and whether the coordinates are metres.

Goes in: a mesh, or items of one. Come out: items whose normals point into the room, remarks on what was
found, and a warning where neighbouring faces don't agree on the side.
Whether an edge is convex, and what is a wall, depends on the side; thresholds are in metres.
"""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np

from scenewidget.engine.checks import warn_caller
from scenewidget.engine.gravity import large_axes, up_direction
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.sides import right_side_out
from scenewidget.engine.units import METRE, likely_unit

__all__ = ["Orientation", "facing", "oriented", "up_direction", "warn_of_mixed_winding"]

Orientation = Literal["auto", "as given", "turned"]

CLEAR = 0.2  # `facing` says something from here on: it is 0.44 to 0.68 for rooms, −1 for a ball from outside.
ROOM = 2.2  # What is smaller than this (metres) is an object, looked at from outside.
PLANES = 0.3  # Of the area of what has walls and tops, at least this lies in its three largest directions.
MIXED = 0.02  # More of the edges wound both ways are worth a warning; scans have up to 0.004.


def facing(items: Items) -> float:
    """How much ``items`` look towards the middle of the scan, from −1 (a ball from outside) to 1.

    Mean over the area of ⟨N, m − x⟩ over that of |m − x|, m the centroid of the surface; 0 without area.

    Parameters
    ----------
    items : Items

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import sphere
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.orientation import facing
    >>> ball = sphere(1)
    >>> inside_out = sw.Mesh(ball.vertices, ball.faces[:, ::-1])
    >>> [round(facing(patch_items(mesh, np.arange(80))), 1) for mesh in (ball, inside_out)]
    [-1.0, 1.0]
    """
    if not items.areas.sum() > 0:
        return 0.0
    apart = np.average(items.centroids, axis=0, weights=items.areas) - items.centroids
    away = np.average(np.linalg.norm(apart, axis=1), weights=items.areas)
    towards = np.average(np.einsum("ij,ij->i", items.normals, apart), weights=items.areas)
    return float(towards / away) if away > 0 else 0.0


def oriented(items: Items, orientation: Orientation = "auto", evidence: float | None = None) -> Items:
    """Items with normals that point into free space; ``report["orientation"]`` says what was found.

    Parameters
    ----------
    items : Items
    orientation : str
        "auto" turns the normals where they point into what is thin rather than into what is wide (see
        `sides.right_side_out`): some programs export rooms, closets or things inside out. Where no two
        surfaces tell, what is as large as a room and looks outwards is turned. "as given" turns nothing,
        "turned" all.
    evidence : float, optional
        `sides.right_side_out` of the items' mesh, where the caller has it already.

    Warns
    -----
    UserWarning
        The mesh, unless a file's reader has asked already, fits another unit much better than the metre.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import sphere
    >>> from scenewidget.engine.items import patch_items
    >>> from scenewidget.engine.orientation import oriented
    >>> ball = sphere(1, radius=3.0)  # as large as a room, and looks outwards
    >>> items = patch_items(ball, np.arange(80))
    >>> oriented(items).report["orientation"]
    'room, inside out: its normals are turned'
    """
    if not items.areas.sum() > 0:
        return items
    _warn_of_unit(items.mesh)
    towards = facing(items)
    mesh = items.mesh
    if evidence is None:
        evidence = right_side_out(mesh.face_centroids, mesh.face_normals, mesh.face_areas)
    is_known = abs(evidence) > CLEAR / 2
    is_outward = evidence < 0 if is_known else towards < -CLEAR
    is_large = np.sort(np.ptp(mesh.bounds, axis=0))[1] >= ROOM
    # what is smaller than a room and round is a thing seen from outside, however thick it is
    is_wrong = is_outward and (is_large or (is_known and _is_of_planes(mesh)))
    turns = orientation == "turned" or (orientation == "auto" and is_wrong)
    if is_wrong:
        kind = "room" if is_large or towards < 0 else "object"
        found = f"{kind}, inside out" + (": its normals are turned" if turns else "")
    elif abs(towards) <= CLEAR and not is_known:
        found = "open: its normals are taken as they are"
    elif towards > 0 and (is_large or not (is_known and is_outward)):
        found = "room, seen from inside"
    else:
        found = "object, seen from outside"
    normals = -items.normals if turns else items.normals
    return dataclasses.replace(items, normals=normals, report={**items.report, "orientation": found})


def _warn_of_unit(mesh: Mesh) -> None:
    if mesh.source:
        return
    unit = likely_unit(mesh)
    if unit is not METRE:
        warn_caller(
            f"thresholds are in metres, and the mesh, {np.ptp(mesh.bounds, axis=0).max():.4g} across, looks "
            f'as if it were in {unit.name}; load_mesh(mesh, units="auto") scales it by {unit.factor:g}'
        )


def _is_of_planes(mesh: Mesh) -> bool:
    return sum(axis.share for axis in large_axes(mesh)[:3]) > PLANES


def warn_of_mixed_winding(mesh: Mesh, pairs: IntArray) -> None:
    """Say so where faces run through a common edge in one direction: they look to different sides.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int32
        `face_adjacency` of the mesh.

    Warns
    -----
    UserWarning
        More than 2 % of the pairs, of which some 50 000 are looked at, are wound against each other.

    Examples
    --------
    >>> import warnings
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> from scenewidget.engine.orientation import warn_of_mixed_winding
    >>> first, second = square(1).faces
    >>> mesh = sw.Mesh(square(1).vertices, [first, second[::-1]])
    >>> with warnings.catch_warnings(record=True) as heard:
    ...     warnings.simplefilter("always")
    ...     warn_of_mixed_winding(mesh, face_adjacency(mesh))
    >>> str(heard[0].message)[:66]
    'at 100% of the edges the two faces look to different sides of the '
    """
    if mesh.is_cloud:  # nothing winds
        return
    sample = pairs[:: max(1, len(pairs) // 50_000)]
    first, second = mesh.vertices[mesh.faces[sample]].transpose(1, 0, 2, 3)
    is_same = (first[:, :, None] == second[:, None]).all(axis=3)  # corner i of one is corner j of the other
    is_mixed = (is_same & np.roll(is_same, -1, axis=(1, 2))).any(axis=(1, 2))
    if is_mixed.any() and is_mixed.mean() > MIXED:
        warn_caller(
            f"at {is_mixed.mean():.0%} of the edges the two faces look to different sides of the surface, "
            "and creases may be found where there are none; wind the faces the same way first, as "
            "trimesh.repair.fix_winding does"
        )
