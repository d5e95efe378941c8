"""Many scans at once: how much faster two workers are, what a scan costs besides, what faults do.

``python tests/benchmarks/dataset.py speed`` segments simulated rooms with one worker, which takes all cores
or one, and with two, interleaved, and by plain processes for comparison. ``… overhead 10000`` hands out so
many scans whose work is nothing, and tells CPU and wall time for each. ``… faults 1513 30 20`` segments so
many pieces of simulated rooms, of which 20 are damaged, kills 30 times a worker and once the client, resumes,
and counts what became of each scan; some labels are compared with those of `segment` without any of this.
"""

import contextlib
import itertools
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import psutil

import scenewidget as sw
from scenewidget.batch import pools
from scenewidget.batch.plan import Job
from scenewidget.batch.schedule import work_through
from scenewidget.batch.tiles import tiles
from scenewidget.engine.threads import KNOB

CLIENT = """
import sys
import scenewidget as sw
run = sw.segment_all(sys.argv[1], sys.argv[2], n_workers=2, progress=False)
run.to_frame().to_json(sys.argv[3], orient="records")
"""
DAMAGES = {  # what may have become of a file
    "empty": lambda data, rng: b"",
    "cut in its header": lambda data, rng: data[: rng.randrange(5, 60)],
    "cut in its numbers": lambda data, rng: data[: len(data) // 2],
    "an error page": lambda data, rng: b"<html>404 Not Found</html>",
    "noise": lambda data, rng: rng.randbytes(len(data)),
}


def speed(folder: Path, n_rounds: int = 2) -> None:
    scans = folder / "scans"
    scans.mkdir()
    for seed in range(8):
        mesh, _ = sw.datasets.simulate_room(seed=seed, n_objects=6, voxel=0.03)
        sw.save_mesh(mesh, scans / f"{seed}.ply")
    ways = {"one worker, all cores": (1, ""), "one worker, one core": (1, "1"), "two workers": (2, "1")}
    seconds: dict[str, list[float]] = {way: [] for way in ways}
    for attempt, (way, (n, threads)) in itertools.product(range(n_rounds), ways.items()):
        os.environ[KNOB] = threads
        out = folder / f"{way}{attempt}"
        with pools.open_pool(n_workers=n) as pool:
            warm = Job("warm", str(scans / "0.ply"), str(out / "warm"), sw.Params())
            work_through([warm] * n, pool, lambda job, row: None, _never())
            jobs = [
                Job(path.name, str(path), str(out / path.name), sw.Params(), size=path.stat().st_size)
                for path in sorted(scans.iterdir())
            ]
            cpu, start = _cpu(), time.perf_counter()
            work_through(jobs, pool, lambda job, row: None, _never())
            seconds[way].append(time.perf_counter() - start)
            print(f"{way}: {seconds[way][-1]:.2f} s, {_cpu() - cpu:.1f} s CPU of the workers", flush=True)
    alone = [_alone(scans, n) for n in (1, 2)]
    print(f"without Dask, one core each: {alone[0]:.2f} s by one process, {alone[1]:.2f} s by two, "
          f"{alone[0] / alone[1]:.2f} times as fast")  # fmt: skip
    least = {way: min(all_of_them) for way, all_of_them in seconds.items()}
    for way in list(ways)[:2]:
        print(f"two workers are {least[way] / least['two workers']:.2f} times as fast as {way}")


def _cpu() -> float:
    """Seconds of CPU that workers of ours have taken so far."""
    total = 0.0
    for process in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.Error):
            total += sum(process.cpu_times()[:2])
    return total


def _alone(scans: Path, n: int) -> float:
    """Seconds that ``n`` plain processes take for all scans; each begins when all are warm."""
    code = (
        "import sys, scenewidget as sw; paths = sys.argv[1:]; sw.segment(sw.load(paths[0]))\n"
        "print('warm', flush=True); input(); [sw.segment(sw.load(path)) for path in paths]"
    )
    paths = sorted(map(str, scans.iterdir()))
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    running = [
        subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", code, *paths[k::n]], **pipes, env=os.environ | {KNOB: "1"}
        )
        for k in range(n)
    ]
    for process in running:
        process.stdout.readline()
    start = time.perf_counter()
    for process in running:
        process.stdin.write("\n")
        process.stdin.flush()
    for process in running:
        process.wait()
    return time.perf_counter() - start


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
    scans, out, table = folder / "scans", folder / "out", folder / "table.json"
    scans.mkdir()
    _write_pieces(scans, n)
    rng = random.Random(0)
    damaged = rng.sample(sorted(scans.iterdir()), n_damaged)
    for path, damage in zip(damaged, itertools.cycle(DAMAGES.values()), strict=False):
        path.write_bytes(damage(path.read_bytes(), rng))
    command = [sys.executable, "-c", CLIENT, str(scans), str(out), str(table)]
    killed, is_resumed = 0, False
    start = time.perf_counter()
    process = subprocess.Popen(command)
    while process.poll() is None:
        time.sleep(0.5)
        rows = sum(1 for _ in out.glob("*/row.json")) if out.is_dir() else 0
        if not is_resumed and rows > n / 2:
            print(f"the client is killed at {rows} rows, after {killed} kills", flush=True)
            process.kill()
            process.wait()
            is_resumed = True
            process = subprocess.Popen(command)
        elif killed < n_kills and rows >= n * (killed + 0.5) / (n_kills + 1):
            killed += _kill_one(process.pid, rng, with_keeper=killed % 10 == 9)
    spent = time.perf_counter() - start
    if process.returncode:
        raise SystemExit(f"the client ended with {process.returncode}")
    rows = json.loads(table.read_text())
    statuses = {row["scan"]: row["status"] for row in rows}
    print(f"{killed} workers and the client killed, {spent:.0f} s: {dict(Counter(statuses.values()))}")
    print(f"{len(rows)} rows of {len(statuses)} scans, of {n}")
    wrong = {p.name for p in damaged} ^ {scan for scan, s in statuses.items() if s not in ("done", "reused")}
    print(f"neither damaged and failed nor whole and done: {wrong or 'none'}")
    for row in [row for row in rows if row["status"] not in ("done", "reused")][:8]:
        print("  ", row["scan"], row["status"], row["error"])
    left = [path for path in out.rglob("*") if path.name.endswith((".tmp", ".lock"))]
    done, failures = (sum(1 for _ in out.glob(f"*/{name}.json")) for name in ("row", "failed"))
    print(f"on disk {done} done, {failures} failed, half files {left}")
    same = [_is_the_same(scans / scan, out) for scan in rng.sample(sorted(set(statuses) - wrong), 40)
            if statuses[scan] in ("done", "reused")]  # fmt: skip
    print(f"labels as without a run: {sum(same)} of {len(same)}")


def _write_pieces(folder: Path, n: int) -> None:
    """Pieces of simulated rooms, of some 1 700 triangles each."""
    written = 0
    for seed in itertools.count():
        mesh, _ = sw.datasets.simulate_room(seed=seed, n_objects=6, voxel=0.08)
        for faces in tiles(mesh, max_faces=mesh.n_faces // 24, overlap=0.2):
            if written == n:
                return
            sw.save_mesh(mesh.part(faces), folder / f"{written:04}.ply")
            written += 1


def _kill_one(client: int, rng: random.Random, *, with_keeper: bool) -> bool:
    """Kill a worker, with or without the command that would start it again; False if there is none yet."""
    below = psutil.Process(client).children(recursive=True)
    with contextlib.suppress(psutil.Error):
        workers = [p for p in below if "spawn_main" in " ".join(p.cmdline())]
        if workers:
            one = rng.choice(workers)
            if with_keeper:
                one.parent().kill()
            one.kill()
            return True
    return False


def _is_the_same(scan: Path, out: Path) -> bool:
    mesh = sw.load_mesh(scan)
    labels = sw.import_labels(mesh, out / scan.name / f"{scan.stem}.npz").labels
    return np.array_equal(labels, sw.segment(mesh).labels)


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
