"""The widget under load: malformed messages, many hands at once, an undo storm, twenty widgets,
a cell that is run two hundred times.

After each, log, picture and disk must say the same; the figures are printed.

python tests/benchmarks/load.py --messages 20000 --seconds 120 --edits 2000 --widgets 20
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import hashlib
import io
import json
import os
import queue
import resource
import sys
import tempfile
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "widget"))

import ipywidgets
import shapes
from IPython.core.interactiveshell import InteractiveShell
from jupyter_client.blocking import BlockingKernelClient
from jupyter_client.manager import KernelManager
from sent import array

import scenewidget as sw
from scenewidget.editing.edits import EditError
from scenewidget.editing.project import read_log
from scenewidget.editing.project_reader import read_project
from scenewidget.editing.session import Session, apply_edits
from scenewidget.widget import lifetimes

PARAMS = {"n_segments": 6, "n_runs": 4, "n_graph_runs": 4}
VALUES: list[Any] = [
    None, True, -1, 0, 3, 1e300, float("nan"), 2**70, "", "x" * 5000, "final", "\ud800", [], [1, [2]], {},
    {"kind": "merge"}, "merge", "undo", [0] * 1000, "__class__", "base", -0.0,
]  # fmt: skip
KINDS = [
    "merge", "split", "relabel", "cut", "undo", "redo", "go_to", "save", "choose", "preview_cut", "suggest",
    "cancel", "brush", "camera", "paint", "slice", "ready", 3, None, [], {},
]  # fmt: skip
KEYS = [
    "face", "onto_face", "face_a", "face_b", "level", "revision", "client", "number", "name", "n", "notice",
    "action", "request", "faces", "point", "normal", "first", "kind",
]  # fmt: skip


def agreement(session: Session, view: Any) -> list[str]:
    """What log, picture and disk don't agree on."""
    out = []
    labels = session.snapshot().labels
    shown = array(view, "atom_segment").astype(np.int64)
    if not np.array_equal(np.where(shown < session.n_segments, shown, -1), labels):
        out.append("the picture has other segments than the session")
    replayed = apply_edits(session.automatic, session.edits)
    if not np.array_equal(replayed.labels, session.segmentation.labels):
        out.append("the log gives other segments than the session has")
    if session.path is None:
        return [*out, "there is no file"]
    log = read_log(read_project(session.path).operations)
    if [edit for edit, _ in log.done] != session.edits or tuple(log.undone[::-1]) != tuple(session.undone):
        out.append("the disk has other edits than the session")
    return out


def report(title: str, seconds: float, said: str, troubles: list[str]) -> int:
    """Print a line; how much is wrong."""
    state = "log, picture and disk agree" if not troubles else "WRONG: " + "; ".join(troubles)
    print(f"{title:32} {seconds:7.1f} s  {said}; {state}", flush=True)
    return len(troubles)


def malformed_messages(n: int) -> int:
    """Send messages that no page of ours sends, and a sound edit now and then."""
    mesh = shapes.box(12)
    widget = sw.SceneWidget(mesh, sw.Params(**PARAMS), autosave="messages.swproj")
    widget.wait()
    rng = np.random.default_rng(0)
    pick = lambda values: values[int(rng.integers(len(values)))]  # noqa: E731
    refused, slowest = 0, 0.0
    begin = time.perf_counter()
    for k in range(n):
        message: Any = {key: pick(VALUES) for key in KEYS if rng.random() < 0.4}
        message["kind"] = pick(KINDS)
        if rng.random() < 0.05:
            message = pick(VALUES)
        if k % 20 == 0:
            message = {"kind": "relabel", "face": int(rng.integers(mesh.n_faces)), "name": f"name {k}"}
            message |= {"revision": widget.view.revision, "client": "benchmark", "number": k}
        start = time.perf_counter()
        widget.view._handle_custom_msg(message, [])
        refused += widget.view.error != ""
        widget.view.error = ""
        slowest = max(slowest, time.perf_counter() - start)
    seconds = time.perf_counter() - begin
    troubles = agreement(widget.session, widget.view)
    said = f"{n} messages, {refused} told as errors, slowest {1e3 * slowest:.0f} ms, "
    said += f"{len(widget.session.edits)} edits done"
    widget.close()
    return report("malformed messages", seconds, said, troubles)


def undo_storm(n: int, n_faces: int) -> int:
    """Edit, undo everything, redo everything, walk at random."""
    side = round((n_faces / 12) ** 0.5)
    mesh = shapes.box(side)
    labels = np.arange(mesh.n_faces) // (mesh.n_faces // 600)
    levels = {"dihedral": np.arange(mesh.n_faces, dtype=np.int32) // 20}
    session = Session(mesh, sw.Segmentation(mesh, labels.astype(np.int32), levels=levels))
    session.save("storm.swproj")
    rng = np.random.default_rng(0)
    begin, times = time.perf_counter(), []
    while len(session.edits) < n:
        a, b = (int(x) for x in rng.integers(0, mesh.n_faces, 2))
        start = time.perf_counter()
        with contextlib.suppress(EditError):
            session.merge(a, b, "dihedral") if rng.random() < 0.7 else session.split(a, "dihedral")
            times.append(time.perf_counter() - start)
    expected = session.segmentation.labels
    for step in (session.undo, session.redo):
        for _ in range(n):
            start = time.perf_counter()
            step()
            times.append(time.perf_counter() - start)
    troubles = [] if np.array_equal(session.segmentation.labels, expected) else ["redo gives other segments"]
    for place in rng.integers(0, n, 20):
        session.go_to(int(place))
    session.go_to(n)
    if not np.array_equal(session.segmentation.labels, expected):
        troubles.append("walking gives other segments")
    log = read_log(read_project(session.path).operations)
    if [edit for edit, _ in log.done] != session.edits or not session.is_saved:
        troubles.append("the disk has other edits than the session")
    seconds = time.perf_counter() - begin
    quantiles = "{:.2f} median, {:.1f} at 99 %".format(*1e3 * np.quantile(times, [0.5, 0.99]))
    said = f"{len(times)} edits, undos and redos at {mesh.n_faces} faces, each {quantiles} ms"
    return report("undo storm", seconds, said, troubles)


def many_widgets(n: int) -> int:
    """Twenty widgets in one notebook, each with its own edits in its own file."""
    mesh, _ = sw.datasets.load_room()
    begin = time.perf_counter()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    widgets = []
    for _ in range(n):
        widgets.append(sw.SceneWidget(mesh, sw.Params(**PARAMS), autosave=f"many-{len(widgets)}.swproj"))
    for widget in widgets:
        widget.wait(None)
    troubles = []
    for k, widget in enumerate(widgets):
        for label in range(k + 1):
            face = int(np.flatnonzero(widget.segmentation.labels == label % widget.session.n_segments)[0])
            with contextlib.suppress(EditError):
                widget.session.relabel(face, f"{k} {label}")
        widget.save()
        troubles += agreement(widget.session, widget.view)
    if len({widget.session.path for widget in widgets}) < n:
        troubles.append("two widgets write one file")
    threads = threading.active_count()
    for widget in widgets:
        widget.close()
    memory = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e3
    said = f"{n} widgets of {mesh.n_faces} faces, {memory:.0f} MB more at most, {threads} threads"
    return report("widgets in one notebook", time.perf_counter() - begin, said, troubles)


def rerun_cell(n: int) -> int:
    """One cell run again and again without waiting for what it computes."""
    shell = InteractiveShell()
    shell.user_ns |= {"sw": sw, "mesh": sw.datasets.load_room()[0]}
    request = {"header": {"msg_id": 0}, "metadata": {"cellId": "a"}}
    shell.kernel = SimpleNamespace(get_parent=lambda channel: request)
    lifetimes._shell = lambda: shell
    begin = time.perf_counter()
    megabytes, counts = [], []
    for k in range(n):
        request["header"] = {"msg_id": k}
        with contextlib.redirect_stdout(io.StringIO()):
            shell.run_cell("w = sw.SceneWidget(mesh, autosave=False)\nw", store_history=True)
        if k + 1 in (n // 2, n):
            shell.user_ns["w"].wait(None)
            gc.collect()
            pages = int(Path("/proc/self/statm").read_text().split()[1])  # Linux
            megabytes.append(pages * resource.getpagesize() / 1e6)
            counts.append((threading.active_count(), len(ipywidgets.widgets.widget._instances)))
    troubles = [f"{counts[0]} threads and widgets became {counts[1]}"] if counts[1] > counts[0] else []
    said = f"{n} runs, {megabytes[0]:.0f} MB after half of them, {megabytes[1]:.0f} MB at the end"
    return report("a cell run again", time.perf_counter() - begin, said, troubles)


# --- a real kernel --------------------------------------------------------------------------------

KERNEL = """
import threading, time, json, hashlib, sys
sys.path[:0] = {paths!r}
import numpy as np, shapes, load
import scenewidget as sw
from scenewidget.editing.edits import EditError
mesh = shapes.box(16)
w = sw.SceneWidget(mesh, sw.Params(**load.PARAMS), autosave="kernel.swproj")
w.wait(None)
w.session.relabel(0, "begin")
w.save()
n_script, stop = 0, threading.Event()

def script():
    global n_script
    rng = np.random.default_rng(1)
    while not stop.is_set():
        a, b = (int(x) for x in rng.integers(0, mesh.n_faces, 2))
        try:
            if n_script % 2:
                w.session.merge(a, b, "base")
            else:
                w.session.relabel(a, f"script {{a}}")
        except EditError:
            pass
        n_script += 1
        time.sleep(0.01)

thread = threading.Thread(target=script)
thread.start()
w
"""
STOP = """
stop.set(); thread.join()
"""
CHECK = """
print(json.dumps({
    "troubles": load.agreement(w.session, w.view), "script": n_script, "edits": len(w.session.edits),
    "operations": len(w.session.to_frame()), "saved": w.session.is_saved,
    "picture": hashlib.md5(bytes(w.view._atom_segment)).hexdigest(), "revision": w.view.revision,
}))
"""


class Page:
    """What a page is to a kernel: a client of its own, with the state of the view as the messages tell it."""

    def __init__(self, manager: Any, seed: int) -> None:
        self.client = BlockingKernelClient(connection_file=manager.connection_file)  # with its own identity
        self.client.load_connection_file()
        self.client.start_channels()
        for last in (False, False, False, True):
            try:
                self.client.wait_for_ready(timeout=60)
                break
            except RuntimeError:  # on a busy machine, a kernel that is slow passes for dead
                if last:
                    raise
        self.state: dict[str, Any] = {}
        self.comm = ""
        self.printed: list[str] = []
        self.idle: set[str] = set()
        self.n_sent = 0
        self._rng = np.random.default_rng(seed)
        self._name = f"page {seed}"

    def listen(self, seconds: float = 0.0) -> None:
        """Take what has come, and what comes within some seconds."""
        deadline = time.monotonic() + seconds
        while True:
            try:
                message = self.client.get_iopub_msg(timeout=max(0.0, deadline - time.monotonic()))
            except queue.Empty:
                return
            kind, content = message["msg_type"], message["content"]
            if kind == "stream" and content["name"] == "stdout":
                self.printed.append(content["text"])
            elif kind == "error":
                self.printed.append("\n".join(content["traceback"]))
            elif kind == "status" and content["execution_state"] == "idle":
                self.idle.add(message["parent_header"].get("msg_id", ""))
            elif kind == "comm_open" and "save_state" in content["data"].get("state", {}):
                self.comm = content["comm_id"]
                self._take(content["data"], message["buffers"])
            elif (
                kind == "comm_msg"
                and content["comm_id"] == self.comm
                and content["data"]["method"] == "update"
            ):
                self._take(content["data"], message["buffers"])

    def _take(self, data: dict[str, Any], buffers: list[Any]) -> None:
        self.state.update(data["state"])
        for path, buffer in zip(data.get("buffer_paths", []), buffers):
            if len(path) == 1:
                self.state[path[0]] = bytes(buffer)

    def edit(self, n_faces: int) -> None:
        """Send an edit as a page does."""
        a, b = (int(x) for x in self._rng.integers(0, n_faces, 2))
        kinds = [
            {"kind": "merge", "face": a, "onto_face": b, "level": "base"},
            {"kind": "split", "face": a, "level": "base"},
            {"kind": "relabel", "face": a, "name": f"{self._name} {b}"},
            {"kind": "undo"},
            {"kind": "redo"},
        ]
        self.n_sent += 1
        message = kinds[int(self._rng.integers(len(kinds)))]
        message |= {"revision": self.state.get("revision", 0), "client": self._name, "number": self.n_sent}
        content = {"comm_id": self.comm, "data": {"method": "custom", "content": message}}
        self.client.shell_channel.send(self.client.session.msg("comm_msg", content))

    def run(self, code: str, timeout: float) -> None:
        """Execute a cell and wait for its end."""
        id_ = self.client.execute(code)
        deadline = time.monotonic() + timeout
        while id_ not in self.idle:
            if time.monotonic() > deadline:
                raise TimeoutError("\n".join([code, *self.printed]))
            self.listen(0.05)


def many_hands(seconds: float) -> int:
    """Two pages and a script edit one session in a kernel of its own."""
    paths = [str(Path(__file__).parent), *sys.path[:2]]
    manager = KernelManager(kernel_name="python3", transport="ipc" if os.name == "posix" else "tcp")
    with tempfile.TemporaryDirectory(prefix="sw-", dir="/tmp") as runtime:
        manager.connection_file = f"{runtime}/kernel.json"
        manager.start_kernel(cwd=str(Path.cwd()))
        try:
            pages = [Page(manager, seed) for seed in (1, 2)]
            pages[0].run(KERNEL.format(paths=paths), 120)
            for page in pages:
                while not page.comm:
                    page.listen(0.1)
            begin = time.perf_counter()
            while time.perf_counter() - begin < seconds:
                for page in pages:
                    page.edit(12 * 16 * 16)
                    page.listen(0.025)
            pages[0].run(STOP, 60)
            pages[0].run(CHECK, 60)  # after whatever the pages have sent
            for page in pages:
                page.listen(1)
            said = json.loads(pages[0].printed[-1])
            took = time.perf_counter() - begin
            troubles = said["troubles"] + ([] if said["saved"] else ["not saved"])
            for page in pages:
                if hashlib.md5(page.state["_atom_segment"]).hexdigest() != said["picture"]:
                    troubles.append("a page shows other segments than the kernel has")
                if page.state["revision"] != said["revision"] or page.state["save_state"] != "saved":
                    troubles.append("a page is behind")
            text = f"two pages sent {sum(page.n_sent for page in pages)} edits, a script {said['script']}, "
            text += f"{said['operations']} operations logged"
            return report("two pages and a script", took, text, troubles)
        finally:
            manager.shutdown_kernel(now=True)


def main() -> None:
    """Run what is asked for and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=20_000)
    parser.add_argument("--seconds", type=float, default=120, help="of two pages and a script in a kernel")
    parser.add_argument("--edits", type=int, default=2_000)
    parser.add_argument("--faces", type=int, default=200_000, help="of the undo storm")
    parser.add_argument("--widgets", type=int, default=20)
    parser.add_argument("--reruns", type=int, default=200, help="of one cell")
    arguments = parser.parse_args()
    n_wrong = 0
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        if arguments.messages:
            n_wrong += malformed_messages(arguments.messages)
        if arguments.edits:
            n_wrong += undo_storm(arguments.edits, arguments.faces)
        if arguments.widgets:
            n_wrong += many_widgets(arguments.widgets)
        if arguments.reruns:
            n_wrong += rerun_cell(arguments.reruns)
        if arguments.seconds:
            n_wrong += many_hands(arguments.seconds)
    sys.exit(n_wrong > 0)


if __name__ == "__main__":
    main()
