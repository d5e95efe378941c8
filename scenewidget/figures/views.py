"""The figures one asks for: a mesh, meshes side by side, two segmentations compared."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import Mesh
from scenewidget.figures.drawing import checked_labels, draw, label_colors
from scenewidget.figures.orbit import Figure
from scenewidget.palette import inherited_colors, label_rows

__all__ = ["compare", "options_of", "show", "side_by_side"]

Shown = TypeVar("Shown", bound=Callable[..., Any])
ALIKE, DIFFERENT = (215, 215, 210), (215, 65, 25)


def options_of(drawing: Callable[..., Any], *, but: Collection[str]) -> Callable[[Shown], Shown]:
    """Name in a function's signature the options that it passes on as they are.

    Parameters
    ----------
    drawing : callable
        Whose keyword-only parameters they are.
    but : collection of str
        Those of them that the function gives itself.

    Examples
    --------
    >>> import inspect
    >>> @options_of(draw, but=("middle",))
    ... def show_nothing(mesh, **options): ...
    >>> list(inspect.signature(show_nothing).parameters)[:3]
    ['mesh', 'colors', 'points']
    """

    def decorate(function: Shown) -> Shown:
        own, theirs = inspect.signature(function), inspect.signature(drawing).parameters.values()
        kept = [p for p in own.parameters.values() if p.kind is not p.VAR_KEYWORD]
        added = [p for p in theirs if p.kind is p.KEYWORD_ONLY and p.name not in but]
        vars(function)["__signature__"] = own.replace(parameters=[*kept, *added])
        return function

    return decorate


@options_of(draw, but=("middle",))
def show(
    mesh: Mesh,
    labels: Any = None,
    values: npt.ArrayLike | None = None,
    vectors: npt.ArrayLike | None = None,
    *,
    view: tuple[float, float] = (-60.0, 30.0),
    width: int = 520,
    height: int = 380,
    **options: Any,
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
    drawing = draw(mesh, labels, values, vectors, **options)
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
