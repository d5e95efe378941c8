"""Edits done, undone and done again in memory; replay in one call; the log as a table."""

import numpy as np
import pytest
from editing_strategies import applies, assert_same, box_session, edited, segmentations
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.editing.edits import Cut, EditError, Merge
from scenewidget.editing.history import History
from scenewidget.editing.project import Operation, read_log
from scenewidget.editing.session import Session, apply_edits
from scenewidget.engine.segmentation import Segmentation

pytestmark = pytest.mark.filterwarnings("ignore:.*edits do not apply:UserWarning")


@given(edited())
def test_apply_edits_leaves_its_input_alone_and_reports_what_does_not_apply(case):
    segmentation, edits = case
    labels = segmentation.labels.copy()
    result = apply_edits(segmentation, edits)
    np.testing.assert_array_equal(segmentation.labels, labels)
    session = Session(segmentation.mesh, segmentation)
    skipped = [k for k, edit in enumerate(edits) if not applies(session, edit)]
    assert [entry[0] for entry in result.report.get("edits that do not apply", ())] == skipped
    assert_same(result, session.segmentation)


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


@given(edited(), st.data())
def test_a_log_brings_a_history_back(case, data):
    segmentation, edits = case
    history, operations = History(segmentation), []
    for edit in edits:
        try:
            _, cut = history.do(edit, when=1.0)
        except EditError:
            continue
        operations.append(Operation(1.0, "edit", edit=edit, cut=cut))
        if data.draw(st.booleans()):
            history.undo()
            operations.append(Operation(2.0, "undo"))
    again = History(segmentation)
    again.resume(read_log(operations))
    assert (again.steps, again.undone) == (history.steps, history.undone)
    assert_same(again.segmentation, history.segmentation)


def test_an_edit_that_does_not_fit_another_segmentation_stays_and_fits_again():
    automatic = box_session().automatic
    history = History(automatic)
    history.do(Merge(0, onto_face=40), 1.0)
    merged = history.segmentation
    whole = Segmentation.from_labels(automatic.mesh, np.zeros(192, int))
    history.start_from(whole)
    assert "in one segment already" in history.steps[0].problem
    assert history.segmentation is whole
    history.start_from(automatic)
    assert history.steps[0].problem == ""
    assert_same(history.segmentation, merged)


def test_a_cut_is_computed_once(monkeypatch):
    session = box_session()
    history = History(session.automatic)
    history.do(Cut(0, 31), 1.0)
    cut = history.segmentation
    monkeypatch.setattr("scenewidget.editing.partition.cut_segment", lambda *_: pytest.fail("computed again"))
    history.undo()
    history.redo(2.0)
    history.start_from(session.automatic)
    assert_same(history.segmentation, cut)


def test_nothing_to_undo_or_redo_is_said():
    history = History(box_session().automatic)
    with pytest.raises(EditError, match="nothing to undo"):
        history.undo()
    with pytest.raises(EditError, match="nothing to redo"):
        history.redo(0.0)
