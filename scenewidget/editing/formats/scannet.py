"""ScanNet: ``<scene>.segs.json`` cuts the vertices into small segments, ``<scene>.aggregation.json`` says
which of them make up an object, and its label.

As the annotation tools and the segmentator of https://github.com/ScanNet/ScanNet write them; Dai et al.
(2017), *ScanNet*, CVPR. The small segments that we write are the pieces of base segments (thesis 3.4) that
lie in one object. Objects without a name are called "unannotated". A group of segments is one object, whose
"parts" are our own: the label and the small segments of each of its segments, the whole first. Each has its
upright box, "obb": its middle, the lengths of its sides and, one after the other, unit vectors along them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from scenewidget.editing.formats.common import (
    FormatError,
    Labels,
    clean_name,
    label_column,
    vertices_from_faces,
)
from scenewidget.editing.formats.seal import SEAL, Contents, check_one_set
from scenewidget.engine.boxes import oriented_boxes
from scenewidget.engine.mesh import IntArray, Mesh
from scenewidget.engine.readers.scan import beside
from scenewidget.engine.segmentation import Segmentation

__all__ = ["read", "write"]

AGGREGATION, SEGS = ".aggregation.json", ".segs.json"
UNNAMED = "unannotated"
BYTES_A_VERTEX = 40  # of JSON that a vertex can take


def write(segmentation: Segmentation, mesh: Mesh, path: Path) -> Contents:
    """Both files; see `export`."""
    scene = _scene(path)
    aggregation, segs = path.with_name(scene + AGGREGATION), path.with_name(scene + SEGS)
    objects = vertices_from_faces(segmentation.labels, mesh)
    base = segmentation.levels.get("base")
    pieces = objects if base is None else vertices_from_faces(base, mesh)
    code = (pieces + 1) * (int(objects.max(initial=-1)) + 2) + objects + 1
    _, first, segment = np.unique(code, return_index=True, return_inverse=True)
    segments_of: dict[int, list[int]] = {}
    for number, vertex in enumerate(first.tolist()):
        segments_of.setdefault(int(objects[vertex]), []).append(number)
    whole = np.append(segmentation.groups, -1).astype(np.int64)
    boxes = oriented_boxes(mesh, whole[segmentation.labels], segmentation.n_segments)
    parts_of: dict[int, list[int]] = {}
    for label in sorted((label for label in segments_of if label >= 0), key=lambda s: (s != whole[s], s)):
        parts_of.setdefault(int(whole[label]), []).append(label)
    groups = [
        {
            "id": k,
            "objectId": k,
            "segments": [number for label in parts for number in segments_of[label]],
            "label": segmentation.names[thing] or UNNAMED,
            "obb": {  # as ScanNet++ and 3RScan have it
                "centroid": boxes.center[thing].tolist(),
                "axesLengths": boxes.size[thing].tolist(),
                "normalizedAxes": boxes.axes[thing].ravel().tolist(),
            },
            **_parts(parts, segments_of, segmentation.names),
        }
        for k, (thing, parts) in enumerate(sorted(parts_of.items()))
    ]
    indices = ",".join(map(str, segment.tolist()))
    # kThresh and segMinVerts belong to ScanNet's own segmentator; readers want the key
    head = f'{{"params":{{"kThresh":0,"segMinVerts":0}},"seal":"{SEAL}","sceneId":{json.dumps(scene)},'
    head += '"segIndices":['
    content = {
        "sceneId": scene,
        "appId": "scenewidget",
        "seal": SEAL,
        "segGroups": groups,
        "segmentsFile": segs.name,
    }
    return {
        aggregation: [json.dumps(content, indent=1).encode()],
        segs: [head.encode(), indices.encode(), b"]}"],
    }


def _parts(parts: list[int], segments_of: dict[int, list[int]], names: Sequence[str]) -> dict[str, Any]:
    if len(parts) == 1:
        return {}
    return {"parts": [{"label": names[part] or UNNAMED, "segments": segments_of[part]} for part in parts]}


def read(path: Path, mesh: Mesh) -> Labels:
    """Objects of an aggregation, or without one the small segments of a ``.segs.json``."""
    if _is_of_segments(path.name):
        return Labels(_read_segments(path, mesh), "vertex")
    data = _read_json(path, 1_000 + 100 * BYTES_A_VERTEX * mesh.n_vertices)
    bare = _bare_labels(data, mesh)
    if bare is not None:
        return bare
    groups = data.get("segGroups") if isinstance(data, dict) else None
    if not isinstance(groups, list):
        raise FormatError(f"{path.name!r} has no list 'segGroups': it is no aggregation of ScanNet")
    beside = _segments_file(path, data.get("segmentsFile"))
    check_one_set(path, beside)
    segment = _read_segments(beside, mesh)
    object_of: dict[int, int] = {}
    names: dict[int, str] = {}
    whole_of: dict[int, int] = {}
    twice = 0
    for group in groups:
        thing = len(names)
        for part in [group, *_parts_of(group)]:
            if not isinstance(part, dict) or not isinstance(part.get("segments"), list):
                raise FormatError(f"{path.name!r} has a group without a list 'segments'")
            k, is_thing = len(names), part is group
            label = clean_name(part.get("label", ""))
            names[k] = "" if label == UNNAMED else label
            if not is_thing:
                whole_of[k] = thing
            for number in _whole_numbers(part["segments"], f"{path.name!r} lists segments"):
                twice += is_thing and number in object_of
                object_of[number] = k  # as ScanNet's own scripts: the last group that names a segment has it
    ids, index = np.unique(segment, return_inverse=True)
    known = set(ids.tolist())
    missing = sum(number not in known for number in object_of)
    if object_of and missing == len(object_of):
        raise FormatError(f"none of the segments that {path.name!r} groups is in the file of segments")
    labels = np.array([object_of.get(number, -1) for number in ids.tolist()], dtype=np.int64)[index]
    return Labels(
        labels,
        "vertex",
        names,
        groups=whole_of,
        report={"segments that two objects claim": twice, "segments without vertices": missing},
    )


def _parts_of(group: Any) -> list[Any]:
    """Parts of an object beside the first, which is what remains of it once the others have theirs."""
    parts = group.get("parts") if isinstance(group, dict) else None
    return parts[1:] if isinstance(parts, list) else []


def _is_of_segments(name: str) -> bool:
    """Whether a file's name is that of small segments: of ScanNet, of 3RScan, of ScanNet++."""
    return name.lower().endswith((SEGS, ".segs.v2.json")) or name.lower() == "segments.json"


def _scene(path: Path) -> str:
    for suffix in (AGGREGATION, SEGS, ".json"):
        if path.name.lower().endswith(suffix):
            return path.name[: -len(suffix)]
    return path.name


def _segments_file(path: Path, named: Any) -> Path:
    """The file of segments beside an aggregation. Only its name counts: no path is followed."""
    scene = _scene(path)
    candidates = []
    if isinstance(named, str):
        name = named.replace("\\", "/").rsplit("/", 1)[-1]
        candidates = [name, name.removeprefix("scannet.")]  # as the released files say
    candidates += [scene + SEGS, scene + "_vh_clean_2.0.010000" + SEGS]
    candidates += ["segments.json", "mesh.refined.0.010000.segs.v2.json"]  # of ScanNet++, of 3RScan
    for name in candidates:
        found = beside(path.parent, name) if _is_of_segments(name) else None
        if found is not None:
            return found
    raise FormatError(
        f"{path.name!r} needs its file of segments beside it, called {candidates[0]!r:.100} "
        f"or {scene + SEGS!r:.100}"
    )


def _read_segments(path: Path, mesh: Mesh) -> IntArray:
    data = _read_json(path, 10_000 + BYTES_A_VERTEX * mesh.n_vertices)
    indices = data.get("segIndices") if isinstance(data, dict) else None
    if not isinstance(indices, list):
        raise FormatError(f"{path.name!r} has no list 'segIndices' of whole numbers")
    numbers = _whole_numbers(indices, f"{path.name!r} has a list 'segIndices'")
    if len(indices) != mesh.n_vertices:
        raise FormatError(
            f"{path.name!r} has {len(indices)} vertices, but the mesh has {mesh.n_vertices}: "
            "it belongs to another mesh"
        )
    return np.array(numbers, dtype=np.int64)


def _bare_labels(data: Any, mesh: Mesh) -> Labels | None:
    """Labels of a list, a number a face or vertex, or of a dictionary with such a list under a usual name."""
    name = label_column(data) if isinstance(data, dict) and "segGroups" not in data else None
    values = data if isinstance(data, list) else data[name] if name is not None else None
    if not isinstance(values, list) or len(values) not in (mesh.n_faces, mesh.n_vertices):
        return None
    per: Literal["face", "vertex"] = "face" if len(values) == mesh.n_faces else "vertex"
    return Labels(np.array(_whole_numbers(values, "has a list of labels"), dtype=np.int64), per)


def _whole_numbers(values: list[Any], what: str) -> list[int]:
    """Whole numbers, also where a program wrote them as text or with a point."""
    if all(type(value) is int for value in values):
        return values
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        numbers = np.array([np.nan])
    if numbers.ndim != 1 or not (np.abs(numbers) < 2**53).all() or (numbers != np.floor(numbers)).any():
        raise FormatError(f"{what} that are no whole numbers")
    return [int(number) for number in numbers.tolist()]


def _read_json(path: Path, most: int) -> Any:
    if path.stat().st_size > most:
        raise FormatError(f"{path.name!r} is larger than one of this mesh can be ({most} bytes)")
    try:
        return json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path.name!r} is damaged or no JSON ({error!s:.200})") from error
