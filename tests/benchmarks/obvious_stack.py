"""The faithful preset from distances to consensus: ours against the obvious stack, on the same items.

The obvious stack is scipy's Dijkstra, alternate k-medoids in numpy and PEAC by the steepest pair. Both get
the same weighted graph, the same starts and the same merging.

python tests/benchmarks/obvious_stack.py --items 10000 --runs 50
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path

import numpy as np
from scipy.sparse.csgraph import dijkstra

sys.path.insert(0, str(Path(__file__).parent))

from plain import alternate_k_medoids, greedy_peac
from scans import add_scan_option, read_scan

from scenewidget.engine.consensus import co_association, peac
from scenewidget.engine.distances import all_pairs, edge_costs, edge_weights, weight_graph
from scenewidget.engine.ensemble import k_medoids_members, merge_flat
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline


def starts_of(n_items: int, k_range: tuple[int, int], n_runs: int) -> list[np.ndarray]:
    """Random medoids, as many for each run as ours would draw."""
    rng = np.random.default_rng(0)
    return [
        rng.choice(n_items, size=int(rng.integers(k_range[0], k_range[1] + 1)), replace=False)
        for _ in range(n_runs)
    ]


def main() -> None:
    """Time both, stage by stage, and print the ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    add_scan_option(parser)
    parser.add_argument("--items", type=int, default=10_000)
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--plain-runs", type=int, default=10, help="fewer are scaled up")
    parser.add_argument("--steps", type=int, default=10_000, help="most steps of the greedy PEAC")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    params = Params.thesis(n_items=arguments.items, n_runs=arguments.runs)
    pipe = Pipeline(read_scan(arguments.scan))
    items, features = pipe.get("items", params), pipe.get("features", params)
    pairs = items.pairs
    steps = np.linalg.norm(features[pairs[:, 0]] - features[pairs[:, 1]], axis=1)
    weights = edge_weights(steps, edge_costs(items.normals, pairs), items.lengths)
    graph = weight_graph(items.n, pairs, weights)
    share = pipe.get("allocation", params)
    print(f"{items.n} items, {len(share)} components, {arguments.runs} runs, S = 50")

    peac(np.eye(3), np.ones(3), 2)  # compiles
    small = Pipeline(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.1]], [[0, 1, 2], [0, 2, 3]]))
    small.run(Params.thesis())

    ours = {}
    start = time.perf_counter()
    D = all_pairs(graph)
    ours["distances"] = time.perf_counter() - start
    start = time.perf_counter()
    keys = k_medoids_members(
        items, [D], share, k_range=params.k_bounds, n_runs=arguments.runs, merge={"flatness": 0.008}
    )
    ours["k-medoids and merging"] = time.perf_counter() - start
    start = time.perf_counter()
    co = co_association(keys, items.areas)
    result = peac(co.C, co.weights, 50, diagonal=False)
    ours["consensus"] = time.perf_counter() - start

    plain = {}
    start = time.perf_counter()
    D = dijkstra(graph, directed=False)
    plain["distances"] = time.perf_counter() - start
    start = time.perf_counter()
    for medoids in starts_of(items.n, params.k_bounds, arguments.plain_runs):
        labels, _ = alternate_k_medoids(D, medoids)
        merge_flat(items, labels.astype(np.int32))
    plain["k-medoids and merging"] = (time.perf_counter() - start) * arguments.runs / arguments.plain_runs
    start = time.perf_counter()
    C, a, _ = co_association(keys, items.areas)
    Y = np.full((50, len(C)), 0.1 / 50)
    Y[cut_tree(average_linkage(C, a), n_clusters=min(50, len(C))), np.arange(len(C))] += 0.9
    Y, violation, n_steps = greedy_peac(C, a, Y, max_steps=arguments.steps)
    plain["consensus"] = time.perf_counter() - start

    residual = C - Y.T @ Y
    np.fill_diagonal(residual, 0.0)
    objective = float((a / a.sum()) @ residual**2 @ (a / a.sum()))
    print(f"{len(C)} base segments; objective ours {result.objective:.6f}, greedy {objective:.6f} "
          f"after {n_steps} steps (violation {violation:.1e})")  # fmt: skip
    print("                          ours s   obvious s   ratio")
    for stage in ours:
        print(f"{stage:24} {ours[stage]:7.2f} {plain[stage]:11.1f} {plain[stage] / ours[stage]:7.1f}")
    total, obvious = sum(ours.values()), sum(plain.values())
    print(f"{'together':24} {total:7.2f} {obvious:11.1f} {obvious / total:7.1f}")


if __name__ == "__main__":
    main()
