"""Pieces of furniture joined where the runs half agree, on patches of paper."""

import numpy as np
import shapes

from scenewidget.engine.consensus import co_association
from scenewidget.engine.furniture import join_furniture
from scenewidget.engine.items import patch_items
from scenewidget.engine.mesh import Mesh

ANY = (0.0, 1.0)


def sheet(patch_of, size=1.0, n=12):
    """Items of a square sheet of some size, a patch for each place (x, y) in it."""
    square = shapes.grid_square(n)
    mesh = Mesh(size * square.vertices, square.faces)
    x, y, _ = mesh.face_centroids.T
    return patch_items(mesh, patch_of(x, y))


def strips(x, y):
    """Three strips side by side."""
    return np.minimum(3 * x, 2).astype(int)


def runs(items, *partitions):
    return co_association(np.array(partitions, dtype=np.int32).T, items.areas)


def test_the_pair_on_which_more_runs_agree_is_joined():
    items = sheet(strips, size=0.9)
    co = runs(items, [0, 0, 1], [0, 0, 1], [0, 1, 1], [0, 1, 2])
    alone = np.arange(3, dtype=np.int32)
    assert join_furniture(items, alone, co, similarity=0.51, touch=ANY).tolist() == [0, 1, 2]
    assert join_furniture(items, alone, co, similarity=0.5, touch=ANY).tolist() == [0, 0, 1]


def test_after_a_step_agreement_is_the_mean_by_area():
    items = sheet(lambda x, y: np.digitize(x, [0.25, 0.75]), size=0.9)
    co = runs(items, [0, 0, 0], [0, 0, 1], [0, 1, 2], [0, 1, 2])
    alone = np.arange(3, dtype=np.int32)
    mean = (0.25 * 0.25 + 0.5 * 0.25) / 0.75  # of the last with the first and the second, 1 : 2
    assert join_furniture(items, alone, co, similarity=mean, touch=ANY).tolist() == [0, 0, 0]
    assert join_furniture(items, alone, co, similarity=mean + 0.01, touch=ANY).tolist() == [0, 0, 1]


def test_what_hardly_touches_and_what_stands_on_another_stays():
    def corner_and_cup(x, y):
        cup = (abs(x - 0.5) < 0.17) & (abs(y - 0.5) < 0.17)
        return np.where(cup, 1, 0)

    items = sheet(corner_and_cup, size=0.9)
    co = runs(items, [0, 0])
    alone = np.arange(2, dtype=np.int32)
    assert join_furniture(items, alone, co).tolist() == [0, 1]
    assert join_furniture(items, alone, co, touch=(0.25, 1.0)).tolist() == [0, 0]
    halves = sheet(lambda x, y: (x > 0.5).astype(int), size=0.9)
    co = runs(halves, [0, 0])
    assert join_furniture(halves, alone, co, touch=(1.01, 2.0)).tolist() == [0, 1]
    assert join_furniture(halves, alone, co, touch=(0.25, 1.0)).tolist() == [0, 0]


def test_walls_are_not_joined():
    """Twice the size, each half is a piece of the room's hull: large, flat, nothing behind it."""
    halves = {size: sheet(lambda x, y: (x > 0.5 * x.max()).astype(int), size=size) for size in (0.9, 2.0)}
    alone = np.arange(2, dtype=np.int32)
    joined = {size: join_furniture(h, alone, runs(h, [0, 0]), touch=ANY) for size, h in halves.items()}
    assert joined[0.9].tolist() == [0, 0]
    assert joined[2.0].tolist() == [0, 1]


def test_the_unlabeled_and_what_touches_nothing_stay():
    items = sheet(strips, size=0.9)
    co = runs(items, [0, 0, 0])
    assert join_furniture(items, np.array([0, -1, 1], np.int32), co).tolist() == [0, -1, 1]
    assert join_furniture(items, np.full(3, -1, np.int32), co).tolist() == [-1, -1, -1]
    assert join_furniture(items, np.array([0, -1, 0], np.int32), co).tolist() == [0, -1, 0]
