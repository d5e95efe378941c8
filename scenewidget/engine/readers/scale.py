"""A scan in metres, whatever unit its file is in."""

from __future__ import annotations

import dataclasses

import numpy as np

from scenewidget.engine.mesh import FloatArray, Mesh
from scenewidget.engine.readers.scan import Notes
from scenewidget.engine.units import FACTORS, METRE, Unit, UnitName, likely_unit, unit_by_size

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


def scale_of(points: FloatArray, units: UnitName | None) -> tuple[float, str]:
    """Factor to metres of the points of a cloud, and a line on the unit where there is something to say.

    Parameters
    ----------
    points : (n_points, 3) float
    units : str, optional
        As of `in_metres`; without faces only the size tells.
    """
    unit = METRE if units not in (None, "auto") else unit_by_size(points)
    across = float(np.subtract(*np.percentile(points, [99, 1], axis=0)).max())
    factor, line = _scaled(unit, across, units)
    return factor, line


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
