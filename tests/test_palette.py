"""Neighbours look different to everyone, an edit leaves colours alone, and files have those of the screen."""

import numpy as np
import pytest
from shapes import box, grid_square
from sights import SIGHTS, neighbour_difference, seen

import scenewidget as sw
from scenewidget.engine.segmentation import Segmentation
from scenewidget.figures.drawing import label_colors
from scenewidget.palette import (
    UNLABELED,
    _differences,
    adjacent_segments,
    are_distinct,
    choose_colors,
    inherited_colors,
    keep_colors,
    label_rows,
    palette,
    segment_colors,
)
from scenewidget.widget.scene_view import SceneView


def test_segments_that_touch_look_different_to_everyone():
    mesh = grid_square(30)
    center = mesh.face_centroids
    labels = (6 * np.floor(6 * center[:, 0]) + np.floor(6 * center[:, 1])).astype(int)
    pairs = adjacent_segments(mesh.faces, labels, mesh.n_vertices)
    shares = np.bincount(labels) / len(labels)
    colors = choose_colors(36, pairs, shares)
    assert _differences()[colors[pairs[:, 0]], colors[pairs[:, 1]]].min() > 0.07
    assert len(set(colors.tolist())) > 30


def test_adjacent_segments_share_a_vertex():
    mesh = grid_square(4)
    labels = np.where(mesh.face_centroids[:, 0] > 0.5, 1, np.where(mesh.face_centroids[:, 1] > 0.5, 2, 0))
    pairs = adjacent_segments(mesh.faces, labels, mesh.n_vertices)
    assert {tuple(sorted(pair)) for pair in pairs.tolist()} == {(0, 1), (0, 2), (1, 2)}
    assert len(adjacent_segments(mesh.faces, np.full(32, -1), mesh.n_vertices)) == 0


def test_a_merged_segment_keeps_the_colour_of_its_larger_part():
    before, after = np.array([0, 0, 0, 1, 1, 2]), np.array([1, 1, 1, 1, 1, 0])
    assert inherited_colors(after, 2, before, np.array([30, 31, 32])).tolist() == [32, 30]


def test_the_larger_part_of_a_split_keeps_the_colour():
    before, after = np.array([0, 0, 0, 1]), np.array([2, 0, 0, 1])
    assert inherited_colors(after, 3, before, np.array([30, 31])).tolist() == [30, 31, -1]


def test_the_palette_has_distinct_colours():
    assert len({tuple(color) for color in palette().tolist()}) == len(palette()) >= 60


def test_who_sees_colours_poorly_can_tell_distinct_ones_apart():
    differences = _differences()
    assert not are_distinct(0, np.array([0]))
    near, far = np.argsort(differences[0])[[1, -1]]
    assert are_distinct(0, np.array([far]))
    assert are_distinct(0, np.array([near, far])) == (differences[0, near] >= 0.06)


@pytest.mark.parametrize("sight", SIGHTS)
def test_neighbours_in_a_scanned_room_differ_in_every_sight(sight):
    mesh, truth = sw.datasets.load_room()
    colors = palette()[label_rows(mesh, truth.labels)]
    least = 0.06 if sight == "tritanopia" else 0.1  # of 30,000 people one; the others, one man in twelve
    assert neighbour_difference(mesh, truth.labels, colors, sight) > least


def test_the_simulation_leaves_greys_and_takes_red_from_green():
    grey = np.array([[128, 128, 128]], np.uint8)
    red, green = np.array([[190, 60, 60], [90, 110, 40]], np.uint8)
    for sight in SIGHTS:
        assert np.abs(seen(grey, sight).astype(int) - grey).max() <= 1
    apart = [
        np.linalg.norm(seen(red, s).astype(int) - seen(green, s)) for s in ("all colours", "deuteranopia")
    ]
    assert apart[1] < 0.6 * apart[0]


# --- one palette for all --------------------------------------------------------------------------


@pytest.fixture
def sides():
    """A box with a segment a side, one side unlabeled."""
    mesh = box(4)
    return Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // 32 - 1)


def test_screen_figures_and_files_choose_the_same_colours(sides):
    view = SceneView(sides.mesh)
    view.set_segments(sides.labels, levels={"base": np.arange(192) // 8})
    np.testing.assert_array_equal(segment_colors(sides)[:-1], view.segment_colors)
    figure = label_colors(sides.labels, label_rows(sides.mesh, sides.labels))
    inside = sides.labels >= 0
    np.testing.assert_array_equal(figure[inside], view.segment_colors[sides.labels[inside]])
    assert tuple(segment_colors(sides)[-1]) == UNLABELED


def test_colours_in_use_stay_and_others_are_chosen_around_them(sides):
    keep_colors(sides, np.array([30, -1, 31, -1, 32]))
    colors = segment_colors(sides)
    np.testing.assert_array_equal(colors[[0, 2, 4]], palette()[[30, 31, 32]])
    assert len(np.unique(colors, axis=0)) == 6


@pytest.mark.parametrize("per", ["face", "vertex"])
def test_a_ply_has_the_colours_of_the_screen(sides, per, tmp_path):
    plyfile = pytest.importorskip("plyfile")
    view = SceneView(sides.mesh)
    view.set_segments(sides.labels, levels={})
    sw.export(sides, sides.mesh, tmp_path / "room.ply", per=per)
    rows = plyfile.PlyData.read(tmp_path / "room.ply")[per].data
    seen = np.stack([rows[name] for name in ("red", "green", "blue")], axis=1)
    shown = np.vstack([view.segment_colors, UNLABELED])
    np.testing.assert_array_equal(seen, shown[rows["instance"]])
