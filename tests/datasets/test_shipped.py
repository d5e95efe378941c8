from __future__ import annotations

import subprocess
import sys
import time
from importlib import resources

import numpy as np
import pytest

from scenewidget.datasets import load_room
from scenewidget.datasets.make_room import RECIPE
from scenewidget.datasets.packing import STEP, pack, unpack
from scenewidget.datasets.room import build_room
from scenewidget.datasets.shipped import ROOM_FILE
from scenewidget.engine.mesh import Mesh


@pytest.fixture(scope="module")
def shipped():
    return load_room()


def test_the_shipped_room_is_small_in_the_wheel_and_quick_to_open(shipped):
    size = len(resources.files("scenewidget.datasets").joinpath(ROOM_FILE).read_bytes())
    assert size < 2_000_000
    assert 150_000 <= shipped[0].n_faces <= 300_000
    start = time.process_time()
    load_room()
    assert time.process_time() - start < 0.5


def test_opening_the_shipped_room_does_not_load_the_simulator():
    code = (
        "import sys, scenewidget as sw; sw.datasets.load_room(); "
        "print('scenewidget.datasets.room' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_the_shipped_room_is_what_its_recipe_gives(shipped):
    mesh, truth = shipped
    options = {"style": None, "shape": None, "size": None, "clutter": 8, "relief": 0.004, **RECIPE}
    voxel = options.pop("voxel")
    _, scene, turn, _ = build_room(**options)
    assert set(truth.names) <= set(scene.names)
    assert len(truth.names) >= len(scene.names) - 4  # a mug may be hidden
    cos, sin = np.cos(turn), np.sin(turn)
    some = np.random.default_rng(0).choice(mesh.n_faces, 5000, replace=False)
    x, y, z = mesh.face_centroids[some].T
    distance, part = scene.nearest(np.stack([cos * x - sin * y, sin * x + cos * y, z]))
    named = np.array(truth.names)[truth.labels[some]]
    assert (named == np.array(scene.names)[scene.part_thing[part]]).mean() > 0.9  # the warp moves it by 1 cm
    assert np.median(np.abs(distance)) < 0.02
    assert mesh.n_faces == pytest.approx(2.5 * mesh.face_areas.sum() / voxel**2, rel=0.2)


def test_packing_loses_nothing_but_half_a_step():
    rng = np.random.default_rng(0)
    vertices, colors = rng.normal(size=(50, 3)), rng.integers(0, 256, (50, 3), dtype=np.uint8)
    faces = rng.integers(0, 50, (120, 3))
    labels, names = rng.integers(-1, 4, 120), ("floor", "wall", "chair 1", "Stuhl ä")
    mesh = Mesh(vertices, faces, colors)
    packed, packed_labels, packed_names = unpack(pack(mesh, labels, names))
    np.testing.assert_allclose(packed.vertices[packed.faces], vertices[faces], atol=STEP / 2 + 1e-12)
    np.testing.assert_array_equal(packed.vertex_colors[packed.faces], colors[faces])
    np.testing.assert_array_equal(packed_labels, labels)
    assert packed_names == names


def test_packing_wants_colours():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(ValueError, match="mesh has no vertex_colors"):
        pack(mesh, np.zeros(1, dtype=np.int32), ("a",))
