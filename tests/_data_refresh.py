"""Run the notebooks and write their outputs back, without widget state: `python tests/refresh_notebooks.py`.

What a notebook prints is compared by nbval, so look at the difference before you commit it.
"""

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"


def refresh(path: Path) -> None:
    """Execute one notebook from a fresh kernel and keep only what can be committed."""
    notebook = nbformat.read(path, as_version=4)
    here = {"metadata": {"path": str(path.parent)}}  # as in JupyterLab, and under nbval
    options = {"timeout": 550, "kernel_name": "python3", "store_widget_state": False}
    NotebookClient(notebook, resources=here, **options).execute()
    notebook.metadata.pop("widgets", None)
    notebook.metadata["language_info"] = {"name": "python"}
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        for output in cell.get("outputs", []):
            output.get("data", {}).pop("application/vnd.jupyter.widget-view+json", None)
    nbformat.write(notebook, path)


if __name__ == "__main__":
    for path in [Path(name) for name in sys.argv[1:]] or sorted(NOTEBOOKS.glob("*.ipynb")):
        print(path.name)
        refresh(path)
