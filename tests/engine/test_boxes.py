"""Boxes around segments: against what they were made of, and turned with the scan."""

import json

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.engine.boxes import oriented_boxes


def turned(mesh, angle, shift=(0.0, 0.0, 0.0)):
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return sw.Mesh(mesh.vertices @ rotation.T + shift, mesh.faces), rotation


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0, -1.2])
def test_a_turned_box_has_itself_as_its_box(angle):
    mesh, rotation = turned(shapes.box(3, size=(4.0, 3.0, 2.4)), angle, (7.0, 8.0, 9.0))
    boxes = oriented_boxes(mesh, np.zeros(mesh.n_faces, int), 1)
    np.testing.assert_allclose(boxes.size[0], [4.0, 3.0, 2.4], atol=1e-9)
    np.testing.assert_allclose(np.abs(boxes.axes[0] @ rotation), np.eye(3), atol=1e-9)
    np.testing.assert_allclose(boxes.center[0], (mesh.vertices.min(0) + mesh.vertices.max(0)) / 2, atol=1e-9)
    assert np.linalg.det(boxes.axes[0]) == pytest.approx(1)


def test_no_turn_gives_a_smaller_plan():
    rng = np.random.default_rng(5)
    points = rng.normal(size=(60, 3)) * [3, 1, 0.5]
    mesh = sw.Mesh(points, np.arange(60).reshape(-1, 3))
    boxes = oriented_boxes(mesh, np.zeros(20, int), 1)
    angles = np.linspace(0, np.pi / 2, 2000)
    along = np.outer(np.cos(angles), points[:, 0]) + np.outer(np.sin(angles), points[:, 1])
    across = np.outer(np.cos(angles), points[:, 1]) - np.outer(np.sin(angles), points[:, 0])
    least = (np.ptp(along, axis=1) * np.ptp(across, axis=1)).min()
    assert boxes.size[0, 0] * boxes.size[0, 1] <= least
    inside = (points - boxes.center[0]) @ boxes.axes[0].T
    assert (np.abs(inside) <= boxes.size[0] / 2 + 1e-9).all()


def test_walls_have_no_thickness_and_segments_without_faces_no_box():
    mesh = sw.Mesh([[0, 0, 0], [3, 4, 0], [3, 4, 2], [0, 0, 2]], [[0, 1, 2], [0, 2, 3]])
    boxes = oriented_boxes(mesh, np.array([1, 1]), 2)
    np.testing.assert_allclose(boxes.size[1], [5, 0, 2], atol=1e-12)
    np.testing.assert_allclose(np.abs(boxes.axes[1, 0]), [0.6, 0.8, 0], atol=1e-12)
    assert np.isnan(boxes.center[0]).all()
    with pytest.raises(ValueError, match="up must be a direction"):
        oriented_boxes(mesh, np.array([1, 1]), 2, up=np.zeros(3))


def test_boxes_are_in_tables_and_in_scannet_files(tmp_path):
    mesh, _ = turned(shapes.box(3, size=(4.0, 3.0, 2.4)), 0.3)
    seg = sw.Segmentation.from_labels(mesh, (mesh.face_centroids[:, 2] > 1.2).astype(int))
    frame = seg.boxes()
    sw.export(seg, mesh, tmp_path / "room.aggregation.json")
    groups = json.loads((tmp_path / "room.aggregation.json").read_text())["segGroups"]
    for group, (_, row) in zip(groups, frame.iterrows(), strict=True):
        assert group["obb"]["centroid"] == list(row["center"])
        assert group["obb"]["axesLengths"] == list(row["size"])
        assert group["obb"]["normalizedAxes"] == [x for axis in row["axes"] for x in axis]
