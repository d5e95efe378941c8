"""Graph segmentation by an adaptive threshold, on any weighted graph.

Goes in: pairs of items and their weights. Come out: labels. Felzenszwalb and Huttenlocher (2004),
IJCV 59(2); on meshes: Karpathy et al. (2013), and the segmentator of ScanNet.
"""

from __future__ import annotations

import numba
import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["join_light_edges"]


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
        ``np.argsort(weights, kind="stable")`` where the caller has it already.

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
    if not threshold >= 0:
        raise ValueError(f"threshold must be at least 0, got {threshold}")
    if order is None:
        order = np.argsort(weights, kind="stable")
    size = np.ones(n_items) if sizes is None else np.array(sizes, dtype=np.float64)
    first = np.ascontiguousarray(pairs[:, 0][order], dtype=np.int32)
    second = np.ascontiguousarray(pairs[:, 1][order], dtype=np.int32)
    weight = np.ascontiguousarray(weights[order], dtype=np.float64)
    return _join(first, second, weight, size, float(threshold), float(min_size))  # type: ignore[no-any-return]


@numba.njit(cache=True, nogil=True)
def _find(parent, i):  # type: ignore[no-untyped-def]
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@numba.njit(cache=True, nogil=True)
def _join(first, second, weight, size, threshold, min_size):  # type: ignore[no-untyped-def]
    n = len(size)
    parent = np.arange(n, dtype=np.int32)
    limit = np.empty(n)
    for i in range(n):
        limit[i] = threshold / size[i] if size[i] > 0 else np.inf
    for smallest in (False, True):  # first by weight, then pieces that are too small
        for e in range(len(first)):
            a, b = _find(parent, first[e]), _find(parent, second[e])
            if a == b:
                continue
            if smallest:
                if size[a] >= min_size and size[b] >= min_size:
                    continue
            elif weight[e] > limit[a] or weight[e] > limit[b]:
                continue
            if b < a:
                a, b = b, a
            parent[b] = a  # the lower index stays root: labels follow the order of the items
            size[a] += size[b]
            limit[a] = weight[e] + (threshold / size[a] if size[a] > 0 else np.inf)
    labels = np.empty(n, dtype=np.int32)
    count = 0
    for i in range(n):
        root = _find(parent, i)
        if root == i:
            labels[i] = count
            count += 1
        else:
            labels[i] = labels[root]
    return labels
