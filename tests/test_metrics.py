"""Each metric against its definition, item by item or pair by pair, on small random labels."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csgraph
from sklearn.metrics import adjusted_rand_score

from scenewidget import metrics
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.segmentation import Segmentation

SYMMETRIC = (
    metrics.rand_index_error,
    metrics.global_consistency_error,
    metrics.local_consistency_error,
    metrics.hamming_distance,
    metrics.adjusted_rand_index,
    metrics.variation_of_information,
)
SCORES = (metrics.adjusted_rand_index, metrics.mean_iou)  # 1 is perfect; for the others 0 is
REGIONAL = (*SYMMETRIC, metrics.mean_iou)


@st.composite
def labelings(draw, lowest=-1):
    """Two label vectors of the same items, some unlabeled (never all), and weights or None."""
    n = draw(st.integers(1, 12))
    label = st.integers(lowest, 4)
    a = np.array(draw(st.lists(label, min_size=n, max_size=n)))
    b = np.array(draw(st.lists(label, min_size=n, max_size=n)))
    a[0], b[0] = max(a[0], 0), max(b[0], 0)
    weights = draw(st.none() | st.lists(st.floats(0.01, 10), min_size=n, max_size=n))
    return a, b, None if weights is None else np.array(weights)


def labeled(a, b, weights, unlabeled):
    """The same problem without unlabeled items: what the three options mean, said slowly."""
    w = np.ones(len(a)) if weights is None else weights
    if unlabeled == "drop":
        keep = [i for i in range(len(a)) if a[i] >= 0 and b[i] >= 0]
        return a[keep], b[keep], w[keep]
    if unlabeled == "one":
        return np.where(a < 0, 99, a), np.where(b < 0, 99, b), w
    own = 100 + np.arange(len(a))
    return np.where(a < 0, own, a), np.where(b < 0, own, b), w


def segment_of(labels, i):
    return labels == labels[i]


def brute_rand_index_error(a, b, w):
    pairs = list(itertools.combinations(range(len(a)), 2))
    wrong = sum(w[i] * w[j] for i, j in pairs if (a[i] == a[j]) != (b[i] == b[j]))
    return wrong / sum(w[i] * w[j] for i, j in pairs) if pairs else 0.0


def local_refinement_error(a, b, w, i):
    mine, other = segment_of(a, i), segment_of(b, i)
    return w[mine & ~other].sum() / w[mine].sum()


def brute_global_consistency_error(a, b, w):
    forth = sum(w[i] * local_refinement_error(a, b, w, i) for i in range(len(a)))
    back = sum(w[i] * local_refinement_error(b, a, w, i) for i in range(len(a)))
    return min(forth, back) / w.sum()


def brute_local_consistency_error(a, b, w):
    each = [
        min(local_refinement_error(a, b, w, i), local_refinement_error(b, a, w, i)) for i in range(len(a))
    ]
    return (w * each).sum() / w.sum()


def brute_directional_hamming(a, b, w):
    outside = 0.0
    for label in set(a):
        outside += min(w[(a == label) & (b != other)].sum() for other in set(b))
    return outside / w.sum()


def brute_hamming_distance(a, b, w):
    return 0.5 * (brute_directional_hamming(a, b, w) + brute_directional_hamming(b, a, w))


def brute_adjusted_rand_index(a, b, w):
    pairs = list(itertools.combinations(range(len(a)), 2))
    in_a, in_b, in_both, every = (
        sum(w[i] * w[j] for i, j in pairs if joined(i, j))
        for joined in (
            lambda i, j: a[i] == a[j],
            lambda i, j: b[i] == b[j],
            lambda i, j: a[i] == a[j] and b[i] == b[j],
            lambda i, j: True,
        )
    )
    if not pairs or in_a == in_b == 0 or (np.isclose(in_a, every) and np.isclose(in_b, every)):
        return 1.0
    expected = in_a * in_b / every
    return (in_both - expected) / ((in_a + in_b) / 2 - expected)


def brute_variation_of_information(a, b, w):
    def entropy(labels):
        shares = np.array([w[[x == y for y in labels]].sum() for x in set(labels)]) / w.sum()
        return -(shares * np.log(shares)).sum()

    joint = list(zip(a.tolist(), b.tolist()))
    return 2 * entropy(joint) - entropy(a.tolist()) - entropy(b.tolist())


def brute_mean_iou(a, b, w):
    rows, columns = list(set(a)), list(set(b))
    size = max(len(rows), len(columns))
    iou = np.zeros((size, size))
    for (i, x), (j, y) in itertools.product(enumerate(rows), enumerate(columns)):
        iou[i, j] = w[(a == x) & (b == y)].sum() / w[(a == x) | (b == y)].sum()
    best = max(sum(iou[order[j], j] for j in range(size)) for order in itertools.permutations(range(size)))
    return best / len(columns)


@pytest.mark.parametrize("metric", REGIONAL)
@pytest.mark.parametrize("unlabeled", ["drop", "one", "singletons"])
@settings(max_examples=60, deadline=None)
@given(case=labelings())
def test_metric_is_its_definition(metric, unlabeled, case):
    if metric is metrics.mean_iou:
        case = tuple(x if x is None else x[:6] for x in case)  # permutations are many
    a, b, weights = case
    x, y, w = labeled(a, b, weights, unlabeled)
    expected = globals()[f"brute_{metric.__name__}"](x, y, w)
    assert metric(a, b, weights, unlabeled) == pytest.approx(expected, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(case=labelings())
def test_directional_hamming_distance_looks_from_a(case):
    a, b, weights = case
    x, y, w = labeled(a, b, weights, "drop")
    value = metrics.hamming_distance(a, b, weights, directional=True)
    assert value == pytest.approx(brute_directional_hamming(x, y, w), abs=1e-9)


@settings(max_examples=100, deadline=None)
@given(case=labelings(lowest=0))
def test_adjusted_rand_index_agrees_with_scikit_learn(case):
    a, b, _ = case
    assert metrics.adjusted_rand_index(a, b) == pytest.approx(adjusted_rand_score(a, b), abs=1e-12)


@pytest.mark.parametrize("metric", SYMMETRIC)
@settings(max_examples=30, deadline=None)
@given(case=labelings())
def test_metric_is_symmetric(metric, case):
    a, b, weights = case
    assert metric(a, b, weights) == pytest.approx(metric(b, a, weights), abs=1e-12)


@pytest.mark.parametrize("metric", REGIONAL)
@settings(max_examples=30, deadline=None)
@given(case=labelings(), names=st.permutations([3, 70, 1, 5000, 12]))
def test_names_of_labels_change_nothing(metric, case, names):
    a, b, weights = case
    renamed = np.where(a >= 0, np.array(names)[a], -7)
    assert metric(renamed, b, weights) == pytest.approx(metric(a, b, weights), abs=1e-12)


@pytest.mark.parametrize("metric", REGIONAL)
@settings(max_examples=30, deadline=None)
@given(case=labelings(), seed=st.integers(0, 1000))
def test_order_of_items_changes_nothing(metric, case, seed):
    a, b, weights = case
    order = np.random.default_rng(seed).permutation(len(a))
    shuffled = None if weights is None else weights[order]
    assert metric(a[order], b[order], shuffled) == pytest.approx(metric(a, b, weights), abs=1e-12)


@pytest.mark.parametrize("metric", REGIONAL)
@settings(max_examples=30, deadline=None)
@given(case=labelings())
def test_a_segmentation_agrees_with_itself_perfectly(metric, case):
    a, _, weights = case
    assert metric(a, a, weights) == pytest.approx(1.0 if metric in SCORES else 0.0, abs=1e-12)


@pytest.mark.parametrize("metric", REGIONAL)
@settings(max_examples=30, deadline=None)
@given(case=labelings())
def test_weights_of_one_are_counts_and_their_unit_is_free(metric, case):
    a, b, _ = case
    assert metric(a, b, np.ones(len(a))) == pytest.approx(metric(a, b), abs=1e-12)
    assert metric(a, b, np.full(len(a), 3e-4)) == pytest.approx(metric(a, b), abs=1e-9)


@pytest.mark.parametrize("metric", [m for m in REGIONAL if m not in (SYMMETRIC[0], SYMMETRIC[4])])
def test_an_item_of_weight_two_is_two_items(metric):
    a, b = np.array([0, 0, 1, 1, 2]), np.array([0, 1, 1, 1, 0])
    weights = np.array([2.0, 1, 1, 2, 1])
    twice = np.repeat(np.arange(5), weights.astype(int))
    assert metric(a, b, weights) == pytest.approx(metric(a[twice], b[twice]), abs=1e-12)


def test_items_without_weight_count_nothing():
    a, b = np.array([0, 0, 1, 1, 2, 3]), np.array([0, 1, 1, 1, 0, 9])
    weights = np.array([1.0, 1, 1, 1, 1, 0])
    for metric in REGIONAL:
        assert metric(a, b, weights) == pytest.approx(metric(a[:5], b[:5]), abs=1e-12)


def test_a_worked_example():
    # contingency: a0 = {2 of b0, 1 of b1}, a1 = {3 of b1}
    a, b = np.array([0, 0, 0, 1, 1, 1]), np.array([0, 0, 1, 1, 1, 1])
    assert metrics.rand_index_error(a, b) == pytest.approx(5 / 15)
    assert metrics.global_consistency_error(a, b) == pytest.approx((2 / 3 + 2 / 3) / 6)
    assert metrics.local_consistency_error(a, b) == pytest.approx((1 * 2 / 3) / 6)
    assert metrics.hamming_distance(a, b) == pytest.approx((1 / 6 + 1 / 6) / 2)
    assert metrics.mean_iou(a, b) == pytest.approx((2 / 3 + 3 / 4) / 2)


def test_singletons_fool_the_consistency_errors_and_not_the_rand_index():
    truth = np.repeat(np.arange(4), 25)
    singletons = np.arange(100)
    assert metrics.global_consistency_error(singletons, truth) == 0
    assert metrics.local_consistency_error(singletons, truth) == 0
    assert metrics.rand_index_error(singletons, truth) == pytest.approx(4 * 300 / 4950)


def test_counts_are_exact_for_more_pairs_than_floats_can_tell_apart():
    truth = np.zeros(3_000_000, dtype=np.int32)
    one_off = truth.copy()
    one_off[7] = 1
    pairs = 3_000_000 * 2_999_999 // 2
    assert metrics.rand_index_error(one_off, truth) == 2_999_999 / pairs


def test_light_items_beside_a_heavy_one_keep_their_digits():
    weights = np.array([1e6, 1e-3, 2e-3, 3e-3])
    a, b = np.array([0, 1, 1, 2]), np.array([5, 6, 6, 6])
    wrong = 1e-3 * 3e-3 + 2e-3 * 3e-3
    pairs = 1e6 * 6e-3 + 1e-3 * 2e-3 + wrong
    assert metrics.rand_index_error(a, b, weights) == pytest.approx(wrong / pairs, rel=1e-3)
    assert metrics.adjusted_rand_index(a, a, weights) == pytest.approx(1, abs=1e-9)


def test_matching_of_many_segments_takes_the_sparse_way_to_the_same_sum():
    rng = np.random.default_rng(0)
    values = rng.uniform(0.05, 1.0, (40, 30)) * (rng.random((40, 30)) < 0.2)
    i, j = np.nonzero(values)
    dense = metrics._matching_sum(i, j, values[i, j], 40, 30)
    limit = metrics.DENSE_CELLS
    try:
        metrics.DENSE_CELLS = 0
        assert metrics._matching_sum(i, j, values[i, j], 40, 30) == pytest.approx(dense)
    finally:
        metrics.DENSE_CELLS = limit
    rows, columns = metrics.linear_sum_assignment(values, maximize=True)
    assert dense == pytest.approx(values[rows, columns].sum())


# --- cut discrepancy ------------------------------------------------------------------------------


def grid(n, height=lambda x, y: 0 * x):
    """An n × n sheet of unit cells, two triangles each."""
    x, y = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    vertices = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3).astype(float)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    right, up = corner + n + 1, corner + 1
    faces = np.concatenate([np.stack([corner, right, right + 1], 1), np.stack([corner, right + 1, up], 1)])
    return Mesh(vertices, faces)


def test_parallel_cuts_lie_as_far_apart_as_they_look():
    mesh = grid(10)
    x = mesh.face_centroids[:, 0]
    a, b = (x > 3).astype(int), (x > 5).astype(int)
    radius = np.average(np.linalg.norm(mesh.face_centroids - [5, 5, 0], axis=1), weights=mesh.face_areas)
    assert metrics.cut_discrepancy(a, b, mesh) == pytest.approx((2 + 2) / radius)
    assert metrics.cut_discrepancy(Segmentation.from_labels(mesh, a), a, mesh) == 0


def test_distance_runs_along_the_surface():
    fold = grid(10, lambda x, y: 4.0 * np.abs(x - 5))  # a steep valley between the two cuts
    x = fold.face_centroids[:, 0]
    a, b = (x > 3).astype(int), (x > 7).astype(int)
    flat = grid(10)
    ratio = metrics.cut_discrepancy(a, b, fold) * metrics._mean_radius(fold)
    assert ratio == pytest.approx(
        np.sqrt(17) * metrics.cut_discrepancy(a, b, flat) * metrics._mean_radius(flat)
    )


def brute_cut_distance(mesh, a, b):
    """The definition with all shortest paths over the edges and unfolded lines, one point at a time."""
    cuts = []
    for labels in (a, b):
        found = []
        for f, g in itertools.combinations(range(mesh.n_faces), 2):
            shared = set(mesh.faces[f].tolist()) & set(mesh.faces[g].tolist())
            if len(shared) == 2 and labels[f] != labels[g]:
                found.append(tuple(shared))
        cuts.append(found)
    n = mesh.n_vertices
    lengths = np.full((n, n), np.inf)
    for face in mesh.faces:
        for p, q in itertools.permutations(face, 2):
            lengths[p, q] = np.linalg.norm(mesh.vertices[p] - mesh.vertices[q])
    for f, g in itertools.combinations(range(mesh.n_faces), 2):
        shared = sorted(set(mesh.faces[f].tolist()) & set(mesh.faces[g].tolist()))
        if len(shared) == 2:  # in a plane the unfolded line is the straight one
            p, q = sorted(set(mesh.faces[[f, g]].ravel().tolist()) - set(shared))
            lengths[p, q] = lengths[q, p] = np.linalg.norm(mesh.vertices[p] - mesh.vertices[q])
    distance = csgraph.floyd_warshall(lengths)
    total = 0.0
    for mine, other in (cuts, cuts[::-1]):
        ends = sorted({v for edge in other for v in edge})
        size = [np.linalg.norm(mesh.vertices[p] - mesh.vertices[q]) for p, q in mine]
        far = [(distance[p, ends].min() + distance[q, ends].min()) / 2 for p, q in mine]
        total += np.average(far, weights=size)
    return total / metrics._mean_radius(mesh)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_cut_discrepancy_is_its_definition(seed):
    rng = np.random.default_rng(seed)
    mesh = grid(4)
    a, b = (rng.integers(0, 2, mesh.n_faces) for _ in range(2))
    a[0], a[1], b[0], b[1] = 0, 1, 0, 1
    assert metrics.cut_discrepancy(a, b, mesh) == pytest.approx(brute_cut_distance(mesh, a, b))
    assert metrics.cut_discrepancy(a, b, mesh) == pytest.approx(metrics.cut_discrepancy(b, a, mesh))


def test_cuts_of_one_side_only_have_no_distance():
    mesh = grid(3)
    a = (mesh.face_centroids[:, 0] > 1).astype(int)
    nothing = np.zeros(mesh.n_faces, dtype=int)
    assert np.isnan(metrics.cut_discrepancy(a, nothing, mesh))
    assert metrics.cut_discrepancy(nothing, nothing, mesh) == 0


def test_border_of_the_unlabeled_is_no_cut_unless_they_are_a_segment():
    mesh = grid(4)
    x = mesh.face_centroids[:, 0]
    a = np.where(x > 3, -1, (x > 1).astype(int))
    b = (x > 1).astype(int)
    assert metrics.cut_discrepancy(a, b, mesh) == 0
    assert metrics.cut_discrepancy(a, b, mesh, unlabeled="one") == pytest.approx(
        1 / metrics._mean_radius(mesh)
    )


def test_cuts_on_another_component_are_measured_through_the_air():
    mesh = grid(2)
    two = Mesh(
        np.concatenate([mesh.vertices, mesh.vertices + np.array([0, 0, 7])]),
        np.concatenate([mesh.faces, mesh.faces + mesh.n_vertices]),
    )
    x, is_upper = two.face_centroids[:, 0], two.face_centroids[:, 2] > 1
    a, b = ((x > 1) & is_upper).astype(int), ((x > 1) & ~is_upper).astype(int)
    assert metrics.cut_discrepancy(a, b, two) == pytest.approx((7 + 7) / metrics._mean_radius(two))


def test_moving_and_scaling_the_mesh_changes_no_discrepancy():
    mesh = grid(5, lambda x, y: np.sin(x) + 0.2 * y)
    rng = np.random.default_rng(1)
    a, b = rng.integers(0, 3, mesh.n_faces), rng.integers(0, 3, mesh.n_faces)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    moved = Mesh(4.0 * mesh.vertices @ turn + [3, -2, 9], mesh.faces)
    assert metrics.cut_discrepancy(a, b, moved) == pytest.approx(metrics.cut_discrepancy(a, b, mesh))


# --- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (([0, 1], [0, 1, 2]), ValueError, "a and b must label the same items, got 2 and 3"),
        (([], []), ValueError, "a and b are empty"),
        (([0.5, 1], [0, 1]), TypeError, "a must be whole-number labels or a Segmentation, got list"),
        (([0, 1], ["x", "y"]), TypeError, "b must be whole-number labels"),
        (([[0, 1]], [0, 1]), ValueError, r"a must have one label an item: shape \(n,\), got \(1, 2\)"),
        (([0, 1], [0, 1], [1.0]), ValueError, r"weights must have one entry an item: \(2,\)"),
        (([0, 1], [0, 1], ["a", "b"]), TypeError, "weights must be numbers"),
        (([0, 1], [0, 1], [1.0, np.nan]), ValueError, "weights must be finite and at least 0"),
        (([0, 1], [0, 1], [1.0, -1.0]), ValueError, "weights must be finite and at least 0"),
        (([0, 1], [0, 1], [0.0, 0.0]), ValueError, "weights sum to 0"),
        (([0, -1], [-1, 0]), ValueError, "no item is labeled in both a and b"),
        (([0, 1], [0, 1], None, "two"), ValueError, "unlabeled must be one of 'drop', 'one', 'singletons'"),
    ],
)
def test_bad_input_is_refused_with_a_reason(arguments, error, message):
    for metric in REGIONAL:
        with pytest.raises(error, match=message):
            metric(*arguments)


def test_cut_discrepancy_refuses_what_is_no_mesh_of_these_labels():
    mesh = grid(2)
    with pytest.raises(ValueError, match="one label a face: the mesh has 8 faces, got 2"):
        metrics.cut_discrepancy([0, 1], [0, 1], mesh)
    with pytest.raises(TypeError, match=r"mesh must be a scenewidget\.Mesh, got str"):
        metrics.cut_discrepancy([0, 1], [0, 1], "room.ply")
