"""What was done and undone over a segmentation, in memory: edits, their outcomes, replay.

Goes in: the automatic segmentation and edits. Come out: steps, and the partition as they leave it. No file,
no thread and no observer is known here; `scenewidget.editing.session` adds those.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenewidget.editing.edits import Cut, Edit, EditError, Group, Merge, Paint, kind_of
from scenewidget.editing.partition import Change, KnownCut, Partition
from scenewidget.editing.project import Log, Operation
from scenewidget.engine.segmentation import Segmentation

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["History", "Step", "apply_edits", "operation_table"]

MOST_LISTED = 1000  # painted faces in a row of the table


@dataclass(frozen=True)
class Step:
    """One edit of the history.

    Attributes
    ----------
    edit : Edit
    time : float
        Seconds since 1970 (UTC) when it was made.
    problem : str
        Why it doesn't apply to the present segmentation; "" if it does.
    n_faces : int
        Faces that it moved.

    Examples
    --------
    >>> from scenewidget.editing import Relabel
    >>> Step(Relabel(0, "chair"), time=0.0).title
    "Name 'chair'"
    """

    edit: Edit
    time: float
    problem: str = ""
    n_faces: int = 0

    @property
    def title(self) -> str:
        """What a history shows: "Merge 3 parts", "Name 'chair'"."""
        return self.edit.title


def apply_edits(segmentation: Segmentation, edits: Iterable[Edit]) -> Segmentation:
    """The segmentation after some edits, in their order.

    Parameters
    ----------
    segmentation : Segmentation
    edits : iterable of Edit
        Merge, Split, Relabel, Cut, Paint, Slice, …

    Returns
    -------
    Segmentation
        ``report["edits that do not apply"]`` lists those that can't be done on this segmentation, as
        (position, edit, reason); a warning says so too.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.editing import Merge, apply_edits
    >>> mesh = sw.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 1])
    >>> apply_edits(seg, [Merge(1, onto_face=0)]).labels
    array([0, 0], dtype=int32)
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


class History:
    """Edits done and undone over one partition.

    Parameters
    ----------
    automatic : Segmentation
        What the edits start from.

    Attributes
    ----------
    partition : Partition
        As the edits done leave it.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from scenewidget.editing import Merge
    >>> history = History(seg)
    >>> step, _ = history.do(Merge(0, onto_face=7), when=0.0)
    >>> history.segmentation.n_segments
    1
    >>> history.undo().title
    'Merge'
    >>> history.segmentation is seg
    True
    """

    def __init__(self, automatic: Segmentation) -> None:
        self.partition = Partition(automatic)
        self._done: list[tuple[Step, Change | None]] = []  # no change where an edit doesn't apply
        self._undone: list[Edit] = []  # the one undone last comes last
        self._segmentation: Segmentation | None = None

    @property
    def steps(self) -> tuple[Step, ...]:
        """The edits done, oldest first, those that don't apply included."""
        return tuple(step for step, _ in self._done)

    @property
    def undone(self) -> tuple[Edit, ...]:
        """What `redo` would do, next one first."""
        return tuple(reversed(self._undone))

    @property
    def segmentation(self) -> Segmentation:
        """The segmentation as it is now; made on first use after a change."""
        if self._segmentation is None:
            self._segmentation = self.partition.segmentation()
        return self._segmentation

    def do(self, edit: Edit, when: float) -> tuple[Step, KnownCut | None]:
        """Do an edit and forget what was undone; the step, and the outcome if it is a cut.

        Raises
        ------
        EditError
            It can't be done; nothing has changed.
        """
        change = self.partition.apply(edit)
        step = Step(edit, when, n_faces=change.n_faces)
        self._done.append((step, change))
        self._undone.clear()
        self._segmentation = None
        return step, change.cut

    def undo(self) -> Step:
        """Take the last edit back.

        Raises
        ------
        EditError
            There is none.
        """
        if not self._done:
            raise EditError("there is nothing to undo")
        step, change = self._done.pop()
        if change is not None:
            self.partition.revert(change)
        self._undone.append(step.edit)
        self._segmentation = None
        return step

    def redo(self, when: float) -> Step:
        """Do the edit again that was undone last.

        Raises
        ------
        EditError
            There is none.
        """
        if not self._undone:
            raise EditError("there is nothing to redo")
        return self._replay(self._undone.pop(), when)

    def resume(self, log: Log) -> None:
        """Do the edits of a project file again; its cuts need not be computed."""
        self.partition.known_cuts.update(log.cuts)
        for edit, when in log.done:
            self._replay(edit, when)
        self._undone = list(log.undone)

    def start_from(self, automatic: Segmentation) -> None:
        """Do all edits again over another automatic segmentation; cuts that fit need not be computed."""
        self.partition = Partition(automatic, self.partition.known_cuts)
        done, self._done = self._done, []
        self._segmentation = None
        for step, _ in done:
            self._replay(step.edit, step.time)

    def _replay(self, edit: Edit, when: float) -> Step:
        """Do an edit that was done before; one that doesn't apply any more stays, with its reason."""
        self._segmentation = None
        try:
            change = self.partition.apply(edit)
        except ValueError as error:  # an EditError, or a level that this segmentation lacks
            self._done.append((Step(edit, when, problem=str(error)), None))
        else:
            self._done.append((Step(edit, when, n_faces=change.n_faces), change))
        return self._done[-1][0]


def operation_table(operations: Iterable[Operation]) -> pd.DataFrame:
    """A row an operation of a log, as `Session.to_frame` describes it.

    Examples
    --------
    >>> from scenewidget.editing import Merge
    >>> operations = [Operation(0.0, "open"), Operation(2.5, "edit", edit=Merge(0, onto_face=7))]
    >>> operation_table(operations)[["seconds", "action", "edit", "faces"]]
       seconds action   edit   faces
    0      0.0   open             ()
    1      2.5   edit  merge  (0, 7)
    """
    import pandas as pd

    rows = [
        {
            "time": pd.Timestamp(operation.time, unit="s", tz="UTC"),
            "action": operation.action,
            "edit": "" if operation.edit is None else kind_of(operation.edit),
            "faces": _faces_named(operation.edit),
            "level": getattr(operation.edit, "level", ""),
            "name": getattr(operation.edit, "name", ""),
            "p": operation.p if operation.action in ("propose", "dismiss") else math.nan,
            "gain": operation.gain if operation.action in ("propose", "dismiss") else math.nan,
        }
        for operation in operations
    ]
    frame = pd.DataFrame(rows)
    frame.insert(1, "seconds", frame["time"].diff().dt.total_seconds().fillna(0.0))
    return frame


def _faces_named(edit: Edit | None) -> tuple[int, ...]:
    """Faces that an edit names; of those that were painted the first so many."""
    if edit is None:
        return ()
    if isinstance(edit, Merge):
        return (*edit.faces, edit.onto_face)
    if isinstance(edit, Cut):
        return edit.face_a, edit.face_b
    if isinstance(edit, (Paint, Group)):
        onto = () if edit.onto_face is None else (edit.onto_face,)
        return (*itertools.islice(edit.faces, MOST_LISTED), *onto)
    return (edit.face,)
