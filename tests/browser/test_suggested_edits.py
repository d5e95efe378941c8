"""The next best edit in the picture: asked for by a button or a key, accepted, skipped, closed."""

from __future__ import annotations

import pytest
from test_explore import WIDGET

TORN = WIDGET.replace("n_segments=6", "n_segments=24")  # of six sides: most neighbours are one thing


@pytest.fixture
def suggesting(notebook):
    """A room in more segments than it has sides; nothing may go wrong in the console meanwhile."""
    book = notebook([TORN])
    book.run_all()
    view = book.view()
    view.wait("busy", "false")
    view.settle()
    book.page.get_by_role("button", name="Next suggestion").wait_for()
    assert int(book.evaluate("len(w.session.suggestions())")) >= 1
    yield book, view
    assert book.errors == []


def title(view):
    return view.root.get_by_role("toolbar", name="Suggestion").locator(".sw-picked-text").inner_text()


def test_a_suggestion_is_shown_skipped_and_accepted(suggesting):
    book, view = suggesting
    best = eval(book.evaluate("[(s.kind, s.title) for s in w.session.suggestions(1)]"))
    book.page.get_by_role("button", name="Next suggestion").click()
    view.wait("suggestion", best[0][0])
    assert title(view) == best[0][1]
    number = book.evaluate("w.view.suggestion['number']")
    view.root.press("k")
    book.wait_for(f"w.view.suggestion['number'] > {number}", True)
    assert book.evaluate("w.session.edits") == "[]"
    expected = book.evaluate("[s.edit for s in w.session.suggestions(1)]")
    view.root.press("Enter")
    book.wait_for("len(w.session.edits)", 1)
    assert book.evaluate("w.session.edits") == expected
    view.root.press("Escape")
    view.wait("suggestion", "")
    assert book.evaluate("list(w.view.suggestion)") == "['number']"


def test_keys_go_on_where_a_click_has_begun(suggesting):
    book, view = suggesting
    view.root.press("k")
    number = book.evaluate("w.view.suggestion['number']")
    skip = view.root.get_by_role("toolbar", name="Suggestion").get_by_role("button", name="Skip")
    skip.click()
    book.wait_for(f"w.view.suggestion['number'] == {number} + 1", True)
    book.page.keyboard.press("k")
    book.wait_for(f"w.view.suggestion['number'] == {number} + 2", True)
    book.page.keyboard.press("Escape")
    view.wait("suggestion", "")
    assert book.evaluate("w.session.edits") == "[]"
