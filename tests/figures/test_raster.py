"""Which pixels a triangle covers, and in which colour."""

import numpy as np
import pytest

from scenewidget.figures.raster import FIELD_OF_VIEW, Camera, render

RED, BLUE = [255, 0, 0], [0, 0, 255]


def flat_colors(n, color):
    return np.tile(np.array(color, np.uint8), (n, 3, 1))


def facing(triangles):
    """Triangles given in the picture's own axes (right, up, towards the camera), seen along −x."""
    right, up, towards = np.moveaxis(np.asarray(triangles, float), -1, 0)
    return np.stack([towards, right, up], axis=-1), Camera(0.0, 0.0, 10.0)


def half_height(distance):
    return distance * np.tan(np.radians(FIELD_OF_VIEW / 2))


def test_a_triangle_covers_the_pixels_that_it_should():
    h = half_height(10.0)
    corners, camera = facing([[[-h, -h, 0], [h, -h, 0], [-h, h, 0]]])  # below the falling diagonal
    picture = render(corners, flat_colors(1, RED), camera, width=40, height=40, supersampling=1)
    row, column = np.indices((40, 40))
    is_red = (picture == RED).all(axis=2)
    np.testing.assert_array_equal(is_red, column <= row)
    assert (picture[~is_red] == 255).all()


def test_coverage_is_the_area_of_the_projection():
    rng = np.random.default_rng(0)
    h = half_height(10.0)
    for triangle in rng.uniform(-0.9 * h, 0.9 * h, (5, 3, 2)):
        corners, camera = facing(np.concatenate([triangle, np.zeros((3, 1))], axis=1)[None])
        picture = render(corners, flat_colors(1, [0, 0, 0]), camera, width=200, height=200)
        (a, b), (c, d) = triangle[1] - triangle[0], triangle[2] - triangle[0]
        expected = abs(a * d - b * c) / 2 * (100 / h) ** 2
        assert (1 - picture[..., 0] / 255).sum() == pytest.approx(expected, rel=0.02, abs=8)


def test_the_nearer_triangle_hides_the_farther_in_whatever_order():
    wide = [[-9, -9], [9, -9], [0, 9]]
    near, far = (np.column_stack([wide, np.full(3, towards)]) for towards in (2.0, -2.0))
    for order in ((near, far), (far, near)):
        corners, camera = facing(order)
        colors = np.concatenate([flat_colors(1, RED if layer is near else BLUE) for layer in order])
        assert (render(corners, colors, camera, width=20, height=20)[10, 10] == RED).all()


def test_triangles_that_cross_are_each_seen_where_they_are_nearer():
    corners, camera = facing(
        [
            [[-9, -9, -3], [9, -9, 3], [9, 9, 3]],
            [[-9, -9, -3], [9, 9, 3], [-9, 9, -3]],
            [[-9, -9, 0], [9, -9, 0], [0, 20, 0]],
        ]
    )
    colors = np.concatenate([flat_colors(2, RED), flat_colors(1, BLUE)])
    picture = render(corners, colors, camera, width=40, height=40)
    assert (picture[20, 5] == BLUE).all()
    assert (picture[20, 35] == RED).all()


def test_back_faces_are_hidden_on_demand():
    corners, camera = facing([[[-9, -9, 0], [0, 9, 0], [9, -9, 0]]])  # clockwise
    shown = render(corners, flat_colors(1, RED), camera, width=20, height=20)
    hidden = render(corners, flat_colors(1, RED), camera, width=20, height=20, hides_back=True)
    assert (shown[12, 10] == RED).all()
    assert (hidden == 255).all()


def test_colours_are_linear_on_the_triangle_also_in_perspective():
    corners, camera = facing([[[-1, -1, -4], [1, -1, 4], [-1, 1, -4]]])
    colors = np.array([[[0, 0, 0], [255, 255, 255], [0, 0, 0]]], np.uint8)
    picture = render(corners, colors, camera, width=400, height=400, background=(7, 0, 0), supersampling=1)
    # the point halfway between the first two corners is at depth 10, right 0, up -1
    row = int(200 + 200 / half_height(10.0)) - 1
    assert int(picture[row, 200, 0]) == pytest.approx(127, abs=3)


def test_triangles_behind_the_camera_and_none_at_all_leave_the_background():
    corners, camera = facing([[[-1, -1, 12], [1, -1, 12], [0, 1, 12]]])
    assert (render(corners, flat_colors(1, RED), camera, width=8, height=6) == 255).all()
    nothing = render(np.zeros((0, 3, 3)), np.zeros((0, 3, 3), np.uint8), camera, width=8, height=6)
    assert nothing.shape == (6, 8, 3)
    assert (nothing == 255).all()
