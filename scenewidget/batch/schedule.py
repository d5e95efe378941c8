"""In which order jobs are done, and what becomes of those during which a process died.

Where several are done at a time, the largest come first, in a window: only so many are handed out at once,
so that a job that ends its process takes no more than its neighbours with it. Those are suspects. When all
others are done each of them, and what was too large for a worker, has the machine for itself. What dies then
is the culprit.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

from scenewidget.batch.job import note_failure
from scenewidget.batch.plan import Job
from scenewidget.batch.pools import Pool
from scenewidget.batch.rows import empty_row, spoken_size

__all__ = ["work_through"]

PATIENCE = 0.25  # seconds between two looks at whether to stop


def work_through(
    jobs: Iterable[Job],
    pool: Pool,
    report: Callable[[Job, dict[str, Any]], None],
    stop: threading.Event,
) -> None:
    """Do all jobs; each is reported once.

    Parameters
    ----------
    jobs : iterable of Job
    pool : Pool
    report : callable (job, row)
    stop : threading.Event
        Once set, nothing more is begun, and what runs is abandoned.

    Examples
    --------
    >>> import threading
    >>> from scenewidget.batch.plan import Job
    >>> from scenewidget.batch.pools import InProcess
    >>> from scenewidget.engine.params import Params
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as out:
    ...     job = Job("a.ply", "no/such/a.ply", out, Params())
    ...     work_through([job], InProcess(), lambda job, row: print(row["status"]), threading.Event())
    failed
    """
    again: dict[str, tuple[Job, dict[str, Any] | None]] = {}

    def first(job: Job, row: dict[str, Any] | None) -> None:
        if row is None or row["status"] == "too large":
            again[job.scan] = (job, row)
        else:
            report(job, row)

    if pool.is_parallel:
        jobs = sorted(jobs, key=lambda job: -job.size)
    _round(jobs, pool, first, stop, window=None)
    if not again or stop.is_set():
        return
    is_larger = pool.enlarge()
    for job, known in again.values():

        def last(job: Job, row: dict[str, Any] | None) -> None:
            report(job, _killed(job, pool) if row is None else row)

        if known is not None and not is_larger:
            report(job, known)
        else:
            _round([job], pool, last, stop, window=1)


def _round(
    jobs: Iterable[Job],
    pool: Pool,
    hear: Callable[[Job, dict[str, Any] | None], None],
    stop: threading.Event,
    window: int | None,
) -> None:
    waiting, n_running = deque(jobs), 0
    while (waiting or n_running) and not stop.is_set():
        while waiting and n_running < (window or pool.window):
            pool.submit(waiting.popleft())
            n_running += 1
        for job, row in pool.collect(PATIENCE):
            n_running -= 1
            hear(job, row)


def _killed(job: Job, pool: Pool) -> dict[str, Any]:
    known = pool.foretold().get(job.scan, {})
    need = known.get("need")
    expected = (
        f"it should take about {spoken_size(need)}" if need else "it died while the file was being read"
    )
    row = empty_row(job.scan) | {
        "status": "killed",
        "faces": known.get("faces"),
        "error": f"its process died, also when nothing else ran: most likely of memory ({expected}); "
        "try it where there is more",
    }
    note_failure(job, row)
    return row
