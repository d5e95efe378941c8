"""Files as other programs write them: one of each kind that was once misread or refused."""

import json
import re
import struct

import numpy as np
import pytest

import scenewidget as sw
from scenewidget.engine.mesh import MeshError
from scenewidget.engine.readers import load

PLACES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
RED, GREEN, BLUE, WHITE = [255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]
HUES = [RED, GREEN, BLUE, WHITE]
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
TEXTURED = SQUARE + "vt .25 .75\nvt .75 .75\nvt .75 .25\nvt .25 .25\nusemtl m\nf 1/1 2/2 3/3 4/4\n"


def written(folder, name, data):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


def picture(folder, name):
    from PIL import Image

    path = folder / name
    path.parent.mkdir(exist_ok=True)
    pixels = np.array([[RED, GREEN], [WHITE, BLUE]], dtype=np.uint8).repeat(4, axis=0).repeat(4, axis=1)
    Image.fromarray(pixels).save(path, "png")


@pytest.mark.parametrize(
    ("head", "library", "content", "texture"),
    [
        ("mtllib b.mtl a.mtl\n", "a.mtl", "map_Kd t.png", "t.png"),
        ("mtllib mats/a.mtl\n", "mats/a.mtl", "map_Kd t.png", "mats/t.png"),
        ("mtllib mats/a.mtl\n", "mats/a.mtl", "map_Kd ../tex/t.png", "tex/t.png"),
        ("mtllib a.mtl\n", "a.mtl", "map_Kd Textures\\T.PNG", "textures/t.png"),
        ("\ufeffmtllib a.mtl\n", "a.mtl", "map_Kd t.png", "t.png"),
        ("", "scan.mtl", "map_Kd t.png", "t.png"),
    ],
)
def test_materials_are_found_where_people_put_them(tmp_path, head, library, content, texture):
    written(tmp_path, "b.mtl", "newmtl other\nKd 1 0 0\n")
    written(tmp_path, library, f"newmtl m\n{content}\n")
    picture(tmp_path, texture)
    assert load(written(tmp_path, "scan.obj", head + TEXTURED)).vertex_colors.tolist() == HUES


@pytest.mark.parametrize(
    "text",
    [
        SQUARE + "vc 255 0 0\nvc 0 255 0\nvc 0 0 255\nvc 255 255 255\nf 1//1/1 2//1/2 3//1/3\n",
        SQUARE.replace("v", "V") + "vc 1 0 0 1\nvc 0 1 0 1\nvc 0 0 1 1\nvc 1 1 1 1\nF 1 2 3\n",
        "#MRGB ffff0000FF00ff00\n" + SQUARE + "#MRGB ff0000ff\r\n#MRGB 00ffffff\nf 1 2 3\n",
    ],
    ids=["vc", "capitals", "#MRGB"],
)
def test_colours_of_an_obj_in_lines_of_their_own(tmp_path, text):
    assert load(written(tmp_path, "a.obj", text)).vertex_colors.tolist() == HUES
    short = re.sub(r"vc [^\n]*\n|#MRGB ffff0000FF00ff00", "", text, count=1)
    with pytest.warns(UserWarning, match="for 4 vertices: "):
        assert load(written(tmp_path, "a.obj", short)).vertex_colors is None


def test_light_in_the_materials_of_an_obj(tmp_path):
    picture(tmp_path, "t.png")
    for content in ("Kd 0 0 0\nmap_Ke t.png", "map_Ke t.png\nmap_Kd t.png"):
        written(tmp_path, "a.mtl", f"newmtl m\n{content}\n")
        assert load(written(tmp_path, "a.obj", "MTLLIB a.mtl\n" + TEXTURED)).vertex_colors.tolist() == HUES
    for content, color in (
        ("Kd 0 0 0\nKe 0 1 0", GREEN),
        ("Kd 1 0 0\nKe 0 1 0", RED),
        ("Kd 0 0 1\nKe 0 0 0", BLUE),
    ):
        written(tmp_path, "a.mtl", f"newmtl m\n{content}\n")
        mesh = load(written(tmp_path, "a.obj", f"mtllib a.mtl\n{SQUARE}USEMTL m\nf 1 2 3 4\n"))
        assert (mesh.vertex_colors == color).all()


def test_the_only_material_counts_where_faces_name_none_and_of_several_none_does(tmp_path):
    picture(tmp_path, "t.png")
    written(tmp_path, "scan.mtl", "newmtl m\nmap_Kd t.png\n")
    text = "mtllib scan.mtl\n" + TEXTURED.replace("usemtl m\n", "")
    assert load(written(tmp_path, "scan.obj", text.encode("utf-16"))).vertex_colors.tolist() == HUES
    written(tmp_path, "scan.mtl", "newmtl m\nmap_Kd t.png\nnewmtl n\nKd 1 0 0\n")
    mesh = load(written(tmp_path, "scan.obj", text))
    assert mesh.vertex_colors is None
    assert "faces name none of the library's 2 materials: colours are lost" in mesh.report


def test_faces_of_a_ply_without_a_list_of_corners_are_missed_aloud(tmp_path):
    head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 1\nproperty int v1\nproperty int v2\nproperty int v3\nend_header\n"
    with pytest.warns(UserWarning, match="its faces have no list of corners and were left out"):
        assert load(written(tmp_path, "a.ply", head + "1 2 3\n0 0 0\n")).is_cloud


def test_names_in_latin_letters_and_remarks_behind_numbers(tmp_path):
    written(tmp_path, "a.mtl", "newmtl T\u00fcr\nmap_Kd T\u00fcr.png\n".encode("latin-1"))
    picture(tmp_path, "T\u00fcr.png")
    text = "mtllib a.mtl\n" + TEXTURED.replace("usemtl m", "usemtl T\u00fcr").replace(
        "1 1 0", "1 1 0 # third"
    )
    mesh = load(written(tmp_path, "scan.obj", text.encode("latin-1")))
    assert mesh.vertex_colors.tolist() == HUES


@pytest.mark.parametrize("row", ["{v} {c} 1.0", "{v} 1.0 {c}"], ids=["alpha behind", "weight before"])
def test_seven_numbers_of_an_obj_vertex(tmp_path, row):
    colors = ["1 0 0", "0 1 0", "0 0 1", "0 .5 0"]
    lines = [row.format(v=line, c=c) for line, c in zip(SQUARE.splitlines(), colors)]
    mesh = load(written(tmp_path, "a.obj", "\n".join(lines) + "\nf 1 2 3 4\n"))
    assert mesh.vertex_colors.tolist() == [RED, GREEN, BLUE, [0, 128, 0]]


def gltf(material=None, *, node=None, primitive=None, generator="x"):
    """A square as glTF with its data in it."""
    data = np.asarray(PLACES, "<f4").tobytes() + np.array([0, 1, 2, 0, 2, 3], "<u4").tobytes()
    data += np.array([[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]], "<f4").tobytes()
    views = [{"buffer": 0, "byteOffset": a, "byteLength": b} for a, b in ((0, 48), (48, 24), (72, 32))]
    kinds = [
        {"componentType": code, "type": kind, "count": n}
        for code, kind, n in ((5126, "VEC3", 4), (5125, "SCALAR", 6), (5126, "VEC2", 4))
    ]
    shape = {"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, **(primitive or {})}
    content = {
        "asset": {"version": "2.0", "generator": generator}, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0], **(node or {})}],
        "meshes": [{"primitives": [shape | ({"material": 0} if material else {})]}],
        "accessors": [{"bufferView": k, **kind} for k, kind in enumerate(kinds)],
        "bufferViews": views, "buffers": [{"byteLength": len(data), "uri": "a.bin"}],
        "images": [{"uri": "T.PNG"}], "textures": [{"source": 0}],
    }  # fmt: skip
    return json.dumps(content | ({"materials": [material]} if material else {})), data


def read_gltf(folder, *args, **options):
    text, data = gltf(*args, **options)
    written(folder, "a.bin", data)
    picture(folder, "t.png")
    return load(written(folder, "a.gltf", text))


def test_light_in_the_picture_and_names_of_another_case_in_gltf(tmp_path):
    dark = {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}, "emissiveTexture": {"index": 0}}
    assert read_gltf(tmp_path, dark).vertex_colors[:4].tolist() == [RED, GREEN, BLUE, WHITE]


def test_base_colours_of_trimesh_are_bytes_for_screens_and_its_default_is_none(tmp_path):
    plain = {"pbrMetallicRoughness": {"baseColorFactor": [128 / 255, 64 / 255, 200 / 255, 1]}}
    mesh = read_gltf(tmp_path, plain, generator="https://github.com/mikedh/trimesh")
    np.testing.assert_allclose(mesh.vertex_colors[0], [128, 64, 200], atol=1)
    grey = {"baseColorFactor": [0.4, 0.4, 0.4, 1], "baseColorTexture": {"index": 0}}
    mesh = read_gltf(tmp_path, {"pbrMetallicRoughness": grey}, generator="https://github.com/mikedh/trimesh")
    assert mesh.vertex_colors[:4].tolist() == [RED, GREEN, BLUE, WHITE]


def test_hidden_nodes_and_morph_targets_of_gltf_are_said(tmp_path):
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}}
    mesh = read_gltf(tmp_path, node=hidden, primitive={"targets": [{"POSITION": 0}]})
    assert mesh.n_faces == 2
    assert "hides some of its nodes" in " ".join(mesh.report)
    assert "morph targets" in " ".join(mesh.report)


ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


def instanced(**attributes):
    """The square at the first of two nodes, drawn as often as the attributes say; and the second."""
    text, data = gltf()
    content = json.loads(text)
    given = {}
    for name, rows in attributes.items():
        array = np.asarray(rows, "<f4")
        given[name] = len(content["accessors"])
        view = {"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes}
        kind = {"bufferView": len(content["bufferViews"]), "componentType": 5126, "count": len(rows)}
        content["accessors"].append(kind | {"type": f"VEC{array.shape[1]}"})
        content["bufferViews"].append(view)
        data += array.tobytes()
    content["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": given}}
    content["nodes"][0]["translation"] = [0, 0, 9]
    content["extensionsUsed"] = content["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    content["buffers"][0]["byteLength"] = len(data)
    return content, data


def test_meshes_that_gltf_draws_many_times_are_many_parts(tmp_path):
    half = np.sqrt(0.5)
    turned = {"TRANSLATION": [[0, 0, 0], [2, 3, 0]], "ROTATION": [[0, 0, 0, 1], [0, 0, half, half]]}
    content, data = instanced(**turned, SCALE=[[1, 1, 1], [2, 2, 2]])
    written(tmp_path, "a.bin", data)
    mesh = load(written(tmp_path, "a.gltf", json.dumps(content)))
    x, y, z = np.asarray(PLACES, dtype=float).T
    many = np.stack([2 - 2 * y, 3 + 2 * x, 9 + 2 * z], axis=1)  # a quarter turn about z, twice as large
    np.testing.assert_allclose(mesh.vertices[4:8], many, atol=1e-6)
    assert mesh.n_faces == 6
    assert "drawn 2 times" in mesh.report[0]
    content, data = instanced(TRANSLATION=[[0, 0, 0], [2, 3, 0]], SCALE=[[1, 1, 1]])
    written(tmp_path, "a.bin", data)
    with pytest.raises(MeshError, match="as many translations as rotations"):
        load(written(tmp_path, "a.gltf", json.dumps(content)))


def test_extensions_that_may_be_ignored_are_said_aloud_where_shapes_have_them(tmp_path):
    text, data = gltf()
    content = json.loads(text) | {"extensionsUsed": ["ACME_bent", "ACME_sound"]}
    content["nodes"][0]["extensions"] = {"ACME_bent": {}}
    written(tmp_path, "a.bin", data)
    with pytest.warns(UserWarning, match="'ACME_bent' isn't read: shapes are as the file has them"):
        mesh = load(written(tmp_path, "a.gltf", json.dumps(content)))
    assert "the extension 'ACME_sound' isn't read: the scan is as the file has it without" in mesh.report


def ply(*lines, rows=ROWS, body=""):
    axes = [f"property float {axis}" for axis in "xyz"]
    head = ["ply", "format ascii 1.0", "element vertex 4", *axes, *lines, "end_header", ""]
    return "\n".join(head) + rows + body


@pytest.mark.parametrize("name", ["vertexIndices", "corner_list"])
def test_lists_of_corners_of_any_name(tmp_path, name):
    data = ply("element face 1", f"property list UCHAR int {name}", body="4 0 1 2 3\n# end\n")
    assert load(written(tmp_path, "a.ply", data)).n_faces == 2


def test_textures_of_a_ply_in_folders_and_none_named(tmp_path):
    rows = "0 0 0 .25 .75\n1 0 0 .75 .75\n1 1 0 .75 .25\n0 1 0 .25 .25\n"
    lines = (
        "property float s",
        "property float t",
        "element face 1",
        "property list uchar int vertex_indices",
    )
    picture(tmp_path, "tex/t.png")
    data = ply("comment TextureFile Tex/T.png", *lines, rows=rows, body="4 0 1 2 3\n")
    assert load(written(tmp_path, "a.ply", data)).vertex_colors.tolist() == HUES
    mesh = load(written(tmp_path, "a.ply", ply(*lines, rows=rows, body="4 0 1 2 3\n")))
    assert "names no texture" in mesh.report[0]


def test_packed_colours_and_normals_that_are_none(tmp_path):
    lines = ["property uint rgba", *(f"property float n{axis}" for axis in "xyz")]
    packed = [(255 << 24) | r << 16 | g << 8 | b for r, g, b in HUES]
    rows = "".join(f"{row} {c} 0 0 0\n" for row, c in zip(ROWS.splitlines(), packed))
    cloud = load(written(tmp_path, "a.ply", ply(*lines, rows=rows)))
    assert cloud.vertex_colors.tolist() == HUES
    assert cloud.given_normals is None


def test_points_without_a_normal_among_others_take_that_of_their_plane():
    x, y = np.meshgrid(np.arange(12) / 50, np.arange(12) / 50)
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    normals = np.tile([0.0, 0.0, -1.0], (len(points), 1))
    normals[::5] = np.nan
    np.testing.assert_allclose(sw.PointCloud(points, normals).face_normals[:, 2], -1, atol=1e-6)


@pytest.mark.parametrize(
    "data",
    [
        "off\n4 1 0\n" + ROWS + "4 0 1 2 3\n",
        "4 1\n" + ROWS + "4 0 1 2 3\n",
        "OFF\n4 2 0\n" + ROWS + "3 0 1 2 255 0 0\n3 0 2 3\n",
    ],
    ids=["small letters", "no keyword", "a colour at some faces"],
)
def test_off_as_people_write_it(tmp_path, data):
    mesh = load(written(tmp_path, "a.off", data))
    np.testing.assert_array_equal(mesh.vertices, PLACES)
    assert mesh.n_faces == 2
    if "255" in data:
        assert mesh.vertex_colors.tolist() == [RED, RED, RED, WHITE]
        assert "1 of 2 faces have no colour" in " ".join(mesh.report)


def test_off_without_faces_is_a_cloud(tmp_path):
    assert load(written(tmp_path, "a.off", "OFF\n4 0 0\n" + ROWS)).is_cloud


def test_stl_with_bytes_behind_and_on_one_line(tmp_path):
    face = struct.pack("<12fH", *[0.0] * 3, *PLACES[:3].ravel(), 0)
    mesh = load(written(tmp_path, "a.stl", bytes(80) + struct.pack("<I", 1) + face + b"\0\0\0"))
    assert mesh.report == ("3 bytes behind the last face were left out",)
    loop = "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 1 1 0 endloop endfacet"
    np.testing.assert_array_equal(
        load(written(tmp_path, "b.stl", f"solid x\r\n{loop}\r\nendsolid x")).vertices, mesh.vertices
    )


POINTS = np.round(np.random.default_rng(0).random((40, 3)) * 5, 3)
COLORS = np.random.default_rng(1).integers(0, 256, (40, 3))
NORMALS = np.tile([0, 0, 1], (40, 1))
SIGNALS = np.random.default_rng(2).integers(-2000, 2000, 40)
NUMBERS = np.arange(40) % 5


def table(*columns, mark=" "):
    rows = np.column_stack(columns).tolist()
    return "".join(mark.join(f"{value:g}" for value in row) + "\n" for row in rows)


SIGNALLED = np.column_stack([POINTS, SIGNALS, COLORS])
COLORED = table(POINTS, COLORS, mark=",")
TABLES = {
    "a.csv": "x,y,z,class,r,g,b\n"
    + table(POINTS, 0 * NUMBERS, COLORS, mark=",").replace(",0,", ",chair,", 1),
    "b.csv": "x,y,z,i,r,g,b\n" + re.sub(r"(?m)^(([^,]+,){3})[^,]+", r"\1", table(SIGNALLED, mark=",")),
    "c.csv": '"Points:0","Points:1","Points:2","RGB:0","RGB:1","RGB:2"\n' + COLORED,
    "d.csv": "Easting [m];Northing;Elevation;Red;Green;Blue\n" + COLORED.replace(",", ";").replace(".", ","),
    "e.csv": "pos_x,pos_y,pos_z,color_r,color_g,color_b\n" + COLORED,
    "a.pts": f"15\n{table(SIGNALLED[:15])}25\n{table(SIGNALLED[15:])}",
    "a.xyz": "# made on Monday, x first\n" + COLORED.replace(",", " ").replace("\n", "\n# more\n", 9),
    "b.xyz": table(POINTS, NORMALS, COLORS),
    "c.txt": table(POINTS, COLORS, NUMBERS),
    "d.txt": table(POINTS, COLORS, SIGNALS, NUMBERS),
    "e.txt": "% of Matlab\n" + table(POINTS, COLORS),
    "f.txt": ("x,y,z,r,g,b\n" + COLORED).encode("utf-16"),
}


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_points_as_programs_write_them(tmp_path, name):
    cloud = load(written(tmp_path, name, TABLES[name]))
    np.testing.assert_allclose(cloud.points, POINTS, atol=1e-9)
    np.testing.assert_array_equal(cloud.vertex_colors, COLORS)
    assert (cloud.given_normals is not None) == (name == "b.xyz")


def test_normals_that_all_look_up_are_no_colours(tmp_path):
    cloud = load(written(tmp_path, "a.xyz", table(POINTS, NORMALS)))
    np.testing.assert_array_equal(cloud.given_normals, NORMALS)
    assert cloud.vertex_colors is None


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.xyz", "1,234.5 2,345.6 3,456.7\n" * 3, "thousands with commas"),
        ("a.csv", "x,y,z,i\n1,2,3,\n1,2\n", "line 2 of its points has 2 columns, and 4 have names"),
        ("a.csv", "x,y,z,i\n1,2,lamp,\n", "is damaged: Unable to parse string"),
        ("a.pts", "2\n1 2 3\n1 2 3\n3\n1 2 3\n", "its blocks promise 5 points, 3 follow"),
    ],
)
def test_tables_that_would_mislead_are_refused(tmp_path, name, data, message):
    with pytest.raises(MeshError, match=message):
        load(written(tmp_path, name, data))


def test_pcd_of_old_and_colours_written_as_nan(tmp_path):
    head = (
        "VERSION .5\nCOLUMNS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 4\nHEIGHT 1\nPOINTS 4\nDATA ascii\n"
    )
    lost = head + "".join(f"{row} nan\n" for row in ROWS.splitlines())
    with pytest.warns(UserWarning, match="colours were written as NaN and are lost"):
        cloud = load(written(tmp_path, "a.pcd", lost))
    np.testing.assert_array_equal(cloud.points, PLACES)
    assert cloud.vertex_colors is None


@pytest.mark.parametrize("head", ["X (mm),Y (mm),Z (mm)", "x_mm,y_mm,z_mm", "x [mm],y [mm],z [mm]"])
def test_the_unit_in_the_names_of_a_table_is_said(tmp_path, head):
    path = written(tmp_path, "a.csv", head + "\n0,0,0\n1,0,2\n2,1,5\n")
    with pytest.warns(UserWarning, match='columns are in mm, as their names say: units="mm"'):
        assert load(path).n_faces == 3
    plain = load(written(tmp_path, "a.csv", "x (m),y (m),z (m)\n0,0,0\n1,0,2\n2,1,5\n"))
    assert not any("columns are in" in line for line in plain.report)


def test_a_ply_in_capitals_and_a_second_scene_of_gltf(tmp_path):
    head = "PLY\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    assert load(written(tmp_path, "a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")).n_faces == 1
    text, data = gltf()
    written(tmp_path, "a.bin", data)
    two = json.loads(text) | {"scenes": [{"nodes": [0]}, {"nodes": [1]}]}
    assert "the file holds 2 scenes" in load(written(tmp_path, "a.gltf", json.dumps(two))).report[0]
