"""What a drawing holds: the surface, its colours, its light."""

import numpy as np
from shapes import box, grid_square, icosphere, tetrahedron

import scenewidget as sw
from scenewidget.figures.drawing import UNLABELED, draw, lit
from scenewidget.figures.raster import Camera


def facing(triangles):
    """Triangles given in the picture's own axes (right, up, towards the camera), seen along −x."""
    right, up, towards = np.moveaxis(np.asarray(triangles, float), -1, 0)
    return np.stack([towards, right, up], axis=-1), Camera(0.0, 0.0, 10.0)


def test_labels_take_distinct_colours_and_none_is_grey():
    mesh = box(4)
    side = np.abs(mesh.face_normals).argmax(axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    colors = draw(mesh, np.where(side == 5, -1, 10 * side)).colors
    facing = mesh.face_normals[:, None]
    for i in range(6):
        of_side = colors[side == i].reshape(-1, 3)
        assert len(np.unique(of_side, axis=0)) == 1  # one normal, one light, one colour
    grey = lit(np.tile(np.array(UNLABELED, np.uint8), (mesh.n_faces, 1, 1)), facing)
    np.testing.assert_array_equal(colors[side == 5][:, 0], grey[side == 5][:, 0])
    unlit = {tuple(colors[side == i][0, 0] / (colors[side == i][0, 0].max())) for i in range(6)}
    assert len(unlit) == 6


def test_values_at_vertices_and_at_faces_are_coloured_by_the_scale():
    mesh = tetrahedron()
    drawing = draw(mesh, values=[0.0, 1.0, 2.0, 3.0], smooth=False)  # as many vertices as faces: vertices
    assert drawing.scale is not None
    expected = lit(
        drawing.scale.colors(mesh.faces.astype(float)), mesh.face_normals[:, None].repeat(3, axis=1)
    )
    np.testing.assert_array_equal(drawing.colors, expected)
    by_face = draw(grid_square(2), values=np.arange(8.0))
    assert (by_face.colors == by_face.colors[:, :1]).all()


def test_light_falls_from_above():
    ball = icosphere(3)
    shade = draw(ball, smooth=True).colors[..., 0].mean(axis=1)
    assert shade[ball.face_centroids[:, 2] > 0.8].min() > shade[ball.face_centroids[:, 2] < -0.8].max()
    assert shade.min() > 0.5 * shade.max()


def test_the_surface_comes_first_and_keeps_its_shape():
    mesh = icosphere(2)
    drawing = draw(
        mesh, values=mesh.vertices[:, 2], isolines=3, edges=True, vectors=mesh.vertices, points=[5]
    )
    assert drawing.n_surface == mesh.n_faces
    np.testing.assert_allclose(drawing.corners[: mesh.n_faces], mesh.vertices[mesh.faces], atol=1e-6)
    added = len(drawing.corners) - mesh.n_faces
    assert added > 3 * mesh.n_vertices + 8  # needles, a mark, and the ribbons
    assert len(drawing.colors) == len(drawing.corners)


def test_rooms_are_looked_into_and_things_are_not():
    inward = sw.Mesh(box(3).vertices, box(3).faces[:, ::-1])
    assert draw(inward).hides_back
    assert not draw(box(3)).hides_back
    assert not draw(grid_square(3)).hides_back
    assert not draw(inward, back_faces=True).hides_back


def test_a_large_mesh_is_drawn_simplified_and_says_so():
    mesh = icosphere(4)
    top = (mesh.face_centroids[:, 2] > 0).astype(int)
    drawing = draw(mesh, top, max_faces=500)
    assert 400 < drawing.n_surface <= 500
    assert "5\u2009120" in drawing.note
    # colours stay where they were: compare with the two colours of the full drawing, up to the light
    middle = drawing.corners.mean(axis=1)[:, 2]
    hue = drawing.colors[:, 0] / drawing.colors[:, 0].max(axis=1, keepdims=True)
    upper, lower = hue[middle > 0.2], hue[middle < -0.2]
    assert np.abs(upper - upper.mean(axis=0)).max() < 0.05
    assert np.abs(lower - lower.mean(axis=0)).max() < 0.05
    assert np.abs(upper.mean(axis=0) - lower.mean(axis=0)).max() > 0.1
