"""Exercises of notebook 11: a dataset, by several hands."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.engine.mesh import IntArray
from scenewidget.exercises.judging import (
    Exercise,
    FunctionExercise,
    NumberExercise,
    WordExercise,
)
from scenewidget.metrics import rand_index_error

__all__ = ["EXERCISES"]

ANN, BOB = np.array([0, 0, 1, 1, 1]), np.array([0, 0, 0, 1, 1])
N_SCANS, N_DAMAGED, N_DONE = 300, 5, 120
SECONDS, N_WORKERS, EFFICIENCY = 40.0, 8, 0.8
MEASURES = ["agreement", "consensus", "gold"]


def disagreement() -> float:
    """The third face is apart from two that Bob holds together with it, and together with two others."""
    return rand_index_error(ANN, BOB)


def minutes() -> float:
    """All seconds over what the workers do at once."""
    return N_SCANS * SECONDS / (N_WORKERS * EFFICIENCY) / 60


def finest(labelings: IntArray) -> IntArray:
    """Faces with the same labels by everybody share a part."""
    return np.unique(labelings, axis=1, return_inverse=True)[1].reshape(-1)


def majority(labelings: IntArray) -> IntArray:
    """For each pair of faces whether at least half of those who labeled both hold them together."""
    together, voted = _votes(labelings)
    return ((voted > 0) & (2 * together >= voted)).astype(np.int64)


def _votes(labelings: IntArray) -> tuple[IntArray, IntArray]:
    known = labelings >= 0
    both = known[:, :, None] & known[:, None]
    alike = labelings[:, :, None] == labelings[:, None]
    return (both & alike).sum(axis=0), both.sum(axis=0)


def _people() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(0)
    return {
        "two people, five faces": (np.array([ANN, BOB]),),
        "three people, twenty faces": (rng.integers(0, 3, (3, 20)),),
    }


def _voters() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(1)
    return {
        "three people, one of whom left a face out": (np.array([[0, 0, 1, 1], [0, 0, 0, 1], [-1, 2, 2, 2]]),),
        "two people": (np.array([ANN, BOB]),),
        "five people, fifteen faces": (rng.integers(-1, 3, (5, 15)),),
    }


def _groups(parts: tuple[Any, ...]) -> Any:
    """Parts numbered by their first face, so that names do not matter."""
    (numbers,) = parts
    _, first, inverse = np.unique(numbers, return_index=True, return_inverse=True)
    return first[inverse].astype(np.float64)


def _joined_by_anyone(labelings: IntArray) -> Any:
    together = (labelings[:, :, None] == labelings[:, None]).any(axis=0)
    for _ in range(len(together)):
        together = together @ together
    return together.argmax(axis=1)


def _first_alone(labelings: IntArray) -> Any:
    return labelings[0]


def _unlabeled_votes(labelings: IntArray) -> Any:
    """−1 taken for a label like any other."""
    alike = (labelings[:, :, None] == labelings[:, None]).sum(axis=0)
    return 2 * alike >= len(labelings)


def _more_than_half(labelings: IntArray) -> Any:
    together, voted = _votes(labelings)
    return 2 * together > voted


def _of_everybody(labelings: IntArray) -> Any:
    together, _ = _votes(labelings)
    return 2 * together >= len(labelings)


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="11.1",
        level=1,
        question="Five of 300 scans are damaged. After 120 scans the power fails, and you run the same call again. How many rows has the table in the end?",
        right=lambda: float(N_SCANS),
        is_whole=True,
        why="a row for each scan, reused, done or failed.",
        hint="which scans have a row, and which of them twice?",
        mistakes={
            "a damaged scan has a row, too: it says what is wrong with it": lambda r: float(
                N_SCANS - N_DAMAGED
            ),
            "what was done before has its row, too: reused": lambda r: float(N_SCANS - N_DONE),
            "no scan has two rows": lambda r: float(N_SCANS + N_DONE),
        },
    ),
    NumberExercise(
        name="11.2",
        level=2,
        question="300 scans take 40 s each. How many minutes do eight workers need that are busy 80 % of the time?",
        right=minutes,
        why="12 000 s, shared by 6.4 workers.",
        hint="all seconds, over the workers that are busy at any moment.",
        mistakes={
            "that supposes workers that never wait": lambda r: r * EFFICIENCY,
            "waiting makes it longer, not shorter": lambda r: r * EFFICIENCY**2,
            "that is in seconds": lambda r: 60 * r,
            "that is what one worker would need": lambda r: r * N_WORKERS,
        },
    ),
    NumberExercise(
        name="11.3",
        level=2,
        question="Ann labels five faces 0, 0, 1, 1, 1, and Bob 0, 0, 0, 1, 1. What is 1 − Rand index between them?",
        right=disagreement,
        why="of ten pairs four differ: those of the third face with each other one.",
        hint="there are ten pairs of faces. Which does one join and the other part?",
        mistakes={
            "one *face* of five differs; pairs are counted": lambda r: 0.2,
            "that is the Rand index itself": lambda r: 1 - r,
            "that is the number of pairs; over how many?": lambda r: 10 * r,
            "a pair is counted once, and no face makes a pair with itself": lambda r: 8 / 25,
        },
    ),
    WordExercise(
        name="11.4",
        level=2,
        question='Two people make the same mistake on every chair. What can show it, "agreement", "consensus" or "gold"?',
        choices=lambda: MEASURES,
        right=lambda: "gold",
        why="on a gold scan the truth is known; without it two who err alike are of one mind.",
        hint="which of them knows something that the two don't?",
        mistakes={
            "they agree perfectly, and are wrong": lambda r: "agreement",
            "a consensus of two who err alike errs with them": lambda r: "consensus",
        },
    ),
    FunctionExercise(
        name="11.5",
        level=3,
        signature="finest(labelings)",
        question="Write `finest(labelings)`: the parts that nobody cuts, a number a face. `labelings` is (people, faces); two faces share a part if *everybody* gives both one label. How you number the parts is up to you.",
        right=finest,
        cases=_people,
        settle=_groups,
        why="faces with equal columns; these parts are what a consensus joins.",
        hint="two faces share a part exactly if their columns are equal.",
        mistakes={
            "faces are joined there that somebody parts: all must agree": _joined_by_anyone,
            "that is one person's segmentation; the others cut it, too": _first_alone,
        },
    ),
    FunctionExercise(
        name="11.6",
        level=3,
        signature="majority(labelings)",
        question="Write `majority(labelings)`: an (n, n) array of 0 and 1, whether at least half of those who labeled *both* faces hold them together. `labelings` is (people, n), −1 where somebody says nothing; 0 where nobody labeled both.",
        right=majority,
        cases=_voters,
        why="who leaves a face out has no vote on it.",
        hint="for each pair count who labeled both, and how many of these gave both one label.",
        mistakes={
            "−1 is no label: who leaves two faces out doesn't say that they belong together": _unlabeled_votes,
            "*at least* half: with two people one is enough": _more_than_half,
            "half of those who labeled both, not half of everybody": _of_everybody,
        },
    ),
)
