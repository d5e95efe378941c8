"""Runs of k-medoids on the faces of a simplified scan: ours against plain numpy from the same starts.

python tests/benchmarks/kmedoids.py --items 10000 --runs 50
"""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from plain import alternate_k_medoids
from scans import add_scan_option, read_scan, simplified

from scenewidget.engine.distances import all_pairs, edge_costs, weight_graph
from scenewidget.engine.kmedoids import alternate, initial_medoids
from scenewidget.engine.mesh import face_adjacency


def main() -> None:
    """Time both and print how their costs compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_scan_option(parser)
    parser.add_argument("--items", type=int, nargs="+", default=[2_000, 5_000, 10_000])
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--plain-runs", type=int, default=5, help="runs of plain numpy, scaled up")
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_args()
    scan = read_scan(arguments.scan)
    alternate(np.zeros((2, 2), np.float32), np.array([0], np.int32))  # compiles

    print("  items   k         ours s (all runs)   plain s (scaled)   ratio   mean cost ours / plain")
    for n in arguments.items:
        mesh = simplified(scan, n)
        pairs = face_adjacency(mesh)
        D = all_pairs(weight_graph(mesh.n_faces, pairs, edge_costs(mesh.face_normals, pairs) + 0.02))
        rng = np.random.default_rng(0)
        starts = [initial_medoids(D, int(rng.integers(100, 126)), seed=i) for i in range(arguments.runs)]
        start = time.perf_counter()
        with ThreadPoolExecutor(arguments.threads) as pool:
            results = list(pool.map(partial(alternate, D), starts))
        ours = time.perf_counter() - start
        start = time.perf_counter()
        plain = [alternate_k_medoids(D, medoids)[1] for medoids in starts[: arguments.plain_runs]]
        scale = arguments.runs / len(plain)
        plain_time = scale * (time.perf_counter() - start)
        costs = np.mean([r.cost for r in results[: len(plain)]]) / np.mean(plain)
        print(
            f"{len(D):7}   100–125 {ours:15.2f} {plain_time:18.1f} {plain_time / ours:10.1f} {costs:18.4f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
