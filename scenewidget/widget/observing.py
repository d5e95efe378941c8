"""Observers of a widget whose own faults don't become the widget's.

A trait is often set in a thread, in the middle of a computation. What an observer raises then is shown as a
traceback of its own, and the widget goes on; traitlets would break off what has set the trait, and tell
nobody else.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from typing import Any

import traitlets

from scenewidget.engine.checks import did_you_mean

__all__ = ["FaultTolerant", "Guarded"]


class Guarded:
    """A handler whose exceptions are shown; equal to the handler itself, so that it can be taken away.

    Examples
    --------
    >>> Guarded(print)("heard")
    heard
    >>> [Guarded(print)].index(print)
    0
    """

    def __init__(self, handler: Callable[..., Any]) -> None:
        self.handler = handler

    def __call__(self, *args: Any) -> None:
        """Call the handler; nothing is raised."""
        try:
            self.handler(*args)
        except Exception as error:
            own = error.__traceback__.tb_next if error.__traceback__ is not None else None
            sys.stderr.write("An observer has failed; what it was told of stands.\n")
            traceback.print_exception(type(error), error, own or error.__traceback__)

    def __eq__(self, other: object) -> bool:
        return self.handler == (other.handler if isinstance(other, Guarded) else other)

    def __hash__(self) -> int:
        return hash(self.handler)


class FaultTolerant(traitlets.HasTraits):
    """Has traits whose observers may fail.

    Examples
    --------
    >>> class Lamp(FaultTolerant):
    ...     is_on = traitlets.Bool()
    >>> lamp = Lamp()
    >>> lamp.observe(lambda change: print("on"), "is_on")
    >>> lamp.is_on = True
    on
    """

    def observe(self, handler: Any, names: Any = traitlets.All, type: Any = "change") -> None:  # noqa: A002  # traitlets' name
        """As of any widget; what the handler raises is shown, and nobody else minds.

        Parameters
        ----------
        handler : callable (change)
        names : str, list of str or All
        type : str

        Raises
        ------
        TypeError
            The handler can't be called.
        ValueError
            There is no such trait, so that the handler would never be called.
        """
        if not callable(handler):
            raise TypeError(f"handler must be callable as handler(change), got {handler!r:.200}")
        _check_names(self, names)
        is_own = isinstance(handler, traitlets.EventHandler) or getattr(handler, "__self__", None) is self
        super().observe(handler if is_own else Guarded(handler), names, type)


def _check_names(owner: traitlets.HasTraits, names: Any) -> None:
    known = owner.trait_names()
    for name in (names,) if isinstance(names, str) else () if names is traitlets.All else names:
        if isinstance(name, str) and name not in known:
            public = [known_name for known_name in sorted(known) if not known_name.startswith("_")]
            hint = did_you_mean(name, public) or f"there are: {', '.join(public)}"
            raise ValueError(f"a {type(owner).__name__} has no {name!r} to observe; {hint}")
