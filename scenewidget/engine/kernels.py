"""Loops that are compiled: once on a machine, if it lets us remember them, else once a process.

Goes in: a function of plain loops over arrays. Comes out: the same as machine code, compiled when it is first
called.

What numpy says in a word (slices that are set, ``full``, sorts, fancy indices) takes seconds to compile, so
kernels say it in loops, over arrays that their caller made: each of one dtype, contiguous, and all of them
either for writing or not, for every combination is compiled for itself.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import numba
from numba.core import event, sigutils
from numba.core.caching import FunctionCache

__all__ = ["compiling", "kernel"]


def kernel(function: Callable[..., Any] | None = None, *, allocates: bool = False, **options: Any) -> Any:
    """Decorator: compile a function on its first call, and remember it on disk where that is possible.

    It holds no lock while it runs, and divides by zero as numpy does. Where nothing can be written (a
    package that was installed for all, a full disk) or what was written can't be read (a process was
    killed), it compiles without saying anything.

    Parameters
    ----------
    function : callable, optional
    allocates : bool
        Whether it makes arrays. Others take no part in counting who holds an array, which costs more than
        the work where one small kernel calls another.
    **options
        Of ``numba.njit``.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.kernels import kernel
    >>> @kernel
    ... def total(values):
    ...     out = 0.0
    ...     for i in range(len(values)):
    ...         out += values[i]
    ...     return out
    >>> total(np.ones(3))
    3.0
    """
    if function is None:
        return lambda function: kernel(function, allocates=allocates, **options)
    njit: Any = numba.njit  # its types don't know all options
    options |= {"nogil": True, "no_cfunc_wrapper": True, "error_model": "numpy", "_nrt": allocates}
    dispatcher = njit(**options)(function)
    with contextlib.suppress(RuntimeError, OSError):  # no folder that can be written
        # what njit(cache=True) does, but that errors of its cache stop the call
        dispatcher._cache = _Cache(function)  # type: ignore[no-untyped-call]
    return dispatcher


@contextlib.contextmanager
def compiling(heard: Callable[[], None]) -> Iterator[None]:
    """Within this context, ``heard()`` is called whenever a kernel must be compiled, before it is.

    Parameters
    ----------
    heard : callable ()
        Called from the thread that compiles, which keeps all others from compiling meanwhile.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.kernels import compiling, kernel
    >>> double = kernel(lambda x: 2 * x)
    >>> times = []
    >>> with compiling(lambda: times.append(1)):
    ...     double(1), double(2)
    (2, 4)
    >>> times
    [1]
    """
    with event.install_listener("numba:compile", _Listener(heard)):
        yield


class _Listener(event.Listener):
    def __init__(self, heard: Callable[[], None]) -> None:
        self._heard = heard

    def on_start(self, event: Any) -> None:
        self._heard()

    def on_end(self, event: Any) -> None:
        pass


class _Cache(FunctionCache):
    """Numba's cache on disk; what can't be read or written counts as not there."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What was compiled for a signature, None if there is nothing."""
        try:
            found = super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except Exception:  # a file cut off, of another version, not ours: unpickling it may raise anything
            with contextlib.suppress(OSError):
                self.flush()  # type: ignore[no-untyped-call]
            return None
        wanted, _ = sigutils.normalize_signature(sig)  # type: ignore[no-untyped-call]
        # two processes that began at once may have written different things under one name
        return found if found is not None and tuple(found.signature.args) == tuple(wanted) else None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Remember what was compiled, if that is possible."""
        with contextlib.suppress(Exception):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
