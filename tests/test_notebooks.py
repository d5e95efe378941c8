"""What may be committed in a notebook; that it runs and prints what it says is nbval's part."""

import json
import re
from pathlib import Path

import pytest

from scenewidget import exercises

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def path(request):
    return request.param


def test_it_carries_outputs_but_no_widget_state(path):
    notebook = json.loads(path.read_text())
    assert "widgets" not in notebook["metadata"]
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in code] == list(range(1, len(code) + 1)), (
        "run it from a fresh kernel"
    )
    assert any(cell["outputs"] for cell in code)


def test_it_is_small_and_names_no_machine(path):
    text = path.read_text()
    assert len(text) < 500_000
    assert re.findall(r"/(?:home|root|tmp|work|usr|Users)/[\w./-]*|[A-Z]:\\\\\w+|0x[0-9a-f]{8,}", text) == []


def test_it_opens_with_goals_and_ends_with_what_was_learnt(path):
    markdown = [
        "".join(c["source"]) for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "markdown"
    ]
    for part in ("**Goals.**", "**You need**", "**Minutes:**", "**Builds on**"):
        assert part in markdown[0]
    ends = [text for text in markdown if text.startswith("## What you can do now")]
    assert len(ends) == 1
    assert "## References" in ends[0]


def test_its_exercises_are_those_of_the_package_and_show_no_answer(path):
    number = path.name[:2]
    if not exercises.names(number):
        pytest.skip("its exercises are its own")
    cells = json.loads(path.read_text())["cells"]
    texts = {
        kind: ["".join(c["source"]) for c in cells if c["cell_type"] == kind] for kind in ("markdown", "code")
    }
    for name in exercises.names(number):
        assert any(exercises.question(name) in text for text in texts["markdown"]), name
        (cell,) = [text for text in texts["code"] if f'exercises.check("{name}"' in text]
        assert cell.startswith("answer = ...") or "return ..." in cell
    checks = [c for c in cells if "exercises.check(" in "".join(c["source"]) and c["cell_type"] == "code"]
    assert {"".join(o["text"]) for c in checks for o in c["outputs"]} == {"not answered yet\n"}


def test_it_prints_no_timings(path):
    for cell in json.loads(path.read_text())["cells"]:
        for output in cell.get("outputs", []):
            output.get("data", {}).pop("image/png", None)  # its base64 spells anything
            assert not re.search(r"\d(?:\.\d+)? ?(?:ms|s|seconds)\b", json.dumps(output)), cell["id"]


def test_exported_to_html_it_shows_its_pictures(path):
    from nbconvert import HTMLExporter

    notebook = json.loads(path.read_text())
    outputs = [o for cell in notebook["cells"] for o in cell.get("outputs", [])]
    page, _ = HTMLExporter().from_filename(str(path))
    assert page.count("<img") >= sum("image/png" in o.get("data", {}) for o in outputs)
    assert "widget-view" not in page  # it would be an empty place where no kernel runs
    figures = [o for o in outputs if "".join(o.get("data", {}).get("text/plain", "")).startswith("Figure(")]
    assert all("image/png" in o["data"] for o in figures)
    titles = re.findall(r"<title>(.*?)</title>", page)
    assert titles == [path.stem]
