"""Where scans lie and where results go: folders of this machine, or URLs of stores such as S3.

What lies at a URL is fetched to a temporary file before it is read, and results are made in a temporary
folder before they are sent; fsspec, which comes with Dask, knows the stores.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import json
import os
import re
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from scenewidget.editing.files import explain, left_behind, replacing
from scenewidget.engine.readers.sniff import MESHES

__all__ = [
    "SCANS",
    "LocalFolder",
    "RemoteFolder",
    "Scan",
    "files_below",
    "folder_at",
    "is_hidden",
    "is_url",
    "join",
    "local_copy",
    "referred",
    "scans_in",
    "without_dots",
]

SCANS = tuple(f".{kind}" for kind in (*MESHES, "pcd", "las", "laz", "e57", "xyz", "pts"))
_WANTED = "scans must be a folder, a pattern, or a list of paths or URLs"
LISTED = 64_000  # bytes at the beginning of an OBJ in which it names its materials


@dataclass(frozen=True)
class Scan:
    """A file that holds a scan.

    Attributes
    ----------
    path : str
        Absolute path, or URL.
    size : int
        Bytes.
    """

    path: str
    size: int


def is_url(path: object) -> bool:
    """Whether a path is a URL of some store; ``file://`` is no other than a path.

    Examples
    --------
    >>> is_url("s3://scans/kitchen"), is_url("scans/kitchen")
    (True, False)
    """
    return isinstance(path, str) and re.match(r"[a-z][a-z0-9+.-]+://", path, re.IGNORECASE) is not None


def is_hidden(path: Path | PurePosixPath) -> bool:
    """Whether a part of a path begins with a dot.

    Examples
    --------
    >>> from pathlib import Path
    >>> is_hidden(Path("a/.cache/b.ply")), is_hidden(Path("a/b.ply"))
    (True, False)
    """
    return any(part.startswith(".") and part != ".." for part in path.parts)


def join(folder: str, name: str) -> str:
    """A path below a folder or URL.

    Examples
    --------
    >>> join("s3://scans/out/", "kitchen/a.ply")
    's3://scans/out/kitchen/a.ply'
    """
    return f"{folder.rstrip('/')}/{name}" if is_url(folder) else str(Path(folder) / name)


# --- scans ----------------------------------------------------------------------------------------


def scans_in(scans: Any) -> dict[str, Scan]:
    """Scans among files and in folders, also in those below, by name.

    Parameters
    ----------
    scans : path, URL, or sequence of them
        Folders (with all below; links are followed), files, or patterns such as ``"scans/*.ply"``.

    Returns
    -------
    scans : dict of str to Scan
        The name is the path relative to the folder that was given, or that holds all that were given.

    Raises
    ------
    TypeError
        Something that is no path.
    ValueError
        No such path, no scan there, two of one name, or a store that can't be reached.
    PermissionError
        A folder that can't be read.

    Examples
    --------
    >>> scans_in("no/such/folder")
    Traceback (most recent call last):
        ...
    ValueError: 'no/such/folder' does not exist; give files, folders or a pattern such as 'scans/*.ply'
    """
    given = [scans] if isinstance(scans, str | os.PathLike) else scans
    if isinstance(given, bytes | Mapping) or not isinstance(given, Iterable):
        raise TypeError(f"{_WANTED}, got {type(scans).__name__}")
    given = list(given)
    strange = [path for path in given if not isinstance(path, str | os.PathLike)]
    if strange:
        raise TypeError(f"{_WANTED}, got one with {type(strange[0]).__name__}")
    if not given or "" in given:
        raise ValueError("scans is empty: give a folder, a pattern such as 'scans/*.ply', or a list of files")
    given = [path.removeprefix("file://") if isinstance(path, str) else path for path in given]
    urls = [str(path) for path in given if is_url(path)]
    found = _local([Path(path) for path in given if not is_url(path)]) if len(urls) < len(given) else {}
    for url in urls:
        for name, scan in _remote(url).items():
            if found.setdefault(name, scan) != scan:
                raise ValueError(f"two scans are called {name!r}: {found[name].path} and {scan.path}")
    if not found:
        listed = ", ".join(SCANS)
        places = ", ".join(repr(str(path)) for path in given)
        raise ValueError(f"no scans in {places}; looked for files that end in {listed}")
    return dict(sorted(found.items()))


def _local(paths: Sequence[Path]) -> dict[str, Scan]:
    found: set[Path] = set()
    for path in paths:
        if path.is_dir():
            files = (file for file in files_below(path) if file.suffix.lower() in SCANS)
            found |= {file.absolute() for file in files if not is_hidden(file.relative_to(path))}
        elif path.exists():
            found.add(path.absolute())
        elif any(sign in str(path) for sign in "*?["):
            base = Path(path.anchor)
            found |= {p.absolute() for p in base.glob(str(path.relative_to(base))) if p.is_file()}
        else:
            raise ValueError(
                f"{str(path)!r} does not exist; give files, folders or a pattern such as 'scans/*.ply'"
            )
    if not found:
        return {}
    absolute = sorted({without_dots(path) for path in found})
    root = (
        without_dots(paths[0].absolute())
        if len(paths) == 1 and paths[0].is_dir()
        else _common_folder(absolute)
    )
    return {_readable(p.relative_to(root)): Scan(str(p), _size(p)) for p in absolute}


def without_dots(path: Path) -> Path:
    """A path without "..": names of scans are names of folders below ``out``, and must not lead out of it.

    Examples
    --------
    >>> without_dots(Path("/scans/kitchen/../bath.ply")).name
    'bath.ply'
    """
    return path.parent.resolve() / path.name if ".." in path.parts else path


def _readable(path: Path) -> str:
    """A path with escapes for bytes that aren't UTF-8, which tables and logs couldn't hold."""
    return os.fsencode(path.as_posix()).decode("utf-8", "backslashreplace")


def _size(path: Path) -> int:
    """Bytes of a file; 0 where that can't be told, as of a link to nowhere, which its row will say."""
    try:
        return path.stat().st_size
    except OSError:
        return 0


def files_below(folder: Path) -> Iterator[Path]:
    """All files in a folder and those below, links to folders followed once.

    Raises
    ------
    PermissionError
        A folder that can't be read.

    Examples
    --------
    >>> list(files_below(Path("no/such/folder")))
    []
    """

    def refuse(error: OSError) -> None:
        if isinstance(error, FileNotFoundError):  # gone since it was listed
            return
        raise PermissionError(
            error.errno,
            f"{error.filename!r} can't be read: {error.strerror}; change that, or give the folders beside it",
        ) from error

    seen: set[str] = set()
    for here, folders, files in os.walk(folder, onerror=refuse, followlinks=True):
        place = os.path.realpath(here)
        if place in seen:  # a link to a folder above
            folders.clear()
            continue
        seen.add(place)
        yield from (Path(here) / name for name in files)


def _common_folder(paths: Sequence[Path]) -> Path:
    folder = paths[0].parent
    while not all(path.is_relative_to(folder) for path in paths):
        folder = folder.parent
    return folder


def _remote(url: str) -> dict[str, Scan]:
    fs, root = _store(url)
    is_pattern = any(sign in root for sign in "*?[")
    try:
        listing = fs.glob(root, detail=True) if is_pattern else _found(fs, root)
    except Exception as error:  # every store has kinds of its own
        why = str(error) or type(error).__name__
        raise ValueError(f"{url!r} can't be listed: {why}") from error
    files = {p: d for p, d in listing.items() if d.get("type") == "file"}
    if is_pattern or list(files) == [root]:
        folders = [path.split("/")[:-1] for path in files]  # by hand: URLs have empty parts
        same = itertools.takewhile(lambda parts: len(set(parts)) == 1, zip(*folders, strict=False))
        root = "/".join(parts[0] for parts in same)
    found = {}
    for path, details in files.items():
        name = PurePosixPath(path.removeprefix(root).lstrip("/"))
        if name.suffix.lower() in SCANS and not is_hidden(name):
            found[str(name)] = Scan(fs.unstrip_protocol(path), int(details.get("size") or 0))
    return found


def _found(fs: Any, root: str) -> dict[str, Any]:
    """Files of a store at or below a path; what is called like a scan counts, also if it isn't there.

    Then its row says so. It is asked for itself first: a web server would send all of a scan to be searched
    for links.
    """
    if PurePosixPath(root).suffix.lower() in SCANS:
        try:
            details = fs.info(root)
        except FileNotFoundError:
            return {root: {"type": "file"}}
        if details.get("type") == "file":
            return {root: details}
    listing: dict[str, Any] = fs.find(root, detail=True)
    return listing


def _store(url: str) -> tuple[Any, str]:
    try:
        import fsspec.core
    except ImportError as error:
        raise ValueError(f'{url!r} is a URL, which wants fsspec: pip install "scenewidget[batch]"') from error
    try:
        fs, path = fsspec.core.url_to_fs(url)
    except (ImportError, ValueError, OSError) as error:
        raise ValueError(f"{url!r} can't be opened: {error}") from error
    return fs, path


# --- files that belong to a scan ------------------------------------------------------------------


@contextlib.contextmanager
def local_copy(path: str) -> Iterator[Path]:
    """A file of this machine for the length of a block: itself, or fetched with what it refers to.

    Examples
    --------
    >>> with local_copy("scans/a.ply") as path:
    ...     path.name
    'a.ply'
    """
    if not is_url(path):
        yield Path(path)
        return
    fs, remote = _store(path)
    folder = PurePosixPath(remote).parent
    with tempfile.TemporaryDirectory(prefix="scenewidget-") as temporary:
        copy = Path(temporary) / PurePosixPath(remote).name
        try:
            fs.get_file(remote, str(copy))
        except FileNotFoundError as error:
            raise FileNotFoundError(errno.ENOENT, "nothing there", path) from error
        waiting = referred(copy)
        while waiting:
            name = waiting.pop()
            target = Path(temporary) / name
            if not target.exists() and fs.exists(str(folder / name)):
                target.parent.mkdir(parents=True, exist_ok=True)
                fs.get_file(str(folder / name), str(target))
                waiting += referred(target)
        yield copy


def referred(path: Path) -> list[str]:
    """Files that a scan names: buffers and pictures of glTF, materials of OBJ and their pictures.

    Only names below the scan's own folder count.

    Examples
    --------
    >>> referred(Path("scans/a.ply"))
    []
    """
    kind = path.suffix.lower()
    names: list[str] = []
    if kind == ".gltf":
        with contextlib.suppress(ValueError, AttributeError, TypeError):
            content = json.loads(path.read_text(encoding="utf-8"))
            entries = [*content.get("buffers", ()), *content.get("images", ())]
            names = [str(e["uri"]) for e in entries if not str(e.get("uri", "data:")).startswith("data:")]
    elif kind in (".obj", ".mtl"):
        with path.open("rb") as file:
            text = file.read(LISTED).decode("utf-8", "replace")
        pattern = r"^\s*mtllib\s+(.+?)\s*$" if kind == ".obj" else r"^\s*map_\w+\s+(?:.*\s)?(\S+)\s*$"
        names = re.findall(pattern, text, re.MULTILINE)
    inside = [
        name
        for name in names
        if not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts
    ]
    return list(dict.fromkeys(inside))


# --- folders of results ---------------------------------------------------------------------------


class LocalFolder:
    """The folder of one scan's results on this machine.

    Parameters
    ----------
    path : path
        Made when something is written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as place:
    ...     folder = LocalFolder(place)
    ...     folder.write("row.json", "{}")
    ...     folder.read("row.json"), folder.read("none.json")
    ('{}', None)
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)

    def read(self, name: str) -> str | None:
        """The text of a file; None if it isn't there."""
        try:
            return (self.path / name).read_text(encoding="utf-8", errors="replace")
        except (FileNotFoundError, NotADirectoryError):
            return None

    def mark(self, name: str) -> list[Any] | None:
        """By which a file is known again, size and time; None if it isn't there."""
        try:
            found = (self.path / name).stat()
        except (FileNotFoundError, NotADirectoryError):
            return None
        return [found.st_size, found.st_mtime_ns]

    def write(self, name: str, text: str) -> None:
        """Write a small file, whole or not at all."""
        self._make()
        with replacing(self.path / name) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")

    def remove(self, name: str) -> None:
        """Remove a file if it is there."""
        with contextlib.suppress(NotADirectoryError):
            (self.path / name).unlink(missing_ok=True)

    def sweep(self, names: Iterable[str]) -> None:
        """Remove what a process that was killed has left half written of these files."""
        for name in names:
            for path in left_behind(self.path / name):
                with contextlib.suppress(OSError):
                    path.unlink()

    @contextlib.contextmanager
    def writing(self) -> Iterator[Path]:
        """A folder to write files into; they are at their place when the block ends well."""
        self._make()
        yield self.path

    def _make(self) -> None:
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except FileExistsError as error:
            raise NotADirectoryError(
                errno.ENOTDIR,
                "a file is where the folder of its results should be; move it away",
                str(self.path),
            ) from error
        except OSError as error:
            raise explain(error, self.path) from error


class RemoteFolder:
    """The folder of one scan's results in a store; as `LocalFolder`.

    Parameters
    ----------
    url : str
    """

    def __init__(self, url: str) -> None:
        self._fs, self._path = _store(url)

    def read(self, name: str) -> str | None:
        """The text of a file; None if it isn't there."""
        try:
            return str(self._fs.cat_file(f"{self._path}/{name}").decode("utf-8", "replace"))
        except FileNotFoundError:
            return None

    def mark(self, name: str) -> list[Any] | None:
        """By which a file is known again, size and the store's own mark; None if it isn't there."""
        try:
            details = self._fs.info(f"{self._path}/{name}")
        except FileNotFoundError:
            return None
        return [details.get("size"), self._fs.ukey(f"{self._path}/{name}")]

    def names(self) -> list[str]:
        """Of the files that lie in it, not of those in folders below."""
        self._fs.invalidate_cache()  # what others have done meanwhile counts
        try:
            found = self._fs.ls(self._path, detail=False)
        except FileNotFoundError:
            return []
        return [str(path).rpartition("/")[2] for path in found]

    def write(self, name: str, text: str) -> None:
        """Write a small file."""
        self._fs.makedirs(self._path, exist_ok=True)
        self._fs.pipe_file(f"{self._path}/{name}", text.encode("utf-8"))

    def remove(self, name: str) -> None:
        """Remove a file if it is there."""
        with contextlib.suppress(FileNotFoundError):
            self._fs.rm_file(f"{self._path}/{name}")

    def sweep(self, names: Iterable[str]) -> None:
        """Nothing: files are sent only once they are whole."""

    @contextlib.contextmanager
    def writing(self) -> Iterator[Path]:
        """A temporary folder to write files into; they are sent when the block ends well."""
        with tempfile.TemporaryDirectory(prefix="scenewidget-") as temporary:
            yield Path(temporary)
            self._fs.makedirs(self._path, exist_ok=True)
            for file in sorted(Path(temporary).iterdir()):
                if file.is_file() and not file.name.startswith(".") and not file.name.endswith(".lock"):
                    self._fs.put_file(str(file), f"{self._path}/{file.name}")


def folder_at(path: str) -> LocalFolder | RemoteFolder:
    """The folder of results at a path or URL.

    Examples
    --------
    >>> type(folder_at("out/a.ply")).__name__
    'LocalFolder'
    """
    return RemoteFolder(path) if is_url(path) else LocalFolder(path)
