"""Processes to be killed in the middle of their work, begun in the same way on every platform.

Never by a fork of the tests themselves, which have threads: a small server that has imported what they need
forks them, or, where there is none, a new Python is started.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import sys
from collections.abc import Callable
from typing import Any
from unittest.mock import patch

_has_server = "forkserver" in multiprocessing.get_all_start_methods()
_context = multiprocessing.get_context("forkserver" if _has_server else "spawn")


def _start_server() -> None:
    """The server, if it isn't there yet, with all that takes long to import."""
    from multiprocessing.forkserver import ensure_running

    _context.set_forkserver_preload(["attacks", "pytest", "scipy.sparse.csgraph"])
    with patch.dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)):  # Python 3.11 doesn't hand it on
        ensure_running()


class Mortal:
    """A process that runs ``work(*arguments, tell)`` and tells things by ``tell.send``."""

    def __init__(self, work: Callable[..., None], *arguments: Any) -> None:
        if _has_server:
            _start_server()
        self._receive, tell = _context.Pipe(duplex=False)
        self._process = _context.Process(target=work, args=(*arguments, tell), daemon=True)
        self._process.start()
        tell.close()

    def hear(self) -> Any:
        """What it tells next; EOFError if it ended instead."""
        return self._receive.recv()

    def heard(self) -> list[Any]:
        """What it has told that wasn't asked for yet, without waiting."""
        told = []
        with contextlib.suppress(EOFError):
            while self._receive.poll():
                told.append(self._receive.recv())
        return told

    def end(self) -> tuple[list[Any], int]:
        """What it told until it ended by itself, and its exit code."""
        told = []
        with contextlib.suppress(EOFError):  # also of a message that was cut off
            while True:
                told.append(self._receive.recv())
        self._process.join()
        self._receive.close()
        return told, self._process.exitcode or 0

    def stop(self) -> None:
        """Kill it, if it is still there."""
        self._process.kill()

    def kill(self) -> list[Any]:
        """Kill it; what it told before. It must not have failed by itself."""
        self.stop()
        told, code = self.end()
        assert code < 0, "the process failed by itself"
        return told
