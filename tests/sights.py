"""What people with each kind of colour blindness see (Machado, Oliveira and Fernandes, 2009)."""

from __future__ import annotations

import numpy as np

from scenewidget.palette import DEUTERANOPIA, PROTANOPIA, TRITANOPIA, _oklab, adjacent_segments

SIGHTS = {
    "all colours": np.eye(3),
    "protanopia": PROTANOPIA,
    "deuteranopia": DEUTERANOPIA,
    "tritanopia": TRITANOPIA,
}


def linear(colors):
    """Light that a screen gives off, (…, 3), of sRGB bytes."""
    share = np.asarray(colors) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def seen(colors, sight):
    """(…, 3) uint8 sRGB that looks to everybody as ``colors`` look to those with that sight."""
    light = np.clip(linear(colors) @ SIGHTS[sight].T, 0, 1)
    share = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(255 * share).astype(np.uint8)


def neighbour_difference(mesh, labels, colors, sight):
    """Smallest Oklab distance between two segments that touch, in that sight."""
    pairs = adjacent_segments(mesh.faces, labels, mesh.n_vertices)
    lab = _oklab(np.clip(linear(colors) @ SIGHTS[sight].T, 0, 1))
    return np.linalg.norm(lab[pairs[:, 0]] - lab[pairs[:, 1]], axis=1).min()
