"""The unit of a scene, an order of faces that no file decides, and scenes that are far from each other."""

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st

from scenewidget.engine.mesh import Mesh, face_adjacency
from scenewidget.engine.scale import far_apart, geometric_order, own_frame, principal_axes, scene_scale


def shell(length, width, height):
    return shapes.box(12, size=(length, width, height))


@pytest.mark.parametrize(
    ("size", "unit"),
    [
        ((5.0, 4.0, 2.5), 1.0),  # a room
        ((2.5, 2.0, 2.4), 0.9),  # a bath: small, but as high as a room
        ((9.0, 1.5, 2.5), 1.0),  # a corridor
        ((12.0, 9.0, 2.6), 1.0),  # a flat
        ((12.0, 9.0, 5.2), 2.0),  # a hall
        ((1.2, 0.8, 0.2), 0.25),  # a table top
        ((0.5, 0.4, 0.9), 0.19),  # a chair
    ],
)
def test_scenes_have_the_unit_of_their_kind(size, unit):
    assert scene_scale(shell(*size)) == pytest.approx(unit, rel=0.12)


@pytest.mark.parametrize("factor", [0.5, 2.0])
@pytest.mark.parametrize("size", [(4.8, 4.0, 2.5), (5.3, 5.0, 2.6), (1.2, 0.8, 0.2)])
def test_the_unit_grows_with_the_scene(size, factor):
    grown = scene_scale(shell(*(factor * np.array(size)))) / scene_scale(shell(*size))
    assert grown == pytest.approx(factor, rel=0.15)


@pytest.mark.parametrize("seed", range(3))
def test_the_unit_hears_of_no_axes_and_of_no_crumbs(seed):
    mesh = shapes.room(8, noise=0.004)[0]
    far = np.array([[90.0, 0.0, 40.0], [90.1, 0.0, 40.0], [90.0, 0.1, 40.0]])
    with_crumb = Mesh(
        np.concatenate([mesh.vertices, far]), np.concatenate([mesh.faces, [mesh.n_vertices + np.arange(3)]])
    )
    unit = scene_scale(mesh)
    assert scene_scale(Mesh(mesh.vertices @ shapes.rotation(seed).T, mesh.faces)) == pytest.approx(unit)
    assert scene_scale(with_crumb) == pytest.approx(unit, rel=0.03)


def test_without_a_surface_the_unit_is_a_metre():
    assert scene_scale(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])) == 1.0


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_the_order_is_the_same_however_a_file_numbers_things(seed):
    mesh, rng = shapes.box(3), np.random.default_rng(seed)
    place, faces = rng.permutation(mesh.n_vertices), rng.permutation(mesh.n_faces)
    vertices = np.empty_like(mesh.vertices)
    vertices[place] = mesh.vertices
    turned = np.array(
        [np.roll(f, k) for f, k in zip(place[mesh.faces[faces]], rng.integers(0, 3, len(faces)))]
    )
    again = Mesh(vertices, turned)
    centers = mesh.face_centroids[geometric_order(mesh)]
    np.testing.assert_allclose(again.face_centroids[geometric_order(again)], centers, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_the_order_is_the_same_however_a_file_turns_the_scan(seed):
    mesh = shapes.room(6, noise=0.004)[0]
    turned = Mesh(mesh.vertices @ shapes.rotation(seed).T + [3.0, -8.0, 1.0], mesh.faces)
    assert geometric_order(turned).tolist() == geometric_order(mesh).tolist()


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**32 - 1))
def test_axes_turn_with_the_points_and_do_not_hear_of_their_order(seed):
    rng = np.random.default_rng(seed)
    points, weights = rng.gamma(2.0, size=(40, 3)) * (3.0, 2.0, 1.0), rng.random(40)
    axes, spread = principal_axes(points, weights)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    values = np.linalg.eigvalsh(np.cov(points.T, aweights=weights, bias=True))
    np.testing.assert_allclose(spread, values[::-1], rtol=1e-9)
    assert (((points - np.average(points, axis=0, weights=weights)) @ axes) ** 3 * weights[:, None]).sum(
        axis=0
    ).min() > -1e-3 * spread.sum() ** 1.5  # each looks to where something is farther off
    R = shapes.rotation(seed % 1000)
    np.testing.assert_allclose(
        points @ own_frame(points, weights), (points @ R.T) @ own_frame(points @ R.T, weights), atol=1e-9
    )
    order = rng.permutation(40)
    assert (principal_axes(points[order], weights[order])[0] == axes).all()  # to the last bit


def test_what_has_no_axes_of_its_own_keeps_those_of_its_file():
    box = shapes.box(4)
    assert (own_frame(box.face_centroids, box.face_areas) == np.eye(3)).all()
    axes, spread = principal_axes(np.ones((4, 3)), np.zeros(4))  # nothing, and without weight
    assert spread.max() == 0
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(("distance", "n"), [(0.5, 1), (2.5, 2)])
def test_boxes_are_scenes_of_their_own_beyond_the_gap(distance, n):
    large, small = shapes.box(8), shapes.box(8, size=(0.5, 0.5, 0.5))
    shift = [large.bounds[1, 0] - small.bounds[0, 0] + distance, 0, 0]
    mesh = Mesh(
        np.concatenate([small.vertices + shift, large.vertices]),
        np.concatenate([small.faces, large.faces + small.n_vertices]),
    )
    scene = far_apart(mesh, face_adjacency(mesh), gap=1.0)
    assert len(np.unique(scene)) == n
    assert (scene[small.n_faces :] == 0).all()  # the larger one comes first
    assert (scene[: small.n_faces] == n - 1).all()
