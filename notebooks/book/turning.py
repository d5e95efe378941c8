"""Figures of the notebooks as pages that turn without a kernel.

Goes in: a notebook, which is run once for its figures. Comes out: a page for each, the same triangles in the
same colours, drawn by ``figure/figure.js``; the picture in the notebook stays until it can be drawn.
"""

from __future__ import annotations

import base64
import gzip
import html
import io
import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from book.staging import NOTEBOOKS, figures_of
from scenewidget.figures.drawing import Drawing
from scenewidget.figures.motion import Vibration
from scenewidget.figures.orbit import Figure
from scenewidget.figures.picture import camera_for, color_bar, png

__all__ = ["page", "write"]

FIGURE_FILES = Path(__file__).parent / "figure"
FINEST = 65535  # places are counted in so many steps along each side of what is drawn
GIVE_PAGES = """\
from book import turning
from scenewidget.figures.orbit import Figure
Figure._repr_mimebundle_ = lambda self, **_: {"text/plain": repr(self), "text/html": turning.page(self)}
"""
PAGE = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<link rel="stylesheet" href="figure.css">
{titles}
<div id="stage"><img src="data:image/png;base64,{still}" alt="{title}"></div>
{legends}{button}
<script type="application/json" id="figure">{saved}</script>
<script src="figure.js"></script>
"""


def page(figure: Figure) -> str:
    """A figure as a page; ``figure.js`` and ``figure.css`` have to lie beside it."""
    swings = isinstance(figure, Vibration)
    rest: Sequence[Drawing] = [figure.at_rest] if swings else figure.drawings
    arrays = _Arrays()
    panels: list[dict[str, Any]] = []
    for i, drawing in enumerate(rest):
        panel = {**_places(drawing, arrays), "colors": arrays.add(_shades(drawing)), "hides_back": drawing.hides_back}
        if swings:
            panel["swung"] = _places(figure.drawings[i], arrays)
        panels.append(panel)
    aspect = figure.width / figure.height
    camera = camera_for(figure.drawings, figure.view, aspect)
    place = {"azimuth": camera.azimuth, "elevation": camera.elevation}
    saved = {
        "panels": panels, "aspect": aspect, "seconds": figure.seconds if swings and isfinite(figure.seconds) else None,
        "camera": {**place, "distance": camera.distance, "target": camera.target}, **arrays.packed(),
    }  # fmt: skip
    titles = [html.escape(drawing.title) for drawing in figure.drawings]
    bare = [replace(drawing, title="", scale=None, note="") for drawing in figure.drawings]
    still = png(bare, view=figure.view, width=figure.width, height=figure.height)
    return PAGE.format(
        title=" · ".join(filter(None, titles)) or "A figure",
        titles=_row("titles", titles),
        still=base64.b64encode(still).decode(),
        legends=_row("legends", [_legend(drawing) for drawing in figure.drawings]),
        button='<button id="swing" type="button">Swing</button>' if swings else "",
        saved=json.dumps(saved, separators=(",", ":")).replace("<", "\\u003c"),
    )


def write(folder: Path, *, kept: Path) -> list[str]:
    """Write the figures of all notebooks into a folder; gives what is wrong.

    A notebook is run unless its pages of an earlier build, in ``kept``, are of the same file.
    """
    for path in FIGURE_FILES.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    found = []
    with ThreadPoolExecutor(2) as pool:  # each runs a kernel of its own
        paths = [path for path in sorted(NOTEBOOKS.glob("*.ipynb")) if figures_of(json.loads(path.read_text("utf-8")))]
        for path, pages in zip(paths, pool.map(lambda path: _pages(path, kept), paths), strict=True):
            n = len(figures_of(json.loads(path.read_text("utf-8"))))
            if len(pages) != n:
                found.append(f"{path.name} has {n} figures, and made {len(pages)} when it was run for the book")
            for i, text in enumerate(pages):
                (folder / f"{path.stem}-figure-{i}.html").write_text(text, encoding="utf-8")
    return found


def _pages(path: Path, kept: Path) -> list[str]:
    """Pages of a notebook's figures, of an earlier build where that is the same."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    version = sha256(path.read_bytes() + (GIVE_PAGES + PAGE).encode()).hexdigest()[:12]
    known = kept / f"{path.stem}-{version}.json"
    if not known.exists():
        notebook.cells.insert(0, nbformat.v4.new_code_cell(GIVE_PAGES))
        here = {"metadata": {"path": str(path.parent)}}
        options = {"timeout": 600, "kernel_name": "python3", "store_widget_state": False, "allow_errors": True}
        NotebookClient(notebook, resources=here, **options).execute()
        found = [
            output["data"]["text/html"]
            for output in figures_of(notebook)
            if "text/html" in output.get("data", {})
        ]
        kept.mkdir(exist_ok=True)
        known.write_text(json.dumps(found), encoding="utf-8")
    pages: list[str] = json.loads(known.read_text(encoding="utf-8"))
    return pages


class _Arrays:
    """Arrays that are stored once, however often they are used."""

    def __init__(self) -> None:
        self._numbers: dict[bytes, int] = {}
        self._arrays: list[np.ndarray[Any, Any]] = []

    def add(self, array: np.ndarray[Any, Any]) -> int:
        key = array.dtype.name.encode() + array.tobytes()
        if key not in self._numbers:
            self._numbers[key] = len(self._arrays)
            self._arrays.append(array.ravel())
        return self._numbers[key]

    def packed(self) -> dict[str, Any]:
        file, table = io.BytesIO(), []
        for array in self._arrays:
            file.write(bytes(-file.tell() % 4))
            table.append({"dtype": array.dtype.name, "offset": file.tell(), "length": array.size})
            file.write(array.tobytes())
        return {"arrays": table, "data": base64.b64encode(gzip.compress(file.getvalue(), 9, mtime=0)).decode()}


def _places(drawing: Drawing, arrays: _Arrays) -> dict[str, Any]:
    """Corners as rows of a table of vertices in whole steps."""
    corners = drawing.corners.reshape(-1, 3).astype(np.float64)
    low = corners.min(axis=0)
    step = np.maximum(np.ptp(corners, axis=0), 1e-12) / FINEST
    counted = np.round((corners - low) / step).astype(np.uint16)
    table, rows = np.unique(counted, axis=0, return_inverse=True)
    kind = np.uint16 if len(table) <= FINEST else np.uint32
    return {
        "vertices": arrays.add(table), "corners": arrays.add(rows.ravel().astype(kind)),
        "low": low.tolist(), "step": step.tolist(),
    }  # fmt: skip


def _shades(drawing: Drawing) -> np.ndarray[Any, Any]:
    """Colours of the corners, or one of each triangle where its corners are alike."""
    is_flat = (drawing.colors == drawing.colors[:, :1]).all()
    return np.ascontiguousarray(drawing.colors[:, 0] if is_flat else drawing.colors)


def _row(kind: str, cells: Sequence[str]) -> str:
    return f'<div class="row {kind}">{"".join(f"<div>{cell}</div>" for cell in cells)}</div>\n' if any(cells) else ""


def _legend(drawing: Drawing) -> str:
    parts = []
    if drawing.scale is not None:
        stops = ",".join("#{:02x}{:02x}{:02x}".format(*color) for color in color_bar(drawing.scale, 17))
        low, middle, high = drawing.scale.ticks()
        texts = "".join(f"<span>{html.escape(text)}</span>" for text in (low, drawing.scale.title or middle, high))
        parts += [f'<div class="bar" style="background:linear-gradient(to right,{stops})"></div>']
        parts += [f'<div class="ticks">{texts}</div>']
    if drawing.note:
        parts.append(f'<div class="note">{html.escape(drawing.note)}</div>')
    return "".join(parts)

