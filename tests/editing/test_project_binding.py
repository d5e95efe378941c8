"""The log of a session in memory and on disk, and the mesh that a project is of."""

import gc
import socket
import weakref

import numpy as np
import pandas as pd
import pytest
import shapes
from editing_strategies import box_session

import scenewidget as sw
from scenewidget.editing.fingerprint import fingerprint
from scenewidget.editing.project import Project, ProjectError
from scenewidget.editing.project_binding import mesh_of_project
from scenewidget.engine.segmentation import Segmentation


def test_before_there_is_a_file_the_log_is_kept_in_memory(tmp_path):
    session = box_session()
    session.merge(0, 40)
    session.undo()
    assert (session.path, session.is_saved, session.file_problem) == (None, False, "")
    session.save(tmp_path / "room.swproj")
    session.redo()
    assert session.is_saved
    session.close()
    assert (session.path, session.is_saved) == (None, False)
    with sw.Session.open(tmp_path / "room.swproj", session.mesh) as again:
        assert again.to_frame()["action"].tolist() == ["open", "edit", "undo", "redo", "open"]


def test_a_session_that_is_dropped_is_collected_at_once(tmp_path):
    session = box_session()
    session.save(tmp_path / "room.swproj")
    gc.disable()
    try:
        gone = weakref.ref(session)
        del session
        assert gone() is None  # no circle with the file: it is given back without waiting for the collector
    finally:
        gc.enable()


def project(mesh, source="", include_mesh=False):
    automatic = Segmentation.from_labels(mesh, np.zeros(mesh.n_faces, int))
    return Project.of(
        automatic, fingerprint=fingerprint(mesh), mesh=mesh if include_mesh else None, source=source,
        params=None, operations=(),
    )  # fmt: skip


def test_a_mesh_that_is_given_must_be_the_right_one(tmp_path):
    mesh = shapes.box(4)
    found, source = mesh_of_project(project(mesh, "scan.ply"), tmp_path / "a.swproj", mesh)
    assert (found, source) == (mesh, "scan.ply")
    with pytest.raises(ProjectError, match=r"'a\.swproj' belongs to another mesh"):
        mesh_of_project(project(mesh), tmp_path / "a.swproj", shapes.box(2))


def test_a_mesh_in_the_file_or_in_memory_needs_no_search(tmp_path):
    mesh = shapes.box(4)
    assert mesh_of_project(project(mesh, include_mesh=True), tmp_path / "a.swproj")[0] is mesh
    assert mesh_of_project(project(mesh), tmp_path / "a.swproj")[0] is mesh


def test_an_anonymous_copy_tells_of_no_time_place_or_machine(tmp_path):
    folder = tmp_path / "home of somebody"
    folder.mkdir()
    box = shapes.box(4)
    sw.export(Segmentation.from_labels(box, np.arange(192) // 32), box, folder / "scan.ply")
    mesh = sw.load_mesh(folder / "scan.ply")
    session = sw.Session(mesh, sw.import_labels(mesh, folder / "scan.ply"))
    session.merge(0, 40)
    mine = session.save(tmp_path / "mine.swproj")
    copy = session.save(tmp_path / "copy.swproj", anonymous=True, include_mesh=True)
    session.merge(0, 80)
    assert (session.path, session.is_saved) == (mine, True)
    assert [path.name for path in tmp_path.glob("copy*")] == ["copy.swproj"]
    for word in (b"somebody", socket.gethostname().encode(), b"scan.ply"):
        assert word not in copy.read_bytes()
    with sw.Session.open(copy) as again:
        assert len(again.edits) == 1
        assert again.to_frame()["time"].iloc[:-1].eq(pd.Timestamp(0, tz="UTC")).all()
    with pytest.raises(ValueError, match="that this session works on; an anonymous copy needs another path"):
        session.save(mine, anonymous=True)
    with pytest.raises(ValueError, match="an anonymous copy needs a path"):
        session.save(anonymous=True)
    session.close()
