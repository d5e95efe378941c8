"""A segmented room as people with each kind of colour blindness see it, and how far neighbours differ.

    python tests/benchmarks/color_blind.py pictures/

Simulated after Machado, Oliveira and Fernandes (2009), IEEE TVCG 15(6), full severity, in linear light.
"""

from __future__ import annotations

import argparse
import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1]))

from sights import SIGHTS, neighbour_difference, seen

import scenewidget as sw
from scenewidget.figures.drawing import draw
from scenewidget.figures.picture import png
from scenewidget.palette import label_rows, palette


def main() -> None:
    """Draw and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    mesh, truth = sw.datasets.load_room()
    picture = png([draw(mesh, labels=truth.labels)], view=(-60, 30), width=900, height=700)
    pixels = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"))
    colors = palette()[label_rows(mesh, truth.labels)]
    for name in SIGHTS:
        Image.fromarray(seen(pixels, name)).save(folder / f"{name}.png")
        difference = neighbour_difference(mesh, truth.labels, colors, name)
        print(f"{name}: neighbours differ by {difference:.3f} in Oklab at least")


if __name__ == "__main__":
    main()
