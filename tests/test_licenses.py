"""Only permissive licences come in: of every package that an installation with all extras brings along."""

from __future__ import annotations

import importlib.metadata
import re
import tomllib
from email.message import Message
from pathlib import Path

import pytest
from packaging.requirements import Requirement

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FORBIDDEN = re.compile(
    r"\bA?L?GPL|GNU (Affero |Lesser |Library )?General Public|non-?commercial|\bCC[- ]BY[- ]NC|SSPL|BUSL",
    re.IGNORECASE,
)
ALLOWED = re.compile(
    r"\bMIT|BSD|Apache|\bISC\b|ISCL|Python Software Foundation|\bPSF|MPL[- ]2|Mozilla Public License 2"
    r"|Zlib|CC0|HPND|Unlicense|Kiwi|matplotlib",
    re.IGNORECASE,
)


def licence(metadata: Message) -> str:
    """What a package says of its licence: the expression, the classifiers, the opening of the text."""
    classifiers = [c for c in metadata.get_all("Classifier", []) if c.startswith("License ::")]
    expression = metadata.get("License-Expression")
    return " | ".join([expression or (metadata.get("License") or "")[:400], *classifiers])


def is_permissive(text: str) -> bool:
    return bool(ALLOWED.search(text)) and not FORBIDDEN.search(text)


def packages() -> dict[str, Message]:
    """Everything installed that scenewidget with all its extras needs, directly or through others."""
    extras = PROJECT["optional-dependencies"].values()
    wanted = [Requirement(text) for texts in (PROJECT["dependencies"], *extras) for text in texts]
    queue = [(one.name, tuple(sorted(one.extras))) for one in wanted if one.name != "scenewidget"]
    found: dict[str, Message] = {}
    seen: set[tuple[str, tuple[str, ...]]] = set()
    while queue:
        name, of = queue.pop()
        if (name.lower(), of) in seen:
            continue
        seen.add((name.lower(), of))
        try:
            distribution = importlib.metadata.distribution(name)
        except importlib.metadata.PackageNotFoundError:
            continue  # an extra that isn't installed here
        found[name.lower()] = distribution.metadata
        for text in distribution.requires or ():
            needed = Requirement(text)
            if needed.marker is None or any(needed.marker.evaluate({"extra": e}) for e in ("", *of)):
                queue.append((needed.name, tuple(sorted(needed.extras))))
    return found


def test_every_package_that_comes_along_is_permissive():
    found = packages()
    assert {"numpy", "numba", "anywidget", "trimesh"} <= set(found)
    refused = {name: licence(data) for name, data in found.items() if not is_permissive(licence(data))}
    if (
        "docutils" in refused
    ):  # of the extra "docs"; only its mode for Emacs is GPL, and the wheel leaves it out
        assert not any(path.suffix == ".el" for path in importlib.metadata.files("docutils") or ())
        del refused["docutils"]
    assert refused == {}


@pytest.mark.parametrize(
    "text",
    [
        "GNU GENERAL PUBLIC LICENSE Version 3",
        "LGPL-2.1-or-later",
        "License :: OSI Approved :: GNU Lesser General Public License v3 (LGPLv3)",
        "AGPL-3.0-only",
        "MIT AND GPL-3.0-or-later",
        "CC-BY-NC-4.0",
        "free for non-commercial use",
        "",
    ],
)
def test_what_is_not_permissive_or_says_nothing_is_refused(text):
    assert not is_permissive(text)


@pytest.mark.parametrize("text", ["BSD-3-Clause", "MPL-2.0", "MIT License", "Apache-2.0 AND ISC", "PSF-2.0"])
def test_permissive_licences_pass(text):
    assert is_permissive(text)


def test_of_libigl_only_the_core_is_imported():
    """igl.copyleft and what it wraps are GPL; the core is MPL 2."""
    for path in (Path(__file__).parents[1] / "scenewidget").rglob("*.py"):
        for line in path.read_text(encoding="utf-8").splitlines():
            words = line.split()
            if words[:1] in (["import"], ["from"]) and any(w.startswith("igl") for w in words):
                assert line.strip() == "import igl", f"{path.name}: {line.strip()}"
            assert "igl.copyleft" not in line, path.name
            assert "igl.triangle" not in line, path.name


def test_every_dependency_stands_in_the_table_with_its_reason():
    root = Path(__file__).parents[1]
    wanted = PROJECT["dependencies"]
    table = (root / ".github" / "DEPENDENCIES.md").read_text(encoding="utf-8")
    rows = [line.split(" | ") for line in table.splitlines() if line.startswith("| ")][1:]
    reasons = {row[0].strip("| "): row[3].strip("| ") for row in rows if len(row) == 4}
    assert set(reasons) == {Requirement(text).name for text in wanted}
    assert all(reasons.values())
