"""From a partition of the items to segments that a person would draw.

Goes in: labels of the consensus. Come out: connected pieces (thesis 3.5), and beyond the thesis, in this
order: walls and floors made whole (`hull`), what stands out of them parted (`relief`), crumbs given to their
neighbour, and pieces of one thing joined (`furniture`).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TypeVar

import numpy as np

from scenewidget.engine.atoms import by_first_appearance
from scenewidget.engine.consensus import CoAssociation
from scenewidget.engine.furniture import join_furniture
from scenewidget.engine.hull import join_planes
from scenewidget.engine.items import Items
from scenewidget.engine.memo import Recall, compute
from scenewidget.engine.mesh import IntArray, connected_components
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.relief import separate_reliefs, separate_tints

__all__ = ["absorb_small", "connected_pieces", "finish", "tidied"]

T = TypeVar("T")


def finish(
    items: Items,
    co: CoAssociation,
    consensus: IntArray,
    *,
    planes: bool = True,
    relief: float = 0.008,
    contrast: float = 0.15,
    min_area: float = 0.02,
    furniture: float = 0.4,
    n_threads: int = 2,
    recall: Recall = compute,
    monitor: Monitor | None = None,
) -> IntArray:
    """(n_items,) int32 segments of the items, dense, from the consensus.

    Parameters
    ----------
    items : Items
    co : CoAssociation
        Of the items.
    consensus : (n_base,) int
        Label of each base segment.
    planes, relief, contrast, min_area, n_threads, recall
        See `tidied`.
    furniture : float
        Mean co-association down to which `join_furniture` joins; 1 joins none.
    monitor : Monitor, optional

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.consensus import co_association
    >>> from scenewidget.engine.finish import finish
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(4, size=2.0), np.arange(32) // 8)
    >>> co = co_association(np.array([[0, 0], [0, 0], [1, 1], [1, 1]]), items.areas)
    >>> finish(items, co, np.array([0, 1])).tolist()  # one floor
    [0, 0, 0, 0]
    >>> finish(items, co, np.array([0, 1]), planes=False).tolist()
    [0, 0, 1, 1]
    """
    pieces = connected_pieces(consensus[co.base], items.pairs)
    labels = tidied(
        items,
        pieces,
        planes=planes,
        relief=relief,
        contrast=contrast,
        min_area=min_area,
        n_threads=n_threads,
        recall=recall,
        monitor=monitor,
    )
    if furniture < 1:
        labels = _island_by_island(
            items,
            labels,
            lambda island, members, inner: join_furniture(
                island, inner, co._replace(base=co.base[members]), similarity=furniture
            ),
        )
    return labels


def tidied(
    items: Items,
    labels: IntArray,
    *,
    planes: bool,
    relief: float,
    contrast: float,
    min_area: float,
    n_threads: int = 2,
    recall: Recall = compute,
    monitor: Monitor | None = None,
) -> IntArray:
    """Pieces of one wall joined, then what stands out of it parted, then crumbs absorbed.

    Parameters
    ----------
    items : Items
    labels : (n_items,) int32
        Dense.
    planes : bool
        Whether `join_planes` joins.
    relief, contrast : float
        Least step of `separate_reliefs` and `separate_tints`; 0 parts nothing.
    min_area : float
        Of `absorb_small`, square units of the scene; 0 absorbs nothing.
    n_threads : int
        Doesn't change the result.
    recall : Recall
        Where to remember maps of walls, for other labels of the same items.
    monitor : Monitor, optional

    Returns
    -------
    labels : (n_items,) int32
        Dense.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.finish import tidied
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(4, size=2.0), np.arange(32) // 8)
    >>> options = {"planes": True, "relief": 0.0, "contrast": 0.0, "min_area": 0.0}
    >>> tidied(items, np.arange(4, dtype=np.int32), **options).tolist()  # one floor
    [0, 0, 0, 0]
    """
    monitor = monitor or SILENT

    def run(island: Items, members: IntArray, labels: IntArray) -> IntArray:
        first = int(members[0])  # names the island

        def keep(key: Hashable, make: Callable[[], T]) -> T:
            return recall((first, key), make)

        if planes:
            labels = join_planes(island, labels)
        monitor.tick()
        if relief > 0:
            labels = separate_reliefs(island, labels, step=relief, n_threads=n_threads, recall=keep)
        monitor.tick()
        if contrast > 0:
            labels = separate_tints(island, labels, contrast=contrast, n_threads=n_threads, recall=keep)
        return absorb_small(island, labels, min_area * island.scale**2) if min_area > 0 else labels

    return _island_by_island(items, labels, run)


def _island_by_island(
    items: Items, labels: IntArray, run: Callable[[Items, IntArray, IntArray], IntArray]
) -> IntArray:
    """Labels that ``run(island, members, labels)`` gives each island, as if it were alone."""
    if len(items.islands) == 1:
        return run(items, np.arange(items.n), labels)
    out = np.full(items.n, -1, dtype=np.int32)
    for members, island in items.islands:
        inner = run(island, members, by_first_appearance(labels[members]))
        out[members] = inner + int(out.max()) + 1
    return out


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

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.finish import connected_pieces
    >>> connected_pieces(np.array([0, 1, 0, -1]), np.array([[0, 1], [1, 2], [2, 3]])).tolist()
    [0, 1, 2, -1]
    """
    same = pairs[labels[pairs[:, 0]] == labels[pairs[:, 1]]]
    _, piece = connected_components(len(labels), same)
    out = np.full(len(labels), -1, dtype=np.int32)
    out[labels >= 0] = by_first_appearance(piece[labels >= 0])
    return out


def absorb_small(items: Items, labels: IntArray, min_area: float) -> IntArray:
    """Give segments below an area to the neighbour that they share most of their seam with.

    Parameters
    ----------
    items : Items
    labels : (n,) int32
        Dense.
    min_area : float
        Square metres. Segments without any neighbour stay.

    Returns
    -------
    labels : (n,) int32
        Dense.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.finish import absorb_small
    >>> from scenewidget.engine.items import patch_items
    >>> items = patch_items(square(2), np.array([0, 0, 0, 0, 0, 0, 0, 1]))
    >>> absorb_small(items, np.array([0, 1], np.int32), min_area=0.2).tolist()
    [0, 0]
    """
    labels = labels.astype(np.int64)
    while True:
        n = int(labels.max(initial=-1)) + 1
        area = np.bincount(labels[labels >= 0], items.areas[labels >= 0], n)
        borders = items.touching(labels)
        both = np.concatenate([borders.labels, borders.labels[:, ::-1]])
        length = np.tile(borders.seam_edges, 2)
        # towards larger segments only (ties by number), so that no two are given to each other
        up = (area[both[:, 1]] > area[both[:, 0]]) | (
            (area[both[:, 1]] == area[both[:, 0]]) & (both[:, 1] < both[:, 0])
        )
        up &= area[both[:, 0]] < min_area
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
