"""What a cut would divide off shows before it is done."""

from __future__ import annotations


def largest(editor):
    """A place well inside the segment that most can be seen of."""
    return next((x, y) for x, y in editor.places().values() if 60 < y < editor.view.size()[1] - 100)


def test_the_other_side_of_a_cut_shows_while_the_pointer_rests(editor):
    x, y = largest(editor)
    steps = editor.root.get_by_text("Drag a part onto another to merge")
    editor.view.point(-40, 100)
    steps.wait_for()
    editor.root.focus()
    editor.page.keyboard.press("c")
    editor.root.get_by_text("Cut: click or drag from one side of a segment").wait_for()
    steps.wait_for(state="hidden")  # that is what another tool does
    editor.click((x - 14, y))
    rubber = editor.root.locator(".sw-rubber")
    editor.view.point(-40, 100)
    assert rubber.is_visible()  # the first point stays marked
    assert not rubber.locator("line").first.is_visible()
    editor.view.point(x + 14, y)
    hint = editor.root.get_by_text("a click here cuts")
    hint.wait_for()
    assert editor.edits() == []
    assert editor.view.state("segments") == str(editor.n)
    n_faces = int("".join(filter(str.isdigit, hint.inner_text().split("cuts")[1])))
    editor.click((x + 14, y))
    editor.settled(editor.n + 1)
    face = editor.python("w.session.edits[0].face_b")
    labels = "w.segmentation.labels"
    assert editor.python(f"int(({labels} == {labels}[{face}]).sum())") == n_faces


def test_escape_takes_the_first_point_and_the_preview_back(editor):
    x, y = largest(editor)
    editor.button("Cut").click()
    editor.click((x - 14, y))
    editor.view.point(x + 14, y)
    editor.root.get_by_text("a click here cuts").wait_for()
    editor.root.focus()
    editor.page.keyboard.press("Escape")
    editor.root.get_by_text("Cut: click or drag from one side of a segment").wait_for()
    assert not editor.root.locator(".sw-rubber").is_visible()
    editor.view.wait("picked", "")
    editor.button("Let go").click()
    editor.view.wait("tool", "merge")
    assert editor.edits() == []


def test_a_segment_is_named_and_hidden_whole_while_a_cut_shows(editor):
    x, y = largest(editor)
    editor.view.point(x, y)
    segment = editor.view.wait_until_pointed()
    editor.button("Cut").click()
    editor.click((x - 14, y))
    editor.view.point(x + 14, y)
    editor.root.get_by_text("a click here cuts").wait_for()
    editor.page.keyboard.press("n")
    form = editor.root.get_by_role("dialog", name="Name a segment")
    form.get_by_text(f"Segment {segment}", exact=True).wait_for()
    editor.page.keyboard.press("Escape")
    editor.page.keyboard.press("h")
    editor.view.wait("hidden", "1")
    hidden = "set(w.segmentation.labels[sorted(w.view._hidden)].tolist())"
    assert editor.python(hidden) == {int(segment)}
    assert int(segment) not in editor.places()
