"""What a cell shows of a figure, and what is sent when it changes."""

import base64
import io

import numpy as np
import pytest
from PIL import Image
from shapes import icosphere

from scenewidget import figures


def test_a_figure_carries_a_picture_a_widget_and_a_stable_text():
    bundle = figures.show(icosphere(1), title="ball")._repr_mimebundle_()
    assert bundle["text/plain"] == "Figure(1 panel)"
    assert "application/vnd.jupyter.widget-view+json" in bundle
    picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(bundle["image/png"]))).convert("RGB"))
    assert picture.shape == (406, 520, 3)
    assert (picture[26:] < 245).any(axis=2).mean() > 0.2


def test_redrawing_sends_only_what_differs():
    mesh = icosphere(2)
    figure = figures.show(mesh, values=mesh.vertices[:, 0])
    (panel,) = figure.panels
    (before,) = panel.layers
    position = before.attributes["position"].array
    figure.redraw(figures.show(mesh, values=mesh.vertices[:, 1]))
    assert panel.layers == [before]
    assert before.object.visible
    assert before.attributes["position"].array is position
    color = before.attributes["color"]
    assert color.normalized  # bytes that stand for 0 to 1
    index = before.attributes["index"].array  # a row a point, and each point once
    np.testing.assert_array_equal(color.array[index], figure.drawings[0].colors.reshape(-1, 3))
    assert len(color.array) == len(position) == mesh.n_vertices
    figure.redraw(figures.show(mesh, values=mesh.vertices[:, 1], points=[0]))
    assert panel.layers[0] is before
    assert list(panel.scene.children) == [layer.object for layer in panel.layers]
    mark = panel.layers[1]
    figure.redraw(figures.show(mesh, values=mesh.vertices[:, 1], points=[1]))
    assert panel.layers == [before, mark]
    assert before.attributes["position"].array is position
    figure.redraw(figures.show(mesh, values=mesh.vertices[:, 1]))
    assert panel.layers == [before, mark]
    assert (before.object.visible, mark.object.visible) == (True, False)
    figure.redraw(figures.show(icosphere(1)))
    assert panel.layers != [before]
    with pytest.raises(ValueError, match="1 panels, got 2"):
        figure.redraw(figures.side_by_side([figure, figure]))
