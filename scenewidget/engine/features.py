"""Descriptors of the vertices of a mesh, and their lift to its faces.

Goes in: a mesh or its eigenbasis. Come out: δ-coordinates and mean curvature (thesis 3.2), the global
point signature (thesis 3.3), heat and wave kernel signatures.

A vertex in no face has descriptor 0. With a basis per component, each component is described by its own
eigenpairs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from scenewidget.engine.checks import checked_count
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.operators import Eigenbasis, cotangent_laplacian, uniform_laplacian

__all__ = [
    "checked_descriptor",
    "delta_coordinates",
    "global_point_signature",
    "heat_kernel_signature",
    "heat_kernel_times",
    "mean_curvature",
    "unit_steps",
    "vertex_to_face",
    "wave_kernel_energies",
    "wave_kernel_signature",
]


def delta_coordinates(mesh: Mesh, kind: Literal["cotangent", "uniform"] = "cotangent") -> FloatArray:
    """Laplacian of the positions, δ = L V (thesis Eqs. 3.2 and 3.3).

    Parameters
    ----------
    mesh : Mesh
    kind : "cotangent" | "uniform"
        Of the Laplacian.

    Returns
    -------
    delta : (n_vertices, 3) float64
        "cotangent": 2 H n in 1/m, outward where the surface is convex; at the boundary it also points
        out of the surface. "uniform": valence times the step from the mean of the neighbours, metres.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import sphere
    >>> from scenewidget.engine.features import delta_coordinates
    >>> delta = delta_coordinates(sphere(3, radius=2.0))
    >>> np.linalg.norm(delta, axis=1).mean().round(2).item()  # twice the mean curvature, 2 / radius
    1.0
    """
    V = mesh.vertices - mesh.vertices[mesh.faces[0, 0]]  # far from the origin, digits would be lost
    if kind == "uniform":
        return uniform_laplacian(mesh) @ V  # type: ignore[no-any-return]
    if kind != "cotangent":
        raise ValueError(f'kind must be "cotangent" or "uniform", got {kind!r}')
    W, A = cotangent_laplacian(mesh)
    return (W @ V) / A.diagonal()[:, None]  # type: ignore[no-any-return]


def mean_curvature(mesh: Mesh) -> FloatArray:
    """Size of the mean curvature, |δ_cot|/2, in 1/m; not meaningful at the boundary.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    curvature : (n_vertices,) float64
        Unsigned: 1/r on a sphere of radius r, whichever way its faces are wound.

    References
    ----------
    Meyer, Desbrun, Schröder and Barr (2003), Visualization and Mathematics III.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import sphere
    >>> from scenewidget.engine.features import mean_curvature
    >>> mean_curvature(sphere(3, radius=2.0)).mean().round(2).item()
    0.5
    """
    return 0.5 * np.linalg.norm(delta_coordinates(mesh), axis=1)  # type: ignore[no-any-return]


def global_point_signature(basis: Eigenbasis) -> FloatArray:
    """GPS(p) = (φ_1(p)/√λ_1, φ_2(p)/√λ_2, …), zero modes dropped (thesis Eq. 3.6).

    Independent of position, orientation and scale of the mesh.

    Returns
    -------
    signature : (n_vertices, d) float64
        A column for each λ > 0, so d = k − 1 on a connected mesh. With a basis per component d = k − 1
        too, and components with fewer vertices than k have zeros in the rest of their columns.

    References
    ----------
    Rustamov (2007), Symposium on Geometry Processing.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.features import global_point_signature
    >>> from scenewidget.engine.operators import eigenbasis
    >>> basis = eigenbasis(square(6), 4)
    >>> global_point_signature(basis).shape
    (49, 3)
    """
    if basis.is_per_component:
        values, vectors = basis.values[basis.component, 1:], basis.vectors[:, 1:]
    else:
        is_zero = basis.values <= 0
        values, vectors = basis.values[~is_zero], basis.vectors[:, ~is_zero]
    inverse_root = np.divide(1.0, np.sqrt(values), out=np.zeros_like(values), where=values > 0)
    return vectors * inverse_root


def heat_kernel_times(basis: Eigenbasis, n_times: int = 100) -> FloatArray:
    """Diffusion times from 4 ln 10/λ_max to 4 ln 10/λ_min, evenly spaced in their logarithm.

    λ_min is the smallest nonzero eigenvalue of the basis and λ_max the largest (Sun et al. 2009 use λ_300).

    Returns
    -------
    times : (n_times,) float64
        Square metres, ascending.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.features import heat_kernel_times
    >>> from scenewidget.engine.operators import eigenbasis
    >>> heat_kernel_times(eigenbasis(square(6), 4), 3).round(2).tolist()
    [0.48, 0.68, 0.95]
    """
    low, high = _spectral_range(basis)
    n_times = checked_count("n_times", n_times)
    return np.geomspace(4 * np.log(10) / high, 4 * np.log(10) / low, n_times)


def heat_kernel_signature(
    basis: Eigenbasis, times: FloatArray | None = None, *, scaled: bool = False
) -> FloatArray:
    """Heat left at each vertex after time t, started there as a unit: Σ_i exp(−λ_i t) φ_i(p)².

    Parameters
    ----------
    basis : Eigenbasis
        Mass-orthonormal eigenpairs of the Laplacian, so that mass @ signature = Σ_i exp(−λ_i t).
    times : (n_times,) float64, optional
        Diffusion times in square metres, not negative; `heat_kernel_times` if not given.
    scaled : bool
        Divide by the heat trace Σ_i exp(−λ_i t), of the component if the basis is per component, so that
        all times weigh alike in a comparison.

    Returns
    -------
    signature : (n_vertices, n_times) float64
        1/m².

    References
    ----------
    Sun, Ovsjanikov and Guibas (2009), Computer Graphics Forum 28(5).

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.features import heat_kernel_signature
    >>> from scenewidget.engine.operators import eigenbasis
    >>> basis = eigenbasis(square(6), 4)
    >>> heat_kernel_signature(basis, np.array([0.01, 1e3])).mean(axis=0).round(2).tolist()
    [4.15, 1.0]
    """
    times = heat_kernel_times(basis) if times is None else _checked_samples("times", times)
    if times.min() < 0:
        raise ValueError(f"times must not be negative, got {times.min()}")
    return _filtered(basis, lambda values: np.exp(-np.outer(values, times)), is_scaled=scaled)


def wave_kernel_energies(basis: Eigenbasis, n_energies: int = 100) -> tuple[FloatArray, float]:
    """Energies and their spread as Aubry et al. choose them, from the range of log λ in the basis.

    Returns
    -------
    energies : (n_energies,) float64
        Logarithms of eigenvalues, evenly spaced from log λ_min + 2σ to log λ_max − 2σ.
    sigma : float
        σ, seven times the spacing; 1.0 if the basis has only one nonzero eigenvalue.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.features import wave_kernel_energies
    >>> from scenewidget.engine.operators import eigenbasis
    >>> energies, sigma = wave_kernel_energies(eigenbasis(square(6), 4), 3)
    >>> energies.round(2).tolist(), round(sigma, 2)
    ([2.58, 2.61, 2.65], 0.16)
    """
    low, high = np.log(_spectral_range(basis))
    n_energies = checked_count("n_energies", n_energies)
    sigma = 7 * (high - low) / (n_energies + 28)  # spacing (high − low − 4σ)/n, σ = 7 spacings
    energies = np.linspace(low + 2 * sigma, high - 2 * sigma, n_energies)
    return energies, float(sigma) or 1.0


def wave_kernel_signature(
    basis: Eigenbasis, energies: FloatArray | None = None, sigma: float | None = None
) -> FloatArray:
    """Mean presence at each vertex of a quantum particle with energy near e: Σ_i C_e g_i(e) φ_i(p)².

    g_i(e) = exp(−(e − log λ_i)²/(2σ²)) and C_e = 1/Σ_i g_i(e), so that mass @ signature = 1 (on each
    component if the basis is per component). Zero modes have no part in it. Unlike heat it looks at a band
    around each scale, so fine detail is not drowned by the coarse shape.

    Parameters
    ----------
    basis : Eigenbasis
    energies : (n_energies,) float64, optional
        Logarithms of eigenvalues (of λ in 1/m²); those of `wave_kernel_energies` if not given.
    sigma : float, optional
        Spread of the band, positive; that of `wave_kernel_energies` for as many energies if not given.

    Returns
    -------
    signature : (n_vertices, n_energies) float64
        1/m². 0 on components without a nonzero eigenvalue in the basis.

    References
    ----------
    Aubry, Schlickewei and Cremers (2011), ICCV Workshops.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.features import wave_kernel_signature
    >>> from scenewidget.engine.operators import eigenbasis
    >>> wave_kernel_signature(eigenbasis(square(6), 4)).shape
    (49, 100)
    """
    given = None if energies is None else _checked_samples("energies", energies)
    default, default_sigma = wave_kernel_energies(basis, 100 if given is None else len(given))
    e = default if given is None else given
    if sigma is None:
        sigma = default_sigma
    if not (np.isfinite(sigma) and sigma > 0):
        raise ValueError(f"sigma must be a positive number, got {sigma!r}")

    def bands(values: FloatArray) -> FloatArray:
        is_zero = values <= 0
        steps = e - np.log(np.where(is_zero, 1.0, values))[:, None]
        exponents = -0.5 * (steps / sigma) ** 2
        exponents[is_zero] = -np.inf
        return exponents

    return _filtered(basis, lambda values: _softmax(bands(values)))


def checked_descriptor(mesh: Mesh, features: Any) -> FloatArray:
    """A descriptor of the user's own, lifted to the faces.

    Parameters
    ----------
    mesh : Mesh
    features : (n_vertices, d) or (n_faces, d) numbers
        In any unit, d at least 1. A mesh with as many vertices as faces takes them as of vertices; a point
        cloud's are of points.

    Returns
    -------
    by_face : (n_faces, d) float64
        Means of a face's corners. Each column moved so that 0 is in the middle of its range (a constant one
        is exactly 0 then), all together scaled into −1..1 by a power of two.

    Examples
    --------
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.features import checked_descriptor
    >>> checked_descriptor(square(1), [[0, 7], [8, 7]]).tolist()  # of the two faces
    [[-0.5, 0.0], [0.5, 0.0]]
    """
    given = np.asarray(features)
    if given.dtype.kind not in "biuf":
        raise TypeError(f"features must be numbers, got {given.dtype}; turn classes into a column each")
    shapes = f"({mesh.n_vertices}, d), a row a vertex, or ({mesh.n_faces}, d), a row a face"
    if given.ndim != 2 or len(given) not in (mesh.n_vertices, mesh.n_faces):
        hint = "; write features[:, None]" if given.ndim == 1 and given.size > 0 else ""
        raise ValueError(f"features must have shape {shapes}, got {given.shape}{hint}")
    if given.shape[1] == 0:
        raise ValueError(f"features must have at least one column, got {given.shape}")
    values = given.astype(np.float64)
    is_bad = ~np.isfinite(values).all(axis=1)
    if is_bad.any():
        raise ValueError(
            f"features must be finite, got NaN or infinite values in {is_bad.sum()} of {len(values)} rows, "
            f"first in row {is_bad.argmax()}; np.nan_to_num(features) makes them 0"
        )
    values -= values.min(axis=0) / 2 + values.max(axis=0) / 2
    values = np.ldexp(values, -np.frexp(np.abs(values).max())[1])
    is_by_vertex = len(values) == mesh.n_vertices and not mesh.is_cloud
    return vertex_to_face(mesh, values) if is_by_vertex else values


def unit_steps(features: FloatArray, pairs: IntArray) -> FloatArray | None:
    """Features in the unit in which the step from an item to its neighbour is 1.

    That is the mean step over all pairs, each weighted by the step itself, Σd² / Σd: so a descriptor that
    differs along one border alone, or is noise elsewhere, makes a step of 1 there.

    Parameters
    ----------
    features : (n_items, d) float
    pairs : (n_pairs, 2) int

    Returns
    -------
    scaled : (n_items, d) float64 or None
        None where no step is greater than 0: the features say nothing.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.engine.features import unit_steps
    >>> pairs = np.array([[0, 1], [1, 2], [2, 3]])
    >>> unit_steps(np.array([[5.0], [5.0], [9.0], [9.0]]), pairs).ravel().tolist()
    [1.25, 1.25, 2.25, 2.25]
    """
    steps = np.linalg.norm(features[pairs[:, 0]] - features[pairs[:, 1]], axis=1)
    total = steps.sum()
    return features / ((steps @ steps) / total) if steps @ steps > 0 else None


def vertex_to_face(mesh: Mesh, values: FloatArray) -> FloatArray:
    """Mean of the values at the three corners of each face (the thesis clusters faces, but does not say).

    Parameters
    ----------
    mesh : Mesh
    values : (n_vertices, d) or (n_vertices,) float

    Returns
    -------
    face_values : (n_faces, d) or (n_faces,) float64

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.features import vertex_to_face
    >>> vertex_to_face(square(1), np.array([[0.0], [1.0], [2.0], [3.0]])).round(2).tolist()
    [[1.67], [1.33]]
    """
    values = np.asarray(values)
    if values.ndim not in (1, 2) or len(values) != mesh.n_vertices:
        raise ValueError(
            f"values must have a row for each of the {mesh.n_vertices} vertices, got shape {values.shape}"
        )
    a, b, c = mesh.faces.T
    return (values[a] + values[b] + values[c]) / 3.0  # type: ignore[no-any-return]


# --- parts ----------------------------------------------------------------------------------------


def _filtered(
    basis: Eigenbasis, response: Callable[[FloatArray], FloatArray], *, is_scaled: bool = False
) -> FloatArray:
    """Σ_i r_i φ_i(p)² with r (k, n_samples) = response(λ), component by component if the basis is."""
    squares = basis.vectors**2
    if not basis.is_per_component:
        weights = response(basis.values)
        return squares @ _unit_sums(weights) if is_scaled else squares @ weights
    order = np.argsort(basis.component, kind="stable")
    ends = np.searchsorted(basis.component[order], np.arange(basis.n_components), side="right")
    starts = np.concatenate([[np.count_nonzero(basis.component < 0)], ends[:-1]])
    rows = []
    for values, start, end in zip(basis.values, starts, ends):
        n_pairs = np.count_nonzero(np.isfinite(values))
        weights = response(values[:n_pairs])
        rows.append(squares[order[start:end], :n_pairs] @ (_unit_sums(weights) if is_scaled else weights))
    out = np.zeros((len(order), rows[0].shape[1]))
    out[order[starts[0] :]] = np.concatenate(rows)
    return out


def _softmax(exponents: FloatArray) -> FloatArray:
    """exp, scaled to sum 1 down each column; 0 where all exponents are −inf."""
    top = exponents.max(axis=0, initial=-np.inf)
    weights = np.exp(exponents - np.where(np.isfinite(top), top, 0.0))
    return _unit_sums(weights)


def _unit_sums(weights: FloatArray) -> FloatArray:
    total = weights.sum(axis=0)
    scaled: FloatArray = np.divide(weights, total, out=np.zeros_like(weights), where=total > 0)
    return scaled


def _spectral_range(basis: Eigenbasis) -> tuple[float, float]:
    """Smallest and largest nonzero eigenvalue, filled rows left out."""
    proper = basis.values[(basis.values > 0) & np.isfinite(basis.values)]
    if proper.size == 0:
        way_out = f"k > {basis.k}, or for per_component=True"
        if basis.is_per_component:  # as in a pipeline, which adds the zero mode to n_eigenpairs
            way_out = f"k > {basis.k}; with segment, set n_eigenpairs to {basis.k} or more"
        raise ValueError(
            "basis has only zero modes: there is at least one for each component (here "
            f"{basis.n_components} components), more where faces have no area; ask eigenbasis for {way_out}"
        )
    return float(proper.min()), float(proper.max())


def _checked_samples(name: str, samples: FloatArray) -> FloatArray:
    array = np.asarray(samples, dtype=np.float64)
    if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite numbers, shape (n_{name},), got shape {array.shape}")
    return array
