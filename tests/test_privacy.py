"""What leaves the machine says nothing of whose machine it was."""

import socket

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.widget.scene_view import SceneView

KINDS = ("csv", "glb", "npy", "npz", "parquet", "ply", "scannet", "scenenn", "txt")


@pytest.fixture
def scan(tmp_path):
    """A scan out of somebody's home, with labels."""
    home, box = tmp_path / "home of somebody", shapes.box(4)
    home.mkdir()
    sw.export(sw.Segmentation.from_labels(box, np.arange(192) // 32), box, home / "scan.ply")
    mesh = sw.load_mesh(home / "scan.ply")
    assert "somebody" in mesh.source
    return mesh, sw.import_labels(mesh, home / "scan.ply")


def test_exports_and_pages_say_nothing_of_people(scan, tmp_path):
    mesh, seg = scan
    out = tmp_path / "out"
    out.mkdir()
    for kind in KINDS:
        sw.export(seg, mesh, out / f"{kind}.out", kind)
    view = SceneView(mesh)
    view.to_html(out / "page.html")
    view.close()
    written = {path.name: path.read_bytes() for path in out.iterdir()}
    assert len(written) > len(KINDS)
    words = (b"somebody", socket.gethostname().encode() + b'"', str(tmp_path).encode())
    assert {name: word for name, data in written.items() for word in words if word in data} == {}
