"""Notebooks as web pages, to be looked at: `python tests/look_at_notebooks.py FOLDER [01 05 ...]`.

Runs each under Voila in a headless Chromium and saves what it looks like, screen by screen, and exports each,
executed, to HTML. Prints how long each took and what the browser complained of.
"""

import os
import shutil
import sys
import time
from pathlib import Path

import nbformat
from nbconvert import HTMLExporter
from nbconvert.preprocessors import ExecutePreprocessor

sys.path.insert(0, str(Path(__file__).parent / "browser"))
from conftest import FLAGS, serve

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"
SCREEN = {"width": 1000, "height": 1400}
SCROLLER = """() => [...document.querySelectorAll("*")]
    .filter(element => ["auto", "scroll"].includes(getComputedStyle(element).overflowY))
    .reduce((best, element) => element.scrollHeight - element.clientHeight
        > best.scrollHeight - best.clientHeight ? element : best, document.scrollingElement)"""


def export(path: Path, folder: Path) -> None:
    """Execute a notebook and write it as a page whose figures are pictures."""
    notebook = nbformat.read(path, as_version=4)
    ExecutePreprocessor(timeout=300, store_widget_state=False).preprocess(
        notebook, {"metadata": {"path": path.parent}}
    )
    page, _ = HTMLExporter(embed_images=True).from_notebook_node(
        notebook, {"metadata": {"name": path.stem, "path": path.parent}}
    )
    (folder / f"{path.stem}.html").write_text(page, encoding="utf-8")
    print(f"  HTML: {page.count('<img')} pictures, {len(page) / 1e6:.1f} MB")


def visit(browser, url: str, path: Path, folder: Path) -> None:
    """Let Voila run a notebook, and take pictures of all of the page."""
    page = browser.new_page(viewport=SCREEN)
    complaints = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
    start = time.monotonic()
    page.goto(f"{url}/voila/render/{path.name}", timeout=300_000)
    page.wait_for_function(
        """() => { const sign = document.querySelector("#loading");
                   return document.body && (!sign || getComputedStyle(sign).display === "none"); }""",
        timeout=300_000,
    )
    print(f"  Voila: {time.monotonic() - start:.0f} s")
    scroller = page.evaluate_handle(SCROLLER)
    height = scroller.evaluate("element => element.scrollHeight")
    for i, top in enumerate(range(0, height, SCREEN["height"] - 50)):
        scroller.evaluate("(element, top) => { element.scrollTop = top; }", top)
        page.wait_for_timeout(800)  # for people to look at: nothing is tested here
        page.screenshot(path=folder / f"{path.stem}-{i}.png")
    for text in dict.fromkeys(complaints):
        print("  Chromium:", text[:200])
    page.close()


def main(folder: Path, names: list[str]) -> None:
    """Look at the notebooks whose names begin so, or at all."""
    from playwright.sync_api import sync_playwright

    folder.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "voila", str(NOTEBOOKS), "--no-browser", "--port={port}"]
    command += ["--strip_sources=False", "--VoilaExecutor.timeout=300"]
    with serve(command, folder, "/voila/static/voila.js") as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(args=FLAGS, executable_path=chromium())
        for path in sorted(NOTEBOOKS.glob("*.ipynb")):
            if not names or path.name.startswith(tuple(names)):
                print(path.name)
                visit(browser, url, path, folder)
                export(path, folder)
        browser.close()


def chromium() -> str:
    """Path of Chromium, as in the tests."""
    wanted = os.environ.get("SCENEWIDGET_CHROMIUM")
    names = [wanted] if wanted else ["chromium", "chromium-browser", "google-chrome"]
    found = next((path for name in names if (path := shutil.which(name))), None)
    if not found:
        raise SystemExit("no Chromium found; set SCENEWIDGET_CHROMIUM to its path")
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
