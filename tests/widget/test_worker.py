"""The newest request wins, and nothing is reported of others."""

import threading

import numba
import pytest

from scenewidget.widget.worker import Newest, Worker, checked_timeout


def test_a_task_that_is_cancelled_before_it_begins_is_reported_too():
    told = []
    worker = Worker(
        on_progress=lambda *_: None,
        on_done=told.append,
        on_error=told.append,
        on_cancelled=lambda: told.append("cancelled"),
    )
    started, gate = threading.Event(), threading.Event()
    worker.submit(lambda *_: started.set() or gate.wait(10))
    assert started.wait(10)
    worker.submit(lambda *_: "never")
    worker.cancel()
    gate.set()
    assert worker.wait(10)
    assert told == ["cancelled"]


def test_worker_reports_nothing_of_a_task_that_was_replaced():
    told = []
    worker = Worker(
        on_progress=lambda *_: None,
        on_done=told.append,
        on_error=told.append,
        on_cancelled=lambda: told.append("c"),
    )
    started = threading.Event()

    def slow(_, cancel):
        started.set()
        assert cancel.wait(10)
        raise RuntimeError("a stale error")

    worker.submit(slow)
    assert started.wait(10)
    worker.submit(lambda *_: "new")
    assert worker.wait(10)
    assert told == ["new"]


def test_of_what_comes_while_something_runs_only_the_last_runs_next():
    runner, done = Newest("test"), []
    started, gate = threading.Event(), threading.Event()
    runner.submit(lambda: (started.set(), gate.wait(10), done.append("first")))
    assert started.wait(10)
    for name in ("second", "third"):
        runner.submit(lambda name=name: done.append(name))
    assert runner.has_next
    assert not runner.wait(0.01)
    gate.set()
    assert runner.wait(10)
    assert done == ["first", "third"]
    assert not runner.is_busy


def test_a_task_that_fails_keeps_none_from_running(caplog):
    runner, done = Newest("test"), []
    runner.submit(lambda: 1 / 0)
    assert runner.wait(10)
    runner.submit(lambda: done.append("next"))
    assert runner.wait(10)
    assert done == ["next"]
    assert "test failed" in caplog.text


def test_what_waits_can_be_dropped():
    runner, done = Newest("test"), []
    started, gate = threading.Event(), threading.Event()
    runner.submit(lambda: (started.set(), gate.wait(10)))
    assert started.wait(10)
    runner.submit(lambda: done.append("never"))
    runner.drop()
    gate.set()
    assert runner.wait(10)
    assert done == []


@pytest.mark.parametrize(
    ("timeout", "error"),
    [("1", TypeError), (True, TypeError), ([], TypeError), (float("nan"), ValueError), (-1, ValueError)],
)
def test_a_timeout_is_a_number_of_seconds(timeout, error):
    with pytest.raises(error, match="timeout must be a number of seconds or None, got"):
        checked_timeout(timeout)


def test_a_stage_that_compiles_says_so_and_the_next_does_not():
    said, told = [], threading.Event()

    def show(stage, _):
        said.append(stage + worker.aside)
        if worker.aside:
            told.set()

    def task(progress, _):
        progress("items", 0.0)
        numba.njit(lambda x: x + 1)(1)
        assert told.wait(10)
        progress("finish", 0.0)

    worker = Worker(on_progress=show, on_done=str, on_error=said.append, on_cancelled=str)
    worker.submit(task)
    assert worker.wait(20)
    assert said == ["items", "items (first run: compiling, once)", "finish"]
