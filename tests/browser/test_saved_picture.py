"""The picture prints, copies, and is saved as a file of the size that one asks for."""

from __future__ import annotations

import base64
import io
import re
import zlib

import numpy as np
import pytest
from PIL import Image

COPIED = """canvas => {
    const copy = document.createElement("canvas");
    Object.assign(copy, { width: canvas.width, height: canvas.height });
    copy.getContext("2d").drawImage(canvas, 0, 0);
    return copy.toDataURL("image/png").split(",")[1];
}"""


def shades(pixels):
    """How many clearly different colours there are."""
    return len(np.unique(pixels.reshape(-1, pixels.shape[-1])[:, :3] // 32, axis=0))


def saved_picture(view):
    """The file that the button gives."""
    with view.page.expect_download() as download:
        view.root.get_by_role("button", name="Save PNG").click()
    assert download.value.suggested_filename.endswith(".png")
    return np.asarray(Image.open(download.value.path()))


def test_what_is_copied_from_the_canvas_is_the_picture(saved):
    saved.page.wait_for_timeout(500)  # long after it was drawn
    data = saved.root.locator("canvas").evaluate(COPIED)
    pixels = np.asarray(Image.open(io.BytesIO(base64.b64decode(data))))
    assert shades(pixels) >= 4
    assert (pixels[..., 3] > 0).mean() > 0.1


def test_it_prints(saved):
    pages = saved.page.pdf(print_background=True)
    assert max((shades(image) for image in images_of(pages)), default=0) >= 4


def images_of(pdf):
    """Colour images in a PDF as Chromium writes them."""
    for found in re.finditer(
        rb"/Subtype /Image\n/Width (\d+)\n/Height (\d+)\n/ColorSpace \[.*?stream\n", pdf, re.S
    ):
        width, height = int(found[1]), int(found[2])
        raw = zlib.decompressobj().decompress(pdf[found.end() :])
        yield np.frombuffer(raw, np.uint8).reshape(height, width, 3)


@pytest.mark.parametrize(("width", "height", "scale"), [("640", "480", "1"), ("300", "900", "3")])
def test_it_is_saved_at_the_size_and_scale_that_one_asks_for(saved, width, height, scale):
    before = saved.pixels()
    saved.root.focus()
    saved.page.keyboard.press("p")
    saved.root.get_by_role("spinbutton", name="Width in pixels").fill(width)
    saved.root.get_by_role("spinbutton", name="Height in pixels").fill(height)
    saved.root.get_by_role("combobox", name="Scale").select_option(scale)
    picture = saved_picture(saved)
    times = int(scale)
    assert picture.shape[:2] == (times * int(height), times * int(width))
    assert shades(picture) >= 4
    assert tuple(picture[0, 0, :3]) == (255, 255, 255)
    saved.page.keyboard.press("Escape")
    saved.root.get_by_role("dialog", name="Picture").wait_for(state="hidden")
    assert (np.abs(saved.pixels().astype(int) - before) > 20).mean() < 0.01  # the page shows what it did


def test_it_is_saved_without_a_background_and_with_its_legend(saved):
    saved.root.get_by_label("Colour by").select_option("normals")
    saved.root.get_by_role("button", name="Picture", exact=True).click()
    saved.root.get_by_role("combobox", name="Scale").select_option("1")
    saved.root.get_by_role("checkbox", name="Transparent background").check()
    plain = saved_picture(saved)
    assert plain[0, 0, 3] == 0
    saved.root.get_by_role("checkbox", name="With the legend").check()
    legend = saved_picture(saved)
    corner = (slice(-60, -12), slice(-150, -12))
    assert (legend[corner] != plain[corner]).any(axis=-1).mean() > 0.5
    assert (legend[:200] == plain[:200]).all()


def test_one_that_is_too_large_is_refused_with_the_reason(saved):
    saved.root.get_by_role("button", name="Picture", exact=True).click()
    saved.root.get_by_role("spinbutton", name="Width in pixels").fill("100000")
    saved.root.get_by_role("button", name="Save PNG").click()
    saved.root.get_by_text("A picture may have").wait_for()
