"""A bar above the output of a cell that takes its time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeVar

import ipywidgets as widgets
from IPython import get_ipython
from IPython.display import display

__all__ = ["sweep"]

T = TypeVar("T")


def sweep(values: Iterable[T], *, title: str = "") -> Iterator[T]:
    """Go through values while a bar shows how far it is; the bar goes away at the end.

    Outside of a notebook nothing is shown, and a notebook that is committed keeps no trace of it.

    Parameters
    ----------
    values : iterable
        Parameters to try, say. They are collected first, to know how many there are.
    title : str
        What is going on.

    Yields
    ------
    value
        One after the other.

    Examples
    --------
    >>> [n**2 for n in sweep([1, 2, 3], title="squares")]
    [1, 4, 9]
    """
    todo = list(values)
    bar = widgets.IntProgress(0, max=len(todo), layout={"width": "240px"})
    text = widgets.Label(f"{title} 0 of {len(todo)}".strip())
    box = widgets.HBox([bar, text])
    if get_ipython() is not None:
        shown = {**box._repr_mimebundle_(), "text/plain": ""}
        display(shown, raw=True)  # type: ignore[no-untyped-call]
    try:
        for done, value in enumerate(todo, start=1):
            yield value
            bar.value, text.value = done, f"{title} {done} of {len(todo)}".strip()
    finally:
        box.layout.display = "none"
