"""The edits that are most worth looking at next, from what the ensemble knows and no truth.

Goes in: where every part is now, and how often the runs put parts together. Comes out: merges and splits,
each with the drop of 1 − RI that can be expected of a person who looks at it and follows it if it is right;
best first. Two pieces that the runs put together almost often enough are worth a question, the more the
larger they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from scenewidget.editing.edits import Edit, Merge, Split
from scenewidget.editing.partition import Partition
from scenewidget.engine.evidence import agreement_of_groups, foreign, same_thing
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray
from scenewidget.engine.segmentation import Level

__all__ = ["Dismissal", "Evidence", "Suggestion", "suggest"]

SMALLEST = 2e-4  # share of the faces below which a part is not worth a question
PROBABLE = 0.05  # least probability of a merge that is worth one: walls and floors are large, but not one
N_SAMPLES = 32  # a segment is known again by so many of its faces
SuggestionKey = tuple[int, frozenset[int]]  # base segment (-1: a whole segment) and ids of the segments


@dataclass(frozen=True)
class Suggestion:
    """An edit that the ensemble would like to have judged.

    Attributes
    ----------
    kind : "merge" | "split"
    face : int
        A face of the part that would move, amid its largest piece.
    onto_face : int
        A face of the segment that it would join; -1 for a split.
    level : "final" | "base"
        Of the part: a whole segment, or a base segment.
    gain : float
        By how much 1 − RI, by face count, is expected to drop if a person follows the suggestion where it is
        right and dismisses it where it is not: 2 p_1 p_2 P for two segments with shares p of the faces and
        probability P of being one thing.
    probability : float
        P, that the edit is right. Below one half the edit is not to be made unseen.
    title : str
        What a list shows.

    Examples
    --------
    >>> Suggestion("split", 3, -1, "base", gain=0.01, probability=0.7, title="Split a part off").edit
    Split(face=3, level='base')
    """

    kind: Literal["merge", "split"]
    face: int
    onto_face: int
    level: Level
    gain: float
    probability: float
    title: str

    @property
    def edit(self) -> Edit:
        """What `Session.do` takes to follow it."""
        if self.kind == "split":
            return Split(self.face, self.level)
        return Merge((self.face,), self.onto_face, self.level)


@dataclass(frozen=True, eq=False)
class Dismissal:
    """A suggestion that a person rejected, remembered by faces: undo gives the ids of segments anew.

    Attributes
    ----------
    part : int
        Base segment that was to move; -1 for a whole segment.
    samples : tuple of (N_SAMPLES,) int
        Faces spread over each segment in question.
    sizes : tuple of float
        Number of faces of each.
    """

    part: int
    samples: tuple[IntArray, ...]
    sizes: tuple[float, ...]

    @classmethod
    def of(cls, partition: Partition, suggestion: Suggestion) -> Dismissal:
        """What there is to remember of a suggestion for the segments as they are now."""
        atoms = partition.atoms
        part = -1
        if suggestion.level == "base":
            part = int(partition.parts["base"][atoms.face_atom[suggestion.face]])
        samples, sizes = [], []
        for face in (suggestion.face, suggestion.onto_face):
            if face < 0:
                continue
            inside = np.flatnonzero(partition.segment == partition.segment_at(face))
            end = np.cumsum(partition.atom_faces[inside])
            places = (np.arange(N_SAMPLES) + 0.5) / N_SAMPLES * end[-1]
            samples.append(atoms.first_face[inside[np.searchsorted(end, places)]])
            sizes.append(float(end[-1]))
        return cls(part, tuple(samples), tuple(sizes))

    def key(self, partition: Partition, sizes: FloatArray) -> SuggestionKey | None:
        """Which suggestion is rejected now; None where a segment in question is no longer what it was.

        That is, it has lost half of its faces, or has more than twice as many.

        Parameters
        ----------
        partition : Partition
        sizes : (n_segments + 1,) float
            Faces of each segment by its id, after those of none.
        """
        ids = []
        for faces, size in zip(self.samples, self.sizes, strict=True):
            now = partition.segment[partition.atoms.face_atom[faces]] + 1
            home = int(np.bincount(now).argmax())
            if 2 * np.count_nonzero(now == home) <= N_SAMPLES or sizes[home] > 2 * size:
                return None
            ids.append(home - 1)
        return self.part, frozenset(ids)


def suggest(partition: Partition, n: int, dismissed: Sequence[Dismissal]) -> list[Suggestion]:
    """At most n suggestions, the largest expected gain first.

    Nothing that a person decided is put in question: what was taken apart or named differently is not to be
    merged, what was moved is not to be moved again, and what is in ``dismissed`` is not repeated.
    """
    sizes = np.bincount(partition.segment + 1, partition.atom_faces).astype(np.float64)
    rejected = {dismissal.key(partition, sizes) for dismissal in dismissed}
    evidence = Evidence(partition)
    found: list[tuple[float, float, SuggestionKey, int, int, int]] = []
    most = n + len(rejected)
    for rows in (evidence.merges(most), evidence.moves(most)):
        found += rows
    found.sort(key=lambda row: -row[0])
    out: list[Suggestion] = []
    for gain, probability, key, part, home, onto in found:
        if len(out) == n:
            break
        if key not in rejected:
            out.append(evidence.suggestion(gain, probability, part, home, onto))
    return out


class Evidence:
    """Shares of faces, and the probability of being one thing, for segments and base segments.

    Attributes
    ----------
    ids : (n,) int
        The segments that are worth a question, by their ids in the partition.
    size : (n,) float64
        Their shares of the faces.
    between : (n, n) float64
        Mean co-association of two of them.
    """

    def __init__(self, partition: Partition) -> None:
        automatic = partition.automatic
        if automatic.keys is None:
            raise ValueError("a segmentation without an ensemble has nothing to suggest")
        self.partition = partition
        self.base = partition.parts["base"]
        faces = partition.atom_faces
        self.is_moved = partition.segment != partition.parts["final"]
        self.ids, self.segment, self.size = _large(partition.segment, faces)
        self.n_faces = float(faces.sum())
        n, n_base = len(self.ids), len(automatic.keys)
        keep = np.flatnonzero((self.base >= 0) & (self.segment >= 0))
        code = self.base[keep].astype(np.int64) * n + self.segment[keep]
        count = np.bincount(code, faces[keep], n_base * n)
        moved = np.bincount(code, self.is_moved[keep], n_base * n) > 0
        sure = np.bincount(code, automatic.confidence[partition.atoms.first_face[keep]] * faces[keep])
        entries = np.flatnonzero(count)
        self.part, self.home = entries // n, entries % n
        self.share = count[entries] / self.n_faces
        self.confidence = sure[entries] / count[entries]
        # base segments that lie in one segment, as they were
        is_whole = np.bincount(self.part, minlength=n_base)[self.part] == 1
        self.asked = np.flatnonzero(is_whole & ~moved[entries] & (self.share >= SMALLEST))
        self.between, self.with_segments = agreement_of_groups(
            automatic.keys, self.share, self.part, self.home, n, self.part[self.asked]
        )

    def merges(self, most: int) -> list[tuple[float, float, SuggestionKey, int, int, int]]:
        """Whole segments onto larger ones, the best so many."""
        probability = same_thing(self.between)
        gain = 2 * self.size[:, None] * self.size[None, :] * probability
        gain[self._kept_apart() | (probability < PROBABLE)] = 0.0
        one, other = np.nonzero(np.triu(gain > 0, 1))
        order = np.argsort(-gain[one, other], kind="stable")[:most]
        out = []
        for a, b in zip(one[order].tolist(), other[order].tolist()):
            onto, part = (a, b) if self.size[a] >= self.size[b] else (b, a)
            key = (-1, frozenset((int(self.ids[a]), int(self.ids[b]))))
            out.append((float(gain[a, b]), float(probability[a, b]), key, -1, part, onto))
        return out

    def moves(self, most: int) -> list[tuple[float, float, SuggestionKey, int, int, int]]:
        """Base segments onto other segments, or off on their own; for each the better of the two.

        The best so many.
        """
        if len(self.asked) == 0:
            return []
        rows = np.arange(len(self.asked))
        home, share = self.home[self.asked], self.share[self.asked]
        leaves = foreign(self.confidence[self.asked])
        rest = self.size[home] - share
        joins = np.minimum(same_thing(self.with_segments), leaves[:, None])
        joins *= 1.0 - same_thing(self.between)[home]  # or all of its segment is to join
        joins[rows, home] = 0.0
        joins[self._kept_apart()[home]] = 0.0
        join = 2 * share[:, None] * (self.size[None, :] + rest[:, None]) * joins
        leave = 2 * share * rest * leaves
        best = join.argmax(axis=1)
        is_join = join[rows, best] > leave
        gains = np.where(is_join, join[rows, best], leave)
        gains[rest <= 0] = 0.0
        order = np.argsort(-gains, kind="stable")[:most]
        out = []
        for i in order[gains[order] > 0].tolist():
            onto = int(best[i]) if is_join[i] else -1
            gain, probability = (join[i, onto], joins[i, onto]) if is_join[i] else (leave[i], leaves[i])
            ends = {int(self.ids[home[i]])} | ({int(self.ids[onto])} if onto >= 0 else set())
            part = int(self.part[self.asked[i]])
            out.append((float(gain), float(probability), (part, frozenset(ends)), part, int(home[i]), onto))
        return out

    def _kept_apart(self) -> BoolArray:
        """(n, n) pairs of segments between which a person has decided."""
        n = len(self.ids)
        out = np.eye(n, dtype=bool)
        final = self.partition.parts["final"]
        keep = (self.segment >= 0) & (final >= 0)
        spread = np.zeros((n, int(final.max(initial=-1)) + 1), dtype=bool)
        spread[self.segment[keep], final[keep]] = True
        is_split = spread.sum(axis=0) > 1
        for column in spread.T[is_split]:
            out |= np.outer(column, column)
        names = np.array([self.partition.names.get(int(i), "") for i in self.ids])
        is_named = names != ""
        out |= is_named[:, None] & is_named[None, :] & (names[:, None] != names[None, :])
        return out

    def suggestion(self, gain: float, probability: float, part: int, home: int, onto: int) -> Suggestion:
        """The suggestion with faces to look at and words to read."""
        where = self.segment == home
        if part >= 0:
            where &= self.base == part
        names = [self.partition.names.get(int(self.ids[s]), "") if s >= 0 else "" for s in (home, onto)]
        thing, target = (repr(name) if name else "" for name in names)
        if onto < 0:
            title = f"Split a part off {thing or 'a segment'}"
        elif part < 0:
            title = f"Merge {thing or 'a segment'} with {target or 'its likely rest'}"
        else:
            title = f"Move a part of {thing or 'a segment'} to {target or 'another one'}"
        return Suggestion(
            "split" if onto < 0 else "merge",
            self._face(where),
            -1 if onto < 0 else self._face(self.segment == onto),
            "final" if part < 0 else "base",
            gain,
            probability,
            f"{title} ({probability:.0%})",
        )

    def _face(self, where: BoolArray) -> int:
        atoms = np.flatnonzero(where)
        largest = atoms[np.argmax(self.partition.atom_faces[atoms])]
        return int(self.partition.atoms.first_face[largest])


def _large(segment: IntArray, faces: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Ids of the segments that are worth a question, the index into them of each atom (-1: none), shares."""
    share = np.bincount(segment + 1, faces)[1:] / max(float(faces.sum()), 1.0)
    ids: IntArray = np.flatnonzero(share >= SMALLEST)
    index = np.full(len(share) + 1, -1)
    index[ids] = np.arange(len(ids))  # the last entry is for segment = -1
    return ids, index[segment], share[ids]
