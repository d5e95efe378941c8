"""What stands out of a floor, or differs from it in tint, is parted from it: on floors made by hand."""

import numpy as np
import pytest
import shapes
from patches import carpet, floor, scene, share, sheet

from scenewidget.engine.items import patch_items
from scenewidget.engine.memo import Memo
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.relief import separate_reliefs, separate_tints


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
    assert (separate_reliefs(patch_items(moved, items.item_of_face), nothing) == expected).mean() > 0.97


# --- tints ----------------------------------------------------------------------------------------


def painted(paint):
    """The patches of an even floor: its colour at (x, y)."""
    items = floor(lambda x, y: 0 * x)
    vertices = items.mesh.vertices
    colors = np.broadcast_to(paint(vertices[:, 0], vertices[:, 1]), (len(vertices), 3)).astype(np.uint8)
    return patch_items(Mesh(vertices, items.mesh.faces, colors), items.item_of_face)


def mixed(where, inside, outside):
    return np.where(where[:, None], inside, outside)


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


def test_walls_that_stay_are_mapped_once():
    items, memo = floor(lambda x, y: 0.012 * carpet(x, y)), Memo(1e9)
    recall, nothing = memo.within("items"), np.zeros(items.n, np.int32)
    first = separate_reliefs(items, nothing, recall=recall)
    assert len(memo) == 2  # a map, and what stands out of it
    assert memo.n_bytes > 100_000
    for same in (nothing, nothing + 1):
        np.testing.assert_array_equal(separate_reliefs(items, same, recall=recall) > same, first > 0)
    assert len(memo) == 2
    separate_reliefs(items, np.where(np.arange(items.n) < 20, -1, 0), recall=recall)
    separate_reliefs(items, nothing, recall=recall, cell=0.05)
    assert len(memo) == 6
