"""What a view costs in a real JupyterLab and a real Chromium without a graphics card.

Prints, for scans of several sizes: from running the cell to the first frame, the handler of a pointer
movement (also while a cell keeps the kernel busy), the picture of another part that blinks, of a camera that
moves and of a stroke of the brush that goes on, the time from other segments in Python to their picture, and
the memory of the page and of the process that draws it.

python tests/benchmarks/view.py
python tests/benchmarks/view.py --faces 10000 100000
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import psutil
from scans import DATA, in_size, read_scan, simplified

sys.path.insert(0, str(Path(__file__).parents[1] / "browser"))

import conftest

CELL = """
import numpy as np
from scenewidget.engine.mesh import Mesh
from scenewidget.widget.scene_view import SceneView
arrays = np.load({path!r})
mesh = Mesh(arrays["vertices"], arrays["faces"], arrays["colors"] if "colors" in arrays else None)
low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
cells = ((mesh.face_centroids - low) / (high - low) * 5).astype(np.int32).clip(0, 4)
segments = cells @ np.array([25, 5, 1], np.int32)
halves = 2 * segments + (mesh.face_normals[:, 2] > 0.5)
"""
SHOW = """
import threading
import scenewidget as sw
from scenewidget.widget.autosave import Autosave
from scenewidget.widget.edit_commands import EditCommands
view, lock = SceneView(mesh, height=560, editable=True, mode="edit"), threading.RLock()
view
"""
TAKE = """
commands = EditCommands(view, lock, Autosave(view, lock, False, print), lambda: None)
labels = np.unique(segments, return_inverse=True)[1]
commands.take(sw.Segmentation(mesh, labels, levels={"base": halves}), sw.Params())
view.on_msg(lambda _, message, __: commands.handle(message))
FIRST = int(np.flatnonzero(labels == 0)[0])
"""
MERGE = """
session = commands.session
last = np.flatnonzero(session.segmentation.labels == session.segmentation.n_segments - 1)
session.merge(int(last[0]), FIRST)
"""
KERNEL = "window.jupyterapp.shell.currentWidget.context.sessionContext.session.kernel"
WORK = "t = __import__('time'); e = t.time() + 8\\nwhile t.time() < e: pass"
BUSY = f'() => void {KERNEL}.requestExecute({{ code: "{WORK}" }})'
# Handlers are measured as the page runs them: everything that a movement does before the next event. Where
# the clock is coarser than that, the mean over all of them still tells.
HOVER = """([root, n]) => {
    const canvas = root.querySelector("canvas");
    const box = canvas.getBoundingClientRect();
    const times = [];
    for (let i = 0; i < n; i++) {
        const place = {
            clientX: box.left + box.width * (0.2 + 0.6 * ((i * 0.618) % 1)),
            clientY: box.top + box.height * (0.2 + 0.6 * ((i * 0.382) % 1)),
            bubbles: true,
        };
        const began = performance.now();
        canvas.dispatchEvent(new PointerEvent("pointermove", place));
        times.push(performance.now() - began);
    }
    return times;
}"""
# A pixel is read back after each frame, so that its time is that of the finished picture.
FRAMES = """([root, n, isPressed, isTurning, start]) => new Promise(resolve => {
    const canvas = root.querySelector("canvas");
    const gl = canvas.getContext("webgl2");
    const box = canvas.getBoundingClientRect();
    const times = [];
    const send = (type, i) => canvas.dispatchEvent(new PointerEvent(type, {
        clientX: box.left + box.width * (isPressed ? start[0] + 0.01 * i : 0.2 + 0.6 * ((i * 0.618) % 1)),
        clientY: box.top + box.height * (isPressed ? start[1] : 0.2 + 0.6 * ((i * 0.382) % 1)),
        ...{ bubbles: true, pointerId: 1, pointerType: "mouse", button: 0, shiftKey: isTurning },
    }));
    canvas.setPointerCapture = () => {};
    if (isPressed) send("pointerdown", 0);
    const next = (i) => {
        if (i > n) {
            if (isPressed) send("pointerup", i);
            resolve(times);
            return;
        }
        setTimeout(() => {
            const began = performance.now();
            send("pointermove", i);
            requestAnimationFrame(() => {
                gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
                times.push(performance.now() - began);
                next(i + 1);
            });
        }, 30);
    };
    next(1);
})"""


@contextmanager
def laboratory():
    """Opens notebooks in a JupyterLab of its own, as the tests of the browser do."""
    from playwright.sync_api import sync_playwright

    class Factory:
        def mktemp(self, name):
            return Path(tempfile.mkdtemp(prefix=f"{name}-"))

    chromium = next(
        path for name in ("chromium", "chromium-browser") if (path := conftest.shutil.which(name))
    )
    server = conftest.jupyter.__wrapped__(Factory(), chromium)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=conftest.FLAGS)
        try:
            context = browser.new_context(viewport={"width": 1100, "height": 900})
            context.set_default_timeout(300_000)  # large scans take their time
            yield next(server), context
        finally:
            browser.close()
            next(server, None)


def milliseconds(times: list[float]) -> str:
    """Median and 95th percentile."""
    return "{:7.2f} {:7.2f}".format(*np.quantile(times, [0.5, 0.95]))


def beginning(view: conftest.View) -> list[float]:
    """Shares of the picture: a place inside a part, left of the middle, as a stroke goes to the right."""
    width, height = view.size()
    places = [place for part, place in view.parts().items() if part and place[0] < 0.6 * width]
    x, y = min(places, key=lambda place: abs(place[0] - 0.35 * width) + abs(place[1] - 0.5 * height))
    return [x / width, y / height]


def memory() -> str:
    """Megabytes of the largest page and of the process that draws for all pages."""
    found = dict.fromkeys(("renderer", "gpu-process"), 0.0)
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.Error):
            for kind in found:
                if f"--type={kind}" in process.cmdline():
                    found[kind] = max(found[kind], process.memory_info().rss / 1e6)
    return "{:7.0f} {:7.0f}".format(*found.values())


def measure(server, context, path: Path) -> dict[str, str]:
    """One row of the table."""
    book = conftest.Notebook(context.new_page(), server)
    book.open([CELL.format(path=str(path)), SHOW])
    run = "() => window.jupyterapp.commands.execute('notebook:run-cell-and-select-next')"
    book.page.evaluate(run)
    book.wait_for("'halves' in globals()", True)
    began = time.perf_counter()
    book.page.evaluate(run)
    view = book.view()
    first = time.perf_counter() - began
    book.execute(TAKE)
    view.wait("segments", book.evaluate("str(view.n_segments)").strip("'"))
    view.settle()
    book.page.wait_for_timeout(3000)  # the stand-in for movements is made meanwhile
    root = view.root.element_handle()
    row = {"first frame (s)": f"{first:.2f}"}
    book.page.evaluate(HOVER, [root, 50])
    times = book.page.evaluate(HOVER, [root, 400])
    row["hover (ms)"] = f"{milliseconds(times)}, mean {np.mean(times):.3f}"
    middle = [0.35, 0.5]
    blinks, turns = [30, False, False, middle], [30, True, True, middle]
    row["another part blinks (ms)"] = milliseconds(book.page.evaluate(FRAMES, [root, *blinks]))
    row["camera moves (ms)"] = milliseconds(book.page.evaluate(FRAMES, [root, *turns]))
    view.settle()
    view.root.focus()
    book.page.keyboard.press("m")
    view.wait("tool", "paint")
    strokes = [30, True, False, beginning(view)]
    for _ in range(2):  # a scan's first stroke makes things ready
        times = book.page.evaluate(FRAMES, [root, *strokes])
        view.wait("pending", "0")
        if book.evaluate("type(commands.session.edits[-1]).__name__") != "'Paint'":
            raise AssertionError("the stroke has painted nothing: it began on the background")
        book.page.keyboard.press("Control+z")
        view.wait("pending", "0")
    row["the brush goes on (ms)"] = milliseconds(times)
    row["memory (MB), page and drawing"] = memory()
    n_segments, times = int(view.state("segments")), []
    for _ in range(10):
        began = time.perf_counter()
        book.execute(MERGE)
        view.wait("segments", str(n_segments := n_segments - 1))
        book.page.evaluate("() => new Promise(resolve => requestAnimationFrame(resolve))")
        times.append(1000 * (time.perf_counter() - began))
    row["other segments, from Python (ms)"] = milliseconds(times)
    book.page.evaluate(BUSY)
    row["hover, kernel busy (ms)"] = milliseconds(book.page.evaluate(HOVER, [root, 400]))
    book.page.wait_for_function(f"() => {KERNEL}.status === 'idle'", timeout=60_000)
    if book.errors:
        print("errors:", *book.errors, sep="\n  ")
    book.close()
    return row


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scan", nargs="?", type=Path, default=DATA / "bedroom.ply")
    parser.add_argument("--faces", type=int, nargs="+", default=[10_000, 100_000, 1_500_000])
    arguments = parser.parse_args()
    scan = read_scan(arguments.scan)
    with tempfile.TemporaryDirectory() as folder, laboratory() as (server, context):
        for n_faces in arguments.faces:
            mesh = in_size(scan, n_faces) if n_faces > scan.n_faces else simplified(scan, n_faces)
            path = Path(folder) / f"{n_faces}.npz"
            colors = {} if mesh.vertex_colors is None else {"colors": mesh.vertex_colors}
            np.savez(path, vertices=mesh.vertices, faces=mesh.faces, **colors)
            print(f"\n{mesh.n_faces} faces; of two numbers, the median and the 95th percentile")
            for name, value in measure(server, context, path).items():
                print(f"  {name:32}{value}")


if __name__ == "__main__":
    main()
