"""Exercises of notebook 08: consensus."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.exercises.judging import (
    Exercise,
    FunctionExercise,
    ListExercise,
    NumberExercise,
    WordExercise,
)

__all__ = ["EXERCISES"]

KEYS = np.array([[0, 0, 0, 0], [0, 0, 0, 0], [0, 1, 0, 0], [1, 1, 0, 1], [1, 1, 1, 1], [1, 1, 1, 1]])
TOGETHER, RUNS, OFFERED = 13, 30, 5


def entry() -> float:
    """Share of the runs in which the third and the fourth thing fall together."""
    return float(counts(KEYS)[2, 3])


def vote() -> str:
    """A pair votes for joining if c > ½."""
    return "join" if TOGETHER / RUNS > 0.5 else "part"


def blocks() -> list[float]:
    """A row for each block, with certainty, explains C without a rest."""
    Y = np.kron(np.eye(3), np.ones((1, 4)))
    C = Y.T @ Y
    return [float(np.linalg.matrix_rank(C)), float(((C - Y.T @ Y) ** 2).sum())]


def disagreement(labels: IntArray, C: FloatArray, a: FloatArray) -> float:
    """A joined pair costs 1 − c, a parted one c."""
    joins = np.equal.outer(labels, labels)
    return float(a @ np.where(joins, 1 - C, C) @ a)


def counts(keys: IntArray) -> FloatArray:
    """The share of the columns in which two rows are equal."""
    return np.asarray((keys[:, None] == keys[None]).mean(axis=2))


def gradient(Y: FloatArray, C: FloatArray, a: FloatArray) -> FloatArray:
    """∂f/∂y_j = −4 a_j Σ_i a_i (c_ij − y_i·y_j) y_i."""
    return np.asarray(-4 * (Y * a) @ (C - Y.T @ Y) * a)


def tied(keys: IntArray) -> list[int]:
    """Things with the same row are one base segment."""
    return np.unique(keys, axis=0, return_inverse=True)[1].ravel().tolist()


def _once(labels: IntArray, C: FloatArray, a: FloatArray) -> float:
    """Each pair once."""
    lost = np.where(np.equal.outer(labels, labels), 1 - C, C) * np.outer(a, a)
    return float(np.triu(lost, 1).sum())


def _partitions() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(8)
    keys = rng.integers(0, 3, (10, 7))
    return {
        "the six things": (np.array([0, 0, 1, 1, 1, 2]), counts(KEYS), np.arange(1.0, 7.0)),
        "ten random things": (rng.integers(0, 4, 10), counts(keys), rng.random(10)),
    }


def _runs() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(9)
    return {"the six things": (KEYS,), "random clusterings": (rng.integers(0, 4, (12, 9)),)}


def _soft() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(10)
    out: dict[str, tuple[Any, ...]] = {}
    for name, n, m in (("six things in two clusters", 6, 2), ("twelve things in four clusters", 12, 4)):
        C = counts(KEYS) if n == 6 else counts(rng.integers(0, 3, (n, 8)))
        out[name] = (rng.dirichlet(np.ones(m), size=n).T, C, rng.random(n) + 0.5)
    return out


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="08.1",
        level=1,
        question="Without computing: what is $c_{34}$ of the six things at the top (the third and the fourth)?",
        right=entry,
        why="they fall together in the second run and in the third.",
        hint="count the columns in which rows three and four are equal.",
        mistakes={
            "that is how many runs; which share of the four?": lambda r: r * KEYS.shape[1],
            "third and fourth, counted from 1": lambda r: float((KEYS[3] == KEYS[4]).mean()),
        },
    ),
    FunctionExercise(
        name="08.2",
        level=3,
        signature="total_disagreement(labels, C, a)",
        question="The total disagreement of a partition with all runs, weighted by $a_i a_j$, follows from $C$ alone. Write it: the mean over "
        "the runs of the sum over all pairs (i, j) of $a_i a_j$ where one joins and the other parts.",
        right=disagreement,
        cases=_partitions,
        also=(_once,),
        why="a joined pair costs 1 − c, a parted one c; so the best vote for each pair is c > ½.",
        hint="what does a joined pair cost, and what a parted one?",
        mistakes={
            "the other way around: a *joined* pair is wrong in the 1 − c of the runs that part it": (
                lambda labels, C, a: float(a @ np.where(np.equal.outer(labels, labels), C, 1 - C) @ a)
            ),
            "the weights a are missing": lambda labels, C, a: disagreement(labels, C, np.ones(len(a))),
            "that squares the difference, (c − [joined])²; the mean over the runs is linear in c": (
                lambda labels, C, a: float(a @ (C - np.equal.outer(labels, labels)) ** 2 @ a)
            ),
        },
    ),
    ListExercise(
        name="08.3",
        level=2,
        question="Three blocks of four segments each, within which all runs agree, and never across. How many rows of $Y$ does PEAC use if it "
        "is offered M = 5, and what is $f$ then? Give both numbers.",
        right=blocks,
        why="C = YᵀY can be had exactly, with a row for each block.",
        hint="C = YᵀY can be had exactly.",
        mistakes={
            "it is offered so many, but blocks want one each": lambda r: [OFFERED, r[1]],
            "one row a *block*, not a segment": lambda r: [12, r[1]],
        },
    ),
    FunctionExercise(
        name="08.4",
        level=3,
        signature="gradient(Y, C, a)",
        question="Write `gradient(Y, C, a)` of $f(Y) = \\sum_{ij} a_i a_j (c_{ij} - y_i \\cdot y_j)^2$, an array of the shape of Y, (M, n); the "
        "sum runs over all i and j, i = j too.",
        right=gradient,
        cases=_soft,
        why="2 from the square, and 2 because y_j stands on both sides of the product.",
        hint="each y_j is in row j and in column j of the sum.",
        mistakes={
            "half of it: y_j stands in row j *and* in column j": lambda Y, C, a: gradient(Y, C, a) / 2,
            "a quarter of it: the 2 of the square, and y_j is in row j *and* in column j": lambda Y, C, a: (
                gradient(Y, C, a) / 4
            ),
            "the sign: the gradient points uphill": lambda Y, C, a: -gradient(Y, C, a),
            "uphill, and half of it: y_j stands in row j *and* in column j": lambda Y, C, a: (
                -gradient(Y, C, a) / 2
            ),
            "the weights a are missing": lambda Y, C, a: gradient(Y, C, np.ones(len(a))),
            "a_j is missing: each term has a_i *and* a_j": lambda Y, C, a: gradient(Y, C, a) / a,
            "pairs (i, i) count, too": lambda Y, C, a: (
                -4 * (Y * a) @ (C - Y.T @ Y - np.diag(np.diagonal(C - Y.T @ Y))) * a
            ),
        },
    ),
    WordExercise(
        name="08.5",
        level=1,
        question='Two segments fell together in 13 of 30 runs. Does this pair vote to `"join"` or to `"part"` them in the median partition?',
        right=vote,
        choices=lambda: ["join", "part"],
        why="13/30 is less than ½.",
        hint="what is c, and which side of ½ is it on?",
    ),
    FunctionExercise(
        name="08.6",
        level=3,
        signature="counts(keys)",
        question="Write `counts(keys)`: from an (n, R) array of labels, a column a run, the (n, n) co-association matrix.",
        right=counts,
        cases=_runs,
        why="names of clusters never meet across columns, so runs of any kind go together.",
        hint="compare row i with row j, entry by entry.",
        mistakes={
            "those are counts; divide by the number of runs": lambda keys: counts(keys) * keys.shape[1],
            "that is 1 only where *all* runs agree": lambda keys: (keys[:, None] == keys[None]).all(axis=2),
            "that is the share of the runs that *part* them": lambda keys: 1 - counts(keys),
        },
    ),
    FunctionExercise(
        name="08.7",
        level=3,
        signature="base(keys)",
        question="Write `base(keys)`: for each thing the number of its base segment; things that *all* runs keep together share one. How you "
        "number them is up to you.",
        right=tied,
        cases=_runs,
        settle=lambda parts: (np.equal.outer(parts[0].ravel(), parts[0].ravel()).astype(float),),
        why="equal rows, equal numbers: np.unique over rows does it.",
        hint="two things are tied if their rows are equal in every column.",
        mistakes={
            "that looks at the first run only": lambda keys: keys[:, 0],
            "that looks at the last run only": lambda keys: keys[:, -1],
        },
    ),
)
