"""Scans with known truth: one that comes with the package, and any number of simulated ones."""

from __future__ import annotations

from scenewidget.datasets.room import SCANNERS, simulate_room
from scenewidget.datasets.scenenn import load_scenenn
from scenewidget.datasets.shipped import load_room

__all__ = ["SCANNERS", "load_room", "load_scenenn", "simulate_room"]
