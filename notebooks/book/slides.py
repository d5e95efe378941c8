"""Slides of the notebooks by nbconvert: a slide a section, below it one for each thought.

Reveal.js and MathJax lie beside them: nothing is fetched when they are shown.
"""

from __future__ import annotations

import re
import shutil
from importlib.util import find_spec
from pathlib import Path
from typing import Any

__all__ = ["as_slides", "beside_each_other", "write"]

NEEDED = ("LICENSE", "dist/reveal.js", "dist/reveal.css", "dist/theme/white.css", "dist/theme/fonts", "plugin/notes")
TEMPLATE = Path(__file__).parent / "slides"


def write(notebooks: list[Path], folder: Path) -> None:
    """Write a page of slides for each notebook, and reveal.js, into a folder."""
    import nbformat
    from nbconvert import SlidesExporter

    package = find_spec("sphinx_revealjs")
    assert package is not None
    assert package.origin is not None
    reveal = Path(package.origin).parent / "_static" / "revealjs"
    for part in NEEDED:
        copy = shutil.copytree if (reveal / part).is_dir() else shutil.copy
        (folder / "reveal" / part).parent.mkdir(parents=True, exist_ok=True)
        copy(reveal / part, folder / "reveal" / part)
    exporter = SlidesExporter(
        extra_template_basedirs=[str(TEMPLATE.parent)], template_name=TEMPLATE.name, embed_images=True,
        reveal_theme="white", reveal_number="c/t", exclude_input_prompt=True, exclude_output_prompt=True,
        mathjax_url="../tex-svg.js",
    )  # fmt: skip
    exporter.reveal_url_prefix = "reveal"
    for path in notebooks:
        notebook = as_slides(nbformat.read(path, as_version=4))
        resources = {"metadata": {"name": path.stem, "path": str(path.parent)}}
        text, _ = exporter.from_notebook_node(notebook, resources)
        (folder / f"{path.stem}.html").write_text(beside_each_other(text), encoding="utf-8")


def beside_each_other(text: str) -> str:
    """The page with its links as they are seen from the folder of the slides."""
    text = re.sub(r'href="(\w+)\.ipynb', r'href="\1.html', text)
    return text.replace('src="_static/views/', 'src="../views/')


def as_slides(notebook: Any) -> Any:
    """The notebook with a kind of slide for each cell; checks of exercises are left to the notebook."""
    for cell in notebook.cells:
        source = cell.source.lstrip()
        if "exercises.check(" in source or cell.get("id") == "links":
            kind = "skip"
        elif cell.cell_type == "markdown":
            kind = "slide" if source.startswith(("# ", "## ")) else "subslide"
        else:
            kind = "-"
        cell.metadata["slideshow"] = {"slide_type": kind}
    return notebook
