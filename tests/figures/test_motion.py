"""Eigenfunctions that swing."""

import numpy as np
import pytest
from shapes import grid_square, icosphere

from scenewidget import figures
from scenewidget.engine.operators import eigenbasis
from scenewidget.figures.motion import displaced


def test_a_vibration_moves_each_point_along_its_normal_by_the_eigenfunction():
    ball = icosphere(3)
    moved = displaced(ball, 0.1 * ball.vertices[:, 2])
    np.testing.assert_allclose(
        np.linalg.norm(moved.vertices, axis=1), 1 + 0.1 * ball.vertices[:, 2], atol=2e-3
    )
    figure = figures.vibration(ball, ball.vertices, start=2, amplitude=0.1, title="φ{i}")
    (drawing,) = figure.drawings
    np.testing.assert_allclose(drawing.corners[: ball.n_faces], moved.vertices[ball.faces], atol=2e-3)
    assert drawing.title == "φ2"


def test_the_browser_swings_between_rest_and_the_displaced_mesh():
    sheet = grid_square(6)
    phi = eigenbasis(sheet, 4).vectors
    box_of = figures.vibration(sheet, phi, start=1, amplitude=0.2).widget
    panel, handles = box_of.children
    action, slider = handles.children
    mesh = action.localRoot
    rest = mesh.geometry.attributes["position"].array
    (morph,) = mesh.geometry.morphAttributes["position"]
    assert np.abs(morph.array - rest).max() == pytest.approx(0.2, abs=1e-6)
    height = phi[:, 1] / np.abs(phi[:, 1]).max() * 0.2
    np.testing.assert_allclose((morph.array - rest)[:, 2], height[sheet.faces].ravel(), atol=1e-6)
    slider.value = 3
    height = phi[:, 3] / np.abs(phi[:, 3]).max() * 0.2
    np.testing.assert_allclose((morph.array - rest)[:, 2], height[sheet.faces].ravel(), atol=1e-6)
    assert panel is not None
