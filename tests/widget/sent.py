"""What a view has sent to the browser."""

from scenewidget.widget.wire import unpacked


def array(view, name):
    """An array of a view, as the browser has it."""
    return unpacked(getattr(view, f"_{name}"), view._headers[name])
