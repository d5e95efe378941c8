"""Figures that people ask for, and what they are told when they ask wrongly."""

import inspect

import numpy as np
import pytest
from shapes import box, grid_square, icosphere

from scenewidget import figures
from scenewidget.datasets import analytic
from scenewidget.figures.drawing import draw


def test_side_by_side_shares_one_camera():
    row = figures.side_by_side([figures.show(icosphere(1)), figures.show(box(1, size=(5, 5, 5)))])
    first, second = row.panels
    assert first.renderer.camera is second.renderer.camera
    assert first.renderer.controls[0] is second.renderer.controls[0]
    assert repr(row) == "Figure(2 panels)"
    with pytest.raises(ValueError, match="at least one figure"):
        figures.side_by_side([])


def test_compare_shows_the_same_colours_for_the_same_parts():
    mesh = box(4)
    a = np.abs(mesh.face_normals).argmax(axis=1)
    renamed = np.array([7, 3, 5])[a]
    same = figures.compare(a, renamed, mesh)
    np.testing.assert_array_equal(same.drawings[0].colors, same.drawings[1].colors)
    assert same.drawings[2].title == "different: 0% of the area"
    other = np.where((a == 0) & (mesh.face_centroids[:, 0] > 0), 9, renamed)
    assert figures.compare(a, other, mesh).drawings[2].title == "different: 17% of the area"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: figures.show(m, labels=np.zeros(3, int)), r"labels must have shape \(8,\)"),
        (lambda m: figures.show(m, values=np.zeros(3)), r"values must have shape \(9,\)"),
        (lambda m: figures.show(m, vectors=np.zeros(9)), r"vectors must have shape \(9, 3\)"),
        (lambda m: figures.show(m, labels=np.zeros(8, int), values=np.zeros(8)), "one of them"),
        (lambda m: figures.show(m, values=np.zeros(8), colormap="rainbows"), "'rainbows'"),
        (lambda m: figures.show(m, values=np.zeros(8), low=2, high=1), "low must not be above high"),
        (lambda m: figures.show(m, points=[9]), r"points must lie in 0\.\.8"),
        (lambda m: figures.vibration(m, np.zeros(4)), "eigenfunction must have shape"),
        (lambda m: figures.vibration(m, np.zeros((9, 2)), start=2), r"start must lie in 0\.\.1"),
        (lambda m: figures.coassociation(np.zeros((2, 3))), "square"),
        (lambda m: figures.coassociation(np.eye(3), [0, 1]), r"labels must have shape \(3,\)"),
        (lambda m: analytic.square(3, triangulation="odd"), "'odd'"),
        (lambda m: analytic.paper_figure(7), "multiple of 10"),
        (lambda m: analytic.folded(m, "z", 0.5, 1.0), "'z'"),
    ],
)
def test_wrong_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(grid_square(2))


def test_wrong_kinds_are_named():
    with pytest.raises(TypeError, match="mesh must be a Mesh"):
        figures.show("room.ply")
    with pytest.raises(TypeError, match="labels must hold whole numbers"):
        figures.show(grid_square(2), labels=np.zeros(8))
    with pytest.raises(TypeError, match="points must be vertex numbers"):
        figures.show(grid_square(2), points=[0.5])


def test_the_signature_of_show_lists_every_option_of_a_drawing():
    shown, drawn = (inspect.signature(function).parameters for function in (figures.show, draw))
    assert shown.keys() - drawn.keys() == {"view", "width", "height"}
    assert drawn.keys() - shown.keys() == {"middle"}
    assert all(shown[name].default == drawn[name].default for name in shown.keys() & drawn.keys())
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        figures.show(box(2), colour="red")
