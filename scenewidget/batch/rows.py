"""What is known of a scan after a run: its row, on disk as ``row.json``, written last.

``row.json`` in the folder of a scan is the mark that it is done: it names the files that were written, how
each is known again, and the digest of all that decided over them. What went wrong the last time stands
beside it in ``failed.json``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from scenewidget.engine.units import UnitName

__all__ = [
    "COLUMNS",
    "FAILED",
    "ROW",
    "STATUSES",
    "empty_row",
    "parse_row",
    "read_row",
    "spoken_size",
    "units_of",
]

ROW = "row.json"
FAILED = "failed.json"
STATUSES = ("done", "reused", "failed", "killed", "too large")
COLUMNS = (
    "scan", "status", "error", "seconds", "faces", "segments", "coverage", "doubt", "peak_memory",
)  # fmt: skip


def empty_row(scan: str) -> dict[str, Any]:
    """A row of which nothing is known but the scan; its status is "failed" until somebody knows better.

    Examples
    --------
    >>> row = empty_row("kitchen/a.ply")
    >>> row["status"], row["faces"]
    ('failed', None)
    """
    return {**dict.fromkeys(COLUMNS), "scan": scan, "status": "failed", "error": ""}


def parse_row(text: str) -> dict[str, Any] | None:
    """The row that a text holds; None if no run of ours wrote it.

    Examples
    --------
    >>> parse_row('{"scan": "a.ply", "key": "f1", "files": {}}')["scan"]
    'a.ply'
    >>> parse_row("mine") is None
    True
    """
    try:
        row = json.loads(text)
    except ValueError:
        return None
    is_ours = isinstance(row, dict) and all(isinstance(row.get(name), str) for name in ("scan", "key"))
    are_numbers = is_ours and all(isinstance(row.get(name), int | float | None) for name in COLUMNS[3:])
    return row if are_numbers and isinstance(row.get("files"), dict) else None


def read_row(path: Path) -> dict[str, Any] | None:
    """The row in a file; None if there is none, or no run of ours wrote it.

    Examples
    --------
    >>> from pathlib import Path
    >>> read_row(Path("no/such/row.json")) is None
    True
    """
    try:
        return parse_row(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        return None


def units_of(row: Mapping[str, Any]) -> UnitName | None:
    """In which unit a scan was read, for `load`; None where nobody said.

    Examples
    --------
    >>> units_of({"units": "mm"}), units_of({})
    ('mm', None)
    """
    units = row.get("units")
    return next((known for known in get_args(UnitName) if known == units), None)


def spoken_size(n_bytes: float) -> str:
    """Bytes as people say them.

    Examples
    --------
    >>> spoken_size(12_400_000_000), spoken_size(700_000_000), spoken_size(20_000)
    ('12.4 GB', '0.7 GB', '20 kB')
    """
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if n_bytes >= (0.1 if unit == "GB" else 1) * size:
            value = n_bytes / size
            return f"{value:.1f} {unit}" if unit == "GB" else f"{value:.0f} {unit}"
    return f"{n_bytes:.0f} bytes"
