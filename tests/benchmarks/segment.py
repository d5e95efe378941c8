"""From a raw scan to labels: seconds a stage, peak memory, sliders, cancel, growth.

python tests/benchmarks/segment.py                         all of it, each part in a process of its own
python tests/benchmarks/segment.py --part growth --faces 100000 1000000 3000000
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1]))

from scans import add_scan_option, in_size, read_scan

from scenewidget.engine.monitor import Cancelled
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.engine.stages import stages

PRESETS = {"default": Params(), "thesis": Params.thesis()}
MOST_GIGABYTES = 6.0  # of distances


def timed(function, *arguments, **options):
    """Seconds and the result."""
    start = time.perf_counter()
    result = function(*arguments, **options)
    return time.perf_counter() - start, result


def warm_up() -> None:
    """Compile everything on a mesh of a few hundred faces."""
    import shapes

    room, _ = shapes.room(10, noise=0.01)
    for params in PRESETS.values():
        Pipeline(room).run(params)


def stage_seconds(mesh, name: str) -> None:
    """One preset on the whole scan, then what a slider costs."""
    pipe, params = Pipeline(mesh), PRESETS[name]
    seconds, result = timed(pipe.run, params)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"\n{name}: {seconds:.2f} s, peak {peak:.2f} GB, {result.n_segments} segments, "
          f"{result.coverage:.1%} of the faces labeled, {result.items.n} items")  # fmt: skip
    print("  " + ", ".join(f"{stage} {s:.2f}" for stage, s in result.timings.items()))
    print(f"  {dict(result.report)}")
    fixed = params.replace(k_range=params.k_bounds)
    for label, changed in (
        ("S alone (k-range given)", fixed.replace(n_segments=30)),
        ("S with its k-range", params.replace(n_segments=30)),
        ("exponent", params.replace(cost_exponent=1.75)),
        ("back to an earlier value", params),
    ):
        pipe.run(fixed)
        seconds, _ = timed(pipe.run, changed)
        print(f"  {label}: {seconds:.3f} s")


def cancel_latency(mesh, name: str) -> None:
    """Set the event at four moments of every stage and wait for `Cancelled`."""
    params = PRESETS[name]
    usual = Pipeline(mesh).run(params).timings
    print(f"\n{name}: seconds from cancel to Cancelled, worst of four moments in each stage")
    pipe, worst = Pipeline(mesh), {}
    for stage in stages(params):
        for need in stages(params)[stage].needs:
            if need != "mesh":
                pipe.get(need, params)
        for share in (0.0, 0.3, 0.6, 0.9):
            pipe._memo._values.pop(stages(params)[stage].key, None)  # where it had ended before the cancel
            asked = Request(stage, share * usual[stage])
            try:
                pipe.get(stage, params, progress=asked.progress, cancel=asked.cancel)
            except Cancelled:
                worst[stage] = max(worst.get(stage, 0.0), time.perf_counter() - asked.moment)
    print("  " + ", ".join(f"{stage} {s:.2f}" for stage, s in worst.items()))
    print(f"  worst: {max(worst.values()):.2f} s")


class Request:
    """A cancel some seconds after a stage has begun."""

    def __init__(self, stage: str, delay: float) -> None:
        self.stage, self.delay = stage, delay
        self.cancel, self.moment, self.timer = threading.Event(), 0.0, None

    def progress(self, stage: str, fraction: float) -> None:
        """Start the clock when the stage begins."""
        if stage == self.stage and self.timer is None:
            self.timer = threading.Timer(self.delay, self.ask)
            self.timer.start()

    def ask(self) -> None:
        """Cancel now."""
        self.moment = time.perf_counter()
        self.cancel.set()


def growth(mesh, name: str, sizes: list[int]) -> None:
    """Seconds of one preset on ever larger parts of the scan, then on the scan cut finer."""
    print(f"\n{name}: growth with the number of raw faces")
    for n_faces in sizes:
        part = in_size(mesh, n_faces)
        seconds, result = timed(Pipeline(part).run, PRESETS[name])
        slow = sorted(result.timings.items(), key=lambda item: -item[1])[:3]
        print(f"  {part.n_faces:9} faces {seconds:7.2f} s  {result.n_segments:4} segments   "
              + ", ".join(f"{stage} {s:.2f}" for stage, s in slow), flush=True)  # fmt: skip


def growth_of_items(mesh, name: str, sizes: list[int]) -> None:
    """Seconds of one preset on one scan, with ever more items."""
    print(f"\n{name}: growth with the number of items")
    for n_items in sizes:
        params = PRESETS[name].replace(n_items=n_items)
        if 4e-9 * n_items**2 * len(params.convex_weights) > MOST_GIGABYTES:
            print(f"  {n_items:9} items   left out: its distances take more than {MOST_GIGABYTES:g} GB")
            continue
        seconds, result = timed(Pipeline(mesh).run, params)
        slow = sorted(result.timings.items(), key=lambda item: -item[1])[:3]
        print(f"  {result.items.n:9} items {seconds:7.2f} s  {result.n_segments:4} segments   "
              + ", ".join(f"{stage} {s:.2f}" for stage, s in slow), flush=True)  # fmt: skip


def main() -> None:
    """Run one part, or each in a process of its own so that peak memory is its own."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    add_scan_option(parser)
    parser.add_argument("--part", choices=["stages", "cancel", "growth"])
    parser.add_argument("--preset", choices=list(PRESETS))
    parser.add_argument(
        "--faces", type=int, nargs="+", default=[100_000, 300_000, 1_000_000, 2_000_000, 3_000_000]
    )
    parser.add_argument("--items", type=int, nargs="+", default=[2_000, 5_000, 10_000, 20_000, 30_000])
    arguments = parser.parse_args()
    if arguments.part is None or arguments.preset is None:
        for part in [arguments.part] if arguments.part else ["stages", "cancel", "growth"]:
            for preset in [arguments.preset] if arguments.preset else PRESETS:
                command = [
                    sys.executable,
                    __file__,
                    "--scan",
                    arguments.scan,
                    "--part",
                    part,
                    "--preset",
                    preset,
                ]
                sizes = ["--faces", *map(str, arguments.faces), "--items", *map(str, arguments.items)]
                subprocess.run([*map(str, command), *sizes], check=True)
        return
    warnings.simplefilter("ignore")
    warm_up()
    mesh = read_scan(arguments.scan)
    if arguments.part == "stages":
        stage_seconds(mesh, arguments.preset)
    elif arguments.part == "cancel":
        cancel_latency(mesh, arguments.preset)
    else:
        growth(mesh, arguments.preset, arguments.faces)
        growth_of_items(mesh, arguments.preset, arguments.items)


if __name__ == "__main__":
    main()
