"""Whoever looks for the tests of a module finds them under its name."""

from pathlib import Path

import pytest

import scenewidget

TESTS, PACKAGE = Path(__file__).parent, Path(scenewidget.__file__).parent
ELSEWHERE = {  # modules whose tests stand in the file of another name, since they only work together
    "engine/scale.py": "engine/test_scene_scale.py",  # figures/test_scale.py has the short name
    "engine/sides.py": "engine/test_gravity.py",
    "engine/units.py": "engine/test_gravity.py",
    "figures/thesis.py": "figures/test_thesis_figures.py",  # engine/test_thesis.py has the short name
    "editing/files.py": "editing/test_store.py",
    "editing/fingerprint.py": "editing/test_store.py",
    "editing/project.py": "editing/test_store.py",
    "editing/project_reader.py": "editing/test_project_files.py",
    "editing/schema.py": "editing/test_store.py",
    "widget/autosave.py": "widget/test_autosave_file.py",  # browser/test_autosave.py has the short name
    "widget/bundle.py": "widget/test_scene_view.py",
    "widget/page.py": "widget/test_scene_view.py",
}


def places():
    """(module, where its tests are) of all modules that do something."""
    for folder in ("engine", "editing", "figures", "widget"):
        for path in sorted((PACKAGE / folder).glob("*.py")):
            if path.name != "__init__.py":
                name = f"{folder}/{path.name}"
                yield name, ELSEWHERE.get(name, f"{folder}/test_{path.name}")


@pytest.mark.parametrize(("module", "tests"), list(places()))
def test_every_module_has_its_tests(module, tests):
    assert (TESTS / tests).is_file()


def test_exceptions_are_of_modules_that_exist():
    assert [name for name in ELSEWHERE if not (PACKAGE / name).is_file()] == []
