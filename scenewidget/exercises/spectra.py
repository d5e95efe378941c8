"""Exercises of notebook 04: the spectrum."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from scenewidget.datasets import analytic
from scenewidget.engine.mesh import FloatArray, Mesh
from scenewidget.engine.operators import cotangent_laplacian, eigenbasis
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise

__all__ = ["EXERCISES"]

AREA, BELOW = 2.0, 500.0
N_LISTED = 24


def factor_of_a_larger_drum() -> float:
    """λ has the unit 1/m²."""
    large, small = (eigenbasis(analytic.square(8, size=size), 3).values[1] for size in (2.0, 1.0))
    return float(large / small)


def _sums_of_squares(count: int) -> Any:
    m, n = np.meshgrid(np.arange(12), np.arange(12))
    return np.sort((m**2 + n**2).ravel())[:count]


def single_eigenvalues() -> int:
    """Those that differ from both neighbours in a list that is one longer."""
    gaps = np.diff(_sums_of_squares(N_LISTED + 1)) > 0
    return int(gaps[0] + (gaps[1:] & gaps[:-1]).sum())


def zeros_of_pieces() -> int:
    """One zero for each piece."""
    parts = [analytic.sphere(1), analytic.torus(n_ring=8, n_tube=6), analytic.square(3), analytic.square(2)]
    starts = np.cumsum([0, *(part.n_vertices for part in parts)])
    vertices = np.concatenate([part.vertices + np.array([5.0 * i, 0, 0]) for i, part in enumerate(parts)])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)])
    return int((eigenbasis(Mesh(vertices, faces), 10).values == 0).sum())


def expected_by_weyl() -> float:
    """N(λ) ≈ area · λ / 4π."""
    return AREA * BELOW / (4 * np.pi)


def tone() -> float:
    """Frequencies go as √λ, and λ as m² + n²."""
    m, n = 2, 1
    return float(np.sqrt(m**2 + n**2))


def low_pass(vectors: FloatArray, mass: FloatArray, values: FloatArray, k: int) -> FloatArray:
    """Coefficients Φᵀ A u of the first k, then their sum."""
    phi = vectors[:, :k]
    return np.asarray(phi @ (phi.T @ (mass * values)))


def heat_step(W: Any, A: Any, u: FloatArray, t: float) -> FloatArray:
    """(A + t W) u_new = A u."""
    return np.asarray(spsolve(sparse.csc_array(A + t * W), A @ u))


def _no_mass(vectors: FloatArray, mass: FloatArray, values: FloatArray, k: int) -> Any:
    return vectors[:, :k] @ (vectors[:, :k].T @ values)


def _one_more(vectors: FloatArray, mass: FloatArray, values: FloatArray, k: int) -> Any:
    return low_pass(vectors, mass, values, k + 1)


def _without_constant(vectors: FloatArray, mass: FloatArray, values: FloatArray, k: int) -> Any:
    return low_pass(vectors[:, 1:], mass, values, k)


def _signals() -> dict[str, tuple[Any, ...]]:
    out = {}
    for name, mesh, k in (
        ("a square", analytic.square(5, triangulation="irregular"), 6),
        ("a sphere", analytic.sphere(2), 9),
        ("a torus", analytic.torus(n_ring=12, n_tube=7), 1),
    ):
        basis = eigenbasis(mesh, 16)
        signal = mesh.vertices @ [1.0, 2.0, -1.0] + np.cos(5 * mesh.vertices[:, 0])
        out[name] = (np.array(basis.vectors), np.array(basis.mass), signal, k)
    return out


def _heats() -> dict[str, tuple[Any, ...]]:
    out: dict[str, tuple[Any, ...]] = {}
    for name, mesh, t in (
        ("a square", analytic.square(5, triangulation="irregular"), 0.02),
        ("a sphere", analytic.sphere(1), 0.3),
        ("a torus, after a long time", analytic.torus(n_ring=10, n_tube=6), 50.0),
    ):
        u = np.zeros(mesh.n_vertices)
        u[3] = 1.0
        out[name] = (*cotangent_laplacian(mesh), u, t)
    return out


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="04.1",
        level=1,
        question="A larger drum sounds lower. By which factor do the eigenvalues change when the square is twice as long and "
        "twice as wide?",
        right=factor_of_a_larger_drum,
        why="λ has the unit 1/m²; the frequency, its root, falls by an octave.",
        hint="λ has the unit 1/m².",
        mistakes={
            "lower, not higher: one over it": lambda r: 1 / r,
            "by that the *frequency* changes, which is √λ": lambda r: np.sqrt(r),
            "the matrix W knows no length, and A is an area: which unit has A⁻¹W?": lambda r: 1.0,
        },
    ),
    NumberExercise(
        name="04.2",
        level=2,
        is_whole=True,
        question="How many of the first 24 eigenvalues of the square with a free border, π²(m² + n²), are single, that is, "
        "different from both neighbours in the list?",
        right=single_eigenvalues,
        why="only m = n can be single, for m and n change places; and of those not all, for 5² + 5² = 1² + 7².",
        hint="take 25 values, so that the last of the 24 has both neighbours.",
        mistakes={
            "zero is an eigenvalue, too": lambda r: r - 1,
            "those are the multiple ones": lambda r: N_LISTED - r,
            "those are the *different* ones; single means once in the list": lambda r: len(
                np.unique(_sums_of_squares(N_LISTED))
            ),
        },
    ),
    NumberExercise(
        name="04.3",
        level=1,
        is_whole=True,
        question="A mesh consists of a sphere, a torus and two squares, none of which touch. How many of its eigenvalues are 0?",
        right=zeros_of_pieces,
        why="on each piece a function may have a constant of its own.",
        hint="on how many pieces can a function be constant, each with its own constant?",
        mistakes={"there are two squares": lambda r: r - 1, "one for the whole is not enough": lambda r: 1},
    ),
    NumberExercise(
        name="04.4",
        level=2,
        question="How many eigenvalues below 500/m² does Weyl's law expect on a surface of 2 m²? (One decimal will do.)",
        right=expected_by_weyl,
        why="N(λ) ≈ area · λ / 4π, whatever the shape.",
        hint="N(λ) ≈ area · λ / 4π.",
        mistakes={
            "4π, not π": lambda r: 4 * r,
            "4π, not 2π": lambda r: 2 * r,
            "λ and not the frequency √λ": lambda r: AREA * np.sqrt(BELOW) / (4 * np.pi),
            "multiply by the area: a larger surface has more tones below": lambda r: r / AREA**2,
            "the area is missing": lambda r: r / AREA,
            "4π² is for a frequency in hertz": lambda r: r / np.pi,
        },
    ),
    NumberExercise(
        name="04.5",
        level=2,
        question="A free square membrane swings in the mode cos(2πx)·cos(πy). How many times as high is its *tone* as that "
        "of the lowest mode, cos(πx)?",
        right=tone,
        why="λ is 5 times as large, and the tone goes as √λ.",
        hint="compare m² + n² of the two, then think of what a tone is.",
        mistakes={
            "that is the ratio of the eigenvalues; a tone goes as their root": lambda r: r**2,
            "m² + n², not m + n": lambda r: np.sqrt(3),
            "the lowest mode has m² + n² = 1, not 2": lambda r: r / np.sqrt(2),
        },
    ),
    FunctionExercise(
        name="04.6",
        level=3,
        signature="low_pass(vectors, mass, values, k)",
        question="Write `low_pass(vectors, mass, values, k)`: the function `values` (n,) rebuilt from its first k "
        "eigenfunctions. `vectors` is (n, K), and `mass` the diagonal of A.",
        right=low_pass,
        cases=_signals,
        why="coefficients are Φᵀ A u, for the φ are orthonormal in the sense of area.",
        hint="first the k coefficients, then the sum of coefficient times eigenfunction.",
        mistakes={
            "the scalar product is weighted by area: Φᵀ A u": _no_mass,
            "one function too many: the first k are columns 0 to k − 1": _one_more,
            "the constant φ₀ is the first of the k; without it the mean is lost": _without_constant,
            "those are the k coefficients' share only that is *left out*": lambda v, m, u, k: (
                u - low_pass(v, m, u, k)
            ),
        },
    ),
    FunctionExercise(
        name="04.7",
        level=3,
        signature="heat_step(W, A, u, t)",
        question="Write `heat_step(W, A, u, t)`: one *implicit* step of the heat equation, the u' with A (u' − u)/t = −W u'. W "
        "and A are sparse.",
        right=heat_step,
        cases=_heats,
        why="one sparse solve with A + tW, stable for every t; the explicit step blows up beyond t = 2/λ_max.",
        hint="bring all that has u' to the left: (A + tW) u' = A u.",
        mistakes={
            "that is the explicit step, W applied to the old u; it blows up when t is large": lambda W, A, u, t: (
                u - t * (W @ u) / A.diagonal()
            ),
            "the areas are missing on the left: A + tW, not 1 + tW": lambda W, A, u, t: np.linalg.solve(
                np.eye(len(u)) + t * W.toarray(), A @ u
            ),
            "the areas are missing: heat is a density, A (u' − u) = −t W u'": lambda W, A, u, t: (
                np.linalg.solve(np.eye(len(u)) + t * W.toarray(), u)
            ),
            "the right-hand side is A u, not u": lambda W, A, u, t: np.linalg.solve((A + t * W).toarray(), u),
            "the sign: heat flows downhill, A + tW": lambda W, A, u, t: np.linalg.solve(
                (A - t * W).toarray(), A @ u
            ),
        },
    ),
)
