"""A whole dataset by one call: `segment_all`, and the `Run` that it gives."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import os
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenewidget.batch.claims import claim
from scenewidget.batch.clients import check_where
from scenewidget.batch.folders import labels_for, named_alike, some
from scenewidget.batch.places import is_url, join, scans_in, without_dots
from scenewidget.batch.plan import FORMATS, Job
from scenewidget.batch.pools import open_pool
from scenewidget.batch.progress import shown
from scenewidget.batch.rows import COLUMNS, STATUSES
from scenewidget.batch.schedule import work_through
from scenewidget.editing.files import is_blind_to_case, real
from scenewidget.engine.checks import checked_count
from scenewidget.engine.params import Params

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["UNITS", "Run", "planned", "segment_all"]

OVERHEAD = 500_000  # bytes that would take as long as what every scan costs, large or small
UNITS = ("m", "cm", "mm", "in", "ft", "auto")


class Run:
    """Many scans on their way; made by `segment_all`.

    Attributes
    ----------
    out : str
        Where the results are.
    scans : tuple of str
        Names, in order.
    rows : dict of str to dict
        By name, of those that have come to an end.
    error : BaseException, optional
        That ended the run early.

    Examples
    --------
    >>> from scenewidget.batch.plan import Job
    >>> Run([Job("a.ply", "scans/a.ply", "out/a.ply", Params())], "out", None, 0)
    Run(1 scan: 1 left)
    """

    def __init__(self, jobs: Sequence[Job], out: str, client: Any, n_workers: int | None) -> None:
        self.out = out
        self.scans = tuple(job.scan for job in jobs)
        self.rows: dict[str, dict[str, Any]] = {}
        self.error: BaseException | None = None
        self._jobs = jobs
        self._where = (client, n_workers)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._start = time.monotonic()
        self._spent = 0.0  # weights of what was really segmented
        self._left = sum(map(_weight, jobs))

    def __repr__(self) -> str:
        return f"Run({self.summary})"

    @property
    def summary(self) -> str:
        """How many scans there are, and what has become of them."""
        statuses = [row["status"] for row in self.rows.values()]
        parts = [f"{statuses.count(status)} {status}" for status in STATUSES if status in statuses]
        if len(self.rows) < len(self.scans):
            parts.append(f"{len(self.scans) - len(self.rows)} left")
        noun = "scan" if len(self.scans) == 1 else "scans"
        return f"{len(self.scans)} {noun}: {', '.join(parts)}"

    @property
    def is_running(self) -> bool:
        """Whether it goes on in the background."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def seconds_left(self) -> float:
        """Expected from the bytes that are left; nan until one scan is done."""
        if self._left <= 0 or len(self.rows) == len(self.scans):
            return 0.0
        return (time.monotonic() - self._start) / self._spent * self._left if self._spent else math.nan

    def to_frame(self) -> pd.DataFrame:
        """A row a scan that has come to an end.

        Returns
        -------
        table : pandas.DataFrame
            ``scan``; ``status``: "done", "reused", "failed", "killed" (its process died, also alone) or
            "too large"; ``error``, "" if there is none; ``seconds``; ``faces``; ``segments``; ``coverage``,
            the labeled share of the area; ``doubt``, the share of it that is probably wrong;
            ``peak_memory``, bytes; and where there is a truth the metrics of `evaluate` and ``n_truth``.
        """
        import pandas as pd

        rows = [self.rows[scan] for scan in self.scans if scan in self.rows]
        more = dict.fromkeys(name for row in rows for name in row if name not in COLUMNS)
        table = pd.DataFrame(rows, columns=[*COLUMNS, *more])
        whole = [name for name in ("faces", "segments", "peak_memory", "n_truth") if name in table]
        return table.astype(
            dict.fromkeys(whole, "Int64") | {"seconds": float, "coverage": float, "doubt": float}
        )

    def cancel(self) -> None:
        """Begin nothing more, and abandon what runs; files that are there are whole."""
        self._stop.set()

    def wait(self, timeout: float | None = None) -> Run:
        """Until it has ended; raises what ended it early.

        Parameters
        ----------
        timeout : float, optional
            Seconds.

        Raises
        ------
        TimeoutError
            It goes on.
        """
        if self._thread is not None:
            self._thread.join(timeout)
            if self._thread.is_alive():
                raise TimeoutError(f"still running after {timeout} s: {self}")
        if self.error is not None:
            raise self.error
        return self

    def work(
        self, hear: Callable[[Run, dict[str, Any]], None], tell: Callable[[str], None] | None = None
    ) -> None:
        """Do it, in this thread.

        Parameters
        ----------
        hear : callable (run, row)
            Called after each scan.
        tell : callable (line), optional
            Hears every step, where the work is done in this process.

        Raises
        ------
        ValueError
            Somebody else is writing there, or two scans would share a folder.
        OSError
            ``out`` can't be written.
        ConnectionError
            No scheduler answers, or it has gone.
        """
        ours = claim(self.out)
        try:
            if not is_url(self.out):
                _refuse_shared_folders(Path(self.out), self.scans)
            with open_pool(*self._where, tell=tell) as pool:
                self._start = time.monotonic()

                def report(job: Job, row: dict[str, Any]) -> None:
                    self.rows[job.scan] = row
                    self._left -= _weight(job)
                    self._spent += _weight(job) if row["status"] != "reused" else 0
                    hear(self, row)
                    if ours.is_lost:
                        raise ValueError(
                            f"another run has taken over {self.out!r} while this one stood still"
                        )

                work_through(self._jobs, pool, report, self._stop)
        finally:
            ours.release()

    def work_behind(self, hear: Callable[[Run, dict[str, Any]], None], end: Callable[[], None]) -> None:
        """Do it in a thread of its own.

        Parameters
        ----------
        hear : callable (run, row)
        end : callable
            Called when it is over.
        """

        def work() -> None:
            try:
                self.work(hear)
            except BaseException as error:
                self.error = error
            finally:
                end()

        self._thread = threading.Thread(target=work, name="scenewidget-run", daemon=True)
        self._thread.start()


def segment_all(
    scans: Any,
    out: str | os.PathLike[str],
    params: Params | None = None,
    client: Any = None,
    n_workers: int | None = None,
    formats: Sequence[str] = ("npz",),
    truth: Any = None,
    resume: bool = True,
    *,
    units: str | None = None,
    tile_faces: int | None = None,
    progress: bool | Callable[[Run, dict[str, Any]], None] = True,
    wait: bool = True,
) -> Run:
    """Segment many scans, on all cores of this machine or on any Dask cluster.

    Each scan gets a folder of its own below ``out``, named like the scan, with its labels in every format,
    a small picture, and, written last, ``row.json``: the mark that it is done. Files are there whole or not
    at all, so a run can be stopped at any moment (Ctrl-C, `Run.cancel`, a power cut) and the same call goes
    on from there. One bad scan stops nobody: it has a row that says why. Files that no run wrote, or that
    somebody has changed since, are never overwritten: a project that was corrected by hand stays.

    Parameters
    ----------
    scans : path, URL, or list of them
        A folder (with all below), a pattern such as ``"scans/*.ply"``, or files; URLs as fsspec knows them
        (``s3://…``, ``gs://…``, ``https://…``).
    out : path or URL
    params : Params, optional
    client : distributed.Client, cluster or address, optional
        Where to work. By default processes on this machine, which need no set-up. Its workers must see the
        scans and ``out`` by the same paths.
    n_workers : int, optional
        Scans at a time on this machine: by default as many as there are cores, and 2 GB of memory for each.
        0 does one after the other in this process, without Dask.
    formats : sequence of str
        What to write: "npz", "ply", "glb", "scannet", "scenenn", "csv", "parquet", "npy", "txt", and
        "swproj", a project in which to correct it.
    truth : folder, file or mapping of scan to file, optional
        True labels, of the same names as the scans; adds the metrics to the rows.
    resume : bool
        Reuse what is done with the same file, parameters and version. What was too much for memory, or
        failed, is tried again.
    units : "m" | "cm" | "mm" | "in" | "ft" | "auto", optional
        What the numbers in the scans are, as of `load_mesh`.
    tile_faces : int, optional
        Segment scans of more faces tile by tile, see `batch.tiles.segment_tiles`: memory is then that of a
        tile of so many faces and its overlap, and 150 bytes a face.
    progress : bool or callable (run, row)
        Whether to show a bar with the time left, in a terminal or notebook (there with a button that
        cancels); or who to tell of each scan.
    wait : bool
        False returns at once, and the run goes on in a thread of its own: `Run.wait`, `Run.cancel`.

    Returns
    -------
    Run
        ``run.to_frame()`` has a row a scan.

    Raises
    ------
    TypeError, ValueError
        No scans, an unknown format, a truth of none of them, a folder into which another run is writing.
    OSError
        A folder that can't be read or written, a scheduler that does not answer.
    ImportError
        Dask isn't there: ``pip install "scenewidget[batch]"``.

    Notes
    -----
    A scan that ends its process, most likely for want of memory, is tried again when nothing else runs, with
    all the memory there is; what ran beside it is done again and not blamed. Scans that are expected to need
    more memory than a worker has (0.6 GB and 0.55 kB a face) come last, one at a time, or are reported as
    "too large" with what they need. The labels don't depend on the number of workers.

    Examples
    --------
    >>> import tempfile
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(8)  # 128 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, mesh.face_areas.astype(int))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = sw.export(seg, mesh, f"{folder}/square.ply")
    ...     run = sw.segment_all(f"{folder}/square.ply", f"{folder}/out", n_workers=0, progress=False)
    ...     run, run.to_frame().columns[:5].tolist()
    (Run(1 scan: 1 done), ['scan', 'status', 'error', 'seconds', 'faces'])
    """
    run = planned(
        scans, out, params, client, n_workers, formats, truth, resume, units=units, tile_faces=tile_faces
    )
    with contextlib.ExitStack() as stack:
        hear = stack.enter_context(shown(run, progress, behind=not wait))
        if wait:
            run.work(hear)
        else:
            run.work_behind(hear, stack.pop_all().close)
    return run


def planned(
    scans: Any,
    out: Any,
    params: Params | None = None,
    client: Any = None,
    n_workers: int | None = None,
    formats: Sequence[str] = ("npz",),
    truth: Any = None,
    resume: bool = True,
    *,
    units: str | None = None,
    tile_faces: int | None = None,
) -> Run:
    """What `segment_all` would do with the same arguments, checked, and not yet begun.

    Examples
    --------
    >>> planned("no/such/folder", "out")
    Traceback (most recent call last):
        ...
    ValueError: 'no/such/folder' does not exist; give files, folders or a pattern such as 'scans/*.ply'
    """
    if not isinstance(out, str | os.PathLike):
        raise TypeError(f"out must be a folder or URL, got {type(out).__name__}")
    if not os.fspath(out):
        raise ValueError("out is empty: name a folder for the results, such as 'out'; '.' is this one")
    if not isinstance(resume, bool):
        raise TypeError(f"resume must be True or False, got {resume!r}")
    if params is not None and not isinstance(params, Params):
        raise TypeError(f"params must be a Params, got {type(params).__name__}")
    if units is not None and units not in UNITS:
        raise ValueError(f"units must be one of {', '.join(map(repr, UNITS))}, got {units!r}")
    check_where(client, n_workers)
    place = os.fspath(out).removeprefix("file://")
    if not is_url(place):
        place = str(without_dots(Path(place).absolute()))
    found = scans_in(scans)
    outside = {name: scan for name, scan in found.items() if not _is_below(scan.path, place)}
    if not outside:
        raise ValueError(f"all scans lie in out, {str(out)!r}; choose another folder for the results")
    true = _truths(truth, list(outside))
    options: dict[str, Any] = {
        "params": params or Params(),
        "formats": _checked_formats(formats),
        "units": units,
        "tile_faces": 0 if tile_faces is None else checked_count("tile_faces", tile_faces),
        "anew": not resume,
    }
    jobs = [
        Job(name, scan.path, join(place, name), truth=true.get(name, ""), size=scan.size, **options)
        for name, scan in outside.items()
    ]
    return Run(jobs, place, client, n_workers)


def _weight(job: Job) -> int:
    return job.size + OVERHEAD


def _is_below(path: str, folder: str) -> bool:
    if is_url(path):
        return path.startswith(folder.rstrip("/") + "/")
    return Path(path).is_relative_to(folder) or real(Path(path).parent).is_relative_to(real(Path(folder)))


def _checked_formats(formats: Any) -> tuple[str, ...]:
    if isinstance(formats, str):
        formats = (formats,)
    formats = list(formats) if isinstance(formats, Iterable) else formats
    if not isinstance(formats, list) or not all(isinstance(name, str) for name in formats):
        raise TypeError(f"formats must be a list of names, such as ['npz', 'swproj'], got {formats!r}")
    chosen = tuple(dict.fromkeys(formats))
    unknown = [name for name in chosen if name not in FORMATS]
    if unknown or not chosen:
        listed = ", ".join(map(repr, FORMATS))
        raise ValueError(
            f"formats may hold {listed}, got {unknown[0]!r}"
            if unknown
            else f"formats is empty; it may hold {listed}"
        )
    if "parquet" in chosen and importlib.util.find_spec("pyarrow") is None:
        raise ValueError('the format "parquet" wants pyarrow: pip install pyarrow, or choose "csv"')
    return chosen


def _truths(truth: Any, scans: Sequence[str]) -> dict[str, str]:
    """File of true labels of each scan that has one; ValueError if none has."""
    if truth is None:
        return {}
    if isinstance(truth, Mapping):
        named = {scan: name for scan in scans if (name := named_alike(scan, truth)) is not None}
        strange = [name for name in truth if name not in named.values()]
        if strange:
            raise ValueError(f"truth has {strange[0]!r}, which is no scan; scans are {some(scans)}")
        odd = [path for path in truth.values() if not isinstance(path, str | os.PathLike)]
        if odd:
            raise TypeError(f"truth must map scans to files of labels, got {type(odd[0]).__name__}")
        missing = [path for path in truth.values() if not Path(path).is_file()]
        if missing:
            raise ValueError(f"truth: {str(missing[0])!r} does not exist")
        return {scan: str(Path(truth[name]).absolute()) for scan, name in named.items()}
    if not isinstance(truth, str | os.PathLike):
        raise TypeError(f"truth must be a folder, a file, or map scans to files, got {type(truth).__name__}")
    files = labels_for(Path(truth), scans)
    found = {scan: files[name] for scan in scans if (name := named_alike(scan, files)) is not None}
    return {scan: str(file.path.absolute()) for scan, file in found.items()}


def _refuse_shared_folders(folder: Path, scans: Iterable[str]) -> None:
    """Raise if two scans' results would go into one folder, as on disks that don't tell a from A."""
    if not is_blind_to_case(folder):
        return
    spelled: dict[str, str] = {}
    for scan in scans:
        other = spelled.setdefault(scan.casefold(), scan)
        if other != scan:
            raise ValueError(
                f"{other!r} and {scan!r} would share a folder in {str(folder)!r}, whose disk doesn't tell "
                "capital from small letters; rename one of them, or choose a place on another disk"
            )
