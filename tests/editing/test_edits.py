"""Edits as data: what they hold, what they refuse, JSON and back."""

import json

import pytest
from editing_strategies import edited
from hypothesis import given

from scenewidget.editing.edits import (
    Cut,
    FillHoles,
    Group,
    Grow,
    Merge,
    Paint,
    Relabel,
    Shrink,
    Slice,
    SmoothBorder,
    Split,
    checked_name,
    edit_from_dict,
    edit_to_dict,
)


@given(edited(max_size=4))
def test_edits_survive_json(case):
    for edit in case[1]:
        assert edit_from_dict(json.loads(json.dumps(edit_to_dict(edit)))) == edit


@pytest.mark.parametrize(
    "data",
    [None, 3, {}, {"kind": "__import__"}, {"kind": "split"}, {"kind": "split", "face": 0, "more": 1},
     {"kind": "split", "face": "0"}, {"kind": "merge", "faces": 5.0, "onto_face": 1},
     {"kind": "merge", "faces": "12", "onto_face": 1}, {"kind": "split", "face": 2**40},
     {"kind": "split", "face": 0, "level": []}, {"kind": ["split"]},
     {"kind": "group", "faces": []}, {"kind": "group", "faces": [1], "onto_face": "2"},
     {"kind": "paint"}, {"kind": "paint", "ranges": []}, {"kind": "paint", "ranges": [0]},
     {"kind": "paint", "ranges": [3, 3]}, {"kind": "paint", "ranges": [0, 2, 2, 3]},
     {"kind": "paint", "ranges": [-1, 3]}, {"kind": "paint", "ranges": [0, 2**40]},
     {"kind": "paint", "ranges": [0, 2.5]}, {"kind": "paint", "ranges": [0, 1], "faces": [3]},
     {"kind": "paint", "ranges": [[0, 1]]}, {"kind": "paint", "ranges": "01"}, {"kind": "paint", "ranges": 7},
     {"kind": "slice", "face": 0, "point": [0, 0, float("nan")], "normal": [0, 0, 1]},
     {"kind": "slice", "face": 0, "point": [0, 0], "normal": [0, 0, 1]},
     {"kind": "slice", "face": 0, "point": [0, 0, 0], "normal": [0, 0, 0]},
     {"kind": "slice", "face": 0, "point": "abc", "normal": [0, 0, 1]},
     {"kind": "grow", "face": 0, "rings": 0}, {"kind": "shrink", "face": 0, "rings": 10**9},
     {"kind": "fill_holes", "face": 0, "max_faces": -1}, {"kind": "smooth_border", "face": 0, "rounds": 1.5}],
)  # fmt: skip
def test_damaged_edits_are_refused(data):
    with pytest.raises((ValueError, TypeError)):
        edit_from_dict(data)


def test_titles_are_what_a_history_shows():
    edits = [Merge(3, 5), Merge([3, 4, 3], 5), Split(3), Relabel(3, "chair"), Relabel(3, ""), Cut(3, 5)]
    edits += [Paint([3], 5), Paint([3, 4]), Slice(0, (0, 0, 0), (0, 0, 1)), Grow(3), Shrink(3)]
    edits += [FillHoles(3), SmoothBorder(3), Group([3, 4], 5), Group(3)]
    titles = ["Merge", "Merge 2 parts", "Split", "Name 'chair'", "Remove name", "Cut"]
    titles += [
        "Paint 1 face",
        "New segment of 2 faces",
        "Slice",
        "Grow",
        "Shrink",
        "Fill holes",
        "Smooth border",
        "Group",
        "Ungroup",
    ]
    assert [edit.title for edit in edits] == titles


def test_one_name_has_one_spelling():
    assert checked_name("  Tu\u0308r ") == "T\u00fcr"  # composed, so that it is found again
    assert Relabel(0, "Tu\u0308r") == Relabel(0, "T\u00fcr ")


def test_a_stroke_is_a_set_of_faces_and_small_in_a_log():
    assert Paint([5, 3, 4, 3], 7) == Paint(range(3, 6), 7)
    assert hash(Paint([5, 3, 4], 7)) == hash(Paint([3, 4, 5], 7))
    assert edit_to_dict(Paint(range(100_000))) == {"kind": "paint", "ranges": [0, 100_000], "onto_face": None}
    huge = edit_from_dict({"kind": "paint", "ranges": [0, 2**31]})  # costs nothing before it meets a mesh
    assert huge.title == "New segment of 2147483648 faces"
