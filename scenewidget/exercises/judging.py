"""Kinds of exercises, and the sentence that an answer gets.

A right answer is never written down here: it is computed when it is asked for. What students often do instead is
computed beside it, so that the hint fits the mistake.
"""

from __future__ import annotations

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from scenewidget.exercises import reading
from scenewidget.exercises.guard import FailedError, TooSlowError, within

__all__ = [
    "Exercise",
    "FunctionExercise",
    "ListExercise",
    "NumberExercise",
    "Verdict",
    "WordExercise",
    "read_in_time",
]

PATIENCE = 0.8  # seconds for all that an answer does itself
NOT_YET = "not yet: "
Arrays = tuple[np.ndarray[Any, Any], ...]
Mistakes = dict[str, Callable[..., Any]]


class Verdict(NamedTuple):
    """Whether it is right, and the sentence."""

    is_right: bool
    text: str


@dataclass(frozen=True, kw_only=True)
class Exercise(ABC):
    """A question, and what is needed to judge answers to it.

    Parameters
    ----------
    name : str
        Notebook and number, "03.2".
    level : int
        1: read off or put in; 2: combine or think; 3: write the algorithm.
    question : str
    right : callable
        Without arguments: the right answer. Of a `FunctionExercise`: the function itself.
    why : str
        Why it is right; what a right answer is told.
    hint : str
        For a wrong answer that is none of the mistakes foreseen.
    mistakes : dict
        From a hint to the wrong answer that deserves it, computed from the right one.
    """

    name: str
    level: int
    question: str
    right: Callable[..., Any]
    why: str
    hint: str
    mistakes: Mistakes = field(default_factory=dict)

    def judged(self, answer: Any) -> Verdict:
        """What the answer is worth; never raises, whatever it is."""
        try:
            return self._judged(answer)
        except reading.UnansweredError:
            return Verdict(False, "not answered yet")
        except reading.UnreadableError as sentence:
            return Verdict(False, f"{NOT_YET}{sentence}")
        except TooSlowError:
            return Verdict(False, f"{NOT_YET}it was not done within a second. Does a loop never end?")
        except FailedError as failure:
            return Verdict(False, f"{NOT_YET}that can't be read; it raised {failure}")

    @abstractmethod
    def _judged(self, answer: Any) -> Verdict: ...


def read_in_time(reader: Callable[[Any], Any], answer: Any) -> Any:
    """What the reader makes of the answer, in time; its own sentences come through.

    Parameters
    ----------
    reader : callable (answer) -> Any
    answer : Any

    Raises
    ------
    TooSlowError, FailedError
        The answer, asked by the reader, took too long or raised.

    Examples
    --------
    >>> read_in_time(reading.number, "1/4")
    0.25
    """

    def guarded() -> tuple[Any, Exception | None]:
        try:
            return reader(answer), None
        except (reading.UnreadableError, reading.UnansweredError) as sentence:
            return None, sentence

    value, sentence = within(PATIENCE, guarded)
    if sentence is not None:
        raise sentence
    return value


def _is_rounded(given: float, right: float) -> bool:
    """Whether it is the right number, within half a percent or rounded to two digits or more."""
    if math.isclose(given, right, rel_tol=5e-3, abs_tol=1e-9):
        return True
    return any(given == float(f"{right:.{digits}g}") for digits in (2, 3, 4))


@dataclass(frozen=True, kw_only=True)
class NumberExercise(Exercise):
    """One number; ``is_whole`` and ``is_exact`` ones are not rounded."""

    is_whole: bool = False
    is_exact: bool = False

    def _judged(self, answer: Any) -> Verdict:
        given = read_in_time(reading.number, answer)
        right = float(self.right())
        if abs(given - right) < 1e-6 if self.is_whole or self.is_exact else _is_rounded(given, right):
            return Verdict(True, f"right: {self.why}")
        for hint, wrong in self.mistakes.items():
            if self._is_same(given, float(wrong(right))):
                return Verdict(False, NOT_YET + hint)
        if self.is_whole and given != round(given):
            return Verdict(False, f"{NOT_YET}a whole number is asked for")
        for hint, value in _common(right, self.is_whole).items():
            if self._is_same(given, value):
                return Verdict(False, NOT_YET + hint)
        return Verdict(False, NOT_YET + self.hint)

    def _is_same(self, given: float, right: float) -> bool:
        return abs(given - right) < 1e-6 if self.is_whole else _is_rounded(given, right)


def _common(right: float, is_whole: bool) -> dict[str, float]:
    """Slips that happen with any number, each with what it makes of the right one."""
    if right == 0:
        return {}
    if is_whole:
        return {"close, but one off: count the ends again": right + 1, "close, but one too few": right - 1}
    return {
        "the size is right, the sign is not": -right,
        "upside down: that is one over it": 1 / right,
        "that is in percent; a share is a hundredth of it": 100 * right,
        "a thousand times too much: which unit is asked for?": 1000 * right,
        "a thousandth of it: which unit is asked for?": right / 1000,
        "twice as much as it is": 2 * right,
        "half of what it is": right / 2,
        "that is its square": right**2,
        "that is its square root": math.sqrt(abs(right)),
    }


@dataclass(frozen=True, kw_only=True)
class WordExercise(Exercise):
    """One of a few words."""

    choices: Callable[[], list[str]]

    def _judged(self, answer: Any) -> Verdict:
        given = read_in_time(reading.word, answer)
        choices = self.choices()
        if given not in [choice.casefold() for choice in choices]:
            return Verdict(False, f"{NOT_YET}one of these is asked for: {', '.join(choices)}")
        right = self.right()
        if given == str(right).casefold():
            return Verdict(True, f"right: {self.why}")
        for hint, wrong in self.mistakes.items():
            if given == str(wrong(right)).casefold():
                return Verdict(False, NOT_YET + hint)
        return Verdict(False, NOT_YET + self.hint)


@dataclass(frozen=True, kw_only=True)
class ListExercise(Exercise):
    """Some numbers. ``accepts`` judges them where several lists are right; ``reads`` takes other forms."""

    accepts: Callable[[list[float]], str] | None = None
    reads: Callable[[Any], list[float]] = reading.numbers
    in_order: bool = True

    def _judged(self, answer: Any) -> Verdict:
        given = read_in_time(self.reads, answer)
        if self.accepts is not None:
            complaint = self.accepts(given)
            return Verdict(False, NOT_YET + complaint) if complaint else Verdict(True, f"right: {self.why}")
        right = self.right()
        if len(given) != len(right):
            return Verdict(False, f"{NOT_YET}{len(right)} numbers are asked for, you gave {len(given)}")
        if self._are_same(given, right):
            return Verdict(True, f"right: {self.why}")
        for hint, wrong in self.mistakes.items():
            if self._are_same(given, wrong(right)):
                return Verdict(False, NOT_YET + hint)
        n_right = sum(map(_is_rounded, given, map(float, right)))
        beside = f" ({n_right} of {len(right)} stand right)" if self.in_order and n_right else ""
        return Verdict(False, NOT_YET + self.hint + beside)

    def _are_same(self, given: list[float], right: Any) -> bool:
        pairs = (given, right) if self.in_order else (sorted(given), sorted(right))
        return all(_is_rounded(a, float(b)) for a, b in zip(*pairs, strict=True))


@dataclass(frozen=True, kw_only=True)
class FunctionExercise(Exercise):
    """A function that the student writes, compared with ``right`` on some cases.

    ``cases`` gives what the function is called with, by the name of the case. ``settle`` brings results that mean
    the same to one form. ``also`` are other functions that are right, too.
    """

    signature: str
    cases: Callable[[], dict[str, tuple[Any, ...]]]
    settle: Callable[[Arrays], Any] = lambda parts: parts
    also: tuple[Callable[..., Any], ...] = ()
    is_free: bool = False  # the shape of a result says nothing before it is settled

    def _judged(self, answer: Any) -> Verdict:
        if answer is None or answer is ...:
            raise reading.UnansweredError
        if not read_in_time(_is_function, answer):
            raise reading.UnreadableError(
                f"a function {self.signature} is asked for: give its name, without brackets"
            )
        cases = self.cases()
        ours = {name: _dense(self.right(*copy.deepcopy(given))) for name, given in cases.items()}
        wanted = {name: self._settled(parts) for name, parts in ours.items()}
        results = {}
        left = PATIENCE
        for name, given in cases.items():
            arguments = copy.deepcopy(given)
            try:
                result = within(left, partial(answer, *arguments))
            except TooSlowError:
                return Verdict(
                    False, f"{NOT_YET}your function was not done within a second. Does a loop never end?"
                )
            except FailedError as failure:
                called = f"; it is called as {self.signature}" if str(failure).startswith("TypeError") else ""
                return Verdict(False, f"{NOT_YET}for {name} your function raised {failure}{called}")
            if result is ...:
                raise reading.UnansweredError
            if result is None:
                return Verdict(
                    False,
                    f"{NOT_YET}your function gives back nothing (None): is there a `return` at its end?",
                )
            try:
                results[name] = read_in_time(partial(self._taken, like=ours[name]), result)
            except reading.UnreadableError as sentence:
                return Verdict(False, f"{NOT_YET}for {name} {sentence}")
            except FailedError as failure:
                return Verdict(
                    False, f"{NOT_YET}what your function gave for {name} can't be read ({failure})"
                )
            if any(np.isnan(part).any() for part in results[name]):
                return Verdict(False, f"{NOT_YET}for {name} your result holds NaN: was 0 divided by 0?")
        wrong_at = [name for name in cases if not _equal(results[name], wanted[name])]
        if not wrong_at or any(self._agrees(other, cases, results) for other in self.also):
            return Verdict(True, f"right: {self.why}")
        for hint, mistake in self.mistakes.items():
            if self._agrees(mistake, cases, results):
                return Verdict(False, NOT_YET + hint)
        some = (
            "" if len(wrong_at) == len(cases) else f" (it is right for {len(cases) - len(wrong_at)} others)"
        )
        return Verdict(False, f"{NOT_YET}{self.hint} The results differ for {wrong_at[0]}{some}.")

    def _taken(self, result: Any, like: Arrays) -> Arrays:
        return self._settled(self._parts(result, like))

    def _parts(self, result: Any, like: Arrays) -> Arrays:
        """The student's arrays, with the shapes of ours."""
        if not self.is_free:
            return reading.arrays(result, tuple(part.shape for part in like))
        found = reading.rows(result)
        if found.size == 0:
            raise reading.UnreadableError("your function gives back nothing but an empty list")
        return (found,)

    def _settled(self, parts: Arrays) -> Arrays:
        settled = self.settle(parts)
        return settled if isinstance(settled, tuple) else (settled,)

    def _agrees(self, function: Callable[..., Any], cases: dict[str, tuple[Any, ...]], results: Any) -> bool:
        with np.errstate(all="ignore"):
            return all(
                _equal(results[name], self._settled(_dense(function(*copy.deepcopy(given)))))
                for name, given in cases.items()
            )


def _is_function(answer: Any) -> bool:
    return callable(answer) and not isinstance(answer, type)


def _dense(result: Any) -> Arrays:
    parts = result if isinstance(result, tuple) else (result,)
    return tuple(np.asarray(p.toarray() if hasattr(p, "toarray") else p, float) for p in parts)


def _equal(given: Any, right: Any) -> bool:
    for a, b in zip(given, right, strict=True):
        if a.shape != b.shape:
            return False
        is_finite = np.isfinite(b)
        scale = np.abs(b[is_finite]).max(initial=0.0) or 1.0
        with np.errstate(invalid="ignore"):
            if not np.allclose(a, b, rtol=1e-4, atol=1e-6 * scale):
                return False
    return True
