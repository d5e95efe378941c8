"""Exercises of notebook 07: k-medoids, and why an ensemble."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from scipy.special import comb
from scipy.stats import binom

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.exercises import reading
from scenewidget.exercises.judging import Exercise, FunctionExercise, ListExercise, NumberExercise

__all__ = ["EXERCISES"]

PLACES = np.array([0, 1, 2, 10, 11, 12, 20, 21, 22])
ON_LINE = np.abs(PLACES[:, None] - PLACES).astype(float)
K, MEMBERS, WRONG = 3, 25, 0.3


def _cost_from(start: Any) -> float:
    """Where the algorithm ends, step by step; nine points need no compiled loop."""
    medoids = list(start)
    cost = ON_LINE[:, medoids].min(axis=1).sum()
    while (better := ON_LINE[:, medoids := step(ON_LINE, medoids)].min(axis=1).sum()) < cost:
        cost = better
    return float(cost)


def worst_start() -> list[int]:
    """All starts tried."""
    return list(max(combinations(range(len(PLACES)), K), key=_cost_from))


def _complaint_about_start(given: list[float]) -> str:
    if len(given) != K:
        return f"{K} points are asked for, you gave {len(given)}"
    if any(value != round(value) for value in given):
        return "points are whole numbers"
    start = [int(value) for value in given]
    if max(start) >= len(PLACES) and set(start) <= set(PLACES.tolist()):  # where they lie, not which they are
        start = [PLACES.tolist().index(value) for value in start]
    if min(start) < 0 or max(start) >= len(PLACES):
        return f"points have the numbers 0 to {len(PLACES) - 1}"
    if len(set(start)) < K:
        return "three different points, please"
    cost = _cost_from(start)
    if cost == _cost_from(worst_start()):
        return ""
    best = min(map(_cost_from, combinations(range(len(PLACES)), K)))
    if cost == best:
        return f"from there it ends in the *best* result, cost {cost:.0f}. Put two of them into one group"
    return f"that costs {cost:.0f}; it gets worse. What if one medoid has to serve two whole groups?"


def wrong_majority() -> float:
    """Binomial: 13 or more of 25."""
    return float(binom.sf(MEMBERS // 2, MEMBERS, WRONG))


def number_of_starts() -> float:
    """Three of nine, whatever their order."""
    return float(comb(len(PLACES), K))


def park_jun_start() -> list[int]:
    """The k smallest v_j = Σ_i d_ij / Σ_l d_il (Park and Jun 2009, step 1)."""
    v = (ON_LINE / ON_LINE.sum(axis=1, keepdims=True)).sum(axis=0)
    return sorted(np.argsort(v, kind="stable")[:K].tolist())


def update(D: FloatArray, labels: IntArray, k: int) -> list[int]:
    """In each cluster the member with the least sum of distances to the others."""
    medoids = []
    for c in range(k):
        members = np.flatnonzero(np.asarray(labels) == c)
        sums = [sum(D[i, j] for j in members) for i in members]
        medoids.append(int(members[int(np.argmin(sums))]))
    return medoids


def assign(D: FloatArray, medoids: Any) -> IntArray:
    """Position of the nearest medoid, of equal ones the first."""
    return np.asarray(D[:, medoids].argmin(axis=1))


def step(D: FloatArray, medoids: Any) -> list[int]:
    """Assign, then update."""
    return update(D, assign(D, medoids), len(medoids))


def _plane(seed: int, n: int) -> FloatArray:
    places = np.random.default_rng(seed).integers(0, 30, (n, 2)).astype(float)
    return np.asarray(np.linalg.norm(places[:, None] - places, axis=2))


def _clusters() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(1)
    labels = np.concatenate([np.arange(4), rng.integers(0, 4, 26)])
    return {
        "the points on the line": (ON_LINE, np.repeat([0, 1, 2], 3), 3),
        "two members that are equally good": (ON_LINE, np.array([0, 0, 1, 1, 1, 1, 2, 2, 2]), 3),
        "one cluster": (ON_LINE, np.zeros(9, dtype=int), 1),
        "thirty points in the plane": (_plane(0, 30), labels, 4),
    }


def _starts() -> dict[str, tuple[Any, ...]]:
    return {
        "the points on the line": (ON_LINE, np.array([8, 0, 4])),
        "a bad start on the line": (ON_LINE, np.array([1, 7, 8])),
        "thirty points in the plane": (_plane(2, 30), np.array([3, 17, 9, 28])),
    }


def _outermost(D: FloatArray, labels: IntArray, k: int) -> list[int]:
    return [
        int(m[D[np.ix_(m, m)].sum(axis=1).argmax()]) for m in (np.flatnonzero(labels == c) for c in range(k))
    ]


def _within(D: FloatArray, labels: IntArray, k: int) -> list[int]:
    return [
        int(D[np.ix_(m, m)].sum(axis=1).argmin()) for m in (np.flatnonzero(labels == c) for c in range(k))
    ]


def _of_all(D: FloatArray, labels: IntArray, k: int) -> list[int]:
    return [int(m[D[m].sum(axis=1).argmin()]) for m in (np.flatnonzero(labels == c) for c in range(k))]


def _last(D: FloatArray, labels: IntArray, k: int) -> list[int]:
    return [
        int(m[::-1][D[np.ix_(m, m)].sum(axis=1)[::-1].argmin()])
        for m in (np.flatnonzero(labels == c) for c in range(k))
    ]


EXERCISES: tuple[Exercise, ...] = (
    ListExercise(
        name="07.1",
        level=1,
        question="Find three points on the line (numbers 0 to 8) to start from such that the algorithm ends in the **worst** of all "
        "results.",
        right=worst_start,
        reads=reading.numbers,
        accepts=_complaint_about_start,
        why="two medoids share a group, and the third has to serve two: no single step leads out of it.",
        hint="try them all.",
    ),
    FunctionExercise(
        name="07.2",
        level=3,
        signature="update(D, labels, k)",
        question="Write step 2 of the algorithm yourself, `update(D, labels, k)`: given distances, labels and the number of clusters, "
        "the medoid of each cluster. Of equally good members take the first.",
        right=update,
        cases=_clusters,
        why="the member with the least sum of distances to its own cluster.",
        hint="for each cluster: its members, their distances to each other, the row with the least sum.",
        mistakes={
            "those are numbers *within* the cluster; which items are they?": _within,
            "those are the outermost members: the least sum, not the largest": _outermost,
            "the sum runs over the members of the cluster only, not over all items": _of_all,
            "of equally good members the first, you took the last": _last,
        },
    ),
    NumberExercise(
        name="07.3",
        level=2,
        question="Suppose 25 members, each wrong about a given pair with probability 0.3, independently. How probable is it that the "
        "majority (13 or more) is wrong about it? Two digits will do. And why is it not that good in our room?",
        right=wrong_majority,
        why="it would be that good if they were wrong independently; ours are wrong about the same pairs, for they see the "
        "same distances.",
        hint="sum a binomial distribution from 13 to 25.",
        mistakes={
            "that is the probability that the majority is right": lambda r: 1 - r,
            "13 itself counts: 13 or more": lambda r: binom.sf(13, MEMBERS, WRONG),
            "13 of 25 is the majority; you began at 12": lambda r: binom.sf(11, MEMBERS, WRONG),
            "that is exactly 13 wrong; more can be": lambda r: binom.pmf(13, MEMBERS, WRONG),
        },
    ),
    NumberExercise(
        name="07.4",
        level=1,
        is_whole=True,
        question="How many different starts has k-medoids with k = 3 on nine points?",
        right=number_of_starts,
        why="few enough to try all; on 1500 items with k = 30 it is a number of 60 digits.",
        hint="three of nine, without order.",
        mistakes={
            "the order of the three doesn't matter": lambda r: 6 * r,
            "the three must be different, and their order doesn't matter": lambda r: len(PLACES) ** K,
        },
    ),
    ListExercise(
        name="07.5",
        level=2,
        in_order=False,
        question="Park and Jun's own start takes the k items with the smallest $v_j = \\sum_i d_{ij} / \\sum_l d_{il}$. Which three points "
        "(numbers 0 to 8) are these on the line, k = 3? Is it a good start?",
        right=park_jun_start,
        why="the middle group, all three: they are central, and next to each other. It is a poor start here.",
        hint="divide each row of the distances by its sum, then add up the columns.",
        mistakes={
            "those are where they lie; give their numbers, 0 to 8": lambda r: PLACES[r].tolist(),
            "those have the *largest* v": lambda r: np.argsort(
                (ON_LINE / ON_LINE.sum(axis=1, keepdims=True)).sum(axis=0)
            )[-K:].tolist(),
            "one in each group would be a good start, but it is not theirs: compute v": lambda r: [1, 4, 7],
        },
    ),
    FunctionExercise(
        name="07.6",
        level=3,
        signature="step(D, medoids)",
        question="Write one whole step of Park and Jun, `step(D, medoids)`: every item goes to its nearest medoid (of equal ones the "
        "first), then every cluster takes its most central member. Give the new medoids, in the order of the old ones.",
        right=step,
        cases=_starts,
        why="repeat it until the cost no longer falls, and it is the algorithm.",
        hint="D[:, medoids].argmin(axis=1) are the labels; then the update of before.",
        mistakes={
            "the order got lost: new medoid 0 belongs to the cluster of old medoid 0": lambda D, m: sorted(
                step(D, m)
            ),
            "those are the old medoids": lambda D, m: list(m),
            "those are the labels after the first half of the step": lambda D, m: assign(D, m)[: len(m)],
        },
    ),
)
