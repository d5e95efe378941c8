"""A family of segmentations: nested, exact in number, through the run, and average linkage at heart."""

import dataclasses
import pickle

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import adjusted_rand_score

from scenewidget.engine.consensus import CoAssociation, co_association
from scenewidget.engine.family import make_family
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.moments import face_moments
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.engine.segmentation import Segmentation

ROOM, _ = shapes.room(10, noise=0.003)
FAST = Params(n_items=800, n_segments=8, k_range=(20, 40), n_runs=6, n_graph_runs=6)

pytestmark = pytest.mark.filterwarnings("ignore:.*:UserWarning")


@pytest.fixture(scope="module", params=["default", "thesis", "auto"])
def run(request):
    """A family and the result that it runs through."""
    params = {
        "default": FAST,
        "thesis": Params.thesis(n_segments=8, n_items=400, k_range=(16, 24), n_runs=6),
        "auto": FAST.replace(n_segments="auto", consensus="linkage"),
    }[request.param]
    pipe = Pipeline(ROOM)
    return pipe.run(params), pipe.family(params)


def is_union(coarse, fine):
    """Whether every segment of `fine` lies in one of `coarse`."""
    keep = fine >= 0
    pairs = np.unique(np.stack([fine[keep], coarse[keep]]), axis=1)
    return np.array_equal(fine >= 0, coarse >= 0) and len(np.unique(pairs[0])) == pairs.shape[1]


def test_every_cut_has_its_number_of_segments_and_is_a_union_of_the_finer_one(run):
    result, family = run
    assert family.least < family.most
    finer = family.cut(family.most)
    for n in range(family.most - 1, family.least - 1, -1):
        cut = family.cut(n)
        assert cut.n_segments == n
        assert is_union(cut.labels, finer.labels)
        if n != result.n_segments:  # whose cut is the run itself, with its own numbers
            np.testing.assert_array_equal(family.item_labels(n), cut.item_labels)
        finer = cut


def test_the_cut_at_the_number_of_the_run_is_the_run(run):
    result, family = run
    cut = family.cut(result.n_segments)
    np.testing.assert_array_equal(cut.labels, result.labels)
    np.testing.assert_array_equal(cut.confidence, result.confidence)


def test_a_cut_is_a_segmentation_like_any_other(run):
    result, family = run
    cut = family.cut(max(family.least, result.n_segments - 2))
    areas = np.bincount(cut.labels[cut.labels >= 0], ROOM.face_areas[cut.labels >= 0])
    assert (np.diff(areas) <= 1e-9).all()
    np.testing.assert_array_equal(np.append(cut.item_labels, -1)[cut.face_map], cut.labels)
    assert cut.confidence.dtype == np.float32
    assert cut.confidence.min() >= 0
    assert cut.confidence.max() <= 1
    for level in ("dihedral", "base"):
        np.testing.assert_array_equal(cut.level(level), result.level(level))


def test_a_cut_finds_its_doubt_when_it_is_asked_for(run):
    result, family = run
    n = max(family.least, result.n_segments - 2)
    cut, other = family.cut(n), family.cut(n)
    assert callable(cut.doubt)
    assert cut.doubt().pieces.labels is cut.labels
    sent = pickle.loads(pickle.dumps(cut))
    np.testing.assert_array_equal(sent.confidence, other.confidence)
    np.testing.assert_array_equal(dataclasses.replace(other, names=["x"] * n).confidence, cut.confidence)
    assert cut.doubt is cut.find_doubt()
    relabeled = dataclasses.replace(family.cut(n), labels=result.labels, names=())
    assert relabeled.find_doubt().pieces.labels is relabeled.labels


def test_a_cut_knows_the_borders_that_its_labels_have(run):
    result, family = run
    cut = family.cut(max(family.least, result.n_segments - 2))
    known = cut.borders().sort_values(["first", "second"])
    anew = dataclasses.replace(cut, doubt=None).borders().sort_values(["first", "second"])
    for column in ("first", "second", "length", "agreement", "offset"):
        np.testing.assert_allclose(known[column], anew[column], atol=1e-6)


def test_numbers_outside_the_family_are_refused_with_its_range(run):
    _, family = run
    for n in (family.least - 1, family.most + 1):
        with pytest.raises(ValueError, match=rf"n_segments must lie in {family.least}\.\.{family.most}"):
            family.cut(n)
    with pytest.raises(TypeError, match=r"n_segments must be a whole number, got 2\.0"):
        family.cut(2.0)


@pytest.mark.parametrize("consensus", ["linkage", "median", "peac"])
def test_granularity_is_an_option_that_goes_as_far_as_the_family_does(consensus):
    pipe, params = Pipeline(ROOM), FAST.replace(consensus=consensus)
    family = pipe.family(params)
    for n, expected in ((family.least + 1, family.least + 1), (1, family.least), (9999, family.most)):
        cut = pipe.run(params.replace(granularity=n))
        np.testing.assert_array_equal(cut.labels, family.cut(expected).labels)
    assert pipe.family(params.replace(granularity=3)) is family


def test_scenes_that_lie_far_apart_stay_apart():
    far = Mesh(ROOM.vertices + np.array([50.0, 60.0, 70.0]), ROOM.faces)
    family = Pipeline(shapes.joined(ROOM, far)).family(FAST)
    labels = family.cut(family.least).labels
    assert not set(labels[: ROOM.n_faces]) & set(labels[ROOM.n_faces :])


def test_the_family_is_remembered_and_the_same_every_time():
    pipe = Pipeline(ROOM)
    family = pipe.family(FAST)
    assert pipe.family(FAST) is family
    again = Pipeline(ROOM).family(FAST)
    np.testing.assert_array_equal(again.merges, family.merges)
    np.testing.assert_array_equal(again.piece, family.piece)


def test_the_pipeline_says_what_it_knows():
    pipe = Pipeline(ROOM)
    assert not pipe.knows("coassociation", FAST)
    pipe.run(FAST)
    assert pipe.knows("coassociation", FAST.replace(n_segments=5))
    assert not pipe.knows("coassociation", FAST.replace(cost_exponent=2.0))
    assert not pipe.knows("no such stage", FAST)


def scattered(areas):
    """A triangle of each area, far apart, and an item a triangle, each the neighbour of every other."""
    n = len(areas)
    corner = np.stack([10.0 * np.arange(n), np.zeros(n), np.zeros(n)], axis=1)
    sides = np.sqrt(2 * np.asarray(areas, float))[:, None]
    vertices = np.concatenate([corner, corner + sides * [1, 0, 0], corner + sides * [0, 1, 0]])
    mesh = Mesh(vertices, np.arange(3 * n).reshape(3, n).T)
    each, normals = np.arange(n, dtype=np.int32), np.tile([0.0, 0.0, 1.0], (n, 1))
    pairs = np.stack(np.triu_indices(n, 1), axis=1).astype(np.int32)
    seam = np.arange(len(pairs), dtype=np.int32)
    return Items(
        mesh.face_areas.copy(), mesh.face_centroids.copy(), normals, face_moments(mesh), pairs, seam,
        np.ones(len(pairs), np.float32), mesh, each, each.copy(),
    )  # fmt: skip


@given(st.integers(0, 2**32 - 1), st.integers(3, 9))
@settings(max_examples=25)
def test_those_are_joined_of_which_fewest_places_are_expected_to_be_wrongly_together(seed, n):
    rng = np.random.default_rng(seed)
    items = scattered(rng.uniform(0.5, 2.0, n))
    half = np.triu(rng.uniform(0.1, 0.9, (n, n)), 1)  # no ties
    C = half + half.T + np.eye(n)
    co = CoAssociation(C, items.areas, np.arange(n, dtype=np.int32))
    segments = Segmentation(
        items.mesh, np.argsort(np.argsort(-items.areas)), items=items, face_map=items.face_map,
        item_labels=np.argsort(np.argsort(-items.areas)),
    )  # fmt: skip
    family = make_family(segments, np.zeros(n, int), co)
    assert (family.least, family.most) == (1, n)
    groups = [[i] for i in range(n)]
    wrong = np.outer(items.areas, items.areas) * (1 - C)
    at = np.empty(n, int)
    at[family.piece] = np.arange(n)  # pieces are numbered by their segments
    for kept, gone in at[family.merges]:
        ways = {
            (a, b): wrong[np.ix_(x, y)].sum() for b, y in enumerate(groups) for a, x in enumerate(groups[:b])
        }
        one, other = min(ways, key=ways.get)
        assert [kept in groups[k] for k in (one, other)] == [gone in groups[k] for k in (other, one)]
        assert kept in groups[one] + groups[other]
        groups[one] += groups.pop(other)


def test_few_segments_are_the_large_ones_and_no_heap_beside_crumbs():
    """Ten scraps float in the room; of seven segments six are still its sides."""
    box = shapes.box(24, size=(4.0, 3.0, 2.4))
    side = 2 * np.abs(box.face_normals).argmax(axis=1) + (box.face_normals.sum(axis=1) > 0)
    scrap = shapes.sheet(4, 4, width=0.2, depth=0.2)
    scrap = Mesh(scrap.vertices - [1.2, 0, 0], scrap.faces)
    mesh = shapes.joined(Mesh(box.vertices, box.faces[:, ::-1]), shapes.joined(*[scrap] * 10, gap=0.25))
    run = Pipeline(mesh).run(Params(n_segments=7))
    assert run.n_segments == 7
    table = np.zeros((7, 6))
    np.add.at(table, (run.labels[: box.n_faces], side), 1)
    assert (table.max(axis=0) > 0.95 * np.bincount(side)).all()
    assert len(set(table.argmax(axis=0))) == 6


def test_within_a_segment_pieces_are_joined_before_segments_are():
    """Two halves of a segment that never fall together are joined before two segments that always do."""
    items = scattered([4.0, 3.0, 2.0, 1.0])
    co = co_association(np.array([[0, 0], [1, 1], [2, 2], [2, 2]]), items.areas)
    segments = Segmentation(
        items.mesh, [0, 0, 1, 2], items=items, face_map=items.face_map, item_labels=np.array([0, 0, 1, 2])
    )
    family = make_family(segments, np.arange(4), co)
    assert family.merges.tolist() == [[0, 1], [2, 3], [0, 2]]
    assert family.similarity.tolist() == [0.0, 1.0, 0.0]
    assert adjusted_rand_score(family.cut(3).labels, [0, 0, 1, 2]) == 1


def test_crumbs_are_not_told_apart():
    items = scattered([4.0, 3.0, 0.01, 1.0])
    co = co_association(np.array([[0, 0], [1, 1], [1, 1], [2, 2]]), items.areas)
    labels = np.array([0, 0, 0, 1])
    segments = Segmentation(items.mesh, labels, items=items, face_map=items.face_map, item_labels=labels)
    family = make_family(segments, np.arange(4), co, min_area=0.02)
    assert family.most == 3
    assert family.piece[2] == family.piece[1]
