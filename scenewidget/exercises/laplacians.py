"""Exercises of notebook 03: two Laplacians."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from scenewidget.datasets import analytic
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.operators import cotangent_laplacian, uniform_laplacian
from scenewidget.exercises import reading
from scenewidget.exercises.judging import Exercise, FunctionExercise, ListExercise, NumberExercise

__all__ = ["EXERCISES"]

CURVATURE, RING, SIDE, ALPHA = 4.0, 1.0, 2.0, 100.0


def radius() -> float:
    """H = 1/r on a sphere."""
    return 1 / CURVATURE


def tube() -> float:
    """H = (R + 2 r cos v)/(2 r (R + r cos v)) on the inner circle, cos v = −1."""
    return float(brentq(lambda r: (RING - 2 * r) / (2 * r * (RING - r)), 0.1, 0.9))


def weight_of_equilateral() -> float:
    """(cot α + cot β)/2 of an inner edge, taken from the matrix of two equilateral triangles."""
    h = np.sqrt(3) / 2
    corners = np.array([[0, 0, 0], [1, 0, 0], [0.5, h, 0], [0.5, -h, 0]])
    W, _ = cotangent_laplacian(Mesh(corners, np.array([[0, 1, 2], [1, 0, 3]])))
    return -float(W[0, 1])


def opposite_angle() -> float:
    """Cot α + cot β = sin(α + β)/(sin α sin β) vanishes where the angles sum to π."""
    return float(brentq(lambda b: 1 / np.tan(np.radians(ALPHA)) + 1 / np.tan(np.radians(b)), 1.0, 179.0))


def energy() -> float:
    """uᵀWu = ∫|∇u|² of u = x."""
    mesh = analytic.square(4, size=SIDE)
    x = mesh.vertices[:, 0]
    return float(x @ (cotangent_laplacian(mesh)[0] @ x))


def saddle() -> FloatArray:
    """x² and y² have the same second difference on the grid, and no diagonal neighbour changes that."""
    x, y, _ = analytic.square(20).vertices.T
    return np.asarray(x**2 - y**2)


def assemble(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Corner by corner: half its cotangent goes to the edge that faces it, its share of the area to it."""
    n = len(vertices)
    W, A = np.zeros((n, n)), np.zeros(n)
    for face in faces.tolist():
        p = [vertices[i] for i in face]
        double_area = np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0]))
        dots = [(p[(c + 1) % 3] - p[c]) @ (p[(c + 2) % 3] - p[c]) for c in range(3)]
        cots = [dot / double_area for dot in dots]
        for c in range(3):
            j, k = (c + 1) % 3, (c + 2) % 3
            i_j, i_k = face[j], face[k]
            for a, b in ((i_j, i_k), (i_k, i_j)):
                W[a, b] -= cots[c] / 2
                W[a, a] += cots[c] / 2
            if min(dots) >= 0:  # Voronoi: the edges to k and j are faced by j and k
                square_k = (p[k] - p[c]) @ (p[k] - p[c])
                square_j = (p[j] - p[c]) @ (p[j] - p[c])
                A[face[c]] += (square_k * cots[j] + square_j * cots[k]) / 8
            else:
                A[face[c]] += double_area / (4 if dots[c] < 0 else 8)
    return W, A


def _engine(vertices: FloatArray, faces: IntArray) -> tuple[Any, Any]:
    W, A = cotangent_laplacian(Mesh(vertices, faces))
    return W.toarray(), A.diagonal()


def _variant(change: Any) -> Any:
    def function(vertices: FloatArray, faces: IntArray) -> tuple[Any, Any]:
        W, A = change(*_engine(vertices, faces), Mesh(vertices, faces))
        return W, A

    return function


def _thirds(mesh: Mesh) -> Any:
    return np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas / 3, 3), mesh.n_vertices)


def _voronoi(mesh: Mesh) -> Any:
    """Voronoi shares everywhere, negative ones in obtuse triangles too."""
    corners = mesh.vertices[mesh.faces]
    e = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    dots = -np.einsum("fci,fci->fc", np.roll(e, -1, axis=1), np.roll(e, -2, axis=1))
    pull = (e**2).sum(axis=2) * dots / (2 * mesh.face_areas[:, None])
    share = (np.roll(pull, -1, axis=1) + np.roll(pull, -2, axis=1)) / 8
    return np.bincount(mesh.faces.ravel(), share.ravel(), mesh.n_vertices)


def _meshes() -> dict[str, tuple[Any, ...]]:
    ring = analytic.torus(n_ring=8, n_tube=6)
    meshes = {
        "one right-angled triangle": Mesh(
            np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]]), np.array([[0, 1, 2]])
        ),
        "an irregular square": analytic.square(3, triangulation="irregular"),
        "a mesh with obtuse triangles": Mesh(
            analytic.square(2).vertices * [3.0, 1.0, 1.0] + [[0.2 * i, 0, 0] for i in range(9)],
            analytic.square(2).faces,
        ),
        "a torus": Mesh(ring.vertices * [1.0, 0.6, 1.0], ring.faces),
    }
    return {name: (np.array(mesh.vertices), np.array(mesh.faces)) for name, mesh in meshes.items()}


def _delta(vertices: FloatArray, faces: IntArray) -> Any:
    return uniform_laplacian(Mesh(vertices, faces)) @ vertices


def uniform_delta(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Sum of vᵢ − vⱼ over the neighbours, each of them once."""
    beside: list[set[int]] = [set() for _ in vertices]
    for a, b, c in faces.tolist():
        beside[a] |= {b, c}
        beside[b] |= {a, c}
        beside[c] |= {a, b}
    return np.array([sum(vertices[i] - vertices[j] for j in near) for i, near in enumerate(beside)])


def _means(vertices: FloatArray, faces: IntArray) -> Any:
    L = uniform_laplacian(Mesh(vertices, faces))
    return (L @ vertices) / L.diagonal()[:, None]


def _twice(vertices: FloatArray, faces: IntArray) -> Any:
    out = np.zeros_like(vertices)
    for a, b in np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]):
        out[a] += vertices[a] - vertices[b]
        out[b] += vertices[b] - vertices[a]
    return out


def _saddle_values(answer: Any) -> list[float]:
    """Values at the vertices, or a function of x and y."""
    if callable(answer) and not hasattr(answer, "__iter__"):
        x, y, _ = analytic.square(20).vertices.T
        answer = answer(x.copy(), y.copy())
    return reading.numbers(answer)


def _saddle_complaint(values: list[float]) -> str:
    mesh = analytic.square(20)
    x, y, _ = mesh.vertices.T
    if len(values) != len(x):
        return f"a value for each of the {len(x)} vertices is asked for, you gave {len(values)}"
    u = np.array(values)
    if np.ptp(u) <= 1e-9 * abs(u).max():
        return "that is a constant; another one is asked for"
    u = u / abs(u).max()
    linear = np.column_stack([x, y, np.ones_like(x)])
    if abs(u - linear @ np.linalg.lstsq(linear, u, rcond=None)[0]).max() < 1e-6:
        return "that is linear; one that bends is asked for"
    inside = (x > 0) & (x < 1) & (y > 0) & (y < 1)
    L = uniform_laplacian(mesh)
    if abs((L @ u)[inside]).max() < 1e-7:
        return ""
    quadratic = np.column_stack([linear, x**2, x * y, y**2])
    weights, *_ = np.linalg.lstsq(quadratic, u, rcond=None)
    if abs(u - quadratic @ weights).max() < 1e-6:
        if abs(weights[4]) > 1e-6 and abs(weights[3] + weights[5]) < 1e-6:
            return (
                "x·y is harmonic on the plane and for the cotangent Laplacian, but the diagonals of this grid all run one "
                "way, and the uniform Laplacian sees them. Which saddle has its axes along the grid?"
            )
        if weights[3] * weights[5] > 0:
            return "that is a bowl: it bends the same way in x and in y. A saddle bends up one way, down the other"
        return "it bends in x and y, but not equally much: the two must cancel"
    return "it is 0 in some places only. Which two powers have the same second difference everywhere?"


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="03.1",
        level=1,
        question="A sphere has mean curvature 4/m. What is its radius in metres?",
        right=radius,
        why="H = 1/r, a quarter of a metre.",
        hint="on a sphere H = 1/r.",
        mistakes={
            "a radius is a length, and not negative": lambda r: -r,
            "that is H itself; its unit is 1/m": lambda r: CURVATURE,
            "1/r² is the *Gaussian* curvature, the product of the two; H is their mean": lambda r: np.sqrt(r),
            "in metres, please": lambda r: 100 * r,
        },
    ),
    ListExercise(
        name="03.2",
        level=2,
        question="Find a function on `regular`, neither constant nor linear, whose uniform Laplacian is 0 at all inner "
        "vertices. Give its values at the vertices, or a function of x and y. (Hint: a saddle.)",
        right=saddle,
        reads=_saddle_values,
        accepts=_saddle_complaint,
        why="its second differences along x and along y cancel at every inner vertex.",
        hint="what do x² and y² have in common?",
    ),
    NumberExercise(
        name="03.3",
        level=2,
        question="On a torus with ring radius 1 m, how large must the radius of the tube be, in metres, for the mean curvature "
        "along the innermost circle to vanish?",
        right=tube,
        why="R + 2 r cos v = 0 at cos v = −1: the tube's 1/r and the hole's −1/(R − r) are equal then.",
        hint="on the innermost circle cos v = −1; set the numerator of H to 0.",
        mistakes={
            "then the hole would close: R − r is 0, and H is not defined": lambda r: RING,
            "the numerator is R + 2 r cos v; twice r, once": lambda r: r / 2,
            "cos v is −1 on the inside, and 1 on the outside": lambda r: -r,
        },
    ),
    NumberExercise(
        name="03.4",
        level=2,
        question="Which weight (cot α + cot β)/2 has an inner edge of a mesh of equilateral triangles?",
        right=weight_of_equilateral,
        why="both angles are 60°, and the half takes the two cotangents to one: cot 60° = 1/√3.",
        hint="which two angles face the edge?",
        mistakes={
            "that is the sum of both cotangents, without the half": lambda r: 2 * r,
            "an inner edge has a triangle on *each* side": lambda r: r / 2,
            "that is the tangent of 60°; cot = 1/tan": lambda r: 1 / r,
            "was 60 taken as radians?": lambda r: 1 / np.tan(60),
        },
    ),
    NumberExercise(
        name="03.5",
        level=2,
        question="One of the two angles that face an edge is 100°. From how many degrees of the other one on is the weight of "
        "the edge negative?",
        right=opposite_angle,
        why="cot α + cot β = sin(α + β)/(sin α · sin β) changes sign at α + β = 180°, and that is the test for Delaunay.",
        hint="when is cot α = −cot β?",
        mistakes={
            "that is the same angle: its cotangent has the same sign, so the sum can't vanish": lambda r: (
                ALPHA
            ),
            "the four angles of a quadrilateral sum to 360°, but here it is two of them that count": lambda r: (
                360 - ALPHA
            ),
            "at 90° the other cotangent is 0, and cot 100° alone is negative already: it begins earlier": lambda r: (
                90.0
            ),
        },
    ),
    NumberExercise(
        name="03.6",
        level=2,
        question="What is uᵀWu for u = x on a square of side 2 m? (W is the cotangent matrix. Try to say it before you "
        "compute it.)",
        right=energy,
        why="uᵀWu = ∫‖∇u‖², the slope is 1 everywhere, and the area is 4 m².",
        hint="uᵀWu = ∫‖∇u‖² over the square.",
        mistakes={
            "that is the Dirichlet *energy*, ½ uᵀWu; the integral itself is twice that": lambda r: r / 2,
            "that is for the square of side 1; the slope stays 1, the area doesn't": lambda r: r / SIDE**2,
            "that is ∫u², or nearly: uᵀAu. W has the slope in it": lambda r: SIDE**4 / 3,
        },
    ),
    FunctionExercise(
        name="03.7",
        level=3,
        signature="uniform_delta(vertices, faces)",
        question="Write `uniform_delta(vertices, faces)`: the δ-coordinates δᵢ = Σⱼ (vᵢ − vⱼ), an (n, 3) array; j runs over the "
        "neighbours of i, each of them once.",
        right=_delta,
        cases=_meshes,
        also=(uniform_delta,),
        why="a set of neighbours a vertex, or L V with the matrix of this notebook, it is the same.",
        hint="for each vertex: its neighbours once each, and the sum of its position less theirs.",
        mistakes={
            "an inner edge was counted twice, once in each of its triangles": _twice,
            "that is divided by the number of neighbours: the step from their mean. The sum is asked for": _means,
            "the other way around: from the neighbours to the vertex": lambda v, f: -_delta(v, f),
        },
    ),
    FunctionExercise(
        name="03.8",
        level=3,
        signature="assemble(vertices, faces)",
        question="Write `assemble(vertices, faces)`: the cotangent matrix W and the mixed areas A as a pair, dense or sparse; A "
        "as a vector or as a diagonal matrix.",
        right=_engine,
        cases=_meshes,
        also=(assemble,),
        why="it is what the package assembles, on all meshes.",
        hint="go through the triangles; each corner gives half its cotangent to the edge that faces it.",
        mistakes={
            "W is right. A holds a third of each triangle: right in sum, but Meyer's areas are Voronoi regions": (
                _variant(lambda W, A, mesh: (W, _thirds(mesh)))
            ),
            "W is right. A is the Voronoi area also in obtuse triangles, where the circumcentre lies outside: there it is ½, ¼, ¼ of the area": (
                _variant(lambda W, A, mesh: (W, _voronoi(mesh)))
            ),
            "A is right. W is twice too large: the weight is (cot α + cot β)/2": _variant(
                lambda W, A, mesh: (2 * W, A)
            ),
            "A is right. W has the wrong sign: positive on the diagonal, so that no eigenvalue is negative": (
                _variant(lambda W, A, mesh: (-W, A))
            ),
            "A is right. W lacks its diagonal: each row must sum to 0": (
                _variant(lambda W, A, mesh: (W - np.diag(np.diagonal(W)), A))
            ),
            "A is right. The weights stand in W, but with the wrong sign and without a diagonal": (
                _variant(lambda W, A, mesh: (np.diag(np.diagonal(W)) - W, A))
            ),
            "A is right. W is the uniform Laplacian: no angle is in it": (
                _variant(lambda W, A, mesh: (uniform_laplacian(mesh).toarray(), A))
            ),
            "W and A are mixed up: W first": _variant(lambda W, A, mesh: (np.diag(A), np.diagonal(W))),
        },
    ),
)
