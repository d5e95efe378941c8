from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.editing import EditError, Merge, Session, Split, simulate_annotator
from scenewidget.metrics import rand_index_error


def strip(n_faces: int) -> sw.Mesh:
    x = np.arange(n_faces + 2) / 2
    vertices = np.stack([x, np.arange(n_faces + 2) % 2, np.zeros(n_faces + 2)], axis=1)
    corner = np.arange(n_faces)
    return sw.Mesh(vertices, np.stack([corner, corner + 1, corner + 2], axis=1))


@st.composite
def scenes(draw: st.DrawFn) -> tuple[sw.Segmentation, np.ndarray]:
    n = draw(st.integers(6, 14))
    labels, base, dihedral, truth = (
        np.array(draw(st.lists(st.integers(least, most), min_size=n, max_size=n)))
        for least, most in ((-1, 3), (-1, 5), (-1, 7), (-1, 3))
    )
    mesh = strip(n)
    labels[:2] = 0
    truth[1:3] = 0
    made = sw.Segmentation.from_labels(mesh, labels)
    levels = {"base": base, "dihedral": dihedral}
    return sw.Segmentation(mesh, made.labels, levels=levels), truth


def best_by_trying(segmentation: sw.Segmentation, edits: list, truth: np.ndarray) -> float:
    """Lowest 1 − RI behind any one more edit, from the definition."""
    n = segmentation.mesh.n_faces
    levels = ("final", "base", "dihedral")
    every = [Split(face, level) for face in range(n) for level in levels]
    every += [Merge(a, b, level) for a in range(n) for b in range(n) for level in levels if a != b]
    errors = []
    for edit in every:
        session = Session(segmentation.mesh, segmentation)
        for earlier in edits:
            session.do(earlier)
        try:
            session.do(edit)
        except EditError:
            continue
        errors.append(rand_index_error(session.segmentation.labels, truth))
    return min(errors)


@given(scenes())
@settings(max_examples=8, deadline=None)
def test_each_edit_is_the_best_of_all_that_the_session_can_do(scene):
    segmentation, truth = scene
    correction = simulate_annotator(segmentation, truth, target=0.0, most=4)
    session = Session(segmentation.mesh, segmentation)
    for k, edit in enumerate(correction.edits):
        best = best_by_trying(segmentation, list(correction.edits[:k]), truth)
        session.do(edit)
        assert rand_index_error(session.segmentation.labels, truth) == pytest.approx(best, abs=1e-12)
        assert correction.errors[k + 1] == pytest.approx(best, abs=1e-12)
    if not correction.reached and len(correction.edits) < 4:
        now = rand_index_error(session.segmentation.labels, truth)
        assert best_by_trying(segmentation, list(correction.edits), truth) >= now - 1e-12


def test_the_truth_needs_no_edit():
    _, truth = sw.datasets.load_room()
    correction = simulate_annotator(truth, truth, target=0.0)
    assert (correction.edits, correction.reached) == ((), True)
    assert repr(correction) == "Correction(0 edits, 1-RI 0.000 to 0.000)"


def test_a_wall_in_three_pieces_needs_two_merges():
    truth = np.repeat([0, 1], [30, 20])
    pieces = sw.Segmentation.from_labels(strip(50), np.repeat([0, 1, 2, 3], [10, 10, 10, 20]))
    correction = simulate_annotator(pieces, truth, target=0.0)
    assert [type(edit) for edit in correction.edits] == [Merge, Merge]
    assert rand_index_error(correction.segmentation.labels, truth) == 0.0


def test_without_finer_levels_two_things_in_one_segment_stay_there():
    one = sw.Segmentation.from_labels(strip(10), np.zeros(10, int))
    correction = simulate_annotator(one, np.repeat([0, 1], 5), target=0.0)
    assert (correction.edits, correction.reached) == ((), False)
    assert "not reached" in repr(correction)


def test_a_part_that_the_truth_does_not_label_is_left_alone():
    labels = np.repeat([0, 1, 2], [10, 10, 5])
    truth = np.repeat([0, 1, -1], [10, 10, 5])
    correction = simulate_annotator(sw.Segmentation.from_labels(strip(25), labels), truth, target=0.0)
    assert correction.edits == ()


def test_a_truth_of_another_mesh_is_refused():
    one = sw.Segmentation.from_labels(strip(10), np.zeros(10, int))
    with pytest.raises(
        ValueError, match=r"truth must have a whole number for each face of the mesh: \(10,\)"
    ):
        simulate_annotator(one, np.zeros(9, int))
