"""PEAC, linkage and the median partition of random ensembles: seconds, objective, spread over restarts.

python tests/benchmarks/consensus.py --base 1000 3000 5000 --restarts 5
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from scans import add_scan_option, read_scan

from scenewidget.engine.consensus import co_association, median_partition, peac
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline


def random_ensemble(n_base: int, n_runs: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Keys of points in the unit square clustered around random centres, ``n_base`` different ones."""
    rng = np.random.default_rng(seed)
    points = rng.random((6 * n_base, 2))
    keys = np.empty((len(points), n_runs), dtype=np.int32)
    parts = rng.random((60, 2))  # what all runs have in common
    home = ((points[:, None] - parts) ** 2).sum(axis=2).argmin(axis=1)
    for run in range(n_runs):
        centres = rng.random((int(rng.integers(100, 126)), 2))
        owner = ((centres[:, None] - parts) ** 2).sum(axis=2).argmin(axis=1)
        distance = ((points[:, None] - centres) ** 2).sum(axis=2) + 0.02 * (home[:, None] != owner)
        keys[:, run] = distance.argmin(axis=1)
    _, first = np.unique(keys, axis=0, return_index=True)
    chosen = np.sort(first)[:n_base]
    return keys[chosen], rng.exponential(size=len(chosen))


def scan_ensembles(path: Path) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Keys of the faithful preset on a scan, merged over planes and not."""
    warnings.simplefilter("ignore")
    pipe = Pipeline(read_scan(path))
    out = []
    for merge in (True, False):
        params = Params.thesis(merge=merge)
        keys, areas = pipe.get("ensemble", params), pipe.get("items", params).areas
        out.append((f"scan, {'merged' if merge else 'not merged'}", keys, areas))
    return out


def timed(function, *arguments, **options):
    """Seconds and the result."""
    start = time.perf_counter()
    result = function(*arguments, **options)
    return time.perf_counter() - start, result


def main() -> None:
    """Time all and print them side by side."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_scan_option(parser)
    parser.add_argument("--base", type=int, nargs="+", default=[1_000, 3_000, 5_000])
    parser.add_argument("--clusters", type=int, default=50)
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--restarts", type=int, default=5)
    arguments = parser.parse_args()
    tiny = co_association(np.array([[0, 0], [0, 1], [1, 1]]))
    peac(tiny.C, tiny.weights, 2), median_partition(tiny.C, tiny.weights)  # compile

    print("  base  C s    peac s  sweeps  objective  best of restarts  above best   linkage s   median s")
    problems = [(f"{n}", *random_ensemble(n, arguments.runs)) for n in arguments.base]
    problems += scan_ensembles(arguments.scan)
    for name, keys, areas in problems:
        seconds_C, (C, weights, _) = timed(co_association, keys, areas)
        seconds, first = timed(peac, C, weights, arguments.clusters)
        others = [
            peac(C, weights, arguments.clusters, init="dirichlet", n_seeds=0, seed=seed).objective
            for seed in range(arguments.restarts)
        ]
        best = min([first.objective, *others])
        above = first.objective / best - 1
        seconds_linkage, tree = timed(average_linkage, C, weights)
        cut_tree(tree, similarity=0.5)
        seconds_median, _ = timed(median_partition, C, weights)
        print(
            f"{len(C):6} {seconds_C:5.2f} {seconds:8.2f} {first.n_sweeps:6} {first.objective:11.6f} "
            f"{best:12.6f} {above:16.2%} {seconds_linkage:10.2f} {seconds_median:10.2f}"
            f"{'' if first.converged else '   NOT CONVERGED'}   {name}",
            flush=True,
        )


if __name__ == "__main__":
    main()
