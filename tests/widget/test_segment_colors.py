"""Which colour a segment has after an edit."""

from __future__ import annotations

import numpy as np
import pytest
from sent import array
from shapes import grid_square

from scenewidget.widget.scene_view import SceneView


@pytest.fixture
def view() -> SceneView:
    return SceneView(grid_square(4))


@pytest.fixture
def quarters(view) -> np.ndarray:
    center = view.mesh.face_centroids
    return (2 * (center[:, 0] > 0.5) + (center[:, 1] > 0.5)).astype(np.int32)


def test_a_segment_keeps_its_colour_by_its_id_and_a_new_one_gets_a_spare_one(view, quarters):
    view.set_segments(quarters, levels={"final": quarters}, ids=np.array([10, 11, 12, 13]))
    colors, sent = view.segment_colors, array(view, "segment_colors")
    np.testing.assert_array_equal(sent[:4], colors)
    merged = np.array([1, 0, 0, 2])[quarters]  # 11 and 12 have become the first, as 12
    view.set_segments(merged, ids=np.array([12, 10, 13]))
    np.testing.assert_array_equal(view.segment_colors, colors[[2, 0, 3]])
    view.set_segments(quarters, ids=np.array([10, 14, 12, 13]))
    np.testing.assert_array_equal(view.segment_colors, [colors[0], sent[4], colors[2], colors[3]])
    view.set_segments(quarters, ids=np.array([10, 11, 12, 13]))
    np.testing.assert_array_equal(view.segment_colors, colors)
    with pytest.raises(ValueError, match=r"ids must have shape \(4,\), one a segment, got \(1,\)"):
        view.set_segments(quarters, ids=np.array([1]))
    view.set_segments(quarters, levels={"half": quarters // 2})  # what was refused has left nothing behind
