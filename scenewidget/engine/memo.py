"""Results by their keys, as many as fit into some bytes.

Goes in: a key and a result. Comes out: the result, as long as it is remembered. Forgetting changes no answer,
for whoever asks can compute it again.
"""

from __future__ import annotations

import dataclasses
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import Any, Protocol, TypeVar

import numpy as np
from scipy import sparse

from scenewidget.engine.mesh import Mesh

__all__ = ["Memo", "Recall", "compute", "n_bytes"]

T = TypeVar("T")


class Recall(Protocol):
    """Gives what is remembered under a ``key``, or computes it by ``make()`` and remembers it.

    Examples
    --------
    >>> from scenewidget.engine.memo import Memo
    >>> recall = Memo(100).within("one mesh")
    >>> recall("answer", lambda: 42), recall("answer", lambda: 43)
    (42, 42)
    """

    def __call__(self, key: Hashable, make: Callable[[], T]) -> T:
        """The value of ``make()``, of this call or an earlier one with an equal ``key``."""
        ...


def compute(key: Hashable, make: Callable[[], T]) -> T:
    """A `Recall` that remembers nothing.

    Parameters
    ----------
    key : hashable
        Not looked at.
    make : callable

    Examples
    --------
    >>> from scenewidget.engine.memo import compute
    >>> compute("answer", lambda: 42)
    42
    """
    return make()


class Memo:
    """Results by their keys; those used longest ago are forgotten first. Several threads may use one memo.

    Parameters
    ----------
    memory : float
        Bytes that all results together may take; the last one stays, however large.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.memo import Memo
    >>> memo = Memo(100)
    >>> memo.keep("zeros", np.zeros(8))
    >>> memo.keep("ones", np.ones(8))  # too much for 100 bytes: what was used longest ago is forgotten
    >>> "zeros" in memo, "ones" in memo
    (False, True)
    """

    def __init__(self, memory: float) -> None:
        self._memory = memory
        self._values: OrderedDict[Hashable, Any] = OrderedDict()
        self._sizes: dict[Hashable, int] = {}
        self._lock = threading.Lock()

    def __contains__(self, key: Hashable) -> bool:
        with self._lock:
            return key in self._values

    def __len__(self) -> int:
        with self._lock:
            return len(self._values)

    @property
    def n_bytes(self) -> int:
        """Bytes of all that is remembered."""
        with self._lock:
            return sum(self._sizes.values())

    def find(self, key: Hashable) -> Any:
        """What is remembered under a key, None if nothing is."""
        with self._lock:
            if key not in self._values:
                return None
            self._values.move_to_end(key)
            return self._values[key]

    def keep(self, key: Hashable, value: Any) -> None:
        """Remember a ``value`` under a ``key``, and forget others where the bytes don't suffice."""
        size = n_bytes(value)
        with self._lock:
            self._values[key] = value
            self._values.move_to_end(key)
            self._sizes[key] = size
            while sum(self._sizes.values()) > self._memory and len(self._values) > 1:
                oldest, _ = self._values.popitem(last=False)
                del self._sizes[oldest]

    def forget(self, which: Callable[[Hashable], bool]) -> None:
        """Forget the results for whose keys ``which`` says so."""
        with self._lock:
            for key in list(filter(which, self._values)):
                del self._values[key], self._sizes[key]

    def within(self, scope: Hashable) -> Recall:
        """A `Recall` whose keys are distinct from those of any other ``scope``."""

        def recall(key: Hashable, make: Callable[[], T]) -> T:
            known: T | None = self.find((scope, key))
            if known is not None:
                return known
            value = make()
            self.keep((scope, key), value)
            return value

        return recall

    def clear(self) -> None:
        """Forget everything."""
        with self._lock:
            self._values.clear()
            self._sizes.clear()


def n_bytes(value: Any) -> int:
    """Bytes of the arrays in a result, each array counted once, and meshes not at all.

    Parameters
    ----------
    value : object
        Arrays, sparse matrices, dataclasses, and tuples, lists and mappings of these.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.memo import n_bytes
    >>> n_bytes({"a": np.zeros(10), "b": [np.zeros(5, np.int32)]})
    100
    """
    return _n_bytes(value, set())


def _n_bytes(value: Any, seen: set[int]) -> int:
    if id(value) in seen:
        return 0
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        # the base of a view is an array; what compiled code returns has a base too, of its own kind
        return _n_bytes(value.base, seen) if isinstance(value.base, np.ndarray) else value.nbytes
    if isinstance(value, (tuple, list)):
        return sum(_n_bytes(v, seen) for v in value)
    if isinstance(value, Mapping):
        return sum(_n_bytes(v, seen) for v in value.values())
    is_record = dataclasses.is_dataclass(value) and not isinstance(value, (Mesh, type))
    if is_record or sparse.issparse(value):
        return sum(_n_bytes(v, seen) for v in vars(value).values())
    return 0
