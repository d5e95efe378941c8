"""What is remembered, what is forgotten first, and how many bytes it counts."""

from dataclasses import dataclass

import numpy as np
import pytest
import shapes
from scipy import sparse

from scenewidget.engine.memo import Memo, compute, n_bytes


def kilobyte():
    return np.zeros(125)


def test_what_was_used_longest_ago_is_forgotten_first():
    memo = Memo(2000)
    for key in "ab":
        memo.keep(key, kilobyte())
    assert memo.find("a") is not None
    memo.keep("c", kilobyte())
    assert [key in memo for key in "abc"] == [True, False, True]
    assert (len(memo), memo.n_bytes) == (2, 2000)
    assert memo.find("b") is None
    memo.clear()
    assert (len(memo), memo.n_bytes) == (0, 0)


def test_what_nobody_will_ask_for_can_be_forgotten():
    memo = Memo(1000)
    for key in (("distances", 1), ("distances", 2), ("tree", 1)):
        memo.keep(key, np.zeros(4))
    memo.forget(lambda key: key[0] == "distances")
    assert len(memo) == 1
    assert ("tree", 1) in memo
    assert memo.n_bytes == 32


def test_the_last_result_stays_however_large_it_is():
    memo = Memo(10)
    memo.keep("a", kilobyte())
    memo.keep("b", kilobyte())
    assert [key in memo for key in "ab"] == [False, True]


def test_recall_computes_once_in_each_scope():
    memo, made = Memo(1e6), []

    def make(value):
        made.append(value)
        return value

    one, other = memo.within("one"), memo.within("other")
    assert [one("key", lambda: make((1,))), one("key", lambda: make((2,)))] == [(1,), (1,)]
    assert other("key", lambda: make((3,))) == (3,)
    assert made == [(1,), (3,)]
    assert [compute("key", lambda: make((4,))), compute("key", lambda: make((5,)))] == [(4,), (5,)]


@dataclass
class Record:
    array: np.ndarray
    rest: object = None


SHARED = kilobyte()


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (SHARED, 1000),
        (SHARED[:5], 1000),  # a view keeps the whole alive
        ((SHARED, [SHARED]), 1000),
        ({"a": kilobyte(), "b": Record(kilobyte(), [kilobyte()])}, 3000),
        (Record(kilobyte(), shapes.box(3)), 1000),  # meshes are not counted
        ("text", 0),
    ],
)
def test_bytes_are_those_of_the_arrays(value, expected):
    assert n_bytes(value) == expected


def test_bytes_of_a_sparse_matrix_are_those_of_its_three_arrays():
    matrix = sparse.csr_array(np.eye(10))
    assert n_bytes(matrix) == matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes
