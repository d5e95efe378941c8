"""Exercises of notebook 06: distances that see creases."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csgraph

from scenewidget.engine.distances import edge_costs, weight_graph
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.exercises.judging import Exercise, FunctionExercise, ListExercise, NumberExercise

__all__ = ["EXERCISES"]

ANGLE, TURNS, POINTS, TIMES = 60.0, 9, 20, 1000.0
STEP = 0.25


def _cost(degrees: float, exponent: float) -> float:
    """The engine's cost between two unit normals at this angle."""
    angle = np.radians(degrees)
    normals = np.array([[0.0, 0.0, 1.0], [np.sin(angle), 0.0, np.cos(angle)]])
    return float(edge_costs(normals, np.array([[0, 1]]), exponent=exponent)[0])


def smallest_exponent() -> float:
    """The first of 0.25, 0.5, … that separates 90° from 10° by a thousand."""
    return next(float(c) for c in STEP * np.arange(1, 100) if _cost(90, c) >= TIMES * _cost(10, c))


def cost_of_sixty() -> float:
    """(1 − cos 60°)^1.5."""
    return _cost(ANGLE, 1.5)


def rounded_crease() -> float:
    """Nine turns of ten degrees, C = 1."""
    return TURNS * _cost(90 / TURNS, 1.0)


def fill_of_a_star() -> list[int]:
    """Middle first: all pairs of its neighbours. Middle last: none."""
    return [_fill(range(POINTS + 1)), _fill(range(POINTS, -1, -1))]


def _fill(order: range) -> int:
    """New edges when the nodes of the star go in this order."""
    near = {0: set(range(1, POINTS + 1)), **{i: {0} for i in range(1, POINTS + 1)}}
    new = 0
    for node in order:
        beside = near.pop(node)
        for a in beside:
            near[a].discard(node)
            fresh = {b for b in beside if b > a} - near[a]
            new += len(fresh)
            near[a] |= fresh
            for b in fresh:
                near[b].add(a)
    return new


def shortest_way() -> float:
    """Dijkstra's algorithm on the graph in the question."""
    pairs = np.array([[0, 1], [1, 2], [0, 3], [3, 2], [1, 3]])
    graph = weight_graph(4, pairs, np.array([4.0, 4.0, 2.0, 5.0, 1.0]))
    return float(csgraph.dijkstra(graph)[0, 2])


def min_plus(A: FloatArray, B: FloatArray) -> FloatArray:
    """Row by row: smallest sum over the node in the middle."""
    return np.array([(row[:, None] + B).min(axis=0) for row in A])


def _usual_product(A: FloatArray, B: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(A @ B, nan=np.inf, posinf=np.inf)


def costs(normals: FloatArray, pairs: IntArray, exponent: float) -> FloatArray:
    """(1 − ⟨N, N⟩)^C, never below 0."""
    dots = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(axis=1)
    return np.asarray(np.maximum(1 - dots, 0) ** exponent)


def _engine_costs(normals: FloatArray, pairs: IntArray, exponent: float) -> Any:
    return edge_costs(normals, pairs, exponent=exponent)


def _matrices() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(6)

    def lengths(n: int, m: int, share: float) -> FloatArray:
        values = rng.integers(1, 10, (n, m)).astype(float)
        values[rng.random((n, m)) < share] = np.inf
        return values

    chain = np.full((4, 4), np.inf)
    np.fill_diagonal(chain, 0.0)
    chain[[0, 1, 2], [1, 2, 3]] = chain[[1, 2, 3], [0, 1, 2]] = [1.0, 2.0, 4.0]
    return {
        "a chain of four nodes": (chain, chain),
        "full matrices": (lengths(5, 5, 0.0), lengths(5, 5, 0.0)),
        "matrices that are not square": (lengths(3, 6, 0.3), lengths(6, 2, 0.3)),
    }


def _creases() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(7)
    normals = rng.normal(size=(12, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    pairs = rng.integers(0, 12, (20, 2))
    flat = np.array([[0.6, 0.0, 0.8], [0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    return {
        "a flat step, a right angle and a full turn": (flat, np.array([[0, 1], [1, 2], [2, 3]]), 1.5),
        "random normals": (normals, pairs, 1.5),
        "the exponent ½": (normals, pairs, 0.5),
    }


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="06.1",
        level=1,
        question="Which is the smallest exponent among 0.25, 0.5, 0.75, 1, … for which a crease of 90° costs at least 1000 times "
        "as much as one of 10°?",
        right=smallest_exponent,
        is_exact=True,
        why="the ratio is (1/(1 − cos 10°))^C, and 65.8^C passes 1000 there.",
        hint="cost(90, c) / cost(10, c) for one exponent after the other.",
        mistakes={
            "enough, but there is a smaller one": lambda r: r + STEP,
            "that is less than 1000 times": lambda r: r - STEP,
            "that solves the equation, but it is none of the choices: 0.25, 0.5, …": lambda r: (
                np.log(TIMES) / -np.log(_cost(10, 1))
            ),
            "enough, but there are smaller ones": lambda r: r + 2 * STEP,
        },
    ),
    ListExercise(
        name="06.2",
        level=2,
        question="A star: node 0 in the middle, joined to 20 others that are not joined to each other. How many *new* edges come "
        "up if the middle is eliminated first, and how many if it goes last? Give both numbers.",
        right=fill_of_a_star,
        why="first, it joins each pair of its 20 neighbours; last, each point of the star has one neighbour when it goes.",
        hint="eliminating a node joins all pairs of the neighbours that it has then.",
        mistakes={
            "the other way around: first things first": lambda r: r[::-1],
            "a pair of neighbours is one edge, not two": lambda r: [2 * r[0], r[1]],
            "n neighbours have n(n − 1)/2 pairs; a node makes none with itself": lambda r: [
                POINTS**2 // 2,
                r[1],
            ],
            "the edges of the star itself are not new": lambda r: [r[0] + POINTS, r[1] + POINTS],
        },
    ),
    FunctionExercise(
        name="06.3",
        level=3,
        signature="min_plus(A, B)",
        question="In this algebra a matrix product is $(A \\otimes B)_{ij} = \\min_k (a_{ik} + b_{kj})$. With $A$ the weights (0 on "
        "the diagonal, ∞ where there is no edge), $A \\otimes A$ holds the shortest paths of at most two steps, $(A \\otimes A) "
        "\\otimes (A \\otimes A)$ of at most four, and so on. Write `min_plus(A, B)`. (For n nodes `A[:, :, None] + B[None]` holds n³ "
        "numbers; mind your memory.)",
        right=min_plus,
        cases=_matrices,
        why="n³ additions, and squaring log₂ n times gives all shortest paths.",
        hint="add where the usual product multiplies, and take the minimum where it adds.",
        mistakes={
            "those are longest ways: the minimum, not the maximum": lambda A, B: np.array(
                [(row[:, None] + B).max(axis=0) for row in A]
            ),
            "that is the usual product: + becomes min, · becomes +": _usual_product,
            "that is min(a, b) entry by entry; the minimum runs over the node k in the middle": lambda A, B: (
                np.minimum(A, B) if A.shape == B.shape else min_plus(A, B) + 1
            ),
            "B is transposed: row i of A meets *column* j of B": lambda A, B: (
                min_plus(A, B.T) if A.shape == B.shape else min_plus(A, B)
            ),
        },
    ),
    NumberExercise(
        name="06.4",
        level=1,
        question="What does it cost to step over a crease of 60° under f2, $(1 - \\cos θ)^{1.5}$?",
        right=cost_of_sixty,
        why="cos 60° = ½, and ½ to the power 1.5 is about a third of a right angle's 1.",
        hint="cos 60° = ½.",
        mistakes={
            "that is with C = 1; f2 has 1.5": lambda r: _cost(ANGLE, 1.0),
            "were the 60 degrees taken as radians?": lambda r: (1 - np.cos(60.0)) ** 1.5,
            "the exponent is 1.5, not ½": lambda r: _cost(ANGLE, 0.5),
            "that is sin and not cos": lambda r: (1 - np.sin(np.radians(ANGLE))) ** 1.5,
        },
    ),
    NumberExercise(
        name="06.5",
        level=2,
        question="A right angle is rounded: nine turns of 10° one after the other. What do they cost together with C = 1?",
        right=rounded_crease,
        why="a seventh of the sharp crease: with C > ½ finer triangles make rounded creases cheaper.",
        hint="nine times the cost of one turn.",
        mistakes={
            "that is one of the nine turns": lambda r: r / TURNS,
            "that is with C = ½, where turns add up": lambda r: TURNS * _cost(10, 0.5),
            "that is with C = 1.5": lambda r: TURNS * _cost(10, 1.5),
            "that is the sharp crease": lambda r: 1.0,
        },
    ),
    NumberExercise(
        name="06.6",
        level=1,
        question="Four nodes: 0–1 and 1–2 cost 4 each, 0–3 costs 2, 3–2 costs 5 and 1–3 costs 1. How long is the shortest way from "
        "0 to 2?",
        right=shortest_way,
        why="over 3: and it doesn't help to go on over 1, which costs as much.",
        hint="list the ways from 0 to 2: over 1, over 3, over both.",
        mistakes={
            "that is over 1; there is a shorter one": lambda r: 8.0,
            "the fewest steps are not the least cost": lambda r: 9.0,
        },
    ),
    FunctionExercise(
        name="06.7",
        level=3,
        signature="costs(normals, pairs, exponent)",
        question="Write `costs(normals, pairs, exponent)`: max(1 − ⟨N_x, N_y⟩, 0)^C for each pair of an (n, 3) array of unit "
        "normals.",
        right=_engine_costs,
        cases=_creases,
        also=(costs,),
        why="the maximum matters: rounding makes ⟨N, N⟩ larger than 1 at times, and a root of a negative number is NaN.",
        hint="the scalar product of the two normals, row by row.",
        mistakes={
            "the sign: 1 − ⟨N, N⟩, so that flat costs nothing": lambda n, p, c: edge_costs(
                n, p, b=1.0, exponent=c
            ),
            "the exponent is missing": lambda n, p, c: edge_costs(n, p, exponent=1.0),
            "that is the angle itself, to the power C": lambda n, p, c: (
                np.arccos(np.clip((n[p[:, 0]] * n[p[:, 1]]).sum(axis=1), -1, 1)) ** c
            ),
        },
    ),
)
