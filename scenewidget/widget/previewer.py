"""Coarse results while a thumb moves: what the memo can answer, or a smaller ensemble.

Goes in: parameters, many a second. Come out: previews in the picture, computed in a thread of their own; of
those asked for meanwhile only the newest is computed next. The session is never touched.
"""

from __future__ import annotations

import threading

from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.widget.scene_view import SceneView
from scenewidget.widget.worker import Newest

__all__ = ["Previewer", "coarser", "preview_params"]

N_RUNS, N_GRAPH_RUNS = 6, 20  # of a preview
N_SIMPLIFIED = (
    2_000  # a preview has at most so many faces: distances between all pairs of 10 000 take seconds
)
PREPARING = "Preparing a preview"  # told before the first preview of a mesh; others come at once


class Previewer:
    """Shows what parameters would give, as long as somebody only tries them.

    Parameters
    ----------
    pipeline : Pipeline
    view : SceneView
    lock : RLock
        Held while the view changes.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> import threading
    >>> view = SceneView(mesh)
    >>> previewer = Previewer(sw.Pipeline(mesh), view, threading.RLock())
    >>> previewer.wait()
    True
    >>> view.close()
    """

    def __init__(self, pipeline: Pipeline, view: SceneView, lock: threading.RLock) -> None:
        self._pipeline, self._view, self._lock = pipeline, view, lock
        self._runner = Newest("scenewidget-preview")
        self._is_open = False  # somebody is trying
        self._epoch = 0  # answers to questions of an earlier one are dropped
        self._status = ""  # of the view, before it said that a preview is being prepared

    def prepare(self, params: Params) -> None:
        """Compute what the first preview around these parameters would have to wait for.

        That is another, coarser simplification of the mesh: seconds at a million faces.
        """
        with self._lock:
            if params.items == "simplified" and not self._is_open:
                self._runner.submit(lambda: self._pipeline.get("items", coarser(params)))

    def ask(self, params: Params) -> None:
        """Show these parameters soon, unless others are asked for before; say so if soon isn't at once."""
        with self._lock:
            self._is_open = True
            epoch = self._epoch
            is_slow = not self._pipeline.knows("items", params)
            if is_slow and not self._view.busy and self._view.status != PREPARING:
                self._status, self._view.status = self._view.status, PREPARING
        self._runner.submit(lambda: self._show(params, epoch))

    def stop(self) -> None:
        """Take no more answers; the preview that is shown stays until `end`."""
        self._runner.drop()
        with self._lock:
            self._is_open = False
            self._epoch += 1
            self._be_ready()

    def end(self) -> None:
        """Show the segments again."""
        self.stop()
        with self._lock:
            self._view.end_preview()

    def settle(self) -> None:
        """Show the segments again, unless somebody has begun to try anew."""
        with self._lock:
            if not self._is_open:
                self.end()

    def wait(self, timeout: float | None = None) -> bool:
        """Block until nothing is being computed; False if the time ran out first."""
        return self._runner.wait(timeout)

    def _show(self, params: Params, epoch: int) -> None:
        try:
            items = self._pipeline.get("items", params)
            if params.consensus == "linkage" and params.n_segments != "auto":
                labels = self._pipeline.get("nested", params).item_labels(params.n_segments)
            else:
                labels = self._pipeline.get("finish", params)
        except (ValueError, MemoryError):  # the full computation will say what is wrong
            items = None
        with self._lock:
            if epoch == self._epoch:
                self._be_ready()
                if items is not None:
                    self._view.show_preview(items, labels)

    def _be_ready(self) -> None:
        if self._view.status == PREPARING:
            self._view.status = self._status


def preview_params(pipeline: Pipeline, wanted: Params, shown: Params) -> Params:
    """What to compute in place of some parameters while a thumb moves.

    Parameters
    ----------
    wanted : Params
        Where the thumb is.
    shown : Params
        Of the last result: its ensemble serves for another S, too.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> pipeline = sw.Pipeline(mesh)
    >>> preview_params(pipeline, sw.Params(consensus="peac"), shown=sw.Params()).consensus
    'linkage'
    """
    wanted = wanted.replace(granularity=None, relief=0.0, contrast=0.0)  # both are looked for on every face
    if wanted.consensus == "peac":  # takes seconds
        wanted = wanted.replace(consensus="linkage")
    if wanted.k_range is None:
        same = wanted.replace(k_range=shown.k_bounds)
        if pipeline.knows("coassociation", same):
            return same
    return wanted if pipeline.knows("coassociation", wanted) else coarser(wanted)


def coarser(params: Params) -> Params:
    """The same with fewer runs, and of a simplified mesh with fewer faces.

    Examples
    --------
    >>> import scenewidget as sw
    >>> coarser(sw.Params(n_runs=20)).n_runs
    6
    """
    p = params
    middle = sorted(p.convex_weights)[len(p.convex_weights) // 2]
    return p.replace(
        n_items=p.n_items if p.items == "superfacets" else min(p.n_items, N_SIMPLIFIED),
        n_runs=min(p.n_runs, N_RUNS),
        n_graph_runs=min(p.n_graph_runs, N_GRAPH_RUNS),
        convex_weights=(middle,),
    )
