"""Edits between the picture and the session, without a browser."""

import threading

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.editing.edits import Grow, Merge
from scenewidget.editing.face_set import FaceSet
from scenewidget.editing.partition import Partition
from scenewidget.palette import adjacent_segments, segment_colors
from scenewidget.widget.autosave import Autosave
from scenewidget.widget.edit_commands import EditCommands
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.wire import middle_of

SMALL = sw.Params(n_segments=6, n_runs=4, n_graph_runs=4)


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def mesh():
    """A box of 4 × 3 × 2.4 m seen from inside."""
    box = shapes.box(16, size=(4.0, 3.0, 2.4))
    return sw.Mesh(box.vertices, box.faces[:, ::-1])


@pytest.fixture(scope="module")
def automatic(mesh):
    return sw.segment(mesh, SMALL)


@pytest.fixture
def commands(mesh, automatic):
    """Edit commands whose session can be asked, with its view."""
    view, lock = SceneView(mesh, editable=True), threading.RLock()
    commands = EditCommands(view, lock, Autosave(view, lock, False, print), lambda: None)
    commands.take(automatic, SMALL)
    return commands


def shown(view, name, dtype=np.uint32):
    return np.frombuffer(getattr(view, f"_{name}"), dtype)


def test_the_picture_shows_what_the_session_holds_after_any_walk(commands, mesh):
    view, session, rng = commands._view, commands.session, np.random.default_rng(0)
    for k in range(60):
        a, b = (int(face) for face in rng.integers(0, mesh.n_faces, 2))
        kind = ("merge", "split", "undo", "redo", "relabel", "group")[k % 6]
        commands.handle(
            {"kind": kind, "face": a, "onto_face": b, "level": ("dihedral", "base", "final")[k % 3],
             "name": f"name {k}", "revision": view.revision}
        )  # fmt: skip
        if k == 30:
            session.cut(*np.flatnonzero(session.segmentation.labels == 0)[[0, -1]])
        expected = session.segmentation
        labels = shown(view, "atom_segment").astype(np.int32)[shown(view, "face_atom")]
        np.testing.assert_array_equal(labels, expected.labels)
        names = {str(i): name for i, name in enumerate(expected.names) if name}
        assert (view.segment_names, view.n_segments) == (names, expected.n_segments)
        parts = {str(i): whole for i, whole in enumerate(expected.groups) if whole != i}
        assert view.segment_groups == parts
        confidence = expected.to_frame()["confidence"]
        np.testing.assert_allclose(shown(view, "segment_confidence", np.float32), confidence, rtol=1e-5)
    assert len(session.edits) > 10


def test_files_have_the_colours_that_the_picture_shows_after_edits(commands, mesh):
    view, session, rng = commands._view, commands.session, np.random.default_rng(1)
    for k in range(24):
        a, b = (int(face) for face in rng.integers(0, mesh.n_faces, 2))
        kind = ("split", "merge", "merge", "undo")[k % 4]
        level = ("dihedral", "dihedral", "base", "final")[k % 4]
        message = {"kind": kind, "face": a, "onto_face": b, "level": level, "revision": view.revision}
        commands.handle(message)
        np.testing.assert_array_equal(segment_colors(session.segmentation)[:-1], view.segment_colors)
    assert session.revision > 12


def test_neighbours_out_of_atoms_are_those_of_the_faces(commands, mesh):
    view = commands._view
    for edit in ({"kind": "split", "face": 5, "level": "dihedral"}, {"kind": "undo"}):
        commands.handle({**edit, "revision": view.revision})
        labels = commands.session.segmentation.labels
        expected = adjacent_segments(mesh.faces, labels, mesh.n_vertices).tolist()
        expected = {(a, b) for a, b in expected} | {(b, a) for a, b in expected}
        for wanted in (slice(None), slice(1, 3), slice(0)):
            is_wanted = np.zeros(labels.max() + 1, bool)
            is_wanted[wanted] = True
            seen = {
                tuple(pair) for pair in view._colors.segment_pairs(view._colors.table, is_wanted).tolist()
            }
            assert seen == {pair for pair in expected if is_wanted[pair[0]]}


def test_labels_per_face_are_made_only_when_somebody_wants_them(mesh, monkeypatch):
    widget = sw.SceneWidget(mesh, SMALL)
    before = widget.wait(60)
    made = []
    whole = Partition.segmentation
    monkeypatch.setattr(Partition, "segmentation", lambda self: made.append(1) or whole(self))
    first, second, third = (int(np.argmax(before.labels == segment)) for segment in range(3))
    edit = {"kind": "merge", "onto_face": first, "level": "final", "revision": widget.view.revision}
    widget.view._handle_custom_msg({**edit, "face": second}, [])
    assert widget.view.n_segments == before.n_segments - 1
    assert made == []
    assert widget.segmentation.n_segments == before.n_segments - 1
    assert widget.segmentation is widget.segmentation
    assert made == [1]
    told = []
    widget.observe(lambda change: told.append(change["new"]), "segmentation")
    widget.view._handle_custom_msg({**edit, "face": third}, [])
    assert [seg.n_segments for seg in told] == [before.n_segments - 2]
    assert made == [1, 1]
    widget.close()


def send(commands, kind, **message):
    commands.handle({"kind": kind, "revision": commands._view.revision, "level": "final", **message})


def test_the_history_is_listed_while_it_is_shown_and_can_be_walked(commands):
    view, session = commands._view, commands.session
    faces = [int(np.argmax(session.segmentation.labels == segment)) for segment in range(3)]
    send(commands, "merge", face=faces[1], onto_face=faces[0])
    assert view.history == []
    view.history_shown = True
    send(commands, "merge", face=[faces[2], faces[0]], onto_face=faces[1])
    send(commands, "relabel", face=faces[0], name="chair")
    assert [(row["n"], row["title"]) for row in view.history] == [
        (1, "Merge"), (2, "Merge 2 parts"), (3, "Name 'chair'"),
    ]  # fmt: skip
    assert all(row["time"] > 1e9 and row["problem"] == "" for row in view.history)
    labels = session.segmentation.labels
    send(commands, "go_to", n=1)
    assert (view.n_done, len(session.edits), view.redo_title) == (1, 1, "Merge 2 parts")
    assert [row["n"] for row in view.history] == [1, 2, 3]
    send(commands, "go_to", n=3)
    np.testing.assert_array_equal(session.segmentation.labels, labels)
    send(commands, "go_to", n=2)
    send(commands, "split", face=faces[0], level="dihedral")
    send(commands, "go_to", n=9)  # listed before the last edit made an end of what could be redone
    assert (view.n_done, view.error) == (3, "")


def test_steps_that_no_longer_apply_are_listed_with_the_reason(commands, mesh):
    view = commands._view
    view.history_shown = True
    labels = commands.session.segmentation.labels
    send(commands, "merge", face=int(np.argmax(labels == 1)), onto_face=int(np.argmax(labels == 0)))
    commands.take(sw.Segmentation.from_labels(mesh, np.zeros(mesh.n_faces, int)), SMALL)
    assert "in one segment already" in view.history[0]["problem"]


def test_a_cut_divides_what_is_under_both_points(commands, mesh):
    labels = commands.session.segmentation.labels
    a, b = (int(face) for face in np.flatnonzero(labels == 0)[[0, -1]])
    n = commands._view.n_segments
    send(commands, "cut", face_a=a, face_b=b)
    assert commands._view.n_segments == n + 1
    assert commands._view.undo_title == "Cut"


def test_names_used_last_come_first_and_keys_stay(commands):
    view = commands._view
    assert view.quick_names == list(commands.session.vocabulary[:7])
    for name in ("lamp", "my own"):
        send(commands, "relabel", face=0, name=name)
    assert view.vocabulary[:3] == ["my own", "lamp", "wall"]
    assert view.quick_names == [*commands.session.vocabulary[:5], "my own", "lamp"]
    assert view.vocabulary.count("lamp") == 1


def test_a_vocabulary_given_is_that_of_a_restored_session_too(mesh):
    first = sw.SceneWidget(mesh, SMALL, autosave=False)
    first.wait(60)
    path = first.save("a.swproj")
    first.session.close()
    second = sw.SceneWidget(mesh, SMALL, vocabulary=["lid", "box"])
    second.wait(60)
    assert second.view.vocabulary == ["lid", "box"]
    second.restore(path)
    assert second.session.vocabulary == ("lid", "box")
    with pytest.raises(ValueError, match="'nyu40', 'scannet20' or a list"):
        sw.SceneWidget(mesh, SMALL, vocabulary="coco")
    second.session.close()


def test_the_preview_of_a_cut_crosses_as_bits(commands, monkeypatch):
    answers = []
    monkeypatch.setattr(commands._view, "send", lambda content, buffers: answers.append((content, *buffers)))
    labels = commands.session.segmentation.labels
    a, b = (int(face) for face in np.flatnonzero(labels == 0)[[0, -1]])
    send(commands, "preview_cut", face_a=a, face_b=b, request="x1")
    send(commands, "preview_cut", face_a=a, face_b=int(np.argmax(labels == 1)), request="x2")
    send(commands, "preview_cut", face_a=a, face_b=b, request="x3", revision=-1)
    assert [content["request"] for content, _ in answers] == ["x1", "x2", "x3"]
    assert [bits for _, bits in answers[1:]] == [b"", b""]
    content, bits = answers[0]
    faces = content["first"] + np.flatnonzero(np.unpackbits(np.frombuffer(bits, np.uint8), bitorder="little"))
    np.testing.assert_array_equal(faces, commands.session.preview_cut(a, b))
    assert (commands.session.edits, commands._view.error) == ([], "")


def test_the_preview_of_an_edit_says_what_would_move_or_why_not(commands, monkeypatch):
    answers = []
    monkeypatch.setattr(commands._view, "send", lambda content, buffers: answers.append((content, *buffers)))
    face = int(np.flatnonzero(commands.session.automatic.labels == 0)[0])
    for request, edit in (
        ("x1", {"kind": "grow", "face": face}),
        ("x2", {"kind": "fill_holes", "face": face}),
    ):
        commands.handle({"kind": "preview_edit", "edit": edit, "request": request})
    (grown, bits), (filled, nothing) = answers
    faces = grown["first"] + np.flatnonzero(np.unpackbits(np.frombuffer(bits, np.uint8), bitorder="little"))
    np.testing.assert_array_equal(faces, commands.session.preview(Grow(face)))
    assert (grown["reason"], nothing, filled["request"]) == ("", b"", "x2")
    assert "has no hole" in filled["reason"]
    assert commands.session.edits == []
    with pytest.raises(TypeError, match="edit must be a Paint, Slice, Grow"):
        commands.session.preview(Merge(face, face + 1))


def test_a_stroke_counts_even_if_another_segmentation_has_come_meanwhile(commands):
    view = commands._view
    before = view.revision
    commands.take(commands.session.automatic, sw.Params())  # edits are made on it again
    commands.take(
        sw.Segmentation.from_labels(view.mesh, np.zeros(view.mesh.n_faces, np.int32)), sw.Params(n_runs=3)
    )
    assert view.revision > before
    commands.handle({"kind": "paint", "ranges": [3, 9], "onto_face": None, "revision": before})
    assert [step.title for step in commands.session.history] == ["New segment of 6 faces"]


def test_free_form_edits_come_as_messages_and_what_is_wrong_is_said(commands, mesh):
    view, session = commands._view, commands.session
    face = int(np.flatnonzero(session.automatic.labels == 0)[0])
    inside = np.flatnonzero(session.automatic.labels == 0)[:7]
    ranges = FaceSet(inside).ranges.tolist()
    middle = mesh.face_centroids[session.automatic.labels == 0].mean(axis=0) - middle_of(mesh)
    for message in (
        {"kind": "paint", "ranges": ranges, "onto_face": None},
        {"kind": "grow", "face": face, "rings": 2},
        {"kind": "undo"},
        {"kind": "slice", "face": int(np.flatnonzero(session.automatic.labels == 0)[-1]),
         "point": middle.tolist(), "normal": [1.0, 1.0, 1.0]},
    ):  # fmt: skip
        commands.handle({**message, "revision": view.revision})
    assert [step.title for step in session.history] == ["New segment of 7 faces", "Slice"]
    assert len(set(session.segmentation.labels[inside])) == 1
    np.testing.assert_allclose(session.edits[-1].point, middle + middle_of(mesh))
    commands.handle({"kind": "paint", "ranges": ranges, "onto_face": face, "revision": view.revision})
    assert view.status == f"All faces are in the segment under onto_face {face} already"
    with pytest.raises(ValueError, match="ranges must hold"):
        commands.handle({"kind": "paint", "ranges": [5, 2], "revision": view.revision})
    assert len(session.history) == 2
