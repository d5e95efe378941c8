"""The view under fingers: they turn and zoom the room, pick, merge and split, and never scroll the page."""

from __future__ import annotations

import json

import pytest


class Fingers:
    """Touches of a picture, by Chromium's own events; places are pixels from its upper left corner."""

    def __init__(self, view):
        self._view = view
        self._session = view.page.context.new_cdp_session(view.page)

    def _send(self, kind, *places):
        points = [
            {"x": self._box["x"] + x, "y": self._box["y"] + y, "id": i, "radiusX": 5, "radiusY": 5}
            for i, (x, y) in enumerate(places)
        ]
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def press(self, *places):
        """Put one finger on each place, once the picture stands still."""
        self._view.settle()
        self._box = self._view.root.locator("canvas").bounding_box()
        for n in range(1, len(places) + 1):
            self._send("touchStart", *places[:n])

    def move(self, starts, ends, steps=6):
        """Move all fingers that are down."""
        for k in range(1, steps + 1):
            t = k / steps
            self._send(
                "touchMove",
                *((x + t * (u - x), y + t * (v - y)) for (x, y), (u, v) in zip(starts, ends, strict=True)),
            )

    def lift(self):
        """Take all fingers away."""
        self._send("touchEnd")

    def tap(self, place):
        """Touch a place for a moment."""
        self.press(place)
        self.lift()

    def drag(self, start, end):
        """One finger from place to place."""
        self.press(start)
        self.move([start], [end])
        self.lift()


# On a busy machine, half a second can pass before a finger is lifted.
NO_LONG_PRESS = """() => {
    const later = window.setTimeout;
    window.setTimeout = (act, ms, ...rest) => later(act, ms === 500 ? 3_600_000 : ms, ...rest);
    return () => { window.setTimeout = later; };
}"""


@pytest.fixture
def fingers(editor):
    """Hands on the screen of an editor; none of their touches is long."""
    undo = editor.page.evaluate_handle(NO_LONG_PRESS)
    yield Fingers(editor.view)
    undo.evaluate("undo => undo()")


def camera(editor):
    editor.view.settle()
    return json.loads(editor.python("__import__('json').dumps(w.view._camera)"))


def test_one_finger_turns_two_zoom_and_the_page_stays(editor, fingers):
    editor.button("Look").click()
    editor.view.drag((100, 200), (110, 200))
    first = camera(editor)
    scrolled = "() => document.querySelector('.jp-WindowedPanel-outer').scrollTop"
    top = editor.page.evaluate(scrolled)
    fingers.drag((300, 200), (300, 300))
    turned = camera(editor)
    assert turned["pitch"] > first["pitch"]
    assert turned["target"] == first["target"]
    starts, ends = [(300, 200), (400, 200)], [(250, 200), (450, 200)]
    fingers.press(*starts)
    fingers.move(starts, ends)
    fingers.lift()
    near = camera(editor)
    assert near["distance"] < 0.8 * turned["distance"]
    assert near["yaw"] == turned["yaw"]
    starts, ends = [(300, 200), (400, 200)], [(360, 230), (460, 230)]
    fingers.press(*starts)
    fingers.move(starts, ends)
    fingers.lift()
    aside = camera(editor)
    assert aside["distance"] == pytest.approx(near["distance"])
    assert aside["target"] != near["target"]
    assert editor.page.evaluate(scrolled) == top
    assert editor.edits() == []


def test_a_tap_points_at_what_is_there(editor, fingers):
    editor.button("Look").click()
    (one, place), _ = editor.ends()
    fingers.tap(place)
    editor.view.wait("hovered", str(one))
    assert f"Segment {one}" in editor.root.locator(".sw-status").inner_text()


def test_a_tap_on_a_part_then_on_its_target_merges(editor, fingers):
    (one, start), (_, end) = editor.ends()
    fingers.tap(start)
    editor.view.wait("picked", str(one))
    fingers.tap(end)
    editor.settled(editor.n - 1)
    assert editor.edits() == ["Merge"]


def test_a_finger_drawn_over_parts_turns_the_room_and_edits_nothing(editor, fingers):
    (_, start), (_, end) = editor.ends()
    before = editor.view.parts()
    fingers.drag(start, end)
    assert editor.view.parts() != before
    editor.view.wait("pending", "0")
    assert editor.edits() == []


def test_a_long_press_splits(editor):
    fingers = Fingers(editor.view)
    (_, start), (_, end) = editor.ends()
    editor.view.drag(start, end)
    editor.settled(editor.n - 1)
    fingers.press(start)
    editor.settled(editor.n)
    fingers.lift()
    editor.view.wait("picked", "")
    assert editor.edits() == ["Merge", "Split"]


def test_a_finger_paints_with_the_brush_and_taps_cut(editor, fingers):
    (_, start), (_, end) = editor.ends()
    editor.button("Brush").click()
    editor.view.wait("tool", "brush")
    fingers.press(start)
    fingers.move([start], [end])
    editor.view.wait("gesture", "brush")
    fingers.lift()
    editor.view.wait("pending", "0")
    assert editor.edits() == ["Merge"]
    editor.button("Cut").click()
    editor.view.wait("tool", "cut")
    n, (x, y) = int(editor.view.state("segments")), start
    fingers.tap((x - 15, y))
    editor.root.get_by_text("click the other side of the cut").wait_for()
    fingers.tap((x + 15, y))
    editor.settled(n + 1)
