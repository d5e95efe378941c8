"""Common to all tests; its place makes `shapes` and `strategies` importable by name."""

from hypothesis import settings

# No deadline: the first example pays for compilation. The same examples in every run.
settings.register_profile("scenewidget", deadline=None, derandomize=True)
settings.load_profile("scenewidget")

LONGEST = (  # files that take a minute or more, the longest first
    "test_notebook_pages.py", "test_pipeline.py", "10_is_it_any_good.ipynb", "08_consensus.ipynb",
    "test_tools.py", "test_editor.py", "test_explore.py", "test_view.py", "test_quality.py",
)  # fmt: skip


def pytest_collection_modifyitems(items):
    """The longest files come first: at the end, no worker is left alone with one."""
    ranks = {name: rank for rank, name in enumerate(LONGEST)}
    items.sort(key=lambda item: ranks.get(item.path.name, len(ranks)))  # else as they were
