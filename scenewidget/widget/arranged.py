"""Our boxes among those of ipywidgets: their height is a picture's, and their parts stay together."""

from __future__ import annotations

import re
from typing import Any

import ipywidgets as widgets
import traitlets

__all__ = ["Arranged"]

PIXELS = re.compile(r"\s*(\d+)(\.\d*)?(px)?\s*")
HEIGHTS = ("height", "min_height", "max_height")
LENGTH = re.compile(r"\s*[\d.]+\s*[a-z%]*\s*")


class Arranged(widgets.DOMWidget):
    """A widget with a ``height``, which ``layout.height`` sets as well, and with parts that aren't exchanged.

    Least and most heights of a layout would leave a gap below the picture or cut it off, so they are refused.

    Examples
    --------
    >>> class Lamp(Arranged):
    ...     height = 200
    >>> Lamp.__module__ = "scenewidget.lamp"
    >>> lamp = Lamp()
    >>> lamp.layout.height = "300px"
    >>> lamp.height, lamp.layout.height
    (300, None)
    >>> lamp.layout.height = "50%"
    Traceback (most recent call last):
    ValueError: layout.height of a Lamp is in pixels, got '50%'; write height = 400
    >>> lamp.children = []
    Traceback (most recent call last):
    AttributeError: children of a Lamp stay what they are; a box of yours holds it and more: VBox([w, ...])
    """

    height: Any
    _is_arranged = False  # until ipywidgets has put it together

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._is_arranged = True
        self._hear_layout()

    def __setattr__(self, name: str, value: Any) -> None:
        """As of any object, but for its parts."""
        kind = type(self)
        is_ours = kind.__module__.split(".")[0] == "scenewidget"
        if name == "children" and is_ours and self._is_arranged:
            raise AttributeError(
                f"children of a {kind.__name__} stay what they are; a box of yours holds it and more: "
                "VBox([w, ...])"
            )
        super().__setattr__(name, value)

    @traitlets.observe("layout")
    def _hear_layout(self, _: Any = None) -> None:
        if self._is_arranged:
            self.layout.observe(self._take_height, list(HEIGHTS))
            for name in HEIGHTS:
                self._take_height({"name": name, "new": getattr(self.layout, name)})

    def _take_height(self, change: Any) -> None:
        """Take a height that was meant for the picture; no length, such as "auto", stays in the layout."""
        name, value = change["name"], change["new"]
        if not isinstance(value, str) or not LENGTH.fullmatch(value):
            return
        setattr(self.layout, name, None)
        if name != "height":
            raise ValueError(
                f"layout.{name} of a {type(self).__name__} would not change its picture, got {value!r:.200}; "
                "write height = 400"
            )
        pixels = PIXELS.fullmatch(value)
        if pixels is None:
            raise ValueError(
                f"layout.height of a {type(self).__name__} is in pixels, got {value!r:.200}; "
                "write height = 400"
            )
        self.height = int(pixels[1])
