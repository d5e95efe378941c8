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


def test_the_modes_of_a_basis_swing_at_the_root_of_their_eigenvalue():
    sheet = grid_square(8)
    basis = eigenbasis(sheet, 6)
    _, handles = figures.vibration(sheet, basis, start=1).widget.children
    action, slider = handles.children
    assert action.timeScale == pytest.approx(1.0)
    for i in (3, 5):
        slider.value = i
        assert action.timeScale == pytest.approx(np.sqrt(basis.values[i] / basis.values[1]))
    slider.value = 0
    assert action.timeScale == 0.0  # the constant function is no vibration
    with pytest.raises(ValueError, match="of the whole mesh, got one per component"):
        figures.vibration(sheet, eigenbasis(sheet, 4, per_component=True))
