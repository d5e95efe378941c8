"""Atoms: the common refinement of several labellings of the same faces.

Goes in: labels per face, one column a level. Comes out: an atom per face, such that every column is
constant on every atom; a labelling then is a small table, one entry an atom, instead of one a face.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import IntArray

__all__ = ["Atoms", "common_refinement"]

TABLE_LIMIT = (
    1 << 25
)  # codes up to here are renumbered through a table of 1 byte + 4 bytes each, not by sorting


@dataclass(frozen=True, eq=False)
class Atoms:
    """Which atom each face belongs to."""

    face_atom: npt.NDArray[np.uint32]  # (n_faces,) dense, numbered from 0
    first_face: IntArray  # (n_atoms,) one face of each atom

    def table(self, labels: IntArray) -> IntArray | None:
        """Label of each atom, (n_atoms,); None if `labels` cuts through an atom."""
        table = labels[self.first_face]
        return table if np.array_equal(table[self.face_atom], labels) else None


def common_refinement(columns: Iterable[IntArray], n_faces: int) -> Atoms:
    """The coarsest atoms on which every column is constant.

    Parameters
    ----------
    columns : iterable of (n_faces,) int
        Labels; -1 and above, gaps allowed.
    n_faces : int
        Faces without any column form a single atom.
    """
    face_atom: IntArray = np.zeros(n_faces, np.int64)
    n_atoms = 1 if n_faces else 0
    for labels in columns:
        codes, n_codes = _dense(labels.astype(np.int64) + 1)
        face_atom, n_atoms = _dense(face_atom * n_codes + codes)
    first_face: IntArray = np.zeros(n_atoms, np.int64)
    first_face[face_atom[::-1]] = np.arange(n_faces)[::-1]  # the last one written stays
    return Atoms(face_atom.astype(np.uint32), first_face)


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
