"""Damaged files are read or refused; tests/benchmarks/fuzz.py does the same for as long as one likes."""

import pytest
from fuzzing import READERS, Fuzzer


@pytest.fixture(scope="module")
def fuzzer(tmp_path_factory):
    return Fuzzer(tmp_path_factory.mktemp("fuzz"))


@pytest.mark.parametrize("reader", READERS)
def test_damaged_files_are_read_or_refused(fuzzer, reader):
    refused = sum(fuzzer.attack(reader, seed) for seed in range(60))
    assert refused > 0 or reader == "wal"  # a torn log ends before the damage


def test_every_truncation_of_a_project_is_refused(fuzzer):
    path, opened = fuzzer.files["swproj"]
    sound = fuzzer.sound["swproj"]
    for length in range(0, len(sound), len(sound) // 40):
        path.write_bytes(sound[:length])
        with pytest.raises(ValueError, match=r"p\.swproj"):
            fuzzer._open(opened)
    path.write_bytes(sound)
    assert fuzzer._open(opened) is False
