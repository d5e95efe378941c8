"""Sphinx settings of the book; ``python notebooks/book`` stages the sources and calls Sphinx with them."""

import re
from importlib.metadata import version as version_of

project = "scenewidget"
author = "The authors of scenewidget"
copyright = "BSD-3-Clause"  # noqa: A001
version = release = version_of("scenewidget")
language = "en"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "numpydoc",
]
exclude_patterns = ["_downloads", "_extra", "_static"]
root_doc = "book/index"
nitpicky = False

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # stored outputs are compared at every test run
nb_ipywidgets_js = {}  # nothing that would be fetched
nb_merge_streams = True

autodoc_typehints = "none"  # the numpydoc tables say types, with shapes
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

html_theme = "furo"
html_title = "scenewidget"
html_static_path = ["_static"]
html_css_files = ["book.css"]
html_extra_path = ["_extra"]
html_copy_source = False
html_show_sphinx = False

mathjax_path = "tex-svg.js"  # one file, fonts included; the build lays it into _static
mathjax3_config = {"svg": {"fontCache": "global"}}


def _without_substitutions(app, what, name, obj, options, lines):
    """Let |x| be the size of x rather than a name to be replaced."""
    for i, line in enumerate(lines):
        if line.strip() == "Examples":
            break
        lines[i] = re.sub(r"\|(?=\S)", r"\\|", line)


def setup(app):
    """Mend docstrings before numpydoc reads them."""
    app.connect("autodoc-process-docstring", _without_substitutions, priority=100)
