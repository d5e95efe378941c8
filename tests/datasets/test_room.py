from __future__ import annotations

from types import MappingProxyType

import numba
import numpy as np
import pytest

from scenewidget.datasets import SCANNERS, simulate_room
from scenewidget.datasets.layout import STYLES
from scenewidget.datasets.room import build_room
from scenewidget.engine.mesh import Mesh, connected_components, face_adjacency
from scenewidget.engine.segmentation import Segmentation

SMALL = MappingProxyType(
    {"size": (3.2, 2.8, 2.4), "voxel": 0.05, "n_objects": 5, "clutter": 2, "unseen": 0.7}
)


@pytest.fixture(scope="module")
def scan() -> tuple[Mesh, Segmentation]:
    return simulate_room(seed=3, voxel=0.03, warp=0.0)


@pytest.fixture(scope="module")
def clean() -> tuple[Mesh, Segmentation]:
    return simulate_room(seed=3, voxel=0.03, **SCANNERS["clean"])


def room_behind(seed: int = 3, relief: float = 0.004, **options):
    base = {"n_objects": 12, "clutter": 8, "style": None, "shape": None, "size": None}
    return build_room(**{**base, **options}, seed=seed, relief=relief)


def to_room(points: np.ndarray, turn: float) -> np.ndarray:
    cos, sin = np.cos(turn), np.sin(turn)
    return points @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]).T


def faces_of(truth: Segmentation, name: str) -> np.ndarray:
    return np.flatnonzero(truth.labels == truth.names.index(name))


def border_share(mesh: Mesh) -> float:
    """Share of edges that only one face has."""
    n_inner = len(face_adjacency(mesh))
    return (3 * mesh.n_faces - 2 * n_inner) / (3 * mesh.n_faces - n_inner)


# --- what it is ------------------------------------------------------------------------------------


def test_a_scan_has_named_things_and_colours(scan):
    mesh, truth = scan
    assert {"floor", "ceiling", "wall south", "wall west", "door 1"} <= set(truth.names)
    assert len(set(truth.names)) == truth.n_segments >= 20
    assert mesh.vertex_colors.std(axis=0).min() > 10
    assert truth.coverage == 1


def test_each_face_belongs_to_what_is_nearest(scan):
    mesh, truth = scan
    _, scene, turn, _ = room_behind()
    centroids = to_room(mesh.face_centroids, turn)
    some = np.random.default_rng(0).choice(mesh.n_faces, 3000, replace=False)
    each = np.stack(
        [part.shape.distance(centroids[some].T.astype(np.float32)) for part in scene.parts]
    )  # brute force
    owner = scene.part_thing[each.argmin(axis=0)]
    expected = np.array(scene.names)[owner]
    assert (np.array(truth.names)[truth.labels[some]] == expected).mean() > 0.999  # ties apart
    assert np.percentile(np.abs(each.min(axis=0)), 95) < 0.03


def test_a_picture_is_where_the_picture_hangs(clean):
    mesh, truth = clean
    _, scene, turn, _ = room_behind(relief=0.0)
    thing = scene.things[scene.names.index("picture 1")]
    low = np.min([part.shape.low for part in thing.parts], axis=0)
    high = np.max([part.shape.high for part in thing.parts], axis=0)
    found = to_room(mesh.face_centroids[faces_of(truth, "picture 1")], turn)
    assert len(found) > 50
    assert (found > low - 0.02).all()
    assert (found < high + 0.02).all()


def test_a_clean_room_is_plane_closed_and_exact(clean):
    mesh, truth = clean
    floor = faces_of(truth, "floor")
    is_flat = mesh.face_normals[floor, 2] > 0.999
    assert is_flat.mean() > 0.95
    assert np.abs(mesh.face_centroids[floor[is_flat], 2]).max() < 0.002
    assert border_share(mesh) < 0.003
    plan, _, _, _ = room_behind(relief=0.0)
    ceiling = faces_of(truth, "ceiling")
    assert mesh.face_areas[ceiling].sum() == pytest.approx(
        plan.size[0] * plan.size[1], rel=0.3 if plan.notch else 0.05
    )


def test_normals_point_into_the_free_space(scan, clean):
    for mesh, relief in ((scan[0], 0.004), (clean[0], 0.0)):
        _, scene, turn, _ = room_behind(relief=relief)
        front = to_room(mesh.face_centroids + 0.02 * mesh.face_normals, turn)
        back = to_room(mesh.face_centroids - 0.02 * mesh.face_normals, turn)
        is_right = scene.nearest(front.T)[0] > scene.nearest(back.T)[0]
        assert mesh.face_areas[is_right].sum() / mesh.face_areas.sum() > 0.97


def test_inside_out_turns_every_face_round():
    mesh, truth = simulate_room(seed=1, **SMALL)
    turned, turned_truth = simulate_room(seed=1, **SMALL, inside_out=True)
    np.testing.assert_allclose(turned.face_normals, -mesh.face_normals, atol=1e-6)
    np.testing.assert_array_equal(turned_truth.labels, truth.labels)


# --- options do what they say ------------------------------------------------------------------------


def test_a_seed_gives_the_same_scan_whatever_the_number_of_threads():
    first, truth = simulate_room(seed=5, **SMALL)
    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        second, again = simulate_room(seed=5, **SMALL)
    finally:
        numba.set_num_threads(before)
    np.testing.assert_array_equal(first.vertices, second.vertices)
    np.testing.assert_array_equal(first.faces, second.faces)
    np.testing.assert_array_equal(first.vertex_colors, second.vertex_colors)
    np.testing.assert_array_equal(truth.labels, again.labels)
    assert truth.names == again.names


def test_another_seed_gives_another_room():
    names = {room_behind(seed)[1].names for seed in range(4)}
    sizes = {room_behind(seed)[0].size for seed in range(4)}
    assert len(names) == len(sizes) == 4


def test_a_finer_voxel_scans_the_same_room_with_more_faces(clean):
    coarse, truth = simulate_room(seed=3, voxel=0.05, **SCANNERS["clean"])
    fine, fine_truth = clean
    ratio = (0.05 / 0.03) ** 2
    assert 0.85 * ratio < fine.n_faces / coarse.n_faces < 1.4 * ratio
    for name in ("floor", "wall south", "wall north", "door 1"):
        areas = [m.face_areas[faces_of(t, name)].sum() for m, t in ((coarse, truth), (fine, fine_truth))]
        assert areas[0] == pytest.approx(areas[1], rel=0.2)


def test_the_face_count_follows_from_area_and_voxel(scan):
    mesh, _ = scan
    assert mesh.n_faces == pytest.approx(2.5 * mesh.face_areas.sum() / 0.03**2, rel=0.2)


def test_noise_is_about_what_was_asked_for():
    spread = []
    for noise in (0.002, 0.008):
        mesh, truth = simulate_room(
            seed=2, **{**SMALL, "n_objects": 0}, noise=noise, relief=0, warp=0, misregistration=0
        )
        height = mesh.face_centroids[faces_of(truth, "floor"), 2]
        spread.append(np.subtract(*np.percentile(height, [75, 25])) / 1.349)
    # cameras are nearer than 2 m in this small room
    assert 0.35 * 0.002 < spread[0] < 1.2 * 0.002
    assert 0.35 * 0.008 < spread[1] < 1.2 * 0.008


def test_less_is_seen_the_fewer_the_stops():
    areas = [
        simulate_room(seed=2, **{**SMALL, "unseen": unseen})[0].face_areas.sum() for unseen in (0.0, 0.5, 1.0)
    ]
    assert areas[0] > 1.1 * areas[1] > 1.3 * areas[2]


def test_what_no_camera_can_see_is_missing(scan, clean):
    under = {}
    for name, (mesh, _) in {"scan": scan, "clean": clean}.items():
        is_down = mesh.face_normals[:, 2] < -0.9
        is_low = mesh.face_centroids[:, 2] < 0.8
        under[name] = mesh.face_areas[is_down & is_low].sum()
    assert under["scan"] < 0.5 * under["clean"]


def test_smoothing_calms_the_normals_and_warp_moves_the_points():
    plain, _ = simulate_room(seed=2, **SMALL, warp=0.0)
    smooth, _ = simulate_room(seed=2, **SMALL, warp=0.0, smoothing=0.1)
    warped, _ = simulate_room(seed=2, **SMALL, warp=0.05)

    def roughness(mesh: Mesh) -> float:
        a, b = face_adjacency(mesh).T
        return float(np.median(1 - (mesh.face_normals[a] * mesh.face_normals[b]).sum(axis=1)))

    assert roughness(smooth) < 0.2 * roughness(plain)
    np.testing.assert_array_equal(plain.faces, warped.faces)
    rms = np.sqrt(((warped.vertices - plain.vertices) ** 2).sum(axis=1).mean())
    assert 0.02 < rms < 0.1


def test_the_default_is_as_hard_as_a_fused_scan():
    # a fused scan of a bedroom (voxel 17 mm) has 5 degrees between neighbouring faces in the median and
    # 10 at the upper quartile, 4.7 % of its edges at borders, 10 000 components a million faces
    mesh, _ = simulate_room(seed=0, voxel=0.028)
    pairs = face_adjacency(mesh)
    cosine = (mesh.face_normals[pairs[:, 0]] * mesh.face_normals[pairs[:, 1]]).sum(axis=1)
    quartiles = np.degrees(np.arccos(np.clip(np.percentile(cosine, [50, 25]), -1, 1)))
    assert 5 < quartiles[0] < 10
    assert 10 < quartiles[1] < 22
    assert border_share(mesh) > 0.025
    n_components, _ = connected_components(mesh.n_faces, pairs)
    assert n_components > 3000e-6 * mesh.n_faces


# --- layouts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("shape", ["rectangle", "L"])
def test_rooms_of_every_style_and_shape_hold_what_was_asked_for(style, shape):
    for seed in range(4):
        plan, scene, _, n_placed = room_behind(seed, style=style, shape=shape, n_objects=16)
        assert n_placed == 16
        assert len(set(scene.names)) == len(scene.names)
        assert len(plan.walls) == (6 if shape == "L" else 4)
        for low, high, part_thing in zip(scene.low, scene.high, scene.part_thing, strict=True):
            if not scene.names[part_thing].startswith(("wall ", "floor", "ceiling", "door", "window")):
                assert (low > -0.15).all()
                assert (high < np.array(plan.size) + 0.15).all()


def test_furniture_does_not_run_through_other_furniture():
    for seed in range(6):
        _, scene, _, _ = room_behind(seed)
        is_furniture = [
            i
            for i, owner in enumerate(scene.part_thing)
            if not scene.names[owner].startswith(("wall ", "floor", "ceiling", "door", "window", "carpet"))
        ]
        rng = np.random.default_rng(seed)
        low, high = scene.low[is_furniture].min(axis=0), scene.high[is_furniture].max(axis=0)
        points = rng.uniform(low, high, (60_000, 3)).T.astype(np.float32)
        depth = np.full((len(scene.things), points.shape[1]), np.inf, dtype=np.float32)
        for i in is_furniture:
            owner = scene.part_thing[i]
            depth[owner] = np.minimum(depth[owner], scene.parts[i].shape.distance(points))
        is_inside = depth < -0.02
        assert (is_inside.sum(axis=0) > 1).sum() <= 0.01 * is_inside.any(axis=0).sum()


def test_a_full_room_says_that_it_is_full():
    with pytest.warns(UserWarning, match=r"only \d+ of n_objects=60 found a place .* larger size"):
        simulate_room(n_objects=60, size=(2.5, 2.5, 2.4), voxel=0.1, clutter=0, **SCANNERS["clean"])


def test_an_empty_room_is_a_room():
    _, truth = simulate_room(n_objects=0, clutter=0, voxel=0.1, shape="rectangle")
    assert {"floor", "wall north", "wall south", "wall east", "wall west"} <= set(truth.names)
    assert not any(name.startswith(("table", "chair", "sofa", "bed")) for name in truth.names)


# --- what is refused -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"seed": -1}, ValueError, "seed must be at least 0, got -1"),
        ({"seed": 1.5}, TypeError, "seed must be a whole number, got 1.5"),
        ({"seed": True}, TypeError, "seed must be a whole number"),
        ({"n_objects": 1000}, ValueError, "n_objects must be from 0 to 200, got 1000"),
        ({"clutter": "many"}, TypeError, "clutter must be a whole number, got 'many'"),
        ({"voxel": 0}, ValueError, "voxel must be from 0.004 to 0.15 metres, got 0"),
        ({"voxel": 20}, ValueError, "voxel .* in millimetres[?] use 0.02"),
        ({"voxel": "fine"}, TypeError, "voxel must be a number, got 'fine'"),
        ({"voxel": 0.004, "size": (12, 12, 3)}, ValueError, "voxel=0.004 would take .* use voxel=0.0"),
        ({"noise": float("nan")}, ValueError, "noise must be from 0 to 0.05 metres, got nan"),
        ({"unseen": 1.5}, ValueError, "unseen must be from 0 to 1, got 1.5"),
        ({"misregistration": -0.1}, ValueError, "misregistration must be"),
        ({"warp": 1.0}, ValueError, "warp must be"),
        ({"relief": 0.2}, ValueError, "relief must be"),
        ({"smoothing": True}, TypeError, "smoothing must be a number, got True"),
        ({"style": "palace"}, ValueError, "style must be one of 'living', .* got 'palace'"),
        (
            {"shape": "round"},
            ValueError,
            "shape must be one of 'rectangle', 'L' or None for any, got 'round'",
        ),
        ({"size": (4, 3)}, ValueError, r"size must be \(width, depth, height\)"),
        ({"size": 4}, TypeError, r"size must be \(width, depth, height\) in metres, got 4"),
        ({"size": (1, 3, 2.5)}, ValueError, "size must be from 1.8 to 30 m"),
        ({"inside_out": 1}, TypeError, "inside_out must be True or False, got 1"),
    ],
)
def test_wrong_options_are_named(options, error, message):
    with pytest.raises(error, match=message):
        simulate_room(**options)
