"""The widget without a browser: what a script sees of it."""

import gc
import threading
import weakref

import numpy as np
import pytest
import shapes
import traitlets

import scenewidget as sw

SMALL = sw.Params(n_segments=6, n_runs=4, n_graph_runs=4)


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    """What is edited is saved beside the notebook: here, in a folder of the test's own."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def mesh():
    """A box of 4 × 3 × 2.4 m seen from inside."""
    box = shapes.box(24, size=(4.0, 3.0, 2.4))
    return sw.Mesh(box.vertices, box.faces[:, ::-1])


@pytest.fixture
def widget(mesh):
    widget = sw.SceneWidget(mesh, SMALL)
    yield widget
    widget.close()


def test_the_result_is_that_of_segment(widget, mesh):
    expected = sw.segment(mesh, SMALL)
    found = widget.wait(60)
    np.testing.assert_array_equal(found.labels, expected.labels)
    assert found is widget.segmentation
    assert widget.session.segmentation is found
    assert widget.view.n_segments == expected.n_segments
    assert (widget.busy, widget.view.busy, widget.view.error) == (False, False, "")


def test_its_repr_is_short_and_says_what_it_shows(widget):
    n_segments = widget.wait(60).n_segments
    assert repr(widget) == f"SceneWidget({widget.mesh.n_faces} faces, {n_segments} segments)"


def test_the_scan_is_shown_before_anything_is_computed(mesh, monkeypatch):
    gate = threading.Event()
    run = sw.Pipeline.run
    monkeypatch.setattr(sw.Pipeline, "run", lambda *args, **kwargs: gate.wait(30) and run(*args, **kwargs))
    widget = sw.SceneWidget(mesh, SMALL)
    assert widget.segmentation is None
    assert widget.busy
    assert len(widget.view._faces) == 12 * mesh.n_faces
    gate.set()
    assert widget.wait(60).n_segments == widget.view.n_segments
    widget.close()


def test_settings_follow_params_and_params_follow_settings(widget):
    widget.wait(60)
    controls = widget.controls
    assert (controls.values["n_segments"], controls.k_bounds) == (6, [12, 15])
    controls.set("n_segments", 8)
    assert widget.params == SMALL.replace(n_segments=8)
    assert controls.k_bounds == [16, 20]
    controls.set("k_range", [10, 30])
    assert widget.params == SMALL.replace(n_segments=8, k_range=(10, 30))
    controls.set("k_range", None)
    assert widget.params.k_range is None
    widget.params = sw.Params.thesis(n_segments=20)
    assert controls.params is widget.params
    assert (controls.values["n_segments"], controls.values["cost_exponent"]) == (20, 1.5)
    widget.params = SMALL
    widget.wait(60)


def test_a_slider_recomputes_only_what_depends_on_it(widget):
    widget.wait(60)
    widget.params = SMALL.replace(k_range=(12, 15))
    widget.wait(60)
    widget.controls.set("n_segments", 5)
    spent = {stage for stage, seconds in widget.wait(60).timings.items() if seconds > 0}
    assert spent == {"family", "granularity"}


def test_new_params_replace_a_computation_under_way(widget):
    for n_segments in (3, 4, 5, 7):
        widget.params = SMALL.replace(n_segments=n_segments)
    np.testing.assert_array_equal(
        widget.wait(60).labels, sw.segment(widget.mesh, SMALL.replace(n_segments=7)).labels
    )


def test_cancel_keeps_the_last_good_result_and_can_be_made_good(widget):
    good = widget.wait(60)
    widget.params = SMALL.replace(seed=1, n_runs=10_000)
    widget.view._handle_custom_msg({"kind": "cancel"}, [])
    assert widget.wait(60) is good
    assert "Cancelled" in widget.view.status
    assert widget.controls.can_rerun
    widget.params = SMALL
    widget.wait(60)
    assert not widget.controls.can_rerun


def test_an_error_is_shown_and_raised_and_loses_nothing(widget, monkeypatch):
    good = widget.wait(60)

    def fail(*_, **__):
        raise ValueError("<b>no</b> such thing")

    monkeypatch.setattr(widget.pipeline, "run", fail)
    widget.params = SMALL.replace(seed=3)
    with pytest.raises(ValueError, match="such thing"):
        widget.wait(10)
    assert widget.view.error == "ValueError: <b>no</b> such thing"
    assert widget.segmentation is good
    assert not widget.busy


def test_waiting_has_an_end(mesh, monkeypatch):
    gate = threading.Event()
    monkeypatch.setattr(sw.Pipeline, "run", lambda *_, **__: gate.wait(30))
    widget = sw.SceneWidget(mesh, SMALL)
    with pytest.raises(TimeoutError, match=r"after 0\.1 seconds"):
        widget.wait(0.1)
    monkeypatch.undo()
    widget.cancel()
    gate.set()
    with pytest.raises(RuntimeError, match="cancelled before there was a result"):
        widget.wait(10)
    widget.close()


def test_observers_are_told_of_results(widget):
    widget.wait(60)
    seen = []
    widget.observe(lambda change: seen.append(change["new"]), "segmentation")
    widget.params = SMALL.replace(n_segments=4)
    assert seen == [widget.wait(60)]


def test_params_set_while_a_result_is_taken_in_leave_the_widget_busy_with_them(widget, monkeypatch):
    widget.wait(60)
    other, another = SMALL.replace(n_segments=5), SMALL.replace(n_segments=4)
    seen = []
    run = widget.pipeline.run

    def watched(params, **options):
        seen.append((params, widget.busy, widget.view.busy, widget.controls.can_rerun))
        return run(params, **options)

    monkeypatch.setattr(widget.pipeline, "run", watched)

    def once(_):
        if widget.params == other:
            widget.params = another

    widget.observe(once, "segmentation")
    widget.params = other
    widget.wait(60)
    assert seen == [(other, True, True, False), (another, True, True, False)]
    assert (widget.busy, widget.view.busy, widget.params) == (False, False, another)


def gesture(widget, **message):
    """What the browser sends after a gesture."""
    message.setdefault("revision", widget.view.revision)
    widget.view._handle_custom_msg(message, [])


def one_face_each(segmentation, n):
    """A face of each of the first segments."""
    return [int(np.argmax(segmentation.labels == segment)) for segment in range(n)]


def test_gestures_edit_and_can_be_undone(widget):
    before = widget.wait(60)
    first, second = one_face_each(before, 2)
    assert (widget.view.undo_title, widget.view.redo_title) == ("", "")
    gesture(widget, kind="merge", face=second, onto_face=first, level="final")
    assert widget.segmentation.n_segments == before.n_segments - 1 == widget.view.n_segments
    assert widget.segmentation.labels[first] == widget.segmentation.labels[second]
    assert (widget.view.undo_title, widget.view.redo_title) == ("Merge", "")
    gesture(widget, kind="undo")
    np.testing.assert_array_equal(widget.segmentation.labels, before.labels)
    assert (widget.view.undo_title, widget.view.redo_title) == ("", "Merge")
    assert widget.view.status == "Undone: Merge"
    gesture(widget, kind="redo")
    gesture(widget, kind="split", face=second, level="final")
    assert widget.segmentation.n_segments == before.n_segments
    assert len(widget.session.edits) == 2


def test_a_merged_segment_has_the_colour_of_the_one_it_was_moved_onto(widget):
    large, _, small = one_face_each(widget.wait(60), 3)
    color = widget.view.segment_colors[2].tolist()
    gesture(widget, kind="merge", face=large, onto_face=small, level="final")
    label = widget.segmentation.labels[large]
    assert widget.view.segment_colors[label].tolist() == color


def test_a_name_given_in_the_picture_is_that_of_the_segment(widget):
    before = widget.wait(60)
    first, second = one_face_each(before, 2)
    assert "chair" in widget.view.vocabulary
    gesture(widget, kind="relabel", face=second, name=" <b>sofa</b> ")
    assert widget.segmentation.names[1] == "<b>sofa</b>"
    assert widget.view.segment_names == {"1": "<b>sofa</b>"}
    gesture(widget, kind="merge", face=second, onto_face=first, level="final")
    assert widget.segmentation.names[widget.segmentation.labels[first]] == "<b>sofa</b>"
    widget.session.vocabulary = ["box", "lid"]
    assert widget.view.vocabulary == ["<b>sofa</b>", "box", "lid"]  # what was used comes first


def test_gestures_may_follow_each_other_faster_than_the_picture(widget):
    before = widget.wait(60)
    seen = widget.view.revision
    first, second, third = one_face_each(before, 3)
    gesture(widget, kind="merge", face=second, onto_face=first, level="final", revision=seen)
    gesture(widget, kind="merge", face=third, onto_face=first, level="final", revision=seen)
    assert widget.segmentation.n_segments == before.n_segments - 2


def test_a_gesture_on_another_segmentation_does_nothing(widget):
    first, second = one_face_each(widget.wait(60), 2)
    seen = widget.view.revision
    widget.params = SMALL.replace(seed=5)
    before = widget.wait(60)
    message = {"kind": "merge", "face": second, "onto_face": first, "level": "final"}
    gesture(widget, **message, revision=seen, client="a", number=1)
    assert widget.segmentation is before
    assert "nothing was edited" in widget.view.status
    assert widget.view._answers == {"a": 1}


def test_every_message_is_answered_together_with_what_it_changed(widget, monkeypatch):
    first, second = one_face_each(widget.wait(60), 2)
    sent = []
    monkeypatch.setattr(widget.view, "send_state", lambda key=None: sent.append(set(key)))
    merge = {"kind": "merge", "face": second, "onto_face": first, "level": "final", "client": "a"}
    gesture(widget, **merge, number=1)
    assert [keys for keys in sent if "_answers" in keys or "_atom_segment" in keys] == [
        keys for keys in sent if {"_answers", "_atom_segment", "undo_title"} <= keys
    ]
    assert widget.view._answers == {"a": 1}
    gesture(widget, **merge, number=2)  # refused: in one segment already
    gesture(widget, kind="undo", client="b", number=1)
    assert widget.view._answers == {"a": 2, "b": 1}


def test_a_damaged_message_is_answered_shown_and_raised(widget):
    before = widget.wait(60)
    split = {"kind": "split", "revision": widget.view.revision, "client": "a"}
    with pytest.raises(KeyError, match="level"):
        widget._handle_message(None, {**split, "face": 0, "number": 1}, [])
    with pytest.raises(ValueError, match="there is no face"):
        widget._handle_message(None, {**split, "face": 10**9, "level": "final", "number": 2}, [])
    assert "there is no face" in widget.view.error
    assert widget.view._answers == {"a": 2}
    assert widget.segmentation is before


def test_the_view_knows_how_sure_each_segment_is(widget):
    frame = widget.wait(60).to_frame()
    sent = np.frombuffer(widget.view._segment_confidence, np.float32)
    np.testing.assert_allclose(sent, frame["confidence"], rtol=1e-5)


def test_an_edit_that_makes_no_sense_is_explained(widget):
    before = widget.wait(60)
    face = int(np.argmax(before.labels == 0))
    gesture(widget, kind="merge", face=face, onto_face=face, level="final")
    assert widget.segmentation.n_segments == before.n_segments
    assert widget.view.status
    gesture(widget, kind="undo")
    assert widget.view.status == "There is nothing to undo"


def test_edits_survive_other_parameters(widget):
    before = widget.wait(60)
    first, second = (int(np.argmax(before.labels == segment)) for segment in (0, 1))
    widget.session.merge(second, first)
    widget.params = SMALL.replace(seed=5)
    after = widget.wait(60)
    assert after.labels[first] == after.labels[second]
    assert len(widget.session.edits) == 1


@pytest.mark.parametrize(
    ("mesh", "params", "error", "message"),
    [
        ("no_such_file.ply", None, FileNotFoundError, "no_such_file.ply"),
        (42, None, TypeError, "mesh must be a path"),
        ((np.zeros((3, 3)), np.zeros((0, 3), int)), None, sw.MeshError, "faces is empty"),
        ((np.eye(3), [[0, 1, 2]]), {"n_segments": 3}, TypeError, "params must be a Params"),
    ],
)
def test_bad_input_is_refused_at_once(mesh, params, error, message):
    with pytest.raises(error, match=message):
        sw.SceneWidget(mesh, params)


REFUSED = [
    (
        lambda w: w.wait("a minute"),
        TypeError,
        "timeout must be a number of seconds or None, got 'a minute'",
    ),
    (lambda w: w.wait(float("nan")), ValueError, "timeout must be a number of seconds or None, got nan"),
    (lambda w: w.save(3), TypeError, "path must be a str or a Path, got int"),
    (lambda w: w.restore(3), TypeError, "path must be a str or a Path, got int"),
    (lambda w: w.restore("no.swproj"), FileNotFoundError, "no.swproj' does not exist"),
    (lambda w: w.to_html(3), TypeError, "path must be a str or a Path, got int"),
    (
        lambda w: w.observe("me", "params"),
        TypeError,
        "handler must be callable as handler.change., got 'me'",
    ),
    (lambda w: setattr(w, "segmentation", w.segmentation), traitlets.TraitError, "read-only"),
    (
        lambda w: setattr(w, "n_segments", 3),
        AttributeError,
        r"w.params = w.params.replace\(n_segments=…\)",
    ),
    (lambda w: setattr(w, "color_by", "scan"), AttributeError, r"write w.view.color_by = …"),
    (lambda w: setattr(w, "parms", 3), AttributeError, "did you mean 'params'"),
    (lambda w: w.merge(1, 2), AttributeError, "it is w.session.merge"),
    (lambda w: w.labels, AttributeError, "it is w.segmentation.labels"),
    (lambda w: w.nothing, AttributeError, "no attribute 'nothing'$"),
    (
        lambda w: setattr(w.params, "seed", 3),
        AttributeError,
        r"w.params = w.params.replace\(seed=…\)",
    ),
    (lambda w: setattr(w, "params", {}), traitlets.TraitError, "expected a Params, not the dict"),
]


def test_what_cannot_be_asked_of_a_widget_says_why(widget):
    before = widget.wait(60)
    for call, error, message in REFUSED:
        with pytest.raises(error, match=message):
            call(widget)
        assert widget.wait(60) is before


def test_its_height_can_be_asked_and_set(widget):
    widget.height = 300
    assert (widget.height, widget.view.height) == (300, 300)


def test_what_is_closed_can_be_forgotten(mesh):
    widget = sw.SceneWidget(mesh, SMALL, truth=np.zeros(mesh.n_faces, int), autosave=False)
    widget.wait(60)
    known = [weakref.ref(widget), weakref.ref(widget.pipeline), weakref.ref(widget.session)]
    widget.close()
    del widget
    gc.collect()
    assert [reference() for reference in known] == [None, None, None]


def test_the_picture_can_be_saved_as_a_page(widget, tmp_path):
    widget.wait(60)
    path = widget.to_html(tmp_path / "room.html")
    page = path.read_text(encoding="utf-8")
    assert f"<title>{widget!r}</title>" in page
    assert '"editable":false' in page
