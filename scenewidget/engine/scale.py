"""How large a scene is, in what order geometry puts its faces, and what is a scene of its own.

Goes in: a mesh. Come out: metres in a unit of the scene, axes and an order of the faces that don't depend on
the file, and which faces are so far from each other that they are different scenes. A table top is to its
cups what a room is to its furniture: the method looks at it through the same thresholds, only smaller.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import (
    FloatArray,
    IntArray,
    Mesh,
    ascending,
    connected_components,
    ties,
    unique_codes,
)
from scenewidget.engine.threads import at_once, by_parts, one_blas_thread, parts

__all__ = ["far_apart", "geometric_order", "own_frame", "principal_axes", "scene_scale"]

ROOM_AREA = 20.0  # m² of surface: of a room at least
ROOM_LENGTH, ROOM_HEIGHT = 4.8, 2.5  # m
ALIKE = 1e-4  # Two axes along which a scene's spread differs by less of the whole are no axes of its own.
STEPS = 2**20  # places told apart along a scene: far finer than a scan is, far coarser than rounding


def scene_scale(mesh: Mesh, frame: FloatArray | None = None) -> float:
    """Metres in a unit of a scene: 1 for rooms and flats, less for what is smaller, more for halls.

    s = min(√(area / 20 m²), median(1, length / 4.8 m, height / 2.5 m)): a scene is smaller than a room where
    it is both shorter and lower than one, or has less surface; and larger where it is both longer and higher,
    as a hall is, but not a flat. Lengths in `Params` count in units of s, areas in units of s².

    Length and height are the longest and the shortest side of the scene along its `own_frame`, without the
    outermost hundredth of its surface on either side.

    Parameters
    ----------
    mesh : Mesh
        Without any surface the unit is a metre.
    frame : (3, 3) float, optional
        `own_frame` of the mesh, where the caller has it already.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.mesh import Mesh
    >>> from scenewidget.engine.scale import scene_scale
    >>> floor = square(10)  # of a metre
    >>> round(scene_scale(floor), 2), scene_scale(Mesh(5 * floor.vertices, floor.faces))
    (0.22, 1.0)
    """
    area = float(mesh.face_areas.sum())
    if not area > 0:
        return 1.0
    axes = own_frame(mesh.face_centroids, mesh.face_areas) if frame is None else frame
    weights = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas, 3), mesh.n_vertices).astype(float)
    with one_blas_thread():
        length, height = at_once(*(partial(_side, mesh.vertices @ axes[:, i], weights) for i in (0, 2)))
    of_a_room = float(np.median([1.0, length / ROOM_LENGTH, height / ROOM_HEIGHT]))
    return min(float(np.sqrt(area / ROOM_AREA)), of_a_room)


def _side(places: FloatArray, weights: FloatArray) -> float:
    """How far apart places on a line are, without the outermost hundredth of the weights on either side."""
    low, high, n_steps = float(places.min()), float(places.max()), 4096
    for _ in range(4):  # closer each time: a stray vertex may be far off
        step = max(high - low, 1e-300) / n_steps
        steps = np.clip((places - low) / step, 0, n_steps - 1).astype(np.int64)
        share = np.cumsum(np.bincount(steps, weights, n_steps))
        first, last = np.searchsorted(share / share[-1], [0.01, 0.99])
        low, high = low + float(first) * step, low + float(last + 1) * step
    return high - low


def own_frame(points: FloatArray, weights: FloatArray) -> FloatArray:
    """The axes of a scene, whatever those of its file.

    They are its `principal_axes`; where two of these are alike, as those of a cube or a ball, the file's.

    Parameters
    ----------
    points : (n, 3) float
    weights : (n,) float
        Areas.

    Returns
    -------
    axes : (3, 3) float64
        Columns, the longest axis first: ``points @ axes``.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.scale import own_frame
    >>> points = np.array([[0.0, 0, 0], [0, 5, 0], [0, 0, 2], [1, 0, 0]])
    >>> turned = points[:, [2, 0, 1]]
    >>> np.allclose(points @ own_frame(points, np.ones(4)), turned @ own_frame(turned, np.ones(4)))
    True
    """
    axes, spread = principal_axes(points, weights)
    return axes if np.diff(-spread).min() > ALIKE * spread.sum() else np.eye(3)


def principal_axes(points: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Along which points are spread most, next and least, and how much.

    Each axis looks to the side on which there is something farther off, by the third moment; where no side
    has it, along the file's axis nearest to it. The order of the points changes nothing.

    Parameters
    ----------
    points : (n, 3) float
    weights : (n,) float

    Returns
    -------
    axes : (3, 3) float64
        Columns, unit.
    spread : (3,) float64
        Mean square distance from the middle along each.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.scale import principal_axes
    >>> axes, spread = principal_axes(np.array([[0.0, 0, 0], [0, -5, 0], [1, 0, 0]]), np.ones(3))
    >>> (axes[:, 0].round(1) + 0.0).tolist(), spread.round(1).tolist()
    ([-0.1, -1.0, 0.0], [5.6, 0.2, 0.0])
    """
    n = len(points)
    share = weights / max(float(_sums(lambda rows: weights[None, rows], n)[0]), 1e-300)

    def columns(rows: slice) -> FloatArray:  # one after the other, which is several times as fast
        return np.ascontiguousarray(points[rows].T)

    middle = _sums(lambda rows: columns(rows) * share[rows], n)

    def products(rows: slice) -> FloatArray:
        x, y, z = columns(rows) - middle[:, None]
        out = np.empty((6, len(x)))
        for product, (one, other) in zip(out, ((x, x), (x, y), (x, z), (y, y), (y, z), (z, z))):
            np.multiply(one, other, out=product)
        out *= share[rows]
        return out

    values, axes = np.linalg.eigh(_sums(products, n)[[[0, 1, 2], [1, 3, 4], [2, 4, 5]]])
    values, axes = np.maximum(values[::-1], 0.0), axes[:, ::-1]

    def cubes(rows: slice) -> FloatArray:
        along = np.ascontiguousarray(((points[rows] - middle) @ axes).T)
        return np.asarray(share[rows] * along * along * along)

    with one_blas_thread():
        skew = _sums(cubes, n)
    nearest = axes[np.abs(axes).argmax(axis=0), range(3)]
    is_known = np.abs(skew) > ALIKE * float(values.sum()) ** 1.5
    return axes * np.where(np.where(is_known, skew, nearest) < 0, -1.0, 1.0), values


def turned(points: FloatArray, axes: FloatArray) -> FloatArray:
    """``points @ axes`` without BLAS' threads, which wait for each other longer than they compute.

    Parameters
    ----------
    points : (n, 3) float64
    axes : (3, 3) float64

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.scale import turned
    >>> turned(np.array([[1.0, 2.0, 3.0]]), np.eye(3)).tolist()
    [[1.0, 2.0, 3.0]]
    """
    out = np.empty((len(points), 3))
    with one_blas_thread():
        by_parts(lambda rows: np.matmul(points[rows], axes, out=out[rows]), len(points))
    return out


def _sums(rows_of: Callable[[slice], FloatArray], n: int) -> FloatArray:
    """(n_rows,) sum of each row, so exact that the order of what is in it doesn't show; made part by part."""
    total = np.zeros((2, len(rows_of(slice(0, 0)))))
    for part in parts(n):
        rows = np.ascontiguousarray(rows_of(part), dtype=np.float64).view()
        rows.flags.writeable = False  # of one kind: it compiles once
        _add(rows, total)
    return np.asarray(total.sum(axis=0))


@kernel
def _add(rows, total):  # type: ignore[no-untyped-def]
    """Sums and what they were rounded by (Knuth's two-sum), both added to ``total``."""
    for i in range(rows.shape[1]):
        for k in range(rows.shape[0]):  # several rows at a time: each addition waits for the last of its row
            x, high = rows[k, i], total[0, k]
            both = high + x
            part = both - high
            total[1, k] += (high - (both - part)) + (x - part)
            total[0, k] = both


def geometric_order(mesh: Mesh, frame: FloatArray | None = None) -> IntArray:
    """(n_faces,) faces by the places of their corners, whatever their order in the file and its axes.

    Two files of one mesh whose faces or vertices are numbered differently, or one of which is turned, give
    the same sequence of triangles, so that what is computed along it is the same: to the last bit where
    nothing is turned.

    Parameters
    ----------
    mesh : Mesh
    frame : (3, 3) float, optional
        `own_frame` of the mesh, where the caller has it already.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.engine.scale import geometric_order
    >>> vertices = [[5, 0, 0], [6, 0, 0], [5, 1, 0], [0, 0, 0], [1, 0, 0], [0, 3, 0]]
    >>> mesh = sw.Mesh(vertices, [[0, 1, 2], [3, 4, 5]])
    >>> turned = sw.Mesh(mesh.vertices[:, [1, 2, 0]], mesh.faces)
    >>> geometric_order(mesh).tolist() == geometric_order(turned).tolist()
    True
    """
    axes = own_frame(mesh.face_centroids, mesh.face_areas) if frame is None else frame
    along = turned(mesh.vertices, axes)
    along -= [min(0.0, float(x.min(initial=0.0))) for x in along.T]
    step = max(float(along.max(initial=0.0)) / STEPS, 1e-300)
    code = np.empty(mesh.n_vertices, dtype=np.int64)

    def codes(rows: slice) -> None:
        x, y, z = np.round(along[rows] / step).astype(np.int64).T
        code[rows] = (x << 42) | (y << 21) | z

    by_parts(codes, mesh.n_vertices)
    order = np.argsort(code)
    code = code[order]
    tied, tie = ties(code)  # mostly corners at one place
    order[tied] = order[tied][np.lexsort((*mesh.vertices[order[tied]].T, tie))]
    is_new = code[1:] != code[:-1]
    same = np.flatnonzero(~is_new)
    is_new[same] = np.any(mesh.vertices[order[same + 1]] != mesh.vertices[order[same]], axis=1)
    place = np.empty(mesh.n_vertices, dtype=np.int64)
    place[order] = np.concatenate([[0], np.cumsum(is_new)])
    if mesh.is_cloud:
        return ascending(place).astype(np.int32)
    n, corners = mesh.n_vertices, np.empty((2, mesh.n_faces), dtype=np.int64)

    def sorted_corners(rows: slice) -> None:
        a, b, c = (np.take(place, side) for side in mesh.faces[rows].T)  # whichever corner a face begins with
        low, high = np.minimum(a, b), np.maximum(a, b)
        second = np.maximum(low, np.minimum(high, c))
        corners[0, rows] = np.minimum(low, c) * n + second
        corners[1, rows] = np.maximum(high, c)

    by_parts(sorted_corners, mesh.n_faces)
    edge, third = corners
    if n < 2_000_000:
        return ascending(edge * n + third).astype(np.int32)
    order = np.argsort(edge)
    tied, tie = ties(edge[order])
    order[tied] = order[tied][np.lexsort((order[tied], third[order[tied]], tie))]
    return order.astype(np.int32)


def far_apart(mesh: Mesh, pairs: IntArray, gap: float) -> IntArray:
    """(n_faces,) int32 scene of each face: faces are in one where a chain of steps up to ``gap`` joins them.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int
        Adjacent faces.
    gap : float
        Metres between centroids of faces.

    Returns
    -------
    scene : (n_faces,) int32
        Numbered by area, the largest first.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> from scenewidget.engine.scale import far_apart
    >>> near, far = square(2).vertices, square(2).vertices + 5.0
    >>> mesh = sw.Mesh([*near, *far], [*square(2).faces, *(square(2).faces + 9)])
    >>> far_apart(mesh, face_adjacency(mesh), gap=1.0).tolist()
    [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1]
    """
    n, component = connected_components(mesh.n_faces, pairs)
    if n > 1:
        size, low = gap / 4, mesh.bounds[0]
        deep, wide, high = (
            _cells(np.array([x.max() for x in mesh.face_centroids.T]), low, size) + 1
        ).tolist()
        code = np.empty(mesh.n_faces, dtype=np.int64)

        def codes_of(rows: slice) -> None:
            x, y, z = _cells(mesh.face_centroids[rows], low, size).T
            code[rows] = (x * wide + y) * high + z

        by_parts(codes_of, mesh.n_faces)
        codes, where = unique_codes(code, deep * wide * high)
        near = cKDTree(_centers(mesh, where, len(codes))).query_pairs(gap, output_type="ndarray")
        # components, then cells, which hold what is nearer than the gap: one graph of both
        is_new = (component[1:] != component[:-1]) | (where[1:] != where[:-1])
        is_new = np.concatenate([[True], is_new])  # most faces follow one of the same cell
        links = np.concatenate([np.stack([component[is_new], n + where[is_new]], axis=1), n + near])
        component = connected_components(n + len(codes), links)[1][component]
        n = int(component.max()) + 1
    area = np.bincount(component, mesh.face_areas, n)
    rank = np.empty(n, dtype=np.int32)
    rank[np.argsort(-area, kind="stable")] = np.arange(n, dtype=np.int32)
    return rank[component]


def _cells(places: FloatArray, low: FloatArray, size: float) -> IntArray:
    cells: IntArray = np.floor((places - low) / size).astype(np.int64)
    return cells


def _centers(mesh: Mesh, where: IntArray, n: int) -> FloatArray:
    """(n, 3) mean of the centroids of the faces in each cell."""
    count = np.bincount(where, minlength=n)
    return np.stack([np.bincount(where, x, n) / count for x in mesh.face_centroids.T], axis=1)
