"""The settings without a browser: what they take, refuse and tell."""

import pytest

import scenewidget as sw
from scenewidget.widget.controls import ParamsControls

pytestmark = pytest.mark.filterwarnings("ignore:.*:UserWarning")


@pytest.fixture
def controls():
    return ParamsControls()


def test_a_value_that_can_not_be_is_refused_with_a_reason(controls):
    before = controls.params
    controls.set("n_items", 1)
    assert "n_items must lie in 2" in controls.problems["n_items"]
    assert controls.params is before
    controls.set("n_runs", 0)
    assert controls.problems == {}
    controls.set("n_graph_runs", 0)
    assert "an ensemble needs a member" in controls.problems["n_graph_runs"]
    assert controls.params == before.replace(n_runs=0)


def test_inputs_are_drawn_anew_after_every_answer(controls):
    seen = controls.revision
    controls.set("n_items", 1)
    assert controls.revision > seen
    seen = controls.revision
    controls.set("n_items", controls.params.n_items)
    assert controls.revision > seen


def test_whole_numbers_and_pairs_come_from_the_browser_as_they_are_typed(controls):
    controls._handle(None, {"kind": "set", "name": "n_runs", "value": 12.0}, [])
    controls._handle(None, {"kind": "set", "name": "convex_weights", "value": [0.5, 1]}, [])
    assert (controls.params.n_runs, controls.params.convex_weights) == (12, (0.5, 1.0))
    controls._handle(None, {"kind": "set", "name": "n_runs", "value": 12.5}, [])
    assert "whole number" in controls.problems["n_runs"]


def test_another_s_takes_the_granularity_back(controls):
    controls.offer_family([3, 90, 40])
    controls.set("granularity", 30)
    assert controls.params.granularity == 30
    controls.set("cost_exponent", 1.5)
    assert controls.params.granularity == 30
    controls.set("n_segments", 20)
    assert controls.params.granularity is None
    controls.set("granularity", 40)  # what the result has by itself
    assert controls.params.granularity is None


def test_the_granularity_waits_for_a_result(controls):
    assert "result" in controls.idle["granularity"]
    controls.offer_family([3, 90, 40])
    assert "granularity" not in controls.idle
    controls.offer_family([7, 7, 7])
    assert "no coarser or finer" in controls.idle["granularity"]


def test_presets_keep_the_number_of_segments(controls):
    controls.set("n_segments", 33)
    controls.use_preset("Thesis")
    assert controls.params == sw.Params.thesis(n_segments=33)
    assert (controls.preset, controls.changed) == ("Thesis", [])
    controls.set("cost_exponent", 2)
    assert (controls.preset, controls.changed) == ("Thesis", ["cost_exponent"])
    controls.use_preset("Thesis")
    assert controls.changed == []
    with pytest.raises(ValueError, match="name must be one of 'Default', 'Thesis', got 'None'"):
        controls.use_preset("None")


def test_its_repr_is_the_code(controls):
    controls.set("n_segments", 12)
    assert repr(controls) == "ParamsControls(sw.Params(n_segments=12))"


def test_movements_and_what_else_people_do_is_told(controls):
    told = []
    controls.connect(
        on_move=lambda name, params: told.append((name, params.cost_exponent)),
        on_leave=lambda: told.append("leave"),
        on_rerun=lambda: told.append("rerun"),
    )
    before = controls.params
    controls._handle(None, {"kind": "move", "name": "cost_exponent", "value": 1.5}, [])
    controls._handle(None, {"kind": "move", "name": "cost_exponent", "value": -1}, [])
    controls._handle(None, {"kind": "leave"}, [])
    controls._handle(None, {"kind": "rerun"}, [])
    controls._handle(None, {"kind": "set", "name": "cost_exponent", "value": before.cost_exponent}, [])
    assert told == [("cost_exponent", 1.5), "leave", "rerun", "leave"]
    assert controls.params is before
