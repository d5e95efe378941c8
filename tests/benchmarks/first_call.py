"""The first segmentation in a fresh process, compilation included, and later ones, on the shipped room.

python tests/benchmarks/first_call.py
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile

SCRIPT = """
import time, warnings
warnings.simplefilter("ignore")
start = time.perf_counter()
import scenewidget as sw
imported = time.perf_counter() - start
mesh, _ = sw.datasets.load_room()
params = sw.Params() if {preset!r} == "default" else sw.Params.thesis()
times = []
for _ in range(2):
    begin = time.perf_counter()
    sw.segment(mesh, params)
    times.append(time.perf_counter() - begin)
first, second = times
print(f"{{mesh.n_faces}} faces: import {{imported:.2f}} s, first {{first:.2f}} s, second {{second:.2f}} s")
"""


def main() -> None:
    """Run both presets, with an empty and with a filled cache of compiled code."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    for preset in ("default", "thesis"):
        with tempfile.TemporaryDirectory() as cache:
            for state in ("nothing compiled yet", "compiled before"):
                environment = os.environ | {"NUMBA_CACHE_DIR": cache}
                command = [sys.executable, "-c", SCRIPT.format(preset=preset)]
                done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
                print(f"{preset}, {state}: {done.stdout.strip()}", flush=True)


if __name__ == "__main__":
    main()
