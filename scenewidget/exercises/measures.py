"""Exercises of notebook 10: is it any good?"""

from __future__ import annotations

from typing import Any

import numpy as np

from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise, WordExercise
from scenewidget.metrics import local_consistency_error, mean_iou

__all__ = ["EXERCISES"]

SHARES = (0.5, 0.3, 0.2)
OVERLAP, ONE, OTHER = 3.0, 5.0, 6.0


def error_of_one_segment(p: FloatArray) -> float:
    """All pairs across two things are wrongly joined: 1 − Σ p²."""
    return float(1 - (np.asarray(p) ** 2).sum())


def error_of_dust() -> float:
    """All pairs within a thing are wrongly apart: Σ p²."""
    return float(sum(p**2 for p in SHARES))


def iou() -> float:
    """Shared area over the area of both together."""
    return OVERLAP / (ONE + OTHER - OVERLAP)


def rand_index_error(a: IntArray, b: IntArray) -> float:
    """Share of the pairs i < j that one joins and the other parts."""
    n, wrong = len(a), 0
    for i in range(n):
        for j in range(i + 1, n):
            wrong += (a[i] == a[j]) != (b[i] == b[j])
    return wrong / (n * (n - 1) / 2)


def intersection_over_union(a: BoolArray, b: BoolArray, areas: FloatArray) -> float:
    """Area in both over area in either."""
    return float(areas[a & b].sum() / areas[a | b].sum())


def _labelings() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(0)
    return {
        "five things": (np.array([0, 0, 1, 1, 1]), np.array([0, 0, 0, 1, 1])),
        "other numbers, the same partition": (np.array([0, 0, 1, 2]), np.array([7, 7, 3, 5])),
        "twenty things": (rng.integers(0, 3, 20), rng.integers(0, 5, 20)),
    }


def _all_pairs(a: IntArray, b: IntArray) -> Any:
    """Pairs i, i counted, too."""
    return float(((a[:, None] == a) != (b[:, None] == b)).mean())


def _masks() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(1)
    areas = rng.random(30) ** 2
    return {
        "four faces": (
            np.array([True, True, False, False]),
            np.array([True, False, True, False]),
            np.array([2.0, 1, 1, 5]),
        ),
        "thirty faces": (rng.random(30) < 0.5, rng.random(30) < 0.6, areas),
    }


def cheat(truth: IntArray) -> IntArray:
    """The largest thing in ten pieces, and all others in one."""
    largest = np.bincount(truth).argmax()
    return np.where(truth == largest, 1 + np.arange(len(truth)) % 10, 0)


def _rooms() -> dict[str, tuple[Any, ...]]:
    """Things as unequal as those of a room, in three rooms of different size."""
    rng = np.random.default_rng(2)
    shares = 1 / np.arange(1, 31)
    return {
        f"a room of {n} triangles": (rng.permutation(np.append(np.arange(30), rng.choice(30, n - 30, p=shares / shares.sum()))),)
        for n in (700, 1_000, 1_300)
    }  # fmt: skip


def _is_cheating(parts: tuple[FloatArray, ...]) -> tuple[FloatArray, ...]:
    """Which of the three things that are asked for these labels have: low LCE, low IoU, a few segments."""
    (labels,) = parts
    (truth,) = next(given for given in _rooms().values() if len(given[0]) == len(labels))
    segments, numbered = np.unique(labels, return_inverse=True)
    found = numbered.ravel()
    is_fine = local_consistency_error(found, truth) < 0.001
    is_bad = mean_iou(found, truth) < 0.1
    return tuple(np.array(float(met)) for met in (is_fine, is_bad, 5 <= len(segments) <= 50))


EXERCISES: tuple[Exercise, ...] = (
    FunctionExercise(
        name="10.1",
        level=2,
        signature="error_of_one_segment(p)",
        question="If everything is one segment and the truth's segments have shares $p_1, p_2, \\dots$ of the (very many) triangles, what is 1 − RI? "
        "Write it: a function of the array p.",
        right=error_of_one_segment,
        cases=lambda: {
            "three things": (np.array(SHARES),),
            "a hundred equal ones": (np.full(100, 0.01),),
            "one thing": (np.ones(1),),
        },
        why="two triangles of one thing, Σ p² of the pairs, are rightly joined; all others wrongly.",
        hint="which pairs are wrongly joined, and which share of all pairs are they?",
        mistakes={
            "those are the pairs that are *rightly* joined": lambda p: (p**2).sum(),
            "each pair of different things was counted once, i < j; two triangles come in either order": lambda p: (
                (1 - (p**2).sum()) / 2
            ),
            "that is the share of triangles outside of the largest thing; pairs are counted": lambda p: (
                1 - p.max()
            ),
        },
    ),
    NumberExercise(
        name="10.2",
        level=1,
        question="And if each of the very many triangles is a segment of its own, with a truth of three things with shares 0.5, 0.3 and 0.2: what is 1 − RI?",
        right=error_of_dust,
        why="now all pairs within a thing are wrongly apart: 0.25 + 0.09 + 0.04.",
        hint="which pairs are wrongly apart now?",
        mistakes={"that is everything in one segment": lambda r: 1 - r, "nothing is joined": lambda r: 1.0},
    ),
    WordExercise(
        name="10.3",
        level=1,
        question='Which of these is 0 for the dust of 10.2, "RI" (1 − Rand index), "LCE" or "IoU" (1 − mean IoU)?',
        choices=lambda: ["RI", "LCE", "IoU"],
        right=lambda: "LCE",
        why="it forgives a segmentation that is finer than the truth, however fine.",
        hint="which measure forgives one segmentation for being finer?",
        mistakes={
            "10.2 has just shown that it isn't": lambda r: "RI",
            "the IoU of a thing with a single triangle is nearly 0, so the error is nearly 1": lambda r: (
                "IoU"
            ),
        },
    ),
    NumberExercise(
        name="10.4",
        level=1,
        question="A segment of 5 m² and a chair of 6 m² share 3 m². What is their IoU?",
        right=iou,
        why="3 over 5 + 6 − 3.",
        hint="what both share, over what they cover together.",
        mistakes={
            "what they share was counted twice below": lambda r: 3 / 11,
            "that is the share of the chair": lambda r: 3 / 6,
            "that is the share of the segment": lambda r: 3 / 5,
        },
    ),
    WordExercise(
        name="10.5",
        level=2,
        question="Two methods differ by 0.004 in 1 − RI on one room, with one seed each. Ten seeds of either lie up to 0.01 apart. Does this show that one is better? "
        '"yes" or "no".',
        choices=lambda: ["yes", "no"],
        right=lambda: "no",
        why="the difference is less than that of two seeds of one method: more seeds, and more rooms.",
        hint="how large is the difference between two seeds of the *same* method?",
        mistakes={"then one method would be better than itself": lambda r: "yes"},
    ),
    FunctionExercise(
        name="10.6",
        level=3,
        signature="rand_index_error(a, b)",
        question="Write `rand_index_error(a, b)`: the share of the pairs i < j of things which one array of labels joins and the other parts.",
        right=rand_index_error,
        cases=_labelings,
        why="over all n (n − 1)/2 pairs.",
        hint="for each pair i < j: is (a_i = a_j) the same as (b_i = b_j)?",
        mistakes={
            "that is the Rand index; the error is 1 less it": lambda a, b: 1 - rand_index_error(a, b),
            "pairs of a thing with itself are no pairs: divide by n (n − 1)/2": _all_pairs,
            "labels have no meaning of their own: 0 in one may be 7 in the other": lambda a, b: float(
                (a != b).mean()
            ),
        },
    ),
    FunctionExercise(
        name="10.7",
        level=3,
        signature="intersection_over_union(a, b, areas)",
        question="Write `intersection_over_union(a, b, areas)`: of two (n_faces,) masks, weighted by the areas of the faces.",
        right=intersection_over_union,
        cases=_masks,
        why="area in both over area in either.",
        hint="a & b above, a | b below, areas summed.",
        mistakes={
            "faces were counted; weigh by area": lambda a, b, areas: intersection_over_union(
                a, b, np.ones_like(areas)
            ),
            "below stands the area in either, once": lambda a, b, areas: (
                areas[a & b].sum() / (areas[a].sum() + areas[b].sum())
            ),
        },
    ),
    FunctionExercise(
        name="10.8",
        level=2,
        signature="cheat(truth)",
        question="Write `cheat(truth)`: from the array of the truth's labels another array of labels with an LCE below 0.001 and a mean IoU below 0.1 "
        "that has **between 5 and 50 segments**.",
        right=cheat,
        cases=_rooms,
        settle=_is_cheating,
        why="the largest thing in pieces, and the others in one: each triangle finds one side finer.",
        hint="LCE forgives what is finer here and coarser there, triangle by triangle; the mean IoU counts every thing once.",
        mistakes={
            "so few or so many segments anybody would notice: 5 to 50 are asked for": lambda truth: 0 * truth,
            "the LCE is low enough, the mean IoU is not: most things must lose their partner": (
                lambda truth: truth
            ),
            "the mean IoU is low enough, the LCE isn't: a segment must lie within one thing, or consist of whole things": (
                lambda truth: np.arange(len(truth)) % 30
            ),
            "neither is met: a segment that is part of one thing and part of another costs LCE": (
                lambda truth: np.where(np.arange(len(truth)) % 5 == 0, (truth + 1) % 30, truth)
            ),
        },
    ),
)
