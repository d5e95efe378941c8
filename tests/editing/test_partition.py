"""Where every face is after an edit."""

import numpy as np
import pytest
import shapes
from editing_strategies import applies, box_session, do_all, edited, edits, segmentations
from hypothesis import given
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.datasets import analytic
from scenewidget.editing.edits import Cut, EditError, Merge, Split
from scenewidget.editing.partition import Partition
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


def test_a_part_of_a_part_is_a_part_of_the_whole():
    session = box_session()  # a segment for every 32 faces
    session.group([32, 64], onto_face=0)
    session.group(96, onto_face=32)  # a part stands for its whole
    assert session.segmentation.groups == (0, 0, 0, 0, 4, 5)
    session.group(0, onto_face=128)  # a whole brings its parts along
    assert session.segmentation.groups == (4, 4, 4, 4, 4, 5)
    session.group([128, 160], onto_face=64)  # but where the whole is put onto a part, that is the whole
    assert session.segmentation.groups == (2, 2, 2, 2, 2, 2)
    with pytest.raises(EditError, match="face 0: its segment is so already"):
        session.group(0, onto_face=96)
    session.group(0)
    assert session.segmentation.groups == (0, 2, 2, 2, 2, 2)
    with pytest.raises(EditError, match="face 0: its segment is part of nothing"):
        session.group(0)
    session.group(64)  # a whole lets go of its parts
    assert session.segmentation is session.automatic
    session.undo()
    assert session.segment_groups == {1: 2, 3: 2, 4: 2, 5: 2}


def test_parts_go_to_what_takes_their_whole():
    session = box_session()
    session.group([32, 64], onto_face=0)
    session.merge(0, 96)
    assert session.segment_groups == {1: 3, 2: 3}
    session.merge(96, 32)  # onto a part, which is the whole then
    assert session.segment_groups == {2: 1}
    session.merge(64, 128)  # the only part is gone
    assert session.segment_groups == {}
    session.go_to(1)
    assert session.segment_groups == {1: 0, 2: 0}
    session.cut(32, 63)  # what is cut off is part of nothing
    assert session.segment_groups == {1: 0, 2: 0}


def test_unlabeled_faces_are_part_of_nothing():
    mesh = shapes.box(2)
    session = Session(mesh, Segmentation(mesh, np.arange(48) // 8 - 1))
    with pytest.raises(EditError, match="face 0 is unlabeled: there is no segment to group"):
        session.group(0, onto_face=20)
    with pytest.raises(EditError, match="onto_face 0 is unlabeled: there is no segment to be part of"):
        session.group(20, onto_face=0)
    session.group([0, 20], onto_face=40)  # passed over as long as one is known
    assert session.segment_groups == {1: 4}


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


def plane_session(n=8):
    """A square of n × n cells of two triangles in the plane z = 0, halved at x = ½."""
    mesh = analytic.square(n)
    labels = (mesh.face_centroids[:, 0] > 0.5).astype(int)
    return Session(mesh, Segmentation.from_labels(mesh, labels))


def test_painted_faces_are_moved_to_the_face_whatever_pieces_they_were():
    session = box_session()
    session.paint([0, 3, 40, 100], onto_face=150)
    expected = np.arange(192) // 32
    expected[[0, 3, 40, 100]] = 4
    now = session.segmentation
    np.testing.assert_array_equal(now.labels, Segmentation.from_labels(now.mesh, expected).labels)
    session.paint(range(10, 50))
    expected[10:50] = 6
    now = session.segmentation
    np.testing.assert_array_equal(now.labels, Segmentation.from_labels(now.mesh, expected).labels)
    assert (now.confidence[10:50] == 1).all()


def test_unlabeled_faces_can_be_painted_but_nothing_can_be_painted_onto_them():
    mesh = shapes.box(2)
    session = Session(mesh, Segmentation(mesh, np.arange(48) // 8 - 1))
    session.paint([0, 1, 2], onto_face=20)
    assert len(set(session.segmentation.labels[[0, 1, 2, 20]])) == 1
    with pytest.raises(EditError, match="onto_face 5 is unlabeled: there is no segment to paint onto"):
        session.paint([20], onto_face=5)
    for call in (session.grow, session.shrink, session.fill_holes, session.smooth_border):
        with pytest.raises(EditError, match="face 5 is unlabeled: there is no segment to"):
            call(5)
    with pytest.raises(EditError, match="face 5 is unlabeled: there is no segment to slice"):
        session.slice(5, (0, 0, 0), (0, 0, 1))


def test_a_segment_that_is_painted_over_leaves_its_name():
    session = box_session()
    session.relabel(0, "door")
    session.paint(range(32), onto_face=40)
    assert session.segmentation.names[session.segmentation.labels[40]] == "door"
    session.undo()
    assert session.segmentation.names[session.segmentation.labels[0]] == "door"


@pytest.mark.parametrize("length", [1e-200, 1.0, 1e200])
def test_a_slice_divides_by_centroids_and_keeps_the_side_of_the_face(length):
    session = plane_session()
    centroids = session.mesh.face_centroids
    left = int(np.argmin(centroids[:, 0]))
    kept = session.atom_segments[session.atoms.face_atom[left]]
    session.slice(left, (0.3, 0.0, 0.0), (length, length, 0.0))
    segment = session.atom_segments[session.atoms.face_atom]
    is_other = (centroids[:, 0] + centroids[:, 1] > 0.3) & (centroids[:, 0] < 0.5)
    assert session.n_segments == 3
    np.testing.assert_array_equal(segment == 2, is_other)
    assert (segment[(centroids[:, 0] < 0.5) & ~is_other] == kept).all()


def test_growing_and_shrinking_move_the_border_by_rings():
    session = plane_session()
    x = session.mesh.face_centroids[:, 0]
    left, right = int(x.argmin()), int(x.argmax())
    session.grow(left, rings=2)
    labels = session.segmentation.labels
    grown = labels == labels[left]
    assert grown[x < 0.5].all()
    assert grown[x < 0.61].all()  # a row of cells has two rings
    assert not grown[x > 0.63].any()
    session.shrink(left, rings=2)
    labels = session.segmentation.labels
    np.testing.assert_array_equal(labels == labels[left], x < 0.5)
    session.grow(left, rings=100)
    assert session.n_segments == 1
    with pytest.raises(EditError, match="there is nothing to grow onto"):
        session.grow(right)
    with pytest.raises(EditError, match="touches no other segment that could take its faces"):
        session.shrink(right)


def test_holes_are_filled_and_teeth_taken_off():
    session = plane_session(16)
    x, y, _ = session.mesh.face_centroids.T
    left, right = int(x.argmin()), int(x.argmax())
    before = session.segmentation.labels
    hole = np.flatnonzero((abs(x - 0.25) < 0.07) & (abs(y - 0.5) < 0.07))
    session.paint(hole)
    with pytest.raises(EditError, match=f"has no hole of at most {len(hole) - 1} faces"):
        session.fill_holes(left, max_faces=len(hole) - 1)
    session.fill_holes(left, max_faces=len(hole))
    np.testing.assert_array_equal(session.segmentation.labels, before)
    tooth = np.flatnonzero((x < 0.5) & (x > 0.38) & (abs(y - 0.53125) < 0.03))
    session.paint(tooth, onto_face=right)
    session.smooth_border(right)
    labels = session.segmentation.labels
    is_right = labels == labels[right]
    assert not is_right[x < 7 / 16].any()  # of a tooth two cells long a low bump is left
    assert np.count_nonzero(is_right != (x > 0.5)) <= 3


@given(segmentations(), st.data())
def test_totals_are_right_however_fine_the_atoms_become(segmentation, data):
    """Sums are kept up while atoms are cut; a partition that adds them up anew has the same."""
    session = Session(segmentation.mesh, segmentation)
    for edit in data.draw(st.lists(edits(segmentation.mesh.n_faces), max_size=6)):
        session._history.partition.numbering()  # so that there are totals to keep up
        applies(session, edit)
    kept = session._history.partition
    fresh = Partition(segmentation)
    fresh.atoms, fresh.segment, fresh.parts = kept.atoms, kept.segment, kept.parts
    fresh.names, fresh._next_id = kept.names, kept._next_id
    np.testing.assert_array_equal(kept.atom_faces, fresh.atom_faces)
    np.testing.assert_array_equal(kept._area, fresh._area)
    np.testing.assert_array_equal(kept._sureness, fresh._sureness)
    for name in ("labels", "ids", "confidence", "atom_confidence"):
        np.testing.assert_array_equal(getattr(kept.numbering(), name), getattr(fresh.numbering(), name))
    first = [np.flatnonzero(kept.atoms.face_atom == atom)[0] for atom in range(kept.atoms.n)]
    np.testing.assert_array_equal(kept.atoms.first_face, first)
