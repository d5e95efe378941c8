"""One computation at a time, off the main thread, the newest request winning.

Goes in: a function that takes a `Monitor`'s progress and cancel. Comes out: its result, its error or the
news that it was cancelled, by callbacks from the worker's thread, never from a request that is stale.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from scenewidget.engine.kernels import compiling
from scenewidget.engine.monitor import Cancelled

__all__ = ["Newest", "Worker", "checked_timeout"]

Task = Callable[[Callable[[str, float], None], threading.Event], Any]


def checked_timeout(timeout: object) -> float | None:
    """Seconds, or None for ever.

    Raises
    ------
    TypeError, ValueError
        Something else; the message says ``timeout``.

    Examples
    --------
    >>> checked_timeout(2), checked_timeout(None)
    (2.0, None)
    """
    if timeout is None:
        return None
    if isinstance(timeout, bool) or not isinstance(timeout, (int, float)):
        raise TypeError(f"timeout must be a number of seconds or None, got {timeout!r:.200}")
    if not timeout >= 0:
        raise ValueError(f"timeout must be a number of seconds or None, got {timeout:g}")
    return float(timeout)


class Newest:
    """Runs tasks off the main thread; of those that come while one runs, only the last is run next.

    Unlike a `Worker`, it never stops what runs: for short tasks whose every answer is worth having.

    Examples
    --------
    >>> runner = Newest("example")
    >>> done = []
    >>> runner.submit(lambda: done.append("one"))
    >>> runner.wait(), done
    (True, ['one'])
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._condition = threading.Condition()
        self._pending: Callable[[], None] | None = None
        self._thread: threading.Thread | None = None

    @property
    def is_busy(self) -> bool:
        """Whether something runs or waits to run."""
        with self._condition:
            return self._thread is not None

    @property
    def has_next(self) -> bool:
        """Whether a task waits that is newer than the one that runs."""
        with self._condition:
            return self._pending is not None

    def submit(self, task: Callable[[], None]) -> None:
        """Run a task soon, unless another is submitted before."""
        with self._condition:
            self._pending = task
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()

    def drop(self) -> None:
        """Forget what waits to run."""
        with self._condition:
            self._pending = None

    def wait(self, timeout: float | None = None) -> bool:
        """Block until nothing runs or waits; False if the time ran out first."""
        with self._condition:
            return self._condition.wait_for(lambda: self._thread is None, timeout)

    def _run(self) -> None:
        while True:
            with self._condition:
                task, self._pending = self._pending, None
                if task is None:
                    self._thread = None
                    self._condition.notify_all()
                    return
            try:
                task()
            except Exception:  # nobody waits for it, and the next task must run
                logging.getLogger(__name__).exception("%s failed", self._name)


class Worker:
    """Runs the latest task that was submitted.

    Parameters
    ----------
    on_progress : callable (stage, fraction)
        Called once more when the stage must compile first; see `aside`.
    on_done : callable (result)
    on_error : callable (exception)
    on_cancelled : callable ()
        Called only when `cancel` was asked for, not when a newer task took over.

    Examples
    --------
    >>> found = []
    >>> worker = Worker(on_progress=print, on_done=found.append, on_error=print, on_cancelled=print)
    >>> worker.submit(lambda progress, cancel: 6 * 7)
    >>> worker.wait(), found
    (True, [42])
    """

    def __init__(
        self,
        *,
        on_progress: Callable[[str, float], None],
        on_done: Callable[[Any], None],
        on_error: Callable[[BaseException], None],
        on_cancelled: Callable[[], None],
    ) -> None:
        self._on_progress, self._on_done = on_progress, on_done
        self._on_error, self._on_cancelled = on_error, on_cancelled
        self._newest = Newest("scenewidget")
        self._lock = threading.Lock()
        self._revision = 0
        self._cancel = threading.Event()  # of the newest task
        self._compiles = False

    @property
    def aside(self) -> str:
        """What to say behind the name of the stage: that it compiles, which it does once on a machine."""
        return " (first run: compiling, once)" if self._compiles else ""

    @property
    def is_busy(self) -> bool:
        """Whether something runs or waits to run."""
        return self._newest.is_busy

    @property
    def has_next(self) -> bool:
        """Whether a task waits that is newer than the one that runs."""
        return self._newest.has_next

    def submit(self, task: Task) -> None:
        """Run a task as soon as the one under way has heard that it is no longer wanted."""
        with self._lock:
            self._revision += 1
            self._cancel.set()
            self._cancel = threading.Event()
            self._newest.submit(partial(self._perform, self._revision, task, self._cancel))

    def cancel(self) -> None:
        """Stop what runs and drop what waits; `on_cancelled` tells when that is done."""
        with self._lock:
            self._cancel.set()

    def wait(self, timeout: float | None = None) -> bool:
        """Block until nothing runs or waits; False if the time ran out first."""
        return self._newest.wait(timeout)

    def _perform(self, revision: int, task: Task, cancel: threading.Event) -> None:
        at = ("", 0.0)

        def report(stage: str, fraction: float) -> None:
            nonlocal at
            self._compiles = self._compiles and stage == at[0]
            at = stage, fraction
            if not cancel.is_set():
                self._on_progress(stage, fraction)

        def say_so() -> None:  # not from the thread that compiles: others wait for it, with locks held
            if at[0] and not self._compiles:
                self._compiles = True
                threading.Thread(target=lambda: report(*at), daemon=True).start()

        def was_replaced() -> bool:
            with self._lock:
                return revision != self._revision

        try:
            if cancel.is_set():
                raise Cancelled("cancelled before it began")
            with compiling(say_so):
                result = task(report, cancel)
            if cancel.is_set():
                raise Cancelled("cancelled at the end")
            self._on_done(result)
        except Cancelled:
            if not was_replaced():
                self._on_cancelled()
        except BaseException as error:  # handed to whoever waits; a thread must not die silently
            if not was_replaced():
                self._on_error(error)
