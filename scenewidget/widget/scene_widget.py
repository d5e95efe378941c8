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
import numpy as np
import traitlets

from scenewidget.editing.edits import EditError
from scenewidget.editing.session import Event, Session
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.engine.segmentation import LEVELS, Segmentation
from scenewidget.widget.controls import ParamsControls
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
        self.view = SceneView(self.pipeline.mesh, height=height, editable=True)
        self.controls = ParamsControls(params, self._set_params, self._compute)
        self.session: Session | None = None
        self._lock = threading.RLock()
        self._message = threading.local()  # that this thread is dealing with
        self._shown_automatic: Segmentation | None = None
        self._shown_revision = -1  # of the session
        self._first_revision = 0  # of the view, since the present automatic segmentation is shown
        self._error: BaseException | None = None
        self._shown_params: Params | None = None
        self._started = 0.0
        self._worker = Worker(
            on_progress=self._show_progress,
            on_done=self._show_result,
            on_error=self._show_error,
            on_cancelled=self._show_cancelled,
        )
        super().__init__([self.view, self.controls], params=params)
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
        elif kind in ("merge", "split", "relabel", "undo", "redo"):
            self._message.now = message
            try:
                if self.session is not None:
                    self._edit(self.session, kind, message)
            except EditError as error:
                self._remark(str(error))
            except Exception as error:
                self.view.error = f"{type(error).__name__}: {error}"
                raise
            finally:
                with self._lock:
                    self.view.answer(message)
                del self._message.now

    def _edit(self, session: Session, kind: str, message: dict[str, Any]) -> None:
        if kind == "undo":
            session.undo()
        elif kind == "redo":
            session.redo()
        elif message["revision"] < self._first_revision:
            # it names faces of parts that are no longer there
            self._remark("Another segmentation had just come: nothing was edited")
        elif kind == "merge":
            session.merge(message["face"], message["onto_face"], message["level"])
        elif kind == "split":
            session.split(message["face"], message["level"])
        else:
            session.relabel(message["face"], message["name"])

    def _remark(self, text: str) -> None:
        """Say something in the status line, unless a computation speaks there."""
        with self._lock:
            if not self.view.busy:
                self.view.status = text

    def _show_edit(self, event: Event) -> None:
        """Show what the session holds now; called after each edit, undo and redo, from any thread.

        Asks the session before it takes the lock: a script that walks the history holds the session's own
        lock while it tells us of each step.
        """
        session = self.session
        if session is None:
            return
        revision = session.revision  # what is read below is this state or a newer one
        automatic, segmentation = session.automatic, session.segmentation
        ids = _segment_ids(session, segmentation)
        history, undone = session.history, session.undone
        names = {i: name for i, name in enumerate(segmentation.names) if name}
        confidence = _mean_confidence(segmentation)
        with self._lock, self.view.hold_sync():
            if revision >= self._shown_revision:
                self._shown_revision = revision
                if automatic is not self._shown_automatic:
                    self._shown_automatic = automatic
                    levels = {str(level): automatic.level(level) for level in LEVELS}
                    self.view.set_partition(levels, segmentation.labels, names, confidence, ids)
                    self._first_revision = self.view.revision
                elif segmentation is not self.segmentation:
                    self.view.set_segments(segmentation.labels, names, confidence, ids)
                self.view.undo_title = history[-1].title if history else ""
                self.view.redo_title = undone[0].title if undone else ""
                self.view.vocabulary = list(session.vocabulary)
                self.segmentation = segmentation
            if event.step is not None:
                done = {"undo": "Undone: ", "redo": "Redone: "}.get(event.kind)
                self._remark(f"{done}{event.step.title}" if done else "")
            if message := getattr(self._message, "now", None):
                self.view.answer(message)

    def _show_progress(self, stage: str, fraction: float) -> None:
        with self._lock, self.view.hold_sync():
            self.view.status = STAGE_NAMES.get(stage, stage)
            self.view.progress = fraction

    def _show_result(self, result: tuple[Params, Segmentation]) -> None:
        params, segmentation = result
        lost = 0
        if self.session is None:
            self.session = Session(self.mesh, segmentation, params=params)
            self.session.observe(self._show_edit)
            self._show_edit(Event("segmentation", None, 0))
        else:
            lost = len(self.session.resegment(segmentation, params))
        with self._lock:
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


def _segment_ids(session: Session, segmentation: Segmentation) -> IntArray | None:
    """(n_segments,) what stays of each segment over edits; None if another edit came in between."""
    atoms, segments = session.atoms, session.atom_segments
    if len(segments) != atoms.n:
        return None
    labels = segmentation.labels[atoms.first_face]
    ids: IntArray = np.full(int(labels.max(initial=-1)) + 1, -1)
    ids[labels[labels >= 0]] = segments[labels >= 0]
    is_whole = np.array_equal(ids[labels[labels >= 0]], segments[labels >= 0]) and (ids >= 0).all()
    return ids if is_whole and len(np.unique(ids)) == len(ids) else None


def _mean_confidence(segmentation: Segmentation) -> FloatArray:
    """(n_segments,) mean over the area, as `Segmentation.to_frame` tells it."""
    labels, areas = segmentation.labels, segmentation.mesh.face_areas
    keep, n = labels >= 0, int(labels.max(initial=-1)) + 1
    area = np.bincount(labels[keep], areas[keep], n)
    weighted = np.bincount(labels[keep], (areas * segmentation.confidence)[keep], n)
    return np.divide(weighted, area, out=np.zeros(n), where=area > 0)
