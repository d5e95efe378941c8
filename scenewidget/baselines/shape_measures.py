"""How much a piece of a scan looks like an object, from its shape alone.

Go in: pieces of a mesh. Come out: the five intrinsic measures of Karpathy, Miller and Fei-Fei (2013),
*Object discovery in 3D scenes via shape analysis*, ICRA, and their mean after normalisation. The paper
describes them in a sentence each; each function here says how it reads that sentence. All are signed so
that more means more of an object. Their sixth, recurrence, compares with pieces from elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.spatial import ConvexHull, QhullError, cKDTree

from scenewidget.engine.mesh import BoolArray, FloatArray, IntArray

__all__ = [
    "compactness",
    "global_convexity",
    "local_convexity",
    "mean_objectness",
    "recurrence",
    "smallest_sphere_radius",
    "smoothness",
    "symmetry",
    "tangent_neighbours",
]

N_DIRECTIONS = 8  # slots of the angles in the tangent plane, as in the authors' program
NORMAL_WEIGHT = 0.3  # of a turned normal against a displacement by the piece's extent, likewise


def mean_objectness(measures: FloatArray) -> FloatArray:
    """Mean of the measures, each brought to mean 0 and standard deviation 1 over the pieces.

    Parameters
    ----------
    measures : (n_pieces, n_measures) float64

    Returns
    -------
    objectness : (n_pieces,) float64
        A measure that is the same for all pieces counts nothing.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.baselines.shape_measures import mean_objectness
    >>> mean_objectness(np.array([[1.0, 10.0], [3.0, 30.0]])).tolist()  # two pieces, two measures
    [-1.0, 1.0]
    """
    spread = measures.std(axis=0)
    centered = measures - measures.mean(axis=0)
    standard = np.divide(centered, spread, out=np.zeros_like(measures), where=spread > 1e-12)
    mean: FloatArray = standard.mean(axis=1)
    return mean


def compactness(area: float, points: FloatArray) -> float:
    """Area of the piece over the area of its smallest bounding sphere.

    Parameters
    ----------
    area : float
        Square metres.
    points : (n_points, 3) float64
        Metres; the sphere goes around these.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.baselines.shape_measures import compactness
    >>> from scenewidget.datasets.analytic import sphere
    >>> round(compactness(4 * np.pi, sphere(3).vertices), 2)  # a ball: its sphere is its own
    1.0
    """
    radius = smallest_sphere_radius(points)
    return area / (4.0 * np.pi * radius**2) if radius > 0 else 0.0


def smallest_sphere_radius(points: FloatArray, n_steps: int = 200) -> float:
    """Radius of the smallest ball around points, too large by less than a per cent.

    Steps towards the farthest point, each shorter than the last: Bădoiu and Clarkson (2003), *Smaller
    core-sets for balls*, SODA.

    Examples
    --------
    >>> from scenewidget.baselines.shape_measures import smallest_sphere_radius
    >>> from scenewidget.datasets.analytic import sphere
    >>> round(smallest_sphere_radius(sphere(2, radius=2.0).vertices), 2)
    2.0
    """
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    best = np.inf
    for step in range(2, n_steps + 2):
        squared = ((points - center) ** 2).sum(axis=1)
        farthest = int(squared.argmax())
        best = min(best, float(squared[farthest]))
        center = center + (points[farthest] - center) / step
    return float(np.sqrt(best))


def symmetry(points: FloatArray, normals: FloatArray) -> float:
    """How well a piece covers its mirror images along its principal axes.

    Reading: for each axis, the mean over the mirrored points of the distance to the nearest point,
    divided by the extent along the axis, plus .3 (1 − the dot product of the two normals); the mean over
    the axes, weighted by the extents, with a minus sign. Both directions of the overlap are equal,
    because a mirror image mirrored is the original.

    Parameters
    ----------
    points, normals : (n_points, 3) float64
        In the principal frame: centered, an axis a column.

    Returns
    -------
    symmetry : float
        At most 0.

    Examples
    --------
    >>> from scenewidget.baselines.shape_measures import symmetry
    >>> from scenewidget.datasets.analytic import sphere
    >>> ball = sphere(2)
    >>> abs(round(float(symmetry(ball.vertices, ball.vertices)), 2))
    0.0
    """
    extents = np.ptp(points, axis=0)
    total = extents.sum()
    if total == 0:
        return 0.0
    tree = cKDTree(points)
    loss = 0.0
    for axis in range(3):
        if extents[axis] <= 1e-9 * total:  # flat: its own mirror image
            continue
        mirror = np.ones(3)
        mirror[axis] = -1.0
        distance, nearest = tree.query(points * mirror)
        turned = 1.0 - np.einsum("ij,ij->i", normals * mirror, normals[nearest])
        loss += extents[axis] / total * float((distance / extents[axis] + NORMAL_WEIGHT * turned).mean())
    return -loss


def global_convexity(points: FloatArray) -> float:
    """Minus the mean distance of the points from their convex hull, metres.

    Reading: a point inside is as far as the nearest facet; not divided by the size of the piece.

    Returns
    -------
    convexity : float
        At most 0; 0 for a convex or a flat piece.

    Examples
    --------
    >>> from scenewidget.baselines.shape_measures import global_convexity
    >>> from scenewidget.datasets.analytic import sphere
    >>> abs(round(float(global_convexity(sphere(2).vertices)), 6))
    0.0
    """
    try:
        facets = ConvexHull(points).equations
    except (QhullError, ValueError):  # too few points, or all in one plane
        return 0.0
    depth = -(points @ facets[:, :3].T + facets[:, 3])
    return -float(np.maximum(depth.min(axis=1), 0.0).mean())


def recurrence(points: FloatArray, others: Sequence[FloatArray], n_nearest: int = 10) -> float:
    """How much a piece is like others: minus the mean distance to the most similar ones, metres.

    Reading: two pieces lie in their principal frames, the second also turned by half a turn about each
    axis; their distance is the mean from each point of one to the nearest of the other, the mean of both
    ways, in the turn where it is least.

    Parameters
    ----------
    points : (n_points, 3) float64
        In the principal frame: centered, an axis a column.
    others : sequence of (n, 3) float64
        Likewise.
    n_nearest : int
        Over how many of the most similar ones the mean is; ten in the paper.

    Returns
    -------
    recurrence : float
        At most 0, which is that of a piece of which there are so many copies; nan without others.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.baselines.shape_measures import recurrence
    >>> stick = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    >>> recurrence(stick, [2 * stick])
    -1.0
    """
    if not others:
        return float("nan")
    tree = cKDTree(points)
    turns = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    found = []
    for other in others:
        there = [tree.query(other * turn)[0].mean() for turn in turns]
        back = [cKDTree(other * turn).query(points)[0].mean() for turn in turns]
        found.append(0.5 * float(np.min(np.add(there, back))))
    return -float(np.mean(np.sort(found)[:n_nearest]))


def local_convexity(labels: IntArray, n_pieces: int, pairs: IntArray, is_convex: BoolArray) -> FloatArray:
    """(n_pieces,) share of the edges inside each piece that are convex; 0 without edges.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.baselines.shape_measures import local_convexity
    >>> pairs, is_convex = np.array([[0, 1], [1, 2]]), np.array([True, True])
    >>> local_convexity(np.array([0, 0, 1]), 2, pairs, is_convex).tolist()  # the second piece has no edge
    [1.0, 0.0]
    """
    piece = labels[pairs[:, 0]]
    inside = (piece == labels[pairs[:, 1]]) & (piece >= 0)
    edges = np.bincount(piece[inside], minlength=n_pieces)
    convex = np.bincount(piece[inside & is_convex], minlength=n_pieces)
    return np.divide(convex, edges, out=np.zeros(n_pieces), where=edges > 0)


def tangent_neighbours(
    positions: FloatArray, normals: FloatArray, pairs: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Vertices up to two edges apart and the slot of the angle under which the first sees the second.

    Returns
    -------
    first, second : (n_neighbours,) int32
        Both orders of each pair.
    slot : (n_neighbours,) int8
        Angle of the step, projected into the tangent plane at the first, in eighths of a turn.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.baselines.shape_measures import tangent_neighbours
    >>> positions = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    >>> normals, pairs = np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([[0, 1], [1, 2]])
    >>> first, second, slot = tangent_neighbours(positions, normals, pairs)
    >>> sorted(zip(first.tolist(), second.tolist()))
    [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]
    """
    n = len(positions)
    ones = np.ones(len(pairs), dtype=np.int32)
    step = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr()
    step = csr_array(step + step.T)
    reach = (step @ step + step).tocoo()
    first, second = reach.row, reach.col
    apart = first != second
    first, second = first[apart].astype(np.int32), second[apart].astype(np.int32)
    # any tangent will do: the one farthest from the normal's largest component is never parallel to it
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    u = np.cross(normals, helper)
    v = np.cross(normals, u)  # |u| = |v| as the normal is a unit: the angle is right without scaling
    offset = positions[second] - positions[first]
    angle = np.arctan2(np.einsum("ij,ij->i", offset, v[first]), np.einsum("ij,ij->i", offset, u[first]))
    slot = np.floor((angle + np.pi) / (2 * np.pi) * N_DIRECTIONS).astype(np.int8) % N_DIRECTIONS
    return first, second, slot


def smoothness(
    labels: IntArray, n_pieces: int, neighbours: tuple[IntArray, IntArray, IntArray]
) -> FloatArray:
    """(n_pieces,) mean entropy of the directions in which a vertex sees its piece around it, nats.

    Reading: neighbours are vertices up to two edges apart (the authors' program took those within 1 cm,
    about as many in their scans), directions fall in eight slots that each start at 1. Thin and ragged
    pieces see little around them and score low; a vertex that sees nothing scores log 8 by this rule,
    the most, so pieces of single vertices are not to be asked.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.baselines.shape_measures import smoothness, tangent_neighbours
    >>> positions = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    >>> normals, pairs = np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([[0, 1], [1, 2]])
    >>> smoothness(np.zeros(3, int), 1, tangent_neighbours(positions, normals, pairs)).shape
    (1,)
    """
    first, second, slot = neighbours
    same = labels[first] == labels[second]
    n = len(labels)
    key = first[same].astype(np.int64) * N_DIRECTIONS + slot[same]
    counts = 1.0 + np.bincount(key, minlength=n * N_DIRECTIONS).reshape(n, N_DIRECTIONS)
    total = counts.sum(axis=1)
    entropy = np.log(total) - (counts * np.log(counts)).sum(axis=1) / total
    inside = labels >= 0
    members = np.bincount(labels[inside], minlength=n_pieces)
    summed = np.bincount(labels[inside], entropy[inside], n_pieces)
    return np.divide(summed, members, out=np.zeros(n_pieces), where=members > 0)
