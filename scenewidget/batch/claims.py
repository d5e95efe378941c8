"""One run at a time into a folder of results, also where that is a store that has no locks.

On this machine the lock of a file ends with the process that holds it. In a store, each run keeps a small
file of its own, ``scenewidget.<run>.claim``, and writes a new number into it every few seconds. Who comes
later looks whether that number still changes: if not, its run has died. No clock is compared with another.
"""

from __future__ import annotations

import contextlib
import json
import os
import threading
import time
import uuid
from pathlib import Path
from typing import Any, Protocol

from scenewidget.batch.places import folder_at, is_url
from scenewidget.editing.files import FileLock, explain, spoken_process, this_process

__all__ = ["Claim", "claim"]

BEAT = 5.0  # seconds between two signs of life
PATIENCE = 3  # beats without a sign before a run counts as dead
SUFFIX = ".claim"


class Claim(Protocol):
    """A folder that is ours."""

    @property
    def is_lost(self) -> bool:
        """Whether somebody else has taken it since."""
        ...

    def release(self) -> None:
        """Give it free."""
        ...


def claim(out: str) -> Claim:
    """Take a folder of results for a run; it is made if missing.

    Parameters
    ----------
    out : str
        Path or URL.

    Raises
    ------
    ValueError
        Another run is writing there.
    OSError
        It can't be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ours = claim(folder)
    ...     ours.is_lost
    ...     ours.release()
    False
    """
    return _InStore(out) if is_url(out) else _OnDisk(Path(out))


def _refusal(out: str, holder: str) -> ValueError:
    return ValueError(f"{out!r} is being written by {holder}; wait for it, or choose another folder")


class _OnDisk:
    is_lost = False

    def __init__(self, folder: Path) -> None:
        made = [place for place in (folder, *folder.parents) if not place.exists()]
        if os.path.lexists(folder) and not folder.is_dir():
            what = "a file" if folder.exists() else "a link to nowhere"
            raise NotADirectoryError(
                f"out must be a folder, and {str(folder)!r} is {what}; choose another place"
            )
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = FileLock(folder / "scenewidget")
            holder = self._lock.acquire()
        except OSError as error:
            raise explain(error, folder) from error
        if holder:
            raise _refusal(str(folder), holder)
        self._made = made

    def release(self) -> None:
        """Give it free; folders that were made for nothing go."""
        self._lock.release()
        with contextlib.suppress(OSError):  # the first that holds something
            for place in self._made:
                place.rmdir()


class _InStore:
    def __init__(self, out: str) -> None:
        self._folder: Any = folder_at(out)
        self._name = f"scenewidget.{uuid.uuid4().hex[:12]}{SUFFIX}"
        self._n_beats = 0
        self._over = threading.Event()
        self.is_lost = False
        try:
            self._write()
        except Exception as error:  # every store has kinds of its own
            why = str(error) or type(error).__name__
            raise OSError(f"can't write {out!r}: {why}; choose another place") from error
        self._thread = threading.Thread(target=self._beat, name="scenewidget-claim", daemon=True)
        self._thread.start()
        try:
            holder = self._living()
        except BaseException:
            self.release()
            raise
        if holder:
            self.release()
            raise _refusal(out, holder)

    def release(self) -> None:
        """Give it free."""
        self._over.set()
        self._thread.join()
        with contextlib.suppress(Exception):  # the store may be gone
            self._folder.remove(self._name)

    def _living(self) -> str:
        """Who else is writing there, "" if nobody; what dead runs have left is removed."""
        before = self._others()
        for _ in range(PATIENCE):
            if not before:
                return ""
            time.sleep(BEAT)
            now = self._others()
            alive = [text for name, text in now.items() if before.get(name) != text]
            if alive:
                return spoken_process("another run", alive[0])
            before = now
        for name in before:
            self._folder.remove(name)
        return ""

    def _others(self) -> dict[str, str]:
        names = [n for n in self._folder.names() if n.endswith(SUFFIX) and n != self._name]
        texts = {name: self._folder.read(name) for name in names}
        return {name: text for name, text in texts.items() if text is not None}

    def _beat(self) -> None:
        while not self._over.wait(BEAT):
            with contextlib.suppress(Exception):  # one that doesn't arrive is no harm, the next one may
                if self._folder.read(self._name) is None:  # taken for dead, as after a long sleep
                    self.is_lost = True
                    return
                self._write()

    def _write(self) -> None:
        self._n_beats += 1
        self._folder.write(self._name, json.dumps({**this_process(), "beat": self._n_beats}))
