"""From a partition of the items to segments that a person would draw.

Goes in: labels of the consensus. Come out: connected pieces (thesis 3.5), and beyond the thesis: pieces of
one plane that don't touch joined to one wall or floor, and crumbs given to their neighbour.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.atoms import by_first_appearance
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import IntArray, connected_components

__all__ = ["absorb_small", "connected_pieces", "join_planes"]


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
    seams = np.bincount(items.seam_pair, minlength=len(items.pairs))
    while True:
        n = int(labels.max(initial=-1)) + 1
        area = np.bincount(labels[labels >= 0], items.areas[labels >= 0], n)
        ends = labels[items.pairs]
        crossing = (ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1)
        both = np.concatenate([ends[crossing], ends[crossing][:, ::-1]])
        length = np.tile(seams[crossing], 2)
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


def join_planes(
    items: Items,
    labels: IntArray,
    *,
    smallest_seed: float = 1.0,
    roughness: float = 0.04,
    parallel: float = 0.9,
    reach: tuple[float, float] = (0.03, 0.05),
    behind: float = 0.12,
    share_behind: float = 0.03,
    shell: float = 0.3,
) -> IntArray:
    """Join segments that lie in the plane of a wall, floor or ceiling, whether they touch it or not.

    A seed is a large flat segment with next to nothing behind it: the hull of the room. In order of
    area each seed takes the segments, other seeds included, whose mean normal agrees with its own and
    whose root mean square distance from its plane is small.

    Parameters
    ----------
    labels : (n,) int32
        Dense.
    smallest_seed : float
        Square metres.
    roughness : float
        Largest root mean square distance of a seed's surface from its plane, metres.
    parallel : float
        Least dot product of the mean normals.
    reach : (least, most)
        How far a segment may lie from the plane, metres: 1.5 times the seed's roughness between these.
    behind, share_behind : float
        A seed has at most this share of the scene's area more than ``behind`` metres behind its plane.
    shell : float
        Fusion leaves shells behind walls that face the other way; those up to this far behind (metres)
        belong to the wall.

    Returns
    -------
    labels : (n,) int32
        Dense.
    """
    n = int(labels.max(initial=-1)) + 1
    keep = labels >= 0
    moments = items.moments.gather(labels, n)
    values, vectors = moments.principal()
    area = np.where(moments.area > 0, moments.area, 1.0)
    rms = np.sqrt(values[:, 0] / area)
    mean_normal = np.stack(
        [np.bincount(labels[keep], (items.areas * c)[keep], n) for c in items.normals.T], axis=1
    )
    length = np.linalg.norm(mean_normal, axis=1, keepdims=True)
    mean_normal = np.divide(mean_normal, length, out=np.zeros_like(mean_normal), where=length > 0)
    plane_normal = (
        vectors[:, :, 0]
        * np.where(np.einsum("ij,ij->i", vectors[:, :, 0], mean_normal) < 0, -1.0, 1.0)[:, None]
    )
    centroid = moments.centroid
    item_centroid = items.moments.centroid
    total = items.areas.sum()
    group = np.arange(n)
    is_free = np.ones(n, dtype=bool)
    for s in np.argsort(-moments.area, kind="stable"):
        if moments.area[s] < smallest_seed:
            break
        normal = plane_normal[s]
        if not is_free[s] or rms[s] > roughness or mean_normal[s] @ normal < parallel:
            continue
        depth = (item_centroid - centroid[s]) @ normal
        if items.areas[depth < -behind].sum() > share_behind * total:
            continue
        offset = (centroid - centroid[s]) @ normal
        spread = np.einsum("i,nij,j->n", normal, moments.scatter, normal) / area
        distance = np.sqrt(offset**2 + np.maximum(spread, 0.0))
        near = distance < np.clip(1.5 * rms[s], *reach)
        facing = mean_normal @ normal
        joins = is_free & near & (facing > parallel)
        joins |= is_free & (facing < -parallel) & (offset < 0) & (offset > -shell)
        joins[s] = True
        group[joins] = s
        is_free[joins] = False
    _, dense = np.unique(group, return_inverse=True)
    return np.where(keep, dense[labels], -1).astype(np.int32)
