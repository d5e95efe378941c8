"""The widget in other hosts than JupyterLab: Notebook 7, Voila and marimo, each a real server."""

from __future__ import annotations

import json
import secrets
import sys
import textwrap
from dataclasses import dataclass
from typing import Any

import pytest
from cells import LABELED
from conftest import OWN_SOCKETS, VOILA_TROUBLES, Notebook, Server, View, errors_of, notebook_of, serve
from editing_page import WIDGET, Editor
from test_view import colors

TELLING = """
import ipywidgets
told = ipywidgets.Label("nothing yet")
view.observe(lambda change: setattr(told, "value", f"outlines {change['new']}"), "outlines")
ipywidgets.VBox([view, told])
"""


@pytest.fixture(scope="module")
def classic(tmp_path_factory, chromium):
    """A Notebook 7."""
    pytest.importorskip("notebook")
    home, token = tmp_path_factory.mktemp("notebook"), secrets.token_hex(16)
    command = [
        *(sys.executable, "-m", "notebook", "--no-browser", "--allow-root", "--expose-app-in-browser"),
        *("--ServerApp.ip=127.0.0.1", "--ServerApp.port={port}", "--ServerApp.port_retries=0"),
        *(f"--IdentityProvider.token={token}", f"--ServerApp.root_dir={home}"),
        *OWN_SOCKETS,
    ]
    own = {f"JUPYTER_{kind}_DIR": str(home / kind.lower()) for kind in ("CONFIG", "DATA")}
    with serve(command, home, f"/api/status?token={token}", env=own) as url:
        yield Server(url, token, home)


def go_through_edits(editor):
    """Merge, split, undo both, let go outside the picture."""

    def become(segments):
        editor.view.wait("segments", str(segments))
        editor.view.wait("pending", "0")

    (_, start), (_, end) = editor.ends()
    editor.view.drag(start, end)
    become(editor.n - 1)
    editor.click(start, button="right")
    become(editor.n)
    editor.page.keyboard.press("Control+z")
    become(editor.n - 1)
    editor.button("Undo").click()
    become(editor.n)
    editor.view.drag(start, (start[0], -20))
    become(editor.n)
    assert not editor.root.get_by_role("alert").is_visible()


class Classic(Notebook):
    """A notebook in a page of Notebook 7."""

    def address(self, name):
        return f"{self.server.url}/notebooks/{name}?token={self.server.token}"


@pytest.fixture
def book(classic, profile):
    """Opens a notebook in Notebook 7: `book(["cell", ...])`."""
    page = profile.new_page()
    page.set_viewport_size({"width": 1100, "height": 900})
    opened = Classic(page, classic)

    def open_book(cells):
        opened.open(cells)
        opened.run_all()
        return opened

    yield open_book
    opened.close()
    assert [error for error in opened.errors if "scenewidget" in error or "WebGL" in error] == []


def test_notebook_7_shows_points_and_tells_python(book):
    opened = book([LABELED + "view"])
    view = opened.view()
    assert colors(view.pixels()) >= 3
    part, place = next((part, place) for part, place in view.parts().items() if part)
    view.point(*place)
    view.wait("hovered", part)
    view.root.get_by_role("button", name="Outlines").click()
    opened.wait_for("view.outlines", False)
    view.page.mouse.click(*_on_page(view, place), button="right")
    assert view.page.locator(".lm-Menu").count() == 0
    view.page.keyboard.press("b")
    opened.wait_for("view.back_faces", True)
    assert view.page.locator(".jp-Notebook .jp-Cell").count() == 1


def test_notebook_7_edits(book):
    opened = book([WIDGET])
    opened.view()
    editor = Editor(opened)
    go_through_edits(editor)
    editor.settled(editor.n)
    assert editor.edits() == []


@pytest.fixture(scope="module")
def voila(tmp_path_factory, chromium):
    """A Voila that serves a folder."""
    pytest.importorskip("voila")
    home = tmp_path_factory.mktemp("voila")
    command = [
        *(sys.executable, "-m", "voila", "--no-browser", "--port={port}", "--token="),
        *("--Voila.ip=127.0.0.1", f"--Voila.root_dir={home}"),
        *OWN_SOCKETS,
    ]
    with serve(command, home, "/voila/static/voila.js") as url:
        yield Server(url, "", home)


@dataclass
class Shown:
    """A page with a view, whatever serves it."""

    page: Any

    def view(self) -> View:
        root = self.page.locator(".scenewidget")
        root.wait_for()
        view = View(self.page, root)
        view.wait("ready", "true")
        return view


@pytest.fixture
def render(voila, profile):
    """Shows a cell under Voila: `render("cell")`; nothing may go wrong in the console."""
    page = profile.new_page()
    page.set_viewport_size({"width": 1100, "height": 900})
    errors = errors_of(page)

    def show(cell):
        (voila.folder / "room.ipynb").write_text(json.dumps(notebook_of([cell])))
        page.goto(f"{voila.url}/voila/render/room.ipynb")
        return Shown(page)

    yield show
    page.close()
    assert [error for error in errors if not any(text in error for text in VOILA_TROUBLES)] == []


def test_voila_shows_points_and_tells_python(render):
    shown = render(LABELED + TELLING)
    view = shown.view()
    view.wait("live", "true")
    assert colors(view.pixels()) >= 3
    part, place = next((part, place) for part, place in view.parts().items() if part)
    view.point(*place)
    view.wait("hovered", part)
    view.root.get_by_role("button", name="Outlines").click()
    shown.page.get_by_text("outlines False").wait_for()


def test_voila_edits(render):
    go_through_edits(Editor(render(WIDGET)))


MARIMO = """
import marimo
app = marimo.App()

@app.cell
def _():
{room}
    w
    return (w,)

if __name__ == "__main__":
    app.run()
"""


def test_marimo_edits(tmp_path, profile):
    pytest.importorskip("marimo", reason="marimo isn't installed; it is no part of the test extra")
    script = tmp_path / "room.py"
    script.write_text(MARIMO.format(room=textwrap.indent(WIDGET, "    ")))
    command = [sys.executable, "-m", "marimo", "run", str(script), "--headless", "--no-token"]
    with serve([*command, "--port={port}"], tmp_path, "/health", env={"HOME": str(tmp_path)}) as url:
        page = profile.new_page()
        page.emulate_media(color_scheme="dark")  # which marimo, light unless told otherwise, passes over
        page.goto(url)
        editor = Editor(Shown(page))
        editor.view.wait("theme", "light")
        assert colors(editor.view.pixels()) >= 3
        go_through_edits(editor)
        settings = page.get_by_role("group", name="Settings", exact=True)
        settings.get_by_role("spinbutton", name="Segments S").fill("3")
        page.keyboard.press("Enter")
        page.wait_for_function(
            "([root, n]) => root.dataset.segments !== n", arg=[editor.root.element_handle(), str(editor.n)]
        )
        page.close()


def _on_page(view, place):
    box = view.root.locator("canvas").bounding_box()
    return box["x"] + place[0], box["y"] + place[1]
