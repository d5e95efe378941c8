"""Exercises of notebook 12: drums."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import eigh

from scenewidget.datasets import analytic
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.operators import cotangent_laplacian
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise, WordExercise

__all__ = ["EXERCISES"]

LEVEL, N_TRUSTED = 1000.0, 50


def lowest_clamped() -> float:
    """m² + n² at its smallest, m = n = 1."""
    return 1.0**2 + 1.0**2


def expected() -> float:
    """Weyl's law with its second term, for a clamped unit square."""
    return float(LEVEL / (4 * np.pi) - 4 * np.sqrt(LEVEL) / (4 * np.pi))


def trusted() -> int:
    """The error is in proportion to k h²."""
    return N_TRUSTED * 3**2


def area_of_drum() -> float:
    """N(λ) ≈ area λ/4π."""
    return 4 * np.pi * 350 / 2000


def clamped(W: FloatArray, A: FloatArray, border: IntArray, k: int) -> FloatArray:
    """Rows and columns of the border struck out."""
    inner = np.setdiff1d(np.arange(len(A)), border)
    values: FloatArray = eigh(W[np.ix_(inner, inner)], np.diag(A[inner]), eigvals_only=True)[:k]
    return values


def heat_trace(values: FloatArray, times: FloatArray) -> FloatArray:
    """Z(t) = Σ exp(−λ t)."""
    return np.array([np.exp(-values * t).sum() for t in times])


def _skins() -> dict[str, tuple[Any, ...]]:
    cases = {}
    for name, mesh, k in (
        ("a square", analytic.square(6), 5),
        ("an irregular square", analytic.square(5, size=2.0, triangulation="irregular"), 4),
        ("a paper cross", analytic.paper_figure(10), 6),
    ):
        W, A = cotangent_laplacian(mesh)
        edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, count = np.unique(edges, axis=0, return_counts=True)
        cases[name] = (W.toarray(), A.diagonal(), np.unique(edges[count == 1]), k)
    return cases


def _pinned(W: FloatArray, A: FloatArray, border: IntArray, k: int) -> FloatArray:
    """Border rows set to those of the unit matrix: each brings an eigenvalue of its own."""
    W = W.copy()
    W[border], W[:, border] = 0, 0
    W[border, border] = 1
    values: FloatArray = eigh(W, np.diag(A), eigvals_only=True)[:k]
    return values


def _free(W: FloatArray, A: FloatArray, border: IntArray, k: int) -> FloatArray:
    values: FloatArray = eigh(W, np.diag(A), eigvals_only=True)[:k]
    return values


def _massless(W: FloatArray, A: FloatArray, border: IntArray, k: int) -> FloatArray:
    return clamped(W, np.ones_like(A), border, k)


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="12.1",
        level=1,
        question="How many times π² is the lowest eigenvalue of a clamped unit square?",
        right=lowest_clamped,
        is_exact=True,
        why="sin(πx) sin(πy): m = n = 1, and 1² + 1² = 2.",
        hint="clamped modes are sines; m and n begin at 1.",
        mistakes={
            "that is the free square's: with a clamped border no constant is left": lambda r: 0.0,
            "sin(πx) alone is not 0 where y is 0 or 1: both m and n begin at 1": lambda r: 1.0,
            "that is the second one, m = 1 and n = 2": lambda r: 5.0,
            "how many times π²: leave π² out": lambda r: r * np.pi**2,
        },
    ),
    WordExercise(
        name="12.2",
        level=2,
        question="A free drum is cut into two along a line, and both halves stay free. Do the eigenvalues, sorted into one list, "
        'rise or fall (or stay), each compared with that of the same number before? Answer "rise", "fall" or "both".',
        choices=lambda: ["rise", "fall", "both"],
        right=lambda: "fall",
        why="functions may jump over the cut now, so there are more of them to make the quotient small with; the second zero shows it.",
        hint="are there more functions to choose from afterwards, or fewer?",
        mistakes={
            "that is what clamping along the line would do: fewer functions. Here functions may jump": lambda r: (
                "rise"
            )
        },
    ),
    NumberExercise(
        name="12.3",
        level=2,
        question="How many eigenvalues below 1000 does Weyl's law with its second term expect of a clamped unit square? "
        "(One decimal will do.)",
        right=expected,
        why="1000/4π − 4·√1000/4π = 79.6 − 10.1.",
        hint="area·λ/4π, and the term of the border with its sign.",
        mistakes={
            "that is the first term alone": lambda r: LEVEL / (4 * np.pi),
            "the sign of the second term is that of a free border": lambda r: (
                (LEVEL + 4 * np.sqrt(LEVEL)) / (4 * np.pi)
            ),
            "the border of the unit square is 4 long": lambda r: (LEVEL - np.sqrt(LEVEL)) / (4 * np.pi),
        },
    ),
    NumberExercise(
        name="12.4",
        level=2,
        question="On some mesh eigenvalues are good to one percent up to the 50th. Up to which, about, on a mesh of the same shape "
        "with edges a third as long?",
        right=trusted,
        why="the error goes as λh² and λ_k as k: with a third of h, nine times as many.",
        hint="the error is in proportion to k·h².",
        mistakes={
            "the error falls with the *square* of the edge": lambda r: N_TRUSTED * 3,
            "shorter edges make it better, not worse": lambda r: N_TRUSTED / 9,
            "k counts modes of a surface: λ_k grows like k, not like k²": lambda r: N_TRUSTED * 81,
        },
    ),
    NumberExercise(
        name="12.5",
        level=2,
        question="A drum has 350 eigenvalues below 2000/m². How large is it, in square metres, by the first term of Weyl's law?",
        right=area_of_drum,
        why="area = 4π N/λ.",
        hint="solve N = area·λ/4π for the area.",
        mistakes={
            "that is N/λ, without the 4π": lambda r: r / (4 * np.pi),
            "2π instead of 4π": lambda r: r / 2,
            "4π went to the wrong side": lambda r: r / (4 * np.pi) ** 2,
        },
    ),
    FunctionExercise(
        name="12.6",
        level=3,
        signature="clamped(W, A, border, k)",
        question="Write `clamped(W, A, border, k)`: the k lowest eigenvalues of a mesh clamped at the vertices `border`, ascending. W is "
        "(n, n) and dense, A the (n,) areas.",
        right=clamped,
        cases=_skins,
        why="rows and columns of the border are struck out, and W_II φ = λ A_II φ solved.",
        hint="which vertices are unknowns? Solve with their rows and columns only (scipy.linalg.eigh takes W and a diagonal matrix).",
        mistakes={
            "those of the free mesh: the border was not used": _free,
            "the border's rows became those of a unit matrix: each of them brings an eigenvalue 1/A of its own. Strike them out": _pinned,
            "the areas are missing: W φ = λ A φ": _massless,
            "descending": lambda W, A, border, k: clamped(W, A, border, k)[::-1],
        },
    ),
    FunctionExercise(
        name="12.7",
        level=3,
        signature="heat_trace(values, times)",
        question="Write `heat_trace(values, times)`: Z(t) = Σ exp(−λt) over the eigenvalues `values`, one for each of the `times`.",
        right=heat_trace,
        cases=lambda: {
            "three eigenvalues": (np.array([0.0, 1.0, 3.0]), np.array([0.1, 1.0])),
            "a clamped square": (
                np.pi**2 * np.array([2.0, 5, 5, 8, 10, 10]),
                np.array([0.01, 0.02, 0.05]),
            ),
        },
        why="one sum for each time; np.exp(−np.outer(times, values)).sum(axis=1).",
        hint="sum over the eigenvalues, one number for each time.",
        mistakes={
            "the sign: heat decays": lambda v, t: heat_trace(-v, t),
            "that is the mean; the trace is the sum": lambda v, t: heat_trace(v, t) / len(v),
            "summed over times and eigenvalues both": lambda v, t: np.full(len(t), heat_trace(v, t).sum()),
        },
    ),
)
