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
    before, position = panel.object, panel.attributes["position"].array
    figure.redraw(figures.show(mesh, values=mesh.vertices[:, 1]))
    assert panel.object is before
    assert panel.attributes["position"].array is position
    np.testing.assert_allclose(
        panel.attributes["color"].array, figure.drawings[0].colors.reshape(-1, 3) / 255, atol=1e-6
    )
    figure.redraw(figures.show(mesh, values=mesh.vertices[:, 1], isolines=3))
    assert panel.object is not before
    with pytest.raises(ValueError, match="1 panels, got 2"):
        figure.redraw(figures.side_by_side([figure, figure]))
