"""Arrows and lines as triangles."""

import numpy as np
import pytest
from shapes import grid_square, icosphere

from scenewidget.figures.strokes import edge_segments, isoline_segments, needles, ribbons


def test_needles_reach_from_start_to_tip_and_face_outwards():
    starts, vectors = np.array([[1.0, 2, 3], [0, 0, 0]]), np.array([[0, 0, 2.0], [0, 0, 0]])
    triangles = needles(starts, vectors, 0.1)
    assert triangles.shape == (3, 3, 3)  # none for the vector without length
    assert np.isclose(triangles, [1, 2, 5]).all(axis=2).sum() == 3
    out = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (((triangles.mean(axis=1) - [1, 2, 3.5]) * out).sum(axis=1) > 0).all()


def test_isolines_lie_at_their_level_and_measure_its_length():
    mesh = grid_square(9)
    corners = mesh.vertices[mesh.faces]
    ends, triangle = isoline_segments(corners, corners[..., 0], np.array([0.25, 0.6]))
    np.testing.assert_allclose(np.unique(ends[..., 0].round(12)), [0.25, 0.6])
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(2.0)
    low, high = corners[triangle].min(axis=1), corners[triangle].max(axis=1)
    assert ((ends.mean(axis=1) >= low - 1e-12) & (ends.mean(axis=1) <= high + 1e-12)).all()


def test_isolines_leave_out_what_is_not_a_number():
    mesh = grid_square(4)
    corners = mesh.vertices[mesh.faces]
    values = np.where(corners[..., 1] > 0.4, np.nan, corners[..., 0])
    ends, _ = isoline_segments(corners, values, np.array([0.3]))
    assert np.isfinite(ends).all()
    assert ends[..., 1].max() <= 0.25


def test_every_edge_is_drawn_once():
    mesh = icosphere(2)
    ends, _ = edge_segments(mesh.faces, mesh.vertices[mesh.faces])
    assert len(ends) == mesh.n_faces * 3 // 2
    assert len(np.unique(np.sort(ends.round(9), axis=1).reshape(-1, 6), axis=0)) == len(ends)


def test_ribbons_have_their_width_lie_in_front_and_face_the_same_way():
    segments = np.array([[[0.0, 0, 0], [1, 0, 0]]]), np.array([0])
    one_side = ribbons(segments, np.array([[0.0, 0, 1]]), 0.1, both_sides=False)
    across = np.cross(one_side[:, 1] - one_side[:, 0], one_side[:, 2] - one_side[:, 0])
    np.testing.assert_allclose(across.sum(axis=0) / 2, [0, 0, 0.1], atol=1e-12)
    assert (one_side[..., 2] == 0.05).all()
    both = ribbons(segments, np.array([[0.0, 0, 1]]), 0.1, both_sides=True)
    across = np.cross(both[:, 1] - both[:, 0], both[:, 2] - both[:, 0])
    np.testing.assert_allclose(across[:, 2], [0.1, 0.1, -0.1, -0.1], atol=1e-12)
