"""Wherever a page puts a view, it fills its place and the pointer hits what it is on."""

from __future__ import annotations

import pytest

SCALED = """transform => {
    document.body.style.transformOrigin = "0 0";
    document.body.style.transform = transform;
}"""


@pytest.mark.parametrize("transform", ["scale(.6)", "scale(.8, .5)", "scale(1.3)"])
def test_the_pointer_hits_what_it_is_on_at_any_scale(saved, transform):
    places = {part: place for part, place in saved.parts().items() if part}
    canvas = saved.root.locator("canvas")
    before = canvas.bounding_box()
    saved.page.evaluate(SCALED, transform)
    saved.settle()
    box = canvas.bounding_box()
    across, down = box["width"] / before["width"], box["height"] / before["height"]
    assert (across, down) != (1, 1)
    seen = {part: (x * across, y * down) for part, (x, y) in places.items()}
    inside = {part: (x, y) for part, (x, y) in seen.items() if x < 900 and 60 * down < y < 560}
    assert len(inside) >= 3
    for part, (x, y) in inside.items():
        saved.point(x, y)
        saved.wait("hovered", part)


def test_the_wheel_leaves_what_it_is_on_in_its_place_at_any_scale(saved):
    saved.page.evaluate(SCALED, "scale(.6)")
    part, (x, y) = next((part, place) for part, place in saved.parts().items() if part)
    saved.point(x, y)
    for _ in range(4):
        saved.page.mouse.wheel(0, -120)
        saved.settle()
    saved.point(x, y)
    saved.wait("hovered", part)
