"""Turn a scan, or the labels of one, into another format.

Without --mesh the source is a scan: its vertices, triangles and colours are written as PLY, OBJ, GLB, STL or
OFF (STL has no colours). With --mesh, or if the source is a project file, the source is labels: they are
written as PLY, NPZ, GLB, ScanNet (.aggregation.json), SceneNN (.xml), CSV, Parquet, NPY or TXT.

  scenewidget convert scan.glb scan.ply
  scenewidget convert scan.ply scan.glb --units mm
  scenewidget convert labels.npz scene.aggregation.json --mesh scan.ply
  scenewidget convert room.swproj room.glb

A file that is there stays, unless an export wrote it or --overwrite is given. Exit code: 0, or 1 with the
reason.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import scenewidget as sw
from scenewidget.batch.folders import read_labels
from scenewidget.command_line.shared import say

__all__ = ["add_parser", "run"]

ONLY_LABELS = (".npz", ".npy", ".aggregation.json", ".segs.json", ".xml", ".label")


def add_parser(commands: Any) -> None:
    """The command ``convert``."""
    parser = commands.add_parser(
        "convert",
        help="turn a scan, or its labels, into another format",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("source", type=Path, help="a scan, or labels")
    parser.add_argument("target", type=Path, help="the file to write; its suffix says the format")
    parser.add_argument("--mesh", type=Path, metavar="SCAN", help="the source is labels of this scan")
    parser.add_argument("--format", help="format of labels, where the suffix does not say it")
    parser.add_argument(
        "--units", choices=("m", "cm", "mm", "in", "ft", "auto"), help="what the numbers of the scan are"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace the target, whoever wrote it")
    parser.add_argument("--json", action="store_true", help="print the paths written as a JSON list")
    parser.add_argument("--quiet", action="store_true", help="print nothing if all goes well")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the target and print what was written."""
    mesh = None if options.mesh is None else sw.load(options.mesh, units=options.units)
    if mesh is not None or options.source.suffix.lower() == ".swproj":
        if not options.source.exists():
            raise FileNotFoundError(f"label file {str(options.source)!r} does not exist")
        labels = read_labels(options.source, mesh)
        written = sw.export(labels, labels.mesh, options.target, options.format, overwrite=options.overwrite)
    elif options.source.name.lower().endswith(ONLY_LABELS):
        raise ValueError(f"{options.source.name!r} holds labels; give the scan that they are of by --mesh")
    else:
        if options.format is not None:
            raise ValueError(
                "--format is for labels; the format of a scan is what the suffix of the target says"
            )
        written = _written(sw.load(options.source, units=options.units), options)
    if options.json:
        say(json.dumps([str(path) for path in written]))
    elif not options.quiet:
        say("\n".join(map(str, written)))
    return 0


def _written(scan: sw.Mesh, options: argparse.Namespace) -> list[Path]:
    try:
        return sw.save_mesh(scan, options.target, overwrite=options.overwrite)
    except ValueError as error:
        raise ValueError(f"{error}; for labels, give their scan by --mesh") from error
