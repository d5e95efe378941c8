"""Keeps a person's corrections on disk without being asked, and finds them again later.

The project file lies in the kernel's folder, that is beside the notebook, and is named after the scan and its
fingerprint. It is made at the first edit that a person makes in the picture: showing a widget writes
nothing, nor does a script, which can be run again. What lies there already is offered and never written over:
whoever starts afresh gets a file with another number.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from scenewidget.editing.fingerprint import fingerprint
from scenewidget.editing.project import ProjectError
from scenewidget.editing.project_reader import Summary, summary_of
from scenewidget.editing.session import Event, Session
from scenewidget.engine.mesh import Mesh
from scenewidget.widget.scene_view import SceneView

__all__ = ["Autosave", "default_name", "newest_project", "spoken"]

SUFFIX = ".swproj"
NO_FILES = ("", "yes", "no", "on", "off", "true", "false", "none")  # that somebody means by autosave
DIGITS = 8  # so many digits of the fingerprint stand in the names of files


def default_name(mesh: Mesh) -> str:
    """Name of the project file of a scan: ``bedroom-1f3a9c02.swproj``.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> default_name(mesh).startswith("scan-")
    True
    """
    stem = re.sub(r"[^\w-]+", "_", Path(mesh.source).stem).strip("_")[:60]
    return f"{stem or 'scan'}-{fingerprint(mesh).digest[:DIGITS]}{SUFFIX}"


def spoken(problem: object) -> str:
    """What a person reads of an error: its message as a sentence, without a number.

    Examples
    --------
    >>> spoken(OSError(28, "no space left"))
    'No space left'
    """
    text = re.sub(r"^\[Errno \d+\] ", "", str(problem))
    return text[:1].upper() + text[1:]


def newest_project(mesh: Mesh, folder: Path) -> Summary | None:
    """The project of this mesh in a folder that was worked on last; None if there is none.

    Files that aren't projects, are damaged or of another mesh are passed over.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     newest_project(mesh, Path(folder)) is None
    True
    """
    if not any(path.suffix == SUFFIX for path in _entries(folder)):
        return None  # the fingerprint of a large mesh takes a moment
    digits = fingerprint(mesh).digest[:DIGITS]
    paths = (path for path in _entries(folder) if path.suffix == SUFFIX and digits in path.name)
    return _newest(_summaries(paths), mesh)


class Autosave:
    """Writes a session to its file and tells the picture how that stands.

    Parameters
    ----------
    view : SceneView
    lock : RLock
        Held while the view changes, never while a session is asked.
    autosave : bool or path
        Whether the first edit makes a file; a path says which one.
    restore : callable (Path)
        Called when a person wants an offered state back.

    Raises
    ------
    ValueError
        The path given is a folder.
    ProjectError
        The path given holds the project of another mesh, or something else.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> import threading
    >>> view = SceneView(mesh)
    >>> autosave = Autosave(view, threading.RLock(), False, restore=print)
    >>> view.save_state
    ''
    >>> view.close()
    """

    def __init__(
        self,
        view: SceneView,
        lock: threading.RLock,
        autosave: bool | str | os.PathLike[str],
        restore: Callable[[Path], None],
    ) -> None:
        if not isinstance(autosave, (bool, str, os.PathLike)):
            raise TypeError(f"autosave must be True, False or a path, got {type(autosave).__name__}")
        if isinstance(autosave, str) and autosave.strip().lower() in NO_FILES:
            raise ValueError(
                f"autosave must be True, False or a path such as 'room.swproj', got {autosave!r}"
            )
        self.autosave = autosave
        self._view = view
        self._lock = lock
        self._restore = restore
        try:
            self._folder = Path.cwd()  # the cell's; a later one may change directory
        except OSError:  # it was removed
            self._folder = Path()
        self._path = None if isinstance(autosave, bool) else self._folder / Path(autosave)
        if self._path is not None and self._path.is_dir():
            raise ValueError(
                f"autosave must name a file, but {str(self._path)!r} is a folder; "
                f"try {str(self._path / default_name(view.mesh))!r}"
            )
        self._problem = ""  # that kept the file from being made
        self._writing: threading.Thread | None = None
        self._tickets = itertools.count(1)
        self._told = 0
        self._session: Session | None = None
        self._notices: dict[str, dict[str, Any]] = {}
        self.offered = self._find()
        if self.offered is not None:
            when = time.strftime("%Y-%m-%d %H:%M", time.localtime(self.offered.last_time))
            self._put_notice(
                "offer",
                f"Edited {when}: {_steps(self.offered.n_steps)} in {self.offered.path.name}",
                [("Restore", "restore"), ("Start afresh", "drop")],
            )

    def _find(self) -> Summary | None:
        if self._path is None:
            return newest_project(self._view.mesh, self._folder)
        if not self._path.exists():
            return None
        found = [summary_of(self._path)]
        if found[0].fingerprint != fingerprint(self._view.mesh):
            raise ProjectError(
                f"{self._path.name!r} belongs to another mesh: it was made on one of {found[0].fingerprint}, "
                f"but this one has {fingerprint(self._view.mesh)}; choose another name for autosave"
            )
        numbered = re.compile(re.escape(self._path.stem) + r"-\d+" + re.escape(self._path.suffix))
        found += _summaries(p for p in _entries(self._path.parent) if numbered.fullmatch(p.name))
        return _newest(found, self._view.mesh)

    # --- writing ----------------------------------------------------------------------------------

    def note(self, session: Session, event: Event, *, is_gesture: bool) -> None:
        """Something has happened in a session; ``is_gesture``: a person did it in the picture."""
        self._session = session
        wants = bool(self.autosave) and (is_gesture or self._path is not None)
        if session.path is None and event.step is not None and wants:
            self._begin_file(session)
        self.tell(session)

    def save(
        self, session: Session, path: str | os.PathLike[str] | None = None, *, anew: bool = False
    ) -> Path:
        """Write everything into one file now: that of the session, or a new one if it has none it may write.

        Parameters
        ----------
        session : Session
        path : path, optional
        anew : bool
            Whether to choose a new name in any case.

        Raises
        ------
        OSError
            It can't be written; edits stay in memory.
        """
        self._session = session
        self.wait()
        try:
            if path is not None:
                written = session.save(path)
            elif session.path is not None and not session.read_only and not anew:
                written = session.save()
            else:
                written = self._save_anew(session)
        except OSError as error:
            self._problem = str(error)
            raise
        else:
            self._problem = ""
        finally:
            self.tell(session)
        return written

    def wait(self) -> None:
        """Until the file that is being made is there."""
        writing = self._writing
        if writing is not None and writing is not threading.current_thread():
            writing.join()

    def _save_anew(self, session: Session) -> Path:
        """Write a session to the first name that is free; no other widget gets the same."""
        first = self._path or self._folder / default_name(self._view.mesh)
        place, number = first, 1
        while True:
            try:
                return session.save(place, overwrite=False)
            except FileExistsError:
                number += 1
                place = first.with_name(f"{first.stem}-{number}{first.suffix}")

    def _begin_file(self, session: Session) -> None:
        """Make the file beside the work: at a million faces that takes half a second."""
        with self._lock:
            if self._writing is not None:
                return

            def write() -> None:
                try:
                    self._save_anew(session)
                    self._problem = ""
                except OSError as error:
                    self._problem = str(error)
                finally:
                    self.tell(session)
                    self._writing = None

            self._writing = threading.Thread(target=write, name="scenewidget-file")  # waited for at the end
            self._writing.start()

    def tell(self, session: Session) -> None:
        """Show how it stands with the file; for the session in use, not for one that it has replaced."""
        if session is not self._session:
            return
        ticket = next(self._tickets)  # whoever asks the session later knows better
        problem = session.file_problem or ("" if session.path is not None else self._problem)
        note = str(session.path or "")
        if session.read_only:
            state, note = "read-only", f"{note} is open read-only: {session.file_reason}"
        elif problem:
            state, note = "failed", spoken(problem)
        elif session.is_saved:
            state = "saved"
        elif self._writing not in (None, threading.current_thread()):
            state = "saving"
        else:
            state = "unsaved" if session.history or session.undone else ""
        with self._lock, self._view.hold_sync():
            if ticket < self._told:
                return
            self._told = ticket
            self._view.save_state, self._view.save_note = state, note
            if state == "failed":
                text = f"{note}. Your edits are in memory only"
                ways_out = [("Try again", "save")]
                if session.path is not None:
                    ways_out.append(("Save a copy", "copy"))
                self._put_notice("file", text, ways_out)
            elif state == "read-only":
                text = f"{note}. Your edits are in memory only"
                self._put_notice("file", text, [("Save a copy", "copy"), ("OK", "drop")])
            elif state == "saved":
                self._drop_notice("file")

    # --- notices ----------------------------------------------------------------------------------

    def choose(self, notice: str, action: str) -> None:
        """A person pressed a button of a notice."""
        known = self._notices.get(notice)
        if known is None or action not in [kind for _, kind in known["actions"]]:
            return  # pressed in another view at the same time
        if action == "restore" and self.offered is not None:
            self._restore(self.offered.path)
        elif action in ("save", "copy") and self._session is not None:
            with contextlib.suppress(OSError):  # told by the notice
                self.save(self._session, anew=action == "copy")
        if action in ("restore", "drop"):
            with self._lock:
                self._drop_notice(notice)

    def _put_notice(self, key: str, text: str, actions: list[tuple[str, str]]) -> None:
        notice = {"key": key, "text": text, "actions": [list(action) for action in actions]}
        self._notices = {**self._notices, key: notice}
        self._view.notices = list(self._notices.values())

    def _drop_notice(self, key: str) -> None:
        self._notices = {other: notice for other, notice in self._notices.items() if other != key}
        self._view.notices = list(self._notices.values())


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def _summaries(paths: Iterable[Path]) -> list[Summary]:
    found = []
    for path in paths:
        with contextlib.suppress(OSError, ProjectError):
            found.append(summary_of(path))
    return found


def _newest(summaries: Iterable[Summary], mesh: Mesh) -> Summary | None:
    ours = (summary for summary in summaries if summary.fingerprint == fingerprint(mesh))
    return max((s for s in ours if s.n_steps > 0), key=lambda s: s.last_time, default=None)


def _steps(n: int) -> str:
    return f"{n} step" if n == 1 else f"{n} steps"
