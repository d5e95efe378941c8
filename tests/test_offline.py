"""The whole job runs without a network: nothing is fetched, nothing is sent."""

from __future__ import annotations

import subprocess
import sys

JOB = """
import socket, sys

asked = []
def refuse(*args, **kwargs):
    asked.append(args)
    raise OSError("this machine has no network")
socket.socket.connect = socket.socket.connect_ex = refuse
socket.getaddrinfo = socket.gethostbyname = socket.create_connection = refuse

import warnings
import scenewidget as sw

mesh, truth = sw.datasets.simulate_room(seed=0, n_objects=2, voxel=0.08)
folder = sys.argv[1]
sw.export(truth, mesh, folder + "/scan.ply")
mesh = sw.load_mesh(folder + "/scan.ply")
widget = sw.SceneWidget(mesh, sw.Params(n_runs=3, n_graph_runs=3), autosave=False)
widget.wait(timeout=300)
session = widget.session
session.merge(0, mesh.n_faces - 1)
session.relabel(0, "floor")
widget.save(folder + "/room.swproj")
widget.to_html(folder + "/room.html")
widget.close()
again = sw.Session.open(folder + "/room.swproj")
sw.export(again.segmentation, mesh, folder + "/room.glb")
sw.evaluate({"ours": again.segmentation}, truth, mesh)
print("asked for the network:", asked)
"""


def test_the_main_job_runs_with_the_network_cut_off(tmp_path):
    command = [sys.executable, "-c", JOB, str(tmp_path)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=400, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "asked for the network: []"
    assert {path.suffix for path in tmp_path.iterdir()} >= {".ply", ".swproj", ".html", ".glb"}
