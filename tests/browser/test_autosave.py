"""Corrections outlive the kernel: saved without being asked, offered again, told in words."""

from __future__ import annotations

from editing_page import WIDGET, Editor


def word(editor, text):
    """Wait until the word beside the Save button is this one."""
    editor.root.locator(".sw-saved", has_text=text).wait_for()


def files(editor):
    return sorted(editor.python("[p.name for p in __import__('pathlib').Path.cwd().glob('*.swproj')]"))


def merge(editor):
    (_, start), (_, end) = editor.ends()
    editor.view.drag(start, end)
    editor.settled(editor.n - 1)


def restart(editor):
    """End the kernel and run the cell again in a new one."""
    old = editor.root.element_handle()
    editor.book.restart()
    editor.book.run_all()
    editor.page.wait_for_function("old => !old.isConnected", arg=old)  # the output of the dead kernel
    return Editor(editor.book)


def test_edits_are_there_again_after_a_kernel_restart(editor):
    assert editor.root.locator(".sw-saved").inner_text() == ""
    assert files(editor) == []
    merge(editor)
    word(editor, "Saved")
    assert len(files(editor)) == 1
    before = editor.python("w.segmentation.labels.tolist()")
    again = restart(editor)
    notice = again.root.get_by_role("alert").filter(has_text="1 step in scan-")
    notice.wait_for()
    assert int(again.view.state("segments")) == editor.n
    notice.get_by_role("button", name="Restore").click()
    again.settled(editor.n - 1)
    notice.wait_for(state="hidden")
    assert again.python("w.segmentation.labels.tolist()") == before
    assert again.edits() == ["Merge"]
    again.root.focus()
    again.page.keyboard.press("Control+z")
    again.settled(editor.n)
    word(again, "Saved")


def test_starting_afresh_and_saving_by_key_and_button(editor):
    merge(editor)
    word(editor, "Saved")
    again = restart(editor)
    again.root.get_by_role("button", name="Start afresh").click()
    again.root.get_by_role("button", name="Start afresh").wait_for(state="hidden")
    assert len(files(again)) == 1
    again.page.keyboard.press("Control+s")
    again.root.locator(".sw-remark", has_text="Saved in scan-").wait_for()
    assert len(files(again)) == 2
    merge(again)
    word(again, "Saved")
    again.button("Save").click()
    again.root.locator(".sw-remark", has_text="Saved in scan-").wait_for()
    assert len(files(again)) == 2
    assert again.page.locator(".jp-Dialog").count() == 0


def test_what_cannot_be_saved_is_said(notebook):
    book = notebook([WIDGET.replace("n_graph_runs=4),", "n_graph_runs=4), autosave='nowhere/room.swproj',")])
    book.run_all()
    editor = Editor(book)
    merge(editor)
    word(editor, "Can't save")
    notice = editor.root.get_by_role("alert").filter(has_text="its folder does not exist")
    notice.wait_for()
    assert "Your edits are in memory only" in notice.inner_text()
    book.execute("import os; os.mkdir('nowhere')")
    notice.get_by_role("button", name="Try again").click()
    word(editor, "Saved")
    notice.wait_for(state="hidden")
