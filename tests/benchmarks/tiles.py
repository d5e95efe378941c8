"""Tiles against the whole: how much it changes that a scan is segmented tile by tile.

``python tests/benchmarks/tiles.py 40 50 4`` takes the simulated rooms of seeds 40 to 49 in four tiles, and
prints, by Rand index error: the whole against another seed, tiles against the whole, and both against the
truth. ``… memory 6000000 1500000`` segments a flat of so many faces in tiles of so many, and prints how much
memory that took beyond what the mesh takes. ``… workers 30000000 2000000`` does so on two workers of 4 GB,
then divides the flat into its rooms as `Rooms` does.
"""

import contextlib
import itertools
import sys
import tempfile
import threading
import time
import warnings

import numpy as np
import psutil
import trimesh

import scenewidget as sw
from scenewidget.batch.memory import peak, reset_peak
from scenewidget.batch.tiles import segment_tiles
from scenewidget.editing.division import Division

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


def walls_between(n_faces: int) -> sw.Mesh:
    """Rooms wall to wall, five in a row, each triangle in four, until there are so many."""
    rooms = []
    for seed in range(300, 306):
        mesh, _ = sw.datasets.simulate_room(seed=seed, n_objects=8, voxel=0.02)
        rooms.append(trimesh.remesh.subdivide(mesh.vertices, mesh.faces))
    vertices, faces = list[np.ndarray](), list[np.ndarray]()
    x = y = depth = 0.0
    n = n_vertices = 0
    for k in itertools.count():
        if n >= n_faces:
            break
        places, triangles = rooms[k % len(rooms)]
        if k and k % 5 == 0:
            x, y, depth = 0.0, y + depth + 0.15, 0.0
        vertices.append(places - places.min(axis=0) + [x, y, 0.0])
        faces.append((triangles + n_vertices).astype(np.int32))
        width, length, _ = np.ptp(places, axis=0)
        x, depth = x + width + 0.15, max(depth, length)
        n_vertices += len(places)
        n += len(triangles)
    return sw.Mesh(np.concatenate(vertices), np.concatenate(faces))


def workers(n_faces: int, max_faces: int) -> None:
    from distributed import LocalCluster

    mesh = walls_between(n_faces)
    most: dict[int, int] = {}

    def look(stage: str, fraction: float) -> None:
        print(f"{stage} {fraction:.2f}, {time.perf_counter() - start:.0f} s", flush=True)

    def watch() -> None:
        while not over.wait(0.5):
            for process in psutil.Process().children(recursive=True):
                with contextlib.suppress(psutil.Error):
                    most[process.pid] = max(most.get(process.pid, 0), process.memory_info().rss)

    over = threading.Event()
    threading.Thread(target=watch, daemon=True).start()
    start = time.perf_counter()
    with LocalCluster(
        n_workers=2, threads_per_worker=1, memory_limit="4GB", dashboard_address=":0"
    ) as cluster:
        found = segment_tiles(mesh, max_faces=max_faces, client=cluster, progress=look)
    over.set()
    spent, sizes = time.perf_counter() - start, sorted(round(size / 1e9, 2) for size in most.values())
    print(f"{found}, {found.report['tiles']} tiles, {spent:.0f} s")
    print(f"at most {sizes} GB in the workers, {(peak() or 0) / 1e9:.2f} GB here")
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as place:
        rooms = Division.make(f"{place}/flat", mesh, segmentation=found)
        print(f"{rooms} in {time.perf_counter() - start:.0f} s: {rooms.n_faces}")


if __name__ == "__main__":
    warnings.simplefilter("ignore", UserWarning)
    if sys.argv[1] in ("memory", "workers"):
        {"memory": memory, "workers": workers}[sys.argv[1]](int(sys.argv[2]), int(sys.argv[3]))
    else:
        against_the_whole(range(int(sys.argv[1]), int(sys.argv[2])), int(sys.argv[3]))
