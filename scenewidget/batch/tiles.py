"""A scan that is too large to be segmented whole: tiles that overlap, joined where they see the same faces.

Each tile is segmented by itself, in the unit of the whole scan, so memory is that of the largest tile. Only
pairs of faces that a tile has seen together count when tiles are joined, by the evidence accumulation of
`consensus` (Fred and Jain 2005, IEEE TPAMI 27(6)): a floor is one because in the overlap both tiles hold the
same faces of it. Where a tile ends things are cut through and look otherwise than they are, so that a
tile has a vote on the nearest quarter of its overlap only.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from scenewidget.batch.clients import connected
from scenewidget.engine.checks import checked_count
from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import segment
from scenewidget.engine.scale import scene_scale
from scenewidget.engine.segmentation import Segmentation
from scenewidget.hands import consensus

__all__ = ["segment_tiles", "tiles"]

VOTING = 0.25  # of the overlap; farther out a tile is too near to where it is cut


def segment_tiles(
    mesh: Mesh,
    params: Params | None = None,
    *,
    max_faces: int = 3_000_000,
    overlap: float = 1.0,
    client: Any = None,
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
        Metres by which a tile reaches into its neighbours, on each side; it votes on the
        nearest quarter of them.
    client : distributed.Client, cluster or address, optional
        Where to segment the tiles, one a thread; by default here, one after the other. The result is the
        same.
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
    ConnectionError
        No scheduler answers.

    Notes
    -----
    Tiles are not seen as the whole is. Five simulated rooms of 230 000 to 280 000 faces, in two or three
    tiles, differ from the whole by a Rand index error of 0.0014 to 0.011, 0.0039 in the mean (another seed:
    0.0009 in the mean); from the truth they are 0.015 in the mean, the whole 0.017.

    Examples
    --------
    >>> from scenewidget.batch.tiles import segment_tiles
    >>> from scenewidget.datasets import analytic
    >>> segment_tiles(analytic.square(4))
    Segmentation(32 faces, 1 segments, 100.0% labeled)
    """
    if isinstance(mesh, PointCloud) or not isinstance(mesh, Mesh):
        raise TypeError(f"mesh must be a Mesh, got {type(mesh).__name__}")
    _check_overlap(overlap)
    boxes, centers = _boxes(mesh, max_faces), mesh.face_centroids[:, :2]
    if len(boxes) == 1:
        return segment(mesh, params, progress=progress)
    parts = [np.flatnonzero(_within(centers, box, overlap)) for box in boxes]
    params = params or Params()
    if params.scale == "auto":
        params = params.replace(scale=scene_scale(mesh))
    tasks = ((mesh.part(faces), params) for faces in parts)
    found: dict[int, tuple[IntArray, FloatArray]] = {}
    for k, result in _done(tasks, client):
        found[k] = result
        if progress is not None:
            progress("tiles", len(found) / len(parts))
    labels: dict[str, IntArray] = {}
    sums, n_votes = np.zeros(mesh.n_faces), np.zeros(mesh.n_faces)
    for k, box in enumerate(boxes):
        is_voting = _within(centers[parts[k]], box, overlap * VOTING)
        faces = parts[k][is_voting]
        labels[f"tile {k}"] = np.full(mesh.n_faces, -1, dtype=np.int64)
        labels[f"tile {k}"][faces] = found[k][0][is_voting]
        sums[faces] += found[k][1][is_voting]
        n_votes[faces] += 1
    joined = consensus(labels, mesh)
    confidence = joined.confidence * (sums / np.maximum(n_votes, 1)).astype(np.float32)
    return dataclasses.replace(joined, confidence=confidence, report={"tiles": len(parts)})


Tile = tuple[Mesh, Params]
Box = tuple[FloatArray, FloatArray]  # least and most x and y


def _done(tasks: Iterable[Tile], client: Any) -> Iterator[tuple[int, tuple[IntArray, FloatArray]]]:
    """Number, labels and confidence of each tile, as they come."""
    if client is None:
        yield from ((k, _segmented(*task)) for k, task in enumerate(tasks))
        return
    from distributed import as_completed

    with connected(client) as ours:
        as_they_come: Any = as_completed
        done, running = as_they_come(loop=ours.loop), dict[Any, int]()
        window = max(1, sum(ours.nthreads().values()))  # more tiles than that would only wait in memory
        for k, (part, params) in enumerate(tasks):
            if len(running) == window:
                future = next(done)
                yield running.pop(future), future.result()
            arrays = (part.vertices, part.faces, part.vertex_colors)
            future = ours.submit(_segmented_elsewhere, *arrays, params, pure=False)
            running[future] = k
            done.add(future)
        for future in done:
            yield running[future], future.result()


def _segmented_elsewhere(
    vertices: FloatArray, faces: IntArray, colors: Any, params: Params
) -> tuple[IntArray, FloatArray]:
    return _segmented(Mesh(vertices, faces, vertex_colors=colors), params)


def _segmented(mesh: Mesh, params: Params) -> tuple[IntArray, FloatArray]:
    found = segment(mesh, params)
    return found.labels, found.confidence


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
    _check_overlap(overlap)
    centers = mesh.face_centroids[:, :2]
    return [np.flatnonzero(_within(centers, box, overlap)) for box in _boxes(mesh, max_faces)]


def _check_overlap(overlap: float) -> None:
    if not (isinstance(overlap, int | float) and np.isfinite(overlap) and overlap >= 0):
        raise ValueError(f"overlap must be a length in metres from 0 on, got {overlap!r}")


def _boxes(mesh: Mesh, max_faces: int) -> list[Box]:
    """Of all tiles, without their overlap."""
    max_faces = checked_count("max_faces", max_faces)
    centers = mesh.face_centroids[:, :2]
    boxes: list[Box] = []
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
    return boxes


def _within(centers: FloatArray, box: Box, overlap: float) -> BoolArray:
    """(n,) which places lie in a box, or so near to it."""
    low, high = box
    return np.asarray(((centers >= low - overlap) & (centers < high + overlap)).all(axis=1))
