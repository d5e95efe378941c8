"""The reference: a page for each public module, an entry for each public name, from the docstrings."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from types import ModuleType
from typing import get_origin

import scenewidget as sw

__all__ = ["PAGES", "page", "pages", "write"]

PAGES = {  # page -> title and the names of `scenewidget` on it
    "scans": ("Scans", ["load", "load_mesh", "load_cloud", "save_mesh", "Mesh", "PointCloud", "MeshError"]),
    "segmenting": ("Segmenting", ["segment", "Params", "Segmentation", "Pipeline", "Cancelled"]),
    "correcting": ("Correcting", ["Session", "export", "import_labels"]),
    "judging": ("Judging", ["evaluate", "agreement", "consensus"]),
    "many": ("Many scans", ["segment_all", "Workbench", "Rooms"]),
    "widgets": ("Widgets", ["SceneWidget", "SceneView", "Compare", "SpectralExplorer"]),
}
MODULES = ("editing", "datasets", "baselines", "metrics", "figures", "exercises")


def pages() -> dict[str, str]:
    """Text of each page by its name, names that PAGES doesn't know on one more."""
    placed = {name for _, names in PAGES.values() for name in names}
    rest = [n for n in sw.__all__ if n not in placed and n != "__version__" and not _is_module(getattr(sw, n))]
    found = {name: page(title, sw, names) for name, (title, names) in PAGES.items()}
    if rest:
        found["more"] = page("More", sw, rest)
    for name in MODULES:
        module = getattr(sw, name)
        found[name] = page(f"scenewidget.{name}", module, sorted(module.__all__))
    for name in engine_modules():
        module = importlib.import_module(f"scenewidget.engine.{name}")
        found[f"engine.{name}"] = page(f"scenewidget.engine.{name}", module, list(module.__all__))
    return found


def engine_modules() -> list[str]:
    """Modules of the engine that offer something, by name."""
    folder = Path(inspect.getfile(sw.engine)).parent
    names = sorted({p.stem for p in folder.glob("[a-z]*.py")} | {p.parent.name for p in folder.glob("*/__init__.py")})
    return [n for n in names if getattr(importlib.import_module(f"scenewidget.engine.{n}"), "__all__", None)]


def page(title: str, module: ModuleType, names: list[str]) -> str:
    """A page in reStructuredText.

    A name of a package's own page that its module offers, too, is described there; here stands a link.
    """
    lines = [title, "=" * len(title), ""]
    if module is not sw:
        lines += [(module.__doc__ or "").strip(), "", f".. currentmodule:: {module.__name__}", ""]
    else:
        lines += [".. currentmodule:: scenewidget", ""]
    for name in names:
        lines += [_entry(module, name), ""]
    return "\n".join(lines)


def write(folder: Path) -> list[str]:
    """Write all pages and their table of contents into a folder of the staged sources; gives their names."""
    folder.mkdir()
    found = pages()
    for name, text in found.items():
        (folder / f"{name}.rst").write_text(text, encoding="utf-8")
    engine = [name for name in found if name.startswith("engine.")]
    rest = [name for name in found if name not in engine]
    contents = ["Reference", "=========", "", "Every public name, with what goes in, what comes out, and an example that runs.", ""]
    for caption, names in (("What most people use", rest), ("The engine, stage by stage", engine)):
        short = [f"   {n.removeprefix('engine.')} <{n}>" if n in engine else f"   {n}" for n in names]
        contents += [".. toctree::", "   :maxdepth: 1", f"   :caption: {caption}", "", *short, ""]
    (folder / "index.rst").write_text("\n".join(contents), encoding="utf-8")
    return list(found)


def _entry(module: ModuleType, name: str) -> str:
    thing = getattr(module, name)
    full = f"{module.__name__}.{name}"
    if module is not sw and getattr(sw, name, None) is thing:
        return f"* `{name}`: see :py:obj:`scenewidget.{name}`"
    if inspect.isclass(thing):
        return f".. autoclass:: {full}\n   :members:\n   :exclude-members: set"  # matplotlib gives charts a set of its own
    if callable(thing) and get_origin(thing) is None:
        return f".. autofunction:: {full}"
    return f".. py:data:: {full}\n\n   {_shown(thing)}"


def _shown(thing: object) -> str:
    text = " ".join(repr(thing).split())
    return f"``{text}``" if len(text) < 300 else f"``{text[:280].strip()}`` …"


def _is_module(thing: object) -> bool:
    return isinstance(thing, ModuleType)
