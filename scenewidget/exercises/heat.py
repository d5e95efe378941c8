"""Exercises of notebook 13: heat."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.datasets import analytic
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.operators import cotangent_laplacian
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise, WordExercise

__all__ = ["EXERCISES"]

LARGEST, MODE, TIME, MOMENT = 8000.0, 10.0, 0.1, 0.01


def longest_step() -> float:
    """|1 − tλ| ≤ 1 for the largest λ."""
    return 2 / LARGEST


def after_two_steps() -> float:
    """Two implicit steps of half the time: 1/(1 + tλ/2)²."""
    return 1 / (1 + TIME / 2 * MODE) ** 2


def one_over_e() -> float:
    """exp(−d²/4t) = 1/e at d = 2√t."""
    return float(2 * np.sqrt(MOMENT))


def crank_nicolson(W: FloatArray, A: FloatArray, u: FloatArray, t: float) -> FloatArray:
    """(A + tW/2) u' = (A − tW/2) u."""
    mass = np.diag(A)
    after: FloatArray = np.linalg.solve(mass + t / 2 * W, (mass - t / 2 * W) @ u)
    return after


def unit_directions(vertices: FloatArray, faces: IntArray, u: FloatArray) -> FloatArray:
    """−∇u/‖∇u‖ on each face, 0 where u is constant; ∇u = Σ uᵢ (N × eᵢ)/(2 area)."""
    X = np.zeros((len(faces), 3))
    for f, face in enumerate(faces.tolist()):
        p = [vertices[i] for i in face]
        normal = np.cross(p[1] - p[0], p[2] - p[0])
        normal /= np.linalg.norm(normal)
        for c in range(3):
            X[f] -= u[face[c]] * np.cross(normal, p[(c + 2) % 3] - p[(c + 1) % 3])
        length = np.linalg.norm(X[f])
        X[f] = X[f] / length if length > 1e-12 else 0
    return X


def _flows() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(0)
    cases = {}
    for name, mesh, t in (
        ("a square", analytic.square(5), 0.02),
        ("an irregular square", analytic.square(4, triangulation="irregular"), 0.3),
        ("a torus", analytic.torus(n_ring=8, n_tube=6), 0.05),
    ):
        W, A = cotangent_laplacian(mesh)
        cases[name] = (W.toarray(), A.diagonal(), rng.random(mesh.n_vertices), t)
    return cases


def _implicit(W: FloatArray, A: FloatArray, u: FloatArray, t: float) -> Any:
    return np.linalg.solve(np.diag(A) + t * W, A * u)


def _explicit(W: FloatArray, A: FloatArray, u: FloatArray, t: float) -> Any:
    return u - t * (W @ u) / A


def _shapes() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(1)
    corner = (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), np.array([0.0, 3, 4]))
    cases: dict[str, tuple[Any, ...]] = {"one triangle": corner}
    for name, mesh in (
        ("an irregular square", analytic.square(3, triangulation="irregular")),
        ("a torus", analytic.torus(n_ring=7, n_tube=5)),
    ):
        cases[name] = (np.array(mesh.vertices), np.array(mesh.faces), rng.random(mesh.n_vertices))
    return cases


def _with_lengths(vertices: FloatArray, faces: IntArray, u: FloatArray) -> Any:
    """The gradient itself, downhill: not of length 1."""
    corners = vertices[faces]
    edges = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    double = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(double, axis=1, keepdims=True)
    turned = np.cross((double / size)[:, None], edges)
    return -np.einsum("fc,fcx->fx", u[faces], turned) / size


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="13.1",
        level=1,
        question="The largest eigenvalue of a mesh is 8000/m². How long may an explicit step be at most, in square metres?",
        right=longest_step,
        why="1 − tλ must not fall below −1: t ≤ 2/λ.",
        hint="a mode is multiplied by 1 − tλ; when is that −1?",
        mistakes={
            "at 1/λ the mode is gone after a step, at 2/λ it swings without growing": lambda r: r / 2,
            "that is λ/2; the larger λ, the shorter the step": lambda r: LARGEST / 2,
        },
    ),
    WordExercise(
        name="13.2",
        level=1,
        question='A sheet with a free border is warm in one corner. Does the total heat 1ᵀAu fall, grow or stay with each implicit step? Answer "falls", "grows" or "stays".',
        choices=lambda: ["falls", "grows", "stays"],
        right=lambda: "stays",
        why="1ᵀW = 0, so 1ᵀA u' = 1ᵀA u: nothing flows out over a free border.",
        hint="multiply (A + tW) u' = A u by 1ᵀ from the left.",
        mistakes={
            "it would with a clamped border, over which heat leaves; the *largest value* falls": lambda r: (
                "falls"
            )
        },
    ),
    NumberExercise(
        name="13.3",
        level=2,
        question="By what is the coefficient of a mode with λ = 10/m² multiplied by *two* implicit steps of 0.05 m² each?",
        right=after_two_steps,
        why="1/(1 + 0.5) twice: 4/9. (The exact factor is e⁻¹ = 0.37, one step of 0.1 makes 0.5.)",
        hint="one step multiplies by 1/(1 + tλ).",
        mistakes={
            "that is one step of 0.1": lambda r: 0.5,
            "that is one of the two steps": lambda r: 1 / 1.5,
            "that is the exact solution; steps come near it": lambda r: np.exp(-1),
            "those are explicit steps, (1 − tλ)²": lambda r: 0.25,
        },
    ),
    NumberExercise(
        name="13.4",
        level=2,
        question="In the plane heat spreads as e^(−d²/4t)/4πt. At which distance, in metres, has it fallen to 1/e of its value at the source, "
        "at t = 0.01 m²?",
        right=one_over_e,
        why="d² = 4t, so d = 2√t = 0.2 m: heat grows like the square root of time.",
        hint="d²/4t = 1.",
        mistakes={
            "√t is only half of it: d² = 4t": lambda r: r / 2,
            "that is d²; take the root": lambda r: r**2,
            "d² = 2t is the standard deviation along one axis; 1/e is at d² = 4t": lambda r: r / np.sqrt(2),
        },
    ),
    FunctionExercise(
        name="13.5",
        level=3,
        signature="crank_nicolson(W, A, u, t)",
        question="Write `crank_nicolson(W, A, u, t)`: one step, (A + tW/2) u' = (A − tW/2) u. W is (n, n) and dense, A the (n,) areas.",
        right=crank_nicolson,
        cases=_flows,
        why="half of the flow is taken at the start, half at the end.",
        hint="a linear system: np.linalg.solve of A + tW/2, with (A − tW/2) u on the right.",
        mistakes={
            "that is the implicit step": _implicit,
            "that is the explicit step": _explicit,
            "the areas are missing": lambda W, A, u, t: crank_nicolson(W, np.ones_like(A), u, t),
            "the signs are swapped: backwards in time": lambda W, A, u, t: crank_nicolson(W, A, u, -t),
            "both halves are whole: t instead of t/2": lambda W, A, u, t: crank_nicolson(W, A, u, 2 * t),
        },
    ),
    FunctionExercise(
        name="13.6",
        level=3,
        signature="unit_directions(vertices, faces, u)",
        question="Write `unit_directions(vertices, faces, u)`: step 2 of the heat method, X = −∇u/‖∇u‖ on each face, an (n_faces, 3) array.",
        right=unit_directions,
        cases=_shapes,
        why="∇u = Σ uᵢ (N × eᵢ)/(2 area), where edge eᵢ faces corner i; the length falls out.",
        hint="on one triangle: ∇u = Σ uᵢ (N × eᵢ)/(2 area), with N the unit normal and eᵢ the edge that faces corner i, counter-clockwise.",
        mistakes={
            "uphill: the sign. X points away from the source, where u is large": lambda v, f, u: (
                -unit_directions(v, f, u)
            ),
            "not of length 1: divide by the norm": _with_lengths,
            "not of length 1, and uphill": lambda v, f, u: -_with_lengths(v, f, u),
        },
    ),
)
