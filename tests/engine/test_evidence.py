from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.engine.evidence import agreement_of_groups


@st.composite
def spread_parts(draw):
    """Keys of parts, and entries (weight, part, group): a part may lie in several groups."""
    n_parts, n_runs, n_groups = draw(st.integers(1, 6)), draw(st.integers(1, 4)), draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    keys = rng.integers(-1, 3, (n_parts, n_runs))
    share = rng.random((n_parts, n_groups)) * (rng.random((n_parts, n_groups)) < 0.7)
    part, group = np.nonzero(share)
    return keys, share, share[part, group], part, group


@given(spread_parts())
def test_mean_agreement_matches_its_definition(given_parts):
    keys, share, weights, part, group = given_parts
    n_parts, n_groups = share.shape
    together = np.array(
        [[np.mean((keys[i] == keys[j]) & (keys[i] >= 0)) for j in range(n_parts)] for i in range(n_parts)]
    )
    mass = np.where(share.sum(axis=0) > 0, share.sum(axis=0), np.inf)
    between, with_groups = agreement_of_groups(keys, weights, part, group, n_groups, np.arange(n_parts))
    np.testing.assert_allclose(between, share.T @ together @ share / np.outer(mass, mass), atol=1e-6)
    np.testing.assert_allclose(with_groups, together @ share / mass, atol=1e-6)
