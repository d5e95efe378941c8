import numpy as np
import pytest
import traitlets
from shapes import blob, box, icosphere, joined

import scenewidget as sw
from scenewidget.engine.features import heat_kernel_signature
from scenewidget.engine.operators import eigenbasis
from scenewidget.figures.spectral_explorer import SpectralExplorer, heat_from, low_pass


@pytest.fixture(scope="module")
def mesh():
    return blob(2)


@pytest.fixture
def explorer(mesh):
    return SpectralExplorer(mesh, k=30)


def positions(explorer):
    """Corners that the browser draws, (n_faces, 3, 3), where they are on the mesh."""
    (panel,) = explorer.figure.panels
    surface = panel.layers[0].attributes
    corners = surface["position"].array[surface["index"].array].reshape(-1, 3, 3)
    used = explorer.mesh.vertices[explorer.mesh.faces]
    return corners + 0.5 * (used.min(axis=(0, 1)) + used.max(axis=(0, 1)))


def test_eigenfunctions_are_those_of_the_engine(explorer, mesh):
    for kind in ("cotangent", "uniform"):
        explorer.laplacian = kind
        expected = eigenbasis(mesh, 30, laplacian=kind)
        explorer.index = 7
        np.testing.assert_array_equal(explorer.values, expected.vectors[:, 7])
        assert f"{expected.values[7]:.4g}" in explorer.figure.drawings[0].title


def test_low_pass_shapes_get_nearer_until_nothing_is_missing():
    ball = icosphere(1)
    basis = eigenbasis(ball, ball.n_vertices)
    distances = [
        np.linalg.norm(low_pass(basis, ball.vertices, k) - ball.vertices) for k in range(1, basis.k + 1)
    ]
    assert (np.diff(distances) <= 1e-9).all()
    assert distances[-1] == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(low_pass(basis, ball.vertices, 4), ball.vertices, atol=1e-9)  # l = 0 and 1
    np.testing.assert_allclose(low_pass(basis, np.full(ball.n_vertices, 3.0), 1), 3.0)


def test_the_browser_gets_the_low_pass_shape(explorer, mesh):
    explorer.mode = "low pass"
    explorer.n_functions = 9
    expected = low_pass(explorer.basis, mesh.vertices, 9)
    np.testing.assert_allclose(positions(explorer), expected[mesh.faces], atol=1e-5)
    np.testing.assert_allclose(explorer.values, np.linalg.norm(expected - mesh.vertices, axis=1))
    explorer.mode = "eigenfunction"
    np.testing.assert_allclose(positions(explorer), mesh.vertices[mesh.faces], atol=1e-5)


def test_heat_keeps_its_sum_and_agrees_with_the_signature_at_its_source(explorer):
    explorer.mode = "heat"
    basis = explorer.basis
    for vertex, t in ((3, 0.05), (40, 2.0)):
        explorer.source, explorer.time = vertex, t
        heat = explorer.values
        assert basis.mass @ heat == pytest.approx(1.0)
        assert heat[vertex] == pytest.approx(heat_kernel_signature(basis, np.array([t]))[vertex, 0])
    np.testing.assert_allclose(heat_from(basis, 3, 1e3), 1 / basis.mass.sum())


def test_heat_stays_on_its_piece():
    pieces = joined(icosphere(1), box(2), gap=3.0)
    heat = heat_from(eigenbasis(pieces, 40), 0, 0.2)
    assert abs(heat[icosphere(1).n_vertices :]).max() < 1e-9


def test_the_signature_is_that_of_the_engine(explorer):
    explorer.mode, explorer.time = "signature", 0.3
    expected = heat_kernel_signature(explorer.basis, np.array([0.3]))[:, 0]
    np.testing.assert_array_equal(explorer.values, expected)


def test_sliders_and_attributes_follow_each_other(explorer):
    explorer._sliders["index"].value = 5
    assert explorer.index == 5
    explorer.mode = "heat"
    assert explorer._mode.value == "heat"
    assert [name for name, s in explorer._sliders.items() if s.layout.display == ""] == ["time", "source"]
    before = explorer.figure.drawings[0]
    explorer.index = 6  # not shown now: nothing is drawn again
    assert explorer.figure.drawings[0] is before


def test_each_laplacian_keeps_a_time_of_its_own(explorer):
    first = explorer._sliders["time"]
    explorer.time = 0.3
    assert first.value == 0.3
    explorer.laplacian = "uniform"
    slider = explorer._sliders["time"]
    assert slider in explorer.children
    assert (first.value, slider.value) == (0.3, explorer.time)
    slider.value = 10**slider.max  # as a hand does it
    assert explorer.time == slider.value
    explorer.time = 1e6  # a script may go on where the slider ends
    assert explorer.time > slider.value == pytest.approx(10**slider.max)
    explorer.laplacian = "cotangent"
    assert explorer.time == 0.3
    assert len(explorer.children) == len(set(explorer.children))
    for one in (first, slider):  # else the page would round it, and have it drawn twice
        steps = (one.max - one.min) / one.step
        assert steps == pytest.approx(round(steps))


@pytest.mark.parametrize(
    ("name", "value"),
    [("index", 30), ("index", 0), ("n_functions", 31), ("source", 10**6), ("mode", "sound")],
)
def test_what_is_out_of_range_is_refused_and_changes_nothing(explorer, name, value):
    before = getattr(explorer, name)
    with pytest.raises(traitlets.TraitError):
        setattr(explorer, name, value)
    assert getattr(explorer, name) == before
    assert np.isfinite(explorer.values).all()


def test_a_double_click_moves_the_source_to_the_nearest_vertex(explorer, mesh):
    explorer.mode = "heat"
    (panel,) = explorer.figure.panels
    picker = panel.renderer.controls[-1]
    used = mesh.vertices[mesh.faces]
    middle = 0.5 * (used.min(axis=(0, 1)) + used.max(axis=(0, 1)))
    picker.faceIndex = 0
    picker.point = tuple(mesh.vertices[17] - middle + explorer.figure.stage.shift + 1e-4)
    assert explorer.source == 17


def test_large_meshes_are_simplified_and_it_says_so():
    explorer = SpectralExplorer(icosphere(4), k=5, max_faces=1_000)
    assert 800 < explorer.mesh.n_faces <= 1_000
    assert "simplified from 5120" in explorer._remark.value


def test_tiny_meshes_work():
    explorer = SpectralExplorer(box(1), k=100)
    assert repr(explorer) == "SpectralExplorer(12 faces, 8 eigenfunctions)"
    for mode in ("eigenfunction", "low pass", "heat", "signature"):
        explorer.mode = mode
        assert np.isfinite(explorer.values).all()


def test_it_displays_with_a_picture():
    bundle = SpectralExplorer(box(2))._repr_mimebundle_()
    assert {"text/plain", "image/png", "application/vnd.jupyter.widget-view+json"} <= set(bundle)


def test_it_is_public():
    assert sw.SpectralExplorer is SpectralExplorer


def test_without_a_mesh_it_starts_on_a_closed_shape_with_single_eigenvalues():
    explorer = SpectralExplorer(k=12)
    edges = np.sort(explorer.mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert explorer.mesh.n_faces <= 10_000
    assert explorer.basis.values[1] > 0
    assert (np.diff(explorer.basis.values) > 1e-3).all()


def test_of_several_pieces_it_takes_the_largest_and_says_so():
    large, crumb = icosphere(2), sw.Mesh([[5, 0, 0], [6, 0, 0], [5, 1, 0]], [[0, 1, 2]])
    explorer = SpectralExplorer(joined(crumb, large), k=10)
    assert explorer.mesh.n_faces == large.n_faces
    assert "the largest of 2 pieces" in explorer._remark.value
    assert explorer.index == 1
    assert explorer.basis.values[1] == pytest.approx(2.0, rel=0.05)  # l = 1 on the unit sphere


def test_loose_triangles_are_one_piece_where_they_touch():
    ball = icosphere(1)
    soup = sw.Mesh(ball.vertices[ball.faces].reshape(-1, 3), np.arange(3 * ball.n_faces).reshape(-1, 3))
    explorer = SpectralExplorer(soup, k=5)
    assert explorer.mesh.n_vertices == ball.n_vertices
    assert explorer._note == ""


def test_a_few_extremes_do_not_pale_the_rest(explorer, mesh):
    for mode in ("eigenfunction", "signature"):
        explorer.mode = mode
        scale = explorer.figure.drawings[0].scale
        ends = np.quantile(explorer.values, [0.01, 0.99])
        if mode == "eigenfunction":  # 0 in the middle, white
            ends = [-abs(ends).max(), abs(ends).max()]
        assert [scale.low, scale.high] == pytest.approx(ends)


def test_one_eigenpair_is_none():
    with pytest.raises(ValueError, match="k must be at least 2, got 1: the first eigenfunction is constant"):
        SpectralExplorer(box(1), k=1)


def test_another_laplacian_is_drawn_once():
    explorer = sw.SpectralExplorer(blob(), k=5)
    explorer.mode = "heat"
    drawn = []
    explorer.figure.redraw = drawn.append
    explorer.laplacian = "uniform"
    assert len(drawn) == 1
