"""Decimation: to the bit what fast-simplification gives, on closed, open, noisy and fragmented meshes."""

import platform

import fast_simplification
import numpy as np
import pytest
from scipy.spatial import cKDTree

from scenewidget.datasets import load_room
from scenewidget.datasets.analytic import sphere, square
from scenewidget.engine import decimation
from scenewidget.engine.decimation import decimate


def noisy_sheet():
    sheet = square(30)
    return sheet.vertices + np.random.default_rng(0).normal(0, 0.003, sheet.vertices.shape), sheet.faces


def part_of_a_scan():
    room, _ = load_room()
    used, corners = np.unique(room.faces[:20_000], return_inverse=True)
    return room.vertices[used], corners.reshape(-1, 3).astype(np.int32)


def fragments():
    """Every fifth face of a ball is missing: most vertices lie at rims, so hardly an edge can go."""
    ball = sphere(4)
    return 0.5 * ball.vertices, ball.faces[np.arange(ball.n_faces) % 5 > 0]


def two_sheets_and_a_fin():
    """Edges with three faces, and faces that come twice."""
    sheet = square(10)
    fin = sheet.vertices[:, [0, 2, 1]] + [0.0, 0.5, 0.0]
    vertices = np.concatenate([sheet.vertices, fin])
    faces = np.concatenate([sheet.faces, sheet.faces[:7], sheet.faces + len(fin)])
    same, where = np.unique(vertices.round(6), axis=0, return_inverse=True)
    return same + np.random.default_rng(1).normal(0, 0.002, same.shape), where.ravel()[faces].astype(np.int32)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="elsewhere C compilers fuse products and sums")
@pytest.mark.parametrize("make", [noisy_sheet, part_of_a_scan, fragments, two_sheets_and_a_fin])
@pytest.mark.parametrize(("share", "aggressiveness"), [(0.9, 7.0), (0.2, 7.0), (0.02, 7.0), (0.02, 15.0)])
def test_it_gives_what_fast_simplification_does_to_the_bit(make, share, aggressiveness):
    vertices, faces = make()
    target = int(share * len(faces))
    expected = fast_simplification.simplify(
        vertices.copy(), faces.astype(np.int32), target_count=target, agg=aggressiveness
    )
    found = decimate(vertices, faces, target, aggressiveness=aggressiveness)
    np.testing.assert_array_equal(found[0], expected[0])
    np.testing.assert_array_equal(found[1], expected[1])


def test_a_mesh_that_is_small_enough_stays_as_it_is():
    ball = sphere(2)
    vertices, faces = decimate(ball.vertices, ball.faces, ball.n_faces)
    np.testing.assert_array_equal(vertices, ball.vertices)
    np.testing.assert_array_equal(faces, ball.faces)


def test_what_it_is_given_stays_as_it_was():
    vertices, faces = noisy_sheet()
    before = vertices.copy(), faces.copy()
    decimate(vertices, faces, 100)
    np.testing.assert_array_equal(vertices, before[0])
    np.testing.assert_array_equal(faces, before[1])


def test_a_large_mesh_is_simplified_in_parts_as_well_as_whole_whatever_the_number_of_threads(monkeypatch):
    room, _ = load_room()
    faces = room.faces[np.argsort(room.face_centroids[:, 0])[:60_000]]
    used, corners = np.unique(faces, return_inverse=True)
    vertices, faces = 2.0 * room.vertices[used], corners.reshape(-1, 3).astype(np.int32)
    whole, _ = decimate(vertices, faces, 2_000)
    monkeypatch.setattr(decimation, "FEWEST", 50_000)
    found = []
    for n_threads in ("1", "3"):
        monkeypatch.setenv("SCENEWIDGET_THREADS", n_threads)
        found.append(decimate(vertices, faces, 2_000))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    np.testing.assert_array_equal(found[0][1], found[1][1])
    assert not np.array_equal(found[0][0], whole)
    assert len(found[0][1]) <= 2_000

    def off(simple):  # mean distance of what was to the nearest vertex of what is
        return cKDTree(simple).query(vertices)[0].mean()

    assert off(found[0][0]) < 1.03 * off(whole)
