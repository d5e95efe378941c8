"""One BLAS thread within the context, what was set before outside of it; work shared out by rows or calls."""

import threading

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from scenewidget.engine.threads import KNOB, PART, at_once, by_parts, one_blas_thread


def blas_threads():
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def _two_blas_threads():
    with threadpool_limits(limits=2, user_api="blas"):
        if blas_threads() != {2}:
            pytest.skip("this BLAS can't be set to two threads")
        yield


def test_within_it_blas_has_one_thread_and_afterwards_what_it_had():
    with one_blas_thread():
        assert blas_threads() == {1}
    assert blas_threads() == {2}


def test_within_one_another_the_outermost_restores():
    with one_blas_thread():
        with one_blas_thread():
            assert blas_threads() == {1}
        assert blas_threads() == {1}
    assert blas_threads() == {2}


def test_an_error_inside_restores_too():
    with pytest.raises(ZeroDivisionError), one_blas_thread():
        _ = 1 / 0
    assert blas_threads() == {2}


def test_threads_inside_at_once_each_find_afterwards_what_was_set_before():
    """Whether the library keeps the number for each thread or for the process."""
    inside, may_leave, seen = threading.Event(), threading.Event(), []

    def stay():
        with one_blas_thread():
            seen.append(blas_threads())
            inside.set()
            may_leave.wait(30)
        seen.append(blas_threads())

    other = threading.Thread(target=stay)
    with one_blas_thread():
        other.start()
        assert inside.wait(30)
        assert blas_threads() == {1}
    may_leave.set()
    other.join()
    assert seen == [{1}, {2}]
    assert blas_threads() == {2}
    with one_blas_thread():
        assert blas_threads() == {1}
    assert blas_threads() == {2}


@pytest.mark.parametrize("n", [0, 1, PART, 3 * PART + 7])
@pytest.mark.parametrize("threads", ["1", "3"])
def test_parts_hold_each_row_once(monkeypatch, n, threads):
    monkeypatch.setenv(KNOB, threads)
    times = np.zeros(n, dtype=int)

    def count(rows):
        times[rows] += 1

    by_parts(count, n)
    assert (times == 1).all()


@pytest.mark.parametrize("threads", ["1", "3"])
def test_what_goes_wrong_in_a_part_or_a_call_is_raised(monkeypatch, threads):
    monkeypatch.setenv(KNOB, threads)
    with pytest.raises(ZeroDivisionError):
        by_parts(lambda rows: rows.start // 0, 2 * PART)
    with pytest.raises(ZeroDivisionError):
        at_once(lambda: 1, lambda: 1 // 0)
