"""The table of segments, a row each, for spreadsheets and data frames."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING

from scenewidget.editing.formats.seal import Contents
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.segmentation import Segmentation

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["as_text", "write_csv", "write_parquet"]


def write_csv(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """The table as CSV in UTF-8.

    A name that a spreadsheet would take for a formula (``=``, ``+``, ``-``, ``@`` first) gets an apostrophe.
    """
    frame = _frame(segmentation)
    frame["name"] = [as_text(name) for name in frame["name"]]
    return {path: [frame.to_csv(lineterminator="\n").encode(errors="replace")]}


def as_text(name: str) -> str:
    """A cell of a CSV that no spreadsheet takes for a formula.

    Examples
    --------
    >>> as_text("=1+1"), as_text("chair")
    ("'=1+1", 'chair')
    """
    return f"'{name}" if name[:1] in tuple("=+-@\t\r") else name


def write_parquet(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """The table as Parquet; needs pyarrow, which scenewidget does not install."""
    try:
        importlib.import_module("pyarrow")  # what pandas writes Parquet with
    except ImportError as error:
        raise ImportError("Parquet needs pyarrow: pip install pyarrow, or choose CSV") from error
    return {path: [_frame(segmentation).to_parquet(engine="pyarrow")]}


def _frame(segmentation: Segmentation) -> pd.DataFrame:
    """Its table with a column a number: centroid_x, normal_z."""
    frame = segmentation.to_frame()
    for name in ("centroid", "normal"):
        at = frame.columns.get_loc(name)
        values = frame.pop(name).tolist()
        for k, axis in enumerate("xyz"):
            frame.insert(at + k, f"{name}_{axis}", [row[k] for row in values])
    return frame
