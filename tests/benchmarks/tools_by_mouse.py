"""Do the brush, the slice and the box do what a person means by them? With a real mouse in a real JupyterLab.

    python tests/benchmarks/tools_by_mouse.py [--scans real/tabletop_6 real/kitchen_12mm]

Of each scan, once it is segmented, the thing that is melted into a segment and costs most is painted out of
it by one stroke (or a patch of a segment, where no such thing has room for a brush), the segment that is
least flat is sliced through three points on it, and what the section box, dragged to half the height, shows
becomes a segment.
Prints the seconds of each, from the tool's key until Python has the edit, and the errors before and after;
whatever doesn't arrive as one edit of its kind ends it. Each is undone again.
Scans that aren't beside the repository are passed over.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "browser"))

import conftest
import numpy as np
from correct_by_mouse import BELOW, KERNEL, MARGINS, N_SIDES, TURN, Hand, notebooks_of, path_of
from matplotlib.path import Path as Outline
from scipy import ndimage

STEP = 6  # pixels between two places that are looked at
BRUSH = 8  # pixels
ROOM = 15  # pixels around a stroke that belong to its segment: the brush and a little more
MEASURE = """
import json
def state():
    labels = w.session.segmentation.labels
    table = table_of(labels).astype(float)
    total = table.sum()
    squares = (table.sum(1) ** 2).sum() + (table.sum(0) ** 2).sum() - 2 * (table**2).sum()
    edits = w.session.edits
    return json.dumps({"n": len(edits), "kind": type(edits[-1]).__name__ if edits else "",
        "segments": w.segmentation.n_segments, "error": squares / (total * total - total)})

def least_flat():
    table = w.segmentation.to_frame()
    large = table[table["area"] > 0.02 * table["area"].sum()]
    return [int(k) for k in large.sort_values("flatness").index]
"""
# The part under each place of a raster.
RASTER = """(root, step) => {
    const canvas = root.querySelector("canvas");
    const box = canvas.getBoundingClientRect();
    const rows = [];
    for (let y = step / 2; y < box.height; y += step) {
        const row = [];
        for (let x = step / 2; x < box.width; x += step) {
            canvas.dispatchEvent(new PointerEvent("pointermove",
                { clientX: box.left + x, clientY: box.top + y, bubbles: true }));
            row.push(root.dataset.hovered === "" ? -1 : Number(root.dataset.hovered));
        }
        rows.push(row);
    }
    canvas.dispatchEvent(new PointerEvent("pointerleave"));
    return rows;
}"""


class Tools:
    """A hand that takes up one tool after the other."""

    def __init__(self, book: conftest.Notebook) -> None:
        self.book, self.hand = book, Hand(book)
        self.view, self.page, self.began = self.hand.view, book.page, 0.0
        book.execute(MEASURE)

    def state(self) -> dict:
        """What Python has."""
        return json.loads(eval(self.book.evaluate("state()")))

    def raster(self):
        """(n_rows, n_columns) segment at each place, -1 = none."""
        self.hand.press("3")
        self.view.settle()
        return np.array(self.view.root.evaluate(RASTER, STEP))

    def timed(self, name: str, kind: str, work) -> None:
        """Do something that ends as one edit of a kind."""
        before = self.state()
        said = work()
        if said is None:
            print(f"  {name}: nothing to be done here", flush=True)
            return
        self.view.wait("pending", "0")
        after = self.state()
        seconds = time.perf_counter() - self.began
        if (after["n"], after["kind"]) != (before["n"] + 1, kind):
            raise AssertionError(f"{name} should have made one {kind}: {before} became {after}")
        print(
            f"  {name}: {said}; {before['segments']} → {after['segments']} segments, 1-RI "
            f"{before['error']:.4f} → {after['error']:.4f}, {seconds:.1f} s",
            flush=True,
        )
        self.hand.press("Control+z")
        self.view.wait("pending", "0")

    def take_up(self, key: str, tool: str) -> None:
        """By its key."""
        self.began = time.perf_counter()
        self.hand.press(key)
        self.view.wait("tool", tool)

    def put_down(self, key: str) -> None:
        """By its key again."""
        self.hand.press(key)
        self.view.wait("tool", "merge")

    def melted(self) -> tuple[int | None, np.ndarray]:
        """A thing that costs much where it is: its segment, and the places where a brush has room on it."""
        self.hand.look_from((self.hand.side + 1) % N_SIDES)  # the camera is told once it has moved
        passed: list[int] = []
        while len(passed) < 6:
            found = self.best_outline(list(range(N_SIDES)), None, passed)
            if found is None:
                break
            self.hand.look_from((self.hand.side + found["turn"]) % N_SIDES)
            again = self.best_outline([0], found["cell"], [])
            if again is not None:
                segment = int(eval(self.book.evaluate(f"{found['cell']} // (int(truth.max()) + 1)")))
                free = where_a_brush_has_room(self.raster(), segment, again["line"])
                if free.any():
                    return segment, free
            passed.append(found["cell"])
        everywhere = [[0, 0], [1e4, 0], [1e4, 1e4], [0, 1e4]]
        return None, where_a_brush_has_room(self.raster(), None, everywhere)

    def best_outline(self, turns: list[int], only: int | None, without: list[int]) -> dict | None:
        """What `correct_by_mouse` would draw."""
        width, height = self.view.size()
        asked = f"best_lasso({width}, {height}, {turns}, {only}, {without})"
        return json.loads(eval(self.book.evaluate(asked)))

    def paint(self) -> str | None:
        """Draw a stroke over what is melted into a segment."""
        segment, free = self.melted()
        if not free.any():
            return None
        line = way_through(free)
        self.take_up("m", "paint")
        radius = self.view.root.get_by_role("spinbutton", name="Brush radius")
        radius.fill(str(BRUSH))
        radius.press("Enter")
        self.view.point(*line[0])
        self.page.mouse.down()
        corner = self.view.root.locator("canvas").bounding_box()
        for x, y in line:
            self.page.mouse.move(corner["x"] + x, corner["y"] + y, steps=6)
        self.page.mouse.up()
        self.view.wait("pending", "0")
        self.put_down("m")
        what = "a patch" if segment is None else f"what is melted into segment {segment}"
        return f"a stroke of {len(line)} corners over {what}"

    def slice(self) -> str | None:
        """Click three points of the segment that is least flat and well in sight."""
        raster = self.raster()
        for segment in eval(self.book.evaluate("least_flat()")):
            rows, columns = np.nonzero(ndimage.binary_erosion(raster == segment, iterations=2))
            if len(rows) < 30:
                continue
            middle = np.argsort(np.abs(columns - np.median(columns)), kind="stable")[: len(rows) // 5]
            ends = [np.argmin(columns), middle[np.argmin(rows[middle])], np.argmax(columns)]
            self.take_up("z", "slice")
            for k in ends:
                self.hand.click(((columns[k] + 0.5) * STEP, (rows[k] + 0.5) * STEP))
            self.view.wait("pending", "0")
            self.put_down("z")
            return f"three points on segment {segment}"
        return None

    def box(self) -> str | None:
        """Drag the upper end of the section down to half and take what is left."""
        self.began = time.perf_counter()
        self.hand.press("x")
        end = self.view.root.get_by_role("slider", name="Height to")
        at = end.bounding_box()
        across = at["x"] + at["width"]
        self.page.mouse.move(across - 8, at["y"] + at["height"] / 2)
        self.page.mouse.down()
        self.page.mouse.move(at["x"] + at["width"] / 2, at["y"] + at["height"] / 2, steps=8)
        self.page.mouse.up()
        self.hand.settle()
        value = end.input_value()
        self.view.root.get_by_role("button", name="Make it a segment").click()
        self.view.wait("pending", "0")
        self.view.root.get_by_role("button", name="Show the whole scan").click()
        self.hand.press("x")
        return f"all below {float(value):.2f} of the height"


def where_a_brush_has_room(raster, segment: int | None, outline):
    """Places in an outline with nothing but one segment around, the one that has most of them by default."""
    rows, columns = np.indices(raster.shape)
    places = (np.column_stack([columns.ravel(), rows.ravel()]) + 0.5) * STEP
    within = Outline(outline).contains_points(places).reshape(raster.shape)
    reach = -(-ROOM // STEP)
    disc = np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) * STEP <= ROOM
    best = np.zeros_like(within)
    for one in np.unique(raster[raster >= 0]) if segment is None else [segment]:
        pieces, n = ndimage.label(ndimage.binary_erosion(raster == one, disc) & within)
        sizes = ndimage.sum(pieces > 0, pieces, range(1, n + 1)) if n else []
        if n and max(sizes) > best.sum():
            best = pieces == 1 + np.argmax(sizes)
    return best


def way_through(free: np.ndarray) -> list[tuple[float, float]]:
    """Corners of one stroke to and fro over some places, which leaves them nowhere."""
    cells: list[tuple[int, int]] = []
    for row in np.flatnonzero(free.any(axis=1))[::2]:
        columns = np.flatnonzero(free[row])
        runs = np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1)
        if not cells:
            run = max(runs, key=len)
        else:
            at = cells[-1][0]
            near = [run for run in runs if run[0] <= at <= run[-1] and free[row - 1, at]]
            if not near:
                break
            run = near[0]
            cells.append((at, row))
        ends = (
            (run[0], run[-1]) if not cells or cells[-1][0] - run[0] < run[-1] - cells[-1][0] else run[[-1, 0]]
        )
        cells += [(int(column), row) for column in ends]
    return [((column + 0.5) * STEP, (row + 0.5) * STEP) for column, row in cells]


def main() -> None:
    """Use each tool on each scan."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scans", nargs="+", default=["real/tabletop_6", "real/kitchen_12mm"])
    parser.add_argument("--picture", help="file to which a screenshot goes at the end")
    arguments = parser.parse_args()
    with contextlib.closing(notebooks_of(arguments.scans)) as books:
        for name, book in books:
            margins = (MARGINS[0], BELOW, MARGINS[2])
            book.open([KERNEL % {"path": str(path_of(name)), "turn": TURN, "margins": margins}])
            book.run_all()
            tools = Tools(book)
            print(f"{name}: {book.evaluate('w')}", flush=True)
            tools.timed("brush", "Paint", tools.paint)
            tools.timed("slice", "Slice", tools.slice)
            tools.timed("box", "Paint", tools.box)
            if arguments.picture:
                tools.view.root.screenshot(path=arguments.picture)
            if book.errors:
                raise AssertionError(f"the console said {book.errors}")


if __name__ == "__main__":
    main()
