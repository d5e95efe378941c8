"""Exercises of notebook 02: what is next to what."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from scenewidget.datasets import analytic, load_room
from scenewidget.engine.mesh import IntArray, Mesh, connected_components, face_adjacency
from scenewidget.exercises.judging import Exercise, FunctionExercise, NumberExercise

__all__ = ["EXERCISES"]

SMALL, MEMORY, ENTRY = 10, 8e9, 4  # triangles of a crumb; bytes of memory, and of a number in it
TRIANGLES = 10_000


@cache
def _room_pairs() -> tuple[int, IntArray]:
    mesh, _ = load_room()
    return mesh.n_faces, face_adjacency(mesh)


def border_edges() -> int:
    """Three edges a triangle; a pair of neighbours uses up two of them."""
    n_faces, pairs = _room_pairs()
    return 3 * n_faces - 2 * len(pairs)


def vertices_of_a_closed_mesh() -> float:
    """Euler: V − E + F = 2, and E = 3F/2, for each edge has two triangles."""
    return 2 + 3 * TRIANGLES / 2 - TRIANGLES


def large_components() -> int:
    """Components of at least ten triangles."""
    count, component = connected_components(_room_pairs()[0], _room_pairs()[1])
    return int((np.bincount(component, minlength=count) >= SMALL).sum())


def most_nodes() -> float:
    """n² entries of four bytes fit in the memory."""
    return float(np.floor(np.sqrt(MEMORY / ENTRY)))


def neighbours(faces: IntArray) -> list[tuple[int, int]]:
    """A table from each edge to its triangles, then the pairs in each entry."""
    at_edge: dict[tuple[int, int], list[int]] = {}
    for t, (a, b, c) in enumerate(faces.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            at_edge.setdefault((min(edge), max(edge)), []).append(t)
    return sorted({(s, t) for found in at_edge.values() for s in found for t in found if s < t})


def components(n: int, pairs: IntArray) -> list[int]:
    """From each node that has no number yet, walk to all that can be reached."""
    beside: list[list[int]] = [[] for _ in range(n)]
    for a, b in np.asarray(pairs).tolist():
        beside[a].append(b)
        beside[b].append(a)
    number, count = [-1] * n, 0
    for start in range(n):
        if number[start] < 0:
            number[start], waiting = count, [start]
            while waiting:
                for other in beside[waiting.pop()]:
                    if number[other] < 0:
                        number[other] = count
                        waiting.append(other)
            count += 1
    return number


def _neighbours_at_corners(faces: IntArray) -> list[tuple[int, int]]:
    touch = (faces[:, None, :, None] == faces[None, :, None, :]).any(axis=(2, 3))
    return [(s, t) for s, t in zip(*np.nonzero(touch), strict=True) if s < t]


def _first_neighbour(n: int, pairs: IntArray) -> list[int]:
    return [min([i, *pairs[(pairs == i).any(axis=1)].ravel().tolist()]) for i in range(n)]


def _as_pairs(parts: tuple[Any, ...]) -> Any:
    """Each pair with its smaller number first, sorted."""
    return np.unique(np.sort(parts[0].reshape(-1, 2), axis=1), axis=0)


def _by_first(parts: tuple[Any, ...]) -> Any:
    """Numbers in the order in which they come up."""
    _, first, inverse = np.unique(parts[0], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first)).astype(float)[inverse.ravel()]


def _faces() -> dict[str, tuple[Any, ...]]:
    meshes: dict[str, Mesh] = {
        "a square": analytic.square(2),
        "a sphere": analytic.sphere(1),
        "a torus": analytic.torus(n_ring=8, n_tube=5),
    }
    return {name: (np.array(mesh.faces),) for name, mesh in meshes.items()}


def _graphs() -> dict[str, tuple[Any, ...]]:
    rng = np.random.default_rng(4)
    return {
        "a chain": (6, np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]])),
        "a chain from the middle and a single node": (6, np.array([[2, 4], [4, 0], [0, 3], [3, 5]])),
        "no edges": (3, np.zeros((0, 2), dtype=int)),
        "a random graph": (30, rng.integers(0, 30, (22, 2))),
    }


EXERCISES: tuple[Exercise, ...] = (
    NumberExercise(
        name="02.1",
        level=1,
        is_whole=True,
        question="How many *border edges* has the scan, those that belong to one triangle only? `mesh.n_faces` and "
        "`len(pairs)` are enough. (A triangle has three edges; pretend that no edge has more than two triangles.)",
        right=border_edges,
        why="of the 3F sides of triangles each pair of neighbours uses two.",
        hint="count the sides of all triangles, then take away those that lie between two neighbours.",
        mistakes={
            "an inner edge is a side of *two* triangles, so each pair takes two sides away": lambda r: (
                r + len(_room_pairs()[1])
            ),
            "those are all sides of all triangles; which of them lie between two?": lambda r: (
                3 * _room_pairs()[0]
            ),
            "those are the inner edges": lambda r: len(_room_pairs()[1]),
        },
    ),
    NumberExercise(
        name="02.2",
        level=2,
        is_whole=True,
        question="A closed mesh without handles, such as a ball, has 10 000 triangles. How many vertices has it? "
        "(Euler: V − E + F = 2.)",
        right=vertices_of_a_closed_mesh,
        why="each triangle has three half edges, so E = 3F/2 and V = 2 + F/2: half as many vertices as triangles.",
        hint="how many edges has it, if each of them belongs to two triangles?",
        mistakes={
            "nearly: 2 is missing. That would be a torus": lambda r: r - 2,
            "an edge belongs to two triangles, so there are 3F/2 of them and not 3F": lambda r: (
                2 + 2 * TRIANGLES
            ),
            "those are the edges": lambda r: 3 * TRIANGLES / 2,
        },
    ),
    NumberExercise(
        name="02.3",
        level=1,
        is_whole=True,
        question="How many connected components of the scan have *at least ten* triangles?",
        right=large_components,
        why="all the others are dust.",
        hint="np.bincount(component) has the size of each component.",
        mistakes={
            "ten itself counts: at least ten, not more than ten": lambda r: int(
                (np.bincount(connected_components(*_room_pairs())[1]) > SMALL).sum()
            ),
            "those are the small ones": lambda r: connected_components(*_room_pairs())[0] - r,
            "those are all": lambda r: connected_components(*_room_pairs())[0],
        },
    ),
    NumberExercise(
        name="02.4",
        level=1,
        question="A computer has 8 GB (8·10⁹ bytes). For how many nodes at most does a full matrix of distances fit, "
        "with 4 bytes a pair (i, j)?",
        right=most_nodes,
        why="4n² = 8·10⁹, some 45 thousand nodes; a scan has ten times as many triangles.",
        hint="n nodes have n² pairs.",
        mistakes={
            "that many *entries* fit; they are n² for n nodes": lambda r: MEMORY / ENTRY,
            "each entry takes four bytes, not one": lambda r: np.sqrt(MEMORY),
            "each entry takes four bytes: divide, don't multiply": lambda r: np.sqrt(MEMORY * ENTRY),
            "the full matrix holds (i, j) and (j, i); you counted one of them": lambda r: r * np.sqrt(2),
        },
    ),
    FunctionExercise(
        name="02.5",
        level=3,
        signature="neighbours(faces)",
        is_free=True,
        question="Write `neighbours(faces)`: from an (F, 3) array of vertex numbers all pairs of triangles that share an "
        "*edge*, in any order. (A table from edges to triangles does it in one pass.)",
        right=neighbours,
        cases=_faces,
        settle=_as_pairs,
        why="a dictionary of edges takes F steps, where comparing all triangles takes F².",
        hint="two triangles are neighbours if they have two vertices in common.",
        mistakes={
            "triangles that share a single corner are no neighbours yet: two common vertices make an edge": (
                _neighbours_at_corners
            ),
        },
    ),
    FunctionExercise(
        name="02.6",
        level=3,
        signature="components(n, pairs)",
        question="Write `components(n, pairs)`: for each of n nodes the number of its connected component; how you number "
        "them is up to you.",
        right=components,
        cases=_graphs,
        settle=_by_first,
        why="each edge is looked at twice, once from each end.",
        hint="everything that can be reached, over any number of steps, has one number.",
        mistakes={"that goes one step far; neighbours of neighbours belong to it as well": _first_neighbour},
    ),
)
