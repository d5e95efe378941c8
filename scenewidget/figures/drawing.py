"""A mesh and what is said about it, as coloured triangles with the light baked in.

Goes in: a mesh with labels, numbers, vectors, marked points. Comes out: a `Drawing`, plain arrays that the
browser and the rasteriser both draw as they are. Meshes with many faces are drawn simplified.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.preprocess import simplify
from scenewidget.figures.scale import ColorArray, ColorScale, color_scale
from scenewidget.figures.strokes import edge_segments, isoline_segments, markers, needles, ribbons
from scenewidget.palette import label_rows, palette

__all__ = [
    "Drawing",
    "at_most",
    "checked_labels",
    "corner_normals",
    "draw",
    "label_colors",
    "nearest_vertices",
]

PLAIN = (205, 200, 190)
UNLABELED = (215, 215, 212)  # paler than on the screen, since figures stand on white pages
INK = (45, 45, 50)
ARROW = (200, 60, 30)
MARK = (230, 50, 20)
MARK_SIZE = 0.022  # radius of a mark, of the diagonal of the mesh
LIGHT = np.array([0.20, -0.62, 0.76])  # points towards the light
DARKEST = 0.62  # a face turned away from the light keeps this share of its colour
LINE_WIDTH = 0.0022  # as a share of the diagonal of the bounding box
MOST_VECTORS = 2_000
DISC = 2.0  # areas of a point: square of the reach of the triangle that it is drawn as

_simplified: weakref.WeakKeyDictionary[Mesh, dict[int, tuple[Mesh, IntArray]]] = weakref.WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Drawing:
    """Triangles to be drawn as they are, without further light.

    Attributes
    ----------
    corners : (n_triangles, 3, 3) float32
        Metres, around the middle of the mesh; the surface first, then what is drawn on it.
    colors : (n_triangles, 3, 3) uint8
        sRGB of each corner.
    n_surface : int
        Triangles that are the surface itself.
    hides_back : bool
        Leave out triangles seen from behind, so that one looks into a room from outside.
    title : str
    scale : ColorScale or None
        What the colours mean, if they are numbers.
    note : str
        What a reader should know, such as that the mesh is drawn simplified.
    faces : (n_surface, 3) int or None
        Numbers of the points at the surface's corners, where all corners at a point have one colour: a
        sixth of the numbers says it all then.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> drawing = draw(mesh)
    >>> drawing.corners.shape, drawing.colors.dtype
    ((8, 3, 3), dtype('uint8'))
    """

    corners: npt.NDArray[np.float32]
    colors: ColorArray
    n_surface: int
    hides_back: bool
    title: str = ""
    scale: ColorScale | None = None
    note: str = ""
    faces: IntArray | None = None

    def __repr__(self) -> str:
        return f"Drawing({self.n_surface} faces)"


def draw(
    mesh: Mesh,
    labels: Any = None,
    values: npt.ArrayLike | None = None,
    vectors: npt.ArrayLike | None = None,
    *,
    colors: npt.ArrayLike | None = None,
    points: npt.ArrayLike | None = None,
    title: str = "",
    scale_title: str = "",
    colormap: str | None = None,
    low: float | None = None,
    high: float | None = None,
    isolines: int = 0,
    edges: bool = False,
    smooth: bool | None = None,
    scan_colors: bool = True,
    back_faces: bool | None = None,
    vector_length: float | None = None,
    max_faces: int = 30_000,
    middle: FloatArray | None = None,
) -> Drawing:
    """The drawing that `show` shows; parameters as there, and ``middle``: what becomes the origin.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> draw(mesh, labels=[0, 0, 0, 0, 1, 1, 1, 1], title="halves")
    Drawing(8 faces)
    """
    if not isinstance(mesh, Mesh):
        raise TypeError(f"mesh must be a Mesh, got {type(mesh).__name__}; load_mesh(mesh) makes one")
    if sum(given is not None for given in (labels, values, colors)) > 1:
        raise ValueError("a face has one colour: give labels, values or colors, one of them")
    labels = None if labels is None else checked_labels(mesh, labels)
    numbers = None if values is None else _checked_rows(mesh, "values", values, ())
    arrows = None if vectors is None else _checked_rows(mesh, "vectors", vectors, (3,))
    rgb = None if colors is None else _checked_rows(mesh, "colors", colors, (3,))
    marked = np.zeros(0, np.intp) if points is None else _checked_points(mesh, points)

    if mesh.is_cloud and (edges or isolines):
        raise ValueError("edges and isolines are drawn along faces, and a cloud has none")

    drawn, source = at_most(mesh, max_faces)
    faces = drawn.faces
    corners = _discs(drawn) if isinstance(drawn, PointCloud) else drawn.vertices[faces]
    low_end, high_end = (end(corners, axis=(0, 1)) for end in (np.min, np.max))
    middle = (low_end + high_end) / 2 if middle is None else middle
    diagonal = float(np.linalg.norm(high_end - low_end)) or 1.0
    corners = corners - middle

    if smooth is None:
        smooth = numbers is not None and len(numbers) == mesh.n_vertices and not mesh.is_cloud
    scale = None
    at_corners = at_points = None
    paint: ColorArray | FloatArray
    if labels is not None:
        paint = label_colors(labels, label_rows(mesh, labels))[source][:, None].repeat(3, axis=1)
    elif rgb is not None:
        paint = _corner_rows(mesh, drawn, source, rgb)
    elif numbers is not None:
        scale = color_scale(numbers, colormap=colormap, low=low, high=high, title=scale_title)
        if smooth and len(numbers) == mesh.n_vertices:
            at_points = numbers[nearest_vertices(mesh, drawn)]
            at_corners = at_points[faces]
        else:
            at_corners = _corner_rows(mesh, drawn, source, numbers)
        paint = scale.colors(at_corners if at_points is None else at_points)
    elif scan_colors and mesh.vertex_colors is not None:
        paint = mesh.vertex_colors[nearest_vertices(mesh, drawn)[faces]]
    else:
        paint = np.tile(np.array(PLAIN, np.uint8), (len(faces), 3, 1))

    hides_back = _is_room(mesh) if back_faces is None else not back_faces
    if at_points is None:
        surface = lit(paint, corner_normals(corners, faces, smooth=smooth))
    else:
        surface = lit(paint, _point_normals(corners, faces, drawn.n_vertices))[faces]
    layers = [(corners, surface)]
    width = LINE_WIDTH * diagonal
    if edges:
        segments = edge_segments(faces, corners)
        typical = float(np.median(np.linalg.norm(segments[0][:, 1] - segments[0][:, 0], axis=1)))
        thin = float(np.clip(0.03 * typical, 0.6 * width, 2.0 * width))
        strips = ribbons(segments, drawn.face_normals, thin, both_sides=not hides_back)
        layers.append((strips, _flat(strips, INK)))
    if isolines and at_corners is not None and scale is not None:
        levels = np.linspace(scale.low, scale.high, isolines + 2)[1:-1]
        strips = ribbons(
            isoline_segments(corners, at_corners, levels),
            drawn.face_normals,
            width,
            both_sides=not hides_back,
        )
        layers.append((strips, _flat(strips, INK)))
    note = (
        ""
        if drawn is mesh
        else f"drawn with {drawn.n_faces:,} of {mesh.n_faces:,} {mesh.noun}s".replace(",", "\u2009")
    )
    if arrows is not None:
        needle, is_thinned = _arrows(mesh, arrows, middle, diagonal, vector_length)
        layers.append((needle, lit(_flat(needle, ARROW), corner_normals(needle, None, smooth=False))))
        if is_thinned:
            note += f"{'; ' if note else ''}{MOST_VECTORS} of {len(arrows)} arrows"
    if len(marked):
        octahedra = markers(mesh.vertices[marked] - middle, MARK_SIZE * diagonal)
        layers.append((octahedra, lit(_flat(octahedra, MARK), corner_normals(octahedra, None, smooth=False))))
    return Drawing(
        np.concatenate([layer for layer, _ in layers]).astype(np.float32),
        np.concatenate([color for _, color in layers]),
        len(faces),
        hides_back,
        title,
        scale,
        note,
        None if at_points is None else faces,
    )


def _discs(cloud: PointCloud) -> FloatArray:
    """(n_points, 3, 3) corners of a triangle at each point, in its plane, reaching to what is around it."""
    normal = cloud.face_normals
    normal = np.where(np.abs(normal).sum(axis=1, keepdims=True) > 0, normal, (0.0, 0.0, 1.0))
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin(axis=1)])
    reach = np.sqrt(DISC * np.maximum(cloud.face_areas, 1e-12))
    across *= (reach / np.linalg.norm(across, axis=1))[:, None]
    up = np.cross(normal, across)
    turns = [(np.cos(angle), np.sin(angle)) for angle in (0.0, 2 * np.pi / 3, 4 * np.pi / 3)]
    return np.stack([cloud.points + c * across + s * up for c, s in turns], axis=1)


def lit(colors: ColorArray | FloatArray, normals: FloatArray) -> ColorArray:
    """Colours under a light from the upper left front; what is turned away stays readable.

    Examples
    --------
    >>> import numpy as np
    >>> lit(np.array([[200, 200, 200]]), np.array([[0.0, 0.0, 1.0]]))
    array([[191, 191, 191]], dtype=uint8)
    """
    facing = normals @ (LIGHT / np.linalg.norm(LIGHT))
    share = DARKEST + (1 - DARKEST) * (0.5 + 0.5 * facing)
    shaded: ColorArray = np.round(colors * share[..., None]).astype(np.uint8)
    return shaded


def corner_normals(corners: FloatArray, faces: IntArray | None, *, smooth: bool) -> FloatArray:
    """(n_triangles, 3, 3) unit normal at each corner: the triangle's, or the mean at its vertex by area.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> corner_normals(mesh.vertices[mesh.faces], mesh.faces, smooth=False)[0, 0]
    array([0., 0., 1.])
    """
    if smooth and faces is not None:
        return _point_normals(corners, faces, int(faces.max()) + 1)[faces]
    return np.repeat(_unit(_twice_the_area(corners))[:, None], 3, axis=1)


def _point_normals(corners: FloatArray, faces: IntArray, n: int) -> FloatArray:
    """(n, 3) unit normal at each point, the mean of its triangles' by area."""
    across = _twice_the_area(corners)
    return _unit(np.stack([np.bincount(faces.ravel(), np.repeat(part, 3), n) for part in across.T], axis=1))


def _twice_the_area(corners: FloatArray) -> FloatArray:
    """(n_triangles, 3) normals as long as twice the area."""
    across: FloatArray = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return across


def _unit(vectors: FloatArray) -> FloatArray:
    """Of length 1; 0 stays 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: FloatArray = np.divide(vectors, length, out=np.zeros(vectors.shape), where=length > 0)
    return unit


# --- what was given ---------------------------------------------------------------------------------


def checked_labels(mesh: Mesh, labels: Any, name: str = "labels") -> IntArray:
    """Labels of an array or a Segmentation, checked and made dense.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> checked_labels(mesh, [7, 7, 7, 7, 9, 9, -5, -5])
    array([ 0,  0,  0,  0,  1,  1, -1, -1])
    """
    array = np.asarray(getattr(labels, "labels", labels))
    if array.shape != (mesh.n_faces,):
        raise ValueError(f"{name} must have shape ({mesh.n_faces},), one a face, got {array.shape}")
    if array.dtype.kind not in "iub":
        raise TypeError(f"{name} must hold whole numbers, got dtype {array.dtype}")
    return _dense(array.astype(np.int64))


def _checked_rows(mesh: Mesh, name: str, rows: npt.ArrayLike, tail: tuple[int, ...]) -> FloatArray:
    array = np.asarray(rows, np.float64)
    fits = [(count, *tail) for count in (mesh.n_vertices, mesh.n_faces)]
    if array.shape not in fits:
        raise ValueError(
            f"{name} must have shape {fits[0]}, a row a vertex, or {fits[1]}, a row a face, got {array.shape}"
        )
    return array


def _checked_points(mesh: Mesh, points: npt.ArrayLike) -> IntArray:
    array = np.atleast_1d(np.asarray(points))
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise TypeError(f"points must be vertex numbers, got {points!r}")
    if array.size and not (array.min() >= 0 and array.max() < mesh.n_vertices):
        raise ValueError(
            f"points must lie in 0..{mesh.n_vertices - 1}, the vertices of the mesh, got {points!r}"
        )
    return array


# --- from the mesh to what is drawn of it --------------------------------------------------------------


def at_most(mesh: Mesh, max_faces: int) -> tuple[Mesh, IntArray]:
    """The mesh with at most about that many faces, and a face of the given mesh for each of its faces.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> ball = analytic.sphere(3)
    >>> small, source = at_most(ball, 300)
    >>> ball.n_faces, small.n_faces, source.shape
    (1280, 300, (300,))
    """
    if mesh.n_faces <= max_faces:
        return mesh, np.arange(mesh.n_faces)
    known = _simplified.setdefault(mesh, {})
    if max_faces not in known:
        small = simplify(
            mesh, n_faces=max_faces, coverage=1.0, smallest=5 / mesh.n_faces, smallest_simplified=0.0
        ).mesh
        nearest = cKDTree(mesh.face_centroids).query(small.face_centroids)[1]
        known[max_faces] = small, nearest
    return known[max_faces]


def nearest_vertices(mesh: Mesh, drawn: Mesh) -> IntArray:
    """(drawn.n_vertices,) nearest vertex of the given mesh.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> nearest_vertices(mesh, mesh)
    array([0, 1, 2, 3, 4, 5, 6, 7, 8])
    """
    if drawn is mesh:
        return np.arange(mesh.n_vertices)
    nearest: IntArray = cKDTree(mesh.vertices).query(drawn.vertices)[1]
    return nearest


def _corner_rows(mesh: Mesh, drawn: Mesh, source: IntArray, rows: FloatArray) -> FloatArray:
    if len(rows) == mesh.n_vertices:
        return rows[nearest_vertices(mesh, drawn)[drawn.faces]]
    return rows[source][:, None].repeat(3, axis=1)


def label_colors(labels: IntArray, rows: IntArray) -> ColorArray:
    """(n_faces, 3) colours of the palette; grey where a label is negative.

    Examples
    --------
    >>> import numpy as np
    >>> label_colors(np.array([0, -1]), np.array([5]))
    array([[167, 209, 166],
           [215, 215, 212]], dtype=uint8)
    """
    table = np.concatenate([palette()[rows], [UNLABELED]])  # the last is for labels of -1
    colors: ColorArray = table[labels].astype(np.uint8)
    return colors


def _dense(labels: IntArray) -> IntArray:
    """Labels numbered from 0 without gaps, in their order; negative ones become -1."""
    used, compact = np.unique(labels, return_inverse=True)
    return np.maximum(compact.ravel() - int((used < 0).sum()), -1)


def _is_room(mesh: Mesh) -> bool:
    """Whether most of the surface faces the middle, as in a room seen from inside."""
    inward = np.einsum("ij,ij->i", mesh.face_vectors, mesh.face_centroids.mean(axis=0) - mesh.face_centroids)
    return bool(inward.sum() > 0.25 * np.abs(inward).sum())


def _arrows(
    mesh: Mesh, vectors: FloatArray, middle: FloatArray, diagonal: float, length: float | None
) -> tuple[FloatArray, bool]:
    """Needles, the longest but a hundredth of them at most a twelfth of the diagonal long."""
    starts = (mesh.vertices if len(vectors) == mesh.n_vertices else mesh.face_centroids) - middle
    sizes = np.linalg.norm(vectors, axis=1)
    longest = float(np.quantile(sizes[sizes > 0], 0.99)) if (sizes > 0).any() else 1.0
    scale = diagonal / 12 / longest if length is None else length
    is_thinned = len(vectors) > MOST_VECTORS
    keep = np.linspace(0, len(vectors) - 1, MOST_VECTORS).astype(np.intp) if is_thinned else slice(None)
    return needles(starts[keep], scale * vectors[keep], 0.004 * diagonal), is_thinned


def _flat(triangles: FloatArray, color: tuple[int, int, int]) -> ColorArray:
    return np.tile(np.array(color, np.uint8), (len(triangles), 3, 1))
