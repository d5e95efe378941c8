"""How long widgets live: what a cell shows goes once the cell has run again and shows something else.

ipywidgets keeps every widget that isn't closed, and IPython every output. So a cell that is run again would
leave behind what it made before, with its mesh, its results and whatever it is still computing. A widget that
a variable still leads to stays.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

import ipywidgets

__all__ = ["Lifetimes", "belongs_to_its_cell", "close_all"]

MOST_LOOKED_AT = 20_000  # values that are searched for widgets
OUTPUTS = ("_", "__", "___")

_of_shell: weakref.WeakKeyDictionary[Any, Lifetimes] = weakref.WeakKeyDictionary()
_of_marimo: weakref.WeakSet[Any] = weakref.WeakSet()


class Closable(Protocol):
    """What can be closed."""

    def close(self) -> None:
        """Let go of everything."""


def belongs_to_its_cell(widget: Closable) -> None:
    """Close a widget once the cell that is running now has run again, unless a variable leads to it then.

    marimo takes the parts of a widget off the page itself when their cell runs again or goes; what is behind
    them is closed once another widget is made. Outside a notebook, or where the host doesn't say which cell
    is running, nothing happens.

    Examples
    --------
    >>> import ipywidgets
    >>> belongs_to_its_cell(ipywidgets.HTML("stays"))
    """
    _close_what_marimo_dropped(widget)
    shell = _shell()
    if shell is None:
        return
    known = _of_shell.get(shell)
    if known is None:
        known = _of_shell[shell] = Lifetimes(shell)
    known.add(widget)


def close_all(*widgets: ipywidgets.Widget) -> None:
    """Close widgets with their layouts and styles, which are widgets of their own.

    Examples
    --------
    >>> import ipywidgets
    >>> box = ipywidgets.HTML("gone")
    >>> close_all(box)
    >>> box.comm is None
    True
    """
    for widget in widgets:
        parts = [getattr(widget, name, None) for name in ("layout", "style")]
        ipywidgets.Widget.close(widget)
        for part in parts:
            if isinstance(part, ipywidgets.Widget):
                part.close()


class Lifetimes:
    """Widgets by the cell that made them, in one IPython shell.

    Parameters
    ----------
    shell : InteractiveShell
        Asked which cell is running, and what its variables are.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> request = {"header": {"msg_id": "1"}, "metadata": {"cellId": "a"}}
    >>> shell = SimpleNamespace(user_ns={}, events=SimpleNamespace(register=lambda *_: None))
    >>> shell.kernel = SimpleNamespace(get_parent=lambda channel: request)
    >>> lifetimes = Lifetimes(shell)
    >>> class Thing:
    ...     def close(self):
    ...         print("closed")
    >>> thing = Thing()
    >>> lifetimes.add(thing)
    >>> lifetimes.tidy()  # the same run
    >>> request["header"] = {"msg_id": "2"}
    >>> lifetimes.tidy()
    closed
    """

    def __init__(self, shell: Any) -> None:
        self._shell: Callable[[], Any] = (
            weakref.ref(shell) if hasattr(shell, "__weakref__") else lambda: shell
        )
        self._cells: dict[str, list[tuple[str, weakref.ref[Any]]]] = {}
        shell.events.register("post_run_cell", lambda *_: self.tidy())

    def add(self, widget: Closable) -> None:
        """Remember a widget that is being made now."""
        cell, run = self._running()
        if cell is None:
            return
        made = self._cells.setdefault(cell, [])
        made.append((run, weakref.ref(widget)))

    def tidy(self) -> None:
        """Close what the cell that has just run made in earlier runs."""
        shell = self._shell()
        cell, run = self._running()
        if shell is None or cell not in self._cells:
            return
        made = [(when, ref) for when, ref in self._cells[cell] if ref() is not None]
        old = [widget for when, ref in made if when != run and (widget := ref()) is not None]
        if old:
            used = _led_to(shell.user_ns, old)
            for widget in old:
                if id(widget) not in used:
                    widget.close()
                    _forget_output(shell, widget)
            made = [(when, ref) for when, ref in made if when == run or id(ref()) in used]
        self._cells[cell] = made
        if not made:
            del self._cells[cell]

    def _running(self) -> tuple[str | None, str]:
        """The cell that is running and a name of this run; None where nobody knows."""
        shell = self._shell()
        try:
            request = shell.kernel.get_parent("shell")
            cell = request["metadata"]["cellId"]
            return (cell if isinstance(cell, str) else None), str(request["header"]["msg_id"])
        except (AttributeError, KeyError, TypeError):  # another kind of kernel or host
            return None, ""


def _shell() -> Any:
    try:
        from IPython import get_ipython
    except ImportError:
        return None
    return get_ipython()


def _close_what_marimo_dropped(newest: Closable) -> None:
    """Close widgets whose comms marimo has closed, now that another is made."""
    for widget in list(_of_marimo):
        comms = _known_to_marimo(widget)
        if comms is not None and not any(comms):
            _of_marimo.discard(widget)
            widget.close()
    if _known_to_marimo(newest):
        _of_marimo.add(newest)


def _known_to_marimo(widget: Any) -> list[bool] | None:
    """Whether marimo still knows the comms of a widget's parts; None elsewhere: Jupyter's have no manager."""
    comms: list[Any] = [getattr(part, "comm", None) for part in getattr(widget, "children", ())]
    known: list[Any] = [getattr(getattr(comm, "comm_manager", None), "comms", None) for comm in comms]
    if not comms or None in known:
        return None
    return [comm.comm_id in names for comm, names in zip(comms, known, strict=True)]


def _led_to(names: Mapping[str, Any], widgets: Iterable[Any]) -> set[int]:
    """Ids of those that variables lead to, by themselves or in lists, dictionaries, boxes and objects."""
    wanted = {id(widget) for widget in widgets}
    hidden = {*OUTPUTS, "Out", "In", "_oh", "_ih", "_dh"}
    values = [value for name, value in names.items() if name not in hidden and not _is_output(name)]
    found: set[int] = set()
    seen: set[int] = set()
    while values and len(seen) < MOST_LOOKED_AT:
        value = values.pop()
        if id(value) in seen:
            continue
        seen.add(id(value))
        if id(value) in wanted:
            found.add(id(value))
        if isinstance(value, Mapping):
            values.extend(value.values())
        elif isinstance(value, (list, tuple, set, frozenset)):
            values.extend(value)
        elif isinstance(value, ipywidgets.Widget):
            values.extend(getattr(value, "children", ()))
        elif type(value).__module__ == "__main__":  # objects of the user's own
            values.extend(getattr(value, "__dict__", {}).values())
    return found


def _is_output(name: str) -> bool:
    return name.startswith("_") and name[1:].isdigit()


def _forget_output(shell: Any, widget: Any) -> None:
    """Take a widget out of IPython's history of outputs, which would hold on to all that it knows."""
    history = shell.user_ns.get("Out")
    if isinstance(history, dict):
        for number in [number for number, value in history.items() if value is widget]:
            del history[number]
    for names in (shell.user_ns, getattr(shell, "user_ns_hidden", {})):
        for name in [name for name, value in names.items() if value is widget]:
            if _is_output(name) or name in OUTPUTS:
                names[name] = ""
    hook = getattr(shell, "displayhook", None)
    for name in OUTPUTS:
        if getattr(hook, name, None) is widget:
            setattr(hook, name, "")
