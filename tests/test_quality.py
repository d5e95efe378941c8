"""The rules that tools can hold: style, types, the direction of imports, a fast start."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from vulture import Vulture

ROOT = Path(__file__).parent.parent

ONE_SET_OF_STUBS = pytest.mark.skipif(
    sys.version_info[:2] != (3, 11) or np.__version__ < "2",
    reason="what NumPy says of its types differs by version; checked with the newest for Python 3.11",
)


@pytest.mark.parametrize(
    "command",
    [
        ["ruff", "check", "."],
        ["ruff", "format", "--check", "."],
        pytest.param(["mypy"], marks=ONE_SET_OF_STUBS),
        ["lint-imports"],
    ],
    ids=" ".join,
)
def test_the_tree_passes(command):
    tool = Path(sys.executable).parent / command[0]
    done = subprocess.run([tool, *command[1:]], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


CALLED_FROM_OUTSIDE = {
    "__getattr__",  # of modules: Python
    "BundleHook", "initialize", "build_data",  # hatchling
    "doctype", "pubid", "system",  # the XML parser
    "_initialize_medoids",  # scikit-learn-extra
    "automatic_value",  # the browser, which spells it in its own way
    "_cache", "on_start", "on_end",  # numba
    "bar_style", "klass",  # ipywidgets, traitlets
    "viewpoint",  # whoever reads a scan with `readers`
    "look_from_above", "look_from_inside",  # scripts, as buttons are for hands
}  # fmt: skip


def test_no_code_is_dead():
    """What the package defines is named a second time in it, or by its JavaScript, a test or a notebook."""
    found = Vulture(ignore_decorators=["@traitlets.*", "@atexit.register"])
    found.scavenge([ROOT / "scenewidget"])
    others = [*ROOT.glob("scenewidget/js/src/**/*.js"), *ROOT.glob("notebooks/*.ipynb"), ROOT / "README.md"]
    others += ROOT.glob("tests/**/*.py")
    named = set(re.findall(r"\w+", "\n".join(path.read_text() for path in others)))
    dead = [item for item in found.get_unused_code() if item.name not in named | CALLED_FROM_OUTSIDE]
    assert [f"{item.filename}:{item.first_lineno} {item.name}" for item in dead] == []


def test_importing_is_light():
    code = (
        "import sys; import scenewidget; "
        "heavy = {'numba', 'scipy', 'IPython', 'ipywidgets', 'anywidget', 'pythreejs', 'trimesh', 'pandas'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_engine_runs_without_jupyter():
    code = (
        "import sys; import scenewidget.engine.pipeline; "
        "print(sorted({'IPython', 'ipywidgets', 'anywidget', 'pythreejs', 'traitlets'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there():
    import scenewidget

    for name in scenewidget.__all__:
        assert getattr(scenewidget, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'segmnt'"):
        _ = scenewidget.segmnt


def test_the_modules_of_the_engine_are_there_without_being_imported_one_by_one():
    code = (
        "import scenewidget as sw; import scipy.sparse as sp; "
        "print(sw.engine.distances.all_pairs(sp.csr_array([[0, 2.0], [2.0, 0]])).tolist()); "
        "print('peac' in dir(sw.engine))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == ["[[0.0, 2.0], [2.0, 0.0]]", "True"]
