"""What an installation weighs: packages, licences, megabytes, seconds to import, printed as tables.

    python tests/benchmarks/weight.py

Sizes are those of the files that each distribution installed here; "why" is the comment in pyproject.toml.
"""

from __future__ import annotations

import importlib.metadata
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
RUNS = 5


def reasons() -> dict[str, str]:
    """Our direct dependencies and why each is there."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    body = text.split("\ndependencies = [", 1)[1].split("\n]", 1)[0]
    return dict(re.findall(r'^\s*"([A-Za-z0-9_-]+)[^"]*",\s*# (.+)$', body, flags=re.MULTILINE))


def megabytes(name: str) -> float:
    files = importlib.metadata.files(name) or []
    return sum(f.locate().stat().st_size for f in files if f.locate().is_file()) / 1e6


def licence(name: str) -> str:
    metadata = importlib.metadata.metadata(name)
    classifiers = [c.split("::")[-1].strip() for c in metadata.get_all("Classifier", []) if "License ::" in c]
    text = metadata.get("License-Expression") or next(iter(classifiers), "") or metadata.get("License", "")
    return text.replace(" License", "").replace("Mozilla Public 2.0 (MPL 2.0)", "MPL-2.0")[:60]


def closure(name: str) -> set[str]:
    """All packages that come with this one, itself included; extras left out."""
    found: set[str] = set()
    queue = [name]
    while queue:
        one = queue.pop().lower().replace("_", "-")
        if one in found:
            continue
        try:
            wanted = importlib.metadata.requires(one) or []
        except importlib.metadata.PackageNotFoundError:
            continue
        found.add(one)
        needs = map(Requirement, wanted)
        queue.extend(r.name for r in needs if r.marker is None or r.marker.evaluate({"extra": ""}))
    return found


def import_seconds(module: str) -> float:
    """Median over fresh processes, less what an empty one takes."""

    def once(code: str) -> float:
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        return time.perf_counter() - start

    once(f"import {module}")
    return statistics.median(once(f"import {module}") - once("pass") for _ in range(RUNS))


def wheel_megabytes() -> float:
    """Size of the wheel that this tree makes."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "pip",
            "wheel",
            "-q",
            "--no-deps",
            "--no-build-isolation",
            "-w",
            folder,
        ]
        subprocess.run([*command, str(ROOT)], check=True)
        return next(Path(folder).glob("*.whl")).stat().st_size / 1e6


def main() -> None:
    print("| package | licence | MB | why |\n|---|---|---|---|")
    for name, why in sorted(reasons().items(), key=lambda item: -megabytes(item[0])):
        print(f"| {name} | {licence(name)} | {megabytes(name):.0f} | {why} |")
    everything = closure("scenewidget")
    total = sum(map(megabytes, everything))
    print("\n| | |\n|---|---|")
    print(f"| packages in all, with what they need themselves | {len(everything)} |")
    print(f"| installed | {total:.0f} MB |")
    print(f"| our wheel | {wheel_megabytes():.2f} MB |")
    print(f"| `import scenewidget` | {import_seconds('scenewidget'):.2f} s |")


if __name__ == "__main__":
    main()
