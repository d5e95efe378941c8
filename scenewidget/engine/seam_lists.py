"""Lists of the seams of each region, from which a seam is taken in constant time: for region merging.

Each seam is in the lists of both its ends, as entry 2 s in that of its first and 2 s + 1 in that of its
second end. ``head`` has the first entry of each region, −1 for none; ``after`` and ``before`` link entries.
"""

from __future__ import annotations

import numba

__all__ = ["insert", "remove"]


@numba.njit(cache=True, nogil=True)
def insert(head, after, before, region, entry):  # type: ignore[no-untyped-def]
    """Put an entry at the head of a region's list."""
    after[entry], before[entry] = head[region], -1
    if head[region] >= 0:
        before[head[region]] = entry
    head[region] = entry


@numba.njit(cache=True, nogil=True)
def remove(head, after, before, region, entry):  # type: ignore[no-untyped-def]
    """Take an entry from a region's list."""
    if before[entry] >= 0:
        after[before[entry]] = after[entry]
    else:
        head[region] = after[entry]
    if after[entry] >= 0:
        before[after[entry]] = before[entry]
