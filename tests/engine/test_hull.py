"""Walls joined, also bent ones, on scenes made by hand."""

import dataclasses

import numpy as np
import pytest
import shapes
from patches import faces_as_items, scene, sheet

from scenewidget.engine import hull
from scenewidget.engine.hull import join_planes, segment_planes
from scenewidget.engine.mesh import Mesh


def wall(x=-1.0, width=4.0, height=2.0):
    """Looks along x, so that the floors here are those of a room."""
    square = shapes.grid_square(6)
    u, v, _ = square.vertices.T
    return Mesh(np.stack([np.full(len(u), x), width * u, height * v], axis=1), square.faces)


def test_two_pieces_of_a_floor_become_one():
    floors = sheet((0, 0, 0), (2, 2)), sheet((3, 0, 0.01), (2, 1)), sheet((0, 3, 0.8), (1, 1))
    items, part = scene(*floors, wall())
    assert join_planes(items, part).tolist() == np.array([0, 0, 1, 2])[part].tolist()


def test_beside_a_table_without_a_room_nothing_is_joined_over_a_gap():
    parts = sheet((0, 0, 0), (2, 2)), sheet((3, 0, 0.01), (2, 1))
    assert len(set(join_planes(*scene(*parts)).tolist())) == 2
    assert len(set(join_planes(*scene(*parts, wall())).tolist())) == 2  # one floor and the wall


def test_a_far_piece_of_a_floor_whose_near_one_leans_is_joined():
    """By the leaning plane of the first the second would lie 8 cm too high."""
    floor = sheet((0, 0, 0), (1.5, 1.5))
    leaning = Mesh(floor.vertices + np.outer(floor.vertices[:, 0] - 0.75, (0, 0, 0.02)), floor.faces)
    items, part = scene(leaning, sheet((4, 0, 0), (1, 1)), wall())
    assert join_planes(items, part).tolist() == np.array([0, 0, 1])[part].tolist()


@pytest.mark.parametrize("thickness", [0.1, 0.3])
def test_nothing_is_joined_through_a_wall(thickness):
    """Two rooms of 4 × 3 × 2.4 m wall to wall: floors, ceilings and walls lie in one plane, but apart."""
    box = shapes.box(12, size=(4.0, 3.0, 2.4))
    inside = Mesh(box.vertices, box.faces[:, ::-1])
    mesh = shapes.joined(inside, inside, gap=4.0 + thickness)
    axis = np.abs(mesh.face_normals).argmax(axis=1)
    side = 2 * axis + (mesh.face_normals.sum(axis=1) > 0) + 6 * np.repeat([0, 1], inside.n_faces)
    assert len(set(join_planes(faces_as_items(mesh), side.astype(np.int32)).tolist())) == 12


def test_of_a_heap_of_triangles_only_the_largest_walls_are_looked_at():
    """Any two of them back to back might be one; each costs a look from every piece of the hull."""
    mesh = Mesh(np.random.default_rng(0).uniform(0, 3, (1500, 3)), np.arange(1500).reshape(-1, 3))
    items, each = faces_as_items(mesh), np.arange(500, dtype=np.int32)
    walls = hull._walls(items, each, segment_planes(items, each), 1.0)
    assert len(walls) == hull.MOST_WALLS
    smaller = [mesh.face_areas[wall.body].min() for wall in walls]
    assert smaller == sorted(smaller, reverse=True)


def test_a_floor_that_runs_through_a_door_is_one():
    floor = sheet((0, 0, 0), (8, 3), n=24)
    ceilings = [
        Mesh(m.vertices, m.faces[:, ::-1])
        for m in (sheet((0, 0, 2.4), (3.9, 3)), sheet((4.1, 0, 2.4), (3.9, 3)))
    ]
    jamb = wall(4.1, width=1.8, height=2.4)
    walls = jamb, Mesh(jamb.vertices - [0.2, 0, 0], jamb.faces[:, ::-1])
    items, part = scene(floor, *ceilings, *walls)
    halves = np.where(part == 0, (items.centroids[:, 0] > items.centroids[part == 0, 0].mean()) * 5, part)
    joined = join_planes(items, halves.astype(np.int32))
    assert [len(set(joined[np.isin(part, parts)].tolist())) for parts in ([0], [1, 2], [3, 4])] == [1, 2, 2]


def test_thresholds_follow_the_scale_of_the_scene():
    parts = [sheet((0, 0, 0), (2, 2)), sheet((3, 0, 0.01), (2, 1)), sheet((0, 3, 0.8), (1, 1)), wall()]
    items, part = scene(*parts)
    small, _ = scene(*(Mesh(mesh.vertices / 8, mesh.faces) for mesh in parts))
    small = dataclasses.replace(small, scales=np.array([1 / 8]))
    np.testing.assert_array_equal(join_planes(small, part), join_planes(items, part))


def test_a_sheet_that_looks_the_other_way_stays():
    ceiling = sheet((3, 0, 0), (2, 1))
    items, part = scene(sheet((0, 0, 0), (2, 2)), Mesh(ceiling.vertices, ceiling.faces[:, ::-1]))
    assert len(set(join_planes(items, part).tolist())) == 2


def test_a_table_top_is_no_floor_because_things_lie_behind_it():
    """Both halves of a table lie in one plane, but the floor is behind them."""
    items, part = scene(sheet((0, 0, 0), (4, 4)), sheet((0, 0, 0.7), (1.2, 1)), sheet((2, 0, 0.7), (1.2, 1)))
    assert len(set(join_planes(items, part).tolist())) == 3


def test_small_and_rough_pieces_found_nothing():
    items, part = scene(sheet((0, 0, 0), (0.9, 1)), sheet((2, 0, 0), (0.9, 1)), wall())
    assert len(set(join_planes(items, part).tolist())) == 3
    assert len(set(join_planes(items, part, min_seed_area=0.5).tolist())) == 2


def test_the_unlabeled_stay_unlabeled():
    items, part = scene(sheet((0, 0, 0), (2, 2)), sheet((3, 0, 0), (2, 1)), wall())
    part[:5] = -1
    joined = join_planes(items, part)
    assert (joined[:5] == -1).all()
    assert set(joined[5:][part[5:] < 2].tolist()) == {0}
    nothing = np.full(items.n, -1, dtype=np.int32)
    np.testing.assert_array_equal(join_planes(items, nothing), nothing)


def test_a_bent_wall_is_followed_beyond_its_plane():
    """Each sheet lies 2 cm above the one before, the last out of reach of the first one's plane."""
    parts = [sheet((0, 0, 0), (3, 3)), sheet((3, 0, 0.02), (2, 3)), sheet((5, 0, 0.04), (2, 3))]
    items, part = scene(*parts, wall())
    assert set(join_planes(items, part).tolist()) == {0, 1}
    far = [parts[0], parts[1], sheet((6, 0, 0.2), (2, 3))]
    assert set(join_planes(*scene(*far, wall())).tolist()) == {0, 1, 2}


def test_a_wall_that_has_grown_is_compared_with_the_hull_again():
    """The third sheet lies out of reach of the first one's plane, but in that of the first two together."""
    parts = [sheet((0, 0, 0), (3, 3)), sheet((3, 0, 0.02), (2, 3))]
    large, high = sheet((5.2, 0, 0.045), (2, 3)), sheet((5.2, 0, 0.1), (2, 3))
    assert set(join_planes(*scene(*parts, large, wall())).tolist()) == {0, 1}
    assert set(join_planes(*scene(*parts, high, wall())).tolist()) == {0, 1, 2}


def test_what_is_followed_is_not_followed_up_a_step():
    parts = [sheet((0, 0, 0), (3, 3)), sheet((3, 0, 0.02), (2, 3)), sheet((5, 0, 0.06), (2, 3))]
    assert set(join_planes(*scene(*parts, wall())).tolist()) == {0, 1, 2}


def test_a_shell_behind_a_wall_belongs_to_it():
    back = sheet((0, 0, -0.2), (1, 1))
    items, part = scene(sheet((0, 0, 0), (6, 6)), Mesh(back.vertices, back.faces[:, ::-1]), wall())
    assert set(join_planes(items, part).tolist()) == {0, 1}
    assert set(join_planes(items, part, shell=0.1).tolist()) == {0, 1, 2}


def test_planes_say_what_is_hull():
    items, part = scene(sheet((0, 0, 0), (4, 4)), sheet((0, 0, 0.7), (1.2, 1)), sheet((5, 0, 0.3), (0.5, 1)))
    planes = segment_planes(items, part)
    assert planes.is_hull.tolist() == [True, False, False]
    np.testing.assert_allclose(planes.areas, [16, 1.2, 0.5])
    np.testing.assert_allclose(planes.normals, np.tile([0, 0, 1], (3, 1)), atol=1e-9)


def test_a_wall_at_the_inner_corner_of_an_l_is_hull_and_a_wardrobe_is_not():
    """Behind both is the other leg of the room; the wall reaches the ceiling."""
    above = sheet((0, 0, 2.5), (4, 4))
    room = [sheet((0, 0, 0), (4, 4)), Mesh(above.vertices, above.faces[:, ::-1])]
    square = shapes.grid_square(6)
    u, v, _ = square.vertices.T
    for height, is_hull in (2.5, True), (2.0, False):
        upright = Mesh(np.stack([np.full(len(u), 2.0), 4 - 2 * u, height * v], axis=1), square.faces)
        planes = segment_planes(*scene(*room, upright))
        np.testing.assert_allclose(planes.normals[2], [-1, 0, 0], atol=1e-9)
        assert planes.is_hull.tolist() == [True, True, is_hull]
    assert not segment_planes(*scene(room[0], upright)).is_hull[1]  # without a ceiling
