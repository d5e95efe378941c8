"""Object discovery by shape, made a segmentation of the whole scene.

Goes in: a mesh. Comes out: a segmentation, row "[1] (Final)" of the thesis' tables. Karpathy, Miller and
Fei-Fei (2013), *Object discovery in 3D scenes via shape analysis*, ICRA: a bag of pieces from several
over-segmentations, five measures of objectness, and of pieces that nearly coincide only the best.
"""

from __future__ import annotations

import threading
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy import sparse

from scenewidget.baselines.graph_segmentation import (
    THRESHOLDS,
    Convexity,
    MeshGraph,
    check_options,
    check_thresholds,
    face_labels,
    mesh_graph,
    segment_graph,
)
from scenewidget.baselines.shape_measures import (
    compactness,
    global_convexity,
    local_convexity,
    mean_objectness,
    smoothness,
    symmetry,
    tangent_neighbours,
)
from scenewidget.engine.mesh import (
    BoolArray,
    FloatArray,
    IntArray,
    Mesh,
    connected_components,
    face_adjacency,
)
from scenewidget.engine.monitor import Monitor, Progress
from scenewidget.engine.segmentation import Segmentation, order_by_area

__all__ = ["karpathy"]

Reject = Literal["size", "thin", "flat"]
Background = Literal["one", "pieces", "unlabeled"]

REJECTS: tuple[Reject, ...] = ("size", "thin", "flat")
MAX_EXTENT, MIN_EXTENT = 1.0, 0.02  # metres
MIN_WIDTH, MIN_DEPTH = 0.05, 0.001  # second and third eigenvalue of the scatter over the first
N_SAMPLES = 400  # vertices of a piece on which symmetry, compactness and global convexity are taken


def karpathy(
    mesh: Mesh,
    thresholds: Iterable[float] = THRESHOLDS,
    min_size: int = 500,
    *,
    reject: Collection[Reject] = (),
    overlap: float = 0.5,
    n_objects: int | None = None,
    background: Background = "one",
    convexity: Convexity = "outward",
    progress: Progress | None = None,
    cancel: threading.Event | None = None,
) -> Segmentation:
    """The pieces of ten over-segmentations that look most like objects, over a background of what is left.

    The paper looks for objects and does not partition a scene; the thesis compares with it "with the hard
    thresholding step disabled". Our reading, step by step:

    1. `karpathy_oversegmentations` at each threshold, on vertices. All pieces of at least `min_size`
       vertices go in one bag; smaller ones are fragments that touch nothing.
    2. Hard thresholds, each switched on by its name in `reject`. "size": longer than 1 m or narrower
       than 2 cm along a principal axis. "thin", "flat": second eigenvalue of the scatter of the vertices
       below .05, third below .001 of the first. The paper has them all, under that heading; the thesis
       none.
    3. Objectness: the mean of five normalised measures, see `scenewidget.baselines.shape_measures`.
    4. Non-maximum suppression, the best first: a piece goes if its intersection with a better one that
       stays is more than `overlap` of their union, counted in vertices.
    5. The pieces left are painted from the lowest rank to the highest, so a better piece covers a worse
       one. What no piece covers is the background.

    Parameters
    ----------
    mesh : Mesh
    thresholds : iterable of float
    min_size : int
        Vertices.
    reject : collection of "size", "thin", "flat"
    overlap : float
        In [0, 1]; 1 suppresses nothing but copies.
    n_objects : int, optional
        Paint only so many of the best; all by default.
    background : "one" | "pieces" | "unlabeled"
        What is left is one segment, a segment for each connected piece, or unlabeled.
    convexity : "outward" | "inward" | "ignored"
        As for `felzenszwalb`; local convexity takes "ignored" for "outward".
    progress : callable (stage: str, fraction: float), optional
    cancel : threading.Event, optional
        Checked between pieces and between thresholds.

    Returns
    -------
    Segmentation
        ``report`` holds the number of pieces in the bag (``n_candidates``), those that were not rejected
        (``n_accepted``) and those that survived suppression (``n_objects``), and for each segment its
        objectness (``objectness``, nan for the background).

    Raises
    ------
    Cancelled
        The event was set.

    Notes
    -----
    Symmetry, compactness and global convexity are taken on a fixed random sample of 400 vertices a piece.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import folded, square
    >>> mesh = folded(square(6), "x", 0.5, np.pi / 2)
    >>> sw.baselines.karpathy(mesh, (0.5, 1.0), min_size=10).coverage
    1.0
    """
    values = check_thresholds(thresholds)
    check_options(mesh, min_size, convexity)
    _check_discovery(reject, overlap, n_objects, background)
    monitor = Monitor(progress, cancel)
    graph = mesh_graph(mesh, "vertices", convexity, monitor)
    layers = segment_graph(graph, values, min_size, monitor)
    bag = _fill_bag(graph, layers, min_size, mesh, monitor)
    shared = _overlaps(bag, monitor)
    keep = ~np.any([_rejected(bag, rule) for rule in reject], axis=0) if reject else np.ones(len(bag), bool)
    score = np.full(len(bag), np.nan)
    if keep.any():
        score[keep] = mean_objectness(_measure(bag, graph, shared, keep, monitor)[keep])
    ranking = _suppress(score, bag.shapes.n_members, shared, overlap)[:n_objects]
    labels = _paint(bag, ranking, graph.faces)
    n_painted = len(ranking)
    if background != "unlabeled":
        labels = _fill_background(mesh, labels, n_painted, background)
    dense, rank = order_by_area(labels, mesh.face_areas)
    scores = np.concatenate([score[ranking], np.full(max(int(labels.max()) + 1 - n_painted, 0), np.nan)])
    report = {
        "n_candidates": len(bag),
        "n_accepted": int(keep.sum()),
        "n_objects": n_painted,
        "objectness": scores[rank],
    }
    return Segmentation(mesh, dense, report=report)


# --- the bag --------------------------------------------------------------------------------------


class _Shapes(NamedTuple):
    """Size and shape of n pieces.

    n_members : (n,) vertices; area : (n,) square metres
    center : (n, 3) metres; axes : (n, 3, 3) principal axes of the vertices in columns, longest first
    spread : (n, 3) eigenvalues of their scatter over the first; extents : (n, 3) metres along the axes
    """

    n_members: IntArray
    area: FloatArray
    center: FloatArray
    axes: FloatArray
    spread: FloatArray
    extents: FloatArray


@dataclass(frozen=True, eq=False)
class _Bag:
    """Candidate pieces; those of one threshold don't overlap.

    layers : for each threshold the (n_vertices,) candidate of each vertex, -1 for none
    shapes : of all candidates
    samples : some vertices of each candidate
    """

    layers: list[IntArray]
    shapes: _Shapes
    samples: list[IntArray]

    def __len__(self) -> int:
        return len(self.samples)


def _fill_bag(graph: MeshGraph, layers: list[IntArray], min_size: int, mesh: Mesh, monitor: Monitor) -> _Bag:
    monitor.start("bag")
    n_vertices = len(graph.positions)
    corners = graph.faces.ravel()
    is_used = np.bincount(corners, minlength=n_vertices) > 0
    vertex_area = np.zeros(n_vertices)
    np.add.at(vertex_area, corners, np.repeat(mesh.face_areas / 3.0, 3))
    shuffled = np.random.default_rng(0).permutation(n_vertices)
    numbered: list[IntArray] = []
    shapes: list[_Shapes] = []
    samples: list[IntArray] = []
    for k, layer in enumerate(layers):
        monitor.tick(k / len(layers))
        size = np.bincount(layer[is_used], minlength=int(layer.max()) + 1)
        is_piece = size >= max(min_size, 1)
        number = np.where(is_piece, np.cumsum(is_piece) - 1, -1)
        piece = np.where(is_used, number[layer], -1)
        members = shuffled[piece[shuffled] >= 0]
        members = members[np.argsort(piece[members], kind="stable")]  # in each piece still shuffled
        start = np.cumsum(size[is_piece]) - size[is_piece]
        numbered.append(np.where(piece >= 0, piece + len(samples), -1))
        shapes.append(_shapes(graph.positions[members], vertex_area[members], start))
        samples += [part[:N_SAMPLES] for part in np.split(members, start[1:])] if len(start) else []
    monitor.finish()
    return _Bag(numbered, _Shapes(*(np.concatenate(column) for column in zip(*shapes))), samples)


def _shapes(points: FloatArray, areas: FloatArray, start: IntArray) -> _Shapes:
    """Shapes of pieces whose points stand one piece after the other, each from its start."""
    n_members = np.diff(np.append(start, len(points)))
    piece = np.repeat(np.arange(len(start)), n_members)
    center = np.add.reduceat(points, start) / n_members[:, None]
    offset = points - center[piece]
    scatter = np.add.reduceat(offset[:, :, None] * offset[:, None, :], start)
    values, vectors = np.linalg.eigh(scatter)
    values, axes = np.maximum(values[:, ::-1], 0.0), vectors[:, :, ::-1]
    along = np.einsum("ni,nij->nj", offset, axes[piece])
    extents = np.maximum.reduceat(along, start) - np.minimum.reduceat(along, start)
    spread = np.divide(values, values[:, :1], out=np.zeros_like(values), where=values[:, :1] > 0)
    return _Shapes(n_members, np.add.reduceat(areas, start), center, axes, spread, extents)


def _rejected(bag: _Bag, rule: Reject) -> BoolArray:
    shapes = bag.shapes
    too_much: BoolArray = {
        "size": (shapes.extents.max(axis=1) > MAX_EXTENT) | (shapes.extents.min(axis=1) < MIN_EXTENT),
        "thin": shapes.spread[:, 1] < MIN_WIDTH,
        "flat": shapes.spread[:, 2] < MIN_DEPTH,
    }[rule]
    return too_much


def _overlaps(bag: _Bag, monitor: Monitor) -> sparse.csr_array:
    """(n_candidates, n_candidates) intersection over union of pieces of different thresholds."""
    monitor.start("overlap")
    n = len(bag)
    total = sparse.csr_array((n, n))
    layer_pairs = list(combinations(bag.layers, 2))
    for k, (one, other) in enumerate(layer_pairs):
        monitor.tick(k / len(layer_pairs))
        both = (one >= 0) & (other >= 0)
        ones = np.ones(int(both.sum()))
        total = total + sparse.coo_array((ones, (one[both], other[both])), shape=(n, n)).tocsr()
    cells = (total + total.T).tocoo()
    n_members = bag.shapes.n_members
    union = n_members[cells.row] + n_members[cells.col] - cells.data
    monitor.finish()
    return sparse.csr_array((cells.data / union, (cells.row, cells.col)), shape=(n, n))


def _measure(
    bag: _Bag, graph: MeshGraph, shared: sparse.csr_array, keep: BoolArray, monitor: Monitor
) -> FloatArray:
    """(n_candidates, 5) measures; rows that are not to be kept stay 0."""
    monitor.start("measure")
    n = len(bag)
    measures = np.zeros((n, 5))
    neighbours = monitor.call(tangent_neighbours, graph.positions, graph.normals, graph.pairs)
    for k, layer in enumerate(bag.layers):
        monitor.tick(0.1 + 0.4 * k / len(bag.layers))
        measures[:, 0] += local_convexity(layer, n, graph.pairs, graph.is_convex)
        measures[:, 1] += smoothness(layer, n, neighbours)
    for k in np.flatnonzero(keep).tolist():
        monitor.tick(0.5 + 0.5 * k / n)
        row = slice(shared.indptr[k], shared.indptr[k + 1])
        copies = shared.indices[row][(shared.data[row] == 1.0) & (shared.indices[row] < k)]
        copies = copies[keep[copies]]
        if len(copies):  # the same vertices at a lower threshold
            measures[k, 2:] = measures[copies[0], 2:]
            continue
        axes, sample = bag.shapes.axes[k], bag.samples[k]
        points = (graph.positions[sample] - bag.shapes.center[k]) @ axes
        normals = graph.normals[sample] @ axes
        measures[k, 2:] = (
            compactness(float(bag.shapes.area[k]), points),
            symmetry(points, normals),
            global_convexity(points),
        )
    monitor.finish()
    return measures


def _suppress(score: FloatArray, size: IntArray, shared: sparse.csr_array, overlap: float) -> IntArray:
    """Candidates that stay, best first; ties go to the larger, then to the lower threshold."""
    order = np.lexsort((np.arange(len(score)), -size, -score))
    order = order[~np.isnan(score[order])]
    is_open = np.ones(len(score), dtype=bool)
    ranking = []
    for k in order:
        if not is_open[k]:
            continue
        ranking.append(k)
        row = slice(shared.indptr[k], shared.indptr[k + 1])
        is_open[shared.indices[row][(shared.data[row] > overlap) | (shared.data[row] == 1.0)]] = False
    return np.array(ranking, dtype=np.int64)


def _paint(bag: _Bag, ranking: IntArray, faces: IntArray) -> IntArray:
    """(n_faces,) rank of the best piece over each face, -1 for none."""
    worst = len(ranking)
    rank = np.full(len(bag) + 1, worst)  # the last is for candidate -1, no piece
    rank[ranking] = np.arange(worst)
    best = np.full(len(bag.layers[0]), worst)
    for layer in bag.layers:
        best = np.minimum(best, rank[layer])
    labels = face_labels(faces, best)
    return np.where(labels == worst, -1, labels)


def _fill_background(mesh: Mesh, labels: IntArray, first: int, background: Background) -> IntArray:
    is_left = labels < 0
    if background == "one":
        return np.where(is_left, first, labels)
    pairs = face_adjacency(mesh)
    _, component = connected_components(mesh.n_faces, pairs[is_left[pairs].all(axis=1)])
    return np.where(is_left, first + component, labels)


# --- checks ---------------------------------------------------------------------------------------


def _check_discovery(reject: Any, overlap: Any, n_objects: Any, background: Any) -> None:
    if isinstance(reject, str) or not isinstance(reject, Collection):
        raise TypeError(f"reject must be a collection of names, such as ('size', 'flat'), got {reject!r}")
    for rule in reject:
        if rule not in REJECTS:
            raise ValueError(f"reject may hold 'size', 'thin' and 'flat', got {rule!r}")
    if not isinstance(overlap, (int, float)) or not 0 <= overlap <= 1:
        raise ValueError(f"overlap must be a number in [0, 1], got {overlap!r}")
    if n_objects is not None and (not isinstance(n_objects, (int, np.integer)) or n_objects < 1):
        raise ValueError(f"n_objects must be a whole number of at least 1 or None, got {n_objects!r}")
    if background not in ("one", "pieces", "unlabeled"):
        raise ValueError(f"background must be 'one', 'pieces' or 'unlabeled', got {background!r}")
