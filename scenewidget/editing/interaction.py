"""What a correction by hand took: a log that any tool can write, and a comparison of such logs.

Goes in: a session and the truth. Comes out: a table of time, operation, and the errors after each. Its
columns are plain enough that another tool's log, brought into the same form, can be put beside it: the
comparison that the thesis misses in the literature (Küçükdemir 2020, chapter 5).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from scenewidget.editing.edits import Edit
from scenewidget.editing.session import Session
from scenewidget.engine.mesh import IntArray
from scenewidget.engine.segmentation import Segmentation
from scenewidget.metrics import global_consistency_error, local_consistency_error, rand_index_error

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["COLUMNS", "compare_interactions", "interaction_log"]

ERRORS = {
    "rand_index_error": rand_index_error,
    "global_consistency_error": global_consistency_error,
    "local_consistency_error": local_consistency_error,
}
COLUMNS = ("seconds", "operation", *ERRORS, "n_segments")


def interaction_log(
    session: Session, truth: Segmentation | IntArray, *, pace: Callable[[Edit | None], float] | None = None
) -> pd.DataFrame:
    """Time, operation, and errors after each, from the start of a session to now.

    ``log.to_csv(path, index=False)`` keeps it; `compare_interactions` takes such files too.

    Parameters
    ----------
    session : Session
        Its log is replayed on its automatic segmentation, undone edits included.
    truth : Segmentation or (n_faces,) int
        Faces with -1 don't count, nor do those that the session leaves unlabeled.
    pace : callable, optional
        ``pace(edit)`` seconds for each operation, None for undo and redo, in place of the clock: for
        simulated annotators, whose clock is the computer's.

    Returns
    -------
    log : pandas.DataFrame
        A row for the start and one for each operation. ``seconds`` since the start; ``operation``: "start",
        "merge", "split", "cut", "relabel", "undo", "redo"; ``rand_index_error``,
        ``global_consistency_error``, ``local_consistency_error`` by face count; ``n_segments``.

    Raises
    ------
    ValueError
        The truth is of another mesh.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> from scenewidget.editing import interaction_log
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> session = sw.Session(mesh, sw.Segmentation.from_labels(mesh, [0, 0, 1, 1, 2, 2, 2, 2]))
    >>> _ = session.merge(0, onto_face=2)
    >>> log = interaction_log(session, [0, 0, 0, 0, 1, 1, 1, 1], pace=lambda edit: 4.0)
    >>> log[["seconds", "operation", "rand_index_error", "n_segments"]].round(3)
       seconds operation  rand_index_error  n_segments
    0      0.0     start             0.143           3
    1      4.0     merge             0.000           2
    """
    import pandas as pd

    actual = np.asarray(truth.labels if isinstance(truth, Segmentation) else truth)
    if actual.dtype.kind not in "iu" or actual.shape != (session.mesh.n_faces,):
        raise ValueError(
            f"truth must have a whole number for each face of the mesh: ({session.mesh.n_faces},), "
            f"got {actual.shape} {actual.dtype}"
        )
    operations = session.operations
    replay = Session(session.mesh, session.automatic)
    rows = [_row(0.0, "start", replay, actual)]
    start, passed = operations[0].time if operations else 0.0, 0.0
    for operation in operations:
        if operation.action == "edit" and operation.edit is not None:
            replay.do(operation.edit)
        elif operation.action == "undo":
            replay.undo()
        elif operation.action == "redo":
            replay.redo()
        else:
            continue
        passed = operation.time - start if pace is None else passed + pace(operation.edit)
        name = type(operation.edit).__name__.lower() if operation.edit else operation.action
        rows.append(_row(passed, name, replay, actual))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def compare_interactions(
    logs: Mapping[str, pd.DataFrame | str | os.PathLike[str]], *, target: float = 0.03
) -> pd.DataFrame:
    """How tools or people fared, a row each.

    Parameters
    ----------
    logs : mapping of name to table or path of a CSV file
        With the columns of `interaction_log`; of the errors only ``rand_index_error`` is needed.
    target : float
        1 − RI that counts as done.

    Returns
    -------
    table : pandas.DataFrame
        Index "log". ``operations``; ``taken_back``, the undos among them; ``seconds``; ``first_error`` and
        ``last_error``, 1 − RI; ``operations_to_target`` and ``seconds_to_target``, nan where it was not
        reached; ``mean_error``, over time: what one would have had by stopping at any moment.

    Raises
    ------
    ValueError
        A log without the columns, without rows, or whose time runs backward.

    Examples
    --------
    >>> import pandas as pd
    >>> from scenewidget.editing import compare_interactions
    >>> log = pd.DataFrame(
    ...     {"seconds": [0, 4], "operation": ["start", "merge"], "rand_index_error": [0.2, 0.01]}
    ... )
    >>> compare_interactions({"mine": log})[["operations", "seconds_to_target", "mean_error"]]
          operations  seconds_to_target  mean_error
    log
    mine           1                4.0         0.2
    """
    import pandas as pd

    if not isinstance(logs, Mapping) or not logs:
        raise ValueError(f"logs must map names to logs, such as {{'mine': log}}, got {logs!r}")
    rows = {name: _summary(_checked_log(name, log), target) for name, log in logs.items()}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("log")


def _row(seconds: float, operation: str, session: Session, truth: IntArray) -> list[Any]:
    labels = session.segmentation.labels
    errors = [metric(labels, truth) for metric in ERRORS.values()]
    return [seconds, operation, *errors, session.segmentation.n_segments]


def _summary(log: pd.DataFrame, target: float) -> dict[str, float]:
    seconds = log["seconds"].to_numpy(dtype=float)
    error = log["rand_index_error"].to_numpy(dtype=float)
    done = np.flatnonzero(error <= target)
    total = seconds[-1] - seconds[0]
    return {
        "operations": len(log) - 1,
        "taken_back": int((log["operation"] == "undo").sum()),
        "seconds": float(total),
        "first_error": float(error[0]),
        "last_error": float(error[-1]),
        "operations_to_target": float(done[0]) if len(done) else np.nan,
        "seconds_to_target": float(seconds[done[0]] - seconds[0]) if len(done) else np.nan,
        "mean_error": float((error[:-1] * np.diff(seconds)).sum() / total) if total > 0 else float(error[-1]),
    }


def _checked_log(name: str, log: Any) -> pd.DataFrame:
    import pandas as pd

    table = log if isinstance(log, pd.DataFrame) else pd.read_csv(log)
    missing = [column for column in COLUMNS[:3] if column not in table]
    if missing:
        raise ValueError(
            f"logs[{name!r}] has no column {missing[0]!r}; it needs {', '.join(COLUMNS[:3])}, a row for the "
            "start and one for each operation"
        )
    if len(table) == 0:
        raise ValueError(f"logs[{name!r}] has no rows; the first is the start, before any operation")
    if (np.diff(table["seconds"]) < 0).any():
        raise ValueError(f"logs[{name!r}] has seconds that run backward; they count from the start")
    return table
