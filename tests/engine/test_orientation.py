"""Which side is free space, and in which unit: on rooms and objects made by hand."""

import dataclasses
import warnings

import numpy as np
import pytest
import shapes
from patches import faces_as_items

import scenewidget as sw
from scenewidget.datasets.analytic import sphere
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.orientation import facing, oriented


def turned(mesh):
    return Mesh(mesh.vertices, mesh.faces[:, ::-1])


def room():
    """An empty room: a box seen from inside."""
    return turned(shapes.box(6, size=(5.0, 4.0, 2.5)))


def test_a_ball_looks_away_from_its_middle():
    ball = sphere(3)
    assert facing(faces_as_items(ball)) == pytest.approx(-1, abs=0.01)
    assert facing(faces_as_items(turned(ball))) == pytest.approx(1, abs=0.01)


def test_a_cube_has_the_value_of_the_integral():
    """⟨N, m − x⟩ is half the side on each face; |x − m| has the mean 0.6403 of it (numerical integral)."""
    x = (np.arange(400) + 0.5) / 400 - 0.5
    mean = np.sqrt(0.25 + x[:, None] ** 2 + x**2).mean()
    assert facing(faces_as_items(shapes.box(40, size=(1.0, 1.0, 1.0)))) == pytest.approx(
        -0.5 / mean, rel=1e-3
    )


@pytest.mark.parametrize(
    ("mesh", "found", "turns"),
    [
        (room(), "room, seen from inside", False),
        (turned(room()), "room, inside out: its normals are turned", True),
        (shapes.box(4, size=(0.5, 0.5, 1.0)), "object, seen from outside", False),
        (turned(shapes.box(4, size=(0.5, 0.5, 1.0))), "object, inside out: its normals are turned", True),
        (shapes.box(9, size=(1.5, 1.8, 2.7)), "room, inside out: its normals are turned", True),
        (turned(shapes.box(9, size=(1.5, 1.8, 2.7))), "room, seen from inside", False),
        (shapes.grid_square(4), "open: its normals are taken as they are", False),
    ],
)
def test_the_side_is_found_and_said(mesh, found, turns):
    items = faces_as_items(mesh)
    result = oriented(items)
    assert result.report["orientation"] == found
    np.testing.assert_array_equal(result.normals, -items.normals if turns else items.normals)


def test_it_can_be_told():
    items = faces_as_items(turned(room()))
    kept = oriented(items, "as given")
    assert kept.report["orientation"] == "room, inside out"
    np.testing.assert_array_equal(kept.normals, items.normals)
    np.testing.assert_array_equal(oriented(kept, "turned").normals, -items.normals)


def test_a_room_inside_out_is_segmented_as_the_same_room():
    mesh, _ = sw.datasets.simulate_room(seed=3, voxel=0.06, n_objects=5)
    params = sw.Params(n_items=800)
    right, wrong = sw.segment(mesh, params), sw.segment(turned(mesh), params)
    assert wrong.report["orientation"] == "room, inside out: its normals are turned"
    assert sw.metrics.rand_index_error(right.labels, wrong.labels) < 1e-12
    as_given = sw.segment(turned(mesh), params.replace(orientation="as given"))
    assert sw.metrics.rand_index_error(right.labels, as_given.labels) > 1e-4


@pytest.mark.parametrize(
    ("scale", "unit"), [(1000.0, "millimetres; .* by 0.001"), (1e-3, "thousands of metres; .* by 1000")]
)
def test_another_unit_than_the_metre_is_noticed(scale, unit):
    mesh = room()
    with pytest.warns(UserWarning, match=f"looks as if it were in {unit}"):
        oriented(faces_as_items(Mesh(mesh.vertices * scale, mesh.faces)))


def test_what_has_no_area_looks_nowhere():
    items = faces_as_items(shapes.triangle())
    assert facing(dataclasses.replace(items, areas=np.zeros(1))) == 0.0


def test_metres_pass_without_a_word():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        oriented(faces_as_items(room()))
