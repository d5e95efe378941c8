"""Hypothesis strategies of small meshes."""

from __future__ import annotations

import numpy as np
import shapes
from hypothesis import strategies as st

from scenewidget.engine.mesh import Mesh


@st.composite
def messy_meshes(draw: st.DrawFn, max_vertices: int = 12, max_faces: int = 20) -> Mesh:
    """Any triangles: non-manifold, degenerate, doubled, disconnected, with unused and coinciding vertices.

    Half of them lie on a coarse lattice, where collinear corners, right angles and coinciding vertices are
    common. At least one face has an area.
    """
    n = draw(st.integers(3, max_vertices))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    vertices = rng.integers(0, 3, (n, 3)).astype(float) if draw(st.booleans()) else rng.normal(size=(n, 3))
    index = st.integers(0, n - 1)
    faces = draw(st.lists(st.tuples(index, index, index), min_size=1, max_size=max_faces))
    vertices[list({0, 1, 2})] = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    return Mesh(vertices, [*faces, (0, 1, 2)])


@st.composite
def clean_meshes(draw: st.DrawFn) -> Mesh:
    """Bumpy surfaces, closed or with boundary, in one or two pieces: manifold, no degenerate face."""
    seed = draw(st.integers(0, 2**32 - 1))
    closed = shapes.blob(1, seed=seed)
    square = shapes.grid_square(draw(st.integers(1, 6)))
    heights = 0.1 * np.random.default_rng(seed).uniform(size=square.n_vertices)
    open_ = Mesh(square.vertices + heights[:, None] * [0.3, 0.2, 1.0], square.faces)
    return draw(st.sampled_from([closed, open_, shapes.joined(closed, open_, gap=4.0)]))


@st.composite
def graphs(draw: st.DrawFn, max_nodes: int = 14) -> tuple[int, np.ndarray, np.ndarray]:
    """(n, pairs, weights): any undirected graph with loops, double and zero edges, in any number of parts."""
    n = draw(st.integers(1, max_nodes))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    pairs = rng.integers(0, n, (draw(st.integers(0, 3 * n)), 2)).astype(np.int32)
    whole = draw(st.booleans())  # small whole numbers: ties and zeros are common
    weights = rng.integers(0, 4, len(pairs)).astype(float) if whole else rng.exponential(size=len(pairs))
    return n, pairs, weights


@st.composite
def ensembles(
    draw: st.DrawFn, max_items: int = 10, max_runs: int = 5, *, partial: bool = False
) -> np.ndarray:
    """(n_items, n_runs) int keys; with ``partial`` some are -1, unseen."""
    shape = draw(st.integers(1, max_items)), draw(st.integers(1, max_runs))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return rng.integers(-1 if partial else 0, draw(st.integers(1, 5)), shape)


@st.composite
def distance_matrices(draw: st.DrawFn, max_items: int = 12) -> np.ndarray:
    """(n, n) distances of points, on a lattice half of the time (ties), in one or two unconnected parts."""
    n = draw(st.integers(1, max_items))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    points = rng.integers(0, 4, (n, 2)).astype(float) if draw(st.booleans()) else rng.normal(size=(n, 2))
    D = np.abs(points[:, None] - points).sum(axis=2)
    part = rng.integers(0, draw(st.integers(1, 2)), n)
    return np.where(part[:, None] == part, D, np.inf).astype(draw(st.sampled_from([np.float32, np.float64])))


@st.composite
def nasty_meshes(draw: st.DrawFn) -> Mesh:
    """What goes wrong in scans and exports: soups, fans, doubled and flipped faces, fragments, extremes."""
    base = draw(
        st.one_of(
            messy_meshes(),
            clean_meshes(),
            st.builds(shapes.box, st.integers(1, 4)),
            st.builds(shapes.fan, st.integers(1, 20)),
            st.builds(shapes.fragments, st.integers(1, 40), seed=st.integers(0, 99)),
        )
    )
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    for change in draw(st.lists(st.sampled_from(sorted(_CHANGES)), max_size=3)):
        base = _CHANGES[change](base, rng)
    return base


def _some_flipped(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    flips = rng.random((mesh.n_faces, 1)) < 0.5
    return Mesh(mesh.vertices, np.where(flips, mesh.faces[:, ::-1], mesh.faces))


def _some_dropped(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    stays = rng.random(mesh.n_faces) < 0.7
    stays[0] = True
    return Mesh(mesh.vertices, mesh.faces[stays])


def _with_degenerate(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    return Mesh(mesh.vertices, np.concatenate([mesh.faces, np.repeat(mesh.faces[:, :1], 3, axis=1)]))


_CHANGES = {
    "soup": lambda mesh, rng: shapes.soup(mesh),
    "double": lambda mesh, rng: Mesh(mesh.vertices, np.concatenate([mesh.faces, mesh.faces])),
    "flip": _some_flipped,
    "degenerate": _with_degenerate,
    "drop": _some_dropped,
    "unused": lambda mesh, rng: Mesh(np.concatenate([mesh.vertices, [[np.nan] * 3, [1e9] * 3]]), mesh.faces),
    "tiny": lambda mesh, rng: Mesh(1e-6 * mesh.vertices, mesh.faces),
    "huge": lambda mesh, rng: Mesh(1e5 * np.clip(mesh.vertices, -1e9, 1e9), mesh.faces),
    "far": lambda mesh, rng: Mesh(mesh.vertices + 1e5, mesh.faces),
    "noise": lambda mesh, rng: Mesh(mesh.vertices + 0.05 * rng.normal(size=mesh.vertices.shape), mesh.faces),
    "another": lambda mesh, rng: shapes.joined(mesh, shapes.icosphere(1), gap=5.0),
}
