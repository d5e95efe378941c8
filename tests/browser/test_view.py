"""The view in a real notebook: what a person sees, points at and turns."""

from __future__ import annotations

import numpy as np
import pytest
from cells import LABELED, ROOM
from conftest import difference, until


def colors(pixels: np.ndarray) -> int:
    """How many clearly different colours there are, each on a hundredth of the picture at least."""
    coarse = (pixels[60:-40] // 32).reshape(-1, 3).astype(int) @ [64, 8, 1]
    return int((np.bincount(coarse) > coarse.size / 100).sum())


@pytest.fixture
def room(notebook):
    """The labeled room, shown."""
    book = notebook([LABELED + "view"])
    book.run_all()
    view = book.view()
    view.settle()
    return book, view


def test_a_mesh_alone_is_drawn(notebook):
    book = notebook([ROOM + "view"])
    book.run_all()
    view = book.view()
    assert (view.state("segments"), view.state("busy"), view.state("hovered")) == ("0", "false", "")
    assert view.root.locator("canvas").count() == 1
    assert colors(view.pixels()) >= 3  # surfaces in different light
    assert book.errors == []


def test_segments_are_drawn_in_their_colours(room):
    book, view = room
    assert view.state("segments") == "6"
    view.root.get_by_role("button", name="Top view").click()
    view.settle()
    x, y = (int(size / 2) for size in view.size())
    seen = view.pixels()[y, x].astype(float)
    expected = np.array(eval(book.evaluate("view.segment_colors[0].tolist()")), float)
    assert (
        np.corrcoef(seen, expected)[0, 1] > 0.9 or np.abs(seen - expected).max() < 30
    )  # floor, lit from above
    assert book.errors == []


def test_the_part_under_the_pointer_is_named_at_each_level(room):
    book, view = room
    assert view.root.get_by_label("Level").input_value() == "surfaces"
    view.root.focus()
    view.page.keyboard.press("t")
    view.settle()
    width, height = view.size()
    view.point(width / 2 - 60, height / 2)
    view.wait("hovered", "0")
    assert "Segment 0" in view.root.inner_text()
    view.page.keyboard.press("1")
    left = {"0": "1", "1": "0"}
    book.wait_for("view.level", "halves")
    here = view.wait_until_pointed()
    view.point(width / 2 + 60, height / 2)
    view.wait("hovered", left[here])
    view.point(3, height - 60)
    view.wait("hovered", "")


def test_the_part_under_the_pointer_blinks(room):
    _, view = room
    width, height = view.size()
    before = view.pixels()
    view.point(width / 2, height / 2)
    view.wait_until_pointed()
    until(view.page, lambda: difference(view.pixels(), before) > 0)


def test_dragging_orbits_and_reset_comes_back(room):
    book, view = room
    width, height = view.size()
    before = view.pixels()
    parts_before = view.parts().keys()
    view.drag((width / 2, height / 2), (width / 2 + 300, height / 2 + 10))
    assert difference(view.pixels(), before) > 0.05
    assert view.parts().keys() != parts_before  # another wall has opened
    view.root.get_by_role("button", name="Reset view").click()
    view.point(3, 70)
    until(view.page, lambda: difference(view.pixels(), before) < 0.01)
    assert book.errors == []


def test_the_wheel_zooms_to_the_pointer(room):
    _, view = room
    part, place = next((part, place) for part, place in view.parts().items() if part)
    view.point(*place)
    for _ in range(6):
        view.page.mouse.wheel(0, -240)
    view.settle()
    view.point(place[0] + 1, place[1])
    view.wait("hovered", part)


def test_the_view_follows_the_size_of_its_cell(room):
    book, view = room
    width, _ = view.size()
    view.page.set_viewport_size({"width": 800, "height": 900})
    view.page.wait_for_function(
        "([c, w]) => c.clientWidth < w", arg=[view.root.locator("canvas").element_handle(), width]
    )
    book.execute("view.height = 300")
    view.page.wait_for_function("c => c.clientHeight < 310", arg=view.root.locator("canvas").element_handle())
    view.settle()
    assert view.size()[0] < width
    assert colors(view.pixels()) >= 3
    canvas = view.root.locator("canvas")
    assert canvas.evaluate("c => Math.abs(c.width / c.clientWidth - c.height / c.clientHeight) < 0.02")


def test_two_views_of_one_model_share_its_state_but_not_the_camera(notebook):
    book = notebook([LABELED + "view", "view"], height=1300)
    book.run_all()
    first, second = book.view(0), book.view(1)
    still = second.pixels()
    width, height = first.size()
    first.drag((width / 2, height / 2), (width / 2 + 250, height / 2))
    first.settle()
    assert difference(second.pixels(), still) < 0.01
    first.root.get_by_role("button", name="Outlines").click()
    outlines = second.root.get_by_role("button", name="Outlines")
    second.page.wait_for_function(
        "b => b.getAttribute('aria-pressed') === 'false'", arg=outlines.element_handle()
    )
    assert book.evaluate("view.outlines") == "False"
    assert book.errors == []


def test_a_lost_context_comes_back(room):
    _, view = room
    before = view.pixels()
    canvas = view.root.locator("canvas").element_handle()
    canvas.evaluate(
        "c => (c.loser = c.getContext('webgl2').getExtension('WEBGL_lose_context')).loseContext()"
    )
    view.wait("ready", "false")
    canvas.evaluate("c => c.loser.restoreContext()")
    view.wait("ready", "true")
    assert difference(view.pixels(), before) < 0.01


def test_a_closed_view_gives_its_context_back(room):
    book, view = room
    canvas = view.root.locator("canvas").element_handle()
    view.page.evaluate("() => window.jupyterapp.commands.execute('notebook:clear-all-cell-outputs')")
    view.page.wait_for_function("c => !c.isConnected && c.getContext('webgl2').isContextLost()", arg=canvas)
    assert book.page.locator(".scenewidget").count() == 0


def test_progress_status_and_errors_lie_over_the_picture(room):
    book, view = room
    book.execute("seen = []; view.on_msg(lambda _, message, __: seen.append(message))")
    book.execute("view.busy, view.progress, view.status = True, 0.4, 'Distances'")
    view.wait("busy", "true")
    assert "Distances" in view.root.inner_text()
    assert view.root.get_by_role("progressbar").get_attribute("aria-valuenow") == "40"
    view.root.get_by_role("button", name="Cancel").click()
    view.page.wait_for_function(
        "b => b.disabled", arg=view.root.get_by_role("button", name="Cancel").element_handle()
    )
    assert book.evaluate("seen") == "[{'kind': 'cancel'}]"
    book.execute("view.busy = False; view.error = 'no <b>such</b> file'")
    view.wait("busy", "false")
    alert = view.root.get_by_role("alert")
    alert.wait_for()
    assert "no <b>such</b> file" in alert.inner_text()
    view.root.get_by_role("button", name="Dismiss").click()
    alert.wait_for(state="hidden")
    assert book.evaluate("view.error") == "''"


def test_edits_send_a_table_and_keep_the_other_colours(room):
    book, view = room
    before = book.evaluate("view.segment_colors[:5].tolist()")
    book.execute("sent = view._face_atom; view.set_segments(np.where(surfaces == 5, 4, surfaces))")
    view.wait("segments", "5")
    assert book.evaluate("sent is view._face_atom") == "True"
    assert book.evaluate("view.segment_colors.tolist()") == before


def test_right_click_and_keys_stay_in_the_view(room):
    _, view = room
    width, height = view.size()
    view.point(width / 2, height / 2)
    view.page.mouse.click(*_center(view), button="right")
    assert view.page.locator(".lm-Menu").count() == 0
    view.page.keyboard.press("b")  # in JupyterLab: insert a cell below
    view.page.wait_for_function(
        "b => b.getAttribute('aria-pressed') === 'true'",
        arg=view.root.get_by_role("button", name="Back faces").element_handle(),
    )
    assert view.page.locator(".jp-Notebook .jp-Cell").count() == 1
    view.root.get_by_role("button", name="Outlines").focus()
    view.page.keyboard.press("b")  # likewise while a button has the focus
    view.page.wait_for_function(
        "b => b.getAttribute('aria-pressed') === 'false'",
        arg=view.root.get_by_role("button", name="Back faces").element_handle(),
    )
    assert view.page.locator(".jp-Notebook .jp-Cell").count() == 1
    view.page.keyboard.press("?")
    view.root.get_by_role("dialog").wait_for()
    view.page.keyboard.press("Escape")
    view.root.get_by_role("dialog").wait_for(state="hidden")


def test_values_are_coloured_with_a_legend(room):
    book, view = room
    book.execute("view.set_values(mesh.face_centroids[:, 2], title='height in m')")
    view.root.get_by_text("height in m").last.wait_for()
    view.settle()
    assert colors(view.pixels()) >= 4


def test_dragging_from_part_to_part_asks_for_a_merge(room):
    book, view = room
    book.execute("view.mode = 'edit'; seen = []; view.on_msg(lambda _, message, __: seen.append(message))")
    view.wait("mode", "edit")
    places = view.parts()
    (one, start), (two, end) = [(part, place) for part, place in places.items() if part][:2]
    view.drag(start, end)
    assert (
        book.evaluate("[(m['kind'], m['level'], m['revision']) for m in seen]")
        == "[('merge', 'surfaces', 1)]"
    )
    assert (
        book.evaluate("(int(surfaces[seen[0]['face']]), int(surfaces[seen[0]['onto_face']]))")
        == f"({one}, {two})"
    )
    view.drag(start, (-30, start[1]))  # released outside: no edit
    view.point(*start)
    view.page.mouse.click(*_on_page(view, start), button="right")
    assert book.evaluate("[m['kind'] for m in seen]") == "['merge', 'split']"


def _center(view) -> tuple[float, float]:
    width, height = view.size()
    return _on_page(view, (width / 2, height / 2))


def _on_page(view, place: tuple[float, float]) -> tuple[float, float]:
    box = view.root.locator("canvas").bounding_box()
    return box["x"] + place[0], box["y"] + place[1]


def test_without_webgl_the_cell_says_so(notebook):
    book = notebook([ROOM + "view"])
    undo = book.page.evaluate_handle(
        """() => {
            const { prototype } = HTMLCanvasElement;
            const { getContext } = prototype;
            prototype.getContext = function (kind, ...rest) {
                return kind === "webgl2" ? null : getContext.call(this, kind, ...rest);
            };
            return () => { prototype.getContext = getContext; };
        }"""
    )
    book.run_all()
    alert = book.page.locator(".scenewidget").get_by_role("alert")
    alert.wait_for()
    assert "needs WebGL 2" in alert.inner_text()
    undo.evaluate("undo => undo()")


def test_light_and_dark_follow_the_host(room):
    book, view = room
    view.wait("theme", "light")
    book.page.evaluate(
        "() => window.jupyterapp.commands.execute('apputils:change-theme', { theme: 'JupyterLab Dark' })"
    )
    view.wait("theme", "dark")
    book.page.evaluate(
        "() => window.jupyterapp.commands.execute('apputils:change-theme', { theme: 'JupyterLab Light' })"
    )
    view.wait("theme", "light")
    book.execute("view.theme = 'dark'")
    view.wait("theme", "dark")


def test_normals_and_confidence_are_colours_to_choose(room):
    book, view = room
    choice = view.root.get_by_label("Colour by")
    options = "select => [...select.options].map(option => option.text)"
    assert choice.evaluate(options) == ["Segments", "Parts", "Normals", "Plain"]
    book.execute("view.set_segments(surfaces, confidence=np.linspace(0, 1, mesh.n_faces))")
    book.page.wait_for_function(
        "select => [...select.options].some(option => option.text === 'Confidence')",
        arg=choice.element_handle(),
    )
    choice.select_option("confidence")
    view.root.get_by_text("≤ 0.5 unsure").wait_for()
    assert book.evaluate("view.color_by") == "'confidence'"
    choice.select_option("normals")
    view.root.get_by_text("down", exact=True).wait_for()
    view.root.get_by_role("button", name="Top view").click()
    view.settle()
    x, y = (int(size / 2) for size in view.size())
    red, green, blue = view.pixels()[y, x].astype(int)
    assert blue > red + 60  # the floor faces up
    assert abs(red - green) < 12
    view.root.get_by_role(
        "button", name="Back faces"
    ).click()  # now the ceiling is in front, seen from its back
    view.settle()
    red, green, blue = view.pixels()[y, x].astype(int)
    assert blue < red - 60
    assert book.errors == []
