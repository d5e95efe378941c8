"""An editing session: merge, split, name and cut, with undo and redo, without any widget.

Goes in: a mesh and its segmentation. Comes out: the segmentation as a person corrected it, the log of what
was done, and, once `Session.save` has named a file, every further edit on disk before the call returns.
"""

from __future__ import annotations

import dataclasses
import os
import threading
import time
import warnings
import weakref
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenewidget.editing.edits import Cut, Edit, EditError, Merge, Relabel, Split
from scenewidget.editing.files import checked_path
from scenewidget.editing.fingerprint import fingerprint, living_mesh
from scenewidget.editing.partition import Change, Partition
from scenewidget.editing.project import Operation, Project, ProjectError, read_log
from scenewidget.editing.store import ProjectFile
from scenewidget.editing.suggestions import Dismissal, Suggestion, suggest
from scenewidget.editing.vocabulary import NYU40, chosen_vocabulary
from scenewidget.engine.atoms import Atoms
from scenewidget.engine.checks import checked_whole
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh, MeshError, load_mesh
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import Level, Segmentation

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Event", "Session", "Snapshot", "Step", "apply_edits"]

EventKind = Literal["edit", "undo", "redo", "segmentation", "vocabulary", "file"]


@dataclass(frozen=True)
class Step:
    """One edit of the history.

    Attributes
    ----------
    edit : Merge, Split, Relabel or Cut
    time : float
        Seconds since 1970 (UTC) when it was made.
    problem : str
        Why it doesn't apply to the present segmentation; "" if it does.
    n_faces : int
        Faces that it moved.
    """

    edit: Edit
    time: float
    problem: str = ""
    n_faces: int = 0

    @property
    def title(self) -> str:
        """What a history shows: "Merge 3 parts", "Name 'chair'"."""
        return self.edit.title


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A session at one moment, as tables over atoms: all that a view needs, small at any number of faces.

    Attributes
    ----------
    revision : int
    automatic : Segmentation
        What the edits start from; its levels are the parts to point at.
    atoms : Atoms
    parts : dict of level to (n_atoms,) int
    labels : (n_atoms,) int32
        As in `Session.segmentation`, -1 unlabeled.
    ids : (n_segments,) int
        What stays of each segment over edits, while labels are numbered by area after each.
    names : tuple of str
        By label, "" where a segment has none.
    confidence : (n_segments,) float64
        Mean over the area; 1 where a person decided.
    atom_confidence : (n_atoms,) float64
    """

    revision: int
    automatic: Segmentation
    atoms: Atoms
    parts: dict[str, IntArray]
    labels: IntArray
    ids: IntArray
    names: tuple[str, ...]
    confidence: FloatArray
    atom_confidence: FloatArray


@dataclass(frozen=True)
class Event:
    """What observers of a session are told.

    Attributes
    ----------
    kind : str
        "edit", "undo", "redo", "segmentation" (another one underneath), "vocabulary", or "file" (saved,
        opened, closed, or trouble with the file).
    step : Step or None
        The edit in question.
    revision : int
        Grows with every event: of two events the larger one tells of the newer state.
    """

    kind: EventKind
    step: Step | None
    revision: int


def apply_edits(segmentation: Segmentation, edits: Iterable[Edit]) -> Segmentation:
    """The segmentation after some edits, in their order.

    Parameters
    ----------
    segmentation : Segmentation
    edits : iterable of Merge, Split, Relabel, Cut

    Returns
    -------
    Segmentation
        ``report["edits that do not apply"]`` lists those that can't be done on this segmentation, as
        (position, edit, reason); a warning says so too.
    """
    partition = Partition(segmentation)
    skipped: list[tuple[int, Edit, str]] = []
    for position, edit in enumerate(edits):
        try:
            partition.apply(edit)
        except EditError as error:
            skipped.append((position, edit, str(error)))
    result = partition.segmentation()
    if not skipped:
        return result
    warnings.warn(
        f"{len(skipped)} edits do not apply to this segmentation; report['edits that do not apply'] lists "
        f"them. The first: {skipped[0][2]}",
        stacklevel=2,
    )
    return dataclasses.replace(result, report={**result.report, "edits that do not apply": tuple(skipped)})


class Session:
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
    """

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
        self.mesh: Mesh = load_mesh(mesh)
        self._source = self.mesh.source
        self._params = params
        self._vocabulary = chosen_vocabulary(vocabulary)
        self._lock = threading.RLock()
        self._partition = Partition(_of_mesh(segmentation, self.mesh))
        self._done: list[tuple[Step, Change | None]] = []
        self._undone: list[Edit] = []
        self._operations: list[Operation] = [Operation(time.time(), "open")]
        if self._vocabulary != NYU40:
            self._operations.append(Operation(time.time(), "vocabulary", names=self._vocabulary))
        self._current: Segmentation | None = None
        self._revision = 0
        self._dismissed: list[Dismissal] = []
        self._observers: list[Callable[[Event], None]] = []
        self._file: ProjectFile | None = None
        self._n_durable = 0
        self._file_problem = ""
        self._must_renew = False  # whether the file lacks another automatic segmentation

    def __repr__(self) -> str:
        place = f", {self.path.name!r}" if self.path is not None else ""
        return (
            f"Session({self.mesh.n_faces} faces, {self.n_segments} segments, {len(self._done)} edits{place})"
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
            faces, cut = self._partition.divide(Cut(face_a, face_b))
        return faces[cut.is_b]

    def do(self, edit: Edit) -> Step:
        """Do an edit made elsewhere; what was undone before is forgotten."""
        if not isinstance(edit, (Merge, Split, Relabel, Cut)):
            raise TypeError(f"edit must be a Merge, Split, Relabel or Cut, got {type(edit).__name__}")
        with self._lock:
            now = time.time()
            change = self._partition.apply(edit)
            step = Step(edit, now, n_faces=change.n_faces)
            self._done.append((step, change))
            self._undone.clear()
            self._log(Operation(now, "edit", edit=edit, cut=change.cut))
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
            most = len(self._done) + len(self._undone)
            if not 0 <= n_edits <= most:
                raise ValueError(f"n_edits must lie in 0..{most}, got {n_edits}")
            events = [self._undo()[1] for _ in range(len(self._done) - n_edits)]
            events += [self._redo()[1] for _ in range(n_edits - len(self._done))]
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
            partition = Partition(_of_mesh(segmentation, self.mesh), self._partition.known_cuts)
            self._partition, self._params = partition, params
            self._dismissed.clear()
            done = [step for step, _ in self._done]
            self._done = []
            for step in done:
                self._replay(step.edit, step.time)
            operation = Operation(time.time(), "segmentation")
            self._log(operation, renew=True)
            event = self._event("segmentation", None)
            problems = tuple(step for step in self.history if step.problem)
        self._tell(event)
        return problems

    # --- state ------------------------------------------------------------------------------------

    @property
    def segmentation(self) -> Segmentation:
        """The segmentation as it is now; made on first use after an edit (0.03 s at a million faces)."""
        with self._lock:
            if self._current is None:
                self._current = self._partition.segmentation()
            return self._current

    def snapshot(self) -> Snapshot:
        """The present state for a view; costs about 1 ms, however many faces there are."""
        with self._lock:
            partition = self._partition
            numbering = partition.numbering()
            return Snapshot(
                self._revision,
                partition.automatic,
                partition.atoms,
                partition.parts,
                numbering.labels,
                numbering.ids,
                numbering.names,
                numbering.confidence,
                numbering.atom_confidence,
            )

    @property
    def automatic(self) -> Segmentation:
        """The segmentation that the edits start from."""
        with self._lock:
            return self._partition.automatic

    @property
    def params(self) -> Params | None:
        """What the automatic segmentation was made with, if known."""
        return self._params

    @property
    def n_segments(self) -> int:
        """Number of segments now."""
        with self._lock:
            segment = self._partition.segment
            return int(np.count_nonzero(np.bincount(segment[segment >= 0])))

    @property
    def edits(self) -> list[Edit]:
        """The edits done so far, oldest first, those that don't apply included."""
        with self._lock:
            return [step.edit for step, _ in self._done]

    @property
    def history(self) -> tuple[Step, ...]:
        """The edits done so far with their times and titles, oldest first."""
        with self._lock:
            return tuple(step for step, _ in self._done)

    @property
    def undone(self) -> tuple[Edit, ...]:
        """What `redo` would do, next one first."""
        with self._lock:
            return tuple(reversed(self._undone))

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to take back."""
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        """Whether there is an edit to do again."""
        return bool(self._undone)

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
            return self._partition.atoms

    @property
    def atom_segments(self) -> IntArray:
        """(n_atoms,) segment of each atom, -1 unlabeled; ids that never change while a segment lives.

        These aren't the labels of `segmentation`, which are numbered by area after every edit; a view
        that colours by them keeps its colours. Costs next to nothing, however many faces there are.
        """
        with self._lock:
            return self._partition.segment.copy()

    @property
    def segment_names(self) -> dict[int, str]:
        """Names by the ids of `atom_segments`; segments without a name are left out."""
        with self._lock:
            return dict(self._partition.names)

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
            return self._partition.part(there.face, there.level, action=action)

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
            if self._partition.automatic.keys is None:
                return []
            return suggest(self._partition, int(n), self._dismissed)

    def dismiss(self, suggestion: Suggestion) -> None:
        """No longer make a ``suggestion``, in either direction.

        It may come back once a segment in question is no longer much what it was (half of its faces gone, or
        twice as many), and once another segmentation comes underneath.

        Parameters
        ----------
        suggestion : Suggestion
            One of `suggestions`, for the segments as they are now.
        """
        if not isinstance(suggestion, Suggestion):
            raise TypeError(f"suggestion must be one of suggestions(), got {type(suggestion).__name__}")
        with self._lock:
            self._dismissed.append(Dismissal.of(self._partition, suggestion))

    def observe(self, callback: Callable[[Event], None]) -> Callable[[], None]:
        """Call ``callback(event)`` after every change; returns what ends that.

        It is called in the thread that made the change, after the change is complete.
        """
        if not callable(callback):
            raise TypeError(f"callback must be callable as callback(event), got {type(callback).__name__}")
        with self._lock:
            self._observers.append(callback)

        def stop() -> None:
            with self._lock:
                if callback in self._observers:
                    self._observers.remove(callback)

        return stop

    def to_frame(self) -> pd.DataFrame:
        """A row an operation: time (UTC), seconds since the one before, action, edit, faces, level, name.

        For studies of how long work takes; nothing leaves the computer.
        """
        import pandas as pd

        with self._lock:
            operations = list(self._operations)
        rows = []
        for operation in operations:
            edit = operation.edit
            faces: tuple[int, ...] = ()
            if isinstance(edit, Merge):
                faces = (*edit.faces, edit.onto_face)
            elif isinstance(edit, Cut):
                faces = (edit.face_a, edit.face_b)
            elif edit is not None:
                faces = (edit.face,)
            rows.append(
                {
                    "time": pd.Timestamp(operation.time, unit="s", tz="UTC"),
                    "action": operation.action,
                    "edit": "" if edit is None else type(edit).__name__.lower(),
                    "faces": faces,
                    "level": getattr(edit, "level", ""),
                    "name": getattr(edit, "name", ""),
                }
            )
        frame = pd.DataFrame(rows)
        frame.insert(1, "seconds", frame["time"].diff().dt.total_seconds().fillna(0.0))
        return frame

    # --- the project file -------------------------------------------------------------------------

    @property
    def path(self) -> Path | None:
        """The project file, None before `save`."""
        return None if self._file is None else self._file.path

    @property
    def read_only(self) -> bool:
        """Whether the file belongs to somebody else: edits stay in memory."""
        return self._file is not None and self._file.read_only

    @property
    def file_reason(self) -> str:
        """Why the file can't be written: who works on it, no permission; "" if it can."""
        return "" if self._file is None else self._file.read_only_reason

    @property
    def is_saved(self) -> bool:
        """Whether every operation is on disk."""
        with self._lock:
            is_complete = self._n_durable == len(self._operations)
            return self._file is not None and is_complete and not self._file_problem

    @property
    def file_problem(self) -> str:
        """Why the last operation is not on disk: disk full, read-only; "" if all is well."""
        return self._file_problem

    def save(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        include_mesh: bool = False,
        overwrite: bool = True,
    ) -> Path:
        """Write the project to a file; from then on every edit is on disk before its call returns.

        Parameters
        ----------
        path : path, optional
            ``.swproj`` by convention. Without one, the file that the session has already.
        include_mesh : bool
            Whether the mesh goes in; without it the file holds only its fingerprint and where it was
            loaded from.
        overwrite : bool
            Whether another file of that name may go. Without it, of two sessions that choose one name at
            the same moment one gets it.

        Returns
        -------
        Path

        Raises
        ------
        ValueError
            No path, and no file yet.
        FileExistsError
            Not to ``overwrite``, and there is such a file.
        OSError
            The file can't be written: disk full, no permission, or another process works on it. The old
            file, if there was one, is untouched, and edits stay in memory.
        """
        with self._lock:
            if path is None and self._file is None:
                raise ValueError("the session has no file yet: save('room.swproj')")
            target = self._file.path if path is None and self._file is not None else checked_path(path)
            same = self._file is not None and self._file.is_at(target)
            if same and self._file is not None and not self._file.read_only and not include_mesh:
                self._flush()
                if self._file_problem:
                    raise OSError(self._file_problem)
                self._file.checkpoint()
            else:
                file = ProjectFile.write(
                    target, self._project(include_mesh), replaces=self._file, overwrite=overwrite
                )
                if self._file is not None and self._file is not file:
                    self._file.close()
                self._file, self._n_durable, self._file_problem = file, len(self._operations), ""
                file.on_takeover = weakref.WeakMethod(self._taken_over)
            event = self._event("file", None)
            written = self._file.path
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
        file = ProjectFile.open(checked_path(path))
        try:
            project = file.load(recover=recover)
            if mesh is not None:
                mesh = load_mesh(mesh)
                source = mesh.source
                if fingerprint(mesh) != project.fingerprint:
                    raise ProjectError(
                        f"{file.path.name!r} belongs to another mesh: it was made on one of "
                        f"{project.fingerprint}, but the mesh given has {fingerprint(mesh)}"
                    )
            else:
                mesh, source = _find_mesh(project, file.path)
            session = cls._from_project(project, mesh, source or project.source)
            session._file = file
            session._n_durable = len(session._operations)
            if recover and project.n_lost and not file.read_only:
                session._file = ProjectFile.write(
                    file.path, session._project(project.mesh is not None), replaces=file
                )
            session._file.on_takeover = weakref.WeakMethod(session._taken_over)
            session._log(Operation(time.time(), "open"))
        except BaseException:
            file.close()
            raise
        if file.read_only:
            warnings.warn(
                f"{file.path.name!r} is open read-only: {file.read_only_reason}. Edits stay in memory; "
                "save them under another name",
                stacklevel=2,
            )
        return session

    def close(self) -> None:
        """Let go of the project file; the session goes on in memory."""
        with self._lock:
            if self._file is not None:
                self._file.close()
            self._file, self._n_durable, self._file_problem = None, 0, ""
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
        session._partition.known_cuts.update(log.cuts)
        for edit, when in log.done:
            session._replay(edit, when)
        session._undone = list(log.undone)
        session._operations = list(project.operations)
        session._current = None
        return session

    def _project(self, include_mesh: bool) -> Project:
        return Project.of(
            self._partition.automatic,
            fingerprint=fingerprint(self.mesh),
            mesh=self.mesh if include_mesh else None,
            source=self._source,
            params=self._params,
            operations=tuple(self._operations),
        )

    def _undo(self) -> tuple[Step, Event]:
        if not self._done:
            raise EditError("there is nothing to undo")
        step, change = self._done.pop()
        if change is not None:
            self._partition.revert(change)
        self._undone.append(step.edit)
        self._log(Operation(time.time(), "undo"))
        return step, self._event("undo", step)

    def _redo(self) -> tuple[Step, Event]:
        if not self._undone:
            raise EditError("there is nothing to redo")
        now = time.time()
        step = self._replay(self._undone.pop(), now)
        self._log(Operation(now, "redo"))
        return step, self._event("redo", step)

    def _replay(self, edit: Edit, when: float) -> Step:
        try:
            change = self._partition.apply(edit)
        except EditError as error:
            self._done.append((Step(edit, when, problem=str(error)), None))
        else:
            self._done.append((Step(edit, when, n_faces=change.n_faces), change))
        return self._done[-1][0]

    def _log(self, operation: Operation, *, renew: bool = False) -> None:
        self._operations.append(operation)
        self._flush(renew=renew)

    def _flush(self, *, renew: bool = False) -> None:
        """Bring what is not yet on disk to the disk; trouble is told, not raised: the edit is done."""
        if self._file is None or self._file.read_only:
            return
        try:
            self._file.append(
                self._operations[self._n_durable :],
                self._project(False) if renew or self._must_renew else None,
            )
        except OSError as error:
            self._must_renew = self._must_renew or renew
            if str(error) != self._file_problem:
                warnings.warn(f"{error}. The edit is done, but only in memory", stacklevel=5)
            self._file_problem = str(error)
        else:
            self._n_durable, self._file_problem, self._must_renew = len(self._operations), "", False

    def _taken_over(self) -> None:
        self._file_problem = "a newer session has taken the file over"
        self._tell(self._event("file", None))

    def _event(self, kind: EventKind, step: Step | None) -> Event:
        self._revision += 1
        if kind not in ("file", "vocabulary"):
            self._current = None
        return Event(kind, step, self._revision)

    def _tell(self, event: Event) -> None:
        for callback in list(self._observers):
            callback(event)


def _check_segmentation(segmentation: Any) -> None:
    if not isinstance(segmentation, Segmentation):
        raise TypeError(
            f"segmentation must be a Segmentation, got {type(segmentation).__name__}; "
            "Segmentation.from_labels(mesh, labels) makes one"
        )


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


def _find_mesh(project: Project, path: Path) -> tuple[Mesh, str]:
    if project.mesh is not None:
        return project.mesh, ""
    living = living_mesh(project.fingerprint)
    if living is not None:
        return living, ""
    how = f"give it: Session.open({path.name!r}, mesh='scan.ply')"
    if not project.source:
        raise ProjectError(f"{path.name!r} does not hold the mesh ({project.fingerprint}); {how}")
    for place in (path.parent / Path(project.source).name, Path(project.source)):
        # a network path of a file from somebody else could send credentials to a stranger
        if str(place).startswith(("\\\\", "//")) or not place.is_file():
            continue
        try:
            mesh = load_mesh(place)
        except (MeshError, OSError):
            continue
        if fingerprint(mesh) == project.fingerprint:
            return mesh, str(place)
    raise ProjectError(
        f"{path.name!r} does not hold the mesh ({project.fingerprint}), and {project.source!r} is not there "
        f"any more or another one; {how}"
    )
