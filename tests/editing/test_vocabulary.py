"""Names for segments and the classes that they stand for."""

import pytest

import scenewidget as sw
from scenewidget.editing.vocabulary import (
    NYU40,
    SCANNET20,
    checked_vocabulary,
    chosen_vocabulary,
    in_vocabulary,
    nyu_class,
    nyu_id,
    quick_names,
)


def test_the_lists_have_their_known_ids():
    assert len(set(NYU40)) == 40
    assert [nyu_id(name) for name in SCANNET20] == [
        1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 16, 24, 28, 33, 34, 36, 39,
    ]  # fmt: skip
    assert sw.editing.NYU40 is NYU40


@pytest.mark.parametrize(
    ("name", "expected"),
    [("chair", "chair"), ("Chair 12", "chair"), ("night stand", "nightstand"), ("fridge", "refrigerator"),
     ("floor_mat", "floor mat"), ("tv", "television"), ("unicorn", ""), ("", ""), ("12", "")],
)  # fmt: skip
def test_names_stand_for_classes(name, expected):
    assert nyu_class(name) == expected
    assert (nyu_id(name) > 0) == (expected != "")


def test_own_lists_are_checked():
    assert checked_vocabulary([" a ", "b", "a"]) == ("a", "b")
    for wrong in ("chair", 3, [3]):
        with pytest.raises(TypeError):
            checked_vocabulary(wrong)
    for wrong in (["a", ""], ["x" * 201], map(str, range(10_001))):
        with pytest.raises(ValueError, match="name"):
            checked_vocabulary(wrong)


def test_a_vocabulary_is_chosen_by_name_or_given():
    assert chosen_vocabulary("nyu40") is NYU40
    assert chosen_vocabulary("ScanNet20") is SCANNET20
    assert chosen_vocabulary(["lid", "box"]) == ("lid", "box")
    with pytest.raises(ValueError, match="must be 'nyu40', 'scannet20' or a list of names, got 'coco'"):
        chosen_vocabulary("coco")


def test_names_keep_their_keys_until_others_are_used_more_recently():
    assert quick_names(NYU40, []) == NYU40[:7]
    assert quick_names(NYU40, ["lamp"]) == (*NYU40[:6], "lamp")
    assert quick_names(NYU40, ["lamp", "wall", "box"]) == (*NYU40[:5], "box", "lamp")
    names = quick_names(NYU40, [*NYU40[:7], "lamp", "wall"])  # wall is gone: it was used longest ago
    assert names == ("lamp", "wall", *NYU40[2:7])
    assert quick_names(["a"], ["b", "a", "c"], n=2) == ("a", "c")
    assert quick_names([], ["x"]) == ("x",)


def test_what_geometry_tells_is_said_in_the_words_of_the_vocabulary():
    mesh, truth = sw.datasets.load_room()
    plain = sw.Segmentation(mesh, truth.labels)
    given = {}
    for words in ("nyu40", "scannet20", ["Floor", "tree"]):
        session = sw.Session(mesh, plain, vocabulary=words)
        given[len(session.vocabulary)] = {name for name, _ in session.suggest_names().values()}
    assert given[40] == {"floor", "ceiling", "wall"}
    assert given[20] == {"floor", "wall"}
    assert given[2] == {"Floor"}
    (step,) = session.accept_names()
    assert session.segmentation.names[truth.labels[step.edit.face]] == "Floor"
    assert session.suggest_names() == {}
    assert in_vocabulary("lamp", SCANNET20) == ""
