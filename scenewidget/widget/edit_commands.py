"""Edits between the picture and a session: what a person did goes in, what has become of it is shown.

The session knows segments as tables over atoms, and so does the picture: an edit moves a few entries and
costs a few ms, however many faces there are.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from scenewidget.editing.edits import Edit, EditError, Relabel, edit_from_dict
from scenewidget.editing.session import Event, Session, Step
from scenewidget.editing.vocabulary import NYU40, quick_names
from scenewidget.engine.mesh import IntArray
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import Segmentation
from scenewidget.widget.autosave import Autosave, spoken
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.wire import face_bits, middle_of

__all__ = ["EditCommands"]

FREE_FORM = {  # edits face by face: what a message may say of each
    "paint": ("ranges", "onto_face"),
    "slice": ("face", "point", "normal"),
    "grow": ("face", "rings"),
    "shrink": ("face", "rings"),
    "fill_holes": ("face", "max_faces"),
    "smooth_border": ("face", "rounds"),
}
KINDS = ("merge", "split", "relabel", "group", "cut", *FREE_FORM, "undo", "redo", "go_to")
MOST_STEPS = 300  # so many of the done steps are listed, and so many of the undone


class EditCommands:
    """What connects a `SceneView` with a `Session`.

    Parameters
    ----------
    view : SceneView
    lock : RLock
        Held while the view changes. Never ask the session while holding it: it may be busy with an edit
        of another thread, or with a slow disk.
    autosave : Autosave
        Writes what changes.
    on_change : callable ()
        Called after every change, once the picture has been told.

    Attributes
    ----------
    session : Session or None
        None before the first segmentation.
    vocabulary : tuple of str or None
        Names to choose from, whatever a restored session says; None = the session's.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from scenewidget.widget.autosave import Autosave
    >>> import threading
    >>> view, lock = SceneView(mesh, editable=True), threading.RLock()
    >>> commands = EditCommands(view, lock, Autosave(view, lock, False, print), lambda: None)
    >>> commands.take(seg, sw.Params())
    0
    >>> message = {"kind": "merge", "face": 0, "onto_face": 7, "level": "final"}
    >>> commands.handle({**message, "revision": view.revision})
    >>> commands.session.edits
    [Merge(faces=(0,), onto_face=7, level='final')]
    >>> view.close()
    """

    def __init__(
        self, view: SceneView, lock: threading.RLock, autosave: Autosave, on_change: Callable[[], None]
    ) -> None:
        self.session: Session | None = None
        self.vocabulary: tuple[str, ...] | None = None
        self._stop_watching: Callable[[], None] = lambda: None
        self._autosave = autosave
        self._view = view
        self._lock = lock
        self._on_change = on_change
        self._message = threading.local()  # that this thread is dealing with
        self._shown_automatic: Segmentation | None = None
        self._shown_revision = -1  # of the session
        self._first_revision = 0  # of the view, since the present automatic segmentation is shown
        view.observe(self._show_history, "history_shown")

    def take(self, segmentation: Segmentation, params: Params) -> int:
        """Put another automatic segmentation underneath; how many edits don't apply to it."""
        if self.session is not None:
            return len(self.session.resegment(segmentation, params))
        vocabulary = NYU40 if self.vocabulary is None else self.vocabulary
        self.adopt(Session(self._view.mesh, segmentation, params=params, vocabulary=vocabulary))
        return 0

    def adopt(self, session: Session) -> None:
        """Go on with a session made elsewhere; the one before is let go, with its file."""
        if self.vocabulary is not None and session.vocabulary != self.vocabulary:
            session.vocabulary = self.vocabulary
        self._stop_watching()
        if self.session is not None:
            self.session.close()
        self.session = session
        with self._lock:
            self._shown_automatic, self._shown_revision = None, -1
        self._stop_watching = session.observe(lambda event: self._show(session, event))
        self._show(session, Event("segmentation", None, 0))

    def handle(self, message: Any) -> None:
        """Do what a message of the picture asks for; what concerns no edit is passed over."""
        kind = message.get("kind") if isinstance(message, dict) else None
        if kind == "save":
            self._save()
        elif kind == "choose":
            try:
                self._autosave.choose(str(message.get("notice")), str(message.get("action")))
            except (OSError, ValueError) as error:  # of the file; told, and nothing has changed
                self._view.error = spoken(error)
        elif kind == "preview_cut":
            self._preview_cut(message)
        elif kind == "preview_edit":
            self._preview_edit(message)
        if kind not in KINDS:
            return
        try:
            if self.session is not None:
                with self.gesture(message):
                    self._edit(self.session, kind, message)
        except EditError as error:
            self.remark(spoken(error))
        except Exception as error:
            self._view.error = f"{type(error).__name__}: {error}"
            raise
        finally:
            with self._lock:
                self._view.answer(message)

    @contextlib.contextmanager
    def gesture(self, message: dict[str, Any]) -> Iterator[None]:
        """Whatever this thread edits meanwhile, a person does in the picture: it begins the file."""
        self._message.now = message
        try:
            yield
        finally:
            del self._message.now

    def remark(self, text: str) -> None:
        """Say something in the status line, unless a computation speaks there."""
        with self._lock:
            if not self._view.busy:
                self._view.status = text

    def _edit(self, session: Session, kind: str, message: dict[str, Any]) -> None:
        if kind == "undo":
            session.undo()
        elif kind == "redo":
            session.redo()
        elif kind == "go_to":
            most = len(session.history) + len(session.undone)  # an edit may have come since it was listed
            session.go_to(min(message["n"], most))
        elif kind in FREE_FORM:  # it names faces of the scan: whatever has come meanwhile, they are there
            session.do(self._free_form(kind, message))
        elif message["revision"] < self._first_revision:
            # it names faces of parts that are no longer there
            self.remark("Another segmentation has just come: nothing was edited")
        elif kind == "merge":
            session.merge(message["face"], message["onto_face"], message["level"])
        elif kind == "split":
            session.split(message["face"], message["level"])
        elif kind == "group":
            session.group(message["face"], message["onto_face"])
        elif kind == "cut":
            session.cut(message["face_a"], message["face_b"])
        else:
            session.relabel(message["face"], message["name"])

    def _free_form(self, kind: str, message: dict[str, Any]) -> Any:
        """The edit face by face that a message asks for."""
        said = {key: message[key] for key in FREE_FORM[kind] if key in message}
        if kind == "slice":
            said["point"] = tuple(np.asarray(said["point"], float) + middle_of(self._view.mesh))
        return edit_from_dict({"kind": kind, **said})

    def _preview_cut(self, message: dict[str, Any]) -> None:
        """Tell the browser what a cut would divide off; nothing, if it can't be done."""
        faces: IntArray = np.zeros(0, np.int64)
        try:
            if self.session is not None and message["revision"] >= self._first_revision:
                faces = self.session.preview_cut(message["face_a"], message["face_b"])
        except EditError:
            pass  # told once a person asks for the cut
        finally:
            first, bits = face_bits(faces)
            answer = {"kind": "cut_preview", "request": message.get("request"), "first": first}
            self._view.send(answer, [bits])

    def _preview_edit(self, message: dict[str, Any]) -> None:
        """Tell the browser which faces an edit would move; none, and why, if it can't be done."""
        faces: IntArray = np.zeros(0, np.int64)
        reason = ""
        try:
            if self.session is not None:
                asked = message["edit"]
                faces = self.session.preview(self._free_form(asked["kind"], asked))
        except EditError as error:
            reason = spoken(error)
        finally:
            first, bits = face_bits(faces)
            answer = {"kind": "edit_preview", "request": message.get("request"), "first": first}
            self._view.send({**answer, "reason": reason}, [bits])

    def _save(self) -> None:
        if self.session is None:
            self.remark("There is nothing to save yet")
            return
        try:
            written = self._autosave.save(self.session)
        except OSError as error:
            self.remark(spoken(error))
        else:
            self.remark(f"Saved in {written.name}")

    def _show(self, session: Session, event: Event) -> None:
        """Show what a session holds now; called after each edit, undo and redo, from any thread."""
        if session is not self.session:
            return
        message = getattr(self._message, "now", None)
        if event.kind == "file":
            self._autosave.tell(session)
            return
        state = session.snapshot()  # this event's or a newer one
        history, undone = session.history, session.undone
        view = self._view
        with self._lock, view.hold_sync():
            if state.revision >= self._shown_revision:
                self._shown_revision = state.revision
                view.show_snapshot(state, keeps_ids=state.automatic is self._shown_automatic)
                session.keep_colors(dict(zip(state.ids.tolist(), view.color_rows.tolist(), strict=True)))
                if state.automatic is not self._shown_automatic:
                    self._shown_automatic = state.automatic
                    self._first_revision = view.revision
                view.undo_title = history[-1].title if history else ""
                view.redo_title = undone[0].title if undone else ""
                used = [
                    step.edit.name for step in history if isinstance(step.edit, Relabel) and step.edit.name
                ]
                latest = dict.fromkeys(reversed(used))
                view.vocabulary = list(latest | dict.fromkeys(session.vocabulary))
                view.quick_names = list(quick_names(session.vocabulary, used))
                self._list_steps(history, undone)
            if event.step is not None:
                done = {"undo": "Undone: ", "redo": "Redone: "}.get(event.kind)
                self.remark(f"{done}{event.step.title}" if done else "")
            if message is not None:
                view.answer(message)
        self._autosave.note(session, event, is_gesture=message is not None)
        self._on_change()

    def _show_history(self, _: Any) -> None:
        session = self.session
        if session is not None:
            history, undone = session.history, session.undone
            with self._lock, self._view.hold_sync():
                self._list_steps(history, undone)

    def _list_steps(self, history: Sequence[Step], undone: Sequence[Edit]) -> None:
        """The steps around the present one, if somebody looks at them."""
        if not self._view.history_shown:
            return
        n = len(history)
        first = max(0, n - MOST_STEPS)
        rows = [
            {"n": first + i + 1, "title": step.title, "time": step.time, "problem": step.problem}
            for i, step in enumerate(history[first:])
        ]
        rows += [
            {"n": n + i + 1, "title": edit.title, "time": 0.0, "problem": ""}
            for i, edit in enumerate(undone[:MOST_STEPS])
        ]
        self._view.history, self._view.n_done = rows, n
