"""What the view sends to the browser, without a browser."""

from __future__ import annotations

import errno

import numpy as np
import pytest
from sent import array
from shapes import grid_square

import scenewidget as sw
from scenewidget.editing import files
from scenewidget.engine.mesh import Mesh
from scenewidget.widget import bundle
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.wire import UNLABELED


@pytest.fixture
def view() -> SceneView:
    return SceneView(grid_square(4))


@pytest.fixture
def quarters(view) -> np.ndarray:
    center = view.mesh.face_centroids
    return (2 * (center[:, 0] > 0.5) + (center[:, 1] > 0.5)).astype(np.int32)


# --- at the beginning ---


def test_a_coloured_scan_starts_in_its_colours():
    mesh = grid_square(2)
    colored = Mesh(mesh.vertices, mesh.faces, np.full((mesh.n_vertices, 3), 7, np.uint8))
    view = SceneView(colored)
    assert (view.color_by, SceneView(mesh).color_by) == ("scan", "shaded")
    np.testing.assert_array_equal(array(view, "vertex_colors"), colored.vertex_colors)
    assert SceneView(colored, color_by="shaded").color_by == "shaded"


def test_repr_is_short_and_deterministic(view, quarters):
    assert repr(view) == "SceneView(32 faces)"
    view.set_segments(quarters, levels={})
    assert repr(view) == "SceneView(32 faces, 4 segments)"


# --- segments ---


def test_tables_give_every_face_its_part_and_its_segment(view, quarters):
    fine = np.arange(32, dtype=np.int32) // 2
    segments = np.where(quarters == 3, -1, quarters)
    view.set_segments(segments, levels={"fine": fine, "final": quarters})
    atom = array(view, "face_atom")
    np.testing.assert_array_equal(array(view, "atom_part")[:, atom], [fine, quarters])
    np.testing.assert_array_equal(array(view, "atom_segment")[atom], segments.astype(np.uint32))
    assert (view.levels, view.level, view.n_segments) == (["fine", "final"], "final", 3)


def test_an_edit_sends_one_table_and_the_edited_colour(view, quarters):
    view.set_segments(quarters, levels={"final": quarters})
    atoms, colors = view._face_atom, view.segment_colors
    view.set_segments(np.where(quarters == 3, 1, quarters))
    assert view._face_atom is atoms
    np.testing.assert_array_equal(view.segment_colors, colors[:3])
    assert view.revision == 2


def test_an_edit_that_cuts_through_atoms_sends_new_ones(view, quarters):
    view.set_segments(quarters, levels={"final": quarters})
    colors = view.segment_colors
    cut = quarters.copy()
    cut[np.flatnonzero(quarters == 0)[0]] = 4
    view.set_segments(cut)
    np.testing.assert_array_equal(array(view, "atom_segment")[array(view, "face_atom")], cut)
    np.testing.assert_array_equal(view.segment_colors[:4], colors)
    assert view.levels == ["final"]


def test_what_is_hidden_stays_so_when_python_cuts_it(view, quarters):
    view.set_segments(quarters, levels={"quarters": quarters})
    view._hidden = [int(np.flatnonzero(quarters == 3)[0])]  # as a page tells
    cut = np.where((quarters == 3) & (np.arange(len(quarters)) % 2 == 1), 4, quarters)
    view.set_segments(cut)
    face_atom = array(view, "face_atom")
    hidden = np.isin(face_atom, face_atom[view._hidden])
    np.testing.assert_array_equal(hidden, quarters == 3)
    view.set_segments(quarters)  # which joins no atoms, so nothing changes
    np.testing.assert_array_equal(np.isin(face_atom, face_atom[view._hidden]), quarters == 3)


def test_confidence_is_one_number_a_segment(view, quarters):
    view.set_segments(quarters, levels={}, confidence=[0.5, 1, 0, 0.25])
    np.testing.assert_array_equal(array(view, "segment_confidence"), np.float32([0.5, 1, 0, 0.25]))
    np.testing.assert_array_equal(array(view, "atom_confidence"), [32768, 65535, 1, 16384])  # by atom
    message = r"confidence must have shape \(32,\), one a face, or \(4,\), one a segment, got \(3,\)"
    with pytest.raises(ValueError, match=message):
        view.set_segments(quarters, confidence=[1, 1, 1])
    with pytest.raises(ValueError, match=r"confidence must lie in 0\.\.1, got -1 to 2"):
        view.set_segments(quarters, confidence=[1, 1, 2, -1])
    view.set_segments(quarters)
    assert array(view, "segment_confidence").size == 0


def test_confidence_of_faces_becomes_means_over_the_area(quarters):
    mesh = grid_square(4)
    stretched = Mesh(mesh.vertices**2, mesh.faces)  # faces of different size
    view = SceneView(stretched)
    sure = np.random.default_rng(0).random(32)
    pairs = np.arange(32) // 2
    view.set_segments(np.where(quarters == 3, -1, quarters), levels={"pairs": pairs}, confidence=sure)
    areas = stretched.face_areas
    expected = [np.average(sure[pairs == i], weights=areas[pairs == i]) for i in range(16)]
    face_code = array(view, "atom_confidence")[array(view, "face_atom")]
    np.testing.assert_allclose((face_code - 1.0) / 65534, np.array(expected)[pairs], atol=1e-5)
    expected = [np.average(sure[quarters == i], weights=areas[quarters == i]) for i in range(3)]
    np.testing.assert_allclose(array(view, "segment_confidence"), expected, rtol=1e-6)


def test_answers_are_kept_for_the_pages_that_asked_last(view):
    for number in (1, 2):
        view.answer({"kind": "undo", "client": "a", "number": number})
    view.answer({"kind": "undo", "client": "a", "number": 1})
    assert view._answers == {"a": 2}
    view.answer({"kind": "undo"})
    for page in range(40):
        view.answer({"client": str(page), "number": 1})
    assert len(view._answers) == 32
    assert "a" not in view._answers
    assert "39" in view._answers


def test_a_segmentation_brings_its_labels_and_names(view, quarters):
    segmentation = sw.Segmentation.from_labels(view.mesh, quarters, names=("", "chair", "", ""))
    view.set_segments(segmentation)
    assert (view.n_segments, view.segment_names) == (4, {"1": "chair"})
    view.set_segments(segmentation, names={2: "table"})
    assert view.segment_names == {"2": "table"}


def test_labels_alone_need_no_levels(view, quarters):
    view.set_segments(quarters, names={2: "chair"})
    assert (view.levels, view.level, view.n_segments) == ([], "", 4)
    assert view.segment_names == {"2": "chair"}


def test_the_first_segments_are_shown_at_once_but_a_choice_is_kept(view, quarters):
    view.set_segments(quarters, levels={})
    assert view.color_by == "segments"
    view.color_by = "shaded"
    view.set_segments(quarters, levels={})
    assert view.color_by == "shaded"


def test_segments_can_be_taken_away(view, quarters):
    view.set_segments(quarters, levels={"final": quarters})
    view.clear_segments()
    assert (view.n_segments, view.levels, view._face_atom) == (0, [], b"")
    assert repr(view) == "SceneView(32 faces)"
    view.set_segments(quarters)
    assert view.n_segments == 4


def test_no_segment_at_all_is_drawn_grey(view):
    view.set_segments(np.full(32, -1), levels={})
    assert view.n_segments == 0
    assert (array(view, "atom_segment") == UNLABELED).all()


@pytest.mark.parametrize(
    ("labels", "error", "message"),
    [
        (np.zeros(31, int), ValueError, r"segments must have shape \(32,\), one label a face, got \(31,\)"),
        (np.zeros(32), TypeError, "segments must hold whole numbers, got dtype float64"),
        (np.full(32, -2), ValueError, r"segments must hold -1 \(unlabeled\) and up, got -2"),
        (np.full(32, 32), ValueError, "segments must be below the number of faces, 32, got 32"),
    ],
)
def test_wrong_labels_are_refused_before_anything_changes(view, labels, error, message):
    with pytest.raises(error, match=message):
        view.set_segments(labels, levels={})
    assert (view.revision, view._face_atom) == (0, b"")


def test_a_wrong_level_is_named(view, quarters):
    with pytest.raises(ValueError, match=r"levels\['base'\] must have shape"):
        view.set_segments(quarters, levels={"base": quarters[1:]})
    with pytest.raises(TypeError, match="levels must map names to labels, got list"):
        view.set_segments(quarters, levels=[quarters])
    view.level = "half"  # may be chosen before there are any
    view.set_segments(quarters, levels={"half": quarters // 2, "final": quarters})
    with pytest.raises(ValueError, match="level must be one of 'half', 'final', got 'base'"):
        view.level = "base"
    assert view.level == "half"


def test_names_must_be_of_segments_and_a_family_must_be_one(view, quarters):
    with pytest.raises(TypeError, match="names must map segments to names, got list"):
        view.set_segments(quarters, names=["wall"])
    assert view.revision == 0
    with pytest.raises(TypeError, match="family must be a Family or None, got int"):
        view.set_family(3)


# --- values ---


def test_values_run_over_the_colour_map_and_nan_is_none(view):
    values = np.linspace(2.0, 4.0, 32)
    values[5] = np.nan
    view.set_values(values, title="height")
    sent = array(view, "face_value")
    assert (sent[0], sent[-1], sent[5]) == (1, 65535, 0)
    assert view.color_by == "values"
    assert view.values_legend == {"title": "height", "low": 2.0, "high": 4.0}
    assert array(view, "colormap").shape == (256, 3)


def test_equal_values_and_no_values_are_drawn(view):
    view.set_values(np.full(32, 3.0))
    assert set(array(view, "face_value").tolist()) == {1}
    view.set_values(np.full(32, np.nan))
    assert set(array(view, "face_value").tolist()) == {0}


def test_wrong_values_are_refused(view):
    with pytest.raises(ValueError, match=r"values must have shape \(32,\)"):
        view.set_values(np.zeros(3))
    with pytest.raises(ValueError, match="colormap must be the name of a matplotlib colour map"):
        view.set_values(np.zeros(32), colormap="rainbow dash")
    with pytest.raises(ValueError, match="low must not be above high"):
        view.set_values(np.zeros(32), low=2, high=1)
    with pytest.raises(ValueError, match="both finite, got nan and 1"):
        view.set_values(np.ones(32), low=np.nan)
    with pytest.raises(TypeError, match="values must be numbers, got <U1"):
        view.set_values(["a"] * 32)
    assert view.color_by == "shaded"


# --- the door ---


def test_only_a_mesh_can_be_shown():
    with pytest.raises(TypeError, match="mesh must be a Mesh, got str"):
        SceneView("scan.ply")


@pytest.mark.parametrize(("height", "error"), [("tall", TypeError), (400.5, TypeError), (5, ValueError)])
def test_a_height_is_a_number_of_pixels(height, error):
    with pytest.raises(error, match=r"height must be .* pixels, got"):
        SceneView(grid_square(2), height=height)


def test_a_page_replaces_a_page_and_nothing_else(view, tmp_path):
    path = view.to_html(tmp_path / "view.html")
    assert view.to_html(path) == path
    path.write_text(path.read_text() + "<!-- by hand -->")
    with pytest.raises(FileExistsError, match="no export wrote it; choose another name, or replace it with"):
        view.to_html(path)
    assert view.to_html(path, overwrite=True) == path


def test_a_page_that_can_not_be_written_says_why_and_leaves_the_old_one(view, tmp_path, monkeypatch):
    path = view.to_html(tmp_path / "view.html")
    old = path.read_bytes()
    with pytest.raises(TypeError, match="path must be a str or a Path, got int"):
        view.to_html(3)
    with pytest.raises(TypeError, match="title must be a text, got int"):
        view.to_html(path, title=3)
    with pytest.raises(TypeError, match="overwrite must be True or False, got 'no'"):
        view.to_html(path, overwrite="no")
    with pytest.raises(ValueError, match=r"'view.png' is no name for a page.*to_html\('view.html'\)"):
        view.to_html(tmp_path / "view.png")
    with pytest.raises(FileNotFoundError, match="its folder does not exist; make it first"):
        view.to_html(tmp_path / "nowhere" / "view.html")
    full = OSError(errno.ENOSPC, "no space")
    monkeypatch.setattr(files.os, "fsync", lambda _: (_ for _ in ()).throw(full))
    with pytest.raises(OSError, match=r"disk is full.*is untouched"):
        view.to_html(path)
    assert (path.read_bytes(), [entry.name for entry in tmp_path.iterdir()]) == (old, ["view.html"])


def test_an_unknown_option_is_named_with_those_there_are():
    with pytest.raises(
        TypeError, match=r"no option 'colour'; there are: back_faces, boxes, busy, camera_group"
    ):
        SceneView(grid_square(2), colour="red")


def test_a_missing_bundle_says_what_to_do(monkeypatch, tmp_path):
    monkeypatch.setattr(bundle, "STATIC", tmp_path)
    bundle.bundled.cache_clear()
    try:
        with pytest.raises(FileNotFoundError, match=r"front end was not built.*pip install"):
            SceneView(grid_square(2))
    finally:
        bundle.bundled.cache_clear()


def test_the_bundle_is_part_of_the_state_of_a_saved_page(view):
    kept = view.get_manager_state(drop_defaults=True, widgets=[view])["state"][view.model_id]["state"]
    assert "scenewidget" in kept["_css"]
    assert len(kept["_esm"]) > 10_000


def test_labels_of_a_large_scan():
    mesh = grid_square(866)  # 1.5 million faces
    view = SceneView(mesh)
    x, y = mesh.face_centroids[:, 0], mesh.face_centroids[:, 1]
    levels = {str(n): (n * np.floor(n * x) + np.floor(n * y)).astype(np.int32) for n in (70, 22, 9)}
    view.set_segments(levels["9"], levels=levels)
    assert view.n_segments == 81
