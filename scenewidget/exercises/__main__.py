"""``python -m scenewidget.exercises solutions FOLDER`` writes worked solutions for teachers."""

from __future__ import annotations

import argparse
from pathlib import Path

from scenewidget.exercises.solutions import write

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> None:
    """Write them and say where."""
    parser = argparse.ArgumentParser(prog="python -m scenewidget.exercises", description="For teachers.")
    commands = parser.add_subparsers(required=True, metavar="solutions")
    solutions = commands.add_parser("solutions", help="write a page of worked solutions for each notebook")
    solutions.add_argument("folder", type=Path, help="where to; made if it is not there")
    folder = parser.parse_args(arguments).folder
    if folder.exists() and not folder.is_dir():
        parser.error(f"FOLDER must be a folder, {folder} is a file")
    for path in write(folder):
        print(path)


if __name__ == "__main__":
    main()
