"""Graph segmentation by an adaptive threshold, on any weighted graph.

Goes in: pairs of items and their weights. Come out: labels. Felzenszwalb and Huttenlocher (2004),
IJCV 59(2); on meshes: Karpathy et al. (2013), and the segmentator of ScanNet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from scenewidget.engine.atoms import by_first_appearance
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray, ascending, taken
from scenewidget.engine.seam_lists import joined_along_seams

__all__ = ["Grown", "grown_pieces", "join_along_seams", "join_light_edges", "without_small"]


def join_light_edges(
    n_items: int,
    pairs: IntArray,
    weights: FloatArray,
    *,
    threshold: float,
    min_size: float = 0.0,
    sizes: FloatArray | None = None,
    order: IntArray | None = None,
) -> IntArray:
    """Join items along light edges while that is light for both sides.

    Edges are taken in ascending weight. Two pieces are joined if the edge's weight is at most
    ``w + threshold / size`` of each piece, w the heaviest edge that the piece was joined by so far (0 at
    first). Afterwards pieces below ``min_size`` are joined to a neighbour in the same order of edges.

    Parameters
    ----------
    n_items : int
    pairs : (n_pairs, 2) int
    weights : (n_pairs,) float
    threshold : float
        In the unit of the weights times that of the sizes; larger gives larger pieces.
    min_size : float
        In the unit of ``sizes``.
    sizes : (n_items,) float, optional
        Size of each item; 1 each by default, so that a size is a count.
    order : (n_pairs,) int, optional
        `mesh.ascending` of the weights, where the caller has it already.

    Returns
    -------
    labels : (n_items,) int32
        Dense, numbered by the first item of each piece. Ties in weight are taken in the order of the
        pairs.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.felzenszwalb import join_light_edges
    >>> pairs = np.array([[0, 1], [1, 2], [2, 3]])
    >>> join_light_edges(4, pairs, np.array([0.1, 0.9, 0.1]), threshold=0.2).tolist()
    [0, 0, 1, 1]
    """
    grown = grown_pieces(n_items, pairs, weights, threshold=threshold, sizes=sizes, order=order)
    return without_small(grown, min_size)


class Grown(NamedTuple):
    """Pieces joined along light edges, and what is left of the graph between them.

    Attributes
    ----------
    piece : (n_items,) int32
        Dense, numbered by the first item of each piece.
    sizes : (n_pieces,) float64
    first, second : (n_edges,) int32
        The pieces on both sides of each edge between two of them, in ascending weight.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.felzenszwalb import grown_pieces
    >>> pairs = np.array([[0, 1], [1, 2], [2, 3]])
    >>> grown = grown_pieces(4, pairs, np.array([0.1, 0.9, 0.1]), threshold=0.2)
    >>> grown.sizes.tolist(), grown.first.tolist(), grown.second.tolist()
    ([2.0, 2.0], [0], [1])
    """

    piece: IntArray
    sizes: FloatArray
    first: IntArray
    second: IntArray


def grown_pieces(
    n_items: int,
    pairs: IntArray,
    weights: FloatArray,
    *,
    threshold: float,
    sizes: FloatArray | None = None,
    order: IntArray | None = None,
) -> Grown:
    """What `join_light_edges` joins before it looks at sizes: several least sizes can be tried on it.

    Parameters
    ----------
    n_items, pairs, weights, threshold, sizes, order
        See `join_light_edges`.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.felzenszwalb import grown_pieces, without_small
    >>> grown = grown_pieces(3, np.array([[0, 1], [1, 2]]), np.array([0.1, 0.9]), threshold=0.2)
    >>> [without_small(grown, least).tolist() for least in (0.0, 2.0)]
    [[0, 0, 1], [0, 0, 0]]
    """
    if not threshold >= 0:
        raise ValueError(f"threshold must be at least 0, got {threshold}")
    if order is None:
        order = ascending(weights)
    size = np.ones(n_items) if sizes is None else np.array(sizes, dtype=np.float64)
    first, second = np.ascontiguousarray(taken(pairs, order).T, dtype=np.int32)
    weight = taken(weights, order).astype(np.float64)
    piece, n_pieces = _joined(first, second, weight, size, float(threshold), 0.0)
    first, second = taken(piece, first), taken(piece, second)
    is_between = first != second
    return Grown(piece, size[:n_pieces], first[is_between], second[is_between])


def without_small(grown: Grown, min_size: float) -> IntArray:
    """Pieces below a size joined to a neighbour, over edges in ascending weight.

    Parameters
    ----------
    grown : Grown
    min_size : float
        In the unit of the sizes.

    Returns
    -------
    labels : (n_items,) int32
        Dense, numbered by the first item of each piece.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.felzenszwalb import Grown, without_small
    >>> grown = Grown(np.array([0, 1, 1]), np.array([1.0, 2.0]), np.array([0]), np.array([1]))
    >>> without_small(grown, 1.0).tolist(), without_small(grown, 1.5).tolist()
    ([0, 1, 1], [0, 0, 0])
    """
    if not min_size > 0:
        return grown.piece
    nothing = np.empty(0)
    label, _ = _joined(grown.first, grown.second, nothing, grown.sizes.copy(), 0.0, float(min_size))
    return taken(label, grown.piece)


def join_along_seams(
    pairs: IntArray, weights: FloatArray, lengths: FloatArray, *, threshold: float, sizes: FloatArray
) -> IntArray:
    """Felzenszwalb's rule, but the weight between two pieces is the mean along their whole seam.

    The lightest edge between two pieces may be a leak: where a scan rounds the crease between a bowl and its
    table, a way over a few faces is smooth, but not the seam as a whole. Pieces are joined in ascending
    weight, which changes as seams grow together, while that is light for both, as in `join_light_edges`.

    Parameters
    ----------
    pairs : (n_pairs, 2) int
        Neighbouring items, each pair once.
    weights, lengths : (n_pairs,) float
        Weight of each seam, not negative, and how long it is, in any unit.
    threshold : float
        In the unit of the weights times that of the sizes.
    sizes : (n_items,) float

    Returns
    -------
    labels : (n_items,) int32
        Dense, numbered by the first item of each piece.

    References
    ----------
    Agglomeration by mean weights of borders: Bailoni et al. (2022), CVPR.

    Examples
    --------
    Two plates meet along a sharp seam with one smooth spot in it:

    >>> import numpy as np
    >>> from scenewidget.engine.felzenszwalb import join_along_seams, join_light_edges
    >>> pairs = np.array([[0, 1], [0, 2], [1, 3], [2, 3]])
    >>> weights, lengths = np.array([0.0, 1.0, 0.1, 0.0]), np.array([9.0, 9.0, 1.0, 9.0])
    >>> join_along_seams(pairs, weights, lengths, threshold=1.0, sizes=np.ones(4)).tolist()
    [0, 0, 1, 1]
    >>> join_light_edges(4, pairs, weights, threshold=1.0).tolist()
    [0, 0, 0, 0]
    """
    size, length = np.asarray(sizes, dtype=np.float64), np.asarray(lengths, dtype=np.float64)
    limits = np.divide(threshold, size, out=np.full(len(size), np.inf), where=size > 0)
    sums = (np.asarray(weights, dtype=np.float64) * length)[:, None]
    roots = joined_along_seams(pairs, sums, 0, length, limits, sizes=size, threshold=threshold)
    return by_first_appearance(roots)


@kernel
def _find(parent, i):  # type: ignore[no-untyped-def]
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


def _joined(
    first: IntArray, second: IntArray, weight: FloatArray, size: FloatArray, threshold: float, min_size: float
) -> tuple[IntArray, int]:
    """Label of each item and the number of labels; ``size`` begins with the sizes of the pieces then."""
    labels, parent, limit = np.empty(len(size), np.int32), np.empty(len(size), np.int32), np.empty(len(size))
    return labels, int(_join(first, second, weight, size, threshold, min_size, parent, limit, labels))


@kernel
def _join(  # type: ignore[no-untyped-def]
    first, second, weight, size, threshold, min_size, parent, limit, labels
):
    """Number of labels: along edges light for both sides or, with a ``min_size``, of pieces below it."""
    n = len(size)
    for i in range(n):
        parent[i] = i
        limit[i] = threshold / size[i] if size[i] > 0 else np.inf
    for e in range(len(first)):
        a, b = _find(parent, first[e]), _find(parent, second[e])
        if a == b:
            continue
        if min_size > 0:
            if size[a] >= min_size and size[b] >= min_size:
                continue
        elif weight[e] > limit[a] or weight[e] > limit[b]:
            continue
        if b < a:
            a, b = b, a
        parent[b] = a  # the lower index stays root: labels follow the order of the items
        size[a] += size[b]
        if min_size <= 0:
            limit[a] = weight[e] + (threshold / size[a] if size[a] > 0 else np.inf)
    count = 0
    for i in range(n):
        root = _find(parent, parent[i])
        if root == i:
            labels[i] = count
            size[count] = size[i]
            count += 1
        else:
            labels[i] = labels[root]
    return count
