"""Does doubt find errors, and do suggestions pay? Real development scans and simulated ones, apart.

    python tests/benchmarks/doubt.py [--kinds real judging] [--scans kitchen_25mm] [--no-looks] [--cache DIR]
    python tests/benchmarks/doubt.py --left-out

Real are the annotated scans beside the repository; they took no part in `python -m scenewidget.calibrate`,
nor did the simulated ones of `rooms`. Columns:

faces: AUC of 1 − confidence for faces being wrong, the same of a small area of the segment, the first within
    fifths of the faces by area, the share of wrong faces, expected calibration error, and the standard
    deviation of the confidence.
borders: AUC and average precision of p_same for the two being mostly one thing, beside the share that are,
    and calibration error; the last row pools them. cuts: the same of p_two.
suggestions: of the first 20 (fewer where there are fewer) the share that lowers 1 − RI, each on its own, what
    joins one segment in one look counting once;
    1 − RI before, after a person who looks at 20 one by one and accepts the right ones, and after the 20 best
    edits with the truth; the share of the gain of these; looks until 1 − RI is a fifth lower, suggested, at
    random, and with the truth; milliseconds from an answer to the next suggestion.
left out: the models fitted on the simulated rooms of all scanners but one, on those of that one, and on the
    real scans; beside the shipped numbers.
names: how many segments `suggest_names` names, and the share that the truth calls so, where it has names.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from rooms import DATA, HALVES, scans

import scenewidget as sw
from scenewidget.calibrate import KINDS, Example, count_things, fit, simulated, wrong_faces
from scenewidget.editing import Edit, EditError, Merge, Session, Suggestion
from scenewidget.editing.annotator import Judge
from scenewidget.engine.doubt import FITTED, Models, doubts
from scenewidget.engine.mesh import face_adjacency

REAL = ("kitchen_12mm", "kitchen_25mm", *(f"tabletop_{i}" for i in range(1, 7)))
SHARE, MOST = 0.8, 300  # target of the looks, and when they end

Array = np.ndarray


def auc(score: Array, is_so: Array, weights: Array | None = None) -> float:
    """Probability that what is so has the higher score than what isn't; ties count half."""
    weights = np.ones(len(score)) if weights is None else weights
    rank = np.unique(score, return_inverse=True)[1]
    n = int(rank.max(initial=-1)) + 1
    yes, no = np.bincount(rank, weights * is_so, n), np.bincount(rank, weights * ~is_so, n)
    total = yes.sum() * no.sum()
    return float((yes * (np.cumsum(no) - no / 2)).sum() / total) if total > 0 else np.nan


def calibration(p: Array, is_so: Array, weights: Array | None = None, n_bins: int = 10) -> float:
    """Expected calibration error."""
    weights = np.ones(len(p)) if weights is None else weights
    place = np.minimum((p * n_bins).astype(int), n_bins - 1)
    miss = np.bincount(place, weights * (p - is_so), n_bins)
    return float(np.abs(miss).sum() / max(weights.sum(), 1e-12))


def average_precision(p: Array, is_so: Array) -> float:
    """Mean precision at each that is so, the likeliest first."""
    hit = is_so[np.argsort(-p, kind="stable")]
    return float((np.cumsum(hit) / np.arange(1, len(hit) + 1))[hit].mean()) if hit.any() else np.nan


def judged_faces(made: sw.Segmentation, truth: Array) -> dict[str, float]:
    """The row of the faces."""
    pieces = made.find_doubt().pieces
    things = count_things(pieces, truth)
    is_foreign, is_rest = wrong_faces(pieces, things)
    rows, columns = np.nonzero(things)
    weights, wrong = things[rows, columns], (is_foreign | is_rest)[rows, columns]
    doubt = 1.0 - made.confidence[pieces.first_face[rows]].astype(float)
    small = -np.bincount(pieces.segment, pieces.moments.area)[pieces.segment[rows]]
    order = np.argsort(small, kind="stable")
    fifth = np.empty(len(order), int)
    fifth[order] = np.minimum(5 * (np.cumsum(weights[order]) - weights[order] / 2) / weights.sum(), 4)
    within = [auc(doubt[fifth == k], wrong[fifth == k], weights[fifth == k]) for k in range(5)]
    counted = [
        min((weights * wrong)[fifth == k].sum(), (weights * ~wrong)[fifth == k].sum()) > 1e-3 * weights.sum()
        for k in range(5)
    ]
    within = [value for value, counts in zip(within, counted) if counts]
    mean = np.average(doubt, weights=weights)
    return {
        "AUC": auc(doubt, wrong, weights),
        "area": auc(small, wrong, weights),
        "fifths": float(np.mean(within)) if within else np.nan,
        "wrong": float(np.average(wrong, weights=weights)),
        "ECE": calibration(doubt, wrong, weights),
        "spread": float(np.sqrt(np.average((doubt - mean) ** 2, weights=weights))),
    }


def outcomes(made: sw.Segmentation, truth: Array) -> tuple[Array, Array, Array, Array]:
    """p_same and whether it is so; p_two and whether it is so."""
    keep = (made.labels >= 0) & (truth >= 0)
    table = np.zeros((made.n_segments, int(truth.max()) + 1))
    np.add.at(table, (made.labels[keep], truth[keep]), 1)
    borders = made.borders()
    first, second = borders["first"].to_numpy(), borders["second"].to_numpy()
    is_known = table.sum(axis=1) > 0
    known = is_known[first] & is_known[second]
    same = table.argmax(axis=1)[first] == table.argmax(axis=1)[second]
    p_two, two = [], []
    for row in made.cuts().itertuples():
        small = np.bincount(truth[row.faces][truth[row.faces] >= 0], minlength=table.shape[1])
        large = table[row.segment] - small
        if small.sum() and large.sum():
            p_two.append(row.p_two)
            two.append(small.argmax() != large.argmax())
    return borders["p_same"].to_numpy()[known], same[known], np.array(p_two), np.array(two, bool)


def pair_scores(p: Array, is_so: Array) -> dict[str, float]:
    """A row of borders or cuts."""
    return {
        "n": len(p),
        "AUC": auc(p, is_so) if len(p) else np.nan,
        "AP": average_precision(p, is_so),
        "are so": float(is_so.mean()) if len(p) else np.nan,
        "ECE": calibration(p, is_so) if len(p) else np.nan,
    }


# --- suggestions ----------------------------------------------------------------------------------


def suggested(session: Session) -> Iterator[Suggestion]:
    """What the session suggests; what was not followed is dismissed."""
    while found := session.suggestions(1):
        n_edits = len(session.edits)
        yield found[0]
        if len(session.edits) == n_edits:
            session.dismiss(found[0])


def at_random(session: Session, rng: np.random.Generator, pairs: Array) -> Iterator[Edit]:
    """Neighbours without a choice: whole segments, and base segments, in equal parts."""
    base = session.automatic.level("base")
    base_pairs = np.unique(base[pairs], axis=0)
    face = np.zeros(int(base.max()) + 1, int)
    face[base] = np.arange(len(base))
    while True:
        segment = session.atom_segments[session.atoms.face_atom[face]]
        ends = np.sort(segment[base_pairs], axis=1)
        crossing = (ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1) & (base_pairs >= 0).all(axis=1)
        if rng.random() < 0.5:
            unique = np.unique(ends[crossing], axis=0)
            chosen = unique[rng.integers(len(unique))]
            k = rng.choice(np.flatnonzero((ends == chosen).all(axis=1)))
            level = "final"
        else:
            k, level = rng.choice(np.flatnonzero(crossing)), "base"
        part, onto = rng.permutation(base_pairs[k])
        yield Merge((int(face[part]),), int(face[onto]), level)


def looked_at(
    made: sw.Segmentation, truth: Array, propose: Callable[[Session], Iterator[Suggestion | Edit]]
) -> tuple[list[float], float]:
    """1 − RI after each look of a person who accepts what lowers it, and milliseconds to the next."""
    session = Session(made.mesh, made)
    judge = Judge(session, truth)
    errors, seconds = [judge.error], []
    proposals = propose(session)
    while (len(errors) <= MOST and errors[-1] > SHARE * errors[0]) or len(errors) <= 20:
        start = time.perf_counter()
        found = next(proposals, None)
        seconds.append(time.perf_counter() - start)
        if found is None:
            break
        try:
            session.do(found.edit if isinstance(found, Suggestion) else found)
        except EditError:
            errors.append(errors[-1])
            continue
        judge.look()
        if judge.error < errors[-1]:
            errors.append(judge.error)
        else:
            errors.append(errors[-1])
            session.undo()
    return errors, 1e3 * float(np.median(seconds[1:] or seconds))


def with_truth(made: sw.Segmentation, truth: Array, n: int = 20) -> list[float]:
    """1 − RI after each of the n edits that lower it most."""
    session = Session(made.mesh, made)
    judge = Judge(session, truth)
    errors = [judge.error]
    while len(errors) <= n and (edit := judge.best_edit()) is not None:
        session.do(edit)
        judge.look()
        errors.append(judge.error)
    return errors


def looks(errors: list[float]) -> float:
    """How many it took to the target; NaN where it wasn't reached."""
    there = np.flatnonzero(np.array(errors) <= SHARE * errors[0])
    return float(there[0]) if len(there) else np.nan


def judged_suggestions(made: sw.Segmentation, truth: Array) -> dict[str, float]:
    """The row of the suggestions."""
    session = Session(made.mesh, made)
    judge = Judge(session, truth)
    start, right = judge.error, []
    for suggestion in session.suggestions(20):
        session.do(suggestion.edit)
        judge.look()
        right.append(judge.error < start)
        session.undo()
    ours, milliseconds = looked_at(made, truth, suggested)
    pairs = face_adjacency(made.mesh)
    random = [
        looks(looked_at(made, truth, lambda s, r=rng: at_random(s, r, pairs))[0])
        for rng in (np.random.default_rng(seed) for seed in range(2))
    ]
    best = with_truth(made, truth)
    after = ours[min(20, len(ours) - 1)]
    return {
        "of": len(right),
        "right": float(np.mean(right)) if right else np.nan,
        "before": start,
        "after": after,
        "best": best[-1],
        "gain": (start - after) / max(start - best[-1], 1e-12),
        "looks": looks(ours),
        "random": float(np.mean([MOST if np.isnan(n) else n for n in random])),
        "truth": looks(best),
        "ms": milliseconds,
    }


def judged_names(made: sw.Segmentation, truth: Array, words: tuple[str, ...]) -> dict[str, float]:
    """Names offered, and the share that is right."""
    right = []
    for segment, (name, _) in made.suggest_names().items():
        inside = truth[(made.labels == segment) & (truth >= 0)]
        right.append(len(inside) > 0 and name in words[np.bincount(inside).argmax()].lower())
    return {"named": len(right), "right": float(np.mean(right)) if right else np.nan}


# --- what transfers -------------------------------------------------------------------------------


def examples_of_real() -> dict[str, Example]:
    """The annotated scans as what is fitted to."""
    found = {}
    for _, name, mesh, truth, _ in every_scan(["real"], None, Path()):
        made = sw.segment(mesh)
        pieces = made.find_doubt().pieces
        found[name] = Example(pieces, made.keys, dict(made.report["runs"]), count_things(pieces, truth))
    return found


def scores(examples: list[Example], models: Models) -> dict[str, float]:
    """Borders pooled, and the mean of the faces, under some models."""
    p, same, of_faces = [], [], []
    for e in examples:
        found = doubts(e.pieces, e.keys, e.runs, models=models)
        table = np.zeros((len(found.two), e.things.shape[1]))
        np.add.at(table, e.pieces.segment, e.things)
        ends, is_known = (found.borders.first, found.borders.second), table.sum(axis=1) > 0
        keep = is_known[ends[0]] & is_known[ends[1]]
        p.append(found.same[keep])
        same.append((table.argmax(axis=1)[ends[0]] == table.argmax(axis=1)[ends[1]])[keep])
        is_foreign, is_rest = wrong_faces(e.pieces, e.things)
        rows, columns = np.nonzero(e.things)
        wrong = (is_foreign | is_rest)[rows, columns]
        of_faces.append(auc(found.wrong[rows], wrong, e.things[rows, columns]))
    pooled = pair_scores(np.concatenate(p), np.concatenate(same))
    names = {"n": "borders", "AUC": "AUC", "ECE": "ECE"}
    return {**{names[k]: pooled[k] for k in names}, "faces AUC": float(np.nanmean(of_faces))}


def left_out(examples: list[Example], real: list[Example]) -> pd.DataFrame:
    """Its rooms and the real scans by a fit that never saw a scanner, and by the shipped one."""
    rows = {}
    for kind in dict.fromkeys(KINDS):
        is_kind = [KINDS[k % len(KINDS)] == kind for k in range(len(examples))]
        rooms = [e for e, is_so in zip(examples, is_kind) if is_so]
        models = fit([e for e, is_so in zip(examples, is_kind) if not is_so])
        for of, where in (("its rooms", rooms), ("real", real)):
            if where:
                rows[f"{kind}: {of}, left out"] = scores(where, models)
                rows[f"{kind}: {of}, shipped"] = scores(where, FITTED)
    return pd.DataFrame(rows).T


# --- scans ----------------------------------------------------------------------------------------


def every_scan(
    kinds: list[str], names: list[str] | None, cache: Path
) -> Iterator[tuple[str, str, sw.Mesh, Array, tuple[str, ...]]]:
    """Kind, name, mesh, truth and its names; what isn't there is left out with a word."""
    if "real" in kinds:
        for name in REAL:
            file = DATA / "real" / f"{name}.npz"
            if names and name not in names:
                continue
            if not file.exists():
                print(f"{name}: not there, left out")
                continue
            kept = np.load(file)
            mesh = sw.Mesh(kept["vertices"], kept["faces"], kept["colors"])
            yield "real", name, mesh, kept["instances"].astype(np.int64), ()
    for half in HALVES:
        if half in kinds:
            for scan in scans(names, [half], cache):
                yield half, scan.name, scan.mesh, scan.truth.labels.astype(np.int64), tuple(scan.truth.names)


def main() -> None:
    """Print a table a kind and question."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kinds", nargs="+", choices=["real", *HALVES], default=["real", "judging"])
    parser.add_argument("--scans", nargs="+")
    parser.add_argument("--no-looks", action="store_true", help="leave suggestions out")
    parser.add_argument("--left-out", action="store_true", help="what a fit tells of a scanner it never saw")
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "scenewidget-quality")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    if arguments.left_out:
        print(left_out(list(simulated(28)), list(examples_of_real().values())).round(3).to_string())
        return
    tables: dict[str, dict[str, dict[str, dict[str, float]]]] = {}
    pools: dict[str, list[tuple[Array, Array, Array, Array]]] = {}
    for kind, name, mesh, truth, words in every_scan(arguments.kinds, arguments.scans, arguments.cache):
        made = sw.segment(mesh)
        table = tables.setdefault(
            kind, {"faces": {}, "borders": {}, "cuts": {}, "suggestions": {}, "names": {}}
        )
        if words:
            table["names"][name] = judged_names(made, truth, words)
        table["faces"][name] = judged_faces(made, truth)
        pools.setdefault(kind, []).append(outcomes(made, truth))
        table["borders"][name] = pair_scores(*pools[kind][-1][:2])
        table["cuts"][name] = pair_scores(*pools[kind][-1][2:])
        if not arguments.no_looks:
            table["suggestions"][name] = judged_suggestions(made, truth)
        print(f"{kind}: {name}", flush=True)
    for kind, table in tables.items():
        pooled = [np.concatenate(column) for column in zip(*pools[kind])]
        for question, rows in table.items():
            frame = pd.DataFrame(rows).T
            if not len(frame):
                continue
            frame.loc["mean"], frame.loc["least"] = frame.mean(), frame.min()
            if question == "borders":
                frame.loc["pooled"] = pair_scores(*pooled[:2])
            elif question == "cuts":
                frame.loc["pooled"] = pair_scores(*pooled[2:])
            elif question == "suggestions":
                rows_ = frame.iloc[:-2]
                frame.loc["pooled", "right"] = (rows_["right"] * rows_["of"]).sum() / rows_["of"].sum()
            print(f"\n{kind}, {question}\n{frame.round(3).to_string()}")


if __name__ == "__main__":
    main()
