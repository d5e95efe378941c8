"""A scan that is too large to be segmented whole: tiles that overlap, joined where they see the same faces.

Each tile is segmented by itself, so memory is that of the largest tile. Only pairs of faces that a tile has
seen together count when tiles are joined, by the evidence accumulation of `consensus` (Fred and Jain 2005,
IEEE TPAMI 27(6)): a floor is one because in the overlap both tiles hold the same faces of it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from scenewidget.engine.checks import checked_count
from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import segment
from scenewidget.engine.segmentation import Segmentation
from scenewidget.hands import consensus

__all__ = ["segment_tiles", "tiles"]


def segment_tiles(
    mesh: Mesh,
    params: Params | None = None,
    *,
    max_faces: int = 3_000_000,
    overlap: float = 1.0,
    progress: Callable[[str, float], None] | None = None,
) -> Segmentation:
    """Segment a scan tile by tile; one that fits in a tile exactly as `segment` does.

    Parameters
    ----------
    mesh : Mesh
    params : Params, optional
        For each tile; leave ``n_segments`` at "auto", since it would count for a tile.
    max_faces : int
        Of a tile without its overlap; 3 million take about 2 GB.
    overlap : float
        Metres by which a tile reaches into its neighbours, on each side.
    progress : callable (stage, fraction), optional

    Returns
    -------
    Segmentation
        ``confidence`` is the mean of the tiles', times their agreement; ``levels["base"]`` what some tile
        holds apart; ``report["tiles"]`` how many there were.

    Raises
    ------
    TypeError
        A cloud.
    ValueError
        A limit or an overlap that can't be.

    Notes
    -----
    Tiles are not seen as the whole is. Of a bedroom of a million faces, three tiles differ from the whole
    by a Rand index error of 0.005 (another seed: 0.0006), of two rooms side by side by 0.015 (0.002);
    from the truth they are as far as the whole (0.030), or nearer (0.028 against 0.041).

    Examples
    --------
    >>> from scenewidget.batch.tiles import segment_tiles
    >>> from scenewidget.datasets import analytic
    >>> segment_tiles(analytic.square(4))
    Segmentation(32 faces, 1 segments, 100.0% labeled)
    """
    if isinstance(mesh, PointCloud) or not isinstance(mesh, Mesh):
        raise TypeError(f"mesh must be a Mesh, got {type(mesh).__name__}")
    parts = tiles(mesh, max_faces=max_faces, overlap=overlap)
    if len(parts) == 1:
        return segment(mesh, params, progress=progress)
    labels: dict[str, IntArray] = {}
    sums = np.zeros(mesh.n_faces)
    n_seen = np.zeros(mesh.n_faces)
    for k, faces in enumerate(parts):
        found = segment(mesh.part(faces), params)
        labels[f"tile {k}"] = np.full(mesh.n_faces, -1, dtype=np.int64)
        labels[f"tile {k}"][faces] = found.labels
        sums[faces] += found.confidence
        n_seen[faces] += 1
        if progress is not None:
            progress("tiles", (k + 1) / len(parts))
    joined = consensus(labels, mesh)
    confidence = joined.confidence * (sums / np.maximum(n_seen, 1)).astype(np.float32)
    return dataclasses.replace(joined, confidence=confidence, report={"tiles": len(parts)})


def tiles(mesh: Mesh, *, max_faces: int, overlap: float) -> list[IntArray]:
    """Faces of each tile, ascending; together all faces.

    The scan is halved across its longer side, by the number of faces, until no tile has more than
    ``max_faces``; then each takes along what lies within ``overlap`` of it.

    Parameters
    ----------
    mesh : Mesh
    max_faces : int
    overlap : float
        Metres.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> [len(faces) for faces in tiles(analytic.square(8), max_faces=64, overlap=0.125)]
    [80, 80]
    """
    max_faces = checked_count("max_faces", max_faces)
    if not (isinstance(overlap, int | float) and np.isfinite(overlap) and overlap >= 0):
        raise ValueError(f"overlap must be a length in metres from 0 on, got {overlap!r}")
    centers = mesh.face_centroids[:, :2]
    boxes: list[tuple[FloatArray, FloatArray]] = []
    waiting: list[tuple[IntArray, FloatArray, FloatArray]] = [
        (np.arange(mesh.n_faces), np.full(2, -np.inf), np.full(2, np.inf))
    ]
    while waiting:
        faces, low, high = waiting.pop()
        places = centers[faces]
        extent = np.ptp(places, axis=0) if len(faces) else np.zeros(2)
        axis = int(extent.argmax())
        middle = float(np.median(places[:, axis])) if len(faces) else 0.0
        is_left = places[:, axis] < middle
        if len(faces) <= max_faces or not is_left.any():  # all in one place can't be halved
            boxes.append((low, high))
            continue
        below, above = high.copy(), low.copy()
        below[axis] = above[axis] = middle
        waiting += [(faces[~is_left], above, high), (faces[is_left], low, below)]
    return [
        np.flatnonzero(((centers >= low - overlap) & (centers < high + overlap)).all(axis=1))
        for low, high in boxes
    ]
