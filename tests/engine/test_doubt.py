from __future__ import annotations

import copy
import dataclasses
import pickle

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.engine.doubt import (
    FITTED,
    LIMITS,
    Models,
    doubts,
    judged_anew,
    logistic,
    measure_borders,
    run_kinds,
)
from scenewidget.engine.pieces import make_pieces


def halves(fold: float = 0.0) -> tuple[sw.Mesh, np.ndarray]:
    """A sheet of 2 m² and which half each face is in; the right half turned up by an angle."""
    mesh = shapes.sheet(8, 4, width=2.0, depth=1.0)
    x = mesh.vertices[:, 0] - 1.0
    turned = np.stack([1 + x * np.cos(fold), mesh.vertices[:, 1], x * np.sin(fold)], axis=1)
    vertices = np.where((x > 0)[:, None], turned, mesh.vertices)
    labels = (mesh.face_centroids[:, 0] > 1.0).astype(np.int32)
    return sw.Mesh(vertices, mesh.faces), labels


def test_what_is_measured_of_a_folded_sheet():
    mesh, labels = halves(fold=np.pi / 2)
    pieces = make_pieces(mesh, labels, labels)
    keys = np.array([[0, 0, 0, 0], [0, 1, 1, 1]])
    borders = measure_borders(pieces, keys, keys[:, :2])
    assert (borders.first.tolist(), borders.second.tolist()) == ([0], [1])
    assert borders.length[0] == pytest.approx(1.0)
    assert borders.by_graph[0] == pytest.approx(0.25)
    assert borders.by_medoids[0] == pytest.approx(0.5)
    assert borders.facing[0] == pytest.approx(0.0, abs=1e-9)
    # points of a square that stands on the plane's edge: height from 0 to 1
    assert borders.offset[0] == pytest.approx(np.sqrt(1 / 3))
    assert borders.n_pieces[0] == 1
    assert borders.convex[0] in (0.0, 1.0)
    assert borders.measures[0, -1] == pytest.approx(
        borders.convex[0], abs=1e-9
    )  # a right angle, if it bulges


def test_a_cut_is_measured_where_the_runs_disagree():
    mesh, _ = halves()
    base = (4 * mesh.face_centroids[:, 0] / 2).astype(int).clip(0, 3)  # four strips
    pieces = make_pieces(mesh, np.zeros(mesh.n_faces, np.int32), base)
    keys = np.array([[0] * 10, [0] * 10, [0] * 2 + [1] * 8, [0] * 2 + [1] * 8])
    d = doubts(pieces, keys)
    assert sorted(pieces.base[d.side(0)].tolist()) in ([0, 1], [2, 3])
    cuts = d.cuts[0]
    assert cuts is not None
    best = int(d.best[0])
    assert cuts.agreement[best] == pytest.approx(0.2)
    assert cuts.seam[best] == pytest.approx(1.0)
    assert cuts.area[best] == pytest.approx(1.0)
    best_of_many = judged_anew(logistic(FITTED.two, cuts.measures).max(), FITTED.likeliest)
    assert d.two[0] == pytest.approx(best_of_many)
    assert cuts.offset.max() < 1e-6
    for k in range(cuts.n):  # by definition: mean over pairs of pieces, by area
        side = cuts.side(k)
        rest = np.setdiff1d(cuts.order, side)
        area = pieces.moments.area
        share = (keys[pieces.base[side]][:, None] == keys[pieces.base[rest]][None]).mean(axis=2)
        weight = np.outer(area[side], area[rest])
        assert cuts.agreement[k] == pytest.approx((share * weight).sum() / weight.sum())
        assert cuts.area[k] == pytest.approx(area[side].sum())


@given(st.lists(st.floats(-5, 5), min_size=5, max_size=5), st.integers(0, 4), st.floats(0, 3))
def test_more_of_a_measure_never_turns_the_model_round(measures, which, more):
    low, _ = LIMITS["same"][which]
    before = logistic(FITTED.same, np.array([measures]))
    measures[which] += more
    after = logistic(FITTED.same, np.array([measures]))
    assert after >= before if low == 0 else after <= before


def test_the_shipped_numbers_keep_to_their_limits():
    for name, limits in LIMITS.items():
        for weight, (low, high) in zip(getattr(FITTED, name)[1:], limits, strict=True):
            assert low <= weight <= high


def test_a_face_is_doubtful_where_its_segment_is_likely_a_piece_of_a_larger_one():
    mesh, _ = halves()
    small = (mesh.face_centroids[:, 0] > 1.7).astype(np.int32)
    pieces = make_pieces(mesh, small, small)
    apart = doubts(pieces, np.array([[0] * 8, [1] * 8]))
    together = doubts(pieces, np.array([[0] * 8, [0] * 6 + [1] * 2]))
    assert together.same[0] > apart.same[0]
    assert together.wrong[1] > apart.wrong[1]  # of the small one
    assert together.wrong[0] == apart.wrong[0]
    assert together.wrong[1] > together.wrong[0]


def test_where_kinds_of_runs_are_not_known_all_stand_for_both():
    keys = np.arange(12).reshape(2, 6)
    graph, medoids = run_kinds(keys, {"k-medoids": 2, "graph": 4})
    np.testing.assert_array_equal(graph, keys[:, 2:])
    np.testing.assert_array_equal(medoids, keys[:, :2])
    for runs in (None, {}, {"k-medoids": 7}):
        for kind in run_kinds(keys, runs):
            np.testing.assert_array_equal(kind, keys)
    assert run_kinds(None, {"graph": 3}) == (None, None)
    np.testing.assert_array_equal(run_kinds(keys, {"k-medoids": 0, "graph": 6})[1], keys)


def test_known_cuts_are_not_measured_again_and_say_the_same(monkeypatch):
    from scenewidget.engine import doubt

    mesh, labels = halves()
    base = (8 * mesh.face_centroids[:, 0] / 2).astype(int).clip(0, 7)
    pieces = make_pieces(mesh, labels, base)
    keys = np.random.default_rng(0).integers(0, 2, (8, 9))
    known = {}
    first = doubts(pieces, keys, known=known)
    monkeypatch.setattr(doubt, "measure_cuts", lambda *_: pytest.fail("measured again"))
    again = doubts(pieces, keys, known=known)
    np.testing.assert_array_equal(first.wrong, again.wrong)


# --- of a segmentation -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def room():
    mesh, truth = sw.datasets.load_room()
    return mesh, truth, sw.segment(mesh)


def test_borders_of_a_room_are_pairs_that_touch_the_likeliest_first(room):
    _, _, seg = room
    borders = seg.borders()
    assert borders.columns.tolist()[:4] == ["first", "second", "length", "p_same"]
    assert (borders["first"] < borders["second"]).all()
    assert not borders.duplicated(["first", "second"]).any()
    assert (borders["length"] > 0).all()
    assert borders["p_same"].between(0, 1).all()
    assert borders["p_same"].is_monotonic_decreasing


def test_cuts_of_a_room_name_faces_of_their_segment(room):
    _, _, seg = room
    cuts = seg.cuts()
    assert cuts["segment"].tolist() == list(range(seg.n_segments))
    assert cuts["p_two"].between(0, 1).all()
    for segment, faces in zip(cuts["segment"], cuts["faces"]):
        assert (seg.labels[faces] == segment).all()
        assert 2 * len(faces) < 2 * (seg.labels == segment).sum()
    assert any(len(faces) for faces in cuts["faces"])


def test_confidence_of_a_room_finds_wrong_faces_better_than_area_does(room):
    mesh, truth, seg = room
    known = (seg.labels >= 0) & (truth.labels >= 0)
    table = np.zeros((seg.n_segments, truth.n_segments))
    np.add.at(table, (seg.labels[known], truth.labels[known]), 1)
    wrong = table.argmax(axis=1)[seg.labels[known]] != truth.labels[known]
    wrong |= table.argmax(axis=0)[truth.labels[known]] != seg.labels[known]
    area = np.bincount(seg.labels[known], mesh.face_areas[known])[seg.labels[known]]

    def auc(score):
        rank = np.unique(score, return_inverse=True)[1]
        bad, good = (np.bincount(rank, weights=w, minlength=rank.max() + 1) for w in (wrong, ~wrong))
        return (bad * (np.cumsum(good) - good / 2)).sum() / (bad.sum() * good.sum())

    assert auc(-seg.confidence[known]) > max(0.75, auc(-area))
    assert seg.confidence[known].std() > 0.08  # a map of it spreads over its colours
    assert (seg.confidence[~(seg.labels >= 0)] == 0).all()


def test_a_segmentation_says_the_same_after_its_doubt_was_forgotten(room):
    _, _, seg = room
    forgotten = dataclasses.replace(seg, doubt=None)
    assert forgotten.borders().equals(seg.borders())
    assert dataclasses.replace(seg, labels=seg.labels.copy()).doubt is None


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda seg: pickle.loads(pickle.dumps(seg))])
def test_a_segmentation_can_be_copied_and_pickled(room, copied):
    _, _, seg = room
    other = copied(seg)
    np.testing.assert_array_equal(other.labels, seg.labels)
    assert not other.labels.flags.writeable
    assert dict(other.report) == dict(seg.report)
    assert other.borders().equals(seg.borders())


def test_labels_without_an_ensemble_have_borders_by_their_shape_and_no_cuts(room):
    _, truth, _ = room
    borders = truth.borders()
    assert len(borders)
    assert borders["agreement"].isna().all()
    assert (truth.cuts()["p_two"] == 0).all()
    nothing = sw.Segmentation.from_labels(truth.mesh, np.full(truth.mesh.n_faces, -1))
    assert len(nothing.borders()) == len(nothing.cuts()) == 0


def test_other_models_can_be_given():
    mesh, labels = halves()
    pieces = make_pieces(mesh, labels, labels)
    never = Models((-50.0, *[0.0] * 5), *FITTED[1:])
    assert doubts(pieces, np.array([[0], [0]]), models=never).same[0] < 1e-6
