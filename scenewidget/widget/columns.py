"""Columns of the table of segments as numbers to colour by: how large, how flat, how high they are."""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import FloatArray
from scenewidget.engine.segmentation import Segmentation

__all__ = ["COLUMNS", "column_values"]

SIDES = ("length", "width", "height")  # of the upright box
COLUMNS = {
    "area": "Area (m²)",
    "faces": "Faces",
    "flatness": "Flatness (0 = a plane)",
    "confidence": "Mean confidence",
    "length": "Length of the box (m)",
    "width": "Width of the box (m)",
    "height": "Height of the box (m)",
}


def column_values(segmentation: Segmentation, name: str) -> FloatArray:
    """Values of a column of `Segmentation.to_frame`, or a side of the box that it tells.

    Parameters
    ----------
    segmentation : Segmentation
    name : str
        A key of `COLUMNS`.

    Returns
    -------
    values : (n_segments + 1,) float64
        The last is NaN, so that -1, unlabeled, takes it.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> column_values(seg, "area"), column_values(seg, "height")
    (array([0.5, 0.5, nan]), array([ 0.,  0., nan]))
    """
    table = segmentation.to_frame()
    if name in SIDES:
        values = np.array([size[SIDES.index(name)] for size in table["size"]], np.float64)
    else:
        values = table[name].to_numpy(np.float64)
    return np.append(values, np.nan)
