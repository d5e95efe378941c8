"""Coarse results while a thumb moves: what the memo can answer, or a smaller ensemble.

Goes in: parameters, many a second. Come out: previews in the picture, computed in a thread of their own; of
those asked for meanwhile only the newest is computed next. The session is never touched.
"""

from __future__ import annotations

import logging
import threading

from scenewidget.engine.params import Params
from scenewidget.engine.pipeline import Pipeline
from scenewidget.widget.scene_view import SceneView

__all__ = ["Previewer", "coarser", "preview_params"]

N_RUNS, N_GRAPH_RUNS = 6, 10  # of a preview
N_SIMPLIFIED = 2_000  # faces; distances between all pairs of 10 000 take seconds


class Previewer:
    """Shows what parameters would give, as long as somebody only tries them.

    Parameters
    ----------
    pipeline : Pipeline
    view : SceneView
    lock : RLock
        Held while the view changes.
    """

    def __init__(self, pipeline: Pipeline, view: SceneView, lock: threading.RLock) -> None:
        self._pipeline, self._view, self._lock = pipeline, view, lock
        self._condition = threading.Condition()
        self._wanted: Params | None = None
        self._is_open = False  # somebody is trying
        self._epoch = 0  # answers to questions of an earlier one are dropped
        self._thread: threading.Thread | None = None

    def ask(self, params: Params) -> None:
        """Show these parameters soon, unless others are asked for before."""
        with self._condition:
            self._wanted, self._is_open = params, True
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="scenewidget-preview", daemon=True)
                self._thread.start()

    def stop(self) -> None:
        """Take no more answers; the preview that is shown stays until `end`."""
        with self._condition:
            self._wanted, self._is_open = None, False
            self._epoch += 1

    def end(self) -> None:
        """Show the segments again."""
        self.stop()
        with self._lock:
            self._view.end_preview()

    def settle(self) -> None:
        """Show the segments again, unless somebody has begun to try anew."""
        with self._condition:
            is_open = self._is_open
        if not is_open:
            self.end()

    def wait(self, timeout: float | None = None) -> bool:
        """Block until nothing is being computed; False if the time ran out first."""
        with self._condition:
            return self._condition.wait_for(lambda: self._thread is None, timeout)

    def _run(self) -> None:
        while True:
            with self._condition:
                params, epoch, self._wanted = self._wanted, self._epoch, None
                if params is None:
                    self._thread = None
                    self._condition.notify_all()
                    return
            try:
                items = self._pipeline.get("items", params)
                labels, _ = self._pipeline.get("finish", params)
            except Exception:  # the full computation will say what is wrong
                logging.getLogger(__name__).debug("no preview", exc_info=True)
                continue
            with self._lock:
                if epoch == self._epoch:
                    self._view.show_preview(items, labels)


def preview_params(pipeline: Pipeline, wanted: Params, shown: Params) -> Params:
    """What to compute in place of some parameters while a thumb moves.

    Parameters
    ----------
    wanted : Params
        Where the thumb is.
    shown : Params
        Of the last result: its ensemble serves for another S, too.
    """
    wanted = wanted.replace(granularity=None)
    if wanted.consensus == "peac":  # takes seconds
        wanted = wanted.replace(consensus="linkage")
    if wanted.k_range is None:
        same = wanted.replace(k_range=shown.k_bounds)
        if pipeline.knows("coassociation", same):
            return same
    return wanted if pipeline.knows("coassociation", wanted) else coarser(wanted)


def coarser(params: Params) -> Params:
    """The same with fewer runs, and of a simplified mesh with fewer faces."""
    p = params
    middle = sorted(p.convex_weights)[len(p.convex_weights) // 2]
    return p.replace(
        n_items=p.n_items if p.items == "superfacets" else min(p.n_items, N_SIMPLIFIED),
        n_runs=min(p.n_runs, N_RUNS),
        n_graph_runs=min(p.n_graph_runs, N_GRAPH_RUNS),
        convex_weights=(middle,),
    )
