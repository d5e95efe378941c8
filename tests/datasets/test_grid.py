from __future__ import annotations

import numpy as np
import pytest

from scenewidget.datasets.grid import extract_surface, sample_scene
from scenewidget.datasets.materials import Material
from scenewidget.datasets.objects import Part
from scenewidget.datasets.scene import Scene, Thing
from scenewidget.datasets.shapes import ball
from scenewidget.engine.mesh import Mesh

RED = Material((255, 0, 0))


def ball_scene(*balls: tuple[list[float], float]) -> Scene:
    return Scene([Thing(f"ball {i}", (Part(ball(*b), RED),)) for i, b in enumerate(balls)])


def sampled(scene: Scene, *, voxel: float = 0.02, turn: float = 0.3):
    return sample_scene(
        scene, low=np.full(3, -0.7), high=np.full(3, 0.7), voxel=voxel, turn=turn, width=3 * voxel
    )


def in_room(band, vertices):
    return band.origin + vertices @ (band.axes / band.voxel).T


def test_marching_cubes_finds_the_area_of_a_ball_and_its_outside():
    band = sampled(ball_scene(([0.05, 0, 0.02], 0.4)))
    vertices, faces = extract_surface(band)
    mesh = Mesh(in_room(band, vertices), faces)
    assert mesh.face_areas.sum() == pytest.approx(4 * np.pi * 0.4**2, rel=0.005)
    out = mesh.face_centroids - [0.05, 0, 0.02]
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices - [0.05, 0, 0.02], axis=1), 0.4, atol=1e-3)
    assert ((out * mesh.face_normals).sum(axis=1) > 0).mean() == 1


def test_blocks_hold_every_node_near_a_surface():
    scene = ball_scene(([0, 0, 0], 0.4), ([0.5, 0.3, 0], 0.12))
    band = sampled(scene)
    n_expected = 4 / 3 * np.pi * sum((r + 0.06) ** 3 - (r - 0.06) ** 3 for r in (0.4, 0.12)) / 0.02**3
    n_found = (np.abs(band.values) <= 0.06).sum()
    assert n_found == pytest.approx(
        n_expected, rel=0.08
    )  # the two balls nearly touch: a few nodes are shared


def test_nodes_know_the_distance_and_the_part():
    scene = ball_scene(([0, 0, 0], 0.4), ([0.5, 0.3, 0], 0.12))
    band = sampled(scene)
    corner = in_room(band, band.blocks * 4 * band.voxel)  # node 0 of each block
    distance, part = scene.nearest(corner.T, reach=1)
    is_near = np.abs(distance) < 0.06
    np.testing.assert_allclose(band.values[is_near, 0], distance[is_near], atol=1e-5)
    np.testing.assert_array_equal(band.parts[is_near, 0], part[is_near])


def test_unknown_nodes_leave_a_hole_with_a_border():
    band = sampled(ball_scene(([0, 0, 0], 0.4)))
    whole = extract_surface(band)[1]
    height = band.origin[2] + band.blocks[:, 2] * 4 * band.voxel
    values = np.where((height > 0)[:, None], np.nan, band.values)
    vertices, faces = extract_surface(band.with_values(values))
    assert 0.35 < len(faces) / len(whole) < 0.65
    assert in_room(band, vertices)[:, 2].max() < 0.1


def test_nothing_known_gives_nothing():
    band = sampled(ball_scene(([0, 0, 0], 0.4)))
    vertices, faces = extract_surface(band.with_values(np.full_like(band.values, np.nan)))
    assert vertices.shape == faces.shape == (0, 3)


def test_nearest_agrees_with_asking_every_part():
    rng = np.random.default_rng(0)
    scene = ball_scene(*((rng.uniform(-1, 1, 3).tolist(), rng.uniform(0.05, 0.3)) for _ in range(8)))
    points = rng.uniform(-3, 3, (3, 3000)).astype(np.float32)
    each = np.stack([part.shape.distance(points) for part in scene.parts])
    distance, part = scene.nearest(points, reach=10)
    np.testing.assert_allclose(distance, each.min(axis=0))
    np.testing.assert_array_equal(part, each.argmin(axis=0))
    is_near = each.min(axis=0) < 0.08  # a short reach may settle for another part only further away than that
    np.testing.assert_array_equal(scene.nearest(points)[1][is_near], part[is_near])
