"""Fit the numbers behind borders, cuts and confidence anew, on simulated rooms whose truth is exact.

    python -m scenewidget.calibrate [--rooms 28] [--first 100]

Rooms of four kinds of scanners are segmented as the default does. `engine.doubt.Models` is
fitted to that by logistic regression, every weight kept to its limits, and printed as it stands in
`engine.doubt.FITTED`. Real scans take no part: `tests/benchmarks/doubt.py` judges by them.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize

from scenewidget.engine.doubt import FITTED, LIMITS, Doubt, Models, doubts, log_odds, measure_gaps, run_kinds
from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.engine.pieces import Pieces
from scenewidget.engine.pipeline import segment

__all__ = ["Example", "count_things", "fit", "fit_logistic", "simulated", "wrong_faces"]

KINDS = ("depth camera", "hasty", "lidar", "depth camera")  # scanners of the rooms, over and over
PULL = 1e-3  # towards weights of zero, in standard deviations


@dataclass(frozen=True, eq=False)
class Example:
    """A segmentation and its truth.

    Attributes
    ----------
    pieces : Pieces
    keys : (n_base, n_runs) int
    runs : dict of str to int
        As of `doubts`.
    things : (n_pieces, n_things) float64
        Faces of each piece by the thing that they belong to.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.calibrate import Example, count_things
    >>> mesh, truth = sw.datasets.load_room()
    >>> pieces = truth.find_doubt().pieces
    >>> Example(pieces, np.zeros((1, 3), int), {}, count_things(pieces, truth.labels)).things.shape
    (31, 31)
    """

    pieces: Pieces
    keys: IntArray
    runs: dict[str, int]
    things: FloatArray


def count_things(pieces: Pieces, truth: IntArray) -> FloatArray:
    """(n_pieces, n_things) faces of each piece by thing; those with −1 aren't counted.

    Parameters
    ----------
    pieces : Pieces
    truth : (n_faces,) int

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.calibrate import count_things
    >>> mesh, truth = sw.datasets.load_room()
    >>> pieces = truth.find_doubt().pieces
    >>> count_things(pieces, truth.labels).shape == (truth.n_segments, truth.n_segments)
    True
    """
    keep = (pieces.face_piece >= 0) & (truth >= 0)
    n_things = int(truth.max(initial=-1)) + 1
    code = pieces.face_piece[keep].astype(np.int64) * n_things + truth[keep]
    return np.bincount(code, minlength=pieces.n * n_things).reshape(pieces.n, n_things).astype(float)


def wrong_faces(pieces: Pieces, things: FloatArray) -> tuple[Any, Any]:
    """(n_pieces, n_things) whether faces of a thing in a piece are foreign to their segment, or its rest.

    Foreign is what isn't of the thing that most of the segment is of; rest is what lies elsewhere than most
    of its thing.

    Parameters
    ----------
    pieces : Pieces
    things : (n_pieces, n_things) float64
        As of `count_things`.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.calibrate import count_things, wrong_faces
    >>> mesh, truth = sw.datasets.load_room()
    >>> pieces = truth.find_doubt().pieces
    >>> things = count_things(pieces, truth.labels)
    >>> [float((wrong * things).sum()) for wrong in wrong_faces(pieces, things)]
    [0.0, 0.0]
    """
    n = int(pieces.segment.max(initial=-1)) + 1
    table = np.zeros((n, things.shape[1]))
    np.add.at(table, pieces.segment, things)
    mostly, home = table.argmax(axis=1), table.argmax(axis=0)
    is_foreign = mostly[pieces.segment][:, None] != np.arange(things.shape[1])
    is_rest = (home != pieces.segment[:, None]) & ~is_foreign
    return is_foreign, is_rest


def simulated(n_rooms: int, first: int = 100) -> Iterator[Example]:
    """Examples of simulated rooms, as the default segments them.

    Parameters
    ----------
    n_rooms : int
    first : int
        Seed of the first room.

    Examples
    --------
    >>> from scenewidget.calibrate import simulated
    >>> list(simulated(0))
    []
    """
    from scenewidget.datasets import SCANNERS, simulate_room

    for i in range(n_rooms):
        rng = np.random.default_rng(first + i)
        options: dict[str, Any] = {
            **SCANNERS[KINDS[i % len(KINDS)]],
            "seed": first + i,
            "n_objects": int(rng.integers(8, 22)),
            "clutter": int(rng.integers(4, 24)),
            "voxel": float(rng.uniform(0.022, 0.03)),
        }
        options["noise"] *= float(rng.uniform(0.7, 2.0))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # not every room has a place for all that is asked for
            mesh, truth = simulate_room(**options)
            made = segment(mesh)
        assert made.keys is not None
        pieces = made.find_doubt().pieces
        yield Example(pieces, made.keys, dict(made.report["runs"]), count_things(pieces, truth.labels))


def fit(examples: list[Example]) -> Models:
    """The models that say best what is wrong with some segmentations.

    Parameters
    ----------
    examples : list of Example

    Examples
    --------
    >>> from scenewidget.calibrate import fit, simulated
    >>> models = fit(list(simulated(28)))  # doctest: +SKIP
    """
    found = [(e, doubts(e.pieces, e.keys, e.runs)) for e in examples]
    same = fit_logistic(*_stacked([_borders(e, d) for e, d in found]), LIMITS["same"])
    two = fit_logistic(*_stacked([_cuts(e, d) for e, d in found]), LIMITS["two"])
    apart = fit_logistic(*_stacked([_gaps(e) for e in examples]), LIMITS["apart"])
    models = FITTED._replace(same=same, two=two, apart=apart)
    usual = [(e, doubts(e.pieces, e.keys, e.runs, models=models)) for e in examples]
    each = fit_logistic(*_stacked([_each(e, d, same) for e, d in usual]), LIMITS["each"])
    likeliest = fit_logistic(*_stacked([_likeliest(e, d, two) for e, d in usual]), LIMITS["likeliest"])
    models = models._replace(each=each, likeliest=likeliest)
    rest = fit_logistic(*_stacked([_faces(e, d, "rest") for e, d in usual]), LIMITS["rest"])
    foreign = fit_logistic(*_stacked([_faces(e, d, "foreign") for e, d in usual]), LIMITS["foreign"])
    return models._replace(rest=rest, foreign=foreign)


def fit_logistic(
    measures: FloatArray, outcome: FloatArray, weights: FloatArray, limits: Sequence[tuple[float, float]]
) -> tuple[float, ...]:
    """Constant and weights of a logistic regression whose weights keep to limits.

    Parameters
    ----------
    measures : (n, m) float64
    outcome : (n,) float64
        Between 0 and 1.
    weights : (n,) float64
        Of each row, not negative.
    limits : sequence of (low, high)
        Of each weight.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.calibrate import fit_logistic
    >>> x = np.linspace(-3, 3, 50)[:, None]
    >>> constant, weight = fit_logistic(x, (x[:, 0] > 0) * 1.0, np.ones(50), [(0.0, 1.0)])
    >>> round(weight, 3)
    1.0
    """
    mean, spread = measures.mean(axis=0), measures.std(axis=0) + 1e-9
    standard, share = (measures - mean) / spread, weights / weights.sum()

    def loss(b: FloatArray) -> tuple[float, FloatArray]:
        score = standard @ b[1:] + b[0]
        miss = share * (1.0 / (1.0 + np.exp(-score)) - outcome)
        value = share @ (np.logaddexp(0.0, score) - outcome * score) + PULL * (b[1:] @ b[1:])
        return float(value), np.concatenate([[miss.sum()], standard.T @ miss + 2 * PULL * b[1:]])

    bounds = [(-np.inf, np.inf), *(tuple(np.multiply(limit, s)) for limit, s in zip(limits, spread))]
    start = np.concatenate([[0.0], [np.clip(0.0, low, high) for low, high in bounds[1:]]])
    found = minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds).x
    slopes = found[1:] / spread
    return (float(found[0] - slopes @ mean), *(float(slope) for slope in slopes))


Rows = tuple[FloatArray, FloatArray, FloatArray]  # measures, outcome, weight of each


def _stacked(parts: list[Rows]) -> Rows:
    measures, outcome, weights = (np.concatenate(column) for column in zip(*parts))
    return measures, outcome, weights


def _table(e: Example) -> FloatArray:
    table = np.zeros((int(e.pieces.segment.max()) + 1, e.things.shape[1]))
    np.add.at(table, e.pieces.segment, e.things)
    return table


def _borders(e: Example, d: Doubt) -> Rows:
    """Whether it is better to join segments that touch than not; large ones count more.

    By the root of the pairs of faces in question, the middle of counting borders alike, which says best how
    many are wrong, and counting what they cost, which says best which suggestions help.
    """
    table, borders = _table(e), d.borders
    one, other = table[borders.first], table[borders.second]
    mass = one.sum(axis=1) * other.sum(axis=1)
    same = np.asarray(2 * (one * other).sum(axis=1) > mass)
    return _weighted(borders.measures[mass > 0], same[mass > 0], mass[mass > 0])


def _each(e: Example, d: Doubt, weights: tuple[float, ...]) -> Rows:
    """Whether segments that touch are mostly of one thing; all count alike."""
    table, borders = _table(e), d.borders
    is_known, mostly = table.sum(axis=1) > 0, table.argmax(axis=1)
    keep = is_known[borders.first] & is_known[borders.second]
    odds = log_odds(weights, borders.measures[keep])
    same = np.equal(mostly[borders.first[keep]], mostly[borders.second[keep]])
    return odds[:, None], same.astype(float), np.ones(len(odds))


def _gaps(e: Example) -> Rows:
    """Whether segments in one plane that don't touch are mostly of one thing; large ones count more."""
    table, gaps = _table(e), measure_gaps(e.pieces, run_kinds(e.keys, e.runs)[0])
    size = table.sum(axis=1)
    mass = size[gaps.first] * size[gaps.second]
    mostly = table.argmax(axis=1)
    same = mostly[gaps.first] == mostly[gaps.second]
    return _weighted(gaps.measures[mass > 0], same[mass > 0], mass[mass > 0])


def _cuts(e: Example, d: Doubt) -> Rows:
    """Whether it is better to cut than not; large cuts count more."""
    rows: list[Rows] = [(np.empty((0, len(LIMITS["two"]))), np.empty(0), np.empty(0))]
    for cuts in d.cuts:
        if cuts is None or not cuts.n:
            continue
        small = np.array([e.things[cuts.side(c)].sum(axis=0) for c in range(cuts.n)])
        large = e.things[cuts.order].sum(axis=0) - small
        mass = small.sum(axis=1) * large.sum(axis=1)
        two = 2 * (small * large).sum(axis=1) < mass
        rows.append((cuts.measures[mass > 0], two[mass > 0].astype(float), mass[mass > 0]))
    measures, two, mass = _stacked(rows)
    return _weighted(measures, two, mass)


def _likeliest(e: Example, d: Doubt, weights: tuple[float, ...]) -> Rows:
    """Whether the sides of the likeliest cut of each segment are mostly of two things; all count alike."""
    measures, two = list[FloatArray](), list[bool]()
    for s, cuts in enumerate(d.cuts):
        if cuts is None or not cuts.n:
            continue
        small = e.things[d.side(s)].sum(axis=0)
        large = e.things[cuts.order].sum(axis=0) - small
        if small.any() and large.any():
            measures.append(cuts.measures[d.best[s]])
            two.append(bool(small.argmax() != large.argmax()))
    odds = log_odds(weights, np.array(measures).reshape(-1, len(weights) - 1))
    return odds[:, None], np.array(two, dtype=float), np.ones(len(two))


def _faces(e: Example, d: Doubt, kind: str) -> Rows:
    """Whether faces are foreign, or of those that aren't, whether they are the rest of a thing elsewhere."""
    is_foreign, is_rest = wrong_faces(e.pieces, e.things)
    if kind == "foreign":
        measures, outcome, weights = d.foreign_measures, is_foreign, e.things
    else:
        measures, outcome, weights = d.rest_measures[e.pieces.segment], is_rest, e.things * ~is_foreign
    rows, columns = np.nonzero(weights)
    weights = weights[rows, columns]
    return measures[rows], outcome[rows, columns].astype(float), weights / max(float(weights.sum()), 1.0)


def _weighted(measures: FloatArray, outcome: Any, mass: FloatArray) -> Rows:
    weights = np.sqrt(mass)
    return measures, outcome.astype(float), weights / max(float(weights.sum()), 1e-300)


def main() -> None:
    """Print the fitted numbers."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rooms", type=int, default=28, help="how many rooms to simulate")
    parser.add_argument("--first", type=int, default=100, help="seed of the first")
    arguments = parser.parse_args()
    examples = list(simulated(arguments.rooms, arguments.first))
    for name, weights in fit(examples)._asdict().items():
        print(f"{name}=({', '.join(f'{weight:.3f}' for weight in weights)}),")


if __name__ == "__main__":
    main()
