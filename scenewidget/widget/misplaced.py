"""Where something belongs that somebody asks of, or gives to, the wrong object."""

from __future__ import annotations

import inspect
from collections.abc import Mapping

from scenewidget.editing.session import Session
from scenewidget.engine.checks import did_you_mean
from scenewidget.engine.params import Params
from scenewidget.engine.segmentation import Segmentation
from scenewidget.widget.scene_state import LIKE, option_names
from scenewidget.widget.scene_view import SceneView

__all__ = ["place_to_get", "place_to_set", "refuse_options"]

WAYS = {  # to do what people ask a `SceneWidget` for that needs no name of its own, or has another
    ("export", "to_ply"): "write sw.export(w.segmentation, w.mesh, path)",
    ("run", "compute", "start", "segment", "update", "refresh", "recompute"): "it computes by itself: set "
    "w.params, and in a script w.wait()",
    ("show", "display", "render"): "w as the last line of a cell shows it, or display(w)",
    ("on_click", "on_change", "on_edit", "on_trait_change"): "write w.observe(handler, 'segmentation')",
    ("screenshot", "save_png", "save_image", "savefig"): "the picture's button with the camera saves a PNG, "
    "w.view.to_html(path) a page",
}
SETTINGS = {  # what people set of a `SceneWidget` that isn't to be set
    ("view",): "its traits are: write w.view.color_by = …, w.view.height = …",
    ("controls",): "they follow w.params",
    ("pipeline",): "another scan needs another widget",
    ("vocabulary",): "write w.session.vocabulary = …",
}


def place_to_set(kind: type, name: str, view: str = "view") -> str:
    """What to write where somebody sets a name that a widget hasn't got; "" if nobody can tell.

    Parameters
    ----------
    kind : type
        Of the widget.
    name : str
    view : str
        What the widget calls its picture.

    Examples
    --------
    >>> import scenewidget as sw
    >>> place_to_set(sw.SceneWidget, "color_by"), place_to_set(sw.SceneWidget, "my_notes")
    ('write w.view.color_by = …', '')
    """
    for names, way in SETTINGS.items():
        if name in names:
            return way
    if name == "width":
        return "write w.layout.width = '600px'"
    if name in Params.__dataclass_fields__ and hasattr(kind, "params"):
        return f"write w.params = w.params.replace({name}=…)"
    if name in option_names():
        return f"write w.{view}.{name} = …"
    if hasattr(kind, "session") and (name in dir(Segmentation) or name in Segmentation.__dataclass_fields__):
        return "it follows from the segmentation, which w.session edits and w.params computes anew"
    if name in inspect.signature(kind).parameters:
        return f"give it when the widget is made: {kind.__name__}(…, {name}=…)"
    own = [*getattr(kind, "class_own_traits", dict)(), "view", "height", "observe"]
    return did_you_mean(name, own, alike=LIKE)


def place_to_get(name: str) -> str:
    """What to write where somebody asks a `SceneWidget` for what it hasn't got; "" if nobody can tell.

    Examples
    --------
    >>> place_to_get("labels")
    'it is w.segmentation.labels'
    """
    for names, way in WAYS.items():
        if name in names:
            return way
    for place, kind in (("segmentation", Segmentation), ("session", Session), ("view", SceneView)):
        if name in dir(kind) or name in getattr(kind, "__dataclass_fields__", ()):
            return f"it is w.{place}.{name}"
    return f"it is w.params.{name}" if name in Params.__dataclass_fields__ else ""


def refuse_options(kind: type, options: Mapping[str, object]) -> None:
    """Say where options belong that a widget doesn't take.

    Parameters
    ----------
    kind : type
        Of the widget.
    options : dict
        What is too much; nothing happens without any.

    Raises
    ------
    TypeError
        There are some.

    Examples
    --------
    >>> import scenewidget as sw
    >>> refuse_options(sw.Compare, {"n_segments": 3})
    Traceback (most recent call last):
    TypeError: Compare takes options of the method in Params: write Compare(mesh, Params(n_segments=3))
    """
    if not options:
        return
    name, *_ = options
    of_method = {key: value for key, value in options.items() if key in Params.__dataclass_fields__}
    if name in of_method:
        given = ", ".join(f"{key}={value!r:.40}" for key, value in of_method.items())
        way = f"{kind.__name__}(mesh, Params({given}))"
        raise TypeError(f"{kind.__name__} takes options of the method in Params: write {way}")
    parameters = inspect.signature(kind).parameters.values()
    there = [p.name for p in parameters if p.kind is not p.VAR_KEYWORD]
    hint = did_you_mean(name, there, alike=LIKE) or f"there are: {', '.join(there)}"
    if name in SceneView.class_traits():
        hint = f"set it of the picture, once it is made: w.view.{name} = …"
    if name == "width":
        hint = "it fills its place; w.layout.width = '600px' says how wide it is"
    raise TypeError(f"{kind.__name__} has no option {name!r}; {hint}")
