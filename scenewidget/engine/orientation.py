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
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import IntArray, Mesh

__all__ = ["Orientation", "facing", "oriented", "warn_of_mixed_winding"]

Orientation = Literal["auto", "as given", "turned"]

CLEAR = 0.2  # `facing` says something from here on: it is 0.44 to 0.68 for rooms, −1 for a ball from outside.
ROOM = 2.2  # What is smaller than this (metres) is an object, looked at from outside.
FEWEST, MOST = 0.02, 300.0  # metres across; less or more is likely to be another unit
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


def oriented(items: Items, orientation: Orientation = "auto") -> Items:
    """Items with normals that point into free space; ``report["orientation"]`` says what was found.

    Parameters
    ----------
    items : Items
    orientation : str
        "auto" turns the normals of what is as large as a room and looks outwards: some programs export
        rooms inside out. What looks outwards and is smaller is an object seen from outside. "as given"
        turns nothing, "turned" all.

    Warns
    -----
    UserWarning
        The mesh is so large or so small that its unit can hardly be the metre.

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
    extent = np.sort(np.ptp(items.mesh.bounds, axis=0))
    if not FEWEST <= extent[2] <= MOST:
        what = "millimetres or centimetres" if extent[2] > MOST else "another unit"
        warn_caller(
            f"the mesh is {extent[2]:.4g} across, and thresholds are in metres; if these are {what}, scale "
            "it: Mesh(mesh.vertices * 0.001, mesh.faces, mesh.vertex_colors) for millimetres"
        )
    towards = facing(items)
    is_outward = towards < -CLEAR
    is_room = extent[1] >= ROOM
    turns = orientation == "turned" or (orientation == "auto" and is_outward and is_room)
    if abs(towards) <= CLEAR:
        found = "open: its normals are taken as they are"
    elif not is_outward:
        found = "room, seen from inside"
    elif is_room:
        found = "room, inside out" + (": its normals are turned" if turns else "")
    else:
        found = "object, seen from outside"
    normals = -items.normals if turns else items.normals
    return dataclasses.replace(items, normals=normals, report={**items.report, "orientation": found})


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
