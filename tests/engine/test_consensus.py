"""Co-association by its definition, leftover rules by hand, the median partition against all partitions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import ensembles

from scenewidget.engine.consensus import (
    base_segments,
    co_association,
    component_trees,
    median_partition,
    peac_by_component,
    settle_leftovers,
)
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.peac import PeacResult


def together(labels):
    return labels[:, None] == labels


@given(ensembles())
def test_base_segments_are_the_items_with_equal_keys(keys):
    base = base_segments(keys)
    np.testing.assert_array_equal(together(base), (keys[:, None] == keys).all(axis=2))
    _, first = np.unique(base, return_index=True)
    assert (np.diff(first) > 0).all()


@given(ensembles(partial=True))
def test_coassociation_is_the_share_of_runs_that_saw_both(keys):
    weights = np.arange(1.0, len(keys) + 1)
    C, areas, base = co_association(keys, weights)
    seen = (keys[:, None] >= 0) & (keys[None, :] >= 0)
    both = seen.sum(axis=2)
    agree = ((keys[:, None] == keys) & seen).sum(axis=2)
    expected = np.divide(agree, both, out=np.zeros(both.shape), where=both > 0)
    np.testing.assert_allclose(C[np.ix_(base, base)], expected)
    np.testing.assert_allclose(areas, np.bincount(base, weights))


@given(ensembles(), st.permutations(range(5)))
def test_coassociation_ignores_the_names_of_clusters(keys, names):
    renamed = np.array(names)[keys]
    np.testing.assert_array_equal(co_association(renamed).C, co_association(keys).C)


@given(ensembles(), st.data())
def test_coassociation_ignores_the_order_of_runs(keys, data):
    order = data.draw(st.permutations(range(keys.shape[1])))
    np.testing.assert_array_equal(co_association(keys[:, order]).C, co_association(keys).C)


@pytest.mark.parametrize(
    ("keys", "weights", "message"),
    [
        (np.zeros(3, int), None, "keys must be whole numbers of shape"),
        (np.zeros((3, 2)), None, "keys must be whole numbers of shape"),
        (np.zeros((3, 0), int), None, "keys has no runs"),
        (np.zeros((0, 3), int), None, "keys has no items"),
        (np.zeros((3, 2), int), np.ones(2), r"weights must have one entry an item: \(3,\)"),
        (np.zeros((3, 2), int), -np.ones(3), "weights must be finite and not negative"),
    ],
)
def test_bad_keys_are_refused(keys, weights, message):
    with pytest.raises(ValueError, match=message):
        co_association(keys, weights)


# --- leftovers ------------------------------------------------------------------------------------


def result(Y):
    Y = np.array(Y)
    return PeacResult(Y, Y.argmax(axis=0).astype(np.int32), 0.0, 0.0, True, 1)


SOFT = result([[0.9, 0.8, 0.4, 0.35, 0.1], [0.1, 0.2, 0.3, 0.4, 0.9], [0.0, 0.0, 0.3, 0.25, 0.0]])
C = np.array(
    [
        [1.0, 0.9, 0.1, 0.1, 0.0],
        [0.9, 1.0, 0.1, 0.1, 0.0],
        [0.1, 0.1, 1.0, 0.8, 0.1],
        [0.1, 0.1, 0.8, 1.0, 0.1],
        [0.0, 0.0, 0.1, 0.1, 1.0],
    ]
)
AREAS = np.array([1.0, 2.0, 3.0, 3.0, 1.0])


def test_columns_without_a_majority_stay_alone():
    labels, share = settle_leftovers(SOFT, C, AREAS, "alone")
    np.testing.assert_array_equal(together(labels), together(np.array([0, 0, 1, 2, 3])))
    assert share == pytest.approx(0.6)


def test_columns_without_a_majority_take_the_largest_entry():
    labels, share = settle_leftovers(SOFT, C, AREAS, "argmax")
    np.testing.assert_array_equal(together(labels), together(np.array([0, 0, 0, 1, 1])))
    assert share == pytest.approx(0.6)


def test_columns_without_a_majority_are_grouped_by_linkage():
    labels, _ = settle_leftovers(SOFT, C, AREAS, "linkage")
    np.testing.assert_array_equal(together(labels), together(np.array([0, 0, 1, 1, 2])))


def test_linkage_gives_leftovers_to_a_settled_cluster_that_they_belong_to():
    close = C.copy()
    close[2, :2] = close[:2, 2] = close[3, :2] = close[:2, 3] = 0.7
    labels, _ = settle_leftovers(SOFT, close, AREAS, "linkage")
    np.testing.assert_array_equal(together(labels), together(np.array([0, 0, 0, 0, 1])))


def test_settled_clusters_never_merge():
    alike = np.ones((5, 5))
    labels, _ = settle_leftovers(SOFT, alike, AREAS, "linkage")
    assert labels[0] == labels[1] != labels[4]


def test_a_half_is_enough():
    labels, share = settle_leftovers(result([[0.5, 0.5], [0.5, 0.5]]), np.ones((2, 2)), np.ones(2))
    assert labels.tolist() == [0, 0]
    assert share == 0


def test_an_unknown_rule_is_refused():
    with pytest.raises(ValueError, match="leftover must be 'alone', 'argmax' or 'linkage', got 'none'"):
        settle_leftovers(SOFT, C, AREAS, "none")


# --- median partition -----------------------------------------------------------------------------


def partitions(n):
    """All partitions of n items as restricted growth strings."""

    def grow(prefix):
        if len(prefix) == n:
            yield np.array(prefix)
            return
        for label in range(max(prefix) + 2):
            yield from grow([*prefix, label])

    yield from grow([0])


def disagreement(C, a, labels):
    W = np.outer(a, a)
    np.fill_diagonal(W, 0)
    return (W * (C - together(labels)) ** 2).sum()


@st.composite
def weighted(draw, max_items):
    keys = draw(ensembles(max_items, 6))
    C, _, _ = co_association(keys)
    a = np.random.default_rng(draw(st.integers(0, 2**32 - 1))).exponential(size=len(C))
    return C, a


@given(weighted(7))
@settings(max_examples=60)
def test_the_median_partition_is_between_the_linkage_cut_and_the_optimum(problem):
    C, a = problem
    ours = disagreement(C, a, median_partition(C, a))
    linkage = disagreement(C, a, cut_tree(average_linkage(C, a), similarity=0.5))
    best = min(disagreement(C, a, labels) for labels in partitions(len(C)))
    assert best - 1e-9 <= ours <= linkage + 1e-9


def test_the_median_partition_is_mostly_the_optimum():
    hits = 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        C, _, _ = co_association(rng.integers(0, 3, (6, 5)))
        a = rng.exponential(size=len(C))
        best = min(disagreement(C, a, labels) for labels in partitions(len(C)))
        hits += disagreement(C, a, median_partition(C, a)) <= best + 1e-9
    assert hits >= 25


@given(weighted(9))
def test_no_single_move_improves_the_median_partition(problem):
    C, a = problem
    labels = median_partition(C, a)
    assert labels.dtype == np.int32
    _, first = np.unique(labels, return_index=True)
    assert (np.diff(first) > 0).all()
    now = disagreement(C, a, labels)
    for i in range(len(C)):
        for target in range(labels.max() + 2):
            moved = labels.copy()
            moved[i] = target
            assert disagreement(C, a, moved) >= now - 1e-9


def test_a_unanimous_ensemble_is_its_own_median():
    part = np.array([0, 0, 1, 2, 2, 2])
    np.testing.assert_array_equal(median_partition(together(part).astype(float), np.ones(6)), part)


@given(ensembles(), st.integers(0, 99))
def test_sums_between_groups_match_their_definition(keys, seed):
    rng = np.random.default_rng(seed)
    co, areas = co_association(keys), rng.random(len(keys))
    group = rng.integers(-1, 3, len(keys))
    between = co.between(group, areas, 3)
    C = co.C[np.ix_(co.base, co.base)]
    for g in range(3):
        weight = areas * (group == g)
        for h in range(3):
            np.testing.assert_allclose(between[g, h], weight @ C @ (areas * (group == h)), atol=1e-12)


def test_peac_is_solved_in_each_component_with_its_share():
    block = np.repeat(np.arange(4), 5)
    co = co_association(np.stack([block, block // 2, np.arange(20)], axis=1))
    component = block // 2
    trees = component_trees(co, component)
    labels = peac_by_component(co, component, np.array([0.5, 0.5]), 4, trees=trees, leftover="argmax")
    assert len(set(labels.tolist())) == 4
    assert not set(labels[co.base[component == 0]]) & set(labels[co.base[component == 1]])
    one = peac_by_component(co, component, np.array([0.5, 0.5]), 2, trees=trees)
    np.testing.assert_array_equal(one[co.base], component)
