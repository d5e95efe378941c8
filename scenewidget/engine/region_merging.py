"""Region merging: regions of a map are joined as long as there is no step between them, the surest first.

Goes in: regions, and the sums along their seams. Comes out: which regions are one. Not in the thesis.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import IntArray
from scenewidget.engine.seam_lists import joined_along_seams
from scenewidget.engine.wall_map import Seams

__all__ = ["merged_regions"]

DOUBT = 2.5  # A seam of n cells counts as DOUBT / √n steps higher, so that long seams are decided first.


def merged_regions(n_regions: int, seams: Seams) -> IntArray:
    """(n_regions,) the root of each region after joining those whose seam has no step, the surest first.

    Sure is a small mean along a long seam. Sums over seams add up when regions are joined, so the mean is
    always that of all cells between two regions.

    Parameters
    ----------
    n_regions : int
    seams : Seams
        In units of what counts as a step: a mean of at most 1 is none.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.region_merging import merged_regions
    >>> from scenewidget.engine.wall_map import Seams
    >>> steps, ridges = np.array([[0.5, 9.0]]), np.zeros((1, 2))
    >>> seams = Seams(np.array([[0, 1], [1, 2]]), steps, ridges, np.array([3.0, 3.0]))
    >>> merged_regions(3, seams).tolist()  # mean steps of 1/6 and 3
    [1, 1, 2]
    """
    sums = np.concatenate([seams.step, seams.ridge]).T
    n_steps = len(seams.step)
    return joined_along_seams(seams.pairs, sums, n_steps, seams.length, np.ones(n_regions), doubt=DOUBT)
