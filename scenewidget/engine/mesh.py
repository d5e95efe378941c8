"""The triangle mesh that everything starts from: what it holds, and what is next to what.

Go in: arrays. Comes out: a checked, read-only `Mesh` and its plain geometry (areas, normals, face
adjacency, connected components). `scenewidget.engine.readers` makes one of a file.
"""

from __future__ import annotations

import importlib
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np
import numpy.typing as npt

from scenewidget.engine.kernels import kernel
from scenewidget.engine.threads import by_parts

__all__ = [
    "BoolArray",
    "FloatArray",
    "IntArray",
    "Mesh",
    "MeshError",
    "connected_components",
    "face_adjacency",
    "neighbor_table",
    "shared_edge_lengths",
]

FloatArray = npt.NDArray[np.floating[Any]]
IntArray = npt.NDArray[np.integer[Any]]
BoolArray = npt.NDArray[np.bool_]

Number = TypeVar("Number", bound=np.generic)

MAX_FAN = 8  # faces at one edge up to which every two of them count as adjacent
LARGEST = 1e15  # metres: fourth powers of lengths (second moments) stay far from overflow


class MeshError(ValueError):
    """Geometry that can't be worked with: no faces, indices out of range, NaN vertices, a truncated file.

    Examples
    --------
    >>> import scenewidget as sw
    >>> sw.Mesh([[0, 0, 0]], [])
    Traceback (most recent call last):
        ...
    scenewidget.engine.mesh.MeshError: faces is empty: a mesh needs at least one triangle ...
    """


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over vertices; arrays are copied, checked and made read-only.

    Faces are kept exactly as they came (order, duplicates, degenerate ones), so that a label per face
    means the same face to the caller as to us.

    Parameters
    ----------
    vertices : (n_vertices, 3) float64
        Positions in metres.
    faces : (n_faces, 3) int32
        Vertex indices, counter-clockwise seen from the side that the normal points to.
    vertex_colors : (n_vertices, 3) uint8, optional
        Red, green, blue as scanned.
    source : str
        The file that it was loaded from, "" if from none.
    faces_of_file : (n_faces,) int32, optional
        Which face of the file each face came from, where polygons were cut or faces dropped; None where
        face i is face i of the file.
    n_file_faces : int, optional
        Number of faces of the file; as many as faces by default.
    report : tuple of str
        What was repaired, dropped or guessed when it was read, one line each.

    Raises
    ------
    MeshError
        No faces, an index out of range, or a vertex in use that is NaN or infinite.
    TypeError
        Arrays that don't hold numbers.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh = sw.Mesh([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> mesh.face_areas.tolist(), mesh.face_normals.tolist()
    ([6.0], [[0.0, 0.0, 1.0]])
    """

    vertices: FloatArray
    faces: IntArray
    vertex_colors: npt.NDArray[np.uint8] | None = None
    source: str = ""
    faces_of_file: IntArray | None = None
    n_file_faces: int = 0
    report: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        vertices = _number_array("vertices", self.vertices)
        faces = _number_array("faces", self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise MeshError(f"vertices must have shape (n_vertices, 3), got {vertices.shape}")
        if faces.size == 0:
            raise MeshError("faces is empty: a mesh needs at least one triangle (a point cloud has none)")
        if faces.ndim != 2 or faces.shape[1] != 3:
            raise MeshError(
                f"faces must have shape (n_faces, 3), got {faces.shape}; split polygons into triangles first"
            )
        if faces.dtype.kind == "f" and not np.array_equal(faces, np.floor(faces)):
            raise TypeError(f"faces must hold whole numbers, got dtype {faces.dtype}")
        lowest, highest = faces.min(), faces.max()
        if lowest < 0 or highest >= len(vertices):
            row = int(np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))[0])
            raise MeshError(
                f"faces[{row}] = {faces[row].tolist()} refers to a vertex that does not exist: "
                f"there are {len(vertices)} vertices, numbered from 0"
            )
        vertices = np.array(vertices, dtype=np.float64, order="C")
        faces = np.array(faces, dtype=np.int32, order="C")
        if not np.isfinite(vertices).all():
            bad = ~np.isfinite(vertices).all(axis=1)
            is_used = bad[faces].any(axis=1)
            if is_used.any():
                row = int(np.flatnonzero(is_used)[0])
                raise MeshError(
                    f"vertices has NaN or infinite positions in {int(bad.sum())} rows, and "
                    f"{int(is_used.sum())} faces use them (first: faces[{row}]); drop those faces, for "
                    "example faces[np.isfinite(vertices)[faces].all(axis=(1, 2))]"
                )
            vertices[bad] = 0.0
        if not np.abs(vertices).max() <= LARGEST:
            raise MeshError(
                f"vertices reach {np.abs(vertices).max():.3g} metres from the origin, and at most "
                f"{LARGEST:.0e} can be worked with; scale the mesh to metres and move it near the origin"
            )
        for array in (vertices, faces):
            array.flags.writeable = False
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)
        if self.vertex_colors is not None:
            object.__setattr__(self, "vertex_colors", _color_array(self.vertex_colors, len(vertices)))
        object.__setattr__(self, "report", tuple(self.report))
        object.__setattr__(self, "n_file_faces", self.n_file_faces or len(faces))
        if self.faces_of_file is not None:
            origin = _number_array("faces_of_file", self.faces_of_file)
            if origin.shape != (len(faces),):
                raise MeshError(
                    f"faces_of_file must have one entry a face: ({len(faces)},), got {origin.shape}"
                )
            object.__setattr__(self, "faces_of_file", read_only(np.array(origin, dtype=np.int32)))

    def seam_lengths(self, pairs: IntArray) -> FloatArray:
        """(n_pairs,) length of the edge that two faces share, metres; 0 where they share none.

        Parameters
        ----------
        pairs : (n_pairs, 2) int
            Faces.
        """
        return shared_edge_lengths(self, pairs)

    is_cloud: ClassVar[bool] = False
    """Whether faces are points; see `engine.clouds.PointCloud`."""
    noun: ClassVar[str] = "face"
    """What people call a face: of a cloud, a point."""

    def __repr__(self) -> str:
        colors = "" if self.vertex_colors is None else ", coloured"
        return f"Mesh({self.n_vertices} vertices, {self.n_faces} faces{colors})"

    @property
    def n_vertices(self) -> int:
        """Number of vertices, unused ones included."""
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        """Number of triangles."""
        return len(self.faces)

    def chosen(self, faces: IntArray) -> Mesh:
        """Some of the faces, or all in another order, over the same vertices.

        Parameters
        ----------
        faces : (n,) int
        """
        chosen = object.__new__(Mesh)  # all has been checked
        rows = read_only(taken(self.faces, faces))
        vars(chosen).update(
            vertices=self.vertices, faces=rows, vertex_colors=self.vertex_colors, n_file_faces=len(rows)
        )
        for name in ("face_vectors", "face_areas", "face_normals", "face_centroids"):
            if name in vars(self):  # what is known of the faces need not be computed again
                vars(chosen)[name] = read_only(taken(vars(self)[name], faces))
        return chosen

    def part(self, faces: IntArray) -> Mesh:
        """Some of the faces, in their order, with the vertices that they use and their colours.

        Parameters
        ----------
        faces : (n,) int
        """
        used, corners = np.unique(self.faces[faces], return_inverse=True)
        colors = None if self.vertex_colors is None else self.vertex_colors[used]
        return Mesh(self.vertices[used], corners.reshape(-1, 3), colors)

    @cached_property
    def _adjacency(self) -> IntArray:
        return read_only(_shared_edges(self))

    @cached_property
    def _welded(self) -> IntArray:
        return read_only(_welded(self))

    @cached_property
    def _close_borders(self) -> dict[float, IntArray]:
        """Found so far, by scale of the scene; `pieces.close_borders` fills it."""
        return {}

    @cached_property
    def _large_axes(self) -> list[Any]:
        """Found so far, none or one list of them; `gravity.large_axes` fills it."""
        return []

    @cached_property
    def _smoothed_faces(self) -> list[Any]:
        """Some faces with smoothed normals, found so far, none or one; `gravity` fills it."""
        return []

    @cached_property
    def is_used(self) -> BoolArray:
        """(n_vertices,) whether a face has the vertex; others may lie anywhere."""
        is_used = np.zeros(self.n_vertices, dtype=np.bool_)
        is_used[self.faces] = True
        is_used.flags.writeable = False
        return is_used

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, 3) least and most of the coordinates of vertices in use, metres."""
        used = self.vertices if self.is_used.all() else self.vertices[self.is_used]
        return read_only(np.array([[x.min() for x in used.T], [x.max() for x in used.T]]))

    @property
    def has_sides(self) -> bool:
        """Whether it is known which side of the surface normals point to; not of every point cloud."""
        return True

    @cached_property
    def face_vectors(self) -> FloatArray:
        """(n_faces, 3) cross product of two edges: normal direction, length twice the area."""
        places = [np.ascontiguousarray(place) for place in self.vertices.T]
        out = np.empty((self.n_faces, 3))

        def cross(rows: slice) -> None:
            a, b, c = (np.ascontiguousarray(corner) for corner in self.faces[rows].T)
            sides = []  # one coordinate after the other, which caches like
            for place in places:
                start = place[a]
                sides.append((place[b] - start, place[c] - start))
            for i in range(3):
                (u, v), (x, y) = sides[i - 2], sides[i - 1]
                np.subtract(u * y, x * v, out=out[rows, i])

        by_parts(cross, self.n_faces)
        return read_only(out)

    @cached_property
    def face_areas(self) -> FloatArray:
        """(n_faces,) square metres; 0 for degenerate faces."""
        out = np.empty(self.n_faces)

        def half_lengths(rows: slice) -> None:
            x, y, z = np.square(self.face_vectors[rows]).T
            np.multiply(0.5, np.sqrt(x + y + z), out=out[rows])

        by_parts(half_lengths, self.n_faces)
        return read_only(out)

    @cached_property
    def face_normals(self) -> FloatArray:
        """(n_faces, 3) unit normals by the right-hand rule; zero vectors for degenerate faces."""
        out = np.zeros((self.n_faces, 3))

        def units(rows: slice) -> None:
            length = 2.0 * self.face_areas[rows, None]
            np.divide(self.face_vectors[rows], length, out=out[rows], where=length > 0)

        by_parts(units, self.n_faces)
        return read_only(out)

    @cached_property
    def face_centroids(self) -> FloatArray:
        """(n_faces, 3) mean of the three corners, metres."""
        out = np.empty((self.n_faces, 3))

        def middles(rows: slice) -> None:
            a, b, c = self.faces[rows].T
            sums = np.take(self.vertices, a, axis=0)  # a third of the time that vertices[a] takes
            sums += np.take(self.vertices, b, axis=0)
            sums += np.take(self.vertices, c, axis=0)
            np.divide(sums, 3, out=out[rows])

        by_parts(middles, self.n_faces)
        return read_only(out)


def taken(rows: npt.NDArray[Number], which: IntArray) -> npt.NDArray[Number]:
    """``rows[which]``, on all threads.

    Parameters
    ----------
    rows : (n, ...)
    which : (m,) int
        Not negative.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import taken
    >>> taken(np.array([5, 6, 7]), np.array([2, 0])).tolist()
    [7, 5]
    """
    out = np.empty((len(which), *rows.shape[1:]), dtype=rows.dtype)
    by_parts(lambda part: np.take(rows, which[part], axis=0, out=out[part], mode="clip"), len(which))
    return out


def read_only(array: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """The same array, which can't be written any more.

    Parameters
    ----------
    array : (n, ...)

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import read_only
    >>> read_only(np.zeros(3))[0] = 1
    Traceback (most recent call last):
    ValueError: assignment destination is read-only
    """
    array.flags.writeable = False
    return array


def _number_array(name: str, value: Any) -> npt.NDArray[Any]:
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise MeshError(f"{name} must have as many entries in every row ({error})") from None
    if array.dtype.kind not in "iuf":
        raise TypeError(
            f"{name} must be an array of numbers, got {type(value).__name__} of dtype {array.dtype}"
        )
    return array


def _color_array(value: Any, n_vertices: int) -> npt.NDArray[np.uint8]:
    colors = _number_array("vertex_colors", value)
    if colors.ndim != 2 or colors.shape[0] != n_vertices or colors.shape[1] not in (3, 4):
        raise MeshError(f"vertex_colors must have shape ({n_vertices}, 3), got {colors.shape}")
    if colors.dtype.kind == "f":
        if not np.isfinite(colors).all() or colors.min(initial=0) < 0 or colors.max(initial=0) > 1:
            raise MeshError("vertex_colors as floats must lie in [0, 1]; or give uint8 in 0..255")
        colors = np.round(255 * colors)
    elif colors.min(initial=0) < 0 or colors.max(initial=0) > 255:
        raise MeshError("vertex_colors must lie in 0..255")
    out = np.array(colors[:, :3], dtype=np.uint8, order="C")
    out.flags.writeable = False
    return out


# --- what is next to what -------------------------------------------------------------------------


def face_adjacency(mesh: Mesh) -> IntArray:
    """Pairs of faces that share an edge; found once a mesh, and read-only.

    Vertices at exactly the same position count as one, so a mesh whose triangles carry corners of their
    own (STL, texture seams) is as connected as it looks. An edge with more than two faces (non-manifold)
    joins every two of them up to 8 faces; with more, each face only with the next in the order of the
    faces. Edges of length zero join nothing.

    Returns
    -------
    pairs : (n_pairs, 2) int32
        Each pair once, ``pairs[:, 0] < pairs[:, 1]``, in lexicographic order.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> face_adjacency(square(1)).tolist()
    [[0, 1]]
    """
    return mesh._adjacency


def _shared_edges(mesh: Mesh) -> IntArray:
    n, bits = mesh.n_faces, mesh.n_vertices.bit_length()
    corner = weld(mesh)
    fits = 2 * bits + n.bit_length() < 64  # sorting edge and face in one number takes a third of the time
    key = np.empty((3, n), dtype=np.int64)
    is_edge = np.ones((3, n), dtype=np.bool_)

    def keys(rows: slice) -> None:
        ends = [np.take(corner, side).astype(np.int64) for side in mesh.faces[rows].T]
        for side, (start, end) in enumerate(zip(ends, ends[1:] + ends[:1])):
            code = np.minimum(start, end) << bits | np.maximum(start, end)
            if fits:
                code = code << n.bit_length() | np.arange(rows.start, rows.stop)
            key[side, rows] = code
            np.not_equal(start, end, out=is_edge[side, rows])

    by_parts(keys, n)
    codes: IntArray = key.ravel() if is_edge.all() else key[is_edge]
    face: IntArray
    if fits:
        codes.sort()
        face = np.empty(len(codes), dtype=np.int32)

        def apart(rows: slice) -> None:
            face[rows] = codes[rows] & ((1 << n.bit_length()) - 1)
            codes[rows] >>= n.bit_length()

        by_parts(apart, len(codes))
    else:
        order = np.argsort(codes)
        face = (np.flatnonzero(is_edge.ravel())[order] % n).astype(np.int32)
        codes = codes[order]
    is_same = codes[1:] == codes[:-1]
    start = np.flatnonzero(np.concatenate([[True], ~is_same]))
    length = np.diff(np.append(start, len(codes)))
    if length.max(initial=0) > MAX_FAN:  # chains follow the order of the faces
        order = np.lexsort((face, codes))
        face = face[order]
    found = [np.stack([face[:-1][is_same], face[1:][is_same]], axis=1)]
    is_fan = (length > 2) & (length <= MAX_FAN)
    start, length = start[is_fan], length[is_fan]
    for gap in range(2, int(length.max(initial=0))):  # few edges have more than two faces
        for first in range(int(length.max()) - gap):
            one = start[length > first + gap] + first
            found.append(np.stack([face[one], face[one + gap]], axis=1))
    pairs = np.concatenate(found)
    one, other = pairs[pairs[:, 0] != pairs[:, 1]].T
    return in_order(one, other)


def in_order(one: IntArray, other: IntArray) -> IntArray:
    """(n_pairs, 2) int32 each pair once, the smaller first, in lexicographic order.

    Parameters
    ----------
    one, other : (n,) int
        What is paired.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import in_order
    >>> in_order(np.array([2, 0, 1]), np.array([1, 3, 2])).tolist()
    [[0, 3], [1, 2]]
    """
    code = np.minimum(one, other).astype(np.int64) << 32 | np.maximum(one, other)
    code.sort()
    if np.any(code[1:] == code[:-1]):
        code = code[np.concatenate([[True], code[1:] != code[:-1]])]
    out = np.empty((len(code), 2), dtype=np.int32)

    def apart(rows: slice) -> None:
        out[rows, 0], out[rows, 1] = code[rows] >> 32, code[rows] & 0xFFFFFFFF

    by_parts(apart, len(code))
    return out


def neighbor_table(n_items: int, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Neighbours of each item as (indptr, indices) of a csr pattern, both int32, ascending.

    Parameters
    ----------
    n_items : int
    pairs : (n_pairs, 2) int
        Neighbours; each pair once, in either order.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import neighbor_table
    >>> starts, neighbors = neighbor_table(3, np.array([[0, 1], [1, 2]]))
    >>> starts.tolist(), neighbors.tolist()
    ([0, 1, 3, 4], [1, 0, 2, 1])
    """
    n = len(pairs)
    code, out = np.empty((2, n), dtype=np.int64), np.empty(2 * n, dtype=np.int32)

    def both_ways(rows: slice) -> None:
        one, other = np.ascontiguousarray(pairs[rows].T, dtype=np.int64)
        code[0, rows], code[1, rows] = one << 32 | other, other << 32 | one

    by_parts(both_ways, n)
    codes = code.ravel()
    codes.sort()
    by_parts(lambda rows: np.bitwise_and(codes[rows], 0xFFFFFFFF, out=out[rows], casting="unsafe"), 2 * n)
    count = np.bincount(np.asarray(pairs, dtype=np.int64).ravel(), minlength=n_items)
    return np.concatenate([[0], np.cumsum(count)]).astype(np.int32), out


def shared_edge_lengths(mesh: Mesh, face_pairs: IntArray) -> FloatArray:
    """(n_pairs,) length of the edge that two faces share, 0 where they share none.

    Corners are one where their coordinates are, so it doesn't matter whether the mesh is welded. Of two
    faces that share all three corners, one of the edges is measured.

    Parameters
    ----------
    mesh : Mesh
    face_pairs : (n_pairs, 2) int

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> mesh = square(1)
    >>> shared_edge_lengths(mesh, face_adjacency(mesh)).round(3)
    array([1.414])
    """
    one, other = (mesh.vertices[mesh.faces[side]] for side in face_pairs.T)
    shared = (one[:, :, None] == other[:, None]).all(axis=3).any(axis=2)
    out = np.zeros(len(face_pairs))
    for k in range(3):
        side = shared[:, k] & shared[:, (k + 1) % 3]
        out[side] = np.linalg.norm(one[side, k] - one[side, (k + 1) % 3], axis=1)
    return out


def weld(mesh: Mesh) -> IntArray:
    """(n_vertices,) int32: for each vertex the first vertex at exactly the same position; read-only."""
    return mesh._welded


def _welded(mesh: Mesh) -> IntArray:
    bits = (mesh.vertices + 0.0).view(np.uint64)  # + 0.0 makes -0.0 and 0.0 one position
    mix = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
    with np.errstate(over="ignore"):
        hashed = (bits ^ (bits >> np.uint64(29))) * mix
        code = hashed[:, 0] ^ (hashed[:, 1] << np.uint64(1)) ^ (hashed[:, 2] >> np.uint64(1))
    order = ascending(code)
    code = code[order]
    is_same = code[1:] == code[:-1]
    out = np.arange(mesh.n_vertices, dtype=np.int32)
    same = np.flatnonzero(is_same)
    if len(same) == 0:
        return out
    if not (mesh.vertices[order[same + 1]] == mesh.vertices[order[same]]).all():
        # two places, one hash: compare the positions themselves
        order = np.lexsort((np.arange(mesh.n_vertices), *mesh.vertices.T))
        is_same = (mesh.vertices[order[1:]] == mesh.vertices[order[:-1]]).all(axis=1)
    is_first = np.concatenate([[True], ~is_same])
    out[order] = order[is_first][np.cumsum(is_first) - 1]
    return out


def ascending(values: FloatArray | IntArray) -> IntArray:
    """(n,) order of values, the least first, equal ones in the order they come in.

    Parameters
    ----------
    values : (n,) float or int

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import ascending
    >>> ascending(np.array([2.0, 1.0, 2.0])).tolist()
    [1, 0, 2]
    """
    least = values.min(initial=0)
    is_single = values.dtype == np.float32 and least >= 0  # whose bits are in their order
    if not is_single and values.dtype != np.int32:
        order = np.argsort(values)  # several times as fast as a stable one, which only ties want
        tied, tie = ties(values[order])
        if 4 * len(tied) > len(values):
            return np.argsort(values, kind="stable")
        order[tied] = order[tied][np.lexsort((order[tied], tie))]
        return order
    key = np.empty(len(values), dtype=np.int64)  # the value, then its place, in one number

    def keys(rows: slice) -> None:
        part = values[rows]
        bits = (part + np.float32(0)).view(np.int32) if is_single else part
        np.subtract(bits, 0 if is_single else int(least), out=key[rows], dtype=np.int64)
        key[rows] <<= 32
        key[rows] |= np.arange(rows.start, rows.start + len(part))

    by_parts(keys, len(key))
    key.sort()
    by_parts(lambda rows: np.bitwise_and(key[rows], 0xFFFFFFFF, out=key[rows]), len(key))
    return key


def ties(ordered: npt.NDArray[Any]) -> tuple[IntArray, IntArray]:
    """Places of those of sorted values that come several times, and which of these values each is.

    Parameters
    ----------
    ordered : (n,)

    Returns
    -------
    tied : (n_tied,) int64
        Ascending.
    tie : (n_tied,) int64
        From 0 on.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import ties
    >>> ties(np.array([1, 2, 2, 3, 5, 5]))
    (array([1, 2, 4, 5]), array([0, 0, 1, 1]))
    """
    is_same = np.zeros(len(ordered) + 1, dtype=np.bool_)
    np.equal(ordered[1:], ordered[:-1], out=is_same[1:-1])
    tied = np.flatnonzero(is_same[1:] | is_same[:-1])
    return tied, np.cumsum(~is_same[tied]) - 1


def unique_codes(codes: IntArray, end: int) -> tuple[IntArray, IntArray]:
    """What ``np.unique(codes, return_inverse=True)`` gives, by counting where that is less work than sorting.

    Parameters
    ----------
    codes : (n,) int64
        Not negative.
    end : int
        All codes are below.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import unique_codes
    >>> unique_codes(np.array([7, 2, 7]), 8)
    (array([2, 7]), array([1, 0, 1]))
    """
    if end > 2 * codes.size:
        distinct, index = np.unique(codes, return_inverse=True)
        return distinct, index
    rank = np.zeros(end, dtype=np.int64)
    rank[codes] = 1
    distinct = np.flatnonzero(rank)
    rank[distinct] = np.arange(len(distinct))
    return distinct, rank[codes]


def connected_components(n_items: int, pairs: IntArray) -> tuple[int, IntArray]:
    """Components of an undirected graph.

    Parameters
    ----------
    n_items : int
        Number of nodes; nodes without a pair are components of their own.
    pairs : (n_pairs, 2) int
        Edges.

    Returns
    -------
    n_components : int
    component : (n_items,) int32
        Component of each node, numbered by the smallest node in it.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.mesh import connected_components
    >>> connected_components(4, np.array([[0, 1], [2, 3]]))
    (2, array([0, 0, 1, 1], dtype=int32))
    """
    component = np.arange(n_items, dtype=np.int32)
    edges = read_only(np.ascontiguousarray(pairs, dtype=np.int32).view())  # of one kind: it compiles once
    return int(_join_all(edges, component)), component


@kernel
def _join_all(pairs, parent):  # type: ignore[no-untyped-def]
    """``parent``, each item its own at first, becomes the component of each item; returns their number."""
    for e in range(len(pairs)):
        a, b = pairs[e, 0], pairs[e, 1]
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        while parent[b] != b:
            parent[b] = parent[parent[b]]
            b = parent[b]
        if a < b:  # the lowest is the root, so every other's parent comes before it
            parent[b] = a
        else:
            parent[a] = b
    count = 0
    for i in range(len(parent)):
        if parent[i] == i:
            parent[i] = count
            count += 1
        else:
            parent[i] = parent[parent[i]]
    return count


def __getattr__(name: str) -> Any:
    if name == "load_mesh":  # where it was until readers became a package
        warnings.warn(
            "load_mesh moved to scenewidget.engine.readers; sw.load_mesh is its public name",
            DeprecationWarning,
            stacklevel=2,
        )
        return getattr(importlib.import_module("scenewidget.engine.readers"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
