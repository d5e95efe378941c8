"""What can be mended about a scan without guessing its shape: bad corners, winding; and what is only said.

Goes in: a `Scan` or a `Mesh`. Comes out: a `Mesh` whose faces know where in the file they were.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh, MeshError, weld
from scenewidget.engine.readers.polygons import triangulated
from scenewidget.engine.readers.scan import Notes, Scan

__all__ = ["checked_triangles", "lost_precision", "wound_alike"]

EDGES = 1 << 19  # looked at together: memory stays small
FAR = 100.0  # extents from the origin; digits may be missing from there on


def checked_triangles(
    scan: Scan, notes: Notes, *, strict: bool, name: str
) -> tuple[IntArray, IntArray | None]:
    """Triangles with corners that exist and are finite, and the polygon of each, None if it is its number.

    Parameters
    ----------
    scan : Scan
    notes : Notes
        Told what was dropped.
    strict : bool
        Refuse what would be dropped.
    name : str
        What messages call the mesh.
    """
    corners, counts = scan.corners, scan.counts
    if corners.dtype.kind == "f":
        whole = np.isfinite(corners) & (np.abs(corners) < 2**53) & (corners == np.floor(corners))
        corners = np.where(whole, corners, -1).astype(np.int64)
    is_good: Any = np.logical_and(corners >= 0, corners < len(scan.vertices))
    is_finite = scan.is_usable
    n_missing = int((~is_good).sum())
    first_missing = int(corners[~is_good][0]) if n_missing else 0
    if not is_finite.all():
        is_good &= is_finite[np.where(is_good, corners, 0)]
    polygon_good: BoolArray
    if counts is None:
        polygon_good = np.asarray(is_good.reshape(-1, 3).all(axis=1))
    else:
        polygon = np.repeat(np.arange(len(counts)), counts)
        polygon_good = np.asarray(np.bincount(polygon[~is_good], minlength=len(counts)) == 0)
    kept = np.flatnonzero(polygon_good)
    if len(kept) < len(polygon_good):
        _judge_dropped(scan, len(polygon_good) - len(kept), n_missing, first_missing, notes, strict, name)
    if counts is None:
        triangles = corners.reshape(-1, 3)
        return (triangles, None) if len(kept) == len(triangles) else (triangles[kept], kept)
    if len(kept) < len(polygon_good):
        corners, counts = corners[polygon_good[polygon]], counts[kept]
    short = int((counts < 3).sum())
    if short and strict:
        raise MeshError(f"{name} has {short} faces with fewer than three corners; strict=False drops them")
    if short:
        notes.say(f"{short} faces with fewer than three corners were dropped", warn=True)
    triangles, home = triangulated(scan.vertices, corners, counts)
    many = int((counts > 3).sum())
    if many:
        notes.say(f"{many} polygons were cut into triangles; faces_of_file tells which face each comes from")
    return triangles, kept[home]


def _judge_dropped(
    scan: Scan, n: int, n_missing: int, first: int, notes: Notes, strict: bool, name: str
) -> None:
    """Say, or refuse, that polygons with bad corners go."""
    n_bad = int((~scan.is_usable).sum())
    why = f"refer to a vertex that does not exist ({first} of {len(scan.vertices)})" if n_missing else ""
    if n_bad:
        why += (" or " if why else "") + f"have NaN, infinite or far corners ({n_bad} vertices do)"
    most = max(1, scan.n_polygons // (100 if n_missing else 2))
    if strict or n > most or n == scan.n_polygons:
        way = "strict=False drops them" if strict and n <= most < scan.n_polygons else "the data are damaged"
        raise MeshError(f"{name}: {n} of {scan.n_polygons} faces {why}; {way}")
    notes.say(f"{n} of {scan.n_polygons} faces were dropped: they {why}", warn=True)


# --- winding --------------------------------------------------------------------------------------


def wound_alike(mesh: Mesh, notes: Notes, *, strict: bool, name: str) -> IntArray:
    """(n_faces, 3) the faces, wound alike where that is safe.

    Neighbours across an edge of exactly two faces must run through it in opposite directions. Where a
    connected part of the surface can be wound so that all do, the smaller share of its area is turned;
    a part that can't (a Möbius strip, a fold of a bad scan) stays as it is.

    Parameters
    ----------
    mesh : Mesh
    notes : Notes
        Told how many were turned.
    strict : bool
        Refuse what would be turned.
    name : str
        What messages call the mesh.
    """
    pairs, is_against = _manifold_pairs(mesh)
    if not is_against.any():
        return mesh.faces
    n = mesh.n_faces
    i, j = pairs.T
    # each face twice, as it is and turned: neighbours against each other join one to the turned other
    first = np.concatenate([i, i + n])
    second = np.where(np.tile(is_against, 2), np.concatenate([j + n, j]), np.concatenate([j, j + n]))
    graph = sparse.coo_matrix((np.ones(len(first), np.int8), (first, second)), shape=(2 * n, 2 * n))
    side = csgraph.connected_components(graph, directed=False)[1]
    here, there = side[:n], side[n:]
    areas = np.bincount(here, mesh.face_areas + 1e-300, 2 * n)
    is_turned = (here != there) & (
        (areas[here] < areas[there]) | ((areas[here] == areas[there]) & (here > there))
    )
    unsafe = int((is_against & (here == there)[i]).sum())
    if strict and is_turned.any():
        raise MeshError(
            f"{name}: {int(is_turned.sum())} of {n} faces look to the other side than their neighbours; "
            "strict=False turns them"
        )
    if unsafe:
        notes.say(
            f"at {unsafe} edges the two faces look to different sides, in parts that can't be wound alike: "
            "left as they are"
        )
    if not is_turned.any():
        return mesh.faces
    notes.say(f"{int(is_turned.sum())} of {n} faces looked to the other side than their neighbours: turned")
    return np.where(is_turned[:, None], mesh.faces[:, ::-1], mesh.faces)


def _manifold_pairs(mesh: Mesh) -> tuple[IntArray, BoolArray]:
    """Faces at edges of exactly two, and whether both run through it the same way."""
    corners = weld(mesh)[mesh.faces]
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    total = corners.sum(axis=1, dtype=np.int64)
    forward, low, high = start < end, np.minimum(start, end), np.maximum(start, end)
    pairs, is_against = [np.empty((0, 2), np.int32)], [np.empty(0, bool)]
    n_parts = 1 + len(low) // EDGES
    limits = np.linspace(0, mesh.n_vertices, n_parts + 1).astype(np.int64)
    for least, most in itertools.pairwise(limits.tolist()):  # some of the vertices after the other
        mine = np.flatnonzero((low >= least) & (low < most) & (low != high))
        key = low[mine].astype(np.int64) * mesh.n_vertices + high[mine]
        order = np.argsort(key)
        mine, key = mine[order], key[order]
        run = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])[: len(key)])
        run = run[np.diff(np.append(run, len(key))) == 2]
        one, other = mine[run], mine[run + 1]
        keep = total[one // 3] != total[other // 3]  # neither a face itself nor its duplicate
        pairs.append(np.stack([one // 3, other // 3], axis=1)[keep].astype(np.int32))
        is_against.append((forward[one] == forward[other])[keep])
    return np.concatenate(pairs), np.concatenate(is_against)


# --- precision ------------------------------------------------------------------------------------


def lost_precision(scan: Scan, notes: Notes) -> None:
    """Say to what step coordinates far from the origin were rounded, if that is coarse for the surface.

    Parameters
    ----------
    scan : Scan
    notes : Notes
    """
    finite = scan.vertices[scan.is_usable]
    if len(finite) < 4:
        return
    far, extent = np.abs(finite).max(axis=0), np.ptp(finite, axis=0)
    if far.max() < FAR * max(float(extent.max()), 1e-300):
        return
    step = _step(finite, far)
    text = ", ".join(f"{value:.0f}" for value in finite.mean(axis=0))
    if step < 2e-4 * extent.max():
        notes.say(f"coordinates lie far from the origin, about ({text}), as in a map's grid")
        return
    notes.say(
        f"coordinates lie far from the origin, about ({text}), and were rounded to steps of {step:.3g} when "
        "they were written (32-bit floats, or few digits): details below that are lost. Export the scan "
        "again in double precision, or moved near the origin",
        warn=True,
    )


def _step(points: FloatArray, far: FloatArray) -> float:
    """To what positions far from the origin were rounded: of 32-bit floats, or of few decimals."""
    largest = int(far.argmax())
    if np.array_equal(points[:, largest].astype(np.float32), points[:, largest]):
        return float(np.spacing(np.float32(far[largest])))
    sample = points[:: max(1, len(points) // 100_000)]
    for digits in range(-2, 4):
        if np.abs(np.round(sample, digits) - sample).max() < 1e-9 * far.max():
            is_alike = len(np.unique(sample, axis=0)) < 0.9 * len(sample)
            return 10.0**-digits if is_alike else 0.0
    return 0.0
