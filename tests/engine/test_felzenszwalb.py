"""Felzenszwalb's rule against a plain transcription of the paper."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import graphs

from scenewidget.engine.felzenszwalb import join_along_seams, join_light_edges


def by_the_paper(n, pairs, weights, c, min_size, sizes):
    """Sets of items; internal difference Int(C) = heaviest edge that joined it, MInt = Int + c / |C|."""
    pieces = [{i} for i in range(n)]
    internal = dict.fromkeys(range(n), 0.0)
    home = list(range(n))

    def limit(piece):
        size = sum(sizes[i] for i in pieces[piece])
        return internal[piece] + (c / size if size > 0 else np.inf)

    def join(a, b, w):
        pieces[a] |= pieces[b]
        internal[a] = w
        for i in pieces[b]:
            home[i] = a

    for e in np.argsort(weights, kind="stable"):
        a, b = home[pairs[e][0]], home[pairs[e][1]]
        if a != b and weights[e] <= min(limit(a), limit(b)):
            join(a, b, weights[e])
    for e in np.argsort(weights, kind="stable"):
        a, b = home[pairs[e][0]], home[pairs[e][1]]
        if a != b and min(sum(sizes[i] for i in pieces[p]) for p in (a, b)) < min_size:
            join(a, b, weights[e])
    return np.array(home)


@given(graphs(), st.floats(0, 5), st.sampled_from([0, 2, 4]), st.booleans())
def test_pieces_are_those_of_the_paper(graph, c, min_size, weighted):
    n, pairs, weights = graph
    sizes = np.random.default_rng(n).integers(1, 4, n) / 2 if weighted else np.ones(n)
    labels = join_light_edges(
        n, pairs, weights, threshold=c, min_size=min_size, sizes=sizes if weighted else None
    )
    expected = by_the_paper(n, pairs, weights, c, min_size, sizes)
    np.testing.assert_array_equal(labels[:, None] == labels, expected[:, None] == expected)
    _, first = np.unique(labels, return_index=True)
    assert (np.diff(first) > 0).all()


@given(graphs())
def test_an_order_given_beforehand_changes_nothing(graph):
    n, pairs, weights = graph
    order = np.argsort(weights, kind="stable")
    given_ = join_light_edges(n, pairs, weights, threshold=1.0, order=order)
    np.testing.assert_array_equal(given_, join_light_edges(n, pairs, weights, threshold=1.0))


def test_a_weak_edge_holds_what_a_strong_one_cuts():
    pairs = np.array([[0, 1], [1, 2], [2, 3]])
    labels = join_light_edges(4, pairs, np.array([0.1, 0.9, 0.1]), threshold=0.2)
    assert labels.tolist() == [0, 0, 1, 1]
    assert join_light_edges(4, pairs, np.array([0.1, 0.9, 0.1]), threshold=5.0).tolist() == [0] * 4


def test_items_without_size_join_their_first_neighbour():
    labels = join_light_edges(
        3, np.array([[0, 1], [1, 2]]), np.array([5.0, 9.0]), threshold=0.0, sizes=np.zeros(3)
    )
    assert labels.tolist() == [0, 0, 0]


def test_no_edges_no_pieces():
    assert join_light_edges(3, np.empty((0, 2), int), np.empty(0), threshold=1.0).tolist() == [0, 1, 2]


@pytest.mark.parametrize("threshold", [-0.1, np.nan])
def test_a_bad_threshold_is_refused(threshold):
    with pytest.raises(ValueError, match="threshold must be at least 0"):
        join_light_edges(2, np.array([[0, 1]]), np.ones(1), threshold=threshold)


def by_whole_seams(n, pairs, weights, lengths, c, sizes):
    """Pieces after joining the two of least mean weight again and again, while that is light for both."""
    home, limit = np.arange(n), {i: c / sizes[i] for i in range(n)}
    while True:
        best = (np.inf, -1, -1)
        for a, b in {tuple(sorted(e)) for e in home[pairs].tolist() if e[0] != e[1]}:
            along = (np.sort(home[pairs], axis=1) == (a, b)).all(axis=1)
            w = (weights * lengths)[along].sum() / lengths[along].sum()
            if w <= min(limit[a], limit[b]):
                best = min(best, (w, a, b))
        if best[1] < 0:
            return home
        w, a, b = best
        home[home == b] = a
        limit[a] = w + c / sizes[home == a].sum()


@given(graphs(), st.floats(0, 2))
def test_pieces_along_seams_are_those_of_the_definition(graph, c):
    n, pairs, _ = graph
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    rng = np.random.default_rng(n + len(pairs))
    weights, lengths = rng.random((2, len(pairs))) + 0.01
    sizes = rng.random(n) + 0.1
    labels = join_along_seams(pairs, weights, lengths, threshold=c, sizes=sizes)
    expected = by_whole_seams(n, pairs, weights, lengths, c, sizes)
    np.testing.assert_array_equal(labels[:, None] == labels, expected[:, None] == expected)
