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
