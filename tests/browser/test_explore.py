"""Trying other settings by mouse and keyboard in a real notebook: previews, results, cancel, refusals."""

from __future__ import annotations

import pytest
from cells import ROOM

WIDGET = (
    ROOM
    + """
import scenewidget as sw

waves = np.sin(2.5 * mesh.vertices @ np.random.default_rng(0).standard_normal((3, 3)))
mesh = Mesh(mesh.vertices + 0.1 * waves, mesh.faces)  # uneven: runs disagree, so there are granularities
w = sw.SceneWidget(mesh, sw.Params(n_segments=6, n_runs=8, n_graph_runs=12, min_area=0.0), height=420)
w.wait()
w
"""
)
MERGE = "w.session.merge(0, int((w.segmentation.labels != w.segmentation.labels[0]).argmax()))"


class Explorer:
    """A widget in a notebook and the settings below it."""

    def __init__(self, book):
        self.book, self.page = book, book.page
        self.view = book.view()
        self.settings = self.page.locator(".swc")
        self.view.wait("busy", "false")
        self.view.settle()
        self.page.wait_for_function("() => !document.querySelector('.swc-family input').disabled")

    def slider(self, name):
        return self.settings.get_by_role("slider", name=name, exact=True)

    def grab(self, slider):
        """Press the mouse on a slider's thumb; gives a function that drags it to a share of its length."""
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        low, high, value = slider.evaluate("input => [input.min, input.max, input.value].map(Number)")

        def to(share, steps=4):
            self.page.mouse.move(
                box["x"] + 8 + (box["width"] - 16) * share, box["y"] + box["height"] / 2, steps=steps
            )

        to((value - low) / (high - low))
        self.page.mouse.down()
        return to

    def python(self, expression):
        return eval(self.book.evaluate(expression))

    def rested(self):
        """Wait until the picture shows the result of what was set."""
        self.page.wait_for_function("() => !document.querySelector('.swc').dataset.moving")
        self.book.execute("w.wait()")
        self.view.wait("preview", "false")
        self.view.wait("busy", "false")


@pytest.fixture
def explorer(notebook):
    """A segmented room; nothing may go wrong in the console meanwhile."""
    book = notebook([WIDGET])
    book.run_all()
    explorer = Explorer(book)
    yield explorer
    assert book.errors == []


def test_granularity_is_answered_by_the_browser_itself_and_kept_at_rest(explorer):
    _, most, own = explorer.python("w.controls.family")
    assert explorer.view.state("segments") == str(own)
    explorer.book.execute(MERGE)
    explorer.view.wait("segments", str(own - 1))
    drag = explorer.grab(explorer.slider("Granularity"))
    revision = explorer.python("w.view.revision")
    drag(1.0)
    explorer.view.wait("preview", "true")
    explorer.page.get_by_text("Preview: your edits come back when you let go").wait_for()
    explorer.view.wait("segments", str(most))
    assert explorer.python("(w.view.revision, w.params.granularity)") == (revision, None)
    explorer.page.mouse.up()
    explorer.rested()
    assert explorer.python("(w.params.granularity, w.session.automatic.n_segments)") == (most, most)
    assert explorer.python("len(w.session.edits)") == 1
    explorer.settings.get_by_role("checkbox", name="Granularity, as computed").check()
    explorer.view.wait("segments", str(own - 1))
    assert explorer.python("w.params.granularity") is None


def test_a_dragged_slider_shows_previews_and_then_the_result(explorer):
    before = explorer.python("(w.session.revision, w.view.revision)")
    drag = explorer.grab(explorer.slider("Cost exponent"))
    drag(0.5)
    explorer.view.wait("preview", "true")
    assert explorer.python("(w.session.revision, w.view.revision)") == before
    assert explorer.python("(w.params.cost_exponent, w.busy)") == (1.0, False)
    explorer.page.mouse.up()
    explorer.rested()
    exponent = explorer.python("w.params.cost_exponent")
    assert exponent == pytest.approx(2.0, abs=0.2)
    assert explorer.python("w.session.params == w.params")
    assert int(explorer.view.state("segments")) == explorer.python("w.segmentation.n_segments")


def test_nothing_is_edited_while_a_preview_shows(explorer):
    explorer.view.root.get_by_role("button", name="Edit", exact=True).click()
    explorer.book.execute(MERGE)
    explorer.view.wait("pending", "0")
    drag = explorer.grab(explorer.slider("Segments S"))
    drag(0.2)
    explorer.view.wait("preview", "true")
    explorer.view.root.evaluate("""root => root.dispatchEvent(
        new KeyboardEvent("keydown", { key: "z", ctrlKey: true, bubbles: true }))""")
    explorer.view.root.get_by_text("This is a preview").wait_for()
    assert explorer.python("len(w.session.edits)") == 1
    explorer.page.mouse.up()
    explorer.rested()
    assert explorer.python("len(w.session.edits)") == 1


def test_escape_and_a_thumb_that_comes_back_change_nothing(explorer):
    slider = explorer.slider("Segments S")
    before = explorer.python("w.view.revision"), slider.input_value()
    slider.focus()
    slider.press("ArrowRight")
    slider.press("Escape")
    explorer.view.wait("preview", "false")
    assert slider.input_value() == before[1]
    drag = explorer.grab(explorer.slider("Granularity"))
    start = explorer.slider("Granularity").input_value()
    drag(1.0)
    explorer.view.wait("preview", "true")
    low, high = (int(explorer.slider("Granularity").get_attribute(end)) for end in ("min", "max"))
    drag((int(start) - low) / (high - low))
    assert explorer.slider("Granularity").input_value() == start
    explorer.page.mouse.up()
    explorer.view.wait("preview", "false")
    assert explorer.python("w.view.revision") == before[0]
    assert explorer.python("w.params.granularity") is None


def test_keys_move_a_slider_and_only_the_last_value_is_computed(explorer):
    slider = explorer.slider("Segments S")
    slider.focus()
    for _ in range(4):
        slider.press("ArrowRight")
    explorer.page.wait_for_function(
        "() => document.querySelector('[data-name=n_segments] [role=spinbutton]').value === '10'"
    )
    explorer.rested()
    assert explorer.python("(w.params.n_segments, w.params.k_range)") == (10, None)


def test_cancel_keeps_the_result_before_and_the_settings_can_be_computed_again(explorer):
    shown = explorer.view.state("segments")
    explorer.book.execute(
        "import threading; run = w.pipeline.run\n"
        "w.pipeline.run = lambda *a, cancel, **k: cancel.wait(60) and run(*a, cancel=cancel, **k)"
    )
    drag = explorer.grab(explorer.slider("Cost exponent"))
    drag(0.6)
    explorer.view.wait("preview", "true")
    explorer.page.mouse.up()
    explorer.view.wait("busy", "true")
    explorer.view.root.get_by_role("button", name="Cancel").click()
    explorer.view.wait("busy", "false")
    explorer.view.wait("preview", "false")
    assert explorer.view.state("segments") == shown
    explorer.book.execute("del w.pipeline.run")
    explorer.settings.get_by_role("button", name="Segment again").click()
    explorer.settings.get_by_role("button", name="Segment again").wait_for(state="hidden")
    explorer.rested()
    assert explorer.python("w.session.params == w.params")


def test_a_value_that_can_not_be_is_refused_beside_its_input(explorer):
    before = explorer.book.evaluate("w.params")
    explorer.settings.get_by_text("Advanced").click()
    box = explorer.settings.get_by_role("spinbutton", name="Most items")
    box.fill("1")
    box.press("Enter")
    explorer.settings.get_by_text("n_items must lie in 2").wait_for()
    assert box.input_value() == "6000"
    assert explorer.book.evaluate("w.params") == before


def test_a_result_that_comes_meanwhile_leaves_alone_what_is_being_typed(explorer):
    box = explorer.settings.get_by_role("spinbutton", name="Cost exponent, exactly")
    box.fill("2")
    explorer.book.execute("w.params = w.params.replace(n_segments=8); w.wait()")
    explorer.rested()
    assert box.input_value() == "2"
    box.press("Enter")
    explorer.book.wait_for("(w.params.n_segments, w.params.cost_exponent)", (8, 2.0))
    explorer.rested()
    box.fill("3")
    box.fill("2")
    box.blur()
    explorer.book.execute("w.params = w.params.replace(cost_exponent=1.5); w.wait()")
    assert box.input_value() == "1.5"


def test_a_decimal_comma_is_one_and_what_is_no_number_is_refused(explorer):
    box = explorer.settings.get_by_role("spinbutton", name="Cost exponent, exactly")

    def type_in(text):
        box.select_text()
        explorer.page.keyboard.type(text)
        box.press("Enter")

    type_in("1,25")
    explorer.book.wait_for("w.params.cost_exponent", 1.25)
    explorer.rested()
    assert box.input_value() == "1.25"
    type_in("1,2,5")
    explorer.settings.get_by_text("is no number").wait_for()
    assert explorer.python("w.params.cost_exponent") == 1.25
    box.press("Escape")
    explorer.settings.get_by_text("is no number").wait_for(state="hidden")
    assert box.input_value() == "1.25"


def test_what_has_no_effect_can_not_be_set(explorer):
    explorer.settings.get_by_text("Advanced").click()
    leftovers = explorer.settings.get_by_role("combobox", name="Leftovers")
    assert leftovers.is_disabled()
    assert "Only PEAC" in explorer.settings.locator("[data-name=leftover]").get_attribute("title")
    explorer.settings.get_by_role("combobox", name="Consensus").select_option("peac")
    explorer.page.wait_for_function("() => !document.querySelector('[data-name=leftover] select').disabled")
    explorer.rested()
    explorer.settings.get_by_role("button", name="Reset to preset").click()
    explorer.page.wait_for_function("() => document.querySelector('[data-name=leftover] select').disabled")
    assert explorer.python("w.params == sw.Params(n_segments=6)")


def test_the_settings_are_copied_as_code(explorer):
    explorer.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    explorer.settings.get_by_role("button", name="Copy as code").click()
    explorer.settings.get_by_text("Copied: sw.Params(").wait_for()
    code = explorer.page.evaluate("() => navigator.clipboard.readText()")
    assert explorer.python(f"{code} == w.params")
