"""Every option of the method in one frozen record, with two presets.

`Params()` is our best; `Params.thesis()` is faithful to Küçükdemir (2020) in every stage. Both run through
the same code.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, TypeVar, get_args

from scenewidget.engine.allocation import Allocation
from scenewidget.engine.checks import checked_whole, did_you_mean
from scenewidget.engine.consensus import Leftover
from scenewidget.engine.dihedral import SlotMapping
from scenewidget.engine.ensemble import MemberInit
from scenewidget.engine.kmedoids import Ties
from scenewidget.engine.orientation import Orientation
from scenewidget.engine.preprocess import Simplifier

__all__ = ["CHOICES", "Consensus", "Feature", "ItemKind", "Params"]

ItemKind = Literal["superfacets", "simplified"]
Feature = Literal["normals", "cotangent", "uniform", "gps", "hks", "wks", "given"]
Consensus = Literal["peac", "linkage", "median"]
_T = TypeVar("_T")

CHOICES: dict[str, tuple[Any, ...]] = {  # what options that are one of a few words can be
    "items": get_args(ItemKind),
    "simplifier": get_args(Simplifier),
    "orientation": get_args(Orientation),
    "feature": get_args(Feature),
    "slot_mapping": get_args(SlotMapping),
    "medoid_ties": get_args(Ties),
    "laplacian": ("cotangent", "robust"),
    "dihedral_order": ("index", "area"),
    "allocation": get_args(Allocation),
    "init": get_args(MemberInit),
    "consensus": get_args(Consensus),
    "leftover": get_args(Leftover),
}
_RANGES: dict[str, tuple[float, float]] = {  # inclusive
    "scale": (1e-6, 1e6),
    "n_items": (2, 40_000),
    "item_area": (0, math.inf),
    "filter_sweeps": (0, 1_000),
    "bridge": (0, math.inf),
    "n_slots": (2, 100_000),
    "tolerance": (0, math.inf),
    "n_eigenpairs": (1, 1_000),
    "feature_floor": (0, math.inf),
    "cost_a": (-math.inf, math.inf),
    "cost_b": (-math.inf, math.inf),
    "cost_exponent": (0, 100),
    "hop": (0, math.inf),
    "n_runs": (0, 10_000),
    "n_graph_runs": (0, 10_000),
    "merge_flatness": (0, 1),
    "merge_normal": (0, 1),
    "merge_seam": (-1, 1),
    "linkage_similarity": (0, 1),
    "relief": (0, math.inf),
    "contrast": (0, math.inf),
    "furniture_similarity": (0, 1),
    "min_area": (0, math.inf),
    "seed": (0, 2**63 - 1),
}


def _explaining_typos(cls: type[_T]) -> type[_T]:
    """The class with a constructor that names the option which an unknown one may have meant."""
    plain = cls.__init__

    @functools.wraps(plain)
    def init(self: _T, *args: Any, **options: Any) -> None:
        if args:
            raise TypeError("Params takes options by name only, as in Params(n_segments=30)")
        _check_names(options, [field.name for field in dataclasses.fields(cls)])  # type: ignore[arg-type]
        plain(self, **options)

    def refuse(self: _T, name: str, value: Any) -> None:
        _check_names([name], [field.name for field in dataclasses.fields(cls)])  # type: ignore[arg-type]
        raise dataclasses.FrozenInstanceError(
            f"Params don't change: write params = params.replace({name}=…), or of a widget "
            f"w.params = w.params.replace({name}=…)"
        )

    cls.__init__ = init  # type: ignore[assignment]
    cls.__setattr__ = refuse  # type: ignore[assignment]
    return cls


def _check_names(given: Iterable[str], names: list[str]) -> None:
    for name in given:
        if name not in names:
            hint = did_you_mean(name, names) or f"options are {', '.join(names)}"
            raise TypeError(f"Params has no option {name!r}; {hint}")


@_explaining_typos
@dataclass(frozen=True, kw_only=True)
class Params:
    """Options of `segment`; make variants with ``params.replace(n_segments=30)``.

    The defaults are our best preset. Options that the thesis does not have, or has with another value,
    say so with "thesis:".

    Parameters
    ----------
    n_segments : int or "auto"
        S, the number of segments aimed at. With ``consensus="peac"`` the number of rows of Y, shared out
        over the components; the result has more where columns stay alone or are cut into connected
        pieces; "auto" gives each component as many as its median partition has clusters, the partition that
        agrees most with the runs whatever its number (see `consensus.peac_by_component`). With "linkage" the
        tree is cut at ``linkage_similarity``; a number asked for is then cut from the nested family through
        that result, exactly so many where the family reaches, else as near as it gets. ``granularity``, if
        given, has the last word. "median" needs no number and ignores it.
    k_range : (int, int), optional
        Least and most clusters of a k-medoids run. None means (2S, 2.5S) (thesis 4.2);
        with "auto" (100, 125).
    cost_exponent : float
        C of Eq. 3.9: cost = max(A + B⟨N_x, N_y⟩, 0)^C. Thesis: 1.5 (its f2).
    cost_a, cost_b : float
        A and B of Eq. 3.9.
    feature : str
        What neighbouring items are compared by (thesis 3.2–3.3): "cotangent" or "uniform" δ-coordinates,
        "gps", "hks", "wks" signatures; "normals" leaves it to the cost alone; "given" are the ``features`` of
        `segment` or `Pipeline`. All multiply the cost, which is 0 where neighbours are coplanar: with
        ``cost_b=0`` features decide there, too. Only k-medoids runs look at them, and of the default's runs
        these are the fewer: more ``n_runs`` or fewer ``n_graph_runs`` make them heard. Thesis: "cotangent".
    items : str
        "superfacets" of the raw mesh, or faces of the "simplified" one. Thesis: "simplified".
    scale : float or "auto"
        Metres in a unit of the scene. "auto" is that of `scale.scene_scale`: 1 for rooms, less for what is
        smaller, so that a table top is seen as a room is, more for halls; parts of the scan that are far
        apart have units of their own. All other lengths here count in this unit, areas in its square. Thesis:
        1, all in metres.
    n_items : int
        Most items. Thesis: 10 000.
    item_area : float
        What a superfacet has at least, square units of the scene.
    simplifier : str
        "fast" or "qslim", both by quadric error metrics; see `preprocess.simplify`. The thesis took Garland's
        QSlim; `thesis` takes "fast", and says why.
    drop_torn : bool
        Whether connected pieces below 1 % of the simplified faces are dropped though they come from a
        larger component that the simplifier tore, to the letter of the thesis; see `preprocess.simplify`.
    tolerance : float
        Faces of the scan that lie farther from the simplified mesh than this share of the root of its mean
        face area stay unlabeled.
    orientation : str
        Which side is free space: "auto", "as given" or "turned"; see `orientation.oriented`.
    filter_sweeps : int or "auto"
        Sweeps of the normal filter under the superfacets; "auto" reaches as far on any mesh, see
        `items.sweeps_for`.
    bridge : float
        Fragments this close (units of the scene) are neighbours, superfacets only.
    n_slots : int
        D of the dihedral-based partitioning (thesis 3.1).
    slot_mapping : str
        Whether these are equal steps of the dot product ("linear"), of the "angle", or hold equal "counts"
        of pairs. Thesis: "linear".
    dihedral_order : str
        In which order its seeds are taken: "index" or "area" of the faces.
    laplacian : str
        "cotangent", or "robust": intrinsic Delaunay (Sharp and Crane 2020).
    n_eigenpairs : int
        Length of the spectral signatures (thesis: 50).
    feature_floor : float
        d0 of `distances.edge_weights`, as a share of the 95 % quantile. Thesis: 0.
    hop : float
        Added to each edge: so runs cut flat surfaces, too, and base segments are small there, which makes
        corrections by them finer. Thesis: 0.
    convex_weights : tuple of float
        What a convex edge's weight is multiplied by, in turn over the runs. Thesis: (1,).
    n_runs : int
        k-medoids runs, E. (The thesis never states it.)
    n_graph_runs : int
        Felzenszwalb runs at random thresholds that join the ensemble. A k-medoids run counts as two of them:
        they are cheaper, and many, for what two seeds agree on grows with their number. Thesis: 0.
    init : str
        Initial medoids: "even" over the surface, or a way of `kmedoids.k_medoids`. Thesis: "random".
    medoid_ties : str
        Which of several members with the least sum of distances becomes the medoid: "first", or "stay" where
        it is; see `kmedoids.k_medoids`. Thesis: "first".
    allocation : str
        How k and S are shared out over components: by "dihedral" partitions, by "faces" (items), or the
        "same" for each (thesis 3.1 names all three); or by the dihedral partitions of the "raw" mesh
        (its chapter 5 expects more of them). Thesis: "dihedral".
    merge : bool
        Whether runs are merged over planes before they join the ensemble (thesis: yes).
    merge_flatness, merge_normal, merge_seam : float
        Thresholds of that; see `ensemble.merge_flat`.
    consensus : str
        "peac", "linkage" or "median". Thesis: "peac".
    linkage_similarity : float
        Mean co-association down to which "linkage" merges.
    leftover : str
        "alone", "argmax" or "linkage"; see `consensus.settle_leftovers`. Thesis: "alone".
    join_planes : bool
        Whether pieces of one wall or floor are joined, those that don't touch too. Thesis: no.
    relief : float
        What stands out of a wall or floor by a step of this height (units of the scene) is a segment of
        its own: doors, pictures, carpets. 0 leaves them with the wall, as in the thesis.
    contrast : float
        Where the scan has colours, what differs in tint from the wall or floor round it by so much is a
        segment of its own, too; see `Items.face_tints`. 0 looks at no colours, as in the thesis.
    furniture_similarity : float
        Mean co-association down to which segments that touch are joined where they are no wall, floor or
        ceiling: a cut that keeps doors from walls leaves sofas in pieces. 1 joins none. Thesis: 1.
    min_area : float
        Segments below this area (square units of the scene) go to a neighbour. Thesis: 0.
    granularity : int, optional
        Cut the nested family of segmentations (see `Pipeline.family`) that runs through the result where it
        has so many segments, or as near as it gets. None: the result as it is.
    seed : int
        Same seed, same labels, whatever the number of threads.

    Examples
    --------
    >>> import scenewidget as sw
    >>> params = sw.Params(n_segments=30)
    >>> params.replace(seed=1).k_bounds
    (60, 75)
    >>> sw.Params.thesis().consensus
    'peac'
    >>> sw.Params(n_segment=30)
    Traceback (most recent call last):
        ...
    TypeError: Params has no option 'n_segment'; did you mean 'n_segments'?
    """

    n_segments: int | Literal["auto"] = "auto"
    k_range: tuple[int, int] | None = None
    cost_exponent: float = 1.0
    cost_a: float = 1.0
    cost_b: float = -1.0
    feature: Feature = "normals"
    items: ItemKind = "superfacets"
    scale: float | Literal["auto"] = "auto"
    n_items: int = 6_000
    item_area: float = 0.003
    simplifier: Simplifier = "fast"
    drop_torn: bool = False
    tolerance: float = 2.0
    orientation: Orientation = "auto"
    filter_sweeps: int | Literal["auto"] = "auto"
    bridge: float = 0.06
    n_slots: int = 64
    slot_mapping: SlotMapping = "linear"
    dihedral_order: Literal["index", "area"] = "index"
    laplacian: Literal["cotangent", "robust"] = "cotangent"
    n_eigenpairs: int = 50
    feature_floor: float = 0.05
    hop: float = 0.02
    convex_weights: tuple[float, ...] = (0.05, 0.2, 1.0)
    n_runs: int = 30
    n_graph_runs: int = 160
    init: MemberInit = "even"
    medoid_ties: Ties = "stay"
    allocation: Allocation = "faces"
    merge: bool = False
    merge_flatness: float = 0.008
    merge_normal: float = 0.99
    merge_seam: float = 0.99
    consensus: Consensus = "linkage"
    linkage_similarity: float = 0.6
    leftover: Leftover = "alone"
    join_planes: bool = True
    relief: float = 0.008
    contrast: float = 0.15
    furniture_similarity: float = 0.4
    min_area: float = 0.02
    granularity: int | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, self._checked(field.name, getattr(self, field.name)))
        if self.n_runs + self.n_graph_runs < 1:
            raise ValueError("n_runs + n_graph_runs must be at least 1: an ensemble needs a member")

    @classmethod
    def thesis(cls, n_segments: int | Literal["auto"] = 50, **changes: Any) -> Params:
        """The faithful preset, δ_cot with f2 unless told otherwise (thesis 4.2).

        Every step is as the thesis has it but for the following; `.github/FIDELITY.md` has all steps, with
        tests and figures.

        - ``simplifier="fast"``, another program for quadric error metrics than Garland's QSlim: its 1 − RI
          is no higher on any of our scans, .0425 against .0625 on a bedroom, in a third of the time.
          ``"qslim"`` is libigl's.
        - ``drop_torn=False``: the 1 % rule counts what comes from one component of the scan, not connected
          pieces of the simplified mesh. QSlim tears off next to nothing (on a noisy bedroom the rule to the
          letter costs 163 of 10 000 faces), "fast" does (2 177). ``True`` is to the letter.
        - ``tolerance=2.0``: faces of the scan farther from the simplified mesh than two mean face widths
          stay unlabeled; the thesis says it of parts that were eliminated.
        - A component that the simplifier tore is one graph again: pieces are neighbours where they are
          nearest to neighbouring faces of the scan. GPS looks at each piece by itself.
        - ``n_runs=50``: the thesis does not state the size of its ensemble.
        - PEAC's objective is minimised by a solver of our own instead of Rota Bulò's; see `peac`.
        - A medoid keeps its own label where another one is at distance 0; distances are float32, the two
          directions of a path may differ by 5e-7.
        - A scan that is inside out is turned (``orientation``); f1 and f2 don't notice.

        Parameters
        ----------
        n_segments : int or "auto"
            S. "auto" is no part of the thesis.
        **changes
            Other fields, as of `replace`.

        Examples
        --------
        >>> import scenewidget as sw
        >>> params = sw.Params.thesis(n_segments=30, feature="gps")
        >>> params.k_bounds, params.medoid_ties
        ((60, 75), 'first')
        """
        preset: dict[str, Any] = {
            "n_segments": n_segments,
            "cost_exponent": 1.5,
            "feature": "cotangent",
            "items": "simplified",
            "scale": 1.0,
            "n_items": 10_000,
            "feature_floor": 0.0,
            "hop": 0.0,
            "convex_weights": (1.0,),
            "n_runs": 50,
            "n_graph_runs": 0,
            "init": "random",
            "medoid_ties": "first",
            "allocation": "dihedral",
            "merge": True,
            "consensus": "peac",
            "join_planes": False,
            "relief": 0.0,
            "contrast": 0.0,
            "furniture_similarity": 1.0,
            "min_area": 0.0,
        }
        return cls().replace(**(preset | changes))

    def replace(self, **changes: Any) -> Params:
        """A copy with some options changed.

        Raises
        ------
        TypeError
            A name that is no option; the message suggests the nearest one.
        ValueError
            A value out of range.
        """
        _check_names(changes, [field.name for field in dataclasses.fields(self)])
        return dataclasses.replace(self, **changes)

    @property
    def k_bounds(self) -> tuple[int, int]:
        """The k-range in force: as given, or (2S, 2.5S)."""
        if self.k_range is not None:
            return self.k_range
        s = 50 if self.n_segments == "auto" else self.n_segments
        return 2 * s, (5 * s) // 2

    @staticmethod
    def _checked(name: str, value: Any) -> Any:
        if name in CHOICES:
            if value not in CHOICES[name]:
                options = ", ".join(map(repr, CHOICES[name]))
                raise ValueError(f"{name} must be one of {options}, got {value!r}")
            return value
        if name in ("merge", "join_planes", "drop_torn"):
            if not isinstance(value, bool):
                raise TypeError(f"{name} must be True or False, got {value!r}")
            return value
        if name in ("n_segments", "scale", "filter_sweeps") and isinstance(value, str) and value == "auto":
            return value
        if name == "n_segments":
            return _whole(name, value, 1, 10_000)
        if name == "granularity":
            return value if value is None else _whole(name, value, 1, 1_000_000)
        if name == "k_range":
            return value if value is None else _k_range(value)
        if name == "convex_weights":
            return _convex_weights(value)
        low, high = _RANGES[name]
        if name.startswith("n_") or name in ("filter_sweeps", "seed"):
            return _whole(name, value, low, high)
        if isinstance(value, bool) or not hasattr(value, "__float__") or isinstance(value, str):
            raise TypeError(f"{name} must be a number, got {value!r}")
        if not low <= float(value) <= high or math.isinf(float(value)):
            raise ValueError(f"{name} must lie in {low}..{high}, got {value}")
        return float(value)


def _whole(name: str, value: Any, low: float, high: float) -> int:
    number = checked_whole(name, value)
    if not low <= number <= high:
        raise ValueError(f"{name} must lie in {low:g}..{high:g}, got {value}")
    return number


def _k_range(value: Any) -> tuple[int, int]:
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise TypeError(f"k_range must be None or two whole numbers (least, most), got {value!r}")
    least, most = (_whole("k_range", k, 1, 40_000) for k in value)
    if least > most:
        raise ValueError(f"k_range must be (least, most), got {value!r}")
    return least, most


def _convex_weights(value: Any) -> tuple[float, ...]:
    if not isinstance(value, (tuple, list)) or not value:
        raise TypeError(f"convex_weights must be a tuple of numbers, got {value!r}")
    if not all(isinstance(w, (int, float)) and 0 < w < math.inf for w in value):
        raise ValueError(f"convex_weights must be positive numbers, got {value!r}")
    return tuple(float(w) for w in value)
