"""Checks of arguments that several stages share."""

from __future__ import annotations

import operator
from typing import Any

__all__ = ["checked_count"]


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
        Not a whole number (2.0 is not one).
    ValueError
        Out of range.
    """
    try:
        count = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, got {value!r}") from None
    if count < 1:
        raise ValueError(f"{name} must be at least 1, got {count}")
    if most is not None and count > most:
        raise ValueError(f"{name} must be at most {most}, got {count}")
    return count
