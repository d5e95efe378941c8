"""No export replaces what no export wrote; what it writes, it writes whole, all files or none."""

import errno
import os
import shutil

import numpy as np
import pytest
import shapes
from test_store import run
from windows import SharingError

import scenewidget as sw
from scenewidget.editing import files
from scenewidget.editing.formats import FormatError, seal

EVERY = ("a.ply", "a.npz", "a.glb", "a.aggregation.json", "a.xml", "a.csv", "a.npy", "a.txt")


@pytest.fixture
def room(tmp_path):
    """A scan on the disk, loaded from there, and a segmentation of it."""
    box = shapes.box(3)
    sw.export(sw.Segmentation.from_labels(box, np.zeros(box.n_faces, int)), box, tmp_path / "scan.ply")
    mesh = sw.load_mesh(tmp_path / "scan.ply")
    return mesh, sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // 18)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("name", EVERY)
def test_what_an_export_wrote_is_replaced(room, tmp_path, name, monkeypatch):
    mesh, seg = room
    first = sw.export(seg, mesh, tmp_path / name)
    other = sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // 9)
    assert sw.export(other, mesh, tmp_path / name) == first
    if name != "a.csv":
        assert sw.import_labels(mesh, tmp_path / name).n_segments == other.n_segments
    monkeypatch.setattr(seal, "_written", {})  # as in another process
    if hasattr(os, "setxattr"):
        sw.export(seg, mesh, tmp_path / name)


@pytest.mark.parametrize("name", EVERY)
def test_what_no_export_wrote_is_not_replaced(room, tmp_path, name):
    mesh, seg = room
    paths = sw.export(seg, mesh, tmp_path / name)
    for theirs in paths:
        for path in paths:
            path.unlink(missing_ok=True)
        theirs.write_bytes(b"by hand")
        before = contents(tmp_path)
        with pytest.raises(
            FileExistsError, match=f"{theirs.name}.*no export wrote it; choose .*overwrite=True"
        ):
            sw.export(seg, mesh, tmp_path / name)
        assert contents(tmp_path) == before
    sw.export(seg, mesh, tmp_path / name, overwrite=True)
    assert b"by hand" not in contents(tmp_path).values()


@pytest.mark.parametrize("name", EVERY)
def test_what_somebody_has_changed_since_is_not_replaced(room, tmp_path, name):
    mesh, seg = room
    for path in sw.export(seg, mesh, tmp_path / name):
        data = path.read_bytes()
        k = len(data) * 2 // 3
        path.write_bytes(data[:k] + bytes([data[k] ^ 1]) + data[k + 1 :])
        with pytest.raises(FileExistsError, match="no export wrote it"):
            sw.export(seg, mesh, tmp_path / name)
        path.write_bytes(data)


def test_the_scan_is_never_replaced_by_the_way(room, tmp_path):
    mesh, seg = room
    shutil.copy(tmp_path / "scan.ply", tmp_path / "keep")
    (tmp_path / "link.ply").symlink_to(tmp_path / "scan.ply")
    (tmp_path / "hard.ply").hardlink_to(tmp_path / "scan.ply")
    for name, options in (
        ("scan.ply", {}),
        ("scan.xml", {}),
        ("link.ply", {}),
        ("hard.xml", {}),
        ("link.xml", {}),
        ("scan.ply", {"format": "npz"}),
    ):
        with pytest.raises(FileExistsError, match="is the scan itself; choose another name, or replace it"):
            sw.export(seg, mesh, tmp_path / name, **options)
    assert not (tmp_path / "scan.xml").exists()
    assert (tmp_path / "scan.ply").read_bytes() == (tmp_path / "keep").read_bytes()
    with pytest.raises(
        FileExistsError, match=r"scan.ply' .written along with 'scan.xml'. is the scan itself"
    ):
        sw.export(seg, mesh, tmp_path / "scan.xml")


def test_another_process_knows_what_an_export_wrote(tmp_path):
    code = """
        import sys, numpy as np, shapes, scenewidget as sw
        mesh = shapes.box(3)
        seg = sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // int(sys.argv[2]))
        for name in ("a.ply", "a.npz", "a.glb", "a.aggregation.json", "b.xml"):
            sw.export(seg, mesh, sys.argv[1] + "/" + name)
    """
    run(code, tmp_path, 18)
    run(code, tmp_path, 9)


@pytest.mark.parametrize("name", ["a.aggregation.json", "a.xml"])
@pytest.mark.parametrize("exists", [False, True])
def test_both_files_of_an_export_are_written_or_none(room, tmp_path, monkeypatch, name, exists):
    mesh, seg = room
    if exists:
        sw.export(seg, mesh, tmp_path / name)
    before = contents(tmp_path)
    other = sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // 9)
    replace = files.Path.replace
    for failing in ("fsync", "replace 1", "replace 2"):
        calls = []

        def refuse(*arguments, failing=failing, calls=calls):
            calls.append(1)
            if failing == f"replace {len(calls)}" or failing == "fsync":
                raise OSError(errno.ENOSPC, "no space left on device")
            return replace(*arguments)

        with monkeypatch.context() as patch:
            patch.setattr(files.os, "fsync", refuse) if failing == "fsync" else patch.setattr(
                files.Path, "replace", refuse
            )
            with pytest.raises(OSError, match="the disk is full"):
                sw.export(other, mesh, tmp_path / name)
        assert contents(tmp_path) == before


@pytest.mark.parametrize("name", ["a.aggregation.json", "a.xml"])
def test_halves_of_two_exports_are_not_taken_for_one(room, tmp_path, name):
    mesh, seg = room
    other = sw.Segmentation.from_labels(mesh, np.arange(mesh.n_faces) // 9)
    first = [path.read_bytes() for path in sw.export(seg, mesh, tmp_path / name)]
    paths = sw.export(other, mesh, tmp_path / name)
    paths[0].write_bytes(first[0])  # killed in between, long ago
    with pytest.raises(FormatError, match="are of different exports, one of which was interrupted"):
        sw.import_labels(mesh, tmp_path / name)


def test_exporting_through_a_link_writes_where_it_leads(room, tmp_path):
    mesh, seg = room
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "a.npz").symlink_to(inner / "b.npz")
    sw.export(seg, mesh, tmp_path / "a.npz")
    assert (tmp_path / "a.npz").is_symlink()
    assert (inner / "b.npz").is_file()


def test_what_another_program_holds_on_windows_stays_and_is_explained(tmp_path, monkeypatch):
    path = tmp_path / "room.ply"
    path.write_text("old")

    def replace(self, target):
        raise SharingError(13, "Permission denied")

    monkeypatch.setattr(type(path), "replace", replace)
    with (
        pytest.raises(PermissionError, match=r"another program has it open; close it there .* untouched"),
        files.replacing(path) as temporary,
    ):
        temporary.write_text("new")
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("room.ply", "old")]


def test_what_another_program_holds_for_a_moment_is_waited_for(tmp_path, monkeypatch):
    path = tmp_path / "room.ply"
    path.write_text("old")
    tries = []
    take = type(path).replace

    def replace(self, target):
        tries.append(target)
        if len(tries) < 3:  # as an index or a scanner of viruses does with new files
            raise SharingError(13, "Permission denied")
        return take(self, target)

    monkeypatch.setattr(type(path), "replace", replace)
    with files.replacing(path) as temporary:
        temporary.write_text("new")
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("room.ply", "new")]


@pytest.mark.parametrize(
    "name",
    ["nul.npz", "CON", "Aux.tar.gz", "com1.ply", "lpt\u00b2.glb", "room.", "room ", "a:b.ply", "who?.ply"],
)
def test_names_that_windows_gives_to_devices_are_refused_there(tmp_path, monkeypatch, name):
    monkeypatch.setattr(files, "ON_WINDOWS", True)
    with (
        pytest.raises(OSError, match="Windows has no files of that name; choose another"),
        files.replacing(tmp_path / name) as temporary,
    ):
        temporary.write_text("lost")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "name", ["null.npz", "console.ply", "com.ply", "com10.ply", "a.nul", "r\u00e4ume 2.ply"]
)
def test_names_that_only_look_like_devices_are_files(tmp_path, monkeypatch, name):
    monkeypatch.setattr(files, "ON_WINDOWS", True)
    with files.replacing(tmp_path / name) as temporary:
        temporary.write_text("kept")
    assert (tmp_path / name).read_text() == "kept"


def test_a_disk_that_is_blind_to_case_shows_by_another_spelling(tmp_path, monkeypatch):
    (tmp_path / "12").touch()
    assert not files.is_blind_to_case(tmp_path)
    (tmp_path / "scenewidget.lock").touch()
    exists = type(tmp_path).exists
    tells = not (tmp_path / "SCENEWIDGET.LOCK").exists()  # not on macOS
    assert files.is_blind_to_case(tmp_path) != tells
    monkeypatch.setattr(type(tmp_path), "exists", lambda self: exists(self.with_name(self.name.lower())))
    assert files.is_blind_to_case(tmp_path)
