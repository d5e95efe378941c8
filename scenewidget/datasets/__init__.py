"""Scans with known truth: one that comes with the package, simulated ones, the real ones of SceneNN."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenewidget.datasets.room import SCANNERS, simulate_room
    from scenewidget.datasets.scenenn import load_scenenn
    from scenewidget.datasets.shipped import load_room

_HOME = {  # public name -> its module; resolved on first use: the simulator takes a second to import
    "SCANNERS": "room",
    "load_room": "shipped",
    "load_scenenn": "scenenn",
    "simulate_room": "room",
}

__all__ = ["SCANNERS", "load_room", "load_scenenn", "simulate_room"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'scenewidget.datasets' has no attribute {name!r}")
    return getattr(importlib.import_module(f"scenewidget.datasets.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
