"""SceneNN: a PLY with a ``label`` a vertex and an XML that says what each label is.

Hua et al. (2016), *SceneNN: a scene meshes dataset with annotations*, 3DV. Segments without a name are
called "segment 3" in the XML, because readers take labels without text for unannotated; label 0 is what no
segment has. `scenewidget.datasets.scenenn` reads mesh and truth of the original scenes.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from scenewidget.editing.formats.common import (
    FormatError,
    Labels,
    clean_name,
    same_place,
    vertices_from_faces,
    whole_numbers,
)
from scenewidget.editing.formats.seal import SEAL, Contents, check_one_set
from scenewidget.editing.vocabulary import nyu_class
from scenewidget.engine.mesh import FloatArray, Mesh
from scenewidget.engine.moments import mean_normals
from scenewidget.engine.readers.ply import columns_of
from scenewidget.engine.segmentation import Segmentation
from scenewidget.palette import segment_colors

__all__ = ["read", "write"]

MAX_XML_BYTES = 16_000_000


def write(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """Both files; see `export`. Labels are 1, 2, … in the order of the segments."""
    scene, annotation = path.with_suffix(".ply"), path.with_suffix(".xml")
    labels = vertices_from_faces(segmentation.labels, mesh) + 1
    colors = segment_colors(segmentation)
    seen = colors[labels - 1] if mesh.vertex_colors is None else mesh.vertex_colors
    label_type = ("ushort", "<u2") if segmentation.n_segments < 2**16 - 1 else ("uint", "<u4")
    columns = [(axis, "float", "<f4") for axis in ("x", "y", "z", "nx", "ny", "nz")]
    columns += [(name, "uchar", "u1") for name in ("red", "green", "blue")]
    columns.append(("label", *label_type))
    vertices = np.zeros(mesh.n_vertices, dtype=[(name, layout) for name, _, layout in columns])
    normals = _vertex_normals(mesh)
    for k in range(3):
        vertices["xyz"[k]] = mesh.vertices[:, k]
        vertices["n" + "xyz"[k]] = normals[:, k]
        vertices[("red", "green", "blue")[k]] = seen[:, k]
    vertices["label"] = labels
    faces = np.zeros(0 if mesh.is_cloud else mesh.n_faces, dtype=[("n", "u1"), ("corners", "(3,)<i4")])
    faces["n"], faces["corners"] = 3, mesh.faces[: len(faces)]
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment {SEAL}",
        f"element vertex {mesh.n_vertices}",
    ]
    header += [f"property {type_} {name}" for name, type_, _ in columns]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"]
    rows = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f"<!-- {SEAL} -->",
        f"<annotation name={_attribute(path.stem)}>",
    ]
    boxes = _boxes(mesh, labels, segmentation.n_segments)
    for k, name in enumerate(segmentation.names):
        if not np.isfinite(boxes[k]).all():
            continue  # so small that no vertex has it
        rows.append(
            f'  <label id="{k + 1}" color="{" ".join(map(str, colors[k].tolist()))}" '
            f"text={_attribute(name or _unnamed(k + 1))} nyu_class={_attribute(nyu_class(name))} "
            f'aabbox="{" ".join(f"{x:.6g}" for x in boxes[k])}"{_part_of(k, segmentation.groups[k])}/>'
        )
    rows.append("</annotation>\n")
    head = "\n".join(header).encode("ascii")
    return {
        scene: [head, vertices.view(np.uint8).data, faces.view(np.uint8).data],
        annotation: ["\n".join(rows).encode()],
    }


def read(path: Path, mesh: Mesh) -> Labels:
    """Labels of the PLY beside an XML (or of the PLY itself) with the names of the XML."""
    scene, annotation = path.with_suffix(".ply"), path.with_suffix(".xml")
    for needed in (scene, annotation):
        if not needed.is_file():
            raise FormatError(f"{path.name!r} needs {needed.name!r} beside it")
    check_one_set(scene, annotation)
    names, groups = _read_names(annotation)
    elements, _ = columns_of(scene)
    vertices = elements.get("vertex", {})
    if "label" not in vertices or len(vertices["label"]) != mesh.n_vertices:
        raise FormatError(
            f"{scene.name!r} has no 'label' for each of the {mesh.n_vertices} vertices of the mesh"
        )
    place = np.stack([vertices.get(axis, np.empty(0)).astype(np.float64) for axis in "xyz"], axis=-1)
    if not same_place(place, mesh):
        raise FormatError(f"{scene.name!r} has other vertices than the mesh")
    labels = whole_numbers(vertices["label"], "label")
    is_known = np.isin(labels, np.array(list(names), dtype=np.int64))
    if not is_known.any():
        raise FormatError(f"{annotation.name!r} names none of the labels in {scene.name!r}")
    return Labels(
        np.where(is_known, labels, -1),
        "vertex",
        names,
        groups,
        report={"vertices whose label the XML does not list": int((~is_known).sum())},
    )


def _part_of(segment: int, whole: int) -> str:
    return "" if whole == segment else f' part_of="{whole + 1}"'


def _unnamed(id_: int) -> str:
    return f"segment {id_}"


def _attribute(text: str) -> str:
    """Quoted for XML, without the characters that XML can't hold."""
    allowed = "".join(c for c in clean_name(text) if c not in "\ufffe\uffff")
    return quoteattr(allowed)


def _vertex_normals(mesh: Mesh) -> npt.NDArray[np.float32]:
    """(n_vertices, 3) area-weighted mean of the faces around each vertex, unit or zero."""
    normals = mean_normals(np.repeat(mesh.face_vectors, 3, axis=0), mesh.faces.ravel(), mesh.n_vertices)
    return normals.astype(np.float32)


def _boxes(mesh: Mesh, labels: npt.NDArray[np.integer[npt.NBitBase]], n: int) -> FloatArray:
    """(n, 6) lowest and highest corner of the vertices of each label from 1; inf where it has none."""
    low, high = np.full((n + 1, 3), np.inf), np.full((n + 1, 3), -np.inf)
    np.minimum.at(low, labels, mesh.vertices)
    np.maximum.at(high, labels, mesh.vertices)
    return np.concatenate([low, high], axis=1)[1:]


def _read_names(path: Path) -> tuple[dict[int, str], dict[int, int]]:
    """Name of each label, "" where it only has what `write` gives to unnamed ones; and wholes of parts."""
    size = path.stat().st_size
    if size > MAX_XML_BYTES:
        raise FormatError(f"{path.name!r} has {size} bytes; an annotation has at most {MAX_XML_BYTES}")
    try:
        root = ElementTree.fromstring(path.read_bytes(), ElementTree.XMLParser(target=_PlainTree()))
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        if isinstance(error, FormatError):
            raise FormatError(f"{path.name!r} {error}") from None
        raise FormatError(f"{path.name!r} is damaged or not XML ({error!s:.200})") from error
    names: dict[int, str] = {}
    groups: dict[int, int] = {}
    for element in root.iter("label"):
        id_ = element.get("id", "")
        if not (id_.isascii() and id_.isdigit()) or len(id_) > 9 or int(id_) in names:
            raise FormatError(
                f"{path.name!r} has a label with id {id_!r:.60}; ids are whole numbers, each once"
            )
        text = clean_name(element.get("text") or element.get("nyu_class") or "")
        names[int(id_)] = "" if text == _unnamed(int(id_)) else text
        whole = element.get("part_of", "")
        if whole.isascii() and whole.isdigit() and len(whole) <= 9:
            groups[int(id_)] = int(whole)
    if not names:
        raise FormatError(f"{path.name!r} holds no <label id=…>: it is no annotation of SceneNN")
    return names, groups


class _PlainTree(ElementTree.TreeBuilder):
    """Builds a tree, unless the file starts to define a document type, and with it entities."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise FormatError(
            f"declares a DOCTYPE ({name:.60}), which an annotation has no use for; it is not read"
        )
