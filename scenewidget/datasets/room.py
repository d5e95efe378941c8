"""Simulated scans of furnished rooms with exact truth.

A seed gives a room (`plan`, `layout`), its signed distance field is sampled near surfaces (`grid`), looked
at by a camera that walks about (`camera`), and what it saw is fused and turned into triangles (`fusion`).
Real scans are unseen in places, ragged, noisy, askew and full of fragments; so are these, as much as the
options say.
"""

from __future__ import annotations

import math
import warnings
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from scipy import sparse

from scenewidget.datasets import camera, fusion, grid
from scenewidget.datasets.coloring import scan_colors
from scenewidget.datasets.layout import STYLES, furnish
from scenewidget.datasets.plan import Plan, room_plan
from scenewidget.datasets.scene import Scene
from scenewidget.datasets.shapes import ripples
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation

__all__ = ["SCANNERS", "build_room", "simulate_room"]

SCANNERS: MappingProxyType[str, MappingProxyType[str, Any]] = MappingProxyType(
    {
        "clean": MappingProxyType(
            {
                "noise": 0.0,
                "unseen": 0.0,
                "misregistration": 0.0,
                "warp": 0.0,
                "relief": 0.0,
                "smoothing": 0.0,
            }
        ),
        "depth camera": MappingProxyType(
            {"noise": 0.003, "unseen": 0.4, "misregistration": 0.004, "warp": 0.01}
        ),
        "hasty": MappingProxyType({"noise": 0.005, "unseen": 0.6, "misregistration": 0.009, "warp": 0.03}),
        "lidar": MappingProxyType(
            {
                "noise": 0.003,
                "unseen": 0.2,
                "misregistration": 0.008,
                "warp": 0.03,
                "smoothing": 0.04,
                "relief": 0.006,
            }
        ),
    }
)
"""Options of `simulate_room` that imitate kinds of scans.

======================  =================================================================================
``"clean"``             no scan at all: every surface, exact, walls plane; like a CAD export
``"depth camera"``      the defaults: a careful walk with a structured-light camera
``"hasty"``             few views, strong noise, drift: thousands of fragments, large holes
``"lidar"``             telephone with LiDAR: more complete, but edges melted and walls bent
======================  =================================================================================
"""

_MARGIN = 0.22  # metres that the grid reaches beyond the walls: recesses of windows
_MOST_NODES = 400_000_000  # of the dense grid in marching cubes: 2 GB


def simulate_room(
    *,
    seed: int = 0,
    n_objects: int = 12,
    voxel: float = 0.02,
    noise: float = 0.003,
    unseen: float = 0.4,
    misregistration: float = 0.004,
    warp: float = 0.01,
    relief: float = 0.004,
    smoothing: float = 0.0,
    clutter: int = 8,
    style: Literal["living", "bedroom", "dining", "study"] | None = None,
    shape: Literal["rectangle", "L"] | None = None,
    size: tuple[float, float, float] | None = None,
    inside_out: bool = False,
) -> tuple[Mesh, Segmentation]:
    """A scan of a furnished room, and its truth.

    The room depends on `seed`, `n_objects`, `clutter`, `style`, `shape`, `size` and `relief` only: other
    options scan the same room differently. Results don't depend on the number of threads.
    ``simulate_room(**SCANNERS["clean"])`` gives the bare geometry, other entries of `SCANNERS` other kinds
    of scans.

    Parameters
    ----------
    seed : int
        Of room and scan.
    n_objects : int
        Furnishings: what stands, hangs or lies as furniture, lamps, pictures, carpets, curtains, radiators.
        Doors, windows, walls, floor and ceiling come on top. If there is no place for all of them, a warning
        says so.
    voxel : float
        Side of a voxel in metres. The number of faces is about 2.5 x area / voxel²: for the default room
        300 000 at 0.029, 650 000 at 0.02, 1.5 million at 0.0137, in 3, 5 and 9 s.
    noise : float
        Standard deviation of the scanned surface about the true one, in metres, 2 m from the cameras; grows
        with distance and slant, correlated over neighbouring points.
    unseen : float
        How little the walk shows, 0 to 1: 1 stands still once, 0.4 makes 6 stops; 0 shows every surface, also
        those that no camera could see.
    misregistration : float
        By how much the tracker mistakes the position of each image, metres: doubled edges, seams, steps.
    warp : float
        Size in metres of a smooth deformation of the whole scan, as an unclosed loop leaves.
    relief : float
        Unevenness of walls (ceiling and floor a little less), metres: bulges a metre wide, plaster a hand
        wide.
    smoothing : float
        Distance in metres over which edges melt, as in scans from telephones.
    clutter : int
        Small things on furniture and floor: books, boxes, vases, bags, clothes.
    style : {"living", "bedroom", "dining", "study"}, optional
        Kind of room; chosen by the seed unless given.
    shape : {"rectangle", "L"}, optional
        Outline of the floor; chosen by the seed unless given.
    size : (width, depth, height), optional
        Of the box around the room, metres; grows with `n_objects` unless given.
    inside_out : bool
        Whether normals point out of the room instead of into it, as some programs export them.

    Returns
    -------
    mesh : Mesh
        z up, the floor near z = 0, walls not parallel to the axes, with vertex colours.
    truth : Segmentation
        One segment a thing: each wall, the floor, the ceiling, each door (leaf, frame and handles), each
        window, each piece of furniture with what belongs to it (cushions to the sofa, duvet to the bed,
        books to the shelf), each picture, lamp, curtain, small thing. A face belongs to the thing whose
        surface is nearest to its centroid before `warp`; things that no face shows are left out.

    Warns
    -----
    UserWarning
        Not all objects found a place.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh, truth = sw.datasets.simulate_room(n_objects=1, voxel=0.1, clutter=0)  # a coarse one
    >>> "floor" in truth.names
    True
    """
    _check_counts(seed=seed, n_objects=n_objects, clutter=clutter)
    for name, value, low, high in (
        ("voxel", voxel, 0.004, 0.15),
        ("noise", noise, 0.0, 0.05),
        ("unseen", unseen, 0.0, 1.0),
        ("misregistration", misregistration, 0.0, 0.1),
        ("warp", warp, 0.0, 0.3),
        ("relief", relief, 0.0, 0.05),
        ("smoothing", smoothing, 0.0, 0.2),
    ):
        _check_number(name, value, low, high)
    _check_choice("style", style, tuple(STYLES))
    _check_choice("shape", shape, ("rectangle", "L"))
    size = _checked_size(size)
    if not isinstance(inside_out, (bool, np.bool_)):
        raise TypeError(f"inside_out must be True or False, got {inside_out!r}")

    plan, scene, turn, n_placed = build_room(
        seed=seed, n_objects=n_objects, clutter=clutter, style=style, shape=shape, size=size, relief=relief
    )
    _check_memory(plan, voxel)
    if n_placed < n_objects:
        warnings.warn(
            f"only {n_placed} of n_objects={n_objects} found a place in a room of {plan.size[0]:.1f} x "
            f"{plan.size[1]:.1f} m; a larger size=(width, depth, height) holds more",
            stacklevel=2,
        )
    scan_rng = np.random.default_rng(np.random.SeedSequence(seed).spawn(3)[2])
    band, vertices, faces = _scan(
        plan, scene, scan_rng, turn, voxel=voxel, noise=noise, unseen=unseen, misregistration=misregistration
    )
    if smoothing > 0:
        vertices = _smoothed(vertices, faces, smoothing, voxel)
    points = _to_room(band, vertices)
    corners = points[faces]
    part = scene.nearest(corners.mean(axis=1).T)[1]
    vertex_part = np.zeros(len(points), dtype=np.int32)
    vertex_part[faces.ravel()] = np.repeat(part, 3)
    color_rng, warp_rng = scan_rng.spawn(2)
    colors = scan_colors(scene, points, _vertex_normals(points, faces), vertex_part, color_rng)
    world = points @ (band.axes / band.voxel)
    if warp > 0:
        world = world + warp * _warp(world, warp_rng)
    mesh = Mesh(world, faces[:, ::-1] if inside_out else faces, colors)
    return mesh, Segmentation.from_labels(mesh, scene.part_thing[part], names=scene.names)


def build_room(
    *,
    seed: int,
    n_objects: int,
    clutter: int,
    style: str | None,
    shape: str | None,
    size: tuple[float, float, float] | None,
    relief: float,
) -> tuple[Plan, Scene, float, int]:
    """The room behind a scan, options as in `simulate_room`.

    Returns
    -------
    plan : Plan
    scene : Scene
        Exact distances in room coordinates.
    turn : float
        Radians from the axes of the scan to those of the room, about z.
    n_placed : int
        Furnishings that found a place.
    """
    plan_rng, furnish_rng, _ = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(3))
    own_style, own_shape = str(plan_rng.choice(list(STYLES))), "L" if plan_rng.random() < 0.3 else "rectangle"
    turn = float(plan_rng.uniform(-0.25, 0.25))
    plan = room_plan(plan_rng, shape=shape or own_shape, size=size, n_objects=n_objects)
    scene, n_placed = furnish(
        plan, furnish_rng, style=style or own_style, n_objects=n_objects, clutter=clutter, relief=relief
    )
    return plan, scene, turn, n_placed


def _scan(
    plan: Plan,
    scene: Scene,
    rng: np.random.Generator,
    turn: float,
    *,
    voxel: float,
    noise: float,
    unseen: float,
    misregistration: float,
) -> tuple[grid.Band, FloatArray, IntArray]:
    """Vertices in grid coordinates and faces, after fusion of a walk or, if nothing disturbs it, of the true
    field.
    """
    walk_rng, sensor_rng, tracker_rng = rng.spawn(3)
    width = max(3 * voxel, 2 * voxel + 3 * noise + 2 * misregistration)
    low, high = np.full(3, -_MARGIN), np.array(plan.size) + _MARGIN
    band = grid.sample_scene(scene, low=low, high=high, voxel=voxel, turn=turn, width=width)
    vertices, faces = grid.extract_surface(band)
    if noise == unseen == misregistration == 0:
        return band, vertices, faces
    points = _to_room(band, vertices)
    n_stops = max(1, round(1 + 10 * (1 - unseen) ** 1.3))
    walk = camera.walk_through(plan, scene, walk_rng, n_stops)
    depth, face = camera.render(points, faces, walk)
    normals = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
    dropout = np.array([material.dropout for material in scene.materials])
    face_dropout = dropout[_parts_at(band, vertices[faces[:, 0]])]
    depth, slant = camera.sense(depth, face, normals, face_dropout, walk, sensor_rng, noise=noise)
    believed = walk.misplaced(tracker_rng, misregistration)
    fused = fusion.fuse(band, depth, slant, believed, truncation=width, fill=unseen == 0)
    return band, *grid.extract_surface(fused)


def _parts_at(band: grid.Band, vertices: FloatArray) -> IntArray:
    """Nearest part as the nearest node of the grid knows it."""
    lookup = np.zeros(band.shape, dtype=np.int32)
    lookup[tuple(band.blocks.T)] = np.arange(len(band.blocks))
    node = np.round(vertices / band.voxel).astype(int)
    row = lookup[tuple((node // grid.BLOCK).T)]
    parts: IntArray = band.parts[row, np.ravel_multi_index(tuple((node % grid.BLOCK).T), (grid.BLOCK,) * 3)]
    return parts


def _to_room(band: grid.Band, vertices: FloatArray) -> FloatArray:
    room: FloatArray = band.origin + vertices @ (band.axes / band.voxel).T
    return room


def _smoothed(vertices: FloatArray, faces: IntArray, distance: float, voxel: float) -> FloatArray:
    """Vertices drawn halfway to the mean of their neighbours until a bump has spread by about `distance`."""
    n = len(vertices)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    links = sparse.coo_matrix(
        (np.ones(2 * len(start)), (np.r_[start, end], np.r_[end, start])), shape=(n, n)
    ).tocsr()
    links.data[:] = 1
    mean = sparse.diags(1 / np.maximum(np.diff(links.indptr), 1)) @ links
    is_used = np.diff(links.indptr) > 0
    for _ in range(max(1, round(2 * (distance / voxel) ** 2))):
        vertices = np.where(is_used[:, None], 0.5 * (vertices + mean @ vertices), vertices)
    return vertices


def _vertex_normals(points: FloatArray, faces: IntArray) -> FloatArray:
    a, b, c = (points[faces[:, i]] for i in range(3))
    weighted = np.cross(b - a, c - a)
    total = np.stack(
        [np.bincount(faces.ravel(), np.repeat(weighted[:, i], 3), minlength=len(points)) for i in range(3)],
        axis=1,
    )
    normals: FloatArray = total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-20)
    return normals


def _warp(points: FloatArray, rng: np.random.Generator) -> FloatArray:
    """A smooth vector field of rms about 1, its waves some 4 m long."""
    columns = points.T.astype(np.float32)
    result: FloatArray = np.stack([ripples(rng, 4.0, 5)(columns) for _ in range(3)], axis=1) / np.sqrt(3)
    return result


# --- checks ---------------------------------------------------------------------------------------


def _check_counts(**counts: Any) -> None:
    for name, value in counts.items():
        if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
            raise TypeError(f"{name} must be a whole number, got {value!r}")
        if value < 0 or (name != "seed" and value > 200):
            raise ValueError(
                f"{name} must be {'at least 0' if name == 'seed' else 'from 0 to 200'}, got {value}"
            )


def _check_number(name: str, value: Any, low: float, high: float) -> None:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name} must be a number, got {value!r}")
    if not (low <= value <= high):
        unit = "" if name == "unseen" else " metres"
        hint = f"; in millimetres? use {value / 1000:g}" if unit and high < value <= 1000 * high else ""
        raise ValueError(f"{name} must be from {low:g} to {high:g}{unit}, got {value!r}{hint}")


def _check_choice(name: str, value: Any, options: tuple[str, ...]) -> None:
    if value is not None and value not in options:
        raise ValueError(
            f"{name} must be one of {', '.join(map(repr, options))} or None for any, got {value!r}"
        )


def _checked_size(size: Any) -> tuple[float, float, float] | None:
    if size is None:
        return None
    try:
        numbers = tuple(float(side) for side in size)
    except (TypeError, ValueError):
        raise TypeError(f"size must be (width, depth, height) in metres, got {size!r}") from None
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ValueError(f"size must be (width, depth, height) in metres, got {size!r}")
    width, depth, height = numbers
    if not (1.8 <= width <= 30 and 1.8 <= depth <= 30 and 2.0 <= height <= 6):
        raise ValueError(f"size must be from 1.8 to 30 m wide and deep and from 2 to 6 m high, got {size!r}")
    return width, depth, height


def _check_memory(plan: Plan, voxel: float) -> None:
    n_nodes = float(np.prod([(1.25 * side + 2 * _MARGIN) / voxel for side in plan.size]))
    if n_nodes > _MOST_NODES:
        possible = 1.01 * voxel * (n_nodes / _MOST_NODES) ** (1 / 3)
        raise ValueError(
            f"voxel={voxel:g} would take a grid of {n_nodes / 1e6:.0f} million nodes for a room of "
            f"{plan.size[0]:.1f} x {plan.size[1]:.1f} x {plan.size[2]:.1f} m, at most "
            f"{_MOST_NODES / 1e6:.0f} million are possible; use voxel={possible:.3f} or a smaller size"
        )
