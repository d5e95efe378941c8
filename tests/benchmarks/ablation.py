"""What each part of the default brings: one left out or replaced at a time, on real and simulated scans.

    python tests/benchmarks/ablation.py [--kinds kitchens tables simulated] [--rows "no hop"] [--seeds 0 1 2]
        [--csv notebooks/ablation.csv]

For each scan and variant the mean over the seeds of the errors by faces (`real.errors`: faces without
annotation left out, crumbs given to the nearest larger piece), the number of segments, and how far two seeds
agree (mean IoU by area, mean over the pairs of seeds). Then per kind of scan the means, as differences to the
default, and on how many scans a variant has a larger 1 − RI. Simulated rooms are the judging half of `rooms`.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import real
from rooms import scans

import scenewidget as sw

VARIANTS: dict[str, dict[str, Any]] = {
    "default": {},
    "simplified mesh instead of superfacets": {"items": "simplified", "n_items": 10_000},
    "lengths in metres": {"scale": 1.0},
    "no normal filter": {"filter_sweeps": 0},
    "no bridges": {"bridge": 0.0},
    "half the superfacets": {"n_items": 3_000, "item_area": 0.006},
    "convex edges like concave ones": {"convex_weights": (1.0,)},
    "no k-medoids runs": {"n_runs": 0},
    "no graph runs": {"n_graph_runs": 0},
    "half the graph runs": {"n_graph_runs": 80},
    "cotangent δ feature": {"feature": "cotangent"},
    "GPS feature": {"feature": "gps"},
    "runs merged over planes": {"merge": True},
    "PEAC": {"consensus": "peac"},
    "median partition": {"consensus": "median"},
    "no hop": {"hop": 0.0},
    "cost exponent 2": {"cost_exponent": 2.0},
    "k of 40 to 50": {"k_range": (40, 50)},
    "shares by dihedral parts": {"allocation": "dihedral"},
    "random starts": {"init": "random"},
    "first of equal medoids": {"medoid_ties": "first"},
    "planes not joined": {"join_planes": False},
    "reliefs left": {"relief": 0.0},
    "colours not looked at": {"contrast": 0.0},
    "furniture not joined": {"furniture_similarity": 1.0},
    "crumbs kept": {"min_area": 0.0},
}
KINDS = ("kitchens", "tables", "simulated")
ERRORS = ["1-RI", "GCE", "LCE"]


def read(kinds: list[str]) -> Iterator[tuple[str, str, sw.Mesh, np.ndarray]]:
    """Kind, name, scan and true labels, −1 where there is none."""
    for name in real.SCANS:
        kind = "tables" if name.startswith("tabletop") else "kitchens"
        if kind in kinds and (real.REAL / f"{name}.npz").exists():
            yield kind, name, *real.read(name)
    if "simulated" in kinds:
        for scan in scans(None, ["judging"], Path(tempfile.gettempdir()) / "scenewidget-quality"):
            yield "simulated", scan.name, scan.mesh, scan.truth.labels


def row(pipe: sw.Pipeline, mesh: sw.Mesh, truth: np.ndarray, params: sw.Params, seeds: list[int]) -> dict:
    """Means over the seeds of one variant on one scan."""
    found = [pipe.run(params.replace(seed=seed)).labels for seed in seeds]
    least = real.crumb(mesh)
    pairs = itertools.combinations(found, 2)
    agreement = [real.agreement(a, b, mesh.face_areas, least)[0] for a, b in pairs]
    means = np.mean([real.errors(mesh, labels, truth) for labels in found], axis=0)
    return {
        **dict(zip(ERRORS, means)),
        "segments": np.mean([labels.max() + 1 for labels in found]),
        "seeds agree": np.mean(agreement) if agreement else np.nan,
    }


def main() -> None:
    """Print differences to the default per kind of scan, and write the rows of all scans."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--rows", nargs="+", choices=list(VARIANTS), default=list(VARIANTS))
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--csv", type=Path, help="where to write the rows; notebook 10 shows them")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    names = dict.fromkeys(["default", *arguments.rows])
    rows = {}
    for kind, scan, mesh, truth in read(arguments.kinds):
        pipe = sw.Pipeline(mesh)  # stages that variants share are computed once
        for name in names:
            params = sw.Params().replace(**VARIANTS[name])
            rows[kind, scan, name] = row(pipe, mesh, truth, params, arguments.seeds)
        print(f"{scan}: done", flush=True)
    table = pd.DataFrame(rows).T.rename_axis(["kind", "scan", "row"])
    for kind, part in table.groupby(level="kind", sort=False):
        means = part.groupby(level="row", sort=False).mean()
        by_scan = part["1-RI"].unstack("row")
        print(f"\n{kind}, {len(by_scan)} scans; default:\n{means.loc['default'].round(4).to_string()}\n")
        differences = means - means.loc["default"]
        differences["worse on"] = by_scan.gt(by_scan["default"], axis=0).sum()
        print(differences.drop("default").sort_values("1-RI", ascending=False).round(4).to_string())
    if arguments.csv:
        table.round(4).to_csv(arguments.csv)


if __name__ == "__main__":
    main()
