"""The method's inner parts as one would write them first, in plain numpy, to compare with."""

from __future__ import annotations

import numpy as np


def alternate_k_medoids(D: np.ndarray, medoids: np.ndarray, max_iter: int = 100) -> tuple[np.ndarray, float]:
    """Park and Jun: assign, move each medoid to the member with the least sum, until the cost stays."""
    medoids = medoids.copy()
    labels, cost = np.empty(0, dtype=int), np.inf
    for _ in range(max_iter):
        trial = D[:, medoids].argmin(axis=1)
        trial[medoids] = np.arange(len(medoids))
        reach = D[np.arange(len(D)), medoids[trial]]
        trial[np.isinf(reach)] = -1
        new = float(reach[np.isfinite(reach)].sum(dtype=np.float64))
        if not new < cost:
            break
        labels, cost = trial, new
        for c in range(len(medoids)):
            members = np.flatnonzero(labels == c)
            medoids[c] = members[D[np.ix_(members, members)].sum(axis=1, dtype=np.float64).argmin()]
    return labels, cost


def greedy_peac(
    C: np.ndarray, weights: np.ndarray, Y: np.ndarray, *, tolerance: float = 1e-4, max_steps: int = 200_000
) -> tuple[np.ndarray, float, int]:
    """PEAC by the steepest pair of all columns, one at a time, with exact line search; no diagonal.

    Y is (n_clusters, n_base). Gives Y, the violation that is left and the number of steps.
    """
    a = weights / weights.sum()
    Y = Y.copy()
    off = C - np.diag(np.diag(C))
    P = (Y * a) @ off
    S = (Y * a) @ Y.T
    gap = np.inf
    for step in range(max_steps):
        force = P - S @ Y + a * (Y * Y).sum(axis=0) * Y
        low = np.where(Y > 0, force, np.inf)
        gaps = force.max(axis=0) - low.min(axis=0)
        j = int(gaps.argmax())
        gap = float(gaps[j])
        if gap <= tolerance:
            return Y, gap, step
        u, v = int(force[:, j].argmax()), int(low[:, j].argmin())
        y = Y[:, j].copy()
        Q = S - a[j] * np.outer(y, y)
        curvature = Q[u, u] - 2 * Q[u, v] + Q[v, v]
        t = y[v] if curvature * y[v] <= gap else gap / curvature
        Y[u, j] += t
        Y[v, j] = 0.0 if t >= y[v] else y[v] - t
        P += np.outer(Y[:, j] - y, a[j] * off[j])
        S = Q + a[j] * np.outer(Y[:, j], Y[:, j])
    return Y, gap, max_steps
