"""Methods of others to compare with: Felzenszwalb's graph segmentation, Karpathy's object discovery."""

from __future__ import annotations

from scenewidget.baselines.graph_segmentation import THRESHOLDS, felzenszwalb, karpathy_oversegmentations
from scenewidget.baselines.object_discovery import karpathy
from scenewidget.baselines.segment_objectness import objectness

__all__ = ["THRESHOLDS", "felzenszwalb", "karpathy", "karpathy_oversegmentations", "objectness"]
