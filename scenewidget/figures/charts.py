"""Charts where 2D says more: eigenvalues, co-association matrices, reliability."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure as MatplotlibFigure
from scipy import sparse

from scenewidget.engine.operators import Eigenbasis

__all__ = ["Chart", "coassociation", "reliability", "spectrum"]


class Chart(MatplotlibFigure):
    """A matplotlib figure that displays itself as a small PNG; ``chart.axes[0]`` is there to be changed.

    Examples
    --------
    >>> chart = spectrum([0.0, 1.0, 2.5])
    >>> chart
    Chart()
    >>> chart.axes[0].get_xlabel()
    'index i'
    """

    def __repr__(self) -> str:
        return "Chart()"

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        from base64 import b64encode

        file = io.BytesIO()
        self.savefig(file, format="png", dpi=80)
        return {"text/plain": repr(self), "image/png": b64encode(file.getvalue()).decode()}


def spectrum(
    basis: Eigenbasis | Mapping[str, Eigenbasis] | npt.ArrayLike,
    *,
    reference: npt.ArrayLike | None = None,
    title: str = "",
) -> Chart:
    """Eigenvalues in ascending order, as dots.

    Parameters
    ----------
    basis : Eigenbasis, mapping of name to Eigenbasis, or (k,) float
        Or eigenvalues as they are; several are drawn in one chart.
    reference : (k,) float, optional
        Closed-form values, drawn as rings.
    title : str

    Examples
    --------
    >>> spectrum([0.0, 1.0, 2.5], reference=[0.0, 1.0, 2.0], title="a drum")
    Chart()
    """
    given = basis if isinstance(basis, Mapping) else {"": basis}
    chart = Chart(figsize=(6.4, 3.2), layout="constrained")
    axes = chart.subplots()
    for i, (name, one) in enumerate(given.items()):
        values = np.asarray(getattr(one, "values", one), np.float64)
        for row in np.atleast_2d(values):
            axes.plot(np.arange(len(row)), row, "o", markersize=4, color=f"C{i}", label=name or None)
            name = ""
    if reference is not None:
        exact = np.asarray(reference, np.float64)
        axes.plot(
            np.arange(len(exact)), exact, "o", markersize=8, fillstyle="none", color="0.35",
            label="closed form",
        )  # fmt: skip
    axes.set(xlabel="index i", ylabel="eigenvalue λᵢ in 1/m²", title=title)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return chart


def coassociation(
    C: Any,
    labels: npt.ArrayLike | None = None,
    *,
    weights: npt.ArrayLike | None = None,
    title: str = "",
) -> Chart:
    """A co-association matrix as a picture, its rows sorted by label, borders of labels drawn in.

    Parameters
    ----------
    C : (n, n) float, or an object with such a matrix as ``C`` or ``matrix``; may be sparse
        Share of the clusterings that put i and j together, 0 to 1. Beyond 800 rows, every n-th is drawn.
    labels : (n,) int, optional
        Rows of one label come together, labels by size; -1 comes last.
    weights : (n,) float, optional
        Rows of one label are ordered by weight, and labels by their sum; by default all 1.
    title : str

    Examples
    --------
    >>> coassociation([[1.0, 0.5], [0.5, 1.0]], [0, 1])
    Chart()
    """
    matrix = getattr(C, "C", getattr(C, "matrix", C))
    matrix = np.asarray(matrix.toarray() if sparse.issparse(matrix) else matrix, np.float64)
    n = len(matrix)
    if matrix.shape != (n, n):
        raise ValueError(f"C must be a square matrix, got shape {matrix.shape}")
    names = np.zeros(n, np.int64) if labels is None else np.asarray(labels)
    heavy = np.ones(n) if weights is None else np.asarray(weights, np.float64)
    for what, array in (("labels", names), ("weights", heavy)):
        if array.shape != (n,):
            raise ValueError(f"{what} must have shape ({n},), one a row of C, got {array.shape}")
    used, compact = np.unique(names, return_inverse=True)
    total = np.where(used < 0, -1.0, np.bincount(compact, heavy))
    order = np.lexsort((np.arange(n), -heavy, compact, -total[compact]))
    order = order[np.linspace(0, n - 1, min(n, 800)).astype(np.intp)]

    chart = Chart(figsize=(5.2, 4.4), layout="constrained")
    axes = chart.subplots()
    image = axes.imshow(matrix[np.ix_(order, order)], cmap="magma", vmin=0, vmax=1, interpolation="nearest")
    borders = np.flatnonzero(np.diff(compact[order])) + 0.5
    if labels is not None:
        axes.hlines(borders, -0.5, len(order) - 0.5, color="white", linewidth=0.4, alpha=0.7)
        axes.vlines(borders, -0.5, len(order) - 0.5, color="white", linewidth=0.4, alpha=0.7)
    axes.set(xticks=[], yticks=[], title=title)
    axes.set_xlabel(f"{n} items" + ("" if labels is None else ", sorted by label"))
    chart.colorbar(image, ax=axes, label="share of clusterings that join them")
    return chart


def reliability(table: Any, *, title: str = "") -> Chart:
    """How far the confidence can be trusted: a dot a bin, on the diagonal where it is right.

    Parameters
    ----------
    table : pandas.DataFrame, or mapping of name to such a table
        As `scenewidget.evaluation.reliability` returns it; several are drawn in one chart. Bars show the
        share of the faces in each bin of the first.
    title : str

    Examples
    --------
    >>> import pandas as pd
    >>> table = pd.DataFrame({"confidence": [0.5, 0.9], "right": [0.4, 0.9], "share": [0.3, 0.7]})
    >>> reliability(table)
    Chart()
    """
    given = dict(table) if isinstance(table, dict) else {"": table}
    chart = Chart(figsize=(5.2, 4.4), layout="constrained")
    axes = chart.subplots()
    axes.plot([0, 1], [0, 1], color="0.6", linewidth=1, linestyle="--")
    for i, (name, rows) in enumerate(given.items()):
        confidence, right, share = (
            np.asarray(rows[key], np.float64) for key in ("confidence", "right", "share")
        )
        error = float((share * np.abs(confidence - right)).sum())
        label = f"{name}: " if name else ""
        label += f"off by {error:.3f} on average"
        if i == 0:
            axes.bar(confidence, share, width=0.04, color="0.85", label="share of the faces")
        axes.plot(confidence, right, "o-", markersize=5, color=f"C{i}", label=label)
    axes.set(
        xlim=(0, 1),
        ylim=(0, 1),
        xlabel="confidence",
        ylabel="share of faces that are right",
        title=title,
    )
    axes.legend(frameon=False, loc="upper left")
    axes.spines[["top", "right"]].set_visible(False)
    return chart
