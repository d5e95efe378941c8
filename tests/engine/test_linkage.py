"""Average linkage against scipy's, with weights by replication, and cuts by their definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.cluster import hierarchy
from scipy.spatial.distance import squareform

from scenewidget.engine.linkage import average_linkage, cut_tree


@st.composite
def similarities(draw, max_items=10):
    """Symmetric matrices without ties, ones on the diagonal."""
    n = draw(st.integers(2, max_items))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    C = rng.random((n, n))
    C = (C + C.T) / 2
    np.fill_diagonal(C, 1)
    return C


def together(labels):
    return labels[:, None] == labels


@given(similarities())
def test_equal_weights_give_the_average_linkage_of_scipy(C):
    tree = average_linkage(C, np.ones(len(C)))
    expected = hierarchy.average(squareform(1 - C, checks=False))
    np.testing.assert_allclose(tree[:, 2:], expected[:, 2:], atol=1e-12)
    np.testing.assert_array_equal(np.sort(tree[:, :2], axis=1), np.sort(expected[:, :2], axis=1))


@given(similarities(6), st.data())
def test_an_item_of_weight_n_is_n_items_at_one_place(C, data):
    weights = np.array(data.draw(st.lists(st.integers(1, 3), min_size=len(C), max_size=len(C))))
    copies = np.repeat(np.arange(len(C)), weights)
    expected = hierarchy.average(squareform(1 - C[np.ix_(copies, copies)], checks=False))
    heights = expected[len(copies) - len(C) :, 2]  # after the copies have merged at height 0
    np.testing.assert_allclose(average_linkage(C, weights)[:, 2], heights, atol=1e-12)


@given(similarities(), st.data())
def test_a_cut_has_as_many_clusters_as_asked_for_and_is_that_of_scipy(C, data):
    k = data.draw(st.integers(1, len(C)))
    labels = cut_tree(average_linkage(C, np.ones(len(C))), n_clusters=k)
    assert labels.max() + 1 == k
    expected = hierarchy.cut_tree(hierarchy.average(squareform(1 - C, checks=False)), n_clusters=k).ravel()
    np.testing.assert_array_equal(together(labels), together(expected))
    _, first = np.unique(labels, return_index=True)
    assert (np.diff(first) > 0).all()  # numbered by first appearance


@given(similarities(), st.floats(0, 1))
def test_a_cut_by_similarity_merges_what_is_at_least_so_alike(C, similarity):
    tree = average_linkage(C, np.ones(len(C)))
    labels = cut_tree(tree, similarity=similarity)
    expected = hierarchy.fcluster(tree, 1 - similarity, criterion="distance")
    if np.abs(tree[:, 2] - (1 - similarity)).min() > 1e-9:
        np.testing.assert_array_equal(together(labels), together(expected))


def test_a_similarity_equal_to_a_merge_includes_it():
    C = np.array([[1, 0.7, 0], [0.7, 1, 0], [0, 0, 1.0]])
    assert cut_tree(average_linkage(C, np.ones(3)), similarity=0.7).tolist() == [0, 0, 1]


@given(similarities(), st.data())
def test_heights_ascend_whatever_the_weights(C, data):
    weights = np.array(data.draw(st.lists(st.floats(0, 10), min_size=len(C), max_size=len(C))))
    tree = average_linkage(C, weights)
    assert np.isfinite(tree).all()
    assert (np.diff(tree[:, 2]) >= -1e-12).all()
    assert tree[-1, 3] == len(C)
    assert sorted(tree[:, :2].ravel().tolist()) == list(range(2 * len(C) - 2))


def test_cuts_of_ties_are_nested_partitions():
    C = np.ones((7, 7))
    tree = average_linkage(C, np.ones(7))
    for k in range(1, 8):
        assert cut_tree(tree, n_clusters=k).max() + 1 == k


def test_one_item_and_more_clusters_than_items():
    tree = average_linkage(np.ones((1, 1)), np.ones(1))
    assert tree.shape == (0, 4)
    assert cut_tree(tree, n_clusters=3).tolist() == [0]
    assert cut_tree(average_linkage(np.eye(2), np.ones(2)), n_clusters=9).tolist() == [0, 1]


def test_a_cut_needs_exactly_one_rule():
    tree = average_linkage(np.eye(3), np.ones(3))
    for options in ({}, {"n_clusters": 2, "similarity": 0.5}):
        with pytest.raises(ValueError, match="give either n_clusters or similarity"):
            cut_tree(tree, **options)


def test_matrices_that_differ_from_their_transpose_in_the_last_bit_give_a_tree():
    for seed in range(2_000):  # one in two hundred sent the chains in circles
        rng = np.random.default_rng(seed)
        C = np.round(4 * rng.random((8, 8))) / 4  # full of ties, as shares of a few runs are
        C = (C + C.T) / 2 + 1e-16 * rng.integers(-1, 2, C.shape)
        np.fill_diagonal(C, 1)
        tree = average_linkage(C, rng.random(8))
        np.testing.assert_array_equal(np.sort(tree[:, :2].ravel()), np.arange(14))


def test_pairs_that_nobody_saw_count_for_nothing():
    """Against the definition: the tree's heights are ratios over what was seen."""
    rng = np.random.default_rng(4)
    keys = rng.integers(-1, 3, (40, 3))
    keys = keys[(keys >= 0).any(axis=1)]
    weights = rng.uniform(0.1, 2.0, len(keys))
    is_seen = (keys >= 0).astype(float)
    seen = is_seen @ is_seen.T
    together = sum(np.equal.outer(k, k) & np.outer(k >= 0, k >= 0) for k in keys.T).astype(float)
    C = np.divide(together, seen, out=np.zeros_like(seen), where=seen > 0)
    tree = average_linkage(C, weights, seen)
    members = [[i] for i in range(len(keys))]
    for left, right, height, size in tree:
        a, b = members[int(left)], members[int(right)]
        mass = np.outer(weights[a], weights[b])
        pairs = (mass * seen[np.ix_(a, b)]).sum()
        mean = (mass * together[np.ix_(a, b)]).sum() / pairs if pairs > 0 else -1.0
        assert height == pytest.approx(1 - mean)
        members.append(a + b)
        assert size == len(members[-1])
    assert (np.diff(tree[:, 2]) >= 0).all()


def test_a_tree_of_what_all_saw_is_the_plain_one():
    C = np.random.default_rng(5).random((30, 30))  # no ties
    C = (C + C.T) / 2
    weights = np.linspace(1, 2, 30)
    np.testing.assert_allclose(average_linkage(C, weights, np.full((30, 30), 4)), average_linkage(C, weights))
