"""One run at a time into a folder, and into a store that has no locks."""

import json

import pytest

from scenewidget.batch import claims
from scenewidget.batch.claims import claim

fsspec = pytest.importorskip("fsspec")


@pytest.fixture(params=["memory://claims/out", "file-like"])
def out(request, tmp_path, monkeypatch):
    """A store; of this machine's disk by another name than that which counts as a path."""
    monkeypatch.setattr(claims, "BEAT", 0.05)
    fsspec.filesystem("memory").store.clear()
    return request.param if request.param.startswith("memory") else f"local://{tmp_path}/out"


def names(out):
    fs, path = fsspec.core.url_to_fs(out)
    return [name.rpartition("/")[2] for name in fs.ls(path, detail=False)]


def test_a_second_run_into_a_store_is_refused_and_the_first_goes_on(out):
    ours = claim(out)
    with pytest.raises(ValueError, match=r"is being written by another run \(process \d+ on "):
        claim(out)
    assert len(names(out)) == 1
    assert not ours.is_lost
    ours.release()
    assert names(out) == []
    claim(out).release()


def test_what_a_dead_run_has_left_holds_nobody_up_whatever_its_clock_says(out):
    fs, path = fsspec.core.url_to_fs(out)
    fs.makedirs(path, exist_ok=True)
    fs.pipe_file(f"{path}/scenewidget.dead.claim", b'{"process": 1, "computer": "moon", "beat": 7}')
    ours = claim(out)
    assert len(names(out)) == 1
    ours.release()


def test_who_was_taken_for_dead_learns_it(out):
    ours = claim(out)
    fs, path = fsspec.core.url_to_fs(out)
    fs.rm_file(f"{path}/{names(out)[0]}")
    ours._thread.join(5)
    assert ours.is_lost
    ours.release()


def test_a_folder_made_for_nothing_goes_again(tmp_path):
    ours = claim(str(tmp_path / "a" / "out"))
    assert json.loads((tmp_path / "a" / "out" / "scenewidget.lock").read_text())["process"]
    ours.release()
    assert not (tmp_path / "a").exists()
    (tmp_path / "kept").mkdir()
    claim(str(tmp_path / "kept")).release()
    assert (tmp_path / "kept").exists()


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(NotADirectoryError, match=r"out must be a folder, and .* is a file"):
        claim(str(tmp_path / "out"))
    assert (tmp_path / "out").read_text() == "mine"
