"""Trying without deciding: previews come, stale ones don't, and the session never hears of them."""

import threading

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.widget.previewer import coarser, preview_params

SMALL = sw.Params(n_segments=6, n_runs=8, n_graph_runs=12)


@pytest.fixture
def widget():
    widget = sw.SceneWidget(shapes.room(10, noise=0.003)[0], SMALL)
    widget.wait(60)
    yield widget
    widget.close()


def move(widget, name, value):
    widget.controls._handle(None, {"kind": "move", "name": name, "value": value}, [])


def test_another_s_cuts_the_tree_of_the_result():
    mesh = shapes.room(10, noise=0.003)[0]
    pipe = sw.Pipeline(mesh)
    pipe.run(SMALL)
    params = preview_params(pipe, SMALL.replace(n_segments=9), SMALL)
    assert params == SMALL.replace(n_segments=9, k_range=(12, 15), relief=0.0, contrast=0.0)
    heard = []
    pipe.get("nested", params, progress=lambda stage, fraction: heard.append(stage))
    assert set(heard) == {"finish", "segmentation", "nested"}


def test_another_cost_makes_a_small_ensemble_of_the_same_items():
    mesh = shapes.room(10, noise=0.003)[0]
    pipe = sw.Pipeline(mesh)
    pipe.run(SMALL)
    params = preview_params(pipe, SMALL.replace(cost_exponent=1.5), SMALL)
    assert params == coarser(SMALL.replace(cost_exponent=1.5, relief=0.0, contrast=0.0))
    assert pipe.get("ensemble", params).shape[1] == 6 + SMALL.n_graph_runs
    assert pipe.get("items", params) is pipe.get("items", SMALL)


def test_the_thesis_is_previewed_on_fewer_faces_and_without_its_slow_consensus():
    params = preview_params(sw.Pipeline(shapes.box(8)), sw.Params.thesis(), sw.Params.thesis())
    assert (params.n_items, params.consensus, params.n_graph_runs) == (2000, "linkage", 0)


def slowly(monkeypatch, pipeline):
    """Makes the pipeline wait before each stage; gives what ends that, and a list of what was asked for."""
    gate, asked, get = threading.Event(), [], pipeline.get

    def wait(stage, params, **options):
        asked.append((stage, params.n_items))
        assert gate.wait(30)
        return get(stage, params, **options)

    monkeypatch.setattr(pipeline, "get", wait)
    return gate, asked


def test_a_preview_that_takes_time_says_so_and_then_no_more(widget, monkeypatch):
    widget.params = SMALL.replace(items="simplified", n_items=600)
    widget.wait(60)
    assert widget._previewer.wait(30)
    widget.pipeline.clear()
    gate, _ = slowly(monkeypatch, widget.pipeline)
    before = widget.view.status
    move(widget, "cost_exponent", 1.5)
    move(widget, "cost_exponent", 1.6)
    assert widget.view.status == "Preparing a preview"
    gate.set()
    assert widget._previewer.wait(30)
    assert (widget.view.status, widget.view._is_preview) == (before, True)
    move(widget, "cost_exponent", 1.7)
    assert widget.view.status == before


def test_the_first_preview_of_a_simplified_mesh_is_prepared_after_the_result(widget, monkeypatch):
    gate, asked = slowly(monkeypatch, widget.pipeline)
    widget.params = SMALL.replace(items="simplified", n_items=3000)
    widget.wait(60)
    gate.set()
    assert widget._previewer.wait(30)
    assert asked == [("items", 2000)]
    move(widget, "cost_exponent", 1.5)
    assert widget.view.status != "Preparing a preview"


def test_a_preview_shows_and_leaves_everything_else_alone(widget):
    before = (widget.segmentation, widget.params, widget.session.revision, widget.view.revision)
    move(widget, "n_segments", 9)
    assert widget._previewer.wait(30)
    assert widget.view._is_preview
    assert (widget.segmentation, widget.params, widget.session.revision, widget.view.revision) == before
    assert not widget.busy
    widget.controls._handle(None, {"kind": "leave"}, [])
    assert not widget.view._is_preview


def test_the_result_takes_the_place_of_the_preview(widget):
    first = int(np.argmax(widget.segmentation.labels == 1))
    widget.session.merge(first, int(np.argmax(widget.segmentation.labels == 0)))
    move(widget, "cost_exponent", 1.5)
    assert widget._previewer.wait(30)
    widget.controls.set("cost_exponent", 1.5)
    widget.wait(60)
    assert not widget.view._is_preview
    assert widget.params.cost_exponent == 1.5
    assert len(widget.session.edits) == 1


def test_a_preview_that_comes_too_late_is_dropped(widget, monkeypatch):
    started, gate = threading.Event(), threading.Event()
    get = widget.pipeline.get

    def slow(stage, params, **options):
        started.set()
        assert gate.wait(30)
        return get(stage, params, **options)

    monkeypatch.setattr(widget.pipeline, "get", slow)
    move(widget, "n_segments", 9)
    assert started.wait(30)
    widget.controls.set("n_segments", 4)
    widget.wait(60)
    gate.set()
    assert widget._previewer.wait(30)
    assert not widget.view._is_preview


def test_of_many_movements_only_the_last_is_computed_next(widget, monkeypatch):
    started, gate, asked = threading.Event(), threading.Event(), []
    get = widget.pipeline.get

    def slow(stage, params, **options):
        asked.append(params.n_segments)
        started.set()
        assert gate.wait(30)
        return get(stage, params, **options)

    monkeypatch.setattr(widget.pipeline, "get", slow)
    for n in (7, 8, 9, 10):
        move(widget, "n_segments", n)
        assert started.wait(30)
    gate.set()
    assert widget._previewer.wait(30)
    assert list(dict.fromkeys(asked)) == [7, 10]


def test_a_computation_that_ends_leaves_a_new_try_alone(widget, monkeypatch):
    gate = threading.Event()
    run = widget.pipeline.run
    monkeypatch.setattr(widget.pipeline, "run", lambda *a, **k: gate.wait(30) and run(*a, **k))
    widget.controls.set("n_segments", 9)
    move(widget, "n_segments", 4)
    assert widget._previewer.wait(30)
    gate.set()
    widget.wait(60)
    assert widget.view._is_preview
    widget.controls._handle(None, {"kind": "leave"}, [])
    assert not widget.view._is_preview


def test_a_cancelled_computation_ends_the_preview_and_offers_to_go_on(widget, monkeypatch):
    stopped = threading.Event()
    monkeypatch.setattr(widget.pipeline, "run", lambda *a, cancel, **k: cancel.wait(30) and stopped.set())
    move(widget, "cost_exponent", 1.5)
    assert widget._previewer.wait(30)
    before = widget.segmentation
    widget.controls.set("cost_exponent", 1.5)
    assert widget.view._is_preview
    widget.view._handle_custom_msg({"kind": "cancel"}, [])
    assert widget.wait(30) is before
    assert not widget.view._is_preview
    assert widget.controls.can_rerun


def test_the_granularity_can_be_chosen_and_keeps_the_edits(widget):
    widget.params = SMALL.replace(min_area=0.0)
    widget.wait(60)
    least, most, own = widget.controls.family
    assert own == widget.session.automatic.n_segments
    assert least <= own < most - 2
    first, second = (int(np.argmax(widget.segmentation.labels == i)) for i in (0, 1))
    widget.session.merge(second, first)
    widget.controls.set("granularity", own + 2)
    widget.wait(60)
    assert widget.params == SMALL.replace(min_area=0.0, granularity=own + 2)
    assert widget.session.automatic.n_segments == own + 2
    assert len(widget.session.edits) == 1
    assert widget.controls.family == [least, most, own]
    np.testing.assert_array_equal(
        widget.session.automatic.labels, sw.segment(widget.mesh, widget.params).labels
    )
    widget.controls.set("granularity", None)
    assert widget.wait(60) is widget.segmentation
    assert widget.session.automatic.n_segments == own


@pytest.mark.parametrize("value", [None, "shown", 1.5, 0])
def test_a_granularity_that_changes_nothing_or_can_not_be_ends_what_the_browser_shows_of_it(
    widget, monkeypatch, value
):
    value = widget.segmentation.n_segments if value == "shown" else value
    sent = []
    monkeypatch.setattr(widget.view, "send", sent.append)
    widget.controls._handle(None, {"kind": "set", "name": "granularity", "value": value}, [])
    assert sent == [{"kind": "end_preview"}]
    assert widget.params == SMALL
    assert not widget.busy


def test_a_value_that_is_refused_ends_the_preview(widget):
    move(widget, "cost_exponent", 1.5)
    assert widget._previewer.wait(30)
    assert widget.view._is_preview
    widget.controls.set("cost_exponent", -1)
    assert not widget.view._is_preview
