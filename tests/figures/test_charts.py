"""Charts in two dimensions."""

import numpy as np
import pandas as pd
from shapes import grid_square

from scenewidget import figures
from scenewidget.engine.operators import eigenbasis


def test_charts_display_themselves():
    basis = eigenbasis(grid_square(6), 8)
    chart = figures.spectrum({"a": basis, "b": basis.values}, reference=basis.values, title="t")
    assert [text.get_text() for text in chart.axes[0].get_legend().get_texts()] == ["a", "b", "closed form"]
    for line in chart.axes[0].lines:
        np.testing.assert_allclose(line.get_ydata(), basis.values)
    assert chart._repr_mimebundle_()["text/plain"] == "Chart()"


def test_reliability_draws_a_dot_a_bin_and_says_how_far_off_they_are():
    table = pd.DataFrame({"confidence": [0.5, 0.9], "right": [0.6, 0.7], "share": [0.25, 0.75]})
    chart = figures.reliability({"a": table, "b": table.iloc[:1]}, title="t")
    lines = chart.axes[0].lines
    np.testing.assert_array_equal(lines[1].get_xydata(), [[0.5, 0.6], [0.9, 0.7]])
    assert lines[1].get_label() == "a: off by 0.175 on average"
    assert [bar.get_height() for bar in chart.axes[0].patches] == [0.25, 0.75]
    assert "image/png" in chart._repr_mimebundle_()


def test_coassociation_brings_equal_labels_together_largest_first():
    labels = np.array([4, 1, 4, -1, 1, 4])
    C = (labels[:, None] == labels).astype(float)
    image = figures.coassociation(C, labels).axes[0].images[0].get_array()
    blocks = np.zeros((6, 6))
    for start, end in ((0, 3), (3, 5), (5, 6)):
        blocks[start:end, start:end] = 1
    np.testing.assert_array_equal(image, blocks)
