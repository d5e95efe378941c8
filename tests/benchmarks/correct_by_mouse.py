"""How many actions of the mouse lead from the automatic result to 1 − RI ≤ 0.03? In a real JupyterLab.

    python tests/benchmarks/correct_by_mouse.py [--scans bedroom real/kitchen_12mm] [--target 0.03]

An annotator who knows the truth (as `scenewidget.editing.simulate_annotator`, one edit at a time) says what
to do next; a real mouse in a real browser does it: drag-merge or click, click; right click to split;
dragging with Shift to look from elsewhere. Segments that can't be seen from any side are clicked in the list;
finer parts that can't are left out, and the next best edit made. Scans that aren't beside the repository are
passed over.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "browser"))

import conftest
from scans import DATA

KERNEL = '''
import json
import numpy as np
import scenewidget as sw
from scenewidget.editing.annotator import Judge

class Annotator(Judge):
    unseen = {"base": set(), "dihedral": set()}  # parts that can't be pointed at

    def _parts(self, part):
        level = ("base", "dihedral")[len(self.levels)]
        return super()._parts(np.where(np.isin(part, list(self.unseen[level])), -1, part))

def plan():
    judge = Annotator(w.session, truth)
    edit = judge.best_edit()
    if edit is None:
        return json.dumps({"error": judge.error})
    face = edit.faces[0] if hasattr(edit, "faces") else edit.face
    labels, automatic = w.session.segmentation.labels, w.session.automatic
    column = labels if edit.level == "final" else automatic.level(edit.level)
    onto = getattr(edit, "onto_face", None)
    return json.dumps({"error": judge.error, "kind": type(edit).__name__, "level": edit.level,
        "part": int(column[face]), "target": None if onto is None else int(labels[onto]),
        "target_parts": [] if onto is None else whole_parts(column, labels == labels[onto])})

def whole_parts(column, is_inside):
    """Parts that lie in a segment with all of their faces."""
    inside = np.bincount(column[is_inside & (column >= 0)], minlength=column.max() + 1)
    return np.flatnonzero((inside > 0) & (inside == np.bincount(column[column >= 0]))).tolist()

def read(name):
    """A scan and its truth: a mesh with an array beside it, or an archive of both."""
    if not name.endswith(".npz"):
        return sw.load_mesh(name), np.load(name.replace(".ply", "_instances.npy")).astype(np.int64)
    arrays = np.load(name)
    mesh = sw.Mesh(arrays["vertices"], arrays["faces"], arrays["colors"])
    return mesh, arrays["instances"].astype(np.int64)

mesh, truth = read(%r)
w = sw.SceneWidget(mesh, height=620)
w.wait(600)
w
'''
KEYS = {"dihedral": "1", "base": "2", "final": "3"}
N_SIDES = 6
ORBIT = 140  # pixels of a drag, a sixth of a turn
MARGINS = (70, 90, 30)  # of the toolbar above, the status line below, the edges


class Hand:
    """The mouse over one widget; knows from which side it looks."""

    def __init__(self, book: conftest.Notebook) -> None:
        self.book, self.page = book, book.page
        self.view = book.view()
        self.view.wait("busy", "false")
        self.view.root.get_by_role("button", name="Edit", exact=True).click()
        self.view.wait("mode", "edit")
        self.side = 0
        self.n_looks = 0
        self.n_rows = 0

    def press(self, key: str) -> None:
        """A key, with the picture in focus."""
        self.view.root.focus()
        self.page.keyboard.press(key)

    def look_from(self, side: int) -> None:
        """Turn the scan by dragging with Shift."""
        width, height = self.view.size()
        while self.side != side:
            self.page.keyboard.down("Shift")
            self.view.drag((width / 2 - ORBIT / 2, height / 2), (width / 2 + ORBIT / 2, height / 2), steps=3)
            self.page.keyboard.up("Shift")
            self.side = (self.side + 1) % N_SIDES
            self.n_looks += 1
        self.settle()

    def settle(self) -> None:
        """Until what lies under the pointer is known."""
        self.view.wait("moving", "false")

    def find(self, part: int, level: str) -> tuple[int, tuple[float, float]] | None:
        """A side and a place from where a part can be pointed at."""
        self.press(KEYS[level])
        for turn in range(N_SIDES):
            self.look_from((self.side + turn) % N_SIDES if turn else self.side)
            place = self.look_for([part])
            if place:
                return self.side, place
        return None

    def look_for(self, parts: list[int]) -> tuple[float, float] | None:
        """A place of one of some parts, as one sees it now."""
        width, height = self.view.size()
        above, below, edge = MARGINS
        wanted = {str(part) for part in parts}
        for part, place in self.view.parts(step=10).items():
            if part in wanted and above < place[1] < height - below and edge < place[0] < width - edge:
                return place
        return None

    def click(self, place: tuple[float, float], button: str = "left") -> None:
        """Press and release."""
        self.view.point(*place)
        self.page.mouse.down(button=button)
        self.page.mouse.up(button=button)

    def do(self, step: dict) -> bool:
        """Carry out an edit; False if something of it can't be seen."""
        target = None if step["target"] is None else self.find(step["target"], "final")
        source = self.find(step["part"], step["level"])
        if source is None or (step["target"] is not None and target is None):
            return step["target"] is not None and step["level"] == "final" and self.do_in_list(step)
        self.look_from(source[0])
        if target is None:
            self.click(source[1], button="right")
            return True
        if target[0] == source[0]:
            self.view.point(*source[1])
            self.page.mouse.down()
        else:
            self.click(source[1])
            self.view.wait("picked", str(step["part"]))
            self.look_from(target[0])
            again = self.look_for(step["target_parts"])  # after some turns it isn't quite where it was
            if again is None:
                self.press("Escape")
                return step["level"] == "final" and self.do_in_list(step)
            target = (target[0], again)
        self.view.point(*target[1])
        self.view.wait("target", str(step["target"]))
        if target[0] != source[0]:
            self.page.mouse.down()
        self.page.mouse.up()
        return True

    def do_in_list(self, step: dict) -> bool:
        """Merge two segments by clicking on their rows in the list."""
        self.press(KEYS["final"])
        self.press("l")
        for segment in (step["part"], step["target"]):
            row = self.view.root.locator(f".sw-list tr[data-segment='{segment}'] .sw-row-name")
            row.scroll_into_view_if_needed()
            row.click()
            if segment == step["part"]:
                self.view.wait("picked", str(segment))
        self.view.wait("pending", "0")
        self.press("l")
        self.n_rows += 1
        return True


def path_of(name: str) -> Path:
    """The file of a scan."""
    archive = DATA / f"{name}.npz"
    return archive if archive.exists() else DATA / f"{name}.ply"


def correct(book: conftest.Notebook, name: str, target: float, most: int) -> None:
    """Open a scan and work until the target is reached."""
    book.open([KERNEL % str(path_of(name))])
    book.run_all()
    hand = Hand(book)
    print(f"{name}: {book.evaluate('w')}", flush=True)
    unseen, start = 0, time.perf_counter()
    for _ in range(most):
        step = json.loads(eval(book.evaluate("plan()")))
        n = int(book.evaluate("len(w.session.edits)"))
        print(f"  after {n} edits 1-RI = {step['error']:.4f}", flush=True)
        if step["error"] <= target or "kind" not in step:
            break
        if not hand.do(step):
            unseen += 1
            if step["level"] == "final":
                print(f"  {step['kind']} of a segment that can't be seen: stopped")
                break
            book.execute(f"Annotator.unseen[{step['level']!r}].add({step['part']})")
            continue
        hand.view.wait("pending", "0")
        done = book.evaluate("[type(edit).__name__ + ' ' + edit.level for edit in w.session.edits][-1]")
        if int(book.evaluate("len(w.session.edits)")) != n + 1 or done != f"'{step['kind']} {step['level']}'":
            raise AssertionError(f"the mouse meant {step}, but {done} was done")
        print(f"  {step['kind']} at level {step['level']!r} by the mouse", flush=True)
    n, file = int(book.evaluate("len(w.session.edits)")), book.evaluate("w.view.save_state")
    print(
        f"{name}: {n} edits by the mouse ({hand.n_rows} in the list of segments), {hand.n_looks} turns of "
        f"the scan, {unseen} edits unseen, {time.perf_counter() - start:.0f} s; 1-RI = {step['error']:.4f}; "
        f"project {file}",
        flush=True,
    )


def main() -> None:
    """Correct each scan."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scans", nargs="+", default=["bedroom", "bedroom_noisy"])
    parser.add_argument("--target", type=float, default=0.03)
    parser.add_argument("--most", type=int, default=60, help="edits, at most")
    parser.add_argument("--picture", help="file to which a screenshot goes at the end")
    arguments = parser.parse_args()
    scans = [name for name in arguments.scans if path_of(name).exists()]
    for name in set(arguments.scans) - set(scans):
        print(f"{name}: not there, left out")
    if not scans:
        return
    from playwright.sync_api import sync_playwright

    with (
        tempfile.TemporaryDirectory() as home,
        sync_playwright() as playwright,
        conftest.lab(Path(home)) as server,
    ):
        browser = playwright.chromium.launch(executable_path=conftest.find_chromium(), args=conftest.FLAGS)
        for name in scans:
            page = browser.new_page(viewport={"width": 1300, "height": 1000})
            page.set_default_timeout(300_000)  # large scans take their time
            book = conftest.Notebook(page, server)
            try:
                correct(book, name, arguments.target, arguments.most)
                if arguments.picture:
                    book.view().root.screenshot(path=arguments.picture)
            finally:
                book.close()
        browser.close()


if __name__ == "__main__":
    main()
