"""Logs of corrections by hand-counted errors, and their comparison."""

import numpy as np
import pandas as pd
import pytest
import shapes

import scenewidget as sw
from scenewidget.editing import compare_interactions, interaction_log

MESH = shapes.grid_square(2)  # 8 faces
TRUTH = np.array([0, 0, 0, 0, 1, 1, 1, 1])


def session_with_a_mistake():
    session = sw.Session(MESH, sw.Segmentation.from_labels(MESH, [0, 0, 1, 1, 2, 2, 2, 2]))
    session.merge(0, onto_face=7)  # wrong
    session.undo()
    session.merge(0, onto_face=2)
    session.relabel(0, "floor")
    return session


def test_a_log_has_every_operation_with_its_errors():
    log = interaction_log(session_with_a_mistake(), TRUTH, pace=lambda edit: 1.0 if edit is None else 5.0)
    assert log["operation"].tolist() == ["start", "merge", "undo", "merge", "relabel"]
    assert log["seconds"].tolist() == [0, 5, 6, 11, 16]
    assert log["n_segments"].tolist() == [3, 2, 3, 2, 2]
    # pairs of 28 that are judged differently: 2 × 2 torn apart; then 2 × 2 torn and 2 × 4 joined
    np.testing.assert_allclose(log["rand_index_error"] * 28, [4, 12, 4, 0, 0], atol=1e-9)
    assert log["local_consistency_error"].iloc[0] == 0  # a refinement
    assert log.iloc[-1][["global_consistency_error", "local_consistency_error"]].tolist() == [0, 0]


def test_by_the_clock_time_never_runs_backward_and_begins_at_the_opening():
    session = session_with_a_mistake()
    log = interaction_log(session, sw.Segmentation.from_labels(MESH, TRUTH))
    assert (log["seconds"].diff().dropna() >= 0).all()
    times = [operation.time for operation in session.operations]
    assert log["seconds"].iloc[-1] == pytest.approx(times[-1] - times[0])
    assert session.operations[0].action == "open"


def test_two_logs_are_compared_by_what_they_took(tmp_path):
    log = interaction_log(session_with_a_mistake(), TRUTH, pace=lambda edit: 5.0)
    log.to_csv(tmp_path / "ours.csv", index=False)
    other = pd.DataFrame(
        {
            "seconds": [0, 10, 30],
            "operation": ["start", "lasso", "lasso"],
            "rand_index_error": [0.2, 0.1, 0.05],
        }
    )
    table = compare_interactions({"ours": tmp_path / "ours.csv", "other": other})
    assert table.loc["ours", ["operations", "taken_back", "seconds"]].tolist() == [4, 1, 20]
    assert table.loc["ours", ["operations_to_target", "seconds_to_target"]].tolist() == [3, 15]
    assert table.loc["ours", "mean_error"] == pytest.approx(5 * (4 + 12 + 4) / 28 / 20)
    assert table.loc["other", ["first_error", "last_error"]].tolist() == [0.2, 0.05]
    assert table.loc["other", "mean_error"] == pytest.approx((10 * 0.2 + 20 * 0.1) / 30)
    assert table.loc["other", ["operations_to_target", "seconds_to_target"]].isna().all()


@pytest.mark.parametrize(
    ("logs", "message"),
    [
        ({}, "logs must map names to logs"),
        ({"a": pd.DataFrame({"seconds": [0]})}, r"logs\['a'\] has no column 'operation'"),
        ({"a": pd.DataFrame(columns=["seconds", "operation", "rand_index_error"])}, "has no rows"),
        (
            {"a": pd.DataFrame({"seconds": [1, 0], "operation": ["", ""], "rand_index_error": [0, 0]})},
            "seconds that run backward",
        ),
    ],
)
def test_logs_that_are_none_are_refused(logs, message):
    with pytest.raises(ValueError, match=message):
        compare_interactions(logs)


def test_the_truth_of_another_mesh_is_refused():
    with pytest.raises(ValueError, match=r"truth must have a whole number for each face of the mesh: \(8,\)"):
        interaction_log(session_with_a_mistake(), TRUTH[:3])
