"""Dihedral-based partitioning from 100 000 to 3 million faces, ordinary surfaces and the worst one.

python tests/benchmarks/dihedral.py --faces 100000 300000 1000000 3000000
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import shapes

from scenewidget.engine.dihedral import dihedral_partition
from scenewidget.engine.mesh import Mesh, face_adjacency


def noisy_sheet(n_faces: int, noise: float) -> Mesh:
    """A square of about so many faces, its heights off by ``noise`` grid steps (standard deviation)."""
    n = round((n_faces / 2) ** 0.5)
    square = shapes.grid_square(n)
    heights = np.random.default_rng(0).normal(scale=noise / n, size=square.n_vertices)
    return Mesh(square.vertices + heights[:, None] * [0, 0, 1], square.faces)


def main() -> None:
    """Time a smooth sheet, a noisy one, and an accordion, where every face is tied in every ring."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faces", type=int, nargs="+", default=[100_000, 300_000, 1_000_000, 3_000_000])
    arguments = parser.parse_args()

    dihedral_partition(shapes.box())  # compile
    print("surface        faces   adjacency s   partition s   µs/face   partitions")
    for n_faces in arguments.faces:
        for name, mesh in (
            ("smooth", noisy_sheet(n_faces, 0.05)),
            ("noisy", noisy_sheet(n_faces, 0.5)),
            ("accordion", shapes.accordion(n_faces // 2)),
        ):
            start = time.perf_counter()
            face_adjacency(mesh)
            adjacency = time.perf_counter() - start
            start = time.perf_counter()
            partition = dihedral_partition(mesh)
            seconds = time.perf_counter() - start - adjacency  # it builds the adjacency itself
            print(
                f"{name:10} {mesh.n_faces:9} {adjacency:13.2f} {seconds:13.2f} "
                f"{1e6 * seconds / mesh.n_faces:9.2f} {partition.max() + 1:12}",
                flush=True,
            )


if __name__ == "__main__":
    main()
