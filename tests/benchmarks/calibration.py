"""Is the confidence a probability? Fits the constants of `engine.evidence` and says how far off they are.

    python tests/benchmarks/calibration.py [--cache DIR] [--chart reliability.png]

Fitted on the tuning half of the quality benchmark (`rooms`), judged on the other: the expected calibration
error (bins of the confidence against the share of face pairs rightly joined) of the agreement as it is, of
the confidence as the engine has it now, and of one fitted anew.
"""

from __future__ import annotations

import argparse
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
from rooms import HALVES, Scan, scans
from scipy.optimize import minimize, nnls

import scenewidget as sw
from scenewidget.editing.partition import Partition
from scenewidget.editing.suggestions import Evidence
from scenewidget.engine.evidence import SAME_THING, agreement_behind
from scenewidget.evaluation import reliability

KNOTS = np.array([0.0, 0.2, 0.35, 0.45, 0.55, 0.65, 0.8, 1.0])
# pairs are judged before the finish, which joins and parts by what the runs don't know
UNFINISHED = {"join_planes": False, "relief": 0.0, "contrast": 0.0, "furniture_similarity": 1.0}
LEAST_RISE = 0.03  # of the confidence, over that of the agreement: it must lead back
FINE = 100  # bins of the agreement that the fit sees


def pairs_of(scan: Scan, made: sw.Segmentation) -> pd.DataFrame:
    """Pairs of segments: mean co-association, share of the face pairs that belong together, face pairs."""
    evidence = Evidence(Partition(made))
    keep = (made.labels >= 0) & (scan.truth.labels >= 0)
    counts = np.zeros((made.n_segments, scan.truth.n_segments))
    np.add.at(counts, (made.labels[keep], scan.truth.labels[keep]), 1)
    counts = counts[evidence.ids]
    size = counts.sum(axis=1)
    i, j = np.triu_indices(len(size), 1)
    right = (counts @ counts.T / np.maximum(np.outer(size, size), 1))[i, j]
    weight = np.outer(size, size)[i, j] / size.sum() ** 2
    return pd.DataFrame({"C": evidence.between[i, j], "right": right, "weight": weight})


def fit_pairs(pairs: pd.DataFrame) -> tuple[float, float]:
    """Slope and middle of the sigmoid; each pair of segments weighs as much as it has face pairs."""
    C, right, weight = (pairs[name].to_numpy() for name in ("C", "right", "weight"))

    def loss(parameters: np.ndarray) -> float:
        x = parameters[0] * (C - parameters[1])
        return float((weight * (np.logaddexp(0, x) - right * x)).sum() / weight.sum())

    slope, middle = minimize(loss, SAME_THING, method="Nelder-Mead").x
    return float(slope), float(middle)


def fit_confidence(bins: pd.DataFrame) -> np.ndarray:
    """Values at the knots, rising from 0 and nowhere level, by least squares."""
    x, right, share = (bins[name].to_numpy() for name in ("confidence", "right", "share"))
    hats = np.stack([np.interp(x, KNOTS, unit) for unit in np.eye(len(KNOTS))], axis=1)
    steps = (hats @ np.tril(np.ones((len(KNOTS), len(KNOTS)))))[:, 1:]
    # a little pull towards even steps where no face is
    pull = 1e-2 * np.eye(len(KNOTS) - 1)
    root = np.sqrt(share)[:, None]
    least = LEAST_RISE * np.diff(KNOTS)
    values, _ = nnls(
        np.concatenate([steps * root, pull]),
        np.concatenate([(right - steps @ least) * root[:, 0], pull @ (np.diff(KNOTS) - least)]),
    )
    return np.concatenate([[0.0], np.cumsum(values + least)])


def error(bins: pd.DataFrame) -> float:
    """Expected calibration error."""
    return float((bins["share"] * (bins["confidence"] - bins["right"]).abs()).sum())


def main() -> None:
    """Print constants and errors."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "scenewidget-quality")
    parser.add_argument(
        "--chart", type=Path, help="where to draw the reliability diagram of the judging half"
    )
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    pairs: list[pd.DataFrame] = []
    made: dict[str, list[tuple[sw.Segmentation, sw.Segmentation]]] = {half: [] for half in HALVES}
    for scan in scans(None, list(HALVES), arguments.cache):
        pipe = sw.Pipeline(scan.mesh)
        segmentation = pipe.run()
        if scan.half == "tuning":
            pairs.append(pairs_of(scan, pipe.run(sw.Params(**UNFINISHED))))
        slim = sw.Segmentation(scan.mesh, segmentation.labels, segmentation.confidence)
        made[scan.half].append((slim, scan.truth))
        print(f"{scan.half}: {scan.name}", flush=True)
    slope, middle = fit_pairs(pd.concat(pairs))
    print(f"SAME_THING = ({slope:.1f}, {middle:.3f})")
    raw = {
        half: [
            (sw.Segmentation(s.mesh, s.labels, agreement_behind(s.confidence)), truth) for s, truth in both
        ]
        for half, both in made.items()
    }
    values = fit_confidence(mean_bins(raw["tuning"], FINE)).round(3)
    print(f"CONFIDENCE = ({tuple(KNOTS.tolist())}, {tuple(values.tolist())})")
    anew = [
        (sw.Segmentation(s.mesh, s.labels, np.interp(s.confidence, KNOTS, values) * (s.labels >= 0)), truth)
        for s, truth in raw["judging"]
    ]
    for name, both in {"agreement": raw["judging"], "now": made["judging"], "anew": anew}.items():
        bins = mean_bins(both, 10)
        print(f"\njudging half, {name}: expected calibration error {error(bins):.4f}\n{bins.round(3)}")
    if arguments.chart:
        sw.figures.reliability(mean_bins(made["judging"], 10)).savefig(arguments.chart)


def mean_bins(both: list[tuple[sw.Segmentation, sw.Segmentation]], n_bins: int) -> pd.DataFrame:
    """Reliability over several scans, each of which counts alike."""
    tables = [reliability(segmentation, truth, n_bins=n_bins) for segmentation, truth in both]
    every = pd.concat(tables)
    every["confidence"] *= every["share"]
    every["right"] *= every["share"]
    total = every.groupby(level=0)[["confidence", "right", "share"]].sum()
    total["confidence"] /= total["share"]
    total["right"] /= total["share"]
    total["share"] /= len(tables)
    return total


if __name__ == "__main__":
    main()
