"""Reading scans: every format gives its values in its own numbering, and damage is named."""

import io
import json
import random
import re
import struct
import warnings

import numpy as np
import pytest
import shapes
import trimesh
from PIL import Image

from scenewidget.engine.mesh import Mesh, MeshError, face_adjacency
from scenewidget.engine.readers import load, load_mesh

V = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
F = [[0, 1, 2]]


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def exported(mesh, suffix, **options):
    data = as_trimesh(mesh).export(file_type=suffix, **options)
    return data.encode() if isinstance(data, str) else data


def written(folder, name, data):
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


FORMATS = [("ply", {}), ("ply", {"encoding": "ascii"}), ("obj", {}), ("off", {}), ("stl", {}), ("glb", {})]


@pytest.mark.parametrize(("suffix", "options"), FORMATS)
def test_every_format_gives_the_faces_back_in_order(tmp_path, suffix, options):
    mesh = shapes.blob(2)
    read = load_mesh(written(tmp_path, f"mesh.{suffix}", exported(mesh, suffix, **options)))
    np.testing.assert_allclose(read.vertices[read.faces], mesh.vertices[mesh.faces], atol=1e-5)
    np.testing.assert_array_equal(face_adjacency(read), face_adjacency(mesh))


def test_vertex_colors_come_along(tmp_path):
    mesh, colors = shapes.box(1), np.arange(24, dtype=np.uint8).reshape(8, 3)
    coloured = as_trimesh(mesh)
    coloured.visual.vertex_colors = colors
    for suffix in ("ply", "glb"):
        read = load_mesh(written(tmp_path, f"a.{suffix}", coloured.export(file_type=suffix)))
        np.testing.assert_array_equal(read.vertex_colors[read.faces], colors[mesh.faces])
    np.testing.assert_array_equal(load_mesh(coloured).vertex_colors, colors)
    assert load_mesh(as_trimesh(mesh)).vertex_colors is None


def test_arrays_trimeshes_and_meshes_are_taken_as_they_are():
    mesh = shapes.box(1)
    assert load_mesh(mesh) is mesh
    for source in ((mesh.vertices, mesh.faces), as_trimesh(mesh)):
        np.testing.assert_array_equal(load_mesh(source).faces, mesh.faces)


def ply(n_vertices, n_faces, body, *, binary=False):
    kind = "binary_little_endian" if binary else "ascii"
    head = (
        f"ply\nformat {kind} 1.0\nelement vertex {n_vertices}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {n_faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return head.encode() + (body if binary else body.encode())


CORNERS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
BYTES = b"".join(struct.pack("<3f", *map(float, line.split())) for line in CORNERS.splitlines())


def test_polygons_are_cut_into_triangles(tmp_path):
    obj = "".join(f"v {line}\n" for line in CORNERS.splitlines())
    for name, data in (
        ("a.ply", ply(4, 1, CORNERS + "4 0 1 2 3\n")),
        ("b.ply", ply(4, 1, BYTES + struct.pack("<B4i", 4, 0, 1, 2, 3), binary=True)),
        ("a.obj", obj + "f 1 2 3 4\n"),
        ("b.obj", obj + "vt 0 0\nf -4/-1 -3/-1 -2/-1 -1/-1\n"),
        ("a.off", f"OFF\n4 1 0\n{CORNERS}4 0 1 2 3\n"),
    ):
        mesh = load_mesh(written(tmp_path, name, data))
        assert mesh.n_faces == 2
        assert mesh.face_areas.sum() == pytest.approx(1)
        np.testing.assert_allclose(mesh.face_normals, [[0, 0, 1]] * 2)


def test_materials_do_not_reorder_the_faces_of_an_obj(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\n"
    text += "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 2 5 3\n"
    mesh = load_mesh(written(tmp_path, "a.obj", text))
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]])
    expected = corners[[[0, 1, 2], [0, 2, 3], [1, 4, 2]]]
    np.testing.assert_allclose(mesh.vertices[mesh.faces], expected)


def test_negative_indices_of_an_obj_count_back_from_their_line(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 6 1 0\nf -3 -2 -1\nf 2 1 -1\n"
    mesh = load_mesh(written(tmp_path, "a.obj", text))
    np.testing.assert_allclose(mesh.vertices[mesh.faces][:, :, 0], [[0, 1, 1], [5, 6, 6], [1, 0, 6]])


def test_parts_of_a_scene_are_put_together_with_their_transforms(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box())
    scene.add_geometry(
        trimesh.creation.box(), transform=trimesh.transformations.translation_matrix([5, 0, 0])
    )
    mesh = load_mesh(written(tmp_path, "a.glb", scene.export(file_type="glb")))
    assert mesh.n_faces == 24
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(6)


GOOD = ply(4, 2, CORNERS + "3 0 1 2\n3 0 2 3\n")
GOOD_BINARY = ply(4, 2, BYTES + struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 0, 2, 3), binary=True)
GOOD_STL = exported(shapes.box(1), "stl")
GOOD_GLB = exported(shapes.box(1), "glb")
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.ply", b"", "is empty"),
        ("a.ply", "hello", "does not start with 'ply'"),
        ("a.ply", GOOD[:40], "truncated: its PLY header has no end"),
        ("a.ply", GOOD[:-5], "truncated: its header promises 2 of element 'face', 1 could be read"),
        ("a.ply", GOOD[:-8], "truncated: its header promises 2 of element"),
        ("a.ply", GOOD[: GOOD.index(b"1 1 0")], "truncated"),
        ("a.ply", GOOD_BINARY[:-1], "truncated"),
        ("a.ply", GOOD_BINARY[:-20], "truncated"),
        ("a.ply", ply(4, 5, CORNERS + "4 0 1 2 3\n" * 3), "promises 5 of element 'face', 3 could be read"),
        ("a.ply", ply(4, 10**12, BYTES, binary=True), "promises 1000000000000 of element 'face', but only"),
        ("a.ply", ply(10**9, 1, BYTES, binary=True), "promises 1000000000 of element 'vertex'"),
        ("a.ply", ply("-4", 1, CORNERS), "promises -4 of element 'vertex'"),
        ("a.ply", ply(4, 0, CORNERS), "holds no triangles, only points"),
        ("a.ply", ply(4, 1, CORNERS + "3 0 1 7\n"), "1 of 1 faces refer to a vertex that does not exist"),
        ("a.ply", ply(4, 1, CORNERS.replace("1 1 0", "1 nan 0") + "3 0 1 2\n"), "NaN, infinite or far"),
        ("a.obj", OBJ, "holds no triangles"),
        ("a.obj", OBJ + "f 1 2 9\n", "damaged"),
        ("a.obj", OBJ + "f 1 2 3\nf 1 2", "a face with fewer than three corners"),
        ("a.obj", OBJ + "f 0 1 2\n", "a face with vertex 0"),
        ("a.obj", OBJ + "f 1/1 0/1 2/1\n", "a face with vertex 0"),
        ("a.obj", "v 0 zero 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "damaged"),
        ("a.off", "OFF\n4 2 0\n" + CORNERS + "4 0 1 2 3\n", "promises at least 6 lines"),
        ("a.off", "OFF\n4 99999999999 0\n" + CORNERS + "4 0 1 2 3\n", "damaged or truncated"),
        ("a.stl", GOOD_STL[:-10], "promises 12 faces in 684 bytes, and it has 674"),
        ("a.stl", GOOD_STL[:80] + b"\xff\xff\xff\xff" + GOOD_STL[84:], "promises 4294967295 faces"),
        ("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "does not end with 'endsolid'"),
        ("a.glb", GOOD_GLB[:-30], "damaged"),
        ("a.glb", b"glTF", "damaged"),
        ("a.txt", "hello", "is a point cloud"),
        ("noending", "hello", "suffix must be one of"),
    ],
)  # fmt: skip
def test_a_damaged_file_is_refused_with_its_name(tmp_path, name, data, message):
    with pytest.raises(MeshError, match=message) as caught:
        load_mesh(written(tmp_path, name, data))
    assert name in str(caught.value) or "faces" in str(caught.value)


def test_a_missing_file_and_a_folder_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"mesh file .*nothing\.ply.* does not exist"):
        load_mesh(tmp_path / "nothing.ply")
    with pytest.raises(MeshError, match="is a folder"):
        load_mesh(tmp_path)


@pytest.mark.parametrize("source", [None, 3, [1], {"a": 1}, np.zeros((3, 3))])
def test_what_is_no_mesh_is_refused(source):
    with pytest.raises(TypeError, match=f"mesh must be a path.*got {type(source).__name__}"):
        load_mesh(source)


def test_a_tuple_of_three_is_refused():
    with pytest.raises(TypeError, match=re.escape("must be (vertices, faces), got 3 entries")):
        load_mesh((V, F, F))


def damaged(data, rng):
    """Cut short, bytes changed, numbers changed, bytes put in or taken out."""
    data = bytearray(data)
    way = rng.randrange(5)
    if way == 0:
        return bytes(data[: rng.randrange(len(data))])
    at = rng.randrange(len(data))
    if way == 1:
        for _ in range(rng.randrange(1, 20)):
            data[rng.randrange(len(data))] = rng.randrange(256)
    elif way == 2:
        for _ in range(rng.randrange(1, 6)):
            data[rng.randrange(min(600, len(data)))] = rng.choice(b"0123456789-. \n\x00\xff")
    elif way == 3:
        data[at:at] = rng.randbytes(rng.randrange(1, 50))
    else:
        del data[at : at + rng.randrange(1, 200)]
    return bytes(data)


@pytest.mark.parametrize(("suffix", "options"), FORMATS)
def test_damaged_bytes_give_a_mesh_or_a_mesh_error(tmp_path, suffix, options):
    good = exported(shapes.box(2), suffix, **options)
    rng = random.Random(0)
    for _ in range(150):
        path = written(tmp_path, f"a.{suffix}", damaged(good, rng))
        try:
            mesh = load_mesh(path)
        except MeshError:
            continue
        assert mesh.faces.max() < mesh.n_vertices


# --- kinds of real files ----------------------------------------------------------------------------

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float32)
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def picture(rows):
    """PNG of pixels given as rows of colours."""
    out = io.BytesIO()
    Image.fromarray(np.array(rows, dtype=np.uint8)).save(out, "png")
    return out.getvalue()


RED, GREEN, BLUE, GREY = [255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]
QUARTERS = picture(np.repeat(np.repeat([[RED, GREEN], [BLUE, GREY]], 8, axis=0), 8, axis=1))
UV = np.array([[0.0, 0.0], [1, 0], [1, 1], [0, 1]], dtype=np.float32)  # corners of the square, v downwards


class Glb:
    """A GLB put together by hand."""

    def __init__(self, generator="test", **content):
        self.data = b""
        self.content = {
            "asset": {"version": "2.0", "generator": generator}, "nodes": [], "meshes": [], "materials": [],
            "accessors": [], "bufferViews": [], "textures": [], "images": [], **content,
        }  # fmt: skip

    def add(self, kind, entry):
        self.content[kind].append(entry)
        return len(self.content[kind]) - 1

    def view(self, data):
        number = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data + b"\0" * (-len(data) % 4)
        return number

    def array(self, values, **more):
        values = np.asarray(values)
        kinds = {"f4": 5126, "u4": 5125, "u2": 5123, "u1": 5121, "i2": 5122, "i1": 5120}
        width = 1 if values.ndim == 1 else values.shape[1]
        return self.add(
            "accessors",
            {
                "bufferView": self.view(values.tobytes()), "componentType": kinds[values.dtype.str[1:]],
                "count": len(values), "type": ["", "SCALAR", "VEC2", "VEC3", "VEC4"][width], **more,
            },
        )  # fmt: skip

    def texture(self, data=None, **image):
        image = image or {"bufferView": self.view(data), "mimeType": "image/png"}
        return {"index": self.add("textures", {"source": self.add("images", image)})}

    def square(self, *, node=None, faces=HALVES, **attributes):
        """A node with the square; attributes are arrays or, for what isn't one, entries of the primitive."""
        primitive = {"attributes": {"POSITION": self.array(SQUARE)}}
        for name, value in attributes.items():
            if isinstance(value, np.ndarray):
                more = {"normalized": True} if value.dtype.kind == "u" else {}
                primitive["attributes"][name] = self.array(value, **more)
            else:
                primitive[name] = value
        primitive["indices"] = self.array(np.ravel(faces).astype("u2"))
        mesh = self.add("meshes", {"primitives": [primitive]})
        self.add("nodes", {"mesh": mesh, **(node or {})})
        return primitive

    def bytes(self):
        self.content["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps({k: v for k, v in self.content.items() if v != []}).encode()
        text += b" " * (-len(text) % 4)
        total = 28 + len(text) + len(self.data)
        head = struct.pack("<4sIII4s", b"glTF", 2, total, len(text), b"JSON")
        return head + text + struct.pack("<I4s", len(self.data), b"BIN\0") + self.data


def colored_material(glb, **pbr):
    return glb.add("materials", {"pbrMetallicRoughness": pbr})


def test_a_plain_colour_factor_colours_a_part_and_is_linear(tmp_path):
    glb = Glb()
    glb.square(material=colored_material(glb, baseColorFactor=[0.2140, 0, 1, 1]))
    mesh = load_mesh(written(tmp_path, "a.glb", glb.bytes()))
    np.testing.assert_allclose(mesh.vertex_colors, [[127, 0, 255]] * 4, atol=1)


def test_textures_factors_and_vertex_colours_multiply(tmp_path):
    glb = Glb()
    half = np.full((4, 3), 0.5, dtype=np.float32)
    both = colored_material(glb, baseColorFactor=[1, 0.5, 1, 1], baseColorTexture=glb.texture(QUARTERS))
    glb.square(material=colored_material(glb, baseColorTexture=glb.texture(QUARTERS)), TEXCOORD_0=UV)
    glb.square(material=both, TEXCOORD_0=UV, COLOR_0=half)
    glb.square(COLOR_0=half)
    glb.square()
    mesh = load_mesh(written(tmp_path, "a.glb", glb.bytes()))
    assert mesh.vertex_colors[:4].tolist() == [RED, GREEN, GREY, BLUE]
    light = np.array([0.5, 0.25, 0.5])  # of what the texture has: 0.2159 for grey
    expected = 1.055 * (np.array([0.2159] * 3) * light) ** (1 / 2.4) - 0.055
    np.testing.assert_allclose(mesh.vertex_colors[6], 255 * expected, atol=1.5)
    np.testing.assert_allclose(mesh.vertex_colors[8:12], 188, atol=1)  # 0.5 in linear light
    assert mesh.vertex_colors[12:].min() == 255
    assert any("1 of 4 parts have no colours" in line for line in mesh.report)


@pytest.mark.parametrize(("generator", "expected"), [("Blender", 188), ("github.com/mikedh/trimesh", 128)])
def test_vertex_colours_of_gltf_are_linear_but_where_the_program_writes_bytes(tmp_path, generator, expected):
    glb = Glb(generator)
    glb.square(COLOR_0=np.full((4, 4), 128, dtype=np.uint8))
    mesh = load_mesh(written(tmp_path, "a.glb", glb.bytes()))
    np.testing.assert_allclose(mesh.vertex_colors, expected, atol=1)


def test_quantized_positions_mirrored_nodes_and_shared_vertices_of_gltf(tmp_path):
    glb = Glb(extensionsRequired=["KHR_mesh_quantization"])
    places = glb.array((SQUARE * 65535).astype("<u2"), normalized=True)
    primitives = [
        {"attributes": {"POSITION": places}, "indices": glb.array(half.astype("u1"))} for half in HALVES
    ]
    mesh = glb.add("meshes", {"primitives": primitives})
    glb.add("nodes", {"mesh": mesh, "scale": [-2, 2, 2], "translation": [1, 0, 0]})
    mesh = load_mesh(written(tmp_path, "a.glb", glb.bytes()))
    np.testing.assert_allclose(mesh.vertices, SQUARE * [-2, 2, 2] + [1, 0, 0])
    assert mesh.n_faces == 2
    np.testing.assert_allclose(mesh.face_normals, [[0, 0, 1]] * 2)  # a mirror doesn't turn it inside out


def test_draco_is_decoded_with_its_colours(tmp_path):
    draco = pytest.importorskip("DracoPy")
    glb = Glb("trimesh", extensionsRequired=["KHR_draco_mesh_compression"])
    colors = np.arange(12, dtype=np.uint8).reshape(4, 3)
    data = draco.encode(SQUARE, HALVES.astype(np.uint32), quantization_bits=14, colors=colors)
    ids = {a["attribute_type"]: a["unique_id"] for a in draco.decode(data).attributes}
    count = {"componentType": 5126, "count": 4, "type": "VEC3"}
    attributes = {
        "POSITION": glb.add("accessors", count),
        "COLOR_0": glb.add("accessors", {**count, "componentType": 5121, "normalized": True}),
    }
    packed = {"bufferView": glb.view(data), "attributes": {"POSITION": ids[0], "COLOR_0": ids[2]}}
    primitive = {"attributes": attributes, "extensions": {"KHR_draco_mesh_compression": packed}}
    glb.add("nodes", {"mesh": glb.add("meshes", {"primitives": [primitive]})})
    mesh = load_mesh(written(tmp_path, "a.glb", glb.bytes()))
    order = [np.abs(mesh.vertices - row).sum(axis=1).argmin() for row in SQUARE]
    np.testing.assert_allclose(mesh.vertices[order], SQUARE, atol=1e-3)
    np.testing.assert_array_equal(mesh.vertex_colors[order], colors)


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_meshopt_compression", "ACME_new"])
def test_a_required_extension_that_is_not_read_is_named(tmp_path, name):
    glb = Glb(extensionsRequired=[name])
    glb.square()
    with pytest.raises(MeshError, match=f"requires the extension '{name}'.*save it without"):
        load_mesh(written(tmp_path, "a.glb", glb.bytes()))


@pytest.mark.parametrize(
    ("image", "message"),
    [
        ({"uri": "gone.png"}, "texture 'gone.png' is missing"),
        ({"uri": "data:image/png;base64,AAAA"}, "texture 'image 0' can't be read"),
    ],
)
def test_a_missing_picture_leaves_a_part_without_colours_and_says_so(tmp_path, image, message):
    glb = Glb()
    glb.square(material=colored_material(glb, baseColorTexture=glb.texture(**image)), TEXCOORD_0=UV)
    with pytest.warns(UserWarning, match=message):
        mesh = load_mesh(written(tmp_path, "a.glb", glb.bytes()))
    assert mesh.vertex_colors is None
    assert message in " ".join(mesh.report)


def test_specular_glossiness_is_read_and_basis_textures_are_said_to_be_lost(tmp_path):
    glb = Glb()
    glossy = {"diffuseFactor": [1, 0, 0, 1]}
    glb.add("materials", {"extensions": {"KHR_materials_pbrSpecularGlossiness": glossy}})
    glb.square(material=0)
    assert load_mesh(written(tmp_path, "a.glb", glb.bytes())).vertex_colors.tolist() == [RED] * 4
    glb = Glb(extensionsRequired=["KHR_texture_basisu"])
    texture = {"index": glb.add("textures", {"extensions": {"KHR_texture_basisu": {"source": 0}}})}
    glb.square(material=colored_material(glb, baseColorTexture=texture), TEXCOORD_0=UV)
    with pytest.warns(UserWarning, match="stored by 'KHR_texture_basisu'"):
        load_mesh(written(tmp_path, "b.glb", glb.bytes()))


def test_a_forged_count_takes_no_memory(tmp_path):
    glb = Glb()
    glb.square()
    glb.content["accessors"][0] = {"componentType": 5126, "count": 12_000_000, "type": "VEC3"}
    with pytest.raises(MeshError, match="its positions, 12000000 of them, have no data"):
        load_mesh(written(tmp_path, "a.glb", glb.bytes()))
    glb.content["accessors"][0]["count"] = 10**12
    with pytest.raises(MeshError, match=r"asks for 1\.2e\+04 GB of positions, and at most 4\.3 GB"):
        load_mesh(written(tmp_path, "a.glb", glb.bytes()))


def test_gltf_with_files_beside_it_and_none_outside(tmp_path):
    glb = Glb()
    glb.square(material=colored_material(glb, baseColorTexture=glb.texture(uri="pic.png")), TEXCOORD_0=UV)
    glb.content["buffers"] = [{"byteLength": len(glb.data), "uri": "a%20b.bin"}]
    written(tmp_path, "a b.bin", glb.data)
    written(tmp_path, "pic.png", QUARTERS)
    mesh = load_mesh(written(tmp_path, "a.gltf", json.dumps(glb.content)))
    assert mesh.vertex_colors.tolist() == [RED, GREEN, GREY, BLUE]
    glb.content["buffers"][0]["uri"] = "../a.bin"
    with pytest.raises(MeshError, match=r"refers to '\.\./a\.bin'; only files beside it"):
        load_mesh(written(tmp_path, "a.gltf", json.dumps(glb.content)))
    glb.content["buffers"][0]["uri"] = "c.bin"
    with pytest.raises(FileNotFoundError, match=r"needs 'c\.bin' beside it"):
        load_mesh(written(tmp_path, "a.gltf", json.dumps(glb.content)))


OBJ_SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("colors", "expected"),
    [
        (["100 100 100", "0 0 255", "1 1 1", "50 60 70"], [[100] * 3, [0, 0, 255], [1] * 3, [50, 60, 70]]),
        (["0.5 0.5 0.5", "0 0 1", "1 0 0", "0 0.2 0"], [[128] * 3, [0, 0, 255], [255, 0, 0], [0, 51, 0]]),
        (["1 1 1", "0 0 1", "1 0 0", "0 1 0"], [[255] * 3, [0, 0, 255], [255, 0, 0], [0, 255, 0]]),
    ],
)
def test_colours_behind_obj_vertices_may_reach_1_or_255(tmp_path, colors, expected):
    rows = [f"{v} {c}" for v, c in zip(OBJ_SQUARE.splitlines(), colors)]
    mesh = load_mesh(written(tmp_path, "a.obj", "\n".join(rows) + "\nf 1 2 3 4\n"))
    assert mesh.vertex_colors.tolist() == expected
    assert "were taken as 0–" in mesh.report[0]


def test_seams_of_a_texture_keep_the_vertices_of_an_obj(tmp_path):
    text = "mtllib my lib.mtl\nv 9 9 9\n" + OBJ_SQUARE
    text += "vt 0 1\nvt 1 1\nvt 1 0\nvt 0 0\nusemtl wall paper\nf 2/1 3/2 4/3\nf 2/1 4/3 5/4\n"
    written(tmp_path, "my lib.mtl", "newmtl wall paper\nKd 0 0 0\nmap_Kd -s 1 1 1 textures\\a b.png\n")
    written(tmp_path, "a b.png", QUARTERS)
    mesh = load_mesh(written(tmp_path, "a.obj", text))
    assert (mesh.n_vertices, mesh.n_faces) == (5, 2)  # with the vertex that no face has
    assert mesh.vertex_colors[1:].tolist() == [RED, GREEN, GREY, BLUE]
    (tmp_path / "a b.png").unlink()
    with pytest.warns(UserWarning, match="texture .*a b.png' is missing"):
        assert load_mesh(tmp_path / "a.obj").vertex_colors is None
    (tmp_path / "my lib.mtl").unlink()
    with pytest.warns(UserWarning, match="material library 'my lib.mtl' is missing"):
        assert load_mesh(tmp_path / "a.obj").vertex_colors is None


def test_plain_materials_and_textures_of_an_obj_stand_beside_each_other(tmp_path):
    text = f"mtllib a.mtl\n{OBJ_SQUARE}v 5 0 0\nv 6 0 0\nv 6 1 0\nvt 0 0\n"
    text += "usemtl plain\nf 1//1 2//1 3//1\nusemtl pic\nf 5/1/1 6/1/1 7/1/1\nusemtl plain\nf 1 3/1 4//1\n"
    written(tmp_path, "a.mtl", "newmtl plain\nKd 1 0 0\nnewmtl pic\nmap_Kd p.png\n")
    written(tmp_path, "p.png", picture([[BLUE]]))
    mesh = load_mesh(written(tmp_path, "a.obj", text))
    assert mesh.vertex_colors.tolist() == [RED] * 4 + [BLUE] * 3


def test_face_colours_become_the_mean_at_their_vertices(tmp_path):
    head = ply(4, 2, "").decode().replace("end_header", "property uchar red\nproperty uchar green\n"
        "property uchar blue\nend_header")  # fmt: skip
    mesh = load_mesh(written(tmp_path, "a.ply", head + CORNERS + "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n"))
    assert mesh.vertex_colors.tolist() == [[128, 0, 128], RED, [128, 0, 128], BLUE]
    assert "mean of those around it" in mesh.report[0]
    coloured = as_trimesh(Mesh(SQUARE, HALVES))
    coloured.visual.face_colors = [[255, 0, 0, 255], [0, 0, 255, 255]]
    assert load_mesh(coloured).vertex_colors[1].tolist() == RED
    off = f"OFF\n4 2 0\n{CORNERS}3 0 1 2 1.0 0.0 0.0\n3 0 2 3 0.0 0.0 1.0\n"
    assert load_mesh(written(tmp_path, "a.off", off)).vertex_colors[3].tolist() == BLUE


def test_wedge_coordinates_of_a_ply_keep_its_vertices(tmp_path):
    head = ply(4, 2, "").decode().replace("element vertex", "comment TextureFile t.png\nelement vertex")
    head = head.replace("end_header", "property list uchar float texcoord\nend_header")
    rows = "3 0 1 2 6 .1 .9 .9 .9 .9 .1\n3 0 2 3 6 .1 .9 .9 .1 .1 .1\n"
    written(tmp_path, "t.png", QUARTERS)
    mesh = load_mesh(written(tmp_path, "a.ply", head + CORNERS + rows))
    assert mesh.n_vertices == 4
    assert mesh.vertex_colors.tolist() == [RED, GREEN, GREY, BLUE]


@pytest.mark.parametrize("binary", [False, True])
def test_mixed_polygons_are_cut_in_their_place(tmp_path, binary):
    if binary:
        body = BYTES + struct.pack("<B3iB4iB3i", 3, 0, 1, 2, 4, 0, 1, 2, 3, 3, 0, 2, 3)
    else:
        body = CORNERS + "3 0 1 2\n4 0 1 2 3\n3 0 2 3\n"
    mesh = load_mesh(written(tmp_path, "a.ply", ply(4, 3, body, binary=binary)))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 2, 3]]
    assert mesh.faces_of_file.tolist() == [0, 1, 1, 2]
    assert mesh.n_file_faces == 3
    assert "1 polygons were cut into triangles" in mesh.report[0]


@pytest.mark.parametrize("turn", range(8))
def test_polygons_that_are_not_convex_are_cut_inside(tmp_path, turn):
    ring = np.array([[0, 0], [4, 0], [4, 3], [3, 3], [3, 1], [1, 1], [1, 3], [0, 3]])
    ring = np.roll(ring, turn, axis=0)[:: 1 if turn % 2 else -1]
    text = "".join(f"v {x} 0 {y}\n" for x, y in ring) + "f 1 2 3 4 5 6 7 8\n"
    mesh = load_mesh(written(tmp_path, "a.obj", text))
    assert mesh.face_areas.sum() == pytest.approx(8)
    assert abs(mesh.face_vectors.sum(axis=0)[1]) == pytest.approx(16)
    arrow = "v 0 0 0\nv 2 1 0\nv 0 2 0\nv 1 1 0\n"
    for order in ("1 2 3 4", "2 3 4 1", "3 4 1 2", "4 1 2 3"):
        assert load_mesh(
            written(tmp_path, "q.obj", arrow + f"f {order}\n")
        ).face_areas.sum() == pytest.approx(1)


def test_a_bad_corner_costs_its_faces_and_strict_refuses(tmp_path):
    body = CORNERS.replace("1 1 0", "nan 1 0") + "3 0 1 3\n3 0 2 3\n3 0 3 1\n"
    path = written(tmp_path, "a.ply", ply(4, 3, body))
    with pytest.warns(UserWarning, match=r"a\.ply: 1 of 3 faces were dropped: they have NaN"):
        mesh = load_mesh(path)
    assert mesh.faces_of_file.tolist() == [0, 2]
    assert mesh.n_vertices == 4
    with pytest.raises(
        MeshError, match=r"1 of 3 faces have NaN, infinite or far corners .*strict=False drops them"
    ):
        load_mesh(path, strict=True)
    with pytest.warns(UserWarning, match=r"refer to a vertex that does not exist \(9 of 4\)"):
        mesh = load_mesh((SQUARE, [[0, 1, 2], [0, 2, 9], [0, 2, 3]]))
    assert mesh.faces_of_file.tolist() == [0, 2]
    with pytest.raises(MeshError, match="2 of 3 faces refer"):
        load_mesh((SQUARE, [[0, 1, 2], [0, 2, 9], [0, 2, 9]]))


def test_faces_that_look_to_the_other_side_are_turned_where_that_is_safe():
    ball = shapes.icosphere(2)
    faces = np.array(ball.faces)
    odd = np.random.default_rng(0).choice(len(faces), 60, replace=False)
    faces[odd] = faces[odd][:, ::-1]
    mesh = load_mesh((ball.vertices, faces))
    outward = np.einsum("ij,ij->i", mesh.face_normals, mesh.face_centroids) > 0
    assert outward.all()
    assert "60 of 320 faces looked to the other side" in mesh.report[0]
    with pytest.raises(MeshError, match=r"60 of 320 faces look to the other side.*strict=False turns them"):
        load_mesh((ball.vertices, faces), strict=True)


def test_a_moebius_strip_is_left_as_it_is():
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = [
        np.stack([(1 + w * np.cos(angle / 2)) * np.cos(angle), (1 + w * np.cos(angle / 2)) * np.sin(angle),
                  w * np.sin(angle / 2)], axis=1) for w in (-0.3, 0.3)
    ]  # fmt: skip
    i = np.arange(24)
    here, there = np.stack([i, i + 24], axis=1), np.stack([(i + 1) % 24, (i + 1) % 24 + 24], axis=1)
    there[-1] = there[-1][::-1]  # half a turn
    quads = np.stack([here[:, 0], there[:, 0], there[:, 1], here[:, 1]], axis=1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    mesh = load_mesh((np.concatenate(rim), faces))
    np.testing.assert_array_equal(mesh.faces, faces)
    assert "parts that can't be wound alike" in mesh.report[0]


def test_coordinates_of_a_map_that_lost_their_digits_are_told_apart_from_those_that_did_not(tmp_path):
    grid = shapes.grid_square(30, size=3.0)
    shift = np.array([345_678.9, 5_400_123.4, 35.2])
    for dtype, text in (("float", "rounded to steps of 0.5"), ("double", "as in a map's grid")):
        table = (grid.vertices + shift).astype({"float": "<f4", "double": "<f8"}[dtype])
        faces = np.zeros(grid.n_faces, dtype=[("n", "u1"), ("c", "<i4", 3)])
        faces["n"], faces["c"] = 3, grid.faces
        head = ply(grid.n_vertices, grid.n_faces, b"", binary=True).replace(b"float", dtype.encode())
        path = written(tmp_path, f"{dtype}.ply", head + table.tobytes() + faces.tobytes())
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            mesh = load_mesh(path)
        assert text in mesh.report[0]
        assert len(caught) == (dtype == "float")


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.usdz", b"PK\x03\x04....", "is a USDZ scene, which isn't read; export the scan as GLB"),
        ("a.ply", b"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS"),
        ("a.glb", b"<!DOCTYPE html><html>", "is a web page; the download went wrong"),
        ("a.fbx", b"Kaydara FBX Binary  \0", "is an FBX scene; save it as GLB"),
        ("a.zip", b"PK\x03\x04....", "is an archive, which isn't read; unpack it"),
        ("a.ply", b"\x1f\x8b\x08", "is a compressed archive; unpack it first"),
        ("a.png", b"\x89PNG\r\n", "is a picture"),
        ("a.pcd", "# .PCD v0.7\nVERSION .7\n", "is a point cloud"),
        ("a.xyz", "0 0 0\n", "is a point cloud"),
        ("a.obj", "junk and\nmore junk\n", "holds no vertices: it is no OBJ file"),
        ("a.obj", OBJ_SQUARE + "p 1\n", "holds no triangles, only points"),
        ("a.glb", json.dumps({"asset": {"version": "1.0"}}), "is glTF of version '1.0'"),
        ("a.ply", ply("9" * 4300, 1, CORNERS), "damaged or truncated: its header promises 99999"),
        ("a.ply", ply(4, 1, "0 0 0\n1 0 0\n1,5 1 0\n0 1 0\n3 0 1 2\n"), "'1,5' stands where a number"),
        ("a.obj", OBJ_SQUARE + "f 1 2 x\n", "'x' stands where a number"),
    ],
)  # fmt: skip
def test_what_is_no_mesh_says_what_it_is_and_what_to_do(tmp_path, name, data, message):
    with pytest.raises(MeshError, match=re.escape(message)):
        load_mesh(written(tmp_path, name, data))


def test_content_counts_before_the_suffix(tmp_path):
    assert load_mesh(written(tmp_path, "a.obj", GOOD)).n_faces == 2
    assert load_mesh(written(tmp_path, "a", GOOD_GLB)).n_faces == 12


def test_the_home_folder_may_be_written_short(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    written(tmp_path, "a.ply", GOOD)
    assert load_mesh("~/a.ply").source == str(tmp_path / "a.ply")


def test_the_old_place_of_load_mesh_still_answers():
    from scenewidget.engine import mesh as module

    with pytest.warns(DeprecationWarning, match=r"moved to scenewidget\.engine\.readers"):
        assert module.load_mesh is load_mesh


def test_triangle_strips_of_a_ply(tmp_path):
    head = (
        ply(4, 1, "").decode().replace("element face", "element tristrips").replace("list uchar", "list int")
    )
    mesh = load_mesh(written(tmp_path, "a.ply", head + CORNERS + "7 0 1 3 2 -1 0 1 \n".replace("7", "7", 1)))
    assert mesh.faces.tolist() == [[0, 1, 3], [3, 1, 2]]


def test_colours_in_the_spare_bits_of_an_stl(tmp_path):
    data = bytearray(GOOD_STL)
    for k in range(12):
        struct.pack_into("<H", data, 84 + 50 * k + 48, 0x8000 | 31)  # VisCAM: the lowest five bits are blue
    assert load_mesh(written(tmp_path, "a.stl", bytes(data))).vertex_colors.tolist() == [BLUE] * 36
    data[:10] = b"COLOR=\xff\0\0\xff"
    for k in range(6):
        struct.pack_into("<H", data, 84 + 50 * k + 48, 31 << 5)
    found = load_mesh(written(tmp_path, "b.stl", bytes(data))).vertex_colors
    assert found.tolist() == [GREEN] * 18 + [RED] * 18


# --- other members of the kinds above ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("declared", "values", "expected"),
    [("float", ".5 .25 1", [128, 64, 255]), ("double", "127 64 255", [127, 64, 255]),
     ("ushort", "65535 0 32768", [255, 0, 128]), ("int", "255 0 128", [255, 0, 128])],
)  # fmt: skip
def test_names_of_a_ply_count_in_any_case_and_colours_in_any_range(tmp_path, declared, values, expected):
    head = "ply\nformat ascii 1.0\nelement vertex 3\n"
    head += "".join(f"property float {axis}\n" for axis in "XYZ")
    head += "".join(f"property {declared} {name}\n" for name in ("Red", "Green", "Blue"))
    head += "element face 1\nproperty list uchar int Vertex_Indices\nend_header\n"
    rows = "".join(f"{x} {y} {z} {values}\n" for x, y, z in V)
    mesh = load_mesh(written(tmp_path, "a.ply", head + rows + "3 0 1 2\n"))
    assert mesh.vertex_colors.tolist() == [expected] * 3


def test_colours_of_gltf_and_mtl_written_as_0_to_255_are_not_cut_off(tmp_path):
    glb = Glb()
    glb.square(COLOR_0=np.full((4, 4), [10, 20, 30, 255], np.float32))
    assert load_mesh(written(tmp_path, "a.glb", glb.bytes())).vertex_colors.tolist() == [[10, 20, 30]] * 4
    glb = Glb()
    glb.square(material=colored_material(glb, baseColorFactor=[255, 128, 0, 255]))
    assert load_mesh(written(tmp_path, "b.glb", glb.bytes())).vertex_colors.tolist() == [[255, 128, 0]] * 4
    written(tmp_path, "m.mtl", "newmtl a\nKd 200 100 50\n")
    obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl nowhere\nf 1 2 3\n"
    with pytest.warns(UserWarning, match="material 'nowhere' is in no library"):
        mesh = load_mesh(written(tmp_path, "a.obj", obj))
    assert mesh.vertex_colors.tolist() == [[200, 100, 50]] * 3


def test_pictures_of_16_bits_keep_their_greys(tmp_path):
    written(tmp_path, "m.mtl", "newmtl a\nmap_Kd grey.png\n")
    Image.fromarray(np.full((2, 2), 128 * 257, dtype=np.uint16)).save(tmp_path / "grey.png")
    obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt .1 .1\nusemtl a\nf 1/1 2/1 3/1\n"
    assert load_mesh(written(tmp_path, "a.obj", obj)).vertex_colors.tolist() == [[128] * 3] * 3


def test_a_trimesh_with_one_colour_for_all_is_coloured_and_a_scene_is_told_the_way():
    pbr = trimesh.visual.material.PBRMaterial(baseColorFactor=[255, 0, 9, 255])
    for coordinates in (None, np.zeros((3, 2))):
        mesh = trimesh.Trimesh(V, F, process=False)
        mesh.visual = trimesh.visual.TextureVisuals(uv=coordinates, material=pbr)
        assert load_mesh(mesh).vertex_colors.tolist() == [[255, 0, 9]] * 3
    with pytest.raises(TypeError, match=r"got Scene; `scene\.to_mesh\(\)` puts its parts together"):
        load_mesh(trimesh.Scene([mesh]))


@pytest.mark.parametrize(("n", "place"), [(4, 1e30), (16, 1e6), (16, 400.0)])
def test_a_corner_far_from_all_others_costs_its_faces_only(n, place):
    room = shapes.box(n)
    places = np.vstack([room.vertices, [[place, 0, 0]]])
    faces = np.vstack([room.faces, [[0, 1, len(places) - 1]]])
    with pytest.warns(UserWarning, match=r"1 of \d+ faces were dropped: they have NaN, infinite or far"):
        assert load_mesh((places, faces)).n_faces == room.n_faces


@pytest.mark.filterwarnings("ignore:.*rounded to steps")
def test_digits_lost_in_one_column_of_a_text_are_noticed(tmp_path):
    points = np.random.default_rng(0).random((300, 3)) * 5 + (448_262, 5_411_932, 312)
    points[:, :2] = points[:, :2].astype(np.float32)
    rows = "\n".join(f"{x} {y} {z:.3f}" for x, y, z in points.tolist())
    assert "rounded to steps of 0.5" in load(written(tmp_path, "a.xyz", rows)).report[0]
