"""The whole path: what a change recomputes, cancel, progress, threads, memory; scenes with known answers."""

import gc
import threading
import warnings

import numpy as np
import pytest
import shapes
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import adjusted_rand_score
from strategies import nasty_meshes

from scenewidget.engine import stages as stage_table
from scenewidget.engine.memo import n_bytes
from scenewidget.engine.mesh import Mesh, MeshError
from scenewidget.engine.monitor import Cancelled
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline, segment
from scenewidget.engine.segmentation import Segmentation
from scenewidget.engine.stages import stages

BLOB = Mesh(0.3 * shapes.blob(3).vertices, shapes.blob(3).faces)
ROOM = shapes.joined(shapes.room(8, noise=0.003)[0], BLOB)  # something round: many superfacets
FAST = Params(n_items=1000, n_segments=12, k_range=(20, 30), n_runs=4, n_graph_runs=4)
FAITHFUL = Params.thesis(n_segments=12, n_items=400, k_range=(20, 30), n_runs=4)

pytestmark = pytest.mark.filterwarnings("ignore:.*:UserWarning")


def test_distances_too_large_to_keep_are_made_as_they_are_used(monkeypatch):
    kept = Pipeline(ROOM).get("ensemble", FAST)
    monkeypatch.setattr(stage_table, "MOST_GB", 0.0)
    pipe = Pipeline(ROOM)
    np.testing.assert_array_equal(pipe.get("ensemble", FAST), kept)
    large = pipe.get("distances", FAST)
    assert len(large) == len(large[:]) == len(FAST.convex_weights)
    assert n_bytes(large) < large[0].nbytes


def same(a, b):
    np.testing.assert_array_equal(a.labels, b.labels)
    np.testing.assert_array_equal(a.confidence, b.confidence)
    np.testing.assert_array_equal(a.face_map, b.face_map)
    for level in ("dihedral", "base", "final"):
        np.testing.assert_array_equal(a.level(level), b.level(level))
    assert a.report == b.report


# --- the memo -------------------------------------------------------------------------------------

CHANGES = [
    {"n_segments": 5},
    {"n_segments": "auto"},
    {"k_range": (10, 15)},
    {"cost_exponent": 1.75},
    {"hop": 0.1},
    {"convex_weights": (1.0,)},
    {"n_runs": 2},
    {"n_graph_runs": 0},
    {"consensus": "linkage"},
    {"consensus": "median"},
    {"consensus": "peac"},
    {"leftover": "argmax"},
    {"allocation": "faces"},
    {"merge": True},
    {"feature": "cotangent"},
    {"feature": "normals"},
    {"items": "simplified"},
    {"items": "superfacets"},
    {"n_items": 300},
    {"min_area": 0.3},
    {"join_planes": False},
    {"granularity": 9},
    {"granularity": None},
    {"seed": 3},
]


@given(st.lists(st.sampled_from(CHANGES), min_size=1, max_size=5), st.booleans(), st.sampled_from([2e9, 3e5]))
@settings(max_examples=5)
def test_after_any_walk_of_changes_the_memo_gives_what_a_fresh_run_gives(walk, faithful, memory):
    params = FAITHFUL if faithful else FAST
    pipe = Pipeline(ROOM, memory=memory)
    pipe.run(params)
    for change in walk:
        params = params.replace(**change)
        result = pipe.run(params)
    same(result, segment(ROOM, params))


FINISH = {"finish", "segmentation"}
CUT = {"nested", "family", "granularity"}
ENSEMBLE = {"ensemble", "coassociation", "tree", "consensus"} | FINISH
DISTANCES = {"distances"} | ENSEMBLE
GRAPH_RUNS = {"graph_runs"} | ENSEMBLE
ITEMS = {"items", "dihedral", "allocation"} | GRAPH_RUNS | DISTANCES


def recomputed(pipe, params):
    heard = []
    pipe.run(params, progress=lambda stage, fraction: heard.append(stage))
    return set(heard)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, set()),
        ({"n_segments": 20}, CUT),
        ({"consensus": "median"}, {"consensus"} | FINISH),
        ({"consensus": "peac"}, {"trees", "consensus"} | FINISH),
        ({"linkage_similarity": 0.5}, {"consensus"} | FINISH),
        ({"min_area": 0.5}, FINISH),
        ({"join_planes": False}, FINISH),
        ({"granularity": 9}, CUT),
        ({"k_range": (5, 9)}, ENSEMBLE),
        ({"n_runs": 3}, ENSEMBLE),
        ({"n_graph_runs": 3}, GRAPH_RUNS),
        ({"seed": 1}, GRAPH_RUNS),
        ({"merge": True}, ENSEMBLE),
        ({"init": "outmost"}, ENSEMBLE),
        ({"allocation": "same"}, {"allocation"} | ENSEMBLE),
        ({"cost_exponent": 1.5}, GRAPH_RUNS | DISTANCES),
        ({"hop": 0.01}, GRAPH_RUNS | DISTANCES),
        ({"cost_a": 1.1}, DISTANCES),
        ({"cost_b": -0.9}, DISTANCES),
        ({"convex_weights": (0.3,)}, DISTANCES),
        ({"feature": "uniform"}, {"features"} | DISTANCES),
        ({"feature": "hks", "n_eigenpairs": 10}, {"eigenbasis", "features"} | DISTANCES),
        ({"n_slots": 32}, {"dihedral", "allocation"} | ENSEMBLE),
        ({"bridge": 0.01}, ITEMS),
        ({"n_items": 900}, ITEMS),
        ({"items": "simplified"}, ITEMS),
        # options that nothing in this preset looks at
        ({"leftover": "argmax"}, set()),
        ({"simplifier": "qslim"}, set()),
        ({"laplacian": "robust"}, set()),
        ({"n_eigenpairs": 20}, set()),
        ({"feature_floor": 0.5}, set()),
        ({"merge_normal": 0.5}, set()),
    ],
)
def test_a_change_recomputes_exactly_what_depends_on_it(change, expected):
    pipe, params = Pipeline(ROOM), FAST.replace(n_segments="auto")
    assert recomputed(pipe, params) == {"adjacency"} | ITEMS
    assert recomputed(pipe, params.replace(**change)) == expected
    assert recomputed(pipe, params) == set()


def test_of_distances_only_the_last_are_remembered():
    pipe, params = Pipeline(ROOM), FAST
    other = params.replace(cost_exponent=1.5)
    pipe.run(params)
    assert pipe.knows("distances", params)
    pipe.run(other)
    assert pipe.knows("distances", other)
    assert not pipe.knows("distances", params)
    assert pipe.knows("ensemble", params)


def test_another_s_takes_the_same_trees_for_peac():
    pipe, params = Pipeline(ROOM), FAST.replace(consensus="peac", k_range=(20, 25))
    pipe.run(params)
    assert recomputed(pipe, params.replace(n_segments=5)) == {"consensus"} | FINISH


def test_another_s_is_cut_from_the_same_family():
    pipe, params = Pipeline(ROOM), FAST.replace(k_range=(20, 25))
    pipe.run(params.replace(n_segments=6))
    assert recomputed(pipe, params.replace(n_segments=7)) == {"family", "granularity"}


def test_k_follows_the_number_of_segments_where_no_range_is_given():
    pipe = Pipeline(ROOM)
    free = FAST.replace(k_range=None)
    pipe.run(free)
    assert recomputed(pipe, free.replace(n_segments=8)) == ENSEMBLE | CUT


def test_timings_are_of_this_call():
    pipe = Pipeline(ROOM)
    assert min(pipe.run(FAST).timings.values()) > 0
    again = pipe.run(FAST)
    assert set(again.timings.values()) == {0.0}


@pytest.mark.parametrize("params", [FAST, FAITHFUL])
def test_the_memo_stays_within_its_bytes_and_counts_the_large_matrices(params):
    pipe = Pipeline(ROOM)
    pipe.run(params)
    n = pipe.get("items", params).n
    assert pipe._memo.n_bytes > 4 * n * n + pipe.get("coassociation", params).C.nbytes
    small = Pipeline(ROOM, memory=1e6)
    for seed in range(5):
        small.run(params.replace(seed=seed))
        largest = max(small._memo._sizes.values())
        assert small._memo.n_bytes <= max(1e6, largest)
    same(small.run(params), pipe.run(params))
    pipe.clear()
    assert len(pipe._memo) == 0


def test_maps_of_walls_are_remembered_counted_and_forgotten_with_the_rest():
    pipe, steps = Pipeline(shapes.room(16, noise=0.003)[0]), stages(Params())
    pipe.run(Params())
    n_maps = len(pipe._memo) - len(steps)
    assert n_maps > 0
    pipe.run(Params(min_area=0.1))
    assert len(pipe._memo) == len(steps) + 2 + n_maps  # two new steps, but the walls are the same
    pipe.clear()
    assert (len(pipe._memo), pipe._memo.n_bytes) == (0, 0)


def test_results_are_freed_with_their_pipeline():
    pipe = Pipeline(ROOM)
    pipe.run(FAST)
    before = sum(type(o) is Segmentation for o in gc.get_objects())
    del pipe
    gc.collect()
    assert sum(type(o) is Segmentation for o in gc.get_objects()) < before


# --- progress and cancel --------------------------------------------------------------------------

VARIANTS = {
    "default": FAST,
    "thesis": FAITHFUL,
    "spectral": FAITHFUL.replace(feature="gps", n_eigenpairs=10),
    "median": FAST.replace(consensus="median"),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_progress_names_every_stage_once_in_order_and_never_falls(name):
    heard = []
    Pipeline(ROOM).run(VARIANTS[name], progress=lambda *step: heard.append(step))
    order = list(dict.fromkeys(stage for stage, _ in heard))
    assert set(order) == set(stages(VARIANTS[name]))
    assert [stage for stage, _ in heard] == sorted((s for s, _ in heard), key=order.index)
    for stage in order:
        fractions = [fraction for s, fraction in heard if s == stage]
        assert (fractions[0], fractions[-1]) == (0.0, 1.0)
        assert fractions == sorted(fractions)


HAS_STAGE = {stage: name for name, params in VARIANTS.items() for stage in stages(params)}


@pytest.mark.parametrize(("stage", "name"), HAS_STAGE.items())
def test_cancel_in_any_stage_stops_at_once_and_leaves_the_memo_right(stage, name):
    cancel, later = threading.Event(), []

    def progress(now, fraction):
        if cancel.is_set():
            later.append((now, fraction))
        if now == stage:
            cancel.set()

    pipe = Pipeline(ROOM)
    with pytest.raises(Cancelled, match=stage):
        pipe.run(VARIANTS[name], progress=progress, cancel=cancel)
    assert later == []
    same(pipe.run(VARIANTS[name]), EXPECTED[name]())


class Once:
    """A result computed when it is first asked for."""

    def __init__(self, params):
        self.params, self.result = params, None

    def __call__(self):
        if self.result is None:
            self.result = segment(ROOM, self.params)
        return self.result


EXPECTED = {name: Once(params) for name, params in VARIANTS.items()}


def test_two_threads_may_use_one_pipeline():
    pipe, results = Pipeline(ROOM), {}

    def work(i):
        results[i] = pipe.run(FAST.replace(seed=i % 2))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i in range(4):
        same(results[i], segment(ROOM, FAST.replace(seed=i % 2)))


@pytest.mark.parametrize("params", [FAST, FAITHFUL])
def test_same_seed_same_labels_for_any_number_of_threads(params, monkeypatch):
    expected = segment(ROOM, params)
    for n_threads in (1, 2, 4):
        monkeypatch.setenv("SCENEWIDGET_THREADS", str(n_threads))
        same(segment(ROOM, params), expected)
    other = segment(ROOM, params.replace(seed=1))
    assert not np.array_equal(other.level("base"), expected.level("base"))


# --- asking for one stage -------------------------------------------------------------------------


def test_any_stage_can_be_asked_for():
    pipe = Pipeline(ROOM)
    for stage in stages(FAST):
        assert pipe.get(stage, FAST) is pipe.get(stage, FAST)
    assert pipe.get("eigenbasis", FAST.replace(n_eigenpairs=5)).vectors.shape[0] == ROOM.n_vertices
    assert repr(pipe) == f"Pipeline({ROOM!r})"


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: Pipeline(ROOM).get("nothing"), ValueError, "stage must be one of 'adjacency', 'items'"),
        (lambda: Pipeline(ROOM).run({"n_segments": 3}), TypeError, "params must be a Params, got dict"),
        (lambda: segment(None), TypeError, "mesh must be a path"),
        (lambda: segment("missing.ply"), FileNotFoundError, "does not exist"),
        (lambda: segment(([[0, 0, 0]], [[0, 0, 1]])), MeshError, "does not exist"),
        (lambda: segment(ROOM, progress=3), TypeError, "progress must be callable"),
        (lambda: segment(ROOM, n_segments=3), TypeError, r"write segment\(mesh, Params\(n_segments=3\)\)"),
        (lambda: segment(ROOM, cancel=3), TypeError, "cancel must be a threading.Event"),
    ],
)
def test_bad_arguments_are_refused_before_any_work(call, error, message, monkeypatch):
    monkeypatch.setattr(stage_table, "_adjacency", lambda *_, **__: pytest.fail("work began"))
    with pytest.raises(error, match=message):
        call()


# --- scenes with known answers --------------------------------------------------------------------


@pytest.mark.parametrize(
    "params",
    [
        Params(n_segments=12),
        Params(n_segments=12, items="simplified", n_items=10_000, allocation="dihedral"),
        Params.thesis(n_segments=12),
        Params.thesis(n_segments=12, feature_floor=0.05),
    ],
)
def test_floor_walls_ceiling_and_table_of_a_room_come_out_right(params):
    mesh, parts = shapes.room(16, noise=0.003)
    seg = segment(mesh, params)
    assert adjusted_rand_score(parts, seg.labels) > 0.99
    assert seg.labels.min() == 0
    frame = seg.to_frame()
    floor = frame.loc[seg.labels[parts == 4][0]]
    assert floor.area == pytest.approx(12, rel=0.05)
    assert floor.normal[2] == pytest.approx(1, abs=0.02)
    assert (np.diff(frame.area) <= 1e-9).all()


@pytest.mark.parametrize(
    "params", [Params(), Params(seed=1), Params(consensus="median"), Params(consensus="peac", n_segments=12)]
)
def test_each_wall_is_a_segment_and_no_segment_of_a_room_has_more(params):
    """The sides of the box in it may be one segment or several."""
    mesh, parts = shapes.room(16, noise=0.003)
    labels = segment(mesh, params).labels
    hull = parts < 6
    assert adjusted_rand_score(parts[hull], labels[hull]) > 0.99
    assert not set(labels[hull].tolist()) & set(labels[~hull].tolist())


@pytest.mark.parametrize("params", [Params(), Params.thesis(feature_floor=0.05)])
def test_the_sides_of_a_box_are_its_segments(params):
    for mesh in (shapes.box(1), shapes.box(10), shapes.soup(shapes.box(10))):
        seg = segment(mesh, params.replace(n_segments=6))
        assert adjusted_rand_score(shapes._side(mesh), seg.labels) > 0.99


@pytest.mark.parametrize("params", [Params(), Params.thesis()])
def test_the_smallest_meshes(params):
    one = segment(shapes.triangle(), params)
    assert one.labels.tolist() == [0]
    assert one.to_frame().area.tolist() == [6]
    apart = segment(shapes.joined(shapes.triangle(), shapes.triangle(), gap=10.0), params)
    assert apart.labels[0] != apart.labels[1] or params.join_planes  # one floor in two pieces
    assert segment(shapes.tetrahedron(), params).n_segments == 4
    assert segment(shapes.grid_square(20, size=4.0), params).n_segments == 1


@pytest.mark.parametrize("params", [FAST.replace(n_segments="auto"), FAITHFUL])
@pytest.mark.parametrize("seed", [1, 2])
def test_moving_a_room_changes_no_segment(params, seed):
    walls = slice(0, 6 * 2 * 8**2)  # what is round is cut where a few runs happen to cut it
    moved = segment(shapes.moved(ROOM, seed=seed), params)
    assert adjusted_rand_score(segment(ROOM, params).labels[walls], moved.labels[walls]) > 0.97


@pytest.mark.parametrize("exponent", [-9, -1])
def test_what_is_smaller_than_a_room_is_segmented_alike_at_any_size(exponent):
    room, _ = shapes.room(8, noise=0.003)
    small, params = Mesh(room.vertices / 4, room.faces), FAST.replace(n_segments="auto")
    scaled = Mesh(2.0**exponent * small.vertices, small.faces)
    assert adjusted_rand_score(segment(small, params).labels, segment(scaled, params).labels) == 1.0


def test_the_order_of_faces_of_a_clean_room_does_not_matter():
    mesh, parts = shapes.room(12)
    order = np.random.default_rng(0).permutation(mesh.n_faces)
    seg = segment(shapes.with_faces_in_order(mesh, order), FAST)
    assert adjusted_rand_score(parts[order], seg.labels) == 1.0


BOTH = [FAST, FAITHFUL.replace(n_items=2000)]


@pytest.mark.parametrize("params", BOTH)
def test_place_and_order_of_faces_change_no_segment_of_a_noisy_room(params):
    mesh, parts = shapes.room(8, noise=0.003)
    assert adjusted_rand_score(parts, segment(mesh, params).labels) == 1.0
    shifted = Mesh(mesh.vertices + np.array([100.0, -50.0, 30.0]), mesh.faces)
    turned = Mesh(mesh.vertices @ shapes.rotation(3).T, mesh.faces)
    for other in (shifted, turned):
        assert adjusted_rand_score(parts, segment(other, params).labels) == 1.0
    order = np.random.default_rng(0).permutation(mesh.n_faces)
    shuffled = segment(shapes.with_faces_in_order(mesh, order), params)
    assert adjusted_rand_score(parts[order], shuffled.labels) == 1.0


@pytest.mark.parametrize("seed", range(2))
def test_a_turned_scan_has_the_same_segments_face_by_face(seed):
    """Not only the right ones: whatever the default makes of noise, it makes of it however a scan lies."""
    mesh, _ = shapes.room(10, noise=0.008)
    params = FAST.replace(n_segments=9)  # more than there is to tell apart
    turned = Mesh(mesh.vertices @ shapes.rotation(seed).T, mesh.faces)
    assert (segment(turned, params).labels == segment(mesh, params).labels).all()


@pytest.mark.parametrize("n_items", [500, 3000])
@pytest.mark.parametrize("factor", [0.125, 8.0])
def test_the_preset_of_the_thesis_knows_no_unit_of_length(factor, n_items):
    """Up to names, whether faces are made few or are few, by powers of two, which round nothing."""
    params = FAITHFUL.replace(n_items=n_items)
    scaled = segment(Mesh(factor * ROOM.vertices, ROOM.faces), params)
    assert adjusted_rand_score(segment(ROOM, params).labels, scaled.labels) == 1.0


@pytest.mark.parametrize("params", BOTH)
def test_a_scene_in_one_plane_has_a_segment_a_piece(params):
    params = params.replace(n_segments="auto") if params.consensus == "linkage" else params
    sheet = shapes.grid_square(12, size=1.5)
    assert segment(sheet, params).n_segments == 1
    apart = segment(shapes.joined(sheet, sheet, gap=4.0), params)
    assert apart.n_segments == 2  # without walls nothing tells that it is one floor


@pytest.mark.parametrize("params", BOTH)
def test_triangles_that_touch_nothing_are_segments(params):
    params = params.replace(n_segments="auto") if params.consensus == "linkage" else params
    corners = shapes.triangle().vertices + np.random.default_rng(0).uniform(0, 100, (50, 1, 3))
    mesh = Mesh(corners.reshape(-1, 3), np.arange(150).reshape(-1, 3))
    seg = segment(mesh, params.replace(join_planes=False))
    assert np.bincount(seg.labels[seg.labels >= 0]).tolist() == [1] * seg.n_segments
    assert (seg.labels < 0).sum() == seg.report.get("faces in dropped components", 0) <= 1  # above 98 %


@pytest.mark.parametrize("params", BOTH)
def test_fourteen_thousand_fragments_come_through_and_what_is_dropped_is_said(params):
    with pytest.warns(UserWarning, match="of the faces are labeled: the mesh is in many pieces"):
        seg = segment(shapes.fragments(14_000), params)
    assert 1 <= seg.n_segments <= params.n_items
    dropped = ("faces in dropped components", "faces floating free of everything")
    assert (seg.labels < 0).sum() == sum(seg.report.get(key, 0) for key in dropped)


@pytest.mark.parametrize("params", BOTH)
@pytest.mark.parametrize("part", [0, 5, 7])
def test_a_side_wound_the_other_way_is_the_same_segment(params, part):
    mesh, parts = shapes.room(8, noise=0.003)
    faces = np.where((parts == part)[:, None], mesh.faces[:, ::-1], mesh.faces)
    assert adjusted_rand_score(parts, segment(Mesh(mesh.vertices, faces), params).labels) == 1.0


def test_faces_wound_at_random_are_noticed_and_the_advice_helps():
    mesh, parts = shapes.room(8, noise=0.003)
    flips = np.random.default_rng(0).random((mesh.n_faces, 1)) < 0.1
    mixed = Mesh(mesh.vertices, np.where(flips, mesh.faces[:, ::-1], mesh.faces))
    for bad in (mixed, shapes.soup(mixed)):
        with pytest.warns(UserWarning, match=r"at 1\d% of the edges.*trimesh\.repair\.fix_winding"):
            segment(bad, FAST)
    mended = trimesh.Trimesh(mixed.vertices, mixed.faces, process=False)
    trimesh.repair.fix_winding(mended)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert adjusted_rand_score(parts, segment(mended, FAST).labels) == 1.0


def test_a_scan_in_dust_says_how_little_it_could_label():
    with pytest.warns(UserWarning, match=r"only 0\.3% of the faces are labeled.*items='superfacets'"):
        segment(shapes.fragments(300), Params.thesis())
    with pytest.warns(UserWarning, match=r"300 loose pieces.* has 0% of its area.*raise bridge="):
        assert segment(shapes.fragments(300)).report["loose pieces"] == 300


@given(nasty_meshes(), st.sampled_from(["default", "thesis", "spectral", "median", "hks", "wks"]))
@settings(max_examples=30)
def test_any_mesh_gives_a_sound_segmentation_or_a_mesh_error(mesh, name):
    variants = VARIANTS | {f: FAITHFUL.replace(feature=f, n_eigenpairs=10) for f in ("hks", "wks")}
    params = variants[name].replace(n_segments=4, k_range=(5, 8), n_runs=2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            seg = segment(mesh, params)
        except MeshError:
            assert not mesh.face_areas.any()
            return
    assert seg.labels.shape == (mesh.n_faces,)
    assert seg.labels.dtype == np.int32
    assert set(seg.labels[seg.labels >= 0].tolist()) == set(range(seg.n_segments))
    assert ((seg.labels < 0) == (seg.face_map < 0)).all()
    dropped = sum(v for k, v in seg.report.items() if k.startswith("faces "))
    assert (seg.labels < 0).sum() <= dropped + (0 if params.items == "superfacets" else mesh.n_faces)
    assert np.isfinite(seg.confidence).all()
    assert (seg.confidence[seg.labels < 0] == 0).all()
    area = seg.to_frame().area.to_numpy()
    assert (np.diff(area) <= 1e-9 * area[0]).all()
    for level in ("dihedral", "base"):
        assert (seg.level(level)[seg.labels >= 0] >= 0).all()
