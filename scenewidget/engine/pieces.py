"""Pieces: base segments within segments, and what can be measured where two of them touch.

Goes in: a mesh, its labels, and its base segments. Comes out: a small graph with the moments of each piece,
and the length of each seam between two. What `engine.doubt` says is read from it and from the keys of the
ensemble, so a project that was opened again says the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenewidget.engine.items import find_bridges
from scenewidget.engine.mesh import (
    BoolArray,
    FloatArray,
    IntArray,
    Mesh,
    face_adjacency,
    unique_codes,
)
from scenewidget.engine.moments import Moments, group_moments
from scenewidget.engine.scale import scene_scale

__all__ = ["Pieces", "close_borders", "make_pieces"]

BRIDGE = 0.06  # times the scale: faces at borders this near to each other touch, as in `items`


@dataclass(frozen=True, eq=False)
class Pieces:
    """A graph of pieces of surface, some thousands at a million faces.

    Attributes
    ----------
    labels : (n_faces,) int32
        What the segments were made of; the same array, not a copy.
    face_piece : (n_faces,) int32
        Piece of each face; −1 where it has no segment or no base segment.
    first_face : (n,) int64
        A face of each.
    base, segment : (n,) int32
        Base segment and segment of each piece; no two pieces have both in common.
    n_faces : (n,) int64
        Faces of each.
    moments : Moments
        Of each.
    vectors : (n, 3) float64
        Sum of normal times area, m².
    pairs : (n_pairs, 2) int32
        Pieces that touch, each pair once, smaller first, in lexicographic order. Fragments of a scan that lie
        within 6 cm of each other (less in a small scene) touch.
    length : (n_pairs,) float64
        Of the common border, metres.
    scale : float
        Metres in a unit of the scene, see `scale.scene_scale`.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> make_pieces(mesh, left, left)
    Pieces(2 pieces, 1 seams)
    """

    labels: IntArray
    face_piece: IntArray
    first_face: IntArray
    base: IntArray
    segment: IntArray
    n_faces: IntArray
    moments: Moments
    vectors: FloatArray
    pairs: IntArray
    length: FloatArray
    scale: float

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __repr__(self) -> str:
        return f"Pieces({self.n} pieces, {len(self.pairs)} seams)"

    @property
    def n(self) -> int:
        """Number of pieces."""
        return len(self.base)

    @property
    def normals(self) -> FloatArray:
        """(n, 3) unit mean normals; zero where they cancel."""
        size = np.linalg.norm(self.vectors, axis=1, keepdims=True)
        return np.asarray(np.divide(self.vectors, size, out=np.zeros_like(self.vectors), where=size > 0))


def make_pieces(
    mesh: Mesh,
    labels: IntArray,
    base: IntArray,
    *,
    scale: float | None = None,
) -> Pieces:
    """The graph of pieces of a segmentation.

    Parameters
    ----------
    mesh : Mesh
    labels, base : (n_faces,) int
        Segment and base segment of each face, −1 for none.
    scale : float, optional
        Metres in a unit of the scene; by default `scale.scene_scale`.

    Returns
    -------
    Pieces
        Numbered by base segment, then segment.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> make_pieces(mesh, left, left).length.tolist()
    [1.0]
    """
    scale = scene_scale(mesh) if scale is None else scale
    keep = (labels >= 0) & (base >= 0)
    n_labels = int(labels.max(initial=-1)) + 1
    code = base[keep].astype(np.int64) * n_labels + labels[keep]
    codes, index = unique_codes(code, (int(base.max(initial=-1)) + 1) * n_labels)
    n = len(codes)
    face_piece = np.full(mesh.n_faces, -1, dtype=np.int32)
    face_piece[keep] = index
    first_face = np.zeros(n, dtype=np.int64)
    first_face[index[::-1]] = np.flatnonzero(keep)[::-1]
    vectors = 0.5 * np.stack([np.bincount(index, v[keep], n) for v in mesh.face_vectors.T], axis=1)
    pairs, length = _seams(mesh, face_piece, n, face_adjacency(mesh), close_borders(mesh, scale))
    return Pieces(
        labels,
        face_piece,
        first_face,
        (codes // max(n_labels, 1)).astype(np.int32),
        (codes % max(n_labels, 1)).astype(np.int32),
        np.bincount(index, minlength=n),
        group_moments(mesh, face_piece, n),
        vectors.astype(np.float64),
        pairs,
        length,
        scale,
    )


def close_borders(mesh: Mesh, scale: float) -> IntArray:
    """(n, 2) int32 faces at borders of different fragments so near to each other that they touch.

    Like the neighbours of its faces, the mesh keeps them: other labels need no other ones.

    Parameters
    ----------
    mesh : Mesh
    scale : float
        Metres in a unit of the scene.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.pieces import close_borders
    >>> one = square(1, size=0.03)
    >>> mesh = sw.Mesh([*one.vertices, *(one.vertices + [0.031, 0, 0])], [*one.faces, *(one.faces + 4)])
    >>> close_borders(mesh, 1.0).tolist()
    [[0, 2], [0, 3]]
    """
    known = mesh._close_borders
    if scale not in known:
        known[scale] = find_bridges(mesh, face_adjacency(mesh), BRIDGE * scale)
    return known[scale]


def _seams(
    mesh: Mesh, piece: IntArray, n: int, adjacency: IntArray, bridges: IntArray
) -> tuple[IntArray, FloatArray]:
    """Pairs of pieces that touch, and for how long."""
    shared = adjacency[_crosses(piece, adjacency)]
    bridges = bridges[_crosses(piece, bridges)]
    # a bridge stands for a side of an equilateral triangle of the area of the smaller face
    across = 1.52 * np.sqrt(np.minimum(*mesh.face_areas[bridges].T)) if len(bridges) else np.zeros(0)
    lengths = np.concatenate([mesh.seam_lengths(shared), across])
    ends = np.sort(piece[np.concatenate([shared, bridges])], axis=1).astype(np.int64)
    codes, index = np.unique(ends[:, 0] * n + ends[:, 1], return_inverse=True)
    pairs = np.stack([codes // max(n, 1), codes % max(n, 1)], axis=1).astype(np.int32)
    return pairs, np.bincount(index, lengths, len(codes)).astype(np.float64)


def _crosses(piece: IntArray, face_pairs: IntArray) -> BoolArray:
    ends = piece[face_pairs]
    return np.asarray((ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1))
