"""Scenes in SceneNN's format, written byte by byte."""

import struct


def scenenn_ply(vertices, faces, labels, *, layout="<", label_type="ushort", lead=""):
    """The bytes of a PLY as SceneNN has it: position, normal, colour and label a vertex."""
    names = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}
    code = {"ushort": "H", "uint": "I", "float": "f"}[label_type]
    header = f"ply\nformat {names[layout]} 1.0\ncomment a scene\n{lead}element vertex {len(vertices)}\n"
    header += "".join(f"property float {x}\n" for x in ("x", "y", "z", "nx", "ny", "nz"))
    header += "".join(f"property uchar {x}\n" for x in ("red", "green", "blue"))
    header += f"property {label_type} label\nelement face {len(faces)}\n"
    header += "property list uchar int vertex_indices\nend_header\n"
    rows = [(*map(float, v), 0.0, 0.0, 1.0, 200, 100, 50, label) for v, label in zip(vertices, labels)]
    if layout == "":
        lines = [" ".join(map(str, row)) for row in rows] + [f"3 {a} {b} {c}" for a, b, c in faces]
        return (header + "\n".join(lines) + "\n").encode()
    body = b"".join(struct.pack(f"{layout}6f3B{code}", *row) for row in rows)
    return header.encode() + body + b"".join(struct.pack(f"{layout}B3i", 3, *face) for face in faces)
