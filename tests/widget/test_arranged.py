"""Heights in layouts are those of pictures."""

import ipywidgets
import pytest

import scenewidget as sw
from scenewidget.datasets import analytic

MESH = analytic.square(2)


@pytest.fixture
def view():
    made = sw.SceneView(MESH)
    yield made
    made.close()


@pytest.mark.parametrize(("given", "height"), [("300px", 300), (" 410.5px ", 410), ("250", 250)])
def test_a_height_given_to_the_layout_is_the_pictures(view, given, height):
    view.layout.height = given
    assert (view.height, view.layout.height) == (height, None)


def test_so_is_that_of_another_layout(view):
    view.layout = ipywidgets.Layout(height="333px", width="50%")
    assert (view.height, view.layout.height, view.layout.width) == (333, None, "50%")
    view.layout = {"height": "222px"}
    assert (view.height, view.layout.height) == (222, None)


@pytest.mark.parametrize("given", ["50%", "20em", "40vh"])
def test_other_lengths_are_refused(view, given):
    with pytest.raises(
        ValueError, match=rf"layout.height of a SceneView is in pixels, got '{given}'; write h"
    ):
        view.layout.height = given
    assert (view.height, view.layout.height) == (560, None)


@pytest.mark.parametrize("name", ["min_height", "max_height"])
def test_least_and_most_heights_are_refused(view, name):
    with pytest.raises(
        ValueError, match=rf"layout.{name} of a SceneView would not change .* '300px'; write h"
    ):
        setattr(view.layout, name, "300px")
    assert (view.height, getattr(view.layout, name)) == (560, None)
    setattr(view.layout, name, "none")


def test_words_of_css_stay_in_the_layout(view):
    view.layout.height = "auto"
    assert (view.height, view.layout.height) == (560, "auto")
