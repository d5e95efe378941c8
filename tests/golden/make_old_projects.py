"""Projects as each format of project files had them; made once, by the code that wrote that format.

From a commit that wrote it (10d3714, the last one, for the first format; 2b3909c for the second):

PYTHONPATH=. python tests/golden/make_old_projects.py tests/golden format_1

The first format has no table ``root``. ``format_1.swproj`` was closed; ``format_1_killed.swproj`` with its
``-wal`` is what a killed process leaves.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import shapes

import scenewidget as sw
from scenewidget.editing.session import Session
from scenewidget.engine.segmentation import Segmentation


def main(folder: Path, name: str) -> None:
    """Write both projects into a folder."""
    mesh = shapes.box(4)
    levels = {"base": np.arange(mesh.n_faces, dtype=np.int32) // 8}
    seg = Segmentation(mesh, np.arange(mesh.n_faces, dtype=np.int32) // 32, levels=levels)
    session = Session(mesh, seg, params=sw.Params(n_segments=6), vocabulary=["chair", "Tür"])
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary) / "room.swproj"
        session.save(place, include_mesh=True)
        session.relabel(0, "chair")
        session.merge([0, 40], 70)
        session.cut(0, 70)
        session.split(100, "base")
        session.undo()
        for suffix in ("", "-wal"):
            shutil.copy(f"{place}{suffix}", folder / f"{name}_killed.swproj{suffix}")
        session.close()
        shutil.copy(place, folder / f"{name}.swproj")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
