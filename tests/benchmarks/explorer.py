"""How fast does the SpectralExplorer answer, from a key or click in a real JupyterLab to the picture?

    python tests/benchmarks/explorer.py [--vertices 10000] [--picture explorer.png] [--without-browser]

Every control is used fifteen times. What counts is the last time that the page drew, before it was still for
a while. Without a browser only Python's part is taken. A browser that draws without a graphics card needs
longer for the drawing than one on a desk.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "browser"))

from scenewidget.figures.spectral_explorer import MODES, SpectralExplorer

TIMES = 15
SHAPE = """import numpy as np
import scenewidget as sw
from scenewidget.datasets.analytic import torus
ring = torus(n_ring={n_ring}, n_tube={n_tube})  # bent, so that no function is missing in its coordinates
bent = ring.vertices + 0.1 * np.sin(2 * ring.vertices[:, [1, 2, 0]] + 1)
mesh = sw.Mesh(bent, ring.faces)
"""
KNOBS = (
    ("eigenfunction", "index", range(10, 25)),
    ("low pass", "n_functions", range(30, 45)),
    ("heat", "time", np.geomspace(0.01, 0.1, TIMES)),
    ("heat", "source", range(500, 515)),
    ("signature", "time", np.geomspace(0.02, 0.2, TIMES)),
)
SLIDERS = {"index": "Eigenfunction", "n_functions": "Basis functions", "time": "Diffusion time t"}
WATCH = """() => {
    window.drawn = 0;
    for (const kind of [WebGLRenderingContext, window.WebGL2RenderingContext])
        for (const name of ["drawArrays", "drawElements"]) {
            const draw = kind.prototype[name];
            kind.prototype[name] = function (...given) {
                window.drawn = performance.now();
                return draw.apply(this, given);
            };
        }
    for (const name of ["keydown", "mousedown", "change", "dblclick"])
        document.addEventListener(name, () => { window.asked = performance.now(); }, true);
}"""
ANSWER = """async () => {
    const give_up = performance.now() + 20000;
    const is_still = () => window.drawn > window.asked && performance.now() - window.drawn > 400;
    while (!is_still() && performance.now() < give_up) await new Promise(done => setTimeout(done, 20));
    return window.drawn - window.asked;
}"""


def in_python(shape: str) -> None:
    """Turn each knob without a page."""
    made: dict[str, Any] = {}
    exec(shape, made)
    explorer = SpectralExplorer(made["mesh"], max_faces=made["mesh"].n_faces)
    for mode, name, values in KNOBS:
        explorer.mode = mode
        seconds = []
        for value in values:
            start = time.perf_counter()
            setattr(explorer, name, value)
            seconds.append(time.perf_counter() - start)
        tell(f"{mode}, {name}", 1e3 * np.array(seconds))


def in_a_browser(shape: str, picture: str | None) -> None:
    """Use each control with keys and mouse."""
    import conftest
    from playwright.sync_api import sync_playwright

    source = shape + "explorer = sw.SpectralExplorer(mesh, max_faces=mesh.n_faces)\nexplorer"
    with (
        tempfile.TemporaryDirectory() as home,
        sync_playwright() as playwright,
        conftest.lab(Path(home)) as server,
    ):
        browser = playwright.chromium.launch(executable_path=conftest.find_chromium(), args=conftest.FLAGS)
        page = browser.new_page(viewport={"width": 1100, "height": 950})
        page.set_default_timeout(120_000)
        book = conftest.Notebook(page, server)
        book.open([source])
        page.evaluate(WATCH)
        book.run_all()
        figure = page.locator(".scenewidget-figure .jupyter-threejs")
        figure.wait_for(state="visible")
        page.wait_for_timeout(2000)
        shown = page.locator(".widget-dropdown select").first

        def measure(name: str, act: Any, times: int = TIMES) -> None:
            answers = []
            for i in range(times):
                act(i)
                answers.append(page.evaluate(ANSWER))
            tell(name, np.array(answers))

        for mode, name, _ in KNOBS:
            shown.select_option(label_of(mode))
            page.evaluate(ANSWER)
            if name == "source":
                box = page.locator(".widget-text").filter(has_text="Source vertex").locator("input")
                box.click()
                measure(f"{mode}, {name}", lambda i: page.keyboard.press("ArrowUp"))
            else:
                handle = page.locator(".widget-slider").filter(has_text=SLIDERS[name]).locator(".noUi-handle")
                handle.focus()
                measure(f"{mode}, {name}", lambda i: page.keyboard.press("ArrowRight"))
            if picture:
                file = Path(picture)
                page.screenshot(path=file.with_stem(f"{file.stem}-{mode.replace(' ', '-')}-{name}"))
        modes = [label_of(mode) for mode in ("heat", "signature")]
        measure("what is shown", lambda i: shown.select_option(modes[i % 2]))
        kinds = page.locator(".widget-toggle-buttons button")
        kinds.nth(1).click()  # computes eigenpairs
        page.evaluate(ANSWER)
        measure("Laplacian", lambda i: kinds.nth(i % 2).click())
        shown.select_option(modes[0])
        page.evaluate(ANSWER)
        area = figure.bounding_box()
        assert area is not None

        def double_click(i: int) -> None:
            page.mouse.dblclick(area["x"] + area["width"] * (0.4 + 0.015 * i), area["y"] + area["height"] / 2)

        measure("source by double click", double_click)
        book.close()
        browser.close()


def label_of(mode: str) -> str:
    """What the list calls it."""
    return MODES[mode][0]


def tell(name: str, milliseconds: Any) -> None:
    """A row of the table."""
    print(f"{name:28}{np.median(milliseconds):6.0f}{np.max(milliseconds):10.0f}", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--vertices", type=int, default=10_000)
    parser.add_argument("--picture", help="files that begin so get screenshots")
    parser.add_argument("--without-browser", action="store_true")
    arguments = parser.parse_args()
    n_tube = round((arguments.vertices / 2.5) ** 0.5)
    n_ring = round(arguments.vertices / n_tube)
    print(f"{n_ring * n_tube} vertices\n{'':28}median   slowest, ms")
    shape = SHAPE.format(n_ring=n_ring, n_tube=n_tube)
    in_python(shape) if arguments.without_browser else in_a_browser(shape, arguments.picture)


if __name__ == "__main__":
    main()
