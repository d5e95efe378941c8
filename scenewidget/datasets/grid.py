"""A signed distance field on the nodes of a voxel grid, kept only near surfaces.

Blocks of 4 x 4 x 4 nodes are found from coarse to fine: a block whose centre is further from every surface
than its own half diagonal can't hold one. What remains costs memory and time in proportion to the surface,
not to the volume.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from skimage.measure import marching_cubes

from scenewidget.datasets.scene import Scene
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray

__all__ = ["Band", "extract_surface", "sample_scene"]

BLOCK = 4  # nodes along the side of a block
_COARSE = 4  # blocks along the side of a coarse block
_CHUNK = 1 << 15  # blocks evaluated at a time: 2 M nodes, 25 MB of coordinates


@dataclass(frozen=True, eq=False)
class Band:
    """Distances in the blocks near surfaces.

    Parameters
    ----------
    origin : (3,) float
        Room coordinates of node (0, 0, 0), metres.
    axes : (3, 3) float
        Columns are the steps between neighbouring nodes in room coordinates; their length is the voxel.
    shape : (int, int, int)
        Blocks along each axis.
    blocks : (n_blocks, 3) int32
        Index of each kept block.
    values : (n_blocks, 64) float32
        Signed distance at the nodes of each block, metres; nan where unknown.
    parts : (n_blocks, 64) int16
        Part of the scene that is nearest.
    """

    origin: FloatArray
    axes: FloatArray
    shape: tuple[int, int, int]
    blocks: IntArray
    values: FloatArray
    parts: IntArray

    @property
    def voxel(self) -> float:
        """Distance of neighbouring nodes in metres."""
        return float(np.linalg.norm(self.axes[:, 0]))

    def with_values(self, values: FloatArray) -> Band:
        """The same blocks with other distances."""
        return replace(self, values=values)


def sample_scene(
    scene: Scene, *, low: FloatArray, high: FloatArray, voxel: float, turn: float, width: float
) -> Band:
    """Distances of a scene at all nodes within `width` metres of a surface (and some more).

    Parameters
    ----------
    low, high : (3,) float
        Box in room coordinates that the grid covers.
    voxel : float
        Metres.
    turn : float
        Radians between the axes of the room and those of the grid, about z.
    width : float
        Metres.
    """
    cos, sin = np.cos(turn), np.sin(turn)
    axes = voxel * np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    corners = np.array(
        [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
    steps = corners @ axes / voxel**2
    # voxels never fall on the planes z = 0 or z = height exactly
    start = np.floor(steps.min(axis=0)) + np.array([0.31, 0.17, 0.43])
    origin = axes @ start
    coarse_side = BLOCK * _COARSE
    n_coarse = np.ceil((steps.max(axis=0) - start) / coarse_side).astype(int)

    blocks = np.stack(np.meshgrid(*(np.arange(n) for n in n_coarse), indexing="ij"), axis=-1).reshape(-1, 3)
    near: list[IntArray] = [np.arange(len(blocks))] * len(scene.parts)
    blocks, near = _keep_near(scene, origin, axes, blocks, near, coarse_side, width)
    children = np.stack(np.meshgrid(*[np.arange(_COARSE)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    fine = (blocks[:, None] * _COARSE + children).reshape(-1, 3)
    near = [(rows[:, None] * len(children) + np.arange(len(children))).ravel() for rows in near]
    blocks, near = _keep_near(scene, origin, axes, fine, near, BLOCK, width)

    values = np.full((len(blocks), BLOCK**3), np.inf, dtype=np.float32)
    parts = np.zeros((len(blocks), BLOCK**3), dtype=np.int16)
    nodes = np.stack(np.meshgrid(*[np.arange(BLOCK)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for i, (part, rows) in enumerate(zip(scene.parts, near, strict=True)):
        for first in range(0, len(rows), _CHUNK):
            chunk = rows[first : first + _CHUNK]
            index = (blocks[chunk][:, None] * BLOCK + nodes).reshape(-1, 3)
            points = (origin[:, None] + axes @ index.T).astype(np.float32)
            found = part.shape.distance(points).astype(np.float32).reshape(-1, BLOCK**3)
            known, owner = values[chunk], parts[chunk]
            closer = found < known
            values[chunk] = np.where(closer, found, known)
            parts[chunk] = np.where(closer, np.int16(i), owner)
    n_x, n_y, n_z = (n_coarse * _COARSE).tolist()
    return Band(origin, axes, (n_x, n_y, n_z), blocks.astype(np.int32), values, parts)


def _keep_near(
    scene: Scene,
    origin: FloatArray,
    axes: FloatArray,
    blocks: IntArray,
    near: list[IntArray],
    side: int,
    width: float,
) -> tuple[IntArray, list[IntArray]]:
    """Blocks of `side` nodes that may hold a surface, and for each part the rows of those it may reach."""
    reach = (side - 1) * float(np.linalg.norm(axes[:, 0])) * np.sqrt(3) / 2 + width
    nearest = np.full(len(blocks), np.inf, dtype=np.float32)
    for i, (part, rows) in enumerate(zip(scene.parts, near, strict=True)):
        points = origin[:, None] + axes @ (blocks[rows].T * side + (side - 1) / 2)
        inside = ((points >= scene.low[i][:, None] - reach) & (points <= scene.high[i][:, None] + reach)).all(
            axis=0
        )
        rows = rows[inside]
        found = part.shape.distance(points[:, inside].astype(np.float32)).astype(np.float32)
        np.minimum.at(nearest, rows, found)
        near[i] = rows[found <= 1.15 * reach]  # 15 % for what is a distance only to first order
    is_kept = np.abs(nearest) <= 1.15 * reach
    new_row = np.cumsum(is_kept) - 1
    return blocks[is_kept], [new_row[rows[is_kept[rows]]] for rows in near]


def extract_surface(band: Band) -> tuple[FloatArray, IntArray]:
    """Zero level of a band by marching cubes (Lewiner et al. 2003, Journal of Graphics Tools 8(2)).

    Cells with an unknown corner stay empty, which leaves a ragged border around what was not seen.

    Returns
    -------
    vertices : (n_vertices, 3) float64
        Grid coordinates in metres: x and y along the axes of the grid, from its origin.
    faces : (n_faces, 3) int32
        Normals point to positive distances: into free space.
    """
    size = tuple(BLOCK * n for n in band.shape)
    volume = np.full(size, 1, dtype=np.float32)
    is_known = np.zeros(size, dtype=bool)
    index = band.blocks.T * BLOCK
    values = np.where(np.abs(band.values) < 1e-3 * band.voxel, np.float32(1e-3 * band.voxel), band.values)
    for node in range(BLOCK**3):
        i, j, k = index + np.array(np.unravel_index(node, (BLOCK,) * 3))[:, None]
        known = ~np.isnan(values[:, node])
        volume[i[known], j[known], k[known]] = values[known, node]
        is_known[i[known], j[known], k[known]] = True
    is_cell = _cells(is_known)
    first = volume[is_cell]
    if first.size == 0 or first.min() >= 0 or volume.min() >= 0:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int32)
    vertices, faces, _, _ = marching_cubes(volume, 0.0, mask=is_cell, allow_degenerate=True)  # type: ignore[no-untyped-call]  # scikit-image is untyped
    return vertices.astype(np.float64) * band.voxel, faces.astype(np.int32)


def _cells(is_known: BoolArray) -> BoolArray:
    """Cells whose eight corners are known, stored at the corner with the highest indices, as scikit-image
    reads it.
    """
    cell = np.zeros_like(is_known)
    inner = is_known[1:, 1:, 1:].copy()
    for i in (0, 1):
        for j in (0, 1):
            for k in (0, 1):
                n_x, n_y, n_z = is_known.shape
                inner &= is_known[i : n_x - 1 + i, j : n_y - 1 + j, k : n_z - 1 + k]
    cell[1:, 1:, 1:] = inner
    return cell
