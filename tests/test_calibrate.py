from __future__ import annotations

import numpy as np
import shapes

import scenewidget as sw
from scenewidget.calibrate import Example, count_things, fit, fit_logistic, wrong_faces
from scenewidget.engine.doubt import LIMITS
from scenewidget.engine.pieces import make_pieces


def test_a_logistic_model_is_found_again():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(20_000, 2))
    p = 1 / (1 + np.exp(-(0.5 + 2 * x[:, 0] - x[:, 1])))
    free = [(-np.inf, np.inf)] * 2
    np.testing.assert_allclose(fit_logistic(x, p, np.ones(len(x)), free), [0.5, 2, -1], rtol=0.05)


def test_weights_keep_to_their_limits():
    x = np.linspace(-2, 2, 40)[:, None]
    rises = (x[:, 0] > 0).astype(float)
    assert fit_logistic(x, rises, np.ones(40), [(-np.inf, 0.0)])[1] == 0
    assert fit_logistic(x, rises, np.ones(40), [(1.0, 1.0)])[1] == 1


def test_wrong_faces_are_foreign_or_the_rest_of_a_thing():
    mesh = shapes.sheet(10, 1)
    labels = np.repeat([0, 1], 10).astype(np.int32)  # two triangles a cell
    truth = np.repeat([0, 0, 0, 0, 1, 0, 1, 1, 1, 1], 2)
    pieces = make_pieces(mesh, labels, np.zeros_like(labels))
    foreign, rest = wrong_faces(pieces, count_things(pieces, truth))
    np.testing.assert_array_equal(count_things(pieces, truth), [[8, 2], [2, 8]])
    np.testing.assert_array_equal(foreign, [[False, True], [True, False]])
    assert not rest.any()
    halves = make_pieces(mesh, np.repeat([0, 1, 2], [8, 4, 8]).astype(np.int32), np.zeros_like(labels))
    _, rest = wrong_faces(halves, count_things(halves, np.repeat([0, 1], [12, 8])))
    np.testing.assert_array_equal(rest, [[False, False], [True, False], [False, False]])


def test_the_fit_keeps_to_the_limits_of_the_models():
    mesh, truth = sw.datasets.load_room()
    seg = sw.segment(mesh, sw.Params(n_items=800))
    pieces = seg.find_doubt().pieces
    things = count_things(pieces, truth.labels)
    models = fit([Example(pieces, seg.keys, dict(seg.report["runs"]), things)])
    for name, limits in LIMITS.items():
        for weight, (low, high) in zip(getattr(models, name)[1:], limits, strict=True):
            assert low - 1e-9 <= weight <= high + 1e-9
