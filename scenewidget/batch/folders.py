"""Which labels lie in a folder, which scan they are of, and how they are read.

Files belong together by their names: ``out/kitchen/a.ply/a.npz``, ``ann/kitchen/a.npz`` and
``truth/kitchen/a.xml`` are all of the scan ``kitchen/a``.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenewidget.batch.places import files_below, is_hidden, scans_in
from scenewidget.batch.rows import ROW, read_row, units_of
from scenewidget.editing.formats import import_labels
from scenewidget.editing.project_reader import is_project
from scenewidget.editing.session import Session
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.readers import load
from scenewidget.engine.segmentation import Segmentation
from scenewidget.engine.units import UnitName

__all__ = [
    "LABELS",
    "Labeled",
    "hands",
    "labeled",
    "labels_for",
    "mesh_of",
    "named_alike",
    "own_copies",
    "project_name",
    "read_labels",
    "some",
]

LABELS = (  # of several files of one scan the first is read: a project may hold corrections
    ".swproj", ".npz", ".npy", ".aggregation.json", ".xml", ".ply", ".glb", ".txt", ".label",
)  # fmt: skip


@dataclass(frozen=True)
class Labeled:
    """Labels of a scan in a file."""

    path: Path
    source: str = ""  # where the scan lay when they were made, "" if nobody knows
    units: UnitName | None = None  # in which the scan was read


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
    files_there = sorted(files_below(path))
    of_runs = [file for file in files_there if file.name == ROW]
    rows = {row.parent: content for row in of_runs if (content := read_row(row)) is not None}
    for folder, row in rows.items():
        files = [folder / name for name in row.get("files", {})]
        files.append(folder / project_name(row["scan"]))  # which a `Workbench` may have made since
        best = min((f for f in files if _rank(f) < len(LABELS) and f.exists()), key=_rank, default=None)
        if best is not None:
            _file_under(found, row, best)
    for file in sorted((p for p in files_there if _rank(p) < len(LABELS) and p.is_file()), key=_rank):
        inside = file.relative_to(path)
        if not any(parent in rows for parent in file.parents) and not is_hidden(inside):
            name = inside.as_posix()[: -len(LABELS[_rank(file)])]
            found.setdefault(name, Labeled(file))
    if not found:
        raise ValueError(f"no labels in {str(path)!r}; looked for files that end in {', '.join(LABELS)}")
    return dict(sorted(found.items()))


def labels_for(path: Path, scans: Collection[str]) -> dict[str, Labeled]:
    """Files of labels by names under which `named_alike` finds some of these scans.

    One file is of the scan that is called like it, or of the only one that there is.

    Raises
    ------
    ValueError
        None is of any of them.
    """
    files = labeled(path)
    if "" in files:
        rank = _rank(path)
        name = path.name[: -len(LABELS[rank])] if rank < len(LABELS) else path.stem
        alike = [scan for scan in scans if Path(scan).stem == name] or list(scans)
        files = {alike[0] if len(alike) == 1 else name: files[""]}
    if all(named_alike(scan, files) is None for scan in scans):
        raise ValueError(
            f"no scan has labels in {str(path)!r}: it has {some(files)}, and scans are {some(scans)}"
        )
    return files


def some(names: Iterable[str]) -> str:
    """A few of many names, for a message.

    Examples
    --------
    >>> some("dcab")
    "'a', 'b', 'c' …"
    """
    listed = sorted(names)
    return ", ".join(map(repr, listed[:3])) + (" …" if len(listed) > 3 else "")


def own_copies(path: Path) -> dict[str, dict[str, Labeled]]:
    """Who has corrected copies of their own in a folder of results: person -> name of the scan -> file."""
    found: dict[str, dict[str, Labeled]] = {}
    for file in sorted(file for file in files_below(path) if file.name == ROW):
        row = read_row(file)
        if row is None:
            continue
        for person, copy in hands(file.parent, row["scan"]).items():
            _file_under(found.setdefault(person, {}), row, copy)
    return dict(sorted(found.items()))


def _file_under(found: dict[str, Labeled], row: Mapping[str, Any], file: Path) -> None:
    """Add a file to others under the name of its scan, without the suffix where that is free."""
    name = str(Path(row["scan"]).with_suffix("").as_posix())
    found[row["scan"] if name in found else name] = Labeled(file, str(row.get("source", "")), units_of(row))


def project_name(scan: str, person: str = "") -> str:
    """Of the file beside a scan's results in which all correct it, or a person a copy of their own.

    Examples
    --------
    >>> project_name("kitchen/a.ply"), project_name("kitchen/a.ply", "ann")
    ('a.swproj', 'a.ann.swproj')
    """
    return Path(scan).stem + (f".{person}" if person else "") + ".swproj"


def hands(folder: Path, scan: str) -> dict[str, Path]:
    """Project files of a scan in the folder of its results, by person, of those who have a copy of their own.

    Examples
    --------
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as place:
    ...     hands(Path(place), "kitchen/a.ply")
    {}
    """
    pattern = re.compile(re.escape(Path(scan).stem) + r"\.(.+)\.swproj")
    found = {match[1]: path for path in folder.iterdir() if (match := pattern.fullmatch(path.name))}
    return {person: path for person, path in sorted(found.items()) if is_project(path)}


def mesh_of(name: str, scans: Path | None, labels: Iterable[Labeled]) -> Mesh:
    """The scan that some labels are of: from ``scans``, from where it lay, or out of the labels' own file.

    Raises
    ------
    ValueError
        It is nowhere; the message says what to give.
    """
    labels = list(labels)
    units = next((one.units for one in labels if one.units is not None), None)
    if scans is not None:
        if scans.is_file():
            return load(scans, units=units)
        for scan, found in scans_in(scans).items():
            if name in (scan, str(Path(scan).with_suffix("").as_posix())):
                return load(found.path, units=units)
        raise ValueError(f"{str(scans)!r} holds no scan {name!r}")
    for one in labels:
        if one.source and Path(one.source).exists():
            return load(one.source, units=one.units)
    for one in labels:
        file = one.path.with_suffix(".ply") if one.path.suffix.lower() == ".xml" else one.path
        if file.suffix.lower() in (".ply", ".glb") and file.exists():
            return load(file)
    raise ValueError("nobody knows which scan these labels are of; give the folder of scans by --scans")


def read_labels(path: Path, mesh: Mesh | None) -> Segmentation:
    """Labels of a file on a mesh; of a project as it stands after the last edit, the file left as it is."""
    if path.suffix.lower() == ".swproj":
        with (
            tempfile.TemporaryDirectory() as copies,  # opening a project writes that into it
            Session.open(shutil.copy(path, copies), mesh) as session,
        ):
            return session.segmentation
    if mesh is None:
        raise ValueError(f"{path.name!r} holds labels only; give the scan that they are of")
    return import_labels(mesh, path)


def _rank(path: Path) -> int:
    name = path.name.lower()
    return next((k for k, suffix in enumerate(LABELS) if name.endswith(suffix)), len(LABELS))


def named_alike(scan: str, names: Mapping[str, object]) -> str | None:
    """Under which of some names a scan stands: its own, or that without its suffix; None if under neither.

    Examples
    --------
    >>> named_alike("kitchen/a.ply", {"kitchen/a": 1})
    'kitchen/a'
    """
    bare = Path(scan).with_suffix("").as_posix()
    return next((name for name in (scan, bare) if name in names), None)
