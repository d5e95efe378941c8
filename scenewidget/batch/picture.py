"""A small picture of a segmented scan, for lists of many: a room from above, without what hides it."""

from __future__ import annotations

import io

import numpy as np
from scipy.ndimage import distance_transform_edt

from scenewidget.engine.mesh import BoolArray, FloatArray
from scenewidget.engine.segmentation import Segmentation
from scenewidget.figures.raster import FIELD_OF_VIEW, Camera, render
from scenewidget.figures.scale import ColorArray
from scenewidget.palette import segment_colors

__all__ = ["PICTURE", "thumbnail"]

PICTURE = "picture.jpg"
WIDTH, HEIGHT = 240, 180
VIEW = (-60.0, 42.0)  # degrees
FEW = 30_000  # so many faces are drawn as triangles; more are so dense that their centres will do
SPECKS = 0.004  # this share of the surface may lie outside the picture, on each side
LIGHT = np.array([0.20, -0.62, 0.76])
GAP = 3.0  # pixels between centres that are filled with the colour of the nearest
PAPER = 255


def thumbnail(segmentation: Segmentation) -> bytes:
    """A JPEG of 240 × 180 pixels with segments in their colours.

    Parameters
    ----------
    segmentation : Segmentation
        Of a mesh or a cloud of any size: a million faces take .3 s.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> seg = sw.Segmentation.from_labels(analytic.square(2), [0, 0, 0, 0, 1, 1, 1, 1])
    >>> thumbnail(seg)[6:10]
    b'JFIF'
    """
    from PIL import Image

    mesh = segmentation.mesh
    camera = Camera(*VIEW, 1.0)
    towards = camera.axes[2]
    facing = mesh.face_normals @ towards
    is_seen = facing > 0 if (facing > 0).any() else np.ones(mesh.n_faces, bool)
    centers = mesh.face_centroids
    inside = _inside(centers[is_seen] @ camera.axes.T)
    camera = Camera.fitting(centers[is_seen][inside], VIEW, WIDTH / HEIGHT)
    shade = 0.62 + 0.38 * np.clip(mesh.face_normals @ LIGHT, 0, 1)
    colors = (segment_colors(segmentation)[segmentation.labels] * shade[:, None]).astype(np.uint8)
    if mesh.n_faces <= FEW and not mesh.is_cloud:
        corners = mesh.vertices[mesh.faces[is_seen]]
        tints = np.repeat(colors[is_seen][:, None], 3, axis=1)
        pixels = render(corners, tints, camera, width=WIDTH, height=HEIGHT)
    else:
        pixels = _dots(centers[is_seen], colors[is_seen], camera)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=82)
    return file.getvalue()


def _inside(places: FloatArray) -> BoolArray:
    """Without the few that lie far from the rest."""
    low, high = np.quantile(places, [SPECKS, 1 - SPECKS], axis=0)
    reach = 0.02 * (high - low) + 1e-9
    is_near: BoolArray = ((places >= low - reach) & (places <= high + reach)).all(axis=1)
    return is_near


def _dots(places: FloatArray, colors: ColorArray, camera: Camera) -> ColorArray:
    """Every place a dot, the nearest last; gaps between them filled."""
    seen = (places - camera.position) @ camera.axes.T
    depth = -seen[:, 2]
    focal = 0.5 * HEIGHT / np.tan(np.radians(FIELD_OF_VIEW / 2))
    x = np.floor(0.5 * WIDTH + focal * seen[:, 0] / np.maximum(depth, 1e-9)).astype(np.int64)
    y = np.floor(0.5 * HEIGHT - focal * seen[:, 1] / np.maximum(depth, 1e-9)).astype(np.int64)
    keep = np.flatnonzero((depth > 0) & (x >= 0) & (x < WIDTH) & (y >= 0) & (y < HEIGHT))
    order = keep[np.argsort(-depth[keep], kind="stable")]
    winner = np.full((HEIGHT, WIDTH), -1, np.int64)
    winner[y[order], x[order]] = order
    gap, nearest = distance_transform_edt(winner < 0, return_indices=True)
    filled = winner[tuple(nearest)]
    pixels: ColorArray = colors[filled]
    pixels[gap > GAP] = PAPER
    return pixels
