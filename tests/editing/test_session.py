"""The algebra of edits: what undo, redo and replay must be, whatever a person does."""

import json
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
import shapes
from editing_strategies import assert_same, edited, segmentations
from hypothesis import given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.editing.edits import (
    Cut,
    EditError,
    Merge,
    Relabel,
    Split,
    edit_from_dict,
    edit_to_dict,
)
from scenewidget.editing.session import Session, apply_edits
from scenewidget.engine.segmentation import Segmentation

pytestmark = pytest.mark.filterwarnings("ignore:.*edits do not apply:UserWarning")


def do_all(session, edits):
    """Do the edits that apply; the number of them."""
    for edit in edits:
        try:
            session.do(edit)
        except EditError:
            continue
    return len(session.edits)


def box_session(**options):
    """A box with a segment a side, four base parts a side and a dihedral part a face."""
    mesh = shapes.box(4)
    labels = np.arange(mesh.n_faces) // 32
    levels = {"base": np.arange(mesh.n_faces) // 8, "dihedral": np.arange(mesh.n_faces)}
    levels = {name: part.astype(np.int32) for name, part in levels.items()}
    return Session(mesh, Segmentation(mesh, labels, levels=levels, **options))


# --- properties -----------------------------------------------------------------------------------


@given(edited())
def test_undo_restores_exactly_and_redo_after_it_is_the_identity(case):
    segmentation, edits = case
    session = Session(segmentation.mesh, segmentation)
    states = [session.segmentation]
    for edit in edits:
        try:
            session.do(edit)
        except EditError:
            assert_same(session.segmentation, states[-1])
        else:
            states.append(session.segmentation)
    for state in states[-2::-1]:
        session.undo()
        assert_same(session.segmentation, state)
    for state in states[1:]:
        session.redo()
        assert_same(session.segmentation, state)
    assert not session.can_redo


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


@given(edited(), st.data())
def test_a_walk_through_the_history_equals_replay_of_the_edits(case, data):
    segmentation, edits = case
    session = Session(segmentation.mesh, segmentation)
    for edit in edits:
        do_all(session, [edit])
        move = data.draw(st.sampled_from(["", "undo", "undo", "redo"]))
        if move == "undo" and session.can_undo:
            session.undo()
        if move == "redo" and session.can_redo:
            session.redo()
    assert_same(session.segmentation, apply_edits(segmentation, session.edits))


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
        assert state.names == tuple(expected.names)
        keep = expected.labels >= 0
        labels, n = expected.labels[keep], expected.n_segments
        area = np.bincount(labels, areas[keep], n)
        mean = np.bincount(labels, (areas * expected.confidence)[keep], n) / np.where(area > 0, area, 1)
        np.testing.assert_allclose(state.confidence, mean, atol=1e-5)


@given(edited())
def test_apply_edits_leaves_its_input_alone_and_reports_what_does_not_apply(case):
    segmentation, edits = case
    labels = segmentation.labels.copy()
    result = apply_edits(segmentation, edits)
    np.testing.assert_array_equal(segmentation.labels, labels)
    session = Session(segmentation.mesh, segmentation)
    skipped = [k for k, edit in enumerate(edits) if not _applies(session, edit)]
    assert [entry[0] for entry in result.report.get("edits that do not apply", ())] == skipped
    assert_same(result, session.segmentation)


def _applies(session, edit):
    try:
        session.do(edit)
    except EditError:
        return False
    return True


@given(edited(max_size=4))
def test_edits_survive_json(case):
    for edit in case[1]:
        assert edit_from_dict(json.loads(json.dumps(edit_to_dict(edit)))) == edit


@given(segmentations(), st.data())
def test_parts_move_whole(segmentation, data):
    face = data.draw(st.integers(0, segmentation.mesh.n_faces - 1))
    onto = data.draw(st.integers(0, segmentation.mesh.n_faces - 1))
    level = data.draw(st.sampled_from(["dihedral", "base", "final"]))
    part = segmentation.level(level) == segmentation.level(level)[face]
    session = Session(segmentation.mesh, segmentation)
    if _applies(session, Merge((face,), onto, level)):
        expected = segmentation.labels.astype(np.int64)
        expected[part] = segmentation.labels[onto]
    elif level != "final" and _applies(session, Split(face, level)):
        expected = segmentation.labels.astype(np.int64)
        expected[part] = segmentation.n_segments
    else:
        return
    expected = Segmentation.from_labels(segmentation.mesh, expected)
    np.testing.assert_array_equal(session.segmentation.labels, expected.labels)


@given(segmentations(), st.data())
def test_edits_of_different_segments_commute(segmentation, data):
    face = st.integers(0, segmentation.mesh.n_faces - 1)
    home = segmentation.labels
    one, other, two, second = (data.draw(face) for _ in range(4))
    groups = [{home[one], home[other]}, {home[two], home[second]}]
    if -1 in groups[0] | groups[1] or groups[0] & groups[1]:
        return
    edits = [Merge((one,), other), Merge((two,), second)]
    there, back = apply_edits(segmentation, edits), apply_edits(segmentation, edits[::-1])
    np.testing.assert_array_equal(there.labels, back.labels)
    assert there.names == back.names


@given(edited(max_size=5), st.data())
def test_another_segmentation_underneath_keeps_the_log_and_coming_back_restores(case, data):
    segmentation, edits = case
    mesh = segmentation.mesh
    session = Session(mesh, segmentation)
    do_all(session, edits)
    before, log = session.segmentation, session.edits
    other = Segmentation.from_labels(mesh, np.arange(mesh.n_faces) % data.draw(st.integers(1, 5)))
    other = Segmentation(mesh, other.labels, levels=dict(segmentation.levels))
    problems = session.resegment(other)
    assert session.edits == log
    assert [s for s in session.history if s.problem] == list(problems)
    assert_same(session.segmentation, apply_edits(other, log))
    assert session.resegment(segmentation) == ()
    assert_same(session.segmentation, before)
    session.go_to(0)
    assert session.segmentation is segmentation


# --- examples -------------------------------------------------------------------------------------


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


def test_a_brush_moves_several_parts_in_one_edit():
    session = box_session()
    step = session.merge(np.array([0, 8, 40, 0]), np.int32(100), level="base")
    assert step.title == "Merge 3 parts"
    assert step.n_faces == 24
    assert len(set(session.segmentation.labels[[0, 8, 40, 100]])) == 1
    session.undo()
    assert session.segmentation is session.automatic


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
    with pytest.raises(EditError, match="face 0 is unlabelled"):
        session.merge(0, 20)
    with pytest.raises(EditError, match="onto_face 0 is unlabelled"):
        session.merge(20, 0)
    session.merge([0, 1], 20, level="dihedral")
    assert session.segmentation.labels[0] == session.segmentation.labels[20]
    session.split(2, level="dihedral")
    assert (session.segmentation.labels >= 0).sum() == 43


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda s: s.merge(0, 1), EditError, "face 0 and onto_face 1 are in one segment already"),
        (lambda s: s.merge(192, 1), ValueError, "there is no face 192: the mesh has 192 faces"),
        (lambda s: s.merge(-1, 1), ValueError, "face"),
        (lambda s: s.merge(True, 1), TypeError, "must be the number of a face, got True"),
        (lambda s: s.merge(1.0, 1), TypeError, "face"),
        (lambda s: s.merge([], 1), ValueError, "faces is empty"),
        (lambda s: s.merge(0, 40, "middle"), ValueError, "level must be one of 'dihedral', 'base', 'final'"),
        (lambda s: s.relabel(0, 3), TypeError, "name must be a text, got int"),
        (lambda s: s.relabel(0, "x" * 201), ValueError, "at most 200 characters"),
        (lambda s: s.relabel(0, "a\0b"), ValueError, "no control characters"),
        (lambda s: s.relabel(0, "\ud800"), ValueError, "no control characters"),
        (lambda s: s.relabel(0, ""), EditError, "the segment under face 0 has no name"),
        (lambda s: s.cut(0, 0), EditError, "needs two different faces"),
        (lambda s: s.cut(0, 40), EditError, "are in different segments"),
        (lambda s: s.undo(), EditError, "nothing to undo"),
        (lambda s: s.redo(), EditError, "nothing to redo"),
        (lambda s: s.do("merge"), TypeError, "edit must be a Merge"),
        (lambda s: s.go_to(1), ValueError, r"n_edits must lie in 0\.\.0"),
        (lambda s: s.go_to("1"), TypeError, "n_edits must be a whole number, got '1'"),
        (lambda s: s.part(-1, "final"), ValueError, "face must be the number of a face, from 0, got -1"),
        (lambda s: s.part(0, "middle"), ValueError, "level must be one of"),
        (lambda s: s.part(0, "final", action="cut"), ValueError, "action must be 'merge' or 'split'"),
        (lambda s: s.observe("undo"), TypeError, "callback must be callable as callback.event., got str"),
        (lambda s: s.resegment([0]), TypeError, "segmentation must be a Segmentation, got list; Segm"),
        (lambda s: s.resegment(s.automatic, {}), TypeError, "params must be a Params, got dict; write Par"),
        (
            lambda s: setattr(s, "vocabulary", ["a", 3]),
            TypeError,
            "vocabulary holds.*must be a text, got int",
        ),
        (lambda s: s.save(), ValueError, "has no file yet"),
        (lambda s: s.save(3), TypeError, "path must be a str or a Path, got int"),
        (lambda s: s.save("."), IsADirectoryError, "it is a folder; name a file in it$"),
        (lambda s: Session.open(3), TypeError, "path must be a str or a Path, got int"),
    ],
)
def test_what_cannot_be_done_says_why_and_changes_nothing(call, error, message):
    session = box_session()
    with pytest.raises(error, match=message):
        call(session)
    assert session.segmentation is session.automatic
    assert session.edits == []
    assert session.revision == 0


def test_a_level_that_the_segmentation_lacks_is_named():
    mesh = shapes.box(2)
    session = Session(mesh, Segmentation.from_labels(mesh, np.arange(48) // 8))
    with pytest.raises(ValueError, match="has no level 'base'"):
        session.split(0, "base")


def test_a_segmentation_of_another_mesh_is_refused():
    seg = Segmentation.from_labels(shapes.box(2), np.arange(48) // 8)
    session = Session(shapes.box(2), seg)  # equal, though not the same object
    assert session.segmentation.mesh is session.mesh
    with pytest.raises(ValueError, match=r"another mesh: of one with 48 faces.* but mesh has 192 faces"):
        Session(shapes.box(4), seg)
    with pytest.raises(TypeError, match="segmentation must be a Segmentation, got list"):
        Session(shapes.box(4), [0])


def test_observers_hear_of_every_change_in_order_until_they_stop():
    session, heard = box_session(), []
    stop = session.observe(heard.append)
    session.merge(0, 40)
    session.undo()
    session.redo()
    session.vocabulary = ["desk", "chair", "desk"]
    session.resegment(session.automatic)
    stop()
    session.undo()
    assert [event.kind for event in heard] == ["edit", "undo", "redo", "vocabulary", "segmentation"]
    assert [event.revision for event in heard] == [1, 2, 3, 4, 5]
    assert session.vocabulary == ("desk", "chair")


def test_ids_of_segments_stay_while_labels_are_numbered_anew():
    session = box_session()
    before = session.atom_segments.copy()
    session.merge(0, 190)
    untouched = before != before[session.atoms.face_atom[0]]
    np.testing.assert_array_equal(session.atom_segments[untouched], before[untouched])
    preview = session.part(0, "base")
    session.split(0, "base")
    assert len(set(session.atom_segments[preview])) == 1


def test_whoever_is_told_of_a_walk_through_the_history_does_not_hold_others_up():
    session = box_session()
    session.merge(0, 40)
    session.merge(40, 70)
    seen = []

    def look_from_elsewhere(event):
        looking = threading.Thread(target=lambda: seen.append((event.kind, len(session.history))))
        looking.start()
        looking.join(10)
        assert not looking.is_alive()

    session.observe(look_from_elsewhere)
    session.go_to(0)
    session.go_to(2)
    assert seen == [("undo", 0), ("undo", 0), ("redo", 2), ("redo", 2)]


def test_threads_can_edit_at_the_same_time():
    session = box_session()

    def work(first):
        for face in range(first, 192, 4):
            try:
                session.split(face, "dihedral")
                session.relabel(face, f"part {face}")
            except EditError:
                continue

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert session.n_segments == 192 - 6 + 6
    assert_same(session.segmentation, apply_edits(session.automatic, session.edits))


REPLAY = """
import hashlib, json, sys
sys.path[:0] = {paths!r}
import test_session
from scenewidget.editing.edits import edit_from_dict
session = test_session.box_session()
for data in json.loads({log!r}):
    session.do(edit_from_dict(data))
print(hashlib.sha256(session.segmentation.labels.tobytes()).hexdigest())
"""


def test_replay_in_a_fresh_process_gives_the_same_bytes():
    import hashlib

    session = box_session()
    session.merge([0, 33], 70)
    session.cut(0, 70)
    session.split(100, "base")
    session.relabel(0, "chair")
    session.cut(120, 110)
    log = json.dumps([edit_to_dict(edit) for edit in session.edits])
    folder = Path(__file__).parent
    code = REPLAY.format(paths=[str(folder), str(folder.parent)], log=log)
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert out.stdout.strip() == hashlib.sha256(session.segmentation.labels.tobytes()).hexdigest()


def test_the_log_is_a_table_with_times():
    session = box_session()
    session.merge([0, 40], 70)
    session.cut(0, 70)
    session.relabel(0, "chair")
    session.split(8, "base")
    session.undo()
    frame = session.to_frame()
    assert frame["action"].tolist() == ["open", "edit", "edit", "edit", "edit", "undo"]
    assert frame["edit"].tolist() == ["", "merge", "cut", "relabel", "split", ""]
    assert frame["faces"].tolist()[1:3] == [(0, 40, 70), (0, 70)]
    assert frame["name"].tolist()[3] == "chair"
    assert frame["level"].tolist()[4] == "base"
    assert (frame["seconds"] >= 0).all()
    assert str(frame["time"].dt.tz) == "UTC"


@pytest.mark.parametrize(
    "data",
    [None, 3, {}, {"kind": "__import__"}, {"kind": "split"}, {"kind": "split", "face": 0, "more": 1},
     {"kind": "split", "face": "0"}, {"kind": "merge", "faces": 5.0, "onto_face": 1},
     {"kind": "merge", "faces": "12", "onto_face": 1}, {"kind": "split", "face": 2**40},
     {"kind": "split", "face": 0, "level": []}, {"kind": ["split"]}],
)  # fmt: skip
def test_damaged_edits_are_refused(data):
    with pytest.raises((ValueError, TypeError)):
        edit_from_dict(data)


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


@settings(max_examples=20)
@given(segmentations(), st.data())
def test_relabel_then_undo_restores_names(segmentation, data):
    session = Session(segmentation.mesh, segmentation)
    face = data.draw(st.integers(0, segmentation.mesh.n_faces - 1))
    if _applies(session, Relabel(face, "new name")):
        assert session.segmentation.names[session.segmentation.labels[face]] == "new name"
        session.undo()
    assert session.segmentation.names == segmentation.names


def test_cut_needs_both_seeds_on_their_sides():
    session = box_session()
    session.merge([40, 70, 100, 130, 170], 0)
    session.do(Cut(0, 190))
    labels = session.segmentation.labels
    assert session.segmentation.n_segments == 2
    assert labels[0] != labels[190]


def test_the_preview_of_a_cut_is_what_the_cut_then_does():
    session = box_session()
    session.merge([40, 70, 100, 130, 170], 0)
    before = session.segmentation.labels
    faces = session.preview_cut(0, 190)
    assert session.segmentation.labels is before
    assert len(session.history) == 1
    session.cut(0, 190)
    labels = session.segmentation.labels
    np.testing.assert_array_equal(faces, np.flatnonzero(labels == labels[190]))
    with pytest.raises(EditError, match="different segments"):
        session.preview_cut(0, 190)
