"""The log of a session in memory and on disk, and the mesh that a project is of."""

import gc
import weakref

import numpy as np
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
