"""Exercises of notebook 09: annotate a scan. Two are answered by a session, edited by mouse or by script."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from scenewidget.datasets import load_room
from scenewidget.editing import Session
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.segmentation import Segmentation
from scenewidget.exercises import reading
from scenewidget.exercises.judging import (
    NOT_YET,
    Exercise,
    FunctionExercise,
    ListExercise,
    NumberExercise,
    Verdict,
    WordExercise,
    read_in_time,
)

__all__ = ["EXERCISES", "SessionExercise"]

N_EDITS, N_UNDONE = 5, 3
THING, SEGMENT, SHARED = 4.0, 5.0, 3.0  # m²
ENOUGH, MOST_EDITS = 0.75, 3
BOOKS, SIDEBOARD = "books 1", "sideboard 1"
LEVELS = ["final", "base", "dihedral"]
STILL_ONE = (
    "the books still share their segment with the sideboard; right-click on a part of them, at the level base"
)
BEYOND_BOOKS = "that takes much of the sideboard with the books"
TOO_MANY = f"the books are apart, but with more than {MOST_EDITS} edits; one merge takes many faces"
UNNAMED = "some segments have no name yet: go through all of them"
ALL_ALIKE = "all segments have the same name: which thing does most of *this* segment's area belong to?"


@dataclass(frozen=True, kw_only=True)
class SessionExercise(Exercise):
    """Edits that bring something about; ``complains`` says what is missing, or nothing."""

    complains: Callable[[Session], str]

    def _judged(self, answer: Any) -> Verdict:
        read_in_time(reading.refuse_nothing, answer)
        if not issubclass(type(answer), Session):  # of its type, for an answer may say anything of itself
            raise reading.UnreadableError(
                "an edited session is asked for: yours = sw.Session(mesh, seg), then edits"
            )
        if not answer.edits:
            raise reading.UnansweredError
        mesh, _ = _room()
        if answer.mesh.n_faces != mesh.n_faces:
            raise reading.UnreadableError("a session on the room of this notebook is asked for")
        complaint = self.complains(answer)
        return Verdict(False, NOT_YET + complaint) if complaint else Verdict(True, f"right: {self.why}")


@cache
def _room() -> tuple[Mesh, Segmentation]:
    return load_room()


def undo_and_redo() -> list[int]:
    """Five less three, and one on top; the new edit forgets what was undone."""
    return [N_EDITS - N_UNDONE + 1, 0]


def overlap() -> float:
    """Shared area over the area of both together."""
    return SHARED / (THING + SEGMENT - SHARED)


def _beside(name: str, onto: str) -> Session:
    """A session in which one thing lies in the segment of another."""
    mesh, truth = _room()
    labels = truth.labels.copy()
    labels[labels == truth.names.index(name)] = truth.names.index(onto)
    return Session(mesh, Segmentation.from_labels(mesh, labels))


def _faces_of(name: str) -> IntArray:
    _, truth = _room()
    return np.flatnonzero(truth.labels == truth.names.index(name))


def books_apart() -> Session:
    """The books painted as a segment of their own, in one edit."""
    session = _beside(BOOKS, SIDEBOARD)
    session.paint(_faces_of(BOOKS))
    return session


def _left_together(_: Session) -> Session:
    session = _beside(BOOKS, SIDEBOARD)
    session.relabel(int(_faces_of(BOOKS)[0]), "books")
    return session


def _too_much(_: Session) -> Session:
    session = _beside(BOOKS, SIDEBOARD)
    sideboard = _faces_of(SIDEBOARD)
    session.paint(np.concatenate([_faces_of(BOOKS), sideboard[: len(sideboard) // 2]]))
    return session


def _bit_by_bit(_: Session) -> Session:
    session = _beside(BOOKS, SIDEBOARD)
    first, *rest = np.array_split(_faces_of(BOOKS), MOST_EDITS + 1)
    session.paint(first)
    for faces in rest:
        session.paint(faces, int(first[0]))
    return session


def _complaint_of_books(session: Session) -> str:
    mesh, truth = _room()
    labels, area = session.segmentation.labels, mesh.face_areas
    is_book = truth.labels == truth.names.index(BOOKS)
    is_labeled = is_book & (labels >= 0)
    if not is_labeled.any():
        return "the books have no segment at all"
    best = labels == np.bincount(labels[is_labeled], area[is_labeled]).argmax()
    iou = area[is_book & best].sum() / area[is_book | best].sum()
    if iou >= ENOUGH:
        return TOO_MANY if len(session.edits) > MOST_EDITS else ""
    on_sideboard = truth.labels == truth.names.index(SIDEBOARD)
    if area[best & on_sideboard].sum() > 0.8 * area[on_sideboard].sum():
        return STILL_ONE
    if area[best & is_book].sum() > 0.8 * area[is_book].sum():
        return BEYOND_BOOKS
    return f"an IoU of {iou:.2f}: their segment holds only a part of the books, or other things, too"


def all_named() -> Session:
    """Each segment named after the thing that most of its area belongs to."""
    mesh, truth = _room()
    session = _beside(BOOKS, SIDEBOARD)
    labels = session.segmentation.labels
    for segment in range(labels.max() + 1):
        inside = (labels == segment) & (truth.labels >= 0)
        thing = np.bincount(truth.labels[inside], mesh.face_areas[inside]).argmax()
        session.relabel(int(np.flatnonzero(inside)[0]), truth.names[int(thing)])
    return session


def _three_named(session: Session) -> Session:
    session.go_to(3)
    return session


def _named_alike(_: Session) -> Session:
    session = _beside(BOOKS, SIDEBOARD)
    labels = session.segmentation.labels
    for segment in range(labels.max() + 1):
        session.relabel(int(np.flatnonzero(labels == segment)[0]), "thing")
    return session


def _complaint_of_names(session: Session) -> str:
    mesh, truth = _room()
    found = session.segmentation
    is_known = (found.labels >= 0) & (truth.labels >= 0)
    inside = np.zeros((found.n_segments, len(truth.names)))
    np.add.at(inside, (found.labels[is_known], truth.labels[is_known]), mesh.face_areas[is_known])
    given = [name for name, row in zip(found.names, inside, strict=True) if row.any()]
    if not all(given):
        return UNNAMED
    if len(set(given)) == 1 < len(given):
        return ALL_ALIKE
    wanted = [truth.names[int(row.argmax())] for row in inside if row.any()]
    n_wrong = sum(one.casefold() != other.casefold() for one, other in zip(given, wanted, strict=True))
    return f"{n_wrong} of {len(given)} segments have another name" if n_wrong else ""


def merged(labels: IntArray, parts: IntArray, faces: IntArray, onto: int) -> IntArray:
    """All faces of the parts that ``faces`` lie in get the label of ``onto``."""
    return np.where(np.isin(parts, parts[faces]), labels[onto], labels)


def thing_iou(labels: IntArray, truth: IntArray, areas: FloatArray, thing: int) -> float:
    """Of the segment that covers most of the thing."""
    is_thing = truth == thing
    on_it = is_thing & (labels >= 0)
    best = labels == np.bincount(labels[on_it], areas[on_it]).argmax()
    return float(areas[is_thing & best].sum() / areas[is_thing | best].sum())


def _edits() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(0)
    parts = np.arange(40) // 4
    return {
        "eight faces": (
            np.array([0, 0, 0, 0, 1, 1, 2, 2]),
            np.array([0, 0, 1, 1, 2, 2, 3, 3]),
            np.array([2]),
            6,
        ),
        "forty faces": (rng.integers(0, 3, 10)[parts], parts, np.array([1, 17, 30]), 39),
    }


def _only_faces(labels: IntArray, parts: IntArray, faces: IntArray, onto: int) -> Any:
    found = labels.copy()
    found[faces] = labels[onto]
    return found


def _segments(labels: IntArray, parts: IntArray, faces: IntArray, onto: int) -> Any:
    return np.where(np.isin(labels, labels[faces]), labels[onto], labels)


def _other_way(labels: IntArray, parts: IntArray, faces: IntArray, onto: int) -> Any:
    return np.where(parts == parts[onto], labels[faces[0]], labels)


def _covered() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(2)
    return {
        "six faces": (
            np.array([0, 0, 1, 1, 1, -1]),
            np.array([0, 0, 0, 1, 1, 0]),
            np.array([1.0, 1, 3, 1, 2, 1]),
            0,
        ),
        "sixty faces": (rng.integers(-1, 3, 60), rng.integers(-1, 4, 60), rng.random(60) ** 3, 2),
    }


def _by_count(labels: IntArray, truth: IntArray, areas: FloatArray, thing: int) -> Any:
    return thing_iou(labels, truth, np.ones_like(areas), thing)


def _covered_share(labels: IntArray, truth: IntArray, areas: FloatArray, thing: int) -> Any:
    is_thing = truth == thing
    on_it = is_thing & (labels >= 0)
    return np.bincount(labels[on_it], areas[on_it]).max() / areas[is_thing].sum()


EXERCISES: tuple[Exercise, ...] = (
    ListExercise(
        name="09.1",
        level=2,
        question="You make five edits, undo three, and make one more. How many edits can you undo now, and how many can you redo? Give both.",
        right=undo_and_redo,
        why="two were left and one came on top; an edit forgets what was undone before it.",
        hint="a new edit after undoing begins another history.",
        mistakes={
            "an edit forgets what was undone before it": lambda r: [r[0], N_UNDONE],
            "the new edit can be undone, too": lambda r: [N_EDITS - N_UNDONE, 0],
            "what was undone no longer counts": lambda r: [N_EDITS + 1, 0],
        },
    ),
    WordExercise(
        name="09.2",
        level=1,
        question='A carpet lies flat on the floor, in one segment with it. At which level does a right-click take a part of the carpet alone, "final", "base" or "dihedral"?',
        choices=lambda: LEVELS,
        right=lambda: "base",
        why="some runs of the ensemble parted it from the floor; no angle does.",
        hint="look at the table of levels: which has small parts where everything is flat?",
        mistakes={
            "at that level floor and carpet are one part": lambda r: "final",
            "no angle parts a carpet from its floor: they share one huge patch": lambda r: "dihedral",
        },
    ),
    NumberExercise(
        name="09.3",
        level=1,
        question="A chair has 4 m², the segment that covers most of it 5 m², and they share 3 m². What is the IoU of the chair?",
        right=overlap,
        why="3 m² of the 6 m² that either covers.",
        hint="what both share, over what either of them covers.",
        mistakes={
            "the shared part was counted twice in what either covers": lambda r: SHARED / (THING + SEGMENT),
            "that is the share of the chair that is covered; the rest of the segment counts, too": lambda r: (
                SHARED / THING
            ),
            "that is the share of the segment that is chair; the rest of the chair counts, too": lambda r: (
                SHARED / SEGMENT
            ),
        },
    ),
    SessionExercise(
        name="09.4",
        level=2,
        question='On the sideboard lie books, and the automatic segmentation took them for a part of it. In a session of your own, bring the IoU of "books 1" to 0.75 or more, with at most three edits.',
        right=books_apart,
        complains=_complaint_of_books,
        why="a merge takes many faces at once; and a single cut between books and sideboard does it, too.",
        hint='see how far `iou(yours, "books 1")` is.',
        mistakes={STILL_ONE: _left_together, BEYOND_BOOKS: _too_much, TOO_MANY: _bit_by_bit},
    ),
    SessionExercise(
        name="09.5",
        level=3,
        question="Name *all* segments of a session by a loop: each after the thing of the truth that most of its area belongs to.",
        right=all_named,
        complains=_complaint_of_names,
        why="`areas_by_thing` has a row for each segment, and any of its triangles names it.",
        hint="the largest entry of a segment's row in `areas_by_thing`.",
        mistakes={UNNAMED: _three_named, ALL_ALIKE: _named_alike},
    ),
    FunctionExercise(
        name="09.6",
        level=3,
        signature="merged(labels, parts, faces, onto)",
        question="Write `merged(labels, parts, faces, onto)`: the labels after a merge at some level. `labels` has the segment and `parts` the part of each face; every part in which one of `faces` lies goes to the segment of the face `onto`.",
        right=merged,
        cases=_edits,
        why="an edit names faces, the level makes parts of them, and only these move.",
        hint="which parts hold the faces, and which faces lie in these parts?",
        mistakes={
            "only the faces themselves were moved; a merge takes the whole *part* that each of them lies in": _only_faces,
            "whole segments were moved; at a level below, only *parts* of them go": _segments,
            "the other way around: the parts go to the segment of `onto`": _other_way,
        },
    ),
    FunctionExercise(
        name="09.7",
        level=3,
        signature="thing_iou(labels, truth, areas, thing)",
        question="Write `thing_iou(labels, truth, areas, thing)`: the IoU, by area, of a thing of the truth and the segment that covers most of it. −1 means unlabeled in both.",
        right=thing_iou,
        cases=_covered,
        why="an unlabeled part of the thing counts as not covered.",
        hint="first the segment that covers most of the thing's area, then shared area over the area of either.",
        mistakes={
            "that counts faces; weigh them by their area": _by_count,
            "that is the share of the thing that is covered; what the segment covers beside it counts, too": _covered_share,
        },
    ),
)
