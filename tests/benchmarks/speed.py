"""Every figure of speed beside its target: compiling, warm calls, sliders, growth, items, the obvious stack.

Each part runs in a process of its own, on a machine that does nothing else; a figure is the median of five.

python tests/benchmarks/speed.py                              all of it, half an hour on two cores
python tests/benchmarks/speed.py --part cold warm sliders --rounds 3
python tests/benchmarks/speed.py --part growth --faces 1200000 2500000 5000000 9900000
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).parent))

import itertools

import numpy as np
from scans import add_scan_option, in_size, read_scan

from scenewidget import datasets
from scenewidget.engine.memo import n_bytes
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline, segment
from scenewidget.engine.stages import stages
from scenewidget.widget.previewer import preview_params

HERE = Path(__file__).parent
PARTS = ("cold", "room", "warm", "sliders", "growth", "items", "obvious", "minplus")
PRESETS = {"default": Params(), "thesis": Params.thesis()}
FIRST = """
import sys, time, warnings
warnings.simplefilter("ignore")
import scenewidget as sw
mesh, _ = sw.datasets.load_room()
params = sw.Params() if sys.argv[1] == "default" else sw.Params.thesis()
for _ in range(4):
    wall, cpu = time.perf_counter(), time.process_time()
    sw.segment(mesh, params)
    print(time.perf_counter() - wall, time.process_time() - cpu)
"""


def row(what: str, value: float, target: float, unit: str = "s") -> None:
    """One figure, its target, and whether it is met."""
    verdict = "met" if value <= target else "NOT MET"
    print(f"{what:58} {value:9.2f} {unit:4} target {target:7.2f}  {verdict}", flush=True)


def seconds(function, *arguments, **options):
    """Wall and processor seconds of a call, and its result."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = function(*arguments, **options)
    return time.perf_counter() - wall, time.process_time() - cpu, result


def cold(rounds: int) -> None:
    """What compiling costs, in later calls of the same process; with an empty cache each time."""
    for preset in PRESETS:
        ratios, shares, costs = [], [], []
        for _ in range(rounds):
            with tempfile.TemporaryDirectory() as cache:
                command = [sys.executable, "-c", FIRST, preset]
                environment = os.environ | {"NUMBA_CACHE_DIR": cache}
                done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
            times = np.array([line.split() for line in done.stdout.splitlines()], dtype=float)
            first, later = times[0], np.median(times[1:], axis=0)
            costs.append(first[0] - later[0])
            ratios.append(costs[-1] / later[0])
            shares.append((first[1] - later[1]) / later[1])
        print(
            f"{preset}: compiling {median(costs):.2f} s; processor time of {median(shares):.1f} later calls"
        )
        row(f"{preset}: compiling, in later calls", median(ratios), 5.0, "")


def room(rounds: int) -> None:
    """Warm calls on the shipped room."""
    mesh, _ = datasets.load_room()
    for name, params in PRESETS.items():
        segment(mesh, params)
        runs = [seconds(segment, mesh, params)[:2] for _ in range(rounds)]
        print(f"{name}: {mesh.n_faces} faces, {median(cpu for _, cpu in runs):.2f} s of processor time")
        row(f"{name}: shipped room", median(wall for wall, _ in runs), 0.6 if name == "default" else np.inf)


def warm(scan: Path, rounds: int, n_faces: int = 1_500_000) -> None:
    """From a raw mesh to labels, and each stage beside what moving its bytes takes."""
    mesh = in_size(read_scan(scan), n_faces)
    warm_up()
    bandwidth = copying()
    for name, params in PRESETS.items():
        runs = []
        for _ in range(rounds):
            wall, cpu, result = seconds(Pipeline(fresh(mesh)).run, params)
            runs.append((wall, cpu, result.timings))
        print(f"{name}: {mesh.n_faces} faces, {median(cpu for _, cpu, _ in runs):.2f} s of processor time")
        row(
            f"{name}: labels of {mesh.n_faces} faces",
            median(r[0] for r in runs),
            2.0 if name == "default" else 2.5,
        )
        pipe, table = Pipeline(mesh), stages(params)
        pipe.run(params)
        for stage, entry in table.items():
            needs = [
                mesh if need == "mesh" else pipe.get(need, params)
                for need in entry.needs
                if need in (*table, "mesh")
            ]
            moved = sum(map(n_bytes, needs)) + n_bytes(pipe.get(stage, params))
            print(f"  {stage:14} {median(r[2][stage] for r in runs):7.3f} s   "
                  f"moving its inputs and outputs once {moved / bandwidth:7.3f} s")  # fmt: skip


def sliders(scan: Path, n_faces: int = 1_000_000) -> None:
    """What answers wait for after a slider has moved: the worst of twenty."""
    mesh = in_size(read_scan(scan), n_faces)
    warm_up()
    params = Params(n_segments=30, k_range=(20, 60))
    pipe = Pipeline(mesh)
    pipe.run(params)
    moves = {
        "S": lambda i: params.replace(n_segments=31 + i),
        "k-range": lambda i: params.replace(k_range=(20 + i % 5, 61 + i)),
        "exponent": lambda i: params.replace(cost_exponent=1.5 + 0.02 * (i + 1)),
    }
    worst = {}
    for what, moved in moves.items():
        pipe.run(params)
        worst[what] = max(seconds(pipe.run, moved(i))[0] for i in range(20))

    def preview(wanted: Params) -> None:
        pipe.get("items", wanted)
        pipe.get("nested", wanted).item_labels(wanted.n_segments)

    pipe.run(params)
    ways = [preview_params(pipe, moves["S"](i), params) for i in range(20)]
    preview(ways[0])  # makes what all others are cut from
    worst["preview of S"] = max(seconds(preview, wanted)[0] for wanted in ways)
    targets = {"S": 0.15, "k-range": 0.5, "exponent": 0.5, "preview of S": 0.1}
    for what, target in targets.items():
        row(f"{what}, {mesh.n_faces} faces, worst of 20", worst[what], target)


def growth(scan: Path, sizes: list[int]) -> None:
    """Seconds and memory with the number of raw faces, each in a process of its own."""
    found = []
    for n_faces in sizes:
        done = subprocess.run(
            [sys.executable, __file__, "--scan", str(scan), "--one", str(n_faces)],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        n, wall, cpu, items, before, peak = map(float, done.stdout.split()[-6:])
        found.append((n, wall))
        print(
            f"{int(n):9} faces {wall:7.2f} s ({cpu:.1f} on all cores), items {items:.2f}, "
            f"{before:.1f} GB, then {peak:.1f} GB"
        )
        row(f"memory of {int(n)} faces", peak, 1.0 + 350e-9 * n, "GB")
    for (few, short), (many, long) in itertools.pairwise(found):
        row(f"{many / few:.1f} × the faces, × the time", long / short, 1.2 * many / few, "")
    row(
        "seconds a million faces, largest over smallest",
        found[-1][1] / found[-1][0] * found[0][0] / found[0][1],
        1.2,
        "",
    )


def one(scan: Path, n_faces: int) -> None:
    """The default on one size: faces, seconds, of the processor, of the items, GB before and at the peak."""
    mesh = in_size(read_scan(scan), n_faces)
    warm_up()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    wall, cpu, result = seconds(Pipeline(mesh).run)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(mesh.n_faces, wall, cpu, result.timings["items"], before, peak)


def items(scan: Path, counts: list[int]) -> None:
    """Seconds with the number of items: distances and their comparison are quadratic, nothing is more."""
    mesh = read_scan(scan)
    warm_up()
    for n_items in counts:
        wall, _, result = seconds(Pipeline(mesh).run, Params(n_items=n_items, item_area=1e-6))
        slow = sorted(result.timings.items(), key=lambda entry: -entry[1])[:4]
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(f"{result.items.n:9} items {wall:7.2f} s, {peak:5.1f} GB, {1e6 * wall / result.items.n**2:.2f} "
              "µs a pair; " + ", ".join(f"{stage} {s:.2f}" for stage, s in slow), flush=True)  # fmt: skip


def fresh(mesh):
    """The same mesh without what has been computed of it."""
    return type(mesh)(mesh.vertices, mesh.faces, mesh.vertex_colors)


def copying() -> float:
    """Bytes that one core reads and writes in a second."""
    source = np.ones(25_000_000)
    target = np.empty_like(source)
    best = min(seconds(np.copyto, target, source)[0] for _ in range(5))
    return 2 * source.nbytes / best


def warm_up() -> None:
    """Compile everything on a small scan."""
    mesh, _ = datasets.load_room()
    for params in PRESETS.values():
        segment(mesh, params)


def main() -> None:
    """Run the parts that were asked for, each in a process of its own."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    add_scan_option(parser)
    parser.add_argument("--part", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--faces", type=int, nargs="+", default=[1_200_000, 2_500_000, 5_000_000, 9_900_000])
    parser.add_argument("--items", type=int, nargs="+", default=[5_000, 10_000, 20_000, 40_000])
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    if options.one:
        one(options.scan, options.one)
        return
    if len(options.part) > 1:
        rest = ["--scan", str(options.scan), "--rounds", str(options.rounds)]
        rest += ["--faces", *map(str, options.faces), "--items", *map(str, options.items)]
        for part in options.part:
            print(f"\n{part}", flush=True)
            subprocess.run([sys.executable, __file__, "--part", part, *rest], check=True)
        return
    (part,) = options.part
    if part == "obvious":  # at least 40 × slower
        subprocess.run([sys.executable, HERE / "obvious_stack.py", "--scan", options.scan], check=True)
    elif part == "minplus":  # at least 60 × faster than scipy's Dijkstra
        subprocess.run(
            [sys.executable, HERE / "distances.py", "--scan", options.scan, "--items", "10000"], check=True
        )
    elif part in ("cold", "room"):
        {"cold": cold, "room": room}[part](options.rounds)
    elif part == "warm":
        warm(options.scan, options.rounds)
    elif part == "sliders":
        sliders(options.scan)
    elif part == "growth":
        growth(options.scan, options.faces)
    else:
        items(options.scan, options.items)


if __name__ == "__main__":
    main()
