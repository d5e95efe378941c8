"""What stands in a room: pieces of one thing joined, on whose parts the ensemble half agrees.

Goes in: labels in which the hull of the room is whole, and how often the runs put base segments together.
Comes out: labels with fewer pieces of furniture. One cut of the merge tree that keeps a door apart from its
wall leaves a sofa in pieces. Not in the thesis.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from scenewidget.engine.atoms import renumbered
from scenewidget.engine.consensus import CoAssociation
from scenewidget.engine.hull import segment_planes
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["join_furniture"]


def join_furniture(
    items: Items,
    labels: IntArray,
    co: CoAssociation,
    *,
    similarity: float = 0.4,
    touch: tuple[float, float] = (0.25, 0.9),
) -> IntArray:
    """Join touching segments that are no piece of the room's hull, those that agree most first.

    Parameters
    ----------
    items : Items
    labels : (n_items,) int32
        Dense, −1 for items in no segment.
    co : CoAssociation
        Of the items.
    similarity : float
        Least mean co-association of two segments that are joined, by area.
    touch : (least, most)
        Their common seam, as a share of the seams with all others of the one that has fewer. Less, and they
        hardly touch; more, and one stands on the other, as a cup on a table.

    Returns
    -------
    labels : (n_items,) int32
        Dense, in the order of the labels given.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.consensus import co_association
    >>> from scenewidget.engine.furniture import join_furniture
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.array([0, 0, 0, 0, 1, 1, 1, 1]))
    >>> co = co_association(np.array([[0, 0], [0, 1]]), items.areas)  # half of the runs put them together
    >>> join_furniture(items, np.arange(2), co, similarity=0.5, touch=(0.0, 1.0)).tolist()
    [0, 0]
    """
    borders = items.touching(labels)
    touching, index = np.unique(borders.labels, return_inverse=True)  # the others can't join anything
    n = len(touching)
    if n == 0:
        return labels
    index = index.reshape(-1, 2)
    edges = borders.seam_edges.astype(np.float64)
    seam = sparse.coo_array((edges, tuple(index.T)), shape=(n, n)).toarray()  # dense (n, n)
    seam += seam.T
    group = np.where(np.isin(labels, touching), np.searchsorted(touching, labels), -1)
    area = np.maximum(np.bincount(group[group >= 0], items.areas[group >= 0], n), 1e-300)
    agreement = co.between(group, items.areas, n) / np.outer(area, area)
    is_free = ~segment_planes(items, labels).is_hull[touching]
    group, total = np.arange(n), seam.sum(axis=1)

    def candidates(rows: slice) -> FloatArray:
        """Agreement of the pairs that may join, −1 for all others."""
        fewer = np.minimum(total[rows, None], total)
        fits = (seam[rows] > 0) & (seam[rows] >= touch[0] * fewer) & (seam[rows] <= touch[1] * fewer)
        fits &= is_free[rows, None] & is_free & (agreement[rows] >= similarity)
        return np.where(fits, agreement[rows], -1.0)

    value = candidates(slice(None))
    best = value.max(axis=1)
    while best.max() >= 0:
        i = int(best.argmax())
        j = int(value[i].argmax())
        both = (area[i] * agreement[i] + area[j] * agreement[j]) / (area[i] + area[j])
        agreement[i], agreement[:, i] = both, both
        area[i] += area[j]
        seam[i] += seam[j]
        seam[:, i] = seam[i]
        seam[i, i] = seam[j] = seam[:, j] = 0.0
        total[i], total[j] = seam[i].sum(), 0.0
        group[group == j] = i
        changes = (value[:, i] >= 0) | (value[:, j] >= 0) | (seam[i] > 0)  # only pairs with either change
        changes[[i, j]] = True
        value[j] = value[:, j] = -1.0
        value[i] = value[:, i] = candidates(slice(i, i + 1))
        best[changes] = value[changes].max(axis=1)
    joined = np.arange(int(labels.max()) + 1)
    joined[touching] = touching[group]
    return renumbered(joined, labels)
