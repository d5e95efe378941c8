"""Pictures that turn without a kernel, in the place of the notebooks' widgets.

Each is a page that `SceneView.to_html` writes: turning, walking, colours and the list work in it, computing doesn't.
"""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

import scenewidget as sw
from book.staging import NOTEBOOKS, widgets_of
from scenewidget.datasets.analytic import part_of
from scenewidget.engine.preprocess import simplify

__all__ = ["VIEWS", "missing", "write"]


@cache
def _room() -> tuple[sw.Mesh, sw.Segmentation, sw.Segmentation]:
    mesh, truth = sw.datasets.load_room()
    return mesh, truth, sw.segment(mesh)


def segmented_room() -> sw.SceneView:
    """The room with its segments."""
    mesh, _, seg = _room()
    return _segmented(mesh, seg)


def corrected_room() -> sw.SceneView:
    """The same after forty corrections of a simulated annotator."""
    mesh, truth, seg = _room()
    session = sw.Session(mesh, seg)
    for edit in sw.editing.simulate_annotator(seg, truth, target=0.0, most=40).edits:
        session.do(edit)
    return _segmented(mesh, session.segmentation)


def living_room() -> sw.SceneView:
    """The living room with its segments."""
    mesh, _ = sw.datasets.simulate_room(seed=11, n_objects=7, voxel=0.045)
    return _segmented(mesh, sw.segment(mesh))


def ring() -> sw.SceneView:
    """What the explorer shows first: an eigenfunction of its ring."""
    return _explored(sw.SpectralExplorer(k=100))


def table() -> sw.SceneView:
    """Heat that has spread on the scanned table."""
    mesh, truth, _ = _room()
    part = part_of(mesh, truth.labels == truth.names.index("table 1"))
    explorer = sw.SpectralExplorer(simplify(part, n_faces=4_000).mesh)
    explorer.mode = "heat"
    return _explored(explorer)


def _segmented(mesh: sw.Mesh, seg: sw.Segmentation) -> sw.SceneView:
    view = sw.SceneView(mesh)
    names = {segment: name for segment, name in enumerate(seg.names) if name}
    view.set_segments(seg.labels, levels=seg.levels, names=names, confidence=seg.confidence)
    return view


def _explored(explorer: sw.SpectralExplorer) -> sw.SceneView:
    values = explorer.values[explorer.mesh.faces].mean(axis=1)  # a face shows one
    scale = explorer.figure.drawings[0].scale
    view = sw.SceneView(sw.Mesh(explorer.vertices, explorer.mesh.faces))
    view.set_values(values, title=scale.title, colormap=scale.colormap, low=scale.low, high=scale.high)
    view.back_faces = True
    return view


VIEWS: dict[str, list[Callable[[], sw.SceneView]]] = {  # notebook -> its widgets, in their order
    "01_segment_a_room": [segmented_room],
    "04_the_spectrum": [ring],
    "05_signatures": [table],
    "09_annotate_a_scan": [segmented_room, corrected_room],
    "17_from_file_to_project": [living_room],
}


def missing() -> list[str]:
    """Widgets of notebooks that have no view here."""
    found = []
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        n = len(widgets_of(json.loads(path.read_text(encoding="utf-8"))))
        if n != len(VIEWS.get(path.stem, [])):
            found.append(f"{path.name} shows {n} widgets, VIEWS has {len(VIEWS.get(path.stem, []))} of them")
    return found


def write(folder: Path, *, kept: Path) -> None:
    """Write all views into a folder; those in ``kept``, of an earlier build, aren't computed again."""
    folder.mkdir()
    kept.mkdir(exist_ok=True)
    for stem, makers in VIEWS.items():
        for n, make in enumerate(makers):
            path = kept / f"{make.__name__}.html"
            if not path.exists():
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    view = make()
                view.to_html(path, title=(make.__doc__ or "").rstrip("."))
                view.close()
            shutil.copy(path, folder / f"{stem}-{n}.html")
