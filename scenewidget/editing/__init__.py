"""Correcting a segmentation by hand: edits, undo, project files, and formats that other tools read."""

from scenewidget.editing.annotator import Correction, simulate_annotator
from scenewidget.editing.edits import Cut, Edit, EditError, Merge, Relabel, Split
from scenewidget.editing.fingerprint import Fingerprint, fingerprint
from scenewidget.editing.formats import FormatError, export, import_labels
from scenewidget.editing.project import ProjectError
from scenewidget.editing.session import Event, Session, Step, apply_edits
from scenewidget.editing.suggestions import Suggestion
from scenewidget.editing.vocabulary import NYU40, SCANNET20, nyu_class, nyu_id

__all__ = [
    "NYU40",
    "SCANNET20",
    "Correction",
    "Cut",
    "Edit",
    "EditError",
    "Event",
    "Fingerprint",
    "FormatError",
    "Merge",
    "ProjectError",
    "Relabel",
    "Session",
    "Split",
    "Step",
    "Suggestion",
    "apply_edits",
    "export",
    "fingerprint",
    "import_labels",
    "nyu_class",
    "nyu_id",
    "simulate_annotator",
]
