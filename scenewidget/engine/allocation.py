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

Allocation = Literal["dihedral", "faces", "same"]


def component_shares(items: Items, dihedral: IntArray, allocation: Allocation = "dihedral") -> FloatArray:
    """Share of k and S of each connected component of the graph of items (thesis 3.1).

    Parameters
    ----------
    items : Items
    dihedral : (items.mesh.n_faces,) int32
        `dihedral_partition` of the items' mesh.
    allocation : str
        By the number of "dihedral" partitions, which tells how much there is to segment; by "faces", which
        here are the items; or the "same" for each: all of it.

    Returns
    -------
    share : (n_components,) float64
        Summing to 1; all 1 for "same".
    """
    component = items.component
    n = int(component.max()) + 1
    if allocation == "same":
        return np.ones(n)
    if allocation == "faces":
        count = np.bincount(component, minlength=n)
    else:
        keep = items.item_of_face >= 0
        home = np.zeros(int(dihedral.max()) + 1, dtype=np.int64)
        home[dihedral[keep]] = component[items.item_of_face[keep]] + 1
        count = np.bincount(home, minlength=n + 1)[1:]
        count = np.maximum(count, 1)
    return np.asarray(count / count.sum())


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
    """
    return np.clip(np.rint(total * share), 1, size).astype(np.int64)
