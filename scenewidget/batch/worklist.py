"""What people have done with the results of a run: the state of each scan, who worked on it and how long.

Beside ``row.json`` lies ``work.json``, or ``work.<person>.json`` where each person works on a copy of their
own. Who has a scan open holds a lock on it that ends with the process, however that ends.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from scenewidget.batch.folders import LABELS, hands, project_name, read_labels
from scenewidget.batch.picture import PICTURE
from scenewidget.batch.places import files_below
from scenewidget.batch.rows import FAILED, ROW, parse_row, units_of
from scenewidget.editing.files import FileLock, explain, replacing
from scenewidget.editing.session import Session
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.readers import load
from scenewidget.engine.segmentation import Segmentation

__all__ = ["STATES", "Entry", "State", "Stopwatch", "Worklist"]

State = Literal["new", "begun", "review", "done"]
STATES: tuple[State, ...] = ("new", "begun", "review", "done")
IDLE = 120.0  # seconds between two edits that count as work at most


@dataclass(frozen=True)
class Entry:
    """A scan with its results, and what people have done with them.

    Attributes
    ----------
    scan : str
    folder : Path
        Of its results.
    row : dict
        As `segment_all` wrote it; without ``faces`` where the scan failed.
    state : "new" | "begun" | "review" | "done"
    seconds : dict of str to float
        How long each person worked on it.
    edits : int
    errors : dict of str to float
        Metrics after the last correction, where there is a truth.

    Examples
    --------
    >>> from pathlib import Path
    >>> Entry("a.ply", Path("out/a.ply"), {"doubt": 0.2}).state
    'new'
    """

    scan: str
    folder: Path
    row: dict[str, Any]
    state: State = "new"
    seconds: dict[str, float] = field(default_factory=dict)
    edits: int = 0
    errors: dict[str, float] = field(default_factory=dict)

    @property
    def has_failed(self) -> bool:
        """Whether there is nothing to correct."""
        return "key" not in self.row or not self.row["key"]

    @property
    def facts(self) -> dict[str, Any]:
        """What a table says of it: scan, state, doubt, faces, segments, edits, seconds, people, error."""
        return {
            "scan": self.scan,
            "state": "failed" if self.has_failed else self.state,
            "doubt": self.row.get("doubt"),
            "faces": self.row.get("faces"),
            "segments": self.row.get("segments"),
            "edits": self.edits,
            "seconds": sum(self.seconds.values()),
            "people": sorted(self.seconds),
            "error": self.row.get("error") or "",
        }


class Worklist:
    """All scans of a folder that `segment_all` wrote.

    Parameters
    ----------
    out : path
    person : str
        Who works now.
    own : bool
        Whether every person corrects a copy of their own, as for measuring how far they agree.

    Raises
    ------
    ValueError
        Nothing of ours is there, or somebody else has files of the same name.

    Examples
    --------
    >>> Worklist("no/such/folder", "ann")
    Traceback (most recent call last):
        ...
    ValueError: no results in 'no/such/folder': give the folder that segment_all wrote
    """

    def __init__(self, out: str | Path, person: str, *, own: bool = False) -> None:
        self.out = Path(out)
        self.person = person
        self.own = own
        self.entries: dict[str, Entry] = {}
        self.refresh()
        if not self.entries:
            raise ValueError(f"no results in {str(out)!r}: give the folder that segment_all wrote")
        if own:
            self._refuse_namesake()

    def refresh(self) -> None:
        """Read again what others may have done since."""
        folders = {path.parent for path in files_below(self.out) if path.name in (ROW, FAILED)}
        entries = [entry for folder in sorted(folders) if (entry := self._read(folder)) is not None]
        self.entries = {entry.scan: entry for entry in entries}

    def _refuse_namesake(self) -> None:
        """Raise if somebody else's copies have the same file names, which some disks say of Ann and ann."""
        for entry in self.entries.values():
            other = (_json(entry.folder / self._work_name, is_row=False) or {}).get("by", self.person)
            if other != self.person:
                raise ValueError(
                    f"person {self.person!r} would write into the copies of {other!r}: "
                    "their files have the same names here; give another name"
                )

    def reread(self, scan: str) -> Entry:
        """One entry as it is on disk now."""
        entry = self._read(self.entries[scan].folder)
        if entry is not None:
            self.entries[scan] = entry
        return self.entries[scan]

    def _read(self, folder: Path) -> Entry | None:
        row = next((row for name in (ROW, FAILED) if (row := _json(folder / name)) is not None), None)
        if row is None:
            return None
        work = _json(folder / self._work_name, is_row=False) or {}
        return Entry(
            scan=row["scan"],
            folder=folder,
            row=row,
            state=_state(work),
            seconds=_numbers(work.get("seconds")),
            edits=edits if isinstance(edits := work.get("edits"), int) else 0,
            errors=_numbers(work.get("errors")),
        )

    @property
    def _work_name(self) -> str:
        return _own_name(self.person) if self.own else "work.json"

    def project(self, entry: Entry) -> Path:
        """File in which a scan is corrected.

        Parameters
        ----------
        entry : Entry
        """
        return entry.folder / project_name(entry.scan, _plain(self.person) if self.own else "")

    def rooms(self, entry: Entry) -> Path:
        """Folder in which a scan is corrected room by room, if it is too large to be edited whole.

        Parameters
        ----------
        entry : Entry
        """
        return self.project(entry).with_suffix(".rooms")

    def note(
        self,
        scan: str,
        *,
        state: State | None = None,
        seconds: float = 0.0,
        edits: int | None = None,
        errors: dict[str, float] | None = None,
    ) -> Entry:
        """Write down what has been done with a scan.

        Parameters
        ----------
        scan : str
        state : State, optional
            If it has changed.
        seconds : float
            Of work, added to what this person has.
        edits : int, optional
        errors : dict, optional

        Raises
        ------
        OSError
            It can't be written.
        """
        entry = self.reread(scan)
        worked = dict(entry.seconds)
        if seconds > 0:
            worked[self.person] = round(worked.get(self.person, 0.0) + seconds, 1)
        work = {
            "state": state or entry.state,
            "seconds": worked,
            "edits": entry.edits if edits is None else edits,
            "errors": entry.errors if errors is None else errors,
            "by": self.person,
            "time": round(time.time(), 1),
        }
        with replacing(entry.folder / self._work_name) as temporary:
            temporary.write_text(
                json.dumps(work, indent=1, ensure_ascii=False), encoding="utf-8", newline="\n"
            )
        return self.reread(scan)

    def lock(self, scan: str) -> tuple[FileLock | None, str]:
        """The lock on a scan, or None and who has it.

        Parameters
        ----------
        scan : str
        """
        lock = FileLock(self.entries[scan].folder / self._work_name)
        try:
            holder = lock.acquire()
        except OSError as error:
            raise explain(error, self.entries[scan].folder) from error
        return (None, holder) if holder else (lock, "")

    def open(self, scan: str, mesh: Mesh) -> Session:
        """The session in which a scan is corrected; its file is made if there is none yet.

        Parameters
        ----------
        scan : str
        mesh : Mesh

        Raises
        ------
        FileNotFoundError
            There are no labels to begin with.
        ProjectError
            The project file is damaged, or of another mesh.
        """
        entry = self.entries[scan]
        path = self.project(entry)
        if path.exists():
            return Session.open(path, mesh)
        session = Session(mesh, self._automatic(entry, mesh), params=_params(entry.row))
        session.save(path, overwrite=False)
        return session

    def _automatic(self, entry: Entry, mesh: Mesh) -> Segmentation:
        files = entry.row["files"]
        names = [name for suffix in LABELS for name in files if name.lower().endswith(suffix)]
        there = [entry.folder / name for name in names if (entry.folder / name).exists()]
        if not there:
            raise FileNotFoundError(f"no labels of {entry.scan!r} are left in {str(entry.folder)!r}")
        return read_labels(there[0], mesh)

    def mesh(self, entry: Entry, scans: Path | None = None) -> Mesh:
        """The scan itself, in the unit in which it was segmented.

        Parameters
        ----------
        entry : Entry
        scans : Path, optional

        Raises
        ------
        FileNotFoundError
            It is nowhere.
        """
        return load(self.source(entry, scans), units=units_of(entry.row))

    def source(self, entry: Entry, scans: Path | None = None) -> Path:
        """The file of a scan, where it lay or in a folder of scans.

        Parameters
        ----------
        entry : Entry
        scans : Path, optional

        Raises
        ------
        FileNotFoundError
            It is nowhere.
        """
        source = Path(entry.row.get("source", "")) if scans is None else scans / entry.scan
        if not source.is_file():
            raise FileNotFoundError(
                f"the scan {entry.scan!r} is not at {str(source)!r} any more; "
                "give the folder in which the scans are now: scans="
            )
        return source

    def labels(self, entry: Entry, mesh: Mesh) -> Segmentation:
        """What a scan's labels are now: as corrected, or automatic.

        Parameters
        ----------
        entry : Entry
        mesh : Mesh
        """
        path = self.project(entry)
        return read_labels(path, mesh) if path.exists() else self._automatic(entry, mesh)

    def hands(self, entry: Entry, states: Collection[str] = STATES) -> dict[str, Path]:
        """Project files of a scan, by person, of those who have a copy of their own.

        Parameters
        ----------
        entry : Entry
        states : collection of str
            Only copies that their owners left in one of these.
        """
        files = hands(entry.folder, entry.scan)
        return {person: path for person, path in files.items() if self._work_of(entry, person)[0] in states}

    def seconds_of(self, entry: Entry, people: Iterable[str]) -> float:
        """How long some worked on copies of their own.

        Parameters
        ----------
        entry : Entry
        people : iterable of str
        """
        return sum(sum(self._work_of(entry, person)[1].values()) for person in people)

    def _work_of(self, entry: Entry, person: str) -> tuple[State, dict[str, float]]:
        """State and seconds of somebody's own copy."""
        work = _json(entry.folder / _own_name(person), is_row=False) or {}
        return _state(work), _numbers(work.get("seconds"))

    def order(self) -> list[str]:
        """Scans that can be corrected, the most doubtful first."""
        known = [entry for entry in self.entries.values() if not entry.has_failed]
        return [e.scan for e in sorted(known, key=lambda e: (-(e.row.get("doubt") or 0.0), e.scan))]

    def to_frame(self) -> pd.DataFrame:
        """A row a scan: state, doubt, faces, segments, edits, seconds of work, people, error and errors."""
        rows = [
            {
                **entry.facts,
                "people": ", ".join(sorted(entry.seconds)),
                "error_before": entry.row.get("rand_index_error"),
                "error_now": entry.errors.get("rand_index_error"),
            }
            for entry in self.entries.values()
        ]
        table = pd.DataFrame(rows)
        numbers = ["doubt", "error_before", "error_now"]
        return table.astype(dict.fromkeys(numbers, float) | {"faces": "Int64", "segments": "Int64"})

    def pictures(self, scans: Iterable[str]) -> dict[str, bytes]:
        """Pictures of scans, of those that have one.

        Parameters
        ----------
        scans : iterable of str
        """
        found = {}
        for scan in scans:
            path = self.entries[scan].folder / PICTURE
            if path.is_file():
                found[scan] = path.read_bytes()
        return found


class Stopwatch:
    """Time that somebody works: between two signs of life at most two minutes.

    Examples
    --------
    >>> watch = Stopwatch()
    >>> watch.tick() < 1.0
    True
    """

    def __init__(self) -> None:
        self._last = time.monotonic()

    def tick(self) -> float:
        """Seconds of work since the last sign of life."""
        now = time.monotonic()
        spent, self._last = min(now - self._last, IDLE), now
        return spent


def _own_name(person: str) -> str:
    """File that says what somebody has done with a copy of their own."""
    return f"work.{_plain(person)}.json"


def _state(work: dict[str, Any]) -> State:
    """What such a file says; "new" where it was edited by hand to something else."""
    return state if (state := work.get("state")) in STATES else "new"


def _numbers(found: object) -> dict[str, float]:
    """Those entries that are numbers: the file may have been edited by hand."""
    entries = found.items() if isinstance(found, dict) else ()
    return {str(name): float(value) for name, value in entries if isinstance(value, int | float)}


def _plain(person: str) -> str:
    """A name as a part of a file's name."""
    return re.sub(r"[^\w-]+", "_", person).strip("_") or "somebody"


def _json(path: Path, *, is_row: bool = True) -> dict[str, Any] | None:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    if is_row:
        return parse_row(text)
    try:
        found = json.loads(text)
    except ValueError:
        return None
    return found if isinstance(found, dict) else None


def _params(row: dict[str, Any]) -> Params | None:
    """What an automatic segmentation was made with, if this version can still tell."""
    try:
        values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in row["params"].items()}
        return Params(**values)
    except (KeyError, TypeError, ValueError, AttributeError):
        return None
