"""Eigenfunctions as vibrations: the surface swings along its normals, as a drum skin does."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from scenewidget.engine.mesh import Mesh
from scenewidget.figures.orbit import Figure

__all__ = ["vibration"]


def vibration(
    mesh: Mesh,
    eigenfunction: npt.ArrayLike,
    *,
    amplitude: float | None = None,
    title: str = "",
    **options: Any,
) -> Figure:
    """A mesh that swings: each point moves along its normal by the eigenfunction there, to and fro.

    Parameters
    ----------
    mesh : Mesh
    eigenfunction : (n_vertices,) or (n_vertices, k) float
        With k columns, a slider chooses the column.
    amplitude : float, optional
        Largest displacement in metres; a twelfth of the diagonal by default.
    title : str
    **options
        Of `show`: view, width, height, isolines, edges …

    Returns
    -------
    Figure
    """
    raise NotImplementedError
