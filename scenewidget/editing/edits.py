"""Edits: what a person did, in words that outlive any numbering of segments.

Each edit names faces of the mesh as loaded, never segments or parts, so that a log of edits can be replayed
on another segmentation of the same mesh. Küçükdemir (2020), thesis 3.6, with names and cuts on top.
"""

from __future__ import annotations

import dataclasses
import math
import operator
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenewidget.editing.face_set import FaceSet
from scenewidget.engine.checks import checked_count
from scenewidget.engine.segmentation import LEVELS, Level

__all__ = [
    "Cut",
    "Edit",
    "EditError",
    "FillHoles",
    "Group",
    "Grow",
    "Merge",
    "Paint",
    "Relabel",
    "Shrink",
    "Slice",
    "SmoothBorder",
    "Split",
    "edit_from_dict",
    "edit_to_dict",
    "edit_values",
    "kind_of",
]

MAX_NAME = 200  # the longest name of a segment, in characters
MAX_FACES = 100_000  # the most faces that one merge may name
MOST_RINGS = 1_000  # of one edit


class EditError(ValueError):
    """An edit that can't be done here; the message says why.

    Examples
    --------
    >>> Cut(3, 3)
    Traceback (most recent call last):
        ...
    scenewidget.editing.edits.EditError: face_a and face_b are both 3: a cut needs two different faces
    """


@dataclass(frozen=True)
class Merge:
    """The parts under ``faces`` join the segment under ``onto_face``.

    At the level "final" a part is the whole segment that the face is in now. At "dihedral" and "base" it is
    the part of that level, wherever its faces are now.

    Examples
    --------
    >>> Merge([4, 9], onto_face=2, level="base").title
    'Merge 2 parts'
    >>> Merge(4, onto_face=2)
    Merge(faces=(4,), onto_face=2, level='final')
    """

    faces: tuple[int, ...]
    onto_face: int
    level: Level = "final"

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", _faces(self.faces, "merge"))
        object.__setattr__(self, "onto_face", _face("onto_face", self.onto_face))
        _check_level(self.level)

    @property
    def title(self) -> str:
        """What a history shows."""
        return "Merge" if len(self.faces) == 1 else f"Merge {len(self.faces)} parts"


@dataclass(frozen=True)
class Split:
    """The part under ``face`` becomes a segment of its own.

    At "dihedral" and "base" that is the part of the level, wherever its faces are now. At "final" it is
    what the segment under the face has from one automatic segment: a piece that was merged comes off again.
    Where ``also`` names more faces, their parts go along, and of all of them only what is in the segment
    under ``face`` moves.

    Examples
    --------
    >>> Split(3, "base")
    Split(face=3, level='base', also=())
    """

    face: int
    level: Level = "final"
    also: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "face", _face("face", self.face))
        _check_level(self.level)
        also = tuple(_face("also", face) for face in self.also)
        if len(also) >= MAX_FACES:
            raise ValueError(f"also has {len(also)} entries; one split takes at most {MAX_FACES - 1}")
        object.__setattr__(self, "also", also)

    @property
    def title(self) -> str:
        """What a history shows."""
        return "Split"


@dataclass(frozen=True)
class Relabel:
    """The segment under ``face`` is called ``name``; "" takes its name away.

    Examples
    --------
    >>> Relabel(3, " chair ")
    Relabel(face=3, name='chair')
    """

    face: int
    name: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "face", _face("face", self.face))
        object.__setattr__(self, "name", checked_name(self.name))

    @property
    def title(self) -> str:
        """What a history shows."""
        return f"Name {self.name!r}" if self.name else "Remove name"


@dataclass(frozen=True)
class Group:
    """The segments under ``faces`` are parts of the one under ``onto_face``: cushions of a sofa.

    They stay segments. A part of a part is one of the whole: what has parts brings them along, and a part
    that others are put onto stands for its whole, unless the whole is put onto it. Without ``onto_face``
    they are part of nothing any more; a whole lets go of its parts.

    Examples
    --------
    >>> Group([4, 9], onto_face=2).title
    'Group'
    >>> Group(4)
    Group(faces=(4,), onto_face=None)
    """

    faces: tuple[int, ...]
    onto_face: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", _faces(self.faces, "group"))
        if self.onto_face is not None:
            object.__setattr__(self, "onto_face", _face("onto_face", self.onto_face))

    @property
    def title(self) -> str:
        """What a history shows."""
        return "Ungroup" if self.onto_face is None else "Group"


@dataclass(frozen=True)
class Cut:
    """The segment under both faces is divided along the cheapest boundary between them.

    The side of ``face_a`` stays the segment that it is, the side of ``face_b`` becomes a new one.

    Examples
    --------
    >>> Cut(3, 9).title
    'Cut'
    """

    face_a: int
    face_b: int

    def __post_init__(self) -> None:
        for key in ("face_a", "face_b"):
            object.__setattr__(self, key, _face(key, getattr(self, key)))
        if self.face_a == self.face_b:
            raise EditError(f"face_a and face_b are both {self.face_a}: a cut needs two different faces")

    @property
    def title(self) -> str:
        """What a history shows."""
        return "Cut"


@dataclass(frozen=True)
class Paint:
    """The faces become part of the segment under ``onto_face``, or a new one without a name.

    Whatever segments they are in now, or in none: faces that the method left unlabeled can be painted.

    Examples
    --------
    >>> Paint([3, 4, 5], onto_face=9)
    Paint(faces=FaceSet(3 faces: 3, 4, 5), onto_face=9)
    >>> Paint(range(1000)).title
    'New segment of 1000 faces'
    """

    faces: FaceSet
    onto_face: int | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.faces, FaceSet):
            object.__setattr__(self, "faces", FaceSet(self.faces))
        if self.onto_face is not None:
            object.__setattr__(self, "onto_face", _face("onto_face", self.onto_face))

    @property
    def title(self) -> str:
        """What a history shows."""
        n = len(self.faces)
        what = f"{n} face{'s' if n > 1 else ''}"
        return f"New segment of {what}" if self.onto_face is None else f"Paint {what}"


@dataclass(frozen=True)
class Slice:
    """The segment under ``face`` is divided along a plane; the other side than the face's becomes a new one.

    Each face is on the side of its centroid, and one whose centroid lies in the plane is on the side that
    the normal leaves behind.

    Examples
    --------
    >>> Slice(3, (0, 0, 1.5), (0, 0, 1))
    Slice(face=3, point=(0.0, 0.0, 1.5), normal=(0.0, 0.0, 1.0))
    """

    face: int
    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "face", _face("face", self.face))
        object.__setattr__(self, "point", _vector("point", self.point))
        object.__setattr__(self, "normal", _vector("normal", self.normal))
        if not any(self.normal):
            raise ValueError("normal has length 0: it must say which way the plane faces")

    @property
    def title(self) -> str:
        """What a history shows."""
        return "Slice"


@dataclass(frozen=True)
class Grow:
    """The segment under ``face`` takes the faces around it, so many rings of them.

    Examples
    --------
    >>> Grow(3, rings=2).title
    'Grow'
    """

    face: int
    rings: int = 1

    title = "Grow"
    nothing = "is all that is connected: there is nothing to grow onto"

    def __post_init__(self) -> None:
        object.__setattr__(self, "face", _face("face", self.face))
        object.__setattr__(self, "rings", checked_count("rings", self.rings, most=MOST_RINGS))


@dataclass(frozen=True)
class Shrink:
    """The segment under ``face`` gives its outermost faces, so many ``rings`` of them, to those around it.

    Examples
    --------
    >>> Shrink(3).title
    'Shrink'
    """

    face: int
    rings: int = 1

    title = "Shrink"
    nothing = "touches no other segment that could take its faces"

    def __post_init__(self) -> None:
        object.__setattr__(self, "face", _face("face", self.face))
        object.__setattr__(self, "rings", checked_count("rings", self.rings, most=MOST_RINGS))


@dataclass(frozen=True)
class FillHoles:
    """The segment under ``face`` takes what it encloses, pieces of at most ``max_faces`` faces.

    Examples
    --------
    >>> FillHoles(3, max_faces=20).title
    'Fill holes'
    """

    face: int
    max_faces: int = 100

    title = "Fill holes"

    def __post_init__(self) -> None:
        object.__setattr__(self, "face", _face("face", self.face))
        object.__setattr__(self, "max_faces", checked_count("max_faces", self.max_faces, most=2**31 - 1))

    @property
    def nothing(self) -> str:
        """Said where it changes nothing."""
        return f"has no hole of at most {self.max_faces} faces"


@dataclass(frozen=True)
class SmoothBorder:
    """The border of the segment under ``face`` loses its teeth; more rounds smooth larger ones.

    Examples
    --------
    >>> SmoothBorder(3).title
    'Smooth border'
    """

    face: int
    rounds: int = 3

    title = "Smooth border"
    nothing = "has a smooth border already"

    def __post_init__(self) -> None:
        object.__setattr__(self, "face", _face("face", self.face))
        object.__setattr__(self, "rounds", checked_count("rounds", self.rounds, most=MOST_RINGS))


Edit = Merge | Split | Relabel | Group | Cut | Paint | Slice | Grow | Shrink | FillHoles | SmoothBorder
_KINDS: dict[str, type[Edit]] = {
    "merge": Merge,
    "split": Split,
    "relabel": Relabel,
    "group": Group,
    "cut": Cut,
    "paint": Paint,
    "slice": Slice,
    "grow": Grow,
    "shrink": Shrink,
    "fill_holes": FillHoles,
    "smooth_border": SmoothBorder,
}


def kind_of(edit: Edit) -> str:
    """What an edit is called in files and tables.

    Examples
    --------
    >>> kind_of(FillHoles(3))
    'fill_holes'
    """
    return next(name for name, kind in _KINDS.items() if type(edit) is kind)


def edit_values(edit: Edit) -> dict[str, Any]:
    """The kind of an edit and its fields; a set of faces as an array of its ranges.

    Examples
    --------
    >>> edit_values(Paint([3, 4]))
    {'kind': 'paint', 'ranges': array([3, 5]), 'onto_face': None}
    """
    values: dict[str, Any] = {"kind": kind_of(edit)}
    for field in dataclasses.fields(edit):
        value = getattr(edit, field.name)
        if isinstance(value, FaceSet):
            values["ranges"] = value.ranges
        elif value != ():  # which says nothing
            values[field.name] = list(value) if isinstance(value, tuple) else value
    return values


def edit_to_dict(edit: Edit) -> dict[str, Any]:
    """The edit as plain data for JSON: its fields and its ``kind``.

    Examples
    --------
    >>> edit_to_dict(Split(3, "base"))
    {'kind': 'split', 'face': 3, 'level': 'base'}
    """
    return {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in edit_values(edit).items()
    }


def edit_from_dict(data: Any) -> Edit:
    """The edit behind plain data, as of `edit_to_dict`.

    Raises
    ------
    ValueError, TypeError
        Not the data of an edit.

    Examples
    --------
    >>> edit_from_dict({"kind": "cut", "face_a": 3, "face_b": 9})
    Cut(face_a=3, face_b=9)
    """
    if not isinstance(data, Mapping) or data.get("kind") not in _KINDS:
        raise ValueError(
            f"an edit must be a mapping with a kind out of {', '.join(_KINDS)}, got {data!r:.200}"
        )
    kind = _KINDS[data["kind"]]
    values = {key: value for key, value in data.items() if key != "kind"}
    allowed = {field.name for field in dataclasses.fields(kind)}
    if kind is Paint and "ranges" in values and "faces" not in values:
        values["faces"] = FaceSet.from_ranges(values.pop("ranges"))
    if values.keys() - allowed:
        raise ValueError(f"a {data['kind']} has no field {sorted(values.keys() - allowed)[0]!r:.200}")
    try:
        return kind(**values)
    except TypeError as error:
        raise TypeError(f"damaged {data['kind']}: {error}") from None


def checked_name(name: Any) -> str:
    """A segment's name without surrounding blanks, composed (NFC).

    Raises
    ------
    TypeError
        Not a text.
    ValueError
        Too long, or with characters that no file can hold (control characters, lone surrogates).

    Examples
    --------
    >>> checked_name("  office chair ")
    'office chair'
    """
    if not isinstance(name, str):
        raise TypeError(f"name must be a text, got {type(name).__name__}")
    clean = unicodedata.normalize("NFC", name).strip()
    if len(clean) > MAX_NAME:
        raise ValueError(f"name must have at most {MAX_NAME} characters, got {len(clean)}")
    for character in clean:
        if unicodedata.category(character) in ("Cc", "Cs"):
            raise ValueError(f"name must hold no control characters, got {name!r}")
    return clean


def _face(name: str, value: Any) -> int:
    try:
        if isinstance(value, bool):
            raise TypeError
        face = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be the number of a face, got {value!r:.200}") from None
    if not 0 <= face < 2**31:
        raise ValueError(f"{name} must be the number of a face, from 0, got {face}")
    return face


def _faces(value: Any, what: str) -> tuple[int, ...]:
    """One face or several of them, each once."""
    several = (value,) if not isinstance(value, (list, tuple)) and np.ndim(value) == 0 else value
    if isinstance(several, bytes) or not isinstance(several, Iterable):
        raise TypeError(f"faces must be a face or a sequence of faces, got {value!r:.200}")
    checked = tuple(dict.fromkeys(_checked_faces("faces", several)))
    if not checked:
        raise ValueError(f"faces is empty: a {what} needs at least one part to move")
    if len(checked) > MAX_FACES:
        raise ValueError(f"faces has {len(checked)} entries; one {what} takes at most {MAX_FACES}")
    return checked


def _checked_faces(name: str, values: Iterable[Any]) -> Iterable[int]:
    """Numbers of faces; a long stroke of plain ones is looked at as a whole, in a tenth of the time."""
    plain = values.tolist() if isinstance(values, np.ndarray) and values.dtype.kind in "iu" else list(values)
    if {*map(type, plain)} == {int} and min(plain) >= 0 and max(plain) < 2**31:
        return plain
    return [_face(name, value) for value in plain]


def _vector(name: str, value: Any) -> tuple[float, float, float]:
    try:
        numbers = tuple(float(part) for part in value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be three numbers, got {value!r:.200}") from None
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ValueError(f"{name} must be three finite numbers, got {value!r:.200}")
    return numbers


def _check_level(level: Any) -> None:
    if level not in LEVELS:
        raise ValueError(f"level must be one of {', '.join(map(repr, LEVELS))}, got {level!r:.200}")
