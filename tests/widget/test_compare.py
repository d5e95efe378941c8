"""Two segmentations side by side, without a browser: what each view shows, and what is said of both."""

import threading

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.datasets import analytic
from scenewidget.palette import segment_colors
from scenewidget.widget.scores import disagreement

MESH, TRUTH = shapes.room(10, noise=0.003)
SMALL = sw.Params(n_segments=6, n_runs=4, n_graph_runs=4)
GIVEN = sw.Segmentation.from_labels(MESH, TRUTH)


@pytest.fixture
def compare():
    compare = sw.Compare(MESH, SMALL, GIVEN, truth=TRUTH)
    compare.wait(60)
    yield compare
    compare.close()


def test_each_side_shows_its_own_segmentation(compare):
    a, b = compare.segmentations
    np.testing.assert_array_equal(a.labels, sw.segment(MESH, SMALL).labels)
    assert b is GIVEN
    assert [view.n_segments for view in compare.views] == [a.n_segments, b.n_segments]
    assert repr(compare) == f"Compare({MESH.n_faces} faces, {a.n_segments} and {b.n_segments} segments)"
    assert not compare.busy


def test_what_overlaps_has_one_colour(compare):
    a, b = compare.segmentations
    left, right = compare.views
    for segment in range(b.n_segments):
        mine = b.labels == segment
        partner = np.bincount(a.labels[mine & (a.labels >= 0)]).argmax()
        if np.mean(mine[a.labels == partner]) > 0.9:
            assert left.segment_colors[partner].tolist() == right.segment_colors[segment].tolist()
    for segmentation, view in zip((a, b), compare.views, strict=True):  # in exported files as well
        np.testing.assert_array_equal(segment_colors(segmentation)[:-1], view.segment_colors)


def test_the_numbers_are_those_of_evaluate(compare):
    a, b = compare.segmentations
    expected = sw.evaluate({"A": a, "B": b}, TRUTH, MESH)
    for side in "AB":
        scores = compare.scores[f"{side} and truth"]
        for name, value in scores.items():
            assert value == pytest.approx(expected.loc[side, name])
    assert compare.scores["B and truth"]["rand_index_error"] == 0
    assert compare.to_frame().equals(expected)
    assert "B and A" in compare._table.value


def test_disagreement_is_coloured_on_both_sides(compare):
    a, b = compare.segmentations
    expected = disagreement(a.labels, b.labels)
    for view in compare.views:
        np.testing.assert_array_equal(np.frombuffer(view._face_error, np.uint8), expected)
        assert view.errors_title
    compare.views[0].color_by = "errors"
    assert compare.views[1].color_by == "errors"


def test_sides_have_the_names_that_they_are_given_by():
    mesh = analytic.square(2)  # 8 triangles
    halves = sw.Segmentation.from_labels(mesh, [0] * 4 + [1] * 4)
    given = {"<i>Ann": halves, "Bob": sw.Segmentation.from_labels(mesh, [0] * 6 + [1] * 2), "Cy": halves}
    compare = sw.Compare(mesh, given, truth=halves)
    compare.wait()
    assert compare.names == tuple(given)
    assert list(compare.scores)[2:] == ["Cy and truth", "Bob and <i>Ann", "Cy and <i>Ann"]
    assert [title.value[:18] for title in compare._titles[:2]] == ["<b>&lt;i&gt;Ann</b", "<b>Bob</b> &nbsp;<"]
    assert "Bob and &lt;i&gt;Ann" in compare._table.value
    assert "<i>" not in compare._table.value
    assert compare.to_frame().index.tolist() == list(given)
    assert compare.views[1].errors_title == "Against <i>Ann"
    with pytest.raises(TypeError, match="isn't noticed; they are measured"):
        compare.scores["Cy and truth"]["rand_index_error"] = 0
    compare.close()


@pytest.mark.parametrize(
    ("sides", "message"),
    [
        (({"Ann": GIVEN},), "a must name two sides at least, got 1"),
        (({1: GIVEN, "Bob": GIVEN},), "a must map names of sides to them, got the name 1"),
        (({"Ann": GIVEN, "Bob": GIVEN}, GIVEN), "a names all sides, so there are none after it"),
    ],
)
def test_names_that_make_no_comparison_are_refused(sides, message):
    with pytest.raises((TypeError, ValueError), match=message):
        sw.Compare(MESH, *sides)


def test_what_the_two_agree_on_least_is_listed_by_segment_and_name():
    mesh = analytic.square(2)  # 8 triangles
    first = sw.Segmentation.from_labels(mesh, [0] * 6 + [1] * 2, names=["<b>floor", ""])
    second = sw.Segmentation.from_labels(mesh, [0] * 4 + [1] * 4, names=["rug", ""])
    compare = sw.Compare(mesh, first, second)
    compare.wait()
    shown = compare._table.value
    assert shown.count("<details>") == 2
    assert "&lt;b&gt;floor" in shown
    assert "<b>floor" not in shown
    table = compare.to_frame(per="segment")
    assert table.iou.iloc[0] == 0.5 == table.iou.min()
    assert compare.to_frame(per="name").iou.to_dict() == {("A", "B", "<b>floor"): 0, ("A", "B", "rug"): 0}
    compare.close()


def test_any_number_a_face_is_coloured_on_both_sides(compare):
    a, b = compare.segmentations
    compare.set_values(np.abs(a.confidence - b.confidence), title="Difference in confidence", low=0, high=1)
    assert [view.color_by for view in compare.views] == ["values", "values"]
    assert [view.values_legend["title"] for view in compare.views] == ["Difference in confidence"] * 2
    assert compare.views[0]._face_value == compare.views[1]._face_value != b""
    with pytest.raises(ValueError, match="one a face"):
        compare.set_values([1.0])


def test_disagreement_of_two_labelings():
    a, b = np.array([0, 0, 0, 1, 1, -1, -1, 2]), np.array([5, 5, 1, 1, 1, -1, 1, 7])
    assert disagreement(a, b).tolist() == [1, 1, 2, 1, 1, 0, 2, 1]
    assert (disagreement(a, a)[a >= 0] == 1).all()


def test_another_side_is_computed_with_what_is_known(compare):
    before = compare.views[0].revision
    compare.b = SMALL.replace(n_segments=4)
    a, b = compare.wait(60)
    np.testing.assert_array_equal(b.labels, sw.segment(MESH, SMALL.replace(n_segments=4)).labels)
    assert max(a.timings.values()) == 0
    assert compare.views[0].revision > before


def test_both_views_look_the_same_way(compare):
    groups = {view.camera_group for view in compare.views}
    assert len(groups) == 1
    assert groups != {""}


def test_three_sides_share_one_mesh_and_are_measured_by_any_rule():
    halves = sw.Segmentation.from_labels(MESH, (MESH.face_centroids[:, 0] > 1).astype(int))

    def size_ratio(first, other):
        sizes = np.bincount(first)[first], np.bincount(other)[other]
        return np.log(sizes[0] / sizes[1])

    compare = sw.Compare(MESH, GIVEN, halves, GIVEN, truth=TRUTH, disagreement=size_ratio)
    assert len(compare.wait(60)) == 3
    assert repr(compare).endswith(f"faces, {GIVEN.n_segments}, 2 and {GIVEN.n_segments} segments)")
    assert list(compare.scores)[2:] == ["C and truth", "B and A", "C and A"]
    assert list(compare.to_frame().index) == ["A", "B", "C"]
    first, *twins = compare.views
    assert [len(view._faces) for view in compare.views] == [12 * MESH.n_faces, 0, 0]
    assert [view._mesh_of for view in twins] == [first._token] * 2
    errors = [np.frombuffer(view._face_error, np.uint8) for view in compare.views]
    np.testing.assert_array_equal(errors[0], np.maximum(errors[1], errors[2]))
    assert (errors[2] == 1).all()
    assert {view.color_by for view in compare.views} == {"values"}
    assert {view.values_legend["title"] for view in compare.views} == {"Size ratio"}
    codes = np.frombuffer(twins[1]._face_value, np.uint16)
    assert len(np.unique(codes)) == 1  # the log of one, everywhere
    first.color_by = "segments"
    compare.others = (halves,)
    compare.wait(60)
    assert first.color_by == "segments"  # a new result leaves the choice
    assert twins[1]._face_error == twins[0]._face_error
    with pytest.raises(ValueError, match="others must stay 1, one a view, got 2"):
        compare.others = (halves, halves)
    compare.close()


def test_a_page_without_the_lender_gets_the_arrays():
    view = sw.SceneView(MESH)
    twin = view.twin()
    twin._handle_custom_msg({"kind": "need_mesh"}, [])
    assert (twin._mesh_of, twin._vertices, twin._faces) == ("", view._vertices, view._faces)


def test_a_measure_that_gives_something_else_is_refused():
    with pytest.raises(TypeError, match="disagreement must take the labels of two sides, got str"):
        sw.Compare(MESH, GIVEN, GIVEN, disagreement="iou")
    with pytest.raises(TypeError, match="labels of two sides: too many positional"):
        sw.Compare(MESH, GIVEN, GIVEN, disagreement=lambda first: first)
    compare = sw.Compare(MESH, GIVEN, GIVEN, disagreement=lambda first, other: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        compare.wait()
    assert "ZeroDivisionError: division by zero (raised by disagreement" in compare.views[0].error
    assert compare.scores["B and A"]["rand_index_error"] == 0.0
    compare.close()
    with pytest.raises(ValueError, match="at most 8 views at once"):
        sw.Compare(MESH, *[GIVEN] * 9)
    compare = sw.Compare(MESH, GIVEN, GIVEN, disagreement=lambda first, other: 0.5)
    with pytest.raises(ValueError, match=r"disagreement must give \d+ numbers, one a face"):
        compare.wait(30)
    compare.close()


def test_without_a_truth_they_are_compared_with_each_other():
    compare = sw.Compare(MESH, GIVEN, GIVEN)
    compare.wait(60)
    assert list(compare.scores) == ["B and A"]
    assert compare.scores["B and A"]["mean_iou"] == 1
    assert list(compare.to_frame().index) == ["B"]
    compare.close()


def test_a_result_that_is_no_longer_wanted_is_not_shown(monkeypatch):
    started, gate, seen = threading.Event(), threading.Event(), []
    run = sw.Pipeline.run

    def deaf(self, params, **_):
        started.set()
        assert gate.wait(30)
        if params != SMALL:
            seen.append([view.busy for view in compare.views])
        return run(self, params)

    monkeypatch.setattr(sw.Pipeline, "run", deaf)
    compare = sw.Compare(MESH, SMALL, GIVEN)
    assert started.wait(30)
    compare.a = SMALL.replace(n_segments=3)
    gate.set()
    found, _ = compare.wait(60)
    assert seen == [[True, True]]
    np.testing.assert_array_equal(found.labels, sw.segment(MESH, compare.a).labels)
    assert not compare.busy
    compare.close()


def test_cancel_stops_and_says_so(monkeypatch):
    started = threading.Event()

    def slow(self, params, *, progress, cancel):
        started.set()
        assert cancel.wait(30)
        raise sw.Cancelled("cancelled")

    monkeypatch.setattr(sw.Pipeline, "run", slow)
    compare = sw.Compare(MESH, GIVEN, SMALL)
    assert started.wait(30)
    compare.views[1]._handle_custom_msg({"kind": "cancel"}, [])
    with pytest.raises(RuntimeError, match="cancelled before there was a result"):
        compare.wait(30)
    assert [view.busy for view in compare.views] == [False, False]
    assert compare.views[1].status == "Cancelled"
    compare.close()


def test_an_error_is_shown_on_its_side_and_raised(monkeypatch):
    def fail(*_, **__):
        raise ValueError("no such thing")

    monkeypatch.setattr(sw.Pipeline, "run", fail)
    compare = sw.Compare(MESH, GIVEN, SMALL)
    with pytest.raises(ValueError, match="no such thing"):
        compare.wait(30)
    assert [view.error for view in compare.views] == ["", "ValueError: no such thing"]
    compare.close()


def test_what_can_not_be_compared_is_refused():
    with pytest.raises(TypeError, match=r"b must be .*; sides with names are given once"):
        sw.Compare(MESH, SMALL, {})
    box = shapes.box(2)
    other = sw.Segmentation.from_labels(box, np.zeros(box.n_faces, int))
    with pytest.raises(ValueError, match="a is of another mesh, of 48 faces"):
        sw.Compare(MESH, other)
    compare = sw.Compare(MESH, GIVEN, GIVEN)
    compare.wait(30)
    with pytest.raises(ValueError, match="b is of another mesh"):
        compare.b = other
    assert (compare.b, compare.busy, len(compare.segmentations)) == (GIVEN, False, 2)
    with pytest.raises(TypeError, match="timeout must be a number of seconds or None, got 'x'"):
        compare.wait("x")
    compare.close()
