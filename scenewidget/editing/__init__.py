"""Correcting a segmentation by hand: edits, undo, project files, and formats that other tools read.

===================  ============================================================================
``session``          `Session`: everything below behind one lock; what scripts and the widget use
``edits``            merge, split, cut, paint, …, as data that names faces of the mesh
``face_set``         faces of a mesh as a value
``partition``        where every face is now, and what each edit does to that
``cut``              the two-seed cut: which faces of a segment are on the side of the second face
``borders``          a segment grown, shrunk, without holes, with a smooth border
``history``          edits done and undone, and their replay on another segmentation
``snapshot``         a session at one moment, as a view wants it
``observers``        who is told of changes
``project_binding``  the log of a session and the file that it is kept in
``project``          what a project is; ``store`` its file, ``schema`` the tables in the file
``suggestions``      merges and splits that are worth a look
``annotator``        a simulated person, to count edits
``interaction``      time, operation and error of each, in a form in which tools can be compared
``division``         a scan of many rooms in a folder, a project for each room
``formats``          segmentations in the files of other tools
===================  ============================================================================
"""

from scenewidget.editing.annotator import Correction, simulate_annotator
from scenewidget.editing.edits import (
    Cut,
    Edit,
    EditError,
    FillHoles,
    Group,
    Grow,
    Merge,
    Paint,
    Relabel,
    Shrink,
    Slice,
    SmoothBorder,
    Split,
)
from scenewidget.editing.face_set import FaceSet
from scenewidget.editing.fingerprint import Fingerprint, fingerprint
from scenewidget.editing.formats import FormatError, export, import_labels
from scenewidget.editing.interaction import compare_interactions, interaction_log
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
    "FaceSet",
    "FillHoles",
    "Fingerprint",
    "FormatError",
    "Group",
    "Grow",
    "Merge",
    "Paint",
    "ProjectError",
    "Relabel",
    "Session",
    "Shrink",
    "Slice",
    "SmoothBorder",
    "Split",
    "Step",
    "Suggestion",
    "apply_edits",
    "compare_interactions",
    "export",
    "fingerprint",
    "import_labels",
    "interaction_log",
    "nyu_class",
    "nyu_id",
    "simulate_annotator",
]
