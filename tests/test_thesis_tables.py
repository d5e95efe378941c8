"""The thesis' tables on a scene made here, in the format of SceneNN."""

import numpy as np
import pandas as pd
import pytest
from scenenn_files import scenenn_ply

import scenewidget as sw
from scenewidget.command_line import main
from scenewidget.command_line import tables as thesis_tables


def write_room(folder, scene, seed=0):
    """A floor, two walls and a box that stands on it, as SceneNN would store them; returns the folder."""
    n = 24
    u, v = np.meshgrid(np.linspace(0, 3, n + 1), np.linspace(0, 3, n + 1), indexing="ij")
    sheets = [
        np.stack([u, v, 0 * u], -1),
        np.stack([0 * u, u, v], -1),
        np.stack([v, 0 * u, u], -1),
        np.stack([0.8 + u / 4, 0.8 + v / 4, 0.7 + 0 * u], -1),
    ]
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    one = np.concatenate(
        [
            np.stack([corner, corner + n + 1, corner + n + 2], 1),
            np.stack([corner, corner + n + 2, corner + 1], 1),
        ]
    )
    vertices = np.concatenate([s.reshape(-1, 3) for s in sheets])
    vertices = vertices + np.random.default_rng(seed).normal(scale=0.002, size=vertices.shape)
    faces = np.concatenate([one + k * (n + 1) ** 2 for k in range(4)])
    labels = np.repeat([11, 12, 13, 14], (n + 1) ** 2)
    entries = "".join(
        f'<label id="{k}" text="" nyu_class="{name}"/>'
        for k, name in zip((11, 12, 13, 14), ("floor", "wall", "wall", "table"))
    )
    (folder / scene).mkdir(parents=True)
    (folder / scene / f"{scene}.ply").write_bytes(scenenn_ply(vertices, faces.tolist(), labels))
    (folder / scene / f"{scene}.xml").write_text(f"<scene>{entries}</scene>")
    return folder


def test_printed_values_are_those_that_the_thesis_averages():
    means = {name: np.mean(list(scenes.values()), axis=0) for name, scenes in thesis_tables.THESIS.items()}
    np.testing.assert_allclose(means[thesis_tables.SEMI], [0.0417, 0.1458, 0.0951], atol=6e-5)
    np.testing.assert_allclose(means[thesis_tables.OURS], [0.1124, 0.4081, 0.2918], atol=6e-5)
    np.testing.assert_allclose(means[thesis_tables.OVER], [0.1413, 0.2658, 0.1262], atol=6e-5)
    np.testing.assert_allclose(means[thesis_tables.FINAL], [0.2382, 0.3556, 0.1315], atol=6e-5)


@pytest.mark.filterwarnings("ignore::UserWarning")  # a room so small makes the method say so
def test_one_command_prints_every_table(tmp_path, capsys):
    folder = write_room(write_room(tmp_path / "data", "016"), "066", seed=1)
    by_hand = tmp_path / "by hand"
    by_hand.mkdir()
    mesh, truth = sw.datasets.load_scenenn(folder / "066" / "066.ply")
    session = sw.Session(mesh, truth)
    session.merge(0, onto_face=mesh.n_faces - 1)  # one mistake, taken back: what is left is right
    session.undo()
    session.save(by_hand / "066.swproj")
    session.close()
    before = (by_hand / "066.swproj").read_bytes()
    csv = tmp_path / "all.csv"
    code = main(
        [
            "tables",
            str(folder),
            "--scenes",
            "016",
            "066",
            "071",
            "--semi-automatic",
            str(by_hand),
            "--csv",
            str(csv),
        ]
    )
    out, err = capsys.readouterr()
    assert code == 0
    assert "not in" in err
    assert "071" in err
    for number in ("4.2", "4.3", "4.4", "4.5", "4.6"):
        assert f"Table {number}" in out
    assert "0.0914" in out  # the thesis' value for scene 016
    assert "0.1412 (0.0755)" in out  # with the deviation over thresholds that it printed
    assert (by_hand / "066.swproj").read_bytes() == before
    lines = csv.read_text().splitlines()
    assert len(lines) == 1 + 1 + 2 * (1 + 10 + 1)  # header, by hand, and two scenes × (ours, ten, final)
    by_hand_line = next(line for line in lines if line.startswith("Semi-Automatic"))
    assert by_hand_line.startswith("Semi-Automatic,066,,0.0,0.0,0.0,1.0")


def test_settings_hold_every_feature_and_cost_function_of_the_thesis(monkeypatch):
    asked = []
    monkeypatch.setattr(sw, "segment", lambda mesh, params: asked.append(params), raising=False)
    rows = thesis_tables.methods("all", seed=3, semi_automatic=None)
    for name, run in rows.items():
        if name.startswith(("Ours", "Default")):
            run(None, "016")
    costs = {(p.feature, p.cost_a, p.cost_b, p.cost_exponent) for p in asked[:-1]}
    assert costs == {
        (feature, *cost)
        for feature in ("uniform", "cotangent", "gps")
        for cost in ((1.0, 0.0, 1.0), (1.0, -1.0, 1.5))
    }
    assert asked[-1] == sw.Params(seed=3)
    assert {p.seed for p in asked} == {3}


def test_tables_average_over_scenes_and_settings():
    measured = pd.DataFrame(
        [
            {"method": thesis_tables.OVER, "scene": s, "setting": c, "RI": v, "GCE": 0.5, "LCE": 0.25,
             "coverage": 1.0, "seconds": 2.0}
            for s, c, v in (("016", "1", 0.1), ("016", "2", 0.3), ("057", "1", 0.2), ("057", "2", 0.2))
        ]
    )  # fmt: skip
    table = thesis_tables.per_scene(measured, thesis_tables.OVER)
    assert table.loc["016", "RI"] == "0.2000 (0.1000)"
    assert table.loc["057", ["RI", "GCE", "thesis RI"]].tolist() == ["0.2000", "0.5000", "0.1671 (0.0357)"]
    row = thesis_tables.summary(measured).loc[thesis_tables.OVER]
    assert row["RI"] == f"0.2000 ({np.std([0.1, 0.3, 0.2, 0.2]):.4f})"
    assert row["thesis RI"] == f"{(0.1412 + 0.1671) / 2:.4f} ({(0.1671 - 0.1412) / 2:.4f})"


def test_printed_deviations_are_those_of_the_printed_values():
    for name, printed in thesis_tables.THESIS.items():
        spread = np.std(list(printed.values()), axis=0)
        if name != thesis_tables.OVER:  # that one is over scenes and thresholds together
            np.testing.assert_allclose(spread, thesis_tables.SPREADS[name], atol=2e-3)
    means = np.array(list(thesis_tables.THESIS[thesis_tables.OVER].values()))
    within = np.array(list(thesis_tables.SPREADS_OVER.values()))
    together = np.sqrt(means.var(axis=0) + (within**2).mean(axis=0))
    np.testing.assert_allclose(together, thesis_tables.SPREADS[thesis_tables.OVER], atol=1e-3)


def test_a_folder_without_scenes_ends_with_a_word(tmp_path, capsys):
    assert main(["tables", str(tmp_path), "--scenes", "016"]) == 1
    assert "SceneNN's files are found as 016/016.ply" in capsys.readouterr().err


def test_a_damaged_scene_ends_with_its_name_and_no_traceback(tmp_path, capsys):
    (tmp_path / "016.ply").write_bytes(b"ply")
    assert main(["tables", str(tmp_path), "--scenes", "016"]) == 1
    assert "scenewidget tables: '016.ply'" in capsys.readouterr().err


def test_unknown_words_get_the_list_of_commands(capsys):
    with pytest.raises(SystemExit) as end:
        main(["tabels"])
    assert end.value.code == 2
    assert "tables" in capsys.readouterr().err
