"""k-medoids against scikit-learn-extra's KMedoids, the same algorithm by others.

Its last release works with numpy < 2 and Python 3.11 only, so it gets an environment of its own in
pytest's cache, made once.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from scenewidget.engine.kmedoids import alternate, initial_medoids, k_medoids

ROOT = Path(__file__).parents[2]
ORACLE = ROOT / "tests" / "oracles" / "sklearn_extra.py"
PACKAGES = ["scikit-learn-extra==0.3.0", "numpy<2", "scipy", "numba"]


def give_up(why):
    """Under CI the comparison has to happen; elsewhere it is skipped where it can't."""
    if os.environ.get("CI"):
        pytest.fail(f"scikit-learn-extra could not be installed: {why}")
    pytest.skip(f"NOT COMPARED with scikit-learn-extra: {why}")


@pytest.fixture(scope="module")
def oracle_python(request):
    """Interpreter of an environment with scikit-learn-extra and numpy < 2."""
    python = sys.executable if sys.version_info[:2] == (3, 11) else shutil.which("python3.11")
    if python is None:
        pytest.skip("NOT COMPARED with scikit-learn-extra: its wheels need a python3.11, and there is none")
    folder = Path(request.config.cache.mkdir("sklearn-extra-py311"))
    inside = folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
    works = [str(inside), "-c", "import numba, sklearn_extra.cluster"]
    if not inside.exists() or subprocess.run(works, capture_output=True, check=False).returncode:
        shutil.rmtree(folder / "venv", ignore_errors=True)
        pip = [str(inside), "-m", "pip", "install", "-q", "--retries", "1", "--timeout", "15", *PACKAGES]
        for command in ([python, "-m", "venv", str(folder / "venv")], pip, works):
            done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
            if done.returncode:
                give_up((done.stderr or done.stdout).strip()[-500:])
    return str(inside)


def problem(seed):
    """Distances of random points, no two equal, and k."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(5, 300))
    points = rng.normal(size=(n, 2))
    D = np.linalg.norm(points[:, None] - points, axis=2)
    return D, int(rng.integers(1, min(n, 40)))


@pytest.fixture(scope="module")
def answers(oracle_python, tmp_path_factory):
    """What scikit-learn-extra says to 20 problems."""
    folder = tmp_path_factory.mktemp("sklearn-extra")
    given = {"count": 20}
    for i in range(20):
        D, k = problem(i)
        given |= {f"D_{i}": D, f"start_{i}": initial_medoids(D, k, seed=i), f"seed_{i}": i}
    np.savez(folder / "problems.npz", **given)
    command = [
        oracle_python,
        str(ORACLE),
        str(folder / "problems.npz"),
        str(folder / "answers.npz"),
        str(ROOT),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return np.load(folder / "answers.npz")


def test_the_oracle_runs_on_the_numpy_that_it_was_built_for(answers):
    assert str(answers["numpy"]).startswith("1.")


@pytest.mark.parametrize("i", range(20))
def test_from_the_same_start_both_end_in_the_same_fixed_point(answers, i):
    D, k = problem(i)
    ours = alternate(D, initial_medoids(D, k, seed=i))
    np.testing.assert_array_equal(ours.medoids, answers[f"medoids_{i}"])
    np.testing.assert_array_equal(ours.labels, answers[f"labels_{i}"])


@pytest.mark.parametrize("i", range(20))
def test_the_backend_gives_the_same_result_as_ours(answers, i):
    D, k = problem(i)
    ours = k_medoids(D, k, seed=i)
    np.testing.assert_array_equal(answers[f"ours_medoids_{i}"], ours.medoids)
    np.testing.assert_array_equal(answers[f"ours_labels_{i}"], ours.labels)
    assert float(answers[f"ours_cost_{i}"]) == pytest.approx(ours.cost, rel=1e-12)


def test_without_the_package_the_backend_says_what_to_install():
    try:
        import sklearn_extra  # noqa: F401  where it can be imported there is nothing to say
    except ImportError:
        with pytest.raises(ImportError, match=r'pip install "scikit-learn-extra==0\.3\.0" "numpy<2"'):
            k_medoids(np.zeros((2, 2)), 1, backend="sklearn-extra")
