"""Area, first and second moments of surfaces, integrated over their triangles.

Goes in: a mesh. Come out: moments per face that simply add up over any set of faces, and from sums of
them the centroid, the principal directions and the flatness of a piece (thesis 3.4, after Karpathy et
al. 2013).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh

__all__ = ["Moments", "face_moments", "group_moments", "mean_normals", "moment_origin"]


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments of n pieces of surface.

    Parameters
    ----------
    area : (n,) float64
        Square metres.
    first : (n, 3) float64
        Integral of the position, m^3.
    second : (n, 3, 3) float64
        Integral of position times its transpose, m^4.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.moments import face_moments
    >>> moments = face_moments(square(1)).gather(np.zeros(2, int), 1)  # of the whole square
    >>> moments.area.tolist(), moments.scatter[0].diagonal().round(4).tolist()  # 1/12 along both sides
    ([1.0], [0.0833, 0.0833, 0.0])
    """

    area: FloatArray
    first: FloatArray
    second: FloatArray

    def gather(self, group: IntArray, n_groups: int) -> Moments:
        """Moments of groups of pieces; pieces in group -1 are left out.

        Parameters
        ----------
        group : (n,) int
            Group of each piece.
        n_groups : int
        """
        flat = np.concatenate([self.area[:, None], self.first, self.second.reshape(-1, 9)], axis=1)
        keep = group >= 0
        if not keep.all():
            group, flat = group[keep], flat[keep]
        ends = np.arange(len(group) + 1)
        member = sparse.csc_array((np.ones(len(group)), group, ends), shape=(n_groups, len(group)))
        sums: FloatArray = member @ flat
        return Moments(sums[:, 0], sums[:, 1:4], sums[:, 4:].reshape(-1, 3, 3))

    @property
    def centroid(self) -> FloatArray:
        """(n, 3) metres; the origin for pieces without area."""
        area = self.area[:, None]
        return np.divide(self.first, area, out=np.zeros_like(self.first), where=area > 0)

    @property
    def scatter(self) -> FloatArray:
        """(n, 3, 3) second moments about the centroid, m^4."""
        return self.second - self.first[:, :, None] * self.centroid[:, None, :]

    def principal(self) -> tuple[FloatArray, FloatArray]:
        """Eigenvalues of the scatter, ascending (n, 3), and eigenvectors in columns (n, 3, 3)."""
        values, vectors = np.linalg.eigh(self.scatter)
        return np.maximum(values, 0.0), vectors

    def distance(self, point: FloatArray, normal: FloatArray) -> FloatArray:
        """(n,) root mean square distance from a plane, metres; 0 for pieces without area.

        Parameters
        ----------
        point, normal : (3,) or (n, 3) float
            Of one plane, or one for each piece; the normals are unit vectors.
        """
        normal = np.broadcast_to(normal, self.first.shape)
        offset = np.einsum("ij,ij->i", self.centroid - point, normal)
        spread = np.einsum("ni,nij,nj->n", normal, self.scatter, normal)
        area = np.where(self.area > 0, self.area, 1.0)
        return np.asarray(np.sqrt(offset**2 * (self.area > 0) + np.maximum(spread / area, 0.0)))

    def flatness(self) -> FloatArray:
        """(n,) smallest over largest eigenvalue of the scatter: 0 is a plane; 0 where there is no area."""
        values, _ = self.principal()
        return np.divide(values[:, 0], values[:, 2], out=np.zeros(len(values)), where=values[:, 2] > 0)


def face_moments(mesh: Mesh) -> Moments:
    """Exact moments of each triangle, about the centre of the bounding box of the faces.

    The second moment of a triangle of area a with corners p, q, r and centroid c is
    a (p pᵀ + q qᵀ + r rᵀ + 9 c cᵀ) / 12. A point of a cloud is a disc.

    Returns
    -------
    Moments
        Positions count from ``moment_origin(mesh)``: near the data, so that the differences in
        ``scatter`` keep their digits.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.moments import face_moments
    >>> face_moments(square(1)).area.tolist()
    [0.5, 0.5]
    """
    if mesh.is_cloud:  # discs: a (p pᵀ + a (I − n nᵀ) / 4π)
        place, area, normal = mesh.face_centroids - moment_origin(mesh), mesh.face_areas, mesh.face_normals
        disc = (np.eye(3) - normal[:, :, None] * normal[:, None]) * (area / (4 * np.pi))[:, None, None]
        second = area[:, None, None] * (place[:, :, None] * place[:, None] + disc)
        return Moments(area, area[:, None] * place, second)
    corners = (mesh.vertices - moment_origin(mesh))[mesh.faces]
    center = corners.mean(axis=1)
    area = mesh.face_areas
    second = np.einsum("fki,fkj->fij", corners, corners) + 9.0 * center[:, :, None] * center[:, None, :]
    return Moments(area, area[:, None] * center, (area / 12.0)[:, None, None] * second)


def group_moments(mesh: Mesh, group: IntArray, n_groups: int) -> Moments:
    """Moments of groups of faces: the same as ``face_moments(mesh).gather(group, n_groups)``, in one pass.

    Parameters
    ----------
    mesh : Mesh
    group : (n_faces,) int
        Group of each face; faces in group −1 are left out.
    n_groups : int

    Returns
    -------
    Moments
        Of each group; positions count from ``moment_origin(mesh)``.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.moments import group_moments
    >>> group_moments(square(1), np.array([0, -1]), 1).area.tolist()
    [0.5]
    """
    sums = np.zeros((n_groups, 13))
    group = np.asarray(group, dtype=np.int32)
    vertices = mesh.vertices - moment_origin(mesh)
    if mesh.is_cloud:
        _add_discs(vertices, mesh.face_normals, mesh.face_areas, group, sums)
    else:
        _add_moments(vertices, mesh.faces, mesh.face_areas, group, sums)
    return Moments(sums[:, 0], sums[:, 1:4], sums[:, 4:].reshape(-1, 3, 3))


@kernel
def _add_moments(vertices, faces, areas, group, sums):  # type: ignore[no-untyped-def]
    """Add the area, the first and the second moments of each face to the row of its group."""
    for f in range(len(faces)):
        row = group[f]
        if row < 0:
            continue
        p, q, r = faces[f, 0], faces[f, 1], faces[f, 2]
        area = areas[f]
        sums[row, 0] += area
        for i in range(3):
            a, b, c = vertices[p, i], vertices[q, i], vertices[r, i]
            center = (a + b + c) / 3
            sums[row, 1 + i] += area * center
            for j in range(3):
                d, e, g = vertices[p, j], vertices[q, j], vertices[r, j]
                sums[row, 4 + 3 * i + j] += (
                    area / 12.0 * (a * d + b * e + c * g + 9.0 * center * ((d + e + g) / 3))
                )


@kernel
def _add_discs(points, normals, areas, group, sums):  # type: ignore[no-untyped-def]
    """The same of the discs around points."""
    for f in range(len(points)):
        row = group[f]
        if row < 0:
            continue
        area = areas[f]
        sums[row, 0] += area
        for i in range(3):
            sums[row, 1 + i] += area * points[f, i]
            for j in range(3):
                disc = ((1.0 if i == j else 0.0) - normals[f, i] * normals[f, j]) * (area / (4 * np.pi))
                sums[row, 4 + 3 * i + j] += area * (points[f, i] * points[f, j] + disc)


def mean_normals(vectors: FloatArray, group: IntArray, n_groups: int) -> FloatArray:
    """(n_groups, 3) float64 unit direction of the sum of each group's vectors; zero where they cancel.

    Of ``mesh.face_vectors``, or of normals times areas, it is the mean normal by area.

    Parameters
    ----------
    vectors : (n, 3) float
    group : (n,) int
        Of each vector; −1 leaves it out.
    n_groups : int

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import folded, square
    >>> from scenewidget.engine.moments import mean_normals
    >>> mesh = folded(square(2), "x", 0.5, np.pi / 2)
    >>> mean_normals(mesh.face_vectors, np.arange(8) // 4, 2).round(6).tolist()
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]
    """
    keep = group >= 0
    sums = np.stack([np.bincount(group[keep], v[keep], n_groups) for v in vectors.T], axis=1)
    sums = sums.astype(np.float64)  # without any vector, numpy counts in whole numbers
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray(np.divide(sums, length, out=np.zeros_like(sums), where=length > 0))


def moment_origin(mesh: Mesh) -> FloatArray:
    """(3,) centre of the bounding box of the faces of a mesh, metres.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.moments import moment_origin
    >>> moment_origin(square(1, size=2.0)).tolist()
    [1.0, 1.0, 0.0]
    """
    return np.asarray(0.5 * (mesh.bounds[0] + mesh.bounds[1]))
