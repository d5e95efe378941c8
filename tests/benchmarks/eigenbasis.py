"""Eigenpairs of the cotangent Laplacian: ours against scipy's default shift-invert, same matrices.

python tests/benchmarks/eigenbasis.py --vertices 5000 20000 50000 --pairs 50
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from scipy.sparse.linalg import eigsh

sys.path.insert(0, str(Path(__file__).parents[1]))

import shapes

from scenewidget.engine.mesh import Mesh
from scenewidget.engine.operators import cotangent_laplacian, eigenbasis


def bumpy_sheet(n_vertices: int) -> Mesh:
    """A square of about so many vertices with noise of a third of its grid step, like a scan."""
    n = round(n_vertices**0.5) - 1
    square = shapes.grid_square(n)
    noise = np.random.default_rng(0).normal(scale=0.3 / n, size=square.vertices.shape)
    return Mesh(square.vertices + noise * [0.5, 0.5, 1.0], square.faces)


def bumpy_torus(n_vertices: int) -> Mesh:
    """A closed surface of about so many vertices."""
    n = round((n_vertices / 2) ** 0.5)
    torus = shapes.torus(n_major=2 * n, n_minor=n)
    noise = np.random.default_rng(0).normal(scale=0.3 / n, size=torus.vertices.shape)
    return Mesh(torus.vertices + noise * 0.5, torus.faces)


def subdivided_sphere(n_vertices: int) -> Mesh:
    """Sphere of at most so many vertices in the order of subdivision, which misleads minimum degree."""
    n_subdivisions = int(np.log((n_vertices - 2) / 10) / np.log(4))
    return shapes.icosphere(n_subdivisions)


def main() -> None:
    """Time both on growing meshes and print how far their eigenvalues differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vertices", type=int, nargs="+", default=[5_000, 20_000, 50_000])
    parser.add_argument("--pairs", type=int, default=50)
    parser.add_argument("--skip-default", action="store_true", help="ours only")
    arguments = parser.parse_args()

    print(f"{arguments.pairs} pairs")
    print("surface              vertices   ours s   scipy s   ratio   largest relative difference")
    for n_vertices in arguments.vertices:
        for make in (bumpy_sheet, bumpy_torus, subdivided_sphere):
            mesh = make(n_vertices)
            start = time.perf_counter()
            basis = eigenbasis(mesh, arguments.pairs)
            ours = time.perf_counter() - start
            line = f"{make.__name__:18} {mesh.n_vertices:10} {ours:8.2f}"
            if not arguments.skip_default:
                W, A = cotangent_laplacian(mesh)
                shift = 1e-8 * np.median(W.diagonal() / A.diagonal())
                start = time.perf_counter()
                values = np.sort(eigsh(W, arguments.pairs, M=A, sigma=-shift, return_eigenvectors=True)[0])
                default = time.perf_counter() - start
                difference = np.abs(values[1:] / basis.values[1:] - 1).max()
                line += f" {default:9.2f} {default / ours:7.1f}   {difference:.1e}"
            print(line, flush=True)


if __name__ == "__main__":
    main()
