"""Segment every scan of a folder, one after the other, and go on where an earlier run stopped.

Each scan gets a folder of its own below --out, named like the scan, with the labels in every --format and,
written last, row.json: the mark that it is done. Files are there whole or not at all, so the run can be
stopped at any moment (Ctrl-C) and started again: what is done with the same file, the same parameters and
the same version of scenewidget is reused, everything else is made anew. A scan that can't be segmented is
reported and stops nobody. Files that this command did not write, or that somebody has changed since, are
never overwritten: a project that was corrected by hand stays.

  scenewidget segment scans/ --out out/
  scenewidget segment scans/*.ply --out out/ --preset thesis --set n_segments=30 --set seed=1
  scenewidget segment scans/ --out out/ --format npz --format swproj

The table has a row a scan: status is done, reused or failed, with the error. Exit code: 0 if all scans are
done or reused, 1 if one failed or nothing could be begun, 2 for words that aren't known, 130 after Ctrl-C.
"""

from __future__ import annotations

import argparse
import ast
import dataclasses
import hashlib
import json
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import scenewidget as sw
from scenewidget.command_line.shared import ROW, add_output, read_row, scans_in, show, tell
from scenewidget.editing.files import FileLock, replacing

__all__ = ["add_parser", "run"]

SUFFIXES = {  # format -> the files that it writes, the one to ask for first
    "npz": (".npz",),
    "ply": (".ply",),
    "glb": (".glb",),
    "scannet": (".aggregation.json", ".segs.json"),
    "scenenn": (".scenenn.xml", ".scenenn.ply"),  # the PLY is not that of "ply"
    "csv": (".csv",),
    "parquet": (".parquet",),
    "npy": (".npy",),
    "txt": (".txt",),
    "swproj": (".swproj",),
}
COLUMNS = ("scan", "status", "error", "seconds", "faces", "segments", "coverage")


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
        type=Path,
        help="folders (with all below), files, or a quoted pattern: 'scans/*.ply'",
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made if missing")
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
        choices=tuple(SUFFIXES),
        help="what to write, npz by default; may be repeated. swproj is a project for the editor",
    )
    parser.add_argument(
        "--units", choices=("m", "cm", "mm", "in", "ft", "auto"), help="what the numbers in the scans are"
    )
    parser.add_argument("--anew", action="store_true", help="reuse nothing of an earlier run")
    parser.add_argument("--workers", type=int, default=1, help="scans at a time: 1, more can't be had yet")
    parser.add_argument("--verbose", action="store_true", help="say every step of every scan")
    add_output(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Segment the scans and print the table; 1 if one failed."""
    if options.workers != 1:
        raise ValueError(
            f"--workers {options.workers}: scans are segmented one after the other, several at a time "
            "can't be had yet; leave --workers out, or run the command on parts of the folder, each with "
            "an --out of its own"
        )
    params = _params(options.preset, options.set)
    formats = tuple(dict.fromkeys(options.format or ["npz"]))
    out: Path = options.out
    scans = scans_in(options.scans)
    scans = {name: p for name, p in scans.items() if not p.is_relative_to(out.absolute())}
    if not scans:
        raise ValueError(f"all scans lie in --out {out}; choose another folder for the results")
    out.mkdir(parents=True, exist_ok=True)
    lock = FileLock(out / "scenewidget")
    holder = lock.acquire()
    if holder:
        raise ValueError(f"{str(out)!r} is being written by {holder}; wait for it, or choose another --out")
    rows: list[dict[str, Any]] = []
    try:
        for number, (name, path) in enumerate(scans.items(), 1):
            row = _row(name, path, out / name, params, formats, options)
            rows.append(row)
            tell(options, f"[{number}/{len(scans)}] {_line(row)}{_left(rows, len(scans))}")
    except KeyboardInterrupt:
        show(rows, options)
        tell(options, f"stopped after {len(rows)} of {len(scans)} scans; the same command goes on from there")
        return 130
    finally:
        lock.release()
    show(rows, options)
    return 1 if any(row["status"] == "failed" for row in rows) else 0


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


def _row(
    name: str,
    path: Path,
    folder: Path,
    params: sw.Params,
    formats: Sequence[str],
    options: argparse.Namespace,
) -> dict[str, Any]:
    """What became of a scan; never raises but for Ctrl-C."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS)
    row |= {"scan": name, "status": "failed", "error": ""}
    start = time.perf_counter()
    try:
        key = _key(path, params, formats, options.units)
        old = read_row(folder / ROW)
        if old is not None and old["key"] == key and not options.anew and _is_whole(folder, old):
            return row | {c: old.get(c) for c in COLUMNS[3:]} | {"status": "reused"}
        if old is None and (folder / ROW).exists():
            raise FileExistsError(f"{str(folder / ROW)!r} is there, and this command did not write it")
        segmentation, said = _segmented(path, params, options)
        if _key(path, params, formats, options.units) != key:
            raise OSError(f"{path.name!r} changed while it was being segmented; run again")
        row |= {
            "faces": segmentation.mesh.n_faces,
            "segments": segmentation.n_segments,
            "coverage": round(segmentation.coverage, 4),
        }
        folder.mkdir(parents=True, exist_ok=True)
        (folder / ROW).unlink(missing_ok=True)  # no longer done, until everything is written
        written = _write(segmentation, params, folder / path.stem, formats, old or {"files": {}})
        row |= {"status": "done", "seconds": round(time.perf_counter() - start, 3)}
        note = row | {
            "files": {file.name: _mark(file) for file in written},
            "key": key,
            "source": str(path),
            "params": dataclasses.asdict(params),
            "version": sw.__version__,
            "warnings": said,
        }
        with replacing(folder / ROW) as temporary:
            temporary.write_text(json.dumps(note, indent=1, ensure_ascii=False), encoding="utf-8")
    except Exception as error:  # whatever one scan does, the others go on
        text = str(error) or "no reason given"
        known = isinstance(error, (OSError, ValueError, TypeError))
        row |= {"status": "failed", "error": text if known else f"{type(error).__name__}: {text}"}
        row["seconds"] = round(time.perf_counter() - start, 3)
    return row


def _segmented(
    path: Path, params: sw.Params, options: argparse.Namespace
) -> tuple[sw.Segmentation, list[str]]:
    """The segmentation of a scan, and the warnings on the way."""
    stage = ""

    def progress(name: str, fraction: float) -> None:
        nonlocal stage
        if name != stage:
            stage = name
            tell(options, f"    {name}")

    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always", UserWarning)
        mesh = sw.load(path, units=options.units)
        found = sw.segment(mesh, params, progress=progress if options.verbose else None)
    said = [str(one.message) for one in heard if issubclass(one.category, UserWarning)]
    if options.verbose:
        for line in said:
            tell(options, f"    {line}")
    return found, said


def _write(
    segmentation: sw.Segmentation, params: sw.Params, stem: Path, formats: Sequence[str], old: dict[str, Any]
) -> list[Path]:
    """Write every format; files that an earlier run wrote and nobody has touched since may go."""
    written: list[Path] = []
    for name in formats:
        targets = [stem.with_name(stem.name + suffix) for suffix in SUFFIXES[name]]
        target = targets[0]
        there = [path for path in targets if path.exists()]
        is_ours = all(old["files"].get(path.name) == _mark(path) for path in there)
        if name == "swproj":
            session = sw.Session(segmentation.mesh, segmentation, params=params)
            try:
                written.append(session.save(target, overwrite=is_ours))
            finally:
                session.close()
        else:
            written += sw.export(segmentation, segmentation.mesh, target, name, overwrite=is_ours)
    return written


def _key(path: Path, params: sw.Params, formats: Sequence[str], units: str | None) -> str:
    """Digest of all that decides over the result: the scan's bytes, the parameters, the version."""
    digest = hashlib.blake2b(digest_size=16)
    buffers = sorted(path.parent.glob("*.bin")) if path.suffix.lower() == ".gltf" else []
    for file in (path, *buffers):
        with file.open("rb") as stream:
            while block := stream.read(1 << 22):
                digest.update(block)
    rest = [dataclasses.asdict(params), sorted(formats), units, sw.__version__]
    digest.update(json.dumps(rest, sort_keys=True).encode())
    return digest.hexdigest()


def _mark(file: Path) -> list[int]:
    """By which a file is known again: size and time."""
    found = file.stat()
    return [found.st_size, found.st_mtime_ns]


def _is_whole(folder: Path, row: dict[str, Any]) -> bool:
    """Whether all files of a row are there; those that somebody corrected count."""
    return all((folder / name).is_file() for name in row["files"])


def _line(row: dict[str, Any]) -> str:
    if row["status"] == "failed":
        return f"{row['scan']}  failed: {row['error']}"
    return f"{row['scan']}  {row['status']}  {row['segments']} segments  {row['seconds']:.1f} s"


def _left(rows: Sequence[dict[str, Any]], n: int) -> str:
    """Time that the rest will take if it is like the scans that this run has segmented."""
    spent = [row["seconds"] for row in rows if row["status"] == "done"]
    if not spent or len(rows) == n:
        return ""
    seconds = sum(spent) / len(spent) * (n - len(rows))
    return f"  (about {seconds / 60:.0f} min left)" if seconds >= 90 else f"  (about {seconds:.0f} s left)"
