"""``python notebooks/book [FOLDER]`` builds the book: course, how-to, reference, slides; FOLDER is build/book if not given.

It wants ``pip install ".[docs]"``. What notebooks printed is stored in them, and compared by the tests; they are
run once for what turns without a kernel, which is kept beside the site. A later build runs only what has changed.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from book import links, reference, slides, staging, turning, views

__all__ = ["build"]


def build(folder: Path, *, with_views: bool = True) -> list[str]:
    """Build the site into ``folder/html``; gives its faults, warnings of Sphinx included."""
    from sphinx.cmd.build import main as sphinx

    source, site = folder / "source", folder / "html"
    for old in (source, site):
        shutil.rmtree(old, ignore_errors=True)
    notebooks = staging.stage(source)
    reference.write(source / "api")
    static = source / "_static"
    (static / "slides").mkdir(parents=True)
    (source / "_downloads").mkdir()
    for path in sorted(staging.NOTEBOOKS.glob("*.ipynb")):
        shutil.copy(path, source / "_downloads")
    shutil.copy(staging.HERE / "book.css", static)
    shutil.copy(mathjax_file(), static)
    (source / "_extra").mkdir()
    (source / "_extra" / "index.html").write_text(
        '<!doctype html><meta http-equiv="refresh" content="0; url=book/index.html"><title>scenewidget</title>'
        '<a href="book/index.html">The book</a>', encoding="utf-8"
    )  # fmt: skip
    slides.write(notebooks, static / "slides")
    wrong = []
    if with_views:
        views.write(static / "views", kept=folder / "views")
        wrong = turning.write(static / "views", kept=folder / "views")
    shutil.copy(staging.HERE / "conf.py", source)
    options = ["-W", "--keep-going", "-q", "-b", "html", "-d", str(folder / "doctrees")]
    code = sphinx([*options, str(source), str(site)])
    return [*(["Sphinx warned, see above"] if code else []), *views.missing(), *wrong, *links.faults(site)]


def mathjax_file() -> Path:
    """MathJax in one file, with its fonts."""
    from importlib.util import find_spec

    package = find_spec("sphinx-mathjax-offline")
    assert package is not None
    assert package.origin is not None
    return Path(package.origin).parent / "static" / "mathjax" / "tex-svg.js"


def main() -> None:
    """Build, and say what is wrong, if anything is."""
    parser = argparse.ArgumentParser(prog="python notebooks/book", description="Build the book.")
    default = staging.NOTEBOOKS.parent / "build" / "book"
    parser.add_argument("folder", nargs="?", type=Path, default=default, help="where to (build/book)")
    folder = parser.parse_args().folder
    start = time.monotonic()
    found = build(folder)
    for fault in found:
        print(fault, file=sys.stderr)
    print(f"{folder / 'html' / 'index.html'} in {time.monotonic() - start:.0f} s")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
