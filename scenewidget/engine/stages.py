"""Every step from a mesh to its segments, in order: the table that `segment` follows.

Goes in: `Params`. Comes out: a `Stage` for each step that these parameters want. The steps stand below the
table in the same order, each a call or two of the module that has its idea.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from scenewidget.engine.allocation import Allocation, component_shares
from scenewidget.engine.checks import warn_caller
from scenewidget.engine.consensus import (
    CoAssociation,
    Leftover,
    co_association,
    component_trees,
    median_partition,
    peac_by_component,
)
from scenewidget.engine.dihedral import dihedral_partition
from scenewidget.engine.distances import (
    DistancesOnDemand,
    MinPlusFactor,
    edge_costs,
    edge_weights,
    warn_of_vanishing_features,
    weight_graph,
)
from scenewidget.engine.ensemble import (
    MemberInit,
    felzenszwalb_members,
    given_members,
    k_medoids_members,
)
from scenewidget.engine.family import Family, fine_pieces, make_family
from scenewidget.engine.features import (
    delta_coordinates,
    global_point_signature,
    heat_kernel_signature,
    unit_steps,
    wave_kernel_signature,
)
from scenewidget.engine.finish import finish, tidied
from scenewidget.engine.gravity import large_axes
from scenewidget.engine.items import Items, simplified_items, superfacet_items
from scenewidget.engine.kmedoids import Ties
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.memo import Recall
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh, face_adjacency
from scenewidget.engine.monitor import Monitor
from scenewidget.engine.operators import Eigenbasis, eigenbasis
from scenewidget.engine.orientation import Orientation, oriented, warn_of_mixed_winding
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import Segmentation, segmentation_of_items
from scenewidget.engine.sides import right_side_out
from scenewidget.engine.threads import at_once, n_threads

__all__ = ["TITLES", "Stage", "stages"]

MEDOIDS_WEIGHT = 2  # graph runs that a k-medoids run counts as, in an ensemble of both
CRUMBS = 100  # loose pieces are no scene of a few things any more
MOST_GB = 1.5  # of distances, which are remembered up to here, and beyond made anew whenever they are used

TITLES = {  # what people read while a step runs
    "adjacency": "Finding neighbouring faces",
    "items": "Gathering faces into items",
    "dihedral": "Partitioning by dihedral angle",
    "raw_dihedral": "Partitioning the scan by dihedral angle",
    "allocation": "Sharing out clusters over components",
    "eigenbasis": "Solving for eigenfunctions",
    "features": "Computing features",
    "distances": "Measuring distances",
    "graph_runs": "Segmenting the graph many times",
    "ensemble": "Clustering many times",
    "coassociation": "Comparing the clusterings",
    "tree": "Building the consensus tree",
    "trees": "Building the consensus trees",
    "consensus": "Finding the consensus",
    "finish": "Tidying segments up",
    "segmentation": "Labeling every face",
    "nested": "Finding coarser and finer segments",
    "family": "Cutting out as many segments as asked for",
    "granularity": "Choosing the granularity",
}


@dataclass(frozen=True)
class Stage:
    """One step: what it is called, what it needs, and all the options that it can see.

    Attributes
    ----------
    name : str
        What `Pipeline.get`, ``timings`` and ``progress`` call it.
    title : str
        What people read while it runs.
    run : callable
        Called with the results of ``needs``, the options by their names, and ``monitor``.
    needs : tuple of str
        Steps above it in the table; "mesh" is the mesh as loaded, "members" what joins the ensemble,
        "descriptor" the features given.
    options : tuple of (name, value)
        All that it can see of the parameters.
    key : hashable
        Two steps on one mesh whose keys are equal have the same result: made of the name, the variant, the
        options, and the keys of what it needs.
    recalls : str
        Where ``run`` also takes ``recall``, the step on whose result depends, beside the keys that ``run``
        gives, what it computes in parts.
    alone : bool
        Only its last result is worth remembering: it is large, and soon made again.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.engine.stages import stages
    >>> stage = stages(sw.Params())["consensus"]
    >>> stage.title, stage.needs, dict(stage.options)
    ('Finding the consensus', ('tree',), {'similarity': 0.6})
    """

    name: str
    title: str
    run: Callable[..., Any]
    needs: tuple[str, ...]
    options: tuple[tuple[str, Hashable], ...]
    key: Hashable
    recalls: str = ""
    alone: bool = False


def stages(params: Params, *, also: str = "") -> dict[str, Stage]:
    """The steps that these parameters want, in the order of the data flow; the last gives the `Segmentation`.

    Parameters
    ----------
    params : Params
    also : str
        "eigenbasis" adds this step where nothing needs it, for teaching.

    Returns
    -------
    table : dict of name to Stage

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.engine.stages import stages
    >>> [name for name in stages(sw.Params()) if name not in stages(sw.Params.thesis())]
    ['graph_runs', 'tree']
    >>> [name for name in stages(sw.Params.thesis()) if name not in stages(sw.Params())]
    ['features', 'trees']
    """
    p = params
    table: dict[str, Stage] = {}

    def step(
        name: str,
        run: Callable[..., Any],
        *needs: str,
        variant: str = "",
        recalls: str = "",
        alone: bool = False,
        **options: Hashable,
    ) -> None:
        seen = tuple(options.items())
        key = (name, variant, seen, tuple(table[need].key for need in needs if need in table))
        table[name] = Stage(name, TITLES[name], run, needs, seen, key, recalls, alone)

    # fmt: off
    step("adjacency", _adjacency, "mesh")
    if p.items == "superfacets":
        step("items", _superfacets, "mesh", "adjacency", variant="superfacets",
             orientation=p.orientation, scale=p.scale, n_items=p.n_items, item_area=p.item_area,
             sweeps=p.filter_sweeps, bridge=p.bridge)
    else:
        step("items", _simplified, "mesh", "adjacency", variant="simplified",
             orientation=p.orientation, scale=p.scale, n_faces=p.n_items, simplifier=p.simplifier,
             drop_torn=p.drop_torn, tolerance=p.tolerance)
    slots: dict[str, Any] = {"n_slots": p.n_slots, "mapping": p.slot_mapping, "order": p.dihedral_order}
    step("dihedral", _dihedral, "items", **slots)
    if p.allocation == "raw":
        step("raw_dihedral", _raw_dihedral, "mesh", **slots)
    counted = "raw_dihedral" if p.allocation == "raw" else "dihedral"
    step("allocation", _allocation, "items", counted, allocation=p.allocation)

    is_spectral, has_features = p.feature in SIGNATURES, p.feature != "normals"
    if is_spectral or also == "eigenbasis":
        step("eigenbasis", _eigenbasis, "items", k=p.n_eigenpairs, laplacian=p.laplacian)
    if is_spectral:
        step("features", _signatures, "items", "eigenbasis", variant="spectral", feature=p.feature)
    elif p.feature == "given":
        step("features", _given, "items", "mesh", "descriptor", variant="given")
    elif has_features:
        step("features", _delta, "items", variant="delta", feature=p.feature)
    step("distances", _distances, "items", *["features"] * has_features, alone=True,
         a=p.cost_a, b=p.cost_b, exponent=p.cost_exponent, hop=p.hop,
         feature_floor=p.feature_floor if has_features else 0.0,
         convex_weights=p.convex_weights if p.n_runs else ())
    if p.n_graph_runs:
        step("graph_runs", _graph_runs, "items",
             n_runs=p.n_graph_runs, exponent=p.cost_exponent, hop=p.hop, seed=p.seed)
    step("ensemble", _ensemble, "items", "distances", "allocation", "members",
         *["graph_runs"] * bool(p.n_graph_runs),
         k_range=p.k_bounds, n_runs=p.n_runs, init=p.init, ties=p.medoid_ties, seed=p.seed,
         merge=(p.merge_flatness, p.merge_normal, p.merge_seam) if p.merge else None)

    step("coassociation", _coassociation, "items", "ensemble",
         n_heavy=p.n_runs if p.n_graph_runs else 0)
    if p.consensus == "linkage":
        step("tree", _tree, "coassociation")
        step("consensus", _consensus_by_linkage, "tree", variant="linkage",
             similarity=p.linkage_similarity)
    elif p.consensus == "median":
        step("consensus", _consensus_by_median, "coassociation", variant="median", seed=p.seed)
    else:
        step("trees", _trees, "coassociation", "items")
        step("consensus", _consensus_by_peac, "coassociation", "items", "allocation", "trees", variant="peac",
             n_segments=p.n_segments, leftover=p.leftover, seed=p.seed)
    tidy: dict[str, Any] = {
        "planes": p.join_planes, "relief": p.relief, "contrast": p.contrast, "min_area": p.min_area,
    }
    step("finish", _finish, "items", "coassociation", "consensus", recalls="items",
         furniture=p.furniture_similarity, **tidy)
    step("segmentation", _segmentation, "mesh", "items", "dihedral", "ensemble", "coassociation",
         "finish", runs=(("k-medoids", p.n_runs), ("graph", p.n_graph_runs)))
    asked = p.n_segments if p.consensus == "linkage" and p.n_segments != "auto" else None
    if asked is not None or p.granularity is not None:
        if p.consensus != "linkage":
            step("tree", _tree, "coassociation")
        step("nested", _nested, "items", "coassociation", "tree", "segmentation",
             recalls="items", **tidy)
        step("family", _family, "nested", through=asked)
        step("granularity", _granularity, "family",
             n_segments=asked if p.granularity is None else p.granularity)
    # fmt: on
    return table


# --- from the mesh to items -----------------------------------------------------------------------


def _adjacency(mesh: Mesh, *, monitor: Monitor) -> IntArray:
    pairs = monitor.call(face_adjacency, mesh)
    warn_of_mixed_winding(mesh, pairs)
    return pairs


def _superfacets(
    mesh: Mesh, pairs: IntArray, *, monitor: Monitor, orientation: Orientation, **options: Any
) -> Items:
    find = partial(superfacet_items, mesh, pairs, monitor=monitor, **options)
    items, evidence = at_once(find, partial(_sides, mesh))
    return oriented(_with_loose_pieces_told(items), orientation, evidence)


def _sides(mesh: Mesh) -> float:
    large_axes(mesh)  # are kept: its unit is told of them
    return right_side_out(mesh.face_centroids, mesh.face_normals, mesh.face_areas)


def _with_loose_pieces_told(items: Items) -> Items:
    """Items whose report counts the pieces that touch nothing else; a scan in crumbs is worth a warning."""
    areas = np.bincount(items.component, items.areas)
    n_pieces, largest = len(areas), areas.max(initial=0.0) / max(float(items.areas.sum()), 1e-300)
    if n_pieces >= CRUMBS and largest < 0.5:
        warn_caller(
            f"the scan lies in {n_pieces} loose pieces, each a segment at least, and the largest has "
            f"{largest:.0%} of its area; where they should touch, fuse or weld them first, or raise bridge="
        )
    return dataclasses.replace(items, report={**items.report, "loose pieces": n_pieces})


def _simplified(
    mesh: Mesh, pairs: IntArray, *, monitor: Monitor, orientation: Orientation, **options: Any
) -> Items:
    return oriented(simplified_items(mesh, pairs, monitor=monitor, **options), orientation)


def _dihedral(items: Items, *, monitor: Monitor, **slots: Any) -> IntArray:
    return dihedral_partition(items.mesh, monitor=monitor, **slots)


def _raw_dihedral(mesh: Mesh, *, monitor: Monitor, **slots: Any) -> IntArray:
    return dihedral_partition(mesh, monitor=monitor, **slots)


def _allocation(items: Items, dihedral: IntArray, *, monitor: Monitor, allocation: Allocation) -> FloatArray:
    return component_shares(items, dihedral, allocation)


# --- features and distances -----------------------------------------------------------------------


def _eigenbasis(items: Items, *, monitor: Monitor, k: int, laplacian: Any) -> Eigenbasis:
    # one more than asked for: each component's zero mode is no signature
    return eigenbasis(items.mesh, k + 1, laplacian=laplacian, per_component=True, monitor=monitor)


SIGNATURES: dict[str, Callable[[Eigenbasis], FloatArray]] = {
    "gps": global_point_signature,
    "hks": heat_kernel_signature,
    "wks": wave_kernel_signature,
}


def _signatures(items: Items, basis: Eigenbasis, *, monitor: Monitor, feature: str) -> FloatArray:
    return items.from_vertices(SIGNATURES[feature](basis))


def _delta(items: Items, *, monitor: Monitor, feature: Any) -> FloatArray:
    return items.from_vertices(delta_coordinates(items.mesh, feature))


def _given(items: Items, mesh: Mesh, by_face: FloatArray, *, monitor: Monitor) -> FloatArray | None:
    features = unit_steps(items.from_raw_faces(by_face, mesh), items.pairs)
    if features is None and len(items.pairs):
        warn_caller("features differ between no neighbouring items, so the normals alone decide")
    return features


def _distances(
    items: Items,
    features: FloatArray | None = None,
    *,
    monitor: Monitor,
    a: float,
    b: float,
    exponent: float,
    hop: float,
    feature_floor: float,
    convex_weights: tuple[float, ...],
) -> Sequence[Any]:
    """Between all items, (n, n) float32 for each of the convex weights."""
    costs = edge_costs(items.normals, items.pairs, a=a, b=b, exponent=exponent)
    steps = None
    if features is not None:
        steps = np.linalg.norm(features[items.pairs[:, 0]] - features[items.pairs[:, 1]], axis=1)
        if feature_floor == 0.0 and b != 0.0:  # else creases cost no more than what is flat
            warn_of_vanishing_features(steps, costs)
    factors = []
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
        factors.append(MinPlusFactor(weight_graph(items.n, items.pairs, weights)))
    distances = DistancesOnDemand(tuple(factors))
    if 4e-9 * items.n**2 * len(factors) > MOST_GB:
        return distances
    return tuple(
        factor.rows(np.arange(items.n), n_threads=n_threads(), monitor=monitor) for factor in factors
    )


# --- the ensemble ---------------------------------------------------------------------------------


def _graph_runs(
    items: Items, *, monitor: Monitor, n_runs: int, exponent: float, hop: float, seed: int
) -> IntArray:
    return felzenszwalb_members(
        items,
        n_runs=n_runs,
        cost_exponent=exponent,
        hop=hop,
        seed=seed,
        n_threads=n_threads(),
        monitor=monitor,
    )


def _ensemble(
    items: Items,
    distances: Sequence[Any],
    share: FloatArray,
    members: tuple[IntArray, ...],
    graph_runs: IntArray | None = None,
    *,
    monitor: Monitor,
    k_range: tuple[int, int],
    n_runs: int,
    init: MemberInit,
    ties: Ties,
    seed: int,
    merge: tuple[float, float, float] | None,
) -> IntArray:
    """(n_items, n_runs) cluster of each item in each run, those of k-medoids first."""
    keys = [] if graph_runs is None else [graph_runs]
    if n_runs:
        runs = k_medoids_members(
            items,
            distances,
            share,
            k_range=k_range,
            n_runs=n_runs,
            init=init,
            ties=ties,
            merge=None if merge is None else dict(zip(("flatness", "normal", "seam"), merge)),
            seed=seed,
            n_threads=n_threads(),
            monitor=monitor,
        )
        keys.insert(0, runs)
    own = np.concatenate(keys, axis=1)
    return np.concatenate([own, given_members(items, members, own.shape[1])], axis=1) if members else own


# --- the consensus --------------------------------------------------------------------------------


def _coassociation(items: Items, keys: IntArray, *, monitor: Monitor, n_heavy: int) -> CoAssociation:
    """The first ``n_heavy`` runs count as `MEDOIDS_WEIGHT` others each."""
    times = np.where(np.arange(keys.shape[1]) < n_heavy, MEDOIDS_WEIGHT, 1)
    return co_association(np.repeat(keys, times, axis=1), items.areas, n_threads=n_threads())


def _tree(co: CoAssociation, *, monitor: Monitor) -> FloatArray:
    return average_linkage(co.C, co.weights)


def _consensus_by_linkage(tree: FloatArray, *, monitor: Monitor, similarity: float) -> IntArray:
    return cut_tree(tree, similarity=similarity)


def _consensus_by_median(co: CoAssociation, *, monitor: Monitor, seed: int) -> IntArray:
    return median_partition(co.C, co.weights, seed=seed)


def _trees(co: CoAssociation, items: Items, *, monitor: Monitor) -> tuple[FloatArray, ...]:
    return component_trees(co, items.component, monitor=monitor)


def _consensus_by_peac(
    co: CoAssociation,
    items: Items,
    share: FloatArray,
    trees: tuple[FloatArray, ...],
    *,
    monitor: Monitor,
    n_segments: int | Literal["auto"],
    leftover: Leftover,
    seed: int,
) -> IntArray:
    return peac_by_component(
        co, items.component, share, n_segments, trees=trees, leftover=leftover, seed=seed, monitor=monitor
    )


# --- from the consensus to segments ---------------------------------------------------------------


def _finish(
    items: Items,
    co: CoAssociation,
    consensus: IntArray,
    *,
    monitor: Monitor,
    recall: Recall,
    furniture: float,
    **tidy: Any,
) -> IntArray:
    """(n_items,) segment of each item."""
    return finish(
        items,
        co,
        consensus,
        furniture=furniture,
        **tidy,
        n_threads=n_threads(),
        recall=recall,
        monitor=monitor,
    )


def _segmentation(
    mesh: Mesh,
    items: Items,
    dihedral: IntArray,
    keys: IntArray,
    co: CoAssociation,
    labels: IntArray,
    *,
    monitor: Monitor,
    runs: tuple[tuple[str, int], ...],
) -> Segmentation:
    return segmentation_of_items(
        mesh, items, labels, dihedral=dihedral, base=co.base, keys=keys, runs=dict(runs)
    )


def _nested(
    items: Items,
    co: CoAssociation,
    tree: FloatArray,
    segmentation: Segmentation,
    *,
    monitor: Monitor,
    recall: Recall,
    min_area: float,
    **tidy: Any,
) -> Family:
    """The family that runs through the segmentation."""
    fine = fine_pieces(items, co, tree)
    fine = tidied(
        items, fine, min_area=min_area, **tidy, n_threads=n_threads(), recall=recall, monitor=monitor
    )
    return make_family(segmentation, fine, co, min_area=min_area)


def _family(family: Family, *, monitor: Monitor, through: int | None) -> Family:
    """The same family, seen from its cut into ``through`` segments."""
    if through is None:
        return family
    return dataclasses.replace(family, segmentation=_granularity(family, monitor=monitor, n_segments=through))


def _granularity(family: Family, *, monitor: Monitor, n_segments: int) -> Segmentation:
    return family.cut(min(max(n_segments, family.least), family.most))
