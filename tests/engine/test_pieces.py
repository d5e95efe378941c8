from __future__ import annotations

import numpy as np
import pytest
import shapes
from hypothesis import given
from hypothesis import strategies as st

import scenewidget as sw
from scenewidget.datasets.analytic import square
from scenewidget.engine.pieces import make_pieces


def test_two_halves_of_a_sheet_meet_along_its_width():
    mesh = shapes.sheet(8, 4, width=2.0, depth=0.5)
    labels = (mesh.face_centroids[:, 0] > 1.0).astype(np.int32)
    pieces = make_pieces(mesh, labels, np.zeros_like(labels))
    assert pieces.pairs.tolist() == [[0, 1]]
    assert pieces.length[0] == pytest.approx(0.5)
    np.testing.assert_allclose(pieces.moments.area, [0.5, 0.5])
    np.testing.assert_allclose(np.abs(pieces.normals), [[0, 0, 1]] * 2, atol=1e-12)
    assert pieces.n_faces.tolist() == [32, 32]


def test_sides_of_a_cube_meet_along_its_edges():
    mesh = shapes.box(3)
    side = np.unique(np.round(mesh.face_normals).astype(int), axis=0, return_inverse=True)[1].ravel()
    pieces = make_pieces(mesh, side.astype(np.int32), side)
    edge = float(np.ptp(mesh.vertices[:, 0]))
    np.testing.assert_allclose(pieces.length, [edge] * 12)


def test_fragments_that_nearly_touch_touch():
    one = shapes.sheet(60, 60, width=3.0, depth=3.0)
    vertices = np.concatenate([one.vertices, one.vertices + np.array([3.01, 0, 0])])
    mesh = sw.Mesh(vertices, np.concatenate([one.faces, one.faces + one.n_vertices]))
    labels = np.repeat([0, 1], one.n_faces).astype(np.int32)
    pieces = make_pieces(mesh, labels, labels)
    assert pieces.pairs.tolist() == [[0, 1]]
    far = sw.Mesh(mesh.vertices + np.repeat([[0, 0, 0], [1, 0, 0]], one.n_vertices, axis=0), mesh.faces)
    assert len(make_pieces(far, labels, labels).pairs) == 0


@given(st.integers(0, 2**32 - 1))
def test_pieces_are_base_segments_within_segments(seed):
    mesh = shapes.box(2)
    rng = np.random.default_rng(seed)
    labels = rng.integers(-1, 3, mesh.n_faces).astype(np.int32)
    base = rng.integers(-1, 4, mesh.n_faces)
    pieces = make_pieces(mesh, labels, base)
    keep = (labels >= 0) & (base >= 0)
    assert ((pieces.face_piece >= 0) == keep).all()
    inside = pieces.face_piece[keep]
    np.testing.assert_array_equal(pieces.segment[inside], labels[keep])
    np.testing.assert_array_equal(pieces.base[inside], base[keep])
    np.testing.assert_array_equal(pieces.face_piece[pieces.first_face], np.arange(pieces.n))
    np.testing.assert_array_equal(pieces.n_faces, np.bincount(inside, minlength=pieces.n))
    assert len(np.unique(np.stack([pieces.base, pieces.segment]), axis=1).T) == pieces.n


def test_seams_are_measured_in_the_unit_of_the_scene():
    mesh = square(4)
    left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    assert make_pieces(mesh, left, left).scale == pytest.approx(np.sqrt(1 / 20))
    assert make_pieces(mesh, left, left, scale=1.0).scale == 1.0
