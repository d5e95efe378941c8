"""Probabilistic evidence accumulation: soft assignments that explain a co-association matrix.

Goes in: how often two base segments fall together, and how much each pair counts. Comes out: Y, a column
of probabilities for each base segment. Rota Bulò et al. (2010), S+SSPR; Lourenço et al. (2015), Machine
Learning 98; thesis 3.5, Eq. 3.14.

Solved by block-coordinate descent, a column at a time, moving probability between two rows at a time by
exact line search. Each step lowers the objective, so it ends in a stationary point, which often has one
row for two things and two rows for one. So the two rows that cost least to join are joined, the row that
this frees starts anew where the residual is largest, and the descent goes on from there; what ends lower
is kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from scenewidget.engine.checks import checked_count
from scenewidget.engine.kernels import kernel
from scenewidget.engine.linkage import average_linkage, cut_tree
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.threads import one_blas_thread

__all__ = ["PeacResult", "peac"]


@dataclass(frozen=True, eq=False)
class PeacResult:
    """A consensus and how well it was solved.

    Attributes
    ----------
    Y : (n_clusters, n_base) float64
        Probability of each cluster for each base segment; columns sum to 1.
    labels : (n_base,) int32
        Row of the largest entry of each column. The rule for columns below ½ is the caller's.
    objective : float
        Σ w_ij (c_ij − y_i·y_j)², weights normalised to Σ a = 1 (or Σ w = 1).
    violation : float
        Largest gain rate left, relative to the weight of a column: 0 at a stationary point.
    converged : bool
        Whether ``violation`` came below the tolerance.
    n_sweeps : int
        Passes over all columns, those of new seeds included.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.peac import peac
    >>> result = peac(np.eye(3), np.ones(3), 3)
    >>> sorted(result.labels.tolist()), result.converged
    ([0, 1, 2], True)
    """

    Y: FloatArray
    labels: IntArray
    objective: float
    violation: float
    converged: bool
    n_sweeps: int


def peac(
    C: FloatArray,
    weights: FloatArray,
    n_clusters: int,
    *,
    diagonal: bool = True,
    init: Literal["linkage", "dirichlet"] = "linkage",
    tree: FloatArray | None = None,
    n_restarts: int = 1,
    n_seeds: int = 6,
    tolerance: float = 1e-4,
    max_sweeps: int = 500,
    seed: int | np.random.SeedSequence = 0,
    monitor: Monitor | None = None,
) -> PeacResult:
    """Minimise Σ w_ij (c_ij − y_i·y_j)² over columns y_j in the simplex (Eq. 3.14).

    Parameters
    ----------
    C : (n_base, n_base) float
        Symmetric co-association in [0, 1].
    weights : (n_base,) or (n_base, n_base) float
        Areas a, for w_ij = a_i a_j (the fast case); or w itself, symmetric, 0 where a pair was never
        observed together (partial evidence: Lourenço et al. 2013).
    n_clusters : int
        Rows of Y: the most clusters that there can be.
    diagonal : bool
        Whether the pairs (i, i) count, as in Eq. 3.14. They pull columns towards certainty.
    init : str
        "linkage" starts from 0.9 · (average-linkage cut) + 0.1 / n_clusters; "dirichlet" from random
        columns (a uniform start is a saddle).
    tree : (n_base − 1, 4) float, optional
        What ``average_linkage(C, areas)`` gave, to save its time.
    n_restarts : int
        Starts, the best objective wins; beyond the first, "dirichlet".
    n_seeds : int
        Most new seeds for a row in each start; after a third of them without a lower objective, no more.
    tolerance : float
        Violation at which to stop.
    max_sweeps : int
        Passes over all columns after which to give up; ``converged`` tells.
    seed : int or SeedSequence
        Decides the random starts and the order of the columns.
    monitor : Monitor, optional
        Told how far it is; stops it on cancel.

    Returns
    -------
    PeacResult

    Raises
    ------
    ValueError
        Shapes, ranges or symmetry are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.peac import peac
    >>> C = np.array([[1.0, 0.9, 0.1], [0.9, 1.0, 0.1], [0.1, 0.1, 1.0]])
    >>> labels = peac(C, np.ones(3), 2).labels.tolist()
    >>> labels[0] == labels[1], labels[0] == labels[2]
    (True, False)
    """
    C, weights = _checked(C, weights, n_clusters)
    if n_restarts < 1:
        raise ValueError(f"n_restarts must be at least 1, got {n_restarts}")
    if n_seeds < 0:
        raise ValueError(f"n_seeds must be at least 0, got {n_seeds}")
    if not tolerance > 0:
        raise ValueError(f"tolerance must be above 0, got {tolerance}")
    monitor = monitor or SILENT
    sequence = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
    best: PeacResult | None = None
    # a fresh copy, because spawning changes the sequence that it is asked of
    children = np.random.SeedSequence(sequence.entropy, spawn_key=sequence.spawn_key).spawn(n_restarts)
    for run, child in enumerate(children):
        rng = np.random.default_rng(child)
        Y = _start(C, weights, n_clusters, init if run == 0 else "dirichlet", tree, rng)
        with one_blas_thread():  # small products between the sweeps; their rounding must not depend on cores
            problem = _Problem(C, weights, diagonal)
            result = _solve(problem, Y, n_seeds, tolerance, max_sweeps, rng, monitor)
        if best is None or result.objective < best.objective:
            best = result
    assert best is not None
    return best


def _checked(C: Any, weights: Any, n_clusters: Any) -> tuple[FloatArray, FloatArray]:
    C = np.ascontiguousarray(C, dtype=np.float64)
    weights = np.ascontiguousarray(weights, dtype=np.float64)
    if C.ndim != 2 or C.shape[0] != C.shape[1] or C.shape[0] == 0:
        raise ValueError(f"C must be a square matrix, got shape {C.shape}")
    if not (C.min() >= -1e-9 and C.max() <= 1 + 1e-9):
        raise ValueError("C must hold shares of runs, in [0, 1] and not NaN; give unobserved pairs weight 0")
    if not _is_symmetric(C, 1e-9):
        raise ValueError("C must be symmetric")
    if weights.shape not in ((len(C),), C.shape):
        raise ValueError(f"weights must have shape ({len(C)},) or {C.shape}, got {weights.shape}")
    if not (weights.min() >= 0 and np.isfinite(weights).all() and weights.sum() > 0):
        raise ValueError("weights must be finite, not negative, and not all zero")
    if weights.ndim == 2 and not _is_symmetric(weights, 1e-9 * float(weights.max())):
        raise ValueError("weights must be symmetric where they are given for pairs")
    checked_count("n_clusters", n_clusters)
    return C, weights / weights.sum()


def _start(
    C: FloatArray, weights: FloatArray, m: int, init: str, tree: FloatArray | None, rng: np.random.Generator
) -> FloatArray:
    n = len(C)
    if init == "dirichlet":
        return np.ascontiguousarray(rng.dirichlet(np.ones(m), size=n))
    if init != "linkage":
        raise ValueError(f"init must be 'linkage' or 'dirichlet', got {init!r}")
    if tree is None:
        areas = weights if weights.ndim == 1 else np.sqrt(np.maximum(np.diag(weights), 1e-300))
        tree = average_linkage(C, areas)
    elif tree.shape != (n - 1, 4):
        raise ValueError(f"tree must have shape ({n - 1}, 4), as average_linkage gives it, got {tree.shape}")
    labels = cut_tree(tree, n_clusters=min(m, n))
    Y = np.full((n, m), 0.1 / m)
    Y[np.arange(n), labels] += 0.9
    return Y


class _Problem:
    """What stays the same from sweep to sweep: C, the weights, and where they are products C in sparse form.

    ``off`` is C without its diagonal: indptr, indices, data of its csr format.
    """

    def __init__(self, C: FloatArray, weights: FloatArray, diagonal: bool) -> None:
        self.C, self.weights, self.diagonal = C, weights, diagonal
        self.own = np.diag(C).copy()
        self.off: Any
        self.squares: FloatArray
        self.is_rank_one = weights.ndim == 1
        self.off, self.squares = _off_diagonal(C, weights) if self.is_rank_one else ((None,) * 3, np.empty(0))

    def products(self, Y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """P = off · diag(a) · Y and S = Yᵀ · diag(a) · Y, where the weights are products."""
        if not self.is_rank_one:
            return np.empty((0, 0)), np.empty((0, 0))
        aY = self.weights[:, None] * Y
        indptr, indices, data = self.off
        return _times(indptr, indices, data, aY), aY.T @ Y

    def residuals(self, Y: FloatArray, P: FloatArray, S: FloatArray) -> FloatArray:
        """(n,) share of each column in the objective."""
        if not self.is_rank_one:
            residual = self.C - Y @ Y.T
            if not self.diagonal:
                np.fill_diagonal(residual, 0.0)
            return np.asarray((self.weights * residual**2).sum(axis=1))
        a, square = self.weights, (Y * Y).sum(axis=1)
        rest = self.squares - 2.0 * (Y * P).sum(axis=1) + (Y @ S * Y).sum(axis=1) - a * square**2
        if self.diagonal:
            rest = rest + a * (self.own - square) ** 2
        return np.asarray(a * np.maximum(rest, 0.0))

    def cost_of_joining(self, Y: FloatArray, P: FloatArray, S: FloatArray) -> FloatArray:
        """(m, m) what the objective gains when row s is added to row r and emptied, overlaps left out."""
        if self.is_rank_one:
            aY, squares = self.weights[:, None] * Y, np.diag(S)
            own = (aY * (Y * Y).sum(axis=1, keepdims=True)).T @ aY
            return np.asarray(np.outer(squares, squares) - 2.0 * (aY.T @ P - S @ S + own))
        residual = self.weights * (self.C - Y @ Y.T)
        np.fill_diagonal(residual, 0.0)
        return np.asarray((Y * Y).T @ self.weights @ (Y * Y) - 2.0 * Y.T @ residual @ Y)


def _solve(
    problem: _Problem,
    Y: FloatArray,
    n_seeds: int,
    tolerance: float,
    max_sweeps: int,
    rng: np.random.Generator,
    monitor: Monitor,
) -> PeacResult:
    """Descent, then new seeds as long as they help; Y holds a column of the paper's Y in each row."""
    P, S = problem.products(Y)
    violation, n_sweeps = _descend(problem, Y, P, S, tolerance, max_sweeps, rng, monitor)
    share = problem.residuals(Y, P, S)
    failed: list[int] = []
    for trial in range(n_seeds if violation <= tolerance and Y.shape[1] > 1 else 0):
        seed = _next_seed(problem.C, share, failed)
        if seed < 0 or len(failed) > n_seeds // 3 or n_sweeps >= max_sweeps or share.sum() < 1e-12:
            break
        monitor.tick(0.6 + 0.4 * trial / n_seeds)
        Y2 = _with_row_at(problem.C, Y, problem.cost_of_joining(Y, P, S), seed)
        P2, S2 = problem.products(Y2)
        found, used = _descend(problem, Y2, P2, S2, 10.0 * tolerance, max_sweeps - n_sweeps, rng, monitor)
        n_sweeps += used
        share2 = problem.residuals(Y2, P2, S2)
        if share2.sum() < (1.0 - 1e-4) * share.sum():
            Y, P, S, share, violation, failed = Y2, P2, S2, share2, found, []
        else:
            failed.append(seed)
    if violation > tolerance and n_sweeps < max_sweeps:
        violation, used = _descend(problem, Y, P, S, tolerance, max_sweeps - n_sweeps, rng, monitor)
        n_sweeps += used
    objective = float(problem.residuals(Y, *problem.products(Y)).sum())
    Y = np.ascontiguousarray(Y.T)
    labels = Y.argmax(axis=0).astype(np.int32)
    return PeacResult(Y, labels, objective, violation, violation <= tolerance, n_sweeps)


def _descend(
    problem: _Problem,
    Y: FloatArray,
    P: FloatArray,
    S: FloatArray,
    tolerance: float,
    max_sweeps: int,
    rng: np.random.Generator,
    monitor: Monitor,
) -> tuple[float, int]:
    """Sweeps over all columns in random order until a stationary point; the violation, and how many.

    Y, P and S are changed in place.
    """
    violation, first = np.inf, 0.0
    weights, own, diagonal = problem.weights, problem.own, problem.diagonal
    indptr, indices, data = problem.off
    for sweep in range(max_sweeps):
        violation = 0.0
        order = rng.permutation(len(Y))
        for chunk in np.array_split(order, max(1, len(Y) // 256)):  # cancel answers between chunks
            if problem.is_rank_one:
                found = _sweep_rank_one(
                    chunk, indptr, indices, data, own, weights, Y, P, S, diagonal, 0.1 * tolerance
                )
            else:
                found = _sweep_general(chunk, problem.C, own, weights, Y, diagonal, 0.1 * tolerance)
            violation = max(violation, float(found))
            monitor.tick()
        first = first or violation
        if violation <= tolerance:
            return violation, sweep + 1
        monitor.tick(0.6 * np.log(first / violation) / max(np.log(first / tolerance), 1e-9))
        if problem.is_rank_one and sweep % 25 == 24:
            P[:], S[:] = problem.products(Y)  # sheds rounding errors
    return float(violation), max_sweeps


def _next_seed(C: FloatArray, share: FloatArray, failed: list[int]) -> int:
    """The column that explains most of the objective, not in the midst of those that failed; or -1."""
    share = np.where((C[failed] > 0.5).any(axis=0), 0.0, share) if failed else share
    seed = int(np.argmax(share))
    return seed if share[seed] > 0 else -1


def _with_row_at(C: FloatArray, Y: FloatArray, cost: FloatArray, seed: int) -> FloatArray:
    """Y with two rows joined, the two that cost least, and the one set free at a column that fits badly.

    It takes most of that column and of those that should be with it more than they are.
    """
    np.fill_diagonal(cost, np.inf)
    stays, goes = np.unravel_index(int(np.argmin(cost)), cost.shape)
    Y = Y.copy()
    missing = C[seed] - Y @ Y[seed]
    Y[:, stays] += Y[:, goes]
    Y[:, goes] = 0.0
    company = missing > 0.05
    company[seed] = True
    Y[company] *= 0.4
    Y[company, goes] += 0.6
    return Y


@kernel
def _is_symmetric(A, absolute):  # type: ignore[no-untyped-def]
    n = len(A)
    for top in range(0, n, 64):  # in tiles: both halves stay in the cache
        for left in range(0, top + 1, 64):
            for i in range(top, min(top + 64, n)):
                for j in range(left, min(left + 64, i)):
                    if abs(A[i, j] - A[j, i]) > absolute + 1e-5 * abs(A[i, j]):
                        return False
    return True


def _off_diagonal(C: FloatArray, a: FloatArray) -> tuple[tuple[IntArray, IntArray, FloatArray], FloatArray]:
    """C without its diagonal as csr (indptr, indices, data), and Σ_j a_j c_ij² over it."""
    n_entries = np.count_nonzero(C, axis=1) - (np.diag(C) != 0.0)
    indptr = np.concatenate([[0], np.cumsum(n_entries)]).astype(np.int64)
    data, indices, squares = np.empty(indptr[-1]), np.empty(indptr[-1], np.int32), np.zeros(len(C))
    _fill_off_diagonal(C, a, data, indices, squares)
    return (indptr, indices, data), squares


@kernel
def _fill_off_diagonal(C, a, data, indices, squares):  # type: ignore[no-untyped-def]
    """Entries of C beside its diagonal, row by row, and Σ_j a_j c_ij² over them."""
    size = 0
    for i in range(len(C)):
        for j in range(len(C)):
            c = C[i, j]
            if c != 0.0 and j != i:
                data[size], indices[size] = c, j
                squares[i] += a[j] * c * c
                size += 1


@kernel(allocates=True)
def _times(indptr, indices, data, X):  # type: ignore[no-untyped-def]
    """Sparse (csr) matrix times dense."""
    n, m = X.shape
    out = np.zeros((n, m))
    for i in range(n):
        here = out[i]
        for e in range(indptr[i], indptr[i + 1]):
            there, value = X[indices[e]], data[e]
            for r in range(m):
                here[r] += value * there[r]
    return out


@kernel(allocates=True)
def _quartic_step(slope, curvature, delta, rest, omega, limit):  # type: ignore[no-untyped-def]
    """Best t in [0, limit] for −slope·t + curvature·t²/2 + ω(rest − 2Δt − 2t²)²/4 − ω rest²/4.

    Candidates are the ends and the real roots of the cubic derivative.
    """
    best_t, best_value = 0.0, 0.0
    c3 = 4.0 * omega
    c2 = 6.0 * omega * delta
    c1 = curvature - 2.0 * omega * rest + 2.0 * omega * delta * delta
    c0 = -slope - omega * rest * delta
    roots = np.empty(4)
    roots[0] = limit
    count = 1
    if c3 < 1e-14 * (abs(c1) + abs(c2) + 1e-300):
        if c1 > 0:
            roots[count] = -c0 / c1
            count += 1
    else:
        b, c, d = c2 / c3, c1 / c3, c0 / c3
        q, r = (b * b - 3.0 * c) / 9.0, (2.0 * b * b * b - 9.0 * b * c + 27.0 * d) / 54.0
        if r * r < q * q * q:
            angle = np.arccos(min(1.0, max(-1.0, r / np.sqrt(q * q * q))))
            for i in range(3):
                roots[count] = -2.0 * np.sqrt(q) * np.cos((angle + 2.0 * np.pi * (i - 1)) / 3.0) - b / 3.0
                count += 1
        else:
            s = -np.sign(r) * (abs(r) + np.sqrt(max(r * r - q * q * q, 0.0))) ** (1.0 / 3.0)
            roots[count] = s + (q / s if s != 0.0 else 0.0) - b / 3.0
            count += 1
    for i in range(count):
        t = min(max(roots[i], 0.0), limit)
        for _ in range(2):  # polish: the closed form loses digits near double roots
            slope_here = c0 + t * (c1 + t * (c2 + t * c3))
            bend = c1 + t * (2.0 * c2 + 3.0 * t * c3)
            if bend > 0:
                t = min(max(t - slope_here / bend, 0.0), limit)
        inner = rest - 2.0 * delta * t - 2.0 * t * t
        value = -slope * t + 0.5 * curvature * t * t + 0.25 * omega * (inner * inner - rest * rest)
        if value < best_value:
            best_t, best_value = t, value
    return best_t


@kernel(allocates=True)
def _solve_column(y, force, Q, a, omega, c_own, tolerance):  # type: ignore[no-untyped-def]
    """Minimise −p·y + yᵀ(Q − a·y₀y₀ᵀ)y/2 + ω(c − |y|²)²/4 over the simplex, from y = y₀.

    ``force`` is p − (Q − a·y₀y₀ᵀ)y₀. Gives the violation that it found.
    """
    m = len(y)
    start = y.copy()
    square = 0.0
    for r in range(m):
        square += y[r] * y[r]
    first = -1.0
    for _ in range(4 * m):
        rest = c_own - square
        u, v = 0, -1
        highest, lowest = -np.inf, np.inf
        for r in range(m):
            h = force[r] + omega * rest * y[r]
            if h > highest:
                highest, u = h, r
            if y[r] > 0.0 and h < lowest:
                lowest, v = h, r
        gap = highest - lowest
        if first < 0:
            first = gap
        if gap <= tolerance:
            break
        apart = start[u] - start[v]
        curvature = Q[u, u] - 2.0 * Q[u, v] + Q[v, v] - a * apart * apart
        slope = force[u] - force[v]
        delta = y[u] - y[v]
        if omega > 0.0:
            t = _quartic_step(slope, curvature, delta, rest, omega, y[v])
        else:
            t = y[v] if curvature * y[v] <= slope else slope / curvature
        if t <= 0.0:
            break
        emptied = t >= y[v]
        square += 2.0 * t * delta + 2.0 * t * t
        y[u] += t
        y[v] = 0.0 if emptied else y[v] - t
        to, back = Q[u], Q[v]
        for r in range(m):
            force[r] -= t * (to[r] - back[r] - a * apart * start[r])
    return first


@kernel(allocates=True)
def _sweep_rank_one(  # type: ignore[no-untyped-def]
    columns, indptr, indices, data, own, a, Y, P, S, diagonal, tolerance
):
    """Columns in turn with w_ij = a_i a_j; P = off·diag(a)·Y and S = Yᵀ·diag(a)·Y are kept up to date."""
    m = Y.shape[1]
    worst = 0.0
    force, changed = np.empty(m), np.empty(m, np.int64)
    for j in columns:
        if a[j] <= 0.0:
            continue
        y = Y[j]
        before = y.copy()
        square = 0.0
        for r in range(m):
            square += y[r] * y[r]
        for r in range(m):
            force[r] = P[j, r] + a[j] * square * y[r]
        for v in range(m):
            if before[v] > 0.0:
                row = S[v]
                for r in range(m):
                    force[r] -= row[r] * before[v]
        found = _solve_column(y, force, S, a[j], a[j] if diagonal else 0.0, own[j], tolerance)
        worst = max(worst, found)
        if found <= tolerance:
            continue
        n_changed = 0
        for r in range(m):
            if y[r] != before[r]:
                changed[n_changed] = r
                n_changed += 1
        for e in range(indptr[j], indptr[j + 1]):
            here, pull = P[indices[e]], a[j] * data[e]
            for k in range(n_changed):
                c = changed[k]
                here[c] += pull * (y[c] - before[c])
        for r in range(m):
            if y[r] != 0.0 or before[r] != 0.0:
                for s in range(m):
                    S[r, s] += a[j] * (y[r] * y[s] - before[r] * before[s])
    return worst


@kernel(allocates=True)
def _sweep_general(columns, C, own, W, Y, diagonal, tolerance):  # type: ignore[no-untyped-def]
    """Columns in turn with any weights: O(n · m²) each, less where the other columns are sparse."""
    n, m = Y.shape
    worst = 0.0
    Q = np.empty((m, m))
    p = np.empty(m)
    support = np.empty(m, dtype=np.int64)
    for j in columns:
        Q[:], p[:] = 0.0, 0.0
        total = W[j, j]
        for i in range(n):
            w = W[j, i]
            if i == j or w == 0.0:
                continue
            total += w
            count = 0
            for r in range(m):
                if Y[i, r] > 0.0:
                    support[count] = r
                    count += 1
            for x in range(count):
                r = support[x]
                p[r] += w * C[j, i] * Y[i, r]
                for z in range(count):
                    Q[r, support[z]] += w * Y[i, r] * Y[i, support[z]]
        if total <= 0.0:
            continue
        p /= total
        Q /= total
        for x in range(m):
            if Y[j, x] > 0.0:
                for r in range(m):
                    p[r] -= Q[r, x] * Y[j, x]
        found = _solve_column(Y[j], p, Q, 0.0, W[j, j] / total if diagonal else 0.0, own[j], tolerance)
        worst = max(worst, found)
    return worst
