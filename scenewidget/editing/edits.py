"""Edits: what a person did, in words that outlive any numbering of segments.

Each edit names faces of the mesh as loaded, never segments or parts, so that a log of edits can be replayed
on another segmentation of the same mesh. Küçükdemir (2020), thesis 3.6, with names and cuts on top.
"""

from __future__ import annotations

import dataclasses
import operator
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenewidget.engine.segmentation import LEVELS, Level

__all__ = ["Cut", "Edit", "EditError", "Merge", "Relabel", "Split", "edit_from_dict", "edit_to_dict"]

MAX_NAME = 200  # the longest name of a segment, in characters
MAX_FACES = 100_000  # the most faces that one brush stroke may name


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
        faces: Any = self.faces
        if not isinstance(faces, (list, tuple)) and np.ndim(faces) == 0:  # a single face
            faces = (faces,)
        if isinstance(faces, bytes) or not isinstance(faces, Iterable):
            raise TypeError(f"faces must be a face or a sequence of faces, got {self.faces!r:.200}")
        checked = tuple(dict.fromkeys(_checked_faces("faces", faces)))
        if not checked:
            raise ValueError("faces is empty: a merge needs at least one part to move")
        if len(checked) > MAX_FACES:
            raise ValueError(f"faces has {len(checked)} entries; one merge takes at most {MAX_FACES}")
        object.__setattr__(self, "faces", checked)
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


Edit = Merge | Split | Relabel | Cut
_KINDS: dict[str, type[Edit]] = {"merge": Merge, "split": Split, "relabel": Relabel, "cut": Cut}


def edit_to_dict(edit: Edit) -> dict[str, Any]:
    """The edit as plain data for JSON: its fields and its ``kind``.

    Examples
    --------
    >>> edit_to_dict(Split(3, "base"))
    {'kind': 'split', 'face': 3, 'level': 'base'}
    """
    data: dict[str, Any] = {"kind": type(edit).__name__.lower()}
    for field in dataclasses.fields(edit):
        value = getattr(edit, field.name)
        if value == ():  # said by nothing
            continue
        data[field.name] = list(value) if isinstance(value, tuple) else value
    return data


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


def _checked_faces(name: str, values: Iterable[Any]) -> Iterable[int]:
    """Numbers of faces; a long stroke of plain ones is looked at as a whole, in a tenth of the time."""
    plain = values.tolist() if isinstance(values, np.ndarray) and values.dtype.kind in "iu" else list(values)
    if {*map(type, plain)} == {int} and min(plain) >= 0 and max(plain) < 2**31:
        return plain
    return [_face(name, value) for value in plain]


def _check_level(level: Any) -> None:
    if level not in LEVELS:
        raise ValueError(f"level must be one of {', '.join(map(repr, LEVELS))}, got {level!r:.200}")
