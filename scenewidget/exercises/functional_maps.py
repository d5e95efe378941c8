"""Exercises of notebook 16: functional maps."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.datasets import analytic
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.operators import eigenbasis
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise, WordExercise

__all__ = ["EXERCISES"]

N_ONE, N_OTHER, N_SIMPLE, N_KEPT = 30, 40, 5, 25


def n_entries() -> int:
    """A row for each eigenfunction of the other, a column for each of the one."""
    return N_ONE * N_OTHER


def n_sign_patterns() -> int:
    """Each diagonal entry is +1 or −1."""
    return int(2**N_SIMPLE)


def frobenius() -> float:
    """CᵀC = I: each of the columns has norm 1."""
    return float(np.linalg.norm(np.eye(N_KEPT)) ** 2)


def functional_map(F: FloatArray, G: FloatArray) -> FloatArray:
    """The C with least ‖C F − G‖: C = G Fᵀ (F Fᵀ)⁻¹."""
    C: FloatArray = np.linalg.solve(F @ F.T, F @ G.T).T
    return C


def point_map(C: FloatArray, phi: FloatArray, psi: FloatArray) -> IntArray:
    """For each row of psi the row of phi whose image under C is nearest."""
    there = phi @ C.T
    return np.array([((there - y) ** 2).sum(axis=1).argmin() for y in psi])


def map_of_points(T: IntArray, phi: FloatArray, psi: FloatArray, mass: FloatArray) -> FloatArray:
    """C = Ψᵀ A Φ[T]."""
    return psi.T @ (mass[:, None] * phi[T])


def _signals() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(0)
    cases: dict[str, tuple[Any, ...]] = {}
    for name, rows, columns, n in (("4 by 4", 4, 4, 9), ("5 functions to 3", 3, 5, 12)):
        C, F = rng.normal(size=(rows, columns)), rng.normal(size=(columns, n))
        cases[name] = (F, C @ F + 0.1 * rng.normal(size=(rows, n)))
    return cases


def _sheets() -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """(Φ, Ψ, masses, T) of a sheet and the same sheet with its vertices in another order."""
    mesh = analytic.square(5, triangulation="irregular")
    basis = eigenbasis(mesh, 6)
    order = np.random.default_rng(2).permutation(mesh.n_vertices)
    return basis.vectors, basis.vectors[order] * [1, -1, 1, 1, -1, -1], basis.mass[order], order


def _matched() -> dict[str, tuple[Any, ...]]:
    phi, psi, mass, T = _sheets()
    exact = map_of_points(T, phi, psi, mass)
    few = np.random.default_rng(3)
    return {
        "a sheet and its shuffled copy": (exact, phi, psi),
        "a map of 3 functions to 2": (
            few.normal(size=(2, 3)),
            few.normal(size=(7, 3)),
            few.normal(size=(5, 2)),
        ),
    }


def _pulled() -> dict[str, tuple[Any, ...]]:
    phi, psi, mass, T = _sheets()
    return {
        "a sheet and its shuffled copy": (T, phi, psi, mass),
        "fewer functions on one side": (T, phi[:, :4], psi, mass),
        "a map to one point": (np.zeros(len(T), int), phi, psi, mass),
    }


def _transposed(F: FloatArray, G: FloatArray) -> Any:
    return functional_map(F, G).T.reshape(len(G), len(F))


def _backwards(F: FloatArray, G: FloatArray) -> Any:
    """From other to one."""
    return functional_map(G, F) if len(F) == len(G) else functional_map(F, G) * 0


def _unmapped(C: FloatArray, phi: FloatArray, psi: FloatArray) -> Any:
    m = min(phi.shape[1], psi.shape[1])
    return point_map(np.eye(m), phi[:, :m], psi[:, :m])


def _other_way(C: FloatArray, phi: FloatArray, psi: FloatArray) -> Any:
    there = phi @ C.T
    nearest = np.array([((psi - x) ** 2).sum(axis=1).argmin() for x in there])
    return nearest if len(nearest) == len(psi) else np.zeros(len(psi))


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="16.1",
        level=1,
        question="With 30 eigenfunctions on *one* and 40 on *other*: how many entries has C?",
        right=n_entries,
        is_whole=True,
        why="a row for each function of the other, a column for each of the one.",
        hint="it is a matrix: rows times columns.",
        mistakes={
            "C takes 30 coefficients to 40; it is a matrix": lambda r: N_ONE + N_OTHER,
            "it needn't be square": lambda r: N_ONE**2,
        },
    ),
    NumberExercise(
        name="16.2",
        level=2,
        question="An isometry takes one shape to another, and the first five eigenvalues are simple. How many different C, five by five, are possible?",
        right=n_sign_patterns,
        is_whole=True,
        why="C is diagonal with ±1, and solvers choose signs freely: 2⁵.",
        hint="what may stand on the diagonal?",
        mistakes={
            "the signs are not fixed: −φ is as good as φ": lambda r: 1.0,
            "the signs of the five are independent of each other": lambda r: 2.0 * N_SIMPLE,
            "order is fixed by the eigenvalues; only signs are free": lambda r: 120.0,
        },
    ),
    NumberExercise(
        name="16.3",
        level=2,
        question="What is the sum of the squares of all entries of a C, 25 by 25, with CᵀC = I?",
        right=frobenius,
        why="the trace of CᵀC, one for each column.",
        hint="Σ c² is the trace of CᵀC.",
        mistakes={
            "that is its root, the Frobenius norm": lambda r: np.sqrt(r),
            "the *columns* have norm 1, not the entries": lambda r: r**2,
        },
    ),
    WordExercise(
        name="16.4",
        level=1,
        question='T takes points of *other* to points of *one*. In which direction do functions go with it, "one to other" or "other to one"?',
        choices=lambda: ["one to other", "other to one"],
        right=lambda: "one to other",
        why="f on one gives f∘T on other: functions go against the points.",
        hint="f is known at T(y). At which point does the new function have this value?",
        mistakes={"that is the way of the points; f∘T can be evaluated on *other*": lambda r: "other to one"},
    ),
    FunctionExercise(
        name="16.5",
        level=3,
        signature="functional_map(F, G)",
        question="Write `functional_map(F, G)`: the C with least ‖C F − G‖. F is (k, n), G is (m, n), columns correspond; no term with eigenvalues.",
        right=functional_map,
        cases=_signals,
        why="a least-squares problem for each row of C: C = G Fᵀ (F Fᵀ)⁻¹.",
        hint="transpose it: Fᵀ Cᵀ ≈ Gᵀ is what np.linalg.lstsq solves.",
        mistakes={
            "transposed: lstsq(F.T, G.T) gives Cᵀ": _transposed,
            "that is G Fᵀ; the inverse of F Fᵀ is missing": lambda F, G: G @ F.T,
            "that is the map from other to one": _backwards,
        },
    ),
    FunctionExercise(
        name="16.6",
        level=3,
        signature="point_map(C, phi, psi)",
        question="Write `point_map(C, phi, psi)`: for each point of *other* (row of psi) the number of the point of *one* (row of phi) with C φ(x) nearest to ψ(y).",
        right=point_map,
        cases=_matched,
        why="rows of phi @ C.T are where C takes the points; then the nearest.",
        hint="C takes the row φ(x) to C φ(x), so all rows together are phi @ C.T.",
        mistakes={
            "C is not used: signs differ between the two shapes": _unmapped,
            "that is for each point of *one* its point of *other*": _other_way,
            "the farthest, not the nearest": lambda C, phi, psi: np.array(
                [(((phi @ C.T) - y) ** 2).sum(axis=1).argmax() for y in psi]
            ),
        },
    ),
    FunctionExercise(
        name="16.7",
        level=3,
        signature="map_of_points(T, phi, psi, mass)",
        question="Write `map_of_points(T, phi, psi, mass)`: the C of a point map T, an array with a point of *one* for each of *other*; `mass` are the areas of *other*.",
        right=map_of_points,
        cases=_pulled,
        why="column j: pull φ_j back, φ_j[T], and take its coefficients in Ψ, weighted by area.",
        hint="phi[T] are the functions of *one*, seen on *other*; their coefficients there are Ψᵀ A times that.",
        mistakes={
            "the areas are missing: coefficients are Ψᵀ A u (notebook 04)": lambda T, phi, psi, mass: (
                psi.T @ phi[T]
            ),
        },
    ),
)
