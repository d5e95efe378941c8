"""The picture that stands in for a figure, its camera and its colour bar."""

import io

import numpy as np
import pytest
from PIL import Image
from shapes import box, icosphere, joined

from scenewidget.figures.drawing import draw
from scenewidget.figures.picture import camera_for, color_bar, png
from scenewidget.figures.raster import FIELD_OF_VIEW, Camera, render
from scenewidget.figures.scale import color_scale


@pytest.mark.parametrize("view", [(-60, 30), (10, 89), (200, -35)])
@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.8])
def test_the_camera_fits_everything_into_the_middle(view, aspect):
    points = box(3, size=(1, 2, 0.5)).vertices + np.array([0.3, 0.0, 0.1])
    camera = Camera.fitting(points, view, aspect)
    x, y, towards = ((points - camera.position) @ camera.axes.T).T
    half = -towards * np.tan(np.radians(FIELD_OF_VIEW / 2))
    across, up = x / half / aspect, y / half
    assert max(abs(across).max(), abs(up).max()) == pytest.approx(0.93, abs=0.02)
    assert across.min() == pytest.approx(-across.max(), abs=0.02)
    assert up.min() == pytest.approx(-up.max(), abs=0.02)


def test_the_colour_bar_ends_in_the_colours_of_the_ends():
    scale = color_scale(np.array([2.0, 5.0]))
    bar = color_bar(scale, 50)
    np.testing.assert_array_equal(bar[[0, -1]], scale.colors([2.0, 5.0]))
    np.testing.assert_array_equal(scale.colors([-100.0, 100.0]), bar[[0, -1]])
    assert scale.ticks() == ["2", "3.5", "5"]
    lightness = bar @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) > -1).all()


def test_the_picture_shows_what_the_camera_sees():
    mesh = joined(box(1), box(1), gap=3.0)
    drawing = draw(mesh, np.repeat([0, 1], 12))
    picture = render(
        drawing.corners, drawing.colors, camera_for([drawing], (-90, 0), 2.0), width=200, height=100
    )
    left, right = picture[50, 40], picture[50, 160]
    assert (left != right).any()
    assert (picture[50, 100] == 255).all()


def test_a_mark_keeps_its_red_among_many_other_colours():
    ball = icosphere(4)
    drawing = draw(
        ball, values=ball.vertices[:, 0], colormap="viridis_r", points=[int(ball.vertices[:, 2].argmax())]
    )
    picture = png([drawing], view=(-60, 30), width=480, height=360)
    r, g, b = np.moveaxis(np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), int), -1, 0)
    assert ((r > 100) & (r > 3 * g) & (r > 3 * b)).sum() > 20
