"""The curve through space: each point once, and steps along it that are short."""

import numpy as np

from scenewidget.engine.curve import along_curve


def test_the_curve_visits_each_point_once_by_short_steps():
    points = np.random.default_rng(0).random((4_000, 3))
    order = along_curve(points)
    assert sorted(order.tolist()) == list(range(4_000))
    steps = np.linalg.norm(np.diff(points[order], axis=0), axis=1)
    assert steps.mean() < 0.2 * np.linalg.norm(np.diff(points, axis=0), axis=1).mean()


def test_points_at_one_place_keep_their_order():
    assert along_curve(np.zeros((5, 3))).tolist() == [0, 1, 2, 3, 4]
