"""Faces of a mesh as a value: a brush stroke, compact, comparable, and never larger than what describes it.

Faces that lie side by side have numbers side by side in most scans, so a set is kept as ranges. A file
that claims a range of two thousand million faces costs sixteen bytes until it meets a mesh.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import IntArray

__all__ = ["FaceSet"]

MOST = 2**31  # face numbers are below


class FaceSet:
    """A set of faces that never changes, in ascending order.

    Parameters
    ----------
    faces : sequence or array of int
        In any order; a face that is named twice counts once.

    Attributes
    ----------
    ranges : (2 n,) int64
        First face and the one after the last of each run, strictly ascending.

    Raises
    ------
    TypeError
        No whole numbers; a mask of booleans isn't taken for face numbers.
    ValueError
        None at all, or negative.

    Examples
    --------
    >>> faces = FaceSet([7, 3, 4, 5, 3])
    >>> len(faces), list(faces), faces.ranges.tolist()
    (4, [3, 4, 5, 7], [3, 6, 7, 8])
    """

    def __init__(self, faces: Any) -> None:
        numbers = _whole_numbers("faces", faces)
        if len(numbers) > 1 and not (numbers[1:] > numbers[:-1]).all():
            numbers = np.sort(numbers)  # np.unique takes ten times as long
            numbers = numbers[np.concatenate([[True], numbers[1:] != numbers[:-1]])]
        if numbers[0] < 0 or numbers[-1] >= MOST:
            wrong = int(numbers[0] if numbers[0] < 0 else numbers[-1])
            raise ValueError(f"faces must hold numbers of faces, from 0, got {wrong}")
        ends = np.flatnonzero(np.diff(numbers) != 1)
        ranges = np.empty(2 * len(ends) + 2, np.int64)
        ranges[0], ranges[-1] = numbers[0], numbers[-1] + 1
        ranges[1:-1:2], ranges[2:-1:2] = numbers[ends] + 1, numbers[ends + 1]
        self.ranges = _fixed(ranges)

    @classmethod
    def from_ranges(cls, ranges: Any) -> FaceSet:
        """The set of some `ranges`; they are checked.

        Examples
        --------
        >>> list(FaceSet.from_ranges([3, 6, 7, 8]))
        [3, 4, 5, 7]
        """
        ends = _whole_numbers("ranges", ranges)
        if len(ends) % 2 or ends[0] < 0 or ends[-1] > MOST or not (ends[1:] > ends[:-1]).all():
            raise ValueError(
                "ranges must hold a first face and the one after the last of each run, ascending and apart"
            )
        faces = cls.__new__(cls)
        faces.ranges = _fixed(ends.copy())
        return faces

    def __len__(self) -> int:
        return int((self.ranges[1::2] - self.ranges[::2]).sum())

    def __iter__(self) -> Iterator[int]:
        for first, end in self.ranges.reshape(-1, 2).tolist():
            yield from range(first, end)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FaceSet) and np.array_equal(self.ranges, other.ranges)

    def __hash__(self) -> int:
        return hash(self.ranges.tobytes())

    def __repr__(self) -> str:
        first = [next(iter(self)), "…"] if len(self) > 8 else list(self)
        return f"FaceSet({len(self)} faces: {', '.join(map(str, first))})"

    def of_mesh(self, n_faces: int) -> IntArray:
        """(n,) the faces, ascending, of a mesh that has so many.

        Raises
        ------
        ValueError
            It hasn't.

        Examples
        --------
        >>> FaceSet([5, 2]).of_mesh(6)
        array([2, 5])
        """
        if self.ranges[-1] > n_faces:
            raise ValueError(
                f"there is no face {self.ranges[-1] - 1}: the mesh has {n_faces} faces, numbered from 0"
            )
        change = np.zeros(n_faces + 1, np.int8)
        change[self.ranges[::2]], change[self.ranges[1::2]] = 1, -1
        return np.flatnonzero(np.cumsum(change, dtype=np.int8))


def _whole_numbers(name: str, values: Any) -> npt.NDArray[np.int64]:
    if isinstance(values, FaceSet):
        values = values.of_mesh(int(values.ranges[-1]))
    if isinstance(values, (str, bytes)):
        raise TypeError(f"{name} must be a sequence of whole numbers, got {values!r:.60}")
    try:
        array = np.asarray(values if isinstance(values, np.ndarray) else list(values))
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a sequence of whole numbers, got {values!r:.60}") from None
    if array.ndim != 1:
        raise ValueError(f"{name} must be a list of numbers, (n,), got an array of shape {array.shape}")
    if len(array) == 0:
        raise ValueError(f"{name} is empty: it needs at least one face")
    if array.dtype == np.bool_:
        raise TypeError(f"{name} must hold numbers of faces, got a mask; write np.flatnonzero(mask)")
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name} must hold whole numbers, got {array.dtype}")
    if array.dtype == np.uint64 and array.max() >= MOST:
        raise ValueError(f"{name} must hold numbers of faces, from 0, got {array.max()}")
    return array.astype(np.int64)


def _fixed(array: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    array.flags.writeable = False
    return array
