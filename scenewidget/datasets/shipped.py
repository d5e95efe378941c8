"""The scan that comes with the package."""

from __future__ import annotations

from importlib import resources

from scenewidget.datasets.packing import unpack
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.segmentation import Segmentation

__all__ = ["ROOM_FILE", "load_room"]

ROOM_FILE = "room.xz"


def load_room() -> tuple[Mesh, Segmentation]:
    """A simulated scan of a furnished living room and its truth, read from the package: no network, under a
    second.

    Made once by ``python -m scenewidget.datasets.make_room``, positions rounded to half a millimetre. What
    the segments of the truth are, `simulate_room` says.

    Returns
    -------
    mesh : Mesh
        Some 250 000 faces with vertex colours, z up, metres, normals into the room.
    truth : Segmentation
        One named segment a thing.

    Examples
    --------
    >>> import scenewidget as sw
    >>> mesh, truth = sw.datasets.load_room()
    >>> truth.n_segments, truth.names[0]
    (31, 'ceiling')
    """
    data = resources.files("scenewidget.datasets").joinpath(ROOM_FILE).read_bytes()
    mesh, labels, names = unpack(data)
    return mesh, Segmentation.from_labels(mesh, labels, names=names)
