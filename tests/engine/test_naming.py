from __future__ import annotations

import numpy as np
import pytest
import shapes
import trimesh

import scenewidget as sw

ROOM, TRUTH = sw.datasets.load_room()


def test_a_room_has_one_floor_one_ceiling_and_walls_and_all_are_right():
    names = TRUTH.suggest_names()
    assert {name for name, _ in names.values()} == {"floor", "ceiling", "wall"}
    for segment, (name, p) in names.items():
        assert name in TRUTH.names[segment]
        assert 0.5 < p < 1


def test_names_turn_with_the_room():
    turned = sw.Mesh(ROOM.vertices[:, [2, 0, 1]], ROOM.faces)  # z becomes x: cyclic, so no mirror
    same = sw.Segmentation(turned, TRUTH.labels)
    assert same.suggest_names(up=(2, 0, 0)) == same.suggest_names() == TRUTH.suggest_names(up=(0, 0, 1))


def test_what_the_engine_finds_is_named_like_the_truth():
    seg = sw.segment(ROOM)
    names = seg.suggest_names()
    assert len(names) >= 4
    for segment, (name, _) in names.items():
        inside = (seg.labels == segment) & (TRUTH.labels >= 0)
        assert name in TRUTH.names[np.bincount(TRUTH.labels[inside]).argmax()]


def box(size, center):
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(center))


def test_tables_and_lamps_are_named_by_where_they_are_and_how_they_lie():
    room = box((5, 4, 2.5), (0, 0, 1.25))
    room.invert()
    things = {
        "table": box((1.4, 0.8, 0.03), (0, 0, 0.7)),
        "chest": box((1.4, 0.8, 0.7), (1.6, 0, 0.35)),  # as broad and nearly as high, but not thin
        "lamp": box((0.35, 0.35, 0.3), (0, 0, 1.9)),
        "vase": box((0.35, 0.35, 0.3), (-2, 1, 1.0)),  # the same, but doesn't hang
    }
    things["table"].update_faces(things["table"].face_normals[:, 2] > -0.5)  # a scan doesn't see below
    parts = [*room.submesh(room.facets, append=False), *things.values()]
    labels = np.repeat(np.arange(len(parts)), [len(part.faces) for part in parts])
    mesh = trimesh.util.concatenate(parts)
    names = sw.Segmentation(sw.load_mesh((mesh.vertices, mesh.faces)), labels).suggest_names(up=(0, 0, 1))
    found = {segment: name for segment, (name, _) in names.items() if segment >= 6}
    assert found == {6: "table", 8: "lamp"}
    assert sorted(name for name, _ in names.values()) == [
        *["ceiling", "floor", "lamp", "table"],
        *["wall"] * 4,
    ]


def test_a_table_is_no_room():
    table = shapes.sheet(10, 10, width=1.0, depth=1.0)
    assert sw.Segmentation(table, np.zeros(table.n_faces, int)).suggest_names() == {}


@pytest.mark.parametrize("up", [(0, 0, 0), (1, 2), (np.nan, 0, 1)])
def test_a_direction_that_is_none_is_refused(up):
    with pytest.raises(ValueError, match="up must be three numbers, not all zero"):
        TRUTH.suggest_names(up=up)
