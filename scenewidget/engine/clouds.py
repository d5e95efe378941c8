"""Point clouds as surfaces: each point is a small disc with a normal, an area and neighbours.

Goes in: points. Comes out: a `PointCloud`, which is a `Mesh` whose faces are its points, so that everything
behind it, from filtered normals to the consensus, works on it unchanged. That the method extends to clouds by
tangent planes is said in the thesis (chapter 5); Hoppe et al. (1992), SIGGRAPH, make them consistent.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from scenewidget.engine.curve import along_curve
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh, MeshError, in_order, taken
from scenewidget.engine.threads import by_parts

__all__ = ["PointCloud"]

T = TypeVar("T", bound=np.generic)

N_AROUND = 16  # neighbours that triangles are made of
N_NEAR = 6  # neighbours that a point is joined to, and that tell its plane
N_AREA = 8  # neighbours that tell the area of a point
LARGEST_AREA = 0.995  # quantile at which areas are capped: lonely points would weigh too much
REACH = 3.0  # median distances of the sixth neighbour, from which on points aren't neighbours
FLAT = 1e-9  # sine of an angle below which three points of a tangent plane lie on a line
SEAM = 0.44  # of the root of a point's area: length of border for each pair across it
BACK = -0.3  # cosine of normals below which neighbours are two sides of one thing
DIFFERENCES = 63  # steps, of some 1.3 degrees, in which neighbours are told from those that differ less
N_FITTED = 30_000  # points that are enough to find the plane that most of them lie on
STEEP = 0.8  # cosine up to which a point faces along no plane
BAND, THIN = 0.03, 0.008  # of the size of a scan: its largest plane is sought so near, and lies so near
RISES = 0.015  # of the size, from which on things stand above that plane
ON_PLANE = 0.35  # of the area, from which on a plane is what everything stands on; floors of rooms have 0.25
THINGS = 0.01  # of the area, that the things on a plane have at least


class PointCloud(Mesh):
    """Points with normals and areas; arrays are copied, checked and made read-only.

    A mesh whose face i is point i: labels, exports and edits name points where those of a mesh name faces.

    Parameters
    ----------
    points : (n_points, 3) float
        Positions in metres.
    normals : (n_points, 3) float, optional
        Pointing into free space. Without them the plane of the 6 nearest points tells, turned to the
        ``viewpoint`` where there is one, else alike along the surface.
    colors : (n_points, 3) uint8, optional
        Red, green, blue; floats in 0–1 are turned into bytes.
    viewpoint : (3,) or (n_points, 3) float, optional
        Where the scanner stood.
    source, report, faces_of_file, n_file_faces
        As of a `Mesh`, with points for faces.

    Raises
    ------
    MeshError
        No points, NaN or infinite ones, or arrays that don't fit them.

    Examples
    --------
    >>> import numpy as np
    >>> x, y = np.meshgrid(np.arange(20) / 50, np.arange(20) / 50)
    >>> cloud = PointCloud(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), viewpoint=(0, 0, 2))
    >>> cloud, cloud.face_normals[0].round(2) + 0.0
    (PointCloud(400 points), array([0., 0., 1.]))
    """

    is_cloud = True
    noun = "point"

    def __init__(
        self,
        points: Any,
        normals: Any = None,
        colors: Any = None,
        viewpoint: Any = None,
        *,
        source: str = "",
        report: tuple[str, ...] = (),
        faces_of_file: Any = None,
        n_file_faces: int = 0,
    ) -> None:
        places = np.asarray(points)
        if places.dtype.kind not in "iuf":
            raise TypeError(f"points must be an array of numbers, got dtype {places.dtype}")
        if places.ndim != 2 or places.shape[1] != 3 or not len(places):
            raise MeshError(f"points must have shape (n_points, 3) with at least one, got {places.shape}")
        if not np.isfinite(places).all():
            n = int((~np.isfinite(places).all(axis=1)).sum())
            raise MeshError(
                f"points has NaN or infinite positions in {n} rows; drop them: "
                "points[np.isfinite(points).all(axis=1)]"
            )
        index = np.arange(len(places), dtype=np.int32)
        faces = np.stack([index] * 3, axis=1)
        super().__init__(places, faces, colors, source, faces_of_file, n_file_faces, report)
        self._keep("given_normals", normals, np.float32)
        self._keep("viewpoint", viewpoint, np.float64)

    def _keep(self, name: str, value: Any, dtype: Any) -> None:
        """Set a read-only array a point, or one for all where it is a position."""
        if value is not None:
            array: Any = np.array(value, dtype=dtype)
            wanted = [(self.n_faces, 3)] + ([(3,)] if name == "viewpoint" else [])
            if array.shape not in wanted:
                short = name.removeprefix("given_")
                raise MeshError(f"{short} must have shape ({self.n_faces}, 3), got {array.shape}")
            if name == "given_normals":
                length = np.linalg.norm(array, axis=1, keepdims=True)
                is_usable = np.isfinite(length) & (length > 0)
                array = np.where(is_usable, array, 0) / np.where(is_usable, length, 1)
                array = array if is_usable.any() else None  # as programs write that have none
            if array is not None:
                array.flags.writeable = False
            value = array
        object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        colors = "" if self.vertex_colors is None else ", coloured"
        return f"PointCloud({self.n_faces} points{colors})"

    @property
    def points(self) -> FloatArray:
        """(n_points, 3) float64 positions, metres."""
        return self.vertices

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, 3) least and most of the coordinates, metres."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @cached_property
    def _order(self) -> IntArray:
        """(n_points,) int32 the points along a curve: what lies close together is close in memory then."""
        return along_curve(self.points).astype(np.int32)

    @cached_property
    def _near(self) -> tuple[IntArray, FloatArray]:
        """Nearest other points, (n_points, up to 8) int32 places in `_order` and float32, nearest first.

        Rows are in that order, too.
        """
        return self._nearest(N_AREA)

    def _nearest(self, k: int) -> tuple[IntArray, FloatArray]:
        k = min(k, self.n_faces - 1)
        index = np.empty((self.n_faces, k), np.int32)
        distance = np.empty((self.n_faces, k), np.float32)
        if k == 0:
            return index, distance
        places = self.points[self._order]  # asked one after the other, neighbours share a path down the tree
        tree = cKDTree(places, balanced_tree=False)

        def ask(rows: slice) -> None:
            apart, found = tree.query(places[rows], k=k + 1)
            index[rows], distance[rows] = found[:, 1:], apart[:, 1:]

        by_parts(ask, self.n_faces)
        return index, distance

    def _as_given(self, along: npt.NDArray[T]) -> npt.NDArray[T]:
        """Rows that stand in `_order`, in the order of the points."""
        out = np.empty_like(along)
        out[self._order] = along
        return out

    @cached_property
    def spacing(self) -> float:
        """Median distance to the sixth neighbour, metres."""
        distance = self._near[1]
        return float(np.median(distance[:, min(N_NEAR, distance.shape[1]) - 1])) if distance.size else 0.0

    @cached_property
    def face_areas(self) -> FloatArray:
        """(n_points,) square metres: an eighth of the disc that reaches to the eighth neighbour."""
        distance = self._near[1]
        if not distance.size:
            return np.zeros(self.n_faces)
        k = min(N_AREA, distance.shape[1])
        areas = np.pi / k * distance[:, k - 1].astype(np.float64) ** 2
        return self._as_given(np.minimum(areas, np.quantile(areas, LARGEST_AREA)))

    @cached_property
    def face_normals(self) -> FloatArray:
        """(n_points, 3) unit normals, zero where a point has too few neighbours."""
        given = self.given_normals  # type: ignore[attr-defined]  # set by _keep
        if given is not None:
            return self._completed(np.asarray(given, dtype=np.float64))
        viewpoint = self.viewpoint  # type: ignore[attr-defined]  # as above
        if viewpoint is None:
            return self._consistent()
        normals = self._tangent_planes()
        away = np.einsum("ij,ij->i", normals, self.points - viewpoint) > 0
        return np.where(away[:, None], -normals, normals)

    def _completed(self, given: FloatArray) -> FloatArray:
        """Given normals, and those of tangent planes where some are missing, turned as the nearest."""
        is_bare = ~given.any(axis=1)
        if not is_bare.any():
            return given
        planes = self._tangent_planes()[is_bare]
        _, nearest = cKDTree(self.points[~is_bare]).query(self.points[is_bare])
        looks_away = np.einsum("ij,ij->i", planes, given[~is_bare][nearest]) < 0
        out = given.copy()
        out[is_bare] = np.where(looks_away[:, None], -planes, planes)
        return out

    @property
    def has_sides(self) -> bool:
        """Whether the sides that normals point to were given; else neighbours agree, and all may be wrong."""
        return self.given_normals is not None or self.viewpoint is not None  # type: ignore[attr-defined]

    @cached_property
    def face_vectors(self) -> FloatArray:
        """(n_points, 3) normals, as long as twice the area."""
        return np.asarray(2.0 * self.face_areas[:, None] * self.face_normals)

    @cached_property
    def face_centroids(self) -> FloatArray:
        """(n_points, 3) the points."""
        return self.points

    def seam_lengths(self, pairs: IntArray) -> FloatArray:
        """(n_pairs,) metres of a border for which a pair of neighbours on its two sides stands.

        A line across points of area a crosses (2/π) · (length of all pairs a square metre), Buffon's needle,
        that is about 2.3/√a pairs a metre.

        Parameters
        ----------
        pairs : (n_pairs, 2) int
        """
        return np.asarray(SEAM * np.sqrt(self.face_areas[pairs].mean(axis=1)))

    def part(self, faces: IntArray) -> PointCloud:
        """Some of the points, with their normals.

        Parameters
        ----------
        faces : (n,) int
            Which.
        """
        colors = None if self.vertex_colors is None else taken(self.vertex_colors, faces)
        normals, areas = taken(self.face_normals, faces), taken(self.face_areas, faces)
        some = PointCloud(taken(self.points, faces), normals, colors)
        for name, rows in (("face_normals", normals), ("face_areas", areas)):  # what each stood for among all
            rows.flags.writeable = False
            vars(some)[name] = rows
        return some

    def thinned(self, n: int) -> PointCloud:
        """At most so many of the points, drawn by a fixed seed; tangent planes are those of what is left.

        Parameters
        ----------
        n : int
        """
        if n >= self.n_faces:
            return self
        some = np.sort(np.random.default_rng(0).choice(self.n_faces, n, replace=False))
        given, stood = self.given_normals, self.viewpoint  # type: ignore[attr-defined]  # set by _keep
        stood = stood[some] if stood is not None and stood.ndim == 2 else stood
        return PointCloud(self.points[some], None if given is None else given[some], viewpoint=stood)

    def chosen(self, faces: IntArray) -> PointCloud:
        """As `part`: of a cloud, vertices are points.

        Parameters
        ----------
        faces : (n,) int
        """
        return self.part(faces)

    @cached_property
    def triangles(self) -> IntArray:
        """(n_triangles, 3) int32 triangles at each point of the Delaunay triangulation of its neighbours.

        The up to 16 nearest points within reach that look to the same side count, in the tangent plane
        (Clarenz, Rumpf and Telea 2004; Belkin, Sun and Wang 2009). A triangle comes up to three times, once
        for each corner that has it. Where the surface ends, the fan of a point is open.
        """
        index, distance = self._nearest(N_AROUND)
        n, k = index.shape
        found = np.empty((n * max(k, 1), 3), np.int32)
        order, reach = self._order, REACH * self.spacing
        count = _stars(self.points[order], self.face_normals[order], index, distance, reach, BACK, found)
        triangles = taken(order, found[:count].ravel()).reshape(-1, 3)
        triangles.flags.writeable = False
        return triangles

    def _tangent_planes(self) -> FloatArray:
        """(n_points, 3) direction in which a point and its neighbours spread least, of either sign."""
        return self._as_given(self._planes_along)

    @cached_property
    def _planes_along(self) -> FloatArray:
        """The same in `_order`."""
        index = self._near[0][:, :N_NEAR].copy()
        out = np.zeros((self.n_faces, 3))
        if index.shape[1] >= 2:
            places = self.points[self._order]
            by_parts(lambda rows: _planes(places, index, out, rows.start, rows.stop), self.n_faces)
        return out

    def _consistent(self) -> FloatArray:
        """Normals that agree along the tree of neighbours that differ least (Hoppe et al. 1992)."""
        normals, pairs = self._planes_along, self._pairs_along
        if not len(pairs):
            return self._as_given(normals)
        dot = np.empty(len(pairs), np.float32)

        def dots_of(rows: slice) -> None:
            one, other = (np.take(normals, side, axis=0) for side in pairs[rows].T)
            np.einsum("ij,ij->i", one, other, out=dot[rows], casting="same_kind")

        by_parts(dots_of, len(pairs))
        # few steps: within one, pairs come along the curve, whose places are near in memory
        differ = (DIFFERENCES * np.sqrt(np.maximum(1.0 - np.abs(dot), 0.0))).astype(np.uint8)
        piece, is_turned = np.arange(self.n_faces), np.zeros(self.n_faces, dtype=np.bool_)
        _agree(pairs, dot < 0, np.argsort(differ, kind="stable"), piece, is_turned)
        areas, places = self.face_areas[self._order], self.points[self._order]
        normals = np.where(is_turned[:, None], -normals, normals)
        step = 1 + len(places) // N_FITTED
        side = _side_of_things(places[::step], normals[::step], areas[::step] + 1e-300)
        if side is None:  # a room: what is around the middle looks to it
            inward = np.average(places, axis=0, weights=areas + 1e-300) - places
            looks = np.bincount(piece, areas * np.einsum("ij,ij->i", normals, inward))
        else:
            looks = np.bincount(piece, areas * (normals @ side))
        return self._as_given(np.where((looks < 0)[piece][:, None], -normals, normals))

    @cached_property
    def _pairs_along(self) -> IntArray:
        """(n_pairs, 2) int32 places in `_order` of points within reach, each pair once, smaller first."""
        index, distance = self._near
        k = min(N_NEAR, index.shape[1])
        reach = REACH * self.spacing
        count = np.zeros(self.n_faces + 1, np.int64)
        empty = np.empty(0, np.int32)
        _pairs(index, distance, k, reach, count, empty, empty)
        starts = np.cumsum(count)
        pairs = np.full((2, int(starts[-1])), -1, np.int32)
        _pairs(index, distance, k, reach, starts, *pairs)
        return np.ascontiguousarray(pairs.T)

    @cached_property
    def _adjacency(self) -> IntArray:
        pairs = self._pairs_along
        is_one_side = np.empty(len(pairs), np.bool_)
        _look_alike(self.face_normals[self._order], pairs, BACK, is_one_side)
        one, other = taken(self._order, pairs[is_one_side].ravel()).reshape(-1, 2).T
        return in_order(one, other)


def _side_of_things(places: FloatArray, normals: FloatArray, areas: FloatArray) -> FloatArray | None:
    """Unit normal of the plane that much of the surface lies on, to the side where the rest of it lies.

    As of a table or a floor with things on it, seen from above. None where no plane has so much, or where
    there is nothing on it, or something on both sides.
    """
    total = areas.sum()
    normal = np.linalg.eigh((normals * areas[:, None]).T @ normals)[1][:, -1]
    low, high = np.percentile(places, [1, 99], axis=0)
    size = float(np.linalg.norm(high - low))
    height = places @ normal
    height = height - height.min()
    if not size > 0 or height.max() > 1e4 * size:
        return None
    facing = np.where(np.abs(normals @ normal) > STEEP, areas, 0.0)
    share = np.bincount((height / (BAND * size / 2)).astype(np.int64), facing)
    share = share[:-1] + share[1:] if len(share) > 1 else share
    is_near = np.abs(height - (share.argmax() + 1) * BAND * size / 2) <= BAND * size
    for shrunk in 0.7 ** np.arange(6):  # by places, for normals of single points lean by degrees
        if areas[is_near].sum() < THINGS * total:
            return None
        middle = np.average(places[is_near], axis=0, weights=areas[is_near])
        apart = places[is_near] - middle
        turned = np.linalg.eigh((apart * areas[is_near][:, None]).T @ apart)[1][:, 0]
        normal = -turned if turned @ normal < 0 else turned
        height = (places - middle) @ normal
        is_near = np.abs(height) < max(BAND * shrunk, THIN) * size
    above, below = (float(areas[sign * height > RISES * size].sum() / total) for sign in (1, -1))
    if areas[is_near].sum() < ON_PLANE * total or max(above, below) < max(THINGS, 4 * min(above, below)):
        return None
    return np.asarray(normal if above > below else -normal)


@kernel
def _look_alike(normals, pairs, back, out):  # type: ignore[no-untyped-def]
    """Whether the normals of each pair differ by less than two sides of one thing."""
    for at in range(len(pairs)):
        i, j = pairs[at, 0], pairs[at, 1]
        dot = normals[i, 0] * normals[j, 0] + normals[i, 1] * normals[j, 1] + normals[i, 2] * normals[j, 2]
        out[at] = dot > back


@kernel
def _pairs(index, distance, k, reach, at, first, second):  # type: ignore[no-untyped-def]
    """Count pairs at their smaller point + 1, or, where there is room, write them in order."""
    is_count = len(first) == 0
    for i in range(len(index)):
        for slot in range(k):
            j = index[i, slot]
            if j == i or distance[i, slot] > reach:
                continue
            low, high = min(i, j), max(i, j)
            if i > j:  # which has the pair already where they are mutual
                is_known = False
                for other in range(k):
                    is_known |= index[j, other] == i and distance[j, other] <= reach
                if is_known:
                    continue
            if is_count:
                at[low + 1] += 1
                continue
            place = at[low]
            at[low] += 1
            while place > 0 and first[place - 1] == low and second[place - 1] > high:
                first[place], second[place] = first[place - 1], second[place - 1]
                place -= 1
            first[place], second[place] = low, high


@kernel(allocates=True)
def _planes(points, index, out, first, last):  # type: ignore[no-untyped-def]
    """Direction in which points and their neighbours spread least, by Jacobi's rotations; none of lines."""
    k = index.shape[1]
    spread, axes, mean = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for i in range(first, last):
        for a in range(3):
            mean[a] = 0.0
            for b in range(3):
                spread[a, b] = 0.0
        for slot in range(k):
            j = index[i, slot]
            x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            mean[0] += x
            mean[1] += y
            mean[2] += z
            spread[0, 0] += x * x
            spread[0, 1] += x * y
            spread[0, 2] += x * z
            spread[1, 1] += y * y
            spread[1, 2] += y * z
            spread[2, 2] += z * z
        for a in range(3):
            for b in range(3):
                if b < a:
                    spread[a, b] = spread[b, a]
                else:
                    spread[a, b] -= mean[a] * mean[b] / (k + 1)
                axes[a, b] = 1.0 if a == b else 0.0
        for _ in range(12):  # six are enough for any
            rest = abs(spread[0, 1]) + abs(spread[0, 2]) + abs(spread[1, 2])
            if not rest > 1e-16 * (spread[0, 0] + spread[1, 1] + spread[2, 2]):
                break
            for p in range(2):
                for q in range(p + 1, 3):
                    if spread[p, q] == 0.0:
                        continue
                    ratio = (spread[q, q] - spread[p, p]) / (2.0 * spread[p, q])
                    tangent = (1.0 if ratio >= 0 else -1.0) / (abs(ratio) + np.sqrt(ratio * ratio + 1.0))
                    cosine = 1.0 / np.sqrt(tangent * tangent + 1.0)
                    sine = tangent * cosine
                    for r in range(3):
                        one, other = spread[r, p], spread[r, q]
                        spread[r, p], spread[r, q] = cosine * one - sine * other, sine * one + cosine * other
                    for r in range(3):
                        one, other = spread[p, r], spread[q, r]
                        spread[p, r], spread[q, r] = cosine * one - sine * other, sine * one + cosine * other
                        one, other = axes[r, p], axes[r, q]
                        axes[r, p], axes[r, q] = cosine * one - sine * other, sine * one + cosine * other
        least, most = 0, 0
        for a in range(1, 3):
            if spread[a, a] < spread[least, least]:
                least = a
            if spread[a, a] >= spread[most, most]:
                most = a
        middle = 3 - least - most
        if least != most and spread[middle, middle] > 1e-12 * max(spread[most, most], 1e-300):
            for a in range(3):
                out[i, a] = axes[a, least]


@kernel
def _root(point, root, is_turned):  # type: ignore[no-untyped-def]
    """The root of a point, and whether it is turned against that; points on the way are hung higher."""
    turn = False
    while root[point] != point:
        turn ^= is_turned[point]
        up = root[point]
        is_turned[point] ^= is_turned[up]
        root[point] = root[up]
        point = up
    return point, turn


@kernel
def _agree(pairs, is_against, order, root, is_turned):  # type: ignore[no-untyped-def]
    """Kruskal's tree along ``order``: the root of each point, and whether to turn it."""
    for at in range(len(order)):
        a, b = pairs[order[at], 0], pairs[order[at], 1]
        a, is_a_turned = _root(a, root, is_turned)
        b, is_b_turned = _root(b, root, is_turned)
        turn = is_against[order[at]] ^ is_a_turned ^ is_b_turned
        if a != b:
            root[max(a, b)] = min(a, b)
            is_turned[max(a, b)] = turn
    for point in range(len(root)):  # roots come before what hangs on them
        up = root[point]
        if up != point:
            is_turned[point] ^= is_turned[up]
            root[point] = root[up]


@kernel(allocates=True)
def _stars(points, normals, index, distance, reach, back, out):  # type: ignore[no-untyped-def]
    """Delaunay triangles around each point, wrapped from neighbour to neighbour; how many there are.

    The next neighbour after a, counter-clockwise, is the b that sees the edge from the point to a under the
    largest angle: the circle through the three is empty (McLain 1976).
    """
    n, k = index.shape
    x, y = np.empty(k), np.empty(k)
    who = np.empty(k, np.int64)
    count = 0
    for i in range(n):
        nx, ny, nz = normals[i]
        if nx * nx + ny * ny + nz * nz < 0.5:
            continue
        # two axes of the tangent plane
        if abs(nx) < 0.6:
            ax, ay, az = 0.0, nz, -ny
        else:
            ax, ay, az = -nz, 0.0, nx
        length = np.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax / length, ay / length, az / length
        bx, by, bz = ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax
        m, start, least = 0, -1, np.inf
        for slot in range(k):
            j = index[i, slot]
            if not 0 < distance[i, slot] <= reach:
                continue
            if nx * normals[j, 0] + ny * normals[j, 1] + nz * normals[j, 2] <= back:
                continue
            dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            x[m], y[m] = dx * ax + dy * ay + dz * az, dx * bx + dy * by + dz * bz
            size = x[m] * x[m] + y[m] * y[m]
            if not size > 0:
                continue
            who[m] = j
            if size < least:
                start, least = m, size
            m += 1
        if m < 2:
            continue
        for turn in (1.0, -1.0):
            a = start
            for _ in range(m):
                best, lowest = -1, np.inf
                length_a = np.sqrt(x[a] * x[a] + y[a] * y[a])
                for b in range(m):
                    cross = turn * (x[a] * y[b] - y[a] * x[b])
                    size = x[b] * x[b] + y[b] * y[b]
                    if cross <= FLAT * length_a * np.sqrt(size):
                        continue
                    cotangent = (size - x[a] * x[b] - y[a] * y[b]) / cross
                    if cotangent < lowest:
                        best, lowest = b, cotangent
                if best < 0:
                    break
                dx, dy = x[best] - x[a], y[best] - y[a]
                if dx * dx + dy * dy > reach * reach:
                    break
                out[count, 0] = i
                out[count, 1] = who[a] if turn > 0 else who[best]
                out[count, 2] = who[best] if turn > 0 else who[a]
                count += 1
                a = best
                if a == start:
                    break
            if a == start:  # all the way round
                break
    return count
