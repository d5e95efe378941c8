"""From a raw scan to something of a size that can be clustered: components, simplification, normals.

Goes in: the mesh as loaded. Come out: the faces worth keeping, a simplified mesh with the way back to the
raw faces (thesis 3.1), and face normals freed from the scanner's noise.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.curve import along_curve
from scenewidget.engine.decimation import decimate
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import (
    BoolArray,
    FloatArray,
    IntArray,
    Mesh,
    MeshError,
    ascending,
    connected_components,
    face_adjacency,
    neighbor_table,
    taken,
    unique_codes,
    weld,
)
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.threads import parts

__all__ = ["Simplified", "filter_normals", "keep_components", "simplify"]

Simplifier = Literal["fast", "qslim"]
_FAST_EDGE = 0.02  # mean length that `decimate` is given: its thresholds are absolute, for metres
PLAIN_SWEEPS, SUPER_STEPS = 6, 4  # of the normal filter: first so many alone, the others in so many groups
BLOCK = 128  # faces whose normals are filtered at once
STRETCH = 4096  # points along the curve among which those with as many neighbours come together
# 2^x as float32, x ≤ 0: powers of 2^(−1/32), and a polynomial of what is left (Nagy, Arm Optimized Routines)
ROOTS = np.array([2.0 ** (-i / 32) for i in range(32)])
POWERS = np.array([2.0**-i for i in range(130)])
LOG2E_32, ROUNDED = 32 * float.fromhex("0x1.71547652b82fep+0"), float.fromhex("0x1.8p+52")
EXP2 = (
    float.fromhex("0x1.c6af84b912394p-5") / 32**3,
    float.fromhex("0x1.ebfce50fac4f3p-3") / 32**2,
    float.fromhex("0x1.62e42ff0c52d6p-1") / 32,
)
FARTHEST = np.float32(87.0)  # whose exponential is the least normal float32
MOST_CUT = 0.1  # share of the sides of faces; raw scans have up to 0.01


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

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.preprocess import keep_components
    >>> keep_components(np.array([0, 0, 0, 1]), 2, coverage=0.7).tolist()
    [True, True, True, False]
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
    component : (mesh.n_faces,) int32
        Connected component of the raw mesh that each simplified face comes from, numbered from the one
        with most raw faces; of those that are left.
    face_map : (n_raw_faces,) int32
        Nearest simplified face of each raw face, of those from its own component; −1 where it was dropped.
    pairs : (n_pairs, 2) int32
        Neighbours: simplified faces that share an edge, then ``bridges``. The connected components of this
        graph are those in ``component``, no more and no fewer.
    bridges : (n_bridges, 2) int32
        Neighbours where the simplifier tore the surface apart: the faces that two adjacent raw faces are
        nearest to, and where no raw faces tell, the nearest faces of two pieces.
    report : dict
        What was reached and dropped, for the user.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.preprocess import simplify
    >>> small = simplify(square(20), n_faces=50)
    >>> small.mesh.n_faces <= 50, small.face_map.shape
    (True, (800,))
    """

    mesh: Mesh
    component: IntArray
    face_map: IntArray
    pairs: IntArray
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
    drop_torn: bool = False,
    tolerance: float = 2.0,
    monitor: Monitor | None = None,
) -> Simplified:
    """Simplify the large components by quadric error metrics and map the result back (thesis 3.1).

    A cloud has no faces to collapse: the points of a component in a cell of a grid, those that look to one
    side, become one, at their mean, with their area and mean normal. The grid is as fine as ``n_faces``
    allows.

    Components of the raw mesh stay apart, however close they lie: no simplified face and no pair of
    neighbours belongs to two of them, and a raw face finds its place in its own.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int, optional
        `face_adjacency` of the mesh, where the caller has it.
    n_faces : int
        Target; a smaller mesh is kept as it is.
    simplifier : str
        "fast": `decimation.decimate`, seconds at a million faces, tears noisy surfaces into pieces. "qslim":
        libigl's, ten times slower; it gets the mesh cut open along non-manifold edges. Where either stops
        above the target, as on fragmented scans, shortest edges are collapsed for the rest.
    coverage, smallest : float
        See `keep_components`.
    smallest_simplified : float
        Components below this share of the simplified faces are dropped.
    drop_torn : bool
        What counts as a component in that. True: a connected piece of the simplified mesh, to the letter
        of the thesis, so what the simplifier tore off is mostly dropped. False: all that comes from one
        component of the raw mesh, and its share of the raw faces counts where it is larger, so what the
        simplifier tore or thinned out stays.
    tolerance : float
        A raw face stays unlabeled if it lies farther from the simplified surface than this share of the
        root of the mean simplified face area; ``inf`` sets no limit.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    References
    ----------
    Garland and Heckbert (1997), SIGGRAPH.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.engine.preprocess import simplify
    >>> mesh, truth = sw.datasets.load_room()
    >>> small = simplify(mesh, n_faces=2_000)
    >>> small.report["components kept"]
    2
    """
    monitor = monitor or SILENT
    if simplifier not in ("fast", "qslim"):
        raise ValueError(f"simplifier must be 'fast' or 'qslim', got {simplifier!r}")
    pairs = face_adjacency(mesh) if pairs is None else pairs
    n_components, raw_component = connected_components(mesh.n_faces, pairs)
    is_kept = keep_components(raw_component, n_components, coverage=coverage, smallest=smallest)
    if isinstance(mesh, PointCloud):
        return _thinned(mesh, raw_component, is_kept, n_faces)
    kept = np.flatnonzero(is_kept)
    component = np.full(mesh.n_faces, -1, dtype=np.int32)
    component[kept] = _by_size(raw_component[kept])
    monitor.tick(0.05)

    corners = weld(mesh)[mesh.faces]
    is_solid = is_kept & ~(corners == np.roll(corners, 1, axis=1)).any(axis=1)
    if not is_solid.any():
        raise MeshError("all faces of the mesh are degenerate (two corners at one place): it has no surface")
    run = _fast if simplifier == "fast" else _qslim
    small, origin = monitor.call(
        _simplified, mesh.vertices, corners[is_solid], component[is_solid], n_faces, run
    )
    reached = small.n_faces
    monitor.tick(0.6)
    has_area = small.face_areas > 0
    if not has_area.any():
        raise MeshError("the mesh has no face with an area: it has no surface to segment")
    small, origin = _with_faces(small, has_area), origin[has_area]

    face_map: IntArray = np.full(mesh.n_faces, -1, dtype=np.int32)
    distance = np.full(mesh.n_faces, np.inf)
    for c in range(int(component.max()) + 1):
        raw, own = np.flatnonzero(component == c), np.flatnonzero(origin == c)
        if len(own):
            part = _with_faces(small, origin == c)
            nearest, distance[raw] = _closest(mesh.face_centroids[raw], part, monitor)
            face_map[raw] = own[nearest]

    raw_share = np.bincount(component[kept]) / len(kept)
    stays = _is_large(small, origin, raw_share, smallest_simplified, drop_torn)
    renumber = np.append(np.where(stays, np.cumsum(stays) - 1, -1), -1).astype(np.int32)
    small, origin, face_map = _with_faces(small, stays), origin[stays], renumber[face_map]

    n_lost = len(kept) - int((face_map >= 0).sum())
    limit = tolerance * np.sqrt(small.face_areas.mean())
    is_beyond = (face_map >= 0) & (distance > limit)
    face_map[is_beyond] = -1
    touching = _touching(small, origin)
    bridges = _bridges(small, origin, touching, face_map[pairs])
    report = {
        "components kept": len(np.unique(origin)),
        "faces in dropped components": int((~is_kept).sum()),
        "faces in components that simplified to nothing or too little": n_lost,
        "faces beyond the tolerance": int(is_beyond.sum()),
        "tolerance in metres": float(limit),
        "simplified faces asked for": int(n_faces),
        "simplified faces reached": reached,
        "simplified faces dropped": reached - small.n_faces,
    }
    origin = np.unique(origin, return_inverse=True)[1].astype(np.int32)
    small = dataclasses.replace(small, source=mesh.source)  # what its reader said of units is not said again
    return Simplified(small, origin, face_map, np.concatenate([touching, bridges]), bridges, report)


def _thinned(cloud: PointCloud, component: IntArray, is_kept: BoolArray, n_wanted: int) -> Simplified:
    """At most ``n_wanted`` points for those of the components that are kept."""
    kept = np.flatnonzero(is_kept)
    if len(kept) <= n_wanted:
        cell = np.arange(len(kept))
    else:
        places, side = cloud.points[kept], _octant(cloud.face_normals[kept])
        low, high = 0.0, float(np.ptp(places, axis=0).max()) + cloud.spacing
        cell = np.zeros(len(kept), dtype=np.int64)
        for _ in range(24):  # the finest grid with so few cells, to a 10⁻⁷ of the extent
            size = 0.5 * (low + high)
            grid = np.floor((places - places.min(axis=0)) / size).astype(np.int64)
            rows = np.column_stack([grid, side, component[kept]])
            found = np.unique(rows @ _mixer(rows), return_inverse=True)[1]
            if found.max() < n_wanted:
                high, cell = size, found
            else:
                low = size
            if high - low < 0.01 * high and cell.any():
                break
    n = int(cell.max()) + 1
    areas = cloud.face_areas[kept]
    weights = areas + 1e-9 * areas.mean() + 1e-300
    total = np.bincount(cell, weights, n)

    def mean(values: npt.NDArray[Any]) -> FloatArray:
        sums = [np.bincount(cell, weights * column, n) / total for column in values[kept].T]
        return np.asarray(np.stack(sums, axis=1))

    colors = None if cloud.vertex_colors is None else np.round(mean(cloud.vertex_colors)).astype(np.uint8)
    small = PointCloud(mean(cloud.points), mean(cloud.face_normals), colors, source=cloud.source)
    area = np.bincount(cell, areas, n)
    area.flags.writeable = False
    vars(small)["face_areas"] = area
    face_map: IntArray = np.full(cloud.n_faces, -1, dtype=np.int32)
    face_map[kept] = cell
    home = np.zeros(n, dtype=np.int64)
    home[cell] = component[kept]
    origin = np.unique(home, return_inverse=True)[1].astype(np.int32)
    pairs = face_adjacency(small)
    touching: IntArray = pairs[origin[pairs[:, 0]] == origin[pairs[:, 1]]]
    report = {
        "components kept": int(origin.max()) + 1,
        "faces in dropped components": int((~is_kept).sum()),
        "simplified faces asked for": int(n_wanted),
        "simplified faces reached": n,
    }
    return Simplified(small, origin, face_map, touching, np.empty((0, 2), np.int32), report)


def _octant(normals: FloatArray) -> IntArray:
    """(n,) to which of the six sides of a cube a normal points."""
    axis = np.abs(normals).argmax(axis=1)
    return np.asarray(2 * axis + (normals[np.arange(len(axis)), axis] > 0))


def _mixer(rows: IntArray) -> IntArray:
    """(k,) by which rows of small whole numbers become one number each, no two alike."""
    spans = np.append(1, np.cumprod((rows.max(axis=0) + 1)[:-1]))
    return np.asarray(spans, dtype=np.int64)


def _by_size(component: IntArray) -> IntArray:
    """Components numbered by descending number of faces, equal ones in their order."""
    present, place = unique_codes(component, int(component.max()) + 1)
    rank = np.empty(len(present), dtype=np.int32)
    rank[np.argsort(-np.bincount(place), kind="stable")] = np.arange(len(present))
    return rank[place]


def _simplified(
    vertices: FloatArray,
    faces: IntArray,
    component: IntArray,
    target: int,
    run: Callable[[FloatArray, IntArray, int], tuple[FloatArray, IntArray]],
) -> tuple[Mesh, IntArray]:
    """All components simplified together, and the component of each simplified face.

    No simplifier tells where its faces come from, but none joins what doesn't touch. So the components are
    moved apart along x, simplified, recognised by where they lie, and moved back.
    """
    n = len(vertices)
    code = component[:, None].astype(np.int64) * n + faces  # what two components share is one vertex of each
    used, compact = unique_codes(code, (int(component.max()) + 1) * n)
    vertices, owner = vertices[used % n], used // n
    faces = compact.reshape(-1, 3).astype(np.int32)
    if len(faces) <= target:
        return Mesh(vertices, faces), component
    middle = 0.5 * (vertices[:, 0].min() + vertices[:, 0].max())
    stride = 4.0 * float(np.ptp(vertices, axis=0).max())  # metres; vertices may end outside of the old bounds
    along_x = np.array([stride, 0.0, 0.0])
    vertices, faces = run(vertices + owner[:, None] * along_x, faces, target)
    place = np.clip(np.rint((vertices[:, 0] - middle) / stride), 0, component.max()).astype(np.int64)
    n_pieces, piece = connected_components(len(vertices), faces[:, [0, 1, 1, 2]].reshape(-1, 2))
    votes = np.zeros((n_pieces, int(component.max()) + 1), dtype=np.int64)
    np.add.at(votes, (piece, place), 1)
    owner = votes.argmax(axis=1)[piece]
    return Mesh(vertices - owner[:, None] * along_x, faces), owner[faces[:, 0]].astype(np.int32)


def _is_large(
    small: Mesh, origin: IntArray, raw_share: FloatArray, smallest: float, drop_torn: bool
) -> BoolArray:
    """(small.n_faces,) whether a face lies in a component worth keeping; the largest is."""
    if drop_torn:
        group = connected_components(small.n_faces, _touching(small, origin))[1]
        share = np.bincount(group) / small.n_faces
    else:
        group = origin
        share = np.maximum(np.bincount(origin, minlength=len(raw_share)) / small.n_faces, raw_share)
        share[np.bincount(origin, minlength=len(raw_share)) == 0] = 0.0
    stays: BoolArray = (share >= min(smallest, share.max()))[group]
    return stays


def _touching(small: Mesh, origin: IntArray) -> IntArray:
    """Faces of one component that share an edge."""
    pairs = face_adjacency(small)
    inside: IntArray = pairs[origin[pairs[:, 0]] == origin[pairs[:, 1]]]
    return inside


def _bridges(small: Mesh, origin: IntArray, touching: IntArray, ends: IntArray) -> IntArray:
    """Pairs of faces that make each component one piece again; ``ends`` are those of adjacent raw faces."""
    _, piece = connected_components(small.n_faces, touching)
    torn = ends[(ends >= 0).all(axis=1)]
    torn = np.sort(torn[piece[torn[:, 0]] != piece[torn[:, 1]]], axis=1)
    bridges = np.unique(torn, axis=0).astype(np.int32)
    _, piece = connected_components(small.n_faces, np.concatenate([touching, bridges]))
    found = [bridges]
    for c in np.unique(origin):
        inside = np.flatnonzero(origin == c)
        _, place, count = np.unique(piece[inside], return_inverse=True, return_counts=True)
        main = inside[place == count.argmax()]
        lost = inside[place != count.argmax()]
        if len(lost) == 0:
            continue
        distance, near = cKDTree(small.face_centroids[main]).query(small.face_centroids[lost])
        order = np.lexsort((distance, piece[lost]))
        _, first = np.unique(piece[lost][order], return_index=True)
        found.append(np.sort(np.stack([lost, main[near]], axis=1)[order[first]], axis=1))
    return np.concatenate(found).astype(np.int32)


def _with_faces(mesh: Mesh, stays: BoolArray) -> Mesh:
    """The mesh without the other faces and without vertices that none of these has."""
    if stays.all():
        return mesh
    used, compact = np.unique(mesh.faces[stays], return_inverse=True)
    return Mesh(mesh.vertices[used], compact.reshape(-1, 3))


def _fast(vertices: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    before = vertices, faces
    center = vertices.mean(axis=0)
    edge = np.linalg.norm(taken(vertices, faces[:, 0]) - taken(vertices, faces[:, 1]), axis=1).mean()
    unit = float(edge) / _FAST_EDGE
    vertices = (vertices - center) / unit
    for aggressiveness in (7.0, 10.0, 15.0):  # fragmented scans stop far above the target: try harder
        vertices, faces = decimate(vertices, faces, int(target), aggressiveness=aggressiveness)
        if len(faces) <= 1.05 * target:
            break
    vertices = vertices * unit + center
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
    """libigl's, on the mesh cut open where it is no manifold: it refuses others, or never returns."""
    import igl

    corners, share = _cut_open(faces)
    if share > MOST_CUT:
        raise MeshError(
            f"simplifier='qslim' needs a manifold, and {share:.0%} of the sides of this mesh's faces lie at "
            "edges with more than two faces or with two that are not wound the same way (trimesh.repair."
            "fix_winding mends the second); use simplifier='fast'"
        )
    apart = np.empty((int(corners.max()) + 1, 3))
    apart[corners.ravel()] = vertices[faces.ravel()]
    vertices, faces, _, _ = igl.qslim(apart, corners.astype(np.int64), int(target))
    if len(faces) == 0:  # a target of a few faces
        vertices, faces = apart, corners
    vertices, faces = np.asarray(vertices), np.asarray(faces, dtype=np.int32)
    return (vertices, faces) if len(faces) <= 1.05 * target else _shortest_edges(vertices, faces, target)


def _cut_open(faces: IntArray) -> tuple[IntArray, float]:
    """(n_faces, 3) new corners, and the share of the sides of faces at which something was cut.

    Two faces share corners only at edges that are theirs alone and that they run through in opposite
    directions. So every edge has one or two faces, and those around a vertex form one fan.
    """
    half = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    code = half.min(axis=1) * (int(faces.max()) + 1) + half.max(axis=1)
    order = np.argsort(code, kind="stable")
    start = np.flatnonzero(np.concatenate([[True], np.diff(code[order]) != 0]))
    count = np.diff(np.append(start, len(code)))
    is_pair = count == 2
    one, other = order[start[is_pair]], order[start[is_pair] + 1]
    is_wound_well = half[one, 0] != half[other, 0]
    cut = int(count[count > 2].sum()) + 2 * int((~is_wound_well).sum())
    one, other = one[is_wound_well], other[is_wound_well]
    here, there = (edge - edge % 3 + (edge + 1) % 3 for edge in (one, other))  # the corners at their far ends
    same = np.concatenate([np.stack([one, there], axis=1), np.stack([here, other], axis=1)])
    corners = connected_components(len(half), same)[1].reshape(-1, 3).astype(np.int32)
    return corners, cut / len(half)


def _closest(points: FloatArray, mesh: Mesh, monitor: Monitor) -> tuple[IntArray, FloatArray]:
    """Exact closest face and distance, in chunks, so that a cancel is heard."""
    import igl

    nearest = np.empty(len(points), dtype=np.int32)
    distance = np.empty(len(points))
    vertices, faces = np.array(mesh.vertices), mesh.faces.astype(np.int64)
    order = along_curve(points)  # so that one search goes through what the last one left in the cache
    for part in parts(len(points), 200_000):
        square, face, _ = igl.point_mesh_squared_distance(taken(points, order[part]), vertices, faces)
        nearest[order[part]], distance[order[part]] = face, np.sqrt(square)
        monitor.tick()
    return nearest, distance


def filter_normals(
    mesh: Mesh,
    pairs: IntArray,
    *,
    normals: FloatArray | None = None,
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
    normals : (n_faces, 3) float, optional
        What to filter; those of the faces by default.
    sweeps : int
        How far normals spread: about √sweeps faces. Of more than 14 not all are made one by one: 18 do
        nearly what 30 would, 42 what 175 would.
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
    Bilateral normal filtering: Zheng, Fu, Au and Tai (2011), IEEE TVCG 17(10). Far diffusion by few sweeps:
    Meyer, Balsara and Aslam (2014), J. Comput. Phys. 257, the scheme of first order.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> from scenewidget.engine.preprocess import filter_normals
    >>> mesh = square(4)
    >>> filter_normals(mesh, face_adjacency(mesh)).mean(axis=0).tolist()
    [0.0, 0.0, 1.0]
    """
    monitor = monitor or SILENT
    indptr, indices = neighbor_table(mesh.n_faces, pairs)
    here = np.zeros((mesh.n_faces + 1, 4), dtype=np.float32)  # normal and area; the last is of no face
    here[:-1, :3] = mesh.face_normals if normals is None else normals
    here[:-1, 3] = mesh.face_areas / max(float(mesh.face_areas.max()), 1e-300)  # any unit fits
    steps, width32 = _super_steps(sweeps), np.float32(width)
    order = None
    if mesh.is_cloud:  # neighbours near in memory, and blocks of points that have as many of them
        order = along_curve(mesh.face_centroids)
        stretch = np.arange(mesh.n_faces, dtype=np.int32) // STRETCH * STRETCH
        order = order[ascending(stretch + np.minimum(np.diff(indptr)[order], STRETCH - 1))]
        here[:-1], (indptr, indices) = here[order], _reordered(indptr, indices, order)
    there = here.copy()
    bounds = np.linspace(0, mesh.n_faces, n_threads + 1).astype(np.int64)
    scratch = np.zeros((n_threads, 10 * BLOCK), dtype=np.float32)
    with ThreadPoolExecutor(n_threads) as pool:
        for done, (last, before, change) in enumerate(steps):
            monitor.tick(done / len(steps))
            jobs = [
                pool.submit(
                    _sweep, here, there, indptr, indices, width32, last, before, change, start, stop, block
                )
                for (start, stop), block in zip(itertools.pairwise(bounds), scratch)
            ]
            for job in jobs:
                job.result()
            here, there = there, here
    if order is None:
        return np.ascontiguousarray(here[:-1, :3])
    out = np.empty((mesh.n_faces, 3), dtype=np.float32)
    out[order] = here[:-1, :3]
    return out


def _reordered(indptr: IntArray, indices: IntArray, order: IntArray) -> tuple[IntArray, IntArray]:
    """A table of neighbours for items in another order; those of each item stay in theirs, so do sums."""
    place = np.empty(len(order), dtype=np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    count = np.diff(indptr)[order]
    starts = np.concatenate([[0], np.cumsum(count)]).astype(np.int32)
    source = np.repeat(indptr[:-1][order] - starts[:-1], count) + np.arange(starts[-1], dtype=np.int32)
    return starts, place[indices[source]]


def _super_steps(sweeps: int) -> list[tuple[np.float32, np.float32, np.float32]]:
    """Shares of the last state, the one before and the change in each sweep that is made.

    The first sweeps are plain, while noise goes and creases are found. What follows is slow diffusion along
    the surface: of it, s sweeps of Runge, Kutta and Legendre do what s (s + 1) / 2 plain ones do, as stably.
    """
    one, none = np.float32(1.0), np.float32(0.0)
    left = sweeps - PLAIN_SWEEPS
    if left <= 2 * SUPER_STEPS:  # nothing to gain
        return [(one, none, one)] * sweeps
    steps = [(one, none, one)] * PLAIN_SWEEPS
    reach = left / SUPER_STEPS
    for _ in range(SUPER_STEPS):
        s = int(np.ceil(np.sqrt(2.0 * reach + 0.25) - 0.5))
        for j in range(1, s + 1):
            share = (2 * j - 1) / j
            change = 2.0 * share * reach / (s * (s + 1))
            steps.append((np.float32(share), np.float32((1 - j) / j), np.float32(change)))
    return steps


# reordered or fused arithmetic (all of fastmath) is hardly faster, and differs from processor to processor
@kernel(fastmath={"nnan", "ninf", "nsz"})
def _sweep(  # type: ignore[no-untyped-def]
    here, there, indptr, indices, width, last, before, change, start, stop, block,
):  # fmt: skip
    """``there`` becomes unit(last · here + before · there + change · (unit(sum) − here)).

    Block by block, first what lies scattered is gathered, then computed for all faces of the block at once,
    which processors do 8 numbers at a time. ``block`` holds one after the other: normals (3), sums (3),
    the k-th neighbours' normals (3) and areas (1), of `BLOCK` faces each.
    """
    one, none, nothing = np.float32(1.0), np.float32(0.0), len(here) - 1
    for first in range(start, stop, BLOCK):
        n = min(BLOCK, stop - first)
        most = 0
        for i in range(n):
            f = first + i
            most = max(most, indptr[f + 1] - indptr[f])
            x, y, z, area = here[f, 0], here[f, 1], here[f, 2], here[f, 3]
            block[i], block[i + BLOCK], block[i + 2 * BLOCK] = x, y, z
            block[i + 3 * BLOCK], block[i + 4 * BLOCK], block[i + 5 * BLOCK] = area * x, area * y, area * z
        for k in range(most):
            for i in range(n):
                e = indptr[first + i] + k
                j = indices[e] if e < indptr[first + i + 1] else nothing
                block[i + 6 * BLOCK], block[i + 7 * BLOCK] = here[j, 0], here[j, 1]
                block[i + 8 * BLOCK], block[i + 9 * BLOCK] = here[j, 2], here[j, 3]
            for i in range(n):
                x, y, z = block[i], block[i + BLOCK], block[i + 2 * BLOCK]
                u, v, w = block[i + 6 * BLOCK], block[i + 7 * BLOCK], block[i + 8 * BLOCK]
                step = (one - x * u - y * v - z * w) / width
                # exp(−step²) = 2^(whole / 32 + rest), as glibc computes it; beyond 87 nothing is left of it
                power = LOG2E_32 * np.float64(-min(step * step, FARTHEST))
                whole = (power + ROUNDED) - ROUNDED
                rest, code = power - whole, np.int32(-whole)
                scale = ROOTS[np.uint32(code & 31)] * POWERS[np.uint32(code >> 5)]
                near = (EXP2[0] * rest + EXP2[1]) * (rest * rest) + (EXP2[2] * rest + 1.0)
                is_blank = x * x + y * y + z * z == none
                weight = block[i + 9 * BLOCK] * (one if is_blank else np.float32(near * scale))
                block[i + 3 * BLOCK] += weight * u
                block[i + 4 * BLOCK] += weight * v
                block[i + 5 * BLOCK] += weight * w
        for i in range(n):
            x, y, z = block[i + 3 * BLOCK], block[i + 4 * BLOCK], block[i + 5 * BLOCK]
            length = np.sqrt(x * x + y * y + z * z)
            by = length if length > none else one
            block[i + 3 * BLOCK] = x / by if length > none else block[i]
            block[i + 4 * BLOCK] = y / by if length > none else block[i + BLOCK]
            block[i + 5 * BLOCK] = z / by if length > none else block[i + 2 * BLOCK]
        if change != one:
            for i in range(n):
                for axis in range(3):
                    block[i + (6 + axis) * BLOCK] = there[first + i, axis]
            for i in range(n):
                x, y, z = block[i], block[i + BLOCK], block[i + 2 * BLOCK]
                u = last * x + before * block[i + 6 * BLOCK] + change * (block[i + 3 * BLOCK] - x)
                v = last * y + before * block[i + 7 * BLOCK] + change * (block[i + 4 * BLOCK] - y)
                w = last * z + before * block[i + 8 * BLOCK] + change * (block[i + 5 * BLOCK] - z)
                length = np.sqrt(u * u + v * v + w * w)
                by = length if length > none else one
                block[i + 3 * BLOCK], block[i + 4 * BLOCK], block[i + 5 * BLOCK] = u / by, v / by, w / by
        for i in range(n):
            for axis in range(3):
                there[first + i, axis] = block[i + (3 + axis) * BLOCK]
