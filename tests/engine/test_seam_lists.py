"""Lists of seams, beside Python's own lists."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from scenewidget.engine.seam_lists import insert, remove

N_REGIONS, N_ENTRIES = 3, 8


def entries_of(head, after, region):
    found, entry = [], head[region]
    while entry >= 0:
        found.append(int(entry))
        entry = after[entry]
    return found


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, N_ENTRIES - 1), st.integers(0, N_REGIONS - 1)), max_size=40))
def test_entries_come_and_go_as_in_lists(steps):
    head, after, before = np.full(N_REGIONS, -1), np.full(N_ENTRIES, -1), np.full(N_ENTRIES, -1)
    expected, home = [[] for _ in range(N_REGIONS)], {}
    for entry, region in steps:
        if entry in home:
            remove(head, after, before, home[entry], entry)
            expected[home.pop(entry)].remove(entry)
        else:
            insert(head, after, before, region, entry)
            expected[region].insert(0, entry)
            home[entry] = region
        assert [entries_of(head, after, r) for r in range(N_REGIONS)] == expected
