"""A scan in metres, whatever unit its file is in."""

from __future__ import annotations

import dataclasses

import numpy as np

from scenewidget.engine.mesh import FloatArray, Mesh
from scenewidget.engine.readers.scan import Notes
from scenewidget.engine.units import FACTORS, METRE, UnitName, likely_unit

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


def scale_of(points: FloatArray, units: UnitName | None) -> tuple[float, str]:
    """Factor to metres of the points of a cloud, and a line on the unit where there is something to say.

    Without faces only the size tells: clouds more than 300 or less than 0.02 across are in another unit.

    Parameters
    ----------
    points : (n_points, 3) float
    units : str, optional
        As of `in_metres`.
    """
    if units is not None and units != "auto":
        factor = FACTORS[units]
        return (
            factor,
            f"numbers were given in {units} and scaled to metres by {factor:g}" if factor != 1 else "",
        )
    low, high = np.percentile(points, [1, 99], axis=0)
    across = float((high - low).max())
    if not across > 0 or 0.02 <= across <= 300:
        return 1.0, ""
    fits = [("millimetres", 0.001), ("centimetres", 0.01), ("hundreds of metres", 100.0)]
    name, factor = min(fits, key=lambda fit: abs(np.log(across * fit[1] / 4.5)))
    if units == "auto":
        return factor, f"numbers were taken as {name} and scaled to metres by {factor:g}"
    return 1.0, (
        f"the cloud is {across:.4g} across and looks as if it were in {name}, while lengths are taken as "
        f'metres; units="auto" scales it by {factor:g}'
    )
