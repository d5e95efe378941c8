"""Columns of the table of segments as colours, and boxes around the segments."""

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.widget.columns import COLUMNS, column_values

MESH = shapes.box(2, size=(4.0, 2.0, 1.0))
TOP = MESH.face_centroids[:, 2] > MESH.bounds[1][2] - 1e-6
SEG = sw.Segmentation.from_labels(MESH, TOP.astype(int))


def test_every_column_has_a_number_a_segment_and_none_for_unlabeled():
    frame = SEG.to_frame()
    for name in COLUMNS:
        values = column_values(SEG, name)
        assert values.shape == (SEG.n_segments + 1,)
        assert np.isnan(values[-1])
    np.testing.assert_array_equal(column_values(SEG, "area")[:-1], frame["area"])
    sides = [column_values(SEG, side)[:-1] for side in ("length", "width", "height")]
    np.testing.assert_array_equal(np.transpose(sides), np.array(frame["size"].tolist()))
    np.testing.assert_array_equal(np.array(frame["size"].tolist()), np.array(SEG.boxes()["size"].tolist()))


def test_a_column_colours_the_segments_and_follows_edits():
    w = sw.SceneWidget(MESH, sw.Params(n_runs=2, n_graph_runs=2), autosave=False)
    w.wait()
    assert set(COLUMNS) == set(w.view.columns)
    w.view.column = "area"
    w.wait()
    assert (w.view.color_by, w.view.values_legend["title"]) == ("values", "Area (m²)")
    before = w.view._face_value
    w.session.paint(np.flatnonzero(TOP)[:3])
    w.wait()
    assert w.view._face_value != before
    w.view.color_by = "segments"
    assert w.view.column == ""
    with pytest.raises(ValueError, match=r"column must be one of 'area', .*, got 'colour'"):
        w.view.column = "colour"
    w.close()


def test_boxes_are_sent_while_they_are_to_be_seen():
    view = sw.SceneView(MESH, up="z")
    view.set_segments(SEG.labels)
    assert view._segment_box == b""
    view.boxes = True
    rows = np.frombuffer(view._segment_box, np.float32).reshape(-1, 12)
    boxes = SEG.boxes()
    middle = (MESH.bounds[0] + MESH.bounds[1]) / 2
    np.testing.assert_allclose(rows[:, :3] + middle, boxes["center"].tolist(), atol=1e-6)
    lengths = 2 * np.linalg.norm(rows[:, 3:].reshape(-1, 3, 3), axis=2)
    np.testing.assert_allclose(lengths, boxes["size"].tolist(), atol=1e-6)
    view.set_segments(np.zeros(MESH.n_faces, int))
    assert len(view._segment_box) == 48
    view.close()
