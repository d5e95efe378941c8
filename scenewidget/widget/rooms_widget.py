"""A scan of many rooms in a notebook: the whole as a coarse mesh, and the editor on one of its rooms."""

from __future__ import annotations

import html
import os
import threading
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import ipywidgets as widgets
import numpy as np
import traitlets

from scenewidget.editing.division import Division
from scenewidget.editing.files import FileLock
from scenewidget.editing.session import Session
from scenewidget.engine.checks import KnownNames
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.readers import load
from scenewidget.engine.segmentation import Segmentation
from scenewidget.widget.arranged import Arranged
from scenewidget.widget.lifetimes import close_all
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.scene_widget import SceneWidget

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Rooms"]

CEILING = 0.85  # of the height: above it nothing is drawn of the whole, so that one looks into the rooms
NO_ROOM = -1
_at_work: weakref.WeakValueDictionary[str, Rooms] = weakref.WeakValueDictionary()  # by folder
MOST_FACES = 3_000_000  # of a room, where nobody says how many


class Rooms(KnownNames, Arranged, widgets.VBox):
    """A scan that is too large to be edited whole: looked at coarsely, corrected room by room.

    The first time, the scan is divided into its rooms, which takes some seconds a million faces; from then on
    its folder opens at once. A click on a room in the picture, or its number in the list, opens the editor on
    it, with all its faces. Every edit is in the room's project in the folder before the editor says "Saved",
    and in the labels of the whole: `segmentation`, `save`, `sw.export`.

    Parameters
    ----------
    scan : Mesh, path, trimesh.Trimesh or (vertices, faces)
        A file is read only when its faces are needed: to divide it, and for the labels of the whole.
    folder : path, optional
        Where rooms and corrections are kept; by default ``<name of the scan>.rooms`` where the kernel runs.
        What lies there goes on, if it was made with the same ``segmentation`` and ``max_faces`` or you leave
        them out.
    params : Params, optional
        For rooms that are segmented alone.
    segmentation : Segmentation, optional
        Of the whole, as `batch.tiles.segment_tiles` makes it. Without one, each room is segmented when it is
        first opened, as it would be alone.
    max_faces : int, optional
        Of a room; a larger one is halved. By default 3 million.
    height : int
        Of each picture, in pixels.

    Attributes
    ----------
    current : int
        The room that is open, -1 if none is. 0 is the one with the most faces.
    editor : SceneWidget or None
        On that room.
    n_edits : int
        Made here so far.
    view : SceneView
        The picture of the whole, coloured by room.
    division : Division
        The folder.

    Raises
    ------
    ValueError
        The folder holds the rooms of another scan, or was made with another segmentation or limit.
    FileExistsError
        It holds something else.

    Examples
    --------
    >>> import tempfile
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(4)  # 32 triangles, which is one room
    >>> halves = sw.Segmentation.from_labels(mesh, [0] * 16 + [1] * 16)
    >>> folder = tempfile.TemporaryDirectory()
    >>> rooms = sw.Rooms(mesh, f"{folder.name}/flat", segmentation=halves)
    >>> rooms
    Rooms(32 faces, 1 rooms)
    >>> rooms.edit(0)
    >>> rooms.editor.session.merge(0, onto_face=31).title
    'Merge'
    >>> rooms.segmentation().n_segments
    1
    >>> rooms.close()
    >>> folder.cleanup()
    """

    current = traitlets.Int(NO_ROOM, read_only=True)
    """The room that is open; -1 if none is."""

    n_edits = traitlets.Int(0, read_only=True)
    """Edits since this was made, less what was undone, in rooms that had segments when they were opened."""

    _set_once = ("division", "view")

    def __init__(
        self,
        scan: Mesh | Any,
        folder: str | os.PathLike[str] | None = None,
        params: Params | None = None,
        *,
        segmentation: Segmentation | None = None,
        max_faces: int | None = None,
        height: int = 520,
    ) -> None:
        if params is not None and not isinstance(params, Params):
            raise TypeError(
                f"params must be a Params, got {type(params).__name__}; write Params(n_segments=…)"
            )
        self._scan = scan
        self._params = params
        self._lock = threading.RLock()
        self._is_showing = False
        self._picture_height = height
        self._editor: SceneWidget | None = None
        self._held: FileLock | None = None
        self._stop_hearing: Callable[[], None] | None = None
        self.division = self._divided(folder, segmentation, max_faces)
        self.view = SceneView(self.division.coarse, height=height)
        self.view.section = [(0.0, 1.0), (0.0, 1.0), (0.0, CEILING)]
        self.view.on_msg(self._handle_message)
        self._list = widgets.Dropdown(description="Room", layout={"width": "auto"})
        self._list.observe(self._choose, "value")
        self._leave_button = widgets.Button(description="Close room", disabled=True, layout={"flex": "none"})
        self._leave_button.on_click(lambda _: self.leave())
        self._note = widgets.HTML(layout={"flex": "1 1 200px"})
        self._bar = widgets.HBox(
            [self._list, self._leave_button, self._note], layout={"flex_flow": "row wrap"}
        )
        self._place = widgets.VBox()
        super().__init__([self.view, self._bar, self._place])
        self._show()
        place = os.path.realpath(self.division.folder)
        before = _at_work.get(place)
        if before is not None:
            before.close()  # a cell that was run again
        _at_work[place] = self

    def __repr__(self) -> str:
        return f"Rooms({sum(self.division.n_faces)} faces, {len(self.division.n_faces)} rooms)"

    @property
    def editor(self) -> SceneWidget | None:
        """On the room that is open; None if none is."""
        return self._editor

    @property
    def height(self) -> int:
        """Of each picture, in pixels; can be set."""
        height: int = self.view.height
        return height

    @height.setter
    def height(self, height: int) -> None:
        self.view.height = height
        if self._editor is not None:
            self._editor.height = height
        self._picture_height = height

    # --- what people and scripts do ---------------------------------------------------------------

    def edit(self, room: int) -> None:
        """Open the editor on a room; the one that is open is left as it is, saved.

        Parameters
        ----------
        room : int
            From 0.

        Raises
        ------
        ValueError
            No such room, or one that somebody has open.
        ProjectError
            Its project is damaged.
        """
        with self._lock:
            if room == self.current != NO_ROOM:
                return
            held, holder = self.division.lock(room)
            if held is None:
                raise ValueError(f"room {room + 1} of the list is open elsewhere: {holder}")
            try:
                editor = self._editor_on(room)
            except BaseException:
                held.release()
                raise
            self._close_editor()
            self._editor, self._held = editor, held
            if editor.session is not None:
                self._stop_hearing = self._count_edits(editor.session)
            self._place.children = [editor]
            self.set_trait("current", int(room))
            self._show()

    def leave(self) -> None:
        """Close the editor; what was done in it is kept."""
        with self._lock:
            self._close_editor()
            self._show()

    def segmentation(self) -> Segmentation:
        """The labels of the whole as they are now; rooms without any are segmented first.

        Raises
        ------
        ValueError
            The scan has changed since it was divided.
        """
        return self.division.segmentation(self.mesh(), self._params)

    def mesh(self) -> Mesh:
        """The whole scan, read now if it has not been yet."""
        if not isinstance(self._scan, Mesh):
            self._scan = load(self._scan)
        return self._scan

    def to_frame(self) -> pd.DataFrame:
        """A row a room: its faces, and whether it has been opened."""
        import pandas as pd

        n = self.division.n_faces
        opened = [self.division.project(k).exists() for k in range(len(n))]
        return pd.DataFrame({"faces": n, "opened": opened}).rename_axis("room")

    def close(self) -> None:
        """Leave the room that is open, saved, and take the widgets off the page."""
        if "_place" in vars(self):  # not if __init__ refused its folder
            with self._lock:
                self._close_editor()
            close_all(self.view, self._list, self._leave_button, self._note, self._bar, self._place)
        super().close()

    # --- inside -----------------------------------------------------------------------------------

    def _divided(
        self, folder: str | os.PathLike[str] | None, segmentation: Segmentation | None, max_faces: int | None
    ) -> Division:
        name = Path(self._scan).stem if isinstance(self._scan, str | os.PathLike) else ""
        if folder is None and not name:
            name = Path(getattr(self._scan, "source", "")).stem or "scan"
        place = Path(folder) if folder is not None else Path(f"{name}.rooms")
        try:
            division = Division.open(place)
        except FileNotFoundError:
            limit = MOST_FACES if max_faces is None else max_faces
            return Division.make(place, self.mesh(), segmentation=segmentation, max_faces=limit)
        scan = self._scan if isinstance(self._scan, Mesh | str | os.PathLike) else None
        division.refuse_other(scan=scan, segmentation=segmentation, max_faces=max_faces)
        return division

    def _editor_on(self, room: int) -> SceneWidget:
        path = self.division.project(room)
        if not path.exists() and self.division.is_segmented:
            self.division.session(room).close()
        part = self.division.part(room)
        if not path.exists():  # segmented while one looks at it
            return SceneWidget(part, self._params, height=self._picture_height, autosave=path)
        editor = SceneWidget(part, height=self._picture_height, autosave=False)
        try:
            editor.restore(path)
            editor.view.color_by = "segments"
        except BaseException:
            editor.close()
            raise
        return editor

    def _count_edits(self, session: Session) -> Callable[[], None]:
        before = self.n_edits - len(session.edits)
        return session.observe(lambda _: self.set_trait("n_edits", before + len(session.edits)))

    def _close_editor(self) -> None:
        """Called with the lock held."""
        editor = self.editor
        if editor is None:
            return
        session = editor.session
        if session is not None and session.path is None:  # so that it need not be computed again
            session.save(self.division.project(self.current), overwrite=False)
        if self._stop_hearing is not None:
            self._stop_hearing()
            self._stop_hearing = None
        editor.close()
        if session is not None:
            session.close()
        self._editor = None
        if self._held is not None:
            self._held.release()
            self._held = None
        self._place.children = []
        self.set_trait("current", NO_ROOM)

    def _show(self) -> None:
        room = self.division.coarse_room
        names = {k: self._title(k) for k in range(len(self.division.n_faces))}
        self.view.set_segments(room, names=names, ids=np.arange(len(names)))
        self._is_showing = True  # what happens to the list meanwhile is nobody's choice
        try:
            self._list.options = [("none", NO_ROOM), *((title, k) for k, title in names.items())]
            self._list.value = self.current
        finally:
            self._is_showing = False
        self._leave_button.disabled = self.current == NO_ROOM
        self._note.value = "" if self.current != NO_ROOM else "Click on a room to open it"

    def _title(self, room: int) -> str:
        state = "open" if room == self.current else "begun" if self.division.project(room).exists() else "new"
        return f"room {room + 1}, {self.division.n_faces[room]} faces, {state}"

    def _choose(self, change: dict[str, Any]) -> None:
        if not self._is_showing and change["new"] != self.current:
            self._go_to(change["new"])

    def _handle_message(self, _: Any, message: Any, __: Any) -> None:
        """A click in the picture of the whole."""
        if isinstance(message, dict) and message.get("kind") == "click":
            face = message.get("face")
            if isinstance(face, int) and 0 <= face < len(self.division.coarse_room):
                self._go_to(int(self.division.coarse_room[face]))

    def _go_to(self, room: int) -> None:
        try:
            if room == NO_ROOM:
                self.leave()
            else:
                self.edit(room)
        except (OSError, ValueError, RuntimeError) as error:
            self._show()
            self._note.value = html.escape(str(error))
