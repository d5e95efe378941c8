"""How far several people agree, scan by scan.

Each folder holds the labels that one of them made, in any format that can be read, project files too.
Files belong together by their names, as first/kitchen/a.swproj and second/kitchen/a.swproj. Or it is one
folder that `scenewidget segment` wrote, in which people have corrected copies of their own, as with
sw.Workbench("out/", person="ann", own=True).

A row a scan and pair of people: errors and scores as of `scenewidget evaluate`, the share that both label of
what either does, and the share of what both have named that they call the same. With --per segment a row a
segment, the least agreed on first: which segment of the other goes best with it, their intersection over
union, and which share lies outside. With --per name a row a name. Scans that only one has labeled are left
out, and named.

  scenewidget agree ann/ bob/
  scenewidget agree out/ --per name
  scenewidget agree ann/ bob/ cyd/ --scans scans/ --json

Exit code: 0, or 1 if a scan could not be compared.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import scenewidget as sw
from scenewidget.batch.folders import Labeled, labeled, mesh_of, own_copies, read_labels
from scenewidget.command_line.shared import add_output, show, tell
from scenewidget.evaluation import METRICS

__all__ = ["add_parser", "run"]


def add_parser(commands: Any) -> None:
    """The command ``agree``."""
    parser = commands.add_parser(
        "agree",
        help="how far several people agree, a row a scan",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "people", nargs="+", type=Path, metavar="FOLDER", help="two or more, one a person; or one of all"
    )
    parser.add_argument("--scans", type=Path, help="the scans, where the labels don't say where they lie")
    parser.add_argument("--by", choices=("faces", "area"), default="faces", help="what the metrics count")
    parser.add_argument(
        "--metrics", nargs="+", choices=tuple(METRICS), metavar="NAME", help="only these columns"
    )
    parser.add_argument(
        "--per", choices=("pair", "segment", "name"), default="pair", help="what has a row; pair by default"
    )
    add_output(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the table; 1 if a scan could not be compared."""
    theirs = _by_person(options.people)
    rows: list[dict[str, Any]] = []
    n_compared = 0
    for scan in sorted({scan for found in theirs.values() for scan in found}):
        files = {name: found[scan] for name, found in theirs.items() if scan in found}
        if len(files) < 2:
            tell(options, f"{scan}  only {next(iter(files))} has labeled it: left out")
            continue
        shown = scan or next(iter(files.values())).path.name
        try:
            mesh = mesh_of(scan, options.scans, files.values())
            labels = {name: read_labels(file.path, mesh) for name, file in files.items()}
            table = sw.agreement(labels, mesh, by=options.by, metrics=options.metrics, per=options.per)
            if options.by == "faces":
                sizes = [column for column in table if column.startswith("size")]
                table = table.astype(dict.fromkeys(sizes, int))
            rows += ({"scan": shown, "error": "", **row} for row in table.reset_index().to_dict("records"))
            n_compared += 1
            tell(options, f"{shown}  compared")
        except (OSError, TypeError, ValueError) as error:
            rows.append({"scan": shown, "error": str(error)})
            tell(options, f"{shown}  {error}")
    if not n_compared and not rows:
        raise ValueError(f"no scan has been labeled by two of {', '.join(theirs)}; files go together by name")
    if not rows:
        tell(options, "nobody has named anything")
    show(rows, options, mean=options.per == "pair")
    return 1 if any(row["error"] for row in rows) else 0


def _by_person(folders: list[Path]) -> dict[str, dict[str, Labeled]]:
    """Files of labels of each person, by the name of the scan."""
    if len(folders) == 1:
        if not folders[0].is_dir():
            raise ValueError(f"{str(folders[0])!r} is no folder; agree takes two or more, one a person")
        copies = own_copies(folders[0])
        if len(copies) < 2:
            raise ValueError(
                f"agree takes two or more folders, one a person, and got only {folders[0]}; one is enough "
                "where two have corrected copies of their own in it: Workbench(…, person=…, own=True)"
            )
        return copies
    names = [path.name or str(path) for path in folders]
    if len(set(names)) < len(names):
        names = [str(path) for path in folders]
    if len(set(names)) < len(names):
        raise ValueError(f"the same folder is given twice: {', '.join(names)}")
    return {name: labeled(path) for name, path in zip(names, folders, strict=True)}
