"""Segmentation: what its constructor refuses, renumbering by area from the definition, levels, the table."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.engine.segmentation import Segmentation, order_by_area

BOX = shapes.box(2, size=(4.0, 2.0, 1.0))
SIDES = shapes._side(BOX)


def test_segments_are_numbered_by_area_and_keep_their_names():
    names = ("left", "right", "front", "back", "floor", "ceiling")
    seg = Segmentation.from_labels(BOX, SIDES, names=names)
    area = [BOX.face_areas[seg.labels == s].sum() for s in range(6)]
    np.testing.assert_allclose(area, [8, 8, 4, 4, 2, 2])
    for s in range(6):
        faces = seg.labels == s
        assert {names[side] for side in SIDES[faces]} == {seg.names[s]}
    assert seg.n_segments == 6
    assert seg.coverage == 1.0
    assert repr(seg) == "Segmentation(48 faces, 6 segments, 100.0% labeled)"


@given(st.lists(st.sampled_from([-5, -1, 0, 1, 2, 7, 10**9]), min_size=1, max_size=30), st.integers(0, 99))
def test_order_by_area_is_dense_descending_and_a_renaming(labels, seed):
    labels = np.array(labels)
    areas = np.random.default_rng(seed).integers(1, 3, len(labels)).astype(float)  # ties are common
    dense, kept = order_by_area(labels, areas)
    np.testing.assert_array_equal(dense < 0, labels < 0)
    assert set(dense[dense >= 0].tolist()) == set(range(len(kept)))
    np.testing.assert_array_equal(kept[dense[dense >= 0]], labels[labels >= 0])
    keys = [(-areas[labels == old].sum(), int(np.argmax(labels == old))) for old in kept]
    assert keys == sorted(keys)


@given(st.permutations(range(6)), st.integers(0, 9))
def test_names_of_labels_do_not_matter(names, shift):
    renamed = 3 * np.array(names)[SIDES] + shift
    a, b = (Segmentation.from_labels(BOX, labels).labels for labels in (SIDES, renamed))
    np.testing.assert_array_equal(a, b)


def test_nothing_labeled_is_a_segmentation_too():
    seg = Segmentation.from_labels(BOX, np.full(BOX.n_faces, -7))
    assert (seg.n_segments, seg.coverage, len(seg.to_frame())) == (0, 0.0, 0)
    assert set(seg.labels.tolist()) == {-1}
    assert not seg.confidence.any()


def test_arrays_are_copies_and_read_only():
    labels = np.zeros(BOX.n_faces, dtype=np.int32)
    seg = Segmentation(BOX, labels)
    labels[0] = 5
    assert seg.labels[0] == 0
    for array in (seg.labels, seg.confidence):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(TypeError):
        seg.report["new"] = 1


def test_the_table_has_what_geometry_says():
    frame = Segmentation.from_labels(BOX, np.where(SIDES == 5, 0, -1), names=("top",)).to_frame()
    assert frame.index.name == "segment"
    row = frame.loc[0]
    assert (row["name"], row.faces, row.area) == ("top", 8, pytest.approx(8))
    np.testing.assert_allclose(row.centroid, (0, 0, 0.5), atol=1e-12)
    np.testing.assert_allclose(row.normal, (0, 0, 1), atol=1e-12)
    assert row.flatness == pytest.approx(0, abs=1e-12)
    assert row.confidence == 1


def test_levels_are_those_that_were_given():
    parts = np.arange(BOX.n_faces)
    seg = Segmentation(BOX, np.zeros(BOX.n_faces, dtype=int), levels={"base": parts})
    np.testing.assert_array_equal(seg.level("base"), parts)
    np.testing.assert_array_equal(seg.level("final"), seg.labels)
    with pytest.raises(ValueError, match="no level 'dihedral': it was not made by segment"):
        seg.level("dihedral")
    with pytest.raises(ValueError, match="level must be one of 'dihedral', 'base', 'final', got 'top'"):
        seg.level("top")


N = BOX.n_faces


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: Segmentation(BOX, np.full(N, 3)), ValueError, "without gaps; .*from_labels"),
        (lambda: Segmentation(BOX, np.full(N, -2)), ValueError, "labels must be -1 or 0"),
        (lambda: Segmentation(BOX, np.zeros(3, int)), ValueError, rf"one entry a face of the mesh: \({N},\)"),
        (lambda: Segmentation(BOX, np.zeros(N)), TypeError, "labels must be whole numbers, got dtype float"),
        (lambda: Segmentation(BOX, ["a"] * N), TypeError, "labels must be an array of numbers"),
        (lambda: Segmentation(BOX, np.zeros(N, int), np.ones(2)), ValueError, "confidence must have one"),
        (
            lambda: Segmentation(BOX, np.zeros(N, int), levels={"top": np.zeros(N, int)}),
            ValueError,
            "levels has a key 'top'; it must be one of 'dihedral', 'base', 'final'",
        ),
        (lambda: Segmentation(BOX, np.zeros(N, int), names=("a", "b")), ValueError, "one entry a segment: 1"),
        (
            lambda: Segmentation.from_labels(BOX, np.full(N, 2), names=("a", "b")),
            ValueError,
            "labels go up to 2, but names has only 2",
        ),
        (
            lambda: Segmentation.from_labels(BOX, np.full(N, 2), groups=(0, 1)),
            ValueError,
            "labels go up to 2, but groups has only 2",
        ),
        (
            lambda: Segmentation(BOX, SIDES, groups=(1, 1)),
            ValueError,
            "groups must have one entry a segment: 6",
        ),
        (
            lambda: Segmentation(BOX, SIDES, groups=(1, 2, 2, 3, 4, 5)),
            ValueError,
            "segment 0 is a part of 1, which must be a segment, and no part itself",
        ),
        (
            lambda: Segmentation(BOX, SIDES, groups=(0, "a", 2, 3, 4, 5)),
            ValueError,
            "1 is a part of 'a', which",
        ),
    ],
)
def test_what_does_not_fit_is_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_confidence_is_found_on_first_use_and_survives_copies():
    base = np.arange(BOX.n_faces, dtype=np.int32) // 2
    known = {"levels": {"base": base}, "keys": SIDES[::2, None].astype(np.int32)}
    seg = Segmentation(BOX, (SIDES > 2).astype(np.int32), **known)
    assert "confidence" not in vars(seg)
    assert seg.doubt is None
    timed = seg.with_timings({"items": 1.0})
    again = pickle.loads(pickle.dumps(seg))
    assert timed.timings == {"items": 1.0}
    for other in (timed, again, copy.deepcopy(seg), dataclasses.replace(seg, names=("a", "b"))):
        np.testing.assert_array_equal(other.confidence, seg.confidence)
    assert seg.confidence is seg.confidence
    assert not seg.confidence.flags.writeable
    assert 0 < seg.confidence.min() <= seg.confidence.max() < 1
    with pytest.raises(AttributeError, match="no attribute 'sureness'"):
        seg.sureness  # noqa: B018
