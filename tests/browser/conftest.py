"""A real JupyterLab in a real headless Chromium.

`notebook(cells)` opens a new notebook with these cells in a server that lives as long as the tests; it can
run them, evaluate Python in their kernel, and find the views they show. Wait on state, never on time.
Pages of JupyterLab go from test to test, since loading one takes longer than most tests: what a test changes
of the page itself, it changes back.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cells import LABELED
from editing_page import WIDGET, Editor
from PIL import Image

FLAGS = [
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-gpu-compositing",  # of the page: without a graphics card, that costs more than WebGL itself
]
# A kernel hangs for ever if somebody takes one of its ports before it does; files are its own.
OWN_SOCKETS = ["--KernelManager.transport=ipc"] if os.name == "posix" else []
NO_NEWS = {"@jupyterlab/apputils-extension:notification": {"fetchNews": "false", "checkForUpdates": False}}
PATIENCE_SECONDS = 90  # a wait ends as soon as it can, but a busy machine can be slow
PARTS = """(root, step) => {
    const canvas = root.querySelector("canvas");
    const box = canvas.getBoundingClientRect();
    const [columns, rows] = [Math.floor(box.width / step), Math.floor(box.height / step)];
    const point = (x, y) => {
        const place = { clientX: box.left + x, clientY: box.top + y, bubbles: true };
        canvas.dispatchEvent(new PointerEvent("pointermove", place));
        return root.dataset.hovered;
    };
    const seen = [];
    for (let row = 0; row < rows; row++) {
        seen.push(Array.from({ length: columns }, (_, i) => point((i + 0.5) * step, (row + 0.5) * step)));
    }
    canvas.dispatchEvent(new PointerEvent("pointerleave"));
    // the place of a part with the most equal places around it
    const best = {};
    seen.forEach((line, row) => line.forEach((part, column) => {
        let room = 0;
        while ([[0, 1], [1, 0], [0, -1], [-1, 0]].every(
            ([y, x]) => seen[row + y * (room + 1)]?.[column + x * (room + 1)] === part)) room++;
        if (!(part in best) || room > best[part].room) {
            best[part] = { room, place: [(column + 0.5) * step, (row + 0.5) * step] };
        }
    }));
    return Object.fromEntries(Object.entries(best).map(([part, { place }]) => [part, place]));
}"""
# The messages of widgets that the kernel hasn't dealt with yet. A widget holds others back meanwhile.
WATCH_MESSAGES = """() => {
    const { kernel } = window.jupyterapp.shell.currentWidget.context.sessionContext.session;
    const unanswered = window.unanswered = new Set();
    kernel.anyMessage.connect((_, { msg, direction }) => {
        if (direction === "send" && msg.header.msg_type === "comm_msg") unanswered.add(msg.header.msg_id);
    });
    kernel.iopubMessage.connect((_, { content, parent_header }) => {
        if (content.execution_state === "idle") unanswered.delete(parent_header.msg_id);
    });
}"""
# What tells why a view isn't as it should be.
STATE = """root => ({
    ...root.dataset,
    text: root.innerText,
    page: document.visibilityState,
    place: JSON.stringify(root.getBoundingClientRect()),
    canvases: [...document.querySelectorAll("canvas")].map((c) => [c.width, c.height, c.isConnected]),
})"""
IS_IDLE = """() => window.jupyterapp?.shell.currentWidget?.context?.sessionContext
    ?.session?.kernel?.status === 'idle'"""
# In a kernel that another notebook has left, if there is one; it is told where it is now.
OPEN = """async ([path, id, home]) => {
    await window.jupyterapp.restored;
    const kernel = id === null ? {} : { kernel: { id, name: "python3" } };
    const { context } = await window.jupyterapp.commands.execute("docmanager:open", { path, ...kernel });
    await context.ready;
    await context.sessionContext.ready;
    const code = `__import__("os").chdir(${JSON.stringify(home)})`;
    if (id !== null) await context.sessionContext.session.kernel.requestExecute({ code, silent: true }).done;
}"""
# Closes the notebook; the kernel forgets all that it knows, if it can be reached, or ends.
LEAVE = """async forget => {
    const { shell, commands, serviceManager } = window.jupyterapp;
    const { context } = shell.currentWidget;
    const { session } = context.sessionContext;
    context.model.dirty = false;  // or it would ask whether to save
    let kernel = null;
    if (forget && session?.kernel?.status === "idle") {
        const request = { code: "", silent: true, user_expressions: { rest: forget } };
        const late = new Promise(resolve => setTimeout(resolve, 5000));
        const reply = await Promise.race([session.kernel.requestExecute(request).done, late]);
        const isClean = reply?.content.user_expressions?.rest?.data?.["text/plain"] === "True";
        if (isClean) kernel = session.kernel.id;
    }
    await commands.execute("application:close-all");
    const isTidy = () => document.querySelector(".jp-Notebook, .scenewidget, .jp-Dialog") === null;
    for (let frame = 0; frame < 100 && !isTidy(); frame++) await new Promise(requestAnimationFrame);
    if (session && kernel === null) await serviceManager.sessions.shutdown(session.id);
    return [isTidy(), kernel];
}"""
# As after a start, but for what is imported and compiled; whether nothing is left that could act by itself.
FORGET = """[
    __import__("ipywidgets").Widget.close_all(),
    get_ipython().reset(new_session=True),
    __import__("gc").collect(),
    all(t is __import__("threading").main_thread() or t.daemon for t in __import__("threading").enumerate()),
][-1]"""
HAS_CELLS = """() => {
    const { content } = window.jupyterapp.shell.currentWidget;
    return content.widgets.length > 0 && content.widgets.length === content.model.cells.length;
}"""
EXECUTION_COUNTS = """() => window.jupyterapp.shell.currentWidget?.content?.widgets
    ?.map((cell) => [cell.model.executionCount, cell.model.executionState])"""
HARMLESS = ("favicon", "ResizeObserver loop")  # a host's own remarks
VOILA_TROUBLES = ("ERR_NAME_NOT_RESOLVED", "ERR_INTERNET_DISCONNECTED", "shared module")  # and those of Voila
HAS_FAILED = pytest.StashKey[bool]()
TITLE = "</title><script>window.harm = 1</script>"
NAMES = {0: "</script><script>window.harm = 2</script>", 1: "ceiling & <b>lamp</b>"}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Every test in this folder drives a browser.

    CI's machines stall at times, so one that fails there is tried once more and named in the summary.
    """
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.browser)
            if os.environ.get("CI"):
                item.add_marker(pytest.mark.flaky(reruns=1))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    """Lets fixtures know whether their test has failed."""
    report = yield
    if report.when != "teardown":
        item.stash[HAS_FAILED] = report.failed
    return report


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of Chromium; without it, skip here and fail under CI."""
    found = find_chromium()
    if found:
        return found
    message = (
        "BROWSER TESTS DID NOT RUN: no Chromium found. Install one (Debian: apt install chromium "
        "fonts-dejavu-core) or set SCENEWIDGET_CHROMIUM to its path"
    )
    if os.environ.get("CI"):
        pytest.fail(message, pytrace=False)
    print(f"\n*** {message} ***\n", file=sys.__stderr__)
    pytest.skip(message)


def find_chromium() -> str | None:
    """Path of Chromium, None if there is none."""
    wanted = os.environ.get("SCENEWIDGET_CHROMIUM")
    names = [wanted] if wanted else ["chromium", "chromium-browser", "google-chrome"]
    return next((path for name in names if (path := shutil.which(name))), None)


@dataclass
class Server:
    """A running Jupyter server and the folder it shows."""

    url: str
    token: str
    folder: Path


@pytest.fixture(scope="session")
def jupyter(tmp_path_factory: pytest.TempPathFactory, chromium: str) -> Iterator[Server]:
    """A JupyterLab with settings, kernels and files of its own."""
    with lab(tmp_path_factory.mktemp("jupyter")) as server:
        yield server


@contextlib.contextmanager
def lab(home: Path) -> Iterator[Server]:
    """A JupyterLab that keeps everything in a folder and lives as long as the block."""
    folder = home / "notebooks"
    folder.mkdir()
    (home / "settings").mkdir()
    (home / "settings" / "overrides.json").write_text(json.dumps(NO_NEWS))
    token = secrets.token_hex(16)
    command = [
        *(sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", "--expose-app-in-browser"),
        *("--ServerApp.ip=127.0.0.1", "--ServerApp.port={port}", "--ServerApp.port_retries=0"),
        *(f"--IdentityProvider.token={token}", f"--ServerApp.root_dir={folder}"),
        *(f"--LabApp.app_settings_dir={home / 'settings'}", f"--LabApp.user_settings_dir={home / 'user'}"),
        *(f"--LabApp.workspaces_dir={home / 'workspaces'}", *OWN_SOCKETS),
    ]
    own = {f"JUPYTER_{kind}_DIR": str(home / kind.lower()) for kind in ("CONFIG", "DATA")}
    with serve(command, home, f"/api/status?token={token}", env=own) as url:
        yield Server(url, token, folder)


@contextlib.contextmanager
def serve(
    command: Sequence[str], home: Path, path: str, *, env: Mapping[str, str] | None = None
) -> Iterator[str]:
    """Address of a server that lives as long as the block; "{port}" in its command becomes a free port.

    It is up once it answers at ``path``; what it prints goes to a file in ``home``.
    """
    port = free_port()
    url, log = f"http://127.0.0.1:{port}", home / "log.txt"
    with (
        # paths of sockets must be short
        tempfile.TemporaryDirectory(prefix="sw-", dir="/tmp" if OWN_SOCKETS else None) as runtime,
        log.open("w") as output,
        subprocess.Popen(
            [word.replace("{port}", str(port)) for word in command],
            env={**os.environ, "JUPYTER_RUNTIME_DIR": runtime, **(env or {})},
            stdout=output,
            stderr=subprocess.STDOUT,
            cwd=home,
        ) as process,
    ):
        try:
            deadline = time.monotonic() + PATIENCE_SECONDS
            while not _answers(f"{url}{path}"):
                if process.poll() is not None or time.monotonic() > deadline:
                    pytest.fail(f"{command[2]} did not start:\n{log.read_text()[-3000:]}", pytrace=False)
                time.sleep(0.1)
            yield url
        finally:
            process.terminate()
            try:
                process.wait(PATIENCE_SECONDS)  # it ends its kernels
            except subprocess.TimeoutExpired:
                process.kill()


def free_port() -> int:
    """A port for a server, none of those that the system hands out by itself meanwhile."""
    while True:
        port = random.randrange(20_000, 30_000)
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port


@pytest.fixture(scope="session")
def chromiums(chromium: str) -> Iterator[Any]:
    """Starts Chromium with WebGL in software, the same everywhere."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        yield playwright.chromium


@pytest.fixture(scope="session")
def profile(chromiums: Any, chromium: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """One browser profile for all tests, on disk, so that JupyterLab comes out of its cache, compiled."""
    context = chromiums.launch_persistent_context(
        tmp_path_factory.mktemp("profile"), executable_path=chromium, args=FLAGS
    )
    context.set_default_timeout(1000 * PATIENCE_SECONDS)
    yield context
    context.close()


@pytest.fixture(scope="session")
def free_pages() -> list[Any]:
    """Pages that show a JupyterLab in which nothing is open."""
    return []


@pytest.fixture(scope="session")
def free_kernels() -> list[str]:
    """Kernels that know nothing any more and belong to no open notebook: the imports take longest."""
    return []


@pytest.fixture
def notebook(
    jupyter: Server,
    profile: Any,
    free_pages: list[Any],
    free_kernels: list[str],
    request: pytest.FixtureRequest,
) -> Iterator[Callable[..., Notebook]]:
    """Opens notebooks: `notebook(["cell", ...], width=1100, height=900)`; closes them.

    In place of cells, it takes the path of a notebook and opens a copy, in a kernel of its own. Cells run
    in a kernel that has seen other cells, but forgot them.
    """
    opened: list[Notebook] = []

    def open_notebook(cells: list[str] | Path, *, width: int = 1100, height: int = 900) -> Notebook:
        page = free_pages.pop() if free_pages else profile.new_page()
        page.bring_to_front()
        page.set_viewport_size({"width": width, "height": height})
        page.mouse.move(0, 0)
        book = Notebook(page, jupyter)
        opened.append(book)
        book.open(cells, free_kernels)
        return book

    yield open_notebook
    for book in opened:
        if not request.node.stash[HAS_FAILED] and book.leave(free_kernels):
            free_pages.append(book.page)
        else:
            book.close()


@pytest.fixture
def editor(notebook):
    """A segmented room, ready to be edited; nothing may go wrong in the console meanwhile."""
    book = notebook([WIDGET])
    book.run_all()
    yield Editor(book)
    assert book.errors == []


@pytest.fixture
def page(profile: Any) -> Iterator[Any]:
    """A page without a network."""
    page = profile.new_page()
    session = profile.new_cdp_session(page)
    session.send("Network.enable")
    session.send(
        "Network.emulateNetworkConditions",
        {"offline": True, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1},
    )
    yield page
    page.close()


@pytest.fixture
def saved(page: Any, tmp_path: Path) -> Iterator[View]:
    """The labeled room as a page, opened from disk."""
    scope: dict[str, Any] = {}
    exec(LABELED, scope)
    view = scope["view"]
    sure = [0.5, 0.75, 1, 0.125, 0.25, 0.625]
    view.set_segments(scope["surfaces"], names=NAMES, confidence=sure)
    view.editable, view.mode, view.busy, view.error = True, "edit", True, "wrong"
    path = view.to_html(tmp_path / "room.html", title=TITLE)
    assert path.stat().st_size < 1_000_000
    page.set_viewport_size({"width": 1000, "height": 640})
    errors, requests = errors_of(page), []
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    root = page.locator(".scenewidget")
    root.wait_for()
    shown = View(page, root)
    shown.wait("ready", "true")
    shown.settle()
    yield shown
    assert errors == []
    assert [url for url in requests if not url.startswith(("file:", "blob:", "data:"))] == []


@dataclass
class Notebook:
    """One notebook in one page."""

    page: Any
    server: Server
    errors: list[str] = field(default_factory=list)
    keeps_kernel: bool = False
    folder: Path = Path()

    def open(self, cells: list[str] | Path, free_kernels: list[str] | None = None) -> None:
        """Write the cells into a file, or copy one with what it reads; open it, until its kernel answers."""
        self.keeps_kernel = free_kernels is not None and not isinstance(cells, Path)
        name = f"{secrets.token_hex(4)}/test.ipynb"  # in a folder of its own: edits are saved beside it
        path = self.server.folder / name
        self.folder = path.parent
        self.folder.mkdir()
        if isinstance(cells, Path):
            others = shutil.ignore_patterns("*.ipynb", ".*")
            shutil.copytree(cells.parent, path.parent, ignore=others, dirs_exist_ok=True)
            shutil.copy(cells, path)
        else:
            path.write_text(json.dumps(notebook_of(cells)))
        self.errors = errors_of(self.page)
        if self.page.evaluate("() => 'jupyterapp' in window"):
            kernel = free_kernels.pop() if self.keeps_kernel and free_kernels else None
            self.page.evaluate(OPEN, [name, kernel, str(self.folder)])
        else:
            self.page.goto(self.address(name))
        self.page.wait_for_function(IS_IDLE)
        self.page.evaluate(WATCH_MESSAGES)
        self.page.evaluate("() => window.jupyterapp.shell.collapseLeft?.()")

    def address(self, name: str) -> str:
        """Where the server shows a notebook."""
        return f"{self.server.url}/lab/tree/{name}?token={self.server.token}&reset"

    def run_all(self) -> None:
        """Run all cells and wait until the kernel is done with them."""
        self.page.wait_for_function(HAS_CELLS)
        self.page.evaluate("() => window.jupyterapp.commands.execute('notebook:run-all-cells')")

    def restart(self) -> None:
        """A new kernel for the notebook; its outputs stay on the page."""
        self.page.evaluate(
            "() => window.jupyterapp.shell.currentWidget.context.sessionContext.restartKernel()"
        )
        self.page.evaluate("() => window.unanswered.clear()")  # the kernel that is gone answers no more
        self.page.wait_for_function(IS_IDLE)
        self.page.evaluate(  # not by `evaluate`, since what waits for the old kernel is never answered
            """async code => {
                const { session } = window.jupyterapp.shell.currentWidget.context.sessionContext;
                await session.kernel.requestExecute({ code, silent: true }).done;
            }""",
            f"import os; os.chdir({str(self.folder)!r})",  # the server began it where another notebook was
        )

    def evaluate(self, expression: str) -> str:
        """`repr` of a Python expression in the kernel, once it has taken what was done on the page.

        The page, too, has then taken whatever Python had told it before.
        """
        self.page.wait_for_function("() => window.unanswered.size === 0")
        answer = self.page.evaluate(
            """async expression => {
                const kernel = window.jupyterapp.shell.currentWidget.context.sessionContext.session.kernel;
                const request = { code: "", silent: true, user_expressions: { it: expression } };
                const reply = await kernel.requestExecute(request).done;
                return reply.content.user_expressions.it;
            }""",
            expression,
        )
        if answer["status"] != "ok":
            raise AssertionError(f"{answer['ename']}: {answer['evalue']}")
        return answer["data"]["text/plain"]

    def wait_for(self, expression: str, value: object) -> None:
        """Wait until a Python expression has a value in the kernel."""
        seen = ""

        def holds() -> bool:
            nonlocal seen
            seen = self.evaluate(expression)
            return seen == repr(value)

        until(self.page, holds, lambda: f"{expression} is still {seen}, not {value!r}")

    def execute(self, code: str) -> None:
        """Run statements in the kernel, outside any cell."""
        assert self.evaluate(f"exec({code!r})") == "None"

    def view(self, index: int = 0) -> View:
        """The n-th view of the notebook, once its first frame is drawn."""
        root = self.page.locator(".scenewidget").nth(index)
        until(self.page, lambda: self.page.locator(".scenewidget").count() > index, self._no_view)
        root.evaluate("root => root.scrollIntoView({ block: 'center' })")  # off screen, nothing is drawn
        view = View(self.page, root)
        view.wait("ready", "true")
        return view

    def _no_view(self) -> str:
        shown = self.page.locator(".jp-Notebook").all_inner_texts()
        counts = self.page.evaluate(EXECUTION_COUNTS)
        return f"there is no such view; cells {counts}, on the page: {shown}, in the console: {self.errors}"

    def leave(self, free_kernels: list[str]) -> bool:
        """Close the notebook, end its kernel or keep it; whether the page is fit for another one."""
        if not self.page.evaluate("() => Boolean(window.jupyterapp?.shell.currentWidget)"):
            return False
        is_tidy, kernel = self.page.evaluate(LEAVE, FORGET if self.keeps_kernel else None)
        free_kernels += [kernel] if kernel else []
        return is_tidy

    def close(self) -> None:
        """End the kernel and the page."""
        self.page.evaluate(
            "() => window.jupyterapp?.shell.currentWidget?.context?.sessionContext?.shutdown()"
        )
        self.page.close()


@dataclass
class View:
    """A SceneView on the page; places are pixels from its upper left corner."""

    page: Any
    root: Any

    def state(self, name: str) -> str:
        """The `data-` attribute of that name."""
        return self.root.get_attribute(f"data-{name}")

    def wait(self, name: str, value: str) -> None:
        """Wait until an attribute has a value."""
        from playwright.sync_api import TimeoutError as Late

        try:
            self.page.wait_for_function(
                "([root, name, value]) => root.getAttribute(`data-${name}`) === value",
                arg=[self.root.element_handle(), name, value],
            )
        except Late:
            seen = self.root.evaluate(STATE)
            raise AssertionError(f"data-{name} never became {value!r}: {seen}") from None

    def settle(self) -> None:
        """Wait until the camera has stopped and what is under the pointer is known again."""
        self.wait_frames(2)  # in which a new layout becomes a new size
        self.wait("moving", "false")

    def wait_frames(self, n: int) -> None:
        """Wait until the page has been drawn so many times."""
        self.page.evaluate(
            "async n => { while (n-- > 0) await new Promise((drawn) => requestAnimationFrame(drawn)); }", n
        )

    def wait_until_pointed(self) -> str:
        """Wait until a part is under the pointer, and say which."""
        self.page.wait_for_function("root => root.dataset.hovered !== ''", arg=self.root.element_handle())
        return self.state("hovered")

    def size(self) -> tuple[float, float]:
        """Width and height of the picture."""
        box = self.root.locator("canvas").bounding_box()
        return box["width"], box["height"]

    def point(self, x: float, y: float) -> None:
        """Move the pointer there, once the picture stands still."""
        self.settle()
        box = self.root.locator("canvas").bounding_box()
        self.page.mouse.move(box["x"] + x, box["y"] + y)

    def parts(self, step: int = 12) -> dict[str, tuple[float, float]]:
        """Parts that a pointer meets on a raster ("" is none), each with a place well inside."""
        self.settle()
        return {part: tuple(place) for part, place in self.root.evaluate(PARTS, step).items()}

    def drag(
        self, start: tuple[float, float], end: tuple[float, float], *, button: str = "left", steps: int = 8
    ) -> None:
        """Press at one place, move to another, release."""
        self.point(*start)
        self.page.mouse.down(button=button)
        box = self.root.locator("canvas").bounding_box()
        self.page.mouse.move(box["x"] + end[0], box["y"] + end[1], steps=steps)
        self.page.mouse.up(button=button)

    def pixels(self) -> np.ndarray:
        """(height, width, 3) uint8 what a person sees of it at rest, toolbar included."""
        self.settle()
        return np.asarray(Image.open(io.BytesIO(self.root.screenshot())).convert("RGB"))


def until(
    page: Any, holds: Callable[[], object], complaint: Callable[[], str] = lambda: "it never came to hold"
) -> None:
    """Wait until something holds that is seen from here only, as what pixels show."""
    deadline = time.monotonic() + PATIENCE_SECONDS
    while not holds():
        assert time.monotonic() < deadline, complaint()
        page.wait_for_timeout(50)


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Share of the pixels, between the bars, that are clearly different."""
    return float((np.abs(one[60:-60].astype(int) - other[60:-60]) > 20).mean())


def errors_of(page: Any) -> list[str]:
    """What goes wrong on a page from now on, but for the remarks of its host."""
    errors: list[str] = []

    def note(text: str) -> None:
        if not any(remark in text for remark in HARMLESS):
            errors.append(text)

    page.on("pageerror", lambda error: note(str(error)))
    page.on("console", lambda message: note(message.text) if message.type == "error" else None)
    return errors


def notebook_of(cells: Sequence[str]) -> dict[str, Any]:
    """What is in the file of a notebook with these cells."""
    empty = {"cell_type": "code", "metadata": {}, "outputs": [], "execution_count": None}
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {
        "cells": [{**empty, "source": cell, "id": f"c{i}"} for i, cell in enumerate(cells)],
        "metadata": {"kernelspec": kernel},
        "nbformat": 4,
        "nbformat_minor": 5,
    }


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=2) as reply:
            return reply.status == 200
    except OSError:
        return False
