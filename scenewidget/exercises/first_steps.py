"""Exercises of notebook 01: segment a room."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise, WordExercise
from scenewidget.metrics import rand_index_error

__all__ = ["EXERCISES"]

TRUTH, FOUND = np.array([0, 0, 1, 1]), np.array([0, 0, 0, 1])


def wrong_pairs() -> float:
    """Of six pairs (0, 2) and (1, 2) are wrongly joined, (2, 3) is wrongly apart."""
    return rand_index_error(FOUND, TRUTH)


def segment_areas(labels: IntArray, areas: FloatArray) -> FloatArray:
    """Area of each segment 0, 1, …; −1 is none."""
    is_labeled = labels >= 0
    return np.bincount(labels[is_labeled], areas[is_labeled]).astype(np.float64)


def _labeled() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(0)
    return {
        "five triangles": (np.array([0, 1, 0, -1, 1]), np.array([1.0, 2, 3, 10, 4])),
        "forty triangles": (rng.permutation(np.arange(40) % 5 - 1), rng.random(40)),
    }


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="01.1",
        level=1,
        question="Which label has a triangle that no segment takes?",
        right=lambda: -1.0,
        is_whole=True,
        why="segments count from 0, the largest first; −1 is unlabeled.",
        hint="segments are 0, 1, 2 …",
        mistakes={"0 is the largest segment": lambda r: 0.0},
    ),
    NumberExercise(
        name="01.2",
        level=1,
        question="What is the *flatness* of a perfectly plane segment, as the table of notebook 01 counts it?",
        right=lambda: 0.0,
        why="the smallest eigenvalue is the scatter across the plane, and there is none.",
        hint="it is the smallest over the largest eigenvalue of the scatter. How much do points of a plane scatter across it?",
        mistakes={"1 would be a ball: as much scatter in all directions": lambda r: 1.0},
    ),
    NumberExercise(
        name="01.3",
        level=2,
        question="Four triangles: in truth the first two are the floor, the others a box. A segmentation joins the first three, and the last is alone. "
        "What is 1 − Rand index?",
        right=wrong_pairs,
        why="of six pairs three are wrong: the third with each of the first two, and with the fourth.",
        hint="there are six pairs of triangles. Which are wrongly joined, which wrongly apart?",
        mistakes={
            "one of four *triangles* is on the wrong side; pairs are counted": lambda r: 0.25,
            "those are the wrongly joined ones; one pair is wrongly apart, too": lambda r: 2 / 6,
            "that is the wrongly parted pair; two are wrongly joined": lambda r: 1 / 6,
        },
    ),
    WordExercise(
        name="01.4",
        level=2,
        question='With the cost exponent at 0, what decides how far two places are apart, "creases" or "distance"?',
        choices=lambda: ["creases", "distance"],
        right=lambda: "distance",
        why="(1 − cos θ) to the power 0 is 1, whatever the crease.",
        hint="what is any number to the power 0?",
        mistakes={
            "a number to the power 0 is 1: every crease costs the same, and so does none": lambda r: "creases"
        },
    ),
    FunctionExercise(
        name="01.5",
        level=3,
        signature="segment_areas(labels, areas)",
        question="Write `segment_areas(labels, areas)`: the area of each segment 0, 1, 2 …, from a label and an area for each triangle; −1 belongs to no segment.",
        right=segment_areas,
        cases=_labeled,
        why="np.bincount with weights, once −1 is left out.",
        hint="a sum of areas for each label.",
        mistakes={
            "triangles were counted, not their areas summed": lambda labels, areas: segment_areas(
                labels, np.ones_like(areas)
            ),
            "the unlabeled triangles (−1) went to the *last* segment, as index −1 does in numpy": (
                lambda labels, areas: (
                    segment_areas(labels, areas)
                    + areas[labels < 0].sum() * (np.arange(labels.max() + 1) == labels.max())
                )
            ),
            "that is the mean area of a triangle; the sum is asked for": lambda labels, areas: (
                segment_areas(labels, areas) / segment_areas(labels, np.ones_like(areas))
            ),
        },
    ),
)
