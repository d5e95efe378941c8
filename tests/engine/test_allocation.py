"""Shares of components by hand, and what numbers they give."""

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.engine.allocation import allocate, component_shares
from scenewidget.engine.dihedral import dihedral_partition
from scenewidget.engine.items import simplified_items
from scenewidget.engine.mesh import face_adjacency


@pytest.mark.parametrize(
    ("allocation", "expected"), [("dihedral", [6 / 7, 1 / 7]), ("faces", [0.6, 0.4]), ("same", [1.0, 1.0])]
)
def test_clusters_are_shared_out_by_what_was_asked_for(allocation, expected):
    mesh = shapes.joined(shapes.box(2), shapes.grid_square(4), gap=3.0)  # 48 faces on 6 sides, 32 on one
    items = simplified_items(mesh, face_adjacency(mesh))
    share = component_shares(items, dihedral_partition(items.mesh), allocation)
    np.testing.assert_allclose(share, expected)


@given(st.integers(1, 200), st.lists(st.integers(1, 30), min_size=1, max_size=8))
def test_every_component_gets_one_to_as_many_clusters_as_it_has_items(total, sizes):
    sizes = np.array(sizes)
    count = allocate(total, sizes / sizes.sum(), sizes)
    assert (count >= 1).all()
    assert (count <= sizes).all()
    inside = (count > 1) & (count < sizes)
    assert (np.abs(count - total * sizes / sizes.sum())[inside] <= 0.5 + 1e-9).all()


def test_same_gives_each_component_the_whole():
    assert allocate(7, np.ones(3), np.array([100, 100, 5])).tolist() == [7, 7, 5]
