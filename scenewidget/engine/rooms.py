"""The rooms of a flat: which faces lie in which, from a map of its walls; and a coarse picture of it.

Goes in: a mesh that may be too large to be looked at whole. Come out: a room for each face, and a mesh of
some hundred thousand faces that looks like it from afar. Not in the thesis.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage, sparse
from scipy.sparse.csgraph import dijkstra

from scenewidget.engine.checks import checked_count
from scenewidget.engine.gravity import up_direction
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh
from scenewidget.engine.threads import parts

__all__ = ["coarse_mesh", "rooms_of"]

CELL = 0.05  # metres, of the map
MOST_CELLS = 1_000_000  # of the map; a larger one has larger cells
BIN = 0.1  # metres of height: what reaches through many of them is a wall
TALL = 1.4  # metres of height that a wall has, or
SHARE = 0.55  # of the height of all, whichever is less
STEEP = 0.35  # most that the normal of a wall leans up or down
CLEAR = 0.45  # metres from the walls: what is nearer is no middle of a room, so no door is
LEAST = 0.3  # square metres of the middle of a room
THROUGH = 20.0  # a step inside a wall is as long as so many in free space
MAP_FACES = 1_500_000  # of a mesh that is fine enough for the map
CHUNK = 2_000_000  # faces looked up at once


def rooms_of(mesh: Mesh, *, max_faces: int = 3_000_000) -> IntArray:
    """Which room each face lies in, seen from above.

    The middles of rooms are what is further from all walls than half a door's width; all else goes to the
    middle that is nearest without walking through walls. So a wall's two sides belong to the rooms that they
    face, and a passage as narrow as a door parts two rooms. Storeys above each other are not told apart.

    Parameters
    ----------
    mesh : Mesh
        In metres.
    max_faces : int
        A room with more is halved across its longer side until no part has more.

    Returns
    -------
    room : (n_faces,) int32
        0 the room with the most faces, and so on; ties by the first face.

    Raises
    ------
    ValueError
        ``max_faces`` is no count.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> rooms_of(analytic.square(4)).tolist() == [0] * 32
    True
    """
    max_faces = checked_count("max_faces", max_faces)
    frame = _frame(mesh)
    plan = _Plan(coarse_mesh(mesh, MAP_FACES)[0], frame)
    room = np.empty(mesh.n_faces, dtype=np.int64)
    places = np.empty((mesh.n_faces, 2), dtype=np.float32)
    for some in parts(mesh.n_faces, CHUNK):
        corners = mesh.vertices[mesh.faces[some]]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(across, axis=1, keepdims=True)
        ahead = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
        # a little into free space, so that a wall's cells are those on its own side
        places[some] = ((corners.mean(axis=1) + plan.cell * ahead) @ frame.T)[:, :2]
        room[some] = plan.room_at(places[some])
    waiting: list[IntArray] = [np.flatnonzero(room == k) for k in range(room.max() + 1)]
    whole: list[IntArray] = []
    while waiting:
        faces = waiting.pop()
        there = places[faces]
        axis = int(np.ptp(there, axis=0).argmax()) if len(faces) else 0
        is_low = there[:, axis] < np.median(there[:, axis]) if len(faces) > max_faces else np.zeros(0, bool)
        if is_low.any():
            waiting += [faces[is_low], faces[~is_low]]
        elif len(faces):
            whole.append(faces)
    out = np.empty(mesh.n_faces, dtype=np.int32)
    for k, faces in enumerate(sorted(whole, key=lambda faces: (-len(faces), faces[0]))):
        out[faces] = k
    return out


def coarse_mesh(mesh: Mesh, n_faces: int = 200_000) -> tuple[Mesh, IntArray]:
    """About so many faces that look like the mesh from afar, and which face of it each stands for.

    Vertices in one cell of a grid become one at their mean (Rossignac and Borrel (1993), Modeling in
    Computer Graphics), which takes a second for some million faces.

    Parameters
    ----------
    mesh : Mesh
        One with no more faces is returned as it is.
    n_faces : int

    Returns
    -------
    coarse : Mesh
    face : (n,) int64

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> coarse, face = coarse_mesh(analytic.square(100), 500)  # of 20 000
    >>> 250 < coarse.n_faces < 1000
    True
    """
    n_faces = checked_count("n_faces", n_faces)
    if mesh.n_faces <= n_faces:
        return mesh, np.arange(mesh.n_faces)
    area = sum(float(_areas(mesh, some).sum()) for some in parts(mesh.n_faces, CHUNK))
    side = max(float(np.sqrt(2.0 * area / n_faces)), 1e-9)
    cell_of: IntArray = np.zeros(mesh.n_vertices, dtype=np.int64)
    for low, high, place in zip(*mesh.bounds, mesh.vertices.T, strict=True):
        n = int((high - low) / side) + 1
        cell_of *= n
        cell_of += np.clip((place - low) / side, 0, n - 1).astype(np.int64)
    _, cluster, size = np.unique(cell_of, return_inverse=True, return_counts=True)
    cluster = cluster.astype(np.int32)

    def means(columns: npt.NDArray[Any]) -> FloatArray:
        return np.stack([np.bincount(cluster, column) for column in columns.T], axis=1) / size[:, None]

    corners = cluster[mesh.faces]
    keep = np.flatnonzero(
        (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    )
    if len(keep) == 0:  # all of it in one cell, or needles
        return mesh, np.arange(mesh.n_faces)
    _, first = np.unique(np.sort(corners[keep], axis=1), axis=0, return_index=True)
    face = keep[np.sort(first)]
    colors = None if mesh.vertex_colors is None else means(mesh.vertex_colors).round().astype(np.uint8)
    return Mesh(means(mesh.vertices), corners[face], colors), face


class _Plan:
    """Rooms on a grid, seen from above."""

    def __init__(self, mesh: Mesh, frame: FloatArray) -> None:
        places = mesh.face_centroids @ frame.T
        self.low = places.min(axis=0)
        extent = np.ptp(places, axis=0)
        self.cell = max(CELL, float(np.sqrt(extent[0] * extent[1] / MOST_CELLS)))
        cells = ((places - self.low) / [self.cell, self.cell, BIN]).astype(np.int64)
        shape = cells.max(axis=0) + 1
        lean = np.abs(mesh.face_normals @ frame[2])
        walls = self._is_wall(cells[lean < STEEP], shape)
        is_seen = np.zeros(shape[:2], dtype=bool)
        is_seen[tuple(cells[lean > 1 - STEEP, :2].T)] = True  # floors and ceilings
        is_free = ndimage.binary_closing(np.pad(is_seen, 3), np.ones((3, 3)), 2)[3:-3, 3:-3] & ~walls
        self.room = self._grown(self._middles(is_free), is_free)

    def room_at(self, places: FloatArray) -> IntArray:
        """(n,) the room at places, (n, 2)."""
        cells = ((places - self.low[:2]) / self.cell).astype(np.int64)
        x, y = np.clip(cells, 0, np.array(self.room.shape) - 1).T
        return np.asarray(self.room[x, y])

    def _is_wall(self, cells: IntArray, shape: IntArray) -> BoolArray:
        there = np.zeros(shape, dtype=bool)
        there[tuple(cells.T)] = True
        n = ndimage.maximum_filter(there, (3, 3, 1)).sum(axis=2)  # a wall that leans is in several cells
        return np.asarray(BIN * n >= min(TALL, SHARE * BIN * shape[2]))

    def _middles(self, is_free: BoolArray) -> IntArray:
        """Numbered from 1; 0 elsewhere."""
        far = ndimage.distance_transform_edt(np.pad(is_free, 1))[1:-1, 1:-1] * self.cell
        middle, n = ndimage.label(far > CLEAR)
        is_large = np.bincount(middle.ravel(), minlength=n + 1) * self.cell**2 >= LEAST
        is_large[0] = False
        return np.asarray(np.where(is_large, np.cumsum(is_large), 0)[middle])

    def _grown(self, middle: IntArray, is_free: BoolArray) -> IntArray:
        """The room of every cell: of the middle that is nearest on foot."""
        starts = np.flatnonzero(middle.ravel())
        if len(np.unique(middle[middle > 0])) < 2:
            return np.zeros(middle.shape, dtype=np.int64)
        step = np.where(is_free, 1.0, THROUGH)
        number = np.arange(middle.size).reshape(middle.shape)
        ends, weights = list[IntArray](), list[FloatArray]()
        for one, other in (np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:]):
            ends.append(np.stack([number[one].ravel(), number[other].ravel()]))
            weights.append((step[one] + step[other]).ravel() / 2)
        size = (middle.size, middle.size)
        graph = sparse.coo_array((np.concatenate(weights), np.concatenate(ends, axis=1)), size).tocsr()
        _, _, source = dijkstra(
            graph, directed=False, indices=starts, min_only=True, return_predecessors=True
        )
        return np.asarray(middle.ravel()[source].reshape(middle.shape) - 1)


def _frame(mesh: Mesh) -> FloatArray:
    """(3, 3) rows: two directions along the ground, and up; z where the surface doesn't tell."""
    up = up_direction(coarse_mesh(mesh)[0])
    up = np.array([0.0, 0.0, 1.0]) if up is None else up
    aside = np.eye(3)[int(np.abs(up).argmin())]
    first = np.cross(aside, up)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first), up])


def _areas(mesh: Mesh, some: slice) -> FloatArray:
    a, b, c = (mesh.vertices[corner] for corner in mesh.faces[some].T)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
