"""A scan in metres, whatever unit its file is in."""

from __future__ import annotations

import dataclasses

import numpy as np

from scenewidget.engine.mesh import Mesh
from scenewidget.engine.readers.scan import Notes
from scenewidget.engine.units import FACTORS, METRE, UnitName, likely_unit

__all__ = ["in_metres"]


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
    if units is None or units == "auto":
        unit = likely_unit(mesh)
        name, factor = unit.name, unit.factor
        if unit is not METRE and units is None:
            across = float(np.ptp(mesh.bounds, axis=0).max())
            notes.say(
                f"the scan is {across:.4g} across and looks as if it were in {name}, while lengths are taken "
                f'as metres; units="auto" scales it by {factor:g}',
                warn=True,
            )
            factor = 1.0
        elif unit is not METRE:
            notes.say(f"numbers were taken as {name} and scaled to metres by {factor:g}")
    else:
        factor = FACTORS[units]
        if factor != 1.0:
            notes.say(f"numbers were given in {units} and scaled to metres by {factor:g}")
    report = tuple(dict.fromkeys([*mesh.report, *notes.lines]))
    if factor == 1.0:
        return mesh if report == mesh.report else dataclasses.replace(mesh, report=report)
    return dataclasses.replace(mesh, vertices=mesh.vertices * factor, report=report)
