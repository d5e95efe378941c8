"""A bar over a loop."""

import gc

import pytest

from scenewidget import figures


@pytest.fixture
def shown(monkeypatch):
    """(box, plain text) of each bar that a notebook would have shown."""
    from scenewidget.figures import progress

    boxes, seen = [], []

    class Box(progress.widgets.HBox):
        def __init__(self, *args, **options):
            super().__init__(*args, **options)
            boxes.append(self)

    monkeypatch.setattr(progress.widgets, "HBox", Box)
    monkeypatch.setattr(progress, "get_ipython", lambda: "a notebook")
    monkeypatch.setattr(
        progress, "display", lambda bundle, raw: seen.append((boxes[-1], bundle["text/plain"]))
    )
    return seen


def test_a_sweep_tells_how_far_it_is_and_leaves_no_trace(shown):
    seen = []
    for value in figures.sweep("abc", title="letters"):
        bar, text = shown[0][0].children
        seen.append((value, bar.value, bar.max, text.value))
    assert seen == [
        ("a", 0, 3, "letters 0 of 3"),
        ("b", 1, 3, "letters 1 of 3"),
        ("c", 2, 3, "letters 2 of 3"),
    ]
    (box, text), *others = shown
    assert (text, others, box.layout.display) == ("", [], "none")


def test_a_sweep_that_is_broken_off_takes_its_bar_away(shown):
    for _ in figures.sweep(range(3)):
        break
    gc.collect()
    assert shown[0][0].layout.display == "none"


def test_a_sweep_outside_of_a_notebook_shows_nothing(capsys):
    assert list(figures.sweep(iter([3, 1]))) == [3, 1]
    assert capsys.readouterr().out == ""
