"""How good are the segments? Thesis' preset, default and Felzenszwalb on scans with a truth, in one table.

    python tests/benchmarks/quality.py [--half judging] [--scans bedroom study] [--rows default strong]
        [--seeds 0 1 2] [--cache DIR] [--csv FILE]

The scans (`rooms`) come in two halves: TUNING, on which thresholds and defaults may be chosen, with the
development scan `bedroom`, and JUDGING, whose means are what counts, with `bedroom_noisy`. Felzenszwalb
gets its threshold c chosen with the truth, for each scan by its 1 − RI, out of 21 from 0.01 to 40, and once
the same for all, the best over the tuning half: more help than any method gets in practice. It also gets
normals that point into the room. "strong" is what a careful programmer would do without an ensemble: filtered
normals, Felzenszwalb, planes joined. In every row segments under 0.02 m² go to the nearest larger one.

Columns: errors by face count, lower is better, and scores; segments and how many the truth has; the edits
that a greedy annotator (`simulate_annotator`) needs to 1 − RI ≤ 0.03, 100 where that is not reached;
coverage, seconds; ± is half the range of 1 − RI over the seeds. For the annotator the rows of Felzenszwalb
have the levels that the editor would offer: dihedral parts, and pieces at the finest threshold as base.

What was computed is kept in the cache; rows of the default are computed again when the engine's sources
change, others when they give another result on the shipped room.
"""

from __future__ import annotations

import argparse
import hashlib
import inspect
import json
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from rooms import HALVES, Scan, scans
from scipy.spatial import cKDTree

import scenewidget as sw
from scenewidget.baselines.graph_segmentation import mesh_graph, segment_graph
from scenewidget.editing import annotator, simulate_annotator
from scenewidget.engine import felzenszwalb, hull, items, preprocess
from scenewidget.engine.dihedral import dihedral_partition
from scenewidget.engine.mesh import FloatArray, IntArray, face_adjacency
from scenewidget.engine.monitor import SILENT

THRESHOLDS = (
    0.01, 0.015, 0.025, 0.04, 0.06, 0.1, 0.15, 0.25, 0.4, 0.6, 1.0, 1.5, 2.5, 4.0, 6.0, 8.0, 11.0, 15.0, 20.0,
    28.0, 40.0,
)  # fmt: skip
FIXED = {"raw": 1.0, "simplified": 4.0, "strong": 0.1}  # least mean 1 − RI over the tuning half
MIN_SIZE = 500  # faces
N_SIMPLIFIED = 10_000
SMALLEST = 0.02  # m²
EDIT_TARGET, MOST_EDITS = 0.03, 100
COLUMNS = {
    "rand_index_error": "1-RI",
    "global_consistency_error": "GCE",
    "local_consistency_error": "LCE",
    "adjusted_rand_index": "ARI",
    "mean_iou": "IoU",
}
PRESETS = {"thesis": sw.Params.thesis(), "default": sw.Params()}
SEARCHED = {
    "raw": "Felzenszwalb",
    "simplified": "Felzenszwalb, simplified",
    "strong": "filtered + Felz. + planes",
}
RAW, SIMPLIFIED, STRONG = (f"{name}, best c" for name in SEARCHED.values())
BETTER = "the better Felzenszwalb"  # raw or simplified, scan by scan, each at its best c
TARGETS = {"1-RI": 0.6, "GCE": 0.8, "LCE": 0.8}  # times the best Felzenszwalb


class Outcome(NamedTuple):
    """What a method made of a scan."""

    segmentation: sw.Segmentation
    seconds: float


# --- judging --------------------------------------------------------------------------------------


def tidied(mesh: sw.Mesh, labels: IntArray) -> IntArray:
    """Labels in which faces of segments under 0.02 m² have the label of the nearest face of a larger one."""
    area = np.bincount(labels[labels >= 0], mesh.face_areas[labels >= 0])
    is_small = (labels >= 0) & (area[labels] < SMALLEST)
    large = np.flatnonzero((labels >= 0) & ~is_small)
    if not is_small.any() or len(large) == 0:
        return labels
    large = large[:: max(1, len(large) // 150_000)]
    labels = labels.copy()
    _, near = cKDTree(mesh.face_centroids[large]).query(mesh.face_centroids[is_small], workers=-1)
    labels[is_small] = labels[large[near]]
    return labels


def judged(scan: Scan, outcome: Outcome) -> dict[str, float]:
    """A row of the table."""
    made = outcome.segmentation
    labels = sw.Segmentation.from_labels(scan.mesh, tidied(scan.mesh, made.labels)).labels
    segmentation = sw.Segmentation(scan.mesh, labels, levels=made.levels)
    correction = simulate_annotator(segmentation, scan.truth, target=EDIT_TARGET, most=MOST_EDITS)
    row = sw.evaluate({"": segmentation}, scan.truth, scan.mesh, metrics=list(COLUMNS)).iloc[0]
    return {
        **{short: float(row[name]) for name, short in COLUMNS.items()},
        "edits": float(len(correction.edits)) if correction.reached else float(MOST_EDITS),
        "segments": segmentation.n_segments,
        "of": scan.truth.n_segments,
        "coverage": made.coverage,
        "seconds": outcome.seconds,
    }


# --- methods --------------------------------------------------------------------------------------


def by_engine(scan: Scan, params: sw.Params) -> Outcome:
    """What a user gets: the scan as it is."""
    start = time.perf_counter()
    made = sw.segment(scan.mesh, params)
    return Outcome(made, time.perf_counter() - start)


def by_felzenszwalb(mesh: sw.Mesh, thresholds: tuple[float, ...]) -> Iterator[Outcome]:
    """On the raw faces."""
    start = time.perf_counter()
    graph = mesh_graph(mesh, "faces", "outward", SILENT)
    seconds = time.perf_counter() - start
    for threshold in thresholds:
        start = time.perf_counter()
        (labels,) = segment_graph(graph, (threshold,), MIN_SIZE, SILENT)
        yield Outcome(sw.Segmentation.from_labels(mesh, labels), seconds + time.perf_counter() - start)


def by_felzenszwalb_simplified(mesh: sw.Mesh, thresholds: tuple[float, ...]) -> Iterator[Outcome]:
    """On the simplified mesh, the smallest piece the same share of the faces, mapped back."""
    start = time.perf_counter()
    small = preprocess.simplify(mesh, n_faces=N_SIMPLIFIED)
    graph = mesh_graph(small.mesh, "faces", "outward", SILENT)
    seconds = time.perf_counter() - start
    least = max(1, round(MIN_SIZE * small.mesh.n_faces / mesh.n_faces))
    for threshold in thresholds:
        start = time.perf_counter()
        (labels,) = segment_graph(graph, (threshold,), least, SILENT)
        labels = np.append(labels, -1)[small.face_map]
        yield Outcome(sw.Segmentation.from_labels(mesh, labels), seconds + time.perf_counter() - start)


def by_filtered_normals(mesh: sw.Mesh, thresholds: tuple[float, ...]) -> Iterator[Outcome]:
    """Felzenszwalb on filtered normals, then the pieces of a plane joined."""
    start = time.perf_counter()
    pairs = face_adjacency(mesh)
    normals = preprocess.filter_normals(mesh, pairs, sweeps=30)
    weights = 1.0 - np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]])
    order = np.argsort(weights, kind="stable")
    patches = felzenszwalb.join_light_edges(
        mesh.n_faces, pairs, weights, threshold=0.001, min_size=30, order=order
    )
    seconds = time.perf_counter() - start
    for threshold in thresholds:
        start = time.perf_counter()
        pieces = felzenszwalb.join_light_edges(
            mesh.n_faces, pairs, weights, threshold=threshold, min_size=MIN_SIZE, order=order
        )
        labels = with_planes(mesh, pieces, patches, normals)
        yield Outcome(sw.Segmentation.from_labels(mesh, labels), seconds + time.perf_counter() - start)


def with_planes(mesh: sw.Mesh, pieces: IntArray, patches: IntArray, normals: FloatArray) -> IntArray:
    """Pieces of one wall, floor or ceiling joined; ``patches`` are what planes are measured with."""
    code = pieces.astype(np.int64) * (int(patches.max()) + 1) + patches
    _, first, item = np.unique(code, return_index=True, return_inverse=True)
    item = item.astype(np.int32)
    patch_items = items.patch_items(mesh, item, pairs=np.empty((0, 2), np.int32), normals=normals)
    return hull.join_planes(patch_items, pieces[first])[item]


Search = Callable[[sw.Mesh, tuple[float, ...]], Iterator[Outcome]]
METHODS: dict[str, Search] = {
    "raw": by_felzenszwalb,
    "simplified": by_felzenszwalb_simplified,
    "strong": by_filtered_normals,
}


def searched(scan: Scan, method: str) -> dict[str, dict[str, float]]:
    """Rows with the best c for this scan and with the fixed one, and 1 − RI for every c."""
    curve: dict[float, float] = {}
    levels = {"dihedral": dihedral_partition(scan.mesh)}
    kept: dict[str, tuple[float, Outcome]] = {}
    thresholds = tuple(sorted({*THRESHOLDS, FIXED[method]}))
    for c, outcome in zip(thresholds, METHODS[method](scan.from_inside, thresholds)):
        levels.setdefault("base", outcome.segmentation.labels)
        labels = tidied(scan.mesh, outcome.segmentation.labels)
        curve[c] = sw.metrics.rand_index_error(labels, scan.truth.labels)
        if curve[c] == min(curve.values()):
            kept["best"] = c, outcome
        if c == FIXED[method]:
            kept["fixed"] = c, outcome
    rows = {}
    for which, (c, outcome) in kept.items():
        made = sw.Segmentation(scan.mesh, outcome.segmentation.labels, levels=levels)
        rows[which] = {**judged(scan, Outcome(made, outcome.seconds)), "c": c}
    return {**rows, "curve": {str(c): error for c, error in curve.items()}}


# --- what was computed before ---------------------------------------------------------------------


class Cache:
    """Rows on disk; a row is found again under the digest of all that it depends on."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def get(self, scan: Scan, name: str, depends_on: Any, compute: Callable[[], Any]) -> Any:
        """The value kept under this name, computed where what it depends on has changed."""
        digest = hashlib.sha256(repr((judging_digest(), scan.recipe, depends_on)).encode()).hexdigest()[:16]
        file = self.folder / "rows" / scan.name / f"{name}-{digest}.json"
        if file.exists():
            return json.loads(file.read_text())
        value = compute()
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(value))
        return value


@cache
def judging_digest() -> str:
    """Of how rows are judged."""
    sources = [inspect.getsource(part) for part in (tidied, judged, annotator)]
    return hashlib.sha256("".join(sources).encode()).hexdigest()


@cache
def engine_digest() -> str:
    """Of all that the engine's modules say."""
    folder = Path(inspect.getfile(sw.Params)).parent
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(folder.glob("*.py")))).hexdigest()


@cache
def probe(name: str) -> str:
    """What a method makes of the shipped room stands for its code."""
    mesh, _ = sw.datasets.load_room()
    if name in PRESETS:
        made = [sw.segment(mesh, PRESETS[name])]
    else:
        made = [outcome.segmentation for outcome in METHODS[name](mesh, (0.06, 2.5))]
    return hashlib.sha256(b"".join(m.labels.tobytes() for m in made)).hexdigest()


# --- tables ---------------------------------------------------------------------------------------


def engine_row(
    kept: Cache,
    scan: Scan,
    name: str,
    params: sw.Params,
    seeds: list[int],
) -> dict[str, float]:
    """Mean over the seeds."""
    code = probe("thesis") if name == "thesis" else engine_digest()
    rows = []
    for seed in seeds:
        options = params.replace(seed=seed)
        rows.append(kept.get(scan, name, (code, options), lambda o=options: judged(scan, by_engine(scan, o))))
    mean = pd.DataFrame(rows).mean().to_dict()
    return {**mean, "±": float(np.ptp([row["1-RI"] for row in rows])) / 2}


def rows_of(
    kept: Cache, scan: Scan, wanted: list[str], seeds: list[int]
) -> Iterator[tuple[str, dict[str, float]]]:
    """Every method on one scan."""
    for name, params in PRESETS.items():
        if name in wanted:
            yield name, engine_row(kept, scan, name, params, seeds)
    for method, title in SEARCHED.items():
        if method not in wanted:
            continue
        code = (probe(method), inspect.getsource(METHODS[method]), THRESHOLDS, FIXED[method])
        rows = kept.get(scan, method, code, lambda m=method: searched(scan, m))
        yield f"{title}, best c", rows["best"]
        yield f"{title}, c = {FIXED[method]:g}", rows["fixed"]
        if scan.half == "tuning":
            CURVES.setdefault(method, []).append(rows["curve"])


CURVES: dict[str, list[dict[str, float]]] = {}  # of the tuning half


def print_tables(kept: Cache, arguments: argparse.Namespace) -> None:
    """Scan by scan, then the means of each half and what they come to beside the targets."""
    tables: dict[str, dict[str, pd.DataFrame]] = {}
    clean: dict[str, float] = {}
    for scan in scans(arguments.scans, arguments.half, kept.folder):
        rows = pd.DataFrame(dict(rows_of(kept, scan, arguments.rows, arguments.seeds))).T.astype(float)
        tables.setdefault(scan.half, {})[scan.name] = rows
        if {RAW, SIMPLIFIED} <= set(rows.index):
            rows.loc[BETTER] = rows.loc[rows.loc[[RAW, SIMPLIFIED], "1-RI"].idxmin()]
        if scan.is_clean and "default" in rows.index:
            clean[scan.name] = rows.loc["default", "1-RI"]
        print(f"\n{scan.half}: {scan.name}, {scan.mesh.n_faces} faces\n{shown(rows)}", flush=True)
    if arguments.csv:
        write_csv({(half, scan): t for half, ts in tables.items() for scan, t in ts.items()}, arguments.csv)
    for half, by_scan in tables.items():
        every = pd.concat(by_scan)
        mean = every.groupby(level=1, sort=False).mean()
        print(f"\n{half}: mean over {len(by_scan)} scans\n{shown(mean.drop(columns='c', errors='ignore'))}")
        if {"default", BETTER} <= set(mean.index):
            print_targets(half, by_scan, mean)
    for name, error in clean.items():
        print(f"\n{name}, a clean room: 1-RI of the default {error:.4f}, target 0.01")
    for method, curves in CURVES.items():
        means = pd.DataFrame(curves).mean()
        c = means.idxmin()
        print(f"{SEARCHED[method]}: best c over the tuning half {c} ({means[c]:.4f}), used {FIXED[method]:g}")


def shown(rows: pd.DataFrame) -> str:
    """Rounded as far as the figures mean something."""
    text = rows.map(lambda x: "" if np.isnan(x) else f"{x:.3f}")
    for name in {"edits", "segments", "of", "seconds"} & set(rows):
        text[name] = rows[name].map("{:.1f}".format)
    if "c" in rows:
        text["c"] = rows["c"].map(lambda c: "" if np.isnan(c) else f"{c:g}")
    return text.to_string()


def print_targets(half: str, by_scan: dict[str, pd.DataFrame], mean: pd.DataFrame) -> None:
    """The default beside the better Felzenszwalb of each scan, and beside the strong baseline."""
    best = BETTER
    print(f"\n{half}: the default against {best} of each scan")
    for column, target in TARGETS.items():
        ratio = mean.loc["default", column] / mean.loc[best, column]
        each = [t.loc["default", column] / max(t.loc[best, column], 1e-9) for t in by_scan.values()]
        print(
            f"  {column}: {ratio:.2f} × (target {target}), scan by scan {min(each):.2f} to {max(each):.2f}, "
            f"median {np.median(each):.2f}"
        )
    ours = mean.loc["default"]
    print(f"  edits to 1-RI ≤ {EDIT_TARGET}: {ours['edits']:.1f} (target 12), {mean.loc[best, 'edits']:.1f}")
    for name in mean.index:
        if name.startswith(SEARCHED["strong"]):
            theirs = mean.loc[name]
            print(
                f"  against {name!r}: 1-RI {ours['1-RI'] / theirs['1-RI']:.2f} × (target below 1), edits "
                f"{ours['edits']:.1f} instead of {theirs['edits']:.1f}"
            )
    least = min(t.loc["default", "coverage"] for t in by_scan.values())
    print(f"  coverage at least {least:.3f} (target 0.98), seconds {mean.loc['default', 'seconds']:.1f}")


def write_csv(tables: dict[tuple[str, str], pd.DataFrame], file: Path) -> None:
    """A line for each half, scan and row; notebook 10 shows what `--csv` wrote."""
    table = pd.concat(tables, names=["half", "scan", "row"])
    table.drop(columns="seconds", errors="ignore").round(4).to_csv(file)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--half", nargs="+", choices=list(HALVES), default=list(HALVES))
    parser.add_argument("--scans", nargs="+", help="names of scans; all by default")
    every = [*PRESETS, *SEARCHED]
    parser.add_argument("--rows", nargs="+", choices=every, default=every)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "scenewidget-quality")
    parser.add_argument("--csv", type=Path, help="where to write the rows of all scans")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    print_tables(Cache(arguments.cache), arguments)


if __name__ == "__main__":
    main()
