"""Probabilistic evidence accumulation: soft assignments that explain a co-association matrix.

Goes in: how often two base segments fall together, and how much each pair counts. Comes out: Y, a column
of probabilities for each base segment. Rota Bulò et al. (2010), S+SSPR; Lourenço et al. (2015), Machine
Learning 98; thesis 3.5, Eq. 3.14.

Solved by block-coordinate descent, a column at a time, moving probability between two rows at a time by
exact line search. Each step lowers the objective, so it ends in a stationary point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numba
import numpy as np

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
        Passes over all columns.
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
    n_restarts: int = 1,
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
    n_restarts : int
        Starts, the best objective wins; beyond the first, "dirichlet".
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
    """
    C, weights = _checked(C, weights, n_clusters)
    if n_restarts < 1:
        raise ValueError(f"n_restarts must be at least 1, got {n_restarts}")
    if not tolerance > 0:
        raise ValueError(f"tolerance must be above 0, got {tolerance}")
    monitor = monitor or SILENT
    sequence = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
    best: PeacResult | None = None
    # a fresh copy, because spawning changes the sequence that it is asked of
    children = np.random.SeedSequence(sequence.entropy, spawn_key=sequence.spawn_key).spawn(n_restarts)
    for run, child in enumerate(children):
        rng = np.random.default_rng(child)
        Y = _start(C, weights, n_clusters, init if run == 0 else "dirichlet", rng)
        with one_blas_thread():  # small products between the sweeps; their rounding must not depend on cores
            result = _solve(C, weights, Y, diagonal, tolerance, max_sweeps, rng, monitor)
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
    if not np.allclose(C, C.T, atol=1e-9):
        raise ValueError("C must be symmetric")
    if weights.shape not in ((len(C),), C.shape):
        raise ValueError(f"weights must have shape ({len(C)},) or {C.shape}, got {weights.shape}")
    if not (weights.min() >= 0 and np.isfinite(weights).all() and weights.sum() > 0):
        raise ValueError("weights must be finite, not negative, and not all zero")
    if weights.ndim == 2 and not np.allclose(weights, weights.T):
        raise ValueError("weights must be symmetric where they are given for pairs")
    if isinstance(n_clusters, bool) or not isinstance(n_clusters, (int, np.integer)):
        raise TypeError(f"n_clusters must be a whole number, got {n_clusters!r}")
    if n_clusters < 1:
        raise ValueError(f"n_clusters must be at least 1, got {n_clusters}")
    return C, weights / weights.sum()


def _start(C: FloatArray, weights: FloatArray, m: int, init: str, rng: np.random.Generator) -> FloatArray:
    n = len(C)
    if init == "dirichlet":
        return np.ascontiguousarray(rng.dirichlet(np.ones(m), size=n))
    if init != "linkage":
        raise ValueError(f"init must be 'linkage' or 'dirichlet', got {init!r}")
    areas = weights if weights.ndim == 1 else np.sqrt(np.maximum(np.diag(weights), 1e-300))
    labels = cut_tree(average_linkage(C, areas), n_clusters=min(m, n))
    Y = np.full((n, m), 0.1 / m)
    Y[np.arange(n), labels] += 0.9
    return Y


def _solve(
    C: FloatArray,
    weights: FloatArray,
    Y: FloatArray,
    diagonal: bool,
    tolerance: float,
    max_sweeps: int,
    rng: np.random.Generator,
    monitor: Monitor,
) -> PeacResult:
    """Sweeps over all columns in random order; Y holds a column of the paper's Y in each row."""
    is_rank_one = weights.ndim == 1
    off = C.copy()
    np.fill_diagonal(off, 0.0)
    P = off @ (weights[:, None] * Y) if is_rank_one else np.empty((0, 0))
    violation: float = np.inf
    sweep = 0
    first = 0.0
    while violation > tolerance and sweep < max_sweeps:
        order = rng.permutation(len(C))
        violation = 0.0
        found: float
        for chunk in np.array_split(order, max(1, len(C) // 256)):  # cancel answers between chunks
            if is_rank_one:
                S = (Y * weights[:, None]).T @ Y
                found = _sweep_rank_one(
                    chunk, off, np.diag(C).copy(), weights, Y, P, S, diagonal, 0.1 * tolerance
                )
            else:
                found = _sweep_general(chunk, off, np.diag(C).copy(), weights, Y, diagonal, 0.1 * tolerance)
            violation = max(violation, found)
            monitor.tick()
        sweep += 1
        first = first or violation
        if violation > 0:
            monitor.tick(np.log(first / violation) / max(np.log(first / tolerance), 1e-9))
        if is_rank_one and sweep % 50 == 0:
            P = off @ (weights[:, None] * Y)  # sheds rounding errors
    residual = C - Y @ Y.T
    if not diagonal:
        np.fill_diagonal(residual, 0.0)
    residual *= residual
    objective = float(weights @ residual @ weights) if is_rank_one else float((weights * residual).sum())
    Y = np.ascontiguousarray(Y.T)
    labels = Y.argmax(axis=0).astype(np.int32)
    return PeacResult(Y, labels, objective, float(violation), bool(violation <= tolerance), sweep)


@numba.njit(cache=True, nogil=True)
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


@numba.njit(cache=True, nogil=True)
def _solve_column(y, p, Q, omega, c_own, tolerance):  # type: ignore[no-untyped-def]
    """Minimise −p·y + yᵀQy/2 + ω(c − |y|²)²/4 over the simplex; gives the violation that it found."""
    m = len(y)
    force = p.copy()
    square = 0.0
    for v in range(m):
        if y[v] > 0.0:
            square += y[v] * y[v]
            for r in range(m):
                force[r] -= Q[r, v] * y[v]
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
        curvature = Q[u, u] - 2.0 * Q[u, v] + Q[v, v]
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
        for r in range(m):
            force[r] -= t * (Q[r, u] - Q[r, v])
    return first


@numba.njit(cache=True, nogil=True)
def _sweep_rank_one(columns, off, own, a, Y, P, S, diagonal, tolerance):  # type: ignore[no-untyped-def]
    """Columns in turn with w_ij = a_i a_j; P = off·diag(a)·Y and S = Yᵀ·diag(a)·Y are kept up to date."""
    n, m = Y.shape
    worst = 0.0
    Q = S.copy()
    for j in columns:
        if a[j] <= 0.0:
            continue
        before = Y[j].copy()
        for r in range(m):
            if before[r] > 0.0:
                for s in range(m):
                    Q[r, s] = S[r, s] - a[j] * before[r] * before[s]
            else:
                Q[r, :] = S[r, :]
        found = _solve_column(Y[j], P[j], Q, a[j] if diagonal else 0.0, own[j], tolerance)
        worst = max(worst, found)
        if found <= tolerance:
            continue
        changed = np.flatnonzero(Y[j] != before)
        for i in range(n):
            pull = a[j] * off[j, i]
            if pull != 0.0:
                for c in changed:
                    P[i, c] += pull * (Y[j, c] - before[c])
        for r in range(m):
            for s in range(m):
                S[r, s] = Q[r, s] + a[j] * Y[j, r] * Y[j, s]
    return worst


@numba.njit(cache=True, nogil=True)
def _sweep_general(columns, off, own, W, Y, diagonal, tolerance):  # type: ignore[no-untyped-def]
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
                p[r] += w * off[j, i] * Y[i, r]
                for z in range(count):
                    Q[r, support[z]] += w * Y[i, r] * Y[i, support[z]]
        if total <= 0.0:
            continue
        found = _solve_column(
            Y[j], p / total, Q / total, W[j, j] / total if diagonal else 0.0, own[j], tolerance
        )
        worst = max(worst, found)
    return worst
