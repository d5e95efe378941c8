"""How many threads the work takes, and one BLAS thread where more only wait for each other.

Eigensolvers make thousands of small BLAS calls. OpenBLAS splits each over all cores and spins until the
last has answered: on a machine with anything else to do, 13 s instead of 1.3 s at 50 000 vertices.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

__all__ = ["KNOB", "at_once", "by_parts", "n_threads", "one_blas_thread", "parts"]

KNOB = "SCENEWIDGET_THREADS"  # variable of the environment, so that processes hand it on

PART = 1 << 16  # rows whose temporaries stay in a core's cache

_lock = threading.Lock()
_n_inside = 0
_before: list[int] = []
_here = threading.local()


def n_threads() -> int:
    """Threads that one computation takes: ``SCENEWIDGET_THREADS``, or the cores that this process may use.

    No result depends on it.

    Raises
    ------
    ValueError
        The variable holds no whole number from 1 on.

    Examples
    --------
    >>> from scenewidget.engine.threads import n_threads
    >>> n_threads() >= 1
    True
    """
    given = os.environ.get(KNOB, "").strip()
    if given:
        if not (given.isdecimal() and int(given) >= 1):
            raise ValueError(
                f"{KNOB} must be a whole number from 1 on, got {given!r}; unset it to use all cores"
            )
        return int(given)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def by_parts(work: Callable[[slice], object], n: int) -> None:
    """Call ``work`` for one part of ``n`` rows after the other, on all threads.

    What is computed of each row alone is done so in half the time on one core, because temporaries of a part
    stay in its cache, and in less on several. What is in a part depends on ``n`` only.

    Parameters
    ----------
    work : callable (slice)
        Writes the result of these rows.
    n : int

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.threads import by_parts
    >>> squares = np.empty(5)
    >>> def square(rows):
    ...     squares[rows] = np.arange(5)[rows] ** 2
    >>> by_parts(square, 5)
    >>> squares.tolist()
    [0.0, 1.0, 4.0, 9.0, 16.0]
    """
    if n <= PART or n_threads() == 1:
        for part in parts(n):
            work(part)
        return
    with ThreadPoolExecutor(n_threads()) as pool:
        for _ in pool.map(work, parts(n)):
            pass


def parts(n: int, size: int = PART) -> Iterator[slice]:
    """Rows 0 to ``n`` in parts whose temporaries stay in a core's cache, or in the memory there is.

    Parameters
    ----------
    n : int
    size : int
        Rows of a part.

    Examples
    --------
    >>> from scenewidget.engine.threads import parts
    >>> [part.stop for part in parts(100_000)]
    [65536, 100000]
    """
    return (slice(start, min(start + size, n)) for start in range(0, n, size))


def at_once(*calls: Callable[[], Any]) -> list[Any]:
    """Results of calls that don't wait for each other, on all threads; the first is made by this thread.

    Parameters
    ----------
    *calls : callable ()

    Examples
    --------
    >>> from scenewidget.engine.threads import at_once
    >>> at_once(lambda: 1, lambda: "two")
    [1, 'two']
    """
    if n_threads() == 1:
        return [call() for call in calls]
    with ThreadPoolExecutor(max(1, n_threads() - 1)) as pool:
        jobs = [pool.submit(call) for call in calls[1:]]
        return [calls[0](), *(job.result() for job in jobs)]


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Within this context BLAS runs on one thread.

    May be entered from several threads at once, and within itself. Some builds of OpenBLAS keep the number
    for each thread that has ever set it, others for the process: so every thread sets its own, and sets it
    back to what the first one found when there was none inside.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.threads import one_blas_thread
    >>> with one_blas_thread():
    ...     product = np.ones((2, 2)) @ np.ones((2, 2))
    >>> product.tolist()
    [[2.0, 2.0], [2.0, 2.0]]
    """
    depth = getattr(_here, "depth", 0)
    _here.depth = depth + 1
    if depth == 0:
        _enter()
    try:
        yield
    finally:
        _here.depth = depth
        if depth == 0:
            _leave()


def _enter() -> None:
    global _n_inside, _before  # what the others found on entering is 1, not what it was before
    with _lock:
        libraries = _blas_libraries()
        if _n_inside == 0:
            _before = [library.get_num_threads() for library in libraries]
        _n_inside += 1
        for library in libraries:
            library.set_num_threads(1)


def _leave() -> None:
    global _n_inside
    with _lock:
        _n_inside -= 1
        for library, n_threads in zip(_blas_libraries(), _before):
            library.set_num_threads(n_threads)


@functools.cache
def _blas_libraries() -> list[Any]:
    return list(ThreadpoolController().select(user_api="blas").lib_controllers)
