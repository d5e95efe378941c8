"""What happens around a view: it recovers, or says what to do."""

from __future__ import annotations

import pytest
from cells import LABELED, ROOM
from conftest import difference, until
from editing_page import WIDGET, Editor
from test_view import colors

COUNT_CONTEXTS = """() => {
    window.contexts = new Set();
    const getContext = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        const context = getContext.call(this, kind, ...rest);
        if (kind === "webgl2" && context) window.contexts.add(context);
        return context;
    };
}"""
LIVING = "() => [...window.contexts].filter(context => !context.isContextLost()).length"


@pytest.fixture
def room(notebook):
    """The labeled room, shown; nothing may go wrong in the console."""
    book = notebook([LABELED + "view"])
    book.page.evaluate(COUNT_CONTEXTS)
    book.run_all()
    view = book.view()
    view.settle()
    yield book, view
    assert book.errors == []


def test_twenty_views_opened_and_closed_give_their_contexts_back(notebook):
    book = notebook([ROOM + "import ipywidgets\nbox = ipywidgets.VBox([])\nbox"])
    warnings = []
    book.page.on("console", lambda message: warnings.append(message.text))
    book.page.evaluate(COUNT_CONTEXTS)
    book.run_all()
    book.wait_for("'box' in globals()", True)
    for _ in range(20):
        book.execute("box.children = [SceneView(mesh, height=200)]")
        book.view()
        book.execute("box.children = []")
        book.page.wait_for_function(LIVING.replace("=> [", "=> 0 === [", 1))
    assert book.page.evaluate("() => window.contexts.size") == 20
    assert not [text for text in warnings if "Too many active WebGL contexts" in text]
    assert book.errors == []


def test_more_views_than_the_browser_allows_are_drawn_when_they_are_looked_at(notebook):
    book = notebook(
        [ROOM + "import ipywidgets\nipywidgets.VBox([SceneView(mesh, height=200) for _ in range(19)])"]
    )
    book.run_all()
    book.page.locator(".scenewidget").nth(18).wait_for(state="attached")
    for index in (0, 9, 18, 0):
        root = book.page.locator(".scenewidget").nth(index)
        root.evaluate("root => root.scrollIntoView({ block: 'center' })")
        drawn_again(book.page, root)
        view = book.view(index)
        assert colors(view.pixels()) >= 3


def drawn_again(page, root):
    """Wait until a picture is there; one that lost its context soon after it was made asks for a click."""
    page.wait_for_function(
        """index => {
            const root = document.querySelectorAll(".scenewidget")[index];
            const button = [...root.querySelectorAll("button")].find(b => b.textContent === "Draw it again");
            button?.click();
            return root.dataset.ready === "true" && root.dataset.moving === "false";
        }""",
        arg=root.evaluate("root => [...document.querySelectorAll('.scenewidget')].indexOf(root)"),
    )


def test_a_picture_put_aside_is_drawn_again(room):
    _, view = room
    before = view.pixels()
    view.root.locator("canvas").evaluate(
        "c => c.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()"
    )
    view.wait("ready", "false")
    drawn_again(view.page, view.root)
    assert view.root.get_by_role("button", name="Draw it again").count() == 0
    view.point(3, view.size()[1] - 60)
    until(view.page, lambda: difference(view.pixels(), before) < 0.01)


def test_scrolled_away_and_back_it_is_still_there(notebook):
    book = notebook([LABELED + "view", *["print('line\\n' * 60)"] * 4], height=700)
    book.run_all()
    view = book.view()
    view.settle()
    before = view.pixels()
    last = book.page.locator(".jp-Cell").last
    last.scroll_into_view_if_needed()
    book.execute("view.color_by = 'shaded'")
    book.execute("view.color_by = 'segments'")
    view = book.view()
    view.settle()
    assert difference(view.pixels(), before) < 0.01
    assert book.errors == []


def test_a_page_that_was_frozen_takes_up_what_changed(room):
    book, view = room
    session = book.page.context.new_cdp_session(book.page)
    session.send("Page.setWebLifecycleState", {"state": "frozen"})
    session.send("Page.setWebLifecycleState", {"state": "active"})
    book.execute("view.set_segments(np.where(surfaces == 5, 4, surfaces))")
    view.wait("segments", "5")
    view.settle()
    assert colors(view.pixels()) >= 3


def test_running_the_cell_again_replaces_the_view(room):
    book, view = room
    old = view.root.locator("canvas").element_handle()
    book.execute("before = view")
    book.run_all()
    book.wait_for("before is view", False)
    book.page.wait_for_function("c => !c.isConnected", arg=old)
    again = book.view()
    again.settle()
    assert book.page.locator(".scenewidget").count() == 1
    book.page.wait_for_function(LIVING.replace("=> [", "=> 1 === [", 1))


def test_a_kernel_that_has_restarted_is_told_of_and_nothing_is_edited(notebook):
    book = notebook([WIDGET])
    book.run_all()
    editor = Editor(book)
    book.restart()
    editor.view.wait("live", "false")
    editor.root.get_by_text("The kernel is gone").wait_for()
    editor.view.wait("mode", "navigate")
    assert not editor.button("Edit").is_visible()
    editor.root.focus()
    editor.page.keyboard.press("e")
    editor.page.keyboard.press("Control+z")
    assert editor.view.state("pending") == "0"
    before = editor.view.pixels()
    width, height = editor.view.size()
    editor.view.drag((width / 2, height / 2), (width / 2 + 200, height / 2))
    editor.view.settle()
    assert difference(editor.view.pixels(), before) > 0.05  # one can still look


def test_a_notebook_closed_and_opened_again_shows_the_view_as_it_was(room):
    book, view = room
    width, height = view.size()
    view.drag((width / 2, height / 2), (width / 2 + 250, height / 2))
    view.settle()
    book.execute("view.set_segments(np.where(surfaces == 5, 4, surfaces))")
    view.wait("segments", "5")
    view.point(3, height - 60)
    before = view.pixels()
    book.wait_for("'yaw' in view._camera", True)
    book.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    book.page.wait_for_function("() => !window.jupyterapp.shell.currentWidget.context.model.dirty")
    book.page.reload()
    again = book.view()
    again.settle()
    assert again.state("segments") == "5"
    assert difference(again.pixels(), before) < 0.01
    book.page.goto(
        "about:blank"
    )  # a page that was loaded again opens its notebook once more, for the next test
