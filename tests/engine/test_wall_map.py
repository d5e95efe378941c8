"""Maps of walls whose heights and tints are known."""

import numpy as np
import pytest
from patches import carpet, floor, sheet
from scipy import ndimage

from scenewidget.engine.items import patch_items
from scenewidget.engine.wall_map import SHIFTS, Seams, nearest, wall_maps

BLUNT = 0.15  # the grid lies askew, so cells at the border hold some of both sides


def floor_with_carpet(height):
    """An even floor and what lies on it, so much higher, as two items."""
    mesh = floor(lambda x, y: height * carpet(x, y), noise=0.0).mesh
    x, y, _ = mesh.face_centroids.T
    return patch_items(mesh, carpet(x, y).astype(int))


def test_a_step_is_the_height_between_both_sides_of_a_seam():
    maps = wall_maps(floor_with_carpet(0.012), np.arange(2), None, 0.05)
    assert len(maps) == len(SHIFTS)
    for grid in maps:
        assert set(np.unique(grid.item).tolist()) == {-1, 0, 1}
        assert grid.seams.pairs.tolist() == [[0, 1]]
        np.testing.assert_allclose(np.abs(grid.seams.step) / grid.seams.length, 0.012, rtol=BLUNT)


def test_other_values_are_mapped_beside_the_heights():
    items = floor_with_carpet(0.0)
    values = np.stack([items.item_of_face * 0.3, 0.5 - items.item_of_face]).astype(float)
    for grid in wall_maps(items, np.arange(2), values, 0.05):
        steps = grid.seams.step[:, 0] / grid.seams.length[0]
        np.testing.assert_allclose(steps, [0.0, 0.3, -1.0], rtol=BLUNT, atol=1e-12)


def test_a_narrow_strip_belongs_to_the_broad_item_beside_it():
    mesh = sheet((0, 0, 0), (2, 2), n=80)
    x = mesh.face_centroids[:, 0]
    items = patch_items(mesh, np.searchsorted([0.95, 1.0], x))
    for grid in wall_maps(items, np.arange(3), None, 0.05):
        assert 1 in grid.item
        assert set(np.unique(grid.without_rims).tolist()) == {-1, 0, 2}
        assert grid.seams.pairs.tolist() == [[0, 2]]


def test_seams_in_units_of_a_step():
    seams = Seams(np.array([[0, 1]]), np.array([[4.0], [9.0]]), np.array([[2.0], [3.0]]), np.array([7.0]))
    scaled = seams.in_units_of(np.array([2.0, 3.0]))
    np.testing.assert_array_equal(scaled.step, [[2], [3]])
    np.testing.assert_array_equal(scaled.ridge, [[1], [1]])
    np.testing.assert_array_equal(scaled.length, [7])


@pytest.mark.parametrize("density", [0.02, 0.2, 0.6])
def test_the_nearest_value_is_that_of_a_distance_transform(density):
    rng = np.random.default_rng(1)
    cells = np.where(rng.random((60, 70)) < density, rng.integers(0, 9, (60, 70)), -1)
    cells[:3] = cells[-3:] = cells[:, :3] = cells[:, -3:] = -1
    far, (rows, columns) = ndimage.distance_transform_edt(cells < 0, return_indices=True)
    for reach in (1, 2, 3):
        expected = np.where(far <= reach, cells[rows, columns], -7)
        found = nearest(cells, reach, np.full(cells.shape, -7))
        np.testing.assert_array_equal(found[3:-3, 3:-3], expected[3:-3, 3:-3])
