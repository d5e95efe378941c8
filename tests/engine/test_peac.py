"""PEAC: the objective and its gradient, monotonicity, recovery of blocks, agreement with a generic solver."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import approx_fprime, minimize

from scenewidget.engine.consensus import co_association
from scenewidget.engine.linkage import average_linkage
from scenewidget.engine.monitor import Cancelled, Monitor
from scenewidget.engine.peac import _Problem, peac


def objective(C, weights, Y, *, diagonal=True):
    """Eq. 3.14 from its definition, weights normalised as peac does."""
    weights = np.asarray(weights, float)
    W = np.outer(weights, weights) / weights.sum() ** 2 if weights.ndim == 1 else weights / weights.sum()
    W = W if diagonal else W - np.diag(np.diag(W))
    return float((W * (C - Y.T @ Y) ** 2).sum())


def gradient(C, W, Y):
    return -4 * Y @ (W * (C - Y.T @ Y))


def blocks(sizes):
    part = np.repeat(np.arange(len(sizes)), sizes)
    return (part[:, None] == part).astype(float), part


def coassociation(seed, n=12, runs=8, k=4):
    keys = np.random.default_rng(seed).integers(0, k, (n, runs))
    return (keys[:, None] == keys).mean(axis=2)


@st.composite
def problems(draw):
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    C = coassociation(seed, draw(st.integers(2, 14)), draw(st.integers(1, 8)))
    weights = rng.exponential(size=len(C)) * (rng.random(len(C)) < 0.9) + 1e-12
    return C, weights, draw(st.integers(1, 6))


def stationarity(C, W, Y, *, diagonal=True):
    """Largest first-order gain of moving probability within a column, per unit of the column's weight."""
    W = W if diagonal else W - np.diag(np.diag(W))
    slope = gradient(C, W, Y)
    worst = np.where(Y > 1e-9, slope, -np.inf).max(axis=0) - slope.min(axis=0)
    total = W.sum(axis=1)
    return (worst[total > 0] / (4 * total[total > 0])).max(initial=0)


def test_the_gradient_is_that_of_finite_differences():
    rng = np.random.default_rng(0)
    C, W = coassociation(0, 5), rng.random((5, 5))
    W = W + W.T
    Y = rng.dirichlet(np.ones(3), size=5).T
    numeric = approx_fprime(Y.ravel(), lambda y: (W * (C - y.reshape(3, 5).T @ y.reshape(3, 5)) ** 2).sum())
    np.testing.assert_allclose(gradient(C, W, Y).ravel(), numeric, atol=1e-5)


@given(problems(), st.booleans())
def test_the_result_is_feasible_stationary_and_its_objective_is_true(problem, diagonal):
    C, weights, m = problem
    result = peac(C, weights, m, diagonal=diagonal, tolerance=1e-6)
    assert result.Y.shape == (m, len(C))
    assert result.Y.min() >= 0
    np.testing.assert_allclose(result.Y.sum(axis=0), 1, atol=1e-9)
    np.testing.assert_array_equal(result.labels, result.Y.argmax(axis=0))
    assert result.objective == pytest.approx(objective(C, weights, result.Y, diagonal=diagonal), abs=1e-12)
    assert result.converged == (result.violation <= 1e-6)
    if result.converged:
        a = weights / weights.sum()
        heavy = a > 1e-6  # the slope of weightless columns drowns in rounding
        W = np.outer(a, a)
        slack = stationarity(
            C[np.ix_(heavy, heavy)], W[np.ix_(heavy, heavy)], result.Y[:, heavy], diagonal=diagonal
        )
        assert slack < 1e-4


@given(problems(), st.sampled_from(["linkage", "dirichlet"]), st.booleans())
@settings(max_examples=30)
def test_the_objective_never_rises_from_sweep_to_sweep(problem, init, diagonal):
    C, weights, m = problem
    values = [
        peac(C, weights, m, diagonal=diagonal, init=init, tolerance=1e-9, max_sweeps=n).objective
        for n in range(12)
    ]
    assert (np.diff(values) <= 1e-12).all()


@pytest.mark.parametrize("m", [4, 5, 9])
def test_unconnected_blocks_are_recovered_exactly(m):
    C, part = blocks([3, 1, 5, 2])
    result = peac(C, np.arange(1.0, 12.0), m)
    assert result.objective == pytest.approx(0, abs=1e-9)
    assert result.converged
    np.testing.assert_array_equal(result.labels[:, None] == result.labels, part[:, None] == part)
    assert result.Y.max(axis=0).min() > 0.99


@pytest.mark.parametrize("diagonal", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_restarts_are_as_good_as_a_generic_solver_from_many_starts(seed, diagonal):
    n, m = 5, 3
    C = coassociation(seed, n, 6, 3)
    weights = np.random.default_rng(seed).uniform(0.5, 2, n)
    a = weights / weights.sum()
    W = np.outer(a, a)
    W = W if diagonal else W - np.diag(np.diag(W))

    def f(y):
        return (W * (C - y.reshape(m, n).T @ y.reshape(m, n)) ** 2).sum()

    def slope(y):
        return gradient(C, W, y.reshape(m, n)).ravel()

    sums = {
        "type": "eq",
        "fun": lambda y: y.reshape(m, n).sum(axis=0) - 1,
        "jac": lambda y: np.tile(np.eye(n), m),
    }
    rng = np.random.default_rng(seed)
    best = min(
        minimize(
            f, rng.dirichlet(np.ones(m), size=n).T.ravel(), jac=slope, bounds=[(0, 1)] * (m * n),
            constraints=sums, method="SLSQP", options={"ftol": 1e-13, "maxiter": 500},
        ).fun
        for _ in range(25)
    )  # fmt: skip
    ours = peac(C, weights, m, diagonal=diagonal, n_restarts=25, tolerance=1e-8).objective
    assert ours == pytest.approx(best, abs=2e-6)


@given(problems(), st.booleans())
@settings(max_examples=50)
def test_weights_for_pairs_that_are_products_give_what_areas_give(problem, diagonal):
    C, weights, m = problem
    weights = weights + 0.1
    a = peac(C, weights, m, diagonal=diagonal, n_seeds=0, tolerance=1e-7)
    W = peac(C, np.outer(weights, weights), m, diagonal=diagonal, n_seeds=0, tolerance=1e-7)
    assert W.objective == pytest.approx(a.objective, rel=1e-4, abs=1e-8)
    rows = np.random.default_rng(0).dirichlet(np.ones(m), size=len(C))
    a, W = weights / weights.sum(), np.outer(weights, weights) / weights.sum() ** 2
    fast, plain = _Problem(C, a, diagonal), _Problem(C, W, diagonal)
    P, S = fast.products(rows)
    np.testing.assert_allclose(fast.residuals(rows, P, S), plain.residuals(rows, P, S), atol=1e-12)
    np.testing.assert_allclose(
        fast.residuals(rows, P, S).sum(), objective(C, weights, rows.T, diagonal=diagonal)
    )
    joining = [problem.cost_of_joining(rows, P, S) for problem in (fast, plain)]
    np.testing.assert_allclose(joining[0], joining[1], atol=1e-12)


@given(problems())
def test_the_cost_of_joining_two_rows_is_what_the_objective_gains(problem):
    """Exact where the rows have no column in common, the diagonal left out."""
    C, weights, _ = problem
    m = 3
    labels = np.random.default_rng(0).integers(0, m, len(C))
    rows = np.eye(m)[labels]
    a = weights / weights.sum()
    helper = _Problem(C, a, False)
    cost = helper.cost_of_joining(rows, *helper.products(rows))
    before = objective(C, weights, rows.T, diagonal=False)
    for r, s in ((0, 1), (0, 2), (1, 2)):
        joined = rows.copy()
        joined[:, r] += joined[:, s]
        joined[:, s] = 0
        gained = objective(C, weights, joined.T, diagonal=False) - before
        assert 2 * cost[r, s] == pytest.approx(gained, abs=1e-12)


@given(problems(), st.booleans(), st.booleans())
@settings(max_examples=50)
def test_new_seeds_never_make_it_worse(problem, diagonal, by_pairs):
    C, weights, m = problem
    weights = np.outer(weights, weights) if by_pairs else weights
    values = [peac(C, weights, m, diagonal=diagonal, n_seeds=n, tolerance=1e-6) for n in (0, 6)]
    assert values[1].objective <= values[0].objective + 1e-9
    assert values[1].converged == values[0].converged


def ensemble_of_the_square(seed, n_base=300, n_runs=20):
    """Points clustered around random centres, other ones in every run: nothing fits exactly."""
    rng = np.random.default_rng(seed)
    points = rng.random((4 * n_base, 2))
    keys = np.stack(
        [
            ((points[:, None] - rng.random((rng.integers(20, 26), 2))) ** 2).sum(axis=2).argmin(axis=1)
            for _ in range(n_runs)
        ],
        axis=1,
    )
    return co_association(keys[:n_base], rng.exponential(size=n_base))


@pytest.mark.parametrize("seed", range(6))
def test_one_call_is_as_good_as_the_best_of_many_random_starts(seed):
    C, weights, _ = ensemble_of_the_square(seed)
    best = peac(C, weights, 10, init="dirichlet", n_restarts=6, n_seeds=0, seed=seed).objective
    assert peac(C, weights, 10).objective <= 1.01 * best


def test_pairs_that_were_never_seen_together_do_not_count():
    C, part = blocks([4, 4])
    W = np.ones((8, 8))
    seen = C.copy()
    unseen = (0, 4), (1, 6), (2, 3)
    for i, j in unseen:
        W[i, j] = W[j, i] = 0
        seen[i, j] = seen[j, i] = 0.5  # whatever stands there
    result = peac(seen, W, 2)
    assert result.objective == pytest.approx(0, abs=1e-9)
    np.testing.assert_array_equal(result.labels[:, None] == result.labels, part[:, None] == part)


def test_the_diagonal_pulls_towards_certainty():
    C = np.full((6, 6), 0.5)
    np.fill_diagonal(C, 1)
    with_it, without = (peac(C, np.ones(6), 2, diagonal=d, init="dirichlet") for d in (True, False))
    assert np.square(with_it.Y).sum() > np.square(without.Y).sum()


def test_one_cluster_has_everything_and_no_more_are_needed_than_columns():
    C = coassociation(1)
    one = peac(C, np.ones(len(C)), 1)
    np.testing.assert_array_equal(one.Y, 1)
    assert one.converged
    many = peac(np.eye(3), np.ones(3), 10)
    assert many.objective == pytest.approx(0, abs=1e-9)
    assert len(set(many.labels.tolist())) == 3


def test_a_single_base_segment_is_certain():
    assert peac(np.ones((1, 1)), np.ones(1), 3).objective == pytest.approx(0, abs=1e-9)


@given(problems())
@settings(max_examples=30)
def test_names_of_base_segments_and_units_of_area_do_not_matter(problem):
    C, weights, m = problem
    first = peac(C, weights, m, tolerance=1e-7)
    scaled = peac(C, 1e6 * weights, m, tolerance=1e-7)
    np.testing.assert_allclose(scaled.Y, first.Y, atol=1e-3)
    assert scaled.objective == pytest.approx(first.objective, abs=1e-7)


def test_an_unfinished_run_says_so():
    result = peac(coassociation(3, 14), np.ones(14), 3, init="dirichlet", max_sweeps=1, tolerance=1e-12)
    assert not result.converged
    assert result.violation > 1e-12
    assert result.n_sweeps == 1


def test_restarts_never_make_it_worse_and_the_seed_decides():
    C = coassociation(5, 14)
    results = [peac(C, np.ones(14), 4, n_restarts=n, seed=7).objective for n in (1, 3, 8)]
    assert results[0] >= results[1] >= results[2]
    again = peac(C, np.ones(14), 4, n_restarts=8, seed=7)
    assert again.objective == results[2]
    sequence = np.random.SeedSequence(7)
    first, second = (peac(C, np.ones(14), 4, init="dirichlet", seed=sequence) for _ in range(2))
    np.testing.assert_array_equal(first.Y, second.Y)


def test_cancel_is_heard():
    class Set:
        def is_set(self):
            return True

    with pytest.raises(Cancelled):
        peac(coassociation(0), np.ones(12), 3, init="dirichlet", monitor=Monitor(cancel=Set()))


TWO = np.eye(2)


@pytest.mark.parametrize(
    ("C", "weights", "m", "options", "error", "message"),
    [
        (np.ones((2, 3)), np.ones(2), 2, {}, ValueError, "C must be a square matrix"),
        (np.empty((0, 0)), np.ones(0), 2, {}, ValueError, "C must be a square matrix"),
        (2 * TWO, np.ones(2), 2, {}, ValueError, "C must hold shares of runs"),
        (TWO * np.nan, np.ones(2), 2, {}, ValueError, "C must hold shares of runs"),
        (np.array([[1, 0.2], [0.3, 1]]), np.ones(2), 2, {}, ValueError, "C must be symmetric"),
        (TWO, np.ones(3), 2, {}, ValueError, r"weights must have shape \(2,\) or \(2, 2\)"),
        (TWO, [-1.0, 2.0], 2, {}, ValueError, "weights must be finite, not negative"),
        (TWO, [0.0, 0.0], 2, {}, ValueError, "not all zero"),
        (TWO, [np.inf, 0.0], 2, {}, ValueError, "weights must be finite"),
        (TWO, np.array([[1.0, 2], [3, 4]]), 2, {}, ValueError, "weights must be symmetric"),
        (TWO, np.ones(2), 0, {}, ValueError, "n_clusters must be at least 1"),
        (TWO, np.ones(2), 1.5, {}, TypeError, "n_clusters must be a whole number"),
        (TWO, np.ones(2), True, {}, TypeError, "n_clusters must be a whole number"),
        (TWO, np.ones(2), 2, {"init": "uniform"}, ValueError, "init must be 'linkage' or 'dirichlet'"),
        (TWO, np.ones(2), 2, {"n_restarts": 0}, ValueError, "n_restarts must be at least 1"),
        (TWO, np.ones(2), 2, {"n_seeds": -1}, ValueError, "n_seeds must be at least 0"),
        (TWO, np.ones(2), 2, {"tolerance": 0.0}, ValueError, "tolerance must be above 0"),
    ],
)  # fmt: skip
def test_bad_arguments_are_refused(C, weights, m, options, error, message):
    with pytest.raises(error, match=message):
        peac(C, weights, m, **options)


def test_a_tree_that_is_there_already_changes_nothing():
    C, weights = coassociation(0), np.random.default_rng(0).exponential(size=12)
    tree = average_linkage(C, weights / weights.sum())
    np.testing.assert_array_equal(peac(C, weights, 3, tree=tree).Y, peac(C, weights, 3).Y)
    with pytest.raises(ValueError, match=r"tree must have shape \(11, 4\), as average_linkage gives it"):
        peac(C, weights, 3, tree=tree[1:])
