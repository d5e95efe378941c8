"""What commands share: how a table is shown, and how progress is told."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["add_output", "show", "tell"]


def add_output(parser: argparse.ArgumentParser) -> None:
    """How a command speaks."""
    parser.add_argument("--json", action="store_true", help="print the table as JSON, a list of rows")
    parser.add_argument("--quiet", action="store_true", help="no progress, only the table and errors")


def tell(options: argparse.Namespace, line: str) -> None:
    """Progress, on stderr unless ``--quiet``."""
    if not options.quiet:
        print(line, file=sys.stderr, flush=True)


def show(rows: Sequence[Mapping[str, Any]], options: argparse.Namespace, *, mean: bool = False) -> None:
    """Print rows as a table, or as JSON with null for what isn't known."""
    if options.json:
        plain = [{key: _plain(value) for key, value in row.items()} for row in rows]
        print(json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False))
        return
    import pandas as pd

    table = pd.DataFrame(list(rows))
    for column in table.select_dtypes("number"):
        if all(isinstance(row.get(column), int | None) for row in rows):
            table[column] = table[column].astype("Int64")  # stays whole beside rows that have none
    errors = table.pop("error") if "error" in table else pd.Series(dtype=str)
    if errors.astype(bool).any():
        table["error"] = errors  # the widest column last
    if mean and len(table) > 1:
        means = table.select_dtypes("float").mean().to_dict()
        table = pd.concat([table, pd.DataFrame([{**means, "scan": "mean"}])], ignore_index=True)
    shown = table.astype(object).where(table.notna(), "")
    print(shown.to_string(index=False, float_format="{:.4f}".format))


def _plain(value: Any) -> Any:
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and not math.isfinite(value) else value
