"""Checks of arguments that several stages share, and warnings that point at the caller's line."""

from __future__ import annotations

import operator
import sys
import warnings
from collections.abc import Iterable, Mapping
from difflib import get_close_matches  # here, for it is needed where the interpreter shuts down
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

__all__ = [
    "FixedDict",
    "FixedList",
    "KnownNames",
    "checked_count",
    "checked_flag",
    "checked_whole",
    "did_you_mean",
    "warn_caller",
]

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


def checked_flag(name: str, value: Any) -> bool:
    """``value`` as a bool; neither 1 nor "yes" is one.

    Parameters
    ----------
    name : str
        What the message calls it.
    value : object

    Raises
    ------
    TypeError
        Not a bool.

    Examples
    --------
    >>> from scenewidget.engine.checks import checked_flag
    >>> checked_flag("overwrite", "no")
    Traceback (most recent call last):
        ...
    TypeError: overwrite must be True or False, got 'no'
    """
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False, got {value!r:.200}")
    return bool(value)


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
    close = get_close_matches(name, list(names), n=1, cutoff=alike)
    return f"did you mean {close[0]!r}?" if close else ""


class FixedDict(dict[Any, Any]):
    """A table that is told, or exchanged as a whole: a change inside of it would reach nobody.

    Parameters
    ----------
    values : dict
    instead : str
        What to do instead, after a semicolon.

    Examples
    --------
    >>> FixedDict({0: "floor"}, instead="; write relabel(face, 'floor')")[1] = "wall"
    Traceback (most recent call last):
    TypeError: a change inside of this table isn't noticed; write relabel(face, 'floor')
    """

    def __init__(self, values: Mapping[Any, Any], *, instead: str = "") -> None:
        super().__init__(
            {k: FixedDict(v, instead=instead) if isinstance(v, dict) else v for k, v in values.items()}
        )
        self._instead = instead

    def _refuse(self, *_: object, **__: object) -> Any:
        """Refuse to be changed in place."""
        raise TypeError(f"a change inside of this table isn't noticed{self._instead}")

    update = pop = popitem = clear = setdefault = _refuse
    __setitem__ = __delitem__ = __ior__ = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return (dict, (dict(self),))


class FixedList(list[Any]):
    """A list that is exchanged as a whole, or not at all: a change inside of it would reach nobody.

    Examples
    --------
    >>> FixedList([1, 2]).append(3)
    Traceback (most recent call last):
    TypeError: a change inside of this list isn't noticed
    """

    _instead = ""  # what to write

    def _refuse(self, *_: object, **__: object) -> Any:
        """Refuse to be changed in place."""
        raise TypeError(f"a change inside of this list isn't noticed{self._instead}")

    append = extend = insert = pop = remove = clear = sort = reverse = _refuse
    __setitem__ = __delitem__ = __iadd__ = __imul__ = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (list(self),))


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
    >>> lamp.ison
    Traceback (most recent call last):
    AttributeError: 'Lamp' object has no attribute 'ison'; did you mean 'is_on'?
    """

    _set_once: tuple[str, ...] = ()  # attributes that its __init__ sets, and nobody afterwards

    def __setattr__(self, name: str, value: Any) -> None:
        """As of any object; an unknown name, or one that stays, is refused with what to write instead."""
        kind = type(self)
        if not name.startswith("_") and kind.__module__.split(".")[0] == "scenewidget":
            of_class = getattr(kind, name, self)
            stays = isinstance(of_class, property) and of_class.fset is None
            if stays or (name in self._set_once and name in vars(self)):
                hint = self._place_to_set(name)
                raise AttributeError(f"{name} of a {kind.__name__} can't be set{hint and '; '}{hint}")
            if of_class is self and name not in self._set_once:
                hint = self._place_to_set(name) or "names of your own begin with an underscore"
                raise AttributeError(f"a {kind.__name__} has no {name!r} to set; {hint}")
        super().__setattr__(name, value)

    if not TYPE_CHECKING:  # which would take every name for known

        def __getattr__(self, name: str) -> Any:
            """Say where something is that isn't here."""
            hint = "" if name.startswith("_") else self._place_to_get(name)
            told = f"{type(self).__name__!r} object has no attribute {name!r}"
            raise AttributeError(f"{told}{hint and '; '}{hint}")

    def _place_to_set(self, name: str) -> str:
        """What to write instead; "" if nobody can tell."""
        others = [known for known in self._public_names() if known != name]
        return did_you_mean(name, others, alike=0.75)

    def _place_to_get(self, name: str) -> str:
        """What to write instead; "" if nobody can tell."""
        names = self._public_names()
        longer = next((known for known in names if known.startswith(f"{name}_")), "")
        return f"did you mean {longer!r}?" if longer else did_you_mean(name, names, alike=0.75)

    def _public_names(self) -> list[str]:
        return [*self._set_once, *(known for known in dir(type(self)) if not known.startswith("_"))]


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
