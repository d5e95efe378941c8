"""What crosses between a view and the browser: arrays as bytes, and messages.

**Arrays.** Each is a trait of bytes; the trait ``_headers`` says its dtype and shape. Geometry crosses once.
Labels cross as *atoms*, the common refinement of all levels and segments, so that an edit sends one small
table. The twin of this module in the front end is ``js/src/wire/wire.js``.

**Messages from the browser**, received with ``view.on_msg(lambda view, message, buffers: ...)``:

``{"kind": "cancel"}``
    Cancel was pressed. The view goes on showing ``busy`` until Python sets it to False.

Only in ``mode="edit"``; faces are those of the mesh as given, ``level`` a name out of ``levels``,
``revision`` the number of the segments that the person was looking at (``view.revision``):

``{"kind": "merge", "face": 12, "onto_face": 40, "level": "final", "revision": 3}``
    ``face`` is a list where a brush has gathered several parts.
``{"kind": "split", "face": 12, "level": "final", "revision": 3}``
``{"kind": "cut", "face_a": 12, "face_b": 40, "revision": 3}``
    Divide the segment under both; shown only once Python brings the new segments.
``{"kind": "paint", "ranges": [12, 40], "onto_face": 7, "revision": 3}``
    Also ``slice``, ``grow``, ``shrink``, ``fill_holes``, ``smooth_border`` with the fields of those edits;
    the ``point`` of a slice counts from `middle_of` the mesh. They name faces of the scan alone, so they are
    done whatever segmentation has come meanwhile.
``{"kind": "relabel", "face": 12, "name": "chair", "revision": 3}``
``{"kind": "group", "face": [12, 40], "onto_face": 7, "revision": 3}``
    Without ``onto_face`` (null) they are part of nothing any more.
``{"kind": "suggest", "do": "next", "number": 0}``
    Or "accept", "skip", "close": of the ``suggestion`` that has this number; or "names": give those that the
    shapes tell.
``{"kind": "undo"}``, ``{"kind": "redo"}``, ``{"kind": "go_to", "n": 5}``
    The last one: undo or redo until so many edits are done.

Not counted as edits, and possible in either mode:

``{"kind": "save"}``
    The Save button or Ctrl + S.
``{"kind": "choose", "notice": key, "action": action}``
    A button of a notice.
``{"kind": "preview_cut", "face_a": 12, "face_b": 40, "revision": 3, "request": "a1"}``
    What would a cut divide off? Only if ``editable``. To be answered by
    ``view.send({"kind": "cut_preview", "request": "a1", "first": 30}, [bits])``, a bit for each face from
    the first one on, the lowest bit of a byte first; without any, there is nothing to show.

``{"kind": "preview_edit", "edit": {"kind": "grow", "face": 12}, "request": "a2"}``
    Which faces would an edit face by face move? To be answered by ``{"kind": "edit_preview", "request": "a2",
    "first": 30, "reason": ""}`` and bits as above; ``reason`` says why it can't be done.

If ``editable``, each also has ``client`` and ``number``: the browser shows the edit at once and goes on
doing so, on top of whatever segments come, until `SceneView.answer` says that the message has been dealt
with. So ``revision`` may be older than the view's: the person saw that one with their own later edits on top.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray, Mesh

__all__ = [
    "UNLABELED",
    "compact",
    "face_bits",
    "geometry",
    "header",
    "middle_of",
    "unit_codes",
    "unlabeled_as_most",
    "unpacked",
]

UNLABELED = 0xFFFFFFFF  # stands for -1 in the tables that cross to the browser


def header(array: npt.NDArray[Any]) -> dict[str, Any]:
    """What ``_headers`` says of an array.

    Examples
    --------
    >>> import numpy as np
    >>> header(np.zeros((4, 3), np.uint8))
    {'dtype': 'uint8', 'shape': [4, 3]}
    """
    return {"dtype": array.dtype.name, "shape": list(array.shape)}


def unpacked(data: bytes, header: dict[str, Any]) -> npt.NDArray[Any]:
    """The array that some bytes are, with its header.

    Examples
    --------
    >>> unpacked(bytes([1, 0, 2, 0]), {"dtype": "uint16", "shape": [2]}).tolist()
    [1, 2]
    """
    return np.frombuffer(data, header["dtype"]).reshape(header["shape"])


def middle_of(mesh: Mesh) -> FloatArray:
    """(3,) what the browser counts coordinates from, in those of the mesh.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> middle_of(analytic.square(2)).tolist()
    [0.5, 0.5, 0.0]
    """
    middle: FloatArray = (mesh.bounds[0] + mesh.bounds[1]) / 2
    return middle


def geometry(mesh: Mesh) -> dict[str, npt.NDArray[Any]]:
    """Arrays of the mesh as the browser takes them.

    Vertices are float32 around the middle of the faces: an origin far away, as in geographic coordinates,
    would eat the precision. Of a cloud cross areas and normals, rows of four bytes of which the last says
    whether their side is known rather than guessed.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> sorted(geometry(mesh)), geometry(mesh)["faces"].dtype
    (['faces', 'vertices'], dtype('uint32'))
    """
    middle = middle_of(mesh)
    vertices = np.where(mesh.is_used[:, None], mesh.vertices - middle, 0.0).astype(np.float32)
    arrays: dict[str, npt.NDArray[Any]] = {"vertices": vertices}
    if isinstance(mesh, PointCloud):
        normals = np.zeros((mesh.n_faces, 4), np.int8)
        normals[:, :3] = np.rint(127 * mesh.face_normals)
        normals[:, 3] = 127 * mesh.has_sides
        areas = mesh.face_areas if mesh.spacing > 0 else np.full(mesh.n_faces, 1e-6)
        arrays |= {"areas": areas.astype(np.float32), "normals": normals}
    else:
        arrays["faces"] = mesh.faces.astype(np.uint32)
    if mesh.vertex_colors is not None:
        arrays["vertex_colors"] = mesh.vertex_colors
    return arrays


def unlabeled_as_most(labels: IntArray) -> npt.NDArray[np.uint32]:
    """Labels as uint32, where -1 becomes `UNLABELED`.

    Examples
    --------
    >>> import numpy as np
    >>> unlabeled_as_most(np.array([0, -1])).tolist()
    [0, 4294967295]
    """
    return labels.astype(np.uint32)


def compact(labels: IntArray, n: int) -> npt.NDArray[Any]:
    """(n_faces,) labels in as few bytes as they need, n for those without.

    Examples
    --------
    >>> import numpy as np
    >>> compact(np.array([2, -1, 0]), 3)
    array([2, 3, 0], dtype=uint16)
    """
    return np.where(labels >= 0, labels, n).astype(np.uint16 if n < 2**16 else np.uint32)


def unit_codes(values: FloatArray) -> npt.NDArray[np.uint16]:
    """Numbers from 0 to 1 as 1 to 65535; NaN as 0.

    Examples
    --------
    >>> import numpy as np
    >>> unit_codes(np.array([0.0, 1.0, np.nan])).tolist()
    [1, 65535, 0]
    """
    codes = np.where(np.isnan(values), 0, np.rint(1 + 65534 * values))
    return np.asarray(codes, np.uint16)


def face_bits(faces: IntArray) -> tuple[int, bytes]:
    r"""A set of faces as its first face and a bit for each face from there to the last.

    Parameters
    ----------
    faces : (n,) int
        Ascending; may be empty.

    Examples
    --------
    >>> import numpy as np
    >>> face_bits(np.array([30, 31, 33]))
    (30, b'\x0b')
    """
    if len(faces) == 0:
        return 0, b""
    first = int(faces[0])
    is_in: BoolArray = np.zeros(int(faces[-1]) - first + 1, bool)
    is_in[faces - first] = True
    return first, np.packbits(is_in, bitorder="little").tobytes()
