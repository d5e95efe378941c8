"""The border of a segment is moved as its definition says, on a chain and on a grid of faces."""

import numpy as np
import pytest

from scenewidget.editing.borders import grown, holes, shrunk, smoothed


def grid(n):
    """Pairs of neighbours of an n by n grid of squares, as if they were faces."""
    places = np.arange(n * n).reshape(n, n)
    across = np.stack([places[:, :-1].ravel(), places[:, 1:].ravel()], axis=1)
    down = np.stack([places[:-1].ravel(), places[1:].ravel()], axis=1)
    return np.concatenate([across, down])


def steps_from(pairs, inside):
    """Number of edges crossed from a set to each face, by breadth."""
    found = np.where(inside, 0, -1)
    for step in range(1, len(inside)):
        near = np.zeros(len(inside), bool)
        for a, b in pairs:
            near[b] |= found[a] == step - 1
            near[a] |= found[b] == step - 1
        found[near & (found < 0)] = step
    return found


@pytest.mark.parametrize("rings", [1, 2, 3])
def test_a_segment_grows_by_all_within_so_many_steps(rings):
    pairs, segment = grid(7), np.full(49, 2)
    segment[[24, 0]], segment[48] = 5, -1
    steps = steps_from(pairs, segment == 5)
    assert grown(pairs, segment, 5, rings).tolist() == np.flatnonzero((steps > 0) & (steps <= rings)).tolist()


def test_a_segment_shrinks_towards_whom_it_shares_most_edges_with():
    pairs = grid(4)
    segment = np.array([5, 5, 5, 5, 5, 5, 5, 7, 5, 5, 5, 7, 5, 5, 5, 7])
    faces, takers = shrunk(pairs, segment, 5)
    assert faces.tolist() == [3, 6, 10, 14]
    assert takers.tolist() == [7, 7, 7, 7]


def test_nothing_is_given_to_unlabeled_faces():
    pairs, segment = grid(3), np.full(9, 5)
    segment[4] = -1
    assert len(shrunk(pairs, segment, 5)[0]) == 0


def test_only_what_is_enclosed_and_small_is_a_hole():
    pairs, segment = grid(5), np.full(25, 5)
    segment[12] = 7  # in the middle
    segment[4] = 8  # a corner, with no neighbour but the segment
    assert 12 in holes(pairs, segment, 5, max_faces=1)
    segment[13] = 7
    assert 12 not in holes(pairs, segment, 5, max_faces=1)
    assert {12, 13} <= set(holes(pairs, segment, 5, max_faces=2).tolist())


def test_a_spike_goes_and_a_straight_border_stays():
    pairs, n = grid(10), 10
    segment = np.where(np.arange(n * n) // n < 5, 5, 7)
    faces, _ = smoothed(pairs, segment, 5)
    assert len(faces) == 0
    segment[5 * n + 4] = segment[6 * n + 4] = 5  # two squares stick out
    faces, takers = smoothed(pairs, segment, 5)
    assert 6 * n + 4 in faces
    assert set(takers[faces >= 5 * n].tolist()) == {7}
