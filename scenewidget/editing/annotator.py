"""A person who always makes the edit that helps most: how many edits a segmentation is from the truth.

Goes in: a segmentation and the truth. Comes out: the edits of a greedy annotator who merges parts onto
segments and splits parts off, at the levels that the segmentation has, until 1 − RI is below a target. The
count is what a user feels, more than any error. After the simulated annotators of interactive segmentation:
McGuinness and O'Connor (2011), Computer Vision and Image Understanding 115(6).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from scenewidget.editing.edits import Edit, Merge, Split
from scenewidget.editing.session import Session
from scenewidget.engine.kernels import kernel
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.segmentation import Level, Segmentation

__all__ = ["Correction", "simulate_annotator"]


@dataclass(frozen=True, eq=False)
class Correction:
    """What a simulated annotator did.

    Attributes
    ----------
    edits : tuple of Merge and Split
    errors : (n_edits + 1,) float64
        1 − RI by face count before the first edit and after each.
    reached : bool
        Whether the last of them is at most the target.
    segmentation : Segmentation
        After the edits.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from scenewidget.editing import simulate_annotator
    >>> simulate_annotator(seg, seg)
    Correction(0 edits, 1-RI 0.000 to 0.000)
    """

    edits: tuple[Edit, ...]
    errors: FloatArray
    reached: bool
    segmentation: Segmentation

    def __repr__(self) -> str:
        end = "" if self.reached else ", target not reached"
        return f"Correction({len(self.edits)} edits, 1-RI {self.errors[0]:.3f} to {self.errors[-1]:.3f}{end})"


def simulate_annotator(
    segmentation: Segmentation, truth: Segmentation | IntArray, *, target: float = 0.03, most: int = 100
) -> Correction:
    """Correct a segmentation by the edits that lower 1 − RI most, one part at a time.

    Every merge of a part onto a segment and every split is tried at every level, and the best one made,
    as `Session.merge` and `Session.split` would. Brush strokes over several parts, cuts and names are left
    out. Ties go to the coarser level, merges first.

    Parameters
    ----------
    segmentation : Segmentation
        With the levels that parts are taken from; one without them can only be merged.
    truth : Segmentation or (n_faces,) int
        Faces with -1 don't count.
    target : float
        Stop when 1 − RI, over the faces that both label, is at most this.
    most : int
        Stop after so many edits.

    Returns
    -------
    Correction
        ``reached`` is False if ``most`` edits were not enough or no edit helps any more.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from scenewidget.editing import simulate_annotator
    >>> quarters = sw.Segmentation.from_labels(mesh, [0, 0, 1, 1, 2, 2, 3, 3])
    >>> done = simulate_annotator(quarters, seg)
    >>> done
    Correction(2 edits, 1-RI 0.286 to 0.000)
    >>> done.edits
    (Merge(faces=(0,), onto_face=2, level='final'), Merge(faces=(4,), onto_face=6, level='final'))
    """
    actual = np.asarray(truth.labels if isinstance(truth, Segmentation) else truth)
    if actual.dtype.kind not in "iu" or actual.shape != (segmentation.mesh.n_faces,):
        raise ValueError(
            f"truth must have a whole number for each face of the mesh: ({segmentation.mesh.n_faces},), "
            f"got {actual.shape} {actual.dtype}"
        )
    session = Session(segmentation.mesh, segmentation)
    judge = Judge(session, actual)
    errors = [judge.error]
    while errors[-1] > target and len(session.edits) < most:
        edit = judge.best_edit()
        if edit is None:
            break
        session.do(edit)
        judge.look()
        errors.append(judge.error)
    return Correction(
        tuple(session.edits), np.array(errors), bool(errors[-1] <= target), session.segmentation
    )


class Judge:
    """Which edit lowers 1 − RI most, from tables of atoms, segments and truth instead of faces.

    Moving counts p_t (faces of thing t) from segment a to b changes Σ r² by
    (r_a − m)² − r_a² + (r_b + m)² − r_b² with m = Σ p_t, and Σ n² likewise per thing.
    """

    def __init__(self, session: Session, truth: IntArray) -> None:
        atoms, automatic = session.atoms, session.automatic
        keep = truth >= 0
        self.session = session
        self.first_face = atoms.first_face
        # (n_atoms, n_things) faces of each thing
        self.counts = sparse.coo_array(
            (np.ones(int(keep.sum())), (atoms.face_atom[keep].astype(np.int64), truth[keep])),
            shape=(atoms.n, int(truth.max(initial=-1)) + 1),
        ).tocsr()
        self.size = np.asarray(self.counts.sum(axis=1)).ravel()
        self.automatic = automatic.labels[self.first_face]
        self.levels: dict[Level, tuple[IntArray, IntArray, FloatArray, Any]] = {}
        for level in ("base", "dihedral"):
            if level in automatic.levels:
                self.levels[level] = self._parts(automatic.levels[level][self.first_face])
        self.look()

    def _parts(self, part: IntArray) -> tuple[IntArray, IntArray, FloatArray, Any]:
        """Atoms by part, the largest part first: atoms, where each part begins, its faces."""
        inside = np.flatnonzero(part >= 0)
        _, dense = np.unique(part[inside], return_inverse=True)
        size = np.bincount(dense, self.size[inside]).astype(np.float64)
        rank = np.empty(len(size), dtype=np.int64)
        rank[np.argsort(-size, kind="stable")] = np.arange(len(size))
        order = np.argsort(rank[dense], kind="stable")
        start = np.concatenate([[0], np.cumsum(np.bincount(rank[dense]))])
        has_unlabeled = np.zeros(len(size), dtype=bool)
        has_unlabeled[rank[dense[self.automatic[inside] < 0]]] = True
        sizes: FloatArray = -np.sort(-size)
        return inside[order], start, sizes, has_unlabeled

    def look(self) -> None:
        """Take in where the atoms are now."""
        segments = self.session.atom_segments
        ids = np.unique(segments)
        ids = ids[ids >= 0]
        self.segment = np.where(segments >= 0, np.searchsorted(ids, segments), -1)
        self.n = len(ids)
        inside = np.flatnonzero(self.segment >= 0)
        member = sparse.coo_array(
            (np.ones(len(inside)), (self.segment[inside], inside)), shape=(self.n, len(segments))
        )
        self.table = (member.tocsr() @ self.counts).toarray()  # (n_segments, n_things)
        self.onto = np.full(self.n, -1)
        self.onto[self.segment[inside][::-1]] = self.first_face[inside][::-1]
        self.error = self._error()

    def _error(self) -> float:
        total = float(self.table.sum())
        squares = (self.table.sum(axis=1) ** 2).sum() + (self.table.sum(axis=0) ** 2).sum()
        if total < 2:
            return 0.0
        return float((squares - 2 * (self.table**2).sum()) / (total * total - total))

    def best_edit(self) -> Edit | None:
        """The edit with the lowest 1 − RI behind it; None if all leave it or raise it."""
        best, edit = self._best_whole()
        for level, (atoms, start, size, has_unlabeled) in self.levels.items():
            error, part, target = _best_part(
                atoms, start, size, has_unlabeled, self.segment, self.counts.indptr, self.counts.indices,
                self.counts.data, self.table, best,
            )  # fmt: skip
            if part >= 0:
                face = int(self.first_face[atoms[start[part]]])
                best = error
                edit = Split(face, level) if target < 0 else Merge(face, int(self.onto[target]), level)  # type: ignore[arg-type]
        return edit if best < self.error else None

    def _best_whole(self) -> tuple[float, Edit | None]:
        """Merges of two segments, and splits of what was merged before."""
        size = self.table.sum(axis=1)
        total = float(size.sum())
        pairs = total * total - total
        best = self.error * (1 - 1e-12) - 1e-15
        edit: Edit | None = None
        change = 2 * size[:, None] * size[None, :] - 4 * self.table @ self.table.T
        np.fill_diagonal(change, np.inf)
        a, b = np.unravel_index(np.argmin(change), change.shape)
        if self.error + change[a, b] / pairs < best:
            if size[a] > size[b]:
                a, b = b, a
            best = self.error + change[a, b] / pairs
            edit = Merge(int(self.onto[a]), int(self.onto[b]))  # type: ignore[arg-type]  # it makes a tuple
        inside = np.flatnonzero((self.segment >= 0) & (self.automatic >= 0))
        n_automatic = int(self.automatic.max()) + 1
        code, first, group = np.unique(
            self.segment[inside] * n_automatic + self.automatic[inside],
            return_index=True,
            return_inverse=True,
        )
        if len(code) > self.n:  # otherwise nothing has been merged
            member = sparse.coo_array(
                (np.ones(len(inside)), (group, inside)), shape=(len(code), len(self.segment))
            )
            part = (member.tocsr() @ self.counts).toarray()
            m, home = part.sum(axis=1), code // n_automatic
            change = 2 * m * (m - size[home]) - 4 * (part * (part - self.table[home])).sum(axis=1)
            p = int(np.argmin(change))
            if self.error + change[p] / pairs < best:
                best = self.error + change[p] / pairs
                edit = Split(int(self.first_face[inside[first[p]]]), "final")
        return best, edit


@kernel(allocates=True)
def _best_part(atoms, start, size, has_unlabeled, segment, indptr, indices, data, table, best):  # type: ignore[no-untyped-def]
    """Lowest 1 − RI below ``best``, by a part's move to another segment (−1: to a new one).

    Parts come with the largest first; those too small to beat the best are passed over, exactly: the
    change is at most m (2 r + 4 n + 4 m) for a part of m faces, r the largest segment, n the largest cell.
    """
    n, n_things = table.shape
    r, s = np.zeros(n), np.zeros(n_things)
    for a in range(n):
        for t in range(n_things):
            r[a] += table[a, t]
            s[t] += table[a, t]
    total = r.sum()
    now = (r**2).sum() + (s**2).sum() - 2 * (table**2).sum()
    reach = 2 * r.max() + 4 * table.max()
    here = np.zeros((n + 1, n_things))  # faces of the part by segment, the unlabeled ones last
    used_segment, used_thing = np.zeros(n + 1, dtype=np.bool_), np.zeros(n_things, dtype=np.bool_)
    segments, things = np.empty(n + 1, dtype=np.int64), np.empty(n_things, dtype=np.int64)
    mass, every = np.zeros(n + 1), np.zeros(n_things)
    best_part, best_target = -1, -1
    for p in range(len(size)):
        bound = now - size[p] * (reach + 4 * size[p])
        if not has_unlabeled[p] and bound >= best * (total * total - total):
            continue
        n_segments = n_used = 0
        for k in range(start[p], start[p + 1]):
            a = segment[atoms[k]]
            if a < 0:
                a = n
            if not used_segment[a]:
                used_segment[a] = True
                segments[n_segments] = a
                n_segments += 1
            for e in range(indptr[atoms[k]], indptr[atoms[k] + 1]):
                t = indices[e]
                if not used_thing[t]:
                    used_thing[t] = True
                    things[n_used] = t
                    n_used += 1
                here[a, t] += data[e]
                every[t] += data[e]
                mass[a] += data[e]
        # without the part: everything of it taken away
        away, whole = 0.0, 0.0
        for k in range(n_segments):
            a = segments[k]
            whole += mass[a]
            if a < n:
                away += _taken(a, here, mass, r, table, things, n_used)
        fresh, n_fresh = 0.0, mass[n]  # faces that were unlabeled and get counted now
        for k in range(n_used):
            t = things[k]
            fresh += (s[t] + here[n, t]) ** 2 - s[t] ** 2
        pairs = (total + n_fresh) * (total + n_fresh - 1)
        for b in range(-1, n):
            if b >= 0 and used_segment[b]:
                gone, m = away - _taken(b, here, mass, r, table, things, n_used), whole - mass[b]
            else:
                gone, m = away, whole
            if m == 0:
                continue
            rb = r[b] if b >= 0 else 0.0
            change = gone + fresh + m * (2 * rb + m)
            for k in range(n_used):
                t = things[k]
                v = every[t] - here[b, t] if b >= 0 else every[t]
                change -= 2 * v * (2 * (table[b, t] if b >= 0 else 0.0) + v)
            if now + change < best * pairs:
                best, best_part, best_target = (now + change) / pairs, p, b
        for k in range(n_segments):
            a = segments[k]
            used_segment[a] = False
            mass[a] = 0.0
            for j in range(n_used):
                here[a, things[j]] = 0.0
        for k in range(n_used):
            used_thing[things[k]] = False
            every[things[k]] = 0.0
    return best, best_part, best_target


@kernel
def _taken(a, here, mass, r, table, things, n_used):  # type: ignore[no-untyped-def]
    """Change of Σ r² − 2 Σ n² when segment a loses its share of the part."""
    change = mass[a] * (mass[a] - 2 * r[a])
    for k in range(n_used):
        t = things[k]
        change -= 2 * here[a, t] * (here[a, t] - 2 * table[a, t])
    return change
