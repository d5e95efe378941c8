"""Shares of k, members with seeds of their own, and merging over planes on hand-made scenes."""

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st

from scenewidget.engine.consensus import co_association
from scenewidget.engine.distances import all_pairs, edge_costs, weight_graph
from scenewidget.engine.ensemble import (
    felzenszwalb_members,
    given_members,
    k_medoids_members,
    merge_flat,
)
from scenewidget.engine.items import simplified_items
from scenewidget.engine.kmedoids import INITS
from scenewidget.engine.mesh import Mesh, face_adjacency
from scenewidget.engine.monitor import Cancelled, Monitor
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import segment


def items_of(mesh):
    return simplified_items(mesh, face_adjacency(mesh))


def distances_of(items):
    weights = edge_costs(items.normals, items.pairs) + 0.01
    return [all_pairs(weight_graph(items.n, items.pairs, weights))]


def members(items, **options):
    n = int(items.component.max()) + 1
    options = {"k_range": (6, 10), "n_runs": 4, "seed": 0} | options
    share = np.bincount(items.component) / items.n if n > 1 else np.ones(1)
    return k_medoids_members(items, distances_of(items), share, **options)


TWO_BOXES = shapes.joined(shapes.box(3), shapes.box(4), gap=3.0)


def test_a_cluster_never_spans_two_components():
    items = items_of(TWO_BOXES)
    for keys in members(items, n_runs=3).T:
        assert keys.min() >= 0
        for label in np.unique(keys):
            assert len(set(items.component[keys == label].tolist())) == 1


def test_k_lies_in_its_range():
    items = items_of(shapes.box(5))
    keys = members(items, k_range=(5, 8), n_runs=30)
    counts = {len(np.unique(column)) for column in keys.T}
    assert counts == {5, 6, 7, 8}


@pytest.mark.parametrize("init", INITS)
def test_more_runs_extend_fewer_and_threads_do_not_matter(init):
    items = items_of(TWO_BOXES)
    few = members(items, n_runs=3, init=init, n_threads=1)
    many = members(items, n_runs=7, init=init, n_threads=4)
    np.testing.assert_array_equal(many[:, :3], few)
    assert not np.array_equal(members(items, n_runs=3, init="random", seed=1), members(items, n_runs=3))


def test_runs_take_the_matrices_in_turn():
    items = items_of(shapes.box(4))
    D = distances_of(items)[0]
    other = np.ascontiguousarray(D.max() - D + np.float32(1))
    np.fill_diagonal(other, 0)
    share, options = np.ones(1), {"k_range": (5, 5), "n_runs": 4}
    both = k_medoids_members(items, [D, other], share, **options)
    first, second = (k_medoids_members(items, [M], share, **options) for M in (D, other))
    np.testing.assert_array_equal(both[:, ::2], first[:, ::2])
    np.testing.assert_array_equal(both[:, 1::2], second[:, 1::2])


def test_graph_members_cut_at_creases_and_extend():
    items = items_of(shapes.room(12)[0])
    few = felzenszwalb_members(items, n_runs=2, n_threads=1)
    many = felzenszwalb_members(items, n_runs=6, n_threads=3)
    np.testing.assert_array_equal(many[:, :2], few)
    assert len(np.unique(many[:, 0])) > 1


def test_cancel_is_heard_between_runs():
    class Later:
        def __init__(self):
            self.asked = 0

        def is_set(self):
            self.asked += 1
            return self.asked > 3

    with pytest.raises(Cancelled):
        members(items_of(shapes.box(3)), n_runs=50, monitor=Monitor(cancel=Later()))


# --- merging --------------------------------------------------------------------------------------


def strips(mesh, axis=0, n=4):
    """Labels in n strips across the mesh."""
    place = mesh.face_centroids[:, axis]
    return np.minimum((n * (place - place.min()) / (np.ptp(place) + 1e-9)).astype(np.int32), n - 1)


def together(labels):
    return labels[:, None] == labels


def test_pieces_of_one_plane_merge():
    items = items_of(shapes.grid_square(8))
    assert merge_flat(items, strips(items.mesh)).tolist() == [0] * items.n


def test_the_sides_of_a_box_stay_apart_and_their_pieces_merge():
    mesh = shapes.box(8)
    items = items_of(mesh)
    side = shapes._side(mesh)
    labels = 2 * side + (mesh.face_centroids @ [0.3, 0.5, 0.7] > 0)
    _, labels = np.unique(labels, return_inverse=True)
    np.testing.assert_array_equal(together(merge_flat(items, labels.astype(np.int32))), together(side))


def bend(angle, n=6):
    """Two square sheets that meet at an angle (radians) at x = 0, and which one a face is on."""
    sheet = shapes.grid_square(n)
    right = sheet.vertices[:, 0]
    up = np.column_stack([np.cos(angle) * right, sheet.vertices[:, 1], np.sin(angle) * right])
    left = Mesh(sheet.vertices * [-1, 1, 1], sheet.faces[:, ::-1])
    return shapes.joined(left, Mesh(up, sheet.faces)), np.repeat([0, 1], sheet.n_faces).astype(np.int32)


@pytest.mark.parametrize(("degrees", "n_left"), [(0, 1), (7, 1), (9, 2), (90, 2)])
def test_the_angle_decides_at_99_percent(degrees, n_left):
    mesh, labels = bend(np.radians(degrees))  # cos 8.1° = .99
    assert merge_flat(items_of(mesh), labels).max() + 1 == n_left


def test_parallel_pieces_that_do_not_touch_stay_apart():
    mesh = shapes.joined(shapes.grid_square(4), shapes.grid_square(4), gap=2.0)
    labels = np.repeat([0, 1], 32).astype(np.int32)
    assert merge_flat(items_of(mesh), labels).tolist() == labels.tolist()


def test_round_pieces_do_not_merge_and_thresholds_are_options():
    items = items_of(shapes.icosphere(3))
    labels = (items.mesh.face_centroids[:, 2] > 0).astype(np.int32)
    assert merge_flat(items, labels).max() == 1
    assert merge_flat(items, labels, flatness=1.1, normal=-1.0, seam=-1.0).max() == 0


def test_a_flat_chain_merges_round_after_round():
    items = items_of(shapes.grid_square(16))
    assert merge_flat(items, strips(items.mesh, n=16)).max() == 0


def test_unlabeled_items_stay_so_and_one_segment_is_left_alone():
    items = items_of(shapes.grid_square(4))
    labels = np.zeros(items.n, dtype=np.int32)
    labels[:3] = -1
    np.testing.assert_array_equal(merge_flat(items, labels), labels)
    labels = strips(items.mesh)
    labels[:3] = -1
    assert (merge_flat(items, labels)[:3] == -1).all()


def test_nothing_to_merge_on_single_faces():
    items = items_of(shapes.triangle())
    assert merge_flat(items, np.zeros(1, np.int32)).tolist() == [0]


@given(st.integers(0, 99))
def test_merging_only_joins_and_twice_is_once(seed):
    items = items_of(shapes.box(4))
    labels = np.random.default_rng(seed).integers(0, 12, items.n).astype(np.int32)
    _, labels = np.unique(labels, return_inverse=True)
    once = merge_flat(items, labels.astype(np.int32))
    assert (together(labels) <= together(once)).all()
    np.testing.assert_array_equal(merge_flat(items, once), once)


# --- members from elsewhere -----------------------------------------------------------------------


def test_members_from_elsewhere_are_heard_and_unknown_ones_say_nothing():
    mesh, parts = shapes.room(8, noise=0.003)
    params = Params(n_graph_runs=8, n_runs=3)
    alone = segment(mesh, params)
    silent = segment(mesh, params, members=[np.full(mesh.n_faces, -1)])
    np.testing.assert_array_equal(alone.labels, silent.labels)
    names = np.random.default_rng(0).permutation(100)
    told, renamed = (segment(mesh, params, members=[m] * 20) for m in (parts, names[parts]))
    np.testing.assert_array_equal(told.labels, renamed.labels)
    partial = segment(mesh, params, members=[np.where(parts < 6, -1, parts)] * 20)
    np.testing.assert_array_equal(partial.labels[parts < 6] == 0, alone.labels[parts < 6] == 0)


ITEMS = items_of(shapes.box(2))  # 48 faces, each an item
OWN = felzenszwalb_members(ITEMS, n_runs=8, seed=1)
labelings = st.lists(st.integers(-1, 3), min_size=ITEMS.n, max_size=ITEMS.n).map(np.array)


def joined_by(members):
    keys = [given_members(ITEMS, members, OWN.shape[1])] if members else []
    return co_association(np.concatenate([OWN, *keys], axis=1), ITEMS.areas)


@given(st.lists(labelings, min_size=1, max_size=4), st.randoms(use_true_random=False), st.data())
def test_order_and_silence_of_members_from_elsewhere_change_nothing(members, random, data):
    told = joined_by(members)
    others = members + [np.full(ITEMS.n, -1)] * data.draw(st.integers(0, 2))
    random.shuffle(others)
    again = joined_by(others)
    np.testing.assert_array_equal(told.base, again.base)
    np.testing.assert_array_equal(told.C, again.C)


@given(st.lists(labelings, min_size=1, max_size=4))
def test_pairs_that_a_member_does_not_see_together_are_unknown_to_it(members):
    told = joined_by(members)
    runs = np.concatenate([OWN.T, members])  # an eighth of eight runs: each counts as one
    together = [(r[:, None] == r) & (r[:, None] >= 0) for r in runs]
    seen = [(r[:, None] >= 0) & (r >= 0) for r in runs]
    expected = np.sum(together, axis=0) / np.sum(seen, axis=0)
    is_apart = told.base[:, None] != told.base  # within a base segment all runs agree
    np.testing.assert_allclose(told.C[told.base][:, told.base][is_apart], expected[is_apart])


def test_members_that_fit_no_face_are_refused():
    mesh = shapes.box(3)
    with pytest.raises(ValueError, match=r"members\[0\] must have a label a face, \(108,\), got \(5,\)"):
        segment(mesh, members=[np.zeros(5, int)])
    with pytest.raises(TypeError, match=r"members\[1\] must be whole numbers"):
        segment(mesh, members=[np.zeros(108, int), np.zeros(108)])
