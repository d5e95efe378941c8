"""Algorithms and formulas of the thesis, line by line and without a thought of speed: to test against."""

import functools
import itertools
import operator

import numpy as np


def total(distances):
    """Sum from left to right; Python's own rounds less since 3.12."""
    return functools.reduce(operator.add, map(float, distances), 0.0)


def nearest(D, medoids):
    """Labels by definition: the first of the nearest medoids, a medoid its own, -1 out of reach."""
    labels = D[:, medoids].argmin(axis=1)
    labels[np.isinf(D[:, medoids].min(axis=1))] = -1
    labels[medoids] = np.arange(len(medoids))
    return labels


def algorithm_2(D, medoids):
    """k-medoids from given medoids; the comments are the line numbers of Algorithm 2."""
    n_updates, previous = 0, np.inf  # 3
    while True:
        labels = nearest(D, medoids)  # 6
        cost = total(D[i, medoids[c]] for i, c in enumerate(labels) if c >= 0)  # 7
        if cost == previous:  # 8
            return labels, medoids, n_updates
        medoids = medoids.copy()
        for c in range(len(medoids)):  # 11
            members = np.flatnonzero(labels == c)
            medoids[c] = members[int(np.argmin([total(D[i, members]) for i in members]))]
        previous = cost  # 13
        n_updates += 1


def cotangent_delta(vertices, faces):
    """Eq. 3.3 of the cotangent Laplacian of 3.2, with Meyer et al.'s areas; vertices in metres."""
    L, areas = np.zeros((len(vertices), len(vertices))), np.zeros(len(vertices))
    for face in faces:
        p = vertices[face]
        double_area = np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0]))
        cots, squares = [], []
        for i in range(3):
            a, b = p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]
            cots.append(a @ b / double_area)
            squares.append((p[(i + 1) % 3] - p[(i + 2) % 3]) @ (p[(i + 1) % 3] - p[(i + 2) % 3]))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            L[face[j], face[k]] -= cots[i] / 2
            L[face[k], face[j]] -= cots[i] / 2
            L[face[j], face[j]] += cots[i] / 2
            L[face[k], face[k]] += cots[i] / 2
            if min(cots) >= 0:
                areas[face[i]] += (squares[j] * cots[j] + squares[k] * cots[k]) / 8
            else:
                areas[face[i]] += double_area / (4 if cots[i] < 0 else 8)
    return L @ vertices / areas[:, None]


def merge(mesh, seams, labels):
    """Section 3.4, figure 3.5: neighbouring flat segments become one, all that qualify at once, in rounds.

    ``seams`` are pairs of faces at an edge.
    """
    normals, labels = mesh.face_normals, labels.copy()
    while True:
        names = np.unique(labels)
        frames = {s: np.linalg.eigh(scatter(mesh, labels == s)) for s in names}
        is_flat = {s: values[0] / values[2] < 0.008 for s, (values, _) in frames.items()}
        joined = {s: s for s in names}
        for a, b in itertools.combinations(names, 2):
            dots = np.array([normals[f] @ normals[g] for f, g in seams if {labels[f], labels[g]} == {a, b}])
            if len(dots) == 0 or not (is_flat[a] and is_flat[b]):
                continue
            is_parallel = abs(frames[a][1][:, 0] @ frames[b][1][:, 0]) > 0.99
            if is_parallel and np.mean(dots > 0.99) >= 0.5 and dots.mean() > 0.99:
                old, new = joined[b], joined[a]
                joined = {s: new if group == old else group for s, group in joined.items()}
        if all(s == group for s, group in joined.items()):
            return labels
        labels = np.array([joined[label] for label in labels])


def scatter(mesh, is_member):
    """(3, 3) scatter matrix of the points of some faces about their centroid, integrated over the area."""
    corners, areas = mesh.vertices[mesh.faces[is_member]], mesh.face_areas[is_member]
    corners = corners - np.average(corners.mean(axis=1), axis=0, weights=areas)
    sums = corners.sum(axis=1)
    own = np.einsum("fki,fkj->fij", corners, corners) + sums[:, :, None] * sums[:, None, :]
    return np.einsum("f,fij->ij", areas / 12, own)
