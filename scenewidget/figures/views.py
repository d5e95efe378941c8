"""The figures one asks for: a mesh, meshes side by side, two segmentations compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import Mesh
from scenewidget.figures.drawing import checked_labels, draw, label_colors
from scenewidget.figures.orbit import Figure
from scenewidget.palette import inherited_colors, label_rows

__all__ = ["compare", "show", "side_by_side"]

ALIKE, DIFFERENT = (215, 215, 210), (215, 65, 25)


def show(
    mesh: Mesh,
    labels: Any = None,
    values: npt.ArrayLike | None = None,
    vectors: npt.ArrayLike | None = None,
    *,
    colors: npt.ArrayLike | None = None,
    points: npt.ArrayLike | None = None,
    title: str = "",
    scale_title: str = "",
    colormap: str | None = None,
    low: float | None = None,
    high: float | None = None,
    isolines: int = 0,
    edges: bool = False,
    smooth: bool | None = None,
    scan_colors: bool = True,
    back_faces: bool | None = None,
    vector_length: float | None = None,
    view: tuple[float, float] = (-60.0, 30.0),
    width: int = 520,
    height: int = 380,
    max_faces: int = 30_000,
) -> Figure:
    """A mesh to turn around, coloured by labels or numbers, with arrows on it.

    Left drag turns, right drag moves, the wheel zooms.

    Parameters
    ----------
    mesh : Mesh
    labels : (n_faces,) int or Segmentation, optional
        A colour each, neighbours distinct; grey where negative.
    values : (n_vertices,) or (n_faces,) float, optional
        Coloured by a colour map with a colour bar; grey where NaN. Where both shapes fit, per vertex.
    vectors : (n_vertices, 3) or (n_faces, 3) float, optional
        Arrows, from the vertices or the centroids of the faces. Of more than 2 000, every n-th is drawn.
    colors : (n_vertices, 3) or (n_faces, 3), optional
        Red, green and blue, 0 to 255, as they are.
    points : (n,) int, optional
        Vertices to mark.
    title, scale_title : str
        Above the picture; below the colour bar, what the values are with their unit.
    colormap : str, optional
        Name of a matplotlib colour map; by default a diverging one centred at 0 for values of both signs.
    low, high : float, optional
        Ends of the colour map.
    isolines : int
        Lines of equal value, evenly spaced between the ends.
    edges : bool
        Draw the edges of the triangles.
    smooth : bool, optional
        Shade over the edges; by default for values at vertices.
    scan_colors : bool
        Without labels and values: the scan's own colours, where it has any.
    back_faces : bool, optional
        Draw faces seen from behind; by default off in rooms, so that one looks in from outside.
    vector_length : float, optional
        Metres for a vector of length 1; by default the longest reach a twelfth of the mesh's diagonal.
    view : (azimuth, elevation)
        Degrees: from where it is looked at first. Azimuth 0 is from +x, 90 from +y.
    width, height : int
        Pixels.
    max_faces : int
        A larger mesh is drawn simplified, and the figure says so.

    Returns
    -------
    Figure

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> sw.figures.show(mesh, labels=[0, 0, 0, 0, 1, 1, 1, 1], title="halves")
    Figure(1 panel)
    """
    drawing = draw(
        mesh, labels, values, vectors, colors=colors, points=points, title=title, scale_title=scale_title,
        colormap=colormap, low=low, high=high, isolines=isolines, edges=edges, smooth=smooth,
        scan_colors=scan_colors, back_faces=back_faces, vector_length=vector_length, max_faces=max_faces,
    )  # fmt: skip
    return Figure([drawing], view=view, width=width, height=height)


def side_by_side(figures: Sequence[Figure], *, width: int | None = None, height: int | None = None) -> Figure:
    """Figures in a row with one camera: turn one and all turn.

    Parameters
    ----------
    figures : sequence of Figure
        The view is that of the first.
    width, height : int, optional
        Pixels of each panel; by default they share 840 pixels.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> figures = [sw.figures.show(mesh, values=mesh.vertices[:, axis]) for axis in range(2)]
    >>> sw.figures.side_by_side(figures)
    Figure(2 panels)
    """
    if not figures:
        raise ValueError("figures must hold at least one figure, got none")
    drawings = [drawing for figure in figures for drawing in figure.drawings]
    width = min(560, 840 // len(drawings)) if width is None else width
    height = min(400, max(200, width)) if height is None else height
    return Figure(drawings, view=figures[0].view, width=width, height=height)


def compare(a: Any, b: Any, mesh: Mesh, *, names: tuple[str, str] = ("a", "b"), **options: Any) -> Figure:
    """Two segmentations side by side in matching colours, and where they part.

    Each label of `b` takes the colour of the label of `a` that it shares most faces with, unless a larger
    share of another label of `b` has it already. The third picture shows the faces whose colours then differ.

    Parameters
    ----------
    a, b : (n_faces,) int or Segmentation
    mesh : Mesh
    names : (str, str)
        Titles of the two.
    **options
        Of `show`.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> sw.figures.compare([0, 0, 0, 0, 1, 1, 1, 1], [0, 0, 1, 1, 2, 2, 2, 2], mesh)
    Figure(3 panels)
    """
    first, second = checked_labels(mesh, a, "a"), checked_labels(mesh, b, "b")
    n_first, n_second = int(first.max()) + 1, int(second.max()) + 1
    rows = label_rows(mesh, first)
    known = inherited_colors(second, n_second, first, rows)
    partner = inherited_colors(second, n_second, first, np.arange(n_first))
    is_alike = np.where(second < 0, first < 0, np.append(partner, -2)[second] == first)
    share = float(mesh.face_areas[~is_alike].sum() / mesh.face_areas.sum())
    painted = {
        names[0]: label_colors(first, rows),
        names[1]: label_colors(second, label_rows(mesh, second, known)),
        f"different: {share:.0%} of the area": np.where(is_alike[:, None], ALIKE, DIFFERENT),
    }
    return side_by_side(
        [show(mesh, colors=colors, title=title, **options) for title, colors in painted.items()]
    )
