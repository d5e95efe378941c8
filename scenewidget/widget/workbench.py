"""A queue of scans to correct, in a notebook: pictures, states, doubt, and the editor on one of them.

Goes in: the folder that `segment_all` wrote. Comes out: each scan's corrections in its project file, and
beside it what has been done, by whom, and how long. Who has a scan open holds a lock on it, so several
people may work on one folder.
"""

from __future__ import annotations

import atexit
import contextlib
import getpass
import math
import os
import threading
import weakref
from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anywidget
import ipywidgets as widgets
import traitlets

from scenewidget.batch.dataset import export_dataset
from scenewidget.batch.folders import labels_for, named_alike, read_labels
from scenewidget.batch.picture import PICTURE, thumbnail
from scenewidget.batch.rows import units_of
from scenewidget.batch.worklist import Entry, State, Stopwatch, Worklist
from scenewidget.editing.files import FileLock, replacing
from scenewidget.editing.session import Session
from scenewidget.engine.checks import KnownNames, checked_count
from scenewidget.evaluation import METRICS, evaluate
from scenewidget.hands import agreement
from scenewidget.widget.arranged import Arranged
from scenewidget.widget.bundle import bundled
from scenewidget.widget.rooms_widget import MOST_FACES, Rooms
from scenewidget.widget.scene_view import check_height
from scenewidget.widget.scene_widget import SceneWidget

if TYPE_CHECKING:
    import pandas as pd

    from scenewidget.engine.segmentation import Segmentation

__all__ = ["QueueView", "Workbench"]

LONGEST = 80  # letters of a person's name, which is part of the names of files
MOST_PICTURES = 60  # that the page may ask for in one go
_at_work: weakref.WeakValueDictionary[tuple[str, str, bool], Workbench] = weakref.WeakValueDictionary()


class QueueView(anywidget.AnyWidget):
    """The queue as the page shows it; `Workbench` drives it.

    Examples
    --------
    >>> view = QueueView()
    >>> view.current
    ''
    >>> view.close()
    """

    _esm = traitlets.Unicode().tag(sync=True)
    _css = traitlets.Unicode().tag(sync=True)

    rows: Any = traitlets.List().tag(sync=True)
    """A dict a scan: scan, state, doubt, faces, segments, edits, seconds, people, error, before, now."""

    current = traitlets.Unicode().tag(sync=True)
    """The scan that is open; "" if none is."""

    note = traitlets.Unicode().tag(sync=True)
    """What happened last, for people."""

    person = traitlets.Unicode().tag(sync=True)
    """Who works."""

    has_truth = traitlets.Bool(False).tag(sync=True)
    """Whether errors are shown."""

    height = traitlets.Int(320).tag(sync=True)
    """Of the list, in pixels."""

    def __init__(self, **options: Any) -> None:
        super().__init__(_esm=bundled("workbench.js"), _css=bundled("workbench.css"), **options)


class Workbench(KnownNames, Arranged, widgets.VBox):
    """A queue of segmented scans, and the editor on the one that is open; the last value of a cell.

    The queue shows a picture of each scan, its state ("new", "begun", "to review", "done"), how much of it
    is probably wrong, who worked on it how long, and errors where there is a truth. Sort, filter and search
    it; open a scan by a double click or Enter; Done (D), To review (R), Next (N) and Previous (P) go on.
    Every edit is in the scan's project file before the editor says "Saved".

    Parameters
    ----------
    out : path
        The folder that `segment_all` wrote, best with the formats "npz" and "swproj".
    person : str, optional
        Who works; by default the name of the account.
    truth : folder, file or None
        True labels, of the same names as the scans; what is done is compared with them.
    gold : folder or file, optional
        True labels of a few scans that nobody sees here: `measure` tells how well people did on them.
    own : bool
        Whether each person corrects a copy of their own, ``<scan>.<person>.swproj``: then `agreement` tells
        how far they agree. By default all share one project a scan.
    scans : path, optional
        The folder of the scans, if they are not where they were.
    height : int
        Of the editor's picture, in pixels.
    room_faces : int
        A scan with more faces is corrected room by room, as by `Rooms`, in a folder beside its results; what
        it is as a whole goes into its project when it is left or done.

    Attributes
    ----------
    current : str
        Name of the scan that is open; "" if none is.
    editor : SceneWidget, Rooms or None
        On that scan.

    Raises
    ------
    ValueError
        Nothing of ours is in that folder, or it is a URL.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(4)  # 32 triangles
    >>> folder = tempfile.TemporaryDirectory()
    >>> _ = sw.export(sw.Segmentation.from_labels(mesh, np.arange(32) // 16), mesh, f"{folder.name}/a.ply")
    >>> run = sw.segment_all(f"{folder.name}/a.ply", f"{folder.name}/out", n_workers=0, progress=False)
    >>> bench = sw.Workbench(f"{folder.name}/out", person="ann")
    >>> bench.edit("a.ply")
    >>> bench.editor.session.relabel(0, "floor").title
    "Name 'floor'"
    >>> bench.done()
    >>> bench.to_frame()[["scan", "state", "edits"]].values.tolist()
    [['a.ply', 'done', 1]]
    >>> bench.close()
    >>> folder.cleanup()
    """

    current = traitlets.Unicode("", read_only=True)
    """The scan that is open; "" if none is."""

    _set_once = ("queue",)

    def __init__(
        self,
        out: str | os.PathLike[str],
        person: str | None = None,
        *,
        truth: str | os.PathLike[str] | None = None,
        gold: str | os.PathLike[str] | None = None,
        own: bool = False,
        scans: str | os.PathLike[str] | None = None,
        height: int = 520,
        room_faces: int = MOST_FACES,
    ) -> None:
        if not isinstance(out, str | os.PathLike):
            raise TypeError(f"out must be a folder, got {type(out).__name__}")
        if isinstance(out, str) and "://" in out:
            raise ValueError(
                f"a workbench wants a folder of this machine, and {out!r} is a URL: fetch it first"
            )
        if not (person is None or (isinstance(person, str) and person.strip() and len(person) <= LONGEST)):
            raise ValueError(
                f"person must be a name of at most {LONGEST} letters, such as 'ann', got {person!r:.200}"
            )
        if not isinstance(own, bool):
            raise TypeError(f"own must be True or False, got {own!r:.200}")
        if scans is not None and not Path(scans).is_dir():
            raise ValueError(f"scans must be the folder of the scans, and {str(scans)!r} is none")
        check_height(height)
        person = person or _account()
        key = (os.path.realpath(out), person, own)
        before = _at_work.get(key)
        if before is not None:
            before.close()  # a cell that was run again
        self._work = Worklist(Path(out), person, own=own)
        names = list(self._work.entries)
        self._truth, self._gold = _files_of("truth", truth, names), _files_of("gold", gold, names)
        self._scans = None if scans is None else Path(scans)
        self._picture_height = height
        self._room_faces = checked_count("room_faces", room_faces)
        self._edits_before = 0  # this sitting
        self._lock = threading.RLock()
        self._held: FileLock | None = None
        self._watch = Stopwatch()
        self._stop_hearing: Callable[[], None] | None = None
        self._editor: SceneWidget | Rooms | None = None
        self.queue = QueueView(person=person, has_truth=bool(self._truth))
        self.queue.on_msg(self._handle_message)
        self._place = widgets.VBox()
        super().__init__([self.queue, self._place])
        self._show_rows()
        _at_work[key] = self

    def __repr__(self) -> str:
        states = [entry.state for entry in self._work.entries.values()]
        return f"Workbench({len(states)} scans, {states.count('done')} done)"

    @property
    def editor(self) -> SceneWidget | Rooms | None:
        """On the scan that is open; None if none is."""
        return self._editor

    @property
    def height(self) -> int:
        """Of the editor's picture, in pixels; can be set."""
        return self._picture_height

    @height.setter
    def height(self, height: int) -> None:
        if self._editor is not None:
            self._editor.height = height
        self._picture_height = height

    # --- what people and scripts do ---------------------------------------------------------------

    def edit(self, scan: str) -> None:
        """Open the editor on a scan; what is open is left as it is, saved.

        Parameters
        ----------
        scan : str
            Its name, as in `to_frame`.

        Raises
        ------
        ValueError
            No such scan, one that failed, or one that somebody has open.
        FileNotFoundError
            The scan or its labels are gone.
        """
        with self._lock:
            entry = self._entry(scan)
            if scan == self.current:
                return
            if entry.has_failed:
                raise ValueError(f"{scan!r} has no segmentation to correct: {entry.row.get('error')}")
            held, holder = self._work.lock(scan)
            if held is None:
                raise ValueError(f"{scan!r} is open elsewhere: {holder}")
            try:
                editor = self._editor_on(scan)
            except BaseException:
                held.release()
                raise
            self._leave()
            self._held, self._editor = held, editor
            self._watch = Stopwatch()
            self._edits_before = entry.edits
            self._stop_hearing = self._hear_edits(editor, scan)
            self._place.children = [editor]
            self._show_current(scan)

    def next(self) -> str:
        """Open the scan after this one that is neither done nor open elsewhere, the most doubtful first.

        Returns
        -------
        scan : str
            "" if there is none.
        """
        return self._open_first(self._after(self.current))

    def previous(self) -> str:
        """Open the scan before this one, whatever its state; "" if there is none."""
        order = self._work.order()
        before = order[: order.index(self.current)] if self.current in order else []
        return self._open_first(before[::-1], any_state=True)

    def done(self) -> None:
        """The scan that is open is right."""
        self._mark("done")

    def review(self) -> None:
        """Somebody should look at the scan that is open again."""
        self._mark("review")

    def refresh(self) -> None:
        """Show what others have done since."""
        with self._lock:
            self._work.refresh()
            self._show_rows()

    def to_frame(self) -> pd.DataFrame:
        """A row a scan: state, doubt, faces, segments, edits, seconds of work, people, error and errors."""
        return self._work.to_frame()

    def annotations(self, scan: str) -> dict[str, Segmentation]:
        """What each who corrects a copy of their own has made of a scan, by name.

        For `agreement` and `consensus`, and two of them for `Compare`.

        Parameters
        ----------
        scan : str

        Raises
        ------
        ValueError
            No such scan.
        FileNotFoundError
            The scan is gone.
        """
        entry = self._entry(scan)
        return self._read(entry, self._copies(entry))

    def agreement(self) -> pd.DataFrame:
        """How far people agree who correct copies of their own: `agreement`, a row a scan and pair.

        Only copies count that their owners have called done.

        Raises
        ------
        ValueError
            No scan is done by two.
        """
        import pandas as pd

        tables = {}
        for scan, entry in self._work.entries.items():
            copies = {} if entry.has_failed else self._work.hands(entry, ["done"])
            if len(copies) > 1:
                tables[scan] = agreement(self._read(entry, copies))
        if not tables:
            raise ValueError(
                "no scan has been corrected by two people who called it done; give each "
                "Workbench(…, person=…, own=True)"
            )
        return pd.concat(tables, names=["scan"])

    def measure(self) -> pd.DataFrame:
        """How well people did on the gold scans that are done: all metrics, a row a scan and person.

        With ``own=True`` whoever has a copy is measured; otherwise the scan as it is, under all who worked
        on it.

        Raises
        ------
        ValueError
            There is no ``gold``, or none of its scans has been corrected.
        """
        import pandas as pd

        rows = {}
        for entry in self._work.entries.values():
            name = named_alike(entry.scan, self._gold)
            if name is None or entry.has_failed:
                continue
            if self._work.own:
                files = self._work.hands(entry)
            else:
                together, project = ", ".join(sorted(entry.seconds)), self._work.project(entry)
                files = {together: project} if entry.state in ("done", "review") else {}
            if files:
                mesh = self._work.mesh(entry, self._scans)
                found = {person: read_labels(path, mesh) for person, path in files.items()}
                table = evaluate(found, read_labels(self._gold[name], mesh), mesh)
                rows[entry.scan] = table.rename_axis("person")
        if not rows:
            raise ValueError(
                "no gold scan has been corrected yet; gold= is a folder of true labels of some scans"
            )
        return pd.concat(rows, names=["scan"])

    def export(
        self,
        target: str | os.PathLike[str],
        *,
        states: Collection[str] = ("done",),
        validation: float = 0.2,
        seed: int = 0,
        agreed: bool = False,
        overwrite: bool = False,
    ) -> pd.DataFrame:
        """Write the whole dataset in ScanNet's layout, with a train and validation split and statistics.

        Parameters
        ----------
        target : path
        states : collection of str
            Which scans: "new", "begun", "review", "done".
        validation : float
            Share of the scenes for validation.
        seed : int
            Of the split.
        agreed : bool
            With ``own=True``: whether each scene has the `consensus` of all whose copies are in one of the
            ``states``, rather than the labels of who works here.
        overwrite : bool
            As of `sw.export`.

        Returns
        -------
        table : pandas.DataFrame
            A row a scene: its split and what it has.
        """
        options: dict[str, Any] = {"states": states, "validation": validation, "seed": seed}
        options |= {"scans": self._scans, "agreed": agreed, "overwrite": overwrite}
        return export_dataset(self._work, target, **options)

    def close(self) -> None:
        """Leave the scan that is open, saved, and take the widgets off the page."""
        if "_place" in vars(self):  # not if __init__ refused its folder
            with self._lock:
                self._leave()
            self.queue.close()
            self._place.close()
        super().close()

    def _entry(self, scan: str) -> Entry:
        entry = self._work.entries.get(scan)
        if entry is None:
            known = ", ".join(map(repr, list(self._work.entries)[:3]))
            raise ValueError(f"there is no scan {scan!r}; there are {known} …")
        return entry

    def _copies(self, entry: Entry) -> dict[str, Path]:
        return {} if entry.has_failed else self._work.hands(entry)

    def _read(self, entry: Entry, files: dict[str, Path]) -> dict[str, Segmentation]:
        mesh = self._work.mesh(entry, self._scans) if files else None
        return {person: read_labels(path, mesh) for person, path in files.items()}

    # --- opening and leaving ----------------------------------------------------------------------

    def _editor_on(self, scan: str) -> SceneWidget | Rooms:
        entry = self._work.entries[scan]
        if (entry.row.get("faces") or 0) > self._room_faces:
            return self._rooms_on(entry)
        mesh = self._work.mesh(entry, self._scans)
        self._work.open(scan, mesh).close()  # makes the project if there is none
        truth = self._truth_of(scan)
        labels = None if truth is None else read_labels(truth, mesh)
        editor = SceneWidget(mesh, truth=labels, height=self._picture_height, autosave=False)
        try:
            editor.restore(self._work.project(entry))
            editor.view.color_by = "segments"
        except BaseException:
            editor.close()
            raise
        return editor

    def _rooms_on(self, entry: Entry) -> Rooms:
        place, height = self._work.rooms(entry), self._picture_height
        if place.exists() and units_of(entry.row) is None:  # then nobody needs its faces yet
            return Rooms(self._work.source(entry, self._scans), place, height=height)
        mesh = self._work.mesh(entry, self._scans)
        labels = None if place.exists() else self._work.labels(entry, mesh)
        return Rooms(mesh, place, segmentation=labels, height=height)

    def _hear_edits(self, editor: SceneWidget | Rooms, scan: str) -> Callable[[], None] | None:
        if isinstance(editor, Rooms):
            editor.observe(lambda _: self._take_edit(scan), "n_edits")
            return None  # nobody hears a widget that is closed
        session = editor.session
        return None if session is None else session.observe(lambda _: self._take_edit(scan))

    def _n_edits(self, editor: SceneWidget | Rooms) -> int:
        if isinstance(editor, Rooms):
            return max(0, self._edits_before + editor.n_edits)
        return 0 if editor.session is None else len(editor.session.edits)

    def _now(self, scan: str, editor: SceneWidget | Rooms) -> Segmentation | None:
        """The labels as they are; those of rooms are put together in the scan's project."""
        if isinstance(editor, SceneWidget):
            return None if editor.session is None else editor.session.segmentation
        found = editor.segmentation()
        with Session(found.mesh, found) as session:
            session.save(self._work.project(self._work.entries[scan]), overwrite=True)
        return found

    def _truth_of(self, scan: str) -> Path | None:
        name = named_alike(scan, self._truth)
        return None if name is None else self._truth[name]

    def _leave(self) -> None:
        """Close what is open; called with the lock held."""
        scan, editor, held = self.current, self.editor, self._held
        if editor is None:
            return
        if self._stop_hearing is not None:
            self._stop_hearing()
        trouble = ""
        try:
            self._note_work(scan, editor)
            if isinstance(editor, Rooms) and editor.n_edits:
                self._now(scan, editor)
        except (OSError, ValueError) as error:  # every edit is in the project of its scan or room
            trouble = str(error)
        session = None if isinstance(editor, Rooms) else editor.session
        editor.close()
        if session is not None:
            session.close()
        self._editor, self._held, self._stop_hearing = None, None, None
        self._place.children = []
        if held is not None:
            held.release()
        self._show_current("")
        self.queue.note = trouble

    def _note_work(self, scan: str, editor: SceneWidget | Rooms, state: State | None = None) -> None:
        n = self._n_edits(editor)
        entry = self._work.entries[scan]
        if state is None and n > 0 and entry.state == "new":
            state = "begun"
        spent = self._watch.tick()
        if state is None and n == entry.edits and n == 0:
            return  # somebody has only had a look
        self._work.note(scan, state=state, seconds=spent, edits=n)

    def _take_edit(self, scan: str) -> None:
        """Something was edited: work goes on; what was done is begun again."""
        with self._lock:
            if scan != self.current or self.editor is None:
                return
            entry = self._work.entries[scan]
            if entry.state in ("new", "done"):
                with contextlib.suppress(OSError):
                    self._note_work(scan, self.editor, "begun")
                self._show_rows()

    def _mark(self, state: State) -> None:
        with self._lock:
            editor, scan = self.editor, self.current
            now = None if editor is None else self._now(scan, editor)
            if editor is None or now is None:
                raise ValueError("no scan is open: open one first, by edit(scan) or next()")
            self._note_work(scan, editor, state)
            self._judge(scan, now)
            self._draw(self._work.entries[scan], now)
            self._show_rows()
            self.queue.send({"kind": "redraw", "scan": scan})

    def _judge(self, scan: str, now: Segmentation) -> None:
        truth = self._truth_of(scan)
        if truth is None:
            return
        found = evaluate({"": now}, read_labels(truth, now.mesh), now.mesh).loc[""]
        self._work.note(scan, errors={name: float(found[name]) for name in METRICS})

    def _draw(self, entry: Entry, now: Segmentation) -> None:
        with contextlib.suppress(OSError), replacing(entry.folder / PICTURE) as temporary:
            temporary.write_bytes(thumbnail(now))

    def _after(self, scan: str) -> list[str]:
        order = self._work.order()
        at = order.index(scan) + 1 if scan in order else 0
        return order[at:] + order[:at]

    def _open_first(self, scans: list[str], *, any_state: bool = False) -> str:
        trouble: Exception | None = None
        for scan in scans:
            entry = self._work.reread(scan)
            if scan == self.current or (entry.state == "done" and not any_state):
                continue
            held, _ = self._work.lock(scan)
            if held is None:
                continue  # open elsewhere
            held.release()
            try:
                self.edit(scan)
            except (OSError, ValueError, TypeError) as error:  # a damaged project holds nobody up
                trouble = trouble or type(error)(f"{scan!r} was passed over: {error}")
                continue
            self.queue.note = "" if trouble is None else str(trouble)
            return scan
        if trouble is not None:
            raise trouble
        return ""

    # --- the page ---------------------------------------------------------------------------------

    def _show_current(self, scan: str) -> None:
        self.set_trait("current", scan)
        self.queue.current, self.queue.note = scan, ""
        self._show_rows()

    def _show_rows(self) -> None:
        self.queue.rows = [_shown(entry) for entry in self._work.entries.values()]

    def _handle_message(self, _: Any, message: Any, __: Any) -> None:
        kind = message.get("kind") if isinstance(message, dict) else None
        if kind == "pictures":
            self._send_pictures(message.get("scans"))
            return
        try:
            scans = [scan for scan in message.get("scans", ()) if scan in self._work.entries]
            if kind == "open" and scans:
                self.edit(scans[0])
            elif kind == "next":
                self._go_on(scans)
            elif kind == "previous":
                self._go_on(scans, any_state=True)
            elif kind in ("done", "review"):
                self._mark(kind)
                if kind == "done":
                    self._go_on(scans)
            elif kind == "refresh":
                self.refresh()
        except (OSError, ValueError, TypeError) as error:
            self.queue.note = str(error)

    def _go_on(self, scans: list[str], *, any_state: bool = False) -> None:
        if not self._open_first(scans, any_state=any_state):
            self.queue.note = "Nothing else is left here: choose other filters, or have a break"

    def _send_pictures(self, scans: Any) -> None:
        wanted = [s for s in scans or () if s in self._work.entries][:MOST_PICTURES]
        found = self._work.pictures(wanted)
        if wanted:
            self.queue.send({"kind": "pictures", "asked": wanted, "scans": list(found)}, list(found.values()))


def _shown(entry: Entry) -> dict[str, Any]:
    """What the page shows of an entry."""
    return {
        **entry.facts,
        "seconds": round(sum(entry.seconds.values())),
        "before": _number(entry.row.get("rand_index_error")),
        "now": _number(entry.errors.get("rand_index_error")),
    }


def _files_of(argument: str, place: object, scans: list[str]) -> dict[str, Path]:
    """Files of true labels by scan, or by its name without suffix."""
    if place is None:
        return {}
    if not isinstance(place, str | os.PathLike):
        raise TypeError(f"{argument} must be a folder or a file, got {type(place).__name__}")
    try:
        return {name: file.path for name, file in labels_for(Path(place), scans).items()}
    except ValueError as error:
        raise ValueError(f"{argument}: {error}") from error


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _account() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # no account has this number
        return "somebody"


@atexit.register
def _leave_all() -> None:
    """Leave, saved, what is open when a program ends, while all that saving needs is still there."""
    with contextlib.ExitStack() as leaving:  # everything, though one should raise
        for bench in list(_at_work.values()):
            leaving.callback(_leave_one, bench)


def _leave_one(bench: Workbench) -> None:
    with bench._lock:
        bench._leave()
