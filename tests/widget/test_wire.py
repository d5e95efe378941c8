"""What crosses to the browser, bit by bit."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from sent import array
from shapes import box, grid_square

from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import Mesh
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.wire import compact, face_bits, header, unit_codes, unpacked


def test_vertices_are_precise_far_from_the_origin():
    near, far = box(3), box(3)
    far = Mesh(near.vertices + np.array([4.5e5, 5.2e6, 100.0]), near.faces)
    np.testing.assert_allclose(
        array(SceneView(far), "vertices"), array(SceneView(near), "vertices"), atol=1e-6
    )
    np.testing.assert_array_equal(array(SceneView(far), "faces"), near.faces)


def test_unused_vertices_do_not_move_the_middle():
    mesh = grid_square(2)
    stray = Mesh(np.vstack([mesh.vertices, [1e6, 0, 0]]), mesh.faces)
    sent = array(SceneView(stray), "vertices")
    np.testing.assert_allclose(sent[:-1], array(SceneView(mesh), "vertices"))
    np.testing.assert_array_equal(sent[-1], 0)


def test_points_cross_with_what_their_discs_need():
    points = np.random.default_rng(0).random((50, 3)) * (1, 1, 0)
    sent = SceneView(PointCloud(points, viewpoint=(0.5, 0.5, 2)))
    assert array(sent, "vertices").shape == (50, 3)
    np.testing.assert_array_equal(array(sent, "normals"), [[0, 0, 127, 127]] * 50)
    np.testing.assert_allclose(array(sent, "areas"), PointCloud(points).face_areas, rtol=1e-6)
    assert "faces" not in sent._headers
    assert (array(SceneView(PointCloud(points)), "normals")[:, 3] == 0).all()  # their side is a guess
    assert repr(sent) == "SceneView(50 points)"
    alone = SceneView(PointCloud([[1.0, 2, 3]]))
    assert array(alone, "areas")[0] > 0


@given(hnp.arrays(st.sampled_from([np.uint8, np.uint32, np.float32]), hnp.array_shapes(min_side=0)))
def test_bytes_and_header_are_the_array(array):
    again = unpacked(array.tobytes(), header(array))
    assert again.dtype == array.dtype
    np.testing.assert_array_equal(again, array)


@given(st.sets(st.integers(0, 300)))
def test_a_set_of_faces_has_a_bit_a_face(faces):
    first, bits = face_bits(np.array(sorted(faces), int))
    assert {first + i for i in range(8 * len(bits)) if bits[i // 8] >> i % 8 & 1} == faces


@given(hnp.arrays(np.float64, st.integers(0, 9), elements=st.floats(0, 1) | st.just(np.nan)))
def test_codes_keep_shares_to_a_65534th_and_say_what_is_unknown(values):
    codes = unit_codes(values)
    np.testing.assert_array_equal(codes == 0, np.isnan(values))
    known = codes > 0
    np.testing.assert_allclose((codes[known] - 1.0) / 65534, values[known], atol=0.5 / 65534)


def test_labels_take_two_bytes_while_these_suffice():
    labels = np.array([5, -1, 65534])
    assert compact(labels, 65535).dtype == np.uint16
    assert compact(labels, 65536).dtype == np.uint32
    assert compact(labels, 65535).tolist() == [5, 65535, 65534]
