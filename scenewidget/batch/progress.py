"""How far a run is, in a terminal or a notebook: a bar, what has failed, and the time left."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import sys
from collections.abc import Callable, Iterator
from typing import Any, Protocol

__all__ = ["shown", "spoken_row", "spoken_time"]


class Underway(Protocol):
    """Many scans on their way, as a bar sees them."""

    scans: tuple[str, ...]

    @property
    def seconds_left(self) -> float:
        """Expected; nan while nobody knows."""
        ...


Hear = Callable[[Any, dict[str, Any]], None]


@contextlib.contextmanager
def shown(run: Underway, progress: bool | Hear, *, behind: bool = False) -> Iterator[Hear]:
    """Who is to hear of each row of a run.

    Parameters
    ----------
    run : Run
    progress : bool or callable (run, row)
        True shows a bar if somebody can see it: in a notebook, or in a terminal on stderr.
    behind : bool
        Whether the run goes on after the block; then nothing is shown.

    Raises
    ------
    TypeError
        Neither.

    Examples
    --------
    >>> with shown(run, False) as hear:  # doctest: +SKIP
    ...     hear(run, row)
    """
    if not isinstance(progress, bool):
        if not callable(progress):
            raise TypeError(f"progress must be True, False or a function, got {type(progress).__name__}")
        yield progress
        return
    if (
        not progress
        or behind
        or not (_in_notebook() or sys.stderr.isatty())
        or not importlib.util.find_spec("rich")
    ):
        yield _unheard
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = None if _in_notebook() else Console(stderr=True)
    columns = (TextColumn("Scans"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[left]}"))
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=len(run.scans), left="")

        def hear(run: Underway, row: dict[str, Any]) -> None:
            if row["status"] not in ("done", "reused"):
                bar.console.print(spoken_row(row), markup=False, highlight=False)
            bar.update(task, advance=1, left=spoken_time(run.seconds_left))

        yield hear


def _unheard(run: Any, row: dict[str, Any]) -> None:
    """Nobody is there to see it."""


def spoken_row(row: dict[str, Any]) -> str:
    """A row as a line.

    Examples
    --------
    >>> spoken_row({"scan": "a.ply", "status": "done", "segments": 12, "seconds": 3.25, "error": ""})
    'a.ply  done  12 segments  3.2 s'
    >>> spoken_row({"scan": "b.ply", "status": "failed", "error": "damaged"})
    'b.ply  failed: damaged'
    """
    if row["status"] not in ("done", "reused"):
        return f"{row['scan']}  {row['status']}: {row['error']}"
    return f"{row['scan']}  {row['status']}  {row['segments']} segments  {row['seconds']:.1f} s"


def spoken_time(seconds: float) -> str:
    """Time left, as people say it; "" if nobody knows.

    Examples
    --------
    >>> spoken_time(40), spoken_time(100), spoken_time(20_000), spoken_time(float("nan"))
    ('about 40 s left', 'about 2 min left', 'about 5.6 h left', '')
    """
    if math.isnan(seconds) or seconds <= 0:
        return ""
    if seconds < 90:
        return f"about {seconds:.0f} s left"
    return f"about {seconds / 60:.0f} min left" if seconds < 5400 else f"about {seconds / 3600:.1f} h left"


def _in_notebook() -> bool:
    """Whether a kernel runs us."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return type(shell).__name__ == "ZMQInteractiveShell"
