"""The exercises of the course: `check` an answer, in whatever form it comes.

Goes in: the name of an exercise and an answer, a number, a list, a word or a function that a student wrote. Comes
out: a sentence, why it is right or a hint for the mistake that was made. Right answers are computed by the engine
when they are needed and stand nowhere. Teachers get them, worked out, from the command
``python -m scenewidget.exercises solutions FOLDER``.
"""

from __future__ import annotations

import difflib
import importlib
import re
from typing import Any

from scenewidget.exercises.judging import Exercise, Verdict

__all__ = ["check", "names", "question", "verdict"]

_HOME = {  # notebook -> module that has its exercises
    "01": "first_steps",
    "02": "graphs",
    "03": "laplacians",
    "04": "spectra",
    "05": "signatures",
    "06": "paths",
    "07": "medoids",
    "08": "agreement",
    "09": "annotating",
    "10": "measures",
    "11": "several_hands",
    "12": "drums",
    "13": "heat",
    "14": "poisson",
    "15": "graph_cuts",
    "16": "functional_maps",
    "17": "projects",
}


def check(name: str, answer: Any = ...) -> None:
    """Print whether an answer is right, and why; or else a hint.

    Parameters
    ----------
    name : str
        Notebook and number, "03.2".
    answer : object
        A number may be an int, a fraction, a text such as "1/4" or "25 %", an array with one entry, rounded to two digits
        or more; numbers may come in any list, a word in capitals, a function as itself. What
        comes back is a sentence, within about a second.

    Examples
    --------
    >>> check("03.1", "1/4")
    right: H = 1/r, a quarter of a metre.
    >>> check("03.1", 4)
    not yet: that is H itself; its unit is 1/m
    >>> check("03.1", ...)
    not answered yet
    """
    print(verdict(name, answer).text)


def verdict(name: str, answer: Any) -> Verdict:
    """(is_right, text): what `check` prints, for programs.

    Parameters
    ----------
    name : str
        Notebook and number, "03.2".
    answer : object
        See `check`.

    Examples
    --------
    >>> verdict("04.1", 0.25).is_right
    True
    """
    try:
        exercise = _exercise(name)
    except ValueError as error:
        return Verdict(False, str(error))
    return exercise.judged(answer)


def names(notebook: str = "") -> list[str]:
    """Names of all exercises, or of those of a notebook.

    Parameters
    ----------
    notebook : str
        Its number, "03".

    Examples
    --------
    >>> names("05")
    ['05.1', '05.2', '05.3', '05.4', '05.5', '05.6', '05.7']
    """
    found = [exercise.name for home in _HOME.values() for exercise in _exercises(home)]
    return [name for name in found if name.startswith(notebook)]


def question(name: str) -> str:
    """The question, as it stands in the notebook.

    Parameters
    ----------
    name : str
        Notebook and number, "03.2".

    Raises
    ------
    ValueError
        There is no such exercise.

    Examples
    --------
    >>> question("03.1")
    'A sphere has mean curvature 4/m. What is its radius in metres?'
    """
    return _exercise(name).question


def _exercises(home: str) -> tuple[Exercise, ...]:
    found: tuple[Exercise, ...] = importlib.import_module(f"scenewidget.exercises.{home}").EXERCISES
    return found


def _exercise(name: Any) -> Exercise:
    """The one of this name; "3.2" is "03.2"."""
    text = name.strip()[:20] if isinstance(name, str) else ""
    parts = re.fullmatch(r"(\d{1,2})\.(\d{1,2})", text)
    if parts:
        text = f"{int(parts[1]):02}.{int(parts[2])}"
        if (home := _HOME.get(text[:2])) is not None:
            for exercise in _exercises(home):
                if exercise.name == text:
                    return exercise
    near = difflib.get_close_matches(text, names(), n=1, cutoff=0.0) or names()[:1]
    got = repr(text) if isinstance(name, str) else f"something else ({type(name).__name__})"
    raise ValueError(f'name must be that of an exercise, such as "{near[0]}", got {got}; names() lists all')
