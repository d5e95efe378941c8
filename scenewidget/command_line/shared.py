"""What commands share: how a table is shown, and how progress is told."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TextIO

from scenewidget.batch.rows import spoken_size

__all__ = ["add_output", "as_flags", "say", "show", "tell"]

FLAGS = re.compile(r"""\b(overwrite|tile_faces|units|scans|truth)=(?:True\b|["']([^"']*)["'])?""")

SPOKEN: Mapping[str, Callable[[float], str]] = {  # columns that people read in other units than programs
    "seconds": "{:.1f}".format,
    "peak_memory": spoken_size,
}


def add_output(parser: argparse.ArgumentParser) -> None:
    """How a command speaks."""
    parser.add_argument("--json", action="store_true", help="print the table as JSON, a list of rows")
    parser.add_argument("--quiet", action="store_true", help="no progress, only the table and errors")


def as_flags(text: str) -> str:
    """A message of the package with its arguments as they are called here.

    Examples
    --------
    >>> as_flags('replace it with overwrite=True, or load it with units="mm"')
    'replace it with --overwrite, or load it with --units mm'
    >>> as_flags("n_workers is for a cluster of our own; with client= leave it out")
    '--workers is for a cluster of our own; with --scheduler leave it out'
    """
    text = re.sub(r"\bclient(=| must)", lambda m: "--scheduler" + m[1].strip("="), text)
    text = re.sub(r"\bn_workers\b", "--workers", text)
    return FLAGS.sub(lambda m: f"--{m[1].replace('_', '-')}" + (f" {m[2]}" if m[2] else ""), text)


def say(text: str, file: TextIO | None = None) -> None:
    r"""Print a text, with escapes for what the terminal's encoding hasn't, such as bytes in a file's name.

    Examples
    --------
    >>> say("kitchen\udcff.ply")
    kitchen\udcff.ply
    """
    file = file or sys.stdout
    encoding = file.encoding or "utf-8"
    print(text.encode(encoding, "backslashreplace").decode(encoding), file=file, flush=True)


def tell(options: argparse.Namespace, line: str) -> None:
    """Progress, on stderr unless ``--quiet``."""
    if not options.quiet:
        say(as_flags(line), sys.stderr)


def show(rows: Sequence[Mapping[str, Any]], options: argparse.Namespace, *, mean: bool = False) -> None:
    """Print rows as a table and then what went wrong, or all as JSON with null for what isn't known."""
    if options.json:
        plain = [{key: _plain(value) for key, value in row.items()} for row in rows]
        say(json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False))
        return
    if not rows:
        return
    import pandas as pd

    table = pd.DataFrame([{k: v for k, v in row.items() if k != "error"} for row in rows])
    for column in table.select_dtypes("number"):
        if all(isinstance(row.get(column), int | None) for row in rows):
            table[column] = table[column].astype("Int64")  # stays whole beside rows that have none
    if mean and len(table.select_dtypes("float").dropna(how="all")) > 1:
        means = table.select_dtypes("float").mean().to_dict()
        table = pd.concat([table, pd.DataFrame([{**means, "scan": "mean"}])], ignore_index=True)
    shown = table.astype(object).where(table.notna(), "")
    for column, spoken in SPOKEN.items():
        if column in shown:
            shown[column] = [spoken(value) if value != "" else "" for value in shown[column]]
    width = max(map(len, shown["scan"]))
    left: Any = {"scan": f"{{:<{width}}}".format}
    say(shown.to_string(index=False, float_format="{:.4f}".format, formatters=left))
    wrong = [f"{row['scan']}: {as_flags(row['error'])}" for row in rows if row.get("error")]
    if wrong:
        say("\n" + "\n".join(wrong))


def _plain(value: Any) -> Any:
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and not math.isfinite(value) else value
