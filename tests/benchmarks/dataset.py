"""Many scans at once: how much faster two workers are, what a scan costs besides, what faults do.

``python tests/benchmarks/dataset.py speed`` segments simulated rooms with one worker and with two,
interleaved. ``… overhead 10000`` hands out so many scans whose work is nothing, and tells CPU and wall time
for each. ``… faults 1513 30 20`` runs so many small scans, of which 20 are damaged, through everything but
the segmentation itself, kills 30 times a worker and once the client, resumes, and counts what became of
each scan.
"""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import psutil

import scenewidget as sw
from scenewidget.batch import pools
from scenewidget.batch.plan import Job
from scenewidget.batch.schedule import work_through
from scenewidget.datasets import analytic

CLIENT = """
import functools, sys
import scenewidget as sw
from scenewidget.batch import pools, runs

def make():
    def task(job):  # everything but the segmentation
        import numpy as np
        from scenewidget.batch import job as module, pools
        from scenewidget.engine.segmentation import Segmentation

        def segment(mesh, params, progress):
            return Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // 9)

        module.segment = segment
        return pools.on_worker(job)
    return task

runs.open_pool = functools.partial(pools.open_pool, task=make())
run = sw.segment_all(sys.argv[1], sys.argv[2], n_workers=2, progress=False)
run.to_frame().to_json(sys.argv[3], orient="records")
"""


def write_scan(path: Path, n: int, tilt: float) -> None:
    mesh = analytic.square(n)
    rows = "".join(f"{x} {y} {tilt * x}\n" for x, y, _ in mesh.vertices.tolist())
    faces = "".join(f"3 {a} {b} {c}\n" for a, b, c in mesh.faces.tolist())
    path.write_text(f"OFF\n{mesh.n_vertices} {mesh.n_faces} 0\n{rows}{faces}")


def speed(folder: Path) -> None:
    (folder / "scans").mkdir()
    for seed in range(8):
        mesh, _ = sw.datasets.simulate_room(seed=seed, n_objects=6, voxel=0.03)
        sw.export(
            sw.Segmentation.from_labels(mesh, mesh.faces[:, 0] * 0), mesh, folder / "scans" / f"{seed}.ply"
        )
    seconds: dict[int, list[float]] = {1: [], 2: []}
    for attempt in range(2):
        for n in (1, 2):
            with pools.open_pool(n_workers=n) as pool:
                warm = Job(
                    "warm", str(folder / "scans" / "0.ply"), str(folder / f"warm{attempt}{n}"), sw.Params()
                )
                work_through([warm] * n, pool, lambda job, row: None, _never())
                jobs = [
                    Job(
                        p.name,
                        str(p),
                        str(folder / f"out{attempt}{n}" / p.name),
                        sw.Params(),
                        size=p.stat().st_size,
                    )
                    for p in sorted((folder / "scans").iterdir())
                ]
                start = time.perf_counter()
                work_through(
                    jobs, pool, lambda job, row: print(job.scan, row["status"], row["seconds"]), _never()
                )
                seconds[n].append(time.perf_counter() - start)
                print(f"{n} workers: {seconds[n][-1]:.1f} s")
    print(f"two workers are {min(seconds[1]) / min(seconds[2]):.2f} times as fast as one")


def overhead(folder: Path, n: int) -> None:
    def task(job):
        return {"scan": job.scan, "status": "done", "error": ""}

    with pools.open_pool(n_workers=2, task=task) as pool:
        jobs = [Job(str(i), "", str(folder), sw.Params()) for i in range(n)]
        work_through(jobs[:20], pool, lambda job, row: None, _never())
        counted: list[str] = []
        wall, cpu = time.perf_counter(), time.process_time()
        work_through(jobs, pool, lambda job, row: counted.append(row["status"]), _never())
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"{Counter(counted)}: {1000 * wall / n:.1f} ms a scan, {1000 * cpu / n:.1f} ms CPU of the client")


def faults(folder: Path, n: int, n_kills: int, n_damaged: int) -> None:
    (folder / "scans").mkdir()
    for i in range(n):
        write_scan(folder / "scans" / f"{i:04}.off", 3 + i % 5, i / n)
    rng = random.Random(0)
    for i in rng.sample(range(n), n_damaged):
        path = folder / "scans" / f"{i:04}.off"
        path.write_bytes(path.read_bytes()[: rng.randrange(5, 60)])
    out, table = folder / "out", folder / "table.json"
    command = [sys.executable, "-c", CLIENT, str(folder / "scans"), str(out), str(table)]
    killed, clients = 0, 0
    start = time.perf_counter()
    process = subprocess.Popen(command)
    while process.poll() is None:
        time.sleep(0.5)
        rows = sum(1 for _ in out.glob("*/row.json")) if out.is_dir() else 0
        if clients == 0 and rows > n / 2:
            print(f"the client is killed at {rows} rows, after {killed} kills")
            process.kill()
            process.wait()
            clients = 1
            time.sleep(2)
            process = subprocess.Popen(command)
        elif killed < n_kills and rows > n * killed / n_kills:
            with_workers = psutil.Process(process.pid).children(recursive=True)
            workers = [p for p in with_workers if "spawn_main" in " ".join(p.cmdline())]
            if workers:
                os.kill(rng.choice(workers).pid, signal.SIGKILL)
                killed += 1
    rows = json.loads(table.read_text())
    statuses = Counter(row["status"] for row in rows)
    print(
        f"{killed} workers and {clients} client killed, {time.perf_counter() - start:.0f} s: {dict(statuses)}"
    )
    names = [row["scan"] for row in rows]
    print(f"{len(names)} rows, {len(set(names))} scans; of others' errors: "
          f"{[row for row in rows if row['status'] not in ('done', 'reused', 'failed')][:3]}")  # fmt: skip
    left = [path for path in out.rglob("*") if path.name.endswith(".tmp")]
    done = sum(1 for _ in out.glob("*/row.json"))
    failures = sum(1 for _ in out.glob("*/failed.json"))
    print(f"rows on disk {done}, failures on disk {failures}, half files {left}")


def _never():
    import threading

    return threading.Event()


def main() -> None:
    what, *numbers = sys.argv[1:] or ["speed"]
    folder = Path(tempfile.mkdtemp(prefix="dataset-"))
    try:
        {"speed": speed, "overhead": overhead, "faults": faults}[what](folder, *map(int, numbers))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
