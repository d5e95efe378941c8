"""A scan in metres, whatever unit its file is in."""

from __future__ import annotations

import dataclasses

import numpy as np

from scenewidget.engine.clouds import PointCloud
from scenewidget.engine.mesh import Mesh
from scenewidget.engine.readers.scan import Notes
from scenewidget.engine.units import FACTORS, METRE, Unit, UnitName, likely_units

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
    found = (METRE,) if units not in (None, "auto") else likely_units(mesh)
    factor, line = _scaled(found, float(np.ptp(mesh.bounds, axis=0).max()), units)
    if line:
        notes.say(line, warn=is_worth_a_warning(found, units))
    report = tuple(dict.fromkeys([*mesh.report, *notes.lines]))
    if factor == 1.0:
        return mesh if report == mesh.report else dataclasses.replace(mesh, report=report)
    return dataclasses.replace(mesh, vertices=mesh.vertices * factor, report=report)


def scale_of(cloud: PointCloud, units: UnitName | None) -> tuple[float, str, bool]:
    """Factor to metres of a cloud, a line on the unit where there is something to say, and if to warn.

    Parameters
    ----------
    cloud : PointCloud
        In the unit of its file.
    units : str, optional
        As of `in_metres`.
    """
    found = (METRE,) if units not in (None, "auto") else likely_units(cloud)
    factor, line = _scaled(found, float(np.ptp(cloud.bounds, axis=0).max()), units)
    return factor, line, is_worth_a_warning(found, units)


def is_worth_a_warning(found: tuple[Unit, ...], units: UnitName | None) -> bool:
    """Whether lengths are left in another unit than the metre, or scaled by a guess that may be wrong.

    Parameters
    ----------
    found : tuple of Unit
        Of `likely_units`.
    units : str, optional
        As of `in_metres`.
    """
    return found[0] is not METRE and (units is None or len(found) > 1)


def _scaled(found: tuple[Unit, ...], across: float, units: UnitName | None) -> tuple[float, str]:
    """By how much to scale what is ``across`` in its numbers, and what to say of it."""
    if units is not None and units != "auto":
        factor = FACTORS[units]
        line = f"numbers were given in {units} and scaled to metres by {factor:g}"
        return factor, line if factor != 1.0 else ""
    unit, *others = found
    named = {factor: name for name, factor in FACTORS.items()}
    also = [
        f'{other.name} fit nearly as well: units="{named[other.factor]}" takes them so'
        for other in others
        if other.factor in named
    ]
    if unit is METRE:
        return 1.0, "; ".join(
            [f"the numbers, {across:.4g} across, were taken as metres", *also]
        ) if also else ""
    if units == "auto":
        line = f"numbers were taken as {unit.name} and scaled to metres by {unit.factor:g}"
        return unit.factor, "; ".join([line, *also])
    line = (
        f"the scan is {across:.4g} across and looks as if it were in {unit.name}, while lengths are taken "
        f'as metres; units="auto" scales it by {unit.factor:g}'
    )
    return 1.0, "; ".join([line, *also])
