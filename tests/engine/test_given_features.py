"""A descriptor of the user's own: what must change nothing, what it decides, what is refused."""

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import adjusted_rand_score

from scenewidget.datasets.analytic import square
from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.features import checked_descriptor, delta_coordinates, unit_steps
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline, segment

BLOB = Mesh(0.5 * shapes.blob(3).vertices, shapes.blob(3).faces)  # something round: many superfacets
ROOM = shapes.joined(shapes.room(8, noise=0.003)[0], BLOB)
GIVEN = Params(feature="given", n_items=400, k_range=(12, 18), n_runs=5, n_graph_runs=2)
FEATURES_ALONE = Params.thesis(2, feature="given", cost_b=0, merge=False, k_range=(2, 2), n_runs=9)

pytestmark = pytest.mark.filterwarnings("ignore:.*:UserWarning")


def same(a, b):
    np.testing.assert_array_equal(a.labels, b.labels)
    np.testing.assert_array_equal(a.confidence, b.confidence)


def same_pieces(a, b):
    """Whether two labelings differ by names alone."""
    pairs = np.unique(np.stack([a, b]), axis=1)
    return len(pairs.T) == len(np.unique(a)) == len(np.unique(b))


# --- what must change nothing ---------------------------------------------------------------------


@given(
    seed=st.integers(0, 9),
    factor=st.floats(1e-200, 1e200) | st.sampled_from([-1.0, 0.3, 5e300, 2e-300]),
    constants=st.lists(st.floats(-1e6, 1e6), max_size=3),
    order=st.permutations(range(4)),
    by_face=st.booleans(),
)
@settings(max_examples=10, deadline=None)
def test_unit_order_and_constant_columns_change_nothing(seed, factor, constants, order, by_face):
    n = BLOB.n_faces if by_face else BLOB.n_vertices
    features = np.random.default_rng(seed).normal(size=(n, 4))
    told = np.column_stack([factor * features[:, order], np.tile(constants, (n, 1))])
    pipe, other = Pipeline(BLOB, features=features), Pipeline(BLOB, features=told)
    for params in (GIVEN, GIVEN.replace(cost_b=0.0)):
        for ours, theirs in zip(pipe.get("distances", params), other.get("distances", params)):
            np.testing.assert_array_equal(ours, theirs)  # in bits, so all that follows is the same, too


def test_a_factor_changes_no_label():
    features = np.random.default_rng(0).normal(size=(ROOM.n_vertices, 3))
    same(segment(ROOM, GIVEN, features=features), segment(ROOM, GIVEN, features=0.3e9 * features))


@pytest.mark.parametrize("kind", ["uniform", "cotangent"])
def test_our_own_features_given_say_what_they_say_as_ours(kind):
    params = GIVEN.replace(hop=0.0)  # the one summand of a weight that has a unit
    pipe = Pipeline(ROOM, features=delta_coordinates(ROOM, kind))
    ours = pipe.get("distances", params.replace(feature=kind))[0]
    given = pipe.get("distances", params)[0]
    is_far = np.isfinite(ours) & (ours > 0)
    ratio = given[is_far] / ours[is_far]
    np.testing.assert_allclose(ratio, np.median(ratio), rtol=1e-4)
    np.testing.assert_array_equal(np.isfinite(given), np.isfinite(ours))
    labels = pipe.run(params).labels  # ties within the precision of float32 may fall otherwise
    assert adjusted_rand_score(pipe.run(params.replace(feature=kind)).labels, labels) > 0.95


def test_features_of_faces_are_those_of_vertices_once_lifted():
    by_vertex = np.random.default_rng(0).normal(size=(ROOM.n_vertices, 2))
    by_face = by_vertex[ROOM.faces].mean(axis=1)
    same(segment(ROOM, GIVEN, features=by_vertex), segment(ROOM, GIVEN, features=by_face))


def test_types_of_numbers_change_nothing():
    features = np.random.default_rng(0).integers(0, 5, (ROOM.n_vertices, 2))
    plain = segment(ROOM, GIVEN, features=features)
    for kind in (np.float32, np.uint8, np.float16):
        same(plain, segment(ROOM, GIVEN, features=features.astype(kind)))
    same(plain, segment(ROOM, GIVEN, features=features.tolist()))


def test_what_is_done_to_the_array_afterwards_changes_nothing():
    features = np.random.default_rng(0).normal(size=(ROOM.n_faces, 2))
    kept = features.copy()
    pipe = Pipeline(ROOM, features=features)
    features[:] = 0.0
    same(pipe.run(GIVEN), segment(ROOM, GIVEN, features=kept))
    np.testing.assert_array_equal(pipe.run(Params(n_runs=2, n_graph_runs=2)).face_map >= 0, True)


# --- what it decides ------------------------------------------------------------------------------


@pytest.mark.parametrize("items", ["raw", "simplified"])
def test_halves_of_a_plane_that_geometry_cannot_tell_apart(items):
    plane = square(24)
    side = plane.face_centroids[:, 0] > 0.5
    params = FEATURES_ALONE.replace(n_items=plane.n_faces if items == "raw" else 400)
    result = segment(plane, params, features=1e-6 * np.column_stack([side, np.full(len(side), 3)]))
    assert result.n_segments == 2
    agree = np.mean((result.labels == 1) == side)
    assert max(agree, 1 - agree) >= (1.0 if items == "raw" else 0.95)
    assert not same_pieces(segment(plane, params.replace(feature="normals")).labels, side)


def test_a_step_along_one_border_is_one_and_creases_still_count():
    features = np.zeros((100, 1))
    features[50:] = 1e-9
    pairs = np.stack([np.arange(99), np.arange(1, 100)], axis=1)
    scaled = unit_steps(features, pairs)
    np.testing.assert_allclose(np.abs(np.diff(scaled[:, 0])).max(), 1.0)
    box = shapes.box(6)
    half = (box.face_centroids[:, :1] > np.median(box.face_centroids[:, 0])).astype(float)
    result = segment(box, Params(feature="given", n_graph_runs=0, k_range=(6, 6)), features=half)
    assert same_pieces(result.labels, np.unique(box.face_normals.round(), axis=0, return_inverse=True)[1])


def test_features_that_say_nothing_leave_it_to_the_normals_and_say_so():
    with pytest.warns(UserWarning, match="features differ between no neighbouring items"):
        silent = segment(ROOM, GIVEN, features=np.full((ROOM.n_faces, 2), 0.1))
    same(silent, segment(ROOM, GIVEN.replace(feature="normals")))


def test_as_many_vertices_as_faces_are_vertices():
    octahedron = Mesh(
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [5, 5, 5], [6, 6, 6]],
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
    )
    assert octahedron.n_vertices == octahedron.n_faces
    features = np.arange(8.0)[:, None]
    by_face = features[octahedron.faces].mean(axis=1)
    told = checked_descriptor(octahedron, features)
    np.testing.assert_allclose(np.diff(told, axis=0), np.diff(by_face, axis=0) / 4)


def test_features_of_a_cloud_are_of_its_points():
    points = np.random.default_rng(0).uniform(size=(400, 3)) * [2, 2, 0.001]
    cloud = PointCloud(points)
    side = (points[:, :1] > 1.0).astype(float)
    np.testing.assert_array_equal(checked_descriptor(cloud, side), side - 0.5)
    assert segment(cloud, GIVEN, features=side).labels.shape == (400,)


# --- what is refused ------------------------------------------------------------------------------


BOX = shapes.box(3)
N, F = BOX.n_vertices, BOX.n_faces


@pytest.mark.parametrize(
    ("features", "error", "message"),
    [
        (np.zeros((5, 2)), ValueError, rf"features must have shape \({N}, d\).*\({F}, d\).*got \(5, 2\)"),
        (np.zeros(F), ValueError, rf"features must have shape .* got \({F},\); write features\[:, None\]"),
        (np.zeros((F, 2, 2)), ValueError, "features must have shape"),
        (np.zeros((F, 0)), ValueError, "features must have at least one column"),
        (
            np.where(np.arange(F) == 7, np.nan, 0.0)[:, None],
            ValueError,
            "in 1 of 108 rows, first in row 7",
        ),
        (np.full((N, 1), np.inf), ValueError, "features must be finite"),
        (np.zeros((F, 1), complex), TypeError, "features must be numbers, got complex128"),
        (np.full((F, 1), "wall"), TypeError, "features must be numbers, got <U4; turn classes into"),
    ],
)
def test_features_that_fit_no_mesh_are_refused(features, error, message):
    for run in (segment, lambda mesh, params, features: Pipeline(mesh, features=features)):
        with pytest.raises(error, match=message):
            run(BOX, Params(feature="given"), features=features)


def test_features_and_the_option_want_each_other():
    with pytest.raises(ValueError, match=r"features are not looked at under feature='normals'; write"):
        segment(BOX, features=np.zeros((F, 1)))
    pipe = Pipeline(BOX)
    for call in (pipe.run, pipe.family, lambda params: pipe.get("features", params)):
        with pytest.raises(
            ValueError, match=r'feature="given" needs features: segment\(mesh, params, features=X'
        ):
            call(Params(feature="given"))
