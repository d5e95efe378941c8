"""What is to be done with one scan: a `Job`, small and quick to read, since it travels."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from importlib.metadata import version

from scenewidget.engine.params import Params
from scenewidget.engine.units import UnitName

__all__ = ["FORMATS", "Job"]

FORMATS = {  # the files that each writes, the one to ask for first
    "npz": (".npz",),
    "ply": (".ply",),
    "glb": (".glb",),
    "scannet": (".aggregation.json", ".segs.json"),
    "scenenn": (".scenenn.xml", ".scenenn.ply"),  # the PLY is not that of "ply"
    "csv": (".csv",),
    "parquet": (".parquet",),
    "npy": (".npy",),
    "txt": (".txt",),
    "swproj": (".swproj",),
}


@dataclass(frozen=True)
class Job:
    """What is to be done with one scan.

    Attributes
    ----------
    scan : str
        Its name.
    source : str
        Path or URL of its file.
    folder : str
        Path or URL of the folder for its results.
    params : Params
    formats : tuple of str
        Of `FORMATS`.
    units : str, optional
        As of `load_mesh`.
    truth : str
        File of labels to compare with; "" for none.
    tile_faces : int
        Larger scans are segmented tile by tile; 0 for none.
    anew : bool
        Whether to reuse nothing.
    size : int
        Bytes of the scan's file.
    version : str
        Of scenewidget, where the job was made.

    Examples
    --------
    >>> Job("a.ply", "scans/a.ply", "out/a.ply", Params()).formats
    ('npz',)
    """

    scan: str
    source: str
    folder: str
    params: Params
    formats: tuple[str, ...] = ("npz",)
    units: UnitName | None = None
    truth: str = ""
    tile_faces: int = 0
    anew: bool = False
    size: int = 0
    version: str = dataclasses.field(default_factory=lambda: version("scenewidget"))
