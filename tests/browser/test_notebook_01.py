"""Notebook 01 as a reader goes through it: run it, look at the room, move a slider."""

from pathlib import Path

import numpy as np

NOTEBOOK = Path(__file__).parent.parent.parent / "notebooks" / "01_segment_a_room.ipynb"


def colours(pixels: np.ndarray) -> int:
    """How many different colours there are, each on a hundredth of the picture at least."""
    coarse = (pixels[60:-40] // 32).reshape(-1, 3).astype(int) @ [64, 8, 1]
    return int((np.bincount(coarse) > coarse.size / 100).sum())


def test_notebook_01_segments_the_room(notebook):
    book = notebook(NOTEBOOK, height=1000)
    book.run_all()
    view = book.view()
    view.page.wait_for_function(
        """() => [...window.jupyterapp.shell.currentWidget.context.model.cells]
            .filter(cell => cell.type === 'code').every(cell => cell.executionCount !== null)""",
    )
    assert book.evaluate("type(w.segmentation).__name__") == "'Segmentation'"
    n_segments = int(book.evaluate("w.wait().n_segments"))
    view.wait("busy", "false")
    view.wait("segments", str(n_segments))
    assert n_segments == 6  # what the notebook asked for last
    assert colours(view.pixels()) >= 4  # not blank, and segments differ

    settings = book.page.locator(".swc")
    for label, value in (("Segments S", "40"), ("Cost exponent", "2")):
        box = settings.get_by_role("spinbutton", name=f"{label}, exactly")
        box.fill(value)
        box.press("Enter")
    book.wait_for("(w.params.n_segments, w.params.cost_exponent)", (40, 2.0))
    chosen = int(book.evaluate("w.wait().n_segments"))
    assert chosen != n_segments
    view.wait("busy", "false")
    view.wait("segments", str(chosen))
    assert book.errors == []
