"""Edits as data: what they hold, what they refuse, JSON and back."""

import json

import pytest
from editing_strategies import edited
from hypothesis import given

from scenewidget.editing.edits import Cut, Merge, Relabel, Split, checked_name, edit_from_dict, edit_to_dict


@given(edited(max_size=4))
def test_edits_survive_json(case):
    for edit in case[1]:
        assert edit_from_dict(json.loads(json.dumps(edit_to_dict(edit)))) == edit


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


def test_titles_are_what_a_history_shows():
    edits = [Merge(3, 5), Merge([3, 4, 3], 5), Split(3), Relabel(3, "chair"), Relabel(3, ""), Cut(3, 5)]
    titles = ["Merge", "Merge 2 parts", "Split", "Name 'chair'", "Remove name", "Cut"]
    assert [edit.title for edit in edits] == titles


def test_one_name_has_one_spelling():
    assert checked_name("  Tu\u0308r ") == "T\u00fcr"  # composed, so that it is found again
    assert Relabel(0, "Tu\u0308r") == Relabel(0, "T\u00fcr ")
