"""What a project is: an automatic segmentation, the log of all operations on it, and which mesh it is of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from scenewidget.editing.edits import Cut, Edit
from scenewidget.editing.fingerprint import Fingerprint
from scenewidget.editing.partition import KnownCut
from scenewidget.engine.mesh import BoolArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import Segmentation

__all__ = ["Action", "Log", "Operation", "Project", "ProjectError", "Root", "read_log"]

Action = Literal["open", "edit", "undo", "redo", "segmentation", "vocabulary", "propose", "dismiss"]


class ProjectError(ValueError):
    """A project file that is damaged, foreign, too new, or of another mesh.

    Examples
    --------
    >>> issubclass(ProjectError, ValueError)
    True
    """


@dataclass(frozen=True, eq=False)
class Operation:
    """An entry of the log."""

    time: float  # seconds since 1970, UTC
    action: Action
    edit: Edit | None = None  # of "edit", and what "propose" and "dismiss" are about
    cut: KnownCut | None = None  # of a `Cut`: its outcome
    names: tuple[str, ...] = ()  # of "vocabulary"
    p: float = 0.0  # of "propose" and "dismiss": how probable the edit seemed
    gain: float = 0.0  # and what was expected of it


@dataclass(frozen=True, eq=False)
class Log:
    """What a list of operations comes down to."""

    done: list[tuple[Edit, float]] = field(default_factory=list)
    undone: list[Edit] = field(default_factory=list)
    cuts: dict[tuple[Cut, bytes], BoolArray] = field(default_factory=dict)
    vocabulary: tuple[str, ...] = ()
    rejected: list[Edit] = field(default_factory=list)  # suggestions about the segmentation as it is now


def read_log(operations: Iterable[Operation]) -> Log:
    """The edits that are done and undone after some operations.

    Raises
    ------
    ProjectError
        An undo or redo with nothing to undo or redo.
    """
    done: list[tuple[Edit, float]] = []
    undone: list[Edit] = []
    cuts: dict[tuple[Cut, bytes], BoolArray] = {}
    vocabulary: tuple[str, ...] = ()
    rejected: list[Edit] = []
    for operation in operations:
        if operation.action == "edit" and operation.edit is not None:
            done.append((operation.edit, operation.time))
            undone.clear()
            if operation.cut is not None and isinstance(operation.edit, Cut):
                cuts[operation.edit, operation.cut.segment_digest] = operation.cut.is_b
        elif operation.action == "vocabulary":
            vocabulary = operation.names
        elif operation.action == "dismiss" and operation.edit is not None:
            rejected.append(operation.edit)
        elif operation.action == "segmentation":
            rejected.clear()
        elif operation.action == "undo":
            if not done:
                raise ProjectError("the log undoes an edit that was never done")
            undone.append(done.pop()[0])
        elif operation.action == "redo":
            if not undone:
                raise ProjectError("the log redoes an edit that was never undone")
            done.append((undone.pop(), operation.time))
    return Log(done, undone, cuts, vocabulary, rejected)


@dataclass(frozen=True)
class Root:
    """Which state a project file is in: equal roots, equal contents.

    Attributes
    ----------
    n_operations : int
        Length of the log.
    log : bytes
        How the chain of the log's digests ends.
    content : bytes
        Digest of everything beside the log.
    """

    n_operations: int
    log: bytes
    content: bytes


@dataclass(frozen=True, eq=False)
class Project:
    """All that a project file holds."""

    fingerprint: Fingerprint
    labels: npt.NDArray[Any]
    confidence: npt.NDArray[Any]
    levels: Mapping[str, npt.NDArray[Any]]
    names: tuple[str, ...]
    groups: tuple[int, ...]
    keys: npt.NDArray[Any] | None
    timings: Mapping[str, float]
    report: Mapping[str, Any]
    params: Params | None
    mesh: Mesh | None
    source: str  # where the mesh was loaded from, "" if from no file
    operations: tuple[Operation, ...]
    n_lost: int = 0  # operations that a recovery left behind
    root: Root | None = None  # of the file that it was read from
    chain: tuple[bytes, ...] = ()  # digests of that file's log, before the first operation and after each

    @classmethod
    def of(
        cls,
        automatic: Segmentation,
        *,
        fingerprint: Fingerprint,
        mesh: Mesh | None,
        source: str,
        params: Params | None,
        operations: tuple[Operation, ...],
    ) -> Project:
        """The project of a segmentation. Items and the simplified mesh are left out: `segment` makes them."""
        return cls(
            fingerprint=fingerprint,
            labels=automatic.labels,
            confidence=np.asarray(automatic.confidence),
            levels=automatic.levels,
            names=tuple(automatic.names),
            groups=tuple(automatic.groups),
            keys=automatic.keys,
            timings=automatic.timings,
            report=automatic.report,
            params=params,
            mesh=mesh,
            source=source,
            operations=operations,
        )

    def anonymous(self) -> Project:
        """The same without when it was made, how long that took, and which files it came from."""
        steps = tuple(replace(operation, time=0.0) for operation in self.operations)
        return replace(self, operations=steps, timings={}, report={}, source="")

    def segmentation(self, mesh: Mesh) -> Segmentation:
        """The automatic segmentation, on its mesh."""
        return Segmentation(
            mesh,
            self.labels,
            self.confidence,
            levels=dict(self.levels),
            names=self.names,
            groups=self.groups,
            keys=self.keys,
            timings=self.timings,
            report=self.report,
        )
