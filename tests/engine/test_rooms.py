"""Rooms of a flat whose walls are known, and its coarse picture."""

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.engine.rooms import coarse_mesh, rooms_of


def sheet(corner, along, up, step=0.1):
    """A rectangle of triangles; its normal is ``along`` x ``up``."""
    corner, along, up = (np.array(v, dtype=float) for v in (corner, along, up))
    n, m = (max(1, round(np.linalg.norm(v) / step)) for v in (along, up))
    i, j = np.meshgrid(np.arange(n + 1), np.arange(m + 1), indexing="ij")
    vertices = corner + i.reshape(-1, 1) / n * along + j.reshape(-1, 1) / m * up
    k = (np.arange(n)[:, None] * (m + 1) + np.arange(m)).ravel()
    one, other = np.stack([k, k + m + 1, k + m + 2], 1), np.stack([k, k + m + 2, k + 1], 1)
    return vertices, np.concatenate([one, other])


def flat(turn=0.0, door=0.9):
    """Two rooms of 4 x 4 m, a wall of 12 cm between them with an open door; and who is left of it."""
    high = (0, 0, 2.5)
    pieces = [sheet((0, 0, 0), (8.12, 0, 0), (0, 4, 0)), sheet((0, 4, 2.5), (8.12, 0, 0), (0, -4, 0))]
    pieces += [sheet((8.12, 0, 0), (-8.12, 0, 0), high), sheet((0, 4, 0), (8.12, 0, 0), high)]
    pieces += [sheet((0, 0, 0), (0, 4, 0), high), sheet((8.12, 4, 0), (0, -4, 0), high)]
    for low, side in ((0.0, 2 - door), (2.0, 2.0)):  # on either side of the door
        pieces += [sheet((4, low + side, 0), (0, -side, 0), high), sheet((4.12, low, 0), (0, side, 0), high)]
    ends = np.cumsum([0, *(len(v) for v, _ in pieces)])
    vertices = np.concatenate([v for v, _ in pieces])
    faces = np.concatenate([f + end for (_, f), end in zip(pieces, ends, strict=False)])
    is_left = vertices[faces].mean(axis=1)[:, 0] < 4.06
    c, s = np.cos(turn), np.sin(turn)
    return sw.Mesh(vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), faces), is_left


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_a_door_parts_two_rooms_and_each_has_its_side_of_the_wall(turn):
    mesh, is_left = flat(turn)
    room = rooms_of(mesh)
    assert room.max() == 1
    left = room == room[np.argmax(is_left)]
    assert np.mean(left != is_left) < 0.01  # some in the doorway


def test_a_wide_opening_parts_nothing():
    mesh, _ = flat(door=1.6)
    assert rooms_of(mesh).max() == 0


def test_rooms_with_too_many_faces_are_halved_and_nothing_is_lost():
    mesh, _ = flat()
    room = rooms_of(mesh, max_faces=3000)
    n = np.bincount(room)
    assert n.max() <= 3000 < mesh.n_faces / 2
    assert (np.diff(n) <= 0).all()
    with pytest.raises(ValueError, match="max_faces must be"):
        rooms_of(mesh, max_faces=0)


def test_what_has_no_walls_is_one_room_and_a_lone_face_too():
    assert rooms_of(shapes.sheet(9, 9, width=3.0, depth=3.0)).max() == 0
    assert rooms_of(sw.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])).tolist() == [0]


def test_the_coarse_mesh_lies_on_the_fine_one_and_tells_its_faces():
    mesh, _ = flat()
    coarse, face = coarse_mesh(mesh, 2000)
    assert 1000 < coarse.n_faces < 4000
    assert coarse.face_areas.sum() == pytest.approx(mesh.face_areas.sum(), rel=0.1)
    away = np.linalg.norm(coarse.face_centroids - mesh.face_centroids[face], axis=1)
    assert away.max() < 0.6
    same, every = coarse_mesh(mesh, mesh.n_faces)
    assert same is mesh
    assert len(every) == mesh.n_faces
