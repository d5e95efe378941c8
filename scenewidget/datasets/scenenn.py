"""SceneNN: real rooms with a label a vertex and the names of the objects.

Go in: the PLY and the XML of a scene. Come out: the mesh and its truth. Hua, Pham, Nguyen, Tran, Yu and
Yeung (2016), *SceneNN: a scene meshes dataset with annotations*, 3DV. The data is not ours to ship; its
authors give it out at https://github.com/hkust-vgd/scenenn for education and research.

The format: ``016/016.ply`` is a triangle mesh whose vertices carry a property ``label``, the id of an
object. ``016/016.xml`` holds ``<label id="…" text="chair 1" nyu_class="chair" …/>`` elements below its
root, one an id.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, BinaryIO, Literal
from xml.etree import ElementTree

import numpy as np

from scenewidget.engine.mesh import IntArray, Mesh, MeshError
from scenewidget.engine.readers import load_mesh
from scenewidget.engine.segmentation import Segmentation

__all__ = ["load_scenenn"]

Unnamed = Literal["unlabeled", "segments"]

MAX_XML_BYTES = 16_000_000  # those of SceneNN have some ten thousand
PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
PLY_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}


def load_scenenn(
    ply_path: str | os.PathLike[str],
    xml_path: str | os.PathLike[str] | None = None,
    *,
    unnamed: Unnamed = "unlabeled",
) -> tuple[Mesh, Segmentation]:
    """A scene of SceneNN and its objects.

    Parameters
    ----------
    ply_path : path
        Mesh with a ``label`` a vertex.
    xml_path : path, optional
        Names of the objects; by default the file beside the PLY that is called the same, if there is one.
        Without any, each label is a segment without a name.
    unnamed : "unlabeled" | "segments"
        What becomes of vertices whose label the XML does not list, or lists without text and class:
        nobody said what they are. Unlabeled, or segments like the others, without a name.

    Returns
    -------
    mesh : Mesh
        All faces, in the order of the file.
    truth : Segmentation
        A face belongs to the object of at least two of its corners; where all three differ, to the middle
        one by id. Named by the text, else by the NYU class.

    Raises
    ------
    FileNotFoundError
        No such PLY or XML.
    MeshError
        A damaged file, vertices without labels, an XML of another scene, or one with a DOCTYPE, which
        could define entities that expand without end.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh, objects = sw.datasets.load_scenenn("036.ply")  # doctest: +SKIP
    """
    if unnamed not in ("unlabeled", "segments"):
        raise ValueError(f"unnamed must be 'unlabeled' or 'segments', got {unnamed!r}")
    ply = Path(ply_path)
    if ply.suffix.lower() != ".ply":
        raise MeshError(f"a scene of SceneNN is a .ply file, got {ply.name!r}")
    mesh = load_mesh(ply)
    vertex_ids = _read_vertex_labels(ply)
    if len(vertex_ids) != mesh.n_vertices:
        raise MeshError(f"{ply.name!r} has {mesh.n_vertices} vertices, but {len(vertex_ids)} labels")
    face_ids = np.sort(vertex_ids[mesh.faces], axis=1)[:, 1]
    xml = Path(xml_path) if xml_path is not None else ply.with_suffix(".xml")
    if xml_path is None and not xml.exists():
        return mesh, Segmentation.from_labels(mesh, np.unique(face_ids, return_inverse=True)[1])
    names = _read_names(xml)
    ids, index = np.unique(face_ids, return_inverse=True)
    if not any(id_ in names for id_ in ids.tolist()):
        raise MeshError(
            f"{xml.name!r} names {len(names)} labels, but none of the {len(ids)} in {ply.name!r}: "
            "do they belong to the same scene?"
        )
    found = [names.get(id_, "") for id_ in ids.tolist()]
    if unnamed == "unlabeled":
        has_name = np.array([name != "" for name in found])
        index = np.where(has_name[index], index, -1)
    return mesh, Segmentation.from_labels(mesh, index, names=found)


def _read_names(path: Path) -> dict[int, str]:
    """Name of each label id; "" where the annotation says nothing."""
    if not path.exists():
        raise FileNotFoundError(f"annotation file {str(path)!r} does not exist")
    size = path.stat().st_size
    if size > MAX_XML_BYTES:
        raise MeshError(
            f"{path.name!r} has {size} bytes; an annotation of SceneNN has at most {MAX_XML_BYTES}"
        )
    parser = ElementTree.XMLParser(target=_PlainTree())
    try:
        root = ElementTree.parse(path, parser).getroot()
    except ElementTree.ParseError as error:
        raise MeshError(f"{path.name!r} is damaged or not XML ({error})") from error
    except (ValueError, LookupError) as error:  # an encoding that does not exist or does not fit
        if isinstance(error, MeshError):
            raise MeshError(f"{path.name!r} {error}") from None
        raise MeshError(f"{path.name!r} is damaged or not XML ({error})") from error
    names: dict[int, str] = {}
    for element in root.findall("label"):
        id_ = element.get("id", "")
        if not (id_.isascii() and id_.isdigit()) or len(id_) > 18:
            raise MeshError(f"{path.name!r} has a label with id {id_!r}; ids must be whole numbers from 0")
        if int(id_) in names:
            raise MeshError(f"{path.name!r} has two labels with id {id_}")
        names[int(id_)] = (element.get("text") or "").strip() or (element.get("nyu_class") or "").strip()
    if not names:
        raise MeshError(f"{path.name!r} holds no <label id=…> below its root: it is no annotation of SceneNN")
    return names


class _PlainTree(ElementTree.TreeBuilder):
    """Builds a tree, unless the file starts to define a document type."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise MeshError(f"declares a DOCTYPE ({name}), which an annotation has no use for; it is not read")


# --- the label column of a PLY --------------------------------------------------------------------


def _read_vertex_labels(path: Path) -> IntArray:
    """(n_vertices,) int64; load_mesh reads geometry and colours only."""
    with path.open("rb") as file:
        order, elements = _read_header(file, path.name)
        for name, count, properties in elements:
            if name == "vertex":
                break
            if any(type_ is None for _, type_ in properties):
                raise MeshError(f"{path.name!r} has lists before its vertices, which no scene of SceneNN has")
            _skip(file, order, count, properties)
        else:
            raise MeshError(f"{path.name!r} has no vertices")
        columns = [column for column, _ in properties]
        if "label" not in columns:
            raise MeshError(
                f"{path.name!r} has no property 'label' on its vertices, only {', '.join(columns)}: "
                "it is not an annotated scene of SceneNN; load_mesh reads its geometry"
            )
        if any(type_ is None for _, type_ in properties):
            raise MeshError(f"{path.name!r} has lists on its vertices, which no scene of SceneNN has")
        if order == "":
            column = columns.index("label")
            rows = (file.readline().split() for _ in range(count))
            try:
                labels = np.array([float(row[column]) for row in rows])
            except (IndexError, ValueError) as error:
                raise MeshError(f"{path.name!r} is damaged: a vertex has no number as its label") from error
        else:
            layout = _layout(order, properties)
            block = file.read(count * layout.itemsize)
            if len(block) < count * layout.itemsize:
                raise MeshError(f"{path.name!r} is truncated inside its vertices")
            labels = np.frombuffer(block, layout)["label"]
    if labels.dtype.kind == "f" and not (np.isfinite(labels) & (labels == np.floor(labels))).all():
        raise MeshError(f"{path.name!r} has labels that are not whole numbers")
    return labels.astype(np.int64)


Properties = list[tuple[str, str | None]]  # name and numpy type, None for a list


def _read_header(file: BinaryIO, name: str) -> tuple[str, list[tuple[str, int, Properties]]]:
    """Byte order ("" for text) and the elements; load_mesh has checked that the header ends and fits."""
    order = None
    elements: list[tuple[str, int, Properties]] = []
    for line in file:
        words = line.decode("ascii", "replace").split()
        if words == ["end_header"]:
            break
        if words[:1] == ["format"] and len(words) > 1:
            order = PLY_ORDERS.get(words[1])
        elif words[:1] == ["element"] and len(words) == 3:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"] and elements and len(words) > 2:
            if words[1] != "list" and words[1] not in PLY_TYPES:
                raise MeshError(f"{name!r} has a property of type {words[1]!r}, which PLY does not know")
            elements[-1][2].append((words[-1], PLY_TYPES.get(words[1])))
    else:
        raise MeshError(f"{name!r} is damaged: its header has no end")
    if order is None:
        raise MeshError(f"{name!r} has no format that PLY knows")
    return order, elements


def _layout(order: str, properties: Properties) -> np.dtype[Any]:
    # columns other than the label get names of their own: files may repeat theirs
    fields = [
        ("label" if name == "label" else f"{k}", f"{order}{type_}")
        for k, (name, type_) in enumerate(properties)
    ]
    return np.dtype(fields)


def _skip(file: BinaryIO, order: str, count: int, properties: Properties) -> None:
    if order == "":
        for _ in range(count):
            file.readline()
    else:
        file.seek(count * _layout(order, properties).itemsize, os.SEEK_CUR)
