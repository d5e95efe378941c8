"""Wherever a page puts a view, it fills its place and the pointer hits what it is on."""

from __future__ import annotations

import pytest
from cells import LABELED

SCALED = """transform => {
    document.body.style.transformOrigin = "0 0";
    document.body.style.transform = transform;
}"""


@pytest.mark.parametrize("transform", ["scale(.6)", "scale(.8, .5)", "scale(1.3)"])
def test_the_pointer_hits_what_it_is_on_at_any_scale(saved, transform):
    places = {part: place for part, place in saved.parts().items() if part}
    canvas = saved.root.locator("canvas")
    before = canvas.bounding_box()
    saved.page.evaluate(SCALED, transform)
    saved.settle()
    box = canvas.bounding_box()
    across, down = box["width"] / before["width"], box["height"] / before["height"]
    assert (across, down) != (1, 1)
    seen = {part: (x * across, y * down) for part, (x, y) in places.items()}
    inside = {part: (x, y) for part, (x, y) in seen.items() if x < 900 and 60 * down < y < 560}
    assert len(inside) >= 3
    for part, (x, y) in inside.items():
        saved.point(x, y)
        saved.wait("hovered", part)


def test_the_wheel_leaves_what_it_is_on_in_its_place_at_any_scale(saved):
    saved.page.evaluate(SCALED, "scale(.6)")
    part, (x, y) = next((part, place) for part, place in saved.parts().items() if part)
    saved.point(x, y)
    for _ in range(4):
        saved.page.mouse.wheel(0, -120)
        saved.settle()
    saved.point(x, y)
    saved.wait("hovered", part)


def test_in_a_row_of_widgets_a_view_takes_the_room_that_is_left(notebook):
    book = notebook([LABELED + "import ipywidgets\nbox = ipywidgets.HBox([view])\nbox"])
    book.run_all()
    room = book.page.locator(".jp-OutputArea-output").bounding_box()["width"]
    widths = "[box.children[0].layout.width]"

    def width():
        shown = book.view()
        shown.settle()
        return shown.root.bounding_box()["width"]

    assert width() > 0.95 * room
    book.execute("box.children = [view, ipywidgets.Button(description='beside')]")
    assert 0.7 * room < width() < 0.95 * room
    book.execute("box.children = [ipywidgets.VBox([view]), ipywidgets.VBox([SceneView(mesh)])]")
    assert 0.4 * room < width() < 0.55 * room
    book.execute("view.layout.width = '300px'; box.children = [view]")
    book.wait_for(widths, ["300px"])
    assert 280 < width() < 310
    assert book.errors == []


@pytest.mark.parametrize(
    "layout",
    [
        "ipywidgets.AppLayout(center=view, left_sidebar=ipywidgets.Button(), pane_widths=['100px', 1, 0])",
        "ipywidgets.Tab([view])",
        "ipywidgets.GridBox([view])",
        "ipywidgets.VBox([view])",
    ],
)
def test_in_other_layouts_it_fills_its_place(notebook, layout):
    book = notebook([LABELED + f"import ipywidgets\n{layout}"])
    book.run_all()
    view = book.view()
    view.settle()
    room = book.page.locator(".jp-OutputArea-output").bounding_box()["width"]
    assert view.root.bounding_box()["width"] > 0.75 * room
    part, place = next((part, place) for part, place in view.parts().items() if part)
    view.point(*place)
    view.wait("hovered", part)
    assert book.errors == []


def test_in_high_contrast_what_is_pressed_is_outlined_and_samples_keep_their_colours(saved):
    saved.page.emulate_media(forced_colors="active")
    outlines = saved.root.get_by_role("button", name="Outlines")
    assert outlines.get_attribute("aria-pressed") == "true"
    assert outlines.evaluate("button => getComputedStyle(button).outline").endswith("solid 2px")
    saved.root.get_by_role("button", name="List of segments").click()
    swatches = saved.root.locator("tbody .sw-swatch")
    swatches.first.wait_for()
    colors = swatches.evaluate_all("all => all.map(swatch => getComputedStyle(swatch).backgroundColor)")
    assert len(set(colors)) == len(colors)


def test_what_happens_is_told_to_those_who_do_not_see_it(saved):
    told = saved.root.locator(".sw-unseen[role=status]")
    assert told.inner_text() == ""
    saved.root.get_by_role("button", name="List of segments").click()
    saved.root.locator("tr[data-segment='1']").get_by_role("button", name="Show").click()
    told.filter(has_text="1 segment hidden").wait_for(state="attached")
