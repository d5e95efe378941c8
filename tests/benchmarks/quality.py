"""How good are the segments? Thesis' preset, default and Felzenszwalb on scans with a truth, in one table.

    python tests/benchmarks/quality.py [--seeds 0 1 2] [--scans bedroom "room 1"]

Scans: the two development scans where they lie beside the repository, and simulated rooms that differ in
layout, size, scanner and shape. Felzenszwalb gets its threshold chosen with the truth, for each scan by its
1 − RI, and once the same for all: more help than any method gets in practice. In every row pieces under
0.02 m² go to the nearest larger one. All errors are by face count; lower is better.
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

import scenewidget as sw
from scenewidget.datasets import SCANNERS

DATA = Path(__file__).parents[3] / "shared" / "data"
ROOMS = {
    "room 1": {"seed": 1, "voxel": 0.018},
    "room 2, hasty": {"seed": 2, "voxel": 0.02, **SCANNERS["hasty"]},
    "room 3, lidar": {"seed": 3, "voxel": 0.02, **SCANNERS["lidar"]},
    "room 4, L-shaped": {"seed": 4, "voxel": 0.022, "shape": "L", "n_objects": 18},
    "room 5, clean": {"seed": 5, "voxel": 0.025, **SCANNERS["clean"]},
}
THRESHOLDS = (0.01, 0.1, 0.5, 1.0, 2.0, 5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0)
FIXED = 10.0
SMALLEST = 0.02  # m²
COLUMNS = {
    "rand_index_error": "1-RI",
    "global_consistency_error": "GCE",
    "local_consistency_error": "LCE",
    "adjusted_rand_index": "ARI",
    "mean_iou": "IoU",
}


def scans(wanted: list[str] | None) -> Iterator[tuple[str, sw.Mesh, sw.Segmentation]]:
    """Name, mesh and truth of each scan, those that aren't there left out with a word."""
    for name in ("bedroom", "bedroom_noisy"):
        if wanted and name not in wanted:
            continue
        if not (DATA / f"{name}.ply").exists():
            print(f"{name}: not there, left out")
            continue
        mesh = sw.load_mesh(DATA / f"{name}.ply")
        labels = np.load(DATA / f"{name}_instances.npy").astype(np.int64)
        names = json.loads((DATA / f"{name}_instances.json").read_text())
        yield name, mesh, sw.Segmentation.from_labels(mesh, labels, names=list(names))
    for name, options in ROOMS.items():
        if not wanted or name in wanted:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # not every room has a place for all that is asked for
                yield name, *sw.datasets.simulate_room(**options)


def tidied(mesh: sw.Mesh, labels: np.ndarray) -> np.ndarray:
    """Labels in which faces of pieces under 0.02 m² have the label of the nearest face of a larger one."""
    area = np.bincount(labels[labels >= 0], mesh.face_areas[labels >= 0])
    is_small = (labels >= 0) & (area[labels] < SMALLEST)
    large = np.flatnonzero((labels >= 0) & ~is_small)
    if not is_small.any() or len(large) == 0:
        return labels
    labels = labels.copy()
    _, near = cKDTree(mesh.face_centroids[large]).query(mesh.face_centroids[is_small], workers=-1)
    labels[is_small] = labels[large[near]]
    return labels


def judged(mesh: sw.Mesh, truth: sw.Segmentation, make: Callable[[], sw.Segmentation]) -> dict[str, float]:
    """One row of the table."""
    start = time.perf_counter()
    made = make()
    seconds = time.perf_counter() - start
    segmentation = sw.Segmentation.from_labels(mesh, tidied(mesh, made.labels))
    row = sw.evaluate({"": segmentation}, truth, mesh, metrics=list(COLUMNS)).iloc[0]
    return {
        **{short: float(row[name]) for name, short in COLUMNS.items()},
        "segments": segmentation.n_segments,
        "of": truth.n_segments,
        "coverage": made.coverage,
        "seconds": seconds,
    }


def rows_of(
    mesh: sw.Mesh, truth: sw.Segmentation, seeds: list[int]
) -> Iterator[tuple[str, dict[str, float]]]:
    """Every method on one scan."""
    for name, params in (("thesis", sw.Params.thesis()), ("default", sw.Params())):
        runs = [
            judged(mesh, truth, lambda p=params, s=seed: sw.segment(mesh, p.replace(seed=s)))
            for seed in seeds
        ]
        row = pd.DataFrame(runs).mean().to_dict()
        row["±"] = float(np.ptp([run["1-RI"] for run in runs])) / 2
        yield name, row
    tried = {
        c: judged(mesh, truth, lambda c=c: sw.baselines.felzenszwalb(mesh, threshold=c)) for c in THRESHOLDS
    }
    best = min(tried, key=lambda c: tried[c]["1-RI"])
    yield "Felzenszwalb, best c", {**tried[best], "c": best}
    yield f"Felzenszwalb, c = {FIXED:g}", {**tried[FIXED], "c": FIXED}


def main() -> None:
    """Print the table scan by scan, then the means."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--scans", nargs="+", help="names of scans; all by default")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    pd.set_option("display.width", 200, "display.max_columns", 20)
    tables = {}
    for name, mesh, truth in scans(arguments.scans):
        tables[name] = pd.DataFrame(dict(rows_of(mesh, truth, arguments.seeds))).T
        print(f"\n{name}: {mesh.n_faces} faces\n{tables[name].round(3).fillna('')}", flush=True)
    if len(tables) > 1:
        mean = pd.concat(tables).astype(float).groupby(level=1, sort=False).mean()
        print(f"\nmean over {len(tables)} scans\n{mean.drop(columns='c').round(3)}")


if __name__ == "__main__":
    main()
