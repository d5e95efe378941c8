"""Exercises of notebook 17: from a file to a project."""

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

N_EDITS, N_UNDONE = 7, 3
AREAS = (14.0, 6.0, 4.0, 1.0)


def factor() -> float:
    """98 inches are 2.49 m, a room's height."""
    return 0.0254


def undo_and_redo() -> list[int]:
    """An edit after undoing forgets what was undone."""
    return [N_EDITS - N_UNDONE + 1, 0]


def coverage() -> float:
    """Labeled area over all of it."""
    return sum(AREAS[:-1]) / sum(AREAS)


def upright(vertices: FloatArray) -> FloatArray:
    """(x, y, z) with y up becomes (x, −z, y): a quarter turn about the x axis."""
    x, y, z = vertices.T
    return np.column_stack([x, -z, y])


def names_by_area(labels: IntArray, truth: IntArray, areas: FloatArray) -> IntArray:
    """For each segment the thing with the largest area in it; −1 is left out on both sides."""
    found = []
    for segment in range(labels.max() + 1):
        inside = (labels == segment) & (truth >= 0)
        found.append(np.bincount(truth[inside], areas[inside]).argmax())
    return np.array(found)


def _places() -> dict[str, tuple[Any, ...]]:
    return {
        "three axes": (np.eye(3),),
        "ten points": (np.random.default_rng(0).normal(size=(10, 3)),),
    }


def _labeled() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(1)
    labels, truth = rng.integers(0, 4, 60), rng.integers(-1, 3, 60)
    return {
        "six faces": (
            np.array([0, 0, 0, 1, 1, -1]),
            np.array([2, 2, 0, 1, -1, 0]),
            np.array([1.0, 1, 3, 1, 9, 5]),
        ),
        "sixty faces": (labels, truth, rng.random(60) ** 3),
    }


def _by_count(labels: IntArray, truth: IntArray, areas: FloatArray) -> Any:
    return names_by_area(labels, truth, np.ones_like(areas))


def _with_unlabeled(labels: IntArray, truth: IntArray, areas: FloatArray) -> Any:
    """The unlabeled faces of the truth counted as a thing, as index −1 does in numpy."""
    n = truth.max() + 1
    found = []
    for segment in range(labels.max() + 1):
        inside = labels == segment
        weights = np.zeros(n)
        np.add.at(weights, truth[inside], areas[inside])
        found.append(weights.argmax())
    return np.array(found)


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="17.1",
        level=1,
        question="The bounding box of a scanned room is 205 × 98 × 157 in the numbers of its file, y up. By which factor must they be multiplied to be metres?",
        right=factor,
        is_exact=True,
        why="98 inches are 2.49 m, a usual height; 98 cm would be a room to crawl in.",
        hint="how high is a room? Try mm, cm, inches, feet.",
        mistakes={
            "in centimetres the room would be 98 cm high": lambda r: 0.01,
            "in millimetres the room would be 98 mm high": lambda r: 0.001,
            "in feet it would be 30 m high": lambda r: 0.3048,
            "upside down: from the file's numbers to metres": lambda r: 1 / r,
        },
    ),
    WordExercise(
        name="17.2",
        level=1,
        question='A scan lies on its side: what is up in the room is along −x in the file. What do you write after `w.view.up =`, "x", "-x", "z" or "-z"?',
        choices=lambda: ["x", "-x", "z", "-z"],
        right=lambda: "-x",
        why="`up` says where up is *in the file*.",
        hint="`up` is a direction of the file, that which points to the ceiling.",
        mistakes={"that points to the floor": lambda r: "x"},
    ),
    ListExercise(
        name="17.3",
        level=2,
        question="You make seven edits, undo three, and make one more. How many can be undone now, and how many redone? Give both.",
        right=undo_and_redo,
        why="four were left, and one came on top; a new edit forgets what had been undone.",
        hint="a new edit after undoing begins another history.",
        mistakes={
            "what was undone is forgotten with the new edit": lambda r: [r[0], N_UNDONE],
            "the new edit can be undone, too": lambda r: [N_EDITS - N_UNDONE, 0],
        },
    ),
    NumberExercise(
        name="17.4",
        level=2,
        question="Three segments have 14, 6 and 4 m², and 1 m² is unlabeled. What is the coverage?",
        right=coverage,
        why="24 of 25 m² have a label.",
        hint="labeled area over all area.",
        mistakes={
            "that is the share without a label": lambda r: 1 - r,
            "three of four parts: weigh by area": lambda r: 0.75,
            "over all of the area, unlabeled included": lambda r: 1.0,
        },
    ),
    FunctionExercise(
        name="17.5",
        level=3,
        signature="upright(vertices)",
        question="Write `upright(vertices)`: an (n, 3) array with y up, turned (not mirrored) so that z is up; x stays.",
        right=upright,
        cases=_places,
        why="(x, −z, y): a rotation, determinant +1.",
        hint="where does the y axis go? Then the z axis can only go to one place, if nothing is mirrored.",
        mistakes={
            "mirrored: swapping two axes makes a left-handed room, and turns every triangle inside out": lambda v: (
                v[:, [0, 2, 1]]
            ),
            "turned the other way: the ceiling is below": lambda v: upright(v) * [1, -1, -1],
        },
    ),
    FunctionExercise(
        name="17.6",
        level=3,
        signature="names_by_area(labels, truth, areas)",
        question="Write `names_by_area(labels, truth, areas)`: for each segment 0, 1, … the thing of the truth with the largest area in it. −1 means unlabeled in both, and doesn't count.",
        right=names_by_area,
        cases=_labeled,
        why="a weighted count for each segment, and its largest entry.",
        hint="for each segment: np.bincount of the truth's labels in it, weighted by area.",
        mistakes={
            "that counts faces; a large triangle should count for more": _by_count,
            "faces that the truth leaves unlabeled (−1) were counted: index −1 is the *last* thing": _with_unlabeled,
        },
    ),
)
