"""Notebooks 02 to 10 as a reader goes through them: run, scroll, look, turn, slide."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import View, until
from PIL import Image

from scenewidget.figures.raster import Camera

FOLDER = Path(__file__).parent.parent.parent / "notebooks"
FIGURES = ".scenewidget-figure .jupyter-threejs"
DONE = """() => [...window.jupyterapp.shell.currentWidget.context.model.cells]
    .filter(cell => cell.type === 'code').every(cell => cell.executionCount !== null)
    && window.jupyterapp.shell.currentWidget.context.sessionContext.session.kernel.status === 'idle'"""
SCROLL = """index => {
    const book = window.jupyterapp.shell.currentWidget.content;
    book.activeCellIndex = index;
    book.scrollToItem(index, "start");
}"""
CELLS_SHOWING = """words => [...window.jupyterapp.shell.currentWidget.context.model.cells]
    .map((cell, i) => [cell, i])
    .filter(([cell]) => cell.type === 'code' && cell.outputs.toJSON().some(
        output => words.some(word => `${output.data?.["text/plain"] ?? ""}`.startsWith(word))))
    .map(([, i]) => i)"""


def pixels(element) -> np.ndarray:
    """(height, width, 3) uint8 what a person sees of it."""
    return np.asarray(Image.open(io.BytesIO(element.screenshot())).convert("RGB"))


def is_drawn(picture: np.ndarray) -> bool:
    """Something that is not the background, in more than one shade."""
    is_ink = (picture < 245).any(axis=2)
    return is_ink.mean() > 0.02 and len(np.unique(picture[is_ink] // 16, axis=0)) > 3


@pytest.fixture
def run(notebook):
    def run_all(name: str):
        book = notebook(next(FOLDER.glob(f"{name}*.ipynb")), height=1000)
        book.run_all()
        book.page.wait_for_function(DONE)
        return book

    return run_all


def figures_of(book, cell: int):
    """The 3D pictures of a cell, scrolled to."""
    book.page.evaluate(SCROLL, cell)
    place = book.page.locator(f'.jp-Cell[data-windowed-list-index="{cell}"] {FIGURES}')
    place.first.wait_for(state="visible")
    place.first.scroll_into_view_if_needed()
    return place


def wait_until_drawn(book, figure) -> np.ndarray:
    until(book.page, lambda: is_drawn(pixels(figure)))
    return pixels(figure)


def changed(before: np.ndarray, after: np.ndarray) -> float:
    """Share of the pixels that are clearly different."""
    return float((np.abs(before.astype(int) - after) > 30).any(axis=2).mean())


def look_at_everything(book, n_figures, n_views=0):
    """Scroll through the notebook; every picture in it must show something."""
    cells = book.page.evaluate(CELLS_SHOWING, ["Figure(", "SpectralExplorer("])
    assert len(cells) >= n_figures
    for cell in cells:
        figures = figures_of(book, cell)
        for i in range(figures.count()):
            wait_until_drawn(book, figures.nth(i))
    cells = book.page.evaluate(CELLS_SHOWING, ["SceneWidget(", "SceneView("])
    assert len(cells) >= n_views
    for cell in cells:
        scene = scene_of(book, cell)
        until(book.page, lambda scene=scene: is_drawn(scene.pixels()))


def scene_of(book, cell):
    """The scene of a cell, scrolled to and complete."""
    book.page.evaluate(SCROLL, cell)
    root = book.page.locator(f'.jp-Cell[data-windowed-list-index="{cell}"] .scenewidget')
    root.wait_for(state="attached")
    root.evaluate("root => root.scrollIntoView({ block: 'center' })")
    view = View(book.page, root)
    view.wait("ready", "true")
    view.wait("busy", "false")
    return view


def slide(book, label, value):
    """Type a number into the readout of a slider."""
    slider = book.page.locator(".widget-slider").filter(has_text=label).last
    slider.locator(".widget-readout").click()
    book.page.keyboard.press("Control+A")
    book.page.keyboard.type(value)
    book.page.keyboard.press("Enter")


@pytest.mark.parametrize(
    ("name", "n_figures"),
    [("02", 6), ("03", 6), ("04", 6), ("05", 7), ("06", 3), ("07", 3), ("08", 3)],
    ids=[
        *("a scan is a graph", "two Laplacians", "the spectrum", "signatures"),
        *("distances", "an ensemble", "consensus"),
    ],
)
def test_every_figure_is_drawn_and_nothing_logs_an_error(run, name, n_figures):
    book = run(name)
    look_at_everything(book, n_figures)
    assert book.errors == []


def test_notebook_09_shows_its_session_in_two_windows_and_goes_through_the_history(run):
    book = run("09")
    look_at_everything(book, 1, n_views=2)
    second = scene_of(book, book.page.evaluate(CELLS_SHOWING, ["SceneView("])[0])
    slide(book, "edits", "0")
    at_first = book.evaluate("seg.n_segments")
    second.wait("segments", at_first)
    assert book.evaluate("len(w.session.edits)") == "0"
    first = scene_of(book, book.page.evaluate(CELLS_SHOWING, ["SceneWidget("])[0])
    first.wait("segments", at_first)
    assert book.errors == []


def test_the_knobs_of_notebook_10_change_picture_and_errors(run):
    book = run("10")
    look_at_everything(book, 2)
    cell = book.page.evaluate(CELLS_SHOWING, ["Figure("])[-1]
    picture = figures_of(book, cell).first
    before = wait_until_drawn(book, picture)
    title = book.page.locator(".scenewidget-figure").last
    told = title.text_content()
    slide(book, "k_range", "10 - 12")
    slide(book, "S", "5")
    until(book.page, lambda: title.text_content() != told)
    until(book.page, lambda: changed(before, pixels(picture)) > 0.02)
    assert book.errors == []


def test_turning_one_of_a_row_turns_all(notebook):
    book = notebook(
        [
            "import scenewidget as sw\n"
            "from scenewidget.datasets.analytic import torus\n"
            "sw.figures.side_by_side([sw.figures.show(torus()), sw.figures.show(torus(1, 0.2))])"
        ]
    )
    book.run_all()
    pictures = book.page.locator(FIGURES)
    pictures.nth(1).wait_for(state="visible")
    before = [wait_until_drawn(book, pictures.nth(i)) for i in range(2)]
    box = pictures.nth(0).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    book.page.mouse.move(x, y)
    book.page.mouse.down()
    book.page.mouse.move(x + 30, y + 70, steps=5)
    for i in range(2):  # while the button is still down
        until(book.page, lambda i=i: changed(before[i], pixels(pictures.nth(i))) > 0.05)
    book.page.mouse.up()
    assert book.errors == []


def test_the_explorer_follows_its_sliders_and_a_double_click(notebook):
    book = notebook(
        [
            "import scenewidget as sw\n"
            "from scenewidget.datasets.analytic import square\n"
            "explorer = sw.SpectralExplorer(square(70))\n"
            "explorer"
        ]
    )
    book.run_all()
    picture = book.page.locator(FIGURES)
    picture.wait_for(state="visible")
    before = wait_until_drawn(book, picture)

    slider = book.page.locator(".widget-slider").filter(has_text="Eigenfunction").first
    slider.locator(".widget-readout").click()
    book.page.keyboard.press("Control+A")
    book.page.keyboard.type("7")
    book.page.keyboard.press("Enter")
    book.page.wait_for_function(
        "() => document.querySelector('.scenewidget-figure').textContent.includes('φ₇')"
    )
    assert book.evaluate("explorer.index") == "7"
    until(book.page, lambda: np.abs(before.astype(int) - pixels(picture)).mean() > 5)

    book.page.locator(".widget-dropdown select").select_option("Heat from a point")
    book.page.wait_for_function(
        "() => document.querySelector('.scenewidget-figure').textContent.includes('heat from')",
    )
    source = book.evaluate("explorer.source")
    box = picture.bounding_box()
    book.page.mouse.dblclick(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    book.page.wait_for_function(
        f"() => !document.querySelector('.scenewidget-figure').textContent.includes('vertex {source} ')",
    )
    clicked = np.array(json.loads(book.evaluate("explorer.mesh.vertices[explorer.source].tolist()")))
    target = -np.array(json.loads(book.evaluate("list(explorer.figure.stage.shift)")))
    towards = Camera(-60, 30, 1.0).axes[2]
    middle = target - towards * (target[2] / towards[2])  # of the picture, on the plane of the square
    np.testing.assert_allclose(clicked, middle + np.array([0.5, 0.5, 0.0]), atol=0.03)
    book.page.locator(".widget-toggle-buttons button").filter(has_text="uniform").click()
    book.page.wait_for_function(
        "() => !document.querySelector('.scenewidget-figure').textContent.includes('m²')"
    )
    assert book.errors == []
