"""Area-weighted average linkage: a tree of all granularities from one co-association matrix.

Goes in: co-association and areas. Come out: a merge tree in scipy's format, and cuts of it. Evidence
accumulation by linkage: Fred and Jain (2005), IEEE TPAMI 27(6); nearest-neighbour chains: Müllner (2011).
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.atoms import by_first_appearance
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.threads import by_parts

__all__ = ["average_linkage", "cut_tree"]


def average_linkage(C: FloatArray, weights: FloatArray, seen: FloatArray | None = None) -> FloatArray:
    """Merge tree by the mean co-association between clusters, each pair of parts weighted by its areas.

    Under partial evidence the mean goes over the pairs that somebody saw together, each as often as it was
    seen. That is a ratio of sums, so a merged cluster is never nearer to a third than the nearer of its two
    parts, and chains of nearest neighbours still find the tree.

    Parameters
    ----------
    C : (n, n) float
        Symmetric, in [0, 1].
    weights : (n,) float
        Areas; those without area count as nearly weightless.
    seen : (n, n) float, optional
        Symmetric; how many runs saw both parts. All saw all by default.

    Returns
    -------
    tree : (n − 1, 4) float64
        scipy's format: the two clusters merged, their distance 1 − mean C, the number of parts.
        Distances ascend; that of clusters of which no pair was seen is 2.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.linkage import average_linkage
    >>> C = np.array([[1.0, 0.8, 0.2], [0.8, 1.0, 0.4], [0.2, 0.4, 1.0]])
    >>> average_linkage(C, np.ones(3)).round(2).tolist()  # 0 and 1 first, then both with 2
    [[0.0, 1.0, 0.2, 2.0], [2.0, 3.0, 0.7, 3.0]]
    >>> seen = np.array([[1, 1, 0], [1, 1, 1], [0, 1, 1]])  # nobody saw 0 and 2 together
    >>> average_linkage(C, np.ones(3), seen).round(2).tolist()
    [[0.0, 1.0, 0.2, 2.0], [2.0, 3.0, 0.6, 3.0]]
    """
    n = len(C)
    if n == 1:
        return np.empty((0, 4))
    shares, distances = np.ascontiguousarray(C, dtype=np.float64).ravel(), np.empty((n, n))
    by_parts(lambda part: np.subtract(1.0, shares[part], out=distances.ravel()[part]), n * n)
    _symmetrise(distances)
    area = np.maximum(np.asarray(weights, dtype=np.float64), 1e-12 * max(float(np.max(weights)), 1e-300))
    pairs = np.empty((0, 0))
    if seen is not None:
        share = area / area.max()  # products of areas could vanish
        pairs = np.asarray(seen, dtype=np.float64) * (share[:, None] * share[None, :])
        distances[pairs == 0] = 2.0
    ends, height = np.empty((n - 1, 2), np.int64), np.empty(n - 1)
    _chain(distances, area.copy(), pairs, ends, height, np.arange(n), np.arange(n), np.empty(n, np.int64))
    order = np.argsort(height, kind="stable")
    tree = np.empty((n - 1, 4))
    _label(ends[order], height[order], np.arange(2 * n - 1), np.ones(2 * n - 1), tree)
    return tree


def cut_tree(tree: FloatArray, *, n_clusters: int | None = None, similarity: float | None = None) -> IntArray:
    """Labels of a cut through the tree.

    Parameters
    ----------
    tree : (n − 1, 4) float64
    n_clusters : int, optional
        Exactly that many clusters (at most n).
    similarity : float, optional
        Merge while the mean co-association is at least this.

    Returns
    -------
    labels : (n,) int32
        Dense, numbered by first appearance.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.linkage import average_linkage, cut_tree
    >>> C = np.array([[1.0, 0.8, 0.2], [0.8, 1.0, 0.4], [0.2, 0.4, 1.0]])
    >>> tree = average_linkage(C, np.ones(3))
    >>> cut_tree(tree, n_clusters=2).tolist(), cut_tree(tree, similarity=0.9).tolist()
    ([0, 0, 1], [0, 1, 2])
    """
    n = len(tree) + 1
    if (n_clusters is None) == (similarity is None):
        raise ValueError("give either n_clusters or similarity")
    if n_clusters is not None:
        n_merges = max(0, n - max(1, n_clusters))
    elif similarity is not None:
        n_merges = int(np.searchsorted(tree[:, 2], 1.0 - similarity + 1e-12, side="right"))
    parent = np.arange(2 * n - 1)
    for step in range(n_merges):
        parent[int(tree[step, 0])] = parent[int(tree[step, 1])] = n + step
    for node in range(n + n_merges - 1, -1, -1):  # parents have larger numbers: one pass from the top
        parent[node] = parent[parent[node]]
    return by_first_appearance(parent[:n])


def _symmetrise(D: FloatArray) -> None:
    """Mean of D and its transpose, in place and by blocks that fit the cache.

    Products that are symmetric on paper differ in the last bit, and chains would go in circles.
    """
    n, size = len(D), 256
    for top in range(0, n, size):
        for left in range(0, top + 1, size):
            one, other = D[top : top + size, left : left + size], D[left : left + size, top : top + size]
            one += other.T.copy()
            one *= 0.5
            other[:] = one.T.copy()


@kernel
def _chain(D, area, pairs, ends, height, alive, place, chain):  # type: ignore[no-untyped-def]
    """Merges by nearest-neighbour chains; D and ``pairs``, the mass of what was seen, are overwritten.

    ``alive`` holds the active clusters, compacted as they vanish, ``place`` where each stands there.
    """
    n = len(area)
    is_partial = len(pairs) > 0
    n_alive = n
    length = 0
    for step in range(n - 1):
        if length == 0:
            chain[0] = alive[0]
            length = 1
        while True:
            x = chain[length - 1]
            y, best = -1, np.inf
            if length > 1:
                y = chain[length - 2]
                best = D[x, y]
            for i in range(n_alive):
                z = alive[i]
                if z != x and D[x, z] < best:
                    best = D[x, z]
                    y = z
            if length > 1 and y == chain[length - 2]:
                break
            chain[length] = y
            length += 1
        length -= 2
        ends[step, 0], ends[step, 1], height[step] = x, y, best
        total = area[x] + area[y]
        for i in range(n_alive):
            z = alive[i]
            if z != x and z != y:
                if is_partial:
                    both = pairs[x, z] + pairs[y, z]
                    d = 2.0
                    if both > 0:
                        d = (pairs[x, z] * D[x, z] + pairs[y, z] * D[y, z]) / both
                    pairs[y, z] = pairs[z, y] = both
                else:
                    d = (area[x] * D[x, z] + area[y] * D[y, z]) / total
                # a mean lies between what it is of; where rounding puts it beside, the chain may come back
                # to where it was, grow past its end and overwrite memory
                low, high = D[x, z], D[y, z]
                if low > high:
                    low, high = high, low
                d = low if d < low else high if d > high else d
                D[y, z] = d
                D[z, y] = d
        area[y] = total
        n_alive -= 1
        alive[place[x]] = alive[n_alive]
        place[alive[n_alive]] = place[x]


@kernel
def _label(ends, height, parent, size, tree):  # type: ignore[no-untyped-def]
    """From representatives, in order of height, to scipy's cluster numbers."""
    n = len(ends) + 1
    for step in range(n - 1):
        a, b = ends[step, 0], ends[step, 1]
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        while parent[b] != b:
            parent[b] = parent[parent[b]]
            b = parent[b]
        new = n + step
        parent[a], parent[b] = new, new
        size[new] = size[a] + size[b]
        if b < a:
            a, b = b, a
        tree[step, 0], tree[step, 1] = a, b
        tree[step, 2], tree[step, 3] = height[step], size[new]
