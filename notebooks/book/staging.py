"""Sources of the book in one folder, as Sphinx wants them: notebooks, pages, what the repository says anyway.

Goes in: the repository. Comes out: a folder with the notebooks (live outputs replaced by what works without a
kernel), the pages of ``notebooks/book``, the glossary and the changelog.
"""

from __future__ import annotations

import base64
import json
import re
import shutil
from pathlib import Path
from typing import Any

__all__ = ["HERE", "NOTEBOOKS", "figures_of", "notebook_for_the_book", "stage", "widgets_of"]

HERE = Path(__file__).parent
NOTEBOOKS = HERE.parent
TAKEN = {"glossary.md": "GLOSSARY.md", "changelog.md": "CHANGELOG.md"}  # from .github
WIDGET = re.compile(r"(SceneWidget|SceneView|Compare|SpectralExplorer)\(")
FIGURE = re.compile(r"Figure\(")
CONTROL = re.compile(r"(interactive\(|FloatProgress\()")
BAR = re.compile(r"^\s*$")  # what a progress bar leaves behind


def stage(folder: Path) -> list[Path]:
    """Write the sources into an empty folder; gives the notebooks there."""
    pages = folder / "book"
    pages.mkdir(parents=True)
    for page in sorted(HERE.glob("*.md")):
        (pages / page.name).write_text(without_empty_globs(page.read_text(encoding="utf-8")), encoding="utf-8")
    for name, theirs in TAKEN.items():
        text = (NOTEBOOKS.parent / ".github" / theirs).read_text(encoding="utf-8")
        (pages / name).write_text(without_links_out(text), encoding="utf-8")
    shutil.copytree(NOTEBOOKS / "images", folder / "images")
    staged = []
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        notebook = json.loads(path.read_text(encoding="utf-8"))
        staged.append(folder / path.name)
        staged[-1].write_text(json.dumps(notebook_for_the_book(notebook, path.stem)), encoding="utf-8")
    return staged


def notebook_for_the_book(notebook: dict[str, Any], stem: str) -> dict[str, Any]:
    """With links to the file and its slides, and outputs that work without a kernel."""
    cells = notebook["cells"]
    for n, output in enumerate(widgets_of(notebook)):
        view = f'<iframe class="view" src="_static/views/{stem}-{n}.html" loading="lazy" title="{_plain(output)}"></iframe>'
        output.clear()
        output.update(output_type="display_data", metadata={}, data={"text/html": view})
    for n, output in enumerate(figures_of(notebook)):
        width, height = _extent(output["data"]["image/png"])
        view = (
            f'<iframe class="figure" src="_static/views/{stem}-figure-{n}.html" loading="lazy" title="A figure to turn" '
            f'style="border: 0; width: 100%; max-width: {width}px; aspect-ratio: {width} / {height}"></iframe>'
        )
        output.clear()
        output.update(output_type="display_data", metadata={}, data={"text/html": view})
    for cell in cells:
        if cell["cell_type"] != "code":
            continue
        for output in cell["outputs"]:
            if CONTROL.match(_plain(output)):
                note = "<p class='needs-kernel'>Sliders stand here in a running notebook.</p>"
                output.update(data={"text/html": note})
        cell["outputs"] = [o for o in cell["outputs"] if not _is_empty(o)]
    links = f"{{download}}`The notebook <_downloads/{stem}.ipynb>` · <a href='_static/slides/{stem}.html'>Slides</a>"
    cells.insert(1, {"cell_type": "markdown", "metadata": {}, "id": "links", "source": links})
    return notebook


def widgets_of(notebook: dict[str, Any]) -> list[dict[str, Any]]:
    """Outputs of the widgets that turn in 3D, in their order."""
    return _outputs(notebook, WIDGET)


def figures_of(notebook: dict[str, Any]) -> list[dict[str, Any]]:
    """Outputs of the figures that turn in 3D, in their order."""
    return _outputs(notebook, FIGURE)


def without_empty_globs(text: str) -> str:
    """Without lines that are a pattern of pages of which there is none; Sphinx would warn of them."""
    kept = [line for line in text.splitlines() if not re.fullmatch(r"\w+\*", line) or any(HERE.glob(f"{line}.md"))]
    return "\n".join(kept) + "\n"


def without_links_out(text: str) -> str:
    """Links to files of the repository, which are no pages of the book, as mere words."""
    return re.sub(r"\[([^\]]+)\]\((?!https?:)[^)]*\)", r"\1", text)


def _outputs(notebook: dict[str, Any], kind: re.Pattern[str]) -> list[dict[str, Any]]:
    return [
        output
        for cell in notebook["cells"]
        if cell["cell_type"] == "code"
        for output in cell["outputs"]
        if kind.match(_plain(output))
    ]


def _extent(still: str | list[str]) -> tuple[int, int]:
    """Width and height of a stored picture, whose shape the page that turns takes on."""
    head = base64.b64decode("".join(still)[:64])
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")


def _plain(output: dict[str, Any]) -> str:
    return "".join(output.get("data", {}).get("text/plain", ""))


def _is_empty(output: dict[str, Any]) -> bool:
    return set(output.get("data", {"": 0})) == {"text/plain"} and bool(BAR.match(_plain(output)))
