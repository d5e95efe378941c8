"""Shortest paths against scipy's Dijkstra, edge costs against their formulas."""

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.sparse import csgraph
from strategies import graphs

from scenewidget.engine.distances import (
    MAX_DENSE_ITEMS,
    STRIP,
    MinPlusFactor,
    all_pairs,
    edge_costs,
    edge_weights,
    weight_graph,
)
from scenewidget.engine.mesh import face_adjacency
from scenewidget.engine.monitor import Cancelled, Monitor


def dijkstra(n, pairs, weights):
    """All pairs by scipy on lightest edges; zeros are lifted by so little that no sum sees it."""
    lightest = {}
    for (a, b), w in zip(np.sort(pairs, axis=1).tolist(), weights):
        lightest[a, b] = min(w, lightest.get((a, b), np.inf))
    edges = [(a, b, max(w, 1e-300)) for (a, b), w in lightest.items() if a != b]
    a, b, w = zip(*edges) if edges else ((), (), ())
    return csgraph.dijkstra(sparse.csr_array((w, (a, b)), shape=(n, n)), directed=False)


def surface_graph(n_cells, seed=0):
    """Faces of a grid with random weights: what the pipeline feeds in."""
    mesh = shapes.grid_square(n_cells)
    pairs = face_adjacency(mesh)
    return mesh.n_faces, pairs, np.random.default_rng(seed).exponential(size=len(pairs))


@given(graphs())
def test_all_pairs_are_those_of_dijkstra(graph):
    n, pairs, weights = graph
    D = all_pairs(weight_graph(n, pairs, weights))
    assert D.dtype == np.float32
    np.testing.assert_array_equal(D, D.T)
    np.testing.assert_allclose(D, dijkstra(n, pairs, weights), rtol=1e-5, atol=1e-30)


def test_all_pairs_on_a_surface_are_those_of_dijkstra():
    n, pairs, weights = surface_graph(20)
    D = all_pairs(weight_graph(n, pairs, weights))
    np.testing.assert_allclose(D, dijkstra(n, pairs, weights), rtol=1e-5)
    np.testing.assert_array_equal(np.diag(D), 0)
    np.testing.assert_array_equal(D, D.T)


@given(graphs())
def test_no_detour_is_shorter(graph):
    n, pairs, weights = graph
    D = all_pairs(weight_graph(n, pairs, weights)).astype(float)
    through = (D[:, :, None] + D[None, :, :]).min(axis=1)
    assert (through * (1 + 1e-6) >= D).all()


@given(graphs(), st.data())
def test_rows_on_demand_are_rows_of_all_pairs(graph, data):
    n, pairs, weights = graph
    matrix = weight_graph(n, pairs, weights)
    sources = data.draw(st.lists(st.integers(0, n - 1), max_size=2 * n))
    rows = MinPlusFactor(matrix).rows(np.array(sources, dtype=int))
    np.testing.assert_allclose(rows, all_pairs(matrix)[sources].reshape(len(sources), n), rtol=1e-6)


def test_rows_of_more_sources_than_a_strip_are_in_the_order_asked_for():
    n, pairs, weights = surface_graph(9)
    matrix = weight_graph(n, pairs, weights)
    sources = np.random.default_rng(0).permutation(n)[: STRIP + 7]
    np.testing.assert_allclose(MinPlusFactor(matrix).rows(sources), all_pairs(matrix)[sources], rtol=1e-6)


def test_the_number_of_threads_does_not_matter():
    graph = weight_graph(*surface_graph(15))
    first = all_pairs(graph, n_threads=1)
    for n_threads in (2, 4):
        np.testing.assert_array_equal(all_pairs(graph, n_threads=n_threads), first)


def test_one_direction_of_an_edge_is_enough_and_of_two_the_lighter_counts():
    one_way = sparse.csr_array(([2.0, 3.0], ([0, 1], [1, 2])), shape=(3, 3))
    np.testing.assert_allclose(all_pairs(one_way), [[0, 2, 5], [2, 0, 3], [5, 3, 0]])
    both = sparse.csr_array(([2.0, 1.0], ([0, 1], [1, 0])), shape=(2, 2))
    np.testing.assert_allclose(all_pairs(both), [[0, 1], [1, 0]])


def test_explicit_zeros_are_edges_and_loops_are_none():
    graph = sparse.csr_array(([0.0, 7.0], ([0, 2], [1, 2])), shape=(3, 3))
    np.testing.assert_array_equal(all_pairs(graph), [[0, 0, np.inf], [0, 0, np.inf], [np.inf, np.inf, 0]])


def test_duplicate_entries_of_a_matrix_count_once_with_the_lightest():
    coo = sparse.coo_array(([5.0, 2.0], ([0, 0], [1, 1])), shape=(2, 2))
    np.testing.assert_array_equal(all_pairs(coo), [[0, 2], [2, 0]])


@pytest.mark.parametrize("n", [0, 1, 3])
def test_a_graph_without_edges_connects_nothing(n):
    D = all_pairs(sparse.csr_array((n, n)))
    np.testing.assert_array_equal(D, np.where(np.eye(n, dtype=bool), 0, np.inf))


def test_a_star_and_a_complete_graph_have_known_distances():
    star = np.column_stack([np.zeros(200, int), np.arange(1, 201)])
    expected = np.full((201, 201), 2.0)
    expected[0], expected[:, 0] = 1, 1
    np.fill_diagonal(expected, 0)
    np.testing.assert_array_equal(all_pairs(weight_graph(201, star, np.ones(200))), expected)
    every = np.stack(np.triu_indices(60, 1), axis=1)
    np.testing.assert_array_equal(all_pairs(weight_graph(60, every, np.ones(len(every)))), 1 - np.eye(60))


@pytest.mark.parametrize(
    ("graph", "error", "message"),
    [
        (np.eye(2), TypeError, "graph must be a scipy sparse matrix, got ndarray"),
        (sparse.csr_array((2, 3)), ValueError, "graph must be square"),
        (sparse.csr_array([[0.0, -1.0], [-1.0, 0.0]]), ValueError, "non-negative weights"),
        (sparse.csr_array([[0.0, np.nan], [np.nan, 0.0]]), ValueError, "none of them NaN"),
        (sparse.csr_array((MAX_DENSE_ITEMS + 1,) * 2), ValueError, r"would take 6.4 GB.*rows\(sources\)"),
    ],
)
def test_a_bad_graph_is_refused(graph, error, message):
    with pytest.raises(error, match=message):
        all_pairs(graph)


@pytest.mark.parametrize("sources", [[3], [-1]])
def test_sources_that_do_not_exist_are_refused(sources):
    factor = MinPlusFactor(sparse.csr_array((3, 3)))
    with pytest.raises(ValueError, match=r"sources must lie in 0\.\.2"):
        factor.rows(np.array(sources))


def test_cancel_stops_between_strips():
    cancel = AfterSomeAnswers(3)
    with pytest.raises(Cancelled):
        all_pairs(weight_graph(*surface_graph(20)), monitor=Monitor(cancel=cancel))


class AfterSomeAnswers:
    """An event that is set once it has been asked a number of times."""

    def __init__(self, n):
        self.n = n

    def is_set(self):
        self.n -= 1
        return self.n < 0


# --- edges ----------------------------------------------------------------------------------------

PAIRS = np.array([[0, 1], [0, 2], [0, 3]])
NORMALS = np.array([[0, 0, 1.0], [0, 0, 1.0], [1.0, 0, 0], [0, 0, -1.0]])


def test_costs_of_the_thesis():
    np.testing.assert_array_equal(edge_costs(NORMALS, PAIRS, a=1, b=0, exponent=1), [1, 1, 1])  # f1
    np.testing.assert_allclose(edge_costs(NORMALS, PAIRS, a=1, b=-1, exponent=1.5), [0, 1, 2**1.5])  # f2


def test_costs_are_never_negative_or_nan_by_rounding():
    longer = NORMALS * (1 + 1e-15)
    assert edge_costs(longer, PAIRS, a=1, b=-1, exponent=0.5)[0] == 0
    assert edge_costs(NORMALS, PAIRS, a=-1, b=0, exponent=0.5).tolist() == [0, 0, 0]


def test_weights_are_feature_steps_times_costs_and_ties_go_to_the_shorter_path():
    steps, costs, lengths = np.array([2.0, 3.0, 0.0]), np.array([1.0, 0.5, 4.0]), np.array([1.0, 1.0, 3.0])
    weights = edge_weights(steps, costs, lengths)
    np.testing.assert_allclose(weights, steps * costs, atol=1e-11)
    assert 0 < edge_weights(steps, np.zeros(3), lengths)[0] < edge_weights(steps, np.zeros(3), lengths)[2]


def test_convex_edges_floor_and_hop_enter_as_documented():
    steps, costs, lengths = np.array([0.0, 20.0]), np.array([1.0, 2.0]), np.array([0.1, 0.2])
    weights = edge_weights(
        steps,
        costs,
        lengths,
        feature_floor=0.5,
        is_convex=np.array([False, True]),
        convex_weight=0.25,
        hop=0.3,
    )
    floor = 0.5 * np.quantile(steps, 0.95)
    expected = [floor * 1.0 + 0.3, 0.25 * (20 + floor) * 2 + 0.3]
    np.testing.assert_allclose(weights, expected, rtol=1e-9)


@given(graphs())
def test_weight_graph_is_symmetric_with_the_lightest_of_double_edges(graph):
    n, pairs, weights = graph
    matrix = weight_graph(n, pairs, weights)
    expected = np.full((n, n), np.inf)
    for (a, b), w in zip(pairs, weights):
        if a != b:
            expected[a, b] = expected[b, a] = min(w, expected[a, b])
    got = np.full((n, n), np.inf)
    coo = matrix.tocoo()
    got[coo.row, coo.col] = coo.data
    np.testing.assert_array_equal(got, expected)
    assert matrix.has_canonical_format
