"""Panels over the picture have room beside each other, in wide and in narrow cells."""

from __future__ import annotations

from itertools import pairwise

import pytest
from editing_page import WIDGET, Editor


@pytest.fixture
def cell(notebook):
    """Opens an editor in a window of some width; nothing may go wrong in the console."""
    books = []

    def open_cell(width):
        book = notebook([WIDGET.replace("height=420", "height=560")], width=width)
        book.run_all()
        books.append(book)
        return Editor(book)

    yield open_cell
    assert [error for book in books for error in book.errors] == []


def box(locator):
    """Left, top, right, bottom."""
    found = locator.bounding_box()
    return found["x"], found["y"], found["x"] + found["width"], found["y"] + found["height"]


def test_the_help_fits_into_a_cell_of_usual_size(cell):
    editor = cell(1200)
    editor.button("Help").click()
    card = editor.root.get_by_role("dialog", name="Keys and gestures")
    assert card.evaluate("card => card.scrollHeight <= card.clientHeight")
    assert card.evaluate("card => card.scrollWidth <= card.clientWidth")
    rows = card.locator(".sw-key")
    kept = rows.first.element_handle()
    editor.book.execute("w.view.outlines = False")
    editor.page.wait_for_function(
        "root => root.querySelector('[aria-label=Outlines]').ariaPressed === 'false'",
        arg=editor.root.element_handle(),
    )
    assert kept.evaluate("row => row.isConnected")  # made anew only if something else is to be listed
    card.get_by_role("button", name="Close help").click()
    editor.button("Look").click()
    editor.button("Help").click()
    assert rows.filter(has_text="turn around this point").is_visible()


def test_in_a_narrow_cell_panels_lie_beside_each_other(cell):
    editor = cell(560)
    editor.button("History").click()
    editor.button("Section").click()
    section = editor.root.get_by_role("dialog", name="Section")
    history = editor.root.get_by_role("region", name="History")
    history.wait_for()
    editor.view.settle()
    stage = box(editor.root)
    assert box(section)[3] <= box(history)[1]
    for panel in (section, history):
        left, top, right, bottom = box(panel)
        assert stage[0] <= left
        assert right <= stage[2]
        assert stage[1] <= top
        assert bottom <= stage[3]
    editor.button("Section").click()
    editor.button("History").click()
    history.wait_for(state="hidden")
    rightmost = max(editor.places().values())
    editor.view.point(*rightmost)
    editor.page.keyboard.press("n")
    form = editor.root.get_by_role("dialog", name="Name a segment")
    form.wait_for()
    assert box(form)[2] <= stage[2]
    assert form.evaluate("form => form.scrollWidth <= form.clientWidth")


def test_bars_over_the_picture_never_cover_each_other(cell):
    editor = cell(560)
    editor.book.execute("w.view.error = 'ValueError: wrong'")
    editor.book.execute(
        "w.view.notices = [{'key': 'a', 'text': 'Saved elsewhere', 'actions': [['Fetch', 'b']]}]"
    )
    offer = {"title": "Merge", "kind": "merge", "face": 0, "onto_face": 9, "level": "final", "number": 1}
    editor.book.execute(f"w.view.set_trait('suggestion', {offer})")
    suggestion = editor.root.get_by_role("toolbar", name="Suggestion")
    suggestion.wait_for()
    editor.root.focus()
    editor.page.keyboard.press("c")
    hint = editor.root.get_by_role("toolbar", name="Picked part")
    hint.wait_for()
    editor.view.settle()
    bars = [hint, suggestion, *editor.root.get_by_role("alert").all()]
    spans = sorted((box(bar)[1], box(bar)[3]) for bar in bars)
    assert len(spans) == 4
    for (_, above), (below, _) in pairwise(spans):
        assert above <= below


def test_all_of_the_section_is_within_reach_in_a_low_picture(notebook):
    book = notebook([WIDGET.replace("height=420", "height=200")], width=520)
    book.run_all()
    editor = Editor(book)
    editor.button("Section").click()
    section = editor.root.get_by_role("dialog", name="Section")
    ceiling = section.get_by_role("button", name="Cut the ceiling off")
    assert box(section)[3] <= box(editor.root)[3]
    ceiling.click()
    book.wait_for("w.view.section[2][1] < 1", True)
    assert book.errors == []
