"""A small software renderer: coloured triangles to pixels, for pictures without a browser.

A z-buffer over all triangles at once: each triangle lists the samples in its bounding box, those inside
compete for the sample by depth. Meant for tens of thousands of triangles, a second at most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import FloatArray, IntArray
from scenewidget.figures.scale import ColorArray

__all__ = ["Camera", "render"]


FIELD_OF_VIEW = 32.0  # degrees, from top to bottom
FILLED = 0.93  # what is fitted into the picture fills this share of its width or height
MOST_CANDIDATES = 4_000_000  # so many pairs of triangle and sample are looked at in one go


@dataclass(frozen=True)
class Camera:
    """Looks at a point, z upwards in the picture.

    Attributes
    ----------
    azimuth, elevation : float
        Degrees: where the camera stands, seen from that point. Azimuth 0 is +x, 90 is +y; elevation 90 is
        straight above.
    distance : float
        Metres.
    target : (x, y, z)
        What it looks at.

    Examples
    --------
    >>> Camera(azimuth=-60.0, elevation=30.0, distance=4.0)
    Camera(azimuth=-60.0, elevation=30.0, distance=4.0, target=(0.0, 0.0, 0.0))
    """

    azimuth: float
    elevation: float
    distance: float
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def fitting(cls, points: npt.NDArray[np.floating], view: tuple[float, float], aspect: float) -> Camera:
        """As near as it can be with all points (n, 3) in the picture, and they in its middle."""
        azimuth, elevation = float(view[0]), float(np.clip(view[1], -89.9, 89.9))
        axes = cls(azimuth, elevation, 1.0).axes
        seen = points.astype(np.float64) @ axes.T
        middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
        half = np.tan(np.radians(FIELD_OF_VIEW / 2)) * FILLED
        for _ in range(4):  # what is nearer looks larger: moving to its middle changes where the middle is
            right, up, towards = (seen - middle).T
            reach = np.maximum(np.abs(right) / (half * aspect), np.abs(up) / half)
            distance = max(float((reach + towards).max()), 1e-9)
            on_screen = np.stack([right, up], axis=1) / np.maximum(distance - towards, 1e-9)[:, None]
            middle[:2] += 0.5 * distance * (on_screen.min(axis=0) + on_screen.max(axis=0))
        target = middle @ axes
        return cls(azimuth, elevation, distance, (float(target[0]), float(target[1]), float(target[2])))

    @property
    def axes(self) -> FloatArray:
        """(3, 3): right, up and towards the camera, in rows."""
        a, e = np.radians(self.azimuth), np.radians(self.elevation)
        towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return np.stack([right, np.cross(towards, right), towards])

    @property
    def position(self) -> FloatArray:
        """(3,) metres."""
        place: FloatArray = np.array(self.target) + self.distance * self.axes[2]
        return place


def render(
    corners: npt.NDArray[np.floating],
    colors: ColorArray,
    camera: Camera,
    *,
    width: int,
    height: int,
    hides_back: bool = False,
    background: tuple[int, int, int] = (255, 255, 255),
    supersampling: int = 2,
) -> ColorArray:
    """The picture, (height, width, 3) uint8.

    Parameters
    ----------
    corners : (n_triangles, 3, 3) float
        Counter-clockwise seen from the front.
    colors : (n_triangles, 3, 3) uint8
        Of the corners; linear between them.
    hides_back : bool
        Leave out triangles seen from behind.
    supersampling : int
        Samples a pixel along each side.

    Notes
    -----
    A sample is covered if it lies inside a triangle or on its border; of those at the same depth the last
    triangle wins, so what is drawn on a surface comes after it. Triangles that reach behind the camera are
    left out.

    Examples
    --------
    >>> import numpy as np
    >>> corners = np.array([[[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]]])
    >>> red = np.tile(np.array([255, 0, 0], np.uint8), (1, 3, 1))
    >>> image = render(corners, red, Camera(0.0, 90.0, 4.0), width=8, height=8)
    >>> image.shape, image[4, 4].tolist()
    ((8, 8, 3), [255, 0, 0])
    """
    n_x, n_y = width * supersampling, height * supersampling
    seen = (corners.astype(np.float64) - camera.position) @ camera.axes.T
    depth = -seen[..., 2]
    focal = 0.5 * n_y / np.tan(np.radians(FIELD_OF_VIEW / 2))
    is_ahead = (depth > 1e-9).all(axis=1)
    inverse = 1.0 / np.where(depth > 1e-9, depth, 1.0)
    x = 0.5 * n_x + focal * seen[..., 0] * inverse - 0.5  # in samples, whose centres are whole numbers
    y = 0.5 * n_y - focal * seen[..., 1] * inverse - 0.5
    double_area = (x[:, 1] - x[:, 0]) * (y[:, 0] - y[:, 2]) - (x[:, 2] - x[:, 0]) * (y[:, 0] - y[:, 1])
    is_drawn = is_ahead & (double_area > 0 if hides_back else double_area != 0)
    left, right = _bounds(x, n_x)
    top, bottom = _bounds(y, n_y)
    n_candidates = np.maximum(right - left, 0) * np.maximum(bottom - top, 0) * is_drawn
    triangles = np.flatnonzero(n_candidates)

    nearest = np.zeros(n_x * n_y)  # inverse depth of what is seen in each sample
    winner = np.full(n_x * n_y, -1, np.int64)
    cut = np.searchsorted(
        np.cumsum(n_candidates[triangles]), np.arange(0, n_candidates.sum(), MOST_CANDIDATES), side="right"
    )
    for some in np.split(triangles, np.unique(cut[1:])):
        triangle = np.repeat(some, n_candidates[some])
        ends = np.cumsum(n_candidates[some])
        place = np.arange(len(triangle)) - np.repeat(ends - n_candidates[some], n_candidates[some])
        row, column = np.divmod(place, (right - left)[triangle])
        row, column = row + top[triangle], column + left[triangle]
        weights = _barycentric(x, y, double_area, triangle, column, row)
        is_inside = (weights >= -1e-9).all(axis=1)
        triangle, sample = triangle[is_inside], (row * n_x + column)[is_inside]
        closeness = (weights[is_inside] * inverse[triangle]).sum(axis=1)
        order = np.lexsort((triangle, closeness, sample))
        triangle, sample, closeness = triangle[order], sample[order], closeness[order]
        is_last = np.append(sample[1:] != sample[:-1], True)[: len(sample)]
        triangle, sample, closeness = triangle[is_last], sample[is_last], closeness[is_last]
        wins = closeness >= nearest[sample]
        nearest[sample[wins]] = closeness[wins]
        winner[sample[wins]] = triangle[wins]

    picture = np.tile(np.array(background, np.float64), (n_x * n_y, 1))
    sample = np.flatnonzero(winner >= 0)
    triangle = winner[sample]
    row, column = np.divmod(sample, n_x)
    weights = _barycentric(x, y, double_area, triangle, column, row) * inverse[triangle]
    weights /= weights.sum(axis=1, keepdims=True)
    picture[sample] = np.einsum("sc,sck->sk", weights, colors[triangle].astype(np.float64))
    picture = picture.reshape(height, supersampling, width, supersampling, 3).mean(axis=(1, 3))
    pixels: ColorArray = np.round(np.clip(picture, 0, 255)).astype(np.uint8)
    return pixels


def _bounds(along: FloatArray, n: int) -> tuple[IntArray, IntArray]:
    """First and one after the last sample of each triangle's bounding box, inside the picture."""
    low = np.clip(np.ceil(along.min(axis=1) - 1e-9), 0, n).astype(np.int64)
    high = np.clip(np.floor(along.max(axis=1) + 1e-9) + 1, 0, n).astype(np.int64)
    return low, high


def _barycentric(
    x: FloatArray, y: FloatArray, double_area: FloatArray, triangle: IntArray, column: IntArray, row: IntArray
) -> FloatArray:
    """(n, 3) weights of the corners on screen."""
    px, py = x[triangle] - column[:, None], y[triangle] - row[:, None]
    turned = [
        px[:, (i + 2) % 3] * py[:, (i + 1) % 3] - px[:, (i + 1) % 3] * py[:, (i + 2) % 3] for i in range(3)
    ]
    weights: FloatArray = np.stack(turned, axis=1) / double_area[triangle, None]
    return weights
