"""Polygons cut into triangles, in the order of the file."""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray

__all__ = ["triangulated"]

MOST_CORNERS, MOST_EARS = 64, 20_000  # of polygons that aren't convex; larger and further ones keep their fan


def triangulated(vertices: FloatArray, corners: IntArray, counts: IntArray) -> tuple[IntArray, IntArray]:
    """Triangles of polygons, and the polygon of each.

    Convex polygons are cut into a fan around their first corner, others by cutting off ears. Polygons with
    fewer than three corners have no triangles.

    Parameters
    ----------
    vertices : (n_vertices, 3) float
    corners : (n_corners,) int
        Vertices of all polygons, one polygon after the other.
    counts : (n_polygons,) int
        Corners of each.

    Returns
    -------
    triangles : (n_triangles, 3) int
    polygon : (n_triangles,) int32
        Ascending.
    """
    starts = np.cumsum(counts) - counts
    n_triangles = np.maximum(counts - 2, 0)
    polygon = np.repeat(np.arange(len(counts), dtype=np.int32), n_triangles)
    step = np.arange(len(polygon)) - np.repeat(np.cumsum(n_triangles) - n_triangles, n_triangles)
    first = starts[polygon]
    triangles = np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1)
    is_cut = counts[polygon] > 3
    if is_cut.any():
        folded = _folded(vertices, triangles, polygon, is_cut)
        is_quad = counts[folded] == 4
        _turn_diagonals(corners, starts[folded[is_quad]], triangles, polygon, folded[is_quad])
        small = folded[~is_quad & (counts[folded] <= MOST_CORNERS)]
        for p in small[np.cumsum(counts[small]) <= MOST_EARS].tolist():
            ring = corners[starts[p] : starts[p] + counts[p]]
            at = int(np.searchsorted(polygon, p))
            triangles[at : at + len(ring) - 2] = ring[_ears(vertices[ring])]
    return triangles, polygon


def _folded(vertices: FloatArray, triangles: IntArray, polygon: IntArray, is_cut: BoolArray) -> IntArray:
    """Polygons whose fan turns back on itself: they aren't convex."""
    cut, home = triangles[is_cut], polygon[is_cut]
    a, b, c = (vertices[cut[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    start = np.flatnonzero(np.concatenate([[True], home[1:] != home[:-1]]))
    total = np.add.reduceat(normal, start, axis=0)
    against = (
        np.einsum("ij,ij->i", normal, np.repeat(total, np.diff(np.append(start, len(home))), axis=0)) < 0
    )
    return np.unique(home[against])


def _turn_diagonals(
    corners: IntArray, starts: IntArray, triangles: IntArray, polygon: IntArray, quads: IntArray
) -> None:
    """Cut these quads along their other diagonal."""
    at = np.searchsorted(polygon, quads)
    for row, order in enumerate(((1, 2, 3), (1, 3, 0))):
        triangles[at + row] = corners[starts[:, None] + np.array(order)]


def _ears(ring: FloatArray) -> IntArray:
    """(n - 2, 3) triangles of one polygon, by cutting off ears; O(n³), for the few that aren't convex."""
    ring = ring - ring.mean(axis=0)
    normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    across = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
    flat = np.stack([ring @ across, ring @ np.cross(normal, across)], axis=1)
    flat /= np.abs(flat).max(axis=0).clip(1e-300)
    left, out = list(range(len(ring))), []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(flat, left, k)), 0)
        out.append([left[k % len(left)] for k in (ear - 1, ear, ear + 1)])
        del left[ear]
    return np.array([*out, left])


def _is_ear(flat: FloatArray, left: list[int], k: int) -> bool:
    a, b, c = (flat[left[(k + step) % len(left)]] for step in (-1, 0, 1))
    if _turn(a, b, c) <= 0:
        return False
    others = [i for i in left if i not in (left[k - 1], left[k], left[(k + 1) % len(left)])]
    return not any(
        _turn(a, b, flat[i]) >= 0 and _turn(b, c, flat[i]) >= 0 and _turn(c, a, flat[i]) >= 0 for i in others
    )


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
