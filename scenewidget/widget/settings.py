"""What there is to set: each option of `Params` with its words, its input, and when it has no effect.

Goes in: `Params`. Come out: descriptions that the browser makes inputs of, reasons why an option does nothing
under the present others, and the Python that makes these parameters.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from scenewidget.engine.params import CHOICES, Params

__all__ = ["PRESETS", "SETTINGS", "Setting", "changes_from", "idle_reasons", "nearest_preset", "params_code"]

Kind = Literal["slider", "range", "number", "choice", "check", "list", "family"]

PRESETS: Mapping[str, Params] = {"Default": Params(), "Thesis": Params.thesis()}
DISABLED = {  # choices that can't be made here, and why
    "given": "only with features: sw.segment(mesh, params, features=…)",
}
CODE = {"Default": "sw.Params", "Thesis": "sw.Params.thesis"}
FREE = (
    "n_segments",
    "granularity",
    "seed",
)  # options that belong to no preset: whoever changes them does not leave it


@dataclass(frozen=True)
class Setting:
    """An input for one option.

    Examples
    --------
    >>> next(setting for setting in SETTINGS if setting.name == "n_segments").label
    'Segments S'
    """

    name: str
    label: str
    tip: str  # one sentence
    kind: Kind
    group: str = ""  # "" is always on view, others are folded away
    low: float | None = None
    high: float | None = None
    step: float | None = None
    automatic: str = ""  # text of a box that leaves the value to the program
    automatic_value: Any = None

    def to_json(self) -> dict[str, Any]:
        """As the browser takes it."""
        words = {"automaticValue" if k == "automatic_value" else k: v for k, v in vars(self).items()}
        if self.kind == "choice":
            words["choices"] = [
                [value, _text(value), DISABLED.get(value, "")] for value in CHOICES[self.name]
            ]
        return {k: v for k, v in words.items() if v is not None or k == "automaticValue"}


def _text(value: str) -> str:
    return {"gps": "GPS", "hks": "HKS", "wks": "WKS", "peac": "PEAC"}.get(value, value.capitalize())


MAIN = (
    Setting(
        "granularity", "Granularity", "How many segments: joins or divides those of this result, at once.",
        "family", low=1, high=2, step=1, automatic="as computed",
    ),
    Setting(
        "n_segments", "Segments S", "How many segments there are; automatic: as many as the runs agree on.",
        "slider", low=2, high=200, step=1, automatic="automatic", automatic_value="auto",
    ),
    Setting(
        "k_range", "k-range",
        "Least and most clusters of a k-medoids run: more clusters see finer things; "
        "automatic: 2S to 2.5S, or 100 to 125 where S is automatic.",
        "range", low=2, high=500, automatic="automatic",
    ),
    Setting(
        "cost_exponent", "Cost exponent",
        "How much sharp creases count against soft ones: cost = max(A + B⟨N, N'⟩, 0)^C.",
        "slider", low=0, high=4, step=0.05,
    ),
)  # fmt: skip
FOLDED = (
    Setting("cost_a", "A", "The constant in the cost of a crease, max(A + B⟨N, N'⟩, 0)^C.",
            "number", "Distances", step=0.05),
    Setting("cost_b", "B", "What the angle between two normals counts in the cost of a crease.",
            "number", "Distances", step=0.05),
    Setting("feature", "Feature", "What neighbouring items are compared by, beside their normals.",
            "choice", "Distances"),
    Setting("laplacian", "Laplacian", "Which Laplacian the eigenfunctions behind the signatures come from.",
            "choice", "Distances"),
    Setting("n_eigenpairs", "Eigenfunctions", "How many eigenfunctions a signature is made of.",
            "number", "Distances", 1, 1000, 1),
    Setting("feature_floor", "Feature floor", "What a crease counts where the feature sees no difference.",
            "number", "Distances", 0, None, 0.01),
    Setting("hop", "Hop", "What every step costs, so that many small creases add up.",
            "number", "Distances", 0, None, 0.005),
    Setting("convex_weights", "Convex weights",
            "What convex creases count against concave ones, in turn over the runs.", "list", "Distances"),
    Setting("n_runs", "k-medoids runs", "How many k-medoids clusterings vote.", "number", "Ensemble",
            0, 10_000, 1),
    Setting("n_graph_runs", "Graph runs", "How many graph segmentations at random thresholds vote.",
            "number", "Ensemble", 0, 10_000, 1),
    Setting("seed", "Seed", "Start of the random numbers: the same seed gives the same segments.",
            "number", "Ensemble", 0, None, 1),
    Setting("init", "First medoids", "Where the runs of k-medoids start from.", "choice", "Ensemble"),
    Setting("medoid_ties", "Tied medoids", "Which of equally central items stands for a cluster.",
            "choice", "Ensemble"),
    Setting("allocation", "Shares of k", "By what separate components of the scan share out the clusters.",
            "choice", "Ensemble"),
    Setting("merge", "Merge planes", "Joins the pieces of a plane within each run before it votes.",
            "check", "Ensemble"),
    Setting("merge_flatness", "… flatness", "Largest λ2/λ0 at which a piece counts as flat.",
            "number", "Ensemble", 0, 1, 0.001),
    Setting("merge_normal", "… normals", "Least dot product of the normals of two planes that are joined.",
            "number", "Ensemble", 0, 1, 0.005),
    Setting("merge_seam", "… seam", "Least dot product of the normals on both sides of their seam.",
            "number", "Ensemble", -1, 1, 0.005),
    Setting("consensus", "Consensus", "How the votes of all runs become one segmentation.",
            "choice", "Consensus"),
    Setting("linkage_similarity", "Agreement",
            "Share of the runs that must agree, where the number is automatic.",
            "number", "Consensus", 0, 1, 0.05),
    Setting("leftover", "Leftovers", "What becomes of pieces that belong nowhere with a probability of ½.",
            "choice", "Consensus"),
    Setting("join_planes", "Join walls",
            "Joins the pieces of one wall, floor or ceiling that doors cut apart.", "check", "Consensus"),
    Setting("relief", "Relief",
            "How far, in units of the scene, a thing must stand out of its wall to come off it; 0 is never.",
            "number", "Consensus", 0, None, 0.002),
    Setting("contrast", "Contrast",
            "How much a thing must differ in tint from its wall to come off it; 0 looks at no colours.",
            "number", "Consensus", 0, None, 0.01),
    Setting("furniture_similarity", "Furniture",
            "Share of the runs that must agree for pieces of furniture that touch to be joined; 1 is never.",
            "number", "Consensus", 0, 1, 0.05),
    Setting("min_area", "Least area", "Segments of less area, in squared units of the scene, are given away.",
            "number", "Consensus", 0, None, 0.01),
    Setting("scale", "Unit of the scene",
            "Metres that lengths here count in: 1 for rooms, less for what is smaller.",
            "number", "Items", 0.001, None, 0.05, automatic="by the area", automatic_value="auto"),
    Setting("items", "Items", "What is clustered: patches of the scan, or faces of a simplified mesh.",
            "choice", "Items"),
    Setting("n_items", "Most items", "How many items there may be: more are finer and slower.",
            "number", "Items", 2, 40_000, 500),
    Setting("item_area", "Least item", "Smallest area of a patch, in square units of the scene.",
            "number", "Items", 0, None, 0.001),
    Setting("simplifier", "Simplifier", "Which program simplifies the mesh.", "choice", "Items"),
    Setting("drop_torn", "Drop torn pieces",
            "Leaves out small pieces that the simplifier tore off, as the thesis is written.",
            "check", "Items"),
    Setting("tolerance", "Map-back reach",
            "How far from the simplified mesh, in mean face widths, a face of the scan still gets a label.",
            "number", "Items", 0, None, 0.5),
    Setting("filter_sweeps", "Smoothing", "Sweeps of the filter that smooths the normals under the patches.",
            "number", "Items", 0, 1000, 5, automatic="by the edges", automatic_value="auto"),
    Setting("bridge", "Bridge", "Fragments this close, in units of the scene, count as neighbours.",
            "number", "Items", 0, None, 0.01),
    Setting("n_slots", "Dihedral slots", "How finely the level “dihedral” tells angles apart.",
            "number", "Items", 2, 100_000, 8),
    Setting("slot_mapping", "Slots by", "By what the slots for the angle between faces are alike.",
            "choice", "Items"),
    Setting("dihedral_order", "Dihedral seeds", "In which order the parts of the level “dihedral” grow.",
            "choice", "Items"),
)  # fmt: skip


def _more(name: str, value: Any) -> Setting:
    """An input for an option that has no words of its own here yet."""
    label = name.replace("_", " ").capitalize()
    kind: Kind = "choice" if name in CHOICES else "check" if isinstance(value, bool) else "number"
    return Setting(name, label, f"See help(Params): {name}.", kind, "More")


_DEFAULTS = {field.name: getattr(Params(), field.name) for field in dataclasses.fields(Params)}
_NAMED = {setting.name for setting in (*MAIN, *FOLDED)}
SETTINGS: tuple[Setting, ...] = (
    *(setting for setting in (*MAIN, *FOLDED) if setting.name in _DEFAULTS),
    *(_more(name, value) for name, value in _DEFAULTS.items() if name not in _NAMED),
)


def idle_reasons(params: Params) -> dict[str, str]:
    """Why options have no effect under the present others, by name.

    Examples
    --------
    >>> import scenewidget as sw
    >>> idle_reasons(sw.Params(consensus="linkage"))["leftover"]
    'Only PEAC leaves pieces over.'
    """
    p, why = params, {}
    has_runs = p.n_runs > 0
    if p.consensus == "median" and (p.k_range is not None or not has_runs):
        why["n_segments"] = "The median partition finds its own number."
    if not has_runs:
        no_runs = "There are no k-medoids runs."
        needs_runs = ("init", "medoid_ties", "k_range", "merge", "cost_a", "cost_b", "feature")
        for name in (*needs_runs, "convex_weights"):
            why[name] = no_runs
        if p.consensus != "peac" or p.n_segments == "auto":
            why["allocation"] = no_runs
    if not has_runs or p.feature == "normals":
        why["feature_floor"] = why.get("feature", "Normals alone have no feature to be blind.")
    if not has_runs or p.feature not in ("gps", "hks", "wks"):
        for name in ("laplacian", "n_eigenpairs"):
            why[name] = why.get("feature", "Only the signatures GPS, HKS and WKS need eigenfunctions.")
    if not (has_runs and p.merge):
        for name in ("merge_flatness", "merge_normal", "merge_seam"):
            why[name] = why.get("merge", "Planes are not merged.")
    if p.consensus != "linkage":
        why["linkage_similarity"] = "Only the linkage is cut at an agreement."
    if p.consensus != "peac":
        why["leftover"] = "Only PEAC leaves pieces over."
    if p.items == "superfacets":
        for name in ("simplifier", "drop_torn", "tolerance"):
            why[name] = "The scan is not simplified."
    else:
        for name in ("filter_sweeps", "bridge", "item_area"):
            why[name] = "It shapes patches, but the items are faces of a simplified mesh."
    return why


def nearest_preset(params: Params) -> str:
    """The preset that differs in fewest options.

    Examples
    --------
    >>> import scenewidget as sw
    >>> nearest_preset(sw.Params.thesis(n_segments=30))
    'Thesis'
    """
    return min(PRESETS, key=lambda name: len(changes_from(name, params)))


def changes_from(preset: str, params: Params) -> dict[str, Any]:
    """Options that differ from a preset, those left aside that belong to none.

    Examples
    --------
    >>> import scenewidget as sw
    >>> changes_from("Default", sw.Params(n_runs=5))
    {'n_runs': 5}
    """
    start = PRESETS[preset]
    return {
        name: getattr(params, name)
        for name in _DEFAULTS
        if name not in FREE and getattr(params, name) != getattr(start, name)
    }


def params_code(params: Params) -> str:
    """Python that makes these parameters, as short as it can be.

    Examples
    --------
    >>> import scenewidget as sw
    >>> params_code(sw.Params(n_runs=5))
    'sw.Params(n_runs=5)'
    """
    preset = nearest_preset(params)
    start = PRESETS[preset]
    changed = {name: getattr(params, name) for name in _DEFAULTS}
    options = [f"{name}={value!r}" for name, value in changed.items() if value != getattr(start, name)]
    return f"{CODE[preset]}({', '.join(options)})"
