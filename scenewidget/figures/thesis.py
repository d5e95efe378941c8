"""Figures 3.3, 4.4 and 5.1 of the thesis, on any scan.

Goes in: a mesh. Come out: pictures side by side that the thesis argues with. Küçükdemir (2020).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.engine.dihedral import dihedral_partition
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.engine.preprocess import simplify
from scenewidget.figures.orbit import Figure
from scenewidget.figures.views import show, side_by_side

__all__ = ["COSTS", "FEATURES", "dihedral_partitions", "features_and_costs", "raw_and_simplified"]

COSTS: dict[str, dict[str, float]] = {  # Eqs. 4.1 and 4.2
    "f1": {"cost_a": 1.0, "cost_b": 0.0, "cost_exponent": 1.0},
    "f2": {"cost_a": 1.0, "cost_b": -1.0, "cost_exponent": 1.5},
}
FEATURES = {"δ_uni": "uniform", "δ_cot": "cotangent", "GPS": "gps"}
VIEW = -60.0, 30.0  # as `show` has it
PARTS_SHOWN = 200_000  # faces of a raw mesh that are drawn: a simplified picture would hide the point


def dihedral_partitions(
    mesh: Mesh, *, n_items: int = 10_000, n_slots: int = 64, view: tuple[float, float] = VIEW
) -> Figure:
    """Figure 3.3: a simplified scan and its dihedral partitions, with their number.

    Parameters
    ----------
    mesh : Mesh
        As loaded; it is simplified first, as in the thesis.
    n_items : int
        Faces to simplify to.
    n_slots : int
        D of Algorithm 1.
    view : (azimuth, elevation)
        Degrees; see `show`.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> sw.figures.dihedral_partitions(analytic.sphere(2))
    Figure(2 panels)
    """
    small = simplify(mesh, n_faces=n_items).mesh
    partition = dihedral_partition(small, n_slots)
    scan = show(small, title=f"{small.n_faces} faces", view=view)
    return side_by_side([scan, show(small, partition, title=_parts(partition), view=view)])


def raw_and_simplified(
    mesh: Mesh, *, n_items: int = 10_000, n_slots: int = 64, view: tuple[float, float] = VIEW
) -> Figure:
    """Figure 5.1: dihedral partitions of the scan as loaded beside those of the simplified one.

    Parameters
    ----------
    mesh : Mesh
    n_items : int
        Faces to simplify to.
    n_slots : int
        D of Algorithm 1.
    view : (azimuth, elevation)
        Degrees; see `show`.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> sw.figures.raw_and_simplified(analytic.sphere(3), n_items=200)
    Figure(2 panels)
    """
    small = simplify(mesh, n_faces=n_items).mesh
    panels = []
    for name, surface in (("raw", mesh), ("simplified", small)):
        partition = dihedral_partition(surface, n_slots)
        panels.append(
            show(surface, partition, title=f"{name}: {_parts(partition)}", view=view, max_faces=PARTS_SHOWN)
        )
    return side_by_side(panels)


def features_and_costs(
    mesh: Mesh,
    params: Params | None = None,
    *,
    pipeline: Pipeline | None = None,
    view: tuple[float, float] = VIEW,
) -> Figure:
    """Figure 4.4: segmentations by each of three features, with f1 and with f2.

    Parameters
    ----------
    mesh : Mesh
    params : Params, optional
        `Params.thesis()` by default; feature and cost are those of the panel.
    pipeline : Pipeline, optional
        Of this mesh, where there is one: it remembers what the panels share.
    view : (azimuth, elevation)
        Degrees; see `show`.

    Examples
    --------
    >>> import scenewidget as sw
    >>> room, truth = sw.datasets.load_room()
    >>> small = sw.Params.thesis(n_segments=8, n_items=400, n_runs=3, consensus="linkage")
    >>> sw.figures.features_and_costs(room, small)
    Figure(6 panels)
    """
    params = Params.thesis() if params is None else params
    pipe = Pipeline(mesh) if pipeline is None else pipeline
    panels = []
    for feature_name, feature in FEATURES.items():
        for cost_name, cost in COSTS.items():
            found = pipe.run(params.replace(feature=feature, **cost))
            title = f"{feature_name}, {cost_name}: {found.n_segments} segments"
            panels.append(show(mesh, found.labels, title=title, view=view))
    return side_by_side(panels, width=280, height=240)


def _parts(partition: Any) -> str:
    return f"{len(np.unique(partition))} partitions"
