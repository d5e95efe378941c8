"""A scan in metres, whatever unit its file is in."""

from __future__ import annotations

import dataclasses

import numpy as np

from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.readers.scan import Notes
from scenewidget.engine.units import FACTORS, METRE, Unit, UnitName, likely_unit

__all__ = ["in_metres", "scale_of"]


def in_metres(mesh: Mesh, units: UnitName | None, notes: Notes) -> Mesh:
    """The mesh scaled to metres, its report with a line on the unit.

    Parameters
    ----------
    mesh : Mesh
    units : str, optional
        What its numbers are; "auto" for what fits best; None leaves them and says what fits better.
    notes : Notes
        Told about the unit.
    """
    unit = METRE if units not in (None, "auto") else likely_unit(mesh)
    factor, line = _scaled(unit, float(np.ptp(mesh.bounds, axis=0).max()), units)
    if line:
        notes.say(line, warn=units is None)
    report = tuple(dict.fromkeys([*mesh.report, *notes.lines]))
    if factor == 1.0:
        return mesh if report == mesh.report else dataclasses.replace(mesh, report=report)
    return dataclasses.replace(mesh, vertices=mesh.vertices * factor, report=report)


def scale_of(cloud: PointCloud, units: UnitName | None) -> tuple[float, str]:
    """Factor to metres of a cloud, and a line on the unit where there is something to say.

    Parameters
    ----------
    cloud : PointCloud
        In the unit of its file.
    units : str, optional
        As of `in_metres`.
    """
    unit = METRE if units not in (None, "auto") else likely_unit(cloud)
    return _scaled(unit, float(np.ptp(cloud.bounds, axis=0).max()), units)


def _scaled(unit: Unit, across: float, units: UnitName | None) -> tuple[float, str]:
    """By how much to scale what is ``across`` in its numbers, and what to say of it."""
    if units is not None and units != "auto":
        factor = FACTORS[units]
        line = f"numbers were given in {units} and scaled to metres by {factor:g}"
        return factor, line if factor != 1.0 else ""
    if unit is METRE:
        return 1.0, ""
    if units == "auto":
        return unit.factor, f"numbers were taken as {unit.name} and scaled to metres by {unit.factor:g}"
    return 1.0, (
        f"the scan is {across:.4g} across and looks as if it were in {unit.name}, while lengths are taken "
        f'as metres; units="auto" scales it by {unit.factor:g}'
    )
