"""Dihedral-based partitioning: pieces within which neighbouring faces meet at nearly the same angle.

Goes in: a mesh. Comes out: a partition number per face (thesis 3.1, Algorithm 1). Flat and evenly curved
pieces become one partition each, however many faces they have, so their number tells how much there is
to segment in a component.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from scenewidget.engine.checks import checked_count
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import (
    BoolArray,
    FloatArray,
    IntArray,
    Mesh,
    connected_components,
    face_adjacency,
    neighbor_table,
)
from scenewidget.engine.monitor import SILENT, Monitor
from scenewidget.engine.threads import by_parts

__all__ = ["MAX_RING_FACES", "SlotMapping", "dihedral_partition"]

SlotMapping = Literal["linear", "angle", "counts"]
SLOT_MAPPINGS: tuple[SlotMapping, ...] = ("linear", "angle", "counts")

MAX_RING_FACES = 256  # faces looked at from one seed; scans of 1.1 M faces never needed 64
BORDER = 1e-9  # in slots: a dot product this close to the border of two slots lies in the upper one
CHUNK = 1 << 14  # seeds between two looks at the monitor


def dihedral_partition(
    mesh: Mesh,
    n_slots: int = 64,
    *,
    order: Literal["index", "area"] = "index",
    mapping: SlotMapping = "linear",
    monitor: Monitor | None = None,
) -> IntArray:
    """Partition of the faces by nearly constant dihedral angle (thesis Algorithm 1).

    [−1, 1] is cut into ``n_slots`` slots. From each seed, a face without a label, the dot products of the
    normals of neighbouring faces are counted by slot, ring by ring, until one slot has strictly the most.
    Its interval, widened by half a slot on both sides, is the range of the new partition, which floods
    from the seed over neighbours without a label whose dot product lies in the range, ends included.

    Parameters
    ----------
    mesh : Mesh
        Wound consistently: between faces that are wound against each other the dot product has the
        opposite sign.
    n_slots : int
        D of the thesis.
    order : "index" or "area"
        Order of the seeds. The thesis leaves it open though it matters; "area" (largest face first, then
        by index) makes the partition independent of the order of the faces.
    mapping : "linear", "angle" or "counts"
        How [−1, 1] is cut: into equal intervals of the dot product (the thesis), of the angle between the
        normals, or so that each slot holds as many pairs of neighbours. The thesis wants others than its
        own tried (chapter 5): a slot of 1/32 at 1 spans 14°, at 0 it spans 2°.
    monitor : Monitor, optional

    Returns
    -------
    partition : (n_faces,) int32
        Numbered from 0 in the order of the seeds. Every partition is connected.

    Notes
    -----
    What the printed algorithm leaves open, as decided here:

    - A face enters the rings of a seed once. Every face that is taken out counts the dot products with
      all its neighbours, labeled or not, so a pair within the rings counts from both sides.
    - The counts start anew with each seed and go on from ring to ring.
    - A flood takes no face from an earlier partition.
    - 1.0 lies in the last slot. A dot product within 1e-9 slots of a border counts for the upper slot and
      as inside a range that ends there, so rounding does not tear flat or right-angled meshes apart.
    - If no slot is decisive when the whole component has been seen, the seed is a partition of its own.
      So it is if ties last beyond the ring in which 256 faces have been reached: without that bound, an
      accordion of n equal folds would cost n² steps.
    - A connected patch of faces without area takes the area-weighted mean normal of the faces around it.
    - Neighbours are those of `face_adjacency`.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.engine.dihedral import dihedral_partition
    >>> corner = sw.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1]],
    ...                  [[0, 1, 3], [0, 3, 2], [0, 5, 1], [0, 4, 5]])
    >>> dihedral_partition(corner)
    array([0, 0, 1, 1], dtype=int32)
    """
    n_slots = checked_count("n_slots", n_slots, most=1_000_000)
    if order not in ("index", "area"):
        raise ValueError(f'order must be "index" or "area", got {order!r}')
    if mapping not in SLOT_MAPPINGS:
        raise ValueError(f"mapping must be one of {', '.join(map(repr, SLOT_MAPPINGS))}, got {mapping!r}")
    monitor = monitor or SILENT
    n = mesh.n_faces
    pairs = face_adjacency(mesh)
    monitor.tick(0.0)
    normals = _normals_everywhere(mesh, pairs)
    indptr, indices = neighbor_table(n, pairs)
    faces = np.repeat(np.arange(n, dtype=np.int32), np.diff(indptr))
    dots = np.empty(len(indices))

    def dots_of(rows: slice) -> None:
        one, other = (np.take(normals, side[rows], axis=0) for side in (faces, indices))
        np.einsum("ij,ij->i", one, other, out=dots[rows])

    by_parts(dots_of, len(indices))
    neighbours = indptr, indices, _place_in_slots(np.clip(dots, -1.0, 1.0), n_slots, mapping)
    seeds = np.arange(n) if order == "index" else np.argsort(-mesh.face_areas, kind="stable")

    partition = np.full(n, -1, dtype=np.int32)
    scratch = np.full(n, -1, dtype=np.int32), np.full(n, 0, dtype=np.int32), np.zeros((2, n_slots), np.int64)
    n_partitions = 0
    for start in range(0, n, CHUNK):
        monitor.tick(start / n)
        n_partitions = _partition_from(
            seeds[start : start + CHUNK], *neighbours, partition, n_partitions, *scratch
        )
    return partition


def _place_in_slots(dots: FloatArray, n_slots: int, mapping: SlotMapping) -> FloatArray:
    """Where each dot product lies among the slots, 0 at −1 and ``n_slots`` at 1; equal ones at one place."""
    if mapping == "angle":
        return np.asarray(n_slots * (1.0 - np.arccos(dots) / np.pi))
    linear: FloatArray = 0.5 * n_slots * (dots + 1.0)
    if mapping == "linear":
        return linear
    _, inverse, count = np.unique(np.rint(linear / BORDER), return_inverse=True, return_counts=True)
    middle = np.cumsum(count) - 0.5 * count  # mean rank of those that are equal
    return np.asarray(n_slots * (middle / max(1, len(dots)))[inverse])


def _normals_everywhere(mesh: Mesh, pairs: IntArray) -> FloatArray:
    """Face normals, those of patches without area taken from around them; zero where nothing is around."""
    has_area: BoolArray = mesh.face_areas > 0
    if has_area.all():
        return mesh.face_normals
    is_sound = has_area[pairs]
    _, patch = connected_components(mesh.n_faces, pairs[~is_sound.any(axis=1)])
    rim = pairs[is_sound[:, 0] != is_sound[:, 1]]
    rim = np.where(has_area[rim[:, :1]], rim, rim[:, ::-1])  # a face with area, a face without
    sums = np.zeros((mesh.n_faces, 3))
    np.add.at(sums, patch[rim[:, 1]], mesh.face_vectors[rim[:, 0]])
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    around: FloatArray = np.divide(sums, length, out=np.zeros_like(sums), where=length > 0)
    return np.where(has_area[:, None], mesh.face_normals, around[patch])


@kernel
def _partition_from(  # type: ignore[no-untyped-def]
    seeds, indptr, indices, place, partition, n_partitions, seen_from, queue, slots
):
    """Algorithm 1 from these seeds on; writes ``partition``, returns the number of partitions so far.

    ``seen_from[f]`` is the seed whose rings f entered last; ``slots`` holds counts and the seed that they are
    of: nothing needs clearing between seeds. One queue serves the rings, then the flood.
    """
    n_slots = slots.shape[1]
    for at in range(len(seeds)):
        seed = seeds[at]
        if partition[seed] >= 0:
            continue
        partition[seed] = n_partitions

        # Rings: queue[ring_start:ring_end] is the current one, what follows the next.
        queue[0], ring_start, ring_end, end = seed, 0, 1, 1
        seen_from[seed] = seed
        most, n_most, best = 0, 0, 0
        while ring_start < ring_end and n_most != 1:
            for i in range(ring_start, ring_end):
                face = queue[i]
                for e in range(indptr[face], indptr[face + 1]):
                    slot = int(place[e] + BORDER)
                    if slot >= n_slots:
                        slot = n_slots - 1
                    if slots[1, slot] != seed + 1:
                        slots[1, slot] = seed + 1
                        slots[0, slot] = 0
                    slots[0, slot] += 1
                    if slots[0, slot] > most:
                        most, n_most, best = slots[0, slot], 1, slot
                    elif slots[0, slot] == most:
                        n_most += 1
                    other = indices[e]
                    if seen_from[other] != seed:
                        seen_from[other] = seed
                        queue[end] = other
                        end += 1
            if end > MAX_RING_FACES:
                break
            ring_start, ring_end = ring_end, end

        if n_most == 1:
            low, high = best - 0.5 - BORDER, best + 1.5 + BORDER
            queue[0], start, end = seed, 0, 1
            while start < end:
                face = queue[start]
                start += 1
                for e in range(indptr[face], indptr[face + 1]):
                    other = indices[e]
                    if partition[other] < 0 and low <= place[e] <= high:
                        partition[other] = n_partitions
                        queue[end] = other
                        end += 1
        n_partitions += 1
    return n_partitions
