"""Tiles that overlap, and what becomes of surfaces that run through several."""

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.batch import tiles as tiles_module
from scenewidget.batch.tiles import segment_tiles, tiles
from scenewidget.engine.scale import scene_scale

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


def test_a_floor_goes_on_under_a_carpet_that_one_tile_has_told_from_it():
    mesh = shapes.sheet(24, 8, width=6.0, depth=2.0)
    x, y, _ = mesh.face_centroids.T
    parts = [np.flatnonzero(x < 4.0), np.flatnonzero(x > 2.0)]
    is_own = [x[parts[0]] < 3.0, x[parts[1]] >= 3.0]
    carpet = (abs(x - 3.0) < 1.5) & (abs(y - 1.0) < 0.4)  # less than half of what both see
    first, second = carpet[parts[0]].astype(int), np.zeros(len(parts[1]), int)
    found = [(labels, np.full(len(labels), 0.8)) for labels in (first, second)]
    joined = tiles_module._joined(mesh, parts, is_own, found)
    assert joined.n_segments == 2
    assert (joined.labels == (carpet & (x < 3.0))).all()
    assert joined.levels["base"].max() == 2
    is_disputed = carpet & (x > 2.0) & (x < 4.0)  # one of two says something else
    assert joined.confidence[is_disputed] == pytest.approx(0.4)
    assert joined.confidence[~is_disputed] == pytest.approx(0.8)


def test_tiles_have_the_colours_and_the_unit_of_the_whole(monkeypatch):
    mesh = shapes.sheet(24, 8, width=6.0, depth=2.0)
    colors = np.arange(3 * mesh.n_vertices, dtype=np.uint32).reshape(-1, 3).astype(np.uint8)
    mesh = sw.Mesh(mesh.vertices, mesh.faces, vertex_colors=colors)
    seen = []
    monkeypatch.setattr(
        tiles_module, "segment", lambda part, params: seen.append((part, params)) or sw.segment(part, params)
    )
    segment_tiles(mesh, FAST, max_faces=200, overlap=0.5)
    assert len(seen) == 2
    known = dict(zip(map(tuple, mesh.vertices), map(tuple, colors)))
    for part, params in seen:
        assert [known[tuple(v)] for v in part.vertices] == list(map(tuple, part.vertex_colors))
        assert params.scale == scene_scale(mesh) != 1


def test_tiles_on_somebodys_workers_give_the_same():
    distributed = pytest.importorskip("distributed")
    mesh = corner()
    here = segment_tiles(mesh, FAST, max_faces=200, overlap=0.5)
    options = {"n_workers": 1, "threads_per_worker": 2, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:
        there = segment_tiles(mesh, FAST, max_faces=200, overlap=0.5, client=cluster)
    assert there.labels.tolist() == here.labels.tolist()
    np.testing.assert_array_equal(there.confidence, here.confidence)


def test_faces_in_one_place_are_one_tile():
    assert len(tiles(shapes.joined(*[shapes.triangle()] * 4), max_faces=1, overlap=0)) == 1


def test_bad_input_is_explained():
    with pytest.raises(TypeError, match="mesh must be a Mesh, got PointCloud"):
        segment_tiles(sw.PointCloud(np.random.default_rng(0).uniform(size=(30, 3))))
    with pytest.raises(ValueError, match="overlap must be a length"):
        tiles(corner(), max_faces=10, overlap=-1)
    with pytest.raises(TypeError, match="params must be a Params, got dict"):
        segment_tiles(corner(), {})
    with pytest.raises(ValueError, match="max_faces"):
        tiles(corner(), max_faces=0, overlap=1)


def test_many_scans_can_be_segmented_in_tiles(tmp_path):
    mesh = corner()
    sw.export(sw.Segmentation.from_labels(mesh, np.zeros(mesh.n_faces, int)), mesh, tmp_path / "a.ply")
    options = {"n_workers": 0, "progress": False}
    found = sw.segment_all(tmp_path / "a.ply", tmp_path / "out", FAST, tile_faces=200, **options)
    assert found.rows["a.ply"]["status"] == "done"
    labels = sw.import_labels(tmp_path / "a.ply", tmp_path / "out" / "a.ply" / "a.npz")
    expected = segment_tiles(sw.load(tmp_path / "a.ply"), FAST, max_faces=200)
    assert labels.labels.tolist() == expected.labels.tolist()
    whole = sw.segment_all(tmp_path / "a.ply", tmp_path / "out", FAST, **options)
    assert whole.rows["a.ply"]["status"] == "done"  # not reused: other labels
    with pytest.raises(ValueError, match="tile_faces must"):
        sw.segment_all(tmp_path / "a.ply", tmp_path / "out", FAST, tile_faces=0, **options)
