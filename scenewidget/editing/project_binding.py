"""The log of a session and the project file that it is kept in, once there is one.

Goes in: operations, one at a time. Comes out: each of them on the disk before `append` returns, or the
reason why not. How a file looks inside is the matter of `scenewidget.editing.store` and `schema`.
"""

from __future__ import annotations

import errno
import os
import re
import warnings
import weakref
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from scenewidget.editing.files import checked_path
from scenewidget.editing.fingerprint import fingerprint, living_mesh
from scenewidget.editing.project import Operation, Project, ProjectError, Root
from scenewidget.editing.store import ProjectFile
from scenewidget.engine.mesh import Mesh, MeshError
from scenewidget.engine.readers import load

__all__ = ["ProjectBinding", "mesh_of_project"]

OF_OTHERS = (  # suffixes of scans and of labels: a project under such a name is taken for one of them
    *(".ply", ".obj", ".glb", ".gltf", ".stl", ".off", ".pcd", ".las", ".laz", ".e57", ".xyz", ".pts"),
    *(".npz", ".npy", ".json", ".xml", ".csv", ".txt", ".html", ".png"),
)


class ProjectBinding:
    """Keeps the log of a session, in memory at first and in a file once there is one.

    The session's lock guards it. What belongs into the file beside the log comes from the session when it is
    wanted, as ``make_project(include_mesh)``.

    Parameters
    ----------
    operations : iterable of Operation
        The log so far.
    on_takeover : method of no argument
        Called when another session of this process has taken the file over. Held weakly.

    Attributes
    ----------
    operations : list of Operation

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> session = sw.Session(mesh, seg)
    >>> session.path is None, session.is_saved
    (True, False)
    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> session.save(f"{folder.name}/square.swproj").name
    'square.swproj'
    >>> session.is_saved
    True
    >>> session.close()
    >>> folder.cleanup()
    """

    def __init__(self, operations: Iterable[Operation], on_takeover: Callable[[], None]) -> None:
        self.operations = list(operations)
        self._problem = ""  # of the last attempt to write
        self._on_takeover = weakref.WeakMethod(on_takeover)
        self._file: ProjectFile | None = None
        self._holds_mesh = False  # whether the file does
        self._must_renew = False  # whether the file lacks another automatic segmentation

    @property
    def path(self) -> Path | None:
        """The file; None before there is one."""
        return None if self._file is None else self._file.path

    @property
    def read_only(self) -> bool:
        """Whether the file belongs to somebody else: operations stay in memory."""
        return self._file is not None and self._file.read_only

    @property
    def reason(self) -> str:
        """Why the file can't be written; "" if it can."""
        return "" if self._file is None else self._file.read_only_reason

    @property
    def problem(self) -> str:
        """Why the last operation is not on the disk at that path now; "" if all is well."""
        return self._problem or ("" if self._file is None else self._file.trouble())

    @property
    def is_saved(self) -> bool:
        """Whether every operation is on the disk, in the file that lies at that path now."""
        if self._file is None:
            return False
        return self._file.root.n_operations == len(self.operations) and not self.problem

    def append(
        self, operation: Operation, make_project: Callable[[bool], Project], *, renew: bool = False
    ) -> None:
        """Log an operation; ``renew`` if another automatic segmentation belongs into the file with it.

        Trouble with the file is told by a warning and by `problem`, not raised: the edit is done.
        """
        self.operations.append(operation)
        self._flush(make_project, renew=renew)

    def take(self, path: Path, project: Project) -> None:
        """Keep the log from now on in the file that it was read from, if nobody else does.

        Raises
        ------
        FileChangedError
            The file has changed since it was read.
        """
        if not project.n_lost:
            file = ProjectFile.take(path, project)
        else:
            try:
                file = ProjectFile.write(path, project)  # what was lost can't be gone on from
            except OSError as error:
                file = ProjectFile(path.absolute(), project.root or Root(0, b"", b""), str(error))
        self._bind(file, holds_mesh=project.mesh is not None)

    def _bind(self, file: ProjectFile, *, holds_mesh: bool) -> None:
        if self._file is not None and self._file is not file:
            self._file.close()
        self._file, self._holds_mesh, self._problem, self._must_renew = file, holds_mesh, "", False
        file.on_takeover = weakref.WeakMethod(self._lose_file)

    def save(
        self,
        path: str | os.PathLike[str] | None,
        make_project: Callable[[bool], Project],
        *,
        include_mesh: bool,
        overwrite: bool,
    ) -> Path:
        """Write everything; see `Session.save`."""
        if path is None and self._file is None:
            raise ValueError("the session has no file yet: save('room.swproj')")
        if path is not None:
            _check_suffix(checked_path(path))
        mine = self._file
        target = mine.path if path is None and mine is not None else checked_path(path)
        is_same = mine is not None and mine.is_at(target)
        if mine is not None and is_same and path is None and mine.is_taken_over:
            raise PermissionError(f"{mine.path.name!r}: {mine.read_only_reason}; save under another name")
        trouble = mine.trouble() if mine is not None and is_same else ""
        if mine is not None and is_same and not trouble and not mine.read_only and not include_mesh:
            self._flush(make_project)
            if self.problem:
                raise OSError(self.problem)
            mine.checkpoint()
            return mine.path
        holds_mesh = include_mesh or (is_same and self._holds_mesh)
        if trouble and path is None:  # nobody has said that what lies there now may go
            overwrite = False
        try:
            file = ProjectFile.write(target, make_project(holds_mesh), replaces=mine, overwrite=overwrite)
        except FileExistsError as error:
            if trouble and path is None:
                raise FileExistsError(errno.EEXIST, trouble) from error
            raise
        self._bind(file, holds_mesh=holds_mesh)
        return file.path

    def save_copy(self, path: str | os.PathLike[str] | None, project: Project, *, overwrite: bool) -> Path:
        """Write a project to a file of its own, which the log does not go on in."""
        if path is None:
            raise ValueError("an anonymous copy needs a path: save('copy.swproj', anonymous=True)")
        target = checked_path(path)
        _check_suffix(target)
        if self._file is not None and self._file.is_at(target):
            raise ValueError(
                f"{target.name!r} is the file that this session works on; "
                "an anonymous copy needs another path"
            )
        file = ProjectFile.write(target, project, overwrite=overwrite)
        file.close()
        return file.path

    def close(self) -> None:
        """Let go of the file; the log goes on in memory."""
        if self._file is not None:
            self._file.close()
        self._file, self._problem = None, ""

    def _flush(self, make_project: Callable[[bool], Project], *, renew: bool = False) -> None:
        """Bring to the disk what is not there yet."""
        if self._file is None or self._file.read_only:
            return
        try:
            self._file.append(
                self.operations[self._file.root.n_operations :],
                make_project(False) if renew or self._must_renew else None,
            )
        except OSError as error:
            problem = re.sub(r"^\[Errno \d+\] ", "", str(error))
            self._must_renew = self._must_renew or renew
            if problem != self._problem:
                warnings.warn(f"{problem}. The edit is done, but only in memory", stacklevel=6)
            self._problem = problem
        else:
            self._problem, self._must_renew = "", False

    def _lose_file(self) -> None:
        self._problem = "a newer session has taken the file over"
        tell = self._on_takeover()
        if tell is not None:
            tell()


def _check_suffix(path: Path) -> None:
    if path.suffix.lower() in OF_OTHERS and not path.exists():  # else it is known what is there
        raise ValueError(
            f"{path.name!r} is no name for a project, which save writes: save('{path.stem}.swproj'); labels "
            f"in formats of other tools are written by sw.export(session.segmentation, mesh, {path.name!r})"
        )


def mesh_of_project(project: Project, path: Path, mesh: Mesh | Any | None = None) -> tuple[Mesh, str]:
    """The mesh of a project and where it was loaded from.

    Parameters
    ----------
    project : Project
    path : Path
        Of the project file: the mesh may lie beside it.
    mesh : Mesh, path, …, optional
        The mesh that a person gives. Without it: the one in the file, or the one that this process has
        loaded already, or the file that it was loaded from, whichever has the right fingerprint.

    Raises
    ------
    ProjectError
        The mesh given is another one, or none is to be found.
    """
    if mesh is not None:
        given = load(mesh)
        if fingerprint(given) != project.fingerprint:
            raise ProjectError(
                f"{path.name!r} belongs to another mesh: it was made on one of "
                f"{project.fingerprint}, but the mesh given has {fingerprint(given)}"
            )
        return given, given.source or project.source
    if project.mesh is not None:
        return project.mesh, project.source
    living = living_mesh(project.fingerprint)
    if living is not None:
        return living, project.source
    how = f"give it: Session.open({path.name!r}, mesh='scan.ply')"
    if not project.source:
        raise ProjectError(f"{path.name!r} does not hold the mesh ({project.fingerprint}); {how}")
    for place in (path.parent / Path(project.source).name, Path(project.source)):
        # a network path of a file from somebody else could send credentials to a stranger
        if str(place).startswith(("\\\\", "//")) or not place.is_file():
            continue
        try:
            found = load(place)
        except (MeshError, OSError):
            continue
        if fingerprint(found) == project.fingerprint:
            return found, str(place)
    raise ProjectError(
        f"{path.name!r} does not hold the mesh ({project.fingerprint}), and {project.source!r} is not there "
        f"any more or another one; {how}"
    )
