"""However a kernel ends, the page notices within seconds, and nothing on it looks alive any more."""

from __future__ import annotations

import ast
import os
import signal
import time
import urllib.request

import pytest
from editing_page import WIDGET, Editor

CONTEXT = "window.jupyterapp.shell.currentWidget.context.sessionContext"
COMPUTING = "w.view.busy, w.view.progress, w.view.status = True, 0.3, 'Distances'"
KEEP_STATE = "@jupyter-widgets/jupyterlab-manager:saveWidgetState"  # in the notebook; turns it on or off
NOTICED_SECONDS = 5
SLACK = float(os.environ.get("SCENEWIDGET_SLACK", "4"))  # of a machine that does other things meanwhile


def shut_down(book):
    book.page.evaluate(f"() => {{ {CONTEXT}.shutdown(); }}")


def restart_while_busy(book):
    book.page.evaluate(
        f"() => {{ {CONTEXT}.session.kernel.requestExecute({{ code: 'import time; time.sleep(60)' }}); }}"
    )
    book.page.wait_for_function(f"() => {CONTEXT}.session.kernel.status === 'busy'")
    book.page.evaluate(f"() => {{ window.restarted = {CONTEXT}.restartKernel(); }}")


def kill(book):
    os.kill(ast.literal_eval(book.evaluate("__import__('os').getpid()")), signal.SIGKILL)


def delete(book):
    name = book.page.evaluate(f"() => {CONTEXT}.session.kernel.id")
    address = f"{book.server.url}/api/kernels/{name}?token={book.server.token}"
    urllib.request.urlopen(urllib.request.Request(address, method="DELETE")).close()


@pytest.mark.parametrize("end", [shut_down, restart_while_busy, kill, delete])
def test_nothing_looks_alive_within_seconds(notebook, end):
    book = notebook([WIDGET])
    book.run_all()
    editor = Editor(book)
    root, page = editor.root, editor.page
    book.execute(COMPUTING)
    root.get_by_role("button", name="Cancel").wait_for()
    end(book)
    began = time.monotonic()
    editor.view.wait("live", "false")
    assert time.monotonic() - began < SLACK * NOTICED_SECONDS
    root.get_by_text("The kernel is gone").wait_for()
    assert editor.view.state("busy") == "false"
    for name in ("Cancel", "Undo", "Save", "Edit"):
        assert not editor.button(name).is_visible(), name
    assert not root.get_by_role("progressbar").is_visible()
    settings = page.get_by_role("group", name="Settings", exact=True)
    settings.get_by_text("The kernel is gone").wait_for()
    assert settings.get_by_role("slider").first.is_disabled()
    root.focus()
    page.keyboard.press("Control+z")
    assert editor.view.state("pending") == "0"
    if end is restart_while_busy:
        page.evaluate("() => window.restarted")  # only then can the server end it


def test_a_page_stored_while_computing_is_at_rest_when_it_is_opened(notebook):
    book = notebook([WIDGET])
    book.run_all()
    editor = Editor(book)
    book.execute(COMPUTING)
    editor.root.get_by_role("button", name="Cancel").wait_for()
    keep_state = f"() => window.jupyterapp.commands.execute('{KEEP_STATE}')"
    book.page.evaluate(keep_state)
    book.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    book.page.wait_for_function("() => !window.jupyterapp.shell.currentWidget.context.model.dirty")
    book.page.evaluate(f"() => {CONTEXT}.shutdown()")
    book.page.reload()
    again = book.view()
    again.wait("live", "false")
    assert again.state("busy") == "false"
    for name in ("Cancel", "Undo", "Save", "Edit"):
        assert not again.root.get_by_role("button", name=name, exact=True).is_visible(), name
    again.root.get_by_text("The kernel is gone").wait_for()
    assert int(again.state("segments")) == editor.n  # one can still look
    book.page.evaluate(keep_state)  # the setting is as it was
    book.page.goto("about:blank")  # a page that was loaded again opens its notebook once more
