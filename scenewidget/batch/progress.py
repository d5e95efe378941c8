"""How far a run is, in a terminal or a notebook: a bar, what has failed, and the time left."""

from __future__ import annotations

import contextlib
import html
import importlib.util
import math
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import ipywidgets

__all__ = ["NotebookBar", "shown", "spoken_row", "spoken_time"]

LISTED = 20  # scans that went wrong, under the bar; the table has all
CANCEL = (
    "Begins nothing more and abandons what runs; files are whole, and the same call goes on from there. "
    "Where the page doesn't answer while a cell runs, interrupt the kernel: that leaves the same"
)


class Underway(Protocol):
    """Many scans on their way, as a bar sees them."""

    scans: tuple[str, ...]
    rows: dict[str, dict[str, Any]]
    error: BaseException | None

    @property
    def seconds_left(self) -> float:
        """Expected; nan while nobody knows."""
        ...

    @property
    def summary(self) -> str:
        """What has become of them."""
        ...

    def cancel(self) -> None:
        """Begin nothing more."""
        ...


Hear = Callable[[Any, dict[str, Any]], None]


@contextlib.contextmanager
def shown(run: Underway, progress: bool | Hear, *, behind: bool = False) -> Iterator[Hear]:
    """Who is to hear of each row of a run.

    Parameters
    ----------
    run : Run
    progress : bool or callable (run, row)
        True shows a bar if somebody can see it: in a notebook, with a button that cancels, or in a terminal
        on stderr.
    behind : bool
        Whether other cells and prompts come meanwhile; then a terminal shows nothing.

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
    if progress and _in_notebook():
        on_page = NotebookBar(run)
        on_page.show()
        try:
            yield on_page.hear
        finally:
            on_page.end(run)
        return
    if not progress or behind or not sys.stderr.isatty() or not importlib.util.find_spec("rich"):
        yield _unheard
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = Console(stderr=True)
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


class NotebookBar:
    """A bar in a notebook, with the time left, a button that cancels, and what went wrong.

    Parameters
    ----------
    run : Run

    Attributes
    ----------
    box : ipywidgets.VBox
        All of it.
    button : ipywidgets.Button
        Cancels the run.

    Examples
    --------
    >>> from scenewidget.batch.runs import Run
    >>> bar = NotebookBar(Run([], "out", None, 0))
    >>> bar.button.description
    'Cancel'
    """

    def __init__(self, run: Underway) -> None:
        import ipywidgets as widgets

        self._lock = threading.Lock()
        self._wrong: list[str] = []
        self._bar = widgets.IntProgress(0, max=max(1, len(run.scans)), layout={"width": "240px"})
        self._text = widgets.Label(f"0 of {len(run.scans)} scans")
        self._list = widgets.HTML()
        self.button = widgets.Button(description="Cancel", tooltip=CANCEL, layout={"width": "80px"})
        self.button.on_click(lambda _: self._cancel(run))
        row = widgets.HBox([self._bar, self._text, self.button])
        self.box: ipywidgets.VBox = widgets.VBox([row, self._list])

    def show(self) -> None:
        """Put it under the cell that is running."""
        from IPython.display import display

        show: Any = display
        show({**self.box._repr_mimebundle_(), "text/plain": self._text.value}, raw=True)
        # JupyterLab sends what widgets say beside the cell that runs (on a "subshell"), and ipykernel 7.4
        # leads it back behind that cell, because it was there that the button was made
        with contextlib.suppress(AttributeError):
            del self.button.comm._reply_subshell_id

    def hear(self, run: Underway, row: dict[str, Any]) -> None:
        """One more scan has come to an end."""
        with self._lock:
            if row["status"] not in ("done", "reused"):
                self._wrong.append(spoken_row(row))
                lines = [html.escape(line) for line in self._wrong[:LISTED]]
                if len(self._wrong) > LISTED:
                    lines.append(f"… and {len(self._wrong) - LISTED} more: see to_frame()")
                self._list.value = "<br>".join(lines)
            self._bar.value = len(run.rows)
            left = spoken_time(run.seconds_left)
            self._text.value = f"{len(run.rows)} of {len(run.scans)} scans" + (f", {left}" if left else "")

    def end(self, run: Underway) -> None:
        """It is over, one way or another: say what came of it, and take the button away."""
        with self._lock:
            self.button.layout.display = "none"
            self._bar.bar_style = "success" if len(run.rows) == len(run.scans) else "warning"
            if run.error is not None:
                self._list.value += f"<p>{html.escape(f'It ended early: {run.error}')}</p>"
            self._text.value = run.summary

    def _cancel(self, run: Underway) -> None:
        self.button.disabled, self.button.description = True, "Cancelling"
        run.cancel()


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
