"""A mesh in a notebook cell: drawn, turned, pointed at and coloured in the browser.

`SceneView` takes a `Mesh` and, later, labels per face; it knows nothing of how labels are made. It can be
used alone (`SceneView(mesh)`) or inside a larger widget. Geometry crosses to the browser once; labels
cross as *atoms*, the common refinement of all levels and segments, so that an edit sends one small table.

State, synced both ways (observe or set any of them)
----------------------------------------------------
``color_by`` : "segments", "parts", "confidence", "errors", "values", "normals", "scan", "shaded"
    What a face's colour tells: its segment, its part at ``level``, how sure the segmentation is of it,
    whether its label is right (`set_errors`), the number of `set_values`, which way it faces, the scan's
    vertex colours, or nothing. Starts as the scan; the first `set_partition` switches it to segments.
``color_mix`` : 0 to 1
    1 = those colours alone, 0 = only the scan below them.
``level`` : name of a level
    Whose parts blink under the cursor, and are coloured by ``"parts"``.
``outlines`` : bool
    Dark lines between segments (between parts if parts are coloured).
``back_faces`` : bool
    Draw faces seen from behind; off lets one look into a room from outside.
``section`` : three pairs (low, high), each from 0 to 1
    What is drawn of the scan: parts of its extent along the walls, across them, and upwards. An end at 0 or 1
    cuts nothing; ``[(0, 1), (0, 1), (0, 0.8)]`` takes a room's ceiling off.
``segment_list`` : bool
    Whether the list of segments is open beside the picture.
``up`` : ``"auto"``, ``"x"``, ``"y"``, ``"z"``, ``"-x"``, ``"-y"``, ``"-z"``, or a vector
    Which way is up in the mesh. ``"auto"`` looks for the axis that floor and ceiling face, see
    `scenewidget.widget.upright.detect_up`, and takes z where the surface doesn't tell.
``theme`` : ``"auto"``, ``"light"``, ``"dark"``
    ``"auto"`` follows the host.
``mode`` : ``"navigate"``, ``"edit"``
    What a left drag does: orbit, or merge and split.
``editable`` : bool
    Whether the toolbar offers Look and Edit, Undo and Redo. Edits then show at once, and whoever sets it
    must `answer` the messages below.
``vocabulary`` : list of str
    Names to choose from when a segment is named.
``quick_names`` : list of str
    Names that the keys 4 to 9 and 0 give at once.
``history_shown`` : bool
    Whether the steps are listed; whoever sets ``editable`` then keeps the next two up to date.
``history`` : list of {"n": int, "title": str, "time": float, "problem": str}
    Steps, oldest first, undone ones last; ``n`` edits are done after it; why it doesn't apply.
``n_done`` : int
    How many edits are done.
``undo_title``, ``redo_title`` : str
    Name of the step that Undo and Redo would take; ``""`` = there is none.
``camera_group`` : str
    Views on a page with the same name here look the same way and point at the same place; ``""`` = none does.
``save_state`` : ``""``, ``"unsaved"``, ``"saving"``, ``"saved"``, ``"failed"``, ``"read-only"``
    How it stands with the edits' file, told beside Undo and Redo; ``""`` = nothing to save yet.
``save_note`` : str
    Which file, or what is wrong with it.
``notices`` : list of {"key": str, "text": str, "actions": [[label, action], ...]}
    Bars over the picture, each with its buttons; pressing one sends ``choose``, below.
``height`` : pixels
``busy`` : bool
    While True a slim progress bar, ``status`` and a Cancel button lie over the picture.
``progress`` : 0 to 1, or -1
    Length of the bar; -1 = unknown, the bar swings.
``status`` : str
    The stage while busy; a remark in the status line otherwise.
``error`` : str
    Shown as text in a panel that people can dismiss, which sets it to ``""``.

State that Python alone sets: ``levels`` (names), ``n_segments``, ``segment_names``, ``revision``, and
``suggestion``, an edit to be judged: what a `Suggestion` has, and its ``number``, which alone says that there
is none.

Methods
-------
``set_partition(levels, segments, names=None)``, ``set_segments(segments, names=None)``,
``clear_partition()``, ``set_values(values, ...)``, ``answer(message)``, ``fit()``, ``look_from_above()``,
``look_from_inside()``, ``reset()``, ``to_html(path)``, ``show_preview(items, labels)``, ``end_preview()``,
``set_family(family)``; ``segment_colors`` is the (n_segments, 3) uint8 table in use, for legends and lists.

Messages from the browser, received with ``view.on_msg(lambda view, message, buffers: ...)``
---------------------------------------------------------------------------------------------
``{"kind": "cancel"}``
    Cancel was pressed. The view goes on showing ``busy`` until Python sets it to False.

Only in ``mode="edit"``; faces are those of the mesh as given, ``level`` a name out of ``levels``,
``revision`` the number of the partition that the person was looking at (``view.revision``):

``{"kind": "merge", "face": 12, "onto_face": 40, "level": "final", "revision": 3}``
    ``face`` is a list where a brush has gathered several parts.
``{"kind": "split", "face": 12, "level": "final", "revision": 3}``
``{"kind": "cut", "face_a": 12, "face_b": 40, "revision": 3}``
    Divide the segment under both; shown only once `set_atoms` or `set_segments` brings it.
``{"kind": "relabel", "face": 12, "name": "chair", "revision": 3}``
``{"kind": "suggest", "do": "next", "number": 0}``
    Or "accept", "skip", "close": of the ``suggestion`` that has this number.
``{"kind": "undo"}``, ``{"kind": "redo"}``, ``{"kind": "go_to", "n": 5}``
    The last one: undo or redo until so many edits are done.

Not counted as edits, and possible in either mode:

``{"kind": "save"}``
    The Save button or Ctrl + S.
``{"kind": "choose", "notice": key, "action": action}``
    A button of a notice.
``{"kind": "preview_cut", "face_a": 12, "face_b": 40, "revision": 3, "request": "a1"}``
    What would a cut divide off? Only if ``editable``. To be answered by
    ``view.send({"kind": "cut_preview", "request": "a1", "first": 30}, [bits])``, a bit for each face from
    the first one on, the lowest bit of a byte first; without any, there is nothing to show.

If ``editable``, each also has ``client`` and ``number``: the browser shows the edit at once and goes on
doing so, on top of whatever segments come, until `answer` says that the message has been dealt with. So
``revision`` may be older than the view's: the person saw that one with their own later edits on top.
"""

from __future__ import annotations

import math
import os
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import anywidget
import numpy as np
import numpy.typing as npt
import traitlets
from scipy import sparse

from scenewidget.editing.files import checked_path, replacing
from scenewidget.engine.atoms import Atoms, common_refinement
from scenewidget.engine.family import Family
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh
from scenewidget.palette import (
    adjacent_segments,
    are_distinct,
    choose_colors,
    conflicts,
    inherited_colors,
    palette,
)
from scenewidget.widget.bundle import bundled
from scenewidget.widget.page import make_page
from scenewidget.widget.upright import AXES, checked_up, detect_up

__all__ = ["SceneView"]

SAVE_STATES = ("", "unsaved", "saving", "saved", "failed", "read-only")
WHOLE = [(0.0, 1.0)] * 3
LEAST_HEIGHT = 120
N_SPARE = 6  # colours for segments that the browser makes before Python knows of them
MAX_CLIENTS = 32  # pages that show a view at the same time
NOT_SAVED = {"face_item", "preview_segment", "preview_colors", "face_piece", "family_merges", "family_colors"}
OF_THE_SESSION = (  # state that a saved page has no use for, and that tells of its author's disk and work
    *("editable", "mode", "busy", "progress", "status", "error", "notices", "save_state", "save_note"),
    *("history_shown", "history", "n_done", "undo_title", "redo_title", "suggestion", "vocabulary"),
    *("quick_names", "camera_group"),
)
UNLABELLED = 0xFFFFFFFF  # -1 in the tables that cross to the browser


class SceneView(anywidget.AnyWidget):
    """Interactive picture of a mesh; see the module's docstring for its state and its messages.

    Parameters
    ----------
    mesh : Mesh
        What to draw; it can't be exchanged later.
    **options
        Initial values of the state, such as ``height=600`` or ``color_by="shaded"``.
    """

    _esm = traitlets.Unicode().tag(sync=True)
    _css = traitlets.Unicode().tag(sync=True)

    color_by = traitlets.Enum(
        ("segments", "parts", "confidence", "errors", "values", "normals", "scan", "shaded"), "shaded"
    ).tag(sync=True)
    color_mix = traitlets.Float(1.0, min=0.0, max=1.0).tag(sync=True)
    level = traitlets.Unicode().tag(sync=True)
    outlines = traitlets.Bool(True).tag(sync=True)
    back_faces = traitlets.Bool(False).tag(sync=True)
    section = traitlets.List(
        traitlets.Tuple(traitlets.Float(), traitlets.Float()), WHOLE, minlen=3, maxlen=3
    ).tag(sync=True)
    segment_list = traitlets.Bool(False).tag(sync=True)
    up = traitlets.Any("auto")
    theme = traitlets.Enum(("auto", "light", "dark"), "auto").tag(sync=True)
    mode = traitlets.Enum(("navigate", "edit"), "navigate").tag(sync=True)
    editable = traitlets.Bool(False).tag(sync=True)
    vocabulary = traitlets.List(traitlets.Unicode()).tag(sync=True)
    undo_title = traitlets.Unicode().tag(sync=True)
    redo_title = traitlets.Unicode().tag(sync=True)
    suggestion: Any = traitlets.Dict(read_only=True).tag(sync=True)
    errors_title = traitlets.Unicode(read_only=True).tag(sync=True)
    camera_group = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(560, min=LEAST_HEIGHT).tag(sync=True)
    busy = traitlets.Bool(False).tag(sync=True)
    progress = traitlets.Float(0.0, min=-1.0, max=1.0).tag(sync=True)
    status = traitlets.Unicode().tag(sync=True)
    error = traitlets.Unicode().tag(sync=True)
    save_state = traitlets.Enum(SAVE_STATES, "").tag(sync=True)
    save_note = traitlets.Unicode().tag(sync=True)
    notices = traitlets.List(traitlets.Dict()).tag(sync=True)
    quick_names = traitlets.List(traitlets.Unicode()).tag(sync=True)
    history_shown = traitlets.Bool(False).tag(sync=True)
    history = traitlets.List(traitlets.Dict()).tag(sync=True)
    n_done = traitlets.Int(0).tag(sync=True)

    levels = traitlets.List(traitlets.Unicode(), read_only=True).tag(sync=True)
    n_segments = traitlets.Int(0, read_only=True).tag(sync=True)
    revision = traitlets.Int(0, read_only=True).tag(sync=True)
    segment_names = traitlets.Dict(read_only=True).tag(sync=True)
    values_legend = traitlets.Dict(read_only=True).tag(sync=True)

    _up = traitlets.List(traitlets.Float(), [0.0, 0.0, 1.0]).tag(sync=True)  # unit vector
    _camera = traitlets.Dict().tag(sync=True)  # as it last stood still on any page
    _hidden = traitlets.List(traitlets.Int()).tag(sync=True)  # a face of each atom hidden last on any page
    _channel = traitlets.Unicode().tag(sync=True)  # on which controls speak to it
    _is_preview = traitlets.Bool(False).tag(sync=True)
    _token = traitlets.Unicode().tag(sync=True)  # tells models apart, for views of one on a page
    _answers = traitlets.Dict().tag(sync=True)  # number of the last message dealt with, by client

    # arrays; _headers says dtype and shape of each
    _headers = traitlets.Dict().tag(sync=True)
    _vertices = traitlets.Bytes().tag(sync=True)
    _faces = traitlets.Bytes().tag(sync=True)
    _vertex_colors = traitlets.Bytes().tag(sync=True)
    _face_atom = traitlets.Bytes().tag(sync=True)
    _atom_part = traitlets.Bytes().tag(sync=True)
    _atom_segment = traitlets.Bytes().tag(sync=True)
    _segment_colors = traitlets.Bytes().tag(sync=True)
    _segment_confidence = traitlets.Bytes().tag(sync=True)
    _atom_confidence = traitlets.Bytes().tag(sync=True)
    _face_value = traitlets.Bytes().tag(sync=True)
    _colormap = traitlets.Bytes().tag(sync=True)
    _face_error = traitlets.Bytes().tag(sync=True)
    _face_item = traitlets.Bytes().tag(sync=True)
    _preview_segment = traitlets.Bytes().tag(sync=True)
    _preview_colors = traitlets.Bytes().tag(sync=True)
    _face_piece = traitlets.Bytes().tag(sync=True)
    _family_merges = traitlets.Bytes().tag(sync=True)
    _family_colors = traitlets.Bytes().tag(sync=True)

    def __init__(self, mesh: Mesh, **options: Any) -> None:
        if not isinstance(mesh, Mesh):
            raise TypeError(f"mesh must be a Mesh, got {type(mesh).__name__}; load_mesh(mesh) makes one")
        unknown = sorted(set(options) - set(self.class_trait_names()))
        if unknown:
            raise TypeError(
                f"SceneView has no option {unknown[0]!r}; there are: {', '.join(_option_names())}"
            )
        height = options.get("height", 560)
        if isinstance(height, bool) or not isinstance(height, int):
            raise TypeError(f"height must be a whole number of pixels, got {height!r:.200}")
        if height < LEAST_HEIGHT:
            raise ValueError(f"height must be at least {LEAST_HEIGHT} pixels, got {height}")
        self.mesh = mesh
        self._atoms: Atoms | None = None
        self._atom_faces: FloatArray = np.zeros(0)  # number of faces of each atom
        self._touching = sparse.csr_array((0, 0), dtype=bool)  # atoms by atoms
        self._parts: dict[str, IntArray] = {}  # of each atom, by level
        self._table: IntArray = np.zeros(0, np.int64)  # segment of each atom
        self._color_rows: IntArray = np.zeros(0, np.int64)
        self._spare_rows: IntArray = np.zeros(0, np.int64)
        self._row_of_id: dict[int, int] = {}
        self._preview_items: Items | None = None
        options["up"] = up = checked_up(options.get("up", "auto"))
        arrays = _geometry(mesh)
        if mesh.vertex_colors is not None:
            options.setdefault("color_by", "scan")
        super().__init__(
            _esm=bundled("scene_view.js"),
            _css=bundled("scene_view.css"),
            _up=_up_vector(up, mesh),
            _token=secrets.token_hex(8),
            _headers={name: _header(array) for name, array in arrays.items()},
            **{f"_{name}": array.tobytes() for name, array in arrays.items()},
            **options,
        )

    @traitlets.validate("section")
    def _check_section(self, proposal: Any) -> Any:
        for low, high in proposal["value"]:
            if not 0.0 <= low < high <= 1.0:
                raise ValueError(f"section must hold pairs 0 <= low < high <= 1, got ({low:g}, {high:g})")
        return proposal["value"]

    @traitlets.validate("level")
    def _check_level(self, proposal: Any) -> Any:
        if self.levels and proposal["value"] not in self.levels:
            raise ValueError(
                f"level must be one of {', '.join(map(repr, self.levels))}, got {proposal['value']!r:.200}"
            )
        return proposal["value"]

    @traitlets.validate("up")
    def _check_up(self, proposal: Any) -> Any:
        return checked_up(proposal["value"])

    @traitlets.observe("up")
    def _take_up(self, change: Any) -> None:
        self._up = _up_vector(change["new"], self.mesh)

    def __repr__(self) -> str:
        segments = f", {self.n_segments} segments" if self._atoms is not None else ""
        return f"SceneView({self.mesh.n_faces} faces{segments})"

    def set_partition(
        self,
        levels: Mapping[str, IntArray],
        segments: IntArray,
        names: Mapping[int, str] | None = None,
        confidence: npt.ArrayLike | None = None,
        ids: IntArray | None = None,
    ) -> None:
        """Show segments and the recommendation levels that hovering goes through.

        Colours stay with the faces: a segment keeps the colour of the earlier segment that it overlaps most.

        Parameters
        ----------
        levels : mapping of name to (n_faces,) int
            Part of each face at each level; -1 where there is none. Pointing at the level "final" shows
            the segments as they are now, after edits.
        segments : (n_faces,) int
            Segment of each face; -1 = unlabelled, drawn grey.
        names : mapping of segment to str, optional
            Shown beside the number of a segment that is pointed at.
        confidence : (n_faces,) or (n_segments,) float, optional
            From 0 to 1. Of a segment it is told likewise, as the mean over its area if it is given by face.
        ids : (n_segments,) int, optional
            What stays of a segment when an edit numbers them anew: over the calls of `set_segments` that
            follow, the same id keeps its colour.
        """
        if not isinstance(levels, Mapping):
            raise TypeError(f"levels must map names to labels, got {type(levels).__name__}")
        checked = {name: self._checked(f"levels[{name!r}]", labels) for name, labels in levels.items()}
        segments = self._checked("segments", segments)
        atoms = common_refinement([*checked.values(), segments], self.mesh.n_faces)
        parts = {name: labels[atoms.first_face] for name, labels in checked.items()}
        table = segments[atoms.first_face]
        means, by_atom = self._confidence(atoms, table, confidence)
        self.set_atoms(atoms, parts, table, names, means, ids, atom_confidence=by_atom)

    def set_segments(
        self,
        segments: IntArray,
        names: Mapping[int, str] | None = None,
        confidence: npt.ArrayLike | None = None,
        ids: IntArray | None = None,
    ) -> None:
        """Show other segments over the same levels, as after an edit; sends one small table if it can.

        It can't if a segment cuts through an atom: then everything is sent as by `set_partition`.

        Parameters
        ----------
        segments : (n_faces,) int
        names, confidence, ids
            As of `set_partition`.
        """
        segments = self._checked("segments", segments)
        atoms, parts = self._atoms, self._parts
        table = None if atoms is None else atoms.table(segments)
        if atoms is None or table is None:
            levels = {name: self._per_face(table) for name, table in parts.items()}
            atoms = common_refinement([*levels.values(), segments], self.mesh.n_faces)
            parts = {name: labels[atoms.first_face] for name, labels in levels.items()}
            table = segments[atoms.first_face]
        means, by_atom = self._confidence(atoms, table, confidence)
        self.set_atoms(atoms, parts, table, names, means, ids, atom_confidence=by_atom, keeps_ids=True)

    def set_atoms(
        self,
        atoms: Atoms,
        parts: Mapping[str, IntArray],
        segments: IntArray,
        names: Mapping[int, str] | None = None,
        confidence: npt.ArrayLike | None = None,
        ids: IntArray | None = None,
        *,
        atom_confidence: FloatArray | None = None,
        keeps_ids: bool = False,
    ) -> None:
        """As `set_partition`, but with labels per atom; costs a few ms while the atoms stay the same object.

        Parameters
        ----------
        atoms : Atoms
        parts : mapping of name to (n_atoms,) int
            Part of each atom at each level.
        segments : (n_atoms,) int
        names, ids
            As in `set_partition`.
        confidence : (n_segments,) float, optional
        atom_confidence : (n_atoms,) float, optional
            To colour by; that of the segment by default.
        keeps_ids : bool
            Whether ids mean what they meant in the last call, so that the same id keeps its colour.
        """
        if names is not None and not isinstance(names, Mapping):
            raise TypeError(f"names must map segments to names, got {type(names).__name__}")
        segments = np.asarray(segments)
        n_rows = int(segments.max(initial=-1)) + 1
        sure = None if confidence is None else np.asarray(confidence, np.float64)
        if sure is not None and sure.shape != (n_rows,):
            raise ValueError(f"confidence must have shape ({n_rows},), one a segment, got {sure.shape}")
        if ids is not None and len(ids) != n_rows:
            raise ValueError(f"ids must have shape ({n_rows},), one a segment, got ({len(ids)},)")
        if not keeps_ids:
            self._row_of_id = {}
        with self.hold_sync():
            before = None if self._atoms is None else (self._atoms, self._table)
            if atoms is not self._atoms or list(parts) != self.levels:
                self._keep_hidden(atoms)
                self._atoms, self._parts = atoms, dict(parts)
                pairs = adjacent_segments(
                    self.mesh.faces, atoms.face_atom.astype(np.int64), self.mesh.n_vertices
                )
                ones, (i, j) = np.ones(2 * len(pairs), bool), np.concatenate([pairs, pairs[:, ::-1]]).T
                self._touching = sparse.csr_array((ones, (i, j)), shape=(atoms.n, atoms.n))
                self._atom_faces = np.bincount(atoms.face_atom, minlength=atoms.n).astype(np.float64)
                self.set_trait("levels", list(parts))
                self._put("face_atom", atoms.face_atom)
                rows = [_unlabelled_as_most(table) for table in parts.values()]
                self._put("atom_part", np.array(rows, np.uint32).reshape(len(rows), atoms.n))
                if self.level not in parts:
                    self.level = "final" if "final" in parts else next(reversed(list(parts)), "")
            self._show_segments(segments, before, names, sure, ids)
            self._put("atom_confidence", self._confidence_codes(sure, atom_confidence))
            if self.color_by in ("scan", "shaded") and self.revision == 1:
                self.color_by = "segments"

    def answer(self, message: Mapping[str, Any]) -> None:
        """Tell the browser that an edit's message has been dealt with, whether it changed anything or not.

        Best together with what it changed, inside one ``hold_sync()``.
        """
        client, number = message.get("client"), message.get("number")
        if isinstance(client, str) and isinstance(number, int):
            others = {name: last for name, last in self._answers.items() if name != client}
            for name in list(others)[: -(MAX_CLIENTS - 1)]:  # those that have been silent longest
                del others[name]
            self._answers = {**others, client: max(number, self._answers.get(client, 0))}

    def clear_partition(self) -> None:
        """Take segments and levels away; the scan itself stays."""
        self._atoms, self._parts = None, {}
        with self.hold_sync():
            for name in ("face_atom", "atom_part", "atom_segment", "segment_colors"):
                self._put(name, np.zeros(0, np.uint32))
            for name in ("segment_confidence", "atom_confidence"):
                self._put(name, np.zeros(0, np.float32))
            self.set_trait("levels", [])
            self.set_trait("n_segments", 0)
            self.set_trait("segment_names", {})
            self.set_trait("revision", self.revision + 1)

    @property
    def color_rows(self) -> IntArray:
        """(n,) row of the palette of each segment by its number."""
        return self._color_rows.copy()

    @property
    def segment_colors(self) -> npt.NDArray[np.uint8]:
        """(n, 3) uint8 colour of each segment by its number."""
        return palette()[self._color_rows]

    def set_values(
        self,
        values: npt.ArrayLike,
        *,
        title: str = "",
        colormap: str = "viridis",
        low: float | None = None,
        high: float | None = None,
    ) -> None:
        """Colour faces by a number each, with a legend, and switch ``color_by`` to it.

        Parameters
        ----------
        values : (n_faces,) float
            NaN is drawn grey.
        title : str
            What the number is, with its unit.
        colormap : str
            Name of a matplotlib colour map.
        low, high : float, optional
            Ends of the colour map; the smallest and the largest finite value by default.
        """
        try:
            numbers = np.asarray(values, np.float64)
        except (TypeError, ValueError):
            raise TypeError(f"values must be numbers, got {np.asarray(values).dtype}") from None
        if numbers.shape != (self.mesh.n_faces,):
            raise ValueError(
                f"values must have shape ({self.mesh.n_faces},), one a face, got {numbers.shape}"
            )
        finite = numbers[np.isfinite(numbers)]
        low = float(finite.min(initial=math.inf) if low is None else low) if len(finite) else 0.0
        high = float(finite.max(initial=-math.inf) if high is None else high) if len(finite) else 1.0
        if not -math.inf < low <= high < math.inf:
            raise ValueError(f"low must not be above high, and both finite, got {low:g} and {high:g}")
        scaled = np.clip((numbers - low) / ((high - low) or 1.0), 0.0, 1.0)
        with self.hold_sync():
            self._put("face_value", _codes(np.where(np.isfinite(numbers), scaled, np.nan)))
            self._put("colormap", _colormap_table(colormap))
            self.set_trait("values_legend", {"title": title, "low": low, "high": high})
            self.color_by = "values"

    def offer_errors(self, title: str) -> None:
        """Let ``color_by="errors"`` be chosen; whoever offers it calls `set_errors` once it is.

        Parameters
        ----------
        title : str
            Of the legend.
        """
        self.set_trait("errors_title", title)

    def set_errors(self, errors: npt.ArrayLike) -> None:
        """What ``color_by="errors"`` shows, (n_faces,): 0 unknown, 1 right, 2 wrong."""
        verdicts = np.asarray(errors)
        if verdicts.shape != (self.mesh.n_faces,) or verdicts.min() < 0 or verdicts.max() > 2:
            raise ValueError(f"errors must be 0, 1 or 2 for each of the {self.mesh.n_faces} faces")
        self._put("face_error", verdicts.astype(np.uint8))

    def show_preview(self, items: Items, item_labels: IntArray) -> None:
        """Show other segments for the moment; those of `set_partition` come back with `end_preview`.

        Nothing can be edited meanwhile. While the items stay the same object, a preview sends only a table of
        them. Colours go with the segments that are covered.

        Parameters
        ----------
        items : Items
        item_labels : (n_items,) int
        """
        with self.hold_sync():
            if items is not self._preview_items:
                self._preview_items = items
                self._put("face_item", _compact(items.face_map, items.n))
            colors = self._item_colors(items, item_labels)
            self._put("preview_segment", _unlabelled_as_most(np.append(item_labels, -1)))
            self._put("preview_colors", palette()[colors])
            self._is_preview = True

    def end_preview(self) -> None:
        """Show the segments again, also where a slider let go asks for a cut of the family."""
        self._is_preview = False
        self.send({"kind": "end_preview"})

    def set_family(self, family: Family | None) -> None:
        """Nested segmentations that a slider on the same channel may show as a preview; None takes them away.

        A segment of a coarser cut has the colour of the largest that it is made of, and those of the
        family's own segmentation have the colours that they are shown in now.
        """
        if family is not None and not isinstance(family, Family):
            raise TypeError(f"family must be a Family or None, got {type(family).__name__}")
        with self.hold_sync():
            if family is None:
                self._put("family_merges", np.zeros(0, np.uint32))
                return
            run, items = family.segmentation, family.segmentation.items
            if items is None or run.item_labels is None:
                raise ValueError("the family's segmentation must know its items")
            labels, has_piece = run.item_labels, family.piece >= 0
            home = np.full(family.most, -1)  # segment of each piece
            home[family.piece[has_piece]] = labels[has_piece]
            known = np.full(family.most, -1)
            stands = np.unique(family.groups(run.n_segments))
            known[stands] = self._item_colors(items, labels)[home[stands]]
            piece = np.append(family.piece, np.int32(-1))[items.face_map]
            shares = np.bincount(piece[piece >= 0], minlength=family.most) / self.mesh.n_faces
            colors = choose_colors(family.most, conflicts(family, items.pairs), shares, known)
            self._put("face_piece", _compact(piece, family.most))
            self._put("family_merges", family.merges.astype(np.uint32))
            self._put("family_colors", palette()[colors])

    def _item_colors(self, items: Items, item_labels: IntArray) -> IntArray:
        """A row of the palette for each segment over items, as near as can be to what is shown."""
        n = int(item_labels.max(initial=-1)) + 1
        labels = np.append(item_labels, -1)[items.face_map]
        shares = np.bincount(labels[labels >= 0], minlength=n) / self.mesh.n_faces
        ends = item_labels[items.pairs]
        ends = ends[(ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1)]
        known = None
        if self._atoms is not None:
            of_atoms = labels[self._atoms.first_face]
            known = inherited_colors(of_atoms, n, self._table, self._color_rows, self._atom_faces)
        return choose_colors(n, np.unique(ends, axis=0), shares, known)

    def fit(self) -> None:
        """Bring the whole scan into the picture, from where it is looked at now."""
        self.send({"kind": "look", "from": "here"})

    def look_from_above(self) -> None:
        """Look straight down, like a floor plan."""
        self.send({"kind": "look", "from": "above"})

    def look_from_inside(self) -> None:
        """Stand in the room, at eye height."""
        self.send({"kind": "look", "from": "inside"})

    def reset(self) -> None:
        """Go back to the first view."""
        self.send({"kind": "look", "from": "start"})

    def to_html(self, path: str | os.PathLike[str], *, title: str = "") -> Path:
        """Save what is shown as one file that a browser opens without Python and without a network.

        It opens at the last place of the camera. Turning, walking, pointing, colours, levels, the section and
        the list work in it, editing doesn't. It takes 0.25 MB and then 9 to 14 bytes a face, so about 10 MB
        for a million faces.

        Parameters
        ----------
        path : str or Path
            Is overwritten; ``.html`` is the usual ending.
        title : str
            Of the page; what ``repr`` says by default.

        Returns
        -------
        path : Path

        Raises
        ------
        OSError
            It can't be written; the file that was there is untouched.
        """
        path = checked_path(path)
        if not isinstance(title, str):
            raise TypeError(f"title must be a text, got {type(title).__name__}")
        arrays = {
            name: np.frombuffer(getattr(self, f"_{name}"), header["dtype"]).reshape(header["shape"])
            for name, header in self._headers.items()
            if name not in NOT_SAVED
        }
        state = {name: getattr(self, name) for name in self.traits(sync=True) if name in _own_names()}
        state |= {name: getattr(SceneView, name).default(self) for name in OF_THE_SESSION}
        state |= {"_camera": self._camera, "_up": self._up}
        page = make_page(
            state,
            arrays,
            bundle=bundled("scene_view.js"),
            style=bundled("scene_view.css"),
            title=title or repr(self),
        )
        with replacing(path) as temporary:
            temporary.write_text(page, encoding="utf-8")
        return path

    def _checked(self, name: str, labels: IntArray) -> IntArray:
        array = np.asarray(labels)
        if array.shape != (self.mesh.n_faces,):
            raise ValueError(
                f"{name} must have shape ({self.mesh.n_faces},), one label a face, got {array.shape}"
            )
        if array.dtype.kind not in "iu":
            raise TypeError(f"{name} must hold whole numbers, got dtype {array.dtype}")
        if array.min() < -1:
            raise ValueError(f"{name} must hold -1 (unlabelled) and up, got {array.min()}")
        if array.max() >= self.mesh.n_faces:
            raise ValueError(
                f"{name} must be below the number of faces, {self.mesh.n_faces}, got {array.max()}"
            )
        return array.astype(np.int32)

    def _keep_hidden(self, atoms: Atoms) -> None:
        """Let the faces that are hidden be so over other atoms too, as open pages do for themselves."""
        if self._atoms is None or not self._hidden:
            return
        old = self._atoms.face_atom
        is_hidden = np.zeros(self._atoms.n, bool)
        is_hidden[old[self._hidden]] = True
        self._hidden = atoms.first_face[is_hidden[old[atoms.first_face]]].tolist()

    def _show_segments(
        self,
        table: IntArray,
        before: tuple[Atoms, IntArray] | None,
        names: Mapping[int, str] | None,
        confidence: FloatArray | None,
        ids: IntArray | None,
    ) -> None:
        n_rows = int(table.max(initial=-1)) + 1
        sizes = np.bincount(table + 1, self._atom_faces, n_rows + 1)[1:]
        shares = sizes / self.mesh.n_faces
        known, lasting = np.full(n_rows, -1), ids if self._row_of_id else None
        if lasting is not None:
            known = np.array([self._row_of_id.get(i, -1) for i in lasting.tolist()], np.int64)
        elif before is not None:
            atoms, old = before
            known = inherited_colors(self._per_face(table), n_rows, old[atoms.face_atom], self._color_rows)
        pairs = self._segment_pairs(table, known < 0)
        if lasting is not None:
            self._take_spare_rows(known, lasting, pairs)
        self._color_rows = choose_colors(n_rows, pairs, shares, known)
        if ids is not None:
            self._row_of_id.update(zip(ids.tolist(), self._color_rows.tolist(), strict=True))
        spare = np.concatenate([self._color_rows, self._spare_rows, np.full(N_SPARE, -1)])[: n_rows + N_SPARE]
        no_pairs, all_shares = np.zeros((0, 2), np.int64), np.append(shares, np.zeros(N_SPARE))
        self._spare_rows = choose_colors(n_rows + N_SPARE, no_pairs, all_shares, spare)[n_rows:]
        self._table = table
        self._put("atom_segment", _unlabelled_as_most(table))
        self._put("segment_colors", palette()[np.concatenate([self._color_rows, self._spare_rows])])
        sure = np.zeros(0) if confidence is None else confidence
        self._put("segment_confidence", sure.astype(np.float32))
        self.set_trait("n_segments", int(np.count_nonzero(sizes)))
        self.set_trait("segment_names", {str(segment): str(name) for segment, name in (names or {}).items()})
        self.set_trait("revision", self.revision + 1)

    def _confidence(
        self, atoms: Atoms, table: IntArray, confidence: npt.ArrayLike | None
    ) -> tuple[FloatArray | None, FloatArray | None]:
        """Confidence by segment and by atom; the latter is None unless it is given by face."""
        if confidence is None:
            return None, None
        given, n = np.asarray(confidence, np.float64), int(table.max(initial=-1)) + 1
        n_faces = self.mesh.n_faces
        if given.shape not in ((n,), (n_faces,)):
            raise ValueError(
                f"confidence must have shape ({n_faces},), one a face, or ({n},), one a segment, "
                f"got {given.shape}"
            )
        if (given < 0).any() or (given > 1).any():
            raise ValueError(f"confidence must lie in 0..1, got {given.min():g} to {given.max():g}")
        if given.shape == (n,):
            return given, None
        areas, is_labelled = self.mesh.face_areas, table >= 0
        area = np.bincount(atoms.face_atom, areas, atoms.n)
        sure = np.bincount(atoms.face_atom, areas * given, atoms.n)
        by_atom = np.divide(sure, area, out=given[atoms.first_face], where=area > 0)
        whole = np.bincount(table[is_labelled], area[is_labelled], n)
        total = np.bincount(table[is_labelled], sure[is_labelled], n)
        return np.divide(total, whole, out=np.zeros(n), where=whole > 0), by_atom

    def _confidence_codes(
        self, confidence: FloatArray | None, by_atom: FloatArray | None
    ) -> npt.NDArray[np.uint16]:
        if by_atom is None and confidence is not None:
            by_segment = np.append(confidence, np.nan)
            by_atom = by_segment[self._table]  # -1, unlabelled, takes the last
        return _codes(np.zeros(0) if by_atom is None else by_atom)

    def _segment_pairs(self, table: IntArray, is_wanted: BoolArray) -> IntArray:
        """(n_pairs, 2) some segments, each with those that it touches, out of the atoms that do."""
        if not is_wanted.any():
            return np.zeros((0, 2), np.int64)
        atoms = np.flatnonzero(np.append(is_wanted, False)[table])
        around = self._touching[atoms]
        one, other = np.repeat(table[atoms], np.diff(around.indptr)), table[around.indices]
        is_border = (one != other) & (other >= 0)
        n = len(is_wanted)
        codes = np.unique(one[is_border].astype(np.int64) * n + other[is_border])
        return np.stack(np.divmod(codes, n), axis=1)

    def _per_face(self, table: IntArray) -> IntArray:
        """(n_faces,) labels out of labels per atom."""
        return table[self._atoms.face_atom] if self._atoms is not None else np.zeros(0, np.int64)

    def _take_spare_rows(self, rows: IntArray, ids: IntArray, pairs: IntArray) -> None:
        """Give new segments the colours that the browser has shown them in, where these can be told apart."""
        new = np.flatnonzero(rows < 0)
        for segment in new[np.argsort(ids[new])][: len(self._spare_rows)]:
            row, self._spare_rows = self._spare_rows[0], self._spare_rows[1:]
            around = rows[pairs[pairs[:, 0] == segment, 1]]
            rows[segment] = row if are_distinct(row, around[around >= 0]) else -1

    def _put(self, name: str, array: npt.NDArray[Any]) -> None:
        self._headers = {**self._headers, name: _header(array)}
        setattr(self, f"_{name}", array.tobytes())


def _compact(labels: IntArray, n: int) -> npt.NDArray[Any]:
    """(n_faces,) labels in as few bytes as they need, n for those without."""
    return np.where(labels >= 0, labels, n).astype(np.uint16 if n < 2**16 else np.uint32)


def _geometry(mesh: Mesh) -> dict[str, npt.NDArray[Any]]:
    """Arrays of the mesh as the browser takes them.

    Vertices are float32 around the middle of the faces: an origin far away, as in geographic coordinates,
    would eat the precision.
    """
    middle = (mesh.bounds[0] + mesh.bounds[1]) / 2
    vertices = np.where(mesh.is_used[:, None], mesh.vertices - middle, 0.0).astype(np.float32)
    arrays: dict[str, npt.NDArray[Any]] = {"vertices": vertices, "faces": mesh.faces.astype(np.uint32)}
    if mesh.vertex_colors is not None:
        arrays["vertex_colors"] = mesh.vertex_colors
    return arrays


def _unlabelled_as_most(labels: IntArray) -> npt.NDArray[np.uint32]:
    return labels.astype(np.uint32)  # -1 becomes UNLABELLED


def _codes(values: FloatArray) -> npt.NDArray[np.uint16]:
    """Numbers from 0 to 1 as 1 to 65535; NaN as 0."""
    codes: npt.NDArray[np.uint16] = np.where(np.isnan(values), 0, np.rint(1 + 65534 * values)).astype(
        np.uint16
    )
    return codes


def _up_vector(up: Any, mesh: Mesh) -> list[float]:
    vector = np.array(AXES[detect_up(mesh) if up == "auto" else up] if isinstance(up, str) else up)
    return [float(value) for value in vector / np.linalg.norm(vector)]


def _header(array: npt.NDArray[Any]) -> dict[str, Any]:
    return {"dtype": array.dtype.name, "shape": list(array.shape)}


def _colormap_table(name: str) -> npt.NDArray[np.uint8]:
    import matplotlib

    if name not in matplotlib.colormaps:
        raise ValueError(
            f"colormap must be the name of a matplotlib colour map such as 'viridis', got {name!r}"
        )
    return np.round(255 * matplotlib.colormaps[name](np.linspace(0, 1, 256))[:, :3]).astype(np.uint8)


def _own_names() -> list[str]:
    return sorted(name for name in SceneView.class_own_traits() if not name.startswith("_"))


def _option_names() -> list[str]:
    traits = SceneView.class_own_traits()
    return [name for name in _own_names() if not traits[name].read_only]
