"""Sets of faces: as Python's sets, compact, and checked before they take memory."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.editing.face_set import FaceSet

FACES = st.lists(st.integers(0, 200), min_size=1)


@given(FACES)
def test_a_set_holds_what_it_was_given(faces):
    found = FaceSet(faces)
    assert list(found) == sorted(set(faces)) == found.of_mesh(201).tolist()
    assert len(found) == len(set(faces))
    assert FaceSet.from_ranges(found.ranges) == found
    assert hash(FaceSet(faces[::-1])) == hash(found)


@given(FACES, FACES)
def test_sets_are_equal_as_sets_are(first, second):
    assert (FaceSet(first) == FaceSet(second)) == (set(first) == set(second))


def test_a_range_of_two_thousand_million_faces_costs_nothing_before_it_meets_a_mesh():
    forged = FaceSet.from_ranges([0, 2**31])
    assert len(forged) == 2**31
    with pytest.raises(ValueError, match="there is no face 2147483647: the mesh has 10 faces"):
        forged.of_mesh(10)


@pytest.mark.parametrize(
    ("faces", "error", "message"),
    [
        ([], ValueError, "faces is empty"),
        ([-1], ValueError, "numbers of faces, from 0, got -1"),
        ([2**31], ValueError, "got 2147483648"),
        (np.ones(3, bool), TypeError, r"got a mask; write np\.flatnonzero\(mask\)"),
        ([0.5], TypeError, "must hold whole numbers, got float64"),
        ("12", TypeError, "must be a sequence of whole numbers"),
        (3, TypeError, "must be a sequence of whole numbers"),
        ([[1, 2]], ValueError, r"got an array of shape \(1, 2\)"),
    ],
)
def test_what_names_no_faces_is_refused(faces, error, message):
    with pytest.raises(error, match=message):
        FaceSet(faces)


@pytest.mark.parametrize("ranges", [[1], [3, 2], [0, 2, 2, 4], [-1, 4], [0, 2**31 + 1]])
def test_forged_ranges_are_refused(ranges):
    with pytest.raises(ValueError, match="ascending and apart"):
        FaceSet.from_ranges(ranges)
