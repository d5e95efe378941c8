"""Suggestions one at a time: shown, followed, passed over, and never followed unseen."""

import json

import pytest
import shapes

import scenewidget as sw

SMALL = sw.Params(n_segments=6, n_runs=8, n_graph_runs=12, min_area=0.0)


@pytest.fixture
def widget():
    mesh, _ = shapes.room(10, noise=0.003)
    widget = sw.SceneWidget(mesh, SMALL, autosave=False)
    widget.wait(60)
    yield widget
    widget.close()


def ask(widget, what, number=None):
    shown = widget.view.suggestion.get("number", 0) if number is None else number
    widget.view._handle_custom_msg({"kind": "suggest", "do": what, "number": shown}, [])


def test_the_next_suggestion_is_the_best_of_the_session(widget):
    best = widget.session.suggestions(1)[0]
    ask(widget, "next")
    shown = widget.view.suggestion
    assert (shown["kind"], shown["face"], shown["onto_face"]) == (best.kind, best.face, best.onto_face)
    assert (shown["level"], shown["title"]) == (best.level, best.title)
    assert widget.session.edits == []


def test_accept_does_the_edit_and_shows_the_one_after_it(widget):
    ask(widget, "next")
    edit = widget.session.suggestions(1)[0].edit
    ask(widget, "accept")
    assert widget.session.edits == [edit]
    after = widget.session.suggestions(1)
    assert widget.view.suggestion.get("title") == (after[0].title if after else None)


def test_an_accepted_suggestion_is_an_edit_made_in_the_picture_and_begins_the_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mesh, _ = shapes.room(10, noise=0.003)
    widget = sw.SceneWidget(mesh, SMALL)
    widget.wait(60)
    ask(widget, "next")
    ask(widget, "accept")
    widget._autosave.wait()
    assert len(list(tmp_path.glob("*.swproj"))) == 1
    assert widget.view.save_state == "saved"
    widget.close()


def test_names_that_shapes_tell_are_given_on_request(widget):
    ask(widget, "names")
    names = [name for name in widget.segmentation.names if name]
    assert {"floor", "ceiling", "wall"} == set(names)
    assert "Named" in widget.view.status
    assert "1 floor" in widget.view.status
    n_edits = len(widget.session.edits)
    assert n_edits == len(names)
    ask(widget, "names")
    assert len(widget.session.edits) == n_edits
    assert "No names that the shapes alone tell" in widget.view.status


def test_the_log_has_what_was_shown(widget):
    ask(widget, "next")
    ask(widget, "skip")
    actions = [operation.action for operation in widget.session.operations]
    n_shown = 1 + ("title" in widget.view.suggestion)
    assert actions == ["open", "propose", "dismiss", *["propose"] * (n_shown - 1)]


def test_skip_changes_nothing_and_does_not_come_back(widget):
    ask(widget, "next")
    first = widget.view.suggestion
    ask(widget, "skip")
    second = widget.view.suggestion
    assert widget.session.edits == []
    assert (second.get("face"), second.get("onto_face")) != (first["face"], first["onto_face"])


def test_an_answer_to_another_suggestion_is_passed_over(widget):
    ask(widget, "next")
    number = widget.view.suggestion["number"]
    ask(widget, "skip")
    ask(widget, "accept", number)
    assert widget.session.edits == []


def is_shown(widget):
    return "title" in widget.view.suggestion


def test_other_edits_and_close_take_it_away(widget):
    ask(widget, "next")
    ask(widget, "close")
    assert not is_shown(widget)
    ask(widget, "next")
    labels = widget.segmentation.labels
    widget.session.merge(0, int((labels != labels[0]).argmax()))
    assert not is_shown(widget)


def test_when_nothing_is_left_it_says_so(widget):
    ask(widget, "next")
    for _ in range(500):
        if not is_shown(widget):
            break
        ask(widget, "skip")
    assert not is_shown(widget)
    assert widget.view.status == "Nothing more to suggest"


def test_every_question_is_answered_by_a_change_also_when_there_is_nothing(widget, monkeypatch):
    monkeypatch.setattr(sw.Session, "suggestions", lambda *_: [])
    told = []
    widget.view.observe(lambda change: told.append(change["new"]), "suggestion")
    for n in (1, 2):
        ask(widget, "next")
        assert len(told) == n
    widget._commands.session = None
    ask(widget, "next")
    assert len(told) == 3
    assert not is_shown(widget)


def test_a_saved_page_tells_nothing_of_the_session(widget, tmp_path):
    ask(widget, "next")
    assert is_shown(widget)
    place = widget.save(tmp_path / "secret.swproj")
    widget.session.relabel(0, "kept")
    widget.view.history_shown = True
    widget.view.notices = [{"key": "file", "text": "private", "actions": []}]
    assert str(place) in widget.view.save_note
    page = widget.to_html(tmp_path / "room.html").read_text(encoding="utf-8")
    saved = json.loads(page.split('id="saved">')[1].split("</script>")[0])["state"]
    assert "secret" not in json.dumps(saved)
    assert "kept" in saved["segment_names"].values()
    named = ("suggestion", "history", "history_shown", "notices", "undo_title", "save_note", "vocabulary")
    assert [saved[name] for name in named] == [{}, [], False, [], "", "", []]
