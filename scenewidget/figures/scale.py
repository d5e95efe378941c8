"""Numbers to colours: a perceptual colour map between two ends.

Numbers of both signs get a map that is pale at 0 and as strong on either side; others get one that grows
lighter from low to high.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import FloatArray
from scenewidget.palette import colormap_table

__all__ = ["ColorScale", "color_scale"]

ColorArray = npt.NDArray[np.uint8]

SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"
NOT_A_NUMBER = (170, 170, 170)
BOTH_SIGNS = 0.02  # numbers have both signs if the smaller side reaches this share of the larger


@dataclass(frozen=True)
class ColorScale:
    """A colour map and the numbers at its ends.

    Attributes
    ----------
    colormap : str
        Name of a matplotlib colour map.
    low, high : float
        Numbers at its ends; what lies beyond takes the colour of the end.
    title : str
        What the numbers are, with their unit.

    Examples
    --------
    >>> scale = ColorScale("viridis", 0.0, 2.0, "height, m")
    >>> scale.colors([0.0, 2.0, float("nan")]).tolist()
    [[68, 1, 84], [253, 231, 37], [170, 170, 170]]
    >>> scale.ticks()
    ['0', '1', '2']
    """

    colormap: str
    low: float
    high: float
    title: str = ""

    def colors(self, values: npt.ArrayLike) -> ColorArray:
        """(..., 3) uint8 sRGB of values of any shape; grey where they are not finite."""
        numbers = np.asarray(values, np.float64)
        is_finite = np.isfinite(numbers)
        share = np.where(is_finite, (numbers - self.low) / ((self.high - self.low) or 1.0), 0.0)
        rows = np.round(255 * np.clip(share, 0.0, 1.0)).astype(np.intp)
        found: ColorArray = np.where(
            is_finite[..., None], colormap_table(self.colormap)[rows], NOT_A_NUMBER
        ).astype(np.uint8)
        return found

    def ticks(self) -> list[str]:
        """The numbers at the two ends and in the middle, as short as they differ."""
        numbers = (self.low, 0.5 * (self.low + self.high), self.high)
        for digits in range(2, 7):
            texts = [f"{number:.{digits}g}".replace("-", "−") for number in numbers]
            if len(set(texts)) == 3:
                break
        return texts


def color_scale(
    values: FloatArray,
    *,
    colormap: str | None = None,
    low: float | None = None,
    high: float | None = None,
    title: str = "",
) -> ColorScale:
    """The scale for these values; ends and colour map that are not given come from them.

    Examples
    --------
    >>> import numpy as np
    >>> color_scale(np.array([-1.0, 3.0]))
    ColorScale(colormap='RdBu_r', low=-3.0, high=3.0, title='')
    """
    finite = values[np.isfinite(values)]
    smallest = float(finite.min()) if finite.size else 0.0
    largest = float(finite.max()) if finite.size else 1.0
    is_signed = min(-smallest, largest) > BOTH_SIGNS * max(-smallest, largest)
    if colormap is None:
        colormap = DIVERGING if is_signed and low is None else SEQUENTIAL
        if colormap == DIVERGING:
            high = max(-smallest, largest) if high is None else high
            low = -high
    low, high = smallest if low is None else float(low), largest if high is None else float(high)
    if not low <= high:
        raise ValueError(f"low must not be above high, got {low:g} and {high:g}")
    colormap_table(colormap)  # says what is wrong with a name
    return ColorScale(colormap, low, high, title)
