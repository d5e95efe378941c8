"""Region merging against its definition."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.engine.region_merging import DOUBT, merged_regions
from scenewidget.engine.wall_map import Seams


def joined_by_definition(n, pairs, sums):
    """Regions after joining the surest two again and again, their sums counted anew each time."""
    region = np.arange(n)
    while True:
        best = None
        for a in np.unique(region):
            for b in np.unique(region[region > a]):
                ends = region[pairs]
                along = (ends == (a, b)).all(axis=1), (ends == (b, a)).all(axis=1)
                total = sums[along[0]].sum(axis=0) + sums[along[1]].sum(axis=0) * (-1, -1, 1, 1, 1)
                length, most = total[-1], np.abs(total[:-1]).max()
                if length > 0 and most <= length:
                    best = min(best or (np.inf,), (most / length + DOUBT / length**0.5, a, b))
        if best is None:
            return region
        region[region == best[2]] = best[1]


@given(st.integers(2, 9), st.floats(0.2, 1.0), st.integers(0, 2**32 - 1))
def test_regions_are_joined_surest_first_by_the_sums_over_their_seams(n, density, seed):
    rng = np.random.default_rng(seed)
    pairs = np.stack(np.triu_indices(n, 1), axis=1)
    pairs = pairs[rng.random(len(pairs)) < density]
    length = rng.integers(1, 20, len(pairs)).astype(float)
    steps, ridges = rng.normal(0, 1.2, (2, 2, len(pairs))) * length  # of two values
    roots = merged_regions(n, Seams(pairs, steps, ridges, length))
    expected = joined_by_definition(n, pairs, np.stack([*steps, *ridges, length], axis=1))
    np.testing.assert_array_equal(roots[:, None] == roots, expected[:, None] == expected)
