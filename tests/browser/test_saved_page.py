"""A view saved as one file: it works from disk, without Python and without a network."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import NAMES, TITLE
from test_view import colors

import scenewidget as sw


def test_it_shows_what_was_saved_and_names_do_no_harm(saved):
    assert saved.state("segments") == "6"
    assert colors(saved.pixels()) >= 3
    assert (saved.state("busy"), saved.state("mode")) == ("false", "navigate")
    assert saved.page.evaluate("() => window.harm") is None
    assert saved.page.title() == TITLE
    place = next(place for part, place in saved.parts().items() if part == "0")
    saved.point(*place)
    saved.wait("hovered", "0")
    assert f"Segment 0 ({NAMES[0]})" in saved.root.inner_text()
    assert "confidence 0.50" in saved.root.inner_text()


def test_turning_levels_colours_and_the_list_work(saved):
    before = saved.pixels()
    width, height = saved.size()
    saved.drag((width / 2, height / 2), (width / 2 + 200, height / 2))
    saved.settle()
    assert (np.abs(saved.pixels().astype(int) - before) > 20).mean() > 0.05
    saved.root.get_by_label("Level").select_option("halves")
    saved.root.get_by_label("Colour by").select_option("parts")
    assert len([part for part in saved.parts() if part]) > 4
    saved.root.focus()
    saved.page.keyboard.press("l")
    table = saved.root.get_by_role("table", name="Segments")
    assert table.locator("tbody tr").count() == 6
    table.locator("tr[data-segment='1']").get_by_role("button", name="Show").click()
    saved.wait("hidden", "1")


def test_it_does_not_offer_to_edit(saved):
    for name in ("Edit", "Undo", "Redo"):
        assert not saved.root.get_by_role("button", name=name, exact=True).is_visible()
    saved.root.focus()
    saved.page.keyboard.press("e")
    assert saved.state("mode") == "navigate"
    saved.root.get_by_role("button", name="List of segments").click()
    saved.root.get_by_role("rowheader").first.get_by_role("button").click()
    saved.page.keyboard.press("n")
    assert not saved.root.get_by_role("dialog", name="Name a segment").is_visible()


def test_a_scan_takes_few_bytes_a_face(tmp_path):
    mesh, truth = sw.datasets.load_room()
    from scenewidget.widget.scene_view import SceneView

    view = SceneView(mesh)
    view.set_segments(truth.labels, levels={})
    size = view.to_html(str(tmp_path / "room.html")).stat().st_size
    assert size < 0.4e6 + 16 * mesh.n_faces


def test_the_section_and_the_inside_work_too(saved):
    saved.root.focus()
    saved.page.keyboard.press("t")
    saved.settle()
    assert "0" in saved.parts()
    saved.page.keyboard.press("x")
    saved.root.get_by_role("slider", name="Height from").focus()
    for _ in range(6):
        saved.page.keyboard.press("ArrowRight")
    saved.settle()
    assert "0" not in saved.parts()  # the floor is cut off
    saved.page.keyboard.press("Escape")
    saved.page.keyboard.press("Shift+X")
    saved.settle()
    assert "0" in saved.parts()
    saved.page.keyboard.press("v")
    saved.wait("inside", "true")
    saved.settle()
    saved.page.keyboard.press("w")
    saved.settle()
    assert any(saved.parts())


@pytest.mark.parametrize(
    ("color", "theme"),
    [("color(srgb 1 1 1)", "light"), ("color(srgb 0.1 0.1 0.1)", "dark"), ("oklch(0.98 0 0)", "light")],
)
def test_it_is_as_light_as_the_page_whatever_the_notation_of_its_colour(saved, color, theme):
    saved.page.evaluate(
        """color => {
            document.body.style.backgroundColor = color;
            for (let node = document.querySelector(".scenewidget").parentElement; node !== document.body;
                 node = node.parentElement) node.style.backgroundColor = "transparent";
        }""",
        color,
    )
    saved.wait("theme", theme)
    saved.page.emulate_media(color_scheme="dark" if theme == "light" else "light")
    saved.settle()
    assert saved.state("theme") == theme


def test_in_a_shadow_tree_it_is_as_light_as_the_page_around(saved):
    saved.page.evaluate(
        """() => {
            const [host, root] = [document.createElement("div"), document.querySelector(".scenewidget")];
            document.body.append(host);
            document.body.style.backgroundColor = "rgb(20 20 20)";
            host.attachShadow({ mode: "open" }).append(root);
            document.body.className = "changed";
        }"""
    )
    saved.wait("theme", "dark")
