"""Compare labels with a truth, scan by scan.

OUT is what `scenewidget segment` wrote, or any folder of label files (NPZ, NPY, TXT, PLY, GLB, ScanNet,
SceneNN, project files); TRUTH is another such folder. Files belong together by their names:
out/kitchen/a.ply/a.npz, or out/kitchen/a.npz, goes with truth/kitchen/a.npz, truth/kitchen/a.xml and so on.
Or both are one file each.

  scenewidget evaluate out/ --truth truth/
  scenewidget evaluate out/ --truth truth/ --person ann
  scenewidget evaluate mine.npz --truth truth.npz --scans scan.ply

Errors, lower is better: rand_index_error (1 − RI), global_consistency_error, local_consistency_error,
hamming_distance, cut_discrepancy, variation_of_information. Scores, higher is better: adjusted_rand_index,
mean_iou. Then the share of the truth that is labeled. Exit code: 0, or 1 if a scan could not be compared.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import scenewidget as sw
from scenewidget.batch.folders import Labeled, labeled, mesh_of, own_copies, read_labels, some
from scenewidget.command_line.shared import add_output, show, tell
from scenewidget.evaluation import METRICS

__all__ = ["add_parser", "run"]


def add_parser(commands: Any) -> None:
    """The command ``evaluate``."""
    parser = commands.add_parser(
        "evaluate",
        help="compare labels with a truth, a row a scan",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("out", type=Path, metavar="OUT", help="folder of labels, or one file")
    parser.add_argument("--truth", type=Path, required=True, help="folder of true labels, or one file")
    parser.add_argument("--scans", type=Path, help="the scans, where OUT doesn't say where they lie")
    parser.add_argument("--by", choices=("faces", "area"), default="faces", help="what the metrics count")
    parser.add_argument(
        "--metrics", nargs="+", choices=tuple(METRICS), metavar="NAME", help="only these columns"
    )
    parser.add_argument(
        "--person", help="judge the copies that this person has corrected: Workbench(…, own=True)"
    )
    add_output(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the table; 1 if a scan could not be compared."""
    ours = labeled(options.out) if options.person is None else _copies(options.out, options.person)
    truth = labeled(options.truth)
    if not set(ours) & set(truth):
        raise ValueError(
            f"no scan has labels in both: {options.out} has {some(ours)}, {options.truth} has {some(truth)}"
        )
    rows = []
    for name, found in ours.items():
        row: dict[str, Any] = {"scan": name or found.path.name, "error": ""}
        try:
            if name not in truth:
                raise ValueError(f"{options.truth} has no labels of it")
            mesh = mesh_of(name, options.scans, [found, truth[name]])
            sides = read_labels(found.path, mesh), read_labels(truth[name].path, mesh)
            table = sw.evaluate({"": sides[0]}, sides[1], mesh, by=options.by, metrics=options.metrics)
            row |= table.loc[""].to_dict()
            row |= {count: int(row[count]) for count in ("n_segments", "n_truth")}
        except (OSError, TypeError, ValueError) as error:
            row["error"] = str(error)
        tell(options, f"{row['scan']}  {row['error'] or 'compared'}")
        rows.append(row)
    show(rows, options, mean=True)
    return 1 if any(row["error"] for row in rows) else 0


def _copies(out: Path, person: str) -> dict[str, Labeled]:
    if not out.is_dir():
        raise ValueError(f"{str(out)!r} is no folder; --person wants one that `scenewidget segment` wrote")
    people = own_copies(out)
    if person not in people:
        listed = ", ".join(people) or "nobody"
        raise ValueError(f"{person!r} has no copies of their own in {str(out)!r}; {listed} has")
    return people[person]
