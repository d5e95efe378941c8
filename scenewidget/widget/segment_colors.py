"""Which colour each segment of a view has, and how it lasts from one edit to the next.

Goes in: segments as tables over atoms, with ids or without. Comes out: a row of the palette for each
segment. With ids, the same id keeps its colour; without, a segment takes that of the earlier one that it
overlaps most. How a colour is chosen at all is the matter of `scenewidget.palette`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse

from scenewidget.engine.atoms import Atoms
from scenewidget.engine.family import Family
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh, face_adjacency
from scenewidget.palette import adjacent_segments, are_distinct, choose_colors, inherited_colors, palette

__all__ = ["N_SPARE", "SegmentColors", "conflicts"]

N_SPARE = 6  # colours for segments that the browser makes before Python knows of them


class SegmentColors:
    """Colours of the segments of one mesh.

    Parameters
    ----------
    mesh : Mesh

    Attributes
    ----------
    atoms : Atoms or None
        What the segments are given over; None before there are any.
    table : (n_atoms,) int
        Segment of each atom, -1 unlabeled.
    rows : (n_segments,) int
        Row of the palette of each segment.
    sizes : (n_segments,) float64
        Number of faces of each segment.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from scenewidget.engine.atoms import common_refinement
    >>> colors, atoms = SegmentColors(mesh), common_refinement([seg.labels], mesh.n_faces)
    >>> colors.update(atoms, seg.labels[atoms.first_face])
    >>> len(colors.rows), len(colors.table_sent)
    (2, 8)
    """

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh
        self.atoms: Atoms | None = None
        self.table: IntArray = np.zeros(0, np.int64)
        self.rows: IntArray = np.zeros(0, np.int64)
        self.sizes: FloatArray = np.zeros(0)
        self._spare: IntArray = np.zeros(0, np.int64)  # rows of the palette for segments to come
        self._row_of_id: dict[int, int] = {}
        self._atom_faces: FloatArray = np.zeros(0)  # number of faces of each atom
        self._touching = sparse.csr_array((0, 0), dtype=bool)  # atoms by atoms

    @property
    def table_sent(self) -> npt.NDArray[np.uint8]:
        """(n_segments + N_SPARE, 3) sRGB of the segments, then of those that the browser may make."""
        return np.asarray(palette()[np.concatenate([self.rows, self._spare])])

    def forget_atoms(self) -> None:
        """There are no segments any more; those that come next inherit nothing by overlap."""
        self.atoms = None

    def update(
        self, atoms: Atoms, table: IntArray, *, ids: IntArray | None = None, keeps_ids: bool = False
    ) -> None:
        """Colour other segments.

        Parameters
        ----------
        atoms : Atoms
            While it stays the same object this costs a few ms.
        table : (n_atoms,) int
        ids : (n_segments,) int, optional
            What stays of each segment over edits.
        keeps_ids : bool
            Whether ids mean what they meant in the last call.
        """
        old_atoms, old_table = self.atoms, self.table
        if atoms is not old_atoms:
            self._stand_on(atoms)
        if not keeps_ids:
            self._row_of_id = {}
        n = int(table.max(initial=-1)) + 1
        self.sizes = np.asarray(np.bincount(table + 1, self._atom_faces, n + 1)[1:], np.float64)
        shares = self.sizes / self._mesh.n_faces
        known, lasting = np.full(n, -1), ids if self._row_of_id else None
        if lasting is not None:
            known = np.array([self._row_of_id.get(i, -1) for i in lasting.tolist()], np.int64)
        elif old_atoms is not None:
            before = old_table[old_atoms.face_atom]
            known = inherited_colors(table[atoms.face_atom], n, before, self.rows)
        pairs = self.segment_pairs(table, known < 0)
        if lasting is not None:
            self._take_spare_rows(known, lasting, pairs)
        self.table, self.rows = table, choose_colors(n, pairs, shares, known)
        if ids is not None:
            self._row_of_id.update(zip(ids.tolist(), self.rows.tolist(), strict=True))
        self._choose_spare_rows(shares)

    def of_items(self, items: Items, item_labels: IntArray) -> IntArray:
        """A row of the palette for each segment over items, as near as can be to what is shown."""
        n = int(item_labels.max(initial=-1)) + 1
        labels = items.to_faces(item_labels, -1)
        shares = np.bincount(labels[labels >= 0], minlength=n) / self._mesh.n_faces
        ends = items.touching(item_labels).labels
        known = None
        if self.atoms is not None:
            of_atoms = labels[self.atoms.first_face]
            known = inherited_colors(of_atoms, n, self.table, self.rows, self._atom_faces)
        return choose_colors(n, np.unique(ends, axis=0), shares, known)

    def of_family(self, family: Family, face_piece: IntArray) -> IntArray:
        """A row of the palette for each piece of a family.

        A segment of a coarser cut has the colour of its largest piece; those of the family's own segmentation
        have the colours that they are shown in now.

        Parameters
        ----------
        family : Family
            Its segmentation knows its items.
        face_piece : (n_faces,) int
            Piece of each face, -1 in none.
        """
        run, items = family.segmentation, family.segmentation.items
        if items is None or run.item_labels is None:
            raise ValueError("the family's segmentation must know its items")
        labels, has_piece = run.item_labels, family.piece >= 0
        home = np.full(family.most, -1)  # segment of each piece
        home[family.piece[has_piece]] = labels[has_piece]
        known = np.full(family.most, -1)
        stands = np.unique(family.groups(run.n_segments))
        known[stands] = self.of_items(items, labels)[home[stands]]
        shares = np.bincount(face_piece[face_piece >= 0], minlength=family.most) / self._mesh.n_faces
        return choose_colors(family.most, conflicts(family, items.pairs), shares, known)

    def segment_pairs(self, table: IntArray, is_wanted: BoolArray) -> IntArray:
        """(n_pairs, 2) some segments, each with those that it touches, out of the atoms that do."""
        if not is_wanted.any():
            return np.zeros((0, 2), np.int64)
        atoms = np.flatnonzero(np.append(is_wanted, False)[table])
        around = self._touching[atoms]
        one, other = np.repeat(table[atoms], np.diff(around.indptr)), table[around.indices]
        is_border = (one != other) & (other >= 0)
        n = len(is_wanted)
        codes = np.unique(one[is_border].astype(np.int64) * n + other[is_border])
        return np.stack(np.divmod(codes, n), axis=1)

    def _stand_on(self, atoms: Atoms) -> None:
        """Know which atoms touch, and their sizes."""
        home = atoms.face_atom.astype(np.int64)
        if self._mesh.is_cloud:
            touching = np.sort(home[face_adjacency(self._mesh)], axis=1)
            pairs = np.unique(touching[touching[:, 0] != touching[:, 1]], axis=0)
        else:
            pairs = adjacent_segments(self._mesh.faces, home, self._mesh.n_vertices)
        ones, (i, j) = np.ones(2 * len(pairs), bool), np.concatenate([pairs, pairs[:, ::-1]]).T
        self._touching = sparse.csr_array((ones, (i, j)), shape=(atoms.n, atoms.n))
        self._atom_faces = np.bincount(atoms.face_atom, minlength=atoms.n).astype(np.float64)
        self.atoms = atoms

    def _take_spare_rows(self, rows: IntArray, ids: IntArray, pairs: IntArray) -> None:
        """Give new segments the colours that the browser has shown them in, where these can be told apart."""
        new = np.flatnonzero(rows < 0)
        for segment in new[np.argsort(ids[new])][: len(self._spare)]:
            row, self._spare = self._spare[0], self._spare[1:]
            around = rows[pairs[pairs[:, 0] == segment, 1]]
            rows[segment] = row if are_distinct(row, around[around >= 0]) else -1

    def _choose_spare_rows(self, shares: FloatArray) -> None:
        n = len(self.rows)
        known = np.concatenate([self.rows, self._spare, np.full(N_SPARE, -1)])[: n + N_SPARE]
        no_pairs, all_shares = np.zeros((0, 2), np.int64), np.append(shares, np.zeros(N_SPARE))
        self._spare = choose_colors(n + N_SPARE, no_pairs, all_shares, known)[n:]


def conflicts(family: Family, pairs: IntArray) -> IntArray:
    """Pieces of a family that stand for touching segments in any of its cuts, (n_pairs, 2).

    Parameters
    ----------
    pairs : (n, 2) int
        Items that touch.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> folded = analytic.folded(analytic.square(8), "x", 0.5, 1.5)
    >>> pipe = sw.Pipeline(folded)
    >>> family = pipe.family(sw.Params(n_runs=2, n_graph_runs=2))
    >>> conflicts(family, family.segmentation.items.pairs).shape[1]
    2
    """
    ends = family.piece[pairs]
    ends = ends[(ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1)]
    touches = np.zeros((family.most, family.most), np.bool_)
    touches[ends[:, 0], ends[:, 1]] = touches[ends[:, 1], ends[:, 0]] = True
    for kept, gone in family.merges:
        touches[kept] |= touches[gone]
        touches[:, kept] = touches[kept]
    return np.argwhere(np.triu(touches, 1))
