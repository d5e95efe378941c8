"""Up, the free side and the unit of rooms, closets, tables and cuts of them, in any direction."""

import numpy as np
import pytest
import shapes
import trimesh
from scipy.spatial.transform import Rotation

from scenewidget import PointCloud, datasets
from scenewidget.engine import gravity
from scenewidget.engine.gravity import large_axes
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.orientation import up_direction
from scenewidget.engine.readers.scale import in_metres
from scenewidget.engine.readers.scan import Notes
from scenewidget.engine.sides import right_side_out
from scenewidget.engine.units import likely_unit


@pytest.fixture(scope="module")
def rooms():
    return [datasets.simulate_room(seed=seed, voxel=0.08)[0] for seed in range(3)]


@pytest.fixture(scope="module")
def open_above():
    room, _ = datasets.simulate_room(seed=5, voxel=0.05, n_objects=8)
    ceiling = (room.face_normals[:, 2] < -0.9) & (room.face_centroids[:, 2] > room.bounds[1, 2] - 0.2)
    return room.part(np.flatnonzero(~ceiling))


def flipped(mesh):
    return Mesh(mesh.vertices, mesh.faces[:, ::-1])


def block(size, bottom=(0.0, 0.0, 0.0), n=12):
    """A closed box that stands on ``bottom``, seen from outside."""
    mesh = shapes.box(n, size=size)
    low = (mesh.bounds[0] + mesh.bounds[1]) / 2 - (0, 0, size[2] / 2)
    return Mesh(mesh.vertices - low + np.array(bottom), mesh.faces)


def together(*meshes):
    joined = trimesh.util.concatenate([trimesh.Trimesh(m.vertices, m.faces, process=False) for m in meshes])
    return Mesh(joined.vertices, joined.faces)


def table():
    """A top on four legs, seen from outside."""
    legs = [block((0.05, 0.05, 0.7), (x, y, 0)) for x in (-0.7, 0.7) for y in (-0.3, 0.3)]
    return together(block((1.6, 0.8, 0.04), (0, 0, 0.7), 24), *legs)


def closet(size=(1.5, 1.8, 2.7)):
    """The inside of a walk-in closet with two shelves."""
    shelves = [block((1.2, 0.3, 0.03), (0, 0.7, z)) for z in (0.6, 1.4)]
    return together(flipped(block(size)), *shelves)


@pytest.mark.parametrize("seed", range(5))
def test_up_is_found_in_any_direction(rooms, seed):
    turn = Rotation.random(random_state=seed).as_matrix()
    room = rooms[seed % 3]
    found = up_direction(Mesh(room.vertices @ turn.T + [40, 50, 60], room.faces))
    assert found @ turn @ [0, 0, 1] > np.cos(np.radians(3))


def test_up_is_found_without_a_ceiling_and_inside_out(rooms):
    for room in rooms[:3]:
        is_ceiling = room.face_normals[:, 2] < -0.9
        assert up_direction(Mesh(room.vertices, room.faces[~is_ceiling])) @ [0, 0, 1] > 0.99
        assert up_direction(flipped(room)) @ [0, 0, 1] > 0.99


def test_a_table_from_above_tells_and_a_bare_wall_does_not():
    above = together(shapes.grid_square(30), block((0.2, 0.2, 0.15), (0.5, 0.5, 0.0), 6))
    assert up_direction(above) @ [0, 0, 1] > 0.99
    assert up_direction(shapes.grid_square(30)) is None
    assert up_direction(shapes.icosphere(4)) is None
    cube = flipped(block((3.0, 3.0, 3.0)))
    assert up_direction(cube) is None


def test_a_table_inside_out_is_not_sure_and_one_without_normals_is():
    above = together(shapes.grid_square(60), block((0.2, 0.2, 0.15), (0.5, 0.5, 0.0), 6))
    assert up_direction(flipped(above)) is None
    for sign in (1, -1):  # whichever way the cloud's own normals happen to point
        cloud = PointCloud(above.face_centroids * (1, 1, sign))
        assert up_direction(cloud) @ [0, 0, sign] > 0.99


def test_a_room_as_points_without_normals_stands_on_its_floor(rooms):
    for room in rooms:
        assert up_direction(PointCloud(room.face_centroids)) @ [0, 0, 1] > 0.99
        turned = Rotation.from_euler("x", 180, degrees=True).as_matrix()
        assert up_direction(PointCloud(room.face_centroids @ turned.T)) @ [0, 0, -1] > 0.99


@pytest.mark.parametrize("toward", [(0.0, 0.3, 0.95), (0.5, 0.1, 0.85), (-0.5, -0.3, 0.8)])
def test_of_a_room_cut_askew_the_ceiling_is_no_floor(rooms, toward):
    told = []
    for room in rooms:
        along = room.face_centroids @ toward
        part = room.part(np.flatnonzero(along > np.quantile(along, 0.45)))  # the ceiling, and little else
        told += [up_direction(part), up_direction(PointCloud(part.face_centroids))]
    assert all(up is None or up @ [0, 0, 1] > 0.99 for up in told)
    assert sum(up is not None for up in told) >= 3


@pytest.mark.parametrize("share", [0.5, 0.7, 0.9])
def test_of_a_level_ceiling_with_the_upper_walls_nothing_is_sure(rooms, share):
    for room in rooms:
        low, high = room.bounds[:, 2]
        part = room.part(np.flatnonzero(room.face_centroids[:, 2] > low + share * (high - low)))
        assert up_direction(part) is None
    below = room.part(np.flatnonzero(room.face_centroids[:, 2] < low + 0.5 * (high - low)))
    assert up_direction(below) @ [0, 0, 1] > 0.99  # furniture tells


def test_heights_of_a_plane_that_only_rounding_tells_apart():
    wall = shapes.grid_square(20, size=0.5)
    both = together(shapes.grid_square(30), Mesh(wall.vertices[:, [0, 2, 1]], wall.faces))
    for seed in range(8):
        turn = Rotation.random(random_state=seed).as_matrix()
        up_direction(Mesh(both.vertices @ turn.T + 1e4, both.faces))  # fails nowhere


def test_walls_as_far_apart_as_floor_and_ceiling_are_no_floor():
    room = flipped(block((4.3, 3.4, 2.0), n=24))
    is_open = room.face_normals[:, 2] > -0.9
    shelf = block((1.6, 0.6, 0.5), (0, 1.4, 0))
    assert up_direction(together(Mesh(room.vertices, room.faces[is_open]), shelf)) @ [0, 0, 1] > 0.99


@pytest.mark.parametrize(
    "mesh", [closet(), closet((1.0, 1.1, 2.4)), table(), flipped(block((5.0, 4.0, 2.5)))]
)
def test_the_free_side_is_told_at_any_size(mesh):
    evidence = right_side_out(mesh.face_centroids, mesh.face_normals, mesh.face_areas)
    assert evidence > 0.3
    assert right_side_out(mesh.face_centroids, -mesh.face_normals, mesh.face_areas) == -evidence


def test_a_single_surface_does_not_tell_its_free_side():
    square = shapes.grid_square(10)
    assert right_side_out(square.face_centroids, square.face_normals, square.face_areas) == 0


UNITS = {
    "metres": 1.0, "millimetres": 1000.0, "centimetres": 100.0, "inches": 1 / 0.0254, "feet": 1 / 0.3048,
    "hundreds of metres": 0.01, "thousands of metres": 0.001,
}  # fmt: skip


@pytest.mark.parametrize("name", UNITS)
def test_the_unit_of_a_room_is_named_with_its_factor(rooms, name):
    for room in rooms[:2]:
        unit = likely_unit(Mesh(room.vertices * UNITS[name], room.faces))
        assert unit.name == name
        assert unit.factor * UNITS[name] == pytest.approx(1)


@pytest.mark.parametrize("name", ["metres", "inches", "feet", "centimetres"])
def test_the_unit_of_an_open_room_is_told_by_the_height_of_its_furniture(open_above, name):
    turned = open_above.vertices[:, [1, 2, 0]]  # y up
    assert likely_unit(Mesh(turned * UNITS[name], open_above.faces)).name == name


@pytest.mark.parametrize(
    ("unit", "units", "said"),
    [
        ("feet", None, 'were taken as metres; feet fit nearly as well: units="ft" takes them so'),
        ("inches", "auto", 'units="cm" takes them so'),
        ("centimetres", "auto", 'units="in" takes them so'),
        ("metres", None, ""),
    ],
)
def test_what_size_can_not_tell_of_a_table_is_said(unit, units, said):
    table = shapes.grid_square(300, size=1.3)  # nothing but size and density tells
    table = Mesh(table.vertices * UNITS[unit], table.faces, source="table.ply")
    notes = Notes()
    in_metres(table, units, notes)
    assert said in " ".join(notes.lines) if said else not notes.lines
    assert bool(notes.warned) == (units == "auto")


def test_axes_measure_what_faces_them():
    axes = large_axes(flipped(block((5.0, 4.0, 2.5), n=40)))[:3]
    assert sorted(round(axis.extent, 1) for axis in axes) == [2.5, 4.0, 5.0]
    assert all(axis.is_opposed for axis in axes)
    assert sum(axis.share for axis in axes) == pytest.approx(1, abs=0.2)


def test_the_surface_is_smoothed_but_once(rooms, monkeypatch):
    room = Mesh(rooms[0].vertices, rooms[0].faces)
    calls, smooth = [], gravity._smoothed_sample
    monkeypatch.setattr(gravity, "_smoothed_sample", lambda mesh: calls.append(mesh) or smooth(mesh))
    for _ in range(2):
        np.testing.assert_array_equal(up_direction(room), up_direction(rooms[0]))
    assert calls.count(room) == 1
