"""Damage files of every format in ways that keep their structure, and see what the readers say.

    python tests/benchmarks/fuzz_readers.py [seconds a format]

Prints a row a format: files read, files refused, the slowest, and whatever else came out than a scan,
`MeshError` or `OSError`. Numbers in headers and JSON become others, parts are cut, doubled and swapped.
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
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from scenewidget.engine.mesh import MeshError
from scenewidget.engine.readers import load

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
    out["xyz"] = ["\n".join(" ".join(map(str, p)) for p in points.tolist()).encode()]
    out["csv"] = [b"x,y,z\n" + "\n".join(",".join(map(str, p)) for p in points.tolist()).encode()]
    try:
        import laspy
    except ImportError:
        return out
    for suffix in ("las", "laz"):
        las = laspy.create(point_format=3, file_version="1.2")
        las.x, las.y, las.z = points.T.astype(float)
        file = io.BytesIO()
        las.write(file, do_compress=suffix == "laz")
        out[suffix] = [file.getvalue()]
    return out


def damaged(data: bytes, rng: random.Random) -> bytes:
    """One to four changes that keep most of the structure."""
    for _ in range(rng.randrange(1, 5)):
        way = rng.randrange(7)
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
        else:
            data = _other_json(data, rng)
    return data


def _other_json(data: bytes, rng: random.Random) -> bytes:
    """A GLB with a value of its JSON taken out, replaced or put elsewhere."""
    if data[:4] != b"glTF" or len(data) < 20:
        return data
    size = int.from_bytes(data[12:16], "little")
    try:
        content = json.loads(data[20 : 20 + size])
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
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON") + text + rest


def main(seconds: float) -> None:
    """Fuzz each format for so long."""
    print(f"{'format':8}{'read':>9}{'refused':>9}{'slowest':>9}{'MB more':>9}  anything else")
    for suffix, whole in seeds().items():
        rng, read, refused, slowest, other = random.Random(0), 0, 0, 0.0, {}
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"a.{suffix}"
            library = Path(folder) / "a.mtl"
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                path.write_bytes(damaged(rng.choice(whole), rng))
                library.write_bytes(damaged(b"newmtl m\nKd 1 0.5 0\nmap_Kd -s 1 1 1 -o 0 0 a.png\n", rng))
                start = time.monotonic()
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        load(path)
                    read += 1
                except (MeshError, OSError):
                    refused += 1
                except BaseException as error:  # what must not happen
                    if isinstance(error, KeyboardInterrupt):
                        raise
                    name = f"{type(error).__name__}: {error!s:.80}"
                    other[name] = other.get(name, 0) + 1
                slowest = max(slowest, time.monotonic() - start)
        more = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        print(f"{suffix:8}{read:9}{refused:9}{slowest:8.2f}s{more:9.0f}  {other or ''}", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 300.0)
