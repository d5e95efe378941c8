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

from scenewidget.engine.mesh import IntArray

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

    def refined(self, faces: IntArray, group: IntArray, n_in_atom: IntArray) -> tuple[Atoms, IntArray]:
        """Atoms such that each of some groups of faces is a union of some.

        Parameters
        ----------
        faces : (n,) int
            Different ones, ascending.
        group : (n,) int
            Group of each, from 0. Faces that aren't named are one more group.
        n_in_atom : (n_atoms,) int
            How many faces each atom has.

        Returns
        -------
        atoms : Atoms
            The old numbers stay; of an atom that was cut, the faces that aren't named keep the number, or
            else the first of the groups. ``self`` if none was cut.
        parents : (n_new,) int
            The old atom that each new one was a part of, ascending.

        Examples
        --------
        >>> import numpy as np
        >>> from scenewidget.engine.atoms import common_refinement
        >>> atoms = common_refinement([np.array([0, 0, 0, 1])], 4)
        >>> finer, parents = atoms.refined(np.array([0, 3]), np.array([0, 0]), np.array([3, 1]))
        >>> finer.face_atom.tolist(), parents.tolist()
        ([2, 0, 0, 1], [0])
        """
        home = self.face_atom[faces].astype(np.int64)
        n_groups = int(group.max(initial=0)) + 1
        code = home * n_groups + group
        piece, n_pieces = _dense(code)
        codes: IntArray = np.zeros(n_pieces, np.int64)
        codes[piece] = code
        n_named = np.bincount(home, minlength=self.n)
        parents = codes // n_groups
        is_first = np.diff(parents, prepend=-1) != 0
        is_new = ~(is_first & (n_named == n_in_atom)[parents])  # nobody else keeps the number
        number = np.where(is_new, self.n + np.cumsum(is_new) - 1, parents)
        parents = parents[is_new]
        if len(parents) == 0:
            return self, parents
        face_atom = self.face_atom.copy()
        face_atom[faces] = number[piece]
        first_face: IntArray = np.concatenate([self.first_face, np.zeros(len(parents), np.int64)])
        moved = np.flatnonzero(is_new[piece])[::-1]
        first_face[number[piece[moved]]] = faces[moved]  # the last one written stays
        is_lost = np.zeros(self.n + len(parents), bool)
        is_lost[parents] = face_atom[self.first_face[parents]] != parents
        if is_lost.any():
            left = np.flatnonzero(is_lost[face_atom])[::-1]
            first_face[face_atom[left]] = left
        return Atoms(face_atom, first_face), parents


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
