"""A whole dataset by one call, in this process: what is refused, what stands in the table, what stays."""

import json
import math
import os
import socket
import threading

import numpy as np
import pytest
import shapes

import scenewidget as sw
from scenewidget.batch import clients, pools
from scenewidget.batch.folders import labeled, mesh_of
from scenewidget.batch.runs import planned
from scenewidget.batch.worklist import Worklist

FAST = sw.Params(n_segments=2, n_runs=2, n_graph_runs=2)


@pytest.fixture
def scans(tmp_path):
    """A square twice, in folders of their own."""
    folder = tmp_path / "scans"
    for room in ("bath", "kitchen"):
        (folder / room).mkdir(parents=True)
        mesh = shapes.sheet(4, 4, width=2.0, depth=2.0)
        sw.export(sw.Segmentation.from_labels(mesh, np.arange(32) // 16), mesh, folder / room / "a.ply")
    return folder


def run(scans, out, **options):
    return sw.segment_all(scans, out, FAST, n_workers=0, progress=False, **options)


def test_a_row_a_scan_with_errors_where_there_is_a_truth(scans, tmp_path):
    truth = tmp_path / "truth" / "kitchen"
    truth.mkdir(parents=True)
    mesh = sw.load(scans / "kitchen" / "a.ply")
    sw.export(sw.Segmentation.from_labels(mesh, np.zeros(32, int)), mesh, truth / "a.npz")
    first = run(scans, tmp_path / "out")
    assert repr(first) == "Run(2 scans: 2 done)"
    table = run(scans, tmp_path / "out", truth=tmp_path / "truth").to_frame().set_index("scan")
    assert table.status.tolist() == ["reused", "reused"]  # judged without being segmented again
    assert table.faces.tolist() == [32, 32]
    assert (table.peak_memory > 1e7).all()
    assert np.isnan(table.rand_index_error["bath/a.ply"])
    labels = sw.import_labels(mesh, tmp_path / "out" / "kitchen" / "a.ply" / "a.npz")
    expected = sw.evaluate({"": labels}, np.zeros(32, int), mesh).loc["", "rand_index_error"]
    assert table.rand_index_error["kitchen/a.ply"] == expected
    assert (tmp_path / "out" / "kitchen" / "a.ply" / "picture.jpg").read_bytes()[6:10] == b"JFIF"


def test_what_failed_has_a_note_that_goes_once_it_is_mended(scans, tmp_path):
    whole = (scans / "bath" / "a.ply").read_bytes()
    (scans / "bath" / "a.ply").write_bytes(whole[:200])
    table = run(scans, tmp_path / "out").to_frame()
    assert table.status.tolist() == ["failed", "done"]
    assert "a.ply" in table.error[0]
    note = tmp_path / "out" / "bath" / "a.ply" / "failed.json"
    assert json.loads(note.read_text())["status"] == "failed"
    (scans / "bath" / "a.ply").write_bytes(whole)
    assert run(scans, tmp_path / "out").to_frame().status.tolist() == ["done", "reused"]
    assert not note.exists()


def test_urls_in_and_out(tmp_path):
    fsspec = pytest.importorskip("fsspec")
    store = fsspec.filesystem("memory")
    mesh = shapes.sheet(4, 4, width=2.0, depth=2.0)
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in mesh.vertices)
    rows += "".join(f"f {a} {b} {c}\n" for a, b, c in mesh.faces + 1)
    store.pipe_file("/urls/scans/kitchen/a.obj", b"mtllib a.mtl\n" + rows.encode())
    store.pipe_file("/urls/scans/kitchen/a.mtl", b"newmtl plain\n")
    store.pipe_file("/urls/scans/notes.md", b"no scan")
    for status in ("done", "reused"):
        found = run("memory://urls/scans", "memory://urls/out", formats=["npz", "swproj"])
        assert {scan: row["status"] for scan, row in found.rows.items()} == {"kitchen/a.obj": status}
    there = {path.rpartition("/")[2] for path in store.find("/urls/out")}
    assert there == {"a.npz", "a.swproj", "picture.jpg", "row.json"}
    store.pipe_file("/urls/scans/kitchen/a.mtl", b"newmtl other\n")
    store.pipe_file("/urls/out/kitchen/a.obj/a.npz", b"mine")
    found = run("memory://urls/scans/*/*.obj", "memory://urls/out")
    assert (
        "no run of ours wrote it" in found.rows["a.obj"]["error"] or found.rows["a.obj"]["status"] == "done"
    )
    assert store.cat_file("/urls/out/kitchen/a.obj/a.npz") == b"mine"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"formats": ("xyz",)}, "formats may hold 'npz', .* got 'xyz'"),
        ({"formats": ()}, "formats is empty"),
        ({"truth": {"bath/b.ply": "b.npz"}}, "'bath/b.ply', which is no scan"),
        ({"units": "miles"}, "units must be one of"),
        ({"scans": "no/such"}, "does not exist; give files, folders or a pattern"),
        ({"scans": []}, "scans is empty"),
        ({"scans": ""}, "scans is empty"),
        ({"out": ""}, "out is empty"),
        ({"truth": {"bath/a": "gone.npz"}}, "'gone.npz' does not exist"),
        ({"scans": "nowhere://a"}, "can't be opened"),
    ],
)
def test_bad_input_is_refused_at_once(scans, tmp_path, options, message):
    with pytest.raises(ValueError, match=message):
        planned(**{"scans": scans, "out": tmp_path / "out", **options})
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_read_is_named(scans, tmp_path, monkeypatch):
    def walk(folder, onerror, followlinks):
        onerror(PermissionError(13, "Permission denied", f"{folder}/bath"))

    monkeypatch.setattr("os.walk", walk)
    with pytest.raises(PermissionError, match="bath' can't be read: Permission denied"):
        planned(scans, tmp_path / "out")


def test_wrong_kinds_are_type_errors(scans, tmp_path):
    for options, message in (
        ({"params": {}}, "params must be a Params"),
        ({"scans": 3}, "scans must be a folder"),
        ({"out": 3}, "out must be a folder"),
        ({"truth": 3}, "truth must be a folder"),
        ({"truth": {"bath/a": 3}}, "truth must map scans to files of labels, got int"),
        ({"scans": [scans, 3]}, "scans must be a folder.* got one with int"),
        ({"scans": {"a": scans}}, "scans must be a folder.* got dict"),
        ({"formats": [["npz"]]}, "formats must be a list of names"),
        ({"formats": 3}, "formats must be a list of names, .* got 3"),
        ({"resume": "no"}, "resume must be True or False"),
    ):
        with pytest.raises(TypeError, match=message):
            planned(**{"scans": scans, "out": tmp_path / "out", **options})
    with pytest.raises(TypeError, match="progress must be"):
        sw.segment_all(scans, tmp_path / "out", n_workers=0, progress=3)


def test_names_do_not_lead_out_of_the_folder_of_results(scans, tmp_path):
    odd = [scans / "bath" / "a.ply", f"{scans}/bath/../kitchen/a.ply", f"{scans}/kitchen/../bath/a.ply"]
    assert planned(odd, tmp_path / "out").scans == ("bath/a.ply", "kitchen/a.ply")
    (tmp_path / "link").symlink_to(scans)
    with pytest.raises(ValueError, match="all scans lie in out"):
        planned(scans, tmp_path / "link")


def test_one_file_of_truth_is_of_its_namesake_or_of_the_only_scan(scans, tmp_path):
    np.save(tmp_path / "true.npy", np.arange(32) // 16)
    found = run(scans / "bath", tmp_path / "out", truth=tmp_path / "true.npy")
    assert found.rows["a.ply"]["n_truth"] == 2
    with pytest.raises(ValueError, match=r"it has 'true', and scans are 'bath/a.ply', 'kitchen/a.ply'"):
        planned(scans, tmp_path / "out", truth=tmp_path / "true.npy")


def test_what_others_have_put_there_is_told_apart_and_stays(scans, tmp_path):
    out = tmp_path / "out"
    out.symlink_to("gone")
    with pytest.raises(NotADirectoryError, match="is a link to nowhere"):
        run(scans, out)
    out.unlink()
    run(scans, out)
    row = out / "bath" / "a.ply" / "row.json"
    row.write_text(row.read_text().replace('"seconds": ', '"seconds": "x", "then": '))
    (out / "kitchen" / "a.ply").rename(tmp_path / "elsewhere")
    (out / "kitchen" / "a.ply").touch()
    errors = run(scans, out).to_frame().error
    assert "no run of ours wrote it" in errors[0]
    assert "a file is where the folder of its results should be" in errors[1]


def test_the_unit_of_a_scan_is_known_to_who_opens_it_later(tmp_path):
    mesh = shapes.sheet(4, 4, width=2000.0, depth=2000.0)
    sw.save_mesh(mesh, tmp_path / "a.ply")
    run(tmp_path / "a.ply", tmp_path / "out", units="mm", formats=["npz", "swproj"])
    work = Worklist(tmp_path / "out", "ann")
    mesh = work.mesh(work.entries["a.ply"])
    assert mesh.bounds[1].max() == 2
    work.open("a.ply", mesh).close()
    assert mesh_of("a", tmp_path, labeled(tmp_path / "out").values()).bounds[1].max() == 2


def test_urls_of_single_files_and_patterns_need_no_listing(tmp_path):
    store = pytest.importorskip("fsspec").filesystem("memory")
    sw.save_mesh(shapes.sheet(4, 4, width=2.0, depth=2.0), tmp_path / "a.off")
    for room in ("bath", "kitchen"):
        store.pipe_file(f"/single/{room}/a.off", (tmp_path / "a.off").read_bytes())
    urls = ["memory://single/bath/a.off", "memory://single/bath/gone.off"]
    rows = run(urls, tmp_path / "out").rows
    assert rows["a.off"]["status"] == "done"
    assert rows["gone.off"]["error"].startswith("nothing there: 'memory://")
    assert planned("memory://single/*/a.off", tmp_path / "out").scans == ("bath/a.off", "kitchen/a.off")


def test_too_little_memory_says_how_much_it_takes(scans, tmp_path, monkeypatch):
    def full(*_, **__):
        raise MemoryError

    monkeypatch.setattr("scenewidget.batch.job.segment", full)
    row = run(scans, tmp_path / "out").rows["bath/a.ply"]
    assert (row["status"], row["faces"]) == ("too large", 32)


def test_a_scheduler_that_does_not_answer(scans, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(clients, "ANSWER", 0.5)
    with pytest.raises(ConnectionError, match=r"no Dask scheduler answers at 'tcp://127\.0"):
        sw.segment_all(scans, tmp_path / "out", client="tcp://127.0.0.1:9", progress=False)
    with pytest.raises(TypeError, match="client must be a dask"):
        sw.segment_all(scans, tmp_path / "out", client=3, progress=False)
    with socket.create_server(("127.0.0.1", 0)) as silent:  # something listens there, and says nothing
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(ConnectionError, match=r"no Dask scheduler answers .* nothing in 0 s"):
            sw.segment_all(scans, tmp_path / "out", client=address, progress=False)


@pytest.mark.skipif(os.name != "posix", reason="needs pipes, links and names of any bytes")
def test_files_that_are_none_have_a_row(scans, tmp_path):
    os.mkfifo(scans / "pipe.ply")
    (scans / "nowhere.ply").symlink_to("gone.ply")
    (scans / "zero.ply").symlink_to("/dev/zero")
    (scans / os.fsdecode(b"k\xfcche.ply")).write_bytes((scans / "bath" / "a.ply").read_bytes())
    rows = run(scans, tmp_path / "out").to_frame().set_index("scan")
    assert "pipe or device" in rows.error["pipe.ply"]
    assert "pipe or device" in rows.error["zero.ply"]
    assert rows.error["nowhere.ply"].startswith("No such file")
    assert rows.status[r"k\xfcche.ply"] == "done"
    assert run(scans, tmp_path / "out").rows[r"k\xfcche.ply"]["status"] == "reused"


def test_without_dask_it_says_how_to_get_it(scans, tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r'pip install "scenewidget\[batch\]"'):
        sw.segment_all(scans, tmp_path / "out", progress=False)


def test_in_the_background_it_can_be_cancelled(scans, tmp_path, monkeypatch):
    begun, go_on = threading.Event(), threading.Event()

    def slow(job, tell):
        begun.set()
        go_on.wait(30)
        return {"scan": job.scan, "status": "done", "error": "", "segments": 1, "seconds": 1.0}

    monkeypatch.setattr(pools, "run_job", slow)
    behind = run(scans, tmp_path / "out", wait=False)
    assert begun.wait(30)
    behind.cancel()
    go_on.set()
    assert repr(behind.wait(30)) == "Run(2 scans: 1 done, 1 left)"
    assert not behind.is_running


def test_two_scans_do_not_share_a_folder_where_case_makes_no_difference(scans, tmp_path, monkeypatch):
    (scans / "bath" / "B.ply").write_bytes((scans / "bath" / "a.ply").read_bytes())
    (scans / "bath" / "b.ply").write_bytes((scans / "bath" / "a.ply").read_bytes())
    monkeypatch.setattr("scenewidget.batch.runs.is_blind_to_case", lambda folder: True)
    with pytest.raises(ValueError, match=r"would share a folder in .*, whose disk doesn't tell capital"):
        run(scans, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_client_of_somebody_elses_and_its_address(scans, tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        (scans / "bath" / "a.ply").write_bytes(b"ply\nnothing")
        found = sw.segment_all(scans, tmp_path / "out", FAST, client=client, progress=False)
        assert {scan: row["status"] for scan, row in found.rows.items()} == {
            "bath/a.ply": "failed",
            "kitchen/a.ply": "done",
        }
        address = cluster.scheduler_address
        again = sw.segment_all(
            scans / "kitchen", tmp_path / "out/kitchen", FAST, client=address, progress=False
        )
        assert again.rows["a.ply"]["status"] == "reused"
        assert client.status == "running"  # it isn't ours to close
        assert (clients.patience_with(None), clients.patience_with(cluster)) == (30, math.inf)
        cluster.scale(0)
        assert clients.patience_with(cluster) == 5
        monkeypatch.setattr(pools, "NOTICE", 0.1)
        monkeypatch.setattr(pools, "patience_with", lambda cluster: 1.0)
        with (
            pytest.warns(UserWarning, match=r"the scheduler at tcp://.* has no workers; waiting 1 s for one"),
            pytest.raises(
                ConnectionError, match=r"has had no workers for 1 s; start some, as by 'dask worker"
            ),
        ):
            sw.segment_all(scans, tmp_path / "none", FAST, client=client, progress=False)
    with pytest.raises(ConnectionError, match="client is closed; give one that is open"):
        sw.segment_all(scans, tmp_path / "out", FAST, client=client, progress=False)


@pytest.mark.parametrize("address", ["10.0.0.5", "tcp://", "tcp://a:b", "nowhere://a:1"])
def test_what_is_no_address_is_told_at_once(scans, tmp_path, address):
    pytest.importorskip("distributed")
    with pytest.raises(ValueError, match=r"client must be the address of a scheduler, such as 'tcp://10\.0"):
        planned(scans, tmp_path / "out", client=address)
