"""Who does the jobs: this process, one after the other, or the workers of a Dask cluster.

Nothing of a scheduler is written here. A cluster of our own is Dask's scheduler in this process and its
worker command as processes beside it, so that a script needs no guard around its main part; any other
cluster is used as it is.
"""

from __future__ import annotations

import contextlib
import importlib.util
import math
import os
import queue
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import uuid
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from scenewidget.batch.clients import ANSWER, check_where, connected, new_client, patience_with
from scenewidget.batch.job import run_job, sweep_up
from scenewidget.batch.plan import Job
from scenewidget.engine.threads import KNOB, n_threads

__all__ = ["DaskPool", "InProcess", "OwnWorkers", "Pool", "on_worker", "open_pool"]

Row = dict[str, Any]
ROOM = (
    2_000_000_000  # bytes of memory for each of our own workers, where nobody says how many there should be
)
SHARE = 0.9  # of the memory is for workers
RESTARTS = 20  # of the command that keeps our workers, before we give up
TOPIC = "scenewidget"
DASHBOARD = 8787
NOTICE = 3.0  # seconds without a worker of somebody else's cluster until we say so


class Pool(Protocol):
    """Does jobs. A row comes back for each, or None where the process that did it has died."""

    is_parallel: bool  # whether several jobs are done at a time

    @property
    def window(self) -> int:
        """So many jobs may wait or run at a time."""
        ...

    def submit(self, job: Job) -> None:
        """Begin a job."""
        ...

    def collect(self, seconds: float) -> list[tuple[Job, Row | None]]:
        """What has ended, after at most so many seconds."""
        ...

    def enlarge(self) -> bool:
        """Give one job all the memory there is; False if that can't be done or is so already."""
        ...

    def foretold(self) -> dict[str, Row]:
        """What jobs told of themselves once they had read their scan."""
        ...

    def close(self) -> None:
        """Let go; what is being done is abandoned."""
        ...


class InProcess:
    """Does jobs in this process, one after the other; needs no Dask.

    Parameters
    ----------
    tell : callable (line), optional
        Hears every step of every scan.

    Examples
    --------
    >>> from scenewidget.batch.plan import Job
    >>> from scenewidget.engine.params import Params
    >>> pool = InProcess()
    >>> with tempfile.TemporaryDirectory() as out:
    ...     pool.submit(Job("a.ply", "no/such/a.ply", out, Params()))
    >>> [(job.scan, row["status"]) for job, row in pool.collect(0.0)]
    [('a.ply', 'failed')]
    """

    is_parallel = False
    window = 1

    def __init__(self, tell: Callable[[str], None] | None = None) -> None:
        self._tell = tell
        self._ended: list[tuple[Job, Row | None]] = []

    def submit(self, job: Job) -> None:
        """Do a job."""
        self._ended.append((job, run_job(job, tell=self._tell)))

    def collect(self, seconds: float) -> list[tuple[Job, Row | None]]:
        """What has been done; ``seconds`` are not needed."""
        ended, self._ended = self._ended, []
        return ended

    def enlarge(self) -> bool:
        """Nothing to enlarge."""
        return False

    def foretold(self) -> dict[str, Row]:
        """Nothing: who dies here tells no more."""
        return {}

    def close(self) -> None:
        """Nothing to let go."""


def on_worker(job: Job) -> Row:
    """Do a job in the process of a Dask worker, within its memory.

    Parameters
    ----------
    job : Job

    Examples
    --------
    >>> from scenewidget.batch.plan import Job
    >>> from scenewidget.engine.params import Params
    >>> with tempfile.TemporaryDirectory() as out:
    ...     on_worker(Job("a.ply", "no/such/a.ply", out, Params()))["status"]
    'failed'
    """
    from distributed import get_worker

    try:
        worker = get_worker()
    except ValueError:  # not in one
        return run_job(job)
    os.environ.setdefault(KNOB, "1")  # a worker has as many threads as it does jobs
    limit = worker.memory_manager.memory_limit
    return run_job(
        job,
        limit=None if limit is None else int(limit) // max(1, worker.state.nthreads),
        foretell=lambda known: worker.log_event(TOPIC, known),
    )


class DaskPool:
    """Does jobs on the workers of a Dask cluster.

    Parameters
    ----------
    client : distributed.Client
    workers : OwnWorkers, optional
        Ours to stop, restart and enlarge.
    task : callable (job) -> row
        What a worker does.
    """

    is_parallel = True

    def __init__(
        self, client: Any, workers: OwnWorkers | None = None, *, task: Callable[[Any], Row] = on_worker
    ) -> None:
        self._client = client
        self._workers = workers
        self._task = task
        self._run = uuid.uuid4().hex[:8]
        self._n_begun = 0
        self._running: dict[str, tuple[Job, Any]] = {}
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._asked = (-1e9, 1)
        self._idle_since: float | None = None  # when somebody else's workers were first missed
        self._has_warned = False

    @property
    def window(self) -> int:
        """Twice the threads that there are now; at least 1, or a cluster that grows on demand never would."""
        return max(1, 2 * self._n_threads())

    def _n_threads(self) -> int:
        when, n = self._asked
        if time.monotonic() > when + 1:
            n = sum(self._client.nthreads().values())
            self._asked = (time.monotonic(), n)
        return n

    def submit(self, job: Job) -> None:
        """Hand a job to the scheduler."""
        self._n_begun += 1
        key = f"segment-{self._run}-{self._n_begun}-{job.scan}"
        future = self._client.submit(self._task, job, key=key, pure=False)
        self._running[future.key] = (job, future)
        future.add_done_callback(self._ended.put)

    def collect(self, seconds: float) -> list[tuple[Job, Row | None]]:
        """What has ended; raises ConnectionError if the scheduler is gone, or if nobody works there."""
        found = []
        with contextlib.suppress(queue.Empty):
            found.append(self._ended.get(timeout=seconds))
            while True:
                found.append(self._ended.get_nowait())
        if not found:
            if self._client.status not in ("running", "connecting"):
                raise ConnectionError(_gone(self._client))
            if self._workers is not None:
                self._workers.keep()
            else:
                self._check_for_workers()
        outcomes = [self._outcome(future) for future in found if future.key in self._running]
        return [outcome for outcome in outcomes if outcome is not None]

    def _check_for_workers(self) -> None:
        """Warn if somebody else's cluster has had no worker for a moment; raise if none is to be expected."""
        if self._n_threads() > 0:
            self._idle_since = None
            return
        self._idle_since = self._idle_since or time.monotonic()
        missed, patience = time.monotonic() - self._idle_since, patience_with(self._client.cluster)
        address = self._client.scheduler.address
        if missed > patience:
            raise ConnectionError(
                f"the scheduler at {address} has had no workers for {patience:.0f} s; start some, as by "
                f"'dask worker {address}' or cluster.scale(2), and run again: it goes on from there"
            )
        if missed > NOTICE and not self._has_warned:
            self._has_warned = True
            until = (
                f"{patience:.0f} s for one" if math.isfinite(patience) else "until its cluster brings some"
            )
            warnings.warn(f"the scheduler at {address} has no workers; waiting {until}", stacklevel=2)

    def _outcome(self, future: Any) -> tuple[Job, Row | None] | None:
        """The job and its row; None if the row was lost on the way, and the job is being done again."""
        from distributed import KilledWorker

        job, _ = self._running.pop(future.key)
        try:
            row = future.result(timeout=ANSWER)
        except KilledWorker:
            return job, None
        except TimeoutError:
            self._running[future.key] = (job, future)
            future.add_done_callback(self._ended.put)
            return None
        except Exception as error:
            if future.status in ("cancelled", "lost"):
                raise ConnectionError(_gone(self._client)) from error
            row = {"scan": job.scan, "status": "failed", "error": f"{type(error).__name__}: {error}"}
        return job, row

    def enlarge(self) -> bool:
        """One worker with all the memory, if they are ours."""
        if self._workers is None:
            return False
        before = set(self._client.nthreads())
        if not self._workers.start_one():
            return False
        end = time.monotonic() + ANSWER  # a job handed to one that has just been ended would be blamed for it
        while before & set(self._client.nthreads()) and time.monotonic() < end:
            time.sleep(0.05)
        return True

    def foretold(self) -> dict[str, Row]:
        """What workers logged of the scans that they read."""
        return {row["scan"]: row for _, row in self._client.get_events(TOPIC)}

    def close(self) -> None:
        """Cancel what runs, sweep up after it, and stop the workers if they are ours."""
        left = list(self._running.values())
        with contextlib.suppress(Exception):  # the scheduler may be gone
            self._client.cancel([future for _, future in left], force=True)
        self._running.clear()
        if self._workers is not None:
            self._workers.stop()
            for job, _ in left:
                sweep_up(job)


class OwnWorkers:
    """Worker processes on this machine, one job each at a time, that nobody has to set up.

    Parameters
    ----------
    address : str
        Of the scheduler.
    n : int
        Workers; they share memory and cores evenly.
    """

    def __init__(self, address: str, n: int) -> None:
        self.n = n
        self._address = address
        self._folder = Path(tempfile.mkdtemp(prefix="scenewidget-workers-"))
        self._process: subprocess.Popen[bytes] | None = None
        self._n_started = 0

    def start(self) -> None:
        """Start them; returns at once."""
        from distributed.system import MEMORY_LIMIT

        self._n_started += 1
        settings = DASK | {
            KNOB: str(max(1, n_threads() // self.n)),
            "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
        }
        command = [
            sys.executable, "-m", "distributed.cli.dask_worker", self._address,
            "--nworkers", str(self.n), "--nthreads", "1", "--no-dashboard",
            "--memory-limit", str(int(SHARE * MEMORY_LIMIT / self.n)),
            "--local-directory", str(self._folder), "--death-timeout", "60",
        ]  # fmt: skip
        with (self._folder / "log.txt").open("ab") as log:
            self._process = subprocess.Popen(
                command,
                stdout=log,
                stderr=log,
                stdin=subprocess.DEVNULL,
                env=os.environ | settings,
                start_new_session=True,  # Ctrl-C is for us alone
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # the same on Windows
            )

    def start_one(self) -> bool:
        """One worker with all the memory instead; False if it is so already."""
        if self.n == 1:
            return False
        self._end()
        self.n = 1
        self.start()
        return True

    def keep(self) -> None:
        """Start them again if somebody has ended the command that keeps them.

        Raises
        ------
        RuntimeError
            They end again and again; the message has the last they said.
        """
        if self._process is None or self._process.poll() is None:
            return
        if self._n_started > RESTARTS:
            said = (self._folder / "log.txt").read_text(errors="replace").strip()[-600:]
            raise RuntimeError(
                f"workers end as soon as they are started; the last they said: {said or 'nothing'}"
            )
        self.start()

    def stop(self) -> None:
        """End them, whatever they do, and remove what they leave."""
        self._end()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _end(self) -> None:
        import psutil

        process, self._process = self._process, None
        if process is None:
            return
        try:
            all_of_them = [*psutil.Process(process.pid).children(recursive=True), psutil.Process(process.pid)]
        except psutil.NoSuchProcess:
            all_of_them = []
        for one in reversed(all_of_them):  # the keeper first, or it would start others
            with contextlib.suppress(psutil.Error):
                one.kill()
        process.wait()


DASK = {  # a worker that is too large is ended; none is put on hold, which might be for good
    "DASK_DISTRIBUTED__WORKER__MEMORY__TARGET": "False",
    "DASK_DISTRIBUTED__WORKER__MEMORY__SPILL": "False",
    "DASK_DISTRIBUTED__WORKER__MEMORY__PAUSE": "False",
    "DASK_DISTRIBUTED__WORKER__MEMORY__TERMINATE": "0.95",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",  # looks at a busy worker 100 times a second
    # Dask has workers give memory back to the system at once, only to ask for it anew: a third more CPU.
    # These are the bounds to which the C library goes by itself, in steps
    "DASK_DISTRIBUTED__NANNY__PRE_SPAWN_ENVIRON": repr(
        {"MALLOC_TRIM_THRESHOLD_": 64 << 20, "MALLOC_MMAP_THRESHOLD_": 32 << 20}
    ),
    "DASK_DISTRIBUTED__LOGGING__DISTRIBUTED": "warning",
}


@contextlib.contextmanager
def open_pool(
    client: Any = None,
    n_workers: int | None = None,
    *,
    tell: Callable[[str], None] | None = None,
    task: Callable[[Any], Row] = on_worker,
) -> Any:
    """A pool for the length of a block.

    Parameters
    ----------
    client : distributed.Client, cluster or address, optional
        By default workers of our own.
    n_workers : int, optional
        How many; 0 stays in this process. By default as many as there are cores, and 2 GB of memory for each.
    tell : callable (line), optional
        Hears every step, where the work is done in this process.
    task : callable (job) -> row
        What a worker does.

    Raises
    ------
    ImportError
        Dask isn't there.
    TypeError, ValueError
        Arguments that can't be.
    ConnectionError
        No scheduler answers.

    Examples
    --------
    >>> with open_pool(n_workers=0) as pool:
    ...     pool.window
    1
    """
    check_where(client, n_workers)
    if client is None and n_workers == 0:
        yield InProcess(tell)
        return
    with contextlib.ExitStack() as stack:
        if client is None:
            pool = _own_pool(n_workers, task, stack)
        else:
            pool = DaskPool(stack.enter_context(connected(client)), task=task)
        stack.callback(pool.close)
        yield pool


def _own_pool(n_workers: int | None, task: Callable[[Any], Row], stack: contextlib.ExitStack) -> DaskPool:
    import logging

    from distributed import LocalCluster
    from distributed.system import MEMORY_LIMIT

    n = n_workers or max(1, min(n_threads(), int(SHARE * MEMORY_LIMIT / ROOM)))
    make: Any = LocalCluster  # no types
    cluster = make(
        n_workers=0,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address=f"127.0.0.1:{_dashboard_port()}",
        silence_logs=logging.CRITICAL,
        scheduler_kwargs={"allowed_failures": 1},
    )
    stack.callback(cluster.close)
    client = stack.enter_context(new_client(cluster))
    workers = OwnWorkers(cluster.scheduler_address, n)
    stack.callback(workers.stop)
    workers.start()
    return DaskPool(client, workers, task=task)


def _dashboard_port() -> int:
    """8787, where people expect Dask's dashboard; any other where that is taken, or where there is none."""
    if importlib.util.find_spec("bokeh") is None:
        return 0
    with socket.socket() as trial:
        try:
            trial.bind(("127.0.0.1", DASHBOARD))
        except OSError:
            return 0
    return DASHBOARD


def _gone(client: Any) -> str:
    address = getattr(client.scheduler, "address", "")
    place = f" at {address}" if address else ""
    return f"the scheduler{place} is gone; what is done is kept, and the same call goes on from there"
