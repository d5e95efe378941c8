"""How much worse a cloud of points is segmented than the annotated scan that it was sampled from.

    python tests/benchmarks/clouds.py [--scans kitchen_25mm bedroom] [--draws 5] [--points 250000]
    python tests/benchmarks/clouds.py --speed 3 --scans bedroom --points 1000000

For each scan of `../shared/data` (said so where it is missing): 1 − RI of the mesh by its faces; of clouds
drawn evenly over its surface, with normals of the scan or without any, labels carried from the nearest point
to each face. Unannotated faces are left out, and crumbs go to what is nearest, as in `real.py`. With
``--speed``, instead, seconds to read and segment files of the scan and of its clouds, in turns.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from real import REAL, SCANS, errors, read
from scipy.spatial import cKDTree

import scenewidget as sw
from scenewidget.engine.mesh import FloatArray, IntArray


def sampled(mesh: sw.Mesh, n: int, seed: int, noise: float) -> tuple[FloatArray, IntArray]:
    """Points spread evenly over the area of a mesh, moved by some noise, and the face of each."""
    rng = np.random.default_rng(seed)
    face = rng.choice(mesh.n_faces, n, p=mesh.face_areas / mesh.face_areas.sum())
    u, v = rng.random((2, n, 1))
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[face]], 1, 0)
    root = np.sqrt(u)
    points = (1 - root) * a + root * (1 - v) * b + root * v * c
    return points + noise * rng.normal(size=(n, 3)), face


def scan(name: str) -> tuple[sw.Mesh, IntArray]:
    """A scan and its instances."""
    if name.startswith("bedroom"):
        data = REAL.parent
        return sw.load_mesh(data / f"{name}.ply"), np.load(data / f"{name}_instances.npy").astype(np.int64)
    return read(name)


def time_in_turns(name: str, n: int, turns: int) -> None:
    """Print seconds of the mesh, of a cloud with normals and of one without, read and segmented."""
    mesh, _ = scan(name)
    points, face = sampled(mesh, n, 0, 0.0)
    kinds = {
        "mesh": mesh,
        "normals": sw.PointCloud(points, mesh.face_normals[face]),
        "bare": sw.PointCloud(points),
    }
    with tempfile.TemporaryDirectory() as folder:
        paths = {kind: sw.save_mesh(one, Path(folder) / f"{kind}.ply")[0] for kind, one in kinds.items()}
        for turn in range(turns + 1):  # the first compiles
            for kind, path in paths.items():
                start, began = time.perf_counter(), time.process_time()
                sw.segment(sw.load(path))
                wall, spent = time.perf_counter() - start, time.process_time() - began
                if kind == "mesh":
                    first = wall, spent
                ratios = f"{wall / first[0]:.2f} and {spent / first[1]:.2f} times the mesh"
                if turn:
                    print(f"{name:14} {kind:8} {wall:6.2f} s, {spent:6.2f} s of CPU: {ratios}", flush=True)


def main() -> None:
    """Print a row a scan."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scans", nargs="*", default=[*SCANS, "bedroom"])
    parser.add_argument("--draws", type=int, default=5)
    parser.add_argument("--points", type=int, default=250_000)
    parser.add_argument("--noise", type=float, default=0.0, help="metres")
    parser.add_argument("--without-normals", action="store_true")
    parser.add_argument("--speed", type=int, default=0, help="time so many turns instead")
    options = parser.parse_args()
    if not REAL.exists():
        print(f"{REAL} is not there: nothing to measure")
        return
    warnings.simplefilter("ignore")
    if options.speed:
        for name in options.scans:
            time_in_turns(name, options.points, options.speed)
        return
    print(f"{'scan':14} {'mesh':>7}  {'median of the clouds':>20}  {'above':>7}   all draws, seconds of CPU")
    for name in options.scans:
        mesh, truth = scan(name)
        whole = errors(mesh, sw.segment(mesh).labels, truth)[0]
        found, spent = [], time.process_time()
        for seed in range(options.draws):
            points, face = sampled(mesh, options.points, seed, options.noise)
            colors = None
            if mesh.vertex_colors is not None:
                colors = mesh.vertex_colors[mesh.faces[face, 0]]
            normals = None if options.without_normals else mesh.face_normals[face]
            cloud = sw.PointCloud(points, normals, colors)
            labels = sw.segment(cloud).labels
            _, nearest = cKDTree(points).query(mesh.face_centroids)
            found.append(errors(mesh, labels[nearest], truth)[0])
        spent = (time.process_time() - spent) / options.draws
        middle = float(np.median(found))
        draws = " ".join(f"{x:.4f}" for x in found)
        print(
            f"{name:14} {whole:7.4f}  {middle:20.4f}  {middle - whole:+7.4f}   {draws}  {spent:.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
