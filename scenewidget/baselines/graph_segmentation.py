"""Felzenszwalb's segmentation of a mesh with Karpathy's weights.

Goes in: a mesh. Comes out: a segmentation, or one for each of several thresholds. Felzenszwalb and
Huttenlocher (2004), *Efficient graph-based image segmentation*, IJCV 59(2); weights of Karpathy, Miller
and Fei-Fei (2013), *Object discovery in 3D scenes via shape analysis*, ICRA. The segmentator of ScanNet
is the same on vertices with threshold .01 and pieces of 20.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from scenewidget.engine.felzenszwalb import join_light_edges
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh, face_adjacency, weld
from scenewidget.engine.moments import mean_normals
from scenewidget.engine.monitor import Monitor, Progress
from scenewidget.engine.segmentation import Segmentation

__all__ = ["THRESHOLDS", "Convexity", "felzenszwalb", "karpathy_oversegmentations"]

Items = Literal["faces", "vertices"]
Convexity = Literal["outward", "inward", "ignored"]

# The thesis says that there were ten, the paper does not list them; the authors' program went from 0.7
# to 5. Ours lie evenly between these in ratio.
THRESHOLDS = (0.7, 0.87, 1.08, 1.35, 1.68, 2.09, 2.6, 3.23, 4.02, 5.0)


def felzenszwalb(
    mesh: Mesh,
    threshold: float = 0.3,
    min_size: int = 500,
    *,
    items: Items = "faces",
    convexity: Convexity = "outward",
    progress: Progress | None = None,
    cancel: threading.Event | None = None,
) -> Segmentation:
    """Pieces whose normals change less inside than at their borders.

    Neighbours i and j weigh 1 − n_i·n_j, squared if the surface is convex between them: objects are
    mostly convex and touch along concave creases. Neighbours are joined in ascending order of weight
    while it is at most w + threshold / size for both pieces, w the heaviest edge inside; then pieces
    below `min_size` are joined to the neighbour behind their lightest edge.

    Parameters
    ----------
    mesh : Mesh
    threshold : float
        Larger gives larger pieces. Scans of a room with a million faces want 5 to 20 if the pieces
        shall be objects, .01 to .5 for an over-segmentation.
    min_size : int
        In items. Fragments that touch nothing stay, however small.
    items : "faces" | "vertices"
        What is joined. On vertices, as in the paper, a face gets the label of two of its corners, or if
        all three differ the middle one of the three.
    convexity : "outward" | "inward" | "ignored"
        Where normals point: out of the objects into free space, into the objects, or unknown, so that
        no edge is squared. The convexity of an edge is the sign of (p_j − p_i)·(n_j − n_i), which is
        that of the paper's (p_j − p_i)·n_j for two faces at an edge, and independent of who is i.
    progress : callable (stage: str, fraction: float), optional
    cancel : threading.Event, optional
        Checked between the steps, about half a second apart on a million faces.

    Returns
    -------
    Segmentation
        Every face labeled.

    Raises
    ------
    Cancelled
        The event was set.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import folded, square
    >>> mesh = folded(square(6), "x", 0.5, np.pi / 2)
    >>> sw.baselines.felzenszwalb(mesh, 0.5, min_size=10).n_segments
    2
    """
    check_options(mesh, min_size, convexity)
    _check_threshold("threshold", threshold)
    if items not in ("faces", "vertices"):
        raise ValueError(f"items must be 'faces' or 'vertices', got {items!r}")
    monitor = Monitor(progress, cancel)
    graph = mesh_graph(mesh, items, convexity, monitor)
    labels = segment_graph(graph, (threshold,), min_size, monitor)[0]
    return Segmentation.from_labels(mesh, labels if items == "faces" else face_labels(graph.faces, labels))


def karpathy_oversegmentations(
    mesh: Mesh,
    thresholds: Iterable[float] = THRESHOLDS,
    min_size: int = 500,
    *,
    convexity: Convexity = "outward",
    progress: Progress | None = None,
    cancel: threading.Event | None = None,
) -> dict[float, Segmentation]:
    """Segmentations whose pieces Karpathy et al. put in one bag: the thesis' row "[1] (Over-segmented)".

    Parameters
    ----------
    mesh : Mesh
    thresholds : iterable of float
        Ten by default; see `THRESHOLDS`.
    min_size, convexity, progress, cancel
        As for `felzenszwalb`, on vertices.

    Returns
    -------
    segmentations : dict of threshold to Segmentation
        Ready for `scenewidget.evaluate`; the thesis gives the mean and the standard deviation over them.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import folded, square
    >>> mesh = folded(square(6), "x", 0.5, np.pi / 2)
    >>> found = sw.baselines.karpathy_oversegmentations(mesh, (0.5, 100.0), min_size=10)
    >>> {threshold: segmentation.n_segments for threshold, segmentation in found.items()}
    {0.5: 2, 100.0: 1}
    """
    values = check_thresholds(thresholds)
    check_options(mesh, min_size, convexity)
    monitor = Monitor(progress, cancel)
    graph = mesh_graph(mesh, "vertices", convexity, monitor)
    return {
        threshold: Segmentation.from_labels(mesh, face_labels(graph.faces, labels))
        for threshold, labels in zip(values, segment_graph(graph, values, min_size, monitor))
    }


# --- the graph ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class MeshGraph:
    """Items of a mesh with the weights between neighbours.

    positions, normals : (n_items, 3) float64; pairs : (n_pairs, 2) int32; weights : (n_pairs,) float64;
    order : their ascending order; is_convex : (n_pairs,) bool; faces : (n_faces, 3) welded corners.
    """

    positions: FloatArray
    normals: FloatArray
    pairs: IntArray
    weights: FloatArray
    order: IntArray
    is_convex: BoolArray
    faces: IntArray


def mesh_graph(mesh: Mesh, items: Items, convexity: Convexity, monitor: Monitor) -> MeshGraph:
    """Faces and their adjacency, or vertices and the edges between them, weighted as by Karpathy et al."""
    monitor.start("graph")
    faces = weld(mesh)[mesh.faces]
    if items == "faces" or mesh.is_cloud:
        pairs, positions, normals = face_adjacency(mesh), mesh.face_centroids, mesh.face_normals
    else:
        pairs, positions, normals = _vertex_pairs(faces), mesh.vertices, vertex_normals(mesh, faces)
    monitor.tick(0.5)
    i, j = pairs[:, 0], pairs[:, 1]
    turned = np.einsum("ij,ij->i", positions[j] - positions[i], normals[j] - normals[i])
    is_convex = turned < 0 if convexity == "inward" else turned > 0
    weights = 1.0 - np.clip(np.einsum("ij,ij->i", normals[i], normals[j]), -1.0, 1.0)
    if convexity != "ignored":
        weights = np.where(is_convex, weights**2, weights)
    monitor.tick(0.8)
    order = np.argsort(weights, kind="stable")
    monitor.finish()
    return MeshGraph(positions, normals, pairs, weights, order, is_convex, faces)


def segment_graph(
    graph: MeshGraph, thresholds: tuple[float, ...], min_size: int, monitor: Monitor
) -> list[IntArray]:
    """(n_items,) labels for each threshold."""
    monitor.start("segment")
    found = []
    for k, threshold in enumerate(thresholds):
        monitor.tick(k / len(thresholds))
        labels = join_light_edges(
            len(graph.positions),
            graph.pairs,
            graph.weights,
            threshold=threshold,
            min_size=min_size,
            order=graph.order,
        )
        found.append(labels)
    monitor.finish()
    return found


def face_labels(faces: IntArray, labels: IntArray) -> IntArray:
    """(n_faces,) the label of at least two corners; the middle one if all three differ."""
    middle: IntArray = np.sort(labels[faces], axis=1)[:, 1]
    return middle


def vertex_normals(mesh: Mesh, faces: IntArray) -> FloatArray:
    """(n_vertices, 3) unit normals, means over the faces by area; zero where there is nothing to average."""
    return mean_normals(np.repeat(mesh.face_vectors, 3, axis=0), faces.ravel(), mesh.n_vertices)


def _vertex_pairs(faces: IntArray) -> IntArray:
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    n = int(faces.max()) + 1
    code = np.sort(sides[:, 0].astype(np.int64) * n + sides[:, 1])
    code = code[np.concatenate([[True], code[1:] != code[:-1]])]
    pairs = np.stack([code // n, code % n], axis=1).astype(np.int32)
    proper: IntArray = pairs[pairs[:, 0] != pairs[:, 1]]
    return proper


# --- checks ---------------------------------------------------------------------------------------


def check_options(mesh: Any, min_size: Any, convexity: str) -> None:
    """Refuse what is no mesh, no size or no rule."""
    if not isinstance(mesh, Mesh):
        raise TypeError(
            f"mesh must be a scenewidget.Mesh, got {type(mesh).__name__}; sw.load_mesh reads files"
        )
    if isinstance(min_size, bool) or not isinstance(min_size, (int, np.integer)):
        raise TypeError(f"min_size must be a whole number of items, got {type(min_size).__name__}")
    if min_size < 0:
        raise ValueError(f"min_size must be at least 0, got {min_size}")
    if convexity not in ("outward", "inward", "ignored"):
        raise ValueError(f"convexity must be 'outward', 'inward' or 'ignored', got {convexity!r}")


def check_thresholds(thresholds: Any) -> tuple[float, ...]:
    """Refuse thresholds that are none; return them as floats."""
    if isinstance(thresholds, str) or not isinstance(thresholds, Iterable):
        raise TypeError(f"thresholds must be numbers, such as (0.7, 1.5, 5.0), got {thresholds!r}")
    values = tuple(thresholds)
    if not values:
        raise ValueError("thresholds is empty: give at least one")
    for k, value in enumerate(values):
        _check_threshold(f"thresholds[{k}]", value)
    if len(set(values)) < len(values):
        raise ValueError(f"thresholds must all differ, got {values}")
    return tuple(float(value) for value in values)


def _check_threshold(name: str, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name} must be a number, got {type(value).__name__}")
    if not math.isfinite(value) or value < 0:
        raise ValueError(f"{name} must be finite and at least 0, got {value}")
