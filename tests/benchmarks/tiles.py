"""Tiles against the whole: how much it changes that a scan is segmented tile by tile.

``python tests/benchmarks/tiles.py 40 50 4`` takes the simulated rooms of seeds 40 to 49 in four tiles, and
prints, by Rand index error: the whole against another seed, tiles against the whole, and both against the
truth. ``… memory 6000000 1500000`` segments a flat of so many faces in tiles of so many, and prints how much
memory that took beyond what the mesh takes.
"""

import sys
import time
import warnings

import numpy as np

import scenewidget as sw
from scenewidget.batch.memory import peak, reset_peak
from scenewidget.batch.tiles import segment_tiles

RI = sw.metrics.rand_index_error


def against_the_whole(seeds: range, n_tiles: int) -> None:
    rows = []
    for seed in seeds:
        mesh, truth = sw.datasets.simulate_room(seed=seed, n_objects=8, voxel=0.04, noise=0.003)
        whole, other = (sw.segment(mesh, sw.Params(seed=k)) for k in (0, 1))
        tiled = segment_tiles(mesh, max_faces=mesh.n_faces // n_tiles + n_tiles)
        rows.append([RI(whole, other), RI(tiled, whole), RI(whole, truth), RI(tiled, truth)])
        print(seed, tiled.report["tiles"], " ".join(f"{x:.4f}" for x in rows[-1]), flush=True)
    print("mean: seed, tiles, whole to truth, tiles to truth", np.mean(rows, axis=0).round(4).tolist())


def flat(n_faces: int) -> sw.Mesh:
    """Copies of a room, each in a place of its own, until there are so many faces."""
    room, _ = sw.datasets.simulate_room(seed=0, n_objects=8, voxel=0.015, noise=0.003)
    n = -(-n_faces // room.n_faces)
    steps = [[8.0 * (k % 4), 8.0 * (k // 4), 0.0] for k in range(n)]
    faces = [room.faces + k * room.n_vertices for k in range(n)]
    return sw.Mesh(np.concatenate([room.vertices + step for step in steps]), np.concatenate(faces))


def memory(n_faces: int, max_faces: int) -> None:
    mesh = flat(n_faces)
    reset_peak()
    before = peak() or 0
    start = time.perf_counter()
    found = segment_tiles(mesh, max_faces=max_faces)
    most = peak() or 0
    print(
        f"{mesh.n_faces} faces, {found.report['tiles']} tiles, {found.n_segments} segments, "
        f"{time.perf_counter() - start:.0f} s; {before / 1e9:.2f} GB with the mesh, "
        f"{most / 1e9:.2f} GB at most"
    )


if __name__ == "__main__":
    warnings.simplefilter("ignore", UserWarning)
    if sys.argv[1] == "memory":
        memory(int(sys.argv[2]), int(sys.argv[3]))
    else:
        against_the_whole(range(int(sys.argv[1]), int(sys.argv[2])), int(sys.argv[3]))
