"""Kill −9 in the middle of work: no acknowledged edit is lost and the file always opens."""

from saver import kill_rounds


def test_kills_at_any_moment_lose_nothing(tmp_path):
    acknowledged, found = kill_rounds(tmp_path, 12)
    assert all(n <= m for n, m in zip(acknowledged, found))
    assert max(acknowledged) > 25
    assert {path.name for path in tmp_path.iterdir() if not path.name.endswith(".tmp")} == {"room.swproj"}
