"""Exercises of notebook 15: four ways to cluster a room."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise, WordExercise

__all__ = ["EXERCISES"]

# two triangles with weights 1, joined by one edge of weight ½
BRIDGED = np.zeros((6, 6))
for _a, _b, _w in ((0, 1, 1), (1, 2, 1), (0, 2, 1), (3, 4, 1), (4, 5, 1), (3, 5, 1), (2, 3, 0.5)):
    BRIDGED[_a, _b] = BRIDGED[_b, _a] = _w
LINE = np.array([0.0, 1.0, 2.0, 9.0, 10.0])


def zeros() -> int:
    """One for each connected component."""
    return 3


def cut_of_the_bridge() -> float:
    """½ on each side, over the sum of degrees 6½ there."""
    return 2 * 0.5 / 6.5


def best_swap() -> float:
    """From medoids 0 and 1 to 1 and 9 (or 10): 1 + 0 + 1 and 0 + 1."""
    D = abs(LINE[:, None] - LINE)
    before = D[:, [0, 1]].min(axis=1).sum()
    after = min(D[:, [kept, new]].min(axis=1).sum() for kept in (0, 1) for new in range(5))
    return float(before - after)


def normalized_laplacian(weights: FloatArray) -> FloatArray:
    """I − D^-½ W D^-½."""
    root = np.sqrt(weights.sum(axis=1))
    found: FloatArray = np.eye(len(weights)) - weights / np.outer(root, root)
    return found


def ncut(weights: FloatArray, labels: IntArray) -> float:
    """Σ Cut/vol over the segments."""
    degree = weights.sum(axis=1)
    found = 0.0
    for segment in np.unique(labels):
        inside = labels == segment
        found += weights[np.ix_(inside, ~inside)].sum() / degree[inside].sum()
    return found


def swap_gain(D: FloatArray, medoids: IntArray, m: int, c: int) -> float:
    """By how much the cost falls if the m-th medoid is replaced by item c."""
    swapped = medoids.copy()
    swapped[m] = c
    return float(D[:, medoids].min(axis=1).sum() - D[:, swapped].min(axis=1).sum())


def _graphs() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(0)
    noisy = rng.random((7, 7))
    noisy = np.triu(noisy, 1) + np.triu(noisy, 1).T
    return {"two triangles with a bridge": (BRIDGED.copy(),), "a graph of random weights": (noisy,)}


def _partitions() -> dict[str, tuple[Any, ...]]:
    (bridged,), (noisy,) = _graphs().values()
    return {
        "two triangles with a bridge": (bridged, np.array([0, 0, 0, 1, 1, 1])),
        "three segments": (noisy, np.array([0, 2, 2, 1, 0, 1, 1])),
        "labels with a gap": (bridged, np.array([4, 4, 7, 7, 7, 9])),
    }


def _swaps() -> dict[str, tuple[Any, ...]]:
    places = np.random.default_rng(1).random((9, 2))
    D = np.linalg.norm(places[:, None] - places, axis=2)
    line = abs(LINE[:, None] - LINE)
    return {
        "five points on a line": (line, np.array([0, 1]), 0, 3),
        "a swap that costs": (line, np.array([1, 3]), 0, 4),
        "nine points": (D, np.array([2, 5, 7]), 1, 0),
    }


def _ratio(weights: FloatArray, labels: IntArray) -> Any:
    return sum(
        weights[np.ix_(labels == s, labels != s)].sum() / (labels == s).sum() for s in np.unique(labels)
    )


def _inner(weights: FloatArray, labels: IntArray) -> Any:
    """Volume taken within the segment alone."""
    total = 0.0
    for s in np.unique(labels):
        inside = labels == s
        within = weights[np.ix_(inside, inside)].sum()
        total += weights[np.ix_(inside, ~inside)].sum() / within if within else np.inf
    return total


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="15.1",
        level=1,
        question="A graph falls into three connected components. How many eigenvalues of L h = μ D h are 0?",
        right=zeros,
        is_whole=True,
        why="a function can have a constant of its own on each component.",
        hint="which functions have hᵀLh = 0?",
        mistakes={"the constant over all is one of them, but each component has its own": lambda r: 1.0},
    ),
    NumberExercise(
        name="15.2",
        level=2,
        question="Two triangles, all of whose edges weigh 1, are joined by one edge of weight ½ between two corners. What is the Ncut of "
        "the two triangles?",
        right=cut_of_the_bridge,
        why="½ is cut on either side; the degrees of a triangle sum to 2 + 2 + 2½ = 6½, so 2 · ½/6½ = 2/13.",
        hint="Cut/vol for each of the two, added; vol is the sum of all degrees, the bridge's weight included.",
        mistakes={
            "that is one of the two terms": lambda r: r / 2,
            "the bridge counts in the degree of its end, too: vol is 6½": lambda r: 1 / 6,
            "vol counts each inner edge at both of its ends: 6½, not 3 or 3½": lambda r: 2 * 0.5 / 3.5,
            "vol counts each inner edge at both of its ends, and the bridge once: 6½": lambda r: 2 * 0.5 / 3,
        },
    ),
    WordExercise(
        name="15.3",
        level=1,
        question="Distances between all pairs are known, but no coordinates. Which of the two can be used as it is, "
        '"k-means" or "k-medoids"?',
        choices=lambda: ["k-means", "k-medoids"],
        right=lambda: "k-medoids",
        why="a medoid is an item; a mean needs coordinates (spectral clustering makes some first).",
        hint="what is the mean of three items without coordinates?",
        mistakes={"of what would the mean be taken?": lambda r: "k-means"},
    ),
    NumberExercise(
        name="15.4",
        level=2,
        question="Items lie at 0, 1, 2, 9 and 10 on a line, the medoids at 0 and 1. By how much does the best single swap of PAM lower the cost?",
        right=best_swap,
        is_whole=True,
        why="the cost is 0 + 0 + 1 + 8 + 9 = 18; with medoids 1 and 9 (or 10) it is 1 + 0 + 1 + 0 + 1 = 3.",
        hint="cost before less cost after; try replacing 0.",
        mistakes={
            "that is the cost after the swap": lambda r: 3.0,
            "that is the cost before it": lambda r: 18.0,
            "a better one: keep the medoid at 1 rather than that at 0": lambda r: 14.0,
        },
    ),
    FunctionExercise(
        name="15.5",
        level=3,
        signature="normalized_laplacian(weights)",
        question="Write `normalized_laplacian(weights)`: I − D^(−½) W D^(−½) of a symmetric (n, n) matrix of weights.",
        right=normalized_laplacian,
        cases=_graphs,
        why="its eigenvalues lie between 0 and 2, and it is symmetric, unlike I − D⁻¹W.",
        hint="D holds the sums of the rows; divide entry (i, j) by √(dᵢ dⱼ).",
        mistakes={
            "that is D − W, not normalized": lambda W: np.diag(W.sum(axis=1)) - W,
            "that is the random walk's I − D⁻¹W: not symmetric": lambda W: (
                np.eye(len(W)) - W / W.sum(axis=1, keepdims=True)
            ),
            "divided by dᵢ dⱼ; the roots are missing": lambda W: (
                np.eye(len(W)) - W / np.outer(W.sum(axis=1), W.sum(axis=1))
            ),
            "I less that: the eigenvalues are turned around": lambda W: (
                np.eye(len(W)) - normalized_laplacian(W)
            ),
        },
    ),
    FunctionExercise(
        name="15.6",
        level=3,
        signature="ncut(weights, labels)",
        question="Write `ncut(weights, labels)`: Σ Cut(S)/vol(S) over the segments of a symmetric weight matrix; labels may be any integers.",
        right=ncut,
        cases=_partitions,
        why="weight that leaves each segment over the sum of the degrees inside it.",
        hint="for each label: weights from inside to outside, over the sum of the degrees inside.",
        mistakes={
            "that is the ratio cut: divided by the number of items, not by the volume": _ratio,
            "the volume is the sum of the *degrees*, edges that leave included": _inner,
            "half of it: each segment counts the edges that leave it": lambda W, labels: ncut(W, labels) / 2,
        },
    ),
    FunctionExercise(
        name="15.7",
        level=3,
        signature="swap_gain(D, medoids, m, c)",
        question="Write `swap_gain(D, medoids, m, c)`: by how much the cost (sum of distances to the nearest medoid) falls if medoid number m is "
        "replaced by item c. Negative if it rises.",
        right=swap_gain,
        cases=_swaps,
        why="cost before less cost after; PAM takes the largest.",
        hint="the nearest medoid of each item before, and after the swap.",
        mistakes={
            "the sign: a gain is positive where the cost falls": lambda D, medoids, m, c: (
                -swap_gain(D, medoids, m, c)
            ),
            "the new medoid is added, but the old one is still there": lambda D, medoids, m, c: (
                D[:, medoids].min(axis=1).sum() - D[:, [*medoids, c]].min(axis=1).sum()
            ),
            "that is the cost after the swap": lambda D, medoids, m, c: (
                D[:, medoids].min(axis=1).sum() - swap_gain(D, medoids, m, c)
            ),
        },
    ),
)
