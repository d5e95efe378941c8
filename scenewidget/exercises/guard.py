"""Calls into answers of students: nothing that they do may raise, hang or take long.

An answer runs in a thread of its own. One that does not come back in time is asked to stop by an exception
raised inside it, and no longer waited for.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from typing import Any

__all__ = ["FailedError", "TooSlowError", "within"]


class TooSlowError(Exception):
    """The call was not done in time."""


class FailedError(Exception):
    """The call raised; the message says what."""


class _Stop(BaseException):
    """Raised inside a thread that nobody waits for any more."""


def within(seconds: float, call: Callable[[], Any]) -> Any:
    """What the call returns.

    Raises
    ------
    TooSlowError
        It took longer.
    FailedError
        It raised, whatever it was, SystemExit too.

    Examples
    --------
    >>> within(0.5, lambda: 1 + 1)
    2
    >>> within(0.5, lambda: 1 / 0)
    Traceback (most recent call last):
    scenewidget.exercises.guard.FailedError: ZeroDivisionError: division by zero
    """
    outcome: list[tuple[bool, Any]] = []

    def work() -> None:
        try:
            outcome.append((True, call()))
        except _Stop:
            pass
        except BaseException as error:
            outcome.append((False, _told(error)))

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(seconds)
    if not outcome:
        if thread.is_alive():
            stop = ctypes.py_object(_Stop)
            ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), stop)
        raise TooSlowError
    is_done, value = outcome[0]
    if not is_done:
        raise FailedError(value)
    return value


def _told(error: BaseException) -> str:
    """Class and message of an error on one line; its __str__ may be an answer's work, too."""
    try:
        message = " ".join(str(error).split())
    except BaseException:
        message = ""
    name = type(error).__name__
    return f"{name}: {message[:160]}" if message else name
