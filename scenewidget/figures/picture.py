"""The picture that stands in for a figure where no browser draws it: small, and the same view.

Goes in: drawings and a view. Comes out: a PNG with titles and colour bars.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.figures.drawing import MARK, Drawing
from scenewidget.figures.raster import Camera, render
from scenewidget.figures.scale import ColorArray, ColorScale

__all__ = ["camera_for", "color_bar", "png"]

N_COLORS, N_GREYS = 100, 12  # of the file: a third of the bytes, and no eye sees it
MARK_SHADES = (0.5, 0.65, 0.8, 0.9, 1.0)  # a mark is small, and would get the colour of what is around it
INK, FAINT = (30, 30, 30), (120, 120, 120)
TITLE_HEIGHT, BAR_HEIGHT, NOTE_HEIGHT, TEXT_SIZE = 26, 34, 18, 13
SPECKS = 0.004  # on each side this share of a room's corners may lie outside the picture
BAR_WIDTH, BAR_THICKNESS = 0.62, 9  # of the panel's width; pixels


def png(drawings: Sequence[Drawing], *, view: tuple[float, float], width: int, height: int) -> bytes:
    """A PNG of the drawings side by side, each width × height pixels with its title and colour bar around.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> from scenewidget.figures.drawing import draw
    >>> png([draw(mesh)], view=(-60.0, 30.0), width=80, height=60)[1:4]
    b'PNG'
    """
    from PIL import Image, ImageDraw

    top = TITLE_HEIGHT if any(drawing.title for drawing in drawings) else 0
    below = BAR_HEIGHT if any(drawing.scale for drawing in drawings) else 0
    note = NOTE_HEIGHT if any(drawing.note for drawing in drawings) else 0
    sheet = Image.new("RGB", (width * len(drawings), top + height + below + note), (255, 255, 255))
    pen = ImageDraw.Draw(sheet)
    camera = camera_for(drawings, view, width / height)
    for i, drawing in enumerate(drawings):
        left = i * width
        picture = render(
            drawing.corners, drawing.colors, camera, width=width, height=height, hides_back=drawing.hides_back
        )
        sheet.paste(Image.fromarray(picture), (left, top))
        if drawing.scale is not None:
            _paste_bar(sheet, drawing.scale, left, top + height, width)
    colors = _few_colors(sheet)
    for i, drawing in enumerate(drawings):
        left, middle = i * width, i * width + width // 2
        pen.text((middle, 5), drawing.title, INK, font=_font(TEXT_SIZE), anchor="mt")
        if drawing.scale is not None:
            _label_bar(pen, drawing.scale, left, top + height, width)
        pen.text((middle, top + height + below + 2), drawing.note, FAINT, font=_font(11), anchor="mt")
    file = io.BytesIO()
    sheet.quantize(palette=colors, dither=Image.Dither.NONE).save(file, "PNG", optimize=True)
    return file.getvalue()


def camera_for(drawings: Sequence[Drawing], view: tuple[float, float], aspect: float) -> Camera:
    """The camera that has all that is seen of the drawings in its picture.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> from scenewidget.figures.drawing import draw
    >>> camera_for([draw(mesh)], (-60.0, 30.0), 1.5).azimuth
    -60.0
    """
    axes = Camera(float(view[0]), float(view[1]), 1.0).axes
    seen = []
    for drawing in drawings:
        corners = drawing.corners
        if drawing.hides_back:
            across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            is_seen = across @ axes[2] > 0
            if is_seen.any():  # without specks that happen to face here
                points = corners[is_seen].reshape(-1, 3)
                low, high = np.quantile(points @ axes.T, [SPECKS, 1 - SPECKS], axis=0)
                corners = np.clip(points @ axes.T, low, high) @ axes
        seen.append(corners.reshape(-1, 3))
    return Camera.fitting(np.concatenate(seen), view, aspect)


def color_bar(scale: ColorScale, n: int) -> ColorArray:
    """(n, 3) colours from the low end of the scale to the high one.

    Examples
    --------
    >>> color_bar(ColorScale("viridis", 0.0, 1.0), 2).tolist()
    [[68, 1, 84], [253, 231, 37]]
    """
    return scale.colors(np.linspace(scale.low, scale.high, n))


def _paste_bar(sheet: Any, scale: ColorScale, left: int, top: int, width: int) -> None:
    from PIL import Image

    length = int(BAR_WIDTH * width)
    strip = np.repeat(color_bar(scale, length)[None], BAR_THICKNESS, axis=0)
    sheet.paste(Image.fromarray(strip), (left + (width - length) // 2, top + 2))


def _label_bar(pen: Any, scale: ColorScale, left: int, top: int, width: int) -> None:
    low, middle, high = scale.ticks()
    length = int(BAR_WIDTH * width)
    start = left + (width - length) // 2
    for text, at, anchor in ((low, 0.0, "lt"), (scale.title or middle, 0.5, "mt"), (high, 1.0, "rt")):
        pen.text((start + at * length, top + 5 + BAR_THICKNESS), text, INK, font=_font(11), anchor=anchor)


def _few_colors(sheet: Any) -> Any:
    """The colours that do best for a picture, those of marks, and greys for the text that will come on it."""
    from PIL import Image

    best = sheet.quantize(N_COLORS, dither=Image.Dither.NONE).getpalette()[: 3 * N_COLORS]
    palette = Image.new("P", (1, 1))
    marks = np.outer(MARK_SHADES, MARK).round().astype(int).ravel()
    greys = np.repeat(np.linspace(0, 255, N_GREYS).astype(int), 3)
    palette.putpalette([*best, *marks.tolist(), *greys.tolist()])
    return palette


@cache
def _font(size: int) -> Any:
    import matplotlib
    from PIL import ImageFont

    path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    return ImageFont.truetype(str(path), size)  # the oldest Pillow takes no Path
