"""Worked solutions for teachers, a page a notebook.

They are computed and written when a teacher asks for them, and come with no notebook.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

from scenewidget import exercises
from scenewidget.exercises.judging import Exercise, FunctionExercise

__all__ = ["page", "write"]

LEVELS = {1: "read off", 2: "think", 3: "write the algorithm"}


def write(folder: Path) -> list[Path]:
    """Write ``solutions_02.md`` and so on into a folder, made if it is not there.

    Examples
    --------
    >>> write(Path("solutions"))[0].name  # doctest: +SKIP
    'solutions_02.md'
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for notebook in exercises._HOME:
        path = folder / f"solutions_{notebook}.md"
        path.write_text(page(notebook), encoding="utf-8", newline="\n")
        written.append(path)
    return written


def page(notebook: str) -> str:
    """Questions, answers, reasons, and the hints that wrong answers get, as Markdown.

    Examples
    --------
    >>> page("03").splitlines()[0]
    '# Notebook 03: solutions'
    """
    found = exercises._exercises(exercises._HOME[notebook])
    return f"# Notebook {notebook}: solutions\n\n" + "\n".join(map(_section, found))


def _section(exercise: Exercise) -> str:
    lines = [f"## {exercise.name} ({LEVELS[exercise.level]})", "", exercise.question, ""]
    if isinstance(exercise, FunctionExercise):
        worked = exercise.also[0] if exercise.also else exercise.right
        lines += [_source(worked), ""]
    else:
        lines += [f"**{_shown(exercise.right())}**", "", _source(exercise.right), ""]
    lines += [f"Why: {exercise.why}", "", "Hints that wrong answers get:", ""]
    lines += [f"- {hint}" for hint in (*exercise.mistakes, exercise.hint)]
    return "\n".join([*lines, ""])


def _shown(answer: Any) -> str:
    if isinstance(answer, float):
        return f"{answer:.6g}"
    text = str(answer)
    return text if len(text) < 80 else f"{text[:70]} …"


def _source(function: Callable[..., Any]) -> str:
    return f"```python\n{textwrap.dedent(inspect.getsource(function)).rstrip()}\n```"
