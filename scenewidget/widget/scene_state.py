"""What Python and the page share about a picture: one trait for each thing, with what it may be set to.

`SceneState` is the list to read first: above what people set or observe, below what only the front end
reads. It does nothing by itself; `scenewidget.widget.scene_view` fills it.
"""

from __future__ import annotations

from typing import Any

import anywidget
import traitlets

from scenewidget.engine.checks import FixedDict, FixedList, KnownNames, did_you_mean
from scenewidget.widget.arranged import Arranged
from scenewidget.widget.observing import FaultTolerant
from scenewidget.widget.upright import checked_up

__all__ = ["LEAST_HEIGHT", "LIKE", "SceneState", "option_names", "own_names"]

SAVE_STATES = ("", "unsaved", "saving", "saved", "failed", "read-only")
WHOLE = [(0.0, 1.0)] * 3
LEAST_HEIGHT = 120
LIKE = 0.75  # of two names, that one is probably the other
INSTEAD = {  # of state that other viewers have
    ("background", "background_color", "bg_color"): "the theme chooses it: write theme = 'light' or 'dark'",
    ("camera", "camera_position", "view", "eye", "target"): "call fit(), look_from_above(), "
    "look_from_inside() or reset()",
    ("width",): "write layout.width = '600px'",
    ("colors", "labels", "segments"): "call set_segments(labels)",
    ("values", "scalars"): "call set_values(values)",
    ("wireframe", "opacity", "alpha", "lights"): "the picture has none; color_mix and outlines change it",
    ("mesh",): "another scan needs another view: SceneView(mesh)",
}
ASKED = {  # methods that other viewers have
    ("set_camera", "reset_camera", "look_at", "home"): "call fit(), look_from_above(), "
    "look_from_inside() or reset()",
    ("show_segments", "set_labels", "color_faces"): "call set_segments(labels)",
    ("set_colors", "set_scalars", "color_by_values"): "call set_values(values)",
    (
        "show",
        "display",
        "render",
        "update",
        "draw",
        "refresh",
    ): "it draws by itself, as the last value of a cell",
    ("add", "add_mesh", "add_points", "load"): "a view shows one scan: make another, SceneView(mesh)",
    ("clear", "remove", "reset_segments"): "call clear_segments()",
    (
        "screenshot",
        "save",
        "savefig",
        "save_png",
        "to_png",
        "to_image",
        "snapshot",
        "export",
    ): "the picture's button with the camera saves a PNG, to_html(path) a page",
}


class Whole(traitlets.List[Any]):
    """A trait that holds a list to be exchanged as a whole.

    Examples
    --------
    >>> state = SceneState()
    >>> state.section[2] = (0, 0.8)
    Traceback (most recent call last):
    TypeError: a change inside of this list isn't noticed; set the whole: view.section = [...]
    """

    klass = FixedList
    _cast_types = (list, tuple)

    def validate_elements(self, obj: Any, value: Any) -> Any:
        """As of any list, and says how to change it."""
        checked = super().validate_elements(obj, value)
        checked._instead = self._instead
        return checked

    @property
    def _instead(self) -> str:
        return f"; set the whole: view.{self.name} = [...]"


class ToldList(Whole):
    """A trait that holds a list that people read only.

    Parameters
    ----------
    trait : traitlets.TraitType
        Of its members.
    instead : str
        What to write where somebody changes it.

    Examples
    --------
    >>> SceneState().levels.append("mine")
    Traceback (most recent call last):
    TypeError: a change inside of this list isn't noticed; write view.set_segments(labels, levels={...})
    """

    def __init__(self, trait: Any, instead: str) -> None:
        super().__init__(trait, read_only=True)
        self._told = instead

    @property
    def _instead(self) -> str:
        return f"; {self._told}"


class Told(traitlets.Dict):
    """A trait that holds a table that people read only.

    Parameters
    ----------
    instead : str
        What to write where somebody changes it.

    Examples
    --------
    >>> SceneState().segment_groups[0] = 1
    Traceback (most recent call last):
    TypeError: a change inside of this table isn't noticed; write session.group(faces, onto_face)
    """

    def __init__(self, instead: str) -> None:
        super().__init__(read_only=True)
        self._instead = f"; {instead}"

    def validate(self, obj: Any, value: Any) -> Any:
        """As of any table, and says how to change it."""
        return FixedDict(super().validate(obj, value) or {}, instead=self._instead)


class SceneState(KnownNames, FaultTolerant, Arranged, anywidget.AnyWidget):
    """State of a picture, synced with the browser both ways.

    Examples
    --------
    >>> state = SceneState(color_by="normals")
    >>> state.section = [(0, 1), (0, 1), (0, 0.8)]  # takes the ceiling off
    >>> state.close()
    """

    _esm = traitlets.Unicode().tag(sync=True)
    _css = traitlets.Unicode().tag(sync=True)

    # --- what is shown ----------------------------------------------------------------------------

    color_by = traitlets.Enum(
        ("segments", "parts", "confidence", "borders", "errors", "values", "normals", "scan", "shaded"),
        "shaded",
    ).tag(sync=True)
    """What a face's colour tells.

    Its segment, its part at ``level``, how sure the segmentation is of it, whether its label is right
    (`set_errors`), the number of `set_values`, which way it faces, the scan's vertex colours, or nothing.
    Starts as the scan; the first `set_segments` switches it to segments.
    """

    color_mix = traitlets.Float(1.0, min=0.0, max=1.0).tag(sync=True)
    """1 = those colours alone, 0 = only the scan below them."""

    level = traitlets.Unicode().tag(sync=True)
    """The level whose parts blink under the cursor, and are coloured by ``color_by="parts"``."""

    outlines = traitlets.Bool(True).tag(sync=True)
    """Whether dark lines part segments (or parts, if parts are coloured)."""

    back_faces = traitlets.Bool(False).tag(sync=True)
    """Whether faces seen from behind are drawn; off lets one look into a room from outside."""

    section = Whole(traitlets.Tuple(traitlets.Float(), traitlets.Float()), WHOLE, minlen=3, maxlen=3).tag(
        sync=True
    )
    """What is drawn of the scan: three pairs (low, high), each from 0 to 1.

    Parts of its extent along the walls, across them, and upwards. An end at 0 or 1 cuts nothing;
    ``[(0, 1), (0, 1), (0, 0.8)]`` takes a room's ceiling off.
    """

    boxes = traitlets.Bool(False).tag(sync=True)
    """Whether the upright box around each segment is drawn, see `Segmentation.boxes`."""

    column = traitlets.Unicode().tag(sync=True)
    """The column of the table of segments that colours them, one of ``columns``; "" = none."""

    segment_list = traitlets.Bool(False).tag(sync=True)
    """Whether the list of segments is open beside the picture."""

    up = traitlets.Any("auto")
    """Which way is up in the mesh: ``"auto"``, ``"x"``, ``"-y"`` … or a vector.

    ``"auto"`` looks for the direction against gravity, see `scenewidget.engine.orientation.up_direction`, and
    takes z where the surface doesn't tell.
    """

    theme = traitlets.Enum(("auto", "light", "dark"), "auto").tag(sync=True)
    """``"auto"`` follows the host."""

    height = traitlets.Int(560, min=LEAST_HEIGHT).tag(sync=True)
    """Of the picture, in pixels."""

    camera_group = traitlets.Unicode().tag(sync=True)
    """Views on a page with the same name here look the same way and point at the same place; "" = none."""

    # --- editing ----------------------------------------------------------------------------------

    mode = traitlets.Enum(("navigate", "edit"), "navigate").tag(sync=True)
    """What a left drag does: orbit, or merge and split."""

    editable = traitlets.Bool(False).tag(sync=True)
    """Whether the toolbar offers Look and Edit, Undo and Redo.

    Edits then show at once, and whoever sets it must `answer` their messages.
    """

    vocabulary = Whole(traitlets.Unicode()).tag(sync=True)
    """Names to choose from when a segment is named."""

    quick_names = Whole(traitlets.Unicode()).tag(sync=True)
    """Names that the keys 4 to 9 and 0 give at once."""

    undo_title = traitlets.Unicode().tag(sync=True)
    """Name of the step that Undo would take back; "" = there is none."""

    redo_title = traitlets.Unicode().tag(sync=True)
    """Name of the step that Redo would do again; "" = there is none."""

    history_shown = traitlets.Bool(False).tag(sync=True)
    """Whether the steps are listed; whoever sets ``editable`` then keeps the next two up to date."""

    history = Whole(traitlets.Dict()).tag(sync=True)
    """Steps, oldest first, undone ones last.

    Each is ``{"n": int, "title": str, "time": float, "problem": str}``: so many edits are done after it, and
    why it doesn't apply.
    """

    n_done = traitlets.Int(0).tag(sync=True)
    """How many edits are done."""

    suggestion: Any = Told("session.suggestions() finds them").tag(sync=True)
    """An edit to be judged: what a `Suggestion` has, and its ``number``; the number alone = there is none."""

    save_state = traitlets.Enum(SAVE_STATES, "").tag(sync=True)
    """How it stands with the edits' file, told beside Undo and Redo; "" = nothing to save yet."""

    save_note = traitlets.Unicode().tag(sync=True)
    """Which file, or what is wrong with it."""

    # --- what is going on -------------------------------------------------------------------------

    busy = traitlets.Bool(False).tag(sync=True)
    """While True, a slim progress bar, ``status`` and a Cancel button lie over the picture."""

    progress = traitlets.Float(0.0, min=-1.0, max=1.0).tag(sync=True)
    """Length of the bar, from 0 to 1; -1 = unknown, the bar swings."""

    status = traitlets.Unicode().tag(sync=True)
    """The stage while busy; a remark in the status line otherwise."""

    error = traitlets.Unicode().tag(sync=True)
    """Shown as text in a panel that people can dismiss, which sets it to ""."""

    notices = Whole(traitlets.Dict()).tag(sync=True)
    """Bars over the picture, each with its buttons; pressing one sends the message ``choose``.

    Each is ``{"key": str, "text": str, "actions": [[label, action], ...]}``.
    """

    # --- told by Python alone ---------------------------------------------------------------------

    levels = ToldList(traitlets.Unicode(), "write view.set_segments(labels, levels={...})").tag(sync=True)
    """Names of the levels whose parts can be pointed at."""

    n_segments = traitlets.Int(0, read_only=True).tag(sync=True)
    """Number of segments that have faces."""

    segment_names = Told("write session.relabel(face, name), or set_segments(labels, names={...})").tag(
        sync=True
    )
    """Names by the number of the segment, as text."""

    segment_groups = Told("write session.group(faces, onto_face)").tag(sync=True)
    """What a segment is a part of, by its number as text; those of nothing are left out."""

    revision = traitlets.Int(0, read_only=True).tag(sync=True)
    """Grows whenever other segments are shown."""

    offers_borders = traitlets.Bool(False, read_only=True).tag(sync=True)
    """Whether ``color_by="borders"`` can be chosen."""

    errors_title = traitlets.Unicode(read_only=True).tag(sync=True)
    """Of the legend of the errors; "" = they can't be chosen."""

    columns = ToldList(traitlets.Unicode(), "write view.offer_columns([...])").tag(sync=True)
    """Columns of a table of segments by which faces can be coloured; whoever offers them gives the values."""

    values_legend = Told("write view.set_values(values, title=…, low=…, high=…)").tag(sync=True)
    """Title and ends of the numbers on show: ``{"title": str, "low": float, "high": float}``."""

    # --- between this class and its front end -----------------------------------------------------

    _asks_up = traitlets.Bool(False).tag(sync=True)
    """Whether a bar asks which way is up."""
    _up = traitlets.List(traitlets.Float(), [0.0, 0.0, 1.0]).tag(sync=True)
    """Unit vector."""
    _camera = traitlets.Dict().tag(sync=True)
    """As it last stood still on any page."""
    _hidden = traitlets.List(traitlets.Int()).tag(sync=True)
    """A face of each atom hidden last on any page."""
    _channel = traitlets.Unicode().tag(sync=True)
    """On which the settings below the picture speak to it."""
    _is_preview = traitlets.Bool(False).tag(sync=True)
    """Whether the preview lies over the segments."""
    _token = traitlets.Unicode().tag(sync=True)
    """Tells models apart, for views of one on a page."""
    _mesh_of = traitlets.Unicode().tag(sync=True)
    """Token of the view on the page whose mesh this one draws; "" = it has its own."""
    _answers = traitlets.Dict().tag(sync=True)
    """Number of the last message dealt with, by client."""

    _headers = traitlets.Dict().tag(sync=True)
    """dtype and shape of each array below."""
    _vertices = traitlets.Bytes().tag(sync=True)
    """(n_vertices, 3) float32, around the middle of the mesh."""
    _faces = traitlets.Bytes().tag(sync=True)
    """(n_faces, 3) uint32."""
    _vertex_colors = traitlets.Bytes().tag(sync=True)
    """(n_vertices, 3) uint8; absent where the scan has none."""
    _areas = traitlets.Bytes().tag(sync=True)
    """(n_points,) float32 of a cloud, whose faces are its points; absent for a mesh."""
    _normals = traitlets.Bytes().tag(sync=True)
    """(n_points, 4) int8 of a cloud, the last 127 where the side is known; absent for a mesh."""
    _face_atom = traitlets.Bytes().tag(sync=True)
    """(n_faces,) uint32."""
    _atom_part = traitlets.Bytes().tag(sync=True)
    """(n_levels, n_atoms) uint32, `UNLABELED` where there is no part."""
    _atom_segment = traitlets.Bytes().tag(sync=True)
    """(n_atoms,) uint32, `UNLABELED` where there is none."""
    _segment_colors = traitlets.Bytes().tag(sync=True)
    """(n_segments + N_SPARE, 3) uint8 sRGB."""
    _segment_confidence = traitlets.Bytes().tag(sync=True)
    """(n_segments,) float32; empty where it isn't known."""
    _atom_confidence = traitlets.Bytes().tag(sync=True)
    """(n_atoms,) uint16 codes, see `unit_codes`."""
    _face_value = traitlets.Bytes().tag(sync=True)
    """(n_faces,) uint16 codes."""
    _colormap = traitlets.Bytes().tag(sync=True)
    """(256, 3) uint8 sRGB of the values."""
    _face_error = traitlets.Bytes().tag(sync=True)
    """(n_faces,) uint8: 0 unknown, 1 right, 2 wrong."""
    _face_border = traitlets.Bytes().tag(sync=True)
    """(n_faces,) uint16 codes, see `unit_codes`."""
    _segment_box = traitlets.Bytes().tag(sync=True)
    """(n_segments, 12) float32: the middle, and half of each side as a vector; NaN where there is no box."""
    _face_item = traitlets.Bytes().tag(sync=True)
    """(n_faces,) item of the preview, their number where there is none."""
    _preview_segment = traitlets.Bytes().tag(sync=True)
    """(n_items + 1,) uint32; the last entry is for faces without an item."""
    _preview_colors = traitlets.Bytes().tag(sync=True)
    """(n, 3) uint8 sRGB of the preview's segments."""
    _face_piece = traitlets.Bytes().tag(sync=True)
    """(n_faces,) piece of the family, their number where there is none."""
    _family_merges = traitlets.Bytes().tag(sync=True)
    """(n_merges, 2) uint32: which piece is kept and which goes, from fine to coarse."""
    _family_colors = traitlets.Bytes().tag(sync=True)
    """(n_pieces, 3) uint8 sRGB."""

    def _place_to_set(self, name: str) -> str:
        ways = (way for names, way in INSTEAD.items() if name in names)
        names = option_names()
        return next(ways, "") or did_you_mean(name, names, alike=LIKE) or f"there are: {', '.join(names)}"

    def _place_to_get(self, name: str) -> str:
        ways = (way for names, way in {**ASKED, **INSTEAD}.items() if name in names)
        return next(ways, "") or super()._place_to_get(name)

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

    @traitlets.validate("column")
    def _check_column(self, proposal: Any) -> Any:
        name = proposal["value"]
        if name and name not in self.columns:
            offered = ", ".join(map(repr, self.columns)) or "none here"
            raise ValueError(f"column must be one of {offered}, got {name!r:.200}")
        return name

    @traitlets.observe("color_by")
    def _leave_column(self, change: Any) -> None:
        if change["new"] != "values":
            self.column = ""


def own_names() -> list[str]:
    """Names of the state that people may read, sorted.

    Examples
    --------
    >>> "n_segments" in own_names(), "_faces" in own_names()
    (True, False)
    """
    return sorted(name for name in SceneState.class_own_traits() if not name.startswith("_"))


def option_names() -> list[str]:
    """Those that people may set.

    Examples
    --------
    >>> "height" in option_names(), "n_segments" in option_names()
    (True, False)
    """
    traits = SceneState.class_own_traits()
    return [name for name in own_names() if not traits[name].read_only]
