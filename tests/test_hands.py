"""What several people say of one scan: their agreement in pairs, and the segmentation that they agree on."""

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget import metrics
from scenewidget.evaluation import METRICS

MESH = shapes.sheet(3, 4, width=3.0, depth=4.0)  # 24 faces of ½ m²
labelings = st.lists(st.integers(-1, 4), min_size=24, max_size=24).map(np.array)
people = st.lists(labelings, min_size=1, max_size=4).map(lambda them: dict(zip("abcd", them)))


def segmentation(labels, names=()):
    return sw.Segmentation.from_labels(MESH, labels, names=names)


def halves(*sides):
    """A label a quarter of the sheet."""
    return np.repeat(sides, 6)


@settings(max_examples=60, deadline=None)
@given(people, st.randoms(use_true_random=False))
def test_the_order_of_people_does_not_matter(them, random):
    names = list(them)
    random.shuffle(names)
    one, other = sw.consensus(them, MESH), sw.consensus({name: them[name] for name in names}, MESH)
    assert one.labels.tolist() == other.labels.tolist()
    assert one.confidence.tolist() == other.confidence.tolist()
    assert one.names == other.names


@settings(max_examples=60, deadline=None)
@given(labelings, st.integers(1, 4))
def test_what_all_say_is_the_consensus(labels, n):
    own = segmentation(labels, [f"thing {k}" for k in range(5)])
    agreed = sw.consensus({str(k): own for k in range(n)})
    assert agreed.labels.tolist() == own.labels.tolist()
    assert agreed.names == own.names
    assert agreed.confidence.tolist() == (own.labels >= 0).tolist()


@settings(max_examples=60, deadline=None)
@given(people)
def test_confidence_is_a_share_and_labels_are_where_somebody_labels(them):
    agreed = sw.consensus(them, MESH)
    is_labeled = np.any([labels >= 0 for labels in them.values()], axis=0)
    assert (agreed.labels >= 0).tolist() == is_labeled.tolist()
    assert (agreed.confidence[is_labeled] > 0).all()
    assert agreed.confidence.max(initial=0) <= 1


@settings(max_examples=40, deadline=None)
@given(people)
def test_whoever_labels_nothing_changes_nothing(them):
    one, other = sw.consensus(them, MESH), sw.consensus({**them, "idle": np.full(24, -1)}, MESH)
    assert one.labels.tolist() == other.labels.tolist()
    assert one.confidence.tolist() == other.confidence.tolist()


def test_the_majority_decides_and_the_confidence_says_by_how_much():
    them = {"a": halves(0, 0, 1, 1), "b": halves(0, 0, 1, 1), "c": halves(0, 1, 1, 1)}
    agreed = sw.consensus(them, MESH)
    assert agreed.labels.tolist() == halves(0, 0, 1, 1).tolist()
    shares = [(1 + 1 + 1 / 2) / 3, (1 + 1 + 1 / 4) / 3, (1 + 1 + 2 / 3) / 3]
    assert agreed.confidence[[0, 6, 12]] == pytest.approx(shares)


def test_a_sliver_between_two_borders_is_no_segment_of_its_own():
    a, b = np.repeat([0, 1], 12), np.repeat([0, 1], [14, 10])
    assert sw.consensus({"a": a, "b": b}, MESH).n_segments == 2


def test_only_pairs_seen_together_count():
    them = {"a": halves(0, 0, -1, -1), "b": halves(-1, 0, 0, -1), "c": halves(-1, -1, 0, 1)}
    assert sw.consensus(them, MESH).labels.tolist() == halves(0, 0, 0, 1).tolist()


def test_parts_that_nobody_saw_together_stay_apart():
    them = {"a": halves(0, 0, -1, -1), "b": halves(-1, -1, 0, 0)}
    assert sw.consensus(them, MESH).labels.tolist() == halves(0, 0, 1, 1).tolist()


def test_names_are_voted_and_who_has_none_abstains():
    chair = segmentation(halves(0, 0, 1, 1), ["chair", ""])
    stool = segmentation(halves(0, 0, 1, 1), ["stool", "wall"])
    agreed = sw.consensus({"a": chair, "b": stool, "c": chair, "d": halves(0, 0, 1, 1)})
    assert agreed.names == ("chair", "wall")
    assert sw.consensus({"b": stool, "a": chair}).names == ("chair", "wall")  # a tie: by alphabet


def test_a_name_that_only_reaches_over_the_border_is_no_vote():
    reaching = segmentation(np.repeat([0, 1], [14, 10]), ["wall", ""])
    agreed = sw.consensus({"a": reaching, "b": np.repeat([0, 1], 12), "c": np.repeat([0, 1], 12)}, MESH)
    assert agreed.names == ("wall", "")


def test_a_split_in_the_editor_offers_what_was_in_dispute():
    them = {"a": halves(0, 0, 1, 1), "b": halves(0, 0, 1, 1), "c": halves(0, 2, 1, 1)}
    session = sw.Session(MESH, sw.consensus(them, MESH))
    session.split(7, level="base")
    assert sw.metrics.rand_index_error(session.segmentation, halves(0, 2, 1, 1)) == 0


@settings(max_examples=30, deadline=None)
@given(labelings, labelings)
def test_agreement_is_the_same_from_both_sides(a, b):
    names = [name for name in METRICS if name != "cut_discrepancy"]
    one = sw.agreement({"a": a, "b": b}, MESH, metrics=names).loc[("a", "b")]
    other = sw.agreement({"b": b, "a": a}, MESH, metrics=names).loc[("b", "a")]
    columns = [*names, "coverage"]
    np.testing.assert_allclose(one[columns].astype(float), other[columns].astype(float), atol=1e-12)


def test_agreement_has_a_row_a_pair_and_every_metric():
    first, second = segmentation(halves(0, 0, 1, 1)), segmentation(halves(0, 1, 2, -1))
    table = sw.agreement({"a": first, "b": second, "c": first})
    assert list(table.index) == [("a", "b"), ("a", "c"), ("b", "c")]
    assert list(table.columns) == [*METRICS, "coverage", "same_name", "n_first", "n_second"]
    row = table.loc[("a", "b")]
    assert row["rand_index_error"] == metrics.rand_index_error(first, second)
    assert row["cut_discrepancy"] == metrics.cut_discrepancy(first, second, MESH)
    both_ways = (metrics.mean_iou(first, second) + metrics.mean_iou(second, first)) / 2
    assert row["mean_iou"] == pytest.approx(both_ways)
    assert row[["coverage", "n_first", "n_second"]].tolist() == [0.75, 2, 3]
    assert table.loc[("a", "c"), ["rand_index_error", "mean_iou", "coverage"]].tolist() == [0, 1, 1]


def test_same_name_counts_what_both_have_named():
    first = segmentation(halves(0, 1, 2, 3), ["floor", "wall", "", "lamp"])
    second = segmentation(halves(0, 1, 2, 3), ["floor", "door", "bed", "lamp"])
    assert sw.agreement({"a": first, "b": second}).iloc[0]["same_name"] == pytest.approx(2 / 3)
    assert np.isnan(sw.agreement({"a": first, "b": halves(0, 1, 2, 3)}).iloc[0]["same_name"])


def test_each_segment_says_with_whom_it_agrees_and_how_much_lies_outside():
    first = segmentation(halves(0, 0, 1, 1), ["floor", "wall"])
    second = segmentation(halves(0, 0, 1, 2), ["floor", "wall", "door"])
    table = sw.agreement({"a": first, "b": second}, per="segment")
    half = table.loc[("a", "b", 1)]
    assert half[["name", "match_name", "iou", "outside"]].tolist() == ["wall", "wall", 0.5, 0.5]
    assert table.loc[("b", "a", 2), ["match", "iou", "outside"]].tolist() == [1, 0.5, 0]
    assert table.loc[("a", "b", 0), "iou"] == 1
    assert table.iou.is_monotonic_increasing


def test_each_name_says_how_far_they_agree_on_it():
    first = segmentation(halves(0, 0, 1, -1), ["floor", "wall"])
    second = segmentation(halves(0, 1, 2, 2), ["floor", "door", "wall"])
    table = sw.agreement({"a": first, "b": second}, per="name").iou
    assert table.to_dict() == {("a", "b", "door"): 0, ("a", "b", "floor"): 0.5, ("a", "b", "wall"): 1}
    assert sw.agreement({"a": halves(0, 0, 1, 1), "b": first}, MESH, per="name").index.get_level_values(
        "name"
    ).tolist() == ["floor", "wall"]
    with pytest.raises(ValueError, match="per must be 'pair', 'segment' or 'name', got 'face'"):
        sw.agreement({"a": first, "b": second}, per="face")


def test_who_labels_other_faces_has_nothing_to_compare():
    row = sw.agreement({"a": halves(0, 0, -1, -1), "b": halves(-1, -1, 0, 0)}, MESH).iloc[0]
    assert row[list(METRICS)].isna().all()
    assert row["coverage"] == 0


@pytest.mark.parametrize("function", [sw.agreement, sw.consensus])
@pytest.mark.parametrize(
    ("annotations", "mesh", "error", "message"),
    [
        ([halves(0, 0, 1, 1)], MESH, TypeError, "annotations must map names to segmentations"),
        ({}, MESH, ValueError, "annotations is empty"),
        (
            {"a": halves(0, 0, 1, 1)[1:], "b": halves(0, 0, 1, 1)},
            MESH,
            ValueError,
            r"annotations\['a'\] must",
        ),
        ({"a": halves(0, 0, 1, 1), "b": "none"}, MESH, TypeError, r"annotations\['b'\] must be a Segm"),
        ({"a": halves(0, 0, 1, 1)}, None, TypeError, "mesh is needed when all annotations are arrays"),
        ({"a": halves(0, 0, 1, 1)}, "scan.ply", TypeError, "mesh must be a scenewidget.Mesh, got str"),
        ({"a": segmentation(halves(0, 0, 1, 1))}, shapes.triangle(), ValueError, "belongs to another mesh"),
    ],
)
def test_bad_input_is_named(function, annotations, mesh, error, message):
    with pytest.raises(error, match=message):
        function(annotations, mesh)


def test_segments_may_have_any_numbers_and_there_may_be_none():
    far = halves(0, 0, 1, 1) + 2**40
    table = sw.agreement({"a": far, "b": halves(0, 0, 1, 1)}, MESH, per="segment")
    assert table.loc[("a", "b", 2**40 + 1), ["match", "iou"]].tolist() == [1, 1.0]
    nothing = np.full(MESH.n_faces, -1)
    assert len(sw.agreement({"a": nothing, "b": nothing}, MESH, per="segment")) == 0


def test_one_annotation_agrees_with_nobody():
    with pytest.raises(ValueError, match="holds only 'a'; agreement takes two or more"):
        sw.agreement({"a": halves(0, 0, 1, 1)}, MESH)


def test_labels_that_nobody_drew_are_refused(monkeypatch):
    monkeypatch.setattr("scenewidget.hands.LARGEST", 3)
    with pytest.raises(ValueError, match="into 4 parts, more than 3"):
        sw.consensus({"a": halves(0, 1, 2, 3)}, MESH)
