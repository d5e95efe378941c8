"""Are rooms that lie apart, or wall to wall, segmented as each would be alone?

    python tests/benchmarks/extent.py [--pairs 3]

Pairs of simulated rooms in one mesh: ten metres apart, with a wall of 10 and 20 cm between, and with a
doorway in one of 15 cm. Columns: 1 − RI of each room alone and in the pair, and the segments that have more
than a thousandth of either room's faces in both; through the doorway the floor may be one.
"""

from __future__ import annotations

import argparse
import warnings

import numpy as np

import scenewidget as sw
from scenewidget.datasets import SCANNERS, simulate_room
from scenewidget.metrics import rand_index_error

KINDS = ("depth camera", "lidar", "depth camera", "hasty")
LAYOUTS = ((10.0, False), (0.1, False), (0.2, False), (0.15, True))  # metres between; whether with a doorway
DOOR = (0.9, 2.05)  # width and height, metres

Room = tuple[sw.Mesh, np.ndarray, np.ndarray]  # walls along x and y from 0 on, truth, width and depth


def room(seed: int, kind: str) -> Room:
    """A simulated room, turned and moved so that walls begin at x = 0 and y = 0, and the floor lies at 0."""
    options = {**SCANNERS[kind], "seed": seed, "shape": "rectangle", "n_objects": 12, "voxel": 0.025}
    mesh, truth = simulate_room(**options)
    is_wall = np.isin(truth.labels, [i for i, name in enumerate(truth.names) if "wall" in name])
    flat = mesh.face_vectors[is_wall, :2] @ [1, 1j]
    turn = np.exp(-1j * np.angle((np.abs(flat) * (flat / np.abs(flat)) ** 4).sum()) / 4)
    plan = mesh.vertices[:, :2] @ [1, 1j] * turn
    vertices = np.stack([plan.real, plan.imag, mesh.vertices[:, 2]], axis=1)
    low, high = np.percentile(vertices[mesh.faces[is_wall]].mean(axis=1), [0.5, 99.5], axis=0)
    floor = truth.labels == next(i for i, name in enumerate(truth.names) if name.startswith("floor"))
    low[2] = np.median(vertices[mesh.faces[floor]][..., 2])
    return sw.Mesh(vertices - low, mesh.faces, mesh.vertex_colors), truth.labels.astype(int), (high - low)[:2]


def beside(one: Room, other: Room, gap: float, has_door: bool) -> tuple[sw.Mesh, np.ndarray, np.ndarray]:
    """Both in a mesh; the truth of the faces, and which room they are of, −1 for the sill of the door."""
    (a, truth_a, size), (b, truth_b, _) = one, other
    vertices = np.concatenate([a.vertices, b.vertices + np.array([size[0] + gap, 0, 0])])
    faces = np.concatenate([a.faces, b.faces + a.n_vertices])
    colors = np.concatenate([a.vertex_colors, b.vertex_colors])
    truth = np.concatenate([truth_a, np.where(truth_b >= 0, truth_b + truth_a.max() + 1, -1)])
    home = np.repeat([0, 1], [a.n_faces, b.n_faces])
    if not has_door:
        return sw.Mesh(vertices, faces, colors), truth, home
    middle = np.array([size[0] + gap / 2, min(size[1], other[2][1]) / 2, 0.0])
    at = vertices[faces].mean(axis=1) - middle
    opens = (np.abs(at[:, 0]) < gap / 2 + 0.15) & (np.abs(at[:, 1]) < DOOR[0] / 2)
    keep = ~(opens & (at[:, 2] > 0.03) & (at[:, 2] < DOOR[1]))
    n, m = int(gap / 0.025) + 2, 37
    x, y = np.meshgrid(np.linspace(-0.02, gap + 0.02, n) - gap / 2, np.linspace(-0.5, 0.5, m) * DOOR[0])
    sill = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1) + middle
    corner = (np.arange(m - 1)[:, None] * n + np.arange(n - 1)).ravel() + len(vertices)
    cells = np.stack([corner, corner + 1, corner + n, corner + n, corner + 1, corner + n + 1], axis=1)
    cells = cells.reshape(-1, 3)
    floor = colors[faces[np.argmin(np.abs(at).sum(axis=1)), 0]]
    mesh = sw.Mesh(
        np.concatenate([vertices, sill]),
        np.concatenate([faces[keep], cells]),
        np.concatenate([colors, np.repeat(floor[None], len(sill), axis=0)]),
    )
    return mesh, *(np.append(values[keep], np.full(len(cells), -1)) for values in (truth, home))


def error(labels: np.ndarray, truth: np.ndarray) -> float:
    """1 − RI over what both label."""
    keep = (labels >= 0) & (truth >= 0)
    return rand_index_error(labels[keep], truth[keep])


def main() -> None:
    """Print a line a pair and layout."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pairs", type=int, default=3)
    n_pairs = parser.parse_args().pairs
    warnings.simplefilter("ignore")
    pairs = []
    for i in range(n_pairs):
        both = [room(301 + 2 * i + k, KINDS[i % len(KINDS)]) for k in range(2)]
        pairs.append((both, [error(sw.segment(mesh).labels, truth) for mesh, truth, _ in both]))
    for gap, has_door in LAYOUTS:
        more = []
        for i, (both, alone) in enumerate(pairs):
            mesh, truth, home = beside(*both, gap, has_door)
            labels = sw.segment(mesh).labels
            together = [error(labels[home == k], truth[home == k]) for k in range(2)]
            counts = np.array(
                [
                    np.bincount(labels[(home == k) & (labels >= 0)], minlength=labels.max() + 1)
                    for k in range(2)
                ]
            )
            n_shared = int((counts > 1e-3 * np.bincount(home[home >= 0])[:, None]).all(axis=0).sum())
            rows = ", ".join(f"{a:.4f} → {t:.4f}" for a, t in zip(alone, together))
            print(
                f"{gap:4} m{' with a door' * has_door}, {KINDS[i % 4]}: {rows}, {n_shared} shared", flush=True
            )
            more += [t - a for a, t in zip(alone, together)]
        print(f"   at most {max(map(abs, more)):.4f} off, in the mean {np.mean(more):+.4f}")


if __name__ == "__main__":
    main()
