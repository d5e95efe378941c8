"""Raw scans for the benchmarks: a file if there is one, a simulated room if not, in any size."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from scenewidget.engine.mesh import Mesh, face_adjacency
from scenewidget.engine.preprocess import simplify
from scenewidget.engine.readers import load_mesh

DATA = Path(__file__).parents[3] / "shared" / "data"


def add_scan_option(parser: argparse.ArgumentParser) -> None:
    """``--scan``: a file; by default a bedroom beside the repository, else a simulated room."""
    parser.add_argument("--scan", type=Path, default=DATA / "bedroom_noisy.ply", help="mesh file")


def read_scan(path: Path) -> Mesh:
    """The scan, and a line that says what it is."""
    if path.exists():
        mesh = load_mesh(path)
        print(f"scan: {path.name}, {mesh.n_faces} faces")
        return mesh
    from scenewidget import datasets

    print(f"{path.name} is not there; simulating a room instead", flush=True)
    start = time.perf_counter()
    mesh, _ = datasets.simulate_room(seed=0, voxel=0.01)
    print(f"scan: simulated room, {mesh.n_faces} faces, made in {time.perf_counter() - start:.0f} s")
    return mesh


def in_size(mesh: Mesh, n_faces: int) -> Mesh:
    """A part of the scan with about so many faces, each cut in four where the scan has too few."""
    if n_faces > mesh.n_faces:
        return subdivided(in_size(mesh, n_faces // 4))
    place = mesh.face_centroids[:, 0]
    faces = mesh.faces[np.argsort(place, kind="stable")[:n_faces]]
    used, compact = np.unique(faces, return_inverse=True)
    return Mesh(mesh.vertices[used], compact.reshape(-1, 3))


def subdivided(mesh: Mesh) -> Mesh:
    """Each face cut in four at the midpoints of its edges."""
    a, b, c = mesh.faces.T.astype(np.int64)
    ends = np.sort(np.concatenate([np.stack(pair, axis=1) for pair in ((a, b), (b, c), (c, a))]), axis=1)
    edges, middle = np.unique(ends[:, 0] * mesh.n_vertices + ends[:, 1], return_inverse=True)
    first, second = edges // mesh.n_vertices, edges % mesh.n_vertices
    vertices = np.concatenate([mesh.vertices, 0.5 * (mesh.vertices[first] + mesh.vertices[second])])
    ab, bc, ca = (mesh.n_vertices + middle).reshape(3, -1)
    corners = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return Mesh(vertices, np.concatenate([np.stack(corner, axis=1) for corner in corners]))


def simplified(mesh: Mesh, n_faces: int) -> Mesh:
    """About so many faces, as the faithful preset clusters them."""
    return simplify(mesh, face_adjacency(mesh), n_faces=n_faces).mesh
