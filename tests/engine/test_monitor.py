"""Progress and cancel."""

import threading

import pytest

from scenewidget.engine.monitor import SILENT, Cancelled, Monitor


@pytest.fixture
def clock(monkeypatch):
    """Time as the monitor sees it: clock[0], in seconds."""
    now = [100.0]
    monkeypatch.setattr("scenewidget.engine.monitor.time.monotonic", lambda: now[0])
    return now


def test_progress_is_told_start_and_end_and_never_falls(clock):
    heard = []
    monitor = Monitor(lambda stage, fraction: heard.append((stage, fraction)))
    for stage in ("one", "two"):
        monitor.start(stage)
        for fraction in (0.2, 0.6, 0.3, 1.7, -1.0):
            clock[0] += 0.06
            monitor.tick(fraction)
        monitor.finish()
    for stage in ("one", "two"):
        fractions = [f for s, f in heard if s == stage]
        assert fractions[0] == 0
        assert fractions[-1] == 1
        assert fractions == sorted(fractions)
        assert 0.6 in fractions


def test_progress_is_told_at_most_twenty_times_a_second(clock):
    heard = []
    monitor = Monitor(lambda stage, fraction: heard.append(fraction))
    monitor.start("stage")
    for _ in range(300):
        clock[0] += 0.001
        monitor.tick(0.5)
    assert 4 <= len(heard) <= 7


def test_cancel_names_the_stage():
    cancel = threading.Event()
    monitor = Monitor(cancel=cancel)
    monitor.start("distances")
    monitor.tick(0.5)
    cancel.set()
    with pytest.raises(Cancelled, match="during 'distances'"):
        monitor.tick()


def test_a_call_that_cannot_be_stopped_is_left_behind_on_cancel():
    cancel, done, finished = threading.Event(), threading.Event(), threading.Event()
    threading.Timer(0.1, cancel.set).start()
    with pytest.raises(Cancelled):
        Monitor(cancel=cancel).call(lambda: (done.wait(30), finished.set()))
    assert not finished.is_set()
    done.set()


@pytest.mark.parametrize("cancel", [None, threading.Event()])
def test_a_call_hands_on_what_the_function_returns_or_raises(cancel):
    monitor = Monitor(cancel=cancel)
    assert monitor.call(divmod, 7, 3) == (2, 1)
    with pytest.raises(ZeroDivisionError):
        monitor.call(divmod, 7, 0)


def test_what_cannot_be_called_or_asked_is_refused():
    with pytest.raises(TypeError, match="progress must be callable"):
        Monitor(progress=3)
    with pytest.raises(TypeError, match=r"cancel must be a threading\.Event"):
        Monitor(cancel=True)


def test_the_silent_monitor_stays_silent():
    SILENT.tick(0.5)
