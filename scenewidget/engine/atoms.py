"""Atoms: the common refinement of several labelings of the same faces.

Goes in: labels per face, one column a level. Comes out: an atom per face, such that every column is
constant on every atom; a labeling then is a small table, one entry an atom, instead of one a face.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import BoolArray, IntArray

__all__ = ["Atoms", "by_first_appearance", "common_refinement", "renumbered"]

TABLE_LIMIT = 1 << 25  # Codes up to here are renumbered by a table of 9 bytes each, larger ones by sorting.


@dataclass(frozen=True, eq=False)
class Atoms:
    """Which atom each face belongs to.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.atoms import common_refinement
    >>> atoms = common_refinement([np.array([0, 0, 1, 1]), np.array([0, 1, 1, 1])], 4)
    >>> atoms.face_atom.tolist(), atoms.n, atoms.table(np.array([7, 8, 9, 9])).tolist()
    ([0, 1, 2, 2], 3, [7, 8, 9])
    """

    face_atom: npt.NDArray[np.uint32]  # (n_faces,) dense, numbered from 0
    first_face: IntArray  # (n_atoms,) the first face of each atom

    @property
    def n(self) -> int:
        """Number of atoms."""
        return len(self.first_face)

    def table(self, labels: IntArray) -> IntArray | None:
        """Label of each atom, (n_atoms,); None if `labels` cuts through an atom."""
        table = labels[self.first_face]
        return table if np.array_equal(table[self.face_atom], labels) else None

    def refined(self, is_inside: BoolArray) -> tuple[Atoms, IntArray]:
        """Atoms such that a set of faces is a union of some; the atoms that it cuts keep the outside.

        Parameters
        ----------
        is_inside : (n_faces,) bool

        Returns
        -------
        atoms : Atoms
            The old numbers stay; the insides of the atoms that were cut come after them. ``self`` if
            the set cuts none.
        parents : (n_new,) int
            The old atom that each new one was a part of, ascending.
        """
        inside = np.flatnonzero(is_inside)
        home = self.face_atom[inside]
        is_cut = np.bincount(home, minlength=self.n) > 0
        is_cut &= np.bincount(self.face_atom[~is_inside], minlength=self.n) > 0
        parents = np.flatnonzero(is_cut)
        if len(parents) == 0:
            return self, parents
        number = np.full(self.n, -1, np.int64)
        number[parents] = self.n + np.arange(len(parents))
        moves = is_cut[home]
        face_atom = self.face_atom.copy()
        face_atom[inside[moves]] = number[home[moves]]
        return Atoms(face_atom, _first_faces(face_atom, self.n + len(parents))), parents


def common_refinement(columns: Iterable[IntArray], n_faces: int) -> Atoms:
    """The coarsest atoms on which every column is constant.

    Parameters
    ----------
    columns : iterable of (n_faces,) int
        Labels; -1 and above, gaps allowed.
    n_faces : int
        Faces without any column form a single atom.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.atoms import common_refinement
    >>> common_refinement([np.array([0, 0, 1, 1]), np.array([0, 1, 1, 1])], 4).face_atom.tolist()
    [0, 1, 2, 2]
    """
    face_atom: IntArray = np.zeros(n_faces, np.int64)
    n_atoms = 1 if n_faces else 0
    for labels in columns:
        codes, n_codes = _dense(labels.astype(np.int64) + 1)
        face_atom, n_atoms = _dense(face_atom * n_codes + codes)
    return Atoms(face_atom.astype(np.uint32), _first_faces(face_atom, n_atoms))


def by_first_appearance(values: npt.NDArray[Any]) -> npt.NDArray[np.int32]:
    """(n,) int32: equal values get equal numbers, 0, 1, … in the order in which they first appear.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.atoms import by_first_appearance
    >>> by_first_appearance(np.array([7, 3, 7, 5])).tolist()
    [0, 1, 0, 2]
    """
    _, first, inverse = np.unique(values, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int32)
    rank[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    return rank[inverse]


def renumbered(group: IntArray, labels: IntArray) -> npt.NDArray[np.int32]:
    """(n,) int32 the group of each label, the groups numbered 0, 1, … in their order; −1 stays −1.

    Parameters
    ----------
    group : (n_labels,) int
        Of each label.
    labels : (n,) int
        −1 for none.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.atoms import renumbered
    >>> renumbered(np.array([4, 2, 4]), np.array([0, 1, 2, -1])).tolist()
    [1, 0, 1, -1]
    """
    _, dense = np.unique(group, return_inverse=True)
    return np.append(dense, -1)[labels].astype(np.int32)  # label −1 is the last entry


def _first_faces(face_atom: IntArray, n_atoms: int) -> IntArray:
    first_face: IntArray = np.zeros(n_atoms, np.int64)
    first_face[face_atom[::-1]] = np.arange(len(face_atom))[::-1]  # the last one written stays
    return first_face


def _dense(codes: IntArray) -> tuple[IntArray, int]:
    """Codes renumbered 0, 1, … in their order, and how many there are."""
    highest = int(codes.max(initial=0))
    if highest > TABLE_LIMIT:
        distinct, dense = np.unique(codes, return_inverse=True)
        return dense, len(distinct)
    is_used = np.zeros(highest + 1, np.bool_)
    is_used[codes] = True
    number = np.cumsum(is_used, dtype=np.int64) - 1
    return number[codes], int(number[-1]) + 1
