"""Items made by hand: a face each, or patches of floors that are as even as wanted."""

import numpy as np
import shapes

from scenewidget.engine.items import patch_items
from scenewidget.engine.mesh import Mesh


def faces_as_items(mesh):
    """One item a face."""
    return patch_items(mesh, np.arange(mesh.n_faces))


def scene(*parts):
    """Items a face of parts joined in one mesh, and the part of each item."""
    mesh = shapes.joined(*parts)
    return faces_as_items(mesh), np.repeat(np.arange(len(parts)), [p.n_faces for p in parts]).astype(np.int32)


def sheet(origin, size, n=6):
    """A level rectangle."""
    square = shapes.grid_square(n)
    return Mesh(square.vertices * [*size, 1] + np.array(origin), square.faces)


def floor(height, n=100, noise=0.001):
    """Patches of a floor 3 m wide: its height at (x, y), and 1 mm of noise."""
    square = shapes.grid_square(n)
    x, y = 3 * square.vertices[:, 0], 3 * square.vertices[:, 1]
    z = height(x, y) + np.random.default_rng(0).normal(scale=noise, size=len(x))
    mesh = Mesh(np.stack([x, y, z], axis=1), square.faces)
    cell = np.floor(mesh.face_centroids[:, :2] / 0.15).astype(np.int64)
    _, patch = np.unique(cell, axis=0, return_inverse=True)
    return patch_items(mesh, patch.ravel())


def carpet(x, y):
    """Whether a place on the floor lies on a carpet in its middle."""
    return (x > 0.6) & (x < 1.8) & (y > 0.9) & (y < 2.1)


def share(items, labels, wanted):
    """Of the area of the label that is found most in a place: how much lies in it, how much of it that is."""
    x, y, _ = items.centroids.T
    inside = wanted(x, y)
    label = np.bincount(labels[inside], items.areas[inside]).argmax()
    both = items.areas[inside & (labels == label)].sum()
    return both / items.areas[labels == label].sum(), both / items.areas[inside].sum()
