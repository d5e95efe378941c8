"""The front end as it was built when the package was installed."""

from __future__ import annotations

from functools import cache
from pathlib import Path

__all__ = ["bundled"]

STATIC = Path(__file__).parent.parent / "static"


@cache
def bundled(name: str) -> str:
    """Text of a file of the bundle, such as ``"scene_view.js"``.

    Raises
    ------
    FileNotFoundError
        It was not built.

    Examples
    --------
    >>> "scenewidget" in bundled("scene_view.css")
    True
    """
    path = STATIC / name
    if not path.is_file():
        raise FileNotFoundError(
            f"{path} is missing: the front end was not built. Install the package again, with "
            "`pip install .` or `pip install -e .` in its folder; both build it"
        )
    return path.read_text(encoding="utf-8")
