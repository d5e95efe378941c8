"""Fewer triangles by quadric error metrics: the rule of fast-simplification, without its idle rounds.

Goes in: a mesh. Comes out: a mesh with fewer faces, if the mesh is small to the last bit the one that the
library would give. The library tries every edge again in each of its hundred rounds, also where no edge can
go any more, as on fragmented scans; here an edge that could not go is tried again only where something around
it has changed. A large mesh is put in an order that keeps neighbours close in memory, and goes through its
first rounds in parts that are worked on at once: vertices that parts share wait until it is one mesh again.

Garland and Heckbert (1997), SIGGRAPH; the rounds with a rising threshold: Forstmann (2014),
Fast Quadric Mesh Simplification (MIT licence), as fast-simplification has it.
"""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from operator import methodcaller

import numpy as np

from scenewidget.engine.curve import along_curve
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, ascending, taken, unique_codes
from scenewidget.engine.threads import n_threads

__all__ = ["decimate"]

ROUNDS, TOGETHER = 100, 5  # rounds; so many of them over one list of faces around vertices
PARTS, FEWEST = 8, 300_000  # parts that a mesh of at least so many faces is worked on in
FAR = 12  # times the target: while more faces are left, parts are worth it
HARDLY = 0.9  # of the faces are left after some rounds: it is done with parts
STEEP = 0.999  # corners with a cosine above are no triangle
TURNED = 0.2  # a normal may turn down to this cosine


def decimate(
    vertices: FloatArray,
    faces: IntArray,
    target: int,
    *,
    aggressiveness: float = 7.0,
) -> tuple[FloatArray, IntArray]:
    """A mesh with about ``target`` faces, or more where no edge may be collapsed any more.

    Parameters
    ----------
    vertices : (n_vertices, 3) float
        In a unit in which edges are some hundredths long: thresholds are absolute.
    faces : (n_faces, 3) int
        Three different vertices each.
    target : int
    aggressiveness : float
        How fast the threshold rises from round to round.

    Returns
    -------
    vertices : (n, 3) float64
    faces : (m, 3) int32

    Examples
    --------
    >>> from scenewidget.datasets.analytic import sphere
    >>> from scenewidget.engine.decimation import decimate
    >>> ball = sphere(3)
    >>> vertices, faces = decimate(0.2 * ball.vertices, ball.faces, 200)
    >>> ball.n_faces, len(faces)
    (1280, 200)
    """
    places = np.array(vertices, dtype=np.float64, order="C")
    faces = np.array(faces, dtype=np.int32, order="C")
    thresholds = 1e-9 * np.array([float(i + 3) ** aggressiveness for i in range(ROUNDS)])
    first = 0
    if len(faces) >= FEWEST and len(faces) > FAR * target:
        surface, first = _thinned_in_parts(places, faces, target, thresholds)
    else:
        no_vertex = np.zeros(len(places), dtype=np.bool_)
        surface = _surface(places, faces, _quadrics(places, faces), _at_rims(faces, len(places)), no_vertex)
    for start in range(first, ROUNDS, TOGETHER):
        if len(surface.faces) <= target:
            break
        surface.collapse(thresholds[start : start + TOGETHER], target)
    used, number = unique_codes(surface.faces.ravel(), len(places))
    return surface.places[used], number.reshape(-1, 3).astype(np.int32)


def _thinned_in_parts(
    places: FloatArray, faces: IntArray, target: int, thresholds: FloatArray
) -> tuple[_Surface, int]:
    """What some rounds leave of a large mesh, and how many rounds those were.

    Parts are the same however many threads there are.
    """
    n = len(places)
    order = along_curve(places)
    place = np.empty(n, dtype=np.int32)
    place[order] = np.arange(n, dtype=np.int32)
    places, faces = taken(places, order), taken(place, faces.ravel()).reshape(-1, 3)
    faces = taken(faces, ascending(faces.min(axis=1)))
    is_rim = _at_rims(faces, n)
    bounds = np.linspace(0, len(faces), PARTS + 1).astype(np.int64)
    lists = [faces[start:stop] for start, stop in itertools.pairwise(bounds)]
    quadrics, n_parts_of = np.zeros((n, 10)), np.zeros(n, dtype=np.int8)
    with ThreadPoolExecutor(n_threads()) as pool:
        inside = list(pool.map(lambda part: unique_codes(part.ravel(), n), lists))
        own = [number.reshape(-1, 3).astype(np.int32) for _, number in inside]
        used = [vertices for vertices, _ in inside]
        for vertices, sums in zip(used, pool.map(lambda v, f: _quadrics(places[v], f), used, own)):
            quadrics[vertices] += sums
            n_parts_of[vertices] += 1
        is_shared = n_parts_of > 1
        surfaces = list(
            pool.map(lambda v, f: _surface(places[v], f, quadrics[v], is_rim[v], is_shared[v]), used, own)
        )
        done, before, left = 0, np.inf, len(faces)
        while done < ROUNDS and FAR * target < left <= HARDLY * before:
            collapse = methodcaller("collapse", thresholds[done : done + TOGETHER], -(-2 * target // PARTS))
            list(pool.map(collapse, surfaces))
            done += TOGETHER
            before, left = left, sum(len(surface.faces) for surface in surfaces)
    for vertices, surface in zip(used, surfaces):
        places[vertices], quadrics[vertices] = surface.places, surface.quadrics
    whole = _Surface(
        places,
        np.concatenate([v[surface.faces].astype(np.int32) for v, surface in zip(used, surfaces)]),
        quadrics,
        is_rim,
        np.zeros(n, dtype=np.bool_),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.errors for surface in surfaces]),
    )
    return whole, done


@dataclass
class _Surface:
    """A mesh that gets coarser and coarser, and what is known of its vertices and faces."""

    places: FloatArray
    faces: IntArray
    quadrics: FloatArray  # (n_vertices, 10) of the planes around each
    is_rim: IntArray
    is_fixed: BoolArray  # which vertices stay as they are
    normals: FloatArray
    errors: FloatArray  # (n_faces, 4) of collapsing each edge, and the least of them

    def __post_init__(self) -> None:
        n = len(self.places)
        self.tried, self.which = np.zeros((2, len(self.faces)), dtype=np.int64)
        self.changed = np.zeros(n, dtype=np.int64)  # at which collapse something around a vertex changed last
        self.seen, self.known = (
            np.zeros(n, dtype=np.int64),
            np.zeros(n),
        )  # errors of edges to the vertex at hand
        self.clock = 1

    def collapse(self, thresholds: FloatArray, target: int) -> None:
        """A round for each threshold, as long as more than ``target`` faces are left."""
        is_gone = np.zeros(len(self.faces), dtype=np.bool_)
        is_dirty = np.zeros(len(self.faces), dtype=np.int8)
        start, count, around, corner = _fans(self.faces, len(self.places))
        state = np.array([self.clock, len(self.faces), target, len(around) // 2, 0, 0])
        while not _collapse(
            self.places, self.faces, self.is_rim, self.is_fixed, self.normals, self.quadrics, self.errors,
            is_gone, is_dirty, self.tried, self.which, self.changed, self.seen, self.known,
            start, count, around, corner, thresholds, state,
        ):  # fmt: skip
            around, corner = (np.concatenate([fans, np.zeros_like(fans)]) for fans in (around, corner))
        self.clock = int(state[0])
        stays = ~is_gone
        self.faces, self.normals, self.errors = self.faces[stays], self.normals[stays], self.errors[stays]
        self.tried, self.which = self.tried[stays], self.which[stays]


def _surface(
    places: FloatArray, faces: IntArray, quadrics: FloatArray, is_rim: IntArray, is_fixed: BoolArray
) -> _Surface:
    normals, errors = np.empty((len(faces), 3)), np.empty((len(faces), 4))
    no_rim = np.zeros_like(is_rim)  # where rims are counts later
    _measure(places, faces, no_rim, quadrics, normals, errors)
    return _Surface(places, faces, quadrics, is_rim, is_fixed, normals, errors)


def _at_rims(faces: IntArray, n_vertices: int) -> IntArray:
    """(n_vertices,) 1 for the ends of edges that only one face has."""
    ends = faces.astype(np.int64)
    one, other = ends.ravel(), ends[:, [1, 2, 0]].ravel()
    code = np.sort(np.minimum(one, other) << 32 | np.maximum(one, other))
    is_new = np.concatenate([[True], code[1:] != code[:-1], [True]])
    alone = code[is_new[1:] & is_new[:-1]]
    is_rim = np.zeros(n_vertices, dtype=np.int32)
    is_rim[alone >> 32] = is_rim[alone & 0xFFFFFFFF] = 1
    return is_rim


def _quadrics(places: FloatArray, faces: IntArray) -> FloatArray:
    out = np.zeros((len(places), 10))
    _add_planes(places, faces, out)
    return out


def _fans(faces: IntArray, n_vertices: int) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Faces around each vertex, in their order, and as which of their corners; with room for more behind."""
    sides = faces.ravel()
    count = np.bincount(sides, minlength=n_vertices).astype(np.int64)
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    order = np.sort(sides.astype(np.int64) << 32 | np.arange(len(sides))) & 0xFFFFFFFF
    around, corner = np.zeros((2, 2 * len(sides)), dtype=np.int32)
    around[: len(sides)], corner[: len(sides)] = order // 3, order % 3
    return start, count, around, corner


@kernel
def _least(a, b):  # type: ignore[no-untyped-def]
    return a if a < b or b != b else b  # as C's fmin: a number where one of them is none


@kernel
def _error_at(q, x, y, z):  # type: ignore[no-untyped-def]
    return (
        q[0] * x * x + 2 * q[1] * x * y + 2 * q[2] * x * z + 2 * q[3] * x + q[4] * y * y
        + 2 * q[5] * y * z + 2 * q[6] * y + q[7] * z * z + 2 * q[8] * z + q[9]
    )  # fmt: skip


@kernel
def _minor(q, a, b, c, d, e, f, g, h, i):  # type: ignore[no-untyped-def]
    return (
        q[a] * q[e] * q[i] + q[c] * q[d] * q[h] + q[b] * q[f] * q[g]
        - q[c] * q[e] * q[g] - q[a] * q[f] * q[h] - q[b] * q[d] * q[i]
    )  # fmt: skip


@kernel
def _merged(places, is_rim, quadrics, i, j):  # type: ignore[no-untyped-def]
    """Where two vertices would become one, and the error there."""
    q = (
        quadrics[i, 0] + quadrics[j, 0], quadrics[i, 1] + quadrics[j, 1], quadrics[i, 2] + quadrics[j, 2],
        quadrics[i, 3] + quadrics[j, 3], quadrics[i, 4] + quadrics[j, 4], quadrics[i, 5] + quadrics[j, 5],
        quadrics[i, 6] + quadrics[j, 6], quadrics[i, 7] + quadrics[j, 7], quadrics[i, 8] + quadrics[j, 8],
        quadrics[i, 9] + quadrics[j, 9],
    )  # fmt: skip
    det = _minor(q, 0, 1, 2, 1, 4, 5, 2, 5, 7)
    if det != 0 and not (is_rim[i] == 1 and is_rim[j] == 1):
        x = -1 / det * _minor(q, 1, 2, 3, 4, 5, 6, 5, 7, 8)
        y = 1 / det * _minor(q, 0, 2, 3, 1, 5, 6, 2, 7, 8)
        z = -1 / det * _minor(q, 0, 1, 3, 1, 4, 6, 2, 5, 8)
        return _error_at(q, x, y, z), x, y, z
    a, b, c = places[i, 0], places[i, 1], places[i, 2]
    d, e, f = places[j, 0], places[j, 1], places[j, 2]
    x, y, z = (a + d) / 2, (b + e) / 2, (c + f) / 2
    one, other, middle = _error_at(q, a, b, c), _error_at(q, d, e, f), _error_at(q, x, y, z)
    error = _least(one, _least(other, middle))
    if middle == error:
        return error, x, y, z
    if other == error:
        return error, d, e, f
    return error, a, b, c


@kernel
def _normal(places, faces, f):  # type: ignore[no-untyped-def]
    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
    ux, uy, uz = places[b, 0] - places[a, 0], places[b, 1] - places[a, 1], places[b, 2] - places[a, 2]
    vx, vy, vz = places[c, 0] - places[a, 0], places[c, 1] - places[a, 1], places[c, 2] - places[a, 2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


@kernel
def _add_planes(places, faces, quadrics):  # type: ignore[no-untyped-def]
    """Quadrics of the planes around each vertex."""
    for f in range(len(faces)):
        a = faces[f, 0]
        x, y, z = _normal(places, faces, f)
        d = -(places[a, 0] * x + places[a, 1] * y + places[a, 2] * z)
        plane = (x * x, x * y, x * z, x * d, y * y, y * z, y * d, z * z, z * d, d * d)
        for k in range(3):
            for i in range(10):
                quadrics[faces[f, k], i] += plane[i]


@kernel
def _measure(places, faces, is_rim, quadrics, normals, errors):  # type: ignore[no-untyped-def]
    """Unit normals, and errors of the edges."""
    for f in range(len(faces)):
        normals[f, 0], normals[f, 1], normals[f, 2] = _normal(places, faces, f)
        for k in range(3):
            errors[f, k] = _merged(places, is_rim, quadrics, faces[f, k], faces[f, (k + 1) % 3])[0]
        errors[f, 3] = _least(errors[f, 0], _least(errors[f, 1], errors[f, 2]))


@kernel
def _turns(  # type: ignore[no-untyped-def]
    places, faces, normals, is_gone, first, n, around, corner, other, x, y, z
):
    """Whether a face around a vertex would turn over if it moved; those shared with another one vanish."""
    for k in range(n):
        f = around[first + k]
        if is_gone[f]:
            continue
        c = corner[first + k]
        i, j = faces[f, (c + 1) % 3], faces[f, (c + 2) % 3]
        if i == other or j == other:
            continue
        ax, ay, az = places[i, 0] - x, places[i, 1] - y, places[i, 2] - z
        length = np.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax / length, ay / length, az / length
        bx, by, bz = places[j, 0] - x, places[j, 1] - y, places[j, 2] - z
        length = np.sqrt(bx * bx + by * by + bz * bz)
        bx, by, bz = bx / length, by / length, bz / length
        if abs(bx * ax + by * ay + bz * az) > STEEP:
            return True
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        nx, ny, nz = nx / length, ny / length, nz / length
        if normals[f, 0] * nx + normals[f, 1] * ny + normals[f, 2] * nz < TURNED:
            return True
    return False


@kernel
def _collapse(  # type: ignore[no-untyped-def]
    places, faces, is_rim, is_fixed, normals, quadrics, errors, is_gone, is_dirty, tried, which, changed,
    seen, known, start, count, around, corner, thresholds, state,
):  # fmt: skip
    """Some rounds; whether they are done, or need more room behind the fans and go on where they stopped.

    ``state`` is the number of collapses so far, of faces left, and of those wanted, the end of the fans, the
    round and the face.
    """
    clock, left, target, end = state[0], state[1], state[2], state[3]
    for t in range(state[4], len(thresholds)):
        if left <= target:
            break
        threshold = thresholds[t]
        begin, state[5] = state[5], 0
        if begin == 0:
            for f in range(len(faces)):
                is_dirty[f] = 0
        for f in range(begin, len(faces)):
            if errors[f, 3] > threshold or is_gone[f] or is_dirty[f]:
                continue
            light, since = 0, 0
            for k in range(3):
                light += (errors[f, k] < threshold) << k
                since = max(since, changed[faces[f, k]])
            if which[f] == light and since < tried[f]:
                continue  # none of these edges could go, and nothing around has changed
            is_done = False
            for k in range(3):
                if not errors[f, k] < threshold:
                    continue
                i, j = faces[f, k], faces[f, (k + 1) % 3]
                if is_rim[i] != is_rim[j] or is_fixed[i] or is_fixed[j]:
                    continue
                _, x, y, z = _merged(places, is_rim, quadrics, i, j)
                if _turns(
                    places, faces, normals, is_gone, start[i], count[i], around, corner, j, x, y, z
                ) or _turns(
                    places, faces, normals, is_gone, start[j], count[j], around, corner, i, x, y, z
                ):  # fmt: skip
                    continue
                if end + count[i] + count[j] > len(around):
                    state[0], state[1], state[3], state[4], state[5] = clock, left, end, t, f
                    return False
                places[i, 0], places[i, 1], places[i, 2] = x, y, z
                for e in range(10):
                    quadrics[i, e] = quadrics[j, e] + quadrics[i, e]
                clock += 1
                first = end
                for side in range(2):
                    v, other = (i, j) if side == 0 else (j, i)
                    for e in range(count[v]):
                        face = around[start[v] + e]
                        if is_gone[face]:
                            continue
                        for c in range(3):
                            changed[faces[face, c]] = clock
                        c = corner[start[v] + e]
                        a, b = (c + 1) % 3, (c + 2) % 3
                        p, q = faces[face, a], faces[face, b]
                        if p == other or q == other:
                            is_gone[face] = True
                            left -= 1
                            continue
                        faces[face, c] = i
                        is_dirty[face] = 1
                        if seen[p] != clock:  # another face has this edge too
                            seen[p] = clock
                            known[p] = _merged(places, is_rim, quadrics, i, p)[0]
                        if seen[q] != clock:
                            seen[q] = clock
                            known[q] = _merged(places, is_rim, quadrics, q, i)[0]
                        errors[face, c], errors[face, b] = known[p], known[q]
                        if (
                            is_rim[p] == 1 and is_rim[q] == 1
                        ):  # at first it was measured as if there were no rims
                            errors[face, a] = _merged(places, is_rim, quadrics, p, q)[0]
                        errors[face, 3] = _least(errors[face, 0], _least(errors[face, 1], errors[face, 2]))
                        around[end], corner[end] = face, c
                        end += 1
                n = end - first
                if n <= count[i]:
                    for e in range(n):
                        around[start[i] + e], corner[start[i] + e] = around[first + e], corner[first + e]
                    end = first
                else:
                    start[i] = first
                count[i] = n
                is_done = True
                break
            if not is_done:
                clock += 1
                tried[f], which[f] = clock, light
            if left <= target:
                break
    state[0], state[1] = clock, left
    return True
