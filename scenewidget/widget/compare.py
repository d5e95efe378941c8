"""Segmentations of one scan side by side: same camera, same pointer, where they differ, and by how much.

Go in: two or more `Params` or `Segmentation`s. Come out: views that turn together, colours for the faces on
which they disagree, and a small table. What has to be computed is computed in one worker thread with one
memo, and the scan crosses to the page once.
"""

from __future__ import annotations

import html
import inspect
import secrets
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import ipywidgets as widgets
import numpy as np
import numpy.typing as npt
import traitlets

from scenewidget.engine.checks import KnownNames
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.monitor import Cancelled
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.engine.segmentation import LEVELS, Segmentation
from scenewidget.engine.stages import TITLES
from scenewidget.evaluation import evaluate
from scenewidget.hands import agreement
from scenewidget.metrics import quick_scores
from scenewidget.palette import keep_colors
from scenewidget.widget.arranged import Arranged
from scenewidget.widget.lifetimes import belongs_to_its_cell, close_all
from scenewidget.widget.misplaced import place_to_set, refuse_options
from scenewidget.widget.observing import FaultTolerant
from scenewidget.widget.scene_state import Told, own_names
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.scores import Scorer, disagreement, score_rows
from scenewidget.widget.settings import params_code
from scenewidget.widget.worker import Worker, checked_timeout

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Compare"]

Side = Params | Segmentation
Measure = Callable[[IntArray, IntArray], npt.ArrayLike]
SHARED = ("color_by", "color_mix", "outlines", "back_faces", "section", "up")  # state of all views
LETTERS = "ABCDEFGH"
MOST = len(LETTERS)  # a browser keeps about sixteen pictures
TABLE_STYLE = "border-collapse:collapse;font-variant-numeric:tabular-nums"
LISTED = 10  # segments on which the two agree least
WAYS = {  # what people ask a `Compare` for under another name
    **dict.fromkeys(("left", "right", "view"), "the pictures are views[0], views[1] …"),
    "segmentation": "those of all sides are in segmentations",
    "session": "it shows segmentations and edits none: that is what a SceneWidget is for",
    "params": "each side has its own: write a = Params(n_segments=…), or b = …",
    **dict.fromkeys(
        ("titles", "labels"), "the sides have names: Compare(mesh, {'Ann': first, 'Bob': second})"
    ),
    **dict.fromkeys(("table", "report", "metrics", "errors"), "write to_frame(), or read scores"),
}
CELL_STYLE = "padding:1px 14px 1px 0;text-align:right;white-space:nowrap"


class Compare(KnownNames, FaultTolerant, Arranged, widgets.VBox):
    """Views of one scan that turn together; set ``a``, ``b`` or ``others`` to compare something else.

    Segments that overlap most have the same colour on all sides. "Errors" among the colours marks the faces
    on which a side disagrees with the first: those whose segment is not the partner of the first's, in the
    matching with the largest sum of intersection over union. The first side marks all of them.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
    a, b : Params or Segmentation
        `Params()` by default. A segmentation must be of this mesh. Instead of them, ``a`` may be a mapping of
        names to two or more sides, as `agreement` takes; else the sides are called A, B, C ….
    *others : Params or Segmentation
        More of them, each in a view of its own.
    truth : Segmentation or (n_faces,) int, optional
        What all are judged by.
    disagreement : callable, optional
        Any measure of your own: takes the labels of the first side and of another, (n_faces,) ints with -1 =
        unlabeled, and gives (n_faces,) numbers, NaN = unknown. It colours each side by what it gives of it,
        and the first by the mean over the others; its ``__name__`` is the title.
    height : int
        Of the pictures, in pixels.
    **options
        None: others are refused with the place where they belong.

    Attributes
    ----------
    a, b : Params or Segmentation
    others : tuple of Params or Segmentation
        Of the sides after these; as many as at first.
    names : tuple of str
        Of all sides.
    segmentations : tuple of Segmentation
        Of all sides; empty until they are there.
    scores : dict of str to dict of str to float
        `metrics.quick_scores` of "A and truth", "B and truth", "B and A", with a third side "C and A" …;
        sides that were given by name have theirs.
    views : tuple of SceneView
    busy : bool

    Raises
    ------
    TypeError, ValueError, MeshError, FileNotFoundError
        Something that can't be compared; nothing is computed.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> seg = sw.Segmentation.from_labels(mesh, [0, 0, 0, 0, 1, 1, 1, 1])
    >>> quarters = sw.Segmentation.from_labels(mesh, [0, 0, 1, 1, 2, 2, 3, 3])
    >>> compare = sw.Compare(mesh, seg, quarters)
    >>> compare.wait()
    (Segmentation(8 faces, 2 segments, 100.0% labeled), Segmentation(8 faces, 4 segments, 100.0% labeled))
    >>> compare
    Compare(8 faces, 2 and 4 segments)
    >>> compare.close()
    >>> named = sw.Compare(mesh, {"Ann": seg, "Bob": quarters})
    >>> _ = named.wait()
    >>> list(named.scores)
    ['Bob and Ann']
    >>> named.close()
    """

    a = traitlets.Union([traitlets.Instance(Params), traitlets.Instance(Segmentation)])
    """What the left side shows."""

    b = traitlets.Union([traitlets.Instance(Params), traitlets.Instance(Segmentation)])
    """What the right side shows."""

    others: Any = traitlets.Tuple()
    """What further views show."""

    segmentations: Any = traitlets.Tuple(read_only=True)
    """Of all sides; empty until they are there."""

    scores: Any = Told("they are measured after each result")
    """Measures by name, by "A and truth", "B and truth", "B and A"."""

    busy = traitlets.Bool(False, read_only=True)
    """Whether something is being computed."""

    _set_once = ("pipeline", "views", "names")

    def __init__(
        self,
        mesh: Mesh | Any,
        a: Side | Mapping[str, Side] | None = None,
        b: Side | None = None,
        *others: Side,
        truth: Segmentation | IntArray | None = None,
        disagreement: Measure | None = None,
        height: int = 420,
        **options: Any,
    ) -> None:
        refuse_options(Compare, options)
        self.pipeline = Pipeline(mesh)
        names, given = _named(a, b, others) if isinstance(a, Mapping) else (list(LETTERS), [a, b, *others])
        places = ["a", "b", *(["others"] * (len(given) - 2))]
        sides = [_checked(place, side, self.mesh) for place, side in zip(places, given, strict=True)]
        if len(sides) > MOST:
            raise ValueError(f"others: at most {MOST} views at once, as browsers draw, got {len(sides)}")
        self.names = tuple(names[: len(sides)])
        _check_measure(disagreement)
        self._disagreement = disagreement
        self._scorer = None if truth is None else Scorer(self.mesh, truth)
        self._lock = threading.RLock()
        self._error: BaseException | None = None
        self._at = 0  # which side is being computed
        group = secrets.token_hex(8)
        first = SceneView(self.mesh, height=height, camera_group=group)
        self.views = (first, *(first.twin(height=height, camera_group=group) for _ in sides[1:]))
        for view in self.views:
            view.offer_errors("Against the other" if len(sides) == 2 else f"Against {self.names[0]}")
            view.on_msg(self._handle_message)
        for view in self.views[1:]:
            for name in SHARED:
                traitlets.link((first, name), (view, name))
        a, b = sides[:2]
        self._titles = tuple(widgets.HTML() for _ in sides)
        self._table = widgets.HTML()
        self._worker = Worker(
            on_progress=self._show_progress,
            on_done=self._show_end,
            on_error=self._show_error,
            on_cancelled=lambda: self._show_end("Cancelled"),
        )
        half = {"flex": "1 1 320px", "min_width": "240px"}
        columns = [widgets.VBox(pair, layout=half) for pair in zip(self._titles, self.views, strict=True)]
        row = widgets.Box(columns, layout={"flex_flow": "row wrap", "width": "100%"})
        super().__init__([row, self._table], a=a, b=b, others=tuple(sides[2:]))
        self.observe(lambda _: self._compute(), ["a", "b", "others"])
        belongs_to_its_cell(self)
        self._compute()

    def _place_to_set(self, name: str) -> str:
        return WAYS.get(name) or place_to_set(type(self), name, "views[0]")

    def _place_to_get(self, name: str) -> str:
        in_view = f"it is views[0].{name}, views[1].{name} …" if name in own_names() else ""
        return WAYS.get(name) or in_view or super()._place_to_get(name)

    def __repr__(self) -> str:
        *most, last = [str(segmentation.n_segments) for segmentation in self.segmentations] or [""]
        numbers = f"{', '.join(most)} and {last}" if most else ""
        return f"Compare({self.mesh.n_faces} {self.mesh.noun}s{f', {numbers} segments' if numbers else ''})"

    @property
    def mesh(self) -> Mesh:
        """The scan, as loaded."""
        return self.pipeline.mesh

    @property
    def height(self) -> int:
        """Of the pictures, in pixels; can be set."""
        height: int = self.views[0].height
        return height

    @height.setter
    def height(self, height: int) -> None:
        for view in self.views:
            view.height = height

    def wait(self, timeout: float | None = 60.0) -> tuple[Segmentation, ...]:
        """Block until all are there, for scripts and tests.

        Raises
        ------
        TimeoutError
            It still runs; it is not cancelled.
        Exception
            Whatever the computation raised.
        RuntimeError
            It was cancelled.
        """
        timeout = checked_timeout(timeout)
        if not self._worker.wait(timeout):
            raise TimeoutError(f"still computing after {timeout:g} seconds; wait(None) waits for ever")
        with self._lock:
            if self._error is not None:
                raise self._error
            found: tuple[Segmentation, ...] = self.segmentations
            if not found:
                raise RuntimeError("cancelled before there was a result; set a or b to compute again")
            return found

    def cancel(self) -> None:
        """Stop the computation."""
        self._worker.cancel()

    def close(self) -> None:
        """Stop the computation and take the widget off the page."""
        if "_worker" in vars(self):
            self._worker.cancel()
            row, _ = self.children
            close_all(*self.views, *self._titles, self._table, *row.children, row)
        close_all(self)

    def set_values(self, values: npt.ArrayLike, **options: Any) -> None:
        """Colour all sides by one number a face; ``disagreement=`` of the class does so after every result.

        Parameters
        ----------
        values : (n_faces,) float
            NaN is drawn grey.
        **options
            ``title``, ``colormap``, ``low``, ``high``, as of `SceneView.set_values`.
        """
        with self._lock:
            for view in self.views:
                view.set_values(values, **options)

    def to_frame(self, per: Literal["side", "segment", "name"] = "side") -> pd.DataFrame:
        """How good they are, or how far they agree.

        Parameters
        ----------
        per : "side" | "segment" | "name"
            What has a row. "side": `evaluate` of all against the truth, or of the others against A without
            one; "segment" and "name": `agreement` of all pairs, by area, the least agreed on first.
        """
        found = dict(zip(self.names, self.wait(None), strict=True))
        if per != "side":
            return agreement(found, self.mesh, by="area", per=per)
        if self._scorer is None:
            first = found.pop(self.names[0])
            return evaluate(found, first, self.mesh)
        return evaluate(found, self._scorer.truth, self.mesh)

    @traitlets.validate("a", "b")
    def _check_side(self, proposal: Any) -> Side:
        return _checked(proposal["trait"].name, proposal["value"], self.mesh)

    @traitlets.validate("others")
    def _check_others(self, proposal: Any) -> tuple[Side, ...]:
        given = proposal["value"]
        if len(given) != len(self.views) - 2:
            raise ValueError(
                f"others must stay {len(self.views) - 2}, one a view, got {len(given)}; "
                "another Compare shows more"
            )
        return tuple(_checked("others", side, self.mesh) for side in given)

    def _compute(self) -> None:
        sides = (self.a, self.b, *self.others)

        def task(progress: Callable[[str, float], None], cancel: threading.Event) -> str:
            found: list[Segmentation] = []
            for self._at, side in enumerate(sides):
                if isinstance(side, Params):
                    side = self.pipeline.run(side, progress=progress, cancel=cancel)
                found.append(side)
                self._show_side(self._at, found, cancel)
            self._show_comparison(found, cancel)
            return ""

        with self._lock:
            self._error = None
            self.set_trait("busy", True)
            self.set_trait("segmentations", ())
            self.set_trait("scores", {})
            self._table.value = ""
            for name, side, title, view in zip(self.names, sides, self._titles, self.views, strict=True):
                title.value = f"<b>{html.escape(name)}</b> &nbsp;<code>{html.escape(_words(side))}</code>"
                view.error, view.status, view.progress, view.busy = "", "Waiting", 0.0, True
            self._worker.submit(task)

    def _show_side(self, i: int, found: list[Segmentation], cancel: threading.Event) -> None:
        with self._lock, self.views[i].hold_sync():
            _stop_if(cancel)
            view = self.views[i]
            for segmentation in found:  # the other's first, so that colours are those of the other side
                there = [level for level in LEVELS if level == "final" or level in segmentation.levels]
                levels = {str(level): segmentation.level(level) for level in there}
                names = {k: name for k, name in enumerate(segmentation.names) if name}
                sure = _mean_confidence(segmentation)
                view.set_segments(segmentation.labels, levels=levels, names=names, confidence=sure)
            keep_colors(found[-1], view.color_rows)
            view.status, view.progress, view.busy = "", 1.0, False

    def _show_comparison(self, found: list[Segmentation], cancel: threading.Event) -> None:
        first, *rest = found
        scores, (one, *names) = {}, self.names
        if self._scorer is not None:
            for name, segmentation in zip(self.names, found, strict=True):
                scores[f"{name} and truth"] = quick_scores(segmentation.labels, self._scorer.truth)
        for name, segmentation in zip(names, rest, strict=True):
            scores[f"{name} and {one}"] = quick_scores(segmentation.labels, first.labels)
        verdicts = [disagreement(first.labels, other.labels) for other in rest]
        least = _least_agreed(dict(zip(self.names, found)), self.mesh) if len(rest) == 1 else ""
        with self._lock:
            _stop_if(cancel)
            for view, verdict in zip(self.views, [np.max(verdicts, axis=0), *verdicts], strict=True):
                view.set_errors(verdict)
            shares = {name: float(np.mean(verdict == 2)) for name, verdict in zip(names, verdicts)}
            self._table.value = _table(scores, shares, one) + least
            self.set_trait("scores", scores)
            self.set_trait("segmentations", tuple(found))
        if self._disagreement is None:
            return
        try:
            values = self._measured(self._disagreement, first, rest)
        except Exception as error:  # of the user's own: what was found stands
            error.add_note("raised by disagreement, the measure that Compare was given")
            self._at = 0
            raise
        with self._lock:
            _stop_if(cancel)
            self._show_values(values)

    def _measured(self, measure: Measure, first: Segmentation, rest: list[Segmentation]) -> FloatArray:
        """(n_views, n_faces) what the measure of the user's own says of each side."""
        rows = np.array([np.asarray(measure(first.labels, other.labels), np.float64) for other in rest])
        if rows.shape != (len(rest), self.mesh.n_faces):
            raise ValueError(
                f"disagreement must give {self.mesh.n_faces} numbers, one a face, got shape {rows.shape[1:]}"
            )
        known = np.isfinite(rows)
        mean = np.where(known, rows, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        return np.vstack([np.where(known.any(axis=0), mean, np.nan), rows])

    def _show_values(self, values: FloatArray) -> None:
        """Colour each side by its row over one range; later results leave the choice of colours as it is."""
        finite = values[np.isfinite(values)]
        low, high = float(finite.min(initial=0.0)), float(finite.max(initial=0.0))
        title = getattr(self._disagreement, "__name__", "disagreement").replace("_", " ").strip("<>")
        chosen = self.views[0].color_by if self.views[0].values_legend else "values"
        for view, row in zip(self.views, values, strict=True):
            view.set_values(row, title=title.capitalize(), low=low, high=high)
        self.views[0].color_by = chosen

    def _handle_message(self, _: Any, message: Any, __: Any) -> None:
        if isinstance(message, dict) and message.get("kind") == "cancel":
            self.cancel()

    def _show_progress(self, stage: str, fraction: float) -> None:
        view = self.views[self._at]
        with self._lock, view.hold_sync():
            view.status, view.progress = TITLES.get(stage, stage) + self._worker.aside, fraction

    def _show_error(self, error: BaseException) -> None:
        with self._lock:
            if self._worker.has_next:
                return
            self._error = error
            whose = "".join(f" ({note})" for note in getattr(error, "__notes__", ()))
            self.views[self._at].error = f"{type(error).__name__}: {error}{whose}"
            self._show_end("The computation failed")

    def _show_end(self, status: str) -> None:
        with self._lock:
            if self._worker.has_next:
                return
            for view in self.views:
                if view.busy:
                    view.status, view.progress, view.busy = status, 1.0, False
            self.set_trait("busy", False)


def _check_measure(measure: Any) -> None:
    if measure is None:
        return
    if not callable(measure):
        raise TypeError(f"disagreement must take the labels of two sides, got {type(measure).__name__}")
    try:
        signature = inspect.signature(measure)
    except ValueError:  # some of those written in C have none
        return
    try:
        signature.bind(None, None)
    except TypeError as error:
        raise TypeError(f"disagreement is called with the labels of two sides: {error}") from None


def _named(given: Mapping[str, Side], b: Side | None, others: Sequence[Side]) -> tuple[list[str], list[Side]]:
    """Names of the sides, and these."""
    if b is not None or others:
        raise TypeError("a names all sides, so there are none after it: Compare(mesh, {'Ann': first, …})")
    names = list(given)
    if len(names) < 2:
        raise ValueError(f"a must name two sides at least, got {len(names)}: {{'Ann': first, 'Bob': second}}")
    wrong = next((name for name in names if not isinstance(name, str) or not name.strip()), None)
    if wrong is not None:
        raise TypeError(f"a must map names of sides to them, got the name {wrong!r:.200}")
    return names, list(given.values())


def _checked(name: str, side: Any, mesh: Mesh) -> Side:
    if side is None:
        return Params()
    if isinstance(side, Mapping):
        raise TypeError(
            f"{name} must be Params or a Segmentation; sides with names are given once and all together: "
            "Compare(mesh, {'Ann': first, 'Bob': second})"
        )
    if isinstance(side, list | tuple):
        raise TypeError(
            f"{name} must be Params or a Segmentation, got {type(side).__name__}; write each by itself: "
            "Compare(mesh, first, second, ...)"
        )
    if not isinstance(side, (Params, Segmentation)):
        raise TypeError(
            f"{name} must be Params or a Segmentation, got {type(side).__name__}; "
            "Segmentation.from_labels(mesh, labels) makes one"
        )
    if isinstance(side, Segmentation) and not (
        side.mesh is mesh or np.array_equal(side.mesh.faces, mesh.faces)
    ):
        raise ValueError(
            f"{name} is of another mesh, of {side.mesh.n_faces} faces where this one has {mesh.n_faces}"
        )
    return side


def _stop_if(cancel: threading.Event) -> None:
    if cancel.is_set():
        raise Cancelled("something else is to be compared")


def _words(side: Side) -> str:
    return params_code(side) if isinstance(side, Params) else f"{side.n_segments} segments, as given"


def _mean_confidence(segmentation: Segmentation) -> Any:
    keep, n = segmentation.labels >= 0, segmentation.n_segments
    labels = segmentation.labels[keep]
    total = np.bincount(labels, segmentation.confidence[keep], n)
    return total / np.maximum(np.bincount(labels, minlength=n), 1)


def _least_agreed(both: Mapping[str, Segmentation], mesh: Mesh) -> str:
    """HTML, folded: the segments and the names on which the two agree least; their names are escaped."""
    segments = agreement(both, mesh, by="area", per="segment").head(LISTED)
    heads = ("", "segment", "name", "m²", "best match", "its name", "IoU", "outside it")
    rows = [
        (side, segment, row["name"], f"{row['size']:.2f}", row["match"] if row["match"] >= 0 else "none",
         row["match_name"], f"{row['iou']:.2f}", f"{row['outside']:.0%}")
        for (side, _, segment), row in segments.iterrows()
    ]  # fmt: skip
    folded = _folded("Segments on which they agree least", heads, rows)
    if not any(name for side in both.values() for name in side.names):
        return folded
    names = agreement(both, mesh, by="area", per="name")
    by_name = [
        (name, f"{row['size_first']:.2f}", f"{row['size_second']:.2f}", f"{row['iou']:.2f}")
        for (_, _, name), row in names.iterrows()
    ]
    return folded + _folded("Names", ("", *(f"m² in {side}" for side in both), "IoU"), by_name)


def _folded(title: str, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    def cell(tag: str, value: object) -> str:
        return f'<{tag} style="{CELL_STYLE}">{html.escape(str(value))}</{tag}>'

    head = "".join(cell("th", value) for value in heads)
    body = "".join(f"<tr>{''.join(cell('td', value) for value in row)}</tr>" for row in rows)
    return f"<details><summary>{title}</summary>{_scrolled(head, body)}</details>"


def _table(scores: dict[str, dict[str, float]], shares: dict[str, float], first: str) -> str:
    """HTML, a row a comparison; the names of the sides are escaped, all other text is ours."""
    rows = {name: score_rows(values, {}) for name, values in scores.items()}
    head = "".join(
        f'<th style="{CELL_STYLE}" title="{html.escape(row["tip"])}">{row["name"]}</th>'
        for row in next(iter(rows.values()))
    )
    body = "".join(
        f'<tr><th style="{CELL_STYLE};text-align:left">{html.escape(name)}</th>'
        + "".join(f'<td style="{CELL_STYLE}">{row["text"]}</td>' for row in cells)
        + "</tr>"
        for name, cells in rows.items()
    )
    words = [f"{share:.1%}" + (f" ({name})" if len(shares) > 1 else "") for name, share in shares.items()]
    who = "They disagree" if len(shares) == 1 else f"The others disagree with {first}"
    note = f"{who} on {', '.join(words)} of the faces: colour by “Errors” shows where."
    return f"{_scrolled(f'<th></th>{head}', body)}<div>{html.escape(note)}</div>"


def _scrolled(head: str, body: str) -> str:
    """A table that a narrow cell moves sideways instead of breaking its words."""
    return f'<div style="overflow-x:auto"><table style="{TABLE_STYLE}"><tr>{head}</tr>{body}</table></div>'
