"""k-medoids against its definition by brute force, on distances with ties and unconnected parts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import distance_matrices
from transcriptions import algorithm_2, nearest, total

from scenewidget.engine.kmedoids import INITS, alternate, initial_medoids, k_medoids

LINE = np.abs(np.subtract.outer([0.0, 1, 2, 10, 11, 12], [0.0, 1, 2, 10, 11, 12]))


def cost_of(D, medoids):
    reach = D[:, medoids].astype(float).min(axis=1)
    return reach[np.isfinite(reach)].sum()


@st.composite
def problems(draw):
    D = draw(distance_matrices())
    return D, draw(st.integers(1, len(D))), draw(st.integers(0, 99))


@given(problems(), st.sampled_from(INITS))
def test_result_is_a_fixed_point_of_assignment_and_update(problem, init):
    D, k, seed = problem
    result = k_medoids(D, k, init=init, seed=seed)
    assert len(set(result.medoids.tolist())) == k
    np.testing.assert_array_equal(result.labels, nearest(D, result.medoids))
    assert result.cost == pytest.approx(cost_of(D, result.medoids), rel=1e-9)
    moved = result.medoids.copy()
    for c in range(k):
        members = np.flatnonzero(result.labels == c)
        sums = D[np.ix_(members, members)].astype(float).sum(axis=1)
        own = D[result.medoids[c], members].astype(float).sum()
        if sums.min() < own:
            moved[c] = members[sums.argmin()]
    assert cost_of(D, moved) >= result.cost * (1 - 1e-12)  # one more update would not lower the cost


@given(problems())
def test_cost_falls_with_every_update(problem):
    D, k, seed = problem
    start = initial_medoids(D, k, seed=seed)
    assert alternate(D, start).cost <= cost_of(D, start) * (1 + 1e-12)


@given(problems())
def test_unreachable_items_are_in_no_cluster(problem):
    D, k, seed = problem
    result = k_medoids(D, k, seed=seed)
    out_of_reach = np.isinf(D[:, result.medoids]).all(axis=1)
    np.testing.assert_array_equal(result.labels == -1, out_of_reach)


def plain_alternate(D, medoids):
    """By definition, a medoid stays unless another is better: every assignment and every sum anew."""

    def cost_of(medoids):
        return total(d for d in D[:, medoids].min(axis=1) if np.isfinite(d))

    labels, cost = nearest(D, medoids), cost_of(medoids)
    for n_iter in range(1, 101):
        moved = medoids.copy()
        for c in range(len(medoids)):
            members = np.flatnonzero(labels == c)
            sums = [total(D[i, members]) for i in members]
            if min(sums) < total(D[medoids[c], members]):
                moved[c] = members[int(np.argmin(sums))]
        if not cost_of(moved) < cost:
            return labels, medoids, n_iter
        medoids, labels, cost = moved, nearest(D, moved), cost_of(moved)
    raise AssertionError("no end")


@st.composite
def larger_problems(draw):
    """Enough items for many updates, of which most change a few clusters only; ties, uneven sizes, parts."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(30, 150))
    on_lattice = draw(st.booleans())
    points = rng.integers(0, 12, (n, 2)).astype(float) if on_lattice else rng.lognormal(0, 2, (n, 2))
    D = np.abs(points[:, None] - points).sum(axis=2)
    part = rng.integers(0, draw(st.integers(1, 2)), n)
    D = np.where(part[:, None] == part, D, np.inf).astype(draw(st.sampled_from([np.float32, np.float64])))
    return D, rng.choice(n, draw(st.integers(1, 12)), replace=False).astype(np.int32)


@given(larger_problems())
@settings(max_examples=50)
def test_looking_only_at_what_changed_gives_what_the_definition_gives(problem):
    D, start = problem
    result = alternate(D, start)
    labels, medoids, n_iter = plain_alternate(D, start)
    np.testing.assert_array_equal(result.labels, labels)
    np.testing.assert_array_equal(result.medoids, medoids)
    assert result.n_iter == n_iter


@given(larger_problems())
@settings(max_examples=100)
def test_ties_to_the_first_give_what_the_printed_algorithm_gives(problem):
    D, start = problem
    result = alternate(D, start, "first")
    labels, medoids, n_iter = algorithm_2(D, start)
    np.testing.assert_array_equal(result.medoids, medoids)
    np.testing.assert_array_equal(result.labels, labels)
    assert result.n_iter == n_iter


@given(problems())
def test_small_problems_full_of_ties_follow_the_printed_algorithm_too(problem):
    D, k, seed = problem
    result = k_medoids(D, k, seed=seed, ties="first")
    labels, medoids, _ = algorithm_2(D, initial_medoids(D, k, seed=seed))
    np.testing.assert_array_equal(result.medoids, medoids)
    np.testing.assert_array_equal(result.labels, labels)


def test_of_members_with_equal_sums_the_first_or_the_medoid_itself():
    D = np.array([[0, 1, 1, 1], [1, 0, 1, 1], [1, 1, 0, 1], [1, 1, 1, 0]], dtype=float)
    assert alternate(D, np.array([2], dtype=np.int32)).medoids.tolist() == [2]
    assert alternate(D, np.array([2], dtype=np.int32), "first").medoids.tolist() == [0]
    zero = np.zeros((4, 4))
    assert alternate(zero, np.array([3], dtype=np.int32), "first").medoids.tolist() == [0]


def test_two_groups_on_a_line_are_found_with_their_middles():
    result = alternate(LINE, np.array([0, 1], dtype=np.int32))
    assert sorted(result.medoids.tolist()) == [1, 4]
    assert result.labels[0] == result.labels[1] == result.labels[2]
    assert result.labels[3] == result.labels[4] == result.labels[5] != result.labels[0]
    assert result.cost == 4


def test_one_cluster_has_the_item_with_the_least_sum():
    assert k_medoids(LINE, 1).medoids.tolist() == [int(LINE.sum(axis=1).argmin())]


@given(distance_matrices())
def test_as_many_clusters_as_items_give_each_its_own(D):
    result = k_medoids(D, len(D), seed=1)
    assert sorted(result.medoids.tolist()) == list(range(len(D)))
    np.testing.assert_array_equal(result.medoids[result.labels], np.arange(len(D)))
    assert result.cost == 0


def test_items_at_distance_zero_stay_distinct_medoids():
    result = k_medoids(np.zeros((5, 5)), 3)
    assert len(set(result.medoids.tolist())) == 3
    np.testing.assert_array_equal(result.labels[result.medoids], [0, 1, 2])


@given(problems(), st.sampled_from(INITS))
def test_same_seed_same_result(problem, init):
    D, k, seed = problem
    first, second = (k_medoids(D, k, init=init, seed=seed) for _ in range(2))
    np.testing.assert_array_equal(first.labels, second.labels)
    np.testing.assert_array_equal(first.medoids, second.medoids)


@given(problems(), st.sampled_from(INITS))
def test_every_start_is_k_distinct_items(problem, init):
    D, k, seed = problem
    medoids = initial_medoids(D, k, init=init, seed=seed)
    assert medoids.dtype == np.int32
    assert len(set(medoids.tolist())) == k
    assert 0 <= medoids.min() <= medoids.max() < len(D)


def test_outmost_items_of_unconnected_parts_are_far_from_the_centres_of_their_own_parts():
    D = np.full((10, 10), np.inf)
    for start, places in ((0, [0.0, 1, 2, 3, 9]), (5, [0.0, 5, 6]), (8, [0.0, 1])):
        inside = slice(start, start + len(places))
        D[inside, inside] = np.abs(np.subtract.outer(places, places))
    assert initial_medoids(D, 2, init="outmost").tolist() == [4, 5]  # the ends of the two larger parts
    assert initial_medoids(D, 3, init="outmost").tolist() == [4, 5, 9]
    assert initial_medoids(D, 5, init="outmost").tolist() == [4, 5, 9, 0, 1]
    assert (k_medoids(D, 3, init="outmost").labels >= 0).all()


@given(problems())
def test_outmost_reaches_every_part_that_it_can(problem):
    D, k, _ = problem
    parts = [set(np.flatnonzero(row).tolist()) for row in np.unique(np.isfinite(D), axis=0)]
    medoids = set(initial_medoids(D, k, init="outmost").tolist())
    reached = sum(bool(part & medoids) for part in parts)
    assert reached == min(k, len(parts))


def test_starts_follow_park_and_jun():
    totals = LINE.sum(axis=1)
    by_total = np.argsort(totals, kind="stable")
    assert initial_medoids(LINE, 3, init="systematic").tolist() == by_total[[0, 2, 4]].tolist()
    farthest = np.argsort(-LINE[totals.argmin()], kind="stable")
    assert initial_medoids(LINE, 2, init="outmost").tolist() == farthest[:2].tolist()
    random = [initial_medoids(LINE, 2, seed=seed).tolist() for seed in range(200)]
    assert {m for pair in random for m in pair} == set(range(6))


def test_plus_plus_takes_a_start_in_each_unconnected_part():
    part = np.arange(12) // 4
    D = np.where(part[:, None] == part, 1.0 - np.eye(12), np.inf)
    for seed in range(10):
        assert set(part[initial_medoids(D, 3, init="k-medoids++", seed=seed)]) == {0, 1, 2}


def test_plus_plus_prefers_far_items():
    near = 1e-3 * np.abs(np.subtract.outer(np.arange(9.0), np.arange(9.0)))
    D = np.full((10, 10), 1000.0)
    D[:9, :9], D[9, 9] = near, 0
    hits = [9 in initial_medoids(D, 2, init="k-medoids++", seed=seed) for seed in range(50)]
    assert all(hits)


def test_whole_numbers_are_distances_too():
    assert k_medoids(LINE.astype(int), 2).cost == k_medoids(LINE, 2).cost


@pytest.mark.parametrize(
    ("D", "k", "options", "error", "message"),
    [
        (LINE, 0, {}, ValueError, r"k must lie in 1\.\.6"),
        (LINE, 7, {}, ValueError, r"k must lie in 1\.\.6"),
        (LINE, 2.0, {}, TypeError, "k must be a whole number"),
        (LINE, True, {}, TypeError, "k must be a whole number"),
        (LINE[:3], 2, {}, ValueError, "D must be a square matrix"),
        (np.empty((0, 0)), 1, {}, ValueError, "D must be a square matrix"),
        (-LINE, 2, {}, ValueError, "no negative values and no NaN"),
        (np.where(LINE > 5, np.nan, LINE), 2, {}, ValueError, "no negative values and no NaN"),
        (LINE, 2, {"init": "best"}, ValueError, "init must be one of 'random', 'systematic'"),
        (LINE, 2, {"backend": "cuda"}, ValueError, "backend must be one of 'numpy', 'sklearn-extra'"),
        (LINE, 2, {"ties": "last"}, ValueError, "ties must be one of 'stay', 'first', got 'last'"),
        (LINE, 2, {"backend": "sklearn-extra", "ties": "first"}, ValueError, "use backend='numpy'"),
    ],
)
def test_bad_arguments_are_refused(D, k, options, error, message):
    with pytest.raises(error, match=message):
        k_medoids(D, k, **options)
