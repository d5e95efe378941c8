"""A process that edits and saves without end, for `kill_rounds`; says which edits it was told are on disk."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import shapes
from mortal import Mortal

from scenewidget.editing.edits import EditError
from scenewidget.editing.session import Session, apply_edits
from scenewidget.engine.segmentation import Segmentation


def start(mesh):
    """A session on a mesh with parts of all sizes, the same every time."""
    n = mesh.n_faces
    levels = {"dihedral": np.arange(n, dtype=np.int32) // 2, "base": np.arange(n, dtype=np.int32) // 8}
    return Session(mesh, Segmentation(mesh, np.arange(n, dtype=np.int32) // 32, levels=levels))


def work(path, seed, tell):
    """Open or make the project and edit until somebody kills us."""
    mesh = shapes.box(6)
    rng = np.random.default_rng(seed)
    if Path(path).exists():
        session = Session.open(path, mesh)
        assert not session.read_only
    else:
        session = start(mesh)
        session.save(path)
    tell.send(len(session.to_frame()))
    while True:
        a, b = (int(x) for x in rng.integers(0, mesh.n_faces, 2))
        action = rng.integers(0, 12)
        try:
            if action < 4:
                session.merge(a, b, ("dihedral", "base", "final")[action % 3])
            elif action < 7:
                session.split(a, ("dihedral", "base", "final")[action % 3])
            elif action == 7:
                session.relabel(a, f"name {b}")
            elif action == 8:
                session.undo()
            elif action == 9:
                session.redo()
            elif action == 10 and b % 5 == 0:
                session.cut(a, b)
            elif action == 11 and b % 20 == 0:
                session.save(path, include_mesh=bool(a % 2))  # the whole file anew
        except EditError:
            continue
        if session.is_saved:
            tell.send(len(session.to_frame()))


def kill_rounds(folder, n_rounds, *, seed=0, most=20, longest=0.1):
    """Kill a saver again and again; what was acknowledged must be there each time.

    Every other round, at some instant from its start on; else, at some instant after up to ``most`` edits.
    Either way within ``longest`` seconds.

    Returns
    -------
    acknowledged, found : lists of int
        Operations that the saver was told are on disk, and operations in the file, for each round.
    """
    rng = np.random.default_rng(seed)
    path, mesh = Path(folder) / "room.swproj", shapes.box(6)
    acknowledged, found = [], []
    for round_ in range(n_rounds):
        saver = Mortal(work, path, seed + round_)
        told = [saver.hear() for _ in range(round_ % 2 * rng.integers(most))]
        time.sleep(float(rng.uniform(0, longest)))
        told += saver.kill()
        acknowledged.append(told[-1] if told else 0)
        if not path.exists() and not acknowledged[-1]:  # killed before the first save was through
            found.append(0)
            continue
        session = Session.open(path, mesh)
        operations = session.to_frame()
        assert not session.read_only
        found.append(len(operations) - 1)  # the last one is this opening
        expected = apply_edits(start(mesh).automatic, session.edits)
        np.testing.assert_array_equal(session.segmentation.labels, expected.labels)
        assert session.segmentation.names == expected.names
        session.close()
    return acknowledged, found
