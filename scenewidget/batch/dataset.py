"""The whole dataset in the layout of ScanNet, with a train and a validation split and statistics."""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Collection, Iterable
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scenewidget.batch.folders import read_labels
from scenewidget.batch.places import is_url
from scenewidget.batch.worklist import STATES, Entry, Worklist
from scenewidget.editing.files import checked_path, explain
from scenewidget.editing.formats import export
from scenewidget.editing.formats.scan import save_mesh
from scenewidget.editing.formats.seal import write_files
from scenewidget.editing.formats.table import as_text
from scenewidget.engine.segmentation import Segmentation
from scenewidget.hands import consensus

__all__ = ["export_dataset", "split"]


def export_dataset(
    worklist: Worklist,
    target: str | os.PathLike[str],
    *,
    states: Collection[str] = ("done",),
    validation: float = 0.2,
    seed: int = 0,
    scans: Path | None = None,
    agreed: bool = False,
    overwrite: bool = False,
) -> pd.DataFrame:
    """Write all scans and their labels as ScanNet has them.

    In ``scans/<scene>``, ``<scene>_vh_clean_2.ply`` is the scan, ``<scene>.aggregation.json`` and
    ``<scene>.segs.json`` are its objects. ``train.txt`` and ``validation.txt`` list the scenes;
    ``scenes.csv`` and ``names.csv`` count.

    Parameters
    ----------
    worklist : Worklist
    target : path
        Made if missing.
    states : collection of str
        Which scans: "new", "begun", "review", "done".
    validation : float
        Share of the scenes for validation, 0 to 1; unless it is one of these, each part has a scene at least.
    seed : int
        Of the split.
    scans : Path, optional
        Where the scans are, if not where they were.
    agreed : bool
        Whether each scene has what those agree on whose own copies are in one of these states.
    overwrite : bool
        As of `export`.

    Returns
    -------
    table : pandas.DataFrame
        A row a scene, as in ``scenes.csv``: scan, scene, split, faces, segments, named, coverage, area (m²),
        seconds of work, people whose work is in it.

    Raises
    ------
    ValueError
        No scan is in one of these states, an unknown state, or a share that is none.

    Examples
    --------
    >>> export_dataset(None, "dataset", states=["finished"])
    Traceback (most recent call last):
        ...
    ValueError: states may hold 'new', 'begun', 'review', 'done', got 'finished'
    """
    if isinstance(states, str):
        raise TypeError(f"states must be a collection, such as [{states!r}], got a single str")
    unknown = [state for state in states if state not in STATES]
    if unknown:
        raise ValueError(f"states may hold {', '.join(map(repr, STATES))}, got {unknown[0]!r}")
    if not isinstance(validation, Real) or not 0 <= validation <= 1:
        raise ValueError(f"validation must lie in [0, 1], got {validation!r}")
    known = [entry for entry in worklist.entries.values() if not entry.has_failed]
    copies = {entry.scan: worklist.hands(entry, states) for entry in known} if agreed else {}
    chosen = [e for e in known if e.state in states or copies.get(e.scan)]
    if not chosen:
        others = sorted({person for entry in known for person in worklist.hands(entry, states)})
        hint = f"{', '.join(others)} have such copies of their own: agreed=True takes those" if others else ""
        whose = f"of {worklist.person!r} " if worklist.own else ""
        raise ValueError(
            f"no scan {whose}is {' or '.join(states) or 'chosen'} yet; "
            + (hint or f"correct some, or give states={STATES} for all of them")
        )
    place = checked_path(target)
    if is_url(target):
        raise ValueError(
            f"target must be a folder of this machine, got {target!r}: export, then send it there"
        )
    scenes = _scene_names(entry.scan for entry in chosen)
    train, held_out = split(scenes.values(), validation, seed)
    rows, names = [], []
    for entry in chosen:
        mesh = worklist.mesh(entry, scans)
        theirs = copies.get(entry.scan, {})
        drawn = {person: read_labels(path, mesh) for person, path in theirs.items()}
        labels = consensus(drawn, mesh) if drawn else worklist.labels(entry, mesh)
        scene = scenes[entry.scan]
        folder = place / "scans" / scene
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise explain(error, folder) from error
        save_mesh(mesh, folder / f"{scene}_vh_clean_2.ply", overwrite=overwrite)
        export(labels, mesh, folder / f"{scene}.aggregation.json", "scannet", overwrite=overwrite)
        seconds = worklist.seconds_of(entry, theirs) if theirs else sum(entry.seconds.values())
        people = len(theirs or entry.seconds)
        counted = _counted(entry, scene, labels, scene in held_out)
        rows.append(counted | {"seconds": round(seconds, 1), "people": people})
        areas = np.bincount(labels.labels[labels.labels >= 0], mesh.face_areas[labels.labels >= 0])
        names += [(as_text(name or "unannotated"), float(area)) for name, area in zip(labels.names, areas)]
    table = pd.DataFrame(rows)
    counts = pd.DataFrame(names, columns=["name", "area"]).groupby("name")["area"].agg(["count", "sum"])
    counts = counts.rename(columns={"count": "segments", "sum": "area"}).sort_values("area", ascending=False)
    texts = {
        "train.txt": "".join(f"{scene}\n" for scene in train),
        "validation.txt": "".join(f"{scene}\n" for scene in held_out),
        "scenes.csv": table.to_csv(index=False, lineterminator="\n"),
        "names.csv": counts.round(3).to_csv(lineterminator="\n"),
    }
    for name, text in texts.items():
        write_files({place / name: [text.encode()]}, asked=place / name, overwrite=overwrite, inputs=[])
    return table


def split(scenes: Iterable[str], validation: float, seed: int) -> tuple[list[str], list[str]]:
    """Scenes for training and for validation, one of each at least; one that comes along later moves hardly
    any other.

    Parameters
    ----------
    scenes : iterable of str
    validation : float
        Share of the second.
    seed : int

    Examples
    --------
    >>> train, validation = split([f"{i}" for i in range(100)], 0.2, 0)
    >>> len(train), len(validation)
    (80, 20)
    """
    names = sorted(scenes)
    lots = {name: hashlib.blake2b(f"{seed}:{name}".encode()).digest() for name in names}
    n_drawn = round(validation * len(names))
    if 0 < validation < 1 and len(names) > 1:
        n_drawn = min(max(n_drawn, 1), len(names) - 1)
    drawn = set(sorted(names, key=lambda name: lots[name])[:n_drawn])
    return [name for name in names if name not in drawn], [name for name in names if name in drawn]


def _counted(entry: Entry, scene: str, labels: Segmentation, is_held_out: bool) -> dict[str, Any]:
    return {
        "scan": as_text(entry.scan),
        "scene": as_text(scene),
        "split": "validation" if is_held_out else "train",
        "faces": labels.mesh.n_faces,
        "segments": labels.n_segments,
        "named": sum(1 for name in labels.names if name),
        "coverage": round(labels.coverage, 4),
        "area": round(float(labels.mesh.face_areas.sum()), 3),
    }


def _scene_names(scans: Iterable[str]) -> dict[str, str]:
    """Scene of each scan: its name without suffix where that is unique, folders joined by underscores.

    Names that differ only in the case of letters count as one: on many disks they are.
    """
    names = sorted(scans)
    bare = {scan: Path(scan).with_suffix("").as_posix().replace("/", "_") for scan in names}
    full = {scan: scan.replace("/", "_").replace(".", "_") for scan in names}
    marked = {scan: f"{full[scan]}_{hashlib.blake2b(scan.encode()).hexdigest()[:6]}" for scan in names}
    scenes: dict[str, str] = {}
    for choice in (bare, full, marked):
        taken = Counter(name.casefold() for name in choice.values())
        scenes = {s: n for s, n in choice.items() if taken[n.casefold()] == 1} | scenes
    return {scan: scenes[scan] for scan in names}
