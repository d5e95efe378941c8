"""Dihedral-based partitions against a hand-worked example and a literal transcription of Algorithm 1."""

import threading
from collections import defaultdict

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st
from strategies import clean_meshes, messy_meshes

from scenewidget.engine import dihedral
from scenewidget.engine.dihedral import _place_in_slots, dihedral_partition
from scenewidget.engine.mesh import Mesh, connected_components, face_adjacency
from scenewidget.engine.monitor import Cancelled, Monitor


def algorithm_1(mesh, n_slots, order="index"):
    """The lines of the thesis' Algorithm 1, with the decisions named in `dihedral_partition`."""
    adjacent = defaultdict(list)
    for i, j in face_adjacency(mesh):
        adjacent[i].append(j)
        adjacent[j].append(i)
    N = mesh.face_normals
    slot_interval = 2 / n_slots
    eps = 1e-9 * slot_interval

    def dot(s, t):
        return min(max(float(N[s] @ N[t]), -1.0), 1.0)

    P = [-1] * mesh.n_faces
    C = 0
    seeds = sorted(range(mesh.n_faces), key=lambda f: -mesh.face_areas[f] if order == "area" else f)
    for f in seeds:
        if P[f] >= 0:
            continue
        slots = [0] * n_slots
        Q, entered = [f], {f}
        angle_found = False
        while not angle_found and Q:
            Q_next = []
            for q in Q:
                for a in adjacent[q]:
                    slots[min(int((dot(q, a) + 1 + eps) / slot_interval), n_slots - 1)] += 1
                    if a not in entered:
                        entered.add(a)
                        Q_next.append(a)
            if slots.count(max(slots)) == 1 and max(slots) > 0:
                U = slots.index(max(slots))
                limits_min = -1 + U * slot_interval - slot_interval / 2 - eps
                limits_max = -1 + (U + 1) * slot_interval + slot_interval / 2 + eps
                angle_found = True
            Q = Q_next
        P[f] = C
        T = [f] if angle_found else []
        while T:
            t = T.pop(0)
            for a in adjacent[t]:
                if P[a] < 0 and limits_min <= dot(t, a) <= limits_max:
                    P[a] = C
                    T.append(a)
        C += 1
    return P


# --- closed forms ---------------------------------------------------------------------------------


def test_a_hand_worked_example():
    # Face 0 in the middle of three others: 1 and 2 folded by 90°, 3 by 60°. Dot products 0, 0, 1/2; with four
    # slots of width 1/2 these are slot 2 = [0, .5) twice and slot 3 = [.5, 1] once. Slot 2 is decisive; its
    # range, widened by 1/4, is [-.25, .75]: it holds all three neighbours, so one partition.
    # With 64 slots the range is [-1/64, 1/32 + 1/64]: 1 and 2 join, 3 is left; seen from 3, the
    # only dot product is 1/2, but face 0 has its label already, so 3 stays alone.
    half, tall = 0.5, np.sqrt(3) / 2
    corners = np.array([[0, 0, 0], [1, 0, 0], [half, tall, 0]])
    centre = corners.mean(axis=0)
    faces, tips = [(0, 1, 2)], []
    for i, fold in enumerate([np.pi / 2, np.pi / 2, np.pi / 3]):
        a, b = corners[i], corners[(i + 1) % 3]
        out = (a + b) / 2 - centre
        tips.append((a + b) / 2 + tall * (np.cos(fold) * out / np.linalg.norm(out) + [0, 0, np.sin(fold)]))
        faces.append(((i + 1) % 3, i, 3 + i))
    mesh = Mesh([*corners, *tips], faces)
    np.testing.assert_allclose(mesh.face_normals[1:] @ mesh.face_normals[0], [0, 0, 0.5], atol=1e-15)
    np.testing.assert_array_equal(dihedral_partition(mesh, 4), [0, 0, 0, 0])
    np.testing.assert_array_equal(dihedral_partition(mesh, 64), [0, 0, 0, 1])


def test_slots_are_equal_steps_of_the_dot_product_or_of_the_angle():
    angles = np.radians([0, 45, 60, 90, 120, 180])
    dots = np.cos(angles)
    np.testing.assert_allclose(_place_in_slots(dots, 8, "linear"), 4 * (dots + 1))
    np.testing.assert_allclose(_place_in_slots(dots, 18, "angle"), [18, 13.5, 12, 9, 6, 0], atol=1e-12)


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=200), st.integers(2, 12))
def test_slots_by_counts_hold_as_many_each(dots, n_slots):
    dots = np.array(dots)
    place = _place_in_slots(dots, n_slots, "counts")
    assert ((place >= 0) & (place <= n_slots)).all()
    order = np.argsort(dots)
    assert (np.diff(place[order]) >= 0).all()
    if len(np.unique(np.rint(1e8 * dots))) == len(dots):  # all differ: a slot has n / D of them, or one more
        held = np.bincount(np.minimum(place.astype(int), n_slots - 1), minlength=n_slots)
        assert held.max() - held.min() <= 1


def test_equal_dot_products_share_a_slot_whatever_rounding_made_of_them():
    dots = np.array([1.0, 1.0 - 1e-16, 1.0 - 2e-16, 0.0, 1e-17, -1e-17])
    place = _place_in_slots(dots, 64, "counts")
    assert len(np.unique(place)) == 2


def test_a_finer_look_at_flat_angles_parts_what_equal_steps_of_the_dot_product_join():
    # Strips of a polygon with folds of 5°, then a fold of 12°: dot products .9962 and .9781 both lie in the
    # last of 64 slots, [.96875, 1]. A slot of angle is 2.8° wide: 5° lies in [2.8°, 5.6°], 12° doesn't.
    folds = np.radians([5, 5, 5, 12, 5, 5, 5])
    heading = np.concatenate([[0], np.cumsum(folds)])
    path = np.concatenate([[[0, 0]], np.cumsum(np.stack([np.cos(heading), np.sin(heading)], 1), axis=0)])
    low = np.column_stack([path, np.zeros(len(path))])
    vertices, faces = np.concatenate([low, low + np.array([0, 0, 9])]), []
    n = len(path)
    for i in range(n - 1):
        faces += [(i, i + 1, n + i + 1), (i, n + i + 1, n + i)]
    mesh = Mesh(vertices, faces)
    assert dihedral_partition(mesh, order="index").max() == 0
    assert dihedral_partition(mesh, mapping="angle")[:8].tolist() != dihedral_partition(mesh)[:8].tolist()
    assert dihedral_partition(mesh, mapping="angle").max() > 0


def test_ties_are_broken_by_further_rings():
    # Three panels of two triangles; faces in a chain 1-0-3-2-5-4, flat and folded in turn.
    # Seed 0 sees flat and fold once each; in the second ring face 1 adds flat, face 3 one of each: 3 to 2.
    # Seed 2 sees one of each, then 3 and 3, and 5 to 4 in the third ring, where the chain ends at 4.
    assert dihedral_partition(shapes.accordion(3)).tolist() == [0, 0, 1, 1, 2, 2]


def test_flat_sides_of_a_box_are_one_partition_each():
    partition = dihedral_partition(shapes.box(4))
    np.testing.assert_array_equal(partition, np.repeat(np.arange(6), 32))


def test_a_plane_is_one_partition_and_so_is_a_sphere():
    assert dihedral_partition(shapes.grid_square(5)).max() == 0
    assert dihedral_partition(shapes.icosphere(3)).max() == 0


def test_a_single_face_and_unconnected_faces_are_partitions_of_their_own():
    assert dihedral_partition(shapes.triangle()).tolist() == [0]
    assert dihedral_partition(shapes.joined(*[shapes.triangle()] * 3, gap=9.0)).tolist() == [0, 1, 2]


def test_one_slot_holds_everything():
    mesh = shapes.joined(shapes.blob(1), shapes.box(1), gap=9.0)
    count, component = connected_components(mesh.n_faces, face_adjacency(mesh))
    assert count == 2
    np.testing.assert_array_equal(dihedral_partition(mesh, 1), component)


def test_a_component_without_a_decisive_ring_leaves_its_seed_alone():
    # a centre with three neighbours at three angles: 1, 1, 1 in its first ring, 2, 2, 2 in all
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    tips = [[0.5, -1, 0.3], [1, 1, 1.0], [-0.5, 0.5, 3.0]]
    mesh = Mesh([*corners, *tips], [(0, 1, 2), (1, 0, 3), (2, 1, 4), (0, 2, 5)])
    assert dihedral_partition(mesh).tolist() == [0, 1, 2, 3]


def test_faces_without_area_neither_cut_nor_count():
    square = shapes.grid_square(4)
    corner = square.faces[5]
    seam = [[corner[0], corner[1], square.n_vertices], [square.n_vertices, corner[1], corner[0]]]
    middle = square.vertices[corner[:2]].mean(axis=0)
    mesh = Mesh([*square.vertices, middle], [*square.faces, *seam])
    assert dihedral_partition(mesh).max() == 0


def test_a_mesh_without_area_is_one_partition_a_component():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [[0, 1, 2], [1, 2, 3]])
    assert dihedral_partition(mesh).tolist() == [0, 0]


# --- oracle ---------------------------------------------------------------------------------------


@given(clean_meshes(), st.sampled_from([1, 2, 3, 7, 64, 1000]), st.sampled_from(["index", "area"]))
def test_partition_follows_algorithm_1_to_the_letter(mesh, n_slots, order):
    assert dihedral_partition(mesh, n_slots, order=order).tolist() == algorithm_1(mesh, n_slots, order)


@given(messy_meshes(), st.sampled_from([2, 5, 64]))
def test_partition_follows_algorithm_1_on_any_triangles_with_area(mesh, n_slots):
    mesh = Mesh(mesh.vertices, mesh.faces[mesh.face_areas > 0])
    assert dihedral_partition(mesh, n_slots).tolist() == algorithm_1(mesh, n_slots)


def test_partition_follows_algorithm_1_on_a_folding_screen():
    mesh = shapes.accordion(40)
    assert dihedral_partition(mesh).tolist() == algorithm_1(mesh, 64)


# --- properties -----------------------------------------------------------------------------------


@given(messy_meshes())
def test_partitions_are_connected_and_numbered_by_first_face(mesh):
    partition = dihedral_partition(mesh)
    assert partition.dtype == np.int32
    _, first = np.unique(partition, return_index=True)
    assert (np.diff(first) > 0).all()
    assert partition[first].tolist() == list(range(len(first)))
    pairs = face_adjacency(mesh)
    inside = pairs[partition[pairs[:, 0]] == partition[pairs[:, 1]]]
    assert connected_components(mesh.n_faces, inside)[0] == len(first)


@given(clean_meshes(), st.integers(0, 99))
def test_moving_a_mesh_changes_no_partition(mesh, seed):
    moved = shapes.moved(mesh, seed=seed, scale=3.0)
    np.testing.assert_array_equal(dihedral_partition(moved), dihedral_partition(mesh))


@given(st.integers(0, 99))
def test_turning_a_box_changes_no_partition(seed):
    box = shapes.box(2, size=(1.0, 2.0, 3.0))
    np.testing.assert_array_equal(dihedral_partition(shapes.moved(box, seed=seed)), dihedral_partition(box))


@given(st.integers(0, 99), st.randoms(use_true_random=False))
def test_order_by_area_does_not_depend_on_the_order_of_faces(seed, random):
    mesh = shapes.blob(1, seed=seed)
    order = np.array(random.sample(range(mesh.n_faces), mesh.n_faces))
    shuffled = shapes.with_faces_in_order(mesh, order)
    expected = dihedral_partition(mesh, order="area")[order]
    np.testing.assert_array_equal(dihedral_partition(shuffled, order="area"), expected)


@given(messy_meshes(), st.randoms(use_true_random=False))
def test_numbers_of_vertices_do_not_matter(mesh, random):
    order = np.array(random.sample(range(mesh.n_vertices), mesh.n_vertices))
    shuffled = shapes.with_vertices_in_order(mesh, order)
    np.testing.assert_array_equal(dihedral_partition(shuffled), dihedral_partition(mesh))


# --- bounds, cancel, bad arguments ----------------------------------------------------------------


def test_lasting_ties_are_left_undecided():
    n = 2 * dihedral.MAX_RING_FACES
    partition = dihedral_partition(shapes.accordion(n))
    sizes = np.bincount(partition)
    # the ends see an end of the screen and know their panel; faces far from both ends stay alone
    assert sizes[0] == 2
    middle = partition[n - 5 : n + 5]
    np.testing.assert_array_equal(sizes[middle], 1)


def test_a_strip_of_faces_without_area_takes_linear_time():
    n = 30_000
    line = np.column_stack([np.arange(n + 2), np.zeros((n + 2, 2))])
    strip = np.column_stack([np.arange(n), np.arange(1, n + 1), np.arange(2, n + 2)])
    mesh = Mesh([*line, [0, 1, 0]], [*strip, [1, 0, n + 2]])
    assert dihedral_partition(mesh).max() == 0


def test_cancel_stops_between_chunks():
    cancel = threading.Event()
    cancel.set()
    with pytest.raises(Cancelled):
        dihedral_partition(shapes.box(2), monitor=Monitor(cancel=cancel))


@pytest.mark.parametrize(
    ("n_slots", "error", "message"),
    [
        (0, ValueError, "n_slots must be at least 1, got 0"),
        (10**9, ValueError, "n_slots must be at most 1000000, got 1000000000"),
        (6.4, TypeError, "n_slots must be a whole number, got 6.4"),
    ],
)
def test_a_bad_number_of_slots_is_refused(n_slots, error, message):
    with pytest.raises(error, match=message):
        dihedral_partition(shapes.triangle(), n_slots)


def test_an_unknown_order_is_refused():
    with pytest.raises(ValueError, match='order must be "index" or "area", got \'random\''):
        dihedral_partition(shapes.triangle(), order="random")
