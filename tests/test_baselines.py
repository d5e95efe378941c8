"""Felzenszwalb by hand on a folded strip, measures of objectness on known shapes, Karpathy as a whole."""

import math
import threading

import numpy as np
import pytest
import shapes
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from scenewidget import metrics
from scenewidget.baselines import (
    THRESHOLDS,
    felzenszwalb,
    karpathy,
    karpathy_oversegmentations,
    objectness,
    shape_measures,
)
from scenewidget.baselines.graph_segmentation import face_labels, mesh_graph, vertex_normals
from scenewidget.baselines.object_discovery import _fill_bag, _overlaps, _suppress
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.monitor import SILENT, Cancelled


def folded_strip(turns, width=1.0):
    """Unit squares in a row, two triangles each, normals up, folded between squares by the angles given.

    A positive turn bends down: a convex ridge seen from above.
    """
    heading = -np.cumsum([0.0, *turns])
    x = np.concatenate([[0.0], np.cumsum(np.cos(heading))])
    z = np.concatenate([[0.0], np.cumsum(np.sin(heading))])
    n, left = len(x), np.arange(len(x) - 1)
    vertices = np.concatenate([np.stack([x, 0 * x + y, z], axis=1) for y in (0.0, width)])
    lower = np.stack([left, left + 1, left + n], axis=1)
    upper = np.stack([left + 1, left + n + 1, left + n], axis=1)
    return Mesh(vertices, np.stack([lower, upper], axis=1).reshape(-1, 3))


def turn(weight):
    """The angle between normals whose weight 1 − cos is given."""
    return math.acos(1.0 - weight)


def scene():
    """Two balls on a floor, grown together with it as in a fused scan, and a speck that touches nothing."""
    side = np.linspace(-0.6, 0.6, 61)
    x, y = np.meshgrid(side, side, indexing="ij")
    z = np.zeros_like(x)
    for cx, cy, r in ((-0.25, 0.0, 0.18), (0.3, 0.1, 0.2)):
        squared = r**2 - (x - cx) ** 2 - (y - cy) ** 2
        z = np.maximum(z, np.sqrt(np.maximum(squared, 0)))
    n = len(side)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + n, corner + n + 1], 1), np.stack([corner, corner + n + 1, corner + 1], 1)]
    )
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    speck = [[0, 0, 1], [0.01, 0, 1], [0, 0.01, 1]]
    mesh = Mesh(np.concatenate([vertices, speck]), np.concatenate([faces, [[n * n, n * n + 1, n * n + 2]]]))
    c = mesh.face_centroids
    truth = np.zeros(mesh.n_faces, dtype=int)
    truth[np.hypot(c[:, 0] + 0.25, c[:, 1]) < 0.18] = 1
    truth[np.hypot(c[:, 0] - 0.3, c[:, 1] - 0.1) < 0.2] = 2
    truth[-1] = 3
    return mesh, truth


# --- Felzenszwalb ---------------------------------------------------------------------------------


def test_felzenszwalb_by_hand_on_a_strip_with_three_concave_folds():
    # Four squares of two faces. Inside a square the weight is 0, so each starts with limit 0 + c/2.
    # Folds weigh .1, .3, .1.
    mesh = folded_strip([-turn(0.1), -turn(0.3), -turn(0.1)])
    squares = np.repeat(np.arange(4), 2)
    halves = np.repeat([0, 1], 4)

    def pieces(threshold):
        return felzenszwalb(mesh, threshold, min_size=0).labels

    # c = .18: limit .09 < .1, nothing joins
    assert metrics.rand_index_error(pieces(0.18), squares) == 0
    # c = .4: limit .2 lets .1 pass; then .1 + .4/4 = .2 stops .3
    assert metrics.rand_index_error(pieces(0.4), halves) == 0
    # c = .82: after the first joins the limit is .1 + .82/4 = .305, all is one
    assert pieces(0.82).max() == 0
    # c = .78: .1 + .78/4 = .295
    assert metrics.rand_index_error(pieces(0.78), halves) == 0


def test_small_pieces_join_across_their_lightest_border():
    mesh = folded_strip([-turn(0.4), -turn(0.3), -turn(0.5)])
    labels = felzenszwalb(mesh, 0.0, min_size=3).labels
    # .3 is taken first: the middle squares become a piece of 4; then the outer ones join it in turn
    assert labels.max() == 0
    labels = felzenszwalb(mesh, 0.0, min_size=2).labels
    assert metrics.rand_index_error(labels, np.repeat(np.arange(4), 2)) == 0


def test_convex_folds_cost_the_square():
    mesh = folded_strip([turn(0.3)])
    # limit c/2: .3² = .09 passes from c = .18, .3 from c = .6
    assert felzenszwalb(mesh, 0.2, min_size=0).n_segments == 1
    assert felzenszwalb(mesh, 0.2, min_size=0, convexity="inward").n_segments == 2
    assert felzenszwalb(mesh, 0.2, min_size=0, convexity="ignored").n_segments == 2
    assert felzenszwalb(mesh, 0.7, min_size=0, convexity="ignored").n_segments == 1
    valley = folded_strip([-turn(0.3)])
    assert felzenszwalb(valley, 0.2, min_size=0).n_segments == 2
    assert felzenszwalb(valley, 0.2, min_size=0, convexity="inward").n_segments == 1


def test_convexity_of_faces_is_the_papers_predicate():
    mesh = Mesh(trimesh.creation.icosphere(2).vertices, trimesh.creation.icosphere(2).faces)
    bumpy = Mesh(mesh.vertices * (1 + 0.2 * np.sin(7 * mesh.vertices[:, :1])), mesh.faces)
    graph = mesh_graph(bumpy, "faces", "outward", SILENT)
    i, j = graph.pairs.T
    seen = np.einsum("ij,ij->i", graph.positions[j] - graph.positions[i], graph.normals[j])
    assert 0 < graph.is_convex.sum() < len(graph.pairs)
    np.testing.assert_array_equal(graph.is_convex, seen > 0)


def test_vertices_can_be_the_items_and_faces_take_the_majority():
    mesh, truth = scene()
    found = felzenszwalb(mesh, 0.5, min_size=20, items="vertices")
    assert found.coverage == 1
    assert metrics.rand_index_error(found, truth) < 0.06
    faces = np.array([[0, 1, 2], [2, 1, 3], [3, 4, 0]])
    np.testing.assert_array_equal(face_labels(faces, np.array([5, 5, 7, 7, 1])), [5, 7, 5])


def test_vertex_normals_are_means_by_area():
    mesh = folded_strip([math.pi / 2])
    normals = vertex_normals(mesh, mesh.faces)
    np.testing.assert_allclose(normals[0], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(normals[1], np.array([1, 0, 2]) / np.sqrt(5), atol=1e-12)  # two faces, one


@pytest.mark.parametrize("items", ["faces", "vertices"])
def test_triangles_with_corners_of_their_own_give_the_same_pieces(items):
    mesh, _ = scene()
    soup = Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * mesh.n_faces).reshape(-1, 3))
    whole, loose = (felzenszwalb(m, 0.5, min_size=20, items=items) for m in (mesh, soup))
    assert metrics.adjusted_rand_index(whole, loose) == pytest.approx(
        1, abs=0.02 if items == "vertices" else 0
    )


# --- measures -------------------------------------------------------------------------------------


def ball(subdivisions=3):
    shape = trimesh.creation.icosphere(subdivisions)
    return np.array(shape.vertices), np.array(shape.vertex_normals)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_smallest_sphere_is_hardly_larger_than_the_smallest(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(11, 3)) * rng.uniform(0.1, 2, 3)
    radius = shape_measures.smallest_sphere_radius(points)
    farthest = np.linalg.norm(points[:, None] - points[None], axis=-1).max()
    assert 0.5 * farthest <= radius * (1 + 1e-12)
    best = min(
        r
        for r, center in _circumspheres(points)
        if (np.linalg.norm(points - center, axis=1) <= r + 1e-9).all()
    )
    assert best <= radius * (1 + 1e-9)
    assert radius <= 1.01 * best


def _circumspheres(points):
    """Every sphere through two, three or four of the points with its center in their flat."""
    from itertools import combinations

    for size in (2, 3, 4):
        for chosen in combinations(range(len(points)), size):
            p = points[list(chosen)]
            edges = p[1:] - p[0]
            step = np.linalg.lstsq(edges, 0.5 * (edges**2).sum(axis=1), rcond=None)[0]
            yield float(np.linalg.norm(step)), p[0] + step


def test_compactness_of_a_ball_is_one_and_of_a_disc_a_quarter():
    points, _ = ball()
    assert shape_measures.compactness(4 * np.pi, points) == pytest.approx(1, rel=0.01)
    angle = np.linspace(0, 2 * np.pi, 50, endpoint=False)
    disc = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    assert shape_measures.compactness(np.pi, disc) == pytest.approx(0.25, rel=0.02)
    assert shape_measures.compactness(0.0, np.zeros((3, 3))) == 0


def test_a_box_is_its_own_mirror_image_and_a_wedge_is_not():
    side = np.linspace(-1, 1, 9)
    x, y = np.meshgrid(side, side)
    faces = [
        np.stack(np.broadcast_arrays(x, y, s), -1).reshape(-1, 3)[:, turn]
        for s in (-1, 1)
        for turn in ([0, 1, 2], [1, 2, 0], [2, 0, 1])
    ]
    normal = [
        np.tile(np.array([0, 0, s])[turn], (81, 1))
        for s in (-1, 1)
        for turn in ([0, 1, 2], [1, 2, 0], [2, 0, 1])
    ]
    points, normals = np.concatenate(faces) * [3, 2, 1], np.concatenate(normal).astype(float)
    inner = (np.abs(points) < [3, 2, 1]).sum(axis=1) == 2  # edges belong to two sides with two normals
    assert shape_measures.symmetry(points[inner], normals[inner]) == pytest.approx(0, abs=1e-12)
    keep = points[:, 0] + 2 * points[:, 2] < 1
    assert shape_measures.symmetry(points[keep], normals[keep]) < -0.1


def test_symmetry_is_its_reading():
    points = np.array([[0.0, 0, 0], [2, 0, 0], [3, 1, 0]])
    normals = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])
    expected = 0.0
    for axis, extent in ((0, 3.0), (1, 1.0)):
        mirror = np.ones(3)
        mirror[axis] = -1
        for p, q in zip(points * mirror, normals * mirror):
            away = np.linalg.norm(points - p, axis=1)
            k = away.argmin()
            expected -= extent / 4 * (away[k] / extent + 0.3 * (1 - q @ normals[k])) / 3
    assert shape_measures.symmetry(points, normals) == pytest.approx(expected)
    assert shape_measures.symmetry(np.zeros((4, 3)), np.zeros((4, 3))) == 0


def test_global_convexity_is_the_mean_depth_below_the_hull():
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    assert shape_measures.global_convexity(corners) == pytest.approx(0, abs=1e-12)
    inside = np.concatenate([corners, [[0, 0, 0], [0.5, 0, 0]]])
    assert shape_measures.global_convexity(inside) == pytest.approx(-(1 + 0.5) / 10)
    assert shape_measures.global_convexity(corners * [1, 1, 0]) == 0
    assert shape_measures.global_convexity(corners[:2]) == 0


def test_local_convexity_is_the_share_of_convex_edges_inside():
    pairs = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]])
    labels = np.array([0, 0, 0, 1, 1, -1])
    is_convex = np.array([True, False, True, True, True])
    share = shape_measures.local_convexity(labels, 3, pairs, is_convex)
    np.testing.assert_array_equal(share, [0.5, 1, 0])
    points, _ = ball()
    mesh = Mesh(points, trimesh.creation.icosphere(3).faces)
    graph = mesh_graph(mesh, "vertices", "outward", SILENT)
    assert graph.is_convex.all()
    assert not mesh_graph(mesh, "vertices", "inward", SILENT).is_convex.any()


def test_neighbours_in_the_tangent_plane_are_their_definition():
    mesh = Mesh(ball(1)[0] * [1, 2, 1], trimesh.creation.icosphere(1).faces)
    graph = mesh_graph(mesh, "vertices", "outward", SILENT)
    first, second, slot = shape_measures.tangent_neighbours(graph.positions, graph.normals, graph.pairs)
    near = np.eye(mesh.n_vertices, dtype=int)
    near[graph.pairs[:, 0], graph.pairs[:, 1]] = near[graph.pairs[:, 1], graph.pairs[:, 0]] = 1
    expected = set(zip(*np.nonzero((near @ near > 0) & ~np.eye(mesh.n_vertices, dtype=bool))))
    assert set(zip(first.tolist(), second.tolist())) == {(int(i), int(j)) for i, j in expected}
    assert 0 <= slot.min() <= slot.max() < 8
    for i in range(mesh.n_vertices):  # angles between neighbours, whatever the tangent that counts as 0
        mine = np.flatnonzero(first == i)
        step = graph.positions[second[mine]] - graph.positions[i]
        n = graph.normals[i]
        flat = step - np.outer(step @ n, n)
        angle = np.arctan2(np.cross(flat[0], flat) @ n, flat @ flat[0]) / (np.pi / 4)
        difference = (slot[mine] - slot[mine[0]] - angle) % 8
        assert (np.minimum(difference, 8 - difference) <= 1 + 1e-9).all()


def test_smoothness_is_the_mean_entropy_with_every_slot_started_at_one():
    first = np.array([0, 0, 0, 1, 2, 3])
    second = np.array([1, 2, 3, 0, 0, 0])
    slot = np.array([0, 0, 5, 1, 2, 3])
    labels = np.array([0, 0, 0, 1])

    def entropy(counts):
        p = np.array(counts) / np.sum(counts)
        return -(p * np.log(p)).sum()

    value = shape_measures.smoothness(labels, 3, (first, second, slot))
    of_0 = (entropy([3, 1, 1, 1, 1, 1, 1, 1]) + 2 * entropy([2, 1, 1, 1, 1, 1, 1, 1])) / 3
    np.testing.assert_allclose(value, [of_0, np.log(8), 0])


def whole(mesh, **options):
    return objectness(mesh, np.arange(mesh.n_faces), **options)


def test_a_ball_is_the_most_compact_symmetric_and_convex_thing():
    ball = whole(shapes.icosphere(4))
    assert ball["compactness"] == pytest.approx(1, rel=0.02)
    assert ball["symmetry"] == pytest.approx(0, abs=0.03)
    assert ball["local_convexity"] == 1
    assert ball["global_convexity"] == pytest.approx(0, abs=1e-9)
    assert whole(shapes.icosphere(4), convexity="inward")["local_convexity"] == 0


def test_a_block_has_the_compactness_of_its_sides():
    a, b, c = 1.0, 2.0, 3.0
    block = whole(shapes.box(6, size=(a, b, c)))
    diagonal = np.sqrt(a * a + b * b + c * c)
    assert block["compactness"] == pytest.approx(
        2 * (a * b + b * c + c * a) / (np.pi * diagonal**2), rel=0.02
    )
    assert block["symmetry"] == pytest.approx(0, abs=0.02)
    assert block["global_convexity"] == pytest.approx(0, abs=1e-9)


def test_a_square_is_flat_symmetric_and_has_no_convex_edge():
    square = whole(shapes.grid_square(8))
    assert square["compactness"] == pytest.approx(1 / (4 * np.pi * 0.5), rel=0.02)
    assert square["global_convexity"] == 0
    assert square["local_convexity"] == 0
    assert square["symmetry"] == pytest.approx(0, abs=1e-9)


def test_a_room_from_inside_is_concave_and_a_dent_lies_under_the_hull():
    box = shapes.box(4)
    inside = Mesh(box.vertices, box.faces[:, ::-1])
    assert whole(inside)["local_convexity"] == 0
    corner = Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 2, 3], [0, 3, 1]]
    )  # hull: the tetrahedron, on which all four lie
    assert whole(corner)["global_convexity"] == pytest.approx(0, abs=1e-12)
    dent = Mesh(
        [*corner.vertices[1:], [0, 0, 0], [0.2, 0.2, 0.2]], [[0, 1, 4], [1, 2, 4], [2, 0, 4], [0, 1, 3]]
    )
    assert whole(dent)["global_convexity"] == pytest.approx(-0.2 / 5)  # one of five, .2 from a side


def test_in_a_lone_triangle_each_corner_sees_two_directions():
    entropy = np.log(10) - 2 * 2 * np.log(2) / 10  # eight slots that start at 1, two of them with one more
    triangle = Mesh([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]], [[0, 1, 2]])
    assert whole(triangle)["smoothness"] == pytest.approx(entropy)


def test_recurrence_is_the_distance_to_what_is_alike():
    chair, copy = (
        shapes.box(3, size=(0.5, 0.6, 1.0)),
        shapes.moved(shapes.box(3, size=(0.5, 0.6, 1.0)), seed=4),
    )
    other = shapes.box(3, size=(2.0, 3.0, 0.1))
    every = lambda mesh: (mesh, np.arange(mesh.n_faces))  # noqa: E731
    assert np.isnan(whole(chair)["recurrence"])
    assert whole(chair, others=[every(copy)])["recurrence"] == pytest.approx(0, abs=1e-6)
    assert whole(chair, others=[every(other)])["recurrence"] < -0.1
    near = whole(chair, others=[every(copy)] * 10 + [every(other)])["recurrence"]
    assert near == pytest.approx(0, abs=1e-6)  # of eleven the ten most similar count
    flat = np.array([[-1.0, 0, 0], [1, 0, 0]])
    assert shape_measures.recurrence(flat, [flat * 2]) == pytest.approx(-1)


def test_a_segment_is_measured_by_itself_whatever_lies_around_it():
    ball = shapes.icosphere(3)
    scene = shapes.joined(ball, shapes.grid_square(5), gap=1.0)
    mask = np.arange(scene.n_faces) < ball.n_faces
    alone, there = whole(ball), objectness(scene, mask)
    for name in alone:
        np.testing.assert_allclose(there[name], alone[name], atol=1e-7, err_msg=name)
    assert objectness(scene, np.flatnonzero(mask))["symmetry"] == there["symmetry"]


@pytest.mark.parametrize(
    ("faces", "options", "error", "message"),
    [
        ([], {}, ValueError, "faces is empty"),
        ([0, 99], {}, ValueError, r"faces must lie in 0\.\.31, got 0\.\.99"),
        ([0.5], {}, TypeError, "faces must be face numbers or a mask"),
        (np.ones(3, dtype=bool), {}, ValueError, r"an entry a face of the mesh: \(32,\)"),
        ([0], {"others": [3]}, TypeError, r"others\[0\] must be a pair \(mesh, faces\)"),
        ([0], {"convexity": "up"}, ValueError, "convexity must be"),
    ],
)
def test_faces_that_are_none_are_refused(faces, options, error, message):
    with pytest.raises(error, match=message):
        objectness(shapes.grid_square(4), faces, **options)


def test_objectness_is_the_mean_of_standardised_measures():
    measures = np.array([[1.0, 10, 5], [2, 20, 5], [3, 60, 5]])
    standard = (measures - measures.mean(axis=0))[:, :2] / measures.std(axis=0)[:2]
    np.testing.assert_allclose(shape_measures.mean_objectness(measures), standard.sum(axis=1) / 3)


# --- Karpathy -------------------------------------------------------------------------------------


def test_bag_holds_shapes_of_its_pieces_and_their_overlaps():
    mesh, _ = scene()
    graph = mesh_graph(mesh, "vertices", "outward", SILENT)
    rng = np.random.default_rng(0)
    layers = [rng.integers(0, 4, mesh.n_vertices), rng.integers(0, 3, mesh.n_vertices)]
    layers[0][:5] = 4
    bag = _fill_bag(graph, layers, 6, mesh, SILENT)
    assert len(bag) == 7  # the piece of 5 is too small
    members = [np.flatnonzero(bag.layers[k >= 4] == k) for k in range(7)]
    shared = _overlaps(bag, SILENT).toarray()
    for k, mine in enumerate(members):
        points = mesh.vertices[mine]
        assert bag.shapes.n_members[k] == len(mine)
        np.testing.assert_allclose(bag.shapes.center[k], points.mean(axis=0))
        values = np.linalg.eigvalsh(np.cov(points.T))[::-1]
        np.testing.assert_allclose(bag.shapes.spread[k], values / values[0])
        along = (points - points.mean(axis=0)) @ bag.shapes.axes[k]
        np.testing.assert_allclose(bag.shapes.extents[k], np.ptp(along, axis=0))
        assert set(bag.samples[k]) <= set(mine)
        assert len(bag.samples[k]) == min(400, len(mine))
        for other in range(7):
            if (other >= 4) != (k >= 4):
                both, either = np.intersect1d(mine, members[other]), np.union1d(mine, members[other])
                assert shared[k, other] == pytest.approx(len(both) / len(either))
            else:
                assert shared[k, other] == 0
    assert bag.shapes.area[:4].sum() < bag.shapes.area[4:].sum() == pytest.approx(mesh.face_areas.sum())


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10_000), overlap=st.sampled_from([0.0, 0.3, 0.5, 1.0]))
def test_suppression_keeps_what_no_better_survivor_covers(seed, overlap):
    rng = np.random.default_rng(seed)
    iou = np.triu(rng.choice([0, 0, 0.2, 0.4, 0.6, 1.0], (8, 8)), 1)
    iou = iou + iou.T
    score = rng.permutation(8).astype(float)
    score[rng.random(8) < 0.2] = np.nan
    ranking = _suppress(score, np.ones(8), sparse.csr_array(iou), overlap)
    expected = []
    for k in sorted(np.flatnonzero(~np.isnan(score)), key=lambda k: -score[k]):
        if not any(iou[k, better] > overlap or iou[k, better] == 1 for better in expected):
            expected.append(k)
    assert ranking.tolist() == expected


def test_karpathy_finds_the_balls_on_the_floor():
    mesh, truth = scene()
    found = karpathy(mesh, min_size=20)
    assert found.coverage == 1
    assert metrics.rand_index_error(found, truth) < 0.06
    assert found.report["n_candidates"] >= found.report["n_accepted"] >= found.report["n_objects"] >= 3
    assert len(found.report["objectness"]) == found.n_segments
    for ball in (1, 2):
        assert len(np.unique(found.labels[truth == ball])) == 1


def test_hard_thresholds_reject_the_floor_only_when_switched_on():
    mesh, truth = scene()
    plain = karpathy(mesh, min_size=20, background="unlabeled")
    strict = karpathy(mesh, min_size=20, background="unlabeled", reject=("size", "thin", "flat"))
    assert np.mean(plain.labels[truth == 0] >= 0) > 0.99
    assert np.mean(strict.labels[truth == 0] >= 0) < 0.1
    assert np.mean(strict.labels[truth == 2] >= 0) > 0.9
    assert strict.report["n_accepted"] < plain.report["n_accepted"]


def test_background_is_one_segment_or_its_pieces_or_unlabeled():
    mesh, _ = scene()
    options = {"min_size": 20, "reject": ("size",), "n_objects": 2}
    one, pieces, unlabeled = (karpathy(mesh, **options, background=b) for b in ("one", "pieces", "unlabeled"))
    left = unlabeled.labels < 0
    assert left[-1]
    assert 0.3 < left.mean() < 1
    assert len(np.unique(one.labels[left])) == 1
    assert len(np.unique(pieces.labels[left])) >= 2
    assert pieces.labels[-1] not in pieces.labels[:-1]
    assert unlabeled.n_segments == 2
    assert np.isnan(one.report["objectness"]).sum() == 1
    assert metrics.adjusted_rand_index(one.labels[~left], unlabeled.labels[~left]) == pytest.approx(1)


def test_a_scene_without_any_candidate_is_all_background():
    mesh, _ = scene()
    nothing = karpathy(mesh, min_size=10**6, background="unlabeled")
    assert nothing.coverage == 0
    assert karpathy(mesh, thresholds=[1.0], min_size=10**6).n_segments == 1


def test_over_segmentations_are_felzenszwalbs_at_ten_thresholds():
    mesh, _ = scene()
    found = karpathy_oversegmentations(mesh, min_size=20)
    assert tuple(found) == THRESHOLDS
    assert len(THRESHOLDS) == 10
    for threshold in (THRESHOLDS[0], THRESHOLDS[-1]):
        alone = felzenszwalb(mesh, threshold, min_size=20, items="vertices")
        np.testing.assert_array_equal(found[threshold].labels, alone.labels)


def test_moving_the_scene_changes_nothing():
    mesh, _ = scene()
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    moved = Mesh(mesh.vertices @ quarter.T + [4, -2, 8], mesh.faces)
    for method in (lambda m: felzenszwalb(m, 1.0, min_size=20), lambda m: karpathy(m, min_size=20)):
        assert metrics.adjusted_rand_index(method(mesh), method(moved)) > 0.98


# --- progress, cancel, refusals -------------------------------------------------------------------


@pytest.mark.parametrize("method", [felzenszwalb, karpathy, karpathy_oversegmentations])
def test_progress_runs_from_0_to_1_in_each_stage(method):
    mesh, _ = scene()
    seen = {}
    method(mesh, min_size=20, progress=lambda stage, fraction: seen.setdefault(stage, []).append(fraction))
    assert list(seen)[:2] == ["graph", "segment"]
    for fractions in seen.values():
        assert fractions[0] == 0
        assert fractions[-1] == 1
        assert fractions == sorted(fractions)


@pytest.mark.parametrize("method", [felzenszwalb, karpathy, karpathy_oversegmentations])
def test_cancel_stops_at_any_stage(method):
    mesh, _ = scene()
    stages = []
    method(mesh, min_size=20, progress=lambda stage, fraction: stages.append(stage))
    for wanted in dict.fromkeys(stages):
        cancel = threading.Event()

        def watch(stage, fraction, wanted=wanted, cancel=cancel):
            if stage == wanted:
                cancel.set()

        with pytest.raises(Cancelled, match=wanted):
            method(mesh, min_size=20, progress=watch, cancel=cancel)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"mesh": "room.ply"}, TypeError, r"mesh must be a scenewidget\.Mesh, got str"),
        ({"min_size": -1}, ValueError, "min_size must be at least 0, got -1"),
        ({"min_size": 0.5}, TypeError, "min_size must be a whole number of items, got float"),
        ({"convexity": "up"}, ValueError, "convexity must be 'outward', 'inward' or 'ignored', got 'up'"),
    ],
)
def test_bad_options_are_refused_by_every_baseline(arguments, error, message):
    given = {"mesh": folded_strip([0.1])} | arguments
    for method in (felzenszwalb, karpathy, karpathy_oversegmentations):
        with pytest.raises(error, match=message):
            method(**given)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"threshold": -1}, ValueError, "threshold must be finite and at least 0, got -1"),
        ({"threshold": math.nan}, ValueError, "threshold must be finite and at least 0, got nan"),
        ({"threshold": "1"}, TypeError, "threshold must be a number, got str"),
        ({"items": "edges"}, ValueError, "items must be 'faces' or 'vertices', got 'edges'"),
    ],
)
def test_felzenszwalb_refuses_bad_input(arguments, error, message):
    with pytest.raises(error, match=message):
        felzenszwalb(folded_strip([0.1]), **arguments)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"thresholds": ()}, ValueError, "thresholds is empty"),
        ({"thresholds": (1.0, 1.0)}, ValueError, "thresholds must all differ"),
        ({"thresholds": (1.0, -1.0)}, ValueError, r"thresholds\[1\] must be finite and at least 0"),
        ({"thresholds": 1.0}, TypeError, "thresholds must be numbers, such as"),
        ({"reject": "size"}, TypeError, "reject must be a collection of names"),
        ({"reject": ("small",)}, ValueError, "reject may hold 'size', 'thin' and 'flat', got 'small'"),
        ({"overlap": 2}, ValueError, r"overlap must be a number in \[0, 1\], got 2"),
        ({"n_objects": 0}, ValueError, "n_objects must be a whole number of at least 1 or None, got 0"),
        ({"background": "none"}, ValueError, "background must be 'one', 'pieces' or 'unlabeled', got 'none'"),
    ],
)
def test_karpathy_refuses_bad_input(arguments, error, message):
    with pytest.raises(error, match=message):
        karpathy(folded_strip([0.1]), **arguments)
