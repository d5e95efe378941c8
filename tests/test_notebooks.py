"""What may be committed in a notebook; that it runs and prints what it says is nbval's part."""

import json
import re
from pathlib import Path

import pytest

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
