"""How fast does the SpectralExplorer answer? Median and slowest of its knobs, at 10 000 faces.

python tests/benchmarks/explorer.py
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import shapes

from scenewidget.figures.spectral_explorer import SpectralExplorer

KNOBS = (
    ("eigenfunction", "index", range(10, 25)),
    ("low pass", "n_functions", range(30, 45)),
    ("heat", "time", np.geomspace(0.01, 0.1, 15)),
    ("signature", "time", np.geomspace(0.02, 0.2, 15)),
)


def main() -> None:
    """Turn each knob fifteen times."""
    explorer = SpectralExplorer(shapes.grid_square(70))
    print(f"{explorer.mesh.n_faces} faces\n{'':14}median   slowest, ms")
    for mode, name, values in KNOBS:
        explorer.mode = mode
        seconds = []
        for value in values:
            start = time.perf_counter()
            setattr(explorer, name, value)
            seconds.append(time.perf_counter() - start)
        print(f"{mode:14}{1e3 * np.median(seconds):6.0f}{1e3 * max(seconds):10.0f}")


if __name__ == "__main__":
    main()
