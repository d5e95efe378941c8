"""What may be wrong with a segmentation: borders that shouldn't be, cuts that are missing, wrong faces.

Goes in: pieces of segments and the ensemble's keys. Comes out: for each pair of segments that touch the
probability that they are one thing, for each segment the likeliest cut and the probability that it is two,
and for each piece the probability that it is wrong. Each is a logistic function of a few measures, monotone
in every one, with the numbers of `Models`; `python -m scenewidget.calibrate` fits them on simulated rooms.

Wrong is a face whose segment is mostly another thing, or whose thing is mostly in another segment.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from scenewidget.engine.evidence import agreement_of_groups, counted_together
from scenewidget.engine.kernels import kernel
from scenewidget.engine.linkage import average_linkage
from scenewidget.engine.mesh import FloatArray, IntArray, connected_components
from scenewidget.engine.moments import Moments, mean_normals
from scenewidget.engine.pieces import Pieces

__all__ = [
    "FITTED",
    "LIMITS",
    "Borders",
    "Cuts",
    "Doubt",
    "Gaps",
    "Models",
    "doubts",
    "judged_anew",
    "log_odds",
    "logistic",
    "measure_borders",
    "measure_cuts",
    "measure_gaps",
    "run_kinds",
]

SMALLEST = 2e-4  # share of the scene below which the side of a cut is not worth a question
FAINT = 0.003  # times the scale: distances from a plane below this are noise
ABOUT = 0.03  # times the scale: that much apart, planes of things that don't touch are as good as one
NO_ENSEMBLE = 0.3  # agreement that is assumed of segments that no ensemble made: that of the usual neighbours
NO_PIECES = 20.0  # pieces of a square scale that are assumed of them: as many as an ensemble has
ONE_WAY = 0.8  # least cosine between the normals of what may go on behind something
ONE_PLANE = 0.2  # times the scale: most distance from the plane of the other
ALMOST = 0.999  # no single reason makes anything surer than this


class Models(NamedTuple):
    """Constant and weights of the logistic models, one of each measure in its order.

    Attributes
    ----------
    same : (1 + 5,) of `Borders.measures`
        That two segments are one thing.
    two : (1 + 3,) of `Cuts.measures`
        That the two sides of a cut are two things.
    each, likeliest : (1 + 1,)
        The same of the log-odds under ``same`` and ``two``, which weigh by what it costs to be wrong: of a
        border where all count alike, and of the likeliest cut of a segment, as the best of many looks better
        than it is.
    apart : (1 + 4,) of `Gaps.measures`
        That two segments that don't touch are one thing.
    rest : (1 + 2,)
        That a face's thing is mostly elsewhere: of log(.05 − Σ log(1 − P_same)) over the larger segments that
        touch its own, and the logarithm of the share that its segment has of the scene.
    foreign : (1 + 2,)
        That its segment is mostly another thing: of log(.05 − log(1 − P_two)) for the likeliest cut that
        has it on the smaller side, and log(.003 + its distance from the plane of its segment over the scale).

    Examples
    --------
    >>> [len(weights) for weights in FITTED]
    [6, 4, 2, 2, 5, 3, 3]
    """

    same: tuple[float, ...]
    two: tuple[float, ...]
    each: tuple[float, ...]
    likeliest: tuple[float, ...]
    apart: tuple[float, ...]
    rest: tuple[float, ...]
    foreign: tuple[float, ...]


# That the fit may not leave: more agreement never makes two segments less likely one thing, and so on; and
# the odds of a border or cut count for a face as they are.
RISING, FALLING, WHOLE = (0.0, np.inf), (-np.inf, 0.0), (1.0, 1.0)
LIMITS = {
    "same": (RISING, RISING, FALLING, FALLING, RISING),
    "two": (FALLING, RISING, FALLING),
    "each": (RISING,),
    "likeliest": (RISING,),
    "apart": (RISING, FALLING, FALLING, FALLING),
    "rest": (WHOLE, FALLING),
    "foreign": (WHOLE, RISING),
}

FITTED = Models(
    same=(-3.597, 1.549, 3.292, -0.734, -0.472, 1.970),
    two=(1.925, -1.263, 1.124, -0.291),
    each=(0.442, 0.844),
    likeliest=(-1.113, 0.518),
    apart=(-10.337, 3.948, -2.831, -0.852, -0.912),
    rest=(-4.677, 1.000, -1.033),
    foreign=(-0.698, 1.000, 0.000),
)


@dataclass(frozen=True, eq=False)
class Borders:
    """Pairs of segments that touch, and what can be measured of them.

    Attributes
    ----------
    first, second : (n,) int64
        Segments, the smaller number first; in lexicographic order.
    smaller : (n,) int64
        The one of the two with less area.
    length : (n,) float64
        Of their common border, metres.
    by_graph, by_medoids : (n,) float64
        Mean co-association of the two, over the graph runs and over the k-medoids runs.
    offset : (n,) float64
        Root mean square distance of the smaller from the plane of the larger, metres.
    convex : (n,) float64
        Share of the border where the surface bulges.
    facing : (n,) float64
        Dot product of the two mean normals.
    n_pieces : (n,) float64
        Pieces that the smaller is made of: its size by what the scan resolves.
    scale : float
        Of the scene.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import measure_borders
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> borders = measure_borders(make_pieces(mesh, left, left), None, None)
    >>> borders.length.tolist(), borders.facing.round(6).tolist()
    ([1.0], [1.0])
    """

    first: IntArray
    second: IntArray
    smaller: IntArray
    length: FloatArray
    by_graph: FloatArray
    by_medoids: FloatArray
    offset: FloatArray
    convex: FloatArray
    facing: FloatArray
    n_pieces: FloatArray
    scale: float

    @property
    def measures(self) -> FloatArray:
        """(n, 5) what `Models.same` weighs, lengths over the scale.

        The last is how far the surface turns away over a bulging border, from 0 to 2: the sides of one body
        do, while a picture bulges from its wall and faces the same way.
        """
        return np.stack(
            [
                self.by_graph,
                self.by_medoids,
                np.log(self.offset / self.scale + FAINT),
                np.log(self.n_pieces),
                self.convex * (1.0 - self.facing),
            ],
            axis=1,
        )


@dataclass(frozen=True, eq=False)
class Cuts:
    """Candidate cuts of one segment into two, each a subtree of the consensus tree against the rest.

    Attributes
    ----------
    order : (n_members,) int64
        Pieces of the segment.
    start, stop : (n,) int64
        ``order[start:stop]`` is one side of each cut.
    is_inside : (n,) bool
        Whether that is the smaller side.
    area : (n,) float64
        Of the smaller side, m².
    agreement : (n,) float64
        Mean co-association of the two sides over the graph runs.
    offset : (n,) float64
        Root mean square distance of the smaller side from the plane of the larger, metres.
    seam : (n,) float64
        Length along which the sides meet, metres.
    scale : float
        Of the scene.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import doubts
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> pieces = make_pieces(mesh, 0 * left, left)
    >>> cuts = doubts(pieces, np.array([[0, 0, 0, 0], [0, 1, 1, 1]])).cuts[0]
    >>> cuts.agreement[0].item(), cuts.seam[0].item()
    (0.25, 1.0)
    """

    order: IntArray
    start: IntArray
    stop: IntArray
    is_inside: np.ndarray[Any, np.dtype[np.bool_]]
    area: FloatArray
    agreement: FloatArray
    offset: FloatArray
    seam: FloatArray
    scale: float

    @property
    def n(self) -> int:
        """Number of candidates."""
        return len(self.start)

    @property
    def measures(self) -> FloatArray:
        """(n, 3) what `Models.two` weighs, lengths over the scale."""
        return np.stack(
            [
                self.agreement,
                np.log(self.offset / self.scale + FAINT),
                np.log(self.area / self.scale**2 + 1e-4),
            ],
            axis=1,
        )

    def side(self, cut: int) -> IntArray:
        """Pieces on the smaller side of a cut."""
        inside = self.order[self.start[cut] : self.stop[cut]]
        if self.is_inside[cut]:
            return inside
        return np.concatenate([self.order[: self.start[cut]], self.order[self.stop[cut] :]])


@dataclass(frozen=True, eq=False)
class Gaps:
    """Pairs of segments that don't touch, but lie in one plane and face one way: a wall behind a cupboard.

    Attributes
    ----------
    first, second : (n,) int64
        Segments, the smaller number first; in lexicographic order.
    agreement : (n,) float64
        Mean co-association of the two over the graph runs.
    offset : (n,) float64
        Root mean square distance of either from the plane of the other, the larger of the two, metres.
    gap : (n,) float64
        Metres between them, to about the size of a piece.
    size : (n,) float64
        Area of the smaller, m².
    scale : float
        Of the scene.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import measure_gaps
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(9, size=3.0)
    >>> thirds = np.floor(mesh.face_centroids[:, 0]).astype(np.int32)
    >>> thirds[thirds == 1] = -1  # nothing is known of the middle
    >>> gaps = measure_gaps(make_pieces(mesh, thirds // 2, thirds // 2), None)
    >>> gaps.first.tolist(), gaps.second.tolist(), gaps.offset.round(6).tolist()
    ([0], [1], [0.0])
    """

    first: IntArray
    second: IntArray
    agreement: FloatArray
    offset: FloatArray
    gap: FloatArray
    size: FloatArray
    scale: float

    @property
    def measures(self) -> FloatArray:
        """(n, 4) what `Models.apart` weighs, lengths over the scale."""
        return np.stack(
            [
                self.agreement,
                np.log(self.offset / self.scale + ABOUT),
                np.log(self.gap / self.scale + 0.02),
                np.log(self.size / self.scale**2 + 1e-4),
            ],
            axis=1,
        )


@dataclass(frozen=True, eq=False)
class Doubt:
    """What may be wrong with a segmentation.

    Attributes
    ----------
    pieces : Pieces
    borders : Borders
    same : (n_borders,) float64
        Probability that the two segments are one thing.
    cuts : tuple of Cuts or None
        For each segment; None where it is a single piece, or no ensemble is known.
    two : (n_segments,) float64
        Probability that a segment is two things, by its likeliest cut; 0 where it has none to offer.
    best : (n_segments,) int64
        That cut; −1 for none.
    rest_measures : (n_segments, 2) float64
        What `Models.rest` weighs.
    foreign_measures : (n_pieces, 2) float64
        What `Models.foreign` weighs.
    wrong : (n_pieces,) float64
        Probability that the faces of a piece are wrong.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import doubts
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> doubt = doubts(make_pieces(mesh, left, left), np.array([[0, 0], [0, 1]]))
    >>> doubt.same.shape, doubt.two.tolist(), doubt.wrong.shape
    ((1,), [0.0, 0.0], (2,))
    """

    pieces: Pieces
    borders: Borders
    same: FloatArray
    cuts: tuple[Cuts | None, ...]
    two: FloatArray
    best: IntArray
    rest_measures: FloatArray
    foreign_measures: FloatArray
    wrong: FloatArray

    def side(self, segment: int) -> IntArray:
        """Pieces on the smaller side of the likeliest cut of a segment; none where there is no cut."""
        cuts = self.cuts[segment]
        return np.empty(0, np.int64) if cuts is None or not cuts.n else cuts.side(int(self.best[segment]))


def doubts(
    pieces: Pieces,
    keys: IntArray | None,
    runs: Mapping[str, int] | None = None,
    *,
    n_segments: int | None = None,
    models: Models = FITTED,
    known: dict[bytes, Cuts] | None = None,
) -> Doubt:
    """What may be wrong with a segmentation.

    Parameters
    ----------
    pieces : Pieces
        Of its segments, which are numbered 0, 1, … without gaps.
    keys : (n_base, n_runs) int or None
        Cluster of each base segment in each run. None: no ensemble is known; then borders are judged by their
        shape alone, and no cuts are found.
    runs : mapping of str to int, optional
        How many of the columns are of which kind, in their order: "k-medoids", "graph". Where there are none
        of a kind, or nothing is said, all columns stand for it.
    n_segments : int, optional
        How many there are, where the last ones may have no piece.
    models : Models
    known : dict, optional
        Measured cuts of segments by their pieces; looked up and filled. Only of the same pieces and keys.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import doubts
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> often, never = (
    ...     doubts(make_pieces(mesh, left, left), np.array([[0, 0], key])).same[0] for key in ([0, 0], [1, 1])
    ... )
    >>> bool(often > never)
    True
    """
    by_graph, by_medoids = run_kinds(keys, runs)
    n = int(pieces.segment.max(initial=-1)) + 1 if n_segments is None else n_segments
    borders = measure_borders(pieces, by_graph, by_medoids)
    same = logistic(models.same, borders.measures)
    area = np.bincount(pieces.segment, pieces.moments.area, n)
    reasons = np.bincount(borders.smaller, -np.log1p(-np.minimum(same, ALMOST)), n)
    share = np.maximum(area / max(float(area.sum()), 1e-300), 1e-12)
    rest_measures = np.stack([np.log(reasons + 0.05), np.log(share)], axis=1)

    cuts = _all_cuts(pieces, by_graph, n, {} if known is None else known)
    two, best = np.zeros(n), np.full(n, -1)
    worst = np.zeros(pieces.n)
    for s, found in enumerate(cuts):
        if found is not None and found.n:
            p = logistic(models.two, found.measures)
            best[s] = p.argmax()
            two[s] = judged_anew(p[best[s]], models.likeliest)
            _spread(found, p, worst)
    reasons = np.log(0.05 - np.log1p(-np.minimum(worst, ALMOST)))
    away = np.log(_from_plane(pieces, n) / pieces.scale + FAINT)
    foreign_measures = np.stack([reasons, away], axis=1)
    right = 1.0 - logistic(models.rest, rest_measures)[pieces.segment]
    right *= 1.0 - logistic(models.foreign, foreign_measures)
    same = judged_anew(same, models.each)
    return Doubt(pieces, borders, same, cuts, two, best, rest_measures, foreign_measures, 1.0 - right)


def _all_cuts(
    pieces: Pieces, keys: IntArray | None, n: int, known: dict[bytes, Cuts]
) -> tuple[Cuts | None, ...]:
    """Candidate cuts of every segment."""
    inside = _seams_inside(pieces, n)
    if keys is None:
        return (None,) * len(inside)
    order = np.argsort(pieces.segment, kind="stable")
    ends = np.searchsorted(pieces.segment[order], np.arange(len(inside) + 1))
    out: list[Cuts | None] = []
    for s, seams in enumerate(inside):
        members = order[ends[s] : ends[s + 1]]
        if len(members) < 2:
            out.append(None)
            continue
        name = members.tobytes()
        if name not in known:
            known[name] = measure_cuts(pieces, keys, members, *seams)
        out.append(known[name])
    return tuple(out)


def log_odds(weights: tuple[float, ...], measures: FloatArray) -> FloatArray:
    """(n,) log-odds of measures under a model of a constant and a weight of each.

    Parameters
    ----------
    weights : (1 + m,) tuple of float
    measures : (n, m) float64

    Examples
    --------
    >>> log_odds((1.0, 2.0), np.array([[0.0], [3.0]])).tolist()
    [1.0, 7.0]
    """
    return np.asarray(weights[0] + measures @ np.asarray(weights[1:]))


def logistic(weights: tuple[float, ...], measures: FloatArray) -> FloatArray:
    """(n,) probability of measures under a model of a constant and a weight of each.

    Parameters
    ----------
    weights : (1 + m,) tuple of float
    measures : (n, m) float64

    Examples
    --------
    >>> logistic((0.0, 1.0), np.array([[0.0], [1.0]])).round(2)
    array([0.5 , 0.73])
    """
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(log_odds(weights, measures), -30.0, 30.0))))


def judged_anew(p: FloatArray, weights: tuple[float, ...]) -> FloatArray:
    """Probabilities of one model under another one, of their log-odds.

    Parameters
    ----------
    p : (…) float64
        Between 0 and 1.
    weights : (2,) tuple of float
        `Models.each` or `Models.likeliest`.

    Examples
    --------
    >>> judged_anew(np.array([0.5, 0.9]), (0.0, 0.5)).round(2)
    array([0.5 , 0.75])
    """
    p = np.asarray(p)
    return logistic(weights, (np.log(p) - np.log1p(-p))[..., None])


def run_kinds(
    keys: IntArray | None, runs: Mapping[str, int] | None
) -> tuple[IntArray | None, IntArray | None]:
    """The columns of the graph runs, and of the k-medoids runs; all of them where a kind is missing.

    Parameters
    ----------
    keys : (n_base, n_runs) int or None
    runs : mapping of str to int, optional
        How many of the columns are of which kind, in their order.

    Examples
    --------
    >>> keys = np.arange(6).reshape(1, 6)
    >>> run_kinds(keys, {"k-medoids": 2, "graph": 4})
    (array([[2, 3, 4, 5]]), array([[0, 1]]))
    """
    if keys is None:
        return None, None
    found: dict[str, IntArray] = {}
    place = 0
    for kind, n in (runs or {}).items():
        if n and place + n <= keys.shape[1]:
            found[kind] = keys[:, place : place + n]
        place += n
    return found.get("graph", keys), found.get("k-medoids", keys)


# --- borders --------------------------------------------------------------------------------------


def measure_borders(pieces: Pieces, by_graph: IntArray | None, by_medoids: IntArray | None) -> Borders:
    """What can be measured of each pair of segments that touch.

    Parameters
    ----------
    pieces : Pieces
    by_graph, by_medoids : (n_base, n_runs) int or None
        Keys of the two kinds of runs.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import measure_borders
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> keys = np.array([[0, 0], [0, 1]])
    >>> measure_borders(make_pieces(mesh, left, left), keys, keys).by_graph.tolist()
    [0.5]
    """
    n = int(pieces.segment.max(initial=-1)) + 1
    i, j = pieces.pairs.T
    ends = np.sort(pieces.segment[pieces.pairs], axis=1).astype(np.int64)
    crosses = ends[:, 0] != ends[:, 1]
    i, j, length = i[crosses], j[crosses], pieces.length[crosses]
    codes, index = np.unique(ends[crosses, 0] * n + ends[crosses, 1], return_inverse=True)
    first, second = codes // max(n, 1), codes % max(n, 1)
    total = np.bincount(index, length, len(codes))
    center, normals = pieces.moments.centroid, pieces.normals
    bulges = np.einsum("ij,ij->i", center[j] - center[i], normals[j] - normals[i]) > 0
    convex = np.bincount(index, length * bulges, len(codes))
    segments = pieces.moments.gather(pieces.segment, n)
    is_first = segments.area[first] <= segments.area[second]
    smaller, larger = np.where(is_first, first, second), np.where(is_first, second, first)
    _, vectors = segments.principal()
    facing = mean_normals(pieces.vectors, pieces.segment, n)
    together = [_agreement(pieces, keys, n)[first, second] for keys in (by_graph, by_medoids)]
    count = np.bincount(pieces.segment, minlength=n).astype(np.float64)
    if by_graph is None and by_medoids is None:
        count = np.maximum(NO_PIECES * segments.area / pieces.scale**2, 1.0)
    return Borders(
        first,
        second,
        smaller,
        np.asarray(total, dtype=np.float64),
        together[0],
        together[1],
        _offset(_taken(segments, smaller), segments.centroid[larger], vectors[larger, :, 0]),
        np.divide(convex, total, out=np.zeros(len(codes)), where=total > 0),
        np.einsum("ij,ij->i", facing[first], facing[second]),
        count[smaller],
        pieces.scale,
    )


def measure_gaps(pieces: Pieces, by_graph: IntArray | None) -> Gaps:
    """What can be measured of pairs of segments that don't touch, but may go on behind something.

    Parameters
    ----------
    pieces : Pieces
    by_graph : (n_base, n_runs) int or None
        Keys of the graph runs.

    Returns
    -------
    Gaps
        Of pairs in about one plane, facing about one way, neither of them too small for a question. Where
        others in that plane lead from one to the other, their borders decide.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import measure_gaps
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(9, size=3.0)
    >>> thirds = np.floor(mesh.face_centroids[:, 0]).astype(np.int32)
    >>> thirds[thirds == 1] = -1  # nothing is known of the middle
    >>> measure_gaps(make_pieces(mesh, thirds // 2, thirds // 2), None).gap.round(2).tolist()  # of discs
    [0.05]
    """
    n = int(pieces.segment.max(initial=-1)) + 1
    segments = pieces.moments.gather(pieces.segment, n)
    plane = segments.principal()[1][:, :, 0]
    facing = mean_normals(pieces.vectors, pieces.segment, n)
    may = np.triu(facing @ facing.T > ONE_WAY, 1)
    is_small = segments.area < SMALLEST * max(float(segments.area.sum()), 1e-300)
    may[is_small] = may[:, is_small] = False
    first, second = np.nonzero(may)
    offset = np.maximum(
        _offset(_taken(segments, second), segments.centroid[first], plane[first]),
        _offset(_taken(segments, first), segments.centroid[second], plane[second]),
    )
    keep = offset < ONE_PLANE * pieces.scale
    first, second, offset = first[keep], second[keep], offset[keep]
    touches = np.zeros((n, n), dtype=bool)
    home = pieces.segment[pieces.pairs]
    touches[home[:, 0], home[:, 1]] = touches[home[:, 1], home[:, 0]] = True
    meets = touches[first, second]
    _, plane_of = connected_components(n, np.stack([first, second], axis=1)[meets])
    keep = ~meets & (plane_of[first] != plane_of[second])
    first, second, offset = first[keep], second[keep], offset[keep]
    order = np.argsort(pieces.segment, kind="stable")
    ends = np.searchsorted(pieces.segment[order], np.arange(n + 1))
    members = [order[ends[s] : ends[s + 1]] for s in range(n)]
    gaps = [_gap(pieces, members[a], members[b]) for a, b in zip(first.tolist(), second.tolist())]
    return Gaps(
        first,
        second,
        _agreement(pieces, by_graph, n)[first, second],
        offset,
        np.array(gaps, dtype=np.float64),
        np.minimum(segments.area[first], segments.area[second]),
        pieces.scale,
    )


def _gap(pieces: Pieces, one: IntArray, other: IntArray) -> float:
    """Metres between two groups of pieces, taken as discs."""
    center, radius = pieces.moments.centroid, np.sqrt(pieces.moments.area / np.pi)
    if len(one) > len(other):
        one, other = other, one
    found = np.inf
    for p in one.tolist():
        apart = np.linalg.norm(center[other] - center[p], axis=1) - radius[other] - radius[p]
        found = min(found, float(apart.min()))
    return max(found, 0.0)


def _agreement(pieces: Pieces, keys: IntArray | None, n: int) -> FloatArray:
    """(n, n) mean co-association of segments."""
    if keys is None:
        return np.full((n, n), NO_ENSEMBLE)
    weights = np.maximum(pieces.moments.area, 1e-12)
    return agreement_of_groups(keys, weights, pieces.base, pieces.segment, n, np.empty(0, np.int64))[0]


def _taken(moments: Moments, rows: IntArray) -> Moments:
    return Moments(moments.area[rows], moments.first[rows], moments.second[rows])


def _offset(moments: Moments, center: FloatArray, normal: FloatArray) -> FloatArray:
    """(n,) root mean square distance of pieces from planes, metres."""
    height = np.einsum("ij,ij->i", moments.centroid - center, normal)
    spread = np.einsum("ni,nij,nj->n", normal, moments.scatter, normal)
    spread = np.divide(spread, moments.area, out=np.zeros(len(spread)), where=moments.area > 0)
    return np.asarray(np.sqrt(height**2 + np.maximum(spread, 0.0)))


def _from_plane(pieces: Pieces, n: int) -> FloatArray:
    """(n_pieces,) root mean square distance of each piece from the plane of its segment, metres."""
    segments = pieces.moments.gather(pieces.segment, n)
    normal = segments.principal()[1][:, :, 0]
    return _offset(pieces.moments, segments.centroid[pieces.segment], normal[pieces.segment])


# --- cuts -----------------------------------------------------------------------------------------


def measure_cuts(
    pieces: Pieces, keys: IntArray, members: IntArray, ends: IntArray, length: FloatArray
) -> Cuts:
    """Candidate cuts of one segment: every subtree of its consensus tree against the rest.

    Parameters
    ----------
    pieces : Pieces
    keys : (n_base, n_runs) int
        Of the graph runs.
    members : (n_members,) int
        Pieces of the segment, at least two.
    ends : (n_seams, 2) int
        Pairs of members that touch, as positions in ``members``.
    length : (n_seams,) float64
        Metres.

    Returns
    -------
    Cuts
        Those whose smaller side is worth a question.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets.analytic import square
    >>> from scenewidget.engine.doubt import measure_cuts
    >>> from scenewidget.engine.pieces import make_pieces
    >>> mesh = square(4)
    >>> left = (mesh.face_centroids[:, 0] < 0.5).astype(np.int32)
    >>> pieces = make_pieces(mesh, 0 * left, left)
    >>> keys = np.array([[0, 0], [0, 1]])
    >>> cuts = measure_cuts(pieces, keys, np.arange(2), pieces.pairs, pieces.length)
    >>> cuts.agreement.tolist()[0]
    0.5
    """
    area = np.maximum(pieces.moments.area[members], 1e-12)
    C = counted_together(keys[pieces.base[members]]) / keys.shape[1]  # dense (n_members, n_members)
    np.fill_diagonal(C, 1.0)
    tree = average_linkage(C, area)
    flat = np.concatenate(
        [
            pieces.moments.area[members][:, None],
            pieces.moments.first[members],
            pieces.moments.second[members].reshape(-1, 9),
            area[:, None],
            (area * (C @ area))[:, None],
        ],
        axis=1,
    )
    n = 2 * len(members) - 1
    sums, within, border = np.zeros((n, flat.shape[1])), np.zeros(n), np.zeros(n)
    sums[: len(members)], within[: len(members)] = flat, area**2 * np.diagonal(C)
    parent, count, start = np.full(n, n - 1), np.ones(n, np.int64), np.zeros(n, np.int64)
    _add_up(
        tree,
        np.ascontiguousarray(ends, np.int64),
        np.ascontiguousarray(length, np.float64),
        parent,
        sums,
        within,
        border,
        count,
        start,
    )
    stop = start + count
    order = np.empty(len(members), dtype=np.int64)
    order[start[: len(members)]] = members
    root, sums, within, border = sums[-1], sums[:-1], within[:-1], border[:-1]
    start, stop = start[:-1], stop[:-1]
    is_inside = 2 * sums[:, 13] <= root[13]
    small = np.where(is_inside[:, None], sums, root - sums)
    large = root - small
    share = small[:, 0] / max(float(pieces.moments.area.sum()), 1e-300)
    keep = (share >= SMALLEST) & (large[:, 0] > 0)
    agreement = (sums[:, 14] - within) / np.maximum(sums[:, 13] * (root[13] - sums[:, 13]), 1e-300)
    small, large = small[keep], large[keep]
    sides = [Moments(side[:, 0], side[:, 1:4], side[:, 4:13].reshape(-1, 3, 3)) for side in (small, large)]
    normal = sides[1].principal()[1][:, :, 0]
    return Cuts(
        order,
        start[keep],
        stop[keep],
        is_inside[keep],
        small[:, 0],
        np.clip(agreement[keep], 0.0, 1.0),
        _offset(sides[0], sides[1].centroid, normal),
        np.maximum(border[keep], 0.0),
        pieces.scale,
    )


def _seams_inside(pieces: Pieces, n: int) -> list[tuple[IntArray, FloatArray]]:
    """For each segment the pairs of its pieces that touch, as positions among them, and for how long."""
    order = np.argsort(pieces.segment, kind="stable")
    first = np.searchsorted(pieces.segment[order], np.arange(n + 1))
    place = np.empty(pieces.n, dtype=np.int64)
    place[order] = np.arange(pieces.n) - first[pieces.segment[order]]
    home = pieces.segment[pieces.pairs]
    inside = np.flatnonzero(home[:, 0] == home[:, 1])
    inside = inside[np.argsort(home[inside, 0], kind="stable")]
    ends = np.searchsorted(home[inside, 0], np.arange(n + 1))
    rows = [inside[ends[s] : ends[s + 1]] for s in range(n)]
    return [(place[pieces.pairs[row]], pieces.length[row]) for row in rows]


def _spread(cuts: Cuts, p: FloatArray, worst: FloatArray) -> None:
    """Raise ``worst`` of each piece to the probability of the likeliest cut with it on the smaller side."""
    found = np.zeros(len(cuts.order))
    for start, stop, is_inside, value in zip(cuts.start, cuts.stop, cuts.is_inside, p):
        for part in (slice(start, stop),) if is_inside else (slice(0, start), slice(stop, None)):
            np.maximum(found[part], value, out=found[part])
    worst[cuts.order] = found


@kernel
def _add_up(  # type: ignore[no-untyped-def]
    tree, ends, length, parent, sums, within, border, count, start
):
    """For every node of a merge tree: sums over its leaves, their agreement, their border, their places.

    All are filled for the leaves, which come first. Column 13 of ``sums`` is the area that the tree was made
    with. ``within`` is the sum over pairs of leaves of both areas times co-association, which the heights of
    the tree give.
    """
    n = len(tree) + 1
    for k in range(n - 1):
        left, right = int(tree[k, 0]), int(tree[k, 1])
        parent[left], parent[right] = n + k, n + k
        for c in range(sums.shape[1]):
            sums[n + k, c] = sums[left, c] + sums[right, c]
        count[n + k] = count[left] + count[right]
        across = sums[left, 13] * sums[right, 13] * (1.0 - tree[k, 2])
        within[n + k] = within[left] + within[right] + 2.0 * across
    for e in range(len(ends)):
        a, b = ends[e, 0], ends[e, 1]
        while a != b:  # up to where the two meet; parents have larger numbers
            if a < b:
                border[a] += length[e]
                a = parent[a]
            else:
                border[b] += length[e]
                b = parent[b]
    for k in range(n - 2, -1, -1):
        left, right = int(tree[k, 0]), int(tree[k, 1])
        start[left] = start[n + k]
        start[right] = start[n + k] + count[left]
