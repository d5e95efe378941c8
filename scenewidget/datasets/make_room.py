"""Makes the scan that comes with the package: ``python -m scenewidget.datasets.make_room [folder]``."""

from __future__ import annotations

import sys
from pathlib import Path
from types import MappingProxyType
from typing import Any

from scenewidget.datasets.packing import pack
from scenewidget.datasets.room import simulate_room
from scenewidget.datasets.shipped import ROOM_FILE

__all__ = ["RECIPE", "make_room"]

RECIPE: MappingProxyType[str, Any] = MappingProxyType(
    {
        "seed": 1,
        "style": "living",
        "shape": "rectangle",
        "size": (4.6, 3.9, 2.5),
        "n_objects": 14,
        "voxel": 0.028,
    }
)


def make_room(**options: Any) -> bytes:
    """The file of the shipped room; `options` override those of `RECIPE`."""
    mesh, truth = simulate_room(**{**RECIPE, **options})
    return pack(mesh, truth.labels, truth.names)


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent) / ROOM_FILE
    data = make_room()
    target.write_bytes(data)
    sys.stdout.write(f"{target}: {len(data) / 1e6:.2f} MB\n")
