"""Common to all tests; its place makes `shapes` and `strategies` importable by name."""

from hypothesis import settings

# No deadline: the first example pays for compilation. The same examples in every run.
settings.register_profile("scenewidget", deadline=None, derandomize=True)
settings.load_profile("scenewidget")
