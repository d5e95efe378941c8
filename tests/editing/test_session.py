"""The algebra of edits: what undo, redo and replay must be, whatever a person does."""

import json
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
import shapes
from editing_strategies import applies, assert_same, box_session, do_all, edited, segmentations
from hypothesis import given, settings
from hypothesis import strategies as st

from scenewidget.editing.edits import (
    EditError,
    Relabel,
    edit_to_dict,
)
from scenewidget.editing.session import Session, apply_edits
from scenewidget.engine.segmentation import Segmentation

pytestmark = pytest.mark.filterwarnings("ignore:.*edits do not apply:UserWarning")


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


def test_a_brush_moves_several_parts_in_one_edit():
    session = box_session()
    step = session.merge(np.array([0, 8, 40, 0]), np.int32(100), level="base")
    assert step.title == "Merge 3 parts"
    assert step.n_faces == 24
    assert len(set(session.segmentation.labels[[0, 8, 40, 100]])) == 1
    session.undo()
    assert session.segmentation is session.automatic


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
        (lambda s: s.paint([0, 192], 40), ValueError, "there is no face 192: the mesh has 192 faces"),
        (lambda s: s.paint([0], 192), ValueError, "there is no face 192"),
        (lambda s: s.paint([-1, 3]), ValueError, "faces must hold numbers of faces, from 0, got -1"),
        (lambda s: s.paint([]), ValueError, "faces is empty: it needs at least one face"),
        (
            lambda s: s.paint([[0, 1]]),
            ValueError,
            r"faces must be a list of numbers, \(n,\), got an array of",
        ),
        (lambda s: s.paint([0.0, 1.5]), TypeError, "faces must hold whole numbers, got float64"),
        (lambda s: s.paint(np.ones(192, bool)), TypeError, r"got a mask; write np.flatnonzero\(mask\)"),
        (lambda s: s.paint("012"), TypeError, "faces must be a sequence of whole numbers, got '012'"),
        (lambda s: s.paint(7), TypeError, "faces must be a sequence of whole numbers, got 7"),
        (lambda s: s.paint([0, 1], 2), EditError, "all faces are in the segment under onto_face 2 already"),
        (lambda s: s.paint(range(32)), EditError, "the faces are a segment of their own already"),
        (lambda s: s.paint([0], 1.0), TypeError, "onto_face must be the number of a face, got 1.0"),
        (lambda s: s.slice(0, (0, 0, 0), (0, 0, 0)), ValueError, "normal has length 0"),
        (lambda s: s.slice(0, (0, 0), (0, 0, 1)), ValueError, "point must be three finite numbers"),
        (lambda s: s.slice(0, (0, 0, np.inf), (0, 0, 1)), ValueError, "point must be three finite numbers"),
        (lambda s: s.slice(0, 3, (0, 0, 1)), TypeError, "point must be three numbers, got 3"),
        (
            lambda s: s.slice(0, (9, 9, 9), (0, 1, 0)),
            EditError,
            "plane leaves the segment under face 0 on one",
        ),
        (lambda s: s.grow(0, 0), ValueError, "rings must be"),
        (lambda s: s.shrink(0, 99), EditError, "nothing would remain of the segment under face 0"),
        (lambda s: s.fill_holes(0), EditError, "has no hole of at most 100 faces"),
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
        (lambda s: s.save("room.PLY"), ValueError, r"'room.PLY' is no name for .*save\('room.swproj'\)"),
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


def test_ids_of_segments_stay_while_labels_are_numbered_anew():
    session = box_session()
    before = session.atom_segments.copy()
    session.merge(0, 190)
    untouched = before != before[session.atoms.face_atom[0]]
    np.testing.assert_array_equal(session.atom_segments[untouched], before[untouched])
    preview = session.part(0, "base")
    session.split(0, "base")
    assert len(set(session.atom_segments[preview])) == 1


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
import editing_strategies
from scenewidget.editing.edits import edit_from_dict
session = editing_strategies.box_session()
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


@settings(max_examples=20)
@given(segmentations(), st.data())
def test_relabel_then_undo_restores_names(segmentation, data):
    session = Session(segmentation.mesh, segmentation)
    face = data.draw(st.integers(0, segmentation.mesh.n_faces - 1))
    if applies(session, Relabel(face, "new name")):
        assert session.segmentation.names[session.segmentation.labels[face]] == "new name"
        session.undo()
    assert session.segmentation.names == segmentation.names


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


def test_an_observer_may_raise_and_the_edit_stands(capsys):
    session, heard = box_session(), []

    def faulty(event):
        raise ZeroDivisionError("mine")

    session.observe(faulty)
    session.observe(heard.append)
    step = session.merge(0, 40)
    assert session.history[-1] is step
    assert [event.step for event in heard] == [step]
    said = capsys.readouterr().err
    assert "An observer has failed; the edit that it was told of stands." in said
    assert "in faulty" in said
    assert "ZeroDivisionError: mine" in said
    assert "callback(event)" not in said


def test_an_edit_of_a_level_that_the_next_segmentation_lacks_waits_for_a_better_one():
    session = box_session()
    session.split(100, "base")
    expected, automatic = session.segmentation, session.automatic
    plain = Segmentation.from_labels(session.mesh, np.arange(192) // 48)
    (step,) = session.resegment(plain)
    assert "has no level 'base'" in step.problem
    assert session.resegment(automatic) == ()
    assert_same(session.segmentation, expected)
