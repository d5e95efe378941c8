"""Checks of arguments that several stages share, and warnings that point at the caller's line."""

from __future__ import annotations

import operator
import sys
import warnings
from pathlib import Path
from typing import Any

__all__ = ["checked_count", "checked_whole", "warn_caller"]

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
    """
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError(f"{name} must be a whole number, got {value!r:.200}")
    return operator.index(value)


def warn_caller(message: str) -> None:
    """A `UserWarning` at the line outside this package that led here, however deep the call.

    Parameters
    ----------
    message : str
    """
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        depth, frame = depth + 1, frame.f_back
    warnings.warn(message, stacklevel=depth + 1)
