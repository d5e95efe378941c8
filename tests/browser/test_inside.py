"""Looking into a room: cut open by a box, walked through, and upright whichever axis is up."""

from __future__ import annotations

import json
from contextlib import contextmanager

import pytest
from cells import LABELED


@pytest.fixture
def room(notebook):
    """The labeled room, shown; nothing may go wrong in the console."""
    book = notebook([LABELED + "view"])
    book.run_all()
    view = book.view()
    view.settle()
    yield book, view
    assert book.errors == []


def seen(view):
    return {part for part in view.parts() if part}


@contextmanager
def moves(view):
    """Wait until what is done inside has set the picture in motion, even if that is over in an instant."""
    root = view.root.element_handle()
    root.evaluate(
        """root => {
            delete root.dataset.moved;
            const heard = () => { if (root.dataset.moving === "true") root.dataset.moved = ""; };
            new MutationObserver(heard).observe(root, { attributeFilter: ["data-moving"] });
        }"""
    )
    yield
    view.page.wait_for_function("root => 'moved' in root.dataset", arg=root)


def camera(book):
    return json.loads(eval(book.evaluate("__import__('json').dumps(view._camera)")))


def test_a_section_cuts_the_room_open_for_eye_and_pointer(room):
    book, view = room
    book.execute("view.back_faces = True")
    view.settle()
    view.root.focus()
    view.page.keyboard.press("t")
    view.settle()
    assert seen(view) == {"1"}  # the ceiling's back
    with moves(view):
        view.page.keyboard.press("Shift+X")
    view.settle()
    assert "1" not in seen(view)
    assert "0" in seen(view)
    book.wait_for("0.85 < view.section[2][1] < 0.97", True)
    book.execute("view.section = [(0, 1), (0, 1), (0, 0.5)]")
    view.page.keyboard.press("x")
    panel = view.root.get_by_role("dialog", name="Section")
    panel.wait_for()
    assert "0.0 – 1.2 m" in panel.inner_text()
    panel.get_by_role("button", name="Show the whole scan").click()
    view.page.wait_for_function(
        "b => b.disabled", arg=panel.get_by_role("button", name="Show the whole scan").element_handle()
    )
    view.settle()
    assert seen(view) == {"1"}
    book.wait_for("view.section", [(0.0, 1.0)] * 3)


def test_the_section_moves_by_keys_and_the_panel_gives_the_focus_back(room):
    book, view = room
    view.root.get_by_role("button", name="Section", exact=True).click()
    height = view.root.get_by_role("slider", name="Height to")
    assert height.evaluate("input => input.matches(':focus')")
    for _ in range(4):
        view.page.keyboard.press("ArrowLeft")
    book.wait_for("view.section[2]", (0.0, 0.98))
    assert height.get_attribute("aria-valuetext") == "2.4 m"
    low = view.root.get_by_role("slider", name="Height from")
    low.focus()
    view.page.keyboard.press("End")  # the ends don't pass each other
    book.wait_for("[round(end, 3) for end in view.section[2]]", [0.96, 0.98])
    view.page.keyboard.press("Escape")
    section = view.root.get_by_role("dialog", name="Section")
    section.wait_for(state="hidden")
    assert view.root.evaluate("root => root.matches(':focus')")
    view.page.keyboard.press("x")
    section.wait_for()
    view.point(*view.parts().popitem()[1])  # where keys are the picture's
    view.page.keyboard.press("Escape")
    section.wait_for(state="hidden")


def test_one_stands_in_the_room_and_walks(room):
    book, view = room
    outside = seen(view)
    view.root.get_by_role("button", name="First-person view").click()
    view.wait("inside", "true")
    view.settle()
    first = camera(book)
    eye = eval(book.evaluate("list(view._camera['target'])"))
    assert abs(eye[2] - (1.6 - 1.2)) < 0.2  # the mesh's middle is at half its height of 2.4 m
    view.page.keyboard.press("w")
    view.settle()
    gone = camera(book)
    assert gone["target"] != first["target"]
    assert gone["yaw"] == first["yaw"]
    view.page.keyboard.press("ArrowRight")
    view.settle()
    assert camera(book)["yaw"] < gone["yaw"]
    turned = camera(book)
    width, height = view.size()
    view.drag((width / 2, height / 2), (width / 2 + 120, height / 2))
    view.settle()
    assert camera(book)["yaw"] > turned["yaw"]  # what is grabbed goes along with the pointer
    near = camera(book)
    view.page.mouse.wheel(0, -240)
    view.settle()
    assert camera(book)["target"] != near["target"]
    view.page.keyboard.press("v")
    view.wait("inside", "false")
    view.settle()
    assert seen(view) == outside


def test_a_key_held_down_walks_on_until_it_is_let_go(room):
    book, view = room
    view.root.focus()
    view.page.keyboard.press("v")
    view.wait("inside", "true")
    view.settle()
    before = camera(book)["target"]
    view.page.keyboard.down("d")
    view.wait_frames(25)
    view.page.keyboard.up("d")
    view.settle()
    after = camera(book)["target"]
    assert sum((a - b) ** 2 for a, b in zip(after, before, strict=True)) > 0.2**2
    assert view.page.locator(".jp-Notebook .jp-Cell").count() == 1  # d, d would delete the cell


def test_editing_goes_on_inside_and_segments_are_turned_to(room):
    book, view = room
    book.execute("view.mode = 'edit'")
    view.wait("mode", "edit")
    view.root.focus()
    view.page.keyboard.press("v")
    view.wait("inside", "true")
    view.settle()
    target = camera(book)["target"]
    view.page.keyboard.press("s")  # back, not split
    view.settle()
    assert camera(book)["target"] != target
    one = next(iter(seen(view)))
    x, y = view.parts()[one]
    view.point(x, y)
    view.page.keyboard.press("f")
    view.settle()
    assert view.state("inside") == "true"
    view.page.keyboard.press("t")
    view.settle()
    assert view.state("inside") == "false"


def test_up_turns_the_scan(room):
    book, view = room
    view.root.focus()
    view.page.keyboard.press("t")
    view.settle()
    assert seen(view) == {"0"} | (seen(view) & {"2", "3", "4", "5"})
    with moves(view):
        book.execute("view.up = '-z'")
    view.settle()
    view.page.keyboard.press("t")
    view.settle()
    assert "0" not in seen(view)
    assert "1" in seen(view)
