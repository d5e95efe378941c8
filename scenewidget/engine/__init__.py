"""The method: pure functions from a mesh to its segments. Runs without Jupyter.

`pipeline.segment` leads from a mesh to its segments; `stages` is the table of its steps in order, each a call
of the module that has its idea: `preprocess`, `items`, `dihedral`, `allocation`, `operators`, `features`,
`distances`, `ensemble`, `consensus`, `finish`, `segmentation`, `family`. Each is imported on first use:
``sw.engine.distances.all_pairs(graph)``.
"""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType


def __getattr__(name: str) -> ModuleType:
    if name in __dir__():
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(module.name for module in pkgutil.iter_modules(__path__))
