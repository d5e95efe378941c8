"""What goes into the book is complete. That it builds without warnings, `python notebooks/book` says."""

import base64
import gzip
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import scenewidget as sw
from scenewidget.datasets import analytic
from scenewidget.engine.operators import eigenbasis

NOTEBOOKS = Path(__file__).parents[1] / "notebooks"
sys.path.insert(0, str(NOTEBOOKS))

from book import links, reference, slides, staging, turning, views  # noqa: E402

PAGES = sorted(staging.HERE.glob("*.md"))


def test_every_public_name_is_in_the_reference():
    pages = reference.pages()
    found = "\n".join(pages.values())
    for name in sw.__all__:
        if name != "__version__":
            is_module = isinstance(getattr(sw, name), type(sw))
            assert (
                (name == "engine" or name in pages) if is_module else f"scenewidget.{name}\n" in found + "\n"
            )
    for module in reference.MODULES:
        for name in getattr(sw, module).__all__:
            assert name in pages[module]


def test_pages_link_to_what_exists():
    pages = {page.name for page in PAGES} | set(staging.TAKEN)
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", text):
            is_there = target in pages or (page.parent / target).exists() or target == "../api/index.rst"
            assert is_there, f"{page.name}: {target}"
        for stem in re.findall(r"_static/slides/(\w+)\.html", text):
            assert (NOTEBOOKS / f"{stem}.ipynb").exists(), f"{page.name}: {stem}"


def test_the_plan_has_every_notebook_of_the_course():
    plan = "".join(page.read_text(encoding="utf-8") for page in PAGES if page.name.startswith("week_"))
    course = [path.stem for path in NOTEBOOKS.glob("*.ipynb")]
    assert [stem for stem in course if f"../{stem}.ipynb" not in plan] == []


def test_every_widget_of_a_notebook_turns_in_the_book():
    assert views.missing() == []


def test_a_notebook_in_the_book_has_nothing_that_needs_a_kernel():
    cells = [
        {"cell_type": "markdown", "source": "# A room"},
        {"cell_type": "code", "source": "w", "outputs": [{"data": {"text/plain": "SceneWidget(8 faces)"}}]},
        {
            "cell_type": "code",
            "source": "",
            "outputs": [{"data": {"text/plain": "interactive(children=())"}}],
        },
        {"cell_type": "code", "source": "", "outputs": [{"data": {"text/plain": ""}}]},
    ]
    figure = sw.figures.show(analytic.square(2), width=50, height=40, title="nine")
    still = base64.b64encode(figure.png()).decode()
    shown = {"data": {"text/plain": repr(figure), "image/png": still}}
    cells.append({"cell_type": "code", "source": "figure", "outputs": [shown]})
    found = staging.notebook_for_the_book({"cells": cells}, "01_room")["cells"]
    assert "01_room.ipynb" in found[1]["source"]
    assert "_static/views/01_room-0.html" in found[2]["outputs"][0]["data"]["text/html"]
    assert "running notebook" in found[3]["outputs"][0]["data"]["text/html"]
    assert found[4]["outputs"] == []
    assert found[5]["outputs"][0]["data"].keys() == {"text/html"}
    assert "_static/views/01_room-figure-0.html" in found[5]["outputs"][0]["data"]["text/html"]
    assert "aspect-ratio: 50 / 66" in found[5]["outputs"][0]["data"]["text/html"]  # 26 for the title


def saved_in(page):
    """What a page of a figure keeps for its script, with its arrays."""
    saved = json.loads(re.search(r'id="figure">(.*?)</script>', page)[1])
    data = gzip.decompress(base64.b64decode(saved["data"]))
    arrays = [np.frombuffer(data, a["dtype"], a["length"], a["offset"]) for a in saved["arrays"]]
    return saved, arrays


def corners_in(panel, arrays):
    steps = arrays[panel["vertices"]].reshape(-1, 3)[arrays[panel["corners"]]]
    return (panel["low"] + panel["step"] * steps.astype(float)).reshape(-1, 3, 3)


def test_the_page_of_a_figure_keeps_its_triangles_and_colours():
    mesh = analytic.sphere(2)
    halves = [sw.figures.show(mesh, values=mesh.vertices[:, axis], edges=True) for axis in (0, 1)]
    figure = sw.figures.side_by_side([*halves, sw.figures.show(mesh, np.arange(320) % 7, title="a < b")])
    saved, arrays = saved_in(page := turning.page(figure))
    assert "a &lt; b" in page
    for drawing, panel in zip(figure.drawings, saved["panels"], strict=True):
        np.testing.assert_allclose(corners_in(panel, arrays), drawing.corners, atol=1e-4)
        colors = arrays[panel["colors"]].reshape(len(drawing.corners), -1, 3)
        np.testing.assert_array_equal(np.broadcast_to(colors, drawing.colors.shape), drawing.colors)
    first, second, third = saved["panels"]
    assert first["corners"] == second["corners"]  # stored once
    assert arrays[third["colors"]].size * 3 == figure.drawings[2].colors.size  # one a triangle
    assert (saved["seconds"], "swing" in page) == (None, False)


def test_the_page_of_a_vibration_swings_from_rest():
    square = analytic.square(3)
    figure = sw.figures.vibration(square, eigenbasis(square, 4), start=3)
    saved, arrays = saved_in(turning.page(figure))
    (panel,) = saved["panels"]
    np.testing.assert_allclose(corners_in(panel, arrays), figure.at_rest.corners, atol=1e-4)
    np.testing.assert_allclose(corners_in(panel["swung"], arrays), figure.drawings[0].corners, atol=1e-4)
    assert saved["seconds"] == pytest.approx(2.4 / np.sqrt(2), rel=0.05)  # cos πx · cos πy
    at_zero = turning.page(sw.figures.vibration(square, eigenbasis(square, 4), start=0))
    assert saved_in(at_zero)[0]["seconds"] is None


def test_links_between_files_of_the_repository_become_words():
    text = "See [the map](../js/README.md) and [Semantic versioning](https://semver.org)."
    assert staging.without_links_out(text) == "See the map and [Semantic versioning](https://semver.org)."


def test_slides_begin_at_headings_and_leave_checks_out():
    import nbformat

    sources = ["# Title", "words", "## Part"]
    cells = [nbformat.v4.new_markdown_cell(source) for source in sources]
    cells += [nbformat.v4.new_code_cell(source) for source in ("1 + 1", 'sw.exercises.check("03.1", answer)')]
    found = slides.as_slides(nbformat.v4.new_notebook(cells=cells))
    kinds = [cell.metadata["slideshow"]["slide_type"] for cell in found.cells]
    assert kinds == ["slide", "subslide", "slide", "-", "skip"]
    page = '<a href="02_x.ipynb">next</a> <iframe src="_static/views/01_x-0.html">'
    assert (
        slides.beside_each_other(page) == '<a href="02_x.html">next</a> <iframe src="../views/01_x-0.html">'
    )


@pytest.mark.parametrize(
    ("page", "fault"),
    [
        ('<a href="other.html#here">x</a>', None),
        ('<a href="missing.html">x</a>', "missing.html, which isn't there"),
        ('<a href="other.html#nowhere">x</a>', "where no such place is"),
        ('<script src="https://cdn.example/x.js"></script>', "from elsewhere"),
        ('<a href="https://example.org">x</a>', None),
    ],
)
def test_faults_of_a_site_are_found(tmp_path, page, fault):
    (tmp_path / "index.html").write_text(page)
    (tmp_path / "other.html").write_text('<p id="here">y</p>')
    found = links.faults(tmp_path)
    assert found == [] if fault is None else fault in found[0]


def test_styles_that_fetch_are_found(tmp_path):
    (tmp_path / "a.css").write_text("@import url(https://fonts.example/f.css);")
    assert links.faults(tmp_path) == ["a.css fetches something from elsewhere"]


@pytest.mark.parametrize("name", ["correct", "own_feature"])
def test_the_code_of_a_page_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (staging.HERE / f"{name}.md").read_text(encoding="utf-8")
    exec("\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL)), {})
