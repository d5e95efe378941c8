"""How many clusters each connected component of a scan gets, of k in a run and of S in the consensus.

Goes in: items and the dihedral-based partition of their mesh. Comes out: a share for each component (thesis
3.1), and from a number of clusters to share out, the number for each.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from scenewidget.engine.items import Items
from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["Allocation", "allocate", "component_shares"]

Allocation = Literal["dihedral", "faces", "same", "raw"]


def component_shares(items: Items, dihedral: IntArray, allocation: Allocation = "dihedral") -> FloatArray:
    """Share of k and S of each connected component of the graph of items (thesis 3.1).

    Parameters
    ----------
    items : Items
    dihedral : (items.mesh.n_faces,) int32
        `dihedral_partition` of the items' mesh; for "raw" that of the mesh as loaded, (n_raw_faces,).
    allocation : str
        By the number of "dihedral" partitions, which tells how much there is to segment; by "faces", which
        here are the items; or the "same" for each: all of it. "raw" counts the dihedral partitions of the
        mesh as loaded, which is denser and less noisy than a simplified one (chapter 5). Each island (see
        `Items`) has all of it to share out.

    Returns
    -------
    share : (n_components,) float64
        Summing to 1 in each island; all 1 for "same".

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.allocation import component_shares
    >>> from scenewidget.engine.items import patch_items
    >>> far = square(2).vertices + 5.0
    >>> mesh = sw.Mesh([*square(2).vertices, *far], [*square(2).faces, *(square(2).faces + 9)])
    >>> items = patch_items(mesh, np.arange(16) // 8)  # one item each
    >>> component_shares(items, np.array([0] * 8 + [1] * 4 + [2] * 4)).round(2).tolist()
    [0.33, 0.67]
    """
    component = items.component
    n = int(component.max()) + 1
    if allocation == "same":
        return np.ones(n)
    if allocation == "faces":
        count = np.bincount(component, minlength=n)
    else:
        item = items.face_map if allocation == "raw" else items.item_of_face
        keep = item >= 0
        homes = np.unique(dihedral[keep].astype(np.int64) * n + component[item[keep]])
        count = np.maximum(np.bincount(homes % n, minlength=n), 1)
    island = np.zeros(n, dtype=np.int64)
    island[component] = items.island
    return np.asarray(count / np.bincount(island, count)[island])


def allocate(total: int, share: FloatArray, size: IntArray) -> IntArray:
    """Distribute a number of clusters over components.

    Parameters
    ----------
    total : int
        k or S.
    share : (n_components,) float
        Of `component_shares`.
    size : (n_components,) int
        Items in each: no component gets more clusters than items.

    Returns
    -------
    count : (n_components,) int64
        At least 1 each, so that many components can exceed the total.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.allocation import allocate
    >>> allocate(20, np.array([0.7, 0.25, 0.05]), np.array([100, 3, 100])).tolist()
    [14, 3, 1]
    """
    return np.clip(np.rint(total * share), 1, size).astype(np.int64)
