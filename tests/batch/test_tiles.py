"""Tiles that overlap, and what becomes of surfaces that run through several."""

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.batch.tiles import segment_tiles, tiles

FAST = sw.Params(n_runs=2, n_graph_runs=2)


def corner():
    """A floor of 6 m and a wall along it."""
    floor = shapes.sheet(24, 8, width=6.0, depth=2.0)
    wall = sw.Mesh(floor.vertices[:, [0, 2, 1]], floor.faces[:, ::-1])
    return shapes.joined(floor, wall)


def test_a_scan_that_fits_is_segmented_as_ever():
    mesh = corner()
    expected = sw.segment(mesh, FAST)
    assert segment_tiles(mesh, FAST).labels.tolist() == expected.labels.tolist()


def test_a_floor_through_three_tiles_is_one():
    mesh = corner()
    found = segment_tiles(mesh, FAST, max_faces=mesh.n_faces // 2, overlap=0.5)
    whole = sw.segment(mesh, FAST)
    assert found.report["tiles"] >= 2
    assert sw.metrics.rand_index_error(found, whole) == 0
    assert ((found.confidence >= 0) & (found.confidence <= 1)).all()


def test_tiles_cover_every_face_and_share_what_lies_in_the_overlap():
    mesh = corner()
    parts = tiles(mesh, max_faces=200, overlap=0.5)
    seen = np.bincount(np.concatenate(parts), minlength=mesh.n_faces)
    assert seen.min() == 1
    assert seen.max() > 1
    alone = tiles(mesh, max_faces=200, overlap=0)
    assert np.bincount(np.concatenate(alone), minlength=mesh.n_faces).tolist() == [1] * mesh.n_faces
    assert max(map(len, alone)) <= 200


def test_faces_in_one_place_are_one_tile():
    assert len(tiles(shapes.joined(*[shapes.triangle()] * 4), max_faces=1, overlap=0)) == 1


def test_bad_input_is_explained():
    with pytest.raises(TypeError, match="mesh must be a Mesh, got PointCloud"):
        segment_tiles(sw.PointCloud(np.random.default_rng(0).uniform(size=(30, 3))))
    with pytest.raises(ValueError, match="overlap must be a length"):
        tiles(corner(), max_faces=10, overlap=-1)
    with pytest.raises(ValueError, match="max_faces"):
        tiles(corner(), max_faces=0, overlap=1)
