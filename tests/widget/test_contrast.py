"""Text of the front end stands out from what lies behind it, by the measure of WCAG 2.2 (4.5 : 1)."""

import re
from pathlib import Path

import pytest

STYLE = Path(__file__).parents[2] / "scenewidget" / "js" / "src" / "panel" / "style.css"
LEAST = 4.5


def rules():
    """Colours of both themes by name; the dark one only says what differs."""
    text = STYLE.read_text(encoding="utf-8")
    light, dark = (
        dict(re.findall(r"--sw-(\w+): ([^;]+);", text.split(start, 1)[1].split("}", 1)[0]))
        for start in ("\n.scenewidget {", '\n.scenewidget[data-theme="dark"] {')
    )
    return {"light": light, "dark": light | dark}


def hexes(text):
    return re.findall(r"#[0-9a-f]{6}\b", text)


def luminance(color):
    channels = [int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear))


def contrast(a, b):
    dark, light = sorted((luminance(a), luminance(b)))
    return (light + 0.05) / (dark + 0.05)


def test_the_measure_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("text", ["ink", "muted", "accent"])
def test_text_stands_out_from_panels_and_from_the_empty_picture(theme, text):
    colors = rules()[theme]
    (color,) = hexes(colors[text])
    behind = [*hexes(colors["solid"]), *hexes(colors["sky"])]
    assert len(behind) >= 4
    assert {b: round(contrast(color, b), 2) for b in behind if contrast(color, b) < LEAST} == {}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_of_the_queue_stands_out_from_its_rows(theme):
    text = (STYLE.parents[1] / "workbench" / "workbench.css").read_text(encoding="utf-8")
    pattern = r"--sww-([\w-]+): (#[0-9a-f]{3,6});"
    light, dark = (
        dict(re.findall(pattern, text.split(start, 1)[1].split("}", 1)[0]))
        for start in (".sww {", '\n.sww[data-theme="dark"] {')
    )
    colors = {"light": light, "dark": light | dark}[theme]
    colors = {name: c if len(c) == 7 else "#" + "".join(2 * d for d in c[1:]) for name, c in colors.items()}
    named = ("ink", "muted", "accent", "done", "review", "begun", "wrong")
    low = {name: round(contrast(colors[name], colors["paper"]), 2) for name in named}
    low["on-accent"] = round(contrast(colors["on-accent"], colors["accent"]), 2)
    assert {name: value for name, value in low.items() if value < LEAST} == {}


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("field", [0.0, 1.0], ids=["on the page", "in a field"])
def test_text_of_the_controls_stands_out_from_pages_and_fields(theme, field):
    text = (STYLE.parents[1] / "controls" / "controls.css").read_text(encoding="utf-8")
    light, dark = (
        dict(re.findall(r"--swc-(\w+): ([^;]+);", text.split(start, 1)[1].split("}", 1)[0]))
        for start in (".swc {", '\n.swc[data-theme="dark"] {')
    )
    colors = {"light": light, "dark": light | dark}[theme]
    page = {"light": "#ffffff", "dark": "#111111"}[theme]  # of JupyterLab
    *tint, share = (int(x) for x in re.findall(r"\d+", colors["field"]))
    behind = "#" + "".join(
        f"{round(c + field * share / 100 * (t - c)):02x}"
        for c, t in zip((int(page[k : k + 2], 16) for k in (1, 3, 5)), tint)
    )
    named = ("ink", "muted", "accent", "wrong", "good")
    low = {name: round(contrast(colors[name], behind), 2) for name in named}
    assert {name: value for name, value in low.items() if value < LEAST} == {}


def test_nothing_swings_or_slides_for_who_asked_for_less_motion():
    moving = 0
    for path in (STYLE.parents[1]).rglob("*.css"):
        text = path.read_text(encoding="utf-8")
        calm = text.partition("@media (prefers-reduced-motion: reduce) {")[2]
        for selector, rule in re.findall(r"([^{}]+)\{([^{}]*)\}", text.replace(calm, "")):
            for kind in re.findall(r"\b(animation|transition):", rule):
                last = selector.split("*/")[-1].split()[-1]
                assert re.search(rf"{re.escape(last)} \{{[^}}]*{kind}: none", calm), (
                    f"{path.name}: {selector}"
                )
                moving += 1
    assert moving > 0
