from __future__ import annotations

import numpy as np
import pytest

import scenewidget as sw
from scenewidget.widget.border_lines import border_lines
from scenewidget.widget.scene_view import SceneView

MESH, TRUTH = sw.datasets.load_room()


def test_lines_run_along_borders_with_their_probability():
    lines = border_lines(TRUTH)
    borders = TRUTH.borders()
    drawn = np.unique(lines[np.isfinite(lines)])
    assert np.isin(drawn, np.append(borders["p_same"], 0.0)).all()
    row = borders.iloc[0]  # the most doubtful shows, whatever it meets
    at_it = lines == row["p_same"]
    assert at_it.any()
    assert set(TRUTH.labels[at_it].tolist()) == {row["first"], row["second"]}


def test_one_segment_has_no_lines():
    one = sw.Segmentation(MESH, np.zeros(MESH.n_faces, int))
    assert np.isnan(border_lines(one)).all()


def test_a_widget_draws_them_once_they_are_chosen():
    widget = sw.SceneWidget(MESH, sw.Params(n_items=800), autosave=False)
    widget.wait(120)
    assert widget.view.offers_borders
    assert widget.view._face_border == b""
    widget.view.color_by = "borders"
    widget.wait(60)
    codes = np.frombuffer(widget.view._face_border, np.uint16)
    np.testing.assert_array_equal(codes > 0, np.isfinite(border_lines(widget.session.segmentation)))


def test_lines_of_another_length_are_refused():
    with pytest.raises(ValueError, match=r"doubtful must have shape \(\d+,\), one a face, got \(3,\)"):
        SceneView(MESH).set_borders([0.1, 0.2, np.nan])
