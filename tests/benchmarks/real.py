"""How the default does on real scans, and whether it depends on what it should not depend on.

    python tests/benchmarks/real.py [--scans kitchen_25mm tabletop_1] [--pictures DIR] [--no-baselines]

For each scan of `../shared/data/real` (research only: never copied into the repository; said so where it is
missing): errors by faces, those without annotation left out; Felzenszwalb at the c that is best for this very
scan, raw or on 10 k faces, and at c = 4 on 10 k faces; in every row pieces under 0.02 s² m² go to the nearest
larger one, s = min(1, √(area / 20 m²)). Then the mean IoU (by area / plain, crumbs left out) with the result
of other seeds, of another order of the faces, at half and double the size, and on 60 k faces; and the error
where few segments are asked for.
"""

from __future__ import annotations

import argparse
import itertools
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

import scenewidget as sw
from scenewidget.baselines.graph_segmentation import mesh_graph, segment_graph
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.monitor import SILENT
from scenewidget.engine.preprocess import simplify

REAL = Path(__file__).parents[3] / "shared" / "data" / "real"
SCANS = ("kitchen_12mm", "kitchen_25mm", *(f"tabletop_{i}" for i in range(1, 7)))
THRESHOLDS = (0.25, 0.6, 1.0, 1.5, 2.5, 4.0, 6.0, 8.0, 11.0, 15.0, 20.0, 28.0, 40.0)
COARSE = (8, 12, 20, 30)  # segments asked for
MIN_SIZE, N_SIMPLIFIED = 500, 10_000


def read(name: str) -> tuple[sw.Mesh, IntArray]:
    """The scan and its instances, −1 where it is not annotated."""
    kept = np.load(REAL / f"{name}.npz")
    return sw.Mesh(kept["vertices"], kept["faces"], kept["colors"]), kept["instances"].astype(np.int64)


def crumb(mesh: sw.Mesh) -> float:
    """Area below which a piece counts as none."""
    return 0.02 * min(1.0, float(mesh.face_areas.sum()) / 20.0)


def tidied(mesh: sw.Mesh, labels: IntArray) -> IntArray:
    """Labels in which faces of crumbs have the label of the nearest face of a larger piece."""
    area = np.bincount(labels[labels >= 0], mesh.face_areas[labels >= 0])
    is_small = (labels >= 0) & (area[labels] < crumb(mesh))
    large = np.flatnonzero((labels >= 0) & ~is_small)
    if not is_small.any() or len(large) == 0:
        return labels
    large = large[:: max(1, len(large) // 150_000)]
    labels = labels.copy()
    _, near = cKDTree(mesh.face_centroids[large]).query(mesh.face_centroids[is_small])
    labels[is_small] = labels[large[near]]
    return labels


def errors(mesh: sw.Mesh, labels: IntArray, truth: IntArray) -> FloatArray:
    """1 − RI, GCE, LCE."""
    keep = truth >= 0
    a, b = tidied(mesh, labels)[keep], truth[keep]
    measures = (
        sw.metrics.rand_index_error,
        sw.metrics.global_consistency_error,
        sw.metrics.local_consistency_error,
    )
    return np.array([measure(a, b) for measure in measures])


def agreement(a: IntArray, b: IntArray, areas: FloatArray, least: float) -> tuple[float, float]:
    """Mean over the segments of both sides of their best IoU, by area and plain."""
    keep = (a >= 0) & (b >= 0)
    table = sparse.coo_array((areas[keep], (a[keep], b[keep]))).tocsr().tocoo()
    r, s = (np.asarray(table.sum(axis=axis)).ravel() for axis in (1, 0))
    iou = table.data / (r[table.row] + s[table.col] - table.data)
    best_r, best_s = np.zeros(len(r)), np.zeros(len(s))
    np.maximum.at(best_r, table.row, iou)
    np.maximum.at(best_s, table.col, iou)
    by_area = ((best_r * r).sum() / r.sum() + (best_s * s).sum() / s.sum()) / 2
    return float(by_area), float((best_r[r >= least].mean() + best_s[s >= least].mean()) / 2)


def felzenszwalb(mesh: sw.Mesh) -> Iterator[tuple[str, IntArray]]:
    """Labels for every threshold, on the raw faces and on the simplified ones."""
    graph = mesh_graph(mesh, "faces", "outward", SILENT)
    for c in THRESHOLDS:
        yield f"raw, c = {c:g}", segment_graph(graph, (c,), MIN_SIZE, SILENT)[0]
    small = simplify(mesh, n_faces=N_SIMPLIFIED)
    graph = mesh_graph(small.mesh, "faces", "outward", SILENT)
    least = max(1, round(MIN_SIZE * small.mesh.n_faces / mesh.n_faces))
    for c in THRESHOLDS:
        yield f"10 k, c = {c:g}", np.append(segment_graph(graph, (c,), least, SILENT)[0], -1)[small.face_map]


def variants(mesh: sw.Mesh) -> Iterator[tuple[str, IntArray]]:
    """Labels of the default on what should give the same pieces."""
    order = np.random.default_rng(0).permutation(mesh.n_faces)
    labels = np.empty(mesh.n_faces, np.int64)
    labels[order] = sw.segment(sw.Mesh(mesh.vertices, mesh.faces[order], mesh.vertex_colors)).labels
    yield "other order", labels
    for factor in (0.5, 2.0):
        scaled = sw.Mesh(factor * mesh.vertices, mesh.faces, mesh.vertex_colors)
        yield f"size × {factor:g}", sw.segment(scaled).labels
    small = simplify(mesh, n_faces=60_000)
    yield "60 k faces", np.append(sw.segment(small.mesh).labels, -1)[small.face_map]


def draw(mesh: sw.Mesh, columns: dict[str, IntArray], file: Path) -> None:
    """Each labeling side by side, seen from above at a slant; grey where there is no label."""
    from PIL import Image

    rng, tiles = np.random.default_rng(3), []
    colors = np.concatenate([rng.integers(60, 250, (1000, 3)), [[90, 90, 90]]]).astype(np.uint8)
    x, y, z = mesh.face_centroids.T
    place = np.stack([x, 0.6 * y + 0.8 * z])
    place = ((place - place.min(axis=1, keepdims=True)) * (599 / np.ptp(place, axis=1).max())).astype(int)
    order = np.argsort(0.6 * z - 0.8 * y)
    for labels in columns.values():
        tile = np.full((602, 602, 3), 255, np.uint8)
        for across, up in itertools.product((0, 1), (0, 1)):
            tile[600 - place[1][order] - up, place[0][order] + across] = colors[
                np.where(labels >= 0, labels % 1000, 1000)
            ][order]
        tiles.append(tile)
    Image.fromarray(np.concatenate(tiles, axis=1)).save(file)


def main() -> None:
    """Print a block of lines for each scan."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scans", nargs="+", default=SCANS)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--no-baselines", action="store_true")
    parser.add_argument("--no-variants", action="store_true", help="seeds only")
    parser.add_argument("--pictures", type=Path, help="folder outside the repository")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    for name in arguments.scans:
        if not (REAL / f"{name}.npz").exists():
            print(f"{name}: not there, left out")
            continue
        mesh, truth = read(name)
        start = time.process_time()
        ours = [sw.segment(mesh, sw.Params(seed=seed)).labels for seed in arguments.seeds]
        seconds = (time.process_time() - start) / len(ours)
        own = np.mean([errors(mesh, labels, truth) for labels in ours], axis=0)
        print(f"{name}: {np.round(own, 4)}, {seconds:.1f} CPU s, {ours[0].max() + 1} segments")
        others = [(f"seed {seed}", labels) for seed, labels in zip(arguments.seeds[1:], ours[1:])]
        for what, labels in itertools.chain(others, () if arguments.no_variants else variants(mesh)):
            by_area, plain = agreement(ours[0], labels, mesh.face_areas, crumb(mesh))
            error = errors(mesh, labels, truth)[0]
            print(f"  {what:12} mean IoU {by_area:.3f} / {plain:.3f}, 1-RI {error:.4f}", flush=True)
        pipe = sw.Pipeline(mesh)
        for n in () if arguments.no_variants else COARSE:
            found = pipe.run(sw.Params(n_segments=n))
            error = errors(mesh, found.labels, truth)[0]
            print(f"  S = {n:<8} {found.n_segments} segments, 1-RI {error:.4f}", flush=True)
        if not arguments.no_baselines:
            rows = {what: errors(mesh, labels, truth) for what, labels in felzenszwalb(mesh)}
            best = min(rows, key=lambda what: rows[what][0])
            for what in dict.fromkeys((best, "10 k, c = 4")):
                print(f"  Felzenszwalb {what}: {np.round(rows[what], 4)}", flush=True)
        if arguments.pictures:
            arguments.pictures.mkdir(parents=True, exist_ok=True)
            draw(mesh, {"truth": truth, "default": ours[0]}, arguments.pictures / f"{name}.png")


if __name__ == "__main__":
    main()
