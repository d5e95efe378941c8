"""A segmented room as people with each kind of colour blindness see it, and how far neighbours differ.

    python tests/benchmarks/color_blind.py pictures/

Writes a picture of each and all four in one, `sights.jpg`, which stands in .github.
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
    sheet = Image.new("RGB", (1000, 778))
    for k, name in enumerate(SIGHTS):
        sight = Image.fromarray(seen(pixels, name))
        sight.save(folder / f"{name}.png")
        sheet.paste(sight.resize((500, 389)), (k % 2 * 500, k // 2 * 389))
        difference = neighbour_difference(mesh, truth.labels, colors, name)
        print(f"{name}: neighbours differ by {difference:.3f} in Oklab at least")
    sheet.save(folder / "sights.jpg", quality=80)


if __name__ == "__main__":
    main()
