"""Colours of a scan, wherever its file keeps them, as one byte a channel at each vertex.

Goes in: numbers of any range at vertices, faces or corners, or textures with coordinates. Come out: bytes.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray, MeshError
from scenewidget.engine.readers.scan import MAX_PIXELS, ByteArray, Notes

__all__ = ["Texture", "as_bytes", "at_vertices", "open_image", "to_linear", "to_srgb", "unpacked"]

FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "TGA", "TIFF", "GIF")
STEP = 1 << 18  # corners sampled at once: temporary arrays stay small


def as_bytes(values: Any, notes: Notes, what: str = "colours") -> ByteArray | None:
    """(n, 3) uint8 of ``values`` in 0–1, 0–255 or 0–65535, whichever their numbers and type fit.

    Bytes are bytes. Other numbers that never exceed 1 count as 0–1, with a fraction among them or not;
    numbers up to 255 as 0–255; beyond, as 0–65535. What fits none of these is no colour: None. ``notes``
    hear what was guessed.
    """
    values = np.asarray(values)[:, :3]
    if values.dtype == np.uint8 or len(values) == 0:
        return np.array(values, dtype=np.uint8)
    is_bad = ~np.isfinite(values).all(axis=1)
    if is_bad.any():
        values = np.where(is_bad[:, None], 0, values)
        notes.say(f"{what}: {int(is_bad.sum())} were NaN or infinite and are black")
    lowest, highest = float(values.min()), float(values.max())
    if values.dtype == np.uint16 and highest > 255:
        scale = 255.0 / 65535.0
    elif lowest < -1e-6 or highest > 65535.0:
        notes.say(f"{what} from {lowest:g} to {highest:g} are neither 0–1 nor 0–255: left out", warn=True)
        return None
    elif highest <= 1.0 + 1e-6 and (values.dtype.kind == "f" or values.dtype.itemsize > 1):
        scale = 255.0
    elif highest <= 255.5:
        scale = 1.0
    else:
        scale = 255.0 / 65535.0
    if scale != 1.0 or values.dtype.kind == "f":
        ranges = {255.0: "0–1", 1.0: "0–255"}
        notes.say(f"{what}: numbers up to {highest:g} were taken as {ranges.get(scale, '0–65535')}")
    out: ByteArray = np.clip(np.round(values * scale), 0, 255).astype(np.uint8)
    return out


def unpacked(values: Any) -> ByteArray:
    """(n, 3) uint8 of numbers that hold a colour in their bits, 0xRRGGBB with or without alpha above.

    The ``values`` are integers, or 32-bit floats of the same bits.
    """
    values = np.asarray(values)
    is_float = values.dtype.kind == "f"
    bits = (
        values.astype(np.float32).view(np.uint32) if is_float else values.astype(np.int64).astype(np.uint32)
    )
    return np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], axis=1).astype(np.uint8)


def to_srgb(linear: FloatArray) -> ByteArray:
    """Bytes as screens want them of linear light in 0–1 (IEC 61966-2-1)."""
    light = np.clip(linear, 0.0, 1.0)
    curved = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    out: ByteArray = np.round(255.0 * curved).astype(np.uint8)
    return out


def to_linear(srgb: ByteArray) -> FloatArray:
    """Linear light in 0–1 of bytes as screens want them, ``srgb`` (IEC 61966-2-1)."""
    steps = np.arange(256) / 255.0
    table: FloatArray = np.where(steps <= 0.04045, steps / 12.92, ((steps + 0.055) / 1.055) ** 2.4)
    return table.astype(np.float32)[srgb]


def at_vertices(
    corners: IntArray,
    corner_colors: ByteArray,
    n_vertices: int,
    *,
    is_known: Any = None,
    fallback: ByteArray | None = None,
) -> ByteArray:
    """(n_vertices, 3) mean colour over the corners at each vertex.

    Parameters
    ----------
    corners : (n_corners,) int
        Vertex of each corner; others than 0 to n_vertices - 1 are left out.
    corner_colors : (n_corners, 3) uint8
    n_vertices : int
    is_known : (n_corners,) bool, optional
        Corners that have a colour; all by default.
    fallback : (n_vertices, 3) uint8, optional
        For vertices without such a corner; white by default.
    """
    is_valid = (corners >= 0) & (corners < n_vertices)
    if is_known is not None:
        is_valid &= is_known
    if not is_valid.all():
        corners, corner_colors = corners[is_valid], corner_colors[is_valid]
    count = np.bincount(corners, minlength=n_vertices)
    out = np.full((n_vertices, 3), 255, dtype=np.uint8) if fallback is None else np.array(fallback)
    has = count > 0
    for k in range(3):
        sums = np.bincount(corners, corner_colors[:, k], n_vertices)
        out[has, k] = np.round(sums[has] / count[has])
    return out


# --- textures -------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Texture:
    """Pixels of a picture and how coordinates beyond it are meant.

    Attributes
    ----------
    pixels : (height, width, 3) uint8
    is_bottom_up : bool
        Whether v counts from the bottom row, as in OBJ and PLY; in glTF it counts from the top.
    wrap : (str, str)
        "repeat", "mirror" or "clamp", for u and v.
    """

    pixels: ByteArray
    is_bottom_up: bool = True
    wrap: tuple[str, str] = ("repeat", "repeat")

    def at(self, uv: FloatArray) -> ByteArray:
        """(n, n_corners, 3) pixels at the corners ``uv`` of n polygons, (n, n_corners, 2).

        Each is taken half a pixel inside its polygon: at the seam of a patch the pixel beyond belongs to
        another one.
        """
        uv = np.asarray(uv, dtype=np.float64)
        out = np.empty((*uv.shape[:2], 3), dtype=np.uint8)
        for start in range(0, len(uv), STEP):
            out[start : start + STEP] = self._at(uv[start : start + STEP])
        return out

    def _at(self, uv: FloatArray) -> ByteArray:
        height, width = self.pixels.shape[:2]
        place = np.where(np.abs(uv) < 1e6, uv, 0.0) * (width, height)  # NaN and nonsense: the corner
        inward = place.mean(axis=1, keepdims=True) - place
        length = np.linalg.norm(inward, axis=2, keepdims=True)
        place += inward * np.divide(0.5, length, out=np.ones_like(length), where=length > 0.5)
        column = _wrapped(np.floor(place[:, :, 0]).astype(np.int64), width, self.wrap[0])
        row = _wrapped(np.floor(place[:, :, 1]).astype(np.int64), height, self.wrap[1])
        return np.asarray(self.pixels[height - 1 - row if self.is_bottom_up else row, column])


def _wrapped(index: IntArray, size: int, how: str) -> IntArray:
    if how == "clamp":
        return np.clip(index, 0, size - 1)
    if how == "mirror":
        index = np.mod(index, 2 * size)
        return np.minimum(index, 2 * size - 1 - index)
    return np.mod(index, size)


def open_image(source: Path | bytes, name: str, notes: Notes) -> ByteArray | None:
    """(height, width, 3) pixels of a picture; None, with a warning in ``notes``, where there are none.

    ``source`` is its file or its bytes, ``name`` what the warning calls it.
    """
    from PIL import Image

    try:
        with Image.open(
            io.BytesIO(source) if isinstance(source, bytes) else source, formats=FORMATS
        ) as image:
            if image.width * image.height > MAX_PIXELS and image.format == "JPEG":
                image.draft("RGB", _halved(image.size))
            if image.width * image.height > MAX_PIXELS:
                raise MeshError(f"{image.width} × {image.height} pixels are more than {MAX_PIXELS}")
            if image.mode.startswith("I"):  # 16 bits of grey, which Pillow would cut off at 255
                grey = np.asarray(image.convert("I")) // 257
                return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)
            return np.asarray(image.convert("RGB"))
    except FileNotFoundError:
        notes.say(f"texture {name!r} is missing: what it colours has no colours", warn=True)
    except Exception as error:  # Pillow raises whatever its decoders stumble over
        notes.say(f"texture {name!r} can't be read ({error!s:.120}): its colours are lost", warn=True)
    return None


def _halved(size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    while width * height > MAX_PIXELS:
        width, height = width // 2, height // 2
    return width, height
