"""An editing session: merge, split, name and cut, with undo and redo, without any widget.

Goes in: a mesh and its segmentation. Comes out: the segmentation as a person corrected it, the log of what
was done, and, once `Session.save` has named a file, every further edit on disk before the call returns.

`Session` joins four things and adds a lock: the `History` of edits over a `Partition`, the `ProjectBinding`
that brings the log to a file, the `Observers`, and the suggestions.
"""

from __future__ import annotations

import dataclasses
import os
import threading
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenewidget.editing.edits import (
    Cut,
    Edit,
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
from scenewidget.editing.files import checked_path
from scenewidget.editing.fingerprint import fingerprint
from scenewidget.editing.history import History, Step, apply_edits, operation_table
from scenewidget.editing.observers import Event, EventKind, Observers
from scenewidget.editing.partition import FaceEdit
from scenewidget.editing.project import Operation, Project, read_log
from scenewidget.editing.project_binding import ProjectBinding, mesh_of_project
from scenewidget.editing.project_reader import blame, read_project
from scenewidget.editing.snapshot import Snapshot
from scenewidget.editing.store import FileChangedError
from scenewidget.editing.suggestions import Advisor, Dismissal, Suggestion
from scenewidget.editing.vocabulary import NYU40, chosen_vocabulary, in_vocabulary
from scenewidget.engine.atoms import Atoms
from scenewidget.engine.checks import FixedDict, FixedList, KnownNames, checked_flag, checked_whole
from scenewidget.engine.mesh import BoolArray, IntArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.readers import load
from scenewidget.engine.segmentation import Level, Segmentation
from scenewidget.palette import keep_colors

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Event", "Session", "Snapshot", "Step", "apply_edits"]


TO_SET = {  # what people set of a session that isn't to be set
    ("edits", "history", "undone"): "merge, split, paint … add to it, undo and redo go through it",
    ("labels", "segments"): "write session.paint(faces, onto_face), or session.resegment(segmentation)",
    ("names",): "write session.relabel(face, 'chair')",
    (
        "segmentation",
        "automatic",
        "n_segments",
    ): "session.resegment(segmentation) puts another one underneath",
    ("params",): "write session.resegment(segmentation, params)",
    ("mesh",): "another scan needs another session",
    ("path",): "write session.save('room.swproj')",
}
TO_GET = {  # what people ask a session for under another name
    ("rename", "label", "name", "set_name", "annotate"): "write session.relabel(face, 'chair')",
    ("apply", "replay", "add", "execute"): "write session.do(edit)",
    ("lasso", "brush", "select", "assign", "set_labels"): "write session.paint(faces, onto_face)",
    ("delete", "remove"): "write session.merge(face, onto_face), or session.undo()",
    ("export", "to_ply", "to_glb"): "write sw.export(session.segmentation, session.mesh, path)",
    ("on_change", "on_edit", "subscribe", "add_observer"): "write session.observe(callback)",
    ("log", "steps"): "it is session.history, and session.to_frame() its table",
}


class _Edits(FixedList):
    _instead = "; merge, split, paint … make an edit, session.do(edit) one that is there already"


class Session(KnownNames):
    """A segmentation that a person corrects.

    Every method may be called from any thread. An edit that can't be done (both faces in one segment
    already, an unlabeled face) raises `EditError`, a ValueError, and changes nothing.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
        A path is remembered in the project file, so that opening the project finds the mesh again.
    segmentation : Segmentation
        What the edits start from.
    params : Params, optional
        What it was made with; kept in the project file.
    vocabulary : "nyu40", "scannet20", or sequence of str
        Names to choose from.

    Raises
    ------
    ValueError
        The segmentation is of another mesh.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> session = sw.Session(mesh, seg)
    >>> session.merge(0, onto_face=7).title
    'Merge'
    >>> session.relabel(0, "table").title
    "Name 'table'"
    >>> session.segmentation.names
    ('table',)
    >>> session.undo().title
    "Name 'table'"
    >>> session
    Session(8 faces, 1 segments, 1 edits)
    """

    _set_once = ("mesh",)

    def __init__(
        self,
        mesh: Mesh | Any,
        segmentation: Segmentation,
        *,
        params: Params | None = None,
        vocabulary: str | Sequence[str] = NYU40,
    ) -> None:
        _check_segmentation(segmentation)
        _check_params(params)
        self.mesh: Mesh = load(mesh)
        self._source = self.mesh.source
        self._params = params
        self._vocabulary = chosen_vocabulary(vocabulary)
        self._lock = threading.RLock()
        self._history = History(_of_mesh(segmentation, self.mesh))
        operations = [Operation(time.time(), "open")]
        if self._vocabulary != NYU40:
            operations.append(Operation(time.time(), "vocabulary", names=self._vocabulary))
        self._binding = ProjectBinding(operations, self._taken_over)
        self._observers = Observers()
        self._revision = 0
        self._dismissed: list[Dismissal] = []
        self._rejected: list[Edit] = []  # what was dismissed before the project was opened
        self._advisor: Advisor | None = None
        self._rows_shown: dict[int, int] = {}

    def __repr__(self) -> str:
        place = f", {self.path.name!r}" if self.path is not None else ""
        size = f"{self.mesh.n_faces} {self.mesh.noun}s"
        return f"Session({size}, {self.n_segments} segments, {len(self.edits)} edits{place})"

    def _place_to_set(self, name: str) -> str:
        return next((way for names, way in TO_SET.items() if name in names), "") or super()._place_to_set(
            name
        )

    def _place_to_get(self, name: str) -> str:
        if name in dir(Segmentation) or name in Segmentation.__dataclass_fields__:
            return f"it is session.segmentation.{name}"
        return next((way for names, way in TO_GET.items() if name in names), "") or super()._place_to_get(
            name
        )

    # --- editing ----------------------------------------------------------------------------------

    def merge(self, face: int | Sequence[int], onto_face: int, level: Level = "final") -> Step:
        """The part of ``level`` under a face joins the segment under another face.

        Parameters
        ----------
        face : int or sequence of int
            Faces of the mesh as loaded; several, as from a brush, move their parts in one edit. Those that
            belong to no part are passed over as long as something moves.
        onto_face : int
        level : "dihedral" | "base" | "final"
            At "final" the part is the whole segment under the face as it is now. At the finer levels it
            is the part of that level, wherever its faces are now.

        Returns
        -------
        Step
            The edit as it stands in the history. A target without a name takes that of the segment that
            disappears into it.

        Raises
        ------
        EditError
            Nothing would move.
        """
        return self.do(Merge(face, onto_face, level))  # type: ignore[arg-type]  # Merge makes it a tuple

    def split(self, face: int, level: Level = "final") -> Step:
        """The part of ``level`` under a face becomes a segment of its own, without a name.

        Parameters
        ----------
        face : int
        level : "dihedral" | "base" | "final"
            At "final" the part is what the present segment has from the automatic segment under the face:
            what was merged comes off again. At the finer levels it is the part of that level, wherever
            its faces are now.

        Raises
        ------
        EditError
            The part is a segment of its own already, or the face belongs to no part.
        """
        return self.do(Split(face, level))

    def relabel(self, face: int, name: str) -> Step:
        """Name the segment under a face; "" takes the name away."""
        return self.do(Relabel(face, name))

    def group(self, faces: int | Sequence[int], onto_face: int | None = None) -> Step:
        """The segments under some faces are parts of the one under another: cushions of a sofa.

        They stay segments, and a group is called like its whole. Exports know: ScanNet's objects are whole
        things, with their parts listed. `Segmentation.things` has every group as one segment.

        Parameters
        ----------
        faces : int or sequence of int
            Where a segment among them has parts, these come along.
        onto_face : int, optional
            A face of the whole, or of a part of it. None: they are part of nothing any more, and a whole
            lets go of its parts.

        Raises
        ------
        EditError
            It is so already.

        Examples
        --------
        >>> import scenewidget as sw
        >>> from scenewidget.datasets import analytic
        >>> mesh = analytic.square(2)  # 8 triangles
        >>> session = sw.Session(mesh, sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 0, 1, 1, 2]))
        >>> session.group([5, 7], onto_face=0).title
        'Group'
        >>> session.segmentation.groups
        (0, 0, 0)
        """
        return self.do(Group(faces, onto_face))  # type: ignore[arg-type]  # Group makes it a tuple

    def cut(self, face_a: int, face_b: int) -> Step:
        """Divide the segment under two faces along the cheapest boundary between them.

        The side of ``face_a`` stays the segment that it is, that of ``face_b`` becomes a new one without a
        name. Takes about a second for 200 000 faces.

        Raises
        ------
        EditError
            The faces are in different segments.
        """
        return self.do(Cut(face_a, face_b))

    def preview_cut(self, face_a: int, face_b: int) -> IntArray:
        """What `cut` would make a new segment; nothing changes, and the same cut is quick then.

        Returns
        -------
        faces : (n,) int
            Ascending; ``face_b`` is one of them.

        Raises
        ------
        EditError
            The faces are in different segments.
        """
        with self._lock:
            faces, cut = self._history.partition.divide(Cut(face_a, face_b))
        return faces[cut.is_b]

    def preview(self, edit: FaceEdit) -> IntArray:
        """Faces that an edit made face by face would move; nothing changes.

        Parameters
        ----------
        edit : Paint, Slice, Grow, Shrink, FillHoles or SmoothBorder

        Returns
        -------
        faces : (n,) int
            Ascending, never none.

        Raises
        ------
        EditError
            It can't be done here, or nothing would move.
        TypeError
            Another kind of edit; of a cut, `preview_cut` tells.
        """
        if not isinstance(edit, FaceEdit):
            raise TypeError(f"edit must be a Paint, Slice, Grow, …, got {type(edit).__name__}")
        with self._lock:
            return self._history.partition.destined(edit)[0]

    def paint(self, faces: Sequence[int] | IntArray, onto_face: int | None = None) -> Step:
        """Faces become part of the segment under another face, or a new segment without a name.

        Parameters
        ----------
        faces : (n,) int
            Faces of the mesh as loaded, wherever they are now, unlabeled ones included; any number of them.
        onto_face : int, optional
            A face of the segment that takes them.

        Raises
        ------
        EditError
            Nothing would move.
        """
        return self.do(Paint(faces, onto_face))  # type: ignore[arg-type]  # Paint makes it a set

    def slice(self, face: int, point: Sequence[float], normal: Sequence[float]) -> Step:
        """Divide the segment under a face along a plane.

        The side of ``face`` stays the segment that it is, the other becomes a new one without a name. Faces
        go whole, each to the side of its centroid.

        Parameters
        ----------
        face : int
        point : (3,) float
            A point of the plane, metres.
        normal : (3,) float
            Across the plane, of any length but 0.

        Raises
        ------
        EditError
            All of the segment is on one side.
        """
        return self.do(Slice(face, point, normal))  # type: ignore[arg-type]  # Slice makes them tuples

    def grow(self, face: int, rings: int = 1) -> Step:
        """The segment under a face takes the faces that share an edge with it, ring by ring."""
        return self.do(Grow(face, rings))

    def shrink(self, face: int, rings: int = 1) -> Step:
        """The segment under a face gives its outermost faces to the segments around it, ring by ring.

        Each goes to the segment that it touches most. Where the scan itself ends, nothing is given away.
        """
        return self.do(Shrink(face, rings))

    def fill_holes(self, face: int, max_faces: int = 100) -> Step:
        """The segment under a face takes what it encloses, pieces of at most ``max_faces`` faces."""
        return self.do(FillHoles(face, max_faces))

    def smooth_border(self, face: int, rounds: int = 3) -> Step:
        """Take the teeth off the border of the segment under a face.

        Parameters
        ----------
        face : int
        rounds : int
            More rounds smooth larger teeth; no face further from the border than so many others moves.
        """
        return self.do(SmoothBorder(face, rounds))

    def do(self, edit: Edit) -> Step:
        """Do an edit made elsewhere; what was undone before is forgotten."""
        if not isinstance(edit, Edit):
            raise TypeError(f"edit must be a Merge, Split, Relabel, Cut, …, got {type(edit).__name__}")
        with self._lock:
            now = time.time()
            step, cut = self._history.do(edit, now)
            self._log(Operation(now, "edit", edit=edit, cut=cut))
            event = self._event("edit", step)
        self._tell(event)
        return step

    def undo(self) -> Step:
        """Take the last edit back.

        Raises
        ------
        EditError
            There is none.
        """
        with self._lock:
            step, event = self._undo()
        self._tell(event)
        return step

    def redo(self) -> Step:
        """Do the edit again that was undone last.

        Raises
        ------
        EditError
            There is none: nothing was undone, or an edit was made since.
        """
        with self._lock:
            step, event = self._redo()
        self._tell(event)
        return step

    def go_to(self, n_edits: int) -> None:
        """Undo or redo until ``n_edits`` edits are done: walk the history."""
        n_edits = checked_whole("n_edits", n_edits)
        with self._lock:
            done, undone = len(self._history.steps), len(self._history.undone)
            most = done + undone
            if not 0 <= n_edits <= most:
                raise ValueError(f"n_edits must lie in 0..{most}, got {n_edits}")
            events = [self._undo()[1] for _ in range(done - n_edits)]
            events += [self._redo()[1] for _ in range(n_edits - done)]
        for event in events:
            self._tell(event)

    def resegment(self, segmentation: Segmentation, params: Params | None = None) -> tuple[Step, ...]:
        """Put another automatic segmentation of the same mesh underneath and do all edits again.

        Parameters
        ----------
        segmentation : Segmentation
        params : Params, optional
            What it was made with; kept in the project file.

        Returns
        -------
        steps : tuple of Step
            The edits that don't apply to it, each with its ``problem``. They stay in the history and
            apply again as soon as a segmentation comes that they fit.
        """
        _check_segmentation(segmentation)
        _check_params(params)
        with self._lock:
            self._history.start_from(_of_mesh(segmentation, self.mesh))
            self._params = params
            self._dismissed.clear()
            self._rejected.clear()
            self._advisor = None
            self._log(Operation(time.time(), "segmentation"), renew=True)
            event = self._event("segmentation", None)
            problems = tuple(step for step in self.history if step.problem)
        self._tell(event)
        return problems

    # --- state ------------------------------------------------------------------------------------

    @property
    def segmentation(self) -> Segmentation:
        """The segmentation as it is now; made on first use after an edit (0.03 s at a million faces)."""
        with self._lock:
            segmentation = self._history.segmentation
            if self._rows_shown:
                ids = self._history.partition.numbering().ids.tolist()
                keep_colors(segmentation, np.array([self._rows_shown.get(i, -1) for i in ids], np.int64))
            return segmentation

    def snapshot(self) -> Snapshot:
        """The present state for a view; costs about 1 ms, however many faces there are."""
        with self._lock:
            return Snapshot.of(self._history.partition, self._revision)

    @property
    def automatic(self) -> Segmentation:
        """The segmentation that the edits start from."""
        with self._lock:
            return self._history.partition.automatic

    @property
    def params(self) -> Params | None:
        """What the automatic segmentation was made with, if known."""
        return self._params

    @property
    def n_segments(self) -> int:
        """Number of segments now."""
        with self._lock:
            segment = self._history.partition.segment
            return int(np.count_nonzero(np.bincount(segment[segment >= 0])))

    @property
    def edits(self) -> list[Edit]:
        """The edits done so far, oldest first, those that don't apply included."""
        with self._lock:
            return _Edits(step.edit for step in self._history.steps)

    @property
    def history(self) -> tuple[Step, ...]:
        """The edits done so far with their times and titles, oldest first."""
        with self._lock:
            return self._history.steps

    @property
    def undone(self) -> tuple[Edit, ...]:
        """What `redo` would do, next one first."""
        with self._lock:
            return self._history.undone

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to take back."""
        return bool(self._history.steps)

    @property
    def can_redo(self) -> bool:
        """Whether there is an edit to do again."""
        return bool(self._history.undone)

    @property
    def revision(self) -> int:
        """Grows with every change."""
        return self._revision

    @property
    def vocabulary(self) -> tuple[str, ...]:
        """Names to choose from; assign another sequence to replace them."""
        return self._vocabulary

    @vocabulary.setter
    def vocabulary(self, names: str | Sequence[str]) -> None:
        checked = chosen_vocabulary(names)
        with self._lock:
            self._vocabulary = checked
            self._log(Operation(time.time(), "vocabulary", names=checked))
            event = self._event("vocabulary", None)
        self._tell(event)

    @property
    def atoms(self) -> Atoms:
        """Pieces that edits move whole; another object after a cut made them finer."""
        with self._lock:
            return self._history.partition.atoms

    @property
    def atom_segments(self) -> IntArray:
        """(n_atoms,) segment of each atom, -1 unlabeled; ids that never change while a segment lives.

        These aren't the labels of `segmentation`, which are numbered by area after every edit; a view
        that colours by them keeps its colours. Costs next to nothing, however many faces there are.
        """
        with self._lock:
            return self._history.partition.segment.copy()

    @property
    def segment_names(self) -> dict[int, str]:
        """Names by the ids of `atom_segments`; segments without a name are left out."""
        with self._lock:
            names = self._history.partition.names
            return FixedDict(names, instead="; write session.relabel(face, 'chair')")

    @property
    def segment_groups(self) -> dict[int, int]:
        """What each segment is a part of, by the ids of `atom_segments`; those of nothing are left out."""
        with self._lock:
            groups = self._history.partition.groups
            return FixedDict(groups, instead="; write session.group(faces, onto_face)")

    def part(self, face: int, level: Level, *, action: Literal["merge", "split"] = "merge") -> BoolArray:
        """(n_atoms,) the atoms that an edit at a face would move; to preview it.

        Parameters
        ----------
        face : int
        level : "dihedral" | "base" | "final"
        action : "merge" | "split"
            At "final" they move different parts: the whole segment, or what it has from one automatic
            segment.

        Raises
        ------
        EditError
            The face belongs to no part of that level.
        """
        if action not in ("merge", "split"):
            raise ValueError(f"action must be 'merge' or 'split', got {action!r:.200}")
        there = Split(face, level)
        with self._lock:
            return self._history.partition.part(there.face, there.level, action=action)

    def suggestions(self, n: int = 10) -> list[Suggestion]:
        """The merges and splits that are most worth looking at, the largest expected gain first.

        From the ensemble alone, without a truth: `do(suggestion.edit)` follows one, `dismiss(suggestion)`
        rejects it. Nothing that a person decided is put in question. Some 20 ms at 1.5 million faces.

        Parameters
        ----------
        n : int
            At most so many.

        Returns
        -------
        list of Suggestion
            Shorter where fewer edits can be expected to help; empty for a segmentation that no ensemble
            made.
        """
        if isinstance(n, bool) or not hasattr(n, "__index__") or int(n) < 0:
            raise ValueError(f"n must be a whole number from 0, got {n!r:.200}")
        with self._lock:
            if self._history.partition.automatic.keys is None:
                return []
            return self._advice().suggest(self._history.partition, int(n), self._dismissed)

    def dismiss(self, suggestion: Suggestion) -> None:
        """No longer make a ``suggestion``, in either direction.

        It may come back once a segment in question is no longer much what it was (half of its faces gone, or
        twice as many), and once another segmentation comes underneath.

        Parameters
        ----------
        suggestion : Suggestion
            One of `suggestions`, for the segments as they are now.
        """
        _check_suggestion(suggestion)
        with self._lock:
            partition, advisor = self._history.partition, self._advice()
            self._dismissed.append(advisor.remember(partition, suggestion, self._dismissed))
            self._log_answer("dismiss", suggestion)

    def propose(self, suggestion: Suggestion) -> None:
        """Keep in the log that a person was shown a ``suggestion``, for studies of what suggestions help.

        The widget does so for each that it shows; who follows it makes the edit the next entry, who rejects
        it a "dismiss". `to_frame` lists them all, with how probable the edit seemed and what was expected.

        Parameters
        ----------
        suggestion : Suggestion
        """
        _check_suggestion(suggestion)
        with self._lock:
            self._log_answer("propose", suggestion)

    def suggest_names(self) -> dict[int, tuple[str, float]]:
        """Names that geometry tells, in the words of the vocabulary, for segments that have none yet.

        What the vocabulary has no word for is left out: ScanNet's twenty have no ceiling.

        Returns
        -------
        names : dict of int to (str, float)
            Label of `segmentation` to name and the probability that it is right, as
            `Segmentation.suggest_names` says.
        """
        with self._lock:
            now, words = self.segmentation, self._vocabulary
        named = {s for s, name in enumerate(now.names) if name}
        offers = now.suggest_names() if now.n_segments else {}
        said = {s: (in_vocabulary(name, words), p) for s, (name, p) in offers.items() if s not in named}
        return {s: offer for s, offer in said.items() if offer[0]}

    def accept_names(self) -> list[Step]:
        """Give all names of `suggest_names`, each an edit of its own; the most probable last.

        Examples
        --------
        >>> import scenewidget as sw
        >>> mesh, truth = sw.datasets.load_room()
        >>> session = sw.Session(mesh, sw.Segmentation(mesh, truth.labels), vocabulary="scannet20")
        >>> sorted({step.edit.name for step in session.accept_names()})
        ['floor', 'wall']
        """
        with self._lock:
            labels = self.segmentation.labels
            offers = sorted(self.suggest_names().items(), key=lambda offer: offer[1][1])
        faces = [int(np.argmax(labels == segment)) for segment, _ in offers]
        return [self.relabel(face, name) for face, (_, (name, _)) in zip(faces, offers)]

    def _log_answer(self, action: Literal["propose", "dismiss"], suggestion: Suggestion) -> None:
        self._log(
            Operation(
                time.time(), action, suggestion.edit, p=float(suggestion.p), gain=float(suggestion.gain)
            )
        )

    def _advice(self) -> Advisor:
        if self._advisor is None:
            self._advisor = Advisor(self._history.partition.automatic)
            for edit in self._rejected:
                again = Suggestion.of(edit)
                self._dismissed.append(
                    self._advisor.remember(self._history.partition, again, self._dismissed)
                )
            self._rejected.clear()
        return self._advisor

    def observe(self, callback: Callable[[Event], None]) -> Callable[[], None]:
        """Call ``callback(event)`` after every change; returns what ends that.

        It is called in the thread that made the change, after the change is complete. What it raises is
        shown on stderr; the change stands, and other observers hear of it.
        """
        return self._observers.add(callback)

    def keep_colors(self, rows: Mapping[int, int]) -> None:
        """Remember in which colours a view shows the segments: exported files have the same.

        Parameters
        ----------
        rows : mapping of int to int
            Row of the palette by the ids of `atom_segments`.
        """
        self._rows_shown = dict(rows)

    @property
    def operations(self) -> tuple[Operation, ...]:
        """The log: all that was done in this session, undo and redo as well, with its time."""
        with self._lock:
            return tuple(self._binding.operations)

    def to_frame(self) -> pd.DataFrame:
        """A row an operation: time (UTC), seconds since the one before, action, edit, faces, level, name.

        Then ``p`` and ``gain`` of suggestions that were shown ("propose") or rejected ("dismiss").

        For studies of how long work takes; nothing leaves the computer.
        """
        with self._lock:
            operations = list(self._binding.operations)
        return operation_table(operations)

    # --- the project file -------------------------------------------------------------------------

    @property
    def path(self) -> Path | None:
        """The project file, None before `save`."""
        return self._binding.path

    @property
    def read_only(self) -> bool:
        """Whether the file belongs to somebody else: edits stay in memory."""
        return self._binding.read_only

    @property
    def file_reason(self) -> str:
        """Why the file can't be written: who works on it, no permission; "" if it can."""
        return self._binding.reason

    @property
    def is_saved(self) -> bool:
        """Whether every operation is on disk, in the file that lies at `path` now."""
        with self._lock:
            return self._binding.is_saved

    @property
    def file_problem(self) -> str:
        """Why the last operation is not on disk: disk full, file deleted or replaced; "" if all is well."""
        with self._lock:
            return self._binding.problem

    def save(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        include_mesh: bool = False,
        overwrite: bool = True,
        anonymous: bool = False,
    ) -> Path:
        """Write the project to a file; from then on every edit is on disk before its call returns.

        Parameters
        ----------
        path : path, optional
            ``.swproj`` by convention. Without one, the file that the session has already: where it was
            deleted or renamed, it is written anew; where another file has taken its place, that stays.
        include_mesh : bool
            Whether the mesh goes in; without it the file holds only its fingerprint and where it was
            loaded from.
        overwrite : bool
            Whether another file of that name may go. Without it, of two sessions that choose one name at
            the same moment one gets it.
        anonymous : bool
            A copy to give away instead: without the times of edits, the seconds that stages took, and the
            names of files that mesh and labels came from. The session goes on in the file that it had.

        Returns
        -------
        Path

        Raises
        ------
        ValueError
            No path, and no file yet; the suffix of a scan or of labels, which `export` writes; or an
            anonymous copy over the session's own file.
        FileExistsError
            Not to ``overwrite``, and there is such a file; or one that is no project.
        OSError
            The file can't be written: disk full, no permission, or another process works on it. The old
            file, if there was one, is untouched, and edits stay in memory.
        """
        flags = {"include_mesh": include_mesh, "overwrite": overwrite, "anonymous": anonymous}
        for name, value in flags.items():
            checked_flag(name, value)
        with self._lock:
            if anonymous:
                copy = self._project(include_mesh).anonymous()
                return self._binding.save_copy(path, copy, overwrite=overwrite)
            written = self._binding.save(path, self._project, include_mesh=include_mesh, overwrite=overwrite)
            event = self._event("file", None)
        self._tell(event)
        return written

    @classmethod
    def open(
        cls, path: str | os.PathLike[str], mesh: Mesh | Any | None = None, *, recover: bool = False
    ) -> Session:
        """The session in a project file, as it was after the last edit, undone ones included.

        Parameters
        ----------
        path : path
        mesh : Mesh, path, …, optional
            The mesh of the project. Without it: the one in the file, or the one that this process has
            loaded already, or the file that it was loaded from, whichever has the right fingerprint.
        recover : bool
            Of a damaged log, keep the operations before the damage instead of refusing the file.

        Returns
        -------
        Session
            Bound to the file. While another process has the file, it is opened read-only, with a
            warning: edits stay in memory then.

        Raises
        ------
        FileNotFoundError
            No such file.
        ProjectError
            Damaged, no project, of a newer version, of another mesh than the one given (the message names
            both), or without any mesh to be found (the message says how to give it). A ValueError.
        """
        place = checked_path(path)
        for last in (False, False, True):
            project = read_project(place, recover=recover)  # nothing is taken before everything fits
            found, source = mesh_of_project(project, place, mesh)
            with blame(place):
                session = cls._from_project(project, found, source)
            try:
                session._binding.take(place, project)
                break
            except FileChangedError:
                if last:
                    raise
        session._log(Operation(time.time(), "open"))
        if session.read_only:
            warnings.warn(
                f"{place.name!r} is open read-only: {session.file_reason}. Edits stay in memory; "
                "save them under another name",
                stacklevel=2,
            )
        return session

    def close(self) -> None:
        """Let go of the project file; the session goes on in memory."""
        with self._lock:
            self._binding.close()
            event = self._event("file", None)
        self._tell(event)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- inside -----------------------------------------------------------------------------------

    @classmethod
    def _from_project(cls, project: Project, mesh: Mesh, source: str) -> Session:
        log = read_log(project.operations)
        session = cls(
            mesh, project.segmentation(mesh), params=project.params, vocabulary=log.vocabulary or NYU40
        )
        session._source = source
        session._history.resume(log)
        session._binding.operations = list(project.operations)
        session._rejected = list(log.rejected)
        return session

    def _project(self, include_mesh: bool) -> Project:
        """All that a file of this session holds now."""
        return Project.of(
            self._history.partition.automatic,
            fingerprint=fingerprint(self.mesh),
            mesh=self.mesh if include_mesh else None,
            source=self._source,
            params=self._params,
            operations=tuple(self._binding.operations),
        )

    def _undo(self) -> tuple[Step, Event]:
        step = self._history.undo()
        self._log(Operation(time.time(), "undo"))
        return step, self._event("undo", step)

    def _redo(self) -> tuple[Step, Event]:
        now = time.time()
        step = self._history.redo(now)
        self._log(Operation(now, "redo"))
        return step, self._event("redo", step)

    def _log(self, operation: Operation, *, renew: bool = False) -> None:
        self._binding.append(operation, self._project, renew=renew)

    def _taken_over(self) -> None:
        self._tell(self._event("file", None))

    def _event(self, kind: EventKind, step: Step | None) -> Event:
        self._revision += 1
        return Event(kind, step, self._revision)

    def _tell(self, event: Event) -> None:
        self._observers.tell(event)


def _check_segmentation(segmentation: Any) -> None:
    if not isinstance(segmentation, Segmentation):
        raise TypeError(
            f"segmentation must be a Segmentation, got {type(segmentation).__name__}; "
            "Segmentation.from_labels(mesh, labels) makes one"
        )


def _check_suggestion(suggestion: Any) -> None:
    if not isinstance(suggestion, Suggestion):
        raise TypeError(f"suggestion must be one of suggestions(), got {type(suggestion).__name__}")


def _check_params(params: Any) -> None:
    if params is not None and not isinstance(params, Params):
        raise TypeError(f"params must be a Params, got {type(params).__name__}; write Params(n_segments=…)")


def _of_mesh(segmentation: Segmentation, mesh: Mesh) -> Segmentation:
    if segmentation.mesh is mesh:
        return segmentation
    theirs, ours = fingerprint(segmentation.mesh), fingerprint(mesh)
    if theirs != ours:
        raise ValueError(f"segmentation is of another mesh: of one with {theirs}, but mesh has {ours}")
    return dataclasses.replace(segmentation, mesh=mesh)
