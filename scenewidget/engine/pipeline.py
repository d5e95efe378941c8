"""A mesh with a memo of what was computed on it, and `segment`.

Goes in: a mesh and `Params`. Comes out: a `Segmentation`. What the steps are, in their order, is the table in
`stages`; a changed option recomputes exactly those that depend on it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from scenewidget.engine.family import Family
from scenewidget.engine.features import checked_descriptor
from scenewidget.engine.memo import Memo
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.monitor import Monitor, Progress
from scenewidget.engine.params import Params
from scenewidget.engine.readers import load
from scenewidget.engine.segmentation import Segmentation
from scenewidget.engine.stages import Stage, stages

__all__ = ["Pipeline", "segment"]


def segment(
    mesh: Mesh | Any,
    params: Params | None = None,
    *,
    members: Sequence[IntArray] = (),
    features: FloatArray | None = None,
    progress: Progress | None = None,
    cancel: threading.Event | None = None,
    **options: Any,
) -> Segmentation:
    """Cut a mesh into meaningful pieces.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
        In metres, normals pointing into free space.
    params : Params, optional
        `Params()` by default.
    members : sequence of (n_faces,) int, optional
        Labelings from elsewhere that join the ensemble; see `Pipeline`.
    features : (n_vertices, d) or (n_faces, d) numbers, optional
        A descriptor of your own, looked at under ``Params(feature="given")``; see `Pipeline`.
    progress : callable (stage: str, fraction: float), optional
        Called from the calling thread and from workers, never by two at once.
    cancel : threading.Event, optional
        Set it from another thread to stop.
    **options
        None: those of `Params` are refused with what to write.

    Returns
    -------
    Segmentation

    Raises
    ------
    MeshError, TypeError
        Something that is not a mesh that can be worked with.
    ValueError, TypeError
        ``members`` or ``features`` that don't fit the mesh; ``features`` without ``feature="given"``, or
        this without those.
    Cancelled
        ``cancel`` was set.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import folded, square
    >>> mesh = folded(square(10, size=2.0), "x", 1.0, 1.5)  # two sides of a corner
    >>> segmentation = sw.segment(mesh, sw.Params(n_segments=2))
    >>> segmentation.n_segments, segmentation.labels.shape
    (2, (200,))

    Halves of one plane that only a descriptor tells apart, here by features alone (``cost_b=0``):

    >>> plane = square(10)
    >>> side = plane.face_centroids[:, :1] > 0.5
    >>> params = sw.Params.thesis(2, feature="given", cost_b=0, merge=False, k_range=(2, 2), n_runs=5)
    >>> sw.segment(plane, params, features=side).n_segments
    2
    """
    if options:
        given = ", ".join(f"{name}={value!r:.40}" for name, value in options.items())
        raise TypeError(f"segment takes options in Params: write segment(mesh, Params({given}))")
    if features is not None and _checked(params).feature != "given":
        raise ValueError(
            f"features are not looked at under feature={_checked(params).feature!r}; "
            'write Params(feature="given"), or leave them out'
        )
    pipe = Pipeline(mesh, members=members, features=features)
    return pipe.run(params, progress=progress, cancel=cancel)


class Pipeline:
    """A mesh with a memo of what was computed on it.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces)
    members : sequence of (n_faces,) int, optional
        Labelings from elsewhere, −1 where they say nothing: another tool's, another person's, masks of
        pictures projected on the mesh. Each joins the ensemble with the weight of an eighth of its runs.
    features : (n_vertices, d) or (n_faces, d) numbers, optional
        What ``Params(feature="given")`` compares neighbours by: any descriptor, in any unit, for it is scaled
        so that a step between neighbouring items is 1 (see `features.unit_steps`); columns count against
        each other as they are. As many rows as vertices are of vertices, though there be as many faces.
        Other values of ``feature`` don't look at it.
    memory : float
        Bytes that remembered results may take; the ones used longest ago are forgotten first. Forgetting
        changes no answer. 2 GB by default.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets.analytic import folded, square
    >>> pipe = sw.Pipeline(folded(square(6, size=2.0), "x", 1.0, 1.5))
    >>> first = pipe.run(sw.Params(n_segments=2))
    >>> again = pipe.run(sw.Params(n_segments=3))  # the items are remembered, only the consensus is new
    >>> again.timings["items"]
    0.0
    >>> pipe.get("items")
    Items(2 items, 1 pairs)
    """

    def __init__(
        self,
        mesh: Mesh | Any,
        *,
        members: Sequence[IntArray] = (),
        features: FloatArray | None = None,
        memory: float = 2e9,
    ) -> None:
        self.mesh = load(mesh)
        self._descriptor = None if features is None else checked_descriptor(self.mesh, features)
        self._members = _checked_members(self.mesh, members)
        self._memo = Memo(memory)

    def __repr__(self) -> str:
        return f"Pipeline({self.mesh!r})"

    def run(
        self,
        params: Params | None = None,
        *,
        progress: Progress | None = None,
        cancel: threading.Event | None = None,
    ) -> Segmentation:
        """What ``segment(mesh, params)`` gives, computing only what isn't remembered.

        ``timings`` of the result are the seconds that this call spent in each stage, 0 for remembered ones.

        Parameters
        ----------
        params : Params, optional
            `Params()` by default.
        progress : callable, optional
            ``progress(stage, fraction)``, called as it goes.
        cancel : threading.Event, optional
            Setting it ends the computation with `Cancelled`.
        """
        params = self._checked(params)
        timings: dict[str, float] = {}
        table = stages(params)
        last = next(reversed(table))
        result: Segmentation = self._compute(last, table, Monitor(progress, cancel), timings)
        return result.with_timings(timings)

    def family(
        self,
        params: Params | None = None,
        *,
        progress: Progress | None = None,
        cancel: threading.Event | None = None,
    ) -> Family:
        """Nested segmentations from fine to coarse that run through what `run` gives.

        ``family.cut(n)`` has exactly n segments, takes milliseconds, and is a union of the segments of
        any finer cut; ``family.cut(result.n_segments)`` is the result of ``run(params)`` itself.

        Parameters
        ----------
        params : Params, optional
        progress : callable, optional
            ``progress(stage, fraction)``, called as it goes.
        cancel : threading.Event, optional
            Setting it ends the computation with `Cancelled`.
        """
        table = stages(self._checked(params).replace(granularity=1))
        family: Family = self._compute("family", table, Monitor(progress, cancel), {})
        return family

    def knows(self, stage: str, params: Params) -> bool:
        """Whether a stage's result for these ``params`` is remembered and costs nothing."""
        table = stages(params)
        return stage in table and table[stage].key in self._memo

    def get(
        self,
        stage: str,
        params: Params | None = None,
        *,
        progress: Progress | None = None,
        cancel: threading.Event | None = None,
    ) -> Any:
        """Result of one stage, for teaching.

        Parameters
        ----------
        stage : str
            One of those in ``timings``.
        params : Params, optional
        progress : callable, optional
            ``progress(stage, fraction)``, called as it goes.
        cancel : threading.Event, optional
            Setting it ends the computation with `Cancelled`.

        Raises
        ------
        ValueError
            These parameters have no such stage; the message lists those that they have.
        """
        params = self._checked(params)
        table = stages(params, also="eigenbasis" if stage == "eigenbasis" else "")
        if stage not in table:
            raise ValueError(f"stage must be one of {', '.join(map(repr, table))}, got {stage!r}")
        return self._compute(stage, table, Monitor(progress, cancel), {})

    def clear(self) -> None:
        """Forget all results."""
        self._memo.clear()

    def _checked(self, params: Params | None) -> Params:
        params = _checked(params)
        if params.feature == "given" and self._descriptor is None:
            raise ValueError(
                'feature="given" needs features: segment(mesh, params, features=X), '
                "Pipeline(mesh, features=X); X of shape (n_vertices, d) or (n_faces, d); "
                'or choose another feature, such as "normals"'
            )
        return params

    def _compute(
        self, name: str, table: Mapping[str, Stage], monitor: Monitor, timings: dict[str, float]
    ) -> Any:
        stage = table[name]
        known = self._memo.find(stage.key)
        if known is not None:
            timings.setdefault(name, 0.0)
            return known
        inputs = [self._input(need, table, monitor, timings) for need in stage.needs]
        options = dict[str, Any](stage.options)
        if stage.recalls:
            options["recall"] = self._memo.within(table[stage.recalls].key)
        if stage.alone:  # the memory is wanted at once
            self._memo.forget(lambda key: isinstance(key, tuple) and key[0] == name)
        monitor.tick()
        monitor.start(name)
        start = time.perf_counter()
        value = stage.run(*inputs, monitor=monitor, **options)
        timings[name] = time.perf_counter() - start
        self._memo.keep(stage.key, value)
        monitor.tick()  # a cancel that came during the last loop is heard before the stage counts as done
        monitor.finish()
        return value

    def _input(
        self, need: str, table: Mapping[str, Stage], monitor: Monitor, timings: dict[str, float]
    ) -> Any:
        given = {"mesh": self.mesh, "members": self._members, "descriptor": self._descriptor}
        return given[need] if need in given else self._compute(need, table, monitor, timings)


def _checked_members(mesh: Any, members: Sequence[IntArray]) -> tuple[IntArray, ...]:
    out = []
    for i, given in enumerate(members):
        labels = np.asarray(given)
        if labels.dtype.kind not in "iu":
            raise TypeError(
                f"members[{i}] must be whole numbers, a label a face and −1 where it says nothing, "
                f"got {labels.dtype}"
            )
        if labels.shape != (mesh.n_faces,):
            raise ValueError(
                f"members[{i}] must have a label a face, ({mesh.n_faces},), got {labels.shape}; "
                "import_labels brings labels of another mesh onto this one"
            )
        out.append(np.maximum(labels, -1).astype(np.int64))
    return tuple(out)


def _checked(params: Params | None) -> Params:
    if params is None:
        return Params()
    if not isinstance(params, Params):
        raise TypeError(f"params must be a Params, got {type(params).__name__}; write Params(n_segments=…)")
    return params
