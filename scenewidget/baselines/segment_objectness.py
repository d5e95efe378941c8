"""The measures of objectness of one segment of a mesh, by name.

Goes in: a mesh and some of its faces. Come out: what Karpathy, Miller and Fei-Fei (2013), *Object discovery
in 3D scenes via shape analysis*, ICRA, rank pieces by; the thesis (chapter 5) would rank suggested edits so.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from scenewidget.baselines.graph_segmentation import Convexity, check_options, mesh_graph
from scenewidget.baselines.shape_measures import (
    compactness,
    global_convexity,
    local_convexity,
    recurrence,
    smoothness,
    symmetry,
    tangent_neighbours,
)
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.monitor import SILENT

__all__ = ["objectness"]

MOST_POINTS = 4_000  # on which symmetry, compactness, global convexity and recurrence are taken


def objectness(
    mesh: Mesh,
    faces: Any,
    *,
    others: Sequence[tuple[Mesh, Any]] = (),
    convexity: Convexity = "outward",
) -> dict[str, float]:
    """Karpathy et al.'s six measures of how much a segment looks like an object, from its shape alone.

    All are signed so that more means more of an object, and taken on the segment by itself: vertices and
    edges that it shares with others count as its own. To rank segments the paper takes the mean of the
    measures, each brought to mean 0 and standard deviation 1 over the segments
    (`shape_measures.mean_objectness`).

    Parameters
    ----------
    mesh : Mesh
    faces : (n,) int or (n_faces,) bool
        Faces of the segment.
    others : sequence of (mesh, faces)
        Segments from other scenes, for recurrence.
    convexity : "outward" | "inward" | "ignored"
        Where normals point; see `felzenszwalb`. "ignored" counts as "outward".

    Returns
    -------
    measures : dict of str to float
        ``compactness``: area over that of the smallest bounding sphere. ``symmetry``: minus the mean
        distance to the mirror images along the principal axes, see `shape_measures.symmetry`.
        ``smoothness``: mean entropy of the directions under which a vertex sees its neighbours, nats.
        ``local_convexity``: share of convex edges. ``global_convexity``: minus the mean distance to the
        convex hull, metres. ``recurrence``: minus the mean distance to the ten most similar of ``others``,
        metres; nan without others. Where there are more than 4 000 vertices, all but smoothness and local
        convexity come from 4 000 of them.

    Raises
    ------
    TypeError, ValueError
        Faces that are no face numbers of the mesh, or none.

    References
    ----------
    Karpathy, Miller and Fei-Fei (2013), ICRA.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh, truth = sw.datasets.load_room()
    >>> measures = sw.baselines.objectness(mesh, truth.labels == 3)
    >>> sorted(measures)[:3]
    ['compactness', 'global_convexity', 'local_convexity']
    """
    check_options(mesh, 1, convexity)
    piece = _part(mesh, _checked_faces("faces", faces, mesh))
    graph = mesh_graph(piece, "vertices", convexity, SILENT)
    labels = np.where(np.bincount(graph.faces.ravel(), minlength=piece.n_vertices) > 0, 0, -1)
    points, axes, sample = _in_frame(graph.positions[labels == 0])
    normals = graph.normals[labels == 0][sample] @ axes
    neighbours = tangent_neighbours(graph.positions, graph.normals, graph.pairs)
    return {
        "compactness": compactness(float(piece.face_areas.sum()), points),
        "symmetry": symmetry(points, normals),
        "smoothness": float(smoothness(labels, 1, neighbours)[0]),
        "local_convexity": float(local_convexity(labels, 1, graph.pairs, graph.is_convex)[0]),
        "global_convexity": global_convexity(points),
        "recurrence": recurrence(
            points, [_other(k, *pair) for k, pair in enumerate(_checked_others(others))]
        ),
    }


def _part(mesh: Mesh, faces: IntArray) -> Mesh:
    used, compact = np.unique(mesh.faces[faces], return_inverse=True)
    return Mesh(mesh.vertices[used], compact.reshape(-1, 3))


def _in_frame(positions: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Points in their principal frame, the longest axis first, the axes as columns, and which they are."""
    n = len(positions)
    sample = np.arange(n)
    if n > MOST_POINTS:
        sample = np.sort(np.random.default_rng(0).permutation(n)[:MOST_POINTS])
    centered = positions - positions.mean(axis=0)
    axes = np.linalg.eigh(centered.T @ centered)[1][:, ::-1]
    return centered[sample] @ axes, axes, sample


def _other(k: int, mesh: Mesh, faces: Any) -> FloatArray:
    chosen = _checked_faces(f"others[{k}]", faces, mesh)
    return _in_frame(mesh.vertices[np.unique(mesh.faces[chosen])])[0]


# --- checks ---------------------------------------------------------------------------------------


def _checked_faces(name: str, faces: Any, mesh: Mesh) -> IntArray:
    chosen = np.asarray(faces)
    if chosen.dtype == bool:
        if chosen.shape != (mesh.n_faces,):
            raise ValueError(
                f"{name} as a mask must have an entry a face of the mesh: ({mesh.n_faces},), "
                f"got {chosen.shape}"
            )
        chosen = np.flatnonzero(chosen)
    if chosen.ndim != 1 or (chosen.dtype.kind not in "iu" and chosen.size):
        raise TypeError(
            f"{name} must be face numbers or a mask, such as seg.labels == 3, got {chosen.dtype} of shape "
            f"{chosen.shape}"
        )
    if chosen.size == 0:
        raise ValueError(f"{name} is empty: an objectness needs at least one face")
    if not (chosen.min() >= 0 and chosen.max() < mesh.n_faces):
        raise ValueError(
            f"{name} must lie in 0..{mesh.n_faces - 1}, got {chosen.min()}..{chosen.max()}: are they of this "
            "mesh?"
        )
    return np.unique(chosen).astype(np.int64)


def _checked_others(others: Any) -> list[tuple[Mesh, Any]]:
    pairs = list(others)
    for k, pair in enumerate(pairs):
        if not (isinstance(pair, (tuple, list)) and len(pair) == 2 and isinstance(pair[0], Mesh)):
            raise TypeError(f"others[{k}] must be a pair (mesh, faces), got {type(pair).__name__}")
    return pairs
