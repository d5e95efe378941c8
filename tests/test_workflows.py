"""What the workflows run and the citation says is what the package's metadata promise."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.specifiers import SpecifierSet

yaml = pytest.importorskip("yaml", reason="pip install pyyaml")

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def read(path):
    return yaml.safe_load(path.read_text("utf-8"))


def test_the_workflows_run_what_the_metadata_promises():
    workflows = {path.stem: read(path) for path in (ROOT / ".github" / "workflows").iterdir()}
    promised = SpecifierSet(PROJECT["requires-python"])
    matrix = workflows["tests"]["jobs"]["python"]["strategy"]["matrix"]
    minors = [int(version.split(".")[1]) for version in matrix["python"]]
    assert minors == list(range(minors[0], minors[-1] + 1))
    assert f"3.{minors[0]}" in promised
    assert f"3.{minors[0] - 1}" not in promised
    label = "Programming Language :: Python :: "
    labels = [text.removeprefix(label) for text in PROJECT["classifiers"] if text.startswith(label)]
    assert labels == ["3", *matrix["python"]]
    assert [system.partition("-")[0] for system in matrix["os"]] == ["ubuntu", "macos", "windows"]
    assert workflows["tests"]["jobs"]["lowest"]["steps"][1]["with"]["python-version"] == f"3.{minors[0]}"
    extras = PROJECT["optional-dependencies"]
    for name, workflow in workflows.items():
        for job in workflow["jobs"].values():
            assert job["timeout-minutes"] <= 60
            for step in job["steps"]:
                assert set(step) & {"run", "uses"}, name
                command = step.get("run", "")
                for extra in re.findall(r"\.\[(\w+)\]|--extra (\w+)", command):
                    assert "".join(extra) in extras, command
                for path in re.findall(r"(?:bash|python|pytest|--ignore) ((?!-)[\w./]+)", command):
                    assert (ROOT / path).exists(), command


def test_citations_name_this_package_and_the_thesis():
    cited = read(ROOT / ".github" / "CITATION.cff")
    assert (cited["cff-version"], cited["type"], cited["title"]) == ("1.2.0", "software", PROJECT["name"])
    assert cited["license"] == PROJECT["license"]
    assert {"message", "authors"} <= set(cited)  # which the format wants
    readme = (ROOT / "README.md").read_text("utf-8")
    thesis = cited["preferred-citation"]
    assert thesis["title"] in readme.replace("{3D}", "3D")
    assert str(thesis["year"]) in readme
