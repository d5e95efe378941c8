"""Kill −9 in the middle of work: no acknowledged edit is lost and the file always opens."""

import os

import pytest
from saver import kill_rounds


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_twenty_kills_lose_nothing(tmp_path):
    acknowledged, found = kill_rounds(tmp_path, 20)
    assert all(n <= m for n, m in zip(acknowledged, found))
    assert max(acknowledged) > 50
    assert {path.name for path in tmp_path.iterdir() if not path.name.endswith(".tmp")} == {"room.swproj"}
