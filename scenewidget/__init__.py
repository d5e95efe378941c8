"""Cut indoor 3D scans into meaningful pieces without training, and correct them by hand in a notebook.

A first look::

    import scenewidget as sw

    mesh, truth = sw.datasets.load_room()     # a small simulated scan and its truth
    seg = sw.segment(mesh)                    # Segmentation: seg.labels, seg.confidence, seg.to_frame()
    w = sw.SceneWidget(mesh)                  # the same in 3D, with sliders, in a notebook

What is where; ``help(sw.segment)`` and so on tell the rest:

======================================  =================================================================
``load_mesh``, ``Mesh``, ``MeshError``  a scan from PLY, OBJ, GLB, STL, OFF or arrays
``load_cloud``, ``PointCloud``          points from PCD, PLY, LAS, LAZ, E57, XYZ, PTS, CSV or an array
``load``                                a mesh or a cloud, by what the file holds
``save_mesh``                           a scan as PLY, OBJ, GLB, STL, OFF
``datasets``                            simulated scans with their truth, and readers of real ones
``segment``, ``Params``                 the method in one call, and everything that can be set about it
``Segmentation``                        its result: labels, confidence, levels, names, a table
``Pipeline``, ``Cancelled``             the same with a memory of its stages, for sliders and experiments
``engine``                              the stages themselves, one module each
``Session``, ``editing``                merging, splitting, cutting, naming, undo, project files
``export``, ``import_labels``           files that other programs read, out and in again
``evaluate``, ``metrics``               comparison with a truth
``agreement``, ``consensus``            what several people say of one scan: how far they agree, and on what
``segment_all``                         many scans at once, on all cores or a Dask cluster
``baselines``                           methods of others, to compare with
``SceneWidget``, ``SceneView``          the widget, and its picture alone
``Compare``                             segmentations of a scan beside each other
``Rooms``                               a scan of many rooms, looked at coarsely, edited room by room
``Workbench``                           a queue of segmented scans to correct, for several people
``figures``, ``SpectralExplorer``       pictures that teach
``exercises``                           answers to the questions of the course, checked
======================================  =================================================================

The folder ``notebooks`` of the repository is a course. ``__version__`` is the version.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenewidget import baselines, datasets, editing, engine, exercises, figures, metrics
    from scenewidget.batch.runs import segment_all
    from scenewidget.editing.formats import export, import_labels
    from scenewidget.editing.formats.scan import save_mesh
    from scenewidget.editing.session import Session
    from scenewidget.engine.clouds import PointCloud
    from scenewidget.engine.mesh import Mesh, MeshError
    from scenewidget.engine.monitor import Cancelled
    from scenewidget.engine.params import Params
    from scenewidget.engine.pipeline import Pipeline, segment
    from scenewidget.engine.readers import load, load_cloud, load_mesh
    from scenewidget.engine.segmentation import Segmentation
    from scenewidget.evaluation import evaluate
    from scenewidget.figures.spectral_explorer import SpectralExplorer
    from scenewidget.hands import agreement, consensus
    from scenewidget.widget.compare import Compare
    from scenewidget.widget.rooms_widget import Rooms
    from scenewidget.widget.scene_view import SceneView
    from scenewidget.widget.scene_widget import SceneWidget
    from scenewidget.widget.workbench import Workbench

_HOME = {  # public name -> module that defines it; resolved on first use, so that importing stays fast
    "Mesh": "engine.mesh",
    "MeshError": "engine.mesh",
    "load_mesh": "engine.readers",
    "load_cloud": "engine.readers",
    "load": "engine.readers",
    "PointCloud": "engine.clouds",
    "Segmentation": "engine.segmentation",
    "Session": "editing.session",
    "export": "editing.formats",
    "import_labels": "editing.formats",
    "save_mesh": "editing.formats.scan",
    "Cancelled": "engine.monitor",
    "evaluate": "evaluation",
    "agreement": "hands",
    "consensus": "hands",
    "Params": "engine.params",
    "Pipeline": "engine.pipeline",
    "segment": "engine.pipeline",
    "segment_all": "batch.runs",
    "Compare": "widget.compare",
    "Rooms": "widget.rooms_widget",
    "SceneView": "widget.scene_view",
    "SceneWidget": "widget.scene_widget",
    "Workbench": "widget.workbench",
    "SpectralExplorer": "figures.spectral_explorer",
}
_MODULES = ("baselines", "datasets", "editing", "engine", "exercises", "figures", "metrics")

__all__ = [
    "Cancelled",
    "Compare",
    "Mesh",
    "MeshError",
    "Params",
    "Pipeline",
    "PointCloud",
    "Rooms",
    "SceneView",
    "SceneWidget",
    "Segmentation",
    "Session",
    "SpectralExplorer",
    "Workbench",
    "__version__",
    "agreement",
    "baselines",
    "consensus",
    "datasets",
    "editing",
    "engine",
    "evaluate",
    "exercises",
    "export",
    "figures",
    "import_labels",
    "load",
    "load_cloud",
    "load_mesh",
    "metrics",
    "save_mesh",
    "segment",
    "segment_all",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("scenewidget")
    if name in _HOME:
        return getattr(importlib.import_module(f"scenewidget.{_HOME[name]}"), name)
    if name in _MODULES:
        return importlib.import_module(f"scenewidget.{name}")
    raise AttributeError(f"module 'scenewidget' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
