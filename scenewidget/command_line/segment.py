"""Segment every scan of a folder, on one core or many, and go on where an earlier run stopped.

Each scan gets a folder of its own below --out, named like the scan, with the labels in every --format, a
small picture and, written last, row.json: the mark that it is done. Files are there whole or not at all, so
the run can be stopped at any moment (Ctrl-C) and started again: what is done with the same file, the same
parameters and the same version of scenewidget is reused, everything else is made anew. A scan that can't be
segmented is reported and stops nobody. Files that this command did not write, or that somebody has changed
since, are never overwritten: a project that was corrected by hand stays.

  scenewidget segment scans/ --out out/
  scenewidget segment scans/ --out out/ --workers 8 --format npz --format swproj
  scenewidget segment scans/*.ply --out out/ --preset thesis --set n_segments=30 --set seed=1
  scenewidget segment s3://bucket/scans --out s3://bucket/out --scheduler tcp://10.0.0.5:8786

Without --workers and --scheduler the scans are segmented one after the other in this process. Both want Dask:
pip install "scenewidget[batch]".

The table has a row a scan: status is done, reused, failed, killed (its process died, also when nothing else
ran) or too large, with the error. Exit code: 0 if all scans are done or reused, 1 if one is not or nothing
could be begun, 2 for words that aren't known, 130 after Ctrl-C,
143 after SIGTERM.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import scenewidget as sw
from scenewidget.batch.places import is_url
from scenewidget.batch.plan import FORMATS
from scenewidget.batch.progress import spoken_row, spoken_time
from scenewidget.batch.runs import UNITS, Run, planned
from scenewidget.command_line.shared import add_output, say, show, tell

__all__ = ["add_parser", "run"]

NEXT = ", which sw.Workbench shows in a notebook to be corrected"


def add_parser(commands: Any) -> None:
    """The command ``segment``."""
    parser = commands.add_parser(
        "segment",
        help="segment every scan of a folder; can be stopped and goes on",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "scans",
        nargs="+",
        help="folders (with all below), files, URLs, or a quoted pattern: 'scans/*.ply'",
    )
    parser.add_argument("--out", required=True, help="folder or URL for the results; made if missing")
    parser.add_argument("--preset", choices=("default", "thesis"), default="default")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="an option of sw.Params, such as n_segments=30; may be repeated",
    )
    parser.add_argument(
        "--format",
        action="append",
        choices=tuple(FORMATS),
        help="what to write, npz by default; may be repeated. swproj is a project for the editor",
    )
    parser.add_argument("--units", choices=UNITS, help="what the numbers in the scans are")
    parser.add_argument(
        "--tile-faces",
        type=int,
        metavar="N",
        help="segment larger scans tile by tile, for want of memory",
    )
    parser.add_argument("--anew", action="store_true", help="reuse nothing of an earlier run")
    parser.add_argument("--truth", type=Path, help="folder of true labels; adds their metrics to the table")
    parser.add_argument("--workers", type=int, help="scans at a time, each in a process of its own")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler: tcp://10.0.0.5:8786")
    parser.add_argument("--verbose", action="store_true", help="say every step, without --workers")
    add_output(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Segment the scans and print the table; 1 if one is neither done nor reused."""
    n_workers = options.workers
    if n_workers is None and options.scheduler is None:
        n_workers = 0
    found = planned(
        options.scans,
        options.out,
        _params(options.preset, options.set),
        client=options.scheduler,
        n_workers=n_workers,
        formats=options.format or ["npz"],
        truth=options.truth,
        resume=not options.anew,
        units=options.units,
        tile_faces=options.tile_faces,
    )

    def hear(run: Run, row: dict[str, Any]) -> None:
        left = spoken_time(run.seconds_left)
        line = f"[{len(run.rows)}/{len(run.scans)}] {spoken_row(row)}"
        tell(options, f"{line}  ({left})" if left else line)

    stopped: list[int] = []
    try:
        with _stopped_by_sigterm(stopped):
            found.work(hear, tell=(lambda line: tell(options, line)) if options.verbose else None)
    except KeyboardInterrupt:
        show(_rows(found), options)
        n = len(found.scans)
        tell(options, f"stopped after {len(found.rows)} of {n} scans; the same command goes on from there")
        return 128 + (stopped or [signal.SIGINT])[0]
    except ConnectionError as error:
        if not found.rows:
            raise
        show(_rows(found), options)
        say(f"scenewidget segment: {error}", sys.stderr)
        return 1
    show(_rows(found), options)
    are_done = [row["status"] in ("done", "reused") for row in found.rows.values()]
    following = NEXT if any(are_done) and not is_url(options.out) else ""
    tell(options, f"\n{found.summary}; in {options.out}{following}")
    return 0 if all(are_done) else 1


@contextlib.contextmanager
def _stopped_by_sigterm(stopped: list[int]) -> Iterator[None]:
    """SIGTERM, as queues of clusters send it, ends what runs as Ctrl-C does, and is noted in the list."""

    def stop(number: int, _: Any) -> None:
        stopped.append(number)
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():  # which alone hears signals
        yield
        return
    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _rows(run: Run) -> list[dict[str, Any]]:
    return [run.rows[scan] for scan in run.scans if scan in run.rows]


def _params(preset: str, changes: Sequence[str]) -> sw.Params:
    values: dict[str, Any] = {}
    for change in changes:
        name, sign, text = change.partition("=")
        if not (sign and name.strip() and text.strip()):
            raise ValueError(f"--set takes name=value, such as n_segments=30, got {change!r}")
        try:
            values[name.strip()] = ast.literal_eval(text.strip())
        except (ValueError, SyntaxError):
            values[name.strip()] = text.strip()  # a word, such as auto
    return sw.Params.thesis(**values) if preset == "thesis" else sw.Params(**values)
