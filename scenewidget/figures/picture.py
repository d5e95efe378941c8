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

from scenewidget.engine.mesh import FloatArray
from scenewidget.figures.drawing import Drawing
from scenewidget.figures.raster import Camera, render
from scenewidget.figures.scale import ColorArray, ColorScale

__all__ = ["all_points", "color_bar", "png"]

N_COLORS = 128  # of the file: a third of the bytes, and no eye sees it
INK, FAINT = (30, 30, 30), (120, 120, 120)
TITLE_HEIGHT, BAR_HEIGHT, NOTE_HEIGHT, TEXT_SIZE = 26, 34, 18, 13
BAR_WIDTH, BAR_THICKNESS = 0.62, 9  # of the panel's width; pixels


def png(drawings: Sequence[Drawing], *, view: tuple[float, float], width: int, height: int) -> bytes:
    """A PNG of the drawings side by side, each width × height pixels with its title and colour bar around."""
    from PIL import Image, ImageDraw

    top = TITLE_HEIGHT if any(drawing.title for drawing in drawings) else 0
    below = BAR_HEIGHT if any(drawing.scale for drawing in drawings) else 0
    note = NOTE_HEIGHT if any(drawing.note for drawing in drawings) else 0
    sheet = Image.new("RGB", (width * len(drawings), top + height + below + note), (255, 255, 255))
    pen = ImageDraw.Draw(sheet)
    camera = Camera.fitting(all_points(drawings), view, width / height)
    for i, drawing in enumerate(drawings):
        left, middle = i * width, i * width + width // 2
        picture = render(
            drawing.corners, drawing.colors, camera, width=width, height=height, hides_back=drawing.hides_back
        )
        sheet.paste(Image.fromarray(picture), (left, top))
        pen.text((middle, 5), drawing.title, INK, font=_font(TEXT_SIZE), anchor="mt")
        if drawing.scale is not None:
            _draw_bar(sheet, pen, drawing.scale, left, top + height, width)
        pen.text((middle, top + height + below + 2), drawing.note, FAINT, font=_font(11), anchor="mt")
    file = io.BytesIO()
    sheet.quantize(N_COLORS, dither=Image.Dither.NONE).save(file, "PNG", optimize=True)
    return file.getvalue()


def all_points(drawings: Sequence[Drawing]) -> FloatArray:
    """(n, 3) corners of all drawings."""
    return np.concatenate([drawing.corners.reshape(-1, 3) for drawing in drawings])


def color_bar(scale: ColorScale, n: int) -> ColorArray:
    """(n, 3) colours from the low end of the scale to the high one."""
    return scale.colors(np.linspace(scale.low, scale.high, n))


def _draw_bar(sheet: Any, pen: Any, scale: ColorScale, left: int, top: int, width: int) -> None:
    from PIL import Image

    length = int(BAR_WIDTH * width)
    start = left + (width - length) // 2
    strip = np.repeat(color_bar(scale, length)[None], BAR_THICKNESS, axis=0)
    sheet.paste(Image.fromarray(strip), (start, top + 2))
    for text, at, anchor in zip(scale.ticks(), (0.0, 0.5, 1.0), ("lt", "mt", "rt"), strict=True):
        if at == 0.5 and scale.title:
            text = scale.title
        pen.text((start + at * length, top + 5 + BAR_THICKNESS), text, INK, font=_font(11), anchor=anchor)


@cache
def _font(size: int) -> Any:
    import matplotlib
    from PIL import ImageFont

    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", size)
