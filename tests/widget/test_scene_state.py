"""State of a picture: what may be set to what."""

import copy
import pickle

import pytest

from scenewidget.widget.scene_state import SceneState, option_names, own_names


@pytest.fixture
def state():
    return SceneState()


@pytest.mark.parametrize("section", [[(0, 1), (0.5, 0.5), (0, 1)], [(0, 1), (0, 1.5), (0, 1)]])
def test_a_section_that_is_none_is_refused(state, section):
    with pytest.raises(ValueError, match=r"section must hold pairs 0 <= low < high <= 1, got"):
        state.section = section
    assert state.section == [(0, 1)] * 3


def test_another_colour_leaves_the_column(state):
    state.set_trait("columns", ["area"])
    with pytest.raises(ValueError, match="column must be one of 'area', got 'volume'"):
        state.column = "volume"
    state.color_by, state.column = "values", "area"
    state.color_by = "normals"
    assert state.column == ""


def test_what_the_front_end_alone_reads_is_no_option():
    assert {"color_by", "height", "up"} <= set(option_names()) < set(own_names())
    assert not any(name.startswith("_") for name in own_names())
    assert "revision" not in option_names()  # told by Python alone


@pytest.mark.parametrize(
    ("name", "value", "way"),
    [
        ("levels", ["base"], r"write view.set_segments\("),
        ("columns", ["area"], r"write view.offer_columns\("),
        ("segment_names", {"0": "floor"}, r"write session.relabel\("),
        ("segment_groups", {"0": 1}, r"write session.group\("),
        ("values_legend", {"title": "", "low": 0}, r"write view.set_values\("),
        ("suggestion", {"edit": {"kind": "merge"}}, r"session.suggestions\(\) finds them"),
    ],
)
def test_a_change_inside_of_what_is_told_is_refused(state, name, value, way):
    state.set_trait(name, value)
    held = getattr(state, name)
    inside = [held["edit"].clear] if "edit" in value else []
    for change in (held.clear, lambda: held.__setitem__(0, 1), lambda: held.pop(0), *inside):
        with pytest.raises(TypeError, match=f"isn't noticed; {way}"):
            change()
    assert held == getattr(state, name) == copy.deepcopy(held) == pickle.loads(pickle.dumps(held)) == value


@pytest.mark.parametrize("name", ["section", "vocabulary", "quick_names"])
def test_a_change_inside_of_a_list_is_refused(state, name):
    setattr(state, name, [(0, 1)] * 3 if name == "section" else ["chair"])
    held = getattr(state, name)
    for change in (lambda: held.append("lamp"), lambda: held.__setitem__(0, (0, 0.5)), held.clear):
        with pytest.raises(TypeError, match="isn't noticed; set the whole"):
            change()
    assert held == getattr(state, name) == copy.deepcopy(held) == pickle.loads(pickle.dumps(held))
