"""Colours as a scanner records them: patterns of the materials, light and shade, exposure that wanders."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from scenewidget.datasets.materials import Material
from scenewidget.datasets.scene import Scene
from scenewidget.datasets.shapes import ripples
from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["scan_colors"]

_SHADE_CELL = 0.12  # metres, grid on which openness is computed


def scan_colors(
    scene: Scene, points: FloatArray, normals: FloatArray, parts: IntArray, rng: np.random.Generator
) -> npt.NDArray[np.uint8]:
    """A colour for each vertex.

    Parameters
    ----------
    points, normals : (n_vertices, 3) float
        Room coordinates in metres, unit normals.
    parts : (n_vertices,) int
        Part of the scene that each vertex belongs to.

    Returns
    -------
    colors : (n_vertices, 3) uint8
    """
    columns = points.T.astype(np.float32)
    field, cloud = ripples(rng, 0.5), ripples(rng, 1.6)
    albedo = np.empty((len(points), 3), dtype=np.float32)
    order = np.argsort(parts, kind="stable")
    edges = np.searchsorted(parts[order], np.arange(len(scene.parts) + 1))
    for i, material in enumerate(scene.materials):
        rows = order[edges[i] : edges[i + 1]]
        if len(rows):
            mix = np.clip(_pattern(material, columns[:, rows], field), 0, 1)[:, None]
            albedo[rows] = (1 - mix) * np.array(material.color) + mix * np.array(material.accent)
    sun = np.array([0.35, -0.25, 0.9])
    facing = 0.78 + 0.22 * normals @ (sun / np.linalg.norm(sun))
    light = facing * (0.55 + 0.45 * _openness(scene, points, normals)) * (1 + 0.05 * cloud(columns))
    grain = rng.normal(0, 5, (len(points), 1)) + rng.normal(0, 2.5, (len(points), 3))
    tint = np.array([1.03, 1.0, 0.94])  # lamplight
    result: npt.NDArray[np.uint8] = np.clip(albedo * light[:, None] * tint + grain, 0, 255).astype(np.uint8)
    return result


def _pattern(material: Material, points: FloatArray, field: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """How much of the accent colour there is at each point, 0 to 1."""
    x, y, z = points / np.float32(material.scale)
    across, along = 2 * np.pi * (x + 0.6 * z), 2 * np.pi * (y + 0.6 * z)
    if material.pattern == "plain":
        return np.zeros(points.shape[1], dtype=np.float32)
    if material.pattern == "spots":
        return 0.5 + 0.35 * field(points / np.float32(2 * material.scale))
    if material.pattern == "print":
        return np.round(1 + 0.8 * field(points * np.float32(0.5 / material.scale))) / 2
    mix: FloatArray
    if material.pattern == "grain":
        mix = 0.5 + 0.5 * np.sin(2 * np.pi * (0.15 * x + y + z + 0.35 * field(points)))
    elif material.pattern == "planks":
        row = np.floor(y)
        is_joint = np.abs(y - row - 0.5) > 0.46
        mix = np.where(
            is_joint, 1, 0.7 * _scramble(row, np.floor(0.12 * x + 0.37 * row)) + 0.1 * field(points)
        )
    elif material.pattern == "weave":
        mix = 0.5 + 0.25 * np.sin(2 * across) * np.sin(2 * along) + 0.1 * field(points)
    elif material.pattern == "stripes":
        mix = (np.sin(across) > 0.2).astype(np.float32)
    elif material.pattern == "checks":
        mix = 0.5 * (np.sin(across) > 0) + 0.5 * (np.sin(along) > 0)
    else:  # books: each of another colour
        mix = _scramble(np.floor(x), np.floor(y))
    return mix


def _scramble(i: FloatArray, j: FloatArray) -> FloatArray:
    """A number from 0 to 1 for each pair of whole numbers, without visible order."""
    scrambled: FloatArray = np.modf(np.abs(np.sin(12.9898 * i + 78.233 * j)) * 437.585)[0]
    return scrambled


def _openness(scene: Scene, points: FloatArray, normals: FloatArray) -> FloatArray:
    """How far away the next surface is 15 to 40 cm in front of each point, 0 in a corner to 1 in the open."""
    low, high = points.min(axis=0) - 0.6, points.max(axis=0) + 0.6
    ticks = [np.arange(a, b, _SHADE_CELL) for a, b in zip(low, high, strict=True)]
    nodes = np.stack(np.meshgrid(*ticks, indexing="ij")).reshape(3, -1)
    distance = scene.nearest(nodes, reach=0.5)[0].reshape([len(t) for t in ticks])
    total = np.zeros(len(points))
    for step in (0.15, 0.4):
        at = ((points + step * normals - low) / _SHADE_CELL).T
        total += np.clip(ndimage.map_coordinates(distance, at, order=1, mode="nearest") / step, 0, 1)
    return total / 2
