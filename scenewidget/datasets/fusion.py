"""Depth images fused into one signed distance field, as scanning programs do it.

Each node near a surface takes the weighted mean of how far each image puts the surface in front of it.
Curless and Levoy (1996), SIGGRAPH; weights that fall off behind the surface after Bylow et al. (2013), RSS.
What no image has seen stays unknown; thin things and narrow gaps suffer as they do in real scans.
"""

from __future__ import annotations

import numba
import numpy as np

from scenewidget.datasets.camera import FOCAL, Walk
from scenewidget.datasets.grid import BLOCK, Band
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray

__all__ = ["fuse"]

_LEAST_EVIDENCE = 0.05  # a frontal reading from 4.5 m away; places seen worse than that stay empty


def fuse(
    band: Band, depth: FloatArray, slant: FloatArray, walk: Walk, *, truncation: float, fill: bool
) -> Band:
    """The band as the images see it.

    Parameters
    ----------
    band : Band
        Where to look; its own distances are used only to fill.
    depth, slant : (n_frames, rows, columns) float32
        Readings in metres (0 for none) and the cosine between ray and surface.
    walk : Walk
        Poses from which the images are believed to be taken.
    truncation : float
        Metres in front of a surface beyond which all distances count alike.
    fill : bool
        Whether unseen nodes get the true distance instead of nan.
    """
    rotations = walk.rotations @ band.axes
    shifts = np.einsum("nij,nj->ni", walk.rotations, band.origin - walk.positions)
    fused = np.empty_like(band.values)
    _integrate(
        band.blocks,
        rotations.astype(np.float32),
        shifts.astype(np.float32),
        np.ascontiguousarray(depth, dtype=np.float32),
        np.ascontiguousarray(slant, dtype=np.float32),
        np.float32(FOCAL),
        np.float32(truncation),
        np.float32(band.voxel),
        fused,
    )
    return band.with_values(np.where(np.isnan(fused), band.values, fused) if fill else fused)


@kernel(allocates=True, parallel=True)
def _integrate(blocks, rotations, shifts, depth, slant, focal, truncation, voxel, fused):  # type: ignore[no-untyped-def]
    """Mean of all readings at every node; a node belongs to one thread, so their number doesn't matter."""
    n_frames, rows, columns = depth.shape
    behind = min(2.6 * voxel, truncation)
    for block in numba.prange(len(blocks)):
        total = np.zeros(BLOCK**3, dtype=np.float32)
        weight = np.zeros(BLOCK**3, dtype=np.float32)
        evidence = np.zeros(BLOCK**3, dtype=np.float32)
        bi, bj, bk = blocks[block, 0] * BLOCK, blocks[block, 1] * BLOCK, blocks[block, 2] * BLOCK
        radius = 3 * voxel
        for n in range(n_frames):
            a, t = rotations[n], shifts[n]
            mi, mj, mk = bi + 1.5, bj + 1.5, bk + 1.5
            z = a[2, 0] * mi + a[2, 1] * mj + a[2, 2] * mk + t[2]
            if z < 0.3:
                continue
            x = a[0, 0] * mi + a[0, 1] * mj + a[0, 2] * mk + t[0]
            y = a[1, 0] * mi + a[1, 1] * mj + a[1, 2] * mk + t[1]
            if abs(x) - radius * 1.5 > z * columns / (2 * focal) or abs(y) - radius * 1.5 > z * rows / (
                2 * focal
            ):
                continue
            for node in range(BLOCK**3):
                i, j, k = bi + node // (BLOCK * BLOCK), bj + (node // BLOCK) % BLOCK, bk + node % BLOCK
                z = a[2, 0] * i + a[2, 1] * j + a[2, 2] * k + t[2]
                x = a[0, 0] * i + a[0, 1] * j + a[0, 2] * k + t[0]
                y = a[1, 0] * i + a[1, 1] * j + a[1, 2] * k + t[1]
                u = int(np.floor(x * focal / z + columns / 2))
                v = int(np.floor(y * focal / z + rows / 2))
                if u < 0 or v < 0 or u >= columns or v >= rows:
                    continue
                reading = depth[n, v, u]
                if reading <= 0:
                    continue
                cosine = max(slant[n, v, u], np.float32(0.15))
                s = (reading - z) * (cosine if abs(reading - z) < 2 * truncation else np.float32(1))
                if s < -behind:
                    continue
                w = cosine / (z * z)
                evidence[node] += w
                if s < -voxel:
                    w *= max((behind + s) / (behind - voxel), np.float32(0.02))
                total[node] += w * min(s, truncation)
                weight[node] += w
        for node in range(BLOCK**3):
            fused[block, node] = total[node] / weight[node] if evidence[node] > _LEAST_EVIDENCE else np.nan
