"""The ensemble: many different clusterings of the same items.

Goes in: items, distances, shares of k for each component. Come out: the keys, a label per item and run.
Members are k-medoids runs (thesis 3.4), merged where they cut a plane in pieces, and optionally
Felzenszwalb runs at random thresholds, for diversity.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, Literal

import numpy as np

from scenewidget.engine.allocation import allocate
from scenewidget.engine.curve import along_curve
from scenewidget.engine.distances import edge_costs
from scenewidget.engine.felzenszwalb import join_along_seams, join_light_edges
from scenewidget.engine.items import Items
from scenewidget.engine.kmedoids import Ties, alternate, initial_medoids
from scenewidget.engine.mesh import FloatArray, IntArray, connected_components
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.scale import own_frame

__all__ = ["MemberInit", "felzenszwalb_members", "given_members", "k_medoids_members", "merge_flat"]

MemberInit = Literal["random", "systematic", "sample", "outmost", "k-medoids++", "even"]
SEAM_THRESHOLD = 3.0  # runs along whole seams: times as high, for a mean is more than the least


def k_medoids_members(
    items: Items,
    distances: Sequence[np.ndarray[Any, np.dtype[np.float32]]],
    share: FloatArray,
    *,
    k_range: tuple[int, int],
    n_runs: int,
    init: MemberInit = "random",
    ties: Ties = "stay",
    merge: dict[str, float] | None = None,
    seed: int = 0,
    n_threads: int = 2,
    monitor: Monitor | None = None,
) -> IntArray:
    """Keys of k-medoids runs with k drawn evenly from ``k_range``.

    Parameters
    ----------
    items : Items
    distances : sequence of (n, n) float32
        Run i works on ``distances[i % len(distances)]``. ``inf`` between components, which are therefore
        clustered apart, each with its share of k.
    share : (n_components,) float
        Of `allocation.component_shares`.
    k_range : (least, most)
    n_runs : int
    init : str
        "even": one medoid in each of k equal parts of the surface, in the order of a curve that fills space,
        and k spread evenly over its range by the runs, so that seeds differ little. Others are those of
        `kmedoids.k_medoids`.
    ties : str
        See `kmedoids.k_medoids`.
    merge : dict, optional
        Thresholds of `merge_flat`; None merges nothing.
    seed : int
        Run i draws from a generator of its own, so more runs extend fewer.
    n_threads : int
        The result does not depend on it.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    Returns
    -------
    keys : (n, n_runs) int32

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.distances import all_pairs
    >>> from scenewidget.engine.ensemble import k_medoids_members
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.arange(8))
    >>> D = all_pairs(items.graph)
    >>> keys = k_medoids_members(items, [D], np.ones(1), k_range=(2, 3), n_runs=4)
    >>> keys.shape, sorted(set((keys.max(axis=0) + 1).tolist()))
    ((8, 4), [3])
    """
    monitor = monitor or SILENT
    component = items.component
    size = np.bincount(component)
    order = np.argsort(component, kind="stable")
    members = np.split(order, np.cumsum(size)[:-1])

    curve = _curve(items)
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(2_000_000,)))
    start = rng.random((len(distances), 1))
    place = [
        float(_evenly(np.array([i // len(distances)]), start[i % len(distances)])[0, 0])
        for i in range(n_runs)
    ]

    def run(D: np.ndarray[Any, np.dtype[np.float32]], i: int) -> IntArray:
        monitor.tick()
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(i,)))
        if init == "even":
            k = int(k_range[0] + place[i] * (k_range[1] + 1 - k_range[0]))
        else:
            k = int(rng.integers(k_range[0], k_range[1] + 1))
        medoids = []
        # one for all components, so that a scene among others is as it is alone
        offset = rng.random() if init == "even" else 0.0
        for inside, count in zip(members, allocate(k, share, size)):
            if init == "even":
                along = inside[np.argsort(curve[inside])]
                medoids.append(along[_by_area(items.areas[along], int(count), offset)])
            elif init == "random":
                medoids.append(rng.choice(inside, size=count, replace=False))
            else:
                block = D if len(members) == 1 else np.ascontiguousarray(D[np.ix_(inside, inside)])
                child = np.random.SeedSequence(int(rng.integers(2**63)))
                medoids.append(inside[initial_medoids(block, int(count), init=init, seed=child)])
        labels = alternate(D, np.concatenate(medoids).astype(np.int32), ties).labels
        return labels if merge is None else merge_flat(items, labels, **merge)

    keys = np.empty((items.n, n_runs), dtype=np.int32)
    n = len(distances)
    for first in range(min(n, n_runs)):  # one matrix after the other: large ones are made when they are used
        _collect(partial(run, distances[first]), range(first, n_runs, n), keys, n_threads, monitor)
    return keys


def felzenszwalb_members(
    items: Items,
    *,
    n_runs: int,
    cost_exponent: float = 1.0,
    convex_weight: tuple[float, float] = (0.05, 0.5),
    threshold: tuple[float, float] = (0.02, 0.3),
    jitter: float = 0.3,
    hop: float = 0.02,
    seed: int = 0,
    n_threads: int = 2,
    monitor: Monitor | None = None,
) -> IntArray:
    """Keys of Felzenszwalb runs on the graph of items, each with its own convex weight and threshold.

    In every other run the weight between two pieces is the mean along their seam, see `join_along_seams`.
    Convex weights and thresholds are spread evenly over their ranges by the runs of either kind, so that
    seeds differ little.

    Parameters
    ----------
    items : Items
    n_runs : int
    cost_exponent : float
        C of `distances.edge_costs`.
    convex_weight : (low, high)
        What a convex edge's weight is multiplied by.
    threshold : (low, high)
        In square units of the scene times weight, spread in its logarithm.
    jitter : float
        Weights are multiplied by exp(jitter · N(0, 1)).
    hop : float
        Added to each weight.
    seed : int
        Run i draws from a generator of its own, so more runs extend fewer.
    n_threads : int
        The result does not depend on it.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    Returns
    -------
    keys : (n, n_runs) int32

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import folded, square
    >>> from scenewidget.engine.ensemble import felzenszwalb_members
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(folded(square(4), "x", 0.5, np.pi / 2), np.arange(32))
    >>> felzenszwalb_members(items, n_runs=3).shape
    (32, 3)
    """
    monitor = monitor or SILENT
    costs = edge_costs(items.normals, items.pairs, a=1.0, b=-1.0, exponent=cost_exponent)

    lengths = np.maximum(items.seam_edges, 1)
    draw = _places_in_island(items)
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1_000_000,)))
    places = np.empty((2, n_runs))
    for kind in (0, 1):
        places[:, kind::2] = _evenly(np.arange(len(range(kind, n_runs, 2))), rng.random(2))
    low, high = np.log(threshold)

    def run(i: int) -> IntArray:
        monitor.tick()
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1_000_001 + i,)))
        alpha = convex_weight[0] + places[0, i] * (convex_weight[1] - convex_weight[0])
        c = float(np.exp(low + places[1, i] * (high - low)))
        weights = np.where(items.is_convex, alpha * costs, costs) + hop
        normal = rng.standard_normal(int(draw.max(initial=-1)) + 1)  # each island draws the same first ones
        weights = weights * np.exp(jitter * normal[draw])
        if i % 2:
            return join_along_seams(
                items.pairs, weights, lengths, threshold=SEAM_THRESHOLD * c, sizes=items.sizes
            )
        return join_light_edges(items.n, items.pairs, weights, threshold=c, sizes=items.sizes)

    keys = np.empty((items.n, n_runs), dtype=np.int32)
    _collect(run, range(n_runs), keys, n_threads, monitor)
    return keys


def _places_in_island(items: Items) -> IntArray:
    """(n_pairs,) how many pairs of the same island stand before each."""
    home = items.island[items.pairs[:, 0]]
    place = np.empty(len(home), dtype=np.int64)
    order = np.argsort(home, kind="stable")
    count = np.bincount(home)
    place[order] = np.arange(len(home)) - np.repeat(np.cumsum(count) - count, count)
    return place


def _evenly(place: IntArray, start: FloatArray) -> FloatArray:
    """(n_dims, n) points that fill [0, 1)^n_dims evenly however many there are: place times a step, modulo 1.

    The steps are powers of the root of x^(n_dims + 1) = x + 1, the golden ratio in one dimension (Kronecker's
    sequence; Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
    """
    n_dims = len(start)
    root = 1.5
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (n_dims + 1))
    steps = root ** -np.arange(1.0, n_dims + 1.0)
    return np.asarray((start[:, None] + np.outer(steps, place)) % 1.0)


def _curve(items: Items) -> IntArray:
    """(n,) place of each item along a curve through its own scene: neighbours are mostly near."""
    place = np.empty(items.n, dtype=np.int64)
    for island in range(len(items.scales)):
        inside = np.flatnonzero(items.island == island)
        points = items.centroids[inside]
        order = along_curve(points @ own_frame(points, items.areas[inside]))
        place[inside[order]] = np.arange(len(inside))
    return place


def _by_area(areas: FloatArray, count: int, offset: float) -> IntArray:
    """Positions of up to ``count`` items, one in each equal part of the area."""
    ends = np.cumsum(areas)
    marks = (np.arange(count) + offset) / count * ends[-1]
    return np.unique(np.minimum(np.searchsorted(ends, marks), len(areas) - 1))


def given_members(items: Items, members: Sequence[IntArray], n_runs: int) -> IntArray:
    """Keys of labelings from elsewhere, each as often as is an eighth of the runs.

    An item has the label of most of its area, −1 where most of it has none: the run says nothing about it.

    Parameters
    ----------
    items : Items
    members : sequence of (n_raw_faces,) int
        −1 for unknown.
    n_runs : int
        Of the ensemble that they join.

    Returns
    -------
    keys : (n, len(members) · max(1, n_runs // 8)) int32

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.ensemble import given_members
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.array([0, 0, 0, 0, 1, 1, 1, 1]))
    >>> given_members(items, [np.array([7, 7, 7, 2, -1, -1, -1, 2])], n_runs=16).tolist()
    [[1, 1], [-1, -1]]
    """
    keep = items.face_map >= 0
    is_raw = len(items.item_of_face) == len(items.face_map)
    area = items.mesh.face_areas[keep] if is_raw else np.ones(int(keep.sum()))
    columns = []
    for labels in members:
        _, dense = np.unique(labels[keep], return_inverse=True)
        n = int(dense.max(initial=0)) + 1
        pairs, index = np.unique(items.face_map[keep].astype(np.int64) * n + dense, return_inverse=True)
        total = np.bincount(index, area)
        order = np.lexsort((-pairs, total, pairs // n))
        winner = np.full(items.n, -1, dtype=np.int32)
        winner[pairs[order] // n] = pairs[order] % n  # the last of an item has most of it
        unknown = int((labels[keep] == -1).any())  # then it is the first of the sorted labels
        columns.append(np.maximum(winner - unknown, -1))
    return np.repeat(np.stack(columns, axis=1), max(1, n_runs // 8), axis=1).astype(np.int32)


def _collect(
    run: Callable[[int], IntArray], numbers: Sequence[int], keys: IntArray, n_threads: int, monitor: Monitor
) -> None:
    """Put what ``run`` gives for each of the numbers in the column of the keys with this number."""
    with ThreadPoolExecutor(n_threads) as pool:
        for i, labels in zip(numbers, pool.map(run, numbers)):
            keys[:, i] = labels
            monitor.tick((i + 1) / keys.shape[1])


def merge_flat(
    items: Items, labels: IntArray, *, flatness: float = 0.008, normal: float = 0.99, seam: float = 0.99
) -> IntArray:
    """Merge neighbouring segments that lie in one plane (thesis 3.4, Fig. 3.5).

    Two neighbours merge if λ2/λ0 of both scatter matrices is below ``flatness``, the absolute dot product
    of their smallest eigenvectors is above ``normal``, and along their seam at least half of the face
    pairs have a dot product of normals above ``seam`` and the mean over the seam is above it too. (The
    thesis says "at least half of the face normals point at similar directions and mean dot product of
    those faces is above the threshold"; we read it as two conditions on all face pairs of the seam.) All
    pairs that qualify merge at once, and so on until none does.

    Parameters
    ----------
    items : Items
    labels : (n,) int32
        Dense, −1 for items in no segment.
    flatness, normal, seam : float
        The thresholds above.

    Returns
    -------
    labels : (n,) int32
        Dense again.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.ensemble import merge_flat
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.arange(8))
    >>> merge_flat(items, np.arange(8)).tolist()
    [0, 0, 0, 0, 0, 0, 0, 0]
    """
    labels = labels.astype(np.int64)
    n = int(labels.max(initial=-1)) + 1
    moments = items.moments.gather(labels, n)
    n_pairs = len(items.pairs)
    count = items.seam_edges
    good = np.bincount(items.seam_pair, items.seam_dot > seam, n_pairs)
    dots = np.bincount(items.seam_pair, items.seam_dot, n_pairs)
    a, b = labels[items.pairs[:, 0]], labels[items.pairs[:, 1]]
    while n > 1:  # segments are joined, and with them their moments and the sums over their seams
        crossing = (a != b) & (a >= 0) & (b >= 0)
        a, b = np.minimum(a, b)[crossing], np.maximum(a, b)[crossing]
        code, inverse = np.unique(a * n + b, return_inverse=True)
        count, good, dots = (np.bincount(inverse, x[crossing], len(code)) for x in (count, good, dots))
        a, b = code // n, code % n
        values, vectors = moments.principal()
        is_flat = values[:, 0] < flatness * values[:, 2]
        normals = vectors[:, :, 0]
        parallel = np.abs(np.einsum("ij,ij->i", normals[a], normals[b])) > normal
        joins = is_flat[a] & is_flat[b] & parallel & (count > 0)
        joins &= (good >= 0.5 * count) & (dots > seam * count)
        if not joins.any():
            break
        n, group = connected_components(n, np.stack([a[joins], b[joins]], axis=1))
        moments = moments.gather(group, n)
        a, b = group[a].astype(np.int64), group[b].astype(np.int64)
        labels = np.where(labels >= 0, group[labels], -1)
    return labels.astype(np.int32)
