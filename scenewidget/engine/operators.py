"""Laplacians of a triangle mesh and their eigenpairs.

Goes in: a mesh. Come out: the uniform and the cotangent Laplacian (thesis 3.2), mixed Voronoi areas
(Meyer et al. 2003) and the eigenbasis W φ = λ A φ, smallest eigenvalues first (thesis Eq. 3.4).

A cloud has the triangles of the tangent plane at each point, a third of each for each corner that has it
(Sharp and Crane 2020): where all three agree, as a triangulation would have it. The smallest eigenvalues are
near those of the surface, not those of another sampling of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh, splu

from scenewidget.engine.checks import checked_count
from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh, MeshError, connected_components
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.threads import one_blas_thread

__all__ = [
    "Eigenbasis",
    "LaplacianKind",
    "cotangent_laplacian",
    "eigenbasis",
    "mixed_areas",
    "robust_laplacian",
    "uniform_laplacian",
    "vertex_components",
]

LaplacianKind = Literal["cotangent", "uniform", "robust"]

MIN_DOUBLE_AREA = 1e-12  # of the largest face: below it a cotangent is taken as if the face were that large
MIN_VERTEX_AREA = 1e-9  # of the mean vertex area, so that A can be inverted
SHIFT = 1e-8  # of a typical diagonal entry of A⁻¹W: makes W + shift·A positive definite
DENSE_LIMIT = 250  # vertices up to which a component is solved densely


# --- Laplacians -----------------------------------------------------------------------------------


def uniform_laplacian(mesh: Mesh) -> sparse.csr_array:
    """Valence on the diagonal, −1 for each edge (thesis 3.2).

    It knows the connectivity only. An edge counts once, whatever the number of faces at it.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    L : (n_vertices, n_vertices) csr float64
        Symmetric, rows sum to 0; vertices in no face have an empty row.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.operators import uniform_laplacian
    >>> uniform_laplacian(square(1)).toarray().tolist()
    [[3.0, -1.0, -1.0, -1.0], [-1.0, 2.0, 0.0, -1.0], [-1.0, 0.0, 2.0, -1.0], [-1.0, -1.0, -1.0, 3.0]]
    """
    n = mesh.n_vertices
    mesh = _triangulated(mesh) if isinstance(mesh, PointCloud) else mesh
    edges = _face_edges(mesh)
    low, high = edges.min(axis=1).astype(np.int64), edges.max(axis=1).astype(np.int64)
    key = np.unique(low * n + high)
    low, high = (part.astype(np.int32) for part in np.divmod(key, n))
    keep = low != high  # a face that names a vertex twice
    return _from_edge_weights(n, low[keep], high[keep], np.ones(int(keep.sum())))


def cotangent_laplacian(mesh: Mesh) -> tuple[sparse.csr_array, sparse.csr_array]:
    """W and A with L_cot = A⁻¹W, so that the Laplacian of a function u at the vertices is A⁻¹(W u).

    The thesis prints W with a zero diagonal; its Eq. 3.4 needs the one built here, W = diag(M·1) − M with
    m_ij = (cot α_ij + cot β_ij)/2 over the faces at edge ij: one of them on the boundary (Neumann), all of
    them at a non-manifold edge. Negative cotangents are kept, so W is positive semi-definite.

    Returns
    -------
    W : (n_vertices, n_vertices) csr float64
        Symmetric, rows sum to 0, independent of scale. Vertices in no face have an empty row. Twice the
        area of a face is taken to be at least 1e-12 of that of the largest.
    A : (n_vertices, n_vertices) csr float64
        Diagonal, square metres: `mixed_areas`, at least 1e-9 of their mean (vertices in no face too).

    Raises
    ------
    MeshError
        No face has an area.

    References
    ----------
    Pinkall and Polthier (1993), Experimental Mathematics 2(1). Meyer, Desbrun, Schröder and Barr (2003),
    Visualization and Mathematics III.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.operators import cotangent_laplacian
    >>> W, A = cotangent_laplacian(square(4))
    >>> bool(abs(W.sum(axis=1)).max() < 1e-12), A.diagonal().sum().round(6).item()
    (True, 1.0)
    """
    if isinstance(mesh, PointCloud):
        triangulated = _triangulated(mesh)
        W, A = cotangent_laplacian(triangulated)
        areas = _clamped(A.diagonal() / 3.0, triangulated.is_used)
        return W / 3.0, sparse.diags_array(areas, format="csr")
    _check_area(mesh)
    dots = _corner_dots(mesh)
    double_area = 2.0 * mesh.face_areas
    cotangents = dots / np.maximum(double_area, MIN_DOUBLE_AREA * double_area.max())[:, None]
    start, end = np.roll(mesh.faces, -1, axis=1).ravel(), np.roll(mesh.faces, -2, axis=1).ravel()
    keep = start != end
    W = _from_edge_weights(mesh.n_vertices, start[keep], end[keep], 0.5 * cotangents.ravel()[keep])
    return W, sparse.diags_array(_clamped(mixed_areas(mesh), mesh.is_used), format="csr")


def robust_laplacian(mesh: Mesh) -> tuple[sparse.csr_array, sparse.csr_array]:
    """W and A of the intrinsic Delaunay triangulation of the tufted cover; needs the extra ``robust``.

    Never a negative weight, whatever the triangles, and at home on non-manifold meshes. It differs from
    the thesis. Faces that name a vertex twice are left out.

    Returns
    -------
    W, A : (n_vertices, n_vertices) csr float64
        As `cotangent_laplacian`; A holds lumped areas (a third of each face at the vertex).

    References
    ----------
    Sharp and Crane (2020), Computer Graphics Forum 39(5); package ``robust_laplacian``.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.operators import robust_laplacian
    >>> W, A = robust_laplacian(square(4))  # doctest: +SKIP
    """
    try:
        import robust_laplacian as package  # type: ignore[import-not-found, unused-ignore]
    except ImportError as error:
        raise ImportError(
            'laplacian="robust" needs the package robust_laplacian: pip install "scenewidget[robust]"'
        ) from error
    if isinstance(mesh, PointCloud):
        once = np.unique(np.sort(mesh.triangles, axis=1), axis=0)
        mesh = Mesh(mesh.points, once if len(once) else _triangulated(mesh).faces)
    _check_area(mesh)
    n = mesh.n_vertices
    is_proper = (mesh.faces != np.roll(mesh.faces, 1, axis=1)).all(axis=1)
    used, faces = np.unique(mesh.faces[is_proper], return_inverse=True)
    W, A = package.mesh_laplacian(mesh.vertices[used], faces.reshape(-1, 3))
    W = sparse.coo_array(0.5 * (W + W.T))
    rows, columns = (used[index].astype(np.int32) for index in W.coords)
    areas = np.zeros(n)
    areas[used] = A.diagonal()
    W = sparse.csr_array((W.data, (rows, columns)), shape=(n, n))
    return W, sparse.diags_array(_clamped(areas, mesh.is_used), format="csr")


def mixed_areas(mesh: Mesh) -> FloatArray:
    """Area that belongs to each vertex; the areas sum to that of the mesh.

    In a face without an obtuse angle a corner owns its Voronoi region, (|e_j|² cot_j + |e_k|² cot_k)/8; in
    an obtuse one half the area belongs to the obtuse corner, a quarter to each of the others.

    Returns
    -------
    areas : (n_vertices,) float64
        Square metres; 0 for vertices in no face or in degenerate faces only.

    References
    ----------
    Meyer, Desbrun, Schröder and Barr (2003), Visualization and Mathematics III.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.operators import mixed_areas
    >>> mixed_areas(square(4)).sum().round(6).item()
    1.0
    """
    if isinstance(mesh, PointCloud):
        return mixed_areas(_triangulated(mesh)) / 3.0
    dots = _corner_dots(mesh)
    corners = mesh.vertices[mesh.faces]
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    pull = np.einsum("fci,fci->fc", opposite, opposite) * dots
    # Shares of the face's own area, not areas from cotangents: the sum stays exact in a needle.
    share = np.roll(pull, -1, axis=1) + np.roll(pull, -2, axis=1)
    total = share.sum(axis=1, keepdims=True)
    share = np.divide(share, total, out=np.full_like(share, 1.0 / 3.0), where=total > 0)
    is_obtuse = dots.min(axis=1) < 0
    share[is_obtuse] = 0.25
    share[is_obtuse, dots[is_obtuse].argmin(axis=1)] = 0.5
    areas = (share * mesh.face_areas[:, None]).ravel()
    return np.bincount(mesh.faces.ravel(), areas, mesh.n_vertices).astype(np.float64, copy=False)


def vertex_components(mesh: Mesh) -> IntArray:
    """Connected component of each vertex over the edges of the faces.

    Vertices at the same place stay apart here, as in the Laplacians (`face_adjacency` takes them as one).

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    component : (n_vertices,) int32
        Numbered by the smallest vertex in it; −1 for vertices in no face.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.engine.operators import vertex_components
    >>> vertex_components(sw.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]], [[0, 1, 2]])).tolist()
    [0, 0, 0, -1]
    """
    mesh = _triangulated(mesh) if isinstance(mesh, PointCloud) else mesh
    _, component = connected_components(mesh.n_vertices, _face_edges(mesh))
    is_used = mesh.is_used
    out = np.full(mesh.n_vertices, -1, dtype=np.int32)
    out[is_used] = np.unique(component[is_used], return_inverse=True)[1]
    return out


# --- eigenbasis -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Eigenbasis:
    """Eigenpairs of W φ = λ A φ; arrays are copied, checked and made read-only.

    Parameters
    ----------
    values : (k,) or (n_components, k) float64
        Eigenvalues in 1/m², ascending; zero modes are exactly 0. With a row per component, a component
        with fewer than k vertices has inf in the rest of its row.
    vectors : (n_vertices, k) float64
        Column i holds φ_i, mass-orthonormal: vectorsᵀ A vectors = 1, in each component on its own if
        ``values`` has a row for each. 0 at vertices in no face.
    mass : (n_vertices,) float64
        Diagonal of A, square metres (ones for the uniform Laplacian).
    component : (n_vertices,) int32
        Connected component of each vertex; −1 for vertices in no face.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.operators import eigenbasis
    >>> basis = eigenbasis(square(8), 3)
    >>> basis.vectors.shape, bool(basis.values[0] < 1e-9)
    ((81, 3), True)
    """

    values: FloatArray
    vectors: FloatArray
    mass: FloatArray
    component: IntArray

    def __post_init__(self) -> None:
        for name, dtype in (("values", float), ("vectors", float), ("mass", float), ("component", np.int32)):
            array = np.array(getattr(self, name), dtype=dtype, order="C")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if self.vectors.ndim != 2 or self.values.shape not in (
            self.vectors.shape[1:],
            (self.n_components, self.vectors.shape[1]),
        ):
            raise ValueError(
                "values must have shape (k,) or (n_components, k) and vectors (n_vertices, k), got "
                f"{self.values.shape} and {self.vectors.shape} for {self.n_components} components"
            )
        for name in ("mass", "component"):
            if getattr(self, name).shape != self.vectors.shape[:1]:
                raise ValueError(
                    f"{name} must have shape ({len(self.vectors)},), one entry a row of vectors, "
                    f"got {getattr(self, name).shape}"
                )

    def __repr__(self) -> str:
        pairs = f"{self.k} pairs" + (" for each component" if self.is_per_component else "")
        return f"Eigenbasis({pairs}, {len(self.vectors)} vertices, {self.n_components} components)"

    @property
    def k(self) -> int:
        """Number of columns in ``vectors``."""
        return int(self.vectors.shape[1])

    @property
    def n_components(self) -> int:
        """Number of connected components."""
        return int(self.component.max(initial=-1)) + 1

    @property
    def is_per_component(self) -> bool:
        """Whether each component has k eigenvalues of its own."""
        return self.values.ndim == 2


def eigenbasis(
    mesh: Mesh,
    k: int = 50,
    *,
    laplacian: LaplacianKind = "cotangent",
    per_component: bool = False,
    monitor: Monitor | None = None,
) -> Eigenbasis:
    """The k smallest eigenpairs of W φ = λ A φ, zero modes included.

    Every connected component is a problem of its own: its smallest eigenvalue is 0 with a constant
    eigenfunction, and each φ lives on one component. What comes back is either the k smallest pairs of
    the whole mesh, whose number of zeros is the number of components, or k pairs for each component. The
    second is what descriptors need (thesis 3.1 treats components one by one): in the first, a cup on the
    other side of the room may own no pair but its constant.

    Parameters
    ----------
    mesh : Mesh
    k : int
        Number of pairs; the zero modes count, so 50 coordinates of `global_point_signature` of a
        connected mesh take k = 51.
    laplacian : "cotangent", "uniform" or "robust"
        The thesis uses the cotangent one. "uniform" has mass 1 at every vertex.
    per_component : bool
        k pairs for each component instead of k in all.
    monitor : Monitor, optional

    Returns
    -------
    basis : Eigenbasis
        Deterministic; the entry of largest |φ| is positive (of equal ones the first). Where eigenvalues
        coincide, the basis of their space is arbitrary, as ever. A mesh has as many pairs as vertices:
        with fewer than k, all of them are returned (per component: the row is filled up with λ = inf,
        φ = 0). Vertices in no face are left out and have φ = 0.

    Raises
    ------
    MeshError
        No face has an area ("cotangent", "robust").

    Notes
    -----
    Lanczos iteration on the inverse: W + shift·A is factored once by SuperLU in a minimum-degree order and
    without pivoting (it is symmetric positive definite), the constant is projected out, and the zero mode
    is put in exactly. 50 pairs at 50 000 vertices take two seconds. Small components are solved densely.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.operators import eigenbasis
    >>> eigenbasis(square(30), 3).values.round(1).tolist()  # 0, then twice about π²
    [0.0, 9.9, 9.9]
    """
    k = checked_count("k", k)
    W, mass = _operators(mesh, laplacian)
    monitor = monitor or SILENT
    component = vertex_components(mesh)
    order = np.argsort(component, kind="stable")
    order = order[component[order] >= 0]
    pieces = np.split(order, np.flatnonzero(np.diff(component[order])) + 1)
    W = W[order][:, order]  # block diagonal

    found = []
    start = 0
    with one_blas_thread():
        for vertices in pieces:
            end = start + len(vertices)

            def tick(share: float, start: int = start, n: int = len(vertices)) -> None:
                monitor.tick((start + share * n) / len(order))

            tick(0.0)
            block = W[start:end, start:end]
            found.append(_smallest_pairs(block, mass[vertices], min(k, len(vertices)), tick, monitor))
            start = end

    if per_component:
        values = np.full((len(pieces), k), np.inf)
        vectors = np.zeros((mesh.n_vertices, k))
        for row, (vertices, (own_values, own_vectors)) in enumerate(zip(pieces, found)):
            values[row, : len(own_values)] = own_values
            vectors[vertices, : len(own_values)] = own_vectors
        return Eigenbasis(values, vectors, mass, component)

    values = np.concatenate([own_values for own_values, _ in found])
    owner = np.repeat(np.arange(len(found)), [len(own_values) for own_values, _ in found])
    column = np.concatenate([np.arange(len(own_values)) for own_values, _ in found])
    smallest = np.argsort(values, kind="stable")[:k]
    vectors = np.zeros((mesh.n_vertices, len(smallest)))
    for i, pick in enumerate(smallest):
        vectors[pieces[owner[pick]], i] = found[owner[pick]][1][:, column[pick]]
    return Eigenbasis(values[smallest], vectors, mass, component)


def _operators(mesh: Mesh, laplacian: str) -> tuple[sparse.csr_array, FloatArray]:
    if laplacian == "uniform":
        return uniform_laplacian(mesh), np.ones(mesh.n_vertices)
    if laplacian == "cotangent":
        W, A = cotangent_laplacian(mesh)
    elif laplacian == "robust":
        W, A = robust_laplacian(mesh)
    else:
        raise ValueError(f'laplacian must be "cotangent", "uniform" or "robust", got {laplacian!r}')
    return W, A.diagonal()


def _smallest_pairs(
    W: sparse.csr_array, mass: FloatArray, k: int, tick: Callable[[float], None], monitor: Monitor
) -> tuple[FloatArray, FloatArray]:
    """The k smallest pairs of one connected component: values (k,), vectors (n, k).

    Solved as μ y = C⁻¹ y with C = A^-½ (W + shift·A) A^-½, y = A^½ φ, λ = 1/μ − shift, in the space
    orthogonal to the constant. The inverse, because a sliver's cotangents dwarf the eigenvalues that we
    are after.
    """
    n, root = len(mass), np.sqrt(mass)
    constant: FloatArray = root / np.linalg.norm(root)
    inverse_values: FloatArray
    y: FloatArray
    stiffness = W.diagonal() / mass
    scale = float(np.median(stiffness)) or float(stiffness.max()) or 1.0
    shift = SHIFT * scale
    if k == 1:
        inverse_values, y = np.empty(0), np.empty((n, 0))
    elif n <= max(DENSE_LIMIT, 2 * k + 10):
        inverse_values, y = _dense_pairs(W, root, constant, k - 1, shift)
    else:
        inverse_values, y = _lanczos_pairs(W, root, constant, k - 1, shift, tick, monitor)
    # The largest |λ| of a full spectrum drown in the rounding of the inverse: keep them finite.
    floor = max(np.finfo(float).eps * inverse_values.max(initial=0.0), 1e-300)
    values = 1.0 / np.maximum(inverse_values, floor) - shift
    values[values < 1e-4 * shift] = 0.0  # a second zero mode: a component of degenerate faces
    order = np.argsort(values, kind="stable")
    values = np.concatenate([[0.0], values[order]])
    phi = np.column_stack([constant, y[:, order]]) / root[:, None]
    return values, _with_fixed_signs(phi)


def _dense_pairs(
    W: sparse.csr_array, root: FloatArray, constant: FloatArray, k: int, shift: float
) -> tuple[FloatArray, FloatArray]:
    n = len(root)
    # Q: orthonormal columns that span what is orthogonal to the constant (a Householder reflection)
    mirror = constant.copy()
    mirror[0] += 1.0
    Q = (np.eye(n) - np.outer(mirror, mirror / mirror[0]))[:, 1:]  # |mirror|² = 2 mirror[0]
    C = Q.T @ (W.toarray() / np.outer(root, root)) @ Q
    C[np.diag_indices(n - 1)] += shift
    try:
        inverse = np.linalg.inv(C)
    except np.linalg.LinAlgError:  # rounding made a pivot exactly 0
        inverse = np.linalg.inv(C + 1e-12 * np.abs(C).max() * np.eye(n - 1))
    values, vectors = linalg.eigh(0.5 * (inverse + inverse.T), subset_by_index=[n - 1 - k, n - 2])
    return values, Q @ vectors


def _lanczos_pairs(
    W: sparse.csr_array,
    root: FloatArray,
    constant: FloatArray,
    k: int,
    shift: float,
    tick: Callable[[float], None],
    monitor: Monitor,
) -> tuple[FloatArray, FloatArray]:
    n = len(root)
    shifted = sparse.csr_array(W + sparse.diags_array(shift * root**2))
    # From some orders of the vertices (a subdivided sphere's) minimum degree takes a hundred times as long.
    order = reverse_cuthill_mckee(shifted, symmetric_mode=True)
    shifted = sparse.csc_array(shifted[order][:, order])
    factorize = partial(
        splu, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0
    )
    try:
        factor = monitor.call(factorize, shifted)
    except RuntimeError:  # rounding made a pivot exactly 0
        largest = float(np.abs(shifted.diagonal()).max())
        factor = monitor.call(factorize, shifted + 1e-12 * largest * sparse.eye_array(n, format="csc"))
    n_basis = min(n, 2 * k + 10)
    n_products = 0

    def apply_inverse(y: FloatArray) -> FloatArray:
        nonlocal n_products
        n_products += 1
        tick(min(n_products / (2 * n_basis), 0.99))
        y = y.ravel()
        y = root * (y - constant * (constant @ y))
        x = np.empty(n)
        x[order] = factor.solve(y[order])
        x *= root
        return x - constant * (constant @ x)

    inverse = LinearOperator((n, n), matvec=apply_inverse, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(n)
    try:
        values, vectors = eigsh(
            inverse, k=k, which="LA", ncv=n_basis, v0=start - constant * (constant @ start)
        )
    except ArpackNoConvergence as error:
        raise MeshError(
            f"eigenpairs did not converge ({len(error.eigenvalues)} of {k} found): the mesh has nearly "
            'degenerate faces; remove them, or use laplacian="robust"'
        ) from error
    return values, vectors


def _with_fixed_signs(phi: FloatArray) -> FloatArray:
    size = np.abs(phi)
    is_largest = size >= (1 - 1e-6) * size.max(axis=0)  # with a margin: φ and −φ may reach the same size
    first = is_largest.argmax(axis=0)
    signed: FloatArray = phi * np.where(phi[first, np.arange(phi.shape[1])] < 0, -1.0, 1.0)
    return signed


# --- parts ----------------------------------------------------------------------------------------


def _triangulated(cloud: PointCloud) -> Mesh:
    """The triangles of the tangent planes of a cloud over its points."""
    if len(cloud.triangles) == 0:
        raise MeshError(
            "no three neighbours of the cloud make a triangle: it has no surface and no Laplacian"
        )
    return Mesh(cloud.points, cloud.triangles)


def _check_area(mesh: Mesh) -> None:
    if not mesh.face_areas.max() > 0:
        raise MeshError(
            f"all {mesh.n_faces} faces are degenerate: the mesh has no area, hence no cotangents; "
            "check the unit and the precision of its vertices"
        )


def _clamped(areas: FloatArray, is_used: BoolArray) -> FloatArray:
    clamped: FloatArray = np.maximum(areas, MIN_VERTEX_AREA * areas[is_used].mean())
    return clamped


def _face_edges(mesh: Mesh) -> IntArray:
    """(3 n_faces, 2) vertices at the ends of each side of each face."""
    return np.stack([mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()], axis=1)


def _corner_dots(mesh: Mesh) -> FloatArray:
    """(n_faces, 3) dot product of the two sides at each corner: its cotangent times twice the area."""
    corners = mesh.vertices[mesh.faces]
    to_next = np.roll(corners, -1, axis=1) - corners
    to_last = np.roll(corners, -2, axis=1) - corners
    dots: FloatArray = np.einsum("fci,fci->fc", to_next, to_last)
    return dots


def _from_edge_weights(n: int, start: IntArray, end: IntArray, weights: FloatArray) -> sparse.csr_array:
    """diag(M·1) − M for the symmetric M with these weights; repeated edges add up."""
    half = sparse.csr_array((weights, (start, end)), shape=(n, n))
    M = half + half.T
    return sparse.csr_array(sparse.diags_array(M.sum(axis=1)) - M)
