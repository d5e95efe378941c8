"""Colours of segments on the screen, in figures and in exported files: neighbours look different.

Goes in: a label per face, what touches what, the colours before. Comes out: a row of a fixed palette per
segment. Differences are measured in Oklab (Ottosson, 2020), and as people with protanopia and deuteranopia
see them (Machado, Oliveira and Fernandes, 2009, IEEE TVCG 15(6)), whichever is smallest.
"""

from __future__ import annotations

import weakref
from functools import cache

import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import FloatArray, IntArray, Mesh
from scenewidget.engine.readers.colors import to_srgb
from scenewidget.engine.segmentation import Segmentation

__all__ = [
    "adjacent_segments",
    "are_distinct",
    "choose_colors",
    "colormap_table",
    "inherited_colors",
    "keep_colors",
    "label_rows",
    "palette",
    "segment_colors",
]

UNLABELED = (179, 179, 181)  # sRGB, as on a light screen

# lightness and chroma of the rings of the palette, calm ones first; hues are staggered from ring to ring
RINGS = ((0.82, 0.075), (0.74, 0.12), (0.66, 0.135), (0.89, 0.09), (0.58, 0.13))
N_HUES = 13
ENOUGH = 0.12  # Oklab distance beyond which more makes nothing clearer

PROTANOPIA = np.array(
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
)
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)
TRITANOPIA = np.array(
    [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
)
RARE = 1.5  # so much less difference will do for tritanopia, which one person in 30,000 has


@cache
def palette() -> npt.NDArray[np.uint8]:
    """(n_colors, 3) uint8 sRGB."""
    return to_srgb(_linear_palette())


# what each segmentation is shown in, where somebody looks at it; -1 = not shown
_rows_shown: weakref.WeakKeyDictionary[Segmentation, IntArray] = weakref.WeakKeyDictionary()


def keep_colors(segmentation: Segmentation, rows: IntArray) -> None:
    """Remember in which colours a view shows a segmentation, so that its files have the same.

    Parameters
    ----------
    segmentation : Segmentation
    rows : (n_segments,) int
        Rows of the palette; -1 where it isn't known.

    Examples
    --------
    >>> import numpy as np
    >>> import scenewidget as sw
    >>> mesh = sw.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> seg = sw.Segmentation.from_labels(mesh, [0])
    >>> keep_colors(seg, np.array([7]))
    >>> bool((segment_colors(seg)[0] == palette()[7]).all())
    True
    """
    _rows_shown[segmentation] = np.array(rows)


def segment_colors(segmentation: Segmentation) -> npt.NDArray[np.uint8]:
    """(n_segments + 1, 3) sRGB of each segment, and of what is unlabeled in the last row.

    The colours that it is shown in, or those that a new view would show it in.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh = sw.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> segment_colors(sw.Segmentation.from_labels(mesh, [0, -1])).tolist()
    [[204, 218, 254], [179, 179, 181]]
    """
    known = _rows_shown.get(segmentation)
    rows = label_rows(segmentation.mesh, segmentation.labels, known)
    return np.concatenate([palette()[rows], np.array([UNLABELED], np.uint8)])


def label_rows(mesh: Mesh, labels: IntArray, known: IntArray | None = None) -> IntArray:
    """A row of the palette for each label, (n_labels,).

    Parameters
    ----------
    mesh : Mesh
    labels : (n_faces,) int
        From 0 without gaps; -1 = none.
    known : (n_labels,) int, optional
        Rows that are settled; -1 = choose.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets import analytic
    >>> int(label_rows(analytic.square(2), np.repeat([0, 1], 4), known=np.array([3, -1]))[0])
    3
    """
    n_labels = int(labels.max(initial=-1)) + 1
    shares = np.bincount(labels[labels >= 0], minlength=n_labels) / len(labels)
    return choose_colors(n_labels, adjacent_segments(mesh.faces, labels, mesh.n_vertices), shares, known)


def colormap_table(name: str) -> npt.NDArray[np.uint8]:
    """(256, 3) sRGB of a matplotlib colour map, from its low end to its high one.

    Raises
    ------
    ValueError
        There is no such colour map.

    Examples
    --------
    >>> colormap_table("viridis")[[0, 255]].tolist()
    [[68, 1, 84], [253, 231, 37]]
    """
    import matplotlib  # 0.2 s: only when numbers are coloured

    if name not in matplotlib.colormaps:
        raise ValueError(
            f"colormap must be the name of a matplotlib colour map such as 'viridis', got {name!r}"
        )
    table: npt.NDArray[np.uint8] = np.round(
        255 * matplotlib.colormaps[name](np.linspace(0, 1, 256))[:, :3]
    ).astype(np.uint8)
    return table


def choose_colors(
    n_segments: int, neighbours: IntArray, shares: FloatArray, known: IntArray | None = None
) -> IntArray:
    """A row of the palette for each segment, (n_segments,).

    Goes through the segments from large to small and takes the colour that differs most from those of the
    neighbours, then of all others, and is used least; large segments prefer light and pale colours.

    Parameters
    ----------
    neighbours : (n_pairs, 2) int
        Segments that touch, each pair once or twice.
    shares : (n_segments,) float
        Part of the faces in each segment, 0 to 1.
    known : (n_segments,) int, optional
        Colours that are settled; -1 = choose.

    Examples
    --------
    >>> import numpy as np
    >>> rows = choose_colors(3, np.array([[0, 1], [1, 2]]), np.array([0.5, 0.3, 0.2]))
    >>> len(set(rows.tolist()))
    3
    """
    difference, loudness = _differences(), _loudness()
    chosen = np.full(n_segments, -1) if known is None else known.copy()
    uses = np.bincount(chosen[chosen >= 0], minlength=len(loudness)).astype(float)
    start, others = _neighbour_lists(neighbours, n_segments)
    for segment in np.argsort(-shares, kind="stable"):
        if chosen[segment] >= 0:
            continue
        around = chosen[others[start[segment] : start[segment + 1]]]
        around = around[around >= 0]
        contrast = difference[around].min(axis=0) if len(around) else np.full(len(loudness), difference.max())
        elsewhere = difference[chosen[chosen >= 0]].min(axis=0, initial=ENOUGH)
        clarity = np.minimum(contrast, ENOUGH) + 0.5 * elsewhere - 0.05 * uses
        color = int(np.argmax(clarity - min(1.0, 4.0 * shares[segment]) * loudness))
        chosen[segment] = color
        uses[color] += 1
    return chosen


def inherited_colors(
    labels: IntArray,
    n_segments: int,
    before: IntArray,
    colors_before: IntArray,
    sizes: FloatArray | None = None,
) -> IntArray:
    """Colours that segments keep from an earlier labeling, (n_segments,); -1 for new ones.

    Largest overlap first, each old colour goes to one segment at most, so a merged segment keeps the colour
    of its larger part and the larger part of a split one keeps the colour of the whole. ``sizes`` are how
    many faces each entry stands for, 1 by default.

    Examples
    --------
    >>> import numpy as np
    >>> before, now = np.array([0, 0, 0, 1]), np.array([0, 0, 2, 1])  # 0 was split
    >>> inherited_colors(now, 3, before, np.array([30, 31]))
    array([30, 31, -1])
    """
    colors = np.full(n_segments, -1)
    is_both = (labels >= 0) & (before >= 0)
    n_before = len(colors_before)
    codes = labels[is_both].astype(np.int64) * n_before + before[is_both]
    pairs, index = np.unique(codes, return_inverse=True)
    overlap = np.bincount(index, None if sizes is None else sizes[is_both], len(pairs))
    is_taken = np.zeros(n_before, np.bool_)
    for pair in pairs[np.argsort(-overlap, kind="stable")]:
        segment, old = divmod(int(pair), n_before)
        if colors[segment] < 0 and not is_taken[old]:
            colors[segment] = colors_before[old]
            is_taken[old] = True
    return colors


def are_distinct(color: int, others: IntArray) -> bool:
    """Whether a row of the palette can be told from some others, by everybody.

    Examples
    --------
    >>> import numpy as np
    >>> are_distinct(0, np.array([0]))
    False
    """
    return bool((_differences()[color, others] >= ENOUGH / 2).all())


def adjacent_segments(faces: IntArray, labels: IntArray, n_vertices: int) -> IntArray:
    """Pairs of segments that share a vertex, (n_pairs, 2); where many meet, not every pair of them.

    Examples
    --------
    >>> import numpy as np
    >>> adjacent_segments(np.array([[0, 1, 2], [0, 2, 3]]), np.array([0, 1]), 4).tolist()
    [[0, 1], [1, 0]]
    """
    at_vertex = np.full(n_vertices, -1)
    for corner in range(3):
        at_vertex[faces[:, corner]] = labels
    n_segments = int(labels.max(initial=0)) + 1
    codes = []
    for corner in range(3):
        other = at_vertex[faces[:, corner]]
        is_border = (other != labels) & (other >= 0) & (labels >= 0)
        codes.append(other[is_border].astype(np.int64) * n_segments + labels[is_border])
    return np.stack(np.divmod(np.unique(np.concatenate(codes)), n_segments), axis=1)


def _neighbour_lists(pairs: IntArray, n_segments: int) -> tuple[IntArray, IntArray]:
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    return np.searchsorted(both[:, 0], np.arange(n_segments + 1)), both[:, 1]


@cache
def _differences() -> FloatArray:
    """(n_colors, n_colors) smallest Oklab distance over normal and colour-blind sight."""
    linear = _linear_palette()
    common = (np.eye(3), PROTANOPIA, DEUTERANOPIA)
    labs = [_oklab(np.clip(linear @ sight.T, 0, 1)) for sight in common]
    labs.append(RARE * _oklab(np.clip(linear @ TRITANOPIA.T, 0, 1)))
    differences = np.min([np.linalg.norm(lab[:, None] - lab, axis=2) for lab in labs], axis=0)
    rounded: FloatArray = np.round(differences, 6)  # so that no processor's last digit decides between two
    return rounded


@cache
def _loudness() -> FloatArray:
    """(n_colors,) how dark and how saturated."""
    lab = _oklab(_linear_palette())
    loudness: FloatArray = np.round(np.linalg.norm(lab[:, 1:], axis=1) + 0.5 * (0.9 - lab[:, 0]), 6)
    return loudness


@cache
def _linear_palette() -> FloatArray:
    colors = []
    for ring, (lightness, chroma) in enumerate(RINGS):
        hue = 2 * np.pi * (np.arange(N_HUES) + 0.5 * ring + 0.2) / N_HUES
        colors += [_inside_gamut(lightness, chroma, angle) for angle in hue]
    return np.array(colors)


def _inside_gamut(lightness: float, chroma: float, hue: float) -> FloatArray:
    """Linear sRGB of an Oklch colour, with less chroma if the screen can't show it."""
    while True:
        linear = _linear_srgb(np.array([lightness, chroma * np.cos(hue), chroma * np.sin(hue)]))
        if (linear > -1e-4).all() and (linear < 1 + 1e-4).all():
            return np.clip(linear, 0, 1)
        chroma *= 0.95


def _linear_srgb(lab: FloatArray) -> FloatArray:
    roots = lab @ np.linalg.inv(_LMS_TO_LAB).T
    linear: FloatArray = roots**3 @ np.linalg.inv(_SRGB_TO_LMS).T
    return linear


def _oklab(linear: FloatArray) -> FloatArray:
    lab: FloatArray = np.cbrt(linear @ _SRGB_TO_LMS.T) @ _LMS_TO_LAB.T
    return lab


_SRGB_TO_LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_LMS_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
