"""Jobs on a real local cluster with faults injected: tasks that do nothing or die."""

import os
import threading

import pytest

from scenewidget.batch.plan import Job
from scenewidget.batch.pools import DaskPool, InProcess, open_pool
from scenewidget.batch.schedule import work_through
from scenewidget.engine.params import Params


@pytest.fixture(scope="module")
def cluster():
    """Two workers whose task is in the name of the scan; a nested function travels by value."""

    def task(job):
        import os
        import signal
        import time
        from pathlib import Path

        what = job.scan.partition("-")[0]
        if what == "poison" or (what == "once" and not Path(job.source).exists()):
            Path(job.source).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if what == "large":
            return {"scan": job.scan, "status": "too large", "error": "needs more"}
        if what == "raises":
            raise ZeroDivisionError("a fault of ours")
        time.sleep(0.5 if what == "slow" else 0)
        return {"scan": job.scan, "status": "done", "error": "", "process": os.getpid()}

    with open_pool(n_workers=2, task=task) as pool:
        yield pool


def jobs(tmp_path, *names):
    return [
        Job(name, str(tmp_path / name), str(tmp_path / "out" / name), Params(), size=len(names) - i)
        for i, name in enumerate(names)
    ]


def outcome(pool, work):
    rows = []
    work_through(work, pool, lambda job, row: rows.append((job.scan, row)), threading.Event())
    assert len(rows) == len({scan for scan, _ in rows}) == len(work)  # each in exactly one status
    return dict(rows)


def test_two_processes_do_the_jobs(cluster, tmp_path):
    rows = outcome(cluster, jobs(tmp_path, *[f"slow-{i}" for i in range(6)]))
    assert {row["status"] for row in rows.values()} == {"done"}
    processes = {row["process"] for row in rows.values()}
    assert len(processes) == 2
    assert os.getpid() not in processes


def test_an_error_of_the_task_itself_is_a_row(cluster, tmp_path):
    rows = outcome(cluster, jobs(tmp_path, "raises-1", "fine-1"))
    assert rows["raises-1"]["error"] == "ZeroDivisionError: a fault of ours"
    assert rows["fine-1"]["status"] == "done"


@pytest.mark.skipif(os.name != "posix", reason="processes are killed by a signal")
def test_what_kills_its_worker_is_reported_and_nobody_else_suffers(cluster, tmp_path):
    """Comes last: afterwards one large worker is left."""
    names = [f"fine-{i}" for i in range(12)]
    names[2:2] = ["poison-1", "once-1", "large-1"]
    rows = outcome(cluster, jobs(tmp_path, *names))
    assert {name for name, row in rows.items() if row["status"] != "done"} == {"poison-1", "large-1"}
    assert rows["poison-1"]["status"] == "killed"
    assert "also when nothing else ran" in rows["poison-1"]["error"]
    assert (tmp_path / "out" / "poison-1" / "failed.json").exists()
    assert rows["large-1"]["status"] == "too large"  # with all the memory, too
    assert not cluster.enlarge()


def test_a_row_that_is_lost_on_the_way_is_waited_for(tmp_path):
    """Its worker died after the work and before the row was fetched: the scheduler has it done again."""

    class Future:
        key = "k"
        status = "finished"
        answers = iter([TimeoutError(), {"scan": "a", "status": "done", "error": ""}])

        def add_done_callback(self, heard):
            heard(self)

        def result(self, timeout):
            answer = next(self.answers)
            if isinstance(answer, Exception):
                raise answer
            return answer

    class Client:
        status = "running"

        def nthreads(self):
            return {}

        def submit(self, *_, **__):
            return Future()

    rows = outcome(DaskPool(Client()), jobs(tmp_path, "a"))
    assert rows["a"]["status"] == "done"


def test_the_large_worker_gets_no_job_while_the_scheduler_believes_in_the_old_ones():
    """Who was handed to one that had just been ended would be blamed for its end."""
    believed = [{"old-1": 1, "old-2": 1}] * 3 + [{"old-2": 1}, {}, {"new": 1}]

    class Client:
        def nthreads(self):
            return believed.pop(0) if len(believed) > 1 else believed[0]

    class Workers:
        def start_one(self):
            return True

    assert DaskPool(Client(), Workers()).enlarge()
    assert believed == [{"new": 1}]


def test_stopping_abandons_what_waits(tmp_path):
    stop, seen = threading.Event(), []

    def report(job, row):
        seen.append(job.scan)
        stop.set()

    work_through(jobs(tmp_path, "a", "b", "c"), InProcess(), report, stop)
    assert seen == ["a"]
