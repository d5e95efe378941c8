"""Every option of `Params`: its kind, its range, its name."""

import dataclasses
import inspect
import math

import pytest

from scenewidget.engine.params import _RANGES, CHOICES, Params

NAMES = [field.name for field in dataclasses.fields(Params)]
WHOLE = [name for name in _RANGES if name.startswith("n_") or name in ("filter_sweeps", "seed")]


def test_every_option_is_checked_and_documented():
    special = {"n_segments", "k_range", "convex_weights", "merge", "join_planes", "drop_torn", "granularity"}
    assert set(NAMES) == set(CHOICES) | set(_RANGES) | special
    for name in NAMES:
        assert name in Params.__doc__


@pytest.mark.parametrize("name", sorted(CHOICES))
def test_an_unknown_choice_is_refused_with_the_choices(name):
    for value in ("no such thing", 3, None, ["fast"]):
        with pytest.raises(ValueError, match=f"{name} must be one of '{CHOICES[name][0]}'"):
            Params(**{name: value})
    for choice in CHOICES[name]:
        assert getattr(Params(**{name: choice}), name) == choice


@pytest.mark.parametrize("name", sorted(_RANGES))
def test_a_number_out_of_range_is_refused_and_the_ends_are_in(name):
    low, high = _RANGES[name]
    for value in (low - 1, high + 1, math.nan, math.inf):
        if isinstance(value, float) and name in WHOLE and not value.is_integer():
            continue
        with pytest.raises((ValueError, TypeError), match=f"{name} must"):
            Params(**{name: int(value) if name in WHOLE and math.isfinite(value) else value})
    for value in (low, high):
        if math.isfinite(value):
            assert getattr(Params(**{name: value}), name) == value


@pytest.mark.parametrize("name", sorted(_RANGES))
@pytest.mark.parametrize("value", ["3", None, True, [3], 1j])
def test_what_is_no_number_is_refused(name, value):
    with pytest.raises(TypeError, match=f"{name} must be a (whole )?number, got"):
        Params(**{name: value})


@pytest.mark.parametrize("name", WHOLE)
def test_counts_are_whole(name):
    with pytest.raises(TypeError, match=f"{name} must be a whole number, got 2.5"):
        Params(**{name: 2.5})


@pytest.mark.parametrize("name", ["merge", "join_planes", "drop_torn"])
def test_switches_are_true_or_false(name):
    for value in (1, "yes", None):
        with pytest.raises(TypeError, match=f"{name} must be True or False"):
            Params(**{name: value})


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"n_segments": 0}, ValueError, r"n_segments must lie in 1\.\."),
        ({"granularity": 0}, ValueError, r"granularity must lie in 1\.\."),
        ({"granularity": "fine"}, TypeError, "granularity must be a whole number"),
        ({"n_segments": 3.0}, TypeError, "n_segments must be a whole number"),
        ({"n_segments": True}, TypeError, "n_segments must be a whole number"),
        ({"n_segments": "automatic"}, TypeError, "n_segments must be a whole number"),
        ({"k_range": 5}, TypeError, r"k_range must be None or two whole numbers \(least, most\), got 5"),
        ({"k_range": (5,)}, TypeError, "k_range must be None or two"),
        ({"k_range": (5, 4)}, ValueError, r"k_range must be \(least, most\), got \(5, 4\)"),
        ({"k_range": (0, 4)}, ValueError, "k_range must lie in"),
        ({"k_range": (1.5, 4)}, TypeError, "k_range must be a whole number"),
        ({"convex_weights": 0.5}, TypeError, "convex_weights must be a tuple"),
        ({"convex_weights": ()}, TypeError, "convex_weights must be a tuple"),
        ({"convex_weights": (0.5, -1)}, ValueError, "convex_weights must be positive"),
        ({"convex_weights": (math.nan,)}, ValueError, "convex_weights must be positive"),
        ({"convex_weights": ("a",)}, ValueError, "convex_weights must be positive"),
        ({"n_runs": 0, "n_graph_runs": 0}, ValueError, "an ensemble needs a member"),
    ],
)
def test_other_bad_values_are_refused(options, error, message):
    with pytest.raises(error, match=message):
        Params(**options)


def test_a_typo_gets_a_suggestion():
    with pytest.raises(TypeError, match="no option 'n_segment'; did you mean 'n_segments'"):
        Params().replace(n_segment=3)
    with pytest.raises(TypeError, match="no option 'zzz'; options are n_segments, k_range"):
        Params().replace(zzz=3)
    with pytest.raises(TypeError, match="no option 'cost_exponant'; did you mean 'cost_exponent'"):
        Params.thesis(cost_exponant=1.0)
    with pytest.raises(TypeError, match="no option 'n_segment'; did you mean 'n_segments'"):
        Params(n_segment=3)
    with pytest.raises(TypeError, match="options by name only"):
        Params(3)
    assert "n_segments" in inspect.signature(Params).parameters


def test_params_are_frozen_values():
    params = Params(k_range=[3, 4], convex_weights=[1, 2])
    assert params.k_range == (3, 4)
    assert params.convex_weights == (1.0, 2.0)
    assert hash(params) == hash(Params().replace(k_range=(3, 4), convex_weights=(1.0, 2.0)))
    assert params.replace() == params
    with pytest.raises(dataclasses.FrozenInstanceError):
        params.n_segments = 3


def test_k_follows_s_unless_given():
    assert Params(n_segments=30).k_bounds == (60, 75)
    assert Params(n_segments="auto").k_bounds == (100, 125)
    assert Params(n_segments=30, k_range=(4, 9)).k_bounds == (4, 9)


def test_the_faithful_preset_is_that_of_the_thesis():
    thesis = Params.thesis()
    assert (thesis.n_segments, thesis.k_bounds, thesis.n_items) == (50, (100, 125), 10_000)
    assert (thesis.cost_a, thesis.cost_b, thesis.cost_exponent) == (1, -1, 1.5)
    assert (thesis.feature, thesis.items, thesis.consensus, thesis.leftover) == (
        "cotangent",
        "simplified",
        "peac",
        "alone",
    )
    assert (thesis.merge, thesis.merge_flatness, thesis.merge_normal, thesis.merge_seam) == (
        True,
        0.008,
        0.99,
        0.99,
    )
    assert (thesis.feature_floor, thesis.hop, thesis.convex_weights) == (0, 0, (1.0,))
    assert (thesis.relief, thesis.contrast, thesis.furniture_similarity) == (0, 0, 1)
    assert (thesis.n_graph_runs, thesis.join_planes, thesis.min_area, thesis.n_slots) == (0, False, 0, 64)
    assert Params.thesis(n_segments=30, feature="gps").feature == "gps"
