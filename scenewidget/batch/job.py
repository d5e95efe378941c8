"""One scan of many, from its file to its results: read, segmented, judged, written, with a row that tells.

Whatever becomes of it, the answer is a row, never an error: one bad scan stops nobody.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
import time
import warnings
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from scenewidget.batch.folders import LABELS, read_labels
from scenewidget.batch.memory import peak, reset_peak, what_it_takes
from scenewidget.batch.picture import PICTURE, thumbnail
from scenewidget.batch.places import LocalFolder, RemoteFolder, folder_at, local_copy, referred
from scenewidget.batch.plan import FORMATS, Job
from scenewidget.batch.rows import COLUMNS, FAILED, ROW, empty_row, parse_row, spoken_size
from scenewidget.batch.tiles import segment_tiles
from scenewidget.editing.formats import export
from scenewidget.editing.session import Session
from scenewidget.engine.pipeline import segment
from scenewidget.engine.readers import load
from scenewidget.engine.segmentation import Segmentation
from scenewidget.evaluation import METRICS, evaluate

__all__ = ["note_failure", "run_job", "sweep_up"]

Folder = LocalFolder | RemoteFolder


class _TooLargeError(Exception):
    def __init__(self, need: int, limit: int) -> None:
        super().__init__(
            f"needs about {spoken_size(need)} of memory, and may take {spoken_size(limit)}: "
            "run it where there is more, or in tiles (tile_faces=)"
        )


def run_job(
    job: Job,
    *,
    limit: int | None = None,
    tell: Callable[[str], None] | None = None,
    foretell: Callable[[dict[str, Any]], None] | None = None,
) -> dict[str, Any]:
    """Do a job and tell what became of it; never raises but for Ctrl-C.

    Parameters
    ----------
    job : Job
    limit : int, optional
        Bytes of memory that it may take; what is expected to need more isn't begun.
    tell : callable (line), optional
        Hears every step and every warning.
    foretell : callable (row), optional
        Hears what is known once the scan has been read, in case that nothing comes after.

    Returns
    -------
    row : dict
        ``status`` is "done", "reused", "failed" or "too large".

    Examples
    --------
    >>> from scenewidget.batch.plan import Job
    >>> from scenewidget.engine.params import Params
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as out:
    ...     run_job(Job("a.ply", "no/such/a.ply", out, Params()))["status"]
    'failed'
    """
    row = empty_row(job.scan)
    start = time.perf_counter()
    reset_peak()

    def learn(known: dict[str, Any]) -> None:
        row["faces"] = known["faces"]
        if foretell is not None:
            foretell(known)

    try:
        row |= _row(job, limit, tell, learn)
    except _TooLargeError as error:
        row |= {"status": "too large", "error": str(error)}
    except MemoryError:
        need = spoken_size(what_it_takes(row["faces"] or 0, is_judged=job.truth != ""))
        row |= {"status": "too large", "error": f"ran out of memory; needs {need} or more"}
    except Exception as error:  # whatever one scan does, the others go on
        text = _spoken(error)
        known = isinstance(error, (OSError, ValueError, TypeError))
        row |= {"status": "failed", "error": text if known else f"{type(error).__name__}: {text}"}
    row["peak_memory"] = peak() if row["peak_memory"] is None else row["peak_memory"]
    if row["status"] in ("failed", "too large"):
        row["seconds"] = round(time.perf_counter() - start, 3)
        note_failure(job, row)
    return row


def _spoken(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:  # without the number
        return error.strerror if error.filename is None else f"{error.strerror}: {error.filename!r}"
    return str(error) or "no reason given"


def note_failure(job: Job, row: dict[str, Any]) -> None:
    """Leave word of what went wrong beside the results, as far as that can be written.

    Parameters
    ----------
    job : Job
    row : dict

    Examples
    --------
    >>> import json, tempfile
    >>> from scenewidget.batch.plan import Job
    >>> from scenewidget.engine.params import Params
    >>> with tempfile.TemporaryDirectory() as out:
    ...     job = Job("a.ply", "a.ply", f"{out}/a.ply", Params())
    ...     note_failure(job, {"scan": "a.ply", "status": "killed"})
    ...     json.loads(folder_at(f"{out}/a.ply").read("failed.json"))["status"]
    'killed'
    """
    with contextlib.suppress(OSError):
        folder = folder_at(job.folder)
        there = folder.read(FAILED)
        if there is None or '"scan"' in there:
            folder.write(FAILED, json.dumps({**row, "source": job.source, "key": "", "files": {}}, indent=1))


def sweep_up(job: Job) -> None:
    """Remove what a process that was killed has left half written of a job's results.

    Parameters
    ----------
    job : Job

    Examples
    --------
    >>> import tempfile
    >>> from scenewidget.batch.plan import Job
    >>> from scenewidget.engine.params import Params
    >>> with tempfile.TemporaryDirectory() as out:
    ...     (Path(out) / ".a.npz.12345678.tmp").touch()
    ...     sweep_up(Job("a.ply", "a.ply", out, Params()))
    ...     list(Path(out).iterdir())
    []
    """
    folder_at(job.folder).sweep(
        [ROW, FAILED, PICTURE, *(n for kind in job.formats for n in _names(job, kind))]
    )


def _names(job: Job, kind: str) -> list[str]:
    """Of the files of one format."""
    return [PurePosixPath(job.scan).stem + suffix for suffix in FORMATS[kind]]


def _row(
    job: Job,
    limit: int | None,
    tell: Callable[[str], None] | None,
    foretell: Callable[[dict[str, Any]], None],
) -> dict[str, Any]:
    """What is known of a scan in the end: done or reused."""
    start = time.perf_counter()
    if job.version != version("scenewidget"):
        raise ValueError(
            f"the worker has scenewidget {version('scenewidget')}, who asked has {job.version}: "
            "install the same everywhere"
        )
    folder = folder_at(job.folder)
    sweep_up(job)
    with local_copy(job.source) as path:
        if path.exists() and not path.is_file():  # a pipe or a device would be read for ever
            raise OSError(f"{path.name!r} is a {'folder' if path.is_dir() else 'pipe or device'}, no file")
        key, truth_key = _key(path, job), _digest(Path(job.truth)) if job.truth else ""
        text = folder.read(ROW)
        old = None if text is None else parse_row(text)
        if old is None and text is not None:
            raise FileExistsError(f"{job.folder}/{ROW} is there, and no run of ours wrote it")
        if old is not None and old["key"] == key and not job.anew and _is_whole(folder, old):
            known = _judged_again(job, folder, path, old, truth_key)
            if known is not None:
                folder.remove(FAILED)
                return known | {"status": "reused"}
        segmentation, said = _segmented(path, job, limit, tell, foretell)
        if _key(path, job) != key:
            raise OSError(f"{path.name!r} changed while it was being segmented; run again")
    mesh = segmentation.mesh
    row: dict[str, Any] = {
        "faces": mesh.n_faces,
        "segments": segmentation.n_segments,
        "coverage": round(segmentation.coverage, 4),
        "doubt": _doubt(segmentation),
    }
    if job.truth:
        row |= _errors(segmentation, Path(job.truth))
    if old is not None:
        folder.remove(ROW)  # no longer done, until everything is written
    files = _write(segmentation, job, folder, old or {"files": {}})
    row |= {"status": "done", "seconds": round(time.perf_counter() - start, 3), "peak_memory": peak()}
    folder.remove(FAILED)
    note = {**empty_row(job.scan), **row} | {
        "files": files,
        "key": key,
        "truth": truth_key,
        "source": job.source,
        "units": job.units,
        "params": dataclasses.asdict(job.params),
        "version": job.version,
        "warnings": said,
    }
    folder.write(ROW, json.dumps(note, indent=1))
    return row


def _segmented(
    path: Path,
    job: Job,
    limit: int | None,
    tell: Callable[[str], None] | None,
    foretell: Callable[[dict[str, Any]], None],
) -> tuple[Segmentation, list[str]]:
    """The segmentation of a scan, and the warnings on the way."""
    stage = ""

    def progress(name: str, fraction: float) -> None:
        nonlocal stage
        if name != stage and tell is not None:
            stage = name
            tell(f"    {name}")

    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always", UserWarning)
        mesh = load(path, units=job.units)
        need = what_it_takes(mesh.n_faces, is_judged=job.truth != "", tile_faces=job.tile_faces)
        foretell({"scan": job.scan, "faces": mesh.n_faces, "need": need})
        if limit is not None and need > limit:
            raise _TooLargeError(need, limit)
        hear = None if tell is None else progress
        if job.tile_faces and not mesh.is_cloud:
            found = segment_tiles(mesh, job.params, max_faces=job.tile_faces, progress=hear)
        else:
            found = segment(mesh, job.params, progress=hear)
    said = [str(one.message) for one in heard if issubclass(one.category, UserWarning)]
    if tell is not None:
        for line in said:
            tell(f"    {line}")
    return found, said


def _doubt(segmentation: Segmentation) -> float:
    """Share of the labeled area that is probably wrong."""
    areas = np.where(segmentation.labels >= 0, segmentation.mesh.face_areas, 0.0)
    total = areas.sum()
    return round(float(((1 - segmentation.confidence) * areas).sum() / total), 4) if total > 0 else 1.0


def _errors(segmentation: Segmentation, truth: Path) -> dict[str, Any]:
    actual = read_labels(truth, segmentation.mesh)
    found = evaluate({"": segmentation}, actual, segmentation.mesh).loc[""]
    return {**{name: float(found[name]) for name in METRICS}, "n_truth": int(found["n_truth"])}


def _judged_again(
    job: Job, folder: Folder, path: Path, old: dict[str, Any], truth_key: str
) -> dict[str, Any] | None:
    """What an earlier run knew, judged by the truth of today; None if that takes a new segmentation."""
    known = {name: old.get(name) for name in COLUMNS[3:]}
    if not job.truth:
        return known
    if old.get("truth") != truth_key:
        suffixes = [suffix for suffix in LABELS if suffix != ".swproj"]  # which may hold corrections
        names = [name for suffix in suffixes for name in old["files"] if name.endswith(suffix)]
        if not names or not isinstance(folder, LocalFolder):
            return None
        mesh = load(path, units=job.units)
        old |= _errors(read_labels(folder.path / names[0], mesh), Path(job.truth)) | {"truth": truth_key}
        folder.write(ROW, json.dumps(old, indent=1))
    return known | {name: old.get(name) for name in (*METRICS, "n_truth")}


def _write(
    segmentation: Segmentation, job: Job, folder: Folder, old: dict[str, Any]
) -> dict[str, list[Any] | None]:
    """Write every format; files that an earlier run wrote and nobody has touched since may go."""
    names: list[str] = []
    with folder.writing() as place:
        for kind in job.formats:
            targets = _names(job, kind)
            is_ours = _may_go(folder, targets, old)
            if not is_ours and isinstance(folder, RemoteFolder):
                raise FileExistsError(f"{job.folder}/{targets[0]} is there, and no run of ours wrote it")
            if kind == "swproj":
                session = Session(segmentation.mesh, segmentation, params=job.params)
                try:
                    names.append(session.save(place / targets[0], overwrite=is_ours).name)
                finally:
                    session.close()
            else:
                paths = export(segmentation, segmentation.mesh, place / targets[0], kind, overwrite=is_ours)
                names += [path.name for path in paths]
        if _may_go(folder, [PICTURE], old):
            (place / PICTURE).write_bytes(thumbnail(segmentation))
            names.append(PICTURE)
    return {name: folder.mark(name) for name in names}


def _may_go(folder: Folder, names: Sequence[str], old: dict[str, Any]) -> bool:
    there = {name: mark for name in names if (mark := folder.mark(name)) is not None}
    return all(old["files"].get(name) == mark for name, mark in there.items())


def _is_whole(folder: Folder, row: dict[str, Any]) -> bool:
    """Whether all files of a row are there; those that somebody corrected count."""
    return all(folder.mark(name) is not None for name in row["files"])


def _key(path: Path, job: Job) -> str:
    """Digest of all that decides over the result: the scan's bytes, the parameters, the version."""
    digest = hashlib.blake2b(digest_size=16)
    digest.update(_digest(path).encode())
    waiting = referred(path)
    for name in waiting:  # grows while materials name pictures
        file = path.parent / name
        if file.is_file():
            digest.update(f"{name}\n{_digest(file)}".encode())
            waiting += [other for other in referred(file) if other not in waiting]
    rest: list[Any] = [dataclasses.asdict(job.params), sorted(job.formats), job.units, job.version]
    if job.tile_faces:
        rest.append(job.tile_faces)
    digest.update(json.dumps(rest, sort_keys=True).encode())
    return digest.hexdigest()


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
