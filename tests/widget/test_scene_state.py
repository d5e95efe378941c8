"""State of a picture: what may be set to what."""

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
