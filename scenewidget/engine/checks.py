"""Checks of arguments that several stages share, and warnings that point at the caller's line."""

from __future__ import annotations

import operator
import sys
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

__all__ = ["KnownNames", "checked_count", "checked_whole", "did_you_mean", "warn_caller"]

_PACKAGE = str(Path(__file__).parent.parent)


def checked_count(name: str, value: Any, *, most: int | None = None) -> int:
    """``value`` as an int from 1 to ``most``.

    Parameters
    ----------
    name : str
        What the message calls it.
    value : object
    most : int, optional

    Raises
    ------
    TypeError
        Not a whole number; neither True nor 2.0 is one.
    ValueError
        Out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.checks import checked_count
    >>> checked_count("n_runs", np.int64(3))
    3
    >>> checked_count("n_runs", 0)
    Traceback (most recent call last):
        ...
    ValueError: n_runs must be at least 1, got 0
    """
    count = checked_whole(name, value)
    if count < 1:
        raise ValueError(f"{name} must be at least 1, got {count}")
    if most is not None and count > most:
        raise ValueError(f"{name} must be at most {most}, got {count}")
    return count


def checked_whole(name: str, value: Any) -> int:
    """``value`` as an int; neither True nor 2.0 is one.

    Parameters
    ----------
    name : str
        What the message calls it.
    value : object

    Raises
    ------
    TypeError
        Not a whole number.

    Examples
    --------
    >>> from scenewidget.engine.checks import checked_whole
    >>> checked_whole("seed", 2.0)
    Traceback (most recent call last):
        ...
    TypeError: seed must be a whole number, got 2.0
    """
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError(f"{name} must be a whole number, got {value!r:.200}")
    return operator.index(value)


def did_you_mean(name: str, names: Iterable[str], *, alike: float = 0.6) -> str:
    """What to say of a name that is unknown but much like a known one; "" if none is.

    Parameters
    ----------
    name : str
    names : iterable of str
        Those that are known.
    alike : float
        How much, from 0 to 1, as `difflib` counts.

    Examples
    --------
    >>> from scenewidget.engine.checks import did_you_mean
    >>> did_you_mean("n_segment", ["n_items", "n_segments"]), did_you_mean("colour", ["n_segments"])
    ("did you mean 'n_segments'?", '')
    """
    import difflib

    close = difflib.get_close_matches(name, list(names), n=1, cutoff=alike)
    return f"did you mean {close[0]!r}?" if close else ""


class KnownNames:
    """Lets nothing be set that its class doesn't know, for that would change nothing and say nothing.

    Names of one's own begin with an underscore, or belong to a class of one's own.

    Examples
    --------
    >>> class Lamp(KnownNames):
    ...     is_on = False
    >>> Lamp.__module__ = "scenewidget.lamp"
    >>> lamp = Lamp()
    >>> lamp.is_on, lamp._bought = True, 2024
    >>> lamp.is_off = True
    Traceback (most recent call last):
    AttributeError: a Lamp has no 'is_off' to set; names of your own begin with an underscore
    """

    _set_once: tuple[str, ...] = ()  # attributes that its __init__ sets

    def __setattr__(self, name: str, value: Any) -> None:
        """As of any object; an unknown name is refused with what to write instead."""
        kind = type(self)
        is_known = name.startswith("_") or hasattr(kind, name) or name in self._set_once
        if not is_known and kind.__module__.split(".")[0] == "scenewidget":
            hint = self._place_to_set(name) or "names of your own begin with an underscore"
            raise AttributeError(f"a {kind.__name__} has no {name!r} to set; {hint}")
        super().__setattr__(name, value)

    def _place_to_set(self, name: str) -> str:
        """What to write instead; "" if nobody can tell."""
        known = [known for known in dir(type(self)) if not known.startswith("_")]
        return did_you_mean(name, known, alike=0.75)


def warn_caller(message: str) -> None:
    """A `UserWarning` at the line outside this package that led here, however deep the call.

    Parameters
    ----------
    message : str

    Examples
    --------
    >>> import warnings
    >>> from scenewidget.engine.checks import warn_caller
    >>> with warnings.catch_warnings(record=True) as heard:
    ...     warnings.simplefilter("always")
    ...     warn_caller("the mesh is 4000 across")
    >>> str(heard[0].message)[:61]
    'the mesh is 4000 across'
    """
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        depth, frame = depth + 1, frame.f_back
    warnings.warn(message, stacklevel=depth + 1)
