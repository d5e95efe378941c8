"""Where every face is after an edit."""

import numpy as np
import pytest
import shapes
from editing_strategies import applies, box_session, do_all, edited, segmentations
from hypothesis import given
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.editing.edits import Cut, EditError, Merge, Split
from scenewidget.editing.session import Session
from scenewidget.engine.segmentation import Segmentation

pytestmark = pytest.mark.filterwarnings("ignore:.*edits do not apply:UserWarning")


@given(edited())
def test_labels_stay_dense_by_area_and_no_face_is_lost(case):
    segmentation, edits = case
    session = Session(segmentation.mesh, segmentation)
    for edit in edits:
        before = session.segmentation.labels
        if do_all(session, [edit]) == 0:
            continue
        now = session.segmentation
        assert ((now.labels >= 0) >= (before >= 0)).all()
        expected = Segmentation.from_labels(now.mesh, now.labels)
        np.testing.assert_array_equal(now.labels, expected.labels)
        assert session.n_segments == now.n_segments == len(now.names)


@given(segmentations(), st.data())
def test_parts_move_whole(segmentation, data):
    face = data.draw(st.integers(0, segmentation.mesh.n_faces - 1))
    onto = data.draw(st.integers(0, segmentation.mesh.n_faces - 1))
    level = data.draw(st.sampled_from(["dihedral", "base", "final"]))
    part = segmentation.level(level) == segmentation.level(level)[face]
    session = Session(segmentation.mesh, segmentation)
    if applies(session, Merge((face,), onto, level)):
        expected = segmentation.labels.astype(np.int64)
        expected[part] = segmentation.labels[onto]
    elif level != "final" and applies(session, Split(face, level)):
        expected = segmentation.labels.astype(np.int64)
        expected[part] = segmentation.n_segments
    else:
        return
    expected = Segmentation.from_labels(segmentation.mesh, expected)
    np.testing.assert_array_equal(session.segmentation.labels, expected.labels)


def test_merged_segments_move_as_one_and_come_apart_again():
    session = box_session()
    before = session.segmentation.labels
    session.merge(0, 40)
    session.merge(0, 70)  # all of what is under face 0 now
    now = session.segmentation
    assert now.n_segments == 4
    assert len(set(now.labels[[0, 40, 70]])) == 1
    session.split(0)  # only what was automatic segment 0
    assert session.segmentation.labels[40] == session.segmentation.labels[70]
    assert session.segmentation.labels[0] != session.segmentation.labels[40]
    session.split(40)
    np.testing.assert_array_equal(session.segmentation.labels, before)
    with pytest.raises(EditError, match="segment of its own already; a finer level or a cut"):
        session.split(40)


def test_moved_faces_have_full_confidence():
    session = box_session(confidence=np.full(192, 0.5, np.float32))
    session.split(0, "base")
    assert session.segmentation.confidence[:8].tolist() == [1.0] * 8
    assert (session.segmentation.confidence[8:] == 0.5).all()


def test_names_stay_with_the_segment_and_are_not_lost_in_a_merge():
    session = box_session()
    session.relabel(0, "  seat ")
    session.merge(0, 40)  # the target has no name: it takes that of what disappears
    assert session.segmentation.names[session.segmentation.labels[40]] == "seat"
    session.relabel(70, "back")
    session.merge(40, 70)  # it has one: it keeps it
    assert session.segmentation.names[session.segmentation.labels[0]] == "back"
    session.split(40)
    assert session.segmentation.names[session.segmentation.labels[40]] == ""
    session.relabel(70, "")
    assert set(session.segmentation.names) == {""}


def test_unlabeled_faces_can_be_gathered_by_a_finer_level():
    mesh = shapes.box(2)
    labels = np.arange(48) // 8 - 1
    seg = Segmentation(mesh, labels, levels={"dihedral": np.arange(48, dtype=np.int32)})
    session = Session(mesh, seg)
    with pytest.raises(EditError, match="face 0 is unlabeled"):
        session.merge(0, 20)
    with pytest.raises(EditError, match="onto_face 0 is unlabeled"):
        session.merge(20, 0)
    session.merge([0, 1], 20, level="dihedral")
    assert session.segmentation.labels[0] == session.segmentation.labels[20]
    session.split(2, level="dihedral")
    assert (session.segmentation.labels >= 0).sum() == 43


def test_items_follow_the_edits():
    mesh, _ = sw.datasets.load_room() if hasattr(sw.datasets, "load_room") else (shapes.box(12), None)
    seg = sw.segment(mesh, sw.Params(n_segments=8, n_runs=2, n_graph_runs=2))
    session = Session(mesh, seg)
    face = int(np.flatnonzero(seg.labels == 0)[0])
    onto = int(np.flatnonzero(seg.labels == 1)[0])
    session.merge(face, onto)
    now = session.segmentation
    keep = (now.face_map >= 0) & (now.labels >= 0)
    np.testing.assert_array_equal(now.item_labels[now.face_map[keep]], now.labels[keep])


def test_cut_needs_both_seeds_on_their_sides():
    session = box_session()
    session.merge([40, 70, 100, 130, 170], 0)
    session.do(Cut(0, 190))
    labels = session.segmentation.labels
    assert session.segmentation.n_segments == 2
    assert labels[0] != labels[190]
