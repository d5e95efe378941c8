"""Items of both kinds: maps, sums and neighbours by their definitions; what moving a mesh may not change."""

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import nasty_meshes

from scenewidget.engine import items as items_module
from scenewidget.engine.items import find_bridges, patch_items, simplified_items, superfacet_items
from scenewidget.engine.mesh import Mesh, MeshError, connected_components, face_adjacency
from scenewidget.engine.scale import scene_scale


def superfacets(mesh, **options):
    return superfacet_items(mesh, face_adjacency(mesh), **options)


def same_partition(a, b):
    pairs = np.unique(np.stack([a, b], axis=1), axis=0)
    return len(pairs) == len(np.unique(a)) == len(np.unique(b))


def check(items, mesh):
    """What holds for any items of any mesh."""
    n = items.n
    assert items.face_map.shape == (mesh.n_faces,)
    assert set(items.item_of_face[items.item_of_face >= 0].tolist()) == set(range(n))
    assert items.face_map.min() >= -1
    assert items.face_map.max() < n
    inside = items.item_of_face >= 0
    expected = np.bincount(items.item_of_face[inside], items.mesh.face_areas[inside], n)
    np.testing.assert_allclose(items.areas, expected)
    assert (items.areas > 0).all()
    weighted = [
        np.bincount(items.item_of_face[inside], (items.mesh.face_areas * c)[inside], n)
        for c in items.mesh.face_centroids.T
    ]
    size = np.ptp(items.mesh.vertices, axis=0).max() + np.abs(items.mesh.vertices).max()
    np.testing.assert_allclose(
        items.centroids, np.stack(weighted, axis=1) / expected[:, None], atol=1e-9 * size
    )
    length = np.linalg.norm(items.normals, axis=1)
    assert ((np.abs(length - 1) < 1e-9) | (length == 0)).all()
    assert (items.pairs[:, 0] < items.pairs[:, 1]).all()
    code = items.pairs[:, 0].astype(int) * n + items.pairs[:, 1]
    assert (np.diff(code) > 0).all()
    assert set(items.seam_pair.tolist()) == set(range(len(items.pairs)))
    assert (np.abs(items.seam_dot) <= 1 + 1e-5).all()
    assert items.graph.shape == (n, n)
    with pytest.raises(ValueError, match="read-only"):
        items.areas[0] = 1


@given(nasty_meshes(), st.sampled_from([2, 30, 6000]))
@settings(max_examples=60)
def test_superfacets_of_any_mesh_are_sound(mesh, n_items):
    if not mesh.face_areas.any():
        with pytest.raises(MeshError, match="no face with an area"):
            superfacets(mesh, n_items=n_items)
        return
    items = superfacets(mesh, n_items=n_items)
    check(items, mesh)
    assert items.n <= n_items
    dropped = int((items.face_map < 0).sum())
    assert dropped == items.report["faces floating free of everything"]
    reach = 0.06 * scene_scale(mesh)
    links = np.concatenate([face_adjacency(mesh), find_bridges(mesh, face_adjacency(mesh), reach)])
    same = items.item_of_face[links[:, 0]] == items.item_of_face[links[:, 1]]
    _, piece = connected_components(mesh.n_faces, links[same])
    inside = items.item_of_face >= 0
    assert same_partition(piece[inside], items.item_of_face[inside])  # each item is in one piece
    np.testing.assert_array_equal(items.face_map[inside], items.item_of_face[inside])
    ends = items.item_of_face[links]
    ends = ends[(ends >= 0).all(axis=1) & (ends[:, 0] != ends[:, 1])]
    np.testing.assert_array_equal(items.pairs, np.unique(np.sort(ends, axis=1), axis=0).reshape(-1, 2))


@given(nasty_meshes())
@settings(max_examples=60)
def test_simplified_items_of_any_mesh_are_sound(mesh):
    if not mesh.face_areas.any():
        return
    items = simplified_items(mesh, face_adjacency(mesh), n_faces=50)
    check(items, mesh)
    np.testing.assert_array_equal(items.item_of_face, np.arange(items.n))


def test_superfacets_of_a_box_do_not_cross_its_edges():
    mesh = shapes.box(12)
    items = superfacets(mesh)
    side = np.round(mesh.face_normals) @ [1, 2, 4]
    for item in range(items.n):
        assert len(set(side[items.face_map == item].tolist())) == 1
    np.testing.assert_allclose(np.linalg.norm(items.normals, axis=1), 1)


def test_convexity_follows_the_normals():
    outside = superfacets(shapes.box(6))
    assert outside.is_convex.all()
    mesh = shapes.box(6)
    assert not superfacets(Mesh(mesh.vertices, mesh.faces[:, ::-1])).is_convex.any()


def test_crumbs_are_dropped_and_reported():
    room, _ = shapes.room(60)
    crumbs = shapes.fragments(10, size=0.01)
    mesh = shapes.joined(room, crumbs, gap=10.0)
    items = superfacets(mesh, n_items=1000)
    assert items.report["faces floating free of everything"] == 80
    np.testing.assert_array_equal(items.face_map >= 0, np.arange(mesh.n_faces) < room.n_faces)


def test_a_mesh_of_nothing_but_fragments_keeps_the_largest_that_fit():
    mesh = shapes.fragments(300)
    items = superfacets(mesh, n_items=100, bridge=0.0)
    assert items.n == 100
    assert (items.face_map >= 0).sum() == 800
    everything = superfacets(mesh, n_items=1000, bridge=0.0)
    assert everything.n == 300
    assert everything.face_map.min() == 0


@pytest.mark.parametrize("kind", ["superfacets", "simplified"])
def test_fourteen_thousand_fragments_are_read_in_seconds(kind):
    room, _ = shapes.room(90)
    mesh = shapes.joined(room, shapes.fragments(14_000, size=0.004), gap=8.0)
    pairs = face_adjacency(mesh)
    if kind == "superfacets":
        items = superfacet_items(mesh, pairs)
        assert items.n <= 6000
    else:
        items = simplified_items(mesh, pairs)
        assert 9000 <= items.n <= 11_000
    assert (items.face_map[: room.n_faces] >= 0).mean() > 0.99


# --- invariances ----------------------------------------------------------------------------------


@given(st.integers(0, 999))
@settings(max_examples=10)
def test_superfacets_do_not_depend_on_place_and_orientation(seed):
    mesh, _ = shapes.room(10, noise=0.005)
    moved = shapes.moved(mesh, seed=seed)
    a, b = superfacets(mesh), superfacets(moved)
    # normals are float32, so a near tie may fall otherwise and move one patch of hundreds
    assert np.mean(label_agreement(a.face_map, b.face_map)) > 0.97


def label_agreement(a, b):
    """For each face, whether its partner in b is the one that holds most of its label in a."""
    table = np.zeros((a.max() + 1, b.max() + 1))
    np.add.at(table, (a, b), 1)
    return table.argmax(axis=1)[a] == b


@given(st.randoms(use_true_random=False))
@settings(max_examples=10)
def test_superfacets_of_a_clean_box_do_not_depend_on_the_order_of_faces(random):
    mesh = shapes.box(8)
    order = np.array(random.sample(range(mesh.n_faces), mesh.n_faces))
    shuffled = superfacets(shapes.with_faces_in_order(mesh, order))
    assert same_partition(superfacets(mesh).face_map[order], shuffled.face_map)


@given(st.randoms(use_true_random=False))
@settings(max_examples=5)
def test_items_are_the_same_to_the_last_bit_in_any_order_of_faces(random):
    mesh, _ = shapes.room(10, noise=0.005)
    order = np.array(random.sample(range(mesh.n_faces), mesh.n_faces))
    items, shuffled = superfacets(mesh), superfacets(Mesh(mesh.vertices, mesh.faces[order]))
    np.testing.assert_array_equal(items.face_map[order], shuffled.face_map)
    for name in ("areas", "centroids", "normals", "pairs", "seam_pair", "seam_dot"):
        np.testing.assert_array_equal(getattr(items, name), getattr(shuffled, name))


@given(st.integers(-6, 0))
def test_superfacets_do_not_depend_on_scale(exponent):
    room, _ = shapes.room(8, noise=0.004)
    mesh = Mesh(room.vertices / 8, room.faces)
    scaled = Mesh(mesh.vertices * 2.0**exponent, mesh.faces)
    a, b = superfacets(mesh), superfacets(scaled)
    assert same_partition(a.face_map, b.face_map)


# --- bridges --------------------------------------------------------------------------------------


def two_sheets(gap):
    return shapes.joined(shapes.grid_square(5), shapes.grid_square(5), gap=1.0 + gap)


def test_fragments_within_reach_are_bridged_and_others_are_not():
    near, far = two_sheets(0.05), two_sheets(0.5)
    step = 0.2 / 3  # from a border face's centroid to the border, at most 2/3 of a cell
    pairs = face_adjacency(near)
    bridges = find_bridges(near, pairs, 0.05 + 4 * step)
    assert len(bridges)
    assert (bridges[:, 0] < 50).all()
    assert (bridges[:, 1] >= 50).all()
    distance = np.linalg.norm(near.face_centroids[bridges[:, 0]] - near.face_centroids[bridges[:, 1]], axis=1)
    assert distance.max() <= 0.05 + 4 * step
    assert len(find_bridges(far, face_adjacency(far), 0.05 + 4 * step)) == 0


def test_no_reach_one_component_or_no_border_need_no_bridges():
    sheets = two_sheets(0.01)
    assert find_bridges(sheets, face_adjacency(sheets), 0.0).shape == (0, 2)
    one = shapes.grid_square(3)
    assert find_bridges(one, face_adjacency(one), 1.0).shape == (0, 2)
    closed = shapes.joined(shapes.icosphere(1), shapes.icosphere(1), gap=2.01)
    assert find_bridges(closed, face_adjacency(closed), 1.0).shape == (0, 2)


def test_each_border_face_finds_its_nearest_of_another_fragment():
    mesh = shapes.fragments(60, seed=3, size=0.3)
    pairs = face_adjacency(mesh)
    _, component = connected_components(mesh.n_faces, pairs)
    border = np.flatnonzero(np.bincount(pairs.ravel(), minlength=mesh.n_faces) < 3)
    expected = set()
    for f in border[component[border] != np.bincount(component).argmax()]:
        other = border[component[border] != component[f]]
        distance = np.linalg.norm(mesh.face_centroids[other] - mesh.face_centroids[f], axis=1)
        if distance.min() < 0.4:
            expected.add(tuple(sorted((int(f), int(other[distance.argmin()])))))
    bridges = find_bridges(mesh, pairs, 0.4)
    assert expected <= {tuple(pair) for pair in bridges.tolist()}
    assert (component[bridges[:, 0]] != component[bridges[:, 1]]).all()


def test_a_closed_thing_in_an_open_room_has_nothing_to_bridge():
    mesh = shapes.joined(shapes.grid_square(20), shapes.icosphere(1, radius=0.1), gap=1.1)
    assert find_bridges(mesh, face_adjacency(mesh), 0.5).shape == (0, 2)


def test_tints_tell_colours_apart_and_shadows_not():
    colors = np.array([[120, 120, 120], [60, 60, 60], [180, 90, 120], [120, 120, 60]])
    mesh = Mesh(np.repeat(shapes.grid_square(1).vertices[:3], 4, axis=0), np.arange(12).reshape(3, 4).T)
    mesh = Mesh(mesh.vertices, mesh.faces, np.tile(colors, (3, 1)).astype(np.uint8))
    green, blue = patch_items(mesh, np.arange(4)).face_tints
    np.testing.assert_allclose(green, [0, 0, np.log(190 / 100), 0], atol=1e-12)
    np.testing.assert_allclose(blue, [0, 0, 0.5 * np.log(190 * 100 / 130**2), np.log(130 / 70)], atol=1e-12)


def halves():
    """A square in two items of two faces each, and one face that is dropped."""
    mesh = shapes.grid_square(2)
    return patch_items(mesh, np.array([0, 0, 0, 0, 1, 1, -1, 2]))


def test_labels_touch_where_items_of_both_are_neighbours():
    items = halves()
    np.testing.assert_array_equal(items.touching(np.arange(3)).labels, items.pairs)
    np.testing.assert_array_equal(items.touching(np.arange(3)).seam_edges, items.seam_edges)
    assert items.touching(np.zeros(3, int)).labels.shape == (0, 2)
    assert items.touching(np.array([5, 5, -1])).labels.shape == (0, 2)
    assert items.touching(np.array([5, 4, -1])).labels.tolist() == [[5, 4]]


def test_values_of_items_go_to_faces_and_those_of_vertices_to_items():
    items = halves()
    assert items.to_faces(np.array([7, 8, 9], np.int32), -1).tolist() == [7, 7, 7, 7, 8, 8, -1, 9]
    assert items.to_faces(np.array([0.5, 1.0, 2.0], np.float32), 0.0).dtype == np.float32
    # a linear function has its mean at the centroid
    np.testing.assert_allclose(items.from_vertices(items.mesh.vertices), items.centroids, atol=1e-12)


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 3.0))
def test_whoever_lies_within_reach_of_a_speck_is_looked_at(seed, reach):
    rng = np.random.default_rng(seed)
    places = rng.normal(size=(80, 3)) * rng.choice([1.0, 100.0], size=(80, 1))
    ones, specks = np.arange(60), np.arange(60, 80)
    apart = np.linalg.norm(places[ones][:, None] - places[specks], axis=2).min(axis=1)
    is_near = items_module._are_near(places, ones, specks, reach)
    assert is_near[apart <= reach].all()
    side = max(reach, np.ptp(places[specks], axis=0).max() / 100)
    assert not is_near[apart > 4 * side].any()  # beyond two cells on each axis
