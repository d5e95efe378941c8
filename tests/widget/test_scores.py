"""Errors against a truth while one edits: the same numbers as `evaluate`, from tables over atoms."""

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.engine.atoms import common_refinement
from scenewidget.metrics import match_segments, mean_iou, quick_scores
from scenewidget.widget.scores import RIGHT, UNKNOWN, WRONG, Scorer, score_rows

MESH = shapes.box(6)
NAMES = ["rand_index_error", "global_consistency_error", "local_consistency_error", "mean_iou", "coverage"]


@st.composite
def labelings(draw):
    """Two labelings of some faces, -1 among them, the second with at least one label."""
    n = draw(st.integers(2, 40))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    a, b = rng.integers(-1, draw(st.integers(1, 6)), n), rng.integers(-1, draw(st.integers(1, 6)), n)
    b[0] = 0
    return a, b


@given(labelings())
@settings(max_examples=60)
def test_quick_scores_are_those_of_evaluate_however_faces_are_counted(pair):
    a, b = pair
    mesh = sw.Mesh(MESH.vertices, MESH.faces[: len(a)])
    row = sw.evaluate({"a": a}, b, mesh, metrics=NAMES[:4]).loc["a"]
    np.testing.assert_allclose(list(quick_scores(a, b).values()), row[NAMES].astype(float), atol=1e-12)
    pairs, counts = np.unique(np.stack([a, b]), axis=1, return_counts=True)
    scores = quick_scores(pairs[0], pairs[1], counts)
    np.testing.assert_allclose([scores[name] for name in NAMES], row[NAMES].astype(float), atol=1e-12)


@given(labelings())
@settings(max_examples=60)
def test_partners_are_one_to_one_and_make_the_mean_iou(pair):
    a, b = pair
    keep = (a >= 0) & (b >= 0)
    partner = match_segments(a, b)
    matched = partner[partner >= 0]
    assert len(np.unique(matched)) == len(matched)
    if keep.any():
        total = sum(
            np.sum((a == i) & (b == j) & keep) / np.sum(((a == i) | (b == j)) & keep)
            for i, j in enumerate(partner)
            if j >= 0
        )
        assert total / len(np.unique(b[keep])) == pytest.approx(mean_iou(a, b))


def test_right_and_wrong_faces():
    truth = np.repeat([0, 1, 2, -1], [100, 60, 40, MESH.n_faces - 200])
    labels = truth.copy()
    labels[90:100] = 1  # a strip of 0 that leaked into 1
    labels[200] = 3
    labels[150] = -1
    atoms = common_refinement([labels], MESH.n_faces)
    errors = Scorer(MESH, truth).errors(atoms, labels[atoms.first_face])
    expected = np.where(truth < 0, UNKNOWN, RIGHT)
    expected[90:100] = expected[150] = WRONG
    np.testing.assert_array_equal(errors, expected)


def test_a_truth_of_another_mesh_is_refused():
    with pytest.raises(ValueError, match="truth must have one label a face"):
        sw.SceneWidget(MESH, truth=np.zeros(5, int))
    with pytest.raises(ValueError, match="truth labels no face"):
        sw.SceneWidget(MESH, truth=np.full(MESH.n_faces, -1))


def test_rows_say_what_became_better_and_worse():
    before = dict.fromkeys(NAMES, 0.5)
    after = before | {
        "rand_index_error": 0.4,
        "mean_iou": 0.3,
        "coverage": 0.9,
        "local_consistency_error": 0.500001,
    }
    assert [row["trend"] for row in score_rows(after, before)] == ["better", "", "", "worse", "better"]
    assert [row["trend"] for row in score_rows(after, {})] == [""] * 5
    assert [row["text"] for row in score_rows(after, {})][-1] == "90.0%"


@pytest.fixture
def widget():
    mesh, truth = shapes.room(10, noise=0.003)
    widget = sw.SceneWidget(mesh, sw.Params(n_segments=6, n_runs=4, n_graph_runs=4), truth=truth)
    widget.wait(60)
    yield widget
    widget.close()


def test_scores_follow_results_and_edits(widget):
    def expected():
        names = NAMES[:4]
        return sw.evaluate({"w": widget.segmentation}, widget._scorer.truth, widget.mesh, metrics=names).loc[
            "w"
        ]

    np.testing.assert_allclose([widget.scores[n] for n in NAMES], expected()[NAMES].astype(float), atol=1e-12)
    first, second = (int(np.argmax(widget.segmentation.labels == i)) for i in (0, 1))
    before = widget.scores
    seen = []
    widget.observe(lambda change: seen.append(change["new"]), "scores")
    widget.session.merge(second, first)
    widget.wait(60)
    assert seen[-1] == widget.scores != before
    np.testing.assert_allclose([widget.scores[n] for n in NAMES], expected()[NAMES].astype(float), atol=1e-12)
    assert widget.controls.scores[0]["trend"] == "worse"
    widget.session.undo()
    widget.wait(60)
    assert widget.scores == before
    assert widget.controls.scores[0]["trend"] == "better"


def test_wrong_faces_are_sent_when_they_are_asked_for(widget):
    assert widget.view._face_error == b""
    widget.view.color_by = "errors"
    widget.wait(60)
    errors = np.frombuffer(widget.view._face_error, np.uint8)
    assert 0.7 < np.mean(errors == RIGHT) < 1
    first, second = (int(np.argmax(widget.segmentation.labels == i)) for i in (0, 1))
    widget.session.merge(second, first)
    widget.wait(60)
    after = np.frombuffer(widget.view._face_error, np.uint8)
    assert np.count_nonzero(after == WRONG) > np.count_nonzero(errors == WRONG)


def test_without_a_truth_there_are_no_scores():
    widget = sw.SceneWidget(MESH, sw.Params(n_segments=6, n_runs=4, n_graph_runs=4))
    widget.wait(60)
    assert (widget.scores, widget.controls.scores, widget.view.errors_title) == ({}, [], "")
    widget.close()


def test_verdicts_are_checked():
    view = sw.SceneView(MESH)
    for wrong in (np.zeros(3), np.full(MESH.n_faces, 3)):
        with pytest.raises(ValueError, match="errors must be 0, 1 or 2 for each"):
            view.set_errors(wrong)
