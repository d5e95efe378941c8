from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.engine.evidence import agreement_behind, agreement_of_groups, calibrated, same_thing


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


def test_the_probability_rises_from_almost_none_to_almost_sure():
    p = same_thing(np.linspace(0, 1, 50))
    assert (np.diff(p) > 0).all()
    assert p[0] == pytest.approx(0.0, abs=0.02)
    assert p[-1] == pytest.approx(1.0, abs=0.02)


def test_confidence_rises_with_the_agreement_and_leads_back_to_it():
    agreement = np.linspace(0, 1, 101)
    confidence = calibrated(agreement)
    assert (np.diff(confidence) > 0).all()
    assert 0 <= confidence[0] < confidence[-1] <= 1
    np.testing.assert_allclose(agreement_behind(confidence), agreement, atol=1e-12)
