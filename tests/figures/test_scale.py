"""From numbers to colours."""

import numpy as np

from scenewidget.figures.scale import color_scale


def test_numbers_of_both_signs_are_centred_at_zero():
    scale = color_scale(np.array([-1.0, 3.0]))
    assert (scale.low, scale.high) == (-3.0, 3.0)
    assert scale.colors([0.0]).min() > 230
    assert color_scale(np.array([-0.001, 3.0])).low == -0.001  # noise below zero is not a sign


def test_what_is_not_a_number_is_grey():
    colors = color_scale(np.array([0.0, 1.0])).colors([np.nan, np.inf])
    assert (colors == colors[:, :1]).all()


def test_constant_and_empty_values_have_a_scale():
    assert color_scale(np.full(3, 2.0)).colors(np.full(3, 2.0)).shape == (3, 3)
    assert color_scale(np.full(3, np.nan)).low == 0.0
