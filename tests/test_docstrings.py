"""Every public name tells what it is, and every parameter what it means."""

import ast
import dataclasses
import doctest
import importlib
import inspect
import pkgutil
import re

import pytest

import scenewidget

SECTIONS = (
    "Parameters", "Returns", "Yields", "Raises", "Attributes", "Notes", "Examples", "References", "Warns",
    "See Also", "Other Parameters",
)  # fmt: skip


def modules():
    """Names of all modules without a leading underscore in their path."""
    found = pkgutil.walk_packages(scenewidget.__path__, "scenewidget.")
    return ["scenewidget", *(m.name for m in found if not any(p.startswith("_") for p in m.name.split(".")))]


def public_objects():
    """(name, object) of what people find from `sw`: its names, those of its packages, the engine's stages.

    Of classes, methods and properties come along.
    """
    homes = ["scenewidget", *(f"scenewidget.{name}" for name in scenewidget._MODULES)]
    homes += [name for name in modules() if name.startswith("scenewidget.engine.")]
    homes += ["scenewidget.datasets.analytic", "scenewidget.baselines.graph_segmentation"]
    seen = {}
    for home in homes:
        module = importlib.import_module(home)
        for name in getattr(module, "__all__", []):
            thing = getattr(module, name)
            if inspect.isclass(thing) or inspect.isfunction(thing):
                seen.setdefault(id(thing), (f"{thing.__module__}.{name}", thing))
    for name, thing in list(seen.values()):
        members = vars(thing).items() if inspect.isclass(thing) else ()
        for key, member in members:
            inner = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
            ours = getattr(inner.fget if isinstance(inner, property) else inner, "__module__", "")
            if key.startswith("_") or not str(ours).startswith("scenewidget"):
                continue  # traitlets, and what matplotlib adds to a class of its own
            if inspect.isfunction(inner) or isinstance(inner, property):
                seen[id(inner)] = (f"{name}.{key}", inner)
    return sorted(seen.values(), key=lambda pair: pair[0])


def sections(doc):
    """Body of each section of a numpy docstring, by name; the text above them under ""."""
    parts = re.split(rf"^({'|'.join(SECTIONS)})\n-+\n", doc, flags=re.MULTILINE)
    return {"": parts[0], **dict(zip(parts[1::2], parts[2::2], strict=True))}


def entries(body):
    """Names that a section explains: `low, high : float` gives both."""
    lines = re.findall(r"^([*\w][\w*, ]*?)(?: ?:.*)?$", body, flags=re.MULTILINE)
    return [name.strip().lstrip("*") for line in lines for name in line.split(",")]


def parameters(thing):
    """Names in the signature without self, cls and what is private."""
    if isinstance(thing, property) or (inspect.isclass(thing) and not is_made_here(thing)):
        return []
    if inspect.isclass(thing) and getattr(thing, "_is_protocol", False):
        return []  # its method says what it is called with
    names = [p for p in inspect.signature(thing).parameters if not p.startswith("_")]
    return [name for name in names if name not in ("self", "cls")]


def is_made_here(cls):
    """Whether we say what a class is made from; exceptions and heirs of other libraries don't."""
    return dataclasses.is_dataclass(cls) or "__init__" in vars(cls)


def complaints(thing):
    """What is missing in the docstring of a class, function, method or property."""
    own = thing.fget.__doc__ if isinstance(thing, property) else vars(thing).get("__doc__", thing.__doc__)
    doc = inspect.cleandoc(own or "")
    if not doc or (
        dataclasses.is_dataclass(thing) and doc.startswith(f"{thing.__name__}(")
    ):  # made by itself
        return ["no docstring"]
    found = sections(doc)
    wanted = parameters(thing)
    told = entries(found.get("Parameters", "")) + entries(found.get("Other Parameters", ""))
    if dataclasses.is_dataclass(thing):
        told += entries(found.get("Attributes", ""))
        source = inspect.getsource(thing)  # fields may be explained where they stand
        told += re.findall(r"^    (\w+):.*?#", source, flags=re.MULTILINE)
    missing = [f"says nothing of {name}" for name in wanted if name not in told and not mentions(doc, name)]
    if "Parameters" in found:
        listed = entries(found["Parameters"])
        missing = [f"{name} is not listed" for name in wanted if name not in told]
        missing += [f"explains {name}, which it does not have" for name in listed if name not in wanted]
    return missing


def mentions(doc, name):
    """Whether a short docstring without a list speaks of a parameter, in its words or by its name."""
    words = set(re.findall(r"\w+", doc.lower()))
    return name.lower() in words or all(
        any(w.startswith(part.rstrip("s")) for w in words) for part in name.lower().split("_") if part
    )


@pytest.mark.parametrize("name", modules())
def test_modules_say_what_they_are_for(name):
    assert (importlib.import_module(name).__doc__ or "").strip()


def test_public_names_are_documented():
    found = [f"{name}: {complaint}" for name, thing in public_objects() for complaint in complaints(thing)]
    assert found == []


def test_help_begins_with_all_that_there_is():
    missing = [name for name in scenewidget.__all__ if f"``{name}``" not in scenewidget.__doc__]
    assert missing == []


# --- examples -------------------------------------------------------------------------------------

SHOWN_BY_EXAMPLE = (
    "scenewidget.engine",
    "scenewidget.metrics",
    "scenewidget.evaluation",
    "scenewidget.baselines",
    "scenewidget.datasets",
    "scenewidget.datasets.analytic",
    "scenewidget.palette",
    "scenewidget.editing",
    "scenewidget.figures",
    "scenewidget.widget",
)
FROM_THEIR_PACKAGE = (  # modules whose names people take from the package alone
    "scenewidget.engine.readers.",
    "scenewidget.datasets.",
    "scenewidget.editing.",
)


def with_examples():
    """Names of the modules in which some docstring has an example."""
    return [name for name in modules() if ">>> " in inspect.getsource(importlib.import_module(name))]


@pytest.mark.parametrize("name", with_examples())
def test_examples_say_what_comes_out(name):
    module = importlib.import_module(name)
    result = doctest.testmod(module, optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    assert result.attempted > 0
    assert result.failed == 0


def test_public_functions_and_classes_have_an_example():
    missing = set()
    for name in modules():
        is_inside = name.startswith(FROM_THEIR_PACKAGE) and name not in SHOWN_BY_EXAMPLE
        if is_inside or not name.startswith(SHOWN_BY_EXAMPLE):
            continue
        module = importlib.import_module(name)
        for key in getattr(module, "__all__", []):
            thing = getattr(module, key)
            if inspect.isfunction(thing) or inspect.isclass(thing):
                missing |= {f"{thing.__module__}.{key}"} if ">>> " not in (thing.__doc__ or "") else set()
    assert missing == set()


# --- traits ---------------------------------------------------------------------------------------


def traits_without_words(source):
    """Names of the public traits that are not followed by a string that says what they are."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.ClassDef):
            continue
        for at, member in enumerate(node.body):
            target = member.targets[0] if isinstance(member, ast.Assign) else getattr(member, "target", None)
            if not isinstance(target, ast.Name) or "traitlets." not in ast.unparse(member):
                continue
            after = node.body[at + 1] if at + 1 < len(node.body) else None
            is_told = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            if not is_told and not target.id.startswith("_"):
                found.append(f"{node.name}.{target.id}")
    return found


def test_every_trait_is_told_under_it():
    sources = [
        inspect.getsource(importlib.import_module(n)) for n in modules() if "scenewidget.data" not in n
    ]
    assert [trait for source in sources for trait in traits_without_words(source)] == []
    assert traits_without_words("class A:\n  x = traitlets.Int()\n  _y = traitlets.Int()") == ["A.x"]
