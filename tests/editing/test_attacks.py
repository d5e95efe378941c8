"""Splices, live copies and kills, a few of each; tests/benchmarks/attack.py tries thousands."""

from attacks import try_live_copies, try_migration_kills, try_splices


def test_splices_of_true_states_open_as_one_of_them_or_not_at_all(tmp_path):
    n_true, n_refused, wrong = try_splices(tmp_path, 80)
    assert wrong == []
    assert n_true > 10
    assert n_refused > 10


def test_copies_of_a_file_at_work_hold_what_was_acknowledged(tmp_path):
    n_true, _, wrong = try_live_copies(tmp_path, 25)
    assert wrong == []
    assert n_true > 10


def test_a_migration_can_be_killed_anywhere(tmp_path):
    not_yet, done = try_migration_kills(tmp_path, 24)
    assert not_yet > 0
    assert done > 0
