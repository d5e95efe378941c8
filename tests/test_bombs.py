"""Small files that would unpack to more than a machine has: refused at once, by name, in little memory."""

import io
import struct
import tracemalloc
import zipfile

import numpy as np
import pytest

import scenewidget as sw
from scenewidget.datasets.analytic import square

NESTED = "[" * 20_000 + "]" * 20_000


def glb(path):
    text = NESTED.encode()
    chunk = struct.pack("<II", len(text), 0x4E4F534A) + text
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunk)) + chunk)
    return sw.load(path)


def gltf(path):
    path.write_text(NESTED)
    return sw.load(path)


def aggregation(path):
    path.write_text(NESTED)
    return sw.import_labels(square(4), path)


def archive(path):
    """Labels of 10⁸ faces: 400 MB that take some hundred kilobytes."""
    header = io.BytesIO()
    shape = {"descr": "<i4", "fortran_order": False, "shape": (10**8,)}
    np.lib.format.write_array_header_1_0(header, shape)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file, file.open("labels.npy", "w") as out:
        out.write(header.getvalue())
        for _ in range(100):
            out.write(bytes(4 * 10**6))
    return sw.import_labels(square(4), path)


@pytest.mark.parametrize(
    ("attack", "name"),
    [(glb, "x.glb"), (gltf, "x.gltf"), (aggregation, "x.aggregation.json"), (archive, "x.npz")],
)
def test_what_would_unpack_beyond_measure_is_refused_by_name(attack, name, tmp_path):
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=name.replace(".", r"\.")):
            attack(tmp_path / name)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()
