"""Cells that run again, without a browser: a real IPython shell, asked by a kernel that is made up."""

import gc
import sys
import threading
import weakref
from types import SimpleNamespace
from unittest.mock import Mock

import ipywidgets
import pytest
from IPython.core.interactiveshell import InteractiveShell

import scenewidget as sw
from scenewidget.datasets import analytic
from scenewidget.widget import lifetimes

PARAMS = "sw.Params(n_runs=2, n_graph_runs=2)"
MAKE = f"sw.SceneWidget(mesh, {PARAMS}, autosave=False)"


@pytest.fixture
def run(monkeypatch):
    """Runs a cell, as often as one likes."""
    shell = InteractiveShell()
    shell.user_ns |= {"sw": sw, "mesh": analytic.square(3), "ipywidgets": ipywidgets}
    request = {"header": {"msg_id": 0}, "metadata": {}}
    shell.kernel = SimpleNamespace(get_parent=lambda channel: request)
    monkeypatch.setattr(lifetimes, "_shell", lambda: shell)

    def run_cell(code, cell="a"):
        request["header"] = {"msg_id": request["header"]["msg_id"] + 1}
        request["metadata"] = {"cellId": cell} if cell else {}
        shell.run_cell(code, store_history=True).raise_error()
        return shell.user_ns

    yield run_cell
    for value in [*shell.user_ns.values(), *shell.user_ns["Out"].values()]:
        if isinstance(value, ipywidgets.Widget):
            value.close()


def n_widgets():
    return len(ipywidgets.widgets.widget._instances)


def test_running_a_cell_again_leaves_nothing_of_what_it_made_before(run):
    run(f"w = {MAKE}\nw")["w"].wait()
    n, threads = n_widgets(), threading.active_count()
    known = []
    for _ in range(5):
        names = run(f"w = {MAKE}\nw")  # without waiting: what is replaced is cancelled
        known.append((weakref.ref(names["w"]), weakref.ref(names["w"].pipeline)))
    names["w"].wait()
    gc.collect()
    assert n_widgets() == n
    assert threading.active_count() <= threads + 2  # one that is just ending
    for _ in range(100):
        if not any(reference() for pair in known[:-1] for reference in pair):
            break
        threading.Event().wait(0.05)
        gc.collect()
    assert not any(reference() for pair in known[:-1] for reference in pair)
    assert names["w"].view.comm is not None


def test_what_variables_lead_to_stays(run):
    names = run(f"all = [*globals().get('all', []), {MAKE}]")
    run(f"all = [*globals().get('all', []), {MAKE}]")
    run(f"box = ipywidgets.HBox([{MAKE}])", cell="b")
    kept = names["box"]
    names = run(f"another, box = box, ipywidgets.HBox([{MAKE}])", cell="b")
    assert [w.view.comm is not None for w in (*names["all"], *kept.children)] == [True] * 3


def test_other_cells_and_hosts_that_tell_nothing_close_nothing(run):
    names = run(f"first = {MAKE}")
    run(f"second = {MAKE}", cell="b")
    run(f"first, old = {MAKE}, first", cell=None)
    assert names["old"].view.comm is not None
    assert names["second"].view.comm is not None


def test_comparisons_go_with_their_cell_too(run):
    code = f"c = sw.Compare(mesh, {PARAMS}, {PARAMS})"
    run(code)["c"].wait()
    n = n_widgets()
    run(code)["c"].wait()
    assert n_widgets() == n
    run("c.close()")
    assert n_widgets() < n - 8


def test_marimo_gets_the_parts_and_what_it_drops_is_closed(monkeypatch):
    class Comms(dict):  # as marimo's manager knows them; it sets `comm` on every widget that is made
        def give(self, widget):
            self[id(widget)] = comm = Mock(comm_id=id(widget), comm_manager=SimpleNamespace(comms=self))
            widget.comm = comm

    comms = Comms()
    ui = SimpleNamespace(anywidget=lambda part: ("a part", part))
    monkeypatch.setitem(sys.modules, "marimo", SimpleNamespace(ui=ui, vstack=list))
    monkeypatch.setattr(ipywidgets.Widget, "_widget_construction_callback", comms.give)
    first = sw.SceneWidget(analytic.square(2), autosave=False)
    assert first._display_() == [("a part", first.view), ("a part", first.controls)]
    second = sw.SceneWidget(analytic.square(2), autosave=False)
    assert first.view.comm is not None
    comms.clear()  # their cells ran again
    third = sw.SceneWidget(analytic.square(2), autosave=False)
    assert (first.view.comm, second.view.comm, third.view.comm is None) == (None, None, False)
    third.close()
