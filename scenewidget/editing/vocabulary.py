"""Names that people give to what stands in rooms: the 40 classes of NYU and the 20 of ScanNet.

Silberman, Hoiem, Kohli and Fergus (2012), ECCV, as mapped to 40 classes by Gupta, Arbelaez and Malik (2013),
CVPR; Dai et al. (2017), *ScanNet*, CVPR.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from scenewidget.editing.edits import checked_name

__all__ = [
    "NYU40",
    "SCANNET20",
    "checked_vocabulary",
    "chosen_vocabulary",
    "in_vocabulary",
    "nyu_class",
    "nyu_id",
    "quick_names",
]

NYU40 = (  # in the order of their ids, from 1
    "wall", "floor", "cabinet", "bed", "chair", "sofa", "table", "door", "window", "bookshelf",
    "picture", "counter", "blinds", "desk", "shelves", "curtain", "dresser", "pillow", "mirror", "floor mat",
    "clothes", "ceiling", "books", "refrigerator", "television", "paper", "towel", "shower curtain", "box",
    "whiteboard", "person", "nightstand", "toilet", "sink", "lamp", "bathtub", "bag", "otherstructure",
    "otherfurniture", "otherprop",
)  # fmt: skip

SCANNET20 = (  # the subset that ScanNet's benchmark counts, in the order of their NYU40 ids
    "wall", "floor", "cabinet", "bed", "chair", "sofa", "table", "door", "window", "bookshelf",
    "picture", "counter", "desk", "curtain", "refrigerator", "shower curtain", "toilet", "sink", "bathtub",
    "otherfurniture",
)  # fmt: skip

_SPELLINGS = {  # of SceneNN and ScanNet's raw names, without blanks
    "fridge": "refrigerator", "refridgerator": "refrigerator", "tv": "television", "monitor": "television",
    "floormat": "floor mat", "showercurtain": "shower curtain", "nightstand": "nightstand", "couch": "sofa",
    "bathtub": "bathtub", "whiteboard": "whiteboard", "bookshelf": "bookshelf", "prop": "otherprop",
    "furniture": "otherfurniture", "structure": "otherstructure", "bookcase": "bookshelf",
}  # fmt: skip
_CLASSES = {name.replace(" ", ""): name for name in NYU40} | _SPELLINGS


def nyu_class(name: str) -> str:
    """The class of NYU40 that a name stands for, "" if none: "chair 2" and "Chair" are chairs.

    >>> nyu_class("Night stand 1")
    'nightstand'
    """
    return _CLASSES.get(name.lower().rstrip("0123456789 .#_-").replace(" ", "").replace("_", ""), "")


def nyu_id(name: str) -> int:
    """Id of the class that a name stands for, 1 to 40; 0 if there is none.

    Examples
    --------
    >>> nyu_id("chair 2"), nyu_id("spaceship")
    (5, 0)
    """
    found = nyu_class(name)
    return NYU40.index(found) + 1 if found else 0


def checked_vocabulary(names: Iterable[str]) -> tuple[str, ...]:
    """Names to choose from, in their order, each once.

    Raises
    ------
    TypeError, ValueError
        Not a sequence of names, or one that no segment can have.

    Examples
    --------
    >>> checked_vocabulary(["desk", " chair", "desk"])
    ('desk', 'chair')
    """
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise TypeError(f"vocabulary must be a sequence of names, got {names!r:.200}")
    try:
        checked = tuple(dict.fromkeys(checked_name(name) for name in names))
    except (TypeError, ValueError) as error:
        raise type(error)(f"vocabulary holds a name that no segment can have: {error}") from None
    if "" in checked:
        raise ValueError("vocabulary holds an empty name")
    if len(checked) > 10_000:
        raise ValueError(f"vocabulary has {len(checked)} names; at most 10000 can be kept")
    return checked


def chosen_vocabulary(choice: str | Iterable[str]) -> tuple[str, ...]:
    """Names to choose from: "nyu40", "scannet20", or a list of one's own.

    Raises
    ------
    TypeError, ValueError
        Another word, not a sequence of names, or one that no segment can have.

    Examples
    --------
    >>> len(chosen_vocabulary("scannet20"))
    20
    >>> chosen_vocabulary(["desk", "chair"])
    ('desk', 'chair')
    """
    if not isinstance(choice, str):
        return checked_vocabulary(choice)
    built_in = {"nyu40": NYU40, "scannet20": SCANNET20}
    if choice.lower() not in built_in:
        raise ValueError(f"vocabulary must be 'nyu40', 'scannet20' or a list of names, got {choice!r:.200}")
    return built_in[choice.lower()]


def in_vocabulary(name: str, vocabulary: Iterable[str]) -> str:
    """The word of a vocabulary for what a name says, "" if it has none.

    The same word in whatever letters comes first, then the first that stands for the same class of NYU40.

    Examples
    --------
    >>> in_vocabulary("table", ["Desk", "Table"]), in_vocabulary("ceiling", SCANNET20)
    ('Table', '')
    >>> in_vocabulary("sofa", ["couch", "lamp"])
    'couch'
    """
    words = list(vocabulary)
    meant = nyu_class(name)
    same = [word for word in words if word.lower() == name.lower()]
    alike = [word for word in words if meant and nyu_class(word) == meant]
    return next(iter(same + alike), "")


def quick_names(vocabulary: Sequence[str], used: Iterable[str], n: int = 7) -> tuple[str, ...]:
    """The names that have keys of their own.

    The first of the vocabulary at the beginning. A name that is used and has no key yet takes the key of the
    one that was used longest ago, so that the others stay where the fingers know them.

    Parameters
    ----------
    used : iterable of str
        Names in the order in which they were given to segments.

    Examples
    --------
    >>> quick_names(["wall", "floor", "chair"], used=["lamp"], n=2)
    ('wall', 'lamp')
    """
    slots = list(vocabulary[:n])
    last = [-1 - i for i in range(len(slots))]  # of those never used, the last ones go first
    for when, name in enumerate(used):
        if name in slots:
            last[slots.index(name)] = when
        elif len(slots) < n:
            slots.append(name)
            last.append(when)
        elif slots:
            oldest = last.index(min(last))
            slots[oldest], last[oldest] = name, when
    return tuple(slots)
