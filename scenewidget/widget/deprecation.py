"""Arguments that become keyword-only: by position they are taken for one release more."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

__all__ = ["keywords_after"]

Method = TypeVar("Method", bound=Callable[..., Any])


def keywords_after(n: int, *names: str) -> Callable[[Method], Method]:
    """Take arguments of a method by position that are keyword-only now, with a DeprecationWarning.

    Parameters
    ----------
    n : int
        How many arguments, after self, may come by position.
    *names : str
        Those that could once follow them, in their order.

    Examples
    --------
    >>> import warnings
    >>> class Thing:
    ...     @keywords_after(1, "names")
    ...     def show(self, labels, *, names=None):
    ...         return names
    >>> with warnings.catch_warnings(record=True) as told:
    ...     warnings.simplefilter("always")
    ...     Thing().show([0], {0: "chair"})
    {0: 'chair'}
    >>> str(told[0].message)
    'show takes names by keyword: names=…; by position only until the next release'
    """

    def decorate(method: Method) -> Method:
        @functools.wraps(method)
        def call(self: Any, *args: Any, **keywords: Any) -> Any:
            late = dict(zip(names, args[n:]))
            if late and len(args) <= n + len(names) and not late.keys() & keywords.keys():
                told = ", ".join(late)
                warnings.warn(
                    f"{method.__name__} takes {told} by keyword: {', '.join(f'{name}=…' for name in late)}; "
                    "by position only until the next release",
                    DeprecationWarning,
                    stacklevel=2,
                )
                return method(self, *args[:n], **late, **keywords)
            return method(self, *args, **keywords)

        return call  # type: ignore[return-value]  # wraps keeps the signature

    return decorate
