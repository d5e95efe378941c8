"""Kill −9 while a person edits in the picture: what the widget called saved is there and offered."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import shapes

from scenewidget.editing.session import Session

TESTS = Path(__file__).parents[1]
PERSON = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
import shapes
import scenewidget as sw

mesh = shapes.box(6)
n = mesh.n_faces
levels = {"dihedral": np.arange(n, dtype=np.int32) // 2, "base": np.arange(n, dtype=np.int32) // 8}
seg = sw.Segmentation(mesh, np.arange(n, dtype=np.int32) // 32, levels=levels)
sw.Pipeline.run = lambda *_, **__: seg
w = sw.SceneWidget(mesh)
w.wait(60)
if any(notice["key"] == "offer" for notice in w.view.notices):
    w.view._handle_custom_msg({"kind": "choose", "notice": "offer", "action": "restore"}, [])
rng = np.random.default_rng(int(sys.argv[2]))
while True:
    a, b = (int(x) for x in rng.integers(0, n, 2))
    kinds = ("merge", "split", "merge", "redo", "relabel", "undo")
    kind = kinds[rng.integers(6 if len(w.session.history) > 1 else 5)]  # without a step, nothing is offered
    level = ("dihedral", "base", "final")[rng.integers(3)]
    message = {"kind": kind, "face": a, "onto_face": b, "name": f"name {b}", "level": level}
    w.view._handle_custom_msg({**message, "revision": w.view.revision}, [])
    operations = len(w.session.to_frame())
    if w.view.save_state == "saved":
        print(operations, flush=True)
"""


def test_what_was_called_saved_survives_a_killed_kernel(tmp_path):
    rng, mesh, before = np.random.default_rng(0), shapes.box(6), 0
    for round_ in range(4):
        person = subprocess.Popen(
            [sys.executable, "-c", PERSON, str(TESTS), str(round_)],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            text=True,
        )
        lines = [person.stdout.readline()]  # the first edit is saved
        time.sleep(float(rng.uniform(0, 0.3)))  # any moment will do
        person.kill()
        lines += [line for line in person.communicate()[0].splitlines(keepends=True) if line.endswith("\n")]
        assert person.returncode != 0, "it ended by itself"
        (path,) = tmp_path.glob("*.swproj")  # the same one in every round: it was restored
        with Session.open(path, mesh) as session:
            found = len(session.to_frame()) - 1  # the last one is this opening
        assert found >= int(lines[-1]) > before
        before = found
