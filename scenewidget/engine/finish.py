"""From a partition of the items to segments that a person would draw.

Goes in: labels of the consensus. Come out: connected pieces (thesis 3.5), and beyond the thesis, crumbs given
to their neighbour. What makes walls and floors whole is in `hull`, what parts a carpet from its floor in
`relief`.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.atoms import by_first_appearance
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import IntArray, connected_components

__all__ = ["absorb_small", "connected_pieces"]


def connected_pieces(labels: IntArray, pairs: IntArray) -> IntArray:
    """Split every label into its connected pieces (thesis 3.5).

    Parameters
    ----------
    labels : (n,) int
        −1 stays −1.
    pairs : (n_pairs, 2) int

    Returns
    -------
    pieces : (n,) int32
        Dense, numbered by first appearance.
    """
    same = pairs[labels[pairs[:, 0]] == labels[pairs[:, 1]]]
    _, piece = connected_components(len(labels), same)
    out = np.full(len(labels), -1, dtype=np.int32)
    out[labels >= 0] = by_first_appearance(piece[labels >= 0])
    return out


def absorb_small(items: Items, labels: IntArray, smallest: float) -> IntArray:
    """Give segments below an area to the neighbour that they share most of their seam with.

    Parameters
    ----------
    items : Items
    labels : (n,) int32
        Dense.
    smallest : float
        Square metres. Segments without any neighbour stay.

    Returns
    -------
    labels : (n,) int32
        Dense.
    """
    labels = labels.astype(np.int64)
    while True:
        n = int(labels.max(initial=-1)) + 1
        area = np.bincount(labels[labels >= 0], items.areas[labels >= 0], n)
        ends = labels[items.pairs]
        crossing = (ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1)
        both = np.concatenate([ends[crossing], ends[crossing][:, ::-1]])
        length = np.tile(items.seam_edges[crossing], 2)
        # towards larger segments only (ties by number), so that no two are given to each other
        up = (area[both[:, 1]] > area[both[:, 0]]) | (
            (area[both[:, 1]] == area[both[:, 0]]) & (both[:, 1] < both[:, 0])
        )
        up &= area[both[:, 0]] < smallest
        if not up.any():
            break
        code, inverse = np.unique(both[up, 0] * n + both[up, 1], return_inverse=True)
        total = np.bincount(inverse, length[up])
        source, target = code // n, code % n
        order = np.lexsort((target, -area[target], -total, source))
        chosen = order[np.concatenate([[True], source[order][1:] != source[order][:-1]])]
        _, group = connected_components(n, np.stack([source[chosen], target[chosen]], axis=1))
        labels = np.where(labels >= 0, group[labels].astype(np.int64), -1)
    return labels.astype(np.int32)
