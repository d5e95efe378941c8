"""Which mesh something belongs to, without the mesh: a hash of its geometry, counts and bounds."""

from __future__ import annotations

import hashlib
import weakref
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from scenewidget.engine.mesh import FloatArray, Mesh

__all__ = ["Fingerprint", "fingerprint", "is_sketch_of", "living_mesh", "sketch"]

SUMS = 8  # in a sketch
CHUNK = 1 << 20  # faces at a time
ROUNDED = 1e-5  # of the size of a scan: what a file with five or six digits takes from a coordinate
SINGLE = 2.0**-24  # of a coordinate: what a file with single precision takes from it

_known: weakref.WeakKeyDictionary[Mesh, Fingerprint] = weakref.WeakKeyDictionary()


@dataclass(frozen=True)
class Fingerprint:
    """What tells one mesh from another; colours don't count.

    Attributes
    ----------
    n_vertices, n_faces : int
    digest : str
        Of positions and triangles, hexadecimal.
    low, high : (3,) float
        Corners of the bounding box, metres.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> str(fingerprint(mesh))[:38]
    '8 faces, 9 vertices, 1.00 × 1.00 × 0.0'
    """

    n_vertices: int
    n_faces: int
    digest: str  # blake2b over positions and faces, hexadecimal
    low: tuple[float, ...]  # corner of the bounding box, metres
    high: tuple[float, ...]

    def __str__(self) -> str:
        size = " × ".join(f"{b - a:.2f}" for a, b in zip(self.low, self.high, strict=True))
        return f"{self.n_faces} faces, {self.n_vertices} vertices, {size} m, fingerprint {self.digest[:8]}"

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Any) -> Fingerprint:
        """The fingerprint behind plain data; ValueError if it is none."""
        if not isinstance(data, Mapping):
            raise ValueError("a fingerprint must be a mapping")
        counts = [data.get("n_vertices"), data.get("n_faces")]
        corners = [data.get("low"), data.get("high")]
        digest = data.get("digest")
        if not all(type(count) is int and 0 < count < 2**31 for count in counts) or not isinstance(
            digest, str
        ):
            raise ValueError("a fingerprint must hold counts and a digest")
        if not all(
            isinstance(corner, list) and len(corner) == 3 and all(isinstance(x, (int, float)) for x in corner)
            for corner in corners
        ):
            raise ValueError("a fingerprint must hold the corners of the bounding box")
        low, high = (tuple(float(x) for x in corner or ()) for corner in corners)
        return cls(int(counts[0] or 0), int(counts[1] or 0), digest, low, high)


def fingerprint(mesh: Mesh) -> Fingerprint:
    """The fingerprint of a mesh, 0.1 s at 1.5 million faces the first time, then remembered.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> fingerprint(mesh) == fingerprint(analytic.square(2))
    True
    >>> fingerprint(mesh) == fingerprint(analytic.square(3))
    False
    """
    found = _known.get(mesh)
    if found is None:
        digest = hashlib.blake2b(digest_size=16)
        digest.update(f"{mesh.n_vertices} {mesh.n_faces} ".encode())
        digest.update((mesh.vertices + 0.0).astype("<f8", copy=False).tobytes())  # −0.0 is 0.0
        digest.update(mesh.faces.astype("<i4", copy=False).tobytes())
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        found = Fingerprint(
            mesh.n_vertices, mesh.n_faces, digest.hexdigest(), tuple(low.tolist()), tuple(high.tolist())
        )
        _known[mesh] = found
    return found


def living_mesh(wanted: Fingerprint) -> Mesh | None:
    """A mesh with this fingerprint that somebody in this process still holds, if any.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> living_mesh(fingerprint(mesh)) is mesh
    True
    """
    return next((mesh for mesh, found in list(_known.items()) if found == wanted), None)


def sketch(mesh: Mesh) -> FloatArray:
    """A mesh in a few numbers that hardly change when another program saves it with fewer digits.

    Sums of the centroids of all faces, each with a sign that its number decides by chance: whoever rounds the
    corners, or splits or welds them, changes little; whoever orders the faces in another way changes all.

    Returns
    -------
    sums : (8, 3) float64, metres

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> sketch(analytic.square(2)).shape
    (8, 3)
    """
    sums = np.zeros((SUMS, 3))
    for start in range(0, mesh.n_faces, CHUNK):
        stop = min(start + CHUNK, mesh.n_faces)
        lots = np.arange(start, stop, dtype=np.uint64) + np.uint64(1)
        for factor in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9):  # of Steele, Lea and Flood (2014), SplitMix
            lots = lots * np.uint64(factor)
            lots ^= lots >> np.uint64(31)
        signs = np.where(lots[None, :] >> np.arange(SUMS, dtype=np.uint64)[:, None] & np.uint64(1), 1.0, -1.0)
        sums += signs @ mesh.face_centroids[start:stop]
    return sums


def is_sketch_of(sums: FloatArray, mesh: Mesh) -> bool:
    """Whether a sketch is of a mesh, or of one that differs from it by rounding only.

    Parameters
    ----------
    sums : (8, 3) float
        Of `sketch`.
    mesh : Mesh

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)
    >>> rounded = sw.Mesh(mesh.vertices.astype("float32") + 1e-7, mesh.faces)
    >>> turned = sw.Mesh(mesh.vertices, mesh.faces[::-1])
    >>> is_sketch_of(sketch(mesh), rounded), is_sketch_of(sketch(mesh), turned)
    (True, False)
    """
    size = float(np.ptp(mesh.vertices, axis=0).max(initial=0.0))
    rounding = ROUNDED * size + SINGLE * float(np.abs(mesh.vertices).max(initial=0.0))
    most = 6 * np.sqrt(mesh.n_faces) * rounding  # six standard deviations of a sum of roundings
    return sums.shape == (SUMS, 3) and bool((np.abs(sums - sketch(mesh)) <= most).all())
