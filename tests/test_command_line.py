"""The command in a shell, called in this process: many scans, their truth, other hands, other formats."""

import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.batch import job as job_module
from scenewidget.batch.plan import FORMATS
from scenewidget.batch.worklist import Worklist
from scenewidget.command_line import main
from scenewidget.engine.readers.sniff import MESHES

FAST = ["--set", "n_segments=3", "--set", "n_runs=2", "--set", "n_graph_runs=2"]


def corner(n, size=2.0):
    """A floor and a wall."""
    floor = shapes.sheet(n, n, width=size, depth=size)
    wall = sw.Mesh(floor.vertices[:, [2, 0, 1]], floor.faces)
    return shapes.joined(floor, wall)


def write(mesh, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in mesh.vertices.tolist())
    faces = "".join(f"3 {a} {b} {c}\n" for a, b, c in mesh.faces.tolist())
    path.write_text(f"OFF\n{mesh.n_vertices} {mesh.n_faces} 0\n{rows}{faces}")
    return path


@pytest.fixture
def scans(tmp_path):
    """Two scans of one name in different folders, and a damaged one."""
    write(corner(4), tmp_path / "scans" / "kitchen" / "a.off")
    write(corner(5), tmp_path / "scans" / "bedroom" / "a.off")
    (tmp_path / "scans" / "broken.off").write_text("OFF\n9 9 9\n1 2")
    return tmp_path / "scans"


def rows(capsys, *words):
    """Exit code and rows of a command that speaks JSON."""
    code = main([*map(str, words), "--json", "--quiet"])
    return code, json.loads(capsys.readouterr().out)


def statuses(capsys, scans, out, *words):
    code, found = rows(capsys, "segment", scans, "--out", out, *FAST, *words)
    return code, {row["scan"]: row["status"] for row in found}


def test_one_bad_scan_stops_nobody(capsys, scans, tmp_path):
    code, found = rows(capsys, "segment", scans, "--out", tmp_path / "out", *FAST)
    assert code == 1
    assert [(row["scan"], row["status"]) for row in found] == [
        ("bedroom/a.off", "done"),
        ("broken.off", "failed"),
        ("kitchen/a.off", "done"),
    ]
    assert "broken.off" in found[1]["error"]
    assert found[0]["faces"] == 100
    assert found[0]["coverage"] == 1
    note = json.loads((tmp_path / "out" / "kitchen" / "a.off" / "row.json").read_text())
    assert note["status"] == "done"
    assert note["params"]["n_segments"] == 3
    labels = sw.import_labels(scans / "kitchen" / "a.off", tmp_path / "out" / "kitchen" / "a.off" / "a.npz")
    expected = sw.segment(scans / "kitchen" / "a.off", sw.Params(n_segments=3, n_runs=2, n_graph_runs=2))
    assert labels.labels.tolist() == expected.labels.tolist()


def test_what_is_done_is_reused_and_what_changed_is_not(capsys, scans, tmp_path):
    out = tmp_path / "out"
    (scans / "broken.off").unlink()
    assert statuses(capsys, scans, out) == (0, {"bedroom/a.off": "done", "kitchen/a.off": "done"})
    assert statuses(capsys, scans, out) == (0, {"bedroom/a.off": "reused", "kitchen/a.off": "reused"})
    write(corner(6), scans / "kitchen" / "a.off")
    assert statuses(capsys, scans, out) == (0, {"bedroom/a.off": "reused", "kitchen/a.off": "done"})
    (out / "bedroom" / "a.off" / "a.npz").unlink()
    assert statuses(capsys, scans, out)[1]["bedroom/a.off"] == "done"
    assert statuses(capsys, scans, out, "--set", "seed=1")[1]["bedroom/a.off"] == "done"
    assert statuses(capsys, scans, out, "--set", "seed=1", "--anew")[1]["bedroom/a.off"] == "done"


def test_ctrl_c_leaves_whole_files_and_the_next_run_goes_on(capsys, scans, tmp_path, monkeypatch):
    out, real = tmp_path / "out", job_module._write

    def stopped(segmentation, job, *rest):
        written = real(segmentation, job, *rest)
        if "kitchen" in job.scan:
            raise KeyboardInterrupt  # after its files, before its mark
        return written

    monkeypatch.setattr(job_module, "_write", stopped)
    (scans / "broken.off").unlink()
    code, found = rows(capsys, "segment", scans, "--out", out, *FAST)
    assert code == 130
    assert [row["scan"] for row in found] == ["bedroom/a.off"]
    left = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    one = {f"bedroom/a.off/{name}" for name in ("a.npz", "picture.jpg", "row.json")}
    assert left == one | {"kitchen/a.off/a.npz", "kitchen/a.off/picture.jpg"}
    monkeypatch.undo()
    assert statuses(capsys, scans, out) == (0, {"bedroom/a.off": "reused", "kitchen/a.off": "done"})


@pytest.mark.skipif(sys.platform == "win32", reason="has no such signal")
def test_a_real_ctrl_c_in_the_middle_of_a_scan(scans, tmp_path):
    write(corner(240), scans / "large.off")  # 230 400 faces take some seconds
    (scans / "broken.off").unlink()
    code = "import sys; from scenewidget.command_line import main; sys.exit(main(sys.argv[1:]))"
    # what is started in the background of a shell inherits that SIGINT is ignored
    code = f"import signal; signal.signal(signal.SIGINT, signal.default_int_handler); {code}"
    words = ["segment", str(scans), "--out", str(tmp_path / "out"), "--verbose"]
    run = subprocess.Popen([sys.executable, "-c", code, *words], stderr=subprocess.PIPE, text=True)
    for line in run.stderr:
        if "[2/3]" in line:
            break
    run.stderr.readline()  # it has begun the third
    run.send_signal(signal.SIGINT)
    assert "stopped after 2 of 3 scans" in run.stderr.read()
    assert run.wait() == 130
    left = sorted(path.name for path in (tmp_path / "out").rglob("*") if path.is_file())
    assert left == [name for name in ("a.npz", "picture.jpg", "row.json") for _ in "ab"]


def test_sigterm_is_as_good_as_ctrl_c(capsys, scans, tmp_path, monkeypatch):
    def end(*_, **__):
        signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr("scenewidget.batch.job.segment", end)
    before = signal.getsignal(signal.SIGTERM)
    assert main(["segment", str(scans), "--out", str(tmp_path / "out")]) == 143
    assert "the same command goes on from there" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGTERM) is before
    assert not list(tmp_path.glob("out/**/*.lock"))


def test_a_project_that_was_corrected_stays(capsys, scans, tmp_path):
    scan, project = scans / "kitchen" / "a.off", tmp_path / "out" / "a.off" / "a.swproj"
    assert statuses(capsys, scan, tmp_path / "out", "--format", "swproj") == (0, {"a.off": "done"})
    with sw.Session.open(project, scan) as session:
        session.relabel(0, "floor")
    assert statuses(capsys, scan, tmp_path / "out", "--format", "swproj") == (0, {"a.off": "reused"})
    code, found = rows(
        capsys, "segment", scan, "--out", tmp_path / "out", *FAST, "--set", "seed=1", "--format", "swproj"
    )
    assert (code, found[0]["status"]) == (1, "failed")
    with sw.Session.open(project, scan) as session:
        assert "floor" in session.segmentation.names


def test_all_formats_stand_beside_each_other(capsys, scans, tmp_path):
    formats = [word for name in FORMATS if name != "parquet" for word in ("--format", name)]
    scan, out = scans / "kitchen" / "a.off", tmp_path / "out"
    for seed in "01":
        assert statuses(capsys, scan, out, *formats, "--set", f"seed={seed}") == (0, {"a.off": "done"})
    wanted = {f"a{s}" for name, every in FORMATS.items() if name != "parquet" for s in every}
    assert {path.name for path in (out / "a.off").iterdir()} == {*wanted, "picture.jpg", "row.json"}


def test_a_scan_that_changes_meanwhile_is_not_called_done(capsys, scans, tmp_path, monkeypatch):
    scan, real = scans / "kitchen" / "a.off", job_module._segmented

    def changed(path, *rest):
        found = real(path, *rest)
        write(corner(3), path)
        return found

    monkeypatch.setattr(job_module, "_segmented", changed)
    code, found = rows(capsys, "segment", scan, "--out", tmp_path / "out", *FAST)
    assert (code, found[0]["status"]) == (1, "failed")
    assert "changed while" in found[0]["error"]
    assert [path.name for path in (tmp_path / "out" / "a.off").iterdir()] == ["failed.json"]


def test_progress_goes_to_stderr_and_the_table_to_stdout(capsys, scans, tmp_path):
    main(["segment", str(scans), "--out", str(tmp_path / "out"), *FAST])
    said = capsys.readouterr()
    assert "[1/3] bedroom/a.off  done" in said.err
    assert "[2/3] broken.off  failed: " in said.err
    assert "[" not in said.out
    table, _, wrong = said.out.partition("\n\n")
    assert {line.split()[1] for line in table.splitlines()[1:]} == {"done", "failed"}
    assert " 100 " in table  # faces, a whole number
    assert " GB" in table
    assert wrong.startswith("broken.off: ")
    assert "3 scans: 2 done, 1 failed; in " in said.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--workers", "-1"], "--workers must be a whole number"),
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "with --scheduler leave it out"),
        (["--set", "n_segment=3"], "did you mean 'n_segments'"),
        (["--set", "n_segments"], "--set takes name=value, such as n_segments=30, got 'n_segments'"),
        (["--set", "n_segments=0"], "n_segments must lie in"),
    ],
)
def test_bad_words_are_explained_and_nothing_is_written(capsys, scans, tmp_path, words, message):
    assert main(["segment", str(scans), "--out", str(tmp_path / "out"), *words]) == 1
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_no_scans_is_said_at_once(capsys, tmp_path):
    assert main(["segment", str(tmp_path), "--out", str(tmp_path / "out")]) == 1
    assert "no scans in" in capsys.readouterr().err
    assert main(["segment", str(tmp_path / "none"), "--out", str(tmp_path / "out")]) == 1
    assert "does not exist" in capsys.readouterr().err


def test_two_runs_into_one_folder_are_refused(capsys, scans, tmp_path):
    from scenewidget.editing.files import FileLock

    (tmp_path / "out").mkdir()
    lock = FileLock(tmp_path / "out" / "scenewidget")
    lock.acquire()
    assert main(["segment", str(scans), "--out", str(tmp_path / "out"), *FAST]) == 1
    lock.release()
    assert "is being written by another kernel or script" in capsys.readouterr().err


def test_results_inside_the_folder_of_scans_are_no_scans(capsys, scans):
    (scans / "broken.off").unlink()
    for status in ("done", "reused"):
        code, found = statuses(capsys, scans, scans / "out", "--format", "ply")
        assert (code, found) == (0, {"bedroom/a.off": status, "kitchen/a.off": status})


def test_a_row_that_somebody_else_wrote_stays(capsys, scans, tmp_path):
    note = tmp_path / "out" / "a.off" / "row.json"
    note.parent.mkdir(parents=True)
    note.write_text("mine")
    assert statuses(capsys, scans / "kitchen" / "a.off", tmp_path / "out") == (1, {"a.off": "failed"})
    assert note.read_text() == "mine"


@pytest.fixture
def truth(scans, tmp_path):
    """The two sides of each corner."""
    for room in ("kitchen", "bedroom"):
        mesh = sw.load(scans / room / "a.off")
        (tmp_path / "truth" / room).mkdir(parents=True)
        sides = sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // (mesh.n_faces // 2))
        sw.export(sides, mesh, tmp_path / "truth" / room / "a.npz")
    return tmp_path / "truth"


def test_evaluate_a_run_and_a_folder_of_files(capsys, scans, truth, tmp_path):
    statuses(capsys, scans, tmp_path / "out")
    code, found = rows(capsys, "evaluate", tmp_path / "out", "--truth", truth)
    assert code == 0
    assert [row["scan"] for row in found] == ["bedroom/a", "kitchen/a"]
    mesh = sw.load(scans / "bedroom" / "a.off")
    sides = [
        sw.import_labels(mesh, f)
        for f in (tmp_path / "out" / "bedroom" / "a.off" / "a.npz", truth / "bedroom" / "a.npz")
    ]
    expected = sw.evaluate({"ours": sides[0]}, sides[1], mesh).loc["ours"]
    assert {name: found[0][name] for name in expected.index} == pytest.approx(expected.to_dict())
    code, found = rows(capsys, "evaluate", truth, "--truth", truth, "--scans", scans)
    assert code == 0
    assert [row["rand_index_error"] for row in found] == [0, 0]
    code, found = rows(
        capsys, "evaluate", truth / "bedroom" / "a.npz", "--truth", truth / "bedroom" / "a.npz",
        "--scans", scans / "bedroom" / "a.off", "--metrics", "mean_iou",
    )  # fmt: skip
    assert (code, found[0]["mean_iou"]) == (0, 1)
    (truth / "kitchen" / "a.npz").unlink()
    code, found = rows(capsys, "evaluate", tmp_path / "out", "--truth", truth)
    assert code == 1
    assert "has no labels of it" in found[1]["error"]


def test_evaluate_says_what_is_missing(capsys, scans, truth, tmp_path):
    assert main(["evaluate", str(tmp_path / "none"), "--truth", str(truth)]) == 1
    assert "does not exist" in capsys.readouterr().err
    assert main(["evaluate", str(truth / "kitchen"), "--truth", str(truth)]) == 1
    assert "no scan has labels in both" in capsys.readouterr().err
    assert main(["evaluate", str(truth), "--truth", str(truth)]) == 1
    assert "--scans" in capsys.readouterr().out


def test_agree_has_a_row_a_scan(capsys, scans, truth, tmp_path):
    statuses(capsys, scans, tmp_path / "out", "--format", "swproj")
    code, found = rows(capsys, "agree", tmp_path / "out", truth)
    assert code == 0
    assert [(row["scan"], row["first"], row["second"]) for row in found] == [
        ("bedroom/a", "out", "truth"),
        ("kitchen/a", "out", "truth"),
    ]
    assert found[0]["coverage"] == 1
    assert main(["agree", str(truth)]) == 1
    assert "two or more folders" in capsys.readouterr().err


def test_agree_on_copies_in_one_folder_by_segment_and_by_name(capsys, scans, tmp_path):
    out = tmp_path / "out"
    statuses(capsys, scans / "kitchen", out)
    assert main(["agree", str(out)]) == 1
    assert "got only" in capsys.readouterr().err
    for person, name in (("ann", "floor"), ("bob", "rug")):
        work = Worklist(out, person, own=True)
        with work.open("a.off", sw.load(scans / "kitchen" / "a.off")) as session:
            session.relabel(0, name)
    code, found = rows(capsys, "agree", out)
    assert (code, found[0]["first"], found[0]["second"], found[0]["same_name"]) == (0, "ann", "bob", 0)
    code, found = rows(capsys, "agree", out, "--per", "name")
    assert [(row["name"], row["iou"]) for row in found] == [("floor", 0), ("rug", 0)]
    code, found = rows(capsys, "agree", out, "--per", "segment")
    assert {row["iou"] for row in found} == {1}
    code, found = rows(capsys, "evaluate", out, "--truth", out, "--person", "bob")
    assert (code, found[0]["mean_iou"]) == (0, 1)
    assert main(["evaluate", str(out), "--truth", str(out), "--person", "cyd"]) == 1
    assert "'cyd' has no copies of their own in" in capsys.readouterr().err
    code, found = rows(capsys, "evaluate", out, "--truth", out)  # a project made since counts
    assert found[0]["mean_iou"] == 1


@pytest.mark.parametrize("kind", [kind for kind in MESHES if kind != "gltf"])
def test_convert_a_scan_keeps_its_faces(tmp_path, kind):
    plain = corner(3)
    source = write(plain, tmp_path / "a.off")
    assert main(["convert", str(source), str(tmp_path / f"b.{kind}")]) == 0
    found = sw.load(tmp_path / f"b.{kind}")
    places = found.vertices[found.faces]
    np.testing.assert_allclose(places, plain.vertices[plain.faces], atol=1e-6)


def test_convert_carries_colors(tmp_path):
    lines = ["v 0 0 0 1 0 0", "v 1 0 0 0 1 0", "v 0 1 0 0 0 1", "f 1 2 3"]
    (tmp_path / "a.obj").write_text("\n".join(lines) + "\n")
    for kind in ("ply", "glb"):
        assert main(["convert", str(tmp_path / "a.obj"), str(tmp_path / f"b.{kind}"), "--quiet"]) == 0
        assert sw.load(tmp_path / f"b.{kind}").vertex_colors.tolist() == (255 * np.eye(3, dtype=int)).tolist()


def test_convert_a_cloud(capsys, tmp_path):
    points = np.random.default_rng(0).uniform(size=(50, 3)).round(3)
    np.savetxt(tmp_path / "a.xyz", points)
    assert main(["convert", str(tmp_path / "a.xyz"), str(tmp_path / "b.ply"), "--quiet"]) == 0
    np.testing.assert_allclose(sw.load_cloud(tmp_path / "b.ply").vertices, points, atol=1e-6)
    assert main(["convert", str(tmp_path / "a.xyz"), str(tmp_path / "b.stl")]) == 1
    assert "is a point cloud" in capsys.readouterr().err


def test_convert_labels(capsys, scans, truth, tmp_path):
    scan, target = scans / "kitchen" / "a.off", tmp_path / "a.txt"
    words = ["convert", truth / "kitchen" / "a.npz", target, "--mesh", scan]
    assert main([*map(str, words), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [str(target)]
    assert target.read_text().split() == ["0"] * 32 + ["1"] * 32


def test_convert_replaces_nothing_of_others(capsys, scans, tmp_path):
    (tmp_path / "a.ply").write_text("mine")
    words = ["convert", str(scans / "kitchen" / "a.off"), str(tmp_path / "a.ply")]
    assert main(words) == 1
    said = capsys.readouterr().err
    assert "no export wrote it" in said
    assert said.endswith("replace it with --overwrite\n")
    assert main([*words, "--overwrite"]) == 0
    assert main(["convert", str(scans / "kitchen" / "a.off"), str(tmp_path / "a.npz")]) == 1
    assert "a scan can be written as .ply" in capsys.readouterr().err
    (tmp_path / "b.npz").touch()
    assert main(["convert", str(tmp_path / "b.npz"), str(tmp_path / "b.csv")]) == 1
    assert "'b.npz' holds labels; give the scan" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["segment", "evaluate", "agree", "convert", "tables"])
def test_help_teaches(capsys, command):
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert command in text
    assert command == "tables" or f"scenewidget {command} " in text.partition("\n\n")[2]


def test_unknown_words_are_code_2(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["segmnt"])
    assert ended.value.code == 2


def test_it_is_a_command_and_stays_quiet_when_nobody_reads(capsys, tmp_path):
    assert main([]) == 2
    assert capsys.readouterr().err.startswith("usage: scenewidget ")
    source = write(corner(3), tmp_path / "a.off")
    read, written = os.pipe()
    os.close(read)
    words = [sys.executable, "-m", "scenewidget", "convert", str(source), str(tmp_path / "a.ply")]
    done = subprocess.run(words, stdout=written, stderr=subprocess.PIPE, check=False)
    os.close(written)
    assert (done.returncode, done.stderr) == (141, b"")
