"""scikit-learn-extra's KMedoids on problems from a file, in an environment of its own (numpy < 2).

python sklearn_extra.py problems.npz answers.npz REPOSITORY

``problems.npz`` holds D_i and start_i; the answers are labels_i, medoids_i of ``KMedoids`` itself and
ours_labels_i, ours_medoids_i of ``scenewidget`` with ``backend="sklearn-extra"`` and k = len(start_i).
"""

from __future__ import annotations

import importlib.util
import sys
import types
from pathlib import Path

import numpy as np

# this file bears the library's name: Python would find it first in its own folder
sys.path[:] = [p for p in sys.path if Path(p or ".").resolve() != Path(__file__).parent]

from sklearn_extra.cluster import KMedoids  # noqa: E402


class FromGivenMedoids(KMedoids):
    """KMedoids that starts where it is told."""

    def _initialize_medoids(self, *_args, **_options):
        return self.start


def load_kmedoids(repository: Path):
    """Our module alone: it needs numpy and numba at most, the rest of the engine needs numpy 2."""
    for name in ("scenewidget", "scenewidget.engine"):
        package = types.ModuleType(name)
        package.__path__ = [str(repository.joinpath(*name.split(".")))]
        sys.modules[name] = package
    name = "scenewidget.engine.kmedoids"
    spec = importlib.util.find_spec(name)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def main() -> None:
    """Answer all problems."""
    problems, repository = np.load(sys.argv[1]), Path(sys.argv[3])
    kmedoids = load_kmedoids(repository)
    answers = {"numpy": np.__version__}
    for i in range(int(problems["count"])):
        D, start = problems[f"D_{i}"], problems[f"start_{i}"]
        model = FromGivenMedoids(len(start), metric="precomputed", method="alternate", max_iter=100)
        model.start = start.astype(np.int64)
        model.fit(D)
        answers[f"labels_{i}"], answers[f"medoids_{i}"] = model.labels_, model.medoid_indices_
        result = kmedoids.k_medoids(D, len(start), seed=int(problems[f"seed_{i}"]), backend="sklearn-extra")
        answers[f"ours_labels_{i}"], answers[f"ours_medoids_{i}"] = result.labels, result.medoids
        answers[f"ours_cost_{i}"] = result.cost
    np.savez(sys.argv[2], **answers)


if __name__ == "__main__":
    main()
