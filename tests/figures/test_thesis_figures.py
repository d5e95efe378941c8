"""Figures 3.3, 4.4 and 5.1 of the thesis, in one call each."""

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.engine.dihedral import dihedral_partition

ROOM = shapes.room(20, noise=0.004)[0]
pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")  # a room so small makes the method say so


def titles(figure):
    return [drawing.title for drawing in figure.drawings]


def test_figure_3_3_has_a_simplified_scan_and_its_partitions():
    box = shapes.box(4)
    figure = sw.figures.dihedral_partitions(box)
    assert titles(figure) == ["192 faces", "6 partitions"]
    assert figure.png().startswith(b"\x89PNG")
    few, many = (sw.figures.dihedral_partitions(ROOM, n_items=500, n_slots=n) for n in (2, 400))
    assert titles(few)[1] != titles(many)[1]


def test_figure_5_1_has_the_partitions_of_the_raw_scan_and_of_the_simplified_one():
    figure = sw.figures.raw_and_simplified(ROOM, n_items=600)
    raw = len(np.unique(dihedral_partition(ROOM)))
    assert titles(figure)[0] == f"raw: {raw} partitions"
    assert titles(figure)[1].startswith("simplified: ")
    assert titles(figure)[1] != f"simplified: {raw} partitions"


def test_figure_4_4_has_three_features_with_two_costs():
    params = sw.Params.thesis(n_segments=8, n_items=400, n_runs=3)
    pipe = sw.Pipeline(ROOM)
    figure = sw.figures.features_and_costs(ROOM, params, pipeline=pipe)
    found = [pipe.run(params.replace(feature=f, cost_b=b, cost_exponent=c)).n_segments
             for f in ("uniform", "cotangent", "gps") for b, c in ((0.0, 1.0), (-1.0, 1.5))]  # fmt: skip
    names = [f"{f}, {c}" for f in ("δ_uni", "δ_cot", "GPS") for c in ("f1", "f2")]
    assert titles(figure) == [f"{name}: {n} segments" for name, n in zip(names, found)]
