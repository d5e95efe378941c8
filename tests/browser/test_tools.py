"""Brush, cut, history and names by keys, in a real notebook; edits that nobody answers."""

from __future__ import annotations

import os
import re
import signal

import pytest
from editing_page import WIDGET, Editor


def three(editor):
    """Three segments that can be pointed at, with their places."""
    width, height = editor.view.size()
    inside = [
        (part, (x, y))
        for part, (x, y) in editor.places().items()
        if 50 < y < height - 90 and 20 < x < width - 20
    ]
    assert len(inside) >= 3, editor.places()
    return inside[:3]


def test_a_brush_gathers_parts_into_one_step(editor):
    places = [place for _, place in three(editor)]
    editor.page.keyboard.down("Control")
    editor.press(places[0])
    for x, y in places[1:]:
        box = editor.root.locator("canvas").bounding_box()
        editor.page.mouse.move(box["x"] + x, box["y"] + y, steps=4)
    assert editor.view.state("gesture") == "brush"
    assert int(editor.view.state("segments")) <= editor.n - 2  # as if it were done
    assert editor.edits() == []
    editor.page.mouse.up()
    editor.page.keyboard.up("Control")
    editor.view.wait("pending", "0")
    assert editor.edits() == ["Merge"]
    n = int(editor.view.state("segments"))
    assert editor.python("w.segmentation.n_segments") == n <= editor.n - 2
    editor.page.keyboard.press("Control+z")
    editor.settled(editor.n)


def test_a_brush_that_is_let_go_edits_nothing(editor):
    places = [place for _, place in three(editor)]
    editor.button("Brush").click()
    editor.view.wait("tool", "brush")
    for end in ("Escape", "outside"):
        editor.press(places[0])
        editor.view.point(*places[1])
        editor.view.wait("segments", str(editor.n - 1))
        if end == "Escape":
            editor.page.keyboard.press("Escape")
        else:
            editor.view.point(-40, 100)
        editor.page.mouse.up()
        editor.view.wait("segments", str(editor.n))
    assert editor.edits() == []
    editor.page.keyboard.press("Escape")
    editor.view.wait("tool", "merge")


def test_a_brush_gathers_one_by_one(editor):
    places = [place for _, place in three(editor)]
    editor.root.focus()
    editor.page.keyboard.press("g")
    for place in places:
        editor.click(place)
    editor.root.get_by_text("Brush: 2 parts onto").wait_for()
    editor.page.keyboard.press("Shift+Enter")
    editor.settled(editor.n - 2)
    assert editor.edits() == ["Merge"]
    editor.root.focus()
    editor.page.keyboard.press("Control+z")
    editor.settled(editor.n)
    for place in places[:2]:
        editor.click(place)
    editor.button("Merge them").click()
    editor.settled(editor.n - 1)


def test_undo_takes_back_what_a_brush_has_gathered_before_any_edit(editor):
    first, *places = [place for _, place in three(editor)]
    editor.view.point(*first)
    editor.root.focus()
    editor.page.keyboard.press("4")
    editor.book.wait_for("len(w.session.edits)", 1)
    editor.page.keyboard.press("g")
    for place in places:
        editor.click(place)
    editor.view.wait("segments", str(editor.n - 1))
    editor.page.keyboard.press("Control+z")
    editor.settled(editor.n)
    assert editor.edits() == ["Relabel"]
    editor.page.keyboard.press("Control+z")
    editor.book.wait_for("len(w.session.edits)", 0)


def test_a_segment_is_cut_between_two_points(editor):
    (one, (x, y)), *_ = three(editor)
    editor.root.focus()
    editor.page.keyboard.press("c")
    editor.view.wait("tool", "cut")
    editor.click((x - 14, y))
    editor.view.wait("picked", str(one))
    editor.root.get_by_text("click the other side of the cut").wait_for()
    editor.view.point(x + 14, y)
    assert editor.root.locator(".sw-rubber").is_visible()
    editor.click((x + 14, y))
    editor.settled(editor.n + 1)
    assert editor.edits() == ["Cut"]
    left, right = editor.python("(w.session.edits[0].face_a, w.session.edits[0].face_b)")
    assert editor.python(f"w.segmentation.labels[{left}] != w.segmentation.labels[{right}]")
    editor.view.point(x - 14, y)
    hovered = editor.view.state("hovered")
    editor.view.point(x + 14, y)
    editor.page.wait_for_function(
        "([root, other]) => !['', other].includes(root.dataset.hovered)",
        arg=[editor.root.element_handle(), hovered],
    )
    editor.page.keyboard.press("Escape")
    editor.view.wait("tool", "merge")


def test_two_points_of_different_segments_are_not_cut(editor):
    (_, start), (_, end) = editor.ends()
    editor.button("Cut").click()
    editor.view.drag(start, end)
    editor.root.get_by_text("A cut needs two points of the same segment").wait_for()
    assert editor.edits() == []


def test_the_history_is_walked_by_clicks(editor):
    (_, start), (_, end) = editor.ends()
    editor.view.drag(start, end)
    editor.settled(editor.n - 1)
    editor.view.point(*start)
    editor.page.keyboard.press("4")
    editor.view.wait("pending", "0")
    editor.button("History").click()
    steps = editor.root.get_by_role("region", name="History").get_by_role("button")
    editor.root.locator(".sw-step", has_text="Name 'wall'").wait_for()
    titles = [step.locator(".sw-step-title").inner_text() for step in steps.all()[1:]]
    assert titles == ["As segmented", "Merge", "Name 'wall'"]
    editor.root.locator(".sw-step", has_text="As segmented").click()
    editor.settled(editor.n)
    assert editor.edits() == []
    editor.root.locator(".sw-step", has_text="Name 'wall'").click()
    editor.settled(editor.n - 1)
    assert editor.edits() == ["Merge", "Relabel"]
    editor.root.locator(".sw-step[aria-current]", has_text="Name 'wall'").press("ArrowUp")
    editor.page.keyboard.press("Enter")
    editor.root.locator(".sw-step[aria-current]", has_text="Merge").wait_for()
    assert editor.edits() == ["Merge"]
    history = editor.root.get_by_role("region", name="History")
    editor.page.keyboard.press("Escape")
    history.wait_for(state="hidden")
    editor.button("History").click()
    history.wait_for()
    editor.click(start)  # where keys are the picture's; what is picked is let go of first
    editor.page.keyboard.press("Escape")
    editor.view.wait("picked", "")
    assert history.is_visible()
    editor.page.keyboard.press("Escape")
    history.wait_for(state="hidden")


def test_digits_give_names(editor):
    (one, start), _ = editor.ends()
    face = editor.python(f"int((w.segmentation.labels == {one}).argmax())")
    name = f"w.segmentation.names[w.segmentation.labels[{face}]]"
    editor.view.point(*start)
    editor.page.keyboard.press("5")
    editor.view.wait("pending", "0")
    assert editor.python(name) == "floor"
    editor.page.keyboard.press("2")  # digits below are levels
    editor.page.keyboard.press("3")
    editor.page.keyboard.press("n")
    form = editor.root.get_by_role("dialog", name="Name a segment")
    form.get_by_role("button", name="6 cabinet").click()
    editor.view.wait("pending", "0")
    assert editor.python(name) == "cabinet"
    assert editor.edits() == ["Relabel", "Relabel"]


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no way to let a kernel pause")
def test_edits_on_their_way_show_in_every_view_and_are_accounted_for(notebook):
    book = notebook([WIDGET, "w.view"], height=1400)
    book.run_all()
    editor = Editor(book)
    other = book.view(1)
    other.wait("segments", str(editor.n))
    editor.root.scroll_into_view_if_needed()
    editor.view.settle()
    (_, start), (_, end) = editor.ends()
    kernel = editor.python("__import__('os').getpid()")
    os.kill(kernel, signal.SIGSTOP)
    try:
        editor.view.drag(start, end)
        editor.view.wait("segments", str(editor.n - 1))
        other.wait("segments", str(editor.n - 1))
        assert other.state("pending") == "1"
        notice = editor.root.get_by_role("alert").filter(has_text="No answer from the kernel to 1 edit")
        notice.wait_for()
        notice.get_by_role("button", name="Take them back").click()
        editor.view.wait("segments", str(editor.n))
        other.wait("segments", str(editor.n))
        assert editor.view.state("pending") == "0"
    finally:
        os.kill(kernel, signal.SIGCONT)
    editor.settled(editor.n - 1)  # it was only busy: the edit was done, and shows


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no way to let a kernel pause")
def test_a_kernel_that_went_is_told_and_leaves_nothing_pending(editor):
    (_, start), (_, end) = editor.ends()
    os.kill(editor.python("__import__('os').getpid()"), signal.SIGSTOP)
    editor.view.drag(start, end)
    editor.view.wait("pending", "1")
    editor.book.restart()
    notice = editor.root.get_by_role("alert").filter(has_text=re.compile("[Rr]un the cell again"))
    notice.wait_for()
    notice.get_by_role("button", name="Take them back").click()
    editor.view.wait("pending", "0")
    editor.view.wait("segments", str(editor.n))


def test_brush_and_cut_go_by_keyboard_alone(editor):
    editor.page.mouse.move(2, 2)
    editor.root.focus()
    editor.page.keyboard.press("t")
    editor.view.settle()
    editor.page.keyboard.press("g")
    editor.page.keyboard.press("Enter")
    editor.root.get_by_text("Brush: gather parts for").wait_for()
    for _ in range(40):
        editor.page.keyboard.press("ArrowUp")
        editor.view.settle()
        editor.page.keyboard.press("Enter")
        if int(editor.view.state("segments")) < editor.n:
            break
    n = int(editor.view.state("segments"))
    assert n < editor.n
    editor.page.keyboard.press("Shift+Enter")
    editor.settled(n)
    editor.page.keyboard.press("c")
    editor.page.keyboard.press("Enter")
    assert editor.view.state("picked") != ""
    editor.page.keyboard.press("ArrowLeft")
    editor.page.keyboard.press("ArrowLeft")
    editor.view.settle()
    editor.page.keyboard.press("Enter")
    editor.settled(n + 1)
    assert editor.edits() == ["Merge", "Cut"]


def test_help_and_toolbar_offer_every_tool(editor):
    editor.root.focus()
    editor.page.keyboard.press("?")
    text = editor.root.get_by_role("dialog", name="Keys and gestures").inner_text()
    for words in ("brush", "cut", "history", "save everything", "give it this name", "gather one by one"):
        assert words in text
    for name in ("Merge", "Brush", "Cut", "Undo", "Redo", "History", "Save"):
        assert editor.button(name).is_visible()


def test_a_stroke_of_the_round_brush_draws_a_segment_and_a_second_one_adds_to_it(editor):
    (_, (x, y)), *_ = three(editor)
    editor.button("Paint").click()
    editor.view.wait("tool", "paint")
    editor.press((x - 10, y))
    editor.view.point(x + 10, y)
    editor.view.wait("segments", str(editor.n + 1))  # shown while the button is down
    assert editor.edits() == []
    canvas = editor.root.locator("canvas").element_handle()
    stroke = canvas.evaluate("(canvas) => canvas.toDataURL()")
    for mix in (0.5, 1.0):  # all of the picture is drawn anew, not what the stroke has changed alone
        editor.book.execute(f"w.view.color_mix = {mix}")
        is_as_before = "([canvas, stroke, mix]) => (canvas.toDataURL() === stroke) === (mix === 1)"
        editor.page.wait_for_function(is_as_before, arg=[canvas, stroke, mix])
    editor.page.mouse.up()
    editor.settled(editor.n + 1)
    assert editor.python("len(w.session.edits[0].faces)") > 20
    editor.view.drag((x - 10, y), (x - 10, y - 40))
    editor.settled(editor.n + 1)
    assert editor.edits() == ["Paint", "Paint"]
    assert editor.python("w.session.edits[1].onto_face in w.session.edits[0].faces")
    both = "[*w.session.edits[0].faces, *w.session.edits[1].faces]"
    assert editor.python(f"len(set(w.segmentation.labels[{both}]))") == 1
    if folder := os.environ.get("SCENEWIDGET_SHOTS"):
        editor.root.screenshot(path=f"{folder}/paint.png")
    editor.page.keyboard.press("Control+z")
    editor.page.keyboard.press("Control+z")
    editor.settled(editor.n)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no way to let a kernel pause")
def test_strokes_are_kept_while_the_kernel_is_busy(editor):
    (_, (x, y)), *_ = three(editor)
    editor.page.keyboard.press("m")
    editor.view.wait("tool", "paint")
    kernel = editor.python("__import__('os').getpid()")
    os.kill(kernel, signal.SIGSTOP)
    try:
        editor.click((x - 25, y))
        editor.click((x + 25, y))
        editor.view.wait("segments", str(editor.n + 2))
        assert editor.view.state("pending") == "2"
    finally:
        os.kill(kernel, signal.SIGCONT)
    editor.settled(editor.n + 2)
    assert editor.edits() == ["Paint", "Paint"]


def test_a_lasso_draws_segments_and_a_distance_is_measured(editor):
    (_, (x, y)), *_ = three(editor)
    editor.root.focus()
    editor.page.keyboard.press("q")
    editor.view.wait("tool", "lasso")
    square = lambda r: [(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)]  # noqa: E731  # corners
    box = editor.root.locator("canvas").bounding_box()
    first, *rest = square(24)
    editor.press(first)
    for to_x, to_y in rest:
        editor.page.mouse.move(box["x"] + to_x, box["y"] + to_y, steps=3)
    editor.view.wait("segments", str(editor.n + 1))  # shown while it is drawn
    assert editor.edits() == []
    editor.page.mouse.up()
    editor.settled(editor.n + 1)
    for place in (*square(10), square(10)[0]):
        editor.click(place)
    editor.settled(editor.n + 2)
    assert editor.edits() == ["Paint", "Paint"]
    editor.page.keyboard.press("d")
    editor.view.wait("tool", "measure")
    editor.click((x - 20, y))
    editor.click((x + 20, y))
    editor.root.get_by_text(re.compile(r"Distance \d+\.\d+ c?m")).wait_for()
    assert re.fullmatch(r"\d+\.\d+ c?m", editor.root.locator(".sw-outline-label").text_content())
