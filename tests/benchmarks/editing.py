"""What edits (alone and in the widget), undo, cuts, saving and reopening cost on a large scan; file sizes.

python tests/benchmarks/editing.py scan.ply
python tests/benchmarks/editing.py --faces 1500000
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import shapes

import scenewidget as sw
from scenewidget.editing.edits import EditError
from scenewidget.editing.session import Session
from scenewidget.engine.mesh import Mesh
from scenewidget.widget.autosave import Autosave
from scenewidget.widget.edit_commands import EditCommands
from scenewidget.widget.scene_view import SceneView


def bumpy_room(n_faces: int) -> Mesh:
    """A noisy box of about so many faces."""
    n = round((n_faces / 12) ** 0.5)
    box = shapes.box(n, size=(5.0, 4.0, 3.0))
    noise = np.random.default_rng(0).normal(scale=1.0 / n, size=box.vertices.shape)
    return Mesh(box.vertices + noise, box.faces)


def milliseconds(times: list[float]) -> str:
    """Median, 99th percentile and maximum."""
    return "{:8.2f} {:8.2f} {:8.2f} ms".format(*1e3 * np.quantile(times, [0.5, 0.99, 1.0]))


def timed(task, *arguments):
    """Seconds that a call takes, and what it returns."""
    start = time.perf_counter()
    result = task(*arguments)
    return time.perf_counter() - start, result


def around(mesh: Mesh, rng: np.random.Generator, n: int) -> np.ndarray:
    """So many faces around one, as under a brush."""
    away = mesh.face_centroids - mesh.face_centroids[rng.integers(0, mesh.n_faces)]
    return np.argpartition(np.einsum("ij,ij->i", away, away), n)[:n]


def main() -> None:
    """Edit at random and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scan", nargs="?")
    parser.add_argument("--faces", type=int, default=1_500_000)
    parser.add_argument("--edits", type=int, default=1_000)
    arguments = parser.parse_args()
    mesh = sw.load_mesh(arguments.scan) if arguments.scan else bumpy_room(arguments.faces)
    seconds, seg = timed(sw.segment, mesh)
    print(f"{mesh}: segmented in {seconds:.1f} s, {seg.n_segments} segments")
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        seconds, session = timed(Session, mesh, seg)
        print(f"start                {seconds:8.2f} s, {session.atoms.n} atoms")
        seconds, _ = timed(session.save, folder / "room.swproj")
        print(
            f"save                 {seconds:8.2f} s, {(folder / 'room.swproj').stat().st_size / 1e6:.2f} MB"
        )
        edits, undos, labels, cuts = [], [], [], []
        for k in range(arguments.edits):
            a, b = (int(face) for face in rng.integers(0, mesh.n_faces, 2))
            level = ("dihedral", "base", "final", "dihedral")[k % 4]
            task = (session.merge, a, b, level) if k % 3 else (session.split, a, level)
            try:
                edits.append(timed(*task)[0])
            except EditError:
                continue
            if k % 4 == 0:
                undos.append(timed(session.undo)[0])
            if k % 20 == 0:
                labels.append(timed(lambda: session.segmentation)[0])
        assert session.is_saved
        print(f"edit, on disk        {milliseconds(edits)}   (median, 99 %, most of {len(edits)})")
        print(f"undo, on disk        {milliseconds(undos)}")
        print(f"labels per face      {milliseconds(labels)}")
        session.go_to(0)
        for label in range(min(5, seg.n_segments)):
            faces = np.flatnonzero(seg.labels == label)
            a, b = (int(face) for face in rng.choice(faces, 2, replace=False))
            cuts.append((len(faces), timed(session.cut, a, b)[0]))
        print("cut                  " + ", ".join(f"{s:.2f} s of {n} faces" for n, s in cuts))
        session.go_to(0)
        for n in (1_000, 10_000, 100_000):
            painted = [timed(session.paint, around(mesh, rng, n))[0] for _ in range(20)]
            print(f"paint {n:7} faces  {milliseconds(painted)}   on disk")
        session.close()
        print(f"project after that   {(folder / 'room.swproj').stat().st_size / 1e6:8.2f} MB")
        seconds, session = timed(Session.open, folder / "room.swproj", mesh)
        print(f"reopen               {seconds:8.2f} s, {len(session.to_frame())} operations")
        session.save(folder / "whole.swproj", include_mesh=True)
        print(f"with the mesh in it  {(folder / 'whole.swproj').stat().st_size / 1e6:8.2f} MB")
        for file in ("a.ply", "a.npz", "a.glb", "s.aggregation.json", "n.xml", "a.csv"):
            seconds, paths = timed(sw.export, session.segmentation, mesh, folder / file)
            size = sum(path.stat().st_size for path in paths) / 1e6
            line = f"export {file:18} {seconds:5.2f} s {size:8.2f} MB"
            if file != "a.csv":
                line += f"   import {timed(sw.import_labels, mesh, folder / file)[0]:5.2f} s"
            print(line, flush=True)
        session.close()
    gestures, answers = by_gestures(mesh, seg, arguments.edits // 4)
    print(f"edit in the widget   {milliseconds(gestures)}   from the message to its answer, CPU")
    print(f"labels after it      {milliseconds(answers)}   only when somebody asks")


def by_gestures(mesh: Mesh, seg: sw.Segmentation, n: int) -> tuple[list[float], list[float]]:
    """Processor seconds of edits as the picture sends them, and of asking for the labels per face then."""
    view = SceneView(mesh, editable=True)
    lock = threading.RLock()
    commands = EditCommands(view, lock, Autosave(view, lock, False, print), lambda: None)
    commands.take(seg, sw.Params())
    rng = np.random.default_rng(1)
    spent, asked = [], []
    for k in range(n):
        a, b = (int(face) for face in rng.integers(0, mesh.n_faces, 2))
        edit = {"kind": "merge", "face": a, "onto_face": b} if k % 3 else {"kind": "split", "face": a}
        message = {**edit, "level": ("dihedral", "base", "final")[k % 3], "revision": view.revision}
        start, before = time.process_time(), len(commands.session.edits)
        commands.handle({**message, "client": "benchmark", "number": k})
        if len(commands.session.edits) > before:
            spent.append(time.process_time() - start)
        if k % 20 == 0:
            start = time.process_time()
            assert commands.session.segmentation.labels.shape == (mesh.n_faces,)
            asked.append(time.process_time() - start)
    return spent, asked


if __name__ == "__main__":
    main()
