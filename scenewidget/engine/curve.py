"""An order of places that keeps what is close together: neighbours are in the processor's cache then.

Goes in: points. Comes out: their order along a curve that fills space.
"""

from __future__ import annotations

import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray

__all__ = ["along_curve"]


def along_curve(points: FloatArray) -> IntArray:
    """(n,) order in which points that lie close mostly come close: along Morton's curve, which fills space.

    It (Morton 1966, IBM) runs through 1024³ cells; points in one cell keep their order.

    Parameters
    ----------
    points : (n, 3) float

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.curve import along_curve
    >>> along_curve(np.array([[9.0, 9, 9], [0, 0, 0], [9, 9, 8], [0, 0, 1]])).tolist()
    [1, 3, 2, 0]
    """
    low = points.min(axis=0)
    cell = (points - low) * (1023.0 / max(float((points.max(axis=0) - low).max()), 1e-300))
    code = np.zeros(len(points), dtype=np.uint64)
    for axis, bits in enumerate(cell.astype(np.uint32).T):
        for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
            bits = (bits | (bits << np.uint32(shift))) & np.uint32(mask)  # two zeros between any two bits
        code |= bits.astype(np.uint64) << np.uint64(axis)
    code = (code << np.uint64(32)) | np.arange(len(points), dtype=np.uint64)
    code.sort()
    return (code & np.uint64(0xFFFFFFFF)).astype(np.int64)
