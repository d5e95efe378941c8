"""What commands share: which scans and labels lie in a folder, how they are read, how a table is shown."""

from __future__ import annotations

import argparse
import json
import math
import shutil
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import scenewidget as sw
from scenewidget.engine.readers import load
from scenewidget.engine.readers.sniff import MESHES

__all__ = [
    "ROW",
    "Labeled",
    "add_output",
    "labeled",
    "mesh_of",
    "read_labels",
    "read_row",
    "scans_in",
    "show",
    "tell",
]

ROW = "row.json"  # written last into the folder of a scan: the mark that it is done
SCANS = tuple(f".{kind}" for kind in (*MESHES, "pcd", "las", "laz", "e57", "xyz", "pts"))
LABELS = (  # of several files of one scan the first is read: a project may hold corrections
    ".swproj", ".npz", ".npy", ".aggregation.json", ".xml", ".ply", ".glb", ".txt", ".label",
)  # fmt: skip


@dataclass(frozen=True)
class Labeled:
    """Labels of a scan in a file."""

    path: Path
    source: str = ""  # where the scan lay when they were made, "" if nobody knows


def scans_in(paths: Sequence[Path]) -> dict[str, Path]:
    """Scans among files and in folders, also in those below; name -> path.

    The name is the path relative to the folder that was given, or that holds all that were given.

    Raises
    ------
    ValueError
        No such path, or no scan there.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            files = (p for p in path.rglob("*") if p.suffix.lower() in SCANS and p.is_file())
            found += (p for p in files if not _is_hidden(p.relative_to(path)))
        elif path.exists():
            found.append(path)
        elif any(sign in str(path) for sign in "*?["):
            base = Path(path.anchor)
            matches = [p for p in base.glob(str(path.relative_to(base))) if p.is_file()]
            found += matches
        else:
            raise ValueError(
                f"{str(path)!r} does not exist; give files, folders or a pattern such as 'scans/*.ply'"
            )
    if not found:
        listed = ", ".join(SCANS)
        raise ValueError(f"no scans in {', '.join(map(str, paths))}; looked for files that end in {listed}")
    absolute = sorted({path.absolute() for path in found})
    root = paths[0].absolute() if len(paths) == 1 and paths[0].is_dir() else _common_folder(absolute)
    return {path.relative_to(root).as_posix(): path for path in absolute}


def labeled(path: Path) -> dict[str, Labeled]:
    """Files of labels in a folder, name of the scan without its suffix -> file; "" -> the file if it is one.

    A folder that ``scenewidget segment`` wrote is read by its rows, any other by the names of its files.

    Raises
    ------
    ValueError
        No such path, or no labels there.
    """
    if path.is_file():
        return {"": Labeled(path)}
    if not path.is_dir():
        raise ValueError(f"{str(path)!r} does not exist; give a folder of labels, or one file")
    found: dict[str, Labeled] = {}
    rows = {row.parent: content for row in sorted(path.rglob(ROW)) if (content := read_row(row)) is not None}
    for folder, row in rows.items():
        files = [folder / name for name in row.get("files", {})]
        best = min((f for f in files if _rank(f) < len(LABELS) and f.exists()), key=_rank, default=None)
        if best is not None:
            name = str(Path(row["scan"]).with_suffix("").as_posix())
            found[row["scan"] if name in found else name] = Labeled(best, str(row.get("source", "")))
    for file in sorted((p for p in path.rglob("*") if _rank(p) < len(LABELS) and p.is_file()), key=_rank):
        inside = file.relative_to(path)
        if not any(parent in rows for parent in file.parents) and not _is_hidden(inside):
            name = inside.as_posix()[: -len(LABELS[_rank(file)])]
            found.setdefault(name, Labeled(file))
    if not found:
        raise ValueError(f"no labels in {str(path)!r}; looked for files that end in {', '.join(LABELS)}")
    return dict(sorted(found.items()))


def mesh_of(name: str, scans: Path | None, labels: Iterable[Labeled]) -> sw.Mesh:
    """The scan that some labels are of: from ``scans``, from where it lay, or out of the labels' own file.

    Raises
    ------
    ValueError
        It is nowhere; the message says what to give.
    """
    labels = list(labels)
    if scans is not None:
        if scans.is_file():
            return load(scans)
        for scan, path in scans_in([scans]).items():
            if name in (scan, str(Path(scan).with_suffix("").as_posix())):
                return load(path)
        raise ValueError(f"{str(scans)!r} holds no scan {name!r}")
    for one in labels:
        if one.source and Path(one.source).exists():
            return load(one.source)
    for one in labels:
        file = one.path.with_suffix(".ply") if one.path.suffix.lower() == ".xml" else one.path
        if file.suffix.lower() in (".ply", ".glb") and file.exists():
            return load(file)
    raise ValueError("nobody knows which scan these labels are of; give the folder of scans by --scans")


def read_labels(path: Path, mesh: sw.Mesh | None) -> sw.Segmentation:
    """Labels of a file on a mesh; of a project as it stands after the last edit, the file left as it is."""
    if path.suffix.lower() == ".swproj":
        with (
            tempfile.TemporaryDirectory() as copies,  # opening a project writes that into it
            sw.Session.open(shutil.copy(path, copies), mesh) as session,
        ):
            return session.segmentation
    if mesh is None:
        raise ValueError(f"{path.name!r} holds labels only; give the scan that they are of")
    return sw.import_labels(mesh, path)


def read_row(path: Path) -> dict[str, Any] | None:
    """What ``scenewidget segment`` noted of a scan; None if it is no such note."""
    try:
        row = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    is_ours = isinstance(row, dict) and isinstance(row.get("scan"), str) and isinstance(row.get("key"), str)
    return row if is_ours and isinstance(row.get("files"), dict) else None


def add_output(parser: argparse.ArgumentParser) -> None:
    """How a command speaks."""
    parser.add_argument("--json", action="store_true", help="print the table as JSON, a list of rows")
    parser.add_argument("--quiet", action="store_true", help="no progress, only the table and errors")


def tell(options: argparse.Namespace, line: str) -> None:
    """Progress, on stderr unless ``--quiet``."""
    if not options.quiet:
        print(line, file=sys.stderr, flush=True)


def show(rows: Sequence[Mapping[str, Any]], options: argparse.Namespace, *, mean: bool = False) -> None:
    """Print rows as a table, or as JSON with null for what isn't known."""
    if options.json:
        plain = [{key: _plain(value) for key, value in row.items()} for row in rows]
        print(json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False))
        return
    import pandas as pd

    table = pd.DataFrame(list(rows))
    for column in table.select_dtypes("number"):
        if all(isinstance(row.get(column), int | None) for row in rows):
            table[column] = table[column].astype("Int64")  # stays whole beside rows that have none
    errors = table.pop("error") if "error" in table else pd.Series(dtype=str)
    if errors.astype(bool).any():
        table["error"] = errors  # the widest column last
    if mean and len(table) > 1:
        means = table.select_dtypes("float").mean().to_dict()
        table = pd.concat([table, pd.DataFrame([{**means, "scan": "mean"}])], ignore_index=True)
    shown = table.astype(object).where(table.notna(), "")
    print(shown.to_string(index=False, float_format="{:.4f}".format))


def _plain(value: Any) -> Any:
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _rank(path: Path) -> int:
    name = path.name.lower()
    return next((k for k, suffix in enumerate(LABELS) if name.endswith(suffix)), len(LABELS))


def _is_hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)


def _common_folder(paths: Sequence[Path]) -> Path:
    folder = paths[0].parent
    while not all(path.is_relative_to(folder) for path in paths):
        folder = folder.parent
    return folder
