"""What the formats share: labels on their way in, colours on their way out, and votes between the two."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from scenewidget.editing.edits import MAX_NAME
from scenewidget.engine.mesh import FloatArray, IntArray, Mesh

__all__ = [
    "FormatError",
    "Labels",
    "clean_name",
    "faces_from_vertices",
    "label_column",
    "no_labels",
    "same_place",
    "vertices_from_faces",
    "whole_numbers",
]

LABEL_NAMES = (  # of columns, in lower case, the first that is there counts
    *("instance", "label", "segment", "object", "objectid", "segment_id", "instance_id", "category_id"),
    *("instanceid", "segmentid", "labelid", "class", "classification", "semantic", "category"),
    *("object_id", "label_id", "class_id", "classid", "categoryid", "semantic_id", "semantic_label"),
    *("instance_label", "globalid", "global_id", "nyu40", "nyu_label", "part", "part_id", "cluster"),
    *("cluster_id", "panoptic", "labels", "instances", "segments", "instance_ids", "segment_ids"),
)


class FormatError(ValueError):
    """A label file that is damaged, of another mesh, or without labels.

    Examples
    --------
    >>> issubclass(FormatError, ValueError)
    True
    """


@dataclass(frozen=True, eq=False)
class Labels:
    """What a label file says."""

    values: IntArray  # (n_faces,) or (n_vertices,) ids, negative = unlabeled
    per: Literal["face", "vertex"]
    names: Mapping[int, str] = field(default_factory=dict)  # of the ids
    groups: Mapping[int, int] = field(default_factory=dict)  # id of the whole, of those that are parts
    confidence: FloatArray | None = None
    levels: Mapping[str, IntArray] = field(default_factory=dict)
    report: Mapping[str, Any] = field(default_factory=dict)


def clean_name(value: Any) -> str:
    r"""A segment's name out of a file, without what no name may hold.

    Examples
    --------
    >>> clean_name(" chair\x07 ")
    'chair'
    """
    text = "".join(c for c in str(value) if unicodedata.category(c) not in ("Cc", "Cs"))
    return unicodedata.normalize("NFC", text).strip()[:MAX_NAME].strip()


def faces_from_vertices(values: IntArray, mesh: Mesh) -> tuple[IntArray, int]:
    """(n_faces,) label of at least two of the corners, else the middle one, and how often that was."""
    corners = np.sort(values[mesh.faces], axis=1)
    ambiguous = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
    return corners[:, 1], int(ambiguous.sum())


def vertices_from_faces(labels: IntArray, mesh: Mesh) -> IntArray:
    """(n_vertices,) label of most of the area around each vertex; ties go to the smaller label, -1 last.

    Vertices without a face are unlabeled.
    """
    n = int(labels.max(initial=-1)) + 2
    shifted = np.where(labels < 0, n - 1, labels).astype(np.int64)
    code = (mesh.faces.astype(np.int64) * n + shifted[:, None]).ravel()
    order = np.argsort(code, kind="stable")
    code = code[order]
    starts = np.flatnonzero(np.concatenate([[True], code[1:] != code[:-1]]))
    # degenerate faces weigh next to nothing, but something: a vertex of them only has a label too
    weights = np.repeat(np.maximum(mesh.face_areas, 1e-30), 3)[order]
    area = np.add.reduceat(weights, starts)
    vertex, label = code[starts] // n, code[starts] % n
    best = np.lexsort((-label, area, vertex))  # the largest comes last and stays
    out = np.full(mesh.n_vertices, -1, dtype=np.int64)
    out[vertex[best]] = label[best]
    return np.where(out == n - 1, -1, out)


def same_place(vertices: FloatArray, mesh: Mesh) -> bool:
    """Whether vertices lie where those of the mesh do, but for the rounding of 32-bit floats."""
    if vertices.shape != mesh.vertices.shape:
        return False
    with np.errstate(over="ignore", invalid="ignore"):
        reach = 1e-5 * max(float(np.abs(mesh.vertices).max()), 1e-30)
        return bool((np.abs(vertices - mesh.vertices) <= reach).all())


def label_column(names: Iterable[str], wanted: str | None = None) -> str | None:
    """The one among the names of columns that holds labels: ``wanted``, or else the most usual name.

    Case doesn't matter, nor what CloudCompare puts before a name.

    Examples
    --------
    >>> label_column(["x", "scalar_Label"]), label_column(["x", "Hue"], "hue")
    ('scalar_Label', 'Hue')
    """
    known = {name.lower(): name for name in reversed(list(names))}
    known = {name.removeprefix("scalar_"): full for name, full in known.items()} | known
    tried = LABEL_NAMES if wanted is None else (wanted.lower(), wanted.lower().removeprefix("scalar_"))
    return next((known[name] for name in tried if name in known), None)


def no_labels(path: Path, names: Iterable[str], wanted: str | None) -> FormatError:
    """That none of the columns of a file is one of labels."""
    tried = ", ".join(LABEL_NAMES[:8]) + ", …" if wanted is None else wanted
    return FormatError(
        f"{path.name!r} has no labels: none of its properties ({', '.join(names)[:300]}) is called {tried}; "
        "property= names another"
    )


def whole_numbers(values: npt.NDArray[Any], name: str) -> IntArray:
    """Labels as int64, -1 for NaN; FormatError if others are no whole numbers."""
    if values.dtype.kind == "f":
        values = np.where(np.isnan(values), -1.0, values)
        if not (np.isfinite(values) & (values == np.floor(values)) & (np.abs(values) < 2**53)).all():
            raise FormatError(f"holds values of {name!r} that are not whole numbers")
    return values.astype(np.int64)
