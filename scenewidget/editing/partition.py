"""Where every face is right now: a segment per atom, and what each edit does to it.

Goes in: the automatic segmentation and edits, one at a time. Come out: changes that can be taken back, and
the corrected `Segmentation`. Atoms are the common refinement of all levels, so an edit touches a table of
some ten thousand entries, whatever the number of faces; labels per face are made when somebody asks.
"""

from __future__ import annotations

import dataclasses
import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.editing.borders import grown, holes, shrunk, smoothed
from scenewidget.editing.cut import cut_segment
from scenewidget.editing.edits import (
    Cut,
    Edit,
    EditError,
    FillHoles,
    Group,
    Grow,
    Merge,
    Paint,
    Relabel,
    Shrink,
    Slice,
    SmoothBorder,
    Split,
)
from scenewidget.engine.atoms import common_refinement
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, face_adjacency
from scenewidget.engine.segmentation import LEVELS, Level, Segmentation, dense_groups

__all__ = ["Change", "FaceEdit", "KnownCut", "Numbering", "Partition"]

FaceEdit = Paint | Slice | Grow | Shrink | FillHoles | SmoothBorder

# A mesh has so many quanta of area, and each face a whole number of them: float64 adds whole numbers exactly.
AREA_QUANTA = 2.0**50


@dataclass(frozen=True, eq=False)
class Change:
    """What an edit did, enough to take it back.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from scenewidget.editing import Merge
    >>> Partition(seg).apply(Merge(0, onto_face=7)).n_faces
    4
    """

    atoms: IntArray  # whose segment changed
    before: IntArray  # their segments
    names: dict[int, str]  # all names before
    groups: dict[int, int]  # all parts before
    n_atoms: int  # atoms that there were
    next_id: int
    n_faces: int  # that moved
    cut: KnownCut | None = None


@dataclass(frozen=True, eq=False)
class KnownCut:
    """The outcome of a cut, so that it need not be computed again.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> _, cut = Partition(seg).divide(Cut(0, 3))
    >>> cut.is_b
    array([False, False,  True,  True])
    """

    segment_digest: bytes  # of the faces of the segment that was cut
    is_b: BoolArray  # (n_faces of the segment,) on the side of face_b


@dataclass(frozen=True, eq=False)
class Numbering:
    """Segments as a `Segmentation` numbers them, without labels per face.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> Partition(seg).numbering().names
    ('', '')
    """

    labels: npt.NDArray[np.int32]  # (n_atoms,) dense, 0 the largest by area, -1 unlabeled
    ids: IntArray  # (n_segments,) what stays of each segment over edits
    names: tuple[str, ...]  # "" where a segment has none
    groups: tuple[int, ...]  # the segment that each is a part of, itself where of none
    confidence: FloatArray  # (n_segments,) mean over the area, 1 where a person decided
    atom_confidence: FloatArray  # (n_atoms,) likewise


class Partition:
    """Segments over atoms, changed by edits.

    Segments have ids that stay while they live: those of the automatic segmentation at first, new numbers
    for new segments. They are not the labels of `segmentation`, which are numbered anew by area.

    Parameters
    ----------
    automatic : Segmentation
        What the edits start from.
    known_cuts : dict, optional
        Outcomes of cuts computed before; used where the same segment is cut by the same faces.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> partition = Partition(seg)
    >>> change = partition.apply(Cut(0, 3))
    >>> partition.segmentation().labels
    array([1, 1, 2, 2, 0, 0, 0, 0], dtype=int32)
    >>> partition.revert(change)
    >>> partition.segmentation() is seg
    True
    """

    def __init__(
        self, automatic: Segmentation, known_cuts: dict[tuple[Cut, bytes], BoolArray] | None = None
    ) -> None:
        self.automatic = automatic
        self.known_cuts = {} if known_cuts is None else known_cuts
        columns = {level: automatic.level(level) for level in LEVELS if level in (*automatic.levels, "final")}
        self.atoms = common_refinement(columns.values(), automatic.mesh.n_faces)
        self.parts: dict[str, IntArray] = {
            level: column[self.atoms.first_face] for level, column in columns.items()
        }
        self.segment: IntArray = self.parts["final"].astype(np.int32)
        self.names: dict[int, str] = {i: name for i, name in enumerate(automatic.names) if name}
        self.groups: dict[int, int] = {i: whole for i, whole in enumerate(automatic.groups) if whole != i}
        self._first = self.names, self.groups
        self._next_id = automatic.n_segments
        self._parent: IntArray = np.arange(self.atoms.n)
        self._divided: tuple[tuple[Cut, bytes], BoolArray] | None = None  # last, so that a preview is kept
        self._totals: FloatArray | None = None  # what `_tally` says of all atoms

    def segment_at(self, face: int) -> int:
        """Id of the segment under a face, -1 if it is unlabeled.

        Raises
        ------
        ValueError
            No such face.
        """
        return int(self.segment[self._atom(face)])

    def part(self, face: int, level: Level, *, action: str = "merge") -> BoolArray:
        """(n_atoms,) the atoms that an edit at a face would move.

        Raises
        ------
        EditError
            The face belongs to no part of the level.
        """
        atom = self._atom(face)
        home = int(self.segment[atom])
        if level == "final":
            if home < 0:
                raise EditError(f"face {face} is unlabeled: it belongs to no segment")
            inside: BoolArray = self.segment == home
            if action == "split":
                inside &= self.parts["final"] == self.parts["final"][atom]
            return inside
        column = self._column(level)
        if column[atom] < 0:
            raise EditError(f"face {face} belongs to no part of the level {level!r}")
        return np.asarray(column == column[atom])

    def _column(self, level: Level) -> IntArray:
        """(n_atoms,) part of each atom that a merge moves whole."""
        if level == "final":
            return self.segment
        if level not in self.parts:
            self.automatic.level(level)  # says what is wrong
        return self.parts[level]

    def apply(self, edit: Edit) -> Change:
        """Do an edit.

        Raises
        ------
        EditError
            It can't be done here or changes nothing; nothing has happened.
        """
        if isinstance(edit, Merge):
            return self._merge(edit)
        if isinstance(edit, Split):
            return self._split(edit)
        if isinstance(edit, Relabel):
            return self._relabel(edit)
        if isinstance(edit, Group):
            return self._group(edit)
        if isinstance(edit, Cut):
            return self._cut(edit)
        faces, takers = self.destined(edit)
        return self._carry(faces, takers)

    def revert(self, change: Change) -> None:
        """Take the last change back that wasn't taken back yet."""
        if change.n_atoms == self.atoms.n:
            self._put(change.atoms, change.before)
        else:  # another edit has made the atoms finer since
            before = np.full(change.n_atoms, -2, dtype=np.int32)
            before[change.atoms] = change.before
            before = before[self._ancestors(change.n_atoms)]
            self.segment = np.where(before == -2, self.segment, before)
            self._totals = None
        self.names, self.groups = change.names, change.groups
        self._next_id = change.next_id
        if self._totals is not None:
            self._totals = self._totals[:, : self._next_id + 1]

    # --- the edits --------------------------------------------------------------------------------

    def _merge(self, edit: Merge) -> Change:
        target = self.segment_at(edit.onto_face)
        if target < 0:
            raise EditError(f"onto_face {edit.onto_face} is unlabeled: there is no segment to join")
        self._atom(max(edit.faces))  # says so where there is no such face
        atoms = self.atoms.face_atom[np.array(edit.faces)]
        column = self._column(edit.level)
        if (column[atoms] < 0).all():
            self.part(edit.faces[0], edit.level)  # says what is wrong
        parts = np.unique(column[atoms])
        parts = parts[parts >= 0]
        moves = np.flatnonzero(
            column == parts[0] if len(parts) == 1 else np.isin(column, parts, kind="table")
        )
        moves = moves[self.segment[moves] != target]
        if len(moves) == 0:
            which = f"face {edit.faces[0]}" if len(edit.faces) == 1 else "all faces"
            raise EditError(f"{which} and onto_face {edit.onto_face} are in one segment already")
        return self._move(moves, target)

    def _split(self, edit: Split) -> Change:
        inside = self.part(edit.face, edit.level, action="split")
        if edit.also:
            for face in edit.also:
                inside |= self.part(face, edit.level, action="split")
            inside &= self.segment == self.segment_at(edit.face)
        moves = np.flatnonzero(inside)
        sources = np.unique(self.segment[moves])
        if (
            len(sources) == 1
            and sources[0] >= 0
            and len(moves) == np.count_nonzero(self.segment == sources[0])
        ):
            finer = "a finer level or a cut" if edit.level != "dihedral" else "a cut"
            raise EditError(
                f"the part under face {edit.face} is a segment of its own already; {finer} can divide it"
            )
        return self._move(moves, self._next_id)

    def _relabel(self, edit: Relabel) -> Change:
        home = self.segment_at(edit.face)
        if home < 0:
            raise EditError(f"face {edit.face} is unlabeled: there is no segment to name")
        if self.names.get(home, "") == edit.name:
            has = f"is called {edit.name!r} already" if edit.name else "has no name"
            raise EditError(f"the segment under face {edit.face} {has}")
        change = self._change(np.empty(0, dtype=np.int64))
        self.names = {**self.names, home: edit.name}
        if not edit.name:
            del self.names[home]
        return change

    def _group(self, edit: Group) -> Change:
        self._atom(max(edit.faces))  # says so where there is no such face
        named = set(self.segment[self.atoms.face_atom[np.array(edit.faces)]].tolist()) - {-1}
        if not named:
            raise EditError(f"face {edit.faces[0]} is unlabeled: there is no segment to group")
        parts = named | {part for part, whole in self.groups.items() if whole in named}
        if edit.onto_face is None:
            after = {part: whole for part, whole in self.groups.items() if part not in parts}
        else:
            target = self.segment_at(edit.onto_face)
            if target < 0:
                raise EditError(f"onto_face {edit.onto_face} is unlabeled: there is no segment to be part of")
            whole = self.groups.get(target, target)
            if whole in named and whole != target:  # what was a part is the whole now
                whole = target
            after = self.groups | dict.fromkeys(parts, whole)
            after.pop(whole, None)
        if after == self.groups:
            is_so = "is part of nothing" if edit.onto_face is None else "is so already"
            raise EditError(f"face {edit.faces[0]}: its segment {is_so}")
        change = self._change(np.empty(0, dtype=np.int64))
        self.groups = after
        return change

    def divide(self, edit: Cut) -> tuple[IntArray, KnownCut]:
        """Faces of the segment that a cut would divide, ascending, and which of them it would divide off.

        Raises
        ------
        EditError
            It can't be done here.
        """
        home = self.segment_at(edit.face_a)
        if home < 0:
            raise EditError(f"face_a {edit.face_a} is unlabeled: there is no segment to cut")
        if self.segment_at(edit.face_b) != home:
            raise EditError(
                f"face_a {edit.face_a} and face_b {edit.face_b} are in different segments; "
                "a cut divides the segment that both are in"
            )
        faces = np.flatnonzero((self.segment == home)[self.atoms.face_atom])
        digest = hashlib.blake2b(faces.astype("<i4").tobytes(), digest_size=16).digest()
        key = edit, digest
        is_b = self.known_cuts.get(key)
        if is_b is None and self._divided is not None and self._divided[0] == key:
            is_b = self._divided[1]
        if is_b is None or len(is_b) != len(faces) or not is_b.any() or is_b.all():
            is_b = cut_segment(self.automatic.mesh, faces, edit.face_a, edit.face_b)
        self._divided = key, is_b
        return faces, KnownCut(digest, is_b)

    def _cut(self, edit: Cut) -> Change:
        faces, cut = self.divide(edit)
        self.known_cuts[edit, cut.segment_digest] = is_b = cut.is_b
        return dataclasses.replace(self._carry(faces[is_b], self._next_id), cut=cut)

    def destined(self, edit: FaceEdit) -> tuple[IntArray, IntArray | int]:
        """Faces that an edit moves, ascending, and the segment that takes each; a new one has the next id.

        Raises
        ------
        EditError
            It can't be done here, or nothing would move.
        """
        if isinstance(edit, Paint):
            return self._painted(edit)
        home = self.segment_at(edit.face)
        if home < 0:
            raise EditError(f"face {edit.face} is unlabeled: there is no segment to {edit.title.lower()}")
        segment: IntArray = self.segment[self.atoms.face_atom]
        if isinstance(edit, Slice):
            return self._sliced(edit, np.flatnonzero(segment == home)), self._next_id
        faces: IntArray
        takers: IntArray | int = home
        if isinstance(edit, Grow):
            faces = grown(self._pairs, segment, home, edit.rings)
        elif isinstance(edit, FillHoles):
            faces = holes(self._pairs, segment, home, edit.max_faces)
        elif isinstance(edit, Shrink):
            faces, takers = shrunk(self._pairs, segment, home, edit.rings)
        else:
            faces, takers = smoothed(self._pairs, segment, home, edit.rounds)
        if len(faces) == 0:
            raise EditError(f"the segment under face {edit.face} {edit.nothing}")
        segment[faces] = takers
        if not (segment == home).any():
            raise EditError(f"nothing would remain of the segment under face {edit.face}")
        return faces, takers

    def _painted(self, edit: Paint) -> tuple[IntArray, int]:
        faces = edit.faces.of_mesh(self.automatic.mesh.n_faces)
        home = self.segment[self.atoms.face_atom[faces]]
        if edit.onto_face is None:
            source = int(home[0])
            if source >= 0 and (home == source).all():
                n_source = int(self.atom_faces[self.segment == source].sum())
                if len(faces) == n_source:
                    raise EditError("the faces are a segment of their own already")
            return faces, self._next_id
        target = self.segment_at(edit.onto_face)
        if target < 0:
            raise EditError(f"onto_face {edit.onto_face} is unlabeled: there is no segment to paint onto")
        faces = faces[home != target]
        if len(faces) == 0:
            raise EditError(f"all faces are in the segment under onto_face {edit.onto_face} already")
        return faces, target

    def _sliced(self, edit: Slice, faces: IntArray) -> IntArray:
        """Those faces of the segment that lie on the other side of the plane than the face that is named."""
        x, y, z = (self.automatic.mesh.face_centroids[faces] - edit.point).T
        length = max(abs(part) for part in edit.normal)
        a, b, c = (part / length for part in edit.normal)
        is_above = x * a + y * b + z * c > 0  # term by term: to the bit the same on every machine
        other: IntArray = faces[is_above != is_above[np.searchsorted(faces, edit.face)]]
        if len(other) == 0:
            raise EditError(f"the plane leaves the segment under face {edit.face} on one side")
        return other

    @cached_property
    def _pairs(self) -> IntArray:
        """(n_pairs, 2) faces that share an edge."""
        return face_adjacency(self.automatic.mesh)

    def _carry(self, faces: IntArray, takers: IntArray | int) -> Change:
        """Put faces, ascending, into segments; atoms that are only partly among them become finer."""
        if isinstance(takers, int):
            self._refine(faces, np.zeros(len(faces), np.int64))
            moves = np.flatnonzero(np.bincount(self.atoms.face_atom[faces], minlength=self.atoms.n))
            return self._move(moves, takers)
        _, group = np.unique(takers, return_inverse=True)
        self._refine(faces, group)
        target = np.full(self.atoms.n, -1, dtype=np.int64)
        target[self.atoms.face_atom[faces]] = takers
        moves = np.flatnonzero(target >= 0)
        return self._move(moves, target[moves])

    def _move(self, moves: IntArray, target: IntArray | int) -> Change:
        """Put atoms into segments; a name is not lost with the last of its faces."""
        change = self._change(moves)
        self._next_id = max(self._next_id, int(np.max(target)) + 1)
        self._put(moves, target)
        sources = np.flatnonzero(np.bincount(change.before + 1)) - 1
        gone = [s for s in sources.tolist() if s >= 0 and not (self.segment == s).any()]
        self.names = {i: name for i, name in self.names.items() if i not in gone}
        for source in gone:
            heir = int(self.segment[moves[change.before == source][0]])
            if source in change.names and heir not in self.names:
                self.names[heir] = change.names[source]
            self._inherit(source, heir)
        return change

    def _inherit(self, gone: int, heir: int) -> None:
        """The parts of a segment that is gone are parts of what has taken it."""
        if gone not in self.groups and gone not in self.groups.values():
            return
        whole = self.groups.get(heir, heir)
        whole = heir if whole == gone else whole
        kept = {p: whole if w == gone else w for p, w in self.groups.items() if p != gone}
        kept.pop(whole, None)
        self.groups = kept

    def _put(self, atoms: IntArray, segments: IntArray | int) -> None:
        """Put atoms into segments, and keep the totals right: that costs what moves, not what there is."""
        if self._totals is None:
            self.segment[atoms] = segments
            return
        before = self._tally(atoms)
        self.segment[atoms] = segments
        totals = self._tally(atoms) - before  # wider than before if a segment is new
        totals[:, : self._totals.shape[1]] += self._totals
        self._totals = totals

    def _tally(self, atoms: IntArray | slice) -> FloatArray:
        """(3, 1 + n_ids) number, area and sureness of some atoms by segment, unlabeled ones first.

        Whole numbers, so that nothing is lost in adding and subtracting.
        """
        segment, area = self.segment[atoms], self._area[atoms]
        sureness = np.where(segment != self.parts["final"][atoms], area, self._sureness[atoms])
        return np.stack([_sums(segment + 1, of, self._next_id + 1) for of in (None, area, sureness)])

    def _change(self, atoms: IntArray) -> Change:
        n_faces = int(self.atom_faces[atoms].sum())
        return Change(
            atoms, self.segment[atoms], self.names, self.groups, self.atoms.n, self._next_id, n_faces
        )

    def _refine(self, faces: IntArray, group: IntArray) -> None:
        """Make atoms finer, so that groups of faces can move; costs what the groups have."""
        n_before = self.atoms.n
        tables = {"atom_faces": self.atom_faces, "_area": self._area, "_sureness": self._sureness}
        self.atoms, parents = self.atoms.refined(faces, group, self.atom_faces)
        if len(parents) == 0:
            return
        atom = self.atoms.face_atom[faces].astype(np.int64) - n_before
        faces, atom = faces[atom >= 0], atom[atom >= 0]
        quanta = self._face_quanta[faces]
        sureness = np.rint(quanta * self.automatic.confidence[faces])
        for (name, table), weights in zip(tables.items(), (None, quanta, sureness), strict=True):
            taken = np.bincount(atom, weights, minlength=len(parents)).astype(table.dtype)
            self.__dict__[name] = finer = np.concatenate([table, taken])
            np.subtract.at(finer, parents, taken)
        self._parent = np.concatenate([self._parent, parents])
        self.segment = np.concatenate([self.segment, self.segment[parents]])
        self.parts = {level: np.concatenate([part, part[parents]]) for level, part in self.parts.items()}
        self._totals = None
        for outdated in ("_confidence", "_pieces"):
            self.__dict__.pop(outdated, None)

    def _ancestors(self, n_atoms: int) -> IntArray:
        """For each atom of today the one that it was part of when there were so many."""
        out = np.arange(self.atoms.n)
        while (late := out >= n_atoms).any():
            out = np.where(late, self._parent[out], out)
        return out

    @cached_property
    def atom_faces(self) -> IntArray:
        """(n_atoms,) number of faces of each atom."""
        return np.bincount(self.atoms.face_atom, minlength=self.atoms.n)

    @cached_property
    def _area(self) -> FloatArray:
        """(n_atoms,) area as whole numbers of quanta: sums are the same in whatever order they are made."""
        return _sums(self.atoms.face_atom, self._face_quanta, self.atoms.n)

    @cached_property
    def _face_quanta(self) -> FloatArray:
        areas = self.automatic.mesh.face_areas
        return np.asarray(np.rint(areas * (AREA_QUANTA / max(float(areas.sum()), 1e-300))))

    @cached_property
    def _sureness(self) -> FloatArray:
        """(n_atoms,) sum of the automatic confidence times the area, in whole quanta."""
        weights = np.rint(self._face_quanta * self.automatic.confidence)
        return _sums(self.atoms.face_atom, weights, self.atoms.n)

    @cached_property
    def _confidence(self) -> FloatArray:
        """(n_atoms,) mean of the automatic confidence over the area, 0 where there is none."""
        return np.divide(self._sureness, self._area, out=np.zeros(self.atoms.n), where=self._area > 0)

    @cached_property
    def _pieces(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Where items and atoms overlap: item, atom and area of each piece."""
        face_map = self.automatic.face_map
        if face_map is None:
            return np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0)
        keep = face_map >= 0
        code = face_map[keep].astype(np.int64) * self.atoms.n + self.atoms.face_atom[keep]
        codes, index = np.unique(code, return_inverse=True)
        # degenerate faces weigh next to nothing, but something
        area = _sums(index, np.maximum(self.automatic.mesh.face_areas[keep], 1e-30), len(codes))
        item, atom = np.divmod(codes, self.atoms.n)
        return item, atom, area

    def _atom(self, face: int) -> int:
        if not face < self.automatic.mesh.n_faces:
            raise ValueError(
                f"there is no face {face}: the mesh has {self.automatic.mesh.n_faces} faces, numbered from 0"
            )
        return int(self.atoms.face_atom[face])

    # --- the answer -------------------------------------------------------------------------------

    def numbering(self) -> Numbering:
        """How `segmentation` numbers and names the segments now; about 1 ms, whatever the faces."""
        labels, ids = self._dense()
        _, area, sureness = self._added_up()[:, ids + 1]
        confidence = np.divide(sureness, area, out=sureness, where=area > 0)
        by_atom = np.where(self._is_moved & (self._area > 0), 1.0, self._confidence)
        names = tuple(self.names.get(i, "") for i in ids.tolist())
        return Numbering(labels, ids, names, self._dense_groups(ids), confidence, by_atom)

    def _dense_groups(self, ids: IntArray) -> tuple[int, ...]:
        return dense_groups(ids, np.array([self.groups.get(i, i) for i in ids.tolist()], np.int64))

    def _added_up(self) -> FloatArray:
        """`_tally` of all atoms."""
        if self._totals is None:
            self._totals = self._tally(slice(None))
        return self._totals

    def segmentation(self) -> Segmentation:
        """The segmentation as it is now, labels dense and 0 the largest by area.

        Faces that an edit moved have confidence 1: a person decided. Where nothing differs from the
        automatic segmentation, that one itself.
        """
        if self._is_automatic:
            return self.automatic
        automatic, atoms = self.automatic, self.atoms
        dense, ids = self._dense()
        labels = dense[atoms.face_atom]
        labels.flags.writeable = False
        confidence: Any = np.where(self._is_moved[atoms.face_atom], np.float32(1), automatic.confidence)
        confidence.flags.writeable = False
        return dataclasses.replace(
            automatic,
            labels=labels,
            confidence=confidence,
            names=[self.names.get(i, "") for i in ids.tolist()],
            groups=self._dense_groups(ids),
            item_labels=None if automatic.face_map is None else self._item_labels(dense),
        )

    @property
    def _is_moved(self) -> BoolArray:
        """(n_atoms,) whether an edit has put the atom elsewhere."""
        return np.asarray(self.segment != self.parts["final"])

    @property
    def _is_automatic(self) -> bool:
        return not self._is_moved.any() and (self.names, self.groups) == self._first

    def _dense(self) -> tuple[npt.NDArray[np.int32], IntArray]:
        """Label of each atom, and the id of the segment behind each label.

        Where nothing but names was changed, those of the automatic segmentation.
        """
        if not self._is_moved.any():
            return self.parts["final"].astype(np.int32), np.arange(self.automatic.n_segments)
        n_atoms, area, _ = self._added_up()[:, 1:]
        ids = np.flatnonzero(n_atoms)
        order = np.argsort(-area[ids], kind="stable")
        if (np.diff(area[ids][order]) == 0).any():  # ties go by the first face
            first = np.full(self._next_id + 1, self.automatic.mesh.n_faces)
            np.minimum.at(first, self.segment, self.atoms.first_face)
            order = np.lexsort((first[ids], -area[ids]))
        ids = ids[order]
        rank = np.full(self._next_id + 1, -1, dtype=np.int32)  # the last one is for segment = -1
        rank[ids] = np.arange(len(ids))
        return rank[self.segment], ids

    def _item_labels(self, atom_label: IntArray) -> IntArray:
        """(n_items,) label of most of each item's area."""
        item, atom, weights = self._pieces
        label = atom_label[atom]
        item, label, weights = item[label >= 0], label[label >= 0], weights[label >= 0]
        n = int(atom_label.max(initial=0)) + 1
        automatic = self.automatic
        n_items = automatic.items.n if automatic.items is not None else int(item.max(initial=-1)) + 1
        code, index = np.unique(item * n + label, return_inverse=True)
        area = np.bincount(index, weights)
        item, label = np.divmod(code, n)
        order = np.lexsort((-label, area, item))  # the largest area comes last and stays
        out = np.full(n_items, -1, dtype=np.int32)
        out[item[order]] = label[order]
        return out


def _sums(group: IntArray, weights: FloatArray | None, n: int) -> FloatArray:
    """(n,) sum of the weights of each group, 1 each by default."""
    return np.asarray(np.bincount(group, weights, minlength=n), dtype=np.float64)
