"""One BLAS thread where more only wait for each other.

Eigensolvers make thousands of small BLAS calls. OpenBLAS splits each over all cores and spins until the
last has answered: on a machine with anything else to do, 13 s instead of 1.3 s at 50 000 vertices.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

__all__ = ["one_blas_thread"]

_lock = threading.Lock()
_n_inside = 0
_before: list[int] = []
_here = threading.local()


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
