"""The whole job by keys alone, as a screen reader tells it: from the accessibility tree of the page."""

from __future__ import annotations

import re

from editing_page import WIDGET
from test_segment_list import Rows

UNNAMED = re.compile(
    r'^\s*- (button|checkbox|combobox|slider|spinbutton|textbox|dialog|table|toolbar)(?! ")', re.M
)


def test_a_scan_is_corrected_named_and_saved_by_keys_and_each_step_is_told(notebook):
    book = notebook([WIDGET])
    book.page.emulate_media(reduced_motion="reduce")
    book.run_all()
    view, press = book.view(), book.page.keyboard.press
    view.wait("busy", "false")
    n, told = int(view.state("segments")), view.root.locator(".sw-unseen[role=status]")

    def hear(words):
        told.filter(has_text=words).wait_for(state="attached")
        view.wait("pending", "0")

    def tree():
        heard = view.root.aria_snapshot()
        assert UNNAMED.findall(heard) == []
        return heard

    view.root.focus()
    press("e")
    hear("Editing")
    for part in (
        '- toolbar "View"',
        '- button "Edit" [pressed]',
        '- combobox "Colour by"',
        '- button "Undo"',
    ):
        assert part in tree()
    press("l")
    rows = Rows(view)
    rows.table.wait_for()
    first, second = rows.segments()[:2]
    heard = tree()
    assert '- table "Segments"' in heard
    assert heard.count("- rowheader") == n
    rows.row(first).get_by_role("rowheader").get_by_role("button").focus()
    press("Enter")
    view.wait("picked", first)
    assert '- toolbar "Picked part"' in tree()
    press("ArrowDown")
    press("Enter")
    hear(f"{n - 1} segments")
    assert book.evaluate("w.segmentation.n_segments") == str(n - 1)
    press("n")
    assert '- dialog "Name a segment"' in tree()
    book.page.keyboard.type("floor")
    press("Enter")
    hear("floor")
    assert "floor" in rows.table.aria_snapshot()
    view.root.focus()
    press("Control+z")
    hear("Undone")
    press("Control+Shift+z")
    view.wait("pending", "0")
    press("Control+s")
    view.root.get_by_role("status").filter(has_text="Saved").first.wait_for()
    assert book.evaluate("[type(edit).__name__ for edit in w.session.edits]") == "['Merge', 'Relabel']"
    settings = book.page.get_by_role("group", name="Settings", exact=True).aria_snapshot()
    assert UNNAMED.findall(settings) == []
    assert "slider" in settings
    book.page.emulate_media(reduced_motion="no-preference")
    assert second in rows.segments() or first in rows.segments()
    assert book.errors == []
