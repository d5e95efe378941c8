from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shapes
from editing_strategies import edits, segmentations
from hypothesis import given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.editing import EditError, Split
from scenewidget.metrics import rand_index_error

FACES = 24  # of each of the eight parts of the strip, in four segments of two


def strip(keys: np.ndarray) -> sw.Session:
    mesh = shapes.box(4)  # 192 faces
    base = np.arange(mesh.n_faces) // FACES
    made = sw.Segmentation(
        mesh, base // 2, np.full(mesh.n_faces, 0.9), levels={"base": base.astype(np.int32)}, keys=keys
    )
    return sw.Session(mesh, made)


def agreeing(shares: dict[tuple[int, int], float]) -> np.ndarray:
    """Keys of ten runs: segments apart, but for pairs of them that fall together in a share of the runs."""
    keys = np.tile(np.repeat(np.arange(4), 2)[:, None], (1, 10))
    for (a, b), share in shares.items():
        keys[2 * b : 2 * b + 2, : round(10 * share)] = a
    return keys


@st.composite
def sessions(draw):
    segmentation = draw(segmentations())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n_base = max(1, int(segmentation.levels["base"].max()) + 1)
    keys = rng.integers(0, 3, (n_base, 6)).astype(np.int32)
    return sw.Session(segmentation.mesh, dataclasses.replace(segmentation, keys=keys))


def test_segments_that_the_runs_joined_more_often_come_first():
    session = strip(agreeing({(0, 1): 0.4, (2, 3): 0.5}))
    first, second = session.suggestions(2)
    ends = [{face // (2 * FACES) for face in (s.face, s.onto_face)} for s in (first, second)]
    assert ends == [{2, 3}, {0, 1}]
    assert (first.kind, first.level, second.kind) == ("merge", "final", "merge")
    assert first.gain == pytest.approx(2 * 0.25 * 0.25 * first.probability)
    assert 0.2 < second.probability < first.probability < 1


def test_a_suggestion_can_be_followed_and_taken_back():
    session = strip(agreeing({(0, 1): 0.5}))
    before = session.suggestions()
    session.do(before[0].edit)
    assert session.n_segments == 3
    assert before[0] not in session.suggestions()
    session.undo()
    assert session.suggestions() == before


def test_what_was_dismissed_is_not_suggested_again():
    session = strip(agreeing({(0, 1): 0.5, (2, 3): 0.4}))
    first, second = session.suggestions(2)
    session.dismiss(first)
    assert session.suggestions(1) == [second]


def merges(session):
    """Pairs of segments to be merged, each by the first of the eight parts that it has."""
    first = [session.part(part * FACES, "final").nonzero()[0].min() for part in range(8)]
    return [
        {first[s.face // FACES], first[s.onto_face // FACES]}
        for s in session.suggestions(100)
        if s.level == "final"
    ]


def test_a_dismissal_is_of_these_parts_whatever_ids_they_get_after_an_undo():
    keys = agreeing({})
    keys[[1, 3], :5] = 2  # half of segment 0 and half of segment 1 were with segment 2 in half of the runs
    session = strip(keys)
    session.split(FACES, "base")
    assert {1, 4} in merges(session)
    session.dismiss(session.suggestions(100)[merges(session).index({1, 4})])
    assert {1, 4} not in merges(session)
    session.undo()
    session.split(3 * FACES, "base")  # it has the id now that the other half had
    assert {3, 4} in merges(session)
    session.undo()
    session.split(FACES, "base")
    assert {1, 4} not in merges(session)


def test_a_dismissal_outlasts_small_changes_of_what_it_is_about_but_not_large_ones():
    session = strip(agreeing({(1, 0): 0.5, (1, 2): 0.5, (1, 3): 0.5}))
    session.dismiss(session.suggestions(100)[merges(session).index({0, 2})])
    assert {0, 2} not in merges(session)
    session.merge(6 * FACES, 0, "base")  # one and a half times as large
    assert {0, 2} not in merges(session)
    session.merge([4 * FACES, 7 * FACES], 0)
    assert {0, 2} in merges(session)
    session.go_to(1)
    assert {0, 2} not in merges(session)


def test_only_a_suggestion_can_be_dismissed():
    with pytest.raises(TypeError, match=r"suggestion must be one of suggestions\(\), got Split"):
        strip(agreeing({})).dismiss(Split(0, "base"))


def test_what_a_person_took_apart_stays_apart():
    session = strip(agreeing({}))
    session.split(0, "base")  # the two halves of a segment agree in every run
    assert session.n_segments == 5
    pair = {0, 1}
    for s in session.suggestions(100):
        assert {s.face // FACES, s.onto_face // FACES} != pair


def test_things_with_different_names_stay_apart():
    session = strip(agreeing({(0, 1): 0.5}))
    session.relabel(0, "chair")
    assert "'chair'" in session.suggestions(1)[0].title
    session.relabel(2 * FACES, "table")
    for s in session.suggestions(100):
        assert {s.face // (2 * FACES), s.onto_face // (2 * FACES)} != {0, 1}


def test_a_part_that_the_runs_saw_elsewhere_is_to_move():
    keys = agreeing({})
    keys[1, :6] = 1  # half of segment 0 was with segment 1
    session = strip(keys)
    confidence = np.where(np.arange(192) // FACES == 1, 0.3, 0.95)
    session.resegment(dataclasses.replace(session.automatic, confidence=confidence))
    (move,) = [s for s in session.suggestions() if s.level == "base" and s.face // FACES == 1]
    assert (move.kind, move.onto_face // (2 * FACES)) == ("merge", 1)
    session.do(move.edit)
    assert len({*session.segmentation.labels[FACES : 4 * FACES].tolist()}) == 1


def test_a_part_that_was_with_nothing_is_to_split_off():
    keys = agreeing({})
    keys[1, :6] = 9
    session = strip(keys)
    confidence = np.where(np.arange(192) // FACES == 1, 0.3, 0.95)
    session.resegment(dataclasses.replace(session.automatic, confidence=confidence))
    (split,) = [s for s in session.suggestions() if s.level == "base" and s.face // FACES == 1]
    assert (split.kind, split.onto_face, split.edit) == ("split", -1, Split(split.face, "base"))
    assert split.probability == pytest.approx(1.3 * 0.7**2)


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_every_suggestion_applies_and_none_comes_twice(data):
    session = data.draw(sessions())
    for edit in data.draw(st.lists(edits(session.mesh.n_faces), max_size=3)):
        try:
            session.do(edit)
        except EditError:
            continue
    found = session.suggestions(30)
    assert len({s.edit for s in found}) == len(found)
    gains = [s.gain for s in found]
    assert gains == sorted(gains, reverse=True)
    assert all(0 < s.gain <= 1 and 0 < s.probability <= 1 for s in found)
    for suggestion in found:
        before = session.atom_segments
        session.do(suggestion.edit)
        assert (session.atom_segments != before).any()
        session.undo()
    for suggestion in found:
        session.dismiss(suggestion)
    assert not {s.edit for s in found} & {s.edit for s in session.suggestions(30)}


def test_a_saved_project_suggests_the_same(tmp_path):
    session = strip(agreeing({(0, 1): 0.4, (2, 3): 0.5}))
    session.save(tmp_path / "box.swproj", include_mesh=True)
    expected = session.suggestions()
    del session
    assert sw.Session.open(tmp_path / "box.swproj").suggestions() == expected


def test_without_an_ensemble_there_is_nothing_to_suggest():
    mesh, truth = sw.datasets.load_room()
    assert sw.Session(mesh, truth).suggestions() == []


def test_on_a_scan_looking_at_twenty_suggestions_pays():
    mesh, truth = sw.datasets.load_room()
    session = sw.Session(mesh, sw.segment(mesh))
    error = start = rand_index_error(session.segmentation, truth)
    n_followed = 0
    for _ in range(20):
        (suggestion,) = session.suggestions(1)
        session.do(suggestion.edit)
        if (now := rand_index_error(session.segmentation, truth)) < error:
            error, n_followed = now, n_followed + 1
        else:
            session.undo()
            session.dismiss(suggestion)
    assert n_followed >= 3
    assert error < 0.95 * start


def test_the_number_must_be_one():
    with pytest.raises(ValueError, match="n must be a whole number from 0, got -1"):
        strip(agreeing({})).suggestions(-1)


def test_keys_must_fit_the_base_level():
    mesh = shapes.box(4)
    labels = np.zeros(mesh.n_faces, np.int32)
    levels = {"base": np.arange(mesh.n_faces) // FACES}
    with pytest.raises(ValueError, match=r"keys must have a row for each of the 8 parts"):
        sw.Segmentation(mesh, labels, levels=levels, keys=np.zeros((3, 5), int))
    with pytest.raises(TypeError, match="keys must be whole numbers"):
        sw.Segmentation(mesh, labels, levels=levels, keys=np.zeros((8, 5)))
    with pytest.raises(ValueError, match=r"keys must have a row"):
        sw.Segmentation(mesh, labels, keys=np.zeros((8, 5), int))
