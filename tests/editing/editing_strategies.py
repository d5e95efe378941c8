"""Hypothesis strategies of segmentations with levels, and of edits on them."""

from __future__ import annotations

import numpy as np
import shapes
from hypothesis import strategies as st
from strategies import clean_meshes, messy_meshes

from scenewidget.editing.edits import (
    Cut,
    EditError,
    FillHoles,
    Group,
    Grow,
    Merge,
    Paint,
    Relabel,
    Shrink,
    Slice,
    SmoothBorder,
    Split,
)
from scenewidget.editing.session import Session
from scenewidget.engine.segmentation import LEVELS, Segmentation, dense_groups, order_by_area

NAMES = ("", "chair", "Tür", "a" * 200, "<b>&\"'", "=1+1")


@st.composite
def segmentations(draw, meshes=None):
    """A mesh cut into a few segments, some faces unlabeled, with levels that cross them."""
    mesh = draw(meshes or st.one_of(clean_meshes(), messy_meshes(), st.just(shapes.box(2))))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n_parts = draw(st.integers(1, 6))
    labels = rng.integers(-1 if draw(st.booleans()) else 0, n_parts, mesh.n_faces)
    if labels.max() < 0:
        labels[0] = 0
    dense, _ = order_by_area(labels, mesh.face_areas)
    levels = {
        "dihedral": rng.integers(0, 12, mesh.n_faces).astype(np.int32),
        "base": rng.integers(-1, 8, mesh.n_faces).astype(np.int32),
    }
    names = [draw(st.sampled_from(NAMES)).strip() for _ in range(int(dense.max()) + 1)]
    wholes = np.arange(len(names))
    if draw(st.booleans()):
        wholes = rng.integers(0, len(names), len(names))
    groups = dense_groups(np.arange(len(names)), wholes)
    confidence = rng.random(mesh.n_faces, np.float32)
    return Segmentation(mesh, dense, confidence, levels=levels, names=names, groups=groups)


def edits(n_faces):
    """Any edit that names faces of the mesh; it need not apply."""
    face = st.integers(0, n_faces - 1)
    level = st.sampled_from(LEVELS)
    few = st.integers(1, 3)
    vector = st.tuples(*[st.sampled_from([-1.0, -0.3, 0.0, 0.1, 0.5, 2.0])] * 3)
    two = st.tuples(face, face).filter(lambda pair: pair[0] != pair[1])
    kinds = [
        st.builds(Merge, st.lists(face, min_size=1, max_size=3).map(tuple), face, level),
        st.builds(Split, face, level),
        st.builds(Relabel, face, st.sampled_from(NAMES)),
        st.builds(Group, st.lists(face, min_size=1, max_size=3).map(tuple), st.none() | face),
        st.builds(Paint, st.lists(face, min_size=1, max_size=20), st.none() | face),
        st.builds(Slice, face, vector, vector.filter(any)),
        st.builds(Grow, face, few),
        st.builds(Shrink, face, few),
        st.builds(FillHoles, face, st.integers(1, 20)),
        st.builds(SmoothBorder, face, few),
    ]
    if n_faces > 1:
        kinds.append(two.map(lambda pair: Cut(*pair)))
    return st.one_of(kinds)


@st.composite
def edited(draw, max_size=8, **options):
    """A segmentation and a list of edits on it."""
    segmentation = draw(segmentations(**options))
    return segmentation, draw(st.lists(edits(segmentation.mesh.n_faces), max_size=max_size))


def assert_same(one, other):
    """Two segmentations are the same to the last bit."""
    np.testing.assert_array_equal(one.labels, other.labels)
    np.testing.assert_array_equal(one.confidence, other.confidence)
    assert (tuple(one.names), one.groups) == (tuple(other.names), other.groups)
    assert one.levels.keys() == other.levels.keys()
    for level in one.levels:
        np.testing.assert_array_equal(one.level(level), other.level(level))


def do_all(session, edits):
    """Do the edits that apply; the number of them."""
    for edit in edits:
        try:
            session.do(edit)
        except EditError:
            continue
    return len(session.edits)


def box_session(**options):
    """A box with a segment a side, four base parts a side and a dihedral part a face."""
    mesh = shapes.box(4)
    labels = np.arange(mesh.n_faces) // 32
    levels = {"base": np.arange(mesh.n_faces) // 8, "dihedral": np.arange(mesh.n_faces)}
    levels = {name: part.astype(np.int32) for name, part in levels.items()}
    return Session(mesh, Segmentation(mesh, labels, levels=levels, **options))


def applies(session, edit):
    """Whether an edit can be done; then it is done."""
    try:
        session.do(edit)
    except EditError:
        return False
    return True
