"""The whole tool in a cell: the scan in 3D, its segmentation, and the sliders that change it.

`SceneWidget` translates between the view, the sliders and a `Pipeline`; everything that it can do, a
script can do without it. The engine runs in one worker thread, so the notebook stays usable.
"""

from __future__ import annotations

import os
import secrets
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import ipywidgets as widgets
import traitlets

from scenewidget.editing.session import Session
from scenewidget.editing.vocabulary import chosen_vocabulary
from scenewidget.engine.checks import KnownNames
from scenewidget.engine.family import Family
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.engine.segmentation import Segmentation
from scenewidget.engine.stages import TITLES
from scenewidget.widget.arranged import Arranged
from scenewidget.widget.autosave import Autosave
from scenewidget.widget.border_lines import border_lines
from scenewidget.widget.columns import COLUMNS, column_values
from scenewidget.widget.controls import ParamsControls
from scenewidget.widget.edit_commands import EditCommands
from scenewidget.widget.lifetimes import belongs_to_its_cell, close_all
from scenewidget.widget.misplaced import place_to_get, place_to_set, refuse_options
from scenewidget.widget.observing import FaultTolerant
from scenewidget.widget.previewer import Previewer, preview_params
from scenewidget.widget.scene_state import Told
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.scores import Scorer, score_rows
from scenewidget.widget.suggestion_bar import SuggestionBar
from scenewidget.widget.worker import Newest, Worker, checked_timeout

__all__ = ["SceneWidget"]

INSTEAD = {
    "segmentation": "w.session.resegment(segmentation) puts another one in its place",
    "session": "w.restore(path) goes on with a project file",
    "mesh": "another scan needs another widget: SceneWidget(mesh)",
}


class _LiveSegmentation(traitlets.Instance):  # type: ignore[type-arg]  # older traitlets have none
    """A trait whose labels per face are made when somebody asks: an edit need not wait for them."""

    def get(self, obj: Any, cls: Any = None) -> Any:
        obj._catch_up()
        return super().get(obj, cls)


class SceneWidget(KnownNames, FaultTolerant, Arranged, widgets.VBox):
    """Segment a scan, look at it and correct it; it displays itself as the last value of a cell.

    The scan shows at once, the segments as soon as they are computed. ``params`` and ``segmentation`` are
    traits: set the first to compute again, observe the second to be told of results and edits. Corrections
    survive: when other parameters give another segmentation, they are made on that again.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
    params : Params, optional
        `Params()` by default.
    truth : Segmentation or (n_faces,) int, optional
        What the segments are compared with after every result and every edit: a line of errors below the
        picture, ``scores``, and the colours "errors".
    height : int
        Of the picture, in pixels.
    autosave : bool or path
        By default the first edit made in the picture starts a project file in the kernel's folder, named
        after the scan, such as ``bedroom-1f3a9c02.swproj``; from then on every edit, a script's too, is
        on disk before the widget says "Saved". A path names the file, and begins with a script's first edit
        as well; False waits for `save`. What a file holds already is offered when the widget is shown again.
    vocabulary : "nyu40", "scannet20" or list of str, optional
        Names to choose from when a segment is named; any other name can be typed. The first seven are given
        by the keys 4 to 9 and 0, until others are used. NYU40 by default, or what a restored session has.
    **options
        None: others are refused with the place where they belong.

    Attributes
    ----------
    params : Params
    segmentation : Segmentation or None
        The last good result with the corrections made so far; None before the first.
    session : Session or None
        The corrections, which scripts can make too: ``w.session.merge(face, onto_face)``.
    busy : bool
    scores : dict of str to float
        What `metrics.quick_scores` says of the segments as they are now; empty without a truth.
    view : SceneView
        The picture: colours, level, camera.
    controls : ParamsControls
        The settings, all options of `Params`. While one is dragged, the picture shows a preview.
    pipeline : Pipeline

    Raises
    ------
    MeshError, TypeError, FileNotFoundError
        The mesh can't be read or worked with; nothing is computed.
    ProjectError
        ``autosave`` names the project of another mesh.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> w = sw.SceneWidget(mesh, sw.Params(n_runs=2, n_graph_runs=2), autosave=False)
    >>> w.wait()
    Segmentation(8 faces, 1 segments, 100.0% labeled)
    >>> w.session.relabel(0, "table").title
    "Name 'table'"
    >>> w.segmentation.names
    ('table',)
    >>> w.close()
    """

    params = traitlets.Instance(Params)
    """What the segmentation is made with; another value computes again."""

    segmentation = _LiveSegmentation(Segmentation, allow_none=True, read_only=True)
    """The last good result with the corrections made so far; None before the first."""

    busy = traitlets.Bool(False, read_only=True)
    """Whether something is being computed."""

    scores: Any = Told("they are measured after each result and edit")
    """Measures of the present segments against the truth, by name; empty without one."""

    _set_once = ("view", "controls", "pipeline")
    _is_closed = False

    def __init__(
        self,
        mesh: Mesh | Any,
        params: Params | None = None,
        *,
        truth: Segmentation | IntArray | None = None,
        height: int = 560,
        autosave: bool | str | os.PathLike[str] = True,
        vocabulary: str | Sequence[str] | None = None,
        **options: Any,
    ) -> None:
        refuse_options(SceneWidget, options)
        if params is not None and not isinstance(params, Params):
            raise TypeError(
                f"params must be a Params, got {type(params).__name__}; write Params(n_segments=…)"
            )
        params = params or Params()
        self.pipeline = Pipeline(mesh)
        self._scorer = None if truth is None else Scorer(self.pipeline.mesh, truth)
        self._score_runner = Newest("scenewidget-scores")
        self._border_runner = Newest("scenewidget-borders")
        channel = secrets.token_hex(8)
        self.view = SceneView(self.pipeline.mesh, height=height, editable=True, _channel=channel)
        self.controls = ParamsControls(params, _channel=channel)
        self._lock = threading.RLock()
        self._previewer = Previewer(self.pipeline, self.view, self._lock)
        self._is_observed = False
        self.view.ask_up()
        self._autosave = Autosave(self.view, self._lock, autosave, self.restore)
        self._commands = EditCommands(self.view, self._lock, self._autosave, self._take_edit)
        self._commands.vocabulary = None if vocabulary is None else chosen_vocabulary(vocabulary)
        self._suggestion_bar = SuggestionBar(
            self.view, self._lock, lambda: self.session, self._commands.remark
        )
        self._is_restoring = False
        self._error: BaseException | None = None
        self._shown_params: Params | None = None
        self._started = 0.0
        self._worker = Worker(
            on_progress=self._show_progress,
            on_done=lambda show: show(),
            on_error=self._show_error,
            on_cancelled=self._show_cancelled,
        )
        super().__init__([self.view, self.controls], params=params)
        self.view.on_msg(self._handle_message)
        self.controls.connect(on_move=self._preview, on_leave=self._previewer.end, on_rerun=self._compute)
        if self._scorer is not None:
            self.view.offer_errors("Errors against the truth")
            self.view.observe(lambda _: self._score_runner.submit(self._score), "color_by")
        self.view.observe(lambda _: self._border_runner.submit(self._draw_derived), ["color_by", "column"])
        self.observe(self._take_params, "params")
        self.controls.observe(lambda change: self.set_trait("params", change["new"]), "params")
        belongs_to_its_cell(self)
        self._compute()

    def __repr__(self) -> str:
        segments = "" if self.segmentation is None else f", {self.segmentation.n_segments} segments"
        return f"SceneWidget({self.mesh.n_faces} {self.mesh.noun}s{segments})"

    def _display_(self) -> Any:
        """What marimo shows, which knows no boxes of ipywidgets: the picture over the settings."""
        import marimo  # type: ignore[import-not-found, unused-ignore]

        return marimo.vstack([marimo.ui.anywidget(part) for part in self.children])

    @property
    def session(self) -> Session | None:
        """The corrections; None before the first result."""
        commands = vars(self).get("_commands")
        return None if commands is None else commands.session

    def observe(self, handler: Any, names: Any = traitlets.All, type: Any = "change") -> None:  # noqa: A002  # traitlets' name
        """As of any widget. Whoever observes ``segmentation`` is told of every edit and result.

        Parameters
        ----------
        handler : callable
        names : str, list of str or All
        type : str

        Raises
        ------
        TypeError
            The handler can't be called.
        """
        super().observe(handler, names, type)
        wanted = [names] if isinstance(names, str) or names is traitlets.All else names
        if traitlets.All in wanted or "segmentation" in wanted:
            self._is_observed = True

    @property
    def mesh(self) -> Mesh:
        """The scan, as loaded."""
        return self.pipeline.mesh

    @property
    def height(self) -> int:
        """Of the picture, in pixels; can be set."""
        height: int = self.view.height
        return height

    @height.setter
    def height(self, height: int) -> None:
        self.view.height = height

    def __setattr__(self, name: str, value: Any) -> None:
        """As of any object; what can't be set says what to write instead."""
        if name in INSTEAD:
            raise traitlets.TraitError(f"{name} of a SceneWidget is read-only; {INSTEAD[name]}")
        if name == "params" and not isinstance(value, Params):
            raise traitlets.TraitError(
                f"a SceneWidget expected a Params, not the {type(value).__name__} {value!r:.100}; "
                "write w.params = w.params.replace(n_segments=…)"
            )
        if name == "params":
            self._refuse_if_closed()
        super().__setattr__(name, value)

    def _refuse_if_closed(self) -> None:
        if self._is_closed:
            raise RuntimeError(
                "this SceneWidget is closed and computes no more, though its session and segmentation stay; "
                "make another one: SceneWidget(mesh, params)"
            )

    def _place_to_set(self, name: str) -> str:
        return place_to_set(type(self), name)

    def _place_to_get(self, name: str) -> str:
        return place_to_get(name) or super()._place_to_get(name)

    def wait(self, timeout: float | None = 60.0) -> Segmentation:
        """Block until the computation has ended, for scripts and tests.

        Parameters
        ----------
        timeout : float or None
            Seconds; None waits for ever.

        Returns
        -------
        Segmentation

        Raises
        ------
        TimeoutError
            It still runs; it is not cancelled.
        Exception
            Whatever the computation raised.
        RuntimeError
            It was cancelled before there was any result.
        """
        timeout = checked_timeout(timeout)
        if not self._worker.wait(timeout):
            stage = f" ({self.view.status})" if self.view.busy else ""
            raise TimeoutError(f"still computing{stage} after {timeout:g} seconds; wait(None) waits for ever")
        self._score_runner.wait(timeout)
        self._border_runner.wait(timeout)
        with self._lock:
            if self._error is not None:
                raise self._error
        segmentation: Segmentation | None = self.segmentation
        if segmentation is None:
            raise RuntimeError("cancelled before there was a result; set params to compute again")
        return segmentation

    def save(self, path: str | os.PathLike[str] | None = None) -> Path:
        """Write the corrections so far into one file; further edits go there too.

        Parameters
        ----------
        path : path, optional
            ``.swproj`` by convention. Without one, the file that autosave uses.

        Raises
        ------
        RuntimeError
            There is no segmentation yet.
        OSError
            The file can't be written; edits stay in memory.
        """
        if self.session is None:
            raise RuntimeError("there is nothing to save before the first segmentation; wait() for it")
        return self._autosave.save(self.session, path)

    def restore(self, path: str | os.PathLike[str]) -> None:
        """Go on with a project file: its segmentation, parameters and edits take the place of these.

        Edits made so far are left as they are in their own file, if they have one.

        Parameters
        ----------
        path : path
            As `Session.save` wrote it, or the widget by itself.

        Raises
        ------
        FileNotFoundError, ProjectError
            No such file, damaged, or of another mesh; nothing has changed.
        """
        self._refuse_if_closed()
        was_busy = self.busy
        self._worker.cancel()  # before the file is read: a late result would land over it
        if not self._worker.wait(30):
            raise TimeoutError("the computation under way does not stop; nothing was restored")
        self._autosave.wait()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # read-only is told in the picture
                session = Session.open(path, self.mesh)
        except BaseException:
            self._compute() if was_busy else self._find_family()
            raise
        if session.params is not None:
            self._is_restoring = True
            try:
                self.params = session.params
            finally:
                self._is_restoring = False
        self._commands.adopt(session)
        can_suggest = session.automatic.keys is not None
        with self._lock:
            self._error, self._shown_params = None, session.params
            self._show_family(None)
            self.controls.can_suggest = can_suggest
            n = len(session.history)
            self._end(f"Restored {n} step{'' if n == 1 else 's'} from {Path(path).name}")
        self._find_family()

    def to_html(self, path: str | os.PathLike[str], *, title: str = "", overwrite: bool = False) -> Path:
        """Save the picture as one file that a browser opens without Python and without a network.

        Everything works in it but editing and computing; see `SceneView.to_html`.

        Parameters
        ----------
        path : path
        title : str
            Of the page.
        overwrite : bool
            A page that was written so is replaced; any other file only with True.
        """
        return self.view.to_html(path, title=title or repr(self), overwrite=overwrite)

    def cancel(self) -> None:
        """Stop the computation; the last good result stays."""
        self._worker.cancel()

    def close(self) -> None:
        """Stop the computation and take the widget off the page."""
        if "_worker" in vars(self):  # not if __init__ refused its mesh
            self._worker.cancel()
            self._previewer.stop()
            self._is_closed = True
            close_all(self.view, self.controls)  # ipywidgets keeps what isn't closed, and that holds the rest
        close_all(self)

    def _take_params(self, change: dict[str, Any]) -> None:
        self.controls.params = change["new"]
        if not self._is_restoring:
            self._compute()

    def _preview(self, _: str, params: Params) -> None:
        """Show roughly what these parameters would give; nothing but the picture changes."""
        if self._shown_params is not None:
            self._previewer.ask(preview_params(self.pipeline, params, self._shown_params))

    def _compute(self) -> None:
        params = self.params
        self._previewer.stop()

        def task(progress: Callable[[str, float], None], cancel: threading.Event) -> Any:
            segmentation = self.pipeline.run(params, progress=progress, cancel=cancel)
            if not cancel.is_set():
                segmentation.confidence  # noqa: B018  # found on first use: here, where nobody waits for it
            return partial(self._show_result, params, segmentation)

        with self._lock:
            self._error = None
            self._started = time.perf_counter()
            self.set_trait("busy", True)
            self.view.error = ""
            self.view.status, self.view.progress, self.view.busy = "Starting", 0.0, True
            self.controls.can_rerun = False
            self._worker.submit(task)

    def _handle_message(self, _: Any, message: Any, __: Any) -> None:
        """What a person did in the picture, as `SceneView` reports it."""
        kind = message.get("kind") if isinstance(message, dict) else None
        if kind == "cancel":
            self.cancel()
        elif kind == "suggest":
            with self._commands.gesture(message):
                self._suggestion_bar.handle(message)
        else:
            self._commands.handle(message)

    def _take_edit(self) -> None:
        """The session has changed: whoever observes the segmentation is told, others get it when they ask."""
        self._suggestion_bar.forget()
        if self._scorer is not None:
            self._score_runner.submit(self._score)
        self._border_runner.submit(self._draw_derived)
        if self._is_observed:
            self._catch_up()

    def _catch_up(self) -> None:
        """Give ``segmentation`` the present labels per face; not to be called with the lock held."""
        session = self.session
        if session is not None:
            self.set_trait("segmentation", session.segmentation)

    def _score(self) -> None:
        """Compare the segments as they are now with the truth; in a thread of its own."""
        session, scorer = self.session, self._scorer
        if session is None or scorer is None:
            return
        state = session.snapshot()
        scores = scorer.scores(state.atoms, state.labels)
        wanted = self.view.color_by == "errors"
        errors = scorer.errors(state.atoms, state.labels) if wanted else None
        with self._lock:
            if scores != self.scores:
                self.controls.show_scores(score_rows(scores, self.scores))
                self.set_trait("scores", scores)
            if errors is not None:
                self.view.set_errors(errors)

    def _draw_derived(self) -> None:
        """Borders or a column of the table as they are now, where looked at; in a thread of its own."""
        session, column = self.session, self.view.column
        if session is None:
            return
        if self.view.color_by == "borders":
            lines = border_lines(session.segmentation)
            with self._lock:
                self.view.set_borders(lines)
        elif column:
            segmentation = session.segmentation
            values = column_values(segmentation, column)[segmentation.labels]
            with self._lock:
                if self.view.column == column:
                    self.view.set_values(values, title=COLUMNS[column], column=column)

    def _show_progress(self, stage: str, fraction: float) -> None:
        with self._lock, self.view.hold_sync():
            self.view.status = TITLES.get(stage, stage) + self._worker.aside
            self.view.progress = fraction

    def _show_result(self, params: Params, segmentation: Segmentation) -> None:
        lost = self._commands.take(segmentation, params)
        self._catch_up()
        with self._lock:
            self._shown_params = params
            seconds = time.perf_counter() - self._started
            labeled = f"{segmentation.coverage:.1%} of the {self.mesh.noun}s labeled"
            summary = f"{labeled}, in {seconds:.1f} s"
            if lost:
                do = "doesn't" if lost == 1 else "don't"
                summary += f"; {lost} of your edits {do} apply to it, the history (U) says why"
            self.controls.can_suggest = True
            self.view.set_trait("offers_borders", True)
            self.view.offer_columns(list(COLUMNS))
            self._end(summary)
        self._offer_family(params, self.pipeline.family(params))
        self._previewer.prepare(params)

    def _find_family(self) -> None:
        """Compute in the background what the granularity of the result needs, as far as it is forgotten."""
        params = self._shown_params
        if params is None:
            return

        def task(_: Callable[[str, float], None], cancel: threading.Event) -> Any:
            return partial(self._offer_family, params, self.pipeline.family(params, cancel=cancel))

        self._worker.submit(task)

    def _offer_family(self, params: Params, family: Family) -> None:
        with self._lock:
            if params == self._shown_params:
                self._show_family(family)

    def _show_family(self, family: Family | None) -> None:
        """Let the granularity of the result be chosen; None: not yet. Called with the lock held."""
        self.view.set_family(family)
        bounds = () if family is None else (family.least, family.most, family.segmentation.n_segments)
        self.controls.offer_family(bounds)

    def _show_error(self, error: BaseException) -> None:
        with self._lock:
            if self._worker.has_next:
                return
            self._error = error
            self.view.error = f"{type(error).__name__}: {error}"
            self._end("The computation failed" + self._what_stays())

    def _show_cancelled(self) -> None:
        with self._lock:
            self._end("Cancelled" + self._what_stays())

    def _what_stays(self) -> str:
        return "" if self.session is None else "; the picture shows the result before"

    def _end(self, summary: str) -> None:
        if self._worker.has_next:  # whose beginning is shown already
            return
        self._previewer.settle()
        self.controls.can_rerun = self._shown_params != self.params
        self.view.status, self.view.progress, self.view.busy = summary, 1.0, False
        self.set_trait("busy", False)
