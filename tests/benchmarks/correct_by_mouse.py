"""How many actions of the mouse lead from the automatic result to 1 − RI ≤ 0.03? In a real JupyterLab.

    python tests/benchmarks/correct_by_mouse.py [--scans bedroom real/kitchen_12mm] [--target 0.03] [--tools]

An annotator who knows the truth (as `scenewidget.editing.simulate_annotator`, one edit at a time) says what
to do next; a real mouse in a real browser does it: drag-merge or click, click; right click to split;
dragging with Shift to look from elsewhere. Segments that can't be seen from any side are clicked in the list;
finer parts that can't are left out, and the next best edit made. With ``--tools`` the annotator also draws
around a thing that is melted into a segment, with the lasso set to one segment and through, from the side
from which that helps most, where it helps more than any merge or split. Scans that aren't beside the
repository are passed over.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import tempfile
import time
from collections.abc import Generator, Sequence
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
    return json.dumps({"error": judge.error, "after": error_after(edit),
        "kind": type(edit).__name__, "level": edit.level, "part": int(column[face]),
        "target": None if onto is None else int(labels[onto]),
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

def table_of(labels):
    """(n_segments, n_things) faces that both label."""
    keep = (labels >= 0) & (truth >= 0)
    n = truth.max() + 1
    return np.bincount(labels[keep] * n + truth[keep], minlength=(labels.max() + 1) * n).reshape(-1, n)

def error_after(edit):
    """1 - RI if an edit were made."""
    labels, automatic = w.session.segmentation.labels, w.session.automatic
    face = edit.faces[0] if hasattr(edit, "faces") else edit.face
    column = labels if edit.level == "final" else automatic.level(edit.level)
    moves = column == column[face]
    if type(edit).__name__ == "Split" and edit.level == "final":
        moves &= automatic.labels == automatic.labels[face]
    onto = getattr(edit, "onto_face", None)
    target = labels.max() + 1 if onto is None else labels[onto]
    table = table_of(np.where(moves, target, labels)).astype(float)
    total = table.sum()
    squares = (table.sum(1) ** 2).sum() + (table.sum(0) ** 2).sum() - 2 * (table**2).sum()
    return float(squares / (total * total - total))

def seen_from(camera, width, height):
    """(n_faces, 2) pixel of each face's middle, as js/src/scene/camera.js has it; NaN behind the eye."""
    cy, sy, cp, sp = (f(camera[k]) for k in ("yaw", "pitch") for f in (np.cos, np.sin))
    forward = np.array([-cp * cy, -cp * sy, -sp])
    away = MIDDLES - (np.array(camera["target"]) - camera["distance"] * forward)
    depth = np.where(away @ forward > 0, away @ forward, np.nan) * camera.get("tangent", np.tan(np.pi / 10))
    x = away @ np.array([-sy, cy, 0]) / (depth * width / height)
    y = away @ np.array([-sp * cy, -sp * sy, cp]) / depth
    return np.column_stack([(1 + x) / 2 * width, (1 - y) / 2 * height])

def outline_of(places, width, height, cell=6):
    """Corners of a line around most of some places; None where they are too few."""
    from contourpy import contour_generator
    from scipy import ndimage
    shape = (int(height) // cell + 3, int(width) // cell + 3)
    at = (places[np.isfinite(places).all(1)] / cell).astype(int) + 1
    at = at[((at > 0) & (at < np.array(shape[::-1]) - 1)).all(1)]
    counts = np.zeros(shape)
    np.add.at(counts, (at[:, 1], at[:, 0]), 1)
    parts, n = ndimage.label(ndimage.binary_closing(counts > 0, iterations=2))
    if n == 0:
        return None
    largest = parts == 1 + np.argmax(ndimage.sum(counts, parts, range(1, n + 1)))
    lines = contour_generator(z=ndimage.binary_fill_holes(largest).astype(float)).lines(0.4)
    return (max(lines, key=len)[::2] - 0.5) * cell

def best_lasso(width, height, turns, only=None, without=()):
    """The outline around one thing in one segment that helps most, from here or after some turns."""
    from matplotlib.path import Path as Outline
    labels = w.session.segmentation.labels
    table = table_of(labels).astype(float)
    rows, things = table.sum(1), table.sum(0)
    total = table.sum()
    ideal = 2 * table * (table - rows[:, None])  # change of the squares, if exactly that were taken out
    found = None
    for index in (np.argsort(ideal, axis=None)[:6] if only is None else [only]):
        segment, thing = np.unravel_index(index, ideal.shape)
        if ideal[segment, thing] >= 0 or int(index) in without:
            continue
        is_inside = labels == segment
        for turn in turns:
            camera = dict(w.view._camera)
            camera["yaw"] -= turn * %(turn)r
            places = seen_from(camera, width, height)
            line = outline_of(places[is_inside & (truth == thing)], width, height)
            if line is None or len(line) < 4:
                continue
            above, below, edge = %(margins)r
            if not ((line > (edge, above)) & (line < (width - edge, height - below))).all():
                continue
            within = np.flatnonzero(np.isfinite(places).all(1))
            within = within[Outline(line).contains_points(places[within])]
            if len(within) == 0 or np.bincount(labels[within][labels[within] >= 0]).argmax() != segment:
                continue  # the lasso takes the segment that has most in it
            taken = within[(labels[within] == segment) & (truth[within] >= 0)]
            share = np.bincount(truth[taken], minlength=table.shape[1]).astype(float)
            m = share.sum()
            change = 2 * m * (m - rows[segment]) - 4 * (share * (share - table[segment])).sum()
            squares = (rows**2).sum() + (things**2).sum() - 2 * (table**2).sum()
            error = float((squares + change) / (total * total - total))
            if found is None or error < found["error"]:
                found = {"error": error, "turn": turn, "cell": int(index), "line": line.round(1).tolist()}
    return json.dumps(found)

mesh, truth = read(%(path)r)
w = sw.SceneWidget(mesh, height=620)
w.wait(600)
from scenewidget.widget.wire import middle_of
up = np.array(w.view._up)
k = int(np.argmax(np.abs(up)))
first = np.eye(3)[(k + 1) %% 3] - up[(k + 1) %% 3] * up
first /= np.linalg.norm(first)
MIDDLES = (mesh.face_centroids - middle_of(mesh)) @ np.array([first, np.cross(up, first), up]).T
w
'''
KEYS = {"dihedral": "1", "base": "2", "final": "3"}
N_SIDES = 6
ORBIT = 140  # pixels of a drag, a sixth of a turn
TURN = 0.0075 * ORBIT  # radians that it turns by
MARGINS = (70, 90, 30)  # of the toolbar above, the status line below, the edges
BELOW = 130  # with the row of options of a tool
WORTH = 1.2  # times the gain of a merge, from which on the annotator takes up the lasso


class Hand:
    """The mouse over one widget; knows from which side it looks."""

    def __init__(self, book: conftest.Notebook) -> None:
        self.book, self.page = book, book.page
        self.view = book.view()
        self.view.wait("busy", "false")
        self.page.wait_for_function(
            "(root) => Number(root.dataset.segments) > 0", arg=self.view.root.element_handle()
        )
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

    def draw(self, line: list[list[float]]) -> None:
        """Around something, with the lasso that takes of one segment alone all that lies within."""
        self.press("q")
        self.view.wait("tool", "lasso")
        for option in ("Through", "One segment"):
            button = self.view.root.get_by_role("button", name=option, exact=True)
            if button.get_attribute("aria-pressed") != "true":
                button.click()
        self.view.point(*line[0])
        self.page.mouse.down()
        for place in [*line[1:], line[0]]:
            self.view.point(*place)
        self.page.mouse.up()
        self.view.wait("pending", "0")
        self.press("q")
        self.view.wait("tool", "merge")

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


def lasso(book: conftest.Notebook, hand: Hand, step: dict, failed: list[int]) -> bool:
    """Draw around a thing where that helps clearly more than the next merge or split; whether it was done."""
    size, now = hand.view.size(), step["error"]
    if book.evaluate("'yaw' in w.view._camera") != "True":  # it is told once it has moved
        hand.look_from((hand.side + 1) % N_SIDES)
    ask = f"best_lasso({size[0]}, {size[1]}, {{}}, {{}}, {failed})"
    found = json.loads(eval(book.evaluate(ask.format(list(range(N_SIDES)), None))))
    if found is None or now - found["error"] < WORTH * (now - step.get("after", now)):
        return False
    hand.look_from((hand.side + found["turn"]) % N_SIDES)
    again = json.loads(eval(book.evaluate(ask.format("[0]", found["cell"]))))  # from where it really is
    n = book.evaluate("len(w.session.edits)")
    if again is not None:
        hand.draw(again["line"])
    is_done = book.evaluate("len(w.session.edits)") != n
    if not is_done:
        print("  an outline that could not be drawn", flush=True)
        failed.append(found["cell"])
    return is_done


def correct(book: conftest.Notebook, name: str, target: float, most: int, *, has_tools: bool) -> None:
    """Open a scan and work until the target is reached."""
    margins = (MARGINS[0], BELOW, MARGINS[2])
    book.open([KERNEL % {"path": str(path_of(name)), "turn": TURN, "margins": margins}])
    book.run_all()
    hand = Hand(book)
    print(f"{name}: {book.evaluate('w')}", flush=True)
    unseen, n_drawn, failed, start = 0, 0, [], time.perf_counter()
    for _ in range(most):
        step = json.loads(eval(book.evaluate("plan()")))
        n = int(book.evaluate("len(w.session.edits)"))
        print(f"  after {n} edits 1-RI = {step['error']:.4f}", flush=True)
        if step["error"] <= target:
            break
        if has_tools and lasso(book, hand, step, failed):
            n_drawn += 1
            print("  an outline drawn with the lasso", flush=True)
            continue
        if "kind" not in step:
            break
        if not hand.do(step):
            unseen += 1
            if step["level"] == "final":
                print(f"  {step['kind']} of a segment that can't be seen: stopped")
                break
            book.execute(f"Annotator.unseen[{step['level']!r}].add({step['part']})")
            continue
        hand.view.wait("pending", "0")
        done = book.evaluate(
            "[type(edit).__name__ + ' ' + getattr(edit, 'level', '') for edit in w.session.edits][-1]"
        )
        if int(book.evaluate("len(w.session.edits)")) != n + 1 or done != f"'{step['kind']} {step['level']}'":
            raise AssertionError(f"the mouse meant {step}, but {done} was done")
        print(f"  {step['kind']} at level {step['level']!r} by the mouse", flush=True)
    n, file = int(book.evaluate("len(w.session.edits)")), book.evaluate("w.view.save_state")
    print(
        f"{name}: {n} edits by the mouse ({n_drawn} drawn, {hand.n_rows} in the list), {hand.n_looks} turns "
        f"of the scan, {unseen} edits unseen, {time.perf_counter() - start:.0f} s; "
        f"1-RI = {step['error']:.4f}; project {file}",
        flush=True,
    )


def notebooks_of(names: Sequence[str]) -> Generator[tuple[str, conftest.Notebook], None, None]:
    """Each scan that is there, and an empty notebook of a JupyterLab for it, which is closed afterwards."""
    scans = [name for name in names if path_of(name).exists()]
    for name in set(names) - set(scans):
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
                yield name, book
            finally:
                book.close()
        browser.close()


def main() -> None:
    """Correct each scan."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scans", nargs="+", default=["bedroom", "bedroom_noisy"])
    parser.add_argument("--target", type=float, default=0.03)
    parser.add_argument("--most", type=int, default=60, help="edits, at most")
    parser.add_argument("--tools", action="store_true", help="also draw with the lasso")
    parser.add_argument("--picture", help="file to which a screenshot goes at the end")
    arguments = parser.parse_args()
    with contextlib.closing(notebooks_of(arguments.scans)) as books:
        for name, book in books:
            correct(book, name, arguments.target, arguments.most, has_tools=arguments.tools)
            if arguments.picture:
                book.view().root.screenshot(path=arguments.picture)


if __name__ == "__main__":
    main()
