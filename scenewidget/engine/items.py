"""What is clustered: faces of a simplified mesh (thesis), or superfacets of the raw mesh (default).

Goes in: a mesh. Comes out: one graph type that everything from distances to consensus works on, without
asking which of the two its nodes are.

A superfacet is a small connected patch of the raw mesh with nearly one normal. Labels of superfacets map
back to the raw faces exactly, and nothing is thrown away to get down to a size that can be clustered.
"""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.spatial import cKDTree

from scenewidget.engine.features import vertex_to_face
from scenewidget.engine.felzenszwalb import grown_pieces, without_small
from scenewidget.engine.mesh import (
    BoolArray,
    FloatArray,
    IntArray,
    Mesh,
    MeshError,
    ascending,
    connected_components,
    face_adjacency,
    in_order,
    taken,
)
from scenewidget.engine.moments import Moments, group_moments, mean_normals, moment_origin
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.preprocess import filter_normals, simplify
from scenewidget.engine.scale import far_apart, geometric_order, own_frame, scene_scale, turned
from scenewidget.engine.threads import at_once, by_parts, n_threads

__all__ = ["Items", "Touching", "find_bridges", "patch_items", "simplified_items", "superfacet_items"]

T = TypeVar("T", bound=np.generic)

FEWEST_ITEMS = 1_000  # that there is room for, however small the scene
FARTHER = 1.35  # that a sweep over the neighbours of a point reaches than over those of a face as large
SCENE = 0.05  # of the scan's area; what is smaller and floats far off is looked at with the largest island
WORST = ("area of the smallest superfacet", "sweeps of the normal filter")  # of all islands the most


@dataclass(frozen=True, eq=False)
class Touching:
    """Pairs of neighbouring items whose labels differ.

    Attributes
    ----------
    labels : (n_touching, 2) int
        Of the two, in the order of ``Items.pairs``; two labels that touch in several places come as often.
    seam_edges : (n_touching,) int64
        Number of edges of the mesh along which the two items meet.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.arange(8) // 2)
    >>> borders = items.touching(np.array([0, 0, 1, 1]))
    >>> borders.labels.tolist(), borders.seam_edges.tolist()
    ([[0, 1], [0, 1]], [1, 1])
    """

    labels: IntArray
    seam_edges: IntArray


@dataclass(frozen=True, eq=False)
class Items:
    """A graph of surface patches.

    Attributes
    ----------
    areas : (n,) float64
        Square metres.
    centroids : (n, 3) float64
        Metres.
    normals : (n, 3) float64
        Unit area-weighted mean normals; zero where the normals cancel.
    moments : Moments
        Of each item, about the centre of the mesh's bounding box.
    pairs : (n_pairs, 2) int32
        Neighbouring items, each pair once, smaller first, in lexicographic order; bridges included.
    seam_pair : (n_seams,) int32
        Index into ``pairs`` of each pair of faces that meet across it.
    seam_dot : (n_seams,) float32
        Dot product of the two faces' normals.
    mesh : Mesh
        The mesh that the items are made of: the simplified one, or the raw one.
    item_of_face : (mesh.n_faces,) int32
        Item of each face of that mesh, −1 where it was dropped.
    face_map : (n_raw_faces,) int32
        Item of each face of the mesh as loaded, −1 where it was dropped.
    report : dict
        What was reached and dropped.
    island : (n,) int32
        Items of different islands are so far apart that they are scenes of their own.
    scales : (n_islands,) float64
        Metres in a unit of each island's scene; see `scale.scene_scale`.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.array([0, 0, 0, 0, 1, 1, 1, 1]))
    >>> items, items.areas.tolist(), items.pairs.tolist(), items.seam_edges.tolist()
    (Items(2 items, 1 pairs), [0.5, 0.5], [[0, 1]], [2])
    >>> items.to_faces(np.array([5, 6]), -1).tolist()
    [5, 5, 5, 5, 6, 6, 6, 6]
    """

    areas: FloatArray
    centroids: FloatArray
    normals: FloatArray
    moments: Moments
    pairs: IntArray
    seam_pair: IntArray
    seam_dot: FloatArray
    mesh: Mesh
    item_of_face: IntArray
    face_map: IntArray
    report: dict[str, Any] = field(default_factory=dict)
    island: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int32))
    scales: FloatArray = field(default_factory=lambda: np.ones(1))

    def __post_init__(self) -> None:
        if len(self.island) != len(self.areas):
            object.__setattr__(self, "island", np.zeros(len(self.areas), dtype=np.int32))
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __repr__(self) -> str:
        return f"Items({self.n} items, {len(self.pairs)} pairs)"

    @property
    def n(self) -> int:
        """Number of items."""
        return len(self.areas)

    @property
    def scale(self) -> float:
        """Metres in a unit of the scene, where there is one island; of the largest otherwise."""
        return float(self.scales[0])

    @cached_property
    def sizes(self) -> FloatArray:
        """(n,) areas in square units of each item's scene."""
        return np.asarray(self.areas / self.scales[self.island] ** 2)

    @cached_property
    def islands(self) -> tuple[tuple[IntArray, Items], ...]:
        """Members, (n_members,) ascending, and items of each island."""
        if len(self.scales) == 1:
            return ((np.arange(self.n), self),)
        return tuple((np.flatnonzero(self.island == i), self._part(i)) for i in range(len(self.scales)))

    def _part(self, island: int) -> Items:
        inside = self.island == island
        number = np.append(np.where(inside, np.cumsum(inside) - 1, -1), -1).astype(np.int32)
        is_inner = inside[self.pairs].all(axis=1)
        pair = np.where(is_inner, np.cumsum(is_inner) - 1, -1)[self.seam_pair].astype(np.int32)
        return dataclasses.replace(
            self,
            areas=self.areas[inside],
            centroids=self.centroids[inside],
            normals=self.normals[inside],
            moments=Moments(
                self.moments.area[inside], self.moments.first[inside], self.moments.second[inside]
            ),
            pairs=number[self.pairs[is_inner]],
            seam_pair=pair[pair >= 0],
            seam_dot=self.seam_dot[pair >= 0],
            item_of_face=number[self.item_of_face],
            face_map=number[self.face_map],
            island=np.zeros(int(inside.sum()), dtype=np.int32),
            scales=self.scales[island : island + 1],
        )

    @cached_property
    def lengths(self) -> FloatArray:
        """(n_pairs,) distance of the two centroids, metres."""
        return np.asarray(
            np.linalg.norm(self.centroids[self.pairs[:, 0]] - self.centroids[self.pairs[:, 1]], axis=1)
        )

    @cached_property
    def seam_edges(self) -> IntArray:
        """(n_pairs,) number of edges of the mesh along which the two items meet."""
        return np.bincount(self.seam_pair, minlength=len(self.pairs))

    @cached_property
    def graph(self) -> sparse.csr_array:
        """(n, n) symmetric csr: distance of the centroids of neighbouring items, metres."""
        rows, columns = np.concatenate([self.pairs, self.pairs[:, ::-1]]).T
        return sparse.csr_array((np.tile(self.lengths, 2), (rows, columns)), shape=(self.n, self.n))

    @cached_property
    def is_convex(self) -> BoolArray:
        """(n_pairs,) whether the surface bulges towards the side that the normals point to."""
        i, j = self.pairs.T
        apart = self.centroids[j] - self.centroids[i]
        return np.asarray(np.einsum("ij,ij->i", apart, self.normals[j] - self.normals[i]) > 0)

    @cached_property
    def faces_by_item(self) -> tuple[IntArray, IntArray]:
        """Faces sorted by item, and where each item's begin and end in that order, (n + 1,)."""
        order = ascending(self.item_of_face).astype(np.int32)
        return order, np.searchsorted(self.item_of_face[order], np.arange(self.n + 1))

    @cached_property
    def face_tints(self) -> FloatArray | None:
        """(2, mesh.n_faces) red against green and yellow against blue; None without colours.

        From the logarithms of the channels: shadows don't change them, and 0.1 is a tenth.
        """
        colors = self.mesh.vertex_colors
        if colors is None:
            return None
        logs = np.log(np.arange(256) + 10.0)[colors]  # the darkest are mostly noise
        one, other, third = (logs[corner] for corner in self.mesh.faces.T)
        r, g, b = ((one + other + third) / 3).T
        return np.stack([r - g, (r + g) / 2 - b])

    @cached_property
    def component(self) -> IntArray:
        """(n,) int32 connected component of each item."""
        return connected_components(self.n, self.pairs)[1]

    def to_faces(self, values: npt.NDArray[T], fill: float) -> npt.NDArray[T]:
        """(n_raw_faces,) the value of its item for each face of the mesh as loaded, ``fill`` where dropped.

        Parameters
        ----------
        values : (n,)
        fill : number
        """
        return np.append(values, np.asarray(fill, values.dtype))[self.face_map]  # item −1 is the last entry

    def from_vertices(self, values: FloatArray) -> FloatArray:
        """(n, d) of each item: mean of a face's corners, then the area-weighted mean over its faces.

        Parameters
        ----------
        values : (mesh.n_vertices, d) float
        """
        return self.from_faces(vertex_to_face(self.mesh, values))

    def from_faces(self, by_face: FloatArray) -> FloatArray:
        """(n, d) of each item: the area-weighted mean over its faces.

        Parameters
        ----------
        by_face : (mesh.n_faces, d) float
        """
        keep = self.item_of_face >= 0
        item, area = self.item_of_face[keep], self.mesh.face_areas[keep]
        if len(item) == self.n:
            return by_face[keep][np.argsort(item)]
        sums = np.stack([np.bincount(item, area * column[keep], self.n) for column in by_face.T], axis=1)
        return np.asarray(sums / np.where(self.areas > 0, self.areas, 1.0)[:, None])

    def from_raw_faces(self, by_face: FloatArray, raw: Mesh) -> FloatArray:
        """(n, d) of each item: the area-weighted mean over faces of the mesh as loaded.

        An item to which no face was mapped has the values of the nearest face.

        Parameters
        ----------
        by_face : (n_raw_faces, d) float
        raw : Mesh
            As loaded.
        """
        if len(self.item_of_face) == len(self.face_map):  # it was not simplified
            return self.from_faces(by_face)
        keep = self.face_map >= 0
        item, area = self.face_map[keep], raw.face_areas[keep]
        total = np.bincount(item, area, self.n)
        sums = np.stack([np.bincount(item, area * column[keep], self.n) for column in by_face.T], axis=1)
        values = np.asarray(sums / np.where(total > 0, total, 1.0)[:, None])
        is_bare = total == 0
        if is_bare.any():
            _, near = cKDTree(raw.face_centroids).query(self.centroids[is_bare])
            values[is_bare] = by_face[near]
        return values

    def touching(self, labels: IntArray) -> Touching:
        """Where items of different labels are neighbours; items in no segment don't count.

        Parameters
        ----------
        labels : (n,) int
            −1 for items in no segment.
        """
        ends = labels[self.pairs]
        crossing = (ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1)
        return Touching(ends[crossing], self.seam_edges[crossing])


def simplified_items(
    mesh: Mesh,
    pairs: IntArray,
    *,
    scale: float | Literal["auto"] = 1.0,
    monitor: Monitor | None = None,
    **options: Any,
) -> Items:
    """Faces of the simplified mesh as items; ``options`` are those of `preprocess.simplify`.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int32
        `face_adjacency` of the mesh.
    scale : float or "auto"
        Metres in a unit of the scene; "auto" is `scale.scene_scale`.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.
    **options
        Of `preprocess.simplify`.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import simplified_items
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> mesh = square(20)
    >>> simplified_items(mesh, face_adjacency(mesh), n_faces=100).n <= 100
    True
    """
    simplified = simplify(mesh, pairs, monitor=monitor, **options)
    small = simplified.mesh
    item_of_face = np.arange(small.n_faces, dtype=np.int32)
    s = scene_scale(mesh) if scale == "auto" else float(scale)
    return patch_items(
        small,
        item_of_face,
        pairs=simplified.pairs,
        face_map=simplified.face_map,
        report=simplified.report,
        scales=np.array([s]),
    )


def superfacet_items(
    mesh: Mesh,
    pairs: IntArray,
    *,
    scale: float | Literal["auto"] = "auto",
    n_items: int = 6_000,
    item_area: float = 0.003,
    sweeps: int | Literal["auto"] = "auto",
    threshold: float = 1e-7,
    bridge: float = 0.06,
    apart: float = 1.0,
    monitor: Monitor | None = None,
) -> Items:
    """Superfacets of the raw mesh as items.

    Felzenszwalb's rule on filtered normals, w = |N_i − N_j|² / 2, over adjacent faces and bridges between
    fragments, sized by area, so that finer faces don't give smaller items; the minimum size is raised by 1.4
    until they are few enough. Fragments below it that float free of everything are dropped, except for the
    largest where 90 % of the faces can't be had without.
    Parts of the mesh that are far apart are islands: each has superfacets as it would have alone. The order
    of the faces changes nothing.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int32
        `face_adjacency` of the mesh.
    scale : float or "auto"
        Metres in a unit of the scene; "auto" is `scale.scene_scale` of each island.
    n_items : int
        Most items.
    item_area : float
        What an item has at least, square units of the scene.
    sweeps : int or "auto"
        Of `preprocess.filter_normals`; "auto" is `sweeps_for`.
    threshold : float
        Of `join_light_edges`, in square units of the scene.
    bridge : float
        Fragments whose borders are at most so far apart count as neighbours, units of the scene.
    apart : float
        Islands are at least so far apart, units of the scene.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import folded, square
    >>> from scenewidget.engine.items import superfacet_items
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> mesh = folded(square(20), "x", 0.5, np.pi / 2)
    >>> items = superfacet_items(mesh, face_adjacency(mesh), n_items=10)
    >>> items.n <= 10, np.abs(items.normals).max(axis=1).min().round(2).item()
    (True, 1.0)
    """
    monitor = monitor or SILENT
    total = float(mesh.face_areas.sum())
    if not total > 0:
        raise MeshError("the mesh has no face with an area: it has no surface to segment")
    _ = mesh.face_normals, mesh.face_centroids  # wanted of both: to put them in order is less work than anew
    frame = monitor.call(own_frame, mesh.face_centroids, mesh.face_areas)
    whole = scene_scale(mesh, frame) if scale == "auto" else float(scale)
    island, in_frame = monitor.call(
        at_once, partial(far_apart, mesh, pairs, apart * whole), partial(geometric_order, mesh, frame)
    )
    areas = np.bincount(island, mesh.face_areas)
    island = np.where(areas[island] >= max(SCENE, 100 / n_items) * total, island, 0).astype(np.int32)
    n_islands = int(island.max()) + 1
    frames, units, orders = [], [], []
    for i in range(n_islands):
        order, unit = in_frame, whole
        if n_islands > 1:
            faces = np.flatnonzero(island == i)
            alone = mesh.part(faces)
            frame = monitor.call(own_frame, alone.face_centroids, alone.face_areas)
            unit = scene_scale(alone, frame) if scale == "auto" else whole
            order = faces[monitor.call(geometric_order, alone, frame)]
        frames.append(frame)
        units.append(unit)
        orders.append(order)
    order = np.concatenate(orders)
    ordered, island = mesh.chosen(order), island[order]
    place = np.empty(mesh.n_faces, dtype=np.int32)
    place[order] = np.arange(mesh.n_faces, dtype=np.int32)
    pairs = in_order(*taken(place, pairs.ravel()).reshape(-1, 2).T)
    areas = np.bincount(island, ordered.face_areas)
    scales = np.array(units)
    item, face_map = np.empty(mesh.n_faces, np.int32), np.empty(mesh.n_faces, np.int32)
    normals = np.empty((mesh.n_faces, 3), np.float32)
    links: list[IntArray] = []
    homes: list[IntArray] = []
    report: dict[str, Any] = {}
    for i, s in enumerate(scales):
        own: Any = slice(None)
        inner = pairs
        if len(scales) > 1:
            own = np.flatnonzero(island == i)
            number = np.empty(mesh.n_faces, dtype=np.int32)
            number[own] = np.arange(len(own), dtype=np.int32)
            inner = number[pairs[island[pairs[:, 0]] == i]]
        made = _superfacets(
            ordered.chosen(own) if len(scales) > 1 else ordered,
            inner,
            frames[i],
            n_items=max(2, round(n_items * float(areas[i] / total))),
            item_area=item_area * s**2,
            sweeps=sweeps,
            threshold=threshold * s**2,
            bridge=bridge * s,
            scale=s,
            monitor=monitor,
        )
        offset = sum(len(h) for h in homes)
        item[own] = np.where(made.item >= 0, made.item + offset, -1)
        face_map[own] = np.where(made.face_map >= 0, made.face_map + offset, -1)
        normals[own] = made.normals  # of faces in one island only the angles between them are asked for
        links.append(made.links if len(scales) == 1 else own[made.links])
        homes.append(np.full(int(made.item.max()) + 1, i, dtype=np.int32))
        for name, value in made.report.items():
            report[name] = max(report.get(name, 0), value) if name in WORST else report.get(name, 0) + value
    items = monitor.call(
        patch_items,
        ordered,
        item,
        pairs=np.concatenate(links),
        normals=normals,
        face_map=face_map,
        report=report,
        island=np.concatenate(homes),
        scales=scales,
    )
    return dataclasses.replace(items, mesh=mesh, item_of_face=item[place], face_map=face_map[place])


class _Superfacets(NamedTuple):
    item: IntArray  # of each face, −1 where dropped
    face_map: IntArray  # the same with specks given to the nearest superfacet
    normals: FloatArray  # of the faces, filtered
    links: IntArray  # neighbouring faces, bridges included
    report: dict[str, float]


def sweeps_for(edge: float) -> int:
    """Sweeps of the normal filter that reach as far on any mesh: (0.11 / edge)², from 30 to 200.

    Noise reaches as far as the scanner's blur, some centimetres in a room, not some faces.

    Parameters
    ----------
    edge : float
        Length of an edge, units of the scene.

    Examples
    --------
    >>> [sweeps_for(edge) for edge in (0.03, 0.011, 0.001)]
    [30, 100, 200]
    """
    return int(np.clip((0.11 / max(edge, 1e-9)) ** 2, 30, 200))


def _superfacets(
    mesh: Mesh,
    pairs: IntArray,
    frame: FloatArray,
    *,
    n_items: int,
    item_area: float,
    sweeps: int | Literal["auto"],
    threshold: float,
    bridge: float,
    scale: float,
    monitor: Monitor,
) -> _Superfacets:
    """Of an island; areas and lengths in metres, normals filtered along the axes of its own ``frame``.

    So what float32 rounds is the same however the file turns the scan.
    """
    if sweeps == "auto":
        edge = float(np.sqrt(2.0 * np.median(mesh.face_areas))) / scale
        sweeps = sweeps_for(FARTHER * edge if mesh.is_cloud else edge)
    smooth = partial(
        filter_normals,
        mesh,
        pairs,
        normals=turned(mesh.face_normals, frame),
        sweeps=sweeps,
        n_threads=n_threads(),
        monitor=monitor,
    )
    normals, bridges = at_once(smooth, partial(find_bridges, mesh, pairs, bridge))
    monitor.tick(0.5)
    links = np.concatenate([pairs, bridges])
    weights = np.empty(len(links), dtype=np.float32)

    def half_squares(rows: slice) -> None:  # 1 − N_i·N_j, whose digits float32 would lose
        steps = np.take(normals, links[rows, 0], axis=0) - np.take(normals, links[rows, 1], axis=0)
        np.multiply(0.5, np.einsum("ij,ij->i", steps, steps), out=weights[rows])

    by_parts(half_squares, len(links))
    order = monitor.call(ascending, weights)
    monitor.tick(0.7)
    areas, smallest = mesh.face_areas, min(item_area, float(mesh.face_areas.sum()) / FEWEST_ITEMS)
    grown = monitor.call(
        grown_pieces, mesh.n_faces, links, weights, threshold=threshold, sizes=areas, order=order
    )
    while True:
        label = monitor.call(without_small, grown, smallest)
        count, area = np.bincount(label), np.bincount(label, areas).astype(np.float64)
        is_kept = (
            area >= smallest
        )  # what is below has no neighbour within reach: crumbs that float in the air
        if is_kept.sum() <= n_items:
            break
        smallest *= 1.4
        monitor.tick(0.8)
    is_kept = _with_crumbs(is_kept, count, area, n_items)
    item = np.where(is_kept, np.cumsum(is_kept) - 1, -1).astype(np.int32)[label]
    face_map = monitor.call(_with_specks, mesh, item, bridge)
    report = {
        "superfacets": int(is_kept.sum()),
        "area of the smallest superfacet": float(smallest),
        "sweeps of the normal filter": sweeps,
        "faces of specks given to the nearest superfacet": int((face_map != item).sum()),
        "faces floating free of everything": int((face_map < 0).sum()),
        "bridges between fragments": len(bridges),
    }
    return _Superfacets(item, face_map, normals, links, report)


def patch_items(
    mesh: Mesh,
    patch: IntArray,
    *,
    pairs: IntArray | None = None,
    normals: FloatArray | None = None,
    face_map: IntArray | None = None,
    report: dict[str, Any] | None = None,
    island: IntArray | None = None,
    scales: FloatArray | None = None,
) -> Items:
    """Given patches as items: sums over their faces, and the graph of patches from the graph of faces.

    Parameters
    ----------
    mesh : Mesh
        What the patches are made of.
    patch : (n_faces,) int
        Patch of each face, dense; −1 for faces that are dropped.
    pairs : (n_pairs, 2) int, optional
        Neighbouring faces; `face_adjacency` by default.
    normals : (n_faces, 3) float, optional
        Those that ``seam_dot`` compares; of the faces by default.
    face_map : (n_raw_faces,) int32, optional
        Patch of each face of the mesh as loaded, where that is another mesh or has more faces in patches.
    report : dict, optional
    island : (n_patches,) int32, optional
    scales : (n_islands,) float64, optional
        See `Items`.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.array([0, 0, 0, 0, 1, 1, 1, -1]))
    >>> items.areas.tolist(), items.face_map.tolist()
    ([0.5, 0.375], [0, 0, 0, 0, 1, 1, 1, -1])
    """
    item_of_face = np.asarray(patch, dtype=np.int32)
    face_pairs = face_adjacency(mesh) if pairs is None else pairs
    normals = mesh.face_normals if normals is None else normals
    n = int(item_of_face.max()) + 1
    moments = group_moments(mesh, item_of_face, n)
    item_normals = mean_normals(mesh.face_vectors, item_of_face, n)
    one, other = (np.take(item_of_face, side) for side in face_pairs.T)
    seams = np.flatnonzero((one >= 0) & (other >= 0) & (one != other))
    one, other, faces = one[seams].astype(np.int64), other[seams], face_pairs[seams]
    code, seam_pair = np.unique(np.minimum(one, other) * n + np.maximum(one, other), return_inverse=True)
    pairs = np.stack([code // n, code % n], axis=1).astype(np.int32)
    seam_dot = np.einsum("ij,ij->i", normals[faces[:, 0]], normals[faces[:, 1]]).astype(np.float32)
    centroids = moments.centroid + moment_origin(mesh)
    return Items(
        moments.area, centroids, item_normals, moments, pairs, seam_pair.astype(np.int32), seam_dot,
        mesh, item_of_face, item_of_face if face_map is None else face_map, report or {},
        np.zeros(n, dtype=np.int32) if island is None else island,
        np.ones(1) if scales is None else scales,
    )  # fmt: skip


def _with_crumbs(is_kept: BoolArray, count: IntArray, area: FloatArray, n_items: int) -> BoolArray:
    """Patches that become items: where those kept hold less than 90 % of the faces, the largest others too.

    Never more than ``n_items``, the largest by area: everything behind grows with the square of it.
    """
    is_kept = is_kept.copy()
    missing = 0.9 * count.sum() - count[is_kept].sum()
    if missing > 0:
        others = np.flatnonzero(~is_kept & (area > 0))
        others = others[np.argsort(-area[others], kind="stable")]
        needed = int(np.searchsorted(np.cumsum(count[others]), missing)) + 1
        is_kept[others[: min(needed, max(0, n_items - int(is_kept.sum())))]] = True
    if is_kept.sum() > n_items:
        kept = np.flatnonzero(is_kept)
        is_kept[kept[np.argsort(-area[kept], kind="stable")[n_items:]]] = False
    return is_kept


def _with_specks(mesh: Mesh, item: IntArray, reach: float) -> IntArray:
    """Map of all faces to items in which the faces of no item have the nearest one, if within reach.

    Specks that hover before a surface without touching it get its label, but don't shape the item.
    """
    lost, kept = np.flatnonzero(item < 0), np.flatnonzero(item >= 0)
    if len(lost) == 0 or reach <= 0:
        return item
    targets = kept[:: max(1, len(kept) // 400_000)]  # a coarse look is enough at this distance
    targets = targets[_are_near(mesh.face_centroids, targets, lost, reach)]
    if len(targets) == 0:
        return item
    distance, near = cKDTree(mesh.face_centroids[targets]).query(
        mesh.face_centroids[lost], distance_upper_bound=reach, workers=n_threads()
    )
    face_map = item.copy()
    face_map[lost] = np.where(np.isfinite(distance), np.append(item[targets], -1)[near], -1)
    return face_map


def _are_near(places: FloatArray, ones: IntArray, others: IntArray, reach: float) -> BoolArray:
    """Which of some places may lie within reach of others: those in a cell of such a one, or beside."""
    low = places[others].min(axis=0)
    side = max(1.001 * reach, float((places[others].max(axis=0) - low).max()) / 128)  # so there are few cells

    def cells(which: IntArray) -> IntArray:
        return np.asarray(np.floor((places[which] - low) / side).astype(np.int64) + 2)

    full = cells(others)
    shape = full.max(axis=0) + 3  # two empty ones around all
    is_near = np.zeros(shape, dtype=np.bool_)
    for step in itertools.product((-1, 0, 1), repeat=3):
        is_near[tuple((full + step).T)] = True
    out = np.empty(len(ones), dtype=np.bool_)

    def look(rows: slice) -> None:
        out[rows] = is_near[tuple(np.clip(cells(ones[rows]), 0, shape - 1).T)]

    by_parts(look, len(ones))
    return out


def find_bridges(mesh: Mesh, pairs: IntArray, reach: float) -> IntArray:
    """Pairs of border faces of different components that lie close to each other.

    Parameters
    ----------
    mesh : Mesh
    pairs : (n_pairs, 2) int32
        Adjacent faces.
    reach : float
        Largest distance of the centroids, metres; 0 finds none.

    Returns
    -------
    bridges : (n_bridges, 2) int32
        For each border face of a component other than the largest its nearest border face of another
        component, if within reach; then the same for the components that these bridges make, until no
        component finds another.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.items import find_bridges
    >>> from scenewidget.engine.mesh import face_adjacency
    >>> beside = square(1).vertices + [1.02, 0.0, 0.0]
    >>> mesh = sw.Mesh([*square(1).vertices, *beside], [*square(1).faces, *(square(1).faces + 4)])
    >>> find_bridges(mesh, face_adjacency(mesh), 0.8).tolist()
    [[0, 3]]
    """
    border = np.flatnonzero(np.bincount(pairs.ravel(), minlength=mesh.n_faces) < 3)
    if mesh.is_cloud:  # which has no borders: all but the largest piece looks for others
        border = np.arange(mesh.n_faces)
    bridges: IntArray = np.empty((0, 2), dtype=np.int32)
    if len(border) == 0 or reach <= 0:
        return bridges
    n_components, component = connected_components(mesh.n_faces, pairs)
    if n_components == 1:
        return bridges
    points, home = mesh.face_centroids[border], component[border]
    size = np.bincount(component)
    cells = _Cells(points, reach)
    if mesh.is_cloud:  # most points have only their own piece around them
        is_mixed = cells.are_mixed(home)
        border, points, home = border[is_mixed], points[is_mixed], home[is_mixed]
        if len(border) == 0:
            return bridges
        cells = _Cells(points, reach)
    tree = cKDTree(points)
    while n_components > 1:  # crumbs first find each other: then their groups look further, and so on
        asking = np.flatnonzero((home != size.argmax()) & cells.are_mixed(home))
        found = border[_nearest_elsewhere(tree, points, home, asking, reach)]
        if len(found) == 0:
            break
        bridges = in_order(*np.concatenate([bridges, found]).T)
        n_components, group = connected_components(n_components, component[bridges])
        component, home, size = group[component], group[home], np.bincount(group, size)
    return bridges


class _Cells:
    """Cells as large as the reach: what a point could find lies in its own or one of the 26 around it."""

    def __init__(self, points: FloatArray, reach: float) -> None:
        low = points.min(axis=0)
        side = max(1.001 * reach, float((points.max(axis=0) - low).max()) / 2**20)  # codes fit in 64 bits
        place = np.floor((points - low) / side).astype(np.int64) + 1
        shape = place.max(axis=0) + 2
        code = (place[:, 0] * shape[1] + place[:, 1]) * shape[2] + place[:, 2]
        self._order = np.argsort(code)
        code = code[self._order]
        self._start = np.flatnonzero(np.concatenate([[True], code[1:] != code[:-1]]))
        code = code[self._start]
        self._beside = []  # each two cells once
        for x, y, z in list(itertools.product((0, 1, -1), repeat=3))[1:]:
            step = int((x * shape[1] + y) * shape[2] + z)
            if step > 0:
                there = np.searchsorted(code, code + step)
                here = np.flatnonzero(np.append(code, -1)[there] == code + step)
                self._beside.append((here, there[here]))

    def are_mixed(self, home: IntArray) -> BoolArray:
        """(n_points,) whether the cells around a point hold points of several homes."""
        ordered = home[self._order]
        least = np.minimum.reduceat(ordered, self._start)
        most = np.maximum.reduceat(ordered, self._start)
        low, high = least.copy(), most.copy()
        for one, other in self._beside:
            for here, there in ((one, other), (other, one)):
                low[here] = np.minimum(low[here], least[there])
                high[here] = np.maximum(high[here], most[there])
        out = np.empty(len(home), dtype=np.bool_)
        out[self._order] = np.repeat(low != high, np.diff(np.append(self._start, len(home))))
        return out


def _nearest_elsewhere(
    tree: cKDTree, points: FloatArray, home: IntArray, asking: IntArray, reach: float
) -> IntArray:
    """(n_found, 2) of those points that ask, the ones that have a point of another home within reach."""
    found = [np.empty((0, 2), dtype=np.int64)]
    k = 4
    while len(asking):  # look among more and more neighbours until one belongs elsewhere
        k = min(k, len(points))
        distance, near = tree.query(points[asking], k=k, distance_upper_bound=reach, workers=n_threads())
        distance, near = distance.reshape(len(asking), -1), near.reshape(len(asking), -1)
        is_other = np.isfinite(distance)
        is_other &= np.append(home, -1)[np.minimum(near, len(points))] != home[asking][:, None]
        hit = is_other.any(axis=1)
        first = is_other.argmax(axis=1)
        found.append(np.stack([asking[hit], near[hit, first[hit]]], axis=1))
        if k >= min(256, len(points)):
            break  # its own home fills the neighbourhood: no small fragment there
        asking = asking[~hit & np.isfinite(distance[:, -1])]
        k *= 4
    return np.concatenate(found)
