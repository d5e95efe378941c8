"""Walls joined, also bent ones, and what stands out of them parted: on scenes made by hand."""

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.engine.hull import join_planes, segment_planes
from scenewidget.engine.items import _build, simplified_items
from scenewidget.engine.mesh import Mesh, face_adjacency
from scenewidget.engine.relief import DOUBT, _merged, _Seams, separate_reliefs, separate_tints


def faces_as_items(mesh):
    """One item a face."""
    options = {"coverage": 1.0, "smallest": 0.0, "smallest_simplified": 0.0}
    return simplified_items(mesh, face_adjacency(mesh), n_faces=10**6, **options)


def scene(*parts):
    """Items a face of parts joined in one mesh, and the part of each item."""
    mesh = shapes.joined(*parts)
    return faces_as_items(mesh), np.repeat(np.arange(len(parts)), [p.n_faces for p in parts]).astype(np.int32)


def sheet(origin, size, n=6):
    square = shapes.grid_square(n)
    return Mesh(square.vertices * [*size, 1] + np.array(origin), square.faces)


def test_two_pieces_of_a_floor_become_one():
    items, part = scene(sheet((0, 0, 0), (2, 2)), sheet((3, 0, 0.01), (2, 1)), sheet((0, 3, 0.8), (1, 1)))
    assert join_planes(items, part).tolist() == np.where(part == 2, 1, 0).tolist()


def test_a_sheet_that_looks_the_other_way_stays():
    ceiling = sheet((3, 0, 0), (2, 1))
    items, part = scene(sheet((0, 0, 0), (2, 2)), Mesh(ceiling.vertices, ceiling.faces[:, ::-1]))
    assert len(set(join_planes(items, part).tolist())) == 2


def test_a_table_top_is_no_floor_because_things_lie_behind_it():
    """Both halves of a table lie in one plane, but the floor is behind them."""
    items, part = scene(sheet((0, 0, 0), (4, 4)), sheet((0, 0, 0.7), (1.2, 1)), sheet((2, 0, 0.7), (1.2, 1)))
    assert len(set(join_planes(items, part).tolist())) == 3


def test_small_and_rough_pieces_found_nothing():
    items, part = scene(sheet((0, 0, 0), (0.9, 1)), sheet((2, 0, 0), (0.9, 1)))
    assert len(set(join_planes(items, part).tolist())) == 2
    assert len(set(join_planes(items, part, smallest_seed=0.5).tolist())) == 1


def test_the_unlabeled_stay_unlabeled():
    items, part = scene(sheet((0, 0, 0), (2, 2)), sheet((3, 0, 0), (2, 1)))
    part[:5] = -1
    joined = join_planes(items, part)
    assert (joined[:5] == -1).all()
    assert set(joined[5:].tolist()) == {0}
    nothing = np.full(items.n, -1, dtype=np.int32)
    for finish in (join_planes, separate_reliefs):
        np.testing.assert_array_equal(finish(items, nothing), nothing)


def test_a_bent_wall_is_followed_beyond_its_plane():
    """Each sheet lies 2 cm above the one before, the last out of reach of the first one's plane."""
    parts = [sheet((0, 0, 0), (3, 3)), sheet((3, 0, 0.02), (2, 3)), sheet((5, 0, 0.04), (2, 3))]
    items, part = scene(*parts)
    assert set(join_planes(items, part).tolist()) == {0}
    far = [parts[0], parts[1], sheet((6, 0, 0.09), (2, 3))]
    assert set(join_planes(*scene(*far)).tolist()) == {0, 1}


def test_a_wall_that_has_grown_is_compared_with_the_hull_again():
    """The third sheet lies out of reach of the first one's plane, but in that of the first two together."""
    parts = [sheet((0, 0, 0), (3, 3)), sheet((3, 0, 0.02), (2, 3))]
    large, small = sheet((6, 0, 0.04), (2, 3)), sheet((6, 0, 0.04), (0.5, 1))
    assert set(join_planes(*scene(*parts, large)).tolist()) == {0}
    assert set(join_planes(*scene(*parts, small)).tolist()) == {0, 1}


def test_what_is_followed_is_not_followed_up_a_step():
    parts = [sheet((0, 0, 0), (3, 3)), sheet((3, 0, 0.02), (2, 3)), sheet((5, 0, 0.06), (2, 3))]
    assert set(join_planes(*scene(*parts)).tolist()) == {0, 1}


def test_a_shell_behind_a_wall_belongs_to_it():
    back = sheet((0, 0, -0.2), (1, 1))
    items, part = scene(sheet((0, 0, 0), (6, 6)), Mesh(back.vertices, back.faces[:, ::-1]))
    assert set(join_planes(items, part).tolist()) == {0}
    assert set(join_planes(items, part, shell=0.1).tolist()) == {0, 1}


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


# --- reliefs --------------------------------------------------------------------------------------


def floor(height, n=100, noise=0.001):
    """Patches of a floor 3 m wide: its height at (x, y), and 1 mm of noise."""
    square = shapes.grid_square(n)
    x, y = 3 * square.vertices[:, 0], 3 * square.vertices[:, 1]
    z = height(x, y) + np.random.default_rng(0).normal(scale=noise, size=len(x))
    mesh = Mesh(np.stack([x, y, z], axis=1), square.faces)
    cell = np.floor(mesh.face_centroids[:, :2] / 0.15).astype(np.int64)
    _, patch = np.unique(cell, axis=0, return_inverse=True)
    return patches(mesh, patch.ravel())


def patches(mesh, patch):
    """Items that are given sets of faces."""
    patch = patch.astype(np.int32)
    return _build(mesh, patch, patch, face_adjacency(mesh), mesh.face_normals, {})


def carpet(x, y):
    return (x > 0.6) & (x < 1.8) & (y > 0.9) & (y < 2.1)


def share(items, labels, wanted):
    """Of the area of the label that is found most in a place: how much lies in it, how much of it that is."""
    x, y, _ = items.centroids.T
    inside = wanted(x, y)
    label = np.bincount(labels[inside], items.areas[inside]).argmax()
    both = items.areas[inside & (labels == label)].sum()
    return both / items.areas[labels == label].sum(), both / items.areas[inside].sum()


@pytest.mark.parametrize("step", [0.012, -0.012])
def test_a_carpet_is_parted_from_its_floor(step):
    items = floor(lambda x, y: step * carpet(x, y))
    labels = separate_reliefs(items, np.zeros(items.n, np.int32))
    assert labels.max() == 1
    assert min(share(items, labels, carpet)) > 0.95


def test_a_step_below_the_threshold_is_none():
    items = floor(lambda x, y: 0.004 * carpet(x, y))
    assert separate_reliefs(items, np.zeros(items.n, np.int32)).max() == 0
    assert separate_reliefs(items, np.zeros(items.n, np.int32), step=0.002).max() == 1


def test_a_bent_floor_is_one():
    items = floor(lambda x, y: 0.05 * np.sin(x) * np.cos(y))
    assert separate_reliefs(items, np.zeros(items.n, np.int32)).max() == 0


def test_a_door_behind_a_frame_is_parted_although_it_lies_in_the_wall():
    def frame(x, y):
        near = np.maximum(np.abs(x - 1.5) - 0.5, np.abs(y - 1.5) - 0.5)
        return np.abs(near) < 0.04

    items = floor(lambda x, y: 0.03 * frame(x, y))
    labels = separate_reliefs(items, np.zeros(items.n, np.int32))
    leaf = labels[np.hypot(items.centroids[:, 0] - 1.5, items.centroids[:, 1] - 1.5) < 0.3]
    assert (leaf == leaf[0]).all()
    assert leaf[0] != labels[np.hypot(items.centroids[:, 0], items.centroids[:, 1]).argmin()]


def test_a_part_at_the_edge_is_no_relief_however_high_its_step():
    """Scans shift halves of a wall against each other; what stands out of a wall has wall round it."""
    items = floor(lambda x, y: 0.03 * (x > 2.1))
    assert separate_reliefs(items, np.zeros(items.n, np.int32)).max() == 0
    items = floor(lambda x, y: 0.03 * ((x > 2.1) & (x < 2.7) & (y > 1.05)))
    assert separate_reliefs(items, np.zeros(items.n, np.int32)).max() == 1


def test_small_things_and_what_is_not_of_the_hull_stay():
    items = floor(lambda x, y: 0.012 * carpet(x, y))
    nothing = np.zeros(items.n, np.int32)
    assert separate_reliefs(items, nothing, min_area=2.0).max() == 0
    assert separate_reliefs(items, np.full(items.n, -1, np.int32)).max() == -1
    under, part = scene(items.mesh, sheet((0, 0, -0.5), (3, 3)))  # a table top: the floor lies behind it
    assert separate_reliefs(under, part).max() == 1


def test_a_turned_and_moved_floor_gives_the_same_parts():
    items = floor(lambda x, y: 0.015 * carpet(x, y))
    moved = Mesh(items.mesh.vertices @ shapes.rotation().T + [5.0, -3.0, 2.0], items.mesh.faces)
    nothing = np.zeros(items.n, np.int32)
    expected = separate_reliefs(items, nothing)
    assert expected.max() == 1
    assert (separate_reliefs(patches(moved, items.item_of_face), nothing) == expected).mean() > 0.97


# --- tints ----------------------------------------------------------------------------------------


def painted(paint):
    """The patches of an even floor: its colour at (x, y)."""
    items = floor(lambda x, y: 0 * x)
    vertices = items.mesh.vertices
    colors = np.broadcast_to(paint(vertices[:, 0], vertices[:, 1]), (len(vertices), 3)).astype(np.uint8)
    return patches(Mesh(vertices, items.mesh.faces, colors), items.item_of_face)


def mixed(where, inside, outside):
    return np.where(where[:, None], inside, outside)


def test_tints_tell_colours_apart_and_shadows_not():
    colors = np.array([[120, 120, 120], [60, 60, 60], [180, 90, 120], [120, 120, 60]])
    mesh = Mesh(np.repeat(shapes.grid_square(1).vertices[:3], 4, axis=0), np.arange(12).reshape(3, 4).T)
    mesh = Mesh(mesh.vertices, mesh.faces, np.tile(colors, (3, 1)).astype(np.uint8))
    green, blue = patches(mesh, np.arange(4)).face_tints
    np.testing.assert_allclose(green, [0, 0, np.log(190 / 100), 0], atol=1e-12)
    np.testing.assert_allclose(blue, [0, 0, 0.5 * np.log(190 * 100 / 130**2), np.log(130 / 70)], atol=1e-12)


def test_a_carpet_of_another_tint_is_parted_from_its_floor_though_it_lies_flat():
    items = painted(lambda x, y: mixed(carpet(x, y), (150, 110, 70), (150, 120, 90)))
    nothing = np.zeros(items.n, np.int32)
    assert separate_reliefs(items, nothing).max() == 0
    labels = separate_tints(items, nothing)
    assert labels.max() == 1
    assert min(share(items, labels, carpet)) > 0.95
    assert separate_tints(items, nothing, contrast=0.5).max() == 0


def test_shadows_and_planks_are_no_things():
    shadow = painted(lambda x, y: mixed(carpet(x, y), (75, 60, 45), (150, 120, 90)))
    assert separate_tints(shadow, np.zeros(shadow.n, np.int32)).max() == 0
    planks = painted(lambda x, y: mixed(np.sin(40 * y) > 0, (150, 110, 70), (150, 120, 90)))
    assert separate_tints(planks, np.zeros(planks.n, np.int32)).max() == 0


def test_without_colours_there_are_no_tints():
    items = floor(lambda x, y: 0 * x)
    assert items.face_tints is None
    assert separate_tints(items, np.zeros(items.n, np.int32)).max() == 0


def joined_by_definition(n, pairs, sums):
    """Regions after joining the surest two again and again, their sums counted anew each time."""
    region = np.arange(n)
    while True:
        best = None
        for a in np.unique(region):
            for b in np.unique(region[region > a]):
                ends = region[pairs]
                along = (ends == (a, b)).all(axis=1), (ends == (b, a)).all(axis=1)
                total = sums[along[0]].sum(axis=0) + sums[along[1]].sum(axis=0) * (-1, -1, 1, 1, 1)
                length, most = total[-1], np.abs(total[:-1]).max()
                if length > 0 and most <= length:
                    best = min(best or (np.inf,), (most / length + DOUBT / length**0.5, a, b))
        if best is None:
            return region
        region[region == best[2]] = best[1]


@given(st.integers(2, 9), st.floats(0.2, 1.0), st.integers(0, 2**32 - 1))
def test_regions_are_joined_surest_first_by_the_sums_over_their_seams(n, density, seed):
    rng = np.random.default_rng(seed)
    pairs = np.stack(np.triu_indices(n, 1), axis=1)
    pairs = pairs[rng.random(len(pairs)) < density]
    length = rng.integers(1, 20, len(pairs)).astype(float)
    steps, ridges = rng.normal(0, 1.2, (2, 2, len(pairs))) * length  # of two values
    roots = _merged(n, _Seams(pairs, steps, ridges, length))
    expected = joined_by_definition(n, pairs, np.stack([*steps, *ridges, length], axis=1))
    np.testing.assert_array_equal(roots[:, None] == roots, expected[:, None] == expected)
