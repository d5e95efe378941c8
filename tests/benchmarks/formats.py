"""Read a million faces or points of each format: are the values right, how long does it take, in what memory?

    python tests/benchmarks/formats.py [--millions 1] [format ...]

The surface is a sheet with waves, coloured where the format can; each file is read in a process of its own.
Memory is the most that the process had above what it had before, and beside it 8 × the arrays read + 64 MB.
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.readers import load

MB = 2**20


def sheet(n_faces: int) -> tuple[FloatArray, IntArray, IntArray]:
    """Vertices, triangles and colours."""
    side = int(np.sqrt(n_faces / 2)) + 1
    y, x = np.divmod(np.arange(side**2), side)
    vertices = np.round(np.stack([x / 100, y / 100, 0.3 * np.sin(x / 30) * np.cos(y / 20)], axis=1), 6)
    corner = np.flatnonzero((x < side - 1) & (y < side - 1))
    near = np.stack([corner, corner + 1, corner + side], axis=1)
    faces = np.concatenate([near, np.stack([corner + 1, corner + side + 1, corner + side], axis=1)])
    colors = np.stack([x % 256, y % 256, (x + y) % 256], axis=1).astype(np.uint8)
    return vertices.astype(np.float32).astype(np.float64), faces.astype(np.int32), colors


def rows(pattern: str, *columns: np.ndarray) -> bytes:
    """A line for each row of the columns."""
    table = zip(*(column.tolist() for block in columns for column in np.atleast_2d(block.T)))
    return "".join(map((pattern + "\n").__mod__, table)).encode()


def ply(encoding: str, vertices: FloatArray, colors: IntArray, faces: IntArray | None = None) -> bytes:
    """A PLY, of points where there are no faces."""
    head = f"ply\nformat {encoding} 1.0\nelement vertex {len(vertices)}\n"
    head += "".join(f"property float {name}\n" for name in "xyz")
    head += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    if faces is not None:
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
    out = (head + "end_header\n").encode()
    if encoding == "ascii":
        return out + rows("%.6f %.6f %.6f %d %d %d", vertices, colors) + rows("3 %d %d %d", faces)
    order = "<" if "little" in encoding else ">"
    table = np.empty(len(vertices), dtype=[("place", f"{order}f4", 3), ("color", "u1", 3)])
    table["place"], table["color"] = vertices, colors
    if faces is None:
        return out + table.tobytes()
    lists = np.empty(len(faces), dtype=[("n", "u1"), ("corners", f"{order}i4", 3)])
    lists["n"], lists["corners"] = 3, faces
    return out + table.tobytes() + lists.tobytes()


def pcd(encoding: str, points: FloatArray, colors: IntArray) -> bytes:
    """A PCD with packed colours."""
    n = len(points)
    red, green, blue = colors.astype(np.uint32).T
    rgb = red << 16 | green << 8 | blue
    head = "# .PCD v.7\nVERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
    head += f"WIDTH {n}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA {encoding}\n"
    if encoding == "ascii":
        return head.encode() + rows("%.6f %.6f %.6f %d", points, rgb)
    if encoding == "binary":
        columns = [points.astype("<f4").view("<u4"), rgb[:, None].astype("<u4")]
        return head.encode() + np.concatenate(columns, axis=1).tobytes()
    flat = np.frombuffer(points.T.astype("<f4").tobytes() + rgb.astype("<u4").tobytes(), np.uint8)
    runs = np.full((-(-len(flat) // 32), 33), 31, np.uint8)  # LZF of literal runs of 32
    runs[:, 1:].reshape(-1)[: len(flat)] = flat
    padded = np.zeros(32 * len(runs), np.uint8)
    padded[: len(flat)] = flat
    runs[:, 1:] = padded.reshape(-1, 32)
    packed = runs.tobytes()
    return head.encode() + struct.pack("<2I", len(packed), 32 * len(runs)) + packed


def textured(path: Path, vertices: FloatArray, faces: IntArray, side: int) -> bytes:
    """An OBJ with material and picture; a vertex is the middle of a pixel."""
    picture = np.zeros((side, side, 3), np.uint8)
    picture[..., 0], picture[..., 1] = np.arange(side) % 256, np.arange(side)[::-1, None] % 256
    Image.fromarray(picture).save(path.with_name("sheet.png"))
    path.with_name("sheet.mtl").write_text("newmtl sheet\nmap_Kd sheet.png\n")
    y, x = np.divmod(np.arange(side**2), side)
    places = (np.stack([x, y], axis=1) + 0.5) / side
    out = b"mtllib sheet.mtl\n" + rows("v %.6f %.6f %.6f", vertices) + rows("vt %.6f %.6f", places)
    out += b"vn 0.0 0.0 1.0\n" * len(vertices) + b"usemtl sheet\n"
    return out + rows("f %d/%d/%d %d/%d/%d %d/%d/%d", np.repeat(faces + 1, 3, axis=1))


def las(path: Path, points: FloatArray, colors: IntArray) -> None:
    """A LAS or LAZ to the tenth of a millimetre."""
    import laspy

    file = laspy.create(point_format=2, file_version="1.2")
    file.header.scales = [1e-4] * 3
    file.x, file.y, file.z = points.T
    file.red, file.green, file.blue = colors.T.astype(np.uint16) * 257
    file.write(str(path))


def writers(
    vertices: FloatArray, faces: IntArray, colors: IntArray
) -> dict[str, Callable[[Path], bytes | None]]:
    """For each format how its file is written, named by what it is and its suffix."""
    side = round(np.sqrt(len(vertices)))
    many = np.resize(np.arange(len(vertices)), len(faces))  # as many points as there are faces
    points = vertices[many] + np.where(np.arange(len(many)) < len(vertices), 0.0, 0.005)[:, None] * [1, 1, 0]
    points, tints = points.astype(np.float32).astype(np.float64), colors[many]
    scan = trimesh.Trimesh(vertices, faces, vertex_colors=colors, process=False)
    soup = vertices[faces].astype("<f4")
    blank = np.zeros((len(soup), 3), "<f4")

    def facets() -> Iterable[bytes]:
        corners = rows("  vertex %.6f %.6f %.6f", soup.reshape(-1, 3).astype(np.float64)).split(b"\n")
        for k in range(0, len(corners) - 1, 3):
            yield b"facet normal 0 0 1\n outer loop\n" + b"\n".join(corners[k : k + 3])
            yield b"\n endloop\nendfacet\n"

    def binary_stl(_: Path) -> bytes:
        table = np.concatenate([blank, soup.reshape(-1, 9)], axis=1).view("u1").reshape(len(soup), 48)
        return bytes(80) + struct.pack("<I", len(soup)) + np.pad(table, ((0, 0), (0, 2))).tobytes()

    even = len(points) // 2 * 2
    count = f"{len(points)}\n".encode()
    return {
        "binary.ply": lambda _: ply("binary_little_endian", vertices, colors, faces),
        "text.ply": lambda _: ply("ascii", vertices, colors, faces),
        "plain.obj": lambda _: rows("v %.6f %.6f %.6f", vertices) + rows("f %d %d %d", faces + 1),
        "colours.obj": lambda _: rows("v %.6f %.6f %.6f %d %d %d", vertices, colors)
        + rows("f %d %d %d", faces + 1),
        "texture.obj": lambda path: textured(path, vertices, faces, side),
        "plain.off": lambda _: b"OFF\n%d %d 0\n" % (len(vertices), len(faces))
        + rows("%.6f %.6f %.6f", vertices) + rows("3 %d %d %d", faces),
        "colours.off": lambda _: b"COFF\n%d %d 0\n" % (len(vertices), len(faces))
        + rows("%.6f %.6f %.6f %d %d %d 255", vertices, colors) + rows("3 %d %d %d", faces),
        "binary.stl": binary_stl,
        "text.stl": lambda _: b"solid sheet\n" + b"".join(facets()) + b"endsolid sheet\n",
        "plain.glb": lambda _: trimesh.Trimesh(vertices, faces, process=False).export(file_type="glb"),
        "colours.glb": lambda _: scan.export(file_type="glb"),
        "points.ply": lambda _: ply("binary_little_endian", points, tints),
        "text.pcd": lambda _: pcd("ascii", points, tints),
        "binary.pcd": lambda _: pcd("binary", points, tints),
        "packed.pcd": lambda _: pcd("binary_compressed", points[:even], tints[:even]),
        "points.las": lambda path: las(path, points, tints),
        "points.laz": lambda path: las(path, points, tints),
        "colours.xyz": lambda _: rows("%.6f %.6f %.6f %d %d %d", points, tints),
        "plain.xyz": lambda _: rows("%.6f %.6f %.6f", points),
        "intensity.pts": lambda _: count + rows("%.6f %.6f %.6f -5 %d %d %d", points, tints),
        "named.csv": lambda _: b"x,y,z,r,g,b\n" + rows("%.6f,%.6f,%.6f,%d,%d,%d", points, tints),
    }  # fmt: skip


def high() -> float:
    """Most memory that this process has had, MB; `resource` would count what started it as well."""
    return int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1024


def judge(path: Path, wanted: Path) -> None:
    """Read a file, hold it against arrays, and print what there is to say."""
    warnings.simplefilter("ignore")
    load(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    before, start = high(), time.process_time()
    scan = load(path)
    spent, most = time.process_time() - start, high() - before
    right = np.load(wanted)
    name = path.name
    arrays = 24 * scan.n_vertices + 12 * (0 if scan.is_cloud else scan.n_faces)
    arrays += 3 * scan.n_vertices * (scan.vertex_colors is not None)
    if name == "texture.obj":
        arrays += 3 * scan.n_vertices  # the pixels
    n = min(len(right["points"]), scan.n_vertices) if scan.is_cloud else len(right["vertices"])
    places = right["points"][:n] if scan.is_cloud else right["vertices"]
    if path.suffix == ".stl":
        places, found = right["vertices"][right["faces"]], scan.vertices[scan.faces]
    else:
        found = scan.vertices
    troubles = []
    if found.shape != places.shape or np.abs(found - places).max() > 6e-5:
        troubles.append("places")
    if not scan.is_cloud and path.suffix != ".stl" and not np.array_equal(scan.faces, right["faces"]):
        troubles.append("faces")
    tints = right["tints"][:n] if scan.is_cloud else right["colors"]
    is_plain = "plain" in name or path.suffix == ".stl"
    shown = slice(2 if name == "texture.obj" else 3)  # the picture has two
    found = scan.vertex_colors
    is_right = found is None if is_plain else found is not None
    if not is_plain and is_right:
        is_right = np.abs(found[:, shown].astype(int) - tints[:, shown]).max() <= 1
    if not is_right:
        troubles.append("colours")
    limit = 8 * arrays / MB + 64
    print(
        f"{name:14} {path.stat().st_size / MB:5.0f} MB  {spent:6.2f} s  {most:6.0f} MB of {limit:4.0f}"
        f"{'  TOO MUCH' * (most > limit)}  {'WRONG: ' + ', '.join(troubles) if troubles else 'right'}",
        flush=True,
    )


def main() -> None:
    """Print a row a format."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("formats", nargs="*", help="names of files, as text.ply, or suffixes; all by default")
    parser.add_argument("--millions", type=float, default=1.0)
    parser.add_argument("--judge", nargs=2, type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.judge:
        judge(*options.judge)
        return
    vertices, faces, colors = sheet(round(1e6 * options.millions))
    many = writers(vertices, faces, colors)
    index = np.resize(np.arange(len(vertices)), len(faces))
    with tempfile.TemporaryDirectory() as folder:
        wanted = Path(folder) / "wanted.npz"
        moved = np.where(np.arange(len(index)) < len(vertices), 0.0, 0.005)[:, None] * [1, 1, 0]
        np.savez(
            wanted, vertices=vertices, faces=faces, colors=colors, points=vertices[index] + moved,
            tints=colors[index],
        )  # fmt: skip
        print(f"{len(faces)} faces or points; seconds of CPU, memory above what there was")
        for name, write in many.items():
            if (
                options.formats
                and name not in options.formats
                and name.rpartition(".")[2] not in options.formats
            ):
                continue
            path = Path(folder) / name
            data = write(path)
            if data is not None:
                path.write_bytes(data)
            command = [sys.executable, __file__, "--judge", str(path), str(wanted)]
            if subprocess.run(command, check=False).returncode:
                print(f"{name:14} WRONG: the reader failed")
            path.unlink()


if __name__ == "__main__":
    main()
