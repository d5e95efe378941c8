"""Exercises of notebook 05: signatures."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from scenewidget.datasets import analytic
from scenewidget.engine.features import global_point_signature, heat_kernel_signature
from scenewidget.engine.mesh import FloatArray, Mesh
from scenewidget.engine.operators import Eigenbasis, eigenbasis
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise, WordExercise

__all__ = ["EXERCISES"]

PLACES = {
    "middle": (0.5, 0.5),
    "right tip": (1.0, 0.5),
    "upper tip": (0.5, 1.3),
    "inner corner": (0.6, 0.6),
}
LATER, LARGER, AREA, WAIT, SMALL = 0.05, 3.0, 2.5, 0.01, 0.01


@cache
def _figure() -> tuple[Mesh, Eigenbasis]:
    mesh = analytic.paper_figure(20)
    return mesh, eigenbasis(mesh, 40)


def _heat_at(time: float) -> dict[str, float]:
    mesh, basis = _figure()
    x, y, _ = mesh.vertices.T
    heat = heat_kernel_signature(basis, np.array([time]))[:, 0]
    return {name: float(heat[np.hypot(x - a, y - b).argmin()]) for name, (a, b) in PLACES.items()}


def warmest_place() -> str:
    """Most heat left at t = 0.05 m²."""
    heat = _heat_at(LATER)
    return max(heat, key=heat.__getitem__)


def _enlarged() -> Mesh:
    return Mesh(LARGER * _figure()[0].vertices, _figure()[0].faces)


def factor_of_gps() -> float:
    """φ has the unit 1/m and so has √λ."""
    large, small = (global_point_signature(eigenbasis(m, 4)) for m in (_enlarged(), _figure()[0]))
    return float(np.linalg.norm(large[:, 0]) / np.linalg.norm(small[:, 0]))


def factor_of_hks() -> float:
    """φ² has the unit 1/m², and λt stays what it was."""
    large, small = (
        heat_kernel_signature(eigenbasis(m, 20), np.array([t]))
        for m, t in ((_enlarged(), LARGER**2 * LATER), (_figure()[0], LATER))
    )
    return float((large / small).mean())


def heat_in_the_end() -> float:
    """φ₀² = 1/area is all that is left."""
    mesh = analytic.square(6, size=np.sqrt(AREA))
    return float(heat_kernel_signature(eigenbasis(mesh, 8), np.array([1e4]))[0, 0])


def damped_from() -> float:
    """exp(−λt) = 1 %."""
    return float(-np.log(SMALL) / WAIT)


def hks(values: FloatArray, vectors: FloatArray, times: FloatArray) -> FloatArray:
    """Σᵢ exp(−λᵢ t) φᵢ(p)², a matrix product."""
    return np.asarray(vectors**2 @ np.exp(-np.outer(values, times)))


def gps(values: FloatArray, vectors: FloatArray) -> FloatArray:
    """φᵢ/√λᵢ from i = 1 on."""
    return np.asarray(vectors[:, 1:] / np.sqrt(values[1:]))


def _bases() -> dict[str, Eigenbasis]:
    return {
        "a square": eigenbasis(analytic.square(5, triangulation="irregular"), 12),
        "a sphere": eigenbasis(analytic.sphere(2), 10),
        "a torus": eigenbasis(analytic.torus(n_ring=12, n_tube=7), 15),
    }


def _spectra() -> dict[str, tuple[Any, ...]]:
    times = np.geomspace(0.01, 1.0, 7)
    return {name: (np.array(b.values), np.array(b.vectors), times) for name, b in _bases().items()}


def _coordinates() -> dict[str, tuple[Any, ...]]:
    return {name: given[:2] for name, given in _spectra().items()}


EXERCISES: tuple[Exercise, ...] = (
    WordExercise(
        name="05.1",
        level=1,
        question="At t = 0.05 m², which of the four places in `vertex` has kept most of its heat? Give its name.",
        right=warmest_place,
        choices=lambda: list(PLACES),
        why="from the end of a long arm heat can leave in one direction only.",
        hint="heat_kernel_signature at the four vertices, at t = 0.05.",
        mistakes={
            "there it has *least*: heat leaves in all directions": lambda r: min(
                _heat_at(LATER), key=_heat_at(LATER).__getitem__
            )
        },
    ),
    NumberExercise(
        name="05.2",
        level=2,
        question="Enlarge the figure three times, `sw.Mesh(3 * flat.vertices, flat.faces)`. By which factor does its GPS change "
        "(up to signs)?",
        right=factor_of_gps,
        why="φ has the unit 1/m and √λ has it, too; their quotient knows no size.",
        hint="φ has the unit 1/m (its square, times area, sums to 1), λ has 1/m².",
        mistakes={
            "that is what happens to φ; it is divided by √λ": lambda r: 1 / LARGER,
            "that is what happens to 1/√λ; φ changes as well": lambda r: LARGER,
            "it is λ that changes by that": lambda r: 1 / LARGER**2,
        },
    ),
    NumberExercise(
        name="05.3",
        level=2,
        question="And by which factor does HKS change on that larger figure, if we also wait longer, nine times as long?",
        right=factor_of_hks,
        why="λt stays the same, and φ² has the unit 1/m².",
        hint="HKS has the unit of φ², and λt none.",
        mistakes={
            "φ is squared in it": lambda r: np.sqrt(r),
            "λt stays, but φ² doesn't": lambda r: 1.0,
            "the same heat on a *larger* surface is thinner: one over it": lambda r: 1 / r,
        },
    ),
    NumberExercise(
        name="05.4",
        level=1,
        question="To which value, in 1/m², does the HKS of every point of a connected surface of 2.5 m² go in the end?",
        right=heat_in_the_end,
        why="one unit of heat, spread over the area: φ₀² = 1/area.",
        hint="only λ₀ = 0 is left of the sum; how large is φ₀?",
        mistakes={
            "that is the area; one unit of heat spreads over it": lambda r: AREA,
            "that is φ₀; HKS has its square": lambda r: np.sqrt(r),
            "heat isn't lost: one unit of it stays on the surface": lambda r: 0.0,
        },
    ),
    NumberExercise(
        name="05.5",
        level=2,
        question="From which eigenvalue λ (in 1/m²) on is a term of the HKS damped to less than 1 % at t = 0.01 m²?",
        right=damped_from,
        why="exp(−λt) = 0.01 at λ = ln(100)/t: with 100 functions the shortest times are cut off, hence their ripples.",
        hint="solve exp(−λt) = 0.01 for λ.",
        mistakes={
            "a natural logarithm, not that of base 10": lambda r: -np.log10(SMALL) / WAIT,
            "there it is damped to 1/e: 1/t is the order of magnitude only": lambda r: 1 / WAIT,
            "divide by t, don't multiply": lambda r: -np.log(SMALL) * WAIT,
            "that is the frequency √λ": lambda r: np.sqrt(r),
        },
    ),
    FunctionExercise(
        name="05.6",
        level=3,
        signature="hks(values, vectors, times)",
        question="Write `hks(values, vectors, times)`: the heat kernel signature, an (n, T) array, from k eigenvalues, an (n, k) "
        "array of eigenfunctions and T times.",
        right=hks,
        cases=_spectra,
        why="a matrix product: squares of φ times exponentials.",
        hint="HKS(p, t) = Σᵢ exp(−λᵢ t) φᵢ(p)².",
        mistakes={
            "φ must be squared": lambda values, vectors, times: vectors @ np.exp(-np.outer(values, times)),
            "the sign in the exponent: heat decays": lambda values, vectors, times: (
                vectors**2 @ np.exp(np.outer(values, times))
            ),
            "λ is in the exponent as it is, not its root": lambda values, vectors, times: (
                vectors**2 @ np.exp(-np.outer(np.sqrt(values), times))
            ),
            "the constant φ₀ counts in HKS: its share is what is left in the end": lambda values, vectors, times: (
                hks(values[1:], vectors[:, 1:], times)
            ),
            "that is the heat kernel squared: exp(−λt), not exp(−2λt)": lambda values, vectors, times: hks(
                2 * values, vectors, times
            ),
        },
    ),
    FunctionExercise(
        name="05.7",
        level=3,
        signature="gps(values, vectors)",
        question="Write `gps(values, vectors)`: the global point signature, an (n, k − 1) array. The first eigenvalue is 0.",
        right=gps,
        cases=_coordinates,
        why="the constant is left out, for its λ is 0 and it tells nothing.",
        hint="GPS(p) = (φ₁(p)/√λ₁, φ₂(p)/√λ₂, …).",
        mistakes={
            "divided by λ; by its root is asked for": lambda values, vectors: vectors[:, 1:] / values[1:],
            "those are the bare eigenfunctions, the high ones weigh as much as the low": lambda values, vectors: (
                vectors[:, 1:]
            ),
            "multiplied by √λ: that makes the high ones weigh most": lambda values, vectors: (
                vectors[:, 1:] * np.sqrt(values[1:])
            ),
            "the last one fell away, and not the constant": lambda values, vectors: (
                vectors[:, :-1] / np.sqrt(np.where(values[:-1] > 0, values[:-1], 1))
            ),
        },
    ),
)
