"""A scan of 1.5 million faces is pointed at and edited as a small one."""

from __future__ import annotations

import pytest
from conftest import difference, until
from editing_page import WIDGET, Editor

LARGE = WIDGET.replace("n=40", "n=354")


@pytest.fixture
def large(notebook):
    """An editor of the room in 6 × 2 × 354² faces; nothing may go wrong in the console."""
    book = notebook([LARGE])
    book.run_all()
    editor = Editor(book)
    assert editor.python("mesh.n_faces") == 1_503_792
    yield editor
    assert book.errors == []


def test_a_scan_of_1_5_million_faces_is_pointed_at_and_edited(large):
    view = large.view
    (one, start), (two, end) = large.ends()
    view.point(3, view.size()[1] - 60)  # nothing is there
    view.wait("hovered", "")
    before = view.pixels()
    view.point(*start)
    view.wait("hovered", str(one))
    until(view.page, lambda: difference(view.pixels(), before) > 0)  # it blinks
    large.book.execute("before = w.segmentation.labels")
    view.drag(start, end)
    large.settled(large.n - 1)
    is_one = large.python(f"np.unique(w.segmentation.labels[(before == {one}) | (before == {two})]).size")
    assert is_one == 1
    view.point(3, view.size()[1] - 60)
    assert difference(view.pixels(), before) > 0.02
    large.click(start, button="right")
    large.settled(large.n)
    assert large.edits() == ["Merge", "Split"]
    for _ in range(2):
        large.page.keyboard.press("Control+z")
    large.settled(large.n)
    assert large.python("(w.segmentation.labels == before).all()")
    view.point(3, view.size()[1] - 60)
    assert difference(view.pixels(), before) < 0.01
