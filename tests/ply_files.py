"""PLY files as other programs write them: read through trimesh, written from the format's definition.

The format: Turk (1994), The PLY Polygon File Format.
"""

import numpy as np
import trimesh

WORDS = "char uchar short ushort int uint float double"
TYPES = dict(zip(("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"), WORDS.split()))


def read(path):
    """The elements of a file as trimesh reads them: name -> structured array, a list of three as (n, 3)."""
    raw = trimesh.load(path, process=False).metadata["_ply_raw"]
    return {
        name: {p: _plain(element["data"][p]) for p in element["properties"]} for name, element in raw.items()
    }


def _plain(values):
    return values["f1"] if values.dtype.names else values


def write(path, elements, *, text=False, order="<"):
    """Write elements, name -> structured array; a field of shape (3,) becomes a list property."""
    kind = "ascii" if text else {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = ["ply", f"format {kind} 1.0", "comment written by a test"]
    for name, rows in elements.items():
        header.append(f"element {name} {len(rows)}")
        for field in rows.dtype.names:
            part = rows.dtype[field]
            word = TYPES[part.base.str[1:]]
            header.append(f"property list uchar {word} {field}" if part.shape else f"property {word} {field}")
    with path.open("wb") as file:
        file.write(("\n".join([*header, "end_header"]) + "\n").encode())
        for rows in elements.values():
            file.write(_text(rows) if text else _binary(rows, order))


def _text(rows):
    def words(row):
        for value in row:
            if np.ndim(value):
                yield str(len(value))
                yield from (str(v) for v in value)
            else:
                yield repr(float(value)) if isinstance(value, np.floating) else str(value)

    return "".join(" ".join(words(row)) + "\n" for row in rows).encode()


def _binary(rows, order):
    fields = []
    for field in rows.dtype.names:
        part = rows.dtype[field]
        if part.shape:
            fields.append((f"n {field}", "u1"))
        fields.append((field, part.base.newbyteorder(order), part.shape))
    packed = np.zeros(len(rows), dtype=fields)
    for field in rows.dtype.names:
        packed[field] = rows[field]
        if rows.dtype[field].shape:
            packed[f"n {field}"] = rows.dtype[field].shape[0]
    return packed.tobytes()
