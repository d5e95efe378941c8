"""The table of metrics: what its columns hold, and what it refuses."""

import numpy as np
import pytest
import shapes

from scenewidget import metrics
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.segmentation import Segmentation
from scenewidget.evaluation import METRICS, evaluate, reliability


def strip(widths):
    """Rectangles of the given widths in a row, two triangles each: uneven areas."""
    x = np.concatenate([[0.0], np.cumsum(widths)])
    vertices = np.concatenate([np.stack([x, 0 * x + y, 0 * x], axis=1) for y in (0, 1)])
    n, left = len(x), np.arange(len(x) - 1)
    lower = np.stack([left, left + 1, left + n], axis=1)
    upper = np.stack([left + 1, left + n + 1, left + n], axis=1)
    return Mesh(vertices, np.stack([lower, upper], axis=1).reshape(-1, 3))


@pytest.fixture
def scene():
    mesh = strip([1, 1, 4, 1, 2])
    truth = Segmentation.from_labels(mesh, np.repeat([0, 0, 1, 2, 2], 2))
    guess = Segmentation.from_labels(mesh, np.repeat([0, 1, 1, 2, -1], 2))
    return mesh, truth, guess


def test_table_has_a_row_a_segmentation_and_a_column_a_metric(scene):
    mesh, truth, guess = scene
    table = evaluate({"guess": guess, "truth": truth.labels}, truth, mesh)
    assert list(table.index) == ["guess", "truth"]
    assert list(table.columns) == [*METRICS, "coverage", "n_segments", "n_truth"]
    for name in set(METRICS) - {"cut_discrepancy"}:
        assert table.loc["guess", name] == getattr(metrics, name)(guess, truth)
    assert table.loc["guess", "cut_discrepancy"] == metrics.cut_discrepancy(guess, truth, mesh)
    assert table.loc["guess", ["coverage", "n_segments", "n_truth"]].tolist() == [0.8, 3, 3]


def test_the_truth_itself_is_perfect(scene):
    mesh, truth, _ = scene
    row = evaluate({"truth": truth}, truth, mesh).loc["truth"]
    assert row.tolist() == [0, 0, 0, 0, 0, 0, 1, 1, 1, 3, 3]


def test_by_area_weighs_faces_by_their_size(scene):
    mesh, truth, guess = scene
    row = evaluate({"guess": guess}, truth, mesh, by="area").loc["guess"]
    assert row["coverage"] == pytest.approx(7 / 9)
    assert row["rand_index_error"] == metrics.rand_index_error(guess, truth, mesh.face_areas)
    assert row["rand_index_error"] != metrics.rand_index_error(guess, truth)


def test_the_mesh_comes_from_the_truth_when_left_out(scene):
    mesh, truth, guess = scene
    assert evaluate({"guess": guess}, truth).equals(evaluate({"guess": guess}, truth, mesh))


def test_unlabeled_faces_of_the_truth_don_t_lower_the_coverage(scene):
    mesh, truth, guess = scene
    partial = np.where(guess.labels < 0, -1, truth.labels)
    assert evaluate({"guess": guess}, partial, mesh).loc["guess", "coverage"] == 1


def test_what_to_do_with_unlabeled_faces_is_handed_on(scene):
    mesh, truth, guess = scene
    row = evaluate({"guess": guess}, truth, mesh, unlabeled="one").loc["guess"]
    assert row["rand_index_error"] == metrics.rand_index_error(guess, truth, unlabeled="one")
    assert row["coverage"] == 0.8


def test_a_segmentation_without_a_label_has_no_errors_to_tell(scene):
    mesh, truth, _ = scene
    row = evaluate({"none": np.full(mesh.n_faces, -1)}, truth, mesh).loc["none"]
    assert row[list(METRICS)].isna().all()
    assert row["coverage"] == row["n_segments"] == 0


def test_only_the_metrics_asked_for_are_computed(scene):
    mesh, truth, guess = scene
    table = evaluate({"guess": guess}, truth, mesh, metrics=["mean_iou"])
    assert list(table.columns) == ["mean_iou", "coverage", "n_segments", "n_truth"]


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"segmentations": "guess"}, TypeError, "segmentations must map names to segmentations"),
        ({"segmentations": {}}, ValueError, "segmentations is empty"),
        ({"segmentations": {"x": "room.ply"}}, TypeError, r"segmentations\['x'\] must be a Segmentation"),
        ({"segmentations": {"x": [0, 1]}}, ValueError, r"segmentations\['x'\] must have one label a face"),
        ({"truth": [0.5] * 10}, TypeError, "truth must be a Segmentation or whole-number labels"),
        ({"truth": [-1] * 10}, ValueError, "truth labels no face at all"),
        ({"truth": [0] * 10, "mesh": None}, TypeError, "mesh is needed when truth is an array"),
        ({"mesh": "room.ply"}, TypeError, r"mesh must be a scenewidget\.Mesh, got str"),
        ({"by": "vertices"}, ValueError, "by must be 'faces' or 'area', got 'vertices'"),
        ({"unlabeled": "two"}, ValueError, "unlabeled must be one of"),
        ({"metrics": ["rand"]}, ValueError, "metrics has 'rand'; it may hold rand_index_error"),
        (
            {"metrics": "mean_iou"},
            TypeError,
            r"metrics must be a collection of names, such as \['mean_iou'\]",
        ),
    ],
)
def test_bad_input_is_refused_with_a_reason(scene, change, error, message):
    mesh, truth, guess = scene
    arguments = {"segmentations": {"guess": guess}, "truth": truth, "mesh": mesh} | change
    with pytest.raises(error, match=message):
        evaluate(**arguments)


def test_segmentations_of_another_mesh_are_refused(scene):
    mesh, truth, _ = scene
    other = strip([1, 1, 1])
    with pytest.raises(
        ValueError, match=r"segmentations\['x'\] belongs to another mesh, of 6 faces .* has 10"
    ):
        evaluate({"x": Segmentation.from_labels(other, np.zeros(6, dtype=int))}, truth, mesh)
    shuffled = Mesh(mesh.vertices, mesh.faces[::-1])
    with pytest.raises(ValueError, match="or in another order"):
        evaluate({"x": Segmentation.from_labels(shuffled, truth.labels)}, truth, mesh)


def test_a_truth_without_area_is_refused():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    with pytest.raises(ValueError, match="only faces without area"):
        evaluate({"x": [0]}, [0], mesh)


# --- reliability ----------------------------------------------------------------------------------


def test_reliability_matches_its_definition():
    mesh = shapes.box(2)
    rng = np.random.default_rng(0)
    labels, actual = rng.integers(0, 3, mesh.n_faces), rng.integers(-1, 3, mesh.n_faces)
    confidence = rng.random(mesh.n_faces)
    segmentation = Segmentation.from_labels(mesh, labels, confidence=confidence)
    table = reliability(segmentation, actual, n_bins=4)
    right = {}
    known = actual >= 0
    labels = segmentation.labels
    for f in np.flatnonzero(known):
        mostly = np.bincount(actual[known & (labels == labels[f])]).argmax()
        home = np.bincount(labels[known & (actual == actual[f])]).argmax()
        row = right.setdefault(int(np.float32(confidence[f]) * 4), [])
        row.append(mostly == actual[f] and home == labels[f])
    assert table.index.tolist() == sorted(right)
    np.testing.assert_allclose(table["right"], [np.mean(right[b]) for b in sorted(right)])
    np.testing.assert_allclose(table["share"].sum(), 1)


def test_a_confidence_that_is_a_probability_has_no_calibration_error():
    mesh = shapes.box(2)
    actual = np.arange(mesh.n_faces) % 2
    one = Segmentation.from_labels(mesh, 0 * actual, confidence=np.full(mesh.n_faces, 0.5))
    (row,) = reliability(one, actual).itertuples()
    assert row.confidence == pytest.approx(row.right, abs=1e-6)
    assert row.share == 1.0


def test_reliability_refuses_what_it_cannot_judge():
    mesh = shapes.box(2)
    labels = np.zeros(mesh.n_faces, int)
    with pytest.raises(TypeError, match="segmentation must be a Segmentation, got ndarray"):
        reliability(labels, labels)
    with pytest.raises(ValueError, match="n_bins must be at least 1, got 0"):
        reliability(Segmentation.from_labels(mesh, labels), labels, n_bins=0)
