"""The stages in their order, the memo of their results, and `segment`.

Goes in: a mesh and `Params`. Comes out: a `Segmentation`. A stage is a name, the stages that it needs, and
its own options; its key is made of these, so that a changed option recomputes exactly what depends on it.
"""

from __future__ import annotations

import dataclasses
import os
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from scenewidget.engine.checks import warn_caller
from scenewidget.engine.consensus import (
    CoAssociation,
    average_linkage,
    co_association,
    cut_tree,
    mean_agreement,
    median_partition,
    peac,
    settle_leftovers,
)
from scenewidget.engine.dihedral import dihedral_partition
from scenewidget.engine.distances import MinPlusFactor, edge_costs, edge_weights, weight_graph
from scenewidget.engine.ensemble import allocate, felzenszwalb_members, k_medoids_members
from scenewidget.engine.evidence import calibrated
from scenewidget.engine.family import Family, make_family
from scenewidget.engine.features import (
    delta_coordinates,
    global_point_signature,
    heat_kernel_signature,
    vertex_to_face,
    wave_kernel_signature,
)
from scenewidget.engine.finish import absorb_small, connected_pieces
from scenewidget.engine.furniture import join_furniture
from scenewidget.engine.hull import join_planes
from scenewidget.engine.items import Items, simplified_items, superfacet_items
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh, face_adjacency, load_mesh
from scenewidget.engine.monitor import Monitor, Progress
from scenewidget.engine.operators import Eigenbasis, eigenbasis
from scenewidget.engine.orientation import Orientation, oriented
from scenewidget.engine.params import Params
from scenewidget.engine.relief import separate_reliefs, separate_tints
from scenewidget.engine.segmentation import Segmentation, order_by_area

__all__ = ["Pipeline", "segment"]

MIXED = 0.02  # share of edges; scans have up to 0.004, where more than two faces meet
FINE_SIMILARITY = 0.9  # what so many of the runs put together is one piece of the finest cut of a family


@dataclass(frozen=True)
class Stage:
    """One step: what it is called, what it needs, and all the options that it can see."""

    name: str
    run: Callable[..., Any]
    needs: tuple[str, ...] = ()
    options: tuple[tuple[str, Hashable], ...] = ()


def segment(
    mesh: Mesh | Any,
    params: Params | None = None,
    *,
    progress: Progress | None = None,
    cancel: threading.Event | None = None,
) -> Segmentation:
    """Cut a mesh into meaningful pieces.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
        In metres, normals pointing into free space.
    params : Params, optional
        `Params()` by default.
    progress : callable (stage: str, fraction: float), optional
        Called from the calling thread and from workers, never by two at once.
    cancel : threading.Event, optional
        Set it from another thread to stop.

    Returns
    -------
    Segmentation

    Raises
    ------
    MeshError, TypeError
        Something that is not a mesh that can be worked with.
    Cancelled
        ``cancel`` was set.
    """
    return Pipeline(mesh).run(params, progress=progress, cancel=cancel)


class Pipeline:
    """A mesh with a memo of what was computed on it.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
    memory : float
        Bytes that remembered results may take; the ones used longest ago are forgotten first. Forgetting
        changes no answer. 2 GB by default.
    """

    def __init__(self, mesh: Mesh | Any, *, memory: float = 2e9) -> None:
        self.mesh = load_mesh(mesh)
        self._memo: OrderedDict[Hashable, Any] = OrderedDict()
        self._sizes: dict[Hashable, int] = {}
        self._memory = memory
        self._lock = threading.Lock()

    def __repr__(self) -> str:
        return f"Pipeline({self.mesh!r})"

    def run(
        self,
        params: Params | None = None,
        *,
        progress: Progress | None = None,
        cancel: threading.Event | None = None,
    ) -> Segmentation:
        """What ``segment(mesh, params)`` gives, computing only what isn't remembered.

        ``timings`` of the result are the seconds that this call spent in each stage, 0 for remembered ones.

        Parameters
        ----------
        params : Params, optional
            `Params()` by default.
        progress : callable, optional
            ``progress(stage, fraction)``, called as it goes.
        cancel : threading.Event, optional
            Setting it ends the computation with `Cancelled`.
        """
        params = _checked(params)
        timings: dict[str, float] = {}
        table = stages(params)
        last = next(reversed(table))
        result: Segmentation = self._compute(last, table, Monitor(progress, cancel), timings)
        return dataclasses.replace(result, timings=timings)

    def family(
        self,
        params: Params | None = None,
        *,
        progress: Progress | None = None,
        cancel: threading.Event | None = None,
    ) -> Family:
        """Nested segmentations from fine to coarse that run through what `run` gives.

        ``family.cut(n)`` has exactly n segments, takes milliseconds, and is a union of the segments of
        any finer cut; ``family.cut(result.n_segments)`` is the result of ``run(params)`` itself.

        Parameters
        ----------
        params : Params, optional
        progress : callable, optional
            ``progress(stage, fraction)``, called as it goes.
        cancel : threading.Event, optional
            Setting it ends the computation with `Cancelled`.
        """
        table = stages(_checked(params).replace(granularity=1))
        family: Family = self._compute("family", table, Monitor(progress, cancel), {})
        return family

    def knows(self, stage: str, params: Params) -> bool:
        """Whether a stage's result for these ``params`` is remembered and costs nothing."""
        table = stages(params)
        with self._lock:
            return stage in table and _key(stage, table) in self._memo

    def get(
        self,
        stage: str,
        params: Params | None = None,
        *,
        progress: Progress | None = None,
        cancel: threading.Event | None = None,
    ) -> Any:
        """Result of one stage, for teaching.

        Parameters
        ----------
        stage : str
            One of those in ``timings``.
        params : Params, optional
        progress : callable, optional
            ``progress(stage, fraction)``, called as it goes.
        cancel : threading.Event, optional
            Setting it ends the computation with `Cancelled`.

        Raises
        ------
        ValueError
            These parameters have no such stage; the message lists those that they have.
        """
        params = _checked(params)
        table = stages(params)
        if stage == "eigenbasis" and stage not in table:
            table[stage] = _eigenbasis_stage(params)
        if stage not in table:
            raise ValueError(f"stage must be one of {', '.join(map(repr, table))}, got {stage!r}")
        return self._compute(stage, table, Monitor(progress, cancel), {})

    def clear(self) -> None:
        """Forget all results."""
        with self._lock:
            self._memo.clear()
            self._sizes.clear()

    def _compute(
        self, name: str, table: Mapping[str, Stage], monitor: Monitor, timings: dict[str, float]
    ) -> Any:
        key = _key(name, table)
        with self._lock:
            if key in self._memo:
                self._memo.move_to_end(key)
                timings.setdefault(name, 0.0)
                return self._memo[key]
        stage = table[name]
        inputs = [self._compute(need, table, monitor, timings) for need in stage.needs]
        monitor.tick()
        monitor.start(name)
        start = time.perf_counter()
        value = stage.run(self.mesh, *inputs, monitor=monitor, **dict(stage.options))
        timings[name] = time.perf_counter() - start
        self._remember(key, value)
        monitor.tick()  # a cancel that came during the last loop is heard before the stage counts as done
        monitor.finish()
        return value

    def _remember(self, key: Hashable, value: Any) -> None:
        size = _n_bytes(value)
        with self._lock:
            self._memo[key] = value
            self._sizes[key] = size
            while sum(self._sizes.values()) > self._memory and len(self._memo) > 1:
                oldest, _ = self._memo.popitem(last=False)
                del self._sizes[oldest]


def _checked(params: Params | None) -> Params:
    if params is None:
        return Params()
    if not isinstance(params, Params):
        raise TypeError(f"params must be a Params, got {type(params).__name__}; write Params(n_segments=…)")
    return params


def _key(name: str, table: Mapping[str, Stage]) -> Hashable:
    stage = table[name]
    return name, stage.run.__name__, stage.options, tuple(_key(need, table) for need in stage.needs)


def _n_bytes(value: Any, seen: set[int] | None = None) -> int:
    """Bytes of the arrays in a result, the mesh as loaded not counted twice within it."""
    seen = set() if seen is None else seen
    if id(value) in seen:
        return 0
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        if isinstance(
            value.base, np.ndarray
        ):  # a view; what compiled code returns has a base too, of its own
            return _n_bytes(value.base, seen)
        return value.nbytes
    if sparse.issparse(value):
        return sum(_n_bytes(v, seen) for v in vars(value).values())
    if isinstance(value, (tuple, list)):
        return sum(_n_bytes(v, seen) for v in value)
    if isinstance(value, Mapping):
        return sum(_n_bytes(v, seen) for v in value.values())
    if dataclasses.is_dataclass(value) and not isinstance(value, (Mesh, type)):
        return sum(_n_bytes(v, seen) for v in vars(value).values())
    return 0


# --- the stage table ------------------------------------------------------------------------------


def stages(params: Params) -> dict[str, Stage]:
    """The stages that these parameters need, in the order of the data flow."""
    p = params

    def stage(name: str, run: Callable[..., Any], *needs: str, **options: Hashable) -> Stage:
        return Stage(name, run, needs, tuple(sorted(options.items())))

    if p.items == "superfacets":
        items = stage(
            "items",
            _superfacets,
            "adjacency",
            orientation=p.orientation,
            n_items=p.n_items,
            sweeps=p.filter_sweeps,
            bridge=p.bridge,
        )
    else:
        items = stage(
            "items",
            _simplified,
            "adjacency",
            orientation=p.orientation,
            n_faces=p.n_items,
            simplifier=p.simplifier,
        )
    table = [
        stage("adjacency", _adjacency),
        items,
        stage("dihedral", _dihedral, "items", n_slots=p.n_slots, order=p.dihedral_order),
        stage("allocation", _share, "items", "dihedral", allocation=p.allocation),
    ]
    feature: tuple[str, ...] = ()
    if p.feature in ("gps", "hks", "wks"):
        table.append(_eigenbasis_stage(p))
        table.append(stage("features", _signatures, "items", "eigenbasis", feature=p.feature))
        feature = ("features",)
    elif p.feature != "normals":
        table.append(stage("features", _delta, "items", feature=p.feature))
        feature = ("features",)
    table += [
        stage(
            "distances",
            _distances,
            "items",
            *feature,
            a=p.cost_a,
            b=p.cost_b,
            exponent=p.cost_exponent,
            feature_floor=p.feature_floor if feature else 0.0,
            convex_weights=p.convex_weights if p.n_runs else (),
            hop=p.hop,
        ),
    ]
    graph_runs: tuple[str, ...] = ()
    if p.n_graph_runs:
        options = {"n_runs": p.n_graph_runs, "exponent": p.cost_exponent, "hop": p.hop, "seed": p.seed}
        table.append(stage("graph_runs", _graph_runs, "items", **options))
        graph_runs = ("graph_runs",)
    table += [
        stage(
            "ensemble",
            _ensemble,
            "items",
            "distances",
            "allocation",
            *graph_runs,
            k_range=p.k_bounds,
            n_runs=p.n_runs,
            init=p.init,
            merge=(p.merge_flatness, p.merge_normal, p.merge_seam) if p.merge else None,
            seed=p.seed,
        ),
        stage("coassociation", _coassociation, "items", "ensemble"),
    ]
    if p.consensus == "linkage":
        table.append(stage("tree", _tree, "coassociation"))
        table.append(
            stage(
                "consensus",
                _consensus_linkage,
                "coassociation",
                "tree",
                n_segments=p.n_segments,
                similarity=p.linkage_similarity if p.n_segments == "auto" else None,
            )
        )
    elif p.consensus == "median":
        table.append(stage("consensus", _consensus_median, "coassociation", seed=p.seed))
    else:
        n_segments = p.k_bounds[0] // 2 if p.n_segments == "auto" else p.n_segments
        table.append(stage("trees", _trees, "coassociation", "items"))
        table.append(
            stage(
                "consensus",
                _consensus_peac,
                "coassociation",
                "items",
                "allocation",
                "trees",
                n_segments=n_segments,
                leftover=p.leftover,
                seed=p.seed,
            )
        )
    table += [
        stage(
            "finish",
            _finish,
            "items",
            "coassociation",
            "consensus",
            planes=p.join_planes,
            relief=p.relief,
            contrast=p.contrast,
            furniture=p.furniture_similarity,
            min_area=p.min_area,
        ),
        stage("segmentation", _segmentation, "items", "dihedral", "ensemble", "coassociation", "finish"),
    ]
    if p.granularity is not None:
        if p.consensus != "linkage":
            table.append(stage("tree", _tree, "coassociation"))
        table += [
            stage(
                "family",
                _family,
                "items",
                "coassociation",
                "tree",
                "segmentation",
                planes=p.join_planes,
                relief=p.relief,
                contrast=p.contrast,
                min_area=p.min_area,
            ),
            stage("granularity", _cut, "family", n_segments=p.granularity),
        ]
    return {s.name: s for s in table}


def _eigenbasis_stage(p: Params) -> Stage:
    options = (("k", p.n_eigenpairs), ("laplacian", p.laplacian))
    return Stage("eigenbasis", _eigenbasis, ("items",), options)


def _n_threads() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _adjacency(mesh: Mesh, *, monitor: Monitor) -> IntArray:
    pairs = monitor.call(face_adjacency, mesh)
    _warn_of_mixed_winding(mesh, pairs)
    return pairs


def _warn_of_mixed_winding(mesh: Mesh, pairs: IntArray) -> None:
    """Faces that run through a common edge in one direction look to different sides of the surface."""
    sample = pairs[:: max(1, len(pairs) // 50_000)]
    first, second = mesh.vertices[mesh.faces[sample]].transpose(1, 0, 2, 3)
    is_same = (first[:, :, None] == second[:, None]).all(axis=3)  # corner i of one is corner j of the other
    is_mixed = (is_same & np.roll(is_same, -1, axis=(1, 2))).any(axis=(1, 2))
    if is_mixed.any() and is_mixed.mean() > MIXED:
        warn_caller(
            f"at {is_mixed.mean():.0%} of the edges the two faces look to different sides of the surface, "
            "and creases may be found where there are none; wind the faces the same way first, as "
            "trimesh.repair.fix_winding does"
        )


def _superfacets(
    mesh: Mesh, pairs: IntArray, *, monitor: Monitor, orientation: Orientation, **options: Any
) -> Items:
    return oriented(superfacet_items(mesh, pairs, monitor=monitor, **options), orientation)


def _simplified(
    mesh: Mesh, pairs: IntArray, *, monitor: Monitor, orientation: Orientation, **options: Any
) -> Items:
    return oriented(simplified_items(mesh, pairs, monitor=monitor, **options), orientation)


def _dihedral(mesh: Mesh, items: Items, *, monitor: Monitor, n_slots: int, order: Any) -> IntArray:
    return dihedral_partition(items.mesh, n_slots, order=order, monitor=monitor)


def _share(mesh: Mesh, items: Items, dihedral: IntArray, *, monitor: Monitor, allocation: str) -> FloatArray:
    """Share of k and S of each component of the item graph."""
    component = items.component
    n = int(component.max()) + 1
    if allocation == "same":
        return np.ones(n)
    if allocation == "faces":
        count = np.bincount(component, minlength=n)
    else:
        keep = items.item_of_face >= 0
        home = np.zeros(int(dihedral.max()) + 1, dtype=np.int64)
        home[dihedral[keep]] = component[items.item_of_face[keep]] + 1
        count = np.bincount(home, minlength=n + 1)[1:]
        count = np.maximum(count, 1)
    return np.asarray(count / count.sum())


def _eigenbasis(mesh: Mesh, items: Items, *, monitor: Monitor, k: int, laplacian: Any) -> Eigenbasis:
    # one more than asked for: each component's zero mode is no signature
    return eigenbasis(items.mesh, k + 1, laplacian=laplacian, per_component=True, monitor=monitor)


def _delta(mesh: Mesh, items: Items, *, monitor: Monitor, feature: Any) -> FloatArray:
    return _lift(items, delta_coordinates(items.mesh, feature))


def _signatures(mesh: Mesh, items: Items, basis: Eigenbasis, *, monitor: Monitor, feature: str) -> FloatArray:
    if feature == "gps":
        return _lift(items, global_point_signature(basis))
    if feature == "hks":
        return _lift(items, heat_kernel_signature(basis))
    return _lift(items, wave_kernel_signature(basis))


def _lift(items: Items, vertex_values: FloatArray) -> FloatArray:
    """Feature of each item: mean of a face's corners, then the area-weighted mean over its faces."""
    values = vertex_to_face(items.mesh, vertex_values)
    keep = items.item_of_face >= 0
    item, area = items.item_of_face[keep], items.mesh.face_areas[keep]
    if len(item) == items.n:
        return values[keep][np.argsort(item)]
    sums = np.stack([np.bincount(item, area * column[keep], items.n) for column in values.T], axis=1)
    return np.asarray(sums / np.where(items.areas > 0, items.areas, 1.0)[:, None])


def _distances(
    mesh: Mesh,
    items: Items,
    features: FloatArray | None = None,
    *,
    monitor: Monitor,
    a: float,
    b: float,
    exponent: float,
    feature_floor: float,
    convex_weights: tuple[float, ...],
    hop: float,
) -> tuple[Any, ...]:
    costs = edge_costs(items.normals, items.pairs, a=a, b=b, exponent=exponent)
    steps = None
    if features is not None:
        steps = np.linalg.norm(features[items.pairs[:, 0]] - features[items.pairs[:, 1]], axis=1)
        if feature_floor == 0.0:
            _warn_of_vanishing_features(steps, costs)
    out = []
    for alpha in convex_weights:
        weights = edge_weights(
            steps,
            costs,
            items.lengths,
            feature_floor=feature_floor,
            is_convex=items.is_convex,
            convex_weight=alpha,
            hop=hop,
        )
        factor = MinPlusFactor(weight_graph(items.n, items.pairs, weights))
        out.append(factor.rows(np.arange(items.n), n_threads=_n_threads(), monitor=monitor))
    return tuple(out)


def _warn_of_vanishing_features(steps: FloatArray, costs: FloatArray) -> None:
    """A clean mesh has no δ difference across its creases: say so, or all distances silently vanish."""
    is_crease = costs > 0.1
    if not is_crease.any() or len(steps) == 0:
        return
    flat = float(np.mean(steps[is_crease] <= 1e-6 * np.quantile(steps, 0.95)))
    if flat > 0.2:
        warn_caller(
            f"{flat:.0%} of the creases have the same feature on both sides, so distances ignore them "
            "(clean, noise-free mesh?); feature_floor=0.05 lets the normals count there"
        )


def _graph_runs(
    mesh: Mesh, items: Items, *, monitor: Monitor, n_runs: int, exponent: float, hop: float, seed: int
) -> IntArray:
    return felzenszwalb_members(
        items,
        n_runs=n_runs,
        cost_exponent=exponent,
        hop=hop,
        seed=seed,
        n_threads=_n_threads(),
        monitor=monitor,
    )


def _ensemble(
    mesh: Mesh,
    items: Items,
    distances: tuple[Any, ...],
    share: FloatArray,
    graph_runs: IntArray | None = None,
    *,
    monitor: Monitor,
    k_range: tuple[int, int],
    n_runs: int,
    init: Any,
    merge: tuple[float, float, float] | None,
    seed: int,
) -> IntArray:
    keys = [] if graph_runs is None else [graph_runs]
    if n_runs:
        runs = k_medoids_members(
            items,
            distances,
            share,
            k_range=k_range,
            n_runs=n_runs,
            init=init,
            merge=None if merge is None else dict(zip(("flatness", "normal", "seam"), merge)),
            seed=seed,
            n_threads=_n_threads(),
            monitor=monitor,
        )
        keys.insert(0, runs)
    return np.concatenate(keys, axis=1)


def _coassociation(mesh: Mesh, items: Items, keys: IntArray, *, monitor: Monitor) -> CoAssociation:
    return co_association(keys, items.areas, n_threads=_n_threads())


def _tree(mesh: Mesh, co: CoAssociation, *, monitor: Monitor) -> FloatArray:
    return average_linkage(co.C, co.weights)


def _consensus_linkage(
    mesh: Mesh,
    co: CoAssociation,
    tree: FloatArray,
    *,
    monitor: Monitor,
    n_segments: Any,
    similarity: float | None,
) -> IntArray:
    if n_segments == "auto":
        return cut_tree(tree, similarity=similarity)
    return cut_tree(tree, n_clusters=_cut_with(tree, co.weights, n_segments))


def _cut_with(tree: FloatArray, weights: FloatArray, n_segments: int) -> int:
    """Number of clusters of the coarsest cut with ``n_segments`` clusters of at least 0.1 % of the area.

    Crumbs don't count, or they would use up the number. Where no cut has that many, the one with most.
    """
    n = len(weights)
    area = np.concatenate([weights, np.zeros(len(tree))])
    for step, (left, right) in enumerate(tree[:, :2].astype(int)):
        area[n + step] = area[left] + area[right]
    is_large = area >= 0.001 * float(weights.sum())
    count, most, best = 1, 1, 1
    for step in range(len(tree) - 1, -1, -1):  # from the root down
        if count >= n_segments:
            break
        left, right = tree[step, :2].astype(int)
        count += int(is_large[left]) + int(is_large[right]) - int(is_large[n + step])
        if count > most:
            most, best = count, len(tree) - step + 1
    return best


def _consensus_median(mesh: Mesh, co: CoAssociation, *, monitor: Monitor, seed: int) -> IntArray:
    return median_partition(co.C, co.weights, seed=seed)


def _component(co: CoAssociation, items: Items) -> IntArray:
    """(n_base,) component of each base segment."""
    component = np.zeros(len(co.weights), dtype=np.int64)
    component[co.base] = items.component
    return component


def _evidence(co: CoAssociation, inside: IntArray) -> FloatArray:
    """C of some base segments."""
    whole = len(inside) == len(co.weights)
    return co.C if whole else np.ascontiguousarray(co.C[np.ix_(inside, inside)])


def _trees(mesh: Mesh, co: CoAssociation, items: Items, *, monitor: Monitor) -> list[FloatArray]:
    """Merge tree of each component, from which `peac` starts whatever S is."""
    component = _component(co, items)
    trees = []
    for c in range(int(component.max()) + 1):
        monitor.tick()
        inside = np.flatnonzero(component == c)
        weights = co.weights[inside]
        trees.append(average_linkage(_evidence(co, inside), weights / (weights.sum() or 1.0)))
    return trees


def _consensus_peac(
    mesh: Mesh,
    co: CoAssociation,
    items: Items,
    share: FloatArray,
    trees: list[FloatArray],
    *,
    monitor: Monitor,
    n_segments: int,
    leftover: Any,
    seed: int,
) -> IntArray:
    """PEAC in each component with its share of S (thesis 3.1, 3.5)."""
    component = _component(co, items)
    out = np.empty(len(co.weights), dtype=np.int32)
    labels: IntArray
    offset, left, unsolved = 0, 0.0, 0
    counts = allocate(n_segments, share, np.bincount(component, minlength=len(share)))
    for c, count in enumerate(counts):
        inside = np.flatnonzero(component == c)
        if count <= 1 or len(inside) == 1 or not co.weights[inside].sum() > 0:
            labels = np.zeros(len(inside), dtype=np.int32)
        else:
            C, weights = _evidence(co, inside), co.weights[inside]
            child = np.random.SeedSequence(seed, spawn_key=(c,))
            result = peac(C, weights, int(count), tree=trees[c], seed=child, monitor=monitor)
            labels, part = settle_leftovers(result, C, weights, leftover)
            left += part * float(weights.sum())
            unsolved += not result.converged
        out[inside] = labels + offset
        offset += int(labels.max()) + 1
    total = float(co.weights.sum())
    if total > 0 and left > 0.05 * total:
        warn_caller(
            f"{left / total:.0%} of the area has no cluster with a probability of at least ½; "
            "raise n_segments, or join what is left over: leftover='argmax' gives it to the likeliest "
            "cluster, leftover='linkage' groups it"
        )
    if unsolved:
        warn_caller(
            f"the consensus did not converge in {unsolved} of {len(counts)} components, so its segments hang "
            "on the seed more than they should; try another seed, or consensus='linkage'"
        )
    return out


def _finish(
    mesh: Mesh,
    items: Items,
    co: CoAssociation,
    consensus: IntArray,
    *,
    monitor: Monitor,
    planes: bool,
    relief: float,
    contrast: float,
    furniture: float,
    min_area: float,
) -> tuple[IntArray, FloatArray]:
    """(n_items,) label of each item, and how much the ensemble agrees with it."""
    pieces = connected_pieces(consensus[co.base], items.pairs)
    labels = _finished(items, pieces, planes, relief, contrast, min_area, monitor)
    if furniture < 1:
        labels = join_furniture(items, labels, co, similarity=furniture)
    return labels, _confidence(co, pieces)


def _finished(
    items: Items,
    labels: IntArray,
    planes: bool,
    relief: float,
    contrast: float,
    min_area: float,
    monitor: Monitor,
) -> IntArray:
    if planes:
        labels = join_planes(items, labels)
    monitor.tick()
    if relief > 0:
        labels = separate_reliefs(items, labels, step=relief)
    monitor.tick()
    if contrast > 0:
        labels = separate_tints(items, labels, contrast=contrast)
    return absorb_small(items, labels, min_area) if min_area > 0 else labels


def _segmentation(
    mesh: Mesh,
    items: Items,
    dihedral: IntArray,
    keys: IntArray,
    co: CoAssociation,
    finished: tuple[IntArray, FloatArray],
    *,
    monitor: Monitor,
) -> Segmentation:
    labels, confidence = finished
    face_map = items.face_map
    raw = np.append(labels, -1)[face_map]
    dense, kept = order_by_area(raw, mesh.face_areas)
    if (dense >= 0).mean() < 0.5:
        warn_caller(
            f"only {(dense >= 0).mean():.1%} of the faces are labeled: the mesh is in many pieces, and most "
            "were too small to keep (see report); weld it first, or use items='superfacets' with more "
            "n_items"
        )
    rank = np.full(int(labels.max()) + 1, -1, dtype=np.int32)
    rank[kept] = np.arange(len(kept), dtype=np.int32)
    is_raw = items.mesh is mesh
    return Segmentation(
        mesh,
        dense,
        np.append(confidence, 0.0)[face_map].astype(np.float32),
        levels={
            "dihedral": dihedral if is_raw else np.append(dihedral, -1)[face_map],
            "base": np.append(co.base, -1)[face_map],
        },
        keys=keys[np.unique(co.base, return_index=True)[1]],
        items=items,
        item_labels=rank[labels],
        face_map=face_map,
        simplified=None if is_raw else items.mesh,
        report=items.report,
    )


def _family(
    mesh: Mesh,
    items: Items,
    co: CoAssociation,
    tree: FloatArray,
    segmentation: Segmentation,
    *,
    monitor: Monitor,
    planes: bool,
    relief: float,
    contrast: float,
    min_area: float,
) -> Family:
    fine = connected_pieces(cut_tree(tree, similarity=FINE_SIMILARITY)[co.base], items.pairs)
    finished = _finished(items, fine, planes, relief, contrast, min_area, monitor)
    return make_family(segmentation, finished, co, smallest=min_area)


def _cut(mesh: Mesh, family: Family, *, monitor: Monitor, n_segments: int) -> Segmentation:
    return family.cut(min(max(n_segments, family.least), family.most))


def _confidence(co: CoAssociation, labels: IntArray) -> FloatArray:
    """(n_items,) probability that an item and its segment are one thing.

    From their mean co-association, by area: how often the runs agree.
    """
    n, n_base = int(labels.max()) + 1, len(co.weights)
    code, index, inverse = np.unique(
        co.base.astype(np.int64) * n + labels, return_index=True, return_inverse=True
    )
    base, segment_of = co.base[index], labels[index]  # pieces: a base segment within a segment
    area = np.bincount(co.base, minlength=n_base)
    weight = co.weights[base] * np.bincount(inverse, minlength=len(code)) / area[base]
    share = np.clip(mean_agreement(co.C, base, segment_of, np.maximum(weight, 1e-300)), 0.0, 1.0)
    return calibrated(share[inverse])
