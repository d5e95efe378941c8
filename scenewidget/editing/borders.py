"""Moving the border of one segment: grown, shrunk, without holes, smooth.

Goes in: pairs of faces that share an edge, the segment of each face, and one segment. Comes out: which faces
move, and to which segment. Nothing here knows of atoms, edits or files.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import BoolArray, IntArray, connected_components

__all__ = ["grown", "holes", "shrunk", "smoothed"]


def grown(pairs: IntArray, segment: IntArray, home: int, rings: int = 1) -> IntArray:
    """(n,) faces at most so many steps outside of a segment, ascending; unlabeled ones, too.

    Parameters
    ----------
    pairs : (n_pairs, 2) int
        Faces that share an edge.
    segment : (n_faces,) int
        Segment of each face, −1 unlabeled.
    home : int
        The segment that grows.
    rings : int
        Steps from a face to one that shares an edge with it.

    Examples
    --------
    >>> import numpy as np
    >>> chain = np.array([[0, 1], [1, 2], [2, 3]])
    >>> grown(chain, np.array([5, 5, 7, 7]), home=5)
    array([2])
    """
    inside = segment == home
    for _ in range(rings):
        ends = inside[pairs]
        inside[pairs[ends.any(axis=1)]] = True
    return np.flatnonzero(inside & (segment != home))


def shrunk(pairs: IntArray, segment: IntArray, home: int, rings: int = 1) -> tuple[IntArray, IntArray]:
    """Faces that a segment gives to the segments around it, and to which.

    Each goes to the segment with which it shares most edges; ties go to the lowest number. Where a segment
    ends because the scan does, or at unlabeled faces, it stays.

    Parameters
    ----------
    pairs, segment, home, rings
        As for `grown`.

    Returns
    -------
    faces : (n,) int
        Ascending.
    takers : (n,) int
        The new segment of each.

    Examples
    --------
    >>> import numpy as np
    >>> chain = np.array([[0, 1], [1, 2], [2, 3]])
    >>> shrunk(chain, np.array([5, 5, 7, 7]), home=5)
    (array([1]), array([7]))
    """
    after = segment.copy()
    for _ in range(rings):
        faces, takers = _takers(pairs, after, home, after == home)
        after[faces] = takers
    faces = np.flatnonzero(after != segment)
    return faces, after[faces]


def holes(pairs: IntArray, segment: IntArray, home: int, max_faces: int) -> IntArray:
    """(n,) faces of connected pieces that a segment encloses, ascending.

    Parameters
    ----------
    pairs, segment, home
        As for `grown`.
    max_faces : int
        Larger pieces are no holes; nor are those that aren't smaller than the segment.

    Examples
    --------
    >>> import numpy as np
    >>> chain = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
    >>> holes(chain, np.array([5, 5, 7, 5, 5]), home=5, max_faces=1)
    array([2])
    """
    outside = segment != home
    ends = outside[pairs]
    n_pieces, piece = connected_components(len(segment), pairs[ends.all(axis=1)])
    touched = pairs[ends[:, 0] != ends[:, 1]]
    is_hole = np.zeros(n_pieces, dtype=bool)
    is_hole[piece[touched]] = True
    size = np.bincount(piece, minlength=n_pieces)
    is_hole &= (size <= max_faces) & (size < np.count_nonzero(~outside))
    return np.flatnonzero(outside & is_hole[piece])


def smoothed(pairs: IntArray, segment: IntArray, home: int, rounds: int = 3) -> tuple[IntArray, IntArray]:
    """Faces that change sides so that the border of a segment gets shorter, and their new segments.

    Belonging to the segment, 1 or 0, spreads over neighbours for some rounds; then each face goes to the
    side that has more than half of it (Merriman, Bence and Osher 1992, Diffusion generated motion by mean
    curvature). A face with exactly half stays, unlabeled ones do, too. Faces that leave go as in `shrunk`.

    Parameters
    ----------
    pairs, segment, home
        As for `grown`.
    rounds : int
        More of them smooth larger teeth; nothing further from the border than so many faces moves.

    Returns
    -------
    faces, takers
        As of `shrunk`.

    Examples
    --------
    An island of one triangle, all of whose neighbours are in segment 7:

    >>> import numpy as np
    >>> pairs = np.array([[0, 1], [0, 2], [0, 3], [3, 6], [4, 5]])
    >>> smoothed(pairs, np.array([5, 7, 7, 7, 5, 5, 7]), home=5, rounds=1)
    (array([0]), array([7]))
    """
    share = (segment == home).astype(np.float64)
    n = len(share)
    i, j = pairs.T
    weight = 1.0 + np.bincount(pairs.ravel(), minlength=n)
    for _ in range(rounds):
        around = np.bincount(i, share[j], minlength=n) + np.bincount(j, share[i], minlength=n)
        share = (share + around) / weight
    after = segment.copy()
    after[(share > 0.5) & (segment >= 0)] = home
    leaving = (share < 0.5) & (segment == home)
    while leaving.any():
        faces, takers = _takers(pairs, after, home, leaving)
        if len(faces) == 0:
            break
        after[faces] = takers
        leaving[faces] = False
    faces = np.flatnonzero(after != segment)
    return faces, after[faces]


def _takers(pairs: IntArray, segment: IntArray, home: int, leaving: BoolArray) -> tuple[IntArray, IntArray]:
    """Those leaving faces that touch another segment, ascending, and the one that each touches most."""
    both = np.concatenate([pairs, pairs[:, ::-1]]).astype(np.int64)
    taker = segment[both[:, 1]]
    both, taker = (x[leaving[both[:, 0]] & (taker >= 0) & (taker != home)] for x in (both, taker))
    n = int(segment.max()) + 1
    code, edges = np.unique(both[:, 0] * n + taker, return_counts=True)
    face, taker = np.divmod(code, n)
    order = np.lexsort((taker, -edges, face))
    face, taker = face[order], taker[order]
    first = np.concatenate([[True], face[1:] != face[:-1]]) if len(face) else np.zeros(0, bool)
    return face[first], taker[first]
