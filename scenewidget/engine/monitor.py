"""Progress and cancel of long work: the one object that every stage reports to.

Goes in: the caller's `progress` callback and `cancel` event. Comes out: `tick` for loops, `call` for
compiled code that can't be asked to stop.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

__all__ = ["Cancelled", "Monitor", "Progress"]

Progress = Callable[[str, float], object]
T = TypeVar("T")


class Cancelled(Exception):  # noqa: N818  the contract's name; it is not an error
    """The caller's cancel event was set; nothing was changed.

    Examples
    --------
    >>> import threading
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> cancel = threading.Event()
    >>> cancel.set()
    >>> sw.segment(square(2), cancel=cancel)
    Traceback (most recent call last):
        ...
    scenewidget.engine.monitor.Cancelled: cancelled
    """


class Monitor:
    """Tells the caller how far a computation is and stops it when asked.

    Parameters
    ----------
    progress : callable (stage: str, fraction: float), optional
        Called at the start (0.0) and end (1.0) of each stage and at most 20 times a second between; the
        fraction never falls within a stage.
    cancel : threading.Event, optional
        When set, the next `tick` raises `Cancelled`.

    Examples
    --------
    >>> from scenewidget.engine.monitor import Monitor
    >>> monitor = Monitor(progress=lambda stage, fraction: print(stage, fraction))
    >>> monitor.start("items")
    items 0.0
    >>> monitor.finish()
    items 1.0
    """

    def __init__(self, progress: Progress | None = None, cancel: threading.Event | None = None) -> None:
        if progress is not None and not callable(progress):
            raise TypeError(
                f"progress must be callable as progress(stage, fraction), got {type(progress).__name__}"
            )
        if cancel is not None and not hasattr(cancel, "is_set"):
            raise TypeError(f"cancel must be a threading.Event, got {type(cancel).__name__}")
        self._progress = progress
        self._cancel = cancel
        self._stage = ""
        self._last = 0.0
        self._highest = 0.0
        self._lock = threading.Lock()

    def start(self, stage: str) -> None:
        """Name the stage that begins."""
        self._stage = stage
        self._highest = 0.0
        self._report(0.0, always=True)

    def finish(self) -> None:
        """Report the end of the stage."""
        self._report(1.0, always=True)

    def tick(self, fraction: float | None = None) -> None:
        """Report ``fraction`` (0 to 1) of the stage; raise `Cancelled` if the caller asked for it."""
        if self._cancel is not None and self._cancel.is_set():
            raise Cancelled(f"cancelled during {self._stage!r}" if self._stage else "cancelled")
        if fraction is not None:
            self._report(fraction, always=False)

    def call(self, function: Callable[..., T], *args: Any, **kwargs: Any) -> T:
        """Result of a call that can't be interrupted; on cancel its thread is left to finish unheard.

        Only for pure calls into compiled code that releases the interpreter lock.

        Parameters
        ----------
        function : callable
        *args, **kwargs
            What it is called with.
        """
        if self._cancel is None:
            return function(*args, **kwargs)
        outcome: dict[str, Any] = {}

        def run() -> None:
            try:
                outcome["value"] = function(*args, **kwargs)
            except BaseException as error:  # handed on to the caller's thread below
                outcome["error"] = error

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        while thread.is_alive():
            thread.join(0.05)
            self.tick()
        if "error" in outcome:
            raise outcome["error"]
        value: T = outcome["value"]
        return value

    def _report(self, fraction: float, *, always: bool) -> None:
        if self._progress is None:
            return
        with self._lock:
            now = time.monotonic()
            if not always and now - self._last < 0.05:
                return
            self._last = now
            self._highest = min(max(float(fraction), self._highest), 1.0)  # estimates waver, bars don't
            self._progress(self._stage, self._highest)


SILENT = Monitor()
