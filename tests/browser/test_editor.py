"""Correcting a segmentation by mouse and keyboard, in a real notebook; what came of it is asked of Python."""

from __future__ import annotations

import json
import os
import re
import signal

import numpy as np
import pytest


def test_dragging_a_part_onto_another_merges_them(editor):
    (one, start), (two, end) = editor.ends()
    editor.book.execute("before = w.segmentation.labels")
    editor.press(start)
    editor.view.point(*end)
    editor.view.wait("target", str(two))
    assert editor.view.state("picked") == str(one)
    assert editor.root.locator(".sw-rubber").is_visible()
    assert "Merge into" in editor.root.inner_text()
    editor.page.mouse.up()
    editor.settled(editor.n - 1)
    assert not editor.root.locator(".sw-rubber").is_visible()
    assert editor.edits() == ["Merge"]
    assert (
        editor.python(f"len(set(w.segmentation.labels[(before == {one}) | (before == {two})].tolist()))") == 1
    )


def test_clicking_a_part_and_then_another_merges_them(editor):
    (one, start), (_, end) = editor.ends()
    editor.click(start)
    editor.view.wait("picked", str(one))
    assert editor.root.get_by_role("toolbar", name="Picked part").is_visible()
    editor.view.point(*end)
    assert editor.root.locator(".sw-rubber").is_visible()
    assert editor.edits() == []
    editor.click(end)
    editor.settled(editor.n - 1)
    assert editor.view.state("picked") == ""
    assert editor.edits() == ["Merge"]


def test_a_right_click_splits_and_a_right_drag_pans(editor):
    (_, start), (_, end) = editor.ends()
    editor.view.drag(start, end)
    editor.settled(editor.n - 1)
    editor.view.drag(start, (start[0] + 60, start[1]), button="right")
    editor.view.settle()
    assert editor.edits() == ["Merge"]
    editor.view.drag((start[0] + 60, start[1]), start, button="right")
    editor.view.settle()
    editor.click(start, button="right")
    editor.settled(editor.n)
    assert editor.edits() == ["Merge", "Split"]
    assert editor.page.locator(".lm-Menu").count() == 0


def test_undo_and_redo_by_keys_and_by_buttons(editor):
    editor.book.execute("before = w.segmentation.labels")
    undo, redo = editor.button("Undo"), editor.button("Redo")
    assert undo.is_disabled()
    (_, start), (_, end) = editor.ends()
    editor.view.drag(start, end)
    editor.settled(editor.n - 1)
    assert undo.get_attribute("title") == "Undo: Merge (Ctrl + Z)"
    editor.page.keyboard.press("Control+z")
    editor.settled(editor.n)
    assert editor.python("bool((w.segmentation.labels == before).all())")
    editor.page.keyboard.press("Control+Shift+Z")
    editor.settled(editor.n - 1)
    undo.click()
    editor.settled(editor.n)
    assert redo.get_attribute("title") == "Redo: Merge (Ctrl + Shift + Z)"
    redo.click()
    editor.settled(editor.n - 1)
    assert redo.is_disabled()
    assert editor.page.locator(".jp-Notebook .jp-Cell").count() == 1  # the notebook undid nothing


def test_a_merge_that_is_not_finished_edits_nothing(editor):
    (_, start), (_, end) = editor.ends()
    editor.view.drag(start, (-30, start[1]))  # released outside
    on_toolbar = editor.button("Help").bounding_box()
    editor.press(start)
    editor.page.mouse.move(on_toolbar["x"] + 5, on_toolbar["y"] + 5, steps=3)
    assert editor.view.state("target") == ""
    editor.page.mouse.up()
    for interrupt in (
        lambda: editor.page.keyboard.press("Escape"),
        lambda: editor.root.locator("canvas").evaluate(
            "c => c.dispatchEvent(new PointerEvent('pointercancel', { pointerId: 1, bubbles: true }))"
        ),
    ):
        editor.press(start)
        editor.view.point(*end)
        assert editor.view.state("gesture") == "link"
        interrupt()
        editor.view.wait("gesture", "idle")
        assert not editor.root.locator(".sw-rubber").is_visible()
        editor.page.mouse.up()
    editor.click(start)
    editor.page.keyboard.press("Escape")
    editor.view.wait("picked", "")
    editor.click(end)
    editor.page.keyboard.press("Escape")
    editor.press(start)
    editor.view.point(*end)
    canvas = editor.root.locator("canvas")
    canvas.evaluate(
        "c => (c.loser = c.getContext('webgl2').getExtension('WEBGL_lose_context')).loseContext()"
    )
    editor.view.wait("ready", "false")
    editor.page.mouse.up()
    canvas.evaluate("c => c.loser.restoreContext()")
    editor.view.wait("ready", "true")
    assert editor.edits() == []
    assert editor.view.state("segments") == str(editor.n)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no way to let a kernel pause")
def test_edits_show_at_once_while_the_kernel_is_busy_and_none_is_lost(editor):
    (_, start), (_, end) = editor.ends()
    third = next(
        place for part, place in editor.places().items() if place not in (start, end) and place[1] > 50
    )
    # on a slow machine, it would be told that the kernel doesn't answer
    quiet = editor.page.add_style_tag(content=".sw-notices { display: none }")
    kernel = editor.python("__import__('os').getpid()")
    os.kill(kernel, signal.SIGSTOP)  # a busy cell is not enough: some kernels answer beside it
    editor.view.drag(start, end)
    editor.view.wait("segments", str(editor.n - 1))
    editor.view.drag(third, end)
    editor.view.wait("segments", str(editor.n - 2))
    editor.page.keyboard.press("Control+z")
    editor.view.wait("segments", str(editor.n - 1))
    editor.page.keyboard.press("Control+Shift+Z")
    editor.view.wait("segments", str(editor.n - 2))
    assert editor.view.state("pending") == "4"
    editor.root.get_by_text("4 edits pending").wait_for()
    editor.click(third, button="right")
    editor.view.wait("segments", str(editor.n - 1))
    editor.page.mouse.move(2, 2)
    editor.view.wait("hovered", "")
    foreseen = editor.view.pixels()[60:-60].astype(int)
    os.kill(kernel, signal.SIGCONT)
    editor.settled(editor.n - 1)
    editor.page.mouse.move(3, 3)
    settled = editor.view.pixels()[60:-60]
    assert (np.abs(settled - foreseen) > 12).mean() < 0.002  # in the same colours
    assert editor.edits() == ["Merge", "Merge", "Split"]
    editor.root.get_by_text("edits pending").wait_for(state="hidden")
    quiet.evaluate("style => style.remove()")


def test_what_makes_no_sense_is_refused_with_a_reason(editor):
    (_, start), _ = editor.ends()
    editor.click(start, button="right")
    editor.root.get_by_text("This is a segment of its own already").wait_for()
    assert editor.edits() == []
    assert editor.view.state("pending") == "0"


def test_a_segment_is_named_with_words_to_choose_from(editor):
    (one, start), _ = editor.ends()
    face = editor.python(f"int((w.segmentation.labels == {one}).argmax())")
    editor.view.point(*start)
    editor.page.keyboard.press("n")
    name = editor.root.get_by_role("combobox", name="Name", exact=True)
    assert "chair" in name.evaluate("input => [...input.list.options].map(option => option.value)")
    editor.page.keyboard.type("<b>sofa</b> & 1")  # digits and letters are no commands here
    editor.page.keyboard.press("Enter")
    editor.view.wait("pending", "0")
    assert editor.python(f"w.segmentation.names[w.segmentation.labels[{face}]]") == "<b>sofa</b> & 1"
    editor.view.point(start[0] + 1, start[1])
    assert f"Segment {one} (<b>sofa</b> & 1)" in editor.root.inner_text()
    editor.click(start)
    editor.button("Name").click()
    assert name.input_value() == "<b>sofa</b> & 1"
    editor.page.keyboard.press("Escape")
    name.wait_for(state="hidden")
    assert editor.edits() == ["Relabel"]


def test_size_name_and_confidence_of_what_is_pointed_at_are_told(editor):
    (one, start), _ = editor.ends()
    editor.view.point(*start)
    editor.view.wait("hovered", str(one))
    row = json.loads(editor.python(f"w.segmentation.to_frame().loc[{one}].to_json()"))
    text = editor.root.locator(".sw-status").inner_text()
    assert f"{row['faces']:,} faces" in text
    assert f"confidence {row['confidence']:.2f}" in text
    assert float(re.search(r"([\d.,]+) m²", text)[1]) == pytest.approx(row["area"], rel=0.06)


def test_segments_are_hidden_isolated_and_framed(editor):
    (one, start), _ = editor.ends()
    editor.view.point(*start)
    editor.page.keyboard.press("h")
    editor.view.wait("hidden", "1")
    editor.view.settle()
    assert one not in editor.places()
    editor.page.keyboard.press("Shift+H")
    editor.view.wait("hidden", "0")
    editor.view.settle()
    assert one in editor.places()
    editor.view.point(*start)
    editor.page.keyboard.press("i")
    editor.view.wait("hidden", str(editor.n - 1))
    editor.view.settle()
    assert list(editor.places()) == [one]
    editor.button("Show all").click()
    editor.view.wait("hidden", "0")
    editor.view.settle()
    editor.view.point(*start)
    editor.page.keyboard.press("f")
    editor.view.settle()
    width, height = editor.view.size()
    editor.view.point(width / 2, height / 2)
    editor.view.wait("hovered", str(one))


def test_everything_goes_by_keyboard_alone(editor):
    editor.root.focus()
    editor.page.keyboard.press("e")
    editor.view.wait("mode", "navigate")
    editor.page.keyboard.press("e")
    editor.view.wait("mode", "edit")
    editor.page.mouse.move(2, 2)
    editor.root.focus()
    editor.page.keyboard.press("t")
    editor.view.settle()
    editor.page.wait_for_function(
        "root => root.dataset.hovered !== ''", arg=editor.root.element_handle()
    )  # in the middle
    editor.page.keyboard.press("Enter")
    first = editor.view.state("picked")
    assert first != ""
    for _ in range(40):
        editor.page.keyboard.press("ArrowUp")
        editor.view.settle()
        if editor.view.state("target") not in ("", first):
            break
    editor.page.keyboard.press("Enter")
    editor.settled(editor.n - 1)
    editor.page.keyboard.press("s")
    editor.settled(editor.n)
    assert editor.edits() == ["Merge", "Split"]


def test_help_lists_all_keys(editor):
    editor.root.focus()
    editor.page.keyboard.press("?")
    text = editor.root.get_by_role("dialog", name="Keys and gestures").inner_text()
    for words in ("merge", "split", "name the segment", "undo", "redo", "hide", "frame", "look or edit"):
        assert words in text
