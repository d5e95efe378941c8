"""A segmented room in a notebook and the hands of a person who edits it; the fixture `editor` opens it."""

from __future__ import annotations

import numpy as np
from cells import ROOM

WIDGET = (
    ROOM
    + """
import scenewidget as sw

w = sw.SceneWidget(mesh, sw.Params(n_segments=6, n_runs=4, n_graph_runs=4), height=420)
w.wait()
w
"""
)


class Editor:
    """A widget in a notebook, in edit mode, looked at into the room."""

    def __init__(self, book):
        self.book, self.page = book, book.page
        self.view = book.view()
        self.root = self.view.root
        self.view.wait("busy", "false")
        self.n = int(self.view.state("segments"))
        self.root.get_by_role("button", name="Edit", exact=True).click()
        self.view.wait("mode", "edit")

    def places(self):
        """Segments with a place well inside each, from large to small in the picture's middle."""
        return {int(part): place for part, place in self.view.parts().items() if part}

    def ends(self):
        """Two segments that can be pointed at, with their places."""
        width, height = self.view.size()
        inside = {
            part: (x, y)
            for part, (x, y) in self.places().items()
            if 50 < y < height - 90 and 20 < x < width - 20
        }
        assert len(inside) >= 2, self.places()
        return list(inside.items())[:2]

    def press(self, place, button="left"):
        self.view.point(*place)
        self.page.mouse.down(button=button)

    def click(self, place, button="left"):
        self.press(place, button)
        self.page.mouse.up(button=button)

    def button(self, name):
        return self.root.get_by_role("button", name=name, exact=True)

    def python(self, expression):
        return eval(self.book.evaluate(expression), {"np": np})  # as NumPy writes its numbers

    def edits(self):
        return self.python("[type(edit).__name__ for edit in w.session.edits]")

    def settled(self, segments):
        """Wait until so many segments are shown and Python has answered everything."""
        self.view.wait("segments", str(segments))
        self.view.wait("pending", "0")
        assert self.python("w.segmentation.n_segments") == segments
