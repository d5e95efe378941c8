"""Depth images as a hand-held depth camera would take them on a walk through the room.

Poses along a path, clean depth by rasterising the noise-free surface, and a sensor: noise that grows with
distance and slant, blurred outlines, readings that get lost on glass, dark or slanted surfaces. After
Khoshelham and Oude Elberink (2012), Sensors 12, and Nguyen, Izadi and Lovell (2012), 3DIMPVT, for the Kinect.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from scipy import ndimage, special

from scenewidget.datasets.plan import Plan
from scenewidget.datasets.scene import Scene
from scenewidget.datasets.shapes import ripples
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["FOCAL", "IMAGE", "Walk", "render", "sense", "walk_through"]

IMAGE = (240, 320)  # rows, columns
FOCAL = 225.0  # pixels: 71 degrees wide, 56 high
_NEAREST = 0.35  # metres; closer surfaces give no reading
_VIEWS = 7  # images at each stop
_WILD = (
    0.004  # share of readings that are wildly wrong, at 1 m: they leave fragments behind and before surfaces
)
_GAIN = 1.0  # noise of one reading in units of the noise that is left when all readings of a place are fused


@dataclass(frozen=True, eq=False)
class Walk:
    """Camera poses.

    Parameters
    ----------
    positions : (n_frames, 3) float64
        Room coordinates, metres.
    rotations : (n_frames, 3, 3) float64
        Rows: the camera's right, down and forward in room coordinates.
    """

    positions: FloatArray
    rotations: FloatArray

    def misplaced(self, rng: np.random.Generator, amount: float) -> Walk:
        """The poses as a tracker believes them: off by about `amount` metres, drifting along the walk."""
        n = len(self.positions)
        jump = np.repeat(rng.normal(0, 0.8, (-(-n // _VIEWS), 6)), _VIEWS, axis=0)[:n] + rng.normal(
            0, 0.5, (n, 6)
        )
        shift, angle = amount * jump[:, :3], amount / 2.5 * jump[:, 3:]
        skew = np.zeros((n, 3, 3))
        for (i, j), column in {(0, 1): 2, (0, 2): 1, (1, 2): 0}.items():
            skew[:, i, j], skew[:, j, i] = -angle[:, column], angle[:, column]
        u, _, v = np.linalg.svd(self.rotations + self.rotations @ skew)
        return Walk(self.positions + shift, u @ v)


def walk_through(plan: Plan, scene: Scene, rng: np.random.Generator, n_stops: int) -> Walk:
    """Stops at free places, spread over the room; at each the camera turns round, looking up and down by
    turns.
    """
    width, depth, height = plan.size
    candidates = rng.uniform([0, 0, 0.5 * height], [width, depth, 0.68 * height], (600, 3))
    is_inside = np.array([plan.contains(x, y, 0.45) for x, y, _ in candidates])
    free = scene.nearest(candidates.T, reach=0.4)[0]
    candidates = (
        candidates[is_inside]
        if (is_inside & (free > 0.3)).sum() < 10
        else candidates[is_inside & (free > 0.3)]
    )
    if len(candidates) == 0:
        candidates = np.array([[0.4 * width, 0.4 * depth, 0.6 * height]])
    stops = [candidates[0]]
    for _ in range(n_stops - 1):  # the next stop is the most remote of a few: spread, yet not on a lattice
        some = candidates[rng.integers(len(candidates), size=8)]
        gaps = np.linalg.norm(some[:, None, :2] - np.array(stops)[None, :, :2], axis=2).min(axis=1)
        stops.append(some[int(np.argmax(gaps))])
    positions, rotations = [], []
    for stop in stops:
        start = rng.uniform(0, 2 * np.pi)
        for view in range(_VIEWS):
            yaw = start + 2 * np.pi * view / _VIEWS + rng.normal(0, 0.12)
            pitch = np.radians([-38, 8, -22, -8, -45, 28, -18][view] + rng.normal(0, 6))
            ahead = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
            right = np.array([np.sin(yaw), -np.cos(yaw), 0])
            positions.append(stop + rng.normal(0, [0.08, 0.08, 0.04]))
            rotations.append(np.stack([right, np.cross(ahead, right), ahead]))
    return Walk(np.array(positions), np.array(rotations))


def render(vertices: FloatArray, faces: IntArray, walk: Walk) -> tuple[FloatArray, IntArray]:
    """Clean depth images of a mesh.

    Parameters
    ----------
    vertices : (n_vertices, 3) float
        Room coordinates, metres.
    faces : (n_faces, 3) int32

    Returns
    -------
    depth : (n_frames, rows, columns) float32
        Metres along the optical axis, 0 where nothing is seen.
    face : (n_frames, rows, columns) int32
        The face seen, -1 where there is none.
    """
    n = len(walk.positions)
    depth = np.zeros((n, *IMAGE), dtype=np.float32)
    face = np.full((n, *IMAGE), -1, dtype=np.int32)
    rotations = walk.rotations.astype(np.float32)
    shifts = -np.einsum("nij,nj->ni", walk.rotations, walk.positions).astype(np.float32)
    _rasterise(vertices.astype(np.float32), faces, rotations, shifts, np.float32(FOCAL), depth, face)
    return depth, face


def sense(
    depth: FloatArray,
    face: IntArray,
    normals: FloatArray,
    dropout: FloatArray,
    walk: Walk,
    rng: np.random.Generator,
    *,
    noise: float,
) -> tuple[FloatArray, FloatArray]:
    """What a depth camera makes of clean depth images.

    Parameters
    ----------
    depth, face
        As `render` returns them.
    normals : (n_faces, 3) float
        Unit normals in room coordinates.
    dropout : (n_faces,) float
        Share of readings that a face swallows.
    noise : float
        Standard deviation, metres, that remains at 2 m once all images are fused; 0 for perfect readings.

    Returns
    -------
    measured : (n_frames, rows, columns) float32
        Depth in metres, 0 where there is no reading.
    slant : (n_frames, rows, columns) float32
        Cosine between ray and normal, for weights.
    """
    rows, columns = IMAGE
    v, u = np.meshgrid(
        np.arange(rows) - rows / 2 + 0.5, np.arange(columns) - columns / 2 + 0.5, indexing="ij"
    )
    rays = np.stack([u / FOCAL, v / FOCAL, np.ones_like(u)], axis=-1)
    units = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    patches = ripples(rng, 0.35)
    # neighbouring readings share their errors, at three scales
    speckle = _NoiseField(rng, {0.7: 0.55, 2.0: 0.65, 9.0: 0.5})
    jitter = _NoiseField(rng, {1.0: 1.0})
    losses = _NoiseField(rng, {0.0: 0.87, 3.0: 0.49})
    measured, slant = np.zeros_like(depth), np.zeros_like(depth)
    for n, frame_rng in enumerate(rng.spawn(len(depth))):
        z, seen = depth[n], face[n]
        normal = normals[seen] @ walk.rotations[n].T
        cosine = np.abs((normal * units).sum(axis=-1))
        if noise > 0:
            z, cosine = _blur_outlines(z, cosine, jitter, frame_rng)
        points = walk.positions[n][:, None] + walk.rotations[n].T @ (z[..., None] * rays).reshape(-1, 3).T
        place = patches(points.astype(np.float32)).reshape(IMAGE)
        chance = _loss(z, cosine, dropout[seen])
        # mostly the same places get lost in every image, so that holes remain
        is_lost = special.ndtr(0.7 * place + 0.71 * losses.window(frame_rng)) < chance
        keeps = (z > _NEAREST) & (depth[n] > 0) & ~is_lost
        if noise > 0:
            sigma = noise * _GAIN * (0.3 + 0.7 * (z / 2) ** 2) * (1 + 0.35 / np.maximum(cosine, 0.2))
            is_wild = frame_rng.random(IMAGE, dtype=np.float32) < _WILD * z**2
            z = z + sigma * speckle.window(frame_rng) * np.where(is_wild, 12, 1)
        measured[n] = np.where(keeps, z, 0)
        slant[n] = cosine
    return measured, slant


class _NoiseField:
    """A random image much larger than a frame, filtered once; every frame gets another window of it.

    Standard deviation 1, made of smooth noise of the given scales (pixels) and shares.
    """

    def __init__(self, rng: np.random.Generator, shares: dict[float, float]) -> None:
        size = (3 * IMAGE[0], 3 * IMAGE[1])
        total = np.zeros(size, dtype=np.float32)
        for scale, share in shares.items():
            white = rng.standard_normal(size, dtype=np.float32)
            blurred = ndimage.gaussian_filter(white, scale, mode="wrap") if scale > 0 else white
            total += share * blurred / blurred.std()
        self.field = total / total.std()

    def window(self, rng: np.random.Generator) -> FloatArray:
        """(rows, columns) part of the field at a random place."""
        i, j = rng.integers(2 * IMAGE[0]), rng.integers(2 * IMAGE[1])
        part: FloatArray = self.field[i : i + IMAGE[0], j : j + IMAGE[1]]
        return part


def _blur_outlines(
    depth: FloatArray, cosine: FloatArray, jitter: _NoiseField, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Readings of a pixel off, and at outlines sometimes between the near and the far surface: flying
    pixels.
    """
    rows, columns = np.meshgrid(*(np.arange(n) for n in IMAGE), indexing="ij")
    i = np.clip(np.round(rows + 0.8 * jitter.window(rng)), 0, IMAGE[0] - 1).astype(int)
    j = np.clip(np.round(columns + 0.8 * jitter.window(rng)), 0, IMAGE[1] - 1).astype(int)
    shifted = depth[i, j]
    share = rng.random(IMAGE, dtype=np.float32)
    mixed = np.where(share < 0.3, share / 0.3, 1)
    is_outline = (shifted > 0) & (depth > 0) & (np.abs(shifted - depth) > 0.05)
    # elsewhere a neighbour's depth differs by slant alone, which the noise already covers
    blurred = np.where(is_outline, mixed * shifted + (1 - mixed) * depth, depth)
    return blurred, np.where(is_outline, cosine[i, j], cosine)


def _loss(depth: FloatArray, cosine: FloatArray, dropout: FloatArray) -> FloatArray:
    """Chance that a reading does not come back: slanted, far away, or swallowed by the material."""
    grazing = np.clip((0.35 - cosine) / 0.3, 0, 1)
    far = np.clip((depth - 3.6) / 2.8, 0, 1)
    chance: FloatArray = 1 - 0.995 * (1 - dropout) * (1 - 0.97 * grazing) * (1 - far)
    return chance


@kernel(allocates=True, parallel=True)
def _rasterise(vertices, faces, rotations, shifts, focal, depth, face):  # type: ignore[no-untyped-def]
    """Depth buffer of every frame; frames are independent, so threads don't change the result."""
    n_frames, rows, columns = depth.shape
    for n in numba.prange(n_frames):
        r, t = rotations[n], shifts[n]
        seen = np.empty((len(vertices), 3), dtype=np.float32)
        for i in range(len(vertices)):
            x, y, z = vertices[i]
            d = r[2, 0] * x + r[2, 1] * y + r[2, 2] * z + t[2]
            seen[i, 2] = d
            if d > 0.05:
                scale = focal / d
                seen[i, 0] = (r[0, 0] * x + r[0, 1] * y + r[0, 2] * z + t[0]) * scale + columns / 2 - 0.5
                seen[i, 1] = (r[1, 0] * x + r[1, 1] * y + r[1, 2] * z + t[1]) * scale + rows / 2 - 0.5
        for f in range(len(faces)):
            a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
            za, zb, zc = seen[a, 2], seen[b, 2], seen[c, 2]
            if za <= 0.05 or zb <= 0.05 or zc <= 0.05:
                continue
            xa, xb, xc = seen[a, 0], seen[b, 0], seen[c, 0]
            left, right = np.ceil(min(xa, xb, xc)), np.floor(max(xa, xb, xc))
            if right < 0 or left > columns - 1 or left > right:
                continue
            ya, yb, yc = seen[a, 1], seen[b, 1], seen[c, 1]
            top, bottom = np.ceil(min(ya, yb, yc)), np.floor(max(ya, yb, yc))
            if bottom < 0 or top > rows - 1 or top > bottom:
                continue
            area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
            if area == 0:
                continue
            for v in range(max(int(top), 0), min(int(bottom), rows - 1) + 1):
                for u in range(max(int(left), 0), min(int(right), columns - 1) + 1):
                    wb = ((u - xa) * (yc - ya) - (xc - xa) * (v - ya)) / area
                    wc = ((xb - xa) * (v - ya) - (u - xa) * (yb - ya)) / area
                    wa = 1 - wb - wc
                    if wa < -1e-4 or wb < -1e-4 or wc < -1e-4:
                        continue
                    z = 1 / (wa / za + wb / zb + wc / zc)
                    if depth[n, v, u] == 0 or z < depth[n, v, u]:
                        depth[n, v, u] = z
                        face[n, v, u] = f
