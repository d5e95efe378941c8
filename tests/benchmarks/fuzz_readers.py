"""Damage files of every format in ways that keep their structure, and see what the readers say.

    python tests/benchmarks/fuzz_readers.py [seconds a format] [format ...]

Prints a row a format: files read, files refused, the CPU seconds of the slowest, and whatever else came out
than a scan or labels, `MeshError`, `FormatError`, `TypeError` or `OSError`. Numbers in headers and JSON
become others, parts are cut, doubled and swapped; of compressed formats and pictures also what is inside.
Formats named "labels …" are read by `import_labels`. What takes more than a second is kept.
"""

from __future__ import annotations

import io
import json
import random
import re
import resource
import struct
import sys
import tempfile
import time
import warnings
import zipfile
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

import scenewidget as sw
from scenewidget.editing.formats import FormatError
from scenewidget.engine.mesh import MeshError
from scenewidget.engine.readers import load

LONG = 1.0  # seconds of CPU, from which on a file is kept
NUMBERS = [b"0", b"-1", b"1", b"3", b"255", b"65536", b"4294967295", b"1e400", b"nan", b"9" * 40, b"0.5", b""]


def seeds() -> dict[str, list[bytes]]:
    """Small whole files of each format."""
    box = trimesh.creation.icosphere(1)
    box.visual.vertex_colors = np.arange(4 * len(box.vertices), dtype=np.uint8).reshape(-1, 4)
    out: dict[str, list[bytes]] = {}
    for suffix, options in (
        ("ply", {}), ("ply", {"encoding": "ascii"}), ("obj", {}), ("off", {}), ("stl", {}), ("glb", {}),
    ):  # fmt: skip
        data = box.export(file_type=suffix, **options)
        out.setdefault(suffix, []).append(data if isinstance(data, bytes) else data.encode())
    out["stl"].append(box.export(file_type="stl_ascii").encode())
    picture = io.BytesIO()
    Image.fromarray(np.arange(192, dtype=np.uint8).reshape(8, 8, 3)).save(picture, "png")
    uv = np.random.default_rng(0).random((len(box.vertices), 2))
    textured = trimesh.Trimesh(box.vertices, box.faces, process=False)
    textured.visual = trimesh.visual.TextureVisuals(uv, image=Image.open(picture))
    out["glb"].append(textured.export(file_type="glb"))
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in box.vertices.round(4).tolist())
    rows += "".join(f"vt {u:.4f} {v:.4f}\n" for u, v in uv.tolist()) + "usemtl m\n"
    rows += "".join("f " + " ".join(f"{i}/{i}" for i in face) + "\n" for face in (box.faces + 1).tolist())
    out["obj"].append(("mtllib a.mtl\n" + rows).encode())
    head = "# .PCD v.7\nVERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 42\n"
    head += "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 42\nDATA "
    points = box.vertices.astype("<f4")
    rgb = np.arange(42, dtype="<u4")
    table = np.concatenate([points.view("<u4"), rgb[:, None]], axis=1)
    flat = points.T.tobytes() + rgb.tobytes()
    packed = b"".join(
        bytes([len(run) - 1]) + run for run in (flat[i : i + 32] for i in range(0, len(flat), 32))
    )
    text = "\n".join(" ".join(map(str, [*p, c])) for p, c in zip(points.tolist(), rgb.tolist()))
    out["pcd"] = [
        (head + "ascii\n" + text).encode(),
        (head + "binary\n").encode() + table.tobytes(),
        (head + "binary_compressed\n").encode() + struct.pack("<2I", len(packed), len(flat)) + packed,
    ]
    lines = [" ".join(map(str, p)) for p in points.tolist()]
    out["xyz"] = ["\n".join(lines).encode(), "\n".join(f"{line} 9 8 7" for line in lines).encode()]
    out["pts"] = [f"{len(lines)}\n{chr(10).join(f'{line} -5 9 8 7' for line in lines)}\n".encode()]
    out["csv"] = [b"x,y,z\n" + "\n".join(",".join(map(str, p)) for p in points.tolist()).encode()]
    out["ply"] += [textured_ply(box, uv), box_of_points(points, ">"), mixed_polygons()]
    out["png"], out["jpg"] = [picture.getvalue()], [photograph()]
    out |= labels_of(box)
    scan = Path(tempfile.gettempdir()) / "seed.e57"  # nothing that we install writes one: pye57 does
    if scan.exists():
        out["e57"] = [scan.read_bytes()]
    else:
        print(f"{scan} is not there, as pye57 writes it: E57 left out")
    out["glb"] += rich_glbs(box)
    try:
        import DracoPy
    except ImportError:
        print("DracoPy is not installed: compressed GLB left out")
    else:
        packed = DracoPy.encode(box.vertices.astype(np.float32), box.faces.astype(np.uint32))
        out["draco"] = [draco_glb(packed, len(box.vertices), len(box.faces))]
    try:
        import laspy
    except ImportError:
        print("laspy is not installed: LAS and LAZ left out")
        return out
    for suffix in ("las", "laz"):
        las = laspy.create(point_format=3, file_version="1.2")
        las.x, las.y, las.z = points.T.astype(float)
        file = io.BytesIO()
        las.write(file, do_compress=suffix == "laz")
        out[suffix] = [file.getvalue()]
    return out


def textured_ply(box: trimesh.Trimesh, uv: np.ndarray) -> bytes:
    """Texture coordinates at the corners of each face, as MeshLab writes them, binary."""
    head = f"ply\nformat binary_little_endian 1.0\ncomment TextureFile a.png\nelement vertex {len(uv)}\n"
    head += "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
    head += f"property uchar green\nproperty uchar blue\nelement face {len(box.faces)}\n"
    head += "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
    rows = [struct.pack("<3f3B", *place, 9, 8, 7) for place in box.vertices.tolist()]
    rows += [struct.pack("<B3iB6f", 3, *f, 6, *uv[f].ravel().tolist()) for f in box.faces.tolist()]
    return (head + "property int texnumber\nend_header\n").encode() + b"".join(
        row + (b"" if k < len(uv) else bytes(4)) for k, row in enumerate(rows)
    )


def box_of_points(points: np.ndarray, order: str) -> bytes:
    """Points without faces, big end first."""
    head = f"ply\nformat binary_big_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    return (head + "end_header\n").encode() + np.tile(points, 2).astype(f"{order}f4").tobytes()


def mixed_polygons() -> bytes:
    """Two triangles and a quadrangle, binary."""
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 6\nproperty double x\nproperty double y\n"
    head += "property double z\nelement face 3\nproperty list uint8 uint32 vertex_index\nend_header\n"
    places = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], "<f8").tobytes()
    faces = [(0, 1, 2), (0, 2, 3), (1, 4, 5, 2)]
    return head.encode() + places + b"".join(struct.pack(f"<B{len(f)}I", len(f), *f) for f in faces)


def photograph() -> bytes:
    """A JPEG."""
    file = io.BytesIO()
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (16, 16, 3), dtype=np.uint8)).save(file, "jpeg")
    return file.getvalue()


def draco_glb(packed: bytes, n_vertices: int, n_faces: int) -> bytes:
    """A GLB whose one primitive is compressed."""
    name = "KHR_draco_mesh_compression"
    squeezed = {"bufferView": 0, "attributes": {"POSITION": 0}}
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "extensions": {name: squeezed}}
    content = {
        "asset": {"version": "2.0"}, "extensionsUsed": [name], "extensionsRequired": [name], "scene": 0,
        "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}],
        "accessors": [{"componentType": 5126, "count": n_vertices, "type": "VEC3"},
                      {"componentType": 5125, "count": 3 * n_faces, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(packed)}],
        "buffers": [{"byteLength": len(packed)}],
    }  # fmt: skip
    return glb_of(content, packed + b"\0" * (-len(packed) % 4))


def rich_glbs(box: trimesh.Trimesh) -> list[bytes]:
    """A sphere of whole numbers, with sparse places and a turned texture; and the same as strips."""
    n, corners = len(box.vertices), box.faces.astype("<u2")
    places = (box.vertices * 30_000).astype("<i2")
    tints = (np.arange(4 * n).reshape(n, 4) * 300).astype("<u2")
    uv = (np.random.default_rng(0).random((n, 2)) * 65_535).astype("<u2")
    picture = photograph()
    parts = [corners.tobytes(), np.pad(places, ((0, 0), (0, 1))).tobytes(), tints.tobytes(), uv.tobytes(),
             np.array([0, 5], "<u2").tobytes(), places[[1, 2]].tobytes(), picture]  # fmt: skip
    views, data = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part + bytes(-len(part) % 4)
    views[1]["byteStride"] = 8
    sparse = {"count": 2, "indices": {"bufferView": 4, "componentType": 5123}, "values": {"bufferView": 5}}
    accessors = [
        {"bufferView": 0, "componentType": 5123, "count": corners.size, "type": "SCALAR"},
        {
            "bufferView": 1,
            "componentType": 5122,
            "count": n,
            "type": "VEC3",
            "normalized": True,
            "sparse": sparse,
        },
        {"bufferView": 2, "componentType": 5123, "count": n, "type": "VEC4", "normalized": True},
        {"bufferView": 3, "componentType": 5123, "count": n, "type": "VEC2", "normalized": True},
    ]
    turn = {"offset": [0.1, 0.2], "rotation": 1, "scale": [2, 2]}
    turned = {"index": 0, "extensions": {"KHR_texture_transform": turn}}
    material = {"baseColorTexture": turned, "baseColorFactor": [1, 0.5, 0.2, 1]}
    attributes = {"POSITION": 1, "COLOR_0": 2, "TEXCOORD_0": 3}
    out = []
    for mode in (4, 5):
        primitive = {"attributes": attributes, "indices": 0, "material": 0, "mode": mode}
        content = {
            "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_mesh_quantization", "KHR_texture_transform"],
            "extensionsRequired": ["KHR_mesh_quantization"], "scene": 1,
            "scenes": [{"nodes": []}, {"nodes": [0]}],
            "nodes": [{"children": [1, 2]}, {"mesh": 0, "scale": [-1, 2, 1], "rotation": [0, 0.6, 0, 0.8]},
                      {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]}],
            "meshes": [{"primitives": [primitive]}], "accessors": accessors, "bufferViews": views,
            "materials": [{"pbrMetallicRoughness": material}],
            "textures": [{"source": 0}], "images": [{"bufferView": 6, "mimeType": "image/jpeg"}],
            "buffers": [{"byteLength": len(data)}],
        }  # fmt: skip
        out.append(glb_of(content, data))
    return out


def glb_of(content: dict, data: bytes) -> bytes:
    """A GLB of its two chunks."""
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(data), len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(data), b"BIN\0") + data


MESH = trimesh.creation.icosphere(1)


def labels_of(box: trimesh.Trimesh) -> dict[str, list[bytes]]:
    """Label files of the same sphere, by "labels " and suffix."""
    mesh = sw.load_mesh((box.vertices, box.faces))
    seg = sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces) % 3, names=["chair", "table", "lamp"])
    out: dict[str, list[bytes]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("a.ply", "a.npz", "a.glb", "a.aggregation.json", "a.xml", "a.npy", "a.txt"):
            for path in sw.export(seg, mesh, Path(folder) / name, overwrite=True):
                suffix = "".join(path.suffixes)
                out.setdefault(f"labels {suffix}", []).append(path.read_bytes())
    out["labels .label"] = [np.arange(mesh.n_faces, dtype="<u4").tobytes()]
    return out


def damaged(data: bytes, rng: random.Random) -> bytes:
    """One to four changes that keep most of the structure."""
    for _ in range(rng.randrange(1, 5)):
        way = rng.randrange(9)
        at = rng.randrange(max(1, len(data)))
        if way == 0:
            data = data[:at]
        elif way == 1:
            data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
        elif way == 2:
            data = data[:at] + data[at : at + rng.randrange(200)] * 2 + data[at + rng.randrange(200) :]
        elif way in (3, 4):  # a number of the text in front, or of the JSON, becomes another
            found = list(re.finditer(rb"-?\d+(\.\d+)?", data[:4000]))
            if found:
                one = rng.choice(found)
                data = data[: one.start()] + rng.choice(NUMBERS) + data[one.end() :]
        elif way == 5:
            places = (0, 4, 8, 12, 80, 84, 96, 104, 105, 107, at)
            at = rng.choice(places)
            data = data[:at] + struct.pack("<I", rng.choice([0, 1, 2**31, 2**32 - 1, 1000])) + data[at + 4 :]
        elif way == 6:
            data = _other_json(data, rng)
        else:
            data = _other_lines(data, rng)
    return data


WORDS = b"""x y z nx ny nz red green blue rgb rgba alpha intensity label scalar_Label float double char
    uchar short ushort int uint int64 list property element vertex face tristrips edge comment
    format ascii binary_little_endian binary_big_endian vertex_indices end_header FIELDS SIZE TYPE
    COUNT WIDTH HEIGHT VIEWPOINT POINTS DATA F U I _ v vt vn vp f l p o g usemtl mtllib newmtl
    map_Kd Kd -s -o a.png a.mtl OFF COFF NOFF STOFF solid facet normal outer loop endloop endfacet
    endsolid # // , ; \\ 0 1 -1 -2 3 4 8 1e39 1e308 nan inf 1/2/3 1//3 1/ / -1/-1 0x10 1,5 1_000""".split()


def _other_lines(data: bytes, rng: random.Random) -> bytes:
    """A line of text left out, repeated, swapped or joined with the next, or one of its words another."""
    end = max(data.find(b"end_header"), data.find(b"DATA "), 0)
    end = len(data) if end == 0 else min(len(data), end + 400)  # what follows may be binary
    lines = data[:end].split(b"\n")
    at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    way = rng.randrange(8)
    if way == 0:
        del lines[at]
    elif way == 1:
        lines[at:at] = [lines[other]] * rng.choice([1, 1, 2, 50])
    elif way == 2:
        lines[at], lines[other] = lines[other], lines[at]
    elif way == 3:
        lines[at : at + 2] = [rng.choice([b" ", b"\\\r", b"\t", b"\0", b"\r"]).join(lines[at : at + 2])]
    else:
        words = lines[at].split()
        if words:
            place = rng.randrange(len(words))
            if way == 4:
                words[place] = rng.choice(WORDS)
            elif way == 5:
                words[place:place] = [rng.choice(WORDS)]
            elif way == 6:
                del words[place]
            else:
                rng.shuffle(words)
            lines[at] = b" ".join(words)
    return b"\n".join(lines) + data[end:]


def _mended_e57(data: bytes) -> bytes:
    """An E57 whose pages of 1024 bytes end with the right checksum again: else nothing behind it is read."""
    pages = []
    for start in range(0, len(data), 1024):
        page = data[start : start + 1020]
        check = 0xFFFFFFFF
        for byte in page:
            check = CASTAGNOLI[(check ^ byte) & 255] ^ (check >> 8)
        pages.append(page + struct.pack(">I", check ^ 0xFFFFFFFF))
    return b"".join(pages)


def _castagnoli(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
    return byte


CASTAGNOLI = [_castagnoli(byte) for byte in range(256)]


def _other_json(data: bytes, rng: random.Random) -> bytes:
    """A GLB or a JSON file with a value taken out, replaced or put elsewhere."""
    is_glb = data[:4] == b"glTF" and len(data) >= 20
    size = int.from_bytes(data[12:16], "little") if is_glb else 0
    if not is_glb and data[:1] not in (b"{", b"["):
        return data
    try:
        content = json.loads(data[20 : 20 + size] if is_glb else data)
    except ValueError:
        return data
    place = content
    for _ in range(rng.randrange(1, 6)):
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            break
        key = rng.choice(keys)
        if isinstance(place[key], (dict, list)) and rng.random() < 0.8:
            place = place[key]
            continue
        place[key] = rng.choice([None, -1, 0, 10**9, 1.5, "x", [], {}, [0], 5126, 7])
        break
    return glb_of(content, data[28 + size :]) if is_glb else json.dumps(content).encode()


def _repacked(data: bytes, rng: random.Random) -> bytes:
    """An archive with one of its files damaged, and right checksums: else nothing in it is read."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as files, zipfile.ZipFile(out, "w") as other:
        names = files.namelist()
        for name in names:
            content = files.read(name)
            if rng.random() < 1 / len(names):
                content = damaged(content, rng)
            other.writestr(name, content)
    return out.getvalue()


PARTNERS = {"labels .aggregation.json": "labels .segs.json", "labels .xml": "labels .ply"}
SCRAP_MTL = b"newmtl m\nKd 1 0.5 0\nmap_Kd -s 1 1 1 -o 0 0 a.png\n"


def write_damaged(name: str, files: dict[str, list[bytes]], folder: Path, rng: random.Random) -> Path:
    """A damaged file of a format, and beside it what it refers to, damaged at times."""
    if name.startswith("labels"):
        path = folder / f"a{name.split()[1]}"
        partner = PARTNERS.get(name)
        if partner:
            data = rng.choice(files[partner])
            (folder / f"a{partner.split()[1]}").write_bytes(
                data if rng.random() < 0.5 else damaged(data, rng)
            )
        data = rng.choice(files[name])
        is_packed = name.endswith("npz") and rng.random() < 0.8
        path.write_bytes(_repacked(data, rng) if is_packed else damaged(data, rng))
        return path
    if name in ("png", "jpg"):  # the texture of an OBJ
        (folder / "a.png").write_bytes(damaged(rng.choice(files[name]), rng))
        (folder / "a.mtl").write_bytes(SCRAP_MTL)
        path = folder / "a.obj"
        path.write_bytes(files["obj"][-1])
        return path
    path = folder / f"a.{'glb' if name == 'draco' else name}"
    data = damaged(rng.choice(files[name]), rng)
    if name == "e57" and rng.random() < 0.8:
        data = _mended_e57(data)
    path.write_bytes(data)
    (folder / "a.png").write_bytes(files["png"][0])
    (folder / "a.mtl").write_bytes(damaged(SCRAP_MTL, rng))
    return path


def main(seconds: float, only: list[str]) -> None:
    """Fuzz each format for so long."""
    files = seeds()
    sphere = sw.load_mesh((MESH.vertices, MESH.faces))
    print(f"{'format':26}{'read':>9}{'refused':>9}{'slowest':>9}{'MB more':>9}  anything else")
    for name in only or files:
        if name not in files:
            print(f"{name!r} is not among {', '.join(files)}")
            continue
        rng, read, refused, slowest, other = random.Random(len(name)), 0, 0, 0.0, {}
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with tempfile.TemporaryDirectory() as folder:
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                path = write_damaged(name, files, Path(folder), rng)
                start = time.process_time()
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        sw.import_labels(sphere, path) if name.startswith("labels") else load(path)
                    read += 1
                except (MeshError, FormatError, TypeError, OSError):
                    refused += 1
                except BaseException as error:  # what must not happen
                    if isinstance(error, KeyboardInterrupt):
                        raise
                    what = f"{type(error).__name__}: {error!s:.80}"
                    if what not in other:
                        kept = Path(tempfile.gettempdir()) / f"fuzz_{len(other)}_{path.name}"
                        kept.write_bytes(path.read_bytes())
                    other[what] = other.get(what, 0) + 1
                spent = time.process_time() - start
                if spent > max(slowest, LONG):
                    (Path(tempfile.gettempdir()) / f"fuzz_slow_{path.name}").write_bytes(path.read_bytes())
                slowest = max(slowest, spent)
        more = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        print(f"{name:26}{read:9}{refused:9}{slowest:8.2f}s{more:9.0f}  {other or ''}", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 300.0, sys.argv[2:])
