"""Point clouds: discs in closed form, consistent normals, readers, and the method on sampled rooms."""

import struct

import numpy as np
import pytest
import shapes
import trimesh

import scenewidget as sw
from scenewidget.datasets import load_room
from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.features import delta_coordinates
from scenewidget.engine.mesh import Mesh, MeshError, face_adjacency
from scenewidget.engine.moments import face_moments, group_moments
from scenewidget.engine.operators import cotangent_laplacian, eigenbasis, uniform_laplacian
from scenewidget.engine.readers import load, load_cloud
from scenewidget.engine.readers.e57 import _stations
from scenewidget.engine.units import _above_floor, likely_unit
from scenewidget.figures.drawing import draw


def sampled(mesh, n, *, noise=0.0, seed=0):
    """Points spread over the area of a mesh, and the face of each."""
    rng = np.random.default_rng(seed)
    face = rng.choice(mesh.n_faces, n, p=mesh.face_areas / mesh.face_areas.sum())
    u, v = rng.random((2, n, 1))
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[face]], 1, 0)
    root = np.sqrt(u)
    return (1 - root) * a + root * (1 - v) * b + root * v * c + noise * rng.normal(size=(n, 3)), face


def test_a_plane_of_points_has_its_area_normal_and_moments():
    points, _ = sampled(shapes.grid_square(2, size=2.0), 20_000)
    cloud = PointCloud(points, viewpoint=(1, 1, 5))
    np.testing.assert_allclose(cloud.face_normals, [[0, 0, 1]] * 20_000, atol=1e-9)
    assert cloud.face_areas.sum() == pytest.approx(4, rel=0.15)
    moments = face_moments(cloud).gather(np.zeros(20_000, int), 1)
    spread = moments.scatter[0] / moments.area[0]
    np.testing.assert_allclose(np.diag(spread), [1 / 3, 1 / 3, 0], atol=0.02)


def test_normals_are_consistent_without_a_viewpoint():
    ball = shapes.icosphere(3)
    points, _ = sampled(ball, 5_000)
    looks = np.einsum("ij,ij->i", PointCloud(points).face_normals, points)
    assert max((looks > 0).mean(), (looks < 0).mean()) > 0.99


def things_on_a_table(*, upside_down=False, n=20_000):
    """Points on a table of 1 m and on three boxes that stand on it, where a camera above sees them."""
    rng = np.random.default_rng(0)
    points, normals = [np.c_[rng.random((n, 2)), np.zeros(n)]], [np.tile([0.0, 0, 1], (n, 1))]
    for x, y, height in ((0.1, 0.2, 0.1), (0.6, 0.1, 0.2), (0.4, 0.7, 0.3)):
        m, side = n // 25, 0.2
        points.append(np.c_[x + side * rng.random((m, 1)), y + side * rng.random((m, 1)), np.full(m, height)])
        normals.append(np.tile([0.0, 0, 1], (m, 1)))
        is_covered = ((points[0][:, :2] > (x, y)) & (points[0][:, :2] < (x + side, y + side))).all(axis=1)
        points[0], normals[0] = points[0][~is_covered], normals[0][~is_covered]
    turn = np.diag([1.0, -1.0, -1.0]) if upside_down else np.eye(3)
    return np.concatenate(points) @ turn, np.concatenate(normals) @ turn


@pytest.mark.parametrize("upside_down", [False, True])
def test_a_table_of_points_is_seen_from_the_side_on_which_things_stand(upside_down):
    points, normals = things_on_a_table(upside_down=upside_down)
    found = PointCloud(points).face_normals  # boxes float: what lies under them nobody sees
    assert np.mean(np.einsum("ij,ij->i", found, normals) > 0.9) > 0.99


@pytest.mark.parametrize("digits", [8, 2])  # the second has points at one place and equal distances
def test_pairs_are_those_of_the_six_nearest_within_reach(digits):
    points = np.round(sampled(shapes.icosphere(2), 900)[0], digits)
    cloud = PointCloud(points, np.tile([0.0, 0, 1], (900, 1)))  # all look to one side
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    reach = 3 * np.median(np.sort(apart)[:, 6])
    pairs = cloud._adjacency
    assert len({tuple(pair) for pair in pairs.tolist()}) == len(pairs)
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert (np.diff(pairs @ [900, 1]) > 0).all()
    sixth = np.minimum(np.sort(apart)[:, 6], reach)
    i, j = np.nonzero(np.triu(apart < 0.999999 * np.maximum(sixth, sixth[:, None]), 1))
    assert {*zip(i.tolist(), j.tolist())} <= {tuple(pair) for pair in pairs.tolist()} or digits == 2
    assert (apart[pairs[:, 0], pairs[:, 1]] <= 1.000001 * np.maximum(*sixth[pairs.T])).all()


def test_planes_spread_least_along_their_normals():
    points = sampled(shapes.icosphere(2), 700, noise=0.02)[0]
    cloud = PointCloud(points, viewpoint=(0, 0, 0))
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    around = points[np.argsort(apart, axis=1)[:, :7]]
    around = around - around.mean(axis=1, keepdims=True)
    least = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0]
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", least, cloud.face_normals)), 1, atol=1e-9)


def test_points_on_a_line_have_no_normals():
    cloud = PointCloud(np.outer(np.arange(40.0), [1.0, 2.0, -0.5]), viewpoint=(5, 0, 0))
    assert not cloud.face_normals.any()


def test_sums_over_groups_of_points_are_those_of_their_discs():
    points, face = sampled(shapes.icosphere(1), 500)
    cloud = PointCloud(points, shapes.icosphere(1).face_normals[face])
    group = np.random.default_rng(0).integers(-1, 4, 500)
    expected, found = face_moments(cloud).gather(group, 4), group_moments(cloud, group, 4)
    np.testing.assert_allclose(found.second, expected.second, atol=1e-14)
    np.testing.assert_allclose(found.first, expected.first, atol=1e-14)


def test_sheets_apart_and_back_to_back_are_not_neighbours():
    points, _ = sampled(shapes.grid_square(2), 4_000)
    two = np.concatenate([points, np.add(points, (0, 0, 0.5))])
    pairs = face_adjacency(PointCloud(two, normals=[[0, 0, 1]] * 8_000))
    assert (np.diff(pairs >= 4_000, axis=1) == 0).all()
    normals = np.repeat([[0, 0, 1], [0, 0, -1]], 4_000, axis=0)
    pairs = face_adjacency(
        PointCloud(np.concatenate([points, np.add(points, (0, 0, 0.003))]), normals=normals)
    )
    assert (np.diff(pairs >= 4_000, axis=1) == 0).all()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.empty((0, 3)), "at least one, got"),
        (np.zeros((3, 2)), r"points must have shape \(n_points, 3\)"),
        ([[0, 0, np.nan]], "NaN or infinite positions in 1 rows; drop them"),
    ],
)
def test_bad_points_are_refused(points, message):
    with pytest.raises(MeshError, match=message):
        PointCloud(points)
    with pytest.raises(MeshError, match=r"normals must have shape \(2, 3\)"):
        PointCloud(np.eye(3)[:2], normals=np.eye(3))


@pytest.mark.parametrize(
    "points", [np.zeros((1, 3)), np.zeros((50, 3)), np.eye(3), np.arange(90.0).reshape(30, 3)]
)
def test_points_without_a_surface_give_an_answer_or_a_clear_error(points):
    cloud = PointCloud(points)
    assert np.isfinite(cloud.face_normals).all()
    try:
        assert len(sw.segment(cloud).labels) == len(points)
    except MeshError as error:
        assert "no surface" in str(error)  # noqa: PT017  # either is right


def test_a_sampled_room_is_segmented_as_well_as_its_mesh():
    mesh, truth = sw.datasets.simulate_room(seed=3, voxel=0.05, n_objects=5)
    points, face = sampled(mesh, 40_000, noise=0.002)
    params = sw.Params(n_items=1_500)
    seg = sw.segment(PointCloud(points, normals=mesh.face_normals[face]), params)
    error = sw.metrics.rand_index_error(seg.labels, truth.labels[face])
    assert error < sw.metrics.rand_index_error(sw.segment(mesh, params).labels, truth.labels) + 0.03


POINTS = np.array([[0, 0, 0], [1.5, 0, 0], [0, 1, 0.25], [1, 1, 1]], dtype=np.float32)
RED = 0xFF0000


def pcd(form, body, n=4, fields="x y z rgb", viewpoint="0 0 0 1 0 0 0"):
    k = len(fields.split())
    head = f"# .PCD v.7\nVERSION .7\nFIELDS {fields}\nSIZE {'4 ' * k}\nTYPE F F F U\nCOUNT {'1 ' * k}\n"
    head += f"WIDTH {n}\nHEIGHT 1\nVIEWPOINT {viewpoint}\nPOINTS {n}\nDATA {form}\n"
    return head.encode() + body


def literal_lzf(data):
    runs = [data[i : i + 32] for i in range(0, len(data), 32)]
    return b"".join(bytes([len(run) - 1]) + run for run in runs)


ROWS = b"".join(struct.pack("<3fI", *row, RED) for row in POINTS)
COLUMNS = POINTS.T.tobytes() + struct.pack("<4I", *[RED] * 4)
PACKED = literal_lzf(COLUMNS)
FILES = {
    "ascii.pcd": pcd("ascii", b"".join(b"%g %g %g %d\n" % (*row, RED) for row in POINTS.tolist())),
    "binary.pcd": pcd("binary", ROWS),
    "squeezed.pcd": pcd("binary_compressed", struct.pack("<2I", len(PACKED), len(COLUMNS)) + PACKED),
    "a.xyz": b"".join(b"%g %g %g 255 0 0\n" % tuple(row) for row in POINTS.tolist()),
    "a.pts": b"4\n" + b"".join(b"%g %g %g -7 255 0 0\n" % tuple(row) for row in POINTS.tolist()),
    "a.csv": b"\xef\xbb\xbfX,Y,Z,Red,Green,Blue\r\n"
    + b"".join(b"%g,%g,%g,255,0,0\r\n" % tuple(row) for row in POINTS.tolist()),
    "a.ply": b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    b"property float z\n"
    b"property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    + b"".join(b"%g %g %g 255 0 0\n" % tuple(row) for row in POINTS.tolist()),
}


def written(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("name", FILES)
def test_every_format_gives_points_and_colours(tmp_path, name):
    cloud = load(written(tmp_path, name, FILES[name]))
    assert isinstance(cloud, PointCloud)
    np.testing.assert_allclose(cloud.points, POINTS)
    assert cloud.vertex_colors.tolist() == [[255, 0, 0]] * 4


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_las_and_laz_give_points_and_colours_and_no_half_of_them(tmp_path, suffix):
    laspy = pytest.importorskip("laspy")
    pytest.importorskip("lazrs")
    las = laspy.create(point_format=3, file_version="1.2")
    las.header.scales = [0.001] * 3
    las.x, las.y, las.z = POINTS.astype(float).T
    las.red, las.green, las.blue = [65535] * 4, [0] * 4, [0] * 4
    path = tmp_path / f"a.{suffix}"
    las.write(path)
    cloud = load(path)
    np.testing.assert_allclose(cloud.points, POINTS, atol=1e-3)
    assert cloud.vertex_colors.tolist() == [[255, 0, 0]] * 4
    data = bytearray(path.read_bytes())
    with pytest.raises(MeshError, match=r"cut\.la"):
        load(written(tmp_path, f"cut.{suffix}", bytes(data[: -34 if suffix == "las" else -60])))
    forged = bytearray(data)
    struct.pack_into("<I", forged, 100, 10**9)  # records before the points
    with pytest.raises(MeshError, match="promises 1000000000 records of its header"):
        load(written(tmp_path, f"records.{suffix}", bytes(forged)))
    if suffix == "laz":  # of nothing: at that the library panics, which is no Exception
        forged = bytearray(data)
        struct.pack_into("<H", forged, data.index(b"laszip encoded") - 2 + 54 + 32, 0)
        with pytest.raises(MeshError, match=r"'empty\.laz' is damaged"):
            load(written(tmp_path, "empty.laz", bytes(forged)))
    struct.pack_into("<I", data, 107, 10**9)
    with pytest.raises(MeshError, match=r"promises 1000000000 points|GB of points"):
        load(written(tmp_path, f"forged.{suffix}", bytes(data)))


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.pcd", FILES["binary.pcd"][:-1], "promises 4 points, but only 63 bytes"),
        ("a.pcd", pcd("binary", ROWS, n=10**9), "asks for 16 GB|promises 1000000000 points"),
        ("a.pcd", FILES["ascii.pcd"][:-20], "promises 4 points, 3 are there"),
        ("a.pcd", FILES["squeezed.pcd"][:-1], "4 points don't fit its"),
        ("a.pcd", pcd("zipped", b""), "form 'zipped', which PCD doesn't know"),
        ("a.pts", FILES["a.pts"].replace(b"4\n", b"9\n", 1), "first line promises 9 points, 4 follow"),
        ("a.xyz", b"0 0 0\n1 1\n", "line 2 of its points has 2 numbers"),
        ("a.xyz", b"hello world\n1 2\n", "has no columns x, y and z"),
        ("a.csv", b"a,b,c\n1,2,3\n", "has no columns x, y and z"),
        ("a.stl", b"solid a\nfacet normal 0 0 1\n", "is a mesh"),
        ("a.e57", b"ASTM-E57" + bytes(40), "damaged or truncated"),
        ("a.las", b"LASF" + bytes(40), "truncated inside its header"),
    ],
)
def test_a_damaged_cloud_is_refused_with_its_name(tmp_path, name, data, message):
    with pytest.raises(MeshError, match=message) as caught:
        load_cloud(written(tmp_path, name, data))
    assert name in str(caught.value)


def test_points_that_are_not_finite_are_left_out_and_counted(tmp_path):
    path = written(tmp_path, "a.xyz", b"0 0 0\nnan 0 0\n1 1 1\n0 1 0\n")
    cloud = load_cloud(path)
    assert cloud.faces_of_file.tolist() == [0, 2, 3]
    assert cloud.report == ("1 of 4 points were NaN, infinite or far from all others, and were left out",)
    with pytest.raises(MeshError, match="1 of 4 points are NaN"):
        load_cloud(path, strict=True)


def test_a_cloud_in_millimetres_is_noticed_and_scaled(tmp_path):
    text = "".join(f"{x} {y} 0\n" for x in range(0, 5000, 500) for y in range(0, 4000, 500))
    path = written(tmp_path, "a.xyz", text.encode())
    with pytest.warns(UserWarning, match="looks as if it were in millimetres"):
        assert np.ptp(load_cloud(path).points) == 4500
    assert np.ptp(load_cloud(path, units="auto").points) == 4.5
    assert np.ptp(load_cloud(path, units="cm").points) == 45


@pytest.mark.parametrize("source", [None, 3, {"a": 1}])
def test_what_is_no_cloud_is_refused(source):
    with pytest.raises(TypeError, match="cloud must be a path or an"):
        load_cloud(source)


def test_a_mesh_stays_a_mesh():
    assert type(load((np.eye(3), [[0, 1, 2]]))) is Mesh


def test_the_laplacian_of_a_sphere_has_the_eigenvalues_and_the_curvature_of_the_sphere():
    points = np.random.default_rng(0).normal(size=(2_000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    ball = PointCloud(points, normals=points)
    W, A = cotangent_laplacian(ball)
    assert abs(W - W.T).max() < 1e-9
    assert abs(W.sum(axis=1)).max() < 1e-9
    assert A.diagonal().sum() == pytest.approx(4 * np.pi, rel=0.1)
    np.testing.assert_allclose(eigenbasis(ball, 9).values, [0, 2, 2, 2, 6, 6, 6, 6, 6], rtol=0.1)
    outward = np.einsum("ij,ij->i", delta_coordinates(ball), points)
    assert np.median(outward) == pytest.approx(2, rel=0.05)  # twice the mean curvature


def test_the_laplacian_of_a_square_has_that_of_free_ends_and_sheets_stay_apart():
    points = np.random.default_rng(1).random((2_000, 3)) * (1, 1, 0)
    np.testing.assert_allclose(
        eigenbasis(PointCloud(points, viewpoint=(0, 0, 5)), 4).values,
        np.pi**2 * np.array([0, 1, 1, 2]),
        rtol=0.06,
        atol=1e-9,
    )
    two = PointCloud(np.concatenate([points, points + np.array([0, 0, 1])]), normals=[[0, 0, 1]] * 4_000)
    assert eigenbasis(two, 3).n_components == 2
    assert uniform_laplacian(two)[0].sum() == 0
    with pytest.raises(MeshError, match="no three neighbours of the cloud make a triangle"):
        cotangent_laplacian(PointCloud([[0, 0, 0], [1, 0, 0]]))


@pytest.mark.parametrize("params", [sw.Params(feature="wks", n_items=200), sw.Params.thesis(n_items=400)])
def test_features_and_the_thesis_preset_take_clouds(params):
    points, face = sampled(shapes.box(4), 3_000)
    cloud = PointCloud(points, normals=shapes.box(4).face_normals[face])
    seg = sw.segment(cloud, params.replace(n_segments=6, n_runs=4))
    assert seg.coverage > 0.95
    error = sw.metrics.rand_index_error(seg.labels, np.argmax(np.abs(cloud.face_normals) @ np.eye(3), axis=1))
    assert error < 0.35
    if seg.simplified is not None:
        assert 200 < seg.simplified.n_faces <= 400
        assert seg.simplified.face_areas.sum() == pytest.approx(cloud.face_areas.sum(), rel=0.03)


def test_borders_of_clouds_have_lengths_and_cuts_between_them_agree_with_themselves():
    points, _ = sampled(shapes.grid_square(2, size=2.0), 8_000)
    cloud = PointCloud(points, normals=[[0, 0, 1]] * 8_000)
    side = (cloud.points[:, 0] > 1).astype(int)
    pairs = face_adjacency(cloud)
    across = pairs[side[pairs[:, 0]] != side[pairs[:, 1]]]
    assert cloud.seam_lengths(across).sum() == pytest.approx(2, rel=0.15)
    other = (cloud.points[:, 0] > 1.2).astype(int)
    assert sw.metrics.cut_discrepancy(side, side, cloud) == 0
    shift = sw.metrics.cut_discrepancy(side, other, cloud)
    assert shift == pytest.approx(0.4 / 0.765, rel=0.1)  # there and back


def test_a_figure_of_a_cloud_has_a_triangle_a_point():
    points, _ = sampled(shapes.grid_square(2), 500)
    cloud = PointCloud(points, viewpoint=(0.5, 0.5, 3))
    drawing = draw(cloud, labels=(points[:, 0] > 0.5).astype(int))
    area = np.linalg.norm(np.cross(*np.diff(drawing.corners, axis=1).transpose(1, 0, 2)), axis=1).sum() / 2
    assert drawing.corners.shape == (500, 3, 3)
    assert area > 2 * cloud.face_areas.sum()
    with pytest.raises(ValueError, match="edges and isolines are drawn along faces, and a cloud has none"):
        draw(cloud, edges=True)


def test_an_e57_says_where_the_scanner_stood_for_each_point():
    scan = "<vectorChild><points recordCount='2'/><pose><translation><x>{}</x><y>2</y><z>3</z></translation>"
    scan += "</pose></vectorChild>"
    xml = "<e57Root xmlns='http://www.astm.org/COMMIT/E57/2010-e57-v1.0'><data3D>"
    xml += scan.format(1) + scan.format("")
    xml += "</data3D></e57Root>"
    assert _stations(xml, 4).tolist() == [[1, 2, 3]] * 2 + [[0, 2, 3]] * 2
    assert _stations(xml, 5) is None  # some were invalid
    assert _stations("<e57Root>", 4) is None


@pytest.mark.parametrize(
    ("name", "text"),
    [("a.csv", "X;Y;Z;Red;Green;Blue\n0,5;1,25;2;9;8;7\n1,5;2;3;9;8;7\n"),
     ("a.asc", "//X Y Z R G B Scalar_field\n2\n0.5 1.25 2 9 8 7 .1\n1.5 2 3 9 8 7 .2\n"),
     ("a.pcd", "VERSION .7\nFIELDS X Y Z Red Green Blue\nSIZE 4 4 4 1 1 1\nTYPE F F F U U U\n"
      "COUNT 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n0.5 1.25 2 9 8 7\n1.5 2 3 9 8 7\n")],
)  # fmt: skip
def test_decimal_commas_counts_behind_names_and_names_in_capitals_are_read(tmp_path, name, text):
    cloud = load(written(tmp_path, name, text.encode()))
    assert cloud.points.tolist() == [[0.5, 1.25, 2], [1.5, 2, 3]]
    assert cloud.vertex_colors.tolist() == [[9, 8, 7]] * 2


def test_a_trimesh_of_points_is_a_cloud_and_a_cloud_is_scaled_when_told_its_unit():
    points = np.random.default_rng(0).random((50, 3))
    cloud = load(trimesh.PointCloud(points, colors=np.full((50, 4), 9, np.uint8)))
    assert isinstance(cloud, PointCloud)
    assert cloud.vertex_colors.tolist() == [[9, 9, 9]] * 50
    np.testing.assert_allclose(load_cloud(cloud, units="mm").points, points / 1000)


def test_a_floor_of_which_part_looks_down_is_the_floor():
    floor, counter = (sampled(shapes.grid_square(2, size=size), 4_000)[0] for size in (4.0, 3.0))
    cloud = PointCloud(np.concatenate([floor, np.add(counter[:2_500], (0, 0, 0.9))]))
    looks = np.where(np.arange(6_500) < 3_000, -1.0, 1.0)  # as where nobody tells the sides of points
    vars(cloud)["face_normals"] = looks[:, None] * [0.0, 0.0, 1.0]
    assert _above_floor(cloud, np.array([0.0, 0.0, 1.0])) == pytest.approx((0.9, 0.9), abs=0.02)


@pytest.mark.parametrize(
    ("per_metre", "factor"), [(1000, 0.001), (100, 0.01), (1 / 0.0254, 0.0254), (1 / 0.3048, 0.3048)]
)
def test_the_unit_of_a_cloud_is_told_by_its_planes(per_metre, factor):
    points, _ = sampled(load_room()[0], 40_000, noise=0.002)
    assert likely_unit(PointCloud(points * per_metre)).factor == factor
