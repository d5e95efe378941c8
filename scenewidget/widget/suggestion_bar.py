"""The suggestions of a session in the picture, one at a time: shown, followed, passed over."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable
from typing import Any

from scenewidget.editing.edits import EditError, Relabel
from scenewidget.editing.session import Session
from scenewidget.editing.suggestions import WORTH, Suggestion
from scenewidget.widget.autosave import spoken
from scenewidget.widget.scene_view import SceneView

__all__ = ["SuggestionBar"]

MOST = 100  # suggestions that are counted


class SuggestionBar:
    """What connects `Session.suggestions` with a `SceneView`.

    Parameters
    ----------
    view : SceneView
    lock : RLock
        Held while the view changes; never while the session is asked.
    session : callable () -> Session or None
    remark : callable (str)
        Says something in the status line.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> import threading
    >>> view = SceneView(mesh)
    >>> bar = SuggestionBar(view, threading.RLock(), session=lambda: None, remark=print)
    >>> bar.handle({"do": "next"})
    There is nothing to suggest before the first result
    >>> view.close()
    """

    def __init__(
        self,
        view: SceneView,
        lock: threading.RLock,
        session: Callable[[], Session | None],
        remark: Callable[[str], None],
    ) -> None:
        self._view, self._lock, self._session, self._remark = view, lock, session, remark
        self._current: Suggestion | None = None
        self._number = 0  # of the one that is shown; answers to another are passed over
        self._is_following = False
        self._n_seen = 0  # answers since the last result

    def handle(self, message: dict[str, Any]) -> None:
        """Do what a person asks for: "next", "accept", "skip", "close", or "names"."""
        session, what = self._session(), message.get("do")
        current = self._current if message.get("number") == self._number else None
        if session is None:
            self._show(None)
            self._remark("There is nothing to suggest before the first result")
            return
        if what == "close":
            self._show(None)
            return
        if what == "names":
            self._show(None)
            named = [step.edit.name for step in session.accept_names() if isinstance(step.edit, Relabel)]
            counted = ", ".join(f"{n} {name}" for name, n in Counter(named).most_common())
            self._remark(f"Named {counted}" if named else "No names that the shapes alone tell")
            return
        if what == "accept" and current is not None:
            self._is_following = True
            self._n_seen += 1
            try:
                session.do(current.edit)
            except EditError as error:
                self._remark(spoken(error))
                session.dismiss(current)
            finally:
                self._is_following = False
        elif what == "skip" and current is not None:
            self._n_seen += 1
            session.dismiss(current)
        found = session.suggestions(MOST)
        n_left = sum(suggestion.gain >= WORTH for suggestion in found)
        self._show(found[0] if found else None, n_left)
        if found:
            session.propose(found[0])
        if not found:
            self._remark("Nothing more to suggest")
        elif n_left == 0:
            self._remark(f"Done: what is left would each lower the error by less than {WORTH:.1%}")

    def forget(self) -> None:
        """The segments have changed by other means: what is shown may not make sense any more."""
        if self._current is not None and not self._is_following:
            self._show(None)

    def _show(self, suggestion: Suggestion | None, n_left: int = 0) -> None:
        with self._lock:
            self._current = suggestion
            self._number += 1
            words = {} if suggestion is None else _shown(suggestion, self._n_seen, n_left)
            self._view.set_trait("suggestion", {**words, "number": self._number})  # every answer is a change


def _shown(suggestion: Suggestion, n_seen: int, n_left: int) -> dict[str, Any]:
    """What the bar shows: the suggestion, and how far one has come."""
    of = f"{n_seen} of {n_seen + n_left} doubtful places seen" if n_left else "the rest hardly matters"
    return {**vars(suggestion), "faces": list(suggestion.faces), "face": suggestion.face, "progress": of}
