"""Warnings point at the line that called the package, not into it."""

import inspect
import warnings

import pytest
import shapes

from scenewidget.engine.checks import checked_count
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import segment


def test_a_warning_names_the_callers_line():
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        line = inspect.currentframe().f_lineno + 1
        segment(shapes.fragments(300), Params.thesis())
    few = [w for w in heard if "faces are labeled" in str(w.message)]
    assert [(w.filename, w.lineno) for w in few] == [(__file__, line)]


def test_a_warning_of_the_first_stage_names_it_too():
    with pytest.warns(UserWarning, match="thresholds are in metres") as heard:
        segment(shapes.box(2, size=(4000.0, 3000.0, 2400.0)))
    assert {w.filename for w in heard} == {__file__}


def test_leftovers_come_with_advice():
    ball = shapes.icosphere(3)  # nothing to agree on
    params = Params.thesis(n_segments=3, k_range=(40, 60), merge=False, feature_floor=0.05)
    with pytest.warns(UserWarning, match="raise n_segments, or .*leftover='argmax'.*leftover='linkage'"):
        segment(ball, params)


@pytest.mark.parametrize("value", [2.0, "2", None, True])
def test_only_whole_numbers_count(value):
    with pytest.raises(TypeError, match="k must be a whole number"):
        checked_count("k", value)


def test_counts_have_bounds():
    assert checked_count("k", 3, most=3) == 3
    with pytest.raises(ValueError, match="k must be at least 1, got 0"):
        checked_count("k", 0)
    with pytest.raises(ValueError, match="k must be at most 3, got 4"):
        checked_count("k", 4, most=3)
