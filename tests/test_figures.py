import base64
import gc
import io

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from shapes import box, grid_square, icosphere, joined, tetrahedron

import scenewidget as sw
from scenewidget import figures
from scenewidget.datasets import analytic
from scenewidget.engine.operators import eigenbasis
from scenewidget.figures.drawing import UNLABELED, draw, lit
from scenewidget.figures.motion import displaced
from scenewidget.figures.picture import camera_for, color_bar
from scenewidget.figures.raster import FIELD_OF_VIEW, Camera, render
from scenewidget.figures.scale import color_scale
from scenewidget.figures.strokes import edge_segments, isoline_segments, needles, ribbons

RED, BLUE = [255, 0, 0], [0, 0, 255]


def flat_colors(n, color):
    return np.tile(np.array(color, np.uint8), (n, 3, 1))


def facing(triangles):
    """Triangles given in the picture's own axes (right, up, towards the camera), seen along −x."""
    right, up, towards = np.moveaxis(np.asarray(triangles, float), -1, 0)
    return np.stack([towards, right, up], axis=-1), Camera(0.0, 0.0, 10.0)


def half_height(distance):
    return distance * np.tan(np.radians(FIELD_OF_VIEW / 2))


# --- rasteriser ---------------------------------------------------------------------------------------


def test_a_triangle_covers_the_pixels_that_it_should():
    h = half_height(10.0)
    corners, camera = facing([[[-h, -h, 0], [h, -h, 0], [-h, h, 0]]])  # below the falling diagonal
    picture = render(corners, flat_colors(1, RED), camera, width=40, height=40, supersampling=1)
    row, column = np.indices((40, 40))
    is_red = (picture == RED).all(axis=2)
    np.testing.assert_array_equal(is_red, column <= row)
    assert (picture[~is_red] == 255).all()


def test_coverage_is_the_area_of_the_projection():
    rng = np.random.default_rng(0)
    h = half_height(10.0)
    for triangle in rng.uniform(-0.9 * h, 0.9 * h, (5, 3, 2)):
        corners, camera = facing(np.concatenate([triangle, np.zeros((3, 1))], axis=1)[None])
        picture = render(corners, flat_colors(1, [0, 0, 0]), camera, width=200, height=200)
        (a, b), (c, d) = triangle[1] - triangle[0], triangle[2] - triangle[0]
        expected = abs(a * d - b * c) / 2 * (100 / h) ** 2
        assert (1 - picture[..., 0] / 255).sum() == pytest.approx(expected, rel=0.02, abs=8)


def test_the_nearer_triangle_hides_the_farther_in_whatever_order():
    wide = [[-9, -9], [9, -9], [0, 9]]
    near, far = (np.column_stack([wide, np.full(3, towards)]) for towards in (2.0, -2.0))
    for order in ((near, far), (far, near)):
        corners, camera = facing(order)
        colors = np.concatenate([flat_colors(1, RED if layer is near else BLUE) for layer in order])
        assert (render(corners, colors, camera, width=20, height=20)[10, 10] == RED).all()


def test_triangles_that_cross_are_each_seen_where_they_are_nearer():
    corners, camera = facing(
        [
            [[-9, -9, -3], [9, -9, 3], [9, 9, 3]],
            [[-9, -9, -3], [9, 9, 3], [-9, 9, -3]],
            [[-9, -9, 0], [9, -9, 0], [0, 20, 0]],
        ]
    )
    colors = np.concatenate([flat_colors(2, RED), flat_colors(1, BLUE)])
    picture = render(corners, colors, camera, width=40, height=40)
    assert (picture[20, 5] == BLUE).all()
    assert (picture[20, 35] == RED).all()


def test_back_faces_are_hidden_on_demand():
    corners, camera = facing([[[-9, -9, 0], [0, 9, 0], [9, -9, 0]]])  # clockwise
    shown = render(corners, flat_colors(1, RED), camera, width=20, height=20)
    hidden = render(corners, flat_colors(1, RED), camera, width=20, height=20, hides_back=True)
    assert (shown[12, 10] == RED).all()
    assert (hidden == 255).all()


def test_colours_are_linear_on_the_triangle_also_in_perspective():
    corners, camera = facing([[[-1, -1, -4], [1, -1, 4], [-1, 1, -4]]])
    colors = np.array([[[0, 0, 0], [255, 255, 255], [0, 0, 0]]], np.uint8)
    picture = render(corners, colors, camera, width=400, height=400, background=(7, 0, 0), supersampling=1)
    # the point halfway between the first two corners is at depth 10, right 0, up -1
    row = int(200 + 200 / half_height(10.0)) - 1
    assert int(picture[row, 200, 0]) == pytest.approx(127, abs=3)


def test_triangles_behind_the_camera_and_none_at_all_leave_the_background():
    corners, camera = facing([[[-1, -1, 12], [1, -1, 12], [0, 1, 12]]])
    assert (render(corners, flat_colors(1, RED), camera, width=8, height=6) == 255).all()
    nothing = render(np.zeros((0, 3, 3)), np.zeros((0, 3, 3), np.uint8), camera, width=8, height=6)
    assert nothing.shape == (6, 8, 3)
    assert (nothing == 255).all()


@pytest.mark.parametrize("view", [(-60, 30), (10, 89), (200, -35)])
@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.8])
def test_the_camera_fits_everything_into_the_middle(view, aspect):
    points = box(3, size=(1, 2, 0.5)).vertices + np.array([0.3, 0.0, 0.1])
    camera = Camera.fitting(points, view, aspect)
    x, y, towards = ((points - camera.position) @ camera.axes.T).T
    half = -towards * np.tan(np.radians(FIELD_OF_VIEW / 2))
    across, up = x / half / aspect, y / half
    assert max(abs(across).max(), abs(up).max()) == pytest.approx(0.93, abs=0.02)
    assert across.min() == pytest.approx(-across.max(), abs=0.02)
    assert up.min() == pytest.approx(-up.max(), abs=0.02)


# --- strokes --------------------------------------------------------------------------------------------


def test_needles_reach_from_start_to_tip_and_face_outwards():
    starts, vectors = np.array([[1.0, 2, 3], [0, 0, 0]]), np.array([[0, 0, 2.0], [0, 0, 0]])
    triangles = needles(starts, vectors, 0.1)
    assert triangles.shape == (3, 3, 3)  # none for the vector without length
    assert np.isclose(triangles, [1, 2, 5]).all(axis=2).sum() == 3
    out = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (((triangles.mean(axis=1) - [1, 2, 3.5]) * out).sum(axis=1) > 0).all()


def test_isolines_lie_at_their_level_and_measure_its_length():
    mesh = grid_square(9)
    corners = mesh.vertices[mesh.faces]
    ends, triangle = isoline_segments(corners, corners[..., 0], np.array([0.25, 0.6]))
    np.testing.assert_allclose(np.unique(ends[..., 0].round(12)), [0.25, 0.6])
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(2.0)
    low, high = corners[triangle].min(axis=1), corners[triangle].max(axis=1)
    assert ((ends.mean(axis=1) >= low - 1e-12) & (ends.mean(axis=1) <= high + 1e-12)).all()


def test_isolines_leave_out_what_is_not_a_number():
    mesh = grid_square(4)
    corners = mesh.vertices[mesh.faces]
    values = np.where(corners[..., 1] > 0.4, np.nan, corners[..., 0])
    ends, _ = isoline_segments(corners, values, np.array([0.3]))
    assert np.isfinite(ends).all()
    assert ends[..., 1].max() <= 0.25


def test_every_edge_is_drawn_once():
    mesh = icosphere(2)
    ends, _ = edge_segments(mesh.faces, mesh.vertices[mesh.faces])
    assert len(ends) == mesh.n_faces * 3 // 2
    assert len(np.unique(np.sort(ends.round(9), axis=1).reshape(-1, 6), axis=0)) == len(ends)


def test_ribbons_have_their_width_lie_in_front_and_face_the_same_way():
    segments = np.array([[[0.0, 0, 0], [1, 0, 0]]]), np.array([0])
    one_side = ribbons(segments, np.array([[0.0, 0, 1]]), 0.1, both_sides=False)
    across = np.cross(one_side[:, 1] - one_side[:, 0], one_side[:, 2] - one_side[:, 0])
    np.testing.assert_allclose(across.sum(axis=0) / 2, [0, 0, 0.1], atol=1e-12)
    assert (one_side[..., 2] == 0.05).all()
    both = ribbons(segments, np.array([[0.0, 0, 1]]), 0.1, both_sides=True)
    across = np.cross(both[:, 1] - both[:, 0], both[:, 2] - both[:, 0])
    np.testing.assert_allclose(across[:, 2], [0.1, 0.1, -0.1, -0.1], atol=1e-12)


# --- colours --------------------------------------------------------------------------------------------


def test_the_colour_bar_ends_in_the_colours_of_the_ends():
    scale = color_scale(np.array([2.0, 5.0]))
    bar = color_bar(scale, 50)
    np.testing.assert_array_equal(bar[[0, -1]], scale.colors([2.0, 5.0]))
    np.testing.assert_array_equal(scale.colors([-100.0, 100.0]), bar[[0, -1]])
    assert scale.ticks() == ["2", "3.5", "5"]
    lightness = bar @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) > -1).all()


def test_numbers_of_both_signs_are_centred_at_zero():
    scale = color_scale(np.array([-1.0, 3.0]))
    assert (scale.low, scale.high) == (-3.0, 3.0)
    assert scale.colors([0.0]).min() > 230
    assert color_scale(np.array([-0.001, 3.0])).low == -0.001  # noise below zero is not a sign


def test_what_is_not_a_number_is_grey():
    colors = color_scale(np.array([0.0, 1.0])).colors([np.nan, np.inf])
    assert (colors == colors[:, :1]).all()


def test_constant_and_empty_values_have_a_scale():
    assert color_scale(np.full(3, 2.0)).colors(np.full(3, 2.0)).shape == (3, 3)
    assert color_scale(np.full(3, np.nan)).low == 0.0


def test_labels_take_distinct_colours_and_none_is_grey():
    mesh = box(4)
    side = np.abs(mesh.face_normals).argmax(axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    colors = draw(mesh, np.where(side == 5, -1, 10 * side)).colors
    facing = mesh.face_normals[:, None]
    for i in range(6):
        of_side = colors[side == i].reshape(-1, 3)
        assert len(np.unique(of_side, axis=0)) == 1  # one normal, one light, one colour
    grey = lit(np.tile(np.array(UNLABELED, np.uint8), (mesh.n_faces, 1, 1)), facing)
    np.testing.assert_array_equal(colors[side == 5][:, 0], grey[side == 5][:, 0])
    unlit = {tuple(colors[side == i][0, 0] / (colors[side == i][0, 0].max())) for i in range(6)}
    assert len(unlit) == 6


def test_values_at_vertices_and_at_faces_are_coloured_by_the_scale():
    mesh = tetrahedron()
    drawing = draw(mesh, values=[0.0, 1.0, 2.0, 3.0], smooth=False)  # as many vertices as faces: vertices
    assert drawing.scale is not None
    expected = lit(
        drawing.scale.colors(mesh.faces.astype(float)), mesh.face_normals[:, None].repeat(3, axis=1)
    )
    np.testing.assert_array_equal(drawing.colors, expected)
    by_face = draw(grid_square(2), values=np.arange(8.0))
    assert (by_face.colors == by_face.colors[:, :1]).all()


def test_light_falls_from_above():
    ball = icosphere(3)
    shade = draw(ball, smooth=True).colors[..., 0].mean(axis=1)
    assert shade[ball.face_centroids[:, 2] > 0.8].min() > shade[ball.face_centroids[:, 2] < -0.8].max()
    assert shade.min() > 0.5 * shade.max()


# --- drawings and figures ---------------------------------------------------------------------------------


def test_the_surface_comes_first_and_keeps_its_shape():
    mesh = icosphere(2)
    drawing = draw(
        mesh, values=mesh.vertices[:, 2], isolines=3, edges=True, vectors=mesh.vertices, points=[5]
    )
    assert drawing.n_surface == mesh.n_faces
    np.testing.assert_allclose(drawing.corners[: mesh.n_faces], mesh.vertices[mesh.faces], atol=1e-6)
    added = len(drawing.corners) - mesh.n_faces
    assert added > 3 * mesh.n_vertices + 8  # needles, a mark, and the ribbons
    assert len(drawing.colors) == len(drawing.corners)


def test_rooms_are_looked_into_and_things_are_not():
    inward = sw.Mesh(box(3).vertices, box(3).faces[:, ::-1])
    assert draw(inward).hides_back
    assert not draw(box(3)).hides_back
    assert not draw(grid_square(3)).hides_back
    assert not draw(inward, back_faces=True).hides_back


def test_a_large_mesh_is_drawn_simplified_and_says_so():
    mesh = icosphere(4)
    top = (mesh.face_centroids[:, 2] > 0).astype(int)
    drawing = draw(mesh, top, max_faces=500)
    assert 400 < drawing.n_surface <= 500
    assert "5\u2009120" in drawing.note
    # colours stay where they were: compare with the two colours of the full drawing, up to the light
    middle = drawing.corners.mean(axis=1)[:, 2]
    hue = drawing.colors[:, 0] / drawing.colors[:, 0].max(axis=1, keepdims=True)
    upper, lower = hue[middle > 0.2], hue[middle < -0.2]
    assert np.abs(upper - upper.mean(axis=0)).max() < 0.05
    assert np.abs(lower - lower.mean(axis=0)).max() < 0.05
    assert np.abs(upper.mean(axis=0) - lower.mean(axis=0)).max() > 0.1


def test_a_figure_carries_a_picture_a_widget_and_a_stable_text():
    bundle = figures.show(icosphere(1), title="ball")._repr_mimebundle_()
    assert bundle["text/plain"] == "Figure(1 panel)"
    assert "application/vnd.jupyter.widget-view+json" in bundle
    picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(bundle["image/png"]))).convert("RGB"))
    assert picture.shape == (406, 520, 3)
    assert (picture[26:] < 245).any(axis=2).mean() > 0.2


def test_side_by_side_shares_one_camera():
    row = figures.side_by_side([figures.show(icosphere(1)), figures.show(box(1, size=(5, 5, 5)))])
    first, second = row.panels
    assert first.renderer.camera is second.renderer.camera
    assert first.renderer.controls[0] is second.renderer.controls[0]
    assert repr(row) == "Figure(2 panels)"
    with pytest.raises(ValueError, match="at least one figure"):
        figures.side_by_side([])


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


def test_compare_shows_the_same_colours_for_the_same_parts():
    mesh = box(4)
    a = np.abs(mesh.face_normals).argmax(axis=1)
    renamed = np.array([7, 3, 5])[a]
    same = figures.compare(a, renamed, mesh)
    np.testing.assert_array_equal(same.drawings[0].colors, same.drawings[1].colors)
    assert same.drawings[2].title == "different: 0% of the area"
    other = np.where((a == 0) & (mesh.face_centroids[:, 0] > 0), 9, renamed)
    assert figures.compare(a, other, mesh).drawings[2].title == "different: 17% of the area"


def test_the_picture_shows_what_the_camera_sees():
    mesh = joined(box(1), box(1), gap=3.0)
    drawing = draw(mesh, np.repeat([0, 1], 12))
    picture = render(
        drawing.corners, drawing.colors, camera_for([drawing], (-90, 0), 2.0), width=200, height=100
    )
    left, right = picture[50, 40], picture[50, 160]
    assert (left != right).any()
    assert (picture[50, 100] == 255).all()


# --- vibration and charts ---------------------------------------------------------------------------------


def test_a_vibration_moves_each_point_along_its_normal_by_the_eigenfunction():
    ball = icosphere(3)
    moved = displaced(ball, 0.1 * ball.vertices[:, 2])
    np.testing.assert_allclose(
        np.linalg.norm(moved.vertices, axis=1), 1 + 0.1 * ball.vertices[:, 2], atol=2e-3
    )
    figure = figures.vibration(ball, ball.vertices, start=2, amplitude=0.1, title="φ{i}")
    (drawing,) = figure.drawings
    np.testing.assert_allclose(drawing.corners[: ball.n_faces], moved.vertices[ball.faces], atol=2e-3)
    assert drawing.title == "φ2"


def test_the_browser_swings_between_rest_and_the_displaced_mesh():
    sheet = grid_square(6)
    phi = eigenbasis(sheet, 4).vectors
    box_of = figures.vibration(sheet, phi, start=1, amplitude=0.2).widget
    panel, handles = box_of.children
    action, slider = handles.children
    mesh = action.localRoot
    rest = mesh.geometry.attributes["position"].array
    (morph,) = mesh.geometry.morphAttributes["position"]
    assert np.abs(morph.array - rest).max() == pytest.approx(0.2, abs=1e-6)
    height = phi[:, 1] / np.abs(phi[:, 1]).max() * 0.2
    np.testing.assert_allclose((morph.array - rest)[:, 2], height[sheet.faces].ravel(), atol=1e-6)
    slider.value = 3
    height = phi[:, 3] / np.abs(phi[:, 3]).max() * 0.2
    np.testing.assert_allclose((morph.array - rest)[:, 2], height[sheet.faces].ravel(), atol=1e-6)
    assert panel is not None


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


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: figures.show(m, labels=np.zeros(3, int)), r"labels must have shape \(8,\)"),
        (lambda m: figures.show(m, values=np.zeros(3)), r"values must have shape \(9,\)"),
        (lambda m: figures.show(m, vectors=np.zeros(9)), r"vectors must have shape \(9, 3\)"),
        (lambda m: figures.show(m, labels=np.zeros(8, int), values=np.zeros(8)), "one of them"),
        (lambda m: figures.show(m, values=np.zeros(8), colormap="rainbows"), "'rainbows'"),
        (lambda m: figures.show(m, values=np.zeros(8), low=2, high=1), "low must not be above high"),
        (lambda m: figures.show(m, points=[9]), r"points must lie in 0\.\.8"),
        (lambda m: figures.vibration(m, np.zeros(4)), "eigenfunction must have shape"),
        (lambda m: figures.vibration(m, np.zeros((9, 2)), start=2), r"start must lie in 0\.\.1"),
        (lambda m: figures.coassociation(np.zeros((2, 3))), "square"),
        (lambda m: figures.coassociation(np.eye(3), [0, 1]), r"labels must have shape \(3,\)"),
        (lambda m: analytic.square(3, triangulation="odd"), "'odd'"),
        (lambda m: analytic.paper_figure(7), "multiple of 10"),
        (lambda m: analytic.folded(m, "z", 0.5, 1.0), "'z'"),
    ],
)
def test_wrong_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(grid_square(2))


def test_wrong_kinds_are_named():
    with pytest.raises(TypeError, match="mesh must be a Mesh"):
        figures.show("room.ply")
    with pytest.raises(TypeError, match="labels must hold whole numbers"):
        figures.show(grid_square(2), labels=np.zeros(8))
    with pytest.raises(TypeError, match="points must be vertex numbers"):
        figures.show(grid_square(2), points=[0.5])


# --- progress -----------------------------------------------------------------------------------------


@pytest.fixture
def shown(monkeypatch):
    """(box, plain text) of each bar that a notebook would have shown."""
    from scenewidget.figures import progress

    boxes, seen = [], []

    class Box(progress.widgets.HBox):
        def __init__(self, *args, **options):
            super().__init__(*args, **options)
            boxes.append(self)

    monkeypatch.setattr(progress.widgets, "HBox", Box)
    monkeypatch.setattr(progress, "get_ipython", lambda: "a notebook")
    monkeypatch.setattr(
        progress, "display", lambda bundle, raw: seen.append((boxes[-1], bundle["text/plain"]))
    )
    return seen


def test_a_sweep_tells_how_far_it_is_and_leaves_no_trace(shown):
    seen = []
    for value in figures.sweep("abc", title="letters"):
        bar, text = shown[0][0].children
        seen.append((value, bar.value, bar.max, text.value))
    assert seen == [
        ("a", 0, 3, "letters 0 of 3"),
        ("b", 1, 3, "letters 1 of 3"),
        ("c", 2, 3, "letters 2 of 3"),
    ]
    (box, text), *others = shown
    assert (text, others, box.layout.display) == ("", [], "none")


def test_a_sweep_that_is_broken_off_takes_its_bar_away(shown):
    for _ in figures.sweep(range(3)):
        break
    gc.collect()
    assert shown[0][0].layout.display == "none"


def test_a_sweep_outside_of_a_notebook_shows_nothing(capsys):
    assert list(figures.sweep(iter([3, 1]))) == [3, 1]
    assert capsys.readouterr().out == ""
