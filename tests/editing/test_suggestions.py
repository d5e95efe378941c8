from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shapes
from editing_strategies import edits, segmentations
from hypothesis import given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.editing import EditError, Relabel, Split, Suggestion
from scenewidget.editing.suggestions import _Lessons
from scenewidget.engine.doubt import measure_gaps
from scenewidget.engine.pieces import make_pieces
from scenewidget.metrics import rand_index_error

FACES = 24  # of each of the eight parts of the strip, in four segments of two


def strip(keys: np.ndarray, *, folded: bool = False) -> sw.Session:
    """A strip of four squares one after the other, each of two parts; flat, or two roofs."""
    mesh = shapes.sheet(32, 3, width=8.0, depth=2.0)  # 192 faces
    if folded:
        x = mesh.vertices[:, 0]
        mesh = sw.Mesh(mesh.vertices + np.outer(2 - np.abs(2 - x % 4), [0, 0, 1]), mesh.faces)
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


def ends(suggestion):
    """The segments in question, by where they lie in the strip."""
    return {face // (2 * FACES) for face in (suggestion.face, suggestion.onto_face) if face >= 0}


def test_segments_that_the_runs_joined_more_often_come_first():
    session = strip(agreeing({(0, 1): 0.7, (2, 3): 0.9}))
    first, second = session.suggestions(2)
    assert [ends(first), ends(second)] == [{2, 3}, {0, 1}]
    assert (first.kind, first.level, second.kind) == ("merge", "final", "merge")
    assert first.gain == pytest.approx(2 * 0.25 * 0.25 * first.p)
    assert 0.4 < second.p < first.p < 1
    assert first.probability == first.p
    assert first.why == "border 2.0 m, same plane, folded in, together in 90% of the runs"


def test_what_is_probably_wrong_is_kept_for_the_end():
    assert [ends(s) for s in strip(agreeing({(0, 1): 0.9})).suggestions()] == [{0, 1}]
    session = strip(agreeing({(0, 1): 0.3, (2, 3): 0.3}), folded=True)
    (found,) = session.suggestions()  # two are alike: one by one
    assert ends(found) == {0, 1}
    assert found.p < 0.5
    session.dismiss(found)
    assert all(s.p < found.p and ends(s) != {0, 1} for s in session.suggestions())


def test_a_suggestion_can_be_followed_and_taken_back():
    session = strip(agreeing({(0, 1): 0.9}))
    before = session.suggestions()
    session.do(before[0].edit)
    assert session.n_segments == 3
    assert before[0] not in session.suggestions()
    session.undo()
    assert session.suggestions() == before


def test_what_was_dismissed_is_not_suggested_again():
    session = strip(agreeing({(0, 1): 0.9, (2, 3): 0.8}))
    first, second = session.suggestions()
    session.dismiss(first)
    assert ends(first) not in [ends(s) for s in session.suggestions()]
    assert ends(second) in [ends(s) for s in session.suggestions()]


def test_a_dismissal_is_of_these_parts_whatever_ids_they_get_after_an_undo():
    session = strip(agreeing({(0, 1): 0.9}))
    session.dismiss(session.suggestions(1)[0])
    session.split(7 * FACES, "base")
    assert {0, 1} not in [ends(s) for s in session.suggestions(100)]
    session.undo()
    session.split(5 * FACES, "base")
    assert {0, 1} not in [ends(s) for s in session.suggestions(100)]


def test_a_dismissal_does_not_outlast_large_changes_of_what_it_is_about():
    session = strip(agreeing({(1, 0): 0.9, (1, 2): 0.9, (1, 3): 0.9}))
    for s in session.suggestions(100):
        if ends(s) == {0, 1}:
            session.dismiss(s)
    assert {0, 1} not in [ends(s) for s in session.suggestions(100)]
    session.merge([4 * FACES, 7 * FACES], 2 * FACES)  # three times as large
    assert session.n_segments == 2
    assert [ends(s) & {0} for s in session.suggestions(100) if s.kind == "merge"] == [{0}]
    session.go_to(0)
    assert {0, 1} not in [ends(s) for s in session.suggestions(100)]


def test_the_log_keeps_what_was_proposed_and_a_rejection_outlasts_the_file(tmp_path):
    session = strip(agreeing({(0, 1): 0.9, (2, 3): 0.8}))
    first, second = session.suggestions()
    session.propose(first)
    session.dismiss(first)
    session.save(tmp_path / "box.swproj", include_mesh=True)
    session.propose(second)
    session.do(second.edit)
    session.close()
    with sw.Session.open(tmp_path / "box.swproj") as again:
        frame = again.to_frame()
        assert frame["action"].tolist() == ["open", "propose", "dismiss", "propose", "edit", "open"]
        assert frame["faces"][1] == frame["faces"][2] == (*first.faces, first.onto_face)
        assert frame["p"][[1, 2]].tolist() == [first.p, first.p]
        assert frame["gain"][3] == second.gain
        assert frame["p"].isna().tolist() == [True, False, False, False, True, True]
        again.undo()
        found = [ends(s) for s in again.suggestions()]
        assert ends(first) not in found
        assert ends(second) in found


def test_what_is_no_merge_or_split_was_no_suggestion():
    with pytest.raises(TypeError, match="edit must be a Merge or a Split, got Relabel"):
        Suggestion.of(Relabel(0, "chair"))


def test_only_a_suggestion_can_be_dismissed():
    with pytest.raises(TypeError, match=r"suggestion must be one of suggestions\(\), got Split"):
        strip(agreeing({})).dismiss(Split(0, "base"))


def test_what_a_person_took_apart_stays_apart():
    session = strip(agreeing({}))
    session.split(0, "base")  # the two halves of a segment agree in every run
    assert session.n_segments == 5
    for s in session.suggestions(100):
        assert {s.face // FACES, s.onto_face // FACES} != {0, 1}


def test_what_a_person_put_together_stays_together():
    session = strip(agreeing({}))
    session.merge(0, 2 * FACES)  # no run has them together
    assert all(s.kind == "merge" for s in session.suggestions(100))


def test_things_with_different_names_stay_apart():
    session = strip(agreeing({(0, 1): 0.9}))
    session.relabel(0, "chair")
    assert "'chair'" in session.suggestions(1)[0].title
    session.relabel(2 * FACES, "table")
    assert {0, 1} not in [ends(s) for s in session.suggestions(100)]


def test_parts_of_one_thing_stay_parts():
    session = strip(agreeing({(0, 1): 0.9}))
    session.group(0, onto_face=2 * FACES)
    assert {0, 1} not in [ends(s) for s in session.suggestions(100)]


def test_one_answer_makes_its_like_more_or_less_likely():
    """The second chair as the first: pairs of squares look alike wherever they lie."""
    session = strip(agreeing({(0, 1): 0.6, (2, 3): 0.6}), folded=True)
    first, second = session.suggestions(2)
    assert first.p == pytest.approx(second.p)
    session.do(first.edit)
    (like,) = [s for s in session.suggestions() if ends(s) == ends(second)]
    assert like.p > second.p + 0.05
    session.undo()
    session.dismiss(first)
    like = session.suggestions()[0]  # the only one left, and not as probable any more
    assert ends(like) == ends(second)
    assert like.p < second.p - 0.05


def test_answers_of_one_kind_teach_less_and_less():
    """The mode of a Gaussian process: what each answer still teaches is what is still surprising."""
    rng = np.random.default_rng(0)
    measures, weights = rng.normal(size=(12, 2)), (-1.0, 0.5, 0.2)
    rows = [(row, float(k % 3 > 0), 0.25 * (1 + k % 4)) for k, row in enumerate(measures)]
    learned = _Lessons.of(rows, weights, measures)
    found = learned.probability(measures)
    _, outcome, share = zip(*rows)
    np.testing.assert_allclose(learned.surprise, np.array(share) * (np.array(outcome) - found), atol=1e-6)
    p = [
        _Lessons.of([(np.zeros(2), 1.0, 1.0)] * n, weights, measures).probability(np.zeros((1, 2)))[0]
        for n in range(9)
    ]
    steps = np.diff(p)
    assert (steps > 0).all()
    assert (np.diff(steps) < 0).all()
    assert p[-1] < 0.95


def test_what_is_to_join_one_segment_comes_in_one_look_and_once_rejected_one_by_one():
    mesh = shapes.sheet(32, 3, width=8.0, depth=2.0)  # a large segment between two small ones
    base = np.arange(mesh.n_faces) // FACES
    keys = np.tile(np.array([[1], [0], [0], [0], [0], [0], [0], [2]]), (1, 10))
    keys[[0, 7], :9] = 0
    labels = np.array([1, 0, 0, 0, 0, 0, 0, 2])[base]
    levels = {"base": base.astype(np.int32)}
    session = sw.Session(mesh, sw.Segmentation(mesh, labels, levels=levels, keys=keys))
    (both,) = session.suggestions()
    assert sorted(face // FACES for face in both.faces) == [0, 7]
    assert both.title == f"Merge 2 parts with their likely rest ({both.p:.0%})"
    assert both.why.startswith("the largest: border 2.0 m")
    session.do(both.edit)
    assert session.n_segments == 1
    session.undo()
    session.dismiss(both)
    one, other = session.suggestions()
    assert {one.face // FACES, other.face // FACES} == {0, 7}
    assert one.gain + other.gain == pytest.approx(both.gain)
    session.dismiss(one)
    assert [s.edit for s in session.suggestions()] == [other.edit]


def test_a_part_that_was_with_nothing_is_to_split_off_whole():
    mesh = shapes.sheet(32, 3, width=8.0, depth=2.0)
    x = mesh.vertices[:, 0]
    # the second square and half of the first stand up by themselves
    vertices = np.stack(
        [np.minimum(x, 1.0) + np.maximum(x - 4.0, 0), mesh.vertices[:, 1], np.clip(x - 1, 0, 3)]
    )
    mesh = sw.Mesh(vertices.T, mesh.faces)
    base = np.arange(mesh.n_faces) // FACES
    keys = np.array([0, 1, 1, 1, 2, 2, 2, 2])[:, None].repeat(10, axis=1)
    keys[2, :3] = 5  # or the side would be a single part
    labels = np.where(base < 4, 0, 1)
    made = sw.Segmentation(mesh, labels, levels={"base": base.astype(np.int32)}, keys=keys)
    session = sw.Session(mesh, made)
    (split,) = [s for s in session.suggestions() if s.kind == "split"]
    assert split.level == "base"
    before = session.n_segments
    session.do(split.edit)
    assert session.n_segments == before + 1
    moved = session.segmentation.labels
    sides = {frozenset(np.unique(base[moved == k]).tolist()) for k in np.unique(moved)}
    assert frozenset({0}) in sides or frozenset({1, 2, 3}) in sides


def test_a_split_of_several_parts_takes_only_what_lies_in_the_segment():
    session = strip(agreeing({}))
    session.merge(FACES, 2 * FACES, "base")  # part 1 to the second square
    session.do(Split(2 * FACES, "base", (FACES, 5 * FACES)))  # parts 2 and 1, but not 5, which is elsewhere
    labels = session.segmentation.labels
    assert labels[FACES] == labels[2 * FACES] != labels[3 * FACES]
    assert labels[5 * FACES] == labels[4 * FACES]


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
    session = strip(agreeing({(0, 1): 0.7, (2, 3): 0.9}))
    session.group(4 * FACES, onto_face=7 * FACES)
    session.save(tmp_path / "box.swproj", include_mesh=True)
    expected = session.suggestions()
    del session
    again = sw.Session.open(tmp_path / "box.swproj")
    assert again.suggestions() == expected
    assert again.segment_groups == {2: 3}


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


def test_a_wall_that_goes_on_behind_something_may_be_one():
    """Three squares in a row, the middle one half a metre nearer and with no surface to either side."""
    parts = [shapes.sheet(8, 3, width=2.0, depth=2.0) for _ in range(3)]
    shifts = [(0, 0, 0), (2, 0, 0.5), (4, 0, 0)]
    n = len(parts[0].vertices)
    mesh = sw.Mesh(
        np.concatenate([part.vertices + shift for part, shift in zip(parts, shifts)]),
        np.concatenate([part.faces + n * k for k, part in enumerate(parts)]),
    )
    labels = np.repeat(np.arange(3), parts[0].n_faces)
    gaps = measure_gaps(make_pieces(mesh, labels, labels), np.array([[0, 0], [1, 1], [0, 2]]))
    assert (gaps.first.tolist(), gaps.second.tolist(), gaps.agreement.tolist()) == ([0], [2], [0.5])
    assert gaps.offset[0] < 1e-6
    assert 1.0 < gaps.gap[0] < 2.1
    made = sw.Segmentation(mesh, labels, levels={"base": labels.astype(np.int32)}, keys=np.zeros((3, 2), int))
    whys = [s.why for s in sw.Session(mesh, made).suggestions()]
    assert any("apart, same plane" in why for why in whys), whys


def test_floor_that_is_seen_elsewhere_is_to_be_merged_with_the_floor():
    """The room without a strip of its floor: what lies beyond touches none of the rest."""
    mesh, truth = sw.datasets.load_room()
    names = truth.suggest_names()
    (floor,) = (s for s, (name, _) in names.items() if name == "floor")
    x = mesh.face_centroids[:, 0]
    low, high = np.percentile(x[truth.labels == floor], [70, 80])
    keep = (truth.labels != floor) | (x < low) | (x > high)
    labels = np.where((truth.labels == floor) & (x > high), truth.n_segments, truth.labels)[keep]
    part = sw.Mesh(mesh.vertices, mesh.faces[keep])
    seg = sw.Segmentation(
        part, labels, levels={"base": labels.astype(np.int32)}, keys=np.arange(truth.n_segments + 1)[:, None]
    )
    assert seg.suggest_names()[truth.n_segments][0] == "floor"
    (found,) = [s for s in sw.Session(part, seg).suggestions(20) if "as low as the floor" in s.why]
    assert {int(labels[found.face]), int(labels[found.onto_face])} == {floor, truth.n_segments}
    assert found.p > 0.6
