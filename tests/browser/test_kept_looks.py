"""A view that is made anew goes on where the last one was."""

from __future__ import annotations

from editing_page import WIDGET, Editor
from test_robust import drawn_again

LOSE = "c => c.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()"
RUN = """n => {
    window.jupyterapp.shell.currentWidget.content.activeCellIndex = n;
    window.jupyterapp.commands.execute("notebook:run-cell");
}"""


def hide_one(editor):
    """Hide a segment in the middle of the picture."""
    (_, place), _ = editor.ends()
    editor.view.point(*place)
    editor.page.keyboard.press("h")
    editor.view.wait("hidden", "1")


def test_a_view_that_is_drawn_again_has_lost_nothing(editor):
    hide_one(editor)
    editor.page.keyboard.press("c")
    editor.view.wait("tool", "cut")
    editor.page.keyboard.press("v")
    editor.view.wait("inside", "true")
    editor.view.settle()
    editor.page.keyboard.press("x")
    section = editor.root.get_by_role("dialog", name="Section")
    section.wait_for()
    old = editor.root.locator("canvas").element_handle()
    old.evaluate(LOSE)
    editor.view.wait("ready", "false")
    drawn_again(editor.page, editor.root)
    assert not old.evaluate("canvas => canvas.isConnected")
    for name, value in {"hidden": "1", "inside": "true", "tool": "cut", "mode": "edit"}.items():
        assert editor.view.state(name) == value
    assert section.is_visible()
    editor.button("First-person view").click()
    editor.view.wait("inside", "false")


def test_what_is_hidden_is_hidden_in_further_views_and_on_saved_pages(notebook):
    book = notebook([WIDGET, "w.view"], height=1400)
    book.page.evaluate(RUN, 0)
    editor = Editor(book)
    hide_one(editor)
    book.wait_for("len(w.view._hidden) > 0", True)
    book.execute("page = w.to_html('hidden.html').read_text()")
    assert '"_hidden":[]' not in editor.python("page")
    book.page.evaluate(RUN, 1)
    other = book.view(1)
    other.wait("hidden", "1")
    editor.root.scroll_into_view_if_needed()
    editor.button("Show all").click()
    book.wait_for("w.view._hidden", [])
    editor.view.wait("hidden", "0")
    assert other.state("hidden") == "1"  # each view hides for itself
    assert book.errors == []
