"""What a view shows for the moment: coarse results, and a family of granularities with stable colours."""

import numpy as np
import pytest
import shapes

import scenewidget as sw

SMALL = sw.Params(n_segments=6, n_runs=4, n_graph_runs=4, k_range=(12, 20), min_area=0.0)


@pytest.fixture(scope="module")
def room():
    mesh, _ = shapes.room(10, noise=0.003)
    pipe = sw.Pipeline(mesh)
    return mesh, pipe.run(SMALL), pipe.family(SMALL)


@pytest.fixture
def view(room):
    mesh, segmentation, _ = room
    view = sw.SceneView(mesh)
    view.set_segments(segmentation.labels, levels={"final": segmentation.labels})
    return view


def sent(view, name):
    header = view._headers[name]
    return np.frombuffer(getattr(view, f"_{name}"), header["dtype"]).reshape(header["shape"])


def test_a_preview_covers_the_segments_and_leaves_them_alone(view, room):
    _, _, family = room
    before = (view.revision, view.n_segments, view._atom_segment, view.segment_colors.tolist())
    other = family.cut(family.most)
    view.show_preview(other.items, other.item_labels)
    assert view._is_preview
    shown = sent(view, "preview_segment")[sent(view, "face_item")]
    np.testing.assert_array_equal(shown, other.labels)
    view.end_preview()
    assert not view._is_preview
    assert (view.revision, view.n_segments, view._atom_segment, view.segment_colors.tolist()) == before


def test_a_preview_of_what_is_shown_has_its_colours(view, room):
    _, segmentation, _ = room
    view.show_preview(segmentation.items, segmentation.item_labels)
    np.testing.assert_array_equal(sent(view, "preview_colors"), view.segment_colors)


def test_the_items_of_faces_are_sent_once(view, room):
    _, segmentation, family = room
    view.show_preview(segmentation.items, segmentation.item_labels)
    first = view._face_item
    view.show_preview(segmentation.items, family.cut(family.least).item_labels)
    assert view._face_item is first


def test_the_browser_can_cut_the_family_as_python_does(view, room):
    _, _, family = room
    view.set_family(family)
    piece, merges = sent(view, "face_piece"), sent(view, "family_merges").reshape(-1, 2)
    for n in (family.least, family.segmentation.n_segments, family.most):
        group = np.arange(family.most)
        for kept, gone in merges[: family.most - n][::-1]:
            group[gone] = group[kept]
        shown = group[piece]
        pairs = np.unique(np.stack([shown, family.cut(n).labels]), axis=1)
        assert pairs.shape[1] == n == len(np.unique(shown))


def test_in_the_family_the_segments_shown_keep_their_colours(view, room):
    _, segmentation, family = room
    view.set_family(family)
    colors, group = sent(view, "family_colors"), family.groups(segmentation.n_segments)
    piece = sent(view, "face_piece")
    np.testing.assert_array_equal(colors[group[piece]], view.segment_colors[segmentation.labels])


def test_in_no_cut_do_neighbours_have_one_colour(view, room):
    mesh, _, family = room
    view.set_family(family)
    colors, piece = sent(view, "family_colors"), sent(view, "face_piece")
    pairs = family.segmentation.items.pairs
    for n in range(family.least, family.most + 1):
        group = family.groups(n)
        ends = group[family.piece[pairs]]
        ends = ends[ends[:, 0] != ends[:, 1]]
        assert (colors[ends[:, 0]] != colors[ends[:, 1]]).any(axis=1).all(), n
    assert len(piece) == mesh.n_faces


def test_a_saved_page_leaves_previews_out(view, room, tmp_path):
    _, segmentation, family = room
    view.set_family(family)
    view.show_preview(segmentation.items, segmentation.item_labels)
    assert "family_merges" not in view.to_html(tmp_path / "view.html").read_text().split('id="bundle"')[0]
