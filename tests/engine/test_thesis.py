"""`Params.thesis()` against the formulas and algorithms of the thesis, stage by stage, on small scenes.

What single modules have to show stands in their own tests; `.github/FIDELITY.md` says which.
"""

import numpy as np
import pytest
import shapes
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from transcriptions import algorithm_2, cotangent_delta, merge

from scenewidget.engine import consensus
from scenewidget.engine.allocation import allocate
from scenewidget.engine.consensus import median_partition
from scenewidget.engine.dihedral import dihedral_partition
from scenewidget.engine.mesh import Mesh, connected_components, face_adjacency
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline, segment

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")  # scenes so small make the method say so

PARAMS = Params.thesis(n_segments=8, k_range=(14, 20), n_runs=4)
ROOM = Pipeline(shapes.room(6, noise=0.01)[0])
TWO = Pipeline(
    shapes.joined(shapes.room(5, noise=0.01)[0], shapes.room(4, noise=0.01, seed=1)[0], gap=1.0),
)


def sheets(gap, n=50, noise=0.004, holes=0.0):
    """Two squares of 3 m above each other, a share of their faces missing; and the sheet of each face."""
    sheet = shapes.grid_square(n, size=3.0)
    rng = np.random.default_rng(0)
    low, high = (sheet.vertices + rng.normal(scale=noise, size=sheet.vertices.shape) for _ in range(2))
    vertices = np.concatenate([low, high + np.array([0, 0, gap])])
    faces = np.concatenate([sheet.faces, sheet.faces + sheet.n_vertices])
    stays = rng.random(len(faces)) >= holes
    return Mesh(vertices, faces[stays]), np.repeat([0, 1], sheet.n_faces)[stays]


# --- components stay apart (3.1, 5) ---------------------------------------------------------------

APART = {
    "thesis": Params.thesis(n_items=1_200),
    "thesis, to the letter": Params.thesis(n_items=1_200, drop_torn=True),
    "thesis, automatic number": Params.thesis("auto", n_items=1_200),
    "thesis, linkage": Params.thesis(n_items=1_200, consensus="linkage"),
    "thesis, median": Params.thesis(n_items=1_200, consensus="median"),
    "thesis, normals alone": Params.thesis(n_items=1_200, feature="normals"),
    "superfacets without bridges": Params(bridge=0, join_planes=False, n_items=1_200),
}


@pytest.mark.parametrize("gap", [0.005, 0.01, 0.02])
@pytest.mark.parametrize("preset", APART)
def test_no_segment_holds_faces_of_two_components(preset, gap):
    mesh, sheet = sheets(gap)
    result = segment(mesh, APART[preset].replace(n_runs=8))
    assert (result.labels >= 0).mean() > 0.8
    for level in ("final", "base", "dihedral"):
        parts = result.labels if level == "final" else result.level(level)
        inside = parts >= 0
        both = np.intersect1d(parts[inside & (sheet == 0)], parts[inside & (sheet == 1)])
        assert len(both) == 0, level


@pytest.mark.parametrize("allocation", ["dihedral", "faces", "same", "raw"])
def test_every_stage_sees_as_many_components_as_were_kept(allocation):
    mesh, sheet = sheets(0.005, noise=0.02, holes=0.15)
    pipe, params = Pipeline(mesh), Params.thesis(n_items=1_200, n_runs=4, allocation=allocation)
    items = pipe.get("items", params)
    home = np.full(items.n, -1)
    home[items.face_map[items.face_map >= 0]] = sheet[items.face_map >= 0]
    pieces, _ = connected_components(items.mesh.n_faces, face_adjacency(items.mesh))
    assert pieces > 2  # torn by the simplifier
    assert items.report["components kept"] == items.component.max() + 1 == 2
    assert len(pipe.get("allocation", params)) == 2
    keys = pipe.get("ensemble", params)
    assert keys.min() >= 0  # every item reaches a medoid: the pieces of a component belong together
    agreed = pipe.get("consensus", params)[pipe.get("coassociation", params).base]
    for labels in (*keys.T, agreed):
        is_known = home >= 0
        for a in np.unique(labels):
            assert len(np.unique(home[is_known & (labels == a)])) <= 1


# --- allocation (3.1) -----------------------------------------------------------------------------


def test_k_and_s_follow_the_number_of_dihedral_partitions():
    pipe = Pipeline(shapes.joined(shapes.box(3), shapes.blob(2), shapes.grid_square(6), gap=2.0))
    items = pipe.get("items", PARAMS)
    partition = dihedral_partition(items.mesh, 64)
    counts = np.array([len(np.unique(partition[items.component == c])) for c in range(3)])
    assert len(set(counts.tolist())) == 3
    np.testing.assert_allclose(pipe.get("allocation", PARAMS), counts / counts.sum())


def test_the_raw_scan_can_say_how_k_and_s_are_shared_out():
    low, high = (shapes.room(20, noise=noise, seed=1)[0] for noise in (0.0005, 0.004))
    pipe = Pipeline(shapes.joined(low, high, gap=1.0))
    params = PARAMS.replace(n_items=500)
    items, raw = pipe.get("items", params), dihedral_partition(pipe.mesh, 64)
    inside = items.face_map >= 0
    home = items.component[items.face_map[inside]]
    counts = np.array([len(np.unique(raw[inside][home == c])) for c in range(home.max() + 1)])
    share = pipe.get("allocation", params.replace(allocation="raw"))
    np.testing.assert_allclose(share, counts / counts.sum())
    assert not np.allclose(share, pipe.get("allocation", params))


# --- from features to distances (3.2–3.4) ---------------------------------------------------------


@pytest.mark.parametrize("cost", [(1.0, 0.0, 1.0), (1.0, -1.0, 1.5)])  # f1, f2
@pytest.mark.parametrize("feature", ["uniform", "cotangent"])
def test_distances_are_shortest_paths_over_equations_3_8_and_3_9(feature, cost):
    a, b, c = cost
    params = PARAMS.replace(feature=feature, cost_a=a, cost_b=b, cost_exponent=c)
    items = ROOM.get("items", params)
    mesh = items.mesh
    if feature == "cotangent":
        delta = cotangent_delta(mesh.vertices, mesh.faces)
    else:
        L = np.zeros((mesh.n_vertices,) * 2)
        for face in mesh.faces:
            for i in range(3):
                L[face[i], face[i - 1]] = L[face[i - 1], face[i]] = -1
        delta = (L - np.diag(L.sum(axis=1))) @ mesh.vertices
    f = delta[mesh.faces].mean(axis=1)
    x, y = face_adjacency(mesh).T
    normals = mesh.face_normals
    dots = np.clip((normals[x] * normals[y]).sum(axis=1), -1, 1)
    w = np.linalg.norm(f[x] - f[y], axis=1) * (a + b * dots) ** c
    edges = np.tile(np.maximum(w, 1e-300), 2), (np.concatenate([x, y]), np.concatenate([y, x]))
    expected = dijkstra(csr_array(edges, shape=(mesh.n_faces,) * 2))  # which takes 0 for no edge
    (D,) = ROOM.get("distances", params)
    np.testing.assert_allclose(D, expected, rtol=1e-4, atol=1e-5 * np.median(expected[expected > 0]))


# --- the ensemble (3.4) ---------------------------------------------------------------------------


@pytest.mark.parametrize("pipe", [ROOM, TWO])
def test_each_run_is_algorithm_2_then_the_merging_of_figure_3_5(pipe):
    items, (D,) = pipe.get("items", PARAMS), pipe.get("distances", PARAMS)
    share, keys = pipe.get("allocation", PARAMS), pipe.get("ensemble", PARAMS)
    assert keys.shape == (items.n, PARAMS.n_runs)
    seams, ks = face_adjacency(items.mesh), []
    for i in range(PARAMS.n_runs):
        rng = np.random.default_rng(np.random.SeedSequence(PARAMS.seed, spawn_key=(i,)))
        ks.append(int(rng.integers(*PARAMS.k_range, endpoint=True)))  # "a random value in this interval"
        size = np.bincount(items.component)
        medoids = [
            rng.choice(np.flatnonzero(items.component == c), size=count, replace=False)
            for c, count in enumerate(allocate(ks[-1], share, size))
        ]
        labels, _, _ = algorithm_2(D, np.concatenate(medoids))
        assert_same_partition(keys[:, i], merge(items.mesh, seams, labels))
    assert len(set(ks)) > 1


def assert_same_partition(one, other):
    pairs = np.unique(np.stack([one, other]), axis=1)
    assert len(pairs.T) == len(np.unique(one)) == len(np.unique(other))


# --- consensus (3.5) ------------------------------------------------------------------------------


def test_base_segments_have_equal_keys_and_c_and_w_are_those_of_equation_3_14():
    items, keys, co = (ROOM.get(name, PARAMS) for name in ("items", "ensemble", "coassociation"))
    assert_same_partition(co.base, np.unique(keys, axis=0, return_inverse=True)[1])
    rows = keys[np.unique(co.base, return_index=True)[1]]
    np.testing.assert_allclose(co.C, (rows[:, None] == rows).mean(axis=2))
    area = [items.mesh.face_areas[co.base == b].sum() for b in range(len(rows))]
    np.testing.assert_allclose(co.weights / co.weights.sum(), np.array(area) / sum(area))


@pytest.mark.parametrize("pipe", [ROOM, TWO])
def test_segments_are_the_connected_pieces_of_what_has_a_probability_of_half(pipe):
    params = PARAMS.replace(n_segments=5)
    items, co = pipe.get("items", params), pipe.get("coassociation", params)
    agreed, result = pipe.get("consensus", params)[co.base], pipe.run(params)
    pairs = items.pairs[agreed[items.pairs[:, 0]] == agreed[items.pairs[:, 1]]]
    assert_same_partition(result.item_labels, connected_components(items.n, pairs)[1])


def test_an_automatic_number_is_that_of_the_partition_that_agrees_most_with_the_runs(monkeypatch):
    params = PARAMS.replace(n_segments="auto")
    co, items = TWO.get("coassociation", params), TWO.get("items", params)
    numbers = []
    for c in range(4):
        inside = np.unique(co.base[items.component == c])
        C, w = co.C[np.ix_(inside, inside)], co.weights[inside]
        labels = median_partition(C, w)
        numbers.append(labels.max() + 1)
        apart = np.subtract.outer(labels, labels) != 0
        score = np.outer(w, w) * np.where(apart, C**2, (1 - C) ** 2)
        for i in range(len(inside)):  # no base segment agrees more with another cluster, or alone
            others = np.arange(len(inside)) != i
            for target in range(labels.max() + 2):
                moved = labels.copy()
                moved[i] = target
                apart = np.subtract.outer(moved, moved) != 0
                new = np.outer(w, w) * np.where(apart, C**2, (1 - C) ** 2)
                assert new[i][others].sum() >= score[i][others].sum() - 1e-9
    asked, solve = [], consensus.peac
    monkeypatch.setattr(consensus, "peac", lambda C, w, n, **more: asked.append(n) or solve(C, w, n, **more))
    fresh = Pipeline(TWO.mesh).get("consensus", params)
    assert asked == [n for n in numbers if n > 1]
    assert len(np.unique(fresh)) >= sum(numbers) / 2


# --- mapping back (3.1, 4.3) ----------------------------------------------------------------------


def test_every_raw_face_has_the_label_of_the_nearest_simplified_face_or_none():
    mesh, _ = shapes.room(20, noise=0.004)
    params = Params.thesis(n_segments=8, n_items=700, n_runs=4)
    result = segment(mesh, params)
    assert result.items.n <= 700
    inside = result.face_map >= 0
    np.testing.assert_array_equal(result.labels[inside], result.item_labels[result.face_map[inside]])
    assert (result.labels[~inside] == -1).all()
    limit = result.report["tolerance in metres"]
    assert limit == pytest.approx(2 * np.sqrt(result.simplified.face_areas.mean()))
    everything = segment(mesh, params.replace(tolerance=1e9))
    assert (everything.labels >= 0).all()
