"""A notebook under Voila: a web page without code, with a live kernel behind it."""

import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import OWN_SOCKETS, VOILA_TROUBLES, View, errors_of, serve

NOTEBOOK = Path(__file__).parent.parent.parent / "notebooks" / "01_segment_a_room.ipynb"


@pytest.fixture
def voila(tmp_path):
    """Address of a server that shows notebook 01."""
    command = [sys.executable, "-m", "voila", str(NOTEBOOK), "--no-browser", "--port={port}", *OWN_SOCKETS]
    with serve(command, tmp_path, "/voila/static/voila.js") as url:  # "/" would run the notebook
        yield url


def test_notebook_01_works_under_voila(voila, profile):
    page = profile.new_page()
    errors = errors_of(page)
    page.set_viewport_size({"width": 1000, "height": 900})
    page.goto(voila)  # answers while the notebook runs
    root = page.locator(".scenewidget")
    root.wait_for(state="attached")
    view = View(page, root)
    root.evaluate("root => root.scrollIntoView({ block: 'center' })")
    view.wait("ready", "true")
    view.wait("busy", "false")
    view.settle()
    assert len(np.unique(view.pixels()[60:-40:4, ::4].reshape(-1, 3) // 32, axis=0)) > 20  # a coloured room

    before = view.state("segments")
    box = page.get_by_role("spinbutton", name="Segments S, exactly")
    box.fill("80")
    box.press("Enter")
    page.wait_for_function(
        "([root, before]) => root.dataset.busy === 'false' && root.dataset.segments !== before",
        arg=[root.element_handle(), before],
    )
    page.close()
    assert [error for error in errors if not any(text in error for text in VOILA_TROUBLES)] == []
