"""Kernels are compiled once where that can be remembered, and work where it can't."""

import numba
import numpy as np
import pytest
from numba.core import config

from scenewidget.engine.kernels import compiling, kernel


def first(values):
    return values[0]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where this test's kernels are remembered."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def compiled(function, *values):
    """How many times it was compiled to give these values, each a first entry."""
    heard = []
    with compiling(lambda: heard.append(1)):
        assert [function(np.array([value])) for value in values] == list(values)
    return len(heard)


def test_a_process_compiles_what_no_other_has(folder):
    assert compiled(kernel(first), 1.5, 2.5, 7) == 2  # for floats and for integers
    assert compiled(kernel(first), 1.5, 7) == 0


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 20])
def test_what_was_cut_off_is_compiled_again_and_mended(folder, ending, left):
    compiled(kernel(first), 1.5)
    (path,) = folder.rglob(f"*.{ending}")
    path.write_bytes(path.read_bytes()[:left])
    assert compiled(kernel(first), 1.5) == 1
    assert compiled(kernel(first), 1.5) == 0


def test_what_another_process_wrote_under_the_same_name_is_not_run(folder):
    compiled(kernel(first), 1.5)
    compiled(kernel(first), 7)
    one, other = sorted(folder.rglob("*.nbc"))
    one.write_bytes(other.read_bytes())
    assert compiled(kernel(first), 1.5, 7) == 1


def test_a_full_disk_is_not_the_kernels_concern(folder, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile._save_data", full)
    assert compiled(kernel(first), 1.5) == 1
    assert compiled(kernel(first), 1.5) == 1


def test_where_nothing_can_be_written_nothing_is(monkeypatch, recwarn):
    monkeypatch.setattr("numba.core.caching.CompileResultCacheImpl._locator_classes", [])
    with pytest.raises(RuntimeError, match="no locator"):
        numba.njit(cache=True)(first)
    assert compiled(kernel(first), 1.5) == 1
    assert not recwarn.list
