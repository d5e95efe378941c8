"""How much labels depend on the processor: the same computation with the kernels of several processors.

OpenBLAS chooses its kernels by the processor; they round differently in the last digit. The default preset
decides by normals and is the same everywhere; spectral features come from an eigensolver, where a last digit
can tip a close decision.

python tests/benchmarks/cpu_kernels.py --items 4000
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import scenewidget as sw

RUN = """
import sys, numpy as np, scenewidget as sw
mesh, _ = sw.datasets.load_room()
for feature in sys.argv[3:]:
    spectral = {"n_items": int(sys.argv[2]), "feature": feature}
    params = sw.Params() if feature == "default" else sw.Params.thesis(**spectral)
    np.save(f"{sys.argv[1]}/{feature}.npy", sw.segment(mesh, params).labels)
"""


def main() -> None:
    """Segment with each kernel in a process of its own and compare the labels with those of the first."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kernels", nargs="+", default=["Haswell", "Sandybridge", "Nehalem"])
    parser.add_argument("--features", nargs="+", default=["default", "cotangent", "gps", "hks", "wks"])
    parser.add_argument("--items", type=int, default=4_000)
    arguments = parser.parse_args()
    mesh, _ = sw.datasets.load_room()
    found: dict[str, dict[str, np.ndarray]] = {}
    begin = time.perf_counter()
    for kernel in arguments.kernels:
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-c", RUN, folder, str(arguments.items), *arguments.features]
            subprocess.run(command, check=True, env={**os.environ, "OPENBLAS_CORETYPE": kernel})
            found[kernel] = {f: np.load(Path(folder) / f"{f}.npy") for f in arguments.features}
    print(f"{'feature':10} " + " ".join(f"{kernel:>24}" for kernel in arguments.kernels))
    for feature in arguments.features:
        first = found[arguments.kernels[0]][feature]
        cells = []
        for kernel in arguments.kernels:
            labels = found[kernel][feature]
            error = sw.metrics.rand_index_error(first, labels, weights=mesh.face_areas)
            cells.append(f"{labels.max() + 1:4} segments, RIE {error:.5f}")
        print(f"{feature:10} " + " ".join(f"{cell:>24}" for cell in cells), flush=True)
    print(f"{time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
