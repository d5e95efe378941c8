"""Two views that turn and point together, and errors that follow an edit, in a real notebook."""

from __future__ import annotations

import json

import pytest
from cells import ROOM
from conftest import until

COMPARE = (
    ROOM
    + """
import scenewidget as sw

halves_of = sw.Segmentation.from_labels(mesh, halves)
walls = sw.Segmentation.from_labels(mesh, surfaces)
c = sw.Compare(mesh, walls, halves_of, truth=surfaces, height=300)
c.wait()
c
"""
)
TRUTH = (
    ROOM
    + """
import scenewidget as sw

params = sw.Params(n_segments=6, n_runs=4, n_graph_runs=4)
w = sw.SceneWidget(mesh, params, truth=surfaces, height=420, autosave=False)
w.wait()
w
"""
)


def camera(book, side):
    """Where a view looks from, as Python knows it at rest."""
    return json.loads(book.evaluate(f"__import__('json').dumps(c.views[{side}]._camera)").strip("'"))


@pytest.fixture
def compared(notebook):
    """Both views at rest; nothing may go wrong in the console meanwhile."""
    book = notebook([COMPARE])
    book.run_all()
    views = [book.view(0), book.view(1)]
    for view in views:
        view.wait("busy", "false")
    yield book, *views
    assert book.errors == []


def test_turning_one_view_turns_the_other(compared):
    book, left, right = compared
    before = right.pixels()
    for view in (left, right):  # each of the two leads
        width, height = view.size()
        view.drag((width * 0.4, height * 0.5), (width * 0.6, height * 0.6))
        left.settle()
        right.settle()
        a, b = camera(book, 0), camera(book, 1)
        assert a["yaw"] == pytest.approx(b["yaw"])
        assert a["target"] == pytest.approx(b["target"])
        assert a["distance"] == pytest.approx(b["distance"])
    assert (right.pixels() != before).any()


def test_pointing_at_a_place_shows_it_in_the_other_view(compared):
    _, left, right = compared
    place = next(place for part, place in left.parts().items() if part)
    left.point(*place)
    left.wait_until_pointed()
    right.wait_until_pointed()
    assert right.root.locator(".sw-twin").is_visible()
    left.point(-20, 20)
    right.wait("hovered", "")
    assert right.root.locator(".sw-twin").is_hidden()


def test_disagreement_is_chosen_for_both_views_at_once(compared):
    _, left, right = compared
    left.root.get_by_label("Colour by").select_option("errors")
    for view in (left, right):
        view.page.wait_for_function(
            "root => root.querySelector('[aria-label=\"Colour by\"]').value === 'errors'",
            arg=view.root.element_handle(),
        )
        view.root.get_by_text("Against the other").wait_for()
    # half of every wall belongs to a segment without a partner
    until(right.page, lambda: reddish(right.pixels().astype(int)).mean() > 0.02)


def reddish(pixels):
    return (pixels[..., 0] > 1.3 * pixels[..., 2]) & (pixels[..., 0] > 90)


def test_errors_follow_an_edit(notebook):
    book = notebook([TRUTH])
    book.run_all()
    view = book.view()
    view.wait("busy", "false")
    error = book.page.locator('.swc-score[data-score="1 − RI"]')
    error.wait_for()
    before = error.locator("b").inner_text()
    book.execute("w.session.merge(0, int((w.segmentation.labels != w.segmentation.labels[0]).argmax()))")
    book.page.locator('.swc-score[data-score="1 − RI"][data-trend="worse"]').wait_for()
    after = error.locator("b").inner_text()
    assert float(after) > float(before)
    book.execute("w.wait()")
    assert after == eval(book.evaluate("f\"{w.scores['rand_index_error']:.4f}\""))
    view.root.get_by_role("button", name="Edit", exact=True).click()
    view.root.get_by_role("button", name="Undo", exact=True).click()
    book.page.locator('.swc-score[data-score="1 − RI"][data-trend="better"]').wait_for()
    assert error.locator("b").inner_text() == before
    assert book.errors == []
