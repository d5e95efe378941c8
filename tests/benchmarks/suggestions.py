"""Are the suggested edits worth looking at? Proposals until 1 − RI is a fifth lower, suggested and at random.

    python tests/benchmarks/suggestions.py [--half judging] [--scans study] [--seed 0] [--cache DIR]

An annotator looks at one proposal after the other, follows those that lower 1 − RI and dismisses the others.
Random proposals are merges of two segments that touch, and base segments moved to a segment that they
touch, in equal parts. The annotator who knows the truth (`simulate_annotator`) is the least that is possible.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from rooms import HALVES, Scan, scans

import scenewidget as sw
from scenewidget.editing import Edit, EditError, Merge, Session, simulate_annotator
from scenewidget.editing.annotator import Judge
from scenewidget.engine.mesh import face_adjacency

SHARE = 0.8  # of the first 1 − RI
MOST = 1_000


def suggested(session: Session) -> Iterator[Edit]:
    """What the session suggests; what was not followed is dismissed."""
    while found := session.suggestions(1):
        n_edits = len(session.edits)
        yield found[0].edit
        if len(session.edits) == n_edits:
            session.dismiss(found[0])


def at_random(session: Session, rng: np.random.Generator, pairs: np.ndarray) -> Iterator[Edit]:
    """Neighbours without a choice."""
    base = session.automatic.level("base")
    base_pairs = np.unique(base[pairs], axis=0)
    face = np.zeros(int(base.max()) + 1, int)
    face[base] = np.arange(len(base))
    while True:
        segment = session.atom_segments[session.atoms.face_atom[face]]
        ends = segment[base_pairs]
        crossing = (ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1) & (base_pairs >= 0).all(axis=1)
        if rng.random() < 0.5:
            unique = np.unique(np.sort(ends[crossing], axis=1), axis=0)
            chosen = unique[rng.integers(len(unique))]
            (k,) = rng.choice(np.flatnonzero((np.sort(ends, axis=1) == chosen).all(axis=1)), 1)
            level = "final"
        else:
            (k,) = rng.choice(np.flatnonzero(crossing), 1)
            level = "base"
        part, onto = rng.permutation(base_pairs[k])
        yield Merge((int(face[part]),), int(face[onto]), level)


def looked_at(
    scan: Scan, made: sw.Segmentation, target: float, propose: Callable[[Session], Iterator[Edit]]
) -> dict[str, float]:
    """Proposals and edits until the target."""
    session = Session(scan.mesh, made)
    judge = Judge(session, scan.truth.labels)
    error, n, seconds = judge.error, 0, []
    proposals = propose(session)
    while error > target and n < MOST:
        start = time.perf_counter()
        edit = next(proposals, None)
        seconds.append(time.perf_counter() - start)
        if edit is None:
            n = MOST
            break
        n += 1
        try:
            session.do(edit)
        except EditError:
            continue
        judge.look()
        if judge.error < error:
            error = judge.error
        else:
            session.undo()
    return {
        "proposals": n,
        "followed": len(session.edits),
        "1-RI": error,
        "ms": 1e3 * float(np.median(seconds)),
    }


def main() -> None:
    """Print a row a scan."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--half", nargs="+", choices=list(HALVES), default=["judging"])
    parser.add_argument("--scans", nargs="+")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "scenewidget-quality")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = {}
    for scan in scans(arguments.scans, arguments.half, arguments.cache):
        made = sw.segment(scan.mesh, sw.Params(seed=arguments.seed))
        error = sw.metrics.rand_index_error(made.labels, scan.truth.labels)
        target = SHARE * error
        pairs = face_adjacency(scan.mesh)
        rng = np.random.default_rng(arguments.seed)
        ours = looked_at(scan, made, target, suggested)
        random = looked_at(scan, made, target, lambda s, r=rng, p=pairs: at_random(s, r, p))
        least = simulate_annotator(made, scan.truth, target=target)
        rows[scan.name] = {
            "1-RI": error, "target": target,
            **{f"suggested {name}": ours[name] for name in ("proposals", "followed", "ms")},
            **{f"random {name}": random[name] for name in ("proposals", "followed")},
            "least": len(least.edits),
        }  # fmt: skip
        print(scan.name, {name: round(value, 4) for name, value in rows[scan.name].items()}, flush=True)
    table = pd.DataFrame(rows).T
    for name, middle in (("mean", table.mean()), ("geometric mean", np.exp(np.log(table).mean()))):
        table.loc[name] = middle
    print(table.round(3).to_string())
    for name in ("mean", "geometric mean"):
        looks, edits = (
            table.loc[name, f"random {what}"] / table.loc[name, f"suggested {what}"]
            for what in ("proposals", "followed")
        )
        print(
            f"{name}: random needs {looks:.1f} times the proposals, {edits:.1f} times the edits (target: 3)"
        )


if __name__ == "__main__":
    main()
