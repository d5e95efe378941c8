"""Scenes in SceneNN's format, written here byte by byte, and what can be wrong with them."""

import numpy as np
import pytest
from scenenn_files import scenenn_ply

from scenewidget.datasets.scenenn import load_scenenn
from scenewidget.engine.mesh import MeshError

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0], [3, 0, 0]], dtype="f4")
FACES = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2], [4, 6, 5]]
LABELS = [8844, 8844, 8844, 8844, 17, 17, 5]
ANNOTATION = """<?xml version="1.0"?>
<scene>
  <label id="8844" color="1 2 3" text="chair 1" nyu_class="chair" aabbox="0 0 0 1 1 0"/>
  <label id="17" text="" nyu_class="wall"/>
  <label id="5" text="" nyu_class=""/>
  <label id="99" text="seen by nobody" nyu_class="lamp"/>
</scene>
"""


def write_scene(folder, name="016", annotation=ANNOTATION, **options):
    """``016.ply`` and ``016.xml`` in a folder; the path of the first."""
    ply = folder / f"{name}.ply"
    ply.write_bytes(scenenn_ply(VERTICES, FACES, LABELS, **options))
    if annotation is not None:
        (folder / f"{name}.xml").write_text(annotation, encoding="utf-8")
    return ply


@pytest.mark.parametrize("layout", ["<", ">", ""])
@pytest.mark.parametrize("label_type", ["ushort", "uint", "float"])
def test_scene_comes_with_its_objects_by_name(tmp_path, layout, label_type):
    mesh, truth = load_scenenn(write_scene(tmp_path, layout=layout, label_type=label_type))
    np.testing.assert_array_equal(mesh.faces, FACES)
    np.testing.assert_allclose(mesh.vertices, VERTICES)
    assert mesh.vertex_colors[0].tolist() == [200, 100, 50]
    # two corners decide; in the last face 17, 17 and 5; label 5 has an entry but no name
    assert [truth.names[k] for k in truth.labels] == ["chair 1", "chair 1", "wall", "chair 1", "wall"]
    assert truth.n_segments == 2


def test_vertices_that_nobody_named_are_unlabeled_unless_wanted(tmp_path):
    ply = write_scene(tmp_path, annotation='<a><label id="8844" text="chair"/></a>')
    _, truth = load_scenenn(ply)
    assert (truth.labels < 0).tolist() == [False, False, True, False, True]
    _, every = load_scenenn(ply, unnamed="segments")
    assert every.coverage == 1
    assert sorted(every.names) == ["", "chair"]


def test_three_different_corners_go_to_the_middle_id(tmp_path):
    ply = tmp_path / "1.ply"
    ply.write_bytes(scenenn_ply(VERTICES[:3], [[0, 1, 2]], [30, 10, 20]))
    _, truth = load_scenenn(ply)
    assert truth.n_segments == 1
    (tmp_path / "1.xml").write_text(
        "<a>" + "".join(f'<label id="{k}" text="o{k}"/>' for k in (10, 20, 30)) + "</a>"
    )
    assert load_scenenn(ply)[1].names == ("o20",)


def test_without_an_annotation_each_label_is_a_segment(tmp_path):
    _, truth = load_scenenn(write_scene(tmp_path, annotation=None))
    assert truth.n_segments == 2
    assert truth.names == ("", "")
    assert truth.coverage == 1


def test_annotation_may_lie_elsewhere(tmp_path):
    ply = write_scene(tmp_path, annotation=None)
    other = tmp_path / "names.xml"
    other.write_text(ANNOTATION)
    assert "chair 1" in load_scenenn(ply, other)[1].names


def test_elements_before_the_vertices_are_passed_over(tmp_path):
    lead = "element camera 2\nproperty float fx\nproperty uchar kind\n"
    ply = tmp_path / "016.ply"
    data = scenenn_ply(VERTICES, FACES, LABELS, lead=lead)
    head, body = data.split(b"end_header\n", 1)
    ply.write_bytes(head + b"end_header\n" + b"\0" * 10 + body)
    assert load_scenenn(ply)[1].n_segments == 2


# --- damage ---------------------------------------------------------------------------------------


def test_missing_files_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"016\.ply"):
        load_scenenn(tmp_path / "016.ply")
    ply = write_scene(tmp_path)
    with pytest.raises(FileNotFoundError, match=r"annotation file .*gone\.xml' does not exist"):
        load_scenenn(ply, tmp_path / "gone.xml")


def test_a_file_without_labels_is_no_annotated_scene(tmp_path):
    ply = tmp_path / "016.ply"
    ply.write_bytes(scenenn_ply(VERTICES, FACES, LABELS).replace(b"ushort label", b"ushort thing"))
    with pytest.raises(MeshError, match="has no property 'label' on its vertices, only x, y, z"):
        load_scenenn(ply)
    with pytest.raises(MeshError, match=r"a scene of SceneNN is a \.ply file, got '016\.obj'"):
        load_scenenn(tmp_path / "016.obj")


@pytest.mark.parametrize("length", [10, 200, 420, 520, -7])
def test_truncated_files_are_refused(tmp_path, length):
    ply = tmp_path / "016.ply"
    ply.write_bytes(scenenn_ply(VERTICES, FACES, LABELS)[:length])
    with pytest.raises(MeshError, match=r"016\.ply"):
        load_scenenn(ply)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"end_header\n", b"end_header of sorts\n"),
        (b"property ushort label", b"property quark label"),
        (b"element vertex 7", b"element vertex"),
        (b"element vertex 7", b"element vertex many"),
        (b"binary_little_endian", b"binary_middle_endian"),
        (b"element vertex 7", b"element vertex 7000000000"),
    ],
)
def test_damaged_headers_are_refused(tmp_path, old, new):
    ply = tmp_path / "016.ply"
    ply.write_bytes(scenenn_ply(VERTICES, FACES, LABELS).replace(old, new))
    with pytest.raises(MeshError, match=r"016\.ply"):
        load_scenenn(ply)


def test_labels_must_be_whole_numbers(tmp_path):
    ply = tmp_path / "016.ply"
    ply.write_bytes(scenenn_ply(VERTICES, FACES, np.array(LABELS) + 0.5, label_type="float"))
    with pytest.raises(MeshError, match="labels that are not whole numbers"):
        load_scenenn(ply)
    ply.write_bytes(scenenn_ply(VERTICES, FACES, LABELS, layout="").replace(b" 8844\n", b" nothing\n"))
    with pytest.raises(MeshError, match=r"016\.ply"):
        load_scenenn(ply)


BOMB = """<?xml version="1.0"?>
<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;&x;&x;&x;&x;&x;"><!ENTITY z "&y;&y;&y;&y;&y;&y;&y;&y;">]>
<a><label id="8844" text="&z;"/></a>"""
FILE = (
    """<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/hostname">]><a><label id="8844" text="t">&x;</label></a>"""
)


@pytest.mark.parametrize(
    ("annotation", "message"),
    [
        (BOMB, "016.xml' declares a DOCTYPE"),
        (FILE, "016.xml' declares a DOCTYPE"),
        ("", "016.xml' is damaged or not XML"),
        ("<a><label id='8844'", "016.xml' is damaged or not XML"),
        ('<?xml version="1.0" encoding="klingon"?><a/>', "016.xml' is damaged or not XML"),
        ("<a><thing id='8844'/></a>", "holds no <label id=…> below its root"),
        ("<a><label id='first'/></a>", "has a label with id 'first'; ids must be whole numbers"),
        ("<a><label text='chair'/></a>", "has a label with id ''"),
        ("<a><label id='1'/><label id='1'/></a>", "has two labels with id 1"),
        ("<a><label id='1' text='x'/></a>", "names 1 labels, but none of the 2 in '016.ply'"),
    ],
)
def test_damaged_or_foreign_annotations_are_refused(tmp_path, annotation, message):
    ply = write_scene(tmp_path, annotation=annotation)
    with pytest.raises(MeshError, match=message):
        load_scenenn(ply)


def test_a_bomb_in_another_encoding_is_refused_too(tmp_path):
    ply = write_scene(tmp_path)
    (tmp_path / "016.xml").write_bytes(BOMB.replace('"1.0"', '"1.0" encoding="utf-16"').encode("utf-16"))
    with pytest.raises(MeshError, match="DOCTYPE"):
        load_scenenn(ply)


def test_an_annotation_of_absurd_size_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr("scenewidget.datasets.scenenn.MAX_XML_BYTES", 100)
    with pytest.raises(MeshError, match="an annotation of SceneNN has at most 100"):
        load_scenenn(write_scene(tmp_path))


def test_options_are_checked(tmp_path):
    with pytest.raises(ValueError, match="unnamed must be 'unlabeled' or 'segments', got 'drop'"):
        load_scenenn(write_scene(tmp_path), unnamed="drop")
