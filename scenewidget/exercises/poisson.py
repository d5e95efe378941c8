"""Exercises of notebook 14: gradient, divergence, Poisson."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.datasets import analytic
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.operators import cotangent_laplacian
from scenewidget.exercises.judging import (
    Exercise,
    FunctionExercise,
    ListExercise,
    NumberExercise,
    WordExercise,
)

__all__ = ["EXERCISES"]

CORNERS = np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0]])
VALUES = np.array([1.0, 5.0, 4.0])


def slope() -> list[float]:
    """Two units over a metre along x, three along y."""
    return [(VALUES[1] - VALUES[0]) / 2, (VALUES[2] - VALUES[0]) / 1]


def removed() -> float:
    """The mean of x² over [0, 1]²."""
    return 1 / 3


def gradient(vertices: FloatArray, faces: IntArray, u: FloatArray) -> FloatArray:
    """∇u = Σ uᵢ (N × eᵢ)/(2 area), edge eᵢ facing corner i."""
    out = np.zeros((len(faces), 3))
    for f, face in enumerate(faces.tolist()):
        p = [vertices[i] for i in face]
        double = np.cross(p[1] - p[0], p[2] - p[0])
        size = np.linalg.norm(double)  # twice the area
        for c in range(3):
            edge = p[(c + 2) % 3] - p[(c + 1) % 3]
            out[f] += u[face[c]] * np.cross(double / size, edge) / size
    return out


def divergence(vertices: FloatArray, faces: IntArray, X: FloatArray) -> FloatArray:
    """−Gᵀ M X: each corner gets −½ ⟨N × e, X⟩, with the edge that faces it."""
    out = np.zeros(len(vertices))
    for face, x in zip(faces.tolist(), X, strict=True):
        p = [vertices[i] for i in face]
        double = np.cross(p[1] - p[0], p[2] - p[0])
        normal = double / np.linalg.norm(double)
        for c in range(3):
            out[face[c]] -= np.cross(normal, p[(c + 2) % 3] - p[(c + 1) % 3]) @ x / 2
    return out


def poisson(W: FloatArray, A: FloatArray, f: FloatArray, border: IntArray) -> FloatArray:
    """W_II u_I = (A f)_I, u = 0 at the border."""
    u = np.zeros(len(f))
    inner = np.setdiff1d(np.arange(len(f)), border)
    u[inner] = np.linalg.solve(W[np.ix_(inner, inner)], (A * f)[inner])
    return u


def _meshes() -> dict[str, Any]:
    return {
        "an irregular square": analytic.square(3, size=2.0, triangulation="irregular"),
        "folded paper": analytic.folded(analytic.square(4), "x", 0.5, 1.0),
        "a torus": analytic.torus(n_ring=7, n_tube=5),
    }


def _functions() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(2)
    return {
        name: (np.array(mesh.vertices), np.array(mesh.faces), rng.random(mesh.n_vertices))
        for name, mesh in _meshes().items()
    }


def _fields() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(3)
    return {
        name: (np.array(mesh.vertices), np.array(mesh.faces), rng.normal(size=(mesh.n_faces, 3)))
        for name, mesh in _meshes().items()
    }


def _problems() -> dict[str, tuple[Any, ...]]:
    cases = {}
    for name, mesh in (
        ("a square", analytic.square(6)),
        ("an irregular square", analytic.square(5, size=2.0, triangulation="irregular")),
    ):
        W, A = cotangent_laplacian(mesh)
        x, y, _ = mesh.vertices.T
        border = np.flatnonzero((x == 0) | (y == 0) | (x == x.max()) | (y == y.max()))
        cases[name] = (W.toarray(), A.diagonal(), 1 + x * y, border)
    return cases


def _tilted(vertices: FloatArray, faces: IntArray, u: FloatArray) -> Any:
    """Not turned by 90°: e instead of N × e."""
    corners = vertices[faces]
    edges = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    size = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.einsum("fc,fcx->fx", u[faces], edges) / size[:, None]


def _unweighted(vertices: FloatArray, faces: IntArray, X: FloatArray) -> Any:
    corners = vertices[faces]
    size = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return divergence(vertices, faces, X / (size / 2)[:, None])


EXERCISES: tuple[Exercise, ...] = (
    ListExercise(
        name="14.1",
        level=1,
        question="A triangle has its corners at (0, 0), (2, 0) and (0, 1), and u is 1, 5 and 4 there. What is ∇u? Give two numbers.",
        right=slope,
        why="4 more over two metres along x, 3 more over one along y.",
        hint="how much does u grow along x, a metre? And along y?",
        mistakes={
            "that is by how much u grows along the edges; a slope is per metre": lambda r: [4.0, 3.0],
            "x and y are swapped": lambda r: r[::-1],
            "downhill: the gradient points uphill": lambda r: [-s for s in r],
        },
    ),
    NumberExercise(
        name="14.2",
        level=1,
        question="What is the sum of the integrated divergence −GᵀMX over all vertices of a mesh, whatever the field X?",
        right=lambda: 0.0,
        why="1ᵀGᵀ = (G 1)ᵀ = 0: the gradient of a constant. What leaves one place arrives at another.",
        hint="multiply by 1ᵀ from the left: what is the gradient of a constant?",
        mistakes={"it does not depend on the area": lambda r: 1.0},
    ),
    NumberExercise(
        name="14.3",
        level=2,
        question="Δu = x² − c on the unit square with a free border has a solution for one c only. Which?",
        right=removed,
        why="the right side must integrate to 0: c is the mean of x², 1/3.",
        hint="1ᵀW = 0, so ∫ f = 0 is needed.",
        mistakes={
            "that is the mean of x; the mean of x² is asked for": lambda r: 0.5,
            "the mean of x² over 0 to 1 is ∫ x² dx": lambda r: 1.0,
            "then ∫ x² − c would be 1/3, and heat would flow in for ever": lambda r: 0.0,
        },
    ),
    WordExercise(
        name="14.4",
        level=2,
        question='A hole in a cylinder is to be closed so that the filling goes on with the slope of its border. Which filling does that, "harmonic" or "biharmonic"?',
        choices=lambda: ["harmonic", "biharmonic"],
        right=lambda: "biharmonic",
        why="L² takes two rings of the border, so the slope as well as the position.",
        hint="how many rings of known vertices does L see, and how many L²?",
        mistakes={
            "a film meets the border at any angle: L sees the first ring only, so positions and no slope": lambda r: (
                "harmonic"
            )
        },
    ),
    FunctionExercise(
        name="14.5",
        level=3,
        signature="gradient(vertices, faces, u)",
        question="Write `gradient(vertices, faces, u)`: ∇u on each face, an (n_faces, 3) array.",
        right=gradient,
        cases=_functions,
        why="Σ uᵢ (N × eᵢ)/(2 area), on all meshes.",
        hint="Σ uᵢ (N × eᵢ)/(2 area): unit normal, the edge that faces corner i, counter-clockwise.",
        mistakes={
            "the sign: is each edge taken counter-clockwise, from corner i + 1 to i + 2, and N × e, not e × N?": (
                lambda v, f, u: -gradient(v, f, u)
            ),
            "half of it: the area is half of ‖a × b‖, and 2 area stands below": lambda v, f, u: (
                gradient(v, f, u) / 2
            ),
            "twice too large: 2 area stands below, not the area": lambda v, f, u: 2 * gradient(v, f, u),
            "the edges are not turned: N × e, not e": _tilted,
        },
    ),
    FunctionExercise(
        name="14.6",
        level=3,
        signature="divergence(vertices, faces, X)",
        question="Write `divergence(vertices, faces, X)`: the integrated divergence −GᵀMX of a field X, (n_faces, 3), an (n_vertices,) array.",
        right=divergence,
        cases=_fields,
        why="the transpose of the gradient, with the areas between.",
        hint="each corner of a face gets −⟨N × e, X⟩/2, with the edge that faces it: the area has cancelled.",
        mistakes={
            "the sign: −GᵀMX; a field that points away from a vertex has positive divergence there": lambda v, f, X: (
                -divergence(v, f, X)
            ),
            "the areas are missing, GᵀX: a large triangle counts for more": _unweighted,
            "twice too much: ½ ⟨N × e, X⟩": lambda v, f, X: 2 * divergence(v, f, X),
        },
    ),
    FunctionExercise(
        name="14.7",
        level=3,
        signature="poisson(W, A, f, border)",
        question="Write `poisson(W, A, f, border)`: u with Δu = f, and 0 at the vertices `border`. W is (n, n) and dense, A the (n,) areas.",
        right=poisson,
        cases=_problems,
        why="W_II u_I = (A f)_I; the border's zeros bring nothing to the right side.",
        hint="solve for the inner vertices only; on the right stand the *integrals* A f.",
        mistakes={
            "the areas are missing on the right: W u = A f": lambda W, A, f, border: poisson(
                W, np.ones_like(A), f, border
            ),
            "the sign: our Δ is positive": lambda W, A, f, border: -poisson(W, A, f, border),
            "u is the *solution*: that is f, with zeros at the border": lambda W, A, f, border: np.where(
                np.isin(np.arange(len(f)), border), 0, f
            ),
        },
    ),
)
