"""Which way is up, found by the surface or said by a person."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import grid_square

from scenewidget import datasets
from scenewidget.engine.mesh import Mesh
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.upright import AXES, checked_up, up_vector


@pytest.fixture(scope="module")
def rooms():
    return [datasets.simulate_room(seed=seed, voxel=0.08)[0] for seed in range(3)]


def turned(mesh: Mesh, up: str) -> Mesh:
    """The mesh with its z axis along another one; a proper rotation."""
    z = np.array(AXES[up])
    x = np.roll(z, 1) * (1 if z.sum() > 0 else -1)
    return Mesh(mesh.vertices @ np.stack([x, np.cross(z, x), z]), mesh.faces)


def test_where_nothing_tells_a_bar_asks_until_the_picture_is_said_to_be_right():
    view = SceneView(grid_square(4))
    assert not view._asks_up  # a picture alone asks nobody
    view.ask_up()
    assert view._asks_up
    view._hear_of_up(view, {"kind": "choose", "notice": "up", "action": "-y"}, [])
    assert (view._asks_up, view.up, view._up) == (True, "-y", [0, -1, 0])
    for nonsense in ("sideways", None, ["x"]):
        view._hear_of_up(view, {"kind": "choose", "notice": "up", "action": nonsense}, [])
    assert view.up == "-y"
    view._hear_of_up(view, {"kind": "choose", "notice": "up", "action": "drop"}, [])
    assert not view._asks_up
    said = SceneView(grid_square(4), up="y")
    said.ask_up()
    assert not said._asks_up


def test_rooms_are_upright_whichever_axis_is_up(rooms):
    assert [up_vector("auto", turned(room, up)) for room, up in zip(2 * rooms, AXES)] == list(AXES.values())


def test_what_does_not_tell_takes_z():
    assert up_vector("auto", grid_square(4)) == AXES["z"]


@given(st.tuples(*3 * [st.floats(-5, 5)]).filter(lambda up: np.linalg.norm(up) > 1e-3))
def test_any_vector_can_be_said(up):
    assert checked_up(list(up)) == up
    view = SceneView(grid_square(2), up=up)
    np.testing.assert_allclose(view._up, np.array(up) / np.linalg.norm(up), atol=1e-12)


@pytest.mark.parametrize("wrong", ["up", "", (0, 0, 0), (1, 2), (1, 2, np.nan), 3, None])
def test_what_is_no_direction_is_refused(wrong):
    with pytest.raises(ValueError, match=r"up must be one of 'auto', 'x', .* or a vector"):
        checked_up(wrong)


def test_up_can_be_changed_and_what_was_found_can_be_asked(rooms):
    view = SceneView(turned(rooms[0], "-y"))
    assert (view.up, view._up) == ("auto", [0.0, -1.0, 0.0])
    view.up = "x"
    assert view._up == [1.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="up must be one of"):
        view.up = "sideways"
    assert view.up == "x"
