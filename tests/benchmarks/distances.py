"""All pairs of shortest paths on the faces of a simplified scan: ours against scipy's Dijkstra.

python tests/benchmarks/distances.py --items 2000 5000 10000 20000 30000
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from scipy.sparse.csgraph import dijkstra

sys.path.insert(0, str(Path(__file__).parent))

from scans import add_scan_option, read_scan, simplified

from scenewidget.engine.distances import MinPlusFactor, all_pairs, edge_costs, weight_graph
from scenewidget.engine.mesh import face_adjacency


def main() -> None:
    """Time both on growing graphs and print how far they differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_scan_option(parser)
    parser.add_argument("--items", type=int, nargs="+", default=[2_000, 5_000, 10_000, 20_000, 30_000])
    parser.add_argument("--whole", type=int, default=10_000, help="Dijkstra from all nodes up to here")
    arguments = parser.parse_args()
    scan = read_scan(arguments.scan)
    all_pairs(weight_graph(2, np.array([[0, 1]]), np.ones(1)))  # compiles

    print("  items  fill an item   factor s   ours s   scipy s   ratio   largest relative difference")
    for n in arguments.items:
        mesh = simplified(scan, n)
        pairs = face_adjacency(mesh)
        graph = weight_graph(mesh.n_faces, pairs, edge_costs(mesh.face_normals, pairs) + 0.02)
        start = time.perf_counter()
        factor = MinPlusFactor(graph)
        factored = time.perf_counter() - start
        ours = min(timed(all_pairs, graph)[0] for _ in range(2))
        D = all_pairs(graph)
        sources = np.arange(len(D))
        if len(D) > arguments.whole:
            sources = np.random.default_rng(0).choice(len(D), 500, replace=False)
        scipy_time, rows = timed(dijkstra, graph, directed=False, indices=sources)
        scipy_time *= len(D) / len(sources)
        finite = np.isfinite(rows) & (rows > 0)
        difference = np.abs(D[sources][finite] / rows[finite] - 1).max()
        note = "" if len(sources) == len(D) else "  (scipy: from 500 nodes, scaled up)"
        print(
            f"{len(D):7} {len(factor.indices) / len(D):13.1f} {factored:10.2f} {ours:8.2f} {scipy_time:9.1f} "
            f"{scipy_time / ours:7.1f}   {difference:.1e}{note}",
            flush=True,
        )
        del D, rows


def timed(function, *arguments, **options):
    """Seconds and the result."""
    start = time.perf_counter()
    result = function(*arguments, **options)
    return time.perf_counter() - start, result


if __name__ == "__main__":
    main()
