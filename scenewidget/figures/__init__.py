"""Figures for teaching: meshes to turn around in a notebook cell, and charts where 2D says more.

Goes in: a mesh with labels, numbers or vectors on it; a basis, a co-association matrix. Comes out: something
that a cell shows as its last value. In a running notebook it can be turned with the mouse (left: turn,
right: move, wheel: zoom); where nothing runs, as on a code host, a picture of the first view stands in.

Everything is drawn as coloured triangles: arrows are needles, lines are ribbons. So the picture and what
the browser draws are the same thing.
"""

from __future__ import annotations

from scenewidget.figures.charts import Chart, coassociation, reliability, spectrum
from scenewidget.figures.drawing import Drawing
from scenewidget.figures.motion import vibration
from scenewidget.figures.orbit import Figure
from scenewidget.figures.progress import sweep
from scenewidget.figures.scale import ColorScale
from scenewidget.figures.thesis import dihedral_partitions, features_and_costs, raw_and_simplified
from scenewidget.figures.views import compare, show, side_by_side

__all__ = [
    "Chart",
    "ColorScale",
    "Drawing",
    "Figure",
    "coassociation",
    "compare",
    "dihedral_partitions",
    "features_and_costs",
    "raw_and_simplified",
    "reliability",
    "show",
    "side_by_side",
    "spectrum",
    "sweep",
    "vibration",
]
