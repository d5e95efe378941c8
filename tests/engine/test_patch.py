"""What a brush takes: faces that are reached over the surface."""

import numpy as np
import pytest

import scenewidget as sw
from scenewidget.datasets import analytic
from scenewidget.engine.patch import reached_faces


def mug(noise=0.0):
    """A steep mound of 0.3 m on a floor of a metre, melted into it, and which of its faces are the mound."""
    flat = analytic.square(40)
    x, y, _ = (flat.vertices - flat.vertices.mean(axis=0)).T
    raised = np.hypot(x, y) < 0.2
    rng = np.random.default_rng(0)
    z = 0.3 * raised + noise * rng.normal(size=len(x))
    mesh = sw.Mesh(np.column_stack([x, y, z]), flat.faces)
    return mesh, raised[mesh.faces].any(axis=1)


@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_a_mug_is_taken_whole_and_its_table_is_not(noise):
    mesh, is_mug = mug(noise)
    height = mesh.face_centroids[:, 2]
    top, floor = int(np.argmax(height)), 0
    for face, expected in ((top, is_mug), (floor, ~is_mug)):
        found = np.zeros(mesh.n_faces, bool)
        found[reached_faces(mesh, face, radius=2.0)] = True
        assert np.mean(found == expected) > 0.995
    assert len(reached_faces(mesh, top, radius=2.0, crease=180)) == mesh.n_faces


def test_a_brush_reaches_as_far_as_its_radius():
    mesh, _ = mug()
    found = reached_faces(mesh, 0, radius=0.1)
    away = np.linalg.norm(mesh.face_centroids - mesh.face_centroids[0], axis=1)
    np.testing.assert_array_equal(found, np.flatnonzero(away <= 0.1))


def test_a_brush_stops_at_an_edge_between_colours():
    flat = analytic.square(10)
    colors = np.where(flat.vertices[:, :1] < 0.45, [[200, 30, 30]], [[60, 60, 60]]).astype(np.uint8)
    mesh = sw.Mesh(flat.vertices, flat.faces, colors)
    red = reached_faces(mesh, 0, radius=9.0)
    assert mesh.face_centroids[red, 0].max() < 0.5
    assert len(reached_faces(mesh, 0, radius=9.0, color_step=255)) == mesh.n_faces


@pytest.mark.parametrize(
    ("face", "radius", "message"),
    [(200, 0.1, "there is no face 200: the mesh has 200 faces"), (0, 0.0, "radius must be a positive number"),
     (0, np.nan, "radius must be a positive"), (-1, 1.0, "there is no face -1")],
)  # fmt: skip
def test_what_a_brush_cannot_take_is_named(face, radius, message):
    with pytest.raises(ValueError, match=message):
        reached_faces(analytic.square(10), face, radius)
