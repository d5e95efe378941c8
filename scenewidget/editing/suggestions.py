"""The edits that are most worth looking at next, from what is doubtful and no truth.

Goes in: where every part is now, and what a person has decided so far. Comes out: merges and splits, each
with the drop of 1 − RI that can be expected of a person who follows it if it is right; best first.
What is doubtful says `engine.doubt`; every decision makes its like, in this scan, more or less likely.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from scenewidget.editing.edits import Edit, Merge, Split
from scenewidget.editing.partition import Partition
from scenewidget.engine.doubt import (
    FITTED,
    Cuts,
    Doubt,
    doubts,
    log_odds,
    logistic,
    measure_borders,
    measure_gaps,
    run_kinds,
)
from scenewidget.engine.gravity import up_direction
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray
from scenewidget.engine.naming import name_segments
from scenewidget.engine.pieces import Pieces
from scenewidget.engine.segmentation import Level, Segmentation

__all__ = ["Advisor", "Dismissal", "Suggestion"]

SMALLEST = 2e-4  # share of the faces below which a part is not worth a question
SURE = 0.6  # least probability of what is suggested first
PROBABLE = 0.1  # least probability of the one that comes where there is nothing of that kind
JOINS = 0.5  # least probability that what is cut off belongs to a neighbour for that to be suggested
N_SAMPLES = 32  # faces by which a segment is known again
MOST_CUTS = 12  # of one segment that are looked at
MOST_PARTS = 1_000  # of a side that is named part by part
STRENGTH = 1.5  # variance of the log-odds that decisions can change
ROUNDS = 8  # of Newton's method
LIKE = 1.0  # how far a decision reaches, in standard deviations of the measures
WORTH = 1e-4  # gain below which there is nothing more to look at

SuggestionKey = tuple[str, frozenset[int], int]
Model = Literal["same", "two", "apart", ""]
NOTHING = np.empty(0, np.int64)
_Lesson = tuple[FloatArray, float, float]  # what a model weighs, what a person decided, how much that counts


@dataclass(frozen=True)
class Suggestion:
    """An edit that is worth being judged.

    Attributes
    ----------
    kind : "merge" | "split"
    faces : tuple of int
        A face of each part that would move; the first lies amid the largest.
    onto_face : int
        A face of the segment that they would join; -1 for a split.
    level : "final" | "base"
        Of the parts: a whole segment, or base segments.
    gain : float
        By how much 1 − RI, by face count, is expected to drop if a person follows the suggestion where it is
        right and dismisses it where it is not: 2 p_1 p_2 p for two segments with shares p_1 and p_2 of the
        faces.
    p : float
        Probability that the edit is right. Below one half it is not to be made unseen.
    title : str
        What a list shows.
    why : str
        What speaks for it, measured: "border 12 cm, same plane, together in 61 % of the runs".

    Examples
    --------
    >>> Suggestion("split", (3, 8), -1, "base", gain=0.01, p=0.7, title="Split a part off").edit
    Split(face=3, level='base', also=(8,))
    """

    kind: Literal["merge", "split"]
    faces: tuple[int, ...]
    onto_face: int
    level: Level
    gain: float
    p: float
    title: str
    why: str = ""

    @classmethod
    def of(cls, edit: Edit) -> Suggestion:
        """The suggestion whose `edit` this is, without what was expected of it.

        Examples
        --------
        >>> Suggestion.of(Split(3, "base", (8,))).faces
        (3, 8)
        """
        if isinstance(edit, Merge):
            return cls("merge", edit.faces, edit.onto_face, edit.level, 0.0, 0.0, "")
        if isinstance(edit, Split):
            return cls("split", (edit.face, *edit.also), -1, edit.level, 0.0, 0.0, "")
        raise TypeError(f"edit must be a Merge or a Split, got {type(edit).__name__}")

    @property
    def face(self) -> int:
        """The first of the faces."""
        return self.faces[0]

    @property
    def probability(self) -> float:
        """The same as ``p``."""
        return self.p

    @property
    def edit(self) -> Edit:
        """What `Session.do` takes to follow it."""
        if self.kind == "split":
            return Split(self.face, self.level, self.faces[1:])
        return Merge(self.faces, self.onto_face, self.level)


@dataclass(frozen=True, eq=False)
class Dismissal:
    """A suggestion that a person rejected, remembered by faces: undo gives the ids of segments anew.

    Attributes
    ----------
    kind : "merge" | "split"
    part : int
        Base segment that was to move first; -1 for a whole segment.
    samples : tuple of (N_SAMPLES,) int
        Faces spread over each segment in question.
    sizes : tuple of float
        Number of faces of each.
    model : "same" | "two" | "apart" | ""
        Which of `engine.doubt.Models` spoke for it; none where two did, and either may have been wrong.
    measures : (n,) float64
        What that model weighed.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh, _ = sw.datasets.load_room()
    >>> session = sw.Session(mesh, sw.segment(mesh, sw.Params(n_items=500)))
    >>> first = session.suggestions(1)[0]
    >>> session.dismiss(first)
    >>> first in session.suggestions()
    False
    """

    kind: Literal["merge", "split"]
    part: int
    samples: tuple[IntArray, ...]
    sizes: tuple[float, ...]
    model: Model
    measures: FloatArray

    @classmethod
    def of(cls, partition: Partition, suggestion: Suggestion) -> Dismissal:
        """What there is to remember of a suggestion for the segments as they are now."""
        atoms = partition.atoms
        part = -1
        if suggestion.level == "base":
            part = int(partition.parts["base"][atoms.face_atom[suggestion.face]])
        samples, sizes = [], []
        whole = suggestion.faces if suggestion.level == "final" else suggestion.faces[:1]
        for face in (*whole, suggestion.onto_face):
            if face < 0:
                continue
            inside = np.flatnonzero(partition.segment == partition.segment_at(face))
            end = np.cumsum(partition.atom_faces[inside])
            places = (np.arange(N_SAMPLES) + 0.5) / N_SAMPLES * end[-1]
            samples.append(atoms.first_face[inside[np.searchsorted(end, places)]])
            sizes.append(float(end[-1]))
        return cls(suggestion.kind, part, tuple(samples), tuple(sizes), "", np.empty(0))

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
        return self.kind, frozenset(ids), self.part


@dataclass(frozen=True, eq=False)
class _Found:
    """A suggestion before it is put in words; segments by their place among those that there are."""

    gain: float
    p: float
    key: SuggestionKey
    home: int
    onto: int  # −1: a segment of its own
    side: IntArray  # pieces that move; none: the whole segment
    model: Model
    measures: FloatArray
    why: str
    also: tuple[int, ...] = ()  # more whole segments that move


@dataclass(eq=False)
class Advisor:
    """What suggests edits of one automatic segmentation, and remembers what it has measured.

    Parameters
    ----------
    automatic : Segmentation
        With an ensemble.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.editing.partition import Partition
    >>> mesh, _ = sw.datasets.load_room()
    >>> seg = sw.segment(mesh, sw.Params(n_items=500))
    >>> len(Advisor(seg).suggest(Partition(seg), 3, []))
    3
    """

    automatic: Segmentation
    _known: dict[bytes, Cuts] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.start: Doubt = self.automatic.find_doubt()
        self.pieces: Pieces = self.start.pieces
        self.graph_keys, self.medoid_keys = run_kinds(self.automatic.keys, self.automatic.report.get("runs"))
        self.gaps = measure_gaps(self.pieces, self.graph_keys)
        self.up = up_direction(self.automatic.mesh)

    def suggest(self, partition: Partition, n: int, dismissed: Sequence[Dismissal]) -> list[Suggestion]:
        """At most n suggestions, the largest expected gain first.

        Nothing that a person decided is put in question: what was taken apart or named differently is not to
        be merged, what was merged is not to be taken apart, and what is in ``dismissed`` is not repeated.
        What is probably wrong comes only after all that is probably right and worth a look, and one by one.

        Parameters
        ----------
        partition : Partition
            Of the same automatic segmentation.
        n : int
        dismissed : sequence of Dismissal
        """
        now = _Look(self, partition, dismissed)
        found = sorted((f for f in now.found() if f.p >= PROBABLE), key=lambda f: -f.gain)
        sure = now.together([f for f in found if f.p >= SURE and f.gain >= WORTH])
        chance = sorted(found, key=lambda f: -f.gain * f.p)[:1]  # small probabilities are the least sure
        return [now.in_words(f) for f in (sure or chance)[:n]]

    def remember(
        self, partition: Partition, suggestion: Suggestion, dismissed: Sequence[Dismissal]
    ) -> Dismissal:
        """What to keep of a suggestion that is rejected."""
        now = _Look(self, partition, dismissed)
        wanted = Dismissal.of(partition, suggestion)
        key = wanted.key(partition, now.id_faces)
        for found in now.found():
            if found.key == key:
                return dataclasses.replace(wanted, model=found.model, measures=found.measures)
        return wanted


class _Look:
    """The doubts about the segments as they are now."""

    def __init__(self, advisor: Advisor, partition: Partition, dismissed: Sequence[Dismissal]) -> None:
        self.advisor, self.partition = advisor, partition
        automatic, pieces = advisor.automatic, advisor.pieces
        atom_piece = pieces.face_piece[partition.atoms.first_face]
        keep = np.flatnonzero((atom_piece >= 0) & (partition.segment >= 0))
        n_ids = int(partition.segment.max(initial=-1)) + 1
        code = atom_piece[keep].astype(np.int64) * n_ids + partition.segment[keep]
        codes, index = np.unique(code, return_inverse=True)
        share = np.bincount(index, partition.atom_faces[keep])
        piece, segment = codes // n_ids, codes % n_ids
        order = np.lexsort((share, piece))  # the segment that has most of a piece comes last and stays
        home = np.zeros(pieces.n, dtype=np.int64)
        home[piece[order]] = segment[order]
        stays = keep[partition.segment[keep] == home[atom_piece[keep]]][::-1]
        self.faces = pieces.first_face.copy()  # of each piece one that lies in its segment as it is now
        self.faces[atom_piece[stays]] = partition.atoms.first_face[stays]
        self.ids, dense = np.unique(home, return_inverse=True)
        self.pieces = dataclasses.replace(pieces, segment=dense.astype(np.int32))
        self.doubt = doubts(
            self.pieces,
            automatic.keys,
            automatic.report.get("runs"),
            n_segments=len(self.ids),
            known=advisor._known,
        )
        self.n_faces = max(float(pieces.n_faces.sum()), 1.0)
        self.size = np.bincount(dense, pieces.n_faces, len(self.ids)) / self.n_faces
        self.id_faces = np.bincount(partition.segment + 1, partition.atom_faces).astype(np.float64)
        self._rejected = {dismissal.key(partition, self.id_faces) for dismissal in dismissed}
        self._apart = self._kept_apart()
        self._learn(dismissed)

    def _learn(self, dismissed: Sequence[Dismissal]) -> None:
        """Log-odds that what was decided so far adds to borders and cuts."""
        before, now = self.advisor.start, self.doubt
        table = np.zeros((len(before.two), len(self.ids)))
        np.add.at(table, (before.pieces.segment, now.pieces.segment), before.pieces.n_faces)
        home = table.argmax(axis=1)  # where most of each automatic segment is
        rows: dict[str, list[_Lesson]] = {"same": [], "two": [], "apart": []}
        b = before.borders
        joined = np.flatnonzero(home[b.first] == home[b.second])
        n_borders = np.bincount(home[b.first[joined]], minlength=len(self.ids))
        n_decisions = np.bincount(home, minlength=len(self.ids)) - 1  # one may touch several of a group
        share = np.minimum(n_decisions / np.maximum(n_borders, 1), 1.0)
        for k in joined:
            rows["same"].append((b.measures[k], 1.0, float(share[home[b.first[k]]])))
        b = now.borders
        for k in np.flatnonzero(self._apart[b.first, b.second]):
            rows["same"].append((b.measures[k], 0.0, 1.0))
        for s in np.flatnonzero((table > 0).sum(axis=1) > 1):
            cuts = before.cuts[s]
            side = before.side(int(s))
            if cuts is not None and len(side):
                is_away = now.pieces.segment[side] != home[s]
                if is_away.mean() > 0.5:
                    rows["two"].append((cuts.measures[int(before.best[s])], 1.0, 1.0))
        for dismissal in dismissed:
            if dismissal.model:
                rows[dismissal.model].append((dismissal.measures, 0.0, 1.0))
        cut = [cuts.measures for cuts in before.cuts if cuts is not None]
        spread = {
            "same": before.borders.measures,
            "two": np.concatenate([np.empty((0, len(FITTED.two) - 1)), *cut]),
            "apart": self.advisor.gaps.measures,
        }
        self._lessons = {
            model: _Lessons.of(rows[model], getattr(FITTED, model), spread[model]) for model in rows
        }

    def found(self) -> list[_Found]:
        """All that could be suggested and wasn't rejected."""
        return [f for f in (*self.merges(), *self.gaps(), *self.divisions()) if f.key not in self._rejected]

    def together(self, sure: list[_Found]) -> list[_Found]:
        """The same with all that is to join one segment in one, unless that was rejected."""
        joined: dict[int, list[_Found]] = {}
        for f in sure:
            if f.onto >= 0 and not len(f.side):
                joined.setdefault(f.onto, []).append(f)
        out = list(sure)
        for onto, parts in joined.items():
            key = ("merge", frozenset().union(*(f.key[1] for f in parts)), -1)
            if len(parts) < 2 or key in self._rejected:
                continue
            gain = sum(f.gain for f in parts)
            p = gain / sum(f.gain / f.p for f in parts)  # the share of it that is right
            also = tuple(f.home for f in parts[1:])
            why = f"the largest: {parts[0].why}"
            out = [f for f in out if f not in parts]
            out.append(_Found(gain, p, key, parts[0].home, onto, NOTHING, "", np.empty(0), why, also))
        return sorted(out, key=lambda f: -f.gain)

    def merges(self) -> list[_Found]:
        """Whole segments onto larger ones that they touch."""
        borders = self.doubt.borders
        p = self._lessons["same"].probability(borders.measures)
        ends = borders.first, borders.second
        return self._joined("same", *ends, p, borders.measures, self._why_same)

    def gaps(self) -> list[_Found]:
        """Whole segments onto larger ones in the same plane, and parts of the floor, behind something."""
        gaps = measure_gaps(self.pieces, self.advisor.graph_keys)
        p = self._lessons["apart"].probability(gaps.measures)

        def why(k: int) -> str:
            words = [f"{_length(float(gaps.gap[k]))} apart", self._off_plane(float(gaps.offset[k]))]
            return ", ".join([*words, f"together in {gaps.agreement[k]:.0%} of the runs"])

        up = self.advisor.up
        names = {} if up is None else name_segments(self.pieces, up)
        floor = {segment: p for segment, (name, p) in names.items() if name == "floor"}
        is_floor = np.isin(gaps.first, [*floor]) & np.isin(gaps.second, [*floor])
        behind = self._joined(
            "apart", gaps.first, gaps.second, np.where(is_floor, 0.0, p), gaps.measures, why
        )
        return behind + self._floors(floor)

    def _floors(self, floor: dict[int, float]) -> list[_Found]:
        """Floor that is seen elsewhere, onto the largest part of it."""
        if len(floor) < 2:
            return []
        parts = np.array(sorted(floor, key=lambda s: -self.size[s]))
        first, second = np.full(len(parts) - 1, parts[0]), parts[1:]
        p = np.array([floor[int(parts[0])] * floor[int(s)] for s in second])
        why = "as low as the floor, without touching it"
        return self._joined("", first, second, p, np.empty((len(p), 0)), lambda k: why)

    def _joined(
        self,
        model: Model,
        first: IntArray,
        second: IntArray,
        p: FloatArray,
        measures: FloatArray,
        why: Callable[[int], str],
    ) -> list[_Found]:
        gain = 2 * self.size[first] * self.size[second] * p
        gain[self._apart[first, second] | (np.minimum(self.size[first], self.size[second]) < SMALLEST)] = 0.0
        out = []
        for k in np.flatnonzero(gain > 0).tolist():
            a, b = int(first[k]), int(second[k])
            onto, home = (a, b) if self.size[a] >= self.size[b] else (b, a)
            key = ("merge", frozenset((int(self.ids[a]), int(self.ids[b]))), -1)
            out.append(
                _Found(float(gain[k]), float(p[k]), key, home, onto, NOTHING, model, measures[k], why(k))
            )
        return out

    def divisions(self) -> list[_Found]:
        """Sides of cuts that become segments of their own, or join another one that they touch."""
        splits = []
        for s, cuts in enumerate(self.doubt.cuts):
            if cuts is None or not cuts.n or self.size[s] < SMALLEST:
                continue
            p = self._lessons["two"].probability(cuts.measures)
            share = self._faces_of_sides(cuts) / self.n_faces
            gain = 2 * share * (self.size[s] - share) * p
            gain[(share < SMALLEST) | (p < PROBABLE)] = 0.0
            for k in np.argsort(-gain * p, kind="stable")[:MOST_CUTS].tolist():
                side = cuts.side(k)
                if gain[k] > 0 and len(side) <= MOST_PARTS and self._may_divide(s, side):
                    side = side[np.argsort(-self.pieces.n_faces[side], kind="stable")]
                    key = ("split", frozenset((int(self.ids[s]),)), int(self.pieces.base[side[0]]))
                    if key not in self._rejected:
                        why = self._why_two(cuts, k)
                        found = _Found(
                            float(gain[k]), float(p[k]), key, s, -1, side, "two", cuts.measures[k], why
                        )
                        splits.append(found)
                        break
        return splits + self._moves(splits)

    def _moves(self, splits: list[_Found]) -> list[_Found]:
        """The same cuts where what comes off probably belongs to a neighbour."""
        n = len(self.ids)
        segment = self.pieces.segment.copy()
        for i, split in enumerate(splits):
            segment[split.side] = n + i
        borders = measure_borders(
            dataclasses.replace(self.pieces, segment=segment),
            self.advisor.graph_keys,
            self.advisor.medoid_keys,
        )
        p = self._lessons["same"].probability(borders.measures)
        out: dict[int, _Found] = {}
        for k in np.flatnonzero((borders.second >= n) & (borders.first < n) & (p >= JOINS)).tolist():
            i, onto = int(borders.second[k]) - n, int(borders.first[k])
            split = splits[i]
            if onto == split.home or self._apart[onto, split.home]:
                continue
            share = float(self.pieces.n_faces[split.side].sum()) / self.n_faces
            both = split.p * float(p[k])
            gain = 2 * share * (self.size[split.home] - share + self.size[onto]) * both
            key = ("merge", frozenset((int(self.ids[split.home]), int(self.ids[onto]))), split.key[2])
            why = f"{split.why}; {_length(float(borders.length[k]))} along the other, {p[k]:.0%} one thing"
            if i not in out or gain > out[i].gain:
                out[i] = _Found(gain, both, key, split.home, onto, split.side, "", split.measures, why)
        return list(out.values())

    def _faces_of_sides(self, cuts: Cuts) -> FloatArray:
        """(n,) faces on the smaller side of each cut."""
        total = np.concatenate([[0], np.cumsum(self.pieces.n_faces[cuts.order])])
        inside = total[cuts.stop] - total[cuts.start]
        return np.asarray(np.where(cuts.is_inside, inside, total[-1] - inside), dtype=np.float64)

    def _may_divide(self, segment: int, side: IntArray) -> bool:
        """Whether a cut leaves together what a person has put together."""
        automatic = self.advisor.pieces.segment
        inside = np.flatnonzero(self.pieces.segment == segment)
        parts = np.unique(automatic[inside])
        if len(parts) == 1:
            return True
        rest = np.setdiff1d(inside, side, assume_unique=True)
        of_side = np.unique(automatic[side])
        return len(of_side) == 1 and bool((automatic[rest] == of_side[0]).any())

    def _kept_apart(self) -> BoolArray:
        """(n, n) pairs of segments between which a person has decided."""
        n = len(self.ids)
        spread = np.zeros((n, len(self.advisor.start.two)), dtype=bool)
        spread[self.pieces.segment, self.advisor.pieces.segment] = True
        out: BoolArray = np.eye(n, dtype=bool)
        for column in spread.T[spread.sum(axis=0) > 1]:
            out |= np.outer(column, column)
        names = np.array([self.partition.names.get(int(i), "") for i in self.ids])
        is_named = names != ""
        out |= is_named[:, None] & is_named[None, :] & (names[:, None] != names[None, :])
        groups = self.partition.groups
        groups = {**groups, **{whole: whole for whole in groups.values()}}
        whole = np.array([groups.get(int(i), -1) for i in self.ids])
        out |= (whole[:, None] == whole[None, :]) & (whole >= 0)[:, None]  # parts of one thing stay parts
        return out

    def in_words(self, found: _Found) -> Suggestion:
        """The suggestion with faces to look at and words to read."""
        names = [
            self.partition.names.get(int(self.ids[s]), "") if s >= 0 else "" for s in (found.home, found.onto)
        ]
        thing, target = (repr(name) if name else "" for name in names)
        if found.also:
            title = f"Merge {1 + len(found.also)} parts with {target or 'their likely rest'}"
        elif found.onto < 0:
            title = f"Split a part off {thing or 'a segment'}"
        else:
            title = f"Merge {thing or 'a segment'} with {target or 'its likely rest'}"
        wholes = [self._face(segment) for segment in (found.home, *found.also)]
        faces = self.faces[found.side] if len(found.side) else wholes
        return Suggestion(
            "split" if found.onto < 0 else "merge",
            tuple(int(face) for face in faces),
            -1 if found.onto < 0 else self._face(found.onto),
            "base" if len(found.side) else "final",
            found.gain,
            found.p,
            f"{title} ({found.p:.0%})",
            found.why,
        )

    def _why_same(self, k: int) -> str:
        b = self.doubt.borders
        together = 0.5 * (b.by_graph[k] + b.by_medoids[k])
        words = [f"border {_length(float(b.length[k]))}", self._off_plane(float(b.offset[k]))]
        words.append("bulging" if b.convex[k] > 0.6 else "folded in" if b.convex[k] < 0.3 else "even")
        return ", ".join([*words, f"together in {together:.0%} of the runs"])

    def _why_two(self, cuts: Cuts, k: int) -> str:
        together = f"with the rest in {cuts.agreement[k]:.0%} of the runs"
        return f"{self._off_plane(float(cuts.offset[k]))}, {together}"

    def _off_plane(self, offset: float) -> str:
        return "same plane" if offset < 0.02 * self.pieces.scale else f"{_length(offset)} off its plane"

    def _face(self, segment: int) -> int:
        inside = np.flatnonzero(self.partition.segment == self.ids[segment])
        largest = inside[np.argmax(self.partition.atom_faces[inside])]
        return int(self.partition.atoms.first_face[largest])


@dataclass(frozen=True, eq=False)
class _Lessons:
    """What a person's decisions say about their like.

    A Gaussian process over the measures, around the log-odds of the model, given the decisions (Rasmussen and
    Williams, 2006, 3.4). What one of them has taught already, a like one teaches no more.
    """

    weights: tuple[float, ...]
    spread: FloatArray  # of each measure
    measures: FloatArray  # (n, m) of what was decided, in spreads
    surprise: FloatArray  # (n,) decision less probability, as learned by now, times its weight

    @classmethod
    def of(cls, rows: list[_Lesson], weights: tuple[float, ...], population: FloatArray) -> _Lessons:
        m = len(weights) - 1
        spread = population.std(axis=0) + 1e-3 if len(population) else np.ones(m)
        measures = np.array([row for row, _, _ in rows]).reshape(-1, m)
        outcome, weight = np.array([row[1:] for row in rows]).reshape(-1, 2).T
        prior, places = log_odds(weights, measures), measures / spread
        alike, surprise = _alike(places, places), np.zeros(len(rows))
        for _ in range(ROUNDS):  # Newton's method for α = w (outcome − p), log-odds of p = prior + K α
            odds = prior + alike @ surprise
            p = 1.0 / (1.0 + np.exp(-odds))
            slope = weight * p * (1.0 - p)
            miss = weight * (outcome - p) - surprise
            surprise = surprise + np.linalg.solve(np.eye(len(rows)) + slope[:, None] * alike, miss)
        return cls(weights, spread, places, surprise)

    def probability(self, measures: FloatArray) -> FloatArray:
        """(n,) of measures (n, m), with what was learned."""
        p = logistic(self.weights, measures)
        if len(self.surprise) == 0:
            return p
        odds = np.log(p / (1 - p)) + _alike(measures / self.spread, self.measures) @ self.surprise
        return np.asarray(1.0 / (1.0 + np.exp(-odds)))


def _alike(some: FloatArray, others: FloatArray) -> FloatArray:
    """(n, m) covariance of log-odds, from measures in spreads."""
    apart = (some[:, None] - others[None]) ** 2
    return np.asarray(STRENGTH * np.exp(-apart.mean(axis=2) / (2 * LIKE**2)))


def _length(meters: float) -> str:
    return f"{100 * meters:.0f} cm" if meters < 1 else f"{meters:.1f} m"
