"""The thesis' tables 4.2 to 4.6 again, beside what it printed, on the scenes of SceneNN.

Rows of table 4.2: "Ours" is ``Params.thesis()`` (f2, δ_cot) or every feature and cost function of Fig. 4.4,
"Default" our own preset, "[1] (Over-segmented)" ten thresholds, "[1] (Final)" the object discovery;
"Semi-Automatic" comes from project files that were made by hand with the editor. Columns: 1 − RI, GCE and
LCE by face count, faces that the truth or the method leaves unlabeled dropped (thesis 4.3), and in
parentheses standard deviations, over scenes in table 4.2, over thresholds in table 4.5. Küçükdemir (2020).
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import scenewidget as sw
from scenewidget import evaluation
from scenewidget.baselines import karpathy, karpathy_oversegmentations
from scenewidget.datasets.scenenn import load_scenenn

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["THESIS", "add_parser", "measure", "methods", "per_scene", "run", "summary"]

COLUMNS = {"rand_index_error": "RI", "global_consistency_error": "GCE", "local_consistency_error": "LCE"}
SEMI, OURS, OVER, FINAL = "Semi-Automatic", "Ours (f2, δ_cot)", "[1] (Over-segmented)", "[1] (Final)"
TABLES = {"4.3": SEMI, "4.4": OURS, "4.5": OVER, "4.6": FINAL}
COSTS = {"f1": {"cost_a": 1.0, "cost_b": 0.0, "cost_exponent": 1.0}, "f2": {"cost_a": 1.0, "cost_b": -1.0}}
FEATURES = {"δ_uni": "uniform", "δ_cot": "cotangent", "GPS": "gps"}

# As printed: scene -> RI, GCE, LCE. For 4.5 the means over ten thresholds.
THESIS: dict[str, dict[str, tuple[float, float, float]]] = {
    SEMI: {"016": (0.0534, 0.1699, 0.1157), "066": (0.0300, 0.1216, 0.0745)},
    OURS: {
        "016": (0.0914, 0.2860, 0.2388), "057": (0.1396, 0.4324, 0.2657), "062": (0.1030, 0.3542, 0.2536),
        "066": (0.1207, 0.5286, 0.4662), "069": (0.1380, 0.5034, 0.3897), "071": (0.1831, 0.5161, 0.3484),
        "086": (0.1166, 0.5524, 0.4329), "109": (0.1399, 0.4135, 0.3534), "207": (0.1019, 0.5090, 0.3995),
        "223": (0.1340, 0.5425, 0.3371), "227": (0.0530, 0.2197, 0.1350), "234": (0.1346, 0.2626, 0.1729),
        "243": (0.0601, 0.3400, 0.2101), "249": (0.0682, 0.2755, 0.1228), "255": (0.0922, 0.4215, 0.2473),
        "273": (0.1156, 0.4654, 0.3793), "286": (0.1202, 0.5085, 0.3745), "522": (0.1105, 0.2152, 0.1257),
    },
    OVER: {
        "016": (0.1412, 0.2740, 0.1755), "057": (0.1671, 0.3230, 0.1492), "062": (0.1128, 0.1832, 0.0532),
        "066": (0.0845, 0.2252, 0.1075), "069": (0.1754, 0.2491, 0.1052), "071": (0.1558, 0.2923, 0.1554),
        "086": (0.1104, 0.2957, 0.1166), "109": (0.0571, 0.3528, 0.1968), "207": (0.1732, 0.2732, 0.1391),
        "223": (0.1392, 0.2142, 0.1053), "227": (0.0739, 0.2024, 0.0703), "234": (0.1633, 0.2574, 0.1448),
        "243": (0.0933, 0.2377, 0.0936), "249": (0.2163, 0.1885, 0.0654), "255": (0.0599, 0.1928, 0.1084),
        "273": (0.0950, 0.3657, 0.1479), "286": (0.1767, 0.3739, 0.2076), "522": (0.3477, 0.2825, 0.1294),
    },
    FINAL: {
        "016": (0.2163, 0.3927, 0.0986), "057": (0.2179, 0.3872, 0.1391), "062": (0.3360, 0.3607, 0.1121),
        "066": (0.1257, 0.2870, 0.0787), "069": (0.2317, 0.3439, 0.1201), "071": (0.2717, 0.4410, 0.1841),
        "086": (0.2574, 0.4015, 0.1518), "109": (0.1163, 0.4517, 0.1956), "207": (0.2347, 0.4174, 0.1754),
        "223": (0.2908, 0.3029, 0.1420), "227": (0.4203, 0.2218, 0.0665), "234": (0.2883, 0.3151, 0.0990),
        "243": (0.0912, 0.3082, 0.1110), "249": (0.3897, 0.2440, 0.0771), "255": (0.1298, 0.3147, 0.1254),
        "273": (0.1460, 0.4327, 0.1444), "286": (0.2054, 0.4242, 0.2104), "522": (0.3193, 0.3549, 0.1363),
    },
}  # fmt: skip
SCENES = tuple(THESIS[OURS])
SPREADS: dict[str, tuple[float, float, float]] = {  # standard deviations of table 4.2, as printed
    SEMI: (0.0117, 0.0242, 0.0206),
    OURS: (0.0312, 0.1136, 0.1063),
    OVER: (0.1015, 0.0803, 0.0463),
    FINAL: (0.0914, 0.0663, 0.0401),
}
SPREADS_OVER: dict[str, tuple[float, float, float]] = {  # those over the thresholds, of table 4.5
    "016": (0.0755, 0.1070, 0.0372), "057": (0.0357, 0.0763, 0.0390), "062": (0.1071, 0.0642, 0.0144),
    "066": (0.0273, 0.0523, 0.0151), "069": (0.0720, 0.0581, 0.0097), "071": (0.0607, 0.0597, 0.0050),
    "086": (0.0894, 0.0724, 0.0270), "109": (0.0078, 0.0368, 0.0130), "207": (0.1063, 0.0660, 0.0388),
    "223": (0.1165, 0.0266, 0.0112), "227": (0.0460, 0.0365, 0.0082), "234": (0.0697, 0.0284, 0.0168),
    "243": (0.0762, 0.0490, 0.0135), "249": (0.1357, 0.0416, 0.0084), "255": (0.0051, 0.0342, 0.0103),
    "273": (0.0451, 0.0306, 0.0089), "286": (0.1010, 0.0519, 0.0214), "522": (0.0202, 0.0174, 0.0038),
}  # fmt: skip

Method = Callable[[sw.Mesh, str], Mapping[str, Any]]  # mesh, scene -> segmentations by name, often one


def methods(settings: str, seed: int, semi_automatic: Path | None) -> dict[str, Method]:
    """What to run on each scene: a row of Table 4.2 each."""

    def ours(**changes: Any) -> Method:
        return lambda mesh, scene: {"": sw.segment(mesh, sw.Params.thesis(seed=seed, **changes))}

    rows: dict[str, Method] = {OURS: ours()}
    if settings == "all":
        for cost, values in COSTS.items():
            for name, feature in FEATURES.items():
                rows[f"Ours ({cost}, {name})"] = ours(feature=feature, **values)
        rows["Default"] = lambda mesh, scene: {"": sw.segment(mesh, sw.Params(seed=seed))}
    rows[OVER] = lambda mesh, scene: {str(c): s for c, s in karpathy_oversegmentations(mesh).items()}
    rows[FINAL] = lambda mesh, scene: {"": karpathy(mesh)}
    if semi_automatic is not None:
        rows = {SEMI: lambda mesh, scene: _by_hand(semi_automatic, scene, mesh)} | rows
    return rows


def measure(
    scenes: Iterable[tuple[str, sw.Mesh, sw.Segmentation]], rows: Mapping[str, Method]
) -> pd.DataFrame:
    """A line for each segmentation: method, scene, setting, RI, GCE, LCE, coverage, segments, seconds."""
    import pandas as pd

    lines = []
    for scene, mesh, truth in scenes:
        for method, run in rows.items():
            start = time.perf_counter()
            found = run(mesh, scene)
            seconds = time.perf_counter() - start
            if not found:
                continue
            table = evaluation.evaluate(found, truth, mesh, metrics=list(COLUMNS)).rename(columns=COLUMNS)
            for setting, row in table.iterrows():
                line = {"method": method, "scene": scene, "setting": setting} | row.to_dict()
                lines.append(line | {"seconds": seconds / len(found)})
            print(f"{scene}  {method:<22} {seconds:6.1f} s", file=sys.stderr)
    return pd.DataFrame(lines)


def per_scene(measured: pd.DataFrame, method: str) -> pd.DataFrame:
    """One of tables 4.3 to 4.6: each scene's errors, with the deviation over settings, beside the thesis'."""
    import pandas as pd

    groups = measured[measured["method"] == method].groupby("scene")[list(COLUMNS.values())]
    means, deviations = groups.mean(), groups.std(ddof=0)
    printed = THESIS.get(method, {})
    table = pd.DataFrame(index=means.index)
    for k, column in enumerate(COLUMNS.values()):
        table[column] = [_cell(*pair) for pair in zip(means[column], deviations[column])]
        spreads = SPREADS_OVER if method == OVER else {}
        table[f"thesis {column}"] = [
            _cell(printed[scene][k], spreads[scene][k] if scene in spreads else 0.0)
            if scene in printed
            else ""
            for scene in means.index
        ]
    return table


def summary(measured: pd.DataFrame) -> pd.DataFrame:
    """Table 4.2: mean (standard deviation) over scenes and settings, beside the thesis'.

    Where only some of its scenes are there, beside the mean and deviation of what it printed for these.
    """
    import pandas as pd

    columns = list(COLUMNS.values())
    table = {}
    for method, lines in measured.groupby("method", sort=False):
        printed = THESIS.get(str(method), {})
        same = np.array([printed[s] for s in lines["scene"].unique() if s in printed])
        row = {}
        for k, column in enumerate(columns):
            row[column] = _cell(lines[column].mean(), lines[column].std(ddof=0), always=True)
            row[f"thesis {column}"] = ""
            if len(same):  # the printed deviation is of all scenes that the thesis has
                spread = SPREADS[str(method)][k] if len(same) == len(printed) else float(same[:, k].std())
                row[f"thesis {column}"] = _cell(same[:, k].mean(), spread, always=True)
        row |= {"coverage": f"{lines['coverage'].mean():.3f}", "seconds": f"{lines['seconds'].mean():.1f}"}
        table[method] = row
    return pd.DataFrame.from_dict(table, orient="index")


def find_scenes(folder: Path, wanted: Sequence[str]) -> dict[str, Path]:
    """PLY of each scene: ``016/016.ply`` or ``016.ply``."""
    found = {}
    for scene in wanted:
        for path in (folder / scene / f"{scene}.ply", folder / f"{scene}.ply"):
            if path.exists():
                found[scene] = path
                break
    return found


def _cell(mean: float, deviation: float, *, always: bool = False) -> str:
    return f"{mean:.4f} ({deviation:.4f})" if always or deviation > 0 else f"{mean:.4f}"


def _by_hand(folder: Path, scene: str, mesh: sw.Mesh) -> dict[str, Any]:
    """Segmentation of a project file ``016.swproj``, or labels ``016.npy``, one a face of the raw mesh."""
    project, labels = folder / f"{scene}.swproj", folder / f"{scene}.npy"
    if project.exists():
        with tempfile.TemporaryDirectory() as copies:  # opening a project writes that into it
            copy = shutil.copy(project, copies)
            return {"": sw.Session.open(copy, mesh).segmentation}
    return {"": np.load(labels, allow_pickle=False)} if labels.exists() else {}


def add_parser(commands: Any) -> None:
    """The command ``tables``."""
    parser = commands.add_parser(
        "tables",
        help="the thesis' tables 4.2 to 4.6 on the scenes of SceneNN",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "folder", type=Path, help="where the scenes lie: 016/016.ply with its XML, or 016.ply"
    )
    parser.add_argument("--scenes", nargs="+", default=SCENES, metavar="ID", help="default: the thesis' 18")
    parser.add_argument("--settings", choices=("thesis", "all"), default="thesis", help="all: Fig. 4.4 too")
    parser.add_argument(
        "--semi-automatic", type=Path, metavar="FOLDER", help="project files made by hand, 016.swproj …"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--csv", type=Path, help="write every measurement there")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the tables; 1 if none of the scenes is in the folder."""
    paths = find_scenes(options.folder, options.scenes)
    missing = [scene for scene in options.scenes if scene not in paths]
    if missing:
        print(f"not in {options.folder}: {', '.join(missing)}", file=sys.stderr)
    if not paths:
        print(
            f"{options.folder} holds none of the scenes; SceneNN's files are found as 016/016.ply or 016.ply "
            "(https://github.com/hkust-vgd/scenenn)",
            file=sys.stderr,
        )
        return 1
    rows = methods(options.settings, options.seed, options.semi_automatic)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # what a method doubts is not for a table
        measured = measure(((scene, *load_scenenn(path)) for scene, path in paths.items()), rows)
    print(f"\nTable 4.2, {len(paths)} of {len(SCENES)} scenes\n{summary(measured).to_string()}")
    for number, method in TABLES.items():
        if (measured["method"] == method).any():
            print(f"\nTable {number}: {method}\n{per_scene(measured, method).to_string()}")
    if options.csv is not None:
        measured.to_csv(options.csv, index=False, lineterminator="\n")
    return 0
