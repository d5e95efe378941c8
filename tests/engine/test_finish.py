"""Connected pieces, and crumbs given to neighbours: on scenes made by hand."""

import numpy as np
import shapes
from hypothesis import given
from hypothesis import strategies as st
from patches import faces_as_items
from strategies import graphs

from scenewidget.engine.finish import absorb_small, connected_pieces
from scenewidget.engine.mesh import Mesh, connected_components


def together(labels):
    return labels[:, None] == labels


@given(graphs(), st.data())
def test_pieces_are_the_components_within_labels(graph, data):
    n, pairs, _ = graph
    labels = np.array(data.draw(st.lists(st.integers(-1, 3), min_size=n, max_size=n)), dtype=np.int32)
    pieces = connected_pieces(labels, pairs)
    np.testing.assert_array_equal(pieces < 0, labels < 0)
    same = pairs[labels[pairs[:, 0]] == labels[pairs[:, 1]]]
    _, component = connected_components(n, same)
    known = labels >= 0
    np.testing.assert_array_equal(together(pieces[known]), together(component[known]))
    _, first = np.unique(pieces[known], return_index=True)
    assert (np.diff(first) > 0).all()


def grid_items(n=10):
    """Items in n × n cells of two faces each, 1 m wide, and the cell's column and row."""
    mesh = shapes.grid_square(n)
    cell = np.repeat(np.arange(n * n), 2)
    bumpy = Mesh(
        mesh.vertices + np.random.default_rng(0).normal(scale=0.01, size=mesh.vertices.shape), mesh.faces
    )
    items = faces_as_items(bumpy)
    assert items.n == mesh.n_faces
    return items, cell // n, cell % n


def test_a_crumb_goes_to_the_neighbour_with_most_of_its_seam():
    items, column, row = grid_items()
    labels = np.where(column < 5, 0, 1).astype(np.int32)
    crumb = (column == 5) & (row < 3)  # three cells touch the left, four of its edges the right
    labels[crumb] = 2
    merged = absorb_small(items, labels, min_area=0.05)
    expected = np.where(column < 5, 0, 1)
    expected[crumb] = 1
    np.testing.assert_array_equal(together(merged), together(expected))


def test_segments_of_the_least_area_stay():
    items, column, _ = grid_items()
    labels = (column >= 5).astype(np.int32)
    np.testing.assert_array_equal(absorb_small(items, labels, min_area=0.4), labels)
    assert absorb_small(items, labels, min_area=0.0).max() == 1


def test_all_crumbs_end_in_one():
    items, _, _ = grid_items()
    assert absorb_small(items, np.arange(items.n, dtype=np.int32), min_area=10.0).max() == 0


def test_crumbs_without_a_neighbour_and_the_unlabeled_stay():
    mesh = shapes.joined(shapes.grid_square(4), shapes.triangle(), gap=5.0)
    items = faces_as_items(mesh)
    labels = items.component.copy()
    np.testing.assert_array_equal(absorb_small(items, labels, min_area=100.0), labels)
    labels[:2] = -1
    assert (absorb_small(items, labels, min_area=100.0)[:2] == -1).all()


@given(st.integers(0, 99), st.floats(0.005, 0.3))
def test_no_segment_with_a_neighbour_stays_below_the_least_area(seed, smallest):
    items, column, row = grid_items(6)
    labels = np.random.default_rng(seed).integers(0, 9, 36)[6 * column + row]
    pieces = connected_pieces(labels.astype(np.int32), items.pairs)
    merged = absorb_small(items, pieces, smallest)
    assert (together(pieces) <= together(merged)).all()
    area = np.bincount(merged, items.areas)
    assert len(area) == 1 or area.min() >= smallest
