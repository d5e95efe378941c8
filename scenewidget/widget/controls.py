"""Sliders for the parameters that one explores, as ipywidgets that can be observed and linked.

Goes in: `Params`. Comes out: new `Params`, whenever a person moves something.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets as widgets

from scenewidget.engine.params import Params

__all__ = ["ParamsControls"]

STYLE = {"description_width": "7rem"}
SLIDER = {"width": "25rem", "max_width": "100%"}


class ParamsControls(widgets.VBox):
    """S, the k-range and the cost exponent.

    Parameters
    ----------
    params : Params
    on_change : callable (Params)
        Called with the new parameters after a person let go of a control.
    on_rerun : callable ()
        Called when "Segment again" is pressed.

    Attributes
    ----------
    n_segments, k_range, cost_exponent : ipywidgets sliders
    tied : Checkbox
        Whether the k-range follows S as 2S to 2.5S.
    rerun : Button
        Shown while the picture isn't what the settings say, after a cancel or an error.
    """

    def __init__(
        self, params: Params, on_change: Callable[[Params], None], on_rerun: Callable[[], None]
    ) -> None:
        self._params = params
        self._on_change = on_change
        self._is_showing = False
        self.n_segments = widgets.IntSlider(
            min=2, max=200, description="Segments S", tooltip="How many segments to aim at",
            continuous_update=False, style=STYLE, layout=SLIDER,
        )  # fmt: skip
        self.k_range = widgets.IntRangeSlider(
            min=2, max=500, description="k-range", tooltip="Least and most clusters of a k-medoids run",
            continuous_update=False, style=STYLE, layout=SLIDER,
        )  # fmt: skip
        self.tied = widgets.Checkbox(
            description="tied to S (2S to 2.5S)", indent=False, layout={"width": "auto"},
            tooltip="Let the k-range follow S",
        )  # fmt: skip
        self.cost_exponent = widgets.FloatSlider(
            min=0.0, max=4.0, step=0.05, readout_format=".2f", description="Cost exponent C",
            tooltip="How strongly creases separate: cost = max(A + B⟨N,N'⟩, 0)^C",
            continuous_update=False, style=STYLE, layout=SLIDER,
        )  # fmt: skip
        self.rerun = widgets.Button(
            description="Segment again", layout={"display": "none", "width": "auto"},
            tooltip="Compute with the settings shown, after a cancel or an error",
        )  # fmt: skip
        for control in (self.n_segments, self.k_range, self.tied, self.cost_exponent):
            control.observe(self._moved, "value")
        self.rerun.on_click(lambda _: on_rerun())
        row = {"flex_flow": "row wrap", "align_items": "center"}
        super().__init__(
            [
                widgets.Box([self.n_segments, self.cost_exponent], layout=row),
                widgets.Box([self.k_range, self.tied, self.rerun], layout=row),
            ]
        )
        self.show(params)

    def show(self, params: Params) -> None:
        """Set all controls to what the parameters say, without reporting a change."""
        self._is_showing = True
        try:
            self._params = params
            s = 50 if params.n_segments == "auto" else params.n_segments
            self.n_segments.max = max(self.n_segments.max, s)
            self.n_segments.value = s
            self.cost_exponent.max = max(self.cost_exponent.max, params.cost_exponent)
            self.cost_exponent.value = params.cost_exponent
            self.tied.value = params.k_range is None
            self._show_k_range(params.k_bounds)
        finally:
            self._is_showing = False

    def offer_rerun(self, is_offered: bool) -> None:
        """Show or hide the button "Segment again"."""
        self.rerun.layout.display = "" if is_offered else "none"

    def _show_k_range(self, bounds: tuple[int, int]) -> None:
        self.k_range.max = max(self.k_range.max, bounds[1])
        self.k_range.min = min(self.k_range.min, bounds[0])
        self.k_range.value = bounds

    def _moved(self, change: dict[str, Any]) -> None:
        if self._is_showing:
            return
        if change["owner"] is self.k_range:
            self._is_showing = True
            self.tied.value = False
            self._is_showing = False
        # only what was moved may change: another field can hold a value that no slider can show
        changes: dict[str, Any] = {}
        if change["owner"] is self.n_segments:
            changes["n_segments"] = self.n_segments.value
        elif change["owner"] is self.cost_exponent:
            changes["cost_exponent"] = self.cost_exponent.value
        else:
            changes["k_range"] = None if self.tied.value else tuple(self.k_range.value)
        params = self._params.replace(**changes)
        self.show(params)
        self._on_change(params)
