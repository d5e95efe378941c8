"""Rooms to look at, as cells of a notebook."""

# A room of 4 × 3 × 2.4 m seen from inside: floor 0, ceiling 1, walls 2-5; level "halves" cuts each in two.
ROOM = """
import numpy as np
from scenewidget.engine.mesh import Mesh
from scenewidget.widget.scene_view import SceneView

def sheet(corner, along, across, n=40):
    s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    i = np.arange(s.size).reshape(s.shape)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    points = np.array(corner) + s.reshape(-1, 1) * along + t.reshape(-1, 1) * across
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])

def room():
    x, y, z = 4.0 * np.eye(3)[0], 3.0 * np.eye(3)[1], 2.4 * np.eye(3)[2]
    o = 0 * x
    sides = [(o, x, y), (z, y, x), (o, y, z), (x, z, y), (o, z, x), (y, x, z)]
    sheets = [sheet(*side) for side in sides]
    vertices = np.concatenate([points for points, _ in sheets])
    faces = np.concatenate([triangles + k * len(sheets[0][0]) for k, (_, triangles) in enumerate(sheets)])
    return Mesh(vertices, faces), np.repeat(np.arange(6), len(sheets[0][1]))

mesh, surfaces = room()
halves = 2 * surfaces + (mesh.face_centroids[:, 0] > 2.0)
view = SceneView(mesh, height=420)
"""
LABELED = ROOM + "view.set_segments(surfaces, levels={'halves': halves, 'surfaces': surfaces})\n"
