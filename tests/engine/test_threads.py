"""One BLAS thread within the context, what was set before outside of it, whoever leaves last."""

import threading

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from scenewidget.engine.threads import one_blas_thread


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
