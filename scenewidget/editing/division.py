"""A scan of many rooms in a folder, a project for each room, and the labels of the whole.

Goes in: a mesh that is too large to be edited whole. Comes out: a folder that opens at once, as a coarse
mesh, from which rooms are read one at a time; what is edited in a room lands in the labels of the whole.
"""

from __future__ import annotations

import json
import os
import secrets
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.editing.files import FileLock, checked_path, explain
from scenewidget.editing.fingerprint import Fingerprint, fingerprint
from scenewidget.editing.session import Session
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import segment
from scenewidget.engine.rooms import coarse_mesh, rooms_of
from scenewidget.engine.segmentation import Segmentation

__all__ = ["Division"]

MARK = "rooms.json"  # written last: the folder is whole
PICTURE = "coarse.npz"
NONE: IntArray = np.zeros(0, dtype=np.int64)


class Division:
    """A scan divided into rooms; `make` and `open` give one.

    Attributes
    ----------
    folder : Path
    coarse : Mesh
        What the whole looks like from afar.
    coarse_room : (n,) int32
        Room of each of its faces.
    n_faces : tuple of int
        Of each room.
    max_faces : int or None
        Of a room, as it was divided; None if nobody knows.
    is_segmented : bool
        Whether there is a segmentation of the whole; otherwise rooms are segmented alone.

    Examples
    --------
    >>> import tempfile
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(4)  # 32 triangles, which is one room
    >>> halves = sw.Segmentation.from_labels(mesh, [0] * 16 + [1] * 16)
    >>> with tempfile.TemporaryDirectory() as place:
    ...     rooms = Division.make(f"{place}/rooms", mesh, segmentation=halves)
    ...     with rooms.session(0) as session:
    ...         step = session.merge(0, onto_face=31)
    ...     rooms.segmentation(mesh).n_segments
    1
    """

    def __init__(self, folder: Path, facts: dict[str, Any], coarse: Mesh, coarse_room: IntArray) -> None:
        self.folder = folder
        self.coarse = coarse
        self.coarse_room = coarse_room
        self.n_faces: tuple[int, ...] = tuple(facts["faces"])
        self.is_segmented: bool = facts["is_segmented"]
        self.max_faces: int | None = facts.get("max_faces")  # None: made before it was written down
        self._bytes: int | None = facts.get("bytes")  # of the scan's file
        self._fingerprint = Fingerprint.from_dict(facts["mesh"])

    def __repr__(self) -> str:
        return f"Division({len(self.n_faces)} rooms, {sum(self.n_faces)} faces)"

    @classmethod
    def make(
        cls,
        folder: str | os.PathLike[str],
        mesh: Mesh,
        *,
        segmentation: Segmentation | None = None,
        max_faces: int = 3_000_000,
    ) -> Division:
        """Divide a scan and write its parts; nothing else may lie in that folder.

        Parameters
        ----------
        folder : path
            Takes some 40 bytes a face.
        mesh : Mesh
        segmentation : Segmentation, optional
            Of the whole, as `batch.tiles.segment_tiles` makes it: its segments may reach through several
            rooms. Without one, each room is segmented alone when it is first opened.
        max_faces : int
            Of a room; see `engine.rooms.rooms_of`.

        Raises
        ------
        FileExistsError
            Something else lies there.
        ValueError
            The segmentation is of another mesh, or the limit is no count.
        OSError
            It can't be written.
        """
        place = _checked_folder(folder)
        if not isinstance(mesh, Mesh) or mesh.is_cloud:
            raise TypeError(
                f"mesh must be a Mesh, got {type(mesh).__name__}; a cloud is not divided into rooms: "
                "segment and edit it whole"
            )
        if segmentation is not None and not isinstance(segmentation, Segmentation):
            raise TypeError(f"segmentation must be a Segmentation, got {type(segmentation).__name__}")
        if segmentation is not None and segmentation.labels.shape != (mesh.n_faces,):
            raise ValueError(
                f"segmentation is of another mesh: it has {len(segmentation.labels)} labels, "
                f"and the scan {mesh.n_faces} faces"
            )
        if place.exists() and (not place.is_dir() or any(place.iterdir())):
            raise FileExistsError(f"{str(place)!r} is there, and holds something else: give another folder")
        room = rooms_of(mesh, max_faces=max_faces)
        coarse, shown = coarse_mesh(mesh)
        n_rooms = int(room.max()) + 1
        half = place.with_name(f".{place.name}.{secrets.token_hex(4)}.tmp")
        try:
            half.mkdir(parents=True)
        except OSError as error:
            raise explain(error, place) from error
        try:
            order = np.argsort(room, kind="stable")
            ends = np.cumsum(np.bincount(room, minlength=n_rooms))
            for k, faces in enumerate(np.split(order, ends[:-1])):
                part = mesh.part(faces)
                arrays: dict[str, Any] = {"face": faces.astype(np.int32), **_arrays(part)}
                if segmentation is not None:
                    arrays["labels"] = segmentation.labels[faces]
                    arrays["confidence"] = segmentation.confidence[faces]
                    arrays["names"] = np.array(segmentation.names, dtype=np.str_)
                    arrays["groups"] = np.array(segmentation.groups, dtype=np.int32)
                np.savez(half / f"{_name(k)}.npz", **arrays)
            np.savez(half / PICTURE, room=room[shown], **_arrays(coarse))
            facts = {
                "faces": np.bincount(room).tolist(),
                "mesh": fingerprint(mesh).to_dict(),
                "is_segmented": segmentation is not None,
                "max_faces": max_faces,
                "bytes": _size_of(mesh.source),
            }
            (half / MARK).write_text(json.dumps(facts), encoding="utf-8", newline="\n")
            if place.exists():
                place.rmdir()  # it is empty
            half.rename(place)
        except BaseException as error:
            shutil.rmtree(half, ignore_errors=True)
            if isinstance(error, OSError):
                raise explain(error, place) from error
            raise
        return cls.open(place)

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Division:
        """The division in a folder, as fast as its coarse mesh is read.

        Parameters
        ----------
        folder : path

        Raises
        ------
        FileNotFoundError
            There is none.
        ValueError
            It is damaged.
        """
        place = _checked_folder(folder)
        if not (place / MARK).is_file():
            raise FileNotFoundError(f"{str(place)!r} holds no rooms; Division.make divides a scan")
        try:
            facts = json.loads((place / MARK).read_text(encoding="utf-8"))
            with np.load(place / PICTURE) as arrays:
                return cls(place, facts, _mesh(dict(arrays)), arrays["room"])
        except (ValueError, TypeError, KeyError, EOFError, OSError) as error:
            raise ValueError(
                f"{str(place)!r} is damaged ({error}): divide the scan again, into another folder"
            ) from error

    def refuse_other(
        self,
        *,
        scan: Mesh | str | os.PathLike[str] | None = None,
        segmentation: Segmentation | None = None,
        max_faces: int | None = None,
    ) -> None:
        """Raise if the folder was not made with the same; None stands for whatever it was made with.

        Parameters
        ----------
        scan : Mesh or path, optional
            Of a path only the size of the file counts, so that it need not be read.
        segmentation : Segmentation, optional
        max_faces : int, optional

        Raises
        ------
        ValueError
            It was made with something else, so that what is given now would be ignored.
        """
        place = str(self.folder)
        size = None if scan is None or isinstance(scan, Mesh) else _size_of(scan)
        if (isinstance(scan, Mesh) and not self.is_of(scan)) or (size and size != (self._bytes or size)):
            raise ValueError(f"{place!r} holds the rooms of another scan; give another folder=")
        if max_faces is not None and max_faces != self.max_faces:
            raise ValueError(
                f"{place!r} was divided with max_faces={self.max_faces}, not {max_faces}; "
                "leave it out to go on there, or give another folder="
            )
        if segmentation is not None and not self._is_made_with(segmentation):
            made = "another one" if self.is_segmented else "none"
            raise ValueError(
                f"segmentation: {place!r} was divided with {made}; "
                "leave it out to go on there, or give another folder="
            )

    def _is_made_with(self, segmentation: Segmentation) -> bool:
        if not self.is_segmented:
            return False
        return all(
            np.array_equal(arrays["labels"], segmentation.labels[arrays["face"]])
            for arrays in map(self._read, range(len(self.n_faces)))
            if arrays["face"].max(initial=-1) < len(segmentation.labels)
        ) and sum(self.n_faces) == len(segmentation.labels)

    def is_of(self, mesh: Mesh) -> bool:
        """Whether a mesh is the one that was divided.

        Parameters
        ----------
        mesh : Mesh
        """
        return fingerprint(mesh) == self._fingerprint

    def part(self, room: int) -> Mesh:
        """The faces of a room.

        Parameters
        ----------
        room : int
            From 0; the largest first.

        Raises
        ------
        ValueError
            No such room, or its file is damaged.
        """
        return _mesh(self._read(room))

    def project(self, room: int) -> Path:
        """File in which a room is corrected, whether there is one yet or not.

        Parameters
        ----------
        room : int
        """
        return self.folder / f"{_name(self._checked(room))}.swproj"

    def lock(self, room: int) -> tuple[FileLock | None, str]:
        """The lock on a room, which ends with the process, or None and who has it.

        Parameters
        ----------
        room : int

        Raises
        ------
        OSError
            The folder can't be written.
        """
        place = self.folder / _name(self._checked(room))
        lock = FileLock(place)
        try:
            holder = lock.acquire()
        except OSError as error:
            raise explain(error, place) from error
        return (None, holder) if holder else (lock, "")

    def session(
        self,
        room: int,
        params: Params | None = None,
        *,
        progress: Callable[[str, float], None] | None = None,
    ) -> Session:
        """The session in which a room is corrected; at first it is segmented, if the whole was not.

        Parameters
        ----------
        room : int
        params : Params, optional
            Of that segmentation.
        progress : callable (stage, fraction), optional

        Raises
        ------
        ValueError
            No such room.
        ProjectError
            Its project is damaged.
        """
        path, arrays = self.project(room), self._read(room)
        part = _mesh(arrays)
        if path.exists():
            return Session.open(path, part)
        found = _given(part, arrays)
        if found is None:
            params = params or Params()
            session = Session(part, segment(part, params, progress=progress), params=params)
        else:
            session = Session(part, found)
        session.save(path, overwrite=False)
        return session

    def segmentation(self, mesh: Mesh, params: Params | None = None) -> Segmentation:
        """The labels of the whole as they are now, rooms that nobody has opened included.

        A segment of the whole that reaches through several rooms is one as long as it lives in them: what
        was merged away or split off in one room is so in that room alone.

        Parameters
        ----------
        mesh : Mesh
            The scan.
        params : Params, optional
            For rooms that are not segmented yet.

        Raises
        ------
        ValueError
            Another mesh, or a room's file is damaged.
        """
        if not self.is_of(mesh):
            raise ValueError(
                f"mesh is not the one that was divided into {str(self.folder)!r}: give that, or the file "
                "that it came from; one saved anew may have fewer digits"
            )
        labels = np.full(mesh.n_faces, -1, dtype=np.int64)
        confidence = np.zeros(mesh.n_faces, dtype=np.float32)
        names: dict[int, str] = {}
        groups: dict[int, int] = {}
        fresh = mesh.n_faces  # beyond all labels that the whole can have
        for k in range(len(self.n_faces)):
            arrays = self._read(k)
            if "labels" not in arrays and not self.project(k).exists():
                self.session(k, params).close()
            ids, sure, named, grouped, kept = self._now(k, arrays)
            of_whole = fresh + np.arange(int(ids.max(initial=-1)) + 1)
            of_whole[: len(kept)] = kept[: len(of_whole)]
            keep = ids >= 0
            labels[arrays["face"][keep]] = of_whole[ids[keep]]
            confidence[arrays["face"]] = sure
            names = {**{int(of_whole[i]): name for i, name in named.items()}, **names}
            if k == 0:
                groups = dict(enumerate(arrays.get("groups", NONE).tolist()))
            groups |= {int(of_whole[i]): int(of_whole[w]) for i, w in grouped.items()}
            fresh += len(of_whole)
        ids, dense = np.unique(labels, return_inverse=True)
        is_part = bool(ids[0] < 0)
        named_ids = ids[is_part:].tolist()
        place = {i: k for k, i in enumerate(named_ids)}
        return Segmentation.from_labels(
            mesh,
            dense - is_part,
            names=[names.get(i, "") for i in named_ids],
            confidence=confidence,
            groups=[place.get(groups.get(i, i), place[i]) for i in named_ids],
        )

    def _now(
        self, room: int, arrays: dict[str, Any]
    ) -> tuple[IntArray, FloatArray, dict[int, str], dict[int, int], IntArray]:
        """Of a room: segments, confidence, names, other wholes than before, ids of the first in all."""
        part = _mesh(arrays)
        given = _given(part, arrays)
        if given is not None and not self.project(room).exists():
            names = {k: name for k, name in enumerate(given.names) if name}
            return given.labels, given.confidence, names, {}, _labels_of(given.labels, arrays["labels"])
        with (
            tempfile.TemporaryDirectory() as copies,  # others may be at work in it, and opening writes
            Session.open(shutil.copy(self.project(room), copies), part) as session,
        ):
            ids = session.atom_segments[session.atoms.face_atom]
            kept = _labels_of(session.automatic.labels, arrays["labels"]) if given is not None else NONE
            sure = session.segmentation.confidence
            before, after = dict(enumerate(session.automatic.groups)), session.segment_groups
            regrouped = {i: after.get(i, i) for i in {*before, *after} if after.get(i, i) != before.get(i, i)}
            return ids, sure, session.segment_names, regrouped, kept

    def _read(self, room: int) -> dict[str, Any]:
        path = self.folder / f"{_name(self._checked(room))}.npz"
        try:
            with np.load(path) as arrays:
                return {name: arrays[name] for name in arrays.files}
        except (ValueError, EOFError, OSError) as error:
            raise ValueError(f"{str(path)!r} can't be read ({error}): divide the scan again") from error

    def _checked(self, room: int) -> int:
        if isinstance(room, bool) or not hasattr(room, "__index__") or not 0 <= int(room) < len(self.n_faces):
            raise ValueError(
                f"room must be a whole number from 0 to {len(self.n_faces) - 1}, got {room!r:.200}"
            )
        return int(room)


def _size_of(path: str | os.PathLike[str]) -> int | None:
    """Bytes of a file; None if there is none."""
    try:
        return Path(path).stat().st_size if path else None
    except OSError:
        return None


def _checked_folder(folder: object) -> Path:
    place = checked_path(folder)
    if not place.name:
        raise ValueError(f"folder must have a name, such as 'flat.rooms', got {str(folder)!r}")
    return place


def _labels_of(automatic: IntArray, whole: IntArray) -> IntArray:
    """The whole's label of each automatic one; none if they part the room otherwise."""
    table = np.full(int(automatic.max(initial=-1)) + 2, -1, dtype=np.int64)  # the last is for unlabeled faces
    table[automatic] = whole
    return table[:-1] if np.array_equal(table[automatic], whole) else NONE


def _given(part: Mesh, arrays: Any) -> Segmentation | None:
    """What the whole's segmentation says of a room; None if there was none."""
    if "labels" not in arrays:
        return None
    told = {"names": arrays["names"].tolist(), "groups": arrays.get("groups", ())}
    return Segmentation.from_labels(part, arrays["labels"], confidence=arrays["confidence"], **told)


def _name(room: int) -> str:
    return f"room_{room + 1:03d}"


def _arrays(mesh: Mesh) -> dict[str, Any]:
    colors = {} if mesh.vertex_colors is None else {"vertex_colors": mesh.vertex_colors}
    return {"vertices": mesh.vertices, "faces": mesh.faces, **colors}


def _mesh(arrays: Any) -> Mesh:
    return Mesh(arrays["vertices"], arrays["faces"], arrays.get("vertex_colors"))
