"""The public names of the package and the arguments they take; as a script, writes them to the golden file.

python tests/public_api.py       # after adding a name; the difference shows what users get
"""

import inspect
from pathlib import Path

import scenewidget as sw

GOLDEN = Path(__file__).parent / "golden" / "public_api.txt"
MODULES = ("baselines", "datasets", "editing", "engine", "exercises", "figures", "metrics")


def arguments(thing):
    """Names of the arguments of a callable, in order, a star before those that go by keyword only."""
    try:
        parameters = inspect.signature(thing).parameters.values()
    except (TypeError, ValueError):
        return ""
    names, is_keyword = [], False
    for parameter in parameters:
        if parameter.name == "self" or parameter.kind is parameter.VAR_KEYWORD:
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not is_keyword:
            names.append("*")
            is_keyword = True
        names.append(parameter.name)
    return f"({', '.join(names)})"


def members(name, thing):
    """Lines about a class: itself, and what it offers of its own."""
    yield f"{name}{arguments(thing)}" if thing.__init__ is not object.__init__ else name
    for one in sorted(
        {n for base in thing.__mro__ if base.__module__.startswith("scenewidget") for n in vars(base)}
    ):
        if one.startswith("_"):
            continue
        value = inspect.getattr_static(thing, one)
        if isinstance(value, (staticmethod, classmethod)):
            value = value.__func__
        if inspect.isfunction(value):
            text = arguments(value).replace("(cls, ", "(").replace("(cls)", "()")
            yield f"{name}.{one}{text}"
        else:
            yield f"{name}.{one}"


def public_api():
    """A line a name."""
    lines = []
    owners = [("", sw)] + [(f"{m}.", getattr(sw, m)) for m in MODULES if hasattr(sw, m)]
    for prefix, owner in owners:
        for name in sorted(getattr(owner, "__all__", ())):
            thing = getattr(owner, name)
            if inspect.isclass(thing):
                lines += members(f"{prefix}{name}", thing)
            elif callable(thing):
                lines.append(f"{prefix}{name}{arguments(thing)}")
            else:
                lines.append(f"{prefix}{name}")
    return lines


if __name__ == "__main__":
    GOLDEN.write_text("\n".join(public_api()) + "\n", encoding="utf-8")
