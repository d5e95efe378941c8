"""The bar in a notebook: what it says, and its button."""

import threading

import pytest

import scenewidget as sw
from scenewidget.batch import pools, progress
from scenewidget.batch.plan import Job
from scenewidget.batch.progress import NotebookBar
from scenewidget.batch.runs import Run


@pytest.fixture
def run(tmp_path):
    jobs = [Job(name, name, str(tmp_path / name), sw.Params()) for name in ("a.ply", "<b>.ply")]
    return Run(jobs, str(tmp_path), None, 0)


@pytest.fixture
def bars(monkeypatch):
    """Bars as they are put on the page of a notebook."""
    found = []
    monkeypatch.setattr(progress, "_in_notebook", lambda: True)
    monkeypatch.setattr(NotebookBar, "show", lambda bar: found.append(bar))
    return found


def test_a_bar_tells_what_went_wrong_as_text(run):
    bar = NotebookBar(run)
    run.rows["<b>.ply"] = {"scan": "<b>.ply", "status": "failed", "error": "damaged"}
    bar.hear(run, run.rows["<b>.ply"])
    row, wrong = bar.box.children
    assert [row.children[0].value, row.children[1].value] == [1, "1 of 2 scans"]
    assert wrong.value == "&lt;b&gt;.ply  failed: damaged"
    bar.end(run)
    assert row.children[1].value == "2 scans: 1 failed, 1 left"
    assert bar.button.layout.display == "none"


@pytest.mark.parametrize("wait", [True, False])
def test_its_button_cancels_the_run_after_the_scan_under_way(tmp_path, bars, monkeypatch, wait):
    begun, go_on = threading.Event(), threading.Event()

    def slow(job, tell):
        begun.set()
        go_on.wait(30)
        return {"scan": job.scan, "status": "done", "error": "", "segments": 1, "seconds": 1.0}

    def press():
        begun.wait(30)
        bars[0].button.click()
        go_on.set()

    monkeypatch.setattr(pools, "run_job", slow)
    for name in "abc":
        (tmp_path / f"{name}.off").touch()
    page = threading.Thread(target=press)
    page.start()
    found = sw.segment_all(tmp_path, tmp_path / "out", n_workers=0, wait=wait).wait(30)
    page.join()
    assert repr(found) == "Run(3 scans: 1 done, 2 left)"
    assert bars[0].button.description == "Cancelling"


def test_an_error_that_ends_a_run_behind_is_told(tmp_path, bars, monkeypatch):
    monkeypatch.setattr(Run, "work", lambda self, hear: 1 / 0)
    (tmp_path / "a.off").touch()
    found = sw.segment_all(tmp_path, tmp_path / "out", n_workers=0, wait=False)
    with pytest.raises(ZeroDivisionError):
        found.wait(30)
    assert "It ended early: division by zero" in bars[0].box.children[1].value
