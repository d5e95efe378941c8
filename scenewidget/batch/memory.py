"""How much memory a scan takes: expected before, measured after."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path

__all__ = ["peak", "reset_peak", "what_it_takes"]

AT_LEAST = 600_000_000  # bytes of a process that has loaded everything
A_FACE, A_FACE_JUDGED = 550, 1000  # bytes, without and with a truth to compare with
A_FACE_OF_TILES = (
    150  # bytes of a face that is only held: 151 between 2.2 and 4.4 million (benchmarks/tiles.py)
)


def what_it_takes(n_faces: int, *, is_judged: bool = False, tile_faces: int = 0) -> int:
    """Bytes that segmenting so many faces takes at its peak, with some room to spare.

    Measured on scans of up to 11 million faces.

    Parameters
    ----------
    n_faces : int
    is_judged : bool
        Whether the result is compared with a truth.
    tile_faces : int
        Of the largest tile, without its overlap, where it is segmented tile by tile; 0 where it isn't.

    Examples
    --------
    >>> what_it_takes(10_000_000) / 1e9
    6.1
    """
    if tile_faces and not is_judged and n_faces > tile_faces:
        return AT_LEAST + A_FACE_OF_TILES * n_faces + 2 * A_FACE * tile_faces  # a tile and its overlap
    return AT_LEAST + (A_FACE_JUDGED if is_judged else A_FACE) * n_faces


def reset_peak() -> None:
    """Begin to measure anew, where the system can do that; elsewhere the peak is that of the whole process.

    Examples
    --------
    >>> reset_peak()
    """
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def peak() -> int | None:
    """Most bytes that this process has held since `reset_peak`; None where nobody can tell.

    Examples
    --------
    >>> peak() is None or peak() > 1_000_000
    True
    """
    with contextlib.suppress(OSError, ValueError, IndexError):
        text = Path("/proc/self/status").read_text()
        return int(text.partition("VmHWM:")[2].split()[0]) * 1024
    with contextlib.suppress(ImportError):
        import resource

        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return int(most) * (1 if sys.platform == "darwin" else 1024)
    with contextlib.suppress(ImportError, AttributeError):
        import psutil

        return int(psutil.Process().memory_info().peak_wset)
    return None
