"""The whole tool in a cell: the scan in 3D, its segmentation, and the sliders that change it.

`SceneWidget` translates between the view, the sliders and a `Pipeline`; everything that it can do, a
script can do without it. The engine runs in one worker thread, so the notebook stays usable.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import ipywidgets as widgets
import traitlets

from scenewidget.editing.edits import EditError
from scenewidget.editing.session import Event, Session
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.engine.segmentation import LEVELS, Segmentation
from scenewidget.widget.controls import EditControls, ParamsControls
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.worker import Worker

__all__ = ["SceneWidget"]

STAGE_NAMES = {
    "adjacency": "Finding neighbouring faces",
    "items": "Gathering faces into items",
    "dihedral": "Partitioning by dihedral angle",
    "allocation": "Sharing out clusters over components",
    "eigenbasis": "Solving for eigenfunctions",
    "features": "Computing features",
    "distances": "Measuring distances",
    "ensemble": "Clustering many times",
    "coassociation": "Comparing the clusterings",
    "tree": "Building the consensus tree",
    "consensus": "Finding the consensus",
    "segmentation": "Labeling every face",
}


class SceneWidget(widgets.VBox):
    """Segment a scan, look at it and correct it; it displays itself as the last value of a cell.

    The scan shows at once, the segments as soon as they are computed. ``params`` and ``segmentation`` are
    traits: set the first to compute again, observe the second to be told of results and edits. Corrections
    survive: when other parameters give another segmentation, they are made on that again.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
    params : Params, optional
        `Params()` by default.
    height : int
        Of the picture, in pixels.

    Attributes
    ----------
    params : Params
    segmentation : Segmentation or None
        The last good result with the corrections made so far; None before the first.
    session : Session or None
        The corrections, which scripts can make too: ``w.session.merge(face, onto_face)``.
    busy : bool
    view : SceneView
        The picture: colours, level, camera.
    controls : ParamsControls
        The sliders.
    edit_controls : EditControls
        The buttons for editing.
    pipeline : Pipeline

    Raises
    ------
    MeshError, TypeError, FileNotFoundError
        The mesh can't be read or worked with; nothing is computed.
    """

    params = traitlets.Instance(Params)
    segmentation = traitlets.Instance(Segmentation, allow_none=True)
    busy = traitlets.Bool(False, read_only=True)

    def __init__(self, mesh: Mesh | Any, params: Params | None = None, *, height: int = 560) -> None:
        if params is not None and not isinstance(params, Params):
            raise TypeError(f"params must be a Params, got {type(params).__name__}")
        params = params or Params()
        self.pipeline = Pipeline(mesh)
        self.view = SceneView(self.pipeline.mesh, height=height)
        self.controls = ParamsControls(params, self._set_params, self._compute)
        self.edit_controls = EditControls(self._undo, self._redo)
        traitlets.link((self.edit_controls.mode, "value"), (self.view, "mode"))
        self.session: Session | None = None
        self._lock = threading.RLock()
        self._error: BaseException | None = None
        self._shown_params: Params | None = None
        self._started = 0.0
        self._worker = Worker(
            on_progress=self._show_progress,
            on_done=self._show_result,
            on_error=self._show_error,
            on_cancelled=self._show_cancelled,
        )
        super().__init__([self.view, self.edit_controls, self.controls], params=params)
        self.view.on_msg(self._handle_message)
        self.observe(self._take_params, "params")
        self._compute()

    def __repr__(self) -> str:
        segments = "" if self.segmentation is None else f", {self.segmentation.n_segments} segments"
        return f"SceneWidget({self.mesh.n_faces} faces{segments})"

    @property
    def mesh(self) -> Mesh:
        """The scan, as loaded."""
        return self.pipeline.mesh

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
        if not self._worker.wait(timeout):
            raise TimeoutError(f"still {self.view.status or 'computing'!r} after {timeout:g} seconds")
        with self._lock:
            if self._error is not None:
                raise self._error
            if self.segmentation is None:
                raise RuntimeError("cancelled before there was a result; set params to compute again")
            return self.segmentation

    def cancel(self) -> None:
        """Stop the computation; the last good result stays."""
        self._worker.cancel()

    def close(self) -> None:
        """Stop the computation and take the widget off the page."""
        if "_worker" in vars(self):  # not if __init__ refused its mesh
            self._worker.cancel()
            self.view.close()
        super().close()

    def _set_params(self, params: Params) -> None:
        self.params = params

    def _take_params(self, change: dict[str, Any]) -> None:
        self.controls.show(change["new"])
        self._compute()

    def _compute(self) -> None:
        params = self.params
        with self._lock:
            self._error = None
            self._started = time.perf_counter()
            self.set_trait("busy", True)
            self.view.error = ""
            self.view.status, self.view.progress, self.view.busy = "Starting", 0.0, True
            self.controls.offer_rerun(False)

        def task(progress: Callable[[str, float], None], cancel: threading.Event) -> Any:
            return params, self.pipeline.run(params, progress=progress, cancel=cancel)

        self._worker.submit(task)

    def _handle_message(self, _: Any, message: Any, __: Any) -> None:
        """What a person did in the picture, as `SceneView` reports it."""
        kind = message.get("kind") if isinstance(message, dict) else None
        if kind == "cancel":
            self.cancel()
        elif kind == "undo":
            self._undo()
        elif kind == "redo":
            self._redo()
        elif kind in ("merge", "split") and self.session is not None:
            if message.get("revision") != self.view.revision:
                self._remark("The picture had just changed: nothing was edited")
            elif kind == "merge":
                self._edit(self.session.merge, message["face"], message["onto_face"], message["level"])
            else:
                self._edit(self.session.split, message["face"], message["level"])

    def _undo(self) -> None:
        if self.session is not None:
            self._edit(self.session.undo)

    def _redo(self) -> None:
        if self.session is not None:
            self._edit(self.session.redo)

    def _edit(self, action: Callable[..., Any], *arguments: Any) -> None:
        try:
            action(*arguments)
        except EditError as error:
            self._remark(str(error))

    def _remark(self, text: str) -> None:
        """Say something in the status line, unless a computation speaks there."""
        with self._lock:
            if not self.view.busy:
                self.view.status = text

    def _show_edit(self, event: Event) -> None:
        """Show what the session holds now; called after each edit, undo and redo, from any thread."""
        with self._lock:
            session = self.session
            if session is None:
                return
            segmentation = session.segmentation
            names = {i: name for i, name in enumerate(segmentation.names) if name}
            if event.kind == "segmentation":
                levels = {str(level): segmentation.level(level) for level in LEVELS}
                self.view.set_partition(levels, segmentation.labels, names)
            elif event.kind in ("edit", "undo", "redo"):
                self.view.set_segments(segmentation.labels, names)
                done = {"edit": "", "undo": "Undone: ", "redo": "Redone: "}[event.kind]
                self._remark(f"{done}{event.step.title if event.step else ''}")
            self.edit_controls.show(session)
            self.segmentation = segmentation

    def _show_progress(self, stage: str, fraction: float) -> None:
        with self._lock, self.view.hold_sync():
            self.view.status = STAGE_NAMES.get(stage, stage)
            self.view.progress = fraction

    def _show_result(self, result: tuple[Params, Segmentation]) -> None:
        params, segmentation = result
        with self._lock:
            lost = 0
            if self.session is None:
                self.session = Session(self.mesh, segmentation, params=params)
                self.session.observe(self._show_edit)
                self._show_edit(Event("segmentation", None, 0))
            else:
                lost = len(self.session.resegment(segmentation, params))
            self._shown_params = params
            seconds = time.perf_counter() - self._started
            summary = f"{segmentation.coverage:.1%} of the faces labeled, in {seconds:.1f} s"
            if lost:
                summary += f"; {lost} of the edits don't apply to it, see session.history"
            self._end(summary)

    def _show_error(self, error: BaseException) -> None:
        with self._lock:
            self._error = error
            self.view.error = f"{type(error).__name__}: {error}"
            self._end("The computation failed" + self._what_stays())

    def _show_cancelled(self) -> None:
        with self._lock:
            self._end("Cancelled" + self._what_stays())

    def _what_stays(self) -> str:
        return "" if self.segmentation is None else "; the picture shows the result before"

    def _end(self, summary: str) -> None:
        self.controls.offer_rerun(self._shown_params != self.params)
        self.view.status, self.view.progress, self.view.busy = summary, 1.0, False
        self.set_trait("busy", False)
