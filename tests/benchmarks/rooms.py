"""The scans that segment quality is measured on, in two halves: one to tune on, one to judge by.

Both development scans, one in each half, where they lie beside the repository, and simulated rooms: no two
share their layout, and they differ in style, shape, size, furniture, clutter, voxel, noise, holes, drift, and
how even the walls are. In "flat, inside out" the normals point out of the room.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import scenewidget as sw
from scenewidget.datasets import SCANNERS

__all__ = ["HALVES", "JUDGING", "TUNING", "Scan", "scans"]

DATA = Path(__file__).parents[3] / "shared" / "data"

# None: a file beside the repository
TUNING: dict[str, dict[str, Any] | None] = {
    "bedroom": None,
    "living room": {"seed": 11, "style": "living", "shape": "rectangle", "voxel": 0.017},
    "hasty bedroom": {
        "seed": 12, "style": "bedroom", "shape": "rectangle", "n_objects": 15, "voxel": 0.018,
        "noise": 0.009, "unseen": 0.65, "misregistration": 0.014, "warp": 0.03, "relief": 0.008,
    },
    "dining room, telephone": {
        "seed": 13, "style": "dining", "n_objects": 16, "voxel": 0.018, "noise": 0.003, "unseen": 0.2,
        "misregistration": 0.016, "smoothing": 0.07, "relief": 0.025, "warp": 0.08,
    },
    "crowded study": {
        "seed": 14, "style": "study", "shape": "L", "n_objects": 20, "clutter": 24, "voxel": 0.019,
        "noise": 0.004, "misregistration": 0.007,
    },
    "attic": {
        "seed": 16, "n_objects": 20, "clutter": 30, "voxel": 0.02, "noise": 0.004, "relief": 0.03,
        "misregistration": 0.014, "smoothing": 0.05, "warp": 0.05,
    },
    "clean living room": {
        "seed": 15, "style": "living", "n_objects": 14, "voxel": 0.021, **SCANNERS["clean"],
    },
}  # fmt: skip
JUDGING: dict[str, dict[str, Any] | None] = {
    "bedroom_noisy": None,
    "study": {"seed": 21, "style": "study", "shape": "rectangle", "voxel": 0.016},
    "hasty dining room": {
        "seed": 22, "style": "dining", "n_objects": 15, "voxel": 0.018, "noise": 0.01, "unseen": 0.7,
        "misregistration": 0.015, "warp": 0.03, "relief": 0.01,
    },
    "bedroom, telephone": {
        "seed": 23, "style": "bedroom", "n_objects": 14, "clutter": 16, "voxel": 0.017, "noise": 0.003,
        "unseen": 0.2, "misregistration": 0.02, "smoothing": 0.08, "relief": 0.03, "warp": 0.1,
    },
    "flat, inside out": {
        "seed": 24, "style": "living", "shape": "L", "n_objects": 20, "clutter": 14, "voxel": 0.02,
        "inside_out": True,
    },
    "old house": {
        "seed": 25, "size": (5.6, 4.2, 2.3), "n_objects": 15, "clutter": 16, "voxel": 0.021, "noise": 0.004,
        "relief": 0.02, "warp": 0.05, "misregistration": 0.012, "unseen": 0.3,
    },
    "cellar": {
        "seed": 32, "n_objects": 20, "clutter": 30, "voxel": 0.02, "noise": 0.004, "relief": 0.03,
        "misregistration": 0.015, "smoothing": 0.06, "warp": 0.06,
    },
    "clean dining room": {
        "seed": 26, "style": "dining", "n_objects": 14, "voxel": 0.021, **SCANNERS["clean"],
    },
}  # fmt: skip
HALVES = {"tuning": TUNING, "judging": JUDGING}


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan with its truth."""

    name: str
    half: str
    mesh: sw.Mesh
    truth: sw.Segmentation
    recipe: str  # what it was simulated with

    @property
    def is_inside_out(self) -> bool:
        """Whether the normals point out of the room."""
        return "inside_out" in self.recipe

    @property
    def is_clean(self) -> bool:
        """Whether it is like a CAD export."""
        return '"noise": 0.0,' in self.recipe

    @property
    def from_inside(self) -> sw.Mesh:
        """The mesh with normals that point into the room, the faces in the same order."""
        if not self.is_inside_out:
            return self.mesh
        return sw.Mesh(self.mesh.vertices, self.mesh.faces[:, ::-1], self.mesh.vertex_colors)


def scans(names: list[str] | None, halves: list[str], cache: Path) -> Iterator[Scan]:
    """Scan by scan; those that aren't there are left out with a word, simulated ones kept in ``cache``."""
    for half in halves:
        for name, options in HALVES[half].items():
            if names and name not in names:
                continue
            if options is None and not (DATA / f"{name}.ply").exists():
                print(f"{name}: not there, left out")
                continue
            mesh, truth = _read(name) if options is None else _simulate(name, options, cache)
            yield Scan(name, half, mesh, truth, json.dumps(options, sort_keys=True))


def _read(name: str) -> tuple[sw.Mesh, sw.Segmentation]:
    mesh = sw.load_mesh(DATA / f"{name}.ply")
    labels = np.load(DATA / f"{name}_instances.npy").astype(np.int64)
    names = json.loads((DATA / f"{name}_instances.json").read_text())
    return mesh, sw.Segmentation.from_labels(mesh, labels, names=list(names))


def _simulate(name: str, options: dict[str, Any], cache: Path) -> tuple[sw.Mesh, sw.Segmentation]:
    file = cache / "scans" / f"{name}.npz"
    recipe = json.dumps(options, sort_keys=True)
    if file.exists():
        kept = np.load(file)
        if str(kept["recipe"]) == recipe:
            mesh = sw.Mesh(kept["vertices"], kept["faces"], kept["colors"])
            return mesh, sw.Segmentation.from_labels(mesh, kept["labels"], names=kept["names"].tolist())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # not every room has a place for all that is asked for
        mesh, truth = sw.datasets.simulate_room(**options)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part.npz")
    np.savez_compressed(
        part, recipe=recipe, vertices=mesh.vertices, faces=mesh.faces, colors=mesh.vertex_colors,
        labels=truth.labels, names=np.array(truth.names),
    )  # fmt: skip
    part.replace(file)
    return mesh, truth
