"""From a raw scan to something of a size that can be clustered: components, simplification, normals.

Goes in: the mesh as loaded. Come out: the faces worth keeping, a simplified mesh with the way back to the
raw faces (thesis 3.1), and face normals freed from the scanner's noise.
"""

from __future__ import annotations

import itertools
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Literal

import numba
import numpy as np
from scipy import sparse

from scenewidget.engine.mesh import (
    BoolArray,
    FloatArray,
    IntArray,
    Mesh,
    MeshError,
    connected_components,
    face_adjacency,
    weld,
)
from scenewidget.engine.monitor import SILENT, Monitor

__all__ = ["Simplified", "filter_normals", "keep_components", "neighbor_table", "simplify"]

Simplifier = Literal["fast", "qslim"]
_FAST_EDGE = 0.02  # mean length that fast-simplification is given: its thresholds are absolute, for metres
_FAST_SIMPLIFICATION = threading.Lock()  # the library keeps its mesh in a global variable


def keep_components(
    component: IntArray, n_components: int, *, coverage: float = 0.98, smallest: float = 0.005
) -> BoolArray:
    """Which faces lie in components worth keeping (thesis 3.1).

    Components are taken from the one with most faces on, until they cover ``coverage`` of the faces or
    the next one holds less than ``smallest`` of them. The first is always kept.

    Parameters
    ----------
    component : (n_faces,) int
    n_components : int
    coverage : float
    smallest : float

    Returns
    -------
    is_kept : (n_faces,) bool
    """
    count = np.bincount(component, minlength=n_components)
    order = np.argsort(-count, kind="stable")
    share = count[order] / max(1, len(component))
    before = np.concatenate([[0.0], np.cumsum(share)[:-1]])
    stop = (before >= coverage) | (share < smallest)
    stop[0] = False
    n_kept = int(np.argmax(stop)) if stop.any() else len(order)
    is_kept = np.zeros(n_components, dtype=bool)
    is_kept[order[:n_kept]] = True
    return is_kept[component]


@dataclass(frozen=True, eq=False)
class Simplified:
    """A simplified mesh and the way back.

    Attributes
    ----------
    mesh : Mesh
        Without degenerate faces and without components below the smallest share.
    face_map : (n_raw_faces,) int32
        Nearest simplified face of each raw face, −1 where it was dropped.
    bridges : (n_bridges, 2) int32
        Pairs of simplified faces that belong to neighbouring raw faces, where the simplifier tore the
        surface apart.
    report : dict
        What was reached and dropped, for the user.
    """

    mesh: Mesh
    face_map: IntArray
    bridges: IntArray
    report: dict[str, Any] = field(default_factory=dict)


def simplify(
    mesh: Mesh,
    pairs: IntArray | None = None,
    *,
    n_faces: int = 10_000,
    simplifier: Simplifier = "fast",
    coverage: float = 0.98,
    smallest: float = 0.005,
    smallest_simplified: float = 0.01,
    tolerance: float = 2.0,
    monitor: Monitor | None = None,
) -> Simplified:
    """Simplify the large components by quadric error metrics and map the result back (thesis 3.1).

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int, optional
        `face_adjacency` of the mesh, where the caller has it.
    n_faces : int
        Target; a smaller mesh is kept as it is.
    simplifier : str
        "fast": fast-simplification, seconds at a million faces, may leave non-manifold edges; where it
        stops above the target, as on fragmented scans, shortest edges are collapsed for the rest. "qslim":
        libigl's, slower by ten times, keeps manifold meshes manifold and refuses others.
    coverage, smallest : float
        See `keep_components`.
    smallest_simplified : float
        Components below this share of the simplified and of the raw faces are dropped. Pieces that the
        simplifier tore off count with the component that they came from.
    tolerance : float
        A raw face stays unlabeled if it lies farther from the simplified surface than this share of the
        root of the mean simplified face area.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    References
    ----------
    Garland and Heckbert (1997), SIGGRAPH.
    """
    monitor = monitor or SILENT
    if simplifier not in ("fast", "qslim"):
        raise ValueError(f"simplifier must be 'fast' or 'qslim', got {simplifier!r}")
    pairs = face_adjacency(mesh) if pairs is None else pairs
    n_components, component = connected_components(mesh.n_faces, pairs)
    is_kept = keep_components(component, n_components, coverage=coverage, smallest=smallest)
    monitor.tick(0.05)

    merged = weld(mesh)[mesh.faces[is_kept]]
    is_degenerate = (merged == np.roll(merged, 1, axis=1)).any(axis=1)
    if is_degenerate.all():
        raise MeshError("all faces of the mesh are degenerate (two corners at one place): it has no surface")
    used, compact = np.unique(merged[~is_degenerate], return_inverse=True)
    vertices: FloatArray = mesh.vertices[used]
    faces: IntArray = compact.reshape(-1, 3).astype(np.int32)
    if len(faces) > n_faces:
        run = _fast if simplifier == "fast" else _qslim
        vertices, faces = monitor.call(run, vertices, faces, n_faces)
    monitor.tick(0.6)

    reached = len(faces)
    small = Mesh(vertices, faces)
    is_solid = small.face_areas > 0
    if not is_solid.any():
        raise MeshError("the mesh has no face with an area: it has no surface to segment")
    if not is_solid.all():
        small = Mesh(small.vertices, small.faces[is_solid])
    face_map: IntArray = np.full(mesh.n_faces, -1, dtype=np.int32)
    kept_faces = np.flatnonzero(is_kept)
    face_map[kept_faces], distance = _closest(mesh.face_centroids[kept_faces], small, monitor)

    piece_count, piece = connected_components(small.n_faces, face_adjacency(small))
    origin = np.full(piece_count, -1, dtype=np.int64)
    origin[piece[face_map[kept_faces]]] = component[kept_faces]
    share = np.bincount(origin[piece] + 1, minlength=n_components + 1) / small.n_faces
    raw_share = np.bincount(component + 1, minlength=n_components + 1) / len(kept_faces)
    share = np.maximum(share, raw_share)  # what the simplifier thinned out does not count as small
    share[0] = 0.0  # pieces that no raw face is nearest to
    is_large = share >= min(smallest_simplified, share.max())
    stays = is_large[origin[piece] + 1]
    small, face_map = _keep_faces(small, stays, face_map)

    limit = tolerance * np.sqrt(small.face_areas.mean())
    beyond = np.zeros(mesh.n_faces, dtype=bool)
    beyond[kept_faces] = distance > limit
    torn = face_map[pairs]
    torn = torn[(torn >= 0).all(axis=1) & ~beyond[pairs].any(axis=1)]
    torn = np.unique(np.sort(torn[piece[stays][torn[:, 0]] != piece[stays][torn[:, 1]]], axis=1), axis=0)
    face_map[beyond] = -1
    report = {
        "faces in dropped components": int((~is_kept).sum()),
        "faces beyond the tolerance": int(beyond.sum()),
        "tolerance in metres": float(limit),
        "simplified faces asked for": int(n_faces),
        "simplified faces reached": reached,
        "simplified faces dropped": reached - small.n_faces,
    }
    return Simplified(small, face_map, torn, report)


def _keep_faces(mesh: Mesh, stays: BoolArray, face_map: IntArray) -> tuple[Mesh, IntArray]:
    """The mesh without some faces, and a map to its faces renumbered, -1 to those that are gone."""
    if stays.all():
        return mesh, face_map
    used, compact = np.unique(mesh.faces[stays], return_inverse=True)
    renumber = np.full(mesh.n_faces + 1, -1, dtype=np.int32)  # the last entry is for face_map = -1
    renumber[np.flatnonzero(stays)] = np.arange(int(stays.sum()), dtype=np.int32)
    return Mesh(mesh.vertices[used], compact.reshape(-1, 3)), renumber[face_map]


def _fast(vertices: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    import fast_simplification

    before = vertices, faces
    center = vertices.mean(axis=0)
    edge = np.linalg.norm(vertices[faces[:, 0]] - vertices[faces[:, 1]], axis=1).mean()
    unit = float(edge) / _FAST_EDGE
    vertices = (vertices - center) / unit
    with _FAST_SIMPLIFICATION:
        for aggressiveness in (7.0, 10.0, 15.0):  # fragmented scans stop far above the target: try harder
            vertices, faces = fast_simplification.simplify(
                np.array(vertices), np.array(faces), target_count=int(target), agg=aggressiveness
            )
            if len(faces) <= 1.05 * target:
                break
    vertices = np.asarray(vertices, dtype=np.float64) * unit + center
    faces = np.asarray(faces, dtype=np.int32)
    if 0 < len(faces) <= 1.05 * target:
        return vertices, faces
    if len(faces) == 0:  # a target of a few faces: the library may leave none
        vertices, faces = before
    return _shortest_edges(vertices, faces, target)


def _shortest_edges(vertices: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    """Collapse shortest edges to their midpoints, whatever they border on, down to ``target`` faces.

    For what the library leaves of a fragmented scan: it never joins a border with the inside. A piece
    keeps a face as long as its edges are manifold, so with more pieces than ``target`` it ends above it.
    """
    while len(faces) > target:
        moved = vertices.copy()
        ends = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges = np.unique(ends, axis=0)
        length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
        _, piece = connected_components(len(vertices), edges)
        allowed = (np.bincount(piece[faces[:, 0]], minlength=len(vertices)) - 1) // 2  # two faces an edge
        wanted = -(-(len(faces) - target) // 2)
        is_free = np.ones(len(vertices), dtype=bool)
        parent = np.arange(len(vertices), dtype=np.int32)
        for a, b in edges[np.argsort(length, kind="stable")]:  # n edges at most, a few µs each
            if is_free[a] and is_free[b] and allowed[piece[a]] > 0:
                is_free[a] = is_free[b] = False
                allowed[piece[a]] -= 1
                parent[b] = a
                moved[a] = 0.5 * (vertices[a] + vertices[b])
                wanted -= 1
                if wanted == 0:
                    break
        left = parent[faces]
        left = left[(left != np.roll(left, 1, axis=1)).all(axis=1)]
        _, first = np.unique(np.sort(left, axis=1), axis=0, return_index=True)
        if len(first) == 0 or len(first) == len(faces):  # all would vanish with an edge of theirs, or none
            break
        vertices, faces = moved, left[np.sort(first)]
    used, compact = np.unique(faces, return_inverse=True)
    return vertices[used], compact.reshape(-1, 3).astype(np.int32)


def _qslim(vertices: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    import igl

    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    if len(np.unique(halves[:, 0] * len(vertices) + halves[:, 1])) < len(halves):  # qslim would never return
        raise MeshError(
            "simplifier='qslim' needs a mesh without non-manifold edges whose faces are all wound the same "
            "way, and this one has an edge that two faces run through in one direction; use simplifier='fast'"
        )
    out_vertices, out_faces, _, _ = igl.qslim(vertices, faces.astype(np.int64), int(target))
    if len(out_faces) == 0:
        raise MeshError(
            "simplifier='qslim' needs a mesh without non-manifold edges, and this one has some; "
            "use simplifier='fast'"
        )
    return np.asarray(out_vertices), np.asarray(out_faces, dtype=np.int32)


def _closest(points: FloatArray, mesh: Mesh, monitor: Monitor) -> tuple[IntArray, FloatArray]:
    """Exact closest face and distance, in chunks, so that a cancel is heard."""
    import igl

    nearest = np.empty(len(points), dtype=np.int32)
    distance = np.empty(len(points))
    faces = mesh.faces.astype(np.int64)
    step = 200_000
    for start in range(0, len(points), step):
        square, face, _ = igl.point_mesh_squared_distance(
            np.ascontiguousarray(points[start : start + step]), np.array(mesh.vertices), faces
        )
        nearest[start : start + step] = face
        distance[start : start + step] = np.sqrt(square)
        monitor.tick(0.65 + 0.35 * min(1.0, (start + step) / len(points)))
    return nearest, distance


def neighbor_table(n_items: int, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Neighbours of each item as (indptr, indices) of a csr pattern, both int32, ascending.

    Parameters
    ----------
    n_items : int
    pairs : (n_pairs, 2) int
        Neighbours; each pair once, in either order.
    """
    ones = np.ones(2 * len(pairs), dtype=np.int8)
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T if len(pairs) else np.empty((2, 0), np.int32)
    table = sparse.csr_array((ones, (rows, columns)), shape=(n_items, n_items))
    table.sort_indices()
    return table.indptr.astype(np.int32), table.indices.astype(np.int32)


def filter_normals(
    mesh: Mesh,
    pairs: IntArray,
    *,
    sweeps: int = 30,
    width: float = 0.3,
    n_threads: int = 2,
    monitor: Monitor | None = None,
) -> FloatArray:
    """Face normals averaged over the surface but not across creases.

    Each sweep replaces a normal by ``unit(A_i N_i + Σ_j A_j exp(−((1 − N_i·N_j) / width)²) N_j)`` over
    the neighbours j, weighted by area A.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int
        Adjacent faces.
    sweeps : int
        How far normals spread: about √sweeps faces.
    width : float
        Difference 1 − N_i·N_j from which a neighbour hardly counts; 0.3 is 46°.
    n_threads : int
        The result does not depend on it.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    Returns
    -------
    normals : (n_faces, 3) float32
        Unit, or zero where a degenerate face has no neighbour to learn from.

    References
    ----------
    Bilateral normal filtering: Zheng, Fu, Au and Tai (2011), IEEE TVCG 17(10).
    """
    monitor = monitor or SILENT
    indptr, indices = neighbor_table(mesh.n_faces, pairs)
    areas = (mesh.face_areas / max(float(mesh.face_areas.max()), 1e-300)).astype(np.float32)  # any unit fits
    here = mesh.face_normals.astype(np.float32)
    there = here.copy()
    bounds = np.linspace(0, mesh.n_faces, n_threads + 1).astype(np.int64)
    with ThreadPoolExecutor(n_threads) as pool:
        for sweep in range(sweeps):
            monitor.tick(sweep / sweeps)
            jobs = [
                pool.submit(_sweep, here, there, areas, indptr, indices, np.float32(width), start, stop)
                for start, stop in itertools.pairwise(bounds)
            ]
            for job in jobs:
                job.result()
            here, there = there, here
    return here


# reordered or fused arithmetic (all of fastmath) is hardly faster, and differs from processor to processor
@numba.njit(cache=True, nogil=True, fastmath={"nnan", "ninf", "nsz"})
def _sweep(here, there, areas, indptr, indices, width, start, stop):  # type: ignore[no-untyped-def]
    for i in range(start, stop):
        x, y, z = here[i, 0], here[i, 1], here[i, 2]
        is_blank = x * x + y * y + z * z == 0.0
        sx, sy, sz = areas[i] * x, areas[i] * y, areas[i] * z
        for e in range(indptr[i], indptr[i + 1]):
            j = indices[e]
            u, v, w = here[j, 0], here[j, 1], here[j, 2]
            step = (np.float32(1.0) - x * u - y * v - z * w) / width
            weight = areas[j] * (np.float32(1.0) if is_blank else np.exp(-step * step))
            sx += weight * u
            sy += weight * v
            sz += weight * w
        length = np.sqrt(sx * sx + sy * sy + sz * sz)
        if length > 0.0:
            there[i, 0], there[i, 1], there[i, 2] = sx / length, sy / length, sz / length
        else:
            there[i, 0], there[i, 1], there[i, 2] = x, y, z
