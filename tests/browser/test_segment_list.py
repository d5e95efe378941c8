"""The list of segments beside the picture: sorted, linked with it both ways, usable by keys."""

from __future__ import annotations

import numpy as np
import pytest
from cells import LABELED
from conftest import until
from editing_page import WIDGET, Editor


class Rows:
    """The list of a view."""

    def __init__(self, view):
        self.view, self.page = view, view.page
        self.list = view.root.get_by_role("complementary", name="List of segments")
        self.table = view.root.get_by_role("table", name="Segments")

    def open(self):
        self.view.root.get_by_role("button", name="List of segments").click()
        self.table.wait_for()
        return self

    def cells(self):
        """Text of each row's cells."""
        return self.table.locator("tbody tr").evaluate_all(
            "rows => rows.map(row => [...row.cells].map(cell => cell.innerText.trim()).slice(1))"
        )

    def segments(self):
        return self.table.locator("tbody tr").evaluate_all("rows => rows.map(row => row.dataset.segment)")

    def row(self, segment):
        return self.table.locator(f"tbody tr[data-segment='{segment}']")

    def marked(self):
        return self.table.locator("tr.sw-marked").evaluate_all("rows => rows.map(row => row.dataset.segment)")

    def sort(self, column):
        self.table.get_by_role("columnheader", name=column).get_by_role("button").click()


@pytest.fixture
def room(notebook):
    """The labeled room with names and confidences, its list open."""
    names = "{2: 'wall 10', 3: 'wall 9', 0: '<i>floor</i>'}"
    sure = "[0.5, 0.75, 1, 0.125, 0.25, 0.625]"
    book = notebook([LABELED + f"view.set_segments(surfaces, names={names}, confidence={sure})\nview"])
    book.run_all()
    view = book.view()
    view.settle()
    yield book, view, Rows(view).open()
    assert book.errors == []


def test_it_tells_of_each_segment_and_sorts_by_each_column(room):
    book, _, rows = room
    assert book.evaluate("view.segment_list") == "True"
    cells = {cell[0]: cell[1:] for cell in rows.cells()}
    assert cells["<i>floor</i>"] == ["3,200", "12.00", "0.50"]
    assert cells["wall 9"] == ["3,200", "7.20", "0.13"]
    assert len(cells) == 6
    area = rows.table.get_by_role("columnheader", name="m²")
    assert area.get_attribute("aria-sort") == "descending"
    areas = [cell[2] for cell in rows.cells()]
    assert areas == ["12.00", "12.00", "9.60", "9.60", "7.20", "7.20"]
    rows.sort("m²")
    assert area.get_attribute("aria-sort") == "ascending"
    assert [cell[2] for cell in rows.cells()] == areas[::-1]
    rows.sort("Conf.")
    assert rows.segments() == ["3", "4", "0", "5", "1", "2"]
    rows.sort("Name")
    assert rows.segments()[:3] == ["0", "3", "2"]
    rows.list.get_by_role("button", name="Close the list").click()
    rows.table.wait_for(state="hidden")
    assert book.evaluate("view.segment_list") == "False"


def test_picture_and_list_point_at_each_other(room):
    _, view, rows = room
    places = {part: place for part, place in view.parts().items() if part}
    (one, place), (two, other) = list(places.items())[:2]
    view.point(*place)
    view.wait("hovered", one)
    assert rows.marked() == [one]
    view.point(*other)
    view.wait("hovered", two)
    assert rows.marked() == [two]
    view.point(3, view.size()[1] - 60)
    view.wait("hovered", "")
    assert rows.marked() == []
    before = view.pixels()
    rows.row(one).hover()
    view.page.wait_for_function(
        "row => row.classList.contains('sw-marked')", arg=rows.row(one).element_handle()
    )
    x, y = (int(value) for value in place)
    view.wait("listed", one)
    until(view.page, lambda: np.abs(view.pixels()[y, x].astype(int) - before[y, x]).max() > 8)


def test_rows_hide_and_frame_segments_by_mouse(room):
    _, view, rows = room
    one = next(part for part in view.parts() if part)
    rows.row(one).get_by_role("button", name="Show ").click()
    view.wait("hidden", "1")
    view.settle()
    assert one not in view.parts()
    assert rows.row(one).get_by_role("button", name="Show ").get_attribute("aria-pressed") == "false"
    assert "1 hidden" in rows.list.inner_text()
    rows.row(one).get_by_role("button", name="Show ").click()
    view.wait("hidden", "0")
    view.settle()
    assert one in view.parts()
    rows.row(one).get_by_role("rowheader").click()
    view.settle()
    width, height = view.size()
    view.point(width / 2, height / 2)
    view.wait("hovered", one)


def test_keys_act_on_the_picture_once_the_pointer_is_there(room):
    book, view, rows = room
    one, two = [part for part in view.parts() if part][:2]
    rows.row(one).get_by_role("rowheader").get_by_role("button").click()
    view.settle()
    view.point(*view.parts()[two])
    view.wait("hovered", two)
    book.page.keyboard.press("h")
    view.wait("hidden", "1")
    assert rows.row(two).get_attribute("data-hidden") == "all"
    assert rows.row(one).get_attribute("data-hidden") == "none"
    colours = view.root.get_by_label("Colour by")
    colours.hover()
    colours.focus()
    view.point(*view.parts()[one])
    book.page.keyboard.press("h")
    view.wait("hidden", "2")


def test_the_list_goes_by_keyboard_alone(room):
    book, view, rows = room
    view.root.focus()
    book.page.keyboard.press("l")
    rows.table.wait_for(state="hidden")
    book.page.keyboard.press("l")
    rows.table.wait_for()
    rows.table.get_by_role("columnheader", name="Conf.").get_by_role("button").focus()
    for key in ("Tab", "Tab", "ArrowDown", "ArrowDown"):
        book.page.keyboard.press(key)
    third = rows.segments()[2]
    assert rows.marked() == [third]
    book.page.keyboard.press("h")
    view.wait("hidden", "1")
    book.page.keyboard.press("End")
    assert rows.marked() == [rows.segments()[-1]]
    book.page.keyboard.press("i")
    view.wait("hidden", "5")
    stops = rows.table.locator("tbody [tabindex='0']").count()
    assert stops == 2  # of all rows only one is a stop of the Tab key


def test_edits_show_in_the_list_at_once(notebook):
    book = notebook([WIDGET])
    book.run_all()
    editor = Editor(book)
    rows = Rows(editor.view).open()
    assert len(rows.segments()) == editor.n
    frame = editor.python("w.segmentation.to_frame()[['faces', 'confidence']].to_dict('index')")
    shown = {int(segment): cells for segment, cells in zip(rows.segments(), rows.cells(), strict=True)}
    for segment, row in frame.items():
        assert shown[segment][1] == f"{row['faces']:,}"
        assert shown[segment][3] == f"{row['confidence']:.2f}"
    one, two = rows.segments()[-1], rows.segments()[0]
    rows.row(one).get_by_role("rowheader").click()
    editor.view.wait("picked", one)
    rows.row(two).get_by_role("rowheader").click()
    editor.settled(editor.n - 1)
    assert editor.edits() == ["Merge"]
    assert len(rows.segments()) == editor.n - 1
    assert editor.python("w.segmentation.to_frame()['faces'].max()") == int(
        rows.cells()[0][1].replace(",", "")
    )
    assert book.errors == []


def test_hundreds_of_segments_are_listed_and_scroll_into_sight(notebook):
    many = LABELED + (
        "centers = mesh.face_centroids\n"
        "many = np.unique(np.column_stack([surfaces, (centers / 0.45).astype(int)]), axis=0, "
        "return_inverse=True)[1].ravel()\n"
        "view.set_segments(many, levels={'final': many})\nview"
    )
    book = notebook([many])
    book.run_all()
    view = book.view()
    n = int(view.state("segments"))
    assert n > 250
    rows = Rows(view).open()
    assert len(rows.segments()) == n
    last = next(part for part in view.parts() if part)
    rows.sort("Name")
    rows.table.locator("tbody tr").first.get_by_role("rowheader").get_by_role("button").focus()
    book.page.keyboard.press("End")
    place = next(place for part, place in view.parts().items() if part == last)
    view.point(*place)
    view.wait("hovered", last)
    book.page.wait_for_function(  # its row has come into sight
        """row => {
            const [own, box] = [row, row.closest(".sw-list-scroll")].map(e => e.getBoundingClientRect());
            return own.top >= box.top && own.bottom <= box.bottom;
        }""",
        arg=rows.row(last).element_handle(),
    )
