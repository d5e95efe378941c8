"""Tables over atoms say what the labels per face say."""

import numpy as np
import pytest
from editing_strategies import do_all, edited
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.editing.session import Session

pytestmark = pytest.mark.filterwarnings("ignore:.*edits do not apply:UserWarning")


@given(edited(), st.data())
def test_a_snapshot_says_the_same_as_the_labels_per_face_at_every_step_of_a_walk(case, data):
    segmentation, edits = case
    session = Session(segmentation.mesh, segmentation)
    areas = segmentation.mesh.face_areas
    for edit in edits:
        do_all(session, [edit])
        session.go_to(data.draw(st.integers(0, len(session.edits) + len(session.undone))))
        state, expected = session.snapshot(), session.segmentation
        np.testing.assert_array_equal(state.labels[state.atoms.face_atom], expected.labels)
        assert (state.names, state.groups) == (tuple(expected.names), expected.groups)
        keep = expected.labels >= 0
        labels, n = expected.labels[keep], expected.n_segments
        area = np.bincount(labels, areas[keep], n)
        mean = np.bincount(labels, (areas * expected.confidence)[keep], n) / np.where(area > 0, area, 1)
        np.testing.assert_allclose(state.confidence, mean, atol=1e-5)
