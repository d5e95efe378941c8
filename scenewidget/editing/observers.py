"""Who wants to hear of a session's changes, and what they are told."""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from scenewidget.editing.history import Step

__all__ = ["Event", "EventKind", "Observers"]

EventKind = Literal["edit", "undo", "redo", "segmentation", "vocabulary", "file"]


@dataclass(frozen=True)
class Event:
    """What observers of a session are told.

    Attributes
    ----------
    kind : str
        "edit", "undo", "redo", "segmentation" (another one underneath), "vocabulary", or "file" (saved,
        opened, closed, or trouble with the file).
    step : Step or None
        The edit in question.
    revision : int
        Grows with every event: of two events the larger one tells of the newer state.

    Examples
    --------
    >>> Event("file", None, revision=3).kind
    'file'
    """

    kind: EventKind
    step: Step | None
    revision: int


class Observers:
    """Callbacks, in the order in which they were added; safe from any thread.

    Examples
    --------
    >>> observers = Observers()
    >>> stop = observers.add(lambda event: print(event.kind))
    >>> observers.tell(Event("undo", None, 1))
    undo
    >>> stop()
    >>> observers.tell(Event("redo", None, 2))
    """

    def __init__(self) -> None:
        self._callbacks: list[Callable[[Event], None]] = []
        self._lock = threading.Lock()

    def add(self, callback: Callable[[Event], None]) -> Callable[[], None]:
        """Call ``callback(event)`` from now on; returns what ends that.

        Raises
        ------
        TypeError
            It can't be called.
        """
        if not callable(callback):
            raise TypeError(f"callback must be callable as callback(event), got {type(callback).__name__}")
        with self._lock:
            self._callbacks.append(callback)

        def stop() -> None:
            with self._lock:
                if callback in self._callbacks:
                    self._callbacks.remove(callback)

        return stop

    def tell(self, event: Event) -> None:
        """Call everybody, in this thread.

        Whatever one of them raises is shown as its own traceback on stderr: what happened has happened, and
        the others want to hear of it.
        """
        for callback in list(self._callbacks):
            try:
                callback(event)
            except Exception as error:
                own = error.__traceback__.tb_next if error.__traceback__ is not None else None
                sys.stderr.write(f"An observer has failed; the {event.kind} that it was told of stands.\n")
                traceback.print_exception(type(error), error, own or error.__traceback__)
