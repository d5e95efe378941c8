"""What a brush takes: faces around one that are reached over the surface.

Goes in: a mesh, a face, and a radius. Comes out: the faces of the same thing within that radius. Things meet
where the surface turns inwards (Hoffman and Richards 1984, Parts of recognition, Cognition 18), so a mug is
left neither for the table that it stands on nor, from the table, for the mug, however near both are.
"""

from __future__ import annotations

import math

import numpy as np

from scenewidget.engine.mesh import BoolArray, IntArray, Mesh, connected_components, face_adjacency
from scenewidget.engine.preprocess import filter_normals
from scenewidget.engine.threads import n_threads

__all__ = ["reached_faces"]

SWEEPS = 20  # of the normals; fewer leave noise that looks like creases, or creases that leak
SPECK = 0.02  # of what is reached; smaller pieces that are left out amid it are noise


def reached_faces(
    mesh: Mesh,
    face: int,
    radius: float,
    *,
    crease: float = 6.0,
    color_step: float = 32.0,
    pairs: IntArray | None = None,
) -> IntArray:
    """Faces around a face that are reached without crossing a concave crease or an edge between colours.

    Parameters
    ----------
    mesh : Mesh
    face : int
        Where the brush is.
    radius : float
        Metres; centroids within this distance of that of ``face`` count.
    crease : float
        Degrees by which the smoothed surface turns inwards at an edge that isn't crossed; 180 crosses all.
        A scanner spreads a crease over several faces, each of which turns a little.
    color_step : float
        Largest difference in red, green or blue, of 255, between neighbours that is crossed; 255 crosses
        all. Colours at vertices spread an edge over two faces, which see a third of it each or more.
    pairs : (n_pairs, 2) int, optional
        `face_adjacency` of the mesh, if it is known already.

    Returns
    -------
    faces : (n,) int
        Ascending; ``face`` is one of them. Specks that noise leaves amid them are filled.

    Raises
    ------
    ValueError
        No such face, or a radius that is no positive number.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> reached_faces(analytic.square(4), 0, radius=0.2)
    array([0, 1, 9])
    """
    if not 0 <= face < mesh.n_faces:
        raise ValueError(f"there is no face {face}: the mesh has {mesh.n_faces} faces, numbered from 0")
    if not (radius > 0 and math.isfinite(radius)):
        raise ValueError(f"radius must be a positive number of metres, got {radius!r:.60}")
    away = mesh.face_centroids - mesh.face_centroids[face]
    near = np.einsum("ij,ij->i", away, away) <= radius**2
    faces: IntArray = np.flatnonzero(near)
    number = np.cumsum(near) - 1
    all_pairs = face_adjacency(mesh) if pairs is None else pairs
    inside = number[all_pairs[near[all_pairs].all(axis=1)]]
    sub = mesh.part(faces)
    is_open = ~_is_concave(sub, inside, crease)
    if mesh.vertex_colors is not None:
        color = mesh.vertex_colors[mesh.faces[faces]].mean(axis=1)
        is_open &= np.abs(color[inside[:, 0]] - color[inside[:, 1]]).max(axis=1) <= color_step
    _, piece = connected_components(len(faces), inside[is_open])
    reached = piece == piece[number[face]]
    left_out = ~reached[inside]
    _, piece = connected_components(len(faces), inside[left_out.all(axis=1)])
    size = np.bincount(piece)
    is_touched = np.zeros(len(size), dtype=bool)
    is_touched[piece[inside[left_out[:, 0] != left_out[:, 1]]]] = True
    is_speck = is_touched & (size <= SPECK * np.count_nonzero(reached))
    return np.asarray(faces[reached | is_speck[piece]])


def _is_concave(mesh: Mesh, pairs: IntArray, crease: float) -> BoolArray:
    """(n_pairs,) whether the surface turns inwards by more than so many degrees between two faces."""
    normals = filter_normals(mesh, pairs, sweeps=SWEEPS, n_threads=n_threads())
    i, j = pairs.T
    cosine = np.einsum("ij,ij->i", normals[i], normals[j])
    apart = mesh.face_centroids[j] - mesh.face_centroids[i]
    is_inwards = np.einsum("ij,ij->i", apart, normals[j] - normals[i]) < 0
    return np.asarray(is_inwards & (cosine < math.cos(math.radians(crease))))
