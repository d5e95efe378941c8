from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.datasets import shapes
from scenewidget.datasets.shapes import Shape


def cloud(n: int = 4000, *, reach: float = 1.0, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-reach, reach, (3, n)).astype(np.float32)


EXACT: dict[str, Shape] = {
    "ball": shapes.ball([0.1, 0, -0.1], 0.4),
    "box": shapes.box([-0.3, -0.2, -0.4], [0.3, 0.5, 0.1]),
    "rounded box": shapes.box([-0.3, -0.2, -0.4], [0.3, 0.5, 0.1], 0.1),
    "cylinder": shapes.cylinder([0.1, 0.2, -0.3], 0.5, 0.3),
    "cone": shapes.cone([0, 0, -0.4], 0.7, 0.4, 0.1),
    "rod": shapes.rod([-0.3, 0.1, 0], [0.4, -0.2, 0.5], 0.1),
    "torus": shapes.torus([0, 0, 0.1], 0.4, 0.15),
    "half space": shapes.half_space([0, 0, 0.1], [1, 2, 2]),
    "box row": shapes.box_row(
        np.array([0.0, 0.3, 0.6]), np.array([0.4, 0.4]), np.array([0.3, 0.3]), [-0.3, 0, 0]
    ),
}
BOUNDED: dict[str, Shape] = {
    **EXACT,
    "tapered rod": shapes.rod([-0.3, 0.1, 0], [0.4, -0.2, 0.5], 0.05, 0.1),
    "ellipsoid": shapes.ellipsoid([0.1, 0, 0], [0.5, 0.3, 0.2]),
    "leaf": shapes.ellipsoid([0, 0, 0.1], [0.1, 0.24, 0.018]),
    "cushion": shapes.cushion([-0.4, -0.3, -0.1], [0.4, 0.3, 0.1]),
    "curtain": shapes.wavy_sheet([-0.5, -0.1, -0.8], [0.5, 0.1, 0.8], 6, 0.03),
    "cup": shapes.cup([0, 0, -0.3], 0.6, 0.3, 0.2, 0.05, 0.1),
    "blend": shapes.smooth_union(0.2, shapes.ball([0, 0, 0], 0.3), shapes.box([0, 0, 0], [0.5, 0.4, 0.3])),
    "ribs": shapes.repeated(shapes.box([-0.02, -0.1, -0.3], [0.02, 0.1, 0.3], 0.01), 0, 7, 0.06),
    "rough ball": shapes.displaced(
        shapes.ball([0, 0, 0], 0.5), 0.01, shapes.ripples(np.random.default_rng(0), 0.3)
    ),
}


def test_distance_to_a_ball_is_that_to_its_middle_less_the_radius():
    points = cloud()
    expected = np.linalg.norm(points - [[0.1], [0], [-0.1]], axis=0) - 0.4
    np.testing.assert_allclose(EXACT["ball"].distance(points), expected, atol=1e-6)


def test_distance_to_a_box_is_that_to_its_nearest_point():
    points = cloud()
    low, high = np.array([[-0.3], [-0.2], [-0.4]]), np.array([[0.3], [0.5], [0.1]])
    outside = np.linalg.norm(points - np.clip(points, low, high), axis=0)
    inside = np.minimum(points - low, high - points).min(axis=0)
    expected = np.where(outside > 0, outside, -inside)
    np.testing.assert_allclose(EXACT["box"].distance(points), expected, atol=1e-6)


@pytest.mark.parametrize("name", EXACT)
def test_distances_grow_by_at_most_a_metre_a_metre_and_mostly_by_one(name):
    shape, points, others = EXACT[name], cloud(), cloud(seed=1)
    gap = np.linalg.norm(points - others, axis=0)
    assert (np.abs(shape.distance(points) - shape.distance(others)) <= gap + 1e-5).all()
    step = 1e-3 * np.eye(3, dtype=np.float32)[:, :, None]
    rise = np.stack([shape.distance(points + s) - shape.distance(points - s) for s in step])
    assert np.median(np.linalg.norm(rise, axis=0)) / 2e-3 == pytest.approx(1, abs=1e-2)


@pytest.mark.parametrize("name", BOUNDED)
def test_distances_never_overestimate(name):
    # or else blocks of space that hold a surface would be skipped
    shape, points = BOUNDED[name], cloud()
    distance = shape.distance(points)
    surface = points[:, np.abs(distance) < 0.01]
    for point, claimed in zip(points.T[:200], distance[:200], strict=True):
        nearest = np.linalg.norm(surface.T - point, axis=1).min()
        assert abs(claimed) < 1.15 * (nearest + 0.01)


@pytest.mark.parametrize("name", [name for name in BOUNDED if name != "half space"])
def test_bounds_hold_all_that_is_solid(name):
    shape = BOUNDED[name]
    solid = cloud(20_000)[:, shape.distance(cloud(20_000)) < 0]
    assert solid.shape[1] > 0
    assert (solid.min(axis=1) >= shape.low - 1e-6).all()
    assert (solid.max(axis=1) <= shape.high + 1e-6).all()


@pytest.mark.parametrize("name", ["box", "cone", "curtain", "box row"])
@given(turn=st.floats(-7, 7), offset=st.tuples(*[st.floats(-1, 1)] * 3))
def test_moving_a_shape_moves_its_distances_and_bounds(name, turn, offset):
    shape, points = BOUNDED[name], cloud(300)
    cos, sin = np.cos(turn), np.sin(turn)
    there = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]) @ points + np.array(offset)[:, None]
    moved = shape.moved(offset, turn)
    np.testing.assert_allclose(moved.distance(there.astype(np.float32)), shape.distance(points), atol=1e-5)
    solid = there[:, shape.distance(points) < 0]
    assert (solid >= moved.low[:, None] - 1e-6).all()
    assert (solid <= moved.high[:, None] + 1e-6).all()


def test_a_positive_tilt_leans_the_top_backwards():
    post = shapes.box([-0.1, -0.1, 0], [0.1, 0.1, 1]).tilted(0.5)
    top = np.array([[0], [-0.95 * np.sin(0.5)], [0.95 * np.cos(0.5)]], dtype=np.float32)
    assert post.distance(top)[0] < 0
    assert post.low[1] < -0.4


@pytest.mark.parametrize(
    ("combine", "expected"),
    [
        (shapes.union, np.minimum),
        (shapes.overlap, np.maximum),
        (shapes.cut, lambda a, b: np.maximum(a, -b)),
    ],
)
def test_combinations_follow_the_algebra_of_sets(combine: Callable[..., Shape], expected):
    a, b, points = EXACT["ball"], EXACT["box"], cloud()
    np.testing.assert_array_equal(
        combine(a, b).distance(points), expected(a.distance(points), b.distance(points))
    )


def test_a_smooth_union_only_adds_and_only_near_the_seam():
    a, b, points = shapes.ball([0, 0, 0], 0.3), shapes.ball([0.4, 0, 0], 0.3), cloud()
    plain = np.minimum(a.distance(points), b.distance(points))
    smooth = shapes.smooth_union(0.1, a, b).distance(points)
    assert (smooth <= plain + 1e-6).all()
    assert (plain - smooth).max() <= 0.025 + 1e-6
    is_far = np.abs(a.distance(points) - b.distance(points)) > 0.1
    np.testing.assert_allclose(smooth[is_far], plain[is_far], atol=1e-6)


def test_ripples_have_unit_strength():
    field = shapes.ripples(np.random.default_rng(3), 0.3)
    assert field(cloud(50_000, reach=5)).std() == pytest.approx(1, rel=0.05)
