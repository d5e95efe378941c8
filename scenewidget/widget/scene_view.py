"""A mesh in a notebook cell: drawn, turned, pointed at and coloured in the browser.

`SceneView` takes a `Mesh` and, later, labels per face; it knows nothing of how labels are made. It can be
used alone (`SceneView(mesh)`) or inside a larger widget. What it shares with the page is listed in
`scenewidget.widget.scene_state`; how arrays and messages cross to the browser stands in
`scenewidget.widget.wire`, how segments get their colours in `scenewidget.widget.segment_colors`.
"""

from __future__ import annotations

import math
import os
import secrets
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import traitlets

from scenewidget.editing.files import checked_path
from scenewidget.editing.formats.seal import write_files
from scenewidget.editing.snapshot import Snapshot
from scenewidget.engine.atoms import Atoms, common_refinement
from scenewidget.engine.boxes import oriented_boxes
from scenewidget.engine.family import Family
from scenewidget.engine.items import Items
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh, read_only
from scenewidget.engine.segmentation import Segmentation
from scenewidget.palette import colormap_table, palette
from scenewidget.widget.bundle import bundled
from scenewidget.widget.page import make_page
from scenewidget.widget.scene_state import LEAST_HEIGHT, SceneState, option_names, own_names
from scenewidget.widget.segment_colors import SegmentColors
from scenewidget.widget.upright import AXES, checked_up, told_up
from scenewidget.widget.wire import (
    compact,
    geometry,
    header,
    middle_of,
    unit_codes,
    unlabeled_as_most,
    unpacked,
)

__all__ = ["SceneView"]

MAX_CLIENTS = 32  # at most so many pages show a view at the same time
NOT_SAVED = {"face_item", "preview_segment", "preview_colors", "face_piece", "family_merges", "family_colors"}
OF_THE_SESSION = (  # state that a saved page has no use for, and that tells of its author's disk and work
    *("editable", "mode", "busy", "progress", "status", "error", "notices", "save_state", "save_note"),
    *("history_shown", "history", "n_done", "undo_title", "redo_title", "suggestion", "vocabulary"),
    *("quick_names", "camera_group"),
)


class SceneView(SceneState):
    """Interactive picture of a mesh.

    Its state is synced with the browser both ways: set any trait of `SceneState`, or observe it.

    Parameters
    ----------
    mesh : Mesh
        What to draw; it can't be exchanged later.
    **options
        Initial values of the state, such as ``height=600`` or ``color_by="shaded"``.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> view = sw.SceneView(analytic.square(2), height=400)
    >>> view.set_segments([0, 0, 0, 0, 1, 1, 1, 1])
    >>> view.color_by, view.n_segments
    ('segments', 2)
    >>> view.close()
    """

    _is_up_told = True
    _set_once = ("mesh",)

    def __init__(self, mesh: Mesh, **options: Any) -> None:
        if not isinstance(mesh, Mesh):
            raise TypeError(f"mesh must be a Mesh, got {type(mesh).__name__}; load_mesh(mesh) makes one")
        unknown = sorted(set(options) - set(self.class_trait_names()))
        if unknown:
            raise TypeError(f"SceneView has no option {unknown[0]!r}; there are: {', '.join(option_names())}")
        check_height(options.get("height", 560))
        self.mesh = mesh
        self._colors = SegmentColors(mesh)
        self._parts: dict[str, IntArray] = {}  # of each atom, by level
        self._preview_items: Items | None = None
        options["up"] = checked_up(options.get("up", "auto"))  # which is heard, and `_up` follows
        arrays = geometry(mesh)
        sent = {} if options.get("_mesh_of") else arrays
        if mesh.vertex_colors is not None:
            options.setdefault("color_by", "scan")
        super().__init__(
            _esm=bundled("scene_view.js"),
            _css=bundled("scene_view.css"),
            _token=secrets.token_hex(8),
            _headers={name: header(array) for name, array in arrays.items()},
            **{f"_{name}": array.tobytes() for name, array in sent.items()},
            **options,
        )

        self.on_msg(self._hear_of_up)
        self.on_msg(self._hear_of_mesh)

    def twin(self, **options: Any) -> SceneView:
        """Another view of the same mesh, which takes its arrays from this one where both are on a page.

        Parameters
        ----------
        **options
            Initial values of its state.

        Examples
        --------
        >>> import scenewidget as sw
        >>> from scenewidget.datasets import analytic
        >>> view = sw.SceneView(analytic.square(2))
        >>> twin = view.twin(color_by="normals")
        >>> twin.mesh is view.mesh, len(view._faces), len(twin._faces)
        (True, 96, 0)
        """
        return SceneView(self.mesh, _mesh_of=self._token, **options)

    def _hear_of_mesh(self, view: Any, message: Any, buffers: Any) -> None:
        """A page without the view whose mesh this one draws asks for the arrays."""
        if self._mesh_of and isinstance(message, dict) and message.get("kind") == "need_mesh":
            with self.hold_sync():
                self._mesh_of = ""
                for name, array in geometry(self.mesh).items():
                    self._put(name, array)

    def ask_up(self) -> None:
        """Let a bar over the picture ask which way is up, where neither the surface nor anybody told."""
        self._asks_up = not self._is_up_told

    def _hear_of_up(self, view: Any, message: Any, buffers: Any) -> None:
        """An axis turns the picture, and the bar stays until the picture is said to be right."""
        if not isinstance(message, dict) or (message.get("kind"), message.get("notice")) != ("choose", "up"):
            return
        action = message.get("action")
        if isinstance(action, str) and action in AXES:
            self.up = action
            self._asks_up = True
        elif action == "drop":
            self._asks_up = False

    @traitlets.observe("boxes", "revision", "_up")
    def _measure_boxes(self, _: Any) -> None:
        """Boxes of the segments as they are, while they are to be seen."""
        atoms = self._colors.atoms
        if not self.boxes or atoms is None or not self.n_segments:
            return
        labels = self._colors.table[atoms.face_atom]
        found = oriented_boxes(self.mesh, labels, int(labels.max()) + 1, np.array(self._up))
        halves = found.axes * (found.size / 2)[:, :, None]
        rows = np.column_stack([found.center - middle_of(self.mesh), halves.reshape(-1, 9)])
        self._put("segment_box", rows.astype(np.float32))

    @traitlets.observe("up")
    def _take_up(self, change: Any) -> None:
        told = told_up(change["new"], self.mesh)
        self._is_up_told, self._asks_up = told is not None, False
        self._up = list(told or AXES["z"])

    def __repr__(self) -> str:
        segments = f", {self.n_segments} segments" if self._colors.atoms is not None else ""
        return f"SceneView({self.mesh.n_faces} {self.mesh.noun}s{segments})"

    # --- segments ---------------------------------------------------------------------------------

    def set_segments(
        self,
        segments: IntArray | Segmentation,
        *,
        levels: Mapping[str, IntArray] | None = None,
        names: Mapping[int, str] | None = None,
        confidence: npt.ArrayLike | None = None,
        ids: IntArray | None = None,
    ) -> None:
        """Show segments, and the recommendation levels that hovering goes through.

        Colours stay with the faces: a segment keeps the colour of the earlier segment that it overlaps most.
        Over the same levels only one small table is sent, unless a segment cuts through an atom.

        Parameters
        ----------
        segments : (n_faces,) int or Segmentation
            Segment of each face; -1 = unlabeled, drawn grey. A segmentation brings its names.
        levels : mapping of name to (n_faces,) int, optional
            Part of each face at each level; -1 where there is none. Pointing at the level "final" shows
            the segments as they are now, after edits. By default the levels stay as they are.
        names : mapping of segment to str, optional
            Shown beside the number of a segment that is pointed at.
        confidence : (n_faces,) or (n_segments,) float, optional
            From 0 to 1. Of a segment it is told likewise, as the mean over its area if it is given by face.
        ids : (n_segments,) int, optional
            What stays of a segment when an edit numbers them anew: as long as no other ``levels`` are given,
            the same id keeps its colour.

        Examples
        --------
        >>> import scenewidget as sw
        >>> from scenewidget.datasets import analytic
        >>> view = sw.SceneView(analytic.square(2))  # 8 triangles
        >>> halves = [0, 0, 0, 0, 1, 1, 1, 1]
        >>> view.set_segments(halves, levels={"halves": halves}, names={0: "floor"})
        >>> view.set_segments([0] * 8)  # an edit
        >>> view.levels, view.n_segments, view.revision
        (['halves'], 1, 2)
        >>> view.close()
        """
        if levels is not None and not isinstance(levels, Mapping):
            raise TypeError(f"levels must map names to labels, got {type(levels).__name__}")
        if isinstance(segments, Segmentation):
            known = {segment: name for segment, name in enumerate(segments.names) if name}
            segments, names = segments.labels, known if names is None else names
        atoms, parts = self._colors.atoms, self._parts
        if levels is not None:
            columns = {name: self._checked(f"levels[{name!r}]", part) for name, part in levels.items()}
        segments = self._checked("segments", segments)
        table = None if atoms is None or levels is not None else atoms.table(segments)
        if atoms is None or table is None:
            if levels is None:
                columns = {name: self._per_face(part) for name, part in parts.items()}
            atoms = common_refinement([*columns.values(), segments], self.mesh.n_faces)
            parts = {name: labels[atoms.first_face] for name, labels in columns.items()}
            table = segments[atoms.first_face]
        means, by_atom = self._confidence(atoms, table, confidence)
        self._show_tables(
            atoms, parts, table, names=names, confidence=means, atom_confidence=by_atom, ids=ids,
            keeps_ids=levels is None,
        )  # fmt: skip

    def show_snapshot(self, snapshot: Snapshot, *, keeps_ids: bool = False) -> None:
        """Show a session at one moment; costs a few ms while its atoms stay the same object.

        Parameters
        ----------
        snapshot : Snapshot
            Of `Session.snapshot`.
        keeps_ids : bool
            Whether ids mean what they meant in the last call, so that the same id keeps its colour.

        Examples
        --------
        >>> import scenewidget as sw
        >>> from scenewidget.datasets import analytic
        >>> mesh = analytic.square(2)  # 8 triangles
        >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
        >>> session, view = sw.Session(mesh, seg), sw.SceneView(mesh)
        >>> view.show_snapshot(session.snapshot())
        >>> view.n_segments
        2
        >>> view.close()
        """
        self._show_tables(
            snapshot.atoms,
            snapshot.parts,
            snapshot.labels,
            names={segment: name for segment, name in enumerate(snapshot.names) if name},
            groups={segment: whole for segment, whole in enumerate(snapshot.groups) if whole != segment},
            confidence=snapshot.confidence,
            atom_confidence=snapshot.atom_confidence,
            ids=snapshot.ids,
            keeps_ids=keeps_ids,
        )

    def _show_tables(
        self,
        atoms: Atoms,
        parts: Mapping[str, IntArray],
        table: IntArray,
        *,
        names: Mapping[int, str] | None,
        confidence: FloatArray | None,
        atom_confidence: FloatArray | None,
        ids: IntArray | None,
        keeps_ids: bool,
        groups: Mapping[int, int] | None = None,
    ) -> None:
        """Send what `set_segments` and `show_snapshot` have brought to tables over atoms."""
        if names is not None and not isinstance(names, Mapping):
            raise TypeError(f"names must map segments to names, got {type(names).__name__}")
        n = int(table.max(initial=-1)) + 1
        if ids is not None and len(ids) != n:
            raise ValueError(f"ids must have shape ({n},), one a segment, got ({len(ids)},)")
        with self.hold_sync():
            if atoms is not self._colors.atoms or list(parts) != self.levels:
                self._keep_hidden(atoms)
                self._put_levels(atoms, parts)
            self._colors.update(atoms, table, ids=ids, keeps_ids=keeps_ids)
            self._put("atom_segment", unlabeled_as_most(table))
            self._put("segment_colors", self._colors.table_sent)
            sure = np.zeros(0) if confidence is None else confidence
            self._put("segment_confidence", sure.astype(np.float32))
            if atom_confidence is None and confidence is not None:
                atom_confidence = np.append(confidence, np.nan)[table]  # -1, unlabeled, takes the last
            by_atom = np.zeros(0) if atom_confidence is None else atom_confidence
            self._put("atom_confidence", unit_codes(by_atom))
            self.set_trait("n_segments", int(np.count_nonzero(self._colors.sizes)))
            self.set_trait("segment_names", {str(i): str(name) for i, name in (names or {}).items()})
            self.set_trait("segment_groups", {str(i): whole for i, whole in (groups or {}).items()})
            self.set_trait("revision", self.revision + 1)
            if self.color_by in ("scan", "shaded") and self.revision == 1:
                self.color_by = "segments"

    def _per_face(self, table: IntArray) -> IntArray:
        """(n_faces,) labels out of labels per atom."""
        atoms = self._colors.atoms
        return table[atoms.face_atom] if atoms is not None else np.zeros(0, np.int64)

    def _put_levels(self, atoms: Atoms, parts: Mapping[str, IntArray]) -> None:
        self._parts = dict(parts)
        self.set_trait("levels", list(parts))
        self._put("face_atom", atoms.face_atom)
        rows = [unlabeled_as_most(part) for part in parts.values()]
        self._put("atom_part", np.array(rows, np.uint32).reshape(len(rows), atoms.n))
        if self.level not in parts:
            self.level = "final" if "final" in parts else next(reversed(list(parts)), "")

    def clear_segments(self) -> None:
        """Take segments and levels away; the scan itself stays."""
        self._colors.forget_atoms()
        self._parts = {}
        with self.hold_sync():
            for name in ("face_atom", "atom_part", "atom_segment", "segment_colors"):
                self._put(name, np.zeros(0, np.uint32))
            for name in ("segment_confidence", "atom_confidence"):
                self._put(name, np.zeros(0, np.float32))
            self.set_trait("levels", [])
            self.set_trait("n_segments", 0)
            self.set_trait("segment_names", {})
            self.set_trait("segment_groups", {})
            self.set_trait("revision", self.revision + 1)

    # --- edits ------------------------------------------------------------------------------------

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

    @property
    def color_rows(self) -> IntArray:
        """(n,) row of the palette of each segment by its number; read-only."""
        return read_only(self._colors.rows.copy())

    @property
    def segment_colors(self) -> npt.NDArray[np.uint8]:
        """(n, 3) uint8 colour of each segment by its number; read-only: a view chooses them."""
        return read_only(palette()[self._colors.rows])

    def set_values(
        self,
        values: npt.ArrayLike,
        *,
        title: str = "",
        colormap: str = "viridis",
        low: float | None = None,
        high: float | None = None,
        column: str = "",
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
        column : str
            The one of ``columns`` that these are the values of.
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
            self._put("face_value", unit_codes(np.where(np.isfinite(numbers), scaled, np.nan)))
            self._put("colormap", colormap_table(colormap))
            self.set_trait("values_legend", {"title": title, "low": low, "high": high})
            self.color_by = "values"
            self.column = column

    def offer_columns(self, names: Sequence[str]) -> None:
        """Let a column of the table of segments be chosen as colour; whoever offers it observes ``column``.

        Parameters
        ----------
        names : list of str
        """
        self.set_trait("columns", list(names))

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

    def set_borders(self, doubtful: npt.ArrayLike) -> None:
        """What ``color_by="borders"`` draws along borders: how likely each runs through one thing.

        Parameters
        ----------
        doubtful : (n_faces,) float
            0 to 1; NaN away from borders, drawn grey.
        """
        values = np.asarray(doubtful, np.float64)
        if values.shape != (self.mesh.n_faces,):
            raise ValueError(
                f"doubtful must have shape ({self.mesh.n_faces},), one a face, got {values.shape}"
            )
        with self.hold_sync():
            self._put("face_border", unit_codes(values))
            self.set_trait("offers_borders", True)

    def show_preview(self, items: Items, item_labels: IntArray) -> None:
        """Show other segments for the moment; those of `set_segments` come back with `end_preview`.

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
                self._put("face_item", compact(items.face_map, items.n))
            self._put("preview_segment", unlabeled_as_most(np.append(item_labels, -1)))
            self._put("preview_colors", palette()[self._colors.of_items(items, item_labels)])
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
            items = family.segmentation.items
            if items is None:
                raise ValueError("the family's segmentation must know its items")
            piece = items.to_faces(family.piece, -1)
            colors = self._colors.of_family(family, piece)
            self._put("face_piece", compact(piece, family.most))
            self._put("family_merges", family.merges.astype(np.uint32))
            self._put("family_colors", palette()[colors])

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

    def to_html(self, path: str | os.PathLike[str], *, title: str = "", overwrite: bool = False) -> Path:
        """Save what is shown as one file that a browser opens without Python and without a network.

        It opens at the last place of the camera. Turning, walking, pointing, colours, levels, the section and
        the list work in it, editing doesn't. It takes 0.25 MB and then 9 to 14 bytes a face, so about 10 MB
        for a million faces.

        Parameters
        ----------
        path : str or Path
            Ends in ``.html`` or ``.htm``, or has no ending.
        title : str
            Of the page; what ``repr`` says by default.
        overwrite : bool
            A page that was written so is replaced; any other file only with True.

        Returns
        -------
        path : Path

        Raises
        ------
        ValueError
            The name is that of another kind of file.
        FileExistsError
            Another file is there.
        OSError
            It can't be written; the file that was there is untouched.
        """
        path = checked_path(path)
        if path.suffix.lower() not in ("", ".html", ".htm"):
            raise ValueError(
                f"{path.name!r} is no name for a page, which to_html writes: to_html('{path.stem}.html'); "
                "the picture's button with the camera saves a PNG"
            )
        if not isinstance(title, str):
            raise TypeError(f"title must be a text, got {type(title).__name__}")
        own = geometry(self.mesh)
        arrays = own | {
            name: unpacked(getattr(self, f"_{name}"), header)
            for name, header in self._headers.items()
            if name not in own and name not in NOT_SAVED
        }
        state = {name: getattr(self, name) for name in self.traits(sync=True) if name in own_names()}
        state |= {name: getattr(SceneView, name).default(self) for name in OF_THE_SESSION}
        state |= {"_camera": self._camera, "_up": self._up}
        page = make_page(
            state,
            arrays,
            bundle=bundled("scene_view.js"),
            style=bundled("scene_view.css"),
            title=title or repr(self),
        )
        write_files({path: [page.encode()]}, asked=path, overwrite=overwrite, inputs=[self.mesh.source])
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
            raise ValueError(f"{name} must hold -1 (unlabeled) and up, got {array.min()}")
        if array.max() >= self.mesh.n_faces:
            raise ValueError(
                f"{name} must be below the number of faces, {self.mesh.n_faces}, got {array.max()}"
            )
        return array.astype(np.int32)

    def _keep_hidden(self, atoms: Atoms) -> None:
        """Let the faces that are hidden be so over other atoms too, as open pages do for themselves."""
        if self._colors.atoms is None or not self._hidden:
            return
        old = self._colors.atoms
        is_hidden = np.zeros(old.n, bool)
        is_hidden[old.face_atom[self._hidden]] = True
        self._hidden = atoms.first_face[is_hidden[old.face_atom[atoms.first_face]]].tolist()

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
        areas, is_labeled = self.mesh.face_areas, table >= 0
        area = np.bincount(atoms.face_atom, areas, atoms.n)
        sure = np.bincount(atoms.face_atom, areas * given, atoms.n)
        by_atom = np.divide(sure, area, out=given[atoms.first_face], where=area > 0)
        whole = np.bincount(table[is_labeled], area[is_labeled], n)
        total = np.bincount(table[is_labeled], sure[is_labeled], n)
        return np.divide(total, whole, out=np.zeros(n), where=whole > 0), by_atom

    def _put(self, name: str, array: npt.NDArray[Any]) -> None:
        self._headers = {**self._headers, name: header(array)}
        setattr(self, f"_{name}", array.tobytes())


def check_height(height: object) -> None:
    """TypeError or ValueError if a picture can't be so high.

    Examples
    --------
    >>> check_height(100)
    Traceback (most recent call last):
        ...
    ValueError: height must be at least 120 pixels, got 100
    """
    if isinstance(height, bool) or not isinstance(height, int):
        raise TypeError(f"height must be a whole number of pixels, got {height!r:.200}")
    if height < LEAST_HEIGHT:
        raise ValueError(f"height must be at least {LEAST_HEIGHT} pixels, got {height}")
