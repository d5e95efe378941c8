"""What there is to set: words, reasons, code."""

import dataclasses
import json

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.engine.stages import stages
from scenewidget.widget.settings import (
    PRESETS,
    SETTINGS,
    changes_from,
    idle_reasons,
    nearest_preset,
    params_code,
)

NAMES = [setting.name for setting in SETTINGS]
MESH, _ = shapes.room(8, noise=0.003)
OTHER_VALUES = {
    "n_segments": [5, "auto"],
    "k_range": [None, (9, 14)],
    "feature": ["normals", "cotangent", "hks"],
    "items": ["superfacets", "simplified"],
    "consensus": ["linkage", "median", "peac"],
    "n_runs": [0, 3],
    "merge": [False, True],
}
CHANGES = {  # another value for each option
    "n_segments": 7, "k_range": (8, 12), "cost_exponent": 1.3, "cost_a": 1.2, "cost_b": -0.8,
    "feature": "uniform", "items": "simplified", "n_items": 150, "simplifier": "qslim", "filter_sweeps": 5,
    "bridge": 0.01, "n_slots": 32, "slot_mapping": "angle",
    "drop_torn": True, "tolerance": 0.5, "medoid_ties": "first", "dihedral_order": "area",
    "laplacian": "robust", "n_eigenpairs": 12,
    "feature_floor": 0.2, "hop": 0.3, "convex_weights": (0.5,), "n_runs": 5,
    "n_graph_runs": 4, "init": "outmost", "allocation": "same", "merge": True, "merge_flatness": 0.02,
    "merge_normal": 0.9, "merge_seam": 0.9, "consensus": "median", "linkage_similarity": 0.4,
    "leftover": "argmax", "join_planes": False, "min_area": 0.3, "relief": 0.02, "contrast": 0.2,
    "furniture_similarity": 0.6, "granularity": 9, "seed": 4, "item_area": 0.05, "scale": 0.5,
}  # fmt: skip
pytestmark = pytest.mark.filterwarnings("ignore:.*:UserWarning")


def test_every_option_has_an_input_with_a_sentence_on_what_it_does():
    assert set(NAMES) == {field.name for field in dataclasses.fields(sw.Params)}
    for setting in SETTINGS:
        assert setting.tip.endswith((".", "^C."))
        assert ". " not in setting.tip
    json.dumps([setting.to_json() for setting in SETTINGS])


def test_features_given_can_be_seen_but_not_chosen_where_there_are_none():
    feature = next(setting for setting in SETTINGS if setting.name == "feature").to_json()
    reasons = {value: why for value, _, why in feature["choices"]}
    assert reasons.pop("given") == "only with features: sw.segment(mesh, params, features=…)"
    assert not any(reasons.values())


combinations = st.fixed_dictionaries({name: st.sampled_from(values) for name, values in OTHER_VALUES.items()})


@given(combinations)
@settings(max_examples=60)
def test_an_option_that_no_stage_looks_at_is_said_to_have_no_effect(options):
    params = sw.Params(n_graph_runs=3, n_items=200, **options)
    why = idle_reasons(params)
    table = stages(params)
    for name, value in CHANGES.items():
        if name in OTHER_VALUES:
            continue  # these decide on the others
        changed = stages(params.replace(**{name: value}))
        if changed[next(reversed(changed))].key == table[next(reversed(table))].key:
            assert name in why, (name, options)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"n_segments": "auto"},
        {"n_runs": 0},
        {"n_runs": 0, "consensus": "peac", "n_segments": "auto"},
        {"consensus": "median", "k_range": (8, 14)},
        {"consensus": "peac", "feature": "uniform"},
        {"items": "simplified", "feature": "hks", "merge": True},
    ],
)
def test_what_is_said_to_have_no_effect_has_none(options):
    params = sw.Params(**{"n_segments": 5, "n_runs": 3, "n_graph_runs": 3, "n_items": 200} | options)
    pipe = sw.Pipeline(MESH)
    expected = pipe.run(params)
    for name in idle_reasons(params):
        result = pipe.run(params.replace(**{name: CHANGES[name]}))
        np.testing.assert_array_equal(result.labels, expected.labels, name)
        np.testing.assert_array_equal(result.confidence, expected.confidence, name)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(
    "changes",
    [{}, {"n_segments": 12, "k_range": (8, 30)}, {"n_segments": "auto", "seed": 3, "cost_exponent": 1.75}],
)
def test_the_code_makes_the_parameters(preset, changes):
    params = PRESETS[preset].replace(**changes)
    assert eval(params_code(params), {"sw": sw}) == params
    assert nearest_preset(params) == preset
    assert set(changes_from(preset, params)) == set(changes) - {"n_segments", "seed"}
